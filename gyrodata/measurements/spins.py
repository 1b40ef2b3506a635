"""The spin of each run: which columns tell it, and its mean in time."""

from __future__ import annotations

import math
from typing import cast

import numpy as np

from gyrodata import physics
from gyrodata.errors import Diagnostic, register
from gyrodata.physics import Floats
from gyrodata.readings import Column, Readings

G403 = register(
    "G403",
    "warning",
    "the spin rises during the interval",
    "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n20.00,15.0,400,450,39.7,1\n",
)


def values_of(column: Column) -> Floats:
    """Values of a column [SI], shape (n,); NaN where nothing was read."""
    return np.array([math.nan if value is None else value for value in column.values], dtype=float)


def spin_columns(readings: Readings) -> tuple[Column, ...]:
    """The columns that the spin is taken from: start, half time and end, or half time alone, or start and end."""
    columns = readings.columns
    for unit in ("spin", "spin_period"):
        for names in ((f"{unit}_start", unit, f"{unit}_end"), (unit,), (f"{unit}_start", f"{unit}_end")):
            if all(name in columns and None not in columns[name].values for name in names):
                return tuple(columns[name] for name in names)
    raise KeyError("spin")


def as_spin(column: Column) -> Floats:
    """Spin [rad/s] of a column of spins, or of times per revolution, shape (n,)."""
    values = np.abs(values_of(column))
    return cast(Floats, 2 * np.pi / values if "period" in column.role else values)


def mean_spins(readings: Readings, diagnostics: list[Diagnostic]) -> tuple[Floats, Floats | None, Floats | None]:
    """Mean spin of each run, and the spin at its start and end where they were read [rad/s]."""
    used = spin_columns(readings)
    spins = [as_spin(column) for column in used]
    if len(used) == 1:
        return spins[0], None, None
    start, end = spins[0], spins[-1]
    diagnostics.extend(
        readings.diagnose(
            G403,
            f"run {readings.runs[i]}: the spin rises by {100 * (end[i] / start[i] - 1):.0f} % while it is timed",
            "are start and end swapped?",
            used[-1].places[i],
            len(used[-1].texts[i]),
        )
        for i in np.flatnonzero(end > start * 1.02)
    )
    return _mean_spin(spins), start, end


def _mean_spin(spins: list[Floats]) -> Floats:
    """Harmonic mean in time of a spin read once, at start and end, or three times [rad/s], shape (n,)."""
    if len(spins) == 3:
        return cast(Floats, physics.simpson_mean_spin(*spins))
    return spins[0] if len(spins) == 1 else cast(Floats, physics.harmonic_mean_spin(*spins))


def spin_weights(spins: list[Floats]) -> list[Floats]:
    """Relative change of the mean spin for a relative change of each reading; they add up to 1."""
    if len(spins) == 3:
        parts = [weight / spin for weight, spin in zip((1, 4, 1), spins, strict=True)]
        return [part / sum(parts) for part in parts]
    if len(spins) == 1:
        return [np.ones_like(spins[0])]
    mean = _mean_spin(spins)
    return [slope * spin / mean for slope, spin in zip(physics.harmonic_mean_spin_slopes(*spins), spins, strict=True)]
