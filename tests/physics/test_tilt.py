"""What a tilt does to I_zz, against the answer worked out from the exact root of eq.
(8), and in digits.
"""

from __future__ import annotations

import math
from itertools import product

import mpmath
import pytest
from biases import tilt_bias

from gyrodata import physics

INERTIA, RATIO = 4.44e-3, 1.594
TRANSVERSE = RATIO * INERTIA
TORQUE = 0.06 * 9.8031 * 0.15
RPM = math.pi / 30


def steady(pitch: float, spin: float, torque: float) -> mpmath.mpf:
    """Slow root of eq. (8) in 50 digits."""
    with mpmath.workdps(50):
        a = (mpmath.mpf(INERTIA) - mpmath.mpf(TRANSVERSE)) * mpmath.sin(
            mpmath.radians(pitch)
        )
        b = mpmath.mpf(INERTIA) * spin
        root = mpmath.sqrt(b * b + 4 * a * mpmath.mpf(torque))
        return 2 * mpmath.mpf(torque) / (b + root * mpmath.sign(b))


def test_tilt_left_out() -> None:
    for pitch, spin, torque in product(
        (-30.0, -5.0, 0.1, 10.0, 40.0), (40.0, -40.0), (TORQUE, -TORQUE)
    ):
        rate = steady(pitch, spin, torque)
        bias = tilt_bias(float(rate), spin, math.radians(pitch), INERTIA, TRANSVERSE)
        assert bias == pytest.approx(
            float(mpmath.mpf(torque) / (rate * spin) / INERTIA - 1), rel=1e-12
        )


@pytest.mark.parametrize(
    ("rpm", "pitch", "percent", "digit"),
    [(200, 2, -0.09, 2), (200, 30, -1.4, 1), (50, 10, -8.1, 1), (50, 30, -31, 0)],
)
def test_tilt_left_out_in_digits(
    rpm: float, pitch: float, percent: float, digit: int
) -> None:
    spin, angle = rpm * RPM, math.radians(pitch)
    rate = physics.precession_rate(TORQUE, spin, INERTIA, TRANSVERSE, angle)
    assert (
        round(100 * tilt_bias(rate, spin, angle, INERTIA, TRANSVERSE), digit) == percent
    )


def test_total_spin_in_digits() -> None:
    # 60 g, 200 rpm, 10°: eq. (9) with the total spin.
    spin, angle = 200 * RPM, math.radians(10)
    rate = physics.precession_rate(TORQUE, spin, INERTIA, TRANSVERSE, angle)
    bias = TORQUE / (rate * (spin + rate * math.sin(angle))) / INERTIA - 1
    assert 100 * bias == pytest.approx(-1.25, abs=0.01)
