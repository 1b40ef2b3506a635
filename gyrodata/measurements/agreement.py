"""Columns that should agree: what is derived in the log against what the readings give."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from gyrodata.errors import Diagnostic, register
from gyrodata.measurements.spins import spin_columns
from gyrodata.physics import Floats
from gyrodata.readings import Column, Readings

if TYPE_CHECKING:
    from gyrodata.measurements.measured import Measurements

G401 = register(
    "G401",
    "warning",
    "a derived column disagrees with the readings",
    "mass [g],position [cm],spin [rpm],time [s],turns,precession period [s]\n20.00,15.0,400,39.7,1,13.2\n",
)

G405 = register(
    "G405",
    "warning",
    "the precession is faster than the spin",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20.00,15.0,4,0.397,1\n",
)


def find_contradictions(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Name the rows where a derived column (period, rate, torque, inertia, second spin) disagrees."""
    rate = 2 * np.pi * measured.turns / measured.time
    with np.errstate(divide="ignore", invalid="ignore"):
        expected: dict[str, Floats] = {
            "precession_period": measured.time / measured.turns,
            "precession_rate": rate,
            "torque": np.abs(measured.torque),
            "spin": measured.spin,
            "spin_period": 2 * np.pi / measured.spin,
            "inertia": np.abs(measured.torque) / (rate * measured.spin),
            "mass": measured.mass,
            "position": np.abs(measured.position),
            "time": measured.time,
            "turns": measured.turns,
            "angle": 2 * np.pi * measured.turns,
        }
    found = []
    # What is always itself the reading agrees with itself.
    own = {"mass", "position", "time"}
    compared = [column for role, column in readings.columns.items() if role not in own]
    for column in (*compared, *readings.others):
        if column.role not in expected:
            continue
        finding = _compare(readings, column, expected[column.role])
        if finding is not None:
            found.append(finding)
    return found


def find_too_fast(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Warn where most runs precess faster than they spin: two columns exchanged, or a unit that is not the one."""
    with np.errstate(divide="ignore", over="ignore"):
        fast = np.flatnonzero(2 * np.pi * np.abs(measured.turns / measured.time) > measured.spin)
    if 2 * len(fast) <= len(measured.runs):
        return []
    column = spin_columns(readings)[0]
    first = int(fast[0])
    return [
        readings.diagnose(
            G405,
            f'the precession is faster than the spin ("{column.header}") in {len(fast)} of {len(measured.runs)} runs',
            "are spin and precession exchanged, or is a unit not the one written?",
            column.places[first],
            len(column.texts[first]),
        )
    ]


def _compare(readings: Readings, column: Column, expected: Floats) -> Diagnostic | None:
    """One finding for a column, placed at its first row that is off by more than 5 % and two last digits."""
    off: list[int] = []
    seen: set[int] = set()  # a reading that serves several runs is compared once
    for i, value in enumerate(column.values):
        if value is None or not math.isfinite(expected[i]) or column.readings[i] in seen:
            continue
        seen.add(column.readings[i])
        allowed = max(0.05 * abs(expected[i]), 2 * (column.resolutions[i] or 0.0))
        if abs(abs(value) - abs(expected[i])) > allowed:
            off.append(i)
    if not off:
        return None
    first = off[0]
    ratio = abs(column.values[first] or math.nan) / abs(expected[first])
    runs = ", ".join(readings.runs[i] for i in off[:6]) + (", …" if len(off) > 6 else "")
    return readings.diagnose(
        G401,
        f'"{column.header}" is {ratio:.3g} times what the readings give in run{"s" if len(off) > 1 else ""} {runs}; '
        "the readings are used",
        "check turns, units and this column's arithmetic",
        column.places[first],
        len(column.texts[first]),
    )
