"""The gyroscope of each station: I_zz by the logs of a class, and whether it drifts.

The logs of a station are not fitted together: with eight logs, this takes fifty times
as long as their own fits, and a wrong log would change the result. Instead, the values
of the logs are combined so that a wrong one changes little.
"""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from msgspec import Struct

from gyrodata.fitting import MAD_TO_SD, chi2_tail
from gyrodata.grading.yardsticks import Reference, by_station, grouped, in_order
from gyrodata.physics import Floats
from gyrodata.readings.blocks import day_of
from gyrodata.reporting.values import count_text, inertia_text, p_text

if TYPE_CHECKING:
    from gyrodata.grading.grade import Grade
    from gyrodata.results import FittedLog

# --- values of which a few may be wrong ---

PULL, GROSS = 2.0, 5.0
"""A value that is farther from the median than the first [standard deviations of all]
counts as if it were at this distance; beyond the second, it does not count."""

LEAST_SCATTER = 0.5
"""The scatter of a few values may be small by chance: it is at least this, over u."""


class Robust(NamedTuple):
    """The n values of I_zz of one station."""

    values: Floats  # far ones moved towards the median [kg*m^2], shape (n,)
    weights: Floats  # 0 for a gross error [1/(kg*m^2)²], shape (n,)
    scatter: float  # over u [1]

    @property
    def mean(self) -> tuple[float, float]:
        """The weighted mean and its standard uncertainty [kg*m^2]."""
        total = self.weights.sum()
        u = max(self.scatter, 1.0) / math.sqrt(total)
        return float(self.weights @ self.values / total), u

    @property
    def spread(self) -> float:
        """The standard deviation of a usual value [kg*m^2]."""
        used = np.count_nonzero(self.weights)
        return self.scatter * math.sqrt(used / self.weights.sum())


def robust(values: Iterable[tuple[float, float]]) -> Robust:
    """Prepare values with their u [kg*m^2] for a mean or a line.

    No u counts as smaller than the median of all: a log that states a tiny uncertainty
    does not decide alone.
    """
    value, u = np.array(list(values)).T
    middle = np.median(value)
    least = max(np.median(u), 1e-9 * abs(middle))
    u = np.maximum(u, least)
    away = (value - middle) / u
    scatter = MAD_TO_SD * float(np.median(np.abs(away)))
    scatter = max(scatter, LEAST_SCATTER)
    most = PULL * scatter
    moved = middle + u * np.clip(away, -most, most)
    counts = np.abs(away) <= GROSS * scatter
    return Robust(moved, counts / u**2, scatter)


# --- the class as its own reference ---

FEW = 5  # a station with fewer logs than this is compared with the whole class


def each_log_once(
    grades: Iterable[Grade], same_data: Iterable[Iterable[str]] = ()
) -> list[Grade]:
    """Return a grade for each different log, however many students hand it in.

    Logs are equal if station, I_zz and u are. `same_data`: Groups of students with the
    same data: partners, and those whose logs are flagged. Of ["ann", "bob"] and
    ["bob", "cat"], "ann" and "cat" count, because "bob" is in the group of "ann".
    """
    groups_of = grouped(
        (student, number) for number, some in enumerate(same_data) for student in some
    )
    counted = set[int]()
    logs = {}
    for grade in grades:
        groups = groups_of.get(grade.student, [])
        if grade.own and counted.isdisjoint(groups):
            counted.update(groups)
            logs[grade.station, grade.inertia, grade.inertia_u] = grade
    return list(logs.values())


def class_references(
    values: Iterable[tuple[str | None, float, float]],
) -> dict[str, Reference]:
    """Return the reference of each station with at least `FEW` logs.

    The key "all" is for every other station.

    `values`: For each log its station (or None), I_zz and its u [kg*m^2], in any order.
    For "all", u is the scatter itself, because the gyroscopes may differ. It is never
    smaller than the u of the logs allow.
    """
    references = {}
    logs = ((station, (value, u)) for station, value, u in values)
    for station, some in by_station(logs, FEW).items():
        number = len(some)
        combined = robust(sorted(some))
        mean, u = combined.mean
        words = f"the {number} logs of station {station}"
        if station == "all":
            words = f"all {number} logs"
            u = max(u, combined.spread)
        source = f"the mean of {words}"
        if number == 1:
            source = "this log alone"
        references[station] = Reference(mean, u, source)
    return references


# --- a station on several days ---

RARE = 0.01
"""An honest class has a station with a note with at most this probability."""

OF_DAY = 0.3
"""Standard deviation of an error that all logs of a day share, over the u of a log: the
balance of the ball on this day. An M0 of 1 mN·m gives a quarter of u."""

YEAR = 366  # days; a longer time between logs of one class is a mistyped date

MOST_DAYS = 100  # of a station; nobody measures on more

_FORMS = "%d.%m.%Y", "%d.%m.%y", "%Y/%m/%d", "%d %B %Y", "%d %b %Y", "%B %d, %Y"
"""Dates that mean one day only, besides those of ISO 8601."""


class DayValue(NamedTuple):
    """I_zz that a log gives on one of its days."""

    day: str  # an ISO date, or the words of the log in small letters
    inertia: float  # [kg*m^2]
    u: float  # [kg*m^2]


def day_values(analysis: FittedLog) -> tuple[DayValue, ...]:
    """Return I_zz of each day of a log; nothing if it names no day."""
    values = {block.name: block.inertia for block in analysis.blocks}
    day = day_of(analysis.readings)
    if day:
        values = {day: analysis.inertia}
    days = []
    for day, inertia in values.items():
        if inertia is not None and inertia.u:
            days.append(DayValue(_name_of(day), inertia.value, inertia.u))
    return tuple(days)


def _name_of(day: str) -> str:
    """Write a date in the form of ISO 8601, and other words in small letters."""
    text = " ".join(day.split())
    with suppress(ValueError):
        return dt.date.fromisoformat(text).isoformat()
    for form in _FORMS:
        with suppress(ValueError):
            return dt.datetime.strptime(text, form).date().isoformat()
    return text.casefold()[:40]


def _number_of(day: str) -> float:
    """Return the number of a day, of which the zero does not matter, or NaN."""
    with suppress(ValueError):
        return float(dt.date.fromisoformat(day).toordinal())
    return float(day) if day.isdecimal() else math.nan


class DayFigures(Struct, frozen=True):
    """The logs of one station on one day."""

    day: str
    """ISO 8601, if the logs have a date."""
    logs: int
    inertia: float
    """The mean of their I_zz, in which a log far from the others counts little
    [kg*m^2]."""
    u: float
    """[kg*m^2]"""


class StationFigures(Struct, frozen=True):
    """The gyroscope of one station on several days."""

    station: str
    days: tuple[DayFigures, ...]
    slope: float | None
    """Relative change of I_zz a day [1/day]; null if the days have no dates or numbers,
    or if the days differ in another way."""
    slope_u: float | None
    """[1/day]"""
    p: float
    """Probability of such a change or of such differences by chance, times the number
    of tests."""

    @property
    def differs(self) -> bool:
        """Return whether chance alone hardly explains the change."""
        return self.p < RARE

    @property
    def change(self) -> str:
        """Say how I_zz changes."""
        if self.slope is None or not self.slope_u:
            days = [
                f"{day.day}: {inertia_text(day.inertia, day.u)}" for day in self.days
            ]
            return f"differs between the days ({'; '.join(days)})"
        verb = "falls" if self.slope < 0 else "rises"
        percent = f"{100 * abs(self.slope):.2g} %"
        u = f"{100 * self.slope_u:.2g} %"
        return f"{verb} by {percent} a day (u {u})"

    @property
    def words(self) -> str:
        """Say whether and how I_zz changes, and what to do."""
        if self.differs:
            return (
                f"station {self.station}: I_zz {self.change}, {p_text(self.p)} by "
                f"chance: look at the ball or its balance"
            )
        logs = count_text(sum(day.logs for day in self.days), "log")
        what = f"the {logs} of {len(self.days)} days"
        return f"station {self.station}: {what} agree within chance ({p_text(self.p)})"


def station_figures(logs: Iterable[Grade]) -> Iterator[StationFigures]:
    """Yield the figures of each station whose logs are of several days.

    `logs`: A grade for each different log.
    """
    values = grouped(
        (log.station, value) for log in logs if log.station for value in log.days
    )
    several = {}
    for station, some in values.items():
        days = {value.day for value in some}
        if len(some) >= FEW and 1 < len(days) <= MOST_DAYS:
            several[station] = sorted(some)
    for station in sorted(several, key=in_order):
        yield _figures(station, several[station], 2 * len(several))


def _figures(station: str, values: Sequence[DayValue], tests: int) -> StationFigures:
    """Compare the means of the days with each other and, if possible, with a line."""
    # A wrong log is seen among all of the station, and not among the few of a day.
    is_usual = robust((inertia, u) for _, inertia, u in values).weights > 0
    usual = [value for value, used in zip(values, is_usual, strict=True) if used]
    by_day = grouped((day, (inertia, u)) for day, inertia, u in usual)
    figures = []
    for day, some in by_day.items():
        mean, u = robust(some).mean
        figures.append(DayFigures(day, len(some), mean, u))
    # A log that is alone on its day shows no scatter.
    p, slope, slope_u = _compare([day for day in figures if day.logs > 1])
    return StationFigures(station, tuple(figures), slope, slope_u, min(1.0, p * tests))


def _compare(
    days: Sequence[DayFigures],
) -> tuple[float, float | None, float | None]:
    """Return p of the differences of days, or p of a line with its slope and u."""
    if len(days) < 2:
        return 1.0, None, None
    means = np.array([day.inertia for day in days])
    variance = [day.u**2 * (1 + day.logs * OF_DAY**2) for day in days]
    weights = 1 / np.array(variance)
    mean = float(np.average(means, weights=weights))
    chi2 = float(weights @ (means - mean) ** 2)
    p = chi2_tail(chi2, len(days) - 1)
    numbers = np.array([_number_of(day.day) for day in days])
    if not 0 < np.ptp(numbers) <= YEAR:
        return p, None, None
    numbers -= np.average(numbers, weights=weights)
    information = float(weights @ numbers**2)
    rise = float(weights * numbers @ means) / information
    p_of_line = chi2_tail(rise**2 * information, 1)
    if p_of_line > p:
        return p, None, None
    return p_of_line, rise / mean, 1 / (math.sqrt(information) * mean)
