"""How fast the spin falls: from ``# spin_down: …`` in the log, or from the spin at the start and end of each run.

Drag is ψ̈ = −c ψ̇^p: p = 0 for dry friction, 1 for an air film, 2 for turbulence. Its strength is given as the relative
fall of the spin in a second.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from gyrodata import physics
from gyrodata.physics import Floats

NO_POWER_LAW = 0.3
"""Smallest standard uncertainty of the exponent: no real drag is exactly a power of the spin."""

NO_LAW = 9.0
"""With a larger reduced chi-square, the falls do not follow one law, and p keeps its expected value."""

CERTAIN = 2.0
"""A fall of the spin below this many standard uncertainties is not used."""


class Drag(Struct, frozen=True):
    """The drag of one gyroscope."""

    rate: float
    """Relative fall of the spin in a second at `spin` [1/s]; the inverse of the decay time."""
    u_rate: float
    """[1/s]"""
    spin: float
    """[rad/s]"""
    exponent: float
    """p [1]."""
    u_exponent: float
    """[1]"""

    def at(self, spin: Floats) -> Floats:
        """Compute the relative fall in a second at other spins [1/s], shape (n,)."""
        return self.rate * (spin / self.spin) ** (self.exponent - 1)


def find_drag(falls: Sequence[tuple[float, float, float]], u_spin: float, u_exponent: float) -> Drag | None:
    """Fit the law of drag to falls of the spin.

    Parameters
    ----------
    falls : sequence of tuple
        Spin at the start and at the end of each fall [rad/s], and its duration [s].
    u_spin : float
        Relative standard uncertainty of one reading of the spin.
    u_exponent : float
        Standard uncertainty of p before the fit; the expected value is 1.

    Returns
    -------
    Drag or None
        None if the spin does not fall visibly.
    """
    if not falls:
        return None
    start, end, seconds = np.array(falls).T
    spin, fall = np.sqrt(start * end), np.log(start / end)
    u = math.sqrt(2) * u_spin / seconds
    middle = float(np.exp(np.mean(np.log(spin))))
    distance = np.log(spin / middle)
    prior = max(u_exponent, 1e-6)
    rate, bend = float(np.sum(fall / seconds / u**2) / np.sum(1 / u**2)), 0.0
    # Gauss-Newton steps for the rate at the middle spin and for p − 1, which has a prior.
    for _step in range(20):
        # The rate at the geometric mean of both spins.
        found = fall / seconds * physics.sinhc(bend * fall / 2)
        shape = np.exp(bend * distance)
        rows = np.vstack([np.column_stack([shape, rate * distance * shape]) / u[:, None], [0.0, 1 / prior]])
        covariance = np.linalg.inv(rows.T @ rows)
        step = covariance @ rows.T @ np.append((found - rate * shape) / u, -bend / prior)
        rate, bend = rate + float(step[0]), float(np.clip(bend + step[1], -2.0, 2.0))
    misfit = float(np.sum(((found - rate * shape) / u) ** 2)) / max(len(u) - 2, 1)
    u_rate, u_bend = (np.sqrt(np.diag(covariance)) * max(1.0, math.sqrt(misfit))).tolist()
    u_bend = min(math.hypot(u_bend, NO_POWER_LAW), u_exponent)
    if misfit > NO_LAW:
        bend, u_bend = 0.0, u_exponent
    return Drag(rate, u_rate, middle, 1 + bend, u_bend) if rate > CERTAIN * u_rate else None
