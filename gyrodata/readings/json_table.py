"""Write the records or the columns of JSON as a table."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from gyrodata.readings import conversion

_Columns = Mapping[str, Sequence[Any]]
"""Cells of each column, by its name."""


class NoTableError(ValueError):
    """JSON is not a table; the text says why."""


class KeyTwiceError(ValueError):
    """One object of JSON has a key twice; its text is the key."""


def table_of(text: str) -> str:
    """Write JSON as a table with tabs between its cells; single values become ``#`` lines.

    The table is a list of objects, or an object with its columns, as pandas writes
    them; it may be the value of a key.
    """
    # A number keeps its digits: 15.0 is not 15.00.
    data = json.loads(
        text,
        object_pairs_hook=_object,
        parse_float=str,
        parse_int=str,
        parse_constant=_constant,
    )
    named = data if isinstance(data, dict) else {"runs": data}
    given = [f"# {key}: {value}" for key, value in named.items() if _is_cell(value)]
    columns = _columns_of({k: v for k, v in named.items() if not _is_cell(v)})
    rows = zip(*(map(_text_of, cells) for cells in columns.values()), strict=True)
    lines = [*given, *map("\t".join, [columns, *rows])]
    # Half of a sign of two parts, which JSON can contain, is not a letter.
    return ("\n".join(lines) + "\n").encode("utf-8", "replace").decode()


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object of JSON; raise KeyTwiceError if a key is there twice."""
    for key, times in Counter(key for key, _ in pairs).items():
        if times > 1:
            raise KeyTwiceError(key)
    return dict(pairs)


def _constant(name: str) -> str | None:
    return None if name == "NaN" else name


def _is_cell(value: Any) -> bool:
    return not isinstance(value, list | dict)


def _text_of(value: Any) -> str:
    """Return a value of JSON as a cell; what is missing is blank."""
    return "" if value is None else conversion.quoted_text(str(value))


def _columns_of(named: dict[str, Any]) -> _Columns:
    """Return the columns of the lists and objects of JSON, by their names."""
    tables = [name for name, value in named.items() if _are_records(value)]
    if len(tables) > 1:
        several = ", ".join(tables[:5])
        raise NoTableError(f"it contains several tables, {several}: keep one")
    if tables:
        return _columns_of_records(named[tables[0]])
    values = list(named.values())
    if len(values) == 1 and isinstance(values[0], dict):
        named = values[0]
    return _checked({name: _cells_of(value) for name, value in named.items()})


def _checked(columns: _Columns) -> _Columns:
    """Return columns of one length; raise NoTableError for something else."""
    if not all(columns.values()) or len(columns) < 2:
        raise NoTableError(
            "it contains no list of objects, and no lists with the names of columns"
        )
    lengths = sorted(set(map(len, columns.values())))
    if len(lengths) > 1:
        listed = ", ".join(map(str, lengths[:5]))
        raise NoTableError(f"its lists have different lengths, {listed}")
    return columns


def _are_records(value: Any) -> bool:
    """Return whether a value is a list of objects, one for each run."""
    is_list = isinstance(value, list) and bool(value)
    return is_list and all(isinstance(item, dict) for item in value)


def _columns_of_records(records: list[dict[str, Any]]) -> _Columns:
    names = dict.fromkeys(name for record in records for name in record)
    columns = {name: [record.get(name) for record in records] for name in names}
    nested = [name for name, cells in columns.items() if not all(map(_is_cell, cells))]
    if nested:
        raise NoTableError(f'"{nested[0]:.60}" contains more than one value')
    return columns


def _cells_of(value: Any) -> list[Any]:
    """Return the cells of a column, by position or by row; none of something else."""
    cells = list(value.values()) if isinstance(value, dict) else value
    is_column = isinstance(cells, list) and all(map(_is_cell, cells))
    return cells if is_column else []
