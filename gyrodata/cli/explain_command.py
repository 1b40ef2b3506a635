"""``gyro explain``: what a diagnostic means, with an example and what to do."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gyrodata.cli.terminal import refuse, write_out
from gyrodata.diagnostics import (
    CODE_PAGE_GUESSED,
    CODES,
    COMPRESSED_FILE_DAMAGED,
    EXPLAINED_CODE_UNKNOWN,
    NO_UNLOADED_RUN,
)
from gyrodata.errors import GyroError

if TYPE_CHECKING:
    from gyrodata.errors import Diagnostic


OPTIONS = "G5"
"""From here on codes are about options and classes, not about one log."""


def explain(
    codes: Annotated[list[str], typer.Argument(metavar="CODE...", help=f"As a message shows it: {NO_UNLOADED_RUN}.")],
) -> None:
    """Say what a diagnostic means, show a log that raises it, and what gyro says of that log."""
    from gyrodata import reporting

    wanted = [f"G{code.strip().upper().removeprefix('G')}" for code in codes]
    for code, asked in zip(wanted, codes, strict=True):
        if code not in CODES:
            hint = f"take a code as a message shows it, such as {NO_UNLOADED_RUN}; gyro schema --diagnostics lists all"
            refuse(EXPLAINED_CODE_UNKNOWN, f'there is no code "{asked}"', hint)
    write_out("\n".join(reporting.explanation(code, _raised(code)) for code in wanted))


def _raised(code: str) -> Diagnostic | None:
    """Let the example raise its diagnostic, where it is a log."""
    from gyrodata.analysis import analyze_readings
    from gyrodata.procedure import check_procedure
    from gyrodata.readings import read_log

    if code >= OPTIONS or CODES[code].example.startswith("analyze "):
        return None
    found: tuple[Diagnostic, ...] = ()
    try:
        # A byte that is no UTF-8 is what two of them are about.
        page = "latin-1" if code in (COMPRESSED_FILE_DAMAGED, CODE_PAGE_GUESSED) else "utf-8"
        readings = read_log(CODES[code].example.encode(page), name="log.csv")
        found = readings.diagnostics
        if code not in {one.code for one in found}:
            found = analyze_readings(readings).diagnostics
        if code not in {one.code for one in found}:
            found = check_procedure(readings)
    except GyroError as error:
        found = error.diagnostics
    return next((one for one in found if one.code == code), None)
