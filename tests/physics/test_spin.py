"""Means of a falling spin against the integral of the drag law, and in digits."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from gyrodata import physics
from gyrodata.physics import SpinRule

ENDS = [(70.0, 63.0), (70.0, 35.0), (40.0, 40.0), (40.0, 39.9999), (30.0, 31.0), (-70.0, -50.0)]
EXPONENTS = [-1.0, 0.0, 0.5, 1.0, 1.5, 2.0]


def spin_at(share: mpmath.mpf, start: float, end: float, exponent: float) -> mpmath.mpf:
    """Spin after a share of the time, by drag of one exponent between start and end; sizes."""
    with mpmath.workdps(40):
        a, b, rest = mpmath.mpf(abs(start)), mpmath.mpf(abs(end)), 1 - mpmath.mpf(exponent)
        if abs(rest) < 1e-12:
            return a * (b / a) ** share
        return (a**rest + share * (b**rest - a**rest)) ** (1 / rest)


def integral(start: float, end: float, exponent: float) -> float:
    """One over the mean in time of 1/spin."""
    inverse = mpmath.quad(lambda share: 1 / spin_at(share, start, end, exponent), [0, 1])
    return math.copysign(float(1 / inverse), start)


@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize(("start", "end"), ENDS)
def test_harmonic_mean_is_the_integral(start: float, end: float, exponent: float) -> None:
    found = physics.harmonic_mean_spin(start, end, exponent)
    assert found == pytest.approx(integral(start, end, exponent), rel=1e-13)


def test_special_cases_of_the_harmonic_mean() -> None:
    a, b = 70.0, 50.0
    geometric, logarithmic = math.sqrt(a * b), (a - b) / math.log(a / b)
    assert physics.harmonic_mean_spin(a, b) == pytest.approx(geometric**2 / logarithmic, rel=1e-15)
    assert physics.harmonic_mean_spin(a, b, 0) == pytest.approx(logarithmic, rel=1e-15)
    assert physics.harmonic_mean_spin(a, b, 0.5) == pytest.approx(geometric, rel=1e-15)
    assert physics.harmonic_mean_spin(a, b, 2) == pytest.approx(2 * a * b / (a + b), rel=1e-15)


@pytest.mark.parametrize("decay", [0.0, 1e-12, 1e-6, 1.99e-4, 2.01e-4, 1e-3])
def test_harmonic_mean_of_a_hardly_falling_spin(decay: float) -> None:
    # (a − b)/ln(a/b) is 0/0 for equal ends; the series takes over smoothly.
    end = 40 * math.exp(-decay)
    with mpmath.workdps(50):
        d = mpmath.log(mpmath.mpf(40.0) / mpmath.mpf(end))
        exact = mpmath.mpf(1) if d == 0 else d / mpmath.expm1(d)
    assert physics.harmonic_mean_spin(40.0, end) == pytest.approx(float(40 * exact), rel=4e-16)


@pytest.mark.parametrize(("start", "end"), [(70.0, 63.0), (70.0, 35.0), (40.0, 40.0), (40.0, 39.98), (30.0, 31.0)])
def test_slopes_of_the_harmonic_mean(start: float, end: float) -> None:
    to_start, to_end = physics.harmonic_mean_spin_slopes(start, end)
    assert float(mpmath.diff(lambda s: s * mean_factor(s, end), start)) == pytest.approx(to_start, rel=1e-6)
    assert start * to_start + end * to_end == pytest.approx(physics.harmonic_mean_spin(start, end), rel=1e-12)


def mean_factor(start: float, end: float) -> mpmath.mpf:
    decay = mpmath.log(mpmath.mpf(start) / end)
    return mpmath.mpf(1) if decay == 0 else decay / mpmath.expm1(decay)


# Bias of I_zz in % for drops of 10, 30 and 50 %.
TABLE: dict[tuple[SpinRule, float], tuple[float, float, float]] = {
    ("half_time", 0): (-0.09, -1.05, -3.8),
    ("half_time", 1): (-0.05, -0.53, -2.0),
    ("arithmetic", 0): (-0.09, -1.05, -3.8),
    ("arithmetic", 1): (-0.18, -2.1, -7.6),
    ("geometric", 0): (0.05, 0.53, 2.0),
    ("geometric", 1): (-0.05, -0.53, -2.0),
    ("logarithmic", 0): (0, 0, 0),
    ("logarithmic", 1): (-0.09, -1.05, -3.9),
    ("viscous", 0): (0.09, 1.06, 4.1),
    ("viscous", 1): (0, 0, 0),
    ("start", 0): (-5, -16, -28),
    ("start", 1): (-5, -17, -31),
}


@pytest.mark.parametrize(("rule", "exponent"), TABLE)
def test_bias_of_each_rule_in_digits(rule: SpinRule, exponent: float) -> None:
    found = 100 * physics.mean_spin_bias(100.0, np.array([90.0, 70.0, 50.0]), rule, exponent)
    for value, digits in zip(found, TABLE[rule, exponent], strict=True):
        shown = f"{abs(digits):g}".partition(".")[2]
        assert abs(value - digits) <= 0.56 * 10.0 ** -len(shown) if digits else abs(value) < 1e-13


@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize(("start", "end"), ENDS)
def test_bias_of_each_rule_against_the_integral(start: float, end: float, exponent: float) -> None:
    decay = math.log(start / end)
    mean = math.copysign(math.sqrt(start * end), start)
    used = {
        "start": start,
        "half_time": math.copysign(float(spin_at(mpmath.mpf(0.5), start, end, exponent)), start),
        "arithmetic": (start + end) / 2,
        "geometric": mean,
        "logarithmic": (start - end) / decay if decay else start,
        "viscous": mean**2 * decay / (start - end) if decay else start,
    }
    for rule, spin in used.items():
        expected = integral(start, end, exponent) / spin - 1
        assert physics.mean_spin_bias(start, end, rule, exponent) == pytest.approx(expected, abs=3e-10)  # type: ignore[arg-type]


def test_the_arithmetic_mean_is_high_by_the_known_amount() -> None:
    # A drop of 30 %: −2.1 % in I_zz.
    assert physics.mean_spin_bias(100.0, 70.0, "arithmetic") == pytest.approx(-0.021, abs=2e-4)
    assert physics.decay_law_doubt(100.0, 70.0) == pytest.approx(-(np.log(0.7) ** 2) / 12, rel=0.01)


def test_the_geometric_mean_is_half_way_between_dry_and_viscous() -> None:
    dry, viscous = (physics.mean_spin_bias(100.0, 90.0, "geometric", p) for p in (0, 1))
    assert dry == pytest.approx(-viscous, rel=1e-3)
    assert dry == pytest.approx(math.log(100 / 90) ** 2 / 24, rel=1e-3)


@pytest.mark.parametrize("fall", [1e-9, 0.1, 0.5])
def test_simpson_needs_no_law_and_bears_noise(fall: float) -> None:
    start, end = 70.0, 70.0 * (1 - fall)
    half = math.sqrt(start * end)  # of a viscous fall
    true = physics.harmonic_mean_spin(start, end)
    decay = math.log(start / end)
    assert physics.simpson_mean_spin(start, half, end) == pytest.approx(true, rel=1e-12 + decay**4 / 2000)
    # A reading at half time above the first leaves the exponent of the law without an answer, not this.
    assert physics.simpson_mean_spin(start, 1.002 * start, end) == pytest.approx(true, rel=0.004 + fall)
