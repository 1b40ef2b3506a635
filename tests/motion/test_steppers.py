"""The integrators that splitting is measured against: what they keep, drag, stacks, and a pair's coefficients."""

from __future__ import annotations

import numpy as np
import pytest

from gyrodata.benchmark.steppers import march, tsit5
from gyrodata.motion import Top, energy, exact, released

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
