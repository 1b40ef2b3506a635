"""Find logs that look copied or invented; a flag is a question to a person.

A fingerprint of each log is kept, and all logs are compared at once (`flag_class`):

* rows in common, or their spins alone, in any order, unit and rounding;
* spins that are much closer than those of other logs, whatever the times are;
* scatter below what a hand can do.

Every threshold follows from one number, `ALLOWED`: the expected number of flags of one
kind in a class of honest students. Each flag contains the number of equally strong
flags that are expected by chance.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal, NamedTuple, get_args

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.measurements import Measurements, spin_columns
from gyrodata.physics import RPM, Floats, Integers
from gyrodata.readings import Column, Readings
from gyrodata.readings.lablog import split_lines
from gyrodata.readings.roles import TIMINGS
from gyrodata.readings.writing import SIMULATED

Kind = Literal["shared rows", "similar spins", "scatter", "simulated"]

KINDS: tuple[Kind, ...] = get_args(Kind)
"""All kinds, in the order in which they are listed."""

ALLOWED = 0.05
"""Largest expected number of flags of one kind in a class of honest students; the
thresholds follow from it."""

LEAST = 1e-300  # smallest probability, so that none is zero

Prints = Mapping[str, "Fingerprint"]
"""Logs by their keys."""
NOTHING: Prints = {}


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
    prints: Prints,
    partners: Sequence[frozenset[str]] = (),
    previous: Prints = NOTHING,
    examples: Prints = NOTHING,
) -> tuple[Flag, ...]:
    """Compare the logs of a class, and return the flags by kind.

    The flags are in the order of `KINDS`, then in the order of students.

    `prints`: One log of each student, by the student's key. `partners`: Students who
    hand in the same data; a student may be in several groups. `previous`, `examples`:
    Earlier logs and published examples, by keys of their own; they are compared with
    the logs of the class, not with each other. Examples are no honest logs, and must
    not change which spins are similar. Logs that are joined by one kind are not joined again by
    the next kind, and many copies of one log are one flag.
    """
    logs = Logs(prints, partners, {**previous, **examples})
    flags = flag_scatter(logs)
    flags += flag_pairs("shared rows", shared(logs), logs)
    honest = Logs(prints, partners, previous)
    pairs = _not_joined(similar(honest), honest, flags)
    flags += flag_pairs("similar spins", pairs, honest)
    pairs = _not_joined(shared(honest, by_spin=True), honest, flags)
    return in_order([*flags, *flag_pairs("shared rows", pairs, honest)])


def in_order(flags: Iterable[Flag]) -> tuple[Flag, ...]:
    """Sort flags by kind, in the order of `KINDS`, then by students."""
    return tuple(sorted(flags, key=_place))


def _place(flag: Flag) -> tuple[int, tuple[str, ...], tuple[str, ...]]:
    """Return what sorts a flag."""
    return KINDS.index(flag.kind), flag.students, flag.previous


# --- the fingerprint of a log ---

WEIGHED_AGAIN, NEXT_WEIGHT = 0.015, 0.05
"""Torques that differ by less than the first share are of one weight. Torques that differ
by more than the second are of two weights, even if each number was changed a little."""

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
    columns = readings.columns
    timing = next(columns[role] for role in TIMINGS if role in columns)
    torque = _rounded(measured.torque, 9)
    # Rows with equal torque and spin keep the order of the file: sorted times would
    # look alike by themselves.
    order = np.lexsort((torque, measured.spin, weights(torque, NEXT_WEIGHT)))
    if len(order) > MOST_ROWS:
        shortest = np.argsort(measured.time, kind="stable")[:MOST_ROWS]
        order = order[np.isin(order, shortest)]
    steps = [_relative_step(column) for column in spin_columns(readings)]
    spin_step = measured.spin * np.max(steps, axis=0)
    rows = {
        "torque": torque,
        "spin": measured.spin,
        "time": measured.time,
        "turns": measured.turns,
        "spin_step": spin_step,
        "time_step": measured.time * _relative_step(timing),
    }
    # Ten digits are more than anyone types, and short in a journal.
    kept = {}
    for name, values in rows.items():
        kept[name] = tuple(_rounded(values[order], 10).tolist())
    lines = tuple([measured.lines[i] for i in order.tolist()])
    return Fingerprint(
        sha256=readings.sha256,
        by_hand=timing.role == "time",
        lines=lines,
        simulated=_simulated(readings),
        **kept,
    )


def _rounded(values: Floats, digits: int) -> Floats:
    """Round values to a number of significant digits."""
    return np.array([float(f"{value:.{digits}g}") for value in values.tolist()])


def _simulated(readings: Readings) -> int:
    """Return the line that says, in any words, that a log is simulated, or 0."""
    for number, line in enumerate(split_lines(readings.source_text), 1):
        if _says_simulated(line):
            return number
    return 0


_SIMULATED = re.compile(r"\b(?:simulated|simuliert\w*|simulad[oa]s?|simulat[oaie])\b")


def _says_simulated(line: str) -> bool:
    """Return whether a remark says that its log is simulated, not measured."""
    words = _words_of(line)
    is_remark = line.lstrip(' "').startswith(("#", "%"))
    if _words_of(SIMULATED) in words or "gyro simulate" in words:
        return True
    if not is_remark or not _SIMULATED.search(words) or "not simulated" in words:
        return False
    if "measured" not in words:
        return True
    return re.search(r"(?:not|never) (?:\w+ )?measured", words) is not None


def _words_of(text: str) -> str:
    return " ".join(re.findall("[a-z]+", text.lower()))


def weights(torque: Floats, apart: float = WEIGHED_AGAIN) -> Integers:
    """Return the number of the weight of each row, in the order of torque.

    Torques that differ by less than the share `apart` are of one weight, which was
    weighed again: 0.0294, 0.0588 and 0.0295 N·m are the numbers 0, 1 and 0.
    """
    sizes = np.array(sorted(set(torque.tolist())))
    larger = sizes[1:]
    is_other = np.diff(sizes) > apart * np.abs(larger)
    return np.searchsorted(larger[is_other], torque, side="right")


def _relative_step(column: Column) -> Floats:
    """Return one step of the last digit over the value, shape (n,).

    This ratio is the same for a period and its rate.
    """
    steps = np.zeros(len(column.readings))
    for at, read in enumerate(column.readings):
        if read.step and read.value:
            steps[at] = read.step / abs(read.value)
    return steps


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
    time = np.array(log.time)
    lever = np.array(log.turns) * np.array(log.spin)
    torque = np.array(log.torque)
    weight = weights(torque)
    lever = lever / np.where(torque == 0, 1.0, np.abs(torque))
    slopes = [lever * (weight == number) for number in dict.fromkeys(weight.tolist())]
    design = np.column_stack([*slopes, np.ones(len(time))])
    design /= np.linalg.norm(design, axis=0)
    solution, _, rank, _ = np.linalg.lstsq(design, time, rcond=1e-9)
    fitted = design @ solution
    left = time - fitted
    dof = len(time) - int(rank)
    variance = left @ left / max(dof, 1)
    of_rounding = np.mean(np.square(log.time_step)) / 12
    return dof, math.sqrt(variance + of_rounding)


class Logs:
    """N logs: those of the class in the order of their keys, and then the earlier logs.

    They have R rows in total. `partners`: Students whose logs may be alike. `previous`:
    Earlier logs.
    """

    def __init__(
        self, prints: Prints, partners: Iterable[frozenset[str]], previous: Prints
    ) -> None:
        students = sorted(prints)
        earlier = sorted(previous)
        self.current = len(students)  # number of logs of this class
        self.keys = [*students, *earlier]
        self.prints = [prints[key] for key in students]
        self.prints += [previous[key] for key in earlier]
        number = {key: log for log, key in enumerate(students)}
        self.partners = []
        for group in partners:
            members = number.keys() & group
            self.partners.append({number[key] for key in members})
        self.pairs = self._count_pairs()
        counts = [len(fingerprint.time) for fingerprint in self.prints]
        # First row of each log, shape (N + 1,), and log of each row, shape (R,).
        self.starts = np.concatenate([[0], np.cumsum(counts)]).astype(int)
        self.log = np.repeat(np.arange(len(counts)), counts)
        turns = self._rows("turns")
        self.torque = np.abs(self._rows("torque"))  # [N*m], shape (R,)
        self.spin = self._rows("spin")  # [rad/s], shape (R,)
        self.spin_step = self._rows("spin_step")  # [rad/s], shape (R,)
        self.period = self._rows("time") / turns  # [s], shape (R,)
        self.period_step = self._rows("time_step") / turns  # [s], shape (R,)
        grids = [_grid(fingerprint) for fingerprint in self.prints]
        self.grid = np.repeat(grids, counts)  # [rad/s], shape (R,)
        # Rows in the order of their spins, shape (R,).
        self.order = np.argsort(self.spin, kind="stable")
        self.scatters = [measure_scatter(fingerprint) for fingerprint in self.prints]
        self.noise = self._noise(counts) / turns  # of a period [s], shape (R,)
        self.useful = self._useful()

    def _partners_of(self, log: int) -> list[int]:
        """Return the logs that a log may be like."""
        groups = [group for group in self.partners if log in group]
        return sorted(set[int]().union(*groups) - {log})

    def _count_pairs(self) -> int:
        """Count the pairs to compare: within the class, and with the earlier logs."""
        earlier = len(self.keys) - self.current
        in_class = self.current * (self.current - 1) // 2
        every = in_class + self.current * earlier
        logs = set[int]().union(*self.partners)
        twice = sum(len(self._partners_of(log)) for log in logs)
        return every - twice // 2

    def _rows(self, name: str) -> Floats:
        values = [
            value for fingerprint in self.prints for value in getattr(fingerprint, name)
        ]
        return np.array(values, dtype=float)

    def _noise(self, counts: list[int]) -> Floats:
        """Return the standard deviation of the time of each row [s], shape (R,).

        A log that scatters more than most may contain a systematic error, which two
        logs can share: then the median of all logs is used.
        """
        sizes = [size for _, size in self.scatters]
        usual = np.minimum(sizes, np.median(sizes or [0.0]))
        hands = [HAND * fingerprint.by_hand for fingerprint in self.prints]
        return np.repeat(np.maximum(usual, hands), counts)

    def _useful(self) -> NDArray[np.bool_]:
        """Return the rows whose spin is not round, each spin once per weight."""
        off = np.abs(self.spin - ROUND * np.round(self.spin / ROUND))
        useful: NDArray[np.bool_] = off > 0.5 * self.spin_step + _EXACT * self.spin
        is_new = np.diff(self.log) != 0
        is_new |= np.diff(self.torque) != 0
        is_new |= np.diff(self.spin) != 0
        useful[1:] &= is_new
        return useful

    def are_compared(self, log: int, others: Integers) -> NDArray[np.bool_]:
        """Return which other logs a log is compared with: not two earlier ones."""
        are_partners = np.isin(others, self._partners_of(log))
        compared: NDArray[np.bool_] = (others != log) & ~are_partners
        if log >= self.current:
            compared &= others < self.current
        return compared

    def rows_of(self, log: int) -> Integers:
        """Return the numbers of the n rows of a log, shape (n,)."""
        return np.arange(self.starts[log], self.starts[log + 1])

    def same(self, name: str, row: Integers, other: Integers) -> NDArray[np.bool_]:
        """Return which rows have the same "spin" or "period".

        Two values are compared to the last digit of the coarser value.
        """
        values = getattr(self, name)
        steps = getattr(self, f"{name}_step")
        return _same_number(values[row], values[other], steps[row], steps[other])

    def near(self, log: int) -> Matches:
        """Match the rows of a log with the rows of others with their weight and spin.

        Spins are compared to the step of the tachometer.
        """
        rows = self.rows_of(log)
        spin = self.spin[rows]
        reach = 0.5 * np.maximum(self.grid[rows], np.max(self.spin_step))
        reach += 2 * _EXACT * spin
        low = np.searchsorted(self.spin, spin - reach, sorter=self.order)
        high = np.searchsorted(self.spin, spin + reach, "right", sorter=self.order)
        mine = np.repeat(rows, high - low)
        parts = [self.order[a:b] for a, b in zip(low, high, strict=True)]
        other = np.concatenate(parts)
        same = self.log[other] != log
        same &= _same_weight(self.torque[mine], self.torque[other])
        same &= _same_number(
            self.spin[mine], self.spin[other], self.grid[mine], self.spin_step[other]
        )
        mine = mine[same]
        other = other[same]
        others, at = np.unique(self.log[other], return_inverse=True)
        return Matches(rows, mine, other, others, at)


class Matches(NamedTuple):
    """Pairs of rows, of a log with n rows and of K others."""

    rows: Integers  # of the log, shape (n,)
    mine: Integers  # the row of the log, of each pair
    other: Integers  # the row of another log, of each pair
    others: Integers  # the other logs, shape (K,)
    at: Integers  # the number of the other log among them, of each pair

    def have(self, which: NDArray[np.bool_] | slice) -> NDArray[np.bool_]:
        """Return which of the K logs has which row, shape (K, n), by some pairs."""
        is_there = np.zeros((len(self.others), len(self.rows)), dtype=bool)
        is_there[self.at[which], self.mine[which] - self.rows[0]] = True
        return is_there


def _grid(log: Fingerprint) -> float:
    """Return the step of the tachometer [rad/s].

    It is the largest step with which all spins of a log agree.
    """
    spin = np.array(log.spin)
    off = np.abs(spin - GRIDS * np.round(spin / GRIDS))
    agree = (off <= 1e-6 * spin).all(axis=1)
    return float(max([*log.spin_step, *GRIDS[agree, 0]]))


# --- one log by itself: scatter below what a hand can do ---


def flag_scatter(logs: Logs) -> list[Flag]:
    """Find logs whose times are closer to straight lines than a hand can stop them."""
    from scipy.special import chdtr

    timed = []
    students = zip(logs.keys[: logs.current], logs.prints, logs.scatters, strict=False)
    for key, log, (dof, size) in students:
        if log.by_hand and dof > 0:
            timed.append((key, log, dof, size))
    flags = []
    for key, log, dof, size in timed:
        # A scatter as large as that of a good hand, or larger, is never rare.
        p = 1.0
        if size < HAND:
            chi2 = dof * (size / HAND) ** 2
            p = float(chdtr(dof, chi2))
        if p * len(timed) <= ALLOWED:
            evidence = (
                f"its {len(log.time)} times are within {size:.2g} s of straight lines "
                f"in the spin, one for each torque ({dof} degrees of freedom); a hand "
                f"on a stopwatch scatters by {HAND:g} s or more"
            )
            flags.append(Flag("scatter", (key,), evidence, p, p * len(timed)))
    return flags


# --- rows that two logs share ---
#
# The question is how often two honest logs would agree as much as two given logs do.
# For each row of a log there is the probability that another log has the same row: the
# share of the logs with its spin at its weight (round spins do not count, because many
# students aim at them), times the probability of the same period. Two people who time
# the same spin seldom stop at the same hundredth of a second; the probability follows
# from the scatter of a hand and from the last digit.
#
# The number of rows that agree by chance then has the distribution of a sum of
# independent events. Each pair is judged from both of its logs, and the larger
# probability counts.

SAME_TORQUE = 0.1
"""Rows are compared if their torques differ by less than this share: each station has
weights of its own."""

FEWEST = 3  # a pair is flagged from this number of rows on
MOST_LIKE = (
    2  # logs with the spins of a log; if there are more, the bench has few spins
)

_WIDTH = math.sqrt(4 * math.pi)
"""No interval of this width contains more of a normal distribution [sigma]."""


class Pairs(NamedTuple):
    """Logs that are too similar, and the probability of this in two honest logs."""

    first: Integers  # numbers of logs, shape (m,)
    second: Integers  # shape (m,), each larger than that of `first`
    p: Floats  # shape (m,)

    def some(self, which: NDArray[np.bool_] | Integers) -> Pairs:
        """Return some of the pairs."""
        return Pairs(self.first[which], self.second[which], self.p[which])


def shared(logs: Logs, by_spin: bool = False) -> Pairs:
    """Find the pairs of logs with more rows in common than expected by chance.

    `by_spin`: Rows have the same spin, whatever their times are. Then logs that are
    like several others do not count: a bench may have a few spins only.
    """
    count = len(logs.keys)
    numbers = [np.zeros(0, dtype=int)]
    chances = [np.zeros(0)]
    for log in range(count):
        other, p = _shared_with(logs, log, by_spin)
        rare = p * logs.pairs <= (NEAR_ALLOWED if by_spin else ALLOWED)
        if by_spin and rare.sum() > MOST_LIKE:
            continue
        number = np.minimum(log, other) * count + np.maximum(log, other)
        numbers.append(number[rare])
        chances.append(p[rare])
    number = np.concatenate(numbers)
    p = np.concatenate(chances)
    # Each pair is there from both of its logs, or it is not rare enough.
    order = np.argsort(number, kind="stable")
    twice = np.flatnonzero(np.diff(number[order]) == 0)
    at = order[twice]
    behind = order[twice + 1]
    first, second = np.divmod(number[at], count)
    return Pairs(first, second, np.maximum(p[at], p[behind]))


def _shared_with(logs: Logs, log: int, by_spin: bool) -> tuple[Integers, Floats]:
    """Return the logs with rows of a log, and how probable so many are by chance."""
    match = logs.near(log)
    rows = match.rows
    mine = match.mine
    other = match.other
    same = logs.same("spin", mine, other)
    # Many students aim at round spins; they may have the same time.
    same &= logs.useful[mine] if by_spin else logs.same("period", mine, other)
    count = match.have(same).sum(axis=1)
    enough = (count >= FEWEST) & logs.are_compared(log, match.others)
    if not enough.any():
        return np.zeros(0, dtype=int), np.zeros(0)
    # A value that n logs have is seen in the other log of a pair in n of N cases.
    common = (1 + match.have(slice(None)).sum(axis=0)) / len(logs.keys)
    common[~logs.useful[rows]] = 0.0 if by_spin else 1.0
    periods = 1.0 if by_spin else _period_chances(logs, rows)
    tails = _rare_events(common * periods)
    return match.others[enough], tails[count[enough]]


def _period_chances(logs: Logs, rows: Integers) -> Floats:
    """Return the probability that another log has the periods of rows, shape (n,)."""
    step = logs.period_step[rows] + 2 * _EXACT * logs.period[rows]
    return np.asarray(step / np.maximum(_WIDTH * logs.noise[rows], step))


def _rare_events(chances: Floats) -> Floats:
    """Return the probability that k or more of n events occur, shape (n + 1,)."""
    numbers: Floats = np.eye(1, len(chances) + 1)[0]
    for chance in chances.tolist():
        more = chance * numbers[:-1]
        numbers *= 1 - chance
        numbers[1:] += more
    return numbers[::-1].cumsum()[::-1].clip(LEAST)


def _same_number(
    number: Floats, other: Floats, step: Floats, other_step: Floats
) -> NDArray[np.bool_]:
    """Return which numbers are the same to the last digit of the coarser one."""
    coarser = np.maximum(step, other_step)
    return np.abs(number - other) <= 0.5 * coarser + _EXACT * number


def _same_weight(torque: Floats, other: Floats) -> NDArray[np.bool_]:
    return np.abs(torque - other) <= SAME_TORQUE * np.maximum(torque, other)


# --- logs with similar spins: copies in which every number was changed a little ---

# the density of honest logs around a log follows from the distance of this neighbour
NEIGHBOURS = 5

# smaller than `ALLOWED`, because the density of honest logs is only estimated
NEAR_ALLOWED = 0.005

NEAR_LOGS = 2000  # in a larger class, honest logs are as close as changed copies

NEAR_SPINS = 0.04  # largest relative difference of the spins, root mean square

NEAR_ROWS = 6  # number of spins, not counting round ones, that two logs must have


def similar(logs: Logs) -> Pairs:
    """Find pairs of logs whose spins are much closer than those of other logs.

    Logs with the same number of runs at each weight are compared in the order of weight
    and spin. The distance is the mean square of the relative differences, with the
    variance of rounding: so copies are found if the spins are written to 1 rpm, but not
    to 10 rpm. Spins that differ by `NEAR_SPINS` or more are not those of a copy. In n
    dimensions, a distance d that is smaller than a usual distance D has the probability
    (d/D)^n. The usual distance is the smallest of these: from the log to its fifth
    neighbour; from most logs of the class to their second neighbour, because the first
    may be a copy; from the log to the middle of the class.
    """
    pairs: list[tuple[int, int, float]] = []
    by_pattern: dict[tuple[int, ...], list[int]] = {}
    for log, fingerprint in enumerate(logs.prints):
        torque = np.array(fingerprint.torque)
        pattern = tuple(weights(torque, NEXT_WEIGHT).tolist())
        by_pattern.setdefault(pattern, []).append(log)
    for pattern, members in by_pattern.items():
        if len(pattern) < NEAR_ROWS or not NEIGHBOURS < len(members) <= NEAR_LOGS:
            continue
        rows = logs.starts[members][:, None] + np.arange(len(pattern))
        chance = _chances_of_distances(logs, rows)
        for at, other in np.argwhere(chance * logs.pairs <= NEAR_ALLOWED).tolist():
            log = members[at]
            partner = members[other]
            if log < partner and logs.are_compared(log, np.array([partner]))[0]:
                pairs.append((log, partner, float(chance[at, other])))
    columns = np.array(pairs, dtype=float).reshape(-1, 3).T
    return Pairs(columns[0].astype(int), columns[1].astype(int), columns[2])


def _chances_of_distances(logs: Logs, rows: Integers) -> Floats:
    """Return the probability that honest logs are as close as each two, shape (m, m).

    `rows`: The rows of the m logs, shape (m, n).
    """
    spin = np.log(logs.spin[rows])
    spin -= np.median(spin, axis=0)
    size = spin**2 + (logs.grid[rows] / logs.spin[rows]) ** 2 / 12
    counts = logs.useful[rows].astype(float)
    number = counts @ counts.T
    # The sum of (a - b)² over the spins that count in both logs.
    square = (counts * size) @ counts.T
    square = square + square.T - 2 * (counts * spin) @ (counts * spin).T
    square = np.abs(square) / np.maximum(number, 1)
    square[(number < NEAR_ROWS) | np.eye(len(rows), dtype=bool)] = np.inf
    few = np.partition(square, NEIGHBOURS, axis=1)[:, :NEIGHBOURS]
    nearest = np.sort(few, axis=1)
    # Logs with equal spins say nothing of the distance of honest ones.
    second = nearest[:, 1]
    apart = second[second > 0]
    middle = np.minimum(2 * np.mean(size, axis=1), np.median([*apart, np.inf]))
    usual = np.minimum(nearest[:, NEIGHBOURS - 1], middle)[:, None]
    chance = np.ones_like(square)
    # If many logs have equal spins, the course asked for them.
    near = (square < NEAR_SPINS**2) & (usual > 0)
    np.divide(square, usual, out=chance, where=near)
    chance = np.where(near, NEIGHBOURS * chance ** (number / 2), 1.0)
    return np.asarray(np.maximum(np.maximum(chance, chance.T) / len(rows), LEAST))


# --- flags of logs that are too similar ---

PAIRS_TOLD = 3  # number of pairs of a group whose evidence is written


def _not_joined(pairs: Pairs, logs: Logs, flags: Iterable[Flag]) -> Pairs:
    """Leave out the pairs of logs that an earlier flag joins already."""
    number = {key: log for log, key in enumerate(logs.keys)}
    joined = -np.arange(1, len(logs.keys) + 1)
    for at, flag in enumerate(flags):
        keys = (*flag.students, *flag.previous)
        joined[[number[key] for key in keys if key in number]] = at
    return pairs.some(joined[pairs.first] != joined[pairs.second])


def flag_pairs(kind: Kind, pairs: Pairs, logs: Logs) -> list[Flag]:
    """Make one flag of all pairs that are connected.

    For example, five copies of one log are one finding, not ten.
    """
    if not len(pairs.p):
        return []
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = np.ones(len(pairs.p)), (pairs.first, pairs.second)
    graph = coo_array(links, shape=(len(logs.keys), len(logs.keys)))
    _, group_of = connected_components(graph, directed=False)
    group = group_of[pairs.first]
    return [
        _flag_of(kind, pairs.some(group == number), logs) for number in np.unique(group)
    ]


def _flag_of(kind: Kind, pairs: Pairs, logs: Logs) -> Flag:
    """Make the flag of connected pairs, with the evidence of the strongest ones."""
    strongest = pairs.some(np.lexsort((pairs.second, pairs.first, pairs.p)))
    tell = _tell_rows if kind == "shared rows" else _tell_spins
    shown = strongest.some(np.arange(len(pairs.p)) < PAIRS_TOLD)
    both = zip(shown.first.tolist(), shown.second.tolist(), strict=True)
    evidence = [tell(logs, first, second) for first, second in both]
    if len(pairs.p) > PAIRS_TOLD:
        evidence.append(f"and {len(pairs.p) - PAIRS_TOLD} more like these")
    members = np.unique([pairs.first, pairs.second]).tolist()
    students = tuple(logs.keys[log] for log in members if log < logs.current)
    previous = tuple(logs.keys[log] for log in members if log >= logs.current)
    p = float(strongest.p[0])
    return Flag(kind, students, "; ".join(evidence), p, p * logs.pairs, previous)


def _tell_spins(logs: Logs, first: int, second: int) -> str:
    """Describe how similar the spins of two logs are."""
    rows = logs.rows_of(first)
    others = logs.rows_of(second)
    spin = _difference(logs.spin[rows], logs.spin[others])
    period = _difference(logs.period[rows], logs.period[others])
    return (
        f"the {len(rows)} spins of {logs.keys[first]} and {logs.keys[second]} differ "
        f"by {spin} (root mean square, in the order of weight and spin), and their "
        f"precession periods by {period}; the spins of other logs differ much more"
    )


def _difference(values: Floats, others: Floats) -> str:
    """Write the relative difference of two series, root mean square."""
    relative = np.log(values / others)
    percent = 100 * math.sqrt(np.mean(relative**2))
    return f"{percent:.2g} %"


def _tell_rows(logs: Logs, first: int, second: int) -> str:
    """Describe the rows that two logs share, with their lines in both files."""
    rows = logs.rows_of(first)[:, None]
    others = logs.rows_of(second)[None, :]
    same = _same_weight(logs.torque[rows], logs.torque[others])
    same &= logs.same("spin", rows, others)
    timed = same & logs.same("period", rows, others)
    words = "with the same spin"
    if timed.any(axis=1).sum() >= FEWEST:
        same = timed
        words += " and the same precession period"
    shared_rows = np.flatnonzero(same.any(axis=1))
    lines = _lines_in_words(logs.prints[first], shared_rows)
    shared_by_other = np.flatnonzero(same.any(axis=0))
    other_lines = _lines_in_words(logs.prints[second], shared_by_other)
    return (
        f"{len(shared_rows)} of {min(same.shape)} rows of {logs.keys[first]} "
        f"({lines}) are in {logs.keys[second]} ({other_lines}), {words}"
    )


def _lines_in_words(log: Fingerprint, which: Integers) -> str:
    """Name the lines of some rows of a log."""
    lines = sorted(np.array(log.lines)[which].tolist())
    return f"lines {', '.join(map(str, lines))}"
