"""Grade one submission for Gradescope, and write the files of its autograder.

Formats: gradescope-autograders.readthedocs.io (specifications, metadata). Gradescope
has no result "could not be graded": such a submission has no points in any test, and
the student reads why. If gyro itself fails, nothing is written, and Gradescope reports
that the autograder failed, which is not a zero.

A student may submit again and again. So nothing that is shown before the due date
contains the right I_zz, in words or through the size of the points: a mark that
compares with the right value shows only whether the value is met.
"""

from __future__ import annotations

import json
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path
from typing import Any

from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import GyroError, InputError
from gyrodata.base.version import __version__
from gyrodata.grading.criteria import ASKS, Mark
from gyrodata.grading.exports.pages import environment
from gyrodata.grading.grade import Grade
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submission, Submissions, submission_of
from gyrodata.grading.submissions.archives import read_file
from gyrodata.grading.submissions.names import LARGEST, LIVE, read_live
from gyrodata.results import escape_controls

# --- the autograder ---


def autograder_files(rubric: Rubric, text: str) -> dict[str, bytes]:
    """Return the files of an autograder by name.

    They are for a zip without a folder around them, which is then uploaded.
    """
    for criterion in rubric.criteria:
        if criterion.check == "reference" and rubric.class_reference:
            raise InputError.named("autograder_compares", rubric.name, id=criterion.id)
    try:
        requirements = requires("gyrodata") or []
    except PackageNotFoundError:
        raise InputError.named(
            "autograder_not_installed", version=__version__
        ) from None
    needed = [line for line in requirements if "extra ==" not in line]
    package = _package_files()
    files = {}
    for name in ("setup.sh", "run_autograder"):
        files[name] = package[f"gyrodata/grading/autograder/{name}"]
    files["rubric.toml"] = text.encode()
    files["requirements.txt"] = "".join(f"{line}\n" for line in needed).encode()
    return files | package


def _package_files() -> dict[str, bytes]:
    """Return the files of gyrodata, with their names below the folder around it."""
    home = Path(__file__).parents[2]
    package = {}
    for path in sorted(home.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            name = path.relative_to(home.parent).as_posix()
            package[name] = path.read_bytes()
    return package


def grade_autograder(root: Path, rubric: Rubric) -> str:
    """Grade the submission that a running autograder has below `root`.

    Return the text of its results.
    """
    from gyrodata.grading.classroom import grade_class

    about: dict[str, Any] = {}
    with suppress(GyroError, ValueError):
        about = read_live(read_file(root, LIVE, LARGEST))
    try:
        submission, _ = submission_of([root / "submission"], about)
    except GyroError as error:
        why = error.diagnostics[0].message
        submission = Submission("submission", "submission", {}, root, problem=why)
    # A class of one: a log that takes too long is reported as not graded.
    class_grades = grade_class(Submissions("gradescope", (submission,)), rubric)
    return results_json(class_grades.grades[0])


# --- its results ---


def results_json(grade: Grade) -> str:
    """Write the results of one submission.

    A mark that could not be judged is a test without points, not a failure.
    """
    judged = [mark for mark in grade.marks if mark.points is not None]
    titles = _secret_titles()
    errors = {
        diagnostic["code"]
        for diagnostic in grade.diagnostics
        if diagnostic["severity"] == "error"
    }
    is_secret = not errors.isdisjoint(titles)
    output = environment().get_template("gradescope.txt.jinja")
    why = "the log cannot be analysed" if is_secret else grade.why
    visible = [mark for mark in judged if not _compares(mark)]
    marks = {"judged": judged, "visible": visible}
    text = output.render(grade=grade, why=why, titles=titles, **marks)
    points = sum(mark.points or 0.0 for mark in judged)
    score = points - grade.late_deduction
    results: dict[str, Any] = {
        "score": round(max(0.0, score), 2),
        "output": text.rstrip("\n"),
        "stdout_visibility": "hidden",
        "extra_data": {
            "status": grade.status,
            "rubric": grade.rubric,
            "submission": grade.digest,
        },
        "tests": [_test(mark) for mark in grade.marks],
    }
    text = json.dumps(results, ensure_ascii=False, indent=1, allow_nan=False) + "\n"
    return escape_controls(text.encode("utf-8", "surrogatepass")).decode(
        "utf-8", "surrogatepass"
    )


def _secret_titles() -> dict[str, str]:
    """Return the titles of messages that may contain the value of the runs, by code.

    Findings of the fit do: only their titles are shown.
    """
    shown = {*ASKS.values()}
    titles = {}
    for code, explanation in explanations().items():
        if code.startswith("G4") and code not in shown:
            titles[code] = explanation.title
    return titles


def _compares(mark: Mark) -> bool:
    """Return whether the reason and the points of a mark reveal the right value."""
    return any(name in mark.detail for name in ("d", "z", "ratio"))


def _test(mark: Mark) -> dict[str, Any]:
    output = mark.reason
    status = {"status": "passed" if (mark.points or 0.0) >= mark.out_of else "failed"}
    if mark.points is None:
        output = f"Not judged ({mark.out_of:g} points): {mark.reason}"
        status = {}
    elif mark.check == "log" and mark.detail.get("warnings"):
        output = f"Things to correct, listed above: {mark.detail['warnings']:g}"
    return {
        "name": mark.title,
        "score": mark.points or 0.0,
        # Points by hand are entered in Gradescope itself, next to the points of the
        # autograder.
        "max_score": 0.0 if mark.check == "manual" else mark.out_of,
        "output": output,
        "visibility": "after_due_date" if _compares(mark) else "visible",
        **status,
    }
