"""Known slips: each is found in reports that students would write, and no honest report is ever given one."""

from __future__ import annotations

import numpy as np
import pytest
from grading.reports import RIGHT, SLIPS, Formula, Sheet, reported_line, sheet

from gyrodata.analysis import analyze_readings
from gyrodata.grading import ACCEPTED, Slip, find_slips, own_runs
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


class TestTwoThatLeaveTheSameFactor:
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
    def test_near_an_honest_answer(self) -> None:
        # All but one run cover whole turns: forgetting the turns changes less than the fits differ.
        rows = sheet(np.random.default_rng(5), turns=1.0)
        turns = rows.turns.copy()
        turns[0] = 2 / 3
        rows = Sheet(rows.mass, rows.position, rows.spin, rows.time * turns, turns)
        value, u = SLIPS["turns_forgotten"].inertia(rows, "through_origin")
        assert value / RIGHT.inertia(rows, "through_origin")[0] == pytest.approx(1, abs=0.06)
        assert slips_in(rows, value, u) == ()

    def test_for_any_odd_factor(self, rows: Sheet) -> None:
        for factor in (1.3, 0.77, 3.3, 17.0, 0.004):
            value, u = Formula(answer=factor).inertia(rows, "through_origin")
            assert slips_in(rows, value, u) == ()

    def test_where_whole_turns_were_timed_none_was_forgotten(self) -> None:
        rows = sheet(np.random.default_rng(5), turns=1.0)
        value, u = Formula(answer=1 / 3).inertia(rows, "through_origin")
        assert slips_in(rows, value, u) == ()


def test_own_fits_agree_with_least_squares_by_numpy(rows: Sheet) -> None:
    analysis, _ = read(rows)
    own = {value.name: value for value in own_runs(analysis, ACCEPTED).values}
    for fit in TEXTBOOK:
        value, u = RIGHT.inertia(rows, fit)
        assert own[fit].value == pytest.approx(value, rel=1e-12)
        assert own[fit].u == pytest.approx(u, rel=1e-9)
