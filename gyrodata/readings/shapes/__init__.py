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
    for shape in SHAPES:
        if shape.applies(grid):
            grid = shape.to_rows(grid, faults)
    return grid
