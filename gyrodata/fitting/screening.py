"""Screening finds runs that do not agree with the others.

At the end are the fits of the textbook (a line through the origin, one with an
intercept, and the mean of the ratios), which a fit must not contradict.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping

import numpy as np

from gyrodata.fitting.adjustment import (
    FACTOR,
    MAD_TO_SD,
    NoFit,
    first_guess,
    median,
    misfits,
    torques_differ,
    transverse_inertia,
)
from gyrodata.fitting.inertia import (
    AS_STATED,
    UNLIKELY,
    FitResult,
    Outlier,
    fit,
)
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

GROSS = 10.0
"""A run that deviates more than this is certainly wrong, also if no correction explains
it."""

OUTLIER = 5.0
"""A run that deviates by more than this many standard uncertainties is flagged."""


def screen(measured: Measurements, tilted: bool = False) -> list[Outlier]:
    """Find the runs that do not agree with the others.

    A run is compared with the prediction of the *other* runs, in units of the
    uncertainty of this difference or of the scatter of the runs, the larger one.

    Returns
    -------
    list of Outlier
        In the order of the log. Empty for fewer than four runs, or if more than a third
        would be outliers: then the stated uncertainties are wrong, not the runs.
    """
    if len(measured.runs) < 4:
        return []
    outliers, result = _settle(measured, tilted, _far_runs(measured))
    if result is None or result.p >= UNLIKELY:
        return outliers
    # One bad run can increase the scatter so much that it is not an outlier.
    named = {outlier.index for outlier in outliers}
    deviations = np.abs(result.deviations)
    deviations[list(named)] = 0.0
    named.add(int(deviations.argmax()))
    more, without = _settle(measured, tilted, named)
    if without is None:
        return outliers
    named_again = {outlier.index for outlier in more}
    return more if named <= named_again else outliers


def _far_runs(measured: Measurements) -> set[int]:
    """Return the runs that are far from the line that most runs agree with."""
    kept = np.ones(len(measured.runs))
    sense = np.where(measured.sense == 0, 1.0, measured.sense)
    start = first_guess(measured, sense, kept)
    misfit = misfits(measured, start)
    misfit[measured.torque == 0] = 0.0
    limit = OUTLIER * max(1.0, MAD_TO_SD * median(misfit))
    return set(np.flatnonzero(misfit > limit).tolist())


def _settle(
    measured: Measurements, tilted: bool, out: set[int]
) -> tuple[list[Outlier], FitResult | None]:
    """Fit without some runs, find the outliers, and repeat until they are the same."""
    count = len(measured.runs)
    outliers: list[Outlier] = []
    for _round in range(6):
        kept = np.ones(count, dtype=bool)
        kept[list(out)] = False
        has_torque = measured.torque[kept].any()
        if len(out) > count / 3 or not has_torque:
            return [], None
        try:
            result = fit(measured, AS_STATED, tilted=tilted, left_out=out)
        except NoFit:
            return [], None
        sizes = np.abs(result.deviations)
        typical = max(1.0, MAD_TO_SD * median(sizes[kept]))
        outliers = []
        for run in np.flatnonzero(sizes > OUTLIER * typical).tolist():
            is_slip = bool(sizes[run] > GROSS * typical)
            deviation = float(result.deviations[run])
            outliers.append(Outlier(run, deviation, is_slip))
        far = {outlier.index for outlier in outliers}
        if far == out:
            return outliers, result
        out = far
    return (outliers if len(outliers) <= count / 3 else []), None


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
    x_mean = intercept * x.mean(axis=-1, keepdims=True)
    y_mean = intercept * y.mean(axis=-1, keepdims=True)
    away = x - x_mean
    size = np.sqrt(np.vecdot(x, x))
    spread = np.sqrt(np.vecdot(away, away))
    spread = np.where(spread > 1e-9 * size, spread, np.nan)
    slope = np.vecdot(away, y - y_mean) / spread**2
    residual = y - y_mean - slope[..., None] * away
    freedom = count - 1 - intercept
    sd = np.full_like(slope, np.nan)
    if freedom > 0:
        sd = np.sqrt(np.vecdot(residual, residual) / freedom)
    constant = y_mean[..., 0] - slope * x_mean[..., 0]
    u_constant = sd * size / (spread * math.sqrt(count))
    return slope, sd / spread, constant, u_constant


def mean_of_ratios(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Compute the mean of y/x over the runs with a torque, and its standard error."""
    loaded = y[(0,) * (y.ndim - 1)] != 0
    ratios = y[..., loaded] / x[..., loaded]
    # A mean is a line through the origin if each x is 1.
    return ordinary_line(np.ones_like(ratios), ratios, intercept=False)[:2]


TEXTBOOK: Mapping[str, Callable[[Floats, Floats], tuple[Floats, Floats]]] = {
    "through_origin": lambda x, y: ordinary_line(x, y, intercept=False)[:2],
    "with_constant": lambda x, y: ordinary_line(x, y, intercept=True)[:2],
    "mean_of_ratios": mean_of_ratios,
}
"""The textbook fits by name: functions from x and y to I_zz and u."""


def insist_on_lines(
    measured: Measurements, fit: FitResult, left_out: Collection[int]
) -> None:
    """Raise `NoFit` if a fit differs by more than `FACTOR` from both lines.

    The lines are corrected for tilt and release. Eq. (8) is a line, too: M + I φ̇² cosθ
    against φ̇ (ψ̇ + φ̇ cosθ).
    """
    rate = fit.sense * measured.precession_rate * measured.slowing
    vertical = rate * np.sin(measured.pitch)
    transverse = transverse_inertia(measured)
    total_spin = measured.spin + vertical
    of_tilt = transverse * rate * vertical
    product = np.delete(rate * total_spin, [*left_out])
    torque = np.delete(measured.torque + of_tilt, [*left_out])
    slopes = []
    intercepts = [False, True] if torques_differ(torque) else [False]
    for intercept in intercepts:
        slope = float(ordinary_line(product, torque, intercept)[0])
        ratio = fit.inertia.value / slope if slope else 0.0
        if 1 / FACTOR < ratio < FACTOR:
            return
        if not math.isnan(slope):
            slopes.append(f"{slope:.2g} kg·m²")
    lines = " and ".join(slopes) or "no result"
    fitted = f"{fit.inertia.value:.2g} kg·m²"
    raise NoFit(f"the fit gives {fitted}, but a straight line gives {lines}")
