"""Sheets of grades that platforms export, filled and given back: single cells change, all others stay as they were.

Canvas: a column keeps its ``(id)``, for without it Canvas makes a new assignment; scores are compared at two decimals;
the last ``.`` or ``,`` of a number is its decimal mark, so that ``1,234`` would be 1.234.

Blackboard: the same of a column's ``|id``; a sheet with commas has every cell in quotation marks.

Moodle: the importer passes over a row without a word where the grade is unchanged, above the maximum or locked; those
rows are told here instead. Headers are in the site's language, so that columns are known by what stands in them where
they are not English.
"""

from __future__ import annotations

import csv
import html
import io
import re
from collections.abc import Collection, Mapping, Sequence

from msgspec import Struct

from gyrodata import diagnostics
from gyrodata.errors import InputError
from gyrodata.grading.grade import Grade, two_decimals
from gyrodata.grading.ledger import TODO, read_number
from gyrodata.grading.platforms import PLATFORMS, Book
from gyrodata.readings import listing

Ids = Mapping[str, Mapping[str, str]]
Ours = Mapping[str, Collection[str] | None]
"""Totals that each student ever had from here, as written; None for one whose total may be written over."""


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
    """Write grades into the sheet that a platform exported: match, refuse, fill, tell.

    `assignment`: Title or number of the column, where there are several. `comments`: Plain text for each student.
    `ids`: `Submission.ids` of each. `ours`: Other totals stay, for somebody set them by hand; None: none stays.

    Gives: `skipped` names the rows that the platform would pass over without a word,
    and those with no grade; rows that were graded in Moodle after the export are not known here.
    """
    book = PLATFORMS[lms].book
    assert book is not None
    sheet = read_sheet(data, name)
    layout = _Columns(sheet, lms, book, assignment) if book.assignment else _Moodle(sheet, lms, book)
    layout.check_points(grades)
    mark = "," if re.search(r",\d+$", layout.most) else "."
    places = layout.rows_of(grades, ids)
    filled: list[str] = []
    changed: list[tuple[str, str, str]] = []
    skipped: list[tuple[str, str]] = []
    by_hand: list[tuple[str, str]] = []
    for grade in sorted(grades, key=lambda grade: grade.student):
        student, rows = grade.student, places.get(grade.student, [])
        if not rows:
            skipped.append((student, f"is in no row of the {book.noun}"))
            continue
        known = None if ours is None else ours.get(student, ())
        graded = grade.status == "graded"
        if not graded:
            skipped.append((student, f"is {grade.status}: {grade.why}" if grade.why else f"is {grade.status}"))
        written = two_decimals(grade.points).replace(".", mark)
        for row in rows:
            before = sheet.value(row, layout.grade)
            stands = read_number(before)
            same = graded and stands == grade.points
            if not same and stands is not None and known is not None and two_decimals(stands) not in known:
                skipped.append((student, f"has {before}, set by hand, which stays: see {TODO}"))
                by_hand.append((student, two_decimals(stands)))
                continue
            if grade.points is None or not graded:
                continue
            if why := layout.why_refused(row, grade.points):
                skipped.append((student, why))
                continue
            if same and layout.passes_over_same:
                skipped.append((student, f"has {before} in Moodle already: Moodle passes over the grade"))
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


_EMPTY = re.compile(r"-?|(?:Needs Grading|In Progress)\b.*", re.IGNORECASE)
_EXCUSED = ("ex", "n/a", "exempt", "exempted", "excused")
_NO = ("no", "nein", "non", "não", "nie", "нет", "ні", "ne", "nee", "nej", "nei", "hayır", "όχι", "いいえ", "否")
"""What cells say: that there is no grade yet, that none is asked for, and that it cannot be changed."""


def platform_of(data: bytes, name: str) -> str:
    """Return the platform that exported a gradebook, by its header or by rows of "Participant 7"; else Canvas."""
    rows = read_sheet(data, name).rows
    head = "\t".join(cell.strip() for cell in rows[0])
    books = ((lms, platform.book) for lms, platform in PLATFORMS.items() if platform.book and platform.book.begins)
    known = next((lms for lms, book in books if re.match(book.begins, head)), "")
    of_moodle = any(re.fullmatch(r"\D+\d+", row[0].strip()) for row in rows[1:] if row)
    return known or ("blackboard" if "[Total Pts:" in head else "moodle" if of_moodle else "canvas")


class _Layout:
    """The places of the columns in a sheet."""

    rows: list[int]  # of students
    grade: int  # columns
    comment: int | None = None
    most: str  # points possible, as written
    other_points = (
        diagnostics.GRADEBOOK_COLUMN_CANNOT_BE_FILLED
    )  # diagnostic of a sheet with other points than the rubric
    passes_over_same = False  # True: the platform does not take a grade that is there already

    def __init__(self, sheet: Sheet, lms: str, book: Book) -> None:
        self.sheet, self.platform, self.book = sheet, lms.title(), book
        self.head = [cell.strip() for cell in sheet.rows[0]] or [""]

    def check_points(self, grades: Collection[Grade]) -> None:
        """See that the sheet has the points of the rubric."""
        most = read_number(self.most)
        out_of = next((grade.out_of for grade in grades), None)
        if most is not None and out_of is not None and round(most, 2) != round(out_of, 2):
            words = f'has {self.most} points for "{self.head[self.grade]}", the rubric {out_of:g}'
            hint = f"make the points of the rubric and of the assignment in {self.platform} the same"
            raise refusal(self.other_points, self.sheet.name, words, hint)


class _Columns(_Layout):
    """Columns that say who a student is, and one for each assignment: Canvas, Blackboard."""

    def __init__(self, sheet: Sheet, lms: str, book: Book, assignment: str | None) -> None:
        super().__init__(sheet, lms, book)
        self.columns = {title.casefold(): at for at, title in enumerate(self.head)}
        # A cell may contain a character that separates cells elsewhere.
        if not re.match(book.begins, "\t".join(self.head)) or book.known_by[0][0].casefold() not in self.columns:
            raise refusal(book.code, sheet.name, book.none, book.export)
        self.key = self.columns[book.known_by[0][0].casefold()]
        every = range(1, len(sheet.rows))
        special = next((row for row in every if book.maximum and book.maximum in sheet.value(row, 0)), None)
        self.rows = [row for row in every if row != special and sheet.value(row, self.key)]
        points = ["" if special is None else sheet.value(special, at) for at in range(len(self.head))]
        self.grade, match = self._assignment_column(assignment, points)
        self.most = match["most"]
        if match["locked"]:
            message = f'takes no points in the column "{self.head[self.grade]}": {match["locked"]}'
            hint = f"{book.unlock}, or name another with --assignment"
            raise refusal(diagnostics.GRADEBOOK_COLUMN_CANNOT_BE_FILLED, sheet.name, message, hint)

    def label(self, row: int) -> str:
        """Name a row to a person."""
        return ", ".join(self.sheet.value(row, at) for at in range(self.key))

    def _assignment_column(self, assignment: str | None, points: Sequence[str]) -> tuple[int, re.Match[str]]:
        pattern = re.compile(self.book.assignment, re.DOTALL | re.IGNORECASE)
        cells = enumerate(zip(self.head, points, strict=True))
        found = titles = {at: match for at, pair in cells if (match := pattern.fullmatch("\n".join(pair)))}
        if assignment is not None:
            wanted = assignment.strip().casefold()
            names = {at: (self.head[at], match["title"], match["number"]) for at, match in titles.items()}
            found = {at: titles[at] for at in titles if wanted in map(str.casefold, names[at])}
        if len(found) == 1:
            return found.popitem()
        shown = listing([self.head[at] for at in titles]) or "none with a number behind its title"
        asked = f'no one column "{assignment}"' if assignment is not None else "not one assignment"
        hint = f"make the assignment in {self.platform} first, and export again"
        if titles:
            hint = f"give the number behind its title with --assignment; or {hint}"
        message = f"has {asked}; its assignments are: {shown}"
        raise refusal(diagnostics.GRADEBOOK_COLUMN_NOT_CLEAR, self.sheet.name, message, hint)

    def rows_of(self, grades: Collection[Grade], ids: Ids) -> dict[str, list[int]]:
        """Look in one column after the other, the platform's own first; several rows for one in several sections."""
        places: dict[tuple[str, str], list[int]] = {}
        for title, _ in self.book.known_by:
            for row in self.rows:
                if value := self.sheet.value(row, self.columns.get(title.casefold())):
                    places.setdefault((title, value.casefold()), []).append(row)
        found = {}
        for grade in grades:
            own = ids.get(grade.student, {})
            # Moodle's number of a student might be Canvas's of another.
            key = () if "moodle" in own else (grade.student,)
            names = [
                (title, value.casefold())
                for title, kinds in self.book.known_by
                for value in (*(own[kind] for kind in kinds if kind in own), *key)
            ]
            found[grade.student] = next((places[name] for name in names if name in places), [])
        return found

    def why_refused(self, row: int, points: float) -> str:
        """Say that a student is excused; "" for one who is not."""
        before = self.sheet.value(row, self.grade)
        return f'has "{before}" in the gradebook: excused or not assigned' if before.casefold() in _EXCUSED else ""


class _Moodle(_Layout):
    """A row for each participant, with the maximum grade, whether the grade can be changed, and comments."""

    other_points = diagnostics.WORKSHEET_CANNOT_TAKE_POINTS
    passes_over_same = True

    def __init__(self, sheet: Sheet, lms: str, book: Book) -> None:
        super().__init__(sheet, lms, book)
        self.rows = [row for row in range(1, len(sheet.rows)) if self._number_of(row) is not None]
        top = self._top_column()
        if not self.rows or top is None or top < 2:
            raise refusal(book.code, sheet.name, f"{book.none}; its columns are: {listing(self.head)}", book.export)
        self.top, self.grade = top, top - 1
        self.comment = self._comment_column()
        self.most = sheet.value(self.rows[0], top)

    def _number_of(self, row: int) -> str | None:
        """Read N of "Participant N", the first word in any language."""
        match = re.fullmatch(r"\D+(\d+)", self.sheet.value(row, 0))
        return match[1] if match else None

    def label(self, row: int) -> str:
        """Name a row to a person."""
        return f"{self.sheet.value(row, 0)} ({self.sheet.value(row, 1)})"

    def _top_column(self) -> int | None:
        """Find the maximum grade: by its English name, else the last column with one number in every row."""
        if "Maximum Grade" in self.head:
            return self.head.index("Maximum Grade")
        values = {at: {self.sheet.value(row, at) for row in self.rows} for at in range(2, len(self.head))}
        found = [at for at, texts in values.items() if len(texts) == 1 and (read_number(*texts) or 0) > 0]
        return found[-1] if found else None

    def _comment_column(self) -> int | None:
        """Find the comments: by their English name, else the last column if its cells are not dates."""
        if "Feedback comments" in self.head:
            return self.head.index("Feedback comments")
        last = len(self.head) - 1
        texts = [self.sheet.value(row, last) for row in self.rows]
        return last if last > self.top + 2 and any(not text or text.startswith("<") for text in texts) else None

    def rows_of(self, grades: Collection[Grade], ids: Ids) -> dict[str, list[int]]:
        """Give each row the grade of the group with the submission's name, else that of "Participant N"."""
        by_group = {grade.name.casefold(): grade.student for grade in grades}
        cells = {row: [self.sheet.value(row, at).casefold() for at in range(2, self.grade)] for row in self.rows}
        groups = {row: next((by_group[one] for one in cells[row] if one in by_group), None) for row in self.rows}
        # A group's number might be that of another participant.
        others = [grade.student for grade in grades if grade.student not in set(groups.values())]
        by_number = {ids.get(student, {}).get("moodle", student): student for student in others}
        found: dict[str, list[int]] = {}
        for row, group in groups.items():
            if student := group or by_number.get(self._number_of(row) or ""):
                found.setdefault(student, []).append(row)
        return found

    def why_refused(self, row: int, points: float) -> str:
        """Say why Moodle's importer would pass over the row; "" if it would not."""
        most = read_number(self.sheet.value(row, self.top))
        if self.sheet.value(row, self.top + 1).casefold() in _NO:
            return "is locked in Moodle: the grade cannot be changed"
        if most is not None and points > most:
            return f"has {points:g} points, more than the maximum grade {most:g}: Moodle passes over it"
        return ""


def _as_html(text: str) -> str:
    """Write a plain text as paragraphs; a spreadsheet does not read a text that begins with a tag as a formula."""
    paragraphs = re.split(r"\n\s*\n", text.strip())
    return "".join(f"<p>{html.escape(one.strip()).replace(chr(10), '<br>')}</p>" for one in paragraphs)


# --- a CSV sheet of somebody else's, in which single cells change and no other ------------------------------


LARGEST = 50_000_000  # bytes of a gradebook that are read


class Sheet(Struct):
    """A table, and how its file is written."""

    name: str  # shown name of the file
    rows: list[list[str]]  # all rows, blank ones too
    delimiter: str  # between cells
    mark: bytes  # byte-order mark
    encoding: str  # of the bytes behind it
    quoted: bool  # True: every cell is in quotation marks; False: one that needs them

    def value(self, row: int, column: int | None) -> str:
        """Give a cell without blanks around it; "" where the row has no such column."""
        cells = self.rows[row]
        return "" if column is None or column >= len(cells) else cells[column].strip()

    def put(self, row: int, column: int, value: str) -> None:
        """Write a cell; a row that is too short grows."""
        cells = self.rows[row]
        cells += [""] * (column + 1 - len(cells))
        cells[column] = value

    def to_bytes(self) -> bytes:
        """Give the whole sheet, its lines as RFC 4180 ends them."""
        out = io.StringIO()
        writer = csv.writer(out, delimiter=self.delimiter, quoting=csv.QUOTE_ALL if self.quoted else csv.QUOTE_MINIMAL)
        writer.writerows(self.rows)
        return self.mark + out.getvalue().encode(self.encoding, "surrogateescape")


class Filled(Struct, frozen=True):
    """A gradebook with grades in it."""

    data: bytes  # the file to upload
    filled: tuple[str, ...]  # students whose grade is in it now
    # student, the old and the new entry, if they differ and the old one was not empty
    changed: tuple[tuple[str, str, str], ...]
    skipped: tuple[tuple[str, str], ...]  # student or row, and why nothing was written for it
    by_hand: tuple[tuple[str, str], ...]  # student and total that somebody else set


_MARKS = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))


def read_sheet(data: bytes, name: str) -> Sheet:
    """Read a sheet with commas, semicolons or tabs, whichever its first lines have most of."""
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
    """Make the error for a gradebook that cannot be used."""
    return InputError.of(code, f'"{name}" {message}', hint, name)
