"""Where fits begin to fail: one thing is made worse, step by step, and coverage and error are followed.

A fit fails where its 95 % interval holds the truth in less than 92 % of the labs, or where its error is more than twice
the Cramér–Rao bound; each by more than twice what chance does in so many labs. Along a curve the same random numbers
are drawn again, as far as the labs are alike: what changes is what is made worse.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.benchmark.effort import Effort, Progress
from gyrodata.benchmark.estimators import ESTIMATORS
from gyrodata.benchmark.trials import HONEST, SCENES, LabScene, Trial, apply_all, judge
from gyrodata.physics import RPM
from gyrodata.simulation import EXACT, Design
from gyrodata.units import Uncertainty

MOST_ROWS = 200
"""So many runs at a point, for each lab that is asked for: labs of more runs than this are fewer …"""

FEWEST = 30
"""… but so many at least."""

FAR = 2.0
"""An error of more than this over the Cramér–Rao bound is a failure [1]."""


class CurvePoint(Struct, frozen=True):
    """All fits of a curve at one value of what is made worse."""

    x: float
    labs: int
    bound: float
    """Cramér–Rao bound of the error of I_zz over I_zz [1]."""
    trials: tuple[Trial, ...]

    def of(self, estimator: str) -> Trial:
        """The trial of one estimator."""
        return next(trial for trial in self.trials if trial.estimator == estimator)

    def fails(self, estimator: str) -> bool:
        """Whether a fit is too sure, or much too far off, here."""
        trial = self.of(estimator)
        return trial.coverage < HONEST[0] - 2 * trial.chance or trial.rmse - 2 * trial.rmse_u > FAR * self.bound


class FitCurve(Struct, frozen=True):
    """Fits, while one thing is made worse."""

    name: str
    title: str
    words: str
    x_label: str
    estimators: tuple[str, ...]
    points: tuple[CurvePoint, ...]

    def first_failure(self, estimator: str) -> float | None:
        """Where a fit fails first, from the side on which most is well; None where it never does."""
        return next((point.x for point in self.points if point.fails(estimator)), None)


class _Plan(Struct, frozen=True):
    name: str
    title: str
    words: str
    x_label: str
    values: tuple[float, ...]
    """The best first."""
    scene: Callable[[float], LabScene]
    estimators: tuple[str, ...]


_USUAL = SCENES[0]
_LINES = ("M on P, constant", "York, constant", "full cov., constant", "recommended")


def _by_imbalance(share: float) -> LabScene:
    return replace(_USUAL, imbalance=share)


def _by_sharing(share: float) -> LabScene:
    """Give every run an error of 1 %, a part of whose square is the tachometer's, which all runs share."""
    own, shared = (Uncertainty(0.0, 0.01 * math.sqrt(part)) for part in (1 - share, share))
    none = Uncertainty(0.0, 1e-6)
    return replace(_USUAL, stated={**EXACT, "u_spin": own if share < 1 else none, "u_spin_scale": shared})


def _by_runs(runs: float) -> LabScene:
    """Take three weights in turn for an odd number of runs, two for an even one."""
    count = int(runs)
    masses = (0.020, 0.040, 0.060) if count % 2 else (0.020, 0.060)
    spins = tuple(rpm * RPM for rpm in (200, 400, 600, 300, 500))
    design = Design(masses, spins=spins, repeats=math.ceil(count / len(masses) / len(spins)))
    # One row of each weight after another; a weight's rows have the spins in turn.
    rows = np.arange(len(masses) * len(spins) * design.repeats).reshape(len(masses), len(spins), -1)
    order = tuple(np.transpose(rows, (2, 1, 0)).ravel()[:count].tolist())
    return replace(_USUAL, design=design, order=order)


def _by_miscounts(wrong: float) -> LabScene:
    return replace(_USUAL, design=Design(repeats=2), imbalance=0.0, miscounts=int(wrong))


def _by_click(seconds: float) -> LabScene:
    return replace(_USUAL, hand=seconds / 0.14)


def _by_spins(times: float) -> LabScene:
    spins = tuple(float(400 * RPM * times**power) for power in (-0.5, 0.0, 0.5))
    return replace(_USUAL, design=Design(spins=spins))


_PLANS = (
    _Plan(
        "imbalance", "imbalance", "9 runs, weights on one side", "M0 over the lightest torque [%]",
        (0.0, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0), lambda x: _by_imbalance(x / 100),
        ("full cov., origin", "pretest", *_LINES[1:]),
    ),
    _Plan(
        "sharing", "shared errors", "each run is off by 1 %", "part of the variance that runs share [%]",
        (0.0, 5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 100.0), lambda x: _by_sharing(x / 100), _LINES,
    ),
    _Plan(
        "runs", "number of runs", "odd: three weights; even: two", "number of runs",
        (3, 4, 5, 6, 9, 10, 31, 100, 301, 1000, 3000), _by_runs, (*_LINES[:3], "full cov., iterated", "recommended"),
    ),
    _Plan(
        "miscounts", "wrong counts", "18 runs, half or double; M0 = 0", "runs with a wrong count",
        (0, 1, 2, 3, 4, 5, 6, 7, 8), _by_miscounts,
        ("median of ratios", "Huber", "full cov., constant", "recommended"),
    ),
    _Plan(
        "click", "click error", "0.14 s is usual, the log silent", "true error of a time [s]",
        (0.03, 0.07, 0.14, 0.2, 0.3, 0.5, 1.0, 2.0), _by_click, ("ODR, constant", *_LINES[1:]),
    ),
    _Plan(
        "spins", "spin range", "three spins about 400 rpm", "highest spin over lowest",
        (1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0), _by_spins, _LINES,
    ),
)  # fmt: skip


def follow_fits(effort: Effort, seed: int = 1, progress: Progress | None = None) -> list[FitCurve]:
    """Follow fits while labs become worse, one thing at a time."""
    whole, done, curves = sum(len(plan.values) for plan in _PLANS), 0, []
    for plan in _PLANS:
        points = []
        for x in plan.values:
            points.append(_try_point(plan, x, effort.curve_labs, seed))
            done += 1
            if progress is not None:
                progress(done / whole)
        curves.append(FitCurve(plan.name, plan.title, plan.words, plan.x_label, plan.estimators, tuple(points)))
    return curves


def _try_point(plan: _Plan, x: float, labs: int, seed: int) -> CurvePoint:
    scene = plan.scene(x)
    count = len(scene.at_work().runs)
    drawn = scene.draw(min(labs, max(MOST_ROWS * labs // count, FEWEST)), seed)
    trials = judge(apply_all({name: ESTIMATORS[name] for name in plan.estimators}, drawn))
    return CurvePoint(x, len(drawn.time), scene.bound(), trials)
