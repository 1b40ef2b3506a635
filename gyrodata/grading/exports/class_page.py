"""``class.html``: a class at a glance, in one file that needs nothing else."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import quote

import numpy as np

from gyrodata import __version__
from gyrodata.fitting import MAD_TO_SD
from gyrodata.grading.grade import Grade, points_text
from gyrodata.grading.templates import environment
from gyrodata.grading.yardsticks import Reference
from gyrodata.physics import Floats, Integers
from gyrodata.reporting import count_text, inertia_text, number_text, power_of_ten

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades


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
    page = environment().get_template("class.html.jinja").stream(content)
    page.enable_buffering(1000)
    yield from page


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
        (grade.zeta, _distance(grade.zeta)),
    ]
    return [{"value": "" if key is None else repr(key), "text": text.replace("-", "−")} for key, text in numbers]


def _distance(value: float | None) -> str:
    """Two digits, and all those before the point up to a million."""
    return "–" if value is None else f"{value:.0f}" if 100 <= value < 1e6 else f"{value:.2g}"


# --- how I_zz is distributed in the class: what is drawn, as places and words -------------------------------


WIDTH, LEFT, RIGHT = 640, 128, 28  # of the drawing, and of its margins [px]

HALF, BETWEEN = 44, 26  # height of the bars on one side of a strip, and what is left between two strips [px]

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
        middle = 16 + HALF + number * (2 * HALF + BETWEEN)
        reference = references.get(station) or references.get("all")
        strips.append(_strip(station, members, reference, scale, middle))
    factor, power = power_of_ten(statistics.median(own))
    words = "; ".join(_strip_words(strip) for strip in strips)
    height = 16 + len(strips) * (2 * HALF + BETWEEN) + 26
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
    return dict(sorted(groups.items()))


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
        "" if reference is None else f"{inertia_text(reference.inertia, reference.u or None)} ({reference.source})",
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
