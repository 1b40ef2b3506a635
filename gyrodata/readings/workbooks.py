"""Excel workbooks, where the extra for them is installed."""

from __future__ import annotations

import io
import zipfile
from datetime import time, timedelta
from importlib import import_module
from typing import Any

from gyrodata.readings.files import G104, G106, G108, MAX_COLUMNS, MAX_ROWS, table_text
from gyrodata.readings.log import Faults, listing

_MAX_UNPACKED = 100 * 1000 * 1000


def workbook_text(data: bytes, faults: Faults) -> str:
    """Write the only filled sheet of a workbook as tab-separated text.

    Parameters
    ----------
    data : bytes
        A zip archive, which a workbook is.
    faults : Faults
        To refuse with.

    Raises
    ------
    InputError
        It is another zip, it is damaged, it has several filled sheets, or openpyxl is not installed.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
            unpacked = sum(info.file_size for info in archive.infolist())
    except (zipfile.BadZipFile, OSError, ValueError):
        raise faults.refuse(G104, "this is a damaged zip archive, not a table", "give the CSV itself") from None
    if "xl/workbook.xml" not in names:
        kind = "an OpenDocument file" if "content.xml" in names else "a zip archive"
        hint = "save the table as CSV and give that file; gyro grade reads a zip of a whole class"
        raise faults.refuse(G104, f"this is {kind}, not a table", hint)
    if unpacked > _MAX_UNPACKED:
        raise faults.refuse(G106, "the workbook unpacks to more than 100 MB", "a lab log has a few kilobytes")
    try:
        openpyxl = import_module("openpyxl")
    except ImportError:
        hint = 'pip install "gyrodata[xlsx]" reads it; or save the table as CSV'
        raise faults.refuse(G108, "this is an Excel workbook", hint) from None
    try:
        sheets = _sheets(openpyxl, data)
    except Exception as error:  # a damaged workbook can fail in any way inside the library
        reason = f"{type(error).__name__}: {error}"[:80]
        raise faults.refuse(G108, f"the workbook cannot be read ({reason})", "save the table as CSV") from None
    if len(sheets) != 1:
        found = listing([name for name, _ in sheets]) or "none"
        raise faults.refuse(G108, f"one filled sheet is needed; found: {found}", "save the log's sheet as CSV")
    return "\n".join(table_text(sheets[0][1])) + "\n"


def _sheets(openpyxl: Any, data: bytes) -> list[tuple[str, list[tuple[Any, ...]]]]:
    book = openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True)
    filled = []
    for sheet in book.worksheets:
        # One stray cell at the far corner makes a sheet of 17 thousand million cells.
        values = sheet.iter_rows(values_only=True, max_row=MAX_ROWS + 10, max_col=MAX_COLUMNS + 10)
        rows = [_row(row) for row in values]
        while rows and not any(value is not None for value in rows[-1]):
            rows.pop()
        if rows:
            filled.append((sheet.title, rows))
    return filled


def _row(values: tuple[Any, ...]) -> tuple[Any, ...]:
    end = len(values)
    while end and values[end - 1] is None:
        end -= 1
    return tuple(_plain(value) for value in values[:end])


def _plain(value: Any) -> Any:
    """Undo what Excel makes of a stopwatch time: 03:36.26 is stored as a time of the day."""
    if isinstance(value, time):
        if value.hour:
            return f"{value:%H:%M:%S} (a time of the day)"  # "3:36" typed: three hours, or three minutes?
        return f"{value.minute:02d}:{value.second + value.microsecond / 1e6:05.2f}"
    if isinstance(value, timedelta):
        minutes, seconds = divmod(value.total_seconds(), 60)
        return f"{int(minutes):02d}:{seconds:05.2f}"
    return value
