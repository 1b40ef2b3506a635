"""Uncertainties that a log states far over the usual.

A person is asked about them, and the log is judged by the usual uncertainties.

A log may say how well it was measured. If its statements could be anything, a wrong
answer would agree with runs that say nothing, and numbers that contradict each other
would not. So each stated uncertainty is compared with the one that the log would have
without the statement: that of the bench if the rubric states it, else the default.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities.error_sources import SOURCES, TRANSVERSE_U
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import (
    SHARED_UNCERTAINTIES,
    Column,
    Faults,
    Reading,
    Readings,
    as_u_of,
    to_display,
    u_keys,
)
from gyrodata.readings.roles import ORIGIN_LENGTHS
from gyrodata.readings.settings import Given, read_settings

OVER_USUAL, OVER_BENCH = 5.0, 2.0
"""A larger stated uncertainty, in units of the default or of that of the bench, is a
question to a person."""

_LIKE = {
    "spin_time": "time",
    "spin_time_start": "time",
    "spin_time_end": "time",
    "precession_period": "time",
    "turns": "angle",
    "nutation_period": "transverse_inertia",
}
"""Roles with the default of another source than that of their name or part."""

_RULER = Uncertainty(0.0005)  # a ruler is read to half a millimetre [m]
_LEAST = {
    "position": _RULER,
    "weight_diameter": Uncertainty(0.0, 0.05),
    # Without a statement about I it is 20 %.
    "transverse_inertia": Uncertainty(0.0, TRANSVERSE_U / OVER_USUAL),
}
"""What is usual, where the default is nothing or the rounding alone."""

G = 9.81  # [m/s²]


class Usual(Struct, frozen=True):
    """The uncertainty that a quantity has without a statement of the log."""

    u: Uncertainty
    words: str
    of_bench: Uncertainty | None = None

    def allows(self, stated: Uncertainty, value: float, rounding: float = 0.0) -> bool:
        """Return whether a stated uncertainty is not far larger than the usual.

        It is the uncertainty of a value that was rounded with the uncertainty
        `rounding`.
        """
        usual = self.u.at(value) + rounding
        if self.of_bench is None:
            return stated.at(value) <= OVER_USUAL * usual
        return stated.at(value) <= max(OVER_BENCH * self.of_bench.at(value), usual)


def with_usual(
    readings: Readings, bench: Mapping[str, str]
) -> tuple[Readings, tuple[str, ...]]:
    """Return a log without the uncertainties that are far over the usual, and these in words.

    `bench`: The lines of ``[bench]`` of the rubric. A log without such a statement is
    returned as it is.
    """
    known = _of_bench(bench)
    told: dict[str, str] = {}
    for role, column in readings.columns.items():
        wide = _too_wide(column, _usual_of_role(role, known), _counts(readings, role))
        for u in dict.fromkeys(wide.values()):
            key = _line_of(readings, role, u)
            words = readings.uncertainties[key] if key else u
            told.setdefault(
                key or f"u_{role}",
                _in_words(key or role, words, _usual_of_role(role, known)),
            )
            readings = _without(readings, role, u, known)
    for key in [key for key in readings.uncertainties if key in SHARED_UNCERTAINTIES]:
        source = key.removeprefix("u_")
        if source not in SOURCES:
            continue
        usual = _usual_of_source(source, key, known)
        if not usual.allows(
            readings.uncertainties[key], _typical(readings, SOURCES[source].quantity)
        ):
            told[key] = _in_words(key, readings.uncertainties[key], usual)
            readings = _with_shared(readings, key, usual.of_bench)
    usual = _usual_of_source("position_zero", "u_position_zero", known)
    if not usual.allows(Uncertainty(readings.origin_u), 0.0):
        key = f"u_{ORIGIN_LENGTHS[readings.position_from or 'surface'][0]}"
        told[key] = _in_words(key, Uncertainty(readings.origin_u), usual)
        readings = replace(readings, origin_u=usual.u.absolute)
    return readings, tuple(told.values())


_PARTS = (12, 8, 10)
"""Usual parts of a turn are multiples of one over these numbers."""
_SMALL_PARTS, _SMALL = 36, 0.25
"""Multiples of 10° are usual below a quarter of a turn, and in a column of angles."""


def unusual_turns(readings: Readings) -> str:
    """Say that most runs have a number of turns that nobody aims at, such as 0.8547.

    By such a number, all times can be made to fit any answer. Numbers that differ from
    run to run are measured. Returns "" if all is usual.
    """
    column = readings.columns.get("turns") or readings.columns.get("angle")
    if column is None:
        return ""
    unusual = [
        one.value
        for one in column.readings
        if one.value and not _is_usual_part(column.role, one.value, one.step or 0.0)
    ]
    repeated = [value for value in unusual if unusual.count(value) > 1]
    if 2 * len(repeated) < len(column.readings):
        return ""
    size, unit = to_display(repeated[0], column.role)
    typed = f"{size:.4g} {unit}".rstrip()
    return f"{len(repeated)} runs have an unusual number of {column.role}: {typed}"


def _is_usual_part(role: str, value: float, step: float) -> bool:
    """Return whether people aim at a number of turns, or at an angle [rad]."""
    whole = 2 * math.pi if role == "angle" else 1.0
    turns, rounding = abs(value) / whole, 0.5 * step / whole + 1e-6
    has_small = role == "angle" or turns < _SMALL
    parts = (*_PARTS, _SMALL_PARTS) if has_small else _PARTS
    return any(abs(turns - round(turns * one) / one) <= rounding for one in parts)


def _in_words(key: str, u: Uncertainty, usual: Usual) -> str:
    name = key if key.startswith("u_") else f"u_{key}"
    return f"{name} {_words_of(u, key)} ({usual.words})"


def _words_of(u: Uncertainty, key: str) -> str:
    """Write an uncertainty with three digits.

    Its unit is the unit in which its quantity is usually shown.
    """
    size, unit = to_display(u.absolute, key)
    parts = [f"{100 * u.relative:.3g} %"] if u.relative else []
    parts += [f"{size:.3g} {unit}".rstrip()] if u.absolute else []
    return " + ".join(parts)


def _of_bench(lines: Mapping[str, str]) -> dict[str, Uncertainty]:
    """Read the uncertainties that a rubric states for the bench, by their keys."""
    given = [
        Given(key, text, key, None)
        for key, text in lines.items()
        if key.startswith("u_")
    ]
    return read_settings([], [], given, Faults(""), True).uncertainties


def _usual_of_role(role: str, bench: Mapping[str, Uncertainty]) -> Usual:
    """Return the uncertainty that the readings of a column have without a statement."""
    source = _LIKE.get(role) or ("spin" if role.startswith("spin") else role)
    if source not in SOURCES:
        return Usual(Uncertainty(math.inf), "")
    kind, usual = SOURCES[source], _LEAST.get(source, SOURCES[source].default)
    # The default of an angle is a number of turns.
    usual = as_u_of("angle", "u_turns", usual) if role == "angle" else usual
    stated = next(
        (as_u_of(role, key, bench[key]) for key in u_keys(role) if key in bench), None
    )
    return Usual(usual, _usual_words(kind.usual, stated, role), stated)


def _usual_of_source(source: str, key: str, bench: Mapping[str, Uncertainty]) -> Usual:
    """Return the uncertainty that a whole log has without a statement."""
    return Usual(
        SOURCES[source].default,
        _usual_words(SOURCES[source].usual, bench.get(key), key),
        bench.get(key),
    )


def _usual_words(usual: str, stated: Uncertainty | None, key: str) -> str:
    if stated is None:
        return f"usual: {usual}"
    return f"that of the bench: {_words_of(stated, key)}"


def _counts(readings: Readings, role: str) -> list[float]:
    """Return the number of turns by which the time of each run was divided.

    The result of this division is the reading of a role.
    """
    turns = readings.columns.get("turns")
    if role != "precession_period" or turns is None:
        return [1.0] * len(readings.runs)
    return [value or 1.0 for value in turns.values]


def _too_wide(
    column: Column, usual: Usual, counts: list[float]
) -> dict[int, Uncertainty]:
    """Return the stated uncertainties of a column that are far over the usual, by run.

    They belong to the readings of the column.
    """
    found = {}
    for run, u in column.stated:
        value = column.values[run]
        divided = Uncertainty(u.absolute * counts[run], u.relative)
        if value is not None and not usual.allows(
            divided, value, column.steps[run] / math.sqrt(12)
        ):
            found[run] = u
    return found


def _without(
    readings: Readings, role: str, u: Uncertainty, bench: Mapping[str, Uncertainty]
) -> Readings:
    """Return a log in which no reading of a role has this uncertainty."""
    column = readings.columns[role]
    of_bench = next(
        (as_u_of(role, key, bench[key]) for key in u_keys(role) if key in bench), None
    )

    def usual(one: Reading) -> Reading:
        return replace(one, u=of_bench) if one.u == u else one

    columns = {
        **readings.columns,
        role: replace(column, readings=tuple(map(usual, column.readings))),
    }
    readings = replace(readings, columns=columns)
    while key := _line_of(readings, role, u):
        readings = _with_shared(readings, key, None)
    return readings


def _line_of(readings: Readings, role: str, u: Uncertainty) -> str:
    """Return the key of the line that states an uncertainty for all readings of a role.

    "" if none does.
    """
    known = readings.uncertainties
    return next(
        (
            key
            for key in u_keys(role)
            if key in known and as_u_of(role, key, known[key]) == u
        ),
        "",
    )


def _with_shared(readings: Readings, key: str, u: Uncertainty | None) -> Readings:
    """Return a log with another uncertainty in one of its lines, or without that line."""
    left = {one: stated for one, stated in readings.uncertainties.items() if one != key}
    places = {one: place for one, place in readings.stated_at.items() if one != key}
    return replace(
        readings,
        uncertainties=left if u is None else {**left, key: u},
        stated_at=places,
    )


def _typical(readings: Readings, quantity: str) -> float:
    """Return the size of a quantity in a log [SI unit]."""
    column = readings.columns.get(quantity)
    sizes = (
        [abs(value) for value in column.values if value] if column is not None else []
    )
    return statistics.median(sizes) if sizes else {"g": G}.get(quantity, 1.0)
