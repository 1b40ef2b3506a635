"""A class through worker processes: one submission does nothing to another, and nothing
is graded twice.
"""

import os
import re
import signal
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from grading.classes import make_folder
from grading.students_reports import a_log
from typer.testing import CliRunner

from gyrodata.base.version import __version__
from gyrodata.base.workers import Failed, in_workers
from gyrodata.cli import app
from gyrodata.grading import classroom
from gyrodata.grading.rubric import default_rubric_text
from gyrodata.grading.submissions import Submission


def told(root: Path, *options: str | Path, workers: int = 2, code: int = 0) -> str:
    """Grade a class, and give what is said on the error stream."""
    words = [
        "grade",
        root,
        "-o",
        root.parent / "grades",
        "--workers",
        workers,
        *options,
    ]
    done = CliRunner().invoke(
        app, [str(word) for word in words], catch_exceptions=False
    )
    assert done.exit_code == code, done.stderr
    return done.stderr


BREAKING = {
    "fine ": lambda: "done",
    "hang": lambda: time.sleep(60),
    "exit": lambda: os._exit(3),
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "memory": lambda: np.ones(10**12),
    "raise": lambda: {}["x"],
}


def work(task: str) -> Any:
    """Do what the task says; at the level of the module, so that a worker finds it."""
    return BREAKING[task.rstrip("0123456789")]()


@pytest.mark.slow
@pytest.mark.parametrize(("workers", "others"), [(1, 0), (2, 60)])
def test_each_work_that_breaks_is_one_answer_with_its_reason(
    workers: int, others: int
) -> None:
    """Many tasks are sent several at a time; a task that breaks does nothing to those
    sent with it.
    """
    more = [f"fine {number}" for number in range(others)]
    done = dict(in_workers(work, [*BREAKING, *more], workers, limit=1.5))
    assert {
        task: answer.why if isinstance(answer, Failed) else answer
        for task, answer in done.items()
    } == {
        **dict.fromkeys(["fine ", *more], "done"),
        "hang": "it took over 1.5 s",
        "exit": "its process ended without an answer, perhaps for want of memory",
        "kill": "its process ended without an answer, perhaps for want of memory",
        "memory": "it needs more memory than 2 GB",
        "raise": "the tool broke on it (KeyError: 'x')",
    }


@pytest.mark.slow
@pytest.mark.skipif(
    sys.platform != "linux",
    reason="a worker that is not forked does not see the replaced function",
)
def test_a_lost_submission_is_graded_in_the_next_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = make_folder(
        tmp_path / "class", {f"s{seed}/lab.csv": a_log(seed) for seed in range(4)}
    )
    grade_submission = classroom.grade_submission

    def dies(submission: Submission, *others: Any) -> classroom.Grade:
        return (
            os._exit(3)
            if submission.student == "s2"
            else grade_submission(submission, *others)
        )

    with monkeypatch.context() as patched:
        patched.setattr(classroom, "grade_submission", dies)
        told(root, code=1)
    why = "its process ended without an answer, perhaps for want of memory"
    assert f"graded 1 (lost last time: {why}): s2" in told(root)
    assert "graded 1" not in told(root)


@pytest.mark.slow
def test_only_what_changed_is_graded_again_and_why_is_told(tmp_path: Path) -> None:
    root = make_folder(
        tmp_path / "class", {f"s{seed}/lab.csv": a_log(seed) for seed in range(4)}
    )
    rubric, text = tmp_path / "rubric.toml", default_rubric_text()

    def again(by: str = text) -> list[str]:
        rubric.write_text(by, encoding="utf-8")
        return re.findall(
            r"graded \d \(.*?\): .*", told(root, "--rubric", rubric, workers=0)
        )

    assert again() == ["graded 4 (new): s0, s1, s2, s3"]
    (root / "s1" / "lab.csv").write_text(a_log(77))
    (root / "s2").rename(root / "t2")
    assert again() == ["graded 1 (the submission changed): s1", "graded 1 (new): t2"]
    every = "s0, s1, s3, t2"
    slip, bench = (
        text.replace('slip = "50 %"', 'slip = "25 %"'),
        text.replace("[bench]\nfrom", "[bench]\n#"),
    )
    for other in (slip, bench + 'u_time = "0.3 s"\n'):
        assert again(other) == [f"graded 4 (the rubric changed): {every}"]
        assert again(other) == []
        again()
    stated = text.replace(
        '[reference]\nfrom = "class"',
        '[reference.all]\ninertia="4.4e-3 kg m^2"\nu="1 %"',
    )
    assert again(stated) == [f"graded 4 (the reference changed): {every}"]
    again()
    journal = tmp_path / "grades" / "journal.ndjson"
    grades = journal.read_text(encoding="utf-8")
    journal.write_text(
        grades.replace(f'"tool":"{__version__}"', '"tool":"0.0.1"'), encoding="utf-8"
    )
    assert again() == [
        f"graded 4 (gyrodata changed from 0.0.1 to {__version__}): {every}"
    ]
