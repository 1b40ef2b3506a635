"""How much work a benchmark does, and how it takes times."""

from __future__ import annotations

from collections.abc import Callable

from msgspec import Struct

Clock = Callable[[], float]
"""Time in seconds, as `time.process_time`."""


class Effort(Struct, frozen=True):
    """How many points a benchmark has, and how often each is tried."""

    motion_labs: int
    """Simulated labs for the models of the motion."""
    turns: int
    """Turns about the vertical of a long motion."""
    evaluations: int
    """An integrator may take about so many evaluations of the torque for one turn, and √n times as many for n turns."""
    labs: int
    """Simulated labs for the estimators."""
    repeats: int = 5
    """How often a time is taken."""


QUICK = Effort(motion_labs=40, turns=50, evaluations=20_000, labs=120)
"""Less than a minute."""

FULL = Effort(motion_labs=200, turns=200, evaluations=100_000, labs=2000)
"""Some minutes."""


def time_of(task: Callable[[], object], clock: Clock, repeats: int) -> float:
    """Take the least CPU time of a task [s]: what else the machine does only ever lengthens it."""
    least = float("inf")
    for _ in range(repeats):
        begun = clock()
        task()
        least = min(least, clock() - begun)
    return max(least, 1e-9)
