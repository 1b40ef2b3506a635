"""What was measured: SI values, and every source of uncertainty with what it is shared by.

`Readings` say what stands in the log; `Measurements` say what it means: a timed interval, a mean spin and a
torque for each run, and a list of `Source`s. A source is one independent cause of error (the reading of one
weight, the zero of the one ruler); runs that share it carry the same group number, so no covariance matrix is
ever typed or built by hand. Readings that stand in several runs are one reading: equal weights share their
error, equal positions share theirs, a spin read once for the whole log is read once.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, cast

import numpy as np

from gyrodata import physics
from gyrodata.errors import Diagnostic, register
from gyrodata.physics import Floats
from gyrodata.readings import Column, Readings
from gyrodata.units import Uncertainty

TRANSVERSE_U = 0.2
"""Relative standard uncertainty of I where the log does not give it …"""

TRANSVERSE_GIVEN_U = 0.02
"""… and where it gives I without one."""

Quantity = Literal["time", "spin", "mass", "position", "force", "torque", "g", "turns", "pitch", "transverse"]

G401 = register(
    "G401",
    "warning",
    "a derived column disagrees with the readings",
    "mass [g],position [cm],spin [rpm],time [s],turns,precession period [s]\n20.00,15.0,400,39.7,1,13.2\n",
)
G402 = register(
    "G402",
    "warning",
    "the senses written contradict the sign of the torque",
    "mass [g],position [cm],spin [rpm],time [s],turns,spin_sense,precession_sense\n20.00,15.0,400,39.7,1,ccw,cw\n",
)
G403 = register(
    "G403",
    "warning",
    "the spin rises during the interval",
    "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n20.00,15.0,400,450,39.7,1\n",
)
G404 = register(
    "G404",
    "note",
    "no acceleration of free fall is given",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20.00,15.0,400,39.7,1\n",
)
G405 = register(
    "G405",
    "warning",
    "the precession is faster than the spin",
    "mass [g],position [cm],spin [rpm],time [s],turns\n20.00,15.0,4,0.397,1\n",
)


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
    described: str
    """The uncertainty in words: "0.2 %"."""

    @property
    def shared(self) -> bool:
        """True if any two runs have the same error."""
        return self.shared_count > 0

    @property
    def shared_count(self) -> int:
        """Number of errors that several runs have in common."""
        return sum(runs > 1 for group, runs in Counter(self.groups).items() if group >= 0)


@dataclass(frozen=True)
class Measurements:
    """One log in SI units, n runs.

    All arrays have shape (n,). Spins are magnitudes; `sense` is the sign of precession times spin, which is
    the sign of the whole torque, 0 where neither the log nor the weight's torque tells it.
    """

    runs: tuple[str, ...]
    lines: tuple[int, ...]
    time: Floats
    """Timed interval [s]."""
    turns: Floats
    """Revolutions of precession in that time [1]."""
    spin: Floats
    """Mean spin relative to the rod's frame [rad/s], the harmonic mean where start and end were read."""
    mass: Floats
    """[kg]; NaN where the torque or a force was given."""
    position: Floats
    """[m]; 0 where no weight is on the rod, NaN where the torque was given."""
    force: Floats
    """[N]; NaN except where a force was given."""
    given_torque: Floats
    """[N*m]; NaN except where the torque itself was given."""
    torque: Floats
    """Signed torque applied [N*m]."""
    sense: Floats
    """+1, −1 or 0."""
    pitch: Floats
    """Rod above the horizontal [rad]; 0 where the log does not say."""
    transverse_inertia: Floats | None
    """I across the rod, weight on [kg*m^2]; None where the log does not say."""
    spin_start: Floats | None
    """[rad/s]"""
    spin_end: Floats | None
    """[rad/s]"""
    g: float
    """Acceleration of free fall [m/s^2]."""
    timed: bool
    """False where rates were given instead of stopwatch times: no reaction time then."""
    timing_bias_u: float
    """Prior width of the timing bias b [s]."""
    imbalance_u: Callable[[float], float] | None
    """Prior width of the residual torque M0 [N*m] for a given I_zz [kg*m^2], from a balance test; None: no test."""
    imbalance_from: str
    """Which key of the log that prior comes from."""
    sources: tuple[Source, ...]
    diagnostics: tuple[Diagnostic, ...]
    spin_readings: int = 1
    """How many readings of the spin each run's mean is taken from."""
    slowing: Floats | None = None
    """Steady precession rate over the mean rate of a rod let go from rest [1]; None where the rate is steady."""
    motion: str | None = None
    """"released" from rest, or "steady"; None where the log does not say."""

    @property
    def product(self) -> Floats:
        """Precession rate times spin, φ̇ψ̇, with the torque's sign [rad²/s²], shape (n,)."""
        sign = np.where(self.sense == 0, 1.0, self.sense)
        return sign * 2 * np.pi * self.turns / self.time * self.spin


def measure(readings: Readings) -> Measurements:
    """Work out what a log's readings mean, and what each of their errors is shared by.

    Parameters
    ----------
    readings : Readings
        Without errors among its diagnostics.

    Returns
    -------
    Measurements
    """
    diagnostics: list[Diagnostic] = []
    count = len(readings.runs)
    nothing = np.full(count, np.nan)
    columns = readings.columns

    g = readings.constants.get("g", physics.STANDARD_GRAVITY)
    uses_weight = "mass" in columns
    uses_force = not uses_weight and "force" in columns
    uses_torque = not uses_weight and not uses_force
    if uses_weight and "g" not in readings.constants:
        diagnostics.append(
            readings.diagnose(
                G404,
                f"g is not given: {physics.STANDARD_GRAVITY} m/s^2 is used",
                "write the local value above the header: # g: 9.803 m/s^2",
            )
        )
    mass = _values(columns["mass"]) if uses_weight else nothing
    force = _values(columns["force"]) if uses_force else nothing
    given_torque = _values(columns["torque"]) if uses_torque else nothing
    position = nothing
    if not uses_torque:
        load = mass if uses_weight else force
        position = np.where(load == 0, 0.0, _values(columns["position"]) if "position" in columns else 0.0)
    torque = given_torque if uses_torque else force * position if uses_force else physics.torque(mass, position, g)

    time, turns, timing = _timing(columns, count)
    spin, spin_start, spin_end = _spin(readings, diagnostics)
    sense = _sense(readings, torque, diagnostics)
    pitch = _values(columns["pitch"]) if "pitch" in columns else np.zeros(count)
    transverse = None
    if "transverse_inertia" in columns:
        transverse = _values(columns["transverse_inertia"])

    imbalance_u, imbalance_from = _balance(readings)
    measurements = Measurements(
        runs=readings.runs,
        lines=readings.lines,
        time=time,
        turns=turns,
        spin=spin,
        mass=mass,
        position=position,
        force=force,
        given_torque=given_torque,
        torque=torque,
        sense=sense,
        pitch=np.nan_to_num(pitch),
        transverse_inertia=transverse,
        spin_start=spin_start,
        spin_end=spin_end,
        g=g,
        timed=timing.role != "precession_rate",
        timing_bias_u=_whole(readings, "u_time_bias", 0.05, 1.0) if timing.role != "precession_rate" else 0.0,
        imbalance_u=imbalance_u,
        imbalance_from=imbalance_from,
        sources=(
            *_sources(readings, timing, time, turns, spin, mass, position),
            *_tilt_sources(readings, pitch, transverse),
        ),
        diagnostics=(),
        spin_readings=len(_spin_columns(readings)),
        motion=readings.motion,
    )
    diagnostics.extend(_contradictions(readings, measurements))
    diagnostics.extend(_too_fast(readings, measurements))
    return replace(measurements, diagnostics=tuple(diagnostics))


def select(measurements: Measurements, kept: Sequence[int]) -> Measurements:
    """Take some of the runs, with the errors that they share.

    Parameters
    ----------
    measurements : Measurements
        n runs.
    kept : sequence of int
        Indices of the runs to keep, in order.

    Returns
    -------
    Measurements
    """
    index = np.asarray(kept, dtype=int)
    fields: dict[str, Any] = {
        name: value[index]
        for name in measurements.__dataclass_fields__
        if isinstance(value := getattr(measurements, name), np.ndarray)
    }
    fields["runs"] = tuple(measurements.runs[i] for i in index)
    fields["lines"] = tuple(measurements.lines[i] for i in index)
    fields["sources"] = tuple(
        replace(
            source,
            groups=tuple(source.groups[i] for i in index),
            absolute=source.absolute[index],
            relative=source.relative[index],
        )
        for source in measurements.sources
    )
    return replace(measurements, **fields)


def torque_groups(measurements: Measurements) -> list[list[int]]:
    """Runs with the same applied torque, in the order in which they stand in the log.

    Parameters
    ----------
    measurements : Measurements
        n runs.

    Returns
    -------
    list of list of int
        Indices of the runs of each torque. Equal means equal to nine digits: the same numbers typed in
        another unit.
    """
    groups: dict[tuple[str, str, str], list[int]] = {}
    for i in range(len(measurements.runs)):
        loads = (measurements.mass[i], measurements.force[i], measurements.given_torque[i])
        load = next((value for value in loads if not math.isnan(value)), math.nan)
        key = (f"{load:.9g}", f"{measurements.position[i]:.9g}", f"{measurements.sense[i]:g}" if load == 0 else "")
        groups.setdefault(key, []).append(i)
    return list(groups.values())


# --- values ------------------------------------------------------------------------------------------------


def _values(column: Column) -> Floats:
    return np.array([math.nan if value is None else value for value in column.values], dtype=float)


def _timing(table: Mapping[str, Column], count: int) -> tuple[Floats, Floats, Column]:
    """Interval [s] and revolutions of each run, and the column that they come from."""
    if "time" in table and ("turns" in table or "angle" in table):
        turns = _values(table["turns"]) if "turns" in table else _values(table["angle"]) / (2 * np.pi)
        return _values(table["time"]), np.abs(turns), table["time"]
    if "precession_period" in table:
        return _values(table["precession_period"]), np.ones(count), table["precession_period"]
    rate = table["precession_rate"]
    return 2 * np.pi / np.abs(_values(rate)), np.ones(count), rate


def _spin_columns(readings: Readings) -> tuple[Column, ...]:
    """The columns that the spin is taken from: start, half time and end, or half time alone, or start and end."""
    columns = readings.columns
    for unit in ("spin", "spin_period"):
        for names in ((f"{unit}_start", unit, f"{unit}_end"), (unit,), (f"{unit}_start", f"{unit}_end")):
            if all(name in columns and None not in columns[name].values for name in names):
                return tuple(columns[name] for name in names)
    raise KeyError("spin")


def _as_spin(column: Column) -> Floats:
    values = np.abs(_values(column))
    return cast(Floats, 2 * np.pi / values if "period" in column.role else values)


def _spin(readings: Readings, diagnostics: list[Diagnostic]) -> tuple[Floats, Floats | None, Floats | None]:
    """Mean spin of each run, and the spin at its start and end where they were read [rad/s]."""
    used = _spin_columns(readings)
    spins = [_as_spin(column) for column in used]
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


def _spin_weights(spins: list[Floats]) -> list[Floats]:
    """Relative change of the mean spin for a relative change of each reading; they add up to 1."""
    if len(spins) == 3:
        parts = [weight / spin for weight, spin in zip((1, 4, 1), spins, strict=True)]
        return [part / sum(parts) for part in parts]
    if len(spins) == 1:
        return [np.ones_like(spins[0])]
    mean = _mean_spin(spins)
    return [slope * spin / mean for slope, spin in zip(physics.harmonic_mean_spin_slopes(*spins), spins, strict=True)]


def _sense(readings: Readings, torque: Floats, diagnostics: list[Diagnostic]) -> Floats:
    """Sign of the whole torque in each run, from the senses written or else from the weight's own torque."""
    sign = np.sign(torque)
    written = np.ones(len(torque))
    told = np.zeros(len(torque), dtype=bool)
    for role in ("spin_sense", "precession_sense"):
        if role in readings.columns:
            values = _values(readings.columns[role])
            told |= ~np.isnan(values)
            written *= np.nan_to_num(values, nan=1.0)
    used = _spin_columns(readings)[0]
    if "precession_sense" in readings.columns and "spin" in used.role and "period" not in used.role:
        # A signed spin says what a sense column would.
        written *= np.where(np.nan_to_num(_values(used), nan=1.0) < 0, -1.0, 1.0)
    if "precession_sense" not in readings.columns:
        return cast(Floats, sign)
    loaded = told & (sign != 0)
    opposed = int(np.sum(written[loaded] != sign[loaded]))
    if opposed > np.sum(loaded) / 2:
        # Only products of senses matter: a log that counts one of the two the other way round is consistent.
        written = -written
        diagnostics.append(
            readings.diagnose(
                G402,
                "most senses written are opposite to what the torque makes them: one of the two is taken as "
                "counted the other way round",
                "+1 (ccw) is right-handed about the rod, seen from its tip, and about the vertical, seen from above",
            )
        )
    return cast(Floats, np.where(told, written, sign))


def _balance(readings: Readings) -> tuple[Callable[[float], float] | None, str]:
    """Prior width of M0 from what the log says of the balance; the most direct statement first."""
    stated = readings.uncertainties.get("u_imbalance")
    if stated is not None and stated.absolute > 0:
        width = stated.absolute
        return (lambda inertia: width), "u_imbalance"
    if readings.balance_tilt is not None:
        angle, seconds = readings.balance_tilt
        column = readings.columns.get("transverse_inertia")
        transverse = float(np.nanmean(_values(column))) if column else None
        # From rest under a constant torque the angle is M0 t²/(2 I).
        return (lambda inertia: 2 * (transverse or 1.3 * inertia) * abs(angle) / seconds**2), "balance_tilt"
    if readings.balance_drift is not None:
        angle, seconds, spin = readings.balance_drift
        return (lambda inertia: inertia * abs(spin * angle / seconds)), "balance_drift"
    return None, ""


# --- sources of uncertainty --------------------------------------------------------------------------------


def _whole(readings: Readings, key: str, default: float, value: float) -> float:
    """Standard uncertainty `key` that holds for the whole log, at a value, or its default."""
    stated = readings.uncertainties.get(key)
    return default if stated is None else stated.at(value)


def _sources(
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
                words if given is None else "as given",
            )
        )

    if timing.role == "precession_rate":
        rate = _values(timing)
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
    used = _spin_columns(readings)
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
        force = _values(columns["force"])
        loaded = force != 0
        absolute, relative, default = _reading_errors(columns["force"], force, 0.0, 0.002)
        sources.append(
            _by_value("force", "force", _numbered([f"{value:.9g}" for value in force], loaded), absolute, relative,
                      "runs with the same force", default, "0.2 % and rounding")
        )  # fmt: skip
    else:
        torque = _values(columns["torque"])
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


def _tilt_sources(readings: Readings, pitch: Floats, transverse: Floats | None) -> list[Source]:
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


def _with_period_errors(timing: Column, columns: Mapping[str, Column], turns: Floats) -> Column:
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
    shared_by: str, default: bool, described: str,
) -> Source:  # fmt: skip
    """Make a source whose error goes with the value: one for each weight, not one for each run.

    Where runs of one group state different uncertainties (a column ``u_mass``), the largest holds for the
    group: it is one reading and has one error.
    """
    absolute, relative = absolute.copy(), relative.copy()
    for group in set(groups) - {-1}:
        members = [i for i, other in enumerate(groups) if other == group]
        absolute[members] = absolute[members].max()
        relative[members] = relative[members].max()
    return Source(name, quantity, groups, absolute, relative, shared_by, default, described)


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
    a, r = np.zeros(len(values)), np.zeros(len(values))
    any_default = False
    for i, stated in enumerate(column.uncertainties):
        if stated is not None:
            a[i], r[i] = stated.absolute, stated.relative
            continue
        any_default = True
        # A number rounded to steps of s is uniform within ±s/2: s/√12 (GUM F.2.2.1).
        rounding = (column.resolutions[i] or 0.0) / math.sqrt(12)
        size = abs(values[i]) if math.isfinite(values[i]) else 0.0
        whole = math.hypot(absolute, relative * size, rounding)
        if relative and size:
            r[i] = whole / size
        else:
            a[i] = whole
    return a, r, any_default


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
    used = _spin_columns(readings)
    parts = []
    any_default = False
    for column in used:
        values = np.abs(_values(column))
        absolute, relative, default = _reading_errors(column, values, 0.0, 0.002)
        # The same relative uncertainty for a period and for its reciprocal.
        parts.append(relative + absolute / values)
        any_default |= default
    weights = _spin_weights([_as_spin(column) for column in used])
    squares = sum((weight * part) ** 2 for weight, part in zip(weights, parts, strict=True))
    return np.sqrt(squares), any_default


# --- columns that should agree -----------------------------------------------------------------------------


def _contradictions(readings: Readings, measured: Measurements) -> list[Diagnostic]:
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


def _too_fast(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Warn where most runs precess faster than they spin: two columns exchanged, or a unit that is not the one."""
    with np.errstate(divide="ignore", over="ignore"):
        fast = np.flatnonzero(2 * np.pi * np.abs(measured.turns / measured.time) > measured.spin)
    if 2 * len(fast) <= len(measured.runs):
        return []
    column = _spin_columns(readings)[0]
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
