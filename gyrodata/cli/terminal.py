"""Standard output and error: what every command prints through."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Any, NoReturn

import typer

from gyrodata.errors import Diagnostic, InputError


def write_out(text: str) -> None:
    """Write data to standard output; a reader that has gone away (``| head``) is no fault."""
    # A test's or a notebook's stand-in has no encoding to fail on.
    with suppress(AttributeError):
        sys.stdout.reconfigure(errors="replace")  # type: ignore[union-attr]
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes standard output once more at exit: let that go nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(0) from None


def complain(diagnostics: Iterable[Diagnostic], quiet: bool = False) -> None:
    """Write diagnostics to standard error, those that stop the analysis last, where they are seen."""
    order = {"note": 0, "warning": 1, "error": 2}
    shown: Sequence[Diagnostic] = sorted(
        (d for d in diagnostics if not quiet or d.severity == "error"),
        key=lambda d: (order[d.severity], d.line or 0, d.column or 0),
    )
    for diagnostic in shown:
        typer.echo(str(diagnostic), err=True)


def refuse(code: str, message: str, hint: str) -> NoReturn:
    """Stop with one error: what is wrong, and what to type."""
    raise InputError([Diagnostic(code, "error", message, hint)])


def progress_bar(whole: int) -> Callable[[int], None] | None:
    """Show how far a long computation is, on a terminal only."""
    if not sys.stderr.isatty():
        return None

    def show(done: int) -> None:
        typer.echo(f"\r{done} of {whole}" if done < whole else "\r\033[K", err=True, nl=False)

    return show


def source_of(log: str) -> dict[str, Any]:
    """Where a log is read from, and what it is called."""
    return {"source": sys.stdin.buffer, "name": "<stdin>"} if log == "-" else {"source": log}
