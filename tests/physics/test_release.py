"""The motion of a released rod, and an integrator at its tightest, against Taylor
series with more digits.
"""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import product
from operator import mul

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gyrodata import physics
from gyrodata.physics import motion
from gyrodata.physics.motion import (
    State,
    Top,
    integrate,
    mean_precession_rate,
    nutation,
    released,
    steady,
    time_to_turn,
)

INERTIA, TRANSVERSE, TORQUE = 4.44e-3, 6.6156e-3, 0.0588
RPM = np.pi / 30
TOP = Top(inertia=INERTIA, transverse_inertia=TRANSVERSE, torque=TORQUE)


BITS, ORDER = 150, 44
Vector = list[int]


def fixed(value: Fraction | float) -> int:
    return round(Fraction(value) * (1 << BITS))


def taylor(
    transverse: float,
    torque: float,
    axis: NDArray[np.float64],
    momentum: NDArray[np.float64],
    time: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """e3 and H after a time, to more digits than a float has, by Taylor series in whole
    numbers.

    ė3 = (H × e3)/I and Ḣ = M Z × e3 are products of two unknowns at most, so each
    coefficient of the series follows from the earlier ones. No angles, energies or
    elliptic functions are used."""
    rate = float(np.linalg.norm(momentum)) / transverse + 4 * float(
        np.sqrt(abs(torque) / transverse)
    )
    steps = max(1, int(np.ceil(rate * abs(time))))
    step = fixed(Fraction(time) / steps)
    gravity = fixed(Fraction(torque) / Fraction(transverse)) * step >> BITS
    e = [fixed(float(component)) for component in axis]
    h = [
        fixed(Fraction(float(component)) / Fraction(transverse))
        for component in momentum
    ]
    for _ in range(steps):
        e, h = one_step(e, h, step, gravity)
    scale = 1 << BITS
    return (
        np.array([float(Fraction(component, scale)) for component in e]),
        np.array(
            [
                float(Fraction(component, scale) * Fraction(transverse))
                for component in h
            ]
        ),
    )


def one_step(e: Vector, h: Vector, step: int, gravity: int) -> tuple[Vector, Vector]:
    x, y, z = [e[0]], [e[1]], [e[2]]
    hx, hy = [h[0]], [h[1]]
    for k in range(ORDER):
        # The vertical part of H never changes.
        turned_x = sum(map(mul, hy, reversed(z))) - h[2] * y[k]
        turned_y = h[2] * x[k] - sum(map(mul, hx, reversed(z)))
        turned_z = sum(map(mul, hx, reversed(y))) - sum(map(mul, hy, reversed(x)))
        hx.append((-gravity * y[k] >> BITS) // (k + 1))
        hy.append((gravity * x[k] >> BITS) // (k + 1))
        x.append((turned_x >> BITS) * step // (k + 1) >> BITS)
        y.append((turned_y >> BITS) * step // (k + 1) >> BITS)
        z.append((turned_z >> BITS) * step // (k + 1) >> BITS)
    return [sum(x), sum(y), sum(z)], [sum(hx), sum(hy), h[2]]


def after(top: Top, state: State, time: float) -> State:
    """The state after a time, by the series."""
    return State(
        *taylor(
            float(top.transverse_inertia),
            float(top.torque),
            state.axis,
            state.momentum,
            time,
        )
    )


def azimuth(state: State) -> float:
    return math.atan2(state.axis[1], state.axis[0])


CASES = [
    (TORQUE, 200 * RPM, -0.7),
    (TORQUE, 50 * RPM, 0.5),
    (-TORQUE, 400 * RPM, 0.2),
    (TORQUE, -600 * RPM, 0.0),
    (TORQUE, 40 * RPM, math.pi / 2 - 1e-3),
    (-TORQUE, 4 * RPM, 0.3),
    (TORQUE, 100 * RPM, -1.5),
    (1e-6, 300 * RPM, 0.4),
]


@pytest.mark.slow
@pytest.mark.parametrize(("torque", "spin", "pitch"), CASES)
def test_a_nutation_agrees_with_the_series(
    torque: float, spin: float, pitch: float
) -> None:
    top = Top(inertia=INERTIA, transverse_inertia=TRANSVERSE, torque=torque)
    state, nod = released(top, spin, pitch), nutation(top, spin, pitch)
    half, whole = (after(top, state, part * nod.period) for part in (0.5, 1.0))
    assert math.asin(half.axis[2]) == pytest.approx(pitch - nod.greatest_sag, abs=1e-12)
    assert whole.axis[2] == pytest.approx(math.sin(pitch), abs=1e-12)
    swept = mean_precession_rate(top, spin, pitch) * nod.period
    for part, end in ((0.5, half), (1.0, whole)):
        assert math.remainder(
            part * swept - azimuth(end), 2 * math.pi
        ) == pytest.approx(0, abs=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize(("torque", "spin", "pitch"), CASES[:-1])
def test_the_time_of_an_angle_agrees_with_the_series(
    torque: float, spin: float, pitch: float
) -> None:
    top = Top(inertia=INERTIA, transverse_inertia=TRANSVERSE, torque=torque)
    sense = math.copysign(1.0, torque * spin)
    angles = sense * np.array([1e-3, 3.0])
    times = time_to_turn(top, spin, pitch, angles)
    assert (np.diff(times) > 0).all()
    for angle, time in zip(angles, times, strict=True):
        assert azimuth(
            after(top, released(top, spin, pitch), float(time))
        ) == pytest.approx(angle, abs=1e-10)
    twice = float(
        np.diff(
            time_to_turn(top, spin, pitch, sense * 2 * math.pi * np.array([10.0, 30.0]))
        )[0]
    )
    assert twice == pytest.approx(
        40 * math.pi / abs(mean_precession_rate(top, spin, pitch)), rel=0.2
    )


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(
    *(st.floats(*ends) for ends in ((-70, 70), (-1.5, 1.5), (-0.2, 0.2), (0.01, 40.0)))
)
def test_the_time_of_a_turn_of_any_rod_is_finite(
    spin: float, pitch: float, torque: float, angle: float
) -> None:
    top = Top(inertia=INERTIA, transverse_inertia=TRANSVERSE, torque=torque)
    time, never = (
        float(time_to_turn(top, spin, pitch, sense * angle))
        for sense in (spin * torque, -spin * torque)
    )
    if abs(spin) > 1 and abs(torque) > 1e-3:
        assert (
            0
            < float(time_to_turn(top, spin, pitch, math.copysign(angle, spin * torque)))
            < 1e6
        )
        assert never == np.inf
    assert not math.isnan(time)


def test_a_turn_that_never_comes_takes_for_ever() -> None:
    assert list(time_to_turn(TOP, 300 * RPM, 0.0, [-0.5, 0.0])) == [np.inf, 0]
    assert (
        time_to_turn(
            Top(inertia=INERTIA, transverse_inertia=TRANSVERSE, torque=0.0),
            300 * RPM,
            0.0,
            1.0,
        )
        == np.inf
    )
    assert (
        mean_precession_rate(
            Top(inertia=INERTIA, transverse_inertia=TRANSVERSE, torque=0.0), 300 * RPM
        )
        == 0
    )


def test_tachometer_that_follows_a_released_rod_reads_more_than_the_total_spin() -> (
    None
):
    for spin, rel in ((200 * RPM, 0.06), (100 * RPM, 0.25)):
        total, sag = (
            float(motion.total_spin(TOP, spin)),
            TRANSVERSE * TORQUE / (INERTIA * spin) ** 2,
        )
        assert total - float(motion.spin_excess(TOP, total)) == pytest.approx(
            spin, rel=1e-6
        )
        # To second order the mean of φ̇ cosθ is −3/2 φ̇ δ: rate and sag grow together.
        assert 1 - total / spin == pytest.approx(
            1.5 * sag**2 * INERTIA / TRANSVERSE, rel=rel
        )


def test_published_bias_of_a_released_rod() -> None:
    # By elliptic integrals: 0.08827 % at 20 g and 1.014 % at 60 g, 200 rpm, k = 1.39
    # and 1.60, m g x for 150 mm.
    for mass, ratio, percent in ((0.02, 1.39, 0.08827), (0.06, 1.60, 1.014)):
        torque = mass * 9.8031 * 0.15
        rate = mean_precession_rate(
            Top(inertia=INERTIA, transverse_inertia=ratio * INERTIA, torque=torque),
            200 * RPM,
        )
        assert 100 * (torque / (rate * 200 * RPM * INERTIA) - 1) == pytest.approx(
            percent, rel=0.02
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pitch", "spin"), product([-50.0, 0.0, 25.0], [400 * RPM, -400 * RPM])
)
def test_steady_precession_stays_steady(pitch: float, spin: float) -> None:
    angle, time = np.radians(pitch), 2.0
    rate = physics.precession_rate(TORQUE, spin, INERTIA, TRANSVERSE, angle)
    end = after(TOP, steady(TOP, spin, angle), time)
    assert end.axis[2] == pytest.approx(np.sin(angle), abs=1e-14)
    assert math.remainder(azimuth(end) - rate * time, 2 * math.pi) == pytest.approx(
        0, abs=1e-12
    )
    # ψ̇ = ω3 − φ̇ cosθ, eq. (2).
    assert end.axis @ end.momentum / INERTIA - rate * np.sin(angle) == pytest.approx(
        spin, rel=1e-13
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "state",
    [
        released(TOP, 600 * RPM, 0.1),
        State(np.array([0.6, 0.0, 0.8]), np.array([0.02 / 3 + 2e-4, 0.04, 0.02])),
        State(np.array([0.6, 0.0, -0.8]), np.array([0.02, 0.04, 0.3])),
    ],
)
def test_an_integrator_at_its_tightest_agrees_with_the_series(state: State) -> None:
    found, _ = integrate(TOP, state, [0.0, 1.0, 4.0], rtol=1e-13, atol=1e-15)
    for i, time in enumerate((0.0, 1.0, 4.0)):
        assert found.axis[i] == pytest.approx(after(TOP, state, time).axis, abs=1e-10)


def test_impossible_tops_are_refused() -> None:
    for inertia, transverse_inertia, torque in (
        (0.0, 1.0, 1.0),
        (1.0, -1.0, 1.0),
        (1.0, 1.0, np.nan),
        (np.array([1.0, -1.0]), 1.0, 1.0),
    ):
        with pytest.raises(
            ValueError, match=r"inertia must be above 0|torque is not a finite number"
        ):
            Top(inertia=inertia, transverse_inertia=transverse_inertia, torque=torque)
