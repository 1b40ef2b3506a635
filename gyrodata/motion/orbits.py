"""A top, its state, and the constants of its motion: turning points, period and phase.

All constants are divided by I. If the torque is negative, the frame is turned by a half turn about X, so that gravity's
β = |M|/I is never negative. With u = cosθ, l = H·Z/I, a = H·e3/I and w = u − u0 from the start,

    u̇² = 2β w³ + A w² + B w + C = 2β (w − w1)(w − w2)(w − w3),    w1 ≤ 0 ≤ w2 ≤ w3,
    φ̇ = (l − a u)/(1 − u²) = ½ (l − a)/(1 − u) + ½ (l + a)/(1 + u),

with coefficients that are computed from the vectors without differences of nearly equal numbers. Then
u = u1 + (u2 − u1) sn²(κ(t − t1)|m), and φ is R t plus two integrals of the third kind. The integral for the upper pole
begins at the lower turning point, and that for the lower pole at the upper one, so that each is a sum of positive terms
for orbits of any distance from the pole (RJ: Carlson, Numerical Algorithms 10, 13, 1995).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from gyrodata.physics import Floats, precession_rate

_MISS = 1e-30
"""Relative distance by which an orbit exactly through the vertical is assumed to miss it [1]."""

UPRIGHT = 1e-50
"""A rod whose 1 − |cosθ| never exceeds this stays upright."""

_NEAREST = 1e-90
"""Smallest ratio of the closest and the farthest distance from a pole, so that all integrals are finite."""

_LEAST_COMPLEMENT = 1e-34
"""Smallest 1 − m: a motion that would need an infinite time to become upright needs about 40/κ instead."""

_SPECK = 1e-60
"""Components of e3 [1] and H/I [rad/s], and β [rad^2/s^2], below this are 0, so that squares do not underflow."""

_NEWTON_STEPS = 60
"""Enough also for a double root, for which each step only halves the error."""

_NEGLIGIBLE = 1e-8
"""The next step is the square of this step over 4, below the last digit."""


class Top(Struct, frozen=True, eq=False):
    """A symmetric body with one fixed point and a torque from gravity; arrays describe many tops and are broadcast."""

    inertia: Any
    """I_zz, the moment of inertia about the rod [kg*m^2], above 0."""
    transverse_inertia: Any
    """I about an axis across the rod through the fixed point [kg*m^2], above 0; may be below or equal to I_zz."""
    torque: Any
    """h m g, the torque with the rod horizontal [N*m]; negative for a weight on the other side of the centre."""

    def __post_init__(self) -> None:
        for name in ("inertia", "transverse_inertia", "torque"):
            values = np.asarray(getattr(self, name), dtype=float)
            if not np.isfinite(values).all():
                raise ValueError(f"{name} is not a finite number")
            if name != "torque" and not (values > 0).all():
                raise ValueError(f"{name} must be above 0")


class State(Struct, frozen=True, eq=False):
    """Direction of the rod and angular momentum.

    The angle of the spin is not included, because nothing depends on it. Euler angles would fail at the vertical.
    """

    axis: Floats
    """e3, the unit vector along the rod, in the fixed frame X, Y, Z with Z upwards [1]; shape (..., 3)."""
    momentum: Floats
    """H, the angular momentum about the fixed point, in the fixed frame [kg*m^2/s]; shape (..., 3)."""


def steady(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state in steady slow precession, eq. (8), at azimuth 0.

    Raises
    ------
    ValueError
        If there is no steady precession: the rod points upwards and the spin is too low.
    """
    rate = precession_rate(top.torque, spin, top.inertia, top.transverse_inertia, pitch)
    if not np.isfinite(rate).all():
        raise ValueError("no steady precession exists at this spin and pitch; use a faster spin or a lower rod")
    axis = _axis(pitch, np.shape(rate))
    vertical = np.zeros_like(axis)
    vertical[..., 2] = rate
    # ω3 = ψ̇ + φ̇ cosθ, eq. (2); H = I (Ω − Ω3 e3) + I_zz ω3 e3, eq. (3).
    along = rate * np.sin(pitch)
    about_rod = np.multiply(top.inertia, spin + along) - np.multiply(top.transverse_inertia, along)
    transverse = np.asarray(top.transverse_inertia, dtype=float)[..., None]
    return State(axis, transverse * vertical + np.asarray(about_rod)[..., None] * axis)


def released(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state of a rod at rest at azimuth 0, with the ball spinning, when the rod is released."""
    momentum = np.multiply(top.inertia, spin)
    shape = np.broadcast_shapes(np.shape(momentum), np.shape(pitch), np.shape(top.torque))
    axis = _axis(pitch, shape)
    return State(axis, np.asarray(momentum)[..., None] * axis)


def energy(top: Top, state: State) -> Any:
    """Compute kinetic and potential energy, (H² − H3²)/2I + H3²/2I_zz + h m g cosθ [J]."""
    about_rod = np.sum(state.axis * state.momentum, axis=-1)
    across = np.sum(state.momentum**2, axis=-1) - about_rod**2
    kinetic = across / np.multiply(2, top.transverse_inertia) + about_rod**2 / np.multiply(2, top.inertia)
    return kinetic + top.torque * state.axis[..., 2]


def _axis(pitch: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """Return the unit vector at azimuth 0 and a pitch, shape (*shape, 3)."""
    axis = np.zeros((*shape, 3))
    axis[..., 0] = np.cos(pitch)
    axis[..., 2] = np.sin(pitch)
    return axis


# --- the constants of the motion ------------------------------------------------------------------------------


class Ladder(Struct, frozen=True, eq=False):
    """Steps of the arithmetic-geometric mean for Jacobi's functions with a parameter m, or an array of them.

    `scipy.special.ellipj` accepts only m. Near the upright, 1 − m can be far below the last digit of m, and the period
    depends on 1 − m. Method: Abramowitz and Stegun, Handbook of Mathematical Functions, 16.4 and 17.6.
    """

    steps: tuple[tuple[Any, Any], ...]
    """c_n/a_n and b_n/a_n for n = 1, 2, ...: sine and cosine of an angle [1]."""
    mean: Any
    """The arithmetic-geometric mean of 1 and √(1 − m) [1]."""

    @property
    def quarter(self) -> Any:
        """The complete integral K(m), a quarter of the period [1]."""
        return np.pi / 2 / self.mean

    def amplitude(self, argument: Any) -> Any:
        """Compute the angle am(x|m) with the sine sn and the cosine cn [rad], for an argument within ±K."""
        angle = 2 ** len(self.steps) * self.mean * argument
        for sine, cosine in reversed(self.steps):
            # The angle with the sine c/a sinφ, also from its cosine, because an arcsine loses digits near 1.
            s = np.sin(angle)
            angle = (angle + np.arctan2(sine * s, np.hypot(np.cos(angle), cosine * s))) / 2
        return angle


def ladder(parameter: Any, complement: Any) -> Ladder:
    """Compute the steps from m and 1 − m, which are given separately; the complement is above 0."""
    arithmetic, geometric, half = 1.0, np.sqrt(complement), np.sqrt(parameter)
    steps = []
    while np.max(half / arithmetic) > _NEGLIGIBLE:
        # (a − b)/2 would lose the digits of a small c; c²/4a' does not.
        arithmetic, geometric = (arithmetic + geometric) / 2, np.sqrt(arithmetic * geometric)
        half = half**2 / (4 * arithmetic)
        steps.append((half / arithmetic, geometric / arithmetic))
    return Ladder(tuple(steps), arithmetic)


class Start(Struct, frozen=True, eq=False):
    """The state over I, in a frame with gravity towards −Z; "upper" is the side with the higher potential energy."""

    flip: Any
    """+1, or −1 if the torque is negative and the frame is turned [1]."""
    gravity: Any
    """β [rad^2/s^2]"""
    place: Any
    """Horizontal part of e3 as a complex number [1]."""
    leaning: Any
    """Horizontal part of H/I as a complex number [rad/s]."""
    height: Any
    """u0 [1]"""
    upper: Any
    """1 − u0 [1], without cancellation."""
    lower: Any
    """1 + u0 [1], without cancellation."""
    climb: Any
    """u̇0 [rad/s]"""
    speed2: Any
    """|ė3|² [rad^2/s^2]"""
    rate2: Any
    """Square of the largest rate of the motion [rad^2/s^2]."""
    about_z: Any
    """l [rad/s]"""
    about_rod: Any
    """a [rad/s]"""
    turning: Any
    """l − a u0 [rad/s]: φ̇ sin²θ."""
    upper_miss: Any
    """l − a [rad/s], without cancellation; 0 for an orbit through the upper pole."""
    lower_miss: Any
    """l + a [rad/s], without cancellation; 0 for an orbit through the lower pole."""


class Orbit(Struct, frozen=True, eq=False, dict=True):
    """The constants of a motion, of the broadcast shape of top and state."""

    start: Start
    upper_miss: Any
    """l − a [rad/s]; 0 is replaced by a tiny value."""
    lower_miss: Any
    """l + a [rad/s]; 0 is replaced by a tiny value."""
    low: Any
    """w1 = u1 − u0 [1], at most 0."""
    high: Any
    """w2 = u2 − u0 [1], at least 0."""
    upper_far: Any
    """1 − u1 [1]"""
    upper_near: Any
    """1 − u2 [1], without cancellation: the smallest distance from the upper pole."""
    lower_far: Any
    """1 + u2 [1]"""
    lower_near: Any
    """1 + u1 [1], without cancellation: the smallest distance from the lower pole."""
    pace: Any
    """κ [rad/s], the rate of the argument of sn, which grows by K in half a nutation."""
    parameter: Any
    """m [1]"""
    complement: Any
    """1 − m [1], without cancellation."""

    @cached_property
    def ladder(self) -> Ladder:
        """The steps of the elliptic functions for m."""
        return ladder(self.parameter, self.complement)

    @property
    def drift(self) -> Any:
        """R [rad/s], the part of φ̇ that is constant."""
        start, width = self.start, self.high - self.low
        middle = start.turning - start.about_rod * (self.low + self.high) / 2
        return (middle + start.about_z * width / 2) / (self.upper_far * self.lower_far)


def orbit(top: Top, state: State) -> Orbit:
    """Compute the orbit through a state."""
    start = scaled(top, state)
    with np.errstate(divide="ignore", invalid="ignore"):
        far, low, high = _turning_points(start)
        return _completed(start, far, low, high)


def scaled(top: Top, state: State) -> Start:
    """Divide the state by I and turn gravity towards −Z; raise ValueError if the state is invalid."""
    transverse = np.asarray(top.transverse_inertia, dtype=float)
    axis, momentum = np.asarray(state.axis, dtype=float), np.asarray(state.momentum, dtype=float)
    length = np.sqrt(np.sum(axis**2, axis=-1))
    if not (np.abs(length - 1) < 1e-6).all() or not np.isfinite(momentum).all():
        raise ValueError("a state needs an axis of length 1 and a finite momentum")
    flip = np.copysign(1.0, top.torque)
    gravity = _without_specks(np.abs(top.torque) / transverse)
    unit, over = _without_specks(axis / length[..., None]), _without_specks(momentum / transverse[..., None])
    x, y, z = unit[..., 0], flip * unit[..., 1], flip * unit[..., 2]
    hx, hy, hz = over[..., 0], flip * over[..., 1], flip * over[..., 2]
    # ė3 = H × e3/I.
    gx, gy, climb = hy * z - hz * y, hz * x - hx * z, hx * y - hy * x
    level = hx * x + hy * y
    about_rod = level + hz * z
    speed2 = gx**2 + gy**2 + climb**2
    # 1 − |u0| as sin²θ/(1 + |u0|) does not lose digits near the vertical.
    wide = 1 + np.abs(z)
    narrow = (x**2 + y**2) / wide
    upper, lower = np.where(z > 0, narrow, wide), np.where(z > 0, wide, narrow)
    return Start(
        flip=flip,
        gravity=gravity,
        place=x + 1j * y,
        leaning=hx + 1j * hy,
        height=z,
        upper=upper,
        lower=lower,
        climb=climb,
        speed2=speed2,
        rate2=np.maximum(speed2 + about_rod**2 + gravity, _SPECK**2),
        about_z=hz,
        about_rod=about_rod,
        turning=x * gy - y * gx,
        upper_miss=hz * upper - level,
        lower_miss=hz * lower + level,
    )


def _without_specks(values: Any) -> Any:
    return np.where(np.abs(values) < _SPECK, 0.0, values)


def _turning_points(start: Start) -> tuple[Any, Any, Any]:
    """Compute 2β w3 [rad²/s²], w1 and w2.

    The variable r = 2β w3 is finite for β = 0. It is the largest root of r³ + A r² + 2βB r + 4β²C, by Newton's method
    from the root for C = 0, which is never smaller.
    """
    beta, spin, speed2 = start.gravity, start.about_rod, start.speed2
    a = 4 * beta * start.height - speed2 - spin**2
    b = 2 * (spin * start.turning - start.height * speed2 - beta * start.upper * start.lower)
    c = start.climb**2
    far = _larger_root(a, 2 * beta * b)
    # The far root is never below the minimum of the cubic.
    least = np.maximum(_larger_root(2 * a / 3, 2 * beta * b / 3), UPRIGHT * start.rate2)
    far = np.maximum(far, least)
    for _step in range(_NEWTON_STEPS):
        value = ((far + a) * far + 2 * beta * b) * far + 4 * beta**2 * c
        slope = (3 * far + 2 * a) * far + 2 * beta * b
        down = np.where((value > 0) & (slope > 0), value / slope, 0)
        nearer = np.maximum(far - down, least)
        done = far - nearer <= 1e-15 * far
        far = nearer
        if done.all():
            break
    # The other roots are those of w² + p w + q with q ≤ 0, so no digits are lost.
    q = -c / far
    p = (2 * beta * q - b) / far
    one = -(p + np.copysign(np.sqrt(p**2 - 4 * q), p)) / 2
    other = np.where(one == 0, 0, q / one)
    return far, np.minimum(one, other), np.maximum(one, other)


def _larger_root(p: Any, q: Any) -> Any:
    """Compute the larger root of x² + p x + q, real and at least 0, without cancellation."""
    root = np.sqrt(np.maximum(p**2 - 4 * q, 0))
    total = p + root
    return np.where(p < 0, (root - p) / 2, -2 * q / np.where(total > 0, total, 1))


def _completed(start: Start, far: Any, low: Any, high: Any) -> Orbit:
    """Compute the other constants from 2β w3, w1 and w2."""
    beta = start.gravity
    still = (start.upper - low < UPRIGHT) | (start.lower + high < UPRIGHT)
    low, high = np.where(still, 0, low), np.where(still, 0, high)
    upper_far = np.maximum(start.upper - low, UPRIGHT)
    upper_miss, upper_near, apart = start.upper_miss, start.upper - high, far - 2 * beta * high
    close = ((upper_near < high) | (start.upper < UPRIGHT)) & ~still
    if close.any():
        miss, near, gap = _upper_approach(start, upper_far)
        upper_miss, upper_near = np.where(close, miss, upper_miss), np.where(close, near, upper_near)
        high, apart = np.where(close, np.maximum(start.upper - near, 0), high), np.where(close, gap, apart)
    lower_far = np.maximum(start.lower + high, UPRIGHT)
    lower_miss, lower_near = start.lower_miss, start.lower + low
    close = ((lower_near < -low) | (start.lower < UPRIGHT)) & ~still
    if close.any():
        # (1 + u1)(1 + u2)(1 + u3) = (l + a)²/2β.
        product = lower_far * (apart + 2 * beta * lower_far)
        miss = _missed(start.lower_miss, product * _or_whole(start.lower, lower_far), start)
        lower_miss, lower_near = np.where(close, miss, lower_miss), np.where(close, miss**2 / product, lower_near)

    pace4 = apart + 2 * beta * (high - low)
    parameter = np.clip(2 * beta * (high - low) / pace4, 0, 1)
    complement = np.maximum(apart / pace4, _LEAST_COMPLEMENT)
    return Orbit(
        start=start,
        upper_miss=upper_miss,
        lower_miss=lower_miss,
        low=low,
        high=high,
        upper_far=upper_far,
        upper_near=np.where(upper_far > UPRIGHT, np.maximum(upper_near, _NEAREST * upper_far), UPRIGHT),
        lower_far=lower_far,
        lower_near=np.where(lower_far > UPRIGHT, np.maximum(lower_near, _NEAREST * lower_far), UPRIGHT),
        pace=np.sqrt(pace4) / 2,
        parameter=parameter,
        complement=complement,
    )


def _upper_approach(start: Start, upper_far: Any) -> tuple[Any, Any, Any]:
    """Compute l − a, 1 − u2 and 2β (u3 − u2) for an orbit close to the upper pole.

    1 − u2 and 1 − u3 are the roots of a quadratic equation with the product −(l − a)²/2β(1 − u1), so that neither they
    nor their difference lose digits.
    """
    beta = start.gravity
    speed2 = start.speed2 - 2 * beta * start.upper
    miss = _missed(start.upper_miss, np.abs(speed2) * _or_whole(start.upper, upper_far), start)
    square = miss**2 / upper_far
    less = (2 * (speed2 - miss * start.about_rod) - square) / upper_far
    gap = np.sqrt(less**2 + 8 * beta * square)
    return miss, np.where(less > 0, 2 * square / (less + gap), (gap - less) / (4 * beta)), gap


def _or_whole(part: Any, whole: Any) -> Any:
    """Return the distance of the start from the pole [1], or for a start at the pole the largest distance."""
    return np.where(part < UPRIGHT, whole, np.maximum(part, 1e-20 * whole))


def _missed(miss: Any, scale2: Any, start: Start) -> Any:
    """Return l ∓ a, or instead of 0 a tiny value with the sign of the azimuth's motion elsewhere."""
    least = _MISS * np.sqrt(scale2)
    sense = np.where(start.about_z == 0, start.flip, start.about_z)
    return np.where(np.abs(miss) < least, np.copysign(least, np.where(miss == 0, sense, miss)), miss)
