"""Grade one student: from a submission to marks with their reasons.

Read the log, analyse it, compute the accepted fits of its runs, compare the report with
them after correcting a common mistake, judge each criterion, and subtract the deduction
for being late. Nothing in a submission raises an error: what cannot be judged has no
points, which is not the same as zero, and the grade is "not graded" until a person has
looked.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Annotated, Literal, NamedTuple, TypedDict

from msgspec import Meta, Struct, field
from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.base.errors import (
    Diagnostic,
    DiagnosticJson,
    GyroError,
    InputError,
    LogError,
    shown,
)
from gyrodata.fitting import times_stated
from gyrodata.grading import criteria, yardsticks
from gyrodata.grading.criteria import Evidence, Mark
from gyrodata.grading.forensics import Fingerprint, fingerprint
from gyrodata.grading.rubric import Rubric, judge_lateness
from gyrodata.grading.stated import unusual_turns
from gyrodata.grading.submissions import Submission, submission_of
from gyrodata.grading.submissions.answers import Answers, partners_in
from gyrodata.grading.submissions.archives import WORKBOOKS, ending
from gyrodata.judging import mistakes
from gyrodata.judging.mistakes import Mistake
from gyrodata.readings import Readings, listing, read_reported
from gyrodata.reporting.values import factor_text, inertia_text
from gyrodata.results import HandIn, Options

# a report farther than this from every accepted fit [u], without a common mistake,
# needs a look
FAR = 3.0

TOO_WIDE = "the log states an uncertainty far over the usual, so the usual one is used"

# a larger scatter of φ̇ψ̇ within a torque, as a share, is not that of measured times
WILD = 0.3

Status = Literal["graded", "so far", "on hold", "excused", "not graded"]


class Decision(Struct, frozen=True):
    """One decision by a person about one student."""

    what: str  # id of a criterion, or one of `ledger.WORDS`
    value: str  # as written
    by: str
    why: str

    @property
    def told(self) -> str:
        """Why, and who says so."""
        return f"{self.why} ({self.by})".lstrip() if self.by else self.why

    def __str__(self) -> str:
        return (
            f"{f'{self.what} {self.value}'.rstrip()}{':' if self.why else ''} "
            f"{self.told}"
        ).rstrip()


class Reported(TypedDict, total=False):
    """I_zz as the student reports it; without any key if nothing is reported."""

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
    points: float | None = (
        # what counts, lateness taken off, two decimals; None if nothing counts yet
        None
    )
    out_of: float
    marks: tuple[Mark, ...] = ()
    """One for each criterion, in the rubric's order; points null: it could not be
    judged, which is not zero."""
    slips: tuple[
        yardsticks.Slip, ...
    ] = ()  # common mistakes that explain the report, the most likely first
    look: tuple[str, ...] = ()  # what a person should look at although it is graded
    station: str | None = None
    log_of: str = ""  # the partner or group whose log it is; "" for an own log
    section: str = ""  # of the roster
    reported: Annotated[
        Reported,
        Meta(
            extra_json_schema={"anyOf": [{"required": _REPORTED}, {"maxProperties": 0}]}
        ),
    ]
    own: Mapping[str, OwnFit]
    """Each accepted fit of the student's own runs, by its name."""
    inertia: float | None = None
    """I_zz that the student's own runs give by the recommended fit, accepted or not
    [kg*m^2]."""
    inertia_u: float | None = None  # its standard uncertainty [kg*m^2]
    matched: str | None = (
        None  # the accepted fit nearest to the report, after correcting a mistake
    )
    d: float | None = None  # distance of the report, as reported, from that fit [u]
    bench: tuple[
        str, ...
    ] = ()  # values that the log does not state, from the rubric: "u_time 0.3 s"
    scatters: tuple[tuple[float, int], ...] = ()
    """χ² of φ̇ψ̇ within each torque and its degrees of freedom, by the usual
    uncertainties; empty with other ones."""
    # Zeta score of ISO 13528: distance of the corrected value from the reference, over
    # the u of both.
    zeta: float | None = field(default=None, name="z")
    late_seconds: float | None  # late by this [s]; None if it is not known
    late_deduction: float  # [points]
    late_reason: str
    diagnostics: tuple[DiagnosticJson, ...] = ()  # what was found in the log
    by_hand: tuple[
        Decision, ...
    ] = ()  # decisions of a person, in the order of desk.csv
    rubric: str  # digest of the rubric
    digest: str  # of the submission and of the decisions by hand


class Grade(ShownGrade, frozen=True, kw_only=True):
    """One student's grade, small enough to keep for a whole class.

    JSON and back gives the same again.
    """

    title: str  # of the rubric
    fingerprint: Fingerprint | None = None
    """Summary of the log to compare it with others; None if the log cannot be analysed.
    """
    # the partners that the log names, and behind "~" all words that may be a name
    partner: str = ""

    @property
    def reported_inertia(self) -> float | None:
        """I_zz as reported [kg*m^2]; None if it is not a number."""
        return self.reported.get("value")

    @property
    def ratio(self) -> float | None:
        """Reported I_zz over that of the nearest accepted fit [1]; None without one of them."""
        value, own = self.reported_inertia, self.own.get(self.matched or "")
        return (
            value / own["value"] if value is not None and own and own["value"] else None
        )


def grade_submission(
    submission: Submission,
    rubric: Rubric,
    reported: str | None = None,
    mistake: Mistake | None = None,
) -> Grade:
    """Grade one student.

    A submission that cannot be judged is "not graded", and never raises an error.

    If the class is the reference, a "reference" mark has no points until `settle`.
    `reported`: I_zz typed in by a person, instead of the submitted value. `mistake`: A
    mistake in the log that is corrected first.
    """
    # The main process only distributes the work, and does not need these.
    from gyrodata.analysis import check_fit, fit_log
    from gyrodata.judging.procedure import what_lacks

    if submission.problem is not None:
        return not_graded(submission, rubric, submission.problem)
    wide = ""
    try:
        readings, answers, bench, too_wide = yardsticks.at_bench(
            submission, rubric.bench
        )
        wide = f"{TOO_WIDE}: {', '.join(too_wide)}" if too_wide else ""
        answer = (
            answers.inertia if reported is None else read_reported("inertia", reported)
        )
        meant = yardsticks.corrected(readings, mistake) if mistake else readings
        analysis = check_fit(fit_log(meant, Options()))
        asked = {
            criteria.ASKS[ask]
            for criterion in rubric.criteria
            for ask in criterion.asks
        }
        lacks = (
            what_lacks(analysis.readings, analysis.measurements, analysis.lab, asked)
            if asked
            else []
        )
    except (GyroError, ArithmeticError, ValueError) as error:
        why = "; ".join(filter(None, [_why_not(error), wide]))
        return not_graded(submission, rubric, why, getattr(error, "diagnostics", ()))
    # The suspected outliers are in the analysis already.
    blank = not_graded(
        submission,
        rubric,
        None,
        (*analysis.diagnostics, *lacks, *answers.diagnostics, *answers.unread),
    )
    lacks += [one for one in analysis.diagnostics if one.code == diagnostics.OUTLIER]
    own = yardsticks.own_runs(analysis, rubric.accept)
    evidence = Evidence(
        rubric,
        analysis,
        lacks,
        own,
        answer,
        submission.members,
        bench,
        unread=tuple(one.message for one in answers.unread),
    )
    if answer is not None and (value := answer.value) is not None:
        step = answer.step or 0.0
        # Many mistakes agree with an answer of one digit by chance: none is named.
        slips: tuple[yardsticks.Slip, ...] = ()
        if (answer.digits or 0) > 1:
            slips = tuple(
                yardsticks.find_slips(
                    value, step, own, analysis.readings, analysis.measurements
                )
            )
        named = [one for one in own.values if slips and one.name == slips[0].fit]
        matched = min(named or own.values, key=lambda one: abs(one.value - value))
        d = yardsticks.distance(value, matched.value, step, own.yardstick)
        cells = reported is None and ending(answers.file) in WORKBOOKS
        evidence = replace(
            evidence, matched=matched, d=d, slips=slips, from_cells=cells
        )
    questions = _questions(answers, evidence) if reported is None else []
    own_log = None if submission.log_of else readings
    doubts = filter(None, [*questions, wide])
    grade = replace(
        blank,
        marks=tuple(
            criteria.judge(criterion, evidence) for criterion in rubric.criteria
        ),
        slips=evidence.slips,
        look=(*blank.look, *_looks(evidence), *doubts),
        station=station_of(readings),
        partner=submission.partner or partners_in(own_log, submission.documents),
        reported={name: getattr(answer, name) for name in _REPORTED if answer},
        own={one.name: {"value": one.value, "u": one.u} for one in own.values},
        inertia=analysis.inertia.value,
        inertia_u=analysis.inertia.u,
        matched=evidence.matched.name if evidence.matched else None,
        d=evidence.d if evidence.matched else None,
        bench=bench,
        scatters=()
        if times_stated(analysis.measurements)
        else criteria.scatter_of(analysis),
        fingerprint=fingerprint(readings, analysis.measurements),
    )
    return (
        added_up(grade)
        if rubric.class_reference
        else _settle_one(grade, rubric, rubric.references, {})
    )


References = Mapping[str, yardsticks.Reference]
Scatters = Mapping[str, yardsticks.BenchScatter]
"""By station; "all" is for all other stations."""


def settle(
    grades: Sequence[Grade], rubric: Rubric
) -> tuple[tuple[Grade, ...], References, Scatters]:
    """Give the points that need the whole class, because the class is the reference.

    `grades`: All grades of the class, as `grade_submission` or an earlier `settle`
    returned them. Returns the grades in the same order, and what they are compared
    with. No grade depends on the order.
    """
    references, scatters = rubric.references, {}
    if rubric.class_reference:
        # A log counts once, however many students it is of.
        known = {
            one.log_of or one.student: (one.station, one.inertia, one.inertia_u or 0.0)
            for one in grades
            if one.inertia is not None
        }
        references = yardsticks.class_references(known.values())
    if "from" in rubric.bench and any(
        criterion.check == "constancy" for criterion in rubric.criteria
    ):
        by_log = {one.log_of or one.student: one for one in grades}
        scatters = yardsticks.class_scatter(
            (grade.station, grade.scatters) for grade in by_log.values()
        )
    return (
        tuple(_settle_one(grade, rubric, references, scatters) for grade in grades),
        references,
        scatters,
    )


def _settle_one(
    grade: Grade, rubric: Rubric, references: References, scatters: Scatters
) -> Grade:
    """Judge the criteria that need a reference or the scatter of the class.

    The points are then added up again.
    """
    if not grade.own:
        return grade
    reference = yardsticks.of_station(references, grade.station)
    scatter = yardsticks.of_station(scatters, grade.station)
    marks = []
    for criterion, one in zip(rubric.criteria, grade.marks, strict=True):
        if criterion.check == "reference":
            one = criteria.judge_reference(criterion, one, reference)
        elif criterion.check == "constancy" and scatter is not None:
            one = criteria.judge_scatter(criterion, one, grade.scatters, scatter)
        marks.append(one)
    zeta = next((one.detail["z"] for one in marks if "z" in one.detail), None)
    return added_up(
        replace(
            grade, marks=tuple(marks), zeta=zeta if isinstance(zeta, float) else None
        )
    )


AGREES, MUCH = 5.0, 3.0
"""A log is doubted if the answer is closer to the reference than the first [standard
uncertainties of both], and the distance of the log is more than the second times that
of the answer."""

# a log whose I_zz is farther from the reference needs a look [standard uncertainties of
# both]
LOOKED_AT = 10.0


class _Doubt(NamedTuple):
    """How a log disagrees with the reference."""

    reference: yardsticks.Reference
    inertia: float  # that the log gives [kg*m^2]
    value: float  # as reported [kg*m^2]; 0 without a number
    far: (
        float  # distance of the log from the reference [standard uncertainties of both]
    )
    wrong_log: bool  # the answer agrees with the reference, and the log does not


def _doubt(grade: Grade, references: References) -> _Doubt | None:
    """Compare the I_zz of a log with the reference.

    None if there is nothing to look for in the log.
    """
    reference = yardsticks.of_station(references, grade.station)
    if reference is None or not grade.own or not grade.inertia:
        return None
    inertia, value, disagree = (
        grade.inertia,
        grade.reported_inertia or 0.0,
        (grade.d or 0.0) > FAR,
    )
    share = (grade.inertia_u or 0.0) / abs(inertia)
    far, away = (
        reference.zeta(inertia, share * inertia),
        abs(inertia - reference.inertia),
    )
    near = reference.zeta(value, min(share, yardsticks.COARSEST) * value) <= AGREES
    wrong_log = disagree and near and away > MUCH * abs(value - reference.inertia)
    if not wrong_log and (disagree or far <= LOOKED_AT):
        return None
    return _Doubt(reference, inertia, value, far, wrong_log)


def is_doubtful(grade: Grade, references: References) -> bool:
    """Return whether `reconsider` would look into the log."""
    return _doubt(grade, references) is not None


def reconsider(
    grade: Grade,
    submission: Submission,
    rubric: Rubric,
    references: References,
    scatters: Scatters,
    typed: str | None,
) -> Grade:
    """Look for a mistake in a log whose own I_zz is far from the reference.

    `grade`: As `settle` returned it. `typed`: I_zz typed in by a person. If the answer
    agrees with the reference, and follows from the log after a known mistake in the log
    is corrected, the grade for the corrected log is returned. Otherwise a person is
    asked to look, unless the answer is wrong too: then it tells how the student has
    worked.
    """
    from gyrodata.analysis import fit_log

    doubt = _doubt(grade, references)
    if doubt is None:
        return grade
    reference, inertia, value, far, wrong_log = doubt
    try:
        readings = yardsticks.at_bench(submission, rubric.bench)[0]
        measured = fit_log(readings, Options()).measurements
    except GyroError:
        return grade  # it has changed since it was graded; the next run sees that
    found = mistakes.explaining_mistakes(
        readings, measured, abs(inertia), value if wrong_log else reference.inertia
    )
    kinds = [kind for kind, _ in found if not kind.kind.startswith("ball_")]
    if wrong_log:
        # Several headers may explain the same factor: the first one tried leaves
        # readings of the usual size.
        kinds.sort(
            key=lambda kind: yardsticks.unusual(yardsticks.corrected(readings, kind))
        )
        again = (grade_submission(submission, rubric, typed, kind) for kind in kinds)
        known = {
            name: getattr(grade, name)
            for name in ("name", "section", "station", "fingerprint")
        }
        right = next(
            (
                replace(one, **known)
                for one in again
                if one.d is not None and one.d <= FAR
            ),
            None,
        )
        if right is not None:
            return _settle_one(right, rubric, references, scatters)
    why = (
        f"one mistake in the log that would explain this factor: "
        f"{' or '.join(kind.log for kind in kinds)}"
    )
    told = (
        f"the log's own I_zz is {far:.3g} standard uncertainties from the reference, "
    )
    told += (
        f"{factor_text(inertia / reference.inertia)} it{f'; {why}' if kinds else ''}"
    )
    more = f"; {why}; {kinds[0].remedy}" if kinds else ""
    marks = tuple(
        replace(one, reason=one.reason + more * (one.check == "reference"))
        for one in grade.marks
    )
    return replace(grade, marks=marks, look=(*grade.look, told))


def added_up(grade: Grade) -> Grade:
    """Add up the points, or say why there is no sum.

    Marks that wait for a person give a sum so far.
    """
    open_marks = [one for one in grade.marks if one.points is None]
    reasons = dict.fromkeys(one.reason for one in open_marks if not one.waits)
    if reasons:
        return replace(
            grade,
            status="not graded",
            why="; ".join(reasons) if grade.own else grade.why,
            points=None,
        )
    total = sum(one.points or 0.0 for one in grade.marks) - grade.late_deduction
    status: Status = "so far" if open_marks else "graded"
    return replace(grade, status=status, why=None, points=round(max(0.0, total), 2))


def points_text(points: float | None) -> str:
    """Write points: "6", "4.35", or "–" where there are none yet."""
    return "–" if points is None else f"{points:.2f}".rstrip("0").rstrip(".")


def two_decimals(points: float | None) -> str:
    """Write points with two decimals, as gradebooks compare them.

    The text never contains a mark between thousands.
    """
    return "" if points is None else f"{points:.2f}"


def _questions(answers: Answers, evidence: Evidence) -> list[str]:
    """Return what is to be asked about the answer."""
    own = evidence.own
    rivals = [
        rival.question
        for rival in answers.rivals
        if evidence.matched is not None
        and min(
            yardsticks.distance(rival.value, one.value, 0.0, own.yardstick)
            for one in own.values
        )
        > evidence.d
    ]
    return [*answers.questions, *rivals[:1]]


def _looks(evidence: Evidence) -> list[str]:
    """Return what a person has to look at."""
    found = []
    # Two mistakes with the same factor cost the same: nothing needs a decision.
    if any(
        abs(slip.factor / evidence.factor - 1) > yardsticks.SAME
        for slip in evidence.slips
    ):
        words = " or ".join(slip.words for slip in evidence.slips)
        found.append(
            f"several mistakes explain the reported I_zz equally well: {words}"
        )
    elif any("+" in slip.kind for slip in evidence.slips):
        found.append(
            f"only two mistakes at once explain the reported I_zz: {evidence.slips[0].words}"
        )
    elif evidence.slips:
        found += _doubts_of_slip(evidence)
    found += filter(None, [unusual_turns(evidence.analysis.readings)])
    spread = criteria.spread_of(evidence.analysis) or 0.0
    if spread > WILD:
        found.append(
            f"the times do not follow from the spins: φ̇ψ̇ scatters by "
            f"{100 * spread:.2g} % within a torque"
        )
    if evidence.d > FAR and not evidence.slips:
        told = f"the reported I_zz is {evidence.d:.3g} u from the student's own runs"
        found.append(f"{told}, and no common mistake explains it")
    return found


SAME_VALUE, SAME_U = 0.001, 0.1
"""An answer with a mistake has the value and the uncertainty of a fit with this
mistake, but for rounding and these shares of them. Of answers at random, one in thirty
is near a fit with some mistake, but one in 200 is so near."""


def _doubts_of_slip(evidence: Evidence) -> list[str]:
    """Ask about a mistake that may agree with the report by chance."""
    slip, log = evidence.slips[0], evidence.analysis
    known = yardsticks.possible_mistakes(evidence.own, log.readings, log.measurements)
    fits = yardsticks.with_mistake(known[slip.kind], evidence.own)
    if not any(_is_exactly(evidence, one) for one in fits):
        return [
            f"a mistake explains the reported I_zz, but not to its digits: {slip.words}"
        ]
    if all(known[one.kind].rank > 0 for one in evidence.slips):
        return [f"only a rare mistake explains the reported I_zz: {slip.words}"]
    return []


def _is_exactly(evidence: Evidence, fit: yardsticks.OwnValue) -> bool:
    """Return whether the value and the uncertainty that are reported are those of a fit."""
    reported, value, _ = evidence.given
    if (
        abs(value - fit.value)
        > SAME_VALUE * abs(fit.value) + (reported.step or 0.0) / 2
    ):
        return False
    if reported.u is None:
        return True
    return (
        fit.u is not None
        and abs(reported.u - fit.u) <= SAME_U * fit.u + (reported.u_step or 0.0) / 2
    )


def station_of(readings: Readings) -> str | None:
    """Return the station that a log names, in the form that a rubric uses."""
    text = next(
        (
            value
            for key, value in readings.metadata.items()
            if key.strip().lower() == "station"
        ),
        "",
    )
    return yardsticks.station_key(text) or None


# --- not graded ---


def not_graded(
    submission: Submission,
    rubric: Rubric,
    why: str | None,
    found: Iterable[Diagnostic] = (),
) -> Grade:
    """Return the grade of a submission of which only the lateness is judged.

    This grade has no points, which is not the same as zero points.
    """
    late = judge_lateness(rubric.late, submission, rubric.points)
    return Grade(
        student=submission.student,
        name=submission.name,
        why=why,
        out_of=rubric.points,
        marks=tuple(
            criteria.mark(criterion, "not judged", {}, None)
            for criterion in rubric.criteria
        ),
        look=(late.reason,) if late.look else (),
        reported={},
        own={},
        late_seconds=late.seconds,
        late_deduction=late.deduct,
        late_reason=late.reason,
        diagnostics=tuple(diagnostic.to_dict() for diagnostic in found),
        title=rubric.title,
        rubric=rubric.digest,
        digest=submission.digest,
        log_of=submission.log_of,
        partner=submission.partner,
    )


def _why_not(error: Exception) -> str:
    """Say in one sentence why the analysis stopped."""
    if not isinstance(error, GyroError):
        # Numbers that stop the analysis itself must not stop the class, nor give this
        # student a zero.
        return (
            f"the analysis failed with these numbers ({type(error).__name__}: {error})"
        )
    done = "analysed" if isinstance(error, LogError) else "read"
    first, *more = [one for one in error.diagnostics if one.severity == "error"]
    where = f"line {first.line}: " if first.line else ""
    return (
        f"the log cannot be {done}: "
        f"{where}{first.message}{f', and {len(more)} more' if more else ''}"
    )


# --- ``gyro check --hand-in`` ---


def read_hand_in(
    paths: Sequence[Path],
) -> tuple[Readings, HandIn, tuple[Diagnostic, ...]]:
    """Read a student's files, folder or zip as `grade_submission` does.

    The answer in the submission is reported as well.
    """
    submission, told = submission_of(paths)
    if submission.problem is not None:
        raise InputError.named("no_log_here", paths[0].name, why=submission.problem)
    readings, answers = submission.read()
    reported, station = (
        answers.inertia or read_reported("inertia", ""),
        station_of(readings),
    )
    file, text = answers.file or None, reported.text or None
    one = HandIn(
        text=text,
        inertia=reported.value,
        u=reported.u,
        file=file,
        line=reported.line,
        station=station,
    )
    # The place of the answer is reported once.
    others = [
        found
        for found in (*answers.diagnostics, *answers.unread)
        if found.code != diagnostics.ANSWER_ELSEWHERE
    ]
    log, name, more = (
        shown(PurePosixPath(submission.log_file or "").name),
        "answer_missing",
        "",
    )
    if one.inertia is not None:
        place = f"{one.file}, line {one.line}" if one.line else one.file
        said = f"I_zz = {inertia_text(one.inertia, one.u)}, read from {place}"
        doubts = (
            "no uncertainty is found with it" if one.u is None else "",
            reported.problem,
        )
        name = "answer_read"
        what = "; ".join(
            filter(None, [said, *doubts, f"station: {station}" if station else ""])
        )
    elif answers.inertia is None:
        read = [one for one in (submission.log_name, *submission.report_names) if one]
        unread = [one for one in submission.members if one not in read]
        here, left = (
            listing(sorted(shown(PurePosixPath(one).name) for one in some))
            for some in (read, unread)
        )
        what = f"no I_zz is found in {here}{f'; not read: {left}' if unread else ''}"
    else:
        what = f"the answer cannot be read: {reported.problem}"
        more = ", and take its other lines with an I_zz out" if one.file == log else ""
    file = file or (log if name == "answer_missing" else "")
    return (
        readings,
        one,
        (
            *told,
            *others,
            Diagnostic.named(name, file, one.line, told=what, log=log, more=more),
        ),
    )
