"""The grades of a class as CSV and as a table for a terminal, and what changes in them.

Beside it: JSON (`class_json`), sheets of platforms (`gradebooks`), Gradescope's autograder (`gradescope`), the page of
the class (`class_page`).
"""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING

from msgspec import Struct, field

from gyrodata.errors import shown
from gyrodata.grading.grade import Grade, points_text, two_decimals
from gyrodata.grading.ledger import csv_table
from gyrodata.reporting.data import csv_cell, csv_lines
from gyrodata.reporting.values import count_text, in_columns

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.forensics import Flag
    from gyrodata.grading.roster import Person

# --- CSV: ``grades.csv``, a row for each student below one of what can be had, and ``flags.csv`` -----------------


POINTS_ROW = "points possible"  # what stands for a student in the first row


def grades_csv(grades: Collection[Grade], flags: Sequence[Flag] = (), absent: Sequence[Person] = ()) -> str:
    """Write the grades of a class; `absent`: Those who handed in nothing.

    Gives: CSV (RFC 4180 with plain line feeds). Points have two decimals; a cell is blank where nothing was judged. A
    text that a spreadsheet would run as a formula has a ' in front.
    """
    flagged: dict[str, list[str]] = {}
    for flag in flags:
        for student in flag.students:
            others = [other for other in (*flag.students, *flag.previous) if other != student]
            flagged.setdefault(student, []).append(f"{flag.kind} with {', '.join(others)}" if others else flag.kind)
    first = next(iter(grades), None)
    columns = ["student"] if first is None else [column for column, _ in _row(first, ())]
    head = [[csv_cell(column) for column in columns]]
    if first is not None:
        possible = {"student": POINTS_ROW, "status": "--", TOTAL: two_decimals(first.out_of)}
        possible |= {mark.criterion: two_decimals(mark.out_of) for mark in first.marks}
        head.append([possible.get(column, "") for column in columns])

    def cells(one: Grade | Person) -> list[str]:
        if isinstance(one, Grade):
            return [cell for _, cell in _row(one, flagged.get(one.student, ()))]
        told = {"student": one.student, "name": one.name, "status": NOTHING, "section": one.section}
        return [csv_cell(told.get(column)) for column in columns]

    people: dict[str, Grade | Person] = {one.student: one for one in absent}
    people |= {grade.student: grade for grade in grades}
    # A large class is kept as text, not cell by cell.
    return csv_lines(chain(head, (cells(people[student]) for student in sorted(people))))


def _row(grade: Grade, flags: Sequence[str]) -> list[tuple[str, str]]:
    """Give each column and cell of one student."""
    texts: list[tuple[str, object]] = [
        ("late [s]", grade.late_seconds),
        ("late", grade.late_reason),
        ("reported [kg*m^2]", grade.reported.get("value")),
        ("u_reported [kg*m^2]", grade.reported.get("u")),
        ("matched", grade.matched),
        ("d", None if grade.d is None else float(f"{grade.d:.4g}")),
        ("z", None if grade.zeta is None else float(f"{grade.zeta:.4g}")),
        ("slips", "; ".join(slip.kind for slip in grade.slips)),
        ("flags", "; ".join(flags)),
        ("look", "; ".join(grade.look)),
        ("by_hand", "; ".join(map(str, grade.by_hand))),
        ("why_not_graded", grade.why),
        ("section", grade.section),
    ]
    return [
        ("student", csv_cell(grade.student)),
        ("name", csv_cell(grade.name)),
        ("status", grade.status),
        (TOTAL, two_decimals(grade.points)),
        *((mark.criterion, two_decimals(mark.points)) for mark in grade.marks),
        ("late_deduction", two_decimals(None if grade.points is None else grade.late_deduction)),
        *((column, csv_cell(text)) for column, text in texts),
    ]


def flags_csv(flags: Iterable[Flag]) -> str:
    """Write the flags of a class as CSV; a text that a spreadsheet would run as a formula has a ' in front."""
    head = ("kind", "students", "earlier logs", "expected by chance in this class", "p", "evidence")
    rows: list[tuple[object, ...]] = [head]
    for flag in flags:
        numbers = (float(f"{flag.expected:.3g}"), float(f"{flag.p:.3g}"))
        rows.append((flag.kind, ", ".join(flag.students), ", ".join(flag.previous), *numbers, flag.evidence))
    return csv_lines(map(csv_cell, row) for row in rows)


# --- changes in ``grades.csv``: who, from what, to what --------------------------------------------------


TOTAL, STATUS = "total", "status"
NOT_GRADED, NOTHING = "not graded", "nothing handed in"


class CellChange(Struct, frozen=True):
    """One cell of such a row."""

    column: str
    before: str = field(name="from")
    after: str = field(name="to")


class Change(Struct, frozen=True):
    """One student whose row is not what it was."""

    student: str
    name: str
    before: str | None = field(name="from")
    """Points, "not graded", or null for one who was not in the table."""
    after: str | None = field(name="to")
    """The same now; null for one who no longer is."""
    parts: tuple[CellChange, ...]
    """Other cells that change."""

    def __str__(self) -> str:
        who = self.name if self.student in self.name else f"{self.name} ({self.student})"
        told = f"{who}: {self.before or 'not in it'} → {self.after or 'no longer in it'}"
        if self.before == self.after:
            told = f"{who}: {self.after}"
        parts = ", ".join(f"{one.column} {one.before or '–'} → {one.after or '–'}" for one in self.parts)
        return f"{told} ({parts})" if parts else told


def compare_tables(then: str, today: str) -> tuple[Change, ...] | None:
    """Compare two tables of grades.

    `then`, `today`: ``grades.csv`` as it is, and as it would be. Gives: Sorted by student; empty where every cell is
    the same; None where the old one is no table of grades.
    """
    old, new = read_table(then), read_table(today)
    if old is None or new is None:
        return None
    changes = []
    for student in sorted(old.keys() | new.keys()):
        was, now = old.get(student, {}), new.get(student, {})
        if was == now:
            continue
        columns = [column for column in {**was, **now} if column not in ("name", TOTAL, STATUS) and was and now]
        cells = (CellChange(column, was.get(column, ""), now.get(column, "")) for column in columns)
        parts = tuple(cell for cell in cells if cell.before != cell.after)
        name = (now or was).get("name") or student
        before, after = (row[TOTAL] or row[STATUS] or NOT_GRADED if row else None for row in (was, now))
        changes.append(Change(student, name, before, after, parts))
    return tuple(changes)


def read_table(table: str) -> dict[str, dict[str, str]] | None:
    """Read a table of grades, each student's cells by column; None where there are no such columns."""
    try:
        rows = {row["student"]: row for _, row in csv_table(table, "student", STATUS, TOTAL)}
    except (csv.Error, LookupError):
        return None
    rows.pop(POINTS_ROW, None)
    return rows


# --- a table for a terminal --------------------------------------------------------------------------------


WIDEST = 28  # characters of a name that are shown


def class_summary(found: ClassGrades) -> Iterator[str]:
    """Write a class for people: a line on the whole, a row for each student, then the flags."""
    out_of = points_text(found.rubric.points)
    first = f"{shown(found.source)}: {count_text(len(found.grades), 'submission')}, {found.tally}"
    if found.mean is not None and found.median is not None:
        first += f"; mean {found.mean:.2f} and median {found.median:.2f} of {out_of} points"
    yield f"{first}\n\n"
    yield from _table_rows(found)
    if found.bench:
        yield f"\n{found.bench}\n"
    if found.flags:
        yield "\nflags (questions, not verdicts):\n"
    for flag in found.flags:
        who = ", ".join(found.label(student) for student in (*flag.students, *flag.previous))
        told = shown(f"{flag.kind}: {who}: {flag.evidence}; expected by chance in such a class: {flag.expected:.2g}")
        yield f"  {told}\n"


def _table_rows(found: ClassGrades) -> Iterator[str]:
    """Put the students under each other, numbers to the right."""
    rows = [("student", "points", "I_zz / own", "what to know")]
    for grade in found.grades:
        ratio = "–" if grade.ratio is None else f"{grade.ratio:.4g}"
        name = shown(grade.name)
        name = name if len(name) <= WIDEST else name[: WIDEST - 1] + "…"
        rows.append((name, points_text(grade.points), ratio, _remark(found, grade)))
    yield from (f"  {line}\n" for line in in_columns(rows, right=(1, 2)))


def _remark(found: ClassGrades, grade: Grade) -> str:
    """Return the most important fact for the grader, in one line."""
    parts = [] if grade.why is None else [f"not graded: {grade.why}"]
    if grade.why is None and grade.status != "graded":
        parts.append(grade.status)
    if grade.slips:
        parts.append(" or ".join(slip.words for slip in grade.slips))
    parts += grade.look
    parts += [f"by hand: {one}" for one in grade.by_hand]
    if grade.late_reason and grade.late_reason not in grade.look:
        taken = f" (−{points_text(grade.late_deduction)})" if grade.late_deduction else ""
        parts.append(f"{grade.late_reason}{taken}")
    parts += [f"flag: {flag.kind}" for flag in found.flags_of.get(grade.student, ())]
    return shown("; ".join(parts))
