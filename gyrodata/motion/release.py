"""The motion of a rod that is released from rest: it nods between its start and a turning point.

All constants are divided by I. If the torque is negative, the frame is turned upside down, so that β = |M|/I is never
negative. With a = H·e3/I, u0 = cosθ at the start and the depth w = u0 − cosθ, which is 0 at the start and w1 at the
turning point,

    ẇ² = 2β w (w1 − w)(w + w3),    φ̇ = a w/((1 − u0 + w)(1 + u0 − w)),

in which every factor is a sum of positive terms. With w = w1/(1 + e^−x) the nutation from the start to the turning
point is −∞ < x < ∞. The integrands in x have no singularity within π of the real axis and decrease exponentially, so
that the trapezoidal rule has an error near the last digit also for rods close to the vertical (Trefethen & Weideman,
SIAM Review 56, 385, 2014).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import ArrayLike

from gyrodata.motion.integrators import Top

_STEP = 0.3
_X = np.arange(-260, 261) * _STEP
"""The points of the integrals."""

_MANY = 1000
"""Number of rods whose integrals are computed at once."""

_TINY, _SPECK = 1e-300, 1e-60
"""A divisor instead of 0, and the smallest β [rad²/s²] and a [rad/s] that count."""


class _Nod(Struct, frozen=True, eq=False):
    """The constants of the motion, of shape (..., 1), and the integrands at `_X`, of shape (..., n)."""

    flip: Any
    """+1, or −1 if the frame is upside down [1]."""
    about_rod: Any
    """a [rad/s]"""
    depth: Any
    """w1 [1]"""
    upper: Any
    """1 − u0 [1]"""
    lower: Any
    """1 + cosθ at the turning point [1]"""
    weight: Any
    """Time that belongs to each point [s]: dt/dx times the step."""

    def sunk(self, x: Any) -> Any:
        """Compute the depth w [1] at x."""
        return self.depth / (1 + np.exp(-x))

    def poles(self, x: Any) -> tuple[Any, Any]:
        """Compute 1 − cosθ and 1 + cosθ [1] at x, without cancellation."""
        return self.upper + self.sunk(x), self.lower + self.depth / (1 + np.exp(x))

    def rate(self, x: Any) -> Any:
        """Compute φ̇ in the frame [rad/s] at x; it grows with the depth."""
        upper, lower = self.poles(x)
        return self.about_rod * self.sunk(x) / (upper * lower)

    def swept(self, x: Any) -> tuple[Any, Any]:
        """Compute the time [s] and the azimuth in the frame [rad] from the start to x, an array of shape (..., 1).

        These are the integrals of the cardinal series through the points.
        """
        from scipy.special import sici

        part = self.weight * (0.5 + sici(np.pi / _STEP * (x - _X))[0] / np.pi)
        return part.sum(axis=-1, keepdims=True), (part * self.rate(_X)).sum(axis=-1, keepdims=True)


def _nod(top: Top, spin: ArrayLike, pitch: ArrayLike) -> _Nod:
    """Compute the constants and the integrands; all arguments are broadcast."""
    given = top.inertia, top.transverse_inertia, top.torque, spin, pitch
    inertia, across, torque, spin, pitch = (one[..., None] for one in np.broadcast_arrays(*map(np.asarray, given)))
    flip = np.copysign(1.0, torque)
    # Rates below _SPECK are 0, so that squares do not underflow.
    pull, about_rod = (
        np.where(np.abs(one) < _SPECK, 0.0, one) for one in (2 * np.abs(torque) / across, inertia * spin / across)
    )
    height, level2 = flip * np.sin(pitch), np.cos(pitch) ** 2
    # 1 − u0 as sin²θ/(1 + u0) does not lose digits near the vertical.
    upper = np.maximum(np.where(height > 0, level2 / (1 + np.abs(height)), 1 - height), _TINY)
    # w1 and −w3 are the roots of 2β w² + 2 half w − 2β sin²θ.
    half = about_rod**2 / 2 - pull * height
    large = np.abs(half) + np.hypot(half, pull * np.sqrt(level2))
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.fmax(np.where(half > 0, large, pull**2 * level2 / large), _TINY)
        depth = np.where(half > 0, pull * level2 / large, large / pull)
    depth = np.where(pull > 0, depth, 0.0)
    lower = np.maximum(about_rod**2 * level2 / (far * (upper + depth)), _TINY)
    nod = _Nod(flip, about_rod, depth, upper, lower, None)
    weight = _STEP / (2 * np.cosh(_X / 2) * np.sqrt(far + pull * nod.sunk(_X)))
    return replace(nod, weight=weight)


def mean_precession_rate(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> Any:
    """Compute the mean rate of precession: the azimuth swept in one nutation over its period [rad/s]."""
    fields = np.broadcast_arrays(top.inertia, top.transverse_inertia, top.torque, spin, pitch)
    if fields[0].ndim and len(fields[0]) > _MANY:
        # In parts, because the integrands of all runs would need much memory.
        parts = zip(*(np.array_split(one, len(one) // _MANY + 1) for one in fields), strict=True)
        return np.concatenate([mean_precession_rate(Top(*part[:3]), *part[3:]) for part in parts])
    nod = _nod(top, spin, pitch)
    return nod.flip[..., 0] * (nod.rate(_X) * nod.weight).sum(axis=-1) / nod.weight.sum(axis=-1)


class Nutation(Struct, frozen=True):
    """The nutation of a rod that is released from rest."""

    period: float
    """Time from one moment of rest to the next [s]."""
    mean_sag: float
    """Mean angle below the start [rad]; negative if the rod rises."""
    greatest_sag: float
    """Largest angle below the start [rad]."""
    sideways: float
    """Mean of φ̇ sinθ, the sideways rate of the rod's direction [rad/s]."""
    lead: float
    """Largest time by which the azimuth is before or after uniform precession [s]; NaN without precession."""


def nutation(top: Top, spin: float, pitch: float = 0.0) -> Nutation:
    """Compute the nutation of one rod that is released from rest, to about 1e-11 of each number."""
    nod = _nod(top, spin, pitch)
    share, rates = nod.weight / nod.weight.sum(), nod.rate(_X)
    mean = float(share @ rates)

    def sag(x: Any) -> Any:
        """Compute the angle from the start, by half angles without cancellation."""
        (upper, lower), (upper0, lower0) = nod.poles(x), nod.poles(_X[0])
        sine = 2 * nod.sunk(x) / (np.sqrt(upper * lower0) + np.sqrt(lower * upper0))
        return 2 * np.arctan2(sine, np.sqrt(lower * lower0) + np.sqrt(upper * upper0))

    # The azimuth is farthest from uniform precession at the moment at which the rate is the mean one.
    time, azimuth = nod.swept(find_crossing(lambda x: np.abs(nod.rate(x)) - abs(mean), _X[:1], _X[-1:]))
    return Nutation(
        period=2 * float(nod.weight.sum()),
        mean_sag=float(nod.flip[0] * (share @ sag(_X))),
        greatest_sag=float((nod.flip * sag(_X[-1]))[0]),
        sideways=float(nod.flip[0] * (share @ (rates * np.sqrt(np.multiply(*nod.poles(_X)))))),
        lead=float(np.abs(azimuth / mean - time)[0]) if mean else np.nan,
    )


def time_to_turn(top: Top, spin: ArrayLike, pitch: ArrayLike, angle: ArrayLike) -> Any:
    """Compute the first time at which the rod has swept an angle about the vertical [s]; infinite if it never does."""
    nod = _nod(top, spin, pitch)
    half_time = nod.weight.sum(axis=-1, keepdims=True)
    half_angle = (nod.weight * nod.rate(_X)).sum(axis=-1, keepdims=True)
    target = np.asarray(angle, dtype=float)[..., None] * nod.flip
    never = (target != 0) & (np.sign(target) != np.sign(half_angle))
    half_angle = np.where(never | (half_angle == 0), np.inf, half_angle)
    halves = target / half_angle
    # In every second half the rod moves back to its height at the start, as in a film that runs backwards.
    whole, rest = np.floor(halves), np.mod(halves, 1)
    back = whole % 2 == 1
    rest = np.where(back, 1 - rest, rest)
    x = find_crossing(lambda x: nod.swept(x)[1] / half_angle - rest, np.full(rest.shape, _X[0]), _X[-1])
    time = nod.swept(x)[0]
    time = half_time * whole + np.where(back, half_time - time, time)
    return np.where(never, np.inf, np.where(halves == 0, 0.0, time))[..., 0]


def find_crossing(function: Callable[[Any], Any], early: ArrayLike, late: ArrayLike) -> Any:
    """Find by bisection where each function rises through 0 between `early` and `late`, to the last digit.

    Without a zero between them, return the end that is closer to 0. A NaN counts as above 0. Newton's method fails at
    times when a precessing rod is at rest.
    """
    low, high = np.broadcast_arrays(np.asarray(early, dtype=float), np.asarray(late, dtype=float))
    while True:
        middle = low + (high - low) / 2
        if not ((low < middle) & (middle < high)).any():
            return high
        below = function(middle) < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
