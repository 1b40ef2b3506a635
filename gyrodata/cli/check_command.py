"""``gyro template``: a log to fill in. ``gyro check``: what a log still lacks."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer

from gyrodata.base.disk import telling, write_whole
from gyrodata.base.errors import Diagnostic, GyroError, InputError
from gyrodata.cli.options import (
    ConfigOption,
    MappingOption,
    SettingsOption,
    constants_of,
    pairs,
    with_units,
)
from gyrodata.cli.terminal import (
    FAULT,
    complain,
    fault,
    names_of,
    refuse,
    source_of,
    tell,
    write_out,
    write_text,
)

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis, HandIn, Options


CheckFormat = Literal["text", "json", "ndjson"]


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

    @property
    def rows(self) -> int | None:
        """Number of runs, if the log was read."""
        return len(self.readings.runs) if self.readings else None

    def __str__(self) -> str:
        from gyrodata.reporting.text import check_text

        verdict = "with an answer" if self.hand_in else "complete"
        return check_text(self.name, self.rows, self.findings, verdict, self.analysis)


def template(
    weights: Annotated[str, typer.Option("--weights")] = "20g,40g,60g",
    position: Annotated[str, typer.Option("--position")] = "15cm",
    spins: Annotated[str, typer.Option("--spins")] = "200,400,600rpm",
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE")] = None,
) -> None:
    """Write a blank log: each weight with every spin, and a run without a weight.

    The spins alternate. Without --out, the log is printed as CSV.
    """
    text = blank_log(with_units(weights), position, with_units(spins))
    if out is None:
        write_out(text)
        return
    if out.exists():
        refuse("template_exists", out=out)
    with telling(out):
        write_whole(
            out, [_workbook(text) if out.suffix.lower() == ".xlsx" else text.encode()]
        )
    tell(f"blank log: {out}; after the first runs, check it: gyro check {out}")


_EXAMPLES = {"mass": "20g,40g,60g", "length": "15cm", "rate": "200,400,600rpm"}


def blank_log(weights: Sequence[str], position: str, spins: Sequence[str]) -> str:
    """Write a log to fill in, with each weight at each spin.

    The log also contains a run without a weight, and the first run again.

    The weights take turns, and the second half of the runs is the first half backwards:
    a drift of the balance during the session does not look like an effect of the
    torque.

    Parameters
    ----------
    weights : sequence of str
        Masses with their units, such as ``20 g``; repeats are kept once.
    position : str
        Position of the weights, such as ``15 cm``.
    spins : sequence of str
        Spins to aim at, such as ``400 rpm``. They are in the notes: the column is for
        the spins that are read.

    Returns
    -------
    str
        CSV text that `read_log` reads without a diagnostic when spin, time and turns
        are filled in.

    Raises
    ------
    InputError
        A value cannot be read.
    """
    # The values have the digits that a scale and a ruler show.
    masses = _shown(weights, "mass", "g", "--weights", 2)
    [arm] = _shown([position], "length", "cm", "--position", 1)
    aims = _shown(spins, "rate", "rpm", "--spins", 0)
    lines = (
        Path(__file__)
        .with_name("blank_log.csv")
        .read_text(encoding="utf-8")
        .splitlines()
    )
    half = [*range(len(masses))] * (len(aims) // 2)
    middle: list[int | None] = [0, *range(1, len(masses)), 0] if len(aims) % 2 else [0]
    middle.insert((len(middle) + 1) // 2, None)
    hung = [0] * len(masses)
    for weight in (*half, *middle, *reversed(half)):
        if weight is None:
            lines.append(
                f"0,,,,,,no weight on the rod; aim at {aims[len(aims) // 2]} rpm"
            )
            continue
        # Each weight begins with another spin, so that the spins take turns too.
        aim = aims[(weight + hung[weight]) % len(aims)]
        hung[weight] += 1
        again = "the first run once more; " if hung[weight] > len(aims) else ""
        lines.append(f"{masses[weight]},{arm},,,,,{again}aim at {aim} rpm")
    return "\n".join(lines) + "\n"


def _shown(
    texts: Sequence[str], kind: str, unit: str, option: str, digits: int
) -> list[str]:
    """Write the values of an option in one unit, with at least `digits` digits."""
    from gyrodata.quantities.notation import parse_quantity
    from gyrodata.quantities.units import UnitError, from_si

    shown = []
    if not texts:
        refuse("template_nothing_given", option=option, example=_EXAMPLES[kind])
    for text in dict.fromkeys(texts):
        try:
            value = from_si(parse_quantity(text, kind), unit, kind)
        except UnitError as error:
            refuse("template_value_unfit", option=option, error=error, hint=error.hint)
        if kind != "length" and value <= 0:
            refuse("template_not_above_zero", option=option, text=text)
        short = f"{value:.10g}"
        shown.append(
            short if len(short.partition(".")[2]) >= digits else f"{value:.{digits}f}"
        )
    return shown


def _workbook(text: str) -> bytes:
    """Return a blank log as a workbook.

    The constants are in rows of two cells, and a row of headers contains the units.
    """
    from openpyxl import Workbook
    from openpyxl.styles import Font

    workbook = Workbook()
    sheet = workbook.active
    for line in text.splitlines():
        if line.endswith(": "):
            sheet.append([line.rstrip(), ""])
        else:
            sheet.append([line] if line.startswith("#") else next(csv.reader([line])))
    header = next(row for row in sheet if row[0].value == "mass [g]")
    for cell in header:
        cell.font = Font(bold=True)
        sheet.column_dimensions[cell.column_letter].width = 18
        # Excel shows as many digits as the instruments; turns are text, because Excel
        # makes a date of 1/3.
        form = {
            "mass [g]": "0.00",
            "position [cm]": "0.0",
            "time [s]": "0.00",
            "turns": "@",
        }.get(cell.value, "General")
        for row in range(cell.row + 1, sheet.max_row + 1):
            below = sheet.cell(row, cell.column)
            below.number_format = form
            if form.startswith("0") and below.value:
                below.value = float(below.value)
    sheet.freeze_panes = sheet.cell(header[0].row + 1, 1)
    data = io.BytesIO()
    workbook.save(data)
    return data.getvalue()


def check(
    logs: Annotated[list[str], typer.Argument(metavar="LOG")],
    hand_in: Annotated[bool, typer.Option("--hand-in")] = False,
    fix: Annotated[bool, typer.Option("--fix")] = False,
    together: Annotated[bool, typer.Option("--together")] = False,
    form: Annotated[CheckFormat, typer.Option("--format", "-f")] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    exit_zero: Annotated[bool, typer.Option("--exit-zero")] = False,
) -> None:
    """Check a log while you can still repeat or add runs.

    Exit codes: 0 nothing wrong (there may be advice); 1 something is wrong, or with
    --hand-in the answer is missing or not unique; 2 wrong use, or a log that cannot be
    read; 3 a fault of gyro.
    """
    if hand_in and any((settings, mapping, config, fix, together, "-" in logs)):
        refuse("hand_in_as_it_is")
    if hand_in:
        worst = _print(_check_submission(logs), form)
    else:
        named = list(zip(logs, names_of(logs), strict=True))
        parts = _parts(named, fix, together)
        if form == "json" and len(parts) > 1:
            refuse("json_for_one_log")
        options = {
            "settings": pairs(settings, "--set"),
            "mapping": pairs(mapping, "--map"),
        }
        codes = [_check_part(part, options, config, fix, form) for part in parts]
        worst = max(codes)
    raise typer.Exit(worst if worst != 1 else int(not exit_zero))


def _parts(
    named: list[tuple[str, str]], fix: bool, together: bool
) -> list[list[tuple[str, str]]]:
    """Return the logs that are checked together, each with its name."""
    if fix and "-" in [log for log, _ in named]:
        refuse("fix_of_standard_input")
    return [named] if together else [[each] for each in named]


def _check_part(
    named: Sequence[tuple[str, str]],
    options: dict[str, Any],
    config: Path | None,
    fix: bool,
    form: CheckFormat,
) -> int:
    """Print what is found in a log, or in several together; return the exit code."""

    def read() -> Readings:
        from gyrodata.readings import read_log
        from gyrodata.readings.together import read_together

        return read_together(
            [
                read_log(
                    **source_of(*each), **options, config=constants_of(each[0], config)
                )
                for each in named
            ]
        )

    checked = check_log(" + ".join(name for _, name in named), read)
    worst = _print(checked, form)
    return max([worst, *_fixed(named, checked, form)]) if fix else worst


def _fixed(
    named: Sequence[tuple[str, str]], checked: Checked, form: CheckFormat
) -> Iterator[int]:
    """Write each checked log as it was understood; yield the exit codes."""
    readings = checked.readings
    if readings is None:
        return
    files = [file for _, file in readings.files] or [readings]
    for (log, _), file in zip(named, files, strict=True):
        try:
            _fix(Path(log), file, form)
        except InputError as error:
            complain(error.diagnostics)
            yield error.exit_code


def _fix(log: Path, readings: Readings, form: CheckFormat) -> None:
    """Write a log as it was understood next to it, and list what is left to fill in."""
    from gyrodata.readings import fixed_log

    fixed = log.with_name(
        f"{log.name.removesuffix('.gz').rpartition('.')[0] or log.name}-fixed.csv"
    )
    if not readings.runs or not readings.columns:
        refuse("fix_without_runs", fixed=fixed, log=readings.name)
    text, left = fixed_log(readings)
    try:
        if fixed.exists() and fixed.read_text("utf-8", "replace") != text:
            refuse("fixed_exists", fixed=fixed)
        write_whole(fixed, [text.encode()])
    except OSError as error:
        refuse("fixed_not_written", fixed=fixed, why=error.strerror or error)
    todo = f"left for you: {len(left)}" if left else "nothing is left to correct"
    typer.echo(
        "\n   ".join(
            [f"{fixed}: {readings.name} as gyro understood it; {todo}", *left]
        ),
        err=form != "text",
    )


def check_log(
    name: str, read: Callable[[], Readings], options: Options | None = None
) -> Checked:
    """Read and analyse a log, and list what it lacks; an error is a finding."""
    from gyrodata import analysis as story

    try:
        readings = read()
        analysis, findings = story.check_log(readings, options)
    except GyroError as error:
        return Checked(name, error.diagnostics, error.exit_code)
    except Exception as error:
        return Checked(name, (fault(error, name),), FAULT)
    has_doubts = analysis is not None and bool(analysis.doubts)
    code = int(has_doubts or _is_serious(findings))
    in_order = sorted(findings, key=_place)
    if readings.files:
        in_order.sort(key=lambda finding: finding.file or "")
    return Checked(name, in_order, code, readings, analysis)


def _check_submission(paths: Sequence[str]) -> Checked:
    """Read a submission as a grader would; an error is a finding.

    Missing runs are not listed: they cannot be measured any more.
    """
    from gyrodata.grading.grade import read_hand_in

    name = names_of(paths)[0]
    try:
        readings, hand_in, of_submission = read_hand_in([Path(path) for path in paths])
    except GyroError as error:
        return Checked(name, error.diagnostics, error.exit_code)
    except Exception as error:
        return Checked(name, (fault(error, name),), FAULT)
    of_log = sorted(readings.diagnostics, key=_place)
    findings = (*of_log, *sorted(of_submission, key=_place))
    code = int(_is_serious(findings))
    return Checked(readings.name, findings, code, readings, hand_in=hand_in)


def _place(finding: Diagnostic) -> tuple[int, int]:
    return finding.line or 0, finding.column or 0


def _is_serious(findings: Sequence[Diagnostic]) -> bool:
    """Return whether a finding is more than a note or advice."""
    from gyrodata.judging.procedure import ADVICE

    return any(
        finding.severity != "note" and finding.code not in ADVICE
        for finding in findings
    )


def _print(checked: Checked, form: CheckFormat) -> int:
    """Print what a check found, and return its exit code."""
    from gyrodata.reporting.data import json_text
    from gyrodata.results import CheckDocument, Input, to_json

    if form == "text":
        write_text(str(checked))
        return checked.code
    readings = checked.readings
    doubts = checked.analysis.doubts if checked.analysis else ()
    only_notes = all(finding.severity == "note" for finding in checked.findings)
    document = CheckDocument(
        input=Input(checked.name, readings.sha256 if readings else None, checked.rows),
        clean=not doubts and only_notes,
        doubts=doubts,
        diagnostics=tuple([finding.to_dict() for finding in checked.findings]),
        hand_in=checked.hand_in,
    )
    write_out(json_text(to_json(document), indent=2 if form == "json" else None))
    return checked.code
