"""``gyro check --hand-in``: show the answer that gyro will read from a submission."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from gyrodata.diagnostics import ANSWER_ELSEWHERE, ANSWER_MISSING, ANSWER_READ, NO_SUBMISSION
from gyrodata.errors import Diagnostic, InputError, shown
from gyrodata.grading.grade import station_of
from gyrodata.grading.submissions import submission_of
from gyrodata.readings import Readings, Reported, listing
from gyrodata.reporting.values import inertia_text
from gyrodata.results import HandIn


def read_hand_in(paths: Sequence[Path]) -> tuple[Readings, HandIn, tuple[Diagnostic, ...]]:
    """Read a student's files, or folder or zip, as `grade_submission` does, and report the answer in it."""
    submission, told = submission_of(paths)
    if submission.problem is not None:
        hint = "a log is a CSV file or a workbook; gyro template prints one to fill in"
        raise InputError.of(NO_SUBMISSION, submission.problem, hint, paths[0].name)
    readings, answers = submission.read()
    reported, station = answers.inertia or Reported("inertia", ""), station_of(readings)
    one = HandIn(
        text=reported.text or None, inertia=reported.value, u=reported.u, file=answers.file or None,
        line=reported.line, station=station
    )  # fmt: skip
    # The place of the answer is reported once.
    others = [found for found in answers.diagnostics if found.code != ANSWER_ELSEWHERE]
    code, file, hint = ANSWER_READ, one.file or "", ""
    if one.inertia is not None:
        message = f"I_zz = {inertia_text(one.inertia, one.u)}, read from {one.file}"
        message += f", line {one.line}" if one.line else ""
        parts = ("no uncertainty is found with it" if one.u is None else "", reported.problem)
        message = "; ".join([message, *filter(None, parts), *([f"station: {station}"] if station else [])])
    else:
        log = shown(PurePosixPath(submission.log_file or "").name)
        hint = f"write one line above the table of {log}, with your value: # reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2"
        code, file, message = ANSWER_MISSING, one.file or log, f"the answer cannot be read: {reported.problem}"
        if answers.inertia is None:
            read = [name for name in (submission.log_name, *submission.report_names) if name]
            unread = [name for name in submission.members if name not in read]
            names, others_named = (
                listing(sorted(shown(PurePosixPath(name).name) for name in some)) for some in (read, unread)
            )
            message = f"no I_zz is found in {names}{f'; not read: {others_named}' if unread else ''}"
        elif one.file == log:
            hint += ", and take its other lines with an I_zz out"
    return readings, one, (*told, *others, Diagnostic.of(code, message, hint, file, one.line))
