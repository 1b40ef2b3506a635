"""How well a bench measures, where a log does not say: by the rubric, or by how far the
class scatters.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from classes.class_cells import grade
from classes.drawn import USUAL, draw
from grading.students_reports import reported_line
from msgspec.structs import replace

from gyrodata.base.errors import InputError
from gyrodata.grading.rubric import default_rubric_text, read_rubric
from gyrodata.grading.yardsticks import class_scatter

FROM_CLASS = '[bench]\nfrom = "class"\n'
STUDENT = draw(3, 5)
REPORT = reported_line(*STUDENT.answer())


def with_bench(*lines: str) -> str:
    """The built-in rubric with uncertainties of the bench."""
    assert FROM_CLASS in default_rubric_text()
    return default_rubric_text().replace(
        FROM_CLASS, "\n".join(["[bench]", *lines, ""]) if lines else ""
    )


def one(log: str, folder: Path, *lines: str) -> dict[str, Any]:
    """Grade one log by a rubric with lines about the bench."""
    (folder / "rubric.toml").write_text(with_bench(*lines), encoding="utf-8")
    (student,) = grade({"ann/lab.csv": log}, "--rubric", folder / "rubric.toml")[
        "students"
    ].values()
    return student


def numbers(student: dict[str, Any]) -> list[object]:
    """What a line about the bench changes; only reasons say where it comes from."""
    marks = [{**mark, "reason": ""} for mark in student["marks"]]
    return [
        *(student[key] for key in ("inertia", "inertia_u", "own", "points", "d")),
        marks,
    ]


def constancy(student: dict[str, Any]) -> dict[str, Any]:
    (mark,) = (mark for mark in student["marks"] if mark["check"] == "constancy")
    return mark


UNCERTAINTIES = (
    'u_time = "0.3 s"',
    'u_spin = "1 % + 0.5 rpm"',
    'u_position_zero = "2 mm"',
    'u_imbalance = "0.5 mN m"',
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "line", [*UNCERTAINTIES, 'ball_mass = "4.31 ± 0.01 kg"', 'motion = "steady"']
)
def test_line_of_the_bench_acts_like_one_of_the_log(line: str, tmp_path: Path) -> None:
    said = line.replace(" = ", ": ").replace('"', "")
    stated, by_rubric = (
        one(STUDENT.log(f"# {said}", REPORT), tmp_path),
        one(STUDENT.log(REPORT), tmp_path, line),
    )
    assert numbers(by_rubric) == numbers(stated)
    assert (by_rubric["bench"], stated["bench"]) == ([said.replace(":", "")], [])
    if line in UNCERTAINTIES:
        assert numbers(by_rubric) != numbers(one(STUDENT.log(REPORT), tmp_path))


def test_uncertainty_of_the_log_goes_before_the_bench(tmp_path: Path) -> None:
    log = STUDENT.log("# u_time: 0.2 s", REPORT)
    plain, given = one(log, tmp_path), one(log, tmp_path, 'u_time = "0.9 s"')
    assert (given["bench"], numbers(given)) == ([], numbers(plain))
    assert "the uncertainties that your log states" in constancy(given)["reason"]


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('u_tiem = "0.3 s"', '"u_tiem" is not known in [bench]'),
        ('u_time = "0.3 kg"', "is not an uncertainty"),
    ],
)
def test_fault_in_the_bench_is_told(line: str, says: str) -> None:
    with pytest.raises(InputError, match=re.escape(says)):
        read_rubric(with_bench(line).encode())


@pytest.mark.slow
def test_rough_bench_costs_nothing_once_it_is_told(tmp_path: Path) -> None:
    def lost(document: dict[str, Any]) -> int:
        return sum(
            constancy(one)["points"] < 1 for one in document["students"].values()
        )

    students = [draw(i, 2, replace(USUAL, hand=0.3)) for i in range(10)]
    logs = {
        f"{one.stem}_lab.csv": one.log(reported_line(*one.answer())) for one in students
    }
    rubrics = {
        "usual": with_bench(),
        "stated": with_bench('u_time = "0.3 s"'),
        "class": default_rubric_text(),
    }
    for name, text in rubrics.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    usual, stated, by_class = (
        grade(logs, "--rubric", tmp_path / name) for name in rubrics
    )
    assert (lost(stated), lost(by_class), lost(usual) >= 2) == (0, 0, True)
    assert (
        usual["scatters"],
        stated["scatters"],
        by_class["scatters"]["all"]["logs"],
    ) == ({}, {}, 10)
    factor = by_class["scatters"]["all"]["factor"]
    assert 1.7 < factor < 3
    told = constancy(next(iter(by_class["students"].values())))["reason"]
    assert f"{factor:.2g} times as large: the 10 logs of the class scatter" in told


def test_scatter_of_a_class_is_recovered() -> None:
    random = np.random.default_rng(4)
    logs = [
        (station, [(factor**2 * float(random.chisquare(2)), 2) for _ in range(3)])
        for station, factor in [("3", 2.0)] * 40 + [(None, 1.0)] * 40
    ]
    found = class_scatter(logs)
    assert found == class_scatter(logs[::-1])
    assert found["3"].factor == pytest.approx(2.0, abs=0.2)
    assert (found["all"].logs, set(found)) == (80, {"3", "all"})
    # A few logs that scatter wildly do not speak for the others.
    assert (
        class_scatter([*logs[40:], *((None, [(1e6, 2)]) for _ in range(4))])[
            "all"
        ].factor
        < 1.5
    )
    assert (
        class_scatter(logs[40:])["all"].factor
        == class_scatter(logs[:7])["all"].factor
        == 1.0
    )
