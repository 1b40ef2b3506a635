"""A CSV sheet of somebody else's, in which single cells change and every other byte stays.

The csv module gives values, not how they were written; a gradebook is given back as it came: its byte-order mark,
delimiter, quotes and line ends.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from gyrodata.diagnostics import GRADEBOOK_CANNOT_BE_READ
from gyrodata.errors import Diagnostic, InputError

LARGEST = 50_000_000  # bytes of a gradebook that are read


class Cell(NamedTuple):
    """One cell."""

    value: str
    written: str  # as it stands in the file, quotes included


@dataclass
class Row:
    """One row."""

    cells: list[Cell]
    end: str  # line end as it stands in the file; "" at the end of it


@dataclass
class Sheet:
    """A table whose bytes are known."""

    name: str  # shown name of the file
    rows: list[Row]  # all rows, blank ones too
    delimiter: str  # between cells
    mark: bytes  # byte-order mark
    encoding: str  # of the bytes behind it

    def value(self, row: int, column: int | None) -> str:
        """Give a cell without blanks around it; "" where the row has no such column."""
        cells = self.rows[row].cells
        return "" if column is None or column >= len(cells) else cells[column].value.strip()

    def put(self, row: int, column: int, value: str) -> None:
        """Write a cell, in quotes where it was in quotes or has to be; a row that is too short grows."""
        cells = self.rows[row].cells
        cells += [Cell("", "")] * (column + 1 - len(cells))
        quoted = cells[column].written.startswith('"')
        if quoted or re.search(rf'["\r\n{re.escape(self.delimiter)}]|^\s|\s$', value):
            cells[column] = Cell(value, '"' + value.replace('"', '""') + '"')
        else:
            cells[column] = Cell(value, value)

    def to_bytes(self) -> bytes:
        """Give the whole sheet."""
        text = "".join(self.delimiter.join(cell.written for cell in row.cells) + row.end for row in self.rows)
        return self.mark + text.encode(self.encoding, "surrogateescape")


@dataclass(frozen=True, slots=True)
class Filled:
    """A gradebook with grades in it."""

    data: bytes  # the file to upload
    filled: tuple[str, ...]  # students whose grade stands in it now
    # student, what stood there, and what stands there now, where the two differ and there was something
    changed: tuple[tuple[str, str, str], ...]
    skipped: tuple[tuple[str, str], ...]  # student or row, and why nothing was written for it


_MARKS = ((b"\xef\xbb\xbf", "utf-8"), (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be"))


def read_sheet(data: bytes, name: str) -> Sheet:
    """Read a sheet with commas, semicolons or tabs, whichever its first lines have most of."""
    hint = "give the CSV file that the gradebook exports, not a workbook"
    mark, encoding = next((pair for pair in _MARKS if data.startswith(pair[0])), (b"", "utf-8"))
    if len(data) > LARGEST:
        raise refusal(GRADEBOOK_CANNOT_BE_READ, name, "is larger than 50 MB", hint)
    try:
        text = data[len(mark) :].decode(encoding, "surrogateescape" if encoding == "utf-8" else "strict")
    except UnicodeDecodeError:
        raise refusal(GRADEBOOK_CANNOT_BE_READ, name, "is no text", hint) from None
    if "\x00" in text:
        raise refusal(GRADEBOOK_CANNOT_BE_READ, name, "is no text", hint)
    if not text.strip():
        raise refusal(GRADEBOOK_CANNOT_BE_READ, name, "is empty", "export the gradebook again")
    head = re.sub(r'"[^"]*"', "", "\n".join(text[:100_000].splitlines()[:3]))
    delimiter = max(",;\t", key=head.count)
    return Sheet(name, list(_rows(text, delimiter)), delimiter, mark, encoding)


def refusal(code: str, name: str, message: str, hint: str) -> InputError:
    """Make the error for a gradebook that cannot be used."""
    return InputError([Diagnostic(code, "error", f'"{name}" {message}', hint, name)])


def _rows(text: str, delimiter: str) -> Iterator[Row]:
    """Split by RFC 4180; a quote that is never closed, or does not begin its cell, is a plain character."""
    plain = rf"[^{re.escape(delimiter)}\r\n]*+"
    cell = re.compile(rf'(?:"((?:[^"]|"")*+)"({plain})|({plain}))({re.escape(delimiter)}|\r\n|\n|\r|\Z)')
    cells: list[Cell] = []
    at = 0
    while at < len(text) or cells:
        match = cell.match(text, at)
        assert match is not None
        inside, behind, whole, end = match.groups()
        value = whole if inside is None else inside.replace('""', '"') + behind
        cells.append(Cell(value, text[at : match.start(4)]))
        at = match.end()
        if end != delimiter:
            yield Row(cells, end)
            cells = []
