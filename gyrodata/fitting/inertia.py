"""The recommended fit: I_zz from raw readings, with errors carried by what they are shared by; and what fits give back.

First the runs are adjusted as stated (`fit_as_stated`); then what the log does not know of its own widths is
integrated over (`posterior`), and the runs are adjusted once more at the widths that were found.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.fitting.adjustment import (
    ASTRAY,
    FACTOR,
    Adjusted,
    NoFit,
    Start,
    adjust,
    assume_sense,
    first_guess,
    misfit,
    robust_start,
)
from gyrodata.fitting.conditions import NEGLIGIBLE, Problem, torques_differ
from gyrodata.fitting.posterior import (
    BALANCE,
    BALANCED,
    STEPS,
    UNBALANCED,
    Conditions,
    Posterior,
    integrate,
    mixed,
)
from gyrodata.measurements import SOURCES, Measurements
from gyrodata.physics import Floats

ONE_SIGN = 1e-4
"""A sign of M0 that is less likely than this is not looked into."""


class Estimate(Struct, frozen=True):
    """A value with its standard uncertainty (k = 1)."""

    value: float
    u: float | None
    """None where nothing tells it; the reason is in the note of its fit."""
    interval_95: tuple[float, float] | None = None
    """Where it is not value ± 1.96 u."""


class Share(Struct, frozen=True):
    """What one source of uncertainty contributes to u(I_zz)."""

    source: str
    shared: bool
    shared_by: str
    u_inertia: float
    """[kg*m^2]"""
    share: float
    """Of the variance [1]; the shares of a budget add up to 1."""


class Outlier(Struct, frozen=True):
    """A run that does not go with the others."""

    index: int
    deviation: float
    """Of its time from what the other runs predict, in standard uncertainties of that difference."""
    turns: float | None
    """Number of revolutions that would explain it."""
    slip: bool
    """True if it is no measurement of this motion: a count explains it, or it is off beyond all doubt."""
    expected: float = math.nan
    """Time that the other runs predict [s]."""
    cells: tuple[str, ...] = ()
    """Corrections of one cell with which it agrees with the other runs, in words, the likeliest first."""
    maybe: str = ""
    """A correction that fits and explains less, in words: the spin that its time needs, or a slip of the pen in a run
    that is not far off."""


class FitResult(Struct, frozen=True, eq=False, dict=True):
    """The adjusted unknowns of one log of n runs.

    Convention: Gauss–Helmert least squares in the raw readings; derivatives and proportional uncertainties at
    the adjusted values; standard uncertainties from the stated ones, not scaled by chi-square.
    """

    inertia: Estimate
    """I_zz [kg*m^2]."""
    imbalance: Estimate
    """M0 [N*m]: the torque is M + M0."""
    timing_bias: Estimate
    """b [s]: a clock reading is the true time plus b."""
    covariance: Floats
    """Of (I_zz, M0, b), shape (3, 3)."""
    chi2: float
    dof: int
    deviations: Floats
    """Time minus what the *other* runs predict, over the standard uncertainty of that difference, shape (n,)."""
    influence: Floats
    """Change of I_zz when one run is left out, to first order [kg*m^2]; 0 for a run that is, shape (n,)."""
    budget: tuple[Share, ...]
    balance_u: float
    """Width of M0 with which the runs were adjusted [N*m]."""
    scatter: float
    """Factor on the errors that a run has alone with which they were [1]."""
    contradicted_balance: float | None
    """Width [N*m] that a balance test allowed M0 where the data contradict it, and so were left alone; or None."""
    two_signs: bool
    """True if the log leaves the sign of M0 open and both are in the answer."""
    sense: Floats
    """Sign of φ̇ψ̇ used for each run, shape (n,)."""
    adjusted: Adjusted
    """Where the adjustment ended; of two possible answers the likelier."""
    posterior: Posterior | None
    """The answer as a mixture; None of a fit at one width."""

    @cached_property
    def _predicted(self) -> tuple[Floats, Floats]:
        return _predict(self.adjusted, self.sense)

    @property
    def fitted_time(self) -> Floats:
        """Time that the fit predicts for each run [s], shape (n,)."""
        return self._predicted[0]

    @property
    def time_u(self) -> Floats:
        """Standard uncertainty of a run's time about the fit, from the errors that it has alone [s], shape (n,)."""
        return self._predicted[1]

    @property
    def log_evidence(self) -> float:
        """Logarithm of how likely the times are, whatever I_zz, M0, b and all widths are, but for a constant [1]."""
        assert self.posterior is not None
        kept = self.adjusted.kept > 0
        return float(self.posterior.evidence) - float(np.log(self.time_u[kept] / self.scatter).sum())

    @property
    def response(self) -> Floats:
        """Relative change of I_zz for a relative change of each run's own M/(φ̇ψ̇) [1], shape (n,).

        M/(φ̇ψ̇) too high by r raises the condition by 2π f I_zz ψ̇ r.
        """
        problem = self.adjusted.problem
        lever = 2 * np.pi * problem.observed[2] * problem.observed[1]
        return cast(Floats, -self.adjusted.gain[: problem.count] * lever / np.sqrt(self.adjusted.own))

    def __repr__(self) -> str:
        return f"<FitResult: I_zz = {self.inertia.value:.6g} kg*m^2, u = {self.inertia.u:.2g} kg*m^2, dof {self.dof}>"


def fit(
    measured: Measurements, tilted: bool = False, left_out: Collection[int] = (), stated: FitResult | None = None
) -> FitResult:
    """Find I_zz, M0 and b of one log, with their uncertainties.

    One prior for all designs: M0 is a Cauchy of a twentieth of the lightest torque, a balance test in the log is
    evidence about it that may be false, b has the width of ``u_time_bias``, and the errors that each run has alone are
    a common factor wider or narrower than stated (`posterior`). Runs left out have no say, but what the others predict
    for them is worked out. Raises `NoFit` where there is no solution, or none that can be believed. `stated` is what
    `fit_as_stated` gives of the same runs, where that is at hand.
    """
    one_sign = bool(measured.sense.all())
    begun = [stated] if stated is not None and one_sign else _by_sign(measured, tilted, left_out)
    results = [_integrated(measured, one) for one in begun]
    results.sort(key=lambda pair: -float(pair[1].evidence))
    first, posterior = results[0]
    several = [other for _, other in results if other.evidence > posterior.evidence + math.log(ONE_SIGN)]
    if len(several) > 1:
        first, posterior = replace(first, two_signs=True), mixed(several)
    return _with_posterior(measured, first, posterior)


def fit_as_stated(
    measured: Measurements, tilted: bool = False, left_out: Collection[int] = (), start: Start | None = None
) -> FitResult:
    """Fit with every width as it was stated, and an M0 that may be as large as the lightest torque: for screening.

    `start` is `first_guess` of these runs with the sense of their torques, where that is at hand.
    """
    return min(_by_sign(measured, tilted, left_out, start), key=lambda result: result.chi2)


def refit(result: FitResult, measured: Measurements, tilted: bool, balanced: bool = False) -> FitResult:
    """Fit runs again at the widths of another fit of them, after something in the runs or in the model has changed.

    Of a ball that is `balanced` M0 is 0, and runs without a weight, which then stand still, have no say.
    """
    inertia, imbalance = result.adjusted.unknowns[:2].tolist()
    width, kept = result.balance_u, result.adjusted.kept
    if balanced:
        width, imbalance, kept = NEGLIGIBLE * width, 0.0, kept * (measured.torque != 0)
    problem = Problem(measured, tilted).with_scatter(result.scatter)
    adjusted = adjust(problem, result.sense, Start(inertia, imbalance), width, kept, ASTRAY, result.adjusted)
    return _result(measured, adjusted, result.sense, width, result.scatter, adjusted.chi2, True)


def _by_sign(
    measured: Measurements, tilted: bool, left_out: Collection[int], start: Start | None = None
) -> list[FitResult]:
    """Fit as stated once, or for both signs of M0 where only unloaded runs without a sense would tell them apart."""
    kept = np.ones(len(measured.runs))
    kept[list(left_out)] = 0.0
    if measured.sense[kept > 0].all():
        return [_as_stated(measured, assume_sense(measured, 1.0), tilted, kept, start)]
    signed: list[tuple[float, FitResult]] = []
    for sign in (1.0, -1.0):
        try:
            signed.append((sign, _as_stated(measured, assume_sense(measured, sign), tilted, kept)))
        except NoFit:
            # This may be the sign that M0 cannot have.
            if sign < 0 and not signed:
                raise
    return [result for sign, result in signed if result.imbalance.value * sign > 0] or [result for _, result in signed]


def lightest_torque(measured: Measurements, kept: Floats) -> float:
    """Smallest torque of the runs that have a say, but for those without any [N*m]."""
    sizes = np.abs(measured.torque[(kept > 0) & (measured.torque != 0)])
    return float(sizes.min()) if len(sizes) else float(np.abs(measured.torque).max())


def _as_stated(
    measured: Measurements, sense: Floats, tilted: bool, kept: Floats, near: Start | None = None
) -> FitResult:
    free, width = torques_differ(measured.torque[kept > 0]), lightest_torque(measured, kept)
    problem, factor = Problem(measured, tilted), 1.0
    try:
        adjusted = adjust(problem, sense, near or first_guess(measured, sense, kept), width, kept, FACTOR)
    except NoFit:
        # A slip of hundreds of standard uncertainties is best explained by all spins being infinite, for their
        # errors are proportional, or by an M0 that takes all torque away. Larger errors of the single runs and a
        # modest M0 keep the answer where the runs are.
        start = robust_start(measured, sense, kept)
        factor = max(1.0, misfit(measured, start, kept))
        if factor > 1:
            width = 0.1 * width
        adjusted = adjust(problem.with_scatter(factor), sense, start, width, kept, ASTRAY)
    prior = (float(adjusted.unknowns[1]) / width) ** 2 if free else 0.0
    # A prior that says nothing is not a datum: neither its pull nor its degree of freedom counts.
    return _result(measured, adjusted, sense, width, factor, factor**2 * (adjusted.chi2 - prior), free)


def _result(
    measured: Measurements, adjusted: Adjusted, sense: Floats, width: float, scatter: float, chi2: float, free: bool
) -> FitResult:
    inertia, imbalance, bias = (float(value) for value in adjusted.unknowns)
    u = np.sqrt(np.diag(adjusted.covariance))
    return FitResult(
        inertia=Estimate(inertia, float(u[0])),
        imbalance=Estimate(imbalance, float(u[1])),
        timing_bias=Estimate(bias, float(u[2])),
        covariance=adjusted.covariance,
        chi2=chi2,
        dof=int(adjusted.kept.sum()) - 1 - int(free),
        deviations=adjusted.deviations,
        influence=adjusted.influence,
        budget=(),
        balance_u=width,
        scatter=scatter,
        contradicted_balance=None,
        two_signs=False,
        sense=sense,
        adjusted=adjusted,
        posterior=None,
    )


def _integrated(measured: Measurements, stated: FitResult) -> tuple[FitResult, Posterior]:
    """Integrate over the widths, adjust at those found, and integrate there."""
    posterior = integrate_at(measured, stated)
    scatter, width = _typical(posterior)
    start = Start(*posterior.middle()[:2].tolist())
    problem = stated.adjusted.problem.with_scatter(scatter / stated.scatter)
    try:
        adjusted = adjust(problem, stated.sense, start, width, stated.adjusted.kept, FACTOR, stated.adjusted)
    except NoFit:
        return stated, posterior
    free = torques_differ(measured.torque[stated.adjusted.kept > 0])
    result = _result(measured, adjusted, stated.sense, width, scatter, stated.chi2, free)
    return result, integrate_at(measured, result, posterior)


def integrate_at(measured: Measurements, result: FitResult, near: Posterior | None = None) -> Posterior:
    """Integrate over the widths of a log, linear where a fit of it ended; I_zz in kg*m^2, M0 in N*m, b in s."""
    inertia, (conditions, unit) = result.inertia.value, _linear(measured, result)
    tested = None
    if measured.imbalance_u is not None:
        tested = measured.imbalance_u(inertia) / unit[1]
    scale = balance_scale(measured, inertia, lightest=float(unit[1])) / unit[1]
    return integrate(conditions, scale, times_stated(measured), tested, near).times(unit)


def _linear(measured: Measurements, result: FitResult) -> tuple[Conditions, Floats]:
    """Conditions of a log, linear where a fit of it ended, and the units of I_zz, M0 and b in them, shape (3,)."""
    adjusted = result.adjusted
    lightest = lightest_torque(measured, adjusted.kept)
    unit = np.array([abs(result.inertia.value), lightest, measured.timing_bias_u])
    rows = result.scatter * adjusted.rows
    # A fit counts M0 in the width that it had there.
    rows[:, 1] *= lightest / adjusted.scale[1]
    rows[:, 0] *= unit[0] / adjusted.scale[0]
    conditions = Conditions(
        unknowns=rows[:, :3],
        shared=rows[:, 3:],
        left=result.scatter * adjusted.weighted - rows[:, 3:] @ adjusted.shared,
        ended=adjusted.unknowns / np.where(unit > 0, unit, 1.0),
        runs=np.asarray(adjusted.kept.sum()),
        scatter=np.asarray(result.scatter),
    )
    return conditions, unit


class Otherwise(Struct, frozen=True):
    """What is taken otherwise than a fit did."""

    sizes: Mapping[str, Floats | float] = {}
    """The errors of a source are so many times as wide, by its name; shape () or (n,)."""
    bias: float | None = None
    """b is exactly this [s]; only where a fit left it open."""
    balance: float | None = None
    """Scale of M0's Cauchy over the lightest torque; a balance test then says nothing."""


def fit_otherwise(
    measured: Measurements, result: FitResult, cases: Sequence[Otherwise], rough: bool = False
) -> list[Estimate]:
    """I_zz as it would be if something were otherwise, all cases at once, linear where a fit ended.

    `rough`: value and u alone, to six digits.
    """
    # The first is as the fit did it: what is less known than there, the sign of M0, is added to all. Where that is
    # known, it makes no difference but that of where two iterations stop.
    bare = rough and not result.two_signs
    cases = cases if bare else [Otherwise(), *cases]
    (linear, unit), adjusted = _linear(measured, result), result.adjusted
    problem, inertia = adjusted.problem, result.inertia.value
    times = np.ones((len(cases), *adjusted.slopes.shape))
    for each, case in zip(times, cases, strict=True):
        for at, source in enumerate(problem.sources):
            each[at] = case.sizes.get(source.name, 1.0)
    alone = (adjusted.slopes * problem.alone) ** 2 / adjusted.own
    weight = 1 / np.sqrt(1 + np.add.reduce((times**2 - 1) * alone, axis=1))
    shared = weight[..., None] * linear.shared
    shared[:, problem.from_run, problem.to_column] *= times[:, problem.from_source, problem.from_run]
    fixed = np.array([case.bias is not None for case in cases])
    # What b is in place of what the fit found, in its unit.
    moved = [0.0 if case.bias is None else case.bias / unit[2] - linear.ended[2] for case in cases]
    unknowns = weight[..., None] * linear.unknowns
    left = weight * (linear.left + np.array(moved)[:, None] * linear.unknowns[:, 2])
    unknowns[fixed, :, 2] = 0.0
    conditions = Conditions(
        unknowns, shared, left, np.tile(linear.ended, (len(cases), 1)),
        np.full(len(cases), linear.runs), np.full(len(cases), linear.scatter),
    )  # fmt: skip
    usual, tested = balance_scale(measured, inertia, lightest=float(unit[1])) / unit[1], None
    if measured.imbalance_u is not None:
        allowed = measured.imbalance_u(inertia) / unit[1]
        tested = np.array([allowed if case.balance is None else UNTESTED for case in cases])
    scale = np.array([usual if case.balance is None else case.balance for case in cases])
    posterior = integrate(conditions, scale, times_stated(measured), tested)
    if bare:
        middle = (unit[0] * posterior.quantiles(1, slice(1, 4))[:, 0]).tolist()
        return [Estimate(value, (above - below) / 2) for below, value, above in middle]
    ends = unit[0] * posterior.quantiles()[:, 0]
    assert result.posterior is not None
    # What is added may put quantiles in another order, where a log is nonsense.
    return [_estimate(each) for each in np.sort(ends[1:] + (result.posterior.quantiles()[0] - ends[0]))]


UNTESTED = 1e6
"""Width of a balance test that says nothing, over the lightest torque [1]."""


def _estimate(ends: Floats) -> Estimate:
    """Make a value of the quantiles at `LEVELS`: the median, half the 68.3 % interval and the 95 % interval."""
    low, below, middle, above, high = ends.tolist()
    return Estimate(middle, (above - below) / 2, (low, high))


def if_balanced(measured: Measurements, result: FitResult) -> Estimate:
    """I_zz of a fit if the ball is balanced: M0 nothing but what "balanced: yes" leaves."""
    return _estimate(integrate_at(replace(measured, balanced=True, imbalance_u=None), result).quantiles()[0])


def balance_scale(
    measured: Measurements, inertia: Floats | float, kept: Floats | None = None, lightest: float | None = None
) -> Any:
    """Scale of M0's Cauchy before the runs are looked at [N*m], for an I_zz or many [kg*m^2].

    A weight that was misread says nothing of the balance: only runs that have a say count.
    """
    if lightest is None:
        lightest = lightest_torque(measured, np.ones(len(measured.runs)) if kept is None else kept)
    usual = BALANCE * lightest
    if measured.torque_unseen is not None:
        return np.minimum(usual, measured.torque_unseen * np.abs(inertia))
    if measured.balanced is None:
        return usual
    return np.minimum(usual, BALANCED * np.abs(inertia)) if measured.balanced else UNBALANCED * usual


def times_stated(measured: Measurements) -> bool:
    """Whether the log states how wide the errors of its times are."""
    return not any(source.default for source in measured.sources if source.quantity == "time")


def _typical(posterior: Posterior) -> tuple[float, float]:
    """Factor s, and the width of M0 with which alone I_zz is known as well as with all of them [N*m]."""
    # Parts of one s stand together, each s with as many widths.
    each = posterior.weight.reshape(STEPS, -1)
    count = each.shape[1]
    factor = float(posterior.typical(posterior.factor))
    most = np.maximum.reduce(each, axis=1)
    away = np.abs(np.log(posterior.factor[::count] / factor))
    at = int(np.where(most > 1e-6 * np.maximum.reduce(most), away, np.inf).argmin())
    nearest, weight = slice(at * count, (at + 1) * count), each[at] / np.add.reduce(each[at])
    u = posterior.u[0, nearest]
    part = Posterior(weight, posterior.mean[:1, nearest], u[None], *(posterior.factor,) * 2, weight)
    ends = part.quantiles(1, slice(1, 4, 2))[0]
    order = u.argsort()
    widths = np.log(posterior.width[nearest][order])
    return factor, float(np.exp(np.interp((ends[1] - ends[0]) / 2, u[order], widths)))


def _with_posterior(measured: Measurements, result: FitResult, posterior: Posterior) -> FitResult:
    """Give a fit the answer of the posterior, and the budget of that."""
    quantiles = posterior.quantiles(3)
    estimates = [_estimate(ends) for ends in quantiles]
    u = float(quantiles[0, 3] - quantiles[0, 1]) / 2
    contradicted = None
    if measured.imbalance_u is not None:
        allowed, alone = (
            measured.imbalance_u(result.inertia.value),
            integrate_at(replace(measured, imbalance_u=None), result),
        )
        ends = alone.quantiles(2)[1]
        if abs(ends[2]) > CONTRADICTED * math.hypot(allowed, (ends[3] - ends[1]) / 2):
            contradicted = allowed
    return replace(
        result,
        inertia=estimates[0],
        imbalance=estimates[1],
        timing_bias=estimates[2],
        budget=_budget(result, u),
        contradicted_balance=contradicted,
        posterior=posterior,
    )


CONTRADICTED = 3.0
"""So many standard uncertainties from 0 the runs see an M0 that a balance test denies."""


def _predict(adjusted: Adjusted, sense: Floats) -> tuple[Floats, Floats]:
    """Time that the fit predicts from each run's other readings, and the spread expected about it [s]."""
    problem = adjusted.problem
    values, _ = problem.truth(np.zeros_like(adjusted.slopes), adjusted.shared)
    inertia, imbalance, bias = (float(value) for value in adjusted.unknowns)
    torque, whole = problem.torque(values)[0] + imbalance, inertia + values[10]
    if problem.tilted:
        rate = np.abs(physics.precession_rate(torque, sense * values[1], whole, values[9], values[8]))
    else:
        rate = np.abs(physics.horizontal_precession_rate(torque, values[1], whole))
    with np.errstate(divide="ignore"):
        # The condition is the time multiplied by the torque at work, and so is its spread.
        return 2 * np.pi * values[2] / rate + bias, np.sqrt(adjusted.own) / np.abs(torque)


def _budget(result: FitResult, u: float) -> tuple[Share, ...]:
    """Split u²(I_zz) by source: the answer is linear in every standardised error, so the squares add up.

    What the runs scatter more than stated, and what is left to say of u, is a row of its own.
    """
    adjusted = result.adjusted
    problem, gain, count = adjusted.problem, adjusted.gain, adjusted.problem.count
    variances = (adjusted.slopes * problem.alone) ** 2 @ (gain[:count] ** 2 / adjusted.own)
    excess = float(variances.sum()) * (1 - 1 / max(result.scatter, 1.0) ** 2)
    variances /= max(result.scatter, 1.0) ** 2
    owners = np.zeros(problem.shared_count, dtype=int)
    owners[problem.to_column] = problem.from_source
    np.add.at(variances, owners, gain[count + 2 :] ** 2)
    shared = set(owners.tolist())
    shares = [
        (source.name, s in shared, source.shared_by, math.sqrt(variance))
        for s, (source, variance) in enumerate(zip(problem.sources, variances.tolist(), strict=True))
        if variance > 0
    ]
    for row, name, words in (
        (count, "residual_torque", "all runs"),
        (count + 1, "time_bias", SOURCES["time_bias"].shared_by),
    ):
        if gain[row]:
            shares.append((name, True, words, abs(float(gain[row]))))
    told = excess + math.fsum(own**2 for *_, own in shares)
    if excess > NEGLIGIBLE * told:
        # The doubt about the scatter widens the tails too.
        excess += max(0.0, u**2 - told)
    if excess > 0:
        shares.append(("unexplained_scatter", False, "", math.sqrt(excess)))
    return _normalised(shares, u)


def _normalised(shares: list[tuple[str, bool, str, float]], u: float) -> tuple[Share, ...]:
    """Largest first; they add up to u² [kg²*m⁴]."""
    total = math.fsum(own**2 for *_, own in shares)
    if not total:
        return ()
    size = u / math.sqrt(total)
    ordered = sorted(shares, key=lambda share: -share[3])
    return tuple(Share(name, shared, by, size * own, own**2 / total) for name, shared, by, own in ordered)
