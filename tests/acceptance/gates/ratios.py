"""Gate 10: what the tool costs beside what cannot be avoided. Printed to standard
error, and never a failure.

Each ratio compares processes that run in turn, and takes the shortest of several runs:
start-up (``gyro --help`` over ``python -c pass``), one log (``gyro analyze --format
json`` over importing numpy), and the CPU of a class of 200 in one process, for each log
beyond the first four."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from places import ROOT

from gates.drawn_logs import Bench, typed
from gates.stored import Found

GYRO = [sys.executable, "-m", "gyrodata"]
KEPT = {
    key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"
}
"""Byte code is kept, as where the tool is installed."""


def cost(command: list[str]) -> tuple[float, float]:
    """Run a command, and give its time and its CPU [s]."""
    begun, before = (
        time.perf_counter(),
        resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime,
    )
    subprocess.run(command, cwd=ROOT, env=KEPT, capture_output=True, check=False)
    return time.perf_counter() - begun, resource.getrusage(
        resource.RUSAGE_CHILDREN
    ).ru_utime - before


def gate(accept: bool = False, part: bool = False) -> Found:
    """Measure the ratios."""
    one = [
        *GYRO,
        "analyze",
        str(ROOT / "sample_data" / "air_gyroscope.csv"),
        "--no-report",
        "--format",
        "json",
    ]
    commands = [
        [*GYRO, "--help"],
        [sys.executable, "-c", "pass"],
        one,
        [sys.executable, "-c", "import numpy"],
    ]
    rounds = [[cost(command)[0] for command in commands] for _ in range(15)]
    start, python, log, numpy = (min(times) for times in zip(*rounds, strict=True))
    used = {}
    with tempfile.TemporaryDirectory() as home:
        for size in (4, 200):
            folder = Path(home) / f"class{size}"
            folder.mkdir()
            for number in range(size):
                said = "# reported_inertia: 4.44e-3 ± 0.05e-3 kg m^2\n".encode()
                name = f"student{number}_{1000 + number}_{9000 + number}_lab.csv"
                (folder / name).write_bytes(said + typed(Bench(), number))
            out = str(Path(home) / f"grades{size}")
            used[size] = cost(
                [*GYRO, "grade", str(folder), "--out", out, "--workers", "0", "--quiet"]
            )[1]
    print(
        f"start-up {start / python:.1f} x python (8.5), one log {log / numpy:.2f} x "
        f"import numpy (3), class of 200: "
        f"{1e3 * (used[200] - used[4]) / 196:.1f} ms of CPU a log (10)",
        file=sys.stderr,
    )
    return Found(
        "printed to standard error",
        "8.5 x, 3 x, 10 ms a log, but never a failure",
        True,
        [],
    )
