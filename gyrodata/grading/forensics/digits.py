"""Last digits: a stopwatch leaves them to chance, a head does not."""

from __future__ import annotations

from collections.abc import Iterable

from gyrodata.fitting import chi2_tail
from gyrodata.grading.forensics.fingerprint import Fingerprint
from gyrodata.grading.forensics.flags import ALLOWED, Flag

FEWEST = 30
"""Times that a log must have before its last digits are looked at."""

HEAVIER = 4.0
"""How much more often than the chi-square distribution says 30 digits give a chi-square as rare as 1 in 100 000:
3.7 times by simulation, and less for more digits or more common values."""


def flag_digits(prints: Iterable[tuple[str, Fingerprint]]) -> list[Flag]:
    """Find logs whose stopwatch times end in some digits too often.

    Chi-square of ten equally likely digits with 9 degrees of freedom: the terminal-digit test of J. H. Pitt and H. Z.
    Hill, "Statistical detection of potentially fabricated numerical data".
    """
    found = {student: one.digits for student, one in prints if sum(one.digits) >= FEWEST}
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
