"""Tables with their names at the side: one column for each run."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from msgspec.structs import replace

from gyrodata.readings.captions import said_in
from gyrodata.readings.grid import Grid, Row, filled_at, is_bare, is_head, is_number
from gyrodata.readings.lablog import Faults, listing


def applies(grid: Grid) -> bool:
    """Return whether no row is a header, but the cells at the side are."""
    if any(map(is_head, grid.rows)):
        return False
    return len(_blocks(grid)) > 1 or is_head(_names_of(grid.rows))


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Make a row of each column; a single value is valid for all runs.

    Several tables with the same names at the side may be below their captions.
    """
    if len(_blocks(grid)) < 2:
        return replace(grid, rows=_turned(grid, grid.rows, faults))
    rows: list[Row] = []
    for is_table, group in groupby(grid.rows, _is_of_table):
        part = list(group)
        rows += _turned(grid, part, faults) if is_table else part
    return replace(grid, rows=rows)


def _is_of_table(row: Row) -> bool:
    """Return whether a row has a name at the side, and several numbers."""
    return not is_number(row.texts[0]) and sum(map(is_bare, row.texts[1:])) > 1


def _blocks(grid: Grid) -> list[Row]:
    """Return the names of each of several tables below each other."""
    parts = [
        list(part) for is_table, part in groupby(grid.rows, _is_of_table) if is_table
    ]
    names = [Row(0, [row.texts[0] for row in part]) for part in parts]
    return list(filter(is_head, names))


def _is_caption(row: Row) -> bool:
    """Return whether a row is a text of one cell."""
    if len(filled_at(row)) != 1:
        return False
    return " " in "".join(row.texts).strip() or bool(said_in(row))


def _side_of(rows: list[Row]) -> int:
    """Return the number of the column with the names."""
    return min((filled_at(row)[0] for row in rows), default=0)


def _names_of(rows: list[Row]) -> Row:
    """Return the cells at the side, without those of captions."""
    table = [row for row in rows if not _is_caption(row)]
    side = _side_of(table)
    return Row(0, [row.texts[side] for row in table])


def _turned(grid: Grid, rows: list[Row], faults: Faults) -> list[Row]:
    """Return the captions, and a row for each column; the same rows if there are no names."""
    captions = [row for row in rows if _is_caption(row)]
    table = [row for row in rows if not _is_caption(row)]
    names = _names_of(rows)
    if not is_head(names):
        return rows
    side = _side_of(table)
    name = grid.cell(table[0], side)
    faults.add("turned", name, names=listing(names.texts, 3))
    return [*captions, *_columns_as_rows(table, side)]


def _columns_as_rows(table: list[Row], side: int) -> Iterator[Row]:
    width = max(len(row.texts) for row in table)
    for at in range(side, width):
        places = [_place_in(row, at, side, width) for row in table]
        cells = [row.cells([place]) for row, place in zip(table, places, strict=True)]
        texts = [cell.texts[0] for cell in cells]
        if any(texts):
            spots = tuple(cell.origin[0] for cell in cells)
            yield Row(table[0].line, texts, spots)


def _place_in(row: Row, at: int, side: int, width: int) -> int:
    """Return the place of a run's cell in a row; a single value is valid for all runs."""
    is_single = len(row.texts) == side + 2 < width
    return side + 1 if is_single and at > side else at
