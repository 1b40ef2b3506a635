"""The upright rod and small nutations against the equations of motion, linearised."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from gyrodata import physics

INERTIA, TRANSVERSE, TORQUE = 4.44e-3, 5.74e-3, 0.0588
RPM = math.pi / 30


def test_sleeping_spins_of_the_lab() -> None:
    torque = physics.torque(np.array([0.02, 0.04, 0.06]), 0.15, 9.8031)
    np.testing.assert_allclose(physics.sleeping_spin(torque, INERTIA, TRANSVERSE) / RPM, [56, 79, 97], atol=0.5)
    assert physics.sleeping_spin(-TORQUE, INERTIA, TRANSVERSE) == 0
    # 40 g, the weight in I, 5 % below: 0.93 in a second.
    across = 1.494 * INERTIA
    total = 0.95 * physics.sleeping_spin(TORQUE, INERTIA, across)
    assert physics.sleeping_growth(TORQUE, total, INERTIA, across) == pytest.approx(0.93, abs=0.005)


@pytest.mark.parametrize("part", [0.0, 0.5, 0.95, 1.05, 3.0])
def test_growth_is_the_exponent_of_the_linearised_motion(part: float) -> None:
    # Near the vertical z = e3x + i e3y obeys I z'' − i I_zz ω3 z' − h m g z = 0.
    total = part * physics.sleeping_spin(TORQUE, INERTIA, TRANSVERSE)
    exponents = np.roots([TRANSVERSE, -1j * INERTIA * total, -TORQUE])
    growth = physics.sleeping_growth(TORQUE, total, INERTIA, TRANSVERSE)
    assert growth == pytest.approx(max(exponents.real), abs=1e-9)
    assert (growth > 0) == (part < 1)


def falling(theta: mpmath.mpf, vertical: mpmath.mpf, own: mpmath.mpf) -> mpmath.mpf:
    """θ̈ by eq. (7a), with H·Z and H·e3 conserved."""
    cos, sin = mpmath.cos(theta), mpmath.sin(theta)
    rate = (vertical - own * cos) / (TRANSVERSE * sin**2)
    return (TORQUE - own * rate + TRANSVERSE * rate**2 * cos) * sin / TRANSVERSE


@pytest.mark.parametrize(("pitch", "rpm"), [(0.0, 400), (0.0, 100), (30.0, 200), (-40.0, 60), (60.0, 120), (-20.0, 0)])
def test_nutation_rate_is_that_of_the_linearised_motion(pitch: float, rpm: float) -> None:
    angle, spin = math.radians(pitch), rpm * RPM
    rate = physics.precession_rate(TORQUE, spin, INERTIA, TRANSVERSE, angle)
    total = spin + rate * math.sin(angle)
    theta = mpmath.pi / 2 - mpmath.mpf(angle)
    own = mpmath.mpf(INERTIA) * total
    vertical = own * mpmath.cos(theta) + TRANSVERSE * rate * mpmath.sin(theta) ** 2
    assert abs(falling(theta, vertical, own)) < 1e-12  # steady
    stiffness = -mpmath.diff(lambda angle: falling(angle, vertical, own), theta)
    found = physics.nutation_rate(total, INERTIA, TRANSVERSE, rate, angle)
    assert found == pytest.approx(float(mpmath.sqrt(stiffness)), rel=1e-9)
