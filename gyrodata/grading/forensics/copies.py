"""What two logs have in common: rows of the same spin and period, whatever the order, unit and rounding; or spins.

That two rows have the same spin is no sign: a class aims at the same spins, and a station may always give the
same ones. But two hands that time the same spin seldom stop at the same hundredth of a second. So spins (and
torques) only tell which rows *could* agree; how many of those do agree in the period is the evidence, and has a
chance that follows from the scatter of a hand and from the last digit. The chances of all pairs of the class
together then say how many flags honest work makes.

Spins alone are a sign only where they are rarer than a class explains: hit by chance, read to the last digit, at the
same weights, and more than half of all. Whoever changes every time a little seldom thinks of them.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.grading.forensics.flags import ALLOWED, LEAST, Flag, Groups, Pair, flag_pairs
from gyrodata.grading.forensics.logs import Fingerprint, Logs
from gyrodata.physics import RPM, Floats, Integers

SAME_TORQUE = 0.1
"""Relative difference of two torques up to which rows are compared: stations have weights of their own."""

TELLING = 0.5  # a row that would agree by chance more often than this tells nothing and is not counted

FEWEST = 3  # rows in common from which a pair is flagged, however rare

SPINS_TELL = 0.001  # share of pairs below which more spins in common tell no more: a class may have reasons for them

WORK = 5_000_000  # comparisons of rows that the base rate may cost; in a larger class, some logs stand for the others

GOLDEN = 0.6180339887498949

ROUND = 50 * RPM
"""Spins that are a multiple of this are aimed at, or written as if they had been met; they never count [rad/s]."""

GRIDS = tuple(rpm * RPM for rpm in (100, 50, 25, 20, 10, 5, 2))
"""What a tachometer may be read to [rad/s]."""

AROUND = 0.02  # relative distance up to which spins tell how common one between them is

MOST_SPINS = 0.5  # share of the spins of the shorter log that must be in common

HABIT, HABIT_SHARE = 5, 0.02
"""More logs than this, and than this share of the class, that have a set of spins make it a habit of the course."""

BLOCK = 32  # logs that are looked up at a time

LARGE = 3000
"""In a class of more logs, spins are the same by chance so often that only those are counted up that follow on each
other in both logs: with two changed spins of nine, four pairs of neighbours are left."""

_EXACT = 1e-9
_BINS = 20  # per decade, in which the chances of pairs are counted


def flag_shared_rows(rows: Rows, groups: Groups) -> list[Flag]:
    """Find logs that have more rows in common than chance gives."""
    chances = rows.chances()
    pairs = []
    for first, second in rows.candidates(chances, groups):
        alike = rows.compare(first, second)
        expected = chances.expected(alike.compared, alike.p)
        if len(alike.rows) >= FEWEST and expected <= ALLOWED:
            pairs.append(Pair(alike.p, expected, first, second))
            groups.join(first, second)
    return flag_pairs("shared rows", pairs, rows.logs, rows.tell)


def flag_same_spins(rows: Rows, groups: Groups) -> list[Flag]:
    """Find logs that have more spins in common, weight by weight, than chance gives, whatever became of the times."""
    logs = rows.logs
    pairs = []
    for first, second in rows.with_same_spins():
        if groups.joined(first, second):
            continue
        p = max(rows.chance_of_spins(first, second), LEAST)
        if p * logs.pairs <= ALLOWED:
            p = max(p, rows.chance_of_spins(second, first))
        if p * logs.pairs <= ALLOWED and not rows.is_habit(first, second):
            pairs.append(Pair(p, p * logs.pairs, first, second))
    for pair in pairs:
        groups.join(pair.first, pair.second)
    return flag_pairs("same spins", pairs, logs, rows.tell_spins)


def same_number(one: Floats, other: Floats, step: Floats, other_step: Floats) -> NDArray[np.bool_]:
    """Tell which numbers are the same to the last digit of the coarser one."""
    same: NDArray[np.bool_] = np.abs(one - other) <= 0.5 * np.maximum(step, other_step) + _EXACT * one
    return same


def same_weight(one: Floats, other: Floats) -> NDArray[np.bool_]:
    """Tell which torques are near enough for their rows to be compared."""
    same: NDArray[np.bool_] = np.abs(np.abs(one) - np.abs(other)) <= SAME_TORQUE * np.maximum(
        np.abs(one), np.abs(other)
    )
    return same


class Alike(NamedTuple):
    """What two logs have in common."""

    rows: list[tuple[int, int]]  # rows that agree, one of each log; numbers of `Logs`
    compared: int  # rows that could agree
    chance: float  # mean chance that one of them does
    p: float  # chance that as many agree, or more


class Chances:
    """How many pairs of honest logs are as much alike as a given pair, added up over the class.

    Pairs are ranked by the chance that so many of their rows agree, times the share of pairs with as many rows that
    could: many spins in common are rarer in one class than in another.

    `counted`: For each number of rows that could agree and mean chance of one, how many pairs looked at have them.

    Numbers of rows are whole, so a pair reaches few values of its rank, each with a chance of its own, which may be far
    less than that of the pair it is held against (R. E. Tarone, Biometrics 46, 1990, 515).
    """

    def __init__(self, counted: Mapping[tuple[int, float], float], weight: float) -> None:
        self._weight = max(weight, 1.0)
        most = max((compared for compared, _ in counted), default=0)
        number = np.zeros(most + 1)
        for (compared, _), pairs in counted.items():
            number[compared] += pairs
        # One more, for the pair in question, which a sample may have missed.
        self._share = (1 + np.cumsum(number[::-1])[::-1]) / (1 + number.sum())
        steps: list[tuple[float, float]] = []
        for (compared, chance), pairs in counted.items():
            reached = 0.0
            for tail in binomial_tails(compared, chance)[:0:-1]:
                steps.append((tail * self.share(compared), weight * pairs * (tail - reached)))
                reached = tail
        steps.sort()
        self._ranks = np.array([rank for rank, _ in steps])
        self._expected = np.cumsum([more for _, more in steps])
        inside = int(np.searchsorted(self._expected, ALLOWED, side="right"))
        self.last_rank = float(self._ranks[inside]) if inside < len(steps) else 1.0
        """No pair of a higher rank is flagged."""

    def share(self, compared: int) -> float:
        """Give the share of pairs with so many rows that could agree, or more, as far as it tells."""
        return max(float(self._share[min(compared, len(self._share) - 1)]), SPINS_TELL)

    def expected(self, compared: int, p: float) -> float:
        """Give the number of honest pairs that rank no higher, with one more like this in what was not looked at."""
        rank = p * self.share(compared) * (1 + _EXACT)
        inside = int(np.searchsorted(self._ranks, rank, side="right"))
        return (float(self._expected[inside - 1]) if inside else 0.0) + self._weight * p


@lru_cache(maxsize=4096)
def binomial_tails(trials: int, chance: float) -> tuple[float, ...]:
    """Give the chance of k successes or more, for k from 0 to `trials`.

    Gives: Of length ``trials + 1``. Where chances differ it is an upper bound at their mean for every k above the mean
    number of successes plus one (W. Hoeffding, Annals of Mathematical Statistics 27, 1956, 713).
    """
    single = [math.comb(trials, k) * chance**k * (1 - chance) ** (trials - k) for k in range(trials + 1)]
    return tuple(float(value) for value in np.minimum(1.0, np.cumsum(single[::-1]))[::-1])


class _Near:
    """Finds values that may agree with a given one: an index for each size of the last digit."""

    def __init__(self, values: Floats, steps: Floats) -> None:
        sizes = np.ceil(np.log10(np.maximum(steps, _EXACT * values)))
        self._parts: list[tuple[float, Floats, Integers]] = []
        for size in np.unique(sizes):
            members = np.flatnonzero(sizes == size)
            order = members[np.argsort(values[members], kind="stable")]
            self._parts.append((float(steps[members].max()), values[order], order))

    def find(self, values: Floats, steps: Floats) -> tuple[Integers, Integers]:
        """Give positions in `values` with those of what is near, one pair for each."""
        which, found = [], []
        for widest, ordered, order in self._parts:
            reach = np.maximum(steps, widest) * 0.5 + 2 * _EXACT * values
            low, high = np.searchsorted(ordered, values - reach), np.searchsorted(ordered, values + reach, side="right")
            at, place = _each(low, high)
            which.append(at)
            found.append(order[place])
        return np.concatenate(which), np.concatenate(found)


class _NearBoth:
    """Finds pairs of values that may both agree with those given: cells of one, in each of them the other in order.

    What is looked through grows with what agrees in both, not with what agrees in one.
    """

    def __init__(self, values: Floats, steps: Floats, beside: Floats, beside_steps: Floats) -> None:
        self._parts: list[tuple[tuple[float, float, float], Floats, NDArray[np.complex128], Integers]] = []
        least = 1e-4 * float(np.median(beside)) if len(beside) else 1.0
        sizes = np.ceil(np.log10(np.maximum([steps, beside_steps], [_EXACT * values, least + 0 * beside])))
        for size in np.unique(sizes, axis=1).T:
            members = np.flatnonzero((sizes == size[:, None]).all(axis=0))
            widest, beside_widest = float(steps[members].max()), float(beside_steps[members].max())
            width = max(beside_widest, least)
            # Complex numbers are ordered by their real part, and then by the other.
            places = np.floor(beside[members] / width) + 1j * values[members]
            order = np.argsort(places, kind="stable")
            cells = np.unique(places.real)
            self._parts.append(((widest, beside_widest, width), cells, places[order], members[order]))

    def find(self, values: Floats, steps: Floats, beside: Floats, beside_steps: Floats) -> tuple[Integers, Integers]:
        """Give positions in `values` with those of what is near, one pair for each."""
        which, found = [np.zeros(0, int)], [np.zeros(0, int)]
        for (widest, beside_widest, width), cells, ordered, order in self._parts:
            reach = np.maximum(steps, widest) * 0.5 + 2 * _EXACT * values
            around = np.maximum(beside_steps, beside_widest) * 0.5 + 2 * _EXACT * beside
            low = np.searchsorted(cells, np.floor((beside - around) / width))
            high = np.searchsorted(cells, np.floor((beside + around) / width), side="right")
            mine, cell = _each(low, high)
            low = np.searchsorted(ordered, cells[cell] + 1j * (values - reach)[mine])
            high = np.searchsorted(ordered, cells[cell] + 1j * (values + reach)[mine], side="right")
            at, place = _each(low, high)
            which.append(mine[at])
            found.append(order[place])
        return np.concatenate(which), np.concatenate(found)


def _each(low: Integers, high: Integers) -> tuple[Integers, Integers]:
    """Give the numbers from each low up to its high, and at which place these stand."""
    count = high - low
    ends = np.cumsum(count)
    total = int(ends[-1]) if len(ends) else 0
    return np.repeat(np.arange(len(low)), count), np.arange(total) - np.repeat(ends - count - low, count)


class _Weighed(NamedTuple):
    """What a log could have in common with each of N logs of R rows."""

    compared: Integers  # rows that could agree, on the side that has fewer, shape (N,)
    chance: Floats  # mean chance that one of them does, on the side where it is larger, shape (N,)
    told_here: NDArray[np.bool_]  # which of the log's rows count for each log, shape (n, N)
    told_there: NDArray[np.bool_]  # which rows count on the other side, shape (R,)


class Rows:
    """The rows of a class, with the chance that any two agree."""

    def __init__(self, logs: Logs) -> None:
        self.logs = logs
        self.by_both = _NearBoth(logs.period, logs.period_step, logs.spin, logs.spin_step)
        self.by_spin = _Near(logs.spin, logs.spin_step)
        self.common = self._common()

    def _compared(self, mine: Integers, other: Integers) -> tuple[Integers, Floats]:
        """Tell which pairs of rows could agree (same spin and torque), and how probably each does in the period."""
        logs = self.logs
        same = same_number(logs.spin[mine], logs.spin[other], logs.spin_step[mine], logs.spin_step[other])
        same &= same_weight(logs.torque[mine], logs.torque[other]) & (logs.log[mine] != logs.log[other])
        kept = np.flatnonzero(same)
        mine, other = mine[kept], other[kept]
        step = np.maximum(logs.period_step[mine], logs.period_step[other]) + 2 * _EXACT * logs.period[mine]
        noise = logs.noise[logs.log[mine]], logs.noise[logs.log[other]]
        spread = np.hypot(noise[0] / logs.turns[mine], noise[1] / logs.turns[other])
        # No window of this width holds more of a normal distribution, wherever its centre is.
        with np.errstate(divide="ignore"):
            return kept, np.clip(step / (math.sqrt(2 * math.pi) * spread), LEAST, 1.0)

    def _agree(self, mine: Integers, other: Integers) -> NDArray[np.bool_]:
        logs = self.logs
        return same_number(logs.period[mine], logs.period[other], logs.period_step[mine], logs.period_step[other])

    def _matches(self) -> Iterator[tuple[Integers, Integers, Floats]]:
        """For each log its rows (counted from 0), the rows of others that agree with them, and the chances of that.

        They are found anew each time: all of a large class at once would not go into memory.
        """
        logs = self.logs
        for begin in range(0, len(logs.keys), BLOCK):
            starts = logs.starts[begin : begin + BLOCK + 1]
            block = slice(int(starts[0]), int(starts[-1]))
            mine, other = self.by_both.find(
                logs.period[block], logs.period_step[block], logs.spin[block], logs.spin_step[block]
            )
            mine = mine + block.start
            kept, chance = self._compared(mine, other)
            agree = self._agree(mine[kept], other[kept])
            mine, other, chance = mine[kept][agree], other[kept][agree], chance[agree]
            order = np.argsort(logs.log[mine], kind="stable")
            ends = np.searchsorted(mine[order], starts[1:-1])
            for start, part in zip(starts[:-1], np.split(order, ends), strict=True):
                yield mine[part] - start, other[part], chance[part]

    def _common(self) -> Floats:
        """Share of the logs that have a row without being otherwise alike: an example left in, a row for everybody."""
        logs = self.logs
        common = np.zeros(len(logs.log))
        for log, (mine, other, _) in enumerate(self._matches()):
            rows = logs.rows(log)
            size = rows.stop - rows.start
            # One count for each log that agrees with a row, however many of its rows do.
            mine, theirs = np.divmod(np.unique(mine * len(logs.keys) + logs.log[other]), len(logs.keys))
            _, theirs, alike = np.unique(theirs, return_inverse=True, return_counts=True)
            strangers = mine[2 * alike[theirs] < size]
            # One stranger is no crowd: it may be the one who copied a few rows.
            crowd = np.maximum(np.bincount(strangers, minlength=size) - 1, 0)
            common[rows] = crowd / max(len(logs.keys) - 2, 1)
        return common

    def chances(self) -> Chances:
        """Count how many rows of every pair could agree, and how probably; a sample stands for a large class."""
        logs = self.logs
        counted: Counter[tuple[int, int]] = Counter()
        seen = work = 0
        # Multiples of the golden ratio: wherever the work ends, the logs done are spread over the whole class.
        for log in np.argsort(np.arange(len(logs.keys)) * GOLDEN % 1, kind="stable").tolist():
            rows = logs.rows(log)
            mine, other = self.by_spin.find(logs.spin[rows], logs.spin_step[rows])
            work += len(logs.log) + len(mine)
            kept, chance = self._compared(mine + rows.start, other)
            both = self._weigh(log, mine[kept], other[kept], chance, range(len(logs.keys)))
            valid = logs.compared_with(log, np.arange(len(logs.keys)))
            seen += int(valid.sum())
            valid &= both.compared > 0
            bins = np.ceil(_BINS * np.log10(np.maximum(both.chance[valid], LEAST))).astype(int)
            counted.update(zip(both.compared[valid].tolist(), bins.tolist(), strict=True))
            if work > WORK and seen:
                break
        return Chances({(m, 10 ** (b / _BINS)): count for (m, b), count in counted.items()}, logs.pairs / seen)

    def _weigh(self, log: int, mine: Integers, other: Integers, chance: Floats, among: range) -> _Weighed:
        """Add up the chances that rows of one log (counted from 0) agree with rows of some others, from both sides."""
        logs = self.logs
        rows, count, first = logs.rows(log), len(among), int(logs.starts[among.start])
        there_rows = slice(first, int(logs.starts[among.stop]))
        size = rows.stop - rows.start
        here = np.bincount(mine * count + logs.log[other] - among.start, chance, minlength=size * count)
        here = here.reshape(size, count)
        here = np.maximum(here, self.common[rows, None] * (here > 0))
        there = np.bincount(other - first, chance, minlength=there_rows.stop - first)
        there = np.maximum(there, self.common[there_rows] * (there > 0))
        told_here, told_there = (here > 0) & (here <= TELLING), (there > 0) & (there <= TELLING)
        owners = logs.log[there_rows][told_there] - among.start
        number_here, number_there = told_here.sum(axis=0), np.bincount(owners, minlength=count)
        here *= told_here
        # Added one after the other, for any number of logs to the same last bit.
        mean_here = np.cumsum(here, axis=0)[-1] / np.maximum(number_here, 1)
        mean_there = np.bincount(owners, there[told_there], minlength=count) / np.maximum(number_there, 1)
        return _Weighed(np.minimum(number_here, number_there), np.maximum(mean_here, mean_there), told_here, told_there)

    def candidates(self, chances: Chances, groups: Groups) -> Iterator[tuple[int, int]]:
        """Give the pairs that may rank low enough to be flagged and are not yet joined, the smaller number first."""
        logs = self.logs
        count = len(logs.keys)
        for log, (mine, other, chance) in zip(range(logs.current), self._matches(), strict=False):
            theirs = logs.log[other]
            kept = logs.compared_with(log, theirs) & (theirs > log)
            place, where = np.unique(mine[kept] * count + logs.log[other[kept]], return_inverse=True)
            single = np.bincount(where, chance[kept], minlength=len(place))
            single = np.maximum(single, self.common[logs.rows(log)][place // count])
            telling = single <= TELLING
            seconds, where = np.unique(place[telling] % count, return_inverse=True)
            together = np.exp(np.bincount(where, np.log(single[telling]), minlength=len(seconds)))
            size = logs.rows(log).stop - logs.rows(log).start
            near = (together <= ALLOWED) & (together * chances.share(size) <= chances.last_rank)
            for second, rank in zip(seconds[near].tolist(), together[near].tolist(), strict=True):
                if groups.joined(log, second):
                    continue
                if rank * chances.share(self._same_spins(log, second)) <= chances.last_rank:
                    yield log, second

    def _same_spins(self, first: int, second: int) -> int:
        """Rows of one log that have the spin of a row of the other, at most."""
        logs = self.logs
        here, there = logs.rows(first), logs.rows(second)
        same = same_number(logs.spin[there], logs.spin[here, None], logs.spin_step[there], logs.spin_step[here, None])
        return int(same.any(axis=1).sum())

    def compare(self, first: int, second: int) -> Alike:
        """Compare two logs row by row."""
        logs = self.logs
        start = logs.rows(first).start
        sides = [np.arange(logs.rows(log).start, logs.rows(log).stop) for log in (first, second)]
        mine, other = (grid.ravel() for grid in np.meshgrid(*sides, indexing="ij"))
        kept, chance = self._compared(mine, other)
        mine, other = mine[kept], other[kept]
        both = self._weigh(first, mine - start, other, chance, range(second, second + 1))
        told_there = both.told_there[other - logs.rows(second).start]
        agree = self._agree(mine, other) & both.told_here[mine - start, 0] & told_there
        rows: list[tuple[int, int]] = []
        taken: set[int] = set()
        for i, j in zip(mine[agree].tolist(), other[agree].tolist(), strict=True):
            if i not in taken and j not in taken:
                taken |= {i, j}
                rows.append((i, j))
        compared, mean = int(both.compared[0]), float(both.chance[0])
        p = binomial_tails(compared, mean)[min(len(rows), compared)]
        return Alike(rows, compared, mean, max(p, LEAST))

    def tell(self, first: int, second: int) -> str:
        """Put what two logs have in common into words."""
        logs = self.logs
        alike = self.compare(first, second)
        mine, other = (np.array(side) for side in zip(*alike.rows, strict=True))
        shorter = min(rows.stop - rows.start for rows in (logs.rows(first), logs.rows(second)))
        places = [
            f"{logs.keys[log]} (lines {', '.join(str(line) for line in sorted(self._lines(log, rows)))})"
            for log, rows in ((first, mine), (second, other))
        ]
        how = []
        if logs.prints[first].sha256 == logs.prints[second].sha256:
            how.append("the files are the same byte for byte")
        if list(np.argsort(self._lines(first, mine))) != list(np.argsort(self._lines(second, other))):
            how.append("in another order")
        steps = logs.period_step[mine] / logs.period_step[other]
        if np.any((steps > 1.5) | (steps < 1 / 1.5)):
            how.append("not typed to the same digit")
        return (
            f"{len(alike.rows)} of {shorter} rows of {places[0]} are in {places[1]}, with the same spin and the same "
            f"precession period{''.join(', ' + words for words in how)}; of rows with the same spin, 1 in "
            f"{1 / alike.chance:.0f} would have the same period by chance"
        )

    def _lines(self, log: int, rows: Integers) -> list[int]:
        lines, start = self.logs.prints[log].lines, int(self.logs.starts[log])
        return [lines[row - start] for row in rows.tolist()]

    # --- spins alone ---

    @cached_property
    def counting(self) -> NDArray[np.bool_]:
        """Rows whose spin tells something, shape (R,): not a round one, and each spin at a weight once."""
        logs = self.logs
        off = np.abs(logs.spin - ROUND * np.round(logs.spin / ROUND))
        counting: NDArray[np.bool_] = off > 0.5 * logs.spin_step + _EXACT * logs.spin
        # Rows are in the order of torque and spin.
        again = (np.diff(logs.log) == 0) & (np.diff(logs.torque) == 0) & (np.diff(logs.spin) == 0)
        counting[1:] &= ~again
        return counting

    @cached_property
    def grids(self) -> Floats:
        """What the spins of each log are read to [rad/s], shape (N,)."""
        logs = self.logs
        grids = np.maximum.reduceat(logs.spin_step, logs.starts[:-1])
        for grid in GRIDS:
            off = np.abs(logs.spin - grid * np.round(logs.spin / grid)) > 1e-6 * logs.spin
            whole = ~np.logical_or.reduceat(off, logs.starts[:-1])
            grids = np.where(whole, np.maximum(grids, grid), grids)
        return grids

    def _near_spins(self, rows: Integers, reach: Floats) -> tuple[Integers, Integers]:
        """Positions among rows, and rows of other logs at the same weight, whose spins are nearer than a reach."""
        logs = self.logs
        at, other = self.by_spin.find(logs.spin[rows], 2 * reach)
        mine = rows[at]
        same = (logs.log[mine] != logs.log[other]) & (np.abs(logs.spin[mine] - logs.spin[other]) <= reach[at])
        same &= same_weight(logs.torque[mine], logs.torque[other])
        return at[same], other[same]

    def _spins_of(self, log: int) -> Integers:
        start, stop = self.logs.starts[log : log + 2]
        rows: Integers = np.arange(start, stop)[self.counting[start:stop]]
        return rows

    def _same(self, rows: Integers) -> tuple[Integers, Integers]:
        """Positions among rows, and logs that have their spins at their weights, each once."""
        logs = self.logs
        at, other = self._near_spins(rows, 0.5 * logs.spin_step[rows] + _EXACT * logs.spin[rows])
        found = np.unique(at * len(logs.keys) + logs.log[other])
        return np.divmod(found, len(logs.keys))

    def with_same_spins(self) -> Iterator[tuple[int, int]]:
        """Give the pairs that share most of their spins, the smaller number first."""
        logs = self.logs
        count, sizes = len(logs.keys), np.add.reduceat(self.counting, logs.starts[:-1])
        if count > LARGE:
            yield from self._with_spins_in_a_row(sizes)
            return
        for begin in range(0, logs.current, BLOCK):
            block = slice(begin, min(begin + BLOCK, logs.current))
            rows = np.arange(logs.starts[block.start], logs.starts[block.stop])
            rows = rows[self.counting[rows]]
            at, having = self._same(rows)
            number = (logs.log[rows[at]] - begin) * count + having
            shared = np.bincount(number, minlength=(block.stop - begin) * count).reshape(-1, count)
            wanted = np.maximum(MOST_SPINS * np.minimum(sizes, sizes[block, None]), FEWEST)
            for i, second in np.argwhere(shared > wanted).tolist():
                first = begin + i
                if first < second and logs.compared_with(first, np.array([second]))[0]:
                    yield first, second

    def _with_spins_in_a_row(self, sizes: Integers) -> Iterator[tuple[int, int]]:
        """Give the same for a large class, of those only that share two pairs of spins that stand in a row in both."""
        logs = self.logs
        counting = np.flatnonzero(self.counting)
        row, after = counting[:-1], counting[1:]
        in_one = logs.log[row] == logs.log[after]
        row, after = row[in_one], after[in_one]
        near = _NearBoth(logs.spin[row], logs.spin_step[row], logs.spin[after], logs.spin_step[after])
        ends = np.searchsorted(logs.log[row], np.arange(0, logs.current + BLOCK, BLOCK))
        for begin, end in itertools.pairwise(ends.tolist()):
            block = slice(begin, end)
            steps = logs.spin_step[row[block]], logs.spin_step[after[block]]
            mine, other = near.find(logs.spin[row[block]], steps[0], logs.spin[after[block]], steps[1])
            mine = mine + begin
            alike = logs.log[row[mine]] < logs.log[row[other]]
            for one in (row, after):
                alike &= self._has_spin(one[mine], one[other])
            mine, other = logs.log[row[mine[alike]]], logs.log[row[other[alike]]]
            pairs, times = np.unique(mine * len(logs.keys) + other, return_counts=True)
            for pair in pairs[times > 1].tolist():
                first, second = divmod(pair, len(logs.keys))
                here, there = self._spins_of(first), np.arange(*logs.starts[second : second + 2])
                shared = int(self._has_spin(here[:, None], there).any(axis=1).sum())
                wanted = max(MOST_SPINS * min(sizes[first], sizes[second]), FEWEST)
                if shared > wanted and logs.compared_with(first, np.array([second]))[0]:
                    yield first, second

    def _has_spin(self, mine: Integers, other: Integers) -> NDArray[np.bool_]:
        """Tell which rows have the spin of another at its weight, to the last digit of the first."""
        logs = self.logs
        reach = 0.5 * logs.spin_step[mine] + _EXACT * logs.spin[mine]
        has: NDArray[np.bool_] = np.abs(logs.spin[mine] - logs.spin[other]) <= reach
        return has & same_weight(logs.torque[mine], logs.torque[other])

    def chance_of_spins(self, log: int, other: int) -> float:
        """Work out the chance that another log has as many of one's spins, by how common each is in the class."""
        logs = self.logs
        rows, count = self._spins_of(log), len(logs.keys)
        at, having = self._same(rows)
        common, shared = np.bincount(at, minlength=len(rows)) / (count - 1), int(np.sum(having == other))
        least = _as_many(common, shared)
        if least * logs.pairs > ALLOWED:
            return least  # what is looked up below only makes it larger
        reach = AROUND * logs.spin[rows]
        around = np.bincount(self._near_spins(rows, reach)[0], minlength=len(rows))
        step = min(self.grids[log], self.grids[other])
        dense = (around + 1) / count * np.minimum(1.0, step / (2 * reach))
        return _as_many(np.minimum(1.0, np.maximum(common, dense)), shared)

    def is_habit(self, first: int, second: int) -> bool:
        """Tell whether more logs have the spins that two share than copy from each other."""
        at, having = self._same(self._spins_of(first))
        shared = at[having == second]
        others = np.bincount(having[np.isin(at, shared)], minlength=len(self.logs.keys))
        habit = 1 + int(np.sum(others > MOST_SPINS * len(shared)))
        return habit > max(HABIT, HABIT_SHARE * len(self.logs.keys))

    def tell_spins(self, first: int, second: int) -> str:
        """Put into words which spins two logs share, and how their times differ."""
        logs = self.logs
        at, having = self._same(self._spins_of(first))
        mine = self._spins_of(first)[at[having == second]]
        of = min(int(self.counting[logs.rows(log)].sum()) for log in (first, second))
        alike = [float(np.min(np.abs(self._times(second, row) - self._time(row)), initial=math.inf)) for row in mine]
        lines = ", ".join(str(line) for line in sorted(self._lines(first, mine)))
        return (
            f"{len(mine)} of {of} spins of {logs.keys[first]} (lines {lines}) are those of {logs.keys[second]} at the "
            f"same weights, round ones not counted; the times beside them differ by {max(alike):.2g} s at most"
        )

    def _time(self, row: int) -> float:
        return float(self.logs.period[row] * self.logs.turns[row])

    def _times(self, log: int, row: int) -> Floats:
        """Times of a log at one row's spin."""
        logs = self.logs
        rows = logs.rows(log)
        same = same_number(logs.spin[row], logs.spin[rows], logs.spin_step[row], logs.spin_step[rows])
        same &= np.abs(logs.torque[rows] - logs.torque[row]) <= SAME_TORQUE * np.abs(logs.torque[row])
        times: Floats = (logs.period[rows] * logs.turns[rows])[same]
        return times


def _as_many(chances: Floats, least: int) -> float:
    """Work out the chance that so many of unlike chances come true, or more (Poisson's binomial)."""
    numbers = np.zeros(len(chances) + 1)
    numbers[0] = 1.0
    for chance in chances.tolist():
        numbers[1:] = numbers[1:] * (1 - chance) + numbers[:-1] * chance
        numbers[0] *= 1 - chance
    return float(numbers[least:].sum())


# --- two logs side by side ----------------------------------------------------------------------------------


class Beside(NamedTuple):
    """A row of each of two logs, counted from 0; None where a log has none left."""

    first: int | None
    second: int | None
    same_spin: bool = False
    same_period: bool = False


def put_beside(first: Fingerprint, second: Fingerprint) -> list[Beside]:
    """Put the rows of two logs beside each other, the most alike first: whatever order, unit and digits they have."""

    def both(name: str) -> tuple[Floats, Floats]:
        return np.array(getattr(first, name))[:, None], np.array(getattr(second, name))

    def of_a_turn(name: str) -> Iterator[Floats]:
        return map(np.divide, both(name), both("turns"))

    weight = same_weight(*both("torque"))
    same_spin = weight & same_number(*both("spin"), *both("spin_step"))
    same_period = weight & same_number(*of_a_turn("time"), *of_a_turn("time_step"))
    partner: dict[int, int] = {}
    taken: set[int] = set()
    for alike in (same_spin & same_period, same_spin, same_period, weight, np.ones_like(weight)):
        for i, j in np.argwhere(alike).tolist():
            if i not in partner and j not in taken:
                partner[i] = j
                taken.add(j)
    found = []
    for row in range(len(first.spin)):
        at = partner.get(row)
        same = (False, False) if at is None else (bool(same_spin[row, at]), bool(same_period[row, at]))
        found.append(Beside(row, at, *same))
    return found + [Beside(None, at) for at in range(len(second.spin)) if at not in taken]
