"""The fit of one log: I_zz, M0 and b from raw readings that share errors.

`fit` first adjusts the runs with the stated uncertainties; then it integrates over the
widths that the log does not know (`posterior`), and adjusts the runs again at the
typical widths. `fit_model` corrects the runs for the models of their motion
(`physics.models`). These corrections depend on I_zz and M0 a little, so that fit and
correction are iterated.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterator
from functools import cached_property, partial
from operator import attrgetter, itemgetter

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.fitting import adjustment, posterior
from gyrodata.fitting.adjustment import (
    ADDED,
    PITCH,
    SPIN,
    TRANSVERSE,
    TURNS,
    Adjusted,
    NoFit,
    Problem,
    Start,
    Widths,
)
from gyrodata.fitting.posterior import Posterior, chi2_tail
from gyrodata.measurements import (
    BALANCE_CHANGE,
    DAY_BALANCE,
    DAY_BIAS,
    REVOLUTION,
    SOURCES,
    TRANSVERSE_U,
    Measurements,
    Source,
    contrasts,
    share_of_mean,
    total_spin_excess,
)
from gyrodata.physics import Floats
from gyrodata.physics.models import ModelError, Motion, TimedRuns
from gyrodata.physics.motion import Top

ONE_SIGN = 1e-4
"""A sign of M0 that is less probable than this is ignored."""

UNLIKELY = 1e-3
"""If chi-square is less probable than this, the runs do not agree."""

LATE_DEVIATION = 3.0
"""Runs of such a log may have been stopped late if they are longer than predicted by
more than this many standard uncertainties."""

LATE_LABS = 0.1
LATE_RUNS = 0.15
"""Probability that some runs of a lab were stopped late, and of each run then."""

LATEST = 4.0
"""Largest lateness [s]; all smaller ones have the same probability."""

UNITS = ("kg*m^2", "N*m", "s")
"""Units of I_zz, M0 and b."""


class Estimate(Struct, frozen=True):
    """A value with its standard uncertainty (k = 1)."""

    value: float
    """In the SI unit."""
    u: float | None
    """Standard uncertainty; null if the runs do not determine it, and the note of the
    fit contains the reason."""
    unit: str
    """The SI unit, such as "kg*m^2"."""
    interval_95: tuple[float, float] | None = None
    """null if it is value ± 1.96 u, or is not computed."""


def relative_u(inertia: Estimate) -> float:
    """Compute the standard uncertainty of I_zz over I_zz [1]."""
    return (inertia.u or 0.0) / abs(inertia.value)


class Share(Struct, frozen=True):
    """The contribution of one uncertainty component to u(I_zz)."""

    source: str
    shared: bool
    shared_by: str
    u_inertia: float
    """[kg*m^2]"""
    share: float
    """Of the variance [1]; the shares of a budget add up to 1."""


class Outlier(Struct, frozen=True):
    """A run that does not agree with the others."""

    index: int
    deviation: float
    """Time minus the prediction of the other runs, in standard uncertainties of this
    difference."""
    slip: bool
    """True if the run is certainly wrong: a number of turns explains it, or it is too
    far off."""
    expected: float = math.nan
    """Time that the other runs predict [s]."""
    cells: tuple[str, ...] = ()
    """Corrections of one cell with which the run agrees with the others, in words, the
    likeliest first. If the run is not certainly wrong, one at most."""


AS_STATED = Widths(1.0, None)
"""The stated widths, and an M0 as large as the smallest torque: for screening."""


class FitResult(Struct, frozen=True, eq=False, dict=True):
    """The adjusted unknowns of one log of n runs.

    Method: Gauss–Helmert least squares in the raw readings, with derivatives and
    proportional uncertainties at the adjusted values. Standard uncertainties come from
    the stated ones, and are not scaled by chi-square.
    """

    chi2: float
    """Sum of the squares of the n residuals, of the shared errors and of b, each over
    its stated standard uncertainty. M0 and its differences between days do not count:
    their widths are no data. If the torques are equal, only M0 itself counts."""
    dof: int
    """Number of runs in the fit, minus one for I_zz, one for each further day, and one
    for M0 if it does not count in `chi2`."""
    widths: Widths
    """Widths with which the runs were adjusted, which `_at_widths` may have changed."""
    sense: Floats
    """Sign of φ̇ψ̇ used for each run, shape (n,)."""
    adjusted: Adjusted
    """The end of the adjustment; of two possible answers the likelier one."""
    two_signs: bool = False
    """True if M0 can have either sign, and the answer includes both."""
    late: tuple[int, ...] = ()
    """Runs whose clock was probably stopped late; they hardly count in the answer."""
    posterior: Posterior | None = None
    """The answer as a mixture; None for a fit at fixed widths."""
    begun: FitResult | None = None
    """The fit at the stated widths, from which the others were found; None for a fit at
    fixed widths."""

    @property
    def as_stated(self) -> FitResult:
        """The fit at the stated widths, or this fit at fixed widths."""
        return self.begun or self

    @property
    def p(self) -> float:
        """Probability of a larger chi-square."""
        return chi2_tail(self.chi2, max(self.dof, 1))

    @cached_property
    def inertia(self) -> Estimate:
        """I_zz [kg*m^2]."""
        return self._estimate(0)

    @cached_property
    def residual_torque(self) -> Estimate:
        """M0 [N*m]: the torque is M + M0."""
        return self._estimate(1)

    @cached_property
    def timing_bias(self) -> Estimate:
        """The bias b [s]: a clock reading is the true time plus b."""
        return self._estimate(2)

    def _estimate(self, number: int) -> Estimate:
        """Return an unknown: median of its posterior, and half the 68.3 % interval."""
        if self.posterior is None:
            u = math.sqrt(self.covariance[number, number])
            return Estimate(float(self.adjusted.unknowns[number]), u, UNITS[number])
        quantiles = self.posterior.quantiles(number)
        low, below, middle, above, high = quantiles.tolist()
        return Estimate(middle, (above - below) / 2, UNITS[number], (low, high))

    @property
    def covariance(self) -> Floats:
        """Covariance of (I_zz, M0, b) at these widths, shape (3, 3)."""
        return self.adjusted.covariance

    @property
    def deviations(self) -> Floats:
        """Time minus the prediction of the other runs, see `Adjusted`, shape (n,)."""
        return self.adjusted.deviations

    @cached_property
    def budget(self) -> tuple[Share, ...]:
        """The sources of u(I_zz), largest first; empty for a fit at fixed widths."""
        if self.posterior is None:
            return ()
        return _budget(self, self.inertia.u or 0.0)

    @cached_property
    def _linear(self) -> adjustment.Linear:
        """The conditions at the end, without the errors of single runs."""
        end = self.adjusted
        return end.problem.linearise(
            np.zeros_like(end.slopes), end.shared, self.sense, end.unknowns
        )

    @cached_property
    def fitted_time(self) -> Floats:
        """Time that the fit predicts from the other readings [s], shape (n,)."""
        inertia, residual_torque, bias = self.adjusted.unknowns.tolist()
        values = self._linear.values
        torque = self._linear.torque + residual_torque
        spin = self.sense * values[SPIN]
        # Eq. (9) if pitch and I are zero, as for a rod that is treated as level.
        top = inertia + values[ADDED], values[TRANSVERSE], values[PITCH]
        rate = np.abs(physics.precession_rate(torque, spin, *top))
        late = bias + self._shift_of(DAY_BIAS)
        angle = REVOLUTION * values[TURNS]
        with np.errstate(divide="ignore"):
            time: Floats = angle / rate + late
        return time

    @cached_property
    def time_u(self) -> Floats:
        """Standard uncertainty of each run's time about the fit [s], shape (n,).

        It comes from the errors of this run alone.
        """
        end = self.adjusted
        net_torque = self._linear.torque + end.unknowns[1]
        width = np.sqrt(end.independent_variance)
        with np.errstate(divide="ignore"):
            # The condition is the time multiplied by the net torque.
            u: Floats = width / np.abs(net_torque)
        return u

    def error_of(self, name: str) -> Floats:
        """Return the adjusted error of a source that runs share, in its u, shape (n,).

        It is zero in runs without this source.
        """
        problem = self.adjusted.problem
        errors = problem.errors_of(self.adjusted.shared)
        error: Floats = errors[problem.is_from(name)].sum(axis=0)
        return error

    def _shift_of(self, name: str) -> Floats:
        """Return the shift of readings by the shared errors of a source, shape (n,)."""
        problem = self.adjusted.problem
        errors = problem.errors_of(self.adjusted.shared)
        shifts = problem.absolute * errors
        shift: Floats = shifts[problem.is_from(name)].sum(axis=0)
        return shift

    @property
    def balances(self) -> Floats:
        """M0 of each run's day [N*m], shape (n,)."""
        # Nobody reads a balance: its reading is zero, and M0 is minus its error.
        return self.residual_torque.value - self._shift_of(DAY_BALANCE)

    @property
    def chance_of_one_balance(self) -> float:
        """Probability that M0 is the same with every weight; 1 if the log says so."""
        if self.posterior is None or self.adjusted.problem.measured.balance is not None:
            return 1.0
        return self.posterior.chance_of_one_balance()

    @property
    def log_evidence(self) -> float:
        """Logarithm of the probability of the times, up to a constant.

        The probability is integrated over I_zz, M0, b and all widths.
        """
        assert self.posterior is not None
        kept = self.adjusted.kept > 0
        stated_u = self.time_u[kept] / self.widths.scatter
        return self.posterior.evidence - float(np.log(stated_u).sum())

    @property
    def response(self) -> Floats:
        """Relative change of I_zz for a relative change of a run's M/(φ̇ψ̇) [1].

        There is a value for each run's own M/(φ̇ψ̇), shape (n,).
        """
        # M/(φ̇ψ̇) too large by the factor 1 + r raises the condition by 2π f I_zz ψ̇ r.
        problem = self.adjusted.problem
        angle = REVOLUTION * problem.observed[TURNS]
        lever = angle * problem.observed[SPIN]
        gain = self.adjusted.gain[: problem.count]
        width = np.sqrt(self.adjusted.independent_variance)
        response: Floats = -gain * lever / width
        return response


def fit(
    measured: Measurements,
    widths: Widths | None = None,
    *,
    tilted: bool = False,
    left_out: Collection[int] = (),
) -> FitResult:
    """Fit I_zz, M0 and b of one log, with their uncertainties.

    The prior is the same for all designs: M0 has a Cauchy distribution whose scale is 5
    % of the smallest torque; a balance test in the log is evidence about M0 that may be
    false; b has the width ``u_time_bias``; and the errors of single runs are wider or
    narrower than stated by a common factor s (`posterior`).

    Parameters
    ----------
    measured : Measurements
        The n runs.
    widths : Widths, optional
        Fit at these widths, without an integration.
    tilted : bool
        Use eq. (8) with each run's pitch, not eq. (9).
    left_out : collection of int
        Runs that are not used, from 0 to n - 1; their times are still predicted. At
        least one run with a torque is used.

    Returns
    -------
    FitResult

    Raises
    ------
    NoFit
        If there is no credible solution.

    Notes
    -----
    Without degrees of freedom, s has its prior, from 0.25 to 20 and mostly near 1: u
    is then larger than with the stated errors alone, by half or more of them.
    """
    begun = _fits_at_widths(measured, tilted, left_out, widths or AS_STATED)
    if widths is not None:
        return min(begun, key=attrgetter("chi2"))
    result = _integrated(measured, begun)
    is_likely = result.as_stated.p > UNLIKELY
    if is_likely or not measured.timed or result.two_signs:
        return result
    return _with_late_runs(measured, result)


def _fits_at_widths(
    measured: Measurements, tilted: bool, left_out: Collection[int], widths: Widths
) -> list[FitResult]:
    """Fit the runs at fixed widths, with each possible sign of M0."""
    kept = np.ones(len(measured.runs))
    kept[list(left_out)] = 0.0
    # Without a direction of the runs without a weight, M0 can have both signs.
    is_determined = measured.sense[kept > 0].all()
    signs = (1.0,) if is_determined else (1.0, -1.0)
    begun: list[FitResult] = []
    for sign in signs:
        # A run without a weight turns in the direction of the residual torque.
        sense = np.where(measured.sense == 0, sign, measured.sense)
        try:
            begun.append(_at_widths(measured, sense, tilted, kept, widths))
        except NoFit:
            if sign == signs[-1] and not begun:
                raise
    return begun


def _integrated(measured: Measurements, begun: list[FitResult]) -> FitResult:
    """Integrate over the widths, from the fits at the stated ones: one for each sign.

    The answer includes both signs of M0 if both are possible.
    """
    of_signs = [_at_typical_widths(measured, result) for result in begun]
    of_signs.sort(key=lambda pair: pair[1].evidence, reverse=True)
    likeliest, answer = of_signs[0]
    least = answer.evidence + math.log(ONE_SIGN)
    possible = [other for _, other in of_signs if other.evidence > least]
    if len(possible) > 1:
        likeliest = replace(likeliest, two_signs=True)
        answer = posterior.mixed(possible)
    stated = min(begun, key=attrgetter("chi2"))
    return replace(likeliest, begun=stated, posterior=answer)


def _at_typical_widths(
    measured: Measurements, begun: FitResult
) -> tuple[FitResult, Posterior]:
    """Integrate over the widths, adjust the runs at the typical ones, and integrate.

    If the runs cannot be adjusted there, the first of both integrals is the answer.
    """
    answer = integrate_at(begun)
    widths = answer.typical_widths()
    start = Start(*(answer.mean[:2] @ answer.weight).tolist())
    end = begun.adjusted
    problem = Problem(measured, end.problem.tilted, widths)
    try:
        adjusted = adjustment.adjust(problem, begun.sense, start, end.kept)
    except NoFit:
        return begun, answer
    result = replace(begun, adjusted=adjusted, widths=widths)
    return result, integrate_at(result)


def _with_late_runs(measured: Measurements, result: FitResult) -> FitResult:
    """Mix a fit with fits without the runs whose clock was perhaps stopped late.

    A hand can be late by seconds, and never early. So a late run says nothing but its
    lateness, which has the same density from zero to `LATEST`.
    """
    fits = [result, *_without_late_runs(measured, result)]
    answers = []
    for late, other in enumerate(fits):
        on_time = float(other.adjusted.kept.sum())
        # The factor of a normal density, for each run.
        of_density = on_time * math.log(math.tau) / 2
        evidence = other.log_evidence - of_density
        if late:
            of_late = late * math.log(LATE_RUNS / LATEST)
            evidence += math.log(LATE_LABS) + of_late
            evidence += on_time * math.log(1 - LATE_RUNS)
        assert other.posterior is not None
        answers.append(replace(other.posterior, evidence=evidence))
    evidences = [answer.evidence for answer in answers]
    likeliest = fits[int(np.argmax(evidences))]
    gone = result.adjusted.kept - likeliest.adjusted.kept
    # The evidence of the log remains comparable with that of another fit of all runs.
    assert result.posterior is not None
    answer = replace(posterior.mixed(answers), evidence=result.posterior.evidence)
    late_runs = tuple(np.flatnonzero(gone).tolist())
    return replace(result, late=late_runs, posterior=answer)


def _without_late_runs(
    measured: Measurements, result: FitResult
) -> Iterator[FitResult]:
    """Leave out one run after the other, the one that seems latest first."""
    kept = result.adjusted.kept.copy()
    tilted = result.adjusted.problem.tilted
    for _ in range(int(kept.sum() / 3)):
        deviations = np.where(kept > 0, result.as_stated.deviations, -np.inf)
        run = int(deviations.argmax())
        if deviations[run] < LATE_DEVIATION:
            return
        kept[run] = 0.0
        left_out = np.flatnonzero(kept == 0).tolist()
        try:
            begun = _fits_at_widths(measured, tilted, left_out, AS_STATED)
        except NoFit:
            return
        result = _integrated(measured, begun)
        lateness = measured.time[run] - result.fitted_time[run]
        if not 0 < lateness < LATEST or result.dof < 1:
            return
        yield result


def _at_widths(
    measured: Measurements, sense: Floats, tilted: bool, kept: Floats, widths: Widths
) -> FitResult:
    """Adjust the runs at fixed widths, or at others if they contain a large mistake.

    The cheapest explanation of a very large mistake is that all spins are infinite,
    because their errors are proportional, or that M0 cancels all torques. Larger errors
    of single runs and a small M0 prevent this. The result contains its widths.
    """
    width = widths.residual_torque
    if width is None:
        width = adjustment.lightest_torque(measured, kept)
        widths = replace(widths, residual_torque=width)
    start = adjustment.first_guess(measured, sense, kept)
    m0 = max(-width, min(start.residual_torque, width))
    start = replace(start, residual_torque=m0)
    try:
        problem = Problem(measured, tilted, widths)
        adjusted = adjustment.adjust(problem, sense, start, kept)
    except NoFit:
        misfit = adjustment.misfits(measured, start)[kept > 0]
        factor = max(widths.scatter, math.sqrt(np.mean(misfit**2)))
        widths = replace(widths, scatter=factor, residual_torque=0.1 * width)
        problem = Problem(measured, tilted, widths)
        astray = adjustment.ASTRAY
        adjusted = adjustment.adjust(problem, sense, start, kept, factor=astray)
    # A prior without information is not a datum: neither its term nor its degree of
    # freedom counts.
    is_separate = _separates_balance(measured, kept)
    of_days = adjusted.shared[adjusted.problem.owned_by(DAY_BALANCE)]
    prior = float(np.sum(of_days**2))
    if is_separate:
        prior += (adjusted.unknowns[1] / adjusted.scale[1]) ** 2
    days = {*measured.day[kept > 0].tolist()}
    return FitResult(
        chi2=widths.scatter**2 * float(adjusted.chi2 - prior),
        dof=int(kept.sum()) - len(days) - is_separate,
        widths=widths,
        sense=sense,
        adjusted=adjusted,
    )


def _separates_balance(measured: Measurements, kept: Floats) -> bool:
    """Return whether the torques of a day differ, so that they determine its M0."""
    used = kept > 0
    for day in {*measured.day[used].tolist()}:
        of_day = used & (measured.day == day)
        if adjustment.torques_differ(measured.torque[of_day]):
            return True
    return False


def integrate_at(result: FitResult, tested: bool = True) -> Posterior:
    """Integrate over the widths, linearised at the end of a fit.

    I_zz in kg*m^2, M0 in N*m, b in s; with `tested` a balance test limits M0.
    """
    adjusted = result.adjusted
    problem = adjusted.problem
    measured = problem.measured
    kept = adjusted.kept > 0
    scatter = result.widths.scatter
    to_unknowns = scatter * adjusted.rows[:, :3]
    # The unit of M0 in the fit is the width of its prior there.
    to_unknowns[:, 1] /= adjusted.scale[1]
    unit = adjusted.scale.copy()
    unit[1] = 1.0
    to_shared = scatter * adjusted.rows[:, 3:]
    to_m0 = to_unknowns[:, 1:2]
    groups = measured.balance_groups
    # `np.unique` would import numpy.ma, which takes as long as the fit.
    used = kept & (groups >= 0)
    weights = sorted({*groups[used].tolist()})
    is_of_weight = groups[:, None] == np.array(weights)
    share = share_of_mean(measured.day)
    is_balance = problem.owned_by(BALANCE_CHANGE, DAY_BALANCE)
    weighted = scatter * adjusted.weighted
    conditions = posterior.Conditions(
        unknowns=to_unknowns,
        shared=to_shared[:, ~is_balance],
        levels=to_m0 * is_of_weight,
        days=to_m0 * contrasts(measured.day).T / share,
        left=weighted - to_shared @ adjusted.shared,
        ended=adjusted.unknowns / np.where(unit > 0, unit, 1.0),
        unit=unit,
        runs=float(adjusted.kept.sum()),
        scatter=scatter,
    )
    inertia = result.inertia.value
    lightest = adjustment.lightest_torque(measured, adjusted.kept)
    # The prior is that of the mean of all days.
    width = None
    if tested and measured.balance_test is not None:
        width = share * measured.balance_test.at(inertia)
    scale = share * balance_scale(measured, inertia, lightest)
    differ = adjustment.torques_differ(measured.torque[kept])
    tails = differ or not measured.balanced
    balance = posterior.balance_prior(scale, width, tails)
    untouched = 0.0 if measured.balance == "touched" else posterior.UNTOUCHED
    if len(weights) < 2:
        untouched = 1.0
    changes = posterior.level_prior(untouched, lightest)
    return posterior.integrate(conditions, balance, changes, times_stated(measured))


def balance_scale(measured: Measurements, inertia: float, lightest: float) -> float:
    """Return the scale of M0's prior, for an I_zz [kg*m^2] and a torque [N*m]."""
    usual = posterior.BALANCE * lightest
    if measured.torque_unseen is not None:
        return min(usual, measured.torque_unseen * abs(inertia))
    if measured.balanced is None:
        return usual
    if measured.balanced:
        return min(usual, posterior.BALANCED * abs(inertia))
    return posterior.UNBALANCED * usual


def times_stated(measured: Measurements) -> bool:
    """Return whether the log states the uncertainty of its times."""
    return not any(
        source.quantity == "time" and source.default for source in measured.sources
    )


def _budget(result: FitResult, u: float) -> tuple[Share, ...]:
    """Split u²(I_zz) by source, the largest first; the shares add up to u² [kg²*m⁴].

    The answer is linear in every standardised error, so the squares add up. What the
    posterior adds to u² above all these parts is the doubt about the factor s: it
    widens the errors of single runs, each in proportion, so that the row of a stated
    4 % can be larger than 4 %. If the typical s is above 1, the part of their variance
    above 1/s² is a row of its own, "unexplained_scatter". Of one run, or of as many
    runs as unknowns, nothing determines s: its typical value, 1.3, and its row are
    those of the prior.
    """
    adjusted = result.adjusted
    problem = adjusted.problem
    # Variances of I_zz [kg²*m⁴]: of each run's condition, then of the priors of M0, b
    # and the shared errors.
    of_runs, of_priors = np.split(adjusted.gain**2, [problem.count])
    independent = adjusted.slopes * problem.independent
    variances = independent**2 @ (of_runs / adjusted.independent_variance)
    single = float(variances.sum())
    if single > adjustment.NEGLIGIBLE * u**2:
        wider = max(0.0, u**2 - single - float(of_priors.sum()))
        variances *= 1 + wider / single
    stated = variances / max(result.widths.scatter, 1.0) ** 2
    unexplained = variances - stated
    excess = float(unexplained.sum())
    of_m0, of_bias, *of_shared = of_priors.tolist()
    np.add.at(stated, problem.owners, of_shared)
    by_bias = SOURCES["time_bias"].shared_by
    # The differences of M0 and of b between days are in the rows of M0 and b.
    rows: defaultdict[tuple[str, bool, str], float] = defaultdict(float)
    for source, variance in zip(problem.sources, stated.tolist(), strict=True):
        is_shared = bool(problem.owned_by(source.name).any())
        rows[source.name, is_shared, source.shared_by] += variance
    rows[DAY_BALANCE, True, "all runs"] += of_m0
    rows[DAY_BIAS, True, by_bias] += of_bias
    rows["unexplained_scatter", False, ""] += max(0.0, excess)
    total = math.fsum(rows.values())
    budget = []
    for row, variance in sorted(rows.items(), key=itemgetter(1), reverse=True):
        if variance:
            share = variance / total
            budget.append(Share(*row, u * math.sqrt(share), share))
    return tuple(budget)


# --- corrections for the model of the motion ---

MAX_ROUNDS = 19
"""Largest number of rounds; corrections and fit agree after a few."""

ALIKE = 0.02
"""Corrections agree if they differ by less than this part of the relative u of I_zz.
The last ones are at least ten times as good, because the differences shrink fast."""


def timed_runs(measured: Measurements) -> TimedRuns:
    """Return the readings of a log that a model of motion needs."""
    return TimedRuns(
        time=measured.time,
        turns=measured.turns,
        spin=measured.corrected_spin,
        pitch=measured.pitch,
        sense=measured.sense,
        transverse_u=_transverse_u(measured),
        spin_start=measured.spin_start,
        spin_end=measured.spin_end,
        total_spin=_total_spin_read(measured),
        direction=measured.precession_sense,
        latitude=measured.latitude,
        start=measured.motion,
        lines=measured.metadata,
    )


def _transverse_u(measured: Measurements) -> float:
    """Return the relative standard uncertainty of I [1], the largest of all runs."""
    for source in measured.sources:
        if source.quantity == "transverse":
            return float(source.relative.max())
    # A log without a pitch and without the word "released" has no source for I, though
    # it may state I.
    states_inertia = measured.transverse_inertia is not None
    if states_inertia or measured.nutation_ratio is not None:
        return SOURCES["transverse_inertia"].default.relative
    return TRANSVERSE_U


def _total_spin_read(measured: Measurements) -> Floats | None:
    """Return the total spin of each run [rad/s], shape (n,); None if it was not read.

    A tachometer that stands still reads it. Spins at the start and the end are read
    before a released rod sags.
    """
    if measured.tachometer == "still":
        excess = total_spin_excess(
            measured.sense, measured.turns, measured.time, measured.pitch
        )
        return measured.corrected_spin + excess
    return None if measured.spin_start is None else measured.spin


def top_of(measured: Measurements, near: FitResult) -> Top:
    """Return the tops of n runs with the I_zz and M0 of a fit.

    The weight spins as well.

    Raises
    ------
    NoFit
        If these are not the numbers of a top.
    """
    # The fit can be that of other runs of the same days.
    mean = near.residual_torque.value
    days = near.adjusted.problem.measured.day.tolist()
    m0_of_day = dict(zip(days, near.balances.tolist(), strict=True))
    m0 = [m0_of_day.get(day, mean) for day in measured.day.tolist()]
    transverse = adjustment.transverse_inertia(measured)
    try:
        return Top(
            inertia=near.inertia.value + measured.added,
            transverse_inertia=transverse,
            torque=measured.torque + m0,
        )
    except ValueError as error:
        raise NoFit(f"the fit gives a top that cannot exist: {error}") from None


def _corrected(measured: Measurements, near: FitResult, chosen: Motion) -> Measurements:
    """Correct the angles of the runs for the motion, with the result of a fit.

    The runs also get the sources of error that exist only with this motion.
    """
    top = top_of(measured, near)
    slowing, errors = chosen.correction(top, timed_runs(measured))
    sources = (*measured.sources, *map(_source_of, errors))
    return replace(measured, slowing=slowing, sources=sources)


def _source_of(error: ModelError) -> Source:
    """Return an error of a model of motion as a source of error of the log."""
    nothing = np.zeros(len(error.size))
    every = np.zeros(len(nothing), dtype=int)
    own = np.arange(len(nothing))
    is_time = error.quantity == "time"
    return Source(
        error.name,
        error.quantity,
        every if error.shared_by else own,
        error.size if is_time else nothing,
        nothing if is_time else error.size,
        error.shared_by,
        True,
        error.described,
        of_motion=True,
    )


def fit_model(
    measured: Measurements,
    chosen: Motion,
    left_out: Collection[int] = (),
    widths: Widths | None = None,
    near: FitResult | None = None,
) -> tuple[Measurements, FitResult]:
    """Fit a log with a motion: fit and correct the runs until both agree.

    Parameters
    ----------
    measured : Measurements
        The runs; earlier corrections are removed first.
    chosen : Motion
        How the rods moved.
    left_out, widths
        As for `fit`.
    near : FitResult, optional
        A fit of nearly the same log, from which the corrections start.

    Returns
    -------
    Measurements
        The corrected runs, with the sources of error of this motion.
    FitResult

    Raises
    ------
    NoFit
        If there is no credible solution.
    """
    fitted = partial(fit, tilted=chosen.tilted, left_out=left_out)
    sources = tuple([source for source in measured.sources if not source.of_motion])
    bare = replace(measured, slowing=1.0, sources=sources)
    if not chosen.is_corrected(timed_runs(bare)):
        return bare, fitted(bare, widths)
    runs = _corrected(bare, near or fitted(bare, AS_STATED), chosen)
    for _round in range(MAX_ROUNDS):
        result = fitted(runs, AS_STATED)
        before = runs
        runs = _corrected(bare, result, chosen)
        if _correct_alike(before, runs, result):
            break
    return runs, fitted(runs, widths)


def _correct_alike(runs: Measurements, other: Measurements, result: FitResult) -> bool:
    """Return whether two corrections of the same runs give the same I_zz.

    They do if they differ by a small part of u of I_zz.
    """
    differ = np.abs(runs.slowing - other.slowing)
    # A run without a steady precession has no correction.
    worst = float(np.max(differ[np.isfinite(differ)], initial=0.0))
    return worst <= ALIKE * relative_u(result.inertia)
