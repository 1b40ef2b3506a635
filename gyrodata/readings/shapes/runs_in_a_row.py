"""Several runs in a row: "mass, rpm 1, time 1, rpm 2, time 2"."""

from __future__ import annotations

import re
from itertools import pairwise, takewhile

from msgspec.structs import replace

from gyrodata.readings import roles
from gyrodata.readings.grid import HEADERS_LOOKED_AT, Grid, Row, filled_at, is_number
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Faults
from gyrodata.readings.words import squeeze

_NUMBER = r"(?:(?<![\s_#])[\s_#]+)?[1-9][0-9]?(?=\s*(?:[\[(].*)?$)"
"""The number of a run at the end of a name, in front of the unit."""


def applies(grid: Grid) -> bool:
    """Return whether a header names the spin and the time of several runs."""
    return any(_parts_of(row)[1] for row in grid.rows[:HEADERS_LOOKED_AT])


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Make a row of each run, with the cells that all runs of a row share."""
    index = [bool(_parts_of(row)[1]) for row in grid.rows].index(True)
    head = grid.rows[index]
    shared, runs = _parts_of(head)
    names = head.cells([*shared, *runs[0]])
    rows = [replace(names, texts=list(map(_without_number, names.texts)))]
    below = list(takewhile(_has_numbers, grid.rows[index + 1 :]))
    for row in below:
        filled = [run for run in runs if any(row.cells(run).texts)]
        rows += [row.cells([*shared, *run]) for run in filled]
    cell = grid.cell(head, runs[0][0])
    faults.add("stacked", cell, line=[head.line], count=len(runs))
    rest = grid.rows[index + 1 + len(below) :]
    return replace(grid, rows=[*grid.rows[:index], *rows, *rest])


def _without_number(name: str) -> str:
    return re.sub(_NUMBER, "", name)


def _has_numbers(row: Row) -> bool:
    return any(map(is_number, row.texts[1:]))


def _parts_of(head: Row) -> tuple[list[int], list[list[int]]]:
    """Return the columns that all runs share, and those of each run.

    Both are empty if the header is an ordinary one.
    """
    places = _places_by_name(head)
    repeated = [columns for columns in places.values() if len(columns) > 1]
    if len(repeated) < 2 or len(set(map(len, repeated))) > 1:
        return [], []
    shared = [columns[0] for columns in places.values() if len(columns) == 1]
    runs = list(map(list, zip(*repeated, strict=True)))
    if _are_runs(head, runs) and _roles_of(head, shared) - {"run"}:
        return shared, runs
    return [], []


def _places_by_name(head: Row) -> dict[str, list[int]]:
    """Return the columns of each name, without the number of a run."""
    places: dict[str, list[int]] = {}
    for at in filled_at(head):
        name = squeeze(_without_number(head.texts[at])).lower()
        places.setdefault(name, []).append(at)
    return places


def _are_runs(head: Row, runs: list[list[int]]) -> bool:
    """Return whether each run has a spin and a time.

    "n1, n2, t1, t2" has the spin before and after.
    """
    in_order = all(max(run) < min(after) for run, after in pairwise(runs))
    of_run = _roles_of(head, runs[0])
    return in_order and "spin" in of_run and not of_run.isdisjoint(roles.TIMINGS)


def _roles_of(head: Row, places: list[int]) -> set[str]:
    names = [_without_number(head.texts[at]) for at in places]
    return {role for name in names for role in parse_header(name).roles}
