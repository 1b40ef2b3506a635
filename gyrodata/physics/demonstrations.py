"""The lab's demonstrations: a force on the tip of the rod, a bicycle wheel on a turntable; and the solid ball."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def tip_velocity(force: ArrayLike, direction: ArrayLike, length: ArrayLike, inertia: ArrayLike, spin: ArrayLike) -> Any:
    """Velocity of the rod's tip under a steady force on it: along the torque, F L²/(I_zz ω) [m/s].

    Vectors have shape (..., 3); `direction` is the unit vector e3 from the centre of the ball to the tip, the spin is
    the total one, counterclockwise for who looks from the tip towards the ball. The tip goes at right angles to the rod
    and to the force: the change of the angular momentum I_zz ω e3 is the torque L e3 × F. For a fast spin, I × turning
    rate small against I_zz ω, and averaged over the nutation; the part of the force along the rod does nothing.
    """
    factor = np.square(length) / np.multiply(inertia, spin)
    torque_direction = np.cross(np.asarray(direction, dtype=float), np.asarray(force, dtype=float))
    return np.asarray(factor)[..., None] * torque_direction


def platform_rate(
    wheel_inertia: ArrayLike, wheel_spin: ArrayLike, platform_inertia: ArrayLike, start: ArrayLike, end: ArrayLike
) -> Any:
    """Rate of a turntable, at rest at first, after a spinning wheel held on it was tipped.

    `platform_inertia` is that of turntable, person and wheel about the vertical, but for the wheel's own spin; `start`
    and `end` are angles of the axle above the horizontal. The rate is positive in the sense of a wheel that spins with
    its axle upright. The angular momentum about the vertical is conserved: I_p Ω = I_w ω (sin(start) − sin(end)).
    """
    change = 2 * np.cos(np.add(start, end) / 2) * np.sin(np.subtract(start, end) / 2)
    return np.multiply(wheel_inertia, wheel_spin) * change / platform_inertia


def solid_ball_inertia(mass: float, diameter: float) -> float:
    """Moment of inertia of a homogeneous ball about any axis through its centre, 2/5 m r² [kg*m^2]."""
    return 0.4 * mass * (diameter / 2) ** 2
