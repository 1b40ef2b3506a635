"""What a teacher and a student read about a grade says what happened, and nothing else."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from classes.class_cells import gyro
from classes.drawn import Student, draw, with_rows
from grading.classes import make_folder
from grading.students_reports import reported_line
from msgspec.structs import replace
from simulated_labs import INERTIA, RPM, G

Words = tuple[str, str, dict[str, Any]]


def answered(student: Student, *head: str) -> str:
    return student.log(reported_line(*student.answer()), *head)


def without_station(student: Student) -> str:
    return answered(student).replace(f"# station: {student.station}\n", "")


def invented(student: Student) -> Student:
    """Compute the times instead of measuring them."""
    rows = student.rows
    torque = 1e-3 * rows.mass * G * 0.01 * rows.position
    time = 2 * np.pi * rows.turns * INERTIA * rows.spin * RPM / torque
    return with_rows(student, replace(rows, time=time), student.number)


def graded(folder: Path, logs: dict[str, str]) -> Words:
    """Return the summary, the page and the grades of a class."""
    files: dict[str, str | bytes] = {f"{key}/lab.csv": log for key, log in logs.items()}
    root = make_folder(folder / "class", files)
    out = folder / "grades"
    done = gyro("grade", root, "--out", out, "--lms", "folder", "--workers", "0")
    page = (out / "class.html").read_text(encoding="utf-8")
    document = json.loads((out / "grades.json").read_text(encoding="utf-8"))
    students = {one["student"]: one for one in document["students"]}
    return done.stdout, page, students


@pytest.mark.slow
def test_logs_of_several_gyroscopes_without_stations_ask_for_them(
    tmp_path: Path,
) -> None:
    students = [draw(i, 4) for i in range(12)]
    other = [
        with_rows(one, replace(one.rows, time=3 * one.rows.time), one.number)
        for one in students[6:]
    ]
    logs = {one.key: without_station(one) for one in [*students[:6], *other]}
    summary, page, found = graded(tmp_path, logs)
    for text in (summary, page):
        assert "12 logs without a station" in text
    for one in found.values():
        (mark,) = (mark for mark in one["marks"] if mark["check"] == "reference")
        assert "the log names no station (# station: 3)" in mark["reason"]
        assert "±" not in mark["reason"]
        assert mark["points"] == 3


@pytest.mark.slow
def test_words_about_one_log_fit_it(tmp_path: Path) -> None:
    students = [replace(draw(i, 4), number=10 * i) for i in range(8)]
    logs = {one.key: answered(one) for one in students}
    logs["header"] = answered(students[0]).replace("spin [rpm]", "spin [rad/s]")
    logs["invented"] = answered(invented(students[1]))
    logs["silent"] = students[2].log()
    summary, page, found = graded(tmp_path, logs)
    assert "without a station" not in summary
    lines = {line.split()[0]: line for line in summary.splitlines() if line.strip()}
    assert "the spins are in rpm, and the header says rad/s" in lines["header"]
    assert "Wrong units in headers" in page
    assert "none is found in lab.csv" in found["silent"]["why"]
    assert "flag: invented or cleared?" in page


@pytest.mark.slow
def test_mistake_is_written_once_for_each_student(tmp_path: Path) -> None:
    one = draw(3, 4)
    value, u = one.answer()
    logs = {
        "exact": one.log(reported_line(100 * value, 100 * u)),
        "near": one.log(reported_line(99 * value, 100 * u)),
    }
    summary, page, found = graded(tmp_path, logs)
    lines = {line.split()[0]: line for line in summary.splitlines() if line.strip()}
    for name in logs:
        assert lines[name].count("centimetres") == 1
    assert (found["exact"]["look"] == [], found["near"]["look"] == []) == (True, False)
    listed = page.split("Common mistakes")[1].split("</ul>")[0]
    assert listed.count("<li>") == 1
