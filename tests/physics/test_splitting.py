"""The splitting methods: their order, what they keep, and the coefficients by their
conditions.
"""

from __future__ import annotations

import numpy as np
import pytest

from gyrodata.physics.motion import METHODS, State, Top, integrate, released, split

INERTIA, TORQUE = 4.44e-3, 0.0588
TOP = Top(inertia=INERTIA, transverse_inertia=1.49 * INERTIA, torque=TORQUE)
FAST = 600 * np.pi / 30


def far(top: Top, steps: int, method: str) -> float:
    state = released(top, FAST, 0.1)
    true = integrate(top, state, [2.0], rtol=1e-13, atol=1e-15)[0].axis[0]
    return float(np.abs(split(top, state, 2.0, steps, method).axis - true).max())


def energy(top: Top, state: State) -> float:
    """Kinetic and potential energy [J]."""
    along, whole = state.axis @ state.momentum, state.momentum @ state.momentum
    kinetic = (whole - along**2) / top.transverse_inertia + along**2 / top.inertia
    return float(kinetic / 2 + top.torque * state.axis[2])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "order", "steps"), [("strang", 2, 200), ("aba84", 4, 100)]
)
def test_a_method_has_the_order_that_it_is_known_for(
    method: str, order: int, steps: int
) -> None:
    assert np.log2(
        far(TOP, steps, method) / far(TOP, 2 * steps, method)
    ) == pytest.approx(order, abs=0.1)


def test_a_weak_torque_brings_out_the_eighth_order() -> None:
    # The error is ε dt⁸ and ε² dt⁴: a torque a hundred thousand times weaker hides the
    # latter.
    weak = Top(inertia=INERTIA, transverse_inertia=1.49 * INERTIA, torque=1e-5 * TORQUE)
    assert np.log2(far(weak, 12, "aba84") / far(weak, 24, "aba84")) > 7


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_conserved_quantities_stay_and_the_energy_is_bounded(method: str) -> None:
    state = released(TOP, 200 * np.pi / 30, 0.3)
    worst = []
    for time in (20.0, 200.0):
        end = split(TOP, state, time, int(100 * time), method)
        assert end.momentum[2] == state.momentum[2]
        assert np.linalg.norm(end.axis) == pytest.approx(1, abs=1e-13)
        assert end.axis @ end.momentum == pytest.approx(
            state.axis @ state.momentum, rel=1e-13
        )
        path = [split(TOP, end, step / 100, step, method) for step in range(1, 60)]
        worst.append(
            max(abs(energy(TOP, place) - energy(TOP, state)) for place in path)
        )
    # Ten times as long, no more energy lost.
    assert worst[1] < 1.2 * worst[0] + 1e-13 * TORQUE
