"""The closed forms against exact arithmetic, numerical integrals and each other."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from gyrodata import physics

INERTIA, TRANSVERSE, TORQUE, SPIN = 4.44e-3, 5.7e-3, 0.0588, 40.0


def slow_root(pitch_sine: float) -> mpmath.mpf:
    """Eq. (8) to 50 digits."""
    with mpmath.workdps(50):
        a = (mpmath.mpf(INERTIA) - mpmath.mpf(TRANSVERSE)) * mpmath.mpf(pitch_sine)
        b = mpmath.mpf(INERTIA) * mpmath.mpf(SPIN)
        return 2 * mpmath.mpf(TORQUE) / (b + mpmath.sqrt(b * b + 4 * a * mpmath.mpf(TORQUE)))


@pytest.mark.parametrize("sine", [0.9, 0.5, 1e-2, 1e-4, 1e-8, 1e-12, 1e-16, 0.0, -0.3])
def test_steady_precession_to_the_last_digit(sine: float) -> None:
    pitch = np.arcsin(sine)
    rate = physics.precession_rate(TORQUE, SPIN, INERTIA, TRANSVERSE, pitch)
    assert abs(rate / float(slow_root(float(np.sin(pitch)))) - 1) < 1e-14


def test_the_textbook_formula_fails_where_the_stable_one_holds() -> None:
    lean = (INERTIA - TRANSVERSE) * np.cos(np.pi / 2)
    momentum = INERTIA * SPIN
    textbook = (-momentum + np.sqrt(momentum**2 + 4 * lean * TORQUE)) / (2 * lean)
    assert textbook == 0  # all digits lost
    rate = physics.precession_rate(TORQUE, SPIN, INERTIA, TRANSVERSE, np.pi / 2 - np.pi / 2)
    assert rate == pytest.approx(TORQUE / momentum, rel=1e-15)


def test_horizontal_is_equation_nine_with_signs() -> None:
    for torque, spin in ((TORQUE, SPIN), (-TORQUE, SPIN), (TORQUE, -SPIN), (0.0, SPIN)):
        assert physics.precession_rate(torque, spin, INERTIA) == pytest.approx(torque / (INERTIA * spin), rel=1e-15)


def test_no_steady_precession_is_not_a_number() -> None:
    assert np.isnan(physics.precession_rate(0.09, 2.0, INERTIA, 0.02, np.radians(60)))


@pytest.mark.parametrize("pitch", [-30.0, -5.0, 10.0, 40.0])
def test_tilt_bias_is_exact(pitch: float) -> None:
    angle = np.radians(pitch)
    rate = physics.precession_rate(TORQUE, SPIN, INERTIA, TRANSVERSE, angle)
    by_nine = TORQUE / (rate * SPIN)
    bias = physics.tilt_bias(rate, SPIN, angle, INERTIA, TRANSVERSE)
    assert by_nine / INERTIA - 1 == pytest.approx(bias, rel=1e-12)


@pytest.mark.parametrize(("start", "end"), [(70.0, 63.0), (70.0, 35.0), (40.0, 40.0), (40.0, 39.9999), (30.0, 31.0)])
def test_harmonic_mean_is_the_integral(start: float, end: float) -> None:
    # ψ̇ falls exponentially; the mean is one over the mean of 1/ψ̇ over the time.
    decay = mpmath.log(mpmath.mpf(start) / end)
    mean_inverse = mpmath.quad(lambda s: mpmath.exp(decay * s) / start, [0, 1])
    assert physics.harmonic_mean_spin(start, end) == pytest.approx(float(1 / mean_inverse), rel=1e-13)


@pytest.mark.parametrize(("start", "end"), [(70.0, 63.0), (70.0, 35.0), (40.0, 40.0), (40.0, 39.98), (30.0, 31.0)])
def test_slopes_of_the_harmonic_mean(start: float, end: float) -> None:
    to_start, to_end = physics.harmonic_mean_spin_slopes(start, end)
    assert float(mpmath.diff(lambda s: s * mean_factor(s, end), start)) == pytest.approx(to_start, rel=1e-6)
    assert start * to_start + end * to_end == pytest.approx(physics.harmonic_mean_spin(start, end), rel=1e-12)


def mean_factor(start: float, end: float) -> mpmath.mpf:
    decay = mpmath.log(mpmath.mpf(start) / end)
    return mpmath.mpf(1) if decay == 0 else decay / mpmath.expm1(decay)


def test_the_arithmetic_mean_is_high_by_the_known_amount() -> None:
    # A drop of 30 %: −2.1 % in I_zz.
    assert physics.arithmetic_mean_bias(100.0, 70.0) == pytest.approx(-0.021, abs=2e-4)
    assert physics.decay_law_doubt(100.0, 70.0) == pytest.approx(-(np.log(0.7) ** 2) / 12, rel=0.01)


def test_a_four_inch_steel_ball() -> None:
    assert physics.solid_ball_inertia(4.30, 0.1016) == pytest.approx(4.44e-3, rel=2e-3)


def test_release_from_rest() -> None:
    # 20 g at 200 rpm: mean rate 0.0885 % high.
    bias = physics.release_bias(0.0294, 200 * np.pi / 30, INERTIA, 1.39 * INERTIA)
    assert bias == pytest.approx(8.85e-4, rel=0.02)
