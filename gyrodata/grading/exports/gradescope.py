"""Gradescope: the results of one submission as its autograder takes them, and the autograder itself.

Formats: gradescope-autograders.readthedocs.io (specifications, submission metadata). Gradescope knows no "could not be
graded": such a submission has no points in any test and says so, in words, where the student reads it. When the tool
itself fails nothing is written, and Gradescope tells that the autograder failed, which is no zero.

A student may submit as often as he likes. So nothing that is shown before the due date tells what I_zz should be, in
words or by the size of the points: a mark that was held against the right value shows only whether it is met.
"""

from __future__ import annotations

import io
import json
import zipfile
from base64 import urlsafe_b64encode
from collections.abc import Mapping
from hashlib import sha256
from importlib.metadata import distributions
from importlib.resources import files
from pathlib import Path
from typing import Any

import gyrodata
from gyrodata.diagnostics import AUTOGRADER_CANNOT_BE_MADE, explanations
from gyrodata.errors import GyroError, InputError
from gyrodata.grading.criteria import Mark
from gyrodata.grading.grade import Grade, not_graded
from gyrodata.grading.rubric import ASKS, Rubric
from gyrodata.grading.submissions import Submission, find_submissions

_COMPARED = ("d", "z", "ratio")  # the words in the detail of a mark that compares with the right value


# --- the autograder -----------------------------------------------------------------------------------------


def autograder_files(rubric: Rubric, text: str) -> dict[str, bytes]:
    """Give the files of an autograder by name, to be zipped without a folder around them and uploaded."""
    for criterion in rubric.criteria:
        if criterion.check == "reference" and rubric.class_reference:
            message = (
                f'criterion "{criterion.id}" compares with the class, and an autograder sees one student: '
                f"nobody could earn its {criterion.points:g} points"
            )
            hint = (
                "in your --rubric (gyro grade --print-rubric full > rubric.toml gives one) write, instead of "
                '[reference] and from = "class": [reference.all], inertia = "4.44e-3 kg m^2", u = "1 %"; or take the '
                "criterion out"
            )
            raise InputError.of(AUTOGRADER_CANNOT_BE_MADE, message, hint, rubric.name)
    name, wheel = _wheel()
    scripts = files("gyrodata.grading").joinpath("autograder")
    setup, run = (scripts.joinpath(one).read_text("utf-8") for one in ("setup.sh", "run_autograder"))
    return {
        "setup.sh": setup.replace("{wheel}", name).encode(),
        "run_autograder": run.encode(),
        "rubric.toml": text.encode(),
        name: wheel,
    }


def _wheel() -> tuple[str, bytes]:
    """Pack the package as it is here: pip builds from sources only, and with a builder that it has to download."""
    version = gyrodata.__version__
    installed = next(iter(distributions(name="gyrodata")), None)
    if installed is None or installed.version != version:
        message = f"gyro {version} runs from its folder and is not installed, so that it cannot be packed"
        hint = "install it, python3 -m pip install . in its folder, and write the autograder with the installed gyro"
        raise InputError.of(AUTOGRADER_CANNOT_BE_MADE, message, hint)
    home, about = Path(gyrodata.__file__).parent, f"gyrodata-{version}.dist-info"
    paths = [path for path in sorted(home.rglob("*")) if path.is_file() and "__pycache__" not in path.parts]
    parts = {f"gyrodata/{path.relative_to(home).as_posix()}": path.read_bytes() for path in paths}
    for name in ("METADATA", "WHEEL", "entry_points.txt"):
        parts[f"{about}/{name}"] = (installed.read_text(name) or "").encode()
    digests = {name: urlsafe_b64encode(sha256(data).digest()).decode().rstrip("=") for name, data in parts.items()}
    lines = [f"{name},sha256={digest},{len(parts[name])}\n" for name, digest in digests.items()]
    parts[f"{about}/RECORD"] = "".join([*lines, f"{about}/RECORD,,\n"]).encode()
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in parts.items():
            entry = zipfile.ZipInfo(name)  # of 1980: the same package gives the same bytes
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED)
    return f"gyrodata-{version}-py3-none-any.whl", packed.getvalue()


def grade_autograder(root: Path, rubric: Rubric) -> str:
    """Grade the submission that a running autograder has below `root`, and give what belongs into its results."""
    from gyrodata.grading.classroom import grade_class

    try:
        submissions = find_submissions(root, "gradescope")
    except GyroError as error:
        why = error.diagnostics[0].message
        return results_json(not_graded(Submission("submission", "submission", {}, root, problem=why), rubric, why))
    # As a class of one: a log that hangs or breaks the tool is reported as not graded.
    return results_json(grade_class(submissions, rubric).grades[0])


# --- its results --------------------------------------------------------------------------------------------


def results_json(grade: Grade) -> str:
    """Write the results of one submission; what could not be judged is a test without points, not one failed."""
    judged = sum(mark.points for mark in grade.marks if mark.points is not None)
    results: dict[str, Any] = {
        "score": round(max(0.0, judged - grade.late_deduction), 2),
        "output": _output(grade),
        "stdout_visibility": "hidden",
        "extra_data": {"status": grade.status, "rubric": grade.rubric, "submission": grade.digest},
        "tests": [_test(mark) for mark in grade.marks],
    }
    return json.dumps(results, ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def _test(mark: Mark) -> dict[str, Any]:
    test: dict[str, Any] = {
        "name": mark.title,
        "score": mark.points or 0.0,
        # Points by hand are entered in Gradescope itself, next to the autograder's points.
        "max_score": 0.0 if mark.check == "manual" else mark.out_of,
        "output": mark.reason,
        "visibility": "after_due_date" if _compared(mark) else "visible",
    }
    if mark.points is None:
        return test | {"output": f"Not judged ({mark.out_of:g} points): {mark.reason}"}
    if mark.check == "log" and mark.detail.get("warnings"):
        test["output"] = f"Things to put right, told above: {mark.detail['warnings']:g}"
    return test | {"status": "passed" if mark.points >= mark.out_of else "failed"}


def _compared(mark: Mark) -> bool:
    """Return whether a mark's reason and points reveal the right value."""
    return any(name in mark.detail for name in _COMPARED)


def _output(grade: Grade) -> str:
    """Say to the student what the numbers mean, whether what is not shown yet is met, and what to look for."""
    judged = [mark for mark in grade.marks if mark.points is not None]
    later = [mark for mark in judged if _compared(mark)]
    shown = [mark for mark in judged if mark not in later]
    points = round(sum(mark.points or 0.0 for mark in shown), 2)
    lines = [f"{points:g} of {sum(mark.out_of for mark in shown):g} points in what is shown now."]
    for mark in later:
        met = "met" if (mark.points or 0.0) >= mark.out_of else "met in part" if mark.points else "not met"
        lines.append(f"{mark.title}: {met}. The points are shown after the due date.")
    if waiting := sum(mark.out_of for mark in grade.marks if mark.waits):
        lines.append(f"{waiting:g} points are judged later.")
    if not judged:
        # The reason of a failed fit may reveal its last value.
        secret = any(_tells_inertia(one["code"]) for one in grade.diagnostics if one["severity"] == "error")
        lines = [f"This could not be graded: {'the log cannot be analysed' if secret else grade.why}."]
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
    code = diagnostic["code"]
    words = explanations()[code].title if _tells_inertia(code) else f"{diagnostic['message']}{hint}"
    return f"{diagnostic['severity']}: {where}{words}"


def _tells_inertia(code: str) -> bool:
    """Return whether the message of a diagnostic may reveal the value of the runs, as findings of the fit do."""
    return code.startswith("G4") and code not in ASKS.values()
