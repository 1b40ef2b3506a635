"""The desk: what a person decides holds whatever happens, is said, and is refused as a whole where it is wrong."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from grading.classes import make_folder
from grading.reports import RIGHT, reported_line, sheet
from typer.testing import CliRunner, Result

from gyrodata import schema
from gyrodata.cli import app
from gyrodata.grading import default_rubric, default_rubric_text, read_desk

HEAD = "student,what,value,by,why\n"
STUDENTS = {"7": {"7"}, "doejane": {"7"}, "8": {"8"}, "roe": {"8"}}


def a_log(seed: int, reports: bool = True, head: str = "# station: 3") -> str:
    rows = sheet(np.random.default_rng(seed), "mixed")
    return rows.log(head, *([reported_line(*RIGHT.inertia(rows, "with_constant"))] if reports else []))


class Lab:
    """A class of four, and the folder of its grades."""

    def __init__(self, home: Path) -> None:
        self.root, self.out = home / "class", home / "grades"
        make_folder(self.root, {f"s{i}/lab.csv": a_log(i, reports=i != 2) for i in range(4)})
        make_folder(self.root, {"s2/report.pdf": b"%PDF-1.4"})

    def grade(self, *options: str | Path) -> Result:
        done = CliRunner().invoke(
            app, ["grade", str(self.root), "-o", str(self.out), "--workers", "1", *map(str, options)]
        )
        assert done.exit_code in (0, 1), done.stderr
        return done

    def desk(self, *lines: str) -> None:
        (self.out / "desk.csv").write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")

    @property
    def students(self) -> Mapping[str, Mapping[str, object]]:
        document = json.loads((self.out / "grades.json").read_text(encoding="utf-8"))
        jsonschema.validate(document, schema.grades_schema())
        return {one["student"]: one for one in document["students"]}

    def feedback(self, student: str) -> str:
        return (self.out / "feedback" / student / "feedback.md").read_text(encoding="utf-8")


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    return Lab(tmp_path)


def test_resubmission_is_told_until_its_desk_line_changes(lab: Lab) -> None:
    lab.grade()
    lab.desk("s0,total,16,Ann,agreed")
    lab.grade()
    assert lab.students["s0"]["look"] == []
    before = lab.students["s0"]["digest"]
    (lab.root / "s0" / "lab.csv").write_text(a_log(9))
    for _ in range(2):
        lab.grade()
        (look,) = lab.students["s0"]["look"]
        assert look.startswith("resubmitted since total 16 was set by hand")
        assert lab.students["s0"]["points"] == 16
        assert "\ns0,total,,,resubmitted" in (lab.out / "desk-todo.csv").read_text()
    lab.desk("s0,total,16,Ann,agreed; still holds")
    lab.grade()
    assert lab.students["s0"]["look"] == []
    assert lab.students["s0"]["digest"] != before


def test_a_decision_that_is_taken_back_leaves_nothing(lab: Lab) -> None:
    lab.grade()
    first = {path: path.read_bytes() for path in lab.out.rglob("*") if path.is_file() and "published" not in str(path)}
    lab.desk("s0,total,16,,", "s2,reported,4.44e-3 ± 0.05e-3 kg m^2,,", "s3,station,9,,", "s1,hold,,,")
    assert "graded 1 (the desk changed): s2" in lab.grade().stderr
    assert [lab.students[one]["status"] for one in ("s0", "s1", "s2")] == ["graded", "on hold", "graded"]
    lab.desk()
    lab.grade()
    del first[lab.out / "journal.ndjson"]
    assert {path: path.read_bytes() for path in first} == first


def test_what_is_on_hold_shows_no_points(lab: Lab) -> None:
    lab.grade()
    assert "of 20 points" in lab.feedback("s1")
    lab.desk("s1,hold,,Ann,copied?", "s1,comment,Come and see me.,Ann,")
    lab.grade()
    assert "Your grade is on hold." in lab.feedback("s1")
    assert "Come and see me. (Ann)" in lab.feedback("s1")
    assert not any(word in lab.feedback("s1") for word in ("copied", "points", "20"))


def test_points_by_hand_complete_a_rubric_with_a_manual_part(lab: Lab, tmp_path: Path) -> None:
    rubric = tmp_path / "rubric.toml"
    rubric.write_text(default_rubric_text("manual"), encoding="utf-8")
    done = lab.grade("--rubric", rubric)
    assert "3 so far, 1 not" in done.stdout
    assert (lab.students["s0"]["status"], lab.students["s0"]["points"]) == ("so far", 15)
    assert "15 of 20 points so far; to come: The report is clear (5)." in lab.feedback("s0")
    todo = (lab.out / "desk-todo.csv").read_text(encoding="utf-8").splitlines()
    assert "s0,report,,,a person gives these points,s0,lab.csv" in todo
    assert any(line.startswith("s2,reported,,,no reported I_zz") and line.endswith("s2,report.pdf") for line in todo)
    lab.desk(*(f"s{i},report,{i + 1.5},Ann,clear" for i in range(3)))
    lab.grade("--rubric", rubric)
    assert (lab.students["s0"]["status"], lab.students["s0"]["points"]) == ("graded", 16.5)
    assert "1.5 of 5 | Given by hand: clear (Ann)" in lab.feedback("s0")
    assert lab.students["s2"]["status"] == "not graded"
    assert "s0," not in (lab.out / "desk-todo.csv").read_text()


@pytest.mark.parametrize("cut", [0, 10])
def test_a_page_of_feedback_that_somebody_wrote_in_is_kept(cut: int, lab: Lab) -> None:
    lab.grade()
    archive = lab.out / "feedback.zip"
    archive.write_bytes(archive.read_bytes()[: -cut or None])
    page = lab.out / "feedback" / "s0" / "feedback.md"
    page.write_text(page.read_text(encoding="utf-8") + "well done\n", encoding="utf-8")
    told = lab.grade().stderr
    assert "feedback/s0/feedback.md was changed by hand; what it was is kept as published/feedback/" in told
    (kept,) = (lab.out / "published" / "feedback").rglob("*.md")
    assert kept.read_text(encoding="utf-8").endswith("well done\n")
    lab.desk("s0,total,3,,")
    assert "was changed by hand" not in lab.grade().stderr, "gyro wrote it last"


def test_table_saved_by_a_spreadsheet_counts_as_unchanged(lab: Lab) -> None:
    lab.grade()
    table = lab.out / "grades.csv"
    table.write_text(table.read_text().replace(".00,", ",").replace(",", ";"), encoding="utf-8")
    lab.grade()
    assert "set by hand" not in (lab.out / "desk-todo.csv").read_text()


def test_a_desk_as_a_spreadsheet_saves_it() -> None:
    text = "\ufeffStudent;What;Value;Look\r\nDoeJane;total;12,5;x\r\n;;;\r\n8;comment;'=1+1;\r\n8;total;;\r\n"
    desk = read_desk(text.encode(), STUDENTS, default_rubric())
    assert [(one.what, one.value) for one in desk.lines["7"]] == [("total", "12,5")]
    assert [(one.what, one.value) for one in desk.lines["8"]] == [("comment", "=1+1")]
    assert desk.decides("8", "total")
    assert desk.value("8", "total") is None
    assert read_desk(b"", STUDENTS, default_rubric()).lines == {}
