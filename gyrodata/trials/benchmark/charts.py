"""The two kinds of pictures of `gyro benchmark`: points in panels, and maps."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gyrodata.reporting.figure_data import COLOURS, MARKERS
from gyrodata.reporting.figures import INK
from gyrodata.trials.benchmark.maps import HALF, MapKind
from gyrodata.trials.benchmark.motions import KNOWN

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLE = Path(__file__).with_suffix(".mplstyle")

LETTERS = 110
"""Largest number of letters in a line of a picture."""

CELLS = ("white", "#BBBBBB", "#F7A98E")
"""Colours of a cell in which a method works, gives no answer, or fails."""

LABELS = {
    "seconds": "CPU time [s]",
    "process": "CPU time of a whole process [s]",
    "evaluations": "evaluations of the torque",
    "coverage": "intervals with the true I_zz",
}
"""Words for columns; those for "error" belong to the picture."""


def draw_points(
    figure: Figure,
    table: pd.DataFrame,
    views: Sequence[tuple[str, str]],
    error: str,
    levels: Mapping[str, float] = {},
) -> None:
    """Draw a panel for each scene and view, which is the columns of its axes.

    A view of a cost that was not measured is left out. `error` describes the error,
    and `levels` are lines for columns.
    """
    labels = LABELS | {"error": error}
    views = [(x, y) for x, y in views if x in table]
    scenes = list(table.groupby("scene", sort=False))
    grid = figure.subplots(
        len(views), len(scenes), sharex="row", sharey="row", squeeze=False
    )
    for row, (x, y) in zip(grid, views, strict=True):
        for ax, (_, points) in zip(row, scenes, strict=True):
            draw_panel(ax, points, x, y)
            ax.set_xlabel(labels[x])
            if y in levels:
                ax.axhline(levels[y], color=INK, linestyle="--", linewidth=1)
        row[0].set_ylabel(labels[y])
    for ax, (scene, _) in zip(grid[0], scenes, strict=True):
        ax.set_title(textwrap.fill(str(scene), 90 // len(scenes)), fontsize=9)
    if "coverage" in table:
        shades = grid[0, 0].collections[-1]
        figure.colorbar(shades, ax=grid, label=labels["coverage"], aspect=50)
    handles = grid[0, 0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower left", ncols=5, fontsize=8.5)


def draw_panel(ax: Axes, rows: pd.DataFrame, x: str, y: str) -> None:
    """Draw the points of each method, connected, with the ends of their intervals.

    The points of an error have the colour of the coverage, if it is known.
    """
    ax.set_xscale("linear" if x == "process" else "log")
    ax.set_yscale("linear" if y == "coverage" else "log")
    for number, (method, points) in enumerate(rows.groupby("method", sort=False)):
        ends = None
        if f"{y}_low" in points:
            ends = points[y] - points[f"{y}_low"], points[f"{y}_high"] - points[y]
        colour = COLOURS[number % len(COLOURS)]
        marker = MARKERS[number % len(MARKERS)]
        fill = "white" if method == KNOWN else colour
        ax.errorbar(
            points[x],
            points[y],
            ends,
            fmt=f"{marker}-",
            color=colour,
            mfc=fill,
            label=method,
        )
        if y == "error" and "coverage" in points:
            ax.scatter(
                points[x],
                points[y],
                c=points["coverage"],
                vmin=0,
                vmax=1,
                marker=marker,
                edgecolors=colour,
                zorder=3,
            )


def draw_map(figure: Figure, table: pd.DataFrame, kind: MapKind) -> None:
    """Draw the number of each method in each cell."""
    from matplotlib.colors import ListedColormap

    methods = list(table.groupby("method", sort=False))
    panels = figure.subplots(1, len(methods), sharey=True)
    for ax, (method, cells) in zip(panels, methods, strict=True):
        shown = [kind.number, "reacts"]
        columns = cells.pivot_table(shown, "y", "x", dropna=False)
        numbers = columns[kind.number]
        is_bad = kind.is_bad(numbers.to_numpy())
        states = np.where(numbers.isna(), 1, 2 * is_bad)
        colours = ListedColormap(CELLS)
        ax.imshow(states, colours, aspect="auto", origin="lower", vmin=0, vmax=2)
        reacts = columns["reacts"].where(numbers.notna()).to_numpy()
        for (y, x), number in np.ndenumerate(numbers):
            text = "" if np.isnan(number) else f"{round(number, 2) + 0:.2f}"
            star = "*" if reacts[y, x] > HALF else ""
            ax.text(x, y, text + star, ha="center", va="center", fontsize=8)
        if np.nanmin(reacts) < HALF < np.nanmax(reacts):
            ax.contour(reacts, [HALF], colors=INK, linestyles="--")
        ax.grid(visible=False)
        ax.set_title(method, fontsize=9.5)
        ax.set_xticks(range(numbers.shape[1]), numbers.columns)
        ax.set_yticks(range(numbers.shape[0]), numbers.index)
        ax.set_xlabel(kind.x_label)
    panels[0].set_ylabel(kind.y_label)
    low, high = kind.good
    words = (
        f"Number: {kind.number_label}. Red: the method fails, because it is not {low:g} "
        f"to {high:g}. Grey: no answer. Star, up to the dashed line: {kind.reactions}."
    )
    figure.supxlabel(textwrap.fill(words, LETTERS), fontsize=8.5)
