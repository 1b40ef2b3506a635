"""What a class costs by its size, and what the process that hands the work out needs of memory.

``python tests/classes/scale.py 100 1000 10000`` makes such classes, grades each with two workers and adds lines to
``scale.csv`` beside it. Without sizes it only draws the figure of the pages from that table,
``sample_data/figures/class_size.png``.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from classes.cost import COMMAND, make_class

TABLE = Path(__file__).with_suffix(".csv")
FIGURE = Path(__file__).parents[2] / "sample_data" / "figures" / "class_size.png"
HEAD = ("students", "way", "CPU a log [ms]", "of the driver [ms]", "memory of the driver [MB]")

LEAST, EACH = 60.0, 0.020
"""What the driver may take: a start, and so much a student [MB]."""


METER = """
import ctypes, json, os, resource, subprocess, sys
if ctypes.CDLL(None).prctl(36, 1, 0, 0, 0) != 0:
    raise OSError("this system does not give orphans to a process that asks for them")
process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL)
os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
fields = open(f"/proc/{process.pid}/stat").read().rpartition(")")[2].split()
alone = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
_, _, own = os.wait4(process.pid, 0)
try:
    while True:
        os.wait()
except ChildProcessError:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(json.dumps({"alone": alone, "all": used.ru_utime + used.ru_stime, "peak": own.ru_maxrss / 1024}))
"""
"""CPU of a command alone, and with all that it starts, which outlives it (Linux only)."""


def metered(cache: Path, *arguments: str | Path) -> dict[str, float]:
    """CPU seconds and memory of ``gyro grade``, its byte code kept as where it is installed."""
    kept = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(cache)}
    command = [sys.executable, "-c", METER, *COMMAND, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=os.environ | kept)
    used: dict[str, float] = json.loads(done.stdout)
    return used


def measure(size: int, seed: int = 1) -> tuple[object, ...]:
    """Grade a class with two workers: a row of the table."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        options = ("--workers", "2", "--quiet")
        # What is compiled once is no cost of a class.
        metered(home / "cache", make_class(home / "few", 4, seed), "-o", home / "first", *options)
        used = metered(home / "cache", make_class(home / "class", size, seed), "-o", home / "grades", *options)
    costs = (f"{1000 * used[part] / size:.1f}" for part in ("all", "alone"))
    return size, "at once", *costs, f"{used['peak']:.0f}"


def draw(rows: list[dict[str, str]]) -> None:
    """Draw cost and memory against the size of the class."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    sizes = [float(row["students"]) for row in rows]
    left.plot(sizes, [float(row[HEAD[2]]) for row in rows], "o-", label="at once")
    right.plot(sizes, [float(row[HEAD[4]]) for row in rows], "o-", label="at once")
    steps = [min(sizes) * (max(sizes) / min(sizes)) ** (step / 50) for step in range(51)]
    right.plot(steps, [LEAST + EACH * size for size in steps], color="0.5", label="60 MB + 20 kB a student")
    left.set(xscale="log", ylim=(0, None), xlabel="students", ylabel="CPU a log, workers and driver [ms]",
             title="few logs bear the start of the tool")  # fmt: skip
    right.set(xscale="log", yscale="log", xlabel="students", ylabel="memory of the driver [MB]")
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    figure.savefig(FIGURE, dpi=150, metadata={"Software": None})


def main() -> None:
    """Measure what is asked for, and draw all that is known."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, help="students in a class")
    for size in parser.parse_args().sizes:
        row = measure(size)
        print(*row, sep=", ", flush=True)
        with TABLE.open("a", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerow(row)
    with TABLE.open(encoding="utf-8", newline="") as file:
        draw(list(csv.DictReader(file)))


if __name__ == "__main__":
    main()
