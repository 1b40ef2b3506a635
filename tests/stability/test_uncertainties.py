"""Uncertainties that are too small, or pull the value, and the way round each."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from labs import INERTIA, lab

from gyrodata import fitting
from gyrodata.benchmark.estimators import (
    Answer,
    log_fit,
    pretested,
    torque_on_product,
    weighted,
    york,
)
from gyrodata.fitting import K_95
from gyrodata.measurements import Measurements


def drawn(count: int, **options: Any) -> list[Measurements]:
    return [lab(np.random.default_rng((7, k)), **options) for k in range(count)]


def own(measured: Measurements) -> Answer:
    fit = fitting.fit(measured)
    assert fit.inertia.u is not None
    ends = fit.inertia.value + K_95 * fit.inertia.u * np.array([0, -1, 1])
    return Answer(*ends)


def without_interval(value: float) -> Answer:
    return Answer(np.array(value), np.array(np.nan), np.array(np.nan))


def coverage(labs: list[Measurements], estimate: Callable[[Measurements], Answer]) -> float:
    """How often the 95 % interval holds the truth."""
    answers = [estimate(measured) for measured in labs]
    return float(np.mean([answer.low <= INERTIA <= answer.high for answer in answers]))


def bias(labs: list[Measurements], estimate: Callable[[Measurements], Answer]) -> float:
    return float(np.mean([estimate(measured).value for measured in labs]) / INERTIA - 1)


def through_origin(measured: Measurements) -> Answer:
    return york(measured, intercept=False)


def test_rows_taken_as_independent_are_too_sure() -> None:
    # One scale, one ruler, one tachometer for 27 runs.
    labs = drawn(80, repeats=3)
    assert coverage(labs, through_origin) < 0.75
    assert coverage(labs, lambda measured: torque_on_product(measured, intercept=False)) < 0.75
    assert coverage(labs, own) > 0.9


def test_peelle_shared_scale_errors_pull_a_plain_fit_down() -> None:
    labs = drawn(150, u_spin=0.05, u_spin_scale=0.03, u_time=0.02)

    def mean(fitted: bool, measured: Measurements) -> Answer:
        ratio = measured.torque / np.abs(measured.product)
        size = np.full(len(ratio), ratio.mean()) if fitted else ratio
        covariance = np.diag((0.05 * size) ** 2) + 0.03**2 * np.outer(size, size)
        weight = np.linalg.solve(covariance, np.ones(len(ratio)))
        return without_interval(float(weight @ ratio / weight.sum()))

    at_measured, at_fitted = (bias(labs, partial(mean, fitted)) for fitted in (False, True))
    # The standard error of the mean of so many labs is 0.3 %; that of the difference is much less.
    assert at_measured - at_fitted < -0.009
    assert abs(at_fitted) < 0.01
    assert abs(bias(labs, own)) < 0.01


def test_weights_from_measured_times_pull_the_fit() -> None:
    # The product is one over the time: a time read too long makes it look precise, and I_zz is too large then.
    labs = drawn(300, turns=1 / 3, u_time=0.5, u_mass=1e-4, u_zero=1e-5, u_spin=1e-3, u_spin_scale=1e-5)
    assert bias(labs, weighted) > 0.003
    assert bias(labs, log_fit) > 0.002
    assert bias(labs, through_origin) > 0.005

    def in_time(measured: Measurements) -> Answer:
        # The same knowledge as a line through the origin has: no residual torque, no bias of the hand.
        lever = 2 * np.pi * measured.turns * measured.spin / measured.torque
        return without_interval(float(np.sum(lever * measured.time) / np.sum(lever**2)))

    assert abs(bias(labs, in_time)) < 0.001


def test_a_pretest_on_the_constant_covers_worst_at_a_small_m0() -> None:
    def covered(imbalance: float) -> float:
        return coverage(drawn(60, imbalance=imbalance, u_zero=1e-4, u_mass=5e-4, u_spin_scale=1e-4), pretested)

    # 1 % of the lightest torque: too little to be seen, enough to matter.
    assert covered(3e-4) < 0.5
    assert covered(2.4e-3) > 0.85
    held = drawn(60, imbalance=3e-4, u_zero=1e-4, u_mass=5e-4, u_spin_scale=1e-4)
    assert coverage(held, own) > 0.9


def test_a_line_without_a_constant_is_too_sure_with_an_m0() -> None:
    labs = drawn(80, imbalance=1e-3)
    assert coverage(labs, through_origin) < 0.1
    assert coverage(labs, own) > 0.88


def test_a_hand_that_is_always_late_is_no_scatter() -> None:
    # 0.15 s, three times the prior of 0.05 s that a log gets if it does not say.
    labs = drawn(80, bias=0.15, turns=1 / 3)
    assert coverage(labs, lambda measured: york(measured, intercept=True)) < 0.75
    knowing = [fitting.fit(measured) for measured in labs]
    assert np.mean([fit.timing_bias.value for fit in knowing]) > 0.02
