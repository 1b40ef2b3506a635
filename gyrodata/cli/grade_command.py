"""``gyro grade``: a class, from what was handed in to grades, feedback and flags."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gyrodata.cli.terminal import complain, progress_bar, refuse, write_out
from gyrodata.diagnostics import (
    GRADES_WITHIN_CLASS,
    NOTHING_TO_GRADE,
    OPTION_FILE_CANNOT_BE_READ,
    OPTION_NEEDS_A_FOLDER,
)

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.desk import Change, Gradebooks
    from gyrodata.grading.exports.sheet import Filled
    from gyrodata.grading.run import GradingOptions


SHOWN = 20
"""Changes that are told; all of them with --dry-run."""


class GradeFormat(StrEnum):
    """What is written to standard output."""

    text = "text"
    json = "json"
    ndjson = "ndjson"
    csv = "csv"


class Platform(StrEnum):
    """Whose names the files have."""

    auto = "auto"
    folder = "folder"
    canvas = "canvas"
    moodle = "moodle"
    blackboard = "blackboard"
    gradescope = "gradescope"


class Attempt(StrEnum):
    """Which of several attempts is graded."""

    newest = "newest"
    oldest = "oldest"


@dataclass(frozen=True)
class _Request:
    """What one call of ``gyro grade`` asks for."""

    rubric: Path | None
    lms: Platform
    pattern: str | None
    attempts: Attempt
    out: Path | None
    workers: int | None
    timeout: float
    gradebook: Path | None
    assignment: str | None
    worksheet: Path | None
    figures: bool
    partners: Path | None
    dry_run: bool
    form: GradeFormat
    quiet: bool


def grade(
    path: Annotated[Path | None, typer.Argument(metavar="PATH", help="Folder or zip of the class.")] = None,
    rubric: Annotated[
        Path | None, typer.Option("--rubric", metavar="FILE", help="TOML file; begin with --print-rubric.")
    ] = None,
    print_rubric: Annotated[bool, typer.Option("--print-rubric", help="Print the rubric, to be changed.")] = False,
    lms: Annotated[Platform, typer.Option("--lms", help="Whose names the files have.")] = Platform.auto,
    pattern: Annotated[
        str | None,
        typer.Option("--pattern", metavar="REGEX", help=r"Names of one's own, such as '(?P<student>\w+)_lab\.csv'."),
    ] = None,
    attempts: Annotated[Attempt, typer.Option("--attempts", help="Which of several is graded.")] = Attempt.newest,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="Folder for the grades. "
                     "Default: NAME-grades, for --format text only."),
    ] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=1, max=256, help="Processes. Default: one for each processor.")
    ] = None,
    timeout: Annotated[
        float, typer.Option("--timeout", metavar="SECONDS", min=0.1, help="Time for one submission.")
    ] = 30.0,
    gradebook: Annotated[
        Path | None, typer.Option("--gradebook", metavar="FILE", help="Canvas gradebook to fill: canvas.csv.")
    ] = None,
    assignment: Annotated[
        str | None, typer.Option("--assignment", metavar="TITLE", help="Its column, where it has several.")
    ] = None,
    worksheet: Annotated[
        Path | None, typer.Option("--worksheet", metavar="FILE", help="Moodle grading worksheet to fill: moodle.csv.")
    ] = None,
    gradescope: Annotated[
        Path | None, typer.Option("--gradescope", metavar="DIR", help="Write an autograder for Gradescope, and stop.")
    ] = None,
    figures: Annotated[bool, typer.Option("--figures", help="Figures in the feedback.")] = False,
    partners: Annotated[
        Path | None,
        typer.Option("--partners", metavar="FILE", help="Who hands in the same data: 'alice, bob' in a line."),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Write nothing, and say what would change.")] = False,
    form: Annotated[
        GradeFormat, typer.Option("--format", "-f", help="What to write to standard output.")
    ] = GradeFormat.text,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only errors on standard error.")] = False,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even when some are not graded.")] = False,
) -> None:  # fmt: skip
    """Grade a class: each student against their own data, with feedback for everybody and a page of the class.

    A second run grades only what has changed, and says why. Exit codes: 0 done; 1 done, with submissions that could
    not be graded; 2 usage, a rubric with a mistake, or a class that cannot be read; 130 stopped by Ctrl-C.
    """
    request = _Request(
        rubric=rubric, lms=lms, pattern=pattern, attempts=attempts, out=out, workers=workers, timeout=timeout,
        gradebook=gradebook, assignment=assignment, worksheet=worksheet, figures=figures, partners=partners,
        dry_run=dry_run, form=form, quiet=quiet,
    )  # fmt: skip
    if print_rubric:
        write_out(_rubric_text(rubric))
        return
    if gradescope is not None:
        _write_autograder(gradescope, rubric)
        _tell([f"autograder: zip the files in {gradescope}, without a folder around them, and upload that"])
        return
    if path is None:
        refuse(NOTHING_TO_GRADE, "there is nothing to grade: no PATH is given", "give the class, a folder or a zip")
    found = _grade_class(path, request)
    lost = len(found.totals) < len(found.grades)
    raise typer.Exit(1 if lost and not exit_zero else 0)


def autograde(
    root: Annotated[Path, typer.Argument(metavar="ROOT", help="What Gradescope lays down.")] = Path("/autograder"),
) -> None:
    """Grade the one submission that a running autograder of Gradescope has; called by its run_autograder."""
    from gyrodata.grading.exports.gradescope import grade_autograder
    from gyrodata.grading.journal import write_whole

    write_whole(root / "results" / "results.json", [grade_autograder(root).encode()])


# --- the story ----------------------------------------------------------------------------------------------


def _grade_class(path: Path, request: _Request) -> ClassGrades:
    """Grade, say what changes, write what was asked for, and print."""
    from gyrodata.grading.desk import changes_in
    from gyrodata.grading.forensics import read_exemptions
    from gyrodata.grading.rubric import read_rubric
    from gyrodata.grading.run import grade_class
    from gyrodata.grading.submissions import find_submissions

    name = "built-in rubric" if request.rubric is None else request.rubric.name
    rubric = read_rubric(_rubric_text(request.rubric).encode("utf-8", "surrogateescape"), name)
    submissions = find_submissions(path, request.lms.value, request.pattern, request.attempts.value)
    folder = _folder(path, request)
    gradebooks = _gradebooks(request)
    gradebooks.try_out(submissions, rubric)
    complain(submissions.diagnostics, request.quiet)
    exempt = None
    if request.partners is not None:
        exempt = read_exemptions(request.partners, submissions.aliases)
        complain(exempt.diagnostics, request.quiet)
    options = _options(folder, len(submissions.items), request)
    try:
        found = grade_class(submissions, rubric, options, exempt)
        changes = changes_in(folder, found) if folder is not None else ()
        filled = gradebooks.fill(found.grades, found.ids)
        if not request.quiet:
            _tell(_told(found, options), _told_changes(changes, request.dry_run), _told_filled(filled))
        if folder is not None and not request.dry_run:
            _write(found, folder, filled, options, request.quiet)
    except KeyboardInterrupt:
        told = "what was done is kept, and the same command goes on from there"
        kept = options.journal is not None and options.keep
        _tell([f"{chr(10) if options.progress else ''}stopped; {told if kept else 'nothing is kept'}"])
        raise typer.Exit(130) from None
    _print(found, changes if request.dry_run else None, request.form)
    return found


def _rubric_text(path: Path | None) -> str:
    """Give the rubric as it was written; bytes that are no text are for the reader to refuse."""
    from gyrodata.grading.rubric import default_rubric_text

    return default_rubric_text() if path is None else _read(path).decode("utf-8", "surrogateescape")


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        refuse(OPTION_FILE_CANNOT_BE_READ, f'"{path}" cannot be read: {error.strerror or error}', "check its name")


def _write_autograder(folder: Path, rubric: Path | None) -> None:
    """Write what is to be zipped for Gradescope, the scripts executable, once the rubric is known to be good."""
    from gyrodata.grading.exports.gradescope import autograder_files
    from gyrodata.grading.journal import write_whole
    from gyrodata.grading.rubric import read_rubric

    data = _rubric_text(rubric).encode("utf-8", "surrogateescape")
    read_rubric(data, "rubric.toml" if rubric is None else rubric.name)
    for name, text in autograder_files(data.decode()).items():
        write_whole(folder / name, [text.encode()])
        if not name.endswith(".toml"):
            (folder / name).chmod(0o755)


def _folder(path: Path, request: _Request) -> Path | None:
    """Say where the grades go, never into the class, where they would be taken for a student's; None for nowhere."""
    home = path.resolve()
    if request.out is not None:
        if request.out.resolve().is_relative_to(home):
            hint = f"write beside it: --out {home.name}-grades"
            refuse(GRADES_WITHIN_CLASS, f'"{request.out}" is in the class, and would be graded with it', hint)
        return request.out
    if request.form is GradeFormat.text or request.dry_run:
        folder = Path(f"{home.stem if home.suffix.lower() == '.zip' else home.name}-grades")
        return home.parent / folder if Path.cwd().is_relative_to(home) else folder
    asked = [("--figures", request.figures), ("--gradebook", request.gradebook), ("--worksheet", request.worksheet)]
    for option, given in asked:
        if given:
            refuse(
                OPTION_NEEDS_A_FOLDER,
                f"{option} needs a folder to write to, and --format {request.form} has none",
                "add --out DIR",
            )
    return None


def _gradebooks(request: _Request) -> Gradebooks:
    from gyrodata.grading.desk import Gradebooks

    canvas, moodle = request.gradebook, request.worksheet
    return Gradebooks(
        canvas=None if canvas is None else _read(canvas),
        canvas_name="" if canvas is None else canvas.name,
        assignment=request.assignment,
        moodle=None if moodle is None else _read(moodle),
        moodle_name="" if moodle is None else moodle.name,
    )


def _options(folder: Path | None, count: int, request: _Request) -> GradingOptions:
    """Say how the class is graded."""
    import time

    from gyrodata.grading.desk import FIGURES, JOURNAL
    from gyrodata.grading.journal import Journal
    from gyrodata.grading.run import GradingOptions
    from gyrodata.workers import count_workers

    return GradingOptions(
        workers=request.workers or count_workers(),
        limit=request.timeout,
        journal=None if folder is None else Journal(folder / JOURNAL),
        keep=not request.dry_run,
        figures=folder / FIGURES if folder is not None and request.figures and not request.dry_run else None,
        progress=None if request.quiet else progress_bar(count, time.monotonic, "graded "),
    )


def _write(
    found: ClassGrades, folder: Path, filled: Mapping[str, Filled], options: GradingOptions, quiet: bool
) -> None:
    """Write the folder of the grades."""
    import time

    from gyrodata.grading.desk import write_results
    from gyrodata.grading.feedback import write_feedback

    write_results(found, folder, filled)
    bar = None if quiet else progress_bar(len(found.grades), time.monotonic, "feedback ")
    lost = write_feedback(found, folder, options, bar)
    _tell(lost)
    if not quiet:
        _tell([f"grades: {folder / 'grades.csv'}", f"class: {folder / 'class.html'}"])


def _print(found: ClassGrades, changes: Sequence[Change] | None, form: GradeFormat) -> None:
    from gyrodata.grading.exports.grades_json import grade_lines, grades_document
    from gyrodata.grading.exports.summary import class_summary

    if form is GradeFormat.text:
        parts = class_summary(found)
    elif form is GradeFormat.csv:
        parts = iter([found.table])
    else:
        parts = grades_document(found, changes) if form is GradeFormat.json else grade_lines(found)
    for part in parts:
        write_out(part)


# --- what is said on the way --------------------------------------------------------------------------------


def _tell(*groups: Iterable[str]) -> None:
    for line in chain.from_iterable(groups):
        typer.echo(line, err=True)


def _told(found: ClassGrades, options: GradingOptions) -> Iterator[str]:
    """Say who was graded in this run, and why."""
    from gyrodata.readings import listing

    reasons: dict[str, list[str]] = {}
    for student, why in found.again.items():
        reasons.setdefault(why, []).append(found.names[student])
    for why, students in reasons.items():
        yield f"graded {len(students)} ({why}): {listing(students, 5)}"
    known = len(found.grades) - len(found.again)
    if known:
        yield f"kept {known} as graded before"
    if options.journal is not None and options.journal.damaged:
        yield str(options.journal.torn())


def _told_changes(changes: Sequence[Change] | None, dry_run: bool) -> Iterator[str]:
    """Say what changes in the table of grades that is there."""
    from gyrodata.grading.desk import BEFORE, TABLE

    kept = "" if dry_run else f"; what it was is kept as {BEFORE}"
    if changes is None:
        yield f"{TABLE} is there and is no table of grades as gyro writes it{kept}"
    elif changes:
        would = "would change" if dry_run else "changes"
        yield f"{TABLE} {would} for {len(changes)}{kept}:"
        shown = changes if dry_run else changes[:SHOWN]
        yield from (f"  {change}" for change in shown)
        if len(changes) > len(shown):
            yield f"  and {len(changes) - len(shown)} more"
    elif dry_run:
        yield f"{TABLE} would not change, or is not there yet"


def _told_filled(filled: Mapping[str, Filled]) -> Iterator[str]:
    """Say what stands in a gradebook now, what stood there before, and who is not in it."""
    from gyrodata.readings import listing

    for name, sheet in filled.items():
        yield f"{name}: {len(sheet.filled)} filled, {len(sheet.changed)} of them changed, {len(sheet.skipped)} not"
        yield from (f"  {student}: {before} → {after}" for student, before, after in sheet.changed)
        reasons: dict[str, list[str]] = {}
        for who, why in sheet.skipped:
            reasons.setdefault(why, []).append(who)
        yield from (f"  {why}: {listing(people, 10)}" for why, people in reasons.items())
