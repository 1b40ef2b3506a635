"""Feedback for a student: points, findings, and how to check a mistake."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from typing import Any

from msgspec.structs import replace

from gyrodata.errors import shown
from gyrodata.grading.grade import Grade, points_text
from gyrodata.grading.templates import environment, sentence
from gyrodata.plotting import FIGURES

_PAGE, _TEXT = (environment().get_template(f"feedback.{kind}.jinja") for kind in ("html", "md"))


def feedback_markdown(grade: Grade) -> str:
    """Write the feedback for one student as Markdown.

    Gives: Every name, note and number from outside is escaped; no clock time.
    """
    text = _TEXT.render(_content(grade))
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def feedback_html(grade: Grade, figures: Mapping[str, tuple[bytes, str]] | None = None) -> str:
    """Write the feedback for one student as one HTML page that needs nothing else.

    `figures`: PNG file, and what it shows in words, by name: "period", "product", "torque", "residuals". Gives: Every
    name, note and number from outside is escaped; no clock time.
    """
    images = [
        {"png": base64.b64encode(data).decode(), "alt": words, "caption": FIGURES[name].caption}
        for name, (data, words) in (figures or {}).items()
    ]
    return _PAGE.render(_content(grade), images=images)


def feedback_comment(grade: Grade) -> str:
    """Write the feedback for one student in a few lines of plain text, for the comment field of a gradebook."""
    if grade.points is None:
        return "\n".join([f"{_verdict(grade)} {sentence(grade.why or '')}".strip(), *_hands(grade)])
    lines = [_verdict(grade), *_hands(grade)]
    lines += [f"A mistake to look for: {sentence(slip.words)} To check: {sentence(slip.check)}" for slip in grade.slips]
    lines += [
        f"{shown(one.title)}: {points_text(one.points)} of {points_text(one.out_of)}. {sentence(one.reason)}"
        for one in grade.marks
        if one.points is not None and one.points < one.out_of
    ]
    if grade.late_reason:
        taken = f" {points_text(grade.late_deduction)} points were taken off for it." if grade.late_deduction else ""
        lines.append(f"{sentence(grade.late_reason)}{taken}")
    return "\n".join(lines)


def _verdict(grade: Grade) -> str:
    """Say in one line what a grade came to."""
    got = f"{points_text(grade.points)} of {points_text(grade.out_of)} points"
    if grade.status == "so far":
        waits = ", ".join(f"{shown(one.title)} ({points_text(one.out_of)})" for one in grade.marks if one.waits)
        return f"{got} so far; to come: {waits}."
    if grade.status == "not graded":
        return "Not graded yet. You have not lost points; an instructor will review it."
    return {"graded": f"{got}.", "on hold": "Your grade is on hold.", "excused": "You are excused."}[grade.status]


def _hands(grade: Grade) -> list[str]:
    """Say what a person decided, but for the criteria, whose rows say it, and what is between other people."""
    told = []
    for one in grade.by_hand:
        if one.what == "comment":
            told.append(f"{sentence(one.value)} {f'({shown(one.by)})' if one.by else ''}".strip())
        elif one.what in ("total", "reported", "station", "excuse"):
            head = f"{one.what.replace('reported', 'I_zz')} given by hand: {one.value}"
            told.append(sentence(f"{head} – {one.told}" if one.value and one.told else f"{head}{one.told}"))
    return told


def _content(grade: Grade) -> dict[str, Any]:
    """Return the functions that write numbers in the templates."""
    if grade.status in ("on hold", "excused"):
        # No points are given, and none are shown.
        grade = replace(grade, marks=(), slips=(), own={}, diagnostics=(), late_reason="")
    costs = [one.detail["slip_cost"] for one in grade.marks if grade.slips and "slip_cost" in one.detail]
    return {
        "grade": grade,
        "told": [one for one in grade.diagnostics if one["severity"] != "note"],
        "slip_cost": costs[0] if costs else None,
        "lead": _lead(grade),
        "verdict": _verdict(grade),
        "hands": _hands(grade),
        "judged": any(one.points is not None for one in grade.marks),
    }


def _lead(grade: Grade) -> str:
    """Return one friendly line that is true of these marks."""
    short = [one for one in grade.marks if one.points is not None and one.points < one.out_of]
    if any(one.what == "total" for one in grade.by_hand):
        return "A person has set the total."
    if not short:
        return "Full marks: log, value and uncertainty are all consistent. Well done."
    if grade.slips:
        return "There is one mistake between your runs and your answer: see below."
    if len(short) == 1:
        one = short[0]
        points = f"{points_text(one.points)} of {points_text(one.out_of)}"
        return f'Only one criterion lost points: "{shown(one.title)}" ({points}).'
    return "The table shows the findings and the points."
