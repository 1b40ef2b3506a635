"""What a balance test is worth that may be false."""

from __future__ import annotations

import numpy as np
import pytest
from labs import INERTIA, G, fitted, lab
from msgspec.structs import replace

from gyrodata.fitting import fit

LIGHTEST = 0.020 * G * 0.15


def test_a_test_that_says_nothing_changes_nothing() -> None:
    measured = lab(np.random.default_rng(3))
    alone, tested = fit(measured).inertia, fit(replace(measured, imbalance_u=lambda inertia: 1e6)).inertia
    assert (tested.value, tested.u) == pytest.approx((alone.value, alone.u), rel=1e-7)


@pytest.mark.parametrize(("turns", "width"), [(1.0, 1e-4), (1 / 3, 3e-5), (1 / 3, 1.7e-4)])
@pytest.mark.parametrize("false", [0.0, 3.0, 10.0, 30.0])
def test_true_tests_help_and_false_ones_are_covered(turns: float, width: float, false: float) -> None:
    random = np.random.default_rng(4)
    labs = []
    for _ in range(150):
        imbalance = width * (false * random.choice([-1.0, 1.0]) if false else random.standard_normal())
        labs.append(lab(random, turns=turns, imbalance=imbalance, bias=0.05 * random.standard_normal()))
    tested = fitted([replace(one, imbalance_u=lambda inertia: width) for one in labs])
    # 93 % is asked of whole turns, less two standard deviations of a count of 150; short times can say little against
    # a false test.
    assert np.mean((tested[:, 0] < INERTIA) & (tested[:, 4] > INERTIA)) > (0.89 if turns == 1 else 0.78)
    if not false:
        off = [np.sqrt(np.mean((one[:, 2] - INERTIA) ** 2)) for one in (tested, fitted(labs))]
        assert off[0] < 0.9 * off[1]


@pytest.mark.parametrize(
    "design", [{}, {"weights": (0.04,)}, {"turns": 1 / 3}, {"weights": (0.1, 0.12, 0.14)}], ids=str
)
def test_a_tighter_true_test_never_gives_a_larger_u(design: dict[str, object]) -> None:
    random = np.random.default_rng(5)
    labs = [lab(random, **design) for _ in range(25)]  # type: ignore[arg-type]
    before = np.inf
    for width in (1e6, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6, 0.0):
        inertia = fitted([replace(one, imbalance_u=lambda inertia, width=width: width) for one in labs])
        after = float(np.mean(inertia[:, 3] - inertia[:, 1]))
        assert after < 1.01 * before
        before = after
