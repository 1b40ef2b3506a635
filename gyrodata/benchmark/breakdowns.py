"""Logs on which estimators break: who says so, and who gives nonsense without a word.

Each case is a simulated log, drawn several times. The textbook's estimators get what a student would work out of
it; the tool gets the log. An estimator that stops with an error or a warning, or gives no number or no interval,
has said so; one that is far off with an interval that misses the truth has not.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from gyrodata.benchmark.effort import Effort, Progress
from gyrodata.benchmark.estimators import ESTIMATORS, Answer, Estimator, recommended
from gyrodata.errors import GyroError
from gyrodata.measurements import Measurements, measure, select
from gyrodata.readings import read_log
from gyrodata.simulation import TYPICAL, Design, Simulation, Truth, simulate
from gyrodata.units import Uncertainty

_RPM = math.pi / 30

Verdict = Literal["holds", "wide", "says so", "too sure", "nonsense"]
"""Right; right, with an interval that tells next to nothing; no answer, and says it; near the truth with an interval
that is too small; wrong without a word."""

_USELESS = 0.5
"""A half-width of an interval beyond this part of I_zz tells next to nothing [1]."""

_FAR = 0.05
"""An error beyond this part of I_zz [1], with an interval that misses the truth in most draws, is nonsense."""


@dataclass(frozen=True, slots=True)
class Breakdown:
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


@dataclass(frozen=True)
class _Log:
    """What a case makes of one draw."""

    text: bytes
    """The log."""
    students: Measurements
    """What a student works out of it."""


def polyfit(measured: Measurements) -> Answer:
    """``numpy.polyfit`` of M on P with a constant, interval from its covariance."""
    with_scatter = len(measured.runs) > 4
    if with_scatter:
        slopes, covariance = np.polyfit(measured.product, measured.torque, 1, cov=True)
        return Answer(float(slopes[0]), 1.96 * math.sqrt(covariance[0, 0]))
    return Answer(float(np.polyfit(measured.product, measured.torque, 1)[0]), None)


def linregress(measured: Measurements) -> Answer:
    """``scipy.stats.linregress`` of M on P."""
    from scipy.special import stdtrit
    from scipy.stats import linregress as regress

    line = regress(measured.product, measured.torque)
    freedom = len(measured.runs) - 2
    half = float(stdtrit(freedom, 0.975)) * float(line.stderr) if freedom > 0 else None
    return Answer(float(line.slope), half)


STUDENTS: Mapping[str, Estimator] = {
    "numpy.polyfit": polyfit,
    "scipy linregress": linregress,
    **{name: estimate for name, estimate in ESTIMATORS.items() if name != "recommended"},
}
"""All but the tool's own."""


def try_breakdowns(effort: Effort, seed: int = 1, progress: Progress | None = None) -> list[Breakdown]:
    """Try every estimator in every case.

    Parameters
    ----------
    effort : Effort
    seed : int
        Of the draws.
    progress : callable, optional
        Told the part that is done.

    Returns
    -------
    list of Breakdown
        Case by case.
    """
    found = []
    for i, (case, draw) in enumerate(CASES.items()):
        answers: dict[str, list[Answer | None]] = {name: [] for name in (*STUDENTS, "recommended")}
        for k in range(effort.draws):
            log = draw(int(np.random.default_rng((seed, k)).integers(2**31)))
            for name, estimate in STUDENTS.items():
                answers[name].append(_asked(estimate, log.students))
            answers["recommended"].append(_asked_tool(log.text))
        found += [_judge(name, case, given) for name, given in answers.items()]
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


def _judge(estimator: str, case: str, answers: list[Answer | None]) -> Breakdown:
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


def _simulated(seed: int, truth: Truth | None = None, design: Design | None = None, **noise: Uncertainty) -> _Log:
    made = simulate(truth or Truth(imbalance=0.0), design or Design(), {**TYPICAL, **noise}, seed)
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
    made = simulate(Truth(imbalance=0.0), Design(masses=(0.04,), spins=(400 * _RPM,)), TYPICAL, seed)
    return _Log(_edited(made, (0, 0, 0), {}), select(measure(made.readings), (0, 0, 0)))


CASES: Mapping[str, Callable[[int], _Log]] = {
    "one torque": partial(_simulated, design=Design(masses=(0.04,), repeats=3)),
    "identical runs": _identical,
    "two runs": partial(_simulated, design=Design(masses=(0.02, 0.06), spins=(400 * _RPM,))),
    "one run": partial(_simulated, design=Design(masses=(0.04,), spins=(400 * _RPM,))),
    "run without torque": _unloaded,
    "times to 7–20 %": partial(
        _simulated, design=Design(spins=(200 * _RPM,), turns=(1 / 6,), repeats=5), u_time=Uncertainty(0.22)
    ),
    "sign lost": _sign_lost,
    "wrong count": _miscounted,
}
"""By the name in the chart, a draw for a seed."""
