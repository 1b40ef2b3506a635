"""Sheets as platforms publish that they write them, and as pandas and Excel write them again.

What matters to a platform is held, not how a file's bytes are laid out: every cell that is not a grade or a comment,
zeros that lead a number, columns, separator, encoding.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from msgspec.structs import replace

from gyrodata.errors import InputError
from gyrodata.grading import (
    Grade,
    Submission,
    Submissions,
    default_rubric,
    fill_book,
    grade_autograder,
    grade_submission,
    read_roster,
)

# Columns, and titles with a number behind them: https://nemogb-dev.github.io/nemogb-r/articles/detailed-canvas-export-info.html
# Columns that are read only, and the row that tells how grades are posted:
# https://ts.vcu.edu/askit/teaching-and-learning/canvas/faculty/grading-faculty/gradebook-action-menu-faculty/
CANVAS = [
    ["Student", "ID", "SIS User ID", "SIS Login ID", "Section", "Gyroscope (87568490)", "Current Score", "Final Score"],
    ["", "", "", "", "", "Manual Posting", "(read only)", "(read only)"],
    ["    Points Possible", "", "", "", "", "20.00", "(read only)", "(read only)"],
    ["O'Neil, Kim", "101", "00123", "kim", 'Lab "A", Monday', "", "88.1", "40.0"],
    ["Ёлкина, Анна", "102", "00042", "anna", "Lab B", "7.00", "90.0", "45.0"],
    ["Student, Test", "", "", "c0ffee", "Lab B", "", "", ""],
]

# Columns of a worksheet: https://github.com/moodle/moodle/commit/16668320a68a2a2050d73aae724d5c0c8c4fe5ff
MOODLE = list(csv.reader(io.StringIO("""\
Identifier,Full name,Email address,Status,Grade,Maximum Grade,Grade can be changed,Last modified (submission),\
Last modified (grade),Feedback comments
Participant 101,Kim O'Neil,kim@x.edu,Submitted for grading,,20.00,Yes,"Mon, 9 March",-,
Participant 102,Анна Ёлкина,0042@x.edu,No submission,7.00,20.00,Yes,-,-,"<p>So,
so</p>"
""")))  # fmt: skip

# Tabs, a .xls that is text, students known by user name, columns by a number:
# http://library.blackboard.com/ref/3ea64795-6ecc-4abd-b595-0a9a8dfdec94/Content/_instructor_grade_center/grade_center_upload_download.htm
BLACKBOARD = [
    [*("Last Name", "First Name", "Username", "Student ID", "Last Access"), "Gyroscope [Total Pts: 20 Score] |5511"],
    ["O'Neil", "Kim", "101", "00123", "2026-03-09 14:05:59", ""],
    ["Ёлкина", "Анна", "102", "00042", "2026-03-09 14:06:00", ""],
    ["Roe", "Sam", "103", "00007", "", ""],
]

# https://gradescope-autograders.readthedocs.io/en/latest/submission_metadata/
GRADESCOPE = {
    "id": 123456, "created_at": "2018-07-01T14:22:32.365935-07:00", "submission_method": "upload",
    "assignment": {
        "due_date": "2018-07-31T23:00:00.000000-07:00", "group_size": 4, "group_submission": True, "id": 25828,
        "course_id": 1234, "late_due_date": None, "release_date": "2018-07-02T00:00:00.000000-07:00",
        "title": "Gyroscope", "total_points": "20.0",
    },
    "users": [{"email": "student@example.com", "id": 1234, "name": "Student User"}],
    "previous_submissions": [{"submission_time": "2017-04-06T14:24:48.087023-07:00", "score": 0.0, "results": {}}],
}  # fmt: skip

Rows = list[list[str]]


def as_csv(
    rows: Rows, encoding: str = "utf-8", quoting: int = csv.QUOTE_MINIMAL, end: str = "\n", part: str = ","
) -> bytes:
    out = io.StringIO()
    csv.writer(out, delimiter=part, quoting=quoting, lineterminator=end).writerows(rows)
    return out.getvalue().encode(encoding)


def by_pandas(rows: Rows) -> bytes:
    read = pd.read_csv(io.BytesIO(as_csv(rows)), dtype=str, keep_default_na=False)
    return read.to_csv(index=False).encode()


WRITERS: dict[str, Callable[[Rows], bytes]] = {
    "the platform": as_csv,
    "pandas": by_pandas,
    "Excel, CSV UTF-8": lambda rows: as_csv(rows, "utf-8-sig", end="\r\n"),
    "Excel, semicolons": lambda rows: as_csv(rows, "utf-8-sig", end="\r\n", part=";"),
    "Excel, every cell quoted": lambda rows: as_csv(rows, quoting=csv.QUOTE_ALL, end="\r\n"),
    "Excel, Unicode text": lambda rows: as_csv(rows, "utf-16", end="\r\n", part="\t"),
}


def layout(data: bytes) -> tuple[str, str]:
    """Encoding and separator of a sheet."""
    encoding = "utf-16" if data[:2] == b"\xff\xfe" else "utf-8-sig" if data[:3] == b"\xef\xbb\xbf" else "utf-8"
    head = data.decode(encoding).splitlines()[0]
    return encoding, max(",;\t", key=head.count)


def table(data: bytes) -> Rows:
    encoding, part = layout(data)
    return list(csv.reader(io.StringIO(data.decode(encoding), newline=""), delimiter=part))


@pytest.fixture(scope="module")
def grades(tmp_path_factory: pytest.TempPathFactory) -> tuple[Grade, ...]:
    """Two graded students."""
    root = tmp_path_factory.mktemp("class")
    (root / "101.csv").write_text("x", encoding="utf-8")
    blank = grade_submission(Submission("101", "101", {}, root, problem="none"), default_rubric())
    graded = replace(blank, status="graded", why=None, points=18.5)
    return graded, replace(graded, student="102", name="102", points=20.0)


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize(
    ("lms", "rows", "changed"),
    [("canvas", CANVAS, {5}), ("moodle", MOODLE, {4, 9}),
     ("blackboard", BLACKBOARD, {5})],
)  # fmt: skip
def test_a_gradebook_is_filled_and_nothing_else_in_it_changes(
    writer: str, lms: str, rows: Rows, changed: set[int], grades: tuple[Grade, ...]
) -> None:
    data = WRITERS[writer](rows)
    assert table(data) == rows, "the program itself has kept every cell"
    filled = fill_book(lms, data, "book.csv", grades, comments={"101": "Well, «done».", "102": "Good; so."})
    after = table(filled.data)
    assert layout(filled.data) == layout(data)
    assert set(filled.filled) == {"101", "102"}
    for before, now in zip(rows, after, strict=True):
        assert {at for at, (old, new) in enumerate(zip(before, now, strict=True)) if old != new} <= changed
    points = min(changed)
    assert [row[points] for row in after if row[points] in ("18.50", "20.00")][-2:] == ["18.50", "20.00"]
    again = pd.read_csv(
        io.BytesIO(filled.data), sep=layout(data)[1], encoding=layout(data)[0], dtype=str, keep_default_na=False
    )
    assert [list(again.columns), *again.to_numpy().tolist()] == after


def test_blackboards_download_is_a_roster() -> None:
    data = as_csv(BLACKBOARD, "utf-16", csv.QUOTE_ALL, "\r\n", "\t")
    items = tuple(Submission(key, key, {"username": key}, Path("class")) for key in ("101", "102"))
    found = read_roster(data, "gc_download.xls", Submissions("blackboard", items))
    assert set(found.people) == {"101", "102"}
    assert found.people["102"].name == "Анна Ёлкина"
    assert [one.student for one in found.absent] == ["103"]


def test_gradescopes_metadata_as_it_publishes_them(tmp_path: Path) -> None:
    (tmp_path / "submission").mkdir()
    (tmp_path / "submission" / "lab.csv").write_text(
        "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n40,15.0,406,13.06,2/3\n",
        encoding="utf-8",
    )
    (tmp_path / "submission_metadata.json").write_text(json.dumps(GRADESCOPE), encoding="utf-8")
    told = json.loads(grade_autograder(tmp_path, default_rubric()))
    assert {"output", "tests"} <= set(told)


@pytest.mark.parametrize(
    ("lms", "head"),
    [
        ("blackboard", 'Last Name,First Name,"Username\tID",Lab [Total Pts: 20 Score] |1\n'),
        ("canvas", 'Student,"ID\tSIS User ID",Lab (1)\n'),
    ],
)
def test_a_tab_within_a_cell_parts_no_columns(lms: str, head: str) -> None:
    with pytest.raises(InputError, match=f"is no {lms.title()} "):
        fill_book(lms, head.encode(), "sheet.csv", [])
