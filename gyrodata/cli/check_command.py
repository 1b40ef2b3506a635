"""``gyro template`` and ``gyro check``: a log to fill in, and what a log still lacks."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from gyrodata.cli.options import ConfigOption, MappingOption, SettingsOption, pairs, with_units
from gyrodata.cli.terminal import FAULT, coloured, fault, name_of, refuse, source_of, write_out
from gyrodata.diagnostics import FORMAT_FOR_ONE_LOG
from gyrodata.errors import GyroError

if TYPE_CHECKING:
    from gyrodata.readings import Readings


CheckFormat = Literal["text", "json", "ndjson", "github"]


def template(
    weights: Annotated[str, typer.Option("--weights", help="Masses of the weights.")] = "20g,40g,60g",
    position: Annotated[str, typer.Option("--position", help="Where the weights sit on the rod.")] = "15cm",
    spins: Annotated[str, typer.Option("--spins", help="Spins to aim at.")] = "200,400,600rpm",
) -> None:
    """Print a blank log to fill in: the weights in turn, each with every spin, and a run without a weight."""
    from gyrodata.readings import blank_log

    write_out(blank_log(with_units(weights), position, with_units(spins)))


def check(
    logs: Annotated[list[str], typer.Argument(metavar="LOG...", help="CSV logs; - is standard input.")],
    form: Annotated[
        CheckFormat, typer.Option("--format", "-f", help="github: annotations of a workflow run.")
    ] = "text",
    settings: SettingsOption = None,
    mapping: MappingOption = None,
    config: ConfigOption = None,
    exit_zero: Annotated[bool, typer.Option("--exit-zero", help="Exit with 0 even when something is found.")] = False,
) -> None:
    """Say what is wrong with a log, and what it still lacks, before the weight comes off.

    Exit codes: 0 clean; 1 something was found; 2 usage, or a log that cannot be read; 3 a fault of gyro.
    """
    given = pairs(settings, "--set"), pairs(mapping, "--map")
    if form == "json" and len(logs) > 1:
        refuse(FORMAT_FOR_ONE_LOG, "--format json is for one log", "use --format ndjson for several: one object a line")
    worst = max(_check_one(log, given[0], given[1], config, form) for log in logs)
    raise typer.Exit(0 if exit_zero and worst == 1 else worst)


def _check_one(
    log: str, settings: dict[str, str], mapping: dict[str, str], config: Path | None, form: CheckFormat
) -> int:
    """Check one log, print what was found, and give the exit code."""
    from gyrodata import reporting
    from gyrodata.readings import read_log

    readings: Readings | None = None
    try:
        readings = read_log(**source_of(log), settings=settings, mapping=mapping, config=config)
        found = readings.diagnostics
        if not any(diagnostic.severity == "error" for diagnostic in found):
            from gyrodata.procedure import check_procedure

            found = (*found, *check_procedure(readings))
        code = 1 if any(diagnostic.severity != "note" for diagnostic in found) else 0
    except GyroError as error:
        found, code = error.diagnostics, error.exit_code
    except Exception as error:
        found, code = (fault(error, name_of(log)),), FAULT
    found = tuple(sorted(found, key=lambda diagnostic: (diagnostic.line or 0, diagnostic.column or 0)))
    name = name_of(log)
    if form == "text":
        write_out(coloured(reporting.check_text(name, len(readings.runs) if readings else None, found), sys.stdout))
    elif form == "github":
        write_out(reporting.github_annotations(name if log == "-" else log, found))
    else:
        digest, rows = (readings.sha256, len(readings.runs)) if readings else (None, None)
        from gyrodata.results import check_document

        document = check_document(name, digest, rows, code == 0, found)
        write_out(reporting.json_text(document, indent=2 if form == "json" else None))
    return code
