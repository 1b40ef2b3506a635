"""The right-hand side of the integrators, with drag."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrodata import physics
from gyrodata.physics.motion import Top, integrate, released, steady, vector_rates

INERTIA = 4.44e-3
TOP = Top(inertia=INERTIA, transverse_inertia=1.3 * INERTIA, torque=0.0294)
FAST = 600 * np.pi / 30


@pytest.mark.slow
@pytest.mark.parametrize("drop", [0.1, 0.3, 0.5])
def test_under_drag_the_angle_is_that_of_the_harmonic_mean_spin(drop: float) -> None:
    decay = 20.0
    time = -decay * np.log(1 - drop)
    state, rates = steady(TOP, FAST), vector_rates(TOP, INERTIA / decay)
    path = solve_ivp(
        lambda _, row: rates(row),
        (0, time),
        np.concatenate([state.axis, state.momentum]),
        "DOP853",
        np.linspace(0, time, 200),
        rtol=1e-8,
        atol=1e-12,
    ).y.T
    swept = np.unwrap(np.arctan2(path[:, 1], path[:, 0]))[-1]
    spin = np.sum(path[:, :3] * path[:, 3:], axis=-1) / INERTIA
    assert spin[-1] / spin[0] == pytest.approx(1 - drop, rel=1e-8)
    mean = physics.harmonic_mean_spin(spin[0], spin[-1])
    assert swept == pytest.approx(TOP.torque * time / (INERTIA * mean), rel=4e-5)


def test_drag_is_a_torque_against_the_whole_rotation() -> None:
    axis, momentum = np.array([0.6, 0.0, 0.8]), np.array([0.02, 0.04, 0.3])
    about_rod = axis @ momentum
    rotation = (momentum - about_rod * axis) / (
        1.3 * INERTIA
    ) + about_rod / INERTIA * axis
    expected = TOP.torque * np.array([-axis[1], axis[0], 0.0]) - 1e-4 * rotation
    assert vector_rates(TOP, 1e-4)([*axis, *momentum])[3:] == pytest.approx(
        tuple(expected), rel=1e-14
    )


def test_times_that_do_not_rise_are_refused() -> None:
    with pytest.raises(ValueError, match=r"sorted|rise|within"):
        integrate(TOP, released(TOP, FAST), [1.0, 0.5])


@pytest.mark.parametrize("spin", [0.0, 1e-320, 1e-160])
def test_a_rod_without_spin_and_torque_stays_at_rest(spin: float) -> None:
    balanced = Top(inertia=INERTIA, transverse_inertia=1.3 * INERTIA, torque=0.0)
    path, _ = integrate(balanced, released(balanced, spin), [1.0, 60.0])
    assert path.axis == pytest.approx(np.array([[1.0, 0, 0], [1.0, 0, 0]]))


@pytest.mark.parametrize("time", [np.nan, np.inf, 0.5, -1.0])
def test_a_time_that_does_not_rise_is_refused(time: float) -> None:
    with pytest.raises(ValueError, match="the times must be finite and rise from 0"):
        integrate(TOP, released(TOP, FAST), [1.0, time])
