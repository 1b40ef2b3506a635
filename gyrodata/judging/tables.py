"""Tables of the report.

They show runs, torques, power laws, other fits, and the ball.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from gyrodata import fitting, physics
from gyrodata.fitting import Estimate, FitResult, Outlier
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats
from gyrodata.quantities.numerals import as_read
from gyrodata.quantities.units import Uncertainty

# --- each run ---


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
    """Time minus what the other runs predict, in standard uncertainties; None if they
    cannot predict it."""
    influence: float
    """Change of I_zz if this run were left out [kg*m^2]; 0 if it is left out."""
    flagged: bool
    left_out: bool
    reason: str


def run_table(
    measured: Measurements,
    fit: FitResult,
    outliers: tuple[Outlier, ...],
    left_out: tuple[int, ...],
) -> tuple[Run, ...]:
    """List for each run what was read and what was computed from it."""
    reasons = {outlier.index: outlier_reason(measured, outlier) for outlier in outliers}
    runs = range(len(measured.runs))
    read = (
        measured.mass,
        measured.position,
        measured.torque,
        measured.spin,
        measured.time,
        measured.turns,
    )
    sense = fit.sense
    rate = sense * measured.precession_rate
    period = measured.time / measured.turns
    product = sense * np.abs(measured.product)
    inertia = measured.torque / product
    inertia[measured.torque == 0] = np.nan
    residual = (
        measured.time - fit.fitted_time,
        fit.time_u,
        fit.deviations,
        fit.adjusted.influence,
    )
    numbers = np.array([*read, rate, period, product, inertia, *residual])
    # In the order of the fields: keyword arguments for each of very many runs would
    # take as long as the fit.
    columns = numbers.astype(object)
    columns[np.isnan(numbers)] = None
    return tuple(
        map(
            Run,
            measured.runs,
            measured.lines,
            *columns.tolist(),
            [run in reasons for run in runs],
            [run in left_out for run in runs],
            [reasons.get(run, "") for run in runs],
        )
    )


def outlier_reason(measured: Measurements, outlier: Outlier) -> str:
    """Return why a run is an outlier: corrections that fit, or its distance."""
    cells = "; or ".join(outlier.cells).replace("; or fits", "; or it fits")
    if cells and outlier.slip:
        return cells
    name = "time" if measured.timed else "period"
    time = measured.time[outlier.index]
    far = abs(outlier.deviation)
    return (
        f"its {name} is {time:.4g} s, "
        f"and the other runs predict {outlier.expected:.4g} s "
        f"({far:.0f} u apart){cells and '; '}{cells}"
    )


def load_words(measured: Measurements, index: int) -> str:
    """Return the load of a run with the digits of the log: "20.00 g at 15.0 cm"."""
    day = measured.day_words(index)
    mass = 1e3 * measured.mass[index]
    if np.isnan(mass):
        torque = 1e3 * measured.torque[index]
        return f"{torque:.3g} mN·m{day}"
    grams = as_read(mass, 1e3 * measured.mass_step[index])
    position = 1e2 * measured.position[index]
    centimetres = as_read(position, 1e2 * measured.position_step[index])
    return f"{grams} g at {centimetres} cm{day}"


def turn_words(turns: float) -> str:
    """Write a number of turns as a student would: "1/3 turn", "2 turns"."""
    from fractions import Fraction

    near = Fraction(turns).limit_denominator(12)
    text = f"{turns:.4g}"
    if abs(near - turns) < 1e-6 * turns:
        text = str(near)
    return f"{text} turn" if turns <= 1 else f"{text} turns"


# --- each torque ---


class MeanProduct(Estimate, frozen=True, kw_only=True):
    """Weighted mean of φ̇ψ̇ of a torque [rad²/s²]; u includes shared errors."""

    spread: float | None
    """Standard deviation of the single runs; null for one run."""
    p: float | None
    """Probability of a larger scatter if φ̇ψ̇ is constant; null for one run."""
    chi2: float | None
    """χ² of that scatter by the uncertainties that each run has alone, of one degree of
    freedom less than runs."""


class Torque(Struct, frozen=True):
    """The runs of one torque."""

    mass: float | None
    """[kg]"""
    position: float | None
    """[m]"""
    torque: float
    """[N*m]"""
    runs: int
    without: Estimate | None
    """I_zz from the runs of the other torques [kg*m^2]; null if undetermined, or for
    very many torques."""
    product: MeanProduct
    period_per_spin: Estimate
    """τ/ψ̇ = 2π/(φ̇ψ̇) from that mean, without its sign: slope of the period against
    the spin [s²/rad]."""


def torque_table(
    measured: Measurements,
    fit: FitResult,
    groups: list[list[int]],
) -> tuple[Torque, ...]:
    """Constancy of φ̇ψ̇ for each torque, from its runs in the fit: `groups`.

    If all runs of a torque are left out, they are used here.
    """
    torques = []
    for number, group in enumerate(measured.by_torque):
        first = group[0]
        runs = groups[number] or group
        product = _mean_product(measured, runs, float(fit.sense[first]))
        mean = abs(product.value)
        slope = 2 * math.pi / mean
        slope_u = slope * (product.u or 0.0) / mean
        per_spin = Estimate(slope, slope_u, "s^2/rad")
        mass = float(measured.mass[first])
        position = float(measured.position[first])
        torque = float(measured.torque[first])
        load = _or_none(mass), _or_none(position), torque
        torques.append(Torque(*load, len(runs), None, product, per_spin))
    return tuple(torques)


def _mean_product(measured: Measurements, runs: list[int], sense: float) -> MeanProduct:
    """Return the weighted mean of φ̇ψ̇ of some runs, and their scatter."""
    values = np.abs(measured.product[runs])
    size = measured.own_relative[runs] * values
    weight = 1 / np.maximum(size, 1e-12) ** 2
    weight /= np.add.reduce(weight)
    mean = float(weight @ values)
    alone = math.sqrt(np.add.reduce((weight * size) ** 2))
    # A late or early hand changes all runs in the same direction, each by b/T.
    late = measured.timing_bias_u * float(
        weight @ (measured.product[runs] / measured.time[runs])
    )
    scale = 0.0
    for source in measured.sources:
        if source.name == "spin_scale":
            scale += float(source.relative[0])
    spread = chi2 = p = None
    if len(runs) > 1:
        away = values - np.add.reduce(values) / len(runs)
        dof = len(runs) - 1
        spread = math.sqrt(away @ away / dof)
        if size.all():
            chi2 = float(np.add.reduce(((values - mean) / size) ** 2))
            p = fitting.chi2_tail(chi2, dof)
    u = math.hypot(alone, late, scale * mean)
    return MeanProduct(sense * mean, u, "rad^2/s^2", spread=spread, p=p, chi2=chi2)


# --- the laws ---


class PowerLaw(Struct, frozen=True):
    """τ ∝ ψ̇^exponent among the runs of one torque; eq. (9) says 1."""

    torque: float
    exponent: float | None
    u: float | None
    reason: str


class Exponent(Estimate, frozen=True, kw_only=True):
    """τ ∝ ψ̇^value with one exponent for all torques, each with a factor of its own."""

    deviation: float
    """From 1, in standard uncertainties."""
    torques: int
    """How many torques have runs at different spins."""


class Constancy(Struct, frozen=True):
    """Scatter of φ̇ψ̇ about the mean of each torque, for all torques together."""

    scatter: float
    """Standard deviation about the means, relative to them [1]."""
    expected: float
    """The same from each run's own timing and spin: root mean square of their relative
    uncertainty [1]."""
    chi2: float
    dof: int
    p: float
    """Probability of a chi-square at least as large if φ̇ψ̇ is constant."""


UNLIKELY = 0.05
"""The stated uncertainties do not explain a scatter whose probability is below this."""


def scatter_in_u(constancy: Constancy | None, measured: Measurements) -> str:
    """Write whether u includes the scatter of the runs.

    It is true for errors that each run has alone, and for a balance that differs
    between weights.
    """
    if constancy is None:
        return "u includes this if every run has an error of its own"
    if constancy.p < UNLIKELY:
        return "u already includes this"
    weights = "the runs of one weight agree, but the weights do not"
    if measured.balance_differs:
        return f"{weights}: u includes this as a balance that differs between weights"
    return f"{weights}: u does not include all of this"


def power_laws(measured: Measurements, groups: list[list[int]]) -> tuple[PowerLaw, ...]:
    """Compute the exponent of the period against the spin for each torque.

    The fit is a weighted line through the logarithms.
    """
    laws = []
    for group, used in zip(measured.by_torque, groups, strict=True):
        exponent = common_exponent(measured, [used])
        torque = float(measured.torque[group[0]])
        if exponent is None:
            laws.append(
                PowerLaw(torque, None, None, "needs two runs with different spins")
            )
        else:
            reason = "u from timing and spin of each run, and the hand's bias"
            laws.append(PowerLaw(torque, exponent.value, exponent.u, reason))
    return tuple(laws)


def common_exponent(measured: Measurements, groups: list[list[int]]) -> Exponent | None:
    """Fit one slope of ln τ on ln ψ̇ to groups of runs.

    Each group has a constant of its own. The result is None without a slope.

    The slope is Σ c ln τ / Σ c ln ψ̇ with c the weighted distance from the group's
    mean; a late or early hand changes every ln τ by b/T.
    """
    spin = np.log(measured.spin)
    period = np.log(measured.time / measured.turns)
    sums = np.zeros(3)
    torques = 0
    for group in groups:
        if len(group) > 1 and np.ptp(spin[group]) >= 0.02:
            weight = 1 / np.maximum(measured.own_relative[group], 1e-12) ** 2
            # Measured from the run of the largest weight: without an error, its
            # rounding would outweigh all other runs.
            at = spin[group] - spin[group[weight.argmax()]]
            away = weight * (at - np.average(at, weights=weight))
            sums += [away @ at, away @ period[group], away @ (1 / measured.time[group])]
            torques += 1
    if not torques:
        return None
    across, along, late = sums.tolist()
    value = along / across
    u = math.hypot(1 / math.sqrt(across), measured.timing_bias_u * late / across)
    return Exponent(value, u, "1", deviation=(value - 1) / u, torques=torques)


def constancy(
    measured: Measurements, torques: tuple[Torque, ...], groups: list[list[int]]
) -> Constancy | None:
    """Test if φ̇ψ̇ is constant for each torque, within u of timing and spin.

    None if no torque has two runs, or if timing and spin are exact.
    """
    several = [
        (torque.product, group)
        for torque, group in zip(torques, groups, strict=True)
        if len(group) > 1
    ]
    if not measured.own_relative.all() or not several:
        return None
    dof = 0
    total = 0.0
    away: list[float] = []
    expected: list[float] = []
    for product, group in several:
        dof += len(group) - 1
        total += product.chi2 or 0.0
        ratio = measured.product[group] / product.value
        away.extend(np.abs(ratio) - 1)
        expected.extend(measured.own_relative[group])
    scatter = math.sqrt(np.dot(away, away) / dof)
    usual = math.sqrt(np.mean(np.square(expected)))
    p = fitting.chi2_tail(total, dof)
    return Constancy(scatter, usual, total, dof, p)


# --- comparisons ---


class NamedFit(Struct, frozen=True):
    """One way to fit the log, for comparison."""

    name: str
    """"recommended", "through_origin" or "with_constant"."""
    inertia: Estimate | None
    """null if this fit is not possible."""
    constant: Estimate | None
    """Constant of the line M = I_zz φ̇ψ̇ + constant, which is −M0."""
    note: str
    """What it is, or why it is not possible."""
    difference: float | None = None
    """I_zz over the recommended one, minus 1; null for the recommended fit and for one
    that is not possible."""
    deviation: float | None = None
    """The same in standard uncertainties of the recommended fit."""


def named_fits(
    measured: Measurements, fit: FitResult, kept: list[int]
) -> tuple[NamedFit, ...]:
    """Return the two lines of the textbook, to compare with the recommended fit."""
    product = fit.sense[kept] * np.abs(measured.product[kept])
    torque = measured.torque[kept]
    note = (
        "all raw readings together; shared errors treated as shared; "
        "M0 and timing bias as unknowns; "
        "u from the stated uncertainties and from how the runs scatter"
    )
    m0 = fit.residual_torque
    constant = Estimate(-m0.value, m0.u, m0.unit)
    return (
        NamedFit("recommended", fit.inertia, constant, note),
        _textbook_line(product, torque, fit.inertia, intercept=False),
        _textbook_line(product, torque, fit.inertia, intercept=True),
    )


def _textbook_line(
    product: Floats, torque: Floats, recommended: Estimate, intercept: bool
) -> NamedFit:
    """Fit a straight line to the n runs: M on φ̇ψ̇ [rad²/s²], both of shape (n,)."""
    name = "with_constant" if intercept else "through_origin"
    words = "with" if intercept else "without"
    line = fitting.ordinary_line(product, torque, intercept)
    slope, u, constant, u_constant = [_or_none(float(number)) for number in line]
    if slope is None or (intercept and not fitting.torques_differ(torque)):
        note = (
            "not possible: all torques are equal, "
            "so a slope and an intercept cannot be separated; "
            "add runs with another weight or position"
        )
        return NamedFit(name, None, None, note)
    note = (
        f"least squares of M on φ̇ψ̇, {words} an intercept; u from the scatter, runs "
        f"assumed independent"
    )
    if len(product) == 1:
        note += "; one run has no scatter, so no u"
    difference = slope - recommended.value
    return NamedFit(
        name,
        Estimate(slope, u, "kg*m^2"),
        Estimate(constant or 0.0, u_constant, "N*m") if intercept else None,
        note,
        difference / recommended.value,
        difference / recommended.u if recommended.u else None,
    )


def _or_none(number: float) -> float | None:
    """Return None for NaN, which means that there is no such number."""
    return None if math.isnan(number) else number


class Sphere(Struct, frozen=True):
    """The ball alone."""

    mass: float | None
    """[kg]; None if the log describes only a disk."""
    mass_u: float | None
    """Standard uncertainty [kg]; None if the log does not state it; then the value is
    taken as exact."""
    diameter: float | None
    """[m]; None if the log describes only a disk."""
    diameter_u: float | None
    """Standard uncertainty [m]; None if the log does not state it; then the value is
    taken as exact."""
    solid: float | None
    """2/5 m r² of the ball without a bore [kg*m^2]; None if the log describes only a
    disk."""
    bore: float
    """Increase by the bore, for the same mass [kg*m^2]."""
    inertia_u: float | None
    """Standard uncertainty of all parts together [kg*m^2]; None if neither the mass nor
    the diameter of the ball has one."""


NO_SPHERE = Sphere(None, None, None, None, None, 0.0, None)


class Ball(Sphere, frozen=True, kw_only=True):
    """Compare the measured I_zz with that of the ball or disk in the log."""

    rod: float
    """½ m r² of the rod [kg*m^2]."""
    disk: float
    """½ m r² of the disk [kg*m^2]."""
    inertia: float
    """The ball, its bore, the rod and the disk together [kg*m^2]."""
    difference: float
    """I_zz minus that [kg*m^2]."""
    difference_u: float | None
    """Standard uncertainty of the difference [kg*m^2]."""
    relative: float
    """I_zz over it, minus 1."""
    deviation: float | None
    """The difference in its standard uncertainties."""


def compare_with_ball(
    inertia: Estimate,
    constants: Mapping[str, float],
    uncertainties: Mapping[str, Uncertainty],
) -> Ball | None:
    """Compare I_zz with that of the ball, its bore, rod and disk.

    None if the log gives neither ball nor disk.
    """
    rod = physics.cylinder_inertia(
        constants.get("rod_mass", 0.0), constants.get("rod_diameter", 0.0)
    )
    disk = _disk_and_hoop(constants)
    has_ball = {"ball_mass", "ball_diameter"} <= constants.keys()
    if not has_ball and not disk:
        return None
    sphere = _sphere(constants, uncertainties) if has_ball else NO_SPHERE
    expected = (sphere.solid or 0.0) + sphere.bore + rod + disk
    difference = inertia.value - expected
    difference_u = None
    if inertia.u is not None:
        difference_u = math.hypot(inertia.u, sphere.inertia_u or 0.0)
    return Ball(
        **asdict(sphere),
        rod=rod,
        disk=disk,
        inertia=expected,
        difference=difference,
        difference_u=difference_u,
        relative=inertia.value / expected - 1,
        deviation=difference / difference_u if difference_u else None,
    )


def _sphere(
    constants: Mapping[str, float], uncertainties: Mapping[str, Uncertainty]
) -> Sphere:
    """Return the ball of a log alone, with its uncertainties."""
    mass = constants["ball_mass"]
    diameter = constants["ball_diameter"]
    solid = physics.solid_ball_inertia(mass, diameter)
    bore = 0.0
    if "bore_diameter" in constants:
        bore = _with_bore(mass, diameter, constants) - solid
    of_mass = uncertainties.get("u_ball_mass")
    of_diameter = uncertainties.get("u_ball_diameter")
    mass_u = diameter_u = inertia_u = None
    by_mass = by_diameter = 0.0
    if of_mass:
        mass_u = of_mass.at(mass)
        by_mass = mass_u / mass
    if of_diameter:
        # 2/5 m (d/2)² grows as m and as d².
        diameter_u = of_diameter.at(diameter)
        by_diameter = 2 * diameter_u / diameter
    if of_mass or of_diameter:
        inertia_u = solid * math.hypot(by_mass, by_diameter)
    return Sphere(mass, mass_u, diameter, diameter_u, solid, bore, inertia_u)


def _disk_and_hoop(constants: Mapping[str, float]) -> float:
    """Compute ½ m r² of a disk and m r² of a hoop [kg*m^2]."""
    disk = physics.cylinder_inertia(
        constants.get("disk_mass", 0.0), constants.get("disk_diameter", 0.0)
    )
    radius = constants.get("hoop_diameter", 0.0) / 2
    return disk + constants.get("hoop_mass", 0.0) * radius**2


def _with_bore(mass: float, diameter: float, constants: Mapping[str, float]) -> float:
    """Compute I_zz of a ball with a bore [kg*m^2]; by default it ends at the centre."""
    across = constants["bore_diameter"]
    if across >= diameter:
        return physics.solid_ball_inertia(mass, diameter)
    depth = min(constants.get("bore_depth", diameter / 2), diameter)
    return physics.bored_ball_inertia(mass, diameter, across, depth)
