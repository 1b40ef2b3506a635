"""Compare all logs of a class: rows that two logs share, and spins that two logs share.

The question is how often two honest logs would agree as much as two given logs do. For each row of a log there are two
probabilities:

* that another log has the same spin at the same weight: the share of the logs that have it. Round spins do not count,
  because many students aim at them;
* that another log also has the same period. Two people who time the same spin seldom stop at the same hundredth of a
  second; the probability follows from the scatter of a hand and from the last digit.

The number of rows that agree by chance then has the distribution of a sum of independent events. Each pair is judged
from both of its logs, and the larger probability counts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.grading.forensics.flags import ALLOWED, LEAST, Flag, flag_pairs
from gyrodata.grading.forensics.logs import Fingerprint, Logs
from gyrodata.physics import RPM, Floats, Integers

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
