"""Straight lines through the points (φ̇ψ̇, M), where ways to fit them fail and the
recommended fit does not.
"""

from __future__ import annotations

import numpy as np
import pytest
from simulated_labs import INERTIA, G, lab

from gyrodata import fit_line
from gyrodata.fitting import fit
from gyrodata.measurements import Measurements


def drawn(seed: int = 1, **options: object) -> Measurements:
    return lab(np.random.default_rng(seed), **options)  # type: ignore[arg-type]


def test_a_line_far_from_the_origin_keeps_its_constant() -> None:
    # Normal equations lose twice the digits, and the constant with them.
    x = 1e8 + np.arange(9.0)
    line = fit_line(x, 3 + 2 * x, cov_y=1.0)
    assert (line.slope, line.intercept) == (
        pytest.approx(2, rel=1e-15),
        pytest.approx(3, abs=1e-7),
    )


def test_a_weight_used_again_is_no_new_weight() -> None:
    # One weighing to 1 % of each of three weights; all else is a thousand times better.
    good = {
        "noise": 0.0,
        "u_mass": 0.01,
        "u_time": 1e-3,
        "u_spin": 1e-5,
        "u_zero": 1e-6,
    }
    once, often = (fit(drawn(repeats=repeats, **good)).inertia.u for repeats in (1, 9))
    assert often == pytest.approx(once, rel=0.05)


def test_an_arm_that_is_off_is_a_scale_where_only_weights_change() -> None:
    def shifted(positions: tuple[float, ...]) -> float:
        measured = drawn(positions=positions, noise=0.0, u_zero=0.0)
        torque = measured.mass * G * (measured.position + 0.0005)
        return fit_line(measured.product, torque).slope / INERTIA - 1

    assert shifted((0.15,)) == pytest.approx(0.0005 / 0.15, rel=1e-6), (
        "and no constant shows it"
    )
    assert abs(shifted((0.05, 0.15))) < 0.2 * 0.0005 / 0.05
    # So the ruler's zero is in the budget, shared by all runs.
    (share,) = (
        share for share in fit(drawn()).budget if share.source == "position_zero"
    )
    assert share.shared
    assert share.u_inertia / INERTIA == pytest.approx(0.0005 / 0.15, rel=0.05)
