"""Real runs with workers, of which the driver or one worker is killed at a random time."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from faults.scenes import GRADE, a_class, contents, differing

ROOT = Path(__file__).parents[2]


def start(home: Path) -> subprocess.Popen[bytes]:
    """Start to grade the class of a folder with two workers."""
    line, env = [sys.executable, "-m", "gyrodata", *GRADE, "--workers", "2"], {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(line, cwd=home, env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def below(process: int) -> Iterator[int]:
    """Give the processes that a process has started, and those that they have."""
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, ValueError, IndexError):
            if int((folder / "stat").read_text().rpartition(")")[2].split()[1]) == process:
                yield int(folder.name)
                yield from below(int(folder.name))


def try_kills(room: Path, count: int, seed: int) -> Iterator[str]:
    """Kill drivers and workers in turn, so many in all, and give what is wrong after the next run."""
    draw = random.Random(seed)
    a_class(room / "whole", 20)
    begun, driver = time.perf_counter(), start(room / "whole")
    told = driver.communicate()[1]
    assert driver.returncode == 0, told
    took, whole = time.perf_counter() - begun, contents(room / "whole" / "grades")
    for number in range(count):
        home = room / f"{number}"
        shutil.copytree(room / "whole" / "class", home / "class")
        driver, wait = start(home), draw.uniform(0.1, took)
        time.sleep(wait)
        # Behind the first two are those that grade: these two keep house for them.
        others = sorted(below(driver.pid))[2:] if number % 2 else []
        victim = draw.choice(others) if others else driver.pid
        with suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
        told = driver.communicate()[1].decode("utf-8", "replace")
        where = f"kill {number} of the {'driver' if victim == driver.pid else 'worker'} after {wait:.2f} s"
        if victim != driver.pid and (driver.returncode != 0 or "Traceback" in told):
            yield f"{where}: exit code {driver.returncode}: {told[-300:]}"
        again = start(home)
        told = again.communicate()[1].decode("utf-8", "replace")
        if again.returncode != 0:
            yield f"{where}: the next run ends with {again.returncode}: {told[-300:]}"
        if wrong := differing(contents(home / "grades"), whole):
            yield f"{where}: after the next run these are not as they should be: {wrong}"
        shutil.rmtree(home)
