"""How well a bench measures, where a log does not say: by the rubric, or by how far the class scatters."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from classes.drawn import USUAL, Bench, draw
from grading.classes import make_folder
from grading.reports import reported_line
from msgspec.structs import replace
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.errors import InputError
from gyrodata.grading import (
    Grade,
    class_scatter,
    default_rubric_text,
    feedback_html,
    feedback_markdown,
    find_submissions,
    grade_submission,
    read_rubric,
)

TEXT = default_rubric_text()
FROM_CLASS = '[bench]\nfrom = "class"\n'
USUAL_TEXT = TEXT.replace(FROM_CLASS, "")
STUDENT = draw(3, 5)
REPORT = reported_line(*STUDENT.answer())


def with_bench(*lines: str) -> str:
    """The built-in rubric with uncertainties of the bench."""
    assert FROM_CLASS in TEXT
    return TEXT.replace(FROM_CLASS, "\n".join(["[bench]", *lines, ""]))


def one(log: str, rubric: str, folder: Path) -> Grade:
    """Grade one log."""
    root = make_folder(folder / f"class{len(list(folder.iterdir()))}", {"ann/lab.csv": log})
    return grade_submission(find_submissions(root).items[0], read_rubric(rubric.encode()))


def numbers(grade: Grade) -> tuple[object, ...]:
    return grade.inertia, grade.inertia_u, grade.own, [(mark.points, mark.detail) for mark in grade.marks]


@pytest.mark.parametrize(
    "line",
    [
        "u_time: 0.3 s", "u_time_bias: 0.05 s", "u_spin: 1 % + 0.5 rpm", "u_spin_scale: 0.5 %", "u_turns: 0.02",
        "u_angle: 5 deg", "u_mass: 0.1 g", "u_position: 0.5 mm", "u_position_zero: 2 mm", "u_g: 1 %",
        "u_imbalance: 0.5 mN m",
    ],
)  # fmt: skip
def test_the_rubric_speaks_as_a_line_of_the_log(line: str, tmp_path: Path) -> None:
    key, _, value = line.partition(": ")
    stated = one(STUDENT.log(f"# {line}", REPORT), USUAL_TEXT, tmp_path)
    by_rubric = one(STUDENT.log(REPORT), with_bench(f'{key} = "{value}"'), tmp_path)
    assert numbers(by_rubric) == numbers(stated)
    assert numbers(by_rubric) != numbers(one(STUDENT.log(REPORT), USUAL_TEXT, tmp_path))
    assert (by_rubric.bench, stated.bench) == ((f"{key} {value}",), ())
    for text in (feedback_markdown(by_rubric), feedback_html(by_rubric)):
        assert "those of the rubric hold: u" in text


PERIODS = "mass [g],position [cm],spin [rpm],time [s],turns,period [s],u_precession_period [s]"


@pytest.mark.parametrize(
    "log",
    [
        STUDENT.log("# u_time: 0.2 s", REPORT),
        STUDENT.log(REPORT, titles="mass [g],position [cm],spin [rpm],time [s] ± 0.2 s,turns"),
        STUDENT.log(REPORT).replace("turns\n", "turns,u_time [s]\n").replace("1/3\n", "1/3,0.2\n")
        .replace("2/3\n", "2/3,0.2\n").replace(",1\n", ",1,0.2\n"),
        "\n".join([
            REPORT, PERIODS,
            *(f"{','.join(row)},{time / turns:.3f},0.2"
              for row, time, turns in zip(STUDENT.cells(), STUDENT.rows.time, STUDENT.rows.turns, strict=True)),
        ]) + "\n",
    ],
    ids=["line", "header", "column", "of the periods"],
)  # fmt: skip
def test_what_a_log_states_itself_goes_before_it(log: str, tmp_path: Path) -> None:
    rubric = with_bench('u_time = "0.9 s"')
    plain, given = (one(log, text, tmp_path) for text in (USUAL_TEXT, rubric))
    assert (given.bench, numbers(given)) == ((), numbers(plain))
    assert given.scatters == ()
    (mark,) = (mark for mark in given.marks if mark.check == "constancy")
    assert "the uncertainties that your log states" in mark.reason


@pytest.mark.parametrize(
    ("lines", "says", "hint"),
    [
        (['u_tiem = "0.3 s"'], '"u_tiem" is not known in [bench]', "did you mean u_time?"),
        (['u_inertia = "1 %"'], '"u_inertia" is not known in [bench]', ""),
        (['u_time = "0.3 kg"'], 'u_time = "0.3 kg" cannot be used: is no uncertainty', ""),
        (["u_time = 0.3"], "u_time = 0.3 cannot be used", 'write u_time = "1 %"'),
        (['u_mass_scale = "0.1 g"'], "is not a share", "0.1 %"),
        (['u_time_bias = "5 %"'], "is a share of what is not read", "0.1 s"),
        (['from = "class"', 'u_time = "0.3 s"'], "both the class and stated values", "leave that out"),
        ([], "or neither", 'write from = "class"'),
    ],
)
def test_a_bench_with_a_fault_is_told_with_its_line(lines: list[str], says: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        read_rubric(with_bench(*lines).encode())
    (found,) = caught.value.diagnostics
    assert says in found.message
    assert hint in found.hint
    assert found.line is not None
    assert with_bench(*lines).split("\n")[found.line - 1] == (lines[0] if lines else "[bench]")


# --- from the class -----------------------------------------------------------------------------------------


def logs_of(count: int, bench: Bench, *head: str) -> dict[str, str]:
    students = [draw(i, 2, bench) for i in range(count)]
    return {f"{one.stem}_lab.csv": one.log(*head, reported_line(*one.answer())) for one in students}


def graded(root: Path, *options: str | Path) -> dict[str, Any]:
    done = CliRunner().invoke(app, ["grade", str(root), "-f", "json", "-q", *map(str, options)], prog_name="gyro")
    assert done.exit_code == 0, done.output
    document: dict[str, Any] = json.loads(done.stdout)
    return document


def lost(document: Mapping[str, Any]) -> int:
    """How many lost points of constancy."""
    marks = [mark for student in document["students"] for mark in student["marks"] if mark["criterion"] == "constancy"]
    return sum(mark["points"] < mark["out_of"] for mark in marks)


ROUGH = {
    "hand": (replace(USUAL, hand=0.3), 'u_time = "0.3 s"'),
    "wobble": (replace(USUAL, wobble=0.02), 'u_turns = "0.02"'),
}


@pytest.mark.parametrize("what", ROUGH)
def test_a_rough_bench_costs_nothing_once_it_is_told(what: str, tmp_path: Path) -> None:
    bench, line = ROUGH[what]
    root = make_folder(tmp_path / "class", logs_of(20, bench))
    for name, text in {"usual": USUAL_TEXT, "stated": with_bench(line), "class": TEXT}.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    usual, stated, by_class = (
        graded(root, "--rubric", tmp_path / f"{name}.toml", "--workers", "1") for name in ("usual", "stated", "class")
    )
    assert lost(stated) == 0
    # A wobble tells most in the shortest turns, which one factor for all does not know.
    assert lost(by_class) <= (what == "wobble") < 4 <= lost(usual)
    assert (usual["scatters"], stated["scatters"]) == ({}, {})
    every = by_class["scatters"]["all"]
    assert every["logs"] == 20
    assert 1.7 < every["factor"] < 3
    (mark,) = (one for one in by_class["students"][0]["marks"] if one["criterion"] == "constancy")
    assert f"{every['factor']:.2g} times as large: the 20 logs of the class scatter" in mark["reason"]
    assert graded(root, "--workers", "2") == by_class | {"input": graded(root, "--workers", "2")["input"]}


def test_a_rerun_with_another_bench_grades_again(tmp_path: Path) -> None:
    root = make_folder(tmp_path / "class", logs_of(3, USUAL))
    rubric, out = tmp_path / "rubric.toml", tmp_path / "grades"
    told = []
    for line in ('u_time = "0.3 s"', 'u_time = "0.3 s"', 'u_time = "0.4 s"'):
        rubric.write_text(with_bench(line), encoding="utf-8")
        done = CliRunner().invoke(app, ["grade", str(root), "--rubric", str(rubric), "--out", str(out)])
        assert done.exit_code == 0, done.output
        told.append(done.stderr)
    assert "kept 3 as graded before" in told[1]
    assert "the rubric changed" in told[2]
    assert "u_time 0.4 s" in (out / "class.html").read_text(encoding="utf-8")


def test_seven_logs_leave_the_usual_uncertainties(tmp_path: Path) -> None:
    rough = replace(USUAL, hand=0.35)
    few = make_folder(tmp_path / "few", logs_of(7, rough))
    done = CliRunner().invoke(app, ["grade", str(few), "--out", str(tmp_path / "out")])
    assert "7 logs without an uncertainty of the times cannot tell how far the bench scatters (8 can)" in done.stdout
    more = {**logs_of(10, rough), "zed0000_7777_9777_lab.csv": draw(2, 3, rough).log("# u_time: 0.05 s", REPORT)}
    document = graded(make_folder(tmp_path / "more", more))
    assert document["scatters"]["all"]["logs"] == 10
    (stated,) = (one for one in document["students"] if one["student"] == "7777")
    (mark,) = (one for one in stated["marks"] if one["criterion"] == "constancy")
    assert mark["points"] < 0.1
    assert "the uncertainties that your log states" in mark["reason"]


def drawn(random: np.random.Generator, factor: float) -> list[tuple[float, int]]:
    return [(factor**2 * float(random.chisquare(2)), 2) for _ in range(3)]


def test_the_scatter_of_a_class_is_recovered() -> None:
    random = np.random.default_rng(4)
    logs = [("3", drawn(random, 2.0)) for _ in range(40)] + [(None, drawn(random, 1.0)) for _ in range(40)]
    found = class_scatter(logs)
    assert found == class_scatter(logs[::-1])
    assert found["3"].factor == pytest.approx(2.0, abs=0.2)
    assert (found["all"].logs, set(found)) == (80, {"3", "all"})
    # Logs that hold anything do not speak for the others.
    junk = [*logs[40:], *((None, [(1e6, 2)]) for _ in range(4))]
    assert class_scatter(junk)["all"].factor < 1.5
    assert class_scatter(logs[40:])["all"].factor == 1.0
    assert class_scatter(logs[:7])["all"].factor == 1.0
