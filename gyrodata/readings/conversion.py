"""Write DataFrames and workbooks as text with a tab between the cells."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from typing import Any

from gyrodata.readings import workbook
from gyrodata.readings.grid import Row, find_place
from gyrodata.readings.lablog import Faults, listing

# --- DataFrames ---


def frame_text(frame: Any) -> tuple[str, frozenset[int]]:
    """Write a DataFrame as tab-separated text; return its columns of floats, too."""
    lines = []
    for key, value in frame.attrs.items():
        if not isinstance(value, Mapping | list | tuple):
            line = f"# {key}: {value_text(value)}"
            lines.append(line.replace("\n", " "))
    if any(name is not None for name in frame.index.names):
        frame = frame.reset_index(allow_duplicates=True)  # as `to_csv` writes them too
    units = frame.attrs.get("units", {})
    headers = [_header_of(column, units) for column in frame.columns]
    floats = [at for at in range(len(headers)) if _has_floats(frame.iloc[:, at])]
    rows = [headers, *frame.itertuples(index=False, name=None)]
    lines += table_lines(rows)
    return "\n".join(lines) + "\n", frozenset(floats)


def _header_of(column: Any, units: Any) -> Any:
    """Return the name of a column with its unit, of which pandas can have both."""
    name: Any = column
    unit: Any = ""
    if isinstance(column, tuple) and len(column) == 2:
        name, unit = column
    if not unit and isinstance(units, Mapping):
        unit = units.get(name)
    return f"{name} [{unit}]" if unit else name


def _has_floats(column: Iterable[Any]) -> bool:
    """Return whether a column has a float; a blank cell is NaN, which is not itself."""
    numbers = [getattr(value, "magnitude", value) for value in column]  # of pint
    floats = [number for number in numbers if isinstance(number, float)]
    return any(number == number for number in floats)


def table_lines(rows: Iterable[Iterable[Any]]) -> Iterator[str]:
    """Write rows of Python values as tab-separated lines."""
    for row in rows:
        yield "\t".join(map(quoted_text, row)).rstrip("\t")


_BLANKS = str.maketrans("\t\r\n", "   ")


def quoted_text(value: Any) -> str:
    """Return a cell as text, in quotes if it begins with one."""
    text = value_text(value).translate(_BLANKS)
    if text[:1] == '"':
        return '"' + text.replace('"', '""') + '"'
    return text


def value_text(value: Any) -> str:
    """Return a cell of a sheet or DataFrame, or a setting, as a student types it."""
    if hasattr(value, "magnitude") and hasattr(value, "units"):  # of pint
        number = value.magnitude
        text = number if isinstance(number, float) else value_text(number)
        return f"{text} {value.units:~}".rstrip()
    if hasattr(value, "nominal_value"):  # of uncertainties
        return f"{value_text(value.nominal_value)} ± {value_text(value.std_dev)}"
    if _is_missing(value):
        return ""
    kind = type(value).__name__
    if kind == "Timedelta":  # of pandas
        return f"{value.total_seconds()!r} s"
    if kind.startswith("float") and abs(value) < 1e15 and float(value).is_integer():
        value = int(value)
    return str(value)


def _is_missing(value: Any) -> bool:
    """Return whether a value is None, NaN (which is not itself), or pandas' NA."""
    kind = type(value).__name__
    return value is None or kind in ("NAType", "NaTType") or value != value


# --- Workbooks ---


def faults_of_workbook(data: bytes, shown: str) -> Faults:
    """Read a workbook as text, with its faults so far.

    Raise InputError if a formula has no value.
    """
    faults_of_file = Faults(shown)
    sheets = _sheets_of(data, faults_of_file)
    text = _text_of_sheets(sheets, faults_of_file)
    faults = Faults(shown, *text)
    hidden = "; ".join(chain.from_iterable(map(workbook.hidden_parts, sheets)))
    if hidden:
        faults.add("hidden_cells", where=hidden)
    lacking = workbook.without_value(sheets)
    if lacking:
        raise _refuse_formulas(lacking, sheets, faults)
    return faults


def _refuse_formulas(
    lacking: list[tuple[workbook.Sheet, workbook.Formula]],
    sheets: list[workbook.Sheet],
    faults: Faults,
) -> Exception:
    """Return the error about formulas without a value."""
    sheet, formula = lacking[0]
    above, _ = faults.sheets[sheets.index(sheet)]
    row = Row(above + formula.row, [])
    place = find_place(faults.lines, "\t", row.spot(formula.column - 1))
    more = ": the stored 0 is not its result" if formula.value else ""
    if others := [workbook.cell_name(*cell, within=sheet) for cell in lacking[1:]]:
        more += f" (also {listing(others)})"
    return faults.refuse("formula_without_value", place, more=more)


def workbook_text(
    data: bytes, faults: Faults
) -> tuple[str, tuple[tuple[int, str], ...]]:
    """Write the filled sheets of a workbook as tab-separated text.

    Return the line above each and its name too.
    """
    return _text_of_sheets(_sheets_of(data, faults), faults)


def sheet_rows(data: bytes) -> dict[str, list[list[Any]]]:
    """Return the rows of each sheet of a workbook, with cells as they were typed.

    ValueError if it cannot be read.
    """
    return {sheet.title: sheet.rows for sheet in workbook.read_sheets(data)}


def _sheets_of(data: bytes, faults: Faults) -> list[workbook.Sheet]:
    """Return the filled sheets of a workbook."""
    try:
        sheets = workbook.read_sheets(data)
    except workbook.TooLargeError as error:
        raise faults.refuse("workbook_too_large", why=str(error)) from None
    except ValueError as error:
        raise faults.refuse("workbook", why=str(error)) from None
    return list(filter(workbook.is_filled, sheets))


def _text_of_sheets(
    sheets: list[workbook.Sheet], faults: Faults
) -> tuple[str, tuple[tuple[int, str], ...]]:
    """Write sheets as tab-separated text; return the line above each and its name."""
    if not sheets:
        raise faults.refuse("workbook_empty")
    lines: list[str] = []
    places = []
    for sheet in sheets:
        if len(sheets) > 1:
            lines.append(f"sheet {sheet.title}")  # a title of what is on the sheet
        places.append((len(lines), workbook.quoted(sheet.title)))
        lines += "\n".join(table_lines(sheet.rows)).rstrip("\n").split("\n")
    return "\n".join(lines) + "\n", tuple(places)
