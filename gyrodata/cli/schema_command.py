"""``gyro schema``: the JSON Schema of an output, or the table of diagnostics."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from gyrodata.cli.terminal import write_out


def schema(
    name: Annotated[
        Literal[
            "analysis",
            "check",
            "grades",
            "plan",
            "predictions",
            "selfcheck",
            "rubric",
            "diagnostics",
        ],
        typer.Argument(
            metavar="NAME",
            show_choices=False,
            help="analysis, check, grades, plan, predictions, selfcheck, rubric; or "
            "diagnostics, the table of codes.",
        ),
    ] = "analysis",
) -> None:
    """Print the JSON Schema of an output or a rubric, or all diagnostics.

    Example:  gyro schema diagnostics
    """
    from gyrodata.cli.schema import json_schema
    from gyrodata.reporting.data import json_text
    from gyrodata.reporting.text import diagnostics_text

    is_table = name == "diagnostics"
    write_out(diagnostics_text() if is_table else json_text(json_schema(name)))
