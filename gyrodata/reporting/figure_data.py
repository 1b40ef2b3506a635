"""The data of the figures: arrays, colours and markers, numbers as text."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.base import errors
from gyrodata.judging.tables import Torque
from gyrodata.measurements import Measurements
from gyrodata.physics import RPM, Floats
from gyrodata.reporting.elements import Numbers, Sentence, plain
from gyrodata.results import Analysis

# Okabe and Ito's three dark colours, and three others with contrast that colour-blind
# readers can distinguish. Grey is for runs without a weight.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#9B3DE8", "#6B2D00", "#1B1B4F")
MARKERS = ("o", "s", "^", "D", "v", "P", "<")
UNLOADED = ("#666666", "X")

MOST_LABELS = 14
"""Largest number of torques in the legend."""


class Look(NamedTuple):
    """Label, colour and marker of one torque in every figure."""

    label: str
    """The load: "20 g at 15 cm"."""
    colour: str
    """"#rrggbb"."""
    marker: str
    """A marker of matplotlib: "o"."""


class Quantity(NamedTuple):
    """A quantity of n runs with its standard uncertainty; arrays of shape (n,)."""

    value: Floats
    u: Floats | float = 0.0


class Group(Struct, frozen=True):
    """Runs that are drawn in one way."""

    look: Look
    members: list[int]
    """Indices of the runs."""


class TorqueGroup(Group, frozen=True):
    """The runs of one torque."""

    summary: Torque
    mean: str
    """The mean of φ̇ψ̇ with u and unit."""


class Scene(Struct, frozen=True):
    """The data of the runs in the units of the axes."""

    analysis: Analysis
    numbers: Numbers
    """The numbers as the report shows them."""
    inertia: float
    """Slope of the fitted line, I_zz [kg*m^2]."""
    imbalance: float
    """M0 [N*m]."""
    groups: Sequence[TorqueGroup]
    """In the order of the table of torques."""
    ranked: Sequence[TorqueGroup]
    """The largest torque first."""
    names: tuple[str, ...]
    labelled: int
    """One in so many torques is in the legend."""
    kept: NDArray[np.bool_]
    """Neither flagged nor left out."""
    hollow: NDArray[np.bool_]
    """Flagged or left out."""
    left_out: NDArray[np.bool_]
    """Not in the fit."""
    spin: Quantity
    """[rpm]"""
    period: Quantity
    """[s]"""
    product: Quantity
    """φ̇ψ̇ [rad²/s²]"""
    unit: str
    """Unit of torques, for example "mN·m"."""
    unit_size: float
    """[N*m]"""
    torque: Quantity
    """[unit]"""
    rest: Quantity
    """Torque minus the fitted line [unit]."""


def gather(analysis: Analysis) -> Scene:
    """Collect the data of the figures from an analysis, in the units of the axes."""
    measured = analysis.measurements
    runs = analysis.run_table
    numbers = Numbers(analysis)
    unit_size = numbers.torque.size
    spin = measured.spin / RPM
    period = measured.time / measured.turns
    product = measured.product
    torque = measured.torque / unit_size
    time_u = _relative(measured, "time", "turns")
    spin_u = _relative(measured, "spin")
    load_u = _relative(measured, "mass", "position", "force", "torque", "g")
    torque_u = np.abs(torque) * load_u
    product_u = np.abs(product) * np.hypot(time_u, spin_u)
    slope = analysis.inertia.value / unit_size
    net_torque = torque + analysis.fit.balances / unit_size
    rest = net_torque - slope * product
    rest_u = np.hypot(torque_u, slope * product_u)
    left_out = np.array([run.left_out for run in runs])
    hollow = left_out | [run.flagged for run in runs]
    groups = tuple(list_groups(numbers))
    return Scene(
        analysis=analysis,
        numbers=numbers,
        inertia=analysis.inertia.value,
        imbalance=analysis.residual_torque.value,
        groups=groups,
        ranked=sorted(groups, key=lambda group: -group.summary.torque),
        names=tuple(short_name(run.run, 14) for run in runs),
        labelled=math.ceil(len(groups) / MOST_LABELS),
        kept=~hollow,
        hollow=hollow,
        left_out=left_out,
        spin=Quantity(spin, spin * spin_u),
        period=Quantity(period, period * time_u),
        product=Quantity(product, product_u),
        unit=numbers.torque.unit,
        unit_size=unit_size,
        torque=Quantity(torque, torque_u),
        rest=Quantity(rest, rest_u),
    )


def _relative(measured: Measurements, *quantities: str) -> Floats:
    """Compute the relative u of a product of quantities in each run."""
    variance = np.zeros(len(measured.runs))
    for source in measured.sources:
        if source.quantity not in quantities:
            continue
        name = "given_torque" if source.quantity == "torque" else source.quantity
        size = np.abs(np.nan_to_num(getattr(measured, name)))
        size = np.where(size == 0, np.inf, size)
        u = source.absolute / size + source.relative
        variance += np.where(source.groups >= 0, u, 0.0) ** 2
    return np.sqrt(variance)


# --- colours and markers ---


def list_groups(n: Numbers) -> Iterator[TorqueGroup]:
    """Yield the runs of each torque, with the label, colour and marker of the torque."""
    torques = n.analysis.torques
    labels = [shown(n.load(i)) for i in range(len(torques))]
    loaded = [i for i, torque in enumerate(torques) if torque.torque]
    by_torque = sorted(loaded, key=lambda i: torques[i].torque)
    colours: Sequence[str] = COLOURS
    if len(loaded) > len(COLOURS):
        from matplotlib import colormaps
        from matplotlib.colors import to_hex

        # From dark blue to salmon, all with enough contrast to white (3 : 1).
        shades = colormaps["plasma"](np.linspace(0.0, 0.66, len(loaded)))
        colours = list(map(to_hex, shades))
    for i, torque in enumerate(torques):
        label = labels[i]
        if labels.count(label) > 1:
            # Runs without a weight can precess in both directions.
            label += " (+)" if torque.product.value > 0 else " (−)"
        look = Look(label, *UNLOADED)
        if torque.torque:
            rank = by_torque.index(i)
            look = Look(label, colours[rank], MARKERS[rank % len(MARKERS)])
        mean = n.value(f"torques.{i}.product.value")
        members = n.analysis.measurements.by_torque[i]
        yield TorqueGroup(look, members, torque, shown((mean,)))


# --- texts ---


def shown(sentence: Sentence) -> str:
    """Write a sentence of the report; the minus sign is typographic."""
    return plain(sentence).replace("-", "−")


def short_name(name: str, most: int) -> str:
    """Shorten a name from the log to one line of at most `most` characters."""
    text = errors.shown(name)
    if len(text) <= most:
        return text
    return f"{text[: most - 1]}…"


def run_name(name: str) -> str:
    """Write the name of a run for a sentence: "run 5"."""
    return name if name.lower().startswith("run") else f"run {name}"
