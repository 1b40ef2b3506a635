"""Every source of error of a log: its quantity, its size, and the runs that share it.

The table in `error_sources` contains their defaults.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.physics import Floats, Integers
from gyrodata.quantities.error_sources import (
    DECAY_SPREAD,
    DECAY_TIME,
    LATE,
    NORMAL_GRAVITY_U,
    SOURCES,
    TRANSVERSE_U,
    WHOLE,
    Quantity,
)
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import Column, Reading, Readings, rounded_turns
from gyrodata.readings.headers import parse_header
from gyrodata.readings.roles import stated_u


class Source(Struct, frozen=True):
    """One kind of error, independent between groups of runs and equal within a group.

    The reading is the truth plus (`absolute` + `relative` × truth) × a standard normal
    number, one for each group. Errors are proportional to the *true* value: if they
    were proportional to the measured one, low readings would look too precise.
    """

    name: str
    """Key of the log without its ``u_``: "position_zero"."""
    quantity: Quantity
    """The quantity that has the error."""
    groups: Integers
    """Group of each run, shape (n,), counted from 0; −1 for a run without this error.
    """
    absolute: Floats
    """Shape (n,), standard uncertainty [SI unit of the quantity]."""
    relative: Floats
    """Shape (n,), standard uncertainty [1]."""
    shared_by: str
    """In words: "runs with the same weight"; "" if every run has its own error."""
    default: bool
    """True if the log does not state it."""
    usual: str
    """The default in words: "0.2 %"."""
    of_motion: bool = False
    """True if it comes from a model of the motion, and not from a reading."""

    @property
    def described(self) -> str:
        """The default in words, or "as given"."""
        return self.usual if self.default else "as given"


def load_role(columns: Mapping[str, Column]) -> str:
    """Return the role that gives the torque: masses, else forces, else the torque itself."""
    if "mass" in columns:
        return "mass"
    return "force" if "force" in columns else "torque"


def list_sources(
    readings: Readings,
    timing: Column,
    time: Floats,
    turns: Floats,
    spin: Floats,
    position: Floats,
    pitch: Floats,
    drag: Drag | None,
) -> Iterator[Source]:
    """List all sources of error of a log, in the order of the table."""
    columns, load = readings.columns, load_role(readings.columns)
    yield from _timing_sources(readings, timing, time, turns)
    yield from _spin_sources(readings, spin, time, drag)
    values = values_of(columns[load])
    yield _by_value(load, columns[load], values, values != 0)
    if load == "mass":
        yield _of_whole_log(readings, "mass_scale")
    # Without a position not one run has a weight.
    if load != "torque" and "position" in columns:
        yield _by_value("position", columns["position"], position, values != 0)
        zero = _of_whole_log(readings, "position_zero")
        # The length added to every position is only as well known as the ball's
        # diameter or the rod's length.
        yield replace(zero, absolute=np.hypot(zero.absolute, readings.origin_u))
        yield from _position_set_sources(readings, values)
        if load == "mass":
            known: tuple[Uncertainty | None, str | None] = None, None
            if "g" in readings.constants:
                known = Uncertainty(), "0"
            elif "latitude" in readings.constants:
                known = NORMAL_GRAVITY_U, "0.01 %, from the latitude"
            yield _of_whole_log(readings, "g", *known)
            if "weight_diameter" in columns and columns["weight_diameter"].stated:
                yield _diameter_source(columns["weight_diameter"], values)
    # The pitch, and I of a tilted or a released rod.
    if "pitch" in columns:
        errors = _reading_errors(columns["pitch"], pitch, SOURCES["pitch"].default)
        yield _source("pitch", np.arange(len(pitch)), *errors)
    elif readings.motion != "released":
        return
    size, default, usual = TRANSVERSE_U, True, f"{100 * TRANSVERSE_U:g} %"
    column = columns.get("transverse_inertia") or columns.get("nutation_period")
    if column is not None:
        usual, of_source = (
            SOURCES["transverse_inertia"].usual,
            SOURCES["transverse_inertia"].default.relative,
        )
        stated = [
            u.at(value) / value for i, u in column.stated if (value := column.values[i])
        ]
        default, size = not stated, max(stated, default=of_source)
    yield _source(
        "transverse_inertia", np.zeros(len(pitch), dtype=int), 0.0, size, default, usual
    )


def _position_set_sources(readings: Readings, load: Floats) -> Iterator[Source]:
    """List the error of a weight that was put at its mark again.

    Runs of one weight share it, unless the weight was moved for each run.
    """
    size, default = stated_or_default(readings, "position_set")
    if readings.position_set == "each weight":
        groups, shared_by = _numbered(load, load), "runs with the same weight"
    elif readings.position_set == "each run":
        groups, shared_by = np.where(load, np.arange(len(load)), -1), ""
    else:
        return
    source = _source("position_set", groups, size.absolute, size.relative, default)
    yield replace(source, shared_by=shared_by)


def _diameter_source(column: Column, mass: Floats) -> Source:
    """Return the uncertainty of the inertia of each weight from that of its diameter."""
    across, given = values_of(column), np.zeros(len(mass))
    for i, u in column.stated:
        given[i] = u.at(float(across[i])) / across[i]
    # Half of m r²: an error of the diameter counts twice.
    doubt = np.where((mass > 0) & np.isfinite(across), 2 * given, 0.0)
    return _source("weight_diameter", _numbered(across, doubt), 0.0, doubt, False)


def read_once(used: tuple[Column, ...]) -> bool:
    """Return whether the spin was read once in each run.

    One spin for the whole log was never read at a midpoint.
    """
    return len(used) == 1 and max(used[0].spots, default=-1) >= 0


def reading_delay(readings: Readings, used: tuple[Column, ...], time: Floats) -> Floats:
    """Return how long after the middle of each run the spin was read [s], shape (n,).

    This is the average delay of the only reading of the spin.

    It is negative if the spin was read before each run, by its header. A log that
    states how uncertain the delay is has no delay on average.
    """
    if used[0].role == "spin" and "spin_start" in parse_header(used[0].header).roles:
        return -time / 2
    is_stated = "u_spin_delay" in readings.uncertainties
    return np.full(len(time), 0.0 if is_stated else LATE)


USUAL_RATE = 1 / DECAY_TIME
"""Relative fall of the spin in a second if the log does not show it [1/s]: the median
of its distribution."""


def usual_fall_u(delay: Floats, delay_u: float) -> Floats:
    """Compute the relative uncertainty of a corrected spin [1], shape (n,).

    The spin is corrected for a usual fall during a delay.

    The fall is d r, with a delay d = `delay` ± `delay_u` [s] and a rate r of a
    log-normal distribution around `USUAL_RATE`. This is the root mean square of its
    distance from `delay` times `USUAL_RATE`.
    """
    mean = math.exp(DECAY_SPREAD**2 / 2)
    mean_square = math.exp(2 * DECAY_SPREAD**2)
    by_rate = delay**2 * (mean_square - 2 * mean + 1)
    by_delay = delay_u**2 * mean_square
    return USUAL_RATE * np.sqrt(by_rate + by_delay)


def _spin_sources(
    readings: Readings, spin: Floats, time: Floats, drag: Drag | None
) -> Iterator[Source]:
    """List the errors of the spins, when they were read, and the law by which the spin falls."""
    used, square, any_default, usual = (
        spin_columns(readings),
        np.zeros(len(spin)),
        False,
        None,
    )
    spins, spots = list(map(as_spin, used)), []
    # The relative change of the mean spin for a relative change of each reading; the
    # sum is 1.
    weights = [np.ones(len(spin))]
    if len(used) == 2:
        share = physics.harmonic_mean_spin_share(*spins)
        weights = [share, 1 - share]
    elif len(used) == 3:
        parts = np.array([[1.0], [4.0], [1.0]]) / np.array(spins)
        weights = list(parts / np.add.reduce(parts))
    for column, weight in zip(used, weights, strict=True):
        size = SOURCES["spin"].default
        if column.role == "spin_time":
            # Several turns are timed with the stopwatch.
            usual, counts = SOURCES["time"].usual, readings.columns["spin_turns"]
            size = Uncertainty(
                SOURCES["time"].default.absolute / min(filter(None, counts.values))
            )
        values = np.abs(values_of(column))
        absolute, relative, default = _reading_errors(column, values, size)
        # The same relative uncertainty for a period and for its reciprocal.
        part = relative + absolute / values
        if column.role == "spin_time":
            part = np.hypot(
                part,
                [
                    r.u.at(r.value) / r.value if r.u and r.value else 0.0
                    for r in counts.readings
                ],
            )
        square, any_default = square + (weight * part) ** 2, any_default or default
        spots.append(column.spots)
    groups = _numbered(list(zip(*spots, strict=True)))
    yield _source("spin", groups, 0.0, np.sqrt(square), any_default, usual)
    yield _of_whole_log(readings, "spin_scale")
    # The spin falls: it was read late, by a law that is not certain.
    delay, delay_default = stated_or_default(readings, "spin_delay")
    law, law_default = stated_or_default(readings, "decay_exponent")
    every = np.zeros(len(spin), dtype=int)
    if read_once(used) and drag is None:
        doubt = usual_fall_u(reading_delay(readings, used, time), delay.absolute)
        yield _source("spin_delay", every, 0.0, doubt, delay_default)
    elif read_once(used) and drag is not None:
        late = np.hypot(reading_delay(readings, used, time), delay.absolute)
        by_law = late * drag.at(spin) * np.log(spin / drag.spin) * drag.u_exponent
        words = f"{LATE:g} s late ± 1.7 s, in a spin that falls by 1/e in {1 / drag.rate:.0f} s"
        yield _source(
            "spin_delay",
            every,
            0.0,
            delay.absolute * drag.at(spin),
            delay_default,
            words,
        )
        yield _source("decay_exponent", every, 0.0, by_law, law_default)
    elif len(used) == 2:
        u = law.at(1.0) if drag is None else drag.u_exponent
        doubt = u * np.abs(physics.decay_law_doubt(*spins))
        yield _source("decay_exponent", every, 0.0, doubt, law_default)


def _timing_sources(
    readings: Readings, timing: Column, time: Floats, turns: Floats
) -> Iterator[Source]:
    """List the errors of the times, or of rates instead of times, and of the timed angles."""
    own = np.arange(len(time))
    if timing.role == "precession_rate":
        rate = np.abs(values_of(timing))
        absolute, relative, default = _reading_errors(
            timing, rate, SOURCES["precession_rate"].default
        )
        yield _source("precession_rate", own, 0.0, relative + absolute / rate, default)
        return
    absolute, relative, default = _reading_errors(timing, time, SOURCES["time"].default)
    # The uncertainty of a period or rate beside the time, as in a log with the columns
    # t, N, T = t/N and σ_T.
    for column in told_by_period(readings.columns, timing):
        # A rate has the same relative error as its period.
        size = (
            time / turns
            if column.role == "precession_period"
            else 2 * np.pi * turns / time
        )
        stated = np.array([[u.absolute, u.relative] for _, u in column.stated])
        if default and np.all((stated.sum(axis=1) > 0) & np.isfinite(size)):
            absolute, relative, default = (
                stated[:, 0] / size * time,
                stated[:, 1],
                False,
            )
    yield _source("time", own, absolute, relative, default)
    if timing.role != "time":
        return
    # The angle that a time covers: the rod is sighted against a mark at its start and
    # at its end, unless both are the same mark.
    column = (
        readings.columns["turns"]
        if "turns" in readings.columns
        else readings.columns["angle"]
    )
    per_turn, part = (
        1.0 if column.role == "turns" else 2 * np.pi,
        np.abs(turns - np.round(turns)) > WHOLE,
    )
    absolute = np.where(part, SOURCES["angle"].default.absolute, 0.0)
    relative, by_default = np.zeros(len(turns)), part.copy()
    of_one_end = stated_u(column.role, readings.uncertainties)
    for i, u in column.stated:
        # A line for the whole log is about one end, as the default; the uncertainty of
        # a single cell is all of it.
        ends = math.sqrt(2) * part[i] if u == of_one_end else 1.0
        absolute[i], relative[i], by_default[i] = (
            ends * u.absolute / per_turn,
            u.relative,
            False,
        )
    if absolute.any() or relative.any():
        yield _source("angle", own, absolute, relative, bool(by_default.any()))
    yield from _screw_sources(readings, turns, by_default)
    if column.role == "turns":
        yield from _rounding_of_turns(column)


def _screw_sources(
    readings: Readings, turns: Floats, by_default: Any
) -> Iterator[Source]:
    """List the error of the angle between two screws, a third of a turn apart.

    Runs between the same two screws share it. If the log does not say at which screw a
    run began, these are all runs of one third, or of two. An angle whose uncertainty
    the log states has no other error.
    """
    size, default = stated_or_default(readings, "screw_angle")
    thirds = 3 * turns
    is_third = np.abs(thirds - np.round(thirds)) < 3 * WHOLE
    between = is_third & (np.abs(turns - np.round(turns)) > WHOLE)
    if default:
        between &= by_default
    if not between.any() or not size.absolute:
        return
    remainder = (np.round(thirds) % 3).astype(int).tolist()
    pairs = zip(readings.screws, remainder, strict=True)
    absolute = np.where(between, size.absolute / (2 * math.pi), 0.0)
    groups = _numbered([*pairs], absolute)
    yield _source("screw_angle", groups, absolute, 0.0, default)


NEGLIGIBLE_ROUNDING = 1e-5
"""A number of turns that is known better than this is exact [1]: 0.333333 is 1/3."""


def _rounding_of_turns(turns: Column) -> Iterator[Source]:
    """List the error of fractions that were typed as rounded decimals.

    Runs with the same decimal have the same error.

    The error of sighting the rod is another one, of each run alone.
    """
    texts = ["" if reading.u else reading.text for reading in turns.readings]
    doubts = {text: rounded_turns(text)[1] for text in set(texts)}
    rounding = np.array([doubts[text] for text in texts])
    rounding[rounding < NEGLIGIBLE_ROUNDING * np.abs(values_of(turns))] = 0.0
    if not rounding.any():
        return
    groups = _numbered(texts, rounding)
    shared_by = "runs with the same rounded turns"
    yield Source(
        "rounded_turns",
        "turns",
        groups,
        rounding,
        np.zeros(len(texts)),
        shared_by,
        True,
        "rounding",
    )


def stated_or_default(readings: Readings, key: str) -> tuple[Uncertainty, bool]:
    """Return the uncertainty of a source of the whole log, and whether it is the default."""
    stated = readings.uncertainties.get(f"u_{key}")
    return (SOURCES[key].default, True) if stated is None else (stated, False)


def _source(
    key: str,
    groups: Integers,
    absolute: Any,
    relative: Any,
    default: bool,
    usual: str | None = None,
) -> Source:
    """Create a source of the table for a log, with one size of its errors or one for each run."""
    kind, nothing = SOURCES[key], np.zeros(len(groups))
    words = kind.usual if usual is None else usual
    return Source(
        key,
        kind.quantity,
        groups,
        nothing + absolute,
        nothing + relative,
        kind.shared_by,
        default,
        words,
    )


def _of_whole_log(
    readings: Readings,
    key: str,
    usual: Uncertainty | None = None,
    words: str | None = None,
) -> Source:
    """Return a component that all runs share.

    `usual` describes its default if this log has another one.
    """
    used, default = stated_or_default(readings, key)
    if default and usual is not None:
        used = usual
    return _source(
        key,
        np.zeros(len(readings.runs), dtype=int),
        used.absolute,
        used.relative,
        default,
        words,
    )


def _by_value(key: str, column: Column, values: Floats, loaded: Floats) -> Source:
    """Return a component with one error for each value: for each weight, not for each run.

    If runs of one group state different uncertainties (a column ``u_mass``), the
    largest is used for the group: it is one reading and has one error.
    """
    absolute, relative, default = _reading_errors(column, values, SOURCES[key].default)
    touched = loaded & np.isfinite(values)
    group = _numbered(values, touched)
    if column.stated or len({*column.steps}) > 1:
        for sizes in (absolute, relative):
            most = np.zeros_like(sizes)
            np.maximum.at(most, group[touched], sizes[touched])
            sizes[touched] = most[group[touched]]
    return _source(key, group, absolute, relative, default)


def _numbered(
    keys: Sequence[object] | Floats, counts: Floats | None = None
) -> Integers:
    """Number the keys from 0 in order of appearance.

    Equal keys, and values that are equal to 9 digits, have the same number.

    With `counts`, shape (n,), a run for which it is zero gets −1.
    """
    numbers: dict[object, int] = {}
    groups = [-1] * len(keys)
    for i, key in enumerate(keys.tolist() if isinstance(keys, np.ndarray) else keys):
        if counts is None or counts[i]:
            groups[i] = numbers.setdefault(
                f"{key:.9g}" if isinstance(key, float) else key, len(numbers)
            )
    return np.array(groups, dtype=int)


def _reading_errors(
    column: Column, values: Floats, default: Uncertainty
) -> tuple[Floats, Floats, bool]:
    """Return the uncertainty of each reading of a column.

    It is the stated uncertainty, or the default with the rounding.

    The absolute [SI] and the relative [1] part have shape (n,); the last value is True
    if a default was used.
    """
    # A number rounded to steps of s is uniform within ±s/2: s/√12 (GUM F.2.2.1).
    rounding = np.array(column.steps) / math.sqrt(12)
    size = np.where(np.isfinite(values), np.abs(values), 0.0)
    whole = np.sqrt(default.absolute**2 + (default.relative * size) ** 2 + rounding**2)
    in_proportion = (size > 0) & (default.relative > 0)
    a, r = (
        np.where(in_proportion, 0.0, whole),
        np.divide(whole, size, out=np.zeros_like(size), where=in_proportion),
    )
    for i, stated in column.stated:
        a[i], r[i] = stated.absolute, stated.relative
    return a, r, len(column.stated) < len(values)


def told_by_period(columns: Mapping[str, Column], timing: Column) -> Iterator[Column]:
    """List the columns of periods or rates that state an uncertainty for every run.

    They are listed only if the times do not state an uncertainty.
    """
    if timing.role != "time" or timing.stated:
        return
    for role in ("precession_period", "precession_rate"):
        if role in columns and len(columns[role].stated) == len(columns[role].readings):
            yield columns[role]


def values_of(column: Column) -> Floats:
    """Return the values of a column [SI], shape (n,); NaN for a blank cell."""
    return np.array(column.values, dtype=float)


# --- how the spin falls ---

NO_POWER_LAW = 0.3
"""Smallest standard uncertainty of the exponent: no real drag is exactly a power of the
spin."""

NO_LAW = 9.0
"""With a larger reduced chi-square, the falls do not follow one law, and p keeps its
expected value."""

CERTAIN = 2.0
"""A fall of the spin below this many standard uncertainties is not used."""


class Drag(Struct, frozen=True):
    """The drag of one gyroscope."""

    rate: float
    """Relative fall of the spin in a second at `spin` [1/s]; the inverse of the decay
    time."""
    u_rate: float
    """[1/s]"""
    spin: float
    """[rad/s]"""
    exponent: float
    """p [1]."""
    u_exponent: float
    """[1]"""

    def at(self, spin: Floats) -> Floats:
        """Compute the relative fall in a second at other spins [1/s], shape (n,)."""
        return self.rate * (spin / self.spin) ** (self.exponent - 1)


def find_drag(readings: Readings, time: Floats) -> Drag | None:
    """Fit the law of drag to the spin-downs of a log.

    The fit also uses the spin at the start and the end of each run.

    Parameters
    ----------
    readings : Readings
    time : ndarray, shape (n,)
        Duration of each run [s].

    Returns
    -------
    Drag or None
        None if the spin does not fall visibly.
    """
    used, falls = spin_columns(readings), list(readings.spin_down)
    if len(used) > 1:
        falls += zip(
            as_spin(used[0]).tolist(),
            as_spin(used[-1]).tolist(),
            time.tolist(),
            strict=True,
        )
    if not falls:
        return None
    values = [
        (u, abs(column.values[i] or 0.0)) for column in used for i, u in column.stated
    ]
    # "100 ± 0" says nothing of the other readings.
    stated = [share for u, value in values if value and (share := u.at(value) / value)]
    u_spin = float(np.median(stated)) if stated else SOURCES["spin"].default.relative
    u_exponent = stated_or_default(readings, "decay_exponent")[0].at(1.0)
    start, end, seconds = np.array(falls).T
    spin, fall = np.sqrt(start * end), np.log(start / end)
    u = math.sqrt(2) * u_spin / seconds
    middle = float(np.exp(np.mean(np.log(spin))))
    distance = np.log(spin / middle)
    prior = max(u_exponent, 1e-6)
    rate, bend = float(np.sum(fall / seconds / u**2) / np.sum(1 / u**2)), 0.0
    # Gauss-Newton steps for the rate at the middle spin and for p − 1, which has a
    # prior.
    for _step in range(20):
        # The rate at the geometric mean of both spins.
        found = fall / seconds * physics.sinhc(bend * fall / 2)
        shape = np.exp(bend * distance)
        rows = np.vstack(
            [
                np.column_stack([shape, rate * distance * shape]) / u[:, None],
                [0.0, 1 / prior],
            ]
        )
        covariance = np.linalg.inv(rows.T @ rows)
        step = (
            covariance @ rows.T @ np.append((found - rate * shape) / u, -bend / prior)
        )
        rate, bend = rate + float(step[0]), float(np.clip(bend + step[1], -2.0, 2.0))
    misfit = float(np.sum(((found - rate * shape) / u) ** 2)) / max(len(u) - 2, 1)
    u_rate, u_bend = (
        np.sqrt(np.diag(covariance)) * max(1.0, math.sqrt(misfit))
    ).tolist()
    u_bend = min(math.hypot(u_bend, NO_POWER_LAW), u_exponent)
    if misfit > NO_LAW:
        bend, u_bend = 0.0, u_exponent
    return (
        Drag(rate, u_rate, middle, 1 + bend, u_bend)
        if rate > CERTAIN * u_rate
        else None
    )


# --- readings of the spin ---


def spin_columns(readings: Readings) -> tuple[Column, ...]:
    """Return the columns of the spin: start, midpoint and end, or one reading, or start and end."""
    columns = readings.columns
    for unit in ("spin", "spin_period"):
        for names in (
            (f"{unit}_start", unit, f"{unit}_end"),
            (unit,),
            (f"{unit}_start", f"{unit}_end"),
        ):
            used = [
                columns[name]
                for name in names
                if name in columns and None not in columns[name].values
            ]
            if len(used) == len(names):
                return tuple(used)
    if "spin_time" in columns and "spin_turns" in columns:
        return (_time_of_one(columns["spin_time"], columns["spin_turns"]),)
    raise KeyError("spin")


def _time_of_one(time: Column, turns: Column) -> Column:
    """Divide the times of several revolutions by their number."""
    readings = []
    for one, count in zip(time.readings, turns.readings, strict=True):
        if one.value is None or not count.value:
            readings.append(Reading())
            continue
        u = (
            None
            if one.u is None
            else Uncertainty(one.u.absolute / count.value, one.u.relative)
        )
        step = None if one.step is None else one.step / count.value
        readings.append(Reading(one.value / count.value, step, u, one.text))
    return replace(time, readings=tuple(readings))


def as_spin(column: Column) -> Floats:
    """Return the spin [rad/s] of a column of spins, or of times per revolution, shape (n,)."""
    values = np.abs(values_of(column))
    return cast(
        Floats,
        2 * np.pi / values
        if column.role.startswith(("spin_period", "spin_time"))
        else values,
    )


def mean_spin(spins: list[Floats], exponent: float = physics.VISCOUS) -> Floats:
    """Compute the harmonic mean in time of a spin [rad/s], shape (n,).

    The spin was read at start and end, or three times.
    """
    if len(spins) == 3:
        return cast(Floats, physics.simpson_mean_spin(*spins))
    return cast(Floats, physics.harmonic_mean_spin(spins[0], spins[-1], exponent))
