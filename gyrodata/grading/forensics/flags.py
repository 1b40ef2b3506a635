"""A flag: something in one log, or between several, that honest work hardly ever does. Never a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

Kind = Literal["shared rows", "shifted or scaled", "residuals", "scatter", "repeats", "digits"]

KINDS: tuple[Kind, ...] = ("shared rows", "shifted or scaled", "residuals", "scatter", "repeats", "digits")
"""In the order in which they are listed."""

ALLOWED = 0.05
"""Flags of one kind that a class of honest students gets by chance, at most; the thresholds follow from it."""

PAIRS_TOLD = 3
"""Pairs of a group whose evidence is told."""

LEAST = 1e-300
"""Where products of small chances end; none is nought."""


@dataclass(frozen=True, slots=True)
class Flag:
    """What was found, and how often honest students would show it."""

    kind: Kind
    students: tuple[str, ...]
    """Their keys, sorted."""
    evidence: str
    """In words, with the numbers."""
    p: float
    """Chance of it, or of more, in one honest log or between two; of the strongest pair where there are several."""
    expected: float
    """How many such flags, as strong as this or stronger, chance makes in an honest class of this size."""
    previous: tuple[str, ...] = ()
    """Keys of earlier logs that it is about, sorted."""


class Pair(NamedTuple):
    """Two logs that are too much alike, by their numbers in the class."""

    p: float
    expected: float
    first: int
    second: int


def flag_pairs(
    kind: Kind, pairs: Iterable[Pair], keys: Sequence[str], current: int, tell: Callable[[Pair], str]
) -> list[Flag]:
    """Make one flag of all pairs that hang together: five copies of one log are one finding, not ten.

    Parameters
    ----------
    kind : str
        Of the flags.
    pairs : iterable of Pair
        In any order.
    keys : sequence of str
        Of every log.
    current : int
        How many of them are of this class; the others are earlier ones.
    tell : callable
        The evidence of one pair in words.

    Returns
    -------
    list of Flag
    """
    parent: dict[int, int] = {}

    def root(member: int) -> int:
        while (above := parent.setdefault(member, member)) != member:
            parent[member] = parent[above]
            member = above
        return member

    ordered = sorted(pairs)
    for pair in ordered:
        parent[root(pair.second)] = root(pair.first)
    groups: dict[int, list[Pair]] = {}
    for pair in ordered:
        groups.setdefault(root(pair.first), []).append(pair)
    return [_one_flag(kind, group, keys, current, tell) for group in groups.values()]


def _one_flag(kind: Kind, group: list[Pair], keys: Sequence[str], current: int, tell: Callable[[Pair], str]) -> Flag:
    """Make a flag of pairs in the order of their p, the strongest told in words."""
    members = sorted({member for pair in group for member in (pair.first, pair.second)})
    evidence = "; ".join(tell(pair) for pair in group[:PAIRS_TOLD])
    more = len(group) - PAIRS_TOLD
    return Flag(
        kind,
        tuple(keys[member] for member in members if member < current),
        evidence + (f"; and {more} more pair{'s' if more > 1 else ''}" if more > 0 else ""),
        max(group[0].p, LEAST),
        max(group[0].expected, LEAST),
        tuple(keys[member] for member in members if member >= current),
    )
