"""The gyroscope's closed forms, in SI floats and arrays: no units, no data, no fit.

The equations are numbered as in the lab sheet. θ is the angle from the vertical to the rod, ``pitch`` =
90° − θ the rod's angle above the horizontal, so cosθ = sin(pitch). The *spin* ψ̇ is counted relative to the
frame that follows the rod, the *precession rate* φ̇ about the vertical.

(6)  torque = h m g sinθ
(8)  φ̇ sinθ [I_zz (φ̇ cosθ + ψ̇) − I φ̇ cosθ] = torque
(9)  θ = 90°: I_zz φ̇ ψ̇ = h m g
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2] (CGPM 1901), used where a log gives none."""

EARTH_ROTATION = 7.292115e-5
"""The Earth's rate of rotation [rad/s] (WGS 84)."""


def torque(mass: ArrayLike, position: ArrayLike, g: float) -> Any:
    """Torque of a weight about the centre of the ball, rod horizontal: m g x.

    Parameters
    ----------
    mass : array_like, any shape
        Mass of the weight [kg].
    position : array_like, same shape
        Signed distance of the weight from the centre along the rod [m].
    g : float
        Acceleration of free fall [m/s^2].

    Returns
    -------
    ndarray or float
        Torque [N*m]. Its sinθ, eq. (6), stands on both sides of eq. (8) and cancels.
    """
    return np.multiply(mass, position) * g


def harmonic_mean_spin(start: ArrayLike, end: ArrayLike) -> Any:
    """Mean in time of a viscously decaying spin, as eq. (9) needs it: the harmonic one.

    The angle precessed is ∫ M/(I_zz ψ̇) dt, so 1/ψ̇ is averaged over time. For an exponential decay between
    `start` and `end` that is G²/L, with the geometric mean G and the logarithmic mean L of the two readings:
    ψ_H = start · d/(e^d − 1) with d = ln(start/end).

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end of the interval [rad/s], of equal sign, not zero.

    Returns
    -------
    ndarray or float
        Mean spin [rad/s].

    Notes
    -----
    Exact for a torque of drag proportional to the spin (an air film). For dry friction the mean is L instead,
    lower in inertia by d²/12: see `decay_law_doubt`.
    """
    decay = np.log(np.divide(start, end))
    safe = np.where(decay == 0, 1.0, decay)
    return np.multiply(start, np.where(decay == 0, 1.0, safe / np.expm1(safe)))


def harmonic_mean_spin_slopes(start: ArrayLike, end: ArrayLike) -> tuple[Any, Any]:
    """Derivatives of `harmonic_mean_spin` with respect to the start and the end.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end of the interval [rad/s].

    Returns
    -------
    tuple of two ndarray or float
        Derivatives [1]; both 1/2 where the spin does not change. They satisfy
        start·s₁ + end·s₂ = mean, because the mean scales with the readings.
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


def arithmetic_mean_bias(start: ArrayLike, end: ArrayLike) -> Any:
    """Relative bias of I_zz when the plain mean (start + end)/2 of a viscously decaying spin is used.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end [rad/s].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; −d²/6 for a small decay d = ln(start/end).
    """
    return harmonic_mean_spin(start, end) / ((np.asarray(start) + np.asarray(end)) / 2) - 1


def decay_law_doubt(start: ArrayLike, end: ArrayLike) -> Any:
    """Relative change of I_zz if the spin fell by dry friction instead of viscously: −d²/12.

    Parameters
    ----------
    start, end : array_like
        Spin at the start and the end [rad/s].

    Returns
    -------
    ndarray or float
        Logarithmic mean (dry friction) in the place of `harmonic_mean_spin`, as a ratio minus 1,
        taken as the change of I_zz that goes with it (the inertia goes as 1/spin).
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    decay = np.log(start / end)
    half = decay / 2
    safe = np.where(np.abs(half) < 1e-4, 1.0, half)
    sinhc = np.where(np.abs(half) < 1e-4, 1 + half**2 / 6, np.sinh(safe) / safe)
    # L/G = sinhc(d/2) and G²/L = G/sinhc(d/2).
    return 1 / sinhc**2 - 1


def precession_rate(
    torque: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike = 0.0,
    pitch: ArrayLike = 0.0,
) -> Any:
    """Slow rate of steady precession: eq. (8), which is eq. (9) for a horizontal rod.

    Parameters
    ----------
    torque : array_like
        h m g, the torque with the rod horizontal [N*m].
    spin : array_like
        Spin ψ̇ relative to the frame that follows the rod [rad/s].
    inertia : array_like
        I_zz about the rod [kg*m^2].
    transverse_inertia : array_like
        I about an axis across the rod through the fixed point [kg*m^2]; matters only where `pitch` is not 0.
    pitch : array_like
        Angle of the rod above the horizontal [rad].

    Returns
    -------
    ndarray or float
        Precession rate φ̇ [rad/s]; NaN where no steady precession exists (rod up and spin too low).

    Notes
    -----
    (I_zz − I) cosθ φ̇² + I_zz ψ̇ φ̇ − h m g = 0 is solved as 2c/(b + sgn(b)√D): the textbook form
    is 0/0 for a horizontal rod and loses all digits near it.
    """
    lean = (np.asarray(inertia) - transverse_inertia) * np.sin(pitch)
    momentum = np.multiply(inertia, spin)
    root = momentum**2 + 4 * lean * np.asarray(torque)
    with np.errstate(invalid="ignore", divide="ignore"):
        return 2 * np.asarray(torque) / (momentum + np.copysign(np.sqrt(root), momentum))


def tilt_bias(
    precession_rate: ArrayLike,
    spin: ArrayLike,
    pitch: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
) -> Any:
    """Relative bias of I_zz when eq. (9) is used for a tilted rod: (1 − I/I_zz)(φ̇/ψ̇) sin(pitch).

    Parameters
    ----------
    precession_rate, spin : array_like
        φ̇ and ψ̇ [rad/s].
    pitch : array_like
        Angle of the rod above the horizontal [rad].
    inertia, transverse_inertia : array_like
        I_zz and I [kg*m^2].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact for steady precession.
    """
    ratio = np.divide(transverse_inertia, inertia)
    return (1 - ratio) * np.divide(precession_rate, spin) * np.sin(pitch)


def release_bias(torque: ArrayLike, spin: ArrayLike, inertia: ArrayLike, transverse_inertia: ArrayLike) -> Any:
    """Relative bias of I_zz when a rod is let go from rest and taken for steady: 2δ².

    Parameters
    ----------
    torque : array_like
        [N*m].
    spin : array_like
        [rad/s].
    inertia, transverse_inertia : array_like
        I_zz and I [kg*m^2].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1, with δ = I M/(I_zz ψ̇)², the mean sag of the rod [rad].

    Notes
    -----
    Lowest order; too low by a tenth and more beyond δ = 0.15.
    """
    sag = np.multiply(transverse_inertia, torque) / (np.multiply(inertia, spin)) ** 2
    return 2 * sag**2


def solid_ball_inertia(mass: float, diameter: float) -> float:
    """Moment of inertia of a homogeneous ball about any axis through its centre, 2/5 m r².

    Parameters
    ----------
    mass : float
        [kg].
    diameter : float
        [m].

    Returns
    -------
    float
        [kg*m^2].
    """
    return 0.4 * mass * (diameter / 2) ** 2
