"""Replace names, dashes and colons in cells by the quantities that they mean."""

from __future__ import annotations

import re
from collections.abc import Iterator

from gyrodata.quantities import numerals
from gyrodata.quantities.numerals import fold_number
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import layout, roles
from gyrodata.readings.chosen import Chosen, pair_in
from gyrodata.readings.grid import filled_at, is_number
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import BLANKS, UNKNOWN, Faults
from gyrodata.readings.origins import FROM
from gyrodata.readings.roles import kind_of_role

_PLUS = re.compile(rf"(?:(?<!\s)\s+)?{numerals.PLUS}\s*")
"""Between two weights that hang together."""
_CLOCK = re.compile(r"(?:[0-9]{1,2}:)?[0-9]{1,3}:[0-9]{2}")
_CLOCK_HEADER = re.compile(r"(?<![a-z])([a-z]+):[a-z]+(:[a-z]+)?")
"""A header that shows the form of its cells: "time (mm:ss:cc)"."""
_BEHIND = rf"\s*(?:[,;)\"]|\.\s|$)|\s{{2}}|\t|\s+\(?{FROM}\b"
_QUANTITY = rf"({numerals.NUMBER}\s*[^\W\d_]+)(?={_BEHIND})"
"""A quantity in a line such as "A = 20.1 g", with no "+ 5 g" behind it."""
_DASHES = BLANKS - UNKNOWN - {""}
_MOST_DASHES = 0.25
"""If a larger share of the cells has a dash, it means "as above" [1]."""
_MOST_NAMES = 30
_LONGEST_NAME = 20


def meant_texts(
    column: Chosen,
    unit: str | None,
    table: layout.Layout,
    positions: tuple[str, ...],
    faults: Faults,
) -> list[str]:
    """Return the texts of a column, as the quantities that they mean."""
    if column.part:
        pairs = filter(None, map(pair_in, column.texts))
        return [pair[column.part - 1] for pair in pairs]
    texts = list(column.texts)
    if column.role in roles.TIMINGS:
        texts = _without_words(texts)
    elif column.role == "mass":
        texts = _with_zero_for_dashes(texts, positions)
    if unit in ("s", None) and ":" in fold_number(" ".join(texts)):
        meant = _without_colons(column, texts, table, faults)
    else:
        meant = _explained_names(column, unit, texts, table)
        _note_explanations(meant, column, table, faults)
    return [_replaced(text, meant) for text in texts] if meant else texts


def _without_words(texts: list[str]) -> list[str]:
    """Leave out words between numbers, such as "aborted"."""
    if not any(map(is_number, texts)):
        return texts
    return [text if re.search("[0-9]", text) else "" for text in texts]


def _replaced(text: str, meant: dict[str, str]) -> str:
    return " + ".join(meant.get(part, part) for part in _PLUS.split(text))


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


# Names


def _explained_names(
    column: Chosen, unit: str | None, texts: list[str], table: layout.Layout
) -> dict[str, str]:
    """Return the quantity of each name in the cells that the log explains once.

    Examples are the line "A = 20.1 g", and a table of the weights.
    """
    meant = {}
    for name in sorted(_names(column, unit, texts))[:_MOST_NAMES]:
        quantities = {
            *_quantities_in_lines(name, column, table),
            *_quantities_in_tables(name, column, table),
        }
        if len(quantities) == 1:
            meant[name] = quantities.pop()
    return meant


def _names(column: Chosen, unit: str | None, texts: list[str]) -> set[str]:
    """Return the cells that may be names: letters, or 1, 2, … without a unit."""
    is_arm = column.role in ("mass", "position")
    if is_arm and unit is None and all(re.fullmatch("[1-9]?", text) for text in texts):
        return {*texts} - {""}
    if column.role not in roles.LOADS:
        return set()
    parts = {part for text in texts for part in (text, *_PLUS.split(text))}  # "A+B"
    return {part for part in parts if part[:1].isalpha() and len(part) <= _LONGEST_NAME}


def _quantities_in_lines(
    name: str, column: Chosen, table: layout.Layout
) -> Iterator[str]:
    """Yield the quantities behind a name: "A = 20.1 g", or "Weight 1: 20.1 g"."""
    pattern = rf"(?<![\w.]){re.escape(name)}\s*[=:,;\t]\s*{_QUANTITY}"
    if name.isdigit():
        owner = rf"(?i:(?<![\w.]){re.escape(column.header.text)})\s*(?:n[or]\.?|#)?\s*"
        pattern = rf"(?:{owner}{pattern}|#{name}\s+{_QUANTITY})"
    for line in table.grid.lines:
        for match in re.finditer(pattern, line):
            yield match[match.lastindex or 0]


def _quantities_in_tables(
    name: str, column: Chosen, table: layout.Layout
) -> Iterator[str]:
    """Yield the quantities in a table of two columns: "disc, mass / g" above "small, 19.7"."""
    unit = ""
    for row in table.grid.rows:
        if len(filled_at(row)) != 2:
            continue
        label, number = filter(None, row.texts)
        if not is_number(number):
            unit = parse_header(number).unit or ""
        elif label == name and kind_of_role(column.role) in kinds_of(unit):
            yield f"{number} {unit}"


def _note_explanations(
    meant: dict[str, str], column: Chosen, table: layout.Layout, faults: Faults
) -> None:
    """Say what the names mean, and remove the warnings of the lines that explain them."""
    if not meant:
        return
    said = ", ".join(f"{name} is {text}" for name, text in meant.items())
    faults.add("name_explained", column.cell, said=said)
    lines = enumerate(table.grid.lines, 1)
    used = {n for n, line in lines if any(text in line for text in meant.values())}
    faults.take_back("remark", used)


# Colons


def _without_colons(
    column: Chosen, texts: list[str], table: layout.Layout, faults: Faults
) -> dict[str, str]:
    """Read 10:06 as 10.06 s if another row shows that it is not a clock time.

    Below a header in s only, ask.
    """
    clocks = [text for text in texts if _CLOCK.fullmatch(fold_number(text))]
    meant = {text: ".".join(text.rsplit(":", 1)) for text in clocks}
    if form := _CLOCK_HEADER.search(column.header.text.lower()):
        return _of_stated_form(form, meant)
    if not meant:
        return {}
    first = clocks[0]
    values = {"first": first, "meant": meant[first]}
    if proof := [text for text in clocks if int(text[-2:]) >= 60]:
        values |= {"proof": proof[0], "header": column.header.text}
        faults.add("colons_are_points", column.cell, **values)
        return meant
    if column.header.unit is None:
        return {}
    cell = table.grid.cell(table.rows[texts.index(first)], column.at)
    name = column.header.text.partition("[")[0].strip()
    faults.add("colon", cell, role=column.role, name=name, **values)
    return meant


def _of_stated_form(form: re.Match[str], meant: dict[str, str]) -> dict[str, str]:
    """Return the texts of three numbers, if a header such as "mm:ss:cc" shows three."""
    three = [text for text in meant if form[2] and text.count(":") == 2]
    if form[1].startswith("h"):
        return {text: text.removeprefix("00:") for text in three}
    return {text: meant[text] for text in three}
