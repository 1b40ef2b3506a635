"""What the figures show: plain arrays, and one look for each torque, taken from an `Analysis`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.comparisons import Torque
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats
from gyrodata.results import Analysis

RPM = 30 / math.pi
"""Revolutions per minute in one rad/s."""

# The first three are Okabe and Ito's; their light ones are lost on white, so the rest was chosen for contrast and for
# distance as the colour-blind see it. Grey is kept for runs without a weight.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#9B3DE8", "#6B2D00", "#1B1B4F")
MARKERS = ("o", "s", "^", "D", "v", "P", "<")
UNLOADED = ("#666666", "X")

MANY = 10
"""More torques than this get one compact list of labels."""


class Look(NamedTuple):
    """How one torque is drawn, in every figure."""

    label: str
    """What stood on the rod: "20 g at 15 cm"."""
    colour: str
    """"#rrggbb"."""
    marker: str
    """As matplotlib writes it: "o"."""


@dataclass(frozen=True)
class Group:
    """The runs of one torque, and how they are drawn."""

    label: str
    members: tuple[int, ...]
    summary: Torque
    colour: str
    marker: str


@dataclass(frozen=True)
class Scene:
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
    deviations: Floats
    inertia: float
    """[kg*m^2]"""
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
    period = np.array([run.period for run in runs])
    product = np.array([run.product for run in runs])
    own_time = np.hypot(_relative(measured, "time", measured.time), _relative(measured, "turns", measured.turns))
    own_spin = _relative(measured, "spin", measured.spin)
    origin = next((fit.inertia for fit in analysis.fits if fit.name == "through_origin"), None)
    return Scene(
        groups=_groups(analysis, grey_safe),
        names=tuple(_short(run.run) for run in runs),
        hollow=np.array([run.flagged or run.left_out for run in runs]),
        left_out=np.array([run.left_out for run in runs]),
        loaded=measured.torque != 0,
        spin=measured.spin * RPM,
        spin_u=measured.spin * RPM * own_spin,
        period=period,
        period_u=period * own_time,
        product=product,
        product_u=np.abs(product) * np.hypot(own_time, own_spin),
        torque=measured.torque,
        torque_u=np.abs(measured.torque) * _relative_torque(measured),
        deviations=analysis.fit.deviations,
        inertia=analysis.inertia.value,
        imbalance=analysis.residual_torque.value,
        covariance=analysis.fit.covariance[:2, :2],
        origin=origin.value if origin else None,
        origin_u=origin.u if origin else None,
        dof=analysis.fit.dof,
        inertia_text=f"{with_u(analysis.inertia.value, analysis.inertia.u)} kg·m²",
    )


def list_looks(analysis: Analysis, grey_safe: bool = False) -> tuple[Look, ...]:
    """Tell how each torque is drawn, for a page that shows the same marks beside its tables.

    Parameters
    ----------
    analysis : Analysis
        What `analyze` gives.
    grey_safe : bool
        As `choose_looks` takes it.

    Returns
    -------
    tuple of Look
        One for each of `analysis.torques`.
    """
    return tuple(Look(group.label, group.colour, group.marker) for group in _groups(analysis, grey_safe))


def _relative(measured: Measurements, quantity: str, values: Floats) -> Floats:
    """Relative standard uncertainty of one quantity in each run, whatever its errors are shared by."""
    variance = np.zeros(len(values))
    size = np.where(values == 0, np.inf, np.abs(values))
    for source in measured.sources:
        if source.quantity == quantity:
            touched = np.asarray(source.groups) >= 0
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
    """Colour and marker of each torque: of the colour-blind-safe set, or graded by size where that is too small.

    Parameters
    ----------
    torques : sequence of float
        [N*m]; 0 without a weight.
    grey_safe : bool
        Graded, dark to light, in any case.

    Returns
    -------
    list of tuple of str
        "#rrggbb" and matplotlib's marker; no two torques share a colour.
    """
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
    """What stood on the rod: "20 g at 15 cm"."""
    if not measured.torque[i]:
        return "no weight"
    at = f" at {as_number(100 * measured.position[i])} cm"
    if not math.isnan(measured.mass[i]):
        mass = measured.mass[i]
        return (f"{as_number(1e3 * mass)} g" if mass < 10 else f"{as_number(mass)} kg") + at
    if not math.isnan(measured.force[i]):
        return f"{as_number(measured.force[i])} N{at}"
    unit, factor = torque_unit(abs(float(measured.torque[i])))
    return f"{as_number(factor * measured.torque[i])} {unit}"


def as_number(value: float) -> str:
    """Write a reading with four digits, or all those before the point, and a real minus."""
    return (f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}").replace("-", "−")


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
    return with_u(group.summary.product, group.summary.product_u)
