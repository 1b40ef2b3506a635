"""The straight line of the textbook: ordinary least squares, uncertainties from the scatter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

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
    By QR of the design. u is s·√(diagonal), s² the sum of squared residuals over n − unknowns; it is None
    where there are no more points than unknowns.
    """
    design = np.column_stack([x, np.ones_like(x)]) if intercept else x[:, None]
    unknowns = design.shape[1]
    q, r = np.linalg.qr(design)
    diagonal = np.abs(np.diag(r))
    if len(x) < unknowns or diagonal.min() <= 1e-9 * np.abs(r[0]).max():
        return None
    solution = np.linalg.solve(r, q.T @ y)
    residuals = y - design @ solution
    freedom = len(x) - unknowns
    inverse = np.linalg.inv(r)
    scale = float(residuals @ residuals) / freedom if freedom > 0 else math.nan
    cov = inverse @ inverse.T * scale
    u = [math.sqrt(cov[j, j]) if freedom > 0 else None for j in range(unknowns)]
    return Line(
        slope=Estimate(float(solution[0]), u[0]),
        intercept=Estimate(float(solution[1]), u[1]) if intercept else None,
        covariance=float(cov[0, 1]) if intercept and freedom > 0 else 0.0,
        residual_sd=math.sqrt(scale) if freedom > 0 else None,
    )
