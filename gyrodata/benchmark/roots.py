"""Where eq. (8) has a solution, and how many of its digits each formula gives.

The truth is the slow root in fifty decimal digits, of the same numbers that the formulas get.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np

from gyrodata import physics
from gyrodata.benchmark.effort import Effort
from gyrodata.benchmark.maps import DigitMap, MapPair, digits
from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import Floats

INERTIA = 4.44e-3
"""I_zz [kg*m^2]: a 4-inch steel ball."""

MASS, POSITION = 0.060, 0.15
"""The heaviest weight of a typical lab [kg], and where it hangs [m]."""

TORQUE = MASS * POSITION * physics.STANDARD_GRAVITY
"""[N*m]"""

ACROSS = DEFAULT_TRANSVERSE_RATIO * INERTIA + MASS * POSITION**2
"""I across the rod [kg*m^2]."""

RPM = math.pi / 30


@dataclass(frozen=True)
class _Plane:
    """Pairs of pitch and spin, flattened."""

    pitch: Floats
    """[rad]"""
    spin: Floats
    """[rad/s]"""
    true: Floats
    """Slow rate of eq. (8) [rad/s]; NaN where there is none."""
    shape: tuple[int, int]

    def digits(self, rate: Floats) -> Floats:
        """Correct digits of a rate; NaN where there is no true one."""
        right = digits(rate / self.true - 1)
        right[np.isnan(self.true)] = np.nan
        return right.reshape(self.shape)


def map_roots(effort: Effort) -> list[MapPair]:
    """Map formulas for the rate of steady precession.

    Parameters
    ----------
    effort : Effort

    Returns
    -------
    list of MapPair
        Over tilt and spin; and over cosθ → 0 and spin.
    """
    rpm = np.geomspace(20, 1000, effort.fine_grid)
    tilts = np.linspace(-80, 80, effort.fine_grid)
    powers = np.linspace(-0.1, -17, effort.fine_grid)
    tilted, level = _plane(np.radians(tilts), rpm * RPM), _plane(np.arcsin(10**powers), rpm * RPM)
    nine = physics.horizontal_precession_rate(TORQUE, tilted.spin, INERTIA)
    return [
        MapPair(
            "tilt", "rod tilted", "spin [rpm]", rpm, "rod above the horizontal [°]", tilts,
            DigitMap("eq. (9)", tilted.digits(nine)),
            DigitMap("eq. (8)", tilted.digits(_eight(tilted))),
            "no steady precession",
        ),
        MapPair(
            "level", "rod nearly level, cosθ → 0", "spin [rpm]", rpm, "log10 cosθ", powers,
            DigitMap("eq. (8), textbook root (−b + √D)/2a", level.digits(_textbook(level))),
            DigitMap("eq. (8), root 2c/(b + √D)", level.digits(_eight(level))),
            "no steady precession",
        ),
    ]  # fmt: skip


def textbook_root(torque: Floats, spin: Floats, inertia: Floats, across: Floats, pitch: Floats) -> Floats:
    """Slow root of eq. (8) by the formula of school [rad/s], which loses digits as cosθ → 0.

    Parameters
    ----------
    torque : ndarray
        h m g [N*m].
    spin : ndarray
        ψ̇ [rad/s].
    inertia, across : ndarray
        I_zz and I [kg*m^2].
    pitch : ndarray
        Rod above the horizontal [rad].

    Returns
    -------
    ndarray
        (−b + √(b² + 4 a h m g))/2a with a = (I_zz − I) cosθ and b = I_zz ψ̇; NaN where it cannot be evaluated.
    """
    a, b = np.subtract(inertia, across) * np.sin(pitch), np.multiply(inertia, spin)
    with np.errstate(divide="ignore", invalid="ignore"):
        root: Floats = (-b + np.sqrt(b * b + 4 * a * torque)) / (2 * a)
    return root


def _plane(pitches: Floats, spins: Floats) -> _Plane:
    pitch, spin = (part.ravel() for part in np.meshgrid(pitches, spins, indexing="ij"))
    return _Plane(pitch, spin, _true_rates(np.sin(pitch), spin), (len(pitches), len(spins)))


def _eight(plane: _Plane) -> Floats:
    rate: Floats = physics.precession_rate(TORQUE, plane.spin, INERTIA, ACROSS, plane.pitch)
    return rate


def _textbook(plane: _Plane) -> Floats:
    load, inertia, across = (np.full(len(plane.spin), value) for value in (TORQUE, INERTIA, ACROSS))
    return textbook_root(load, plane.spin, inertia, across, plane.pitch)


def _true_rates(heights: Sequence[float] | Floats, spins: Sequence[float] | Floats) -> Floats:
    """Slow root of eq. (8) in 50 digits [rad/s], for cosθ and ψ̇ as they are; NaN where there is none."""
    rates = np.full(len(spins), np.nan)
    with localcontext() as context:
        context.prec = 50
        inertia, load = Decimal(INERTIA), Decimal(TORQUE)
        difference = inertia - Decimal(ACROSS)
        for i, (height, spin) in enumerate(zip(heights, spins, strict=True)):
            linear = inertia * Decimal(float(spin))
            square = linear * linear + 4 * difference * Decimal(float(height)) * load
            if square >= 0:
                rates[i] = float(2 * load / (linear + square.sqrt()))
    return rates
