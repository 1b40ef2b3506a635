"""``gyro check --hand-in``: show the answer that gyro will read from a submission."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from gyrodata.diagnostics import ANSWER_ELSEWHERE, ANSWER_MISSING, ANSWER_READ, NO_SUBMISSION
from gyrodata.errors import Diagnostic, InputError, shown
from gyrodata.grading.grade import station_of
from gyrodata.grading.submissions import Submission, submission_of
from gyrodata.grading.submissions.student_files import Answers
from gyrodata.readings import Readings, Reported, listing
from gyrodata.reporting.values import inertia_text
from gyrodata.results import HandIn


def read_hand_in(paths: Sequence[Path]) -> tuple[Readings, HandIn, tuple[Diagnostic, ...]]:
    """Read a student's files, or folder or zip, as `grade_submission` does, and say what is taken for the answer."""
    submission, told = submission_of(paths)
    if submission.problem is not None:
        hint = "a log is a CSV file or a workbook; gyro template prints one to fill in"
        raise InputError.of(NO_SUBMISSION, submission.problem, hint, paths[0].name)
    readings, answers = submission.read()
    reported = answers.inertia or Reported("inertia", "")
    one = HandIn(
        text=reported.text or None, inertia=reported.value, u=reported.u, file=answers.file or None,
        line=reported.line, station=station_of(readings),
    )  # fmt: skip
    # Where the answer stands is said once.
    others = [found for found in answers.diagnostics if found.code != ANSWER_ELSEWHERE]
    said = _missing(submission, answers, one) if one.inertia is None else _found(answers, one)
    return readings, one, (*told, *others, said)


def _found(answers: Answers, one: HandIn) -> Diagnostic:
    place = f"{one.file}, line {one.line}" if one.line else f"{one.file}"
    message = f"I_zz = {inertia_text(one.inertia or 0.0, one.u)}, read from {place}"
    if one.u is None:
        message += "; no uncertainty is found with it"
    if answers.inertia is not None and answers.inertia.problem:
        message += f"; {answers.inertia.problem}"
    if one.station is not None:
        message += f"; station: {one.station}"
    return Diagnostic.of(ANSWER_READ, message, "", one.file or "", one.line)


def _missing(submission: Submission, answers: Answers, one: HandIn) -> Diagnostic:
    log = shown(PurePosixPath(submission.log_file or "").name)
    hint = f"write one line above the table of {log}, with your value: # reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2"
    if answers.inertia is None:
        read = [name for name in (submission.log_name, *submission.report_names) if name]
        names = sorted(shown(PurePosixPath(name).name) for name in read)
        unread = sorted(shown(PurePosixPath(name).name) for name in submission.members if name not in read)
        message = f"no I_zz is found in {listing(names)}{f'; not read: {listing(unread)}' if unread else ''}"
        return Diagnostic.of(ANSWER_MISSING, message, hint, log)
    message = f"the answer cannot be read: {answers.inertia.problem}"
    if one.file == log:
        hint += ", and take its other lines with an I_zz out"
    return Diagnostic.of(ANSWER_MISSING, message, hint, one.file or log, one.line)
