"""The laws of the report: the period grows as the spin, and at one torque φ̇ψ̇ is constant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gyrodata import fitting
from gyrodata.measurements import Measurements, torque_groups


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
