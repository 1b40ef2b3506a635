"""Runs in sentences: "20.1 g, 400 rpm: one turn took 12.3 s"."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import groupby, pairwise

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities.units import kinds_of
from gyrodata.readings.captions import QUANTITY, Given, said_in
from gyrodata.readings.grid import Grid, Row, is_head
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Faults
from gyrodata.readings.layout import NOT_USED
from gyrodata.readings.turns import words_of_turns
from gyrodata.readings.workbook import MAX_COLUMNS

_ROLES = ("mass", "position", "spin", "turns", "time")
_SEVERAL_NUMBERS = r"(?<![0-9.])[0-9.]++(?:,[0-9.]++){2,}"
"""Of "215,392,582", the commas separate cells."""


class _Part(Struct, frozen=True):
    """A line of text, or a part of it about one run."""

    line: int
    text: str
    said: Given

    @property
    def is_run(self) -> bool:
        """Return whether it gives a spin and a time."""
        return {"spin", "time"} <= self.said.keys()


def applies(grid: Grid) -> bool:
    """Return whether no header names the quantities of columns, but lines give runs."""
    heads = filter(is_head, grid.rows)
    if any(map(names_quantities, heads)):
        return False
    return sum(part.is_run for part in _parts_of(grid)) > 1


def names_quantities(row: Row) -> bool:
    """Return whether most cells of a row name a quantity.

    Of a sentence that is split at its blanks, few do.
    """
    named = [text for text in row.texts if parse_header(text).roles]
    return 2 * len(named) > len(row.filled())


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Make a row of each run; other lines are captions of the runs below them."""
    parts = list(_parts_of(grid))
    names = _names_of([part.said for part in parts if part.is_run])
    rows: list[Row] = []
    has_header = False
    for part in parts:
        words = " ".join(part.text.split())
        if not part.is_run:
            rows.append(Row(part.line, [words]))
            has_header = False
        elif NOT_USED.is_in(words):
            rows.append(Row(part.line, ["#", words]))
        else:
            rows += [] if has_header else [Row(part.line, list(names))]
            has_header = True
            texts = [part.said.get(role, ("", 0))[0] for role in names]
            spots = (part.line * MAX_COLUMNS,) * len(names)
            rows.append(Row(part.line, texts, spots))
    return replace(grid, rows=rows)


def _names_of(runs: list[Given]) -> list[str]:
    """Return the columns of a table of these runs."""
    given = {role for run in runs for role, (text, _) in run.items() if text}
    ends = sorted(role for role in given if role.startswith(("spin_", "time_")))
    return [*(role for role in _ROLES if role in given), *ends]


def _parts_of(grid: Grid) -> Iterator[_Part]:
    """Yield the lines of a table; lines of one quantity each are joined to a run."""
    for has_quantities, group in groupby(
        _read_lines(grid), lambda part: bool(part.said)
    ):
        parts = list(group)
        if has_quantities:
            yield from _as_one_run(parts)
        else:
            yield from (part for part in parts if part.text.strip())


def _as_one_run(parts: list[_Part]) -> list[_Part]:
    """Join lines that give a run together, each of them other quantities."""
    said = {role: item for part in parts for role, item in part.said.items()}
    count = sum(len(part.said) for part in parts)
    if count > len(said) or not {"spin", "time"} <= said.keys():
        return parts
    return [_Part(parts[0].line, "", said)]


def _read_lines(grid: Grid) -> Iterator[_Part]:
    first, last = grid.rows[0].line, grid.rows[-1].line
    for number, line in enumerate(grid.lines[first - 1 : last], first):
        line = re.sub(_SEVERAL_NUMBERS, lambda cells: cells[0].replace(",", " "), line)
        for text in _runs_in(line):
            part = _Part(number, text, _read_run(number, text))
            # A run behind # was taken out.
            if not part.is_run or not text.lstrip().startswith("#"):
                yield part


def _read_run(number: int, text: str) -> Given:
    """Return what a line says of a run."""
    without_number = re.sub(r"^\s*\(?[0-9]{1,2}[.):、]\s+", "", text)
    said = said_in(Row(number, [without_number]), with_time=True)
    spins = [
        match[0]
        for match in QUANTITY.finditer(text)
        if kinds_of(match[2] or match[3]) == {"rate"}
    ]
    if len(spins) == 2 and "time" in said:
        said |= {"spin_start": (spins[0], 0), "spin_end": (spins[1], 0)}
        said["spin"] = ("", 0)
    if {"spin", "time"} <= said.keys() and "turns" not in said:
        # "9.97 s for a third"
        behind = re.split("[0-9]", text)[-1].rstrip(" .;,)")
        turns = words_of_turns(behind)
        if "/" in turns:
            said["turns"] = (turns, 0)
    return said


def _runs_in(line: str) -> list[str]:
    """Split a line of several runs.

    "M1 = 40 g: (184 rpm; 9.0 s), (390 rpm; 19.3 s)" is a caption and two runs.
    """
    places: dict[str, list[int]] = {"rate": [], "time": []}
    for match in QUANTITY.finditer(line):
        for kind in kinds_of(match[2] or match[3]) & places.keys():
            places[kind].append(match.start())
    first, behind = sorted(places.values())
    alternate = [at for pair in zip(first, behind, strict=False) for at in pair]
    if len(first) < 2 or alternate != sorted(first + behind):
        return [line]
    parts = [line[start:end] for start, end in pairwise([*first, len(line)])]
    return [line[: first[0]], *parts]
