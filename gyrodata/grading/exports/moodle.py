"""A Moodle offline grading worksheet, downloaded, filled and given back: two columns change, all else stays.

Rules: `mod/assign/feedback/offline/importgradeslib.php` and `locallib.php` of moodle/moodle. The importer passes over
a row without a word where the grade is unchanged, above the maximum or locked; those rows are told here instead.
Headers are in the site's language, so that columns are known by what stands in them where they are not English.
"""

from __future__ import annotations

import html
import re
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from gyrodata.errors import register
from gyrodata.grading.exports.grades_csv import two_decimals
from gyrodata.grading.exports.sheet import Filled, Sheet, read_sheet, refusal
from gyrodata.readings import listing

if TYPE_CHECKING:
    from gyrodata.grading.grade import Grade

G755 = register("G755", "error", "this is no Moodle grading worksheet", "grade class --worksheet grades.csv")
G756 = register("G756", "error", "the worksheet cannot take these points", "grade class --worksheet ten-points.csv")

_NO_IDS: Mapping[str, Mapping[str, str]] = MappingProxyType({})
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
            if before and _number(before) == grade.points:
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
            raise refusal(G755, sheet.name, message, hint)
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
            if len(values) == 1 and (_number(values.pop()) or 0) > 0:
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
        most = _number(self.sheet.value(self.rows[0], self.top))
        out_of = next((grade.out_of for grade in grades), None)
        if most is None or out_of is None or round(most, 2) == round(out_of, 2):
            return
        hint = "make the points of the rubric and the maximum grade of the assignment in Moodle the same"
        raise refusal(G756, self.sheet.name, f"has a maximum grade of {most:g}, the rubric {out_of:g} points", hint)

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
        most = _number(self.sheet.value(row, self.top))
        if self.sheet.value(row, self.can_change).casefold() in _NO:
            return "is locked in Moodle: the grade cannot be changed"
        if most is not None and points > most:
            return f"has {points:g} points, more than the maximum grade {most:g}: Moodle passes over it"
        return ""


def _number(text: str) -> float | None:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return None


def _as_html(text: str) -> str:
    """Write a plain text as paragraphs; one that begins with a tag is no formula to a spreadsheet either."""
    paragraphs = re.split(r"\n\s*\n", text.strip())
    return "".join(f"<p>{html.escape(one.strip()).replace(chr(10), '<br>')}</p>" for one in paragraphs)
