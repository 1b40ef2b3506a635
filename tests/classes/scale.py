"""What a class costs by its size, and what the process that hands the work out needs of memory.

``python tests/classes/scale.py 100 1000 10000`` makes such classes, grades each with two workers and adds lines to
``scale.csv`` beside it. Without sizes it only draws the figure of the pages from that table,
``sample_data/figures/class_size.png``.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from grading.classes import make_folder

from classes.cells import with_answer
from classes.drawn import draw

TABLE = Path(__file__).with_suffix(".csv")
FIGURE = Path(__file__).parents[2] / "sample_data" / "figures" / "class_size.png"
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
print(json.dumps([used.ru_utime + used.ru_stime, alone, own.ru_maxrss / 1024]))
"""
"""CPU of a command with all that it starts, which outlives it, and alone; its memory (Linux only)."""


def metered(home: Path, size: int) -> list[float]:
    """CPU [s] of all and of the driver, and memory [MB], for a class; byte code is kept as if installed."""
    root = make_folder(home / f"class{size}", with_answer([draw(i, 10) for i in range(size)]))
    gyro = [sys.executable, "-m", "gyrodata", "grade", root, "-o", home / f"grades{size}", "--workers", "2", "--quiet"]
    env = os.environ | {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(home / "cache")}
    done = subprocess.run([sys.executable, "-c", METER, *gyro], capture_output=True, text=True, check=True, env=env)
    return list(json.loads(done.stdout))


def measure(size: int) -> list[str]:
    """Grade a class with two workers: a row of the table."""
    with tempfile.TemporaryDirectory() as home:
        metered(Path(home), 4)  # What is compiled once is no cost of a class.
        everything, alone, memory = metered(Path(home), size)
    return [f"{size}", "at once", f"{1000 * everything / size:.1f}", f"{1000 * alone / size:.1f}", f"{memory:.0f}"]


def plot() -> None:
    """Draw cost and memory against the size of the class."""
    from matplotlib.figure import Figure

    sizes, _, costs, _, memory = zip(*list(csv.reader(TABLE.open(encoding="utf-8")))[1:], strict=True)
    sizes = [float(size) for size in sizes]
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(sizes, [float(cost) for cost in costs], "o-", label="at once")
    right.plot(sizes, [float(one) for one in memory], "o-", label="at once")
    steps = [min(sizes) * (max(sizes) / min(sizes)) ** (step / 50) for step in range(51)]
    right.plot(steps, [LEAST + EACH * size for size in steps], color="0.5", label="60 MB + 20 kB a student")
    left.set(xscale="log", ylim=(0, None), xlabel="students", ylabel="CPU a log, workers and driver [ms]")
    left.set_title("few logs bear the start of the tool")
    right.set(xscale="log", yscale="log", xlabel="students", ylabel="memory of the driver [MB]")
    left.legend(fontsize=7)
    right.legend(fontsize=7)
    figure.savefig(FIGURE, dpi=150, metadata={"Software": None})


if __name__ == "__main__":
    for size in map(int, sys.argv[1:]):
        row = measure(size)
        print(*row, sep=", ", flush=True)
        with TABLE.open("a", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerow(row)
    plot()
