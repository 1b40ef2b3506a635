"""``grades.csv``, a row for each student below one of what can be had; and ``flags.csv``, a row for each flag."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

from gyrodata.reporting import csv_cell

if TYPE_CHECKING:
    from gyrodata.grading.forensics import Flag
    from gyrodata.grading.grade import Grade


POINTS_ROW = "points possible"
"""What stands for a student in the first row."""

_BEFORE = ("student", "name", "status", "total")
_AFTER = (
    "late_deduction",
    "late [s]",
    "late",
    "reported [kg*m^2]",
    "u_reported [kg*m^2]",
    "matched",
    "d",
    "z",
    "slips",
    "flags",
    "look",
    "why_not_graded",
)


def grades_csv(grades: Collection[Grade], flags: Sequence[Flag] = ()) -> str:
    """Write the grades of a class.

    Gives: CSV (RFC 4180 with plain line feeds). Points have two decimals; a cell is blank where nothing was judged. A
    text that a spreadsheet would run as a formula has a ' in front.
    """
    first = next(iter(grades), None)
    criteria = {} if first is None else {mark.criterion: mark.out_of for mark in first.marks}
    flagged: dict[str, list[str]] = {}
    for flag in flags:
        for student in flag.students:
            others = [other for other in (*flag.students, *flag.previous) if other != student]
            flagged.setdefault(student, []).append(f"{flag.kind} with {', '.join(others)}" if others else flag.kind)
    lines = [_line([csv_cell(header) for header in (*_BEFORE, *criteria, *_AFTER)])]
    if first is not None:
        possible = [two_decimals(points) for points in criteria.values()]
        blank = [""] * len(_AFTER)
        lines.append(_line([POINTS_ROW, "", "--", two_decimals(first.out_of), *possible, *blank]))
    columns = list(criteria)
    rows = ((grade.student, _line(_row(grade, columns, flagged.get(grade.student, [])))) for grade in grades)
    lines += [line for _, line in sorted(rows)]
    return "".join(lines)


def two_decimals(points: float | None) -> str:
    """Write points with two decimals, as gradebooks compare them, and never with a mark between thousands."""
    return "" if points is None else f"{points:.2f}"


def _line(cells: Sequence[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()


def _row(grade: Grade, criteria: Sequence[str], flags: Sequence[str]) -> list[str]:
    marks = {mark.criterion: mark.points for mark in grade.marks}
    cells: list[object] = [grade.student, grade.name, grade.status]
    after: list[object] = [
        grade.late_seconds,
        grade.late_reason,
        grade.reported.get("value"),
        grade.reported.get("u"),
        grade.matched,
        None if grade.d is None else float(f"{grade.d:.4g}"),
        None if grade.zeta is None else float(f"{grade.zeta:.4g}"),
        "; ".join(slip.kind for slip in grade.slips),
        "; ".join(flags),
        "; ".join(grade.look),
        grade.why,
    ]
    points = [grade.points, *(marks.get(criterion) for criterion in criteria)]
    deducted = two_decimals(grade.late_deduction if grade.status == "graded" else None)
    return [*map(csv_cell, cells), *map(two_decimals, points), deducted, *map(csv_cell, after)]


def flags_csv(flags: Iterable[Flag]) -> str:
    """Write the flags of a class.

    Gives: CSV; a text that a spreadsheet would run as a formula has a ' in front.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["kind", "students", "earlier logs", "expected by chance in this class", "p", "evidence"])
    for flag in flags:
        numbers = (float(f"{flag.expected:.3g}"), float(f"{flag.p:.3g}"))
        cells = (flag.kind, ", ".join(flag.students), ", ".join(flag.previous), *numbers, flag.evidence)
        writer.writerow([csv_cell(cell) for cell in cells])
    return out.getvalue()
