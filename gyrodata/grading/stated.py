"""What a log states about itself that could make any answer agree with its runs.

Those are uncertainties far over the usual, days, and unusual numbers of turns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from msgspec.structs import replace

from gyrodata.quantities.error_sources import SOURCES
from gyrodata.readings import SHARED_UNCERTAINTIES, Faults, Readings, to_display
from gyrodata.readings.roles import stated_u
from gyrodata.readings.settings import Setting, read_settings


def list_stated(readings: Readings) -> list[str]:
    """List what a log states that widens u: uncertainties by their names, and days."""
    lines = list(readings.uncertainties)
    columns = [
        f"u_{role}" for role, column in readings.columns.items() if column.stated
    ]
    others = []
    if readings.origin_u:
        others.append("of the length to the origin")
    if readings.blocks:
        others.append("of each day or group")
    return [*dict.fromkeys([*lines, *columns]), *others]


def with_usual(readings: Readings, bench: Mapping[str, str]) -> Readings:
    """Return a log with the usual uncertainties instead of its own.

    `bench`: The lines of ``[bench]`` of the rubric, whose uncertainties go before the
    default ones.
    """
    own_u = {key: text for key, text in bench.items() if key.startswith("u_")}
    lines = [Setting(key, text, key, None) for key, text in own_u.items()]
    known = read_settings([], [], lines, Faults(""), True).uncertainties
    columns = {}
    for role, column in readings.columns.items():
        u = stated_u(role, known)
        cells = tuple(replace(cell, u=u) for cell in column.readings)
        columns[role] = replace(column, readings=cells)
    shared = {key: u for key, u in known.items() if key in SHARED_UNCERTAINTIES}
    origin_u = min(readings.origin_u, SOURCES["position_zero"].default.absolute)
    made = {"columns": columns, "uncertainties": shared, "origin_u": origin_u}
    return replace(readings, **made, stated_at={})


_PARTS = (12, 8, 10)
"""Usual parts of a turn are multiples of one over these numbers."""
_SMALL_PARTS, _SMALL = 36, 0.25
"""Multiples of 10° are usual below a quarter of a turn, and in a column of angles."""


def _is_part(turns: float, step: float, has_small: bool) -> bool:
    """Return whether people aim at a number of turns, or at such a part of one."""
    rounding = 0.5 * step + 1e-6
    parts = [*_PARTS]
    if has_small or abs(turns) < _SMALL:
        parts.append(_SMALL_PARTS)
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
