"""Commands for instructors and developers.

Their subjects are simulated logs, the coverage of intervals, the speed, and the schemas
of the output.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gyrodata.base.disk import telling, write_folder
from gyrodata.cli.options import (
    ConfigOption,
    FormatOption,
    MappingOption,
    SettingsOption,
    list_option,
    quantity_option,
    read,
)
from gyrodata.cli.terminal import (
    named_logs,
    progress_bar,
    tell,
    write_answer,
    write_out,
)

if TYPE_CHECKING:
    from gyrodata.trials.benchmark.labs import LabScene


def simulate(
    inertia: Annotated[
        Any,
        quantity_option(
            "--inertia", "inertia", "above zero", words="I_zz about the rod."
        ),
    ] = "4.44e-3 kg m^2",
    weights: Annotated[
        Any,
        list_option("--weights", "mass", words="Masses of the weights; 0g: no weight."),
    ] = "20g,40g,60g",
    position: Annotated[
        Any,
        list_option(
            "--position",
            "length",
            words="Positions of the weight; negative: the other side.",
        ),
    ] = "15cm",
    spins: Annotated[
        Any,
        list_option(
            "--spins",
            "rate",
            "other than zero",
            words="Spins at the start of each run; negative: reversed.",
        ),
    ] = "200,400,600rpm",
    turns: Annotated[
        Any,
        list_option(
            "--turns",
            "number",
            "above zero",
            "NUMBERS",
            words="Number of timed turns, such as 1/3 or 1/3,1.",
        ),
    ] = "1",
    pitch: Annotated[
        Any,
        list_option(
            "--pitch", "angle", words="Angles of the rod above the horizontal."
        ),
    ] = "0deg",
    imbalance: Annotated[
        Any,
        quantity_option(
            "--imbalance",
            "torque",
            words='Residual torque M0, such as "0.3 mN m". Default: none, or drawn from '
            "u_imbalance of a noise FILE.",
        ),
    ] = None,
    spin_decay: Annotated[
        Any,
        quantity_option(
            "--spin-decay",
            "time",
            "above zero",
            words='Time constant of the decay of the spin, "600 s"; the log then has '
            "the spin at start and end.",
        ),
    ] = None,
    noise: Annotated[
        str,
        typer.Option(
            "--noise",
            metavar="none|typical|FILE",
            help="typical: the default uncertainties; FILE: a log with lines such as "
            "# u_time: 0.1 s.",
        ),
    ] = "typical",
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Seed of the random numbers.")
    ] = 1,
) -> None:
    r"""Print a simulated log with a known true value, for gyro analyze or any other fit.

    Each weight at each position with each pitch, spin and number of turns is one run.
    The rod precesses steadily. The runs share errors as in a lab: one ruler, one scale,
    one tachometer, one hand. The log contains its uncertainties, and its first line the
    true values. The same options give the same log.

    Example:  gyro simulate --inertia "4.44e-3 kg m^2" \
                --weights 20g,40g,60g --position 15cm \
                --spins 200,400,600rpm --turns 1 \
                --seed 1 > log.csv
    """
    from gyrodata.trials import simulation

    known = {"none": simulation.EXACT, "typical": simulation.TYPICAL}
    truth = simulation.Truth(
        inertia=inertia, imbalance=imbalance, decay_time=spin_decay
    )
    design = simulation.Design(
        masses=weights, positions=position, spins=spins, turns=turns, pitches=pitch
    )
    errors = known[noise] if noise in known else simulation.read_noise(noise)
    write_out(simulation.simulate(truth, design, errors, seed).log)


def selfcheck(
    logs: Annotated[
        list[str],
        typer.Argument(
            metavar="LOG",
            help="Log: CSV, text or workbook; - is stdin. Several are days of one "
            "gyroscope.",
        ),
    ],
    labs: Annotated[
        int,
        typer.Option("--labs", min=1, max=1000000, help="Number of simulated labs."),
    ] = 1000,
    seed: Annotated[
        int, typer.Option("--seed", min=0, help="Seed of the random numbers.")
    ] = 1,
    form: FormatOption = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
) -> None:
    r"""Simulate this lab many times, and count the intervals with the true value.

    gyro simulates new readings from the design of the lab, its fitted values as the
    truth, and its stated uncertainties. Each day of a lab has its own M0 and hand; each
    of several logs is a day. gyro applies the recommended fit and those of the textbook
    to each lab. If the runs scatter more or less than stated, a second table shows labs
    with this scatter.

    Example:  gyro selfcheck demo.csv \
                --labs 1000
    """
    from gyrodata.analysis import analyze_readings
    from gyrodata.trials.coverage import selfcheck as simulate

    analysis = analyze_readings(read(logs, settings, mapping, config))
    with progress_bar(labs, "simulated labs") as progress:
        done = simulate(analysis, labs, seed, progress)
    write_answer(form, done.to_dict(), f"{done}\n")


def benchmark(
    log: Annotated[
        str | None,
        typer.Argument(
            metavar="[LOG]", help="Log whose lab takes the place of the usual one."
        ),
    ] = None,
    out: Annotated[
        Path,
        typer.Option(
            "--out", "-o", help="Folder for the page, the pictures and the tables."
        ),
    ] = Path("gyro-benchmark"),
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="A quick look with few labs: a quarter of a minute."
        ),
    ] = False,
) -> None:
    """Chart cost against error on this machine, and map where methods fail.

    The charts compare programs that fit a lab, models of the motion and integrators. The
    maps show for two quantities each where a common method fails, and what gyro does
    there. With a LOG, its lab takes the place of the usual one. gyro writes one page,
    benchmark.html, with the pictures as PNG and their numbers as CSV. It takes up to ten
    minutes on two processors, with --quick a quarter of a minute.

    Example:  gyro benchmark --quick --out charts
    """
    from gyrodata.base.workers import count_workers
    from gyrodata.trials.benchmark.report import FULL, QUICK, files, run

    own = None if log is None else _scene_of(log)
    # Test first that the folder can be written, because the benchmark takes minutes.
    with telling(out):
        write_folder(out, {})
    effort = QUICK if quick else FULL
    workers = count_workers()
    with progress_bar(100, "per cent") as progress:
        tables = run(effort, workers, own, progress)
    name = named_logs([log])[0].name if log else ""
    pages = files(tables, name, workers)
    with telling(out):
        write_folder(out, pages)
    tell(f"page: {out / 'benchmark.html'}")


def _scene_of(log: str) -> LabScene:
    """Read a log for the benchmark."""
    from gyrodata.analysis import fit_log
    from gyrodata.results import Options
    from gyrodata.trials.benchmark.labs import scene_of

    return scene_of(fit_log(read([log]), Options()))


def schema(
    name: Annotated[
        Literal[
            "analysis",
            "check",
            "grades",
            "plan",
            "predictions",
            "selfcheck",
            "rubric",
            "diagnostics",
        ],
        typer.Argument(
            metavar="NAME",
            show_choices=False,
            help="analysis, check, grades, plan, predictions, selfcheck, rubric; or "
            "diagnostics, the table of codes.",
        ),
    ] = "analysis",
) -> None:
    """Print the JSON Schema of an output or a rubric, or all diagnostics.

    Example:  gyro schema diagnostics
    """
    from gyrodata.cli.schema import json_schema
    from gyrodata.reporting.data import json_text
    from gyrodata.reporting.text import diagnostics_text

    is_table = name == "diagnostics"
    write_out(diagnostics_text() if is_table else json_text(json_schema(name)))
