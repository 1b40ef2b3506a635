"""Known slips: a reported I_zz that would be right without one common mistake, found by the factor that it leaves.

Each mistake is applied to the student's own readings, and the accepted fits are computed again. If the reported value
then agrees, the mistake is named. Mistakes with nearly the same factor (no g: 9.81, rpm as rad/s: 9.55) explain it
equally well, and all are named. No mistake is searched for if the runs explain the report. A mistake whose result is
among the results of honest fits cannot be detected, and is not named.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.diagnostics import LOG_CONTRADICTS_RIGHT_ANSWER
from gyrodata.errors import Diagnostic
from gyrodata.grading.yardsticks import OwnRuns, OwnValue, distance, nearest
from gyrodata.measurements import Measurements
from gyrodata.mistakes import SIZES, Mistake, known_mistakes, list_mistakes
from gyrodata.physics import RPM, Floats
from gyrodata.readings import Column, Reading, Readings

FROM = 3.0  # no slip is searched for if an accepted fit is nearer than this [u]

WITHIN, BOTH_WITHIN = 2.0, 1.0
"""Largest distance from the report [u] at which one mistake, or two together, explain it. There are many pairs, and
one of them agrees by chance more easily."""

NEAREST = 0.015  # largest relative distance, even if u is larger: 60 instead of 57.3 are two slips

AS_GOOD = 0.5  # slips whose distances differ by less than this [u] explain the report equally well

SAME = 1e-3  # slips whose factors differ by less than this share differ only by the units of the log

MOST = 3  # slips that are named


class Slip(Struct, frozen=True):
    """A known mistake that explains a reported value."""

    kind: str  # stable name: "rpm_as_rad_s", or two of them with " + " between
    words: str  # the mistake in words
    check: str  # how to check it, in words
    factor: float  # reported value over the value of the same fit without the slip [1]
    fit: str  # the accepted fit with the slip that agrees with the report, a name as in `OwnValue`
    u: float | None
    """Standard uncertainty of this fit with the slip [kg*m^2]; a slip that differs between runs scatters the points."""
    distance: float  # of the report from that fit [u]


def find_slips(
    reported: float, step: float, own: OwnRuns, readings: Readings, measured: Measurements
) -> tuple[Slip, ...]:
    """Name the slips that explain a reported I_zz, the most likely first.

    Parameters
    ----------
    reported, step : float
        The value, and one step of its last digit [kg*m^2].
    own : OwnRuns
        The accepted fits of the student's own runs.
    readings, measured
        The log.

    Returns
    -------
    tuple of Slip
        Several if they explain it equally well; empty if the runs explain the report, or no known slip does.
    """
    if min(distance(reported, value.value, step, own.yardstick) for value in own.values) <= FROM:
        return ()
    if reported:
        inverse = 1 / reported
        best = nearest(own.values, inverse)
        away = distance(inverse, best.value, step * inverse**2, own.yardstick)
        if away <= min(WITHIN, NEAREST / own.yardstick):
            u, kind = None if best.u is None else best.u * reported**2, known_mistakes()["inverse_slope"]
            return (Slip(kind.kind, kind.words, kind.check, reported**2, best.name, u, away),)
    singles = [kind for kind in list_mistakes(readings, measured, own.recommended.value) if kind.words]
    found = _matching(reported, step, own, singles, WITHIN)
    if not any(slip.distance <= BOTH_WITHIN for _, slip in found):
        found += _matching(reported, step, own, _pairs(singles), BOTH_WITHIN)
    least = min((slip.distance for _, slip in found), default=0.0)
    as_good = [item for item in found if item[1].distance <= least + AS_GOOD]
    as_good.sort(key=lambda item: (item[0], item[1].distance))
    # A mistake suggested by the log's units comes before one with only the same factor.
    likely = [slip.factor for rank, slip in as_good if rank == 0]
    named = [
        slip
        for rank, slip in as_good
        if rank == 0 or not any(abs(factor / slip.factor - 1) < SAME for factor in likely)
    ]
    return tuple(named[:MOST])


def corrected(readings: Readings, kind: Mistake) -> Readings:
    """Return a log without a mistake, and with a warning of it."""
    columns, runs = dict(readings.columns), len(readings.runs)
    if kind.kind == "exchanged":
        spin, time = columns["spin"], columns["time"]
        columns["spin"] = replace(_scaled(time, np.full(runs, RPM)), role="spin", unit="rpm")
        columns["time"] = replace(_scaled(spin, np.full(runs, 1 / RPM)), role="time", unit="s")
    else:
        torque, product = np.broadcast_to(kind.torque, runs), np.broadcast_to(kind.product, runs)
        role = kind.column or ("turns" if np.all(torque == 1) else "position")
        factor = product if role == "time" else 1 / (product if role in ("spin", "turns") else torque)
        for name in {role, *(["spin_start", "spin_end"] if role == "spin" else [])} & columns.keys():
            unit = columns[name].unit if role == "turns" else kind.meant or columns[name].unit
            columns[name] = replace(_scaled(columns[name], factor), unit=unit)
    warning = Diagnostic.of(LOG_CONTRADICTS_RIGHT_ANSWER, kind.log, kind.remedy, readings.name)
    return replace(readings, columns=columns, diagnostics=(*readings.diagnostics, warning))


def unusual(readings: Readings) -> int:
    """Count the quantities of a log with a reading that is very unusual for this lab."""
    columns = ((size, readings.columns[size.role].values) for size in SIZES if size.role in readings.columns)
    return sum(any(one and not size.usual[0] <= abs(one) <= size.usual[1] for one in some) for size, some in columns)


def _scaled(column: Column, factor: Floats) -> Column:
    """Multiply the readings of a column, their steps and their uncertainties."""

    def times(one: Reading, by: float) -> Reading:
        u = one.u and replace(one.u, absolute=by * one.u.absolute)
        return replace(one, value=one.value and by * one.value, step=one.step and by * one.step, u=u)

    return replace(column, readings=tuple(map(times, column.readings, factor.tolist())))


def _matching(
    reported: float, step: float, own: OwnRuns, kinds: list[Mistake], within: float
) -> list[tuple[int, Slip]]:
    """Find the slips of a list that explain the report, each with its rank and by the fit that agrees best."""
    plain = {value.name: value.value for value in own.values}
    margin = FROM * own.yardstick
    low, high = min(plain.values()) * (1 - margin), max(plain.values()) * (1 + margin)
    found = []
    for kind in kinds:
        fits = own.fits(kind.product, kind.torque)
        torque = np.broadcast_to(kind.torque, own.torque.shape)[own.torque != 0]
        # The recommended fit can only be scaled, by a factor that is the same in every run.
        if "recommended" in plain and not np.ndim(kind.product) and np.ptp(torque) <= 1e-9 * abs(torque[0]):
            factor, best = float(torque[0] / kind.product), own.recommended
            fits.append(OwnValue("recommended", best.value * factor, None if best.u is None else best.u * factor))
        explaining = []
        for one in fits:
            # A value among honest answers cannot be separated from them.
            if one.name in plain and one.value and not low <= one.value <= high:
                away = distance(reported, one.value, step, own.yardstick)
                if away <= min(within, NEAREST / own.yardstick):
                    about = kind.kind, kind.words, kind.check, one.value / plain[one.name]
                    explaining.append(Slip(*about, one.name, one.u, away))
        if explaining:
            found.append((kind.rank, min(explaining, key=lambda slip: slip.distance)))
    return found


def _pairs(singles: list[Mistake]) -> list[Mistake]:
    """List all pairs of forgotten steps: students put raw numbers into the formula."""
    return [
        Mistake(
            f"{first.kind} + {second.kind}",
            f"perhaps {first.words}, and {second.words}",
            f"{first.check}; {second.check}",
            product=first.product * second.product,
            torque=first.torque * second.torque,
            rank=max(first.rank, second.rank),
        )
        for first, second in combinations([kind for kind in singles if kind.forgets], 2)
        if first.forgets != second.forgets
    ]
