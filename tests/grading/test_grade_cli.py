"""`gyro grade` from the outside: the sample class, what is written and printed, exit
codes, and what is refused.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import make_sample_class
import openpyxl
import pytest
from classes.class_cells import gyro
from grading.classes import LOG, make_folder
from places import DATA, ROOT
from processes import started
from schemas import assert_valid
from typer.testing import Result

from gyrodata.grading.rubric import default_rubric_text

CLASS = ROOT / "sample_data" / "class"
EXPECTED = DATA / "sample_class.txt"  # what `gyro grade sample_data/class` prints


def rows_of(grades: Path) -> dict[str, dict[str, str]]:
    table = (grades / "grades.csv").read_text(encoding="utf-8")
    return {row["student"]: row for row in csv.DictReader(io.StringIO(table))}


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    """The sample class, graded once."""
    folder = tmp_path_factory.mktemp("graded")
    return gyro(
        "grade", CLASS, "--out", folder / "grades", "--workers", "2"
    ), folder / "grades"


@pytest.fixture
def grades(graded: tuple[Result, Path], tmp_path: Path) -> Path:
    """A copy of its grades, to work in."""
    return Path(shutil.copytree(graded[1], tmp_path / "grades"))


# --- the sample class ---


def test_the_stored_class_is_what_the_script_makes() -> None:
    stored = {path.name: path.read_bytes() for path in CLASS.iterdir()}
    assert stored == make_sample_class.make()


@pytest.mark.slow
def test_what_is_printed_and_written(graded: tuple[Result, Path]) -> None:
    done, folder = graded
    assert done.exit_code == 1, "three are not graded"
    assert done.stdout == EXPECTED.read_text(encoding="utf-8")
    assert "graded 14 (new): adlernina, bakertom" in done.stderr
    assert "1 file is of no student and left aside: README.txt" in done.stderr
    rows = rows_of(folder)
    assert [rows[number]["total"] for number in ("102", "111", "112", "113")] == [
        "20.00",
        "",
        "",
        "",
    ], "never a zero"
    for student in make_sample_class.STUDENTS:
        assert (
            rows[re.findall(r"_(\d+)_", student.file)[0]]["slips"].split("; ")[0]
            == student.slip
        ), student.file
    assert {path.name for path in folder.iterdir()} == {
        "class.html",
        "rubric-used.toml",
        "desk-todo.csv",
        "feedback",
        "feedback.zip",
        "flags.csv",
        "grades.csv",
        "grades.json",
        "journal.ndjson",
        "published",
    }
    stems = {
        Path(name).stem for name in make_sample_class.make() if name != "README.txt"
    }
    written = {path.name: path.read_bytes() for path in (folder / "feedback").iterdir()}
    assert set(written) == {
        f"{stem}{ending}" for stem in stems for ending in (".html", ".md")
    }
    with zipfile.ZipFile(folder / "feedback.zip") as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == written


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.mark.slow
def test_a_second_run_grades_nobody_and_changes_no_byte(grades: Path) -> None:
    before = bytes_of(grades)
    (grades / ".gyro-lock").touch()  # of a run that was killed as it ended
    done = gyro("grade", CLASS, "--out", grades, "--workers", "1")
    assert "kept 14 as graded before\n" in done.stderr
    assert bytes_of(grades) == before
    min(grades.glob("feedback/*.html")).unlink()
    gyro("grade", CLASS, "--out", grades, "--workers", "1")
    assert bytes_of(grades) == before, "a page that is gone is written again"


@pytest.mark.slow
def test_a_page_is_written_again_if_a_person_changed_it_or_if_it_shows_something_else(
    grades: Path,
) -> None:
    page = min(grades.glob("feedback/*.md"))
    right = page.read_bytes()
    page.write_bytes(b"mine")
    done = gyro("grade", CLASS, "--out", grades)
    assert (
        f"feedback/{page.name} was changed by hand; what it was is kept as published/feedback/"
        in done.stderr
    )
    assert [one.read_bytes() for one in grades.glob("published/feedback/*")] == [
        b"mine"
    ]
    assert page.read_bytes() == right
    before = bytes_of(grades / "feedback")
    (grades / "desk.csv").write_text(
        "student,what,value,by,why\n101,comment,Well done,TA,\n", encoding="utf-8"
    )
    gyro("grade", CLASS, "--out", grades)
    changed = [
        name
        for name, data in bytes_of(grades / "feedback").items()
        if data != before[name]
    ]
    assert sorted(Path(name).suffix for name in changed) == [".html", ".md"]
    with zipfile.ZipFile(grades / "feedback.zip") as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == bytes_of(
            grades / "feedback"
        )


@pytest.mark.slow
def test_pages_of_a_student_who_left_the_class_are_moved(
    grades: Path, tmp_path: Path
) -> None:
    shutil.copytree(CLASS, tmp_path / "class")
    (gone,) = (tmp_path / "class").glob("bakertom*")
    gone.unlink()
    pages = sorted(path.name for path in grades.glob("feedback/bakertom*"))
    done = gyro("grade", tmp_path / "class", "--out", grades)
    assert len(pages) == 2
    assert [
        name
        for name in pages
        if f"feedback/{name} belongs to no submission that is here now"
        not in done.stderr
    ] == []
    kept = (
        re.sub("-[0-9a-f]{12}(?=[.])", "", path.name)
        for path in grades.glob("published/feedback/*")
    )
    assert sorted(kept) == pages
    assert list(grades.glob("feedback/bakertom*")) == []


@pytest.mark.slow
def test_feedback_tells_a_bonus_and_says_full_marks_only_for_them(grades: Path) -> None:
    desk = (
        "student,what,value,by,why\n101,bonus,-1,TA,see my mail\n102,late,2,TA,a day\n"
    )
    (grades / "desk.csv").write_text(desk, encoding="utf-8")
    gyro("grade", CLASS, "--out", grades)
    first, second = (
        next(grades.glob(f"feedback/*_{one}_*.md")).read_text(encoding="utf-8")
        for one in (101, 102)
    )
    assert "Bonus given by hand: -1 – see my mail (TA)." in first
    assert "Full marks" not in first + second
    assert second.count("taken off") == 1
    assert (
        "2 points are taken off for lateness, as decided by hand: a day (TA)." in second
    )


@pytest.mark.slow
def test_a_lateness_that_is_waived_is_not_stated_as_one(grades: Path) -> None:
    (late,) = grades.glob("feedback/novakeva*.md")
    assert "Marked late." in late.read_text(encoding="utf-8")
    desk = "student,what,value,by,why\n114,late,0,TA,was ill\n102,late,0,TA,\n"
    (grades / "desk.csv").write_text(desk, encoding="utf-8")
    gyro("grade", CLASS, "--out", grades)
    text = late.read_text(encoding="utf-8")
    said = "No points are taken off for lateness, as decided by hand"
    assert f"{said}: was ill (TA)." in text
    assert "Late" not in text
    (other,) = grades.glob("feedback/bakertom*.md")
    assert f"{said} (TA)." in other.read_text(encoding="utf-8")


@pytest.mark.slow
def test_lateness_of_students_who_are_in_time_stays_blank(
    grades: Path, tmp_path: Path
) -> None:
    rubric = default_rubric_text() + '\n[late]\nmarked = "10 %"\n'
    (tmp_path / "rubric.toml").write_text(rubric, encoding="utf-8")
    options = ("--rubric", tmp_path / "rubric.toml", "--dry-run", "--workers", "0")
    done = gyro("grade", CLASS, "--out", grades, *options)
    assert "grades.csv would change for 1:" in done.stderr
    assert "late [s]" not in done.stderr


@pytest.mark.slow
def test_a_cluster_writes_the_same_files(
    graded: tuple[Result, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with ProcessPoolExecutor(2) as cluster:
        monkeypatch.setattr(
            "gyrodata.cli.grade_command._executor_of", lambda address: cluster
        )
        done = gyro(
            "grade",
            CLASS,
            "--out",
            tmp_path / "grades",
            "--cluster",
            "tcp://localhost:8786",
        )
    assert done.stdout == graded[0].stdout
    assert bytes_of(tmp_path / "grades") == bytes_of(graded[1])


@pytest.mark.slow
def test_json_ndjson_and_csv(
    graded: tuple[Result, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("grade", CLASS, "--workers", "0", "--format")
    document = json.loads(gyro(*words, "json").stdout)
    assert_valid(document, "grades")
    assert document == json.loads(
        (graded[1] / "grades.json").read_text(encoding="utf-8")
    )
    assert document["changes"] is None
    lines = [json.loads(line) for line in gyro(*words, "ndjson").stdout.splitlines()]
    assert [
        {k: v for k, v in line.items() if k not in ("schema", "tool")} for line in lines
    ] == document["students"]
    table = gyro(*words, "csv").stdout
    assert table == (graded[1] / "grades.csv").read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [], "nothing is written to disk"


# --- what changes ---


@pytest.mark.slow
def test_a_dry_run_tells_what_would_change_and_writes_nothing(
    grades: Path, tmp_path: Path
) -> None:
    rubric = tmp_path / "rubric.toml"
    rubric.write_text(
        gyro("grade", "--print-rubric", "full").stdout.replace(
            'slip = "50 %"', 'slip = "25 %"'
        )
    )
    before = bytes_of(grades)
    done = gyro(
        "grade",
        CLASS,
        "--out",
        grades,
        "--rubric",
        rubric,
        "--dry-run",
        "--workers",
        "0",
        "--format",
        "json",
    )
    assert bytes_of(grades) == before
    assert "graded 14 (the rubric changed): adlernina" in done.stderr
    assert (
        "grades.csv would change for 7:\n  castilloines (103): 17.00 → 18.50 "
        "(inertia 3.00 → 4.50)\n"
    ) in done.stderr
    changes = json.loads(done.stdout)["changes"]
    assert_valid(json.loads(done.stdout), "grades")
    assert changes[0] == {
        "student": "103",
        "name": "castilloines",
        "from": "17.00",
        "to": "18.50",
        "parts": [{"column": "inertia", "from": "3.00", "to": "4.50"}],
    }


@pytest.mark.slow
def test_points_typed_into_grades_csv_are_kept_and_belong_in_the_desk(
    grades: Path,
) -> None:
    table, kept = grades / "grades.csv", grades / "published"
    edited = table.read_text(encoding="utf-8").replace(
        "113,moreaulea,not graded,,", "113,moreaulea,graded,15.00,"
    )
    table.write_text(edited, encoding="utf-8")
    done = gyro("grade", CLASS, "--out", grades)
    assert "moreaulea (113): 15.00 → not graded" in done.stderr
    (path,) = kept.glob("grades-by-hand-*.csv")
    assert path.read_text(encoding="utf-8") == edited
    told = f"it is kept as published/{path.name}; write your points into desk.csv"
    assert told in " ".join(done.stderr.split())
    (grades / "desk.csv").write_text("student,what,value\n113,total,15.00\n")
    assert "by-hand" not in gyro("grade", CLASS, "--out", grades).stderr
    assert rows_of(grades)["113"]["total"] == "15.00"


# --- options ---


@pytest.mark.parametrize("name", ["my data.csv", "lab.xlsx"])
def test_one_log_is_sent_to_the_command_for_it(name: str, tmp_path: Path) -> None:
    book, out = openpyxl.Workbook(), io.BytesIO()
    for row in csv.reader(io.StringIO(LOG)):
        book.worksheets[0].append(row)
    book.save(out)
    make_folder(
        tmp_path,
        {
            name: out.getvalue() if name.endswith("x") else LOG,
            "report.txt": "I_zz = 4.4e-3 kg m^2",
        },
    )
    done = gyro("grade", tmp_path / name)
    assert (done.exit_code, list(tmp_path.glob("*grades*"))) == (2, [])
    _, *command = shlex.split(done.stderr.partition("run: ")[2].strip())
    assert (command[:2], "G719" in gyro(*command).stdout) == (
        ["check", "--hand-in"],
        True,
    )


@pytest.mark.slow
def test_a_log_of_an_earlier_year_is_found(grades: Path, tmp_path: Path) -> None:
    log = (CLASS / "bakertom_102_9002_gyroscope.csv").read_bytes()
    root = make_folder(tmp_path / "class", {"ann/lab.csv": log})
    done = gyro(
        "grade",
        root,
        "--out",
        tmp_path / "new",
        "--previous",
        grades,
        "--format",
        "json",
        "--exit-zero",
    )
    flags = [
        (flag["kind"], flag["students"], flag["previous"])
        for flag in json.loads(done.stdout)["flags"]
    ]
    example = "sample_data/class/bakertom_102_9002_gyroscope.csv"
    assert flags == [
        ("shared rows", ["ann"], ["grades/102", example]),
    ]
    refused = gyro("grade", root, "--previous", CLASS / "README.txt")
    assert (
        refused.exit_code,
        "folder that an earlier run wrote, with its journal" in refused.stderr,
    ) == (2, True)


@pytest.mark.slow
def test_hostile_names_stay_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    log = (CLASS / "bakertom_102_9002_gyroscope.csv").read_bytes()
    names = [
        "=cmd|' C calc'!A0",
        "@SUM(1)",
        "a<b>&c",
        "Ünïcode 名前",
        "\t=1",
        "＝1",
        "a,b\n=1",
    ]
    names.append("Żółć\u2028\udcff")
    root = make_folder(
        tmp_path / "class",
        {f"{name}/lab.csv": log for name in names},
    )
    words = (
        "grade",
        root,
        "--out",
        "\x1b[2J\x7f",
        "--workers",
        "0",
    )
    done = gyro(*words)
    assert done.exit_code == 0, done.stderr
    assert "␛[2J\ufffd/grades.csv" in done.output
    assert not {"\x1b", "\x7f"} & set(done.output)
    (out,) = set(tmp_path.iterdir()) - {root}
    rows = list(
        csv.reader(io.StringIO((out / "grades.csv").read_text(encoding="utf-8")))
    )
    assert len(rows) == 2 + len(names)
    assert [
        cell
        for row in rows
        for cell in row
        if cell[:1] in tuple("=+-@\t\r＝") and cell != "--"
    ] == []
    assert "<b>&c" not in (out / "class.html").read_text(encoding="utf-8")


@contextmanager
def grading(
    tmp_path: Path, count: int, *, hears_control_c: bool = True
) -> Iterator[subprocess.Popen[str]]:
    """Start to grade a class of so many equal logs, and wait for the first line of the
    journal.
    """
    log = (CLASS / "bakertom_102_9002_gyroscope.csv").read_bytes()
    root = make_folder(
        tmp_path / "class", {f"s{number:04d}.csv": log for number in range(count)}
    )
    command = [
        sys.executable,
        "-m",
        "gyrodata",
        "grade",
        root,
        "-o",
        tmp_path / "g",
        "--workers",
        "2",
    ]
    ours = {**os.environ, "PYTHONPATH": str(ROOT)}
    pipe = subprocess.PIPE
    with started(
        command,
        hears_control_c=hears_control_c,
        env=ours,
        stdout=pipe,
        stderr=pipe,
        text=True,
    ) as run:
        journal, begun = tmp_path / "g" / "journal.ndjson", time.monotonic()
        while run.poll() is None and not (journal.exists() and journal.stat().st_size):
            assert time.monotonic() - begun < 60, "no submission is graded"
            time.sleep(0.01)  # a file that is there may have no line yet
        yield run


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals are another thing there")
def test_control_c_stops_at_once_and_says_what_is_kept(tmp_path: Path) -> None:
    with grading(tmp_path, 400) as run:
        os.killpg(run.pid, signal.SIGINT)
        out, errors = run.communicate(timeout=30)
    assert (run.returncode, out) == (130, "")
    assert (
        errors
        == "stopped; what was done is kept, and the same command goes on from there\n"
    )
    assert (tmp_path / "g" / "journal.ndjson").read_bytes().endswith(b"\n")


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals are another thing there")
def test_command_started_in_the_background_does_not_hear_control_c(
    tmp_path: Path,
) -> None:
    with grading(tmp_path, 8, hears_control_c=False) as run:
        os.killpg(run.pid, signal.SIGINT)
        out, errors = run.communicate(timeout=60)
    assert "stopped" not in errors
    assert "s0007" in rows_of(tmp_path / "g"), (run.returncode, out, errors)
