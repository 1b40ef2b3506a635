"""The 95 % interval of I_zz by the profile of chi-square, where value ± k·u is not good enough."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from gyrodata.fitting.adjustment import adjust
from gyrodata.fitting.conditions import Problem
from gyrodata.fitting.results import FitResult
from gyrodata.fitting.start import Start
from gyrodata.measurements import Measurements

TOLERANCE = 0.05
"""The linear interval stands where each half of it is right to this relative size."""


def profile_interval(
    measured: Measurements, result: FitResult, k: float, tilted: bool = False, left_out: Collection[int] = ()
) -> tuple[float, float] | None:
    """Find where chi-square, with all else adjusted, has risen by k² on either side of I_zz.

    Parameters
    ----------
    measured : Measurements
        n runs.
    result : FitResult
        Their fit, made with the same `tilted` and `left_out`.
    k : float
        Coverage factor of the interval: 1.96 for 95 %.
    tilted : bool
        Use eq. (8).
    left_out : collection of int
        Indices of runs that have no say.

    Returns
    -------
    tuple of float or None
        Lower and upper end [kg*m^2]; None where value ± k·u is right to 5 % of its half-width, or where the
        answer is a mixture of two fits, which has no one profile.
    """
    u = result.inertia.u
    if not u or result.two_signs or "balance_doubt" in {share.source for share in result.budget}:
        return None
    halves = [_half(measured, result, side * k * u, k, tilted, left_out) for side in (-1.0, 1.0)]
    if any(half is None for half in halves) or all(abs(half / (k * u) - 1) < TOLERANCE for half in halves if half):
        return None
    low, high = (half or k * u for half in halves)
    return result.inertia.value - low, result.inertia.value + high


def _half(
    measured: Measurements, result: FitResult, distance: float, k: float, tilted: bool, left_out: Collection[int]
) -> float | None:
    """Distance from I_zz to the end on one side [kg*m^2], > 0; None where the profile does not rise so far."""
    lowest = result.chi2 + ((result.imbalance.value / result.imbalance_prior) ** 2 if result.imbalance_free else 0.0)
    for _step in range(8):
        inertia = result.inertia.value + distance
        if inertia <= 0:
            return None
        rise = _chi2_at(measured, result, inertia, tilted, left_out) - lowest
        if not rise > 0:
            return None
        # Exact for a parabola, and a short way for what is nearly one.
        ratio = k / math.sqrt(rise)
        distance *= min(max(ratio, 0.5), 2.0)
        if abs(ratio - 1) < (TOLERANCE if _step == 0 else 1e-4):
            break
    return abs(distance)


def _chi2_at(
    measured: Measurements, result: FitResult, inertia: float, tilted: bool, left_out: Collection[int]
) -> float:
    kept = np.ones(len(measured.runs))
    kept[list(left_out)] = 0.0
    start = Start(inertia, result.imbalance.value)
    problem = Problem(measured, tilted)
    adjusted = adjust(problem, result.sense, start, result.imbalance_prior, measured.timing_bias_u, kept, held=True)
    return adjusted.chi2
