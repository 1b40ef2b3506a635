"""All of the benchmark: what is measured, in order."""

from __future__ import annotations

from dataclasses import dataclass

from gyrodata.benchmark.breakdowns import Breakdown, try_breakdowns
from gyrodata.benchmark.effort import Clock, Effort, Progress
from gyrodata.benchmark.maps import MapPair
from gyrodata.benchmark.motion import MotionPanel, run_motion
from gyrodata.benchmark.roots import map_roots
from gyrodata.benchmark.steppers import map_integrators
from gyrodata.benchmark.trials import TrialPanel, run_trials
from gyrodata.benchmark.upright import Passage, pass_upright


@dataclass(frozen=True)
class Benchmark:
    """What was measured."""

    motion: list[MotionPanel]
    trials: list[TrialPanel]
    """The four scenes of the chart, and the lab with weights on one side."""
    roots: list[MapPair]
    integrators: list[MapPair]
    passages: list[Passage]
    breakdowns: list[Breakdown]


def run_benchmark(effort: Effort, clock: Clock, seed: int = 1, progress: Progress | None = None) -> Benchmark:
    """Measure speed, accuracy and stability.

    Parameters
    ----------
    effort : Effort
        `QUICK` or `FULL`.
    clock : callable
        Time in seconds, as `time.perf_counter`; all but the times is the same on every run.
    seed : int
        Of the simulated labs.
    progress : callable, optional
        Told the part that is done.

    Returns
    -------
    Benchmark
    """

    def part(begin: float, end: float) -> Progress:
        return lambda done: None if progress is None else progress(begin + (end - begin) * done)

    return Benchmark(
        motion=run_motion(effort, clock, seed, part(0.0, 0.25)),
        trials=run_trials(effort, clock, seed, part(0.25, 0.7)),
        roots=map_roots(effort),
        integrators=map_integrators(effort, part(0.7, 0.8)),
        passages=pass_upright(effort, part(0.8, 0.9)),
        breakdowns=try_breakdowns(effort, seed, part(0.9, 1.0)),
    )
