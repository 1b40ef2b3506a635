"""The straight line of the textbook: ordinary least squares, uncertainties from the scatter."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gyrodata.fitting.results import Estimate
from gyrodata.physics import Floats


@dataclass(frozen=True, slots=True)
class Line:
    """Ordinary least squares of y on x, uncertainties from the scatter."""

    slope: Estimate
    intercept: Estimate | None
    covariance: float
    """Of slope and intercept."""
    residual_sd: float | None


def ordinary_line(x: Floats, y: Floats, intercept: bool) -> Line | None:
    """Fit y = slope·x (+ intercept) by ordinary least squares, as a textbook does.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Any units.
    intercept : bool
        Whether the line has a constant.

    Returns
    -------
    Line or None
        None where x does not determine the unknowns (no spread for a line with a constant).

    Notes
    -----
    The classical formulas about the means, which lose no digits where the points are far from zero. u is
    s·√(diagonal), s² the sum of squared residuals over n − unknowns; it is None where there are no more points than
    unknowns.
    """
    count, freedom = len(x), len(x) - 1 - intercept
    x_mean, y_mean = (float(x.mean()), float(y.mean())) if intercept else (0.0, 0.0)
    away = x - x_mean
    spread, size = math.sqrt(away @ away), math.sqrt(x @ x)
    if freedom < 0 or spread <= 1e-9 * size:
        return None
    slope = float(away @ (y - y_mean)) / spread**2
    residuals = (y - y_mean) - slope * away
    sd = math.sqrt(float(residuals @ residuals) / freedom) if freedom else None
    constant = None
    if intercept:
        constant = Estimate(y_mean - slope * x_mean, sd and sd * size / (spread * math.sqrt(count)))
    return Line(
        slope=Estimate(slope, sd and sd / spread),
        intercept=constant,
        covariance=-x_mean * (sd / spread) ** 2 if sd else 0.0,
        residual_sd=sd,
    )
