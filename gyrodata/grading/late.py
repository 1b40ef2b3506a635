"""Points for late submissions: steps, grace time and exceptions, from the time stamps of a submission."""

from __future__ import annotations

import datetime as dt
import math
import re
from collections.abc import Mapping
from itertools import pairwise
from typing import Annotated

from msgspec import Meta, Struct, field

from gyrodata.quantities import parse_uncertainty
from gyrodata.reporting.values import duration_text
from gyrodata.toml_table import Path, Text, UnfitError
from gyrodata.units import UnitError

_DURATION = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(s|sec|second|min|minute|h|hour|day|week)s?\s*", re.IGNORECASE)
_SECONDS = {"s": 1, "m": 60, "h": 3600, "d": 86400, "w": 604800}

# As a rubric contains them: a duration, and the points or the share of all points that are taken off.
Duration = Annotated[str, Meta(examples=["15 min", "36 h", "2 days"])]
Deduction = Annotated[str, Meta(pattern=r"%\s*$", examples=["10 %"])] | Annotated[float, Meta(ge=0, examples=[2])]
Time = Annotated[
    dt.datetime | None,
    Meta(examples=["2026-03-09T23:59:00+01:00"], extra_json_schema={"pattern": r"^\d{4}-\d\d-\d\d[Tt ]\d\d:\d\d"}),
]


def seconds_of(text: str, key: str = "") -> float:
    """Read a duration [s]; UnfitError if the text is not a duration."""
    match = _DURATION.fullmatch(text)
    if match is None:
        hint = f'write {key} = "15 min" or "36 h" or "2 days"'
        raise UnfitError(f'{key} = "{text[:40]}" is not a duration', hint, path=key)
    return float(match[1]) * _SECONDS[match[2][0].lower()]


def points_of(value: str | float, whole: float, path: Path = ()) -> float:
    """Read a deduction from `whole` points; UnfitError if it is more than that. `path` leads to its key."""
    try:
        points = parse_uncertainty(value, "number").relative * whole if isinstance(value, str) else value
    except UnitError:
        points = math.nan
    if not 0 <= points <= whole:
        message = f"{path[-1]} = {value} is not a share of {whole:g} points"
        raise UnfitError(message, f'write at most {path[-1]} = "100 %"', path=path)
    return points


class Tier(Struct, frozen=True, forbid_unknown_fields=True):
    """The deduction up to this lateness."""

    until: Duration
    deduct: Deduction

    def __post_init__(self) -> None:
        seconds_of(self.until, "until")


class LateException(Struct, frozen=True, forbid_unknown_fields=True):
    """An exception for one student: exactly one of `due`, `extra` and `waive`."""

    student: Text  # key, any id, or name
    due: Time = None
    extra: Duration | None = None  # additional time
    waive: Annotated[bool, Meta(examples=[True])] = False

    def __post_init__(self) -> None:
        seconds_of(self.extra or "0 s", "extra")
        if (self.due is not None) + (self.extra is not None) + self.waive != 1:
            hint = 'write due = 2026-03-16T23:59:00+01:00, or extra = "2 days", or waive = true'
            raise UnfitError("an exception says exactly one of due, extra and waive", hint)


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
        seconds_of(self.grace, "grace")
        if any(seconds_of(first.until) >= seconds_of(second.until) for first, second in pairwise(self.tiers)):
            message = "a tier is not later than the one before it"
            raise UnfitError(message, "write the tiers in rising order", path="tier")


class Lateness(Struct, frozen=True):
    """The result of the rule for one submission."""

    seconds: float | None  # 0 if in time; None if unknown
    deduct: float  # [points]
    reason: str  # in words; "" if in time
    look: bool  # True if a person must decide


def judge_lateness(
    rule: LateRule | None,
    keys: Mapping[str, str],
    late: bool,
    late_seconds: float | None,
    submitted: str | None,
    whole: float,
) -> Lateness:
    """Compute what lateness costs of `whole` points, from the marks and time stamps of the submission only.

    Parameters
    ----------
    rule : LateRule or None
        The rule; with None, lateness costs nothing.
    keys : mapping
        All ids and names of the student.
    late, late_seconds, submitted
        As in `Submission`.
    whole : float
        All points of the rubric.
    """
    if rule is None:
        after = f"{duration_text(late_seconds)} late" if late_seconds else "marked late" if late else ""
        return Lateness(late_seconds, 0.0, after, False)
    called = {value.casefold() for value in keys.values()}
    excepted = next((one for one in rule.exceptions if one.student.casefold() in called), None)
    if excepted is not None and excepted.waive:
        return Lateness(late_seconds, 0.0, "lateness waived for you" if late or late_seconds else "", False)
    due = excepted.due if excepted and excepted.due else rule.due
    extra = seconds_of(excepted.extra or "0 s") if excepted else 0.0
    try:
        stamp = dt.datetime.fromisoformat(submitted or "")
    except ValueError:
        stamp = None
    seconds = None if late else 0.0
    if due is not None and stamp is not None:
        # A stamp without a time zone is in the time of the course, and so is a deadline without one.
        zone = due.tzinfo or stamp.tzinfo
        due, stamp = (one.replace(tzinfo=one.tzinfo or zone) for one in (due, stamp))
        seconds = (stamp - due).total_seconds() - extra
    elif late_seconds is not None and not (excepted is not None and excepted.due is not None and late):
        # If the student has another deadline, the lateness that the platform counts says nothing.
        seconds = late_seconds - extra
    if seconds is None:
        if rule.marked is None or excepted is not None:
            return Lateness(None, 0.0, "marked late, but nothing says by how much", True)
        return Lateness(None, points_of(rule.marked, whole), "marked late, without the time", False)
    if seconds <= seconds_of(rule.grace):
        reason = f"{duration_text(seconds)} after the deadline, within the grace time" if seconds > 0 else ""
        return Lateness(max(0.0, seconds), 0.0, reason, False)
    deduct = next((tier.deduct for tier in rule.tiers if seconds <= seconds_of(tier.until)), rule.beyond)
    return Lateness(seconds, points_of(deduct, whole), f"{duration_text(seconds)} late", False)
