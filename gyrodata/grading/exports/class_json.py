"""Write the grades as JSON: "gyro.grades/1", one object for the class, and "gyro.grade/1", one for each student."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Literal

from msgspec import Struct

from gyrodata.errors import DiagnosticJson
from gyrodata.grading.classroom import ClassGrades, CriterionFigures
from gyrodata.grading.exports import Change
from gyrodata.grading.forensics import Flag
from gyrodata.grading.grade import Grade, ShownGrade
from gyrodata.grading.yardsticks import BenchScatter, Reference
from gyrodata.reporting.data import json_text
from gyrodata.results import Tool, encode, to_json


class ClassInput(Struct):
    """The graded class and its rubric."""

    name: str
    lms: str
    submissions: int
    rubric: str
    rubric_sha256: str


class ClassSummary(Struct):
    """The number of graded students, and their points."""

    graded: int
    not_graded: int
    mean: float | None
    median: float | None


class AbsentPerson(Struct):
    """A student without a submission."""

    student: str
    name: str
    section: str


class Student(ShownGrade, frozen=True, kw_only=True):
    """One student; a line of --format ndjson is such an object, with "schema": "gyro.grade/1" and "tool"."""

    flags: tuple[str, ...]
    ids: Mapping[str, str]
    """The student's identifiers on the platform."""


class GradesDocument(Struct, kw_only=True):
    """The document of ``gyro grade --format json``: all quantities are SI, times seconds."""

    schema: Literal["gyro.grades/1"] = "gyro.grades/1"
    tool: Tool = Tool()
    input: ClassInput
    title: str
    out_of: float
    summary: ClassSummary
    criteria: tuple[CriterionFigures, ...]
    references: Mapping[str, Reference]
    scatters: Mapping[str, BenchScatter]
    absent: tuple[AbsentPerson, ...]
    slips: Mapping[str, list[str]]
    flags: tuple[Flag, ...]
    changes: tuple[Change, ...] | None
    diagnostics: tuple[DiagnosticJson, ...]
    students: tuple[Student, ...] = ()


def grades_document(found: ClassGrades, changes: Iterable[Change] | None = None) -> Iterator[str]:
    """Write the grades of a class as one JSON object, in pieces with one student each, for a class may be large.

    `changes`: Differences from the table of an earlier run, if they were asked for.
    """
    rubric, graded, count = found.rubric, len(found.totals), len(found.grades)
    head = GradesDocument(
        input=ClassInput(found.source, found.submissions.lms, count, rubric.name, rubric.digest),
        title=rubric.title,
        out_of=rubric.points,
        summary=ClassSummary(graded, count - graded, found.mean, found.median),
        criteria=tuple(found.criteria()),
        references=dict(sorted(found.references.items())),
        scatters=dict(sorted(found.scatters.items())),
        absent=tuple(AbsentPerson(one.student, one.name, one.section) for one in found.roster.absent),
        slips=found.slips,
        flags=found.flags,
        changes=None if changes is None else tuple(changes),
        diagnostics=tuple(one.to_dict() for one in found.submissions.diagnostics),
    )
    yield json_text(to_json(head)).removesuffix("]\n}\n")
    for number, grade in enumerate(found.grades):
        yield ("," if number else "") + "\n    " + encode(_student(found, grade)).decode()
    yield "\n  ]\n}\n"


def grade_lines(found: ClassGrades) -> Iterator[str]:
    """Write one JSON object for each student, one per line."""
    for grade in found.grades:
        line = {"schema": "gyro.grade/1", "tool": Tool(), **to_json(_student(found, grade))}
        yield encode(line).decode() + "\n"


def _student(found: ClassGrades, grade: Grade) -> Student:
    told = {name: getattr(grade, name) for name in ShownGrade.__struct_fields__}
    flags = tuple(flag.kind for flag in found.flags_of.get(grade.student, ()))
    return Student(**told, flags=flags, ids=found.ids[grade.student])
