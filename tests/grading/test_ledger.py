"""The desk: what a person decides stays whatever happens, is said, and leaves nothing behind when it is taken back."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from grading.classes import make_folder
from grading.reports import RIGHT, reported_line, sheet
from typer.testing import CliRunner, Result

from gyrodata import schema
from gyrodata.cli import app
from gyrodata.grading import default_rubric_text


def a_log(seed: int) -> str:
    rows = sheet(np.random.default_rng(seed), "mixed")
    return rows.log("# station: 3", reported_line(*RIGHT.inertia(rows, "with_constant")))


class Lab:
    """A class of four, the third without an answer in its log; the folder of its grades."""

    def __init__(self, home: Path) -> None:
        self.root, self.out, self.options = home / "class", home / "grades", ("--workers", "1")
        logs = {f"s{i}/lab.csv": a_log(i) for i in range(4)}
        logs["s2/lab.csv"] = re.sub("# reported_inertia.*\n", "", logs["s2/lab.csv"])
        make_folder(self.root, {**logs, "s2/report.pdf": b"%PDF-1.4"})
        self.grade()

    def grade(self) -> Result:
        done = CliRunner().invoke(app, ["grade", str(self.root), "-o", str(self.out), *self.options])
        assert done.exit_code in (0, 1), done.stderr
        return done

    def decide(self, *lines: str, head: str = "student,what,value,by,why") -> str:
        (self.out / "desk.csv").write_text("\n".join([head, *lines, ""]), encoding="utf-8")
        return self.grade().stderr

    @property
    def students(self) -> Mapping[str, Mapping[str, Any]]:
        document = json.loads((self.out / "grades.json").read_text(encoding="utf-8"))
        jsonschema.validate(document, schema.grades_schema())
        return {one["student"]: one for one in document["students"]}

    def points(self, *students: str) -> list[tuple[str, float | None]]:
        return [(self.students[one]["status"], self.students[one]["points"]) for one in students]

    def feedback(self, student: str) -> str:
        return (self.out / "feedback" / student / "feedback.md").read_text(encoding="utf-8")

    @property
    def todo(self) -> str:
        return (self.out / "desk-todo.csv").read_text(encoding="utf-8")


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    return Lab(tmp_path)


def test_resubmission_is_told_until_its_desk_line_changes(lab: Lab) -> None:
    lab.decide("s0,total,16,Ann,agreed")
    assert lab.students["s0"]["look"] == []
    (lab.root / "s0" / "lab.csv").write_text(a_log(9))
    for _ in range(2):
        lab.grade()
        (look,) = lab.students["s0"]["look"]
        assert look.startswith("resubmitted since total 16 was set by hand")
        assert lab.points("s0") == [("graded", 16)]
        assert "\ns0,total,,,resubmitted" in lab.todo
    lab.decide("s0,total,16,Ann,agreed; still right")
    assert lab.students["s0"]["look"] == []


def test_a_decision_that_is_taken_back_leaves_nothing(lab: Lab) -> None:
    first = {path: path.read_bytes() for path in lab.out.rglob("*") if path.is_file() and "published" not in str(path)}
    told = lab.decide("s0,total,16,,", "s2,reported,4.44e-3 ± 0.05e-3 kg m^2,,", "s3,station,9,,", "s1,hold,,,")
    assert "graded 1 (the desk changed): s2" in told
    assert [lab.students[one]["status"] for one in ("s0", "s1", "s2")] == ["graded", "on hold", "graded"]
    lab.decide()
    del first[lab.out / "journal.ndjson"]
    assert {path: path.read_bytes() for path in first} == first


def test_what_is_on_hold_shows_no_points(lab: Lab) -> None:
    assert "of 20 points" in lab.feedback("s1")
    lab.decide("s1,hold,,Ann,copied?", "s1,comment,Come and see me.,Ann,")
    assert "Your grade is on hold." in lab.feedback("s1")
    assert "Come and see me. (Ann)" in lab.feedback("s1")
    assert not any(word in lab.feedback("s1") for word in ("copied", "points", "20"))


def test_points_by_hand_complete_a_rubric_with_a_manual_part(lab: Lab, tmp_path: Path) -> None:
    (tmp_path / "rubric.toml").write_text(default_rubric_text("manual"), encoding="utf-8")
    lab.options += ("--rubric", str(tmp_path / "rubric.toml"))
    assert "3 so far, 1 not" in lab.grade().stdout
    assert lab.points("s0") == [("so far", 15)]
    assert "15 of 20 points so far; to come: The report is clear (5)." in lab.feedback("s0")
    todo = lab.todo.splitlines()
    assert "s0,report,,,a person gives these points,s0,lab.csv" in todo
    assert any(line.startswith("s2,reported,,,no reported I_zz") and line.endswith("s2,report.pdf") for line in todo)
    lab.decide(*(f"s{i},report,{i + 1.5},Ann,clear" for i in range(3)))
    assert lab.points("s0", "s2") == [("graded", 16.5), ("not graded", None)]
    assert "1.5 of 5 | Given by hand: clear (Ann)" in lab.feedback("s0")
    assert "s0," not in lab.todo


@pytest.mark.parametrize("cut", [0, 10])
def test_a_page_of_feedback_that_somebody_wrote_in_is_kept(cut: int, lab: Lab) -> None:
    archive, page = lab.out / "feedback.zip", lab.out / "feedback" / "s0" / "feedback.md"
    archive.write_bytes(archive.read_bytes()[: -cut or None])
    page.write_text(page.read_text(encoding="utf-8") + "well done\n", encoding="utf-8")
    told = lab.grade().stderr
    assert "feedback/s0/feedback.md was changed by hand; what it was is kept as published/feedback/" in told
    (kept,) = (lab.out / "published" / "feedback").rglob("*.md")
    assert kept.read_text(encoding="utf-8").endswith("well done\n")
    assert "was changed by hand" not in lab.decide("s0,total,3,,"), "gyro wrote it last"


def test_tables_as_a_spreadsheet_saves_them_are_read(lab: Lab) -> None:
    table = lab.out / "grades.csv"
    table.write_text(table.read_text().replace(".00,", ",").replace(",", ";"), encoding="utf-8")
    lab.decide("S0;total;12,5;x", ";;;", "s1;comment;'=1+1;", "s1;total;;", head="\ufeffStudent;What;Value;Look")
    assert lab.points("s0", "s1") == [("graded", 12.5), ("graded", 20)]
    assert "=1+1" in lab.feedback("s1")
    assert "set by hand" not in lab.todo
