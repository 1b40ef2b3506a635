"""``gyro template``: a log to fill in. ``gyro check``: what a log still lacks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer

from gyrodata.base import diagnostics
from gyrodata.base.errors import Diagnostic, InputError
from gyrodata.cli.new_table import shown, write_new, write_table
from gyrodata.cli.options import (
    ConfigOption,
    MappingOption,
    Reader,
    SettingsOption,
    input_of,
    list_option,
    quantity_option,
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


def template(
    weights: Annotated[
        Any,
        list_option("--weights", "mass", "above zero", words="Masses of the weights."),
    ] = "20g,40g,60g",
    position: Annotated[
        Any,
        quantity_option(
            "--position", "length", words="Position of the weights on the rod."
        ),
    ] = "15cm",
    spins: Annotated[
        Any, list_option("--spins", "rate", "above zero", words="Spins to aim for.")
    ] = "200,400,600rpm",
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="Write this file, such as log.xlsx or log.csv.",
        ),
    ] = None,
) -> None:
    r"""Write a blank log: each weight with every spin, and a run without a weight.

    The spins alternate. Without --out, the log is printed as CSV.

    Example:  gyro template --weights 20g,40g,60g \
                --position 15cm --spins 200,400,600rpm \
                --out log.xlsx
    """
    text = blank_log(weights, position, spins)
    write_table(out or Path("-"), text)


def blank_log(weights: Sequence[float], position: float, spins: Sequence[float]) -> str:
    """Write a log to fill in, with each weight at each spin.

    The log also contains a run without a weight, and the first run again.

    The weights take turns, and the second half of the runs is the first half backwards:
    a drift of the balance during the session does not look like an effect of the
    torque.

    Parameters
    ----------
    weights : sequence of float
        Masses [kg]; repeats are kept once.
    position : float
        Position of the weights [m].
    spins : sequence of float
        Spins to aim at [rad/s]. They are in the notes: the column is for the spins that
        are read.

    Returns
    -------
    str
        CSV text that `read_log` reads without a diagnostic when spin, time and turns
        are filled in.
    """
    # The values have the digits that a scale and a ruler show.
    masses = [shown(mass, "mass", "g", 2) for mass in dict.fromkeys(weights)]
    arm = shown(position, "length", "cm", 1)
    aims = [shown(spin, "rate", "rpm", 0) for spin in dict.fromkeys(spins)]
    head = Path(__file__).with_name("blank_log.csv").read_text(encoding="utf-8")
    lines = head.splitlines()
    notes = {mass: _notes(aims, first) for first, mass in enumerate(masses)}
    notes["0"] = iter([f"no weight on the rod; aim at {aims[len(aims) // 2]} rpm"])
    half = masses * (len(aims) // 2)
    middle = [*masses * (len(aims) % 2), masses[0]]
    middle.insert((len(middle) + 1) // 2, "0")
    for mass in (*half, *middle, *reversed(half)):
        position_cell = arm if mass != "0" else ""
        lines.append(f"{mass},{position_cell},,,,,{next(notes[mass])}")
    lines.append("")
    return "\n".join(lines)


def _notes(aims: Sequence[str], first: int) -> Iterator[str]:
    """Yield the notes about the spins of a weight, which begin with another for each."""
    for turn in range(len(aims)):
        yield f"aim at {aims[(first + turn) % len(aims)]} rpm"
    yield f"the first run once more; aim at {aims[first % len(aims)]} rpm"


def check(
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
        worst = checked.code
    else:
        if fix and "-" in logs:
            refuse("fix_of_standard_input")
        parts = in_parts(logs, together, form)
        reader = Reader.of_options(settings, mapping, config)
        worst = max([_check_part(part, reader, fix, form) for part in parts])
    finish(worst, exit_zero)


def _check_part(logs: Sequence[Log], reader: Reader, fix: bool, form: str) -> int:
    """Print what is found in a log, or in several together; return the exit code."""
    name = " + ".join(log.name for log in logs)
    checked = check_log(name, partial(reader.read, logs))
    write_answer(form, checked.to_dict(), checked)
    readings = checked.readings
    worst = checked.code
    if not fix or readings is None:
        return worst
    files = [file for _, file in readings.files] or [readings]
    for log, file in zip(logs, files, strict=True):
        try:
            _fix(Path(log.path), file, form)
        except InputError as error:
            complain(error.diagnostics)
            worst = max(worst, error.exit_code)
    return worst


def _fix(log: Path, readings: Readings, form: str) -> None:
    """Write a log as it was understood next to it, and list what is left to fill in."""
    from gyrodata.readings import fixed_log

    fixed = log.with_name(f"{stem_of(log)}-fixed.csv")
    if not readings.runs or not readings.columns:
        refuse("fix_without_runs", fixed=fixed, log=readings.name)
    text, left = fixed_log(readings)
    write_new(fixed, text.encode())
    head = f"{fixed}: {readings.name} as gyro understood it; left for you: "
    lines = [f"{head}{len(left) or 'nothing'}", *left]
    typer.echo("\n   ".join(lines), err=form != "text")


def check_log(
    name: str, read: Callable[[], Readings], options: Options | None = None
) -> Checked:
    """Read and analyse a log, and list what it lacks; an error is a finding."""
    from gyrodata import analysis as story

    try:
        readings = read()
        analysis, findings = story.check_log(readings, options)
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
    answer = diagnostics.REMARK, hand_in.file, hand_in.line
    others = [
        finding
        for finding in readings.diagnostics
        if (finding.code, finding.file, finding.line) != answer
    ]
    of_log = sorted(others, key=place)
    findings = (*of_log, *sorted(of_submission, key=place))
    code = int(_is_serious(findings))
    return Checked(readings.name, findings, code, readings, hand_in=hand_in)


def _is_serious(findings: Sequence[Diagnostic]) -> bool:
    """Return whether a finding is more than a note or advice."""
    from gyrodata.judging.procedure import ADVICE

    return any(
        finding.severity != "note" and finding.code not in ADVICE
        for finding in findings
    )
