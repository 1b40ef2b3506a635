"""Gradebooks of Canvas and Moodle, downloaded, filled and given back: single cells change, all else stays as it was.

Canvas (`lib/gradebook_importer.rb` and `lib/gradebook_exporter.rb` of instructure/canvas-lms): a column keeps its
``(id)``, for without it Canvas makes a new assignment; scores are compared at two decimals; the last ``.`` or ``,``
of a number is its decimal mark, so that ``1,234`` would be 1.234.

Moodle (`mod/assign/feedback/offline/importgradeslib.php` and `locallib.php` of moodle/moodle): the importer passes over
a row without a word where the grade is unchanged, above the maximum or locked; those rows are told here instead.
Headers are in the site's language, so that columns are known by what stands in them where they are not English.
"""

from __future__ import annotations

import html
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from operator import itemgetter
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from gyrodata.diagnostics import (
    GRADEBOOK_COLUMN_CANNOT_BE_FILLED,
    GRADEBOOK_COLUMN_NOT_CLEAR,
    NO_CANVAS_GRADEBOOK,
    NO_MOODLE_WORKSHEET,
    WORKSHEET_CANNOT_TAKE_POINTS,
)
from gyrodata.grading.exports.grades_csv import two_decimals
from gyrodata.grading.exports.sheet import Filled, Sheet, read_sheet, refusal
from gyrodata.readings import listing

if TYPE_CHECKING:
    from gyrodata.grading.grade import Grade


# --- Canvas -------------------------------------------------------------------------------------------------


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
            if before not in ("", "-") and _canvas_number(before) != points:
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
        raise refusal(
            NO_CANVAS_GRADEBOOK, sheet.name, 'is no Canvas gradebook: it does not begin with "Student" and "ID"', hint
        )
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
    raise refusal(GRADEBOOK_COLUMN_NOT_CLEAR, sheet.name, f"has {asked}; its assignments are: {shown}", hint)


def _check_points(sheet: Sheet, column: int, grades: Iterable[Grade]) -> str:
    """See that the column takes these points, and give its decimal mark."""
    special = _points_row(sheet)
    possible = "" if special is None else sheet.value(special, column)
    title = sheet.value(0, column)
    if re.search(r"read.only", possible, re.IGNORECASE):
        raise refusal(
            GRADEBOOK_COLUMN_CANNOT_BE_FILLED,
            sheet.name,
            f'locks the column "{title}" (read only)',
            "unlock it in Canvas and export again",
        )
    points = _canvas_number(possible)
    out_of = next((grade.out_of for grade in grades), None)
    if points is not None and out_of is not None and round(points, 2) != round(out_of, 2):
        hint = "make the points of the rubric and of the assignment in Canvas the same"
        raise refusal(
            GRADEBOOK_COLUMN_CANNOT_BE_FILLED,
            sheet.name,
            f'has {possible} points for "{title}", the rubric {out_of:g}',
            hint,
        )
    return "," if re.search(r",\d+$", possible) else "."


def _canvas_number(text: str) -> float | None:
    """Read a number as Canvas does: the last mark in it is the decimal one."""
    *whole, last = re.split("[.,]", text.strip())
    try:
        return float(f"{''.join(whole)}.{last}" if whole else last)
    except ValueError:
        return None


# --- Moodle -------------------------------------------------------------------------------------------------


_NO_COMMENTS: Mapping[str, str] = MappingProxyType({})
_NO = frozenset(
    {"no", "nein", "non", "não", "nie", "нет", "ні", "ne", "nee", "nej", "nei", "hayır", "όχι", "いいえ", "否"}
)
"""What stands under "Grade can be changed" where it cannot."""


def fill_worksheet(
    data: bytes,
    grades: Collection[Grade],
    *,
    name: str = "worksheet.csv",
    comments: Mapping[str, str] = _NO_COMMENTS,
    ids: Mapping[str, Mapping[str, str]] = _NO_IDS,
) -> Filled:
    """Write grades and comments into a downloaded Moodle worksheet.

    `comments`: Plain text for each student, for the column of feedback comments; it is escaped for the HTML that Moodle
    shows. Where the worksheet has no such column it is left away. `ids`: `Submission.ids` of each student; the row is
    that of "Participant N" with Moodle's number N, else that of the group with the submission's name. Gives: `skipped`
    names the rows that Moodle would pass over without a word, and those with no grade. What cannot be known from the
    worksheet: rows graded in Moodle after it was downloaded are passed over too.
    """
    sheet = read_sheet(data, name)
    columns = _Columns(sheet)
    columns.check_points(grades)
    people = [_Person(grade.student, grade.name, grade.points, grade.why) for grade in grades]
    by_row = columns.find(people, ids)
    filled: list[str] = []
    changed: list[tuple[str, str, str]] = []
    placed = {grade.student for grade in by_row.values()}
    skipped = [(one.student, "is in no row of the worksheet") for one in people if one.student not in placed]
    for row in columns.rows:
        grade = by_row.get(row)
        if grade is None:
            skipped.append((columns.label(row), "has no submission"))
        elif grade.points is None:
            skipped.append((grade.student, f"is not graded: {grade.why}"))
        elif why := columns.why_refused(row, grade.points):
            skipped.append((grade.student, why))
        else:
            before = sheet.value(row, columns.grade)
            if before and _moodle_number(before) == grade.points:
                skipped.append((grade.student, f"has {before} in Moodle already: Moodle passes over the grade"))
            else:
                changed += columns.put(row, columns.grade, grade.student, columns.written(grade.points))
            if columns.comment is not None and grade.student in comments:
                changed += columns.put(row, columns.comment, grade.student, _as_html(comments[grade.student]))
            filled.append(grade.student)
    return Filled(sheet.to_bytes(), tuple(dict.fromkeys(filled)), tuple(changed), tuple(sorted(skipped)))


class _Person(NamedTuple):
    """What of a grade stands in the worksheet."""

    student: str
    name: str
    points: float | None
    why: str | None


class _Columns:
    """The columns that matter of a worksheet in any language."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        self.head = [cell.value.strip() for cell in sheet.rows[0].cells]
        self.rows = [row for row in range(1, len(sheet.rows)) if self._number_of(row) is not None]
        top = self._top_column()
        if not self.rows or top is None or top < 2:
            hint = "in the assignment: View all submissions, Download grading worksheet; give that file as it is"
            message = f"is no Moodle grading worksheet; its columns are: {listing(self.head)}"
            raise refusal(NO_MOODLE_WORKSHEET, sheet.name, message, hint)
        self.top = top
        self.grade = top - 1
        self.can_change = top + 1
        self.comment = self._comment_column()
        self.mark = "," if any("," in sheet.value(row, top) for row in self.rows) else "."

    def _number_of(self, row: int) -> str | None:
        """Read N of "Participant N", the first word in any language."""
        match = re.fullmatch(r"\D+(\d+)", self.sheet.value(row, 0))
        return match[1] if match else None

    def label(self, row: int) -> str:
        """Name a row to a person."""
        return f"{self.sheet.value(row, 0)} ({self.sheet.value(row, 1)})"

    def _top_column(self) -> int | None:
        """Find the maximum grade: by its English name, else the one column with one number in every row."""
        if "Maximum Grade" in self.head:
            return self.head.index("Maximum Grade")
        found = []
        for column in range(2, len(self.head)):
            values = {self.sheet.value(row, column) for row in self.rows}
            if len(values) == 1 and (_moodle_number(values.pop()) or 0) > 0:
                found.append(column)
        return found[-1] if found else None

    def _comment_column(self) -> int | None:
        """Find the comments: the last column, where its cells are no dates."""
        if "Feedback comments" in self.head:
            return self.head.index("Feedback comments")
        last = len(self.head) - 1
        texts = [self.sheet.value(row, last) for row in self.rows]
        return last if last > self.top + 2 and any(not text or text.startswith("<") for text in texts) else None

    def check_points(self, grades: Collection[Grade]) -> None:
        """See that the worksheet has the points of the rubric."""
        most = _moodle_number(self.sheet.value(self.rows[0], self.top))
        out_of = next((grade.out_of for grade in grades), None)
        if most is None or out_of is None or round(most, 2) == round(out_of, 2):
            return
        hint = "make the points of the rubric and the maximum grade of the assignment in Moodle the same"
        raise refusal(
            WORKSHEET_CANNOT_TAKE_POINTS,
            self.sheet.name,
            f"has a maximum grade of {most:g}, the rubric {out_of:g} points",
            hint,
        )

    def find(self, grades: Sequence[_Person], ids: Mapping[str, Mapping[str, str]]) -> dict[int, _Person]:
        """Give each row its grade; a group's goes to all of its rows."""
        found: dict[int, _Person] = {}
        by_group = {grade.name.casefold(): grade for grade in grades}
        for row in self.rows:
            groups = (self.sheet.value(row, column).casefold() for column in range(2, self.grade))
            group = next((group for group in groups if group in by_group), None)
            if group is not None:
                found[row] = by_group[group]
        # A group's number might be that of another participant.
        of_groups = {grade.student for grade in found.values()}
        by_number = {
            ids.get(grade.student, {}).get("moodle", grade.student): grade
            for grade in grades
            if grade.student not in of_groups
        }
        for row in self.rows:
            number = self._number_of(row)
            if row not in found and number in by_number:
                found[row] = by_number[number]
        return found

    def written(self, points: float) -> str:
        """Write points with the site's decimal mark."""
        return two_decimals(points).replace(".", self.mark)

    def put(self, row: int, column: int, student: str, text: str) -> list[tuple[str, str, str]]:
        """Write a cell; give what stood there where something else did."""
        before = self.sheet.value(row, column)
        self.sheet.put(row, column, text)
        return [(student, before, text)] if before not in ("", text) else []

    def why_refused(self, row: int, points: float) -> str:
        """Say why Moodle's importer would not take a grade in this row; "" if it would."""
        most = _moodle_number(self.sheet.value(row, self.top))
        if self.sheet.value(row, self.can_change).casefold() in _NO:
            return "is locked in Moodle: the grade cannot be changed"
        if most is not None and points > most:
            return f"has {points:g} points, more than the maximum grade {most:g}: Moodle passes over it"
        return ""


def _moodle_number(text: str) -> float | None:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return None


def _as_html(text: str) -> str:
    """Write a plain text as paragraphs; one that begins with a tag is no formula to a spreadsheet either."""
    paragraphs = re.split(r"\n\s*\n", text.strip())
    return "".join(f"<p>{html.escape(one.strip()).replace(chr(10), '<br>')}</p>" for one in paragraphs)
