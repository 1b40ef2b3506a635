"""The fit of one log: I_zz, M0 and b from the raw readings, with errors that runs share.

`fit` first adjusts the runs with the stated uncertainties; then it integrates over the
widths that the log does not know (`posterior`), and adjusts the runs again at the
typical widths. `fit_model` corrects the runs for a model of the motion: a rod that is
released from rest nutates and has a slightly smaller mean rate; for a tilted rod whose
spin falls, the mean rate is not the rate at the mean spin; and the floor turns with the
Earth. These corrections depend on I_zz and M0 a little, so that fit and correction are
iterated.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from contextlib import suppress
from functools import cached_property, partial
from operator import attrgetter, itemgetter
from typing import Literal, cast

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
)
from gyrodata.fitting.posterior import Posterior
from gyrodata.measurements import (
    SOURCES,
    TRANSVERSE_U,
    Measurements,
    Source,
    total_spin_excess,
)
from gyrodata.physics import Floats, motion

ONE_SIGN = 1e-4
"""A sign of M0 that is less probable than this is ignored."""

CONTRADICTED = 3.0
"""Number of standard uncertainties by which the runs must contradict a balance test."""

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
    turns: float | None
    """Number of revolutions that would explain it."""
    slip: bool
    """True if the run is certainly wrong: a number of turns explains it, or it is too
    far off."""
    expected: float = math.nan
    """Time that the other runs predict [s]."""
    cells: tuple[str, ...] = ()
    """Corrections of one cell with which the run agrees with the others, in words, the
    likeliest first."""
    maybe: str = ""
    """A less certain correction in words: the spin that fits the time, or a typing
    error in a run that is not far off."""


class Widths(Struct, frozen=True):
    """Widths of the errors that a log knows only roughly."""

    scatter: float
    """Factor s on the errors of single runs [1]."""
    residual_torque: float | None
    """Width of M0 [N*m]; None: the smallest torque."""


AS_STATED = Widths(1.0, None)
"""The stated widths, and an M0 as large as the smallest torque: for screening."""


class FitResult(Struct, frozen=True, eq=False, dict=True):
    """The adjusted unknowns of one log of n runs.

    Method: Gauss–Helmert least squares in the raw readings, with derivatives and
    proportional uncertainties at the adjusted values. Standard uncertainties come from
    the stated ones, and are not scaled by chi-square.
    """

    inertia: Estimate
    """I_zz [kg*m^2]."""
    residual_torque: Estimate
    """M0 [N*m]: the torque is M + M0."""
    timing_bias: Estimate
    """b [s]: a clock reading is the true time plus b."""
    covariance: Floats
    """Covariance of (I_zz, M0, b), shape (3, 3)."""
    chi2: float
    dof: int
    deviations: Floats
    """Time minus the prediction of the *other* runs, over the standard uncertainty of
    this difference, shape (n,)."""
    widths: Widths
    """Widths with which the runs were adjusted."""
    sense: Floats
    """Sign of φ̇ψ̇ used for each run, shape (n,)."""
    adjusted: Adjusted
    """The end of the adjustment; of two possible answers the likelier one."""
    budget: tuple[Share, ...] = ()
    contradicted_balance: float | None = None
    """Width of M0 according to a balance test that the runs contradict [N*m], else
    None."""
    two_signs: bool = False
    """True if M0 can have either sign, and the answer includes both."""
    posterior: Posterior | None = None
    """The answer as a mixture; None for a fit at fixed widths."""
    as_stated: FitResult | None = None
    """The fit at the stated widths, from which the others were found; None for a fit at
    fixed widths."""

    @cached_property
    def _linear(self) -> adjustment.Linear:
        """The conditions at the end of the adjustment, without the errors of single runs."""
        end = self.adjusted
        return end.problem.linearise(
            np.zeros_like(end.slopes), end.shared, self.sense, end.unknowns
        )

    @cached_property
    def fitted_time(self) -> Floats:
        """Time that the fit predicts for each run from its other readings [s], shape (n,)."""
        inertia, residual_torque, bias = self.adjusted.unknowns.tolist()
        values, torque = self._linear.values, self._linear.torque + residual_torque
        # Eq. (9) if pitch and I are zero, as for a rod that is treated as level.
        top = inertia + values[ADDED], values[TRANSVERSE], values[PITCH]
        rate = np.abs(physics.precession_rate(torque, self.sense * values[SPIN], *top))
        with np.errstate(divide="ignore"):
            return cast(Floats, 2 * np.pi * values[TURNS] / rate + bias)

    @cached_property
    def time_u(self) -> Floats:
        """Standard uncertainty of each run's time about the fit [s], shape (n,).

        It comes from the errors of this run alone.
        """
        end = self.adjusted
        with np.errstate(divide="ignore"):
            # The condition is the time multiplied by the total torque.
            return cast(
                Floats,
                np.sqrt(end.independent_variance)
                / np.abs(self._linear.torque + end.unknowns[1]),
            )

    @property
    def log_evidence(self) -> float:
        """Logarithm of the probability of the times, up to a constant.

        The probability is integrated over I_zz, M0, b and all widths.
        """
        assert self.posterior is not None
        kept = self.adjusted.kept > 0
        return self.posterior.evidence - float(
            np.log(self.time_u[kept] / self.widths.scatter).sum()
        )

    @property
    def response(self) -> Floats:
        """Relative change of I_zz for a relative change of a run's M/(φ̇ψ̇) [1].

        There is a value for each run's own M/(φ̇ψ̇), shape (n,).
        """
        # M/(φ̇ψ̇) too large by the factor 1 + r raises the condition by 2π f I_zz ψ̇ r.
        problem = self.adjusted.problem
        lever = 2 * np.pi * problem.observed[TURNS] * problem.observed[SPIN]
        return cast(
            Floats,
            -self.adjusted.gain[: problem.count]
            * lever
            / np.sqrt(self.adjusted.independent_variance),
        )

    def __repr__(self) -> str:
        return (
            f"<FitResult: I_zz = {self.inertia.value:.6g} kg*m^2, u = "
            f"{self.inertia.u:.2g} kg*m^2, dof {self.dof}>"
        )


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
        Runs that are not used; their times are still predicted.

    Returns
    -------
    FitResult

    Raises
    ------
    NoFit
        If there is no credible solution.
    """
    kept = np.ones(len(measured.runs))
    kept[list(left_out)] = 0.0
    # Without a direction of the runs without a weight, M0 can have both signs.
    signs = (1.0,) if measured.sense[kept > 0].all() else (1.0, -1.0)
    begun: list[FitResult] = []
    agree: list[FitResult] = []
    for sign in signs:
        try:
            result = _at_widths(
                measured,
                adjustment.assume_sense(measured, sign),
                tilted,
                kept,
                widths or AS_STATED,
            )
        except NoFit:
            if sign == signs[-1] and not begun:
                raise
            continue
        begun.append(result)
        if len(signs) > 1 and result.residual_torque.value * sign > 0:
            agree.append(result)
    begun = agree or begun
    if widths is not None:
        return min(begun, key=attrgetter("chi2"))
    found = []
    for result in begun:
        # Integrate over the widths, adjust the runs at the typical ones, and integrate
        # there again.
        answer = _integrate_at(result)
        scatter, width = answer.typical_widths()
        start = Start(*(answer.mean[:2] @ answer.weight).tolist())
        problem = result.adjusted.problem.with_scatter(scatter / result.widths.scatter)
        with suppress(NoFit):
            adjusted = adjustment.adjust(
                problem, result.sense, start, width, kept, adjustment.FACTOR
            )
            result = _result(
                adjusted, result.sense, Widths(scatter, width), result.chi2
            )
            answer = _integrate_at(result)
        found.append((answer.evidence, result, answer))
    found.sort(key=itemgetter(0), reverse=True)
    evidence, first, answer = found[0]
    if len(found) > 1 and found[1][0] > evidence + math.log(ONE_SIGN):
        # The other sign of M0 is possible too.
        first, answer = (
            replace(first, two_signs=True),
            posterior.mixed([answer, found[1][2]]),
        )
    estimates = []
    for (low, below, middle, above, high), unit in zip(
        answer.quantiles(3).tolist(), UNITS, strict=True
    ):
        # The median, half the 68.3 % interval, and the 95 % interval.
        estimates.append(Estimate(middle, (above - below) / 2, unit, (low, high)))
    inertia, residual_torque, bias = estimates
    contradicted = None
    if measured.balance_test is not None:
        allowed = measured.balance_test(first.inertia.value)
        ends = _integrate_at(first, tested=False).quantiles(2)[1]
        if abs(ends[2]) > CONTRADICTED * math.hypot(allowed, (ends[3] - ends[1]) / 2):
            contradicted = allowed
    return replace(
        first,
        inertia=inertia,
        residual_torque=residual_torque,
        timing_bias=bias,
        posterior=answer,
        contradicted_balance=contradicted,
        budget=_budget(first, inertia.u or 0.0),
        as_stated=min(begun, key=attrgetter("chi2")),
    )


def lightest_torque(measured: Measurements, kept: Floats) -> float:
    """Return the smallest torque of the kept runs that is not zero [N*m]."""
    sizes = np.abs(measured.torque[(kept > 0) & (measured.torque != 0)])
    return float(sizes.min()) if len(sizes) else float(np.abs(measured.torque).max())


def _at_widths(
    measured: Measurements, sense: Floats, tilted: bool, kept: Floats, widths: Widths
) -> FitResult:
    """Adjust the runs at fixed widths."""
    factor, width = widths.scatter, widths.residual_torque
    width = lightest_torque(measured, kept) if width is None else width
    problem = Problem(measured, tilted)
    start = adjustment.first_guess(measured, sense, kept)
    start = replace(
        start, residual_torque=max(-width, min(start.residual_torque, width))
    )
    try:
        adjusted = adjustment.adjust(
            problem.with_scatter(factor), sense, start, width, kept, adjustment.FACTOR
        )
    except NoFit:
        # The cheapest explanation of a very large mistake is that all spins are
        # infinite, because their errors are proportional, or that M0 cancels all
        # torques. Larger errors of single runs and a small M0 prevent this.
        start = adjustment.robust_start(measured, sense, kept)
        factor = max(factor, adjustment.misfit(measured, start, kept))
        if factor > widths.scatter:
            width = 0.1 * width
        adjusted = adjustment.adjust(
            problem.with_scatter(factor), sense, start, width, kept, adjustment.ASTRAY
        )
    # A prior without information is not a datum: neither its term nor its degree of
    # freedom counts.
    differ = adjustment.torques_differ(measured.torque[kept > 0])
    prior = (float(adjusted.unknowns[1]) / width) ** 2 if differ else 0.0
    return _result(
        adjusted, sense, Widths(factor, width), factor**2 * (adjusted.chi2 - prior)
    )


def _result(
    adjusted: Adjusted, sense: Floats, widths: Widths, chi2: float
) -> FitResult:
    """Create the result of a fit at fixed widths."""
    u = np.sqrt(adjusted.covariance.diagonal())
    inertia, residual_torque, bias = map(
        Estimate, adjusted.unknowns.tolist(), u.tolist(), UNITS
    )
    differ = adjustment.torques_differ(
        adjusted.problem.measured.torque[adjusted.kept > 0]
    )
    return FitResult(
        inertia=inertia,
        residual_torque=residual_torque,
        timing_bias=bias,
        covariance=adjusted.covariance,
        chi2=chi2,
        dof=int(adjusted.kept.sum()) - 1 - int(differ),
        deviations=adjusted.deviations,
        widths=widths,
        sense=sense,
        adjusted=adjusted,
    )


def _integrate_at(result: FitResult, tested: bool = True) -> Posterior:
    """Integrate over the widths, linearised at the end of a fit.

    I_zz in kg*m^2, M0 in N*m, b in s.
    """
    adjusted, inertia, measured = (
        result.adjusted,
        result.inertia.value,
        result.adjusted.problem.measured,
    )
    lightest = lightest_torque(measured, adjusted.kept)
    unit = np.array([abs(inertia), lightest, measured.timing_bias_u])
    rows = result.widths.scatter * adjusted.rows
    # The fit used other units of M0 and I_zz.
    rows[:, 1] *= lightest / adjusted.scale[1]
    rows[:, 0] *= unit[0] / adjusted.scale[0]
    conditions = posterior.Conditions(
        unknowns=rows[:, :3],
        shared=rows[:, 3:],
        left=result.widths.scatter * adjusted.weighted - rows[:, 3:] @ adjusted.shared,
        ended=adjusted.unknowns / np.where(unit > 0, unit, 1.0),
        unit=unit,
        runs=float(adjusted.kept.sum()),
        scatter=result.widths.scatter,
    )
    test = measured.balance_test if tested else None
    width = None if test is None else test(inertia) / lightest
    scale = balance_scale(measured, inertia, lightest) / lightest
    return posterior.integrate(conditions, scale, times_stated(measured), width)


def balance_scale(measured: Measurements, inertia: float, lightest: float) -> float:
    """Return the scale of M0's prior [N*m], for an I_zz [kg*m^2] and a smallest torque [N*m]."""
    usual = posterior.BALANCE * lightest
    if measured.torque_unseen is not None:
        return min(usual, measured.torque_unseen * abs(inertia))
    if measured.balanced is None:
        return usual
    return (
        min(usual, posterior.BALANCED * abs(inertia))
        if measured.balanced
        else posterior.UNBALANCED * usual
    )


def times_stated(measured: Measurements) -> bool:
    """Return whether the log states the uncertainty of its times."""
    return not any(
        source.quantity == "time" and source.default for source in measured.sources
    )


def _budget(result: FitResult, u: float) -> tuple[Share, ...]:
    """Split u²(I_zz) by source, the largest first; the shares add up to u² [kg²*m⁴].

    The answer is linear in every standardised error, so the squares add up. Scatter
    above the stated uncertainties has a row of its own. The factor s itself is
    uncertain, which widens the errors of single runs.
    """
    adjusted = result.adjusted
    problem, gain, count = adjusted.problem, adjusted.gain, adjusted.problem.count
    variances = (adjusted.slopes * problem.independent) ** 2 @ (
        gain[:count] ** 2 / adjusted.independent_variance
    )
    single = float(variances.sum())
    if single > adjustment.NEGLIGIBLE * u**2:
        wider = max(0.0, u**2 - single - float(np.sum(gain[count:] ** 2)))
        variances *= 1 + wider / single
    stated = variances / max(result.widths.scatter, 1.0) ** 2
    excess, variances = float((variances - stated).sum()), stated
    owners = np.zeros(problem.shared_count, dtype=int)
    owners[problem.to_column] = problem.from_source
    np.add.at(variances, owners, gain[count + 2 :] ** 2)
    shared = set(owners.tolist())
    parts = [
        (math.sqrt(variance), source.name, s in shared, source.shared_by)
        for s, (source, variance) in enumerate(
            zip(problem.sources, variances.tolist(), strict=True)
        )
    ]
    for row, name, words in (
        (0, "residual_torque", "all runs"),
        (1, "time_bias", SOURCES["time_bias"].shared_by),
    ):
        parts.append((abs(float(gain[count + row])), name, True, words))
    parts.append((math.sqrt(max(excess, 0.0)), "unexplained_scatter", False, ""))
    parts.sort(key=itemgetter(0), reverse=True)
    sizes, *_ = zip(*parts, strict=True)
    total = math.fsum(np.square(sizes).tolist())
    factor = u / math.sqrt(total or 1.0)
    return tuple(
        Share(name, several, by, factor * own, own**2 / total)
        for own, name, several, by in parts
        if own
    )


# --- corrections for the model of the motion ---

Model = Literal["auto", "horizontal", "steady", "released"]

MAX_ROUNDS = 20
"""Largest number of rounds; corrections and fit agree after a few."""


class ChosenModel(Struct, frozen=True):
    """The model that a log is fitted with."""

    tilted: bool
    """Eq. (8) with each run's pitch, not eq. (9)."""
    released: bool
    """The mean rate of a rod that is released from rest, not that of steady precession.
    """
    asked: bool
    """True if the user chose the model."""
    earth: bool = False
    """The precession relative to the stars, not relative to the turning floor."""

    @property
    def name(self) -> Literal["horizontal", "steady", "released"]:
        """Name of the model in the option ``--model``."""
        if self.released:
            return "released"
        return "steady" if self.tilted else "horizontal"


def is_corrected(measured: Measurements, chosen: ChosenModel) -> bool:
    """Return whether a model corrects the runs with the result of a fit."""
    return (
        chosen.earth
        or chosen.released
        or (chosen.tilted and measured.spin_start is not None)
    )


def corrected(
    measured: Measurements, near: FitResult, chosen: ChosenModel
) -> Measurements:
    """Correct the angles of the runs for a model, with the I_zz and M0 of a fit of them.

    Runs of a released rod also get sources of error: the phase of the nutation at the
    last button press, and I. If the log does not say how the rod was started, a push of
    the hand is a source as well.
    """
    inertia, residual_torque = near.inertia.value, near.residual_torque.value
    across = adjustment.transverse_inertia(measured)
    total = measured.torque + residual_torque
    # The weight spins as well.
    runs, whole = measured, inertia + measured.added
    lean = (across, measured.pitch) if chosen.tilted else (0.0, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = physics.precession_rate(total, measured.corrected_spin, whole, *lean)
        if chosen.released:
            top = motion.Top(whole, across, total)
            mean = motion.mean_precession_rate(
                top, conserved_spin(measured, top), measured.pitch
            )
            click = physics.click_error(measured.corrected_spin, whole, across)
            runs = _released(measured, steady, mean, click, chosen.asked)
        elif chosen.tilted and measured.spin_start is not None:
            runs = replace(
                measured,
                slowing=steady / _mean_rate_of_decay(measured, total, whole, across),
            )
    if not chosen.earth:
        return runs
    # The floor turns while a run is timed; at a pole if the latitude is unknown.
    # Counterclockwise is positive.
    vertical = physics.EARTH_ROTATION * math.sin(
        math.pi / 2 if measured.latitude is None else measured.latitude
    )
    usual = adjustment.assume_sense(measured, math.copysign(1.0, residual_torque))
    sense = usual if measured.precession_sense is None else measured.precession_sense
    floor = (
        np.where(sense == 0, usual, sense)
        * vertical
        * measured.time
        / (2 * np.pi * measured.turns)
    )
    return replace(
        runs, slowing=(1.0 if runs.slowing is None else runs.slowing) * (1 + floor)
    )


OF_RELEASE = ("nutation", "release", "habit", "push")
"""Sources that a released rod adds."""

PART_RELEASED, PART_U = 0.5, 0.4
"""Part of the effect of a release, and its standard uncertainty, if the log does not
say how the rod was started: a rod that gets a push of the share k of the steady rate
shows (1 − k)(4 − 2k − (3 − k)q)/(4 − 3q) of it, with q = I_zz/I, to second order in I
φ̇/(I_zz ψ̇)."""


def _released(
    measured: Measurements, steady: Floats, mean: Floats, click: Floats, asked: bool
) -> Measurements:
    """Correct runs of a released rod by the ratio of the steady rate and the mean rate [rad/s].

    `click` is the largest error of a time by the phase of the nutation [s].
    """
    is_stated = asked or measured.motion is not None
    # Without a torque both rates are zero.
    effect = np.divide(steady, mean, out=np.ones_like(mean), where=mean != 0) - 1
    part = 1.0 if is_stated else PART_RELEASED
    own, every, nothing = (
        np.arange(len(mean)),
        np.zeros(len(mean), dtype=int),
        np.zeros(len(mean)),
    )
    # A log without a pitch and without the word "released" has no source for I, though
    # it may state I.
    given = (
        measured.transverse_inertia is not None or measured.nutation_ratio is not None
    )
    default = SOURCES["transverse_inertia"].default.relative if given else TRANSVERSE_U
    for source in measured.sources:
        if source.quantity == "transverse":
            default = float(source.relative.max())
    # The reduction of the mean rate is proportional to the square of I.
    doubt = 2 * default * part * np.abs(effect)
    more = [
        Source(
            "nutation",
            "time",
            own,
            click / math.sqrt(2),
            nothing,
            "",
            True,
            "its phase at the last click",
        ),
        Source(
            "release",
            "turns",
            every,
            nothing,
            doubt,
            "all runs",
            True,
            "the doubt about I in the mean rate",
        ),
    ]
    if not is_stated:
        push = PART_U * np.abs(effect)
        # One half of the variance is the habit of the hand, the other half differs from
        # run to run.
        more += [
            Source(
                name,
                "turns",
                groups,
                nothing,
                push / math.sqrt(2),
                shared_by,
                True,
                "half of the effect ± 40 %",
            )
            for name, groups, shared_by in (
                ("habit", every, "all runs (the same hand)"),
                ("push", own, ""),
            )
        ]
    return replace(
        measured, slowing=1 + part * effect, sources=(*measured.sources, *more)
    )


def conserved_spin(measured: Measurements, top: motion.Top) -> Floats:
    """Return the total spin of each run if the rod was released from rest [rad/s], shape (n,).

    A tachometer that follows the rod reads more than it while the rod sags. Spins at
    the start and the end are read before the rod sags.
    """
    if measured.tachometer == "still":
        excess = total_spin_excess(
            measured.sense, measured.turns, measured.time, measured.pitch
        )
        return measured.corrected_spin + excess
    if measured.spin_start is not None:
        return measured.spin
    return cast(Floats, motion.total_spin(top, measured.corrected_spin, measured.pitch))


def _mean_rate_of_decay(
    measured: Measurements, total: Floats, inertia: Floats | float, across: Floats
) -> Floats:
    """Compute the mean of eq. (8)'s rate over a viscous decay of the spin [rad/s].

    The method is Gauss-Legendre quadrature.
    """
    assert measured.spin_start is not None
    assert measured.spin_end is not None
    points, weights = np.polynomial.legendre.leggauss(8)
    decay = np.log(measured.spin_end / measured.spin_start)
    spins = measured.spin_start * np.exp(0.5 * (points[:, None] + 1) * decay)
    # A third reading of the spin can give a harmonic mean that differs from that of a
    # viscous decay.
    spins *= measured.spin / physics.harmonic_mean_spin(
        measured.spin_start, measured.spin_end
    )
    return np.asarray(
        0.5
        * weights
        @ physics.precession_rate(total, spins, inertia, across, measured.pitch)
    )


def earth_is_told(measured: Measurements) -> bool:
    """Return whether the log states the latitude and the direction of each run.

    The correction for the Earth needs both.
    """
    sense = measured.precession_sense
    return measured.latitude is not None and sense is not None and bool(sense.all())


def fit_model(
    measured: Measurements,
    chosen: ChosenModel,
    left_out: Collection[int] = (),
    widths: Widths | None = None,
) -> tuple[Measurements, FitResult]:
    """Fit a log with a model: correct the runs with the result of the fit, until both agree.

    Parameters
    ----------
    measured : Measurements
        The runs; earlier corrections are removed first.
    chosen : ChosenModel
        The model.
    left_out, widths
        As for `fit`.

    Returns
    -------
    Measurements
        The corrected runs; of a released rod, with more sources of error.
    FitResult

    Raises
    ------
    NoFit
        If there is no credible solution.
    """
    sources = measured.sources
    while sources and sources[-1].name in OF_RELEASE:
        sources = sources[:-1]
    bare = runs = replace(measured, slowing=None, sources=sources)
    fitted = partial(fit, tilted=chosen.tilted, left_out=left_out)
    if not is_corrected(runs, chosen):
        return runs, fitted(runs, widths)
    result = fitted(runs, AS_STATED)
    for _round in range(MAX_ROUNDS):
        new = corrected(bare, result, chosen)
        if (
            runs.slowing is not None
            and new.slowing is not None
            and np.allclose(runs.slowing, new.slowing, rtol=1e-8)
        ):
            break
        runs, result = new, fitted(new, AS_STATED)
    return runs, result if widths == AS_STATED else fitted(runs, widths)
