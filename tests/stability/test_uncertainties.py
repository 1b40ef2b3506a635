"""Uncertainties that are too small, or pull the value, and the recommended fit of the same labs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from labs import INERTIA, lab

from gyrodata import LineFit, fit_line
from gyrodata.fitting import fit
from gyrodata.measurements import Measurements


def drawn(count: int, **options: Any) -> list[Measurements]:
    return [lab(np.random.default_rng((7, k)), **options) for k in range(count)]


def york(measured: Measurements, intercept: bool = False) -> LineFit:
    """Fit a line that takes all errors for each run's own."""
    x, y, time, spin = measured.product, measured.torque, *measured.sources[:2]
    u_x = x * np.hypot(time.absolute / measured.time, spin.relative)
    return fit_line(x, y, u_x**2, (0.002 * y) ** 2, intercept=intercept)


def coverage(labs: list[Measurements], intercept: bool = False) -> float:
    """How often the 95 % interval of the line contains the truth."""
    lines = [york(measured, intercept) for measured in labs]
    return float(np.mean([abs(line.slope - INERTIA) < 1.96 * line.u_slope for line in lines]))


@pytest.mark.parametrize(
    ("options", "most", "least"),
    [({"repeats": 3}, 0.75, 0.9), ({"imbalance": 1e-3}, 0.1, 0.88)],
    ids=["one scale and ruler for 27 runs", "no constant with an M0"],
)
def test_a_line_is_too_sure_and_the_recommended_fit_is_not(options: dict[str, Any], most: float, least: float) -> None:
    labs = drawn(80, **options)
    assert coverage(labs) < most
    ends = np.array([fit(measured).inertia.interval_95 for measured in labs])
    assert np.mean((ends[:, 0] < INERTIA) & (ends[:, 1] > INERTIA)) > least


def test_peelle_shared_scale_errors_pull_a_plain_fit_down() -> None:
    labs = drawn(150, u_spin=0.05, u_spin_scale=0.03, u_time=0.02)

    def bias(fitted: bool) -> float:
        means = []
        for measured in labs:
            ratio = measured.torque / measured.product
            size = np.full(len(ratio), ratio.mean()) if fitted else ratio
            covariance = np.diag((0.05 * size) ** 2) + 0.03**2 * np.outer(size, size)
            weight = np.linalg.solve(covariance, np.ones(len(ratio)))
            means.append(weight @ ratio / weight.sum())
        return float(np.mean(means) / INERTIA - 1)

    # The standard error of the mean of so many labs is 0.3 %; that of the difference is much less.
    assert bias(fitted=False) - bias(fitted=True) < -0.009
    assert abs(np.mean([fit(measured).inertia.value for measured in labs]) / INERTIA - 1) < 0.01


def test_a_hand_that_is_always_late_is_no_scatter() -> None:
    # 0.15 s, three times the prior of 0.05 s that a log gets if it states none.
    labs = drawn(80, bias=0.15, turns=1 / 3)
    assert coverage(labs, intercept=True) < 0.75
    assert np.mean([fit(measured).timing_bias.value for measured in labs]) > 0.02
