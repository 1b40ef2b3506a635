"""Straight lines through the points (φ̇ψ̇, M), where ways to fit them fail."""

from __future__ import annotations

import math

import numpy as np
import pytest
from labs import INERTIA, G, lab

from gyrodata import fitting
from gyrodata.benchmark.estimators import (
    Estimator,
    linregress,
    log_fit,
    mean_of_ratios,
    polyfit,
    recommended,
    theil_sen,
    weighted,
)
from gyrodata.measurements import Measurements, select


def random(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


def holds(measured: Measurements) -> bool:
    """Whether the recommended fit has the truth within three of its standard uncertainties, its interval no zero."""
    answer = recommended(measured)
    assert answer.half < answer.value
    return bool(abs(answer.value - INERTIA) < 1.6 * answer.half)


class TestOneTorque:
    """All weights equal: the points lie above one another, and a slope is what the noise makes of it."""

    measured = lab(random(), weights=(0.040,), repeats=3)

    @pytest.mark.parametrize("estimate", [polyfit, linregress, theil_sen], ids=["polyfit", "linregress", "Theil–Sen"])
    def test_lines_return_zero_without_a_word(self, estimate: Estimator) -> None:
        assert abs(estimate(self.measured).value) < 1e-3 * INERTIA


class TestIdenticalPoints:
    measured = select(lab(random(), weights=(0.040,), rpm=(400.0,)), [0, 0, 0])

    def test_polyfit_warns_and_gives_half_of_it(self) -> None:
        with pytest.warns(np.exceptions.RankWarning):
            slope = np.polyfit(self.measured.product, self.measured.torque, 1)[0]
        assert slope / INERTIA != pytest.approx(1, abs=0.1)

    def test_the_way_round(self) -> None:
        with pytest.raises(ValueError, match="x are"):
            fitting.fit_line(self.measured.product, self.measured.torque)
        assert fitting.ordinary_line(self.measured.product, self.measured.torque, intercept=True) is None
        assert holds(self.measured)


def test_two_points_leave_no_residual() -> None:
    two = select(lab(random()), [0, 8])
    line = fitting.ordinary_line(two.product, two.torque, intercept=True)
    assert line is not None
    assert line.slope.u is None, "not 0, and not NaN"
    # Student's factor for one degree of freedom is 12.7.
    ratio = mean_of_ratios(two)
    assert np.isfinite([ratio.half, weighted(two).half]).all()
    assert holds(two)


class TestRunWithoutTorque:
    """Timed while the residual torque alone turned it: a point near the origin, and a ratio of zero."""

    measured = lab(random(), unloaded=True, imbalance=1e-3)

    def test_it_has_no_ratio_and_no_logarithm(self) -> None:
        ratios = self.measured.torque / self.measured.product
        assert ratios[-1] == 0
        # So it is left out, and with it all that it tells of the residual torque.
        assert log_fit(self.measured).value / INERTIA - 1 < -0.015

    def test_the_way_round(self) -> None:
        assert holds(self.measured)
        assert fitting.fit(self.measured).imbalance.value == pytest.approx(1e-3, rel=0.05)


class TestSignLost:
    """Weights on either side, and products without a sign, as a stopwatch and a tachometer give them."""

    measured = lab(random(), positions=(0.15, -0.15))

    def test_the_slope_is_zero_or_garbage(self) -> None:
        unsigned, torque = np.abs(self.measured.product), self.measured.torque
        assert abs(np.mean(torque / unsigned)) < 0.01 * INERTIA
        assert abs(np.sum(unsigned * torque) / np.sum(unsigned**2)) < 0.01 * INERTIA
        assert abs(np.polyfit(unsigned, torque, 1)[0]) < 0.5 * INERTIA

    def test_the_way_round_is_the_sign_of_the_torque(self) -> None:
        assert (self.measured.sense == np.sign(self.measured.torque)).all()
        assert holds(self.measured)


def test_theil_sen_meets_ties_where_weights_are_used_again() -> None:
    biases = []
    for seed in range(40):
        measured = lab(random(seed))
        biases.append(theil_sen(measured).value / INERTIA - 1)
    # Nine of the 36 slopes are exactly zero, so that their median is too low and its interval means nothing.
    product, torque = measured.product, measured.torque
    first, second = np.triu_indices(9, 1)
    assert np.sum(torque[first] == torque[second]) == 9
    assert np.mean(biases) < -0.004
    half = theil_sen(measured).half
    assert half > 0.3 * INERTIA
    untied = torque[first] != torque[second]
    slopes = (product[second] - product[first])[untied] / (torque[second] - torque[first])[untied]
    assert 1 / np.median(slopes) == pytest.approx(INERTIA, rel=0.05)
    assert holds(measured)


def test_normal_equations_lose_twice_the_digits() -> None:
    # A line far from the origin: y = 3 + 2 x with x near 10⁸.
    x = 1e8 + np.arange(9.0)
    y = 3 + 2 * x
    design = np.column_stack([x, np.ones(9)])
    constant = (np.sum(x * x) * np.sum(y) - np.sum(x) * np.sum(x * y)) / np.linalg.det(design.T @ design)
    assert abs(constant - 3) > 1
    line = fitting.fit_line(x, y, cov_y=1.0)
    assert line.slope == pytest.approx(2, rel=1e-15)
    assert line.intercept == pytest.approx(3, abs=1e-7)


def test_odr_takes_a_weight_used_again_for_a_new_one() -> None:
    odrpack = pytest.importorskip("odrpack")

    def quoted(repeats: int) -> tuple[float, float]:
        # One weighing to 1 % of each of three weights; all else is a thousand times better.
        measured = lab(random(), repeats=repeats, noise=0.0, u_mass=0.01, u_time=1e-3, u_spin=1e-5, u_zero=1e-6)
        product, torque = measured.product, measured.torque
        found = odrpack.odr_fit(
            lambda x, beta: beta[0] * x, product, torque, np.array([INERTIA]),
            weight_x=1 / (1e-4 * product) ** 2, weight_y=1 / (0.01 * torque) ** 2,
        )  # fmt: skip
        u = fitting.fit(measured).inertia.u
        assert u is not None
        return math.sqrt(found.cov_beta[0, 0]), u

    once, often = quoted(1), quoted(9)
    assert often[0] == pytest.approx(once[0] / 3, rel=0.05), "as if each run had a weight of its own"
    assert often[1] == pytest.approx(once[1], rel=0.05)


def test_an_arm_that_is_off_is_a_scale_where_only_weights_change() -> None:
    def shifted(positions: tuple[float, ...]) -> float:
        measured = lab(random(), positions=positions, noise=0.0, u_zero=0.0)
        torque = measured.mass * G * (measured.position + 0.0005)
        line = fitting.ordinary_line(measured.product, torque, intercept=True)
        assert line is not None
        return float(line.slope.value / INERTIA - 1)

    assert shifted((0.15,)) == pytest.approx(0.0005 / 0.15, rel=1e-6), "and no constant tells it"
    assert abs(shifted((0.05, 0.15))) < 0.2 * 0.0005 / 0.05
    # So the ruler's zero is in the budget, shared by all runs.
    shares = {share.source: share for share in fitting.fit(lab(random())).budget}
    assert shares["position_zero"].shared
    assert shares["position_zero"].u_inertia / INERTIA == pytest.approx(0.0005 / 0.15, rel=0.05)
