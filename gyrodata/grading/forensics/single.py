"""What is odd in one log by itself: scatter and repeats below what a hand can do, last digits not left to chance."""

from __future__ import annotations

import math
from collections.abc import Iterable

from gyrodata.fitting import chi2_tail
from gyrodata.grading.forensics.flags import ALLOWED, Flag, chi2_lower_tail
from gyrodata.grading.forensics.logs import HAND, Fingerprint, Logs


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
