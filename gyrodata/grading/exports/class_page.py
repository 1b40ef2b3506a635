"""``class.html``: a class at a glance, and what waits for a person, in one file that needs nothing else."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import groupby
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from gyrodata import __version__
from gyrodata.grading.forensics import Fingerprint, Flag, put_beside
from gyrodata.grading.grade import Grade, points_text
from gyrodata.grading.ledger import COLUMNS, DESK, Offer
from gyrodata.grading.templates import environment
from gyrodata.physics import RPM
from gyrodata.reporting.data import csv_lines
from gyrodata.reporting.values import count_text, number_text, power_of_ten

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades


MOST_STUDENTS = 5000  # rows of the page; a browser needs seconds for more, and the other tables contain all

MOST_NAMED = 500  # people of one slip, and lines of one reason, that are listed on the page


def class_page(
    found: ClassGrades, feedback: Callable[[str], str], offers: Sequence[Offer], files: Mapping[str, str]
) -> str:
    """Write the page of a class.

    `feedback`: Gives a student's page, as a path below the folder of the class page. `offers`: What waits for a person,
    those of one reason together. `files`: What there is to look into.

    Every name, note and number from outside is escaped; no clock time, nothing from another place.
    """
    from markupsafe import Markup

    inertias = [grade.inertia for grade in found.grades if grade.inertia is not None]
    words = {slip.kind: slip.words for grade in found.grades for slip in grade.slips}
    factor, power = power_of_ten(statistics.median(inertias)) if inertias else (1.0, "")
    waiting = dict.fromkeys(offer.flag for offer in offers if offer.flag)
    between = Markup('</td><td class="n">')
    content = {
        "found": found,
        "version": __version__,
        "link": lambda student: quote(feedback(student).encode("utf-8", "replace")),
        "files": files.__getitem__,
        "desk": DESK,
        "desk_head": csv_lines([COLUMNS]).strip(),
        "desk_line": lambda offer: csv_lines([offer.cells]).rstrip("\n"),
        "offers": offers,
        "groups": [_group(reason, list(lines)) for reason, lines in groupby(offers, lambda one: one.reason)],
        "pairs": _pairs_of_logs(waiting, found.compared),
        "decided": [flag for flag in found.flags if flag not in waiting],
        "marked": {student for one in offers for student in (one.student, *(one.flag.students if one.flag else ()))},
        "slips": [(words[kind], students) for kind, students in found.slips.items()],
        "criteria": list(found.criteria()),
        "histogram": count_points(found.totals, found.rubric.points),
        # Cell by cell would take half as long again for the whole page.
        "all_points": lambda grade: between.join(points_text(one.points) for one in (grade, *grade.marks)),
        "count": count_text,
        "rarity": _rarity,
        "unit": f"{power} kg·m²" if power else "kg·m²",
        "distances": lambda grade: between.join(map(_distance, (grade.d, grade.zeta))),
        "reported": lambda grade: _reported(grade, factor),
        "by_key": {grade.student: grade for grade in found.grades},
        "most": {"rows": MOST_STUDENTS, "named": MOST_NAMED},
    }
    return environment().get_template("class.html.jinja").render(content)


def _reported(grade: Grade, factor: float) -> str:
    value, u = grade.reported_inertia, grade.reported.get("u")
    if value is None:
        return "–"
    return number_text(value, u if isinstance(u, float) else None, factor).replace("-", "−")


def _distance(value: float | None) -> str:
    """Two digits, and all those before the point up to a million."""
    text = "–" if value is None else f"{value:.0f}" if 100 <= value < 1e6 else f"{value:.2g}"
    return text.replace("-", "−")


# --- what waits for a person, by reason, and the logs of flagged pairs ----------------------------------------


ROWS_SHOWN = 40  # of one pair of logs; the first ones, and most logs have nine

ROWS_IN_ALL = 3000  # of all pairs; a class where everybody is flagged would make a page that no browser likes


def _group(reason: str, lines: list[Offer]) -> dict[str, Any]:
    """Tell those about a flag from the others, and what all lines say; "" where they say different things."""
    flags: dict[Flag, list[Offer]] = {}
    for line in lines:
        if line.flag is not None:
            flags.setdefault(line.flag, []).append(line)
    others = [one for one in lines if one.flag is None]
    why = lines[0].why if len(lines) > 1 and not flags and len({line.why for line in lines}) == 1 else ""
    return {"reason": reason, "number": len(lines), "why": why, "lines": others, "flags": flags}


def _rarity(expected: float) -> str:
    one_in = "fewer than 1 in a million" if expected < 1e-6 else f"about 1 in {float(f'{1 / expected:.1g}'):.0f}"
    return f"By chance, {one_in} honest classes would show this."


def _pairs_of_logs(flags: Iterable[Flag], logs: Mapping[str, Fingerprint]) -> dict[Flag, list[dict[str, Any]]]:
    """Show the logs of each flag side by side, up to `ROWS_IN_ALL` rows."""
    tables: dict[Flag, list[dict[str, Any]]] = {}
    left = ROWS_IN_ALL
    for flag in flags:
        tables[flag] = []
        for pair in flag.pairs:
            if left > 0:
                tables[flag].append(_pair_of_logs(pair, logs))
                left -= len(tables[flag][-1]["rows"])
    return tables


def _pair_of_logs(students: tuple[str, str], logs: Mapping[str, Fingerprint]) -> dict[str, Any]:
    """Show two logs side by side.

    Gives: A row has its torque [mN*m]; line, spin [rpm], time [s] and turns in each log; whether the spins and the
    times are the same.
    """
    both = logs[students[0]], logs[students[1]]
    beside = put_beside(*both)
    rows = []
    for one in beside[:ROWS_SHOWN]:
        places = list(zip(both, (one.first, one.second), strict=True))
        left, right = ([] if at is None else _row_of(log, at) for log, at in places)
        torque = next(log.torque[at] for log, at in places if at is not None)
        rows.append((f"{1e3 * torque:.4g}", left, right, one.same_spin, one.same_period))
    return {"students": students, "rows": rows, "left_out": len(beside) - len(rows)}


def _row_of(log: Fingerprint, at: int) -> list[str]:
    """Write a row to the digits that were typed."""
    turns = Fraction(log.turns[at]).limit_denominator(12)
    exact = abs(float(turns) - log.turns[at]) < 1e-6 * log.turns[at]
    return [
        str(log.lines[at]),
        _typed(log.spin[at] / RPM, log.spin_step[at] / RPM),
        _typed(log.time[at], log.time_step[at]),
        str(turns) if exact else f"{log.turns[at]:.4g}",
    ]


def _typed(value: float, step: float) -> str:
    """Write a number to the decimals of its last digit; six digits where that is not known."""
    return f"{value:.{max(0, math.ceil(-math.log10(step) - 1e-6))}f}" if step > 0 else f"{value:.6g}"


# --- the class in numbers -----------------------------------------------------------------------------------


MOST_BARS = 25  # of the points


def count_points(totals: Sequence[float], out_of: float) -> list[tuple[str, int]]:
    """Count how many have how many points, rounded to a step that leaves few bars: 0 first; empty for nobody."""
    steps = (size * 10.0**power for power in range(-3, 9) for size in (1, 2, 5))
    step = next(step for step in steps if out_of <= MOST_BARS * step)
    last = round(out_of / step)
    counts = Counter(min(math.floor(total / step + 0.5), last) for total in totals)
    return [(points_text(round(at * step, 3)), counts[at]) for at in range(last + 1)] if counts else []
