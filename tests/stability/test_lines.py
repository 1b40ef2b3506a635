"""Straight lines through the points (φ̇ψ̇, M), where ways to fit them fail and the recommended fit does not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from labs import INERTIA, G, lab

from gyrodata import fit_line
from gyrodata.fitting import fit
from gyrodata.measurements import Measurements


def drawn(seed: int = 1, **options: object) -> Measurements:
    return lab(np.random.default_rng(seed), **options)  # type: ignore[arg-type]


def test_normal_equations_lose_twice_the_digits() -> None:
    # A line far from the origin: y = 3 + 2 x with x near 10⁸.
    x = 1e8 + np.arange(9.0)
    y = 3 + 2 * x
    design = np.column_stack([x, np.ones(9)])
    constant = (np.sum(x * x) * np.sum(y) - np.sum(x) * np.sum(x * y)) / np.linalg.det(design.T @ design)
    assert abs(constant - 3) > 1
    line = fit_line(x, y, cov_y=1.0)
    assert line.slope == pytest.approx(2, rel=1e-15)
    assert line.intercept == pytest.approx(3, abs=1e-7)


def test_odr_takes_a_weight_used_again_for_a_new_one() -> None:
    odrpack = pytest.importorskip("odrpack")

    def quoted(repeats: int) -> tuple[float, float]:
        # One weighing to 1 % of each of three weights; all else is a thousand times better.
        measured = drawn(repeats=repeats, noise=0.0, u_mass=0.01, u_time=1e-3, u_spin=1e-5, u_zero=1e-6)
        product, torque = measured.product, measured.torque
        found = odrpack.odr_fit(
            lambda x, beta: beta[0] * x, product, torque, np.array([INERTIA]),
            weight_x=1 / (1e-4 * product) ** 2, weight_y=1 / (0.01 * torque) ** 2,
        )  # fmt: skip
        return math.sqrt(found.cov_beta[0, 0]), fit(measured).inertia.u

    once, often = quoted(1), quoted(9)
    assert often[0] == pytest.approx(once[0] / 3, rel=0.05), "as if each run had a weight of its own"
    assert often[1] == pytest.approx(once[1], rel=0.05)


def test_an_arm_that_is_off_is_a_scale_where_only_weights_change() -> None:
    def shifted(positions: tuple[float, ...]) -> float:
        measured = drawn(positions=positions, noise=0.0, u_zero=0.0)
        torque = measured.mass * G * (measured.position + 0.0005)
        return fit_line(measured.product, torque).slope / INERTIA - 1

    assert shifted((0.15,)) == pytest.approx(0.0005 / 0.15, rel=1e-6), "and no constant shows it"
    assert abs(shifted((0.05, 0.15))) < 0.2 * 0.0005 / 0.05
    # So the ruler's zero is in the budget, shared by all runs.
    (share,) = (share for share in fit(drawn()).budget if share.source == "position_zero")
    assert share.shared
    assert share.u_inertia / INERTIA == pytest.approx(0.0005 / 0.15, rel=0.05)
