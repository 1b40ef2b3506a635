"""Files whole or not at all, through no link, by one gyro at a time, under names that every system can write."""

from __future__ import annotations

import errno
import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from gyrodata import analyze
from gyrodata.cli import app
from gyrodata.disk import (
    LOCK,
    add_line,
    alone_in,
    clear,
    file_name,
    files_like,
    last_line,
    open_end,
    write_changed,
    write_folder,
    write_whole,
)
from gyrodata.errors import InputError

ROOT = Path(__file__).parent.parent
SAMPLE = ROOT / "sample_data" / "air_gyroscope.csv"
CLASS = ROOT / "sample_data" / "class"
posix = pytest.mark.skipif(os.name != "posix", reason="modes, links and signals of POSIX")


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_a_file_that_is_so_already_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "new" / "file"
    assert write_changed(path, b"one") is None
    before = path.stat().st_ino
    assert write_changed(path, b"one") is None
    assert path.stat().st_ino == before
    assert write_changed(path, b"two", sync=True) == b"one"
    assert path.read_bytes() == b"two"
    assert [one.name for one in path.parent.iterdir()] == ["file"]


@posix
def test_what_is_private_is_its_owner_s_alone_and_what_is_there_keeps_its_mode(tmp_path: Path) -> None:
    grades = tmp_path / "grades" / "grades.csv"
    write_whole(grades, [b"1"], private=True)
    assert (mode(grades.parent), mode(grades)) == (0o700, 0o600)
    grades.chmod(0o640)
    write_whole(grades, [b"2"], private=True)
    assert mode(grades) == 0o640
    write_whole(tmp_path / "report", [b""])
    assert mode(tmp_path / "report") & 0o600 == 0o600


@posix
def test_grades_are_their_owner_s_alone(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["grade", str(CLASS), "-o", str(tmp_path / "g"), "--workers", "0", "--exit-zero"])
    assert done.exit_code == 0
    paths = list((tmp_path / "g").rglob("*"))
    assert {mode(path) for path in [tmp_path / "g", *paths] if path.is_dir()} == {0o700}
    assert {mode(path) for path in paths if path.is_file()} == {0o600}
    assert not (tmp_path / "g" / LOCK).exists()


@posix
def test_no_link_that_somebody_planted_is_followed(tmp_path: Path) -> None:
    thesis = tmp_path / "thesis.txt"
    thesis.write_text("my own")
    folder = tmp_path / "grades"
    folder.mkdir()
    for name in ("grades.csv", ".grades.csv.part", "journal.ndjson", LOCK):
        (folder / name).symlink_to(thesis)
    write_whole(folder / "grades.csv", [b"new"])
    assert not (folder / "grades.csv").is_symlink()
    with pytest.raises(OSError, match="symbolic"):
        open_end(folder / "journal.ndjson")
    with pytest.raises(OSError, match="symbolic"), alone_in(folder):
        pass
    assert thesis.read_text() == "my own"


def test_a_line_that_was_torn_stays_by_itself(tmp_path: Path) -> None:
    path = tmp_path / "lines"
    path.write_bytes(b"whole\ntorn")
    with open_end(path) as file:
        assert add_line(file, b"next\n") == len(b"whole\ntorn\n")
        assert add_line(file, b"other\n") == len(b"whole\ntorn\nnext\n")
    assert path.read_bytes() == b"whole\ntorn\nnext\nother\n"
    assert last_line(path) == (16, b"other\n")


def test_a_folder_that_cannot_be_listed_is_not_taken_for_an_empty_one(tmp_path: Path) -> None:
    for name in ("b-1.csv", "a-1.csv", "a-2.txt"):
        (tmp_path / name).touch()
    assert [path.name for path in files_like(tmp_path, "?-1.csv")] == ["a-1.csv", "b-1.csv"]
    assert files_like(tmp_path / "nothing", "*") == []
    with pytest.raises(OSError, match="Not a directory"):
        files_like(tmp_path / "a-1.csv", "*")


# --- a report as a whole ------------------------------------------------------------------------------------


def test_a_report_that_cannot_be_written_leaves_the_old_one_and_other_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_folder(tmp_path / "report", {"a": b"1", "b": b"1"})
    (tmp_path / "report" / "mine.txt").write_text("mine")
    real = os.open

    def full(path: Any, flags: int, *given: Any, **named: Any) -> int:
        if flags & os.O_CREAT and str(path).endswith("b"):
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, flags, *given, **named)

    with monkeypatch.context() as patch:
        patch.setattr(os, "open", full)
        with pytest.raises(OSError, match="No space left"):
            write_folder(tmp_path / "report", {"a": b"2", "b": b"2"})
        with pytest.raises(OSError, match="No space left"):
            write_folder(tmp_path / "new", {"a": b"2", "b": b"2"})
    found = {path.name: path.read_bytes() for path in (tmp_path / "report").iterdir()}
    assert found == {"a": b"1", "b": b"1", "mine.txt": b"mine"}
    assert not (tmp_path / "new").exists()
    write_folder(tmp_path / "report", {"a": b"2", "b": b"2"})
    found = {path.name: path.read_bytes() for path in (tmp_path / "report").iterdir()}
    assert found == {"a": b"2", "b": b"2", "mine.txt": b"mine"}


def test_what_a_killed_run_left_goes_and_what_is_being_written_stays(tmp_path: Path) -> None:
    (tmp_path / f".gyro-{'0' * 16}.part").write_bytes(b"half")
    (tmp_path / f".gyro-{'1' * 16}.part").mkdir()
    (tmp_path / f".gyro-{'1' * 16}.part" / "a").write_bytes(b"half")
    (tmp_path / ".gyro-mine").write_bytes(b"")

    def parts() -> Any:
        yield b"first"
        clear(tmp_path)
        yield b"second"

    write_whole(tmp_path / "file", parts())
    assert sorted(path.name for path in tmp_path.iterdir()) == [".gyro-mine", "file"]
    assert (tmp_path / "file").read_bytes() == b"firstsecond"


# --- one at a time ------------------------------------------------------------------------------------------


def test_another_gyro_at_work_is_told_and_a_killed_one_is_no_hindrance(tmp_path: Path) -> None:
    (tmp_path / LOCK).write_text("of one that was killed")
    with alone_in(tmp_path):
        with pytest.raises(InputError, match=r"G609.*another gyro is at work here") as caught, alone_in(tmp_path):
            pass
        assert "choose another folder with --out" in caught.value.diagnostics[0].hint
        with pytest.raises(InputError, match="G609"):
            analyze(SAMPLE).report(tmp_path)
        done = CliRunner().invoke(app, ["analyze", str(SAMPLE), "-o", str(tmp_path)])
        assert (done.exit_code, "error G609" in done.stderr) == (2, True)
        # A single file is nobody's folder.
        done = CliRunner().invoke(app, ["analyze", str(SAMPLE), "-f", "json", "-o", str(tmp_path / "x.json")])
        assert done.exit_code == 0
    assert [path.name for path in tmp_path.iterdir()] == ["x.json"]


@posix
def test_a_system_without_locks_lets_everybody_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", none)
    with alone_in(tmp_path), alone_in(tmp_path):
        pass


def test_three_runs_at_once_on_one_folder(tmp_path: Path) -> None:
    line = [sys.executable, "-m", "gyrodata", "grade", str(CLASS), "--workers", "0", "--exit-zero", "-o"]
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    with alone_in(tmp_path / "g", ours=True):
        # As a run does that is not done yet.
        late = [subprocess.Popen([*line, "g"], cwd=tmp_path, env=env, stderr=subprocess.PIPE) for _ in range(2)]
        for one in late:
            _, told = one.communicate(timeout=120)
            assert one.returncode == 2
            assert b"error G609" in told
        assert [path.name for path in (tmp_path / "g").iterdir()] == [LOCK]


# --- names ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["doejane_9876_55501_lab", "שרה כהן_1234572_assignsubmission_file_my_lab", "a" * 250])
def test_a_name_that_every_system_writes_stays(name: str) -> None:
    assert file_name(name, room=5) == name


@pytest.mark.parametrize(
    ("name", "begins"),
    [
        ("a" * 251, "aaaa"),
        ("я" * 127, "яяя"),
        ('a<b>c:d"e|f?g*h', "a_b_c_d_e_f_g_h-"),
        ("a/b\\c", "a_b_c-"),
        ("tab\there\x7f", "tab_here_-"),
        ("CON", "_CON-"),
        ("nul.csv", "_nul.csv-"),
        ("LPT¹", "_LPT¹-"),
        ("ends in a dot.", "ends in a dot_-"),
        ("ends in a blank ", "ends in a blank_-"),
        ("", "_-"),
    ],
)
def test_a_name_that_some_system_cannot_write_is_another(name: str, begins: str, tmp_path: Path) -> None:
    safe = file_name(name, room=5)
    assert safe.startswith(begins)
    assert len(safe.encode()) + 5 <= 255
    assert file_name(safe, room=5) == safe
    assert file_name(f"{name}x", room=5) != safe
    write_whole(tmp_path / f"{safe}.html", [b""])


@posix
def test_a_student_s_long_name_costs_nobody_anything(tmp_path: Path) -> None:
    root = tmp_path / "class"
    root.mkdir()
    log = (CLASS / "bakertom_102_9002_gyroscope.csv").read_bytes()
    for name in ("ann_101_9001_lab.csv", f"bob_102_9002_{'ж' * 119}.csv", "eve_103_9003_a?b.csv"):
        (root / name).write_bytes(log)
    done = CliRunner().invoke(app, ["grade", str(root), "-o", str(tmp_path / "g"), "--workers", "0", "--exit-zero"])
    assert done.exit_code == 0
    assert len(list((tmp_path / "g" / "feedback").glob("*.html"))) == 3
    # A name that cannot be written even so: a folder stands in its place.
    page = tmp_path / "g" / "feedback" / "ann_101_9001_lab.html"
    page.unlink()
    page.mkdir()
    done = CliRunner().invoke(app, ["grade", str(root), "-o", str(tmp_path / "g"), "--workers", "0"])
    assert done.exit_code == 1
    assert "no feedback for ann: Is a directory" in done.stderr
    assert "bob" in (tmp_path / "g" / "grades.csv").read_text()
