"""Files whole or not at all, through no link, by one gyro at a time, under names that
every system can write.
"""

from __future__ import annotations

import errno
import itertools
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from analyzed_once import drawn_once
from places import SAMPLES
from typer.testing import CliRunner, Result

from gyrodata.base.disk import LOCK, alone_in
from gyrodata.cli import app

SAMPLE, CLASS = SAMPLES / "air_gyroscope.csv", SAMPLES / "class"
posix = pytest.mark.skipif(
    os.name != "posix", reason="modes, links and signals of POSIX"
)


def gyro(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


def grade(folder: Path, out: Path, *words: object) -> Result:
    return gyro("grade", folder, "-o", out, "--workers", 0, *words)


@pytest.fixture(scope="module", autouse=True)
def figures_are_kept() -> Iterator[None]:
    """A report needs figures, and no test here looks at one."""
    with drawn_once():
        yield


@pytest.mark.slow
@posix
def test_grades_are_readable_by_their_owner_only(tmp_path: Path) -> None:
    out = tmp_path / "g"
    assert grade(CLASS, out, "--exit-zero").exit_code == 0
    for path in (out, *out.rglob("*")):
        assert stat.S_IMODE(path.stat().st_mode) == (0o700 if path.is_dir() else 0o600)
    assert not (out / LOCK).exists()


@pytest.mark.slow
@posix
@pytest.mark.parametrize("name", ["grades.csv", LOCK])
def test_a_planted_link_is_not_followed(name: str, tmp_path: Path) -> None:
    (tmp_path / "g").mkdir()
    (tmp_path / "thesis.txt").write_text("my own")
    (tmp_path / "g" / name).symlink_to(tmp_path / "thesis.txt")
    done = grade(CLASS, tmp_path / "g", "--exit-zero")
    assert (done.exit_code, "error G" in done.stderr) in ((0, False), (2, True))
    assert (tmp_path / "thesis.txt").read_text() == "my own"


@pytest.mark.slow
def test_a_full_disk_leaves_the_old_report_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report = tmp_path / "report"
    assert gyro("analyze", SAMPLE, "-o", report).exit_code == 0
    (report / "mine.txt").write_text("mine")
    before = {path.name: path.read_bytes() for path in report.iterdir()}
    real, count = os.open, itertools.count(1)

    def full(path: Any, flags: int, *given: Any, **named: Any) -> int:
        if flags & os.O_CREAT and next(count) % 4 == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(path, flags, *given, **named)

    monkeypatch.setattr(os, "open", full)
    for folder in (report, tmp_path / "new"):
        done = gyro("analyze", SAMPLE, "-o", folder, "--set", "g=9.9 m/s^2")
        assert (done.exit_code, "No space left" in done.stderr) == (2, True)
    assert {path.name: path.read_bytes() for path in report.iterdir()} == before
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_a_second_gyro_in_a_folder_is_refused_with_g609(tmp_path: Path) -> None:
    (tmp_path / LOCK).write_text("of one that was killed")
    with alone_in(tmp_path):
        for done in (gyro("analyze", SAMPLE, "-o", tmp_path), grade(CLASS, tmp_path)):
            assert (done.exit_code, "error G609" in done.stderr) == (2, True)
            assert "choose another folder with --out" in " ".join(done.stderr.split())
        # A single file needs no folder of its own.
        assert (
            gyro("analyze", SAMPLE, "-f", "json", "-o", tmp_path / "x.json").exit_code
            == 0
        )
    assert [path.name for path in tmp_path.iterdir()] == ["x.json"]


@pytest.mark.slow
@posix
def test_a_long_or_strange_file_name_costs_no_student(tmp_path: Path) -> None:
    root, out = tmp_path / "class", tmp_path / "g"
    root.mkdir()
    for name in (
        "ann_101_9001_lab.csv",
        f"bob_102_9002_{'ж' * 119}.csv",
        "eve_103_9003_a?b.csv",
    ):
        (root / name).write_bytes(
            (CLASS / "bakertom_102_9002_gyroscope.csv").read_bytes()
        )
    assert grade(root, out, "--exit-zero").exit_code == 0
    assert len(list((out / "feedback").glob("*.html"))) == 3
