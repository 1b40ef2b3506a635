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
    Faults,
    Readings,
    as_u_of,
    to_display,
)
from gyrodata.readings.roles import ORIGIN_LENGTHS, stated_u
from gyrodata.readings.settings import Setting, read_settings

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
        most = self.u.at(value) + rounding
        if self.of_bench is None:
            most *= OVER_USUAL
        else:
            most = max(most, OVER_BENCH * self.of_bench.at(value))
        return stated.at(value) <= most


def with_usual(
    readings: Readings, bench: Mapping[str, str]
) -> tuple[Readings, tuple[str, ...]]:
    """Return a log without uncertainties if one is far too large, and these in words.

    `bench`: The lines of ``[bench]`` of the rubric. A log without such a statement is
    returned as it is.
    """
    lines = [
        Setting(key, text, key, None)
        for key, text in bench.items()
        if key.startswith("u_")
    ]
    known = read_settings([], [], lines, Faults(""), True).uncertainties
    wide = _wide_lines(readings, known) or _wide_columns(readings, known)
    usual = _usual("position_zero", "u_position_zero", known.get("u_position_zero"))
    origin_u = Uncertainty(readings.origin_u)
    if not usual.allows(origin_u, 0.0):
        key = f"u_{ORIGIN_LENGTHS[readings.position_from or 'surface'][0]}"
        wide = [*wide, _in_words(key, origin_u, usual)]
        readings = replace(readings, origin_u=usual.u.absolute)
    if not wide:
        return readings, ()
    columns = {}
    for role, column in readings.columns.items():
        u = stated_u(role, known)
        cells = tuple(replace(cell, u=u) for cell in column.readings)
        columns[role] = replace(column, readings=cells)
    shared = {key: u for key, u in known.items() if key in SHARED_UNCERTAINTIES}
    readings = replace(readings, columns=columns, uncertainties=shared, stated_at={})
    return readings, tuple(wide)


def _wide_lines(readings: Readings, bench: Mapping[str, Uncertainty]) -> list[str]:
    """Return the uncertainties in lines of the log that are far too large, in words."""
    wide = []
    for key, u in readings.uncertainties.items():
        source = key.removeprefix("u_")
        usual = _usual(source, key, bench.get(key))
        quantity = source
        if key in SHARED_UNCERTAINTIES and source in SOURCES:
            quantity = SOURCES[source].quantity
        if not usual.allows(u, *_typical(readings, quantity)):
            wide.append(_in_words(key, u, usual))
    return wide


def _wide_columns(readings: Readings, bench: Mapping[str, Uncertainty]) -> list[str]:
    """Return the uncertainties of readings that are far over the usual, in words."""
    wide = {}
    for role, column in readings.columns.items():
        source = _LIKE.get(role) or ("spin" if role.startswith("spin") else role)
        usual = _usual(source, role, stated_u(role, bench))
        turns = readings.columns.get("turns") if role == "precession_period" else None
        for run, u in column.stated:
            value = column.values[run]
            rounding = column.steps[run] / math.sqrt(12)
            # The time of a run was divided by its turns, and so was its uncertainty.
            count = (turns.values[run] if turns else None) or 1.0
            divided = Uncertainty(u.absolute * count, u.relative)
            if value is not None and not usual.allows(divided, value, rounding):
                wide[role] = _in_words(role, u, usual)
    return list(wide.values())


def _usual(source: str, key: str, stated: Uncertainty | None) -> Usual:
    """Return the uncertainty that readings or a whole log have without a statement.

    `stated`: That of the bench, if a rubric states it.
    """
    if source not in SOURCES:
        return Usual(Uncertainty(math.inf), "")
    usual = _LEAST.get(source, SOURCES[source].default)
    if key == "angle":
        # The default of an angle is a number of turns.
        usual = as_u_of("angle", "u_turns", usual)
    words = f"usual: {SOURCES[source].usual}"
    if stated is not None:
        words = f"that of the bench: {_words_of(stated, key)}"
    return Usual(usual, words, stated)


def _in_words(key: str, u: Uncertainty, usual: Usual) -> str:
    return f"u_{key.removeprefix('u_')} {_words_of(u, key)} ({usual.words})"


def _words_of(u: Uncertainty, key: str) -> str:
    """Write an uncertainty with three digits.

    Its unit is the unit in which its quantity is usually shown.
    """
    size, unit = to_display(u.absolute, key)
    parts = [f"{100 * u.relative:.3g} %"] if u.relative else []
    parts += [f"{size:.3g} {unit}".rstrip()] if u.absolute else []
    return " + ".join(parts)


def _typical(readings: Readings, quantity: str) -> tuple[float, float]:
    """Return the size of a quantity in a log, and u of its rounding [SI unit]."""
    column = readings.columns.get(quantity)
    sizes = [abs(value) for value in column.values if value] if column else []
    if column is None or not sizes:
        return {"g": G}.get(quantity, 1.0), 0.0
    return statistics.median(sizes), statistics.median(column.steps) / math.sqrt(12)


_PARTS = (12, 8, 10)
"""Usual parts of a turn are multiples of one over these numbers."""
_SMALL_PARTS, _SMALL = 36, 0.25
"""Multiples of 10° are usual below a quarter of a turn, and in a column of angles."""


def _is_part(turns: float, step: float, has_small: bool) -> bool:
    """Return whether people aim at a number of turns, or at such a part of one."""
    rounding = 0.5 * step + 1e-6
    parts = (*_PARTS, _SMALL_PARTS) if has_small or abs(turns) < _SMALL else _PARTS
    return any(abs(turns - round(turns * n) / n) <= rounding for n in parts)


def unusual_turns(readings: Readings) -> str:
    """Say that most runs have a number of turns that nobody aims at, such as 0.8547.

    By such a number, all times can be made to fit any answer. Numbers that differ from
    run to run are measured. Returns "" if all is usual.
    """
    column = readings.columns.get("turns") or readings.columns.get("angle")
    if column is None:
        return ""
    is_angle = column.role == "angle"
    whole = 2 * math.pi if is_angle else 1.0
    values = [turns or 0.0 for turns in column.values]
    unusual = [
        value
        for value, step in zip(values, column.steps, strict=True)
        if not _is_part(value / whole, step / whole, is_angle)
    ]
    repeated = [value for value in unusual if unusual.count(value) > 1]
    if 2 * len(repeated) < len(column.readings):
        return ""
    size, unit = to_display(repeated[0], column.role)
    typed = f"{size:.4g} {unit}".rstrip()
    return f"{len(repeated)} runs have an unusual number of {column.role}: {typed}"
