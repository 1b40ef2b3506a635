"""Work that goes wrong in every way that work can."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from gyrodata.grading.grade import Grade, grade_submission
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission


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


def grade(submission: Submission, rubric: Rubric) -> Grade:
    """Grade as always, but for students whose key says what goes wrong."""
    what = submission.student.rstrip("0123456789")
    if what in ("hang", "exit", "kill", "memory", "raise"):
        work(what)
    if what == "not":
        return replace(grade_submission(submission, rubric), d=float("nan"))
    return grade_submission(submission, rubric)


def fail(submission: Submission, rubric: Rubric) -> Grade:
    """Never called where every grade is known."""
    raise AssertionError(submission.student)
