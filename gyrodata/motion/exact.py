"""The exact motion of eqs. (7) at any time, by Jacobi's elliptic functions and Carlson's integrals."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from gyrodata.motion.orbits import UPRIGHT, Orbit, State, Top, orbit, released

_LONGEST = 1e12
"""Number of nutations after which an angle will not be reached: a mean rate this small is rounding."""


def exact(top: Top, state: State, time: ArrayLike) -> State:
    """Compute the state at any time [s], of either sign, in closed form.

    The error is about 1e-15 times the largest of 1 and the angles of nutation, unless the motion magnifies the last
    digit of `state`, as near the unstable upright position.
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
    """Compute the azimuth that the rod sweeps from time 0 on, not reduced to one turn [rad].

    Counterclockwise seen from above is positive. A rod that passes exactly through the vertical turns by half a turn
    there, in the direction of its other motion, or counterclockwise without other motion. A rod that starts there has
    azimuth 0 in the direction in which it leaves. A rod that stays upright sweeps 0.
    """
    course = _Course(orbit(top, state))
    swept, _ = course.at(time)
    return course.orbit.start.flip * swept


def mean_precession_rate(top: Top, state: State) -> Any:
    """Compute the mean rate of precession: the azimuth swept in one nutation over its period [rad/s].

    The vertical has the same meaning as in `precession_angle`.
    """
    path = orbit(top, state)
    rate = _summed_rate(path)
    return path.start.flip * (_Course(path).mean_rate if rate is None else rate)


_POINTS = 120
"""Largest number of points in half a nutation; more would take as long as the complete integrals."""

_UPRIGHT_ENOUGH = 1e-3
"""Distance from a pole, in 1 − |cosθ|, below which l − a u loses digits."""


def _summed_rate(path: Orbit) -> Any:
    """Compute the mean φ̇ by the midpoint rule [rad/s]; None if this would need too many points.

    With u = u1 + (u2 − u1) sin²(ψ/2) the time is proportional to ∫ dψ/√(1 − m sin²(ψ/2)); all is periodic and smooth
    in ψ. N points have an error of e^(−2 N arcosh x), with x the distance of the nearest of −1, 1 and u3 from
    the middle, in half widths (Trefethen & Weideman, SIAM Review 56, 385, 2014).
    """
    width, nearest = np.asarray(path.high - path.low), np.minimum(path.upper_near, path.lower_near)
    with np.errstate(divide="ignore", invalid="ignore"):
        beyond = np.minimum(nearest / width, path.complement / path.parameter)
    # For steady precession the width is 0.
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
    """Compute the first time at which the rod has swept an angle about the vertical [s].

    The error is about 1e-15 of the time and of the nutation's period, and the effect of the last digit of the angle
    (large near a cusp, where the rod is at rest). Infinite if the rod does not reach the angle in 1e12 nutations.
    """
    course = _Course(orbit(top, state))
    return course.time_to(course.orbit.start.flip * np.asarray(angle, dtype=float))


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
    from scipy.integrate import quad
    from scipy.optimize import minimize_scalar

    course = _Course(orbit(top, released(top, spin, pitch)))
    path, start, whole = course.orbit, course.orbit.start, course.orbit.ladder.quarter
    width = path.high - path.low

    def sag(place: _Place) -> Any:
        """Compute the angle from the start, the highest place, by half angles without cancellation."""
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
        """Compute the azimuth from the lowest place minus uniform precession [rad]."""
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
    """Return a vector in the fixed frame from its horizontal part, a complex number, and its height."""
    vector = np.empty((*np.shape(level), 3))
    vector[..., 0], vector[..., 1], vector[..., 2] = level.real, flip * level.imag, flip * height
    return vector


class _Place(Struct, frozen=True, eq=False):
    """A place on an orbit, given by Jacobi's functions."""

    sn: Any
    """[1]; positive while the rod rises."""
    cn: Any
    dn: Any
    upper: Any
    """1 − u [1], with its own digits."""
    lower: Any
    """1 + u [1], with its own digits."""


class _Course:
    """The motion along an orbit: the place and the swept azimuth at a time."""

    def __init__(self, path: Orbit) -> None:
        from scipy.special import elliprf

        self.orbit = path
        start, width = path.start, path.high - path.low
        self._weigh(path, width)
        with np.errstate(divide="ignore", invalid="ignore"):
            sn = np.where(width > 0, np.sqrt(-path.low / width), width)
            cn = np.where(width > 0, np.sqrt(path.high / width), 1)
        # At a turning point the climb is 0; the rod is then on its way from the upper to the lower one.
        first = self._place(np.where(start.climb > 0, sn, -sn), cn)
        self.phase = first.sn * elliprf(first.cn**2, first.dn**2, 1.0)
        self.offset = self.bend(first)
        # Near the vertical the direction of H gives the azimuth, elsewhere the direction of the rod.
        towards = start.rate2 * np.sqrt(first.upper * first.lower) * start.place
        towards = towards + np.conj(self.lean(first)) * start.leaning
        # An upright rod has no azimuth, and does not need one.
        self.heading = np.sign(towards)
        self._leave_pole()

    def _leave_pole(self) -> None:
        """Start a motion from the vertical at the azimuth at which the rod leaves, a quarter turn further."""
        path, start = self.orbit, self.orbit.start
        above = (start.upper < UPRIGHT) & (path.upper_far > UPRIGHT)
        below = (start.lower < UPRIGHT) & (path.lower_far > UPRIGHT)
        if (above | below).any():
            miss = np.where(above, path.upper_miss, path.lower_miss)
            quarter = np.where(above | below, np.copysign(np.pi / 2, miss), 0)
            self.offset = self.offset + quarter
            self.heading = self.heading * np.exp(1j * quarter)
            # The passage is shorter than the last digit of the phase.
            self.phase = np.where(below, np.finfo(float).epsneg, self.phase)

    def _weigh(self, path: Orbit, width: Any) -> None:
        """Compute the factors of the two integrals of the third kind, and the complete integrals."""
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
        """Compute the azimuth minus R t, from the lower turning point to a place on either side of it [rad]."""
        from scipy.special import elliprj

        path = self.orbit
        s2, c2, d2 = place.sn**2, place.cn**2, place.dn**2
        from_below = elliprj(c2, d2, 1.0, place.upper / path.upper_far)
        from_above = elliprj(1.0, s2, d2 / path.complement, place.lower / path.lower_far)
        upper = self.upper_weight * np.abs(place.sn) * s2 * from_below
        lower = self.lower_bend - self.lower_weight * np.abs(place.cn) * c2 * from_above
        return np.copysign(1.0, place.sn) * (upper + lower)

    def lean(self, place: _Place) -> Any:
        """Compute the horizontal part of H/I, as a complex number relative to the rod's azimuth [rad/s]."""
        path = self.orbit
        start = path.start
        # a − l u from the small quantities of the nearer pole, because it is divided by sinθ.
        along = np.where(
            place.upper < place.lower,
            start.about_z * place.upper - path.upper_miss,
            path.lower_miss - start.about_z * place.lower,
        )
        climb = 2 * path.pace * (path.high - path.low) * place.sn * place.cn * place.dn
        return (along - 1j * climb) / np.sqrt(place.upper * place.lower)

    def after_lowest(self, argument: Any) -> _Place:
        """Return the place for an argument of sn, within ±K of the lowest place."""
        angle = self.orbit.ladder.amplitude(argument)
        return self._place(np.sin(angle), np.cos(angle))

    def at(self, time: ArrayLike) -> tuple[Any, _Place]:
        """Compute the swept azimuth [rad] in the frame of the orbit, and the place, at a time [s]."""
        path, time = self.orbit, np.asarray(time, dtype=float)
        argument = self.phase + path.pace * time
        nutations = np.round(argument / (2 * path.ladder.quarter))
        place = self.after_lowest(argument - nutations * 2 * path.ladder.quarter)
        whole = 2 * nutations * (self.upper_bend + self.lower_bend)
        return path.drift * time + (whole + (self.bend(place) - self.offset)), place

    @property
    def period(self) -> Any:
        """Period of the nutation [s]."""
        return 2 * self.orbit.ladder.quarter / self.orbit.pace

    @property
    def mean_rate(self) -> Any:
        """Mean φ̇ in the frame of the orbit [rad/s]."""
        return self.orbit.drift + 2 * (self.upper_bend + self.lower_bend) / self.period

    def time_to(self, angle: Any) -> Any:
        """Compute the first time [s] at which the swept azimuth is `angle` [rad].

        In a nutation the azimuth moves forward and backward once, or only in one direction. So it first reaches the
        angle in the forward part of the first nutation whose end is far enough.
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
        """Compute the end of the first motion in this direction, and the duration of each such motion [s]."""
        from scipy.special import elliprf

        path, quarter = self.orbit, self.orbit.ladder.quarter
        # l − a u at the turning points; it is linear in u, so its sign changes at most once between them.
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
    """Compute φ̇ sin²θ = l − a u [rad/s], exactly at the nearer pole."""
    spin = path.start.about_rod
    return np.where(upper < lower, path.upper_miss + spin * upper, path.lower_miss - spin * lower)


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
