"""Fill the sheets of grades that Canvas and Moodle export.

Single cells change, and all other cells stay as they were.

Canvas: a column keeps its ``(id)``, because without it Canvas makes a new assignment;
scores are compared at two decimals; the last ``.`` or ``,`` of a number is its decimal
mark, so ``1,234`` would be 1.234.

Moodle: its importer skips a row without a message if the grade is unchanged, above the
maximum or locked; those rows are reported here instead. Headers are in the language of
the site, so columns are found by their content.
"""

from __future__ import annotations

import csv
import html
import io
import re
from collections.abc import Collection, Iterable, Mapping, Sequence

from msgspec import Struct

from gyrodata.base.errors import InputError
from gyrodata.grading.exports.pages import feedback_comment
from gyrodata.grading.grade import Grade, two_decimals
from gyrodata.grading.ledger import read_number
from gyrodata.grading.roster import TEST_STUDENT
from gyrodata.readings import listing

Ours = Mapping[str, Collection[str] | None]
"""Totals that each student ever had from gyro, as written; None if the student's total
may be overwritten."""


class Filled(Struct):
    """A gradebook with grades in it."""

    file: str  # name of the file to write
    data: bytes = b""  # the file to upload
    filled: list[str] = []  # students whose grade is in it now
    # student, old and new cell, if they differ and the old cell was not empty
    changed: list[tuple[str, str, str]] = []
    skipped: list[tuple[str, str]] = []  # student or row, and why nothing was written
    by_hand: list[
        tuple[str, str]
    ] = []  # student and total that a person has set in the gradebook


class _Layout(Struct):
    """Where the grades are in a sheet, and whose rows there are."""

    lms: str
    grade: int  # column of the grades
    most: str  # possible points, as written
    labels: Mapping[int, str]  # the name of each row of a student, for people
    places: Mapping[
        tuple[str, str], list[int]
    ]  # rows by what names a student there, and the name in small letters
    # Moodle's column of the maximum; the next one says whether the grade can be changed
    top: int | None = None
    comment: int | None = None  # column of the comments


_NOUNS = {"canvas": "gradebook", "moodle": "worksheet"}
_KNOWN_BY = {
    "canvas": (
        ("id", ("canvas", "key")),
        ("sis user id", ("sid", "key")),
        ("sis login id", ("username", "email", "key")),
    ),
    "moodle": (("group", ("name",)), ("number", ("moodle", "key"))),
}
"""Columns that identify students, and the kinds of id in each; Moodle: a group in any
column, and the number of "Participant 7"."""


def fill_book(
    data: bytes,
    name: str,
    grades: Collection[Grade],
    *,
    assignment: str | None = None,
    ids: Mapping[str, Mapping[str, str]] = {},
    ours: Ours | None = None,
) -> Filled:
    """Write grades, and comments if it has a column for them, into an exported sheet.

    `assignment`: Title or number of the column, if there are several. `ids`:
    `Submission.ids` of each student. `ours`: Other totals stay, because a person has
    set them; None: all are overwritten. Raises InputError for a sheet that cannot be
    filled.
    """
    sheet = read_sheet(data, name)
    is_canvas = sheet.head[0].lower().startswith(("student", "lastname"))
    rows = {} if is_canvas else _participants(sheet)
    layout = _worksheet(sheet, rows) if rows else _columns(sheet, assignment)
    _insist_on_points(sheet, layout, next(iter(grades)).out_of)
    filled = Filled(f"{layout.lms}.csv")
    filling = _Filling(sheet, layout, filled, ours)
    others = dict(layout.labels)  # rows of nobody who is graded
    for grade in sorted(grades, key=lambda grade: grade.student):
        rows_of_grade = _rows_of(layout, grade, ids.get(grade.student, {}))
        if not rows_of_grade:
            filling.skip(grade, f"is not in the {_NOUNS[layout.lms]}")
        elif not _has_points(grade):
            why = f": {grade.why}" if grade.why else ""
            status = "not complete" if grade.status == "so far" else grade.status
            filling.skip(grade, f"is {status}{why}")
        for row in rows_of_grade:
            others.pop(row, None)
            filling.write(grade, row)
    missing = dict.fromkeys(others.values(), "has no submission")
    missing.pop(TEST_STUDENT, None)
    filled.skipped += missing.items()
    filled.data = sheet.to_bytes()
    return filled


def _insist_on_points(sheet: Sheet, layout: _Layout, out_of: float) -> None:
    """Raise an error if the platform expects another number of points."""
    most = read_number(layout.most)
    if most is None or round(most, 2) == round(out_of, 2):
        return
    is_worksheet = layout.top is not None
    message = "worksheet_other_points" if is_worksheet else "gradebook_other_points"
    values = {"lms": layout.lms.title(), "most": layout.most, "out_of": out_of}
    column = sheet.value(0, layout.grade)
    raise sheet.error(message, column=column, **values)


def _has_points(grade: Grade) -> bool:
    return grade.status == "graded" and grade.points is not None


def _rows_of(layout: _Layout, grade: Grade, ids: Mapping[str, str]) -> list[int]:
    """Return the rows of a student: several if the student is in several sections."""
    known = {"name": grade.name, "key": grade.student, **ids}
    if "moodle" in known:
        # It may be the number of another student in Canvas.
        del known["key"]
    for title, kinds in _KNOWN_BY[layout.lms]:
        for kind in kinds:
            place = (title, known.get(kind, "").casefold())
            if known.get(kind) and place in layout.places:
                return layout.places[place]
    return []


class _Filling(Struct):
    """A sheet while grades are written into it."""

    sheet: Sheet
    layout: _Layout
    filled: Filled
    ours: Ours | None

    def skip(self, grade: Grade, why: str) -> None:
        """Note why nothing is written."""
        self.filled.skipped.append((grade.student, why))

    def write(self, grade: Grade, row: int) -> None:
        """Write a grade and its comment into a row, if nothing speaks against it."""
        before = self.sheet.value(row, self.layout.grade)
        if self._is_set_by_hand(grade, before):
            self.skip(grade, f"has {before}, set by hand, which is kept")
            total = two_decimals(read_number(before) or 0.0)
            self.filled.by_hand.append((grade.student, total))
            return
        if not _has_points(grade):
            return
        points = grade.points or 0.0
        refusal = _why_refused(self.sheet, self.layout, row, points)
        if refusal:
            self.skip(grade, refusal)
            return
        is_worksheet = self.layout.top is not None
        if is_worksheet and read_number(before) == points:
            self.skip(grade, f"has {before} in Moodle already: Moodle skips the grade")
        else:
            text = two_decimals(points)
            if _has_decimal_comma(self.layout.most):
                text = text.replace(".", ",")
            self._set(grade, row, self.layout.grade, text)
        if self.layout.comment is not None:
            text = _comment_cell(feedback_comment(grade))
            self._set(grade, row, self.layout.comment, text)
        if grade.student not in self.filled.filled[-1:]:
            self.filled.filled.append(grade.student)

    def _is_set_by_hand(self, grade: Grade, before: str) -> bool:
        """Return whether a person has set a total that gyro never gave."""
        total = read_number(before)
        if self.ours is None or total is None:
            return False
        if _has_points(grade) and total == grade.points:
            return False
        known = self.ours.get(grade.student, ())
        return known is not None and two_decimals(total) not in known

    def _set(self, grade: Grade, row: int, column: int, text: str) -> None:
        """Change one cell, and note what it contained."""
        old = self.sheet.value(row, column)
        is_new = old in (text, *_EMPTY)
        if not is_new and read_number(old) != grade.points:
            self.filled.changed.append((grade.student, old, text))
        cells = self.sheet.rows[row]
        cells += [""] * (column + 1 - len(cells))
        cells[column] = text


def _comment_cell(text: str) -> str:
    """Return a comment as HTML.

    A spreadsheet does not read a text that begins with a tag as a formula.
    """
    plain = html.escape(text).strip()
    paragraphs = re.sub(r"(?:(?<!\s)\s+)?\n\s*\n\s*", "</p><p>", plain)
    return f"<p>{paragraphs}</p>".replace("\n", "<br>")


# Contents of a cell: no grade yet; no grade is needed; the grade cannot be changed.
_EMPTY = ("", "-")
_EXCUSED = ("ex", "n/a", "exempt", "exempted", "excused")
_NO = (
    "no",
    "nein",
    "non",
    "não",
    "nie",
    "нет",
    "ні",
    "ne",
    "nee",
    "nej",
    "nei",
    "hayır",
    "όχι",
    "いいえ",
    "否",
)


def _why_refused(sheet: Sheet, layout: _Layout, row: int, points: float) -> str:
    """Return why the platform would not take a grade; "" if it would."""
    before = sheet.value(row, layout.grade)
    if before.casefold() in _EXCUSED:
        return f'has "{before}" in the gradebook: excused or not assigned'
    if layout.top is not None:
        most = read_number(sheet.value(row, layout.top))
        if sheet.value(row, layout.top + 1).casefold() in _NO:
            return "is locked in Moodle: the grade cannot be changed"
        if most is not None and points > most:
            return f"has {points:g} points, more than the maximum grade {most:g}: Moodle skips it"
    return ""


_ASSIGNMENT = re.compile(r"(.*) \((\d+)\)", re.DOTALL)


def _columns(sheet: Sheet, assignment: str | None) -> _Layout:
    """Find the grades in a sheet of Canvas.

    The sheet has columns with names and ids, and columns with assignments.
    """
    columns = {title.casefold(): at for at, title in enumerate(sheet.head)}
    key = columns.get("id")
    if key is None:
        raise sheet.error("no_book_of_canvas", columns="")
    rows = range(1, len(sheet.rows))
    of_maximum = [row for row in rows if "Points Possible" in sheet.value(row, 0)]
    grade = _chosen_assignment(sheet, assignment)
    most = ""
    if of_maximum:
        most = sheet.value(of_maximum[0], grade)
    _insist_on_open(sheet, grade, most)
    labels: dict[int, str] = {}
    for row in rows:
        if row not in of_maximum and sheet.value(row, key):
            cells = [sheet.value(row, at) for at in range(key)]
            labels[row] = ", ".join(cells)
    places = _ids_of_rows(sheet, labels, columns)
    return _Layout("canvas", grade, most, labels, places)


def _ids_of_rows(
    sheet: Sheet, rows: Iterable[int], columns: Mapping[str, int]
) -> dict[tuple[str, str], list[int]]:
    """Return the rows of a sheet of Canvas by each id in them."""
    places: dict[tuple[str, str], list[int]] = {}
    for row in rows:
        for title, _ in _KNOWN_BY["canvas"]:
            value = sheet.value(row, columns.get(title)).casefold()
            places.setdefault((title, value), []).append(row)
    return places


def _insist_on_open(sheet: Sheet, grade: int, most: str) -> None:
    """Raise an error if Canvas does not take grades in a column."""
    if "read only" in most.lower().replace("-", " ").replace("_", " "):
        column = sheet.head[grade]
        raise sheet.error("gradebook_column_locked", column=column, why="read only")


def _chosen_assignment(sheet: Sheet, assignment: str | None) -> int:
    """Return the column of the assignment that the user names, or the only one."""
    names: dict[int, Sequence[str]] = {}
    for at, title in enumerate(sheet.head):
        if match := _ASSIGNMENT.fullmatch(title):
            names[at] = match.group(0, 1, 2)
    chosen = list(names)
    asked = "not one assignment"
    if assignment is not None:
        wanted = assignment.strip().casefold()
        chosen = []
        for at, forms in names.items():
            if wanted in map(str.casefold, forms):
                chosen.append(at)
        asked = f'not exactly one column "{assignment}"'
    if len(chosen) == 1:
        return chosen[0]
    titles = listing([sheet.head[at] for at in names])
    shown = titles or "none with a number after its title"
    raise sheet.error("gradebook_column_unclear", asked=asked, shown=shown)


def _has_decimal_comma(number: str) -> bool:
    """Return whether a number ends with a comma and digits: "20,00"."""
    _, comma, decimals = number.rpartition(",")
    return comma != "" and decimals.isdecimal()


def _participants(sheet: Sheet) -> dict[int, str]:
    """Return the number of each row with "Participant N", in any language."""
    rows = {}
    for row in range(1, len(sheet.rows)):
        match = re.fullmatch(r"\D+(\d+)", sheet.value(row, 0))
        if match is not None:
            rows[row] = match[1]
    return rows


def _worksheet(sheet: Sheet, rows: Mapping[int, str]) -> _Layout:
    """Find the grades in a sheet of Moodle.

    The sheet has a row for each participant, with the maximum, a lock and comments.
    Columns are found by their content: the maximum is the last one with one number in
    every row, and the last column may have comments.
    """
    columns = range(2, len(sheet.head))
    values = {}
    numbers = []
    for at in columns:
        values[at] = {sheet.value(row, at) for row in rows}
        if len(values[at]) == 1 and read_number(*values[at]) is not None:
            numbers.append(at)
    if not numbers:
        listed_columns = f"; its columns are: {listing(sheet.head)}"
        raise sheet.error("no_book_of_moodle", columns=listed_columns)
    top = numbers[-1]
    labels = {}
    for row in rows:
        number = sheet.value(row, 0)
        labels[row] = f"{number} ({sheet.value(row, 1)})"
    most = sheet.value(next(iter(rows)), top)
    # Dates may be in the last column instead.
    last = columns[-1]
    has_comments = any(not text or text.startswith("<") for text in values[last])
    is_behind = last >= top + 2
    comment = last if has_comments and is_behind else None
    places = _groups_and_numbers(sheet, rows, top - 1)
    return _Layout("moodle", top - 1, most, labels, places, top, comment)


def _groups_and_numbers(
    sheet: Sheet, rows: Mapping[int, str], end: int
) -> dict[tuple[str, str], list[int]]:
    """Return the rows by the number of a participant, and by a group in any column."""
    places: dict[tuple[str, str], list[int]] = {}
    for row, number in rows.items():
        for value in {sheet.value(row, at).casefold() for at in range(2, end)}:
            places.setdefault(("group", value), []).append(row)
        places.setdefault(("number", number), []).append(row)
    return places


# --- a CSV sheet in which only single cells may change ---


class Sheet(Struct):
    """A table, and the format of its file."""

    name: str  # shown name of the file
    rows: list[list[str]]  # all rows, blank ones too
    head: list[str]  # the first row, without spaces around the cells
    delimiter: str  # character between cells
    encoding: str

    def error(self, message: str, **values: object) -> InputError:
        """Return an error about the sheet."""
        return InputError.named(message, self.name, name=self.name, **values)

    def value(self, row: int, column: int | None) -> str:
        """Return a cell without spaces around it; "" if the row has no such column."""
        cells = self.rows[row]
        if column is None or column >= len(cells):
            return ""
        return cells[column].strip()

    def to_bytes(self) -> bytes:
        """Return the whole file, with line ends of RFC 4180."""
        out = io.StringIO()
        csv.writer(out, delimiter=self.delimiter).writerows(self.rows)
        return out.getvalue().encode(self.encoding, "surrogateescape")


def read_sheet(data: bytes, name: str) -> Sheet:
    """Read a sheet with commas, semicolons or tabs, as its first lines have them."""
    encoding = "utf-8-sig" if data[:3] == b"\xef\xbb\xbf" else "utf-8"
    text = data.decode(encoding, "surrogateescape")
    try:
        if not text.strip() or "\x00" in text:
            raise ValueError("is no text" if text.strip() else "is empty")
        first = "\n".join(text[:100_000].splitlines()[:3])
        unquoted = "".join(first.split('"')[::2])
        delimiter = max(",;\t", key=unquoted.count)
        rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
    except (ValueError, csv.Error) as error:
        raise InputError.named(
            "gradebook_not_read", name, name=name, why=str(error)
        ) from None
    titles = [cell.strip() for cell in rows[0]]
    return Sheet(name, rows, titles or [""], delimiter, encoding)
