"""A column that counts weights, and a text that states the mass of one."""

from __future__ import annotations

import re

from msgspec.structs import replace

from gyrodata.quantities import notation, vocabulary
from gyrodata.readings import roles
from gyrodata.readings.grid import Grid, Row, filled_at, is_head
from gyrodata.readings.lablog import Faults
from gyrodata.readings.roles import parse_header

_ONE_WEIGHT = re.sub(r"([sne])(?=\||$)", r"\1?", vocabulary.words("weights", "|"))
_EACH = vocabulary.words("each", "|")
_MASS = rf"({notation.NUMBER}\s*k?g)\b"
_MASS_OF_ONE = re.compile(
    rf"(?i)\b(?:{_EACH})\W+(?:\w+\W+)?(?:{_ONE_WEIGHT})\b[^0-9;]{{0,20}}?{_MASS}"
    rf"|(?<![0-9]){_MASS}\s*(?:{_EACH})\b"
)
"""A text such as "one washer = 8.3 g"."""


def applies(grid: Grid) -> bool:
    """Return whether a column counts weights whose mass one text states."""
    return any(map(_counts_at, grid.rows)) and len(_masses_of_one(grid)) == 1


def _counts_at(row: Row) -> list[int]:
    """Return the places of the headers of counts."""
    if not is_head(row):
        return []
    return [
        at for at in filled_at(row) if roles.counts_weights(parse_header(row.texts[at]))
    ]


def _masses_of_one(grid: Grid) -> set[str]:
    texts = [comment.text for comment in grid.comments]
    texts += [" ".join(row.texts) for row in grid.rows]
    matches = [match for text in texts for match in _MASS_OF_ONE.finditer(text)]
    return {match[1] or match[2] for match in matches}


def to_rows(grid: Grid, faults: Faults) -> Grid:
    """Replace the counts by masses."""
    mass = min(_masses_of_one(grid))
    counts = [(head, at) for head in grid.rows for at in _counts_at(head)]
    for head, at in counts:
        said = f"1 of {head.texts[at]} is {mass}"
        faults.add("name_explained", grid.cell(head, at), said=said)
        head.texts[at] = "mass"
    places = {at for _, at in counts}
    return replace(grid, rows=[_with_masses(row, places, mass) for row in grid.rows])


def _with_masses(row: Row, places: set[int], mass: str) -> Row:
    texts = [
        _times(text, mass) if at in places else text
        for at, text in enumerate(row.texts)
    ]
    return replace(row, texts=texts)


def _times(count: str, mass: str) -> str:
    """Return the mass of a number of weights, as a product; other texts as they are."""
    if not count.isdecimal():
        return count
    return "0 g" if count == "0" else f"{count} x {mass}"
