"""Explanations: the mistakes with which the runs of a log would agree.

An explanation says which readings are wrong: those of single runs, the load of one
weight in all its runs, the turns of whole weights, or none, because the balance
differs between weights. All are judged in the same way: the log is fitted as if the
explanation were true, and the probability of all its times (the evidence of this fit)
is multiplied by how common the mistake is. A reading that an explanation calls wrong
can have every value, so that its probability is small and the same everywhere.

No explanation is tried for a log whose runs agree.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import combinations
from operator import attrgetter, itemgetter
from typing import NamedTuple, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.fitting import Estimate, FitResult, NoFit, Outlier
from gyrodata.judging import corrections
from gyrodata.judging.changes import MOST_RUNS, MOST_WEIGHTS
from gyrodata.judging.corrections import (
    HALF_LOG_2PI,
    USUAL_COUNTS,
    Correction,
    Prediction,
)
from gyrodata.judging.tables import compare_with_ball, load_words, turn_words
from gyrodata.measurements import Measurements, Source
from gyrodata.measurements.checks import other_units, possible_range, unit_size
from gyrodata.measurements.sources import load_role
from gyrodata.physics import Floats
from gyrodata.quantities.error_sources import Quantity
from gyrodata.quantities.numerals import as_read
from gyrodata.readings import Column, Readings

ONE_BALANCE = 1 / 3
"""If M0 is the same with every weight with a smaller probability, the weights do not
agree."""

# --- how common each mistake is ---

WRONG_RUN = 3e-3
"""Probability that a run is wrong for a reason that gyro does not know [1]; the known
ones are in `corrections`."""

WRONG_WEIGHT = 0.03
"""Probability that the mass or the position of one weight is wrong in all its runs [1].
"""

FAR = 0.1
SELDOM = 0.02
"""A balance that differs between weights by more than this part of the lightest torque
is less common by this factor than its prior in the fit, whose tails make u safe."""

OFTEN = 5 / 9
"""Other differences are less common than in the fit too: five of 14 published logs show
one, and the fit supposes as many logs with as without."""

LARGE = math.log(2.0)
RARE = 0.05
"""A load that is wrong by a factor above 2 is less common by this factor."""

POORLY_BALANCED = 0.25
POOR = 5.0
"""Share of the balls whose M0 has a prior that is wider by this factor [1]: the only
published air ball has an M0 of 28 % of the lightest torque."""

WRONG_COUNT = 0.01
"""Probability that the turns of all runs of one weight are miscounted [1]."""

PART_OF_A_TURN = 4.0
"""A student who does not write the turns has timed a part of one turn this many times
as often as several turns [1]."""

UNKNOWN = 4.0
"""A wrong time is equally probable in a range of this width of its logarithm."""

WIDE = 0.4
"""Relative standard uncertainty of a wrong load [1]."""

CLEARLY = math.log(20.0)
"""An explanation is certain if it is this much more probable than every other one, as
the logarithm of a ratio."""

MOST_ODD = 12
"""More wrong runs are not searched for a mistake."""

FARTHEST = 20
"""Runs that are farther apart in the log are not exchanged by mistake."""

MOST_LISTED = 4
MOST_SHOWN = 3
"""Largest number of explanations, and of corrections, that are shown."""


MESSAGES = {
    "weight": "weight_wrong",
}
"""The message of a kind of explanation in `messages.toml`, if it is not "shared_error"."""


class Explanation(Struct, frozen=True):
    """A mistake with which the runs of a log would agree."""

    kind: str
    """"runs", "weight", "turns", "hand", "origin", "drift" or "balance"; `MESSAGES`
    names its message."""
    words: str
    remedy: str
    """What to do, with the text to type; "" if the message of the runs says it."""
    probability: float
    """Compared with all others that were tried, and with no mistake [1]."""
    runs: tuple[str, ...]
    """The runs whose readings would be wrong."""
    inertia: Estimate
    """I_zz if it is true [kg*m^2]."""


class Hypothesis(Struct, frozen=True):
    """An explanation with its fit, before all of them are compared."""

    kind: str
    """As of an explanation; or "none"."""
    words: str
    log_probability: float
    wrong: tuple[int, ...]
    """The runs that are certainly wrong if it is true."""
    fit: FitResult
    remedy: str = ""
    outliers: tuple[Outlier, ...] = ()


class Diagnosis(Struct, frozen=True):
    """Explanations of a log whose runs do not agree."""

    explanations: tuple[Explanation, ...] = ()
    """The probable ones, the most probable first; empty if there is none."""
    outliers: tuple[Outlier, ...] = ()
    """Runs that look odd, with their corrections."""
    left_out: tuple[int, ...] = ()
    """The runs that are certainly wrong."""


class Log(Struct, frozen=True):
    """A log whose runs do not agree."""

    readings: Readings
    measured: Measurements
    """Its n runs, corrected for their motion."""
    tilted: bool

    def fit(
        self, measured: Measurements | None = None, left_out: Sequence[int] = ()
    ) -> FitResult:
        """Fit the log, or a changed one."""
        runs = self.measured if measured is None else measured
        return fitting.fit(runs, tilted=self.tilted, left_out=left_out)

    def evidence(self, fit: FitResult) -> float:
        """Return the log of the probability of the kept times, and of the ball."""
        return float(np.logaddexp(*self.evidences(fit)))

    def evidences(self, fit: FitResult) -> tuple[float, float]:
        """Return the evidence if M0 is the same with all weights, and if it differs."""
        assert fit.posterior is not None
        level = fit.posterior.level
        weight = fit.posterior.weight
        evidence = fit.log_evidence - float(fit.adjusted.kept.sum()) * HALF_LOG_2PI
        evidence += self._log_agreement_with_ball(fit) + self._log_of_balance(fit)
        if self.measured.balance is not None:
            # The log decides whether the balance differs.
            return evidence, -math.inf
        lightest = fitting.lightest_torque(self.measured, fit.adjusted.kept)
        common = np.where(level > FAR * lightest, SELDOM, OFTEN)
        with np.errstate(divide="ignore"):
            of_alike = weight @ (level == 0)
            of_different = weight @ (common * (level > 0))
            alike, differs = np.log([of_alike, of_different])
        return evidence + float(alike), evidence + float(differs)

    def _log_of_balance(self, fit: FitResult) -> float:
        """Return the log of how much more common an M0 is than in its prior."""
        measured = self.measured
        stated = measured.balanced, measured.balance_test, measured.torque_unseen
        if any(each is not None for each in stated):
            return 0.0
        lightest = fitting.lightest_torque(measured, fit.adjusted.kept)
        scale = fitting.balance_scale(measured, fit.inertia.value, lightest)
        m0 = fit.residual_torque.value
        near = 1 + (m0 / scale) ** 2
        far = 1 + (m0 / (POOR * scale)) ** 2
        more_common = near / (POOR * far)
        return math.log(1 - POORLY_BALANCED + POORLY_BALANCED * more_common)

    def _log_agreement_with_ball(self, fit: FitResult) -> float:
        """Return the log of the probability of I_zz for the ball; 0 without a ball."""
        ball = compare_with_ball(
            fit.inertia, self.readings.constants, self.readings.uncertainties
        )
        if ball is None:
            return 0.0
        off = ball.relative / math.hypot(BALL, fitting.relative_u(fit.inertia))
        return math.log(math.exp(-0.5 * off**2) + NO_BALL)


BALL = 0.03
NO_BALL = 0.01
"""Relative difference of I_zz from the value for the ball that is usual, and the
probability density of any other difference [1]."""


def diagnose(
    readings: Readings,
    measured: Measurements,
    tilted: bool,
    base: FitResult | None,
    outliers: Sequence[Outlier],
) -> Diagnosis:
    """Find what explains that the runs of a log do not agree.

    Parameters
    ----------
    readings, measured
        The log, and its n runs, corrected for their motion.
    tilted : bool
        As for `fitting.fit`.
    base : FitResult or None
        The fit of all runs; None if there is none.
    outliers : sequence of Outlier
        The runs that do not agree with the others.

    Returns
    -------
    Diagnosis
    """
    log = Log(readings, measured, tilted)
    tried = _hypotheses(log, base, outliers)
    best = max([each.log_probability for each in tried], default=0.0)
    likely = [each for each in tried if each.log_probability > best - CLEARLY]
    if not likely or "none" in [each.kind for each in likely]:
        # No mistake is named, but it may be clear which runs do not agree.
        of_runs = [each.outliers for each in tried if each.kind == "runs"]
        return Diagnosis(outliers=of_runs[0] if of_runs else ())
    return _diagnosis(log, tried, likely)


def _diagnosis(
    log: Log, tried: Sequence[Hypothesis], likely: Sequence[Hypothesis]
) -> Diagnosis:
    """List the likely mistakes; `tried` and `likely` begin with the most probable."""
    first = likely[0]
    best = first.log_probability
    total = sum([math.exp(each.log_probability - best) for each in tried])
    explained = []
    for each in likely[:MOST_LISTED]:
        probability = math.exp(each.log_probability - best) / total
        runs = tuple([log.measured.runs[run] for run in each.wrong])
        explained.append(
            Explanation(
                each.kind, each.words, each.remedy, probability, runs, each.fit.inertia
            )
        )
    wrong = set.intersection(*[set(each.wrong) for each in likely])
    shown = first.outliers
    if first.kind in MESSAGES and not wrong:
        shown = ()
    return Diagnosis(tuple(explained), shown, tuple(sorted(wrong)))


def _hypotheses(
    log: Log, base: FitResult | None, outliers: Sequence[Outlier]
) -> list[Hypothesis]:
    """List what may be wrong in a log, the most probable first."""
    tried = [*_as_written(log, base), *_wrong_runs(log, outliers)]
    if len(log.measured.runs) <= MOST_RUNS:
        tried += _wrong_weights(log)
        tried += _wrong_counts(log)
        tried += _shared_errors(log)
    return sorted(tried, key=attrgetter("log_probability"), reverse=True)


# --- no mistake ---

BALANCE_WORDS = "M0 differs between the weights, as if somebody touched the balance"


def _as_written(log: Log, base: FitResult | None) -> Iterator[Hypothesis]:
    """Suppose that all readings are right, and that M0 is the same or differs."""
    if base is None:
        return
    alike, differs = log.evidences(base)
    if alike > -math.inf:
        yield Hypothesis("none", "", alike, (), base)
    if differs > -math.inf:
        yield Hypothesis("balance", BALANCE_WORDS, differs, (), base)


# --- single runs ---


def _wrong_runs(log: Log, outliers: Sequence[Outlier]) -> Iterator[Hypothesis]:
    """Suppose that the outliers are wrong, or instead the others of one weight."""
    if not outliers:
        return
    odd = [outlier.index for outlier in outliers]
    known = {outlier.index: outlier for outlier in outliers}
    for runs in (odd, *_instead(log.measured, odd)):
        with suppress(NoFit):
            yield _runs_hypothesis(log, runs, known)


def _instead(measured: Measurements, odd: Sequence[int]) -> Iterator[list[int]]:
    """List the runs that may be wrong instead of the outliers of a torque.

    Runs of one torque that contradict each other are decided by their number, or by the
    other torques.
    """
    for group in measured.by_torque:
        is_divided = 0 < len(set(odd).intersection(group)) < len(group)
        instead = set(odd).symmetric_difference(group)
        too_many = len(instead) > min(MOST_ODD, len(measured.runs) / 2)
        if is_divided and not too_many and measured.torque[group[0]]:
            yield sorted(instead)


def _runs_hypothesis(
    log: Log, runs: Sequence[int], known: dict[int, Outlier]
) -> Hypothesis:
    """Suppose that some runs are wrong, each by its most probable correction."""
    measured = log.measured
    others = log.fit(left_out=runs)
    of_run = _corrections(log, others, runs)
    total = log.evidence(others)
    for run in runs:
        total += _log_sum(of_run[run]) - math.log(measured.time[run])
    outliers = [
        _with_corrections(others, run, of_this, known.get(run))
        for run, of_this in sorted(of_run.items())
    ]
    wrong = [outlier.index for outlier in outliers if outlier.slip]
    return Hypothesis(
        "runs",
        _words_of_runs(measured, outliers),
        total,
        tuple(wrong),
        others,
        outliers=tuple(outliers),
    )


def _log_sum(of_run: Sequence[Correction]) -> float:
    """Return the log of the probability density of a run that is wrong somehow."""
    unknown = math.log(WRONG_RUN / UNKNOWN)
    known = [each.log_density for each in of_run]
    return float(np.logaddexp.reduce([unknown, *known]))


def _corrections(
    log: Log, others: FitResult, odd: Sequence[int]
) -> dict[int, list[Correction]]:
    """List the corrections with which odd runs agree with the others, by run.

    The partner of an odd run in an exchange is listed too.
    """
    of_run: dict[int, list[Correction]] = {run: [] for run in odd}
    if len(log.measured.runs) > MOST_RUNS:
        return of_run
    prediction = Prediction(log.measured, others)
    kept = np.flatnonzero(others.adjusted.kept).tolist()
    for run in odd[:MOST_ODD]:
        tried = corrections.of_run(log.readings, log.measured, kept, run)
        of_run[run] = [*prediction.agreeing(tried, odd)]
    for exchange in _exchanges(log, prediction, of_run):
        share = exchange.log_density / len(of_run.keys() & exchange.runs)
        for run in exchange.runs:
            half = replace(exchange, log_density=share if run in odd else 0.0)
            of_run.setdefault(run, []).append(half)
    return of_run


def _exchanges(
    log: Log, prediction: Prediction, of_run: Mapping[int, list[Correction]]
) -> list[Correction]:
    """List the exchanges that are more probable than other errors of the outliers."""
    gains = []
    for first, second in combinations(range(len(log.measured.runs)), 2):
        odd = of_run.keys() & (first, second)
        is_tried = odd and second - first <= FARTHEST
        tried = corrections.of_pair(log.readings, first, second) if is_tried else ()
        before = sum([_log_sum(of_run[run]) for run in odd])
        for exchange in prediction.agreeing(tried, odd):
            gain = exchange.log_density - before
            if gain > 0:
                gains.append((gain, exchange))
    used: set[int] = set()
    exchanges = []
    for _, exchange in sorted(gains, key=itemgetter(0), reverse=True):
        if used.isdisjoint(exchange.runs):
            used.update(exchange.runs)
            exchanges.append(exchange)
    return exchanges


def _with_corrections(
    others: FitResult, run: int, of_run: Sequence[Correction], known: Outlier | None
) -> Outlier:
    """Return an outlier with its probable corrections."""
    expected = float(others.fitted_time[run])
    deviation = float(others.deviations[run])
    outlier = known or Outlier(run, deviation, slip=True)
    ranked = sorted(of_run, key=attrgetter("log_density", "words"), reverse=True)
    best = ranked[0].log_density if ranked else 0.0
    probable = [each for each in ranked if each.log_density > best - CLEARLY]
    likely = [each.words for each in probable[:MOST_SHOWN]]
    is_wrong = outlier.slip or any(each.is_certain for each in probable)
    if not is_wrong and len(probable) > 1:
        # A run that is not clearly wrong may be odd by chance; then several
        # corrections may fit, or none.
        likely = []
    cells = tuple(likely)
    return replace(
        outlier, deviation=deviation, expected=expected, slip=is_wrong, cells=cells
    )


def _words_of_runs(measured: Measurements, outliers: Sequence[Outlier]) -> str:
    """Return what is wrong with some runs, if they are wrong."""
    words: dict[str, None] = {}
    for outlier in outliers:
        run = measured.runs[outlier.index]
        cell = f"run {run} is wrong"
        if outlier.cells:
            cell = outlier.cells[0]
            # An exchange names both runs.
            if "runs" not in cell:
                cell = f"run {run}: {cell}"
        words[cell] = None
    return "; ".join(words)


# --- the load of a weight ---


def _wrong_weights(log: Log) -> Iterator[Hypothesis]:
    """Suppose that the load of one weight is wrong in all its runs."""
    weights = log.measured.by_weight
    if not 2 <= len(weights) <= MOST_WEIGHTS:
        return
    prior = math.log(WRONG_WEIGHT / len(weights))
    for runs in weights:
        if len(runs) > 1:
            with suppress(NoFit):
                yield _weight_hypothesis(log, runs, prior)


def _weight_hypothesis(log: Log, runs: list[int], prior: float) -> Hypothesis:
    """Suppose that the load of some runs can have every value."""
    measured = log.measured
    own = measured.single_inertia
    others = np.delete(own, runs)
    # With this factor on the load, the runs agree with the others but for M0.
    factor = fitting.median(others[others > 0]) / fitting.median(own[runs])
    fit = log.fit(_with_free_load(log, runs, factor))
    factor /= 1 + WIDE * float(fit.error_of(FREE_LOAD)[runs[0]])
    slips = _near(factor, _slips(log.readings))
    counts = _near(factor, _counts(measured.turns[runs]))
    causes = [*slips, *counts, *_values_of_load(log, runs[0], factor)]
    if not causes:
        raise NoFit("no possible load agrees with the other weights")
    evidence = log.evidence(fit) + prior
    if slips:
        evidence += math.log(KNOWN_SLIP)
    elif abs(math.log(factor)) > LARGE:
        evidence += math.log(RARE)
    load = load_words(measured, runs[0])
    count = len(runs)
    number = "both" if count == 2 else f"all {count}"
    cause = " or ".join(causes[:MOST_SHOWN])
    words = f"{number} runs of {load} would agree with the others if {cause}"
    reason = f"the mass or the position of {load} is wrong"
    outliers = []
    for run in runs:
        deviation = float(fit.deviations[run])
        outliers.append(Outlier(run, deviation, slip=True, cells=(reason,)))
    wrong = tuple(runs)
    return Hypothesis(
        "weight", words, evidence, wrong, fit, WEIGH_AGAIN, tuple(outliers)
    )


WEIGH_AGAIN = (
    "weigh it and measure its position again; correct the log, and do not change a time"
)

FREE_LOAD = "free_load"
"""Name of the error of a load that may be wrong."""


def _with_free_load(log: Log, runs: list[int], factor: float) -> Measurements:
    """Multiply the load of some runs, and let it have every value near this one."""
    measured = log.measured
    role = load_role(log.readings.columns)
    quantity = cast(Quantity, role)
    of_weight = np.isin(np.arange(len(measured.runs)), runs)
    factors = np.where(of_weight, factor, 1.0)
    name = "given_torque" if role == "torque" else role
    group = np.where(of_weight, 0, -1)
    wide = np.where(of_weight, WIDE, 0.0)
    free = Source(FREE_LOAD, quantity, group, 0 * wide, wide)
    changed = {name: factors * getattr(measured, name)}
    return replace(
        measured,
        torque=factors * measured.torque,
        sources=(*measured.sources, free),
        **changed,
    )


KNOWN_SLIP = 10.0
"""A factor that is exactly that of a known mistake is more probable by this factor than
any other one."""


def _near(factor: float, causes: Iterator[tuple[str, float]]) -> list[str]:
    """Return the words of those causes that are the same as a factor on the load."""
    return [words for words, of_load in causes if abs(factor / of_load - 1) < NEAR]


def _slips(readings: Readings) -> Iterator[tuple[str, float]]:
    """List mistakes in all times or spins of a weight.

    Each has its words, and the factor on the load with which the runs agree as well.
    """
    if "spin" in readings.columns:
        yield "their spins were half as large (two strips of tape?)", 2.0
    for role, power in (("time", 1), ("spin", -1)):
        if role in readings.columns:
            for unit, times in other_units(readings.columns[role]):
                yield f"their {role}s were in {unit}", times**power


def _counts(turns: Floats) -> Iterator[tuple[str, float]]:
    """List other counts for runs that have the same turns, like `_slips`."""
    if np.ptp(turns):
        return
    written = float(turns[0])
    for step in corrections.FEW_COUNTS:
        count = written + step
        if count > 0:
            yield f"they had {turn_words(count)}", written / count


def _values_of_load(log: Log, run: int, factor: float) -> Iterator[str]:
    """List the masses and positions with which a weight agrees, with their causes."""
    for role in corrections.load_roles(log.readings):
        measured = getattr(log.measured, role, log.measured.given_torque)[run]
        low, high = possible_range(role)
        if low <= abs(factor * measured) <= high:
            column = log.readings.columns[role]
            yield f"its {_value_words(column, run, measured, factor)}"


def _value_words(column: Column, run: int, measured: float, factor: float) -> str:
    """Return `factor` times the measured value of a column, and its cause if known."""
    value = factor * measured
    name = column.role.replace("_", " ")
    for cell in corrections.of_typing(column, run):
        if abs(cell.value / value - 1) < NEAR:
            why = cell.words.partition("(")[2].rstrip(")")
            return f"{name} were {cell.text} {column.unit} ({why})"
    missing = value - measured
    shown = _in_column(column, run, (column.values[run] or 0.0) + missing)
    if column.role == "mass" and HANGER[0] < missing < HANGER[1]:
        hanger = _in_column(column, run, missing)
        return f"{name} were {shown} (is a hanger of {hanger} missing?)"
    return f"{name} were {shown}"


NEAR = 0.03
"""A mistake explains a load if it gives this load within this part of it [1]."""

HANGER = (0.5e-3, 0.02)
"""Range of the mass of a hanger [kg]."""


def _in_column(column: Column, run: int, value: float) -> str:
    """Return a value with the unit and the digits of a column."""
    unit = unit_size(column)
    number = as_read(value / unit, column.steps[run] / unit)
    return f"{number} {column.unit}".rstrip()


# --- the turns of weights ---


SAME_COUNT = math.log(4 / 3) / 2
"""Torques agree if their I_zz with M0 = 0 differ by less than this logarithm: half of
the smallest step between two counts."""


def _wrong_counts(log: Log) -> Iterator[Hypothesis]:
    """Suppose that the turns of all runs of some weights are wrong."""
    measured = log.measured
    # Weights whose runs were timed for the same turns.
    groups = [
        runs
        for runs in measured.by_torque
        if measured.torque[runs[0]] and not np.ptp(measured.turns[runs])
    ]
    for counts in _agreeing_counts(measured, groups)[:MOST_SHOWN]:
        turns = measured.turns.copy()
        words = []
        price = 0.0
        for runs, count in zip(groups, counts, strict=True):
            written = float(turns[runs[0]])
            if count == written:
                continue
            turns[runs] = count
            load = load_words(measured, runs[0])
            fits = turn_words(count)
            number, _ = turn_words(written).split(" ")
            words.append(f"the runs of {load} fit {fits}, not {number}")
            price += math.log(WRONG_COUNT)
        if max(counts) > 1:
            price -= math.log(PART_OF_A_TURN)
        with suppress(NoFit):
            fit = log.fit(replace(measured, turns=turns))
            wrong = np.flatnonzero(turns != measured.turns).tolist()
            evidence = log.evidence(fit) + price
            yield Hypothesis("turns", "; ".join(words), evidence, tuple(wrong), fit)


SAME_TURNS = 0.01
"""Counts are the same if they differ by less than this part, as 0.33 and 1/3."""


def _agreeing_counts(
    measured: Measurements, groups: Sequence[list[int]]
) -> list[tuple[float, ...]]:
    """List the turns of weights with which their I_zz agree, by their groups of runs.

    Each weight with each of its counts gives an I_zz, and the other weights then have
    the nearest count. Only the counts that change the fewest weights are listed; none
    if the weights agree as written.
    """
    own = measured.single_inertia
    written = np.array([measured.turns[runs[0]] for runs in groups])
    angles = np.array([fitting.median(own[runs]) for runs in groups]) * written
    # The shape of these two is (weights, counts).
    counts = np.array([[count, *USUAL_COUNTS] for count in written.tolist()])
    inertia = angles[:, None] / counts
    answers: dict[tuple[float, ...], int] = {}
    for supposed in inertia.reshape(-1):
        off = np.abs(np.log(inertia / supposed))
        nearest = counts[range(len(counts)), off.argmin(axis=1)]
        is_other = ~np.isclose(nearest, written, rtol=SAME_TURNS)
        if off.min(axis=1).max() < SAME_COUNT:
            answer = np.where(is_other, nearest, written)
            answers[tuple(answer.tolist())] = int(is_other.sum())
    fewest = min(answers.values(), default=0)
    listed = [each for each, changed in answers.items() if changed == fewest > 0]
    # Only the first are tried: the smallest counts are the most usual.
    return sorted(listed, key=sum)


# --- an error that all runs share ---

SHARED_ERROR = 0.05
"""Probability that an error that all runs share is much larger than stated [1]."""


class SharedError(NamedTuple):
    """An error that all runs share, if it is much larger than stated."""

    kind: str
    quantity: Quantity
    size: float
    """Standard uncertainty [s], [m], or as a part of the lightest torque [1]."""
    unit: float
    """The unit of the number in the words [SI unit]."""
    words: str
    remedy: str
    signs: tuple[str, str] = ("", "")
    """Words for readings that are too large, and too small."""
    needs: str = ""
    """The source of error of a log that can have it; "" if every log can."""


SHARED_ERRORS = (
    SharedError(
        "hand",
        "time",
        1.0,
        1.0,
        "the stopwatch was {size:.2g} s {sign} than stated",
        "state the bias of your hand, for example # u_time_bias: {twice:.1g} s, "
        "or time more turns",
        ("later", "earlier"),
        "time",
    ),
    SharedError(
        "origin",
        "position",
        5e-3,
        1e-3,
        "every position was {size:.2g} mm {sign}",
        "measure the arm from the centre of the ball, or state # u_position_zero: "
        "{size:.1g} mm",
        ("less", "more"),
        "position_zero",
    ),
    SharedError(
        "drift",
        "balance",
        0.1,
        1e-3,
        "M0 drifted by {size:.2g} mN·m from the first run to the last",
        "fix the balance weight, check step 2 again, "
        "and repeat the first run at the end",
    ),
)


def _shared_errors(log: Log) -> Iterator[Hypothesis]:
    """Suppose that one error that all runs share is much larger than stated."""
    names = {"", *[source.name for source in log.measured.sources]}
    for error in SHARED_ERRORS:
        if error.needs in names:
            with suppress(NoFit):
                yield _shared_hypothesis(log, error)


def _shared_hypothesis(log: Log, error: SharedError) -> Hypothesis:
    """Suppose that one error that all runs share is much larger than stated."""
    measured = log.measured
    every = np.ones(len(measured.runs))
    sizes = error.size * every
    if error.kind == "drift":
        lightest = fitting.lightest_torque(measured, every)
        sizes *= lightest * np.linspace(-0.5, 0.5, len(every))
    group = np.zeros(len(every), dtype=int)
    wide = Source(error.kind, error.quantity, group, sizes, 0 * every, "all runs")
    fit = log.fit(replace(measured, sources=(*measured.sources, wide)))
    largest = np.ptp(np.append(0.0, sizes)) / error.unit
    off = largest * float(fit.error_of(error.kind)[0])
    size = abs(off)
    sign = error.signs[int(off < 0)]
    words = error.words.format(size=size, sign=sign)
    words = f"the runs would agree if {words}"
    remedy = error.remedy.format(size=size, twice=2 * size)
    # A balance that differs as well is another explanation.
    evidence, _ = log.evidences(fit)
    evidence += math.log(SHARED_ERROR)
    return Hypothesis(error.kind, words, evidence, (), fit, remedy)
