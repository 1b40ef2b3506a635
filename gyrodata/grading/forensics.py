"""Find logs that look copied or invented: flags are questions to a person, never verdicts.

A fingerprint of each log is kept, and all logs are compared at once (`flag_class`):

* rows in common, in any order, unit and rounding;
* the same spins at the same weights, whatever the times are, or spins that are much
  closer than those of other logs;
* scatter below what a hand can do.

Every threshold follows from one number, `ALLOWED`: the expected number of flags of one
kind in a class of honest students. Each flag contains the number of equally strong
flags that are expected by chance.
"""

from __future__ import annotations

import heapq
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from typing import Literal, get_args

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from gyrodata.fitting import chi2_lower_tail
from gyrodata.grading.yardsticks import grouped
from gyrodata.measurements import Measurements, spin_columns
from gyrodata.physics import RPM, Floats, Integers
from gyrodata.readings import Column, Readings
from gyrodata.readings.lablog import split_lines
from gyrodata.readings.roles import TIMINGS
from gyrodata.readings.writing import SIMULATED

Kind = Literal["shared rows", "same spins", "similar spins", "scatter", "simulated"]

KINDS: tuple[Kind, ...] = get_args(Kind)
"""All kinds, in the order in which they are listed."""

ALLOWED = 0.05
"""Largest expected number of flags of one kind in a class of honest students; the
thresholds follow from it."""

LEAST = 1e-300  # smallest probability, so that none is zero

Prints = Mapping[str, "Fingerprint"]
"""Logs by their keys."""
NOTHING: Prints = {}
Pairs = dict[tuple[int, int], float]
"""Probability that two honest logs are so similar, by the numbers of their tables, the
smaller one first."""


class Flag(Struct, frozen=True):
    """A finding, and how often it occurs among honest students."""

    kind: Kind
    students: tuple[str, ...]  # their keys, sorted
    evidence: str  # in words, with the numbers
    p: float
    """Probability of this or more in one honest log, or between two; of the strongest
    pair if there are several."""
    # number of equally strong or stronger flags that is expected in an honest class of
    # this size
    expected: float
    previous: tuple[str, ...] = ()  # keys of earlier logs in it, sorted


def flag_class(
    prints: Prints, partners: Iterable[frozenset[str]] = (), previous: Prints = NOTHING
) -> tuple[Flag, ...]:
    """Compare the logs of a class, and return the flags by kind.

    The flags are in the order of `KINDS`, then in the order of students.

    `prints`: One log of each student, by the student's key. `partners`: Students who
    hand in the same data; a student may be in several groups. `previous`: Earlier logs
    and published examples, by keys of their own; they are compared with the logs of the
    class, not with each other. Logs that are joined by one kind are not joined again by
    the next kind, and many copies of one log are one flag.
    """
    logs = Logs(prints, partners, previous)
    flags = flag_scatter(logs)
    if logs.pairs > 0:
        rows, spins = shared(logs)
        # The stronger evidence is told.
        rows = {pair: p for pair, p in rows.items() if p <= spins.get(pair, 1.0)}
        for kind, pairs in zip(KINDS, (rows, spins, similar(logs)), strict=False):
            flags += flag_pairs(kind, pairs, logs, flags)
    return in_order(flags)


def in_order(flags: Iterable[Flag]) -> tuple[Flag, ...]:
    """Sort flags by kind, in the order of `KINDS`, then by students."""
    return tuple(
        sorted(
            flags,
            key=lambda flag: (KINDS.index(flag.kind), flag.students, flag.previous),
        )
    )


# --- the fingerprint of a log ---

WEIGHED_AGAIN = 0.015
"""Largest share by which the torques of one weight differ."""

MOST_ROWS = 200  # a longer log is compared by the rows with the shortest times


class Fingerprint(Struct, frozen=True):
    """One log's n rows in SI units, in the order of weight and then spin.

    The steps of the last digits show how far a copy may differ from its original by
    rounding only.
    """

    sha256: str  # of the file
    # True if intervals were timed with a stopwatch; False if the log has only periods
    # or rates
    by_hand: bool
    lines: tuple[int, ...]  # line of each row in the file
    torque: tuple[float, ...]  # applied torque [N*m], signed
    spin: tuple[float, ...]  # mean spin [rad/s], a magnitude
    time: tuple[float, ...]  # timed interval [s]
    turns: tuple[float, ...]  # revolutions of precession in that time [1]
    spin_step: tuple[
        float, ...
    ]  # one step of the last digit typed of the spin [rad/s]; 0 if it is exact
    time_step: tuple[
        float, ...
    ]  # one step of the last digit typed of the time [s]; 0 if it is exact
    simulated: int = (
        0  # line of the file that says that the log is simulated; 0 if none does
    )


def fingerprint(readings: Readings, measured: Measurements) -> Fingerprint:
    """Return the fingerprint of one log; `measured`: its n runs."""
    timing = next(
        readings.columns[role] for role in TIMINGS if role in readings.columns
    )
    torque = np.array([float(f"{value:.9g}") for value in measured.torque.tolist()])
    # Rows with equal torque and spin keep the order of the file: sorted times would
    # look alike by themselves.
    order = np.lexsort((measured.spin, weights(torque)))
    if len(order) > MOST_ROWS:
        order = order[
            np.isin(order, np.argsort(measured.time, kind="stable")[:MOST_ROWS])
        ]
    spin_step = measured.spin * np.max(
        [_relative_step(column) for column in spin_columns(readings)], axis=0
    )
    rows = {
        "torque": torque,
        "spin": measured.spin,
        "time": measured.time,
        "turns": measured.turns,
    }
    rows |= {
        "spin_step": spin_step,
        "time_step": measured.time * _relative_step(timing),
    }
    # Ten digits are more than anyone types, and short in a journal.
    kept = {
        name: tuple([float(f"{one:.10g}") for one in values[order].tolist()])
        for name, values in rows.items()
    }
    lines = tuple([measured.lines[i] for i in order.tolist()])
    return Fingerprint(
        sha256=readings.sha256,
        by_hand=timing.role == "time",
        lines=lines,
        simulated=_simulated(readings),
        **kept,
    )


def _simulated(readings: Readings) -> int:
    """Return the line that says, in any words, that a log is simulated, or 0."""
    lines = split_lines(readings.source_text)
    return next(
        (number for number, line in enumerate(lines, 1) if _says_simulated(line)), 0
    )


_SIMULATED = re.compile(r"\b(?:simulated|simuliert\w*|simulad[oa]s?|simulat[oaie])\b")


def _says_simulated(line: str) -> bool:
    """Return whether a remark says that its log is simulated, not measured."""
    words = _words_of(line)
    is_remark = line.lstrip(' "').startswith(("#", "%"))
    if _words_of(SIMULATED) in words or "gyro simulate" in words:
        return True
    if not is_remark or not _SIMULATED.search(words) or "not simulated" in words:
        return False
    return (
        "measured" not in words
        or re.search(r"(?:not|never) (?:\w+ )?measured", words) is not None
    )


def _words_of(text: str) -> str:
    return " ".join(re.findall("[a-z]+", text.lower()))


def weights(torque: Floats) -> Integers:
    """Return the number of the weight of each row, in the order of torque.

    A weight that is weighed again has the same number.

    Torques that differ by less than `WEIGHED_AGAIN` are of one weight.
    """
    sizes = np.array(sorted(set(torque.tolist())))
    return np.searchsorted(
        sizes[1:][np.diff(sizes) > WEIGHED_AGAIN * np.abs(sizes[1:])],
        torque,
        side="right",
    )


def _relative_step(column: Column) -> Floats:
    """Return one step of the last digit over the value, shape (n,).

    This ratio is the same for a period and its rate.
    """
    return np.array(
        [
            read.step / abs(read.value) if read.step and read.value else 0.0
            for read in column.readings
        ]
    )


# --- all logs as arrays ---

HAND = 0.05
"""Standard deviation of an interval between two button presses by a good hand [s]; most
people scatter more.

The `u_time` of a log is not used: with a value that is too large, a small χ² would be
no sign of anything."""

GRIDS = RPM * np.array(
    [[100.0], [50.0], [25.0], [20.0], [10.0], [5.0], [2.0]]
)  # steps of a tachometer [rad/s]

ROUND = 50 * RPM  # multiples of this are spins that students aim at [rad/s]

_EXACT = 1e-9


def measure_scatter(log: Fingerprint) -> tuple[int, float]:
    """Fit the n times of a log by T = a f ψ̇/|M| + b, with a slope a for each weight.

    Return the scatter around the fit.

    This is eq. (9) with any I_zz, balance, weights, ruler and scale of the tachometer,
    and b is the timing bias. Everything else that changes the times only adds to the
    scatter. Returns the degrees of freedom (n minus the slopes minus the bias), and the
    standard deviation of a time [s], with the variance that rounding may have hidden.
    """
    time, lever = np.array(log.time), np.array(log.turns) * np.array(log.spin)
    torque = np.array(log.torque)
    weight, lever = weights(torque), lever / np.where(torque == 0, 1.0, np.abs(torque))
    slopes = [lever * (weight == number) for number in dict.fromkeys(weight.tolist())]
    design = np.column_stack([*slopes, np.ones(len(time))])
    design /= np.linalg.norm(design, axis=0)
    solution, _, rank, _ = np.linalg.lstsq(design, time, rcond=1e-9)
    left, dof = time - design @ solution, len(time) - int(rank)
    return dof, math.sqrt(
        left @ left / max(dof, 1) + np.mean(np.square(log.time_step)) / 12
    )


class Logs:
    """N logs: those of the class in the order of their keys, and then the earlier logs.

    Logs with the same rows share one of U tables, so that many copies of a log take the
    time of one. The tables have R rows in total. `partners`: Students whose logs may be
    alike. `previous`: Earlier logs.
    """

    def __init__(
        self, prints: Prints, partners: Iterable[frozenset[str]], previous: Prints
    ) -> None:
        students, self.current = (
            sorted(prints),
            len(prints),
        )  # number of logs of this class
        self.keys = [*students, *sorted(previous)]
        self.prints = [
            *(prints[key] for key in students),
            *(previous[key] for key in sorted(previous)),
        ]
        self.exempt = self._exempt(partners)
        # Number of pairs to compare: within the class, and with the earlier logs.
        self.pairs = self.current * (self.current - 1) // 2 + self.current * len(
            previous
        )
        self.pairs -= sum(some.bit_count() for some in self.exempt.values()) // 2
        same = grouped(
            (replace(one, sha256="", lines=()), log)
            for log, one in enumerate(self.prints)
        )
        self.tables = list(same)
        self.members = list(same.values())  # the logs of each table
        self.copies = np.array(
            [len(logs) for logs in self.members], dtype=int
        )  # shape (U,)
        self.table_of = {
            log: table for table, logs in enumerate(self.members) for log in logs
        }
        counts = [len(one.time) for one in self.tables]
        self.starts = np.concatenate([[0], np.cumsum(counts)]).astype(
            int
        )  # first row of each table, shape (U + 1,)
        self.table = np.repeat(
            np.arange(len(counts)), counts
        )  # table of each row, shape (R,)
        turns, self.torque = (
            self._rows("turns"),
            np.abs(self._rows("torque")),
        )  # torque [N*m], shape (R,)
        self.spin, self.spin_step = (
            self._rows("spin"),
            self._rows("spin_step"),
        )  # [rad/s], shape (R,)
        self.coarsest = np.max(self.spin_step, initial=0.0)  # [rad/s]
        self.grid = np.repeat(
            [_grid(one) for one in self.tables], counts
        )  # [rad/s], shape (R,)
        self.order = np.argsort(
            self.spin, kind="stable"
        )  # rows in the order of their spins, shape (R,)
        self.period, self.period_step = (
            self._rows("time") / turns,
            self._rows("time_step") / turns,
        )  # [s], shape (R,)
        self.scatters = [measure_scatter(one) for one in self.tables]
        # Standard deviation of a period [s], shape (R,). A log that scatters more than
        # most may contain a systematic error, which two logs can share: then the median
        # of all logs is used.
        sizes = [size for _, size in self.scatters]
        usual = np.median(np.repeat(sizes or [0.0], self.copies if sizes else 1))
        least = np.maximum(
            np.minimum(sizes, usual), [HAND * one.by_hand for one in self.tables]
        )
        self.noise = np.repeat(least, counts) / turns
        # Rows with a spin that is not round, each spin once per weight, shape (R,).
        off = np.abs(self.spin - ROUND * np.round(self.spin / ROUND))
        self.useful = off > 0.5 * self.spin_step + _EXACT * self.spin
        self.useful[1:] &= (
            (np.diff(self.table) != 0)
            | (np.diff(self.torque) != 0)
            | (np.diff(self.spin) != 0)
        )
        self.known = np.add.reduceat(
            self.useful, self.starts[:-1], dtype=int
        )  # number of these, shape (U,)

    def _exempt(self, partners: Iterable[frozenset[str]]) -> dict[int, int]:
        """Return the logs that each log may be like, as a mask with a bit for each log."""
        number = {key: log for log, key in enumerate(self.keys[: self.current])}
        exempt: dict[int, int] = {}
        for group in partners:
            logs = [number[key] for key in group if key in number]
            for log in logs:
                exempt[log] = exempt.get(log, 0) | (mask_of(logs) & ~(1 << log))
        return exempt

    def compared_with(self, log: int) -> int:
        """Return the logs that a log is compared with, as a mask.

        Earlier logs are not compared with each other.
        """
        every = (1 << (len(self.keys) if log < self.current else self.current)) - 1
        return every & ~self.exempt.get(log, 0) & ~(1 << log)

    def rows_of(self, log: int) -> Integers:
        """Return the numbers of the n rows of a log, shape (n,)."""
        table = self.table_of[log]
        return np.arange(self.starts[table], self.starts[table + 1])

    def _rows(self, name: str) -> Floats:
        return np.array(
            [value for one in self.tables for value in getattr(one, name)], dtype=float
        )

    def same(self, name: str, one: Integers, other: Integers) -> NDArray[np.bool_]:
        """Return which rows have the same "spin" or "period".

        Two values are compared to the last digit of the coarser value.
        """
        values, steps = getattr(self, name), getattr(self, f"{name}_step")
        return _same_number(values[one], values[other], steps[one], steps[other])


def mask_of(logs: Iterable[int]) -> int:
    """Return an integer with a bit for each of some logs.

    The integer is small and fast, even for thousands of logs.
    """
    mask = bytearray()
    for log in logs:
        mask.extend(bytes(max(0, log // 8 + 1 - len(mask))))
        mask[log // 8] |= 1 << log % 8
    return int.from_bytes(mask, "little")


def logs_of(mask: int) -> Iterator[int]:
    """Give the logs of a mask, in order."""
    data = np.frombuffer(
        mask.to_bytes((mask.bit_length() + 7) // 8, "little"), dtype=np.uint8
    )
    yield from np.flatnonzero(np.unpackbits(data, bitorder="little")).tolist()


def _grid(log: Fingerprint) -> float:
    """Return the step of the tachometer [rad/s].

    It is the largest step with which all spins of a log agree.
    """
    spin = np.array(log.spin)
    agree = (np.abs(spin - GRIDS * np.round(spin / GRIDS)) <= 1e-6 * spin).all(axis=1)
    return float(max([*log.spin_step, *GRIDS[agree, 0]]))


# --- one log by itself: scatter below what a hand can do ---


def flag_scatter(logs: Logs) -> list[Flag]:
    """Find logs whose times are closer to straight lines than a hand can stop them."""
    everyone = [
        (key, logs.table_of[number])
        for number, key in enumerate(logs.keys[: logs.current])
    ]
    tables = [
        (key, logs.tables[table], *logs.scatters[table]) for key, table in everyone
    ]
    timed = [
        (key, log, dof, size)
        for key, log, dof, size in tables
        if log.by_hand and dof > 0
    ]
    flags = []
    for key, log, dof, size in timed:
        # A scatter as large as that of a good hand, or larger, is never rare.
        p = chi2_lower_tail(dof * (size / HAND) ** 2, dof) if size < HAND else 1.0
        if p * len(timed) <= ALLOWED:
            told = (
                f"its {len(log.time)} times are within {size:.2g} s of straight lines "
                f"in the spin, one for each"
            )
            told = (
                f"{told} torque ({dof} degrees of freedom); a hand on a stopwatch "
                f"scatters by {HAND:g} s or more"
            )
            flags.append(Flag("scatter", (key,), told, p, p * len(timed)))
    return flags


# --- rows and spins that two logs share ---
#
# The question is how often two honest logs would agree as much as two given logs do.
# For each row of a log there are two probabilities:
#
# * that another log has the same spin at the same weight: the share of the logs that
# have it. Round spins do not
#   count, because many students aim at them;
# * that another log also has the same period. Two people who time the same spin seldom
# stop at the same hundredth of
#   a second; the probability follows from the scatter of a hand and from the last
# digit.
#
# The number of rows that agree by chance then has the distribution of a sum of
# independent events. Each pair is judged from both of its logs, and the larger
# probability counts.

SAME_TORQUE = 0.1
"""Rows are compared if their torques differ by less than this share: each station has
weights of its own."""

# a pair is flagged from this number of rows on; if only spins agree, from one more
FEWEST = 3

MOST_SPINS = 0.5  # share of the spins of the shorter log that must agree

HABIT, HABIT_SHARE = 5, 0.02
"""If more logs than both of these, a number and a share of the class, have a set of
spins, the course asked for it."""


def shared(logs: Logs) -> tuple[Pairs, Pairs]:
    """Find the pairs of logs with more rows in common than expected by chance.

    The second result contains the pairs with more spins in common than expected.
    """
    found: tuple[Pairs, Pairs] = {}, {}
    for table in range(len(logs.tables)):
        for pairs, chances in zip(found, _shared_with(logs, table), strict=True):
            pairs |= {
                (table, other): p for other, p in chances if p <= ALLOWED / logs.pairs
            }
    rows, spins = (
        {
            (i, j): max(p, pairs[j, i])
            for (i, j), p in pairs.items()
            if i <= j and (j, i) in pairs
        }
        for pairs in found
    )
    return rows, spins


def _same_number(
    one: Floats, other: Floats, step: Floats, other_step: Floats
) -> NDArray[np.bool_]:
    """Return which numbers are the same to the last digit of the coarser one."""
    return np.abs(one - other) <= 0.5 * np.maximum(step, other_step) + _EXACT * one


def _same_weight(one: Floats, other: Floats) -> NDArray[np.bool_]:
    return np.abs(one - other) <= SAME_TORQUE * np.maximum(one, other)


def _tails(chances: Floats) -> Floats:
    """Return the probability that k or more of n events occur, for m sets of events.

    The shape of the result is (m, n + 1).
    """
    numbers: Floats = np.eye(1, chances.shape[1] + 1).repeat(len(chances), axis=0)
    for chance in chances.T[:, :, None]:
        more = chance * numbers[:, :-1]
        numbers *= 1 - chance
        numbers[:, 1:] += more
    return numbers[:, ::-1].cumsum(axis=1)[:, ::-1].clip(LEAST)


def _shared_with(
    logs: Logs, table: int
) -> tuple[Iterable[tuple[int, float]], Iterable[tuple[int, float]]]:
    """Compare a log with K tables of other logs that have one of its spins.

    With its own table if that has copies.

    Returns these tables with the probability that an honest log has as many of its
    rows, and of its spins; only those with enough of them.
    """
    number, rows = len(logs.keys), np.arange(logs.starts[table], logs.starts[table + 1])
    # Each row with each row of another log that has its weight and its spin, to the
    # step of the tachometer.
    reach = (
        0.5 * np.maximum(logs.grid[rows], logs.coarsest) + 2 * _EXACT * logs.spin[rows]
    )
    low = np.searchsorted(logs.spin, logs.spin[rows] - reach, sorter=logs.order)
    high = np.searchsorted(
        logs.spin, logs.spin[rows] + reach, side="right", sorter=logs.order
    )
    mine = np.repeat(rows, high - low)
    other = np.concatenate(
        [logs.order[begin:end] for begin, end in zip(low, high, strict=True)]
    )
    same = (logs.table[other] != table) | (logs.copies[table] > 1)
    same &= _same_weight(logs.torque[mine], logs.torque[other])
    same &= _same_number(
        logs.spin[mine], logs.spin[other], logs.grid[mine], logs.spin_step[other]
    )
    mine, other = mine[same], other[same]
    others = np.flatnonzero(np.bincount(logs.table[other]))
    at = np.searchsorted(others, logs.table[other])
    # Number of other logs with each table, shape (K,).
    weight = logs.copies[others] - (others == table)

    def which_have(which: NDArray[np.bool_] | slice) -> NDArray[np.bool_]:
        """Return which of the K tables has which row, shape (K, n)."""
        found = np.zeros((len(others), len(rows)), dtype=bool)
        found[at[which], mine[which] - rows[0]] = True
        return found

    spin = logs.same("spin", mine, other)
    agree, useful = (
        which_have(spin & logs.same("period", mine, other)),
        logs.useful[rows],
    )
    same_rows, same_spins = agree.sum(axis=1), (which_have(spin) & useful).sum(axis=1)
    enough = np.maximum(
        MOST_SPINS * np.minimum(logs.known[table], logs.known[others]), FEWEST
    )
    by_rows, by_spins = same_rows >= FEWEST, same_spins > enough
    if not (by_rows | by_spins).any():
        return (), ()
    # A value that n logs have is seen in the other log of a pair in n of N cases.
    common = (1 + weight @ which_have(slice(None))) / number
    habit = np.sum(weight[same_spins > MOST_SPINS * logs.known[table]]) > max(
        HABIT, HABIT_SHARE * number
    )
    common[~useful | habit] = 1.0
    # No interval of this width contains more of a normal distribution.
    step = logs.period_step[rows] + 2 * _EXACT * logs.period[rows]
    chance = step / np.maximum(math.sqrt(4 * math.pi) * logs.noise[rows], step)
    # An example that everybody left in the log is in many logs that are not alike
    # otherwise.
    unlike = 2 * same_rows < len(rows)
    crowd = np.maximum(weight[unlike] @ agree[unlike] - 1, 0) / max(number - 2, 1)
    tails = _tails(np.array([np.maximum(common * chance, crowd), common * useful]))
    of_rows = zip(
        others[by_rows].tolist(), tails[0, same_rows[by_rows]].tolist(), strict=True
    )
    return of_rows, zip(
        others[by_spins].tolist(), tails[1, same_spins[by_spins]].tolist(), strict=True
    )


# --- logs with similar spins: copies in which every number was changed a little ---

# the density of honest logs around a log follows from the distance of this neighbour
NEIGHBOURS = 5

NEAR_ALLOWED = (
    0.01  # smaller than `ALLOWED`, because the density of honest logs is only estimated
)

NEAR_LOGS = 2000  # in a larger class, honest logs are as close as changed copies

NEAR_SPINS = 0.04  # largest relative difference of the spins, root mean square

NEAR_ROWS = 6  # number of spins, not counting round ones, that two logs must have


def similar(logs: Logs) -> Pairs:
    """Find pairs of logs with spins that are much closer to each other than those of the next logs.

    Logs with the same number of runs at each weight are compared in the order of weight
    and spin. The distance is the mean square of the relative differences, with the
    variance of rounding: so copies are found if the spins are written to 1 rpm, but not
    to 10 rpm. Spins that differ by `NEAR_SPINS` or more are not those of a copy. In n
    dimensions, a distance d that is smaller than a usual distance D has the probability
    (d/D)^n. The usual distance is the smallest of these: from the log to its fifth
    neighbour; from most logs of the class to their nearest neighbour; from the log to
    the middle of the class.
    """
    found: Pairs = {}
    patterns = [tuple(weights(np.array(one.torque)).tolist()) for one in logs.tables]
    for pattern, members in grouped(
        zip(patterns, range(len(patterns)), strict=True)
    ).items():
        copies = logs.copies[members]
        if len(pattern) < NEAR_ROWS or not NEIGHBOURS < copies.sum() <= NEAR_LOGS:
            continue
        rows = logs.starts[members][:, None] + np.arange(len(pattern))
        spin = np.log(logs.spin[rows])
        spin -= np.median(np.repeat(spin, copies, axis=0), axis=0)
        size, counts = (
            spin**2 + (logs.grid[rows] / logs.spin[rows]) ** 2 / 12,
            logs.useful[rows].astype(float),
        )
        number = counts @ counts.T
        # The sum of (a - b)² over the spins that count in both logs.
        square = (counts * size) @ counts.T
        square = np.abs(
            square + square.T - 2 * (counts * spin) @ (counts * spin).T
        ) / np.maximum(number, 1)
        # A log has no distance from itself, but one from its copies.
        square[
            (number < NEAR_ROWS) | (np.eye(len(members), dtype=bool) & (copies == 1))
        ] = np.inf
        first, last = (_nearest(square, copies, count) for count in (1, NEIGHBOURS))
        usual = np.minimum(
            2 * np.mean(size, axis=1), np.median(np.repeat(first, copies))
        )
        usual = np.minimum(last, usual)
        chance = np.where(
            square < NEAR_SPINS**2,
            NEIGHBOURS * (square / usual[:, None]) ** (number / 2),
            1.0,
        )
        chance = np.maximum(np.maximum(chance, chance.T) / copies.sum(), LEAST)
        for i, j in np.argwhere(chance * logs.pairs <= NEAR_ALLOWED).tolist():
            if i <= j:
                found[members[i], members[j]] = float(chance[i, j])
    return found


def _nearest(square: Floats, copies: Integers, count: int) -> Floats:
    """Return the distance of each table from the `count`-th nearest other log, shape (U,).

    `square`: Distances between the tables, shape (U, U). `copies`: Number of logs of
    each table, shape (U,).
    """
    order = np.argsort(square, axis=1)
    others = copies - np.eye(len(copies), dtype=int)
    enough = np.take_along_axis(others, order, axis=1).cumsum(axis=1) >= count
    at = np.take_along_axis(order, enough.argmax(axis=1)[:, None], axis=1)
    distances: Floats = np.take_along_axis(square, at, axis=1)[:, 0]
    return distances


# --- flags of logs that are too similar ---

PAIRS_TOLD = 3  # number of pairs of a group whose evidence is written


Links = dict[int, int]
"""For each log, the logs that it is paired with, as a mask."""


def flag_pairs(
    kind: Kind, pairs: Pairs, logs: Logs, before: Iterable[Flag]
) -> list[Flag]:
    """Make one flag of all pairs that are connected.

    For example, five copies of one log are one finding, not ten.

    `before`: Flags of other kinds; pairs that these join already are left out.
    """
    free = _not_joined(pairs, logs, before)
    links = {pair: _links_of(pair, logs, free) for pair in pairs}
    group_of = _groups_of(links.values())
    parts: dict[int, list[tuple[float, Links]]] = {}
    for pair, some in links.items():
        for group, inner in grouped(
            (group_of[log], log) for log in sorted(some)
        ).items():
            parts.setdefault(group, []).append(
                (pairs[pair], {log: some[log] for log in inner})
            )
    members = grouped((group, log) for log, group in sorted(group_of.items()))
    flags = []
    for group, found in parts.items():
        # Each pair is counted from both of its logs.
        count = (
            sum(mask.bit_count() for _, some in found for mask in some.values()) // 2
        )
        strongest = heapq.nsmallest(
            PAIRS_TOLD, (one for p, some in found for one in _first_pairs(p, some))
        )
        told = [tell(kind, logs, first, second) for _, first, second in strongest]
        told += (
            [f"and {count - PAIRS_TOLD} more like these"] if count > PAIRS_TOLD else []
        )
        students = tuple(logs.keys[log] for log in members[group] if log < logs.current)
        p, previous = (
            strongest[0][0],
            tuple(logs.keys[log] for log in members[group] if log >= logs.current),
        )
        flags.append(Flag(kind, students, "; ".join(told), p, p * logs.pairs, previous))
    return flags


def _not_joined(pairs: Pairs, logs: Logs, before: Iterable[Flag]) -> Links:
    """Return the logs that each log of some pairs is compared with.

    Logs that an earlier flag joins to it are left out.
    """
    number = {key: log for log, key in enumerate(logs.keys)}
    tables = {table for pair in pairs for table in pair}
    free = {
        log: logs.compared_with(log) for table in tables for log in logs.members[table]
    }
    for flag in before:
        joined = {number[key] for key in (*flag.students, *flag.previous)}
        others = ~mask_of(joined)
        for log in joined & free.keys():
            free[log] &= others
    return free


def _links_of(pair: tuple[int, int], logs: Logs, free: Links) -> Links:
    """Return the pairs of logs with two tables, from both sides."""
    one, other = (logs.members[table] for table in pair)
    sides = [(one, mask_of(other)), (other, mask_of(one))]
    links = {log: free[log] & mask for some, mask in sides for log in some}
    return {log: mask for log, mask in links.items() if mask}


def _groups_of(links: Iterable[Links]) -> dict[int, int]:
    """Return the first log of the group of each log: all that are connected."""
    every: Links = {}
    for some in links:
        for log, mask in some.items():
            every[log] = every.get(log, 0) | mask
    group_of: dict[int, int] = {}
    for head in sorted(every):
        if head in group_of:
            continue
        group, new = 0, 1 << head
        while new:
            group |= new
            near = 0
            for log in logs_of(new):
                near |= every[log]
            new = near & ~group
        group_of |= dict.fromkeys(logs_of(group), head)
    return group_of


def _first_pairs(p: float, links: Links) -> Iterator[tuple[float, int, int]]:
    """Give the first pairs of some links, as many as are told."""
    pairs = (
        (p, log, other)
        for log, mask in links.items()
        for other in logs_of(mask)
        if log < other
    )
    return islice(pairs, PAIRS_TOLD)


def tell(kind: Kind, logs: Logs, first: int, second: int) -> str:
    """Describe what two logs have in common, with the lines in both files."""
    (one, mine), (other, theirs) = (
        (logs.prints[log], logs.keys[log]) for log in (first, second)
    )
    rows, others = logs.rows_of(first), logs.rows_of(second)
    if kind == "similar spins":
        ratios = (
            logs.spin[rows] / logs.spin[others],
            logs.period[rows] / logs.period[others],
        )
        spin, period = (
            f"{100 * math.sqrt(np.mean(np.log(ratio) ** 2)):.2g} %" for ratio in ratios
        )
        told = (
            f"the {len(rows)} spins of {mine} and {theirs} differ by {spin} (root mean "
            f"square, in the order of"
        )
        told += f" weight and spin), and their precession periods by {period}"
        return f"{told}; the spins of other logs differ much more"
    row, column = rows[:, None], others[None, :]
    same = _same_weight(logs.torque[row], logs.torque[column]) & logs.same(
        "spin", row, column
    )
    same &= logs.same("period", row, column) | (kind == "same spins")
    matched: dict[int, int] = {}
    for i, j in np.argwhere(same).tolist():
        if i not in matched and j not in matched.values():
            matched[i] = j
    at, at_other = list(matched), list(matched.values())
    lines, other_lines = np.array(one.lines)[at], np.array(other.lines)[at_other]
    numbers, other_numbers = (
        ", ".join(map(str, sorted(some))) for some in (lines, other_lines)
    )
    common, mine = (
        f"{len(at)} of {min(len(rows), len(others))}",
        f"{mine} (lines {numbers})",
    )
    rows, others = rows[at], others[at_other]
    if kind == "same spins":
        apart = np.max(
            np.abs(logs.period[rows] - logs.period[others]) * np.array(one.turns)[at]
        )
        told = f"{common} spins of {mine} are those of {theirs} at the same weights"
        return f"{told}; the times beside them differ by {apart:.2g} s at most"
    told = f"{common} rows of {mine} are in {theirs} (lines {other_numbers})"
    told += ", with the same spin and the same precession period"
    told += (
        ", the files are the same byte for byte" if one.sha256 == other.sha256 else ""
    )
    told += (
        ", in another order"
        if np.any(np.argsort(lines) != np.argsort(other_lines))
        else ""
    )
    steps = logs.period_step[[rows, others]]
    return told + (
        ", not typed to the same digit"
        if np.any(steps.max(axis=0) > 1.5 * steps.min(axis=0))
        else ""
    )
