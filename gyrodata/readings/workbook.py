"""Read the sheets of a workbook, .xlsx or .ods.

The result contains cells as they were typed, hidden rows, and formulas without a value.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable, Iterable, Iterator
from datetime import datetime, time, timedelta
from typing import Any
from xml.etree import ElementTree

from msgspec import Struct, field

from gyrodata.readings import formulas
from gyrodata.readings.formulas import Content, Formula
from gyrodata.readings.lablog import listing

MAX_ROWS = 100_000
MAX_COLUMNS = 200
MAX_CELLS = 200_000
"""Filled cells of a workbook, each as often as it is repeated."""
MAX_TEXT = 10 * 1000 * 1000
"""Characters in all cells of a workbook."""
_ROWS, _COLUMNS = MAX_ROWS + 10, MAX_COLUMNS + 10
"""Rows and columns that are read: so a file over the limits is refused, and one far
cell is not."""
_MAX_UNPACKED = 100 * 1000 * 1000
_MAX_SHEETS = 100
_MAX_SHEET_BYTES = 10 * 1000 * 1000
_MAX_STRING_BYTES = 1000 * 1000
_MAX_STYLE_BYTES = 400 * 1000
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
"""Parts of an .xlsx workbook that are no sheets and no strings."""


class TooLargeError(ValueError):
    """A workbook is over a limit; its text says which."""


class Sheet(Struct):
    """One sheet of a workbook."""

    title: str
    rows: list[list[Any]]
    """Its cells; a row that is struck out begins with #."""
    is_hidden: bool = False
    hidden_rows: list[int] = field(default_factory=list)
    """Numbers of the hidden rows; they count from 1."""
    hidden_columns: list[int] = field(default_factory=list)
    """Numbers of the hidden columns; they count from 1."""
    without_value: dict[tuple[int, int], Formula] = field(default_factory=dict)
    """Each formula whose value was not calculated, by its row and column."""
    blanked: set[tuple[int, int]] = field(default_factory=set)
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
            is_excel = "xl/workbook.xml" in archive.namelist()
            sheets = (
                _excel_sheets(data, archive)
                if is_excel
                else _opendocument_sheets(archive)
            )
    except TooLargeError:
        raise
    except (
        Exception
    ) as error:  # a damaged workbook can fail in any way inside the libraries
        raise ValueError(f"{type(error).__name__}: {error}") from None
    _check_size(cell for sheet in sheets for row in sheet.rows for cell in row)
    return sheets


def write_formulas(sheet: Sheet) -> None:
    """Write each formula without a value into its cell.

    Forget those of rows that are taken out with #.
    """
    for row, column in list(sheet.without_value):
        while len(sheet.rows) < row:
            sheet.rows.append([])
        cells = list(sheet.rows[row - 1])
        if cells[:1] == ["#"]:
            del sheet.without_value[row, column]
            continue
        cells += [None] * (column - len(cells))
        cells[column - 1] = sheet.without_value[row, column].text
        sheet.rows[row - 1] = cells


def is_filled(sheet: Sheet) -> bool:
    """Return whether a sheet contains a cell that is not blank."""
    return any(cell not in (None, "") for row in sheet.rows for cell in row)


def hidden_parts(sheet: Sheet) -> Iterator[str]:
    """Name the hidden rows and columns of a sheet that contain something, or the sheet itself."""
    if sheet.is_hidden:
        yield f"the sheet {quoted(sheet.title)}"
    rows = [row for row in sheet.hidden_rows if any(sheet.rows[row - 1 : row])]
    filled = _filled_columns(sheet)
    columns = [column for column in sheet.hidden_columns if column in filled]
    for word, numbers, name in (("row", rows, str), ("column", columns, _letters)):
        if numbers:
            what = f"{_count_of(word, len(numbers))} {_spans(numbers, name)}"
            yield f"{what} of the sheet {quoted(sheet.title)}"


def _filled_columns(sheet: Sheet) -> set[int]:
    return {
        column
        for row in sheet.rows
        for column, cell in enumerate(row, 1)
        if cell not in (None, "")
    }


def unseen_cells(sheet: Sheet) -> set[tuple[int, int]]:
    """Return the row and the column of each filled cell that is not shown."""
    rows, columns = set(sheet.hidden_rows), set(sheet.hidden_columns)
    return {
        (row, column)
        for row, cells in enumerate(sheet.rows, 1)
        for column, cell in enumerate(cells, 1)
        if cell not in (None, "")
        and (row in rows or column in columns or (row, column) in sheet.blanked)
    }


def _count_of(word: str, count: int) -> str:
    """Return "row", "rows" or, if there are many, "40 rows"."""
    if count == 1:
        return word
    return f"{word}s" if count <= 12 else f"{count} {word}s"


def _spans(numbers: list[int], name: Callable[[int], str]) -> str:
    """Return numbers in short form: ``3-5, 7``."""
    spans: list[tuple[int, int]] = []
    for number in numbers:
        if spans and spans[-1][1] == number - 1:
            spans[-1] = spans[-1][0], number
        else:
            spans.append((number, number))
    return listing(
        [
            name(first) if first == last else f"{name(first)}-{name(last)}"
            for first, last in spans
        ]
    )


def _letters(column: int) -> str:
    """Return the letters of a column."""
    from openpyxl.utils import get_column_letter

    return str(get_column_letter(column))


def quoted(title: str) -> str:
    """Return the name of a sheet as a spreadsheet program writes it in a formula."""
    return title if title.isalnum() else f"'{title}'"


def cell_name(sheet: Sheet, row: int, column: int, within: Sheet) -> str:
    """Return the name of a cell, such as B5; with its sheet, if this is not `within`."""
    name = f"{_letters(column)}{row}"
    return name if sheet is within else f"{quoted(sheet.title)}!{name}"


def _check_size(cells: Iterable[Any]) -> None:
    """Raise TooLargeError if there are too many filled cells, or if these contain too much text."""
    filled = [cell for cell in cells if cell not in (None, "")]
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
            f"its part {part} unpacks to {size:.1f} MB; at most {most / 1e6:g} MB are read"
        )


def _add_values(sheets: list[Sheet], content: Content) -> None:
    """Give each sheet its formulas without a value."""
    by_title = {sheet.title: sheet for sheet in sheets}
    for formula, height, width in content.arrays:
        _spread(formula, height, width, len(by_title[formula.cell[0]].rows), content)
    lacking = formulas.without_value(content)
    for cell in sorted(lacking):
        title, row, column = cell
        if row <= _ROWS and column <= _COLUMNS:
            by_title[title].without_value[row, column] = lacking[cell]


def _spread(
    formula: Formula, height: int, width: int, last_row: int, content: Content
) -> None:
    """Add the formula of an area to each of its cells, in rows with content.

    The file contains the formula only in the first cell.
    """
    title, top, left = formula.cell
    for row in range(top, min(top + height - 1, max(top, last_row)) + 1):
        for column in range(left, min(left + width - 1, _COLUMNS) + 1):
            cell = (title, row, column)
            value = (
                str(content.numbers[cell] or "0") if cell in content.numbers else None
            )
            if cell not in content.numbers or content.numbers[cell] == 0:
                content.formulas.append(Formula(cell, f"{{{formula.text}}}", value))


# --- Excel ---


def _excel_sheets(data: bytes, archive: zipfile.ZipFile) -> list[Sheet]:
    """Return the sheets of an .xlsx workbook."""
    from openpyxl.reader.excel import ExcelReader
    from openpyxl.xml.constants import SHARED_STRINGS

    _check_parts(archive)
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
    _check_sheets(archive, list(parts.values()))
    reader.read()
    book = reader.wb
    sheets = [_excel_sheet(sheet) for sheet in book.worksheets]
    texts = {sheet.title: archive.read(parts[sheet.title]) for sheet in sheets}
    has_formulas = any(
        re.search(rb"<(?:\w+:)?f[\s/>]", text) for text in texts.values()
    )
    content = Content(to_calculate=_asks_to_calculate(archive.read("xl/workbook.xml")))
    for sheet in sheets:
        if has_formulas or b"hidden" in texts[sheet.title]:
            _scan(texts[sheet.title], sheet, content)
    _add_values(sheets, content)
    return sheets


def _check_parts(archive: zipfile.ZipFile) -> None:
    """Raise TooLargeError if openpyxl would need long for a part that is no sheet."""
    for part in archive.namelist():
        if part in _SMALL_PARTS or part.endswith(".rels"):
            _check_part(archive, part, _MAX_STYLE_BYTES)


def _asks_to_calculate(text: bytes) -> bool:
    """Return whether a workbook says that its formulas have to be calculated when it is opened."""
    settings = (
        part
        for part in ElementTree.fromstring(text).iter()
        if part.tag.endswith("}calcPr")
    )
    return any(_is_true(one.get("fullCalcOnLoad")) for one in settings)


def _check_sheets(archive: zipfile.ZipFile, parts: list[str]) -> None:
    """Raise TooLargeError if the sheets contain more than can be read in some seconds."""
    if len(parts) > _MAX_SHEETS:
        raise TooLargeError(f"{len(parts)} sheets; at most {_MAX_SHEETS} are read")
    cells = tags = size = 0
    for part in parts:
        _check_part(archive, part, _MAX_SHEET_BYTES)
        text = archive.read(part) if part in archive.namelist() else b""
        size += len(text)
        cells += len(re.findall(rb"<(?:\w+:)?c[\s/>]", text))
        tags += text.count(b"<")
        if (
            size > _MAX_SHEET_BYTES
            or cells > MAX_CELLS
            or tags > _TAGS_OF_A_CELL * cells + _MAX_OTHER_TAGS
        ):
            most = f"{MAX_CELLS:_} cells".replace("_", " ")
            raise TooLargeError(
                f"its sheets are too large; at most {most} and "
                f"{_MAX_SHEET_BYTES / 1e6:g} MB are read"
            )


def _excel_sheet(sheet: Any) -> Sheet:
    """Return a sheet of openpyxl, with cells as they were typed."""
    # One stray cell at the far corner makes a sheet of 17 thousand million cells.
    rows = list(sheet.iter_rows(max_row=_ROWS, max_col=_COLUMNS))
    values = [cell.value for row in rows for cell in row]
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
    return {
        (row, column)
        for row, cells in enumerate(rows, 1)
        for column, cell in enumerate(cells, 1)
        if cell.value is not None and _shows_nothing(cell)
    }


_SMALLEST = 4
"""Height of letters that nobody reads [points]."""


def _shows_nothing(cell: Any) -> bool:
    """Return whether a cell has a blank format, or white or tiny letters."""
    if not cell.has_style:
        return False
    # "positive;negative;zero;text"
    sections = re.sub(r'"[^"]*"|\\.|\[[^\[\]]*\]', "", cell.number_format).split(";")
    section = 3 if isinstance(cell.value, str) else 0
    if len(sections) > section and not re.search(r"[\w#?@]", sections[section]):
        return True
    font = cell.font
    is_white = font.color is not None and (
        font.color.rgb == "FFFFFFFF"
        or (font.color.type == "theme" and not font.color.theme)
    )
    return (is_white and cell.fill.fill_type is None) or (font.sz or 11) <= _SMALLEST


def _typed(row: Iterable[Any], in_minutes: bool) -> list[Any]:
    """Return the cells of a row as they were typed; a row that is struck out begins with #."""
    cells = list(row)
    while cells and cells[-1].value is None:
        cells.pop()
    filled = [cell for cell in cells if cell.value is not None]
    values = [_value_as_typed(cell, in_minutes) for cell in cells]
    is_struck_out = bool(filled) and all(cell.font.strike for cell in filled)
    return ["#", *values] if is_struck_out else values


def _value_as_typed(cell: Any, in_minutes: bool) -> Any:
    value = cell.value
    if type(value) in (int, float):
        return _number_as_typed(value, cell.number_format or "")
    if isinstance(value, time) and value.hour and not in_minutes:
        # "3:36" typed: three hours, or three minutes?
        return f"{value:%H:%M:%S} (a time of the day)"
    if isinstance(value, time):
        # Excel stores 03:36.26 as a time of the day.
        day = datetime.combine(datetime.min, value)
        return _duration_as_typed(day - datetime.min, in_minutes)
    if isinstance(value, timedelta):
        return _duration_as_typed(value, in_minutes)
    return value


def _number_as_typed(value: float, number_format: str) -> float | str:
    """Return a number with the digits that its format shows: 15.0 is stored as 15.

    Digits that the sheet does not show were typed too.
    """
    shown = re.fullmatch(r"0\.(0+)", number_format)
    text = f"{value:.{len(shown[1])}f}" if shown else ""
    return text if shown and float(text) == value else value


def _duration_as_typed(duration: timedelta, in_minutes: bool) -> str:
    minutes, seconds = divmod(duration.total_seconds(), 60)
    if in_minutes:
        hours, minutes = divmod(int(minutes), 60)
        return f"{hours}:{minutes:02d}"
    return f"{int(minutes):02d}:{seconds:05.2f}"


def _scan(text: bytes, sheet: Sheet, content: Content) -> None:
    """Add the hidden rows and columns and the formulas of a sheet.

    openpyxl does not report them if it reads only values.
    """
    row = column = 0
    masters: dict[str, tuple[str, str]] = {}
    for event, element in ElementTree.iterparse(io.BytesIO(text), ("start", "end")):
        name = element.tag.rpartition("}")[2]
        if event == "start" and name == "row":
            row, column = int(element.get("r", row + 1)), 0
            sheet.hidden_rows += [row] if _is_true(element.get("hidden")) else []
        elif event == "start" and name == "col":
            sheet.hidden_columns += _hidden_columns(element)
        elif event == "end" and name == "c":
            row, column = _position(element.get("r"), row, column + 1)
            _add_cell((sheet.title, row, column), element, content, masters)
            element.clear()
        elif event == "end" and name == "row":
            element.clear()


def _hidden_columns(element: ElementTree.Element) -> range:
    """Return the numbers of the columns that an element hides."""
    if not _is_true(element.get("hidden")):
        return range(0)
    last = min(int(element.get("max", "0")), _COLUMNS)
    return range(int(element.get("min", "1")), last + 1)


def _is_true(text: str | None) -> bool:
    return text in ("1", "true")


def _position(reference: str | None, row: int, column: int) -> tuple[int, int]:
    """Return the row and the column of a cell; some programs do not write them."""
    from openpyxl.utils.cell import coordinate_to_tuple

    return coordinate_to_tuple(reference) if reference else (row, column)


def _add_cell(
    cell: formulas.Cell,
    element: ElementTree.Element,
    content: Content,
    masters: dict[str, tuple[str, str]],
) -> None:
    """Add the number and the formula of a cell.

    `masters` has the first cell of each shared formula.
    """
    parts = {part.tag.rpartition("}")[2]: part for part in element}
    kind, value = element.get("t", "n"), _value_in(element)
    if value is not None or "is" in parts:
        content.numbers[cell] = _as_number(value) if kind == "n" else None
    if "f" not in parts:
        return
    value = "FALSE" if kind == "b" and value == "0" else value
    text = _text_of(parts["f"], element.get("r", ""), masters)
    formula = Formula(cell, text, value)
    area = parts["f"].get("ref")
    if area and parts["f"].get("t") in ("array", "dataTable"):
        content.arrays.append((formula, *_size_of(area)))
    else:
        content.formulas.append(formula)


def _value_in(cell: ElementTree.Element) -> str | None:
    """Return the stored value of a cell; None if there is none."""
    for part in cell:
        if part.tag.rpartition("}")[2] == "v":
            # The text of a formula can be blank.
            return part.text or ("" if cell.get("t") == "str" else None)
    return None


def _text_of(
    element: ElementTree.Element, reference: str, masters: dict[str, tuple[str, str]]
) -> str:
    """Return the text of a formula; of a shared one, only its first cell contains it."""
    # Some programs write the sign = too.
    text, group = "=" + (element.text or "").lstrip("= "), element.get("si", "")
    if element.get("t") == "shared" and element.text:
        masters[group] = text, reference
    elif element.get("t") == "shared" and group in masters:
        return _translated(*masters[group], reference)
    return text


def _size_of(area: str) -> tuple[int, int]:
    """Return the number of rows and of columns of an area, such as B5:B12."""
    from openpyxl.utils import range_boundaries

    left, top, right, bottom = range_boundaries(area)
    return bottom - top + 1, right - left + 1


def _translated(text: str, origin: str, to: str) -> str:
    """Return a shared formula as it reads in another cell."""
    from openpyxl.formula.tokenizer import TokenizerError
    from openpyxl.formula.translate import Translator, TranslatorError

    if not origin or not to or len(text) > formulas.MAX_TEXT:
        return text
    try:
        return str(Translator(text, origin).translate_formula(to))
    except (TokenizerError, TranslatorError, IndexError, ValueError):
        return text


def _as_number(text: str | None) -> float | None:
    try:
        return float(text or "")
    except ValueError:
        return None


# --- OpenDocument ---


def _name(space: str, name: str) -> str:
    """Return the name of an element or an attribute in the files of LibreOffice."""
    return f"{{urn:oasis:names:tc:opendocument:xmlns:{space}:1.0}}{name}"


_TABLE, _ROW = _name("table", "table"), _name("table", "table-row")
_COLUMN, _PARAGRAPH = _name("table", "table-column"), _name("text", "p")
_REPEATED = _name("table", "number-columns-repeated")
_ROWS_REPEATED = _name("table", "number-rows-repeated")


def _opendocument_sheets(archive: zipfile.ZipFile) -> list[Sheet]:
    """Return the sheets of an .ods workbook."""
    _check_part(archive, "content.xml", _MAX_SHEET_BYTES)
    text = archive.read("content.xml")
    if b"<!DOCTYPE" in text:
        raise ValueError("it declares entities")
    root = ElementTree.fromstring(text)
    invisible = {
        style.get(_name("style", "name"))
        for style in root.iter(_name("style", "style"))
        for properties in style.iter(_name("style", "table-properties"))
        if properties.get(_name("table", "display")) == "false"
    }
    content, left = Content(), MAX_CELLS
    sheets: list[Sheet] = []
    for table in root.iter(_TABLE):
        sheet = Sheet(table.get(_name("table", "name"), ""), [])
        sheet.is_hidden = table.get(_name("table", "style-name")) in invisible
        left = _add_rows(table, sheet, content, left)
        sheets.append(sheet)
    _add_values(sheets, content)
    return sheets


def _add_rows(
    table: ElementTree.Element, sheet: Sheet, content: Content, left: int
) -> int:
    """Add the rows of a table to a sheet.

    Return how many more filled cells may be in the workbook.
    """
    column = 1
    for element in table.iter(_COLUMN):
        end = min(column + int(element.get(_REPEATED, "1")), _COLUMNS + 1)
        sheet.hidden_columns += range(column, end) if _is_collapsed(element) else ()
        column = end
    for element in table.iter(_ROW):
        cells = _cells_of_row(element, sheet.title, len(sheet.rows) + 1, content)
        # A sheet ends with a million blank rows, each with a thousand blank cells.
        filled = sum(cell != "" for cell in cells)
        times = min(int(element.get(_ROWS_REPEATED, "1")), _ROWS - len(sheet.rows))
        left -= filled * times
        if left < 0:
            raise TooLargeError(
                f"more than {MAX_CELLS:_} filled cells, many of them copies".replace(
                    "_", " "
                )
            )
        if _is_collapsed(element) and filled:
            sheet.hidden_rows += range(len(sheet.rows) + 1, len(sheet.rows) + times + 1)
        sheet.rows += [cells if filled else []] * times
    return left


def _is_collapsed(element: ElementTree.Element) -> bool:
    """Return whether a row or a column is hidden, by hand or by a filter."""
    return element.get(_name("table", "visibility")) in ("collapse", "filter")


def _cells_of_row(
    element: ElementTree.Element, title: str, row: int, content: Content
) -> list[str]:
    """Return the texts of a row; add its numbers and formulas to the content of the workbook."""
    cells: list[str] = []
    for cell in element:
        shown = _shown(cell)
        # One element can mean "this cell 16,384 times".
        times = min(int(cell.get(_REPEATED, "1")), _COLUMNS - len(cells))
        for column in range(len(cells) + 1, len(cells) + times + 1):
            _add_opendocument_cell((title, row, column), cell, shown, content)
        cells += [shown] * times
    return cells


def _shown(cell: ElementTree.Element) -> str:
    """Return the text of a cell.

    A number is the text that the sheet shows, if this contains all its digits.
    """
    # The paragraphs of a remark are inside of another element.
    shown = " ".join("".join(part.itertext()) for part in cell.findall(_PARAGRAPH))
    number = cell.get(_name("office", "value"), "")
    if cell.get(_name("office", "value-type")) != "float" or not number:
        return shown
    shown = shown.replace(",", ".")
    is_plain = re.fullmatch(r"-?[0-9]++\.?[0-9]*", shown)
    return shown if is_plain and float(shown) == float(number) else number


def _add_opendocument_cell(
    cell: formulas.Cell, element: ElementTree.Element, shown: str, content: Content
) -> None:
    """Add the number and the formula of a cell."""
    kind, number = (
        element.get(_name("office", "value-type")),
        element.get(_name("office", "value")),
    )
    if number or shown:
        content.numbers[cell] = _as_number(number)
    formula = element.get(_name("table", "formula"))
    if formula is None:
        return
    # A formula can have a blank text as its value.
    value = (
        (number or shown or None)
        if kind in (None, "float", "percentage", "currency")
        else shown
    )
    height, width = (
        int(element.get(_name("table", f"number-matrix-{side}-spanned"), "1"))
        for side in ("rows", "columns")
    )
    if height * width > 1:
        content.arrays.append(
            (Formula(cell, _usual_formula(formula), value), height, width)
        )
    else:
        content.formulas.append(Formula(cell, _usual_formula(formula), value))


def _usual_formula(formula: str) -> str:
    """Return a formula of OpenDocument as a spreadsheet program shows it.

    For example, ``of:=[.B$4]+0.3`` becomes ``=B$4+0.3``.
    """
    text = "=" + formula.partition("=")[2]

    def usual(area: re.Match[str]) -> str:
        sheet, _, first = area[1].partition(":")[0].rpartition(".")
        last = area[1].partition(":")[2].rpartition(".")[2]
        name = sheet.lstrip("$") + "!" if sheet else ""
        return name + first + (f":{last}" if last else "")

    return re.sub(r"\[([^\[\]]*)\]", usual, text).replace(";", ",")
