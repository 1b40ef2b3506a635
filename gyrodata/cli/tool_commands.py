"""Commands for instructors and developers.

Their subjects are simulated logs, the coverage of intervals, the speed, and the schemas
of the output.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from gyrodata.base.disk import telling, write_folder
from gyrodata.cli import options
from gyrodata.cli.terminal import names_of, progress_bar, source_of, tell, write_out

if TYPE_CHECKING:
    from gyrodata.trials.simulation import Decay


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
        decay=_decay(spin_decay),
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


def _decay(text: str | None) -> Decay | None:
    """Read "600 s", a time constant, or "10 %", the part lost in each run."""
    from gyrodata.trials.simulation import Decay

    if text is None:
        return None
    if text.rstrip().endswith("%"):
        return Decay(
            lost=options.quantity("--spin-decay", text.rstrip()[:-1], "number") / 100
        )
    return Decay(
        time_constant=options.quantity("--spin-decay", text, "time", "above zero")
    )


def selfcheck(
    log: Annotated[str, typer.Argument(metavar="LOG")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1000000)] = 1000,
    seed: Annotated[int, typer.Option("--seed", min=0)] = 1,
    form: options.FormatOption = "text",
    settings: options.SettingsOption = None,
    mapping: options.MappingOption = None,
    config: options.ConfigOption = None,
) -> None:
    """Simulate this lab many times, and count the intervals with the true value.

    gyro simulates new readings from the design of the lab, its fitted values as the
    truth, and its stated uncertainties. It applies the recommended fit and those of the
    textbook to each. If the runs of the log scatter more or less than stated, a second
    table shows labs with this scatter.
    """
    from gyrodata.analysis import analyze_readings
    from gyrodata.readings import read_log
    from gyrodata.reporting.data import json_text
    from gyrodata.trials.coverage import selfcheck as simulate

    given: dict[str, Any] = {
        "settings": options.pairs(settings, "--set"),
        "mapping": options.pairs(mapping, "--map"),
    }
    readings = read_log(
        **source_of(log, names_of([log])[0]),
        **given,
        config=options.constants_of(log, config),
    )
    done = simulate(analyze_readings(readings), labs, seed, progress_bar(labs))
    write_out(json_text(done.to_dict()) if form == "json" else f"{done}\n")


def benchmark(
    out: Annotated[Path, typer.Option("--out", "-o")] = Path("gyro-benchmark"),
    quick: Annotated[bool, typer.Option("--quick")] = False,
) -> None:
    """Chart speed against accuracy on this machine, and show where methods fail.

    There are four charts: models of the motion, integrators, fits, and methods that
    fail with their solutions. Each is written as PNG, SVG and CSV, with a short text
    that names the best method and the reason; the text is printed too. It takes some
    minutes, with --quick less than one.
    """
    import time

    from gyrodata.trials.benchmark import (
        FULL,
        QUICK,
        csv_tables,
        describe_machine,
        reading,
        run_benchmark,
    )
    from gyrodata.trials.benchmark.charts import render_benchmark

    effort = QUICK if quick else FULL
    # Test first that the folder can be written, because the benchmark takes minutes.
    with telling(out):
        write_folder(out, {})
    # Some systems count CPU time in long ticks; the wall clock is better there.
    clock = (
        time.process_time
        if time.get_clock_info("process_time").resolution < 1e-5
        else time.perf_counter
    )
    done = run_benchmark(effort, clock, 1, progress_bar(100), describe_machine())
    words = reading(done, effort, 1)
    tables = {f"{name}.csv": table.encode() for name, table in csv_tables(done).items()}
    with telling(out):
        write_folder(
            out, {**render_benchmark(done), **tables, "reading.md": words.encode()}
        )
    write_out(words)
    tell(f"charts: {out}")


SchemaName = Literal[
    "analysis", "check", "grades", "predictions", "selfcheck", "rubric", "diagnostics"
]


def schema(
    name: Annotated[
        SchemaName, typer.Argument(metavar="NAME", show_choices=False)
    ] = "analysis",
) -> None:
    """Print the JSON Schema of an output or a rubric, or all diagnostics."""
    from gyrodata.cli.schema import diagnostics_table, json_schema
    from gyrodata.reporting.data import json_text
    from gyrodata.reporting.text import diagnostics_text

    write_out(
        diagnostics_text(diagnostics_table())
        if name == "diagnostics"
        else json_text(json_schema(name))
    )
