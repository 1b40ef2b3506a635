"""Make gyrodata/grading/examples.json, the logs that come with gyro; ``python
tests/make_examples.py`` writes it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from msgspec import json, to_builtins
from typer.testing import CliRunner

from gyrodata.base.errors import GyroError
from gyrodata.cli import app
from gyrodata.grading.examples import OF_ROWS
from gyrodata.grading.forensics import FEWEST, Fingerprint, fingerprint
from gyrodata.measurements import measure
from gyrodata.readings import read_log

ROOT = Path(__file__).parent.parent
TARGET = ROOT / "gyrodata" / "grading" / "examples.json"
PAGES = (ROOT / "README.md", *sorted((ROOT / "gyrodata" / "docs").glob("*.md")))


def samples() -> Iterator[tuple[str, bytes]]:
    """Give the files of the folder of samples."""
    for path in sorted((ROOT / "sample_data").rglob("*.csv")):
        if not path.parent.name.endswith("-report"):
            yield path.relative_to(ROOT).as_posix(), path.read_bytes()


def texts() -> Iterator[tuple[str, bytes]]:
    """Give every text that may be a log, with its name."""
    yield from samples()
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for block in re.finditer(r"(?ms)^```(\w*)\n(.*?)^```", text):
            if block[1] != "console":
                yield page.name, block[2].encode()
            for command in re.findall(r"(?m)^\$ gyro (simulate [^|>\n]*)", block[2]):
                log = CliRunner().invoke(app, command.split()).stdout
                yield f"{page.name}, gyro {command.strip()}", log.encode()


def prints() -> dict[str, Fingerprint]:
    """Take the fingerprints of those that are logs, each once."""
    found: dict[str, Fingerprint] = {}
    for name, data in texts():
        try:
            readings = read_log(data, name=name)
        except GyroError:
            continue
        if not readings.ok or len(readings.runs) < FEWEST:
            continue
        one = fingerprint(readings, measure(readings))
        rows = {(each.torque, each.spin, each.time) for each in found.values()}
        if (one.torque, one.spin, one.time) not in rows:
            # A second log of one page has a number behind the name of the page.
            count = sum(key.partition(" (")[0] == name for key in found)
            found[f"{name} ({count + 1})" if count else name] = one
    return found


def stored(one: Fingerprint) -> dict[str, Any]:
    """Give the fields of a fingerprint; a value that all rows share is there once."""
    fields = to_builtins(one)
    for name in OF_ROWS:
        if len(set(fields[name])) == 1:
            fields[name] = fields[name][0]
    if not one.simulated:
        del fields["simulated"]
    return fields


def make() -> str:
    """Write the fingerprints, one in a line."""
    lines = [
        f"{json.encode(name).decode()}:{json.encode(stored(one)).decode()}"
        for name, one in prints().items()
    ]
    return "{\n" + ",\n".join(lines) + "\n}\n"


if __name__ == "__main__":
    TARGET.write_text(make(), encoding="utf-8")
