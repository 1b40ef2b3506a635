"""The lab's demonstrations: a force on the tip, a bicycle wheel on a turntable, a gyroscope above the turning Earth."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.physics.precession import EARTH_ROTATION

SIDEREAL_DAY = 2 * math.pi / EARTH_ROTATION
"""Time of one turn of the Earth against the stars [s]; 3 min 56 s less than 24 hours."""


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


def balanced_direction(
    azimuth: ArrayLike, altitude: ArrayLike, latitude: ArrayLike, time: ArrayLike
) -> tuple[Any, Any]:
    """Where a balanced spinning gyroscope points after a time: at the same star.

    Azimuth in [0, 2π) and altitude [rad]; the azimuth is NaN where the rod points straight up or down, within 1e-12
    rad.

    Against the ground the sky turns about the Earth's axis, which points north at the altitude of the latitude, from
    east to west: a turn of the direction by −Ω t about that axis (Rodrigues' formula).
    """
    rod = _vector(azimuth, altitude)
    axis = _vector(0.0, latitude)
    turned = -EARTH_ROTATION * np.asarray(time, dtype=float)
    along = sum(a * r for a, r in zip(axis, rod, strict=True))
    across = (
        axis[1] * rod[2] - axis[2] * rod[1],
        axis[2] * rod[0] - axis[0] * rod[2],
        axis[0] * rod[1] - axis[1] * rod[0],
    )
    share = 2 * np.sin(turned / 2) ** 2
    east, north, up = (
        r * np.cos(turned) + c * np.sin(turned) + a * along * share for r, c, a in zip(rod, across, axis, strict=True)
    )
    level = np.hypot(east, north)
    bearing = np.arctan2(east, north)
    bearing = np.where(bearing < 0, bearing + 2 * np.pi, bearing)
    bearing = np.where(bearing >= 2 * np.pi, 0.0, bearing)
    return np.where(level > 1e-12, bearing, np.nan)[()], np.arctan2(up, level)


def _vector(azimuth: ArrayLike, altitude: ArrayLike) -> tuple[Any, Any, Any]:
    """East, north and up parts of a direction."""
    level = np.cos(altitude)
    return level * np.sin(azimuth), level * np.cos(azimuth), np.sin(altitude)
