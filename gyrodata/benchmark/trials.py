"""The estimators tried out: simulated labs with a known truth, four kinds of them.

All labs are of one design, three weights at three spins, on either side of the ball, so that the residual torque is
told by the runs and not assumed. What a lab with weights on one side only makes of the first scene is told too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from gyrodata.benchmark.effort import Clock, Effort, Progress
from gyrodata.benchmark.estimators import ESTIMATORS, Answer
from gyrodata.measurements import Measurements, measure
from gyrodata.physics import Floats
from gyrodata.simulation import EXACT, TYPICAL, Design, Truth, simulate
from gyrodata.units import Uncertainty

HONEST = 0.935
"""Least coverage of a 95 % interval that is still called honest [1]."""

_TEXTBOOK = {**EXACT, "u_time": Uncertainty(0.14), "u_spin": Uncertainty(0.0, 0.002)}
_BOTH_SIDES = Design(positions=(0.15, -0.15))


@dataclass(frozen=True, slots=True)
class LabScene:
    """A kind of lab."""

    name: str
    title: str
    words: str
    """What is wrong with its readings."""
    truth: Truth
    noise: Mapping[str, Uncertainty]
    design: Design = _BOTH_SIDES
    miscounted: bool = False
    """One run of each lab, and its turns are written down as half or double."""


SCENES = (
    LabScene("textbook", "textbook noise", "every error independent: click 0.14 s, spin 0.2 %",
             Truth(imbalance=0.0), _TEXTBOOK),
    LabScene("imbalance", "imbalance and timing bias", "M0 = 1 mN·m, 3 % of the lightest torque; the hand "
             "late by ± 0.1 s", Truth(imbalance=1e-3), {**TYPICAL, "u_time_bias": Uncertainty(0.1)}),
    LabScene("shared", "shared errors", "one ruler, scale, tachometer and hand for all runs",
             Truth(imbalance=0.0), TYPICAL),
    LabScene("miscount", "one wrong count", "the same, and one run's turns are written down as half or double",
             Truth(imbalance=0.0), TYPICAL, miscounted=True),
)  # fmt: skip
"""The four charts."""

ONE_SIDE = LabScene(
    "one side", "textbook noise, weights on one side", "every error independent, and no residual torque",
    Truth(imbalance=0.0), _TEXTBOOK, Design(),
)  # fmt: skip
"""Where the runs hardly tell the residual torque, so that assuming that there is none pays, if there is none."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One estimator in one kind of lab."""

    estimator: str
    rmse: float
    """Root mean square of I_zz over the true one, minus 1 [1]."""
    bias: float
    """Mean of the same [1]."""
    coverage: float
    """Part of the labs whose 95 % interval holds the true I_zz [1]."""
    half: float
    """Mean half-width of those intervals over the true I_zz [1]."""
    seconds: float
    """For one fit [s]."""
    better: bool
    """True if its squared errors are smaller than the recommended fit's, by twice their standard error."""
    failed: int
    """Labs without an answer."""
    labs: int

    @property
    def honest(self) -> bool:
        """Whether the coverage is `HONEST`, to within its standard error in so many labs."""
        return self.coverage >= HONEST - math.sqrt(HONEST * (1 - HONEST) / self.labs)


@dataclass(frozen=True, slots=True)
class TrialPanel:
    """All estimators in one kind of lab."""

    scene: LabScene
    labs: int
    trials: tuple[Trial, ...]

    @property
    def best(self) -> Trial | None:
        """The smallest root mean square error among the honest; the recommended fit where none is truly smaller.

        None where no estimator is honest.
        """
        honest = [trial for trial in self.trials if trial.honest and not trial.failed]
        mine = [trial for trial in honest if trial.estimator == "recommended"]
        if mine and not any(trial.better for trial in honest):
            return mine[0]
        return min(honest, key=lambda trial: trial.rmse, default=None)

    @property
    def recommended(self) -> Trial:
        """The tool's own."""
        return self.of("recommended")

    def of(self, estimator: str) -> Trial:
        """The trial of one estimator."""
        return next(trial for trial in self.trials if trial.estimator == estimator)


def run_trials(effort: Effort, clock: Clock, seed: int = 1, progress: Progress | None = None) -> list[TrialPanel]:
    """Try every estimator in every kind of lab.

    Parameters
    ----------
    effort : Effort
    clock : callable
        Time in seconds.
    seed : int
        Of the labs.
    progress : callable, optional
        Told the part that is done.

    Returns
    -------
    list of TrialPanel
        For `SCENES`, and then `ONE_SIDE`, with a fifth of the labs.
    """
    plan = [(scene, effort.labs) for scene in SCENES] + [(ONE_SIDE, max(1, effort.labs // 5))]
    whole, done = sum(labs for _, labs in plan), 0
    panels = []
    for scene, labs in plan:

        def tell(lab: int, before: int = done) -> None:
            if progress is not None:
                progress((before + lab) / whole)

        panels.append(_try_scene(scene, labs, clock, seed, tell))
        done += labs
    return panels


def _try_scene(scene: LabScene, labs: int, clock: Clock, seed: int, tell: Callable[[int], None]) -> TrialPanel:
    answers: dict[str, list[Answer]] = {name: [] for name in ESTIMATORS}
    seconds = dict.fromkeys(ESTIMATORS, 0.0)
    for lab, measured in enumerate(_labs(scene, labs, seed)):
        if not lab:
            _warm_up(measured)
        for name, estimate in ESTIMATORS.items():
            begun = clock()
            try:
                answer = estimate(measured)
            except (ValueError, ArithmeticError):
                answer = Answer(math.nan, None)
            seconds[name] += clock() - begun
            answers[name].append(answer)
        tell(lab + 1)
    return TrialPanel(scene, labs, _judge(answers, seconds, scene.truth.inertia, labs))


def _warm_up(measured: Measurements) -> None:
    """Let every estimator load what it needs, which is no part of its time."""
    for estimate in ESTIMATORS.values():
        with suppress(ValueError, ArithmeticError):
            estimate(measured)


def _labs(scene: LabScene, labs: int, seed: int) -> Iterator[Measurements]:
    for lab in range(labs):
        random = np.random.default_rng((seed, lab))
        measured = measure(simulate(scene.truth, scene.design, scene.noise, int(random.integers(2**31))).readings)
        if scene.miscounted:
            turns = measured.turns.copy()
            turns[random.integers(len(turns))] *= random.choice((0.5, 2.0))
            measured = replace(measured, turns=turns)
        yield measured


def _judge(
    answers: Mapping[str, list[Answer]], seconds: Mapping[str, float], truth: float, labs: int
) -> tuple[Trial, ...]:
    """Compare the answers with the truth, and the squared errors lab by lab with those of the recommended fit."""
    off = {name: np.array([answer.value / truth - 1 for answer in found]) for name, found in answers.items()}
    mine = off["recommended"] ** 2
    trials = []
    for name, found in answers.items():
        half = np.array([np.nan if answer.half is None else answer.half / truth for answer in found])
        told = np.isfinite(off[name])
        gain = (mine - off[name] ** 2)[told]
        trials.append(
            Trial(
                estimator=name,
                rmse=math.sqrt(float(np.mean(off[name][told] ** 2))),
                bias=float(np.mean(off[name][told])),
                coverage=float(np.mean(np.abs(off[name]) <= half)),
                half=float(np.nanmean(half)),
                seconds=max(seconds[name], 1e-9) / labs,
                better=_clearly_positive(gain),
                failed=int(np.sum(~told)),
                labs=labs,
            )
        )
    return tuple(trials)


def _clearly_positive(differences: Floats) -> bool:
    """Whether a mean is above zero by twice its standard error."""
    if len(differences) < 2:
        return False
    return float(differences.mean()) > 2 * float(differences.std(ddof=1)) / math.sqrt(len(differences))
