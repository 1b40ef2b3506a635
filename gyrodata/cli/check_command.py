"""``gyro template`` and ``gyro check``: a log to fill in, and what a log still lacks."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.cli.options import ConfigOption, MappingOption, SettingsOption, StdinOption, pairs, with_units
from gyrodata.cli.terminal import (
    FAULT,
    STDIN,
    coloured,
    fault,
    name_of,
    names_of,
    refuse,
    short_paths,
    source_of,
    wrapped,
    write_out,
)
from gyrodata.diagnostics import FIXED_LOG_CANNOT_BE_WRITTEN, FORMAT_FOR_ONE_LOG, HAND_IN_AS_IT_IS
from gyrodata.errors import Diagnostic, GyroError, InputError

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis, HandIn


CheckFormat = Literal["text", "json", "ndjson"]


def template(
    weights: Annotated[str, typer.Option("--weights", help="Masses of the weights.")] = "20g,40g,60g",
    position: Annotated[str, typer.Option("--position", help="Position of the weights on the rod.")] = "15cm",
    spins: Annotated[str, typer.Option("--spins", help="Spins to aim for.")] = "200,400,600rpm",
) -> None:
    """Print a blank log to fill in: each weight with every spin, alternating, and a run without a weight."""
    from gyrodata.readings import blank_log

    write_out(blank_log(with_units(weights), position, with_units(spins)))


def check(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="Logs: CSV, text or workbook; - is stdin.")],
    hand_in: Annotated[
        bool,
        typer.Option("--hand-in", help="Show instead which answer gyro grade will read from the files of one "
                     "submission, or from a folder or zip."),
    ] = False,
    fix: Annotated[
        bool,
        typer.Option("--fix", help="Also write the log as gyro understood it, with -fixed.csv in the name."),
    ] = False,
    form: Annotated[CheckFormat, typer.Option("--format", "-f", help="What to write to standard output.")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    stdin: StdinOption = STDIN,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 even if there is only advice.")] = False,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even if something is found.")] = False,
) -> None:  # fmt: skip
    """Check a log while you can still repeat or add runs.

    Exit codes: 0 nothing wrong (there may be advice); 1 something is wrong, or with --hand-in the answer is missing or
    not unique; 2 wrong use, or a log that cannot be read; 3 a fault of gyro.
    """
    given = pairs(settings, "--set"), pairs(mapping, "--map")
    if hand_in:
        if settings or mapping or config or fix or "-" in logs:
            message = "--hand-in reads files as gyro grade does, which knows no --set, --map, --config, --fix and no -"
            refuse(HAND_IN_AS_IT_IS, message, "leave these out, and write what they say into the log")
        from gyrodata.grading.hand_in import read_hand_in

        files = [Path(log) for log in logs]
        worst = _check_one(name_of(logs[0]), lambda: read_hand_in(files), form, strict)
    elif form == "json" and len(logs) > 1:
        refuse(FORMAT_FOR_ONE_LOG, "--format json is for one log", "use --format ndjson for several: one object a line")
    else:
        if fix and "-" in logs:
            message = "--fix writes a file beside the log, and standard input has no name"
            refuse(FIXED_LOG_CANNOT_BE_WRITTEN, message, "save the log first: gyro check --fix log.csv")
        named = zip(logs, names_of(short_paths(logs), stdin), strict=True)
        read = partial(_read, given, config)
        worst = 0
        unfixed: list[Diagnostic] = []
        for log, name in named:
            read_one = partial(read, log, name)
            worst = max(worst, _check_one(name, read_one, form, strict))
            try:
                if fix:
                    _fix(Path(log), name, read_one, form)
            except InputError as error:
                unfixed += error.diagnostics
        if unfixed:
            raise InputError(unfixed)
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


Read = tuple["Readings", "HandIn | None", tuple["Diagnostic", ...]]
"""A log, what a grader would read beside it, and what was found on the way."""


def _read(given: tuple[dict[str, str], dict[str, str]], config: Path | None, log: str, name: str) -> Read:
    """Read one log by itself; `given`: settings and mapping."""
    from gyrodata.readings import read_log

    settings, mapping = given
    return read_log(**source_of(log, name), settings=settings, mapping=mapping, config=config), None, ()


def _fix(log: Path, name: str, read: Callable[[], Read], form: CheckFormat) -> None:
    """Write a log as it was understood next to it, and list what is left to fill in."""
    from gyrodata.disk import write_whole
    from gyrodata.readings import fixed_log

    try:
        readings, _, _ = read()
    except GyroError:
        return  # the check has shown why this is not a log
    fixed = log.with_name(f"{log.name.removesuffix('.gz').rpartition('.')[0] or log.name}-fixed.csv")
    if not readings.runs or not readings.columns:
        message = f"{fixed} is not written: gyro understands no run of {name}"
        refuse(FIXED_LOG_CANNOT_BE_WRITTEN, message, "first correct what is said above")
    text, left = fixed_log(readings)
    try:
        if fixed.exists() and fixed.read_text("utf-8", "replace") != text:
            message = f"{fixed} is there already, and is another one"
            refuse(FIXED_LOG_CANNOT_BE_WRITTEN, message, "rename it or take it away, so that nothing in it is lost")
        write_whole(fixed, [text.encode()])
    except OSError as error:
        message = f"{fixed} cannot be written: {error.strerror or error}"
        refuse(FIXED_LOG_CANNOT_BE_WRITTEN, message, "make room there, or copy the log into another folder")
    todo = f"left for you: {len(left)}" if left else "nothing is left to correct"
    typer.echo("\n   ".join([f"{fixed}: {name} as gyro understood it; {todo}", *left]), err=form != "text")


def _check_one(name: str, read: Callable[[], Read], form: CheckFormat, strict: bool) -> int:
    """Check one log, print what was found, and give the exit code."""
    from gyrodata.procedure import ADVICE, check_log
    from gyrodata.reporting.data import json_text
    from gyrodata.reporting.text import check_text

    readings: Readings | None = None
    hand_in: HandIn | None = None
    analysis: Analysis | None = None
    told: tuple[Diagnostic, ...] = ()
    try:
        readings, hand_in, told = read()
        found = (*readings.diagnostics, *told)
        # Missing runs are listed before the submission, when they can still be measured.
        if readings.ok and hand_in is None:
            analysis, found = check_log(readings)
        serious = [one for one in found if one.severity != "note" and (strict or one.code not in ADVICE)]
        code = 1 if serious or (analysis and analysis.doubts) else 0
    except GyroError as error:
        found, code = error.diagnostics, error.exit_code
    except Exception as error:
        found, code = (fault(error, name),), FAULT
    # Findings about the whole submission come last.
    found = tuple(sorted(found, key=lambda one: (one in told, one.line or 0, one.column or 0)))
    name = readings.name if readings and hand_in else name
    if form == "text":
        well = "with an answer" if hand_in else "complete"
        runs = len(readings.runs) if readings else None
        text = wrapped(check_text(name, runs, found, well, analysis), sys.stdout)
        write_out(coloured(text, sys.stdout))
    else:
        digest, rows = (readings.sha256, len(readings.runs)) if readings else (None, None)
        from gyrodata.results import CheckDocument, Input, to_json

        doubts = analysis.doubts if analysis else ()
        document = CheckDocument(
            input=Input(name, digest, rows),
            clean=not doubts and all(one.severity == "note" for one in found),
            doubts=doubts,
            diagnostics=tuple(one.to_dict() for one in found),
            hand_in=hand_in,
        )
        write_out(json_text(to_json(document), indent=2 if form == "json" else None))
    return code
