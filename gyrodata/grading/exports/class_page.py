"""``class.html``: a class at a glance, in one file that needs nothing else."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from gyrodata import __version__
from gyrodata.grading.exports.distribution import LEFT, RIGHT, WIDTH, draw_distribution
from gyrodata.grading.feedback import environment, points_text
from gyrodata.reporting import count_text, number_text, power_of_ten

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades
    from gyrodata.grading.grade import Grade


def class_page(found: ClassGrades, feedback: Callable[[str], str]) -> Iterator[str]:
    """Write the page of a class.

    `feedback`: Gives a student's page, as a path below the folder of the class page.

    Every name, note and number from outside is escaped; no clock time, nothing from another place.
    """
    inertias = [grade.inertia for grade in found.grades if grade.inertia is not None]
    words = {slip.kind: slip.words for grade in found.grades for slip in grade.slips}
    factor, power = power_of_ten(statistics.median(inertias)) if inertias else (1.0, "")
    in_question = found.in_question()
    content = {
        "found": found,
        "version": __version__,
        "link": lambda student: quote(feedback(student).encode("utf-8", "replace")),
        "in_question": in_question,
        "marked": frozenset(in_question),
        "slips": [(words[kind], students) for kind, students in found.slips.items()],
        "criteria": list(found.criteria()),
        "drawing": draw_distribution(found.grades, found.references),
        "box": {"width": WIDTH, "left": LEFT, "right": WIDTH - RIGHT},
        "points": points_text,
        "count": count_text,
        "unit": f"{power} kg·m²" if power else "kg·m²",
        "cells": lambda grade: _cells(grade, factor),
    }
    yield from environment().get_template("class.html.jinja").generate(content)


def _cells(grade: Grade, factor: float) -> list[dict[str, Any]]:
    """The numbers of a student's row: what to sort by, and what is shown."""
    marks = [(mark.points, points_text(mark.points)) for mark in grade.marks]
    value, u = grade.reported.get("value"), grade.reported.get("u")
    reported = number_text(value, u if isinstance(u, float) else None, factor) if isinstance(value, float) else "–"
    numbers: list[tuple[object, str]] = [
        (grade.points, points_text(grade.points)),
        *marks,
        (value, reported),
        (grade.d, _distance(grade.d)),
        (grade.z, _distance(grade.z)),
    ]
    return [{"value": "" if key is None else repr(key), "text": text.replace("-", "−")} for key, text in numbers]


def _distance(value: float | None) -> str:
    """Two digits, and all those before the point up to a million."""
    return "–" if value is None else f"{value:.0f}" if 100 <= value < 1e6 else f"{value:.2g}"
