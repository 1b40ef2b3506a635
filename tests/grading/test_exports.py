"""Grades go back to where they came from: only what is meant to change changes, and what would be lost is told."""

import csv
import functools
import io
import json
import math
import re
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from grading.classes import make_folder
from grading.reports import RIGHT, SLIPS, Formula, reported_line, sheet
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from gyrodata.diagnostics import CODES
from gyrodata.errors import InputError
from gyrodata.grading import (
    Flag,
    Grade,
    Mark,
    Rubric,
    autograder_files,
    default_rubric_text,
    fill_book,
    find_submissions,
    grade_autograder,
    grade_submission,
    grades_csv,
    read_rubric,
    read_sheet,
    results_json,
)

fill_gradebook = functools.partial(fill_book, "canvas", name="gradebook.csv")
fill_grade_center = functools.partial(fill_book, "blackboard", name="gc_fullgc.csv")
fill_worksheet = functools.partial(fill_book, "moodle", name="worksheet.csv")
OUT_OF = (2.0, 6.0, 12.0)


def made(kind: type[Any], /, **fields: object) -> Any:
    """Make a noun of which only these fields matter."""
    return kind(**(dict.fromkeys(kind.__struct_fields__) | fields))


def a_grade(student: str, points: Sequence[float | None] = (2.0, 4.5, 11.0), **fields: object) -> Grade:
    """Make a grade with three criteria; what a test does not speak of is empty."""
    marks = tuple(
        Mark(f"c{number}", f"Criterion {number}", "log", got, most, f"r{number}", {}, "")
        for number, (got, most) in enumerate(zip(points, OUT_OF, strict=True))
    )
    graded = None not in points
    total = sum(point or 0.0 for point in points) if graded else None
    values: dict[str, object] = {
        "student": student, "name": student.title(), "status": "graded" if graded else "not graded", "points": total,
        "out_of": 20.0, "why": None if graded else "the log cannot be read", "marks": marks, "slips": (), "look": (),
        "reported": {}, "own": {}, "late_deduction": 0.0, "late_reason": "", "diagnostics": (), "by_hand": (),
        "title": "Lab", "rubric": "r", "digest": "d",
    }  # fmt: skip
    return made(Grade, **(values | fields))


def rows_of(data: bytes | str, delimiter: str = ",") -> list[list[str]]:
    text = data.decode("utf-8-sig") if isinstance(data, bytes) else data
    return list(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))


# --- grades.csv ---------------------------------------------------------------------------------------------


def test_grades_csv_has_points_possible_and_each_criterion() -> None:
    grades = [
        a_grade("bob", late_seconds=7200.0, late_deduction=2.0, late_reason="2 h late"),
        a_grade("ann", (2.0, None, None)),
        a_grade("kim", matched="through_origin", d=0.123456, zeta=1.0, reported={"value": 4.4e-3, "u": 5e-5}),
    ]
    flag = made(Flag, kind="shared rows", students=("ann", "bob"), evidence="7 of 9", previous=())
    text = grades_csv(grades, [flag])
    rows = rows_of(text)
    head = rows[0]
    assert head[:7] == ["student", "name", "status", "total", "c0", "c1", "c2"]
    assert rows[1][:7] == ["points possible", "", "--", "20.00", "2.00", "6.00", "12.00"]
    assert [row[0] for row in rows[2:]] == ["ann", "bob", "kim"]
    table = {row[0]: dict(zip(head, row, strict=True)) for row in rows[1:]}
    assert table["ann"]["total"] == table["ann"]["c1"] == "", "not a zero by accident"
    assert table["ann"]["why_not_graded"] == "the log cannot be read"
    assert table["ann"]["flags"] == "shared rows with bob"
    late = [table["bob"][column] for column in ("total", "late_deduction", "late [s]", "late")]
    assert late == ["17.50", "2.00", "7200.0", "2 h late"]
    assert (table["kim"]["reported [kg*m^2]"], table["kim"]["d"]) == ("0.0044", "0.1235")
    assert grades_csv(list(reversed(grades)), [flag]) == text, "the order makes no difference"


@pytest.mark.parametrize(
    "evil", ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "\r=1", "＝1", '=HYPERLINK("x","y")', "a,b\n=1"]
)
def test_no_cell_of_grades_is_a_formula(evil: str) -> None:
    text = grades_csv([a_grade(evil, (None, None, None), name=evil, why=evil, look=(evil,))])
    for row in rows_of(text):
        assert not any(cell[:1] in tuple("=+-@\t\r＝") for cell in row if cell != "--")


# --- sheets of somebody else's ------------------------------------------------------------------------------


@given(st.lists(st.lists(st.text('a b",\n;é', max_size=6), min_size=2, max_size=4), min_size=1, max_size=4),
       st.sampled_from(["\n", "\r\n"]), st.sampled_from([csv.QUOTE_ALL, csv.QUOTE_MINIMAL]), st.data())  # fmt: skip
@settings(derandomize=True, deadline=None, max_examples=100)
def test_a_changed_cell_changes_alone(table: list[list[str]], end: str, quoting: int, data: st.DataObject) -> None:
    table[0] = ["head", *(f"h{n}" for n in range(len(table[0]) - 1))]
    out = io.StringIO(newline="")
    csv.writer(out, lineterminator=end, quoting=quoting).writerows(table)  # type: ignore[arg-type]
    sheet = read_sheet(out.getvalue().encode(), "x.csv")
    row = data.draw(st.integers(0, len(table) - 1))
    column = data.draw(st.integers(0, len(table[row]) + 1))
    new = data.draw(st.text('1,"\nx ', max_size=5))
    sheet.put(row, column, new)
    table[row] += [""] * (column + 1 - len(table[row]))
    table[row][column] = new
    assert rows_of(sheet.to_bytes()) == [
        one if one != [""] else rows_of(sheet.to_bytes())[at] for at, one in enumerate(table)
    ]


def test_bytes_that_are_no_utf8_are_kept() -> None:
    data = b"Student,ID,x\n\xe9t\xe9,1,\n"
    sheet = read_sheet(data, "x.csv")
    sheet.put(1, 2, "5")
    assert sheet.to_bytes() == b"Student,ID,x\r\n\xe9t\xe9,1,5\r\n"


# --- Canvas -------------------------------------------------------------------------------------------------

GRADEBOOK = (
    "Student,ID,SIS User ID,SIS Login ID,Section,Homework (111),Gyroscope lab (123456),Quiz (222),Final Score\r\n"
    "    Points Possible,,,,,10.00,20.00,5.00,(read only)\r\n"
    '"Doe, Jane",9876,s001,jdoe,PHYS-02,"1,5",,3,17.5\r\n'
    "李 雷,9877,s002,li@uni.example,PHYS-02,-,12.00,,\r\n"
    '"O""Neil, Zoë",9878,s003,zoe,PHYS-02,7, EX ,,\r\n'
    '"=cmd, Bob",9879,s004,bob,PHYS-03,7,"3.00",,\r\n'
    "\r\n"
    '"Student, Test",9999,,,PHYS-02,,,,\r\n'
)


def test_canvas_fills_one_column_and_leaves_every_other_cell() -> None:
    grades = [
        a_grade("9876"),
        a_grade("9877", (2.0, 6.0, 4.0)),
        a_grade("9878"),
        a_grade("9879", (2.0, None, None)),
        a_grade("5555"),
    ]
    data = ("\ufeff" + GRADEBOOK).encode()
    filled = fill_gradebook(data, grades=grades, assignment="123456")
    assert filled.data.startswith(b"\xef\xbb\xbf")
    assert filled.data.count(b"\r\n") == GRADEBOOK.count("\r\n")
    assert rows_of(filled.data) == rows_of(GRADEBOOK.replace('"1,5",,3,17.5', '"1,5",17.50,3,17.5'))
    assert filled.filled == ("9876", "9877")
    assert filled.changed == ()
    assert dict(filled.skipped) == {
        "5555": "is in no row of the gradebook",
        "9878": 'has "EX" in the gradebook: excused or not assigned',
        "9879": "is not graded: the log cannot be read",
        "Student, Test": "has no submission",
    }


@pytest.mark.parametrize(
    ("student", "ids"),
    [
        ("9876", {}),
        ("doe", {"canvas": "9876"}),
        ("s001", {"sid": "s001"}),
        ("s001", {}),
        ("jdoe", {}),
        ("x", {"username": "JDOE"}),
    ],
)
def test_canvas_knows_a_student_by_any_of_three_numbers(student: str, ids: dict[str, str]) -> None:
    filled = fill_gradebook(GRADEBOOK.encode(), grades=[a_grade(student)], assignment="123456", ids={student: ids})
    assert rows_of(filled.data)[2][6] == "17.50"


# --- Blackboard ---------------------------------------------------------------------------------------------

GRADE_CENTER = """\
"Last Name","First Name","Username","Student ID","Last Access","Availability",\
"Lab [EXTRA] [Total Pts: 20 Score] |11","Lab [Total Pts: 20] |12","Quiz [Total Pts: 20 Percentage] |13",\
"Total [Total Pts: up to 1,040 Score] |14","Weighted Total [Total Pts: up to 0 Percentage] |15"
"Doe","Jane","jdoe","0012","2026-03-09 14:05:59","Yes","","","","",""
"Roe","Bob","broe","0013","","Yes","","Needs Grading(3.00)","","",""
"Fox","Dan","dfox","0014","","Yes","","In Progress","","",""
"O'Neil","Zoë","zoe","0015","","Yes","","Exempt","","",""
"Lee","Ann","alee","0016","","Yes","","3.00","","",""
"Poe","Cat","cpoe","0017","","No","","","","",""
"""


def test_blackboard_fills_one_column_and_leaves_every_other_cell() -> None:
    grades = [a_grade(one) for one in ("jdoe", "BROE", "0014", "zoe", "alee", "nobody")]
    filled = fill_grade_center(GRADE_CENTER.encode(), grades=grades, assignment="12", ids={"x": {"username": "jdoe"}})
    expected = rows_of(GRADE_CENTER)
    for row in (1, 2, 3, 5):
        expected[row][7] = "17.50"
    assert rows_of(filled.data) == expected
    assert filled.filled == ("0014", "BROE", "alee", "jdoe")
    # What waits to be graded is no grade that is lost.
    assert filled.changed == (("alee", "3.00", "17.50"),)
    assert dict(filled.skipped) == {
        "nobody": "is in no row of the Grade Center",
        "zoe": 'has "Exempt" in the gradebook: excused or not assigned',
        "Poe, Cat": "has no submission",
    }


# --- Moodle -------------------------------------------------------------------------------------------------

WORKSHEET = (
    'Identifier,"Full name","ID number","Email address",Status,Group,Grade,"Maximum Grade","Grade can be changed",'
    '"Last modified (submission)","Last modified (grade)","Feedback comments"\n'
    'Participant 101,"Doe, Jane",0012,jane@uni.example,"Submitted for grading - ","Group A",,20.00,Yes,'
    '"Monday, 9 March 2026, 2:05 PM",-,\n'
    'Participant 102,"Zoë ""Z"" =1+1",+7,z@uni.example,"Submitted for grading",,17.50,20.00,Yes,-,"Mon, 9 March",""\n'
    'Participant 103,李雷,0014,l@uni.example,"No submission",,,20.00,Yes,-,-,\n'
    'Participant 104,Bob,0015,b@uni.example,Submitted,,3.00,20.00,No,-,-,"<p>old</p>"\n'
    'Participant 105,Kim,0016,k@uni.example,Submitted,,"3.00",20.00,Yes,-,-,"<p>old</p>"\n'
    "Participant 106,Ann,0017,a@uni.example,Submitted,,,20.00,Yes,-,-,\n"
)


@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_moodle_fills_two_columns_and_leaves_every_other_cell(mark: str, end: str) -> None:
    sheet = (mark + WORKSHEET).replace("\n", end)
    grades = [a_grade("101"), a_grade("102"), a_grade("104"), a_grade("105"), a_grade("106", (None,) * 3), a_grade("9")]
    comments = dict.fromkeys(["101", "102", "104", "105", "106"], "Well <done>,\nJane")
    filled = fill_worksheet(sheet.encode(), grades=grades, comments=comments)
    comment = "<p>Well &lt;done&gt;,<br>Jane</p>"
    expected = rows_of(WORKSHEET)
    for row in (1, 2, 5):
        expected[row][6], expected[row][11] = "17.50", comment
    assert rows_of(filled.data) == expected
    assert filled.data.startswith(mark.encode())
    assert filled.filled == ("101", "102", "105")
    assert filled.changed == (("105", "3.00", "17.50"), ("105", "<p>old</p>", comment))
    assert dict(filled.skipped) == {
        "102": "has 17.50 in Moodle already: Moodle passes over the grade",
        "104": "is locked in Moodle: the grade cannot be changed",
        "106": "is not graded: the log cannot be read",
        "9": "is in no row of the worksheet",
        "Participant 103 (李雷)": "has no submission",
    }


GERMAN = (
    "ID,Vollständiger Name,E-Mail-Adresse,Status,Bewertung,Bestwertung,Bewertung kann geändert werden,"
    "Zuletzt geändert (Abgabe),Zuletzt geändert (Bewertung),Feedback als Kommentar\n"
    'Teilnehmer/in11,Jane Doe,j@uni.example,Abgegeben,,"20,00",Ja,-,-,\n'
    'Teilnehmer/in12,Bob Roe,b@uni.example,Abgegeben,,"20,00",Nein,-,-,\n'
)


def test_moodle_in_another_language() -> None:
    filled = fill_worksheet(GERMAN.encode(), grades=[a_grade("11"), a_grade("12")], comments={"11": "Gut"})
    assert rows_of(filled.data)[1][4] == "17,50"
    assert rows_of(filled.data)[1][9] == "<p>Gut</p>"
    assert dict(filled.skipped) == {"12": "is locked in Moodle: the grade cannot be changed"}


def test_moodle_gives_the_grade_of_a_group_to_its_members() -> None:
    sheet = WORKSHEET.replace("Submitted,,", 'Submitted,"Group A",')
    group = a_grade("102", name="Group A")  # the group's number is that of another participant
    filled = fill_worksheet(sheet.encode(), grades=[group], ids={"102": {"moodle": "102"}})
    graded = [row[0] for row in rows_of(filled.data) if row[6] == "17.50"]
    assert graded == ["Participant 101", "Participant 102", "Participant 105", "Participant 106"]
    assert rows_of(filled.data)[2] == rows_of(WORKSHEET)[2], "102 had those points before and is not touched"
    assert filled.filled == ("102",)


# --- Gradescope ---------------------------------------------------------------------------------------------

RUBRIC = default_rubric_text().replace(
    '[reference]\nfrom = "class"', '[reference.all]\ninertia = "4.44e-3 kg m^2"\nu = "0.02e-3 kg m^2"'
)
STATED = read_rubric(RUBRIC.encode())
SHOWN = {"enum": ["hidden", "after_due_date", "after_published", "visible"]}
WRITTEN = {"enum": ["text", "html", "simple_format", "md", "ansi"]}
TEST = {
    "score": {"type": "number"}, "max_score": {"type": "number"}, "status": {"enum": ["passed", "failed"]},
    "name": {"type": "string"}, "name_format": WRITTEN, "number": {"type": "string"}, "output": {"type": "string"},
    "output_format": WRITTEN, "tags": {"type": "array"}, "visibility": SHOWN, "extra_data": {"type": "object"},
}  # fmt: skip
RESULTS = {
    "score": {"type": "number", "minimum": 0}, "execution_time": {"type": "number"}, "output": {"type": "string"},
    "output_format": WRITTEN, "test_output_format": WRITTEN, "test_name_format": WRITTEN, "visibility": SHOWN,
    "stdout_visibility": SHOWN, "extra_data": {"type": "object"}, "leaderboard": {"type": "array"},
    "tests": {"type": "array", "items": {"type": "object", "properties": TEST, "additionalProperties": False}},
}  # fmt: skip
"""The keys of results as Gradescope publishes them."""


def results_of(text: str, out_of: float = 20.0) -> dict[str, Any]:
    """Read results, and hold them to what Gradescope takes and to what the assignment is worth."""
    results: dict[str, Any] = json.loads(text, parse_constant=pytest.fail)
    jsonschema.validate(results, {"properties": RESULTS, "additionalProperties": False, "required": ["score", "tests"]})
    assert sum(test["max_score"] for test in results["tests"]) == out_of
    assert all(0 <= test["score"] <= test["max_score"] for test in results["tests"])
    return results


def hidden(results: dict[str, Any]) -> list[dict[str, Any]]:
    return [test for test in results["tests"] if test["visibility"] == "after_due_date"]


def seen(results: dict[str, Any]) -> str:
    """What a student can read while the assignment is open."""
    open_ones = [test for test in results["tests"] if test not in hidden(results)]
    return "\n".join([results["output"], *(f"{test['name']} {test['output']}" for test in open_ones)])


def handed_in(root: Path, log: str | bytes, rubric: Rubric = STATED) -> tuple[Grade, dict[str, Any]]:
    """Grade a log as the autograder has it."""
    make_folder(root, {"submission/lab.csv": log})
    grade = grade_submission(find_submissions(root, "gradescope").items[0], rubric)
    return grade, results_of(results_json(grade), sum(one.points for one in rubric.criteria if one.check != "manual"))


def test_results_of_a_graded_submission() -> None:
    found = {"severity": "warning", "line": 3, "message": "odd", "hint": "look", "code": "G203"}
    grade = a_grade("x", late_deduction=2.0, points=(2.0, 4.5, 11.0), late_reason="late by 2 h", diagnostics=(found,))
    compared = replace(grade.marks[1], detail={"d": 1.0})
    results = results_of(results_json(replace(grade, marks=(grade.marks[0], compared, grade.marks[2]), points=15.5)))
    assert results["score"] == 15.5
    assert [test["score"] for test in results["tests"]] == [2.0, 4.5, 11.0]
    assert [test["max_score"] for test in results["tests"]] == [2.0, 6.0, 12.0]
    assert [test["status"] for test in results["tests"]] == ["passed", "failed", "failed"]
    assert [test["output"] for test in hidden(results)] == ["r1"]
    assert results["output"].split("\n") == [
        "13 of 14 points in what is shown now.",
        "Criterion 1: met in part. The points are shown after the due date.",
        "late by 2 h. 2 points are taken off.",
        "warning: line 3: odd (look)",
    ]


def test_what_cannot_be_graded_says_so_and_fails_no_test() -> None:
    results = results_of(results_json(a_grade("x", (None, None, None))))
    assert results["output"].startswith("This could not be graded: the log cannot be read.\nThat is no zero")
    assert not any("status" in test for test in results["tests"])
    assert results["extra_data"]["status"] == "not graded"


def tells(text: str, value: float) -> bool:
    """Whether a text holds a number, with whatever power of ten."""
    digits = [float(one) for one in re.findall(r"\d+(?:\.\d+)?", text)]
    found = [one / value for one in digits if one]
    return any(abs(one / 10 ** round(math.log10(one)) - 1) < 0.02 for one in found)


WRONG = {"nobody knows why": Formula(answer=1.3), "half": Formula(answer=0.5)}


@pytest.mark.parametrize("kind", [*SLIPS, *WRONG])
def test_gradescope_hides_the_right_value_from_a_wrong_report(kind: str, tmp_path: Path) -> None:
    rows = sheet(np.random.default_rng(3), turns="mixed")
    value, u = (SLIPS | WRONG)[kind].inertia(rows, "through_origin")
    grade, results = handed_in(tmp_path, rows.log(reported_line(value, u)))
    text = seen(results).replace(str(grade.reported["text"]), "")
    text = re.sub(r"\S+ × \S+ kg·m² is not between", "yours is not between", text)
    assert not tells(text, RIGHT.inertia(rows, "through_origin")[0]), text
    # After the due date it is told.
    assert any(tells(test["output"], RIGHT.inertia(rows, "through_origin")[0]) for test in hidden(results))
    assert all(slip.words in text for slip in grade.slips)
    assert "I_zz follows from your own runs: " in text


def test_gradescope_hides_the_right_u_from_a_wrong_report(tmp_path: Path) -> None:
    rows = sheet(np.random.default_rng(3), turns="mixed")
    value, u = RIGHT.inertia(rows, "through_origin")
    _, results = handed_in(tmp_path, rows.log(reported_line(value, 20 * u)))
    assert "The uncertainty is realistic: not met." in results["output"]
    assert "that the fits of your runs give" in str(hidden(results))
    assert "your runs give" not in seen(results)
    _, results = handed_in(tmp_path, rows.log(reported_line(value, None)))
    assert "no uncertainty is reported; write it behind the value" in seen(results)


@pytest.mark.parametrize("code", ["G401", "G407", "G421", "G435", "G443"])
def test_gradescope_hides_what_the_log_gives(code: str, tmp_path: Path) -> None:
    grade, results = handed_in(tmp_path, "# reported_inertia: 9e-3 kg m^2\n" + CODES[code].example)
    (found,) = [one for one in grade.diagnostics if one["code"] == code]
    where = f"line {found['line']}: " if found["line"] else ""
    assert f"{found['severity']}: {where}{CODES[code].title}" in seen(results)
    assert found["message"] not in seen(results)


METADATA = '{"id": 5, "created_at": "2026-03-09T14:00:00-08:00", "users": [{"name": "Jane", "email": "j@uni.example"}]}'


@pytest.fixture(scope="module")
def autograder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What Gradescope makes of the folder, its wheel installed beside the libraries that are here."""
    root = tmp_path_factory.mktemp("autograder")
    files = autograder_files(STATED, RUBRIC)
    assert files == autograder_files(STATED, RUBRIC)
    make_folder(root, {f"source/{name}": data for name, data in files.items()})
    (wheel,) = (name for name in files if name.endswith(".whl"))
    assert f"/autograder/source/{wheel}\n" in files["setup.sh"].decode()
    with zipfile.ZipFile(root / "source" / wheel) as packed:
        assert {entry.external_attr >> 16 for entry in packed.infolist()} == {0o644}
    library = root / "gyro" / "library"
    pip = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-index", "--no-compile"]
    subprocess.run([*pip, "--target", library, root / "source" / wheel], check=True)
    starter = f'#!/bin/sh\nPYTHONPATH="{library}" exec "{library}/bin/gyro" "$@"\n'
    make_folder(root, {"run_autograder": files["run_autograder"], "gyro/bin/gyro": starter, "results/": ""})
    for script in ("run_autograder", "gyro/bin/gyro"):
        (root / script).chmod(0o755)
    for script in ("setup.sh", "run_autograder"):
        subprocess.run(["bash", "-n", root / "source" / script], check=True)
    return root


@pytest.mark.parametrize("good", [True, False])
def test_the_autograder_grades_what_gradescope_lays_down(autograder: Path, good: bool) -> None:
    rows = sheet(np.random.default_rng(3), turns="mixed")
    log = rows.log(reported_line(*RIGHT.inertia(rows, "through_origin"))) if good else "PK\x03\x04\x00"
    make_folder(autograder, {"submission_metadata.json": METADATA, "submission/lab.csv": log})
    subprocess.run([autograder / "run_autograder"], check=True, cwd="/")
    results = results_of((autograder / "results" / "results.json").read_text("utf-8"))
    assert [path.name for path in (autograder / "results").iterdir()] == ["results.json"]
    assert (results["score"], results["extra_data"]["status"]) == ((20.0, "graded") if good else (0.0, "not graded"))
    assert ("This could not be graded: " in results["output"]) != good


@pytest.mark.parametrize("content", ["", "no log at all", "\x00", None])
def test_the_autograder_never_fails_for_what_is_submitted(
    tmp_path: Path, content: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "gyrodata.grading.classroom.in_workers", lambda work, tasks, *_: ((task, work(task)) for task in tasks)
    )
    submitted = {"submission/": ""} if content is None else {"submission/lab.csv": content}
    root = make_folder(tmp_path, {"submission_metadata.json": "broken", **submitted})
    results = results_of(grade_autograder(root, STATED))
    assert (results["score"], "could not be graded" in results["output"]) == (0.0, True)


def test_what_no_autograder_can_give_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for kind in ("simple", "full", "manual"):
        text = default_rubric_text(kind)  # type: ignore[arg-type]
        with pytest.raises(InputError, match=r"compares with the class.*nobody could earn its \d points"):
            autograder_files(read_rubric(text.encode()), text)
    without = 'schema = 1\npoints = 2\n[[criterion]]\nid = "log"\ncheck = "log"\npoints = 2\n'
    text = without + '[reference]\nfrom = "class"\n'
    assert "rubric.toml" in autograder_files(read_rubric(text.encode()), text)

    monkeypatch.setattr("gyrodata.grading.exports.gradescope.distributions", lambda name: ())
    with pytest.raises(InputError, match=r"G768.*is not installed"):
        autograder_files(STATED, RUBRIC)
