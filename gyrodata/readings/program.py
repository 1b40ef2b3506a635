"""Write the numbers in a program or in a notebook as a table."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any

from gyrodata.quantities.units import kinds_of
from gyrodata.readings import json_table
from gyrodata.readings.headers import parse_header
from gyrodata.readings.json_table import KeyTwiceError, NoTableError
from gyrodata.readings.turns import turns_in

__all__ = ["KeyTwiceError", "NoTableError", "table_of"]

_NAME = r"(?m)(?:^[^\S\n]*|[{(,]\s*)(?P<name>\"[^\"\n]+\"|'[^'\n]+'|[^\W\d]\w*)\s*(?:=|:|<-)\s*"
_SAID = r"[\])} \t;]*(?:,(?=[ \t]*[#%]))?[ \t]*(?:[#%]+[ \t]*(?P<said>[^\n]*))?"
_LIST = rf"{_NAME}(?:[\w.]+\(|[\[(])+(?P<cells>[^\[\](){{}}=#%:]+)[\])]+{_SAID}"
"""A list, in Python, MATLAB or R: ``m = np.array([20.1, 40.2])  # g``, ``"mass_g":
[20.1, 40.2]``."""
_ONE = (
    rf"{_NAME}(?P<cells>[-+]?[0-9][0-9.e/+-]*)[ \t]*+(?:[;,][ \t]*+)?(?:$|[#%]+[ "
    rf"\t]*(?P<said>[^\n]*))"
)
"""A single number: ``x = 15.0  # cm``."""
_CODE = (
    r"^\s*\w+\s*=\s*(?:[\w.]*\()*(?:\"\"\"|'''|[\[({]+)|\"\"\"|'''|^[\s\[(]*(?=[-+\d.])"
    r"|(?<=[\d.])[\s\])]*+(?:[,;]\s*+)?$|^[\])};,\s]+$"
)
"""What is around the rows of a table in a program."""
_STATEMENT = (
    r"\s*+(?:(?:import|from|print|df)\b"
    r"|[\w, ]+=\s*(?![\w.]*[\"'\[({]*\s*(?:$|[-+\d.\"']))(?=.*(?:[*\[]|\w[(./]\w)))"
)
"""A line that calculates: ``I = [m * x for m, x in rows]``; "d = distance in cm" does
not."""

_Column = tuple[str, list[str]]
"""Name and cells of a list."""


def table_of(text: str) -> str:
    """Return the lists of a program as the columns of a table, or its rows without brackets."""
    notes: list[str] = []
    if text.lstrip()[:1] in ("{", "["):
        data = json_table.read_json(text)
        if not _is_notebook(data):
            return json_table.write_table(data)
        text = "\n".join("".join(cell["source"]) for cell in data["cells"])
        notes = _notes_of_notebook(data)
    columns = _columns_in(text)
    if len(columns) < 2:
        return _without_code(text)
    return "\n".join([*notes, *_table_of_lists(text, columns)]) + "\n"


def _is_notebook(data: Any) -> bool:
    return isinstance(data, dict) and isinstance(data.get("cells"), list)


def _notes_of_notebook(data: Any) -> list[str]:
    """Return the text between the programs of a notebook, as comments."""
    texts = [
        "".join(cell["source"])
        for cell in data["cells"]
        if cell["cell_type"] == "markdown"
    ]
    lines = "\n".join(texts).split("\n")
    return [f"# {line}" for line in lines if line]


def _columns_in(text: str) -> list[_Column]:
    """Return the lists of a program that have the most common length."""
    lists = [
        (_header(found), re.split(r"[\s,;]+", found["cells"].strip(" ,;\n")))
        for found in re.finditer(_LIST, text)
    ]
    lengths = Counter(len(cells) for _, cells in lists if len(cells) > 2)
    usual = max(lengths, key=lengths.__getitem__, default=0)
    return [(header, cells) for header, cells in lists if len(cells) == usual]


def _table_of_lists(text: str, columns: list[_Column]) -> list[str]:
    """Return the lines of a table: comments, single numbers as keys, names and rows."""
    remarks = [
        f"# {line.lstrip(' #%')}"
        for line in text.split("\n")
        if line.lstrip().startswith(("#", "%"))
    ]
    given = []
    for number in re.finditer(_ONE, text):
        header = parse_header(_header(number))
        if len(header.roles) == 1:
            given.append(f"# {header.roles[0]}: {number['cells']} {header.unit or ''}")
    names = ", ".join(header for header, _ in columns)
    rows = zip(*(cells for _, cells in columns), strict=True)
    return [*dict.fromkeys(remarks), *given, names, *map(", ".join, rows)]


def _without_code(text: str) -> str:
    """Return the lines of a program without what calculates, and without brackets."""
    lines = []
    for line in text.split("\n"):
        if not re.match(_STATEMENT, line):
            remark = line.lstrip()
            if remark.startswith("%"):
                line = f"#{remark.lstrip('%')}"
            lines.append(re.sub(_CODE, "", line))
    return "\n".join(lines)


def _header(found: re.Match[str]) -> str:
    """Return the name of a list, with the unit in the comment behind it.

    If the comment names a column, the function returns the comment instead.
    """
    name, comment = found["name"].strip("\"'"), (found["said"] or "").strip()
    unit, _, words = comment.partition(" ")
    unit = unit.strip(",;:()[]")
    header = comment
    if kinds_of(unit) and turns_in(words):
        header = f"{name} {words} [{unit}]"
    elif kinds_of(unit):
        header = name if parse_header(name).unit else f"{name} [{unit}]"
    return (header if parse_header(header).roles else name).replace(",", " ")
