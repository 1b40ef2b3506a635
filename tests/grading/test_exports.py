"""Grades go back to students and platforms: only what should change changes, and no
text from outside is obeyed.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from grading.classes import make_folder
from grading.students_reports import (
    RIGHT,
    SLIPS,
    STATED,
    Formula,
    reported_line,
    sheet,
    three_grades,
)
from msgspec.structs import replace
from pages import Structure
from places import DATA
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.grading.exports import gradebooks
from gyrodata.grading.exports.gradebooks import fill_book
from gyrodata.grading.exports.gradescope import results_json
from gyrodata.grading.exports.pages import feedback_pages
from gyrodata.grading.grade import Grade, grade_submission
from gyrodata.grading.rubric import read_rubric
from gyrodata.grading.submissions import submission_of
from gyrodata.grading.submissions.names import read_live

Rows = list[list[str]]


# --- feedback ---

GRADES = three_grades()


def a_grade(student: str, points: float | None = 17.5, **changes: Any) -> Grade:
    found = GRADES["waiting" if points is None else "good"]
    return replace(
        found, student=student, name=student.title(), points=points, **changes
    )


@pytest.mark.parametrize("name", GRADES)
def test_feedback_is_the_stored_text_and_the_page_agrees(name: str) -> None:
    """After an intended change, write the new text into the file in tests/data."""
    assert feedback_pages(GRADES[name])[".md"] == (
        DATA / f"feedback_{name}.md"
    ).read_text(encoding="utf-8")
    text = feedback_pages(GRADES[name])[".html"]
    page = Structure(text)
    assert (
        ("Not graded yet" in page.text)
        == (name == "waiting")
        == ("of 20 points" not in page.text)
    )
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in page.tags}
    sources = [
        str(value)
        for _, one in page.tags
        for key, value in one.items()
        if key in ("src", "href")
    ]
    assert sources == [], "it needs no other file"


def with_everywhere(text: str) -> Grade:
    """Put a text wherever one comes from a student, a platform or a rubric."""
    grade = GRADES["slip"]
    marks = tuple(
        replace(mark, title=text, reason=f"{text} {i}", rule=text)
        for i, mark in enumerate(grade.marks)
    )
    told = tuple({**one, "message": text, "hint": text} for one in grade.diagnostics)
    reported = {**grade.reported, "text": text}
    return replace(
        grade,
        name=text,
        title=text,
        late_reason=text,
        reported=reported,
        marks=marks,
        diagnostics=told,
    )


def test_page_obeys_nothing_from_outside() -> None:
    page = Structure(
        feedback_pages(
            with_everywhere("<img src=x onerror=alert(1)>\"'&</td>{{ 7*7 }}")
        )[".html"]
    )
    assert [tag for tag, _ in page.tags] == [
        tag for tag, _ in Structure(feedback_pages(with_everywhere("x"))[".html"]).tags
    ]
    assert "49" not in page.text


def test_markdown_obeys_nothing_from_outside() -> None:
    text = "x`*_[a](b)<i>#|~$&\n# x\r\t\u202e\u2028"
    before, after = (feedback_pages(with_everywhere(one))[".md"] for one in ("x", text))
    assert after.count("\n") == before.count("\n")
    assert not {"\u202e", "\u2028", "\t", "<"} & set(after)
    bare = re.sub(r"\\[\\`*_\[\]|~$]", "", after)
    assert not re.search(r"\]\(|`", bare)
    assert bare.count("|") == before.replace(r"\|", "").count("|")


# --- sheets of somebody else's ---

BOOKS: dict[str, dict[str, Any]] = tomllib.loads(
    (DATA / "gradebooks.toml").read_text("utf-8")
)
"""Sheets; who is filled; what was there before; and why somebody is skipped; a student
w... is not graded."""


def rows_of(text: str, part: str = ",") -> Rows:
    return list(csv.reader(io.StringIO(text, newline=""), delimiter=part))


def exported(book: str) -> Rows:
    return [
        [cell.partition("→")[0] for cell in row]
        for row in rows_of(BOOKS[book]["sheet"])
    ]


def as_csv(
    rows: Rows,
    encoding: str = "utf-8",
    end: str = "\n",
    part: str = ",",
    quoting: int = 0,
) -> bytes:
    out = io.StringIO()
    csv.writer(out, delimiter=part, quoting=quoting, lineterminator=end).writerows(rows)  # type: ignore[arg-type]
    return out.getvalue().encode(encoding)


WRITERS: dict[str, tuple[Callable[[Rows], bytes], str, str]] = {
    "the platform": (as_csv, "utf-8", ","),
    "Excel, semicolons": (
        lambda rows: as_csv(rows, "utf-8-sig", "\r\n", ";"),
        "utf-8-sig",
        ";",
    ),
    "tabs": (lambda rows: as_csv(rows, "utf-8", "\r\n", "\t"), "utf-8", "\t"),
}


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("book", BOOKS)
def test_only_grades_and_comments_of_a_book_change(
    book: str, writer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gradebooks, "feedback_comment", lambda _: "Well <done>\nJane")
    write, encoding, part = WRITERS[writer]
    before = exported(book)
    after = [
        [cell.rpartition("→")[2] for cell in row]
        for row in rows_of(BOOKS[book]["sheet"])
    ]
    filled, changed, skipped = (
        BOOKS[book][key] for key in ("filled", "changed", "skipped")
    )
    skipped = {
        key: why.replace("WHY", str(GRADES["waiting"].why))
        for key, why in skipped.items()
    }
    students = {*filled, *(key for key in skipped if " " not in key)}
    grades = [
        a_grade(one.removeprefix("w"), None if one[0] == "w" else 17.5)
        for one in students
    ]
    data = write(before)
    assert rows_of(data.decode(encoding), part) == before, (
        "the program itself has kept every cell"
    )
    assignment = {"canvas": "123456"}.get(book)
    found = fill_book(data, "book.csv", grades, assignment=assignment)
    assert found.file == f"{book.split()[0]}.csv"
    assert rows_of(found.data.decode(encoding), part) == after
    assert found.data[:3] == data[:3]
    assert (list(found.filled), [list(one) for one in found.changed]) == (
        filled,
        changed,
    )
    assert dict(found.skipped) == {
        key.removeprefix("w") if key[1:].isdigit() else key: skipped[key]
        for key in skipped
    }


# --- Gradescope ---

RUBRIC = read_rubric(STATED.encode())
TEST = {
    "score",
    "max_score",
    "status",
    "name",
    "name_format",
    "number",
    "output",
    "output_format",
    "tags",
    "visibility",
    "extra_data",
}
RESULTS = {
    "score",
    "execution_time",
    "output",
    "output_format",
    "test_output_format",
    "test_name_format",
    "tests",
    "visibility",
    "stdout_visibility",
    "extra_data",
    "leaderboard",
}
"""The keys of results as Gradescope publishes them."""
# https://gradescope-autograders.readthedocs.io/en/latest/submission_metadata/
METADATA = """{"id": 123456, "created_at": "2018-07-01T14:22:32.365935-07:00", "submission_method": "upload",
"assignment": {"due_date": "2018-07-31T23:00:00.000000-07:00", "late_due_date": null, "total_points": "20.0"},
"users": [{"email": "student@example.com", "id": 1234, "name": "Student User"}]}"""  # noqa: E501


def results_of(text: str) -> tuple[dict[str, Any], str, str]:
    """Compare results with what Gradescope takes; give also what a student sees before
    the due date, and after it.
    """
    results: dict[str, Any] = json.loads(text, parse_constant=pytest.fail)
    assert set(results) <= RESULTS
    assert all(set(test) <= TEST for test in results["tests"])
    assert sum(test["max_score"] for test in results["tests"]) == 20
    assert all(0 <= test["score"] <= test["max_score"] for test in results["tests"])
    hidden = [
        test for test in results["tests"] if test["visibility"] == "after_due_date"
    ]
    shown = [
        f"{test['name']} {test['output']}"
        for test in results["tests"]
        if test not in hidden
    ]
    return (
        results,
        "\n".join([results["output"], *shown]),
        "\n".join(test["output"] for test in hidden),
    )


def handed_in(root: Path, log: str) -> tuple[Grade, str, str]:
    """Grade a log as the autograder has it."""
    make_folder(root, {"submission/lab.csv": log})
    grade = grade_submission(submission_of([root / "submission"])[0], RUBRIC)
    return grade, *results_of(results_json(grade))[1:]


def tells(text: str, value: float) -> bool:
    """Whether a text contains a number, with whatever power of ten."""
    found = [
        one / value for one in map(float, re.findall(r"\d+(?:\.\d+)?", text)) if one
    ]
    return any(abs(one / 10 ** round(math.log10(one)) - 1) < 0.02 for one in found)


WRONG = {
    kind: SLIPS[kind]
    for kind in ("rpm_as_rad_s", "g_as_kg", "turns_forgotten", "rpm_as_rad_s + g_as_kg")
}
WRONG |= {"nobody knows why": Formula(answer=1.3), "half": Formula(answer=0.5)}
ROWS = sheet(np.random.default_rng(3), turns="mixed")
VALUE, U = RIGHT.inertia(ROWS, "through_origin")


@pytest.mark.slow
@pytest.mark.parametrize("kind", WRONG)
def test_gradescope_hides_the_right_value_from_a_wrong_report(
    kind: str, tmp_path: Path
) -> None:
    grade, seen, hidden = handed_in(
        tmp_path, ROWS.log(reported_line(*WRONG[kind].inertia(ROWS, "through_origin")))
    )
    text = seen.replace(str(grade.reported["text"]), "")
    text = re.sub(r"\S+ × \S+ kg·m² is not between", "yours is not between", text)
    assert not tells(text, VALUE), text
    assert any(tells(line, VALUE) for line in hidden.splitlines()), (
        "after the due date it is told"
    )
    assert all(slip.words in text for slip in grade.slips)
    assert "I_zz follows from your own runs: " in text


@pytest.mark.parametrize(
    ("share", "said"), [(0.0, "met"), (2.5, "met in part"), (30.0, "not met")]
)
def test_gradescope_says_how_far_the_answer_is_met(
    share: float, said: str, tmp_path: Path
) -> None:
    grade, seen, _ = handed_in(tmp_path, ROWS.log(reported_line(VALUE + share * U, U)))
    assert (
        f"I_zz follows from your own runs: {said}. The points are shown after the due date."
        in seen
    ), grade.marks


@pytest.fixture(scope="module")
def autograder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What Gradescope makes of the folder, with the libraries that are here."""
    root = make_folder(
        tmp_path_factory.mktemp("autograder"), {"rubric.toml": STATED, "results/": ""}
    )
    words = [
        "grade",
        "--gradescope",
        str(root / "source"),
        "--rubric",
        str(root / "rubric.toml"),
    ]
    done = CliRunner().invoke(app, words)
    told = "in Gradescope: 20 autograder points, and a due date, after which all feedback is shown"
    assert (done.exit_code, done.stderr.splitlines()[1:]) == (0, [told])
    needed = (
        (root / "source" / "requirements.txt").read_text(encoding="utf-8").splitlines()
    )
    names = {re.split(r"\W", one)[0] for one in needed}
    assert names & {"numpy", "jinja2", "distributed", "pytest"} == {"numpy", "jinja2"}
    subprocess.run(["bash", "-n", root / "source" / "setup.sh"], check=True)
    make_folder(root, {"gyro/bin/python": f'#!/bin/sh\nexec "{sys.executable}" "$@"\n'})
    (root / "gyro/bin/python").chmod(0o755)
    return Path(shutil.copy(root / "source" / "run_autograder", root)).parent


@pytest.mark.slow
@pytest.mark.parametrize("good", [True, False])
def test_the_autograder_grades_what_gradescope_gives_it(
    autograder: Path, good: bool
) -> None:
    log = ROWS.log(reported_line(VALUE, U)) if good else "PK\x03\x04\x00"
    make_folder(
        autograder, {"submission_metadata.json": METADATA, "submission/lab.csv": log}
    )
    subprocess.run([autograder / "run_autograder"], check=True, cwd="/")
    (written,) = (autograder / "results").iterdir()
    results, _, _ = results_of(written.read_text("utf-8"))
    assert written.name == "results.json"
    assert (results["score"], results["extra_data"]["status"]) == (
        (20.0, "graded") if good else (0.0, "not graded")
    )
    assert ("This could not be graded: " in results["output"]) != good


def autograde(root: Path, files: dict[str, str], rubric: str = STATED) -> str:
    make_folder(root, {"source/rubric.toml": rubric, **files})
    done = CliRunner().invoke(app, ["autograde", str(root)])
    assert done.exit_code == 0, done.stderr
    return (root / "results" / "results.json").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("content", ["no log at all", "\x00", None])
def test_the_autograder_never_fails_for_what_is_submitted(
    content: str | None, tmp_path: Path
) -> None:
    submitted = (
        {"submission/": ""} if content is None else {"submission/lab.csv": content}
    )
    results, _, _ = results_of(
        autograde(tmp_path, {"submission_metadata.json": "broken", **submitted})
    )
    assert (results["score"], results["extra_data"]["status"]) == (0.0, "not graded")
    assert re.match(
        "This could not be graded: .*\nThis is not a zero", results["output"]
    )
    assert not any("status" in test for test in results["tests"]), "none has failed"


def test_running_autograder_knows_the_student_and_the_lateness(tmp_path: Path) -> None:
    about = read_live(METADATA.replace("2018-07-31T23", "2018-06-30T23").encode())
    make_folder(tmp_path, {"submission/lab.csv": ROWS.log()})
    submission, _ = submission_of([tmp_path / "submission"], about)
    assert (submission.student, submission.name, submission.late) == (
        "student@example.com",
        "Student User",
        True,
    )
    assert submission.late_seconds == pytest.approx(55352.365935)
