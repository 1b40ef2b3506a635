"""The whole motion of eqs. (7), exactly, at any time: Jacobi's functions and Carlson's integrals."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from gyrodata.motion.orbits import UPRIGHT, Orbit, State, Top, orbit, released

_LONGEST = 1e12
"""Nutations [1] after which an angle not yet swept never is: what is left of a mean rate of 0 is rounding."""


def exact(top: Top, state: State, time: ArrayLike) -> State:
    """The state at any time, before or after, in closed form.

    Good to about 1e-15 times the largest of 1 and the angles turned through by nutation, unless the motion itself
    magnifies what is in the last digit of `state`: one that almost comes to rest near the upright.
    """
    course = _Course(orbit(top, state))
    start = course.orbit.start
    swept, place = course.at(time)
    ahead = course.heading * np.exp(1j * swept)
    axis = ahead * np.sqrt(place.upper * place.lower)
    momentum = ahead * course.lean(place) * top.transverse_inertia
    height = np.where(place.upper < place.lower, 1 - place.upper, place.lower - 1)
    upwards = start.about_z * top.transverse_inertia
    return State(_vector(axis, height, start.flip), _vector(momentum, upwards, start.flip))


def precession_angle(top: Top, state: State, time: ArrayLike) -> Any:
    """Azimuth that the rod sweeps about the vertical from time 0 on, not reduced to a turn [rad].

    Counterclockwise seen from above. A rod that passes exactly through the vertical turns by half a turn there, in the
    sense of its turning otherwise, or counterclockwise if it does not turn otherwise. For one that starts there it
    counts from the azimuth at which it leaves. A rod that stays upright sweeps 0.
    """
    course = _Course(orbit(top, state))
    swept, _ = course.at(time)
    return course.orbit.start.flip * swept


def mean_precession_rate(top: Top, state: State) -> Any:
    """Secular rate of precession: what the rod sweeps in a nutation over its period [rad/s].

    With the same meaning at the vertical as in `precession_angle`. From sums where the orbit keeps away from the
    vertical, as one that is let go from rest does, else from complete integrals.
    """
    path = orbit(top, state)
    rate = _summed_rate(path)
    return path.start.flip * (_Course(path).mean_rate if rate is None else rate)


_POINTS = 120
"""So many points at most stand for half a nutation; more would cost as much as the complete integrals."""

_UPRIGHT_ENOUGH = 1e-3
"""Closer to a pole than this, in 1 − |cosθ|, l − a u loses digits."""


def _summed_rate(path: Orbit) -> Any:
    """Secular φ̇ by the midpoint rule [rad/s]; None where that would need too many points.

    With u = u1 + (u2 − u1) sin²(ψ/2) the time goes as ∫ dψ/√(1 − m sin²(ψ/2)), and all is periodic and smooth in ψ: N
    points have an error of e^(−2 N arcosh x), with x the distance of the nearest of −1, 1 and u3 from the middle in
    half widths (Trefethen & Weideman, SIAM Review 56, 385, 2014).
    """
    width, nearest = np.asarray(path.high - path.low), np.minimum(path.upper_near, path.lower_near)
    with np.errstate(divide="ignore", invalid="ignore"):
        beyond = np.minimum(nearest / width, path.complement / path.parameter)
    # Around a rod that precesses steadily nothing is near.
    slowest = np.min(np.arccosh(1 + 2 * beyond[width > 0]), initial=40.0)
    if not (slowest * _POINTS > 20 and np.min(nearest) > _UPRIGHT_ENOUGH):
        return None
    count = math.ceil(20 / slowest)
    share = np.sin(np.pi * (np.arange(count) + 0.5) / (2 * count)) ** 2
    start = path.start
    fields = (start.turning, start.about_rod, path.low, width, path.upper_near, path.lower_near, path.parameter)
    turning, spin, low, whole, upper, lower, parameter = (np.asarray(values)[..., None] for values in fields)
    passing = np.reciprocal(np.sqrt(1 - parameter * share))
    up = whole * share
    rates = (turning - spin * (low + up)) / ((upper + whole - up) * (lower + up))
    return np.add.reduce(passing * rates, axis=-1) / np.add.reduce(passing, axis=-1)


def time_to_turn(top: Top, state: State, angle: ArrayLike) -> Any:
    """The first time at which the rod has swept an angle about the vertical: where a stopwatch stops [s].

    To about 1e-15 of itself and of the nutation's period, and to what the last digit of the angle settles (little
    near a cusp, where the rod stands still). Infinite where the rod never gets there, or not within 1e12 nutations.
    """
    course = _Course(orbit(top, state))
    return course.time_to(course.orbit.start.flip * np.asarray(angle, dtype=float))


class Nutation(Struct, frozen=True):
    """How a rod nods that was let go from rest, and what of its precession is not uniform."""

    period: float
    """From one moment of rest to the next, where the rod is as high as at the start [s]."""
    mean_sag: float
    """Angle below the start, mean over time [rad]; negative if the rod rises."""
    greatest_sag: float
    """The same at most [rad]."""
    sideways: float
    """φ̇ sinθ, mean over time: how fast the rod's direction goes sideways [rad/s]."""
    lead: float
    """How far in time the azimuth gets ahead of its mean course, or behind, at most [s]; NaN where there is none."""


def nutation(top: Top, spin: float, pitch: float = 0.0) -> Nutation:
    """The nutation of one rod let go from rest, of any size, to about 1e-11 of each of its numbers."""
    from scipy.integrate import quad
    from scipy.optimize import minimize_scalar

    course = _Course(orbit(top, released(top, spin, pitch)))
    path, start, whole = course.orbit, course.orbit.start, course.orbit.ladder.quarter
    width = path.high - path.low

    def sag(place: _Place) -> Any:
        """Angle between two directions by their half angles, free of cancellation; the start is the highest place."""
        down, up = np.sqrt(place.lower * start.upper), np.sqrt(place.upper * start.lower)
        along = np.sqrt(place.lower * start.lower) + np.sqrt(place.upper * start.upper)
        return 2 * np.arctan2(2 * width * place.cn**2 / (down + up), along)

    def aside(place: _Place) -> Any:
        return start.about_rod * width * place.cn**2 / np.sqrt(place.upper * place.lower)

    def mean(what: Callable[[_Place], Any]) -> float:
        total, _ = quad(lambda x: what(course.after_lowest(x)), 0, whole, epsabs=0, epsrel=1e-10, limit=500)
        return float(total / whole) if width else 0.0

    rate = course.mean_rate

    def ahead(x: float) -> Any:
        """Azimuth from the lowest place on, on top of its mean course [rad]."""
        return course.bend(course.after_lowest(x)) + (path.drift - rate) * x / path.pace

    lead = np.nan
    if rate:
        found = minimize_scalar(lambda x: -abs(ahead(x) / rate), bounds=(0, whole), method="bounded")
        lead = -found.fun
    return Nutation(
        period=float(course.period),
        mean_sag=float(start.flip * mean(sag)),
        greatest_sag=float(start.flip * sag(course.after_lowest(0.0))),
        sideways=float(start.flip * mean(aside)),
        lead=float(lead),
    )


def _vector(level: Any, height: Any, flip: Any) -> Any:
    """A vector in the fixed frame from its horizontal part, a complex number, and its height."""
    vector = np.empty((*np.shape(level), 3))
    vector[..., 0], vector[..., 1], vector[..., 2] = level.real, flip * level.imag, flip * height
    return vector


class _Place(Struct, frozen=True, eq=False):
    """A place on an orbit, by Jacobi's functions there."""

    sn: Any
    """[1], with the sign of the rod's rise."""
    cn: Any
    dn: Any
    upper: Any
    """1 − u [1], with its own digits."""
    lower: Any
    """1 + u [1], with its own digits."""


class _Course:
    """An orbit run through in time: the place and the azimuth swept."""

    def __init__(self, path: Orbit) -> None:
        from scipy.special import elliprf

        self.orbit = path
        start, width = path.start, path.high - path.low
        self._weigh(path, width)
        with np.errstate(divide="ignore", invalid="ignore"):
            sn = np.where(width > 0, np.sqrt(-path.low / width), width)
            cn = np.where(width > 0, np.sqrt(path.high / width), 1)
        # At a turning point the climb is 0: the rod comes from the upper one and is at the end of its way to the lower.
        first = self._place(np.where(start.climb > 0, sn, -sn), cn)
        self.phase = first.sn * elliprf(first.cn**2, first.dn**2, 1.0)
        self.offset = self.bend(first)
        # Near the vertical the way H leans tells the azimuth, elsewhere the way the rod points.
        towards = start.rate2 * np.sqrt(first.upper * first.lower) * start.place
        towards = towards + np.conj(self.lean(first)) * start.leaning
        # One that stands has no azimuth, and needs none.
        self.heading = np.sign(towards)
        self._leave_pole()

    def _leave_pole(self) -> None:
        """Count a motion that starts at the vertical from the azimuth at which it leaves, a quarter turn on."""
        path, start = self.orbit, self.orbit.start
        above = (start.upper < UPRIGHT) & (path.upper_far > UPRIGHT)
        below = (start.lower < UPRIGHT) & (path.lower_far > UPRIGHT)
        if (above | below).any():
            miss = np.where(above, path.upper_miss, path.lower_miss)
            quarter = np.where(above | below, np.copysign(np.pi / 2, miss), 0)
            self.offset = self.offset + quarter
            self.heading = self.heading * np.exp(1j * quarter)
            # The passage takes less than the last digit of the phase.
            self.phase = np.where(below, np.finfo(float).epsneg, self.phase)

    def _weigh(self, path: Orbit, width: Any) -> None:
        """What multiplies the two integrals of the third kind, and their whole values."""
        from scipy.special import elliprj

        m1 = path.complement
        scale = width / (6 * path.pace)
        self.upper_weight = scale * path.upper_miss / path.upper_far**2
        self.lower_weight = scale * path.lower_miss / np.sqrt(m1) / path.lower_far**2
        self.lower_bend = self.lower_weight * elliprj(1.0, 0.0, 1 / m1, path.lower_near / path.lower_far)
        self.upper_bend = self.upper_weight * elliprj(0.0, m1, 1.0, path.upper_near / path.upper_far)

    def _place(self, sn: Any, cn: Any) -> _Place:
        path = self.orbit
        width = path.high - path.low
        dn = np.sqrt(path.complement + path.parameter * cn**2)
        return _Place(sn, cn, dn, path.upper_near + width * cn**2, path.lower_near + width * sn**2)

    def bend(self, place: _Place) -> Any:
        """Azimuth on top of R t, from the lower turning point to a place on either side of it [rad]."""
        from scipy.special import elliprj

        path = self.orbit
        s2, c2, d2 = place.sn**2, place.cn**2, place.dn**2
        from_below = elliprj(c2, d2, 1.0, place.upper / path.upper_far)
        from_above = elliprj(1.0, s2, d2 / path.complement, place.lower / path.lower_far)
        upper = self.upper_weight * np.abs(place.sn) * s2 * from_below
        lower = self.lower_bend - self.lower_weight * np.abs(place.cn) * c2 * from_above
        return np.copysign(1.0, place.sn) * (upper + lower)

    def lean(self, place: _Place) -> Any:
        """Horizontal part of H/I, as a complex number relative to the rod's azimuth [rad/s]."""
        path = self.orbit
        start = path.start
        # a − l u by what is small at the nearer pole, because it is divided by sinθ.
        along = np.where(
            place.upper < place.lower,
            start.about_z * place.upper - path.upper_miss,
            path.lower_miss - start.about_z * place.lower,
        )
        climb = 2 * path.pace * (path.high - path.low) * place.sn * place.cn * place.dn
        return (along - 1j * climb) / np.sqrt(place.upper * place.lower)

    def after_lowest(self, argument: Any) -> _Place:
        """The place by the argument of sn, within ±K of the lowest one."""
        angle = self.orbit.ladder.amplitude(argument)
        return self._place(np.sin(angle), np.cos(angle))

    def at(self, time: ArrayLike) -> tuple[Any, _Place]:
        """Swept azimuth [rad] in the frame of the orbit, and the place, at a time [s]."""
        path, time = self.orbit, np.asarray(time, dtype=float)
        argument = self.phase + path.pace * time
        nutations = np.round(argument / (2 * path.ladder.quarter))
        place = self.after_lowest(argument - nutations * 2 * path.ladder.quarter)
        whole = 2 * nutations * (self.upper_bend + self.lower_bend)
        return path.drift * time + (whole + (self.bend(place) - self.offset)), place

    @property
    def period(self) -> Any:
        """Time of a whole nutation [s]."""
        return 2 * self.orbit.ladder.quarter / self.orbit.pace

    @property
    def mean_rate(self) -> Any:
        """Secular φ̇ in the frame of the orbit [rad/s]."""
        return self.orbit.drift + 2 * (self.upper_bend + self.lower_bend) / self.period

    def time_to(self, angle: Any) -> Any:
        """First time [s] at which the swept azimuth is `angle` [rad].

        In a nutation the azimuth goes forth and back once, or only forth, or only back, so the first arrival is on
        the forward stretch of the first nutation whose end is far enough.
        """
        sense, target = np.copysign(1.0, angle), np.abs(angle)
        end, stretch = self._forward(sense)
        gain = sense * self.mean_rate * self.period
        missing = target - sense * self.at(end)[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            nutations = np.where(missing > 0, np.ceil(missing / gain), 0)
        never = ((missing > 0) & ~(gain > 0)) | (stretch == 0) | (nutations > _LONGEST)
        late = np.where(never, end, end + nutations * self.period)
        early = np.where(never, end, np.maximum(late - stretch, 0))
        when = find_crossing(lambda time: sense * self.at(time)[0] - target, early, late)
        return np.where(target == 0, 0, np.where(never, np.inf, when))[()]

    def _forward(self, sense: Any) -> tuple[Any, Any]:
        """When the azimuth first stops going in this sense, and how long each such stretch is [s]."""
        from scipy.special import elliprf

        path, quarter = self.orbit, self.orbit.ladder.quarter
        # l − a u at the turning points; between them its sign changes at most once, for it is linear in u.
        below = sense * _turning(path, path.upper_far, path.lower_near)
        above = sense * _turning(path, path.upper_near, path.lower_far)
        back = below * above < 0
        with np.errstate(divide="ignore", invalid="ignore"):
            s2, c2 = below / (below - above), above / (above - below)
            reversal = np.sqrt(s2) * elliprf(c2, path.complement + path.parameter * c2, 1.0)
        half = np.where(back, np.where(below > 0, reversal, quarter - reversal), quarter * (below + above > 0))
        middle = quarter * (back & (below <= 0))
        end = np.mod(middle + half - self.phase, 2 * quarter) / path.pace
        return end, 2 * half / path.pace


def _turning(path: Orbit, upper: Any, lower: Any) -> Any:
    """φ̇ sin²θ = l − a u [rad/s], exact at the pole that is near."""
    spin = path.start.about_rod
    return np.where(upper < lower, path.upper_miss + spin * upper, path.lower_miss - spin * lower)


def find_crossing(function: Callable[[Any], Any], early: ArrayLike, late: ArrayLike) -> Any:
    """Halve the ways from `early` to `late` down to the last digit of where each function rises through 0.

    If the function is 0 nowhere between them, it is the end that is closer to 0. Halving is slow but sure: Newton's
    method stalls where a precessing rod stands still.
    """
    low, high = np.broadcast_arrays(np.asarray(early, dtype=float), np.asarray(late, dtype=float))
    while True:
        middle = low + (high - low) / 2
        if not ((low < middle) & (middle < high)).any():
            return high
        below = function(middle) < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
