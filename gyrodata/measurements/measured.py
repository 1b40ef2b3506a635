"""Measured values of each run in SI, and their uncertainty components."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict, replace

from gyrodata import physics
from gyrodata.base.errors import Diagnostic
from gyrodata.measurements import blocks
from gyrodata.measurements import sources as parts
from gyrodata.measurements.sources import (
    REVOLUTION,
    Drag,
    Source,
    as_spin,
    find_drag,
    spin_columns,
    timing_column,
    values_of,
)
from gyrodata.physics import Floats, Integers
from gyrodata.quantities.error_sources import (
    DEFAULT_TRANSVERSE_RATIO,
    LATE,
    SOURCES,
    WHOLE,
)
from gyrodata.quantities.units import Uncertainty
from gyrodata.readings import Column, Readings
from gyrodata.readings.headers import parse_header
from gyrodata.readings.lablog import listing


class Measurements(Struct, frozen=True, eq=False, dict=True):
    """One log in SI units, n runs.

    All arrays have shape (n,). Spins are magnitudes; `sense` is the sign of precession
    times spin, which is the sign of the net torque; 0 if neither the log nor the torque
    of the weight shows it.
    """

    runs: tuple[str, ...]
    lines: tuple[int, ...]
    time: Floats
    """Timed interval [s]."""
    turns: Floats
    """Revolutions of precession in that time [1]."""
    spin: Floats
    """Mean spin relative to the rod's frame [rad/s]; the harmonic mean if start and end
    were read."""
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
    g: float
    """Acceleration of free fall [m/s^2]."""
    timed: bool
    """False if the log contains rates instead of stopwatch times: these have no
    reaction time."""
    timing_bias_u: float
    """Prior width of the timing bias b [s]."""
    balance_test: Uncertainty | None
    """Prior width of the residual torque M0 [N*m] from a balance test: a fixed part, and
    one proportional to I_zz [kg*m^2]; None: no test."""
    balance_test_from: str
    """The key of the log from which that prior comes."""
    mass_step: Floats
    """One step of the last digit of each mass [kg]; 0 if unknown."""
    position_step: Floats
    """One step of the last digit of each position [m]; 0 if unknown."""
    day: Integers
    """Number of each run's day or group."""
    sources: tuple[Source, ...]
    diagnostics: tuple[Diagnostic, ...]
    spin_start: Floats | None = None
    """[rad/s]; None if it was not read."""
    spin_end: Floats | None = None
    """[rad/s]; None if it was not read."""
    slowing: Floats | float = 1.0
    """Steady precession rate over the mean rate of the run [1]; 1 if the rate is steady.
    """
    balanced: bool | None = None
    """Whether the ball is balanced; None if the log does not say."""
    balance: str | None = None
    """Whether somebody "touched" the balance between weights, or it was "untouched";
    None if the log does not say."""
    precession_sense: Floats | None = None
    """+1 counterclockwise, −1 clockwise seen from above; 0 for a run without a
    direction; None if no run has one."""
    motion: str | None = None
    """"released" from rest, or "steady"; None if the log does not say."""
    tachometer: str | None = None
    """"still", or "follows" the rod; None if the log does not say."""
    added: Floats | float = 0.0
    """Inertia that the weight adds to I_zz of each run, because it spins [kg*m^2],
    shape (n,); 0 if unknown."""
    latitude: float | None = None
    """[rad]; None if the log does not say."""
    torque_unseen: float | None = None
    """Largest torque over I_zz with which an unloaded rod would not have moved visibly
    [rad²/s²]; None if there is no run in which it did not move."""
    nutation_ratio: Floats | None = None
    """I/I_zz of each run from the period of its nutation [1], NaN if it was not
    measured; None without a column."""
    drag: Drag | None = None
    """How fast the spin falls; None if the log does not show it."""
    delay: Floats | None = None
    """How long after the middle of each run the spin was read [s], on average; negative
    if it was read before the run. None unless it was read once in each run."""
    delay_factor: Floats | None = None
    """By what the fit multiplies the spins, because they were read late or early [1];
    None without a delay."""
    block_names: tuple[str, ...] = ("",)
    """Name of each day or group, by its number."""
    metadata: Mapping[str, str] = {}
    """Every line ``# key: value`` of the log."""

    @property
    def load(self) -> Floats:
        """The mass [kg], force [N] or torque [N*m] in the log, shape (n,)."""
        for load in (self.mass, self.force):
            if not np.isnan(load).all():
                return load
        return self.given_torque

    @cached_property
    def by_torque(self) -> list[list[int]]:
        """Indices of the runs of each torque of a day, in the order of the log."""
        groups: defaultdict[str, list[int]] = defaultdict(list)
        senses = np.where(self.load == 0, self.sense, 0.0)
        settings = zip(self.load, self.position, senses, self.day, strict=True)
        for run, sizes in enumerate(settings):
            words = " ".join([f"{size:.9g}" for size in sizes])
            groups[words].append(run)
        return list(groups.values())

    @cached_property
    def by_weight(self) -> list[list[int]]:
        """Indices of the runs of each weight, without the runs that have none.

        The torques and positions of a weight agree within 1 %, as if it was weighed for
        each run.
        """
        groups: list[list[int]] = []
        sizes = np.array([self.torque, np.nan_to_num(self.position)])
        loaded = [group for group in self.by_torque if self.torque[group[0]]]
        for group in loaded:
            size = sizes[:, group[:1]]
            near = (np.abs(sizes - size) <= 0.01 * np.abs(size)).all(axis=0)
            if known := next((runs for runs in groups if near[runs[0]]), None):
                known.extend(group)
            else:
                groups.append([*group])
        return groups

    @cached_property
    def balance_groups(self) -> Integers:
        """Group of runs with the same M0, shape (n,): −1 if all runs have the same M0.

        M0 can change while a weight is changed. A run without a weight has the M0 of
        the run before it: a weight that is taken off leaves the balance as it was.
        """
        groups = np.full(len(self.runs), -1)
        if self.balance == "untouched":
            return groups
        for number, runs in enumerate(self.by_weight):
            groups[runs] = number
        loaded = np.flatnonzero(self.torque)
        before = np.searchsorted(loaded, np.arange(len(groups)), side="right") - 1
        groups = groups[loaded[np.maximum(before, 0)]]
        return parts.number_groups([*zip(self.day, groups, strict=True)])

    @property
    def one_block(self) -> bool:
        """Whether all runs are of one day and one group."""
        return not np.ptp(self.day)

    def run_words(self, indices: Sequence[int] | Integers) -> str:
        """Name some runs: "run 2", "runs 2, 5"."""
        names = listing([self.runs[run] for run in indices])
        return f"run{'s' * (len(indices) > 1)} {names}"

    def day_words(self, run: int) -> str:
        """Return the day or group of a run behind its load: ", Mon"; else ""."""
        return "" if self.one_block else f", {self.block_names[self.day[run]]}"

    @property
    def balance_differs(self) -> bool:
        """Whether M0 may differ between the weights of the log."""
        return bool(np.ptp(self.balance_groups))

    @property
    def precession_rate(self) -> Floats:
        """Size of the mean precession rate [rad/s], shape (n,)."""
        return REVOLUTION * self.turns / self.time

    @cached_property
    def product(self) -> Floats:
        """Precession rate times spin, with the torque's sign [rad²/s²], shape (n,).

        The spin is as it was read; the fit corrects it for a late reading.
        """
        sign = np.where(self.sense == 0, 1.0, self.sense)
        rate = sign * self.precession_rate
        return rate * self.spin

    @property
    def single_inertia(self) -> Floats:
        """I_zz of each run alone by eq. (9) [kg*m^2]; 0 without a weight, shape (n,)."""
        return np.abs(self.torque / self.product)

    @cached_property
    def whole_turns(self) -> Any:
        """Whether each run ends where it began, after whole turns, shape (n,)."""
        return np.abs(self.turns - np.round(self.turns)) <= WHOLE

    @property
    def corrected_spin(self) -> Floats:
        """Mean spin, corrected for the delay of its reading [rad/s], shape (n,)."""
        return self.spin if self.delay_factor is None else self.spin * self.delay_factor

    @cached_property
    def own_relative(self) -> Floats:
        """Relative u of φ̇ψ̇ from the run's own time and spin [1], shape (n,)."""
        variance = np.zeros(len(self.runs))
        for source in self.sources:
            is_own = not source.shared_by.startswith("all runs")
            if is_own and source.quantity in ("time", "spin", "turns"):
                size = getattr(self, source.quantity)
                variance += (source.absolute / size + source.relative) ** 2
        return np.sqrt(variance)

    @property
    def time_u(self) -> float | None:
        """Standard uncertainty of every time [s]; None if the runs differ."""
        for source in self.sources:
            differs = source.relative.any() or np.ptp(source.absolute)
            if source.name == "time" and not differs:
                return float(source.absolute[0])
        return None


def measure(readings: Readings) -> Measurements:
    """Compute the measured values of a log and their uncertainty components."""
    readings = without_loads(readings)
    diagnostics: list[Diagnostic] = []
    values = {role: values_of(column) for role, column in readings.columns.items()}
    loads = _loads(readings, values, diagnostics)
    timing = timing_column(readings.columns).role
    time, turns = _timing(timing, values)
    drag = find_drag(readings, time)
    spins = _spins(readings, diagnostics, time, drag)
    sense = _sense(readings, loads["torque"], diagnostics)
    pitch = np.nan_to_num(values.get("pitch", np.zeros(len(time))))
    if readings.tachometer == "still":
        excess = total_spin_excess(sense, turns, time, pitch)
        spins["spin"] = spins["spin"] - excess
    timed = timing != "precession_rate"
    bias, _ = parts.stated_or_default(readings, "time_bias")
    days = readings.blocks or [""] * len(readings.runs)
    balance_test, balance_test_from = _balance_test(readings)
    torque_unseen = None
    if readings.unmoved is not None:
        torque_unseen = _torque_unseen(readings, readings.unmoved, diagnostics)
    transverse = values.get("transverse_inertia")
    nutation = values.get("nutation_period")
    nutation_ratio = None
    if nutation is not None and transverse is None:
        nutation_ratio = spins["spin"] * nutation / REVOLUTION
    direction = values.get("precession_sense")
    measured = Measurements(
        **loads,
        **spins,
        runs=readings.runs,
        lines=readings.lines,
        time=time,
        turns=turns,
        sense=sense,
        pitch=pitch,
        transverse_inertia=transverse,
        timed=timed,
        timing_bias_u=bias.absolute if timed else 0.0,
        balance_test=balance_test,
        balance_test_from=balance_test_from,
        torque_unseen=torque_unseen,
        sources=(),
        motion=readings.motion,
        tachometer=readings.tachometer,
        precession_sense=None if direction is None else np.nan_to_num(direction),
        balanced=readings.balanced,
        balance=readings.balance,
        latitude=readings.constants.get("latitude"),
        nutation_ratio=nutation_ratio,
        drag=drag,
        day=parts.number_groups(days),
        block_names=tuple(dict.fromkeys(days)),
        metadata=readings.metadata,
        diagnostics=tuple(diagnostics),
    )
    return replace(measured, sources=blocks.sources_of(readings, measured))


def _loads(
    readings: Readings, values: Mapping[str, Floats], diagnostics: list[Diagnostic]
) -> dict[str, Any]:
    """Compute the torque of each run, and what the log says of its weight."""
    columns = readings.columns
    kind = parts.load_role(readings.columns)
    load = values[kind]
    nothing = np.full(len(readings.runs), np.nan)
    g = _gravity(readings, diagnostics)
    position = nothing
    torque = load
    added = np.zeros(len(load))
    if kind != "torque":
        position = np.where(load == 0, 0.0, values.get("position", nothing))
        torque = physics.torque(load, position, g if kind == "mass" else 1.0)
    if kind == "mass" and "weight_diameter" in columns:
        # Half of m r², as of a disk.
        added = np.nan_to_num(0.5 * load * (values["weight_diameter"] / 2) ** 2)
    steps = {role: np.array(columns[role].steps) for role in columns}
    return {
        "g": g,
        "mass": load if kind == "mass" else nothing,
        "force": load if kind == "force" else nothing,
        "given_torque": load if kind == "torque" else nothing,
        "position": position,
        "torque": torque,
        "added": added,
        "mass_step": steps.get("mass", np.zeros(len(load))),
        "position_step": steps.get("position", np.zeros(len(load))),
    }


def _gravity(readings: Readings, diagnostics: list[Diagnostic]) -> float:
    """Return g of a log [m/s^2], or its usual value."""
    constants = readings.constants
    if "g" in constants:
        return constants["g"]
    if "latitude" in constants:
        return float(physics.normal_gravity(constants["latitude"]))
    if "mass" in readings.columns:
        note = readings.say("gravity_not_given", g=physics.STANDARD_GRAVITY)
        diagnostics.append(note)
    return physics.STANDARD_GRAVITY


def _timing(role: str, values: Mapping[str, Floats]) -> tuple[Floats, Floats]:
    """Return the time [s] and the turns of each run; one turn for a period.

    `role` is that of the column of the timing.
    """
    time = values[role]
    turns = np.ones(len(time))
    if role == "precession_rate":
        time = REVOLUTION / np.abs(time)
    elif role == "time":
        turns = values["turns"] if "turns" in values else values["angle"] / REVOLUTION
    return time, np.abs(turns)


def without_loads(readings: Readings) -> Readings:
    """Return a log without its masses if it has torques and no positions.

    Only the torques are then used.
    """
    if "torque" not in readings.columns or "position" in readings.columns:
        return readings
    kept = {
        role: column
        for role, column in readings.columns.items()
        if role not in ("mass", "force")
    }
    return replace(readings, columns=kept)


def total_spin_excess(
    sense: Floats, turns: Floats, time: Floats, pitch: Floats
) -> Floats:
    """Compute how much the reading of a fixed tachometer exceeds the spin [rad/s].

    The difference is φ̇ sin(pitch), shape (n,).
    """
    sign = np.where(sense == 0, 1.0, sense)
    angle = REVOLUTION * turns
    rate = angle / time
    return sign * rate * np.sin(pitch)


def select(measurements: Measurements, kept: Sequence[int]) -> Measurements:
    """Select some of the runs, with the errors that they share."""
    sources = [_taken(source, kept) for source in measurements.sources]
    return cast(
        Measurements,
        replace(
            _taken(measurements, kept),
            sources=tuple(sources),
            runs=tuple([measurements.runs[i] for i in kept]),
            lines=tuple([measurements.lines[i] for i in kept]),
        ),
    )


def _taken(record: Any, kept: Sequence[int]) -> Any:
    """Return a record with some of the elements of its arrays."""
    index = np.asarray(kept, dtype=int)
    fields = asdict(record)
    for name, value in fields.items():
        if isinstance(value, np.ndarray):
            fields[name] = value[index]
    return type(record)(**fields)


def _spins(
    readings: Readings, diagnostics: list[Diagnostic], time: Floats, drag: Drag | None
) -> dict[str, Any]:
    """Compute the mean spin of each run, and what the log says of the spin.

    The mean is the harmonic mean in time over each run, if the only reading was in its
    middle.
    """
    used = spin_columns(readings)
    if len(used) == 1:
        return _spins_read_once(readings, used[0], time, drag)
    spins = list(map(as_spin, used))
    start = spins[0]
    end = spins[-1]
    last = used[-1]
    for i in np.flatnonzero(end > start * 1.02).tolist():
        percent = 100 * (end[i] / start[i] - 1)
        cell = last.cell(i)
        run = readings.runs[i]
        diagnostics.append(readings.say("spin_rises", cell, run=run, percent=percent))
    if len(spins) == 3:
        mean = physics.simpson_mean_spin(*spins)
    else:
        exponent = physics.VISCOUS if drag is None else drag.exponent
        mean = physics.harmonic_mean_spin(start, end, exponent)
    return {"spin": mean, "spin_start": start, "spin_end": end}


def _spins_read_once(
    readings: Readings, column: Column, time: Floats, drag: Drag | None
) -> dict[str, Any]:
    """Compute the mean spin of runs in which it was read once.

    It was read in the middle of the run, later, or before the run.
    """
    spin = as_spin(column)
    if max(column.spots, default=-1) < 0:
        # One spin for the whole log was never read at a midpoint.
        return {"spin": spin}
    delay = _reading_delay(readings, column, time)
    rate: Floats | float = parts.USUAL_RATE
    if drag is not None:
        rate = drag.at(spin)
        fall = rate * time
        # The harmonic mean in time is a little smaller than the spin in the middle.
        excess = (2 - drag.exponent) * fall**2 / 24
        part = 1 - excess
        spin = spin * part
    factor = np.exp(delay * rate)
    is_late = delay.any()
    return {"spin": spin, "delay": delay, "delay_factor": factor if is_late else None}


def _reading_delay(readings: Readings, column: Column, time: Floats) -> Floats:
    """Return how long after the middle of each run a spin was read [s], shape (n,).

    A header such as "spin at start" says that it was read before the run. A log that
    states how uncertain the delay is has no delay on average.
    """
    if column.role == "spin" and "spin_start" in parse_header(column.header).roles:
        return -time / 2
    is_stated = "u_spin_delay" in readings.uncertainties
    return np.full(len(time), 0.0 if is_stated else LATE)


def _sense(readings: Readings, torque: Floats, diagnostics: list[Diagnostic]) -> Floats:
    """Return the sign of the net torque in each run.

    The written directions or the torque of the weight determine the sign.
    """
    sign = np.sign(torque)
    written = np.ones(len(torque))
    is_stated = np.zeros(len(torque), dtype=bool)
    for role in ("spin_sense", "precession_sense"):
        if role in readings.columns:
            values = values_of(readings.columns[role])
            is_stated |= ~np.isnan(values)
            written *= np.nan_to_num(values, nan=1.0)
    if "precession_sense" not in readings.columns:
        return cast(Floats, sign)
    # A signed spin has the same meaning as a column of directions.
    back = values_of(spin_columns(readings)[0]) < 0
    states_spin = "spin_sense" in readings.columns or bool(back.any())
    written *= np.where(back, -1.0, 1.0)
    loaded = is_stated & (sign != 0)
    count = np.sum(loaded)
    opposed = np.sum(written[loaded] != sign[loaded])
    if opposed > count / 2:
        # Only products of directions matter: a log that counts one of the two the other
        # way round is consistent.
        written = -written
        # If the log does not state the direction of the spin, a clockwise spin reverses
        # every run with a weight.
        if states_spin or opposed < count:
            diagnostics.append(readings.say("senses_contradict_torque"))
    return cast(Floats, np.where(is_stated, written, sign))


def _balance_test(readings: Readings) -> tuple[Uncertainty | None, str]:
    """Return the prior width of M0 from a balance test, and the key of the test.

    The most direct statement first; (None, "") without a test.
    """
    if "u_imbalance" in readings.uncertainties:
        stated = readings.uncertainties["u_imbalance"]
        return Uncertainty(stated.absolute), "u_imbalance"
    if readings.balance_tilt is not None:
        angle, seconds = readings.balance_tilt
        # From rest under a constant torque the angle is M0 t²/(2 I).
        shift = 2 * abs(angle) / seconds**2
        column = readings.columns.get("transverse_inertia")
        if column is None:
            test = Uncertainty(relative=DEFAULT_TRANSVERSE_RATIO * shift)
        else:
            test = Uncertainty(float(np.nanmean(values_of(column))) * shift)
        return test, "balance_tilt"
    if readings.balance_drift is None:
        return None, ""
    angle, seconds, spin = readings.balance_drift
    return Uncertainty(relative=abs(spin * angle / seconds)), "balance_drift"


def _torque_unseen(
    readings: Readings, still: Readings, diagnostics: list[Diagnostic]
) -> float:
    """Compute the torque over I_zz [rad²/s²] that would have moved the rod visibly.

    The rod is the unloaded rod of the runs `still`.
    """
    counts = still.columns.get("turns") or still.columns["angle"]
    per_turn = 1.0 if counts.role == "turns" else REVOLUTION
    sighted = np.full(len(still.runs), SOURCES["angle"].default.absolute)
    for i, u in counts.stated:
        sighted[i] = u.absolute / per_turn or sighted[i]
    time = values_of(still.columns["time"])
    # Eq. (9): the torque is I_zz φ̇ψ̇.
    spin = _spins(still, diagnostics, time, None)["spin"]
    unseen = REVOLUTION * sighted / time * spin
    best = int(unseen.argmin())
    note = readings.say(
        "rod_stayed",
        counts.place(best),
        run=still.runs[best],
        time=time[best],
        degrees=360 * sighted[best],
    )
    diagnostics.append(note)
    return float(unseen[best])
