"""Parts of a figure: dots, bars, titles, keys, ticks and limits, from plain arrays and axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.physics import Floats
from gyrodata.plotting.figure_data import Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, SOFT, FAINT = "#222222", "#666666", "#dddddd"

MARK = 5.5
"""Diameter of a dot [point]."""


class Marks(NamedTuple):
    """One set of runs on axes."""

    x: Floats
    y: Floats
    x_u: Floats
    y_u: Floats


def measure_axes(ax: Axes) -> tuple[float, float]:
    """Width and height of the axes [point]."""
    return 72 * ax.bbox.width / ax.figure.dpi, 72 * ax.bbox.height / ax.figure.dpi


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


def bars_note(ax: Axes, marks: Marks) -> str:
    """Say what the error bars are, or that the dots hide them all; u is one standard uncertainty."""
    ends = np.stack([np.column_stack([marks.x, marks.y]), np.column_stack([marks.x + marks.x_u, marks.y + marks.y_u])])
    middle, end = ax.transData.transform(ends.reshape(-1, 2)).reshape(ends.shape) * 72 / ax.figure.dpi
    if np.all(np.abs(end - middle) < MARK / 2):
        return "bars, ± 1u, are within the dots"
    return "bars: ± 1 standard uncertainty"


def _dots(ax: Axes, x: Floats, y: Floats, colour: str, marker: str, hollow: bool) -> None:
    ax.plot(
        x,
        y,
        linestyle="none",
        marker=marker,
        markersize=MARK,
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


def write_title(ax: Axes, title: str, note: str) -> None:
    """Write the title, and below it in small print how to read the figure, from the figure's left edge."""
    width, height = measure_axes(ax)
    left = (8 - 72 * ax.bbox.x0 / ax.figure.dpi) / width
    _write_above(ax, left, title, 20 / height, 10.5, note, 7 / height, 8)


def head(ax: Axes, title: str, note: str) -> None:
    """Write the title of one panel of several, and a line of small print below it, from the axes' left edge."""
    height = measure_axes(ax)[1]
    _write_above(ax, 0.0, title, 14 / height, 9, note, 4 / height, 7.5)


def _write_above(
    ax: Axes, left: float, title: str, title_up: float, title_size: float, note: str, note_up: float, note_size: float
) -> None:
    ax.text(left, 1 + title_up, title, transform=ax.transAxes, fontsize=title_size, weight="bold", color=INK)
    ax.text(left, 1 + note_up, note, transform=ax.transAxes, fontsize=note_size, weight="normal", color=SOFT)


def draw_key(
    ax: Axes,
    x: Sequence[float],
    y: Sequence[float],
    text: str,
    gap: float,
    size: float = 8.0,
    linespacing: float | None = None,
    **look: Any,
) -> None:
    """Draw one entry of a key, in parts of the axes: a mark or a stroke through (x, y), and what it is right of it."""
    ax.plot(x, y, transform=ax.transAxes, **look)
    ax.text(
        x[-1] + gap, y[-1], text, transform=ax.transAxes, va="center", fontsize=size, color=INK, linespacing=linespacing
    )


def with_hollow(scene: Scene, text: str) -> str:
    """Add to a note what hollow marks mean, where there are any."""
    if not scene.hollow.any():
        return text
    return f"{text}; hollow: {'left out' if (scene.left_out == scene.hollow).all() else 'flagged'}"


def _plain(value: float, _position: object = None) -> str:
    return f"{value:.5g}".replace("-", "−").replace("e+0", "e").replace("e−0", "e−")


def name_axes(ax: Axes, x: str, y: str) -> None:
    """Label both axes, and write their ticks as plain numbers; for axes made within ``rc_context(RULED)``."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.xaxis.set_major_formatter(_plain)
    ax.yaxis.set_major_formatter(_plain)
    if ax.get_xscale() == "linear":
        # Few numbers, for readers and for speed.
        ax.locator_params(nbins=6)


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
