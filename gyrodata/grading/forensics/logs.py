"""The logs of a class: the fingerprint of each log, the scatter of its times, and all logs as arrays."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Mapping
from itertools import permutations

import numpy as np
from msgspec import Struct

from gyrodata.measurements import Measurements, spin_columns
from gyrodata.physics import RPM, Floats
from gyrodata.readings import Column, Readings
from gyrodata.readings.roles import TIMINGS

MOST_ROWS = 200  # a longer log is compared by the rows with the shortest times


class Fingerprint(Struct, frozen=True):
    """One log's n rows in SI units, in the order of torque and then spin.

    The steps of the last digits show how far a copy may differ from its original by rounding only.
    """

    sha256: str  # of the file
    by_hand: bool  # True if intervals were timed with a stopwatch; False if the log has only periods or rates
    lines: tuple[int, ...]  # line of each row in the file
    torque: tuple[float, ...]  # applied torque [N*m], signed
    spin: tuple[float, ...]  # mean spin [rad/s], a magnitude
    time: tuple[float, ...]  # timed interval [s]
    turns: tuple[float, ...]  # revolutions of precession in that time [1]
    spin_step: tuple[float, ...]  # one step of the last digit typed of the spin [rad/s]; 0 if it is exact
    time_step: tuple[float, ...]  # one step of the last digit typed of the time [s]; 0 if it is exact


def fingerprint(readings: Readings, measured: Measurements) -> Fingerprint:
    """Return the fingerprint of one log; `measured`: its n runs."""
    columns = readings.columns
    timing = next(columns[role] for role in TIMINGS if role in columns)
    torque = np.array([float(f"{value:.9g}") for value in measured.torque.tolist()])
    # Rows with equal torque and spin keep the order of the file: sorted times would look alike by themselves.
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
    """Round to ten digits: more than anyone types, and short in a journal."""
    return tuple([float(f"{value:.10g}") for value in values.tolist()])


def _relative_step(column: Column) -> Floats:
    """Return one step of the last digit over the value, which is the same for a period and its rate, shape (n,)."""
    return np.array([read.step / abs(read.value) if read.step and read.value else 0.0 for read in column.readings])


# --- the scatter of the times -----------------------------------------------------------------------


HAND = 0.05
"""Standard deviation of an interval between two button presses by a good hand [s]; most people scatter more.

The `u_time` of a log is not used: with a value that is too large, a small χ² would be no sign of anything."""


class Scatter(Struct, frozen=True):
    """The residuals of one log's n times after a fit of the spin."""

    times: int  # n
    dof: int  # n minus one slope for each torque minus the shared timing bias
    squares: float  # sum of the squared residuals, with the variance that rounding may have hidden [s²]

    @property
    def size(self) -> float:
        """Standard deviation of one time [s]."""
        return math.sqrt(self.squares / self.dof)


def measure_scatter(log: Fingerprint) -> Scatter | None:
    """Fit the times of a log by T = a f ψ̇ + b, with a slope a for each torque; None without degrees of freedom.

    This is eq. (9) with any I_zz, balance, weights, ruler and scale of the tachometer, and b is the timing bias.
    Everything else that changes the times only adds to the scatter.
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

GRIDS = tuple(rpm * RPM for rpm in (100, 50, 25, 20, 10, 5, 2))  # possible steps of a tachometer [rad/s]

TRUSTED_DOF = 3  # a log's own scatter is used from this number of degrees of freedom on


class Logs:
    """N logs with R rows in total: those of the class in the order of their keys, and then the earlier logs.

    `partners`: Students whose logs may be alike. `previous`: Earlier logs.
    """

    def __init__(
        self, prints: Mapping[str, Fingerprint], partners: Iterable[frozenset[str]], previous: Mapping[str, Fingerprint]
    ) -> None:
        students, number = sorted(prints), len(prints) + len(previous)
        self.keys = [*students, *sorted(previous)]
        self.prints = [*(prints[key] for key in students), *(previous[key] for key in sorted(previous))]
        self.current = len(students)  # number of logs of this class
        together = [[students.index(key) for key in group if key in prints] for group in partners]
        exempt = {one * number + other for group in together for one, other in permutations(group, 2)}
        self.exempt = np.array(sorted(exempt), dtype=int)  # pairs that may be alike: first log times N plus second log
        earlier = number - self.current
        # Number of pairs to compare: within the class, and with the earlier logs.
        self.pairs = self.current * (self.current - 1) // 2 + self.current * earlier - len(exempt) // 2
        counts = [len(one.time) for one in self.prints]
        self.starts = np.concatenate([[0], np.cumsum(counts)]).astype(int)  # first row of each log, shape (N + 1,)
        self.log = np.repeat(np.arange(number), counts)  # log of each row, shape (R,)
        turns = self._rows("turns")
        self.torque = self._rows("torque")  # [N*m], shape (R,)
        self.spin, self.spin_step = self._rows("spin"), self._rows("spin_step")  # [rad/s], shape (R,)
        self.grids = self._grids()  # step of the tachometer in each row's log [rad/s], shape (R,)
        self.order = np.argsort(self.spin, kind="stable")  # rows in the order of their spins, shape (R,)
        self.period, self.period_step = self._rows("time") / turns, self._rows("time_step") / turns  # [s], shape (R,)
        self.scatters = [measure_scatter(one) for one in self.prints]  # None for a log without degrees of freedom
        # Smallest standard deviation of a period [s], shape (R,); 0 if it is not known.
        self.noise = np.repeat(self._noise(), counts) / turns

    def _rows(self, name: str) -> Floats:
        return np.array([value for one in self.prints for value in getattr(one, name)], dtype=float)

    def _grids(self) -> Floats:
        grids = np.maximum.reduceat(self.spin_step, self.starts[:-1])
        for grid in GRIDS:
            off = np.abs(self.spin - grid * np.round(self.spin / grid)) > 1e-6 * self.spin
            grids = np.maximum(grids, grid * ~np.logical_or.reduceat(off, self.starts[:-1]))
        return grids[self.log]

    def _noise(self) -> Floats:
        """Return the smallest scatter of each log's times [s], shape (N,): its own or the median of the class.

        The smaller of the two is used: a log that scatters more than most may contain a systematic error, which two
        logs can share. The scatter of the tachometer is subtracted, because students with the same spins share it.
        """
        noise = np.zeros(len(self.prints))
        for by_hand, least in ((True, HAND), (False, 0.0)):
            own: dict[int, float] = {}
            for at, (one, scatter) in enumerate(zip(self.prints, self.scatters, strict=True)):
                if one.by_hand == by_hand and scatter is not None and scatter.dof >= TRUSTED_DOF:
                    rows = zip(one.time, one.spin, one.spin_step, strict=True)
                    from_spin = [t**2 * (TACHOMETER**2 + (step / spin) ** 2 / 12) for t, spin, step in rows]
                    own[at] = math.sqrt(max(scatter.squares / scatter.dof - statistics.median(from_spin), 0.0))
            middle = statistics.median(own.values()) if own else 0.0
            for at, one in enumerate(self.prints):
                if one.by_hand == by_hand:
                    noise[at] = max(min(own.get(at, 0.0), middle), least)
        return noise
