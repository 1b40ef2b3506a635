"""A flag: something in one log, or between several, that honest work hardly ever does.

Here: how chances become flags, and what is odd in one log by itself. `copies` and `edits` compare logs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple, get_args

from msgspec import Struct

from gyrodata.grading.forensics.logs import HAND, Logs

Kind = Literal["shared rows", "shifted or scaled", "same spins", "scatter"]

KINDS: tuple[Kind, ...] = get_args(Kind)
"""In the order in which they are listed."""

ALLOWED = 0.05
"""Flags of one kind that a class of honest students gets by chance, at most; the thresholds follow from it."""

LEAST = 1e-300  # where products of small chances end; none is nought


class Flag(Struct, frozen=True):
    """What was found, and how often honest students would show it."""

    kind: Kind
    students: tuple[str, ...]  # their keys, sorted
    evidence: str  # in words, with the numbers
    p: float
    """Chance of it, or of more, in one honest log or between two; of the strongest pair where there are several."""
    expected: float  # how many such flags, as strong as this or stronger, chance makes in an honest class of this size
    previous: tuple[str, ...] = ()  # keys of earlier logs that it is about, sorted
    pairs: tuple[tuple[str, str], ...] = ()  # what joins all of them, the strongest first; each pair brings in a log


def chi2_lower_tail(chi2: float, dof: float) -> float:
    """Probability of a chi-square at most this large.

    Gives: P(dof/2, chi2/2), the regularised lower incomplete gamma function, by its series (DLMF 8.11.4), which keeps
    all digits of a tiny probability.
    """
    if chi2 <= 0:
        return 0.0
    order, half = dof / 2, chi2 / 2
    term = total = 1.0
    step = order
    while term > 1e-16 * total:
        step += 1
        term *= half / step
        total += term
    return min(1.0, math.exp(order * math.log(half) - half - math.lgamma(order + 1)) * total)


# --- pairs of logs that are too much alike ------------------------------------------------------------------


PAIRS_TOLD = 3  # pairs of a group whose evidence is told


class Pair(NamedTuple):
    """Two logs that are too much alike, by their numbers in the class."""

    p: float
    expected: float
    first: int
    second: int


class Groups:
    """Logs that hang together by what was found so far; other pairs of them need no finding."""

    def __init__(self) -> None:
        self._above: dict[int, int] = {}

    def head(self, log: int) -> int:
        """Give the log that stands for all that hang together with one."""
        while (above := self._above.setdefault(log, log)) != log:
            self._above[log] = self._above[above]
            log = above
        return log

    def join(self, first: int, second: int) -> bool:
        """Let two logs hang together; tell whether they did not before."""
        new = not self.joined(first, second)
        self._above[self.head(second)] = self.head(first)
        return new

    def joined(self, first: int, second: int) -> bool:
        """Tell whether two logs hang together."""
        return self.head(first) == self.head(second)


def flag_pairs(kind: Kind, pairs: Iterable[Pair], logs: Logs, tell: Callable[[int, int], str]) -> list[Flag]:
    """Make one flag of all pairs that hang together, told in words: five copies of one log are one finding, not ten."""
    together = Groups()
    ordered = sorted(pairs)
    for pair in ordered:
        together.join(pair.first, pair.second)
    groups: dict[int, list[Pair]] = {}
    for pair in ordered:
        groups.setdefault(together.head(pair.first), []).append(pair)
    return [_one_flag(kind, group, logs, tell) for group in groups.values()]


def _one_flag(kind: Kind, group: list[Pair], logs: Logs, tell: Callable[[int, int], str]) -> Flag:
    """Make a flag of pairs in the order of their p, the strongest told in words."""
    together = Groups()
    members = sorted({member for pair in group for member in (pair.first, pair.second)})
    evidence = "; ".join(tell(pair.first, pair.second) for pair in group[:PAIRS_TOLD])
    more = len(group) - PAIRS_TOLD
    return Flag(
        kind,
        tuple(logs.keys[member] for member in members if member < logs.current),
        evidence + (f"; and {more} more like these" if more > 0 else ""),
        max(group[0].p, LEAST),
        max(group[0].expected, LEAST),
        tuple(logs.keys[member] for member in members if member >= logs.current),
        tuple((logs.keys[one], logs.keys[other]) for _, _, one, other in group if together.join(one, other)),
    )


# --- one log by itself: scatter below what a hand can do --------------------------------------------------


def flag_scatter(logs: Logs) -> list[Flag]:
    """Find logs whose times lie closer to straight lines than a hand can put them."""
    flags = []
    timed = [i for i in range(logs.current) if logs.by_hand[i] and logs.dof[i]]
    for i in timed:
        p = chi2_lower_tail(float(logs.squares[i]) / HAND**2, int(logs.dof[i]))
        if p * len(timed) <= ALLOWED:
            scatter = logs.scatter(i)
            evidence = (
                f"its {len(scatter.residuals)} times lie within {scatter.size:.2g} s of straight lines in the spin, "
                f"one for each torque ({scatter.dof} degrees of freedom); a hand on a stopwatch scatters by {HAND:g} s "
                "or more"
            )
            flags.append(Flag("scatter", (logs.keys[i],), evidence, p, p * len(timed)))
    return flags
