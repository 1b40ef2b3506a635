"""From a submission to points: what is judged, what cannot be, and that nothing a
student writes stops it.
"""

import json
import math
import tempfile
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from grading.students_reports import (
    RIGHT,
    SLIPS,
    STATED,
    Formula,
    Sheet,
    reported_line,
    sheet,
)
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec import to_builtins
from msgspec.structs import replace

from gyrodata.grading.exports.pages import feedback_pages
from gyrodata.grading.grade import Grade, grade_submission, standard_of
from gyrodata.grading.rubric import Rubric, default_rubric_text, read_rubric
from gyrodata.grading.submissions import Submission

BY_CLASS = read_rubric(default_rubric_text().encode())
BY_REFERENCE = read_rubric(STATED.encode())
ROWS = sheet(np.random.default_rng(3), turns="mixed")
VALUE, U = RIGHT.inertia(ROWS, "through_origin")
ALL = {
    "log": 2,
    "procedure": 3,
    "inertia": 6,
    "reference": 3,
    "uncertainty": 3,
    "units": 2,
    "constancy": 1,
}
FITS = ("through_origin", "with_constant", "mean_of_ratios")


def grade(
    text: str | bytes,
    rubric: Rubric = BY_REFERENCE,
    student: str = "s1",
    **more: object,
) -> Grade:
    with tempfile.TemporaryDirectory() as folder:
        data = (
            text if isinstance(text, bytes) else text.encode("utf-8", "surrogatepass")
        )
        (Path(folder) / f"{student}.csv").write_bytes(data)
        one = Submission(
            student, student, {}, Path(folder), **{"log_name": f"{student}.csv"} | more
        )  # type: ignore[arg-type]
        return grade_submission(one, rubric)


def points(grade: Grade) -> dict[str, float | None]:
    return {mark.criterion: mark.points for mark in grade.marks}


def mark_of(grade: Grade, criterion: str) -> tuple[float | None, str]:
    return next(
        (mark.points, mark.reason)
        for mark in grade.marks
        if mark.criterion == criterion
    )


def report(
    rows: Sheet = ROWS, formula: Formula = RIGHT, fit: str = "through_origin"
) -> str:
    return rows.log(reported_line(*formula.inertia(rows, fit)))


def says(text: str) -> str:
    return ROWS.log(f"# reported_inertia: {text}")


@pytest.mark.slow
@pytest.mark.parametrize("fit", FITS)
def test_value_of_any_accepted_fit_earns_all_points(fit: str) -> None:
    found = grade(report(fit=fit))
    assert (found.status, found.why, found.points, points(found)) == (
        "graded",
        None,
        20,
        ALL,
    )
    assert (found.matched, found.d, found.slips, found.look) == (fit, 0, (), ())
    narrow = grade(report(), rubric=replace(BY_REFERENCE, accept=("with_constant",)))
    assert (list(narrow.own), (narrow.d or 0.0) > 0) == (["with_constant"], True)


@pytest.mark.slow
def test_points_fall_with_the_distance_of_the_value() -> None:
    found = [
        grade(says(f"{VALUE * (1 + k / 1000):.8e} ± {U:.2e} kg m^2"))
        for k in range(0, 60, 3)
    ]
    earned = [
        points(one)["inertia"] for one in sorted(found, key=lambda one: one.d or 0.0)
    ]
    assert earned == sorted(earned, reverse=True)  # type: ignore[type-var]
    assert (earned[0], earned[-1], any(0 < (one or 0.0) < 6 for one in earned)) == (
        6,
        0,
        True,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("times", "earned"), [(0.1, 0), (0.25, 0.5), (0.6, 3), (1, 3), (1.9, 3), (9, 0)]
)
def test_uncertainty_too_small_or_too_large_costs_points(
    times: float, earned: float
) -> None:
    us = [fit["u"] for fit in grade(ROWS.log()).own.values() if fit["u"]]
    u = times * (max(us) if times > 1 else min(us))
    assert points(grade(says(f"{VALUE:.6e} ± {u:.6e} kg m^2")))[
        "uncertainty"
    ] == pytest.approx(earned, abs=0.01)


FEW = report(sheet(np.random.default_rng(3), weights=(0.02, 0.05)))
ONE_SPIN = report(sheet(np.random.default_rng(3), rpm=(400.0,)), fit="mean_of_ratios")
UNEVEN = report(replace(ROWS, time=ROWS.time * np.tile([1.0, 1.12, 0.9], 3)))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "criterion", "earned", "told"),
    [
        (says("4.44e-3 ± 0.02e-3 kg m^2"), "units", 2, "has its unit"),
        (says("4.44e-3 ± 0.02e-3"), "units", 1, "has no unit"),
        (
            says("4.44e-3 ± 0.02e-3 kg m"),
            "units",
            1,
            "is not a unit of a moment of inertia",
        ),
        (
            says("4.44213e-3 ± 0.02e-3 kg m^2"),
            "units",
            1,
            "the value's last digit is finer",
        ),
        (
            says("4.4e-3 ± 0.02e-3 kg m^2"),
            "units",
            1,
            "coarser than that of its uncertainty: round both",
        ),
        (
            says("4.4423e-3 ± 0.0213e-3 kg m^2"),
            "units",
            1,
            "the uncertainty has 3 digits",
        ),
        (says("4.442e-3 ± 0.102e-3 kg m^2 (k = 2)"), "units", 2, "has its unit"),
        (ROWS.log(reported_line(VALUE, U, unit=" kg m")), "inertia", 6, ""),
        (
            report().replace("# g:", "# u_tme: 0.2 s\n# g:"),
            "log",
            1.5,
            'line 1: "# u_tme" is kept as a remark',
        ),
        (FEW, "procedure", 2, ""),
        (UNEVEN, "constancy", 0, "more than the usual uncertainties of such readings"),
        (ONE_SPIN, "constancy", 0, "no torque has two runs"),
        (
            report(fit="with_constant"),
            "uncertainty",
            3,
            "agrees with your runs, whose fits give ",
        ),
        (
            ROWS.log(reported_line(VALUE, None)),
            "uncertainty",
            0,
            "write it after the value: 4.4e-3 ± 0.1e-3 kg m^2",
        ),
    ],
)
def test_fault_of_a_log_or_value_costs_its_points(
    text: str, criterion: str, earned: float, told: str
) -> None:
    got, reason = mark_of(found := grade(text), criterion)
    assert got == earned
    assert told in reason
    assert told[1:].replace("_", "\\_") in feedback_pages(found)[".md"]


def test_zero_that_a_cell_loses_costs_no_points(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["I_zz", 4.4, 0.02, "g m²"])
    book.save(tmp_path / "answer.xlsx")
    (tmp_path / "s1.csv").write_text(ROWS.log(), encoding="utf-8")
    one = Submission(
        "s1", "s1", {}, tmp_path, log_name="s1.csv", report_names=("answer.xlsx",)
    )
    assert mark_of(grade_submission(one, BY_REFERENCE), "units")[0] == 2


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in SLIPS if "+" in kind])
def test_two_mistakes_at_once_are_a_question(kind: str) -> None:
    found = grade(report(ROWS, SLIPS[kind]))
    assert (found.slips, points(found)["inertia"]) == ((), 0)
    assert "no common mistake explains it" in found.look[0]


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in SLIPS if "+" not in kind])
def test_known_mistake_is_named_and_costs_points_once(kind: str) -> None:
    for fit in ("through_origin", "mean_of_ratios"):
        found = grade(report(ROWS, SLIPS[kind], fit))
        (slip,) = [slip for slip in found.slips if slip.kind == kind]
        assert SLIPS[kind].inertia(ROWS, fit)[0] / slip.factor == pytest.approx(
            RIGHT.inertia(ROWS, fit)[0], rel=0.03
        )
        # "rpm or no g": undone with the better of the two, it is right within their
        # difference.
        assert points(found) == {**ALL, "inertia": pytest.approx(3, abs=1.2)}


@pytest.mark.slow
def test_value_without_a_known_mistake_is_not_reasonable() -> None:
    found = grade(ROWS.log(reported_line(3.7e5 * VALUE, 3.7e5 * U)))
    assert points(found) == {**ALL, "inertia": 0, "uncertainty": 0}
    assert "which your runs give" in mark_of(found, "reference")[1]
    inverse = grade(ROWS.log(reported_line(1 / VALUE, U / VALUE**2)))
    assert "inver" in inverse.slips[0].words
    odd = grade(report(ROWS, Formula(answer=1.3)))
    assert (odd.slips, points(odd)) == ((), {**ALL, "inertia": 0})
    assert "no common mistake explains it" in odd.look[0]
    with_constant = report(
        ROWS, replace(SLIPS["turns_forgotten"], spin=1.0), "with_constant"
    )
    assert grade(with_constant).slips == (), (
        "such a fit says nothing: two mistakes at once explain it by chance"
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_random_times_with_correct_value_need_a_look(seed: int) -> None:
    rows = replace(ROWS, time=np.random.default_rng(seed).uniform(2, 30, 9).round(2))
    found = grade(rows.log(reported_line(VALUE, U)))
    assert (
        found.status == "not graded" or "do not follow from the spins" in found.look[0]
    )


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
"""  # noqa: E501


def test_rubric_of_percents_and_files_is_followed() -> None:
    rubric = read_rubric(PLAIN.encode())
    whole = grade(report(), rubric, members=("lab.csv", "Plot.PNG"))
    assert points(whole) == {"own": 4, "reference": 3, "u": 2, "plot": 1}
    found = grade(says(f"{1.1 * 4.44e-3:.6e} kg m^2"), rubric, members=("lab.csv",))
    # The arithmetic costs points once.
    assert points(found) == {"own": 0, "reference": 3, "u": 0, "plot": 0}
    by_hand = PLAIN.replace(
        '"own_data", points = 4, full = "percent <= 2", zero = "percent >= 6"',
        '"manual", points = 4',
    )
    alone = read_rubric(by_hand.encode())
    found = grade(says(f"{1.1 * 4.44e-3:.6e} kg m^2"), alone, members=("lab.csv",))
    assert points(found) == {"own": None, "reference": 1.5, "u": 0, "plot": 0}
    assert "10 % from" in mark_of(found, "reference")[1]
    found = grade(says(f"{9.5 * 4.44e-3:.6e} kg m^2"), alone, members=("lab.csv",))
    assert "850 % from" in mark_of(found, "reference")[1]


@pytest.mark.parametrize(
    ("factor", "words"), [(1.1, "8 u away"), (5.3, ": yours is 5.31 times that")]
)
def test_distance_of_a_wrong_answer_is_in_u_or_a_factor(
    factor: float, words: str
) -> None:
    found = grade(says(f"{factor * 4.44e-3:.4e} kg m^2"))
    assert mark_of(found, "inertia")[1].endswith(words)


def test_percent_is_that_of_the_answer_without_its_named_mistake() -> None:
    rubric = read_rubric(PLAIN.encode())
    twice = 30 / np.pi  # rpm turned into rad/s twice
    found = grade(says(f"{twice * 4.44e-3:.6e} kg m^2"), rubric)
    assert points(found)["own"] == 2
    assert "turned from rpm into rad/s twice" in mark_of(found, "own")[1]


def test_lateness_is_taken_off_the_sum_down_to_zero() -> None:
    late = "[late]\nbeyond = '100 %'\n[[late.tier]]\nuntil = '1 day'\ndeduct = '10 %'\n"
    rubric = read_rubric((STATED + late).encode())
    soon, later = (
        grade(report(), rubric, late=True, late_seconds=3600.0 * hours)
        for hours in (2, 100)
    )
    assert (soon.points, soon.late_deduction, soon.late_reason) == (18, 2, "2 h late")
    assert (later.points, points(later)) == (0, ALL)
    marked = grade(report(), rubric, late=True)
    assert (marked.points, marked.look) == (
        20,
        ("marked late, but nothing says by how much",),
    )
    waiting = grade(b"", rubric, late=True, late_seconds=7200.0)
    for text in feedback_pages(waiting).values():
        assert "You have not lost points" in text
        assert "2 h late." in text
        assert "taken off" not in text


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (b"", "the log cannot be read"),
        (
            b"mass [g],position [cm],spin [rpm],time [s],turns\n20,15,56O,13.06,1/3\n",
            'line 2: spin "56O"',
        ),
        (
            b"mass [g],position [cm],spin [rpm],time [s],turns\n0,,400,160.2,1/3\n",
            "no run has a torque",
        ),
        (
            b"mass [g],position [cm],spin [rpm],time [s]\n20,15,400,13.06\n",
            "the log cannot be analysed",
        ),
    ],
)
def test_log_that_cannot_be_judged_has_no_points(text: bytes, why: str) -> None:
    found = grade(text)
    assert (found.status, found.points, set(points(found).values())) == (
        "not graded",
        None,
        {None},
    )
    assert why in (found.why or "")
    assert found.diagnostics


def test_missing_value_waits_unless_the_rubric_says_zero() -> None:
    found, zero = grade(ROWS.log()), replace(BY_REFERENCE, no_report="zero")
    assert (found.status, found.points, points(found)["procedure"]) == (
        "not graded",
        None,
        3,
    )
    assert "no I_zz is reported" in (found.why or "")
    assert grade(ROWS.log(), zero).points == 6
    assert grade(report(), log_name="gone.csv").status == "not graded"
    unread = grade(says("about four"), zero)
    assert unread.status == "not graded"
    assert '"about four" is not a number' in (unread.why or "")


def test_station_without_a_reference_waits_for_a_person() -> None:
    stations = {"bench a": (BY_REFERENCE.reference or {})["all"]}
    elsewhere = replace(BY_REFERENCE, reference=stations)
    for station in ("# station: 8\n", ""):
        waiting = grade(station + report(), elsewhere)
        assert (waiting.status, waiting.points, waiting.why) == ("so far", 17, None)
        assert "no reference for this station" in mark_of(waiting, "reference")[1]
    assert grade("# Station: Bench  A\n" + report(), elsewhere).points == 20


@pytest.mark.slow
def test_outsider_is_far_from_the_class_in_any_order() -> None:
    random = np.random.default_rng(1)
    labs = [sheet(random) for _ in range(8)]
    labs[7] = replace(labs[7], mass=2 * labs[7].mass)
    waiting = [
        grade(report(one), BY_CLASS, student=f"s{k}") for k, one in enumerate(labs)
    ]
    waiting += [grade(b"hello", BY_CLASS, student="t")]
    assert (waiting[0].status, waiting[0].points) == ("so far", 17)
    found = settled(waiting)
    assert [points(one)["reference"] for one in found] == [3] * 7 + [0, None]
    assert (found[0].status, found[0].points, found[8]) == ("graded", 20, waiting[8])
    assert settled(waiting[::-1])[::-1] == found


def settled(grades: list[Grade]) -> list[Grade]:
    """Compare the grades of a class with each other."""
    standard = standard_of(grades, BY_CLASS)
    return [standard.settled(grade) for grade in grades]


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(st.text(max_size=40))
@example("0 ± 0 kg m^2")
@example("1e308 ± 1e308 kg m^2")
@example("4.4e-3 ± 0 kg m^2")
@example("nan kg m^2")
def test_any_reported_text_gives_points_within_the_rubric(text: str) -> None:
    found = grade(says(" ".join(text.split())))
    json.dumps(to_builtins(found), allow_nan=False)
    assert found.status != "graded" or 0 <= (found.points or 0.0) <= 20
    for mark in found.marks:
        assert mark.points is None or 0 <= mark.points <= mark.out_of
        assert all(
            math.isfinite(value)
            for value in mark.detail.values()
            if isinstance(value, float)
        )
