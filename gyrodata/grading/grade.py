"""One student's grade: from a submission to marks with their reasons, without ever raising for what is in it.

The story: read the log → analyse it → work out the accepted fits of its runs → hold the report against them, known
slips undone → judge each criterion → take off for being late. What cannot be judged has no points instead of zero,
and makes the whole grade "not graded", with the reason, so that a person looks at it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Literal, TypedDict, TypeVar

import msgspec
from msgspec import Meta, Struct, field
from msgspec.structs import replace

from gyrodata.diagnostics import COLUMNS_EXCHANGED, OUTLIER
from gyrodata.errors import Diagnostic, DiagnosticJson, GyroError, LogError
from gyrodata.fitting import times_stated
from gyrodata.grading import yardsticks
from gyrodata.grading.criteria import Evidence, Mark, judge, judge_reference, judge_scatter, mark, scatter_of
from gyrodata.grading.forensics import Fingerprint, fingerprint
from gyrodata.grading.late import judge_lateness
from gyrodata.grading.rubric import ASKS, Rubric
from gyrodata.grading.slips import SAME, Slip, corrected, find_slips, unusual
from gyrodata.mistakes import Mistake, explaining_mistakes, known_mistakes
from gyrodata.readings import Readings, read_reported
from gyrodata.reporting.values import factor_text

if TYPE_CHECKING:
    from gyrodata.grading.submissions import Submission
    from gyrodata.grading.submissions.student_files import Answers
    from gyrodata.results import Analysis

FAR = 3.0  # a report farther than this from every accepted fit [u], and explained by no known slip, is worth a look

Record = TypeVar("Record", bound=Struct)

Status = Literal["graded", "so far", "on hold", "excused", "not graded"]


class Decision(Struct, frozen=True):
    """The decisions by hand about one student."""

    what: str  # id of a criterion, or one of `ledger.WORDS`
    value: str  # as written
    by: str
    why: str

    @property
    def told(self) -> str:
        """Why, and who says so."""
        return f"{self.why} ({self.by})".lstrip() if self.by else self.why

    def __str__(self) -> str:
        head = f"{self.what} {self.value}".rstrip()
        return f"{head}{':' if self.why else ''} {self.told}".rstrip()


class Reported(TypedDict, total=False):
    """I_zz as the student reports it; no key at all where nothing is reported."""

    text: str
    value: float | None
    """[kg*m^2]"""
    u: float | None
    """[kg*m^2]"""
    line: int | None


_REPORTED = list(Reported.__annotations__)


class OwnFit(TypedDict):
    """The value of one accepted fit of the student's own runs."""

    value: float
    """[kg*m^2]"""
    u: float | None
    """[kg*m^2]"""


class ShownGrade(Struct, frozen=True, kw_only=True):
    """The grade of one student, as it is shown."""

    student: str
    name: str
    status: Status = "not graded"  # "so far": some marks wait for a person
    why: str | None = None  # why it is not graded; None if it is
    points: float | None = None  # what counts, lateness taken off, two decimals; None where nothing counts yet
    out_of: float
    marks: tuple[Mark, ...] = ()
    """One for each criterion, in the rubric's order; points null: it could not be judged, which is no zero."""
    slips: tuple[Slip, ...] = ()  # known slips that explain the report, the likeliest first
    look: tuple[str, ...] = ()  # what a person should look at though it is graded
    station: str | None = None
    section: str = ""  # of the roster
    reported: Annotated[Reported, Meta(extra_json_schema={"anyOf": [{"required": _REPORTED}, {"maxProperties": 0}]})]
    own: Mapping[str, OwnFit]
    """Each accepted fit of the student's own runs, by its name."""
    inertia: float | None = None
    """I_zz that the student's own runs give by the recommended fit, accepted or not [kg*m^2]."""
    inertia_u: float | None = None  # its standard uncertainty [kg*m^2]
    matched: str | None = None  # the accepted fit that the report comes nearest to, a slip undone
    d: float | None = None  # distance of the report from it, as reported [u]
    bench: tuple[str, ...] = ()  # uncertainties that the log does not state, and has from the rubric: "u_time 0.3 s"
    scatters: tuple[tuple[float, int], ...] = ()
    """χ² of φ̇ψ̇ within each torque and its degrees of freedom, by the usual uncertainties; none where others hold."""
    # Zeta score of ISO 13528: distance from the reference over the u of both, a slip undone. JSON, tables and rubrics
    # have called it "z" from the start.
    zeta: float | None = field(default=None, name="z")
    late_seconds: float | None  # late by this [s]; None where nothing tells
    late_deduction: float  # [points]
    late_reason: str
    diagnostics: tuple[DiagnosticJson, ...] = ()  # what was found in the log
    by_hand: tuple[Decision, ...] = ()  # what a person decided, in the order of the desk
    rubric: str  # digest of the rubric
    digest: str  # of the submission, and of what was decided by hand


class Grade(ShownGrade, frozen=True, kw_only=True):
    """One student's grade, small enough to keep for a whole class; JSON and back gives the same again."""

    title: str  # of the rubric
    fingerprint: Fingerprint | None = None
    """What is kept of the log to compare it with others; None where it cannot be analysed."""
    partner: str = ""  # the partners that the log names

    @property
    def reported_inertia(self) -> float | None:
        """I_zz as reported [kg*m^2]; None if it is not a number."""
        return self.reported.get("value")

    @property
    def ratio(self) -> float | None:
        """Reported I_zz over that of the accepted fit that it comes nearest to [1]; None without one of them."""
        value, own = self.reported_inertia, self.own.get(self.matched or "")
        return value / own["value"] if value is not None and own and own["value"] else None


def to_json(record: Struct) -> str:
    """Write a record as the journal contains it; `from_json` gives the same again, to the last digit."""
    return json.dumps(msgspec.to_builtins(record), allow_nan=False, separators=(",", ":"))


def from_json(text: str | bytes, kind: type[Record]) -> Record:
    """Take a record back from its JSON; raise ValueError where it is none."""
    try:
        return msgspec.json.decode(text, type=kind)
    except msgspec.DecodeError:
        # Half of a surrogate, as of a file's name in another coding, passes only here.
        try:
            return msgspec.convert(json.loads(text), kind)
        except msgspec.ValidationError as error:  # no ValueError in older releases
            raise ValueError(str(error)) from None


def grade_submission(
    submission: Submission, rubric: Rubric, reported: str | None = None, mistake: Mistake | None = None
) -> Grade:
    """Grade one student.

    `rubric`: What is judged. Where the class is the reference, a "reference" mark has no points until `settle`.
    `reported`: I_zz typed in by a person, instead of what was handed in. `mistake`: One in the log, undone first.

    Gives: Status "not graded", and no points, where the log cannot be read or analysed, or a criterion cannot
    be judged. Bad data never raise.
    """
    # The driver of the workers does not need them.
    from gyrodata.analysis import analyze_readings
    from gyrodata.procedure import what_lacks

    if submission.problem is not None:
        return not_graded(submission, rubric, submission.problem)
    try:
        readings, answers, bench = yardsticks.at_bench(submission, rubric.bench)
        if reported is not None:
            answers = replace(answers, inertia=read_reported("inertia", reported))
        if mistake is not None:
            readings = corrected(readings, mistake)
        analysis = analyze_readings(readings, whole=False)
        asked = {ASKS[ask] for criterion in rubric.criteria for ask in criterion.asks}
        lacks = what_lacks(readings, analysis.measurements, analysis, asked) if asked else []
        lacks += [one for one in analysis.diagnostics if one.code == OUTLIER]
    except (GyroError, OSError, ArithmeticError, ValueError) as error:
        found = getattr(error, "diagnostics", ())
        if mistake is None and any(one.code == COLUMNS_EXCHANGED for one in found):
            again = grade_submission(submission, rubric, reported, known_mistakes()["exchanged"])
            if again.d is not None and again.d <= FAR:
                return again
        return not_graded(submission, rubric, _why_not(error), found)
    evidence = replace(_gather(analysis, lacks, answers, rubric, bench), files=submission.members)
    marks = tuple(judge(criterion, evidence) for criterion in rubric.criteria)
    # The runs that look odd are in the analysis already.
    untold = [one for one in lacks if one.code != OUTLIER]
    blank = not_graded(submission, rubric, None, (*analysis.diagnostics, *untold, *answers.diagnostics))
    grade = replace(
        blank,
        marks=marks,
        slips=evidence.slips,
        look=(*blank.look, *_looks(evidence)),
        station=station_of(readings),
        partner=next((text for key, text in readings.metadata.items() if key.lower().startswith("partner")), ""),
        reported={name: getattr(evidence.reported, name) for name in _REPORTED if evidence.reported},
        own={own.name: {"value": own.value, "u": own.u} for own in evidence.own.values},
        inertia=analysis.inertia.value,
        inertia_u=analysis.inertia.u,
        matched=evidence.matched.name if evidence.matched else None,
        d=evidence.d,
        bench=bench,
        scatters=() if times_stated(analysis.measurements) else scatter_of(analysis),
        fingerprint=fingerprint(readings, analysis.measurements),
    )
    return added_up(grade) if rubric.class_reference else _settle_one(grade, rubric, rubric.references, {})


Class = tuple[tuple[Grade, ...], Mapping[str, yardsticks.Reference], Mapping[str, yardsticks.BenchScatter]]
"""Grades, and by station ("all" for every other) what they are held against and how far the readings scatter."""


def settle(grades: Iterable[Grade], rubric: Rubric) -> Class:
    """Give the points that wait for the whole class: those against a reference that the class itself gives.

    `grades`: All of the class, as `grade_submission` or an earlier `settle` gave them. Gives: In the order given; no
    grade depends on that order.
    """
    grades = tuple(grades)
    references, scatters = rubric.references, {}
    if rubric.class_reference:
        known = (grade for grade in grades if grade.inertia is not None)
        references = yardsticks.class_references(
            (grade.station, grade.inertia or 0.0, grade.inertia_u or 0.0) for grade in known
        )
    if rubric.class_scatter and any(criterion.check == "constancy" for criterion in rubric.criteria):
        scatters = yardsticks.class_scatter((grade.station, grade.scatters) for grade in grades)
    return tuple(_settle_one(grade, rubric, references, scatters) for grade in grades), references, scatters


def _settle_one(
    grade: Grade,
    rubric: Rubric,
    references: Mapping[str, yardsticks.Reference],
    scatters: Mapping[str, yardsticks.BenchScatter],
) -> Grade:
    """Judge the criteria that need a reference or the scatter of the class, and sum the points again."""
    if not grade.own:
        return grade
    station = grade.station or "all"
    reference = references.get(station) or references.get("all")
    scatter = scatters.get(station) or scatters.get("all")
    marks = tuple(
        judge_reference(criterion, one, reference)
        if criterion.check == "reference"
        else judge_scatter(criterion, one, grade.scatters, scatter)
        if criterion.check == "constancy" and scatter is not None
        else one
        for criterion, one in zip(rubric.criteria, grade.marks, strict=True)
    )
    zeta = next((one.detail["z"] for one in marks if "z" in one.detail), None)
    return added_up(replace(grade, marks=marks, zeta=zeta if isinstance(zeta, float) else None))


AGREES, MUCH = 5.0, 3.0
"""A log is doubted if the answer is nearer to the reference than the first [standard uncertainties of both], and the
log is more than the second times as far from it as the answer."""

LOOKED_AT = 10.0  # a log whose own I_zz is farther from the reference is worth a look [standard uncertainties of both]


def reconsider(
    grade: Grade,
    submission: Submission,
    rubric: Rubric,
    references: Mapping[str, yardsticks.Reference],
    scatters: Mapping[str, yardsticks.BenchScatter],
    reported: str | None,
) -> Grade:
    """Look for a mistake in a log whose own I_zz is far from the reference.

    `grade`: As `settle` gave it. `reported`: As `grade_submission` has it. Gives: Where the answer agrees with the
    reference, and follows from the log once a known mistake in it is undone, the grade for that; else a line for a
    person to look at, if nothing else explains the log.
    """
    from gyrodata.analysis import analyze_readings

    reference = references.get(grade.station or "all") or references.get("all")
    if reference is None or not grade.own or not grade.inertia:
        return grade
    share = (grade.inertia_u or 0.0) / abs(grade.inertia)

    def away(value: float, u: float) -> float:
        return abs(value - reference.inertia) / (math.hypot(u * value, reference.u) or 1e-9 * reference.inertia)

    far, value = away(grade.inertia, share), grade.reported_inertia
    of_log = value is not None and (grade.d or 0.0) > FAR and away(value, min(share, yardsticks.COARSEST)) <= AGREES
    of_log = of_log and abs(grade.inertia - reference.inertia) > MUCH * abs((value or 0.0) - reference.inertia)
    if not of_log and (far <= LOOKED_AT or grade.slips or (grade.d or 0.0) > FAR):
        return grade
    try:
        readings = yardsticks.at_bench(submission, rubric.bench)[0]
        measured = analyze_readings(readings, whole=False).measurements
    except GyroError:
        return grade  # it has changed since it was graded; the next run sees that

    def mistakes(expected: float) -> list[Mistake]:
        found = explaining_mistakes(readings, measured, abs(grade.inertia or 0.0), expected)
        return [kind for kind, _ in found if not kind.kind.startswith("ball_")]

    if value and of_log:
        # Of headers that leave the same factor, the one without which the readings are of the usual size.
        left = [(unusual(corrected(readings, kind)), kind) for kind in mistakes(value)]
        likely = [kind for count, kind in sorted(left, key=lambda one: one[0]) if count <= unusual(readings)]
        factor = grade.inertia / value
        unknown = f"the log gives an I_zz that is {factor_text(factor)} the answer, which agrees with the reference"
        if grade.slips:
            likely.append(Mistake("", torque=factor, log=unknown, remedy="check the unit in each header of the log"))
        for kind in likely:
            again = grade_submission(submission, rubric, reported, kind)
            if again.d is not None and again.d <= FAR:
                known = {name: getattr(grade, name) for name in ("name", "section", "station", "fingerprint")}
                look = (*again.look, *([unknown] if kind.log == unknown else []))
                return _settle_one(replace(again, look=look, **known), rubric, references, scatters)
        return grade
    times = factor_text(grade.inertia / reference.inertia)
    told = f"the log's own I_zz is {far:.3g} standard uncertainties from the reference, {times} it"
    marks = grade.marks
    if kinds := mistakes(reference.inertia):
        why = f"one mistake in the log that would explain this factor: {' or '.join(kind.log for kind in kinds)}"
        told = f"{told}; {why}"
        marks = tuple(
            replace(one, reason=f"{one.reason}; {why}; {kinds[0].remedy}") if one.check == "reference" else one
            for one in marks
        )
    return replace(grade, marks=marks, look=(*grade.look, told))


def added_up(grade: Grade) -> Grade:
    """Return the sum of the points, or why it is missing; open marks give a sum so far."""
    open_marks = [one for one in grade.marks if one.points is None]
    reasons = dict.fromkeys(one.reason for one in open_marks if not one.waits)
    if reasons:
        return replace(grade, status="not graded", why="; ".join(reasons) if grade.own else grade.why, points=None)
    total = sum(one.points or 0.0 for one in grade.marks) - grade.late_deduction
    status: Status = "so far" if open_marks else "graded"
    return replace(grade, status=status, why=None, points=round(max(0.0, total), 2))


def points_text(points: float | None) -> str:
    """Write points: "6", "4.35", or "–" where there are none yet."""
    return "–" if points is None else f"{points:.2f}".rstrip("0").rstrip(".")


def two_decimals(points: float | None) -> str:
    """Write points with two decimals, as gradebooks compare them, and never with a mark between thousands."""
    return "" if points is None else f"{points:.2f}"


# --- what there is to judge ---------------------------------------------------------------------------------


def _gather(
    analysis: Analysis, lacks: list[Diagnostic], answers: Answers, rubric: Rubric, bench: tuple[str, ...]
) -> Evidence:
    """Hold the report against the student's own runs."""
    own, reported = yardsticks.own_runs(analysis, rubric.accept), answers.inertia
    evidence = Evidence(
        analysis=analysis,
        lacks=lacks,
        own=own,
        reported=reported,
        absent_is_zero=answers.inertia is None and rubric.no_report == "zero",
        carries=any(criterion.check == "own_data" for criterion in rubric.criteria),
        bench=bench,
    )
    if reported is None or reported.value is None:
        return evidence
    step = reported.step or 0.0
    slips = find_slips(reported.value, step, own, analysis.readings, analysis.measurements)
    matched = yardsticks.nearest(own.values, reported.value)
    if slips:
        matched = next(value for value in own.values if value.name == slips[0].fit)
    d = yardsticks.distance(reported.value, matched.value, step, own.yardstick)
    return replace(evidence, matched=matched, d=d, slips=slips)


def _looks(evidence: Evidence) -> list[str]:
    """Items that need review by a person."""
    found = []
    # Two that leave the same factor cost the same: nothing is to be decided.
    if any(abs(slip.factor / evidence.factor - 1) > SAME for slip in evidence.slips):
        kinds = ", ".join(slip.kind for slip in evidence.slips)
        found.append(f"several known slips explain the reported I_zz equally well: {kinds}")
    if evidence.d is not None and evidence.d > FAR and not evidence.slips:
        found.append(
            f"the reported I_zz is {evidence.d:.3g} u from the student's own runs, and no known slip explains it"
        )
    return found


def station_of(readings: Readings) -> str | None:
    """Take the station that a log names, as a rubric names it."""
    text = next((value for key, value in readings.metadata.items() if key.strip().lower() == "station"), "")
    return yardsticks.station_key(text) or None


# --- not graded ---------------------------------------------------------------------------------------------


def not_graded(
    submission: Submission, rubric: Rubric, why: str | None, diagnostics: Iterable[Diagnostic] = ()
) -> Grade:
    """Make the grade of a submission with nothing judged but the lateness: no points, and no zero."""
    keys = {"student": submission.student, "name": submission.name, **submission.ids}
    stamps = submission.late, submission.late_seconds, submission.submitted
    late = judge_lateness(rubric.late, keys, *stamps, rubric.points)
    return Grade(
        student=submission.student,
        name=submission.name,
        why=why,
        out_of=rubric.points,
        marks=tuple(mark(criterion, None, "not judged", {}) for criterion in rubric.criteria),
        look=(late.reason,) if late.look else (),
        reported={},
        own={},
        late_seconds=late.seconds,
        late_deduction=late.deduct,
        late_reason=late.reason,
        diagnostics=tuple(diagnostic.to_dict() for diagnostic in diagnostics),
        title=rubric.title,
        rubric=rubric.digest,
        digest=submission.digest,
    )


def _why_not(error: Exception) -> str:
    """Say in one sentence what stops the analysis."""
    if isinstance(error, OSError):
        return f"the submission cannot be read: {error.strerror or type(error).__name__}"
    if not isinstance(error, GyroError):
        # Numbers on which the analysis itself breaks are no reason to lose the class, nor to give this one a zero.
        return f"the analysis broke on these numbers ({type(error).__name__}: {error})"
    faults = [one for one in error.diagnostics if one.severity == "error"]
    if not faults:
        return "the log cannot be analysed"
    where = f"line {faults[0].line}: " if faults[0].line else ""
    more = f", and {len(faults) - 1} more" if len(faults) > 1 else ""
    kind = "the log cannot be analysed" if isinstance(error, LogError) else "the log cannot be read"
    return f"{kind}: {where}{faults[0].message}{more}"
