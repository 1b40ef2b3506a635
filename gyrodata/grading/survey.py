"""What is asked of all grades of a class at once, gathered in one look at each: numbers, for a class may be large."""

from __future__ import annotations

import math
import sys
from array import array
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from gyrodata.grading.grade import Grade
from gyrodata.grading.rubric import Rubric


@dataclass(frozen=True, slots=True)
class Survey:
    """N grades, in their order; NaN stands for what a grade does not have."""

    students: Sequence[str]
    """Their keys."""
    stations: Sequence[str | None]
    points: Sequence[float]
    """Of each grade."""
    judged: Sequence[Sequence[float]]
    """For each criterion of the rubric, the points of those for whom it could be judged."""
    inertia: Sequence[float]
    """I_zz that each one's own runs give by the recommended fit [kg*m^2]."""
    reported: Sequence[float]
    """I_zz as reported [kg*m^2]."""
    ratio: Sequence[float]
    """Reported I_zz over that of the accepted fit that it comes nearest to [1]."""
    slips: Mapping[str, Sequence[str]]
    """Who made which known slip, by its kind; the commonest first."""
    slip_words: Mapping[str, str]
    """Each of these slips in words."""
    notes: Mapping[str, Sequence[str]]
    """Why a person should look at a grade, by student; only of those that need it."""

    @property
    def totals(self) -> Sequence[float]:
        """Points of those who are graded."""
        return array("d", known(self.points))


def known(values: Iterable[float]) -> list[float]:
    """Give those values that are there.

    Parameters
    ----------
    values : iterable of float
        NaN for what is not there.

    Returns
    -------
    list of float
    """
    return [value for value in values if not math.isnan(value)]


def survey_grades(grades: Iterable[Grade], rubric: Rubric) -> Survey:
    """Look at each grade once.

    Parameters
    ----------
    grades : iterable of Grade
        All of a class.
    rubric : Rubric
        By which they were given.

    Returns
    -------
    Survey
    """
    students: list[str] = []
    stations: list[str | None] = []
    points, inertia, reported, ratio = (array("d") for _ in range(4))
    judged = [array("d") for _ in rubric.criteria]
    slips: dict[str, list[str]] = {}
    words: dict[str, str] = {}
    notes: dict[str, tuple[str, ...]] = {}
    for grade in grades:
        students.append(grade.student)
        stations.append(None if grade.station is None else sys.intern(grade.station))
        points.append(_number(grade.points))
        inertia.append(_number(grade.inertia))
        value = grade.reported.get("value")
        reported.append(value if isinstance(value, float) else math.nan)
        own = grade.own.get(grade.matched or "", {}).get("value")
        ratio.append(reported[-1] / own if own else math.nan)
        for values, mark in zip(judged, grade.marks, strict=True):
            if mark.points is not None:
                values.append(mark.points)
        for slip in grade.slips:
            slips.setdefault(slip.kind, []).append(grade.student)
            words[slip.kind] = slip.words
        told = (*(() if grade.why is None else (f"could not be graded: {grade.why}",)), *grade.look)
        if told:
            notes[grade.student] = told
    ordered = dict(sorted(slips.items(), key=lambda item: (-len(item[1]), item[0])))
    return Survey(students, stations, points, judged, inertia, reported, ratio, ordered, words, notes)


def _number(value: float | None) -> float:
    return math.nan if value is None else value
