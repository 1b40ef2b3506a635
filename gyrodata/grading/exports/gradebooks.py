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
    top: int | None = (
        # Moodle's column of the maximum; the next one says whether the grade can be
        # changed
        None
    )
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
    layout = (
        _columns(sheet, lms, book, assignment)
        if book.assignment
        else _worksheet(sheet, book)
    )
    most, out_of = read_number(layout.most), next(iter(grades)).out_of
    if most is not None and round(most, 2) != round(out_of, 2):
        words = {
            "name": name,
            "most": layout.most,
            "column": sheet.value(0, layout.grade),
            "out_of": out_of,
        }
        of_sheet = "worksheet_other_points" if layout.top else "gradebook_other_points"
        raise InputError.named(of_sheet, name, lms=lms.title(), **words)
    mark = "," if re.search(r",\d+$", layout.most) else "."
    # Blackboard's sheet with tabs ends in .xls.
    found = Filled(f"{lms}.{'xls' if name.lower().endswith('.xls') else 'csv'}")
    others = dict(layout.labels)  # rows of nobody who is graded
    for grade in sorted(grades, key=lambda grade: grade.student):
        student, known = (
            grade.student,
            None if ours is None else ours.get(grade.student, ()),
        )
        own = {"name": grade.name, "key": student, **ids.get(student, {})}
        if "moodle" in own:
            del own["key"]  # it may be the number of another student in Canvas
        names = [
            (title, own[kind].casefold())
            for title, kinds in book.known_by
            for kind in kinds
            if kind in own
        ]
        rows = next((layout.places[one] for one in names if one in layout.places), [])
        graded, points = (
            grade.status == "graded" and grade.points is not None,
            grade.points or 0.0,
        )
        if not rows or not graded:
            why = f"is {grade.status}{f': {grade.why}' if grade.why else ''}"
            found.skipped.append(
                (student, why if rows else f"is not in the {book.noun}")
            )
        for row in rows:
            others.pop(row, None)
            before = sheet.value(row, layout.grade)
            there = read_number(before)
            same = graded and there == points
            if (
                not same
                and there is not None
                and known is not None
                and two_decimals(there) not in known
            ):
                found.skipped.append(
                    (student, f"has {before}, set by hand, which is kept")
                )
                found.by_hand.append((student, two_decimals(there)))
            elif graded and (why := _why_refused(sheet, layout, row, points)):
                found.skipped.append((student, why))
            elif graded:
                cells = {layout.grade: two_decimals(points).replace(".", mark)}
                if same and layout.top:
                    found.skipped.append(
                        (
                            student,
                            f"has {before} in Moodle already: Moodle skips the grade",
                        )
                    )
                    cells = {}
                if layout.comment is not None:
                    # A spreadsheet does not read a text that begins with a tag as a
                    # formula.
                    told = re.sub(
                        r"(?:(?<!\s)\s+)?\n\s*\n\s*",
                        "</p><p>",
                        html.escape(comment(grade)).strip(),
                    )
                    cells[layout.comment] = f"<p>{told}</p>".replace("\n", "<br>")
                for column, text in cells.items():
                    old = sheet.value(row, column)
                    if (
                        old != text
                        and not _EMPTY.fullmatch(old)
                        and read_number(old) != points
                    ):
                        found.changed.append((student, old, text))
                    sheet.rows[row] += [""] * (column + 1 - len(sheet.rows[row]))
                    sheet.rows[row][column] = text
                if student not in found.filled[-1:]:
                    found.filled.append(student)
    found.skipped += [(label, "has no submission") for label in others.values()]
    found.data = sheet.to_bytes()
    return found


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
    every = range(1, len(sheet.rows))
    special = next(
        (row for row in every if book.maximum and book.maximum in sheet.value(row, 0)),
        None,
    )
    points = {
        at: "" if special is None else sheet.value(special, at)
        for at in range(len(sheet.head))
    }
    pattern = re.compile(book.assignment, re.DOTALL | re.IGNORECASE)
    matches = {
        at: pattern.fullmatch(f"{sheet.head[at]}\n{most}")
        for at, most in points.items()
    }
    titles = {at: match for at, match in matches.items() if match}
    wanted = None if assignment is None else assignment.strip().casefold()
    names = {
        at: (sheet.head[at], match["title"], match["number"])
        for at, match in titles.items()
    }
    found = {
        at: titles[at]
        for at in titles
        if wanted is None or wanted in map(str.casefold, names[at])
    }
    if len(found) != 1:
        shown = (
            listing([sheet.head[at] for at in titles])
            or "none with a number after its title"
        )
        asked = (
            f'not exactly one column "{assignment}"'
            if assignment is not None
            else "not one assignment"
        )
        give = (
            "give the number after its title with --assignment; or " if titles else ""
        )
        values = {
            "name": sheet.name,
            "asked": asked,
            "shown": shown,
            "give": give,
            "lms": lms.title(),
        }
        raise InputError.named("gradebook_column_unclear", sheet.name, **values)
    ((grade, match),) = found.items()
    if match["locked"]:
        values = {
            "name": sheet.name,
            "column": sheet.head[grade],
            "why": match["locked"],
            "unlock": book.unlock,
        }
        raise InputError.named("gradebook_column_locked", sheet.name, **values)
    labels, places = dict[int, str](), dict[tuple[str, str], list[int]]()
    for row in (row for row in every if row != special and sheet.value(row, key)):
        labels[row] = ", ".join(sheet.value(row, at) for at in range(key))
        for title, _ in book.known_by:
            if value := sheet.value(row, columns.get(title.casefold())):
                places.setdefault((title, value.casefold()), []).append(
                    row
                )  # several if in several sections
    return _Layout(grade, match["most"], labels, places)


def _worksheet(sheet: Sheet, book: Book) -> _Layout:
    """Find the grades in a sheet of Moodle.

    The sheet has a row for each participant, with the maximum, a lock and comments.

    Columns are found by their English name, or else by their content: one number in
    every row.
    """
    matches = {
        row: re.fullmatch(r"\D+(\d+)", sheet.value(row, 0))
        for row in range(1, len(sheet.rows))
    }
    rows = {
        row: match[1] for row, match in matches.items() if match
    }  # "Participant N", in any language
    values = {
        at: {sheet.value(row, at) for row in rows} for at in range(2, len(sheet.head))
    }
    equal = [
        at
        for at, some in values.items()
        if len(some) == 1 and read_number(*some) is not None
    ]
    top = equal[-1] if equal else 0
    if "Maximum Grade" in sheet.head:
        top = sheet.head.index("Maximum Grade")
    if not rows or top < 2:
        columns = f"; its columns are: {listing(sheet.head)}"
        raise InputError.named(
            "no_book_of_moodle", sheet.name, name=sheet.name, columns=columns
        )
    # The last column contains comments if its cells are not dates.
    last = len(sheet.head) - 1
    is_comment = last > top + 2 and any(
        not text or text.startswith("<") for text in values[last]
    )
    told = "Feedback comments"
    comment = last if is_comment else None
    if told in sheet.head:
        comment = sheet.head.index(told)
    places: dict[tuple[str, str], list[int]] = {}
    for row, number in rows.items():
        for value in {sheet.value(row, at).casefold() for at in range(2, top - 1)}:
            places.setdefault(("group", value), []).append(row)
        places.setdefault(("number", number), []).append(row)
    labels = {row: f"{sheet.value(row, 0)} ({sheet.value(row, 1)})" for row in rows}
    return _Layout(
        top - 1, sheet.value(next(iter(rows)), top), labels, places, top, comment
    )


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
    """Read a sheet with commas, semicolons or tabs: the most common of them in the first lines."""
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
