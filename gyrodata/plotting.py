"""The four figures of a log, and what each of them shows in words: the only matplotlib.

`_gather` takes from an `Analysis` the plain arrays that are drawn; the drawing functions know axes, arrays and
colours only. A torque keeps its colour and marker through all figures. Axes stand at fixed places and nothing
is laid out by trial, which makes the figures quick and their bytes the same on every run.
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.analysis import K_95, Analysis, Torque
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES = ("period", "product", "torque", "residuals")
"""Names of the figures, in the order of the report."""

Form = Literal["png", "svg", "pdf"]

RPM = 30 / math.pi
"""Revolutions per minute in one rad/s."""

# Okabe and Ito's colours without yellow, which is lost on white; grey is kept for runs without a weight.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_MARKERS = ("o", "s", "^", "D", "v", "P", "<")
_UNLOADED = ("#666666", "X")
_INK, _SOFT, _FAINT = "#222222", "#666666", "#dddddd"

_MANY = 10
"""More torques than this get a graded colour each and one compact list of labels."""

_SIZE = (6.6, 4.2)
"""Width and height [inch]."""
_FRAME = (0.125, 0.125, 0.635, 0.745)
"""Left, bottom, width and height of the axes in the figure; labels stand in the margin right of it."""

_STYLE: Any = {
    # A "$" in a run's name is a dollar; and the parser of formulas costs more than the figure.
    "text.parse_math": False,
    "text.usetex": False,
    "svg.hashsalt": "gyrodata",
    "svg.fonttype": "path",
    "pdf.fonttype": 3,
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": _SOFT,
    "axes.labelcolor": _INK,
    "axes.labelsize": 9.5,
    "axes.axisbelow": True,
    "xtick.color": _SOFT,
    "ytick.color": _SOFT,
    "xtick.labelcolor": _INK,
    "ytick.labelcolor": _INK,
}

# No date and no version: the same log gives the same bytes.
_METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": "gyrodata"},
    "pdf": {"CreationDate": None, "Creator": "gyrodata", "Producer": None},
}


# --- what is drawn ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Group:
    """The runs of one torque, and how they are drawn."""

    label: str
    members: tuple[int, ...]
    summary: Torque
    exponent: tuple[float, float] | None
    """Of the period against the spin, with its standard uncertainty."""
    colour: str
    marker: str


@dataclass(frozen=True)
class _Scene:
    """Everything that the figures show of n runs; arrays of shape (n,), with standard uncertainties."""

    groups: tuple[_Group, ...]
    names: tuple[str, ...]
    hollow: NDArray[np.bool_]
    """Flagged or left out of the fit; bool."""
    left_out: bool
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


def _gather(analysis: Analysis) -> _Scene:
    """Take from an analysis what the figures need, in the units of their axes where a factor suffices."""
    measured, runs = analysis.measurements, analysis.run_table
    period = np.array([run.period for run in runs])
    product = np.array([run.product for run in runs])
    own_time = np.hypot(_relative(measured, "time", measured.time), _relative(measured, "turns", measured.turns))
    own_spin = _relative(measured, "spin", measured.spin)
    origin = next((fit.inertia for fit in analysis.fits if fit.name == "through_origin"), None)
    return _Scene(
        groups=_groups(analysis),
        names=tuple(_short(run.run) for run in runs),
        hollow=np.array([run.flagged or run.left_out for run in runs]),
        left_out=any(run.left_out for run in runs),
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
        imbalance=analysis.imbalance.value,
        covariance=analysis.fit.covariance[:2, :2],
        origin=origin.value if origin else None,
        origin_u=origin.u if origin else None,
        dof=analysis.fit.dof,
        inertia_text=f"{_with_u(analysis.inertia.value, analysis.inertia.u)} kg·m²",
    )


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


def _groups(analysis: Analysis) -> tuple[_Group, ...]:
    members = torque_groups(analysis.measurements)
    labels = [_group_label(analysis.measurements, group[0]) for group in members]
    for i, group in enumerate(members):
        if labels.count(labels[i]) > 1 or labels[i] in labels[:i]:
            # The same load in two senses of precession, as only runs without a weight can have.
            labels[i] += f" ({'+' if analysis.run_table[group[0]].product > 0 else '−'})"
    looks = _looks([torque.torque for torque in analysis.torques])
    return tuple(
        _Group(
            label=labels[i],
            members=tuple(group),
            summary=analysis.torques[i],
            exponent=_exponent(analysis, i),
            colour=looks[i][0],
            marker=looks[i][1],
        )
        for i, group in enumerate(members)
    )


def _exponent(analysis: Analysis, index: int) -> tuple[float, float] | None:
    law = analysis.power_law[index]
    return None if law.exponent is None or law.u is None else (law.exponent, law.u)


def _looks(torques: Sequence[float]) -> list[tuple[str, str]]:
    """Colour and marker of each torque: of the colour-blind-safe set, or graded by rank where there are many."""
    loaded = [i for i, torque in enumerate(torques) if torque]
    looks = [_UNLOADED] * len(torques)
    if len(torques) > _MANY:
        from matplotlib import colormaps
        from matplotlib.colors import to_hex

        ranked = sorted(loaded, key=lambda i: torques[i])
        shades = colormaps["viridis"](np.linspace(0.0, 0.88, len(ranked)))
        for rank, i in enumerate(ranked):
            looks[i] = (to_hex(shades[rank]), _MARKERS[rank % len(_MARKERS)])
    else:
        for rank, i in enumerate(loaded):
            looks[i] = (_COLOURS[rank % len(_COLOURS)], _MARKERS[rank % len(_MARKERS)])
    return looks


def _group_label(measured: Measurements, i: int) -> str:
    """What stood on the rod: "20 g at 15 cm"."""
    if not measured.torque[i]:
        return "no weight"
    at = f" at {_number(100 * measured.position[i])} cm"
    if not math.isnan(measured.mass[i]):
        mass = measured.mass[i]
        return (f"{_number(1e3 * mass)} g" if mass < 10 else f"{_number(mass)} kg") + at
    if not math.isnan(measured.force[i]):
        return f"{_number(measured.force[i])} N{at}"
    unit, factor = _torque_unit(abs(float(measured.torque[i])))
    return f"{_number(factor * measured.torque[i])} {unit}"


def _number(value: float) -> str:
    return f"{value:.4g}".replace("-", "−")


def _short(name: str) -> str:
    """One line of at most 14 characters: names come from the log and may be anything."""
    text = " ".join("".join(c if c.isprintable() else " " for c in name).split())
    return text if len(text) <= 14 else text[:13] + "…"


def _run_name(name: str) -> str:
    return name if name.lower().startswith("run") else f"run {name}"


def _torque_unit(largest: float) -> tuple[str, float]:
    if largest >= 10:
        return "N·m", 1.0
    return ("mN·m", 1e3) if largest >= 1e-4 else ("µN·m", 1e6)


def _with_u(value: float, u: float | None) -> str:
    """Value and standard uncertainty with two digits of the uncertainty: "(4.44 ± 0.06) × 10⁻³"."""
    if not u or not math.isfinite(u):
        return _number(value)
    from uncertainties import ufloat

    form = ".2uP" if 0.1 <= abs(value) < 1e4 else ".2ueP"
    return f"{ufloat(value, u):{form}}".replace("±", " ± ").replace("×", " × ").replace("-", "−")


# --- drawing parts: plain arrays and axes ---------------------------------------------------------------------


class _Mark(NamedTuple):
    """One set of runs on axes."""

    x: Floats
    y: Floats
    x_u: Floats
    y_u: Floats


def _bars(ax: Axes, marks: _Mark, colours: Sequence[str]) -> None:
    """Draw all error bars of a figure as one artist; colours has one entry for each run."""
    from matplotlib.collections import LineCollection

    x, y, x_u, y_u = marks
    upright = np.stack([np.column_stack([x, y - y_u]), np.column_stack([x, y + y_u])], axis=1)
    across = np.stack([np.column_stack([x - x_u, y]), np.column_stack([x + x_u, y])], axis=1)
    ax.add_collection(
        LineCollection(list(np.concatenate([upright, across])), colors=[*colours, *colours], linewidths=1.0),
        autolim=False,
    )


def _dots(ax: Axes, x: Floats, y: Floats, colour: str, marker: str, hollow: bool) -> None:
    ax.plot(
        x,
        y,
        linestyle="none",
        marker=marker,
        markersize=5.5,
        color=colour,
        markerfacecolor="white" if hollow else colour,
        markeredgewidth=1.3 if hollow else 0.5,
        markeredgecolor=colour if hollow else "white",
        zorder=4 if hollow else 3,
        clip_on=False,
    )


def _runs(ax: Axes, scene: _Scene, marks: _Mark, bars: bool = True) -> None:
    """Draw every run with its group's colour and marker; flagged ones hollow."""
    colours = [""] * len(scene.names)
    for group in scene.groups:
        members = np.array(group.members)
        for i in group.members:
            colours[i] = group.colour
        for hollow in (False, True):
            chosen = members[scene.hollow[members] == hollow]
            if len(chosen):
                _dots(ax, marks.x[chosen], marks.y[chosen], group.colour, group.marker, hollow)
    if bars:
        _bars(ax, marks, colours)


def _pin(values: Floats, low: float, high: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Bring what lies outside the axes to their edge; say which runs were moved."""
    pinned = np.clip(values, low, high)
    return pinned, pinned != values


def _beyond(values: Floats, moved: NDArray[np.bool_], unit: str) -> list[str]:
    """What to add to the name of a run that is drawn at the edge of the axes because it lies beyond."""
    return [f" is at {_number(v)}{unit}" if m else "" for v, m in zip(values, moved, strict=True)]


def _name_runs(ax: Axes, scene: _Scene, marks: _Mark, values: Sequence[str], below: bool = False) -> None:
    """Write the name beside each hollow point, and its value where it is not drawn at its place.

    Labels that would lie on one another are moved down, line by line; at the lower edge, up.
    """
    # Points, as fonts are measured; figures are laid out at 72 to the inch whatever they are saved at.
    to_points = 72 / ax.figure.dpi
    taken: list[tuple[float, float]] = []
    for i in sorted((int(i) for i in np.flatnonzero(scene.hollow)), key=lambda i: -marks.y[i]):
        x, y = ax.transData.transform((marks.x[i], marks.y[i])) * to_points
        across, up = ax.transAxes.inverted().transform((x / to_points, y / to_points))
        left = across > 0.72
        drop, step = (5.0, 10.0) if up < 0.1 else (-11.0 if below else -7.0 if up > 0.93 else 5.0, -10.0)
        while any(abs(x - other) < 75 and abs(y + drop - height) < 10 for other, height in taken):
            drop += step
        taken.append((x, y + drop))
        ax.annotate(
            f"{_run_name(scene.names[i])}{values[i]}",
            (marks.x[i], marks.y[i]),
            (0.0 if below else -7.0 if left else 7.0, drop),
            textcoords="offset points",
            ha="right" if left else "center" if below else "left",
            va="center",
            fontsize=8,
            color=_INK,
            annotation_clip=False,
            bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.6},
            zorder=2.9,
        )


def _spread(targets: Sequence[float], gap: float) -> list[float]:
    """Move heights apart until neighbours are `gap` from one another, as near to their targets as the frame lets."""
    order = sorted(range(len(targets)), key=lambda i: targets[i])
    heights = [min(max(targets[i], 0.0), 1.0) for i in order]
    for _ in range(60):
        moved = False
        for low in range(len(heights) - 1):
            lack = gap - (heights[low + 1] - heights[low])
            if lack > 1e-6:
                heights[low] -= lack / 2
                heights[low + 1] += lack / 2
                moved = True
        heights = [min(max(height, 0.0), 1.0) for height in heights]
        if not moved:
            break
    else:
        # Too tight to settle: evenly, in order.
        heights = [0.5 + gap * (rank - (len(heights) - 1) / 2) for rank in range(len(heights))]
    placed = [0.0] * len(targets)
    for rank, i in enumerate(order):
        placed[i] = heights[rank]
    return placed


def _label_margin(ax: Axes, scene: _Scene, heights: Sequence[float] | None, extra: Sequence[str] = ()) -> None:
    """Name each torque right of the axes, beside where its line ends; without heights, from the top down.

    Parameters
    ----------
    ax : Axes
        With its limits set.
    scene : _Scene
        Its groups are labelled.
    heights : sequence of float or None
        Of each group, in the data's units.
    extra : sequence of str
        A second line for each label.
    """
    groups = scene.groups
    if len(groups) > _MANY:
        _list_margin(ax, scene)
        return
    gap = 0.105 if extra else 0.058
    if heights is None:
        placed = [0.97 - gap * rank for rank in range(len(groups))]
    else:
        at = ax.transAxes.inverted().transform(ax.transData.transform([(1.0, height) for height in heights]))
        placed = _spread([float(y) if math.isfinite(y) else 1.0 for y in at[:, 1]], gap)
    for i, group in enumerate(groups):
        _label(ax, placed[i], group, group.label + (f"\n{extra[i]}" if extra else ""), 8.5)


def _label(ax: Axes, height: float, group: _Group, text: str, size: float) -> None:
    ax.plot(
        [1.035], [height], marker=group.marker, markersize=5.5, color=group.colour, markeredgecolor="white",
        markeredgewidth=0.5, transform=ax.transAxes, clip_on=False,
    )  # fmt: skip
    ax.text(1.06, height, text, transform=ax.transAxes, va="center", fontsize=size, color=_INK, linespacing=1.15)


def _list_margin(ax: Axes, scene: _Scene) -> None:
    """Many torques: one compact list by torque, the largest on top, thinned out where it would not fit."""
    ranked = sorted(scene.groups, key=lambda group: -group.summary.torque)
    step = math.ceil(len(ranked) / 24)
    shown = ranked[::step]
    for rank, group in enumerate(shown):
        _label(ax, 0.98 - rank * min(0.045, 1 / len(shown)), group, group.label, 7.0)
    if step > 1:
        ax.text(1.02, 1.03, f"1 in {step} of {len(ranked)} torques", transform=ax.transAxes, fontsize=7, color=_SOFT)


def _title(ax: Axes, title: str, note: str) -> None:
    ax.text(0.0, 1.085, title, transform=ax.transAxes, fontsize=10.5, weight="bold", color=_INK)
    ax.text(0.0, 1.03, note, transform=ax.transAxes, fontsize=8, color=_SOFT)


def _note(scene: _Scene, text: str) -> str:
    if not scene.hollow.any():
        return text
    return f"{text}; hollow: {'left out of the fit' if scene.left_out else 'flagged'}"


def _plain(value: float, _position: object = None) -> str:
    return f"{value:.5g}".replace("-", "−").replace("e+0", "e").replace("e−0", "e−")


def _axes(ax: Axes, x: str, y: str) -> None:
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.xaxis.set_major_formatter(_plain)
    ax.yaxis.set_major_formatter(_plain)
    ax.grid(axis="y", color=_FAINT, linewidth=0.6)
    ax.tick_params(length=3)


def _log_ticks(low: float, high: float) -> list[float]:
    """Round numbers for a logarithmic axis, few enough to be written out."""
    decades = math.log10(high / low)
    steps: tuple[float, ...] = (1, 1.5, 2, 3, 4, 6, 8) if decades < 1.2 else (1, 2, 5) if decades < 3.5 else (1,)
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    every = max(1, math.ceil(decades / 8))
    return [
        step * 10.0**power
        for power in range(first, last + 1)
        if power % every == 0
        for step in steps
        if low <= step * 10.0**power <= high
    ]


def _range(values: Floats, u: Floats, hollow: NDArray[np.bool_]) -> tuple[float, float]:
    """Limits with zero inside, set by the runs in the fit; a flagged run may stretch them by a half at most."""
    kept = values[~hollow] if not hollow.all() else values
    kept_u = u[~hollow] if not hollow.all() else u
    low, high = min(0.0, float((kept - kept_u).min())), max(0.0, float((kept + kept_u).max()))
    span = (high - low) or 1.0
    low = max(min(low, float(values.min())), low - span / 2)
    high = min(max(high, float(values.max())), high + span / 2)
    space = 0.06 * (high - low or 1.0)
    return (low - space if low < 0 else 0.0), (high + space if high > 0 else 0.0)


# --- the four figures -----------------------------------------------------------------------------------------


def _draw_period(ax: Axes, scene: _Scene) -> None:
    """Period against spin, with the fitted law of each torque."""
    working = np.array([abs(group.summary.torque + scene.imbalance) for group in scene.groups])
    with np.errstate(divide="ignore"):
        slopes = 2 * math.pi * scene.inertia / RPM / working
    kept = ~scene.hollow if not scene.hollow.all() else scene.hollow
    logarithmic = bool(scene.period[kept].max() > 6 * np.median(scene.period[kept]))
    right = 1.06 * float((scene.spin + scene.spin_u).max())
    if logarithmic:
        left, bottom = float(scene.spin.min()) / 1.3, float(scene.period.min()) / 1.4
        top = 1.5 * float(scene.period.max())
        ax.set_xscale("log")
        ax.set_yscale("log")
    else:
        left = bottom = 0.0
        top = _range(scene.period, scene.period_u, scene.hollow)[1]
        ends = slopes * right
        top = max([top, *(1.01 * ends[ends < 1.3 * top])])
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    for axis, limits in ((ax.xaxis, (left, right)), (ax.yaxis, (bottom, top))) if logarithmic else ():
        axis.set_ticks(_log_ticks(*limits))
        axis.set_ticks([], minor=True)
    logs = ", log scale" if logarithmic else ""
    _axes(ax, f"spin ψ̇ [rpm{logs}]", f"precession period τ [s{logs}]")
    _laws(ax, [(group.colour, slope) for group, slope in zip(scene.groups, slopes, strict=True)], left, right)
    period, moved = _pin(scene.period, bottom, top)
    marks = _Mark(scene.spin, period, scene.spin_u, np.minimum(scene.period_u, period - bottom))
    _runs(ax, scene, marks)
    _name_runs(ax, scene, marks, _beyond(scene.period, moved, " s"))
    _label_margin(ax, scene, [float(min(slope * right, top)) for slope in slopes])
    law = "lines: τ = 2π I_zz ψ̇ / |M + M0|; bars: ± 1 standard uncertainty"
    _title(ax, "Precession period against spin", _note(scene, law))


def _laws(ax: Axes, laws: Sequence[tuple[str, float]], left: float, right: float) -> None:
    """Lines y = slope·x from the left to the right edge, straight on linear and on logarithmic axes."""
    from matplotlib.collections import LineCollection

    drawn = [(colour, slope) for colour, slope in laws if math.isfinite(slope)]
    segments = [np.array([(left, slope * left), (right, slope * right)]) for _, slope in drawn]
    ax.add_collection(LineCollection(segments, colors=[colour for colour, _ in drawn], linewidths=1.0), autolim=False)


def _draw_product(ax: Axes, scene: _Scene) -> None:
    """φ̇ψ̇ against spin: level for each torque, with the mean and its band."""
    from matplotlib.collections import LineCollection, PolyCollection

    right = 1.06 * float((scene.spin + scene.spin_u).max())
    bottom, top = _range(scene.product, scene.product_u, scene.hollow)
    ax.set_xlim(0.0, right)
    ax.set_ylim(bottom, top)
    _axes(ax, "spin ψ̇ [rpm]", "precession rate × spin, φ̇ψ̇ [rad²/s²]")
    means = [group.summary.product for group in scene.groups]
    widths = [2 * group.summary.product_u for group in scene.groups]
    colours = [group.colour for group in scene.groups]
    ax.add_collection(
        PolyCollection(
            [
                np.array([(0, mean - half), (right, mean - half), (right, mean + half), (0, mean + half)])
                for mean, half in zip(means, widths, strict=True)
            ],
            facecolors=colours,
            alpha=0.2,
            linewidths=0,
        ),
        autolim=False,
    )
    level = [np.array([(0.0, mean), (right, mean)]) for mean in means]
    ax.add_collection(LineCollection(level, colors=colours, linewidths=1.0), autolim=False)
    if bottom < 0 < top:
        ax.axhline(0, color=_SOFT, linewidth=0.8)
    product, moved = _pin(scene.product, bottom, top)
    marks = _Mark(scene.spin, product, scene.spin_u, scene.product_u)
    _runs(ax, scene, marks)
    _name_runs(ax, scene, marks, _beyond(scene.product, moved, ""))
    _label_margin(ax, scene, means, [_mean_text(group) for group in scene.groups])
    bands = "lines and bands: weighted mean ± 2u; bars: ± 1 standard uncertainty"
    _title(ax, "φ̇ψ̇ for each torque", _note(scene, bands))


def _mean_text(group: _Group) -> str:
    return _with_u(group.summary.product, group.summary.product_u)


def _draw_torque(ax: Axes, scene: _Scene) -> None:
    """Torque against φ̇ψ̇ with the recommended line, its 95 % band, and the line through the origin."""
    unit, factor = _torque_unit(float(np.abs(scene.torque).max()))
    left, right = _range(scene.product, scene.product_u, scene.hollow)
    torque, torque_u = factor * scene.torque, factor * scene.torque_u
    x = np.linspace(left, right, 41)
    line = x * scene.inertia - scene.imbalance
    (v_inertia, cov), (_, v_imbalance) = scene.covariance
    half = K_95 * np.sqrt(np.maximum(x**2 * v_inertia - 2 * x * cov + v_imbalance, 0.0))
    low, high = _range(torque, torque_u, scene.hollow)
    ends = factor * line[[0, -1]]
    low, high = min(low, float(ends.min()) - 0.02 * (high - low)), max(high, float(ends.max()))
    ax.set_xlim(left, right)
    # Room for the key above the lines.
    ax.set_ylim(low, high + 0.13 * (high - low))
    _axes(ax, "precession rate × spin, φ̇ψ̇ [rad²/s²]", f"torque M [{unit}]")
    ax.fill_between(x, factor * (line - half), factor * (line + half), color="#0072B2", alpha=0.15, linewidth=0)
    ax.plot(x, factor * line, color=_INK, linewidth=1.2)
    rows = [("-", "M = I_zz φ̇ψ̇ − M0, with its 95 % band")]
    if scene.origin is not None:
        ax.plot(x[[0, -1]], factor * scene.origin * x[[0, -1]], "--", color=_SOFT, linewidth=0.9, dashes=(5, 4))
        rows.append(("--", f"through the origin: {_with_u(scene.origin, scene.origin_u)} kg·m²"))
    if low < 0:
        ax.axhline(0, color=_SOFT, linewidth=0.8)
    if left < 0 < right:
        ax.axvline(0, color=_SOFT, linewidth=0.8)
    product, moved = _pin(scene.product, left, right)
    marks = _Mark(product, torque, scene.product_u, torque_u)
    _runs(ax, scene, marks)
    _name_runs(ax, scene, marks, _beyond(scene.product, moved, ""), below=True)
    _label_margin(ax, scene, [factor * group.summary.torque for group in scene.groups])
    _key(ax, rows)
    _title(ax, f"I_zz = {scene.inertia_text}", _note(scene, "torque against φ̇ψ̇; bars: ± 1 standard uncertainty"))


def _key(ax: Axes, rows: Sequence[tuple[str, str]]) -> None:
    """Say what the lines are, top left, where a rising line never is."""
    for rank, (style, text) in enumerate(rows):
        height = 0.965 - 0.052 * rank
        ax.plot([0.02, 0.075], [height, height], style, color=_INK if style == "-" else _SOFT, linewidth=1.1,
                transform=ax.transAxes)  # fmt: skip
        ax.text(0.09, height, text, transform=ax.transAxes, va="center", fontsize=8, color=_INK)


def _draw_residuals(ax: Axes, scene: _Scene) -> None:
    """Each run's time against what the others predict, in standard uncertainties, in the order of the log."""
    count = len(scene.names)
    place = np.arange(1.0, count + 1)
    deviations = np.nan_to_num(scene.deviations)
    kept = np.abs(deviations[~scene.hollow])
    limit = max(3.5, 1.15 * float(kept.max())) if len(kept) else 3.5
    ax.set_xlim(0.4, count + 0.6)
    ax.set_ylim(-limit, limit)
    _axes(ax, "run, in the order of the log", "time − prediction of the other runs [u]")
    ax.axhspan(-2, 2, color="#0072B2", alpha=0.1, linewidth=0)
    ax.axhline(0, color=_SOFT, linewidth=0.8)
    _run_ticks(ax, scene.names)
    nothing = np.zeros(count)
    height, moved = _pin(deviations, -0.96 * limit, 0.96 * limit)
    marks = _Mark(place, height, nothing, nothing)
    _runs(ax, scene, marks, bars=False)
    _name_runs(ax, scene, marks, _beyond(np.round(deviations), moved, " u"))
    _label_margin(ax, scene, None)
    inside = int(np.sum(kept <= 2))
    title = f"Residuals: {inside} of {len(kept)} runs within ± 2 standard uncertainties"
    if scene.dof < 1:
        title = "Residuals: as many unknowns as runs, so they tell nothing"
    _title(ax, title, _note(scene, "band: ± 2u, where about 95 % of good runs lie"))


def _run_ticks(ax: Axes, names: Sequence[str]) -> None:
    """Runs by their names where these have room, else every so many."""
    count = len(names)
    # About 58 characters fit below the axes.
    step = max(1, math.ceil(count * (max(len(name) for name in names) + 1.5) / 58))
    ax.xaxis.set_ticks(np.arange(1, count + 1)[::step], list(names[::step]))


_DRAWERS: dict[str, Callable[[Axes, _Scene], None]] = {
    "period": _draw_period,
    "product": _draw_product,
    "torque": _draw_torque,
    "residuals": _draw_residuals,
}


def draw(analysis: Analysis, name: str) -> Figure:
    """Draw one figure.

    Parameters
    ----------
    analysis : Analysis
        What `analyze` gives.
    name : str
        One of `FIGURES`.

    Returns
    -------
    matplotlib.figure.Figure
        6.6 × 4.2 inches; period in s, spin in rpm, φ̇ψ̇ in rad²/s², torque in mN·m.
    """
    from matplotlib import rc_context

    with rc_context(_STYLE):
        return _figure(_gather(analysis), name)


def _figure(scene: _Scene, name: str) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, dpi=150)
    _DRAWERS[name](figure.add_axes(_FRAME), scene)
    return figure


def render(analysis: Analysis, form: Form = "png") -> dict[str, bytes]:
    """Draw all figures as files.

    Parameters
    ----------
    analysis : Analysis
        What `analyze` gives.
    form : {"png", "svg", "pdf"}
        PNG has 150 dots to the inch.

    Returns
    -------
    dict of str to bytes
        Of each name in `FIGURES` the bytes of its file: the same on every run, without a date.
    """
    from matplotlib import rc_context

    files = {}
    with rc_context(_STYLE), warnings.catch_warnings():
        # A run's name may be written in a script that the font does not have; it is drawn as boxes then.
        warnings.filterwarnings("ignore", message="(?s).*[Gg]lyph.* missing")
        scene = _gather(analysis)
        for name in FIGURES:
            file = io.BytesIO()
            _figure(scene, name).savefig(file, format=form, metadata=_METADATA[form])
            files[name] = file.getvalue()
    return files


# --- in words -------------------------------------------------------------------------------------------------


def alt_text(analysis: Analysis, name: str) -> str:
    """Say what a figure shows, for who cannot see it.

    Parameters
    ----------
    analysis : Analysis
        What `analyze` gives.
    name : str
        One of `FIGURES`.

    Returns
    -------
    str
        Two or three sentences with the figure's main numbers and their units; plain text.
    """
    scene = _gather(analysis)
    words = {"period": _period_words, "product": _product_words, "torque": _torque_words, "residuals": _residual_words}
    odd = [_run_name(scene.names[i]) for i in np.flatnonzero(scene.hollow)]
    hollow = f" Drawn hollow ({'left out' if scene.left_out else 'flagged'}): {_listed(odd)}." if odd else ""
    return words[name](scene) + hollow


def _listed(items: Sequence[str], most: int = 4) -> str:
    return "; ".join(items[:most]) + (f"; and {len(items) - most} more" if len(items) > most else "")


def _period_words(scene: _Scene) -> str:
    told = []
    for group in scene.groups:
        members = sorted((i for i in group.members if not scene.hollow[i]), key=lambda i: scene.spin[i])
        if not members:
            continue
        first, last = members[0], members[-1]
        at = f"{group.label}: {_number(scene.period[first])} s at {scene.spin[first]:.0f} rpm"
        to = f" to {_number(scene.period[last])} s at {scene.spin[last]:.0f} rpm"
        told.append(at + (to if last != first else ""))
    return (
        f"Precession period against spin, {_count(len(scene.names), 'run')} at {_count(len(scene.groups), 'torque')}, "
        f"with the fitted proportional law of each torque as a line. {_listed(told)}."
    )


def _product_words(scene: _Scene) -> str:
    told = [f"{group.label}: {_mean_text(group)} rad²/s²" for group in scene.groups]
    return f"Precession rate times spin against spin; a level line for the mean of each torque. {_listed(told)}."


def _torque_words(scene: _Scene) -> str:
    unit, factor = _torque_unit(float(np.abs(scene.torque).max()))
    low, high = factor * float(scene.torque.min()), factor * float(scene.torque.max())
    reach = f"from {_number(low)} to {_number(high)}" if high > low else f"of {_number(high)}"
    return (
        f"Torque {reach} {unit} against precession rate times spin, with the fitted line of slope "
        f"I_zz = {scene.inertia_text}, which crosses zero product at {_number(-factor * scene.imbalance)} {unit}, "
        "its 95 % band, and the line through the origin, dashed."
    )


def _residual_words(scene: _Scene) -> str:
    kept = np.abs(np.nan_to_num(scene.deviations[~scene.hollow]))
    return (
        "Each run's time minus what the other runs predict, in standard uncertainties, in the order of the log. "
        f"{int(np.sum(kept <= 2))} of {_count(len(kept), 'run')} in the fit lie within ± 2, the farthest at "
        f"{_number(float(kept.max(initial=0.0)))}."
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")
