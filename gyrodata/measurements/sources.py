"""Every source of error of a log: its quantity, its size, and the runs that share it.

The table in `error_sources` contains their defaults.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

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
from gyrodata.readings.roles import stated_u

if TYPE_CHECKING:
    from gyrodata.measurements.measured import Measurements


REVOLUTION = math.tau
"""One revolution [rad]."""


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
    shared_by: str = ""
    """In words: "runs with the same weight"; "" if every run has its own error."""
    default: bool = True
    """True if the log does not state it."""
    usual: str = ""
    """The default in words: "0.2 %"."""
    of_motion: bool = False
    """True if it comes from a model of the motion, and not from a reading."""

    @property
    def described(self) -> str:
        """The default in words, or "as given"."""
        return self.usual if self.default else "as given"


def load_role(columns: Mapping[str, Column]) -> str:
    """Return the role that gives the torque: mass, else force, else torque."""
    if "mass" in columns:
        return "mass"
    return "force" if "force" in columns else "torque"


def timing_column(table: Mapping[str, Column]) -> Column:
    """Return the column of the timing.

    It contains times if there are turns or angles, else periods, else rates of
    precession.
    """
    if "time" in table and ("turns" in table or "angle" in table):
        return table["time"]
    return (
        table["precession_period"]
        if "precession_period" in table
        else table["precession_rate"]
    )


def list_sources(readings: Readings, measured: Measurements) -> Iterator[Source]:
    """List all sources of error of a log, in the order of the table."""
    columns = readings.columns
    yield from _timing_sources(readings, measured)
    if timing_column(columns).role == "time":
        yield from _angle_sources(readings, measured)
    yield from _spin_sources(readings)
    yield from _falling_spin_sources(readings, measured)
    yield from _load_sources(readings, measured)
    if "pitch" in columns:
        errors = _reading_errors(columns["pitch"], measured.pitch, "pitch")
        yield _source("pitch", np.arange(len(measured.pitch)), *errors)
    if "pitch" in columns or readings.motion == "released":
        yield _transverse_source(readings)


def _load_sources(readings: Readings, measured: Measurements) -> Iterator[Source]:
    """List the errors of weights, forces or torques, and of their positions."""
    columns = readings.columns
    load = load_role(readings.columns)
    values = values_of(columns[load])
    yield _by_value(columns[load], values, values != 0)
    if load == "mass":
        yield _of_whole_log(readings, "mass_scale")
    # Without a position not one run has a weight.
    if load == "torque" or "position" not in columns:
        return
    yield _by_value(columns["position"], measured.position, values != 0)
    zero = _of_whole_log(readings, "position_zero")
    # The length added to every position is only as well known as the ball's diameter or
    # the rod's length.
    yield replace(zero, absolute=np.hypot(zero.absolute, readings.origin_u))
    if readings.position_set in ("each weight", "each run"):
        yield _position_set_source(readings, values)
    if load == "mass":
        yield _gravity_source(readings)
        if "weight_diameter" in columns and columns["weight_diameter"].stated:
            yield _diameter_source(columns["weight_diameter"], values)


def _gravity_source(readings: Readings) -> Source:
    """Return the error of g: none if it is given, little if the latitude is."""
    if "g" in readings.constants:
        return _of_whole_log(readings, "g", Uncertainty(), "0")
    if "latitude" in readings.constants:
        words = "0.01 %, from the latitude"
        return _of_whole_log(readings, "g", NORMAL_GRAVITY_U, words)
    return _of_whole_log(readings, "g")


def _transverse_source(readings: Readings) -> Source:
    """Return the error of I, which counts if the rod is tilted or released."""
    columns = readings.columns
    every = np.zeros(len(readings.runs), dtype=int)
    column = columns.get("transverse_inertia") or columns.get("nutation_period")
    if column is None:
        words = f"{100 * TRANSVERSE_U:g} %"
        return _source(
            "transverse_inertia", every, 0.0, TRANSVERSE_U, True, usual=words
        )
    size = SOURCES["transverse_inertia"].default.relative
    if column.stated:
        size = float(_stated_shares(column).max())
    return _source("transverse_inertia", every, 0.0, size, not column.stated)


def _stated_shares(column: Column) -> Floats:
    """Return the relative uncertainties that a column states [1], shape (n,).

    They are 0 where it states none.
    """
    shares = np.zeros(len(column.values))
    for i, u in column.stated:
        if value := column.values[i]:
            shares[i] = u.at(value) / abs(value)
    return shares


def _position_set_source(readings: Readings, load: Floats) -> Source:
    """Return the error of a weight that was put at its mark again.

    Runs of one weight share it, unless the weight was moved for each run.
    """
    groups = number_groups(load, load)
    shared_by = "runs with the same weight"
    if readings.position_set == "each run":
        groups = np.where(load, np.arange(len(load)), -1)
        shared_by = ""
    size, default = stated_or_default(readings, "position_set")
    source = _source("position_set", groups, size.absolute, size.relative, default)
    return replace(source, shared_by=shared_by)


def _diameter_source(column: Column, mass: Floats) -> Source:
    """Return the error of the inertia of each weight from that of its diameter."""
    across = values_of(column)
    # Half of m r²: an error of the diameter counts twice.
    doubt = np.where(mass > 0, 2 * _stated_shares(column), 0.0)
    return _source("weight_diameter", number_groups(across, doubt), 0.0, doubt, False)


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


def _spin_sources(readings: Readings) -> Iterator[Source]:
    """List the errors of the readings of the spin."""
    used = spin_columns(readings)
    square = np.zeros(len(readings.runs))
    any_default = False
    for column, share in zip(used, _shares_of_readings(used), strict=True):
        relative, default = _relative_errors(readings, column)
        of_reading = share * relative
        square += of_reading**2
        any_default |= default
    groups = number_groups(list(zip(*[column.spots for column in used], strict=True)))
    usual = SOURCES["time"].usual if used[0].role == "spin_time" else None
    yield _source("spin", groups, 0.0, np.sqrt(square), any_default, usual=usual)
    yield _of_whole_log(readings, "spin_scale")


def _shares_of_readings(used: tuple[Column, ...]) -> list[Any]:
    """Return the relative change of the mean spin for one of each reading [1].

    The sum is 1.
    """
    spins = [as_spin(column) for column in used]
    if len(spins) == 1:
        return [1.0]
    if len(spins) == 2:
        share = physics.harmonic_mean_spin_share(*spins)
        return [share, 1 - share]
    parts = np.array([[1.0], [4.0], [1.0]]) / np.array(spins)
    return list(parts / parts.sum(axis=0))


def _relative_errors(readings: Readings, column: Column) -> tuple[Floats, bool]:
    """Return the relative uncertainty of each spin [1], and whether one is the default.

    It is the same for a period and for its reciprocal.
    """
    values = np.abs(values_of(column))
    if column.role != "spin_time":
        absolute, relative, default = _reading_errors(column, values, "spin")
        of_size = absolute / values
        return relative + of_size, default
    # Several turns are timed with the stopwatch.
    turns = readings.columns["spin_turns"]
    counts = values_of(turns)
    usual = Uncertainty(SOURCES["time"].default.absolute / counts.min())
    absolute, relative, default = _reading_errors(column, values, usual)
    return np.hypot(relative + absolute / values, _stated_shares(turns)), default


def _falling_spin_sources(
    readings: Readings, measured: Measurements
) -> Iterator[Source]:
    """List the errors of a spin that was read late, and falls by an unknown law."""
    used = spin_columns(readings)
    spin = measured.spin
    drag = measured.drag
    law, law_default = stated_or_default(readings, "decay_exponent")
    every = np.zeros(len(spin), dtype=int)
    if len(used) == 2:
        u = law.at(1.0) if drag is None else drag.u_exponent
        doubt = u * np.abs(physics.decay_law_doubt(*map(as_spin, used)))
        yield _source("decay_exponent", every, 0.0, doubt, law_default)
    delay = measured.delay
    if delay is None:
        return
    size, default = stated_or_default(readings, "spin_delay")
    if drag is None:
        doubt = usual_fall_u(delay, size.absolute)
        yield _source("spin_delay", every, 0.0, doubt, default)
        return
    late = np.hypot(delay, size.absolute)
    rate = drag.at(spin)
    of_rate = size.absolute * rate
    distance = np.log(spin / drag.spin)
    of_law = late * rate * distance * drag.u_exponent
    words = (
        f"{LATE:g} s late ± 1.7 s, in a spin that falls by 1/e in {1 / drag.rate:.0f} s"
    )
    yield _source("spin_delay", every, 0.0, of_rate, default, usual=words)
    yield _source("decay_exponent", every, 0.0, of_law, law_default)


def _timing_sources(readings: Readings, measured: Measurements) -> Iterator[Source]:
    """List the errors of the times, or of rates instead of times."""
    columns = readings.columns
    timing = timing_column(columns)
    time = measured.time
    turns = measured.turns
    own = np.arange(len(time))
    if timing.role == "precession_rate":
        rate = np.abs(values_of(timing))
        absolute, relative, default = _reading_errors(timing, rate, "precession_rate")
        yield _source("precession_rate", own, 0.0, relative + absolute / rate, default)
        return
    errors = _reading_errors(timing, time, "time")
    if timing.role == "time" and not timing.stated:
        angle = REVOLUTION * turns
        rate = angle / time
        beside = {"precession_period": time / turns, "precession_rate": rate}
        for role, values in beside.items():
            if role in columns and errors[-1]:
                errors = _errors_beside_time(columns[role], values, time) or errors
    yield _source("time", own, *errors)


def _errors_beside_time(
    column: Column, values: Floats, time: Floats
) -> tuple[Floats, Floats, bool] | None:
    """Return the errors of times from those that a period or rate next to them states.

    A log can have the columns t, N, T = t/N and σ_T. A rate has the same relative error
    as its period. The result is None if a run has no error.
    """
    absolute, relative, default = _reading_errors(column, values, "time")
    if default or not (absolute + relative).all():
        return None
    return absolute / values * time, relative, False


TWO_ENDS = math.sqrt(2)
"""Error of an angle with two sighted ends over the error of each of them [1]."""


def _angle_sources(readings: Readings, measured: Measurements) -> Iterator[Source]:
    """List the errors of the timed angles.

    The rod is sighted against a mark at the start and at the end of a time, unless both
    are the same mark.
    """
    column = readings.columns.get("turns") or readings.columns["angle"]
    per_turn = 1.0 if column.role == "turns" else REVOLUTION
    part = ~measured.whole_turns
    absolute = part * SOURCES["angle"].default.absolute
    relative = np.zeros(len(part))
    by_default = part.copy()
    of_one_end = stated_u(column.role, readings.uncertainties)
    for i, u in column.stated:
        # "# u_angle: 1 deg" is about one end of a part of a turn, "120 ± 1" in a cell
        # about the angle itself, as the default.
        factor = TWO_ENDS * part[i] if u == of_one_end else 1.0
        absolute[i] = factor * u.absolute / per_turn
        relative[i] = u.relative
        by_default[i] = False
    if absolute.any() or relative.any():
        own = np.arange(len(part))
        yield _source("angle", own, absolute, relative, bool(by_default.any()))
    yield from _screw_sources(readings, measured, by_default)
    if column.role == "turns":
        yield from _rounding_of_turns(column)


def _screw_sources(
    readings: Readings, measured: Measurements, by_default: Any
) -> Iterator[Source]:
    """List the error of the angle between two screws, a third of a turn apart.

    Runs between the same two screws share it. If the log does not say at which screw a
    run began, these are all runs of one third, or of two. An angle whose uncertainty
    the log states has no other error.
    """
    size, default = stated_or_default(readings, "screw_angle")
    thirds = 3 * measured.turns
    is_third = np.abs(thirds - np.round(thirds)) < 3 * WHOLE
    between = is_third & ~measured.whole_turns
    if default:
        between &= by_default
    if not between.any() or not size.absolute:
        return
    remainder = (np.round(thirds) % 3).astype(int).tolist()
    pairs = zip(readings.screws, remainder, strict=True)
    absolute = np.where(between, size.absolute / REVOLUTION, 0.0)
    groups = number_groups([*pairs], absolute)
    yield _source("screw_angle", groups, absolute, 0.0, default)


NEGLIGIBLE_ROUNDING = 1e-5
"""A number of turns that is known better than this is exact [1]: 0.333333 is 1/3."""


def _rounding_of_turns(turns: Column) -> Iterator[Source]:
    """List the error of fractions that were typed as rounded decimals.

    Runs with the same decimal have the same error.

    The error of sighting the rod is another one, of each run alone.
    """
    texts = ["" if reading.u else reading.text for reading in turns.readings]
    values = dict(zip(texts, values_of(turns), strict=True))
    doubts = {text: rounded_turns(text, values[text])[1] for text in values}
    rounding = np.array([doubts[text] for text in texts])
    rounding[rounding < NEGLIGIBLE_ROUNDING * np.abs(values_of(turns))] = 0.0
    if not rounding.any():
        return
    groups = number_groups(texts, rounding)
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
    """Return the uncertainty of a source, and whether it is the default."""
    stated = readings.uncertainties.get(f"u_{key}")
    return (SOURCES[key].default, True) if stated is None else (stated, False)


def _source(
    key: str,
    groups: Integers,
    absolute: Any,
    relative: Any,
    default: bool,
    *,
    usual: str | None = None,
) -> Source:
    """Create a source of the table, with one size of its errors or one for each run.

    `usual` describes its default if this log has another one than the table.
    """
    kind = SOURCES[key]
    nothing = np.zeros(len(groups))
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
        usual=words,
    )


def _by_value(column: Column, values: Floats, loaded: Any) -> Source:
    """Return a source with one error for each value: each weight, not each run.

    If runs of one group state different uncertainties (a column ``u_mass``), the
    largest is used for the group: it is one reading and has one error.
    """
    key = column.role
    absolute, relative, default = _reading_errors(column, values, key)
    touched = loaded & np.isfinite(values)
    group = number_groups(values, touched)
    for sizes in (absolute, relative):
        most = np.zeros_like(sizes)
        np.maximum.at(most, group[touched], sizes[touched])
        sizes[touched] = most[group[touched]]
    return _source(key, group, absolute, relative, default)


def number_groups(keys: Sequence[object] | Floats, counts: Any = None) -> Integers:
    """Number the keys from 0 in order of appearance.

    Equal keys, and values that are equal to 9 digits, have the same number.

    With `counts`, shape (n,), a run for which it is zero gets −1.
    """
    if isinstance(keys, np.ndarray):
        keys = [f"{key:.9g}" for key in keys]
    counted = [True] * len(keys) if counts is None else counts
    numbers: dict[object, int] = {}
    groups = [
        numbers.setdefault(key, len(numbers)) if is_counted else -1
        for key, is_counted in zip(keys, counted, strict=True)
    ]
    return np.array(groups, dtype=int)


def _reading_errors(
    column: Column, values: Floats, usual: Uncertainty | str
) -> tuple[Floats, Floats, bool]:
    """Return the uncertainty of each reading of a column.

    It is the stated uncertainty, or the default with the rounding. `usual` is the
    default, or the source that has it.

    The absolute [SI] and the relative [1] part have shape (n,); the last value is True
    if a default was used.
    """
    default = SOURCES[usual].default if isinstance(usual, str) else usual
    # A number rounded to steps of s is uniform within ±s/2: s/√12 (GUM F.2.2.1).
    rounding = np.array(column.steps) / math.sqrt(12)
    size = np.where(np.isfinite(values), np.abs(values), 0.0)
    whole = np.sqrt(default.absolute**2 + (default.relative * size) ** 2 + rounding**2)
    is_relative = (size > 0) & (default.relative > 0)
    absolute = np.where(is_relative, 0.0, whole)
    relative = np.divide(whole, size, out=np.zeros_like(size), where=is_relative)
    for i, stated in column.stated:
        absolute[i] = stated.absolute
        relative[i] = stated.relative
    return absolute, relative, len(column.stated) < len(values)


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
    used = spin_columns(readings)
    falls = list(readings.spin_down)
    if len(used) > 1:
        falls += zip(as_spin(used[0]), as_spin(used[-1]), time, strict=True)
    return _fit_drag(readings, np.array(falls)) if falls else None


def _fit_drag(readings: Readings, falls: Floats) -> Drag | None:
    """Fit the law of drag to falls of the spin, shape (falls, 3); see `Fall`."""
    u_exponent = stated_or_default(readings, "decay_exponent")[0].at(1.0)
    prior = max(u_exponent, 1e-6)
    start, end, seconds = falls.T
    spin = np.sqrt(start * end)
    fall = np.log(start / end)
    u = math.sqrt(2) * _usual_u_of_spin(readings) / seconds
    middle = float(np.exp(np.mean(np.log(spin))))
    distance = np.log(spin / middle)
    weight = 1 / u**2
    mean_rate = fall / seconds
    rate = float(np.sum(mean_rate * weight) / np.sum(weight))
    bend = 0.0
    information = np.diag([0.0, prior**-2])
    # Gauss-Newton steps for the rate at the middle spin and for p − 1, which has a
    # prior.
    for _step in range(20):
        # The rate at the geometric mean of both spins.
        measured_rate = mean_rate * physics.sinhc(bend * fall / 2)
        shape = np.exp(bend * distance)
        left = (measured_rate - rate * shape) / u
        rows = np.array([shape, rate * distance * shape]) / u
        covariance = np.linalg.inv(rows @ rows.T + information)
        step = covariance @ (rows @ left - information @ [rate, bend])
        rate += float(step[0])
        bend = float(np.clip(bend + step[1], -2.0, 2.0))
    left = (measured_rate - rate * shape) / u
    misfit = float(left @ left) / max(len(u) - 2, 1)
    wider = math.sqrt(max(1.0, misfit))
    u_rate, u_bend = (wider * np.sqrt(np.diag(covariance))).tolist()
    if rate <= CERTAIN * u_rate:
        return None
    if misfit > NO_LAW:
        return Drag(rate, middle, 1.0, u_exponent)
    wide = math.hypot(u_bend, NO_POWER_LAW)
    u_bend = min(wide, u_exponent)
    exponent = 1 + bend
    return Drag(rate, middle, exponent, u_bend)


def _usual_u_of_spin(readings: Readings) -> float:
    """Return the relative uncertainty of a typical reading of the spin [1]."""
    shares = np.concatenate([*map(_stated_shares, spin_columns(readings))])
    # "100 ± 0" says nothing of the other readings.
    stated = shares[shares > 0]
    usual = SOURCES["spin"].default.relative
    return float(np.median(stated)) if len(stated) else usual


# --- readings of the spin ---


def spin_columns(readings: Readings) -> tuple[Column, ...]:
    """Return the columns of the spin, in the order in which they are read."""
    columns = readings.columns
    complete = {role for role in columns if None not in columns[role].values}
    for unit in ("spin", "spin_period"):
        start = f"{unit}_start"
        end = f"{unit}_end"
        for names in ((start, unit, end), (unit,), (start, end)):
            if complete.issuperset(names):
                return tuple([columns[name] for name in names])
    if "spin_time" in columns and "spin_turns" in columns:
        return (_time_of_one(columns["spin_time"], columns["spin_turns"]),)
    raise KeyError("spin")


def _time_of_one(time: Column, turns: Column) -> Column:
    """Divide the times of several revolutions by their number."""
    readings = []
    for reading, count in zip(time.readings, turns.values, strict=True):
        if reading.value is None or not count:
            readings.append(Reading())
            continue
        step = None if reading.step is None else reading.step / count
        u = reading.u and replace(reading.u, absolute=reading.u.absolute / count)
        readings.append(replace(reading, value=reading.value / count, step=step, u=u))
    return replace(time, readings=tuple(readings))


def as_spin(column: Column) -> Floats:
    """Return the spin [rad/s] of a column of spins or of periods, shape (n,)."""
    values = np.abs(values_of(column))
    is_period = column.role.startswith(("spin_period", "spin_time"))
    return REVOLUTION / values if is_period else values
