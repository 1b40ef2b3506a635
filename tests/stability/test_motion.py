"""The motion, where ways of writing it and of stepping through it fail."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gyrodata import motion
from gyrodata.benchmark.stability import ACROSS, INERTIA, TORQUE, follow_euler, follow_reduced, nodding
from gyrodata.physics import RPM

TOP = motion.Top(INERTIA, ACROSS, TORQUE)
TIMES = np.linspace(0.0, 5.0, 21)[1:]
NUTATION = 2 * math.pi * ACROSS / (INERTIA * 400 * RPM)
"""Period of a nutation at 400 rpm [s]."""


def off(axis: np.ndarray, state: motion.State, times: np.ndarray = TIMES) -> float:
    """Distance of e3 from the exact one, at its worst."""
    return float(np.max(np.linalg.norm(axis - motion.exact(TOP, state, times).axis, axis=-1)))


def test_euler_angles_die_at_the_pole() -> None:
    start = nodding(0.0)
    assert follow_euler(start, TIMES)[0] is None
    assert follow_reduced(start, TIMES)[0] is None
    path = motion.integrate(TOP, start, TIMES)
    assert off(path.axis, start) < 1e-7
    assert off(motion.split(TOP, start, TIMES[-1], 1000).axis[None], start, TIMES[-1:]) < 1e-6


def test_too_few_steps_a_nutation_are_wrong_without_a_word() -> None:
    start = motion.released(TOP, 400 * RPM)
    few, enough = (round(per * TIMES[-1] / NUTATION) for per in (1.5, 8.0))
    end = motion.split(TOP, start, TIMES[-1], few, "strang")
    assert off(end.axis[None], start, TIMES[-1:]) > 5e-3
    # What is conserved looks as well as ever.
    assert np.linalg.norm(end.axis) == pytest.approx(1, abs=1e-13)
    assert end.momentum[2] == pytest.approx(start.momentum[2], abs=1e-14)
    assert off(motion.split(TOP, start, TIMES[-1], enough).axis[None], start, TIMES[-1:]) < 1e-5


def test_newton_stalls_where_the_rod_stands_still() -> None:
    start = motion.released(TOP, 200 * RPM)
    rate = float(motion.mean_precession_rate(TOP, start))
    # A rod let go from rest comes to rest again after every nutation: a triple zero for Newton.
    guess = 3 * 2 * math.pi * ACROSS / (INERTIA * 200 * RPM)
    cusp = next(t for t in np.linspace(0.9 * guess, 1.1 * guess, 4001) if motion.exact(TOP, start, t).axis[2] > -1e-8)
    target = float(motion.precession_angle(TOP, start, cusp))
    time = target / rate + 0.05
    for _ in range(6):
        step = 1e-6
        slope = (motion.precession_angle(TOP, start, time + step) - motion.precession_angle(TOP, start, time)) / step
        time -= (motion.precession_angle(TOP, start, time) - target) / slope
    assert abs(motion.precession_angle(TOP, start, time) - target) > 1e-8
    held = motion.time_to_turn(TOP, start, target)
    assert motion.precession_angle(TOP, start, held) == pytest.approx(target, abs=1e-14)
