"""Read the rubric with its criteria, deductions for being late, and reference for I_zz.

Each criterion has its points.

A rubric is a TOML file. The file ``rubric.toml`` in this folder is used if no other is
given; it explains every key.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import json
import math
import re
from collections import Counter
from collections.abc import Collection, Mapping
from functools import cached_property
from importlib.resources import files
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import msgspec
from msgspec import Meta, Struct, field, to_builtins
from msgspec.structs import asdict, force_setattr

from gyrodata.base.errors import Diagnostic, nearest
from gyrodata.grading.criteria import ASKS, KINDS, MEANINGS, points_of
from gyrodata.grading.rubric_file import Number, Text, TomlFile, unfit
from gyrodata.grading.yardsticks import (
    APPARATUS,
    BENCH,
    TABLES,
    Reference,
    Station,
    check_bench,
    station_key,
)
from gyrodata.reporting.values import duration_text

if TYPE_CHECKING:
    from gyrodata.grading.submissions import Submission, Submissions

# --- deductions for being late ---

# As a rubric contains them: a duration, and the points or the share of all points that
# are taken off.
_DURATION = r"^\s*\d+(\.\d+)?\s*(s|sec|second|min|minute|h|hour|day|week)s?\s*$"
Duration = Annotated[
    str, Meta(pattern=_DURATION, examples=["15 min", "36 h", "2 days"])
]
_SHARE = Annotated[str, Meta(pattern=r"^\s*\d+(\.\d+)?\s*%\s*$", examples=["10 %"])]
Deduction = _SHARE | Annotated[float, Meta(ge=0, examples=[2])]
_STAMP = {"pattern": r"^\d{4}-\d\d-\d\d[Tt ]\d\d:\d\d"}
Time = Annotated[
    dt.datetime | None,
    Meta(examples=["2026-03-09T23:59:00+01:00"], extra_json_schema=_STAMP),
]


def seconds_of(duration: str) -> float:
    """Read a duration [s]: "2 days" is 172,800."""
    number, unit, *_ = re.findall(r"[\d.]+|[a-z]", duration)
    seconds = {"s": 1, "m": 60, "h": 3600, "d": 86400, "w": 604800}
    return float(number) * seconds[unit]


class Tier(Struct, frozen=True, forbid_unknown_fields=True):
    """The deduction up to this lateness."""

    until: Duration
    deduct: Deduction


class LateException(Struct, frozen=True, forbid_unknown_fields=True):
    """An exception for one student: exactly one of `due`, `extra` and `waive`."""

    student: Text  # key, any id, or name
    due: Time = None
    extra: Duration | None = None  # additional time
    waive: Annotated[bool, Meta(examples=[True])] = False

    def __post_init__(self) -> None:
        stated = [self.due is not None, self.extra is not None, self.waive]
        if sum(stated) != 1:
            raise unfit("late_exception_unclear")


class LateRule(Struct, frozen=True, forbid_unknown_fields=True):
    """How many points lateness costs."""

    due: Time = None  # None: the lateness that the learning platform shows counts
    grace: Duration = "0 s"
    tiers: tuple[Tier, ...] = field(
        default=(), name="tier"
    )  # in rising order of `until`
    beyond: Deduction = "100 %"  # after the last tier
    marked: Deduction | None = None
    """For a submission that is only marked late, without a time; None: a person must
    look."""
    exceptions: tuple[LateException, ...] = field(default=(), name="exception")

    def __post_init__(self) -> None:
        ends = [seconds_of(tier.until) for tier in self.tiers]
        if sorted(set(ends)) != ends:
            raise unfit("late_tiers_not_rising", "tier")
        named = Counter(exception.student.casefold() for exception in self.exceptions)
        for student, count in named.items():
            if count > 1:
                raise unfit("late_exception_twice", "exception", student=student)


class Lateness(Struct, frozen=True):
    """The result of the rule for one submission."""

    seconds: float | None  # 0 if in time; None if nothing says a time
    deduct: float  # [points]
    reason: str  # in words; "" if in time
    look: bool  # True if a person must decide


def judge_lateness(
    rule: LateRule | None, submission: Submission, whole: float
) -> Lateness:
    """Compute how many of `whole` points a late submission loses.

    With a tier until = "1 day", deduct = "10 %", two hours late cost 2 of 20 points:
    Lateness(7200.0, 2.0, "2 h late", False). Only the marks and time stamps of the
    submission are used.
    """
    if rule is None:
        return _lateness_without_rule(submission)
    exception = _exception_for(submission, rule)
    if exception is not None and exception.waive:
        is_late = submission.late or submission.late_seconds
        words = "lateness waived for you" if is_late else ""
        return Lateness(submission.late_seconds, 0.0, words, False)
    seconds = _seconds_late(submission, rule, exception)
    if seconds is None:
        return _lateness_without_time(rule, exception, submission, whole)
    words = duration_text(seconds)
    if seconds <= seconds_of(rule.grace):
        why = f"{words} after the deadline, within the grace time"
        if seconds <= 0:
            return Lateness(0.0, 0.0, "", False)
        return Lateness(seconds, 0.0, why, False)
    reached = (tier.deduct for tier in rule.tiers if seconds <= seconds_of(tier.until))
    lost = points_of(next(reached, rule.beyond), whole)
    return Lateness(seconds, lost, f"{words} late", False)


def _lateness_without_rule(submission: Submission) -> Lateness:
    """Return how late a submission is, for a rubric that deducts nothing."""
    words = "marked late" if submission.late else ""
    if submission.late_seconds:
        words = f"{duration_text(submission.late_seconds)} late"
    return Lateness(submission.late_seconds, 0.0, words, False)


def _lateness_without_time(
    rule: LateRule,
    exception: LateException | None,
    submission: Submission,
    whole: float,
) -> Lateness:
    """Return the lateness of a submission without a time, which may be marked late."""
    if not submission.late:
        return Lateness(None, 0.0, "", False)
    if rule.marked is None or exception is not None:
        why = "marked late, but nothing says by how much"
        return Lateness(None, 0.0, why, True)
    lost = points_of(rule.marked, whole)
    return Lateness(None, lost, "marked late, without the time", False)


def _exception_for(submission: Submission, rule: LateRule) -> LateException | None:
    """Return the exception that a rubric makes for a student."""
    known = (submission.student, submission.name, *submission.ids.values())
    names = {name.casefold() for name in known}
    for exception in rule.exceptions:
        if exception.student.casefold() in names:
            return exception
    return None


def _seconds_late(
    submission: Submission, rule: LateRule, exception: LateException | None
) -> float | None:
    """Return the time after the deadline of the student [s]; None if nothing says it.

    It is negative or zero for a submission in time.
    """
    own_due = exception.due if exception else None
    extra = 0.0
    if exception and exception.extra:
        extra = seconds_of(exception.extra)
    by_stamp = _seconds_between(own_due or rule.due, submission.submitted)
    if by_stamp is not None:
        return by_stamp - extra
    # If the student has another deadline, the lateness that the platform counts says
    # nothing.
    counts = not (submission.late and own_due)
    if submission.late_seconds is not None and counts:
        return submission.late_seconds - extra
    return None


def _seconds_between(due: dt.datetime | None, submitted: str | None) -> float | None:
    """Return the time from a deadline to a stamp [s]; None if one of them is missing.

    A stamp without a time zone is in the time of the course, and so is a deadline
    without one.
    """
    if due is None:
        return None
    try:
        stamp = dt.datetime.fromisoformat(submitted or "")
    except ValueError:
        return None
    zone = due.tzinfo or stamp.tzinfo
    due = due.replace(tzinfo=due.tzinfo or zone)
    stamp = stamp.replace(tzinfo=stamp.tzinfo or zone)
    return (stamp - due).total_seconds()


# --- the rubric ---

ACCEPTED = tuple(TABLES["fits"])
"""Fits of a student's own runs that a rubric may accept."""


# --- conditions, "d <= 0.3" or "ratio in 0.5..2", and the points between two of them
# ---

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
CONDITION = (
    rf"^\s*(?P<name>{'|'.join(MEANINGS)})\s*"
    rf"(?:(?P<sign><=|>=|≤|≥)\s*(?P<bound>{_NUMBER})|(?P<word>in|outside)\s+"
    rf"(?P<low>{_NUMBER})\s*\.\.\s*(?P<high>{_NUMBER}))\s*$"
)
_OPPOSITE = {"<=": ">=", ">=": "<=", "in": "outside"}
"""By the relation of `full`, that of `zero`."""
_ENDS = {">=": ">= NUMBER", "<=": "<= NUMBER", "outside": "outside LOW..HIGH"}


class Curve(NamedTuple):
    """Share of the points as a function of a variable.

    The share is 1 in `full`, 0 outside `some`, and linear in between. Of the conditions
    full = "d <= 1" and zero = "d >= 3", `full` is (-inf, 1) and `some` is (-inf, 3): a
    d of 2 has a share of 0.5.
    """

    variable: str
    full: tuple[float, float]  # ends of the values with all points
    some: tuple[float, float]  # ends of the values with any points

    def share(self, value: float) -> float:
        """Return the share of the points for a value."""
        (low, high), (least, most) = self.full, self.some
        if low <= value <= high:
            return 1.0
        # The value may be "not a number", and the two ends may be equal.
        if not least < value < most:
            return 0.0
        near, far = high, most
        if value < low:
            near, far = low, least
        share = (far - value) / (far - near)
        return max(0.0, share)


class Condition(NamedTuple):
    """A condition of a rubric: "ratio in 0.5..2" is ("ratio", "in", 0.5, 2.0).

    Of "d <= 0.6", both numbers are 0.6.
    """

    variable: str
    relation: str  # "<=", ">=", "in" or "outside"
    low: float
    high: float

    def ends(self, relation: str) -> tuple[float, float]:
        """Return the ends of the values with this `relation` to the numbers."""
        least = -math.inf if relation == "<=" else self.low
        most = math.inf if relation == ">=" else self.high
        return least, most


def parse_condition(text: str, key: str) -> Condition:
    """Read the condition of a `key`; raise UnfitError if it is none."""
    match = re.fullmatch(CONDITION, text)
    if match is None:
        raise unfit("condition_unclear", key, text=text)
    sign = (match["sign"] or "").replace("≤", "<=").replace("≥", ">=")
    low = float(match["low"] or match["bound"])
    high = float(match["high"] or match["bound"])
    if match["word"] and low >= high:
        raise unfit("condition_unclear", key, text=text)
    return Condition(match["name"], match["word"] or sign, low, high)


# --- the file ---

_PATTERN = {"pattern": re.sub(r"\?P<\w+>", "", CONDITION), "description": str(MEANINGS)}
ConditionText = Annotated[str, Meta(examples=["d <= 0.6"], extra_json_schema=_PATTERN)]


_RELATIONS = {
    "<=": " up to ",
    "≤": " up to ",
    ">=": " from ",
    "≥": " from ",
    " in ": " from ",
    "..": " to ",
}
"""Relations of a condition, as students read them."""


class Criterion(Struct, frozen=True, dict=True, forbid_unknown_fields=True):
    """One criterion, as the rubric states it.

    Keys that are not given have the defaults of `KINDS`.
    """

    id: Text  # unique; the column of the grades
    check: Literal[*KINDS]  # type: ignore[valid-type]
    points: Number
    title: Text = ""
    full: ConditionText = ""
    zero: ConditionText = ""
    slip: Deduction | None = None  # deduction for a common mistake
    asks: Annotated[tuple[Literal[*ASKS], ...], Meta(min_length=1)] = ()  # type: ignore[valid-type]

    def __post_init__(self) -> None:
        kind = KINDS[self.check]
        for key in ("full", "zero", "slip", "asks"):
            if getattr(self, key) and key not in kind.keys:
                raise unfit("criterion_key_unknown", key, key=key, check=self.check)
        defaults = {
            "title": kind.title,
            "full": kind.full,
            "zero": kind.zero,
            "slip": "50 %",
            "asks": tuple(ASKS)[:3],
        }
        for key, value in defaults.items():
            if getattr(self, key) in (None, "", ()) and key in ("title", *kind.keys):
                force_setattr(self, key, value)
        assert self.curve  # its faults are reported now

    @cached_property
    def curve(self) -> Curve:
        """Share of the points as a function of a variable, by `full` and `zero`."""
        if self.check == "manual":
            return Curve("", (0.0, 0.0), (0.0, 0.0))
        kind = KINDS[self.check]
        zero = parse_condition(self.zero, "zero")
        full = parse_condition(self.full, "full")
        name = full.variable
        known = (kind.full.split()[0], *kind.variables)
        if name not in known:
            values = {"name": name, "check": self.check, "known": " or ".join(known)}
            raise unfit("condition_of_other_check", "full", **values)
        opposite = _OPPOSITE.get(full.relation)
        if opposite is None:
            raise unfit("full_outside", "full", full=self.full, name=name)
        ends = full.ends(full.relation)
        some = zero.ends(full.relation)
        is_farther_out = some[0] <= ends[0] and ends[1] <= some[1]
        if zero[:2] != (name, opposite) or not is_farther_out:
            both = {"zero": self.zero, "full": self.full}
            values = {"name": name, "opposite": _ENDS[opposite]}
            raise unfit("conditions_do_not_fit", "full", **both, **values)
        return Curve(name, ends, some)

    @property
    def rule(self) -> str:
        """The two conditions in words, for students."""
        name = self.curve.variable
        full = _in_words(self.full, name)
        zero = _in_words(self.zero, name)
        meaning = MEANINGS.get(name, name)
        return f"{meaning}: all points {full}, none {zero}"


def _in_words(condition: str, name: str) -> str:
    """Write a condition as students read it, without the name of its variable."""
    text = condition.strip().removeprefix(name)
    for typed, words in _RELATIONS.items():
        text = text.replace(typed, words)
    return " ".join(text.split())


class _Table(Struct, frozen=True, dict=True, forbid_unknown_fields=True):
    """The keys of the file."""

    schema: Literal[1]
    points: Number
    criteria: tuple[Criterion, ...] = field(name="criterion")
    title: Text = "Gyroscope lab"
    accept: Annotated[
        tuple[Literal[ACCEPTED], ...],  # type: ignore[valid-type]
        Meta(min_length=1),
    ] = ACCEPTED
    no_report: Literal["look", "zero"] = "look"
    late: LateRule | None = None
    reference: Mapping[str, Station | str] | None = None
    bench: Annotated[
        Mapping[str, str],
        Meta(extra_json_schema={"propertyNames": {"enum": ["from", *BENCH]}}),
    ] = {}

    def __post_init__(self) -> None:
        self._check_points()
        self._check_ids()
        check_bench(self.bench)
        _check_origin("reference", self.reference or {}, self.references)
        stated = {key for key in self.bench if key not in ("from", *APPARATUS)}
        _check_origin("bench", self.bench, stated)

    def _check_points(self) -> None:
        """Raise UnfitError if the points of the criteria are not those of all."""
        total = math.fsum(criterion.points for criterion in self.criteria)
        if abs(total - self.points) > 1e-9:
            parts = " + ".join(f"{criterion.points:g}" for criterion in self.criteria)
            values = {"points": self.points, "parts": parts, "total": total}
            raise unfit("points_do_not_add_up", "points", **values)

    def _check_ids(self) -> None:
        """Raise UnfitError for an id that cannot be a column of the grades."""
        known = set[str]()
        for at, criterion in enumerate(self.criteria):
            place = "criterion", at, "id"
            if criterion.id in known:
                raise unfit("criterion_twice", *place, id=criterion.id)
            if criterion.id.casefold() in TABLES["reserved"]:
                raise unfit("criterion_id_reserved", *place, id=criterion.id)
            if criterion.check == "reference" and self.reference is None:
                raise unfit("reference_missing", "criterion", at, id=criterion.id)
            known.add(criterion.id)

    @cached_property
    def references(self) -> Mapping[str, Reference]:
        """References of the rubric, by station; "all" is for all other stations."""
        references = {}
        for name, stated in (self.reference or {}).items():
            source = "the rubric" if name == "all" else f"the rubric, station {name}"
            if isinstance(stated, Station):
                references[station_key(name)] = stated.reference(source)
        return references


def _check_origin(
    head: str, table: Mapping[str, Station | str], stated: Collection[str]
) -> None:
    """Raise UnfitError if a table has another origin than "class", or two origins."""
    source = table.get("from")
    if source not in (None, "class"):
        raise unfit("from_not_class", head, "from", source=source)
    if source and stated:
        raise unfit("class_and_stated", head, "from", table=head)


class Rubric(_Table, frozen=True, dict=True):
    """Everything that decides about points."""

    name: str = ""

    @property
    def class_reference(self) -> bool:
        """True if the reference is taken from the class."""
        return "from" in (self.reference or {})

    def _hash(self, *left_out: str) -> str:
        content = to_builtins(self, builtin_types=(dt.datetime,))
        content = {key: value for key, value in content.items() if key not in left_out}
        text = json.dumps(content, sort_keys=True, default=dt.datetime.isoformat)
        return hashlib.sha256(text.encode()).hexdigest()

    @cached_property
    def digest(self) -> str:
        """Hash of all that can change a grade: not of remarks and spaces."""
        return self._hash("name")

    @cached_property
    def judged(self) -> str:
        """Digest without the references, which only the whole class uses."""
        return self._hash("name", "reference")


BUILT_IN = ("simple", "full", "manual")


def default_rubric_text(kind: str = "full") -> str:
    """Return the text of a rubric of `BUILT_IN`, by default of "full"."""
    name = f"rubric-{kind}.toml".replace("-full", "")
    return files("gyrodata.grading").joinpath(name).read_text("utf-8")


def read_rubric(data: bytes, name: str = "rubric.toml") -> Rubric:
    """Read a rubric; raise InputError with its first mistake."""
    file = TomlFile(data, name)
    written = file.values.get("reference")
    stations = written if isinstance(written, dict) else {}
    for station in stations:
        if station != "from":
            file.record(Station, ("reference", station))
    return Rubric(**asdict(file.record(_Table)), name=name)


def unknown_exceptions(rubric: Rubric, submissions: Submissions) -> list[Diagnostic]:
    """Warn of exceptions for students who are not in the class."""
    known = {}
    for item in submissions.items:
        for name in (item.student, item.name, *item.ids.values()):
            known[name.casefold()] = name
    if rubric.late is None:
        return []
    named = [exception.student for exception in rubric.late.exceptions]
    hint = "write the name, key or id of a student"
    return [
        Diagnostic.named(
            "exception_for_nobody",
            rubric.name,
            student=student,
            near=nearest(student, known.values(), hint),
        )
        for student in named
        if student.casefold() not in known
    ]


def rubric_shape() -> dict[str, Any]:
    """Return the JSON Schema of a rubric, for editors."""
    return msgspec.json.schema(_Table)
