"""Write the numbers in a program or in a notebook as a table."""

from __future__ import annotations

import json
import re
from collections import Counter
from typing import Any

from gyrodata.quantities.units import kinds_of
from gyrodata.readings.headers import parse_header
from gyrodata.readings.turns import turns_in

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


MAX_DEPTH = 50
"""Brackets inside of brackets in JSON; a notebook with an output has about ten."""


class NoTableError(ValueError):
    """JSON is not a table; the text says why."""


class KeyTwiceError(ValueError):
    """One object of JSON has a key twice; its text is the key."""


def table_of(text: str) -> str:
    """Return the lists of a program as the columns of a table, or its rows without brackets."""
    notes: list[str] = []
    if text.lstrip()[:1] in ("{", "["):
        data = _json(text)
        if "cells" not in data or not _is_notebook(data):
            return _table_of_json(data)
        cells = [(cell["cell_type"], "".join(cell["source"])) for cell in data["cells"]]
        text = "\n".join(source for _, source in cells)
        notes = [
            f"# {line}"
            for kind, source in cells
            if kind == "markdown"
            for line in source.split("\n")
            if line
        ]
    lists = [
        (_header(found), re.split(r"[\s,;]+", found["cells"].strip(" ,;\n")))
        for found in re.finditer(_LIST, text)
    ]
    often = Counter(len(cells) for _, cells in lists if len(cells) > 2).most_common(1)
    columns = [
        (header, cells)
        for header, cells in lists
        if often and len(cells) == often[0][0]
    ]
    notes += [
        f"# {line.lstrip(' #%')}"
        for line in text.split("\n")
        if re.match(r"\s*[#%]", line)
    ]
    if len(columns) < 2:
        lines = (
            re.sub(r"^\s*%+", "#", line)
            for line in text.split("\n")
            if not re.match(_STATEMENT, line)
        )
        return "\n".join(re.sub(_CODE, "", line) for line in lines)
    single = (
        (parse_header(_header(found)), found["cells"])
        for found in re.finditer(_ONE, text)
    )
    given = [
        f"# {one.roles[0]}: {cells} {one.unit or ''}"
        for one, cells in single
        if len(one.roles) == 1
    ]
    rows_of = zip(*(cells for _, cells in columns), strict=True)
    table = [", ".join(header for header, _ in columns), *map(", ".join, rows_of)]
    return "\n".join([*dict.fromkeys(notes), *given, *table]) + "\n"


def _json(text: str) -> Any:
    """Read JSON, or one object in each line.

    Raise ValueError if a key is there twice, or if it is nested too deep.
    """
    _check_depth(text)
    joined = re.sub(r"\}[ \t\r]*\n\s*\{", "}, {", text)
    whole = text if joined == text else f"[{joined}]"
    # A number keeps its digits: 15.0 is not 15.00.
    return json.loads(
        whole,
        object_pairs_hook=_object,
        parse_float=str,
        parse_int=str,
        parse_constant=_constant,
    )


def _constant(name: str) -> str | None:
    return None if name == "NaN" else name


def _check_depth(text: str) -> None:
    """Raise NoTableError if brackets are nested deeper than in any table."""
    depth = 0
    for sign in re.finditer(r'(?s)"(?:[^"\\]|\\.)*+"?|[\[\]{}]', text):
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(sign[0], 0)
        if depth > MAX_DEPTH:
            raise NoTableError(
                f"it contains brackets inside of brackets, more than {MAX_DEPTH} deep"
            )


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object of JSON; raise KeyTwiceError if a key is there twice."""
    count = Counter(key for key, _ in pairs)
    for key, times in count.items():
        if times > 1:
            raise KeyTwiceError(key)
    return dict(pairs)


def _is_notebook(data: Any) -> bool:
    return isinstance(data, dict) and isinstance(data["cells"], list)


def _table_of_json(data: Any) -> str:
    """Write records, or lists with the names of their columns, as a table.

    Other values become ``#`` lines.
    """
    named = data if isinstance(data, dict) else {}
    tables = [name for name, value in named.items() if _are_records(value)]
    if len(tables) > 1:
        raise NoTableError(
            f"it contains several tables, {', '.join(tables[:5])}: keep one"
        )
    records = data if _are_records(data) else []
    if tables:
        records = named[tables[0]]
    columns = {} if records else _columns_of(named)
    if not records and not columns:
        raise NoTableError(
            "it contains no list of objects, and no lists with the names of columns"
        )
    if columns:
        records = [
            dict(zip(columns, row, strict=True))
            for row in zip(*columns.values(), strict=True)
        ]
    given = [
        f"# {key}: {value}"
        for key, value in named.items()
        if not isinstance(value, list | dict)
    ]
    names = list(dict.fromkeys(name for row in records for name in row))
    runs = ("\t".join(_text_of(row.get(name)) for name in names) for row in records)
    table = "\n".join([*given, "\t".join(names), *runs]) + "\n"
    # Half of a sign of two parts, which JSON can contain, is no letter.
    return table.encode("utf-8", "replace").decode()


def _are_records(value: Any) -> bool:
    """Return whether a value is a list of objects, one for each run."""
    return (
        isinstance(value, list)
        and bool(value)
        and all(isinstance(one, dict) for one in value)
    )


def _columns_of(named: dict[str, Any]) -> dict[str, list[Any]]:
    """Return the columns of an object.

    They are lists of equal length, or objects with the same keys, as pandas writes
    them.

    They may be below one key, such as "data".
    """
    lists = {
        name: list(one.values()) if isinstance(one, dict) else one
        for name, one in named.items()
    }
    lists = {name: one for name, one in lists.items() if isinstance(one, list)}
    plain = {
        name: one
        for name, one in lists.items()
        if not any(isinstance(cell, list | dict) for cell in one)
    }
    if len(plain) > 1 and _have_equal_keys([named[name] for name in plain]):
        return plain
    lengths = sorted({len(one) for one in plain.values()})
    if len(lengths) > 1:
        raise NoTableError(
            f"its lists have different lengths, {', '.join(map(str, lengths[:5]))}"
        )
    inner = [one for one in named.values() if isinstance(one, dict)]
    return next(filter(None, map(_columns_of, inner)), {})


def _have_equal_keys(columns: list[Any]) -> bool:
    """Return whether columns have the same number of cells.

    Those that are objects, the same keys too.
    """
    keys = {tuple(one) for one in columns if isinstance(one, dict)}
    return len({len(one) for one in columns}) == 1 and len(keys) < 2


def _text_of(value: Any) -> str:
    """Return a value of JSON as a cell; what is missing is blank."""
    return "" if value is None else re.sub(r"[\t\r\n]", " ", str(value))


def _header(found: re.Match[str]) -> str:
    """Return the name of a list, with the unit in the comment behind it.

    If the comment names a column, the function returns the comment instead.
    """
    name, said = found["name"].strip("\"'"), (found["said"] or "").strip()
    unit, _, words = said.partition(" ")
    unit = unit.strip(",;:()[]")
    if kinds_of(unit):
        said = f"{name} [{unit}]" if not parse_header(name).unit else name
        said = f"{name} {words} [{unit}]" if turns_in(words) else said
    return (said if parse_header(said).roles else name).replace(",", " ")
