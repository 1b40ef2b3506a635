"""What `gyro check` found, and the table of all codes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from gyrodata.errors import Diagnostic
from gyrodata.reporting.values import count_text
from gyrodata.reporting.words import visible
from gyrodata.results import CheckDocument, Input, Tool, plain


def check_document(
    name: str, sha256: str | None, rows: int | None, clean: bool, diagnostics: Sequence[Diagnostic]
) -> dict[str, Any]:
    """Put what `gyro check` found into its JSON object."""
    found = tuple(diagnostics)
    return plain(CheckDocument("gyro.check/1", Tool(), Input(name, sha256, rows), clean, found))  # type: ignore[no-any-return]


def check_text(name: str, runs: int | None, diagnostics: Sequence[Diagnostic]) -> str:
    """Write what `gyro check` found, and a last line that sums it up.

    Parameters
    ----------
    name : str
        Name of the log.
    runs : int or None
        Number of runs read; None where it could not be read.
    diagnostics : sequence of Diagnostic
        What was found.

    Returns
    -------
    str
    """
    counts = {severity: sum(d.severity == severity for d in diagnostics) for severity in ("error", "warning", "note")}
    told = ", ".join(count_text(count, severity) for severity, count in counts.items() if count)
    read = "" if runs is None else f"{count_text(runs, 'run')}, "
    clean = not counts["error"] and not counts["warning"]
    verdict = f"complete{f' ({told})' if told else ''}" if clean else told
    return visible("".join(f"{diagnostic}\n" for diagnostic in diagnostics) + f"{name}: {read}{verdict}\n")


def github_annotations(path: str, diagnostics: Sequence[Diagnostic]) -> str:
    """Write diagnostics as workflow commands, one a line.

    Parameters
    ----------
    path : str
        Path of the log as it was typed.
    diagnostics : sequence of Diagnostic
        What was found.

    Returns
    -------
    str
        ``::error file=…,line=…,col=…,title=…::message``; percent signs, line ends, and in properties commas and
        colons, are escaped as the format asks.
    """

    def escaped(text: str, more: str = "") -> str:
        for character in "%\r\n" + more:
            text = text.replace(character, f"%{ord(character):02X}")
        return text

    lines = []
    for d in diagnostics:
        kind = "notice" if d.severity == "note" else d.severity
        place = "".join(f",{key}={value}" for key, value in (("line", d.line), ("col", d.column)) if value is not None)
        message = escaped(f"{d.message}\n{d.hint}".strip())
        lines.append(f"::{kind} file={escaped(path, ',:')}{place},title={escaped(d.code, ',:')}::{message}\n")
    return "".join(lines)


def diagnostics_text(table: Sequence[Mapping[str, str]]) -> str:
    """Write the table of diagnostic codes, each with an example that raises it.

    Parameters
    ----------
    table : sequence of mapping
        Keys "code", "severity", "title", "example".

    Returns
    -------
    str
    """
    blocks = []
    for row in table:
        example = "\n".join(f"      {line}" for line in row["example"].rstrip("\n").splitlines())
        blocks.append(f"{row['code']}  {row['severity']:7}  {row['title']}\n{example}\n")
    return "\n".join(blocks)
