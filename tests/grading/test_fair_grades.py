"""Classes through ``gyro grade``: no correct answer is punished, no decision is lost or given to another student."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from classes.cells import canvas, with_answer
from classes.disguises import plant
from classes.drawn import FITS, USUAL, Bench, Student, draw
from classes.graded import grade, gyro
from grading.classes import make_folder
from grading.reports import RIGHT, SLIPS, reported_line, sheet
from msgspec.structs import replace

from gyrodata.grading import default_rubric_text

CARRIED_OUT = {"G775", "G776"}
"""Codes whose hints are followed here."""

BALL = "# ball_diameter: 10.16 cm"
RADIUS = 5.08  # of that ball [cm]
TITLES = "mass [g],position [cm],spin [rpm],time [s],turns"
HEADERS = {
    "kg": ("mass [g]", "mass [kg]", "the masses are in grams"),
    "mm": ("position [cm]", "position [mm]", "the positions are in cm"),
    "m": ("position [cm]", "position [m]", "the positions are in centimetres"),
    "rad/s": ("spin [rpm]", "spin [rad/s]", "the spins are in rpm"),
    "Hz": ("spin [rpm]", "spin [Hz]", "the spins are in rpm"),
    "min": ("time [s]", "time [min]", "the times are in s"),
    "exchanged": ("spin [rpm],time [s]", "time [s],spin [rpm]", "the columns of spin and time are exchanged"),
}
"""What a header should be, what it is, and how the mistake is named."""


def honest(count: int, seed: int, bench: Bench = USUAL, *head: str) -> dict[Student, str]:
    students = [draw(i, seed, bench) for i in range(count)]
    return {one: one.log(*head, reported_line(*one.answer(fit=FITS[i % 3]))) for i, one in enumerate(students)}


def graded(logs: Mapping[Student, str], *options: str | Path) -> list[dict[str, Any]]:
    """Grade a class: its students in the order given."""
    students = grade(canvas(logs), *options)["students"]
    return [students[one.key] for one in logs]


def mark(student: Mapping[str, Any], check: str) -> dict[str, Any]:
    return next(one for one in student["marks"] if one["check"] == check)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as table:
        return list(csv.DictReader(table))


# --- a correct answer, and a mistake in the log -------------------------------------------------------------


@pytest.mark.parametrize("bench", [USUAL, replace(USUAL, thirds=False)], ids=["thirds", "whole turns"])
def test_correct_answer_with_wrong_header_keeps_17_points(bench: Bench) -> None:
    logs, named = honest(100, 3, bench), {}
    for i in range(56):
        student, kind = draw(200 + i, 3, bench), list(HEADERS)[i % 7]
        right, wrong, named[student] = HEADERS[kind]
        answer = reported_line(*student.answer(fit=FITS[i % 3]))
        logs[student] = student.log(answer, titles=TITLES.replace(right, wrong))
    found = dict(zip(logs, graded(logs), strict=True))
    assert [found[one]["points"] for one in named if (found[one]["points"] or 0) < 17] == []
    told = {one: mark(found[one], "log")["reason"] for one in named}
    assert [told[one] for one, words in named.items() if words not in told[one]] == []
    assert [one["look"] for student, one in found.items() if student not in named and one["look"]] == []


def test_wrong_answer_keeps_its_mistake_if_log_is_right() -> None:
    logs = honest(40, 4)
    for i, kind in enumerate(("g_as_kg", "cm_as_m", "rpm_as_rad_s", "minutes_as_seconds")):
        student = draw(200 + i, 4)
        logs[student] = student.log(reported_line(*student.answer(SLIPS[kind])))
    found = graded(logs)[40:]
    assert [one["slips"][0]["kind"] for one in found] == ["g_as_kg", "cm_as_m", "rpm_as_rad_s", "minutes_as_seconds"]
    assert [mark(one, "own_data")["points"] for one in found] == [3, 3, 3, 3]


def test_hint_for_wrong_header_gives_all_points_when_followed() -> None:
    logs, student = honest(30, 5), draw(200, 5)
    logs[student] = student.log(reported_line(*student.answer()), titles=TITLES.replace("mass [g]", "mass [kg]"))
    (told,) = (one for one in graded(logs)[-1]["diagnostics"] if one["code"] == "G776")
    assert told["hint"] == 'write the header as "mass [g]"'
    logs[student] = logs[student].replace("mass [kg]", "mass [g]")
    found = graded(logs)[-1]
    assert found["points"] == 20
    assert "G776" not in [one["code"] for one in found["diagnostics"]]


# --- the arm from the ball's surface ------------------------------------------------------------------------


def from_surface(student: Student) -> Student:
    return replace(student, rows=replace(student.rows, position=student.rows.position - RADIUS))


@pytest.mark.parametrize("bench", [USUAL, replace(USUAL, thirds=False)], ids=["thirds", "whole turns"])
@pytest.mark.parametrize("where", ["arithmetic", "log"])
def test_arm_from_surface_is_named_for_18_of_20(where: str, bench: Bench) -> None:
    logs = honest(80, 6, bench, BALL)
    for i in range(20):
        student = draw(200 + i, 6, bench)
        short = from_surface(student)
        rows = student if where == "arithmetic" else short
        logs[student] = rows.log(BALL, reported_line(*RIGHT.inertia(short.rows, FITS[i % 3])))
    found = graded(logs)
    told = [str((one["slips"], one["look"], mark(one, "reference")["reason"])) for one in found]
    assert sum("from the ball's surface" in words for words in told[80:]) >= 18
    assert [words for words in told[:80] if "surface" in words] == []
    if where == "log":
        assert all("one mistake in the log that would explain this factor" in words for words in told[80:])


def test_rubric_bench_gives_the_ball_for_logs_without_it(tmp_path: Path) -> None:
    rubric = tmp_path / "rubric.toml"
    text = default_rubric_text().replace(
        '[bench]\nfrom = "class"', '[bench]\nfrom = "class"\nball_diameter = "10.16 cm"'
    )
    rubric.write_text(text, encoding="utf-8")
    logs = honest(30, 7)
    arithmetic, header, stated = (draw(200 + i, 7) for i in range(3))
    logs[arithmetic] = arithmetic.log(reported_line(*from_surface(arithmetic).answer()))
    titles = TITLES.replace("position", "distance from ball surface")
    logs[header] = from_surface(header).log(reported_line(*header.answer()), titles=titles)
    logs[stated] = stated.log("# ball_diameter: 10.2 cm", reported_line(*stated.answer()))
    found = graded(logs, "--rubric", rubric)
    assert "from the ball's surface" in str(found[30]["slips"])
    assert (found[31]["status"], found[31]["points"]) == ("graded", 20)
    assert (found[31]["bench"], found[32]["bench"]) == (["ball_diameter 10.16 cm"], [])


def test_latitude_of_log_wins_over_g_of_bench(tmp_path: Path) -> None:
    rubric, student = tmp_path / "rubric.toml", draw(1, 8)
    rubric.write_text(
        default_rubric_text().replace('from = "class"\n\n# Or state it, as', 'g = "9.70 m/s^2"\n\n# Or'),
        encoding="utf-8",
    )
    log = student.log("# latitude: 50 deg", reported_line(*student.answer()))
    (with_bench,), (without,) = graded({student: log}, "--rubric", rubric), graded({student: log})
    assert with_bench["inertia"] == without["inertia"]


@pytest.mark.parametrize(
    "line",
    [
        'g = "9.803 m/s^2"', 'latitude = "42.5 deg"', 'ball_mass = "4.31 ± 0.01 kg"', 'ball_diameter = "101.6 mm"',
        'rod_length = "25 cm"', 'rod_mass = "50 g"', 'rod_diameter = "8 mm"',
        'bore_diameter = "20 mm"', 'bore_depth = "40 mm"', 'disk_mass = "1.7 kg"', 'disk_diameter = "25 cm"',
        'weight_diameter = "20 mm"', 'transverse_inertia = "6e-3 kg m^2"', 'motion = "steady"',
    ],
)  # fmt: skip
def test_bench_constant_acts_like_line_of_log(line: str, tmp_path: Path) -> None:
    rubric = tmp_path / "rubric.toml"
    rubric.write_text(default_rubric_text().replace('[bench]\nfrom = "class"', f"[bench]\n{line}"), encoding="utf-8")
    student, usual = draw(1, 8), tmp_path / "usual.toml"
    usual.write_text(default_rubric_text().replace('[bench]\nfrom = "class"', ""), encoding="utf-8")
    given = f"# {line.replace(' = ', ': ').replace(chr(34), '')}"
    (stated,) = graded({student: student.log(given, reported_line(*student.answer()))}, "--rubric", usual)
    (by_rubric,) = graded({student: student.log(reported_line(*student.answer()))}, "--rubric", rubric)
    same = ("inertia", "inertia_u", "own", "points", "d")
    assert {name: by_rubric[name] for name in same} == {name: stated[name] for name in same}


def test_bench_constant_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    rubric, root = tmp_path / "rubric.toml", make_folder(tmp_path / "class", {"ann/lab.csv": draw(1, 8).log()})
    text = default_rubric_text().replace('from = "class"\n\n# Or state it, as a line', 'ball_diameter = "4 kg"\n\n# Or')
    rubric.write_text(text, encoding="utf-8")
    done = gyro("grade", root, "--rubric", rubric, "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert 'ball_diameter: "4 kg"' in done.stderr


# --- what a student reads -----------------------------------------------------------------------------------


def feedback(log: str, folder: Path) -> str:
    root = make_folder(folder / "class", {"ann/lab.csv": log})
    assert gyro("grade", root, "-o", folder / "out", "--workers", "0").exit_code == 0
    return (folder / "out" / "feedback" / "ann" / "feedback.md").read_text(encoding="utf-8")


def test_feedback_names_criterion_that_lost_points(tmp_path: Path) -> None:
    student = draw(1, 9)
    value, u = student.answer()
    text = feedback(student.log(reported_line(value, 29 * u)), tmp_path)
    assert 'Only one criterion lost points: "The uncertainty is realistic" (0 of 3).' in text


@pytest.mark.parametrize("kind", ["answer_in_g_cm2", "exponent_sign_lost", "g_as_kg + cm_as_m"])
def test_known_mistake_costs_its_points_only_once(kind: str, tmp_path: Path) -> None:
    rows = sheet(np.random.default_rng(3), "mixed")
    text = feedback(rows.log(reported_line(*SLIPS[kind].inertia(rows, "through_origin"))), tmp_path)
    assert "It cost 3 points, once" in text
    assert "**17 of 20 points.**" in text
    assert " 0 of " not in text


def test_two_mistakes_together_are_told_as_perhaps(tmp_path: Path) -> None:
    rows = sheet(np.random.default_rng(3), "mixed")
    pair = SLIPS["rpm_as_rad_s + g_as_kg"]
    text = feedback(rows.log(reported_line(*pair.inertia(rows, "through_origin"))), tmp_path)
    assert "**Perhaps the spin in rpm was used as if it were in rad/s, and the masses" in text
    assert "One mistake that would explain this factor" in text or "Mistakes that would each explain" in text


# --- who is graded ------------------------------------------------------------------------------------------


def test_report_folder_of_gyro_is_not_a_student(tmp_path: Path) -> None:
    log = draw(1, 10).log(reported_line(*draw(1, 10).answer()))
    for where, students in ((tmp_path / "flat", ["ann", "bob"]), (tmp_path / "deep", ["ann", "bob"])):
        names = {f"{one}.csv" if where.name == "flat" else f"{one}/lab.csv": log for one in students}
        root = make_folder(where, names)
        first = root / next(iter(names))
        gyro("analyze", first, "-o", first.with_name(f"{first.stem}-report"))
        gyro("analyze", first, "-o", root / "other-report")
        gyro("grade", root, "-o", tmp_path / f"{where.name}-out")
        assert [row["student"] for row in rows_of(tmp_path / f"{where.name}-out" / "grades.csv")[1:]] == students


JANE = "Jane Doe_{}_assignsubmission_file/lab.csv"
WORKSHEET = """Identifier,Full name,Email address,Status,Grade,Maximum Grade,Grade can be changed,Feedback comments
Participant 7000,Jane Doe,a@x.edu,Submitted,14.50,20.00,Yes,
Participant 7001,Jane Doe,b@x.edu,Submitted,14.50,20.00,Yes,
Participant 7002,Max Roe,c@x.edu,Submitted,,20.00,Yes,
"""


@pytest.mark.parametrize("with_sheet", [True, False])
def test_desk_line_for_shared_name_is_refused_with_both_ids(with_sheet: bool, tmp_path: Path) -> None:
    log = draw(1, 11).log(reported_line(*draw(1, 11).answer()))
    names = [JANE.format(7000), JANE.format(7001), "Max Roe_7002_assignsubmission_file/lab.csv"]
    root, out, sheet_file = (
        make_folder(tmp_path / "class", dict.fromkeys(names, log)),
        tmp_path / "out",
        tmp_path / "w.csv",
    )
    sheet_file.write_text(WORKSHEET, encoding="utf-8")
    run = ("grade", root, "-o", out, *(["--worksheet", sheet_file] if with_sheet else []))
    gyro(*run)
    assert {row["name"] for row in rows_of(out / "grades.csv")[1:]} == {"Jane Doe (7000)", "Jane Doe (7001)", "Max Roe"}
    before = (out / "grades.csv").read_bytes()
    (out / "desk.csv").write_text("student,what,value,by,why\nJane Doe,total,3,Ann,x\n", encoding="utf-8")
    done = gyro(*run)
    assert done.exit_code == 2
    assert 'G775: 2 students are called "Jane Doe": 7000, 7001' in done.stderr
    assert (out / "grades.csv").read_bytes() == before
    for name in ("7001", "Jane Doe (7001)"):
        (out / "desk.csv").write_text(f"student,what,value,by,why\n{name},total,3,Ann,x\n", encoding="utf-8")
        gyro(*run)
        totals = {row["student"]: row["total"] for row in rows_of(out / "grades.csv")[1:]}
        assert totals == {"7000": "20.00", "7001": "3.00", "7002": "20.00"}


def test_desk_line_for_absent_student_is_still_refused(tmp_path: Path) -> None:
    log = draw(1, 11).log(reported_line(*draw(1, 11).answer()))
    root, out = make_folder(tmp_path / "class", {JANE.format(7000): log, JANE.format(7009): log}), tmp_path / "out"
    (tmp_path / "w.csv").write_text(WORKSHEET, encoding="utf-8")
    gyro("grade", root, "-o", out)
    for name, code in (("Max Roe", "G772"), ("7002", "G772"), ("Jane Doe", "G775")):
        (out / "desk.csv").write_text(f"student,what,value,by,why\n{name},total,3,Ann,x\n", encoding="utf-8")
        done = gyro("grade", root, "-o", out, "--worksheet", tmp_path / "w.csv")
        assert (done.exit_code, f"error {code}" in done.stderr) == (2, True)


# --- the worklist and the desk ------------------------------------------------------------------------------


class Room:
    """A class with copies and one student without an answer; the folder of its grades."""

    def __init__(self, home: Path) -> None:
        self.root, self.out = home / "class", home / "grades"
        students, _ = plant([draw(i, 12) for i in range(25)], 12, 1)
        blank = draw(900, 12)
        make_folder(self.root, {**with_answer(students), f"{blank.stem}_lab.csv": blank.log()})
        self.blank = blank.key
        self.told = self.grade()

    def grade(self, code: int = 1) -> str:
        done = gyro("grade", self.root, "-o", self.out, "--workers", "0")
        assert done.exit_code == code, done.stderr
        return done.stderr

    @property
    def flags(self) -> list[dict[str, str]]:
        return rows_of(self.out / "flags.csv")

    @property
    def todo(self) -> list[dict[str, str]]:
        return rows_of(self.out / "desk-todo.csv")

    def desk(self, rows: list[dict[str, str]]) -> None:
        with (self.out / "desk.csv").open("w", encoding="utf-8", newline="") as table:
            writer = csv.DictWriter(table, ["student", "what", "value", "by", "why"], extrasaction="ignore")
            writer.writeheader()
            writer.writerows(rows)


@pytest.fixture
def room(tmp_path: Path) -> Room:
    return Room(tmp_path)


def test_worklist_saved_as_desk_settles_nothing(room: Room) -> None:
    flags, todo = room.flags, room.todo
    assert len(flags) >= 5
    assert {row["value"] for row in todo} == {""}
    (room.out / "desk.csv").write_bytes((room.out / "desk-todo.csv").read_bytes())
    told = room.grade()
    assert room.flags == flags
    assert room.todo == todo
    assert f"{len(todo)} lines wait in desk.csv for a value" in told
    page = (room.out / "class.html").read_text(encoding="utf-8")
    assert all(f"{row['student']},flag,,," in page for row in todo if row["what"] == "flag")


@pytest.mark.parametrize("verdict", ["partners", "copied", "cleared"])
def test_flag_is_settled_by_a_word_and_a_name(verdict: str, room: Room) -> None:
    flags = [row for row in room.todo if row["what"] == "flag"]
    assert len(flags) == len(room.flags)
    room.desk([flags[0] | {"value": verdict, "by": "Ann"}, *flags[1:]])
    room.grade()
    assert [row for row in room.todo if row["what"] == "flag"] == flags[1:]
    one = flags[1]["student"].split(" + ")[0]
    room.desk([{"student": one, "what": "flag", "value": verdict, "by": "Ann"}])
    room.grade()
    assert flags[1] not in room.todo, "one of its students is enough"


def test_flag_needs_a_name_and_a_known_word(room: Room) -> None:
    flag = next(row for row in room.todo if row["what"] == "flag")
    room.desk([flag | {"value": "cleared"}])
    assert "write who has decided it, under by" in room.grade(2)
    room.desk([flag | {"value": "fine", "by": "Ann"}])
    assert "write partners, copied or cleared" in room.grade(2)


def test_later_copy_of_a_settled_log_is_flagged_again(room: Room) -> None:
    flag = next(row for row in room.todo if row["what"] == "flag" and "shared rows" in row["why"])
    room.desk([flag | {"value": "cleared", "by": "Ann"}])
    room.grade()
    key = flag["student"].split(" + ")[0]
    (source,) = room.root.glob(f"*_{key}_*")
    (room.root / "late0000_5555_1_lab.csv").write_bytes(source.read_bytes())
    room.grade()
    assert any(row["what"] == "flag" and "5555" in row["student"] for row in room.todo)


def test_partner_line_by_hand_still_removes_the_flag(room: Room) -> None:
    flag = next(row for row in room.flags if row["students"].count(",") == 1)
    one, other = flag["students"].split(", ")
    room.desk([{"student": one, "what": "partner", "value": other, "by": "Ann"}])
    room.grade()
    assert flag["students"] not in [row["students"] for row in room.flags]


def test_ungraded_student_waits_whatever_an_empty_line_says(room: Room) -> None:
    line = next(row for row in room.todo if row["student"] == room.blank)
    for by, why in (("", line["why"]), ("Ann", "later")):
        room.desk([line | {"by": by, "why": why}])
        assert "1 line waits in desk.csv for a value" in room.grade()
        assert line in room.todo
