"""Flags: something in one log, or between several logs, that is rare in honest work."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, get_args

from msgspec import Struct

from gyrodata.fitting import chi2_lower_tail
from gyrodata.grading.forensics.logs import HAND, Logs

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
