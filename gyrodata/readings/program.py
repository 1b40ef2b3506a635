"""Write the numbers in a program or in a notebook as a table."""

from __future__ import annotations

import re
from collections import Counter

import msgspec

from gyrodata.readings.roles import parse_header, turns_in
from gyrodata.units import kinds_of

_NAME = r"(?m)(?:^|[{(,])\s*(?P<name>\"[^\"\n]+\"|'[^'\n]+'|[^\W\d]\w*)\s*(?:=|:|<-)\s*"
_SAID = r"[\])} \t;]*(?:,(?=[ \t]*[#%]))?[ \t]*(?:[#%]+[ \t]*(?P<said>[^\n]*))?"
_LIST = rf"{_NAME}(?:[\w.]+\(|[\[(])+(?P<cells>[^\[\](){{}}=#%:]+)[\])]+{_SAID}"
"""A list, in Python, MATLAB or R: ``m = np.array([20.1, 40.2])  # g``, ``"mass_g": [20.1, 40.2]``."""
_ONE = rf"{_NAME}(?P<cells>[-+]?[0-9][0-9.e/+-]*)[ \t]*[;,]?[ \t]*(?:$|[#%]+[ \t]*(?P<said>[^\n]*))"
"""A single number: ``x = 15.0  # cm``."""
_CODE = (
    r"^\s*\w+\s*=\s*(?:[\w.]*\()*(?:\"\"\"|'''|[\[({]+)|\"\"\"|'''|^[\s\[(]*(?=[-+\d.])"
    r"|(?<=[\d.])[\s\])]*[,;]?\s*$|^[\])};,\s]+$"
)
"""What is around the rows of a table in a program."""
_STATEMENT = (
    r"\s*(?:(?:import|from|print|df)\b"
    r"|[\w, ]+=\s*(?![\w.]*[\"'\[({]*\s*(?:$|[-+\d.\"']))(?=.*(?:[*\[]|\w[(./]\w)))"
)
"""A line that calculates: ``I = [m * x for m, x in rows]``; "d = distance in cm" does not."""


def table_of(text: str) -> str:
    """Return the lists of a program as the columns of a table, or its rows without brackets."""
    notes: list[str] = []
    if text[:1] in "{[":
        joined = re.sub(r"\}\s*\n\s*\{", "}, {", text)  # one object in each line
        data = msgspec.json.decode(text if joined == text else f"[{joined}]")
        if "cells" not in data:
            named = {} if isinstance(data, list) else data
            rows = next((one for one in named.values() if isinstance(one, list) and isinstance(one[0], dict)), data)
            given = [f"# {key}: {value}" for key, value in named.items() if not isinstance(value, list | dict)]
            names = list(dict.fromkeys(name for row in rows for name in row))
            runs = ("\t".join(str(row.get(name, "")) for name in names) for row in rows)
            return "\n".join([*given, "\t".join(names), *runs]) + "\n"
        cells = [(cell["cell_type"], "".join(cell["source"])) for cell in data["cells"]]
        text = "\n".join(source for _, source in cells)
        notes = [f"# {line}" for kind, source in cells if kind == "markdown" for line in source.split("\n") if line]
    lists = [
        (_header(found), re.split(r"[\s,;]+", found["cells"].strip(" ,;\n"))) for found in re.finditer(_LIST, text)
    ]
    often = Counter(len(cells) for _, cells in lists if len(cells) > 2).most_common(1)
    columns = [(header, cells) for header, cells in lists if often and len(cells) == often[0][0]]
    notes += [f"# {line.lstrip(' #%')}" for line in text.split("\n") if re.match(r"\s*[#%]", line)]
    if len(columns) < 2:
        lines = (re.sub(r"^\s*%+", "#", line) for line in text.split("\n") if not re.match(_STATEMENT, line))
        return "\n".join(re.sub(_CODE, "", line) for line in lines)
    single = ((parse_header(_header(found)), found["cells"]) for found in re.finditer(_ONE, text))
    given = [f"# {one.roles[0]}: {cells} {one.unit or ''}" for one, cells in single if len(one.roles) == 1]
    rows_of = zip(*(cells for _, cells in columns), strict=True)
    table = [", ".join(header for header, _ in columns), *map(", ".join, rows_of)]
    return "\n".join([*dict.fromkeys(notes), *given, *table]) + "\n"


def _header(found: re.Match[str]) -> str:
    """Return the name of a list, with the unit in the comment behind it, or else that comment if it names a column."""
    name, said = found["name"].strip("\"'"), (found["said"] or "").strip()
    unit, _, words = said.partition(" ")
    unit = unit.strip(",;:()[]")
    if kinds_of(unit):
        said = f"{name} [{unit}]" if not parse_header(name).unit else name
        said = f"{name} {words} [{unit}]" if turns_in(words) else said
    return (said if parse_header(said).roles else name).replace(",", " ")
