"""From text to a table: delimiter, quotes, ``#`` lines and limits; then where header, units and runs stand."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

from gyrodata.diagnostics import (
    BLOCKS_SIDE_BY_SIDE,
    BLOCKS_STACKED,
    CELL_TOO_LONG,
    HEADER_PARTED_BY_COMMA,
    HEADER_STANDS_TWICE,
    HEADER_WITHOUT_RUNS,
    NO_DELIMITER,
    NO_HEADER_ROW,
    QUOTE_NEVER_CLOSED,
    ROW_IS_ONLY_A_TITLE,
    ROW_TAKEN_OUT,
    TABLE_TRANSPOSED,
    TOO_MANY_COLUMNS,
    TOO_MANY_ROWS,
)
from gyrodata.readings.cells import BLANKS, find_in_row
from gyrodata.readings.headers import Header, parse_header, with_unit
from gyrodata.readings.lablog import Faults, Place, Text, listing, span
from gyrodata.readings.roles import TEXTS, kind_of_role, squeeze
from gyrodata.readings.source import MAX_COLUMNS, MAX_ROWS, Document
from gyrodata.units import kinds_of

MAX_CELL = 10_000


class Row(NamedTuple):
    """One row of a table."""

    line: int
    """Where it begins."""
    texts: list[str]
    """Its cells, without quotes and without blanks around them; blank ones at the end are cut off."""


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
        return find_cell(self.lines, self.delimiter, row.line, at)

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
    rows = _without_answers(rows, lines, delimiter or ",", metadata)
    width = len(rows[0].texts) if rows else 0
    hidden = [
        c.line
        for c in comments
        if delimiter and width > 2 and c.text.count(delimiter) == width - 1 and c.text[:1].isdigit()
    ]
    if hidden:
        faults.add(ROW_TAKEN_OUT, f"{span(hidden)}: begins with # and is left out", "", Place(hidden[0], 1))
    return Grid(lines, delimiter or ",", rows, metadata, comments)


def _without_answers(rows: list[Row], lines: list[str], delimiter: str, metadata: list[tuple[str, Text]]) -> list[Row]:
    """Take I_zz out of a table below or beside which it is written, as if it stood in a ``#`` line."""
    kept: list[Row] = []
    for row in rows:
        at, answer = find_in_row(row.texts)
        if answer:
            metadata.append(("I_zz", find_cell(lines, delimiter, row.line, at)._replace(text=answer)))
            left = row.texts[:at]
            while left and not left[-1]:
                left.pop()
            row = Row(row.line, left)
        if row.texts:
            kept.append(row)
    return kept


def has_decimal_commas(rows: list[Row]) -> bool:
    """Tell whether the first numbers of a table are written with a decimal comma, and none with a point."""
    signs = {
        match[1]
        for row in rows[:50]
        for text in row.texts
        if (match := _DECIMAL.fullmatch(text)) and (len(match[2]) != 3 or text[0] == "0")
    }
    return signs == {","}


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
    """Take the delimiter that cuts the header and most rows into equally many cells."""
    best, best_share = None, 0.0
    for delimiter in _DELIMITERS:
        counts = [_count(line[: 4 * MAX_CELL], delimiter) for line in lines]
        if not counts or not any(counts[:2]):
            continue
        usual = max(counts[:2])
        share = sum(count == usual for count in counts) / len(counts)
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


def spot(row: Row, at: int) -> int:
    """Number a cell of the file."""
    return row.line * MAX_COLUMNS + at


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


_HINT = "the first row names the columns, such as: mass [g], position [cm], spin [rpm], time [s], turns"


@dataclass(frozen=True)
class Layout:
    """A table of runs: its headers, and the rows below them."""

    grid: Grid
    """For the places of cells."""
    cells: list[Text]
    """The header row."""
    headers: list[Header]
    """What each of them says, with the unit of a second header row."""
    rows: list[Row]


def find_layout(grid: Grid, faults: Faults) -> Layout | None:
    """Find the header and the rows; None, with diagnostics, where there is no such table."""
    rows = grid.rows
    if not rows:
        faults.add(NO_HEADER_ROW, "there is no table in this log", _HINT)
        return None
    for check in (_is_transposed, _stands_side_by_side, _starts_with_title):
        if check(grid, faults):
            return None
    head = grid.cells(rows[0])
    headers = [parse_header(cell.text) for cell in head]
    numbers = _numbers(rows[0])
    if numbers and numbers * 2 >= sum(1 for cell in head if cell.text):
        hint = _HINT
        if any(comment.text.count(grid.delimiter) == len(head) - 1 for comment in grid.comments):
            hint = "take the # away from the line with the names of the columns"
        faults.add(NO_HEADER_ROW, "there is no header row: the first row holds numbers", hint, head[0])
        return None
    body = rows[1:]
    if body and _is_unit_row(body[0]):
        headers = _with_units(headers, body[0])
        body = body[1:]
    if (
        _is_parted(head, headers, faults)
        or _repeats_a_header(head, faults)
        or _is_stacked(grid, body, len(head), headers, faults)
    ):
        return None
    if not body:
        faults.add(
            HEADER_WITHOUT_RUNS, "there is a header, but not one run below it", "write one row for each timed run"
        )
        return None
    return Layout(grid, head, headers, body)


def is_number(text: str) -> bool:
    """Tell whether a cell begins like a number."""
    return text[:1].isdigit() or (text[:1] in "+-−.,(" and text[1:2].isdigit())


def _numbers(row: Row) -> int:
    count = 0
    for text in row.texts:
        if is_number(text) and not parse_header(text).roles:
            count += 1
    return count


def _is_transposed(grid: Grid, faults: Faults) -> bool:
    rows = grid.rows[:20]
    named = [
        row
        for row in rows
        if len(row.texts) > 1
        and parse_header(row.texts[0]).roles
        and all(is_number(text) or text in BLANKS for text in row.texts[1:])
    ]
    if not named or named[0] is not rows[0] or _numbers(rows[0]) == 0 or len(named) * 2 < len(rows):
        return False
    names = listing([row.texts[0] for row in named])
    hint = "turn it: one column for each quantity, one row for each run (in a spreadsheet: Paste special, Transpose)"
    message = f"the names stand at the side ({names}): the table is transposed"
    faults.add(TABLE_TRANSPOSED, message, hint, grid.cell(rows[0], 0))
    return True


_ASSIGNMENT = re.compile(r".{0,30}=\s*[-+]?[0-9].*")
_COPY = re.compile(r"\.[0-9]{1,2}$")


def _stands_side_by_side(grid: Grid, faults: Faults) -> bool:
    for row in grid.rows[:3]:
        if _numbers(row):
            break
        names = [squeeze(_COPY.sub("", text)) for text in row.texts]
        if sum(bool(_ASSIGNMENT.fullmatch(t)) for t in row.texts) > 1 or _cycle([n for n in names if n]):
            shown = listing([text for text in row.texts if text])
            hint = "put the blocks below each other, with a column for what differs (such as mass [g])"
            faults.add(BLOCKS_SIDE_BY_SIDE, f"blocks stand side by side: {shown}", hint, grid.cell(row, 0))
            return True
    return False


def _cycle(names: list[str]) -> int:
    """Give the length of the block of two or more names that repeats, or 0."""
    for period in range(2, len(names) // 2 + 1):
        if len(set(names[:period])) == period and all(
            name == names[i % period] for i, name in enumerate(names[: len(names) // period * period])
        ):
            return period
    return 0


def _starts_with_title(grid: Grid, faults: Faults) -> bool:
    rows = grid.rows
    filled = [at for at, text in enumerate(rows[0].texts) if text]
    if len(filled) != 1 or len(rows) < 2 or sum(1 for text in rows[1].texts if text) < 2:
        return False
    cell = grid.cell(rows[0], filled[0])
    if parse_header(cell.text).roles and not parse_header(rows[1].texts[0]).roles:
        return False
    _add_title(cell, faults)
    return True


def _add_title(cell: Text, faults: Faults) -> None:
    hint = "put a # before the line, or take it out; what it says of the runs goes into a column"
    faults.add(ROW_IS_ONLY_A_TITLE, f'line {cell.line} holds only "{cell.text[:60]}"', hint, cell)


def _bare(text: str) -> str:
    return text[1:-1].strip() if text[:1] + text[-1:] in ("[]", "()") else text


def _is_unit_row(row: Row) -> bool:
    units = 0
    for text in row.texts:
        bare = _bare(text)
        if is_number(text) and not (kinds_of(bare) and any(letter.isalpha() for letter in bare)):
            return False
        if kinds_of(bare) or bare == "%":
            units += 1
        elif text and bare not in BLANKS and bare == text:
            return False
    return units > 0


def _with_units(headers: list[Header], row: Row) -> list[Header]:
    out = list(headers)
    for index, text in enumerate(row.texts[: len(headers)]):
        bare = _bare(text)
        if bare not in BLANKS and headers[index].unit is None:
            out[index] = with_unit(headers[index], bare)
    return out


def _is_parted(head: list[Text], headers: list[Header], faults: Faults) -> bool:
    """Find ``m, g`` that became two cells, which shifts every column behind it."""
    for cell, unit, header in zip(head, head[1:], headers, strict=False):
        alone = bool(kinds_of(unit.text)) and not parse_header(unit.text).roles
        if alone and header.roles and header.unit is None:
            message = f'"{unit.text}" stands alone in its cell: is it the unit of "{cell.text}"?'
            faults.add(
                HEADER_PARTED_BY_COMMA, message, f'write "{cell.text} [{unit.text}]", or put the header in quotes', unit
            )
            return True
    return False


def _repeats_a_header(head: list[Text], faults: Faults) -> bool:
    seen: set[str] = set()
    found = False
    for cell in head:
        key = " ".join(cell.text.split())
        if key and key in seen:
            hint = "name repeats of one time time_1, time_2, …; rename or remove the other columns"
            faults.add(HEADER_STANDS_TWICE, f'two columns are called "{cell.text[:60]}"', hint, cell)
            found = True
        seen.add(key)
    return found


def _is_stacked(grid: Grid, body: list[Row], width: int, headers: list[Header], faults: Faults) -> bool:
    """Find a second header, or a title, among the runs."""
    for row in body:
        if is_number(row.texts[0]):
            continue
        filled = [at for at, text in enumerate(row.texts) if text]
        if any(is_number(row.texts[at]) or row.texts[at] in BLANKS for at in filled):
            continue
        named = [at for at in filled if parse_header(row.texts[at]).roles]
        if len(named) > 1:
            hint = "keep one header row; what differs between the blocks goes into a column"
            message = f"a second header row in line {row.line}: blocks are stacked"
            faults.add(BLOCKS_STACKED, message, hint, grid.cell(row, named[0]).place)
            return True
        at = filled[0]
        text_column = at < width and TEXTS.intersection(headers[at].roles)
        if len(filled) == 1 and width > 1 and len(row.texts[at]) > 1 and (at == 0 or not text_column):
            if at < width and headers[at].roles and kind_of_role(headers[at].roles[0]) == "sign":
                continue
            _add_title(grid.cell(row, at), faults)
            return True
    return False
