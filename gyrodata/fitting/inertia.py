"""The recommended fit: I_zz from raw readings, with errors carried by what they are shared by.

A balance test in a log may be false, and nobody knows how often. Before the runs are looked at it is true with some
chance, or M0 is some ten, thirty or more times larger than it says. Each of these is weighed by how well it goes with
what the runs alone say of M0 (Bayes). The answer leans on the test more than its uncertainty does, which has to hold
where the test is false: an interval that every true test makes much shorter does not cover where the runs cannot tell a
false one from a true one.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from gyrodata import physics
from gyrodata.fitting.adjustment import Adjusted, Start, adjust
from gyrodata.fitting.conditions import NEGLIGIBLE, Problem, torques_differ
from gyrodata.fitting.estimates import ASTRAY, FACTOR, Estimate, FitResult, NoFit, Share, insist_on_solution
from gyrodata.fitting.start import assume_sense, first_guess, misfit, robust_start
from gyrodata.measurements import SOURCES, Measurements
from gyrodata.physics import Floats

DEFAULT_IMBALANCE_U = 3e-4
"""Prior width of M0 [N*m] where one torque only is there and no balance test: what a balance that drifts
5 degrees in a minute at 400 rpm leaves in a 4-inch steel ball."""


def fit(measured: Measurements, tilted: bool = False, left_out: Collection[int] = ()) -> FitResult:
    """Find I_zz, M0 and b of one log, with their uncertainties.

    M0 has practically no prior (the width is the largest torque) wherever the torques differ, and `DEFAULT_IMBALANCE_U`
    where they are all the same. A balance test in the log gives it a width; the answer is then weighed between the
    test's being true and false (`weigh`), so that the runs win where they contradict it. b has the prior of
    `u_time_bias`. Neither unknown is ever switched off by the data. Runs left out have no say, but what the others
    predict for them is worked out. Raises `NoFit` where there is no solution, or none that can be believed.
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
    """Put together a fit of the runs alone and one that believes the balance test."""
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
    time_u_factor = 1.0
    try:
        adjusted = _solve(measured, tilted, sense, first_guess(measured, sense, free, kept), width, kept, FACTOR)
    except NoFit:
        # A slip of hundreds of standard uncertainties is best explained by all spins being infinite, for their
        # errors are proportional, or by an M0 that takes all torque away. Larger errors of the single runs and a
        # modest M0 keep the answer where the runs are.
        start = robust_start(measured, sense, free, kept)
        time_u_factor = max(1.0, misfit(measured, start, kept))
        if time_u_factor > 1:
            width = min(width, 0.1 * float(np.abs(measured.torque[measured.torque != 0]).min()))
        adjusted = _solve(_with_wider_times(measured, time_u_factor), tilted, sense, start, width, kept, ASTRAY)
    inertia, imbalance, bias = (float(value) for value in adjusted.unknowns)
    u = np.sqrt(np.diag(adjusted.covariance)[:3])
    fitted, own = _predict(adjusted, sense)
    return FitResult(
        inertia=Estimate(inertia, float(u[0])),
        imbalance=Estimate(imbalance, float(u[1])),
        timing_bias=Estimate(bias, float(u[2]) if measured.timing_bias_u > 0 else 0.0),
        covariance=adjusted.covariance[:3, :3],
        # A prior that says nothing is not a datum: neither its pull nor its degree of freedom counts.
        chi2=time_u_factor**2 * (adjusted.chi2 - ((imbalance / width) ** 2 if free else 0.0)),
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
        time_u_factor=time_u_factor,
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
        (count + 1, "time_bias", SOURCES["time_bias"].shared_by),
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


TRUSTED, DOUBTED = 0.8, 0.2
"""How likely a test is true before the runs are looked at [1]: for the answer, and for its uncertainty."""

FALSE = ((10.0, 3.0, 0.2), (-10.0, 3.0, 0.2), (30.0, 10.0, 0.2), (-30.0, 10.0, 0.2), (0.0, 60.0, 0.2))
"""Where M0 is if it is not: about so many widths of the test [1], give or take so many [1], with this chance [1]."""

FARTHEST = max(width for _, width, _ in FALSE)
"""Twice so many widths of the test away [1] it is nowhere among these."""

CONTRADICTED = 1 / 3
"""Where true is this many times as likely as false, or less, the runs contradict the test."""


@dataclass(frozen=True, slots=True)
class Weighed:
    """An answer with a balance test that may be false."""

    mean: Floats
    """I_zz [kg*m^2], M0 [N*m], …, shape (k,)."""
    covariance: Floats
    """Of these, shape (k, k)."""
    odds: float
    """How many times likelier what the runs say is if the test is true [1]."""

    @property
    def contradicted(self) -> bool:
        """Whether the runs contradict the test."""
        return self.odds < CONTRADICTED

    @property
    def sure(self) -> bool:
        """Whether the runs leave no doubt that the test is true."""
        return DOUBTED * self.odds > 999 * (1 - DOUBTED)


def weigh(mean: Floats, covariance: Floats, tested: float) -> Weighed:
    """Put together the unknowns I_zz, M0, … by the runs alone and a balance test that tells M0 to `tested` [N*m]."""
    if abs(mean[1]) > 2 * math.hypot(math.sqrt(covariance[1, 1]), FARTHEST * tested):
        return Weighed(mean, covariance, 0.0)
    centres = tested * np.array([0.0, *(centre for centre, _, _ in FALSE)])
    widths = tested * np.array([1.0, *(width for _, width, _ in FALSE)])
    chances = np.array([chance for _, _, chance in FALSE])
    # M0 is normal about each centre; all else follows it as its covariance says.
    variances = covariance[1, 1] + widths**2
    gain = covariance[:, 1] / variances[:, None]
    means = mean + gain * (centres - mean[1])[:, None]
    likelihood = np.exp(-0.5 * (mean[1] - centres) ** 2 / variances) / np.sqrt(variances)
    false = likelihood[1:] * chances
    odds = float(likelihood[0] / max(false.sum(), 1e-300 * likelihood[0]))

    def shares(trust: float) -> Floats:
        share = np.concatenate([[trust * likelihood[0]], (1 - trust) * false])
        share /= share.sum()
        return share

    answer = shares(TRUSTED) @ means
    share, off = shares(DOUBTED), means - answer
    spread = covariance - np.einsum("i,i,ij,ik->jk", share, variances, gain, gain)
    spread += np.einsum("i,ij,ik->jk", share, off, off)
    if odds < 1:
        # A test that the runs speak against makes nothing surer.
        alone, now = np.diag(covariance), np.diag(spread)
        widen = np.sqrt(np.divide(alone, now, out=np.ones_like(now), where=now < alone))
        spread *= widen[:, None] * widen
    return Weighed(answer, spread, odds)
