"""A header behind the sign #: ``# mass [g], spin [rpm], time [s]`` above numbers."""

from __future__ import annotations

from collections import Counter

from msgspec.structs import replace

from gyrodata.readings.grid import Grid, Row, is_head
from gyrodata.readings.lablog import Faults


def applies(grid: Grid) -> bool:
    """Return whether no row is a header, but a comment with as many cells as the rows."""
    return not any(map(is_head, grid.rows)) and _header_of(grid) is not None


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Add the header to the rows."""
    header = _header_of(grid)
    rows = [header] if header else []
    rows = sorted([*grid.rows, *rows], key=lambda row: row.line)
    return replace(grid, rows=rows)


def _header_of(grid: Grid) -> Row | None:
    widths = Counter(len(row.texts) for row in grid.rows)
    usual = max(widths, key=widths.__getitem__)
    for comment in (*grid.comments, *(text for _, text in grid.metadata)):
        cells = [cell.strip() for cell in comment.text.split(grid.delimiter)]
        row = Row(comment.place.line, cells)
        if len(cells) == usual and is_head(row):
            return row
    return None
