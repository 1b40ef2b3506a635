"""Gate 8: hostile files end within five seconds, with the right exit code and a message
that a terminal can show.

Each file is given to the command in a process of its own: archives that unpack to
gigabytes, bytes that are no text, files over the limits, units that would take for ever
to work out, cells that a terminal obeys."""

from __future__ import annotations

import gzip
import io
import re
import resource
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path

from places import ROOT

from gates.stored import Found

LONGEST = 5.0
"""CPU seconds, which other programs on the machine do not stretch much."""
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROWS = "20,15.0,206,6.95,1/3\n40,15.0,398,6.71,1/3\n60,15.0,604,20.12,1\n"
LOG = HEAD + ROWS
BARE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""What a terminal obeys, or what turns a line around."""


def packed(name: str, data: bytes) -> bytes:
    """Make a zip archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, data)
    return out.getvalue()


@cache
def cases() -> dict[str, tuple[str, bytes | str | Callable[[], bytes], int]]:
    """Make what is given to the command, and the exit code: 1 is an error in the log, 2
    a file that cannot be read.
    """
    zeros = b"0" * 120_000_000
    return {
        "workbook that unpacks to 120 MB": (
            "a.xlsx",
            partial(packed, "xl/workbook.xml", zeros),
            2,
        ),
        "gzip bomb": ("a.csv.gz", partial(gzip.compress, zeros, 9), 2),
        "gzip that is cut off": ("a.csv.gz", gzip.compress(LOG.encode())[:60], 2),
        "zip that is no workbook": ("a.xlsx", packed("a", b"x"), 2),
        "half of a workbook": ("a.xlsx", packed("xl/workbook.xml", b"<x")[:60], 2),
        "NUL": ("a.csv", LOG.replace("206", "2\x006"), 2),
        "eleven megabytes": ("a.csv", "1" * 11_000_000, 2),
        "hundred thousand rows": ("a.csv", HEAD + "20,15,400,7,1\n" * 100_001, 2),
        "a line of nine megabytes": ("a.csv", HEAD + "x" * 9_000_000 + "\n" + ROWS, 2),
        "a quote that never ends": ("a.csv", HEAD + '"' + ROWS * 20_000, 2),
        "five thousand columns": ("a.csv", "x," * 5000 + "\n" + "1," * 5000 + "\n", 2),
        "PNG": ("a.png", b"\x89PNG\r\n\x1a\n" + b"\x00" * 99, 2),
        "web page": ("a.csv", "<!DOCTYPE html><html></html>", 2),
        "empty": ("a.csv", "", 2),
        "power tower as a unit": ("a.csv", LOG.replace("[cm]", "[9**9**9*m]"), 1),
        "power tower in a cell": ("a.csv", LOG.replace("15.0", "15 9**9**9*m", 1), 1),
        "power tower in a line": ("a.csv", f"# g: 9.8 m/s^9**9**9\n{LOG}", 1),
        "nested brackets in a unit": (
            "a.csv",
            LOG.replace("[cm]", f"[{'(' * 4000}cm{')' * 4000}]"),
            1,
        ),
        "a cell that a terminal obeys": (
            "a.csv",
            LOG.replace("206", "\x1b[2J\x1b]0;x\x07"),
            1,
        ),
        "a cell that turns the line around": (
            "a.csv",
            LOG.replace("206", "\u202e6O2"),
            1,
        ),
        "a number of 4000 digits": ("a.csv", LOG.replace("206", "9" * 4000), 1),
        "nan and inf": ("a.csv", LOG.replace("206", "nan").replace("398", "inf"), 1),
        "a name that a terminal obeys": (
            "\x1b[31mred\x07.csv",
            LOG.replace("206", "2O6"),
            1,
        ),
        "class with a bomb in it": ("bomb.zip", partial(packed, "a.csv", zeros), 1),
        "class that climbs out": (
            "evil.zip",
            packed("../../evil.csv", LOG.encode()),
            2,
        ),
        "class that is no zip": ("bad.zip", b"PK\x03\x04" + b"x" * 50, 2),
    }


def run(case: str, folder: Path) -> Iterator[str]:
    """Give one file to the command, and list what is wrong with the answer."""
    name, data, code = cases()[case]
    data = data() if callable(data) else data
    (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
    words = (
        ["grade", name, "--dry-run"]
        if name.endswith(".zip")
        else ["analyze", name, "--no-report"]
    )
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    start = f"import sys; sys.path.insert(0, {str(ROOT)!r}); from gyrodata.cli import app; app()"
    try:
        done = subprocess.run(
            [sys.executable, "-c", start, *words],
            capture_output=True,
            timeout=60,
            cwd=folder,
        )
    except subprocess.TimeoutExpired:
        yield f"{case}: at most {LONGEST:g} s | more than a minute"
        return
    took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    said = (done.stdout + done.stderr).decode("utf-8", "replace")
    if done.returncode != code:
        yield f"{case}: exit code {code} | {done.returncode}: {said[:150]!r}"
    if took > LONGEST:
        yield f"{case}: at most {LONGEST:g} s | {took:.1f} s"
    if (
        not re.search(r"(error|warning) G\d{3}: \S|not graded: ", said)
        or "Traceback" in said
    ):
        yield f"{case}: a message | {said[-150:]!r}"
    if bare := BARE.search(said):
        yield f"{case}: words that a terminal can show | {bare[0]!r}"


def gate(accept: bool = False, part: bool = False) -> Found:
    """Run all cases, or one of them."""
    tried = list(cases())[2:3] if part else list(cases())
    with tempfile.TemporaryDirectory() as folder:
        wrong = [line for case in tried for line in run(case, Path(folder))]
    return Found(
        f"{len(tried)} files, {len(wrong)} wrong",
        f"exit code, message, {LONGEST:g} s",
        not wrong,
        wrong,
    )
