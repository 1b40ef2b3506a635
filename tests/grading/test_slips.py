"""Known slips: each is found in reports that students would write, and no honest report is ever given one."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from grading.reports import RIGHT, SLIPS, Formula, Sheet, reported_line, sheet

from gyrodata.analysis import analyze_readings
from gyrodata.grading import ACCEPTED, Slip, distance, find_slips, own_runs
from gyrodata.readings import Reported, read_log
from gyrodata.results import Analysis

TEXTBOOK = ("through_origin", "with_constant", "mean_of_ratios")


def read(rows: Sheet, *head: str) -> tuple[Analysis, Reported | None]:
    readings = read_log(rows.log(*head).encode(), name="log.csv")
    return analyze_readings(readings), readings.reported.get("inertia")


def slips_in(rows: Sheet, value: float, u: float, digits: int = 2) -> tuple[Slip, ...]:
    analysis, reported = read(rows, reported_line(value, u, digits))
    assert reported is not None
    assert reported.value is not None
    own = own_runs(analysis, ACCEPTED)
    return find_slips(reported.value, reported.step or 0.0, own, analysis.readings, analysis.measurements)


@pytest.fixture(scope="module")
def rows() -> Sheet:
    return sheet(np.random.default_rng(3), turns="mixed", imbalance=0.0006, bias=0.03)


@pytest.mark.parametrize("kind", SLIPS)
@pytest.mark.parametrize("fit", TEXTBOOK)
def test_each_is_found_in_the_numbers_that_it_leaves(rows: Sheet, kind: str, fit: str) -> None:
    value, u = SLIPS[kind].inertia(rows, fit)
    found = slips_in(rows, value, u)
    assert kind in [slip.kind for slip in found]
    right, _ = RIGHT.inertia(rows, fit)
    best = next(slip for slip in found if slip.kind == kind)
    assert value / best.factor == pytest.approx(right, rel=0.03)
    assert best.words
    assert best.check
    assert best.distance < 1


@pytest.mark.parametrize("kind", ["rpm_as_rad_s", "g_as_kg", "cm_as_m", "turns_forgotten", "diameter_for_radius"])
def test_the_best_explanation_is_the_true_one_in_many_labs(kind: str) -> None:
    random = np.random.default_rng(29)
    best = []
    for k in range(8):
        rows = sheet(random, turns="mixed" if k % 2 else 1 / 3, imbalance=0.0008 * (k % 3))
        # Thirds of a turn in step with the weights and then forgotten leave points without a slope.
        fit = TEXTBOOK[2 * (k % 4 // 2) if k % 2 else k % 3]
        found = slips_in(rows, *SLIPS[kind].inertia(rows, fit))
        best.append(found[0].kind if found else None)
    assert best == [kind] * 8


class TestHonestReports:
    """The larger study: 0 of 1800 reports rounded to one or two digits of u, from 300 labs of three designs with
    imbalances up to 10 % of the lightest torque; 0 of 900 read off a hand-drawn line (3 % off)."""

    def test_are_never_given_a_slip(self) -> None:
        random = np.random.default_rng(11)
        named = []
        for k in range(24):
            weights = ((0.02, 0.04, 0.06), (0.05, 0.1), (0.02, 0.03, 0.05, 0.08))[k % 3]
            turns: float | str = "mixed" if k % 6 == 0 else (1 / 3, 1.0)[k % 2]
            rows = sheet(random, turns, weights=weights, imbalance=(0.0, 0.001, 0.003, -0.002)[k % 4], bias=0.1)
            analysis, _ = read(rows)
            own = own_runs(analysis, ACCEPTED)
            for fit in TEXTBOOK:
                value, u = RIGHT.inertia(rows, fit)
                for report in (value, float(f"{value:.1e}"), value + u * random.uniform(-1, 1)):
                    named += find_slips(report, u / 10, own, analysis.readings, analysis.measurements)
        assert named == []

    def test_match_the_fit_that_was_used_to_the_digits_reported(self, rows: Sheet) -> None:
        analysis, _ = read(rows)
        own = {value.name: value for value in own_runs(analysis, ACCEPTED).values}
        for fit in TEXTBOOK:
            value, u = RIGHT.inertia(rows, fit)
            assert own[fit].value == pytest.approx(value, rel=1e-12)
            assert own[fit].u == pytest.approx(u, rel=1e-9)


class TestTwoThatLeaveTheSameFactor:
    def test_are_told_both(self) -> None:
        random = np.random.default_rng(7)
        told = set()
        for _ in range(12):
            rows = sheet(random, turns=1 / 3, imbalance=0.001)
            told |= {tuple(slip.kind for slip in slips_in(rows, *SLIPS["missing_g"].inertia(rows, "with_constant"), 1))}
        assert any({"missing_g", "rpm_as_rad_s"} <= set(kinds) for kinds in told)

    def test_the_log_s_units_decide_where_only_they_can(self, rows: Sheet) -> None:
        value, u = SLIPS["g_as_kg"].inertia(rows, "through_origin")
        # Positions are in cm here, so that millimetres taken as metres are not what happened.
        assert [slip.kind for slip in slips_in(rows, value, u)] == ["g_as_kg", "exponent_lost"]
        text = rows.log().replace("position [cm]", "position [mm]")
        text = "".join(
            line if line[0] in "#m" else line.replace(",15.00,", ",150.0,").replace(",15.10,", ",151.0,")
            for line in text.splitlines(keepends=True)
        )
        readings = read_log(text.encode(), name="log.csv")
        analysis = analyze_readings(readings)
        found = find_slips(value, u / 10, own_runs(analysis, ACCEPTED), readings, analysis.measurements)
        assert {slip.kind for slip in found} == {"g_as_kg", "mm_as_m", "exponent_lost"}


class TestNoSlipIsNamed:
    def test_where_no_two_can_have_been_made_together(self) -> None:
        rows = [(0.0295, spin, 6.31 * spin) for spin in (3.3, 6.7, 10.0)]
        rows += [(0.059, spin, 3.16 * spin) for spin in (3.3, 6.7, 10.1)]
        log = "torque [N*m],spin [Hz],time [s],turns\n" + "".join(f"{m},{n},{t:.2f},1\n" for m, n, t in rows)
        analysis = analyze_readings(read_log(log.encode(), name="log.csv"))
        own = own_runs(analysis, ACCEPTED)
        assert find_slips(1.7 * analysis.inertia.value, 1e-6, own, analysis.readings, analysis.measurements) == ()

    def test_near_an_honest_answer(self) -> None:
        # All but one run cover whole turns: forgetting the turns changes less than the fits differ.
        rows = sheet(np.random.default_rng(5), turns=1.0)
        turns = rows.turns.copy()
        turns[0] = 2 / 3
        rows = Sheet(rows.mass, rows.position, rows.spin, rows.time * turns, turns)
        value, u = SLIPS["turns_forgotten"].inertia(rows, "through_origin")
        assert value / RIGHT.inertia(rows, "through_origin")[0] == pytest.approx(1, abs=0.06)
        assert slips_in(rows, value, u) == ()

    @pytest.mark.parametrize(("at", "turns_there", "side"), [(0, 2 / 3, -1), (4, 4 / 3, 1)])
    def test_where_what_it_leaves_lies_among_honest_answers(self, at: int, turns_there: float, side: int) -> None:
        rows = sheet(np.random.default_rng(5), turns=1.0)
        turns = rows.turns.copy()
        turns[at] = turns_there
        rows = Sheet(rows.mass, rows.position, rows.spin, rows.time * turns, turns)
        analysis, _ = read(rows)
        own = own_runs(analysis, ("through_origin",))
        right, unit = own.values[0].value, own.yardstick * own.values[0].value
        value, _ = SLIPS["turns_forgotten"].inertia(rows, "through_origin")
        assert 1.2 < side * (value - right) / unit < 3
        report = value + side * 1.9 * unit
        assert abs(report - right) > 3 * unit
        assert find_slips(report, 0.0, own, analysis.readings, analysis.measurements) == ()

    def test_for_any_odd_factor(self, rows: Sheet) -> None:
        for factor in (1.3, 0.77, 3.3, 17.0, 0.004):
            value, u = Formula(answer=factor).inertia(rows, "through_origin")
            assert slips_in(rows, value, u) == ()

    def test_where_whole_turns_were_timed_none_was_forgotten(self) -> None:
        rows = sheet(np.random.default_rng(5), turns=1.0)
        value, u = Formula(answer=1 / 3).inertia(rows, "through_origin")
        assert slips_in(rows, value, u) == ()

    def test_for_a_report_of_nothing(self, rows: Sheet) -> None:
        analysis, _ = read(rows)
        own = own_runs(analysis, ACCEPTED)
        assert find_slips(0.0, 1e-3, own, analysis.readings, analysis.measurements) == ()


class TestDistance:
    def test_rounding_to_the_digits_reported_costs_nothing(self) -> None:
        for digits in range(1, 8):
            text = f"{4.4372819e-3:.{digits - 1}e}"
            assert distance(float(text), 4.4372819e-3, 10.0 ** (-2 - digits), 0.01) == 0

    def test_half_of_the_last_digit_is_rounding_whatever_a_float_makes_of_it(self) -> None:
        assert [distance(float(f"{k}.5e-5"), k * 1e-5, 1e-5, 0.01) for k in range(100, 200)] == [0] * 100
        assert distance(4.45e-3, 4.44e-3, 1e-5, 0.01) == pytest.approx(0.5 / 4.44)

    def test_it_grows_with_the_difference(self) -> None:
        away = [distance(4.44e-3 * (1 + k / 1000), 4.44e-3, 1e-6, 0.01) for k in range(100)]
        assert all(near <= far for near, far in pairwise(away))

    def test_a_value_rounded_to_nothing_is_not_near(self) -> None:
        assert distance(0.0, 4.44e-3, 0.01, 0.01) == pytest.approx(100)


class TestOwnRuns:
    def test_the_yardstick_is_u_of_the_recommended_fit_within_bounds(self, rows: Sheet) -> None:
        analysis, _ = read(rows)
        u = analysis.inertia.u
        assert u is not None
        assert own_runs(analysis, ACCEPTED).yardstick == pytest.approx(u / analysis.inertia.value)
        exact = "u_time_bias: 0 s", "u_spin_delay: 0 s", "u_turns: 0 %", "u_position_zero: 0 mm", "u_mass: 0 %"
        fine = sheet(np.random.default_rng(3), noise=0.0)
        sharp, _ = read(fine, "# u_time: 0.01 s", *(f"# {line}" for line in exact), "# balanced: yes")
        assert (sharp.inertia.u or 0.0) < 0.005 * sharp.inertia.value
        assert own_runs(sharp, ACCEPTED).yardstick == 0.005
        blunt, _ = read(rows, "# u_time: 9 s")
        assert own_runs(blunt, ACCEPTED).yardstick == 0.05

    def test_a_miscounted_run_may_be_in_or_out(self) -> None:
        rows = sheet(np.random.default_rng(5))
        turns = rows.turns.copy()
        turns[4] = 2
        wrong = Sheet(rows.mass, rows.position, rows.spin, rows.time, turns)
        analysis, _ = read(wrong)
        values = {value.name: value.value for value in own_runs(analysis, ACCEPTED).values}
        assert {"through_origin", "through_origin:all", "mean_of_ratios:all"} <= set(values)
        assert values["mean_of_ratios:all"] == pytest.approx(RIGHT.inertia(wrong, "mean_of_ratios")[0])
        assert own_runs(analysis, ACCEPTED).values[-1].name.endswith(":all")

    def test_one_torque_leaves_no_line_with_a_constant(self) -> None:
        rows = sheet(np.random.default_rng(5), weights=(0.04,))
        analysis, _ = read(rows)
        assert [value.name for value in own_runs(analysis, ("with_constant",)).values] == ["recommended"]
        assert "with_constant" not in [value.name for value in own_runs(analysis, ACCEPTED).values]
