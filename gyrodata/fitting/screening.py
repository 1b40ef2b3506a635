"""Screening finds runs or whole torques that do not agree with the others.

It also finds the turn counts that would explain them.

At the end are the fits of the textbook (a line through the origin, one with an
intercept, and the mean of the ratios), which a fit must not contradict.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gyrodata.fitting import adjustment
from gyrodata.fitting.adjustment import MAD_TO_SD, NoFit, median
from gyrodata.fitting.inertia import (
    AS_STATED,
    FitResult,
    Outlier,
    fit,
)
from gyrodata.fitting.posterior import chi2_tail
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

MASKED = 1e-3
"""If chi-square is less probable than this, the fit is tried without the worst run."""

GROSS = 10.0
"""A run that deviates more than this is certainly wrong, also if no turn count explains
it."""

OUTLIER = 5.0
"""A run that deviates by more than this many standard uncertainties is flagged."""

TURN_COUNTS = (1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, *range(1, 31))
"""Likely numbers of revolutions."""


Screened = tuple[list[Outlier], FitResult | None]


def screen(
    measured: Measurements, tilted: bool = False, as_stated: FitResult | None = None
) -> Screened:
    """Find the runs that do not agree with the others, and turns that explain them.

    A run is compared with the prediction of the *other* runs, in units of the
    uncertainty of this difference or of the scatter of the runs, the larger one.
    `as_stated` is the fit of all runs, if it is there already.

    Returns
    -------
    list of Outlier
        In the order of the log. Empty for fewer than four runs, or if more than a third
        would be outliers: then the stated uncertainties are wrong, not the runs.
    FitResult or None
        The fit without these runs, if there is one.
    """
    count = len(measured.runs)
    if count < 4:
        return [], None
    if as_stated is not None and _agrees(as_stated):
        return [], as_stated
    found, result = _settle(measured, tilted, _far_runs(measured), as_stated)
    if result is None or chi2_tail(result.chi2, max(result.dof, 1)) >= MASKED:
        return found, result
    # One bad run can increase the scatter so much that it is not an outlier.
    named = {outlier.index for outlier in found}
    deviations = np.abs(result.deviations)
    deviations[list(named)] = 0.0
    named.add(int(deviations.argmax()))
    more, without = _settle(measured, tilted, named)
    if without is not None and named <= {outlier.index for outlier in more}:
        return more, without
    return found, result


def _agrees(fit: FitResult) -> bool:
    """Return whether each run agrees with the others, and all with their uncertainties.

    Then no run is masked.
    """
    is_likely = chi2_tail(fit.chi2, max(fit.dof, 1)) >= MASKED
    return is_likely and bool(np.abs(fit.deviations).max() <= OUTLIER)


def _far_runs(measured: Measurements) -> set[int]:
    """Return the runs that are far from the line that most runs agree with."""
    every = np.ones(len(measured.runs))
    start = adjustment.first_guess(
        measured, adjustment.assume_sense(measured, 1.0), every
    )
    off = adjustment.misfits(measured, start)
    off[measured.torque == 0] = 0.0
    limit = OUTLIER * max(1.0, MAD_TO_SD * median(off))
    return set(np.flatnonzero(off > limit).tolist())


def _settle(
    measured: Measurements,
    tilted: bool,
    out: set[int],
    as_stated: FitResult | None = None,
) -> Screened:
    """Fit without some runs, find the outliers, and repeat until they are the same."""
    count = len(measured.runs)
    found: list[Outlier] = []
    for _round in range(6):
        kept = np.ones(count, dtype=bool)
        kept[list(out)] = False
        if len(out) > count / 3 or not np.abs(measured.torque[kept]).any():
            return [], None
        try:
            result = (as_stated if not out else None) or fit(
                measured, AS_STATED, tilted=tilted, left_out=out
            )
        except NoFit:
            return [], None
        typical = max(1.0, MAD_TO_SD * median(np.abs(result.deviations[kept])))
        far = np.flatnonzero(np.abs(result.deviations) > OUTLIER * typical)
        found = []
        for i in far.tolist():
            deviation = float(result.deviations[i])
            turns = _explaining_turns(measured, result, i, typical)
            found.append(
                Outlier(
                    i,
                    deviation,
                    turns,
                    slip=turns is not None or abs(deviation) > GROSS * typical,
                )
            )
        if set(far.tolist()) == out:
            return found, result
        out = set(far.tolist())
    return (found if len(found) <= count / 3 else []), None


def _explaining_turns(
    measured: Measurements, result: FitResult, index: int, typical: float
) -> float | None:
    """Return the turns that explain a run best, to 3 u; None if none does."""
    bias = result.timing_bias.value
    one_turn = (result.fitted_time[index] - bias) / measured.turns[index]
    spread = (
        abs(
            (measured.time[index] - result.fitted_time[index])
            / result.deviations[index]
        )
        * typical
    )
    candidates = {
        *TURN_COUNTS,
        *(measured.turns[index] + step for step in (-1, -0.5, 0.5, 1)),
    }
    misfits = {
        # The uncertainty of one turn grows with the number of turns.
        turns: abs(measured.time[index] - bias - turns * one_turn)
        / (spread * max(1.0, turns / measured.turns[index]))
        for turns in candidates
        if turns > 0 and not math.isclose(turns, measured.turns[index])
    }
    best = min(sorted(misfits), key=lambda turns: misfits[turns])
    return best if misfits[best] < 3 else None


USUAL_COUNTS = (1 / 3, 1 / 2, 2 / 3, 1.0, 2.0, 3.0)
"""Usual numbers of revolutions of all runs of one weight."""

AGREES = 0.03
"""Torques agree if their relative deviation (root mean square) is below this; wrong
counts give 20 %."""

MODEST = 0.3
"""Largest residual torque over the smallest torque with which other counts explain a
log."""

MOST_TORQUES = 12
"""Largest number of torques that are tried."""


def explaining_counts(measured: Measurements) -> list[dict[int, float]]:
    """Find turn counts, one for each torque, with which the torques agree.

    For a level rod M + M0 = I_zz φ̇ψ̇ is a line, and a turn count scales φ̇ψ̇. Every
    pair of torques with two counts gives a line, and so does every torque with M0 = 0;
    the other torques then get the nearest count.

    Returns
    -------
    list of dict
        The corrections that change the fewest torques: number of the group in
        `by_torque`, and its revolutions. Empty if the torques agree without a
        correction, or if there is no correction.
    """
    loaded = [
        k for k, runs in enumerate(measured.by_torque) if measured.torque[runs[0]]
    ]
    if not 2 <= len(loaded) <= MOST_TORQUES:
        return []
    candidates = [_candidates(measured, measured.by_torque[k]) for k in loaded]
    torque = np.array([measured.torque[measured.by_torque[k][0]] for k in loaded])
    products = [product for _, product in candidates]
    inertia, residual_torque = _lines(torque, products)
    chosen, off = _nearest(products, (torque[:, None] + residual_torque) / inertia)
    changed = chosen > 0
    agrees = np.sqrt(np.mean(off**2, axis=0)) < AGREES
    if np.any(agrees & ~changed.any(axis=0)):
        return []
    agrees &= np.abs(residual_torque) < MODEST * np.abs(torque).min()
    lines = np.flatnonzero(agrees)
    sizes = changed[:, lines].sum(axis=0)
    answers: list[dict[int, float]] = []
    for line in lines[sizes == sizes.min(initial=MOST_TORQUES)]:
        answer = {
            loaded[k]: float(candidates[k][0][chosen[k, line]])
            for k in np.flatnonzero(changed[:, line])
        }
        if answer not in answers:
            answers.append(answer)
    # Students who forget to write the turns have timed parts of one turn.
    return sorted(answers, key=lambda answer: sum(answer.values()))


def _nearest(products: list[Floats], expected: Floats) -> tuple[Any, Floats]:
    """Return the nearest candidate of each torque on each line, shape (torques, lines).

    The second array contains the logarithm of its ratio to the expected φ̇ψ̇.
    """
    chosen = []
    off = []
    for product, line in zip(products, expected, strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            away = np.abs(np.log(product / line[:, None]))
        away[~np.isfinite(away)] = np.inf
        chosen.append(away.argmin(axis=1))
        off.append(away.min(axis=1))
    return np.array(chosen), np.array(off)


def _candidates(measured: Measurements, runs: list[int]) -> tuple[Floats, Floats]:
    """List the counts that the runs of one torque can have, the written one first.

    For each the median of φ̇ψ̇ [rad²/s²]. If the runs have different counts, these are
    not a common mistake.
    """
    product = median(np.abs(measured.product[runs])) * np.sign(measured.torque[runs[0]])
    written = measured.turns[runs[0]]
    counts = [written]
    if not np.ptp(measured.turns[runs]):
        counts += [count for count in USUAL_COUNTS if not math.isclose(count, written)]
    return np.array(counts), product * np.array(counts) / written


def _lines(torque: Floats, products: list[Floats]) -> tuple[Floats, Floats]:
    """Return I_zz [kg*m^2] and M0 [N*m] of every line through two torques.

    Lines through one torque with M0 = 0 are returned as well.
    """
    # The origin counts as another torque, the first one.
    number = np.repeat(np.arange(len(torque) + 1), [1, *map(len, products)])
    x = np.concatenate([[0.0], *products])
    y = np.append(0.0, torque)[number]
    first, second = np.triu_indices(len(x), 1)
    # If there are only two torques, a line through both is not evidence.
    is_line = number[first] != number[second]
    is_line &= (first == 0) | (len(torque) > 2)
    first = first[is_line]
    second = second[is_line]
    with np.errstate(divide="ignore", invalid="ignore"):
        inertia = (y[second] - y[first]) / (x[second] - x[first])
        residual_torque = inertia * x[first] - y[first]
    usable = np.isfinite(inertia) & (inertia > 0)
    usable &= np.abs(residual_torque) < 3 * np.abs(torque).max()
    return inertia[usable], residual_torque[usable]


# --- the fits of the textbook ---


def ordinary_line(
    x: Floats, y: Floats, intercept: bool
) -> tuple[Floats, Floats, Floats, Floats]:
    """Fit y = slope·x (+ intercept) to n points of each lab.

    The method is ordinary least squares, and the runs are treated as independent.

    For x = φ̇ψ̇ [rad²/s²] and y = M [N*m], of one lab or of many labs of one design,
    shape (…, n), the slope is I_zz.

    Returns
    -------
    tuple of ndarray
        Slope, its u, intercept and its u, each of shape (…). u is NaN without degrees
        of freedom; all are NaN if x does not determine the line. Without `intercept`
        the last two have no meaning.
    """
    count = x.shape[-1]
    # Formulas relative to the means do not lose digits if the points are far from zero.
    x_mean = intercept * np.add.reduce(x, axis=-1, keepdims=True) / count
    y_mean = intercept * np.add.reduce(y, axis=-1, keepdims=True) / count
    away = x - x_mean
    size = np.sqrt(np.vecdot(x, x))
    spread = np.sqrt(np.vecdot(away, away))
    spread = np.where(spread > 1e-9 * size, spread, np.nan)
    slope = np.vecdot(away, y - y_mean) / spread**2
    left = y - y_mean - slope[..., None] * away
    freedom = count - 1 - intercept
    sd = (
        np.sqrt(np.vecdot(left, left) / freedom)
        if freedom > 0
        else np.full_like(slope, np.nan)
    )
    return (
        slope,
        sd / spread,
        y_mean[..., 0] - slope * x_mean[..., 0],
        sd * size / (spread * math.sqrt(count)),
    )


def mean_of_ratios(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Compute the mean of y/x over the runs with a torque, and its standard error."""
    loaded = y[(0,) * (y.ndim - 1)] != 0
    ratios = y[..., loaded] / x[..., loaded]
    count = ratios.shape[-1]
    mean = np.add.reduce(ratios, axis=-1) / count
    squares = np.add.reduce((ratios - mean[..., None]) ** 2, axis=-1)
    return mean, np.sqrt(squares / (count - 1) / count) if count > 1 else np.full_like(
        mean, np.nan
    )


TEXTBOOK: Mapping[str, Callable[[Floats, Floats], tuple[Floats, Floats]]] = {
    "through_origin": lambda x, y: ordinary_line(x, y, intercept=False)[:2],
    "with_constant": lambda x, y: ordinary_line(x, y, intercept=True)[:2],
    "mean_of_ratios": mean_of_ratios,
}
"""The textbook fits by name: functions from x and y to I_zz and u."""


def insist_on_lines(
    measured: Measurements, fit: FitResult, tilted: bool, kept: Floats
) -> None:
    """Raise `NoFit` if a fit differs by more than `FACTOR` from both lines.

    The lines are corrected for tilt and release.
    """
    index = np.flatnonzero(kept)
    product = fit.sense * np.abs(measured.product)
    torque = measured.torque
    if tilted or measured.slowing is not None:
        product, torque = _line_of_motion(measured, fit, tilted)
    product = product[index]
    torque = torque[index]
    found = []
    intercepts = [False, True] if adjustment.torques_differ(torque) else [False]
    for intercept in intercepts:
        slope = float(ordinary_line(product, torque, intercept)[0])
        ratio = fit.inertia.value / slope if slope else 0.0
        if 1 / adjustment.FACTOR < ratio < adjustment.FACTOR:
            return
        if not math.isnan(slope):
            found.append(f"{slope:.2g} kg·m²")
    lines = " and ".join(found) or "no result"
    raise NoFit(
        f"the fit gives {fit.inertia.value:.2g} kg·m², but a straight line gives {lines}"
    )


def _line_of_motion(
    measured: Measurements, fit: FitResult, tilted: bool
) -> tuple[Floats, Floats]:
    """Return φ̇ψ̇ and the torque of each run, corrected for tilt and release.

    Eq. (8) is a line, too: M + I φ̇² cosθ against φ̇ (ψ̇ + φ̇ cosθ).
    """
    rate = fit.sense * 2 * np.pi * measured.turns / measured.time
    if measured.slowing is not None:
        rate = rate * measured.slowing
    if not tilted:
        return rate * measured.spin, measured.torque
    height = np.sin(measured.pitch)
    transverse = adjustment.transverse_inertia(measured)
    torque = measured.torque + transverse * rate**2 * height
    return rate * (measured.spin + rate * height), torque
