"""The laws of the report: the period grows as the spin, and at one torque φ̇ψ̇ is constant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrodata import fitting
from gyrodata.fitting import FitResult
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats


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


def own_relative(measured: Measurements) -> Floats:
    """Relative uncertainty of φ̇ψ̇ of each run from time and spin, each run's own, shape (n,)."""
    variance = np.zeros(len(measured.runs))
    for source in measured.sources:
        size = {"time": measured.time, "spin": measured.spin, "turns": measured.turns}.get(source.quantity)
        if size is not None and source.name not in ("spin_scale",):
            variance += (source.absolute / size + source.relative) ** 2
    return np.sqrt(variance)


def power_laws(measured: Measurements, kept: list[int]) -> tuple[PowerLaw, ...]:
    """Exponent of the period against the spin for each torque: a weighted line through the logarithms.

    Parameters
    ----------
    measured : Measurements
        n runs.
    kept : list of int
        Indices of the runs that have a say.

    Returns
    -------
    tuple of PowerLaw
        One for each torque.
    """
    laws = []
    for group in torque_groups(measured):
        members = _with_a_say(group, kept)
        torque = float(measured.torque[group[0]])
        if not _spins_differ(measured, members):
            laws.append(PowerLaw(torque, None, None, "needs two runs with different spins"))
            continue
        exponent, u = _slope(measured, [members])
        laws.append(PowerLaw(torque, exponent, u, "u from timing and spin of each run, and the hand's bias"))
    return tuple(laws)


def overall_exponent(measured: Measurements, kept: list[int]) -> Exponent | None:
    """Exponent of the period against the spin, the same for all torques.

    Parameters
    ----------
    measured : Measurements
        n runs.
    kept : list of int
        Indices of the runs that have a say.

    Returns
    -------
    Exponent or None
        None where no torque has runs at different spins.
    """
    groups = [_with_a_say(group, kept) for group in torque_groups(measured)]
    groups = [members for members in groups if _spins_differ(measured, members)]
    if not groups:
        return None
    value, u = _slope(measured, groups)
    return Exponent(value, u, (value - 1) / u, len(groups))


def _with_a_say(group: Sequence[int], kept: list[int]) -> list[int]:
    inside = set(kept)
    return [i for i in group if i in inside]


def _spins_differ(measured: Measurements, members: Sequence[int]) -> bool:
    return len(members) > 1 and bool(np.ptp(np.log(measured.spin[list(members)])) >= 0.02)


def _slope(measured: Measurements, groups: Sequence[Sequence[int]]) -> tuple[float, float]:
    """Common slope of ln τ on ln ψ̇ of groups that have each a constant of their own, and its uncertainty.

    The slope is Σ c ln τ with the weights c below; a late or early hand changes every ln τ by b/T.
    """
    own = np.maximum(own_relative(measured), 1e-12)
    spins, periods = np.log(measured.spin), np.log(measured.time / measured.turns)
    across, slope, bias = 0.0, 0.0, 0.0
    for group in groups:
        members = list(group)
        weights = 1 / own[members] ** 2
        away = spins[members] - np.sum(weights * spins[members]) / np.sum(weights)
        across += float(np.sum(weights * away**2))
        slope += float(np.sum(weights * away * periods[members]))
        bias += float(np.sum(weights * away / measured.time[members]))
    return slope / across, math.hypot(1 / math.sqrt(across), measured.timing_bias_u * bias / across)


def constancy(measured: Measurements, fit: FitResult, kept: list[int]) -> Constancy | None:
    """Say whether φ̇ψ̇ is constant at each torque, as far as timing and spin can tell.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their recommended fit.
    kept : list of int
        Indices of the runs that have a say.

    Returns
    -------
    Constancy or None
        None where no torque has two runs, or where timing and spin are exact.
    """
    own = own_relative(measured)
    if not own.all():
        return None
    product = fit.sense * np.abs(measured.product)
    chi2, squares, expected, dof, count = 0.0, 0.0, 0.0, 0, 0
    for group in torque_groups(measured):
        members = _with_a_say(group, kept)
        if len(members) < 2:
            continue
        values = product[members]
        mean = np.average(values, weights=1 / (own[members] * values) ** 2)
        chi2 += float(np.sum(((values - mean) / (own[members] * values)) ** 2))
        squares += float(np.sum((values / mean - 1) ** 2))
        expected += float(np.sum(own[members] ** 2))
        dof += len(members) - 1
        count += len(members)
    if not dof:
        return None
    return Constancy(math.sqrt(squares / dof), math.sqrt(expected / count), chi2, dof, fitting.chi2_tail(chi2, dof))
