"""Eqs. (1) to (5) against the axes, moved by hand, and against eqs. (7) and (8)."""

from __future__ import annotations

import math
from collections.abc import Callable

import kinematics
import numpy as np
import pytest

from gyrodata import physics
from gyrodata.physics import Floats

INERTIA, TRANSVERSE, TORQUE, SPIN = 4.44e-3, 5.7e-3, 0.0588, 40.0


def azimuth(time: float) -> float:
    return 0.4 + 1.3 * time - 0.2 * time**2


def theta(time: float) -> float:
    return 1.1 + 0.3 * math.sin(2 * time)


def spun(time: float) -> float:
    return 5 * time + 0.5 * time**2


def change(
    what: Callable[[float], Floats | float], time: float, step: float = 1e-4
) -> Floats:
    """Derivative by differences of fourth order."""
    far, near = (np.subtract(what(time + d), what(time - d)) for d in (2 * step, step))
    return np.asarray((8 * near - far) / (12 * step))


def axes(time: float) -> Floats:
    return kinematics.frame_axes(azimuth(time), theta(time))


def frame(time: float) -> Floats:
    return kinematics.frame_rotation(
        float(change(theta, time)), float(change(azimuth, time)), theta(time)
    )


def body(time: float) -> Floats:
    rates = (float(change(what, time)) for what in (theta, azimuth, spun))
    return kinematics.body_rotation(*rates, theta(time))


@pytest.mark.parametrize("time", [0.0, 0.7, 1.9])
def test_the_frame_turns_by_equation_one(time: float) -> None:
    rotation = frame(time) @ axes(time)
    np.testing.assert_allclose(
        change(axes, time), np.cross(rotation, axes(time)), atol=1e-9
    )


@pytest.mark.parametrize("time", [0.0, 0.7, 1.9])
def test_equations_3_to_5_are_the_change_of_the_fixed_vector(time: float) -> None:
    def momentum(now: float) -> Floats:
        return kinematics.angular_momentum(body(now), INERTIA, TRANSVERSE) @ axes(now)

    parts = kinematics.momentum_change(
        body(time), change(body, time), frame(time), INERTIA, TRANSVERSE
    )
    np.testing.assert_allclose(parts @ axes(time), change(momentum, time), atol=1e-8)


@pytest.mark.parametrize("pitch", [-0.6, 0.0, 0.3])
def test_steady_precession_balances_the_torque(pitch: float) -> None:
    tilt = math.pi / 2 - pitch
    for root in (physics.precession_rate, physics.fast_precession_rate):
        rate = root(TORQUE, SPIN, INERTIA, TRANSVERSE, pitch)
        if math.isinf(rate):
            continue
        own, turning = (
            kinematics.body_rotation(0.0, rate, SPIN, tilt),
            kinematics.frame_rotation(0.0, rate, tilt),
        )
        found = kinematics.momentum_change(
            own, np.zeros(3), turning, INERTIA, TRANSVERSE
        )
        np.testing.assert_allclose(
            found, [TORQUE * math.sin(tilt), 0, 0], rtol=1e-9, atol=1e-15
        )
