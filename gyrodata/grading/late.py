"""Points for late submissions: steps, grace time and exceptions, from the time stamps of a submission."""

from __future__ import annotations

import datetime as dt
import re
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated

from msgspec import Meta, Struct, field

from gyrodata.reporting.values import duration_text
from gyrodata.toml_table import Text, unfit

if TYPE_CHECKING:
    from gyrodata.grading.submissions import Submission

# As a rubric contains them: a duration, and the points or the share of all points that are taken off.
_DURATION = r"^\s*\d+(\.\d+)?\s*(s|sec|second|min|minute|h|hour|day|week)s?\s*$"
Duration = Annotated[str, Meta(pattern=_DURATION, examples=["15 min", "36 h", "2 days"])]
_SHARE = Annotated[str, Meta(pattern=r"^\s*\d+(\.\d+)?\s*%\s*$", examples=["10 %"])]
Deduction = _SHARE | Annotated[float, Meta(ge=0, examples=[2])]
_STAMP = {"pattern": r"^\d{4}-\d\d-\d\d[Tt ]\d\d:\d\d"}
Time = Annotated[dt.datetime | None, Meta(examples=["2026-03-09T23:59:00+01:00"], extra_json_schema=_STAMP)]


def seconds_of(duration: str) -> float:
    """Read a duration [s]."""
    number, unit, *_ = re.findall(r"[\d.]+|[a-z]", duration)
    return float(number) * {"s": 1, "m": 60, "h": 3600, "d": 86400, "w": 604800}[unit]


def points_of(deduction: str | float, whole: float) -> float:
    """Read a deduction from `whole` points."""
    return float(deduction.rstrip(" %")) / 100 * whole if isinstance(deduction, str) else deduction


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
        if (self.due is not None) + (self.extra is not None) + self.waive != 1:
            raise unfit("late_exception_unclear")


class LateRule(Struct, frozen=True, forbid_unknown_fields=True):
    """How many points lateness costs."""

    due: Time = None  # None: the lateness that the learning platform shows counts
    grace: Duration = "0 s"
    tiers: tuple[Tier, ...] = field(default=(), name="tier")  # in rising order of `until`
    beyond: Deduction = "100 %"  # after the last tier
    marked: Deduction | None = None
    """For a submission that is only marked late, without a time; None: a person must look."""
    exceptions: tuple[LateException, ...] = field(default=(), name="exception")

    def __post_init__(self) -> None:
        ends = [seconds_of(tier.until) for tier in self.tiers]
        if sorted(set(ends)) != ends:
            raise unfit("late_tiers_not_rising", "tier")


class Lateness(Struct, frozen=True):
    """The result of the rule for one submission."""

    seconds: float | None  # 0 if in time; None if unknown
    deduct: float  # [points]
    reason: str  # in words; "" if in time
    look: bool  # True if a person must decide


def judge_lateness(rule: LateRule | None, submission: Submission, whole: float) -> Lateness:
    """Compute what lateness costs of `whole` points, from the marks and time stamps of the submission only."""
    late, late_seconds = submission.late, submission.late_seconds
    if rule is None:
        after = f"{duration_text(late_seconds)} late" if late_seconds else "marked late" if late else ""
        return Lateness(late_seconds, 0.0, after, False)
    called = {one.casefold() for one in (submission.student, submission.name, *submission.ids.values())}
    excepted = next((one for one in rule.exceptions if one.student.casefold() in called), None)
    if excepted and excepted.waive:
        return Lateness(late_seconds, 0.0, "lateness waived for you" if late or late_seconds else "", False)
    due = (excepted and excepted.due) or rule.due
    extra = seconds_of(excepted.extra or "0 s") if excepted else 0.0
    seconds, stamp = None if late else 0.0, None
    with suppress(ValueError):
        stamp = dt.datetime.fromisoformat(submission.submitted or "")
    if due is not None and stamp is not None:
        # A stamp without a time zone is in the time of the course, and so is a deadline without one.
        zone = due.tzinfo or stamp.tzinfo
        due, stamp = (one.replace(tzinfo=one.tzinfo or zone) for one in (due, stamp))
        seconds = (stamp - due).total_seconds() - extra
    elif late_seconds is not None and not (late and excepted and excepted.due):
        # If the student has another deadline, the lateness that the platform counts says nothing.
        seconds = late_seconds - extra
    if seconds is None and (rule.marked is None or excepted):
        return Lateness(None, 0.0, "marked late, but nothing says by how much", True)
    if seconds is None:
        return Lateness(None, points_of(rule.marked or 0.0, whole), "marked late, without the time", False)
    if seconds <= seconds_of(rule.grace):
        reason = f"{duration_text(seconds)} after the deadline, within the grace time" if seconds > 0 else ""
        return Lateness(max(0.0, seconds), 0.0, reason, False)
    deduct = next((tier.deduct for tier in rule.tiers if seconds <= seconds_of(tier.until)), rule.beyond)
    return Lateness(seconds, points_of(deduct, whole), f"{duration_text(seconds)} late", False)
