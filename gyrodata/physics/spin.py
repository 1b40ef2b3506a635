"""A spin that falls while it is timed: the mean that eq. (9) needs.

Drag is ψ̈ = −c ψ̇^p: p = 0 dry friction, p = 1 viscous (an air film), p = 2 turbulent. The angle precessed is
∫ M/(I_zz ψ̇) dt, so the mean that belongs in eq. (9) is the harmonic one in time. With start a, end b,
d = ln(a/b), the geometric mean G = √(ab) and sinhc(x) = sinh(x)/x it is G sinhc((1 − p)d/2)/sinhc(p d/2).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

VISCOUS = 1.0
"""Exponent of the drag of an air film."""


def _sinhc(x: Any) -> Any:
    """sinh(x)/x; its series where that is 0/0."""
    near = np.abs(x) < 1e-4
    safe = np.where(near, 1.0, x)
    return np.where(near, 1 + x * x / 6, np.sinh(safe) / safe)[()]


def harmonic_mean_spin(start: ArrayLike, end: ArrayLike, exponent: ArrayLike = VISCOUS) -> Any:
    """Mean in time of a decaying spin, as eq. (9) needs it: the harmonic one [rad/s].

    G²/L for viscous drag, with the geometric mean G and the logarithmic mean L of both readings; G
    for p = 1/2; L for dry friction; 2ab/(a + b) for p = 2.

    The law hardly matters for a small decay: mean/G = 1 + (1 − 2p) d²/24 + …, see `decay_law_doubt`.
    """
    half = np.log(np.divide(start, end)) / 2
    share = np.multiply(exponent, half)
    return np.multiply(start, np.exp(-half)) * _sinhc(half - share) / _sinhc(share)


def harmonic_mean_spin_slopes(start: ArrayLike, end: ArrayLike) -> tuple[Any, Any]:
    """Derivatives of `harmonic_mean_spin`, for viscous drag, with respect to the start and the end.

    Both are 1/2 where the spin does not change. They satisfy start·s₁ + end·s₂ = mean, because the mean
    scales with the readings.
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    decay = np.log(start / end)
    # f(d) = d/(e^d − 1); mean = start f(d); f' is a difference of near-equal numbers below |d| ~ 1e-3.
    near = np.abs(decay) < 1e-3
    safe = np.where(near, 1.0, decay)
    value = np.where(near, 1 - decay / 2 + decay**2 / 12, safe / np.expm1(safe))
    slope = np.where(
        near,
        -0.5 + decay / 6 - decay**3 / 180,
        (np.expm1(safe) - safe * np.exp(safe)) / np.expm1(safe) ** 2,
    )
    return value + slope, -slope * start / end


def simpson_mean_spin(start: ArrayLike, half: ArrayLike, end: ArrayLike) -> Any:
    """Harmonic mean in time of a spin read at the start, at half time and at the end, by Simpson's rule for 1/ψ̇.

    Smooth in the readings, so that their noise does no harm where the spin hardly falls.

    6/(1/start + 4/half + 1/end); for a viscous decay low by d⁴/2880 of itself with d = ln(start/end), which is 8e-5 for
    a spin that falls by half, and as good for any other smooth decay.
    """
    return 6 / (np.divide(1, start) + np.divide(4, half) + np.divide(1, end))


def decay_law_doubt(start: ArrayLike, end: ArrayLike) -> Any:
    """Relative change of I_zz if the spin fell by dry friction instead of viscously: −d²/12.

    Logarithmic mean (dry friction) in the place of `harmonic_mean_spin`, as a ratio minus 1, taken as the change of
    I_zz that goes with it (the inertia goes as 1/spin).
    """
    return harmonic_mean_spin(start, end) / harmonic_mean_spin(start, end, 0.0) - 1
