"""Parts of a figure: dots, bars, names, labels and limits, from plain arrays and axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.physics import Floats
from gyrodata.plotting.scene import MANY, Group, Scene, as_number, run_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, SOFT, _FAINT = "#222222", "#666666", "#dddddd"


class Marks(NamedTuple):
    """One set of runs on axes."""

    x: Floats
    y: Floats
    x_u: Floats
    y_u: Floats


def _bars(ax: Axes, marks: Marks, colours: Sequence[str]) -> None:
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


def draw_runs(ax: Axes, scene: Scene, marks: Marks, bars: bool = True) -> None:
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


def pin(values: Floats, low: float, high: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Bring what lies outside the axes to their edge; say which runs were moved."""
    pinned = np.clip(values, low, high)
    return pinned, pinned != values


def beyond(values: Floats, moved: NDArray[np.bool_], unit: str) -> list[str]:
    """What to add to the name of a run that is drawn at the edge of the axes because it lies beyond."""
    return [f" is at {as_number(v)}{unit}" if m else "" for v, m in zip(values, moved, strict=True)]


def name_runs(ax: Axes, scene: Scene, marks: Marks, values: Sequence[str], below: bool = False) -> None:
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
            f"{run_name(scene.names[i])}{values[i]}",
            (marks.x[i], marks.y[i]),
            (0.0 if below else -7.0 if left else 7.0, drop),
            textcoords="offset points",
            ha="right" if left else "center" if below else "left",
            va="center",
            fontsize=8,
            color=INK,
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


def label_margin(ax: Axes, scene: Scene, heights: Sequence[float] | None, extra: Sequence[str] = ()) -> None:
    """Name each torque right of the axes, beside where its line ends; without heights, from the top down.

    Parameters
    ----------
    ax : Axes
        With its limits set.
    scene : Scene
        Its groups are labelled.
    heights : sequence of float or None
        Of each group, in the data's units.
    extra : sequence of str
        A second line for each label.
    """
    groups = scene.groups
    if len(groups) > MANY:
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


def _label(ax: Axes, height: float, group: Group, text: str, size: float) -> None:
    ax.plot(
        [1.035], [height], marker=group.marker, markersize=5.5, color=group.colour, markeredgecolor="white",
        markeredgewidth=0.5, transform=ax.transAxes, clip_on=False,
    )  # fmt: skip
    ax.text(1.06, height, text, transform=ax.transAxes, va="center", fontsize=size, color=INK, linespacing=1.15)


def _list_margin(ax: Axes, scene: Scene) -> None:
    """Many torques: one compact list by torque, the largest on top, thinned out where it would not fit."""
    ranked = sorted(scene.groups, key=lambda group: -group.summary.torque)
    step = math.ceil(len(ranked) / 24)
    shown = ranked[::step]
    for rank, group in enumerate(shown):
        _label(ax, 0.98 - rank * min(0.045, 1 / len(shown)), group, group.label, 7.0)
    if step > 1:
        ax.text(1.02, 1.03, f"1 in {step} of {len(ranked)} torques", transform=ax.transAxes, fontsize=7, color=SOFT)


def write_title(ax: Axes, title: str, note: str) -> None:
    """Write the title, and below it in small print how to read the figure."""
    ax.text(0.0, 1.085, title, transform=ax.transAxes, fontsize=10.5, weight="bold", color=INK)
    ax.text(0.0, 1.03, note, transform=ax.transAxes, fontsize=8, color=SOFT)


def with_hollow(scene: Scene, text: str) -> str:
    """Add to a note what hollow marks mean, where there are any."""
    if not scene.hollow.any():
        return text
    return f"{text}; hollow: {'left out of the fit' if scene.left_out else 'flagged'}"


def _plain(value: float, _position: object = None) -> str:
    return f"{value:.5g}".replace("-", "−").replace("e+0", "e").replace("e−0", "e−")


def name_axes(ax: Axes, x: str, y: str) -> None:
    """Label both axes, and write their ticks as plain numbers."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.xaxis.set_major_formatter(_plain)
    ax.yaxis.set_major_formatter(_plain)
    ax.grid(axis="y", color=_FAINT, linewidth=0.6)
    ax.tick_params(length=3)


def log_ticks(low: float, high: float) -> list[float]:
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


def zero_range(values: Floats, u: Floats, hollow: NDArray[np.bool_]) -> tuple[float, float]:
    """Limits with zero inside, set by the runs in the fit; a flagged run may stretch them by a half at most."""
    kept = values[~hollow] if not hollow.all() else values
    kept_u = u[~hollow] if not hollow.all() else u
    low, high = min(0.0, float((kept - kept_u).min())), max(0.0, float((kept + kept_u).max()))
    span = (high - low) or 1.0
    low = max(min(low, float(values.min())), low - span / 2)
    high = min(max(high, float(values.max())), high + span / 2)
    space = 0.06 * (high - low or 1.0)
    return (low - space if low < 0 else 0.0), (high + space if high > 0 else 0.0)
