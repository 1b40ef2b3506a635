"""Grade one student: from a submission to marks with their reasons.

Read the log, analyse it, compute the accepted fits of its runs, compare the report with
them after correcting a common mistake, judge each criterion, and subtract the deduction
for being late. Nothing in a submission raises an error: what cannot be judged has no
points, which is not the same as zero, and the grade is "not graded" until a person has
looked.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypedDict

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
from gyrodata.grading.stated import list_stated, unusual_turns, with_usual
from gyrodata.grading.stations import (
    DayValue,
    class_references,
    day_values,
    each_log_once,
)
from gyrodata.grading.submissions import Submission, submission_of
from gyrodata.grading.submissions.answers import Answers, partners_in
from gyrodata.grading.submissions.archives import WORKBOOKS, ending
from gyrodata.judging import mistakes
from gyrodata.judging.mistakes import Mistake
from gyrodata.readings import Readings, listing, read_reported
from gyrodata.readings import Reported as ReportedValue
from gyrodata.readings.names import STATION_WORDS, squeeze
from gyrodata.reporting.values import factor_text, inertia_text
from gyrodata.results import HandIn, Options

if TYPE_CHECKING:
    from gyrodata.results import FittedLog

# a report farther than this from every accepted fit [u], without a common mistake,
# needs a look
FAR = 3.0

TOO_WIDE = "the log states uncertainties far over the usual, so the usual ones are used"
MOST_WIDER, MOST_ROUGHER = 1.5, 5.0
"""Uncertainties that a log states are used unless they widen u of I_zz by more than the
first factor, or those of φ̇ψ̇ by more than the second; and so are its days."""

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
    def signed_why(self) -> str:
        """Why, and who says so."""
        if not self.by:
            return self.why
        return f"{self.why} ({self.by})".lstrip()

    def __str__(self) -> str:
        decision = f"{self.what} {self.value}".rstrip()
        colon = ":" if self.why else ""
        return f"{decision}{colon} {self.signed_why}".rstrip()


class Reported(TypedDict, total=False):
    """I_zz as the student reports it; without any key if nothing is reported."""

    text: str
    value: float | None
    """[kg*m^2]"""
    u: float | None
    """[kg*m^2]"""
    line: int | None
    file: str | None
    """The file with the answer; null if a person typed it."""


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
    days: tuple[DayValue, ...] = ()  # I_zz on each day that the log names

    @property
    def reported_inertia(self) -> float | None:
        """I_zz as reported [kg*m^2]; None if it is not a number."""
        return self.reported.get("value")

    @property
    def ratio(self) -> float | None:
        """Reported I_zz over that of the nearest fit [1]; None without one of them."""
        value = self.reported_inertia
        own = self.own.get(self.matched or "")
        if value is None or not own or not own["value"]:
            return None
        return value / own["value"]


def grade_submission(
    submission: Submission,
    rubric: Rubric,
    reported: str | None = None,
    mistake: Mistake | None = None,
) -> Grade:
    """Grade one student.

    A submission that cannot be judged is "not graded", and never raises an error.

    If the class is the reference, a "reference" mark has no points until it is settled.
    `reported`: I_zz typed in by a person, instead of the submitted value. `mistake`: A
    mistake in the log that is corrected first.
    """
    if submission.problem is not None:
        return not_graded(submission, rubric, submission.problem)
    try:
        bench = yardsticks.at_bench(submission, rubric.bench)
        readings = bench.readings
        if mistake is not None:
            readings = yardsticks.corrected(readings, mistake)
        analysis, wide = _analysed(readings, rubric)
    except (GyroError, ArithmeticError, ValueError) as error:
        notes = getattr(error, "diagnostics", ())
        return not_graded(submission, rubric, _why_not(error), notes)
    lacks = _lacks(analysis, rubric)
    answers = bench.answers
    if reported is not None:
        answers = Answers(read_reported("inertia", reported), unread=answers.unread)
    evidence = _evidence(submission, bench, answers, (analysis, lacks), rubric)
    doubts = [*_looks(evidence), *answers.questions, wide]
    # The suspected outliers are in the analysis already.
    diagnostics_of_all = (
        *analysis.diagnostics,
        *lacks,
        *bench.answers.diagnostics,
        *answers.unread,
    )
    grade = replace(
        not_graded(submission, rubric, None, diagnostics_of_all),
        **_values_of(evidence),
        reported=_reported(answers),
        bench=bench.added,
        station=station_of(bench.readings),
        partner=submission.partner or _partners_of(submission, bench.readings),
        fingerprint=fingerprint(bench.readings, analysis.measurements),
    )
    grade = replace(grade, look=(*grade.look, *filter(None, doubts)))
    if rubric.class_reference:
        return added_up(grade)
    return Standard(rubric, rubric.references, {}).settled(grade)


def _analysed(readings: Readings, rubric: Rubric) -> tuple[FittedLog, str]:
    """Analyse a log, by the usual uncertainties if its own ones widen u far.

    Also return the question about them, or "".
    """
    # The main process only distributes the work, and does not need this.
    from gyrodata.analysis import check_fit, fit_log

    stated = list_stated(readings)
    if not stated:
        return check_fit(fit_log(readings, Options())), ""
    usual_readings = with_usual(readings, rubric.bench)
    usual = fit_log(usual_readings, Options())
    one_day = usual
    if readings.blocks:
        # The residual torque of each day widens u, too.
        one_day = fit_log(replace(usual_readings, blocks=()), Options())
    with suppress(GyroError):
        own = check_fit(fit_log(readings, Options()))
        if not _widen(own, one_day) and not _roughen(own, usual):
            return own, ""
    return check_fit(one_day), f"{TOO_WIDE}: {listing(stated)}"


def _widen(own: FittedLog, usual: FittedLog) -> bool:
    """Return whether a log's own statements make u of I_zz far too large."""
    u = own.inertia.u or math.inf
    usual_u = usual.inertia.u or 0.0
    return u > MOST_WIDER * usual_u


def _roughen(own: FittedLog, usual: FittedLog) -> bool:
    """Return whether a log's own uncertainties hide the scatter of its runs."""
    scatter = sum(chi2 for chi2, _ in criteria.scatter_of(own))
    usual_scatter = sum(chi2 for chi2, _ in criteria.scatter_of(usual))
    return MOST_ROUGHER**2 * scatter < usual_scatter


def _lacks(analysis: FittedLog, rubric: Rubric) -> list[Diagnostic]:
    """Return what a log lacks for the procedure that the rubric asks for."""
    from gyrodata.judging.procedure import what_lacks

    asked = {
        criteria.ASKS[ask] for criterion in rubric.criteria for ask in criterion.asks
    }
    if not asked:
        return []
    return what_lacks(analysis.readings, analysis.measurements, analysis.lab, asked)


def _partners_of(submission: Submission, readings: Readings) -> str:
    """Return the partners that a student names; the log of a partner does not count."""
    own_log = None if submission.log_of else readings
    return partners_in(own_log, submission.documents)


def _evidence(
    submission: Submission,
    bench: yardsticks.AtBench,
    answers: Answers,
    log: tuple[FittedLog, list[Diagnostic]],
    rubric: Rubric,
) -> Evidence:
    """Collect what the criteria look at, and compare the answer with the own runs."""
    analysis, lacks = log
    notes = analysis.diagnostics
    outliers = [note for note in notes if note.code == diagnostics.OUTLIER]
    evidence = Evidence(
        rubric,
        analysis,
        [*lacks, *outliers],
        yardsticks.own_runs(analysis, rubric.accept),
        answers.inertia,
        submission.members,
        bench.added,
        from_cells=ending(answers.file) in WORKBOOKS,
        unread=tuple(answer.message for answer in answers.unread),
    )
    answer = answers.inertia
    if answer is None or answer.value is None:
        return evidence
    own = evidence.own
    value = answer.value
    step = answer.step or 0.0
    slips = _slips(evidence, answer, value)
    name = slips[0].fit if slips else None
    fits = [own_fit for own_fit in own.values if own_fit.name == name]
    matched = min(fits or own.values, key=lambda own_fit: abs(own_fit.value - value))
    d = yardsticks.distance(value, matched.value, step, own.yardstick)
    return replace(evidence, matched=matched, d=d, slips=slips)


def _slips(
    evidence: Evidence, answer: ReportedValue, value: float
) -> tuple[yardsticks.Slip, ...]:
    """Name the mistakes that explain an answer; of one digit, many agree by chance."""
    if (answer.digits or 0) < 2:
        return ()
    log = evidence.analysis.readings, evidence.analysis.measurements
    step = answer.step or 0.0
    return tuple(yardsticks.find_slips(value, step, evidence.own, *log))


def _values_of(evidence: Evidence) -> dict[str, Any]:
    """Return the marks and the numbers of a grade, by the names of its fields."""
    analysis = evidence.analysis
    matched = evidence.matched
    inertia = analysis.inertia
    scatters = criteria.scatter_of(analysis)
    fits = evidence.own.values
    marks = [
        criteria.judge(criterion, evidence) for criterion in evidence.rubric.criteria
    ]
    return {
        "marks": tuple(marks),
        "slips": evidence.slips,
        "own": {fit.name: {"value": fit.value, "u": fit.u} for fit in fits},
        "inertia": inertia.value,
        "inertia_u": inertia.u,
        "matched": matched.name if matched else None,
        "d": evidence.d if matched else None,
        "scatters": () if times_stated(analysis.measurements) else scatters,
        "days": day_values(analysis),
    }


def _reported(answers: Answers) -> Reported:
    """Return the answer with its place."""
    answer = answers.inertia
    if answer is None:
        return {}
    return {
        "text": answer.text,
        "value": answer.value,
        "u": answer.u,
        "line": answer.line,
        "file": answers.file or None,
    }


References = Mapping[str, yardsticks.Reference]
Scatters = Mapping[str, yardsticks.BenchScatter]
"""By station; "all" is for all other stations."""


class Standard(NamedTuple):
    """What the grades of a class are compared with."""

    rubric: Rubric
    references: References
    scatters: Scatters

    def settled(self, grade: Grade) -> Grade:
        """Judge the criteria that need a reference or the scatter of the class.

        The points are then added up again. `grade`: As `grade_submission` or this
        function returned it.
        """
        if not grade.own:
            return grade
        reference = yardsticks.of_station(self.references, grade.station)
        scatter = yardsticks.of_station(self.scatters, grade.station)
        marks = []
        zeta = None
        for criterion, mark in zip(self.rubric.criteria, grade.marks, strict=True):
            if criterion.check == "reference":
                mark = criteria.judge_reference(criterion, mark, reference)
                zeta = mark.detail.get("z", zeta)
            elif criterion.check == "constancy" and scatter is not None:
                mark = criteria.judge_scatter(criterion, mark, grade.scatters, scatter)
            marks.append(mark)
        zeta = zeta if isinstance(zeta, float) else None
        return added_up(replace(grade, marks=tuple(marks), zeta=zeta))


def standard_of(
    grades: Sequence[Grade], rubric: Rubric, same_data: Iterable[Iterable[str]] = ()
) -> Standard:
    """Return what the grades of a class are compared with; the order does not matter.

    `same_data`: As for `each_log_once`.
    """
    logs = each_log_once(grades, same_data)
    references = rubric.references
    scatters = {}
    if rubric.class_reference:
        references = class_references(
            (log.station, log.inertia or 0.0, log.inertia_u or 0.0) for log in logs
        )
    checks = [criterion.check for criterion in rubric.criteria]
    if "from" in rubric.bench and "constancy" in checks:
        scatters = yardsticks.class_scatter((log.station, log.scatters) for log in logs)
    return Standard(rubric, references, scatters)


AGREES, MUCH = 5.0, 3.0
"""A log is doubted if the answer is closer to the reference than the first [standard
uncertainties of both], and the distance of the log is more than the second times that
of the answer."""

# a log whose I_zz is farther from the reference needs a look [standard uncertainties of
# both]
LOOKED_AT = 5.0


class Disagreement(NamedTuple):
    """How a log disagrees with the reference."""

    reference: yardsticks.Reference
    inertia: float  # that the log gives [kg*m^2]
    value: float  # as reported [kg*m^2]; 0 without a number
    far: (
        float  # distance of the log from the reference [standard uncertainties of both]
    )
    wrong_log: bool  # the answer agrees with the reference, and the log does not


def find_disagreement(grade: Grade, references: References) -> Disagreement | None:
    """Compare the I_zz that a log gives with the reference.

    None if there is nothing to look for in the log: they agree, or the answer is far
    from both.
    """
    reference = yardsticks.of_station(references, grade.station)
    if reference is None or not grade.own or not grade.inertia:
        return None
    inertia = grade.inertia
    value = grade.reported_inertia or 0.0
    disagree = (grade.d or 0.0) > FAR
    share = (grade.inertia_u or 0.0) / abs(inertia)
    far = reference.zeta(inertia, share * inertia)
    u = min(share, yardsticks.COARSEST) * value
    wrong_log = disagree and _is_answer_nearer(reference, inertia, value, u)
    if not wrong_log and (disagree or far <= LOOKED_AT):
        return None
    return Disagreement(reference, inertia, value, far, wrong_log)


def _is_answer_nearer(
    reference: yardsticks.Reference, inertia: float, value: float, u: float
) -> bool:
    """Return whether an answer agrees with the reference, and its log does not."""
    agrees = reference.zeta(value, u) <= AGREES
    expected = reference.inertia
    away_of_log = abs(inertia - expected)
    away_of_answer = abs(value - expected)
    return agrees and away_of_log > MUCH * away_of_answer


def reconsider(
    grade: Grade,
    submission: Submission,
    standard: Standard,
    typed: str | None,
) -> Grade:
    """Look for a mistake in a log whose own I_zz is far from the reference.

    `grade`: It is settled. `typed`: I_zz typed in by a person. If the answer
    agrees with the reference, and follows from the log after a known mistake in the log
    is corrected, the grade for the corrected log is returned. Otherwise a person is
    asked to look, unless the answer is wrong too: then it tells how the student has
    worked.
    """
    from gyrodata.analysis import fit_log

    rubric = standard.rubric
    doubt = find_disagreement(grade, standard.references)
    if doubt is None:
        return grade
    try:
        readings = yardsticks.at_bench(submission, rubric.bench).readings
        measured = fit_log(readings, Options()).measurements
    except GyroError:
        return grade  # it has changed since it was graded; the next run sees that
    wanted = doubt.value if doubt.wrong_log else doubt.reference.inertia
    explained = mistakes.explaining_mistakes(
        readings, measured, abs(doubt.inertia), wanted
    )
    kinds = [kind for kind, _ in explained if not kind.kind.startswith("ball_")]
    if doubt.wrong_log:
        # Several headers may explain the same factor: the first one tried leaves
        # readings of the usual size.
        kinds.sort(
            key=lambda kind: yardsticks.unusual(yardsticks.corrected(readings, kind))
        )
        for kind in kinds:
            again = grade_submission(submission, rubric, typed, kind)
            if again.d is not None and again.d <= FAR:
                return standard.settled(replace(again, **_known_of(grade)))
    return _with_question(grade, doubt, kinds)


def _known_of(grade: Grade) -> dict[str, Any]:
    """Return what a grade has from the class, by the names of its fields."""
    names = ("name", "section", "station", "fingerprint")
    return {name: getattr(grade, name) for name in names}


def _with_question(
    grade: Grade, doubt: Disagreement, kinds: Sequence[Mistake]
) -> Grade:
    """Ask a person to look at a log, and tell the student which mistakes explain it."""
    factor = factor_text(doubt.inertia / doubt.reference.inertia)
    look = (
        f"the log's own I_zz is {doubt.far:.3g} standard uncertainties from the "
        f"reference, {factor} it"
    )
    if not kinds:
        return replace(grade, look=(*grade.look, look))
    words = " or ".join(kind.log for kind in kinds)
    why = f"one mistake in the log that would explain this factor: {words}"
    marks = []
    for mark in grade.marks:
        if mark.check == "reference":
            reason = f"{mark.reason}; {why}; {kinds[0].remedy}"
            mark = replace(mark, reason=reason)
        marks.append(mark)
    return replace(grade, marks=tuple(marks), look=(*grade.look, f"{look}; {why}"))


def added_up(grade: Grade) -> Grade:
    """Add up the points, or say why there is no sum.

    Marks that wait for a person give a sum so far.
    """
    open_marks = [mark for mark in grade.marks if mark.points is None]
    reasons = dict.fromkeys(mark.reason for mark in open_marks if not mark.waits)
    if reasons:
        why = "; ".join(reasons) if grade.own else grade.why
        return replace(grade, status="not graded", why=why, points=None)
    total = sum(mark.points or 0.0 for mark in grade.marks)
    left = max(0.0, total - grade.late_deduction)
    status: Status = "so far" if open_marks else "graded"
    return replace(grade, status=status, why=None, points=round(left, 2))


def points_text(points: float | None) -> str:
    """Write points: "6", "4.35", or "–" where there are none yet."""
    if points is None:
        return "–"
    return f"{points:.2f}".rstrip("0").rstrip(".")


def two_decimals(points: float | None) -> str:
    """Write points with two decimals, as gradebooks compare them.

    The text never contains a mark between thousands.
    """
    if points is None:
        return ""
    return f"{points:.2f}"


def _looks(evidence: Evidence) -> list[str]:
    """Return what a person has to look at."""
    reasons = []
    words = " or ".join(slip.words for slip in evidence.slips)
    # Two mistakes with the same factor cost the same: nothing needs a decision.
    factor = evidence.factor
    if any(abs(slip.factor / factor - 1) > yardsticks.SAME for slip in evidence.slips):
        reasons.append(
            f"several mistakes explain the reported I_zz equally well: {words}"
        )
    elif evidence.slips:
        reasons += [f"{doubt}: {words}" for doubt in _doubts_of_slip(evidence)]
    reasons += filter(None, [unusual_turns(evidence.analysis.readings)])
    spread = criteria.spread_of(evidence.analysis) or 0.0
    if spread > WILD:
        reasons.append(
            f"the times do not follow from the spins: φ̇ψ̇ scatters by "
            f"{100 * spread:.2g} % within a torque"
        )
    if evidence.d > FAR and not evidence.slips:
        far = f"the reported I_zz is {evidence.d:.3g} u from the student's own runs"
        reasons.append(f"{far}, and no common mistake explains it")
    return reasons


SAME_VALUE = 0.001
"""An answer with a mistake has the value of a fit with this mistake, but for rounding
and this share of it: g is 9.81 or 9.80 m/s². Its uncertainty may have other parts than
that of a fit. Of answers at random with three digits, one in twenty is near a fit with
some mistake, but one in a hundred is so near."""


def _doubts_of_slip(evidence: Evidence) -> list[str]:
    """Ask about a mistake that may agree with the report by chance."""
    log = evidence.analysis
    known = yardsticks.possible_mistakes(evidence.own, log.readings, log.measurements)
    fits = yardsticks.with_mistake(known[evidence.slips[0].kind], evidence.own)
    reported, value, _ = evidence.answer
    half_step = (reported.step or 0.0) / 2
    shares = []
    for fit in fits:
        apart = abs(value - fit.value) - half_step
        shares.append(apart / abs(fit.value))
    if min(shares) > SAME_VALUE:
        return ["a mistake explains the reported I_zz, but not to its digits"]
    if all(known[slip.kind].rank > 0 for slip in evidence.slips):
        return ["only a rare mistake explains the reported I_zz"]
    return []


def station_of(readings: Readings) -> str | None:
    """Return the station that a log names, in the form that a rubric uses."""
    for key, text in readings.metadata.items():
        if squeeze(key).lower() in STATION_WORDS:
            return yardsticks.station_key(text) or None
    return None


# --- not graded ---


def not_graded(
    submission: Submission,
    rubric: Rubric,
    why: str | None,
    diagnostics: Iterable[Diagnostic] = (),
) -> Grade:
    """Return the grade of a submission of which only the lateness is judged.

    This grade has no points, which is not the same as zero points.
    """
    late = judge_lateness(rubric.late, submission, rubric.points)
    marks = [
        criteria.mark(criterion, "not judged", {}, None)
        for criterion in rubric.criteria
    ]
    return Grade(
        student=submission.student,
        name=submission.name,
        why=why,
        out_of=rubric.points,
        marks=tuple(marks),
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
    first, *more = [note for note in error.diagnostics if note.severity == "error"]
    words = first.message
    if first.line:
        words = f"line {first.line}: {words}"
    if more:
        words += f", and {len(more)} more"
    return f"the log cannot be {done}: {words}"


# --- ``gyro check --hand-in`` ---


def read_hand_in(
    paths: Sequence[Path],
) -> tuple[Readings, HandIn, tuple[Diagnostic, ...]]:
    """Read a student's files, folder or zip as `grade_submission` does.

    The answer in the submission is reported as well.
    """
    submission, notes = submission_of(paths)
    if submission.problem is not None:
        raise InputError.named("no_log_here", paths[0].name, why=submission.problem)
    readings, answers = submission.read()
    answer: dict[str, Any] = {**dict.fromkeys(_REPORTED), **_reported(answers)}
    answer["inertia"] = answer.pop("value")
    handed_in = HandIn(**answer, station=station_of(readings))
    # The place of the answer is reported once.
    about_texts = (*answers.diagnostics, *answers.unread)
    place = diagnostics.ANSWER_ELSEWHERE
    others = [note for note in about_texts if note.code != place]
    note = _note_on_answer(submission, answers, handed_in)
    return readings, handed_in, (*notes, *others, note)


def _note_on_answer(
    submission: Submission, answers: Answers, handed_in: HandIn
) -> Diagnostic:
    """Say which answer is read, or why none is."""
    log = shown(PurePosixPath(submission.log_file or "").name)
    file = handed_in.file or log
    problem = None
    if answers.inertia is not None:
        problem = answers.inertia.problem
    if handed_in.inertia is not None:
        words = _words_of_answer(handed_in.inertia, problem, handed_in)
        if answers.of_gyro:
            return Diagnostic.named("answer_of_gyro", file, handed_in.line, words=words)
        return Diagnostic.named("answer_read", file, handed_in.line, words=words)
    files = sorted(shown(PurePosixPath(member).name) for member in submission.members)
    words = f"no I_zz is found in {listing(files)}"
    more = ""
    if answers.inertia is not None:
        words = f"the answer cannot be read: {problem}"
        more = ", and take its other lines with an I_zz out" * (file == log)
    values = {"words": words, "log": log, "more": more}
    return Diagnostic.named("answer_missing", file, handed_in.line, **values)


def _words_of_answer(inertia: float, problem: str | None, handed_in: HandIn) -> str:
    """Describe an answer that is read, with what is unusual about it."""
    place = handed_in.file or ""
    if handed_in.line:
        place += f", line {handed_in.line}"
    words = [f"I_zz = {inertia_text(inertia, handed_in.u)}, read from {place}"]
    if handed_in.u is None:
        words.append("no uncertainty is found with it")
    if problem:
        words.append(problem)
    if handed_in.station:
        words.append(f"station: {handed_in.station}")
    return "; ".join(words)
