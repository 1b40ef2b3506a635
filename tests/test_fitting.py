"""The fit: the truth, the same number by another method, coverage, and where other fits break."""

from __future__ import annotations

import math
from contextlib import suppress
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gates.labs import Bench, Table, draw, write
from labs import INERTIA, G, lab
from msgspec.structs import replace
from scipy.optimize import least_squares

import gyrodata
from gyrodata.fitting import NoFit, fit, fit_as_stated
from gyrodata.measurements import Measurements


def exact(**options: object) -> Measurements:
    return lab(np.random.default_rng(0), noise=0.0, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("imbalance", [0.0, 2e-3, -2e-3, 8e-3])
def test_exact_readings_give_back_the_truth(imbalance: float) -> None:
    result = fit_as_stated(exact(imbalance=imbalance))
    assert result.inertia.value == pytest.approx(INERTIA, rel=1e-4)  # the broad prior of M0 pulls by 1e-5
    # The prior of all designs pulls a large M0 a little: by a small part of u, never the other way.
    whole = fit(exact(imbalance=imbalance))
    assert whole.inertia.value == pytest.approx(INERTIA, abs=0.25 * whole.inertia.u)
    assert result.imbalance.value == pytest.approx(imbalance, abs=1e-5)
    assert result.chi2 < 1e-2


def test_torques_of_both_signs_and_an_unloaded_run() -> None:
    both = exact(positions=(0.15, -0.15), imbalance=1e-3)
    assert fit(both).inertia.value == pytest.approx(INERTIA, rel=1e-5)
    assert fit(exact(unloaded=True, imbalance=6e-4)).imbalance.value == pytest.approx(6e-4, rel=1e-4)


def latent_least_squares(measured: Measurements) -> tuple[float, float]:
    """The same problem by another method: every true reading is an unknown of one big least-squares problem."""
    count = len(measured.runs)
    time, spin, spin_scale, mass, zero = measured.sources
    weights = max(mass.groups) + 1

    def model(p: np.ndarray) -> np.ndarray:
        inertia, imbalance, bias = p[0] * 1e-3, p[1] * 1e-3, p[2]
        e_spin, e_scale, e_zero = p[3 : 3 + count], p[3 + count], p[4 + count]
        e_mass = p[5 + count : 5 + count + weights]
        true_spin = measured.spin / (1 + spin.relative * e_spin + spin_scale.relative * e_scale)
        true_mass = measured.mass / (1 + mass.relative * e_mass[list(mass.groups)])
        torque = true_mass * G * (measured.position - zero.absolute * e_zero)
        predicted = 2 * np.pi * measured.turns * inertia * true_spin / np.abs(torque + imbalance) + bias
        priors = [p[1] * 1e-3 / np.abs(measured.torque).min(), p[2] / measured.timing_bias_u, *p[3:]]
        return np.concatenate([(measured.time - predicted) / time.absolute, priors])

    start = np.zeros(5 + count + weights)
    start[0] = 4.0
    solution = least_squares(model, start, method="trf", xtol=1e-15, ftol=1e-15, gtol=1e-15, jac="3-point")
    cov = np.linalg.inv(solution.jac.T @ solution.jac)
    return solution.x[0] * 1e-3, math.sqrt(cov[0, 0]) * 1e-3


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_agrees_with_least_squares_in_all_true_readings(seed: int) -> None:
    measured = lab(np.random.default_rng(seed), repeats=2, imbalance=2e-3, bias=0.04)
    value, u = latent_least_squares(measured)
    result = fit_as_stated(measured)
    assert result.inertia.value == pytest.approx(value, rel=2e-7)
    assert result.inertia.u == pytest.approx(u, rel=1e-5)


@pytest.mark.parametrize(
    ("repeats", "weights", "close"),
    # Where M0 is hardly told, u is 5 % of I_zz, and nothing is linear.
    [(2, (0.02, 0.04, 0.06), 0.05), (1, (0.02, 0.04, 0.06), 0.05), (3, (0.1, 0.12), 0.35)],
)
def test_agrees_with_the_posterior_by_plain_integration(repeats: int, weights: tuple[float, ...], close: float) -> None:
    # Times are normal about the model with a covariance that is written down whole; I_zz, M0 and s on a dense grid.
    measured = lab(np.random.default_rng(4), repeats=repeats, weights=weights, imbalance=5e-4, bias=0.04)
    result = fit(measured)
    time, spin, spin_scale, mass, zero = measured.sources
    lightest = float(np.abs(measured.torque).min())
    inertias = result.inertia.value + np.linspace(-8, 8, 161) * result.inertia.u
    imbalances = result.imbalance.value + np.linspace(-8, 8, 121) * result.imbalance.u
    lever = 2 * np.pi * measured.turns * measured.spin
    same = np.equal.outer(np.array(mass.groups), np.array(mass.groups))
    at = lever * result.inertia.value / (measured.torque + result.imbalance.value)
    by_torque = at * measured.torque / (measured.torque + result.imbalance.value)
    shared = measured.timing_bias_u**2 + spin_scale.relative[0] ** 2 * np.outer(at, at)
    shared = shared + np.outer(by_torque, by_torque) * (mass.relative[0] ** 2 * same + (zero.absolute[0] / 0.15) ** 2)
    total = np.zeros(len(inertias))
    predicted = lever * inertias[:, None, None] / (measured.torque + imbalances[:, None])
    residual = measured.time - predicted
    for factor in np.exp(np.linspace(math.log(0.15), math.log(12), 80)):
        covariance = shared + factor**2 * np.diag(time.absolute**2 + (spin.relative * at) ** 2)
        inverse, (_, size) = np.linalg.inv(covariance), np.linalg.slogdet(covariance)
        chi2 = np.einsum("abi,ij,abj->ab", residual, inverse, residual)
        log_factor = math.log(factor)
        prior = 0.95 * math.exp(-0.5 * (log_factor / math.log(3.5)) ** 2) / (math.log(3.5) * math.sqrt(2 * math.pi))
        prior += 0.05 / (math.pi * math.log(5) * (1 + (log_factor / math.log(5)) ** 2))
        cauchy = 1 / (1 + (imbalances / (0.05 * lightest)) ** 2)
        total += prior * (np.exp(-0.5 * (chi2 + size) + 200) * cauchy).sum(axis=1)
    below = (np.cumsum(total) - total / 2) / total.sum()
    told = (result.inertia.interval_95[0], result.inertia.value, result.inertia.interval_95[1])
    off = (np.array(told) - np.interp((0.025, 0.5, 0.975), below, inertias)) / result.inertia.u
    assert off == pytest.approx(np.zeros(3), abs=close)


@pytest.mark.parametrize(("imbalance", "repeats"), [(0.0, 1), (1.5e-3, 1), (0.0, 3)])
def test_coverage_and_bias(imbalance: float, repeats: int) -> None:
    random = np.random.default_rng(11)
    labs = 400
    results = [
        fit(lab(random, repeats=repeats, imbalance=imbalance, bias=0.05 * random.standard_normal()))
        for _ in range(labs)
    ]
    errors = np.array([(r.inertia.value - INERTIA) / r.inertia.u for r in results])
    # Three standard deviations of a binomial of 400; few runs tell their own scatter badly, so u is on the long side.
    assert 0.63 < np.mean(np.abs(errors) < 1) < 0.80
    inside = [r.inertia.interval_95[0] <= INERTIA <= r.inertia.interval_95[1] for r in results]
    assert 0.92 < np.mean(inside) < 0.99
    assert abs(errors.mean()) < 3 / math.sqrt(labs) + 0.25 * (imbalance > 0)


def test_unknown_sense_of_an_unloaded_run_is_covered() -> None:
    random = np.random.default_rng(5)
    errors = []
    for _ in range(150):
        result = fit(lab(random, unloaded=True, sensed=False, imbalance=-5e-4))
        errors.append((result.inertia.value - INERTIA) / result.inertia.u)
    assert np.mean(np.abs(errors) < 2) > 0.90


def test_rows_as_independent_would_understate_u() -> None:
    measured = exact(repeats=3)
    alone = replace(
        measured,
        sources=tuple(
            replace(source, groups=np.arange(len(measured.runs))) if source.name != "spin_scale" else source
            for source in measured.sources
        ),
    )
    assert fit(measured).inertia.u > 1.02 * fit(alone).inertia.u


def test_budget_adds_up() -> None:
    result = fit(lab(np.random.default_rng(2), repeats=2))
    assert math.fsum(share.share for share in result.budget) == pytest.approx(1)
    assert math.fsum(share.u_inertia**2 for share in result.budget) == pytest.approx(result.inertia.u**2, rel=1e-9)


@pytest.mark.parametrize(
    ("design", "dof"),
    [
        ({"weights": (0.04,), "rpm": (400.0,)}, 0),
        ({"weights": (0.02, 0.06), "rpm": (400.0,)}, 0),
        ({"weights": (0.04,), "rpm": (400.0,), "repeats": 4}, 3),
        ({"weights": (0.04,)}, 2),
    ],
    ids=["one run", "two runs", "four identical runs", "one torque"],
)
def test_few_exact_runs_give_the_truth_and_a_wide_u(design: dict[str, Any], dof: int) -> None:
    result, balanced = fit(exact(**design)), fit(replace(exact(**design), balanced=True))
    assert result.inertia.value == pytest.approx(INERTIA, rel=2e-4)
    assert result.dof == dof
    if len(design.get("weights", ())) == 1:
        # Half of the 68.3 % interval of a Cauchy of 5 % is 9.2 %.
        assert result.inertia.u / INERTIA == pytest.approx(0.092, rel=0.1)
        assert balanced.inertia.u < 0.3 * result.inertia.u


def test_times_as_short_as_their_error_give_a_finite_answer() -> None:
    random = np.random.default_rng(8)
    short = []
    for _ in range(60):
        with suppress(NoFit):
            short.append(fit(lab(random, weights=(0.2, 0.4), repeats=2, turns=1 / 3, u_time=0.3)).inertia)
    # If the times are mostly error, some labs have no answer.
    assert len(short) > 45
    assert all(0.2 * INERTIA < one.value < 3 * INERTIA and math.isfinite(one.u) for one in short)


def test_a_contradicted_balance_test_changes_nothing() -> None:
    measured = exact(imbalance=6e-3)
    tested = replace(measured, imbalance_u=lambda inertia: 1e-5, imbalance_from="u_imbalance")
    result, free = fit(tested), fit(measured)
    assert result.contradicted_balance == pytest.approx(1e-5)
    assert result.inertia.value == pytest.approx(free.inertia.value, abs=0.2 * free.inertia.u)
    assert result.inertia.u == pytest.approx(free.inertia.u, rel=0.25)


def test_influence_is_what_leaving_out_does() -> None:
    measured = lab(np.random.default_rng(12), repeats=2)
    whole = fit(measured)
    for run in (0, 7, 17):
        changed = fit(measured, left_out=(run,)).inertia.value - whole.inertia.value
        assert whole.influence[run] == pytest.approx(changed, rel=0.1, abs=0.05 * whole.inertia.u)


def odd_runs(table: Table, lines: str = "") -> list[tuple[int, str]]:
    """Flagged runs of a typed log, counted from 0, and the first reason that is given."""
    runs = gyrodata.analyze(write(table, lines).encode()).run_table
    return [(int(run.run) - 1, run.reason.partition("; or ")[0]) for run in runs if run.flagged]


def test_clean_labs_have_no_odd_run() -> None:
    assert [odd_runs(draw(Bench(imbalance=0.02), seed)) for seed in range(60)] == [[]] * 60


@pytest.mark.parametrize("masses", [(20, 40, 60), (20, 40), (20, 60)], ids=str)
def test_one_wrong_count_is_named_with_the_right_one(masses: tuple[int, ...]) -> None:
    for wrong in range(3 * len(masses)):
        table = draw(Bench(masses=masses), wrong)
        table.turns[wrong] = "2"
        # A large M0 would make two good runs odd in its place.
        assert odd_runs(table) == [(wrong, "fits 1 turn, not 2")]


@pytest.mark.parametrize("true", ["1/3", "1/2", "2/3", "2", "3"])
@pytest.mark.parametrize("written", ["1", "7"])
def test_each_likely_count_is_found(true: str, written: str) -> None:
    table = draw(Bench(hand=0.02), 4)
    table.turns[:] = written
    table.time[:] *= float(written)
    table.time[4] *= float(Fraction(true)) / float(written)
    assert odd_runs(table, "# u_time: 0.05 s\n") == [(4, f"fits {true} turn{'s' * (true in '23')}, not {written}")]


def test_gross_errors_kept_in_the_fit_do_not_break_it() -> None:
    # A weak ruler and tight times: a fit by the raw conditions would shrink I_zz and the arm to nothing.
    measured = lab(np.random.default_rng(6), weights=tuple(0.01 * k for k in range(3, 12)), u_zero=0.01)
    turns = measured.turns.copy()
    turns[[3, 4]] = 1.5
    assert 2e-3 < fit(replace(measured, turns=turns)).inertia.value < 8e-3


@pytest.mark.parametrize(
    "bench",
    [Bench(), Bench(masses=(40,)), Bench(masses=(20, 60), spins=(200, 600)), Bench(imbalance=0.1, thirds=True)],
    ids=str,
)
def test_one_more_run_never_raises_the_mean_u(bench: Bench) -> None:
    ratios = []
    for seed in range(25):
        table = draw(bench, seed)
        fewer = Table(*(np.delete(column, seed % len(table.mass)) for column in table))
        before, after = (gyrodata.analyze(write(one).encode()).inertia.u for one in (fewer, table))
        ratios.append(after / before)
    assert np.mean(ratios) < 1.01


def test_uncertainty_agrees_with_gtc() -> None:
    # Two runs and two unknowns: the answer is a formula, and GTC propagates the readings' errors through it.
    from GTC import uncertainty, ureal, value

    measured = replace(lab(np.random.default_rng(2), weights=(0.02, 0.06), rpm=(400.0,)), timing_bias_u=0.0)
    scale, zero = ureal(1, 0.001), ureal(0, 0.0005)
    levers, swings, torques = [], [], []
    for i in range(2):
        spin = float(measured.spin[i])
        levers.append(2 * math.pi * ureal(spin, 0.002 * spin) * scale)
        swings.append(ureal(float(measured.time[i]), 0.14))
        mass = float(measured.mass[i])
        torques.append(ureal(mass, 0.002 * mass) * measured.g * (float(measured.position[i]) + zero))
    # M T = I L − M0 T for both runs.
    efforts = [torque * swing for torque, swing in zip(torques, swings, strict=True)]
    inertia = (efforts[1] * swings[0] - efforts[0] * swings[1]) / (levers[1] * swings[0] - levers[0] * swings[1])
    result = fit_as_stated(measured)
    assert result.inertia.value == pytest.approx(value(inertia), rel=2e-3)  # the broad prior of M0 pulls a little
    assert result.inertia.u == pytest.approx(uncertainty(inertia), rel=2e-2)
