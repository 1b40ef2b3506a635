"""What two logs have in common: rows of the same spin and period, whatever the order, unit and rounding; or spins.

Each row is looked up, by its weight and spin, among those of all other logs. Two things follow:

* how common each spin is in the class, and so how rare it is to share as many as two logs do. Round ones never count,
  nor do spins that are a habit of the course;
* how many of these rows have the same period too. Two hands that time one spin seldom stop at the same hundredth of a
  second: each row has a chance that follows from the scatter of a hand and from the last digit.

Both logs of a pair are asked, and the larger chance counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.grading.forensics.flags import ALLOWED, LEAST, Flag, flag_pairs
from gyrodata.grading.forensics.logs import Fingerprint, Logs
from gyrodata.physics import RPM, Floats, Integers

SAME_TORQUE = 0.1
"""Relative difference of two torques up to which rows are compared: stations have weights of their own."""

TELLING = 0.5  # a row that would agree by chance more often than this tells nothing and is not counted

FEWEST = 3  # rows in common from which a pair is flagged, however rare; of spins alone, more than these

ROUND = 50 * RPM
"""Spins that are a multiple of this are aimed at, or written as if they had been met; they never count [rad/s]."""

GRIDS = tuple(rpm * RPM for rpm in (100, 50, 25, 20, 10, 5, 2))
"""What a tachometer may be read to [rad/s]."""

MOST_SPINS = 0.5  # share of the spins of the shorter log that must be in common

HABIT, HABIT_SHARE = 5, 0.02
"""More logs than this, and than this share of the class, that have a set of spins make it a habit of the course."""

BLOCK, PAIRS = 32, 1_000_000  # logs that are looked up at a time, and pairs that are counted at a time, at most

_EXACT = 1e-9

_Found = tuple[Integers, Floats]
"""Pairs, each as one number times that of all logs plus the other, with their chances."""


def flag_copies(logs: Logs) -> list[Flag]:
    """Find logs that have more rows in common than chance gives, or else more spins, whatever became of the times."""
    near = _Near(logs)
    common = _common(logs, near)
    telling = np.add.reduceat(common > 0, logs.starts[:-1], dtype=int)
    size = min(BLOCK, 1 + PAIRS // len(logs.keys))
    blocks = np.split(np.arange(len(logs.keys)), range(size, len(logs.keys), size))
    asked = [_Asked(logs, near, common, telling, block).found() for block in blocks]
    rows, joined = flag_pairs("shared rows", _both_ways([one for one, _ in asked], logs), logs, _tell_rows)
    spins = [pair for pair in _both_ways([one for _, one in asked], logs) if joined[pair[1]] != joined[pair[2]]]
    return rows + flag_pairs("same spins", spins, logs, _tell_spins)[0]


def _both_ways(found: list[_Found], logs: Logs) -> list[tuple[float, int, int]]:
    """Give chance and numbers of the pairs that are found from both of their logs; the larger chance counts."""
    keys, p = (np.concatenate(parts) for parts in zip(*found, strict=True))
    first, second = np.divmod(keys, len(logs.keys))
    back = np.argsort(second * len(logs.keys) + first)
    there, here, other = np.intersect1d(keys, (second * len(logs.keys) + first)[back], True, return_indices=True)
    p, (first, second) = np.maximum(p[here], p[back[other]]), np.divmod(there, len(logs.keys))
    once = first < second
    return list(zip(p[once].tolist(), first[once].tolist(), second[once].tolist(), strict=True))


def same_number(one: Floats, other: Floats, step: Floats, other_step: Floats) -> NDArray[np.bool_]:
    """Tell which numbers are the same to the last digit of the coarser one."""
    same: NDArray[np.bool_] = np.abs(one - other) <= 0.5 * np.maximum(step, other_step) + _EXACT * one
    return same


def same_weight(one: Floats, other: Floats) -> NDArray[np.bool_]:
    """Tell which torques are near enough for their rows to be compared."""
    one, other = np.abs(one), np.abs(other)
    same: NDArray[np.bool_] = np.abs(one - other) <= SAME_TORQUE * np.maximum(one, other)
    return same


def tails(chances: Floats) -> Floats:
    """Give the chance that k or more come true of those in each row, shape (g, n), for k from 0 to n.

    How many of unlike chances come true is Poisson's binomial; they are taken one after the other.
    """
    numbers = np.zeros((len(chances), chances.shape[1] + 1))
    numbers[:, 0] = 1.0
    for chance in chances.T[:, :, None]:
        numbers[:, 1:] = numbers[:, 1:] * (1 - chance) + numbers[:, :-1] * chance
        numbers[:, :1] *= 1 - chance
    return np.cumsum(numbers[:, ::-1], axis=1)[:, ::-1]


def _counting(logs: Logs) -> NDArray[np.bool_]:
    """Tell which rows have a spin that tells something, shape (R,): no round one, and each at a weight once."""
    off = np.abs(logs.spin - ROUND * np.round(logs.spin / ROUND))
    counting: NDArray[np.bool_] = off > 0.5 * logs.spin_step + _EXACT * logs.spin
    # Rows are in the order of torque and spin.
    counting[1:] &= (np.diff(logs.log) != 0) | (np.diff(logs.torque) != 0) | (np.diff(logs.spin) != 0)
    return counting


def _grids(logs: Logs) -> Floats:
    """Tell what the spins of each row's log are read to [rad/s], shape (R,)."""
    grids = np.maximum.reduceat(logs.spin_step, logs.starts[:-1])
    for grid in GRIDS:
        off = np.abs(logs.spin - grid * np.round(logs.spin / grid)) > 1e-6 * logs.spin
        grids = np.maximum(grids, grid * ~np.logical_or.reduceat(off, logs.starts[:-1]))
    return grids[logs.log]


class _Near:
    """Finds rows that may have the weight and spin of a given one: an index for each weight and size of last digit."""

    def __init__(self, logs: Logs) -> None:
        self.logs, torque = logs, np.abs(logs.torque)
        sizes = np.ceil(np.log10(np.maximum(logs.spin_step, _EXACT * logs.spin)))
        weights = np.round(np.log(np.maximum(torque, LEAST)) / SAME_TORQUE)
        # A place is where a row stands in this order.
        self.order = np.lexsort((logs.spin, sizes, weights))
        self.log, self.period, self._spin = (of[self.order] for of in (logs.log, logs.period, logs.spin))
        self.reach = 0.5 * logs.period_step + _EXACT * logs.period
        self.their = self.reach[self.order]
        self._places = np.arange(len(self.order))
        changes = (np.diff(weights[self.order]) != 0) | (np.diff(sizes[self.order]) != 0)
        self._parts: list[tuple[Integers, float, float, float]] = []
        for part in np.split(self._places, np.flatnonzero(changes) + 1):
            rows, ratio = self.order[part], 1 - SAME_TORQUE - _EXACT
            light, heavy = ratio * float(torque[rows].min()), float(torque[rows].max()) / ratio
            self._parts.append((part, light, heavy, float(logs.spin_step[rows].max())))

    def find(self, rows: Integers, steps: Floats) -> tuple[Integers, Integers]:
        """Give rows with the places of what is near, one pair for each."""
        which, found, torque = [], [rows[:0]], np.abs(self.logs.torque[rows])
        for part, light, heavy, widest in self._parts:
            asked = rows[(light <= torque) & (torque <= heavy)]
            spin, ordered = self.logs.spin[asked], self._spin[part[0] : part[-1] + 1]
            reach = np.maximum(steps[asked], widest) * 0.5 + 2 * _EXACT * spin
            low, high = np.searchsorted(ordered, spin - reach), np.searchsorted(ordered, spin + reach, side="right")
            which.append(np.repeat(asked, high - low))
            found += [part[start:end] for start, end in zip(low.tolist(), high.tolist(), strict=True)]
        return np.concatenate(which), np.concatenate(found)

    def same(self, mine: Integers, place: Integers, steps: Floats) -> tuple[Integers, Integers]:
        """Keep the rows that do have the weight and spin of a row of another log."""
        logs, other = self.logs, self.order[place]
        same = same_weight(logs.torque[mine], logs.torque[other]) & (logs.log[mine] != logs.log[other])
        same &= same_number(logs.spin[mine], logs.spin[other], steps[mine], logs.spin_step[other])
        return mine[same], other[same]


def _common(logs: Logs, near: _Near) -> Floats:
    """Share of the logs that have each row's spin, shape (R,); 0 where it tells nothing."""
    common, grid, rows = np.zeros(len(logs.log)), _grids(logs), np.flatnonzero(_counting(logs))
    # Many rows of a large class have one weight and spin.
    values = np.column_stack([logs.torque, logs.spin, grid])[rows]
    _, first, again = np.unique(values, axis=0, return_index=True, return_inverse=True)
    for begin in range(0, len(first), BLOCK):
        asked = np.sort(rows[first[begin : begin + BLOCK]])
        mine, other = near.same(*near.find(asked, grid), grid)
        with_it = np.unique(mine * len(logs.keys) + logs.log[other]) // len(logs.keys)
        # What one in n logs has is seen in two, where two are looked at.
        common[asked] = (1 + np.bincount(np.searchsorted(asked, with_it), minlength=len(asked))) / len(logs.keys)
    common[rows] = common[rows[first]][again.ravel()]
    return common


class _Asked:
    """What each log of a block shares with each other log: an entry for each of its rows and each log with its spin.

    Of pairs that share too little to be flagged there are none; there are many in a large class.
    """

    def __init__(self, logs: Logs, near: _Near, common: Floats, spins: Integers, block: Integers) -> None:
        self.logs, self.near, self.common, self.spins, number = logs, near, common, spins, len(logs.keys)
        self.logs_asked, begin = block, block[0]
        self.rows = np.arange(logs.starts[begin], logs.starts[block[-1] + 1])
        mine, place = near.find(self.rows, logs.spin_step)
        pair = (logs.log[mine] - begin) * number + near.log[place]
        often = np.bincount(pair, common[mine] > 0, len(block) * number)
        agree = np.flatnonzero(np.abs(logs.period[mine] - near.period[place]) <= near.reach[mine] + near.their[place])
        alike, crowd = self._crowd(*near.same(mine[agree], place[agree], logs.spin_step), len(often))
        several = np.flatnonzero(often > FEWEST)
        first, second = np.divmod(several, number)
        wanted = alike >= FEWEST
        wanted[several] |= often[several] > MOST_SPINS * np.minimum(spins[block[first]], spins[second])
        kept = np.flatnonzero(wanted[pair])
        mine, other = near.same(mine[kept], place[kept], logs.spin_step)
        entry, at = np.unique(mine * number + logs.log[other], return_inverse=True)
        self.row, log = np.divmod(entry, number)
        self.agree = np.bincount(at, self._same_period(mine, other)) > 0
        self.pair, self.at = np.unique(logs.log[self.row] * number + log, return_inverse=True)
        self.first, self.second = np.divmod(self.pair, number)
        self.chance = np.maximum(np.bincount(at, _chance(logs, mine, other)), crowd[self.row - self.rows[0]])

    def _same_period(self, mine: Integers, other: Integers) -> NDArray[np.bool_]:
        period, step = self.logs.period, self.logs.period_step
        return same_number(period[mine], period[other], step[mine], step[other])

    def _crowd(self, mine: Integers, other: Integers, pairs: int) -> tuple[Integers, Floats]:
        """Count the rows in which pairs agree; and give, for each row, the share of the logs that have it.

        Those that are otherwise alike are left out: this is for an example left in, a row for everybody.
        """
        logs, agree = self.logs, self._same_period(mine, other)
        row, log = np.divmod(np.unique(mine[agree] * len(logs.keys) + logs.log[other[agree]]), len(logs.keys))
        pair = (logs.log[row] - self.logs_asked[0]) * len(logs.keys) + log
        alike = np.bincount(pair, minlength=pairs)
        strangers = 2 * alike[pair] < np.diff(logs.starts)[logs.log[row]]
        # One stranger is no crowd: it may be the one who copied a few rows.
        crowd = np.bincount(row - self.rows[0], strangers, len(self.rows)) - 1
        return alike, np.maximum(crowd, 0) / max(len(logs.keys) - 2, 1)

    def _laid_out(self, values: Floats, row: Integers, owner: Integers, owners: int) -> Floats:
        """Lay out values of rows, those of one owner in a row, each at its place in its log."""
        starts = self.logs.starts
        table = np.zeros((owners, int(np.max(np.diff(starts)[self.logs_asked]))))
        table[owner, row - starts[self.logs.log[row]]] = values
        return table

    def _is_habit(self, number: int) -> bool:
        """Tell whether more logs have the spins that two share than copy from each other."""
        logs, rows = self.logs, self.row[self.at == number]
        spins = rows[self.common[rows] > 0]
        mine, other = self.near.same(*self.near.find(spins, logs.spin_step), logs.spin_step)
        others = np.bincount(np.unique(mine * len(logs.keys) + logs.log[other]) % len(logs.keys))
        most = max(HABIT, HABIT_SHARE * len(logs.keys))
        return 1 + int(np.sum(others > MOST_SPINS * len(spins))) > most

    def found(self) -> tuple[_Found, _Found]:
        """Give the pairs with more rows, and those with more spins, in common than chance gives."""
        logs = self.logs
        allowed = ALLOWED / logs.pairs
        compared = ((self.first < logs.current) | (self.second < logs.current)) & ~np.isin(self.pair, logs.exempt)
        owners = logs.log[self.rows] - self.logs_asked[0]
        table = self._laid_out(self.common[self.rows], self.rows, owners, len(self.logs_asked))
        shared = np.bincount(self.at, self.common[self.row] > 0).astype(int)
        p_spins = tails(table)[self.first - self.logs_asked[0], shared]
        spins = np.minimum(self.spins[self.first], self.spins[self.second])
        enough = shared > np.maximum(MOST_SPINS * spins, FEWEST)
        telling = self.chance <= TELLING
        alike = np.bincount(self.at, self.agree & telling).astype(int)
        least = np.exp(np.bincount(self.at, (self.agree & telling) * np.log(np.maximum(self.chance, LEAST))))
        close = (alike >= FEWEST) & (p_spins * least <= allowed)
        uncommon = p_spins <= np.where(close, 1 - _EXACT, allowed)
        for number in np.flatnonzero(compared & uncommon & (close | enough)).tolist():
            if self._is_habit(number):
                p_spins[number] = 1.0
        copied = np.flatnonzero(compared & close)
        place = np.full(len(self.pair), -1)
        place[copied] = np.arange(len(copied))
        telling &= place[self.at] >= 0
        table = self._laid_out(self.chance[telling], self.row[telling], place[self.at[telling]], len(copied))
        p = tails(table)[np.arange(len(copied)), alike[copied]]
        # Where rows alone do not tell, how rare their spins are does: the chance of such a product (R. A. Fisher).
        both = np.maximum(p * p_spins[copied], LEAST)
        p = np.maximum(np.where(p <= allowed, p, both * (1 - np.log(both))), LEAST)
        in_spins = compared & enough & (p_spins <= allowed)
        return (self.pair[copied][p <= allowed], p[p <= allowed]), (self.pair[in_spins], p_spins[in_spins])


def _chance(logs: Logs, mine: Integers, other: Integers) -> Floats:
    """Give the chance that two hands that time the same spin stop at the same digit, row by row."""
    step = np.maximum(logs.period_step[mine], logs.period_step[other]) + 2 * _EXACT * logs.period[mine]
    spread = np.hypot(logs.noise[mine], logs.noise[other])
    # No window of this width holds more of a normal distribution, wherever its centre is.
    return step / np.maximum(math.sqrt(2 * math.pi) * spread, step)


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
    likeness = weight + 2 * same_period + 4 * same_spin
    order = np.unravel_index(np.argsort(-likeness, axis=None, kind="stable"), likeness.shape)
    partner: dict[int, int] = {}
    taken: set[int] = set()
    for i, j in zip(*(side.tolist() for side in order), strict=True):
        if i not in partner and j not in taken:
            partner[i] = j
            taken.add(j)
    pairs = [(row, partner.get(row)) for row in range(len(first.spin))]
    found = [Beside(i, j, *(j is not None and bool(same[i, j]) for same in (same_spin, same_period))) for i, j in pairs]
    return found + [Beside(None, at) for at in range(len(second.spin)) if at not in taken]


def _alike(logs: Logs, first: int, second: int, period: bool) -> list[tuple[int, int]]:
    """Give the rows of two logs that have the same spin, and where that is asked the same period."""
    beside = put_beside(logs.prints[first], logs.prints[second])
    return [
        (one.first, one.second)
        for one in beside
        if one.first is not None and one.second is not None and one.same_spin and (one.same_period or not period)
    ]


def _lines(logs: Logs, log: int, rows: Iterable[int]) -> str:
    lines = logs.prints[log].lines
    return f"{logs.keys[log]} (lines {', '.join(map(str, sorted(lines[row] for row in rows)))})"


def _tell_rows(logs: Logs, first: int, second: int) -> str:
    """Put what two logs have in common into words."""
    alike = _alike(logs, first, second, period=True)
    one, other = logs.prints[first], logs.prints[second]
    mine, theirs = zip(*alike, strict=True)
    how = ["the files are the same byte for byte"] * (one.sha256 == other.sha256)
    if np.any(np.argsort([one.lines[i] for i in mine]) != np.argsort([other.lines[j] for j in theirs])):
        how.append("in another order")
    steps = [(one.time_step[i] / one.turns[i], other.time_step[j] / other.turns[j]) for i, j in alike]
    if any(max(pair) > 1.5 * min(pair) for pair in steps):
        how.append("not typed to the same digit")
    common = f"{len(alike)} of {min(len(one.spin), len(other.spin))} rows of {_lines(logs, first, mine)} are in "
    common += f"{_lines(logs, second, theirs)}, with the same spin and the same precession period"
    return ", ".join([common, *how])


def _tell_spins(logs: Logs, first: int, second: int) -> str:
    """Put into words which spins two logs share, and how their times differ."""
    alike = _alike(logs, first, second, period=False)
    one, other = logs.prints[first], logs.prints[second]
    apart = max(abs(one.time[i] - other.time[j] * one.turns[i] / other.turns[j]) for i, j in alike)
    return (
        f"{len(alike)} of {min(len(one.spin), len(other.spin))} spins of {_lines(logs, first, [i for i, _ in alike])} "
        f"are those of {logs.keys[second]} at the same weights; the times beside them differ by {apart:.2g} s at most"
    )
