"""``gyro grade``: a class, from the submissions to grades, feedback and flags."""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer
from typer import Argument, Option

from gyrodata.base.disk import alone_in, telling, write_whole
from gyrodata.cli.options import read_bytes
from gyrodata.cli.terminal import (
    complain,
    finish,
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
    from gyrodata.grading.ledger import Desk
    from gyrodata.grading.roster import Roster
    from gyrodata.grading.rubric import Rubric
    from gyrodata.grading.submissions import Submissions


def grade(
    *,
    path: Annotated[
        Path | None, Argument(metavar="PATH", help="Folder or zip of the class.")
    ] = None,
    rubric: Annotated[
        Path | None,
        Option(
            "--rubric",
            metavar="FILE",
            help="TOML file, or simple, full or manual; to change one, begin with "
            "--print-rubric.",
        ),
    ] = None,
    print_rubric: Annotated[
        Literal["simple", "full", "manual"] | None,
        Option(
            "--print-rubric",
            help="Print a rubric to begin with; without --rubric, gyro uses full.",
        ),
    ] = None,
    lms: Annotated[
        Literal[
            "auto",
            "folder",
            "canvas",
            "moodle",
            "blackboard",
            "brightspace",
            "gradescope",
        ],
        Option(
            "--lms",
            metavar="PLATFORM",
            help="Platform of the download: canvas, moodle, blackboard, brightspace, "
            "gradescope or folder.",
        ),
    ] = "auto",
    attempts: Annotated[
        Literal["newest", "oldest"],
        Option("--attempts", help="Which of several is graded."),
    ] = "newest",
    out: Annotated[
        Path | None,
        Option(
            "--out",
            "-o",
            metavar="DIR",
            help="Folder for the grades. Default: NAME-grades, for --format text only.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        Option(
            "--workers",
            min=0,
            max=256,
            help="Processes; 0: only this one, where nothing stops a submission that "
            "hangs. Default: one for each processor.",
        ),
    ] = None,
    cluster: Annotated[
        Any,
        Option(
            "--cluster",
            metavar="ADDRESS",
            parser=lambda address: _executor_of(address),
            help="Dask scheduler that grades on other machines.",
        ),
    ] = None,
    timeout: Annotated[
        float,
        Option(
            "--timeout", metavar="SECONDS", min=0.1, help="Time for one submission."
        ),
    ] = 30.0,
    gradebook: Annotated[
        Path | None,
        Option(
            "--gradebook",
            metavar="FILE",
            help="Gradebook exported from Canvas or Moodle, to fill with the grades.",
        ),
    ] = None,
    assignment: Annotated[
        str | None,
        Option(
            "--assignment",
            metavar="TITLE",
            help="Column of the gradebook, if there are several.",
        ),
    ] = None,
    gradescope: Annotated[
        Path | None,
        Option(
            "--gradescope",
            metavar="DIR",
            help="Write an autograder for Gradescope, and stop.",
        ),
    ] = None,
    roster: Annotated[
        Path | None,
        Option(
            "--roster",
            metavar="FILE",
            help="CSV: student, name, section, ta, station, partner. Default: the "
            "gradebook.",
        ),
    ] = None,
    previous: Annotated[
        list[Path] | None,
        Option(
            "--previous",
            metavar="DIR",
            help="Grades of an earlier year, to find copies of its logs.",
        ),
    ] = None,
    anonymous: Annotated[
        bool,
        Option(
            "--anonymous",
            help="Show ids instead of names in class.html and in the feedback.",
        ),
    ] = False,
    dry_run: Annotated[
        bool, Option("--dry-run", help="Write nothing, and say what would change.")
    ] = False,
    form: Annotated[
        Literal["text", "json", "ndjson", "csv"],
        Option("--format", "-f", help="What to write to standard output."),
    ] = "text",
    quiet: Annotated[
        bool, Option("--quiet", "-q", help="On standard error, print errors only.")
    ] = False,
    exit_zero: Annotated[
        bool, Option("--exit-zero", help="Exit with 0 even when some are not graded.")
    ] = False,
) -> None:
    """Grade a class: each student against their own data.

    Everybody gets feedback, and there is a page of the class.

    A second run grades only what has changed, and says why. Decide in class.html in the
    folder of the grades, and save desk.csv there; or write this file yourself, with lines
    of the file desk-todo.csv and the columns student,what,value,by,why.

    Exit codes: 0 done; 1 done, with submissions that could not be graded; 2 usage, a
    rubric or desk.csv with a mistake, or a class that cannot be read; 130 stopped by
    Ctrl-C.

    Example:  gyro grade class
              gyro grade --print-rubric simple > rubric.toml
              gyro grade class --rubric rubric.toml -o graded
    """
    if print_rubric:
        from gyrodata.grading.rubric import default_rubric_text

        write_out(default_rubric_text(print_rubric))
        return
    if gradescope is not None:
        _write_autograder(gradescope, rubric)
        return
    if path is None:
        refuse("nothing_to_grade")
    folder = _folder(path, out, form, dry_run, gradebook is not None)
    from gyrodata.base.workers import count_workers
    from gyrodata.grading import output
    from gyrodata.grading.classroom import JOURNAL, GradingOptions, grade_class
    from gyrodata.grading.rubric import unknown_exceptions
    from gyrodata.grading.submissions import list_submissions

    listed = list_submissions(path.absolute(), lms, attempts)
    inputs = _read_inputs(listed, rubric, gradebook, assignment, roster)
    earlier = _earlier(previous)
    complain((*listed.diagnostics, *unknown_exceptions(inputs.rubric, listed)), quiet)
    # Decisions are used too if the grades are only printed.
    home = folder or _usual_folder(path.resolve())
    desk = _read_desk(home, inputs, listed)
    target = None if dry_run else folder
    with _alone_in(target):
        with progress_bar(len(listed.items), "graded", quiet) as progress:
            options = GradingOptions(
                workers=count_workers() if workers is None else workers,
                limit=timeout,
                cluster=cluster,
                journal=folder and folder / JOURNAL,
                keep=not dry_run,
                progress=progress,
            )
            grades = grade_class(
                listed,
                inputs.rubric,
                options,
                previous=earlier,
                desk=desk,
                roster=inputs.roster,
            )
        complain(grades.submissions.diagnostics[len(listed.diagnostics) :], quiet)
        changes = _changes(grades, folder)
        filled = inputs.filled(grades, folder, desk)
        if not quiet:
            summary = output.describe_run(grades, changes, filled, dry_run)
            tell(*summary.splitlines())
        if target is not None:
            output.write_rubric(target, inputs.rubric_text)
            _write(grades, target, filled, quiet, anonymous)
    _print(grades, changes if dry_run else None, form)
    finish(int(grades.count("not graded") > 0), exit_zero)


@contextmanager
def _alone_in(folder: Path | None) -> Iterator[None]:
    """Be the only gyro that writes the grades, and say what is kept after Ctrl-C."""
    kept = "nothing is kept"
    with ExitStack() as stack:
        if folder is not None:
            kept = "what was done is kept, and the same command goes on from there"
            stack.enter_context(telling(folder, "grades_not_written"))
            stack.enter_context(alone_in(folder, private=True))
        try:
            yield
        except KeyboardInterrupt:
            tell(f"stopped; {kept}")
            raise typer.Exit(130) from None


class _Inputs(NamedTuple):
    """The rubric, gradebook and roster of a class."""

    rubric: Rubric
    rubric_text: bytes
    fill_book: Callable[..., Filled] | None
    """Writes grades into the sheet that a platform exported."""
    roster: Roster

    def filled(
        self, grades: ClassGrades, folder: Path | None, desk: Desk
    ) -> Filled | None:
        """Return the gradebook with the grades in it, if there is one."""
        from gyrodata.grading.output import totals_from_here

        if self.fill_book is None:
            return None
        ours = folder and totals_from_here(folder, desk, grades.names)
        return self.fill_book(grades=grades.grades, ids=grades.ids, ours=ours)


def _read_inputs(
    listed: Submissions,
    rubric: Path | None,
    gradebook: Path | None,
    assignment: str | None,
    roster: Path | None,
) -> _Inputs:
    """Read the files of the options: a wrong one stops gyro before it grades."""
    from gyrodata.grading.exports.gradebooks import fill_book
    from gyrodata.grading.grade import not_graded
    from gyrodata.grading.roster import Roster, read_roster
    from gyrodata.grading.rubric import read_rubric

    text, name = _rubric(rubric)
    judged = read_rubric(text, name)
    fill = None
    if gradebook is not None:
        fill = partial(
            fill_book, read_bytes(gradebook), gradebook.name, assignment=assignment
        )
        fill(grades=[not_graded(listed.items[0], judged, "not yet")])
    people = Roster()
    table = roster or gradebook
    if table is not None:
        people = read_roster(read_bytes(table), table.name, listed)
    return _Inputs(judged, text, fill, people)


def _read_desk(home: Path, inputs: _Inputs, listed: Submissions) -> Desk:
    """Read the decisions of people in the folder of the grades."""
    from gyrodata.grading.ledger import DESK, NO_DESK, read_desk

    desks = [desk for desk in (home / DESK, home / "desk.xlsx") if desk.exists()]
    if len(desks) > 1:
        refuse("two_desks", home=home)
    for copy in sorted(home.glob("desk*([0-9]*).csv")):
        refuse("desk_of_browser", home=home, name=copy.name)
    if not desks:
        return NO_DESK
    meant = inputs.roster.who_is_meant(listed.items)
    return read_desk(desks[0], read_bytes(desks[0]), meant, inputs.rubric)


def _changes(grades: ClassGrades, folder: Path | None) -> Sequence[Change] | None:
    """Compare the table of grades with that of the last run.

    A table without a line, and no table, are not compared.
    """
    from gyrodata.grading import output
    from gyrodata.grading.exports import compare_tables

    table = folder and folder / output.TABLE
    if not table or not table.is_file() or not table.stat().st_size:
        return ()
    new = grades.table.encode("utf-8", "replace")
    return compare_tables(table.read_bytes(), new)


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


def _print(grades: ClassGrades, changes: Sequence[Change] | None, form: str) -> None:
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


# --- input ---


def _rubric(path: Path | None) -> tuple[bytes, str]:
    """Read the text and the name of the rubric."""
    from gyrodata.grading.rubric import BUILT_IN, default_rubric_text

    kind = "full" if path is None else str(path)
    if path is None or (kind in BUILT_IN and not path.exists()):
        return default_rubric_text(kind).encode(), f"built-in rubric {kind}"
    return read_bytes(path), path.name


def _executor_of(address: str) -> Executor:
    """Connect to a Dask cluster."""
    try:
        from distributed import Client

        executor: Executor = Client(address).get_executor()
    except (ImportError, OSError, ValueError) as error:
        refuse("cluster_unusable", address=address, error=error)
    return executor


def _earlier(years: Sequence[Path] | None) -> dict[str, Fingerprint]:
    """Read the logs of earlier years from the journals next to their grades."""
    from gyrodata.grading.classroom import JOURNAL, read_journal

    fingerprints: dict[str, Fingerprint] = {}
    for year in years or ():
        path = year / JOURNAL
        name = year.resolve().name
        journal = read_bytes(path) if path.exists() else b""
        kept = {}
        for student, entry in read_journal(journal)[0].items():
            if entry.grade.fingerprint:
                kept[f"{name}/{student}"] = entry.grade.fingerprint
        if not kept:
            refuse("previous_without_logs", year=year, journal=JOURNAL)
        fingerprints |= kept
    return fingerprints


def _write_autograder(folder: Path, path: Path | None) -> None:
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
    manual = [part.points for part in rubric.criteria if part.check == "manual"]
    points = rubric.points - sum(manual)
    tell(
        f"autograder: zip the files in {folder}, without a folder around them, and upload that",
        f"in Gradescope: {points:g} autograder points, and a due date, after which all "
        f"feedback is shown",
    )


def _folder(
    path: Path, out: Path | None, form: str, dry_run: bool, needed: bool
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
