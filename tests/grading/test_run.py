"""A class through worker processes: one submission does nothing to another, and nothing is graded twice."""

from __future__ import annotations

import errno
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from grading.classes import make_folder
from grading.reports import RIGHT, reported_line, sheet
from typer.testing import CliRunner, Result

from gyrodata import __version__
from gyrodata.cli import app
from gyrodata.grading import default_rubric_text
from gyrodata.workers import Failed, in_workers

ROOT = Path(__file__).parents[2]


def a_log(seed: int) -> str:
    rows = sheet(np.random.default_rng(seed), "mixed")
    return rows.log("# station: 3", reported_line(*RIGHT.inertia(rows, "with_constant")))


def gyro(root: Path, out: Path, *options: str | Path) -> Result:
    words = ["grade", root, "-o", out, "--workers", "2", *options]
    return CliRunner().invoke(app, [str(word) for word in words], catch_exceptions=False)


def files_of(folder: Path) -> dict[str, bytes]:
    """All that a run leaves but its journal, which is in the order in which grades were made."""
    paths = (path for path in folder.rglob("*") if path.is_file() and path.name != "journal.ndjson")
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


@pytest.fixture
def honest(tmp_path: Path) -> Path:
    return make_folder(tmp_path / "class", {f"s{seed}/lab.csv": a_log(seed) for seed in range(4)})


def work(task: str) -> str:
    """Do what the task says; module-level, so that a worker finds it."""
    if task == "hang":
        while True:
            pass
    if task == "exit":
        os._exit(3)
    if task == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if task == "memory":
        np.ones(10**12)
    if task == "raise":
        raise KeyError("x")
    return f"{task} done"


@pytest.mark.parametrize("together", [1, 4])
def test_each_work_that_breaks_is_one_answer_with_its_reason(together: int) -> None:
    tasks = ["fine 1", "hang", "exit", "kill", "memory", "raise", "fine 2"]
    done = dict(in_workers(work, tasks, workers=3, limit=1.5, at_once=together))
    assert {task: answer.why if isinstance(answer, Failed) else answer for task, answer in done.items()} == {
        "fine 1": "fine 1 done",
        "fine 2": "fine 2 done",
        "hang": "it took over 1.5 s",
        "exit": "its process ended (exit code 3)",
        "kill": "its process was killed (SIGKILL), perhaps for want of memory",
        "memory": "it needs more memory than 2 GB",
        "raise": "the tool broke on it (KeyError: 'x')",
    }


@pytest.mark.parametrize("name", ["lab.csv", "report.txt"])
@pytest.mark.parametrize("which", [1, 2])
def test_file_that_the_disk_refuses_once_is_read_in_the_next_run(
    name: str, which: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = a_log(1).replace("# reported_inertia: ", "# note: ")
    root = make_folder(tmp_path / "class", {"a/lab.csv": log, "a/report.txt": "I_zz = 4.43e-3 ± 0.05e-3 kg m^2"})
    opened, times = Path.open, []

    def refusing(path: Path, *given: Any, **named: Any) -> Any:
        times.extend([path] * (path.name == name))
        if path.name == name and len(times) == which:
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return opened(path, *given, **named)

    monkeypatch.setattr(Path, "open", refusing)
    for _ in range(2):
        gyro(root, tmp_path / "grades", "--workers", "0")
    assert len(times) > 1
    assert ",graded,20.00," in (tmp_path / "grades" / "grades.csv").read_text(encoding="utf-8")


def test_report_above_1_mb_is_told_and_the_log_is_graded(tmp_path: Path) -> None:
    report = "I_zz = 4.43e-3 ± 0.05e-3 kg m^2\n" + "x" * 1_000_000
    root = make_folder(tmp_path / "class", {"a/lab.csv": a_log(1), "a/report.txt": report})
    assert gyro(root, tmp_path / "grades").exit_code == 0
    assert "larger than 1 MB" in (tmp_path / "grades" / "grades.json").read_text(encoding="utf-8")
    assert "kept 1 as graded before" in gyro(root, tmp_path / "grades").stderr


def test_only_what_changed_is_graded_again_and_why_is_told(honest: Path, tmp_path: Path) -> None:
    def told(text: str | None = None) -> list[str]:
        rubric = [] if text is None else ["--rubric", tmp_path / "rubric.toml"]
        (tmp_path / "rubric.toml").write_text(text or "", encoding="utf-8")
        stderr = gyro(honest, tmp_path / "grades", *rubric).stderr
        return re.findall(r"graded \d \(.*?\): .*", stderr)

    assert told() == ["graded 4 (new): s0, s1, s2, s3"]
    (honest / "s1" / "lab.csv").write_text(a_log(77))
    (honest / "s2").rename(honest / "t2")
    assert told() == ["graded 1 (the submission changed): s1", "graded 1 (new): t2"]
    text = default_rubric_text()
    every = "s0, s1, s3, t2"
    assert told(text.replace('slip = "50 %"', 'slip = "25 %"')) == [f"graded 4 (the rubric changed): {every}"]
    told()
    stated = text.replace('[reference]\nfrom = "class"', '[reference.all]\ninertia="4.4e-3 kg m^2"\nu="1 %"')
    assert told(stated) == [f"graded 4 (the reference changed): {every}"]
    told()
    journal = tmp_path / "grades" / "journal.ndjson"
    grades = journal.read_text(encoding="utf-8").splitlines(keepends=True)[:-1]
    journal.write_text("".join(grades).replace(f'"tool":"{__version__}"', '"tool":"0.0.1"'), encoding="utf-8")
    assert told() == [f"graded 4 (gyrodata changed from 0.0.1 to {__version__}): {every}"]


def test_figure_that_is_gone_is_drawn_again(tmp_path: Path) -> None:
    root = make_folder(tmp_path / "class", {"a/lab.csv": a_log(1)})
    out = tmp_path / "grades"
    gyro(root, out)
    for _ in range(2):
        assert "graded 1 (its figures are missing): a" in gyro(root, out, "--figures").stderr
        assert "kept 1 as graded before" in gyro(root, out, "--figures").stderr
        min((out / "figures" / "a").iterdir()).unlink()


def test_a_kill_loses_nothing(honest: Path, tmp_path: Path) -> None:
    """Nor does a last line that was only written in part."""
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    gyro(honest, whole)
    first = subprocess.Popen(
        [sys.executable, "-m", "gyrodata", "grade", honest, "--workers", "2", "-o", killed],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    journal = killed / "journal.ndjson"
    while first.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") >= 2):
        time.sleep(0.005)
    first.kill()
    first.wait()
    kept = journal.read_bytes().count(b"\n")
    second = gyro(honest, killed)
    assert f"kept {kept} as graded before" in second.stderr
    assert files_of(killed) == files_of(whole)
    journal.write_bytes(b"".join(journal.read_bytes().splitlines(keepends=True)[:-1])[:-40])
    third = gyro(honest, killed)
    assert "kept 3 as graded before" in third.stderr
    assert files_of(killed) == files_of(whole)
