"""A header behind the sign #, or with another delimiter than the rows."""

from __future__ import annotations

import itertools
import re
from collections import Counter

from msgspec.structs import replace

from gyrodata.readings.grid import Grid, Row, filled_at, is_head
from gyrodata.readings.lablog import Faults, Text


def applies(grid: Grid) -> bool:
    """Return whether no row is a header, but a text with as many names as the rows."""
    return not any(map(is_head, grid.rows)) and _header_of(grid) is not None


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Split the header into cells."""
    header = _header_of(grid)
    if header is None:
        return grid
    others = [row for row in grid.rows if row.line != header.line]
    return replace(grid, rows=sorted([*others, header], key=lambda row: row.line))


def _header_of(grid: Grid) -> Row | None:
    """Return the names of the columns; None if there are none."""
    widths = Counter(len(row.texts) for row in grid.rows)
    usual = max(widths, key=widths.__getitem__)
    between = [re.escape(grid.delimiter), ",", r"\s{2,}", r"\s+"]
    for text, sign in itertools.product(_texts_of(grid), between):
        cells = re.split(sign, text.text)
        row = Row(text.place.line, [cell.strip() for cell in cells])
        if len(cells) == usual and is_head(row):
            return row
    return None


def _texts_of(grid: Grid) -> list[Text]:
    """Return the texts that may be a header: comments, and rows of one cell."""
    single = [row for row in grid.rows if len(filled_at(row)) == 1]
    keyed = [text for _, text in grid.metadata]
    return [*grid.comments, *keyed, *map(grid.first_cell, single)]
