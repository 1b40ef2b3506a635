"""Write the pages: the feedback for a student, and ``class.html`` with what needs a decision and the class in numbers.

HTML is escaped, and each text from outside becomes one harmless line.
"""

from __future__ import annotations

import base64
import math
import os
import re
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from itertools import groupby
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from msgspec.structs import replace

from gyrodata import __version__
from gyrodata.errors import shown
from gyrodata.grading.forensics import Flag
from gyrodata.grading.grade import Grade, points_text
from gyrodata.grading.ledger import COLUMNS, DESK, Offer
from gyrodata.grading.yardsticks import fit_words, in_order
from gyrodata.plotting import FIGURES
from gyrodata.reporting.data import csv_lines
from gyrodata.reporting.values import count_text, factor_text, inertia_text, number_text, power_of_ten

if TYPE_CHECKING:
    from jinja2 import Environment

    from gyrodata.grading.classroom import ClassGrades


@lru_cache(maxsize=1)
def environment() -> Environment:
    """Return the environment of all templates, with its filters."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("gyrodata.grading", "."),
        autoescape=lambda name: name is not None and name.endswith(".html.jinja"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"plain": shown, "points": points_text, "factor": factor_text, "inertia": inertia_text}
    made.filters |= {"number": number_text, "distance": _distance, "fit_words": fit_words}
    # Titles, rules and reasons are the same for many students.
    made.filters |= {"md": lru_cache(512)(_markdown_safe), "sentence": lru_cache(512)(sentence)}
    return made


def sentence(text: object) -> str:
    """Return one line with a capital and a full stop."""
    line = shown(text).rstrip(".")
    # "g is missing" and "φ̇ψ̇ scatters" begin with a symbol.
    first = line[:1].upper() if re.match("[a-z]{2}", line) else line[:1]
    return f"{first}{line[1:]}{'' if line.endswith(('?', '!')) else '.'}" if line else ""


def _distance(value: float | None) -> str:
    """Write a distance in units of u: two digits, and all digits before the point up to a million."""
    return "–" if value is None else f"{value:.0f}" if 100 <= value < 1e6 else f"{value:.2g}".replace("-", "−")


def _markdown_safe(text: object) -> str:
    """Return one line that Markdown takes literally."""
    line = re.sub(r"([\\`*_\[\]|~$])", r"\\\1", shown(text))
    return line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("://", ":\\//")


# --- the feedback for a student ----------------------------------------------------------------------------


def feedback_markdown(grade: Grade) -> str:
    """Write the feedback for one student as Markdown.

    Gives: Every name, note and number from outside is escaped; no clock time.
    """
    text = environment().get_template("feedback.md.jinja").render(_content(grade))
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
    return environment().get_template("feedback.html.jinja").render(_content(grade), images=images)


def feedback_comment(grade: Grade) -> str:
    """Write the feedback for one student in a few lines of plain text, for the comment field of a gradebook."""
    return environment().get_template("feedback.txt.jinja").render(_content(grade)).strip()


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
    """Return what the templates of the feedback need."""
    if grade.status in ("on hold", "excused"):
        # No points are given, and none are shown.
        grade = replace(grade, marks=(), slips=(), own={}, diagnostics=(), late_reason="")
    words: Any = environment().get_template("words.jinja").module
    short = [one for one in grade.marks if one.points is not None and one.points < one.out_of]
    costs = [one.detail["slip_cost"] for one in grade.marks if grade.slips and "slip_cost" in one.detail]
    return {
        "grade": grade,
        "short": short,
        "told": [one for one in grade.diagnostics if one["severity"] != "note"],
        "slip_cost": costs[0] if costs else None,
        "lead": words.lead(grade, short).strip(),
        "verdict": words.verdict(grade).strip(),
        "hands": _hands(grade),
        "judged": any(one.points is not None for one in grade.marks),
    }


# --- the page of a class -----------------------------------------------------------------------------------

# Longer lists would make a page that is too large for a browser; the other tables contain everything.
MOST = {"rows": 5000, "named": 500}


def class_page(
    found: ClassGrades,
    feedback: Callable[[str], str],
    offers: Sequence[Offer],
    files: Mapping[str, str],
    folder: Path | None = None,
) -> str:
    """Write the page of a class.

    `feedback`: Returns the path of a student's page below the folder of the class page. `offers`: What needs a
    decision, grouped by reason. `files`: Names of the files to look into, by student. `folder`: The folder of the class
    page, for links to these files. All text from outside is escaped; the page contains no clock time.
    """
    inertias = [grade.inertia for grade in found.grades if grade.inertia is not None]
    factor, power = power_of_ten(statistics.median(inertias)) if inertias else (1.0, "")
    open_flags = list(dict.fromkeys(offer.flag for offer in offers if offer.flag))
    items = {item.student: item for item in found.submissions.items}

    def links(student: str) -> list[tuple[str, str]]:
        """Return the name and the address of each file besides the log; no links into a zip."""
        item = items[student]
        if folder is None or not item.source.is_dir():
            return []
        base = Path(os.path.relpath(item.source, folder)).as_posix()
        paths = {name: quote(f"{base}/{name}".encode("utf-8", "replace")) for name in item.beside_log}
        return [(PurePosixPath(name).name, path) for name, path in paths.items()]

    content = {
        "found": found,
        "version": __version__,
        "link": lambda student: quote(feedback(student).encode("utf-8", "replace")),
        "files": files,
        "links": links,
        "desk": DESK,
        "desk_head": ",".join(COLUMNS),
        "desk_line": lambda offer: csv_lines([offer.cells]).rstrip("\n"),
        "offers": offers,
        "groups": [_group(reason, list(lines)) for reason, lines in groupby(offers, lambda one: one.reason)],
        "decided": [flag for flag in found.flags if flag not in open_flags],
        "marked": {student for one in offers for student in (one.student, *(one.flag.students if one.flag else ()))},
        "words": {slip.kind: slip.words for grade in found.grades for slip in grade.slips},
        "references": sorted(found.references.items(), key=lambda one: in_order(one[0])),
        "criteria": list(found.criteria()),
        "histogram": count_points(found.totals, found.rubric.points),
        "count": count_text,
        "factor": factor,
        "unit": f"{power} kg·m²" if power else "kg·m²",
        "by_key": {grade.student: grade for grade in found.grades},
        "most": MOST,
    }
    return environment().get_template("class.html.jinja").render(content)


def _group(reason: str, lines: list[Offer]) -> dict[str, Any]:
    """Separate the lines about a flag from the others; "why" is what all lines say, or "" if they differ."""
    flags: dict[Flag, list[Offer]] = {}
    for line in lines:
        if line.flag is not None:
            flags.setdefault(line.flag, []).append(line)
    others = [one for one in lines if one.flag is None]
    why = lines[0].why if len(lines) > 1 and not flags and len({line.why for line in lines}) == 1 else ""
    return {"reason": reason, "number": len(lines), "why": why, "lines": others, "flags": flags}


def count_points(totals: Sequence[float], out_of: float) -> list[tuple[str, int]]:
    """Count the students with equal points, rounded to a step that gives up to 25 bars; no bars without students."""
    steps = (size * 10.0**power for power in range(-3, 9) for size in (1, 2, 5))
    step = next(step for step in steps if out_of <= 25 * step)
    last = round(out_of / step)
    counts = Counter(min(math.floor(total / step + 0.5), last) for total in totals)
    return [(points_text(round(at * step, 3)), counts[at]) for at in range(last + 1)] if counts else []
