"""Tables to fill in: one writer for the commands, by the ending of the name."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from gyrodata.base.disk import telling, write_whole
from gyrodata.cli.terminal import refuse, tell, write_out

ENDINGS = (".csv", ".txt", ".xlsx")
"""Endings of the names of tables that spreadsheets and gyro open."""


class RunToFill(NamedTuple):
    """A run that is not measured yet."""

    mass: float
    """[kg]; 0 without a weight."""
    position: float
    """[m]"""
    turns: str
    note: str


def log_to_fill_in(runs: Iterable[RunToFill]) -> str:
    """Write a log in which spin and time are left to fill in."""
    text = Path(__file__).with_name("blank_log.csv").read_text(encoding="utf-8")
    for run in runs:
        load = "0,"
        if run.mass:
            # The values have the digits that a scale and a ruler show.
            mass = shown(run.mass, "mass", "g", 2)
            load = f"{mass},{shown(run.position, 'length', 'cm', 1)}"
        text += f"{load},,,{run.turns},,{run.note}\n"
    return text


def write_table(out: Path, text: str) -> None:
    """Write a table to fill in; "-" is standard output."""
    if out == Path("-"):
        write_out(text)
        return
    ending = out.suffix.lower()
    if ending not in ENDINGS:
        refuse("table_of_unknown_type", out=out)
    write_new(out, _workbook(text) if ending == ".xlsx" else text.encode())
    tell(f'table to fill in: {out}; after the first runs: gyro check "{out}"')


def write_new(out: Path, data: bytes) -> None:
    """Write a file. One with another content may contain data, and stays."""
    with telling(out):
        if out.exists() and out.read_bytes() != data:
            refuse("file_exists", out=out)
        write_whole(out, [data])


def shown(value: float, kind: str, unit: str, digits: int) -> str:
    """Write a value [SI unit] in a unit, with at least `digits` digits."""
    from gyrodata.quantities.units import from_si

    number = from_si(value, unit, kind)
    short = f"{number:.10g}"
    decimals = len(short.partition(".")[2])
    return short if decimals >= digits else f"{number:.{digits}f}"


_CELL_FORMATS = {
    "mass [g]": "0.00",
    "position [cm]": "0.0",
    "time [s]": "0.00",
    "turns": "@",
}
"""Excel shows as many digits as the instruments; turns are text, because Excel makes a
date of 1/3."""


def _workbook(text: str) -> bytes:
    """Return a table as a workbook.

    The constants are in rows of two cells, and a row of headers contains the units.
    """
    from openpyxl import Workbook

    workbook = Workbook()
    sheet = workbook.active
    for line in text.splitlines():
        if line.endswith(": "):
            sheet.append([line.rstrip(), ""])
        elif line.startswith("#"):
            sheet.append([line])
        else:
            sheet.append(next(csv.reader([line])))
    header = next(row for row in sheet if not str(row[0].value).startswith("#"))
    for head in header:
        sheet.column_dimensions[head.column_letter].width = 18
    for row in sheet.iter_rows(min_row=header[0].row + 1):
        for head, cell in zip(header, row, strict=True):
            _set_format(cell, head.value)
    data = io.BytesIO()
    workbook.save(data)
    return data.getvalue()


def _set_format(cell: Any, header: str) -> None:
    """Show a number with the digits of its column; what is typed as well."""
    cell.number_format = _CELL_FORMATS.get(header, "General")
    digits = str(cell.value).replace(".", "", 1)
    if digits.isdecimal() and cell.number_format.startswith("0"):
        cell.value = float(cell.value)
