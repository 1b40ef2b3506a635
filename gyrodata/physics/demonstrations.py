"""The lab's two demonstrations: a force on the tip of the rod, and a bicycle wheel on a turntable."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def tip_velocity(force: ArrayLike, direction: ArrayLike, length: ArrayLike, inertia: ArrayLike, spin: ArrayLike) -> Any:
    """Velocity of the rod's tip under a steady force on it: along the torque, F L²/(I_zz ω).

    Parameters
    ----------
    force : array_like, shape (..., 3)
        Force on the tip [N].
    direction : array_like, shape (..., 3)
        Unit vector e3 from the centre of the ball to the tip [1].
    length : array_like, shape (...)
        Distance of the tip from the centre [m].
    inertia : array_like, shape (...)
        I_zz [kg*m^2].
    spin : array_like, shape (...)
        Total spin ω, counterclockwise for who looks from the tip towards the ball, not 0 [rad/s].

    Returns
    -------
    ndarray, shape (..., 3)
        Velocity [m/s] at right angles to the rod and to the force: the change of the angular momentum
        I_zz ω e3 is the torque L e3 × F. For a fast spin, I × turning rate small against I_zz ω, and averaged over the
        nutation; the part of the force along the rod does nothing.
    """
    factor = np.square(length) / np.multiply(inertia, spin)
    torque_direction = np.cross(np.asarray(direction, dtype=float), np.asarray(force, dtype=float))
    return np.asarray(factor)[..., None] * torque_direction


def platform_rate(
    wheel_inertia: ArrayLike, wheel_spin: ArrayLike, platform_inertia: ArrayLike, start: ArrayLike, end: ArrayLike
) -> Any:
    """Rate of a turntable, at rest at first, after a spinning wheel held on it was tipped.

    Parameters
    ----------
    wheel_inertia : array_like
        Moment of inertia of the wheel about its axle [kg*m^2].
    wheel_spin : array_like
        Total spin of the wheel about its axle [rad/s]; a free-running wheel keeps it.
    platform_inertia : array_like
        Moment of inertia of turntable, person and wheel about the vertical, but for the wheel's own spin
        [kg*m^2].
    start, end : array_like
        Angle of the axle above the horizontal before and after [rad].

    Returns
    -------
    ndarray or float
        Rate [rad/s], positive in the sense of a wheel that spins with its axle upright. The angular momentum about
        the vertical is conserved: I_p Ω = I_w ω (sin(start) − sin(end)).
    """
    change = 2 * np.cos(np.add(start, end) / 2) * np.sin(np.subtract(start, end) / 2)
    return np.multiply(wheel_inertia, wheel_spin) * change / platform_inertia
