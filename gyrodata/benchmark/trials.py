"""The estimators tried out on simulated labs with a known truth, and on logs that break them.

All labs of `run_trials` are of one design, three weights at three spins, on either side of the ball, so that the
residual torque is told by the runs and not assumed. What a lab with weights on one side only makes of the first scene
is told too.

Each case of `try_breakdowns` is a simulated log, drawn several times. The textbook's estimators get what a student
would work out of it; the tool gets the log. An estimator that stops with an error or a warning, or gives no number or
no interval, has said so; one that is far off with an interval that misses the truth has not.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.benchmark.effort import Clock, Effort, Progress
from gyrodata.benchmark.estimators import ESTIMATORS, STUDENTS, Answer, Estimator, recommended
from gyrodata.errors import GyroError
from gyrodata.measurements import Measurements, measure, select
from gyrodata.physics import RPM, Floats
from gyrodata.readings import read_log
from gyrodata.simulation import EXACT, TYPICAL, Design, Simulation, Truth, simulate
from gyrodata.units import Uncertainty

HONEST = 0.935
"""Least coverage of a 95 % interval that is still called honest [1]."""

_TEXTBOOK = {**EXACT, "u_time": Uncertainty(0.14), "u_spin": Uncertainty(0.0, 0.002)}
_BOTH_SIDES = Design(positions=(0.15, -0.15))


class LabScene(Struct, frozen=True):
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


class Trial(Struct, frozen=True):
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


class TrialPanel(Struct, frozen=True):
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
    """Try every estimator in every kind of lab."""
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


# --- logs on which estimators break ----------------------------------------------------------------------------

Verdict = Literal["holds", "wide", "says so", "too sure", "nonsense"]
"""Right; right, with an interval that tells next to nothing; no answer, and says it; near the truth with an interval
that is too small; wrong without a word."""

_USELESS = 0.5
"""A half-width of an interval beyond this part of I_zz tells next to nothing [1]."""

_FAR = 0.05
"""An error beyond this part of I_zz [1], with an interval that misses the truth in most draws, is nonsense."""


class Breakdown(Struct, frozen=True):
    """One estimator in one case."""

    estimator: str
    case: str
    verdict: Verdict
    error: float | None
    """Median distance of I_zz from the true one, over that, of the draws with an answer [1]; None where none has."""
    coverage: float
    """Part of the draws whose 95 % interval holds the true I_zz [1]."""
    told: float
    """Part of the draws in which it said that something is wrong, or gave no interval [1]."""


class _Log(Struct, frozen=True):
    """What a case makes of one draw."""

    text: bytes
    """The log."""
    students: Measurements
    """What a student works out of it."""


def try_breakdowns(effort: Effort, seed: int = 1, progress: Progress | None = None) -> list[Breakdown]:
    """Try every estimator in every case."""
    found = []
    for i, (case, draw) in enumerate(CASES.items()):
        answers: dict[str, list[Answer | None]] = {name: [] for name in (*STUDENTS, "recommended")}
        for k in range(effort.draws):
            log = draw(int(np.random.default_rng((seed, k)).integers(2**31)))
            for name, estimate in STUDENTS.items():
                answers[name].append(_asked(estimate, log.students))
            answers["recommended"].append(_asked_tool(log.text))
        found += [_verdict(name, case, given) for name, given in answers.items()]
        if progress is not None:
            progress((i + 1) / len(CASES))
    return found


def _asked(estimate: Estimator, measured: Measurements) -> Answer | None:
    """What an estimator answers; None where it says that it cannot."""
    try:
        with warnings.catch_warnings():
            # A warning on the screen is a word too.
            warnings.simplefilter("error")
            return estimate(measured)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError, RuntimeWarning, np.exceptions.RankWarning):
        return None


def _asked_tool(text: bytes) -> Answer | None:
    """What the tool answers to a log; None where it refuses it."""
    try:
        readings = read_log(text)
    except GyroError:
        return None
    if any(diagnostic.severity == "error" for diagnostic in readings.diagnostics):
        return None
    return _asked(recommended, measure(readings))


def _verdict(estimator: str, case: str, answers: list[Answer | None]) -> Breakdown:
    truth = Truth().inertia
    given = [answer for answer in answers if answer is not None and math.isfinite(answer.value)]
    off = [answer.value / truth - 1 for answer in given]
    halves = [math.nan if answer.half is None else answer.half / truth for answer in given]
    told = 1 - sum(math.isfinite(half) for half in halves) / len(answers)
    covered = sum(abs(o) <= half for o, half in zip(off, halves, strict=True)) / len(answers)
    quoted = [half for half in halves if math.isfinite(half)]
    error = float(np.median(np.abs(off))) if off else None
    if error is None or told >= 0.5:
        verdict: Verdict = "says so"
    elif covered >= 0.8:
        verdict = "holds" if float(np.median(quoted)) < _USELESS else "wide"
    else:
        verdict = "nonsense" if covered < 0.5 and error > _FAR else "too sure"
    return Breakdown(estimator, case, verdict, error, covered, told)


# --- the cases ----------------------------------------------------------------------------------------------


def _simulated(seed: int, design: Design, **noise: Uncertainty) -> _Log:
    made = simulate(Truth(imbalance=0.0), design, {**TYPICAL, **noise}, seed)
    return _Log(made.log.encode(), measure(made.readings))


def _sign_lost(seed: int) -> _Log:
    log = _simulated(seed, design=Design(positions=(0.15, -0.15)))
    # Stopwatch and tachometer know no sign; the student plots positive products against signed torques.
    return replace(log, students=replace(log.students, sense=np.ones(len(log.students.runs))))


def _edited(made: Simulation, kept: Sequence[int], cells: Mapping[tuple[int, str], str]) -> bytes:
    """The text of a log with some of its runs, in order, and some cells written anew: by row kept and header."""
    lines = made.log.splitlines()
    top = len(lines) - len(made.readings.runs)
    rows = [lines[top + i].split(",") for i in kept]
    headers = [name.split("[")[0].strip() for name in lines[top - 1].split(",")]
    for (row, header), text in cells.items():
        rows[row][headers.index(header)] = text
    return "\n".join([*lines[:top], *(",".join(row) for row in rows)]).encode()


def _unloaded(seed: int) -> _Log:
    """Nine runs, and one without a weight that the residual torque turned by a twelfth of a turn."""
    design = Design(masses=(0.020, 0.040, 0.060, 0.0), turns=(1.0, 1 / 12))
    made = simulate(Truth(imbalance=1e-3), design, TYPICAL, seed)
    kept = [*range(0, 18, 2), 21]
    return _Log(_edited(made, kept, {}), select(measure(made.readings), kept))


def _miscounted(seed: int) -> _Log:
    """One of nine runs was of two turns, and is written down as of one."""
    made = simulate(Truth(imbalance=0.0), Design(turns=(1.0, 2.0)), TYPICAL, seed)
    kept = [*range(0, 8, 2), 9, *range(10, 18, 2)]
    measured = select(measure(made.readings), kept)
    return _Log(_edited(made, kept, {(4, "turns"): "1"}), replace(measured, turns=np.ones(9)))


def _identical(seed: int) -> _Log:
    """One run, written down three times."""
    made = simulate(Truth(imbalance=0.0), Design(masses=(0.04,), spins=(400 * RPM,)), TYPICAL, seed)
    return _Log(_edited(made, (0, 0, 0), {}), select(measure(made.readings), (0, 0, 0)))


CASES: Mapping[str, Callable[[int], _Log]] = {
    "one torque": partial(_simulated, design=Design(masses=(0.04,), repeats=3)),
    "identical runs": _identical,
    "two runs": partial(_simulated, design=Design(masses=(0.02, 0.06), spins=(400 * RPM,))),
    "one run": partial(_simulated, design=Design(masses=(0.04,), spins=(400 * RPM,))),
    "run without torque": _unloaded,
    "times to 7–20 %": partial(
        _simulated, design=Design(spins=(200 * RPM,), turns=(1 / 6,), repeats=5), u_time=Uncertainty(0.22)
    ),
    "sign lost": _sign_lost,
    "wrong count": _miscounted,
}
"""By the name in the chart, a draw for a seed."""
