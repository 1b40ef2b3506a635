"""Read the sheets of a workbook (.xlsx).

The result contains cells as they were typed, hidden rows, and formulas without a value.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Collection, Iterable, Iterator
from datetime import datetime, time, timedelta
from itertools import chain
from typing import Any
from xml.etree import ElementTree

from msgspec import Struct

from gyrodata.readings.lablog import listing

MAX_ROWS = 100_000
MAX_COLUMNS = 200
MAX_CELLS = 200_000
MAX_TEXT = 10_000_000
"""Characters in all cells of a workbook."""
_ROWS = MAX_ROWS + 10
_COLUMNS = MAX_COLUMNS + 10
"""Rows and columns that are read: so a file over the limits is refused, and one far
cell is not."""
_MAX_UNPACKED = 100_000_000
_MAX_SHEETS = 100
_MAX_SHEET_BYTES = 10_000_000
_MAX_STRING_BYTES = 1_000_000
_MAX_STYLE_BYTES = 400_000
"""Bytes that openpyxl reads in two or three seconds."""
_TAGS_OF_A_CELL = 8
_MAX_OTHER_TAGS = 100_000
_SMALL_PARTS = frozenset(
    (
        "[Content_Types].xml",
        "xl/styles.xml",
        "xl/workbook.xml",
        "docProps/core.xml",
        "docProps/custom.xml",
    )
)
"""Parts of a workbook that are no sheets and no strings."""
_FIRST_YEAR = 1900
"""Year of the smallest numbers that are shown as dates."""
_SMALLEST_LETTERS = 4
"""Height of letters that nobody reads [points]."""


class TooLargeError(ValueError):
    """A workbook is over a limit; its text says which."""


class Formula(Struct, frozen=True):
    """A formula in a cell."""

    row: int
    column: int
    text: str
    value: str | None
    """Stored value; None if there is none."""

    @property
    def is_zero(self) -> bool:
        """Whether the stored value is 0, or a blank text that is not a result."""
        if not (self.value or "").strip():
            return '"' not in self.text
        try:
            return float(self.value or "") == 0
        except ValueError:
            return False


class Sheet(Struct):
    """One sheet of a workbook."""

    title: str
    rows: list[list[Any]]
    """Its cells; a row that is struck out begins with #."""
    is_hidden: bool = False
    hidden_rows: list[int] = []
    """Numbers of the hidden rows; they count from 1."""
    hidden_columns: list[int] = []
    """Numbers of the hidden columns; they count from 1."""
    formulas: list[Formula] = []
    blanked: set[tuple[int, int]] = set()
    """Row and column of each cell whose format or font shows nothing of it."""


def read_sheets(data: bytes) -> list[Sheet]:
    """Return the sheets of a workbook.

    Raises
    ------
    TooLargeError
        The workbook is over a limit.
    ValueError
        The workbook cannot be read.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(member.file_size for member in archive.infolist()) > _MAX_UNPACKED:
                raise TooLargeError("it unpacks to more than 100 MB")
            if "xl/workbook.xml" not in archive.namelist():
                raise ValueError("it is no .xlsx workbook")
            sheets = _read_archive(data, archive)
    except TooLargeError:
        raise
    except Exception as error:  # a damaged file can fail in any way inside openpyxl
        raise ValueError(f"{type(error).__name__}: {error}") from None
    rows = chain.from_iterable(sheet.rows for sheet in sheets)
    _check_size(chain.from_iterable(rows))
    return sheets


def _read_archive(data: bytes, archive: zipfile.ZipFile) -> list[Sheet]:
    from openpyxl.reader.excel import ExcelReader
    from openpyxl.xml.constants import SHARED_STRINGS

    for part in archive.namelist():
        if part in _SMALL_PARTS or part.endswith(".rels"):
            _check_part(archive, part, _MAX_STYLE_BYTES)
    reader = ExcelReader(
        io.BytesIO(data), read_only=True, data_only=True, keep_links=False
    )
    reader.read_manifest()
    strings = reader.package.find(SHARED_STRINGS)
    if strings is not None:
        _check_part(archive, strings.PartName[1:], _MAX_STRING_BYTES)
    reader.read_workbook()
    parts = {
        sheet.name: relation.target for sheet, relation in reader.parser.find_sheets()
    }
    _check_sheets(archive, parts.values())
    reader.read()
    sheets = [_sheet_of(sheet) for sheet in reader.wb.worksheets]
    for sheet in sheets:
        text = archive.read(parts[sheet.title])
        if b"hidden" in text or re.search(rb"<(?:\w+:)?f[\s/>]", text):
            _scan(text, sheet)
    return sheets


# --- Hidden rows and columns ---


def without_value(sheets: list[Sheet]) -> list[tuple[Sheet, Formula]]:
    """Return the formulas whose values were not calculated.

    A program that calculates nothing stores no value, or a 0 for all formulas.
    """
    formulas: list[tuple[Sheet, Formula]] = []
    for sheet in sheets:
        for formula in sheet.formulas:
            row = sheet.rows[formula.row - 1]
            if row[:1] != ["#"]:
                formulas.append((sheet, formula))
    if formulas and all(formula.is_zero for _, formula in formulas):
        return formulas
    return [(sheet, each) for sheet, each in formulas if each.value is None]


def is_filled(sheet: Sheet) -> bool:
    """Return whether a sheet contains a cell that is not blank."""
    return any(map(_fills, chain.from_iterable(sheet.rows)))


def hidden_parts(sheet: Sheet) -> Iterator[str]:
    """Name the hidden rows and columns of a sheet with cells, or the sheet itself."""
    if sheet.is_hidden:
        yield f"the sheet {quoted(sheet.title)}"
    hidden = [row for row in sheet.hidden_rows if any(sheet.rows[row - 1 : row])]
    rows = list(map(str, hidden))
    filled = {column for _, column in _filled_cells(sheet)}
    columns = [_letters(column) for column in sheet.hidden_columns if column in filled]
    for word, names in (("row", rows), ("column", columns)):
        if names:
            word += "s" * (len(names) > 1)
            yield f"{word} {listing(names)} of the sheet {quoted(sheet.title)}"


def unseen_cells(sheet: Sheet) -> set[tuple[int, int]]:
    """Return the row and the column of each filled cell that is not shown."""
    rows = set(sheet.hidden_rows)
    columns = set(sheet.hidden_columns)
    filled = set(_filled_cells(sheet))
    hidden = {
        (row, column) for row, column in filled if row in rows or column in columns
    }
    return hidden | filled.intersection(sheet.blanked)


def _filled_cells(sheet: Sheet) -> Iterator[tuple[int, int]]:
    """Yield the row and the column of each filled cell."""
    for row, cells in enumerate(sheet.rows, 1):
        for column, cell in enumerate(cells, 1):
            if _fills(cell):
                yield row, column


def _fills(cell: Any) -> bool:
    return cell not in (None, "")


def _letters(column: int) -> str:
    """Return the letters of a column."""
    from openpyxl.utils import get_column_letter

    return str(get_column_letter(column))


def quoted(title: str) -> str:
    """Return the name of a sheet as a spreadsheet program writes it in a formula."""
    if title.isalnum():
        return title
    return f"'{title}'"


def cell_name(sheet: Sheet, formula: Formula, within: Sheet) -> str:
    """Return the name of a cell, such as B5; with its sheet if this is not `within`."""
    name = f"{_letters(formula.column)}{formula.row}"
    if sheet is within:
        return name
    return f"{quoted(sheet.title)}!{name}"


# --- Limits ---


def _check_size(cells: Iterable[Any]) -> None:
    """Raise TooLargeError if there are too many filled cells, or too much text."""
    filled = list(filter(_fills, cells))
    if len(filled) > MAX_CELLS:
        raise TooLargeError(f"more than {MAX_CELLS:_} filled cells".replace("_", " "))
    if sum(len(cell) for cell in filled if isinstance(cell, str)) > MAX_TEXT:
        raise TooLargeError("more than 10 MB of text")


def _check_part(archive: zipfile.ZipFile, part: str, most: int) -> None:
    """Raise TooLargeError if a part of a workbook unpacks to more bytes than are read.

    A part may be missing.
    """
    if part in archive.namelist() and archive.getinfo(part).file_size > most:
        size = archive.getinfo(part).file_size / 1e6
        raise TooLargeError(
            f"its part {part} unpacks to {size:.1f} MB; "
            f"at most {most / 1e6:g} MB are read"
        )


def _check_sheets(archive: zipfile.ZipFile, parts: Collection[str]) -> None:
    """Raise TooLargeError if the sheets contain more than can be read in seconds."""
    if len(parts) > _MAX_SHEETS:
        raise TooLargeError(f"{len(parts)} sheets; at most {_MAX_SHEETS} are read")
    cells = tags = size = 0
    for part in parts:
        _check_part(archive, part, _MAX_SHEET_BYTES)
        text = archive.read(part) if part in archive.namelist() else b""
        size += len(text)
        cells += len(re.findall(rb"<(?:\w+:)?c[\s/>]", text))
        tags += text.count(b"<")
        has_many_tags = tags > _TAGS_OF_A_CELL * cells + _MAX_OTHER_TAGS
        if size > _MAX_SHEET_BYTES or cells > MAX_CELLS or has_many_tags:
            raise TooLargeError(
                "its sheets are too large; at most 200 000 cells and 10 MB are read"
            )


# --- Cells as they were typed ---


def _sheet_of(sheet: Any) -> Sheet:
    """Return a sheet of openpyxl, with cells as they were typed."""
    # One stray cell at the far corner makes a sheet of 17 thousand million cells.
    rows = list(sheet.iter_rows(max_row=_ROWS, max_col=_COLUMNS))
    values = [cell.value for cell in chain.from_iterable(rows)]
    times = [value for value in values if isinstance(value, time)]
    in_minutes = bool(times) and all(map(_is_in_minutes, times))
    typed = [_typed(row, in_minutes) for row in rows]
    is_hidden = sheet.sheet_state != "visible"
    return Sheet(sheet.title, typed, is_hidden=is_hidden, blanked=_blanked(rows))


def _is_in_minutes(typed: time) -> bool:
    """Return whether a time may be minutes and seconds.

    Of 0:21, minutes and seconds, Excel makes 21 minutes past midnight.
    """
    return typed.hour < 4 and not typed.second and not typed.microsecond


def _blanked(rows: list[Any]) -> set[tuple[int, int]]:
    """Return the row and the column of each filled cell that shows nothing."""
    blanked = set()
    for row, cells in enumerate(rows, 1):
        for column, cell in enumerate(cells, 1):
            if cell.value is not None and cell.has_style and _shows_nothing(cell):
                blanked.add((row, column))
    return blanked


def _shows_nothing(cell: Any) -> bool:
    """Return whether a cell has a blank format, or white or tiny letters."""
    # "positive;negative;zero;text"
    signs = re.sub(r'"[^"]*"|\\.|\[[^\[\]]*\]', "", cell.number_format)
    sections = signs.split(";")
    section = 3 if isinstance(cell.value, str) else 0
    shown = sections[section] if section < len(sections) else "@"
    if not any(sign.isalnum() or sign in "_#?@" for sign in shown):
        return True
    is_tiny = (cell.font.sz or 11) <= _SMALLEST_LETTERS
    return is_tiny or (cell.fill.fill_type is None and _is_white(cell.font.color))


def _is_white(color: Any) -> bool:
    """Return whether letters are white; None is the usual color."""
    if color is None:
        return False
    is_first_of_theme = color.type == "theme" and not color.theme
    return is_first_of_theme or color.rgb == "FFFFFFFF"


def _typed(row: Iterable[Any], in_minutes: bool) -> list[Any]:
    """Return the cells of a row as they were typed; a struck-out row begins with #."""
    cells = list(row)
    while cells and cells[-1].value is None:
        cells.pop()
    filled = [cell for cell in cells if cell.value is not None]
    values = [_value_as_typed(cell, in_minutes) for cell in cells]
    is_struck_out = bool(filled) and all(cell.font.strike for cell in filled)
    if is_struck_out:
        return ["#", *values]
    return values


def _value_as_typed(cell: Any, in_minutes: bool) -> Any:
    value = cell.value
    if type(value) in (int, float):
        return _number_as_typed(value, cell.number_format or "")
    if isinstance(value, time) and value.hour and not in_minutes:
        # "3:36" typed: three hours, or three minutes?
        return f"{value:%H:%M:%S} (a time of the day)"
    if isinstance(value, time):
        # Excel stores 03:36.26 as a time of the day.
        value = datetime.combine(datetime.min, value) - datetime.min
    if isinstance(value, timedelta):
        return _duration_as_typed(value, in_minutes)
    if isinstance(value, datetime) and value.year == _FIRST_YEAR:
        return _number_below_date(value, cell.number_format)
    return value


def _number_below_date(value: datetime, number_format: str) -> float | str:
    """Return the number in a cell that has the format of a date or a time.

    Excel counts days from 1900: in a cell in which it has made a date of 1/3, a 3 that
    is typed later is shown as the 3rd of January.
    """
    from openpyxl.utils.datetime import to_excel

    number: float = round(to_excel(value), 6)
    # 24:00 may be minutes and seconds.
    return f"({number:g} below a time)" if "h" in number_format else number


def _number_as_typed(value: float, number_format: str) -> float | str:
    """Return a number with the digits that its format shows: 15.0 is stored as 15.

    Digits that the sheet does not show were typed too.
    """
    decimals = number_format.removeprefix("0.")
    if decimals == number_format or decimals.strip("0"):
        return value
    text = f"{value:.{len(decimals)}f}"
    if float(text) == value:
        return text
    return value


def _duration_as_typed(duration: timedelta, in_minutes: bool) -> str:
    minutes, seconds = divmod(duration.total_seconds(), 60)
    if in_minutes:
        hours, minutes = divmod(int(minutes), 60)
        return f"{hours}:{minutes:02d}"
    return f"{int(minutes):02d}:{seconds:05.2f}"


# --- What openpyxl does not report if it reads only values ---


def _scan(text: bytes, sheet: Sheet) -> None:
    """Add the hidden rows and columns and the formulas of a sheet."""
    from openpyxl.utils.cell import coordinate_to_tuple

    row = column = 0
    for event, element in ElementTree.iterparse(io.BytesIO(text), ("start", "end")):
        name = element.tag.rpartition("}")[2]
        if event == "start" and name == "row":
            row = int(element.get("r", row + 1))
            column = 0
            sheet.hidden_rows += [row] if _is_hidden(element) else []
        elif event == "start" and name == "col" and _is_hidden(element):
            first = int(element.get("min", "1"))
            last = min(int(element.get("max", "0")), _COLUMNS)
            sheet.hidden_columns += range(first, last + 1)
        elif event == "end" and name == "c":
            # Some programs do not name the cells.
            place = element.get("r")
            row, column = coordinate_to_tuple(place) if place else (row, column + 1)
            _add_formula(sheet, row, column, element)
            element.clear()


def _stored_value(part: ElementTree.Element | None, kind: str) -> str | None:
    """Return the stored value of a formula; None if there is none."""
    if part is None:
        return None
    if kind == "b" and part.text == "0":
        return "FALSE"  # no 0
    return part.text or ("" if kind == "str" else None)


def _is_hidden(element: ElementTree.Element) -> bool:
    return element.get("hidden") in ("1", "true")


def _add_formula(
    sheet: Sheet, row: int, column: int, cell: ElementTree.Element
) -> None:
    """Add the formula of a cell; write it into a blank cell."""
    parts = {part.tag.rpartition("}")[2]: part for part in cell}
    if "f" not in parts or row > _ROWS or column > _COLUMNS:
        return
    value = _stored_value(parts.get("v"), cell.get("t", "n"))
    text = (parts["f"].text or "").lstrip("= ")
    formula = Formula(row, column, f"={text}", value)
    sheet.formulas.append(formula)
    while len(sheet.rows) < row:
        sheet.rows.append([])
    cells = sheet.rows[row - 1]
    cells += [None] * (column - len(cells))
    if value is None and cells[0] != "#":
        cells[column - 1] = formula.text
