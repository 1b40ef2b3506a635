"""Fill the sheets of grades that platforms export: single cells change, all other cells stay as they were.

Canvas: a column keeps its ``(id)``, because without it Canvas makes a new assignment; scores are compared at two
decimals; the last ``.`` or ``,`` of a number is its decimal mark, so ``1,234`` would be 1.234.

Blackboard: the same for the ``|id`` of a column; a sheet with commas has every cell in quotation marks.

Moodle: its importer skips a row without a message if the grade is unchanged, above the maximum or locked; those rows
are reported here instead. Headers are in the language of the site, so columns are found by their content.
"""

from __future__ import annotations

import csv
import html
import io
import re
from collections.abc import Collection, Mapping

from msgspec import Struct

from gyrodata import diagnostics
from gyrodata.errors import InputError
from gyrodata.grading.grade import Grade, two_decimals
from gyrodata.grading.ledger import read_number
from gyrodata.grading.submissions.names import PLATFORMS, Book
from gyrodata.readings import listing

Ids = Mapping[str, Mapping[str, str]]
Ours = Mapping[str, Collection[str] | None]
"""Totals that each student ever had from gyro, as written; None if the student's total may be overwritten."""


class Filled(Struct, frozen=True):
    """A gradebook with grades in it."""

    data: bytes  # the file to upload
    filled: tuple[str, ...]  # students whose grade is in it now
    # student, old and new cell, if they differ and the old cell was not empty
    changed: tuple[tuple[str, str, str], ...]
    skipped: tuple[tuple[str, str], ...]  # student or row, and why nothing was written
    by_hand: tuple[tuple[str, str], ...]  # student and total that a person has set in the gradebook


def fill_book(
    lms: str,
    data: bytes,
    name: str,
    grades: Collection[Grade],
    *,
    assignment: str | None = None,
    comments: Mapping[str, str] = {},
    ids: Mapping[str, Mapping[str, str]] = {},
    ours: Ours | None = None,
) -> Filled:
    """Write grades into the sheet that a platform exported.

    `assignment`: Title or number of the column, if there are several. `comments`: Plain text for each student. `ids`:
    `Submission.ids` of each. `ours`: Other totals stay, because a person has set them; None: all are overwritten.
    Raises InputError for a sheet that cannot be filled.
    """
    book = PLATFORMS[lms].book
    assert book is not None
    sheet = read_sheet(data, name)
    layout = _Columns(sheet, lms, book, assignment) if book.assignment else _Moodle(sheet, book)
    most, out_of = read_number(layout.most), next((grade.out_of for grade in grades), None)
    if most is not None and out_of is not None and round(most, 2) != round(out_of, 2):
        words = f'has {layout.most} points for "{layout.head[layout.grade]}", the rubric {out_of:g}'
        hint = f"make the points of the rubric and of the assignment in {lms.title()} the same"
        raise refusal(layout.other_points, name, words, hint)
    mark = "," if re.search(r",\d+$", layout.most) else "."
    places = layout.rows_of(grades, ids)
    filled, changed = list[str](), list[tuple[str, str, str]]()
    skipped, by_hand = list[tuple[str, str]](), list[tuple[str, str]]()
    for grade in sorted(grades, key=lambda grade: grade.student):
        student, rows = grade.student, places.get(grade.student, [])
        known = None if ours is None else ours.get(student, ())
        graded = grade.status == "graded" and grade.points is not None
        points, written = grade.points or 0.0, two_decimals(grade.points).replace(".", mark)
        if not rows or not graded:
            why = f"is {grade.status}{f': {grade.why}' if grade.why else ''}"
            skipped.append((student, why if rows else f"is not in the {book.noun}"))
        for row in rows:
            before = sheet.value(row, layout.grade)
            there = read_number(before)
            same = graded and there == points
            if not same and there is not None and known is not None and two_decimals(there) not in known:
                skipped.append((student, f"has {before}, set by hand, which is kept"))
                by_hand.append((student, two_decimals(there)))
                continue
            if not graded:
                continue
            if why := layout.why_refused(row, points):
                skipped.append((student, why))
                continue
            if same and layout.skips_same:
                skipped.append((student, f"has {before} in Moodle already: Moodle skips the grade"))
            else:
                if not same and not _EMPTY.fullmatch(before):
                    changed.append((student, before, written))
                sheet.put(row, layout.grade, written)
            if layout.comment is not None and student in comments:
                before, text = sheet.value(row, layout.comment), _as_html(comments[student])
                if before not in ("", text):
                    changed.append((student, before, text))
                sheet.put(row, layout.comment, text)
            filled.append(student)
    asked = {row for rows in places.values() for row in rows}
    skipped += [(layout.label(row), "has no submission") for row in layout.rows if row not in asked]
    return Filled(sheet.to_bytes(), tuple(dict.fromkeys(filled)), tuple(changed), tuple(skipped), tuple(by_hand))


# Contents of a cell: no grade yet; no grade is needed; the grade cannot be changed.
_EMPTY = re.compile(r"-?|(?:Needs Grading|In Progress)\b.*", re.IGNORECASE)
_EXCUSED = ("ex", "n/a", "exempt", "exempted", "excused")
_NO = ("no", "nein", "non", "não", "nie", "нет", "ні", "ne", "nee", "nej", "nei", "hayır", "όχι", "いいえ", "否")


def platform_of(data: bytes, name: str) -> str:
    """Return the platform that exported a gradebook, by its header or by rows of "Participant 7"; else Canvas."""
    rows = read_sheet(data, name).rows
    head = "\t".join(cell.strip() for cell in rows[0])
    books = ((lms, platform.book) for lms, platform in PLATFORMS.items() if platform.book and platform.book.begins)
    known = next((lms for lms, book in books if re.match(book.begins, head)), "")
    of_moodle = any(re.fullmatch(r"\D+\d+", row[0].strip()) for row in rows[1:] if row)
    return known or ("blackboard" if "[Total Pts:" in head else "moodle" if of_moodle else "canvas")


class _Columns:
    """The sheet of Canvas or Blackboard: columns with names and ids, and a column for each assignment."""

    other_points = diagnostics.GRADEBOOK_COLUMN_CANNOT_BE_FILLED  # code if the sheet has other points than the rubric
    skips_same = False  # True if the platform skips a grade that has not changed
    comment: int | None = None  # column of the comments

    def __init__(self, sheet: Sheet, lms: str, book: Book, assignment: str | None) -> None:
        self.sheet, self.book = sheet, book
        self.head = [cell.strip() for cell in sheet.rows[0]] or [""]
        self.columns = {title.casefold(): at for at, title in enumerate(self.head)}
        # A cell may contain a character that separates cells elsewhere.
        if not re.match(book.begins, "\t".join(self.head)) or book.known_by[0][0].casefold() not in self.columns:
            raise refusal(book.code, sheet.name, book.none, book.export)
        self.key = self.columns[book.known_by[0][0].casefold()]
        every = range(1, len(sheet.rows))
        special = next((row for row in every if book.maximum and book.maximum in sheet.value(row, 0)), None)
        self.rows = [row for row in every if row != special and sheet.value(row, self.key)]  # rows of students
        pattern = re.compile(book.assignment, re.DOTALL | re.IGNORECASE)
        points = ["" if special is None else sheet.value(special, at) for at in range(len(self.head))]
        matches = map(pattern.fullmatch, map("{}\n{}".format, self.head, points))
        found = titles = {at: match for at, match in enumerate(matches) if match}
        if assignment is not None:
            wanted = assignment.strip().casefold()
            names = {at: (self.head[at], match["title"], match["number"]) for at, match in titles.items()}
            found = {at: titles[at] for at in titles if wanted in map(str.casefold, names[at])}
        if len(found) != 1:
            shown = listing([self.head[at] for at in titles]) or "none with a number after its title"
            asked = f'not exactly one column "{assignment}"' if assignment is not None else "not one assignment"
            hint = "give the number after its title with --assignment; or " if titles else ""
            hint += f"make the assignment in {lms.title()} first, and export again"
            message = f"has {asked}; its assignments are: {shown}"
            raise refusal(diagnostics.GRADEBOOK_COLUMN_NOT_CLEAR, sheet.name, message, hint)
        ((self.grade, match),) = found.items()  # column of the grades
        self.most: str = match["most"]  # possible points, as written
        if match["locked"]:
            message = f'takes no points in the column "{self.head[self.grade]}": {match["locked"]}'
            hint = f"{book.unlock}, or name another with --assignment"
            raise refusal(diagnostics.GRADEBOOK_COLUMN_CANNOT_BE_FILLED, sheet.name, message, hint)

    def label(self, row: int) -> str:
        """Return the name of a row for people."""
        return ", ".join(self.sheet.value(row, at) for at in range(self.key))

    def rows_of(self, grades: Collection[Grade], ids: Ids) -> dict[str, list[int]]:
        """Find the rows of each student, by the columns in the order of the book; several if in several sections."""
        places: dict[tuple[str, str], list[int]] = {}
        for title, _ in self.book.known_by:
            for row in self.rows:
                if value := self.sheet.value(row, self.columns.get(title.casefold())):
                    places.setdefault((title, value.casefold()), []).append(row)
        found = {}
        for grade in grades:
            own = ids.get(grade.student, {})
            # The number of a student in Moodle may be that of another student in Canvas.
            key = () if "moodle" in own else (grade.student,)
            names = [
                (title, value.casefold())
                for title, kinds in self.book.known_by
                for value in (*(own[kind] for kind in kinds if kind in own), *key)
            ]
            found[grade.student] = next((places[name] for name in names if name in places), [])
        return found

    def why_refused(self, row: int, points: float) -> str:
        """Return why the platform would not take a grade; "" if it would."""
        before = self.sheet.value(row, self.grade)
        return f'has "{before}" in the gradebook: excused or not assigned' if before.casefold() in _EXCUSED else ""


class _Moodle:
    """The sheet of Moodle: a row for each participant, with the maximum grade, a lock, and comments."""

    other_points = diagnostics.WORKSHEET_CANNOT_TAKE_POINTS
    skips_same = True

    def __init__(self, sheet: Sheet, book: Book) -> None:
        self.sheet, self.head = sheet, [cell.strip() for cell in sheet.rows[0]] or [""]
        self.rows = [row for row in range(1, len(sheet.rows)) if self._number_of(row) is not None]
        # Columns are found by their English name, or else by their content: one number in every row.
        values = {at: {sheet.value(row, at) for row in self.rows} for at in range(2, len(self.head))}
        equal = [at for at, some in values.items() if len(some) == 1 and read_number(*some) is not None]
        top = self.head.index("Maximum Grade") if "Maximum Grade" in self.head else equal[-1] if equal else 0
        if not self.rows or top < 2:
            raise refusal(book.code, sheet.name, f"{book.none}; its columns are: {listing(self.head)}", book.export)
        self.top, self.grade, self.most = top, top - 1, sheet.value(self.rows[0], top)
        # The last column contains comments if its cells are not dates.
        last = len(self.head) - 1
        is_comment = last > top + 2 and any(not text or text.startswith("<") for text in values[last])
        self.comment = last if is_comment else None
        if "Feedback comments" in self.head:
            self.comment = self.head.index("Feedback comments")

    def _number_of(self, row: int) -> str | None:
        """Return N of "Participant N", in any language."""
        match = re.fullmatch(r"\D+(\d+)", self.sheet.value(row, 0))
        return match[1] if match else None

    def label(self, row: int) -> str:
        """Return the name of a row for people."""
        return f"{self.sheet.value(row, 0)} ({self.sheet.value(row, 1)})"

    def rows_of(self, grades: Collection[Grade], ids: Ids) -> dict[str, list[int]]:
        """Find the rows of each student: those of the group with the name, or else that of "Participant N"."""
        by_group = {grade.name.casefold(): grade.student for grade in grades}
        cells = {row: [self.sheet.value(row, at).casefold() for at in range(2, self.grade)] for row in self.rows}
        groups = {row: next((by_group[one] for one in cells[row] if one in by_group), None) for row in self.rows}
        # The number of a group might be that of another participant.
        others = [grade.student for grade in grades if grade.student not in set(groups.values())]
        by_number = {ids.get(student, {}).get("moodle", student): student for student in others}
        found: dict[str, list[int]] = {}
        for row, group in groups.items():
            if student := group or by_number.get(self._number_of(row) or ""):
                found.setdefault(student, []).append(row)
        return found

    def why_refused(self, row: int, points: float) -> str:
        """Return why the platform would not take a grade; "" if it would."""
        most = read_number(self.sheet.value(row, self.top))
        if self.sheet.value(row, self.top + 1).casefold() in _NO:
            return "is locked in Moodle: the grade cannot be changed"
        if most is not None and points > most:
            return f"has {points:g} points, more than the maximum grade {most:g}: Moodle skips it"
        return ""


def _as_html(text: str) -> str:
    """Write a plain text as paragraphs; a spreadsheet does not read a text that begins with a tag as a formula."""
    paragraphs = re.split(r"\n\s*\n", text.strip())
    return "".join(f"<p>{html.escape(one.strip()).replace(chr(10), '<br>')}</p>" for one in paragraphs)


# --- a CSV sheet in which only single cells may change ------------------------------------------------------


LARGEST = 50_000_000  # bytes of a gradebook that are read


class Sheet(Struct):
    """A table, and the format of its file."""

    name: str  # shown name of the file
    rows: list[list[str]]  # all rows, blank ones too
    delimiter: str  # character between cells
    mark: bytes  # byte-order mark
    encoding: str  # of the rest of the file
    quoted: bool  # True: every cell is in quotation marks; False: only cells that need them

    def value(self, row: int, column: int | None) -> str:
        """Return a cell without spaces around it; "" if the row has no such column."""
        cells = self.rows[row]
        return "" if column is None or column >= len(cells) else cells[column].strip()

    def put(self, row: int, column: int, value: str) -> None:
        """Write a cell; a row that is too short becomes longer."""
        cells = self.rows[row]
        cells += [""] * (column + 1 - len(cells))
        cells[column] = value

    def to_bytes(self) -> bytes:
        """Return the whole file, with line ends of RFC 4180."""
        out = io.StringIO()
        writer = csv.writer(out, delimiter=self.delimiter, quoting=csv.QUOTE_ALL if self.quoted else csv.QUOTE_MINIMAL)
        writer.writerows(self.rows)
        return self.mark + out.getvalue().encode(self.encoding, "surrogateescape")


_MARKS = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))


def read_sheet(data: bytes, name: str) -> Sheet:
    """Read a sheet with commas, semicolons or tabs: the most common of them in the first lines."""
    mark, encoding = next((pair for pair in _MARKS if data.startswith(pair[0])), (b"", "utf-8"))
    try:
        if len(data) > LARGEST:
            raise ValueError("is larger than 50 MB")
        text = data[len(mark) :].decode(encoding, "surrogateescape" if encoding == "utf-8" else "strict")
        if not text.strip() or "\x00" in text:
            raise ValueError("is no text" if text.strip() else "is empty")
        head = re.sub(r'"[^"]*"', "", "\n".join(text[:100_000].splitlines()[:3]))
        delimiter = max(",;\t", key=head.count)
        rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
    except (ValueError, csv.Error) as error:
        why = "is no text" if isinstance(error, UnicodeDecodeError) else str(error)
        hint = "give the CSV file that the gradebook exports, not a workbook"
        hint = "export the gradebook again" if why == "is empty" else hint
        raise refusal(diagnostics.GRADEBOOK_CANNOT_BE_READ, name, why, hint) from None
    first = f'"{delimiter}"'.join(cell.replace('"', '""') for cell in rows[0])
    return Sheet(name, rows, delimiter, mark, encoding, text.startswith(f'"{first}"'))


def refusal(code: str, name: str, message: str, hint: str) -> InputError:
    """Return the error for a gradebook that cannot be used."""
    return InputError.of(code, f'"{name}" {message}', hint, name)
