"""The tables beside the answer: other fits, each torque, each run."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gyrodata import fitting
from gyrodata.fitting import Estimate, FitResult, Outlier
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats


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


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """τ ∝ ψ̇^exponent among the runs of one torque; eq. (9) says 1."""

    torque: float
    exponent: float | None
    u: float | None
    reason: str


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


@dataclass(frozen=True, slots=True)
class Run:
    """One timed run."""

    run: str
    line: int
    mass: float | None
    position: float | None
    torque: float
    spin: float
    time: float
    turns: float
    precession_rate: float
    period: float
    product: float
    inertia: float | None
    residual: float
    """Time minus fitted time [s]."""
    residual_u: float
    """Standard uncertainty expected of it from what this run has alone [s]."""
    influence: float
    """Change of I_zz if this run were left out [kg*m^2]; 0 where it is."""
    flagged: bool
    left_out: bool
    reason: str


def named_fits(measured: Measurements, fit: FitResult, kept: list[int], scaled: bool) -> tuple[NamedFit, ...]:
    """The two straight lines of the textbook beside the recommended fit.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their recommended fit.
    kept : list of int
        Indices of the runs that have a say.
    scaled : bool
        Whether the recommended fit was scaled by the Birge ratio.

    Returns
    -------
    tuple of NamedFit
    """
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
            "stated uncertainties, "
            + ("multiplied by the Birge ratio, as asked" if scaled else "not scaled by chi-square"),
        ),
        NamedFit("through_origin", origin.slope if origin else None, None, note),
        constant,
    )


def _own_relative(measured: Measurements) -> Floats:
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
    inside = set(kept)
    own = _own_relative(measured)
    for group in torque_groups(measured):
        members = [i for i in group if i in inside]
        torque = float(measured.torque[group[0]])
        spins = np.log(measured.spin[members])
        if len(members) < 2 or np.ptp(spins) < 0.02:
            laws.append(PowerLaw(torque, None, None, "needs two runs with different spins"))
            continue
        periods = np.log(measured.time[members] / measured.turns[members])
        weights = 1 / np.maximum(own[members], 1e-12) ** 2
        centre = np.sum(weights * spins) / np.sum(weights)
        across = np.sum(weights * (spins - centre) ** 2)
        exponent = float(np.sum(weights * (spins - centre) * periods) / across)
        laws.append(PowerLaw(torque, exponent, float(1 / np.sqrt(across)), "u from timing and spin of each run"))
    return tuple(laws)


def _without(
    measured: Measurements, fit: FitResult, group: list[int], kept: list[int], tilted: bool
) -> Estimate | None:
    """I_zz from all runs but those of one torque: what leaning on that weight does."""
    rest = sorted(set(kept) - set(group))
    if not np.any(measured.torque[rest]) or len(set(measured.torque)) > 12 or fit.inertia.u is None:
        return None
    shift = fit.adjusted.without([i for i in group if i in kept])
    # Where one torque is left, another prior of M0 comes with it.
    if shift is None or (fit.imbalance_free and not fitting.torques_differ(measured.torque[rest])):
        return fitting.fit(measured, tilted, set(range(len(measured.runs))) - set(rest)).inertia
    return Estimate(fit.inertia.value + shift[0], math.sqrt(fit.inertia.u**2 + shift[1]))


def torque_table(measured: Measurements, fit: FitResult, kept: list[int], tilted: bool) -> tuple[Torque, ...]:
    """Constancy of φ̇ψ̇ for each torque, and what each does to the answer.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their recommended fit.
    kept : list of int
        Indices of the runs that have a say.
    tilted : bool
        Whether eq. (8) was used.

    Returns
    -------
    tuple of Torque
    """
    groups = []
    inside = set(kept)
    own = _own_relative(measured)
    product = fit.sense * np.abs(measured.product)
    scale = next((float(s.relative[0]) for s in measured.sources if s.name == "spin_scale"), 0.0)
    for group in torque_groups(measured):
        members = [i for i in group if i in inside] or group
        values = product[members]
        weights = 1 / np.maximum(own[members] * np.abs(values), 1e-12) ** 2
        weights = weights / weights.sum()
        mean = float(np.sum(weights * values))
        alone = float(np.sqrt(np.sum((weights * own[members] * values) ** 2)))
        # A late or early hand moves all of them the same way, each by b/T.
        hand = measured.timing_bias_u * float(np.sum(weights * values / measured.time[members]))
        several = len(members) > 1
        chi2 = (
            float(np.sum(((values - mean) / (own[members] * values)) ** 2)) if several and own[members].all() else None
        )
        groups.append(
            Torque(
                mass=_or_none(measured.mass[group[0]]),
                position=_or_none(measured.position[group[0]]),
                torque=float(measured.torque[group[0]]),
                runs=len(members),
                without=_without(measured, fit, group, kept, tilted),
                product=mean,
                product_u=math.hypot(alone, hand, scale * mean),
                product_spread=float(np.std(values, ddof=1)) if several else None,
                product_p=None if chi2 is None else fitting.chi2_tail(chi2, len(members) - 1),
            )
        )
    return tuple(groups)


def run_table(
    measured: Measurements, fit: FitResult, outliers: tuple[Outlier, ...], left_out: tuple[int, ...]
) -> tuple[Run, ...]:
    """Put what was read and what was made of it side by side for each run.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their recommended fit.
    outliers : tuple of Outlier
        Those that look odd.
    left_out : tuple of int
        Indices of the runs that have no say.

    Returns
    -------
    tuple of Run
    """
    reasons = {outlier.index: outlier_reason(measured, outlier) for outlier in outliers}
    product = fit.sense * np.abs(measured.product)
    rate = 2 * np.pi * measured.turns / measured.time
    return tuple(
        Run(
            run=measured.runs[i],
            line=measured.lines[i],
            mass=_or_none(measured.mass[i]),
            position=_or_none(measured.position[i]),
            torque=float(measured.torque[i]),
            spin=float(measured.spin[i]),
            time=float(measured.time[i]),
            turns=float(measured.turns[i]),
            precession_rate=float(fit.sense[i] * rate[i]),
            period=float(measured.time[i] / measured.turns[i]),
            product=float(product[i]),
            inertia=float(measured.torque[i] / product[i]) if measured.torque[i] else None,
            residual=float(measured.time[i] - fit.fitted_time[i]),
            residual_u=float(fit.time_u[i]),
            influence=float(fit.influence[i]),
            flagged=i in reasons,
            left_out=i in left_out,
            reason=reasons.get(i, ""),
        )
        for i in range(len(measured.runs))
    )


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else float(value)


def outlier_reason(measured: Measurements, outlier: Outlier) -> str:
    """Say why a run looks odd: the count that fits it, or how far off it is.

    Parameters
    ----------
    measured : Measurements
        n runs.
    outlier : Outlier
        One of them.

    Returns
    -------
    str
    """
    written = measured.turns[outlier.index]
    if outlier.turns is not None:
        return f"fits {turn_words(outlier.turns)}, not {turn_words(written).split(' ')[0]}"
    side = "longer" if outlier.deviation > 0 else "shorter"
    return f"its time is {abs(outlier.deviation):.0f} standard uncertainties {side} than the other runs say"


def turn_words(turns: float) -> str:
    """Write a number of turns as a student would: "1/3 turn", "2 turns".

    Parameters
    ----------
    turns : float
        Revolutions, > 0.

    Returns
    -------
    str
    """
    from fractions import Fraction

    near = Fraction(turns).limit_denominator(12)
    text = str(near) if abs(near - turns) < 1e-6 * turns else f"{turns:.4g}"
    return f"{text} turn" if turns <= 1 else f"{text} turns"
