"""The desk of whoever grades: what is written into the folder of the grades, and what a run would change in it."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from gyrodata.grading.classroom import ClassGrades, GradingOptions, figure_path
from gyrodata.grading.exports import Change, compare_tables, flags_csv, grades_document
from gyrodata.grading.exports.class_page import class_page
from gyrodata.grading.exports.gradebooks import Filled, fill_book
from gyrodata.grading.feedback import feedback_comment, feedback_html, feedback_markdown
from gyrodata.grading.grade import Grade, not_graded
from gyrodata.grading.journal import cannot_write, write_changed, write_whole
from gyrodata.grading.platforms import book_of
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission, Submissions
from gyrodata.workers import Failed, in_workers

FIGURES = "figures"
TABLE, BEFORE = "grades.csv", "grades-before.csv"


@dataclass(frozen=True, slots=True)
class Gradebooks:
    """What platforms handed out to be filled."""

    given: Mapping[str, tuple[bytes, str]]  # by platform: the sheet, and its name
    assignment: str | None = None  # column, where a sheet has several

    def fill(self, grades: Collection[Grade], ids: Mapping[str, Mapping[str, str]]) -> dict[str, Filled]:
        """Fill them; by the name of the file to be written."""
        comments = {grade.student: feedback_comment(grade) for grade in grades} if self.given else {}
        filled = {}
        for lms, (data, name) in self.given.items():
            sheet = fill_book(lms, data, name, grades, assignment=self.assignment, comments=comments, ids=ids)
            filled[book_of(lms).file] = sheet
        return filled

    def try_out(self, submissions: Submissions, rubric: Rubric) -> None:
        """See that they can be filled, before a class is graded for them; raise as `fill` does."""
        first = submissions.items[0]
        self.fill((not_graded(first, rubric, "not yet"),), {first.student: first.ids})


def changes_in(folder: Path, found: ClassGrades) -> tuple[Change, ...] | None:
    """Say what changes in the table of grades of a folder; None where what is there is no such table."""
    path = folder / TABLE
    try:
        before = path.read_bytes().decode("utf-8-sig", "replace")
    except FileNotFoundError:
        return ()
    except OSError as error:
        raise cannot_write(folder, error) from None
    return () if before == found.table else compare_tables(before, found.table)


def write_results(found: ClassGrades, folder: Path, filled: Mapping[str, Filled]) -> None:
    """Write everything but the feedback; another table of grades that was there is kept."""
    names = feedback_names(found)
    _keep_before(folder, found.table.encode("utf-8", "replace"))
    texts: dict[str, Iterable[str]] = {
        TABLE: [found.table],
        "flags.csv": [flags_csv(found.flags)],
        "class.html": class_page(found, lambda student: f"{FOLDER}/{names[student]}.html"),
        "grades.json": grades_document(found),
    }
    for name, parts in texts.items():
        write_whole(folder / name, (part.encode("utf-8", "replace") for part in parts))
    for name, sheet in filled.items():
        write_whole(folder / name, [sheet.data])


def _keep_before(folder: Path, table: bytes) -> None:
    """Keep a table that somebody may have worked in."""
    path = folder / TABLE
    try:
        if path.is_file() and path.read_bytes() != table:
            path.replace(folder / BEFORE)
    except OSError as error:
        raise cannot_write(folder, error) from None


# --- the feedback of a class, in files named so that the platform takes them, and a zip of all --------------


FOLDER = "feedback"
ARCHIVE = "feedback.zip"
ENDINGS = (".html", ".md")


@dataclass(frozen=True, slots=True)
class _Task:
    """One student's feedback to be written."""

    grade: Grade
    submission: Submission
    figures: Mapping[str, str]  # what each figure shows, by name; empty where the feedback has none


@dataclass(frozen=True)
class _Work:
    """How it is written, in a worker."""

    figures: Path | None

    def __call__(self, task: _Task) -> tuple[str, str]:
        """Give the page and the Markdown."""
        drawn = {}
        if self.figures is not None:
            drawn = {name: figure_path(self.figures, task.submission, name).read_bytes() for name in task.figures}
        return feedback_html(task.grade, drawn, task.figures), feedback_markdown(task.grade)


def feedback_names(found: ClassGrades) -> dict[str, str]:
    """Name each student's feedback below `FOLDER` as the platform does, without its ending; numbers part equal ones."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for item in found.submissions.items:
        plain = item.feedback_name("")
        name, number = plain, 1
        while name.casefold() in taken:
            number += 1
            name = f"{plain}-{number}"
        taken.add(name.casefold())
        names[item.student] = name
    return names


def write_feedback(
    found: ClassGrades, folder: Path, options: GradingOptions, progress: Callable[[int], None] | None = None
) -> tuple[str, ...]:
    """Write the feedback of a class into a folder and a zip; say whose could not be written, and why."""
    names = feedback_names(found)
    figures = found.figures if options.figures is not None else {}
    tasks = (
        _Task(grade, item, figures.get(grade.student, {}))
        for grade, item in zip(found.grades, found.submissions.items, strict=True)
    )
    lost: list[str] = []
    written: list[str] = []
    work, preload = _Work(options.figures), ["gyrodata.grading.grade"]
    for task, answer in in_workers(work, tasks, options.workers, options.limit, preload):
        if isinstance(answer, Failed):
            lost.append(f"no feedback for {task.grade.name}: {answer.why}")
        else:
            name = names[task.grade.student]
            for ending, text in zip(ENDINGS, answer, strict=True):
                write_changed(folder / FOLDER / f"{name}{ending}", text.encode("utf-8", "replace"))
            written.append(name)
        if progress is not None:
            progress(len(written) + len(lost))
    _write_archive(folder, sorted(written))
    return tuple(sorted(lost))


def _write_archive(folder: Path, names: list[str]) -> None:
    """Zip the feedback of this class, and of nobody else; the same files give the same bytes."""
    target = folder / ARCHIVE
    unfinished = target.with_name(f".{ARCHIVE}.part")
    try:
        with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
            for name in (f"{name}{ending}" for name in names for ending in ENDINGS):
                entry = zipfile.ZipInfo(name)  # of 1980: a zip's bytes should not tell the time
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, (folder / FOLDER / name).read_bytes())
        unfinished.replace(target)
    except OSError as error:
        raise cannot_write(folder, error) from None
