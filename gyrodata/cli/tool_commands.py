"""Commands about the tool itself: whether its intervals hold, how fast it is and where it breaks, what it prints."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gyrodata.cli.options import ConfigOption, MappingOption, PlainFormat, SettingsOption, pairs
from gyrodata.cli.terminal import progress_bar, source_of, write_folder, write_out


def selfcheck(
    log: Annotated[str, typer.Argument(metavar="LOG", help="CSV log; - is standard input.")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1_000_000, help="How many labs to simulate.")] = 4000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
    form: Annotated[PlainFormat, typer.Option("--format", "-f", help="Form of the output.")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
) -> None:
    """Simulate this very lab many times, and count how often the quoted intervals hold the truth.

    The lab's design, its fitted values as the truth and its stated uncertainties make new readings; the
    recommended fit and those of the textbook are applied to each. Where the runs of the log scatter otherwise than
    stated, the output says so, and has a second table of labs that scatter as this one does.
    """
    import time

    from gyrodata import reporting
    from gyrodata.analysis import analyze_readings
    from gyrodata.measurements import select
    from gyrodata.readings import read_log
    from gyrodata.selfcheck import selfcheck as simulate

    given = pairs(settings, "--set"), pairs(mapping, "--map")
    readings = read_log(**source_of(log), settings=given[0], mapping=given[1], config=config)
    analysis = analyze_readings(readings)
    tilted = any(effect.effect == "tilt" and effect.kept for effect in analysis.effects)
    kept = [i for i, run in enumerate(analysis.run_table) if not run.left_out]
    measured = select(analysis.measurements, kept)
    done = simulate(measured, time.perf_counter, labs, seed=seed, tilted=tilted, progress=progress_bar(labs))
    write_out(reporting.json_text(done.to_dict()) if form == "json" else done.to_text() + "\n")


def benchmark(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for the charts; made if it is not there.")
    ] = Path("gyro-benchmark"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer labs and points: less than a minute.")] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
) -> None:  # fmt: skip
    """Chart speed against accuracy on this machine, and map where methods break.

    Motion models and integrators, estimators, and maps of stability: each as PNG, SVG and CSV, and a short text that
    reads the charts, which is printed too. It takes some minutes, with --quick less than one.
    """
    import time

    from gyrodata.benchmark import FULL, QUICK, csv_tables, reading, run_benchmark
    from gyrodata.plotting import render_benchmark

    effort = QUICK if quick else FULL
    show = progress_bar(100)
    # A folder that cannot be written is better known before the minutes than after them.
    write_folder(out, {})
    done = run_benchmark(effort, time.perf_counter, seed, None if show is None else lambda part: show(int(100 * part)))
    words = reading(done, effort, seed)
    tables = {f"{name}.csv": table.encode() for name, table in csv_tables(done).items()}
    write_folder(out, {**render_benchmark(done), **tables, "reading.md": words.encode()})
    write_out(words)
    typer.echo(f"charts: {out}", err=True)


def schema(
    diagnostics: Annotated[
        bool, typer.Option("--diagnostics", help="The table of diagnostic codes, each with an example.")
    ] = False,
    checks: Annotated[bool, typer.Option("--check", help="The schema of gyro check --format json.")] = False,
    grades: Annotated[bool, typer.Option("--grades", help="The schema of gyro grade --format json.")] = False,
    predictions: Annotated[
        bool, typer.Option("--predictions", help="The schema of gyro predict --format json.")
    ] = False,
    selfchecks: Annotated[
        bool, typer.Option("--selfcheck", help="The schema of gyro selfcheck --format json.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="The table of diagnostics as JSON.")] = False,
) -> None:
    """Print the JSON Schema of the outputs, or the table of diagnostics."""
    from gyrodata import reporting
    from gyrodata import schema as schemas

    if diagnostics and as_json:
        write_out(reporting.json_text({"diagnostics": schemas.diagnostics_table()}))
    elif diagnostics:
        write_out(reporting.diagnostics_text(schemas.diagnostics_table()))
    else:
        wanted = schemas.analysis_schema
        for asked, other in (
            (checks, schemas.check_schema),
            (grades, schemas.grades_schema),
            (predictions, schemas.predictions_schema),
            (selfchecks, schemas.selfcheck_schema),
        ):
            wanted = other if asked else wanted
        write_out(reporting.json_text(wanted()))
