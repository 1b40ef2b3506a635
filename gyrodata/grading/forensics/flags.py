"""A flag: something in one log, or between several, that honest work hardly ever does.

Here: how chances become flags, and what is odd in one log by itself. `copies` and `edits` compare logs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple

from gyrodata.fitting import chi2_tail
from gyrodata.grading.forensics.logs import HAND, Fingerprint, Logs

Kind = Literal["shared rows", "shifted or scaled", "residuals", "scatter", "repeats", "digits"]

KINDS: tuple[Kind, ...] = ("shared rows", "shifted or scaled", "residuals", "scatter", "repeats", "digits")
"""In the order in which they are listed."""

ALLOWED = 0.05
"""Flags of one kind that a class of honest students gets by chance, at most; the thresholds follow from it."""

LEAST = 1e-300  # where products of small chances end; none is nought


@dataclass(frozen=True, slots=True)
class Flag:
    """What was found, and how often honest students would show it."""

    kind: Kind
    students: tuple[str, ...]  # their keys, sorted
    evidence: str  # in words, with the numbers
    p: float
    """Chance of it, or of more, in one honest log or between two; of the strongest pair where there are several."""
    expected: float  # how many such flags, as strong as this or stronger, chance makes in an honest class of this size
    previous: tuple[str, ...] = ()  # keys of earlier logs that it is about, sorted


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

    def join(self, first: int, second: int) -> None:
        """Let two logs hang together."""
        self._above[self.head(second)] = self.head(first)

    def joined(self, first: int, second: int) -> bool:
        """Tell whether two logs hang together."""
        return self.head(first) == self.head(second)


def flag_pairs(kind: Kind, pairs: Iterable[Pair], logs: Logs, tell: Callable[[Logs, Pair], str]) -> list[Flag]:
    """Make one flag of all pairs that hang together: five copies of one log are one finding, not ten."""
    together = Groups()
    ordered = sorted(pairs)
    for pair in ordered:
        together.join(pair.first, pair.second)
    groups: dict[int, list[Pair]] = {}
    for pair in ordered:
        groups.setdefault(together.head(pair.first), []).append(pair)
    return [_one_flag(kind, group, logs, tell) for group in groups.values()]


def _one_flag(kind: Kind, group: list[Pair], logs: Logs, tell: Callable[[Logs, Pair], str]) -> Flag:
    """Make a flag of pairs in the order of their p, the strongest told in words."""
    members = sorted({member for pair in group for member in (pair.first, pair.second)})
    evidence = "; ".join(tell(logs, pair) for pair in group[:PAIRS_TOLD])
    more = len(group) - PAIRS_TOLD
    return Flag(
        kind,
        tuple(logs.keys[member] for member in members if member < logs.current),
        evidence + (f"; and {more} more like these" if more > 0 else ""),
        max(group[0].p, LEAST),
        max(group[0].expected, LEAST),
        tuple(logs.keys[member] for member in members if member >= logs.current),
    )


# --- one log by itself: scatter and repeats below what a hand can do --------------------------------------


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


def flag_repeats(prints: Iterable[tuple[str, Fingerprint]]) -> list[Flag]:
    """Find logs whose repeats of one setting are more alike than a hand can make them."""
    measured = ((student, _repeats(one)) for student, one in prints if one.by_hand)
    found = {student: (dof, squares) for student, (dof, squares) in measured if dof > 0}
    flags = []
    for student, (dof, squares) in found.items():
        p = chi2_lower_tail(squares / HAND**2, dof)
        if p * len(found) <= ALLOWED:
            evidence = (
                f"its repeats of one setting scatter by {math.sqrt(squares / dof):.2g} s ({dof} degrees of freedom); "
                f"a hand on a stopwatch scatters by {HAND:g} s or more"
            )
            flags.append(Flag("repeats", (student,), evidence, p, p * len(found)))
    return flags


def _repeats(one: Fingerprint) -> tuple[int, float]:
    """Degrees of freedom and sum of squares [s²] among rows of equal torque, spin and turns."""
    settings: dict[tuple[float, float, float], list[int]] = {}
    for i, setting in enumerate(zip(one.torque, one.spin, one.turns, strict=True)):
        settings.setdefault(setting, []).append(i)
    dof, squares = 0, 0.0
    for rows in settings.values():
        more = len(rows) - 1
        if more:
            mean = math.fsum(one.time[i] for i in rows) / len(rows)
            hidden = math.fsum(one.time_step[i] ** 2 for i in rows) / len(rows) / 12
            dof += more
            squares += math.fsum((one.time[i] - mean) ** 2 for i in rows) + more * hidden
    return dof, squares


# --- last digits: a stopwatch leaves them to chance, a head does not ----------------------------------------


FEWEST_DIGITS = 30  # times that a log must have before its last digits are looked at

HEAVIER = 4.0
"""How much more often than the chi-square distribution says 30 digits give a chi-square as rare as 1 in 100 000:
3.7 times by simulation, and less for more digits or more common values."""


def flag_digits(prints: Iterable[tuple[str, Fingerprint]]) -> list[Flag]:
    """Find logs whose stopwatch times end in some digits too often.

    Chi-square of ten equally likely digits with 9 degrees of freedom: the terminal-digit test of J. H. Pitt and H. Z.
    Hill, "Statistical detection of potentially fabricated numerical data".
    """
    found = {student: one.digits for student, one in prints if sum(one.digits) >= FEWEST_DIGITS}
    flags = []
    for student, counts in found.items():
        total = sum(counts)
        chi2 = sum((count - total / 10) ** 2 for count in counts) / (total / 10)
        p = min(1.0, HEAVIER * chi2_tail(chi2, 9))
        if p * len(found) <= ALLOWED:
            listed = " ".join(str(count) for count in counts)
            evidence = (
                f"the last digits 0 to 9 of its {total} times stand {listed} times; 0 and 5 are "
                f"{100 * (counts[0] + counts[5]) / total:.0f} % of them, where chance makes 20 %"
            )
            flags.append(Flag("digits", (student,), evidence, p, p * len(found)))
    return flags
