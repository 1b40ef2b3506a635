"""The logs of a class side by side: what is kept of each, how its times scatter, and all of them as arrays."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from itertools import permutations

import numpy as np
from msgspec import Struct

from gyrodata.measurements import Measurements, spin_columns
from gyrodata.physics import Floats, Integers
from gyrodata.readings import Column, Readings
from gyrodata.readings.roles import TIMINGS

MOST_ROWS = 200  # rows that are kept of a log; of a longer one, those with the shortest times


class Fingerprint(Struct, frozen=True):
    """One log's n rows, in the order of torque and then spin, however they were typed.

    Units, order, names of columns and the split into repeats are gone; the steps of the last digits tell how
    far a copy may differ from its original by rounding alone.
    """

    sha256: str  # of the file
    by_hand: bool  # True where intervals were timed with a stopwatch; False where a period or a rate is all there is
    lines: tuple[int, ...]  # line of each row in the file
    torque: tuple[float, ...]  # applied torque [N*m], signed
    spin: tuple[float, ...]  # mean spin [rad/s], a magnitude
    time: tuple[float, ...]  # timed interval [s]
    turns: tuple[float, ...]  # revolutions of precession in that time [1]
    spin_step: tuple[float, ...]  # one step of the last digit typed of the spin [rad/s]; 0 where it is exact
    time_step: tuple[float, ...]  # one step of the last digit typed of the time [s]; 0 where it is exact


def fingerprint(readings: Readings, measured: Measurements) -> Fingerprint:
    """Take the fingerprint of one log.

    `measured`: What `gyrodata.measurements.measure` makes of them, n runs; no fit is needed.
    """
    columns = readings.columns
    timing = next(columns[role] for role in TIMINGS if role in columns)
    torque = np.array([float(f"{value:.9g}") for value in measured.torque.tolist()])
    # The order of the file stays where torque and spin are equal: sorted times would look alike by themselves.
    order = np.lexsort((measured.spin, torque))
    if len(order) > MOST_ROWS:
        order = order[np.isin(order, np.argsort(measured.time, kind="stable")[:MOST_ROWS])]
    spin_step = measured.spin * np.max([_relative_step(column) for column in spin_columns(readings)], axis=0)
    time_step = measured.time * _relative_step(timing)
    return Fingerprint(
        sha256=readings.sha256,
        by_hand=timing.role == "time",
        lines=tuple([measured.lines[i] for i in order.tolist()]),
        torque=_kept(torque[order]),
        spin=_kept(measured.spin[order]),
        time=_kept(measured.time[order]),
        turns=_kept(measured.turns[order]),
        spin_step=_kept(spin_step[order]),
        time_step=_kept(time_step[order]),
    )


def _kept(values: Floats) -> tuple[float, ...]:
    """Ten digits: more than anyone types, and short in a journal."""
    return tuple([float(f"{value:.10g}") for value in values.tolist()])


def _relative_step(column: Column) -> Floats:
    """One step of the last digit over the value, the same for a period and for its rate, shape (n,)."""
    return np.array([read.step / abs(read.value) if read.step and read.value else 0.0 for read in column.readings])


# --- what the spin leaves unexplained -----------------------------------------------------------------------


HAND = 0.05
"""Standard deviation of an interval between two clicks of a good hand on a stopwatch [s]; most scatter more.

What a log states as its `u_time` plays no part: with one that is stated too large, a small chi-square is no sign."""


class Scatter(Struct, frozen=True):
    """Return the residuals of one log's n times after a fit of the spin."""

    times: int  # n
    dof: int  # n minus one slope for each torque minus the shared timing bias
    squares: float  # sum of the squares of time minus the line of its torque, with what rounding may have hidden [s²]

    @property
    def size(self) -> float:
        """Standard deviation of one time [s]."""
        return math.sqrt(self.squares / self.dof)


def measure_scatter(log: Fingerprint) -> Scatter | None:
    """Take out of the times of a log what spin, torque and timing bias explain; None if nothing is left to measure.

    T = a f ψ̇ + b with a slope a for each torque: eq. (9) with any I_zz, balance, weights, ruler and tachometer scale.
    Whatever else moves the times only adds to the scatter. A bias that the slopes explain is none of its own.
    """
    time, lever = np.array(log.time), np.array(log.turns) * np.array(log.spin)
    slopes = [lever * (np.array(log.torque) == torque) for torque in dict.fromkeys(log.torque)]
    design = np.column_stack([*slopes, np.ones(len(time))])
    size = np.linalg.norm(design, axis=0)
    solution, _, rank, _ = np.linalg.lstsq(design / size, time, rcond=1e-9)
    dof = len(time) - int(rank)
    if dof <= 0:
        return None
    left = time - design / size @ solution
    return Scatter(len(time), dof, float(left @ left + dof * np.mean(np.square(log.time_step)) / 12))


# --- all logs as arrays -------------------------------------------------------------------------------------


TACHOMETER = 0.002  # relative scatter of a reading of the spin

TRUSTED_DOF = 3  # degrees of freedom from which a log's own scatter is believed


class Logs(Struct, frozen=True):
    """N logs with R rows in all: the class, by key, and then the earlier ones, by key."""

    keys: tuple[str, ...]
    prints: tuple[Fingerprint, ...]
    current: int  # how many are of this class
    scatters: tuple[Scatter | None, ...]  # of each log; None where it has no degree of freedom
    starts: Integers  # where each log's rows begin, shape (N + 1,)
    log: Integers  # log of each row, shape (R,)
    order: Integers  # rows in the order of their spins, shape (R,)
    torque: Floats  # [N*m], shape (R,)
    spin: Floats  # [rad/s], shape (R,)
    period: Floats  # time of one revolution of precession [s], shape (R,)
    spin_step: Floats  # [rad/s], shape (R,)
    period_step: Floats  # [s], shape (R,)
    noise: Floats  # standard deviation that a period has at least [s], shape (R,); 0 where nothing tells
    exempt: Integers  # pairs that may be alike, each as its first log times N plus its second, both ways round

    @property
    def pairs(self) -> int:
        """How many pairs there are to compare: within the class, and with the earlier logs."""
        earlier = len(self.keys) - self.current
        return self.current * (self.current - 1) // 2 + self.current * earlier - len(self.exempt) // 2


def lay_out(
    prints: Mapping[str, Fingerprint], partners: Iterable[frozenset[str]], previous: Mapping[str, Fingerprint]
) -> Logs:
    """Put the logs of the class, by student, side by side. `partners`: Students whose logs may be alike."""
    students, earlier = sorted(prints), sorted(previous)
    logs = [*(prints[key] for key in students), *(previous[key] for key in earlier)]
    rows = {
        name: np.array([value for one in logs for value in getattr(one, name)], dtype=float)
        for name in ("torque", "spin", "time", "turns", "spin_step", "time_step")
    }
    counts = np.array([len(one.time) for one in logs], dtype=int)
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(int)
    scatters = [measure_scatter(one) for one in logs]
    number = {key: at for at, key in enumerate(students)}
    together = [[number[key] for key in group if key in number] for group in partners]
    exempt = {one * len(logs) + other for group in together for one, other in permutations(group, 2)}
    return Logs(
        keys=(*students, *earlier),
        prints=tuple(logs),
        current=len(students),
        scatters=tuple(scatters),
        starts=starts,
        log=np.repeat(np.arange(len(logs)), counts),
        order=np.argsort(rows["spin"], kind="stable"),
        torque=rows["torque"],
        spin=rows["spin"],
        period=rows["time"] / rows["turns"],
        spin_step=rows["spin_step"],
        period_step=rows["time_step"] / rows["turns"],
        noise=np.repeat(_noise(logs, scatters), counts) / rows["turns"],
        exempt=np.array(sorted(exempt), dtype=int),
    )


def _noise(logs: Sequence[Fingerprint], scatters: Sequence[Scatter | None]) -> Floats:
    """Least scatter of a log's times: its own or the class's middle one, whichever is less, and a good hand's at least.

    A log that scatters more than most may only be bent, and bends can be shared. What the tachometer adds is no
    scatter of the times: students who hit the same spins share them however they read them.
    """
    noise = np.zeros(len(logs))
    for by_hand, least in ((True, HAND), (False, 0.0)):
        own = {
            at: math.sqrt(max(scatter.squares / scatter.dof - _from_tachometer(one), 0.0))
            for at, (one, scatter) in enumerate(zip(logs, scatters, strict=True))
            if one.by_hand == by_hand and scatter is not None and scatter.dof >= TRUSTED_DOF
        }
        middle = statistics.median(own.values()) if own else 0.0
        for at, one in enumerate(logs):
            if one.by_hand == by_hand:
                noise[at] = max(min(own.get(at, 0.0), middle), least)
    return noise


def _from_tachometer(one: Fingerprint) -> float:
    """Variance that the readings of the spin bring into the times [s²], in the middle of the log's rows."""
    rows = zip(one.time, one.spin, one.spin_step, strict=True)
    return statistics.median(time**2 * (TACHOMETER**2 + (step / spin) ** 2 / 12) for time, spin, step in rows)
