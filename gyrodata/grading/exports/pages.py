"""Write the pages: the feedback for a student, and ``class.html``.

``class.html`` shows everything that needs a decision, and the class in numbers.

HTML is escaped, and each text from outside becomes one harmless line.
"""

from __future__ import annotations

import base64
import hashlib
import math
import re
import statistics
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup
from msgspec.structs import replace

from gyrodata.base.errors import shown
from gyrodata.base.version import __version__
from gyrodata.grading.criteria import Mark
from gyrodata.grading.exports.review import (
    MOST_STUDENTS,
    address,
    file_links,
    script_data,
)
from gyrodata.grading.grade import Grade, points_text
from gyrodata.grading.ledger import Offer, short
from gyrodata.grading.yardsticks import fit_words, in_order
from gyrodata.readings import listing
from gyrodata.reporting.data import csv_lines, templates, with_few_blank_lines
from gyrodata.reporting.values import (
    count_text,
    factor_text,
    in_columns,
    inertia_text,
    number_text,
    power_of_ten,
)

if TYPE_CHECKING:
    from jinja2 import Environment

    from gyrodata.grading.classroom import ClassGrades


@lru_cache(maxsize=1)
def environment() -> Environment:
    """Return the environment of all templates, with its filters."""
    made = templates(Path(__file__).parents[1])
    made.globals["version"] = __version__
    # Titles, rules and reasons are the same for many students, and numbers in the two
    # pages of one student.
    filters: dict[str, Callable[..., Any]] = {
        "address": address,
        "columns": _columns,
        "count": count_text,
        "distance": _distance_text,
        "factor": factor_text,
        "fit_words": fit_words,
        "inertia": inertia_text,
        "md": _markdown_safe,
        "number": number_text,
        "plain": shown,
        "points": points_text,
        "sentence": sentence,
    }
    made.filters |= {name: lru_cache(512)(text) for name, text in filters.items()}
    made.filters["listing"] = listing
    return made


def _distance_text(z: float | None) -> str:
    """Write a distance in u, with all digits before the point up to a million."""
    if z is None:
        return "–"
    if 100 <= z < 1e6:
        return f"{z:.0f}"
    return f"{z:.2g}".replace("-", "−")


def sentence(text: object) -> str:
    """Return one line with a capital and a full stop: "no log: only a.pdf" begins "No".

    A symbol stays as it is: "g is missing." has no capital.
    """
    line = shown(text).rstrip(".")
    # "g is missing" and "φ̇ψ̇ scatters" begin with a symbol.
    start = line[:2]
    if len(start) == 2 and start.isascii() and start.isalpha() and start.islower():
        line = line[:1].upper() + line[1:]
    if not line or line.endswith(("?", "!")):
        return line
    return f"{line}."


def _columns(text: str) -> str:
    """Set the cells of lines with tabs under each other.

    The second and the third column are numbers.
    """
    rows = [line.split("\t") for line in text.strip("\n").split("\n")]
    lines = in_columns(rows, right=(1, 2))
    return "".join(f"  {line}\n" for line in lines)


def _markdown_safe(text: object) -> str:
    """Return one line that Markdown takes literally."""
    line = re.sub(r"([\\`*_\[\]|~$])", r"\\\1", shown(text))
    return (
        line.replace("&", "&amp;")
        .replace("<", "&lt;")
        .replace(">", "&gt;")
        .replace("://", ":\\//")
    )


# --- the feedback for a student ---


def feedback_pages(grade: Grade) -> dict[str, str]:
    """Write the feedback for one student as one HTML page, and as Markdown.

    The HTML page needs no other file. The key of each text is the ending of its file.
    Every name, note and number from outside is escaped; there is no clock time.
    """
    content = _content(grade)
    template = environment().get_template
    page = template("feedback.html.jinja").render(content)
    text = template("feedback.md.jinja").render(content)
    return {".html": page, ".md": with_few_blank_lines(text)}


def feedback_comment(grade: Grade) -> str:
    """Write the feedback for one student in a few lines of plain text.

    The text is for the comment field of a gradebook.
    """
    template = environment().get_template("feedback.txt.jinja")
    return template.render(_content(grade)).strip()


_SENTENCES = ("verdict", "why", "hands", "late", "explains", "bench", "closest")
"""Macros of words.jinja about a grade alone."""


def _content(grade: Grade) -> dict[str, Any]:
    """Return what the templates of the feedback need."""
    if grade.status in ("on hold", "excused"):
        # No points are given, and none are shown.
        grade = replace(
            grade, marks=(), slips=(), own={}, diagnostics=(), late_reason=""
        )
    short = [mark for mark in grade.marks if _is_short(mark)]
    costs = (mark.detail.get("slip_cost") for mark in grade.marks)
    cost = next((cost for cost in costs if cost is not None), None)
    # Called from here, the macros escape nothing; each page escapes their texts.
    macros: Any = environment().get_template("words.jinja").module
    words = {name: getattr(macros, name)(grade).strip() for name in _SENTENCES}
    words["lead"] = macros.lead(grade, short).strip()
    return {"grade": grade, "short": short, "slip_cost": cost, "words": words}


def _is_short(mark: Mark) -> bool:
    """Return whether a mark has less than all points."""
    return mark.points is not None and mark.points < mark.out_of


# --- a class as a page ---


def class_page(
    class_grades: ClassGrades,
    feedback: Mapping[str, str],
    offers: Sequence[Offer],
    folder: Path | None,
) -> str:
    """Write the page of a class.

    `feedback`: The path of each student's page below the folder of the class page.
    `offers`: What needs a decision, grouped by reason. `folder`: The folder of the
    class page, for links to files to look into; None to show no names of files. All
    text from outside is escaped; the page contains no clock time. Its policy allows its
    own style and script only.
    """
    inertias = [
        grade.inertia for grade in class_grades.grades if grade.inertia is not None
    ]
    factor = 1.0
    power = ""
    if inertias:
        factor, power = power_of_ten(statistics.median(inertias))
    items = {item.student: item for item in class_grades.submissions.items}

    def links(student: str) -> list[tuple[str, str]]:
        """Return the name and the address of each file."""
        return file_links(items[student], items[student].files_to_read, folder)

    # Texts of students may be very long; a line for the desk is copied as it is.
    page = environment().overlay()
    page.filters = {
        **page.filters,
        "plain": lambda text: short(shown(text)),
        "sentence": lambda text: short(sentence(text)),
        "whole": shown,
    }
    return page.get_template("class.html.jinja").render(
        class_grades=class_grades,
        feedback=feedback,
        links=links,
        offers=offers,
        factor=factor,
        style=_part("class.css"),
        script=_part("class.js"),
        digest=_digest,
        most={"rows": MOST_STUDENTS, "named": 500},
        data=Markup(script_data(class_grades, feedback, offers, folder)),
        number_of=_numbered(offers),
        place_of=_numbered(class_grades.names),
        desk_line=lambda offer: csv_lines([offer.cells]).rstrip("\n"),
        unit=f"{power} kg·m²" if power else "kg·m²",
        groups=[
            (reason, list(lines))
            for reason, lines in groupby(offers, lambda offer: offer.reason)
        ],
        marked={student for offer in offers for student in offer.people},
        references=sorted(
            class_grades.references.items(),
            key=lambda reference: in_order(reference[0]),
        ),
        histogram=count_points(class_grades.totals, class_grades.rubric.points),
        by_key={grade.student: grade for grade in class_grades.grades},
    )


def _numbered(items: Iterable[Hashable]) -> dict[Hashable, int]:
    return {item: number for number, item in enumerate(items)}


def _part(name: str) -> Markup:
    """Return a file that the page contains as it is."""
    return Markup(Path(__file__).parents[1].joinpath(name).read_text("utf-8"))


def _digest(text: str) -> str:
    """Return the hash by which a policy allows a style or a script."""
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def count_points(totals: Sequence[float], out_of: float) -> list[tuple[str, int]]:
    """Count the students with equal points, rounded to a step that gives up to 25 bars.

    [2, 2, 0.9] of 2 points gives [("0", 0), ("0.1", 0), …, ("0.9", 1), …, ("2", 2)].
    No bars without students.
    """
    steps = (size * 10.0**power for power in range(-3, 9) for size in (1, 2, 5))
    step = next(step for step in steps if out_of <= 25 * step)
    if not totals:
        return []
    last = round(out_of / step)
    bars = [math.floor(total / step + 0.5) for total in totals]
    counts = Counter(min(bar, last) for bar in bars)
    histogram = []
    for at in range(last + 1):
        points = round(at * step, 3)
        histogram.append((points_text(points), counts[at]))
    return histogram
