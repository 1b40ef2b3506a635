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
"""Between two looks at the file [s]."""

PATIENCE = 10
"""After so many looks a file is read even if it changes all the time."""

_CLEAR = "\033[H\033[2J"
_RULE = "-" * 72 + "\n"


def watch(
    path: Path,
    read: Callable[[bytes], Readings],
    analyse: Callable[[Readings], Analysis],
    sleep: Callable[[float], None] = time.sleep,
) -> None:
    """Print how the lab stands, now and after each change of the log, until Ctrl-C.

    On a terminal each state takes the place of the last; elsewhere they follow each other, parted by a line.
    """
    on_terminal = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
    before = ""
    for data in contents(path, sleep):
        text = f"{path.name}: cannot be read now\n" if data is None else state(path.name, data, read, analyse)
        if on_terminal:
            text = coloured(text, sys.stdout)
            write_out(f"{_CLEAR}{text}\nwatching {path.name}; Ctrl-C ends it\n")
        else:
            write_out(before + text)
        before = _RULE


def contents(path: Path, sleep: Callable[[float], None]) -> Iterator[bytes | None]:
    """Give what a file holds, now and whenever that has changed and come to rest; None while it cannot be read.

    A file that is being written changes from look to look, and one that is saved by renaming another is gone for a
    moment: what is not the same in two looks is not yet read.
    """
    last_seen = last_read = signature(path)
    shown = _read(path)
    yield shown
    restless = 0
    while True:
        sleep(PAUSE)
        seen = signature(path)
        if seen == last_read:
            restless = 0
        elif seen == last_seen or restless >= PATIENCE:
            data = _read(path)
            last_read, restless = seen, 0
            if data != shown:
                shown = data
                yield shown
        else:
            restless += 1
        last_seen = seen


def signature(path: Path) -> tuple[int, ...] | None:
    """Give what changes when a file is saved; None where there is no file."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino


def _read(path: Path) -> bytes | None:
    from gyrodata.readings import MAX_BYTES

    try:
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError:
        return None


def state(
    name: str,
    data: bytes,
    read: Callable[[bytes], Readings],
    analyse: Callable[[Readings], Analysis],
) -> str:
    """Say how the lab stands by what the file holds, or why it does not say yet."""
    from gyrodata.procedure import what_lacks
    from gyrodata.reporting.text import unfinished_text, watch_text

    try:
        readings = read(data)
        analysis = analyse(readings)
        return watch_text(analysis, what_lacks(readings, analysis.measurements, analysis))
    except GyroError as error:
        return unfinished_text(name, error.diagnostics)
    except Exception as error:
        return unfinished_text(name, [fault(error, name)])
