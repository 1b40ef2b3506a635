"""From a submission to points: what is judged, what cannot be, and that nothing a student writes stops it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from grading.reports import RIGHT, SLIPS, Formula, Sheet, reported_line, sheet
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from msgspec import convert, to_builtins
from msgspec.structs import replace

from gyrodata import grading
from gyrodata.grading import (
    Grade,
    Rubric,
    Submission,
    default_rubric,
    default_rubric_text,
    grade_submission,
    read_rubric,
    settle,
)

Grader = Callable[..., Grade]

RUBRIC = default_rubric()
STATED = read_rubric(
    default_rubric_text()
    .replace('[reference]\nfrom = "class"', '[reference.all]\ninertia = "4.44e-3 kg m^2"\nu = "0.02e-3 kg m^2"')
    .encode()
)


@pytest.fixture(scope="module")
def rows() -> Sheet:
    return sheet(np.random.default_rng(3), turns="mixed")


@pytest.fixture
def hand_in(tmp_path: Path) -> Callable[..., Submission]:
    def hand(text: str | bytes, student: str = "s1", answers: str | None = None, **more: object) -> Submission:
        data = text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass")
        (tmp_path / f"{student}.csv").write_bytes(data)
        if answers is not None:
            (tmp_path / f"{student}.toml").write_text(answers, encoding="utf-8")
            more["report_names"] = (f"{student}.toml",)
        return Submission(student, student.title(), {}, tmp_path, log_name=f"{student}.csv", **more)  # type: ignore[arg-type]

    return hand


@pytest.fixture
def grade(hand_in: Callable[..., Submission]) -> Grader:
    def graded(text: str | bytes, rubric: Rubric = STATED, **more: object) -> Grade:
        return grade_submission(hand_in(text, **more), rubric)

    return graded


def points(grade: Grade) -> dict[str, float | None]:
    return {mark.criterion: mark.points for mark in grade.marks}


def report(rows: Sheet, formula: Formula = RIGHT, fit: str = "through_origin") -> str:
    return rows.log(reported_line(*formula.inertia(rows, fit)))


ALL = {"log": 2, "procedure": 3, "inertia": 6, "reference": 3, "uncertainty": 3, "units": 2, "constancy": 1}


class TestAGoodReport:
    @pytest.mark.parametrize("fit", ["through_origin", "with_constant", "mean_of_ratios"])
    def test_by_any_accepted_fit_earns_everything(self, grade: Grader, rows: Sheet, fit: str) -> None:
        found = grade(report(rows, fit=fit))
        assert (found.status, found.why, found.points, points(found)) == ("graded", None, 20, ALL)
        assert found.matched == fit
        assert found.d == 0
        assert found.slips == ()
        assert found.look == ()

    def test_only_what_the_course_accepts_is_compared_with(self, grade: Grader, rows: Sheet) -> None:
        narrow = replace(STATED, accept=("with_constant",))
        found = grade(report(rows), rubric=narrow)
        assert list(found.own) == ["with_constant"]
        assert found.d is not None
        assert found.d > 0

    @pytest.mark.parametrize("digits", [1, 2])
    def test_rounding_costs_nothing(self, grade: Grader, rows: Sheet, digits: int) -> None:
        value, u = RIGHT.inertia(rows, "through_origin")
        assert grade(rows.log(reported_line(value, u, digits))).points == 20

    def test_in_an_answers_file_is_as_good(self, grade: Grader, rows: Sheet) -> None:
        line = reported_line(*RIGHT.inertia(rows, "through_origin"))
        found = grade(rows.log(), answers=f'# my answers\ninertia = "{line.split(": ")[1]}"')
        assert found.points == 20

    def test_in_another_unit_is_as_good(self, grade: Grader, rows: Sheet) -> None:
        value, u = RIGHT.inertia(rows, "through_origin")
        assert grade(rows.log(reported_line(1e7 * value, 1e7 * u, unit=" g cm^2"))).points == 20


PLAIN = """schema = 1
points = 10
criterion = [
  { id = "own", check = "own_data", points = 4, full = "percent <= 2", zero = "percent >= 6" },
  { id = "reference", check = "reference", points = 3, full = "percent <= 5", zero = "percent >= 15" },
  { id = "u", check = "uncertainty", points = 2, full = "stated >= 1", zero = "stated <= 0" },
  { id = "plot", check = "files", points = 1 },
]
[reference.all]
inertia = "4.44e-3 kg m^2"
u = "1 %"
"""


class TestAPlainRubric:
    def test_percent_stated_and_files_are_counted(self, grade: Grader, rows: Sheet) -> None:
        rubric = read_rubric(PLAIN.encode())
        value, u = RIGHT.inertia(rows, "through_origin")
        assert points(grade(report(rows), rubric, members=("lab.csv", "Plot.PNG"))) == {
            "own": 4, "reference": 3, "u": 2, "plot": 1,
        }  # fmt: skip
        found = grade(rows.log(f"# reported_inertia: {1.1 * 4.44e-3:.6e} kg m^2"), rubric, members=("lab.csv",))
        assert points(found) == {"own": 0, "reference": 1.5, "u": 0, "plot": 0}
        assert "10 % from" in next(mark.reason for mark in found.marks if mark.criterion == "reference")
        beside = grade(rows.log(reported_line(1.04 * value, u)), replace(rubric, accept=("through_origin",)))
        assert points(beside)["own"] == pytest.approx(2, abs=0.1)

    def test_a_slip_is_undone_for_the_reference_only_where_it_is_charged_for(self, grade: Grader, rows: Sheet) -> None:
        slipped = report(rows, SLIPS["rpm_as_rad_s"])
        rubric = read_rubric(PLAIN.encode())
        assert points(grade(slipped, rubric)) == {"own": 2, "reference": 3, "u": 2, "plot": 0}
        without = replace(rubric, criteria=rubric.criteria[1:])
        assert points(grade(slipped, without)) == {"reference": 0, "u": 2, "plot": 0}

    def test_runs_that_say_nothing_agree_with_nothing(self, grade: Grader, rows: Sheet) -> None:
        wild = replace(rows, time=rows.time * np.random.default_rng(1).uniform(0.55, 1.6, len(rows.time)))
        found = grade(wild.log("# reported_inertia: 6.2e-3 ± 0.1e-3 kg m^2"))
        (mark,) = (mark for mark in found.marks if mark.criterion == "reference")
        assert mark.detail["u"] == pytest.approx(0.05 * 6.2e-3)
        assert mark.points == 0


class TestPoints:
    def test_fall_with_the_distance_and_stay_within_the_rubric(self, grade: Grader, rows: Sheet) -> None:
        value, u = RIGHT.inertia(rows, "through_origin")
        earned = []
        for k in range(0, 60, 3):
            found = grade(rows.log(f"# reported_inertia: {value * (1 + k / 1000):.8e} ± {u:.2e} kg m^2"))
            assert found.points is not None
            assert 0 <= found.points <= found.out_of
            mark = next(mark for mark in found.marks if mark.criterion == "inertia")
            earned.append((found.d, mark.points))
        earned.sort(key=lambda pair: pair[0] or 0.0)
        assert [p for _, p in earned] == sorted((p for _, p in earned), key=lambda p: -(p or 0.0))
        assert earned[0][1] == 6
        assert earned[-1][1] == 0
        assert any(0 < (p or 0.0) < 6 for _, p in earned)

    def test_add_up_to_two_decimals(self, grade: Grader, rows: Sheet) -> None:
        found = grade(rows.log("# reported_inertia: 4.5e-3 ± 0.3e-3 kg m^2"))
        assert found.points == pytest.approx(sum(mark.points or 0.0 for mark in found.marks))
        assert found.points == round(found.points or 0.0, 2)

    def test_lateness_is_taken_off_the_sum_and_no_further_than_nothing(self, grade: Grader, rows: Sheet) -> None:
        late = "[late]\nbeyond = '100 %'\n[[late.tier]]\nuntil = '1 day'\ndeduct = '10 %'\n"
        rubric = read_rubric((default_rubric_text() + late).encode())
        rubric = replace(rubric, references=STATED.references, class_reference=False)
        by_hours = {hours: grade(report(rows), rubric, late=True, late_seconds=3600.0 * hours) for hours in (2, 100)}
        assert by_hours[2].points == 18
        assert (by_hours[2].late_deduction, by_hours[2].late_reason) == (2, "2 h late")
        assert by_hours[100].points == 0
        assert points(by_hours[100]) == ALL
        marked = grade(report(rows), rubric, late=True)
        assert marked.points == 20
        assert marked.look == ("marked late, but nothing says by how much",)


class TestAKnownSlip:
    @pytest.mark.parametrize("kind", [kind for kind in SLIPS if "+" not in kind])
    @pytest.mark.parametrize("fit", ["through_origin", "mean_of_ratios"])
    def test_is_deducted_once(self, grade: Grader, rows: Sheet, kind: str, fit: str) -> None:
        found = grade(report(rows, SLIPS[kind], fit))
        assert kind in [slip.kind for slip in found.slips]
        lost = {name: ALL[name] - (earned or 0.0) for name, earned in points(found).items() if earned != ALL[name]}
        # "rpm or no g": undone with the better of the two, it is right within their difference.
        assert set(lost) == {"inertia"}
        assert lost["inertia"] == pytest.approx(3, abs=1.2)

    def test_gate_applies_to_value_without_known_mistake(self, grade: Grader, rows: Sheet) -> None:
        assert points(grade(report(rows, SLIPS["g_as_kg + cm_as_m"]))) == {**ALL, "inertia": 3}
        value, u = RIGHT.inertia(rows, "through_origin")
        found = grade(rows.log(reported_line(3.7e5 * value, 3.7e5 * u)))
        assert points(found) == {**ALL, "inertia": 0, "reference": 0, "uncertainty": 0}
        reason = next(mark.reason for mark in found.marks if mark.criterion == "reference")
        assert "nothing on a lab bench has such a moment of inertia" in reason

    def test_that_is_one_of_two_is_worth_a_look(self, grade: Grader) -> None:
        random = np.random.default_rng(7)
        looks = [
            grade(report(sheet(random, turns=1 / 3, imbalance=0.001), SLIPS["missing_g"], "with_constant")).look
            for _ in range(8)
        ]
        assert any("explain the reported I_zz equally well" in look for found in looks for look in found)

    def test_that_nobody_knows_costs_the_points_and_is_worth_a_look(self, grade: Grader, rows: Sheet) -> None:
        found = grade(report(rows, Formula(answer=1.3)))
        assert found.slips == ()
        assert points(found) == {**ALL, "inertia": 0, "reference": 0}
        assert "no known slip explains it" in found.look[0]


class TestTheUncertainty:
    @pytest.mark.parametrize(
        ("times", "earned"), [(0.1, 0), (0.35, 1.5), (0.6, 3), (1, 3), (1.9, 3), (3.5, 1.5), (9, 0)]
    )
    def test_is_neither_too_small_nor_too_large(self, grade: Grader, rows: Sheet, times: float, earned: float) -> None:
        value, _ = RIGHT.inertia(rows, "through_origin")
        own = grade(rows.log()).own
        us = [fit["u"] for fit in own.values() if fit["u"]]
        u = times * (max(us) if times > 1 else min(us))
        found = grade(rows.log(f"# reported_inertia: {value:.6e} ± {u:.6e} kg m^2"))
        assert points(found)["uncertainty"] == pytest.approx(earned, abs=0.01)

    def test_that_is_not_reported_earns_nothing_there(self, grade: Grader, rows: Sheet) -> None:
        found = grade(rows.log(reported_line(RIGHT.inertia(rows, "through_origin")[0], None)))
        assert points(found)["uncertainty"] == 0
        assert found.status == "graded"

    def test_of_a_single_run_is_recognised(self, grade: Grader, rows: Sheet) -> None:
        value, u = RIGHT.inertia(rows, "mean_of_ratios")
        found = grade(rows.log(f"# reported_inertia: {value:.5e} ± {6 * u:.2e} kg m^2"))
        assert "√n" not in str(found.marks)
        found = grade(
            rows.log(f"# reported_inertia: {value:.5e} ± {3 * u:.3e} kg m^2"),
            replace(STATED, accept=("mean_of_ratios",)),
        )
        assert "that of their mean is √n times smaller" in str(found.marks)


class TestUnitAndDigits:
    @pytest.mark.parametrize(
        ("text", "earned", "told"),
        [
            ("4.44e-3 ± 0.02e-3 kg m^2", 2, "has its unit"),
            ("4.44e-3 ± 0.02e-3", 1, "has no unit"),
            ("4.44e-3 ± 0.02e-3 kg m", 1, "is no unit of a moment of inertia"),
            ("4.44213e-3 ± 0.02e-3 kg m^2", 1, "the value's last digit is finer"),
            ("4.4e-3 ± 0.024e-3 kg m^2", 1, "the value's last digit is coarser"),
            ("4.4423e-3 ± 0.0213e-3 kg m^2", 1, "the uncertainty has 3 digits"),
            ("4.44232512e-3 kg m^2", 1, "more digits than its uncertainty"),
            ("4.442e-3 kg m^2", 2, "has its unit"),
            ("4.44e-3 kg m^2 ± 0.5 %", 2, "has its unit"),
        ],
    )
    def test_each_fault_is_told(self, grade: Grader, rows: Sheet, text: str, earned: float, told: str) -> None:
        found = grade(rows.log(f"# reported_inertia: {text}"))
        mark = next(mark for mark in found.marks if mark.criterion == "units")
        assert mark.points == earned
        assert told in mark.reason

    @pytest.mark.parametrize("unit", ["", " kg m", " furlongs"])
    def test_without_a_usable_unit_the_number_is_judged_as_si(self, grade: Grader, rows: Sheet, unit: str) -> None:
        value, u = RIGHT.inertia(rows, "through_origin")
        found = grade(rows.log(reported_line(value, u, unit=unit)))
        assert points(found) == {**ALL, "units": 1}


class TestTheLog:
    def test_what_the_reader_doubts_is_told_with_its_line(self, grade: Grader, rows: Sheet) -> None:
        found = grade(report(rows).replace("# g:", "# u_tme: 0.2 s\n# g:"))
        mark = found.marks[0]
        assert mark.points == 1.5
        assert 'line 1: "# u_tme" is kept as a remark' in mark.reason

    def test_what_the_procedure_lacks_is_counted(self, grade: Grader) -> None:
        few = sheet(np.random.default_rng(3), weights=(0.02, 0.05))
        assert points(grade(report(few)))["procedure"] == 2
        fewer = sheet(np.random.default_rng(3), weights=(0.02, 0.05), rpm=(300.0, 310.0))
        found = grade(report(fewer))
        assert points(found)["procedure"] == 0
        assert "the lab asks for three spins" in found.marks[1].reason

    def test_a_product_that_is_not_constant_costs_the_point(self, grade: Grader, rows: Sheet) -> None:
        time = rows.time * np.tile([1.0, 1.12, 0.9], 3)
        found = grade(report(replace(rows, time=time)))
        assert points(found)["constancy"] == 0
        assert "more than the usual uncertainties of such readings" in found.marks[-1].reason

    def test_one_run_a_torque_shows_no_constancy(self, grade: Grader) -> None:
        single = sheet(np.random.default_rng(3), rpm=(400.0,))
        found = grade(report(single, fit="mean_of_ratios"))
        assert points(found)["constancy"] == 0
        assert "no torque has two runs" in found.marks[-1].reason

    def test_its_spread_can_be_judged_instead(self, grade: Grader, rows: Sheet) -> None:
        text = (
            default_rubric_text()
            .replace('"p >= 0.001"', '"spread <= 0.05"')
            .replace('"p <= 0.000001"', '"spread >= 0.2"')
        )
        rubric = replace(read_rubric(text.encode()), references=STATED.references, class_reference=False)
        assert points(grade(report(rows), rubric))["constancy"] == 1


class TestNotGraded:
    @pytest.mark.parametrize(
        ("text", "why"),
        [
            (b"", "the log cannot be read"),
            (b"\x89PNG\r\n\x1a\n\0\0", "the log cannot be read"),
            (b"hello", "the log cannot be read: line 1: no delimiter"),
            (b"mass [g],position [cm],spin [rpm],time [s],turns\n20,15,56O,13.06,1/3\n", 'line 2: spin "56O"'),
            (b"mass [g],position [cm],spin [rpm],time [s],turns\n0,,400,160.2,1/3\n", "no run has a torque"),
            (b"mass [g],position [cm],spin [rpm],time [s]\n20,15,400,13.06\n", "the log cannot be analysed"),
        ],
    )
    def test_a_log_that_cannot_be_judged_has_no_points_and_says_why(self, grade: Grader, text: bytes, why: str) -> None:
        found = grade(text)
        assert (found.status, found.points) == ("not graded", None)
        assert why in (found.why or "")
        assert set(points(found).values()) == {None}
        assert found.diagnostics

    def test_a_submission_without_a_log_says_so(self, hand_in: Callable[..., Submission]) -> None:
        found = grade_submission(hand_in("", problem="no log: only photo.png"), STATED)
        assert (found.status, found.why) == ("not graded", "no log: only photo.png")

    def test_a_file_that_is_gone_is_a_reason_too(self, hand_in: Callable[..., Submission], rows: Sheet) -> None:
        handed = hand_in(report(rows))
        assert grade_submission(replace(handed, log_name="gone.csv"), STATED).status == "not graded"

    def test_numbers_that_break_the_analysis_wait_for_a_person(
        self, grade: Grader, rows: Sheet, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def broken(*_: object, **__: object) -> None:
            raise np.linalg.LinAlgError("singular matrix")

        monkeypatch.setattr("gyrodata.analysis.analyze_readings", broken)
        found = grade(report(rows))
        assert (found.status, found.why) == (
            "not graded",
            "the analysis broke on these numbers (LinAlgError: singular matrix)",
        )

    def test_no_reported_value_waits_for_a_person_unless_the_rubric_says_zero(self, grade: Grader, rows: Sheet) -> None:
        found = grade(rows.log())
        assert (found.status, found.points) == ("not graded", None)
        assert "no reported I_zz was found" in (found.why or "")
        assert points(found)["procedure"] == 3
        assert points(found)["inertia"] is None
        zero = grade(rows.log(), replace(STATED, no_report="zero"))
        assert (zero.status, zero.points) == ("graded", 6)

    def test_a_reported_value_that_cannot_be_read_always_waits(self, grade: Grader, rows: Sheet) -> None:
        found = grade(rows.log("# reported_inertia: about four"), replace(STATED, no_report="zero"))
        assert found.status == "not graded"
        assert '"about four" is not a number' in (found.why or "")

    def test_a_station_without_a_reference_waits(self, grade: Grader, rows: Sheet) -> None:
        elsewhere = replace(STATED, references={"7": STATED.references["all"]})
        text = report(rows)
        for station in ("# station: 8\n", ""):
            waiting = grade(station + text, elsewhere)
            assert (waiting.status, waiting.points, waiting.why) == ("so far", 17, None)
            (mark,) = (mark for mark in waiting.marks if mark.waits)
            assert (mark.check, mark.points) == ("reference", None)
            assert "no reference for this station" in mark.reason
        assert grade("# station: 7\n" + text, elsewhere).points == 20

    @pytest.mark.parametrize(("away", "words"), [(1.0, "is 1 standard uncertainty from"), (1.1, "1.1 standard unc")])
    def test_one_standard_uncertainty_is_one(self, grade: Grader, rows: Sheet, away: float, words: str) -> None:
        text, all_ = report(rows), STATED.references["all"]
        (seen,) = (mark.detail for mark in grade(text).marks if mark.criterion == "reference")
        moved = replace(all_, inertia=seen["value"] + away * math.hypot(seen["u"], all_.u))
        (mark,) = (m for m in grade(text, replace(STATED, references={"all": moved})).marks if m.check == "reference")
        assert words in mark.reason

    def test_stations_are_the_same_however_they_are_written(self, grade: Grader, rows: Sheet) -> None:
        named = default_rubric_text().replace(
            '[reference]\nfrom = "class"', '[reference."Bench A"]\ninertia = "4.44e-3 kg m^2"\nu = "0.5 %"'
        )
        found = grade("# Station: bench  a\n" + report(rows), read_rubric(named.encode()))
        assert (found.station, found.points) == ("bench a", 20)


class TestTheClassAsReference:
    def test_points_wait_for_the_class(self, grade: Grader, rows: Sheet) -> None:
        waiting = grade(report(rows), RUBRIC)
        assert (waiting.status, waiting.points) == ("so far", 17)
        (settled,), *_ = settle([waiting], RUBRIC)
        assert (settled.status, settled.why, settled.points) == ("graded", None, 20)
        assert settle([settled], RUBRIC)[0] == (settled,)

    def test_order_does_not_matter(self, grade: Grader) -> None:
        random = np.random.default_rng(1)
        labs = [sheet(random) for _ in range(7)]
        waiting = [grade(f"# station: {k % 2}\n" + report(one), RUBRIC, student=f"s{k}") for k, one in enumerate(labs)]
        assert settle(waiting, RUBRIC)[0] == settle(waiting[::-1], RUBRIC)[0][::-1]

    def test_an_outsider_is_far_from_it(self, grade: Grader) -> None:
        random = np.random.default_rng(1)
        texts = [report(sheet(random)) for _ in range(7)]
        wrong = sheet(random)
        texts.append(report(replace(wrong, mass=2 * wrong.mass)))
        found, *_ = settle([grade(text, RUBRIC, student=f"s{k}") for k, text in enumerate(texts)], RUBRIC)
        assert [points(one)["reference"] for one in found] == [3] * 7 + [0]
        assert (found[-1].zeta or 0.0) > 10

    def test_what_is_not_graded_stays_so(self, grade: Grader, rows: Sheet) -> None:
        missing, broken = grade(rows.log(), RUBRIC), grade(b"hello", RUBRIC)
        assert settle([missing, broken], RUBRIC)[0][1] == broken
        assert settle([missing, broken], RUBRIC)[0][0].status == "not graded"

    def test_with_no_report_as_zero_the_class_settles(self, grade: Grader, rows: Sheet) -> None:
        rubric = replace(RUBRIC, no_report="zero")
        assert settle([grade(rows.log(), rubric)], rubric)[0][0].points == 6


class TestJson:
    @pytest.mark.parametrize("text", ["good", "slip", "none", "broken"])
    def test_there_and_back_gives_the_same(self, grade: Grader, rows: Sheet, text: str) -> None:
        contents: Mapping[str, str | bytes] = {
            "good": report(rows),
            "slip": report(rows, SLIPS["rpm_as_rad_s"]),
            "none": rows.log(),
            "broken": b"hello",
        }
        found = grade(contents[text])
        stored = json.dumps(to_builtins(found), allow_nan=False)
        assert convert(json.loads(stored), Grade) == found
        assert json.dumps(to_builtins(convert(json.loads(stored), Grade))) == stored
        assert len(stored) < 20_000

    def test_the_same_submission_gives_the_same_bytes(self, grade: Grader, rows: Sheet) -> None:
        assert to_builtins(grade(report(rows))) == to_builtins(grade(report(rows)))


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.one_of(
        st.text(max_size=40),
        st.tuples(
            st.floats(allow_nan=False, allow_infinity=False),
            st.one_of(st.none(), st.floats(allow_nan=False, allow_infinity=False)),
            st.sampled_from(["kg m^2", "g cm^2", "kg", "", "%", "kg*m^2*s"]),
        ).map(lambda t: f"{t[0]!r} {t[2]}" if t[1] is None else f"{t[0]!r} ± {t[1]!r} {t[2]}"),
    )
)
@example("0 ± 0 kg m^2")
@example("-0.0 kg m^2")
@example("1e308 ± 1e308 kg m^2")
@example("5e-324 ± 5e-324 kg m^2")
@example("4.4e-3 ± 0 kg m^2")
@example("4.4e-3 ± 5e-324 kg m^2")
@example("4.4e-3 ± 1e99 kg m^2")
@example("nan kg m^2")
def test_nothing_that_is_reported_stops_it(grade: Grader, rows: Sheet, text: str) -> None:
    line = " ".join(text.split())
    found = grade(rows.log(f"# reported_inertia: {line}"))
    json.dumps(to_builtins(found), allow_nan=False)
    if found.status == "graded":
        assert found.points is not None
        assert 0 <= found.points <= 20
    for mark in found.marks:
        assert mark.points is None or 0 <= mark.points <= mark.out_of
        assert all(math.isfinite(value) for value in mark.detail.values() if isinstance(value, float))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.integers(0, 400),
    st.integers(0, 30),
    st.one_of(st.text(max_size=8), st.sampled_from(["0", "-1", "1e9", "1e-9", ",", "\n", "%", "nan"])),
)
def test_nothing_in_a_log_stops_it(grade: Grader, rows: Sheet, at: int, length: int, text: str) -> None:
    whole = report(rows)
    found = grade(whole[:at] + text + whole[at + length :])
    json.dumps(to_builtins(found), allow_nan=False)
    assert (found.points is None) == (found.status == "not graded") == (found.why is not None)


def test_the_front_gives_every_name_that_it_lists() -> None:
    assert [name for name in grading.__all__ if not hasattr(grading, name)] == []
    assert dir(grading) == sorted(set(grading.__all__))
