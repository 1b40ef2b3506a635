"""Workbooks with formulas, and with hidden rows: as programs write them, and as
spreadsheet programs save them.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable
from typing import Any
from xml.sax.saxutils import escape

import openpyxl
import pytest
from openpyxl.worksheet.formula import ArrayFormula
from simulated_labs import analyze_briefly

from gyrodata.base.errors import GyroError
from gyrodata.readings import read_log

HEAD = ["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"]
TIMES = [
    (20.1, 201, 20.12),
    (20.1, 400, 40.04),
    (40.3, 201, 10.04),
    (40.3, 400, 19.97),
    (60.2, 602, 20.12),
]
"""Mass [g], spin [rpm] and time of one turn [s] at an arm of 14.8 cm, simulated with
I_zz = 4.44e-3 kg·m²."""
TRUTH = 4.44e-3
Rows = list[list[Any]]


def rows(position: Callable[[int], Any]) -> Rows:
    """Give a log; `position` is a function of the number of the row."""
    runs = [
        [mass, position(row), spin, time, 1]
        for row, (mass, spin, time) in enumerate(TIMES, 2)
    ]
    return [HEAD, *runs]


class Written(str):
    """A formula with the value that is stored beside it; None stores none."""

    value: str | None

    def __new__(cls, formula: str, value: str | None = None) -> Written:
        made = super().__new__(cls, formula)
        made.value = value
        return made


def letter(column: int) -> str:
    return chr(ord("A") + column)


def xlsx_cell(name: str, cell: Any) -> str:
    """Write a cell with its formula and its value, as most programs do."""
    if isinstance(cell, Written):
        value = "" if cell.value is None else f"<v>{cell.value}</v>"
        return f'<c r="{name}"><f>{escape(cell[1:])}</f>{value}</c>'
    if isinstance(cell, str):
        return f'<c r="{name}" t="inlineStr"><is><t>{escape(cell)}</t></is></c>'
    return f'<c r="{name}"><v>{cell}</v></c>'


def sheet_xml(table: Rows, cell: Callable[[str, Any], str] = xlsx_cell) -> str:
    lines = (
        f'<row r="{number}">'
        + "".join(cell(f"{letter(at)}{number}", one) for at, one in enumerate(row))
        + "</row>"
        for number, row in enumerate(table, 1)
    )
    return "<sheetData>" + "".join(lines) + "</sheetData>"


def changed(data: bytes, part: str, change: Callable[[str], str]) -> bytes:
    """Change one part of a workbook."""
    out = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(data)) as old,
        zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        for name in old.namelist():
            text = old.read(name)
            new.writestr(name, change(text.decode()).encode() if name == part else text)
    return out.getvalue()


def saved(book: openpyxl.Workbook) -> bytes:
    book.save(stream := io.BytesIO())
    return stream.getvalue()


def xlsx(
    *tables: Rows,
    cell: Callable[[str, Any], str] = xlsx_cell,
    asks: bool = False,
    sheet: str = "Sheet",
) -> bytes:
    """Write sheets as XML; `asks`: the workbook says that its formulas have to be
    calculated when it is opened.
    """
    book = openpyxl.Workbook()
    book.active.title = sheet
    for number in range(1, len(tables)):
        book.create_sheet(f"Data{number}")
    data = saved(book)
    for number, table in enumerate(tables, 1):
        text = sheet_xml(table, cell)
        part = f"xl/worksheets/sheet{number}.xml"
        data = changed(
            data,
            part,
            lambda old, text=text: re.sub(
                "<sheetData ?/>|<sheetData></sheetData>", lambda _: text, old
            ),
        )
    setting = (
        '<calcPr calcId="1" fullCalcOnLoad="1"/>'
        if asks
        else '<calcPr calcId="191029"/>'
    )
    return changed(
        data, "xl/workbook.xml", lambda old: re.sub("<calcPr[^>]*/>", setting, old)
    )


def by_openpyxl(table: Rows) -> bytes:
    book = openpyxl.Workbook()
    for row in table:
        book.active.append(
            [str(cell) if isinstance(cell, Written) else cell for cell in row]
        )
    return saved(book)


def as_text_cell(name: str, cell: Any) -> str:
    """Write a formula as R's openxlsx does, with the type of a text."""
    return (
        f'<c r="{name}" t="str"><f>{escape(cell[1:])}</f></c>'
        if isinstance(cell, Written)
        else xlsx_cell(name, cell)
    )


def blank_text_cell(name: str, cell: Any) -> str:
    if not isinstance(cell, Written):
        return xlsx_cell(name, cell)
    return f'<c r="{name}" t="str"><f>{escape(cell[1:])}</f><v></v></c>'


def without_places(table: Rows) -> bytes:
    """Write a workbook as some programs do: no row and no cell has its name."""
    text = "xl/worksheets/sheet1.xml"
    return changed(
        xlsx(table), text, lambda old: re.sub(r'(<(?:row|c)) r="\w+"', r"\1", old)
    )


PROGRAMS: dict[str, Callable[[Rows], bytes]] = {
    "openpyxl": by_openpyxl,
    "SheetJS, ExcelJS: no value": xlsx,
    "R openxlsx: no value, as a text": lambda table: xlsx(table, cell=as_text_cell),
    "a blank text": lambda table: xlsx(table, cell=blank_text_cell),
    "no names of cells": without_places,
}


def refusal(data: bytes) -> str:
    """Give the error of a log, with its place."""
    with pytest.raises(GyroError) as caught:
        analyze_briefly(data, name="log.xlsx")
    error = caught.value.diagnostics[-1]
    return f"{str(error).partition(' error')[0]} {error.code} {error.message}; {error.hint}"


@pytest.mark.parametrize("program", PROGRAMS)
def test_formula_without_a_value_is_an_error_with_its_cell(program: str) -> None:
    table = rows(lambda row: 14.5 if row == 2 else Written(f"=B$2+{row / 10}"))
    said = refusal(PROGRAMS[program](table))
    assert said.startswith(
        "log.xlsx:Sheet!B3: G110 a formula without a stored value (also B4, B5, B6)"
    )
    assert "open the file in Excel or LibreOffice, and save it" in said


ZEROS = {
    "sum": "=B$2+0.3",
    "difference": "=B$2-1",
    "functions": "=ROUND(AVERAGE(B$2:B$2)*10/SUM(2,3)^2%, 2)",
}


@pytest.mark.parametrize("formula", ZEROS.values(), ids=list(ZEROS))
def test_stored_zero_that_is_not_the_result_is_an_error(formula: str) -> None:
    table = rows(lambda row: 14.8 if row == 2 else Written(formula, "0"))
    data = xlsx(table)
    assert (
        "Sheet!B3: G110 a formula without a stored value: the stored 0 is not"
        in refusal(data)
    )


def test_stored_zero_of_a_number_on_another_sheet_is_an_error() -> None:
    table = rows(lambda row: 14.8 if row == 2 else Written("='Data1'!A$1*2", "0"))
    assert "Sheet!B3: G110" in refusal(xlsx(table, [[7.4]]))


def test_zeros_below_a_zero_that_was_not_calculated_are_errors() -> None:
    table = rows(
        lambda row: (
            14.5 if row == 2 else Written(f"=IF(B{row - 1}>1,B{row - 1}*2,0)", "0")
        )
    )
    table[2][1] = Written("=B2+0.3", "0")
    assert (
        "Sheet!B3: G110 a formula without a stored value: the stored 0 is not its "
        "result (also B4, B5, B6)"
    ) in (refusal(xlsx(table)))


def test_zero_of_a_formula_in_a_workbook_that_asks_is_an_error() -> None:
    table = rows(lambda row: 14.5 if row == 2 else Written("=VLOOKUP(1,A1:B9,2)", "0"))
    assert "Sheet!B3: G110" in refusal(xlsx(table, asks=True))


def shared(table: Rows, value: str) -> bytes:
    """Write the formula of one column as Excel does: only the first cell contains it."""

    def cell(name: str, one: Any) -> str:
        if not isinstance(one, Written):
            return xlsx_cell(name, one)
        formula = (
            f'<f t="shared" ref="B3:B6" si="0">{one[1:]}</f>'
            if name == "B3"
            else '<f t="shared" si="0"/>'
        )
        return f'<c r="{name}">{formula}{value}</c>'

    return xlsx(table, cell=cell)


@pytest.mark.slow
@pytest.mark.parametrize("value", ["", "<v></v>", "<v/>", "<v>0</v>"])
def test_shared_formula_without_values_is_an_error(value: str) -> None:
    data = shared(rows(lambda row: 14.5 if row == 2 else Written("=B2+0.3")), value)
    assert "Sheet!B3: G110" in refusal(data)
    assert "(also B4, B5, B6)" in refusal(data)


def test_area_of_an_array_formula_without_values_is_an_error() -> None:
    book = openpyxl.Workbook()
    for row in rows(lambda row: 14.5 if row == 2 else None):
        book.active.append(row)
    book.active["B3"] = ArrayFormula("B3:B6", "=C3:C6/C3:C6*14.8")
    assert "Sheet!B3: G110 a formula without a stored value" in refusal(saved(book))


def test_line_with_a_formula_without_a_value_is_an_error() -> None:
    below = [["g [m/s^2]", Written("=9.8+0.003")]]
    assert "Sheet!B7: G110" in refusal(xlsx(rows(lambda row: 14.8) + below))


@pytest.mark.slow
@pytest.mark.parametrize(
    "write",
    [xlsx, lambda table: shared(table, "<v>14.8</v>")],
    ids=["xlsx", "shared"],
)
def test_formulas_with_values_are_read(write: Callable[[Rows], bytes]) -> None:
    plain = analyze_briefly(write(rows(lambda row: 14.8))).inertia
    table = rows(lambda row: 14.8 if row == 2 else Written("=B2", "14.8"))
    inertia = analyze_briefly(write(table)).inertia
    assert (inertia.value, inertia.u) == (plain.value, plain.u)
    assert abs(inertia.value - TRUTH) < 2 * inertia.u


LEGITIMATE = {
    "difference of equal cells": "=A3-A3",
    "difference in the last bit": "=B2*3-3*B2+0.1+0.2-0.3",
    "product with a zero": "=B2*0",
    "choice": '=IF(B2>20,"",0)',
}


@pytest.mark.slow
@pytest.mark.parametrize("formula", LEGITIMATE.values(), ids=list(LEGITIMATE))
def test_zeros_among_other_results_are_read(formula: str) -> None:
    # A program that calculates no formula stores a 0 for all of them.
    table = rows(lambda row: 14.8 if row == 2 else Written("=B$2", "14.8"))
    extra = [["check"], *[[Written(formula, "0")] for _ in TIMES]]
    joined = [left + right for left, right in zip(table, extra, strict=True)]
    inertia = analyze_briefly(xlsx(joined)).inertia
    assert abs(inertia.value - TRUTH) < 2 * inertia.u


def test_formula_with_a_blank_text_as_its_value_is_blank() -> None:
    table = rows(lambda row: 14.8)
    table = [
        [*row, Written('=IF(A2>99,"heavy","")') if at else "note"]
        for at, row in enumerate(table)
    ]
    inertia = analyze_briefly(xlsx(table, cell=blank_text_cell)).inertia
    assert abs(inertia.value - TRUTH) < 2 * inertia.u


def hidden_note(data: bytes) -> str:
    (note,) = [one for one in analyze_briefly(data).diagnostics if one.code == "G111"]
    assert note.severity == "note"
    return note.message


def test_hidden_rows_and_columns_of_excel_are_named() -> None:
    book = openpyxl.load_workbook(io.BytesIO(by_openpyxl(rows(lambda row: 14.8))))
    sheet = book.active
    for row in (3, 5, 6, 90):  # row 90 is blank
        sheet.row_dimensions[row].hidden = True
    sheet.column_dimensions["B"].hidden = True
    sheet.column_dimensions["K"].hidden = True
    said = hidden_note(saved(book))
    assert said == (
        "hidden in the spreadsheet, but read: rows 3, 5, 6 of the sheet Sheet; "
        "column B of the sheet Sheet"
    )


def test_many_hidden_rows_are_counted() -> None:
    book = openpyxl.load_workbook(io.BytesIO(by_openpyxl(rows(lambda row: 14.8))))
    for row in range(7, 27):
        book.active.append([20.1, 14.8, 201, 20.12 + row / 100, 1])
        book.active.row_dimensions[row].hidden = True
    assert "and 8 more of the sheet Sheet" in hidden_note(saved(book))


def test_hidden_sheet_is_named() -> None:
    book = openpyxl.load_workbook(io.BytesIO(by_openpyxl(rows(lambda row: 14.8))))
    other = book.create_sheet("Raw data")
    other.append(["a"])
    other.sheet_state = "hidden"
    assert "the sheet 'Raw data'" in hidden_note(saved(book))


@pytest.mark.parametrize("number", [14.8, 3, 61])
def test_number_in_a_cell_with_the_format_of_a_date_is_read(
    number: float,
) -> None:
    """A cell in which 1/3 was typed, and then a number, shows the number as a date."""
    book = openpyxl.Workbook()
    for row in rows(lambda _: number):
        book.active.append(row)
    book.active["B2"].number_format = "d-mmm"
    readings = read_log(saved(book), name="log.xlsx")
    assert readings.columns["position"].values[0] == pytest.approx(number / 100)


def test_number_in_a_cell_with_the_format_of_a_time_is_asked_for() -> None:
    book = openpyxl.Workbook()
    for row in rows(lambda _: 15):
        book.active.append(row)
    book.active["B2"] = 120
    book.active["B2"].number_format = "h:mm"
    assert "did you mean 120?" in refusal(saved(book))
