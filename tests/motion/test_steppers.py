"""The integrators that splitting is measured against: what they keep, drag, stacks, and a pair's coefficients."""

from __future__ import annotations

import numpy as np
import pytest

from gyrodata.benchmark.steppers import STEPPERS, march, tsit5
from gyrodata.motion import METHODS, State, Top, energy, exact, integrate, released

INERTIA = 4.44e-3
TOP = Top(INERTIA, 1.49 * INERTIA, 0.0588)
SLOW = 150 * np.pi / 30
START = released(TOP, SLOW, 0.3)
END = exact(TOP, START, 2.0)


@pytest.mark.parametrize(("method", "steps", "near"), [("RK4", 800, 1e-7), ("RKMK4", 400, 1e-7), ("aba84", 400, 1e-9)])
def test_they_follow_the_exact_motion(method: str, steps: int, near: float) -> None:
    path = march(method, TOP, START, 2.0, steps)
    assert path.axis == pytest.approx(END.axis, abs=near)
    assert path.momentum == pytest.approx(END.momentum, abs=near * INERTIA * SLOW)


def test_halving_the_step_of_the_midpoint_rule_leaves_a_quarter_of_the_error() -> None:
    off = [np.linalg.norm(march("implicit midpoint", TOP, START, 2.0, steps).axis - END.axis) for steps in (800, 1600)]
    assert off[0] / off[1] == pytest.approx(4, rel=0.02)


def test_evaluations_are_counted() -> None:
    assert march("RK4", TOP, START, 1.0, 7).evaluations == 28
    assert march("RKMK4", TOP, START, 1.0, 7).evaluations == 28
    assert march("aba84", TOP, START, 1.0, 7).evaluations == 35
    assert 14 < march("implicit midpoint", TOP, START, 1.0, 7).evaluations < 100


def test_the_midpoint_rule_keeps_all_that_is_quadratic() -> None:
    path = march("implicit midpoint", TOP, START, 20.0, 1000)
    assert np.linalg.norm(path.axis) == pytest.approx(1, abs=1e-13)
    assert path.momentum[2] == pytest.approx(START.momentum[2], abs=1e-16)
    assert path.axis @ path.momentum == pytest.approx(START.axis @ START.momentum, rel=1e-13)
    assert energy(TOP, path) - energy(TOP, START) == pytest.approx(0, abs=1e-12 * TOP.torque)


def test_the_method_on_the_group_never_leaves_the_sphere() -> None:
    path = march("RKMK4", TOP, START, 20.0, 1000)
    assert np.linalg.norm(path.axis) == pytest.approx(1, abs=1e-13)
    assert path.momentum[2] == START.momentum[2]
    assert abs(np.linalg.norm(march("RK4", TOP, START, 20.0, 1000).axis) - 1) > 1e-8


@pytest.mark.parametrize("method", ["RK4", "RKMK4"])
def test_drag(method: str) -> None:
    drag = 2e-4
    true = integrate(TOP, START, 2.0, drag=drag, rtol=1e-11)
    path = march(method, TOP, START, 2.0, 1600, drag)
    assert path.axis == pytest.approx(true.axis, abs=1e-8)
    assert path.momentum == pytest.approx(true.momentum, abs=1e-8 * INERTIA * SLOW)
    assert energy(TOP, path) < energy(TOP, START) - 1e-3


@pytest.mark.parametrize("method", ["implicit midpoint", "aba84"])
def test_drag_is_refused_by_those_that_know_of_none(method: str) -> None:
    with pytest.raises(ValueError, match="knows of no drag"):
        march(method, TOP, START, 1.0, 10, 1e-4)


@pytest.mark.parametrize("method", [*STEPPERS, *METHODS])
def test_a_stack_is_the_single_tops(method: str) -> None:
    tops = Top(INERTIA, 1.49 * INERTIA, np.array([0.03, -0.06, 0.05]))
    states = released(tops, np.array([20.0, 40.0, 0.0]), 0.2)
    times = np.array([1.0, 2.0, -0.5])
    together = march(method, tops, states, times, 60)
    for i, time in enumerate(times):
        one = Top(INERTIA, 1.49 * INERTIA, tops.torque[i])
        alone = march(method, one, State(states.axis[i], states.momentum[i]), time, 60)
        assert alone.axis == pytest.approx(together.axis[i], abs=1e-12)
        assert alone.momentum == pytest.approx(together.momentum[i], abs=1e-13)


def test_the_pair_of_tsitouras_meets_its_order_conditions() -> None:
    pair = tsit5()
    a, b, c = np.zeros((7, 6)), np.append(pair.B, 0.0), np.append(pair.C, 1.0)
    a[:6, :5], a[6] = pair.A, pair.B
    a = np.column_stack([a, np.zeros(7)])
    assert a.sum(axis=1) == pytest.approx(c, abs=1e-14)
    for power in range(5):
        assert b @ c**power == pytest.approx(1 / (power + 1), abs=1e-14)
    # Of the trees that are no quadrature, one of each order.
    assert b @ a @ c == pytest.approx(1 / 6, abs=1e-14)
    assert b @ a @ a @ c == pytest.approx(1 / 24, abs=1e-14)
    assert b @ a @ a @ a @ c == pytest.approx(1 / 120, abs=1e-14)
    assert (b * c) @ a @ c**2 == pytest.approx(1 / 15, abs=1e-14)
    # The other member of the pair is of order 4: their difference is nothing up to there.
    for power in range(4):
        assert pair.E @ c**power == pytest.approx(0, abs=1e-14)
    assert abs(pair.E @ c**4) > 1e-5
    assert pair.P.sum(axis=1) == pytest.approx(b, abs=1e-13)


def test_the_pair_of_tsitouras_gives_the_way_between_its_steps() -> None:
    times = np.linspace(0, 2.0, 57)
    path = integrate(TOP, START, times, method=tsit5(), rtol=1e-9, atol=1e-12)
    assert np.abs(path.axis - exact(TOP, START, times).axis).max() < 1e-7
