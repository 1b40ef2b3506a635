"""Tables beside the answer: each run, the runs of each torque, the laws of the report, other fits and a solid ball."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, physics
from gyrodata.fitting import Estimate, FitResult, Outlier
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats
from gyrodata.quantities import as_read
from gyrodata.units import Uncertainty

# --- each run ---------------------------------------------------------------------------------------------------


class Run(Struct, frozen=True):
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
    studentized_residual: float | None
    """Time minus what the other runs predict, in standard uncertainties; None where they cannot tell."""
    influence: float
    """Change of I_zz if this run were left out [kg*m^2]; 0 where it is."""
    flagged: bool
    left_out: bool
    reason: str


def run_table(
    measured: Measurements, fit: FitResult, outliers: tuple[Outlier, ...], left_out: tuple[int, ...]
) -> tuple[Run, ...]:
    """Put what was read and what was made of it side by side for each run."""
    out = set(left_out)
    reasons = {outlier.index: outlier_reason(measured, outlier) for outlier in outliers}
    product = fit.sense * np.abs(measured.product)
    everyone = range(len(measured.runs))

    def known(values: Floats) -> list[float | None]:
        """Plain numbers, and None for what was not read."""
        return [None if value != value else value for value in values.tolist()]

    # In the order of the fields: names for each of very many runs would take as long as the fit.
    columns = (
        measured.runs,
        measured.lines,
        known(measured.mass),
        known(measured.position),
        measured.torque.tolist(),
        measured.spin.tolist(),
        measured.time.tolist(),
        measured.turns.tolist(),
        (fit.sense * (2 * np.pi * measured.turns / measured.time)).tolist(),
        (measured.time / measured.turns).tolist(),
        product.tolist(),
        known(np.where(measured.torque == 0, np.nan, measured.torque / product)),
        (measured.time - fit.fitted_time).tolist(),
        fit.time_u.tolist(),
        known(fit.deviations),
        fit.influence.tolist(),
        [i in reasons for i in everyone],
        [i in out for i in everyone],
        [reasons.get(i, "") for i in everyone],
    )
    return tuple(map(Run, *columns))


def or_none(value: float) -> float | None:
    """Give None for what was not read."""
    return None if math.isnan(value) else float(value)


def outlier_reason(measured: Measurements, outlier: Outlier) -> str:
    """Say why a run looks odd: which corrections fit it, or how far off it is."""
    if outlier.cells:
        return "; or ".join(outlier.cells).replace("; or fits", "; or it fits")
    name, time = "time" if measured.timed else "period", measured.time[outlier.index]
    return (
        f"its {name} is {time:.4g} s, and the other runs predict {outlier.expected:.4g} s "
        f"({abs(outlier.deviation):.0f} u apart){outlier.maybe and '; '}{outlier.maybe}"
    )


def load_words(measured: Measurements, index: int) -> str:
    """Name the load of a run as the log does: "20.00 g at 15.0 cm"."""
    if not np.isnan(measured.mass[index]):
        of_mass, of_position = measured.steps_of_load(index)
        mass = as_read(1e3 * measured.mass[index], 1e3 * of_mass)
        return f"{mass} g at {as_read(1e2 * measured.position[index], 1e2 * of_position)} cm"
    return f"{1e3 * measured.torque[index]:.3g} mN·m"


def turn_words(turns: float) -> str:
    """Write a number of turns as a student would: "1/3 turn", "2 turns"."""
    from fractions import Fraction

    near = Fraction(turns).limit_denominator(12)
    text = str(near) if abs(near - turns) < 1e-6 * turns else f"{turns:.4g}"
    return f"{text} turn" if turns <= 1 else f"{text} turns"


# --- each torque ------------------------------------------------------------------------------------------------


class Torque(Struct, frozen=True):
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
    product_chi2: float | None
    """χ² of that scatter by the uncertainties that each run has alone, of one degree of freedom less than runs."""
    period_per_spin: float
    """τ/ψ̇ = 2π/(φ̇ψ̇) from that mean, without its sign: slope of the period against the spin [s²/rad]."""
    period_per_spin_u: float
    """Its standard uncertainty [s²/rad]."""


def torque_table(
    measured: Measurements, fit: FitResult, kept: list[int], without: Mapping[int, Estimate]
) -> tuple[Torque, ...]:
    """Constancy of φ̇ψ̇ for each torque; `without`: I_zz without the runs of a torque, by the number of its group."""
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
            without=without.get(k),
            product_p=None if of_scatter is None else fitting.chi2_tail(of_scatter, runs - 1),
            product_chi2=of_scatter,
            period_per_spin=float(slope[k]),
            period_per_spin_u=float(slope[k] * mean_u[k] / abs(mean[k])),
        )
        for k, (group, runs) in enumerate(zip(groups, told.runs.tolist(), strict=True))
        for of_scatter in [float(chi2[k]) if runs > 1 and np.isfinite(chi2[k]) else None]
    )


# --- the laws ---------------------------------------------------------------------------------------------------


class PowerLaw(Struct, frozen=True):
    """τ ∝ ψ̇^exponent among the runs of one torque; eq. (9) says 1."""

    torque: float
    exponent: float | None
    u: float | None
    reason: str


class Exponent(Struct, frozen=True):
    """τ ∝ ψ̇^value with one exponent for all torques, each with a factor of its own."""

    value: float
    u: float
    """Standard uncertainty."""
    deviation: float
    """From 1, in standard uncertainties."""
    torques: int
    """How many torques have runs at different spins."""


class Constancy(Struct, frozen=True):
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


# --- beside the answer ------------------------------------------------------------------------------------------


class NamedFit(Struct, frozen=True):
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
            Estimate(-fit.residual_torque.value, fit.residual_torque.u),
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


class Ball(Struct, frozen=True):
    """What spins, as the log describes it, and how the measured I_zz compares with it."""

    mass: float | None
    """[kg]; None where the log describes a disk only."""
    mass_u: float | None
    """Standard uncertainty [kg]; None where the log does not state it: taken as exact."""
    diameter: float | None
    """[m]; None where the log describes a disk only."""
    diameter_u: float | None
    """Standard uncertainty [m]; None where the log does not state it: taken as exact."""
    solid: float | None
    """2/5 m r² of the ball without a bore [kg*m^2]; None where the log describes a disk only."""
    bore: float
    """What the bore adds to it for the same mass [kg*m^2]."""
    rod: float
    """½ m r² of the rod [kg*m^2]."""
    disk: float
    """½ m r² of the disk [kg*m^2]."""
    inertia: float
    """All of these together [kg*m^2]."""
    inertia_u: float | None
    """Its standard uncertainty [kg*m^2]; None where neither the ball's mass nor its diameter has one."""
    difference: float
    """I_zz minus that [kg*m^2]."""
    difference_u: float | None
    """Standard uncertainty of the difference [kg*m^2]."""
    relative: float
    """I_zz over it, minus 1."""
    deviation: float | None
    """The difference in its standard uncertainties."""


def compare_with_ball(
    inertia: Estimate, constants: Mapping[str, float], uncertainties: Mapping[str, Uncertainty]
) -> Ball | None:
    """Compare I_zz with that of the ball, its bore, rod and disk; None where the log gives neither ball nor disk."""
    has_ball = "ball_mass" in constants and "ball_diameter" in constants
    rod, disk = (
        physics.cylinder_inertia(constants[f"{part}_mass"], constants[f"{part}_diameter"])
        if f"{part}_mass" in constants and f"{part}_diameter" in constants
        else 0.0
        for part in ("rod", "disk")
    )
    if not has_ball and not disk:
        return None
    mass, diameter = (constants["ball_mass"], constants["ball_diameter"]) if has_ball else (0.0, 0.0)
    stated = [uncertainties.get("u_ball_mass"), uncertainties.get("u_ball_diameter")]
    mass_u, diameter_u = (
        given.at(value) if given and has_ball else None for given, value in zip(stated, (mass, diameter), strict=True)
    )
    solid, bore = physics.solid_ball_inertia(mass, diameter), 0.0
    if has_ball and constants.get("bore_diameter", diameter) < diameter:
        # Without its depth a bore ends at the centre.
        depth = min(constants.get("bore_depth", diameter / 2), diameter)
        bore = physics.bored_ball_inertia(mass, diameter, constants["bore_diameter"], depth) - solid
    expected = solid + bore + rod + disk
    expected_u = None
    if mass_u is not None or diameter_u is not None:
        # 2/5 m (d/2)² grows as m and as d².
        expected_u = solid * math.hypot((mass_u or 0.0) / mass, 2 * (diameter_u or 0.0) / diameter)
    difference = inertia.value - expected
    difference_u = None if inertia.u is None else math.hypot(inertia.u, expected_u or 0.0)
    return Ball(
        mass=mass if has_ball else None,
        mass_u=mass_u,
        diameter=diameter if has_ball else None,
        diameter_u=diameter_u,
        solid=solid if has_ball else None,
        bore=bore,
        rod=rod,
        disk=disk,
        inertia=expected,
        inertia_u=expected_u,
        difference=difference,
        difference_u=difference_u,
        relative=inertia.value / expected - 1,
        deviation=difference / difference_u if difference_u else None,
    )
