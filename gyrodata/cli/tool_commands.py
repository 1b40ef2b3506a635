"""Commands about the tool itself: whether its intervals hold, how fast it is, what its output and diagnostics mean."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.cli.options import ConfigOption, MappingOption, PlainFormat, SettingsOption, StdinOption, pairs
from gyrodata.cli.terminal import STDIN, name_of, progress_bar, refuse, source_of, tell, write_out
from gyrodata.diagnostics import (
    CODE_PAGE_GUESSED,
    COMPRESSED_FILE_DAMAGED,
    EXPLAINED_CODE_UNKNOWN,
    NO_UNLOADED_RUN,
    REPORT_CANNOT_BE_WRITTEN,
    explanations,
)
from gyrodata.disk import telling, write_folder
from gyrodata.errors import GyroError

if TYPE_CHECKING:
    from gyrodata.errors import Diagnostic


def selfcheck(
    log: Annotated[str, typer.Argument(metavar="LOG", help="CSV log; - is standard input.")],
    labs: Annotated[int, typer.Option("--labs", min=1, max=1_000_000, help="How many labs to simulate.")] = 1000,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random numbers.")] = 1,
    form: Annotated[PlainFormat, typer.Option("--format", "-f", help="Form of the output.")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    stdin: StdinOption = STDIN,
) -> None:
    """Simulate this very lab many times, and count how often the quoted intervals hold the truth.

    The lab's design, its fitted values as the truth and its stated uncertainties make new readings; the
    recommended fit and those of the textbook are applied to each. Where the runs of the log scatter otherwise than
    stated, the output says so, and has a second table of labs that scatter as this one does.
    """
    import time

    from gyrodata.analysis import analyze_readings
    from gyrodata.coverage import selfcheck as simulate
    from gyrodata.measurements import select
    from gyrodata.readings import read_log
    from gyrodata.reporting.data import json_text

    given = pairs(settings, "--set"), pairs(mapping, "--map")
    readings = read_log(**source_of(log, name_of(log, stdin)), settings=given[0], mapping=given[1], config=config)
    analysis = analyze_readings(readings)
    tilted = any(effect.effect == "tilt" and effect.kept for effect in analysis.effects)
    kept = [i for i, run in enumerate(analysis.run_table) if not run.left_out]
    measured = select(analysis.measurements, kept)
    done = simulate(measured, time.perf_counter, labs, seed=seed, tilted=tilted, progress=progress_bar(labs))
    write_out(json_text(done.to_dict()) if form == "json" else done.to_text() + "\n")


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


OPTIONS = "G5"
"""From here on codes are about options and classes, not about one log."""


def _topics(incomplete: str) -> list[tuple[str, str]]:
    """List the pages and codes that begin so, each with its title, for a shell that completes."""
    from gyrodata.docs import PAGES, page_title

    listed = [(name, page_title(name)) for name in PAGES]
    listed += [(code, one.title) for code, one in sorted(explanations().items())]
    return [(name, title) for name, title in listed if name.startswith(incomplete)]


def explain(
    topics: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[PAGE | CODE]...",
            autocompletion=_topics,
            help=f"A page of the documentation, or a code as a message shows it: {NO_UNLOADED_RUN}. "
            "Without one, the pages are listed.",
        ),
    ] = None,
) -> None:
    """Show a page of the documentation, or say what a diagnostic means.

    Of a diagnostic: a log that raises it, what gyro says of that log, and what to do.
    """
    from gyrodata.docs import PAGES, for_terminal, page_text, page_title

    if not topics:
        longest = max(map(len, PAGES))
        listed = [f"  gyro explain {name:<{longest}}  {page_title(name)}" for name in PAGES]
        code = f"  gyro explain {NO_UNLOADED_RUN:<{longest}}  what a code in a message means, and what to do"
        write_out("\n".join(["Pages:", *listed, "Codes:", code]) + "\n")
    parts = []
    for topic in topics or []:
        if (name := topic.lower().removesuffix(".md")) in PAGES:
            page = page_text(name)
            parts.append(for_terminal(page) if sys.stdout.isatty() else page)
        else:
            parts.append(_explanation(topic))
    write_out("\n".join(parts))


def _explanation(asked: str) -> str:
    """Say what a code means."""
    from gyrodata.docs import PAGES
    from gyrodata.reporting.text import explanation

    code = f"G{asked.strip().upper().removeprefix('G')}"
    if code not in explanations():
        hint = (
            f"take a code as a message shows it, such as {NO_UNLOADED_RUN}, or a page: {', '.join(PAGES)}; "
            "gyro schema diagnostics lists all codes"
        )
        refuse(EXPLAINED_CODE_UNKNOWN, f'there is no code "{asked}", and no such page', hint)
    return explanation(code, _raised(code))


def _raised(code: str) -> Diagnostic | None:
    """Let the example raise its diagnostic, where it is a log."""
    from gyrodata.procedure import check_log
    from gyrodata.readings import read_log

    if code >= OPTIONS or explanations()[code].example.startswith("analyze "):
        return None
    found: tuple[Diagnostic, ...] = ()
    try:
        # A byte that is no UTF-8 is what two of them are about.
        page = "latin-1" if code in (COMPRESSED_FILE_DAMAGED, CODE_PAGE_GUESSED) else "utf-8"
        readings = read_log(explanations()[code].example.encode(page), name="log.csv")
        found = readings.diagnostics
        if code not in {one.code for one in found}:
            found = check_log(readings)[1]
    except GyroError as error:
        found = error.diagnostics
    return next((one for one in found if one.code == code), None)
