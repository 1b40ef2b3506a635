"""The Earth turns under the gyroscope: once in 23 h 56 min against the stars."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

EARTH_ROTATION = 7.292115e-5
"""The Earth's rate of rotation against the stars [rad/s] (WGS 84)."""

SIDEREAL_DAY = 2 * math.pi / EARTH_ROTATION
"""Time of one turn of the Earth against the stars [s]; 3 min 56 s less than 24 hours."""


def earth_bias(precession_rate: ArrayLike, latitude: ArrayLike) -> Any:
    """Relative bias of I_zz when the lab is taken to stand still: Ω sin(latitude)/φ̇.

    I_zz estimated over true, minus 1, by the vertical part of the Earth's rotation; the horizontal part averages out
    over a turn.
    """
    return EARTH_ROTATION * np.sin(latitude) / np.asarray(precession_rate, dtype=float)


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
