"""The general integrator: drag, other torques, what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from gyrodata import physics
from gyrodata.motion import Top, energy, exact, integrate, released, steady
from gyrodata.physics import Floats

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


def test_any_torque_adds_to_that_of_gravity() -> None:
    # Gravity handed in as a torque, on a top without its own; a film of air written out.
    def gravity(_: float, axis: Floats, __: Floats) -> list[float]:
        return [-TOP.torque * axis[1], TOP.torque * axis[0], 0.0]

    def film(_: float, axis: Floats, momentum: Floats) -> Floats:
        about_rod = axis @ momentum
        return -1e-4 * ((momentum - about_rod * axis) / (1.3 * INERTIA) + about_rod / INERTIA * axis)

    state, free = released(TOP, FAST, 0.1), Top(INERTIA, 1.3 * INERTIA, 0.0)
    here, there = integrate(free, state, 2.0, drag=gravity), integrate(TOP, state, 2.0)
    assert here.axis == pytest.approx(there.axis, abs=1e-12)
    here, there = integrate(TOP, state, 2.0, drag=film), integrate(TOP, state, 2.0, drag=1e-4)
    assert here.axis == pytest.approx(there.axis, abs=1e-11)
    assert energy(TOP, here) < energy(TOP, state)


def test_what_cannot_be_integrated_is_refused() -> None:
    one, two, state = TOP, Top(INERTIA, INERTIA, np.array([0.1, 0.2])), released(TOP, FAST)
    for top, times, drag, match in (
        (two, [1.0, 2.0, 3.0], 0.0, "one time, or one for each top"),
        (two, 1.0, lambda *_: [0.0, 0.0, 0.0], "takes one top at a time"),
        (two, 1.0, [0.0, np.nan], "drag is not a finite number"),
        (one, [1.0, 0.5], 0.0, "rise from 0, or fall"),
        (one, [-1.0, 0.5], 0.0, "rise from 0, or fall"),
        (one, 1.0, lambda *_: [np.nan, 0.0, 0.0], r"torque at .* is not a finite number"),
        (one, 1.0, lambda time, *_: [0.0, 0.0, 1e-3 / (0.5 - time) ** 2], "gave up"),
    ):
        with pytest.raises(ValueError, match=match):
            integrate(top, state, times, drag=drag)
