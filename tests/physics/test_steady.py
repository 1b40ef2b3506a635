"""Both roots of eq. (8) against 250 digits, the upright rod against the linearised
motion.
"""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gyrodata import physics

INERTIA, TRANSVERSE, TORQUE, SPIN = 4.44e-3, 5.74e-3, 0.0588, 40.0
RPM = math.pi / 30
EPSILON = np.finfo(float).eps


def exact_roots(
    torque: float, spin: float, inertia: float, transverse: float, pitch: float
) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Slow and fast root of eq. (8) by the plain formula, in digits enough for what it
    loses.
    """
    with mpmath.workdps(250):
        a = (mpmath.mpf(inertia) - mpmath.mpf(transverse)) * mpmath.sin(
            mpmath.mpf(pitch)
        )
        b, c = mpmath.mpf(inertia) * mpmath.mpf(spin), -mpmath.mpf(torque)
        if a == 0:
            return -c / b, mpmath.inf
        root = mpmath.sqrt(b * b - 4 * a * c)
        both = sorted(((-b + root) / (2 * a), (-b - root) / (2 * a)), key=abs)
        return both[0], both[1]


sizes = st.floats(-3, 3).map(lambda x: 10.0**x)
signs = st.sampled_from([1.0, -1.0])


@pytest.mark.slow
@given(sizes, sizes, sizes, signs, signs, st.floats(-1.5, 1.5))
def test_any_top_to_what_its_condition_allows(
    scale: float, shape: float, load: float, side: float, sense: float, pitch: float
) -> None:
    inertia, spin = 1e-3 * scale, 30.0 * sense
    transverse, torque = inertia * (0.5 + shape), side * load * inertia
    pitch = pitch if abs(pitch) > 1e-100 else 0.0
    numbers = torque, spin, inertia, transverse, pitch
    a = (inertia - transverse) * math.sin(pitch)
    b = inertia * spin
    root = b * b + 4 * a * torque
    slow = physics.precession_rate(*numbers)
    if abs(root) < 1e-13 * b * b:
        return  # both answers are right
    if root < 0:
        assert np.isnan(slow)
        assert np.isnan(physics.fast_precession_rate(*numbers))
        return
    spread = (b * b + 4 * abs(a * torque)) / (
        2 * math.sqrt(root) * (abs(b) + math.sqrt(root))
    )
    expected, fast = exact_roots(*numbers)
    assert abs(slow / expected - 1) <= 8 * EPSILON * (1 + spread)
    if a != 0:
        found = physics.fast_precession_rate(*numbers)
        # I − I_zz has a condition of its own.
        difference = (inertia + transverse) / abs(inertia - transverse)
        assert abs(found / fast - 1) <= 8 * EPSILON * (1 + spread) * (1 + difference)


def test_without_a_torque_the_fast_root_is_free_precession() -> None:
    # The body turns about its angular momentum at H/I, with H cosθ = I_zz ω3.
    pitch, total = 0.5, 40.0
    spin = total * (1 - INERTIA / TRANSVERSE)
    rate = physics.fast_precession_rate(0.0, spin, INERTIA, TRANSVERSE, pitch)
    assert rate == pytest.approx(
        INERTIA * total / (TRANSVERSE * math.sin(pitch)), rel=1e-14
    )


def test_no_steady_precession_is_not_a_number() -> None:
    assert np.isnan(physics.precession_rate(0.09, 2.0, INERTIA, 0.02, np.radians(60)))
    assert np.isnan(
        physics.precession_rate(TORQUE, 0.0, INERTIA, TRANSVERSE, 0.3)
    )  # up, no spin
    assert np.isnan(
        physics.precession_rate(TORQUE, 0.0, INERTIA, TRANSVERSE, 0.0)
    )  # level, no spin
    assert np.isnan(physics.horizontal_precession_rate(TORQUE, 0.0, INERTIA))


def test_the_least_spin_is_where_steady_precession_ends() -> None:
    for pitch in (5.0, 60.0, 89.0):
        top = INERTIA, TRANSVERSE, math.radians(pitch)
        least = physics.least_spin(TORQUE, *top)
        assert np.isfinite(physics.precession_rate(TORQUE, least * (1 + 1e-12), *top))
        assert np.isnan(physics.precession_rate(TORQUE, least * (1 - 1e-12), *top))


def test_the_least_spin_of_the_lab() -> None:
    # 60 g at 150 mm, 60° up: 42.8 rpm, or 61 rpm with the weight in I.
    pitch, torque = math.radians(60), 0.06 * 9.8031 * 0.15
    for across, rpm in ((TRANSVERSE, 42.8), (TRANSVERSE + 0.06 * 0.15**2, 61)):
        assert physics.least_spin(
            torque, INERTIA, across, pitch
        ) / RPM == pytest.approx(rpm, rel=0.005)
    # A rod that hangs or is level, a weight that lifts, a flat body with I < I_zz.
    for numbers in (
        (TORQUE, INERTIA, TRANSVERSE, -0.5),
        (TORQUE, INERTIA, TRANSVERSE, 0.0),
        (-TORQUE, INERTIA, TRANSVERSE, 0.5),
        (TORQUE, TRANSVERSE, INERTIA, 0.5),
    ):
        assert physics.least_spin(*numbers) == 0


def test_sleeping_spins_of_the_lab() -> None:
    torque = physics.torque(np.array([0.02, 0.04, 0.06]), 0.15, 9.8031)
    np.testing.assert_allclose(
        physics.sleeping_spin(torque, INERTIA, TRANSVERSE) / RPM, [56, 79, 97], atol=0.5
    )
    assert physics.sleeping_spin(-TORQUE, INERTIA, TRANSVERSE) == 0
    # 40 g, the weight in I, 5 % below: 0.93 in a second.
    across = 1.494 * INERTIA
    total = 0.95 * physics.sleeping_spin(TORQUE, INERTIA, across)
    assert physics.sleeping_growth(TORQUE, total, INERTIA, across) == pytest.approx(
        0.93, abs=0.005
    )


@pytest.mark.parametrize("part", [0.0, 0.5, 0.95, 1.05, 3.0])
def test_growth_is_the_exponent_of_the_linearised_motion(part: float) -> None:
    # Near the vertical z = e3x + i e3y obeys I z'' − i I_zz ω3 z' − h m g z = 0.
    total = part * physics.sleeping_spin(TORQUE, INERTIA, TRANSVERSE)
    exponents = np.roots([TRANSVERSE, -1j * INERTIA * total, -TORQUE])
    growth = physics.sleeping_growth(TORQUE, total, INERTIA, TRANSVERSE)
    assert growth == pytest.approx(max(exponents.real), abs=1e-9)
    assert (growth > 0) == (part < 1)
