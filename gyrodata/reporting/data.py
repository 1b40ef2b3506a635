"""Results for programs and spreadsheets: JSON, CSV, and the templates of pages."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Mapping
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec.structs import astuple

from gyrodata.base.errors import PICTURES, Diagnostic
from gyrodata.judging.tables import Run
from gyrodata.physics import RPM
from gyrodata.results import UNITS_OF_RUNS, Analysis, round_digits, runs_with_notes

if TYPE_CHECKING:
    from jinja2 import Environment

_SIGN = r"[=+\-@＝＋－＠]"
_FORMULA = rf"(^(?=[\s\"]*{_SIGN})|[;\n\t](?=(?:[^\S\n]|\")*{_SIGN}))|^(?=[\t\n])"
"""Places where a spreadsheet expects a formula: the start of a cell, also with the
delimiters of other countries."""


_AFTER_SPIN = Run.__struct_fields__.index("spin") + 1


def filled(
    template: str,
    filters: Mapping[str, Any],
    signs: Mapping[str, str] = {},
    **content: object,
) -> str:
    """Fill a template of this folder, with at most one empty line between lines."""
    room = templates(Path(__file__).parent, **signs)
    room.filters |= filters
    return with_few_blank_lines(room.get_template(template).render(**content))


def with_few_blank_lines(text: str) -> str:
    """Return a text with at most one empty line between lines, and one line end."""
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def templates(folder: Path, **signs: str) -> Environment:
    """Return the environment of a folder's templates; HTML escapes every text.

    `signs` replaces the signs of Jinja, such as ``variable_start_string``.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

    # To fold constants takes longer than it gains in one run.
    made = Environment(
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
        optimized=False,
        **signs,  # type: ignore[arg-type]
    )
    made.filters["kind"] = lambda block: type(block).__name__
    made.loader = FileSystemLoader(folder)
    made.autoescape = select_autoescape(("html.jinja",))
    return made


def json_text(document: dict[str, Any], indent: int | None = 2) -> str:
    """Write a result as JSON, on one line if `indent` is None.

    Not-a-number is an error of the tool.
    """
    return json.dumps(document, indent=indent, allow_nan=False) + "\n"


def table_header(table: str) -> str:
    """Write the header of a table of `table_rows`; several logs can share it."""
    if table == "logs":
        return ",".join(_LOG_COLUMNS) + "\n"
    heads = ["log"]
    for name in Run.__struct_fields__:
        unit = f" [{UNITS_OF_RUNS[name]}]" if name in UNITS_OF_RUNS else ""
        heads.append(f"{name}{unit}")
        if name == "spin":
            heads.append("spin [rpm]")
    return ",".join([*heads, "note"]) + "\n"


def table_rows(analysis: Analysis, table: str) -> str:
    """Write the rows of a log in a table: one for each run, or one for the log.

    Values are in SI units with the digits of the JSON; the spin of a run is in rpm too.
    """
    if table == "runs":
        rows = []
        for run, note in runs_with_notes(analysis):
            cells: list[object] = [analysis.name, *astuple(run), note]
            cells.insert(_AFTER_SPIN + 1, run.spin / RPM)
            rows.append([csv_cell(cell) for cell in cells])
        return csv_lines(rows)
    document = analysis.to_dict()
    result = document["result"]
    row = {**document["input"], **result, **result["goodness"]}
    for name in _QUANTITIES:
        quantity = result[name]
        low, high = quantity.get("interval_95") or (None, None)
        quantity = {**quantity, "interval_95_low": low, "interval_95_high": high}
        for part in _PARTS:
            row[f"{name}_{part}"] = quantity.get(part)
    return log_row(analysis.name, row, analysis.diagnostics)


def log_row(
    name: str, row: Mapping[str, Any], diagnostics: Iterable[Diagnostic]
) -> str:
    """Write the row of a log; `row` is empty for a log without an answer."""
    codes = [finding.code for finding in diagnostics if finding.severity != "note"]
    different = " ".join(dict.fromkeys(codes))
    row = {**row, "log": name, "diagnostics": different}
    return csv_lines([[csv_cell(row.get(column)) for column in _LOG_COLUMNS]])


_QUANTITIES = ("inertia", "residual_torque", "timing_bias")
_PARTS = ("value", "u", "unit", "interval_95_low", "interval_95_high")
_LOG_COLUMNS = (
    "log",
    "rows",
    *[f"{name}_{part}" for name, part in product(_QUANTITIES, _PARTS)],
    "model",
    "chi2",
    "dof",
    "p",
    "birge",
    "scatter",
    "sha256",
    "diagnostics",
)
"""Columns of the table of logs: the names in the JSON, joined if one contains the
other."""


def csv_cell(value: object) -> str:
    """Write one cell of a table that a spreadsheet may open.

    The cell is empty for None, and a number has the digits of the JSON.

    A text gets a ' where a spreadsheet would read a formula, and pictures of control
    characters.
    """
    if value is None or value == "":
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(round_digits(value))
    # The csv module does not quote a carriage return, and readers end the row there.
    text = str(value).replace("\r", " ").replace("\t", " ").translate(PICTURES)
    return re.sub(_FORMULA, lambda start: f"{start[1] or ''}'", text)


def csv_lines(rows: Iterable[Iterable[str]]) -> str:
    """Write rows as lines of CSV."""
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()
