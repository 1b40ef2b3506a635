"""Integrators of the exact motion: error against evaluations and against time.

A level rod is released at 150 rpm, and nods eight times in one turn about the vertical.
The reference are the exact integrals of this motion, which are elliptic integrals of
the first and third kind (E. T. Whittaker, *Analytical Dynamics*, 1937, chapter VI).
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata import physics
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats, motion
from gyrodata.trials.benchmark.fits import cheapest
from gyrodata.trials.simulation import Truth

if TYPE_CHECKING:
    import pandas as pd

SPIN = 150 * RPM
"""[rad/s]"""

MASS = 0.060
POSITION = 0.15
"""The weight [kg], and its distance from the centre of the ball [m]."""

TOP = motion.Top(
    inertia=Truth().inertia,
    transverse_inertia=DEFAULT_TRANSVERSE_RATIO * Truth().inertia + MASS * POSITION**2,
    torque=MASS * POSITION * physics.STANDARD_GRAVITY,
)
START = motion.released(TOP, SPIN)

NOMINAL: Mapping[Any, int] = {
    "splitting strang": 2,
    "splitting aba84": 4,
    "RK45": 5,
    "DOP853": 8,
}
"""The integrators and their orders."""

ADAPTIVE = "RK45", "DOP853"
"""Integrators that choose their steps by a relative tolerance."""

ROUNDING = 3e-13
"""Error below which rounding counts, of the direction after one turn: the end of a
curve [1]."""

SHOWS_ORDER = 1e-11, 1e-3
"""Errors after one turn between which the order is fitted [1]."""

FITTED = 5
"""Number of points to which the order is fitted: the finest that rounding allows."""

AIM = 1e-6
"""Error for which the title names the fastest integrator [1]."""


def measure_curve(method: str, turns: int, budget: int) -> list[dict[str, Any]]:
    """Integrate the motion with ever finer settings, up to `budget` evaluations."""
    end, true = reference(turns)
    period = motion.nutation(TOP, SPIN).period
    # The first call also imports the integrator.
    follow(method, 1, 1.0, period)
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
                "scene": f"turns: {turns}",
                "method": method,
                "evaluations": evaluations,
                "seconds": seconds,
                "error": error,
            }
        )
        smallest = min(error / turns, tolerance)
        if smallest < ROUNDING or 1.5 * evaluations > budget:
            break
    return rows


def fitted_order(curve: pd.DataFrame) -> float:
    """Fit the order of an integrator; NaN if there are not enough points."""
    fine = curve[curve["error"].between(*SHOWS_ORDER)].tail(FITTED)
    if len(fine) < 2:
        return math.nan
    slope, _ = np.polyfit(np.log(fine["evaluations"]), np.log(fine["error"]), 1)
    return -float(slope)


def title(curves: pd.DataFrame) -> str:
    """Name the orders, and the fastest integrator for a small error."""
    (_, short), *_ = curves.groupby("scene", sort=False)
    orders = [
        f"{method} {fitted_order(curve):.2f} ({NOMINAL[method]})"
        for method, curve in short.groupby("method", sort=False)
    ]
    head = f"Fitted order (nominal): {', '.join(orders)}"
    fastest = cheapest(curves, curves["error"] < AIM)
    return "\n".join([head, f"The fastest for an error below {AIM:g}:", *fastest])


def reference(turns: int) -> tuple[float, Floats]:
    """Return a time at which the rod is at its lowest point, and the true e3 then.

    There it moves fastest, after about `turns` turns about the vertical.
    """
    nod = motion.nutation(TOP, SPIN)
    rate = float(motion.mean_precession_rate(TOP, SPIN, 0.0))
    halves = 2 * round(2 * math.pi * turns / (rate * nod.period)) + 1
    end = halves * nod.period / 2
    azimuth = rate * end
    level = math.cos(nod.greatest_sag)
    down = -math.sin(nod.greatest_sag)
    return end, np.array([level * math.cos(azimuth), level * math.sin(azimuth), down])


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
