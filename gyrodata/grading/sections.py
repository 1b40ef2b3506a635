"""Compare the points of sections, and of graders, with those of the rest of a class."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from msgspec import Struct

from gyrodata.fitting import chi2_tail
from gyrodata.grading.yardsticks import grouped, in_order
from gyrodata.reporting.values import p_text

if TYPE_CHECKING:
    from gyrodata.grading.classroom import ClassGrades

FEWEST = 5
"""Students in a section, and in the rest of the class, for a test by large numbers."""

RARE = 0.01
"""An honest class has a section with a note with this probability."""


class SectionFigures(Struct, frozen=True):
    """The points of those who are in one section, or have one grader."""

    kind: Literal["section", "grader"]
    name: str
    graded: int
    mean: float
    median: float
    spread: float | None
    """Standard deviation [points]; null for one student."""
    full: float
    """Share of students with all points [1]."""
    p: float | None
    """Probability of such a difference from the rest of the class by chance, times the
    number of sections; null for fewer than five students."""

    @property
    def differs(self) -> bool:
        """Return whether chance alone hardly explains the difference."""
        if self.p is None:
            return False
        return self.p < RARE

    @property
    def words(self) -> str:
        """Say how the section differs."""
        return (
            f"{self.kind} {self.name} has other points than the rest of the class "
            f"(mean {self.mean:.2f}, {p_text(self.p or 0.0)} by chance)"
        )


def section_figures(class_grades: ClassGrades) -> Iterator[SectionFigures]:
    """Yield the figures of each section and each grader, if there are several."""
    people = class_grades.roster.people
    points = {}
    for grade in class_grades.grades:
        if grade.status == "graded" and grade.points is not None:
            points[grade.student] = grade.points
    known = [key for key in points if key in people]
    sections = grouped((people[key].section, points[key]) for key in known)
    graders = grouped((people[key].grader, points[key]) for key in known)
    yield from _compare("section", sections, class_grades.rubric.points)
    yield from _compare("grader", graders, class_grades.rubric.points)


def _compare(
    kind: Literal["section", "grader"],
    points: Mapping[str, Sequence[float]],
    out_of: float,
) -> Iterator[SectionFigures]:
    """Compare the points of each group with those of all others.

    The test is that of Mann and Whitney, corrected for ties and, by the factor of
    Bonferroni, for the number of groups.
    """
    groups = {name: some for name, some in points.items() if name}
    if len(groups) < 2:
        return
    for name in sorted(groups, key=in_order):
        mine = groups[name]
        others = [total for key in groups if key != name for total in groups[key]]
        with_all = sum(total >= out_of for total in mine)
        yield SectionFigures(
            kind,
            name,
            graded=len(mine),
            mean=round(statistics.fmean(mine), 4),
            median=statistics.median(mine),
            spread=round(statistics.stdev(mine), 4) if len(mine) > 1 else None,
            full=round(with_all / len(mine), 4),
            p=_probability(mine, others, len(groups)),
        )


def _probability(
    mine: Sequence[float], others: Sequence[float], count: int
) -> float | None:
    """Return the corrected p of a difference; None if there are too few students.

    It is that of ``scipy.stats.mannwhitneyu``, "asymptotic" and without its correction
    for continuity; the import of scipy takes longer than a class that is graded already.
    """
    if min(len(mine), len(others)) < FEWEST:
        return None
    _, place, counts = np.unique(
        [*mine, *others], return_inverse=True, return_counts=True
    )
    if len(counts) == 1:
        return 1.0
    # Equal points share the mean of their ranks.
    ranks = (np.cumsum(counts) - (counts - 1) / 2)[place]
    is_mine = np.arange(len(ranks)) < len(mine)
    correlation = float(np.corrcoef(ranks, is_mine)[0, 1])
    chi2 = (len(ranks) - 1) * correlation**2
    return min(1.0, count * chi2_tail(chi2, 1))
