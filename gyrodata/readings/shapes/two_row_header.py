"""A second row of names below merged cells: "Time (s)" over 1, 2, 3."""

from __future__ import annotations

import re
from itertools import pairwise

from msgspec.structs import replace

from gyrodata.readings import roles
from gyrodata.readings.grid import (
    HEADERS_LOOKED_AT,
    Grid,
    Row,
    filled_at,
    is_bare,
    is_head,
    units_of_row,
)
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Faults
from gyrodata.readings.unusual_headers import split_unit

_READING = re.compile(r"[.,][0-9]|[0-9]{3}")
"""Part of a number that does not count repeats."""


def applies(grid: Grid) -> bool:
    """Return whether a row of names goes on in the next row."""
    return any(_joined(*pair) for pair in pairwise(grid.rows[:HEADERS_LOOKED_AT]))


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Join both rows of each header."""
    rows: list[Row] = []
    for row in grid.rows:
        header = _joined(rows[-1], row) if rows else None
        if header is None:
            rows.append(row)
        else:
            rows[-1] = header
    return replace(grid, rows=rows)


def _joined(upper: Row, lower: Row) -> Row | None:
    """Return the header of two rows; None if the lower one contains no names."""
    if not _may_go_on(upper, lower):
        return None
    texts = [*upper.texts, *[""] * (len(lower.texts) - len(upper.texts))]
    over = ""
    for at, text in enumerate(lower.texts):
        over = texts[at] or over
        if text:
            texts[at] = _name_of(over, text)
            if not parse_header(texts[at]).roles:
                return None
    last = len(upper.texts) - 1
    spots = tuple(upper.spot(min(at, last)) for at in range(len(texts)))
    return Row(upper.line, texts, spots)


def _may_go_on(upper: Row, lower: Row) -> bool:
    """Return whether a header has blank cells, below which a row has names."""
    is_wider = len(lower.texts) > len(upper.texts) and not is_head(lower)
    if not is_wider and "" not in upper.texts:
        return False
    if not is_head(upper) and not _is_over_trials(upper, lower):
        return False
    is_run = any(is_bare(text) and _READING.search(text) for text in lower.texts)
    return not is_run and (is_head(lower) or not units_of_row(lower.texts))


def _name_of(over: str, text: str) -> str:
    """Return the name of a column below a merged cell."""
    header = parse_header(text)
    if header.unit and {*header.roles} - roles.TEXTS:
        return text
    name, unit = split_unit(over)
    return f"{name} {text.rstrip('.')}" + (f" [{unit}]" if unit else "")


def _is_over_trials(upper: Row, lower: Row) -> bool:
    """Return whether a row begins with a time over cells that only number repeats."""
    at = filled_at(upper)[0]
    over, under = parse_header(upper.texts[at]), "".join(lower.texts[at : at + 1])
    is_time = over.unit and not {*over.roles}.isdisjoint(roles.TIMINGS)
    is_next = upper.line == lower.line - 1
    is_trial = {*parse_header(under).roles} <= roles.TEXTS
    return bool(is_time) and at > 0 and is_next and is_trial
