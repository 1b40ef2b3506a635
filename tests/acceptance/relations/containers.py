"""The same cells in another encoding, with other separators, or in a file of another
kind.
"""

from __future__ import annotations

import csv
import gzip
import io
import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from relations.layouts import by_mass
from relations.log_tables import (
    LogTable,
    Rewriting,
    Rows,
    is_number,
    named,
    relation,
    separated,
    text_relation,
)

# Encodings and ends of lines


def encoded(name: str, encoding: str, end: str = "\n") -> None:
    named(name, lambda table: Rewriting(table.text.replace("\n", end).encode(encoding)))


encoded("UTF-8 with a mark of order", "utf-8-sig")
encoded("UTF-16", "utf-16")
encoded("UTF-16, mark and CR LF", "utf-16", "\r\n")
encoded("CR LF", "utf-8", "\r\n")
encoded("CR", "utf-8", "\r")


@text_relation
def latin_1(table: LogTable) -> bytes:
    return f"# café\n{table.text}".encode("latin-1")


@text_relation
def no_end_of_the_last_line(table: LogTable) -> str:
    return table.text.rstrip("\n")


@text_relation
def gz(table: LogTable) -> bytes:
    return gzip.compress(table.text.encode())


# Separators


def delimited(
    name: str, delimiter: str, change: Callable[[str], str] = str, head: str = ""
) -> None:
    def rewritten(table: LogTable) -> Rewriting:
        grid = [table.grid[0], *([change(cell) for cell in row] for row in table.rows)]
        return Rewriting(head + table.above + separated(grid, delimiter))

    named(name, rewritten)


def with_decimal_comma(cell: str) -> str:
    return cell.replace(".", ",") if is_number(cell) else cell


delimited("semicolons", ";")
delimited("tabs", "\t")
delimited("upright lines", "|")
delimited("semicolons and decimal commas", ";", with_decimal_comma)
delimited("tabs and decimal commas", "\t", with_decimal_comma)
delimited("commas and decimal commas in quotes", ",", with_decimal_comma)
delimited("line that names the separator", ";", head="sep=;\n")
delimited("blanks around the cells", ",", lambda cell: f" {cell} ")
delimited(
    "real minus signs",
    ",",
    lambda cell: cell.replace("-", "−") if is_number(cell) else cell,
)


@text_relation
def all_cells_in_quotes(table: LogTable) -> str:
    return table.above + separated(table.grid, quoting=csv.QUOTE_ALL)


@text_relation
def separators_behind_the_last_column(table: LogTable) -> str:
    return table.above + separated([[*row, "", ""] for row in table.grid])


def in_columns_of_text(grid: Rows) -> str:
    widths = [max(map(len, column)) for column in zip(*grid, strict=True)]
    lines = (
        "   ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in grid
    )
    return "".join(f"{line.rstrip()}\n" for line in lines)


@text_relation
def columns_of_blanks(table: LogTable) -> str | None:
    if any("" in row for row in table.rows):
        return None
    return table.above + in_columns_of_text(table.grid)


@text_relation
def markdown(table: LogTable) -> str:
    head, *rows = [f"| {' | '.join(row)} |\n" for row in table.grid]
    return table.above + head + "|---" * len(table.headings) + "|\n" + "".join(rows)


# JSON

NEEDED = {"mass", "position", "turns"}
"""Constants without which a log cannot be analysed."""


def as_number(cell: str) -> float | int | str:
    if not is_number(cell):
        return cell
    return float(cell) if "." in cell or "e" in cell else int(cell)


def as_written_by(write: Callable[[Any], str], table: LogTable) -> LogTable:
    """Give the log with the digits that are left of its numbers: 15.00 becomes 15.0 in
    JSON.
    """
    for role in table.roles:
        table = table.with_cells(role, lambda cell: str(write(as_number(cell))))
    return table


def in_records(table: LogTable, change: Callable[[str], Any]) -> str:
    names = [str(heading) for heading in table.headings]
    rows = [dict(zip(names, map(change, row), strict=True)) for row in table.rows]
    return json.dumps({**dict(table.constants), "runs": rows})


@text_relation
def json_records_of_texts(table: LogTable) -> str:
    return in_records(table, str)


@relation
def json_records_of_numbers(table: LogTable) -> Rewriting:
    return Rewriting(in_records(table, as_number), same_as=as_written_by(str, table))


def in_lists(table: LogTable, change: Callable[[str], Any]) -> str:
    lists = {
        str(heading): [change(cell) for cell in table.cells(heading.role)]
        for heading in table.headings
    }
    return json.dumps({**dict(table.constants), **lists})


@text_relation
def json_columns_of_texts(table: LogTable) -> str:
    return in_lists(table, str)


@relation
def json_columns_of_numbers(table: LogTable) -> Rewriting:
    return Rewriting(in_lists(table, as_number), same_as=as_written_by(str, table))


@relation
def json_columns_as_pandas_writes_them(table: LogTable) -> Rewriting | None:
    """What `DataFrame.to_json()` writes: columns, each with its cells by the number of
    the row.
    """
    if NEEDED.intersection(dict(table.constants)):
        return None
    table = replace(table, constants=())
    columns = {
        str(heading): dict(enumerate(table.cells(heading.role)))
        for heading in table.headings
    }
    return Rewriting(json.dumps(columns), same_as=table)


@relation
def data_frame_of_texts(table: LogTable) -> Rewriting:
    import pandas as pd

    frame = pd.DataFrame(table.rows, columns=table.grid[0])
    frame.attrs.update(table.constants)
    return Rewriting(frame)


# Workbooks


def workbook(
    sheets: dict[str, Rows],
    change: Callable[[str], Any] = str,
    *,
    with_formats: bool = False,
) -> bytes:
    """Write sheets; with formats, a number is shown with the digits that it was typed
    with.
    """
    import openpyxl

    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, grid in sheets.items():
        sheet = book.create_sheet(title)
        for row_number, row in enumerate(grid, 1):
            for column, text in enumerate(row, 1):
                cell = sheet.cell(row_number, column, change(text) if text else None)
                decimals = len(text.partition(".")[2]) if is_number(text) else 0
                if with_formats and decimals:
                    cell.number_format = f"0.{'0' * decimals}"
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def sheet_of(table: LogTable) -> Rows:
    return [*([key, value] for key, value in table.constants), *table.grid]


@text_relation
def workbook_of_texts(table: LogTable) -> bytes:
    return workbook({"Sheet1": sheet_of(table)})


@text_relation
def workbook_of_numbers_with_formats(table: LogTable) -> bytes:
    return workbook({"Sheet1": sheet_of(table)}, as_number, with_formats=True)


def as_excel_shows(number: Any) -> str:
    return (
        str(int(number))
        if isinstance(number, float) and number.is_integer()
        else str(number)
    )


@relation
def workbook_of_numbers(table: LogTable) -> Rewriting:
    return Rewriting(
        workbook({"Sheet1": sheet_of(table)}, as_number),
        same_as=as_written_by(as_excel_shows, table),
    )


def states_readings(table: LogTable) -> bool:
    """Return whether a log states a reading for all runs.

    On a sheet of its own, such a line is asked about: it may be that of one run.
    """
    return not {"mass", "position", "turns"}.isdisjoint(dict(table.constants))


@text_relation
def workbook_with_the_constants_on_a_sheet_of_their_own(
    table: LogTable,
) -> bytes | None:
    if not table.constants or states_readings(table):
        return None
    return workbook(
        {
            "Data": table.grid,
            "Apparatus": [[key, value] for key, value in table.constants],
        }
    )


@text_relation
def workbook_with_the_table_in_a_corner(table: LogTable) -> bytes:
    return workbook(
        {
            "Sheet1": [
                [],
                ["", "", "Gyroscope"],
                [],
                *(["", "", *row] for row in sheet_of(table)),
            ]
        }
    )


@text_relation
def workbook_of_three_sheets(table: LogTable) -> bytes | None:
    if states_readings(table):
        return None
    third = -(-len(table.rows) // 3)
    parts = [table.rows[at : at + third] for at in range(0, len(table.rows), third)]
    sheets = {
        f"part {at}": [table.grid[0], *map(list, part)]
        for at, part in enumerate(parts, 1)
    }
    return workbook(
        {"Apparatus": [[key, value] for key, value in table.constants], **sheets}
    )


@text_relation
def workbook_with_a_sheet_for_each_weight(table: LogTable) -> bytes | None:
    parts = by_mass(table)
    if len(parts) < 2 or "0" in parts or dict(table.constants).keys() - {"g"}:
        return None
    sheets = {f"{mass} g": part.grid for mass, part in parts.items()}
    first, *_ = sheets
    sheets[first] = [*([key, value] for key, value in table.constants), *sheets[first]]
    return workbook(sheets)


@text_relation
def merged_cells_of_a_workbook(table: LogTable) -> bytes | None:
    """Merge the cells of each weight, as a student does who types its mass once."""
    if "mass" not in table.roles or len(set(table.cells("mass"))) == len(table.rows):
        return None
    import openpyxl

    book = openpyxl.load_workbook(io.BytesIO(workbook({"Sheet1": sheet_of(table)})))
    sheet, column = book.active, table.roles.index("mass") + 1
    for first, last in equal_neighbours(table.cells("mass")):
        above = len(table.constants) + 2
        sheet.merge_cells(
            start_row=above + first,
            end_row=above + last,
            start_column=column,
            end_column=column,
        )
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def equal_neighbours(cells: Iterable[str]) -> list[tuple[int, int]]:
    """Give the first and the last place of each run of equal cells."""
    spans: list[tuple[int, int]] = []
    before = None
    for at, cell in enumerate(cells):
        spans[-1:] = [(spans[-1][0], at)] if cell == before else [*spans[-1:], (at, at)]
        before = cell
    return spans
