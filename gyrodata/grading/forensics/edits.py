"""Tables that are one table edited: all times shifted or scaled.

Whatever two students share (station, weights, ruler, spins aimed at, a habit) makes their tables alike, but the
scatter of two hands stays between them: the squares of what is left add up to a chi-square at least, however much
else is shared. A sum far below that says that the scatter itself was taken over.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np

from gyrodata.grading.forensics.flags import ALLOWED, Flag, Groups, Pair, chi2_lower_tail, flag_pairs
from gyrodata.grading.forensics.logs import TRUSTED_DOF, Logs
from gyrodata.physics import Floats, Integers

BLOCK = 100  # logs that are compared with all others at a time, at most

CELLS = 40_000  # pairs that are compared at a time: what they take in memory does not grow with the class

SPREAD = 20.0
"""The times of a log must differ by this many times the scatter of a hand for their scale to have a meaning."""

HALVINGS = 200  # of the interval in which a limit lies; enough for every digit of a small one


def flag_shifted_or_scaled(logs: Logs, groups: Groups) -> list[Flag]:
    """Find logs whose times are those of another log, times a factor, plus a shift.

    `logs`: The class; rows are compared in the order of torque and spin.

    The least sum of squared distances from a line, over the variance of one time, is a chi-square with n − 2 degrees of
    freedom where two tables agree but for a factor, a shift and the scatter of both hands, and larger where they do
    not.
    """
    sizes = np.unique(np.diff(logs.starts)).tolist()
    tables = [_times_of(logs, size) for size in sizes if size - 2 >= TRUSTED_DOF]
    tests = sum(_tests(logs, members) for members, _ in tables)
    pairs = []
    for members, times in tables:
        dof = times.shape[1] - 2
        for chi2, first, second in _nearest(logs, members, times, _limit(dof, ALLOWED / max(tests, 1)), groups):
            if groups.joined(first, second) or not logs.compared_with(first, np.array([second]))[0]:
                continue
            p = chi2_lower_tail(chi2, dof)
            if p * tests <= ALLOWED:
                pairs.append(Pair(p, p * tests, first, second))
                groups.join(first, second)
    return flag_pairs("shifted or scaled", pairs, logs, partial(_tell_line, logs))


def _times_of(logs: Logs, size: int) -> tuple[Integers, Floats]:
    """Logs with n rows whose times have a scale, shape (G,), and those times about their mean [s], shape (G, n)."""
    members = np.flatnonzero((np.diff(logs.starts) == size) & (logs.noise > 0))
    times = np.array([logs.prints[log].time for log in members.tolist()]).reshape(len(members), size)
    times -= times.mean(axis=1, keepdims=True)
    spread = times.std(axis=1) > SPREAD * logs.noise[members]
    return members[spread], times[spread]


def _tests(logs: Logs, members: Integers) -> int:
    """Count the pairs within the class and with earlier logs."""
    current = int(np.sum(members < logs.current))
    return current * (current - 1) // 2 + current * (len(members) - current)


def _nearest(
    logs: Logs, members: Integers, times: Floats, limit: float, groups: Groups
) -> Iterator[tuple[float, int, int]]:
    """Chi-square and numbers of the pairs that are near enough to be told and do not hang together yet."""
    if len(members) < 2:
        return
    noise, step = logs.noise[members], logs.time_step[members]
    heads = np.array([groups.head(log) for log in members.tolist()])
    # Times of one shape are near each other along any direction: only those near along the one that tells most apart
    # are compared, so that a hundred thousand logs are not ten thousand million pairs.
    length = np.linalg.norm(times, axis=1)
    shapes = times / length[:, None]
    along = shapes @ np.linalg.eigh(np.cov(shapes.T))[1][:, -1]
    reach = 2 * math.sqrt(limit) * float(np.max(noise / length)) + 1e-9
    order = np.argsort(along, kind="stable")
    along = along[order]
    found: list[tuple[int, int, float]] = []
    begin = 0
    while begin < len(order):
        width = int(np.searchsorted(along, along[begin] + reach, side="right")) - begin
        end = min(begin + min(BLOCK, max(4, CELLS // width)), len(order))
        block, near = order[begin:end], order[begin : np.searchsorted(along, along[end - 1] + reach, side="right")]
        # What a last digit hides: step²/12 for each square.
        hidden = np.maximum(step[block, None], step[near]) ** 2 * (times.shape[1] - 2) / 12
        chi2 = (_from_a_line(times[block], times[near]) + hidden) / np.minimum(noise[block, None], noise[near]) ** 2
        for i, j in np.argwhere((chi2 <= limit) & (heads[block, None] != heads[near])).tolist():
            if i < j:
                one, other = int(block[i]), int(near[j])
                found.append((min(one, other), max(one, other), float(chi2[i, j])))
        begin = end
    for i, j, least in sorted(found):
        if members[i] < logs.current:
            yield least, int(members[i]), int(members[j])


def _from_a_line(some: Floats, others: Floats) -> Floats:
    """Least sum of squared distances of the points (x, y) from a rising line through their centre, shape (b, G)."""
    own, theirs = np.sum(some**2, axis=1)[:, None], np.sum(others**2, axis=1)
    both = some @ others.T
    least = 0.5 * (own + theirs - np.hypot(own - theirs, 2 * both))
    return np.where(both > 0, np.maximum(least, 0.0), np.inf)


def _limit(dof: int, p: float) -> float:
    """Chi-square whose lower tail is p, by halving; rounded up."""
    low, high = 0.0, float(dof)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if chi2_lower_tail(middle, dof) < p else (low, middle)
    return high


def _tell_line(logs: Logs, first: int, second: int) -> str:
    x, y = (np.array(logs.prints[log].time) for log in (first, second))
    dx, dy = x - x.mean(), y - y.mean()
    xx, yy, xy = float(dx @ dx), float(dy @ dy), float(dx @ dy)
    factor = (yy - xx + math.hypot(yy - xx, 2 * xy)) / (2 * xy)
    shift = float(y.mean() - factor * x.mean())
    size = float(np.sqrt(np.mean((y - factor * x - shift) ** 2)))
    hands = math.hypot(1, factor) * float(min(logs.noise[first], logs.noise[second]))
    one, other = logs.keys[first], logs.keys[second]
    return (
        f"the {len(x)} times of {other} are {factor:.4g} times those of {one} {'-' if shift < 0 else '+'} "
        f"{abs(shift):.2f} s, to {size:.2g} s (rms); two hands on a stopwatch would leave {hands:.2g} s or more"
    )
