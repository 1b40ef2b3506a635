"""What small errors do to I_zz: each against a run worked out with the error in it, and in digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from gyrodata import physics

INERTIA, SPIN, TORQUE = 4.44e-3, 40.0, 0.0294


def estimate(torque: float, time: float, turns: float = 1.0) -> mpmath.mpf:
    """I_zz by eq. (9), as a student works it out."""
    return mpmath.mpf(torque) * time / (2 * mpmath.pi * turns * SPIN)


def true_time(torque: float, turns: float = 1.0) -> float:
    return float(2 * mpmath.pi * turns * INERTIA * SPIN / mpmath.mpf(torque))


@pytest.mark.parametrize("imbalance", [3e-4, -3e-4, 0.01])
def test_imbalance_taken_for_none(imbalance: float) -> None:
    found = estimate(TORQUE, true_time(TORQUE + imbalance)) / INERTIA - 1
    assert physics.imbalance_bias(TORQUE, imbalance) == pytest.approx(float(found), rel=1e-12)


def test_imbalance_with_the_weights_of_three_fits() -> None:
    # M0 = 3e-4 N*m, 1 % of the lightest of 1 : 2 : 3.
    torque, spin = np.meshgrid(physics.torque(np.array([0.02, 0.04, 0.06]), 0.15, 9.8031), [20.0, 40.0, 60.0])
    bias = physics.imbalance_bias(torque, 3e-4)
    product = (torque + 3e-4) / INERTIA
    weights = {"ratios": np.ones_like(torque), "squares": product**2, "time": (spin / torque) ** 2}
    found = {name: 100 * np.average(bias, weights=weight) for name, weight in weights.items()}
    assert found == pytest.approx({"ratios": -0.62, "squares": -0.44, "time": -0.86}, abs=0.006)
    # The middle one is the slope of M against φ̇ψ̇ through the origin.
    slope = np.sum(product * torque) / np.sum(product**2)
    assert 100 * (slope / INERTIA - 1) == pytest.approx(found["squares"], rel=1e-9)


@pytest.mark.parametrize("bias", [0.1, -0.03])
def test_a_slow_hand(bias: float) -> None:
    time = true_time(TORQUE)
    found = estimate(TORQUE, time + bias) / INERTIA - 1
    assert physics.timing_bias(time, bias) == pytest.approx(float(found), rel=1e-11)


def test_small_errors_in_digits() -> None:
    times = np.array([2.2, 10.0, 60.0])
    np.testing.assert_allclose(100 * physics.timing_bias(times, 0.1), [4.5, 1.0, 0.17], atol=0.05)


def test_a_four_inch_steel_ball() -> None:
    assert physics.solid_ball_inertia(4.30, 0.1016) == pytest.approx(4.44e-3, rel=2e-3)
