"""Measured values of each run in SI, their uncertainty components, and contradictions within the log."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.error_sources import DEFAULT_TRANSVERSE_RATIO, SOURCES
from gyrodata.errors import Diagnostic
from gyrodata.measurements import sources as parts
from gyrodata.measurements.drag import Drag, find_drag
from gyrodata.measurements.sources import Source, as_spin, spin_columns, values_of
from gyrodata.physics import Floats
from gyrodata.readings import SHARED_UNCERTAINTIES, Column, Place, Readings, as_u_of, u_keys
from gyrodata.units import Uncertainty

STEADIEST = 0.06
"""Standard uncertainty of a time that the steadiest hand stops [s]."""

NO_ACCIDENT = 0.05, 0.005
"""Rows are called identical if chance makes as many with less than this probability: one pair, or several."""


class Measurements(Struct, frozen=True, eq=False, dict=True):
    """One log in SI units, n runs.

    All arrays have shape (n,). Spins are magnitudes; `sense` is the sign of precession times spin, which is
    the sign of the net torque; 0 if neither the log nor the torque of the weight shows it.
    """

    runs: tuple[str, ...]
    lines: tuple[int, ...]
    time: Floats
    """Timed interval [s]."""
    turns: Floats
    """Revolutions of precession in that time [1]."""
    spin: Floats
    """Mean spin relative to the rod's frame [rad/s]; the harmonic mean if start and end were read."""
    mass: Floats
    """[kg]; NaN if the log contains the torque or a force."""
    position: Floats
    """[m]; 0 if no weight is on the rod, NaN if the log contains the torque."""
    force: Floats
    """[N]; NaN unless the log contains a force."""
    given_torque: Floats
    """[N*m]; NaN unless the log contains the torque itself."""
    torque: Floats
    """Signed torque applied [N*m]."""
    sense: Floats
    """+1, −1 or 0."""
    pitch: Floats
    """Rod above the horizontal [rad]; 0 if the log does not say."""
    transverse_inertia: Floats | None
    """Transverse I with the weight [kg*m^2]; None if the log does not say."""
    spin_start: Floats | None
    """[rad/s]"""
    spin_end: Floats | None
    """[rad/s]"""
    g: float
    """Acceleration of free fall [m/s^2]."""
    timed: bool
    """False if the log contains rates instead of stopwatch times: these have no reaction time."""
    timing_bias_u: float
    """Prior width of the timing bias b [s]."""
    balance_test: Callable[[float], float] | None
    """Prior width of the residual torque M0 [N*m] for a given I_zz [kg*m^2], from a balance test; None: no test."""
    balance_test_from: str
    """The key of the log from which that prior comes."""
    sources: tuple[Source, ...]
    diagnostics: tuple[Diagnostic, ...]
    spin_readings: int = 1
    """Number of readings of the spin in each run."""
    slowing: Floats | None = None
    """Steady precession rate over the mean rate of the run [1]; None if the rate is steady."""
    balanced: bool | None = None
    """Whether the ball is balanced; None if the log does not say."""
    precession_sense: Floats | None = None
    """+1 counterclockwise, −1 clockwise seen from above; 0 for a run without a direction; None if no run has one."""
    motion: str | None = None
    """"released" from rest, or "steady"; None if the log does not say."""
    tachometer: str | None = None
    """"still", or "follows" the rod; None if the log does not say."""
    added: Floats | float = 0.0
    """Inertia that the weight adds to I_zz of each run, because it spins [kg*m^2], shape (n,); 0 if unknown."""
    latitude: float | None = None
    """[rad]; None if the log does not say."""
    mass_step: Floats | None = None
    """One step of the last digit of each mass [kg]; 0 if unknown."""
    position_step: Floats | None = None
    """One step of the last digit of each position [m]; 0 if unknown."""
    torque_unseen: float | None = None
    """Largest torque over I_zz with which an unloaded rod would not have moved visibly [rad²/s²]; None if there is no
    run in which it did not move."""
    nutation_ratio: Floats | None = None
    """I/I_zz of each run from the period of its nutation [1], NaN if it was not measured; None without a column."""
    drag: Drag | None = None
    """How fast the spin falls; None if the log does not show it."""

    def __repr__(self) -> str:
        return f"<Measurements of {len(self.runs)} runs>"

    @cached_property
    def by_torque(self) -> list[list[int]]:
        """Indices of the runs of each torque, in the order of the log."""
        loads = np.where(np.isnan(self.mass), np.where(np.isnan(self.force), self.given_torque, self.force), self.mass)
        alike: dict[tuple[float, ...], list[int]] = {}
        for i, key in enumerate(zip(loads.tolist(), self.position.tolist(), self.sense.tolist(), strict=True)):
            alike.setdefault(key, []).append(i)
        groups: dict[tuple[str, str, str], list[int]] = {}
        for (load, position, sense), runs in alike.items():
            words = (f"{load:.9g}", f"{position:.9g}", f"{sense:g}" if load == 0 else "")
            groups.setdefault(words, []).extend(runs)
        return [sorted(group) for group in groups.values()]

    @cached_property
    def product(self) -> Floats:
        """Precession rate times spin, φ̇ψ̇, with the torque's sign [rad²/s²], shape (n,)."""
        sign = np.where(self.sense == 0, 1.0, self.sense)
        return sign * 2 * np.pi * self.turns / self.time * self.spin

    @cached_property
    def own_relative(self) -> Floats:
        """Relative uncertainty of each run's φ̇ψ̇ from its own time and spin [1], shape (n,)."""
        variance = np.zeros(len(self.runs))
        for source in self.sources:
            size = {"time": self.time, "spin": self.spin, "turns": self.turns}.get(source.quantity)
            if size is not None and not source.shared_by.startswith("all runs"):
                variance += (source.absolute / size + source.relative) ** 2
        return np.sqrt(variance)

    def steps_of_load(self, run: int) -> tuple[float, float]:
        """Return one step of the last digit of a run's mass [kg] and of its position [m]; 0 if unknown."""
        mass, position = (0.0 if steps is None else float(steps[run]) for steps in (self.mass_step, self.position_step))
        return mass, position

    @property
    def time_u(self) -> float | None:
        """Standard uncertainty of every time [s]; None if the runs differ."""
        own = [source for source in self.sources if source.quantity == "time" and self.timed]
        if len(own) != 1 or own[0].relative.any() or np.ptp(own[0].absolute):
            return None
        return float(own[0].absolute[0])


def measure(readings: Readings) -> Measurements:
    """Compute the measured values of a log and their uncertainty components."""
    if "torque" in readings.columns and "position" not in readings.columns:
        # A mass without a position gives no torque: the log's own torque is used.
        loads = {role: column for role, column in readings.columns.items() if role not in ("mass", "force")}
        readings = replace(readings, columns=loads)
    diagnostics: list[Diagnostic] = []
    count = len(readings.runs)
    nothing = np.full(count, np.nan)
    columns = readings.columns

    latitude = readings.constants.get("latitude")
    usual_g = physics.STANDARD_GRAVITY if latitude is None else float(physics.normal_gravity(latitude))
    g = readings.constants.get("g", usual_g)
    uses_weight = "mass" in columns
    uses_force = not uses_weight and "force" in columns
    uses_torque = not uses_weight and not uses_force
    if uses_weight and latitude is None and "g" not in readings.constants:
        diagnostics.append(readings.say("gravity_not_given", g=physics.STANDARD_GRAVITY))
    mass = values_of(columns["mass"]) if uses_weight else nothing
    force = values_of(columns["force"]) if uses_force else nothing
    given_torque = values_of(columns["torque"]) if uses_torque else nothing
    position = nothing
    if not uses_torque:
        load = mass if uses_weight else force
        position = np.where(load == 0, 0.0, values_of(columns["position"]) if "position" in columns else nothing)
    torque = given_torque if uses_torque else force * position if uses_force else physics.torque(mass, position, g)

    time, turns, timing = _timing(columns, count)
    drag = _drag(readings, time)
    spin, spin_start, spin_end = _mean_spins(readings, diagnostics, time, drag)
    sense = _sense(readings, torque, diagnostics)
    pitch = values_of(columns["pitch"]) if "pitch" in columns else np.zeros(count)
    if readings.tachometer == "still":
        spin = spin - total_spin_excess(sense, turns, time, np.nan_to_num(pitch))
    transverse = None
    if "transverse_inertia" in columns:
        transverse = values_of(columns["transverse_inertia"])

    balance_test, balance_test_from = _balance(readings)
    bias, _ = parts.stated_or_default(readings, "time_bias")
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
        timing_bias_u=bias.absolute if timing.role != "precession_rate" else 0.0,
        balance_test=balance_test,
        balance_test_from=balance_test_from,
        sources=(
            *parts.list_sources(readings, timing, time, turns, spin, mass, position, drag),
            *parts.tilt_sources(readings, pitch, transverse),
        ),
        diagnostics=(),
        spin_readings=len(spin_columns(readings)),
        motion=readings.motion,
        tachometer=readings.tachometer,
        precession_sense=np.nan_to_num(values_of(columns["precession_sense"]))
        if "precession_sense" in columns
        else None,
        balanced=readings.balanced,
        added=_added(columns, mass) if uses_weight else 0.0,
        latitude=latitude,
        mass_step=np.array(columns["mass"].steps) if uses_weight else None,
        position_step=np.array(columns["position"].steps) if "position" in columns else None,
        torque_unseen=_torque_unseen(readings, diagnostics),
        nutation_ratio=spin * values_of(columns["nutation_period"]) / (2 * np.pi)
        if "nutation_period" in columns and transverse is None
        else None,
        drag=drag,
    )
    diagnostics.extend(_find_contradictions(readings, measurements))
    diagnostics.extend(_find_too_fast(readings, measurements))
    diagnostics.extend(_find_unheard(readings, measurements, timing))
    diagnostics.extend(_find_copies(readings, measurements, timing))
    return replace(measurements, diagnostics=tuple(diagnostics))


def total_spin_excess(sense: Floats, turns: Floats, time: Floats, pitch: Floats) -> Floats:
    """Compute what a tachometer that stands still reads in excess of the spin [rad/s]: φ̇ sin(pitch), shape (n,)."""
    return np.where(sense == 0, 1.0, sense) * 2 * np.pi * turns / time * np.sin(pitch)


def select(measurements: Measurements, kept: Sequence[int]) -> Measurements:
    """Select some of the runs, with the errors that they share."""
    index = np.asarray(kept, dtype=int)
    fields: dict[str, Any] = {
        name: value[index]
        for name in measurements.__struct_fields__
        if isinstance(value := getattr(measurements, name), np.ndarray)
    }
    fields["runs"] = tuple(measurements.runs[i] for i in index)
    fields["lines"] = tuple(measurements.lines[i] for i in index)
    fields["sources"] = tuple(
        replace(
            source,
            groups=source.groups[index],
            absolute=source.absolute[index],
            relative=source.relative[index],
        )
        for source in measurements.sources
    )
    return replace(measurements, **fields)


def torque_groups(measurements: Measurements) -> list[list[int]]:
    """Return the runs of each applied torque, in the order of the log."""
    return measurements.by_torque


def _timing(table: Mapping[str, Column], count: int) -> tuple[Floats, Floats, Column]:
    """Return the interval [s] and the revolutions of each run, and the column of the timing."""
    if "time" in table and ("turns" in table or "angle" in table):
        turns = values_of(table["turns"]) if "turns" in table else values_of(table["angle"]) / (2 * np.pi)
        return values_of(table["time"]), np.abs(turns), table["time"]
    if "precession_period" in table:
        return values_of(table["precession_period"]), np.ones(count), table["precession_period"]
    rate = table["precession_rate"]
    return 2 * np.pi / np.abs(values_of(rate)), np.ones(count), rate


def _added(table: Mapping[str, Column], mass: Floats) -> Floats | float:
    """Compute the moment of inertia of each run's weight about the rod [kg*m^2]: half of m r², as of a disk."""
    if "weight_diameter" not in table:
        return 0.0
    return np.nan_to_num(0.5 * mass * (values_of(table["weight_diameter"]) / 2) ** 2)


def _drag(readings: Readings, time: Floats) -> Drag | None:
    """Find the drag from the spin-downs of a log, and from the spin at the start and the end of each run."""
    used, falls = spin_columns(readings), list(readings.spin_down)
    if len(used) > 1:
        falls += zip(as_spin(used[0]).tolist(), as_spin(used[-1]).tolist(), time.tolist(), strict=True)
    stated = [
        u.at(value) / value for column in used for i, u in column.stated if (value := abs(column.values[i] or 0.0))
    ]
    u_spin = float(np.median(stated)) if stated else SOURCES["spin"].default.relative
    return find_drag(falls, u_spin, parts.stated_or_default(readings, "decay_exponent")[0].at(1.0))


def _mean_spins(
    readings: Readings, diagnostics: list[Diagnostic], time: Floats, drag: Drag | None
) -> tuple[Floats, Floats | None, Floats | None]:
    """Compute the mean spin of each run, and the spin at its start and end if these were read [rad/s]."""
    used = spin_columns(readings)
    spins = [as_spin(column) for column in used]
    if len(used) == 1:
        if drag is None or not parts.read_once(used):
            return spins[0], None, None
        # The spin at the midpoint, which was read too late, and then the harmonic mean over the run.
        rate = drag.at(spins[0])
        mean = 1 + parts.lateness(readings) * rate - (2 - drag.exponent) * (rate * time) ** 2 / 24
        return spins[0] * mean, None, None
    start, end = spins[0], spins[-1]
    diagnostics.extend(
        readings.say("spin_rises", used[-1].cell(i), run=readings.runs[i], percent=100 * (end[i] / start[i] - 1))
        for i in np.flatnonzero(end > start * 1.02).tolist()
    )
    return parts.mean_spin(spins, physics.VISCOUS if drag is None else drag.exponent), start, end


def _sense(readings: Readings, torque: Floats, diagnostics: list[Diagnostic]) -> Floats:
    """Return the sign of the net torque in each run, from the written directions or from the torque of the weight."""
    sign = np.sign(torque)
    written = np.ones(len(torque))
    told = np.zeros(len(torque), dtype=bool)
    for role in ("spin_sense", "precession_sense"):
        if role in readings.columns:
            values = values_of(readings.columns[role])
            told |= ~np.isnan(values)
            written *= np.nan_to_num(values, nan=1.0)
    if "precession_sense" not in readings.columns:
        return cast(Floats, sign)
    # A signed spin has the same meaning as a column of directions.
    back = values_of(spin_columns(readings)[0]) < 0
    told_spin = "spin_sense" in readings.columns or bool(back.any())
    written *= np.where(back, -1.0, 1.0)
    loaded = told & (sign != 0)
    opposed = int(np.sum(written[loaded] != sign[loaded]))
    if opposed > np.sum(loaded) / 2:
        # Only products of directions matter: a log that counts one of the two the other way round is consistent.
        written = -written
        # If the log does not state the direction of the spin, a clockwise spin reverses every run with a weight.
        if told_spin or opposed < np.sum(loaded):
            diagnostics.append(readings.say("senses_contradict_torque"))
    return cast(Floats, np.where(told, written, sign))


def _balance(readings: Readings) -> tuple[Callable[[float], float] | None, str]:
    """Return the prior width of M0 from the balance test of a log; the most direct statement first."""
    stated = readings.uncertainties.get("u_imbalance")
    if stated is not None:
        width = stated.absolute
        return (lambda inertia: width), "u_imbalance"
    if readings.balance_tilt is not None:
        angle, seconds = readings.balance_tilt
        column = readings.columns.get("transverse_inertia")
        transverse = float(np.nanmean(values_of(column))) if column else None
        # From rest under a constant torque the angle is M0 t²/(2 I).
        return (
            lambda inertia: 2 * (transverse or DEFAULT_TRANSVERSE_RATIO * inertia) * abs(angle) / seconds**2
        ), "balance_tilt"
    if readings.balance_drift is not None:
        angle, seconds, spin = readings.balance_drift
        return (lambda inertia: inertia * abs(spin * angle / seconds)), "balance_drift"
    return None, ""


def _torque_unseen(readings: Readings, diagnostics: list[Diagnostic]) -> float | None:
    """Compute the torque over I_zz [rad²/s²] that would have moved an unloaded rod visibly; None without such a run."""
    still = readings.unmoved
    if still is None:
        return None
    counts, time = still.columns.get("turns") or still.columns["angle"], values_of(still.columns["time"])
    usual, turn = SOURCES["angle"].default.absolute, 1.0 if counts.role == "turns" else 2 * math.pi
    sighted = [one.u.absolute / turn if one.u and one.u.absolute else usual for one in counts.readings]
    # Eq. (9): the torque is I_zz φ̇ψ̇.
    unseen = 2 * math.pi * np.array(sighted) / time * _mean_spins(still, diagnostics, time, None)[0]
    best = int(unseen.argmin())
    values = {"run": still.runs[best], "time": time[best], "degrees": 360 * sighted[best]}
    diagnostics.append(readings.say("rod_stayed", counts.place(best), **values))
    return float(unseen[best])


def _find_contradictions(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Name the rows in which a derived column (period, rate, torque, inertia, second spin) disagrees."""
    rate = 2 * np.pi * measured.turns / measured.time
    expected: dict[str, Callable[[], Floats]] = {
        "precession_period": lambda: measured.time / measured.turns,
        "precession_rate": lambda: rate,
        "torque": lambda: np.abs(measured.torque),
        "spin": lambda: measured.spin,
        "spin_period": lambda: 2 * np.pi / measured.spin,
        "inertia": lambda: np.abs(measured.torque) / (rate * measured.spin),
        "mass": lambda: measured.mass,
        "position": lambda: np.abs(measured.position),
        "time": lambda: measured.time,
        "turns": lambda: measured.turns,
        "angle": lambda: 2 * np.pi * measured.turns,
    }
    found = []
    # These columns are always the readings themselves.
    own = {"mass", "position", "time"}
    compared = [column for role, column in readings.columns.items() if role not in own]
    for column in (*compared, *readings.others):
        if column.role not in expected:
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            finding = _compare(readings, column, expected[column.role]())
        if finding is not None:
            found.append(finding)
    return found


def _find_unheard(readings: Readings, measured: Measurements, timing: Column) -> list[Diagnostic]:
    """Name every stated ``u_…`` that has no effect, with the reason, unless it is zero."""
    columns = readings.columns
    load = next(role for role in ("mass", "force", "torque") if role in columns)
    weighed, spins, ball = load == "mass", spin_columns(readings), {"ball_mass", "ball_diameter"}
    placed = load != "torque" and "position" in columns
    silent: dict[str, str | None] = {
        "u_time_bias": "rates are given, not times of a stopwatch" if timing.role == "precession_rate" else None,
        "u_mass_scale": None if weighed else f"the {load} is given, and no mass",
        "u_g": None if weighed else f"the {load} is given, and no mass",
        "u_position_zero": None if placed else "no position is read",
        "u_spin_delay": _not_at_half_time(spins),
        "u_decay_exponent": None
        if len(spins) == 2 or (parts.read_once(spins) and measured.drag is not None)
        else "the log does not show how the spin falls, or the spin is read three times in each run",
        **dict.fromkeys(
            ("u_ball_mass", "u_ball_diameter"),
            None if ball <= set(readings.constants) else "ball_mass and ball_diameter are not both given",
        ),
        "u_rod_length": None if readings.position_from == "tip" else "no position counts from the tip of the rod",
    }
    if readings.position_from == "surface":
        silent["u_ball_diameter"] = None
    read = {load, timing.role, *(column.role for column in (*spins, *parts.told_by_period(columns, timing)))}
    read |= {"position"} if load != "torque" else set()
    read |= {"turns" if "turns" in columns else "angle"} if timing.role == "time" else set()
    read |= {"weight_diameter"} if weighed else set()
    read |= {"spin_turns"} if spins[0].role == "spin_time" else set()
    read |= {"pitch"}
    if "pitch" in columns or readings.motion == "released":
        read |= {"transverse_inertia" if "transverse_inertia" in columns else "nutation_period"}
    found = []
    for key, place in readings.stated_at.items():
        u = readings.uncertainties[key]
        base = key.removeprefix("u_")
        whole = timing.role == "time" and not parts.is_part(measured.turns).any() and not u.relative
        if key in SHARED_UNCERTAINTIES:
            why = silent.get(key)
        elif base in ("turns", "angle") and whole:
            why = "whole turns end where they began, so no mark is sighted"
        elif any(
            as_u_of(role, key, u) in (reading.u for reading in columns[role].readings)
            for role in read & set(columns)
            if key in u_keys(role)
        ):
            why = None
        elif base in read & set(columns):
            why = f"every {base} has an uncertainty of its own"
        else:
            why = _why_not_read(base, columns, timing)
        if why is not None and u != Uncertainty():
            found.append(readings.say("uncertainty_not_used", place, key=key, why=why))
    return found


def _find_copies(readings: Readings, measured: Measurements, timing: Column) -> list[Diagnostic]:
    """Warn of identical rows, unless the times are so coarse that they can agree by chance."""
    settings = list(zip(*(column.values for column in readings.columns.values() if column is not timing), strict=True))
    if not measured.timed or len(set(zip(settings, timing.values, strict=True))) == len(settings):
        return []
    runs_of: dict[int, list[int]] = {}
    for run, line in enumerate(measured.lines):
        runs_of.setdefault(line, []).append(run)
    alike: dict[object, dict[object, list[int]]] = {}
    for line, runs in runs_of.items():
        times = alike.setdefault(tuple(settings[run] for run in runs), {})
        times.setdefault(tuple(timing.values[run] for run in runs), []).append(line)
    copied = [lines for times in alike.values() for lines in times.values() if len(lines) > 1]
    rows = [sum(map(len, times.values())) for times in alike.values()]
    copies, pairs = sum(len(lines) - 1 for lines in copied), sum(n * (n - 1) // 2 for n in rows)
    # Two readings of one time agree in their last digit with this chance, by the steadiest hand.
    step = float(np.median(timing.steps))
    u = next(float(np.median(source.absolute)) for source in measured.sources if source.name == "time")
    chance = step / (2 * math.sqrt(math.pi) * math.hypot(min(u, STEADIEST), step / math.sqrt(12)) or 1.0)
    if not copied or not step or copies <= pairs * chance or chance >= 1:
        return []
    # Chernoff's bound of the probability of this many among these pairs.
    others = pairs - copies
    power = copies * math.log(copies / (pairs * chance))
    power += others * math.log(others / (pairs * (1 - chance))) if others else 0.0
    if math.exp(-power) > NO_ACCIDENT[pairs > 1]:
        return []
    shown = "; ".join(f"lines {' and '.join(map(str, lines))}" for lines in copied[:6]) + "; …" * (len(copied) > 6)
    return [readings.say("rows_identical", Place(copied[0][1], 1), lines=shown)]


def _not_at_half_time(spins: tuple[Column, ...]) -> str | None:
    """Return the reason why a late reading of the spin is not an error source; None if it is one."""
    if len(spins) > 1:
        return "the spin is read more than once in each run"
    return None if any(spot >= 0 for spot in spins[0].spots) else "one spin is given for the whole log"


def _why_not_read(role: str, columns: Mapping[str, Column], timing: Column) -> str:
    """Return the reason why the readings of a role, or their uncertainties, are not used."""
    if role == "inertia":
        return "I_zz is the result, and so is its uncertainty"
    if role in ("turns", "angle"):
        if timing.role != "time":
            return f"the log contains the {timing.role.replace('_', ' ')}, so no angle is sighted"
        return "the log also states the other one of u_turns and u_angle"
    if role == "transverse_inertia" and role in columns:
        return "the rod is level and steady, so the transverse inertia does not matter"
    if role in columns:
        return f"{role} is only compared with the readings"
    return f"there is no {role} in this log"


def _find_too_fast(readings: Readings, measured: Measurements) -> list[Diagnostic]:
    """Warn if most runs precess faster than they spin: two columns are exchanged, or a unit is wrong."""
    with np.errstate(divide="ignore", over="ignore"):
        fast = np.flatnonzero(2 * np.pi * np.abs(measured.turns / measured.time) > measured.spin)
    if 2 * len(fast) <= len(measured.runs):
        return []
    column = spin_columns(readings)[0]
    values = {"header": column.header, "fast": len(fast), "runs": len(measured.runs)}
    return [readings.say("precession_faster_than_spin", column.cell(int(fast[0])), **values)]


def _compare(readings: Readings, column: Column, expected: Floats) -> Diagnostic | None:
    """Create a finding for a column, at its first row that deviates by more than 5 % and two last digits."""
    with np.errstate(invalid="ignore"):
        gap = np.abs(np.abs(values_of(column)) - np.abs(expected))
        wrong = gap > np.maximum(0.05 * np.abs(expected), 2 * np.array(column.steps))
    if not wrong.any():
        return None
    # A reading that is used for several runs is compared once.
    there = np.flatnonzero(np.isfinite(gap))
    _, at = np.unique(np.array(column.spots)[there], return_index=True)
    off = [i for i in np.sort(there[at]).tolist() if wrong[i]]
    if not off:
        return None
    first = off[0]
    ratio = abs(column.readings[first].value or math.nan) / abs(expected[first])
    runs = ", ".join(readings.runs[i] for i in off[:6]) + (", …" if len(off) > 6 else "")
    hint = "check the turns, the units and the arithmetic of this column"
    used = readings.columns.get(column.role)
    if used is not None and used.header != column.header:
        hint = f'if this column is the {column.role}, and not "{used.header}": --map {column.role}="{column.header}"'
    runs = f"run{'s' if len(off) > 1 else ''} {runs}"
    cell = column.cell(first)
    return readings.say("derived_column_disagrees", cell, header=column.header, ratio=ratio, runs=runs, hint=hint)
