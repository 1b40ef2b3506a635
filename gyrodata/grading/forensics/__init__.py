"""Flags, never verdicts: what in a class's logs honest work hardly ever shows, with how often it would.

A fingerprint of each log is kept (`logs`), and all are compared at once (`flag_class`):

* rows in common, in any order, unit and rounding (`copies`);
* times shifted or scaled as a whole, and residuals that come back (`edits`);
* scatter and repeats below what a hand can do (`single`);
* last digits that are not left to chance (`single`).

Every threshold follows from one number, `ALLOWED`: the flags of one kind that a class of honest students gets by
chance. Every flag says how many as strong as itself chance makes.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from gyrodata.grading.forensics.copies import flag_shared_rows
from gyrodata.grading.forensics.edits import flag_residuals, flag_shifted_or_scaled
from gyrodata.grading.forensics.exemptions import Exemptions, read_exemptions
from gyrodata.grading.forensics.flags import ALLOWED, KINDS, Flag, Groups
from gyrodata.grading.forensics.logs import Fingerprint, fingerprint, lay_out
from gyrodata.grading.forensics.single import flag_digits, flag_repeats, flag_scatter

__all__ = [
    "ALLOWED",
    "KINDS",
    "Exemptions",
    "Fingerprint",
    "Flag",
    "fingerprint",
    "flag_class",
    "read_exemptions",
]

_NOTHING: Mapping[str, Fingerprint] = MappingProxyType({})


def flag_class(
    prints: Mapping[str, Fingerprint],
    exempt: Exemptions | None = None,
    previous: Mapping[str, Fingerprint] = _NOTHING,
) -> tuple[Flag, ...]:
    """Find what is odd in a class's logs.

    `prints`: One log of each student, by the student's key. `exempt`:
    Partners, whose logs may be alike, and staff, whose logs are left out. `previous`: Earlier logs and published
    examples, by a key of their own; compared with the class's, not with each other. Gives: By kind, in the order of
    `KINDS`, then by students. Logs that one kind joins are not joined again by the next, and many copies of one log are
    one flag.
    """
    exempt = exempt or Exemptions()
    judged = [student for student in sorted(prints) if student not in exempt.staff]
    logs = lay_out(judged, prints, exempt, previous)
    groups = Groups()
    flags = flag_shared_rows(logs, groups) + flag_shifted_or_scaled(logs, groups) + flag_residuals(logs, groups)
    flags += flag_scatter(logs)
    flags += flag_repeats((student, prints[student]) for student in judged)
    flags += flag_digits((student, prints[student]) for student in judged)
    return tuple(sorted(flags, key=lambda flag: (KINDS.index(flag.kind), flag.students, flag.previous)))
