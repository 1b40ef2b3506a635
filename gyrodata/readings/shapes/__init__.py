"""Tables in other forms than one header row with one row for each run.

Each module of this folder reads one form. `applies` says whether a grid has it, and
`to_rows` returns the grid with ordinary rows. Most logs need none of them.
"""

from __future__ import annotations

from typing import Protocol

from gyrodata.readings.grid import Grid, Row, filled_at, has_numbers, is_head
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Faults
from gyrodata.readings.names import Phrases
from gyrodata.readings.shapes import (
    side_by_side,
    transposed,
)


class Shape(Protocol):
    """A form of a table."""

    def applies(self, grid: Grid) -> bool:
        """Return whether a table has this form."""

    def to_rows(self, grid: Grid, faults: Faults) -> Grid:
        """Return the table with one row for each run; add a note on what was changed."""


SHAPES: tuple[Shape, ...] = (
    transposed,
    side_by_side,
)
"""The forms, in the order in which they are looked for."""


def reshape(grid: Grid, faults: Faults) -> Grid:
    """Return the table with one row for each run; a note says what was changed."""
    if not grid.rows or _is_usual(grid):
        return grid
    for shape in SHAPES:
        if shape.applies(grid):
            grid = shape.to_rows(grid, faults)
    return grid


_WEIGHTS = Phrases("weights")
_DIGITS = frozenset("0123456789")


def _is_usual(grid: Grid) -> bool:
    """Return whether a table has one row of names above its runs, each with one name."""
    named = [
        row for row in grid.rows if len(filled_at(row)) > 1 and not has_numbers(row)
    ]
    if len(named) != 1 or not is_head(named[0]):
        return False
    names, width = named[0].texts, max(len(row.texts) for row in grid.rows)
    if "" in names or len(set(names)) < width:
        return False
    return all(map(_is_plain, names)) and _names_quantities(named[0])


def _names_quantities(row: Row) -> bool:
    named = [text for text in row.texts if parse_header(text).roles]
    return 2 * len(named) > len(row.filled())


def _is_plain(name: str) -> bool:
    """Return whether a name contains no number, and does not count weights."""
    return _DIGITS.isdisjoint(name) and not _WEIGHTS.is_in(name)
