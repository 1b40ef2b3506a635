"""Add the time of each run, if a log has only the start and the stop of a clock."""

from __future__ import annotations

from decimal import Decimal, DecimalException

from msgspec.structs import replace

from gyrodata.quantities.numerals import fold_number
from gyrodata.readings import layout
from gyrodata.readings.grid import Row
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import Faults
from gyrodata.readings.layout import cells_of

_TIME = "time [s]"


def with_elapsed_time(table: layout.Layout, faults: Faults) -> layout.Layout:
    """Add the column of the time between the start and the stop of a running clock.

    The table stays as it is if it has no such columns, or if a cell is no time.
    """
    clocks = {
        header.moment: at
        for at, header in enumerate(table.headers)
        if _may_be_clock(table, at)
    }
    if not {"start", "end"} <= clocks.keys():
        return table
    start, end = clocks["start"], clocks["end"]
    pairs = zip(cells_of(table, start), cells_of(table, end), strict=True)
    try:
        times = [_seconds(stop) - _seconds(begin) for begin, stop in pairs]
    except DecimalException:
        return table
    if min(times) < 0:
        return table
    values = {"sign": "minus", "second": table.cells[start].text, "name": _TIME}
    faults.add("read_as", table.cells[end], **values)
    width = len(table.cells)
    rows = []
    for row, time in zip(table.rows, times, strict=True):
        spots = (*map(row.spot, range(width)), row.spot(end))
        rows.append(Row(row.line, [*row.texts[:width], f"{time:f}"], spots))
    header = replace(parse_header(_TIME), text=table.headers[end].text)
    cells = [*table.cells, table.cells[end]]
    headers = [*table.headers, header]
    return replace(table, cells=cells, headers=headers, rows=rows)


def _may_be_clock(table: layout.Layout, at: int) -> bool:
    """Return whether a column contains times of a clock; frames of a video are none."""
    header = table.headers[at]
    if header.roles or header.unit not in (None, "s"):
        return False
    return header.unit == "s" or any(":" in text for text in cells_of(table, at))


def _seconds(text: str) -> Decimal:
    """Read the time of a clock, "12:01:10.25" or "1:10", or a plain number."""
    plain = fold_number(text.partition(" (")[0]).replace(",", ".")
    total = Decimal()
    for part in plain.split(":"):
        total = 60 * total + Decimal(part)
    return total
