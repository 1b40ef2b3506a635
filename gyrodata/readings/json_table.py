"""Write the records or the columns of JSON as a table."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from operator import itemgetter
from typing import Any

MAX_DEPTH = 50
"""Brackets inside of brackets in JSON; a notebook with an output has about ten."""

Records = Sequence[Mapping[str, Any]]
"""One object for each run: its cells by the names of their columns."""


class NoTableError(ValueError):
    """JSON is not a table; the text says why."""


class KeyTwiceError(ValueError):
    """One object of JSON has a key twice; its text is the key."""


def read_json(text: str) -> Any:
    """Read JSON, or one object in each line.

    Raise ValueError if a key is there twice, or if it is nested too deep.
    """
    _check_depth(text)
    joined = re.sub(r"\}[ \t\r]*\n\s*\{", "}, {", text)
    # A number keeps its digits: 15.0 is not 15.00.
    return json.loads(
        text if joined == text else f"[{joined}]",
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
    for key, times in Counter(key for key, _ in pairs).items():
        if times > 1:
            raise KeyTwiceError(key)
    return dict(pairs)


def write_table(data: Any) -> str:
    """Write a table with tabs between its cells; single values become ``#`` lines.

    The table is a list of objects, or an object with its columns, as pandas writes
    them.
    """
    named: dict[str, Any] = data if isinstance(data, dict) else {}
    given = [f"# {key}: {value}" for key, value in named.items() if _is_cell(value)]
    records = _records_of(named) if named else _records_of_list(data)
    names = list(dict.fromkeys(name for record in records for name in record))
    rows = [[_text_of(record.get(name)) for name in names] for record in records]
    lines = [*given, *map("\t".join, [names, *rows])]
    # Half of a sign of two parts, which JSON can contain, is no letter.
    return ("\n".join(lines) + "\n").encode("utf-8", "replace").decode()


def _is_cell(value: Any) -> bool:
    return not isinstance(value, list | dict)


def _text_of(value: Any) -> str:
    """Return a value of JSON as a cell; what is missing is blank."""
    return "" if value is None else re.sub(r"[\t\r\n]", " ", str(value))


def _records_of_list(data: Any) -> Records:
    if _are_records(data):
        return list(data)
    raise _no_table()


def _no_table() -> NoTableError:
    return NoTableError(
        "it contains no list of objects, and no lists with the names of columns"
    )


def _records_of(named: dict[str, Any]) -> Records:
    """Return the runs of an object."""
    tables = [name for name, value in named.items() if _are_records(value)]
    if len(tables) > 1:
        raise NoTableError(
            f"it contains several tables, {', '.join(tables[:5])}: keep one"
        )
    if tables:
        return list(named[tables[0]])
    if isinstance(named.get("columns"), list) and isinstance(named.get("data"), list):
        return _records_of_rows(named["columns"], named["data"])
    columns = _columns_of(named)
    if not columns:
        raise _no_table()
    return _records_of_rows([*columns], [*zip(*columns.values(), strict=True)])


def _records_of_rows(names: list[str], rows: Sequence[Sequence[Any]]) -> Records:
    if any(len(row) != len(names) for row in rows):
        raise NoTableError("its rows do not have one value for each name of a column")
    return [dict(zip(names, row, strict=True)) for row in rows]


def _are_records(value: Any) -> bool:
    """Return whether a value is a list of objects, one for each run."""
    is_list = isinstance(value, list) and bool(value)
    return is_list and all(isinstance(item, dict) for item in value)


def _cells_of(value: Any) -> list[Any]:
    """Return the cells of a column; none if the value is something else."""
    cells = list(value.values()) if isinstance(value, dict) else value
    is_column = isinstance(cells, list) and all(map(_is_cell, cells))
    return cells if is_column else []


def _check_lengths(columns: dict[str, list[Any]]) -> None:
    """Raise NoTableError if columns have different lengths."""
    lengths = sorted(set(map(len, columns.values())))
    if len(lengths) > 1:
        listed = ", ".join(map(str, lengths[:5]))
        raise NoTableError(f"its lists have different lengths, {listed}")


def _keys_of(column: Any) -> tuple[str, ...]:
    return tuple(column) if isinstance(column, dict) else ()


def _columns_of(named: dict[str, Any]) -> dict[str, list[Any]]:
    """Return the columns of an object.

    They are lists of equal length, or objects with the same keys. They may be below one
    key, such as "data".
    """
    cells = [(name, _cells_of(value)) for name, value in named.items()]
    columns = dict(filter(itemgetter(1), cells))
    keys = {_keys_of(named[name]) for name in columns} - {()}
    _check_lengths(columns)
    if len(columns) > 1 and len(keys) < 2:
        return columns
    inner = [value for value in named.values() if isinstance(value, dict)]
    return next(filter(None, map(_columns_of, inner)), {})
