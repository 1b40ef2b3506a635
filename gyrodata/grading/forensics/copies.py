"""Rows that two logs share: the same spin and period in any order, unit and rounding; or the same spins.

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

TELLING = 0.5  # a row that would agree by chance more often than this is not counted

FEWEST = 3  # rows in common from which a pair is flagged, however rare; of spins alone, more than these

ROUND = 50 * RPM
"""Spins that are a multiple of this are aimed at, or written as if they had been met; they never count [rad/s]."""

GRIDS = tuple(rpm * RPM for rpm in (100, 50, 25, 20, 10, 5, 2))
"""What a tachometer may be read to [rad/s]."""

MOST_SPINS = 0.5  # share of the spins of the shorter log that must be in common

HABIT, HABIT_SHARE = 5, 0.02
"""More logs than this, and than this share of the class, that have a set of spins make it a habit of the course."""

BLOCK = 256  # rows that are looked up at a time, so that a large class needs little memory

_EXACT = 1e-9

_Found = tuple[Integers, Floats]
"""Pairs, each as one number times that of all logs plus the other, with their chances."""


def flag_copies(logs: Logs) -> list[Flag]:
    """Find logs that have more rows in common than chance gives, or else more spins, whatever became of the times."""
    common = _common(logs)
    telling = np.add.reduceat(common > 0, logs.starts[:-1], dtype=int)
    blocks = np.split(np.arange(len(logs.keys)), range(BLOCK // 8, len(logs.keys), BLOCK // 8))
    found = [_compare(logs, common, telling, block) for block in blocks]
    rows, joined = flag_pairs("shared rows", _both_ways([one for one, _ in found], logs), logs, _tell_rows)
    spins = [pair for pair in _both_ways([one for _, one in found], logs) if joined[pair[1]] != joined[pair[2]]]
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
    """Return which rows have a useful spin, shape (R,): not a round one, and each once for a weight."""
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


def _same_spins(logs: Logs, rows: Integers, steps: Floats) -> tuple[Integers, Integers]:
    """Give each row with each row of another log that has its weight and its spin, one pair for each.

    `steps`: one step of the last digit of each spin [rad/s], shape (R,).
    """
    spin, by_spin = logs.spin[rows], logs.spin[logs.order]
    reach = 0.5 * np.maximum(steps[rows], np.max(logs.spin_step)) + 2 * _EXACT * spin
    low, high = np.searchsorted(by_spin, spin - reach), np.searchsorted(by_spin, spin + reach, side="right")
    mine, begin = np.repeat(rows, high - low), np.repeat(low - np.cumsum(high - low) + (high - low), high - low)
    other = logs.order[begin + np.arange(len(mine))]
    same = same_weight(logs.torque[mine], logs.torque[other]) & (logs.log[mine] != logs.log[other])
    same &= same_number(logs.spin[mine], logs.spin[other], steps[mine], logs.spin_step[other])
    return mine[same], other[same]


def _common(logs: Logs) -> Floats:
    """Return the share of the logs with each row's spin, shape (R,); 0 if the spin is not useful."""
    common, grid, rows = np.zeros(len(logs.log)), _grids(logs), np.flatnonzero(_counting(logs))
    # Many rows of a large class have one weight and spin.
    values = np.column_stack([logs.torque, logs.spin, grid])[rows]
    _, first, again = np.unique(values, axis=0, return_index=True, return_inverse=True)
    for begin in range(0, len(first), BLOCK):
        asked = np.sort(rows[first[begin : begin + BLOCK]])
        mine, other = _same_spins(logs, asked, grid)
        with_it = np.unique(mine * len(logs.keys) + logs.log[other]) // len(logs.keys)
        # A value in one of n logs is seen in two if two logs are compared.
        common[asked] = (1 + np.bincount(np.searchsorted(asked, with_it), minlength=len(asked))) / len(logs.keys)
    common[rows] = common[rows[first]][again.ravel()]
    return common


def _compare(logs: Logs, common: Floats, telling: Integers, block: Integers) -> tuple[_Found, _Found]:
    """Give the pairs with more rows, and those with more spins, in common than chance gives, for a block of logs.

    `common`: as `_common` has it. `telling`: rows of each log whose spin tells something, shape (N,).
    """
    number, allowed, lengths = len(logs.keys), ALLOWED / logs.pairs, np.diff(logs.starts)
    rows = np.arange(logs.starts[block[0]], logs.starts[block[-1] + 1])
    mine, other = _same_spins(logs, rows, logs.spin_step)
    same_period = same_number(logs.period[mine], logs.period[other], logs.period_step[mine], logs.period_step[other])
    crowd = _crowd(logs, rows, mine[same_period], other[same_period])
    # An entry is a row and another log that has its spin; all entries of two logs are a pair.
    entry, at = np.unique(mine * number + logs.log[other], return_inverse=True)
    row, log = np.divmod(entry, number)
    agree = np.bincount(at, same_period, len(entry)) > 0
    chance = np.maximum(np.bincount(at, _chance(logs, mine, other), len(entry)), crowd[row - rows[0]])
    pair, at = np.unique(logs.log[row] * number + log, return_inverse=True)
    first, second = np.divmod(pair, number)

    def count(entries: NDArray[np.bool_]) -> Integers:
        return np.bincount(at, entries, len(pair)).astype(int)

    def laid_out(values: Floats, of: Integers, owner: Integers, owners: int) -> Floats:
        """Lay out values of rows, those of one owner in a row, each at its place in its log."""
        table = np.zeros((owners, int(np.max(lengths[block]))))
        table[owner, of - logs.starts[logs.log[of]]] = values
        return table

    compared = ((first < logs.current) | (second < logs.current)) & ~np.isin(pair, logs.exempt)
    shared = count(common[row] > 0)
    p_spins = tails(laid_out(common[rows], rows, logs.log[rows] - block[0], len(block)))[first - block[0], shared]
    enough = shared > np.maximum(MOST_SPINS * np.minimum(telling[first], telling[second]), FEWEST)
    rare = chance <= TELLING
    alike = count(agree & rare)
    least = np.exp(np.bincount(at, (agree & rare) * np.log(np.maximum(chance, LEAST)), len(pair)))
    close = (alike >= FEWEST) & (p_spins * least <= allowed)
    uncommon = p_spins <= np.where(close, 1 - _EXACT, allowed)
    for one in np.flatnonzero(compared & uncommon & (close | enough)).tolist():
        of_pair = row[at == one]
        if _is_habit(logs, of_pair[common[of_pair] > 0]):
            p_spins[one] = 1.0
    copied = np.flatnonzero(compared & close)
    place = np.full(len(pair), -1)
    place[copied] = np.arange(len(copied))
    rare &= place[at] >= 0
    p = tails(laid_out(chance[rare], row[rare], place[at[rare]], len(copied)))[np.arange(len(copied)), alike[copied]]
    # If rows alone do not tell, how rare their spins are does: the chance of such a product (R. A. Fisher).
    both = np.maximum(p * p_spins[copied], LEAST)
    p = np.maximum(np.where(p <= allowed, p, both * (1 - np.log(both))), LEAST)
    in_spins = compared & enough & (p_spins <= allowed)
    return (pair[copied][p <= allowed], p[p <= allowed]), (pair[in_spins], p_spins[in_spins])


def _crowd(logs: Logs, rows: Integers, mine: Integers, other: Integers) -> Floats:
    """Give, for each of the rows, the share of the logs that have it and are otherwise not alike.

    This is for an example left in, a row for everybody. `mine`, `other`: rows that are the same.
    """
    row, log = np.divmod(np.unique(mine * len(logs.keys) + logs.log[other]), len(logs.keys))
    _, pair, alike = np.unique(logs.log[row] * len(logs.keys) + log, return_inverse=True, return_counts=True)
    strangers = 2 * alike[pair] < np.diff(logs.starts)[logs.log[row]]
    # One other log is not enough: it may be the log of a student who copied a few rows.
    crowd = np.bincount(row - rows[0], strangers, len(rows)) - 1
    return np.maximum(crowd, 0) / max(len(logs.keys) - 2, 1)


def _is_habit(logs: Logs, rows: Integers) -> bool:
    """Tell whether more logs have the spins of these rows than copy from each other."""
    mine, other = _same_spins(logs, rows, logs.spin_step)
    others = np.bincount(np.unique(mine * len(logs.keys) + logs.log[other]) % len(logs.keys))
    return 1 + int(np.sum(others > MOST_SPINS * len(rows))) > max(HABIT, HABIT_SHARE * len(logs.keys))


def _chance(logs: Logs, mine: Integers, other: Integers) -> Floats:
    """Give the chance that two hands that time the same spin stop at the same digit, row by row."""
    step = np.maximum(logs.period_step[mine], logs.period_step[other]) + 2 * _EXACT * logs.period[mine]
    spread = np.hypot(logs.noise[mine], logs.noise[other])
    # No window of this width contains more of a normal distribution, wherever its centre is.
    return step / np.maximum(math.sqrt(2 * math.pi) * spread, step)


# --- two logs side by side ----------------------------------------------------------------------------------


class Beside(NamedTuple):
    """A row of each of two logs, counted from 0; None where a log has none left."""

    first: int | None
    second: int | None
    same_spin: bool = False
    same_period: bool = False


def put_beside(first: Fingerprint, second: Fingerprint) -> list[Beside]:
    """Match the rows of two logs, the most similar first, in any order, unit and number of digits."""

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
