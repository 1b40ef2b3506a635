"""Tables side by side, each with the same names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

from msgspec.structs import replace

from gyrodata.quantities.numerals import has_digit
from gyrodata.readings.grid import HEADERS_LOOKED_AT, Grid, Row, filled_at, has_numbers
from gyrodata.readings.names import squeeze

_COPY = r"(?i)(?:\.|(?<!\s)\s+run\s?#?\s?)[0-9]{1,3}$"
"""What a spreadsheet or a data logger writes behind names that repeat."""


def to_rows(grid: Grid) -> Grid:
    """Put tables whose names repeat below each other, each with the words above it."""
    head = _head_of(grid)
    if head is None:
        return grid
    index = grid.rows.index(head)
    numbers = [at for at, row in enumerate(grid.rows) if has_numbers(row)]
    last = max([index, *numbers])
    starts = _starts(head)
    of_tables = grid.rows[index + 1 : last + 1]
    below = grid.rows[last + 1 :]
    words = grid.rows[:index]
    rows = [row for row in words if _is_title(row, starts[0])]
    words = [row for row in words if row not in rows]
    for start, end in pairwise([*starts, len(head.texts)]):
        places = range(start, end)
        names = _cut(head, places)
        rows += _words_of(words, start, end)
        rows.append(replace(names, texts=list(map(_without_number, names.texts))))
        rows += _filled(of_tables, start, end)
    return replace(grid, rows=[*rows, *below])


def _filled(rows: list[Row], start: int, end: int) -> list[Row]:
    """Return the rows of one table, without blank ones."""
    cut = [_cut(row, range(start, end)) for row in rows]
    return [row for row in cut if any(row.texts)]


def _head_of(grid: Grid) -> Row | None:
    """Return the first row whose names repeat."""
    for row in grid.rows[:HEADERS_LOOKED_AT]:
        if not has_numbers(row) and _starts(row):
            return row
    return None


def _without_number(name: str) -> str:
    return re.sub(_COPY, "", name)


def _starts(head: Row) -> list[int]:
    """Return the column at which each table begins; none if the names do not repeat."""
    filled = filled_at(head)
    names = [squeeze(_without_number(head.texts[at])) for at in filled]
    # A column on the left may number the rows of all tables.
    for left in (0, 1):
        for size in range(2, (len(names) - left) // 2 + 1):
            first = names[left : left + size]
            second = names[left + size : left + 2 * size]
            if first == second and len(set(first)) == size:
                return filled[left::size]
    return []


def _is_title(row: Row, start: int) -> bool:
    """Return whether a row is one cell at the left of the tables."""
    filled = filled_at(row)
    return len(filled) == 1 and filled[0] <= start


def _words_of(rows: list[Row], start: int, end: int) -> Iterator[Row]:
    """Yield the words above one table."""
    for row in rows:
        places = range(start, end)
        cut = _cut(row, places)
        if not any(cut.texts):
            continue
        # "mass:", "20 g", "", "40 g": the name at the side is valid for all.
        label = row.texts[0]
        if start and label and not has_digit(label) and "=" not in label:
            at = filled_at(cut)[0]
            cut.texts[at] = f"{label} {cut.texts[at]}"
        yield cut


def _cut(row: Row, places: range) -> Row:
    first = places[0]
    there = filled_at(row)
    filled = set(places).intersection(there)
    last = max(filled, default=first)
    return row.cells(range(first, last + 1))
