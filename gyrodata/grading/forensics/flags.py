"""A flag: something in one log, or between several, that honest work hardly ever does.

Here: how chances become flags, and what is odd in one log by itself. `copies` compares logs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Literal, get_args

from msgspec import Struct

from gyrodata.fitting import chi2_lower_tail
from gyrodata.grading.forensics.logs import HAND, Logs

Kind = Literal["shared rows", "same spins", "scatter"]

KINDS: tuple[Kind, ...] = get_args(Kind)
"""In the order in which they are listed."""

ALLOWED = 0.05
"""Flags of one kind that a class of honest students gets by chance, at most; the thresholds follow from it."""

LEAST = 1e-300  # where products of small chances end; none is nought


class Flag(Struct, frozen=True):
    """A finding, and how often it would occur among honest students."""

    kind: Kind
    students: tuple[str, ...]  # their keys, sorted
    evidence: str  # in words, with the numbers
    p: float
    """Chance of it, or of more, in one honest log or between two; of the strongest pair where there are several."""
    expected: float  # how many such flags, as strong as this or stronger, chance makes in an honest class of this size
    previous: tuple[str, ...] = ()  # keys of earlier logs that it is about, sorted
    pairs: tuple[tuple[str, str], ...] = ()  # what joins all of them, the strongest first; each pair brings in a log


# --- pairs of logs that are too much alike ------------------------------------------------------------------


PAIRS_TOLD = 3  # pairs of a group whose evidence is told


def flag_pairs(
    kind: Kind, pairs: Iterable[tuple[float, int, int]], logs: Logs, tell: Callable[[Logs, int, int], str]
) -> tuple[list[Flag], list[int]]:
    """Make one flag of all pairs that hang together: five copies of one log are one finding, not ten.

    `pairs`: Chance and numbers of two logs. Gives: The flags, and for each log the one that stands for all that hang
    together with it.
    """
    head = list(range(len(logs.keys)))
    ordered, joining = sorted(pairs), []
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
        flags.append(
            Flag(
                kind,
                tuple(logs.keys[member] for member in members if member < logs.current),
                "; ".join(told),
                found[0][0],
                found[0][0] * logs.pairs,
                tuple(logs.keys[member] for member in members if member >= logs.current),
                tuple((logs.keys[one], logs.keys[other]) for one, other in joining if head[one] == group),
            )
        )
    return flags, head


# --- one log by itself: scatter below what a hand can do --------------------------------------------------


def flag_scatter(logs: Logs) -> list[Flag]:
    """Find logs whose times lie closer to straight lines than a hand can put them."""
    flags = []
    both = enumerate(zip(logs.prints, logs.scatters, strict=True))
    timed = [(i, scatter) for i, (log, scatter) in both if i < logs.current and log.by_hand and scatter is not None]
    for i, scatter in timed:
        # Half of all chi-squares are below their mean, or more; that is never rare.
        p = chi2_lower_tail(scatter.squares / HAND**2, scatter.dof) if scatter.size < HAND else 1.0
        if p * len(timed) <= ALLOWED:
            evidence = (
                f"its {scatter.times} times lie within {scatter.size:.2g} s of straight lines in the spin, "
                f"one for each torque ({scatter.dof} degrees of freedom); a hand on a stopwatch scatters by {HAND:g} s "
                "or more"
            )
            flags.append(Flag("scatter", (logs.keys[i],), evidence, p, p * len(timed)))
    return flags
