"""``gyro grade``: a class, from what was handed in to grades, feedback and flags."""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata import diagnostics
from gyrodata.cli.terminal import complain, progress_bar, refuse, tell, write_out
from gyrodata.disk import alone_in, telling, write_whole

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from gyrodata.grading.classroom import ClassGrades, GradingOptions
    from gyrodata.grading.exports import Change
    from gyrodata.grading.exports.gradebooks import Filled
    from gyrodata.grading.forensics import Fingerprint


SHOWN = 20
"""Changes that are told; all of them with --dry-run."""

Form = Literal["text", "json", "ndjson", "csv"]
Platform = Literal["auto", "folder", "canvas", "moodle", "blackboard", "gradescope"]


def grade(
    path: Annotated[Path | None, typer.Argument(metavar="PATH", help="Folder or zip of the class.")] = None,
    rubric: Annotated[
        Path | None, typer.Option("--rubric", metavar="FILE", help="TOML file; begin with --print-rubric.")
    ] = None,
    print_rubric: Annotated[
        Literal["simple", "full", "manual"] | None,
        typer.Option("--print-rubric", help="Print a rubric to begin with; without one, full holds."),
    ] = None,
    lms: Annotated[Platform, typer.Option("--lms", help="Platform the download comes from.")] = "auto",
    pattern: Annotated[
        str | None,
        typer.Option("--pattern", metavar="REGEX", help=r"Names of one's own, such as '(?P<student>\w+)\.csv'."),
    ] = None,
    attempts: Annotated[
        Literal["newest", "oldest"], typer.Option("--attempts", help="Which of several is graded.")
    ] = "newest",
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="DIR", help="Folder for the grades. "
                     "Default: NAME-grades, for --format text only."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=0, max=256, help="Processes; 0: only this one, where nothing stops a submission "
                     "that hangs. Default: one for each processor."),
    ] = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", metavar="ADDRESS", help="Dask scheduler that grades on other machines.")
    ] = None,
    timeout: Annotated[
        float, typer.Option("--timeout", metavar="SECONDS", min=0.1, help="Time for one submission.")
    ] = 30.0,
    gradebook: Annotated[
        Path | None,
        typer.Option("--gradebook", metavar="FILE", help="Gradebook exported from Canvas, Blackboard or Moodle, to "
                     "fill with the grades."),
    ] = None,
    assignment: Annotated[
        str | None, typer.Option("--assignment", metavar="TITLE", help="Column of the gradebook, if there are several.")
    ] = None,
    gradescope: Annotated[
        Path | None, typer.Option("--gradescope", metavar="DIR", help="Write an autograder for Gradescope, and stop.")
    ] = None,
    figures: Annotated[bool, typer.Option("--figures", help="Figures in the feedback.")] = False,
    roster: Annotated[
        Path | None,
        typer.Option("--roster", metavar="FILE", help="CSV: student, name, section, station, partner. "
                     "Default: the gradebook."),
    ] = None,
    previous: Annotated[
        list[Path] | None,
        typer.Option("--previous", metavar="DIR", help="Grades of an earlier year, to find copies of its logs."),
    ] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Write nothing, and say what would change.")] = False,
    form: Annotated[Form, typer.Option("--format", "-f", help="What to write to standard output.")] = "text",
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="On standard error, print errors only.")] = False,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even when some are not graded.")] = False,
) -> None:  # fmt: skip
    """Grade a class: each student against their own data, with feedback for everybody and a page of the class.

    A second run grades only what has changed, and says why. What you decide by hand is kept in desk.csv in the folder
    of the grades, with the columns student,what,value,by,why; desk-todo.csv there has lines to copy.

    Exit codes: 0 done; 1 done, with submissions that could not be graded or got no feedback; 2 usage, a rubric or
    desk.csv with a mistake, or a class that cannot be read; 130 stopped by Ctrl-C.
    """
    if print_rubric:
        from gyrodata.grading.rubric import default_rubric_text

        write_out(default_rubric_text(print_rubric))
        return
    if gradescope is not None:
        _tell(_write_autograder(gradescope, rubric))
        return
    if path is None:
        refuse(
            diagnostics.NOTHING_TO_GRADE,
            "there is nothing to grade: no PATH is given",
            "give the class, a folder or a zip",
        )
    need_one = ["--figures"] * figures + ["--gradebook"] * (gradebook is not None)
    folder = _folder(path, out, form, dry_run, need_one)
    from gyrodata.grading.classroom import GradingOptions, grade_class
    from gyrodata.grading.desk import FIGURES, Gradebooks, changes_in, find_desk, totals_from_here
    from gyrodata.grading.exports.gradebooks import platform_of
    from gyrodata.grading.journal import JOURNAL, Journal
    from gyrodata.grading.roster import Roster, read_roster
    from gyrodata.grading.rubric import read_rubric, unknown_exceptions
    from gyrodata.grading.submissions import find_submissions
    from gyrodata.workers import count_workers

    judged = read_rubric(_rubric_bytes(rubric), "built-in rubric" if rubric is None else rubric.name)
    submissions = find_submissions(path.absolute(), lms, pattern, attempts)
    sheets = {}
    if gradebook is not None:
        data = _read(gradebook)
        sheets[platform_of(data, gradebook.name)] = data, gradebook.name
    gradebooks = Gradebooks(sheets, assignment)
    gradebooks.try_out(submissions, judged)
    # Decisions are used too if the grades are only printed.
    listed = roster or gradebook
    people = Roster() if listed is None else read_roster(_read(listed), listed.name, submissions)
    desk = find_desk(folder or _usual_folder(path.resolve()), people.who_is_meant(submissions), judged)
    complain((*submissions.diagnostics, *unknown_exceptions(judged, submissions)), quiet)
    options = GradingOptions(
        workers=count_workers() if workers is None else workers,
        limit=timeout,
        cluster=_executor_of(cluster) if cluster else None,
        journal=None if folder is None else Journal(folder / JOURNAL),
        keep=not dry_run,
        figures=folder / FIGURES if folder is not None and figures and not dry_run else None,
        progress=None if quiet else progress_bar(len(submissions.items), time.monotonic, "graded "),
    )
    years = _earlier(previous or [])
    at_work = ExitStack()
    if folder is not None and not dry_run:
        with telling(folder, diagnostics.GRADES_FOLDER_CANNOT_BE_WRITTEN):
            at_work.enter_context(alone_in(folder, private=True))
    lost: Sequence[str] = ()
    try:
        found = grade_class(submissions, judged, options, years, desk, people)
        changes = changes_in(folder, found) if folder is not None else ()
        ours = totals_from_here(folder, desk, found.names) if folder is not None and sheets else None
        filled = gradebooks.fill(found.grades, found.ids, ours)
        if not quiet:
            _tell(_told(found, options), _told_changes(changes, dry_run), _told_filled(filled))
        if folder is not None and not dry_run:
            lost = _write(found, folder, filled, options, quiet)
    except KeyboardInterrupt:
        told = "what was done is kept, and the same command goes on from there"
        kept = options.journal is not None and options.keep
        _tell([f"{chr(10) if options.progress else ''}stopped; {told if kept else 'nothing is kept'}"])
        raise typer.Exit(130) from None
    finally:
        at_work.close()
    _print(found, changes if dry_run else None, form)
    raise typer.Exit(1 if (found.count("not graded") or lost) and not exit_zero else 0)


def autograde(
    root: Annotated[Path, typer.Argument(metavar="ROOT", help="What Gradescope lays down.")] = Path("/autograder"),
) -> None:
    """Grade the one submission that a running autograder of Gradescope has; called by its run_autograder."""
    from gyrodata.grading.exports.gradescope import grade_autograder
    from gyrodata.grading.rubric import read_rubric

    rubric = root / "source" / "rubric.toml"
    graded = grade_autograder(root, read_rubric(_read(rubric), rubric.name))
    with telling(root, diagnostics.GRADES_FOLDER_CANNOT_BE_WRITTEN):
        write_whole(root / "results" / "results.json", [graded.encode()])


# --- what goes in -------------------------------------------------------------------------------------------


def _executor_of(address: str) -> Executor:
    """Give what hands tasks to the workers of a Dask cluster."""
    try:
        from distributed import Client

        executor: Executor = Client(address).get_executor()
    except (ImportError, OSError, ValueError) as error:
        hint = (
            "python3 -m pip install 'gyrodata[cluster]'; the address is what dask scheduler prints, as tcp://HOST:8786"
        )
        refuse(diagnostics.CLUSTER_CANNOT_BE_USED, f"--cluster {address} cannot be used: {error}", hint)
    return executor


def _rubric_bytes(path: Path | None) -> bytes:
    from gyrodata.grading.rubric import BUILT_IN, default_rubric_text

    if path is None or (str(path) in BUILT_IN and not path.exists()):
        return default_rubric_text("full" if path is None else str(path)).encode()
    return _read(path)


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        refuse(
            diagnostics.OPTION_FILE_CANNOT_BE_READ,
            f'"{path}" cannot be read: {error.strerror or error}',
            "check its name",
        )


def _earlier(years: Sequence[Path]) -> dict[str, Fingerprint]:
    """Read the logs of earlier years from the journals next to their grades."""
    from gyrodata.grading.journal import JOURNAL, Journal

    found: dict[str, Fingerprint] = {}
    for year in years:
        path = year / JOURNAL if year.is_dir() else year
        _read(path)
        name = path.resolve().parent.name if path.name == JOURNAL else path.stem
        entries = Journal(path).read().items()
        kept = {f"{name}/{student}": one.grade.fingerprint for student, one in entries if one.grade.fingerprint}
        if not kept:
            hint = f"give the folder that an earlier run wrote, with its {JOURNAL}"
            refuse(
                diagnostics.OPTION_FILE_CANNOT_BE_READ, f'--previous "{year}" holds no log that could be compared', hint
            )
        found |= kept
    return found


def _write_autograder(folder: Path, rubric: Path | None) -> Iterator[str]:
    """Write what is to be zipped for Gradescope, the scripts executable, and say what to do in Gradescope."""
    from gyrodata.grading.exports.gradescope import autograder_files
    from gyrodata.grading.rubric import read_rubric

    data = _rubric_bytes(rubric)
    judged = read_rubric(data, "built-in rubric" if rubric is None else rubric.name)
    files = autograder_files(judged, data.decode("utf-8-sig"))
    with telling(folder, diagnostics.GRADES_FOLDER_CANNOT_BE_WRITTEN):
        for name, content in files.items():
            write_whole(folder / name, [content])
            if content.startswith(b"#!"):
                (folder / name).chmod(0o755)
    by_hand = [criterion for criterion in judged.criteria if criterion.check == "manual"]
    points = judged.points - sum(criterion.points for criterion in by_hand)
    yield f"autograder: zip the files in {folder}, without a folder around them, and upload that"
    yield f"in Gradescope: {points:g} autograder points, and a due date, after which all feedback is shown"
    yield from (f'in Gradescope: {one.points:g} points for "{one.title}" are given by hand' for one in by_hand)


def _folder(path: Path, out: Path | None, form: Form, dry_run: bool, need_one: Sequence[str]) -> Path | None:
    """Say where the grades go, never into the class, where they would be taken for a student's; None for nowhere."""
    home = path.resolve()
    if out is not None:
        if out.resolve().is_relative_to(home):
            beside = os.path.relpath(home.parent / _usual_folder(home).name)
            hint = f"write beside it: --out {shlex.quote(beside)}"
            refuse(diagnostics.GRADES_WITHIN_CLASS, f'"{out}" is in the class, and would be graded with it', hint)
        return out
    if form == "text" or dry_run:
        return _usual_folder(home)
    for option in need_one:
        message = f"{option} needs a folder to write to, and --format {form} has none"
        refuse(diagnostics.OPTION_NEEDS_A_FOLDER, message, "add --out DIR")
    return None


def _usual_folder(home: Path) -> Path:
    folder = Path(f"{home.stem if home.suffix.lower() == '.zip' else home.name}-grades")
    return home.parent / folder if Path.cwd().is_relative_to(home) else folder


# --- what comes out -----------------------------------------------------------------------------------------


def _write(
    found: ClassGrades, folder: Path, filled: Mapping[str, Filled], options: GradingOptions, quiet: bool
) -> Sequence[str]:
    """Write the folder of the grades; give a line for each student without feedback."""
    from gyrodata.grading.desk import write_feedback, write_results

    waiting = write_results(found, folder, filled)
    bar = None if quiet else progress_bar(len(found.grades), time.monotonic, "feedback ")
    lost, changed = write_feedback(found, folder, options.figures, bar)
    _tell(lost, changed)
    if not quiet:
        _tell(_told_where(folder, waiting))
    return lost


def _print(found: ClassGrades, changes: Sequence[Change] | None, form: Form) -> None:
    from gyrodata.grading.exports.class_json import grade_lines, grades_document

    if form in ("text", "csv"):
        parts = iter([found.summary if form == "text" else found.table])
    else:
        parts = grades_document(found, changes) if form == "json" else grade_lines(found)
    for part in parts:
        write_out(part)


# --- what is said on the way --------------------------------------------------------------------------------


def _tell(*groups: Iterable[str]) -> None:
    tell(*chain.from_iterable(groups))


def _told_where(folder: Path, waiting: int) -> list[str]:
    from gyrodata.grading.ledger import TODO
    from gyrodata.reporting.values import count_text

    waits = f"; {count_text(waiting, 'line')} for you in {folder / TODO}" if waiting else ""
    return [f"grades: {folder / 'grades.csv'}{waits}", f"class: {folder / 'class.html'}"]


def _told(found: ClassGrades, options: GradingOptions) -> Iterator[str]:
    """Say who was graded in this run, and why."""
    from gyrodata.grading.desk import waiting_lines
    from gyrodata.grading.ledger import DESK
    from gyrodata.readings import listing
    from gyrodata.reporting.values import count_text

    reasons: dict[str, list[str]] = {}
    for student, why in found.again.items():
        reasons.setdefault(why, []).append(found.names[student])
    for why, students in reasons.items():
        yield f"graded {len(students)} ({why}): {listing(students, 5)}"
    known = len(found.grades) - len(found.again)
    if known:
        yield f"kept {known} as graded before"
    empty = [one for one in waiting_lines(found) if found.desk.empty(one)]
    if empty:
        yield f"{count_text(len(empty), 'line')} {'waits' if len(empty) == 1 else 'wait'} in {DESK} for a value"
    if left := len(found.desk.left - {(one.student, one.what) for one in empty}):
        yield f"{DESK}: {count_text(left, 'line')} without a value, left as gyro has it"
    if options.journal is not None and options.journal.damaged:
        yield str(options.journal.lost_lines())


def _told_changes(changes: Sequence[Change] | None, dry_run: bool) -> Iterator[str]:
    """Say what changes in the table of grades that is there."""
    from gyrodata.grading.desk import PUBLISHED, TABLE

    kept = "" if dry_run else f"; what it was is kept in {PUBLISHED}"
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
    """List the new and old entries of a gradebook, and the students who are not in it."""
    from gyrodata.readings import listing

    for name, sheet in filled.items():
        yield f"{name}: {len(sheet.filled)} filled, {len(sheet.changed)} of them changed, {len(sheet.skipped)} not"
        yield from (f"  {student}: {before} → {after}" for student, before, after in sheet.changed)
        reasons: dict[str, list[str]] = {}
        for who, why in sheet.skipped:
            reasons.setdefault(why, []).append(who)
        yield from (f"  {why}: {listing(people, 10)}" for why, people in reasons.items())
