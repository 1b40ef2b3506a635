"""A Canvas gradebook, downloaded, filled and given back: one column changes, all else stays byte for byte.

Rules: `lib/gradebook_importer.rb` and `lib/gradebook_exporter.rb` of instructure/canvas-lms. A column keeps its
``(id)``, for without it Canvas makes a new assignment; scores are compared at two decimals; the last ``.`` or ``,``
of a number is its decimal mark, so that ``1,234`` would be 1.234.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from operator import itemgetter
from types import MappingProxyType
from typing import TYPE_CHECKING

from gyrodata.errors import register
from gyrodata.grading.exports.grades_csv import two_decimals
from gyrodata.grading.exports.sheet import Filled, Sheet, read_sheet, refusal
from gyrodata.readings import listing

if TYPE_CHECKING:
    from gyrodata.grading.grade import Grade

G752 = register("G752", "error", "this is no Canvas gradebook", "grade class --gradebook grades.csv")
G753 = register(
    "G753", "error", "which column of the gradebook to fill is not clear", "grade class --gradebook two.csv"
)
G754 = register("G754", "error", "the column of the gradebook cannot be filled", "grade class --gradebook locked.csv")

_STUDENT_COLUMNS = ("id", "sis user id", "sis login id", "integration id", "root account", "section")
_NO_IDS: Mapping[str, Mapping[str, str]] = MappingProxyType({})


def fill_gradebook(
    data: bytes,
    grades: Collection[Grade],
    *,
    name: str = "gradebook.csv",
    assignment: str | None = None,
    ids: Mapping[str, Mapping[str, str]] = _NO_IDS,
) -> Filled:
    """Write grades into a downloaded Canvas gradebook.

    `assignment`: Title or number of the assignment; it may be left away where the gradebook has only one. `ids`:
    `Submission.ids` of each student. A student is looked for by Canvas's number, then the SIS user id, then the login;
    never by name.
    """
    sheet = read_sheet(data, name)
    columns = _student_columns(sheet)
    special = _points_row(sheet)
    rows = [row for row in range(1, len(sheet.rows)) if row != special and sheet.value(row, columns["id"])]
    column = _assignment_column(sheet, columns, assignment)
    mark = _check_points(sheet, column, grades)
    places = _Places(sheet, columns, rows)
    filled: list[str] = []
    changed: list[tuple[str, str, str]] = []
    skipped: list[tuple[str, str]] = []
    told = ((grade.student, grade.points, grade.why) for grade in grades)
    for student, points, why in sorted(told, key=itemgetter(0)):
        found = places.of(student, ids.get(student, {}))
        if not found:
            skipped.append((student, "is in no row of the gradebook"))
        elif points is None:
            skipped.append((student, f"is not graded: {why}"))
        for row in found if points is not None else ():
            before, written = sheet.value(row, column), two_decimals(points).replace(".", mark)
            if before.upper() in ("EX", "N/A"):
                skipped.append((student, f'has "{before}" in the gradebook: excused or not assigned'))
                continue
            if before not in ("", "-") and _number(before) != points:
                changed.append((student, before, written))
            sheet.put(row, column, written)
            filled.append(student)
    skipped += [(sheet.value(row, 0), "has no submission") for row in rows if row not in places.asked]
    return Filled(sheet.to_bytes(), tuple(dict.fromkeys(filled)), tuple(changed), tuple(skipped))


class _Places:
    """Where each student stands."""

    _KINDS = (("id", ("canvas",)), ("sis user id", ("sid",)), ("sis login id", ("username", "email")))

    def __init__(self, sheet: Sheet, columns: Mapping[str, int], rows: list[int]) -> None:
        self.asked: set[int] = set()
        self._rows: dict[tuple[str, str], list[int]] = {}
        for kind, _ in self._KINDS:
            for row in rows:
                value = sheet.value(row, columns.get(kind))
                if value:
                    self._rows.setdefault((kind, value.casefold()), []).append(row)

    def of(self, student: str, ids: Mapping[str, str]) -> list[int]:
        """Give the rows of a student, several where one stands in several sections."""
        for kind, names in self._KINDS:
            # Moodle's number of a student might be Canvas's of another.
            key = () if "moodle" in ids else (student,)
            for value in (*(ids[name] for name in names if name in ids), *key):
                found = self._rows.get((kind, value.casefold()))
                if found:
                    self.asked |= set(found)
                    return found
        return []


def _student_columns(sheet: Sheet) -> dict[str, int]:
    """Find the columns that say who a student is: "Student, ID, …" or "LastName, FirstName, ID, …"."""
    head = [cell.value.strip() for cell in sheet.rows[0].cells]
    if not re.match("Student|LastName", head[0]) or "ID" not in head[1:3]:
        hint = "in Canvas: Grades, Export, Export Entire Gradebook; give that file as it is"
        raise refusal(G752, sheet.name, 'is no Canvas gradebook: it does not begin with "Student" and "ID"', hint)
    return {title.lower(): at for at, title in enumerate(head) if title.lower() in _STUDENT_COLUMNS}


def _points_row(sheet: Sheet) -> int | None:
    rows = range(1, len(sheet.rows))
    return next((row for row in rows if "Points Possible" in sheet.value(row, 0)), None)


def _assignment_column(sheet: Sheet, columns: Mapping[str, int], assignment: str | None) -> int:
    head = [cell.value.strip() for cell in sheet.rows[0].cells]
    titles = {
        at: match for at, title in enumerate(head) if (match := re.fullmatch(r"(.*) \((\d+)\)", title, re.DOTALL))
    }
    if assignment is None:
        found = [at for at in titles if at > max(columns.values(), default=0)]
    else:
        wanted = assignment.strip().casefold()
        found = [
            at for at, match in titles.items() if wanted in (part.casefold() for part in (match[0], *match.groups()))
        ]
    if len(found) == 1:
        return found[0]
    shown = listing([titles[at][0] for at in titles]) or "none with a number in brackets"
    asked = f'no one column "{assignment}"' if assignment is not None else "not one assignment"
    hint = "name it with its number, such as 123456; make the assignment in Canvas first and export again"
    raise refusal(G753, sheet.name, f"has {asked}; its assignments are: {shown}", hint)


def _check_points(sheet: Sheet, column: int, grades: Iterable[Grade]) -> str:
    """See that the column takes these points, and give its decimal mark."""
    special = _points_row(sheet)
    possible = "" if special is None else sheet.value(special, column)
    title = sheet.value(0, column)
    if re.search(r"read.only", possible, re.IGNORECASE):
        raise refusal(
            G754, sheet.name, f'locks the column "{title}" (read only)', "unlock it in Canvas and export again"
        )
    points = _number(possible)
    out_of = next((grade.out_of for grade in grades), None)
    if points is not None and out_of is not None and round(points, 2) != round(out_of, 2):
        hint = "make the points of the rubric and of the assignment in Canvas the same"
        raise refusal(G754, sheet.name, f'has {possible} points for "{title}", the rubric {out_of:g}', hint)
    return "," if re.search(r",\d+$", possible) else "."


def _number(text: str) -> float | None:
    """Read a number as Canvas does: the last mark in it is the decimal one."""
    *whole, last = re.split("[.,]", text.strip())
    try:
        return float(f"{''.join(whole)}.{last}" if whole else last)
    except ValueError:
        return None
