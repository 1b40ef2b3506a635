"""Find logs that look copied or invented: flags are questions to a person, never verdicts.

A fingerprint of each log is kept, and all logs are compared at once (`flag_class`):

* rows in common, in any order, unit and rounding;
* the same spins at the same weights, whatever the times are, or spins that are much closer than those of other logs;
* scatter below what a hand can do.

Every threshold follows from one number, `ALLOWED`: the expected number of flags of one kind in a class of honest
students. Each flag contains the number of equally strong flags that are expected by chance.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Iterable, Mapping
from itertools import permutations
from typing import Literal, NamedTuple, get_args

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.fitting import chi2_lower_tail
from gyrodata.measurements import Measurements, spin_columns
from gyrodata.physics import RPM, Floats, Integers
from gyrodata.readings import Column, Readings
from gyrodata.readings.roles import TIMINGS

Kind = Literal["shared rows", "same spins", "similar spins", "scatter"]

KINDS: tuple[Kind, ...] = get_args(Kind)
"""All kinds, in the order in which they are listed."""

ALLOWED = 0.05
"""Largest expected number of flags of one kind in a class of honest students; the thresholds follow from it."""

LEAST = 1e-300  # smallest probability, so that none is zero


class Flag(Struct, frozen=True):
    """A finding, and how often it occurs among honest students."""

    kind: Kind
    students: tuple[str, ...]  # their keys, sorted
    evidence: str  # in words, with the numbers
    p: float
    """Probability of this or more in one honest log, or between two; of the strongest pair if there are several."""
    expected: float  # number of equally strong or stronger flags that is expected in an honest class of this size
    previous: tuple[str, ...] = ()  # keys of earlier logs in it, sorted
    pairs: tuple[tuple[str, str], ...] = ()  # pairs that join all logs, the strongest first


def flag_class(
    prints: Mapping[str, Fingerprint],
    partners: Iterable[frozenset[str]] = (),
    previous: Mapping[str, Fingerprint] = {},
) -> tuple[Flag, ...]:
    """Compare the logs of a class, and return the flags by kind, in the order of `KINDS`, then by students.

    `prints`: One log of each student, by the student's key. `partners`: Students who hand in the same data; a student
    may be in several groups. `previous`: Earlier logs and published examples, by keys of their own; they are compared
    with the logs of the class, not with each other. Logs that are joined by one kind are not joined again by the next
    kind, and many copies of one log are one flag.
    """
    logs = Logs(prints, partners, previous)
    flags = flag_scatter(logs) + (flag_copies(logs) if logs.pairs > 0 else [])
    return tuple(sorted(flags, key=lambda flag: (KINDS.index(flag.kind), flag.students, flag.previous)))


# --- the fingerprint of a log --------------------------------------------------------------------------------

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
        own: dict[int, float] = {}
        for at, (one, scatter) in enumerate(zip(self.prints, self.scatters, strict=True)):
            if scatter is not None and scatter.dof >= TRUSTED_DOF:
                rows = zip(one.time, one.spin, one.spin_step, strict=True)
                from_spin = [t**2 * (TACHOMETER**2 + (step / spin) ** 2 / 12) for t, spin, step in rows]
                own[at] = math.sqrt(max(scatter.squares / scatter.dof - statistics.median(from_spin), 0.0))
        middle = statistics.median(own.values()) if own else 0.0
        least = [HAND if one.by_hand else 0.0 for one in self.prints]
        return np.array([max(min(own.get(at, 0.0), middle), hand) for at, hand in enumerate(least)])


# --- pairs of logs that are too similar ---------------------------------------------------------------------


PAIRS_TOLD = 3  # number of pairs of a group whose evidence is written


def flag_pairs(
    kind: Kind, pairs: Mapping[tuple[int, int], float], logs: Logs, tell: Callable[[Logs, int, int], str]
) -> tuple[list[Flag], list[int]]:
    """Make one flag of all pairs that are connected: five copies of one log are one finding, not ten.

    `pairs`: Probability by the numbers of two logs. Returns the flags, and for each log the number of the log that
    represents its group.
    """
    head = list(range(len(logs.keys)))
    ordered, joining = sorted((p, *pair) for pair, p in pairs.items()), []
    for _, first, second in ordered:
        if head[first] != head[second]:
            joining.append((first, second))
            head = [head[first] if one == head[second] else one for one in head]
    groups: dict[int, list[tuple[float, int, int]]] = {}
    for pair in ordered:
        groups.setdefault(head[pair[1]], []).append(pair)
    flags = []
    for group, found in groups.items():
        members = [log for log, one in enumerate(head) if one == group]
        told = [tell(logs, *pair[1:]) for pair in found[:PAIRS_TOLD]]
        told += [f"and {len(found) - PAIRS_TOLD} more like these"] if len(found) > PAIRS_TOLD else []
        students, previous = (
            tuple(logs.keys[log] for log in members if (log < logs.current) == now) for now in (True, False)
        )
        joined = tuple((logs.keys[one], logs.keys[other]) for one, other in joining if head[one] == group)
        p = found[0][0]
        flags.append(Flag(kind, students, "; ".join(told), p, p * logs.pairs, previous, joined))
    return flags, head


# --- one log by itself: scatter below what a hand can do --------------------------------------------------


def flag_scatter(logs: Logs) -> list[Flag]:
    """Find logs whose times are closer to straight lines than a hand can stop them."""
    flags = []
    both = enumerate(zip(logs.prints[: logs.current], logs.scatters, strict=False))
    timed = [(i, scatter) for i, (log, scatter) in both if log.by_hand and scatter is not None]
    for i, scatter in timed:
        # A scatter as large as that of a good hand, or larger, is never rare.
        p = chi2_lower_tail(scatter.squares / HAND**2, scatter.dof) if scatter.size < HAND else 1.0
        if p * len(timed) <= ALLOWED:
            evidence = (
                f"its {scatter.times} times are within {scatter.size:.2g} s of straight lines in the spin, "
                f"one for each torque ({scatter.dof} degrees of freedom); a hand on a stopwatch scatters by {HAND:g} s "
                "or more"
            )
            flags.append(Flag("scatter", (logs.keys[i],), evidence, p, p * len(timed)))
    return flags


# --- rows and spins that two logs share ----------------------------------------------------------------------
#
# The question is how often two honest logs would agree as much as two given logs do. For each row of a log there are
# two probabilities:
#
# * that another log has the same spin at the same weight: the share of the logs that have it. Round spins do not
#   count, because many students aim at them;
# * that another log also has the same period. Two people who time the same spin seldom stop at the same hundredth of
#   a second; the probability follows from the scatter of a hand and from the last digit.
#
# The number of rows that agree by chance then has the distribution of a sum of independent events. Each pair is
# judged from both of its logs, and the larger probability counts.

SAME_TORQUE = 0.1
"""Rows are compared if their torques differ by less than this share: each station has weights of its own."""

FEWEST = 3  # a pair is flagged from this number of rows on; if only spins agree, from one more

MOST_SPINS = 0.5  # share of the spins of the shorter log that must agree

ROUND = 50 * RPM  # multiples of this are spins that students aim at [rad/s]

HABIT, HABIT_SHARE = 5, 0.02
"""If more logs than both of these, a number and a share of the class, have a set of spins, the course asked for it."""

BLOCK = 32  # logs that are compared at a time, so that a large class needs little memory

_EXACT = 1e-9


def flag_copies(logs: Logs) -> list[Flag]:
    """Find logs that have more rows in common than expected by chance, or otherwise more spins."""
    useful = _useful(logs)
    blocks = np.split(np.arange(len(logs.keys)), range(BLOCK, len(logs.keys), BLOCK))
    found = [_compare(logs, useful, block) for block in blocks]
    rows, spins = (_both_ways(np.concatenate(some, axis=1)) for some in zip(*found, strict=True))
    # The stronger evidence is told.
    rows = {pair: p for pair, p in rows.items() if p <= spins.get(pair, 1.0)}
    flags, joined = flag_pairs("shared rows", rows, logs, _tell_rows)
    spins = {(one, other): p for (one, other), p in spins.items() if joined[one] != joined[other]}
    also, joined_too = flag_pairs("same spins", spins, logs, _tell_spins)
    near = {
        (one, other): p
        for (one, other), p in _near(logs, useful).items()
        if joined[one] != joined[other] and joined_too[one] != joined_too[other]
    }
    return flags + also + flag_pairs("similar spins", near, logs, _tell_near)[0]


def _both_ways(found: Floats) -> dict[tuple[int, int], float]:
    """Return the probability of each pair that is rare from both logs; `found`: log, other log, probability."""
    p = {(int(first), int(second)): one for first, second, one in found.T.tolist()}
    return {(i, j): max(one, p[j, i]) for (i, j), one in p.items() if i < j and (j, i) in p}


def _same_number(one: Floats, other: Floats, step: Floats, other_step: Floats) -> NDArray[np.bool_]:
    """Return which numbers are the same to the last digit of the coarser one."""
    same: NDArray[np.bool_] = np.abs(one - other) <= 0.5 * np.maximum(step, other_step) + _EXACT * one
    return same


def _same_weight(one: Floats, other: Floats) -> NDArray[np.bool_]:
    one, other = np.abs(one), np.abs(other)
    same: NDArray[np.bool_] = np.abs(one - other) <= SAME_TORQUE * np.maximum(one, other)
    return same


def _tails(chances: Floats) -> Floats:
    """Return the probability that k or more of the events in each row occur, shape (N, n + 1), for k from 0 to n."""
    numbers = np.zeros((len(chances), chances.shape[1] + 1))
    numbers[:, 0] = 1.0
    for chance in chances.T[:, :, None]:
        numbers[:, 1:] = numbers[:, 1:] * (1 - chance) + numbers[:, :-1] * chance
        numbers[:, :1] *= 1 - chance
    return np.cumsum(numbers[:, ::-1], axis=1)[:, ::-1]


def _useful(logs: Logs) -> NDArray[np.bool_]:
    """Return which rows have a spin that is not round, each spin once per weight, shape (R,)."""
    useful: NDArray[np.bool_] = np.abs(logs.spin - ROUND * np.round(logs.spin / ROUND)) > (
        0.5 * logs.spin_step + _EXACT * logs.spin
    )
    # Rows are in the order of torque and spin.
    useful[1:] &= (np.diff(logs.log) != 0) | (np.diff(logs.torque) != 0) | (np.diff(logs.spin) != 0)
    return useful


def _rows_with_same_spin(logs: Logs, rows: Integers) -> tuple[Integers, Integers]:
    """Return each row with each row of another log that has its weight and its spin, to the step of the tachometer."""
    spin, by_spin = logs.spin[rows], logs.spin[logs.order]
    reach = 0.5 * np.maximum(logs.grids[rows], np.max(logs.spin_step)) + 2 * _EXACT * spin
    low, high = np.searchsorted(by_spin, spin - reach), np.searchsorted(by_spin, spin + reach, side="right")
    mine, begin = np.repeat(rows, high - low), np.repeat(low - np.cumsum(high - low) + (high - low), high - low)
    other = logs.order[begin + np.arange(len(mine))]
    same = _same_weight(logs.torque[mine], logs.torque[other]) & (logs.log[mine] != logs.log[other])
    same &= _same_number(logs.spin[mine], logs.spin[other], logs.grids[mine], logs.spin_step[other])
    return mine[same], other[same]


def _compare(logs: Logs, useful: NDArray[np.bool_], block: Integers) -> tuple[Floats, Floats]:
    """Compare the logs of a block with all logs; return the pairs with rare rows, and those with rare spins.

    `useful`: As `_useful` returns it. Each pair has three numbers: the log, the
    other log, and the probability that honest logs agree as much.
    """
    number, lengths = len(logs.keys), np.diff(logs.starts)[block]
    rows = np.arange(logs.starts[block[0]], logs.starts[block[-1] + 1])
    mine, other = _rows_with_same_spin(logs, rows)
    spin = _same_number(logs.spin[mine], logs.spin[other], logs.spin_step[mine], logs.spin_step[other])
    period = _same_number(logs.period[mine], logs.period[other], logs.period_step[mine], logs.period_step[other])
    # An entry is a row and another log that has its spin; all entries of two logs are a pair.
    entry, at = np.unique(mine * number + logs.log[other], return_inverse=True)
    row, second = np.divmod(entry, number)
    spin, agree = (np.bincount(at, one, len(entry)) > 0 for one in (spin, spin & period))
    pair, at = np.unique(logs.log[row] * number + second, return_inverse=True)
    first, second = np.divmod(pair, number)
    shared, alike = (np.bincount(at, one, len(pair)).astype(int) for one in (spin & useful[row], agree))

    # A value that n logs have is seen in the other log of a pair in n of N cases.
    row -= rows[0]
    common = (1 + np.bincount(row, minlength=len(rows))) / number
    known = np.add.reduceat(useful, logs.starts[:-1], dtype=int)
    habit = np.bincount(first - block[0], shared > MOST_SPINS * known[first], len(block))
    common[~useful[rows] | (habit > max(HABIT, HABIT_SHARE * number))[logs.log[rows] - block[0]]] = 1.0
    # No interval of this width contains more of a normal distribution.
    step = logs.period_step[rows] + 2 * _EXACT * logs.period[rows]
    chance = step / np.maximum(math.sqrt(4 * math.pi) * logs.noise[rows], step)
    # An example that everybody left in the log is in many logs that are not alike otherwise.
    strangers = agree & (2 * alike < lengths[first - block[0]])[at]
    crowd = np.maximum(np.bincount(row, strangers, len(rows)) - 1, 0) / max(number - 2, 1)

    def tails(chances: Floats) -> Floats:
        table = np.zeros((len(block), int(np.max(lengths))))
        table[logs.log[rows] - block[0], rows - logs.starts[logs.log[rows]]] = chances
        p: Floats = np.maximum(_tails(table)[first - block[0]], LEAST)
        return p

    each = np.arange(len(pair))
    p_rows = tails(np.maximum(common * chance, crowd))[each, alike]
    p_spins = tails(common * useful[rows])[each, shared]
    compared = ((first < logs.current) | (second < logs.current)) & ~np.isin(pair, logs.exempt)
    enough = shared > np.maximum(MOST_SPINS * np.minimum(known[first], known[second]), FEWEST)
    rare = ((compared & (alike >= FEWEST), p_rows), (compared & enough, p_spins))
    rows_found, spins_found = (np.stack([first, second, p])[:, ok & (p <= ALLOWED / logs.pairs)] for ok, p in rare)
    return rows_found, spins_found


# --- logs with similar spins: copies in which every number was changed a little -----------------------------

NEIGHBOURS = 5  # the density of honest logs around a log follows from the distance of this neighbour

NEAR_ALLOWED = 0.01  # smaller than `ALLOWED`, because the density of honest logs is only estimated

NEAR_LOGS = 2000  # in a larger class, honest logs are as close as changed copies

NEAR_ROWS = 6  # number of spins, not counting round ones, that two logs must have


def _near(logs: Logs, useful: NDArray[np.bool_]) -> dict[tuple[int, int], float]:
    """Find pairs of logs with spins that are much closer to each other than those of the next logs.

    Logs with the same number of runs at each weight are compared in the order of weight and spin. The distance is the
    mean square of the relative differences, with the variance of rounding: so copies are found if the spins are written
    to 1 rpm, but not to 10 rpm. In n dimensions, a distance d that is smaller than a usual distance D has the
    probability (d/D)^n. The usual distance is the smallest of these: from the log to its fifth neighbour; from most
    logs of the class to their nearest neighbour; from the log to the middle of the class.
    """
    found: dict[tuple[int, int], float] = {}
    groups: dict[tuple[int, ...], list[int]] = {}
    for log, one in enumerate(logs.prints):
        groups.setdefault(tuple(np.unique(one.torque, return_inverse=True)[1].tolist()), []).append(log)
    for pattern, members in groups.items():
        if len(pattern) < NEAR_ROWS or not NEIGHBOURS < len(members) <= NEAR_LOGS:
            continue
        rows = logs.starts[members][:, None] + np.arange(len(pattern))
        spin, counts = np.log(logs.spin[rows]), useful[rows]
        rounding = (logs.grids[rows] / logs.spin[rows]) ** 2 / 12
        own = 2 * np.mean((spin - np.median(spin, axis=0)) ** 2 + rounding, axis=1)
        number, square = np.zeros((2, len(members), len(members)))
        for count, one, step in zip(counts.T, spin.T, rounding.T, strict=True):
            both = count[:, None] & count
            number += both
            square += both * ((one[:, None] - one) ** 2 + step[:, None] + step)
        square /= np.maximum(number, 1)
        square[(number < NEAR_ROWS) | np.eye(len(members), dtype=bool)] = np.inf
        nearest = np.sort(square, axis=1)
        usual = np.minimum(nearest[:, NEIGHBOURS - 1], np.minimum(own, np.median(nearest[:, 0])))
        chance = np.where(np.isfinite(square), NEIGHBOURS * (square / usual[:, None]) ** (number / 2), 1.0)
        chance = np.maximum(chance, chance.T) / len(members)
        for i, j in np.argwhere(np.triu(chance * logs.pairs <= NEAR_ALLOWED, 1)).tolist():
            found[members[i], members[j]] = max(float(chance[i, j]), LEAST)
    exempt = set(logs.exempt.tolist())
    return {(i, j): p for (i, j), p in found.items() if i < logs.current and i * len(logs.keys) + j not in exempt}


# --- two logs side by side ----------------------------------------------------------------------------------


class Beside(NamedTuple):
    """A row of each of two logs, counted from 0; None if a log has no row left."""

    first: int | None
    second: int | None
    same_spin: bool = False
    same_period: bool = False


def put_beside(first: Fingerprint, second: Fingerprint) -> list[Beside]:
    """Match the rows of two logs, the most similar first, in any order, unit and number of digits."""

    def both(name: str) -> tuple[Floats, Floats]:
        return np.array(getattr(first, name))[:, None], np.array(getattr(second, name))

    turns = both("turns")
    periods, steps = (map(np.divide, both(name), turns) for name in ("time", "time_step"))
    weight = _same_weight(*both("torque"))
    same_spin = weight & _same_number(*both("spin"), *both("spin_step"))
    same_period = weight & _same_number(*periods, *steps)
    likeness = weight + 2 * same_period + 4 * same_spin
    order = np.unravel_index(np.argsort(-likeness, axis=None, kind="stable"), likeness.shape)
    found: dict[int, Beside] = {}
    left = set(range(len(second.spin)))
    for i, j in zip(*(side.tolist() for side in order), strict=True):
        if i not in found and j in left:
            found[i] = Beside(i, j, bool(same_spin[i, j]), bool(same_period[i, j]))
            left.remove(j)
    mine = [found.get(row, Beside(row, None)) for row in range(len(first.spin))]
    return mine + [Beside(None, row) for row in sorted(left)]


def _alike(logs: Logs, first: int, second: int, period: bool) -> tuple[list[tuple[int, int]], str, str]:
    """Return the rows that agree in the spin, or also in the period, and each log's name with their lines."""
    one, other = logs.prints[first], logs.prints[second]
    alike = [
        (row.first, row.second)
        for row in put_beside(one, other)
        if row.first is not None and row.second is not None and row.same_spin and (row.same_period or not period)
    ]
    lines = sorted(one.lines[i] for i, _ in alike), sorted(other.lines[j] for _, j in alike)
    names = [
        f"{logs.keys[log]} (lines {', '.join(map(str, some))})"
        for log, some in zip((first, second), lines, strict=True)
    ]
    return alike, names[0], names[1]


def _tell_rows(logs: Logs, first: int, second: int) -> str:
    """Describe the rows that two logs have in common."""
    alike, mine, theirs = _alike(logs, first, second, period=True)
    one, other = logs.prints[first], logs.prints[second]
    how = ["the files are the same byte for byte"] * (one.sha256 == other.sha256)
    if np.any(np.argsort([one.lines[i] for i, _ in alike]) != np.argsort([other.lines[j] for _, j in alike])):
        how.append("in another order")
    steps = [(one.time_step[i] / one.turns[i], other.time_step[j] / other.turns[j]) for i, j in alike]
    if any(max(pair) > 1.5 * min(pair) for pair in steps):
        how.append("not typed to the same digit")
    common = f"{len(alike)} of {min(len(one.spin), len(other.spin))} rows of {mine} are in {theirs}"
    return ", ".join([f"{common}, with the same spin and the same precession period", *how])


def _tell_spins(logs: Logs, first: int, second: int) -> str:
    """Describe the spins that two logs share, and how their times differ."""
    alike, mine, _ = _alike(logs, first, second, period=False)
    one, other = logs.prints[first], logs.prints[second]
    apart = max(abs(one.time[i] - other.time[j] * one.turns[i] / other.turns[j]) for i, j in alike)
    common = f"{len(alike)} of {min(len(one.spin), len(other.spin))} spins of {mine} are those of {logs.keys[second]}"
    return f"{common} at the same weights; the times beside them differ by {apart:.2g} s at most"


def _tell_near(logs: Logs, first: int, second: int) -> str:
    """Describe how little the spins and the times of two logs differ."""
    one, other = logs.prints[first], logs.prints[second]
    spins, periods = (
        math.sqrt(np.mean(np.square(np.log(np.divide(x, y)))))
        for x, y in ((one.spin, other.spin), (np.divide(one.time, one.turns), np.divide(other.time, other.turns)))
    )
    return (
        f"the {len(one.spin)} spins of {logs.keys[first]} and {logs.keys[second]} differ by {100 * spins:.2g} % "
        f"(root mean square, in the order of weight and spin), and their precession periods by {100 * periods:.2g} %; "
        "the spins of other logs differ much more"
    )
