"""Constants of nature, and the type that the closed forms work on."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RPM = math.pi / 30  # rad/s of 1 rpm

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2] (CGPM 1901), used where a log gives none."""

EARTH_ROTATION = 7.292115e-5
"""The Earth's rate of rotation against the stars [rad/s] (WGS 84)."""

SIDEREAL_DAY = 2 * math.pi / EARTH_ROTATION
"""Time of one turn of the Earth against the stars [s]; 3 min 56 s less than 24 hours."""
