"""Gradescope: the results of one submission as its autograder takes them, and the autograder itself.

Formats: gradescope-autograders.readthedocs.io (specifications, submission metadata). Gradescope knows no "could not be
graded": such a submission has no points in any test and says so, in words, where the student reads it. When the tool
itself fails nothing is written, and Gradescope tells that the autograder failed, which is no zero.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrodata import __version__
from gyrodata.grading.platforms import AUTOGRADER

if TYPE_CHECKING:
    from gyrodata.grading.criteria import Mark
    from gyrodata.grading.grade import Grade

_SETUP = """\
#!/usr/bin/env bash
# Makes the image once: gyrodata with a Python of its own, its byte code compiled, for each submission starts anew.
# Put a wheel (gyrodata-*.whl) beside this file to install that one.
set -euo pipefail
apt-get update
apt-get install -y --no-install-recommends ca-certificates python3-venv
python3 -m venv /autograder/uv
/autograder/uv/bin/pip install --quiet uv
/autograder/uv/bin/uv venv --python ">=3.11" /autograder/gyro
shopt -s nullglob
wheels=(/autograder/source/gyrodata-*.whl)
what="${{wheels[0]:-gyrodata=={version}}}"
/autograder/uv/bin/uv pip install --python /autograder/gyro/bin/python --compile-bytecode "$what"
/autograder/gyro/bin/gyro --version
"""

_RUN = """\
#!/usr/bin/env bash
# Grades /autograder/submission by the rubric beside this file, and writes results/results.json.
# After ten minutes Gradescope would give a zero; an autograder that is stopped before is told as one that failed.
exec timeout 300 /autograder/gyro/bin/gyro autograde /autograder
"""


def autograder_files(rubric: str) -> dict[str, str]:
    """Give the files of an autograder by name, to be zipped without a folder around them and uploaded."""
    return {"setup.sh": _SETUP.format(version=__version__), "run_autograder": _RUN, "rubric.toml": rubric}


def grade_autograder(root: Path) -> str:
    """Grade the submission that a running autograder has below `root`, and give what belongs into its results."""
    from gyrodata.grading.grade import grade_submission, settle
    from gyrodata.grading.rubric import default_rubric_text, read_rubric
    from gyrodata.grading.submissions import find_submissions

    own = root / AUTOGRADER.rubric
    rubric = read_rubric(own.read_bytes() if own.exists() else default_rubric_text().encode(), own.name)
    grade = grade_submission(find_submissions(root, "gradescope").items[0], rubric)
    # What is held against the median of a class waits for the class.
    return results_json(grade if rubric.class_reference else settle((grade,), rubric)[0])


def results_json(grade: Grade) -> str:
    """Write the results of one submission; what could not be judged is a test without points, not one failed."""
    judged = sum(mark.points for mark in grade.marks if mark.points is not None)
    results: dict[str, Any] = {
        "score": round(max(0.0, judged - grade.late_deduction), 2) if judged else 0.0,
        "output": _output(grade, judged),
        "output_format": "text",
        "test_output_format": "text",
        "test_name_format": "text",
        "stdout_visibility": "hidden",
        "extra_data": {"status": grade.status, "rubric": grade.rubric, "submission": grade.digest},
        "tests": [_test(number, mark) for number, mark in enumerate(grade.marks, 1)],
    }
    return json.dumps(results, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def _test(number: int, mark: Mark) -> dict[str, Any]:
    if mark.points is None:
        waits = f"Not judged yet ({mark.out_of:g} points): {mark.reason}"
        return {"number": str(number), "name": mark.title, "score": 0.0, "max_score": 0.0, "output": waits}
    return {
        "number": str(number),
        "name": mark.title,
        "score": mark.points,
        "max_score": mark.out_of,
        "status": "passed" if mark.points >= mark.out_of else "failed",
        "output": mark.reason,
    }


def _output(grade: Grade, judged: float) -> str:
    """Say to the student what the numbers mean."""
    waiting = sum(mark.out_of for mark in grade.marks if mark.points is None)
    lines = []
    if grade.status == "graded":
        lines.append(f"{grade.points:g} of {grade.out_of:g} points.")
    elif judged:
        lines.append(f"{judged:g} of {grade.out_of - waiting:g} points so far; {waiting:g} are judged later.")
    else:
        lines.append(f"This could not be graded: {grade.why}.")
        lines.append("That is no zero: mend it and submit again, or leave it, and somebody will look at it.")
    if grade.late_reason:
        taken = f" {grade.late_deduction:g} points are taken off." if grade.late_deduction else ""
        lines.append(f"{grade.late_reason}.{taken}")
    lines += [f"A slip to look for: {slip.words}. To check: {slip.check}." for slip in grade.slips]
    lines += [_found(one) for one in grade.diagnostics]
    return "\n".join(lines)


def _found(diagnostic: Mapping[str, Any]) -> str:
    where = f"line {diagnostic['line']}: " if diagnostic.get("line") else ""
    hint = f" ({diagnostic['hint']})" if diagnostic.get("hint") else ""
    return f"{diagnostic['severity']}: {where}{diagnostic['message']}{hint}"
