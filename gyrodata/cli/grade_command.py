"""``gyro grade``: a class, from the submissions to grades, feedback and flags."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import typer
from msgspec.structs import replace
from typer import Argument, Option

from gyrodata.base.disk import alone_in, telling, write_whole
from gyrodata.cli.terminal import (
    complain,
    progress_bar,
    refuse,
    tell,
    write_out,
    write_text,
)

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.exports import Change
    from gyrodata.grading.exports.gradebooks import Filled
    from gyrodata.grading.forensics import Fingerprint
    from gyrodata.grading.ledger import Desk, Known
    from gyrodata.grading.roster import Roster
    from gyrodata.grading.rubric import Rubric
    from gyrodata.grading.submissions import Submissions


Form = Literal["text", "json", "ndjson", "csv"]
Platform = Literal[
    "auto", "folder", "canvas", "moodle", "blackboard", "brightspace", "gradescope"
]


def grade(
    path: Annotated[Path | None, Argument(metavar="PATH")] = None,
    rubric: Annotated[Path | None, Option("--rubric", metavar="FILE")] = None,
    print_rubric: Annotated[
        Literal["simple", "full", "manual"] | None, Option("--print-rubric")
    ] = None,
    lms: Annotated[Platform, Option("--lms", metavar="PLATFORM")] = "auto",
    attempts: Annotated[Literal["newest", "oldest"], Option("--attempts")] = "newest",
    out: Annotated[Path | None, Option("--out", "-o", metavar="DIR")] = None,
    workers: Annotated[int | None, Option("--workers", min=0, max=256)] = None,
    cluster: Annotated[str | None, Option("--cluster", metavar="ADDRESS")] = None,
    timeout: Annotated[float, Option("--timeout", metavar="SECONDS", min=0.1)] = 30.0,
    gradebook: Annotated[Path | None, Option("--gradebook", metavar="FILE")] = None,
    assignment: Annotated[str | None, Option("--assignment", metavar="TITLE")] = None,
    gradescope: Annotated[Path | None, Option("--gradescope", metavar="DIR")] = None,
    roster: Annotated[Path | None, Option("--roster", metavar="FILE")] = None,
    previous: Annotated[list[Path] | None, Option("--previous", metavar="DIR")] = None,
    anonymous: Annotated[bool, Option("--anonymous")] = False,
    dry_run: Annotated[bool, Option("--dry-run")] = False,
    form: Annotated[Form, Option("--format", "-f")] = "text",
    quiet: Annotated[bool, Option("--quiet", "-q")] = False,
    exit_zero: Annotated[bool, Option("--exit-zero")] = False,
) -> None:
    """Grade a class: each student against their own data.

    Everybody gets feedback, and there is a page of the class.

    A second run grades only what has changed, and says why. Decide in class.html in the
    folder of the grades, and save desk.csv there; or write this file yourself, with lines
    of the file desk-todo.csv and the columns student,what,value,by,why.

    Exit codes: 0 done; 1 done, with submissions that could not be graded; 2 usage, a
    rubric or desk.csv with a mistake, or a class that cannot be read; 130 stopped by
    Ctrl-C.
    """
    if print_rubric:
        from gyrodata.grading.rubric import default_rubric_text

        write_out(default_rubric_text(print_rubric))
        return
    if gradescope is not None:
        tell(*_write_autograder(gradescope, rubric))
        return
    if path is None:
        refuse("nothing_to_grade")
    folder = _folder(path, out, form, dry_run, gradebook is not None)
    from gyrodata.base.workers import count_workers
    from gyrodata.grading import classroom, output, submissions
    from gyrodata.grading.rubric import read_rubric, unknown_exceptions

    judged = read_rubric(*_rubric(rubric))
    listed = submissions.list_submissions(path.absolute(), lms, attempts)
    book = _read_gradebook(gradebook, assignment, listed, judged)
    people = _read_roster(roster or gradebook, listed)
    # Decisions are used too if the grades are only printed.
    home = folder or _usual_folder(path.resolve())
    desk = _read_desk(home, people.who_is_meant(listed.items), judged)
    complain((*listed.diagnostics, *unknown_exceptions(judged, listed)), quiet)
    target = None if dry_run else folder
    options = classroom.GradingOptions(
        workers=count_workers() if workers is None else workers,
        limit=timeout,
        cluster=_executor_of(cluster) if cluster else None,
        journal=None if folder is None else folder / classroom.JOURNAL,
        keep=not dry_run,
    )
    years = _earlier(previous or [])
    with ExitStack() as at_work:
        if folder is not None:
            at_work.enter_context(telling(folder, "grades_not_written"))
        if target is not None:
            at_work.enter_context(alone_in(target, private=True))
        try:
            with progress_bar(len(listed.items), "graded", quiet) as progress:
                options = replace(options, progress=progress)
                grades = classroom.grade_class(
                    listed, judged, options, years, desk, people
                )
            complain(grades.submissions.diagnostics[len(listed.diagnostics) :], quiet)
            changes = _changes(grades, folder)
            filled = None if book is None else book.filled(grades, folder, desk)
            if not quiet:
                tell(*output.told_of(grades, changes, filled, dry_run).split("\n")[:-1])
            if target is not None:
                output.write_rubric(target, _rubric(rubric)[0])
                _write(grades, target, filled, quiet, anonymous)
        except KeyboardInterrupt:
            kept = "nothing is kept"
            if target:
                kept = "what was done is kept, and the same command goes on from there"
            tell(f"stopped; {kept}")
            raise typer.Exit(130) from None
    _print(grades, changes if dry_run else None, form)
    raise typer.Exit(1 if grades.count("not graded") and not exit_zero else 0)


class _Gradebook(NamedTuple):
    """The sheet of grades that a platform exported."""

    data: bytes
    name: str
    assignment: str | None

    def filled(self, grades: ClassGrades, folder: Path | None, desk: Desk) -> Filled:
        """Return the sheet with the grades in it."""
        from gyrodata.grading import output
        from gyrodata.grading.exports.gradebooks import fill_book

        ours = None
        if folder is not None:
            ours = output.totals_from_here(folder, desk, grades.names)
        book = self.data, self.name, grades.grades, self.assignment, grades.ids, ours
        return fill_book(*book)


def _read_gradebook(
    path: Path | None, assignment: str | None, listed: Submissions, rubric: Rubric
) -> _Gradebook | None:
    """Read a gradebook; one that cannot be filled stops gyro before it grades."""
    if path is None:
        return None
    from gyrodata.grading.exports.gradebooks import fill_book
    from gyrodata.grading.grade import not_graded

    book = _Gradebook(_read(path), path.name, assignment)
    fill_book(
        book.data,
        book.name,
        [not_graded(listed.items[0], rubric, "not yet")],
        assignment,
    )
    return book


def _read_roster(path: Path | None, listed: Submissions) -> Roster:
    from gyrodata.grading.roster import Roster, read_roster

    return Roster() if path is None else read_roster(_read(path), path.name, listed)


def _read_desk(home: Path, meant: Known, rubric: Rubric) -> Desk:
    """Read the decisions of people in the folder of the grades."""
    from gyrodata.grading import ledger

    desks = [desk for desk in (home / ledger.DESK, home / "desk.xlsx") if desk.exists()]
    if len(desks) > 1:
        refuse("two_desks", home=home)
    if not desks:
        return ledger.NO_DESK
    return ledger.read_desk(desks[0], _read(desks[0]), meant, rubric)


def _changes(grades: ClassGrades, folder: Path | None) -> Sequence[Change] | None:
    """Compare the table of grades with that of the last run.

    A table without a line, and no table, are not compared.
    """
    from gyrodata.grading import output
    from gyrodata.grading.exports import compare_tables

    table = folder / output.TABLE if folder is not None else None
    old = table.read_bytes() if table is not None and table.is_file() else b""
    return compare_tables(old, grades.table.encode("utf-8", "replace")) if old else ()


def _write(
    grades: ClassGrades,
    folder: Path,
    filled: Filled | None,
    quiet: bool,
    anonymous: bool,
) -> None:
    """Write the results and the feedback of a class."""
    from gyrodata.grading import output

    written = list(output.write_results(grades, folder, filled, anonymous))
    shown = grades.without_names() if anonymous else grades
    tell(*output.write_feedback(shown, folder))
    if not quiet:
        tell(*written)


def _print(grades: ClassGrades, changes: Sequence[Change] | None, form: Form) -> None:
    """Print the grades in a format."""
    from gyrodata.grading.exports import grade_lines, grades_document

    if form == "text":
        write_text(grades.summary)
    elif form == "csv":
        write_out(grades.table)
    elif form == "json":
        for part in grades_document(grades, changes):
            write_out(part)
    else:
        for line in grade_lines(grades):
            write_out(line)


def autograde(
    root: Annotated[
        Path, Argument(metavar="ROOT", help="Folder of the autograder.")
    ] = Path("/autograder"),
) -> None:
    """Grade the one submission that a running autograder of Gradescope has.

    Called by its run_autograder.
    """
    from gyrodata.grading.exports.gradescope import grade_autograder
    from gyrodata.grading.rubric import read_rubric

    rubric = root / "source" / "rubric.toml"
    graded = grade_autograder(root, read_rubric(_read(rubric), rubric.name))
    with telling(root, "grades_not_written"):
        write_whole(root / "results" / "results.json", [graded.encode()])


# --- input ---


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        refuse("option_file_not_read", path=path, why=error.strerror or error)


def _rubric(path: Path | None) -> tuple[bytes, str]:
    """Read the text and the name of the rubric."""
    from gyrodata.grading.rubric import BUILT_IN, default_rubric_text

    kind = "full" if path is None else str(path)
    if path is None or (kind in BUILT_IN and not path.exists()):
        return default_rubric_text(kind).encode(), f"built-in rubric {kind}"
    return _read(path), path.name


def _executor_of(address: str) -> Executor:
    """Connect to a Dask cluster."""
    try:
        from distributed import Client

        executor: Executor = Client(address).get_executor()
    except (ImportError, OSError, ValueError) as error:
        refuse("cluster_unusable", address=address, error=error)
    return executor


def _earlier(years: Sequence[Path]) -> dict[str, Fingerprint]:
    """Read the logs of earlier years from the journals next to their grades."""
    from gyrodata.grading.classroom import JOURNAL, read_journal

    fingerprints: dict[str, Fingerprint] = {}
    for year in years:
        path = year / JOURNAL
        name = year.resolve().name
        entries = read_journal(_read(path) if path.exists() else b"")[0].items()
        kept = {
            f"{name}/{student}": fingerprint.grade.fingerprint
            for student, fingerprint in entries
            if fingerprint.grade.fingerprint
        }
        if not kept:
            refuse("previous_without_logs", year=year, journal=JOURNAL)
        fingerprints |= kept
    return fingerprints


def _write_autograder(folder: Path, path: Path | None) -> Iterator[str]:
    """Write the files for Gradescope, and say what to do there."""
    from gyrodata.grading.exports.gradescope import autograder_files
    from gyrodata.grading.rubric import read_rubric

    data, name = _rubric(path)
    rubric = read_rubric(data, name)
    files = autograder_files(rubric, data.decode("utf-8-sig"))
    with telling(folder, "grades_not_written"):
        for name, content in files.items():
            write_whole(folder / name, [content])
            if content.startswith(b"#!"):
                (folder / name).chmod(0o755)
    by_hand = [
        criterion for criterion in rubric.criteria if criterion.check == "manual"
    ]
    points = rubric.points - sum(criterion.points for criterion in by_hand)
    yield f"autograder: zip the files in {folder}, without a folder around them, and upload that"
    yield (
        f"in Gradescope: {points:g} autograder points, and a due date, after which all "
        f"feedback is shown"
    )
    yield from (
        f'in Gradescope: {judged.points:g} points for "{judged.title}" are given by hand'
        for judged in by_hand
    )


def _folder(
    path: Path, out: Path | None, form: Form, dry_run: bool, needed: bool
) -> Path | None:
    """Return the folder for the grades; None for no folder, unless it is needed.

    Grades in the folder of the class are refused: they would be taken for a student's.
    """
    home = path.resolve()
    if out is not None:
        if out.resolve().is_relative_to(home):
            beside = os.path.relpath(home.parent / _usual_folder(home).name)
            refuse("grades_within_class", out=out, beside=shlex.quote(beside))
        return out
    if form == "text" or dry_run:
        return _usual_folder(home)
    if needed:
        refuse("option_needs_folder", option="--gradebook", form=form)
    return None


def _usual_folder(home: Path) -> Path:
    folder = Path(f"{home.stem if home.suffix.lower() == '.zip' else home.name}-grades")
    return home.parent / folder if Path.cwd().is_relative_to(home) else folder
