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
    """Return a log without uncertainties if one is far too large, and these in words.

    `bench`: The lines of ``[bench]`` of the rubric. A log without such a statement is
    returned as it is.
    """
    known = _of_bench(bench)
    wide = {**_wide_columns(readings, known), **_wide_sources(readings, known)}
    usual = _usual_of_source("position_zero", "u_position_zero", known)
    origin_u = readings.origin_u
    if not usual.allows(Uncertainty(origin_u), 0.0):
        key = f"u_{ORIGIN_LENGTHS[readings.position_from or 'surface'][0]}"
        wide[key] = _in_words(key, Uncertainty(origin_u), usual)
        origin_u = usual.u.absolute
    if not wide:
        return readings, ()
    columns = {}
    for role, column in readings.columns.items():
        u = _stated_by_bench(role, known)
        cells = tuple(replace(cell, u=u) for cell in column.readings)
        columns[role] = replace(column, readings=cells)
    shared = {key: u for key, u in known.items() if key in SHARED_UNCERTAINTIES}
    readings = replace(
        readings,
        columns=columns,
        uncertainties=shared,
        stated_at={},
        origin_u=origin_u,
    )
    return readings, tuple(wide.values())


def _wide_columns(
    readings: Readings, bench: Mapping[str, Uncertainty]
) -> dict[str, str]:
    """Return the uncertainties of readings that are far over the usual, in words."""
    wide: dict[str, str] = {}
    for role, column in readings.columns.items():
        usual = _usual_of_role(role, bench)
        for u in _too_wide(column, usual, _counts(readings, role)):
            key = _line_of(readings, role, u)
            words = readings.uncertainties[key] if key else u
            wide.setdefault(key or f"u_{role}", _in_words(key or role, words, usual))
    return wide


def _wide_sources(
    readings: Readings, bench: Mapping[str, Uncertainty]
) -> dict[str, str]:
    """Return the uncertainties of the whole log that are far too large, in words."""
    wide = {}
    for key, u in readings.uncertainties.items():
        source = key.removeprefix("u_")
        if key not in SHARED_UNCERTAINTIES or source not in SOURCES:
            continue
        usual = _usual_of_source(source, key, bench)
        if not usual.allows(u, _typical(readings, SOURCES[source].quantity)):
            wide[key] = _in_words(key, u, usual)
    return wide


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
    turns = abs(value) / whole
    rounding = 0.5 * step / whole + 1e-6
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


def _stated_by_bench(role: str, bench: Mapping[str, Uncertainty]) -> Uncertainty | None:
    """Return the uncertainty that a rubric states for the readings of a column."""
    for key in u_keys(role):
        if key in bench:
            return as_u_of(role, key, bench[key])
    return None


def _usual_of_role(role: str, bench: Mapping[str, Uncertainty]) -> Usual:
    """Return the uncertainty that the readings of a column have without a statement."""
    source = _LIKE.get(role) or ("spin" if role.startswith("spin") else role)
    if source not in SOURCES:
        return Usual(Uncertainty(math.inf), "")
    usual = _LEAST.get(source, SOURCES[source].default)
    if role == "angle":
        # The default of an angle is a number of turns.
        usual = as_u_of("angle", "u_turns", usual)
    stated = _stated_by_bench(role, bench)
    return Usual(usual, _usual_words(SOURCES[source].usual, stated, role), stated)


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


def _too_wide(column: Column, usual: Usual, counts: list[float]) -> list[Uncertainty]:
    """Return the stated uncertainties of a column that are far over the usual."""
    wide = []
    for run, u in column.stated:
        value = column.values[run]
        divided = Uncertainty(u.absolute * counts[run], u.relative)
        rounding = column.steps[run] / math.sqrt(12)
        if value is not None and not usual.allows(divided, value, rounding):
            wide.append(u)
    return wide


def _line_of(readings: Readings, role: str, u: Uncertainty) -> str:
    """Return the key of the line that states an uncertainty for a role; "" for none."""
    known = readings.uncertainties
    for key in u_keys(role):
        if key in known and as_u_of(role, key, known[key]) == u:
            return key
    return ""


def _typical(readings: Readings, quantity: str) -> float:
    """Return the size of a quantity in a log [SI unit]."""
    column = readings.columns.get(quantity)
    sizes = (
        [abs(value) for value in column.values if value] if column is not None else []
    )
    return statistics.median(sizes) if sizes else {"g": G}.get(quantity, 1.0)
