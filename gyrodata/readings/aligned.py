"""Tables whose cells are separated by blanks."""

from __future__ import annotations

import re
from collections import Counter
from typing import NamedTuple

from gyrodata.readings.workbook import MAX_COLUMNS


class _Gaps(NamedTuple):
    """A way to align columns with blanks."""

    between: str
    """Blanks between two cells."""
    cell: re.Pattern[str]
    least: int
    """Columns that a table has at least."""
    share: float
    """Share of the lines that must have the usual number of columns."""
    rival: float
    """A delimiter that separates more than this share of the lines is used instead."""


_WIDE = _Gaps(r"\s{2,}", re.compile(r"\S+(?: \S+)*"), 2, 0.0, 1.0)
_NARROW = _Gaps(r"\s+", re.compile(r"\S+"), 4, 0.4, 0.5)


def write_tabs(
    lines: list[str], body: list[int], without_decimals: float, with_decimals: float
) -> bool:
    """Write tabs between cells that are separated by blanks.

    Parameters
    ----------
    lines : list of str
        Lines of the file; the function changes those in `body`.
    body : list of int
        Indices of the lines of the table.
    without_decimals, with_decimals : float
        Share of the lines that the best delimiter separates, if commas between digits
        do not count, and if they do [1].

    Returns
    -------
    bool
        False if the cells are separated by a delimiter.
    """
    for gaps, rival in ((_WIDE, without_decimals), (_NARROW, with_decimals)):
        if rival < gaps.rival and _are_aligned(lines, body, gaps, rival):
            _write_tabs_for_blanks(lines, body, gaps.cell)
            return True
    return False


def _are_aligned(lines: list[str], body: list[int], gaps: _Gaps, rival: float) -> bool:
    cells = [re.split(gaps.between, lines[index].strip()) for index in body]
    counts = Counter(map(len, cells))
    columns, often = counts.most_common(1)[0]
    is_usual = often > max(rival, gaps.share) * len(body)
    return is_usual and gaps.least <= columns <= MAX_COLUMNS


def _write_tabs_for_blanks(
    lines: list[str], body: list[int], cell: re.Pattern[str]
) -> None:
    """Write tabs between cells; of a row with blank cells, each comes to its column."""
    rows = {index: list(cell.finditer(lines[index])) for index in body}
    counts = Counter(map(len, rows.values()))
    repeated = [count for count, often in counts.items() if often > 1]
    width = max(repeated or counts)
    full = [row for row in rows.values() if len(row) == width]
    spans = [_span(column) for column in zip(*full, strict=True)]
    for index, row in rows.items():
        lines[index] = _with_tabs(row, spans)


def _span(cells: tuple[re.Match[str], ...]) -> tuple[int, int]:
    """Return where the cells of a column begin and end."""
    start = min(cell.start() for cell in cells)
    end = max(cell.end() for cell in cells)
    return start, end


def _with_tabs(row: list[re.Match[str]], spans: list[tuple[int, int]]) -> str:
    line = ""
    column = 0
    end = 0
    for number, cell in enumerate(row):
        first = column + 1 if number else 0
        last = len(spans) - len(row) + number
        to = _nearest(cell, spans, first, last)
        tabs = "\t" * (to - column)
        line += tabs.ljust(cell.start() - end) + cell[0]
        column = to
        end = cell.end()
    return line


def _nearest(
    cell: re.Match[str], spans: list[tuple[int, int]], first: int, last: int
) -> int:
    """Return which of some columns a cell is above or below."""

    def distance(column: int) -> int:
        start, stop = spans[column]
        return max(start - cell.end(), cell.start() - stop)

    if last > first:
        return min(range(first, last + 1), key=distance)
    return first
