"""The desk of whoever grades: what is written into the folder of the grades, and what a run would change in it."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gyrodata.grading.classroom import ClassGrades
from gyrodata.grading.exports.class_page import class_page
from gyrodata.grading.exports.gradebooks import fill_book
from gyrodata.grading.exports.grades_csv import POINTS_ROW, flags_csv
from gyrodata.grading.exports.grades_json import grades_document
from gyrodata.grading.exports.sheet import Filled
from gyrodata.grading.feedback import FOLDER, feedback_comment, feedback_names
from gyrodata.grading.grade import Grade, not_graded
from gyrodata.grading.journal import cannot_write, write_whole
from gyrodata.grading.platforms import book_of
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submissions

JOURNAL, FIGURES = "journal.ndjson", "figures"
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


# --- changes in the table of grades: who, from what, to what ------------------------------------------------


TOTAL, STATUS = "total", "status"
NOT_GRADED = "not graded"


@dataclass(frozen=True, slots=True)
class Change:
    """One student whose row is not what it was."""

    student: str
    name: str
    before: str | None
    """Points, "not graded", or None for one who was not in the table."""
    after: str | None
    """The same now; None for one who no longer is."""
    parts: tuple[tuple[str, str, str], ...]
    """Other cells that change: column, before, after."""

    def to_dict(self) -> dict[str, Any]:
        """Give it as JSON can hold it."""
        parts = [{"column": column, "from": before, "to": after} for column, before, after in self.parts]
        return {"student": self.student, "name": self.name, "from": self.before, "to": self.after, "parts": parts}

    def __str__(self) -> str:
        who = self.name if self.student in self.name else f"{self.name} ({self.student})"
        told = f"{who}: {self.before or 'not in it'} → {self.after or 'no longer in it'}"
        if self.before == self.after:
            told = f"{who}: {self.after}"
        parts = ", ".join(f"{column} {before or '–'} → {after or '–'}" for column, before, after in self.parts)
        return f"{told} ({parts})" if parts else told


def compare_tables(before: str, after: str) -> tuple[Change, ...] | None:
    """Compare two tables of grades.

    `before`, `after`: ``grades.csv`` as it is, and as it would be. Gives: Sorted by student; empty where every cell is
    the same; None where the old one is no table of grades.
    """
    old, new = _read_table(before), _read_table(after)
    if old is None or new is None:
        return None
    changes = []
    for student in sorted(old.keys() | new.keys()):
        was, now = old.get(student), new.get(student)
        if was == now:
            continue
        parts: list[tuple[str, str, str]] = []
        if was is not None and now is not None:
            columns = [column for column in {**was, **now} if column not in ("name", TOTAL, STATUS)]
            pairs = ((column, was.get(column, ""), now.get(column, "")) for column in columns)
            parts = [pair for pair in pairs if pair[1] != pair[2]]
        name = (now or was or {}).get("name") or student
        changes.append(Change(student, name, _points_text(was), _points_text(now), tuple(parts)))
    return tuple(changes)


def _read_table(table: str) -> dict[str, dict[str, str]] | None:
    """Read a table of grades, each student's cells by column; None where there are no such columns."""
    try:
        reader = csv.DictReader(io.StringIO(table, newline=""))
        columns = [column for column in dict.fromkeys(reader.fieldnames or ()) if column]
        if not {"student", STATUS, TOTAL} <= set(columns):
            return None
        rows = {row["student"] or "": {column: row[column] or "" for column in columns} for row in reader}
    except csv.Error:
        return None
    rows.pop(POINTS_ROW, None)
    return rows


def _points_text(row: Mapping[str, str] | None) -> str | None:
    return None if row is None else row[TOTAL] or NOT_GRADED
