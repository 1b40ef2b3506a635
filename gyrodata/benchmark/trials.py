"""The estimators tried out on simulated labs with a known truth, and on logs that break them.

A scene is a kind of lab: what is done, what its log says of its errors, and what is true. Its labs are drawn from the
sources of error of its own log, and from what the log does not know. Beside the errors of the estimators stands the
Cramér–Rao bound of the scene: no estimator without knowledge from elsewhere can do better.

Each case of `try_breakdowns` is a simulated log, drawn several times. The textbook's estimators get what a student
would work out of it; the tool gets the log. An estimator that stops with an error or a warning, or gives no number or
no interval, has said so; one that is far off with an interval that misses the truth has not.
"""

from __future__ import annotations

import math
import warnings
import zlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.benchmark.effort import Clock, Effort, Progress
from gyrodata.benchmark.estimators import (
    ESTIMATORS,
    READ,
    STUDENTS,
    Answer,
    Estimator,
    one_lab,
    recommended,
    stated_errors,
    straight_line,
)
from gyrodata.benchmark.timing import Task, Timing, time_in_turns
from gyrodata.errors import GyroError
from gyrodata.measurements import Measurements, measure, select
from gyrodata.physics import RPM, Floats
from gyrodata.readings import read_log
from gyrodata.simulation import EXACT, TYPICAL, Design, Simulation, Truth, simulate
from gyrodata.units import Uncertainty

HONEST = 0.92, 0.98
"""Coverage of a 95 % interval that is called honest [1]: with less it is too sure, with more too wide."""

TIE = 1.03
"""Root mean square errors within this factor are as good."""


_MIXED = 0, 4, 8, 1, 5, 6, 2, 3, 7
"""When each of three weights at three spins is run: no weight before the others as a whole."""


class LabScene(Struct, frozen=True):
    """A kind of lab."""

    name: str
    title: str
    words: str
    """What is done, and what is wrong with its readings."""
    design: Design = Design()
    order: tuple[int, ...] | None = None
    """Which runs of the design are done, in their order; None: each once."""
    stated: Mapping[str, Uncertainty] | None = None
    """What the log says of its errors; None: nothing, so that they are taken as usual."""
    imbalance: float = 0.025
    """M0 over the lightest torque [1]; published balls have a median of 0.025 …"""
    drift: float = 0.0
    """… and its rise from the first of nine runs to the last, the weights in mixed order [1]."""
    hand: float = 1.0
    """The stopwatch errs so many times as wide as the log says …"""
    tails: int | None = None
    """… by a Student's t with so many degrees of freedom; None: normal."""
    sighting: float = 1.0
    """The angles err so many times as wide as the log says."""
    miscounts: int = 0
    """So many runs of each lab have half or twice their turns written down."""

    @property
    def as_stated(self) -> bool:
        """Whether all errors are as the log says."""
        return (self.drift, self.hand, self.tails, self.sighting, self.miscounts) == (0.0, 1.0, None, 1.0, 0)

    def at_work(self) -> Measurements:
        """Read a log of the design without errors."""
        truth = Truth(imbalance=self.residual, timing_bias=0.0)
        made = simulate(truth, self.design, TYPICAL if self.stated is None else self.stated, None)
        lines = [line for line in made.log.splitlines() if self.stated is not None or not line.startswith("# u_")]
        measured = measure(read_log("\n".join(lines).encode()))
        return measured if self.order is None else select(measured, self.order)

    @property
    def residual(self) -> float:
        """M0 [N*m]."""
        return self.imbalance * min(self.design.masses) * min(map(abs, self.design.positions)) * Truth().g

    def draw(self, labs: int, seed: int) -> Measurements:
        """Draw so many labs: the readings have shape (L, n); a lab with a time below zero is none, and left out."""
        exact = self.at_work()
        random = np.random.default_rng((seed, zlib.crc32(self.name.encode())))
        shape = labs, len(exact.runs)
        time = exact.time * exact.torque / (exact.torque + self._drifts(exact))
        true = {name: np.broadcast_to(getattr(exact, name), shape) for name in READ} | {"time": time}
        read = {name: np.broadcast_to(values, shape).copy() for name, values in true.items()}
        for source in exact.sources:
            if source.quantity not in READ:
                continue
            drawn = random.standard_normal((labs, source.groups.max() + 1))[:, source.groups]
            if source.name == "time":
                tails = self.tails
                drawn = self.hand * (drawn if tails is None else random.standard_t(tails, shape))
            # Errors are in proportion to the true value.
            off = (source.absolute + source.relative * true[source.quantity]) * drawn * (source.groups >= 0)
            if source.quantity == "turns":
                # Who sights the rod too far along stops late.
                read["time"] += self.sighting * time * off / exact.turns
            else:
                read[source.quantity] += off
        read["time"] += exact.timing_bias_u * random.standard_normal((labs, 1))
        wrong = random.permuted(np.broadcast_to(np.arange(shape[1]) < self.miscounts, shape), axis=1)
        read["turns"] *= np.where(wrong, random.choice((0.5, 2.0), shape), 1.0)
        possible = (read["time"] > 0).all(axis=1)
        read = {name: values[possible] for name, values in read.items()}
        return replace(exact, **read, torque=read["mass"] * read["position"] * exact.g)

    def _drifts(self, exact: Measurements) -> Floats:
        """By how much M0 is off its mean in each run [N*m]."""
        if not self.drift:
            return np.zeros(len(exact.runs))
        session = np.linspace(-0.5, 0.5, len(_MIXED))[list(_MIXED)]
        return np.asarray(self.drift * np.abs(exact.torque).min() * session)

    def bound(self, balanced: bool = False) -> float:
        """Cramér–Rao bound on the error of I_zz over I_zz, M0 unknown, or known; shared errors by their widths.

        Of labs without what nobody can know: a drift, or wrong counts.
        """
        exact = self.at_work()
        # Fisher's information of a Student's t, for which a normal distribution of this width has as much.
        wide = 1.0 if self.tails is None else math.sqrt((self.tails + 3) / (self.tails + 1))
        errors = stated_errors(exact, {"time": wide * self.hand, "angle": self.sighting})
        torque = exact.torque + (self.residual if balanced else 0.0)
        return float(straight_line(exact.product, torque, errors, intercept=not balanced).u) / Truth().inertia


_ALONE = {**EXACT, "u_time": Uncertainty(0.14), "u_spin": Uncertainty(0.0, 0.002)}
_STATED = {**TYPICAL, "u_time_bias": Uncertainty(0.08)}
_THIRDS = Design(turns=(1 / 3,))

SCENES = (
    LabScene("usual", "the usual lab", "9 runs, weights on one side, M0 = 2.5 % of the lightest torque"),
    LabScene("both sides", "both sides", "18 runs, weights on both sides of the ball",
             Design(positions=(0.15, -0.15))),
    LabScene("3 runs", "3 runs", "three weights at one spin", Design(spins=(400 * RPM,))),
    LabScene("27 runs", "27 runs", "each of the nine runs three times", Design(repeats=3)),
    LabScene("balanced", "no imbalance", "M0 = 0, which nobody knows", imbalance=0.0),
    LabScene("imbalance", "imbalance", "M0 = 10 % of the lightest torque", imbalance=0.1),
    LabScene("alone", "independent", "every error independent and stated, M0 = 0",
             stated=_ALONE, imbalance=0.0),
    LabScene("third", "hand better", "the log states 0.14 s; it is a third of that", stated=_STATED, hand=1 / 3),
    LabScene("threefold", "hand worse", "the log states 0.14 s; it is three times that", stated=_STATED, hand=3.0),
    LabScene("tenfold", "hand far worse", "the log states 0.14 s; it is ten times that", stated=_STATED, hand=10.0),
    LabScene("tails", "heavy tails", "clicks err by a Student's t with 3 degrees of freedom",
             stated=_STATED, tails=3),
    LabScene("sighting", "mark missed", "thirds of a turn, sighted to 3° in place of 1°", _THIRDS, sighting=3.0),
    LabScene("drift", "drift", "M0 rises by 4 % of the lightest torque, runs in mixed order", drift=0.04),
    LabScene("miscount", "wrong count", "one run's turns are written down as half or double", miscounts=1),
)  # fmt: skip
"""The usual lab, others with errors as their logs say, and then those whose logs say what is not so."""

CHARTED = ("usual", "both sides", "threefold", "miscount")
"""Of these time is taken too, for a chart of speed against accuracy."""


class Trial(Struct, frozen=True):
    """One estimator in one kind of lab."""

    estimator: str
    rmse: float
    """Root mean square of I_zz over the true one, minus 1 [1]."""
    rmse_u: float
    """Its standard error in so many labs [1]."""
    bias: float
    """Mean of the same [1]."""
    coverage: float
    """Part of the labs whose 95 % interval holds the true I_zz [1]."""
    half: float
    """Mean half-width of those intervals over the true I_zz [1]."""
    ratio: float
    """RMSE over that of the recommended fit in the same labs [1]."""
    ratio_u: float
    """Its standard error [1]."""
    time: Timing | None
    """None where it was not taken."""
    failed: int
    """Labs without an answer."""
    labs: int

    @property
    def chance(self) -> float:
        """Standard error of a coverage of `HONEST` in so many labs."""
        return math.sqrt(HONEST[0] * (1 - HONEST[0]) / self.labs)

    @property
    def honest(self) -> bool:
        """Whether the coverage is `HONEST`, to within its standard error in so many labs."""
        low, high = HONEST
        return low - self.chance <= self.coverage <= high + self.chance

    @property
    def better(self) -> bool:
        """Whether it is truly closer than the recommended fit."""
        return self.ratio + 2 * self.ratio_u < 1 / TIE

    @property
    def ties(self) -> bool:
        """Whether it is as close as the recommended fit, as far as so many labs tell."""
        return not self.better and self.ratio - 2 * self.ratio_u < TIE


class TrialPanel(Struct, frozen=True):
    """All estimators in one kind of lab."""

    scene: LabScene
    labs: int
    bound: float
    """Cramér–Rao bound of the error of I_zz over I_zz, M0 unknown [1] …"""
    bound_balanced: float
    """… and M0 known [1]."""
    trials: tuple[Trial, ...]

    @property
    def recommended(self) -> Trial:
        """The tool's own."""
        return self.of("recommended")

    @property
    def peers(self) -> list[Trial]:
        """The others that are honest, the closest first."""
        return sorted(
            (one for one in self.trials if one.honest and not one.failed and one.estimator != "recommended"),
            key=lambda one: one.rmse,
        )

    @property
    def best(self) -> Trial | None:
        """The closest of the honest; the recommended fit if none is truly closer. None where no estimator is honest."""
        better = [one for one in self.peers if one.better]
        if better:
            return better[0]
        return self.recommended if self.recommended.honest else next(iter(self.peers), None)

    @property
    def outcome(self) -> str:
        """What comes of the recommended fit beside the honest others, in a few words."""
        mine = self.recommended
        if not mine.honest:
            return f"{'too sure' if mine.coverage < HONEST[0] else 'too wide'}: {100 * mine.coverage:.1f} %"
        if not self.peers:
            return "alone honest"
        closer = [one.estimator for one in self.peers if one.better]
        if closer:
            return f"closer: {closer[0]}"
        ties = [one.estimator for one in self.peers if one.ties]
        if not ties:
            return "closest of honest"
        return f"ties: {ties[0]}" + (f" + {len(ties) - 1}" if len(ties) > 1 else "")

    def of(self, estimator: str) -> Trial:
        """The trial of one estimator."""
        return next(trial for trial in self.trials if trial.estimator == estimator)


_TIMED_LABS = 2


def run_trials(
    effort: Effort, clock: Clock, seed: int = 1, progress: Progress | None = None, wall: Clock | None = None
) -> list[TrialPanel]:
    """Try every estimator in every kind of lab."""
    panels = []
    for i, scene in enumerate(SCENES):
        labs = scene.draw(effort.labs, seed)
        # First, for what it loads is no part of anybody's time.
        answers = apply_all(ESTIMATORS, labs)
        times = _take_times(labs, effort.repeats + 2, clock, wall or clock) if scene.name in CHARTED else {}
        trials = judge(answers, times)
        panels.append(TrialPanel(scene, len(labs.time), scene.bound(), scene.bound(balanced=True), trials))
        if progress is not None:
            progress((i + 1) / len(SCENES))
    return panels


def apply_all(estimators: Mapping[str, Estimator], labs: Measurements) -> dict[str, Answer]:
    """Ask every estimator about L labs; NaN where one has no answer."""
    with np.errstate(all="ignore"):
        return {name: estimate(labs) for name, estimate in estimators.items()}


def _take_times(labs: Measurements, rounds: int, clock: Clock, wall: Clock) -> dict[str, Timing]:
    """Time fits of one lab at a time, every estimator once in each round."""
    several = [one_lab(labs, lab) for lab in range(min(_TIMED_LABS, len(labs.time)))]

    def fit_all(estimate: Estimator) -> None:
        with np.errstate(all="ignore"):
            for measured in several:
                # A log is read anew each time.
                estimate(replace(measured))

    tasks = [Task(partial(fit_all, estimate), share=1 / len(several)) for estimate in ESTIMATORS.values()]
    return dict(zip(ESTIMATORS, time_in_turns(tasks, rounds, clock, wall), strict=True))


def judge(answers: Mapping[str, Answer], times: Mapping[str, Timing] | None = None) -> tuple[Trial, ...]:
    """Compare the answers with the truth, and the squared errors lab by lab with those of the recommended fit."""
    truth = Truth().inertia
    mine = (answers["recommended"].value / truth - 1) ** 2
    trials = []
    for name, answer in answers.items():
        off = answer.value / truth - 1
        told = np.isfinite(off) & np.isfinite(mine)
        squares, own, count = off[told] ** 2, mine[told], max(int(told.sum()), 1)
        rmse, ratio = math.sqrt(float(squares.mean())), math.sqrt(float(squares.mean() / own.mean()))
        covered = (answer.low <= truth) & (truth <= answer.high)
        half = answer.half[np.isfinite(answer.half)] / truth
        trials.append(
            Trial(
                estimator=name,
                rmse=rmse,
                rmse_u=rmse / 2 * float((squares / squares.mean()).std()) / math.sqrt(count),
                bias=float(off[told].mean()),
                coverage=float(covered.mean()),
                half=float(half.mean()) if len(half) else math.nan,
                ratio=ratio,
                ratio_u=ratio / 2 * float((squares / squares.mean() - own / own.mean()).std()) / math.sqrt(count),
                time=(times or {}).get(name),
                failed=int(np.sum(~np.isfinite(off))),
                labs=len(off),
            )
        )
    return tuple(trials)


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
    draws: int


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
        # A warning on the screen is a word too.
        with warnings.catch_warnings(), np.errstate(divide="warn", invalid="warn"):
            warnings.simplefilter("error")
            answer = estimate(measured)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError, RuntimeWarning, np.exceptions.RankWarning):
        return None
    return answer if np.isfinite(answer.value) else None


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
    truth, draws = Truth().inertia, len(answers)
    given = [answer for answer in answers if answer is not None]
    quoted = [answer for answer in given if np.isfinite(answer.half)]
    told = 1 - len(quoted) / draws
    covered = sum(bool(answer.low <= truth <= answer.high) for answer in quoted) / draws
    error = float(np.median([abs(answer.value / truth - 1) for answer in given])) if given else None
    if error is None or told >= 0.5:
        verdict: Verdict = "says so"
    elif covered >= 0.8:
        half = float(np.median([answer.half / truth for answer in quoted]))
        verdict = "holds" if half < _USELESS else "wide"
    else:
        verdict = "nonsense" if covered < 0.5 and error > _FAR else "too sure"
    return Breakdown(estimator, case, verdict, error, covered, told, draws)


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
