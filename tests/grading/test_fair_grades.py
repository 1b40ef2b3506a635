"""Classes through ``gyro grade``: no correct answer is punished, no decision is lost or
given to another student.
"""

import csv
import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from classes.class_cells import canvas, grade, gyro, with_answer
from classes.disguises import plant
from classes.drawn import FITS, TITLES, Student, draw, with_rows
from grading.classes import make_folder
from grading.students_reports import reported_line
from msgspec.structs import replace

from gyrodata.grading.rubric import default_rubric_text

CARRIED_OUT = {"G775", "G776"}
"""Codes whose hints are followed here."""

BALL = "# ball_diameter: 10.16 cm"
RADIUS = 5.08  # of that ball [cm]
HEADERS = {
    "kg": ("mass [g]", "mass [kg]", "the masses are in grams"),
    "mm": ("position [cm]", "position [mm]", "the positions are in cm"),
    "rad/s": ("spin [rpm]", "spin [rad/s]", "the spins are in rpm"),
    "min": ("time [s]", "time [min]", "the times are in s"),
    "exchanged": (
        "spin [rpm],time [s]",
        "time [s],spin [rpm]",
        "the columns of spin and time are exchanged",
    ),
}
"""What a header should be, what it is, and how the mistake is named."""


def answered(student: Student, *head: str, i: int = 1, titles: str = TITLES) -> str:
    """A log with an answer by one of three fits."""
    return student.log(
        *head, reported_line(*student.answer(fit=FITS[i % 3])), titles=titles
    )


def honest(count: int, seed: int, *head: str) -> dict[Student, str]:
    return {
        one: answered(one, *head, i=i)
        for i, one in enumerate(draw(i, seed) for i in range(count))
    }


def graded(logs: Mapping[Student, str], *options: str | Path) -> list[dict[str, Any]]:
    """Grade a class: its students in the order given."""
    students = grade(canvas(logs), *options)["students"]
    return [students[one.key] for one in logs]


def reason(student: Mapping[str, Any], check: str) -> str:
    return str(next(one["reason"] for one in student["marks"] if one["check"] == check))


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as table:
        return list(csv.DictReader(table))


@pytest.mark.slow
def test_correct_answer_with_wrong_header_keeps_17_points() -> None:
    logs, words = honest(10, 3), list(HEADERS.values())
    for i, (right, wrong, _) in enumerate(words):
        student = draw(200 + i, 3)
        logs[student] = answered(student, i=i, titles=TITLES.replace(right, wrong))
    found = graded(logs)
    assert [one["points"] for one in found[10:] if (one["points"] or 0) < 17] == []
    assert [
        reason(one, "log")
        for (_, _, name), one in zip(words, found[10:], strict=True)
        if name not in reason(one, "log")
    ] == []
    assert [one["look"] for one in found[:10] if one["look"]] == []
    hints = {
        told["hint"] for told in found[10]["diagnostics"] if told["code"] == "G776"
    }
    assert hints == {'write the header as "mass [g]"'}


def from_surface(student: Student) -> Student:
    """Measure the arm from the ball's surface."""
    return replace(
        student, rows=replace(student.rows, position=student.rows.position - RADIUS)
    )


@pytest.mark.slow
@pytest.mark.parametrize("where", ["arithmetic", "log"])
def test_arm_from_surface_is_named_for_nine_of_ten(where: str) -> None:
    logs = honest(20, 6, BALL)
    for i in range(10):
        student = draw(200 + i, 6)
        rows = student if where == "arithmetic" else from_surface(student)
        logs[student] = rows.log(
            BALL, reported_line(*from_surface(student).answer(fit=FITS[i % 3]))
        )
    told = [
        str((one["slips"], one["look"], reason(one, "reference")))
        for one in graded(logs)
    ]
    assert sum("from the ball's surface" in words for words in told[20:]) >= 9
    assert [words for words in told[:20] if "surface" in words] == []
    if where == "log":
        assert all(
            "one mistake in the log that would explain this factor" in words
            for words in told[20:]
        )


@pytest.mark.slow
def test_report_folder_of_gyro_is_not_a_student(tmp_path: Path) -> None:
    root = make_folder(
        tmp_path / "class",
        dict.fromkeys(["ann/lab.csv", "bob/lab.csv"], answered(draw(1, 10))),
    )
    report = root / "ann" / "lab-report"
    assert gyro("analyze", root / "ann" / "lab.csv", "-o", report).exit_code == 0
    shutil.copytree(report, root / "other-report")
    gyro("grade", root, "-o", tmp_path / "out")
    assert [row["student"] for row in rows_of(tmp_path / "out" / "grades.csv")[1:]] == [
        "ann",
        "bob",
    ]


JANE = "Jane Doe_{}_assignsubmission_file/lab.csv"
WORKSHEET = """Identifier,Full name,Email address,Status,Grade,Maximum Grade,Grade can be changed,Feedback comments
Participant 7000,Jane Doe,a@x.edu,Submitted,14.50,20.00,Yes,
Participant 7001,Jane Doe,b@x.edu,Submitted,14.50,20.00,Yes,
Participant 7002,Max Roe,c@x.edu,Submitted,,20.00,Yes,
"""  # noqa: E501


@pytest.mark.slow
def test_desk_line_for_shared_name_is_refused_with_both_ids(tmp_path: Path) -> None:
    names = [
        JANE.format(7000),
        JANE.format(7001),
        "Max Roe_7002_assignsubmission_file/lab.csv",
    ]
    root, out = (
        make_folder(tmp_path / "class", dict.fromkeys(names, answered(draw(1, 11)))),
        tmp_path / "out",
    )
    (tmp_path / "w.csv").write_text(WORKSHEET, encoding="utf-8")
    run = ("grade", root, "-o", out, "--gradebook", tmp_path / "w.csv")
    gyro(*run)
    before = (out / "grades.csv").read_bytes()
    (out / "desk.csv").write_text(
        "student,what,value,by,why\nJane Doe,total,3,Ann,x\n", encoding="utf-8"
    )
    done = gyro(*run)
    assert (
        done.exit_code,
        'G775: 2 students are called "Jane Doe": 7000, 7001' in done.stderr,
    ) == (2, True)
    assert (out / "grades.csv").read_bytes() == before
    for name in ("7001", "Jane Doe (7001)"):
        (out / "desk.csv").write_text(
            f"student,what,value,by,why\n{name},total,3,Ann,x\n", encoding="utf-8"
        )
        gyro(*run)
        totals = {
            row["student"]: (row["name"], row["total"])
            for row in rows_of(out / "grades.csv")[1:]
        }
        jane = {
            "7000": ("Jane Doe (7000)", "20.00"),
            "7001": ("Jane Doe (7001)", "3.00"),
        }
        assert totals == {**jane, "7002": ("Max Roe", "20.00")}


class Room:
    """A class on disk, and the folder of its grades."""

    def __init__(self, home: Path, files: Mapping[str, str | bytes]) -> None:
        self.root, self.out = make_folder(home / "class", files), home / "grades"
        self.grade()

    def grade(self, *options: str | Path, refused: bool = False) -> str:
        done = gyro("grade", self.root, "--out", self.out, "--workers", "0", *options)
        assert (done.exit_code == 2) == refused, done.stderr
        return done.stderr

    def table(self, name: str) -> list[dict[str, str]]:
        return rows_of(self.out / f"{name}.csv")

    def todo(self, what: str = "flag") -> list[dict[str, str]]:
        return [row for row in self.table("desk-todo") if row["what"] == what]

    def desk(self, *rows: dict[str, str]) -> None:
        with (self.out / "desk.csv").open("w", encoding="utf-8", newline="") as table:
            writer = csv.DictWriter(
                table, ["student", "what", "value", "by", "why"], extrasaction="ignore"
            )
            writer.writeheader()
            writer.writerows(rows)


@pytest.fixture
def room(tmp_path: Path) -> Room:
    """A class with copies and one student without an answer."""
    students, _ = plant([draw(i, 12) for i in range(16)], 12, 1)
    return Room(
        tmp_path,
        {**with_answer(students), f"{draw(900, 12).stem}_lab.csv": draw(900, 12).log()},
    )


@pytest.mark.slow
def test_worklist_saved_as_desk_settles_nothing(room: Room) -> None:
    flags, todo = room.table("flags"), room.table("desk-todo")
    assert len(flags) >= 5
    assert {row["value"] for row in todo} == {""}
    (room.out / "desk.csv").write_bytes((room.out / "desk-todo.csv").read_bytes())
    room.grade()
    assert (room.table("flags"), room.table("desk-todo")) == (flags, todo)
    page = (room.out / "class.html").read_text(encoding="utf-8")
    assert all(
        f"{row['student']},flag,,," in page for row in todo if row["what"] == "flag"
    )


@pytest.mark.slow
def test_flag_is_settled_by_a_known_word_and_a_name(room: Room) -> None:
    flags = room.todo()
    assert len(flags) == len(room.table("flags"))
    for verdict in ("partners", "copied", "invented", "cleared"):
        room.desk(flags[0] | {"value": verdict, "by": "Ann"}, *flags[1:])
        room.grade()
        assert room.todo() == flags[1:]
    room.desk(flags[0] | {"value": "cleared"})
    assert "write who has decided it, under by" in room.grade(refused=True)
    room.desk(flags[0] | {"value": "fine", "by": "Ann"})
    assert "write partners, copied, invented or cleared" in room.grade(refused=True)


EDITS = {
    "inertia": ("1000", "4.5", "worked out on paper"),
    "total": ("1001", "12", "agreed in the office hour"),
    "reported": ("1002", "4.44e-3 ± 0.05e-3 kg m^2", "it is in the PDF"),
    "station": ("1003", "7", "the label was wrong"),
    "partner": ("1004", "1005", "one bench, two students"),
    "comment": ("1006", "Read the ruler at eye level.", "seen in the lab"),
    "hold": ("1007", "", "to be talked over"),
    "excuse": ("1008", "", "a doctor's note"),
}
"""What is decided of whom, and why; 1005 has the data of 1004, and 1002 no answer."""


@pytest.mark.slow
def test_every_decision_is_kept_and_said_whatever_happens(tmp_path: Path) -> None:
    students = [draw(i, 10) for i in range(10)]
    students[5] = with_rows(students[4], students[4].rows, 5)
    logs = {one: one.log() if one.number == 2 else answered(one) for one in students}
    room, rubric = Room(tmp_path, canvas(logs)), tmp_path / "rubric.toml"
    assert room.table("flags")
    names = ("student", "what", "value", "why", "by")
    room.desk(
        *(
            dict(zip(names, (one, what, *more, "Ann"), strict=True))
            for what, (one, *more) in EDITS.items()
        )
    )
    desk = (room.out / "desk.csv").read_bytes()
    for slip in (50, 40, 30):
        rubric.write_text(
            default_rubric_text().replace('slip = "50 %"', f'slip = "{slip} %"'),
            encoding="utf-8",
        )
        if slip == 30:
            for path in room.root.iterdir():
                path.write_text(
                    "# again\n" + path.read_text(encoding="utf-8"), encoding="utf-8"
                )
        room.grade("--rubric", rubric)
        rows = {row["student"]: row for row in room.table("grades")}
        assert (rows["1000"]["inertia"], rows["1001"]["total"]) == ("4.50", "12.00")
        assert ("resubmitted" in rows["1001"]["look"]) == (slip == 30)
        assert (rows["1002"]["status"], rows["1004"]["flags"]) == ("graded", "")
        assert (rows["1007"]["total"], rows["1008"]["total"]) == ("", "")
        document = json.loads((room.out / "grades.json").read_text(encoding="utf-8"))
        assert (
            next(
                one["station"]
                for one in document["students"]
                if one["student"] == "1003"
            )
            == "7"
        )
        for what, (one, value, why) in EDITS.items():
            (page,) = (room.out / "feedback").glob(f"*_{one}_*.md")
            said = f"{page.read_text(encoding='utf-8')}{rows[one]}{document}"
            assert (value if what == "comment" else why) in said
        assert (room.out / "desk.csv").read_bytes() == desk
