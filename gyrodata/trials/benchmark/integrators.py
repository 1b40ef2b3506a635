"""Integrators of the exact motion: error against evaluations and against time.

A level rod is released at 150 rpm, and nods eight times in one turn about the vertical.
The true motion is known from elliptic integrals: the sine of the sag is a root of a
cubic polynomial, and time and azimuth of half a nutation are complete integrals of the
first and third kind (E. T. Whittaker, *Analytical Dynamics*, 1937, chapter VI).
"""

from __future__ import annotations

import itertools
import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata import physics
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats, motion
from gyrodata.trials.simulation import Truth

if TYPE_CHECKING:
    import pandas as pd

MASS = 0.060
POSITION = 0.15
SPIN = 150 * RPM
"""[kg], [m], [rad/s]"""

TOP = motion.Top(
    Truth().inertia,
    DEFAULT_TRANSVERSE_RATIO * Truth().inertia + MASS * POSITION**2,
    MASS * POSITION * physics.STANDARD_GRAVITY,
)
START = motion.released(TOP, SPIN)


NOMINAL = {
    "splitting strang": 2,
    "splitting aba84": 4,
    "RK45": 5,
    "DOP853": 8,
}
"""The integrators and their orders."""

ADAPTIVE = "RK45", "DOP853"
"""Integrators that choose their steps by a relative tolerance."""

ROUNDING = 1e-11, 3e-13
"""Errors below which rounding counts, of the direction after one turn: for the fitted
order, and at the end of a curve [1]."""

LARGEST = 1e-3
"""Largest error at which the order is fitted [1]."""

FITTED = 5
"""Number of points to which the order is fitted: the finest that rounding allows."""


def measure_curve(method: str, turns: int, budget: int) -> list[dict[str, Any]]:
    """Integrate the motion with ever finer settings, up to `budget` evaluations."""
    end, true = reference(turns)
    period = motion.nutation(TOP, SPIN).period
    rows: list[dict[str, Any]] = []
    for level in itertools.count():
        steps = math.ceil(4 * 2 ** (level / 2) * end / period)
        tolerance = 1e-3 * 10 ** (-level / 2)
        begun = time.process_time()
        axis, evaluations = follow(method, steps, tolerance, end)
        seconds = max(time.process_time() - begun, 1e-9)
        error = float(np.linalg.norm(axis - true))
        rows.append(
            {
                "turns": turns,
                "method": method,
                "nominal": NOMINAL[method],
                "setting": tolerance if method in ADAPTIVE else steps,
                "evaluations": evaluations,
                "seconds": seconds,
                "error": error,
            }
        )
        smallest = min(error / turns, tolerance)
        if smallest < ROUNDING[1] or 1.5 * evaluations > budget:
            return rows
    raise AssertionError


def fitted_order(curve: pd.DataFrame) -> float:
    """Fit the order of an integrator; NaN if there are not enough points."""
    least = ROUNDING[0] * curve["turns"]
    fine = curve[curve["error"].between(least, LARGEST)].tail(FITTED)
    if len(fine) < 2:
        return math.nan
    slope, _ = np.polyfit(np.log(fine["evaluations"]), np.log(fine["error"]), 1)
    return -float(slope)


def reference(turns: int) -> tuple[float, Floats]:
    """Return a time at which the rod is at its lowest point, and the true e3 then.

    There it moves fastest, after about `turns` turns about the vertical.
    """
    from scipy.special import ellipk, elliprf, elliprj

    # ẇ² = w [pull (1 − w²) − spin² w], for w, the sine of the sag.
    pull = 2 * TOP.torque / TOP.transverse_inertia
    spin = TOP.inertia * SPIN / TOP.transverse_inertia
    half = spin**2 / pull / 2
    sunk = math.hypot(half, 1) - half
    # The other root is −1/sunk.
    parameter = -(sunk**2)

    def third_kind(n: float) -> float:
        """Compute the complete integral Π(n) by Carlson's forms."""
        first_kind = elliprf(0, 1 - parameter, 1)
        return float(first_kind + n / 3 * elliprj(0, 1 - parameter, 1, 1 - n))

    scale = math.sqrt(sunk / pull)
    half_period = 2 * scale * float(ellipk(parameter))
    half_azimuth = spin * scale * (third_kind(sunk) - third_kind(-sunk))
    halves = 2 * round(math.pi * turns / half_azimuth) + 1
    azimuth = halves * half_azimuth
    level = math.sqrt(1 - sunk**2)
    axis = [level * math.cos(azimuth), level * math.sin(azimuth), -sunk]
    return halves * half_period, np.array(axis)


def follow(method: str, steps: int, tolerance: float, end: float) -> tuple[Floats, int]:
    """Integrate the motion; return e3 at the end and the number of evaluations."""
    if method in ADAPTIVE:
        path, evaluations = motion.integrate(
            TOP, START, [end], method=method, rtol=tolerance, atol=tolerance
        )
        return path.axis[0], evaluations
    name = method.removeprefix("splitting ")
    kicks = motion.METHODS[name][1]
    return motion.split(TOP, START, end, steps, name).axis, steps * len(kicks)
