"""What is kept of a log to compare it with others: its rows in SI and how finely each was typed."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from gyrodata.measurements import Measurements
from gyrodata.physics import Floats
from gyrodata.readings import Column, Readings

MOST_ROWS = 200
"""Rows that are kept of a log; of a longer one, those with the shortest times."""

_SPIN = (("spin",), ("spin_start", "spin_end"), ("spin_period",), ("spin_period_start", "spin_period_end"))
_TIMING = ("time", "precession_period", "precession_rate")

_FINEST, _COARSEST = 0.0009, 0.011
"""Steps of a stopwatch [s] whose last digit a hand leaves to chance: with a scatter of 0.05 s, hundredths and below."""


@dataclass(frozen=True, slots=True)
class Fingerprint:
    """One log's n rows, in the order of torque and then spin, however they were typed.

    Units, order, names of columns and the split into repeats are gone; the steps of the last digits tell how
    far a copy may differ from its original by rounding alone.
    """

    sha256: str
    """Of the file."""
    by_hand: bool
    """True where intervals were timed with a stopwatch; False where a period or a rate is all there is."""
    lines: tuple[int, ...]
    """Line of each row in the file."""
    torque: tuple[float, ...]
    """Applied torque [N*m], signed."""
    spin: tuple[float, ...]
    """Mean spin [rad/s], a magnitude."""
    time: tuple[float, ...]
    """Timed interval [s]."""
    turns: tuple[float, ...]
    """Revolutions of precession in that time [1]."""
    spin_step: tuple[float, ...]
    """One step of the last digit typed of the spin [rad/s]; 0 where it is exact."""
    time_step: tuple[float, ...]
    """One step of the last digit typed of the time [s]; 0 where it is exact."""
    digits: tuple[int, ...]
    """How often each last digit 0 … 9 stands in the times as typed, whole log; empty where that tells nothing."""

    def to_dict(self) -> dict[str, Any]:
        """Give it as JSON can hold it; `from_dict` takes it back exactly."""
        values = ((field.name, getattr(self, field.name)) for field in fields(self))
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values}

    @classmethod
    def from_dict(cls, stored: dict[str, Any]) -> Fingerprint:
        """Take back what `to_dict` gave."""
        values: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value for name, value in stored.items()
        }
        return cls(**values)


def fingerprint(readings: Readings, measured: Measurements) -> Fingerprint:
    """Take the fingerprint of one log.

    `measured`: What `gyrodata.measurements.measure` makes of them, n runs; no fit is needed.
    """
    columns = readings.columns
    timing = next(columns[role] for role in _TIMING if role in columns)
    spins = next(roles for roles in _SPIN if all(role in columns for role in roles))
    torque = np.array([float(f"{value:.9g}") for value in measured.torque])
    # The order of the file stays where torque and spin are equal: sorted times would look alike by themselves.
    order = np.lexsort((measured.spin, torque))
    if len(order) > MOST_ROWS:
        order = order[np.isin(order, np.argsort(measured.time, kind="stable")[:MOST_ROWS])]
    spin_step = measured.spin * np.max([_relative_step(columns[role]) for role in spins], axis=0)
    time_step = measured.time * _relative_step(timing)
    return Fingerprint(
        sha256=readings.sha256,
        by_hand=timing.role == "time",
        lines=tuple(measured.lines[i] for i in order),
        torque=_kept(torque[order]),
        spin=_kept(measured.spin[order]),
        time=_kept(measured.time[order]),
        turns=_kept(measured.turns[order]),
        spin_step=_kept(spin_step[order]),
        time_step=_kept(time_step[order]),
        digits=_last_digits(timing),
    )


def _kept(values: Floats) -> tuple[float, ...]:
    """Ten digits: more than anyone types, and short in a journal."""
    return tuple(float(f"{value:.10g}") for value in values)


def _relative_step(column: Column) -> Floats:
    """One step of the last digit over the value, the same for a period and for its rate, shape (n,)."""
    pairs = zip(column.resolutions, column.values, strict=True)
    return np.array([step / abs(value) if step and value else 0.0 for step, value in pairs])


def _last_digits(timing: Column) -> tuple[int, ...]:
    """Count the last digits as a stopwatch shows them; a spreadsheet's lost zeros are put back."""
    if timing.role != "time" or timing.unit != "s":
        return ()
    counts = [0] * 10
    for value, step in zip(timing.values, timing.resolutions, strict=True):
        if value is None or step is None or not _FINEST < step < _COARSEST:
            return ()
        counts[round(value / step) % 10] += 1
    return tuple(counts)
