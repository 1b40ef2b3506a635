"""The rate of steady precession, where formulas for it fail: eq. (8) and the means of a falling spin."""

from __future__ import annotations

import math
import warnings
from decimal import Decimal, localcontext

import numpy as np
import pytest

from gyrodata import physics
from gyrodata.benchmark.stability import ACROSS, INERTIA, TORQUE, textbook_root
from gyrodata.physics import RPM

SPIN = 400 * RPM
LEVEL = physics.horizontal_precession_rate(TORQUE, SPIN, INERTIA)


def test_the_textbook_root_vanishes_as_cos_theta_does() -> None:
    # 6e-17 is what the cosine of π/2 is to a computer.
    pitch = np.array([6e-17, 1e-12, 1e-8, 1e-4])
    rate = textbook_root(np.full(4, SPIN), pitch)
    off = np.abs(rate / physics.precession_rate(TORQUE, SPIN, INERTIA, ACROSS, pitch) - 1)
    assert off[0] == 1, "the root is 0"
    assert off[1] > 1e-4
    assert off[2] > 1e-9
    assert off[3] > 1e-13
    assert physics.precession_rate(TORQUE, SPIN, INERTIA, ACROSS, pitch[0]) == pytest.approx(LEVEL, rel=1e-15)


def test_there_is_no_real_root_with_the_rod_up_and_the_spin_low() -> None:
    pitch = math.radians(60)
    roots = np.roots([(INERTIA - ACROSS) * math.sin(pitch), INERTIA * 30 * RPM, -TORQUE])
    assert np.iscomplex(roots).all(), "numbers all the same, for who takes their real part"
    least = physics.least_spin(TORQUE, INERTIA, ACROSS, pitch)
    assert np.isnan(physics.precession_rate(TORQUE, 30 * RPM, INERTIA, ACROSS, pitch))
    assert 30 * RPM < least < 70 * RPM
    assert np.isfinite(physics.precession_rate(TORQUE, 1.000001 * least, INERTIA, ACROSS, pitch))


@pytest.mark.parametrize("beyond", [1e-10, 1e-12, 1e-14])
def test_eigenvalues_lose_half_the_digits_at_the_double_root(beyond: float) -> None:
    pitch = math.radians(60)
    spin = float(physics.least_spin(TORQUE, INERTIA, ACROSS, pitch)) * (1 + beyond)
    coefficients = ((INERTIA - ACROSS) * math.sin(pitch), INERTIA * spin, -TORQUE)
    with localcontext() as context:
        context.prec = 50
        a, b, c = (Decimal(float(value)) for value in coefficients)
        root = b * b - 4 * a * c
        assert root > 0
        true = float(-2 * c / (b + root.sqrt()))
    found = np.roots(coefficients)
    nearest = found[np.argmin(np.abs(found - true))]
    held = float(physics.precession_rate(TORQUE, spin, INERTIA, ACROSS, pitch))
    # D is a difference of equal numbers, so that the rate is good to ε/√x at x beyond the double root, and no better.
    assert abs(held / true - 1) < 4e-16 / math.sqrt(beyond)
    assert abs(nearest / true - 1) < 1e-6
    assert abs(held / true - 1) <= abs(nearest / true - 1) + 4e-16 / math.sqrt(beyond)


def test_eq_9_fails_for_a_tilted_rod_and_so_does_the_cosine_of_its_pitch() -> None:
    pitch, spin = math.radians(45), 100 * RPM
    rate = physics.precession_rate(TORQUE, spin, INERTIA, ACROSS, pitch)
    plain = TORQUE / (rate * spin)
    mistaken = TORQUE * math.cos(pitch) / (rate * spin)
    assert plain / INERTIA - 1 == pytest.approx(-0.08, abs=0.02)
    assert mistaken / INERTIA - 1 == pytest.approx(-0.35, abs=0.02)
    corrected = plain / (1 + physics.tilt_bias(rate, spin, pitch, INERTIA, ACROSS))
    assert corrected == pytest.approx(INERTIA, rel=1e-14)


def test_the_log_mean_of_equal_spins_is_0_by_0() -> None:
    def naive(start: float, end: float) -> float:
        # G²/L, the harmonic mean in time of a viscous fall, as it is written down.
        return float(start * end * np.log(np.float64(start) / end) / (np.float64(start) - end))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert np.isnan(naive(SPIN, SPIN))
    near = SPIN * (1 - 1e-13)
    assert abs(naive(SPIN, near) / SPIN - 1) > 1e-5
    assert physics.harmonic_mean_spin(SPIN, SPIN) == SPIN
    assert physics.harmonic_mean_spin(SPIN, near) == pytest.approx(SPIN, rel=2e-13)


def test_the_plain_mean_of_a_spin_that_halves_is_8_percent_off() -> None:
    harmonic = physics.harmonic_mean_spin(SPIN, SPIN / 2)
    assert 0.75 * SPIN / harmonic - 1 == pytest.approx(0.082, abs=0.001)
    # One over the spin, averaged over a viscous fall in a million steps.
    times = (np.arange(1_000_000) + 0.5) / 1_000_000
    assert harmonic == pytest.approx(1 / np.mean(1 / (SPIN * 0.5**times)), rel=1e-10)
