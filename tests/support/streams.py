"""Run every command in every format, its output into a file and onto a terminal, in
this process's locale: ``python tests/support/streams.py FOLDER ENCODING …``.
"""

from __future__ import annotations

import itertools
import os
import sys
import threading
import time
from codecs import lookup
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path

from analyzed_once import analyzed_once
from fitted_once import fitted_once
from places import DATA

LINES = (DATA / "commands_and_formats.txt").read_text(encoding="utf-8").splitlines()


def run(line: str, out: int, encoding: str) -> None:
    """Run a command with a descriptor for standard output and error, opened as Python
    opens its own.
    """
    from gyrodata.cli import app

    with open(out, "wb", closefd=False) as raw:
        both = TextIOWrapper(
            raw, encoding=encoding, errors="strict", write_through=True
        )
        before = sys.stdout, sys.stderr
        sys.stdout = sys.stderr = both
        try:
            with suppress(SystemExit):
                app(line.split(), prog_name="gyro")
        finally:
            sys.stdout, sys.stderr = before
            both.detach()


def on_terminal(line: str, encoding: str) -> bytes:
    """Give what a terminal gets."""
    master, slave = os.openpty()
    seen: list[bytes] = []

    def read() -> None:
        with suppress(OSError):
            while data := os.read(master, 1 << 16):
                seen.append(data)

    reader = threading.Thread(target=read)
    reader.start()
    run(line, slave, encoding)
    os.close(slave)
    reader.join()
    os.close(master)
    return b"".join(seen).replace(b"\r\n", b"\n")


if __name__ == "__main__":
    folder, *encodings = sys.argv[1:]
    assert lookup(encodings[0]) == lookup(sys.stdout.encoding)
    # Every fit of a self-check takes as long as the others.
    time.perf_counter = time.monotonic = itertools.count().__next__
    with analyzed_once(), fitted_once():
        for encoding in encodings:
            target = Path(folder, encoding)
            target.mkdir()
            for i, one in enumerate(LINES):
                with (target / f"{i}.file").open("wb") as file:
                    run(one, file.fileno(), encoding)
                (target / f"{i}.terminal").write_bytes(on_terminal(one, encoding))
