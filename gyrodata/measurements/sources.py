"""Every source of error that touches a log: what it is an error of, how large it is, and what it is shared by."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from gyrodata.measurements.spins import as_spin, spin_columns, spin_weights, values_of
from gyrodata.physics import Floats
from gyrodata.readings import Column, Readings
from gyrodata.units import Uncertainty

TRANSVERSE_U = 0.2
"""Relative standard uncertainty of I where the log does not give it …"""


TRANSVERSE_GIVEN_U = 0.02
"""… and where it gives I without one."""


Quantity = Literal["time", "spin", "mass", "position", "force", "torque", "g", "turns", "pitch", "transverse"]


@dataclass(frozen=True, slots=True)
class Source:
    """One kind of error, independent between groups of runs and equal within a group.

    The reading is the truth plus (`absolute` + `relative` × truth) × a standard normal number, one for each
    group. Proportional errors are thus proportional to the *true* value: taken at the measured one, low
    readings would look precise and pull the fit.
    """

    name: str
    """Key of the log without its ``u_``: "position_zero"."""
    quantity: Quantity
    """What it is an error of."""
    groups: tuple[int, ...]
    """Group of each run, shape (n,), counted from 0; −1 for a run that it does not touch."""
    absolute: Floats
    """Shape (n,), standard uncertainty [SI unit of the quantity]."""
    relative: Floats
    """Shape (n,), standard uncertainty [1]."""
    shared_by: str
    """In words: "runs with the same weight"; "" where every run has its own."""
    default: bool
    """True where the log does not give it."""
    usual: str
    """What it is in words where the log does not give it: "0.2 %"."""

    @property
    def described(self) -> str:
        """What it is in words, in this log."""
        return self.usual if self.default else "as given"

    @property
    def shared(self) -> bool:
        """True if any two runs have the same error."""
        return self.shared_count > 0

    @property
    def shared_count(self) -> int:
        """Number of errors that several runs have in common."""
        return sum(runs > 1 for group, runs in Counter(self.groups).items() if group >= 0)


def stated_or(readings: Readings, key: str, default: float, value: float) -> float:
    """Standard uncertainty `key` that holds for the whole log, at a value, or its default."""
    stated = readings.uncertainties.get(key)
    return default if stated is None else stated.at(value)


def list_sources(
    readings: Readings, timing: Column, time: Floats, turns: Floats, spin: Floats, mass: Floats, position: Floats
) -> list[Source]:
    """All sources of uncertainty that touch this log, in the order of the table in the documentation."""
    count = len(readings.runs)
    own = tuple(range(count))
    every = (0,) * count
    columns = readings.columns
    sources: list[Source] = []

    def whole_log(key: str, quantity: Quantity, default: Uncertainty, words: str, shared_by: str) -> None:
        given = readings.uncertainties.get(f"u_{key}")
        used = default if given is None else given
        sources.append(
            Source(
                key,
                quantity,
                every,
                np.full(count, used.absolute),
                np.full(count, used.relative),
                shared_by,
                given is None,
                words,
            )
        )

    if timing.role == "precession_rate":
        rate = values_of(timing)
        absolute, relative, default = _reading_errors(timing, np.abs(rate), 0.0, 0.01)
        relative = relative + absolute / np.abs(rate)
        sources.append(
            Source("precession_rate", "time", own, np.zeros(count), relative, "", default, "1 % and rounding")
        )
    else:
        absolute, relative, default = _stated_for_period(columns, timing, time, turns) or _reading_errors(
            timing, time, 0.14, 0.0
        )
        sources.append(
            Source("time", "time", own, absolute, relative, "", default, "0.14 s (0.1 s a click) and rounding")
        )
        if "angle" in columns and "turns" not in columns:
            angles = columns["angle"]
            given_angle = [
                u.at(v or 0.0) if u else 0.0 for u, v in zip(angles.uncertainties, angles.values, strict=True)
            ]
            if any(given_angle):
                scaled = np.array(given_angle) / (2 * np.pi)
                sources.append(Source("angle", "turns", own, scaled, np.zeros(count), "", False, "as given"))

    relative_spin, default = _spin_errors(readings)
    used = spin_columns(readings)
    groups = _numbered([tuple(column.readings[i] for column in used) for i in range(count)])
    sources.append(
        Source(
            "spin", "spin", groups, np.zeros(count), relative_spin,
            "runs with the same reading", default, "0.2 % a reading and rounding",
        )
    )  # fmt: skip
    whole_log("spin_scale", "spin", Uncertainty(0.0, 0.001), "0.1 %", "all runs (one tachometer)")

    if "mass" in columns:
        loaded = mass != 0
        absolute, relative, default = _reading_errors(columns["mass"], mass, 0.0, 0.002)
        weights = _numbered([f"{value:.9g}" for value in mass], loaded)
        sources.append(
            _by_value("mass", "mass", weights, absolute, relative, "runs with the same weight", default,
                      "0.2 % and rounding")
        )  # fmt: skip
        whole_log("mass_scale", "mass", Uncertainty(0.0, 0.0005), "0.05 %", "all runs (one scale)")
    elif "force" in columns:
        force = values_of(columns["force"])
        loaded = force != 0
        absolute, relative, default = _reading_errors(columns["force"], force, 0.0, 0.002)
        sources.append(
            _by_value("force", "force", _numbered([f"{value:.9g}" for value in force], loaded), absolute, relative,
                      "runs with the same force", default, "0.2 % and rounding")
        )  # fmt: skip
    else:
        torque = values_of(columns["torque"])
        absolute, relative, default = _reading_errors(columns["torque"], torque, 0.0, 0.005)
        sources.append(
            _by_value("torque", "torque", _numbered([f"{value:.9g}" for value in torque], torque != 0), absolute,
                      relative, "runs with the same torque", default, "0.5 % and rounding")
        )  # fmt: skip
        return sources

    if "position" not in columns:
        return sources  # not one run has a weight
    absolute, relative, default = _reading_errors(columns["position"], position, 0.0, 0.0)
    places = _numbered([f"{value:.9g}" for value in position], loaded)
    sources.append(
        _by_value("position", "position", places, absolute, relative, "runs with the same position", default,
                  "rounding")
    )  # fmt: skip
    whole_log("position_zero", "position", Uncertainty(0.0005, 0.0), "0.5 mm", "all runs (one ruler, one zero)")
    if "mass" in columns:
        free = Uncertainty(0.0, 0.0 if "g" in readings.constants else 0.0002)
        whole_log("g", "g", free, "0" if "g" in readings.constants else "0.02 %", "all runs")
    return sources


def tilt_sources(readings: Readings, pitch: Floats, transverse: Floats | None) -> list[Source]:
    """Doubt about the pitch and about I, where they have a part: of a tilted rod, or one let go from rest."""
    count = len(readings.runs)
    sources = []
    if "pitch" in readings.columns:
        absolute, relative, default = _reading_errors(readings.columns["pitch"], pitch, math.radians(2), 0.0)
        sources.append(
            Source("pitch", "pitch", tuple(range(count)), absolute, relative, "", default, "2° and rounding")
        )
    elif readings.motion != "released":
        return []
    size, default, words = np.full(count, TRANSVERSE_U), True, "20 %"
    if transverse is not None:
        column = readings.columns["transverse_inertia"]
        stated = [u.at(value) / value for u, value in zip(column.uncertainties, transverse, strict=True) if u]
        default, words = not stated, "2 %"
        size = np.full(count, max(stated) if stated else TRANSVERSE_GIVEN_U)
    sources.append(
        Source("transverse_inertia", "transverse", (0,) * count, np.zeros(count), size, "all runs", default, words)
    )
    return sources


def with_period_errors(timing: Column, columns: Mapping[str, Column], turns: Floats) -> Column:
    """Where a log states the uncertainty of the period only, that of the time is as many times larger."""
    period = columns.get("precession_period")
    if period is None or timing.role != "time" or any(timing.uncertainties):
        return timing
    scaled = tuple(
        None if u is None else Uncertainty(u.absolute * float(f), u.relative)
        for u, f in zip(period.uncertainties, turns, strict=True)
    )
    return replace(timing, uncertainties=scaled)


def _by_value(
    name: str, quantity: Quantity, groups: tuple[int, ...], absolute: Floats, relative: Floats,
    shared_by: str, default: bool, usual: str,
) -> Source:  # fmt: skip
    """Make a source whose error goes with the value: one for each weight, not one for each run.

    Where runs of one group state different uncertainties (a column ``u_mass``), the largest holds for the
    group: it is one reading and has one error.
    """
    group = np.array(groups, dtype=int)
    touched = group >= 0

    def largest(sizes: Floats) -> Floats:
        most = np.zeros(int(group.max(initial=-1)) + 1)
        np.maximum.at(most, group[touched], sizes[touched])
        return np.where(touched, most[group] if len(most) else 0.0, sizes)

    return Source(name, quantity, groups, largest(absolute), largest(relative), shared_by, default, usual)


def _numbered(keys: Sequence[object], touched: Sequence[bool] | Floats | None = None) -> tuple[int, ...]:
    """Number equal keys alike, from 0 in order of appearance; −1 where not touched."""
    numbers: dict[object, int] = {}
    return tuple(
        -1 if touched is not None and not touched[i] else numbers.setdefault(key, len(numbers))
        for i, key in enumerate(keys)
    )


def _reading_errors(column: Column, values: Floats, absolute: float, relative: float) -> tuple[Floats, Floats, bool]:
    """Uncertainty of each reading of a column: as given, or the default with the last digit's rounding.

    Parameters
    ----------
    column : Column
        n readings.
    values : ndarray, shape (n,)
        Their values [SI].
    absolute, relative : float
        Default [SI], [1].

    Returns
    -------
    tuple
        Absolute [SI] and relative [1] part, shape (n,), and whether any default was used.
    """
    # A number rounded to steps of s is uniform within ±s/2: s/√12 (GUM F.2.2.1).
    rounding = np.array([step or 0.0 for step in column.resolutions]) / math.sqrt(12)
    size = np.where(np.isfinite(values), np.abs(values), 0.0)
    whole = np.sqrt(absolute**2 + (relative * size) ** 2 + rounding**2)
    in_proportion = (size > 0) & (relative > 0)
    a, r = np.where(in_proportion, 0.0, whole), np.divide(whole, size, out=np.zeros_like(size), where=in_proportion)
    given = [i for i, stated in enumerate(column.uncertainties) if stated is not None]
    for i in given:
        stated = column.uncertainties[i]
        assert stated is not None
        a[i], r[i] = stated.absolute, stated.relative
    return a, r, len(given) < len(values)


def _stated_for_period(
    columns: Mapping[str, Column], timing: Column, time: Floats, turns: Floats
) -> tuple[Floats, Floats, bool] | None:
    """Uncertainty of each time from the one that the log states for every run's period, or rate; None if it does not.

    A log with columns ``t``, ``N``, ``T = t/N`` and ``σ_T`` says how well the times are known, in another place.
    """
    if timing.role != "time" or any(stated is not None for stated in timing.uncertainties):
        return None
    for role in ("precession_period", "precession_rate"):
        column = columns.get(role)
        if column is None or any(stated is None for stated in column.uncertainties):
            continue
        # A rate is off by the same share as its period.
        size = time / turns if role == "precession_period" else 2 * np.pi * turns / time
        absolute = np.array([0.0 if stated is None else stated.absolute for stated in column.uncertainties])
        relative = np.array([0.0 if stated is None else stated.relative for stated in column.uncertainties])
        if np.all((absolute + relative * size > 0) & np.isfinite(size)):
            return absolute / size * time, relative, False
    return None


def _spin_errors(readings: Readings) -> tuple[Floats, bool]:
    """Relative standard uncertainty of each run's mean spin, shape (n,), and whether a default was used."""
    used = spin_columns(readings)
    parts = []
    any_default = False
    for column in used:
        values = np.abs(values_of(column))
        absolute, relative, default = _reading_errors(column, values, 0.0, 0.002)
        # The same relative uncertainty for a period and for its reciprocal.
        parts.append(relative + absolute / values)
        any_default |= default
    weights = spin_weights([as_spin(column) for column in used])
    squares = sum((weight * part) ** 2 for weight, part in zip(weights, parts, strict=True))
    return np.sqrt(squares), any_default
