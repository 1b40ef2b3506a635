"""Tables with their names at the side: one column for each run."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec.structs import replace

from gyrodata.readings.captions import said_in
from gyrodata.readings.grid import Grid, Row, filled_at, is_head
from gyrodata.readings.lablog import Faults, listing


def applies(grid: Grid) -> bool:
    """Return whether no row is a header, but the cells at the side are."""
    if any(map(is_head, grid.rows)):
        return False
    names = _names_of(_table_of(grid))
    return is_head(names) and len(set(names.texts)) == len(names.texts)


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Make a row of each column; a single value is valid for all runs."""
    captions = list(filter(_is_caption, grid.rows))
    table = _table_of(grid)
    side = _side_of(table)
    names = listing(_names_of(table).texts, 3)
    faults.add("turned", grid.cell(table[0], side), names=names)
    return replace(grid, rows=[*captions, *_columns_as_rows(table, side)])


def _table_of(grid: Grid) -> list[Row]:
    return [row for row in grid.rows if not _is_caption(row)]


def _is_caption(row: Row) -> bool:
    """Return whether a row is a text of one cell."""
    if len(filled_at(row)) != 1:
        return False
    return " " in "".join(row.texts).strip() or bool(said_in(row))


def _side_of(rows: list[Row]) -> int:
    """Return the number of the column with the names."""
    return min((filled_at(row)[0] for row in rows), default=0)


def _names_of(table: list[Row]) -> Row:
    """Return the cells at the side."""
    side = _side_of(table)
    return Row(0, [row.texts[side] for row in table])


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
