"""The fits of the textbook: a line through the origin, one with a constant, and the mean of the ratios.

Each is for one lab or for many of one design, stacked: x = φ̇ψ̇ [rad²/s²] and y = M [N*m] of shape (…, n), the answer
I_zz and u of shape (…). Uncertainties are from the scatter, runs taken as independent; NaN where nothing is left to
tell them. These know nothing of shared errors: they are there to compare with, and no answer may be far from them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from gyrodata.fitting.adjustment import FACTOR, NoFit
from gyrodata.fitting.conditions import torques_differ, transverse_inertia
from gyrodata.fitting.estimates import Estimate, FitResult
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats


def through_origin(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Least squares of y = slope·x: slope and u, s² being the sum of squared residuals over n − 1."""
    slope, sd, spread = _line(x, y, 1)
    return slope, sd / spread


def with_constant(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Least squares of y = slope·x + constant: slope and u, s² being the sum of squared residuals over n − 2.

    The classical formulas about the means, which lose no digits where the points are far from zero.
    """
    slope, sd, spread = _line(x - x.mean(axis=-1, keepdims=True), y - y.mean(axis=-1, keepdims=True), 2)
    return slope, sd / spread


def _line(x: Floats, y: Floats, unknowns: int) -> tuple[Floats, Floats, Floats]:
    """Slope through the origin, standard deviation of the residuals, and √Σx²."""
    spread = np.sqrt(_dot(x, x))
    slope: Floats = _dot(x, y) / spread**2
    freedom = x.shape[-1] - unknowns
    if freedom <= 0:
        return slope, np.full_like(slope, np.nan), spread
    left = y - slope[..., None] * x
    return slope, np.sqrt(_dot(left, left) / freedom), spread


def _dot(a: Floats, b: Floats) -> Floats:
    """Scalar product along the last axis."""
    product: Floats = (a[..., None, :] @ b[..., :, None])[..., 0, 0]
    return product


def mean_of_ratios(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Mean of y/x over the runs with a torque, and u, the standard error of that mean."""
    loaded = y.reshape(-1, y.shape[-1])[0] != 0
    ratios = y[..., loaded] / x[..., loaded]
    count = ratios.shape[-1]
    mean = ratios.mean(axis=-1)
    if count < 2:
        return mean, np.full_like(mean, np.nan)
    return mean, ratios.std(axis=-1, ddof=1) / math.sqrt(count)


TEXTBOOK: Mapping[str, Callable[[Floats, Floats], tuple[Floats, Floats]]] = {
    "through_origin": through_origin,
    "with_constant": with_constant,
    "mean_of_ratios": mean_of_ratios,
}
"""The fits of the textbook by name."""


@dataclass(frozen=True, slots=True)
class Line:
    """Ordinary least squares of y on x, uncertainties from the scatter."""

    slope: Estimate
    intercept: Estimate | None


def ordinary_line(x: Floats, y: Floats, intercept: bool) -> Line | None:
    """Fit y = slope·x (+ intercept) to n points; None where x does not determine the unknowns."""
    x_mean, y_mean = (float(x.mean()), float(y.mean())) if intercept else (0.0, 0.0)
    count, size = len(x), math.sqrt(x @ x)
    if count < 1 + intercept or np.linalg.norm(x - x_mean) <= 1e-9 * size:
        return None
    slope, sd, spread = (float(value) for value in _line(x - x_mean, y - y_mean, 1 + intercept))
    told = not math.isnan(sd)
    constant = None
    if intercept:
        u = sd * size / (spread * math.sqrt(count)) if told else None
        constant = Estimate(y_mean - slope * x_mean, u)
    return Line(Estimate(slope, sd / spread if told else None), constant)


def insist_on_lines(measured: Measurements, fit: FitResult, tilted: bool, kept: Floats) -> None:
    """Accept a fit within a factor of `FACTOR` of a line, corrected for tilt and release, or raise `NoFit`."""
    index = np.flatnonzero(kept)
    rate = fit.sense[index] * 2 * np.pi * measured.turns[index] / measured.time[index]
    if measured.slowing is not None:
        rate = rate * measured.slowing[index]
    spin, torque = measured.spin[index], measured.torque[index]
    if tilted:
        # Eq. (8) as a line: M + I φ̇² cosθ against φ̇ (ψ̇ + φ̇ cosθ).
        height = np.sin(measured.pitch[index])
        torque = torque + transverse_inertia(measured)[index] * rate**2 * height
        spin = spin + rate * height
    lines = [ordinary_line(rate * spin, torque, intercept=False)]
    if torques_differ(torque):
        lines.append(ordinary_line(rate * spin, torque, intercept=True))
    slopes = [line.slope.value for line in lines if line is not None]
    if not any(1 / FACTOR < fit.inertia.value / slope < FACTOR for slope in slopes if slope > 0):
        beside = " and ".join(f"{slope:.2g}" for slope in slopes) or "nothing"
        raise NoFit(f"the fit gives {fit.inertia.value:.2g} kg*m^2, and the lines of the textbook {beside}")
