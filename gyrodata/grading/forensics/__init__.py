"""Flags, never verdicts: what in a class's logs honest work hardly ever shows, with how often it would.

A fingerprint of each log is kept (`logs`), and all are compared at once (`flag_class`):

* rows in common, in any order, unit and rounding (`copies`);
* the same spins at the same weights, whatever became of the times (`copies`);
* scatter below what a hand can do (`flags`).

Every threshold follows from one number, `ALLOWED`: the flags of one kind that a class of honest students gets by
chance. Every flag says how many as strong as itself chance makes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from gyrodata.grading.forensics.copies import Beside, flag_copies, put_beside
from gyrodata.grading.forensics.flags import ALLOWED, KINDS, Flag, flag_scatter
from gyrodata.grading.forensics.logs import Fingerprint, fingerprint, lay_out

__all__ = ["ALLOWED", "KINDS", "Beside", "Fingerprint", "Flag", "fingerprint", "flag_class", "put_beside"]

_NOTHING: Mapping[str, Fingerprint] = MappingProxyType({})


def flag_class(
    prints: Mapping[str, Fingerprint],
    partners: Iterable[frozenset[str]] = (),
    previous: Mapping[str, Fingerprint] = _NOTHING,
) -> tuple[Flag, ...]:
    """Find what is odd in a class's logs.

    `prints`: One log of each student, by the student's key. `partners`: Students who hand in the same data; one may be
    in several groups. `previous`: Earlier logs and published examples, by a key of their own; compared with the
    class's, not with each other. Gives: By kind, in the order of `KINDS`, then by students. Logs that one kind joins
    are not joined again by the next, and many copies of one log are one flag.
    """
    logs = lay_out(prints, partners, previous)
    flags = flag_scatter(logs) + (flag_copies(logs) if logs.pairs > 0 else [])
    return tuple(sorted(flags, key=lambda flag: (KINDS.index(flag.kind), flag.students, flag.previous)))
