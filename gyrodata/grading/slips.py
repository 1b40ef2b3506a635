"""Known slips: a reported I_zz that is right but for one mistake that many make, named from the factor it leaves.

Each slip is applied to the student's own readings, and the accepted fits are worked out anew; where the reported
value then agrees, the slip is named. Slips that leave nearly the same factor (no g: 9.81, rpm as rad/s: 9.55)
explain it equally well, and are named both. A slip is never looked for where the runs themselves explain the
report, and one whose result lies among what honest fits of the same runs give cannot be told and is not named.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from msgspec import Struct

from gyrodata.grading.yardsticks import OwnRuns, OwnValue, distance
from gyrodata.known_slips import Kind, list_kinds
from gyrodata.measurements import Measurements
from gyrodata.physics import RPM
from gyrodata.readings import Readings

FROM = 3.0  # a report nearer than this to an accepted fit [u] is arithmetic as it should be: no slip is looked for

WITHIN, BOTH_WITHIN = 2.0, 1.0
"""A slip explains a report if what it makes of the runs is nearer than this [u]: one slip, two slips together.
There are many pairs, so that one of them comes near by chance more easily."""

NEAREST = 0.015  # and nearer than this share, however wide u: 60 for 57.3 are two slips, not one

AS_GOOD = 0.5  # a slip that is farther by less than this [u] than the best explains the report as well

SAME = 1e-3
"""Slips whose factors differ by less than this share leave the same factor: only the log's units tell them apart."""

SLOWEST = 30.0  # no rod is spun more slowly [rpm]

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
    honest = own.values
    if min(distance(reported, value.value, step, own.yardstick) for value in honest) <= FROM:
        return ()
    upside_down = _upside_down(reported, step, own, honest)
    if upside_down is not None:
        return (upside_down,)
    singles = [kind for kind in list_kinds(readings, measured) if kind.words]
    singles += [*_of_answers(own.recommended.value), *_of_columns(readings, measured)]
    found = _matching(reported, step, own, honest, singles, WITHIN)
    if not any(slip.distance <= BOTH_WITHIN for _, slip in found):
        found += _matching(reported, step, own, honest, list(_pairs(singles)), BOTH_WITHIN)
    if not found:
        return ()
    best = min(slip.distance for _, slip in found)
    as_good = sorted(
        (item for item in found if item[1].distance <= best + AS_GOOD), key=lambda item: (item[0], item[1].distance)
    )
    # What the log's own units suggest goes before what merely leaves the same factor.
    likely = [slip.factor for rank, slip in as_good if rank == 0]
    told = [
        slip
        for rank, slip in as_good
        if rank == 0 or not any(abs(factor / slip.factor - 1) < SAME for factor in likely)
    ]
    return tuple(told[:MOST])


def _upside_down(reported: float, step: float, own: OwnRuns, honest: tuple[OwnValue, ...]) -> Slip | None:
    """Find the slope of a plot with its axes the other way round."""
    if reported == 0:
        return None
    inverse = 1 / reported
    best = min(honest, key=lambda value: abs(value.value - inverse))
    away = distance(inverse, best.value, step * inverse**2, own.yardstick)
    if away > min(WITHIN, NEAREST / own.yardstick):
        return None
    return Slip(
        "inverse_slope",
        "it is the inverse, 1/I_zz: the slope of φ̇ψ̇ over M",
        "plot M over φ̇ψ̇, or take one over the slope; its unit tells: 1/(kg·m²) is no moment of inertia",
        reported**2,
        best.name,
        None if best.u is None else best.u * reported**2,
        away,
    )


def _matching(
    reported: float, step: float, own: OwnRuns, honest: tuple[OwnValue, ...], kinds: list[Kind], within: float
) -> list[tuple[int, Slip]]:
    """Slips of a list that explain the report, each by the fit that does it best, with their rank."""
    product = np.array([kind.product * own.product for kind in kinds])
    torque = np.array([kind.torque * own.torque for kind in kinds])
    plain = {value.name: value.value for value in honest}
    fits = own.fits(product, torque)
    if "recommended" in plain:
        # Whoever used this fit had one factor in every run, if any.
        same = np.array([kind.torque / kind.product if np.ndim(kind.product) == 0 else math.nan for kind in kinds])
        u = math.nan if own.recommended.u is None else own.recommended.u
        fits.append(("recommended", own.recommended.value * same, u * same))
    low, high = min(plain.values()), max(plain.values())
    within = min(within, NEAREST / own.yardstick)
    found = []
    for i, kind in enumerate(kinds):
        best: Slip | None = None
        for name, values, us in fits:
            value, u = float(values[i]), float(us[i])
            base = plain.get(name)
            if base is None or not math.isfinite(value) or value == 0:
                continue
            margin = FROM * own.yardstick
            if low * (1 - margin) <= value <= high * (1 + margin):
                continue  # not to be told from an honest answer
            away = distance(reported, value, step, own.yardstick)
            if away <= within and (best is None or away < best.distance):
                best = Slip(
                    kind.kind, kind.words, kind.check, value / base, name, u if math.isfinite(u) else None, away
                )
        if best is not None:
            found.append((kind.rank, best))
    return found


def _of_answers(inertia: float) -> Iterator[Kind]:
    """What becomes of an answer, or of a constant, after all conversions."""
    yield Kind(
        "sign", "there is a minus sign too many, and a moment of inertia is positive",
        "torque, spin and precession each have a sense; use magnitudes, or all three with their signs", torque=-1.0,
    )  # fmt: skip
    yield Kind(
        "degrees_per_second", "a rate is in degrees a second, not in rad/s",
        "a turn is 2π rad: φ̇ = 2π × turns/time", product=180 / math.pi,
    )  # fmt: skip
    yield Kind(
        "g_in_cm_s2", "g was taken in cm/s², 981, and all else in SI",
        "g is 9.81 m/s²", torque=100.0,
    )  # fmt: skip
    yield Kind(
        "cm2_as_m2", "the answer is in g·cm² (cgs), written as g·m², or in kg·cm², written as kg·m²",
        "1 cm² is 10⁻⁴ m²", torque=1e4, rank=1,
    )  # fmt: skip
    exponent = -math.floor(math.log10(abs(inertia)))
    if exponent:
        yield Kind(
            "exponent_lost", "the exponent of the answer is lost: the number stands without its power of ten",
            "write the power of ten behind the number, and the unit behind that", torque=10.0**exponent,
        )  # fmt: skip
        yield Kind(
            "exponent_sign_lost", "the sign of the exponent of the answer is lost",
            f"I_zz in kg·m² is {'below' if exponent > 0 else 'above'} 1: its exponent is "
            f"{'negative' if exponent > 0 else 'positive'}", torque=100.0**exponent,
        )  # fmt: skip


def _of_columns(readings: Readings, measured: Measurements) -> Iterator[Kind]:
    """Time and spin under each other's header."""
    columns = readings.columns
    if "time" not in columns or "spin" not in columns or columns["spin"].unit != "rpm" or columns["time"].unit != "s":
        return
    spin, time = measured.spin / RPM, measured.time
    if np.all((spin < time) & (time > SLOWEST)):
        yield Kind(
            "columns_exchanged", "the columns of time and spin are exchanged: each stands under the other's header",
            "a spin of some hundred rpm, a time of some seconds: put the two headers right",
            product=(time / spin) ** 2,
        )  # fmt: skip


def _pairs(singles: list[Kind]) -> Iterator[Kind]:
    """Two steps forgotten by one student: raw numbers put into the formula."""
    forgotten = [kind for kind in singles if kind.forgets]
    for i, first in enumerate(forgotten):
        for second in forgotten[i + 1 :]:
            if first.forgets == second.forgets:
                continue
            yield Kind(
                f"{first.kind} + {second.kind}",
                f"{first.words}, and {second.words}",
                f"{first.check}; {second.check}",
                product=first.product * second.product,
                torque=first.torque * second.torque,
                rank=max(first.rank, second.rank),
            )
