"""Each run: what was read, what was made of it, why it looks odd; and I_zz beside other fits and a solid ball's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from gyrodata import fitting, physics
from gyrodata.fitting import Estimate, FitResult, Outlier
from gyrodata.measurements import Measurements
from gyrodata.units import Uncertainty


@dataclass(slots=True, unsafe_hash=True)  # frozen ones take five times as long to make, and there may be very many
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

    def known(values: physics.Floats) -> list[float | None]:
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
    """Say why a run looks odd: the count that fits it, or how far off it is."""
    written = measured.turns[outlier.index]
    if outlier.turns is not None:
        return f"fits {turn_words(outlier.turns)}, not {turn_words(written).split(' ')[0]}"
    side = "longer" if outlier.deviation > 0 else "shorter"
    return f"its time is {abs(outlier.deviation):.0f} standard uncertainties {side} than the other runs say"


def load_words(measured: Measurements, index: int) -> str:
    """Name the load of a run as the log does: "20 g at 15 cm"."""
    if not np.isnan(measured.mass[index]):
        return f"{1e3 * measured.mass[index]:.4g} g at {1e2 * measured.position[index]:.4g} cm"
    return f"{1e3 * measured.torque[index]:.3g} mN*m"


def turn_words(turns: float) -> str:
    """Write a number of turns as a student would: "1/3 turn", "2 turns"."""
    from fractions import Fraction

    near = Fraction(turns).limit_denominator(12)
    text = str(near) if abs(near - turns) < 1e-6 * turns else f"{turns:.4g}"
    return f"{text} turn" if turns <= 1 else f"{text} turns"


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
class Ball:
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
