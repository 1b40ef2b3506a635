"""Steady precession while the spin dies away: the time to sweep an angle, in closed form.

The spin falls as ψ̇ = ψ̇₀ e^(−t/τ), as in an air film, and the precession follows the slow root of eq. (8),
a φ̇² + I_zz ψ̇ φ̇ − M = 0 with a = (I_zz − I) sin(pitch), at every moment. With φ̇ in the place of the spin as the
variable, φ = ∫ φ̇ dt = −τ ∫ φ̇ dψ̇/ψ̇ becomes

    φ = τ ∫ (M + a φ̇²)/(M − a φ̇²) dφ̇,

an inverse hyperbolic tangent for a M > 0, an arc tangent for a M < 0, and for a level rod, a = 0, just τ (φ̇₁ − φ̇₀).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from gyrodata import physics
from gyrodata.physics import Floats


@dataclass(frozen=True)
class Course:
    """Precession of n runs from their start on, with the spin falling."""

    rate: Floats
    """Precession rate at the start [rad/s], with its sign."""
    momentum: Floats
    """I_zz × size of the spin at the start [kg*m^2/s]."""
    tilt: Floats
    """4 a M [kg²m⁴/s²]: above 0 where the tilt slows the precession, below 0 where it hastens it."""

    def root(self, momentum: Floats) -> Floats:
        """√D of eq. (8) [kg*m^2/s]; NaN where it has no solution, 0 where it is about to have none."""
        square = momentum**2 + self.tilt
        return cast(Floats, np.sqrt(np.where(np.abs(square) < 1e-15 * momentum**2, 0.0, square)))

    def swept(self, lost: ArrayLike) -> Floats:
        """Angle swept while a part of the spin is lost, as a multiple of rate × τ.

        Parameters
        ----------
        lost : array_like
            1 − spin/spin at the start, 0 ≤ lost < 1 [1].

        Returns
        -------
        ndarray
            [1]; NaN where no steady precession exists at the spin that is left.
        """
        lost = np.asarray(lost, dtype=float)
        after = self.momentum * (1 - lost)
        with np.errstate(invalid="ignore"):
            root, root_after = self.root(self.momentum), self.root(after)
        # φ̇ = 2M/(I_zz ψ̇ + √(…)), so this is φ̇₁/φ̇₀ − 1 without the difference of near-equal numbers.
        grown = lost * self.momentum * (1 + (self.momentum + after) / (root + root_after)) / (after + root_after)
        # q = a φ̇²/M at the start.
        q = self.tilt / (self.momentum + root) ** 2
        # Difference of the two inverse tangents, by their addition theorem.
        step = grown / (1 - q * (1 + grown))
        return cast(Floats, 2 * step * _inverse_tangent(q * step**2) - grown)


def _inverse_tangent(square: Floats) -> Floats:
    """Give artanh(z)/z of z² for a positive and arctan(z)/z of −z² for a negative argument: 1 + x/3 + x²/5 …."""
    size = np.sqrt(np.abs(square))
    with np.errstate(invalid="ignore", divide="ignore"):
        whole = np.where(square > 0, np.arctanh(np.minimum(size, 1.0)), np.arctan(size)) / size
    near = 1 + square / 3 + square**2 / 5 + square**3 / 7
    return np.where(np.abs(square) < 1e-4, near, whole)


def course(torque: ArrayLike, spin: ArrayLike, inertia: float, across: ArrayLike, pitch: ArrayLike) -> Course:
    """Give the precession of a top from its start on.

    Parameters
    ----------
    torque : array_like, shape (n,)
        h m g, the torque with the rod horizontal [N*m].
    spin : array_like, shape (n,)
        Spin ψ̇ at the start, of either sign [rad/s].
    inertia : float
        I_zz [kg*m^2].
    across : array_like, shape (n,)
        I across the rod [kg*m^2].
    pitch : array_like, shape (n,)
        Angle of the rod above the horizontal [rad]; it stays.

    Returns
    -------
    Course
    """
    rate = physics.precession_rate(torque, spin, inertia, across, pitch)
    tilt = 4 * (inertia - np.asarray(across)) * np.sin(pitch) * np.asarray(torque)
    return Course(np.asarray(rate), inertia * np.abs(spin), np.asarray(tilt))


def time_by_share(at: Course, angle: Floats, lost: float) -> Floats:
    """Time to sweep an angle in which a given part of the spin is lost.

    Parameters
    ----------
    at : Course
        n runs.
    angle : ndarray, shape (n,)
        To sweep, > 0 [rad].
    lost : float
        1 − spin at the end over spin at the start, 0 < lost < 1 [1].

    Returns
    -------
    ndarray, shape (n,)
        [s]; NaN where the precession stops being steady before.
    """
    return cast(Floats, -np.log1p(-lost) * angle / (np.abs(at.rate) * at.swept(lost)))


def time_by_constant(at: Course, angle: Floats, time_constant: float) -> Floats:
    """Time to sweep an angle while the spin falls with a time constant τ.

    Parameters
    ----------
    at : Course
        n runs.
    angle : ndarray, shape (n,)
        To sweep, > 0 [rad].
    time_constant : float
        τ [s].

    Returns
    -------
    ndarray, shape (n,)
        [s]; NaN where the precession stops being steady before.

    Notes
    -----
    The precession only becomes faster, so the angle is a convex function of the time, and Newton's steps from
    any later time go down to the answer without ever passing it.
    """
    speed = np.abs(at.rate)
    with np.errstate(divide="ignore"):
        # Below the spin of D = 0 eq. (8) has no solution.
        longest = -time_constant * np.log(np.sqrt(np.maximum(-at.tilt, 0.0)) / at.momentum)
    # With a M < 0 the precession gains more than that of a level rod, with a M > 0 less, but it gains.
    level = time_constant * np.log1p(angle / (speed * time_constant))
    time = np.minimum(np.where(at.tilt > 0, angle / speed, level), longest)

    def beyond(time: Floats) -> Floats:
        return speed * time_constant * at.swept(-np.expm1(-time / time_constant)) - angle

    reached = beyond(time) > -1e-14 * angle
    for _step in range(100):
        left = at.momentum * np.exp(-time / time_constant)
        rate = speed * (at.momentum + at.root(at.momentum)) / (left + at.root(left))
        step = beyond(time) / rate
        time = time - step
        if np.all(np.abs(step[reached]) < 1e-10 * time[reached]):
            break
    return np.where(reached, time, np.nan)
