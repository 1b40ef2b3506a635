"""Known slips: a reported I_zz that is right but for one mistake that many make, named from the factor it leaves.

Each slip is applied to the student's own readings, and the accepted fits are worked out anew; where the reported
value then agrees, the slip is named. Slips that leave nearly the same factor (no g: 9.81, rpm as rad/s: 9.55)
explain it equally well, and are named both. A slip is never looked for where the runs themselves explain the
report, and one whose result lies among what honest fits of the same runs give cannot be told and is not named.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
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

FROM = 3.0  # a report nearer than this to an accepted fit [u] is arithmetic as it should be: no slip is looked for

WITHIN, BOTH_WITHIN = 2.0, 1.0
"""A slip explains a report if what it makes of the runs is nearer than this [u]: one slip, two slips together.
There are many pairs, so that one of them comes near by chance more easily."""

NEAREST = 0.015  # and nearer than this share, however wide u: 60 for 57.3 are two slips, not one

AS_GOOD = 0.5  # a slip that is farther by less than this [u] than the best explains the report as well

SAME = 1e-3
"""Slips whose factors differ by less than this share leave the same factor: only the log's units tell them apart."""

MOST = 3  # slips that explain one report equally well and are told


class Slip(Struct, frozen=True):
    """A known mistake that explains a reported value."""

    kind: str  # stable name: "rpm_as_rad_s", or two of them with " + " between
    words: str  # what happened, in words
    check: str  # how to check it, in words
    factor: float  # reported value over what the same fit gives without the slip [1]
    fit: str  # which accepted fit of the runs with the slip it agrees with, a name as in `OwnValue`
    u: float | None
    """Standard uncertainty that this fit has with the slip [kg*m^2]; a slip that is not the same in every run scatters
    the points."""
    distance: float  # how far from that fit the report is [u]


def find_slips(
    reported: float, step: float, own: OwnRuns, readings: Readings, measured: Measurements
) -> tuple[Slip, ...]:
    """Name the slips that explain a reported I_zz.

    `reported` [kg*m^2]. `step`: One step of its last digit [kg*m^2]. Gives: The likeliest first; several where they
    explain it equally well; empty where the runs explain the report or no known slip does.
    """
    if min(distance(reported, value.value, step, own.yardstick) for value in own.values) <= FROM:
        return ()
    if reported:
        inverse = 1 / reported
        best = nearest(own.values, inverse)
        away = distance(inverse, best.value, step * inverse**2, own.yardstick)
        if away <= min(WITHIN, NEAREST / own.yardstick):
            u = None if best.u is None else best.u * reported**2
            return (_slip(known_mistakes()["inverse_slope"], reported**2, best.name, u, away),)
    singles = [kind for kind in list_mistakes(readings, measured, own.recommended.value) if kind.words]
    found = _matching(reported, step, own, singles, WITHIN)
    if not any(slip.distance <= BOTH_WITHIN for _, slip in found) and (pairs := list(_pairs(singles))):
        found += _matching(reported, step, own, pairs, BOTH_WITHIN)
    least = min((slip.distance for _, slip in found), default=0.0)
    as_good = [item for item in found if item[1].distance <= least + AS_GOOD]
    as_good.sort(key=lambda item: (item[0], item[1].distance))
    # A mistake suggested by the log's units comes before one with only the same factor.
    likely = [slip.factor for rank, slip in as_good if rank == 0]
    told = [
        slip
        for rank, slip in as_good
        if rank == 0 or not any(abs(factor / slip.factor - 1) < SAME for factor in likely)
    ]
    return tuple(told[:MOST])


def corrected(readings: Readings, kind: Mistake) -> Readings:
    """Undo a mistake in a log, and warn of it."""
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
    told = Diagnostic.of(LOG_CONTRADICTS_RIGHT_ANSWER, kind.log, kind.remedy, readings.name)
    return replace(readings, columns=columns, diagnostics=(*readings.diagnostics, told))


def unusual(readings: Readings) -> int:
    """Count the quantities of a log with a reading that this lab hardly ever has."""
    columns = ((size, readings.columns[size.role].values) for size in SIZES if size.role in readings.columns)
    return sum(any(one and not size.usual[0] <= abs(one) <= size.usual[1] for one in some) for size, some in columns)


def _scaled(column: Column, factor: Floats) -> Column:
    """Multiply the readings of a column, and what is known of each."""

    def times(one: Reading, by: float) -> Reading:
        u = one.u and replace(one.u, absolute=by * one.u.absolute)
        return replace(one, value=one.value and by * one.value, step=one.step and by * one.step, u=u)

    return replace(column, readings=tuple(map(times, column.readings, factor.tolist())))


def _slip(kind: Mistake, factor: float, fit: str, u: float | None, away: float) -> Slip:
    return Slip(kind.kind, kind.words, kind.check, factor, fit, u, away)


def _matching(
    reported: float, step: float, own: OwnRuns, kinds: list[Mistake], within: float
) -> list[tuple[int, Slip]]:
    """Slips of a list that explain the report, each by the fit that does it best, with their rank."""
    plain = {value.name: value.value for value in own.values}
    margin = FROM * own.yardstick
    low, high = min(plain.values()) * (1 - margin), max(plain.values()) * (1 + margin)
    found = []
    for kind in kinds:
        fits = own.fits(kind.product, kind.torque)
        if "recommended" in plain:
            # With this fit, a mistake has the same factor in every run.
            factor, u = _of_every_run(kind, own), own.recommended.u
            fits.append(OwnValue("recommended", own.recommended.value * factor, None if u is None else u * factor))
        explaining = []
        for one in fits:
            # A value among honest answers cannot be separated from them; a value that is not finite is near none.
            if one.name in plain and one.value and not low <= one.value <= high:
                away = distance(reported, one.value, step, own.yardstick)
                if away <= min(within, NEAREST / own.yardstick):
                    explaining.append(_slip(kind, one.value / plain[one.name], one.name, one.u, away))
        if explaining:
            found.append((kind.rank, min(explaining, key=lambda slip: slip.distance)))
    return found


def _of_every_run(kind: Mistake, own: OwnRuns) -> float:
    """Give the factor that a slip leaves in I_zz; NaN where runs differ in it."""
    torque = np.broadcast_to(kind.torque, own.torque.shape)[own.torque != 0]
    if np.ndim(kind.product) or np.ptp(torque) > 1e-9 * abs(torque[0]):
        return math.nan
    return float(torque[0] / kind.product)


def _pairs(singles: list[Mistake]) -> Iterator[Mistake]:
    """Two steps forgotten by one student: raw numbers put into the formula."""
    for first, second in combinations([kind for kind in singles if kind.forgets], 2):
        if first.forgets != second.forgets:
            yield Mistake(
                f"{first.kind} + {second.kind}",
                f"perhaps {first.words}, and {second.words}",
                f"{first.check}; {second.check}",
                product=first.product * second.product,
                torque=first.torque * second.torque,
                rank=max(first.rank, second.rank),
            )
