"""The grades of a class as a table for a terminal."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from typing import TYPE_CHECKING

from gyrodata.grading.feedback import points_text
from gyrodata.grading.patterns import shown
from gyrodata.reporting import count_text

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.grade import Grade

WIDEST = 28
"""Characters of a name that are shown."""


def class_summary(found: ClassGrades) -> str:
    """Write a class for people: a line on the whole, a row for each student, then the flags.

    Parameters
    ----------
    found : ClassGrades
        The class.

    Returns
    -------
    str
    """
    graded, out_of = len(found.totals), points_text(found.rubric.points)
    count = count_text(len(found.grades), "submission")
    first = f"{found.source}: {count}, {graded} graded, {len(found.grades) - graded} not"
    if found.mean is not None and found.median is not None:
        first += f"; mean {found.mean:.2f} and median {found.median:.2f} of {out_of} points"
    lines = [first, ""]
    rows = [("student", "points", "I_zz / own", "what to know")]
    rows += [
        (_cut(grade.name), points_text(grade.points), _ratio(grade), _remark(found, grade)) for grade in found.grades
    ]
    lines += _aligned(rows)
    if found.flags:
        lines += ["", "flags, which are no verdicts:"]
    for flag in found.flags:
        who = ", ".join(found.label(student) for student in (*flag.students, *flag.previous))
        lines.append(
            "  " + shown(f"{flag.kind}: {who}: {flag.evidence}; chance makes {flag.expected:.2g} in such a class")
        )
    return "\n".join(lines) + "\n"


def _ratio(grade: Grade) -> str:
    """The reported I_zz over that of the student's own runs."""
    value = grade.reported.get("value")
    own = (grade.own.get(grade.matched or "") or {}).get("value")
    return f"{value / own:.4g}" if isinstance(value, float) and own else "–"


def _remark(found: ClassGrades, grade: Grade) -> str:
    """What whoever grades wants to know, in one line."""
    parts = [] if grade.why is None else [f"not graded: {grade.why}"]
    if grade.slips:
        parts.append(" or ".join(slip.words for slip in grade.slips))
    parts += grade.look
    if grade.late_reason and grade.late_reason not in grade.look:
        taken = f" (−{points_text(grade.late_deduction)})" if grade.late_deduction else ""
        parts.append(f"{grade.late_reason}{taken}")
    parts += [f"flag: {flag.kind}" for flag in found.flags_of.get(grade.student, ())]
    return shown("; ".join(parts))


def _cut(text: str) -> str:
    return text if len(text) <= WIDEST else text[: WIDEST - 1] + "…"


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Put rows under each other, numbers to the right."""
    widths = [max(_width(row[column]) for row in rows) for column in range(3)]
    lines = []
    for name, points, ratio, remark in rows:
        first = name + " " * (widths[0] - _width(name))
        lines.append(f"  {first}  {points:>{widths[1]}}  {ratio:>{widths[2]}}  {remark}".rstrip())
    return lines


def _width(text: str) -> int:
    """Columns of a terminal: two for a wide character, none for a mark that stands on another."""
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return len(text) + wide - sum(unicodedata.combining(character) > 0 for character in text)
