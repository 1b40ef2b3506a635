"""Steady precession: torque, eqs. (8) and (9), both roots, and the least spin that has them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


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


def precession_rate(
    torque: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike = 0.0,
    pitch: ArrayLike = 0.0,
    *,
    total_spin: bool = False,
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
    total_spin : bool
        `spin` is the total spin ω3 = ψ̇ + φ̇ cosθ, as a tachometer that stands still reads it.

    Returns
    -------
    ndarray or float
        Precession rate φ̇ [rad/s]; NaN where no steady precession exists: rod up (for a positive torque and
        I > I_zz) and spin below `least_spin`, or a level rod that does not spin. 0 for no torque. With no
        spin, and the rod hanging, the positive one of the two rates of a conical pendulum.

    Notes
    -----
    a φ̇² + b φ̇ − h m g = 0, with b = I_zz × spin and a = (I_zz − I) cosθ, or −I cosθ for the total spin, is
    solved as 2 h m g/(b + sgn(b)√D), D = b² + 4 a h m g: the textbook form is 0/0 for a horizontal rod and
    loses all digits near it. Where D nearly vanishes the rate itself is ill-conditioned: a relative error ε
    of D/b² moves it by √ε.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        _, load, doubled = _quadratic(torque, spin, inertia, transverse_inertia, pitch, total_spin)
        rate = 2 * load / doubled
    idle = doubled == 0
    if idle.any():
        # Without spin and with a level rod nothing holds a torque; without a torque the rod just stays.
        return np.where(idle, np.where(load == 0, 0.0, np.nan), rate)[()]
    return rate


def fast_precession_rate(
    torque: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    pitch: ArrayLike,
    *,
    total_spin: bool = False,
) -> Any:
    """Fast rate of steady precession, the other root of eq. (8); hardly ever seen in a lab.

    Parameters
    ----------
    torque, spin, inertia, transverse_inertia, pitch, total_spin
        As for `precession_rate`.

    Returns
    -------
    ndarray or float
        Precession rate φ̇ [rad/s]; NaN where no steady precession exists; infinite where there is only the
        slow one, for a level rod or I = I_zz. Without a torque, the free precession of a spinning body.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        curvature, _, doubled = _quadratic(torque, spin, inertia, transverse_inertia, pitch, total_spin)
        return -doubled / (2 * curvature)


def _quadratic(
    torque: ArrayLike, spin: ArrayLike, inertia: ArrayLike, across: ArrayLike, pitch: ArrayLike, total_spin: bool
) -> tuple[Any, Any, Any]:
    """Give a, h m g and b + sgn(b)√D of eq. (8); sgn(0) is the sign of that zero."""
    load = np.asarray(torque, dtype=float)
    curvature = _curvature(inertia, across, pitch, total_spin)
    momentum = np.multiply(inertia, spin)
    root = np.sqrt(momentum * momentum + 4 * curvature * load)
    return curvature, load, momentum + np.copysign(root, momentum)


def _curvature(inertia: ArrayLike, across: ArrayLike, pitch: ArrayLike, total_spin: bool) -> Any:
    """Coefficient of φ̇² in eq. (8)."""
    difference = np.negative(across) if total_spin else np.subtract(inertia, across)
    return difference * np.sin(pitch)


def horizontal_precession_rate(torque: ArrayLike, spin: ArrayLike, inertia: ArrayLike) -> Any:
    """Rate of steady precession of a horizontal rod, eq. (9): h m g/(I_zz ψ̇).

    Parameters
    ----------
    torque : array_like
        h m g [N*m].
    spin : array_like
        Spin ψ̇ [rad/s]; for a horizontal rod it is the total spin as well.
    inertia : array_like
        I_zz [kg*m^2].

    Returns
    -------
    ndarray or float
        φ̇ [rad/s]; NaN for a spin of zero.
    """
    momentum = np.multiply(inertia, spin)
    return np.divide(torque, np.where(momentum == 0, np.nan, momentum))


def least_spin(
    torque: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    pitch: ArrayLike,
    *,
    total_spin: bool = False,
) -> Any:
    """Size of the spin below which there is no steady precession, from D = 0 in eq. (8).

    Parameters
    ----------
    torque, inertia, transverse_inertia, pitch, total_spin
        As for `precession_rate`.

    Returns
    -------
    ndarray or float
        2√((I − I_zz) cosθ h m g)/I_zz [rad/s], with I in the place of I − I_zz for the total spin; 0 where
        every spin has a steady precession. A level rod under a torque needs a spin above 0.
    """
    curvature = _curvature(inertia, transverse_inertia, pitch, total_spin)
    return 2 * np.sqrt(np.maximum(-curvature * np.asarray(torque), 0.0)) / inertia
