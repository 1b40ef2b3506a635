"""Write the grades of a class as CSV and as JSON, and compare two such tables.

JSON is "gyro.grades/1", one object for the class, or "gyro.grade/1", one for each
student.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from msgspec import Struct, field

from gyrodata.base.errors import DiagnosticJson, GyroError
from gyrodata.base.tool import Tool
from gyrodata.base.version import __version__
from gyrodata.grading import ledger
from gyrodata.grading.forensics import Flag
from gyrodata.grading.grade import Grade, ShownGrade, two_decimals
from gyrodata.grading.sections import SectionFigures
from gyrodata.grading.stations import StationFigures
from gyrodata.grading.yardsticks import BenchScatter, Reference
from gyrodata.readings import listing
from gyrodata.reporting.data import csv_cell, csv_lines, json_text
from gyrodata.results import encode, to_json

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades

# --- ``grades.csv``, with the possible points in the first row, and ``flags.csv`` ---

POINTS_ROW = "points possible"  # the text in the column of the students
TOTAL, STATUS = "total", "status"


def grades_csv(class_grades: ClassGrades) -> str:
    """Write the grades of a class as CSV, with the students without a submission.

    Points have two decimals; a cell is blank if nothing was judged. A text that a
    spreadsheet would run as a formula has a ' in front.
    """
    rows: dict[str, Mapping[str, str | float | None]] = {}
    for absentee in class_grades.roster.absent:
        rows[absentee.student] = {
            "student": absentee.student,
            "name": absentee.name,
            STATUS: "nothing handed in",
            "section": absentee.section,
        }
    for grade in class_grades.grades:
        flags = class_grades.flags_of.get(grade.student, ())
        rows[grade.student] = _cells(grade, flags)
    first = class_grades.grades[0]
    possible = {"student": POINTS_ROW, STATUS: "--", TOTAL: two_decimals(first.out_of)}
    possible["name"] = f"graded by gyrodata {__version__}"
    possible |= {mark.criterion: two_decimals(mark.out_of) for mark in first.marks}
    columns = list(rows[first.student])
    table = [columns, [possible.get(column, "") for column in columns]]
    for student in sorted(rows):
        row = rows[student]
        table.append([csv_cell(row.get(column)) for column in columns])
    return csv_lines(table)


def _cells(grade: Grade, flags: Iterable[Flag]) -> dict[str, str | float | None]:
    """Return the cells of one student by column."""
    remarks = []
    for flag in flags:
        others = [*flag.students, *flag.previous]
        others.remove(grade.student)
        names = listing(others, MOST_NAMED)
        remarks.append(f"{flag.kind} with {names}" if others else flag.kind)
    late = ""
    if grade.points is not None:
        late = two_decimals(grade.late_deduction)

    points = {mark.criterion: two_decimals(mark.points) for mark in grade.marks}
    return {
        "student": grade.student,
        "name": grade.name,
        STATUS: grade.status,
        TOTAL: two_decimals(grade.points),
        **points,
        "late_deduction": late,
        "late [s]": grade.late_seconds,
        "late": grade.late_reason,
        "reported [kg*m^2]": grade.reported.get("value"),
        "u_reported [kg*m^2]": grade.reported.get("u"),
        "matched": grade.matched,
        "d": _four_digits(grade.d),
        "z": _four_digits(grade.zeta),
        "slips": "; ".join(slip.kind for slip in grade.slips),
        "flags": "; ".join(remarks),
        "look": "; ".join(grade.look),
        "by_hand": "; ".join(map(str, grade.by_hand)),
        "why_not_graded": grade.why,
        "section": grade.section,
    }


def _four_digits(distance: float | None) -> float | None:
    """Round a distance to four digits, which are enough for a table."""
    if distance is None:
        return None
    return float(f"{distance:.4g}")


MOST_NAMED = 50  # students or files in a cell; flags.csv names all students


def flags_csv(flags: Iterable[Flag]) -> str:
    """Write the flags of a class as CSV."""
    rows = []
    for flag in flags:
        students = ", ".join(flag.students)
        earlier = ", ".join(flag.previous)
        numbers = [float(f"{number:.3g}") for number in (flag.expected, flag.p)]
        rows.append((flag.kind, students, earlier, *numbers, flag.evidence))
    head = "kind,students,earlier logs,expected by chance in this class,p,evidence\n"
    return head + csv_lines(map(csv_cell, row) for row in rows)


# --- changes in ``grades.csv`` ---


class CellChange(Struct, frozen=True):
    """One cell of such a row."""

    column: str
    before: str = field(name="from")
    after: str = field(name="to")


class Change(Struct, frozen=True):
    """One student whose row has changed."""

    student: str
    name: str
    before: str | None = field(name="from")
    """Points, "not graded", or null for a student who was not in the table."""
    after: str | None = field(name="to")
    """The same now; null for a student who is no longer in the table."""
    parts: tuple[CellChange, ...]
    """Other cells that have changed."""


def compare_tables(then: bytes, today: bytes) -> tuple[Change, ...] | None:
    """Compare two files of ``grades.csv``.

    Return the changes by student, the largest change of points first; None if the old
    one is not such a table.
    """
    old = read_table(then)
    new = read_table(today)
    if old is None or new is None:
        return None
    changes = []
    for student in sorted(old.keys() | new.keys()):
        change = _change(student, old.get(student), new.get(student))
        if change is not None:
            changes.append(change)
    return tuple(sorted(changes, key=_size, reverse=True))


Row = dict[str, str]
"""The cells of a student by column."""


def _change(student: str, was: Row | None, now: Row | None) -> Change | None:
    """Return what has changed for one student; None for nothing that is shown."""
    before = _total(was)
    after = _total(now)
    name = (now or was or {}).get("name") or student
    if was is None or now is None:
        return Change(student, name, before, after, ())
    parts = tuple(_changed_cells(was, now))
    is_same_person = was["name"] == now["name"]
    if before == after and is_same_person and not parts:
        return None
    return Change(student, name, before, after, parts)


def _changed_cells(was: Row, now: Row) -> Iterator[CellChange]:
    """Give the other cells that look different now."""
    for column in was | now:
        old = was.get(column, "")
        new = now.get(column, "")
        is_other = column not in ("name", TOTAL, STATUS)
        if is_other and not _same(column, old, new):
            yield CellChange(column, old, new)


def _total(row: Row | None) -> str | None:
    if row is None:
        return None
    return row[TOTAL] or row[STATUS] or "not graded"


def _same(column: str, old: str, new: str) -> bool:
    """Return whether two cells look the same: distances are shown with two digits."""
    numbers = [ledger.read_number(cell) for cell in (old, new)]
    if column not in DISTANCES or None in numbers:
        return old == new
    return f"{numbers[0]:.2g}" == f"{numbers[1]:.2g}"


DISTANCES = ("d", "z")


def _size(change: Change) -> float:
    """Return how many points a change is about."""
    before = ledger.read_number(change.before or "") or 0.0
    after = ledger.read_number(change.after or "") or 0.0
    return abs(after - before)


def read_table(data: bytes) -> dict[str, dict[str, str]] | None:
    """Read a table of grades, each student's cells by column.

    Return None if these columns are missing.
    """
    try:
        lines = ledger.read_list(
            data, "grades.csv", "student", STATUS, TOTAL, lower=False
        )
        rows = {row["student"]: row for _, row in lines}
    except (csv.Error, LookupError, ValueError, GyroError):
        return None
    rows.pop(POINTS_ROW, None)
    return rows


# --- JSON ---


class CriterionFigures(Struct, frozen=True):
    """The results of a class in one criterion."""

    id: str
    title: str
    out_of: float
    judged: int  # students whose points are known
    full: int  # students with all points
    none: int  # students with no points
    mean: float | None  # mean points; None if nobody's points are known


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
    """The grade of one student; a line of --format ndjson is such an object.

    The line has "schema": "gyro.grade/1" and "tool" as well.
    """

    flags: tuple[str, ...]
    ids: Mapping[str, str]
    """The student's identifiers on the platform."""


class GradesDocument(Struct, kw_only=True):
    """The document of ``gyro grade --format json``, in SI units."""

    schema: Literal["gyro.grades/1"] = "gyro.grades/1"
    tool: Tool = Tool()
    input: ClassInput
    title: str
    out_of: float
    summary: ClassSummary
    criteria: tuple[CriterionFigures, ...]
    sections: tuple[SectionFigures, ...]
    """Of the sections and graders of a roster."""
    stations: tuple[StationFigures, ...]
    """Of the stations whose logs are of several days."""
    references: Mapping[str, Reference]
    scatters: Mapping[str, BenchScatter]
    absent: tuple[AbsentPerson, ...]
    slips: Mapping[str, list[str]]
    flags: tuple[Flag, ...]
    changes: tuple[Change, ...] | None
    diagnostics: tuple[DiagnosticJson, ...]
    students: tuple[Student, ...] = ()


def grades_document(
    class_grades: ClassGrades, changes: Iterable[Change] | None = None
) -> Iterator[str]:
    """Write the grades of a class as one JSON object, in pieces.

    Each piece contains one student, because a class may be large.

    `changes`: Differences from the table of an earlier run, if they were asked for.
    """
    rubric = class_grades.rubric
    graded = len(class_grades.totals)
    count = len(class_grades.grades)
    submissions = class_grades.submissions
    source = class_grades.source
    summary = ClassSummary(
        graded, count - graded, class_grades.mean, class_grades.median
    )
    absent = [
        AbsentPerson(person.student, person.name, person.section)
        for person in class_grades.roster.absent
    ]
    head = GradesDocument(
        input=ClassInput(source, submissions.lms, count, rubric.name, rubric.digest),
        title=rubric.title,
        out_of=rubric.points,
        summary=summary,
        criteria=tuple(class_grades.criteria()),
        sections=tuple(class_grades.sections),
        stations=class_grades.stations,
        references=dict(sorted(class_grades.references.items())),
        scatters=dict(sorted(class_grades.scatters.items())),
        absent=tuple(absent),
        slips=class_grades.slips,
        flags=class_grades.flags,
        changes=None if changes is None else tuple(changes),
        diagnostics=tuple(note.to_dict() for note in submissions.diagnostics),
    )
    yield json_text(to_json(head)).removesuffix("]\n}\n")
    for number, grade in enumerate(class_grades.grades):
        student = to_json(_student(class_grades, grade))
        comma = "," if number else ""
        yield f"{comma}\n    {encode(student).decode()}"
    yield "\n  ]\n}\n"


def grade_lines(class_grades: ClassGrades) -> Iterator[str]:
    """Write one JSON object for each student, one per line."""
    for grade in class_grades.grades:
        line = {
            "schema": "gyro.grade/1",
            "tool": Tool(),
            **to_json(_student(class_grades, grade)),
        }
        yield encode(line).decode() + "\n"


def _student(class_grades: ClassGrades, grade: Grade) -> Student:
    fields = {name: getattr(grade, name) for name in ShownGrade.__struct_fields__}
    flags = tuple(flag.kind for flag in class_grades.flags_of.get(grade.student, ()))
    return Student(**fields, flags=flags, ids=class_grades.ids[grade.student])
