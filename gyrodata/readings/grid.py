"""From text to rows of cells: delimiter, quotes, ``#`` lines and limits."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import NamedTuple

from gyrodata.diagnostics import (
    CELL_TOO_LONG,
    NO_DELIMITER,
    QUOTE_NEVER_CLOSED,
    ROW_TAKEN_OUT,
    TOO_MANY_COLUMNS,
    TOO_MANY_ROWS,
)
from gyrodata.readings.lablog import Faults, Place, Text, span
from gyrodata.readings.source import MAX_COLUMNS, MAX_ROWS, Document

MAX_CELL = 10_000


class Row(NamedTuple):
    """One row of a table."""

    line: int
    """Where it begins."""
    texts: list[str]
    """Its cells, without quotes and without blanks around them; blank ones at the end are cut off."""
    origin: tuple[tuple[int, int], ...] | None = None
    """Line and number of each cell in the file, where they are not those of this row."""

    def spot(self, at: int) -> int:
        """Number a cell of the file."""
        line, column = self.origin[at] if self.origin is not None and at < len(self.origin) else (self.line, at)
        return line * MAX_COLUMNS + column


@dataclass(frozen=True)
class Grid:
    """The rows of a table, and the ``# key: value`` lines around it."""

    lines: list[str]
    """Of the file."""
    delimiter: str
    rows: list[Row]
    """Rows that are neither comments nor blank."""
    metadata: list[tuple[str, Text]]
    """Keys with their values, in the order of the file."""
    comments: list[Text]
    """``#`` lines that say no ``key: value``."""

    def cell(self, row: Row, at: int) -> Text:
        """Give one cell with its place, which only a fault asks for."""
        return Text(row.texts[at], *find_place(self.lines, self.delimiter, row.spot(at)))

    def cells(self, row: Row) -> list[Text]:
        """Give the cells of one row with their places."""
        return [self.cell(row, at) for at in range(len(row.texts))]


# Marks of order and width that a copy from a web page or a chat brings along, and that no editor shows.
_UNSEEN = "\ufeff\u200b\u200c\u200d\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2060 \u00a0"
_DECIMAL = re.compile(r"[-+−]?[0-9]+([.,])([0-9]+)")
_DELIMITERS = ("\t", ";", ",")
_KEY = re.compile(r"\s*([^\W\d][\w .()/\-]{0,39}?)\s*[:=]\s*(.*)", re.DOTALL)


def make_grid(document: Document) -> Grid:
    """Split a log into cells."""
    faults = document.faults
    lines = faults.lines
    body: list[int] = []  # indices of the table's lines
    metadata: list[tuple[str, Text]] = []
    comments: list[Text] = []
    forced = document.delimiter
    for index, line in enumerate(lines):
        if not line or line.isspace():
            continue
        if line[0] in '# "\t' and re.match(r'[ "\t]*#(?!\s*[;,\t])', line):
            _read_comment(line, index + 1, metadata, comments)
        elif index == 0 and re.fullmatch(r"sep=[;,\t]\s*", line):
            forced = line[4]  # what Excel writes for itself
        else:
            body.append(index)
    if len(body) - 1 > MAX_ROWS:  # without the header
        raise faults.refuse(
            TOO_MANY_ROWS, f"{len(body) - 1} rows; at most 100 000 are read", "a lab log has some dozens"
        )
    delimiter = forced or find_delimiter([lines[i] for i in body[:30]])
    if delimiter is None and body:
        line = lines[body[0]]
        hint = "put a comma, a semicolon or a tab between the columns"
        raise faults.refuse(
            NO_DELIMITER, "no delimiter between the columns was found", hint, Place(body[0] + 1, 1), len(line)
        )
    rows = _split_rows(lines, body, delimiter or ",", faults)
    width = len(rows[0].texts) if rows else 0
    hidden = [
        c.line
        for c in comments
        if delimiter and width > 2 and c.text.count(delimiter) == width - 1 and c.text[:1].isdigit()
    ]
    if hidden:
        faults.add(ROW_TAKEN_OUT, f"{span(hidden)}: begins with # and is left out", "", Place(hidden[0], 1))
    return Grid(lines, delimiter or ",", rows, metadata, comments)


def decimal_signs(grid: Grid, by_delimiter: bool = True) -> set[str]:
    """Give the decimal signs of a table's first numbers, as far as no mark between thousands looks like them."""
    signs = {
        match[1]
        for row in grid.rows[:50]
        for text in row.texts
        if (match := _DECIMAL.fullmatch(text)) and (len(match[2]) != 3 or text[0] == "0")
    }
    # Where a spreadsheet parts the cells with semicolons, the comma is the decimal sign.
    return signs or ({","} if by_delimiter and grid.delimiter == ";" else set())


def _read_comment(line: str, number: int, metadata: list[tuple[str, Text]], comments: list[Text]) -> None:
    """Read ``# key: value``; a spreadsheet may have quoted the line or hung delimiters on it."""
    start = line.index("#") + 1
    content = line[start:].rstrip(" \t,;")
    if line.lstrip().startswith('"'):
        content = content.rstrip('"').replace('""', '"')
    match = _KEY.fullmatch(content)
    if match is None:
        comments.append(Text(content.strip(), number, start))
        return
    key = re.sub(r"[\s\-]+", "_", match[1].strip())
    metadata.append((key, Text(match[2].strip(), number, start + match.start(2) + 1)))


def find_delimiter(lines: list[str]) -> str | None:
    """Take the delimiter that cuts most rows into equally many cells."""
    best, best_share = None, 0.0
    for delimiter in _DELIMITERS:
        counts = [_count(line[: 4 * MAX_CELL], delimiter) for line in lines]
        often = Counter(count for count in counts if count)
        if not often:
            continue
        # Titles may stand above the header, and a row may lack the delimiters of its blank cells.
        share = max(often[max(counts[:2])] if any(counts[:2]) else 0, often.most_common(1)[0][1]) / len(counts)
        if best is None or share > best_share + 0.3:
            best, best_share = delimiter, share
    return best


def _count(line: str, delimiter: str) -> int:
    if '"' in line:
        line = re.sub(r'"[^"]*"', "", line)
    return line.count(delimiter)


def _split_rows(lines: list[str], body: list[int], delimiter: str, faults: Faults) -> list[Row]:
    rows: list[Row] = []
    until = -1  # last line of a quoted cell that goes over several lines
    for index in body:
        if index <= until:
            continue
        line = lines[index]
        if '"' in line:
            cells, until = _split_quoted(lines, index, delimiter, faults)
            texts = [cell.text for cell in cells]
        else:
            texts = [part.strip() for part in line.split(delimiter)]
            if not line.isascii():
                texts = [text.strip(_UNSEEN).strip() for text in texts]
            if len(line) > MAX_CELL or len(texts) > MAX_COLUMNS:
                _check_sizes(line, index + 1, delimiter, faults)
        while texts and not texts[-1]:
            texts.pop()
        if len(texts) > MAX_COLUMNS:
            raise _too_many_columns(len(texts), index + 1, faults)
        if texts:
            rows.append(Row(index + 1, texts))
    return rows


def _check_sizes(line: str, number: int, delimiter: str, faults: Faults) -> None:
    if line.count(delimiter) > MAX_COLUMNS and line.rstrip(delimiter + " ").count(delimiter) >= MAX_COLUMNS:
        raise _too_many_columns(line.count(delimiter) + 1, number, faults)
    for at, part in enumerate(line.split(delimiter)):
        if len(part) > MAX_CELL:
            raise _long_cell(len(part), find_cell(faults.lines, delimiter, number, at), faults)


def _too_many_columns(count: int, line: int, faults: Faults) -> Exception:
    hint = "a lab log has about ten; is this another table?"
    return faults.refuse(TOO_MANY_COLUMNS, f"{count} columns; at most {MAX_COLUMNS} are read", hint, Place(line, 1))


def _long_cell(length: int, cell: Text, faults: Faults) -> Exception:
    return faults.refuse(CELL_TOO_LONG, f"a cell of {length} characters; at most 10 000 are read", "", cell.place)


def find_cell(lines: list[str], delimiter: str, line: int, at: int) -> Text:
    """Find the place of one cell of the row that begins in a line."""
    whole = lines[line - 1]
    if '"' in whole:
        return _split_quoted(lines, line - 1, delimiter, Faults(""))[0][at]
    parts = whole.split(delimiter)
    text = parts[at].strip()
    text = text if whole.isascii() else text.strip(_UNSEEN).strip()
    before = sum(len(part) + 1 for part in parts[:at])
    return Text(text, line, 1 + before + (parts[at].index(text) if text else 0))


def find_place(lines: list[str], delimiter: str, spot: int) -> Place:
    """Find where a cell stands by its number."""
    line, at = divmod(spot, MAX_COLUMNS)
    return find_cell(lines, delimiter, line, at).place


def _split_quoted(lines: list[str], index: int, delimiter: str, faults: Faults) -> tuple[list[Text], int]:
    """Split a line with quoted cells; one of them may go on in the next lines."""
    row: list[Text] = []
    line, position = lines[index], 0
    while True:
        start = position
        while start < len(line) and line[start] in " \u00a0":
            start += 1
        if line.startswith('"', start):
            place = Place(index + 1, start + 1)
            text, index, position = _read_quoted(lines, index, start + 1, place, faults)
            line = lines[index]
            end = line.find(delimiter, position)
            end = len(line) if end < 0 else end
            row.append(Text((text + line[position:end]).strip(), place.line, place.column + 1))
        else:
            end = line.find(delimiter, position)
            end = len(line) if end < 0 else end
            text = line[position:end].strip()
            row.append(Text(text, index + 1, min(start, end) + 1))
        if len(row[-1].text) > MAX_CELL:
            raise _long_cell(len(row[-1].text), row[-1], faults)
        if end >= len(line):
            return row, index
        if len(row) > MAX_COLUMNS * 2:
            raise _too_many_columns(line.count(delimiter) + 1, index + 1, faults)
        position = end + 1


def _read_quoted(lines: list[str], index: int, position: int, opened: Place, faults: Faults) -> tuple[str, int, int]:
    """Read up to the closing quote; give the text, and the line and position behind the quote."""
    parts: list[str] = []
    length = 0
    while True:
        line = lines[index]
        end = line.find('"', position)
        if end < 0:
            parts.append(line[position:] + " ")
            length += len(line) - position + 1
            index, position = index + 1, 0
        elif line.startswith('""', end):
            parts.append(line[position : end + 1])
            length += end + 1 - position
            position = end + 2
        else:
            parts.append(line[position:end])
            return "".join(parts), index, end + 1
        if index >= len(lines) or length > MAX_CELL:
            message = "a quoted cell begins here and is never closed"
            raise faults.refuse(QUOTE_NEVER_CLOSED, message, 'close it with ", or take the quote away', opened)
