"""The general integrator: drag, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from gyrodata import physics
from gyrodata.motion import Top, energy, exact, integrate, released, steady, vector_rates

INERTIA = 4.44e-3
TOP = Top(INERTIA, 1.3 * INERTIA, 0.0294)
FAST = 600 * np.pi / 30


@pytest.mark.parametrize("drop", [0.1, 0.3, 0.5])
def test_under_drag_the_angle_is_that_of_the_harmonic_mean_spin(drop: float) -> None:
    decay = 20.0
    time = -decay * np.log(1 - drop)
    times = np.linspace(0, time, 200)
    path = integrate(TOP, steady(TOP, FAST), times, drag=INERTIA / decay, rtol=1e-8)
    swept = np.unwrap(np.arctan2(path.axis[:, 1], path.axis[:, 0]))[-1]
    spin = np.sum(path.axis * path.momentum, axis=-1) / INERTIA
    assert spin[-1] / spin[0] == pytest.approx(1 - drop, rel=1e-8)
    mean = physics.harmonic_mean_spin(spin[0], spin[-1])
    assert swept == pytest.approx(TOP.torque * time / (INERTIA * mean), rel=4e-5)


@pytest.mark.parametrize("times", [[0.0, 0.5, 0.5, 2.0], [-0.2, -1.0]], ids=["forwards", "backwards"])
def test_without_drag_it_is_the_exact_motion(times: list[float]) -> None:
    state = released(TOP, FAST, -0.2)
    path, true = integrate(TOP, state, times, rtol=1e-11), exact(TOP, state, np.array(times))
    assert np.abs(path.axis - true.axis).max() < 1e-9
    assert np.abs(path.momentum - true.momentum).max() < 1e-9 * INERTIA * FAST


def test_drag_is_a_torque_against_the_whole_rotation() -> None:
    axis, momentum = np.array([0.6, 0.0, 0.8]), np.array([0.02, 0.04, 0.3])
    about_rod = axis @ momentum
    rotation = (momentum - about_rod * axis) / (1.3 * INERTIA) + about_rod / INERTIA * axis
    expected = TOP.torque * np.array([-axis[1], axis[0], 0.0]) - 1e-4 * rotation
    assert vector_rates(TOP, 1e-4)(*axis, *momentum)[3:] == pytest.approx(tuple(expected), rel=1e-14)
    state = released(TOP, FAST, 0.1)
    assert energy(TOP, integrate(TOP, state, 2.0, drag=1e-4)) < energy(TOP, state)


def test_what_cannot_be_integrated_is_refused() -> None:
    state = released(TOP, FAST)
    for times, drag, match in (
        ([1.0], np.nan, "drag is not a finite number"),
        ([1.0, 0.5], 0.0, "rise from 0, or fall"),
        ([-1.0, 0.5], 0.0, "rise from 0, or fall"),
    ):
        with pytest.raises(ValueError, match=match):
            integrate(TOP, state, times, drag=drag)
