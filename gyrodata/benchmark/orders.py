"""Integrators: how the error falls as they ask for the torque more often, over one turn and over many.

One top throughout, let go from rest with a level rod at 150 rpm. It nods deeply, eight times in a turn about the
vertical. The truth is the exact motion. The number of evaluations of the torque is the same on every machine; the time
of one evaluation is that of Python, and a compiled program may rank the methods differently.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from msgspec import Struct

from gyrodata import motion, physics
from gyrodata.benchmark.effort import Clock, Effort
from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats

INERTIA, MASS, POSITION = 4.44e-3, 0.060, 0.15
"""I_zz of a 4-inch steel ball [kg*m^2], and the heaviest weight of a usual lab [kg] with its place [m]."""

TOP = motion.Top(
    INERTIA, DEFAULT_TRANSVERSE_RATIO * INERTIA + MASS * POSITION**2, MASS * POSITION * physics.STANDARD_GRAVITY
)
SPIN = 150 * RPM
START = motion.released(TOP, SPIN)
NUTATION = 2 * math.pi / float(physics.nutation_rate(SPIN, INERTIA, TOP.transverse_inertia))
TURN = 2 * math.pi / float(motion.mean_precession_rate(TOP, START))
"""Periods [s]."""

METHODS = {"splitting strang": 2, "splitting aba84": 4, "RK4": 4, "RK45": 5, "DOP853": 8}
"""Integrators with the order that they are known for."""

AIMS = (1e-3, 1e-6, 1e-9)
"""Errors of e3 for which the evaluations are told [1]."""

_ARRIVED = 3e-13
"""Below this error only rounding is seen."""


class Grade(Struct, frozen=True):
    """One method with one setting."""

    setting: str
    fineness: float
    """Steps in a nutation; for a method that chooses its steps, evaluations."""
    evaluations: int
    """How often it asks for the torque, in all turns."""
    seconds: float
    """CPU time of an evaluation, in Python [s]."""
    off: float
    """Distance of e3 from the true one at the end [1]."""


class Order(Struct, frozen=True):
    """The curve of one method."""

    method: str
    turns: int
    points: tuple[Grade, ...]

    @property
    def order(self) -> float | None:
        """The slope between steps that are too coarse and rounding; None if there is none."""
        seen = [point for point in self.points if 1e-11 < point.off < 1e-3]
        if len(seen) < 2:
            return None
        fineness, off = np.log([p.fineness for p in seen]), np.log([p.off for p in seen])
        return -float(np.polyfit(fineness, off, 1)[0])

    def evaluations(self, aim: float) -> float | None:
        """Evaluations for an error of e3, interpolated on the double logarithmic curve; None if none is so near."""
        for before, after in zip(self.points, self.points[1:], strict=False):
            if after.off <= aim < before.off:
                share = math.log(before.off / aim) / math.log(before.off / after.off)
                return float(before.evaluations * (after.evaluations / before.evaluations) ** share)
        return None


def find_orders(effort: Effort, clock: Clock) -> list[Order]:
    """Follow the top for one turn and for many, by every method, ever more finely."""
    orders = []
    for turns in (1, effort.turns):
        true = motion.exact(TOP, START, turns * TURN).axis
        for method in METHODS:
            points: list[Grade] = []
            for setting, fineness in _settings(method):
                begun = clock()
                axis, evaluations = _follow(method, fineness, turns * TURN)
                seconds = max(clock() - begun, 1e-9) / evaluations
                off = float(np.linalg.norm(axis - true))
                points.append(
                    Grade(setting, fineness if "steps" in setting else evaluations, evaluations, seconds, off)
                )
                if off < _ARRIVED or 2 * evaluations > effort.evaluations * turns**0.5:
                    break
            orders.append(Order(method, turns, tuple(points)))
    return orders


def cheapest(orders: Sequence[Order], turns: int) -> dict[str, tuple[float, float]]:
    """Find the methods with the fewest evaluations, each with the largest and the smallest error for which it is so."""
    winners: dict[str, tuple[float, float]] = {}
    for aim in np.geomspace(1e-2, 1e-11, 181).tolist():
        needed = {o.method: count for o in orders if o.turns == turns and (count := o.evaluations(aim))}
        if needed:
            best = min(needed, key=lambda method: needed[method])
            winners[best] = winners.get(best, (aim,))[0], aim
    return winners


def _settings(method: str) -> Iterator[tuple[str, float]]:
    """Name ever finer settings: steps in a nutation, or the relative tolerance."""
    for power in range(2, 13):
        if method.startswith("splitting") or method == "RK4":
            yield f"{2**power} steps a nutation", 2.0**power
        else:
            yield f"rtol 1e-{power + 1}", 10.0 ** -(power + 1)


def _follow(method: str, fineness: float, time: float) -> tuple[Floats, int]:
    """Follow the top for a time; give e3 at its end and the count of evaluations."""
    steps = math.ceil(fineness * time / NUTATION)
    if method == "RK4":
        row = [*START.axis.tolist(), *START.momentum.tolist()]
        return np.array(runge_kutta(motion.vector_rates(TOP), row, time / steps, steps)[:3]), 4 * steps
    if method.startswith("splitting"):
        name = method.removeprefix("splitting ")
        return motion.split(TOP, START, time, steps, name).axis, steps * len(motion.METHODS[name][1])
    path = motion.integrate(TOP, START, time, method=method, rtol=fineness, atol=1e-3 * fineness)
    return path.axis, path.evaluations


def runge_kutta(rates: Callable[..., Sequence[float]], row: Sequence[float], step: float, steps: int) -> list[float]:
    """Take steps of the classical method of Runge and Kutta; `rates` has the components of the row as arguments."""
    for _ in range(steps):
        a = rates(*row)
        b = rates(*[y + step / 2 * k for y, k in zip(row, a, strict=True)])
        c = rates(*[y + step / 2 * k for y, k in zip(row, b, strict=True)])
        d = rates(*[y + step * k for y, k in zip(row, c, strict=True)])
        row = [y + step / 6 * (p + 2 * (q + r) + s) for y, p, q, r, s in zip(row, a, b, c, d, strict=True)]
    return list(row)
