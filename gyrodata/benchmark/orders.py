"""Integrators by themselves: by which power of the evaluations each gets better, and what it keeps for how long.

One top throughout, let go from rest level at 150 rpm: it nods deeply, eight times in a turn about the vertical. The
truth is the exact motion. Evaluations of the torque are the same on every machine.
"""

from __future__ import annotations

import math

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata import motion, physics
from gyrodata.benchmark.effort import Effort, Progress
from gyrodata.benchmark.motion_cost import FAMILIES, setting_words, stages_of
from gyrodata.benchmark.stability import ACROSS, INERTIA, TORQUE
from gyrodata.benchmark.steppers import march, tsit5
from gyrodata.physics import RPM, Floats

SPIN = 150 * RPM
"""[rad/s]"""

TOP = motion.Top(INERTIA, ACROSS, TORQUE)
START = motion.released(TOP, SPIN)
NUTATION = 2 * math.pi / float(physics.nutation_rate(SPIN, INERTIA, ACROSS))
"""Period, about [s]."""
PRECESSION = 2 * math.pi / float(motion.mean_precession_rate(TOP, START))
"""Period [s]."""


class Grade(Struct, frozen=True):
    """One method at one setting, after one precession."""

    setting: str
    fineness: float
    """Steps a nutation, or evaluations of a method that chooses its steps."""
    evaluations: int
    off: float
    """Distance of e3 from the true one [1]."""
    energy: float
    """Energy gained or lost, over h m g [1]."""


class Order(Struct, frozen=True):
    """The curve of one method."""

    method: str
    points: tuple[Grade, ...]

    @property
    def order(self) -> float | None:
        """The slope where it is seen, between steps that are too coarse and rounding; None where there is none."""
        seen = [p for p in self.points if 1e-11 < p.off < 1e-3]
        if len(seen) < 2 or self.method in VARYING:
            return None
        fineness, off = np.log([p.fineness for p in seen]), np.log([p.off for p in seen])
        return -float(np.polyfit(fineness, off, 1)[0])


VARYING = ("LSODA",)
"""They choose their order too."""

_MOST = 2.5
"""A curve may take so many times the budget of an effort, as it is one top's."""

_ARRIVED = 3e-13
"""Below it rounding is seen, and no method."""


def find_orders(effort: Effort) -> list[Order]:
    """Follow the top for one precession by every method at every setting."""
    true = motion.exact(TOP, START, PRECESSION).axis
    before = float(motion.energy(TOP, START))
    orders = []
    settings = {**dict.fromkeys(FAMILIES, effort.steps_per_nutation), **effort.tolerances}
    for method, values in settings.items():
        points: list[Grade] = []
        for value in values:
            if method in FAMILIES:
                steps = math.ceil(value * PRECESSION / NUTATION)
                if 4e-6 * steps * stages_of(method) > _MOST * effort.budget:
                    break
                path, fineness = march(method.removeprefix("splitting "), TOP, START, PRECESSION, steps), value
            else:
                path = _adaptive(method, value, PRECESSION)
                fineness = float(path.evaluations)
            off = float(np.linalg.norm(path.axis - true))
            gained = abs(float(motion.energy(TOP, path)) - before) / TORQUE
            points.append(Grade(setting_words(method, value), fineness, path.evaluations, off, gained))
            if off < _ARRIVED:
                break
        orders.append(Order(method, tuple(points)))
    return orders


def _adaptive(method: str, tolerance: float, time: float | Floats) -> motion.Path:
    solver = tsit5() if method == "Tsit5" else method
    return motion.integrate(TOP, START, time, method=solver, rtol=tolerance, atol=1e-3 * tolerance)


# --- what is kept, and for how long -----------------------------------------------------------------------------


class Drift(Struct, frozen=True, eq=False):
    """What one method has lost after so many precessions, at its worst in the nutation that follows."""

    method: str
    setting: str
    per_nutation: float
    """Evaluations of the torque."""
    precessions: Floats
    energy: Floats
    """Off what it was, over h m g [1]."""
    length: Floats
    """| |e3| − 1 | [1]"""
    off: Floats
    """Distance of e3 from the true one [1]."""


WATCHED: tuple[tuple[str, float], ...] = (
    ("RK4", 10.0),
    ("DOP853", 1e-4),
    ("implicit midpoint", 8.0),
    ("RKMK4", 10.0),
    ("splitting strang", 40.0),
    ("splitting aba84", 8.0),
)
"""Methods with steps a nutation or a relative tolerance: each asks for the torque some forty times a nutation."""

_SAMPLES = 41


def watch_drift(effort: Effort, progress: Progress | None = None) -> list[Drift]:
    """Follow the top for many precessions by methods that ask for the torque equally often."""
    whole = effort.precessions * PRECESSION / NUTATION
    nutations = np.unique(np.round(np.geomspace(1, whole, _SAMPLES)).astype(int))
    drifts = []
    for i, (method, setting) in enumerate(WATCHED):
        drifts.append(_watch(method, setting, nutations))
        if progress is not None:
            progress((i + 1) / len(WATCHED))
    return drifts


def _watch(method: str, setting: float, nutations: NDArray[np.int_]) -> Drift:
    """Look for one nutation at what is left, after each of these numbers of nutations."""
    inside = int(setting) if method in FAMILIES else 8
    times = NUTATION * np.add.outer(nutations, np.arange(inside) / inside)
    if method in FAMILIES:
        path = _marched(method, times.ravel(), NUTATION / setting)
    else:
        path = _adaptive(method, setting, times.ravel())
    true = motion.exact(TOP, START, times.ravel()).axis
    lost: tuple[Floats, ...] = (
        (motion.energy(TOP, path) - motion.energy(TOP, START)) / TORQUE,
        np.linalg.norm(path.axis, axis=-1) - 1,
        np.linalg.norm(path.axis - true, axis=-1),
    )
    energy, length, off = (np.abs(part).reshape(times.shape).max(axis=1) for part in lost)
    per = path.evaluations * NUTATION / float(times[-1, -1])
    return Drift(
        method,
        setting_words(method, setting),
        per,
        np.asarray(nutations * (NUTATION / PRECESSION), dtype=float),
        energy,
        length,
        off,
    )


def _marched(method: str, times: Floats, step: float) -> motion.Path:
    """Go by equal steps to each of the times."""
    axes, momenta, evaluations, done = [], [], 0, 0
    state = START
    for steps in np.round(times / step).astype(int).tolist():
        if steps > done:
            path = march(method.removeprefix("splitting "), TOP, state, (steps - done) * step, steps - done)
            state, evaluations, done = path, evaluations + path.evaluations, steps
        axes.append(state.axis)
        momenta.append(state.momentum)
    return motion.Path(np.array(axes), np.array(momenta), evaluations)
