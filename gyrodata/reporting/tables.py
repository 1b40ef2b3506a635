"""Tables that a spreadsheet may open."""

from __future__ import annotations

import csv
import io

from gyrodata.analysis import Analysis

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


def runs_csv(analysis: Analysis) -> str:
    """Write one row for each run, SI units in the header.

    Parameters
    ----------
    analysis : Analysis
        The result.

    Returns
    -------
    str
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    names = list(analysis.to_dict()["result"]["runs"][0])
    writer.writerow([f"{name} [{RUN_UNITS[name]}]" if name in RUN_UNITS else name for name in names])
    for run in analysis.run_table:
        writer.writerow([csv_cell(getattr(run, name)) for name in names])
    return out.getvalue()


def csv_cell(value: object) -> str:
    """Write one cell of a table that a spreadsheet may open: nothing for None, all digits of a number, a safe text."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    text = str(value).replace("\r", " ")  # which the csv module leaves unquoted, and readers take for a row's end
    # A spreadsheet runs a cell that begins like this as a formula, in wide letters too.
    return f"'{text}" if text[:1] in tuple("=+-@\t\n＝＋－＠") else text
