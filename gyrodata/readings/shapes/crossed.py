"""A crossed table: a quantity in the header, another one at the side, times in the cells.

Such headers are "20 g" and "40 g"; "time (s) with 20 g"; or 20 and 40 below "mass (g)"
or behind it.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities import notation, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.captions import SAID_KINDS, Given, said_in
from gyrodata.readings.grid import (
    HEADERS_LOOKED_AT,
    Grid,
    Row,
    filled_at,
    is_bare,
    is_number,
)
from gyrodata.readings.lablog import Faults
from gyrodata.readings.roles import parse_header

_QUANTITY = re.compile(
    rf"(?i)(?:[\[(]\s*|(?<!\s)\s+)?(?:\b(?:{vocabulary.words('with').replace(' ', '|')}"
    rf"|[mMxr])\s*(?:[=:]\s*)?)?"
    rf"(?<![\w.,/])({notation.NUMBER})\s*([^\W\d_][^\s,;)\]]*)\s*[\])]?"
)
"""A quantity in a header, with its brackets and small words: "(20 g)", "with 20 g", "m
= 20 g"."""
_CORNER = r"(?:(?<!\s)\s+)?(?:\\|↓|→|\||\s/\s|\bvs\b)\s*"
"""Marks between the names of rows and columns in the corner of a table."""


class _Crossed(Struct, frozen=True):
    """A crossed table."""

    index: int
    """Number of its header among the rows."""
    first: int
    """Number of its first row."""
    name: str
    """Name of the quantities in the header."""
    quantities: dict[int, str]
    """Quantity of each column of times."""
    time: str
    """Name of what the cells contain."""
    below: list[Row]
    """The rows of times."""
    labels: list[Given]
    """Quantities in the first cell of each row, such as "200 rpm"."""
    side: list[int]
    """Columns at the side, each with a name of its own."""

    def names(self, head: Row) -> list[str]:
        """Return the names of the columns of the ordinary table."""
        at_side = [re.split(_CORNER, head.texts[at])[0] for at in self.side]
        return [*self.labels[0], *at_side, self.name, self.time]


def applies(grid: Grid) -> bool:
    """Return whether a header contains a quantity of each column, and a time is named."""
    return _find(grid) is not None


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Make a row of each cell of each crossed table."""
    while table := _find(grid):
        head = grid.rows[table.index]
        cell = grid.cell(head, min(table.quantities))
        role = parse_header(table.name).roles[0]
        faults.add("crossed", cell, line=[head.line], role=role, time=table.time)
        rest = grid.rows[table.index + 1 + len(table.below) :]
        rows = [*grid.rows[: table.first], *_rows_of(table, head), *rest]
        grid = replace(grid, rows=rows)
    return grid


def _rows_of(table: _Crossed, head: Row) -> Iterator[Row]:
    first = min(table.quantities)
    of_label = [0] * len(table.labels[0])
    spots = [head.spot(at) for at in (*of_label, *table.side, first, first)]
    yield Row(head.line, table.names(head), tuple(spots))
    for row, label in zip(table.below, table.labels, strict=True):
        side = row.cells(table.side)
        texts = [*(text for text, _ in label.values()), *side.texts]
        spots = [row.spot(at) for at in (*of_label, *table.side)]
        for at, quantity in table.quantities.items():
            if time := "".join(row.texts[at : at + 1]):
                origin = (*spots, head.spot(at), row.spot(at))
                yield Row(row.line, [*texts, quantity, time], origin)


def _find(grid: Grid) -> _Crossed | None:
    for index in range(min(len(grid.rows), HEADERS_LOOKED_AT)):
        if table := _crossed_at(grid, index):
            return table
    return None


def _crossed_at(grid: Grid, index: int) -> _Crossed | None:
    """Return the crossed table whose header is this row; None for another row."""
    head = grid.rows[index]
    names, quantities = _quantities_of(head)
    first, name = index, names[0] if names else ""
    if not quantities:
        name, first = _name_of_numbers(grid, index)
        quantities = {at: head.texts[at] for at in filled_at(head)[1:]} if name else {}
    if len(set(quantities.values())) < 2:
        return None
    below = list(itertools.takewhile(_has_times, grid.rows[index + 1 :]))
    time = _name_of_time([*names[1:], *_texts_around(grid, index, len(below))])
    has_labels = head.texts[0] in ("", time)
    labels = [said_in(row.cells([0])) if has_labels else {} for row in below]
    side = [at for at in filled_at(head) if at not in quantities]
    if has_labels and side[:1] == [0]:
        del side[0]
    table = _Crossed(index, first, name, quantities, time, below, labels, side)
    return table if below and time and _is_complete(table, head) else None


def _is_complete(table: _Crossed, head: Row) -> bool:
    """Return whether the side of a table names quantities that its header does not."""
    *at_side, name, _ = [set(parse_header(text).roles) for text in table.names(head)]
    named = set().union(*at_side)
    same_labels = all(label.keys() == table.labels[0].keys() for label in table.labels)
    return same_labels and not named & name and not named.isdisjoint(roles.ROLES)


def _has_times(row: Row) -> bool:
    return any(map(is_number, row.texts[1:]))


def _quantities_of(head: Row) -> tuple[list[str], dict[int, str]]:
    """Return what quantities in a header are, and the quantity in each column.

    The names are the role, and what remains of the header: "time (s)" of "time (s) with
    20 g". Both are empty if the header contains quantities of two roles.
    """
    quantities = {}
    names = set()
    for at in filled_at(head):
        text = head.texts[at]
        match = _QUANTITY.search(text)
        kinds = SAID_KINDS.keys() & kinds_of(match[2]) if match else set()
        if match and kinds:
            rest = f"{text[: match.start()].strip()} {text[match.end() :].strip()}"
            quantities[at] = f"{match[1]} {match[2]}"
            names.add((SAID_KINDS[min(kinds)], rest.strip()))
    if len(names) != 1:
        return [], {}
    return list(names.pop()), quantities


def _name_of_numbers(grid: Grid, index: int) -> tuple[str, int]:
    """Return the name of the numbers in a header, which is above them or in the corner.

    The function also returns the number of the row with this name. The name is "" if
    the header contains other texts.
    """
    head = grid.rows[index]
    numbers = [head.texts[at] for at in filled_at(head)[1:]]
    if not all(map(is_bare, numbers)):
        return "", index
    names, first = re.split(_CORNER, head.texts[0])[1:], index
    if not names and index:
        names, first = grid.rows[index - 1].filled(), index - 1
    header = parse_header(names[0]) if len(names) == 1 else None
    return (names[0], first) if header and header.unit and header.roles else ("", index)


def _texts_around(grid: Grid, index: int, count: int) -> list[str]:
    """Return the texts above and below a table, the nearest first."""
    rows = [*grid.rows[index::-1], *grid.rows[index + 1 + count :]]
    texts = [text for row in rows for text in row.texts]
    return [*(comment.text for comment in grid.comments), *texts]


def _name_of_time(texts: list[str]) -> str:
    """Return the text that names a time, if possible with its unit; else ""."""
    without_unit = ""
    for text in texts:
        for part in (*re.split(r"[,;:.]\s+", text), text):
            header = parse_header(part)
            if not {*header.roles}.isdisjoint(roles.TIMINGS):
                if header.unit is not None:
                    return part
                without_unit = without_unit or part
    return without_unit
