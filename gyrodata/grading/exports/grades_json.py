"""The grades of a class for programs: "gyro.grades/1", one object for the class, and "gyro.grade/1", one a student."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from gyrodata import __version__

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.desk import Change
    from gyrodata.grading.forensics import Flag
    from gyrodata.grading.grade import Grade


SCHEMA = "gyro.grades/1"
STUDENT_SCHEMA = "gyro.grade/1"

_TOOL = {"name": "gyrodata", "version": __version__}


def grades_document(found: ClassGrades, changes: Sequence[Change] | None = None) -> Iterator[str]:
    """Write the grades of a class as one JSON object, piece by piece, for a class may be large.

    `changes`: Against the table of an earlier run, where that was asked for. Gives: Text; each student stands on a
    line.
    """
    head = {
        "schema": SCHEMA,
        "tool": _TOOL,
        "input": {
            "name": found.source,
            "lms": found.submissions.lms,
            "submissions": len(found.grades),
            "rubric": found.rubric.name,
            "rubric_sha256": found.rubric.digest,
        },
        "title": found.rubric.title,
        "out_of": found.rubric.points,
        "summary": {
            "graded": len(found.totals),
            "not_graded": len(found.grades) - len(found.totals),
            "mean": found.mean,
            "median": found.median,
        },
        "criteria": [{name: getattr(one, name) for name in one.__slots__} for one in found.criteria()],
        "references": {
            station: {"inertia": one.inertia, "u": one.u, "source": one.source}
            for station, one in sorted(found.references.items())
        },
        "slips": found.slips,
        "flags": [flag_dict(flag) for flag in found.flags],
        "changes": None if changes is None else [change.to_dict() for change in changes],
        "diagnostics": [diagnostic.to_dict() for diagnostic in found.submissions.diagnostics],
    }
    yield json.dumps(head, indent=2, allow_nan=False).removesuffix("\n}") + ',\n  "students": ['
    for number, grade in enumerate(found.grades):
        yield ("," if number else "") + "\n    " + json.dumps(_student(found, grade), allow_nan=False)
    yield "\n  ]\n}\n"


def grade_lines(found: ClassGrades) -> Iterator[str]:
    """Write one JSON object for each student, one a line."""
    for grade in found.grades:
        head = {"schema": STUDENT_SCHEMA, "tool": _TOOL}
        yield json.dumps(head | _student(found, grade), allow_nan=False) + "\n"


def flag_dict(flag: Flag) -> dict[str, Any]:
    """Give a flag as JSON can hold it."""
    return {
        "kind": flag.kind,
        "students": list(flag.students),
        "previous": list(flag.previous),
        "evidence": flag.evidence,
        "p": flag.p,
        "expected": flag.expected,
    }


def _student(found: ClassGrades, grade: Grade) -> dict[str, Any]:
    """One student, with what the platform calls them, and without the fingerprint, which is for the journal."""
    content = grade.to_dict()
    del content["fingerprint"], content["title"]
    flags = [flag.kind for flag in found.flags_of.get(grade.student, ())]
    return content | {"flags": flags, "ids": dict(found.ids[grade.student])}
