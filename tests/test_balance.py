"""What a balance test is worth that may be false."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from labs import INERTIA, lab

from gyrodata.fitting import fit
from gyrodata.fitting.inertia import DOUBTED, FALSE, TRUSTED, weigh

MEAN = np.array([4.44e-3, 6e-4, 0.01])
COVARIANCE = np.array([[1.6e-9, 1.0e-8, 1e-8], [1.0e-8, 1.6e-7, 1e-7], [1e-8, 1e-7, 2.5e-3]])


def density(imbalance: np.ndarray, tested: float, trust: float) -> np.ndarray:
    """What is thought of M0 before the runs are looked at."""

    def normal(centre: float, width: float) -> np.ndarray:
        return np.exp(-0.5 * ((imbalance - centre) / width) ** 2) / width

    total = trust * normal(0.0, tested)
    for centre, width, chance in FALSE:
        total += (1 - trust) * chance * normal(centre * tested, width * tested)
    return total


@pytest.mark.parametrize("tested", [2e-5, 1e-4, 4e-4])
def test_the_answer_is_that_of_an_integral_over_the_residual_torque(tested: float) -> None:
    imbalance = np.linspace(-60 * tested - 3e-3, 60 * tested + 3e-3, 400_001)
    given_runs = np.exp(-0.5 * (imbalance - MEAN[1]) ** 2 / COVARIANCE[1, 1])
    # I_zz and b follow M0 as their covariances say.
    slope = COVARIANCE[1] / COVARIANCE[1, 1]
    weighed = weigh(MEAN, COVARIANCE, tested)
    share = density(imbalance, tested, TRUSTED) * given_runs
    expected = MEAN + slope * (np.sum(share * imbalance) / share.sum() - MEAN[1])
    assert weighed.mean == pytest.approx(expected, rel=1e-9)
    share = density(imbalance, tested, DOUBTED) * given_runs
    along = np.sum(share * (imbalance - weighed.mean[1]) ** 2) / share.sum()
    least = COVARIANCE[1, 1] if weighed.odds < 1 else 0.0
    assert weighed.covariance[1, 1] == pytest.approx(max(along, least), rel=1e-6)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.floats(-5e-3, 5e-3), st.floats(-9, -2), st.floats(-6, -3), st.floats(-0.99, 0.99))
def test_what_comes_out_is_an_answer_between_with_a_covariance(
    imbalance: float, tested: float, u: float, correlation: float
) -> None:
    inertia_u, imbalance_u = 5e-5, 10.0**u
    mixed = correlation * inertia_u * imbalance_u
    covariance = np.array([[inertia_u**2, mixed], [mixed, imbalance_u**2]])
    weighed = weigh(np.array([INERTIA, imbalance]), covariance, 10.0**tested)
    if weighed.odds < 1:
        assert (np.diag(weighed.covariance) >= np.diag(covariance) * (1 - 1e-9)).all()
    assert (
        np.linalg.eigvalsh(weighed.covariance / np.outer([inertia_u, imbalance_u], [inertia_u, imbalance_u])) > 0
    ).all()
    low, high = sorted((0.0, imbalance))
    reach = 33 * 10.0**tested
    assert low - reach <= weighed.mean[1] <= high + reach


def test_a_test_far_from_what_the_runs_say_is_nothing() -> None:
    weighed = weigh(MEAN, COVARIANCE, 1e-12)
    assert weighed.mean[1] == pytest.approx(0.0, abs=1e-9), "1.5 standard uncertainties are no contradiction"
    far = np.array([MEAN[0], 3e-3, MEAN[2]])
    weighed = weigh(far, COVARIANCE, 1e-12)
    assert (weighed.mean == far).all()
    assert (weighed.covariance == COVARIANCE).all()
    assert weighed.contradicted


def test_what_has_no_uncertainty_stays_exact() -> None:
    exact = COVARIANCE.copy()
    exact[2] = exact[:, 2] = 0.0
    weighed = weigh(MEAN, exact, 1e-4)
    assert weighed.mean[2] == pytest.approx(MEAN[2], rel=1e-12)
    assert weighed.covariance[2, 2] == 0.0


@pytest.mark.parametrize(("turns", "width"), [(1.0, 1e-4), (1 / 3, 3e-5), (1 / 3, 1.7e-4)])
def test_true_tests_help_and_false_ones_are_covered(turns: float, width: float) -> None:
    random = np.random.default_rng(4)
    labs = 250

    def drawn(imbalances: np.ndarray) -> tuple[float, float]:
        """RMSE over that without the test, and coverage of ± 2u."""
        pairs = []
        for imbalance in imbalances:
            measured = lab(random, turns=turns, imbalance=imbalance, bias=0.05 * random.standard_normal())
            tested = fit(replace(measured, imbalance_u=lambda inertia: width))
            pairs.append((tested, fit(measured)))
        off = [np.array([result.inertia.value - INERTIA for result in side]) for side in zip(*pairs, strict=True)]
        held = np.abs(off[0]) < 2 * np.array([result.inertia.u for result, _ in pairs])
        return float(np.sqrt(np.mean(off[0] ** 2) / np.mean(off[1] ** 2))), float(held.mean())

    # 93.5 % and more, less two standard deviations of a count of 250.
    ratio, held = drawn(width * random.standard_normal(labs))
    assert ratio < 0.85
    assert held > 0.905
    # Ten times larger than stated.
    _, held = drawn(10 * width * random.choice([-1.0, 1.0], labs))
    assert held > 0.905
