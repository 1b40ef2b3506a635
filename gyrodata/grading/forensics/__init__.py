"""Find logs that look copied or invented: flags are questions to a person, never verdicts.

A fingerprint of each log is kept (`logs`), and all logs are compared at once (`flag_class`):

* rows in common, in any order, unit and rounding (`copies`);
* the same spins at the same weights, whatever the times are (`copies`);
* scatter below what a hand can do (`flags`).

Every threshold follows from one number, `ALLOWED`: the expected number of flags of one kind in a class of honest
students. Each flag contains the number of equally strong flags that are expected by chance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from gyrodata.grading.forensics.copies import Beside, flag_copies, put_beside
from gyrodata.grading.forensics.flags import ALLOWED, KINDS, Flag, flag_scatter
from gyrodata.grading.forensics.logs import Fingerprint, Logs, fingerprint

__all__ = ["ALLOWED", "KINDS", "Beside", "Fingerprint", "Flag", "fingerprint", "flag_class", "put_beside"]

_NOTHING: Mapping[str, Fingerprint] = MappingProxyType({})


def flag_class(
    prints: Mapping[str, Fingerprint],
    partners: Iterable[frozenset[str]] = (),
    previous: Mapping[str, Fingerprint] = _NOTHING,
) -> tuple[Flag, ...]:
    """Compare the logs of a class, and return the flags by kind, in the order of `KINDS`, then by students.

    `prints`: One log of each student, by the student's key. `partners`: Students who hand in the same data; a student
    may be in several groups. `previous`: Earlier logs and published examples, by keys of their own; they are compared
    with the logs of the class, not with each other. Logs that are joined by one kind are not joined again by the next
    kind, and many copies of one log are one flag.
    """
    logs = Logs(prints, partners, previous)
    flags = flag_scatter(logs) + (flag_copies(logs) if logs.pairs > 0 else [])
    return tuple(sorted(flags, key=lambda flag: (KINDS.index(flag.kind), flag.students, flag.previous)))
