"""Pairs of logs that are too much alike, and the flags that come of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from gyrodata.grading.forensics.flags import LEAST, Flag, Kind
from gyrodata.grading.forensics.logs import Logs

PAIRS_TOLD = 3
"""Pairs of a group whose evidence is told."""


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
