"""Gate 10: what the tool costs beside what cannot be avoided. Printed to standard error, and never a failure.

Each ratio compares processes that run in turn, and takes the shortest of several runs: start-up (``gyro --help`` over
``python -c pass``), one log (``gyro analyze --format json`` over importing numpy), and the CPU of a class of 200 a log,
workers included, without what a class of four costs.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from gates.labs import Bench, typed
from gates.stored import ROOT, Found

GYRO = [sys.executable, "-m", "gyrodata"]
LOG = str(ROOT / "sample_data" / "air_gyroscope.csv")


def fastest(*commands: list[str], times: int = 15) -> list[float]:
    """Run commands in turn, and give the shortest time of each [s]. Byte code is kept, as where it is installed."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    took: list[list[float]] = [[] for _ in commands]
    for _ in range(times):
        for command, mine in zip(commands, took, strict=True):
            begun = time.perf_counter()
            subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, check=True)
            mine.append(time.perf_counter() - begun)
    return [min(mine) for mine in took]


def of_class(size: int, home: Path) -> float:
    """Grade a class, and give the CPU of all processes [s]."""
    folder = home / f"class{size}"
    folder.mkdir()
    for number in range(size):
        said = b"# reported_inertia: 4.44e-3 \xc2\xb1 0.05e-3 kg m^2\n"
        name = f"student{number}_{1000 + number}_{9000 + number}_lab.csv"
        (folder / name).write_bytes(said + typed(Bench(), number))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [*GYRO, "grade", str(folder), "--out", str(home / f"grades{size}"), "--workers", "2", "--quiet"]
    subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def gate(accept: bool = False, part: bool = False) -> Found:
    """Measure the ratios."""
    bare, numpy = [sys.executable, "-c", "pass"], [sys.executable, "-c", "import numpy"]
    one = [*GYRO, "analyze", LOG, "--no-report", "--format", "json"]
    start, python, analysis, importing = fastest([*GYRO, "--help"], bare, one, numpy)
    with tempfile.TemporaryDirectory() as folder:
        few, many = of_class(4, Path(folder)), of_class(200, Path(folder))
    print(
        f"start-up {start / python:.1f} x python, one log {analysis / importing:.2f} x import numpy "
        f"({1e3 * analysis:.0f} ms), class of 200: {1e3 * (many - few) / 196:.1f} ms of CPU a log",
        file=sys.stderr,
    )
    return Found("printed to standard error", "8.5 x, 3 x, 10 ms a log; never a failure", True)
