"""The one fit: I_zz, M0 and b from the raw readings of one log, with the errors that its runs share.

First the runs are adjusted with the stated widths; then the fit integrates over the widths that the log does not know
(`posterior`), and adjusts the runs once more at the typical widths.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import cached_property
from typing import cast

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
from gyrodata.fitting.conditions import ADDED, NEGLIGIBLE, PITCH, SPIN, TRANSVERSE, TURNS, Problem, torques_differ
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


UNITS = ("kg*m^2", "N*m", "s")
"""Of the unknowns I_zz, M0 and b."""


class Estimate(Struct, frozen=True):
    """A value with its standard uncertainty (k = 1)."""

    value: float
    u: float | None
    """null if the runs do not determine it; the note of its fit contains the reason."""
    unit: str
    interval_95: tuple[float, float] | None = None
    """null if it is value ± 1.96 u, or is not computed."""


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


class Widths(Struct, frozen=True):
    """Widths of the errors that a log knows only roughly."""

    scatter: float
    """Factor s on the errors that only one run has [1]."""
    residual_torque: float | None
    """Width of M0 [N*m]; None: the lightest torque."""


AS_STATED = Widths(1.0, None)
"""Each width as the log states it, and an M0 that may be as large as the lightest torque: for screening."""


class FitResult(Struct, frozen=True, eq=False, dict=True):
    """The adjusted unknowns of one log of n runs.

    Convention: Gauss–Helmert least squares in the raw readings; derivatives and proportional uncertainties at
    the adjusted values; standard uncertainties from the stated ones, not scaled by chi-square.
    """

    inertia: Estimate
    """I_zz [kg*m^2]."""
    residual_torque: Estimate
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
    widths: Widths
    """Widths with which the runs were adjusted."""
    contradicted_balance: float | None
    """Width [N*m] that a balance test allowed M0 where the data contradict it, and so were left alone; or None."""
    two_signs: bool
    """True if the log leaves the sign of M0 open and both are in the answer."""
    sense: Floats
    """Sign of φ̇ψ̇ used for each run, shape (n,)."""
    adjusted: Adjusted
    """Where the adjustment ended; of two possible answers the likelier."""
    posterior: Posterior | None
    """The answer as a mixture; None if the fit was asked for at fixed widths."""

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
        return self.posterior.evidence - float(np.log(self.time_u[kept] / self.scatter).sum())

    @property
    def scatter(self) -> float:
        """Factor s on the errors that only one run has, with which the runs were adjusted [1]."""
        return self.widths.scatter

    @property
    def response(self) -> Floats:
        """Relative change of I_zz for a relative change of each run's own M/(φ̇ψ̇) [1], shape (n,).

        M/(φ̇ψ̇) too high by r raises the condition by 2π f I_zz ψ̇ r.
        """
        problem = self.adjusted.problem
        lever = 2 * np.pi * problem.observed[TURNS] * problem.observed[SPIN]
        return cast(Floats, -self.adjusted.gain[: problem.count] * lever / np.sqrt(self.adjusted.independent_variance))

    def __repr__(self) -> str:
        return f"<FitResult: I_zz = {self.inertia.value:.6g} kg*m^2, u = {self.inertia.u:.2g} kg*m^2, dof {self.dof}>"


def fit(
    measured: Measurements,
    widths: Widths | None = None,
    *,
    tilted: bool = False,
    left_out: Collection[int] = (),
    near: FitResult | None = None,
) -> FitResult:
    """Find I_zz, M0 and b of one log, with their uncertainties.

    There is one prior for all designs: M0 has a Cauchy distribution of a twentieth of the lightest torque; a balance
    test in the log is evidence about M0 that may be false; b has the width of ``u_time_bias``; and the errors that only
    one run has are wider or narrower than stated by a common factor s (`posterior`).

    Parameters
    ----------
    measured : Measurements
        The n runs.
    widths : Widths, optional
        Fit at these widths, instead of integrating over all; `AS_STATED` does not integrate either.
    tilted : bool
        Use eq. (8) with each run's pitch, not eq. (9).
    left_out : collection of int
        Runs that are not used; the fit still predicts their times.
    near : FitResult, optional
        A fit of a similar log: this fit begins there, and takes a third of the time. It gives the same I_zz; M0 and b
        are those at one width, and there is no budget.

    Returns
    -------
    FitResult

    Raises
    ------
    NoFit
        If there is no solution, or none that can be believed.
    """
    kept = np.ones(len(measured.runs))
    kept[list(left_out)] = 0.0
    if near is not None and (widths or measured.sense.all()):
        begun = [_at_widths(measured, near.widths if widths is None else widths, tilted, kept, near)]
    else:
        begun = _by_sign(measured, tilted, kept)
    if widths is not None:
        return min(begun, key=lambda result: result.chi2)
    results = [_integrated(measured, one, near) for one in begun]
    results.sort(key=lambda pair: -pair[1].evidence)
    first, posterior = results[0]
    several = [other for _, other in results if other.evidence > posterior.evidence + math.log(ONE_SIGN)]
    if len(several) > 1:
        first, posterior = replace(first, two_signs=True), mixed(several)
    return _with_posterior(measured, first, posterior, near is not None)


def _at_widths(measured: Measurements, widths: Widths, tilted: bool, kept: Floats, near: FitResult) -> FitResult:
    """Fit at some widths, from where a fit of a similar log ended."""
    inertia, residual_torque = near.adjusted.unknowns[:2].tolist()
    sense = assume_sense(measured, math.copysign(1.0, residual_torque))
    width = lightest_torque(measured, kept) if widths.residual_torque is None else widths.residual_torque
    start = Start(inertia, max(-width, min(residual_torque, width)))
    problem = Problem(measured, tilted).with_scatter(widths.scatter)
    adjusted = adjust(problem, sense, start, width, kept, ASTRAY, near.adjusted)
    return _result(measured, adjusted, sense, Widths(widths.scatter, width), adjusted.chi2)


def _by_sign(measured: Measurements, tilted: bool, kept: Floats) -> list[FitResult]:
    """Fit as stated once, or for both signs of M0 if only unloaded runs without a sense would tell them apart."""
    if measured.sense[kept > 0].all():
        return [_as_stated(measured, assume_sense(measured, 1.0), tilted, kept)]
    signed: list[tuple[float, FitResult]] = []
    for sign in (1.0, -1.0):
        try:
            signed.append((sign, _as_stated(measured, assume_sense(measured, sign), tilted, kept)))
        except NoFit:
            # This may be the sign that M0 cannot have.
            if sign < 0 and not signed:
                raise
    agree = [result for sign, result in signed if result.residual_torque.value * sign > 0]
    return agree or [result for _, result in signed]


def lightest_torque(measured: Measurements, kept: Floats) -> float:
    """Smallest torque of the runs that have a say, but for those without any [N*m]."""
    sizes = np.abs(measured.torque[(kept > 0) & (measured.torque != 0)])
    return float(sizes.min()) if len(sizes) else float(np.abs(measured.torque).max())


def _as_stated(measured: Measurements, sense: Floats, tilted: bool, kept: Floats) -> FitResult:
    width = lightest_torque(measured, kept)
    problem, factor = Problem(measured, tilted), 1.0
    try:
        adjusted = adjust(problem, sense, first_guess(measured, sense, kept), width, kept, FACTOR)
    except NoFit:
        # A mistake of hundreds of standard uncertainties is best explained by all spins being infinite, for their
        # errors are proportional, or by an M0 that takes all torque away. Larger errors of the single runs and a
        # modest M0 keep the answer near the runs.
        start = robust_start(measured, sense, kept)
        factor = max(1.0, misfit(measured, start, kept))
        if factor > 1:
            width = 0.1 * width
        adjusted = adjust(problem.with_scatter(factor), sense, start, width, kept, ASTRAY)
    prior = (float(adjusted.unknowns[1]) / width) ** 2 if torques_differ(measured.torque[kept > 0]) else 0.0
    # A prior that says nothing is not a datum: neither its pull nor its degree of freedom counts.
    return _result(measured, adjusted, sense, Widths(factor, width), factor**2 * (adjusted.chi2 - prior))


def _result(measured: Measurements, adjusted: Adjusted, sense: Floats, widths: Widths, chi2: float) -> FitResult:
    u = np.sqrt(np.diag(adjusted.covariance))
    inertia, residual_torque, bias = map(Estimate, adjusted.unknowns.tolist(), u.tolist(), UNITS)
    return FitResult(
        inertia=inertia,
        residual_torque=residual_torque,
        timing_bias=bias,
        covariance=adjusted.covariance,
        chi2=chi2,
        dof=int(adjusted.kept.sum()) - 1 - int(torques_differ(measured.torque[adjusted.kept > 0])),
        deviations=adjusted.deviations,
        influence=adjusted.influence,
        budget=(),
        widths=widths,
        contradicted_balance=None,
        two_signs=False,
        sense=sense,
        adjusted=adjusted,
        posterior=None,
    )


def _integrated(measured: Measurements, begun: FitResult, near: FitResult | None) -> tuple[FitResult, Posterior]:
    """Integrate over the widths, adjust at the typical ones unless those of `near` are similar, and integrate there."""
    posterior = integrate_at(measured, begun)
    if near is not None and near.posterior is not None and posterior.is_similar(near.posterior):
        return begun, posterior
    widths = _typical(posterior)
    assert widths.residual_torque is not None
    start = Start(*posterior.middle()[:2].tolist())
    problem = begun.adjusted.problem.with_scatter(widths.scatter / begun.scatter)
    try:
        adjusted = adjust(
            problem, begun.sense, start, widths.residual_torque, begun.adjusted.kept, FACTOR, begun.adjusted
        )
    except NoFit:
        return begun, posterior
    result = _result(measured, adjusted, begun.sense, widths, begun.chi2)
    return result, integrate_at(measured, result, posterior)


def integrate_at(measured: Measurements, result: FitResult, near: Posterior | None = None) -> Posterior:
    """Integrate over the widths of a log, linear at the end of a fit of it; I_zz in kg*m^2, M0 in N*m, b in s."""
    adjusted, inertia = result.adjusted, result.inertia.value
    lightest = lightest_torque(measured, adjusted.kept)
    unit = np.array([abs(inertia), lightest, measured.timing_bias_u])
    rows = result.scatter * adjusted.rows
    # A fit counts M0 in the width that it had there.
    rows[:, 1] *= lightest / adjusted.scale[1]
    rows[:, 0] *= unit[0] / adjusted.scale[0]
    conditions = Conditions(
        unknowns=rows[:, :3],
        shared=rows[:, 3:],
        left=result.scatter * adjusted.weighted - rows[:, 3:] @ adjusted.shared,
        ended=adjusted.unknowns / np.where(unit > 0, unit, 1.0),
        runs=float(adjusted.kept.sum()),
        scatter=result.scatter,
    )
    tested = None if measured.balance_test is None else measured.balance_test(inertia) / lightest
    scale = balance_scale(measured, inertia, lightest) / lightest
    return integrate(conditions, scale, times_stated(measured), tested, near).times(unit)


def _estimate(ends: Floats, unit: str) -> Estimate:
    """Make a value of the quantiles at `LEVELS`: the median, half the 68.3 % interval and the 95 % interval."""
    low, below, middle, above, high = ends.tolist()
    return Estimate(middle, (above - below) / 2, unit, (low, high))


def balance_scale(measured: Measurements, inertia: float, lightest: float) -> float:
    """Scale of M0's Cauchy before the runs are looked at [N*m], for an I_zz [kg*m^2] and a lightest torque [N*m]."""
    usual = BALANCE * lightest
    if measured.torque_unseen is not None:
        return min(usual, measured.torque_unseen * abs(inertia))
    if measured.balanced is None:
        return usual
    return min(usual, BALANCED * abs(inertia)) if measured.balanced else UNBALANCED * usual


def times_stated(measured: Measurements) -> bool:
    """Whether the log states how wide the errors of its times are."""
    return not any(source.default for source in measured.sources if source.quantity == "time")


def _typical(posterior: Posterior) -> Widths:
    """Factor s, and the width of M0 with which alone I_zz is known as well as with all of them."""
    # Parts of one s are together, each s with as many widths.
    each = posterior.weight.reshape(STEPS, -1)
    count = each.shape[1]
    factor = posterior.typical(posterior.factor)
    most = np.maximum.reduce(each, axis=1)
    away = np.abs(np.log(posterior.factor[::count] / factor))
    at = int(np.where(most > 1e-6 * np.maximum.reduce(most), away, np.inf).argmin())
    nearest, weight = slice(at * count, (at + 1) * count), each[at] / np.add.reduce(each[at])
    u = posterior.u[0, nearest]
    part = Posterior(weight, posterior.mean[:1, nearest], u[None], posterior.factor, posterior.factor, 0.0)
    ends = part.quantiles()[0]
    order = u.argsort()
    widths = np.log(posterior.width[nearest][order])
    return Widths(factor, float(np.exp(np.interp((ends[3] - ends[1]) / 2, u[order], widths))))


def _with_posterior(measured: Measurements, result: FitResult, posterior: Posterior, near: bool) -> FitResult:
    """Give a fit the answer of the posterior; all but I_zz only if it is not `near`."""
    if near:
        return replace(result, inertia=_estimate(posterior.quantiles(1)[0], UNITS[0]), posterior=posterior)
    inertia, residual_torque, timing_bias = map(_estimate, posterior.quantiles(3), UNITS)
    contradicted = None
    if measured.balance_test is not None:
        allowed = measured.balance_test(result.inertia.value)
        ends = integrate_at(replace(measured, balance_test=None), result).quantiles(2)[1]
        if abs(ends[2]) > CONTRADICTED * math.hypot(allowed, (ends[3] - ends[1]) / 2):
            contradicted = allowed
    return replace(
        result,
        inertia=inertia,
        residual_torque=residual_torque,
        timing_bias=timing_bias,
        budget=_budget(result, inertia.u or 0.0),
        contradicted_balance=contradicted,
        posterior=posterior,
    )


CONTRADICTED = 3.0
"""So many standard uncertainties from 0 the runs see an M0 that a balance test denies."""


def _predict(adjusted: Adjusted, sense: Floats) -> tuple[Floats, Floats]:
    """Time that the fit predicts from each run's other readings, and the spread expected about it [s]."""
    problem = adjusted.problem
    values, _ = problem.truth(np.zeros_like(adjusted.slopes), adjusted.shared)
    inertia, residual_torque, bias = adjusted.unknowns.tolist()
    torque, whole = problem.torque(values)[0] + residual_torque, inertia + values[ADDED]
    if problem.tilted:
        spin = sense * values[SPIN]
        rate = np.abs(physics.precession_rate(torque, spin, whole, values[TRANSVERSE], values[PITCH]))
    else:
        rate = np.abs(physics.horizontal_precession_rate(torque, values[SPIN], whole))
    with np.errstate(divide="ignore"):
        # The condition is the time multiplied by the torque at work, and so is its spread.
        return 2 * np.pi * values[TURNS] / rate + bias, np.sqrt(adjusted.independent_variance) / np.abs(torque)


def _budget(result: FitResult, u: float) -> tuple[Share, ...]:
    """Split u²(I_zz) by source: the answer is linear in every standardised error, so the squares add up.

    What the runs scatter more than stated, and what is left to say of u, is a row of its own.
    """
    adjusted = result.adjusted
    problem, gain, count = adjusted.problem, adjusted.gain, adjusted.problem.count
    variances = (adjusted.slopes * problem.independent) ** 2 @ (gain[:count] ** 2 / adjusted.independent_variance)
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
