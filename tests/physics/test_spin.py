"""Means of a falling spin against the integral of the drag law, and in digits."""

from __future__ import annotations

import math

import mpmath
import pytest

from gyrodata import physics

ENDS = [
    (70.0, 63.0),
    (70.0, 35.0),
    (40.0, 40.0),
    (40.0, 39.9999),
    (30.0, 31.0),
    (-70.0, -50.0),
]
EXPONENTS = [-1.0, 0.0, 0.5, 1.0, 1.5, 2.0]


def spin_at(share: mpmath.mpf, start: float, end: float, exponent: float) -> mpmath.mpf:
    """Spin after a share of the time, by drag of one exponent between start and end;
    sizes.
    """
    with mpmath.workdps(40):
        a, b, rest = (
            mpmath.mpf(abs(start)),
            mpmath.mpf(abs(end)),
            1 - mpmath.mpf(exponent),
        )
        if abs(rest) < 1e-12:
            return a * (b / a) ** share
        return (a**rest + share * (b**rest - a**rest)) ** (1 / rest)


def integral(start: float, end: float, exponent: float) -> float:
    """One over the mean in time of 1/spin."""
    inverse = mpmath.quad(
        lambda share: 1 / spin_at(share, start, end, exponent), [0, 1]
    )
    return math.copysign(float(1 / inverse), start)


@pytest.mark.slow
@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize(("start", "end"), ENDS)
def test_harmonic_mean_is_the_integral(
    start: float, end: float, exponent: float
) -> None:
    found = physics.harmonic_mean_spin(start, end, exponent)
    assert found == pytest.approx(integral(start, end, exponent), rel=1e-13)


@pytest.mark.parametrize("decay", [0.0, 1e-12, 1e-6, 1.99e-4, 2.01e-4, 1e-3])
def test_harmonic_mean_of_a_hardly_falling_spin(decay: float) -> None:
    # (a − b)/ln(a/b) is 0/0 for equal ends; the series takes over smoothly.
    end = 40 * math.exp(-decay)
    with mpmath.workdps(50):
        d = mpmath.log(mpmath.mpf(40.0) / mpmath.mpf(end))
        exact = mpmath.mpf(1) if d == 0 else d / mpmath.expm1(d)
    assert physics.harmonic_mean_spin(40.0, end) == pytest.approx(
        float(40 * exact), rel=4e-16
    )


def test_dry_friction_for_a_viscous_fall() -> None:
    dry, viscous = integral(100.0, 70.0, 0.0), integral(100.0, 70.0, 1.0)
    assert physics.decay_law_doubt(100.0, 70.0) == pytest.approx(
        viscous / dry - 1, rel=1e-10
    )
    assert physics.decay_law_doubt(100.0, 70.0) == pytest.approx(
        -(math.log(0.7) ** 2) / 12, rel=0.01
    )


@pytest.mark.parametrize("fall", [1e-9, 0.1, 0.5])
def test_simpson_needs_no_law_and_bears_noise(fall: float) -> None:
    start, end = 70.0, 70.0 * (1 - fall)
    half = math.sqrt(start * end)  # of a viscous fall
    true = physics.harmonic_mean_spin(start, end)
    decay = math.log(start / end)
    assert physics.simpson_mean_spin(start, half, end) == pytest.approx(
        true, rel=1e-12 + decay**4 / 2000
    )
    # A reading at half time above the first leaves the exponent of the law without an
    # answer, not this.
    assert physics.simpson_mean_spin(start, 1.002 * start, end) == pytest.approx(
        true, rel=0.004 + fall
    )


@pytest.mark.parametrize("fall", [0.0, 1e-4, -5e-4, 0.02, 0.5])
def test_shares_are_derivatives_of_the_mean(fall: float) -> None:
    start, end, step = 40.0, 40.0 * math.exp(-fall), 1e-4
    mean, share = (
        physics.harmonic_mean_spin,
        physics.harmonic_mean_spin_share(start, end),
    )
    by_start = (mean(start + step, end) - mean(start - step, end)) / (2 * step)
    by_end = (mean(start, end + step) - mean(start, end - step)) / (2 * step)
    found = [float(share / start), float((1 - share) / end)]
    assert [mean(start, end) * one for one in found] == pytest.approx(
        [by_start, by_end], rel=1e-8
    )


@pytest.mark.parametrize("pitch", [0.0, 0.4, -0.5])
def test_the_spin_of_a_sag_is_the_spin_that_sags_so(pitch: float) -> None:
    spin = physics.spin_of_sag(0.3, 0.06, 4.4e-3, 7.1e-3, pitch)
    assert float(physics.sag_size(0.06, spin, 4.4e-3, 7.1e-3, pitch)) == pytest.approx(
        0.3, rel=1e-9
    )
