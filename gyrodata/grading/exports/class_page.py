"""Write ``class.html``: what needs a decision, all students, and the class in numbers, in one file."""

from __future__ import annotations

import math
import os
import statistics
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import groupby
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from gyrodata import __version__
from gyrodata.grading.forensics import Fingerprint, Flag, put_beside
from gyrodata.grading.grade import points_text
from gyrodata.grading.ledger import COLUMNS, DESK, Offer
from gyrodata.grading.templates import environment
from gyrodata.grading.yardsticks import in_order
from gyrodata.physics import RPM
from gyrodata.reporting.data import csv_lines
from gyrodata.reporting.values import count_text, power_of_ten

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades

# Longer lists would make a page that is too large for a browser; the other tables contain everything.
MOST = {"rows": 5000, "named": 500, "pairs": 300, "rows of a pair": 40}


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
        "pairs": [pair for flag in open_flags for pair in flag.pairs][: MOST["pairs"]],
        "beside": lambda pair: _beside(found.compared[pair[0]], found.compared[pair[1]]),
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


def _beside(first: Fingerprint, second: Fingerprint) -> list[tuple[str, list[list[str]], bool, bool]]:
    """Return the rows of two logs next to each other: the torque [mN·m], the cells, and if spin and time are the same.

    The cells of a log are its line, spin [rpm], time [s] and turns, with the digits that were typed.
    """
    rows = []
    for one in put_beside(first, second):
        cells, torque = [["", "", "", ""]] * 2, 0.0
        for side, (log, at) in enumerate(((first, one.first), (second, one.second))):
            if at is not None:
                torque = log.torque[at]
                turns = Fraction(log.turns[at]).limit_denominator(12)
                exact = abs(float(turns) - log.turns[at]) < 1e-6 * log.turns[at]
                spin = _typed(log.spin[at] / RPM, log.spin_step[at] / RPM)
                time = _typed(log.time[at], log.time_step[at])
                cells[side] = [str(log.lines[at]), spin, time, str(turns) if exact else f"{log.turns[at]:.4g}"]
        rows.append((f"{1e3 * torque:.4g}", cells, one.same_spin, one.same_period))
    return rows


def _typed(value: float, step: float) -> str:
    """Write a number to its last digit; six digits if that is not known."""
    return f"{value:.{max(0, math.ceil(-math.log10(step) - 1e-6))}f}" if step > 0 else f"{value:.6g}"


def count_points(totals: Sequence[float], out_of: float) -> list[tuple[str, int]]:
    """Count the students with equal points, rounded to a step that gives up to 25 bars; no bars without students."""
    steps = (size * 10.0**power for power in range(-3, 9) for size in (1, 2, 5))
    step = next(step for step in steps if out_of <= 25 * step)
    last = round(out_of / step)
    counts = Counter(min(math.floor(total / step + 0.5), last) for total in totals)
    return [(points_text(round(at * step, 3)), counts[at]) for at in range(last + 1)] if counts else []
