"""Standard output and error: what every command prints through."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

import typer

from gyrodata.errors import Diagnostic, InputError, register

G603 = register("G603", "error", "the report cannot be written", "analyze log.csv --out /dev/null")


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


def progress_bar(whole: int, clock: Callable[[], float] | None = None, what: str = "") -> Callable[[int], None] | None:
    """Show how far a long computation is, and by a clock [s] how long it still takes, on a terminal only."""
    if not sys.stderr.isatty():
        return None
    first: tuple[int, float] | None = None

    def show(done: int) -> None:
        nonlocal first
        left = ""
        if clock is not None:
            now = clock()
            # Before the first call an earlier run may have done much, and starting took its time.
            first = first or (done, now)
            if done > first[0]:
                left = f", {time_text((now - first[1]) * (whole - done) / (done - first[0]))} left"
        typer.echo(f"\r{what}{done} of {whole}{left}\033[K" if done < whole else "\r\033[K", err=True, nl=False)

    return show


def time_text(seconds: float) -> str:
    """Write a time to wait: "5 s", "3 min", "1 h 20 min"."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    hours, minutes = divmod(round(seconds / 60), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"


def source_of(log: str) -> dict[str, Any]:
    """Where a log is read from, and what it is called."""
    return {"source": sys.stdin.buffer, "name": "<stdin>"} if log == "-" else {"source": log}


def write_folder(folder: Path, contents: dict[str, bytes]) -> None:
    """Write files into a folder, each one whole or not at all."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in contents.items():
            unfinished = folder / f".{name}.part"
            unfinished.write_bytes(data)
            unfinished.replace(folder / name)
    except OSError as error:
        reason = error.strerror or str(error)
        refuse(G603, f"the files cannot be written to {folder}: {reason}", "choose another folder with --out")
