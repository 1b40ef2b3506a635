"""``gyro schema``: what comes out."""

from __future__ import annotations

from typing import Annotated

import typer

from gyrodata.cli.terminal import write_out


def schema(
    diagnostics: Annotated[
        bool, typer.Option("--diagnostics", help="The table of diagnostic codes, each with an example.")
    ] = False,
    checks: Annotated[bool, typer.Option("--check", help="The schema of gyro check --format json.")] = False,
    grades: Annotated[bool, typer.Option("--grades", help="The schema of gyro grade --format json.")] = False,
    predictions: Annotated[
        bool, typer.Option("--predictions", help="The schema of gyro predict --format json.")
    ] = False,
    selfchecks: Annotated[
        bool, typer.Option("--selfcheck", help="The schema of gyro selfcheck --format json.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="The table of diagnostics as JSON.")] = False,
) -> None:
    """Print the JSON Schema of the outputs, or the table of diagnostics."""
    from gyrodata import reporting
    from gyrodata import schema as schemas

    if diagnostics and as_json:
        write_out(reporting.json_text({"diagnostics": schemas.diagnostics_table()}))
    elif diagnostics:
        write_out(reporting.diagnostics_text(schemas.diagnostics_table()))
    else:
        wanted = schemas.analysis_schema
        for asked, other in (
            (checks, schemas.check_schema),
            (grades, schemas.grades_schema),
            (predictions, schemas.predictions_schema),
            (selfchecks, schemas.selfcheck_schema),
        ):
            wanted = other if asked else wanted
        write_out(reporting.json_text(wanted()))
