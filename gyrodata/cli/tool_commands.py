"""Commands about the tool itself: coverage of its intervals, speed, and the schemas of its output."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrodata import diagnostics
from gyrodata.cli.options import ConfigOption, FormatOption, MappingOption, SettingsOption, constants_of, pairs
from gyrodata.cli.terminal import names_of, progress_bar, source_of, tell, write_out
from gyrodata.disk import telling, write_folder


def selfcheck(
    log: Annotated[str, typer.Argument(metavar="LOG", help="Log: CSV, text or workbook; - is stdin.")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1_000_000, help="Number of simulated labs.")] = 1000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
    form: FormatOption = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
) -> None:
    """Simulate this lab many times, and count how often its intervals contain the true value.

    gyro simulates new readings from the design of the lab, its fitted values as the truth, and its stated
    uncertainties. It applies the recommended fit and those of the textbook to each. If the runs of the log scatter
    more or less than stated, a second table shows labs with this scatter.
    """
    from gyrodata.analysis import analyze_readings
    from gyrodata.coverage import selfcheck as simulate
    from gyrodata.readings import read_log
    from gyrodata.reporting.data import json_text

    given = pairs(settings, "--set"), pairs(mapping, "--map")
    readings = read_log(
        **source_of(log, names_of([log])[0]), settings=given[0], mapping=given[1], config=constants_of(log, config)
    )
    analysis = analyze_readings(readings)
    done = simulate(analysis, labs, seed, progress_bar(labs))
    write_out(json_text(done.to_dict()) if form == "json" else f"{done}\n")


def benchmark(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for the charts.")
    ] = Path("gyro-benchmark"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer labs and points: less than a minute.")] = False,
) -> None:  # fmt: skip
    """Chart speed against accuracy on this machine, and show where methods fail.

    There are four charts: models of the motion, integrators, fits, and methods that fail with their solutions. Each is
    written as PNG, SVG and CSV, with a short text that names the best method and the reason; the text is printed too.
    It takes some minutes, with --quick less than one.
    """
    import time

    from gyrodata.benchmark import FULL, QUICK, csv_tables, describe_machine, reading, run_benchmark
    from gyrodata.plotting.charts import render_benchmark

    effort = QUICK if quick else FULL
    # Test first that the folder can be written, because the benchmark takes minutes.
    with telling(out, diagnostics.REPORT_CANNOT_BE_WRITTEN):
        write_folder(out, {})
    # Some systems count CPU time in long ticks; the wall clock is better there.
    fine = time.get_clock_info("process_time").resolution < 1e-5
    clock = time.process_time if fine else time.perf_counter
    done = run_benchmark(effort, clock, 1, progress_bar(100), describe_machine())
    words = reading(done, effort, 1)
    tables = {f"{name}.csv": table.encode() for name, table in csv_tables(done).items()}
    with telling(out, diagnostics.REPORT_CANNOT_BE_WRITTEN):
        write_folder(out, {**render_benchmark(done), **tables, "reading.md": words.encode()})
    write_out(words)
    tell(f"charts: {out}")


SchemaName = Literal["analysis", "check", "grades", "predictions", "selfcheck", "rubric", "diagnostics"]


def schema(
    name: Annotated[
        SchemaName,
        typer.Argument(
            metavar="[NAME]",
            help="analysis, check, grades, predictions, selfcheck, rubric; or diagnostics, the table of codes.",
        ),
    ] = "analysis",
) -> None:
    """Print the JSON Schema of an output or of a rubric, or the table of diagnostics."""
    from gyrodata.reporting.data import json_text
    from gyrodata.reporting.text import diagnostics_text
    from gyrodata.schema import diagnostics_table, json_schema

    write_out(diagnostics_text(diagnostics_table()) if name == "diagnostics" else json_text(json_schema(name)))
