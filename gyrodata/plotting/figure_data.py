"""What the figures show: plain arrays, one look for each torque, and words, taken from an `Analysis`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import RPM, Floats
from gyrodata.quantities import as_read
from gyrodata.results import Analysis
from gyrodata.tables import Torque

# The first three are Okabe and Ito's; their light ones are lost on white, so the rest was chosen for contrast and for
# distance as the colour-blind see it. Grey is kept for runs without a weight.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#9B3DE8", "#6B2D00", "#1B1B4F")
MARKERS = ("o", "s", "^", "D", "v", "P", "<")
UNLOADED = ("#666666", "X")


class Look(NamedTuple):
    """How one torque is drawn, in every figure."""

    label: str
    """What stood on the rod: "20 g at 15 cm"."""
    colour: str
    """"#rrggbb"."""
    marker: str
    """As matplotlib writes it: "o"."""


class Group(Struct, frozen=True):
    """The runs of one torque, and how they are drawn."""

    label: str
    members: tuple[int, ...]
    summary: Torque
    colour: str
    marker: str


class Scene(Struct, frozen=True):
    """Everything that the figures show of n runs; arrays of shape (n,), with standard uncertainties."""

    groups: tuple[Group, ...]
    names: tuple[str, ...]
    hollow: NDArray[np.bool_]
    """Flagged; bool."""
    left_out: NDArray[np.bool_]
    """Flagged and without a say in the fit; bool."""
    loaded: NDArray[np.bool_]
    """A weight on the rod; bool."""
    spin: Floats
    """[rpm]"""
    spin_u: Floats
    period: Floats
    """[s]"""
    period_u: Floats
    product: Floats
    """φ̇ψ̇ [rad²/s²]"""
    product_u: Floats
    torque: Floats
    """[N*m]"""
    torque_u: Floats
    rest: Floats
    """What the recommended line leaves of the torque [N*m]."""
    rest_u: Floats
    deviations: Floats
    inertia: float
    """[kg*m^2]"""
    interval: tuple[float, float]
    """95 % interval of I_zz."""
    imbalance: float
    """[N*m]"""
    covariance: Floats
    """Of (I_zz, M0)."""
    origin: float | None
    """I_zz of the line through the origin [kg*m^2]."""
    origin_u: float | None
    dof: int
    inertia_text: str


def gather(analysis: Analysis, grey_safe: bool = False) -> Scene:
    """Take from an analysis what the figures need, in the units of their axes where a factor suffices."""
    measured, runs = analysis.measurements, analysis.run_table
    per_rpm = 1 / RPM
    period = np.array([run.period for run in runs])
    product = np.array([run.product for run in runs])
    own_time = np.hypot(_relative(measured, "time", measured.time), _relative(measured, "turns", measured.turns))
    own_spin = _relative(measured, "spin", measured.spin)
    torque_u = np.abs(measured.torque) * _relative_torque(measured)
    product_u = np.abs(product) * np.hypot(own_time, own_spin)
    spread = 1.96 * math.sqrt(analysis.fit.covariance[0, 0])
    origin = next((fit.inertia for fit in analysis.fits if fit.name == "through_origin"), None)
    return Scene(
        groups=_groups(analysis, grey_safe),
        names=tuple(_short(run.run) for run in runs),
        hollow=np.array([run.flagged or run.left_out for run in runs]),
        left_out=np.array([run.left_out for run in runs]),
        loaded=measured.torque != 0,
        spin=measured.spin * per_rpm,
        spin_u=measured.spin * per_rpm * own_spin,
        period=period,
        period_u=period * own_time,
        product=product,
        product_u=product_u,
        torque=measured.torque,
        torque_u=torque_u,
        rest=measured.torque + analysis.residual_torque.value - analysis.inertia.value * product,
        rest_u=np.hypot(torque_u, analysis.inertia.value * product_u),
        deviations=analysis.fit.deviations,
        inertia=analysis.inertia.value,
        interval=analysis.inertia.interval_95 or (analysis.inertia.value - spread, analysis.inertia.value + spread),
        imbalance=analysis.residual_torque.value,
        covariance=analysis.fit.covariance[:2, :2],
        origin=origin.value if origin else None,
        origin_u=origin.u if origin else None,
        dof=analysis.fit.dof,
        inertia_text=f"{with_u(analysis.inertia.value, analysis.inertia.u)} kg·m²",
    )


def line_band(scene: Scene, product: Floats) -> tuple[Floats, Floats]:
    """How far the recommended line may lie lower and higher at a product, with 95 % [N*m].

    The line turns, by as much as the interval of its slope says, about the point where slope and height know nothing of
    each other; the height there has what is left.
    """
    (v_inertia, cov), (_, v_imbalance) = scene.covariance
    pivot = cov / v_inertia
    height = 1.96**2 * max(v_imbalance - cov * pivot, 0.0)
    low, high = (abs(end - scene.inertia) for end in scene.interval)
    along = product - pivot
    lower, upper = (np.where(along > 0, *turned) * along for turned in ((low, high), (high, low)))
    return np.sqrt(lower**2 + height), np.sqrt(upper**2 + height)


def list_looks(analysis: Analysis, grey_safe: bool = False) -> tuple[Look, ...]:
    """Tell how each torque is drawn, for a page that shows the same marks beside its tables."""
    return tuple(Look(group.label, group.colour, group.marker) for group in _groups(analysis, grey_safe))


def _relative(measured: Measurements, quantity: str, values: Floats) -> Floats:
    """Relative standard uncertainty of one quantity in each run, whatever its errors are shared by."""
    variance = np.zeros(len(values))
    size = np.where(values == 0, np.inf, np.abs(values))
    for source in measured.sources:
        if source.quantity == quantity:
            touched = source.groups >= 0
            variance += np.where(touched, source.absolute / size + source.relative, 0.0) ** 2
    return np.sqrt(variance)


def _relative_torque(measured: Measurements) -> Floats:
    """Relative standard uncertainty of the torque of each run."""
    factors = {
        "mass": measured.mass,
        "position": measured.position,
        "force": measured.force,
        "torque": measured.given_torque,
        "g": np.full(len(measured.runs), measured.g),
    }
    parts = [_relative(measured, quantity, np.nan_to_num(values)) for quantity, values in factors.items()]
    return np.sqrt(sum((part**2 for part in parts), np.zeros(len(measured.runs))))


def _groups(analysis: Analysis, grey_safe: bool) -> tuple[Group, ...]:
    members = torque_groups(analysis.measurements)
    labels = [_group_label(analysis.measurements, group[0]) for group in members]
    for i, group in enumerate(members):
        if labels.count(labels[i]) > 1 or labels[i] in labels[:i]:
            # The same load in two senses of precession, as only runs without a weight can have.
            labels[i] += f" ({'+' if analysis.run_table[group[0]].product > 0 else '−'})"
    looks = choose_looks([torque.torque for torque in analysis.torques], grey_safe)
    return tuple(
        Group(
            label=labels[i],
            members=tuple(group),
            summary=analysis.torques[i],
            colour=looks[i][0],
            marker=looks[i][1],
        )
        for i, group in enumerate(members)
    )


def choose_looks(torques: Sequence[float], grey_safe: bool = False) -> list[tuple[str, str]]:
    """Colour and marker of each torque: of the colour-blind-safe set, or graded by size where that is too small."""
    loaded = [i for i, torque in enumerate(torques) if torque]
    looks = [UNLOADED] * len(torques)
    if not grey_safe and len(loaded) <= len(COLOURS):
        for rank, i in enumerate(loaded):
            looks[i] = (COLOURS[rank], MARKERS[rank])
        return looks
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    ranked = sorted(loaded, key=lambda i: torques[i])
    # From dark blue over violet to salmon, where the contrast with white comes down to 3 : 1.
    shades = colormaps["plasma"](np.linspace(0.0, 0.66, len(ranked)))
    for rank, i in enumerate(ranked):
        looks[i] = (to_hex(shades[rank]), MARKERS[rank % len(MARKERS)])
    return looks


def _group_label(measured: Measurements, i: int) -> str:
    """What stood on the rod: "20.00 g at 15.0 cm"."""
    if not measured.torque[i]:
        return "no weight"
    of_mass, of_position = measured.steps_of_load(i)
    at = f" at {as_number(100 * measured.position[i], 100 * of_position)} cm"
    if not math.isnan(measured.mass[i]):
        mass = measured.mass[i]
        if mass < 10:
            return f"{as_number(1e3 * mass, 1e3 * of_mass)} g{at}"
        return f"{as_number(mass, of_mass)} kg{at}"
    if not math.isnan(measured.force[i]):
        return f"{as_number(measured.force[i])} N{at}"
    unit, factor = torque_unit(abs(float(measured.torque[i])))
    return f"{as_number(factor * measured.torque[i])} {unit}"


def as_number(value: float, step: float = 0.0) -> str:
    """Write a reading with the digits that it was read to, or else with four or all before the point; a real minus."""
    return (f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else as_read(value, step)).replace("-", "−")


def _short(name: str) -> str:
    """One line of at most 14 characters: names come from the log and may be anything."""
    text = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    return text if len(text) <= 14 else text[:13] + "…"


def run_name(name: str) -> str:
    """Name a run as in a sentence: "run 5"."""
    return name if name.lower().startswith("run") else f"run {name}"


def torque_unit(largest: float) -> tuple[str, float]:
    """Choose a unit by the largest torque [N*m]; give it with the number of such units in 1 N*m."""
    if largest >= 10:
        return "N·m", 1.0
    return ("mN·m", 1e3) if largest >= 1e-4 else ("µN·m", 1e6)


def with_u(value: float, u: float | None) -> str:
    """Value and standard uncertainty with two digits of the uncertainty: "(4.44 ± 0.06) × 10⁻³"."""
    if not u or not math.isfinite(u):
        return as_number(value)
    from uncertainties import ufloat

    form = ".2uP" if 0.1 <= abs(value) < 1e4 else ".2ueP"
    return f"{ufloat(value, u):{form}}".replace("±", " ± ").replace("×", " × ").replace("-", "−")


def mean_text(group: Group) -> str:
    """Write the mean φ̇ψ̇ of a torque with its standard uncertainty [rad²/s²]."""
    return with_u(group.summary.product.value, group.summary.product.u)


# --- in words ----------------------------------------------------------------------------------------------------


def alt_text(analysis: Analysis, name: str) -> str:
    """Say what a figure shows, for who cannot see it."""
    scene = gather(analysis)
    words = {"period": _period_words, "product": _product_words, "torque": _torque_words, "residuals": _residual_words}
    odd = [run_name(scene.names[i]) + ", left out" * bool(scene.left_out[i]) for i in np.flatnonzero(scene.hollow)]
    hollow = f" Drawn hollow: {_listed(odd)}." if odd else ""
    return words[name](analysis, scene) + hollow


def _listed(items: Sequence[str], most: int = 4) -> str:
    return "; ".join(items[:most]) + (f"; and {len(items) - most} more" if len(items) > most else "")


def _period_words(analysis: Analysis, scene: Scene) -> str:
    told = []
    for group in scene.groups:
        members = sorted((i for i in group.members if not scene.hollow[i]), key=lambda i: scene.spin[i])
        if not members:
            continue
        first, last = members[0], members[-1]
        at = f"{group.label}: {as_number(scene.period[first])} s at {as_number(scene.spin[first])} rpm"
        to = f" to {as_number(scene.period[last])} s at {as_number(scene.spin[last])} rpm"
        told.append(at + (to if last != first else ""))
    law = analysis.exponent
    grows = f", growing as the spin to the power {with_u(law.value, law.u)}" if law else ""
    return (
        f"Precession period against spin, {_count(len(scene.names), 'run')} at {_count(len(scene.groups), 'torque')}"
        f"{grows}; a line through zero for each torque, steeper for the smaller one. {_listed(told)}."
    )


def _product_words(analysis: Analysis, scene: Scene) -> str:
    told = [f"{group.label}: {mean_text(group)} rad²/s²" for group in scene.groups]
    same = analysis.constancy
    level = f"; the runs scatter by {100 * same.scatter:.2g} % about them" if same else ""
    return f"Precession rate times spin against spin: a level line for each torque{level}. {_listed(told)}."


def _torque_words(_: Analysis, scene: Scene) -> str:
    unit, factor = torque_unit(float(np.abs(scene.torque).max()))
    low, high = factor * float(scene.torque.min()), factor * float(scene.torque.max())
    reach = f"from {as_number(low)} to {as_number(high)}" if high > low else f"of {as_number(high)}"
    far = np.abs(scene.rest) / np.maximum(scene.rest_u, 1e-300)
    farthest = int(np.argmax(np.where(scene.left_out, 0.0, far)))
    return (
        f"Torque {reach} {unit} against precession rate times spin: a straight line of slope I_zz = "
        f"{scene.inertia_text}, which crosses zero product at {as_number(-factor * scene.imbalance)} {unit}, with its "
        "95 % band; dashed, the line through the origin. Below, enlarged, what the line leaves of each run's torque: "
        f"most, for its uncertainty, of {run_name(scene.names[farthest])}."
    )


def _residual_words(_: Analysis, scene: Scene) -> str:
    kept = np.abs(np.nan_to_num(scene.deviations[~scene.left_out]))
    return (
        f"Each run's time minus what the other runs predict: {int(np.sum(kept <= 2))} of {_count(len(kept), 'run')} in "
        f"the fit lie within ± 2 standard uncertainties, the farthest at {as_number(float(kept.max(initial=0.0)))}. "
        "In the order of the log."
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
