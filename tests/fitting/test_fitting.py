"""The fit: the truth, the same number by other methods, odd runs."""

from __future__ import annotations

import math
from contextlib import suppress
from fractions import Fraction

import numpy as np
import pytest
from gates.drawn_logs import Bench, Table, draw, write
from msgspec.structs import replace
from scipy.optimize import least_squares
from simulated_labs import INERTIA, G, analyze_briefly, lab

import gyrodata
from gyrodata.fitting import AS_STATED, TEXTBOOK, NoFit, fit
from gyrodata.measurements import Measurements
from gyrodata.results import FittedLog


def latent_least_squares(measured: Measurements) -> tuple[float, float]:
    """The same problem by another method: every true reading is an unknown of one big
    least-squares problem.
    """
    count = len(measured.runs)
    time, spin, spin_scale, mass, zero = measured.sources

    def model(p: np.ndarray) -> np.ndarray:
        (inertia, imbalance, bias, e_scale, e_zero), e_spin, e_mass = (
            p[:5],
            p[5 : 5 + count],
            p[5 + count :],
        )
        true_spin = measured.spin / (
            (1 + spin.relative * e_spin) * (1 + spin_scale.relative * e_scale)
        )
        true_mass = measured.mass / (1 + mass.relative * e_mass[list(mass.groups)])
        torque = (
            true_mass * G * (measured.position - zero.absolute * e_zero)
            + imbalance * 1e-3
        )
        predicted = (
            2e-3 * np.pi * measured.turns * inertia * true_spin / np.abs(torque) + bias
        )
        priors = [
            imbalance * 1e-3 / np.abs(measured.torque).min(),
            bias / measured.timing_bias_u,
            *p[3:],
        ]
        return np.concatenate([(measured.time - predicted) / time.absolute, priors])

    start = np.zeros(6 + count + max(mass.groups))
    start[0] = 4.0
    solution = least_squares(
        model, start, method="trf", xtol=1e-15, ftol=1e-15, gtol=1e-15, jac="3-point"
    )
    cov = np.linalg.inv(solution.jac.T @ solution.jac)
    return solution.x[0] * 1e-3, math.sqrt(cov[0, 0]) * 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_agrees_with_least_squares_in_all_true_readings(seed: int) -> None:
    measured = lab(np.random.default_rng(seed), repeats=2, imbalance=2e-3, bias=0.04)
    value, u = latent_least_squares(measured)
    inertia = fit(measured, AS_STATED).inertia
    assert inertia.value == pytest.approx(value, rel=2e-7)
    assert inertia.u == pytest.approx(u, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("repeats", "weights", "close"),
    # Where M0 is hardly told, u is 5 % of I_zz, and nothing is linear.
    [(1, (0.02, 0.04, 0.06), 0.05), (3, (0.1, 0.12), 0.45)],
)
def test_agrees_with_the_posterior_by_plain_integration(
    repeats: int, weights: tuple[float, ...], close: float
) -> None:
    # Times are normal about the model with a covariance that is written down whole;
    # I_zz, M0 and s on a dense grid. The balance is the same for all weights.
    drawn = lab(
        np.random.default_rng(4),
        repeats=repeats,
        weights=weights,
        imbalance=5e-4,
        bias=0.04,
    )
    measured = replace(drawn, balance="untouched")
    result = fit(measured)
    time, spin, spin_scale, mass, zero = measured.sources
    lightest = float(np.abs(measured.torque).min())
    inertias = result.inertia.value + np.linspace(-8, 8, 161) * result.inertia.u
    imbalances = (
        result.residual_torque.value
        + np.linspace(-8, 8, 121) * result.residual_torque.u
    )
    lever = 2 * np.pi * measured.turns * measured.spin
    same = np.equal.outer(np.array(mass.groups), np.array(mass.groups))
    at = lever * result.inertia.value / (measured.torque + result.residual_torque.value)
    by_torque = at * measured.torque / (measured.torque + result.residual_torque.value)
    shared = measured.timing_bias_u**2 + spin_scale.relative[0] ** 2 * np.outer(at, at)
    shared = shared + np.outer(by_torque, by_torque) * (
        mass.relative[0] ** 2 * same + (zero.absolute[0] / 0.15) ** 2
    )
    total = np.zeros(len(inertias))
    predicted = (
        lever * inertias[:, None, None] / (measured.torque + imbalances[:, None])
    )
    residual = measured.time - predicted
    for factor in np.exp(np.linspace(math.log(0.15), math.log(12), 40)):
        covariance = shared + factor**2 * np.diag(
            time.absolute**2 + (spin.relative * at) ** 2
        )
        inverse, (_, size) = np.linalg.inv(covariance), np.linalg.slogdet(covariance)
        chi2 = np.einsum("abi,ij,abj->ab", residual, inverse, residual)
        log_factor = math.log(factor)
        prior = (
            0.95
            * math.exp(-0.5 * (log_factor / math.log(3.5)) ** 2)
            / (math.log(3.5) * math.sqrt(2 * math.pi))
        )
        prior += 0.05 / (math.pi * math.log(5) * (1 + (log_factor / math.log(5)) ** 2))
        cauchy = 1 / (1 + (imbalances / (0.05 * lightest)) ** 2)
        total += prior * (np.exp(-0.5 * (chi2 + size) + 200) * cauchy).sum(axis=1)
    below = (np.cumsum(total) - total / 2) / total.sum()
    told = (
        result.inertia.interval_95[0],
        result.inertia.value,
        result.inertia.interval_95[1],
    )
    off = (
        np.array(told) - np.interp((0.025, 0.5, 0.975), below, inertias)
    ) / result.inertia.u
    assert off == pytest.approx(np.zeros(3), abs=close)


@pytest.mark.parametrize("rpm", [(400.0,), (200.0, 400.0, 600.0)])
def test_the_mean_of_ratios_has_the_standard_error_of_a_mean(
    rpm: tuple[float, ...],
) -> None:
    measured = lab(np.random.default_rng(6), rpm=rpm)
    ratios = measured.torque / measured.product
    expected = np.mean(ratios), np.std(ratios, ddof=1) / math.sqrt(len(ratios))
    # A run without a weight has no ratio.
    product, torque = np.append(measured.product, 1.0), np.append(measured.torque, 0.0)
    for x, y in ((measured.product, measured.torque), (product, torque)):
        assert TEXTBOOK["mean_of_ratios"](x, y) == pytest.approx(expected, rel=1e-12)


@pytest.mark.slow
def test_the_budget_adds_up_to_u() -> None:
    result = gyrodata.analyze(write(draw(Bench(repeats=2), 2)).encode())
    assert math.fsum(share.share for share in result.budget) == pytest.approx(1)
    assert math.fsum(share.u_inertia**2 for share in result.budget) == pytest.approx(
        result.inertia.u**2, rel=1e-9
    )


@pytest.mark.parametrize(
    ("masses", "spins", "repeats", "dof"),
    [((0.04,), (400,), 1, 0), ((0.02, 0.06), (400,), 1, 0), ((0.04,), (400,), 4, 3)],
    ids=["one run", "two runs", "four identical runs"],
)
def test_few_exact_runs_give_the_truth_and_a_wide_u(
    masses: tuple[float, ...], spins: tuple[float, ...], repeats: int, dof: int
) -> None:
    exact = lab(
        np.random.default_rng(0), noise=0.0, weights=masses, rpm=spins, repeats=repeats
    )
    result, balanced = fit(exact), fit(replace(exact, balanced=True))
    assert (result.inertia.value, result.dof) == (pytest.approx(INERTIA, rel=2e-4), dof)
    if len(masses) == 1:
        # Half of the 68.3 % interval of a Cauchy of 5 % is 9.2 %.
        assert result.inertia.u / INERTIA == pytest.approx(0.092, rel=0.1)
        assert balanced.inertia.u < 0.3 * result.inertia.u


@pytest.mark.slow
def test_times_as_short_as_their_error_give_a_finite_answer() -> None:
    random = np.random.default_rng(8)
    short = []
    for _ in range(15):
        with suppress(NoFit):
            short.append(
                fit(
                    lab(random, weights=(0.2, 0.4), repeats=2, turns=1 / 3, u_time=0.3)
                ).inertia
            )
    # If the times are mostly error, some labs have no answer.
    assert len(short) > 10
    assert all(
        0.2 * INERTIA < one.value < 3 * INERTIA and math.isfinite(one.u)
        for one in short
    )


@pytest.mark.slow
def test_a_balance_test_that_says_nothing_or_is_false_changes_nothing() -> None:
    def tested(imbalance: float, line: str) -> FittedLog:
        return analyze_briefly(
            write(draw(Bench(imbalance=imbalance), 3), line).encode()
        )

    free, silent = tested(0.0, ""), tested(0.0, "# u_imbalance: 1000 N*m\n")
    # The widths of M0 are on another grid if there is a test.
    assert silent.inertia.value == pytest.approx(
        free.inertia.value, abs=0.01 * free.inertia.u
    )
    assert silent.inertia.u == pytest.approx(free.inertia.u, rel=0.005)
    untouched, wrong = "# balance: untouched\n", "# u_imbalance: 1e-5 N*m\n"
    free, false = tested(0.2, untouched), tested(0.2, untouched + wrong)
    assert "G412" in {one.code for one in false.diagnostics}
    assert false.inertia.value == pytest.approx(
        free.inertia.value, abs=0.2 * free.inertia.u
    )
    assert false.inertia.u == pytest.approx(free.inertia.u, rel=0.25)
    # Somebody may have touched the balance after the test: u contains both.
    silent = tested(0.2, wrong)
    assert "G412" in {one.code for one in silent.diagnostics}
    low, high = silent.inertia.interval_95
    assert low < INERTIA < high


def odd_runs(table: Table, lines: str = "") -> list[tuple[int, str]]:
    """Flagged runs of a typed log, counted from 0, and the first reason that is given."""
    log = write(table, f"# motion: steady\n{lines}")
    runs = analyze_briefly(log.encode()).run_table
    return [
        (int(run.run) - 1, run.reason.partition("; or ")[0])
        for run in runs
        if run.flagged
    ]


@pytest.mark.slow
def test_clean_labs_have_no_odd_run() -> None:
    assert [odd_runs(draw(Bench(imbalance=0.02), seed)) for seed in range(20)] == [
        []
    ] * 20


@pytest.mark.slow
@pytest.mark.parametrize("masses", [(20, 40, 60), (20, 60)], ids=str)
def test_one_wrong_count_is_named_with_the_right_one(masses: tuple[int, ...]) -> None:
    for wrong in range(0, 3 * len(masses), 4):
        table = draw(Bench(masses=masses), wrong)
        table.turns[wrong] = "2"
        # A large M0 would make two good runs odd in its place.
        assert odd_runs(table) == [(wrong, "fits 1 turn, not 2")]


@pytest.mark.slow
@pytest.mark.parametrize(("true", "written"), [("1/3", "1"), ("2/3", "7"), ("3", "1")])
def test_each_likely_count_is_found(true: str, written: str) -> None:
    table = draw(Bench(hand=0.02), 4)
    table.turns[:] = written
    table.time[:] *= float(written)
    table.time[4] *= float(Fraction(true)) / float(written)
    assert odd_runs(table, "# u_time: 0.05 s\n") == [
        (4, f"fits {true} turn{'s' * (true in '23')}, not {written}")
    ]


def without(table: Table, run: int, lines: str) -> FittedLog:
    return analyze_briefly(
        write(Table(*(np.delete(column, run) for column in table)), lines).encode()
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lines", "close"),
    # One run can also change how much the weights seem to differ.
    [("# balance: untouched\n", 0.05), ("", 0.08)],
)
def test_influence_is_what_leaving_the_run_out_does(lines: str, close: float) -> None:
    table = draw(Bench(repeats=2), 12)
    whole = analyze_briefly(write(table, lines).encode())
    for run in (0, 7, 17):
        changed = without(table, run, lines).inertia.value - whole.inertia.value
        assert whole.run_table[run].influence == pytest.approx(
            changed, rel=0.1, abs=close * whole.inertia.u
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    "bench",
    [
        Bench(),
        Bench(masses=(40,)),
        Bench(masses=(20, 60), spins=(200, 600)),
        Bench(imbalance=0.1, thirds=True),
    ],
    ids=["9 runs", "one torque", "4 runs", "thirds of a turn"],
)
def test_one_more_run_never_raises_the_mean_u(bench: Bench) -> None:
    ratios = []
    steady = "# motion: steady\n"
    for seed in range(6):
        table = draw(bench, seed)
        after = analyze_briefly(write(table, steady).encode()).inertia.u
        before = without(table, seed % len(table.mass), steady).inertia.u
        ratios.append(after / before)
    assert np.mean(ratios) < 1.01


def test_value_and_uncertainty_agree_with_gtc() -> None:
    # Two runs and two unknowns: M T = I L − M0 T is solved, and GTC propagates the
    # readings' errors through it.
    from GTC import uncertainty, ureal, value

    measured = replace(
        lab(np.random.default_rng(2), weights=(0.02, 0.06), rpm=(400.0,)),
        timing_bias_u=0.0,
    )
    scale, arm = ureal(1, 0.001), float(measured.position[0]) + ureal(0, 0.0005)
    levers = [
        2 * math.pi * ureal(spin, 0.002 * spin) * scale
        for spin in measured.spin.tolist()
    ]
    swings = [ureal(time, 0.14) for time in measured.time.tolist()]
    torques = [ureal(mass, 0.002 * mass) * G * arm for mass in measured.mass.tolist()]
    efforts = [torque * swing for torque, swing in zip(torques, swings, strict=True)]
    exact = (efforts[1] * swings[0] - efforts[0] * swings[1]) / (
        levers[1] * swings[0] - levers[0] * swings[1]
    )
    inertia = fit(measured, AS_STATED).inertia
    assert inertia.value == pytest.approx(value(exact), rel=1e-4)
    assert inertia.u == pytest.approx(uncertainty(exact), rel=1e-3)
