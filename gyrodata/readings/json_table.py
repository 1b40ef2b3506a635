"""Write the records or the columns of JSON as a table."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

from gyrodata.readings import conversion


class NoTableError(ValueError):
    """JSON is not a table; the text says why."""


def table_of(text: str) -> str:
    """Write JSON as a table with tabs between cells; single values become ``#`` lines.

    The table is a list of objects, or an object with its columns, as pandas writes
    them; it may be the value of a key.
    """
    import pandas as pd

    # A number keeps its digits: 15.0 is not 15.00.
    data = json.loads(
        text,
        object_pairs_hook=_object,
        parse_float=str,
        parse_int=str,
        parse_constant={"NaN": None}.get,
    )
    named = data if isinstance(data, dict) else {"runs": data}
    lines = [f"# {key}: {value}" for key, value in named.items() if _is_cell(value)]
    units = _taken_units(named)
    try:
        frame = pd.DataFrame(_table_in(named), dtype=object)
    except NoTableError:
        raise
    except (ValueError, TypeError, AttributeError):
        raise NoTableError("its columns do not have the same length") from None
    nested = [name for name in frame if not all(map(_is_cell, frame[name]))]
    if nested:
        raise NoTableError(f'"{nested[0]:.60}" contains more than one value')
    if min(len(frame), len(frame.columns) - 1) < 1:
        raise NoTableError(
            "it contains no list of objects, and no lists with the names of columns"
        )
    frame.attrs = {"units": units}
    table, _ = conversion.frame_text(frame)
    lines.append(table)
    # Half of a sign of two parts, which JSON can contain, is not a letter.
    return "\n".join(lines).encode("utf-8", "replace").decode()


def _taken_units(named: dict[str, Any]) -> dict[str, Any]:
    """Take the units of the columns out of JSON; {} if it has none."""
    if isinstance(named.get("units"), dict):
        return dict(named.pop("units"))
    return {}


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object of JSON; raise NoTableError if a key is there twice."""
    for key, times in Counter(key for key, _ in pairs).items():
        if times > 1:
            raise NoTableError(f'it contains the key "{key:.60}" twice: keep one')
    return dict(pairs)


def _is_cell(value: Any) -> bool:
    return not isinstance(value, list | dict)


def _table_in(named: dict[str, Any]) -> Any:
    """Return the records or the columns of JSON."""
    named = {key: value for key, value in named.items() if not _is_cell(value)}
    tables = [name for name, value in named.items() if _are_records(value)]
    if len(tables) > 1:
        several = ", ".join(tables[:5])
        raise NoTableError(f"it contains several tables, {several}: keep one")
    if tables:
        return named[tables[0]]
    values = list(named.values())
    if len(values) == 1 and isinstance(values[0], dict):
        return values[0]
    return named


def _are_records(value: Any) -> bool:
    """Return whether a value is a list of objects, one for each run."""
    is_list = isinstance(value, list) and bool(value)
    return is_list and all(isinstance(item, dict) for item in value)
