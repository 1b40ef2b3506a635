"""Scatter below what a hand can do: about straight lines in the spin, and among repeats of one setting."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gyrodata.grading.forensics.fingerprint import Fingerprint
from gyrodata.grading.forensics.flags import ALLOWED, Flag
from gyrodata.physics import Floats

if TYPE_CHECKING:
    from gyrodata.grading.forensics.logs import Logs

HAND = 0.05
"""Standard deviation of an interval between two clicks of a good hand on a stopwatch [s]; most scatter more.

What a log states as its `u_time` plays no part: with one that is stated too large, a small chi-square is no sign."""


@dataclass(frozen=True, slots=True)
class Scatter:
    """What the spin leaves unexplained in one log's times."""

    residuals: Floats
    """Time minus the straight line in the spin of its torque [s], shape (n,)."""
    dof: int
    """n minus one slope for each torque minus the shared timing bias."""
    squares: float
    """Sum of the residuals' squares, with what rounding may have hidden [s²]."""

    @property
    def size(self) -> float:
        """Standard deviation of one time [s]."""
        return math.sqrt(self.squares / self.dof)


def measure_scatter(one: Fingerprint) -> Scatter | None:
    """Take out of a log's times what spin, torque and timing bias explain.

    Gives: None with less than one degree of freedom.

    T = a f ψ̇ + b with a slope a for each torque: eq. (9) with any I_zz, balance, weights, ruler and tachometer scale.
    Whatever else moves the times only adds to the scatter.
    """
    torque, lever = np.array(one.torque), np.array(one.turns) * np.array(one.spin)
    time, step = np.array(one.time), np.array(one.time_step)
    of_torque = (torque[:, None] == np.unique(torque)).astype(float)
    design = np.column_stack([of_torque * lever[:, None] / lever.max(), np.ones(len(time))])
    solution, _, rank, _ = np.linalg.lstsq(design, time, rcond=1e-9)
    dof = len(time) - int(rank)
    if dof < 1:
        return None
    residuals = time - design @ solution
    return Scatter(residuals, dof, float(residuals @ residuals) + dof * float(np.mean(step**2)) / 12)


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
