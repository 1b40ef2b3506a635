"""Other fits beside the recommended one, and the runs of each torque together."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gyrodata import fitting
from gyrodata.comparisons.runs import or_none
from gyrodata.fitting import Estimate, FitResult
from gyrodata.measurements import Measurements, torque_groups


@dataclass(frozen=True, slots=True)
class NamedFit:
    """One way to fit the log, for comparison."""

    name: str
    """"through_origin", "with_constant" or "recommended"."""
    inertia: Estimate | None
    """[kg*m^2]; None where this fit is not possible."""
    constant: Estimate | None
    """Constant of the line M = I_zz φ̇ψ̇ + constant [N*m], which is −M0."""
    note: str
    """What it is, or why it is not possible."""
    difference: float | None = None
    """I_zz over the recommended one, minus 1; None for the recommended fit and for one that is not possible."""
    deviation: float | None = None
    """The same in standard uncertainties of the recommended fit."""


def named_fits(measured: Measurements, fit: FitResult, kept: list[int]) -> tuple[NamedFit, ...]:
    """The two straight lines of the textbook beside the recommended fit."""
    index = np.array(kept)
    product = fit.sense[index] * np.abs(measured.product[index])
    torque = measured.torque[index]
    textbook = "least squares of M on φ̇ψ̇, {}; u from the scatter, runs taken as independent"
    origin = fitting.ordinary_line(product, torque, intercept=False)
    line = fitting.ordinary_line(product, torque, intercept=True) if fitting.torques_differ(torque) else None
    if line is not None:
        constant = NamedFit("with_constant", line.slope, line.intercept, textbook.format("with a constant"))
    else:
        reason = (
            "not possible: a line with a constant needs at least two different points"
            if len(kept) < 2
            else "not possible: all torques are equal, so a slope and a constant cannot be told apart; "
            "add runs with another weight or position"
        )
        constant = NamedFit("with_constant", None, None, reason)
    note = textbook.format("through the origin")
    if len(kept) == 1:
        note += "; one run has no scatter, so no u"
    return (
        NamedFit(
            "recommended",
            fit.inertia,
            Estimate(-fit.imbalance.value, fit.imbalance.u),
            "all raw readings together; shared errors carried as shared; M0 and timing bias as unknowns; u from the "
            "stated uncertainties and from how the runs scatter",
        ),
        _beside(NamedFit("through_origin", origin.slope if origin else None, None, note), fit.inertia),
        _beside(constant, fit.inertia),
    )


def _beside(other: NamedFit, recommended: Estimate) -> NamedFit:
    """Say how far another fit lies from the recommended one."""
    if other.inertia is None:
        return other
    difference = other.inertia.value - recommended.value
    deviation = difference / recommended.u if recommended.u else None
    return replace(other, difference=difference / recommended.value, deviation=deviation)


@dataclass(frozen=True, slots=True)
class Torque:
    """The runs of one torque."""

    mass: float | None
    position: float | None
    torque: float
    runs: int
    product: float
    """Weighted mean of φ̇ψ̇ [rad²/s²]."""
    product_u: float
    """Standard uncertainty of that mean, errors shared by these runs included [rad²/s²]."""
    product_spread: float | None
    """Standard deviation of the single values; None for one run [rad²/s²]."""
    without: Estimate | None
    """I_zz from the runs of the other torques [kg*m^2]; None where they cannot tell it, or with over 12 torques."""
    product_p: float | None
    """Chance of a scatter at least as large if φ̇ψ̇ is constant; None for one run."""
    period_per_spin: float
    """τ/ψ̇ = 2π/(φ̇ψ̇) from that mean, without its sign: slope of the period against the spin [s²/rad]."""
    period_per_spin_u: float
    """Its standard uncertainty [s²/rad]."""


MOST_TORQUES = 12
"""What each torque does to the answer is told of so many, no more."""


def _without(measured: Measurements, fit: FitResult, kept: list[int], tilted: bool) -> list[Estimate | None]:
    """I_zz from all runs but those of each torque: what leaning on that weight does."""
    groups = torque_groups(measured)
    if len(groups) > MOST_TORQUES or fit.inertia.u is None:
        return [None] * len(groups)
    inside = set(kept)
    told = [[i for i in group if i in inside] for group in groups]
    found: list[Estimate | None] = []
    for group, shift in zip(told, fit.adjusted.without(told), strict=True):
        members = set(group)
        rest = [i for i in kept if i not in members]
        if not measured.torque[rest].any():
            found.append(None)
        elif shift is None:
            found.append(_fit_of(measured, tilted, rest))
        else:
            found.append(Estimate(fit.inertia.value + shift[0], math.sqrt(fit.inertia.u**2 + shift[1])))
    return found


def _fit_of(measured: Measurements, tilted: bool, rest: list[int]) -> Estimate | None:
    try:
        return fitting.fit(measured, tilted, set(range(len(measured.runs))) - set(rest)).inertia
    except fitting.NoFit:
        return None


def torque_table(measured: Measurements, fit: FitResult, kept: list[int], tilted: bool) -> tuple[Torque, ...]:
    """Constancy of φ̇ψ̇ for each torque, and what each does to the answer."""
    groups = []
    inside = set(kept)
    # Plain numbers: a torque has a handful of runs, for which arrays take longer.
    own = measured.own_relative.tolist()
    product = (fit.sense * np.abs(measured.product)).tolist()
    scale = next((float(s.relative[0]) for s in measured.sources if s.name == "spin_scale"), 0.0)
    without = _without(measured, fit, kept, tilted)
    for group, others in zip(torque_groups(measured), without, strict=True):
        members = [i for i in group if i in inside] or group
        values = [product[i] for i in members]
        sizes = [own[i] * abs(product[i]) for i in members]
        weights = [1 / max(size, 1e-12) ** 2 for size in sizes]
        whole = math.fsum(weights)
        mean = math.fsum(w * value for w, value in zip(weights, values, strict=True)) / whole
        alone = math.sqrt(math.fsum((w * size) ** 2 for w, size in zip(weights, sizes, strict=True))) / whole
        # A late or early hand moves all of them the same way, each by b/T.
        late = math.fsum(w * product[i] / measured.time[i] for w, i in zip(weights, members, strict=True)) / whole
        hand = measured.timing_bias_u * late
        several = len(members) > 1
        chi2 = spread = None
        if several:
            middle = math.fsum(values) / len(values)
            spread = math.sqrt(math.fsum((value - middle) ** 2 for value in values) / (len(values) - 1))
        if several and all(sizes):
            chi2 = math.fsum(((value - mean) / size) ** 2 for value, size in zip(values, sizes, strict=True))
        mean_u = math.hypot(alone, hand, scale * mean)
        slope = 2 * math.pi / abs(mean)
        groups.append(
            Torque(
                mass=or_none(measured.mass[group[0]]),
                position=or_none(measured.position[group[0]]),
                torque=float(measured.torque[group[0]]),
                runs=len(members),
                without=others,
                product=mean,
                product_u=mean_u,
                product_spread=spread,
                product_p=None if chi2 is None else fitting.chi2_tail(chi2, len(members) - 1),
                period_per_spin=slope,
                period_per_spin_u=slope * mean_u / abs(mean),
            )
        )
    return tuple(groups)
