"""What a second run says: decisions stay true, and each change is listed, with its reason."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from classes.class_cells import gyro
from grading.classes import make_folder, packed
from grading.students_reports import RIGHT, SLIPS, a_log, reported_line, sheet

from gyrodata.base.version import __version__
from gyrodata.grading.exports import compare_tables
from gyrodata.grading.rubric import default_rubric_text

OTHERS = {f"s{seed}/lab.csv": a_log(seed) for seed in range(10, 16)}
BAD = "mass,bad\n1,2\n"


def run(home: Path, *options: str, desk: str = "") -> str:
    """Grade the class; return what is told."""
    out = home / "grades"
    out.mkdir(exist_ok=True)
    if desk:
        (out / "desk.csv").write_text(f"student,what,value,by,why\n{desk}")
    done = gyro("grade", home / "class", "-o", out, "--workers", "0", *options)
    assert done.exit_code in (0, 1), done.stderr
    return done.stderr


def looks(home: Path, student: str) -> list[str]:
    document = json.loads((home / "grades" / "grades.json").read_text())
    return next(
        one["look"] for one in document["students"] if one["student"] == student
    )


@pytest.mark.slow
@pytest.mark.parametrize("new", [a_log(7), f"# station: 2\n{BAD}"])
def test_new_log_below_a_decision_about_the_log_is_told(
    new: str, tmp_path: Path
) -> None:
    make_folder(tmp_path / "class", {**OTHERS, "a/lab.csv": BAD})
    make_folder(tmp_path / "grades", {"fix.csv": a_log(3), "other.csv": a_log(3)})
    desk = "a,log,fix.csv,Ann,columns named\n"
    for _ in range(2):
        run(tmp_path, desk=desk)
        assert looks(tmp_path, "a") == []
    (tmp_path / "class" / "a" / "lab.csv").write_text(new)
    for _ in range(2):
        run(tmp_path)
        (look,) = looks(tmp_path, "a")
        assert look.startswith("resubmitted since")
    todo = (tmp_path / "grades" / "desk-todo.csv").read_text()
    assert "resubmitted since" in todo
    run(tmp_path, desk="a,log,other.csv,Ann,looked at the new one too\n")
    assert looks(tmp_path, "a") == []


@pytest.mark.slow
def test_one_line_confirms_all_decisions_for_a_new_submission(tmp_path: Path) -> None:
    make_folder(tmp_path / "class", {**OTHERS, "a/lab.csv": a_log(3)})
    desk = "a,reported,4.44e-3 ± 0.05e-3 kg m^2,Ann,\na,bonus,1,Ann,\n"
    run(tmp_path, desk=desk)
    assert looks(tmp_path, "a") == []
    for version in (7, 8):
        (tmp_path / "class" / "a" / "lab.csv").write_text(a_log(version))
        run(tmp_path)
        questions = looks(tmp_path, "a")
        assert len(questions) == 2
        assert all("confirm all decisions" in question for question in questions)
        desk += f"a,total,,Ann,looked at version {version}\n"
        for _ in range(2):
            run(tmp_path, desk=desk)
            assert looks(tmp_path, "a") == []
    todo = (tmp_path / "grades" / "desk-todo.csv").read_text()
    assert "resubmitted" not in todo


@pytest.mark.slow
def test_unknown_lateness_asks_for_the_points_to_take_off(tmp_path: Path) -> None:
    logs = {f"doe_{seed}_90{seed}_lab.csv": a_log(seed) for seed in (10, 11)}
    logs["roe_LATE_12_9012_lab.csv"] = a_log(12)
    rubric = default_rubric_text("simple") + '[late]\nbeyond = "100 %"\n'
    make_folder(tmp_path, {"rubric.toml": rubric})
    make_folder(tmp_path / "class", logs)
    options = ("--rubric", str(tmp_path / "rubric.toml"))
    run(tmp_path, *options)
    todo = (tmp_path / "grades" / "desk-todo.csv").read_text(encoding="utf-8")
    assert "12,late,,,marked late, but nothing says by how much" in todo.replace(
        '"', ""
    )
    run(tmp_path, *options, desk="12,late,2,Ann,a day\n")
    todo = (tmp_path / "grades" / "desk-todo.csv").read_text(encoding="utf-8")
    assert todo.count("\n") == 1


def table(**cells: dict[str, str]) -> bytes:
    columns = ("student", "name", "status", "total", "inertia", "z", "late")
    rows = [",".join(columns)]
    for student, some in cells.items():
        row = {"student": student, "name": student, "status": "graded", **some}
        rows.append(",".join(row.get(column, "") for column in columns))
    return "\n".join(rows).encode()


def test_changes_are_all_listed_and_the_largest_first() -> None:
    names = [f"s{n:03d}" for n in range(60)]
    then = {one: {"total": "20.00", "z": "0.5212"} for one in names}
    now = {one: {"total": "20.00", "z": "0.5247"} for one in names}
    assert compare_tables(table(**then), table(**now)) == ()
    for at, name in enumerate(names[:40]):
        now[name]["total"] = f"{20 - at / 4:.2f}"
    now["s050"] = {"status": "not graded", "z": "0.5247"}
    now["s051"]["late"] = "2 h late"
    changes = compare_tables(table(**then), table(**now)) or ()
    assert [one.student for one in changes[:2]] == ["s050", "s039"]
    assert [one.student for one in changes[-1:]] == ["s051"]
    assert len(changes) == 41
    assert all(part.column != "z" for one in changes for part in one.parts)
    now["s052"]["z"] = "1.9"
    (change,) = (
        one
        for one in compare_tables(table(**then), table(**now)) or ()
        if one.student == "s052"
    )
    assert [part.column for part in change.parts] == ["z"]


@pytest.mark.slow
def test_every_change_is_printed(tmp_path: Path) -> None:
    rows = sheet(np.random.default_rng(4), "mixed")
    slip = reported_line(*SLIPS["rpm_as_rad_s"].inertia(rows, "with_constant"))
    right = reported_line(*RIGHT.inertia(rows, "with_constant"))
    files = {f"t{n:02d}/lab.csv": f"{rows.log(slip)}# run {n}\n" for n in range(21)}
    make_folder(tmp_path / "class", {**OTHERS, **files})
    run(tmp_path)
    for name, text in files.items():
        (tmp_path / "class" / name).write_text(text.replace(slip, right))
    told = run(tmp_path)
    assert len(re.findall(r"^  t\d\d: \d+\.\d\d → \d+\.\d\d \(", told, re.M)) == 21


@pytest.mark.slow
def test_another_version_says_whose_points_change_and_why(tmp_path: Path) -> None:
    make_folder(tmp_path / "class", dict(OTHERS))
    out = tmp_path / "grades"
    run(tmp_path)
    table = (out / "grades.csv").read_text(encoding="utf-8-sig")
    assert f"graded by gyrodata {__version__}" in table
    assert (
        (out / "rubric-used.toml")
        .read_text()
        .startswith(f"# gyrodata {__version__} graded by this rubric.\n# The rubric")
    )
    # What an older version would have left: its number, and other points for one.
    journal = (out / "journal.ndjson").read_text()
    (out / "journal.ndjson").write_text(journal.replace(__version__, "0.0.1"))
    row = next(line for line in table.splitlines() if line.startswith("s12,"))
    older = row.replace("20.00", "17.00").replace(",6.00,", ",3.00,", 1)
    (out / "grades.csv").write_text(table.replace(row, older), encoding="utf-8-sig")
    before = (out / "grades.csv").read_bytes()
    told = run(tmp_path, "--dry-run")
    assert (out / "grades.csv").read_bytes() == before
    assert f"graded 6 (gyrodata changed from 0.0.1 to {__version__})" in told
    (why,) = re.findall(
        r"s12: 17.00 → 20.00 \(inertia 3.00 → 6.00\)\n    inertia: (.*)", told
    )
    assert "agrees with your runs" in why
    assert "s13: " not in told


def test_a_rubric_that_was_used_can_be_used_again(tmp_path: Path) -> None:
    make_folder(tmp_path / "class", {"s10/lab.csv": OTHERS["s10/lab.csv"]})
    run(tmp_path)
    used = tmp_path / "grades" / "rubric-used.toml"
    first = used.read_bytes()
    assert "kept 1" in run(tmp_path, "--rubric", str(used))
    assert used.read_bytes() == first


@pytest.mark.slow
def test_no_text_of_a_student_is_longer_than_300_letters(tmp_path: Path) -> None:
    names = {f"{n:05d}-{'x' * 60}.png": b"" for n in range(3000)}
    long = f"# reported_inertia: {'9' * 5000} kg m^2\n"
    make_folder(
        tmp_path / "class",
        {
            **OTHERS,
            "a/lab.zip": packed(names),
            "b/lab.csv": long + a_log(3),
            "c/lab.csv": f"mass [g],{'y' * 8000}\n1,2\n",
        },
    )
    run(tmp_path)
    todo = (tmp_path / "grades" / "desk-todo.csv").read_text()
    cells = [cell for line in todo.splitlines() for cell in line.split(",")]
    assert 50 < max(map(len, cells)) <= 302
    page = (tmp_path / "grades" / "class.html").read_text()
    texts = re.sub(r"(?s)<(script|style).*?</\1>", "", page)
    pieces = re.split(r"<[^<>]*>", texts)
    assert 200 < max(map(len, pieces)) < 500
