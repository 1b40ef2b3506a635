"""Commands about the tool itself: coverage of its intervals, speed, and the schemas of its output."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from gyrodata.cli.options import ConfigOption, MappingOption, PlainFormat, SettingsOption, StdinOption, pairs
from gyrodata.cli.terminal import STDIN, name_of, progress_bar, source_of, tell, write_out
from gyrodata.diagnostics import REPORT_CANNOT_BE_WRITTEN
from gyrodata.disk import telling, write_folder


def selfcheck(
    log: Annotated[str, typer.Argument(metavar="LOG", help="Log: CSV, text or workbook; - is stdin.")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1_000_000, help="Number of simulated labs.")] = 1000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
    form: Annotated[PlainFormat, typer.Option("--format", "-f", help="Form of the output.")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    stdin: StdinOption = STDIN,
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
    readings = read_log(**source_of(log, name_of(log, stdin)), settings=given[0], mapping=given[1], config=config)
    analysis = analyze_readings(readings)
    done = simulate(analysis, labs, seed, progress_bar(labs))
    write_out(json_text(done.to_dict()) if form == "json" else f"{done}\n")


def benchmark(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for the charts.")
    ] = Path("gyro-benchmark"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer labs and points: less than a minute.")] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
) -> None:  # fmt: skip
    """Chart speed against accuracy on this machine, and where methods fail.

    There are four charts: models of the motion, integrators, fits, and methods that fail with their solutions. Each is
    written as PNG, SVG and CSV, with a short text that says which method wins and why; the text is printed too. It
    takes some minutes, with --quick less than one.
    """
    import time

    from gyrodata.benchmark import FULL, QUICK, csv_tables, describe_machine, reading, run_benchmark
    from gyrodata.plotting.charts import render_benchmark

    effort = QUICK if quick else FULL
    # A folder that cannot be written is better known before the minutes than after them.
    with telling(out, REPORT_CANNOT_BE_WRITTEN):
        write_folder(out, {})
    # Where the system counts CPU time in long ticks, the wall clock is the better one.
    fine = time.get_clock_info("process_time").resolution < 1e-5
    clock = time.process_time if fine else time.perf_counter
    done = run_benchmark(effort, clock, seed, progress_bar(100), describe_machine())
    words = reading(done, effort, seed)
    tables = {f"{name}.csv": table.encode() for name, table in csv_tables(done).items()}
    with telling(out, REPORT_CANNOT_BE_WRITTEN):
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
    as_json: Annotated[bool, typer.Option("--json", help="The table of diagnostics as JSON.")] = False,
) -> None:
    """Print the JSON Schema of an output or of a rubric, or the table of diagnostics."""
    from gyrodata import schema as schemas
    from gyrodata.reporting.data import json_text
    from gyrodata.reporting.text import diagnostics_text

    if name == "diagnostics":
        table = schemas.diagnostics_table()
        write_out(json_text({"diagnostics": table}) if as_json else diagnostics_text(table))
    else:
        write_out(json_text(getattr(schemas, f"{name}_schema")()))
