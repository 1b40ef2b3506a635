"""Fill the sheets of grades that platforms export.

Single cells change, and all other cells stay as they were.

Canvas: a column keeps its ``(id)``, because without it Canvas makes a new assignment;
scores are compared at two decimals; the last ``.`` or ``,`` of a number is its decimal
mark, so ``1,234`` would be 1.234.

Blackboard: the same for the ``|id`` of a column; a sheet with commas has every cell in
quotation marks.

Moodle: its importer skips a row without a message if the grade is unchanged, above the
maximum or locked; those rows are reported here instead. Headers are in the language of
the site, so columns are found by their content.
"""

from __future__ import annotations

import csv
import html
import io
import re
from collections.abc import Callable, Collection, Mapping

from msgspec import Struct

from gyrodata.base.errors import InputError
from gyrodata.grading.exports.pages import feedback_comment
from gyrodata.grading.grade import Grade, two_decimals
from gyrodata.grading.ledger import read_number
from gyrodata.grading.submissions.names import PLATFORMS, Book
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

    grade: int  # column of the grades
    most: str  # possible points, as written
    labels: Mapping[int, str]  # the name of each row of a student, for people
    places: Mapping[
        tuple[str, str], list[int]
    ]  # rows by what names a student there, and the name in small letters
    # Moodle's column of the maximum; the next one says whether the grade can be changed
    top: int | None = None
    comment: int | None = None  # column of the comments


def fill_book(
    data: bytes,
    name: str,
    grades: Collection[Grade],
    assignment: str | None = None,
    ids: Mapping[str, Mapping[str, str]] = {},
    ours: Ours | None = None,
    comment: Callable[[Grade], str] = feedback_comment,
) -> Filled:
    """Write grades into the sheet that a platform exported.

    `assignment`: Title or number of the column, if there are several. `ids`:
    `Submission.ids` of each student. `ours`: Other totals stay, because a person has
    set them; None: all are overwritten. `comment`: Gives a plain text for the student.
    Raises InputError for a sheet that cannot be filled.
    """
    sheet = read_sheet(data, name)
    lms, book = _platform_of(sheet)
    layout = _layout_of(sheet, lms, book, assignment)
    _insist_on_points(sheet, layout, lms, next(iter(grades)).out_of)
    # Blackboard's sheet with tabs ends in .xls.
    file = f"{lms}.{'xls' if name.lower().endswith('.xls') else 'csv'}"
    filling = _Filling(sheet, layout, Filled(file), ours, comment)
    others = dict(layout.labels)  # rows of nobody who is graded
    for grade in sorted(grades, key=lambda grade: grade.student):
        rows = _rows_of(layout, book, grade, ids.get(grade.student, {}))
        if not rows:
            filling.skip(grade, f"is not in the {book.noun}")
        elif not _has_points(grade):
            why = f": {grade.why}" if grade.why else ""
            filling.skip(grade, f"is {grade.status}{why}")
        for row in rows:
            others.pop(row, None)
            filling.write(grade, row)
    filled = filling.filled
    filled.skipped += [(label, "has no submission") for label in others.values()]
    filled.data = sheet.to_bytes()
    return filled


def _layout_of(sheet: Sheet, lms: str, book: Book, assignment: str | None) -> _Layout:
    """Find the grades; the sheet of Moodle is the only one without assignments."""
    if book.assignment:
        return _columns(sheet, lms, book, assignment)
    return _worksheet(sheet, book)


def _insist_on_points(sheet: Sheet, layout: _Layout, lms: str, out_of: float) -> None:
    """Raise an error if the platform expects another number of points."""
    most = read_number(layout.most)
    if most is None or round(most, 2) == round(out_of, 2):
        return
    raise InputError.named(
        "gradebook_other_points" if layout.top is None else "worksheet_other_points",
        sheet.name,
        lms=lms.title(),
        name=sheet.name,
        most=layout.most,
        column=sheet.value(0, layout.grade),
        out_of=out_of,
    )


def _has_points(grade: Grade) -> bool:
    return grade.status == "graded" and grade.points is not None


def _rows_of(
    layout: _Layout, book: Book, grade: Grade, ids: Mapping[str, str]
) -> list[int]:
    """Return the rows of a student: several if the student is in several sections."""
    known = {"name": grade.name, "key": grade.student, **ids}
    if "moodle" in known:
        # It may be the number of another student in Canvas.
        del known["key"]
    for title, kinds in book.known_by:
        for kind in kinds:
            place = (title, known.get(kind, "").casefold())
            if kind in known and place in layout.places:
                return layout.places[place]
    return []


class _Filling(Struct):
    """A sheet while grades are written into it."""

    sheet: Sheet
    layout: _Layout
    filled: Filled
    ours: Ours | None
    comment: Callable[[Grade], str]

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
            mark = "," if re.search(r",\d+$", self.layout.most) else "."
            text = two_decimals(points).replace(".", mark)
            self._set(grade, row, self.layout.grade, text)
        if self.layout.comment is not None:
            text = _comment_cell(self.comment(grade))
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
        is_new = old == text or _EMPTY.fullmatch(old)
        if not is_new and read_number(old) != grade.points:
            self.filled.changed.append((grade.student, old, text))
        cells = self.sheet.rows[row]
        cells += [""] * (column + 1 - len(cells))
        cells[column] = text


def _comment_cell(text: str) -> str:
    """Return a comment as HTML.

    A spreadsheet does not read a text that begins with a tag as a formula.
    """
    paragraphs = re.sub(
        r"(?:(?<!\s)\s+)?\n\s*\n\s*", "</p><p>", html.escape(text).strip()
    )
    return f"<p>{paragraphs}</p>".replace("\n", "<br>")


# Contents of a cell: no grade yet; no grade is needed; the grade cannot be changed.
_EMPTY = re.compile(r"-?|(?:Needs Grading|In Progress)\b.*", re.IGNORECASE)
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


def _platform_of(sheet: Sheet) -> tuple[str, Book]:
    """Return the platform that exported a sheet.

    The header, or rows such as "Participant 7", determine the platform; otherwise it is
    Canvas.
    """
    head = "\t".join(sheet.head)
    books = {lms: platform.book for lms, platform in PLATFORMS.items() if platform.book}
    of_moodle = any(
        re.fullmatch(r"\D+\d+", sheet.value(row, 0))
        for row in range(1, len(sheet.rows))
    )
    lms = "moodle" if of_moodle else "canvas"
    if "[Total Pts:" in head:
        lms = "blackboard"
    lms = next(
        (
            one
            for one, book in books.items()
            if book.begins and re.match(book.begins, head)
        ),
        lms,
    )
    return lms, books[lms]


def _columns(sheet: Sheet, lms: str, book: Book, assignment: str | None) -> _Layout:
    """Find the grades in a sheet of Canvas or Blackboard.

    The sheet has columns with names and ids, and columns with assignments.
    """
    columns = {title.casefold(): at for at, title in enumerate(sheet.head)}
    key = columns.get(book.known_by[0][0].casefold())
    # A cell may contain a character that separates cells elsewhere.
    if key is None or not re.match(book.begins, "\t".join(sheet.head)):
        raise InputError.named(
            f"no_book_of_{lms}", sheet.name, name=sheet.name, columns=""
        )
    rows = range(1, len(sheet.rows))
    of_maximum = next(
        (row for row in rows if book.maximum and book.maximum in sheet.value(row, 0)),
        None,
    )
    assignments = _assignments(sheet, book, of_maximum)
    grade = _chosen_assignment(sheet, lms, assignments, assignment)
    match = assignments[grade]
    if match["locked"]:
        raise InputError.named(
            "gradebook_column_locked",
            sheet.name,
            name=sheet.name,
            column=sheet.head[grade],
            why=match["locked"],
            unlock=book.unlock,
        )
    labels: dict[int, str] = {}
    places: dict[tuple[str, str], list[int]] = {}
    for row in rows:
        if row == of_maximum or not sheet.value(row, key):
            continue
        labels[row] = ", ".join(sheet.value(row, at) for at in range(key))
        for title, _ in book.known_by:
            value = sheet.value(row, columns.get(title.casefold()))
            if value:
                places.setdefault((title, value.casefold()), []).append(row)
    return _Layout(grade, match["most"], labels, places)


def _assignments(
    sheet: Sheet, book: Book, of_maximum: int | None
) -> dict[int, re.Match[str]]:
    """Find the columns with assignments; `of_maximum` is the row of possible points."""
    pattern = re.compile(book.assignment, re.DOTALL | re.IGNORECASE)
    assignments = {}
    for at, title in enumerate(sheet.head):
        most = "" if of_maximum is None else sheet.value(of_maximum, at)
        match = pattern.fullmatch(f"{title}\n{most}")
        if match is not None:
            assignments[at] = match
    return assignments


def _chosen_assignment(
    sheet: Sheet,
    lms: str,
    assignments: Mapping[int, re.Match[str]],
    assignment: str | None,
) -> int:
    """Return the column of the assignment that the user names, or the only one."""
    if assignment is None:
        chosen = list(assignments)
        asked = "not one assignment"
    else:
        wanted = assignment.strip().casefold()
        chosen = [
            at
            for at, match in assignments.items()
            if wanted
            in map(str.casefold, (sheet.head[at], match["title"], match["number"]))
        ]
        asked = f'not exactly one column "{assignment}"'
    if len(chosen) == 1:
        return chosen[0]
    titles = listing([sheet.head[at] for at in assignments])
    give = "give the number after its title with --assignment; or "
    raise InputError.named(
        "gradebook_column_unclear",
        sheet.name,
        name=sheet.name,
        asked=asked,
        shown=titles or "none with a number after its title",
        give=give if assignments else "",
        lms=lms.title(),
    )


def _worksheet(sheet: Sheet, book: Book) -> _Layout:
    """Find the grades in a sheet of Moodle.

    The sheet has a row for each participant, with the maximum, a lock and comments.

    Columns are found by their English name, or else by their content: one number in
    every row.
    """
    rows = _participants(sheet)
    values = {
        at: {sheet.value(row, at) for row in rows} for at in range(2, len(sheet.head))
    }
    top = _column_of_maximum(sheet, values)
    if not rows or top < 2:
        columns = f"; its columns are: {listing(sheet.head)}"
        raise InputError.named(
            "no_book_of_moodle", sheet.name, name=sheet.name, columns=columns
        )
    places: dict[tuple[str, str], list[int]] = {}
    for row, number in rows.items():
        for value in {sheet.value(row, at).casefold() for at in range(2, top - 1)}:
            places.setdefault(("group", value), []).append(row)
        places.setdefault(("number", number), []).append(row)
    labels = {row: f"{sheet.value(row, 0)} ({sheet.value(row, 1)})" for row in rows}
    most = sheet.value(next(iter(rows)), top)
    comment = _column_of_comments(sheet, values, top)
    return _Layout(top - 1, most, labels, places, top, comment)


def _participants(sheet: Sheet) -> dict[int, str]:
    """Return the number of each row with "Participant N", in any language."""
    rows = {}
    for row in range(1, len(sheet.rows)):
        match = re.fullmatch(r"\D+(\d+)", sheet.value(row, 0))
        if match is not None:
            rows[row] = match[1]
    return rows


def _column_of_maximum(sheet: Sheet, values: Mapping[int, Collection[str]]) -> int:
    """Return the column of the maximum: the last one with one number; 0 if none has."""
    if "Maximum Grade" in sheet.head:
        return sheet.head.index("Maximum Grade")
    equal = [
        at
        for at, some in values.items()
        if len(some) == 1 and read_number(*some) is not None
    ]
    return equal[-1] if equal else 0


def _column_of_comments(
    sheet: Sheet, values: Mapping[int, Collection[str]], top: int
) -> int | None:
    """Return the last column if it contains comments and no dates; else None."""
    if "Feedback comments" in sheet.head:
        return sheet.head.index("Feedback comments")
    last = len(sheet.head) - 1
    if last <= top + 2:
        return None
    is_comment = any(not text or text.startswith("<") for text in values[last])
    return last if is_comment else None


# --- a CSV sheet in which only single cells may change ---


class Sheet(Struct):
    """A table, and the format of its file."""

    name: str  # shown name of the file
    rows: list[list[str]]  # all rows, blank ones too
    head: list[str]  # the first row, without spaces around the cells
    delimiter: str  # character between cells
    encoding: str
    quoted: (
        bool  # True: every cell is in quotation marks; False: only cells that need them
    )

    def value(self, row: int, column: int | None) -> str:
        """Return a cell without spaces around it; "" if the row has no such column."""
        cells = self.rows[row]
        return "" if column is None or column >= len(cells) else cells[column].strip()

    def to_bytes(self) -> bytes:
        """Return the whole file, with line ends of RFC 4180."""
        out = io.StringIO()
        writer = csv.writer(
            out,
            delimiter=self.delimiter,
            quoting=csv.QUOTE_ALL if self.quoted else csv.QUOTE_MINIMAL,
        )
        writer.writerows(self.rows)
        return out.getvalue().encode(self.encoding, "surrogateescape")


def read_sheet(data: bytes, name: str) -> Sheet:
    """Read a sheet with commas, semicolons or tabs, as its first lines have them."""
    encoding = "utf-8-sig" if data[:3] == b"\xef\xbb\xbf" else "utf-8"
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else encoding
    try:
        text = data.decode(
            encoding, "strict" if encoding == "utf-16" else "surrogateescape"
        )
        if not text.strip() or "\x00" in text:
            raise ValueError("is no text" if text.strip() else "is empty")
        head = re.sub(r'"[^"]*"', "", "\n".join(text[:100_000].splitlines()[:3]))
        delimiter = max(",;\t", key=head.count)
        rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
    except (ValueError, csv.Error) as error:
        why = "is no text" if isinstance(error, UnicodeDecodeError) else str(error)
        raise InputError.named("gradebook_not_read", name, name=name, why=why) from None
    quoted = (
        re.match(rf'(?:"(?:[^"]|"")*"{delimiter})*"(?:[^"]|"")*"[\r\n]', text)
        is not None
    )  # the first row
    return Sheet(
        name,
        rows,
        [cell.strip() for cell in rows[0]] or [""],
        delimiter,
        encoding,
        quoted,
    )
