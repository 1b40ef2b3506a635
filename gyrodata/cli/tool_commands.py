"""Commands for instructors and developers.

Their subjects are simulated logs, the coverage of intervals, the speed, and the schemas
of the output.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.base.disk import telling, write_folder
from gyrodata.cli import options
from gyrodata.cli.terminal import (
    names_of,
    progress_bar,
    tell,
    write_out,
    write_text,
)

if TYPE_CHECKING:
    from gyrodata.trials.benchmark.report import Scene


def simulate(
    inertia: Annotated[
        str, typer.Option("--inertia", metavar="QUANTITY")
    ] = "4.44e-3 kg m^2",
    weights: Annotated[
        str, typer.Option("--weights", metavar="QUANTITIES")
    ] = "20g,40g,60g",
    position: Annotated[str, typer.Option("--position", metavar="QUANTITIES")] = "15cm",
    spins: Annotated[
        str, typer.Option("--spins", metavar="QUANTITIES")
    ] = "200,400,600rpm",
    turns: Annotated[str, typer.Option("--turns", metavar="NUMBERS")] = "1",
    pitch: Annotated[str, typer.Option("--pitch", metavar="QUANTITIES")] = "0deg",
    imbalance: Annotated[
        str | None, typer.Option("--imbalance", metavar="QUANTITY")
    ] = None,
    spin_decay: Annotated[
        str | None, typer.Option("--spin-decay", metavar="QUANTITY")
    ] = None,
    noise: Annotated[
        str, typer.Option("--noise", metavar="none|typical|FILE")
    ] = "typical",
    seed: Annotated[int, typer.Option("--seed", min=0)] = 1,
) -> None:
    """Print a simulated log with a known true value, for gyro analyze or any other fit.

    Each weight at each position with each pitch, spin and number of turns is one run.
    The rod precesses steadily. The runs share errors as in a lab: one ruler, one scale,
    one tachometer, one hand. The log contains its uncertainties, and its first line the
    true values. The same options give the same log.
    """
    from gyrodata.trials import simulation

    known = {"none": simulation.EXACT, "typical": simulation.TYPICAL}
    truth = simulation.Truth(
        inertia=options.quantity("--inertia", inertia, "inertia", "above zero"),
        imbalance=None
        if imbalance is None
        else options.quantity("--imbalance", imbalance, "torque"),
        decay_time=None
        if spin_decay is None
        else options.quantity("--spin-decay", spin_decay, "time", "above zero"),
    )
    design = simulation.Design(
        masses=_list("--weights", weights, "mass"),
        positions=_list("--position", position, "length"),
        spins=_list("--spins", spins, "rate", "other than zero"),
        turns=_list("--turns", turns, "number", "above zero"),
        pitches=_list("--pitch", pitch, "angle"),
    )
    errors = known[noise] if noise in known else simulation.read_noise(noise)
    write_out(simulation.simulate(truth, design, errors, seed).log)


def _list(
    option: str, text: str, kind: str, bound: options.Bound = ""
) -> tuple[float, ...]:
    return tuple(
        options.quantity(option, item, kind, bound) for item in options.with_units(text)
    )


def selfcheck(
    logs: Annotated[list[str], typer.Argument(metavar="LOG")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1000000)] = 1000,
    seed: Annotated[int, typer.Option("--seed", min=0)] = 1,
    form: options.FormatOption = "text",
    settings: options.SettingsOption = None,
    mapping: options.MappingOption = None,
    config: options.ConfigOption = None,
) -> None:
    """Simulate this lab many times, and count the intervals with the true value.

    gyro simulates new readings from the design of the lab, its fitted values as the
    truth, and its stated uncertainties. Each day of a lab has its own M0 and hand; each
    of several logs is a day. gyro applies the recommended fit and those of the textbook
    to each lab. If the runs scatter more or less than stated, a second table shows labs
    with this scatter.
    """
    from gyrodata.analysis import analyze_readings
    from gyrodata.reporting.data import json_text
    from gyrodata.trials.coverage import selfcheck as simulate

    analysis = analyze_readings(options.read(logs, settings, mapping, config))
    with progress_bar(labs, "simulated labs") as progress:
        done = simulate(analysis, labs, seed, progress)
    if form == "json":
        write_out(json_text(done.to_dict()))
    else:
        write_text(f"{done}\n")


def benchmark(
    log: Annotated[str | None, typer.Argument(metavar="[LOG]")] = None,
    out: Annotated[Path, typer.Option("--out", "-o")] = Path("gyro-benchmark"),
    quick: Annotated[bool, typer.Option("--quick")] = False,
) -> None:
    """Chart cost against error on this machine, and map where methods fail.

    The charts compare programs that fit a lab, models of the motion and integrators. The
    maps show for two quantities each where a common method fails, and what gyro does
    there. With a LOG, its lab takes the place of the usual one. gyro writes one page,
    benchmark.html, with the pictures as PNG and their numbers as CSV. It takes up to ten
    minutes on two processors, with --quick a quarter of a minute.
    """
    from gyrodata.base.workers import count_workers
    from gyrodata.trials.benchmark import report

    own = report.USUAL if log is None else _scene_of(log)
    # Test first that the folder can be written, because the benchmark takes minutes.
    with telling(out):
        write_folder(out, {})
    effort = report.QUICK if quick else report.FULL
    workers = count_workers()
    with progress_bar(100, "per cent") as progress:
        tables = report.run(effort, workers, 1, own, progress)
    name = names_of([log])[0] if log else ""
    files = report.files(tables, name, workers)
    with telling(out):
        write_folder(out, files)
    write_text("\n\n".join(report.titles(tables).values()) + "\n")
    tell(f"page: {out / 'benchmark.html'}")


def _scene_of(log: str) -> Scene:
    """Read a log for the benchmark."""
    from gyrodata.analysis import fit_log
    from gyrodata.results import Options
    from gyrodata.trials.benchmark.report import scene_of

    return scene_of(fit_log(options.read([log]), Options()))


SchemaName = Literal[
    "analysis",
    "check",
    "grades",
    "plan",
    "predictions",
    "selfcheck",
    "rubric",
    "diagnostics",
]


def schema(
    name: Annotated[
        SchemaName, typer.Argument(metavar="NAME", show_choices=False)
    ] = "analysis",
) -> None:
    """Print the JSON Schema of an output or a rubric, or all diagnostics."""
    from gyrodata.cli.schema import json_schema
    from gyrodata.reporting.data import json_text
    from gyrodata.reporting.text import diagnostics_text

    if name == "diagnostics":
        write_out(diagnostics_text())
    else:
        write_out(json_text(json_schema(name)))
