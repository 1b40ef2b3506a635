"""The grades of a class as a table for a terminal."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from gyrodata.grading.feedback import points_text
from gyrodata.grading.submissions import shown
from gyrodata.reporting import count_text

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.grade import Grade

WIDEST = 28
"""Characters of a name that are shown."""


def class_summary(found: ClassGrades) -> Iterator[str]:
    """Write a class for people: a line on the whole, a row for each student, then the flags."""
    graded, out_of = len(found.totals), points_text(found.rubric.points)
    count = count_text(len(found.grades), "submission")
    first = f"{found.source}: {count}, {graded} graded, {len(found.grades) - graded} not"
    if found.mean is not None and found.median is not None:
        first += f"; mean {found.mean:.2f} and median {found.median:.2f} of {out_of} points"
    yield f"{first}\n\n"
    yield from _rows(found)
    if found.flags:
        yield "\nflags, which are no verdicts:\n"
    for flag in found.flags:
        who = ", ".join(found.label(student) for student in (*flag.students, *flag.previous))
        told = shown(f"{flag.kind}: {who}: {flag.evidence}; chance makes {flag.expected:.2g} in such a class")
        yield f"  {told}\n"


def _rows(found: ClassGrades) -> Iterator[str]:
    """Put the students under each other, numbers to the right."""
    head = ("student", "points", "I_zz / own", "what to know")
    widths = (
        _widest(head[0], map(_cut, found.names.values())),
        _widest(head[1], (points_text(grade.points) for grade in found.grades)),
        _widest(head[2], map(_ratio_text, found.grades)),
    )
    yield _row(head, widths)
    for grade in found.grades:
        yield _row((_cut(grade.name), points_text(grade.points), _ratio_text(grade), _remark(found, grade)), widths)


def _widest(head: str, texts: Iterable[str]) -> int:
    return max(_width(head), max(map(_width, texts), default=0))


def _row(cells: tuple[str, str, str, str], widths: tuple[int, int, int]) -> str:
    name, points, ratio, remark = cells
    blanks = " " * (widths[0] - _width(name))
    return f"  {name}{blanks}  {points:>{widths[1]}}  {ratio:>{widths[2]}}  {remark}".rstrip() + "\n"


def _ratio_text(grade: Grade) -> str:
    """The reported I_zz over that of the student's own runs."""
    return "–" if grade.ratio is None else f"{grade.ratio:.4g}"


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


def _width(text: str) -> int:
    """Columns of a terminal: two for a wide character, none for a mark that stands on another."""
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return len(text) + wide - sum(unicodedata.combining(character) > 0 for character in text)
