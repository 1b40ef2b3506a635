"""A second table, of time and spin: how fast the spin falls."""

from __future__ import annotations

from itertools import pairwise

from msgspec.structs import replace

from gyrodata.quantities import notation
from gyrodata.quantities.units import UnitError
from gyrodata.readings.grid import Grid, Row, filled_at, has_numbers
from gyrodata.readings.headers import Header, parse_header
from gyrodata.readings.lablog import Fall

_SHORTEST = 3
"""Rows of a spin-down."""


def take_out(grid: Grid) -> tuple[Grid, tuple[Fall, ...]]:
    """Take a table of time and spin out of a log that contains another table as well.

    Returns
    -------
    Grid
        The other rows.
    tuple of Fall
        Empty if there is no such table.
    """
    heads = [at for at, row in enumerate(grid.rows) if _is_name_row(row)]
    if len(heads) < 2:
        return grid, ()
    for at in heads:
        columns = _columns_of(grid.rows[at])
        rows = _rows_below(grid.rows, at)
        falls = _falls(rows, columns) if len(rows) >= _SHORTEST and columns else ()
        if falls:
            # A title of one cell, or the name of a sheet, belongs to the table.
            has_title = at > 0 and len(filled_at(grid.rows[at - 1])) == 1
            before = grid.rows[: at - has_title]
            return replace(grid, rows=before + grid.rows[at + 1 + len(rows) :]), falls
    return grid, ()


def _is_name_row(row: Row) -> bool:
    return len(filled_at(row)) > 1 and not has_numbers(row)


def _columns_of(head: Row) -> dict[str, tuple[int, Header]]:
    """Return the columns of a header of a time and a spin; none for another header."""
    headers = [(at, parse_header(head.texts[at])) for at in filled_at(head)]
    columns = {"".join(header.roles): (at, header) for at, header in headers}
    return columns if len(headers) == 2 and columns.keys() == {"time", "spin"} else {}


def _rows_below(rows: list[Row], at: int) -> list[Row]:
    """Return the rows of numbers below a header, with cells below its names alone."""
    below = []
    for row in rows[at + 1 :]:
        if _is_name_row(row) or filled_at(row) != filled_at(rows[at]):
            break
        below.append(row)
    return below


def _falls(rows: list[Row], columns: dict[str, tuple[int, Header]]) -> tuple[Fall, ...]:
    """Return three falls of the spin; none if it does not fall while the time goes on."""
    try:
        times = _values(rows, *columns["time"], "time")
        spins = _values(rows, *columns["spin"], "rate")
    except UnitError:
        return ()
    # In a table of runs with one weight, a faster spin has a longer time.
    if sorted(set(times)) != times or spins[-1] >= spins[0]:
        return ()
    # Three long falls: the noise of the readings then does not matter.
    last = len(times) - 1
    ends = [*range(0, last, -(-last // 3)), last]
    return tuple((spins[a], spins[b], times[b] - times[a]) for a, b in pairwise(ends))


def _values(rows: list[Row], at: int, header: Header, kind: str) -> list[float]:
    cells = [notation.read_cell(row.texts[at], kind, header.unit) for row in rows]
    return [abs(cell.value) for cell in cells]
