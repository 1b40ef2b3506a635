"""Screening: the runs that do not go with the others, and what would explain them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gyrodata.fitting.chi_square import chi2_tail
from gyrodata.fitting.conditions import median
from gyrodata.fitting.inertia import fit
from gyrodata.fitting.results import FitResult, NoFit, Outlier
from gyrodata.fitting.start import assume_sense, first_guess, rough_misfit, torques_differ
from gyrodata.measurements import Measurements, torque_groups

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

    Parameters
    ----------
    measured : Measurements
        n runs.
    tilted : bool
        Use eq. (8).

    Returns
    -------
    tuple
        The outliers in the order of the log; none for fewer than four runs, or where more than a third would
        have to go: then the stated uncertainties are at fault, not the runs. And the fit without them, where
        one was made.

    Notes
    -----
    A run is compared with what the fit of the *others* predicts, in units of the uncertainty of that
    difference, or of the runs' own scatter (1.4826 × median) where that is larger. Where the scatter is more
    than twice what was stated, a run is also compared with the median run of its torque: misfits between the
    torques must not hide one bad timing among good ones.
    """
    count = len(measured.runs)
    if count < 4:
        return [], None
    found, result = _settle(measured, tilted, _far_from_start(measured))
    if result is not None and len(found) + 1 <= count / 3 and chi2_tail(result.chi2, max(result.dof, 1)) < MASKED:
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
        if len(out) > count / 3 or kept.sum() < 3 or not np.abs(measured.torque[kept]).any():
            return [], None
        try:
            result = fit(measured, tilted, out)
        except NoFit:
            return [], None
        typical = max(1.0, 1.4826 * median(np.abs(result.deviations[kept])))
        far = np.flatnonzero((np.abs(result.deviations) > OUTLIER * typical) | _far_within(measured, result, typical))
        found = [_outlier(measured, result, int(i), typical) for i in far]
        fresh = {outlier.index for outlier in found}
        if fresh == out:
            return (found, result) if len(found) <= count / 3 else ([], None)
        out = fresh
    return (found if len(found) <= count / 3 else []), None


def _outlier(measured: Measurements, result: FitResult, index: int, typical: float) -> Outlier:
    deviation = float(result.deviations[index])
    turns = _explaining_turns(measured, result, index, typical)
    return Outlier(index, deviation, turns, slip=turns is not None or abs(deviation) > GROSS * typical)


def _far_within(measured: Measurements, result: FitResult, typical: float) -> Any:
    """Which runs are far from the others of their torque, where the log scatters more than it should."""
    apart = np.full(len(measured.runs), np.nan)
    if typical <= 2:
        return np.isfinite(apart)
    for group in torque_groups(measured):
        if len(group) >= 4:
            apart[group] = np.abs(result.deviations[group] - median(result.deviations[group]))
    grouped = apart[~np.isnan(apart)]
    if not grouped.any():
        return np.zeros(len(apart), dtype=bool)
    return np.nan_to_num(apart) > OUTLIER * 1.4826 * median(grouped)


def _far_from_start(measured: Measurements) -> set[int]:
    """Runs far from the line that most runs agree with: a first guess, from which screening goes on."""
    everything = np.ones(len(measured.runs))
    start = first_guess(measured, assume_sense(measured, 1.0), torques_differ(measured.torque), everything)
    total = np.abs(measured.torque + start.imbalance)
    with np.errstate(divide="ignore"):
        predicted = start.inertia * 2 * np.pi * measured.turns * measured.spin / total
    off = rough_misfit(measured, predicted)
    off[measured.torque == 0] = 0.0
    scale = max(1.0, 1.4826 * median(off))
    return {int(i) for i in np.flatnonzero(off > OUTLIER * scale)}


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
