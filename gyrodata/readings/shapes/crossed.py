"""A crossed table: a quantity in each header, another one at the side, times in the cells.

Such headers are "20 g" and "40 g", or "time (s) with 20 g".
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities import numerals, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.captions import SAID_KINDS
from gyrodata.readings.grid import HEADERS_LOOKED_AT, Grid, Row, filled_at, has_numbers
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Faults

_QUANTITY = re.compile(
    rf"(?i)(?:[\[(]\s*|(?<!\s)\s+)?(?:\b(?:{vocabulary.words('with').replace(' ', '|')}"
    rf"|[mMxr])\s*(?:[=:]\s*)?)?"
    rf"(?<![\w.,/])({numerals.NUMBER})\s*([^\W\d_][^\s,;)\]]*)\s*[\])]?"
)
"""A quantity in a header, with its brackets and small words: "(20 g)", "with 20 g", "m
= 20 g"."""


class _Crossed(Struct, frozen=True):
    """A crossed table."""

    index: int
    """Number of its header among the rows."""
    role: str
    """What the quantities in the header are."""
    quantities: dict[int, str]
    """Quantity of each column of times."""
    time: str
    """Name of what the cells contain."""
    side: list[int]
    """Columns at the side, each with a name of its own."""
    rows: list[Row]
    """The rows of times."""


def applies(grid: Grid) -> bool:
    """Return whether headers contain a quantity of each column, and a text names the time."""
    return _find(grid) is not None


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Make a row of each cell of each crossed table."""
    while table := _find(grid):
        head = grid.rows[table.index]
        cell = grid.cell(head, min(table.quantities))
        line = [head.line]
        faults.add("crossed", cell, line=line, role=table.role, time=table.time)
        rest = grid.rows[table.index + 1 + len(table.rows) :]
        rows = [*grid.rows[: table.index], *_rows_of(table, head), *rest]
        grid = replace(grid, rows=rows)
    return grid


def _rows_of(table: _Crossed, head: Row) -> Iterator[Row]:
    first = min(table.quantities)
    names = head.cells([*table.side, first, first])
    names.texts[-2:] = table.role, table.time
    yield names
    for row in table.rows:
        side = row.cells(table.side)
        for at, quantity in table.quantities.items():
            if time := "".join(row.texts[at : at + 1]):
                spots = (*side.origin, head.spot(at), row.spot(at))
                yield Row(row.line, [*side.texts, quantity, time], spots)


def _find(grid: Grid) -> _Crossed | None:
    for index, head in enumerate(grid.rows[:HEADERS_LOOKED_AT]):
        role, rest, quantities = _quantities_of(head)
        below = list(itertools.takewhile(has_numbers, grid.rows[index + 1 :]))
        if not quantities or not below:
            continue
        side = [at for at in filled_at(head) if at not in quantities]
        named = {name for at in side for name in parse_header(head.texts[at]).roles}
        time = _name_of_time([rest, *_texts_above(grid, index)])
        named -= {*roles.TIMINGS}
        if time and role not in named and not named.isdisjoint(roles.ROLES):
            return _Crossed(index, role, quantities, time, side, below)
    return None


def _quantities_of(head: Row) -> tuple[str, str, dict[int, str]]:
    """Return the role of the quantities in a header, what remains of it, and the quantities.

    "time (s)" remains of "time (s) with 20 g". There are no quantities if they do not
    differ, or if they have two roles.
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
    if len(names) != 1 or len(set(quantities.values())) < 2:
        return "", "", {}
    return *names.pop(), quantities


def _texts_above(grid: Grid, index: int) -> Iterator[str]:
    for row in grid.rows[index::-1]:
        yield from row.texts
    yield from (comment.text for comment in grid.comments)


def _name_of_time(texts: list[str]) -> str:
    """Return the text that names a time with its unit; "" if there is none."""
    for text in texts:
        for part in (*re.split(r"[,;:.]\s+", text), text):
            header = parse_header(part)
            if header.unit and not {*header.roles}.isdisjoint(roles.TIMINGS):
                return part
    return ""
