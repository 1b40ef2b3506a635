"""``gyro template``: a log to fill in. ``gyro check``: what a log still lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer

from gyrodata.base import diagnostics
from gyrodata.base.errors import Diagnostic, InputError
from gyrodata.cli.new_table import write_new
from gyrodata.cli.options import (
    ConfigOption,
    MappingOption,
    Reader,
    SettingsOption,
    input_of,
    stem_of,
)
from gyrodata.cli.terminal import (
    Log,
    complain,
    explained,
    finish,
    in_parts,
    named_logs,
    place,
    refuse,
    write_answer,
)

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis, HandIn, Options


class Checked(NamedTuple):
    """A log or a submission, and what `gyro check` found in it."""

    name: str
    findings: Sequence[Diagnostic]
    code: int
    """The exit code."""
    readings: Readings | None = None
    """None if the log cannot be read."""
    analysis: Analysis | None = None
    """None if the log has no answer, or for a submission."""
    hand_in: HandIn | None = None
    """Of a submission: what a grader would read."""

    def __str__(self) -> str:
        from gyrodata.reporting.text import check_text

        runs = len(self.readings.runs) if self.readings else None
        verdict = "with an answer" if self.hand_in else "complete"
        return check_text(self.name, runs, self.findings, verdict, self.analysis)

    def to_dict(self) -> dict[str, Any]:
        """Return the object of the JSON, with the schema "gyro.check/1"."""
        from gyrodata.results import CheckDocument, to_json

        doubts = self.analysis.doubts if self.analysis else ()
        only_notes = all(finding.severity == "note" for finding in self.findings)
        document = CheckDocument(
            input=input_of(self.name, self.readings),
            clean=not doubts and only_notes,
            doubts=doubts,
            diagnostics=tuple([finding.to_dict() for finding in self.findings]),
            hand_in=self.hand_in,
        )
        return to_json(document)


def check(
    *,
    logs: Annotated[
        list[str],
        typer.Argument(metavar="LOG", help="Logs: CSV, text or workbook; - is stdin."),
    ],
    hand_in: Annotated[
        bool,
        typer.Option(
            "--hand-in",
            help="Show instead which answer gyro grade will read from the files of one "
            "submission, or from a folder or zip.",
        ),
    ] = False,
    fix: Annotated[
        bool,
        typer.Option(
            "--fix",
            help="Also write the log as gyro understood it, with -fixed.csv in the "
            "name.",
        ),
    ] = False,
    together: Annotated[
        bool,
        typer.Option(
            "--together",
            help="Check several logs of one gyroscope as one: days, groups.",
        ),
    ] = False,
    form: Annotated[
        Literal["text", "json", "ndjson"],
        typer.Option("--format", "-f", help="What to write to standard output."),
    ] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    exit_zero: Annotated[
        bool,
        typer.Option("--exit-zero", help="Exit with 0 even if something is found."),
    ] = False,
) -> None:
    """Check a log while you can still repeat or add runs.

    Exit codes: 0 nothing wrong (there may be advice); 1 something is wrong, or with
    --hand-in the answer is missing or not unique; 2 wrong use, or a log that cannot be
    read; 3 a fault of gyro.

    Example:  gyro check demo.csv
              gyro check demo.csv --fix
              gyro check demo.csv --format json
    """
    if hand_in:
        if any((settings, mapping, config, fix, together, "-" in logs)):
            refuse("hand_in_as_it_is")
        checked = _check_submission(logs)
        write_answer(form, checked.to_dict(), checked)
        exit_code = checked.code
    else:
        if fix and "-" in logs:
            refuse("fix_of_standard_input")
        parts = in_parts(logs, together, form)
        reader = Reader.of_options(settings, mapping, config)
        exit_code = max([_check(part, reader, fix, form) for part in parts])
    finish(exit_code, exit_zero)


def _check(logs: Sequence[Log], reader: Reader, fix: bool, form: str) -> int:
    """Print what is found in a log, or in several together; return the exit code."""
    name = " + ".join(log.name for log in logs)
    checked = check_log(name, partial(reader.read, logs))
    write_answer(form, checked.to_dict(), checked)
    exit_code = checked.code
    if not fix or checked.readings is None:
        return exit_code
    of_logs = [readings for _, readings in checked.readings.files]
    for log, readings in zip(logs, of_logs or [checked.readings], strict=True):
        try:
            _write_fixed(Path(log.path), readings, form)
        except InputError as error:
            complain(error.diagnostics)
            exit_code = max(exit_code, error.exit_code)
    return exit_code


def _write_fixed(log: Path, readings: Readings, form: str) -> None:
    """Write a log as it was understood next to it, and list what is left to fill in."""
    from gyrodata.readings import fixed_log

    fixed = log.with_name(f"{stem_of(log)}-fixed.csv")
    if not readings.runs or not readings.columns:
        refuse("fix_without_runs", fixed=fixed, log=readings.name)
    text, gaps = fixed_log(readings)
    write_new(fixed, text.encode())
    count = len(gaps) or "nothing"
    summary = f"{fixed}: {readings.name} as gyro understood it; left for you: {count}"
    lines = [summary, *gaps]
    typer.echo("\n   ".join(lines), err=form != "text")


def check_log(
    name: str, read: Callable[[], Readings], options: Options | None = None
) -> Checked:
    """Read and analyse a log, and list what it lacks; an error is a finding."""
    from gyrodata import analysis as analyzing

    try:
        readings = read()
        analysis, findings = analyzing.check_log(readings, options)
    except Exception as error:
        return Checked(name, *explained(error, name))
    has_doubts = analysis is not None and bool(analysis.doubts)
    code = int(has_doubts or _is_serious(findings))
    in_order = sorted(findings, key=place)
    if readings.files:
        in_order.sort(key=lambda finding: finding.file or "")
    return Checked(name, in_order, code, readings, analysis)


def _check_submission(paths: Sequence[str]) -> Checked:
    """Read a submission as a grader would; an error is a finding.

    Missing runs are not listed: they cannot be measured any more.
    """
    from gyrodata.grading.grade import read_hand_in

    name = named_logs(paths)[0].name
    try:
        readings, hand_in, of_submission = read_hand_in([Path(path) for path in paths])
    except Exception as error:
        return Checked(name, *explained(error, name))
    # The line of the answer is read, although no fit uses it.
    remark_of_answer = diagnostics.REMARK, hand_in.file, hand_in.line
    of_log = [
        finding
        for finding in readings.diagnostics
        if (finding.code, finding.file, finding.line) != remark_of_answer
    ]
    findings = (*sorted(of_log, key=place), *sorted(of_submission, key=place))
    code = int(_is_serious(findings))
    return Checked(readings.name, findings, code, readings, hand_in=hand_in)


def _is_serious(findings: Sequence[Diagnostic]) -> bool:
    """Return whether a finding is more than a note or advice."""
    from gyrodata.judging.procedure import ADVICE

    return any(
        finding.severity != "note" and finding.code not in ADVICE
        for finding in findings
    )
