"""Replace dashes and colons in cells by the quantities that they mean."""

from __future__ import annotations

import re

from gyrodata.quantities.numerals import fold_number
from gyrodata.readings import layout, roles
from gyrodata.readings.chosen import Chosen
from gyrodata.readings.grid import is_number
from gyrodata.readings.lablog import BLANKS, UNKNOWN, Faults

_CLOCK = re.compile(r"(?:[0-9]{1,2}:)?[0-9]{1,3}:[0-9]{2}")
_DASHES = BLANKS - UNKNOWN - {""}
_MOST_DASHES = 0.25
"""If a larger share of the cells has a dash, it means "as above" [1]."""


def meant_texts(
    column: Chosen,
    unit: str | None,
    table: layout.Layout,
    positions: tuple[str, ...],
    faults: Faults,
) -> list[str]:
    """Return the texts of a column, as the quantities that they mean."""
    texts = list(column.texts)
    if column.role in roles.TIMINGS:
        texts = _without_words(texts)
    elif column.role == "mass":
        texts = _with_zero_for_dashes(texts, positions)
    if unit in ("s", None) and ":" in fold_number(" ".join(texts)):
        meant = _without_colons(column, texts, table, faults)
        return [meant.get(text, text) for text in texts]
    return texts


def _without_words(texts: list[str]) -> list[str]:
    """Leave out words between numbers, such as "aborted"."""
    if not any(map(is_number, texts)):
        return texts
    return [text if re.search("[0-9]", text) else "" for text in texts]


def _with_zero_for_dashes(texts: list[str], positions: tuple[str, ...]) -> list[str]:
    """Read a dash without a position as "no weight"; in many rows it means "as above"."""
    dashed = {
        i
        for i, text in enumerate(texts)
        if text in _DASHES and (not positions or positions[i] in BLANKS)
    }
    if len(dashed) > _MOST_DASHES * len(texts):
        return texts
    return ["0" if i in dashed else text for i, text in enumerate(texts)]


# Colons


def _without_colons(
    column: Chosen, texts: list[str], table: layout.Layout, faults: Faults
) -> dict[str, str]:
    """Read 10:06 as 10.06 s if another row shows that it is not a clock time.

    Below a header in s only, ask; "mm:ss" says what its cells are.
    """
    clocks = [text for text in texts if _CLOCK.fullmatch(fold_number(text))]
    if not clocks or ":" in column.header.text:
        return {}
    meant = {text: ".".join(text.rsplit(":", 1)) for text in clocks}
    values = {"first": clocks[0], "meant": meant[clocks[0]]}
    if proof := [text for text in clocks if int(text[-2:]) >= 60]:
        values |= {"proof": proof[0], "header": column.header.text}
        faults.add("colons_are_points", column.cell, **values)
        return meant
    if column.header.unit is not None:
        cell = table.grid.cell(table.rows[texts.index(clocks[0])], column.at)
        name = column.header.text.partition("[")[0].strip()
        faults.add("colon", cell, role=column.role, name=name, **values)
    return {}
