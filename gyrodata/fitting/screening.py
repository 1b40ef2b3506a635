"""Screening: the runs, or whole torques, that do not go with the others, and what would explain them."""

from __future__ import annotations

import math
from collections.abc import Collection
from itertools import combinations
from typing import Any

import numpy as np

from gyrodata.fitting.adjustment import NoFit, assume_sense, first_guess, rough_misfit
from gyrodata.fitting.conditions import MAD_TO_SD, median
from gyrodata.fitting.inertia import AS_STATED, FitResult, Outlier, balance_scale, fit, lightest_torque
from gyrodata.fitting.lines import chi2_tail
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats

MASKED = 1e-3
"""Where chi-square is less likely than this, the run that is furthest off is tried out as well."""

GROSS = 10.0
"""A run further off than this is a slip, whether or not a turn count explains it, and has no say."""

OUTLIER = 5.0
"""A run is flagged when it stands off by more than this many standard uncertainties."""

TURN_COUNTS = (1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, *range(1, 31))
"""Revolutions that are likely to have been timed."""


def screen(measured: Measurements, tilted: bool = False) -> tuple[list[Outlier], FitResult | None]:
    """Find the runs that do not go with the others, and the turn count that would explain each.

    Gives them in the order of the log, and the fit without them, where one was made. None for fewer than four runs, or
    where more than a third would have to go: then the stated uncertainties are at fault, not the runs.

    A run is compared with what the fit of the *others* predicts, in units of the uncertainty of that difference, or of
    the runs' own scatter (their median × 1.4826) where that is larger. Where the scatter is more than twice what was
    stated, a run is also compared with the median run of its torque: misfits between the torques must not hide one bad
    timing among good ones.
    """
    count = len(measured.runs)
    if count < 4:
        return [], None
    found, result = _settle(measured, tilted, _far_from_start(measured))
    if result is not None and chi2_tail(result.chi2, max(result.dof, 1)) < MASKED:
        # One bad run may widen the scatter until it hides in it.
        named = {outlier.index for outlier in found}
        kept = [i for i in range(count) if i not in named]
        worst = max(kept, key=lambda i: abs(result.deviations[i]))
        more, without = _settle(measured, tilted, named | {worst})
        if without is not None and {outlier.index for outlier in more} >= named | {worst}:
            return more, without
    return found, result


def _settle(measured: Measurements, tilted: bool, out: set[int]) -> tuple[list[Outlier], FitResult | None]:
    """Fit without some runs, see which are odd then, and go on until they are the same."""
    count = len(measured.runs)
    found: list[Outlier] = []
    for _round in range(6):
        kept = np.array([i not in out for i in range(count)])
        if len(out) > count / 3 or not np.abs(measured.torque[kept]).any():
            return [], None
        try:
            result = fit(measured, AS_STATED, tilted=tilted, left_out=out)
        except NoFit:
            return [], None
        typical = max(1.0, MAD_TO_SD * median(np.abs(result.deviations[kept])))
        far = np.flatnonzero((np.abs(result.deviations) > OUTLIER * typical) | _far_within(measured, result, typical))
        found = []
        for i in far.tolist():
            deviation, turns = float(result.deviations[i]), _explaining_turns(measured, result, i, typical)
            found.append(Outlier(i, deviation, turns, slip=turns is not None or abs(deviation) > GROSS * typical))
        if set(far.tolist()) == out:
            return found, result
        out = set(far.tolist())
    return (found if len(found) <= count / 3 else []), None


def _far_within(measured: Measurements, result: FitResult, typical: float) -> Any:
    """Which runs are far from the others of their torque, if the log scatters more than it should."""
    apart = np.zeros(len(measured.runs))
    groups = [group for group in torque_groups(measured) if len(group) >= 4]
    if typical <= 2 or not groups:
        return apart > 0
    for group in groups:
        apart[group] = np.abs(result.deviations[group] - median(result.deviations[group]))
    return apart > OUTLIER * MAD_TO_SD * median(apart[np.concatenate(groups)])


def _far_from_start(measured: Measurements) -> set[int]:
    """Runs far from the line that most runs agree with: a first guess, from which screening goes on."""
    start = first_guess(measured, assume_sense(measured, 1.0), np.ones(len(measured.runs)))
    total = np.abs(measured.torque + start.residual_torque)
    with np.errstate(divide="ignore"):
        predicted = start.inertia * 2 * np.pi * measured.turns * measured.spin / total
    off = rough_misfit(measured, predicted)
    off[measured.torque == 0] = 0.0
    return set(np.flatnonzero(off > OUTLIER * max(1.0, MAD_TO_SD * median(off))).tolist())


def _explaining_turns(measured: Measurements, result: FitResult, index: int, typical: float) -> float | None:
    """Turn count with which a run would fit within 3 of its own spreads, the nearest one; None if none does."""
    bias = result.timing_bias.value
    one_turn = (result.fitted_time[index] - bias) / measured.turns[index]
    spread = abs((measured.time[index] - result.fitted_time[index]) / result.deviations[index]) * typical
    candidates = {*TURN_COUNTS, *(measured.turns[index] + step for step in (-1, -0.5, 0.5, 1))}
    misfits = {
        # What is uncertain of one turn is as much more uncertain of several.
        turns: abs(measured.time[index] - bias - turns * one_turn) / (spread * max(1.0, turns / measured.turns[index]))
        for turns in candidates
        if turns > 0 and not math.isclose(turns, measured.turns[index])
    }
    best = min(sorted(misfits), key=lambda turns: misfits[turns])
    return best if misfits[best] < 3 else None


NO_WORSE = 1e-3
"""Runs fit as well if their chi-square, over that of the chosen runs, is more likely than this."""

MOST_INSTEAD = 12
"""So many runs of one torque that agree with each other are not wrong together."""

LESS_LIKELY = 3.0
"""An M0 that is so many times less likely than another one decides which runs are wrong."""


def rivals(
    measured: Measurements, chosen: FitResult, left_out: Collection[int]
) -> list[tuple[list[int], list[int], FitResult]]:
    """Find the torques of which the runs that are kept may be wrong as well, instead of those that are left out.

    Gives for each such torque its runs that are left out, those that would be left out instead, and the fit then.
    Runs of one torque that contradict each other are decided by their number or by the other torques; of two torques
    any pair is on a line with some M0, so that only a much larger M0 speaks against the other choice.
    """

    def unlikely(result: FitResult) -> float:
        if measured.balance_test is not None:
            width = measured.balance_test(result.inertia.value)
        else:
            width = balance_scale(measured, result.inertia.value, lightest_torque(measured, result.adjusted.kept))
        return 1 + (result.residual_torque.value / max(width, 1e-12)) ** 2

    found = []
    for group in torque_groups(measured):
        gone = sorted(set(group) & set(left_out))
        rest = sorted(set(group) - set(left_out))
        instead = {*left_out, *rest} - set(gone)
        too_many = len(rest) > MOST_INSTEAD or len(instead) > len(measured.runs) / 2
        if not gone or not rest or too_many or not measured.torque[group[0]]:
            continue
        try:
            other = fit(measured, tilted=chosen.adjusted.problem.tilted, left_out=instead)
        except NoFit:
            continue
        misfit = other.chi2 / max(1.0, chosen.chi2 / max(chosen.dof, 1))
        if chi2_tail(misfit, max(other.dof, 1)) > NO_WORSE and unlikely(other) < LESS_LIKELY * unlikely(chosen):
            found.append((gone, rest, other))
    return found


USUAL_COUNTS = (1 / 3, 1 / 2, 2 / 3, 1.0, 2.0, 3.0)
"""Revolutions that a lab times all runs of a weight by."""

AGREES = 0.03
"""Torques agree where what is left of them is below this, relative, as a root mean square: wrong counts leave 20 %."""

MODEST = 0.3
"""Other counts explain a log only with a residual torque below this share of the lightest torque."""

MOST_TORQUES = 12
"""More torques than this are not tried."""


def explaining_counts(measured: Measurements) -> list[dict[int, float]]:
    """Find the counts, one for each torque, with which the torques agree.

    Gives the corrections that change the fewest torques, one in most cases: number of the group in `torque_groups` and
    the revolutions that fit it. Empty where the torques agree as written, or no counts make them.

    With a level rod M + M0 = I_zz φ̇ψ̇ is a line, and a count scales φ̇ψ̇. Every two torques with any two counts make a
    line, and so does every torque with M0 = 0; each of the others then takes the count that is nearest to it.
    """
    numbers = [k for k, group in enumerate(torque_groups(measured)) if measured.torque[group[0]]]
    if not 2 <= len(numbers) <= MOST_TORQUES:
        return []
    groups = [torque_groups(measured)[k] for k in numbers]
    torque = np.array([measured.torque[group[0]] for group in groups])
    product = np.sign(torque) * [median(np.abs(measured.product[group])) for group in groups]
    # Runs of one torque with different counts were counted one by one.
    written = [np.unique(measured.turns[group]) for group in groups]
    factors = [np.unique([1.0, *(np.array(USUAL_COUNTS) / w[0] if len(w) == 1 else [])]) for w in written]
    inertia, residual_torque = _lines(torque, product, factors)
    total = torque + residual_torque[:, None]
    chosen, left = np.ones((len(inertia), len(torque))), np.empty((len(inertia), len(torque)))
    for k, factor in enumerate(factors):
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.abs(np.log(inertia[:, None] * product[k] * factor / total[:, k : k + 1]))
        off[~np.isfinite(off)] = np.inf
        best = off.argmin(axis=1)
        chosen[:, k], left[:, k] = factor[best], off[np.arange(len(off)), best]
    changed = ~np.isclose(chosen, 1.0)
    agrees = np.sqrt(np.mean(left**2, axis=1)) < AGREES
    if np.any(agrees & ~changed.any(axis=1)):
        return []
    found = np.flatnonzero(agrees & (np.abs(residual_torque) < MODEST * np.abs(torque).min()))
    fewest = min(changed[found].sum(axis=1), default=0)
    answers: list[dict[int, float]] = []
    for line in found[changed[found].sum(axis=1) == fewest]:
        answer = {numbers[k]: float(written[k][0] * chosen[line, k]) for k in np.flatnonzero(changed[line])}
        if answer not in answers:
            answers.append(answer)
    return answers


def _lines(torque: Floats, product: Floats, factors: list[Floats]) -> tuple[Floats, Floats]:
    """I_zz [kg*m^2] and M0 [N*m] of every line that two torques, or one with M0 = 0, may lie on."""
    slopes = [m / (p * factor) for m, p, factor in zip(torque, product, factors, strict=True)]
    constants = [np.zeros(len(factor)) for factor in factors]
    # Two torques always lie on a line, and it tells nothing.
    for a, b in combinations(range(len(torque)), 2) if len(torque) > 2 else ():
        first, second = (x.ravel() for x in np.meshgrid(product[a] * factors[a], product[b] * factors[b]))
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (torque[a] - torque[b]) / (first - second)
        slopes.append(slope)
        constants.append(slope * first - torque[a])
    inertia, residual_torque = np.concatenate(slopes), np.concatenate(constants)
    sane = np.isfinite(inertia) & (inertia > 0) & (np.abs(residual_torque) < 3 * np.abs(torque).max())
    return inertia[sane], residual_torque[sane]
