"""The data of the figures: arrays, colours and markers, numbers as text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.fitting import Estimate
from gyrodata.judging.tables import Torque
from gyrodata.measurements import Measurements
from gyrodata.physics import RPM, Floats
from gyrodata.reporting import values
from gyrodata.results import Analysis, Result, is_wide

# Okabe and Ito's three dark colours, and three others with contrast that colour-blind
# readers can distinguish. Grey is for runs without a weight.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#9B3DE8", "#6B2D00", "#1B1B4F")
MARKERS = ("o", "s", "^", "D", "v", "P", "<")
UNLOADED = ("#666666", "X")


class Look(NamedTuple):
    """Label, colour and marker of one torque in every figure."""

    label: str
    """The load: "20 g at 15 cm"."""
    colour: str
    """"#rrggbb"."""
    marker: str
    """A marker of matplotlib: "o"."""


class Group(Struct, frozen=True):
    """The runs of one torque."""

    look: Look
    members: list[int]
    summary: Torque


class Scene(Struct, frozen=True):
    """The data of n runs; arrays of shape (n,). ``_u``: standard uncertainties."""

    analysis: Analysis
    inertia: float
    """Slope of the fitted line, I_zz [kg*m^2]."""
    imbalance: float
    """M0 [N*m]."""
    groups: tuple[Group, ...]
    names: tuple[str, ...]
    hollow: NDArray[np.bool_]
    """Flagged or left out."""
    left_out: NDArray[np.bool_]
    """Not in the fit."""
    spin: Floats
    """[rpm]"""
    spin_u: Floats
    period: Floats
    """[s]"""
    period_u: Floats
    product: Floats
    """φ̇ψ̇ [rad²/s²]"""
    product_u: Floats
    unit: str
    """Unit of torques, for example "mN·m"."""
    unit_size: float
    """[N*m]"""
    torque: Floats
    """[unit]"""
    torque_u: Floats
    rest: Floats
    """Torque minus the fitted line [unit]."""
    rest_u: Floats


def gather(analysis: Analysis) -> Scene:
    """Collect the data of the figures from an analysis, in the units of the axes."""
    measured = analysis.measurements
    runs = analysis.run_table
    torque_scale = values.torque_scale(float(np.abs(measured.torque).max()))
    unit_size = torque_scale.size
    period = measured.time / measured.turns
    product = measured.product
    time_u = _relative(measured, "time", "turns")
    spin_u = _relative(measured, "spin")
    torque_u = np.abs(measured.torque) * _relative(
        measured, "mass", "position", "force", "torque", "g"
    )
    product_u = np.abs(product) * np.hypot(time_u, spin_u)
    inertia = analysis.inertia.value
    imbalance = analysis.residual_torque.value
    return Scene(
        analysis=analysis,
        inertia=inertia,
        imbalance=imbalance,
        groups=_groups(analysis),
        names=tuple(short_name(run.run, 14) for run in runs),
        hollow=np.array([run.flagged or run.left_out for run in runs]),
        left_out=np.array([run.left_out for run in runs]),
        spin=measured.spin / RPM,
        spin_u=measured.spin / RPM * spin_u,
        period=period,
        period_u=period * time_u,
        product=product,
        product_u=product_u,
        unit=torque_scale.unit,
        unit_size=unit_size,
        torque=measured.torque / unit_size,
        torque_u=torque_u / unit_size,
        rest=(measured.torque + analysis.fit.balances - inertia * product) / unit_size,
        rest_u=np.hypot(torque_u, inertia * product_u) / unit_size,
    )


def _relative(measured: Measurements, *quantities: str) -> Floats:
    """Compute the relative u of a product of quantities in each run."""
    variance = np.zeros(len(measured.runs))
    for source in measured.sources:
        if source.quantity in quantities:
            name = "given_torque" if source.quantity == "torque" else source.quantity
            size = np.abs(np.nan_to_num(getattr(measured, name)))
            size = np.where(size == 0, np.inf, size)
            variance += (
                np.where(
                    source.groups >= 0, source.absolute / size + source.relative, 0.0
                )
                ** 2
            )
    return np.sqrt(variance)


# --- colours and markers ---


def list_looks(analysis: Analysis) -> tuple[Look, ...]:
    """Return the label, colour and marker of each torque, also for tables."""
    return tuple(group.look for group in _groups(analysis))


def _groups(analysis: Analysis) -> tuple[Group, ...]:
    measured = analysis.measurements
    members = measured.by_torque
    torques = analysis.torques
    labels = [
        _label(measured, group[0]) + measured.day_words(group[0]) for group in members
    ]
    for i in [i for i, label in enumerate(labels) if labels.count(label) > 1]:
        # Runs without a weight can precess in both directions.
        labels[i] += f" ({'+' if torques[i].product.value > 0 else '−'})"
    loaded = sorted(
        (i for i, torque in enumerate(torques) if torque.torque),
        key=lambda i: torques[i].torque,
    )
    colours = _colours(len(loaded))
    looks = [UNLOADED] * len(torques)
    for rank, i in enumerate(loaded):
        looks[i] = (colours[rank], MARKERS[rank % len(MARKERS)])
    parts = zip(labels, looks, members, torques, strict=True)
    return tuple(
        Group(Look(label, *look), group, torque) for label, look, group, torque in parts
    )


def _colours(count: int) -> Sequence[str]:
    """Return colours for a number of torques."""
    if count <= len(COLOURS):
        return COLOURS
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    # From dark blue to salmon, all with enough contrast to white (3 : 1).
    return [
        to_hex(shade) for shade in colormaps["plasma"](np.linspace(0.0, 0.66, count))
    ]


def _label(measured: Measurements, i: int) -> str:
    """Describe the load of a run: "20.00 g at 15.0 cm"."""
    if not measured.torque[i]:
        return "no weight"
    at = f" at {as_number(100 * measured.position[i], 100 * measured.position_step[i])} cm"
    mass = measured.mass[i]
    force = measured.force[i]
    if not math.isnan(mass):
        scale = values.mass_scale(mass)
        step = measured.mass_step[i] / scale.size
        return f"{as_number(mass / scale.size, step)} {scale.unit}{at}"
    if not math.isnan(force):
        return f"{as_number(force)} N{at}"
    scale = values.torque_scale(abs(float(measured.torque[i])))
    return f"{as_number(measured.torque[i] / scale.size)} {scale.unit}"


# --- numbers as text ---


def as_number(value: float, step: float = 0.0) -> str:
    """Write a reading with its digits, or with at least four significant digits.

    The minus sign is typographic.
    """
    return values.reading_text(value, step=step).replace("-", "−")


def with_u(result: Estimate) -> str:
    """Write a value with two digits of its u: "4.44 ± 0.06"."""
    return values.number_text(result.value, result.u).replace("-", "−")


def answer(inertia: Result) -> str:
    """Write I_zz [kg*m^2] with u, or its 95 % interval if that is wider."""
    if inertia.interval_95 is None or not is_wide(inertia):
        return values.inertia_text(inertia.value, inertia.u)
    scale = values.inertia_scale(inertia.value, inertia.u)
    ends = values.interval_ends(*inertia.interval_95, scale.size)
    return f"{values.with_unit(' to '.join(ends), scale)} (95 % interval)"


def short_name(name: str, most: int) -> str:
    """Shorten a name from the log to one line of at most `most` characters."""
    text = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    return text if len(text) <= most else f"{text[: most - 1]}…"


def run_name(name: str) -> str:
    """Write the name of a run for a sentence: "run 5"."""
    return name if name.lower().startswith("run") else f"run {name}"
