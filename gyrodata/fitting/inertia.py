"""The recommended fit: I_zz from raw readings, with errors carried by what they are shared by."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from typing import cast

import numpy as np

from gyrodata import physics
from gyrodata.fitting.adjustment import Adjusted, adjust
from gyrodata.fitting.balance import weigh
from gyrodata.fitting.conditions import NEGLIGIBLE, Problem
from gyrodata.fitting.results import Estimate, FitResult, NoFit, Share
from gyrodata.fitting.start import Start, assume_sense, first_guess, misfit, robust_start, torques_differ
from gyrodata.fitting.trust import ASTRAY, FACTOR, insist_on_solution
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

DEFAULT_IMBALANCE_U = 3e-4
"""Prior width of M0 [N*m] where one torque only is there and no balance test: what a balance that drifts
5 degrees in a minute at 400 rpm leaves in a 4-inch steel ball."""


def fit(measured: Measurements, tilted: bool = False, left_out: Collection[int] = ()) -> FitResult:
    """Find I_zz, M0 and b of one log, with their uncertainties.

    Parameters
    ----------
    measured : Measurements
        n ≥ 1 runs, at least one of them kept and with a torque.
    tilted : bool
        Use eq. (8) with each run's pitch, not eq. (9).
    left_out : collection of int
        Indices of runs that have no say; what the others predict for them is told.

    Returns
    -------
    FitResult

    Raises
    ------
    NoFit
        If there is no solution, or none that can be believed (`trust`).

    Notes
    -----
    M0 has practically no prior (the width is the largest torque) wherever the torques differ, and
    `DEFAULT_IMBALANCE_U` where they are all the same. A balance test in the log gives it a width; the answer is
    then weighed between the test's being true and false (`balance`), so that the runs win where they contradict
    it. b has the prior of `u_time_bias`. Neither unknown is ever switched off by the data.
    """
    kept = np.ones(len(measured.runs))
    kept[list(left_out)] = 0.0
    differ = torques_differ(measured.torque[kept > 0])
    largest = float(np.abs(measured.torque[kept > 0]).max())
    alone = _fit_signs(measured, tilted, largest if differ else DEFAULT_IMBALANCE_U, differ, kept)
    if measured.imbalance_u is None:
        return alone
    tested = max(measured.imbalance_u(alone.inertia.value), NEGLIGIBLE * largest)
    try:
        tight = _fit_signs(measured, tilted, tested, False, kept)
    except NoFit:
        if not differ:
            raise
        return replace(alone, contradicted_balance=tested)
    if not differ:
        return tight
    return _with_balance(alone, tight, tested)


def _with_balance(alone: FitResult, tight: FitResult, tested: float) -> FitResult:
    """Put together a fit of the runs alone and one that believes the balance test; see `balance`."""
    mean = np.array([alone.inertia.value, alone.imbalance.value, alone.timing_bias.value])
    weighed = weigh(mean, alone.covariance, tested)
    if weighed.sure:
        return tight
    first = alone if weighed.contradicted else tight
    result = _with_unknowns(first, weighed.mean, weighed.covariance, "balance_doubt")
    return replace(result, contradicted_balance=tested if weighed.contradicted else None)


def _fit_signs(measured: Measurements, tilted: bool, width: float, free: bool, kept: Floats) -> FitResult:
    """Fit once, or for both signs of M0 where only unloaded runs without a sense would tell them apart.

    Where both signs remain possible the answer is the mixture of the two, weighted by their likelihoods: its
    mean and its whole spread, not the better half.
    """
    if np.all(measured.sense[kept > 0] != 0):
        return _fit_once(measured, assume_sense(measured, 1.0), tilted, width, free, kept)
    signed: list[tuple[float, FitResult]] = []
    for sign in (1.0, -1.0):
        try:
            signed.append((sign, _fit_once(measured, assume_sense(measured, sign), tilted, width, free, kept)))
        except NoFit:
            # This may be the sign that M0 cannot have.
            if sign < 0 and not signed:
                raise
    both = [result for sign, result in signed if result.imbalance.value * sign > 0] or [result for _, result in signed]
    both.sort(key=lambda result: result.chi2)
    if len(both) == 1:
        return both[0]
    odds = math.exp(-0.5 * min(both[1].chi2 - both[0].chi2, 1400.0))
    if odds < 1e-4:
        return both[0]
    return replace(_mixture(both[0], both[1], 1 / (1 + odds), "residual_torque_sign"), two_signs=True)


def _mixture(first: FitResult, second: FitResult, weight: float, doubt: str) -> FitResult:
    """Put two possible answers into one; all but the unknowns is told of the likelier, `first`."""
    pair = ((weight, first), (1 - weight, second))
    means = [np.array([r.inertia.value, r.imbalance.value, r.timing_bias.value]) for _, r in pair]
    mean = pair[0][0] * means[0] + pair[1][0] * means[1]
    covariance = np.zeros((3, 3))
    for (share, result), value in zip(pair, means, strict=True):
        covariance += share * (result.covariance + np.outer(value - mean, value - mean))
    return _with_unknowns(first, mean, covariance, doubt)


def _with_unknowns(first: FitResult, mean: Floats, covariance: Floats, doubt: str) -> FitResult:
    """Give a fit other unknowns; what the doubt about it adds to u is a source of its own in the budget."""
    grown = covariance[0, 0] - first.covariance[0, 0]
    budget = list(first.budget)
    if grown > 0:
        budget.append(Share(doubt, True, "all runs", math.sqrt(grown), 0.0))
    inertia, imbalance, bias = (Estimate(float(mean[j]), math.sqrt(covariance[j, j])) for j in range(3))
    return replace(
        first,
        inertia=inertia,
        imbalance=imbalance,
        timing_bias=bias,
        covariance=covariance,
        budget=_normalised(budget),
    )


def _fit_once(measured: Measurements, sense: Floats, tilted: bool, width: float, free: bool, kept: Floats) -> FitResult:
    widened = 1.0
    try:
        adjusted = _solve(measured, tilted, sense, first_guess(measured, sense, free, kept), width, kept, FACTOR)
    except NoFit:
        # A slip of hundreds of standard uncertainties is best explained by all spins being infinite, for their
        # errors are proportional, or by an M0 that takes all torque away. Larger errors of the single runs and a
        # modest M0 keep the answer where the runs are.
        start = robust_start(measured, sense, free, kept)
        widened = max(1.0, misfit(measured, start, kept))
        if widened > 1:
            width = min(width, 0.1 * float(np.abs(measured.torque[measured.torque != 0]).min()))
        adjusted = _solve(_with_wider_times(measured, widened), tilted, sense, start, width, kept, ASTRAY)
    inertia, imbalance, bias = (float(value) for value in adjusted.unknowns)
    u = np.sqrt(np.diag(adjusted.covariance)[:3])
    fitted, own = _predict(adjusted, sense)
    return FitResult(
        inertia=Estimate(inertia, float(u[0])),
        imbalance=Estimate(imbalance, float(u[1])),
        timing_bias=Estimate(bias, float(u[2]) if measured.timing_bias_u > 0 else 0.0),
        covariance=adjusted.covariance[:3, :3],
        # A prior that says nothing is not a datum: neither its pull nor its degree of freedom counts.
        chi2=widened**2 * (adjusted.chi2 - ((imbalance / width) ** 2 if free else 0.0)),
        dof=int(kept.sum()) - 1 - int(free),
        fitted_time=fitted,
        time_u=own,
        deviations=adjusted.deviations,
        influence=adjusted.influence,
        response=_response(adjusted),
        budget=_budget(adjusted),
        imbalance_prior=width,
        imbalance_free=free,
        contradicted_balance=None,
        two_signs=False,
        sense=sense,
        adjusted=adjusted,
        widened=widened,
    )


def _solve(
    measured: Measurements, tilted: bool, sense: Floats, start: Start, width: float, kept: Floats, factor: float
) -> Adjusted:
    """Adjust from a start, and insist on a solution that can be believed."""
    try:
        # What is not finite does not pass.
        with np.errstate(all="ignore"):
            adjusted = adjust(Problem(measured, tilted), sense, start, width, measured.timing_bias_u, kept)
    except np.linalg.LinAlgError:
        raise NoFit("the runs do not tell the unknowns apart") from None
    insist_on_solution(adjusted, start.inertia, factor)
    return adjusted


def _with_wider_times(measured: Measurements, factor: float) -> Measurements:
    """Multiply the uncertainty that each run's time has alone."""
    sources = tuple(
        replace(source, absolute=factor * source.absolute, relative=factor * source.relative)
        if source.quantity == "time"
        else source
        for source in measured.sources
    )
    return replace(measured, sources=sources)


def _predict(adjusted: Adjusted, sense: Floats) -> tuple[Floats, Floats]:
    """Time that the fit predicts from each run's other readings, and the spread expected about it [s]."""
    problem = adjusted.problem
    values, _ = problem.truth(np.zeros_like(adjusted.slopes), adjusted.shared)
    inertia, imbalance, bias = (float(value) for value in adjusted.unknowns)
    torque = problem.torque(values)[0] + imbalance
    if problem.tilted:
        rate = np.abs(physics.precession_rate(torque, sense * values[1], inertia, values[9], values[8]))
    else:
        rate = np.abs(physics.horizontal_precession_rate(torque, values[1], inertia))
    with np.errstate(divide="ignore"):
        # The condition is the time multiplied by the torque at work, and so is its spread.
        return 2 * np.pi * values[2] / rate + bias, np.sqrt(adjusted.own) / np.abs(torque)


def _budget(adjusted: Adjusted) -> tuple[Share, ...]:
    """Split u²(I_zz) by source: the answer is linear in every standardised error, so the squares add up."""
    problem, gain, count = adjusted.problem, adjusted.gain, adjusted.problem.count
    variances = (adjusted.slopes * problem.alone) ** 2 @ (gain[:count] ** 2 / adjusted.own)
    owners = np.zeros(problem.shared_count, dtype=int)
    owners[problem.to_column] = problem.from_source
    np.add.at(variances, owners, gain[count + 2 :] ** 2)
    shared = set(owners.tolist())
    shares = [
        Share(source.name, s in shared, source.shared_by, math.sqrt(variance), 0.0)
        for s, (source, variance) in enumerate(zip(problem.sources, variances.tolist(), strict=True))
        if variance > 0
    ]
    for row, name, words in (
        (count, "residual_torque", "all runs"),
        (count + 1, "time_bias", "all runs (the same hand)"),
    ):
        if gain[row]:
            shares.append(Share(name, True, words, abs(float(gain[row])), 0.0))
    return _normalised(shares)


def _response(adjusted: Adjusted) -> Floats:
    """Response of I_zz to each run's own inertia: M/(φ̇ψ̇) too high by r raises the condition by 2π f I_zz ψ̇ r."""
    problem = adjusted.problem
    lever = 2 * np.pi * problem.observed[2] * problem.observed[1]
    return cast(Floats, -adjusted.gain[: problem.count] * lever / np.sqrt(adjusted.own))


def _normalised(shares: list[Share]) -> tuple[Share, ...]:
    total = math.fsum(share.u_inertia**2 for share in shares)
    filled = [
        Share(share.source, share.shared, share.shared_by, share.u_inertia, share.u_inertia**2 / total)
        for share in sorted(shares, key=lambda share: -share.u_inertia)
        if total
    ]
    return tuple(filled)
