"""The laws of the report and the solid ball: the same numbers by another method."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from labs import lab as draw
from msgspec.structs import replace
from scipy import stats

import gyrodata
from gyrodata import fitting
from gyrodata.comparisons import CHANCE, Pattern, list_sensitivity, look_for_patterns, pattern_words, torque_table
from gyrodata.diagnostics import CODES
from gyrodata.fitting import Estimate, fit
from gyrodata.measurements import Measurements, select

HEAD = "# g: 9.803 m/s^2\n# u_time: 0.1 s\n# u_spin: 0.2 %\n# u_time_bias: 0.05 s\n"
ROWS = """mass [g],position [cm],spin [rpm],time [s],turns
20.00,15.0,206,20.4,1
20.00,15.0,407,40.4,1
20.00,15.0,601,59.5,1
40.00,15.0,203,10.2,1
40.00,15.0,405,20.1,1
60.00,15.0,201,13.6,2
60.00,15.0,404,13.4,1
0,,404,300,1/3
"""


def own(lab: gyrodata.Analysis) -> np.ndarray:
    """Relative u of time and spin of each run, by hand: 0.1 s and 0.2 %."""
    return np.hypot(0.1 / lab.measurements.time, 0.002)


def test_one_exponent_for_all_torques_is_the_line_with_a_constant_for_each() -> None:
    lab = gyrodata.analyze((HEAD + ROWS).encode())
    assert lab.exponent is not None
    kept = lab.runs[lab.runs["torque"] != 0].index
    spin, period, time = (lab.runs[name].to_numpy()[kept] for name in ("spin", "period", "time"))
    torques = lab.runs["torque"].to_numpy()[kept]
    design = np.column_stack([np.log(spin), *((torques == torque).astype(float) for torque in np.unique(torques))])
    covariance = np.diag(own(lab)[kept] ** 2)
    weight = np.linalg.inv(covariance)
    solve = np.linalg.inv(design.T @ weight @ design) @ design.T @ weight
    assert lab.exponent.value == pytest.approx((solve @ np.log(period))[0], rel=1e-9)
    covariance = covariance + 0.05**2 * np.outer(1 / time, 1 / time)
    assert lab.exponent.u == pytest.approx(math.sqrt((solve @ covariance @ solve.T)[0, 0]), rel=1e-9)
    assert lab.exponent.torques == 3
    assert lab.exponent.deviation == pytest.approx((lab.exponent.value - 1) / lab.exponent.u)


def test_one_torque_has_one_exponent() -> None:
    lab = gyrodata.analyze((HEAD + "\n".join(ROWS.splitlines()[:4])).encode())
    assert lab.exponent is not None
    assert (lab.power_law[0].exponent, lab.power_law[0].u) == pytest.approx((lab.exponent.value, lab.exponent.u))


def test_constancy_is_the_scatter_about_each_mean_against_timing_and_spin() -> None:
    lab = gyrodata.analyze((HEAD + ROWS).encode())
    assert lab.constancy is not None
    products, groups = lab.runs["product"].to_numpy(), lab.runs["torque"].to_numpy()
    squares, chi2, variances = 0.0, 0.0, []
    for torque in np.unique(groups[groups != 0]):
        values, u = products[groups == torque], own(lab)[groups == torque]
        mean = np.sum(values / (u * values) ** 2) / np.sum(1 / (u * values) ** 2)
        squares += np.sum((values / mean - 1) ** 2)
        chi2 += np.sum(((values - mean) / (u * values)) ** 2)
        variances += list(u**2)
    assert lab.constancy.dof == 4
    assert lab.constancy.scatter == pytest.approx(math.sqrt(squares / 4))
    assert lab.constancy.expected == pytest.approx(math.sqrt(np.mean(variances)))
    assert lab.constancy.p == pytest.approx(stats.chi2.sf(chi2, 4), rel=1e-6)


def test_the_slope_of_the_period_is_that_of_its_product() -> None:
    lab = gyrodata.analyze((HEAD + ROWS).encode())
    group = lab.torques[0]
    assert group.period_per_spin == pytest.approx(2 * math.pi / group.product)
    assert group.period_per_spin_u / group.period_per_spin == pytest.approx(group.product_u / group.product)
    run = lab.run_table[0]
    assert run.period / run.spin == pytest.approx(group.period_per_spin, rel=0.02)


@pytest.mark.parametrize(
    ("lines", "relative"),
    [
        ("# ball_mass: 4.10 ± 0.02 kg\n# ball_diameter: 10.16 ± 0.01 cm\n", math.hypot(0.02 / 4.1, 2 * 0.01 / 10.16)),
        ("# ball_mass: 4.10 kg\n# u_ball_mass: 20 g\n# ball_diameter: 10.16 cm\n", 0.02 / 4.1),
        ("# ball_mass: 4.10 kg\n# ball_diameter: 10.16 cm\n# u_ball_diameter: 0.1 %\n", 0.002),
    ],
)
def test_the_ball_has_an_uncertainty_of_its_own(lines: str, relative: float) -> None:
    lab = gyrodata.analyze((HEAD + lines + ROWS).encode())
    ball = lab.ball
    assert ball is not None
    assert ball.inertia == pytest.approx(0.4 * 4.1 * 0.0508**2)
    assert ball.inertia_u == pytest.approx(ball.inertia * relative)
    assert lab.inertia.u is not None
    assert ball.difference_u == pytest.approx(math.hypot(lab.inertia.u, ball.inertia * relative))
    assert ball.deviation == pytest.approx((lab.inertia.value - ball.inertia) / ball.difference_u)
    assert ball.relative == pytest.approx(lab.inertia.value / ball.inertia - 1)


def test_a_ball_without_u_is_taken_as_exact_and_none_is_not_compared() -> None:
    ball = gyrodata.analyze((HEAD + "# ball_mass: 4.1 kg\n# ball_diameter: 10.16 cm\n" + ROWS).encode()).ball
    assert ball is not None
    assert (ball.mass_u, ball.diameter_u, ball.inertia_u) == (None, None, None)
    assert ball.deviation is not None
    assert gyrodata.analyze((HEAD + "# ball_mass: 4.1 kg\n" + ROWS).encode()).ball is None


def test_other_fits_say_how_far_they_lie() -> None:
    lab = gyrodata.analyze((HEAD + ROWS).encode())
    recommended, origin, _ = lab.fits
    assert recommended.difference is None
    assert origin.inertia is not None
    assert lab.inertia.u is not None
    assert origin.difference == pytest.approx(origin.inertia.value / lab.inertia.value - 1)
    assert origin.deviation == pytest.approx((origin.inertia.value - lab.inertia.value) / lab.inertia.u)


def patterns(measured: Measurements) -> tuple[Pattern, ...]:
    return look_for_patterns(measured, fitting.fit(measured))


def told(measured: Measurements) -> str:
    """Name of the pattern that a diagnostic would tell, or none."""
    found = patterns(measured)
    return found[0].name if found and found[0].p_corrected < CHANCE else ""


def drifting(random: np.random.Generator) -> Measurements:
    """M0 goes from -5 % to +5 % of the lightest torque, the runs in mixed order."""
    measured = draw(random)
    measured = select(measured, np.random.default_rng(5).permutation(len(measured.runs)).tolist())
    drift = 0.05 * measured.torque.min() * np.linspace(-1, 1, len(measured.runs))
    return replace(measured, time=measured.time * measured.torque / (measured.torque + drift))


def mislabelled(random: np.random.Generator) -> Measurements:
    """The second of four weights is 10 % heavier than its label says."""
    measured = draw(random, weights=(0.02, 0.04, 0.06, 0.08))
    light = np.where(np.arange(12) // 3 == 1, 1 / 1.1, 1.0)
    return replace(measured, mass=measured.mass * light, torque=measured.torque * light)


def late(random: np.random.Generator) -> Measurements:
    return draw(random, repeats=3, bias=0.5)


class TestPatterns:
    @pytest.mark.parametrize("runs", [{}, {"repeats": 3}, {"unloaded": True, "imbalance": 1e-3}], ids=str)
    def test_labs_without_one_are_left_in_peace(self, runs: dict[str, float]) -> None:
        labs = [draw(np.random.default_rng((3, seed)), **runs) for seed in range(60)]  # type: ignore[arg-type]
        assert sum(told(lab) != "" for lab in labs) <= 3

    def test_each_chance_by_itself_is_uniform(self) -> None:
        chances: dict[str, list[float]] = {}
        for seed in range(150):
            for pattern in patterns(draw(np.random.default_rng((4, seed)), repeats=2)):
                chances.setdefault(pattern.name, []).append(pattern.p)
        assert {"spin", "time_bias", "mass", "agreement"} <= set(chances)
        for name, found in chances.items():
            assert stats.kstest(found, "uniform").pvalue > 1e-3, name

    @pytest.mark.parametrize(("name", "slip"), [("order", drifting), ("mass", mislabelled), ("time_bias", late)])
    def test_the_cause_is_named(self, name: str, slip: Callable[[np.random.Generator], Measurements]) -> None:
        labs = [slip(np.random.default_rng((5, seed))) for seed in range(25)]
        assert sum(told(lab) == name for lab in labs) >= 20

    def test_sizes_are_those_of_the_slips(self) -> None:
        random = np.random.default_rng(6)
        label = next(one for one in patterns(mislabelled(random)) if one.of.startswith(("36", "37")))
        assert label.size == pytest.approx(-0.1, abs=0.04)
        assert "% more" in pattern_words(label)[0]
        hand = next(one for one in patterns(late(random)) if one.name == "time_bias")
        assert hand.size == pytest.approx(0.5, abs=0.25)
        assert "the hand is later than stated" in pattern_words(hand)[0]
        drift = next(one for one in patterns(drifting(random)) if one.name == "order")
        assert drift.size == pytest.approx(0.1 * 0.02 * 9.803 * 0.15, rel=0.4)

    def test_a_pull_is_the_adjusted_value_over_what_is_known_now_and_was_not_before(self) -> None:
        measured = draw(np.random.default_rng(7), repeats=3, bias=0.3)
        fit = fitting.fit(measured)
        pull = next(one.statistic for one in patterns(measured) if one.name == "time_bias")
        value, posterior = fit.adjusted.unknowns[2], fit.adjusted.covariance[2, 2]
        assert abs(pull) == pytest.approx(abs(value) / math.sqrt(0.05**2 - posterior), rel=0.2)

    @pytest.mark.parametrize("seed", range(4))
    def test_a_pattern_is_what_one_more_unknown_takes_off_chi_square(self, seed: int) -> None:
        measured = draw(np.random.default_rng(seed), repeats=1 + seed % 2, bias=0.1)
        fit = fitting.fit(measured)
        adjusted, count = fit.adjusted, len(measured.runs)
        shared = len(adjusted.shared)
        priors = np.eye(3 + shared)[1:]
        moved = [*adjusted.unknowns[1:] / adjusted.scale[1:], *adjusted.shared]
        column = adjusted.rows[:, 1] * np.linspace(-0.5, 0.5, count)
        likely, drops = [], []
        for s in np.exp(np.linspace(math.log(0.2), math.log(20), 24)):
            wider = fit.scatter / s
            target = np.concatenate([-wider * adjusted.weighted, np.negative(moved)])
            rows = np.vstack([wider * adjusted.rows, priors])
            more = np.column_stack([rows, np.concatenate([wider * column, np.zeros(len(priors))])])
            without, within = (np.linalg.lstsq(design, target, rcond=None)[1][0] for design in (rows, more))
            drops.append(without - within)
            chance = float(fitting.scatter_prior(np.log([s]), fitting.times_stated(measured))[0])
            likely.append(chance - count * math.log(s) - 0.5 * (np.linalg.slogdet(more.T @ more)[1] + within))
        weight = np.exp(np.array(likely) - max(likely))
        drift = next(one for one in look_for_patterns(measured, fit) if one.name == "order")
        assert drift.statistic**2 == pytest.approx(drops[int(np.argmax(weight))], rel=1e-6, abs=1e-9)
        p = sum(w * math.erfc(math.sqrt(max(z2, 0.0) / 2)) for w, z2 in zip(weight, drops, strict=True)) / weight.sum()
        assert drift.p == pytest.approx(p, rel=1e-6)

    def test_runs_that_agree_too_well_are_told(self) -> None:
        measured = draw(np.random.default_rng(8), repeats=3, noise=0.1)
        assert told(measured) == "agreement"
        (agreement,) = [one for one in patterns(measured) if one.name == "agreement"]
        assert agreement.size is None
        assert agreement.statistic < 0.1

    def test_the_json_has_them_all_with_holm_s_correction(self) -> None:
        result = gyrodata.analyze((HEAD + ROWS).encode()).to_dict()["result"]
        chances = [one["p"] for one in result["patterns"]]
        assert chances == sorted(chances)
        assert result["patterns"][0]["p_corrected"] == pytest.approx(min(1, chances[0] * len(chances)))
        assert two_runs()["patterns"] == []


def two_runs() -> dict[str, object]:
    return gyrodata.analyze((HEAD + "\n".join(ROWS.splitlines()[:3])).encode()).to_dict()["result"]  # type: ignore[no-any-return]


def test_one_run_whose_spin_falls_alone_is_named() -> None:
    header, *rows = CODES["G434"].example.splitlines()[1:]
    log = "\n".join([header, *rows])
    assert [d.message[:5] for d in gyrodata.analyze(log.encode()).diagnostics if d.code == "G434"] == ["run 3"]
    calm = log.replace("410,360", "410,405")
    assert "G434" not in {d.code for d in gyrodata.analyze(calm.encode()).diagnostics}


def refits(measured: Measurements, monkeypatch: pytest.MonkeyPatch) -> dict[str, Estimate]:
    """What `list_sensitivity` says, each by a fit of its own to a log in which that is so."""
    twice = tuple(
        replace(one, absolute=2 * one.absolute, relative=2 * one.relative) if one.quantity == "time" else one
        for one in measured.sources
    )
    found = {"u_time_twice": fit(replace(measured, sources=twice)).inertia}
    for name, late in (("hand_late", 0.1), ("hand_early", -0.1)):
        found[name] = fit(replace(measured, time=measured.time - late, timing_bias_u=0.0)).inertia
    for name, scale in (("balanced", 1e-6), ("balance_free", 1.0)):
        with monkeypatch.context() as patch:
            patch.setattr("gyrodata.fitting.inertia.BALANCE", scale)
            found[name] = fit(measured).inertia
    return found


@pytest.mark.parametrize("tested", [None, 1e-4])
def test_what_the_answer_hangs_on_is_what_a_fit_of_its_own_finds(
    tested: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = draw(np.random.default_rng(2), imbalance=2e-3 if tested is None else 1e-4)
    measured = drawn if tested is None else replace(drawn, imbalance_u=lambda inertia: tested)
    result, kept = fit(measured), list(range(9))
    torques = torque_table(measured, result, kept, False)
    rows = {row.words: row for row in list_sensitivity(measured, result, torques, kept)}
    named = {row.name: row.inertia for row in rows.values()}
    for name, expected in refits(replace(measured, imbalance_u=None), monkeypatch).items():
        if tested is not None and not name.startswith("balance"):
            continue
        inertia = named[name]
        assert inertia is not None
        # A balance that the runs deny is far from where the fit is linear.
        close = 0.2 if name == "balanced" else 0.1
        assert inertia.value == pytest.approx(expected.value, abs=close * expected.u), name
        assert inertia.u == pytest.approx(expected.u, rel=0.05), name
    for row in rows.values():
        assert row.inertia is not None
        assert row.deviation == pytest.approx((row.inertia.value - result.inertia.value) / result.inertia.u)
    assert [row.inertia for row in rows.values() if row.name == "without"] == [torque.without for torque in torques]


def test_what_the_runs_deny_has_no_answer() -> None:
    # With no weight on the rod it precesses, which a perfect balance denies, however far off the other runs are.
    exact = {"u_time_bias": "0.05 s", "u_angle": "0 deg", "u_spin_delay": "0 s"}
    denied = gyrodata.analyze("sample_data/air_gyroscope.csv", settings=exact)
    rows = {row.name: row for row in denied.sensitivity}
    assert rows["balanced"].inertia is None
    assert rows["balanced"].deviation is None
    assert rows["balance_free"].inertia is not None


def test_one_torque_hangs_on_the_balance_and_on_no_weight() -> None:
    one = gyrodata.analyze((HEAD + "\n".join(ROWS.splitlines()[:4])).encode())
    rows = {row.name: row for row in one.sensitivity}
    assert rows["balance_free"].inertia is None
    assert rows["balanced"].inertia is not None
    assert one.if_balanced is not None
    assert rows["balanced"].inertia.u < one.if_balanced.u < one.inertia.u
    assert "without" not in rows
    assert gyrodata.analyze((HEAD + ROWS).encode()).if_balanced is None


def test_a_log_of_rates_has_no_hand() -> None:
    rates = "mass [g],position [cm],spin [rpm],precession_rate [deg/s]\n20,15,206,17.7\n40,15,405,17.9\n"
    names = {row.name for row in gyrodata.analyze(rates.encode()).sensitivity}
    assert names == {"balanced", "balance_free", "without"}


@pytest.mark.parametrize("given", ["bore", "rod", "disk", "bore, rod", "disk alone"])
def test_what_spins_may_have_a_bore_a_rod_and_a_disk(given: str) -> None:
    lines = {
        "ball": "# ball_mass: 4.3 kg\n# ball_diameter: 10.16 cm\n",
        "bore": "# bore_diameter: 2 cm\n# bore_depth: 4 cm\n",
        "rod": "# rod_mass: 0.2 kg\n# rod_diameter: 2 cm\n",
        "disk": "# disk_mass: 0.5 kg\n# disk_diameter: 8 cm\n",
    }
    alone = given == "disk alone"
    parts = ["disk"] if alone else ["ball", *given.split(", ")]
    found = gyrodata.analyze("".join([*(lines[part] for part in parts), HEAD, ROWS]).encode()).ball
    assert found is not None
    solid, radius = 0.4 * 4.3 * 0.0508**2, 0.0508
    # The bored ball's mass is what was weighed: its steel is denser than that of a whole ball of this mass.
    bore = np.pi * 0.01**2 * 0.04
    density = 4.3 / (4 / 3 * np.pi * radius**3 - bore)
    bored = density * (8 / 15 * np.pi * radius**5 - 0.5 * bore * 0.01**2) - solid
    expected = {"ball": solid, "bore": bored, "rod": 0.5 * 0.2 * 0.01**2, "disk": 0.5 * 0.5 * 0.04**2}
    assert found.inertia == pytest.approx(sum(expected[part] for part in parts), rel=1e-9)
    assert found.bore == (pytest.approx(expected["bore"]) if "bore" in parts else 0.0)
    assert expected["bore"] > 0
    assert (found.mass is None) == (found.solid is None) == alone
