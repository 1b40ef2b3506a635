"""``class.html``: a class at a glance, and what waits for a person, in one file that needs nothing else."""

from __future__ import annotations

import math
import re
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

import numpy as np

from gyrodata import __version__
from gyrodata.fitting import MAD_TO_SD
from gyrodata.grading.forensics import Fingerprint, Flag, put_beside
from gyrodata.grading.grade import Grade, points_text
from gyrodata.grading.ledger import COLUMNS, DESK, Offer, csv_lines
from gyrodata.grading.templates import environment
from gyrodata.grading.yardsticks import Reference
from gyrodata.physics import RPM, Floats, Integers
from gyrodata.reporting import count_text, number_text, power_of_ten

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades


MOST_STUDENTS = 5000  # rows of the page; a browser takes seconds for more, and the tables beside it have all

MOST_NAMED = 500  # people of one slip, and lines of one reason, that are listed on the page


def class_page(
    found: ClassGrades, feedback: Callable[[str], str], offers: Sequence[Offer], files: Callable[[str], str]
) -> Iterator[str]:
    """Write the page of a class.

    `feedback`: Gives a student's page, as a path below the folder of the class page. `offers`: What waits for a person,
    those of one reason together. `files`: Names what there is to look into.

    Every name, note and number from outside is escaped; no clock time, nothing from another place.
    """
    inertias = [grade.inertia for grade in found.grades if grade.inertia is not None]
    words = {slip.kind: slip.words for grade in found.grades for slip in grade.slips}
    factor, power = power_of_ten(statistics.median(inertias)) if inertias else (1.0, "")
    waiting = {offer.flag for offer in offers}
    content = {
        "found": found,
        "version": __version__,
        "link": lambda student: quote(feedback(student).encode("utf-8", "replace")),
        "files": files,
        "desk": DESK,
        "desk_head": csv_lines([COLUMNS]).strip(),
        "offers": offers,
        "groups": _by_reason(offers, found.compared),
        "decided": [flag for flag in found.flags if flag not in waiting],
        "marked": {student for one in offers for student in (one.student, *(one.flag.students if one.flag else ()))},
        "slips": [(words[kind], students) for kind, students in found.slips.items()],
        "criteria": list(found.criteria()),
        "of_points": draw_points(found.totals, found.rubric.points),
        "drawing": draw_distribution(found.grades, found.references),
        "box": {"width": WIDTH, "left": LEFT, "right": WIDTH - RIGHT},
        "points": points_text,
        "count": count_text,
        "unit": f"{power} kg·m²" if power else "kg·m²",
        "half": HALF,
        "distance": _distance,
        "cells": lambda grade: _cells(grade, factor),
        "by_key": {grade.student: grade for grade in found.grades},
        "most": {"rows": MOST_STUDENTS, "named": MOST_NAMED},
    }
    page = environment().get_template("class.html.jinja").stream(content)
    page.enable_buffering(1000)
    yield from page


def _cells(grade: Grade, factor: float) -> tuple[list[str], str, str]:
    """The numbers of a student's row: points, the report with what to sort it by, and its distances."""
    value, u = grade.reported_inertia, grade.reported.get("u")
    points = [points_text(grade.points), *(points_text(mark.points) for mark in grade.marks)]
    if value is None:
        return points, "", "–"
    return points, f"{value:.6g}", number_text(value, u if isinstance(u, float) else None, factor).replace("-", "−")


# --- what waits for a person: lines for the desk, by reason, and the logs of flagged pairs ----------------------


class Line(NamedTuple):
    """One line for the desk."""

    offer: Offer
    text: str  # as it is copied


class Finding(NamedTuple):
    """A flag, and the lines about it."""

    flag: Flag
    rarity: str  # how often chance alone makes such a flag, in words
    lines: list[Line]
    pairs: list[PairOfLogs]


class Group(NamedTuple):
    """All that waits for one reason."""

    reason: str
    number: int  # of lines
    why: str  # what all lines say; "" where they say different things
    lines: list[Line]  # those about no flag
    findings: list[Finding]


class PairOfLogs(NamedTuple):
    """Two logs side by side."""

    keys: tuple[str, str]
    rows: list[tuple[str, list[str], list[str], bool, bool]]
    """Torque [mN*m]; line, spin [rpm], time [s] and turns in each log; whether the spins and the times are the same."""
    left_out: int  # rows that are not shown

    def same(self, column: int) -> int:
        """Count the rows that have the same spin (3) or time (4)."""
        return sum(bool(row[column]) for row in self.rows)


ROWS_SHOWN = 40  # of one pair of logs; the first ones, and most logs have nine

ROWS_IN_ALL = 3000  # of all pairs; a class where everybody is flagged would make a page that no browser likes


def _by_reason(offers: Sequence[Offer], logs: Mapping[str, Fingerprint]) -> list[Group]:
    """Group the lines; the tables of the pairs are laid out until `ROWS_IN_ALL` are there."""
    groups: dict[str, list[Line]] = {}
    for offer in offers:
        groups.setdefault(offer.reason, []).append(Line(offer, csv_lines([offer.cells]).rstrip("\n")))
    left = ROWS_IN_ALL
    made = []
    for reason, lines in groups.items():
        flags: dict[Flag, list[Line]] = {}
        for line in lines:
            if line.offer.flag is not None:
                flags.setdefault(line.offer.flag, []).append(line)
        findings = []
        for flag, about in flags.items():
            pairs = []
            for one, other in flag.pairs:
                if left > 0:
                    pairs.append(_pair_of_logs(one, other, logs))
                    left -= len(pairs[-1].rows)
            findings.append(Finding(flag, _rarity(flag.expected), about, pairs))
        whys = {line.offer.why for line in lines}
        why = whys.pop() if len(whys) == 1 and len(lines) > 1 and not flags else ""
        made.append(Group(reason, len(lines), why, [line for line in lines if line.offer.flag is None], findings))
    return made


def _rarity(expected: float) -> str:
    one_in = "fewer than 1 in a million" if expected < 1e-6 else f"about 1 in {float(f'{1 / expected:.1g}'):.0f}"
    return f"By chance, {one_in} honest classes would show this."


def _pair_of_logs(one: str, other: str, logs: Mapping[str, Fingerprint]) -> PairOfLogs:
    """Put two logs beside each other."""
    both = logs[one], logs[other]
    beside = put_beside(*both)
    rows = []
    for row in beside[:ROWS_SHOWN]:
        places = row.first, row.second
        cells = [[] if at is None else _row_of(log, at) for log, at in zip(both, places, strict=True)]
        torque = next(log.torque[at] for log, at in zip(both, places, strict=True) if at is not None)
        rows.append((f"{1e3 * torque:.4g}", cells[0], cells[1], row.same_spin, row.same_period))
    return PairOfLogs((one, other), rows, len(beside) - len(rows))


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


def _distance(value: float | None) -> str:
    """Two digits, and all those before the point up to a million."""
    text = "–" if value is None else f"{value:.0f}" if 100 <= value < 1e6 else f"{value:.2g}"
    return text.replace("-", "−")


# --- how points and I_zz are distributed in the class: what is drawn, as places and words -------------------


WIDTH, LEFT, RIGHT = 400, 30, 30  # of a drawing, and of its margins [px]

HALF, BETWEEN = 28, 34  # height of the bars on one side of a strip, and what is left for words above it [px]

TALL = 90  # height of the bars of the points [px]

MOST_BARS = 25  # of the points

MOST_STRIPS = 12  # with more stations than this all are drawn in one strip

REACH = 8.0  # values farther than this from the middle, in robust standard deviations, are counted at the edge

NARROWEST = 0.004  # least half-width of the axis, as a share of I_zz


class Bar(NamedTuple):
    """One bar: where it is [px], and what it says."""

    x: float
    y: float
    width: float
    height: float
    words: str


class Points(NamedTuple):
    """How points are distributed."""

    bars: list[tuple[Bar, int]]  # with the number of students
    ticks: list[tuple[float, str]]  # place [px] and text of each
    height: float
    words: str  # what it shows, for those who cannot see it


def draw_points(totals: Sequence[float], out_of: float) -> Points | None:
    """Lay out how many have how many points, rounded to a step that leaves few bars; None for nobody."""
    if not totals:
        return None
    step = next(
        size * 10.0**power for power in range(-3, 9) for size in (1, 2, 5) if out_of <= MOST_BARS * size * 10.0**power
    )
    last = round(out_of / step)
    counts = Counter(min(math.floor(total / step + 0.5), last) for total in totals)
    width = (WIDTH - LEFT - RIGHT) / (last + 1)
    tall = TALL / max(counts.values())
    bars = []
    for at, count in sorted(counts.items()):
        said = f"{count_text(count, 'student')}: {points_text(round(at * step, 3))} points"
        height = round(count * tall, 1)
        bars.append(
            (
                Bar(round(LEFT + at * width + 0.5, 1), round(16 + TALL - height, 1), round(width - 1, 1), height, said),
                count,
            )
        )
    every = next(every for every in (1, 2, 5, 10) if last <= 8 * every or every == 10)
    ticks = [(round(LEFT + (at + 0.5) * width, 1), points_text(round(at * step, 3))) for at in range(last, -1, -every)]
    return Points(bars, ticks, TALL + 50, f"Points. {'; '.join(bar.words for bar, _ in bars)}.")


class Side(NamedTuple):
    """One side of a strip: above what the runs give, below what was reported."""

    words: str
    number: int  # of values
    bars: tuple[Bar, ...]
    below: tuple[str, ...]  # keys of those left of the axis
    above: tuple[str, ...]  # keys of those right of it


class Strip(NamedTuple):
    """One station, or everybody."""

    label: str
    middle: float  # height of its line [px]
    own: Side
    reported: Side
    band: tuple[float, float, float] | None  # left end, value and right end of the reference ± u [px]
    reference: str  # the same in words; "" where there is none


class Drawing(NamedTuple):
    """All strips on one axis."""

    strips: tuple[Strip, ...]
    ticks: tuple[tuple[float, str], ...]  # place [px] and text of each
    unit: str
    height: float
    words: str  # what it shows, for those who cannot see it


def draw_distribution(grades: Sequence[Grade], references: Mapping[str, Reference]) -> Drawing | None:
    """Lay out the distribution of I_zz in a class; None where not one log gives an I_zz."""
    own = [grade.inertia for grade in grades if grade.inertia is not None]
    reported = [grade.reported_inertia for grade in grades if grade.reported_inertia is not None]
    if not own:
        return None
    groups = _groups(grades, references)
    bins = max(12, min(48, 2 * math.isqrt(len(own)) + 8))
    scale = _Scale(np.linspace(*_range(own, reported, references), bins + 1))
    strips = []
    for number, (station, members) in enumerate(groups.items()):
        middle = BETWEEN + HALF + number * (2 * HALF + BETWEEN)
        reference = references.get(station) or references.get("all")
        strips.append(_strip(station, members, reference, scale, middle))
    factor, power = power_of_ten(statistics.median(own))
    words = "; ".join(_strip_words(strip) for strip in strips)
    height = len(strips) * (2 * HALF + BETWEEN) + 42
    unit = f"{power} kg·m²" if power else "kg·m²"
    return Drawing(tuple(strips), tuple(scale.ticks(factor)), unit, height, f"Distribution of I_zz. {words}.")


def _groups(grades: Sequence[Grade], references: Mapping[str, Reference]) -> dict[str, list[Grade]]:
    """Part a class by the stations that have a reference of their own."""
    groups: dict[str, list[Grade]] = {}
    for grade in grades:
        if grade.inertia is not None or grade.reported_inertia is not None:
            station = grade.station if grade.station is not None and grade.station in references else "all"
            groups.setdefault(station, []).append(grade)
    if len(groups) > MOST_STRIPS:
        return {"all": [grade for members in groups.values() for grade in members]}
    # Station 2 before station 10.
    return dict(
        sorted(groups.items(), key=lambda one: [int(x) if x.isdecimal() else x for x in _NUMBERS.split(one[0])])
    )


_NUMBERS = re.compile(r"([0-9]+)")


def _range(own: Sequence[float], reported: Sequence[float], references: Mapping[str, Reference]) -> tuple[float, float]:
    """Find an axis on which the bulk is seen, whatever slips do to a few."""
    middle = statistics.median(own)
    spread = MAD_TO_SD * statistics.median(abs(value - middle) for value in own)
    reach = max(REACH * spread, NARROWEST * abs(middle))
    kept = [value for value in (*own, *reported) if abs(value - middle) <= reach]
    for reference in references.values():
        kept += [end for end in (reference.inertia - reference.u, reference.inertia + reference.u)
                 if abs(end - middle) <= 2 * reach]  # fmt: skip
    low, high = min(kept), max(kept)
    pad = max(0.06 * (high - low), NARROWEST * abs(middle) / 2)
    return low - pad, high + pad


class _Scale(NamedTuple):
    """From I_zz to a place in the drawing."""

    edges: Floats  # of the bars [kg*m^2]

    def x(self, value: float) -> float:
        low, high = float(self.edges[0]), float(self.edges[-1])
        return round(LEFT + (value - low) / (high - low) * (WIDTH - LEFT - RIGHT), 1)

    def ticks(self, factor: float) -> Iterable[tuple[float, str]]:
        """Three to seven round numbers."""
        low, high = float(self.edges[0]) / factor, float(self.edges[-1]) / factor
        width = high - low
        step = next(
            size * 10.0**power
            for power in range(math.floor(math.log10(width)) - 1, math.floor(math.log10(width)) + 2)
            for size in (1, 2, 5)
            if width / (size * 10.0**power) <= 6
        )
        places = max(0, -math.floor(math.log10(step) + 1e-9))
        numbers = range(math.ceil(low / step), math.floor(high / step) + 1)
        return [(self.x(number * step * factor), f"{number * step:.{places}f}") for number in numbers]


def _strip(station: str, members: Sequence[Grade], reference: Reference | None, scale: _Scale, middle: float) -> Strip:
    own = {grade.student: grade.inertia for grade in members if grade.inertia is not None}
    reported = {grade.student: value for grade in members if (value := grade.reported_inertia) is not None}
    counts = [np.histogram(list(values.values()), scale.edges)[0] for values in (own, reported)]
    tall = HALF / max(1, *map(max, counts))
    band = None
    if reference is not None:
        ends = (reference.inertia - reference.u, reference.inertia, reference.inertia + reference.u)
        left, value, right = (min(max(scale.x(end), LEFT), WIDTH - RIGHT) for end in ends)
        band = left, value, right
    return Strip(
        "all" if station == "all" else f"station {station}",
        middle,
        _side("from their runs", own, _bars(counts[0], tall, middle - 1, True, scale), scale),
        _side("as reported", reported, _bars(counts[1], tall, middle + 1, False, scale), scale),
        band,
        "" if reference is None else reference.words,
    )


def _bars(counts: Integers, tall: float, base: float, up: bool, scale: _Scale) -> Iterator[Bar]:
    """Lay out the bars of one side, up or down from the line."""
    width = (WIDTH - LEFT - RIGHT) / len(counts)
    for at in np.flatnonzero(counts).tolist():
        count, height = int(counts[at]), tall * float(counts[at])
        said = f"{count_text(count, 'student')}: {scale.edges[at]:.4g} to {scale.edges[at + 1]:.4g} kg·m²"
        y = base - height if up else base
        yield Bar(round(LEFT + at * width + 0.5, 1), round(y, 1), round(width - 1, 1), round(height, 1), said)


def _side(words: str, values: Mapping[str, float], bars: Iterable[Bar], scale: _Scale) -> Side:
    below = tuple(student for student, value in values.items() if value < scale.edges[0])
    above = tuple(student for student, value in values.items() if value > scale.edges[-1])
    return Side(words, len(values), tuple(bars), below, above)


def _strip_words(strip: Strip) -> str:
    parts = [f"{strip.own.number} from their runs", f"{strip.reported.number} as reported"]
    off = len(strip.reported.below) + len(strip.reported.above)
    if off:
        parts.append(f"{off} of those reported off the axis")
    if strip.reference:
        parts.append(f"reference {strip.reference}")
    return f"{strip.label}: {', '.join(parts)}"
