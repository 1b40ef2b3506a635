"""Gate 8: hostile files end within five seconds, with the right exit code and a message that a terminal can show.

Each file is given to the command in a process of its own: archives that unpack to gigabytes, bytes that are no text,
files over the limits, units that would take for ever to work out, cells that a terminal obeys, and options.
"""

from __future__ import annotations

import gzip
import io
import re
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gates.stored import ROOT, Found

LONGEST = 5.0
"""Seconds."""
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROWS = "20,15.0,206,6.95,1/3\n40,15.0,398,6.71,1/3\n60,15.0,604,20.12,1\n"
LOG = HEAD + ROWS
BARE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""What a terminal obeys, or what turns a line around."""


def packed(**members: bytes) -> bytes:
    """Make a zip archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name.replace("__", "/").replace("_xml", ".xml").replace("_csv", ".csv"), data)
    return out.getvalue()


ZEROS = b"0" * 120_000_000
CASES: dict[str, tuple[str, bytes, int]] = {
    "workbook that unpacks to 120 MB": ("a.xlsx", packed(xl__workbook_xml=ZEROS), 2),
    "gzip bomb": ("a.csv.gz", gzip.compress(ZEROS, 9), 2),
    "gzip that is cut off": ("a.csv.gz", gzip.compress(LOG.encode())[:60], 2),
    "zip that is no workbook": ("a.xlsx", packed(a=b"x"), 2),
    "half of a workbook": ("a.xlsx", packed(xl__workbook_xml=b"<x")[:60], 2),
    "NUL": ("a.csv", LOG.encode().replace(b"206", b"2\x006"), 2),
    "eleven megabytes": ("a.csv", b"1" * 11_000_000, 2),
    "hundred thousand rows": ("a.csv", HEAD.encode() + b"20,15,400,7,1\n" * 100_001, 2),
    "a line of nine megabytes": ("a.csv", (HEAD + "x" * 9_000_000 + "\n" + ROWS).encode(), 2),
    "a quote that never ends": ("a.csv", (HEAD + '"' + ROWS * 20_000).encode(), 2),
    "five thousand columns": ("a.csv", (",".join(["x"] * 5000) + "\n" + ",".join(["1"] * 5000) + "\n").encode(), 2),
    "PNG": ("a.png", b"\x89PNG\r\n\x1a\n" + b"\x00" * 99, 2),
    "web page": ("a.csv", b"<!DOCTYPE html><html></html>", 2),
    "empty": ("a.csv", b"", 2),
    "power tower as a unit": ("a.csv", LOG.replace("[cm]", "[9**9**9*m]").encode(), 1),
    "power tower in a cell": ("a.csv", LOG.replace("15.0", "15 9**9**9*m", 1).encode(), 1),
    "power tower in a line": ("a.csv", f"# g: 9.8 m/s^9**9**9\n{LOG}".encode(), 1),
    "nested brackets in a unit": ("a.csv", LOG.replace("[cm]", f"[{'(' * 4000}cm{')' * 4000}]").encode(), 1),
    "a cell that a terminal obeys": ("a.csv", LOG.replace("206", "\x1b[2J\x1b]0;x\x07").encode(), 1),
    "a cell that turns the line around": ("a.csv", LOG.replace("206", "\u202e6O2").encode(), 1),
    "a number of 4000 digits": ("a.csv", LOG.replace("206", "9" * 4000).encode(), 1),
    "nan and inf": ("a.csv", LOG.replace("206", "nan").replace("398", "inf").encode(), 1),
    "a name that a terminal obeys": ("\x1b[31mred\x07.csv", LOG.replace("206", "2O6").encode(), 1),
    "class that is a zip bomb": ("grade bomb.zip", packed(a_csv=ZEROS), 1),
    "class that climbs out": ("grade evil.zip", packed(**{"..__..__evil_csv": LOG.encode()}), 2),
    "class that is no zip": ("grade bad.zip", b"PK\x03\x04" + b"x" * 50, 2),
}  # fmt: skip
"""What is given to the command, and the exit code: 1 is an error in the log, 2 a file that cannot be read."""


def run(case: str, folder: Path) -> Iterator[str]:
    """Give one file to the command, and list what is wrong with the answer."""
    name, data, code = CASES[case]
    command, _, name = name.rpartition(" ")
    path = folder / name
    path.parent.mkdir(parents=True)
    path.write_bytes(data)
    words = [command or "analyze", str(path), *(["--dry-run"] if command else ["--no-report"])]
    begun = time.perf_counter()
    try:
        done = subprocess.run([sys.executable, "-m", "gyrodata", *words], capture_output=True, timeout=60, cwd=ROOT)
    except subprocess.TimeoutExpired:
        yield f"{case}: at most {LONGEST:g} s | more than a minute"
        return
    took, said = time.perf_counter() - begun, (done.stdout + done.stderr).decode("utf-8", "replace")
    if done.returncode != code:
        yield f"{case}: exit code {code} | {done.returncode}: {said[:150]!r}"
    if took > LONGEST:
        yield f"{case}: at most {LONGEST:g} s | {took:.1f} s"
    if not re.search(r"(error|warning) G\d{3}: \S|not graded: ", said) or "Traceback" in said:
        yield f"{case}: a message | {said[-150:]!r}"
    if bare := BARE.search(said):
        yield f"{case}: words that a terminal can show | {bare[0]!r}"


def gate(accept: bool = False, part: bool = False) -> Found:
    """Run all cases, or every fifth of them."""
    cases = list(CASES)[:: 5 if part else 1]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(2) as pool:
        found = pool.map(lambda pair: list(run(pair[1], Path(folder) / str(pair[0]))), enumerate(cases))
        wrong = [line for lines in found for line in lines]
    return Found(f"{len(cases)} files, {len(wrong)} wrong", f"exit code, a message, {LONGEST:g} s", not wrong, wrong)
