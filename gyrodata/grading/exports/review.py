"""Collect what the script of ``class.html`` shows and saves: plain data, no HTML."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from msgspec import to_builtins

from gyrodata.base.errors import DiagnosticJson, shown
from gyrodata.grading.forensics import Fingerprint
from gyrodata.grading.grade import Grade, points_text
from gyrodata.grading.ledger import (
    COLUMNS,
    REGRADE,
    SETTLING,
    STALE,
    VERDICTS,
    Offer,
    short,
    words_of,
)
from gyrodata.grading.submissions import Submission
from gyrodata.grading.yardsticks import fit_words
from gyrodata.physics import RPM
from gyrodata.reporting.values import inertia_text

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.rubric import Criterion

MOST_STUDENTS = 5000
"""A page with more is too large for a browser."""

MOST_ROWS, MOST_FILES = 40, 20
"""Of a log; of the files or the partners of a student."""


def address(path: str) -> str:
    """Write the path of a file as a link."""
    return quote(path.encode("utf-8", "replace"))


def script_data(
    class_grades: ClassGrades,
    feedback: Mapping[str, str],
    offers: Sequence[Offer],
    folder: Path | None,
) -> str:
    """Write the data as JSON that no HTML parser takes for the end of a script.

    `feedback`, `offers` and `folder`: As for `class_page`.
    """
    items = {item.student: item for item in class_grades.submissions.items}
    students = []
    for grade in class_grades.grades[:MOST_STUDENTS]:
        student = _student(class_grades, grade, items[grade.student], folder)
        student["feedback"] = address(feedback.get(grade.student, ""))
        students.append(student)
    lines = class_grades.desk.written
    extra = {column for line in lines for column in line.cells}
    rubric = class_grades.rubric
    words = words_of(rubric).values()
    document = {
        "words": [to_builtins(word) | {"how": word.how} for word in words],
        "verdicts": VERDICTS,
        "criteria": [_criterion(criterion) for criterion in rubric.criteria],
        "students": students,
        "offers": [_offer(class_grades, offer) for offer in offers],
        "columns": [*COLUMNS, *sorted(extra - set(COLUMNS))],
        "desk": to_builtins(lines),
    }
    return json.dumps(document, separators=(",", ":")).replace("<", "\\u003c")


@lru_cache(4096)
def _plain(text: str) -> str:
    """Return a harmless line, which is cut if it is very long."""
    return short(shown(text))


def _criterion(criterion: Criterion) -> Mapping[str, str]:
    """Return a criterion for which a person can give points."""
    title = _plain(criterion.title)
    return {"what": criterion.id, "title": title, "of": points_text(criterion.points)}


def _offer(class_grades: ClassGrades, offer: Offer) -> Mapping[str, Any]:
    """Return an open question, with the logs to be compared if it is about a flag."""
    flag = offer.flag
    previous = flag.previous if flag else ()
    return {
        "people": offer.people,
        "what": offer.what,
        "value": offer.value,
        # A request stays as it is, because its answer is found by it.
        "why": offer.why if offer.what == REGRADE else _plain(offer.why),
        # A line without a value also confirms the result for a new submission.
        "leave": offer.can_be_left or offer.why.startswith(STALE),
        "settled_by": _settled_by(offer),
        "earlier": [_plain(class_grades.label(key)) for key in previous],
    }


def _settled_by(offer: Offer) -> Sequence[str]:
    """Return the words that settle a question; none if every decision does."""
    if offer.flag or offer.what == REGRADE:
        return [offer.what]
    is_of_one = offer.can_be_left or offer.gives_points
    return [offer.what, *SETTLING] if is_of_one else []


def _student(
    class_grades: ClassGrades, grade: Grade, item: Submission, folder: Path | None
) -> dict[str, Any]:
    """Return what a person looks at to decide about one student."""
    student = grade.student
    log = class_grades.prints.get(student)
    group = []
    for some in class_grades.groups:
        if student in some:
            partners = [key for key in some[:MOST_FILES] if key != student]
            group += [_plain(class_grades.label(key)) for key in partners]
    marks = [[points_text(mark.points), _plain(mark.reason)] for mark in grade.marks]
    return {
        "id": student,
        "name": _plain(class_grades.label(student)),
        "about": list(_about(grade)),
        "group": group,
        "files": file_links(item, item.members[:MOST_FILES], folder),
        "marks": marks,
        "answer": _answer(grade, folder is not None),
        "own": _own_runs(grade),
        "notes": [_note(diagnostic) for diagnostic in grade.diagnostics[:MOST_ROWS]],
        "rows": [] if log is None else _rows(log),
    }


def _about(grade: Grade) -> Iterator[str]:
    """Say in short lines what a grade is and why."""
    points = points_text(grade.points)
    total = f"{points} of {points_text(grade.out_of)} points"
    yield total if grade.status == "graded" else f"{grade.status}, {total}"
    if grade.section:
        yield f"section {_plain(grade.section)}"
    if grade.station:
        yield f"station {_plain(grade.station)}"
    if grade.log_of:
        yield f"graded on the log of {shown(grade.log_of)}"
    if grade.late_reason:
        yield _plain(grade.late_reason)
    for slip in grade.slips:
        yield _plain(slip.words)


def _own_runs(grade: Grade) -> str:
    """Return what the own runs give by the fit that is nearest to the answer."""
    for name in (grade.matched or "", *grade.own):
        if name in grade.own:
            fit = grade.own[name]
            value = inertia_text(fit["value"], fit["u"])
            return f"{value} by {fit_words(name)}"
    return ""


def _answer(grade: Grade, with_file: bool) -> list[str]:
    """Return the answer, and its place with its factor to the own runs."""
    text = grade.reported.get("text")
    if not text:
        return []
    file = grade.reported.get("file")
    line = grade.reported.get("line")
    place = []
    if file and with_file:
        place.append(shown(file))
    if line:
        place.append(f"line {line}")
    parts = [short(", ".join(place))] if place else []
    if grade.ratio:
        parts.append(f"{grade.ratio:.4g} times the own runs")
    return [_plain(text), "; ".join(parts)]


def file_links(
    item: Submission, names: Iterable[str], folder: Path | None
) -> list[tuple[str, str]]:
    """Return the name and the address of each file.

    A file in a zip has no address. Without a folder, files get numbers instead of
    names, in which there may be the name of a student.
    """
    if folder is None:
        numbers = [item.members.index(name) + 1 for name in names]
        return [(f"file {number}", "") for number in numbers]
    base = ""
    if item.source.is_dir():
        base = Path(os.path.relpath(item.source, folder)).as_posix() + "/"
    links = []
    for name in names:
        own_name = name.rpartition("/")[2]
        link = address(base + name) if base else ""
        links.append((_plain(own_name), link))
    return links


def _note(diagnostic: DiagnosticJson) -> str:
    """Write what was found in a log."""
    message = _plain(diagnostic["message"])
    line = diagnostic["line"]
    return f"line {line}: {message}" if line else message


def _rows(log: Fingerprint) -> list[list[str]]:
    """Return the line, torque, spin, time and turns of each run, as texts.

    The torque is in mN·m, the spin in rpm, and the time in s.
    """
    rows = zip(log.lines, log.torque, log.spin, log.time, log.turns, strict=True)
    texts = []
    for line, torque, spin, time, turns in islice(rows, MOST_ROWS):
        in_mnm = f"{1e3 * torque:.4g}"
        in_rpm = f"{spin / RPM:.5g}"
        in_s = f"{time:.5g}"
        texts.append([str(line), in_mnm, in_rpm, in_s, _fraction(turns)])
    return texts


@lru_cache(64)
def _fraction(turns: float) -> str:
    """Write a number of turns as a log does."""
    return str(Fraction(turns).limit_denominator(99))
