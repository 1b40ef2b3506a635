"""A class that has been graded: every grade, what it was held against, what was flagged, and the figures of it all."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from gyrodata.grading.exports.grades_csv import grades_csv
from gyrodata.grading.forensics import Flag
from gyrodata.grading.grade import Grade
from gyrodata.grading.reference import Reference
from gyrodata.grading.rubric import Rubric
from gyrodata.grading.submissions import Submissions


@dataclass(frozen=True, slots=True)
class CriterionFigures:
    """How a class did in one criterion."""

    id: str
    title: str
    out_of: float
    judged: int
    """Students for whom it could be judged."""
    full: int
    """Students with all of its points."""
    none: int
    """Students with none."""
    mean: float | None
    """Mean points of those judged; None for nobody."""


@dataclass(frozen=True)
class ClassGrades:
    """All that a run found out."""

    source: str
    """Name of the folder or zip, without where it is."""
    submissions: Submissions
    rubric: Rubric
    grades: Sequence[Grade]
    """In the order of `submissions`, settled."""
    references: Mapping[str, Reference]
    """What I_zz was held against, by station; "all" for every other."""
    flags: tuple[Flag, ...]
    again: Mapping[str, str]
    """Why each student was graded in this run, by key; the others' grades were known."""
    figures: Mapping[str, Mapping[str, str]]
    """What each drawn figure shows, in words, by student and name of the figure."""

    @cached_property
    def totals(self) -> list[float]:
        """Points of those who are graded, in the order of the grades."""
        return [grade.points for grade in self.grades if grade.points is not None]

    @cached_property
    def slips(self) -> Mapping[str, list[str]]:
        """Who made which known slip, by its kind; the commonest first."""
        found: dict[str, list[str]] = {}
        for grade in self.grades:
            for slip in grade.slips:
                found.setdefault(slip.kind, []).append(grade.student)
        return dict(sorted(found.items(), key=lambda item: (-len(item[1]), item[0])))

    @cached_property
    def notes(self) -> Mapping[str, tuple[str, ...]]:
        """Why a person should look at a grade, by student; only of those that need it."""
        found = {}
        for grade in self.grades:
            told = (*(() if grade.why is None else (f"could not be graded: {grade.why}",)), *grade.look)
            if told:
                found[grade.student] = told
        return found

    @cached_property
    def table(self) -> str:
        """``grades.csv``."""
        return grades_csv(self.grades, self.flags)

    @property
    def mean(self) -> float | None:
        """Mean of the points; None where nobody is graded."""
        return round(statistics.fmean(self.totals), 4) if self.totals else None

    @property
    def median(self) -> float | None:
        """Median of the points; None where nobody is graded."""
        return statistics.median(self.totals) if self.totals else None

    @cached_property
    def ids(self) -> Mapping[str, Mapping[str, str]]:
        """What platforms know each student by."""
        return {item.student: item.ids for item in self.submissions.items}

    @cached_property
    def names(self) -> Mapping[str, str]:
        """How each student is shown."""
        return {item.student: item.name for item in self.submissions.items}

    def label(self, student: str) -> str:
        """Call a student by name, with the key where that is another."""
        name = self.names.get(student, student)
        return name if name == student or student in name else f"{name} ({student})"

    @cached_property
    def flags_of(self) -> Mapping[str, tuple[Flag, ...]]:
        """The flags that each flagged student is in."""
        found: dict[str, list[Flag]] = {}
        for flag in self.flags:
            for student in flag.students:
                found.setdefault(student, []).append(flag)
        return {student: tuple(flags) for student, flags in found.items()}

    def in_question(self) -> list[str]:
        """List those whose grade a person should look at."""
        return [student for student in self.names if student in self.notes or student in self.flags_of]

    def looks(self, student: str) -> list[str]:
        """Say why a person should look at a student's grade; nothing where nobody need to."""
        reasons = list(self.notes.get(student, ()))
        for flag in self.flags_of.get(student, ()):
            others = [self.label(other) for other in (*flag.students, *flag.previous) if other != student]
            reasons.append(f"flag: {flag.kind}{' with ' + ', '.join(others) if others else ''}")
        return reasons

    def criteria(self) -> Iterator[CriterionFigures]:
        """Tell how the class did in each criterion, in the rubric's order."""
        for at, criterion in enumerate(self.rubric.criteria):
            marks = (grade.marks[at].points for grade in self.grades)
            judged = [points for points in marks if points is not None]
            yield CriterionFigures(
                criterion.id,
                criterion.title,
                criterion.points,
                len(judged),
                sum(one >= criterion.points for one in judged),
                sum(one <= 0 for one in judged),
                round(statistics.fmean(judged), 4) if judged else None,
            )
