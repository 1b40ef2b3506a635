"""How times are taken: CPU time in interleaved rounds, the least of them, with quartiles; and on what machine."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from msgspec import Struct

from gyrodata.benchmark.effort import Clock

MOST_APART = 0.3
"""Wall and CPU time may differ by this share; where they do by more, others had the processor, and no ratio is told."""

_LEAST = 1e-9
"""A time is never zero, whatever the clock's steps [s]."""


class Timing(Struct, frozen=True):
    """The times that a thing took, one in each round."""

    cpu: tuple[float, ...]
    """CPU time [s]; the same round has the same place in all that took turns."""
    wall: tuple[float, ...]
    """[s]"""

    @property
    def seconds(self) -> float:
        """The least CPU time [s]: what others on the machine only ever lengthen."""
        return min(self.cpu)

    @property
    def quartiles(self) -> tuple[float, float]:
        """Of the CPU times [s]."""
        low, high = np.quantile(self.cpu, (0.25, 0.75))
        return float(low), float(high)

    @property
    def apart(self) -> float:
        """By which share the least wall time differs from the least CPU time [1]."""
        one, other = sorted((min(self.cpu), min(self.wall)))
        return other / one - 1

    def over(self, other: Timing) -> str:
        """How many times as long as another that took turns with it: median and quartiles of the rounds; or why not."""
        worst = max(self.apart, other.apart)
        if worst > MOST_APART:
            return f"not told: wall and CPU time differ by {100 * worst:.0f} %"
        low, ratio, high = np.quantile(np.array(self.cpu) / np.array(other.cpu), (0.25, 0.5, 0.75))
        return f"{_two(ratio)} ({_two(low)} to {_two(high)})"


def _two(value: float) -> str:
    """Write a number with two digits."""
    return f"{float(f'{value:.2g}'):g}"


class Task(Struct, frozen=True):
    """Something to be timed."""

    run: Callable[[], object]
    calls: int = 1
    """So many calls between two looks at the clock."""
    share: float = 1.0
    """What a call's time is multiplied by."""


def time_in_turns(tasks: Sequence[Task], rounds: int, clock: Clock, wall: Clock, tries: int = 1) -> list[Timing]:
    """Time all tasks round after round, so that a slow minute of the machine meets them all alike.

    One that was interrupted is tried again, so many times at most.
    """
    cpu: list[list[float]] = [[] for _ in tasks]
    outer: list[list[float]] = [[] for _ in tasks]
    for _ in range(rounds):
        for i, task in enumerate(tasks):
            for _ in range(tries):
                spent, waited = _time_once(task, clock, wall)
                if waited < (1 + MOST_APART) * spent:
                    break
            cpu[i].append(spent)
            outer[i].append(waited)
    return [Timing(tuple(own), tuple(waited)) for own, waited in zip(cpu, outer, strict=True)]


def _time_once(task: Task, clock: Clock, wall: Clock) -> tuple[float, float]:
    """CPU time and wall time of one call [s]."""
    seen, begun = wall(), clock()
    for _ in range(task.calls):
        task.run()
    spent, waited = clock() - begun, wall() - seen
    return max(spent, _LEAST) * task.share / task.calls, max(waited, _LEAST) * task.share / task.calls


def describe_machine() -> str:
    """What times depend on, as it is now, in one line: processor, versions, threads and load."""
    from importlib.metadata import version

    versions = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy"))
    threads = os.environ.get("OMP_NUM_THREADS") or os.environ.get("OPENBLAS_NUM_THREADS") or "any number"
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return (
        f"{_processor()}, {os.cpu_count()} cores; Python {platform.python_version()}, {versions}; "
        f"threads for linear algebra: {threads}{load}"
    )


def _processor() -> str:
    """The processor's name, as far as the system tells it without a command."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, "") or platform.processor() or platform.machine()
