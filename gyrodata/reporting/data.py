"""Results for programs and spreadsheets: JSON and CSV."""

from __future__ import annotations

import csv
import io
import json
import re
from typing import TYPE_CHECKING, Any

from msgspec.structs import asdict

from gyrodata.comparisons import Run
from gyrodata.errors import PICTURES
from gyrodata.physics import RPM

if TYPE_CHECKING:
    from gyrodata.results import Analysis

RUN_UNITS = {
    "mass": "kg",
    "position": "m",
    "torque": "N*m",
    "spin": "rad/s",
    "time": "s",
    "precession_rate": "rad/s",
    "period": "s",
    "product": "rad^2/s^2",
    "inertia": "kg*m^2",
    "residual": "s",
    "residual_u": "s",
    "influence": "kg*m^2",
}


_FORMULA = r"(^|[;\n\t])(?=[\s\"]*[=+\-@＝＋－＠])|^(?=[\t\n])"
"""Where a spreadsheet would find a formula: at a cell's start, or behind what parts cells in another country."""


_AFTER_SPIN = Run.__struct_fields__.index("spin") + 1


def json_text(document: dict[str, Any], indent: int | None = 2) -> str:
    """Write a result as JSON, one line for ``indent=None``. Not-a-number does not pass: it is a fault of the tool."""
    return json.dumps(document, indent=indent, allow_nan=False) + "\n"


def runs_csv(analysis: Analysis) -> str:
    """Write one row for each run, units in the header: SI, every digit, as in the JSON; the spin in rpm too."""
    return runs_header() + runs_rows(analysis)


def runs_header() -> str:
    """Write the header of `runs_csv`."""
    heads = [f"{name} [{RUN_UNITS[name]}]" if name in RUN_UNITS else name for name in Run.__struct_fields__]
    return ",".join(["log", *heads[:_AFTER_SPIN], "spin [rpm]", *heads[_AFTER_SPIN:], "note"]) + "\n"


def runs_rows(analysis: Analysis) -> str:
    """Write the rows of `runs_csv`; those of several logs can stand below one header."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    for run, note in zip(analysis.run_table, analysis.readings.notes, strict=True):
        cells = list(asdict(run).values())
        # As many digits as survive the way to rad/s and back.
        rpm = float(f"{run.spin / RPM:.14g}")
        row = [analysis.name, *cells[:_AFTER_SPIN], rpm, *cells[_AFTER_SPIN:], note]
        writer.writerow([csv_cell(cell) for cell in row])
    return out.getvalue()


def csv_cell(value: object) -> str:
    """Write one cell of a table that a spreadsheet may open: nothing for None, all digits of a number.

    A text has a ' wherever a spreadsheet would take it for a formula, and pictures of control characters.
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    # The csv module leaves a carriage return unquoted, and readers take it for a row's end.
    text = str(value).replace("\r", " ").replace("\t", " ").translate(PICTURES)
    return re.sub(_FORMULA, lambda start: f"{start[1] or ''}'", text)
