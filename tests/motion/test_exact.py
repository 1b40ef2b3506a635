"""The closed form against longer arithmetic, against integrators, against its own symmetries and limits."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from operator import mul

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from gyrodata import physics
from gyrodata.motion import (
    State,
    Top,
    energy,
    exact,
    integrate,
    mean_precession_rate,
    precession_angle,
    released,
    steady,
    time_to_turn,
)
from gyrodata.motion import nutation as whole_nutation

INERTIA, TRANSVERSE, TORQUE = 4.44e-3, 6.6156e-3, 0.0588
RPM = np.pi / 30
TOP = Top(INERTIA, TRANSVERSE, TORQUE)
HANGING = Top(INERTIA, TRANSVERSE, -TORQUE)
FREE = Top(INERTIA, TRANSVERSE, 0.0)
UPRIGHT = np.array([0.0, 0.0, 1.0])


def moving(theta: float, spin: float, turning: float = 0.0, nodding: float = 0.0, azimuth: float = 0.3) -> State:
    """The state with total spin ω3, φ̇ and θ̇, by eqs. (1) to (3)."""
    axes = physics.frame_axes(azimuth, theta)
    rotation = np.array([nodding, turning * np.sin(theta), spin])
    return State(axes[2], physics.angular_momentum(rotation, INERTIA, TRANSVERSE) @ axes)


def through_pole(side: float, miss: float = 0.0) -> State:
    """A motion that comes to the upper (+1) or lower (−1) vertical, or misses it a little."""
    axis = np.array([0.6, 0.0, 0.8 * side])
    # H·Z = ± H·e3.
    return State(axis, np.array([0.02 / 3 + miss, 0.04, 0.02 * side]))


def climbing(theta: float, spin: float, share: float) -> State:
    """A slow top that rises with H·Z = H·e3 and such a share of the energy that takes it to rest upright."""
    own = INERTIA * spin / TRANSVERSE
    fall = (1 - np.cos(theta)) * (2 * share * TORQUE / TRANSVERSE - own**2 / (1 + np.cos(theta)))
    return moving(theta, spin, own / (1 + np.cos(theta)), -float(np.sqrt(fall)))


BITS, ORDER = 150, 44
Vector = list[int]


def fixed(value: Fraction | float) -> int:
    return round(Fraction(value) * (1 << BITS))


def taylor(
    transverse: float, torque: float, axis: NDArray[np.float64], momentum: NDArray[np.float64], time: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """e3 and H after a time, to more digits than a float has, by Taylor series in whole numbers.

    ė3 = (H × e3)/I and Ḣ = M Z × e3 are products of two unknowns at most, so each coefficient of the series follows
    from the earlier ones. No angles, energies or elliptic functions are used.
    """
    rate = float(np.linalg.norm(momentum)) / transverse + 4 * float(np.sqrt(abs(torque) / transverse))
    steps = max(1, int(np.ceil(rate * abs(time))))
    step = fixed(Fraction(time) / steps)
    gravity = fixed(Fraction(torque) / Fraction(transverse)) * step >> BITS
    e = [fixed(float(component)) for component in axis]
    h = [fixed(Fraction(float(component)) / Fraction(transverse)) for component in momentum]
    for _ in range(steps):
        e, h = one_step(e, h, step, gravity)
    scale = 1 << BITS
    return (
        np.array([float(Fraction(component, scale)) for component in e]),
        np.array([float(Fraction(component, scale) * Fraction(transverse)) for component in h]),
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


def far_from_series(top: Top, state: State, time: float) -> float:
    """Largest error of e3 and of H in parts of its size."""
    axis, momentum = taylor(float(top.transverse_inertia), float(top.torque), state.axis, state.momentum, time)
    found = exact(top, state, time)
    size = max(float(np.linalg.norm(momentum)), 1e-3)
    return max(float(np.abs(found.axis - axis).max()), float(np.abs(found.momentum - momentum).max()) / size)


def test_a_hundred_seconds_at_600_rpm_to_thirteen_digits() -> None:
    # 671 nutations, released from rest; the requirement is 1e-10.
    assert far_from_series(TOP, released(TOP, 600 * RPM), 100.0) < 1e-13


CASES = {
    "released, 200 rpm, rod down": (TOP, released(TOP, 200 * RPM, -0.7), 4.0),
    "released, 50 rpm, rod up: nods by a right angle": (TOP, released(TOP, 50 * RPM, 0.5), 4.0),
    "torque the other way": (HANGING, released(HANGING, 400 * RPM, 0.2), 4.0),
    "no torque": (FREE, moving(1.1, 40.0, 2.0, 1.0), 4.0),
    "loops": (TOP, moving(1.2, 60.0, -3.0, 0.5), 4.0),
    "I below I_zz": (Top(INERTIA, 0.6 * INERTIA, TORQUE), released(TOP, 300 * RPM, 0.3), 4.0),
    "falls from upright but for 1e-6": (TOP, moving(1e-6, 4.0), 3.0),
    "starts upright": (TOP, moving(0.0, 20.0, nodding=3.0), 4.0),
    "passes the vertical": (TOP, through_pole(1.0), 4.0),
    "passes the vertical below, torque the other way": (HANGING, through_pole(1.0, 1e-12), 4.0),
    "pendulum over the top": (TOP, moving(2.5, 0.0, nodding=20.0), 4.0),
    "spherical pendulum": (TOP, moving(2.5, 0.0, 2.0, 1.0), 4.0),
    "pendulum from upright but for 1e-6": (TOP, moving(1e-6, 0.0), 4.0),
    "backwards in time": (TOP, released(TOP, 600 * RPM, 0.2), -4.0),
    "climbs to the upright and stands there for long": (TOP, climbing(1.2, 3.0, 1.0), 1.0),
    "climbs just past the upright, from below": (TOP, climbing(2.3, 2.0, 1 + 1e-5), 1.2),
}


@pytest.mark.parametrize("case", CASES)
def test_hard_motions_to_thirteen_digits(case: str) -> None:
    assert far_from_series(*CASES[case]) < 2e-13


def test_the_series_agrees_with_odefun_of_mpmath() -> None:
    state = moving(1.2, 60.0, -3.0, 0.5)
    transverse, torque = mpmath.mpf(TRANSVERSE), mpmath.mpf(TORQUE)

    def rates(_: mpmath.mpf, y: list[mpmath.mpf]) -> list[mpmath.mpf]:
        e, h = y[:3], y[3:]
        turned = [h[1] * e[2] - h[2] * e[1], h[2] * e[0] - h[0] * e[2], h[0] * e[1] - h[1] * e[0]]
        return [part / transverse for part in turned] + [-torque * e[1], torque * e[0], mpmath.mpf(0)]

    start = [mpmath.mpf(float(part)) for part in (*state.axis, *state.momentum)]
    with mpmath.workdps(20):
        end = mpmath.odefun(rates, 0, start)(0.25)
    axis, momentum = taylor(TRANSVERSE, TORQUE, state.axis, state.momentum, 0.25)
    assert [float(part) for part in end] == pytest.approx([*axis, *momentum], rel=1e-15, abs=1e-17)


def test_against_a_runge_kutta_method_at_its_tightest() -> None:
    state = released(TOP, 600 * RPM, 0.1)
    found = integrate(TOP, state, 10.0, rtol=1e-13, atol=1e-14)
    assert np.abs(found.axis - exact(TOP, state, 10.0).axis).max() < 1e-11


def many(count: int = 200) -> tuple[Top, State]:
    random = np.random.default_rng(5)
    torque = random.choice([-1, 0, 1, 1], count) * 10 ** random.uniform(-3, -0.5, count)
    top = Top(INERTIA, INERTIA * 10 ** random.uniform(-0.4, 0.6, count), torque)
    axis = random.normal(size=(count, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    return top, State(axis, INERTIA * (random.normal(size=(count, 1)) * 40 * axis + random.normal(size=(count, 3)) * 5))


def test_conserved_quantities() -> None:
    top, state = many()
    size = np.linalg.norm(state.momentum, axis=-1) + np.sqrt(top.transverse_inertia * np.abs(top.torque))
    for time in (0.01, 1.0, 100.0):
        later = exact(top, state, time)
        assert np.abs(np.linalg.norm(later.axis, axis=-1) - 1).max() < 1e-14
        assert later.momentum[..., 2] == pytest.approx(state.momentum[..., 2], rel=1e-15)
        along, before = (np.sum(s.axis * s.momentum, axis=-1) for s in (later, state))
        assert (np.abs(along - before) / size).max() < 1e-14
        change = energy(top, later) - energy(top, state)
        assert (np.abs(change) / (size**2 / np.minimum(INERTIA, top.transverse_inertia))).max() < 1e-14


def test_the_angle_swept_is_the_azimuth() -> None:
    top, state = many(40)
    times = np.linspace(0, 2.0, 4001)[:, None]
    azimuth = np.unwrap(np.arctan2(*(exact(top, state, times).axis[..., i] for i in (1, 0))), axis=0)
    assert np.abs(precession_angle(top, state, times) - (azimuth - azimuth[0])).max() < 1e-10


@pytest.mark.parametrize("pitch", [-50.0, 0.0, 25.0])
@pytest.mark.parametrize("spin", [400 * RPM, -400 * RPM])
def test_steady_precession_stays_steady(pitch: float, spin: float) -> None:
    angle, times = np.radians(pitch), np.linspace(0, 60, 50)
    state = steady(TOP, spin, angle)
    rate = physics.precession_rate(TORQUE, spin, INERTIA, TRANSVERSE, angle)
    path = exact(TOP, state, times)
    assert np.abs(path.axis[:, 2] - np.sin(angle)).max() < 1e-14
    assert precession_angle(TOP, state, times) == pytest.approx(rate * times, rel=1e-12)
    assert mean_precession_rate(TOP, state) == pytest.approx(rate, rel=1e-12)
    # ψ̇ = ω3 − φ̇ cosθ, eq. (2).
    total = np.sum(path.axis * path.momentum, axis=-1) / INERTIA
    assert total - rate * np.sin(angle) == pytest.approx(np.full(50, spin), rel=1e-14)


def test_published_bias_of_a_released_rod() -> None:
    # By elliptic integrals: 0.08827 % at 20 g and 1.014 % at 60 g, 200 rpm, k = 1.39 and 1.60, m g x for 150 mm.
    for mass, ratio, percent in ((0.02, 1.39, 0.08827), (0.06, 1.60, 1.014)):
        torque = mass * 9.8031 * 0.15
        top = Top(INERTIA, ratio * INERTIA, torque)
        rate = mean_precession_rate(top, released(top, 200 * RPM))
        assert 100 * (torque / (rate * 200 * RPM * INERTIA) - 1) == pytest.approx(percent, rel=0.02)


def test_a_rod_that_stands_stays() -> None:
    poles = ((UPRIGHT, 0.3 * UPRIGHT), (UPRIGHT, 0 * UPRIGHT), (-UPRIGHT, 0 * UPRIGHT))
    for top, (axis, momentum) in product((TOP, HANGING, FREE), poles):
        state = State(axis, momentum)
        later = exact(top, state, 50.0)
        assert [*later.axis, *later.momentum] == pytest.approx([*axis, *momentum], abs=1e-24)
        assert (precession_angle(top, state, 50.0), mean_precession_rate(top, state)) == (0, 0)
        assert time_to_turn(top, state, 1.0) == np.inf


def test_time_of_a_turn_undoes_the_angle() -> None:
    top, state = many()
    pulled = top.torque != 0
    top = Top(INERTIA, top.transverse_inertia[pulled], top.torque[pulled])
    state = State(state.axis[pulled], state.momentum[pulled])
    sense = np.sign(mean_precession_rate(top, state))
    for turns in (1e-3, 1 / 3, 1.0, 20.0):
        angle = sense * turns * 2 * np.pi
        time = time_to_turn(top, state, angle)
        assert np.isfinite(time).all()
        assert (np.abs(precession_angle(top, state, time) - angle) / (1 + np.abs(angle))).max() < 1e-12


def test_a_turn_that_never_comes_takes_for_ever() -> None:
    state = released(TOP, 300 * RPM)
    assert (time_to_turn(TOP, state, -0.5), time_to_turn(TOP, state, 0.0)) == (np.inf, 0)
    assert time_to_turn(FREE, released(FREE, 300 * RPM), 1.0) == np.inf


@settings(max_examples=60, deadline=None)
@given(*(st.floats(*ends) for ends in ((0, np.pi), (-70, 70), (-5, 5), (-5, 5), (-0.2, 0.2))))
def test_any_motion_agrees_with_the_series(
    theta: float, spin: float, turning: float, nodding: float, torque: float
) -> None:
    # In half a second no motion magnifies rounding by more than a few thousand times.
    top = Top(INERTIA, TRANSVERSE, torque)
    assert far_from_series(top, moving(theta, spin, turning, nodding), 0.5) < 1e-11


def test_impossible_tops_are_refused() -> None:
    for top in ((0.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, np.nan), (np.array([1.0, -1.0]), 1.0, 1.0)):
        with pytest.raises(ValueError, match=r"inertia must be above 0|torque is not a finite number"):
            Top(*top)


FROM_UPRIGHT = (np.pi / 2, 0.8, 0.1, 3e-2, 1e-3, 1e-5, -1e-5, -1e-3)


@pytest.mark.parametrize(
    ("spins", "pitches", "near"),
    [
        ((20.0, 100 * RPM, -400 * RPM), [np.copysign(np.pi / 2 - abs(off), off) for off in FROM_UPRIGHT], 1e-11),
        # Wide nutations, up to a straight angle.
        ((-8.0, 1.0, 3.0, 6.0, 15.0, 40.0), (-1.2, -0.5, 0.0, 0.5, 1.2), 4e-15),
    ],
    ids=["near the vertical", "wide"],
)
def test_mean_rate_is_the_angle_of_a_nutation(spins: tuple[float, ...], pitches: list[float], near: float) -> None:
    for spin, pitch in product(spins, pitches):
        state, period = released(TOP, spin, pitch), whole_nutation(TOP, spin, pitch).period
        mean = mean_precession_rate(TOP, state)
        assert mean * period == pytest.approx(precession_angle(TOP, state, period), rel=near)
        assert mean * 40 * period == pytest.approx(precession_angle(TOP, state, 40 * period), rel=1e-11)


def test_the_first_time_of_an_angle_is_the_first_of_a_fine_grid() -> None:
    times = np.linspace(0, 3, 30_001)
    for spin, turning, nodding in product((30.0, -30.0), (-6.0, -1.0, 0.0, 2.0, 14.0), (-2.0, 0.0, 1.5)):
        state = moving(1.2, spin, turning, nodding)
        swept = precession_angle(TOP, state, times)
        for angle in (0.02, -0.02, 0.4, -0.4):
            passed = np.sign(angle) * swept >= abs(angle)
            found = time_to_turn(TOP, state, angle)
            assert found == pytest.approx(times[np.argmax(passed)], abs=1.01e-4) if passed.any() else found > 3


def test_a_turn_that_ends_where_the_rod_stands_still_is_found() -> None:
    # A rod let go from rest comes to rest again after every nutation: a triple zero, where Newton's method stalls.
    state, nutation = released(TOP, 200 * RPM), whole_nutation(TOP, 200 * RPM, 0.0).period
    target = float(precession_angle(TOP, state, 3 * nutation))
    assert precession_angle(TOP, state, time_to_turn(TOP, state, target)) == pytest.approx(target, abs=1e-14)
