"""A class through worker processes: one submission does nothing to another, and nothing is graded twice."""

import os
import re
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from grading.classes import make_folder
from grading.reports import a_log
from typer.testing import CliRunner

from gyrodata import __version__
from gyrodata.cli import app
from gyrodata.grading.rubric import default_rubric_text
from gyrodata.workers import Failed, in_workers


def told(root: Path, *options: str | Path, workers: int = 2) -> str:
    """Grade a class, and give what is said on the error stream."""
    words = ["grade", root, "-o", root.parent / "grades", "--workers", workers, *options]
    done = CliRunner().invoke(app, [str(word) for word in words], catch_exceptions=False)
    assert done.exit_code == 0, done.stderr
    return done.stderr


BREAKING = {
    "fine 1": lambda: "done",
    "hang": lambda: time.sleep(60),
    "exit": lambda: os._exit(3),
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "memory": lambda: np.ones(10**12),
    "raise": lambda: {}["x"],
    "fine 2": lambda: "done",
}


def work(task: str) -> Any:
    """Do what the task says; at the level of the module, so that a worker finds it."""
    return BREAKING[task]()


@pytest.mark.parametrize("workers", [1, 3])
def test_each_work_that_breaks_is_one_answer_with_its_reason(workers: int) -> None:
    done = dict(in_workers(work, list(BREAKING), workers, limit=1.5))
    assert {task: answer.why if isinstance(answer, Failed) else answer for task, answer in done.items()} == {
        "fine 1": "done",
        "fine 2": "done",
        "hang": "it took over 1.5 s",
        "exit": "its process ended without an answer, perhaps for want of memory",
        "kill": "its process ended without an answer, perhaps for want of memory",
        "memory": "it needs more memory than 2 GB",
        "raise": "the tool broke on it (KeyError: 'x')",
    }


def test_only_what_changed_is_graded_again_and_why_is_told(tmp_path: Path) -> None:
    root = make_folder(tmp_path / "class", {f"s{seed}/lab.csv": a_log(seed) for seed in range(4)})
    rubric, text = tmp_path / "rubric.toml", default_rubric_text()

    def again(by: str = text) -> list[str]:
        rubric.write_text(by, encoding="utf-8")
        return re.findall(r"graded \d \(.*?\): .*", told(root, "--rubric", rubric, workers=0))

    assert again() == ["graded 4 (new): s0, s1, s2, s3"]
    (root / "s1" / "lab.csv").write_text(a_log(77))
    (root / "s2").rename(root / "t2")
    assert again() == ["graded 1 (the submission changed): s1", "graded 1 (new): t2"]
    every = "s0, s1, s3, t2"
    slip, bench = text.replace('slip = "50 %"', 'slip = "25 %"'), text.replace("[bench]\nfrom", "[bench]\n#")
    for other in (slip, bench + 'u_time = "0.3 s"\n'):
        assert again(other) == [f"graded 4 (the rubric changed): {every}"]
        assert again(other) == []
        again()
    stated = text.replace('[reference]\nfrom = "class"', '[reference.all]\ninertia="4.4e-3 kg m^2"\nu="1 %"')
    assert again(stated) == [f"graded 4 (the reference changed): {every}"]
    again()
    journal = tmp_path / "grades" / "journal.ndjson"
    grades = journal.read_text(encoding="utf-8")
    journal.write_text(grades.replace(f'"tool":"{__version__}"', '"tool":"0.0.1"'), encoding="utf-8")
    assert again() == [f"graded 4 (gyrodata changed from 0.0.1 to {__version__}): {every}"]
