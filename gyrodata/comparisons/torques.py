"""The runs of each torque together: what each torque says, and the laws of the report.

The period grows as the spin, and at one torque φ̇ψ̇ is constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from gyrodata import fitting
from gyrodata.comparisons.runs import or_none
from gyrodata.fitting import Estimate, FitResult
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats


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
    groups = torque_groups(measured)
    inside = set(kept)
    told = _Groups([[i for i in group if i in inside] or group for group in groups])
    product = fit.sense * np.abs(measured.product)
    size = measured.own_relative * np.abs(product)
    weight = 1 / np.maximum(size, 1e-12) ** 2
    mean = told.mean(product, weight)
    alone = np.sqrt(told.sum((weight * size) ** 2)) / told.sum(weight)
    # A late or early hand moves all of them the same way, each by b/T.
    hand = measured.timing_bias_u * told.mean(product / measured.time, weight)
    scale = next((float(s.relative[0]) for s in measured.sources if s.name == "spin_scale"), 0.0)
    mean_u = np.sqrt(alone**2 + hand**2 + (scale * mean) ** 2)
    slope = 2 * np.pi / np.abs(mean)
    with np.errstate(all="ignore"):
        # One run has no spread, and an exact one no chi-square.
        spread = np.sqrt(told.sum(told.from_mean(product, np.ones_like(product)) ** 2) / (told.runs - 1))
        chi2 = told.sum((told.from_mean(product, weight) / size) ** 2)
    return tuple(
        Torque(
            mass=or_none(measured.mass[group[0]]),
            position=or_none(measured.position[group[0]]),
            torque=float(measured.torque[group[0]]),
            runs=runs,
            product=float(mean[k]),
            product_u=float(mean_u[k]),
            product_spread=or_none(spread[k]),
            without=without,
            product_p=fitting.chi2_tail(float(chi2[k]), runs - 1) if runs > 1 and np.isfinite(chi2[k]) else None,
            period_per_spin=float(slope[k]),
            period_per_spin_u=float(slope[k] * mean_u[k] / abs(mean[k])),
        )
        for k, (group, runs, without) in enumerate(
            zip(groups, told.runs.tolist(), _without(measured, fit, kept, tilted), strict=True)
        )
    )


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
    groups = _kept_groups(measured, kept)
    differ = _spins_differ(measured, groups)
    slopes = iter(_slopes(measured, [group for group, told in zip(groups, differ, strict=True) if told]).T)
    laws = []
    for group, told in zip(torque_groups(measured), differ, strict=True):
        torque = float(measured.torque[group[0]])
        if told:
            exponent, u = _slope(measured, next(slopes)[:, None])
            laws.append(PowerLaw(torque, exponent, u, "u from timing and spin of each run, and the hand's bias"))
        else:
            laws.append(PowerLaw(torque, None, None, "needs two runs with different spins"))
    return tuple(laws)


def overall_exponent(measured: Measurements, kept: list[int]) -> Exponent | None:
    """Exponent of the period against the spin, the same for all torques; None where no torque tells it."""
    groups = _kept_groups(measured, kept)
    groups = [group for group, differ in zip(groups, _spins_differ(measured, groups), strict=True) if differ]
    if not groups:
        return None
    value, u = _slope(measured, _slopes(measured, groups))
    return Exponent(value, u, (value - 1) / u, len(groups))


def _spins_differ(measured: Measurements, groups: Sequence[Sequence[int]]) -> list[bool]:
    spins = np.log(measured.spin)
    return [len(group) > 1 and float(np.ptp(spins[group])) >= 0.02 for group in groups]


def _slopes(measured: Measurements, groups: Sequence[Sequence[int]]) -> Floats:
    """Sums over each torque's runs from which `_slope` has the slope of ln τ on ln ψ̇, shape (3, groups).

    The slope is Σ c ln τ / Σ c ln ψ̇ with c the weighted distance from the torque's own mean; a late or early hand
    changes every ln τ by b/T.
    """
    told = _Groups(groups)
    weight = 1 / np.maximum(measured.own_relative, 1e-12) ** 2
    away = told.from_mean(np.log(measured.spin), weight)
    period = np.log(measured.time / measured.turns)
    return np.array([told.sum(weight * away * each) for each in (away, period, 1 / measured.time)])


def _slope(measured: Measurements, sums: Floats) -> tuple[float, float]:
    """Common slope of some torques that have each a constant of their own, and its standard uncertainty."""
    across, along, late = np.add.reduce(sums, axis=1).tolist()
    return along / across, math.hypot(1 / math.sqrt(across), measured.timing_bias_u * late / across)


def constancy(measured: Measurements, kept: list[int]) -> Constancy | None:
    """Say whether φ̇ψ̇ is constant at each torque, as far as timing and spin can tell.

    None where no torque has two runs, or where timing and spin are exact.
    """
    groups = [group for group in _kept_groups(measured, kept) if len(group) > 1]
    own, product = measured.own_relative, np.abs(measured.product)
    if not own.all() or not groups:
        return None
    told = _Groups(groups)
    weight = 1 / (product * own) ** 2
    away = told.from_mean(product, weight)
    count, dof = len(told.index), len(told.index) - len(groups)
    chi2 = float(np.add.reduce(told.sum(weight * away**2)))
    scatter = float(np.add.reduce(told.sum(away**2) / told.mean(product, weight) ** 2)) / dof
    expected = float(np.add.reduce(told.sum(own**2))) / count
    return Constancy(math.sqrt(scatter), math.sqrt(expected), chi2, dof, fitting.chi2_tail(chi2, dof))


def _kept_groups(measured: Measurements, kept: list[int]) -> list[list[int]]:
    inside = set(kept)
    return [[i for i in group if i in inside] for group in torque_groups(measured)]


class _Groups:
    """Sums over the runs of each torque, all torques at once."""

    def __init__(self, members: Sequence[Sequence[int]]) -> None:
        self.runs = np.array([len(group) for group in members], dtype=int)
        self.index = np.array([i for group in members for i in group], dtype=int)
        self.of = np.repeat(np.arange(len(members)), self.runs)

    def sum(self, values: Floats) -> Floats:
        """Sum of the values of n runs over those of each torque, shape (torques,)."""
        return cast(Floats, np.bincount(self.of, values[self.index], len(self.runs)))

    def mean(self, values: Floats, weight: Floats) -> Floats:
        """Weighted mean of each torque, shape (torques,)."""
        return self.sum(weight * values) / self.sum(weight)

    def from_mean(self, values: Floats, weight: Floats) -> Floats:
        """Distance of each run from its torque's weighted mean, shape (n,); 0 for runs of none."""
        away = np.zeros_like(values)
        away[self.index] = values[self.index] - self.mean(values, weight)[self.of]
        return away
