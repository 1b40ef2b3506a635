"""The runs of each torque together: what each torque says, and the laws of the report.

The period grows as the spin, and at one torque φ̇ψ̇ is constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gyrodata import fitting
from gyrodata.comparisons.runs import or_none
from gyrodata.fitting import Estimate, FitResult
from gyrodata.measurements import Measurements, torque_groups


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
    """I_zz from the runs of the other torques [kg*m^2]; None where they cannot tell it, or of very many."""
    product_p: float | None
    """Chance of a scatter at least as large if φ̇ψ̇ is constant; None for one run."""
    period_per_spin: float
    """τ/ψ̇ = 2π/(φ̇ψ̇) from that mean, without its sign: slope of the period against the spin [s²/rad]."""
    period_per_spin_u: float
    """Its standard uncertainty [s²/rad]."""


MOST_TORQUES = 12
"""What each torque does to the answer is told of so many, no more."""

MOST_RUNS = 5000
"""Nor is so large a log fitted again for it."""


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
        if not measured.torque[rest].any() or (shift is None and len(rest) > MOST_RUNS):
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


# --- the laws ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """τ ∝ ψ̇^exponent among the runs of one torque; eq. (9) says 1."""

    torque: float
    exponent: float | None
    u: float | None
    reason: str


@dataclass(frozen=True, slots=True)
class Exponent:
    """τ ∝ ψ̇^value with one exponent for all torques, each with a factor of its own."""

    value: float
    u: float
    """Standard uncertainty."""
    deviation: float
    """From 1, in standard uncertainties."""
    torques: int
    """How many torques have runs at different spins."""


@dataclass(frozen=True, slots=True)
class Constancy:
    """How far the single φ̇ψ̇ lie from the mean of their torque, all torques together."""

    scatter: float
    """Standard deviation about the means, relative to them [1]."""
    expected: float
    """The same from each run's own timing and spin: root mean square of their relative uncertainty [1]."""
    chi2: float
    dof: int
    p: float
    """Chance of a chi-square at least as large if φ̇ψ̇ is constant."""


def power_laws(measured: Measurements, kept: list[int]) -> tuple[PowerLaw, ...]:
    """Exponent of the period against the spin for each torque: a weighted line through the logarithms."""
    laws = []
    points, inside = _points(measured), set(kept)
    for group in torque_groups(measured):
        members = [i for i in group if i in inside]
        torque = float(measured.torque[group[0]])
        if not _spins_differ(points, members):
            laws.append(PowerLaw(torque, None, None, "needs two runs with different spins"))
            continue
        exponent, u = _slope(points, [members], measured.timing_bias_u)
        laws.append(PowerLaw(torque, exponent, u, "u from timing and spin of each run, and the hand's bias"))
    return tuple(laws)


def overall_exponent(measured: Measurements, kept: list[int]) -> Exponent | None:
    """Exponent of the period against the spin, the same for all torques; None where no torque tells it."""
    points, inside = _points(measured), set(kept)
    groups = [[i for i in group if i in inside] for group in torque_groups(measured)]
    groups = [members for members in groups if _spins_differ(points, members)]
    if not groups:
        return None
    value, u = _slope(points, groups, measured.timing_bias_u)
    return Exponent(value, u, (value - 1) / u, len(groups))


class _Point(NamedTuple):
    """One run in logarithms. Plain numbers: a torque has a handful of runs, for which arrays take longer."""

    spin: float
    period: float
    weight: float
    """1 over the square of the relative uncertainty that the run has alone."""
    time: float


def _points(measured: Measurements) -> list[_Point]:
    weights = 1 / np.maximum(measured.own_relative, 1e-12) ** 2
    columns = (np.log(measured.spin), np.log(measured.time / measured.turns), weights, measured.time)
    return [_Point(*values) for values in zip(*(column.tolist() for column in columns), strict=True)]


def _spins_differ(points: Sequence[_Point], members: Sequence[int]) -> bool:
    spins = [points[i].spin for i in members]
    return len(spins) > 1 and max(spins) - min(spins) >= 0.02


def _slope(points: Sequence[_Point], groups: Sequence[Sequence[int]], timing_bias_u: float) -> tuple[float, float]:
    """Common slope of ln τ on ln ψ̇ of groups that have each a constant of their own, and its uncertainty.

    The slope is Σ c ln τ with the weights c below; a late or early hand changes every ln τ by b/T.
    """
    across, slope, bias = 0.0, 0.0, 0.0
    for group in groups:
        total = math.fsum(points[i].weight for i in group)
        centre = math.fsum(points[i].weight * points[i].spin for i in group) / total
        for point in (points[i] for i in group):
            away = point.weight * (point.spin - centre)
            across += away * (point.spin - centre)
            slope += away * point.period
            bias += away / point.time
    return slope / across, math.hypot(1 / math.sqrt(across), timing_bias_u * bias / across)


def constancy(measured: Measurements, kept: list[int]) -> Constancy | None:
    """Say whether φ̇ψ̇ is constant at each torque, as far as timing and spin can tell.

    None where no torque has two runs, or where timing and spin are exact.
    """
    own = measured.own_relative
    if not own.all():
        return None
    runs = list(zip(np.abs(measured.product).tolist(), own.tolist(), strict=True))
    chi2, squares, expected, dof, count = 0.0, 0.0, 0.0, 0, 0
    inside = set(kept)
    for group in torque_groups(measured):
        members = [i for i in group if i in inside]
        if len(members) < 2:
            continue
        weights = [1 / (runs[i][0] * runs[i][1]) ** 2 for i in members]
        mean = math.fsum(w * runs[i][0] for w, i in zip(weights, members, strict=True)) / math.fsum(weights)
        chi2 += math.fsum(w * (runs[i][0] - mean) ** 2 for w, i in zip(weights, members, strict=True))
        squares += math.fsum((runs[i][0] / mean - 1) ** 2 for i in members)
        expected += math.fsum(runs[i][1] ** 2 for i in members)
        dof += len(members) - 1
        count += len(members)
    if not dof:
        return None
    return Constancy(math.sqrt(squares / dof), math.sqrt(expected / count), chi2, dof, fitting.chi2_tail(chi2, dof))
