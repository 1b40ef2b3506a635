"""The folder of a class's grades: what is written where, and what a run would change in it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from gyrodata.grading.changes import Change, compare_tables
from gyrodata.grading.classroom import ClassGrades
from gyrodata.grading.exports.canvas import fill_gradebook
from gyrodata.grading.exports.class_page import class_page
from gyrodata.grading.exports.documents import grades_document
from gyrodata.grading.exports.flags_csv import flags_csv
from gyrodata.grading.exports.moodle import fill_worksheet
from gyrodata.grading.exports.sheet import Filled
from gyrodata.grading.feedback import feedback_comment
from gyrodata.grading.grade import Grade, not_graded
from gyrodata.grading.handback import FOLDER, feedback_names
from gyrodata.grading.journal import cannot_write, write_whole
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submissions

JOURNAL, FIGURES = "journal.ndjson", "figures"
TABLE, BEFORE = "grades.csv", "grades-before.csv"
CANVAS, MOODLE = "canvas.csv", "moodle.csv"


@dataclass(frozen=True, slots=True)
class Gradebooks:
    """What platforms handed out to be filled; None for what is not asked for."""

    canvas: bytes | None = None
    canvas_name: str = ""
    assignment: str | None = None
    moodle: bytes | None = None
    moodle_name: str = ""

    def fill(self, grades: Collection[Grade], ids: Mapping[str, Mapping[str, str]]) -> dict[str, Filled]:
        """Fill them.

        Gives: By the name of the file to be written.
        """
        filled = {}
        if self.canvas is not None:
            filled[CANVAS] = fill_gradebook(
                self.canvas, grades, name=self.canvas_name, assignment=self.assignment, ids=ids
            )
        if self.moodle is not None:
            comments = {grade.student: feedback_comment(grade) for grade in grades}
            filled[MOODLE] = fill_worksheet(self.moodle, grades, name=self.moodle_name, comments=comments, ids=ids)
        return filled

    def try_out(self, submissions: Submissions, rubric: Rubric) -> None:
        """See that they can be filled, before a class is graded for them; raise as `fill` does."""
        first = submissions.items[0]
        self.fill((not_graded(first, rubric, "not yet"),), {first.student: first.ids})


def changes_in(folder: Path, found: ClassGrades) -> tuple[Change, ...] | None:
    """Say what the table of grades in a folder would become.

    Gives: Empty where nothing changes or nothing is there; None where what is there is no table of grades.
    """
    path = folder / TABLE
    try:
        before = path.read_bytes().decode("utf-8-sig", "replace")
    except FileNotFoundError:
        return ()
    except OSError as error:
        raise cannot_write(folder, error) from None
    return () if before == found.table else compare_tables(before, found.table)


def write_results(found: ClassGrades, folder: Path, filled: Mapping[str, Filled]) -> None:
    """Write everything but the feedback.

    `folder`: Made where there is none. A table of grades that was there, and is another, stays as
    ``grades-before.csv``.
    """
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
