"""An `Analysis` in words: the text summary, JSON, tables, and the page.

Nothing is computed here that is not already in the result. The names below are loaded when they are first used:
JSON needs none of the words, and text none of the page.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gyrodata.reporting.data import (
        csv_cell,
        csv_lines,
        json_text,
        runs_csv,
        table_header,
        table_rows,
        unanswered_row,
    )
    from gyrodata.reporting.files import alternatives, report_files, shown_form
    from gyrodata.reporting.latex import latex_report
    from gyrodata.reporting.markdown import markdown_report
    from gyrodata.reporting.page import report_page
    from gyrodata.reporting.text import (
        check_text,
        diagnostics_text,
        explanation,
        summary,
        unfinished_text,
        watch_text,
    )
    from gyrodata.reporting.values import (
        count_text,
        duration_text,
        factor_text,
        in_columns,
        inertia_range_text,
        inertia_text,
        number_text,
        p_text,
        power_of_ten,
        size_text,
    )

__all__ = [
    "alternatives",
    "check_text",
    "count_text",
    "csv_cell",
    "csv_lines",
    "diagnostics_text",
    "duration_text",
    "explanation",
    "factor_text",
    "in_columns",
    "inertia_range_text",
    "inertia_text",
    "json_text",
    "latex_report",
    "markdown_report",
    "number_text",
    "p_text",
    "power_of_ten",
    "report_files",
    "report_page",
    "runs_csv",
    "shown_form",
    "size_text",
    "summary",
    "table_header",
    "table_rows",
    "unanswered_row",
    "unfinished_text",
    "watch_text",
]

_HOMES = {
    **dict.fromkeys(("alternatives", "report_files", "shown_form"), "files"),
    "latex_report": "latex",
    "markdown_report": "markdown",
    "report_page": "page",
    **dict.fromkeys(
        ("csv_cell", "csv_lines", "json_text", "runs_csv", "table_header", "table_rows", "unanswered_row"), "data"
    ),
    **dict.fromkeys(
        (
            "check_text",
            "diagnostics_text",
            "explanation",
            "summary",
            "unfinished_text",
            "watch_text",
        ),
        "text",
    ),
    **dict.fromkeys(
        (
            "count_text",
            "duration_text",
            "factor_text",
            "in_columns",
            "inertia_range_text",
            "inertia_text",
            "number_text",
            "p_text",
            "power_of_ten",
            "size_text",
        ),
        "values",
    ),
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'gyrodata.reporting' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"gyrodata.reporting.{_HOMES[name]}"), name)
