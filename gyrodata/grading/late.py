"""What being late costs: tiers, grace, and exceptions for single students, from the submission's own stamps."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Mapping

from msgspec import Struct

from gyrodata.diagnostics import RUBRIC_VALUE_CANNOT_BE_USED
from gyrodata.grading.toml_table import Table

_DURATION = re.compile(r"\s*(\d+(?:\.\d+)?)\s*([a-z]+)\s*", re.IGNORECASE)
_SECONDS = {
    "s": 1,
    "sec": 1,
    "second": 1,
    "min": 60,
    "minute": 60,
    "h": 3600,
    "hour": 3600,
    "day": 86400,
    "week": 604800,
}


class Tier(Struct, frozen=True):
    """Up to this late, this is taken off."""

    until: float  # [s]
    deduct: float  # [points]


class LateException(Struct, frozen=True):
    """What holds for one student instead: exactly one of `due`, `extra` and `waive`."""

    student: str  # key, any id, or name
    due: dt.datetime | None
    extra: float | None  # time more [s]
    waive: bool


class LateRule(Struct, frozen=True):
    """How lateness becomes points."""

    due: dt.datetime | None  # None: what the learning platform says counts
    grace: float  # [s]
    tiers: tuple[Tier, ...]  # in rising order of `until`
    beyond: float  # taken off after the last tier [points]
    marked: float | None
    """Taken off where a submission is only marked late, without by how much [points]; None: a person must look."""
    exceptions: tuple[LateException, ...]


class Lateness(Struct, frozen=True):
    """What the rule makes of one submission."""

    seconds: float | None  # late by this, 0 for in time; None where nothing tells
    deduct: float  # [points]
    reason: str  # in words; "" for in time
    look: bool  # True where a person must decide


def parse_duration(text: str) -> float | None:
    """Read a duration, "15 min", "1 day" or "36 h" [s]; None where it is none."""
    match = _DURATION.fullmatch(text)
    if match is None:
        return None
    word = match[2].lower()
    unit = _SECONDS.get(word) or _SECONDS.get(word.removesuffix("s"))
    return None if unit is None else float(match[1]) * unit


def duration_text(seconds: float) -> str:
    """Write a duration [s]: "3 h 20 min", "2 days 4 h"; two units at most, cut off, not rounded."""
    if seconds < 60:
        return f"{seconds:.0f} s"
    days, rest = divmod(int(seconds), 86400)
    hours, rest = divmod(rest, 3600)
    minutes = rest // 60
    parts = [(days, "day" if days == 1 else "days"), (hours, "h"), (minutes, "min")]
    while parts[0][0] == 0:
        parts.pop(0)
    return " ".join(f"{count} {unit}" for count, unit in parts[:2] if count)


def read_late(top: Table, points: float) -> LateRule | None:
    """Read the table ``[late]`` of a rubric; None where there is none."""
    table = top.table("late")
    if table is None:
        return None
    due = table.time("due", "2026-03-09T23:59:00+01:00")
    grace = _duration(table, "grace") or 0.0
    tiers: list[Tier] = []
    for one in table.tables("tier"):
        until = _duration(one, "until", required=True)
        deduct = one.deduction("deduct", points, points, required=True)
        one.done()
        if until is not None:
            if tiers and until <= tiers[-1].until:
                one.wrong("until", "is not later than the tier before it", "write the tiers in rising order")
            tiers.append(Tier(until, deduct))
    beyond = table.deduction("beyond", points, points)
    marked = table.deduction("marked", points, 0.0)
    exceptions = tuple(_exception(one) for one in table.tables("exception"))
    table.done()
    return LateRule(due, grace, tuple(tiers), beyond, marked if "marked" in table.values else None, exceptions)


def _exception(table: Table) -> LateException:
    student = table.text("student", '"s001234"', required=True) or ""
    due = table.time("due", "2026-03-16T23:59:00+01:00")
    extra = _duration(table, "extra")
    waive = bool(table.take("waive", (bool,), "true"))
    table.done()
    if sum(key in table.values for key in ("due", "extra", "waive")) != 1:
        hint = 'write due = 2026-03-16T23:59:00+01:00, or extra = "2 days", or waive = true'
        table.faults.add(
            RUBRIC_VALUE_CANNOT_BE_USED, table.path, "an exception says exactly one of due, extra and waive", hint
        )
    return LateException(student, due, extra, waive)


def _duration(table: Table, key: str, required: bool = False) -> float | None:
    text = table.text(key, '"1 day"', required)
    if text is None:
        return None
    seconds = parse_duration(text)
    if seconds is None:
        table.wrong(key, f'{key} = "{text[:40]}" is no duration', f'write {key} = "15 min", "36 h" or "2 days"')
    return seconds


def judge_lateness(
    rule: LateRule | None, keys: Mapping[str, str], late: bool, late_seconds: float | None, submitted: str | None
) -> Lateness:
    """Say what lateness costs by the submission's own marks and stamps, never the clock; nothing without a rule."""
    if rule is None:
        after = f"{duration_text(late_seconds)} late" if late_seconds else "marked late" if late else ""
        return Lateness(late_seconds, 0.0, after, False)
    called = {value.casefold() for value in keys.values()}
    excepted = next((one for one in rule.exceptions if one.student.casefold() in called), None)
    if excepted is not None and excepted.waive:
        return Lateness(late_seconds, 0.0, "lateness waived for you" if late or late_seconds else "", False)
    seconds = _seconds_late(rule, excepted, late, late_seconds, submitted)
    if seconds is None:
        if rule.marked is None or excepted is not None:
            return Lateness(None, 0.0, "marked late, but nothing says by how much", True)
        return Lateness(None, rule.marked, "marked late, without the time", False)
    if seconds <= rule.grace:
        reason = f"{duration_text(seconds)} after the deadline, within the grace time" if seconds > 0 else ""
        return Lateness(max(0.0, seconds), 0.0, reason, False)
    deduct = next((tier.deduct for tier in rule.tiers if seconds <= tier.until), rule.beyond)
    return Lateness(seconds, deduct, f"{duration_text(seconds)} late", False)


def _seconds_late(
    rule: LateRule, excepted: LateException | None, late: bool, late_seconds: float | None, submitted: str | None
) -> float | None:
    """Late by this [s], negative for early; None where it is late and nothing says by how much."""
    due = excepted.due if excepted and excepted.due else rule.due
    extra = (excepted.extra or 0.0) if excepted else 0.0
    stamp = _stamp(submitted)
    if due is not None and stamp is not None:
        # A stamp without a zone is on the course's own clock, and so is a deadline without one.
        if due.tzinfo is None or stamp.tzinfo is None:
            zone = due.tzinfo or stamp.tzinfo
            due, stamp = (one.replace(tzinfo=one.tzinfo or zone) for one in (due, stamp))
        return (stamp - due).total_seconds() - extra
    if excepted is not None and excepted.due is not None and late:
        return None  # the platform counts from another deadline
    if late_seconds is not None:
        return late_seconds - extra
    return None if late else 0.0


def _stamp(submitted: str | None) -> dt.datetime | None:
    try:
        return dt.datetime.fromisoformat(submitted) if submitted else None
    except ValueError:
        return None
