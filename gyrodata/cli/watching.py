"""``gyro analyze --watch``: print the answer again whenever the log is saved."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from gyrodata.cli.terminal import coloured, fault, write_out
from gyrodata.errors import GyroError

if TYPE_CHECKING:
    from gyrodata.readings import Readings
    from gyrodata.results import Analysis

PAUSE = 0.5
"""Time between two looks at the file [s]."""


def watch(path: Path, read: Callable[[bytes], Readings], analyse: Callable[[Readings], Analysis]) -> None:
    """Print the state of the lab, now and after each change of the log, until Ctrl-C.

    On a terminal each state replaces the last one; elsewhere a line separates them.
    """
    on_terminal = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    before = ""
    for data in contents(path):
        text = f"{path.name}: cannot be read now\n" if data is None else state(path.name, data, read, analyse)
        if on_terminal:
            # Clear the screen first.
            write_out(f"\033[H\033[2J{coloured(text, sys.stdout)}\nwatching {path.name}; Ctrl-C ends it\n")
        else:
            write_out(before + text)
        before = "-" * 72 + "\n"


def contents(path: Path) -> Iterator[bytes | None]:
    """Give the content of a file, now and after each change; None while it cannot be read.

    Two looks in sequence have to agree, because a program may still be writing the file.
    """
    from gyrodata.readings import MAX_BYTES

    data = last = shown = None
    for look in range(sys.maxsize):
        try:
            with path.open("rb") as file:
                data = file.read(MAX_BYTES + 1)
        except OSError:
            data = None
        if look == 0 or (data == last and data != shown):
            shown = data
            yield data
        last = data
        time.sleep(PAUSE)


def state(name: str, data: bytes, read: Callable[[bytes], Readings], analyse: Callable[[Readings], Analysis]) -> str:
    """Describe the state of the lab, or explain why there is no answer yet."""
    from gyrodata.procedure import what_lacks
    from gyrodata.reporting import text

    try:
        readings = read(data)
        analysis = analyse(readings)
        return text.watch_text(analysis, what_lacks(readings, analysis.measurements, analysis))
    except GyroError as error:
        return text.unfinished_text(name, error.diagnostics)
    except Exception as error:
        return text.unfinished_text(name, [fault(error, name)])
