"""Work that goes wrong in every way that work can."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
from msgspec import convert
from msgspec.structs import replace

from gyrodata.grading import Grade, Rubric, Submission, grade_submission
from gyrodata.stacks import in_step


def work(task: str) -> str:
    """Do what the task says; "fine" is fine."""
    what, _, detail = task.partition(" ")
    if what == "hang":
        while True:
            pass
    if what == "sleep":
        time.sleep(float(detail))
    if what == "exit":
        os._exit(3)
    if what == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "memory":
        np.ones(10**12)
    if what == "crowd":  # there is room for one of them only
        block = bytearray(1_200_000_000)
        _meet()
        return f"{task} done" if len(block) else ""
    if what == "deep":
        return work(task)
    if what == "raise":
        raise KeyError(detail)
    if what == "once":  # dies the first time only
        mark = Path(detail)
        if not mark.exists():
            mark.touch()
            os._exit(1)
    return f"{task} done"


@in_step
def _meet() -> None:
    pass


def first_alone(mark: Path) -> Callable[[str], str]:
    """Give the work to the process that comes first; others die."""
    try:
        mark.touch(exist_ok=False)
    except FileExistsError:
        os._exit(4)
    return work


def grade(submission: Submission, rubric: Rubric, reported: str | None = None) -> Grade:
    """Grade as always, but for students whose key says what goes wrong."""
    what = submission.student.rstrip("0123456789")
    if what in ("hang", "exit", "kill", "memory", "raise"):
        work(what)
    if what == "not":
        return replace(grade_submission(submission, rubric), d=float("nan"))
    return grade_submission(submission, rubric)


def quick(submission: Submission, rubric: Rubric, reported: str | None = None) -> Grade:
    """Grade in no time: what another student got, with spins and times that are nobody else's."""
    grade = _another()
    assert grade.fingerprint is not None
    random = np.random.default_rng(list(submission.student.encode()))
    time = tuple(np.round(20 * random.random(len(grade.fingerprint.time)) + 1, 2).tolist())
    spin = tuple((np.array(grade.fingerprint.spin) * random.uniform(0.8, 1.2, len(time))).tolist())
    one = replace(grade.fingerprint, sha256=submission.student, time=time, spin=spin)
    return replace(grade, student=submission.student, name=submission.name, fingerprint=one)


@lru_cache(maxsize=1)
def _another() -> Grade:
    text = (Path(__file__).parent / "expected" / "slip.json").read_text(encoding="utf-8")
    return convert(json.loads(text), Grade)


def fail(submission: Submission, rubric: Rubric, reported: str | None = None) -> Grade:
    """Never called where every grade is known."""
    raise AssertionError(submission.student)
