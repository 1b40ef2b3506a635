"""What a new run would change in the table of grades that is there: who, from what, to what."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gyrodata.grading.exports.grades_csv import POINTS_ROW

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
    old, new = _read(before), _read(after)
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
        changes.append(Change(student, name, _points(was), _points(now), tuple(parts)))
    return tuple(changes)


def _read(table: str) -> dict[str, dict[str, str]] | None:
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


def _points(row: Mapping[str, str] | None) -> str | None:
    return None if row is None else row[TOTAL] or NOT_GRADED
