"""A spin-down: how the spin of the ball falls if nothing else happens, from a line or a small table of the log."""

from __future__ import annotations

import re
from itertools import pairwise

from msgspec.structs import replace

from gyrodata.quantities import CellError, parse_quantity, read_cell
from gyrodata.readings.lablog import check_value
from gyrodata.readings.layout import is_number
from gyrodata.readings.roles import parse_header
from gyrodata.readings.source import Grid, Row
from gyrodata.units import UnitError

Fall = tuple[float, float, float]
"""Spin at the start and at the end [rad/s], and the time between both [s]."""

SAMPLE = "612 rpm to 540 rpm in 120 s"
MOST_FALLS = 3
"""A table is divided into this many falls, so that its noise does not matter."""


def read_spin_down(text: str) -> tuple[Fall, ...]:
    """Read one or several falls, such as "612 rpm to 540 rpm in 120 s", with semicolons between them.

    Raises
    ------
    CellError
        If the text cannot be read.
    """
    found = []
    for part in filter(None, map(str.strip, text.split(";"))):
        match = re.fullmatch(r"(.+?)\s+to\s+(.+?)\s+in\s+(.+)", part)
        if match is None:
            raise CellError("cannot be read", f'write it like "{SAMPLE}"')
        try:
            start, end, seconds = map(parse_quantity, match.groups(), ("rate", "rate", "time"))
        except UnitError as error:
            raise CellError(f"cannot be read: {error}", error.hint or f'write it like "{SAMPLE}"') from None
        found.append((abs(start), abs(end), seconds))
        if not (seconds > 0 and start and end):
            raise CellError("contains a spin or a time that is not above zero", f'write it like "{SAMPLE}"')
        fault, hint = check_value("spin", start)
        if fault:
            raise CellError(fault, hint)
        if abs(end) > 1.02 * abs(start):
            raise CellError("says that the spin rises", "exchange start and end if they are swapped")
    return tuple(found)


def split_table(grid: Grid) -> tuple[Grid, tuple[Fall, ...]]:
    """Take a table of time and spin, with at least three rows, out of a log that contains another table as well.

    Returns
    -------
    Grid
        The other rows.
    tuple of Fall
        Empty if there is no such table.
    """
    heads = [at for at, row in enumerate(grid.rows) if len(_filled(row)) > 1 and not any(map(is_number, row.texts))]
    for at in heads:
        headers = {place: parse_header(grid.rows[at].texts[place]) for place in _filled(grid.rows[at])}
        columns = {header.roles: (place, header.unit) for place, header in headers.items()}
        if len(heads) < 2 or len(headers) != 2 or set(columns) != {("time",), ("spin",)}:
            continue
        last = at + 1
        while last < len(grid.rows) and _filled(grid.rows[last]) == list(headers) and last not in heads:
            last += 1
        if last < at + 4:
            continue
        try:
            times, spins = (
                [abs(read_cell(row.texts[place], kind, unit).value) for row in grid.rows[at + 1 : last]]
                for (place, unit), kind in ((columns[("time",)], "time"), (columns[("spin",)], "rate"))
            )
        except CellError:
            continue
        # In a table of runs with one weight, a faster spin has a longer time.
        if sorted(set(times)) != times or spins[-1] >= spins[0]:
            continue
        # Few and long falls, so that the noise of the readings does not matter.
        ends = [*range(0, len(times) - 1, -(-(len(times) - 1) // MOST_FALLS)), len(times) - 1]
        falls = [(spins[a], spins[b], times[b] - times[a]) for a, b in pairwise(ends)]
        # A title of one cell, or the name of a sheet, belongs to the table.
        first = at - 1 if at and len(_filled(grid.rows[at - 1])) == 1 else at
        return replace(grid, rows=grid.rows[:first] + grid.rows[last:]), tuple(falls)
    return grid, ()


def _filled(row: Row) -> list[int]:
    """List the places of the cells that are not blank."""
    return [at for at, text in enumerate(row.texts) if text]
