"""Run every command in every format, its output into a file and onto a terminal, in this process's locale."""

from __future__ import annotations

import itertools
import os
import sys
import threading
import time
from contextlib import suppress
from io import TextIOWrapper
from pathlib import Path

LINES = [
    "--help",
    *(f"{name} --help" for name in ("analyze", "grade")),
    *(f"analyze log.csv bad.csv --no-report --format {form}" for form in ("text", "ndjson", "csv", "markdown")),
    *(f"analyze log.csv --no-report --format {form}" for form in ("json", "latex")),
    *(f"analyze log.csv --format csv --table {table}" for table in ("logs", "torques", "budget")),
    "analyze log.csv --no-report -v --values short",
    *(f"check log.csv bad.csv --format {form}" for form in ("text", "ndjson", "github")),
    "check bad.csv --format json",
    "check --hand-in class",
    "template",
    *(f"explain {topic}" for topic in ("", "G454", "theory")),
    *(f"grade class -q --workers 0 --dry-run --format {form}" for form in ("text", "json", "ndjson", "csv")),
    "grade --print-rubric full",
    "simulate --pitch 30deg",
    *(f"selfcheck log.csv --labs 20 --format {form}" for form in ("text", "json")),
    *(f"schema {what}" for what in ("--diagnostics", "--grades")),
    *(
        f"predict {what} --log log.csv --format {form}"
        for what in ("precession", "tip", "twist", "platform", "earth")
        for form in ("text", "json")
    ),
]  # fmt: skip


def run(line: str, out: int, encoding: str) -> None:
    """Run a command with a descriptor for standard output and error, opened as Python opens its own."""
    from gyrodata.cli import app

    with open(out, "wb", closefd=False) as raw:
        both = TextIOWrapper(raw, encoding=encoding, errors="strict", write_through=True)
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
    coded, target = sys.stdout.encoding, Path(sys.argv[1])
    # Every fit of a self-check takes as long as the others.
    time.perf_counter = itertools.count().__next__
    for i, one in enumerate(LINES):
        with (target / f"{i}.file").open("wb") as file:
            run(one, file.fileno(), coded)
        (target / f"{i}.terminal").write_bytes(on_terminal(one, coded))
