"""The charts of `gyro benchmark`, one function each, 9 inches wide."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata.judging.changes import DROP_ALL
from gyrodata.reporting import figures
from gyrodata.reporting.figures import INK
from gyrodata.trials.benchmark import report
from gyrodata.trials.benchmark.fits import STATED
from gyrodata.trials.benchmark.integrators import fitted_order
from gyrodata.trials.benchmark.maps import KINDS, MapKind
from gyrodata.trials.benchmark.motions import FULL, KNOWN
from gyrodata.trials.benchmark.report import Benchmark

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLES = figures.STYLE, Path(__file__).with_suffix(".mplstyle")

Place = tuple[float, float] | None
"""x and y of the reader's log in a map."""


def render(
    done: Benchmark, places: Mapping[str, tuple[float, float]], workers: int
) -> dict[str, bytes]:
    """Draw all charts in several processes; return the bytes of each PNG by its name."""
    tasks = {
        name: partial(draw, name, title, done, places.get(name))
        for name, title in report.titles(done).items()
    }
    return dict(report.answers_of(tasks, workers))


def draw(name: str, title: str, done: Benchmark, place: Place) -> bytes:
    """Draw one chart."""
    table = done.tables[name]
    with figures.own_style(*STYLES):
        figure = new_figure(title, f"{report.labs_text(done)}. {done.machine}")
        if name in CHARTS:
            CHARTS[name](figure, table)
        else:
            (kind,) = [kind for kind in KINDS if kind.name == name]
            draw_map(figure, table, kind, place)
        return figures.save(figure, "png", 9)


def new_figure(title: str, foot: str) -> Figure:
    """Create a figure with a title, and with a line of small text at its right edge."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    layout = ConstrainedLayoutEngine(rect=(0, 0, 0.98, 1))
    figure = Figure(figsize=(9.0, 7.2), dpi=110, layout=layout)
    figure.suptitle(title, x=0.01, ha="left", fontsize=11)
    figure.text(0.998, 0.02, foot, rotation=90, ha="right", fontsize=5.5)
    return figure


# --- programs ---

STEPS = (0, 50, 75, 85, 92, 98, 100.1)
"""Limits of the colours of the coverage [%]."""


def draw_fits(figure: Figure, scores: pd.DataFrame) -> None:
    """Draw the error and the coverage of each program against its cost."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import BoundaryNorm

    scenes = list(scores.groupby("scene", sort=False))
    colours = ScalarMappable(BoundaryNorm(STEPS, 256), "RdYlBu")
    grid = figure.subplots(2, len(scenes), sharex=True, sharey="row")
    for (upper, lower), (scene, rows) in zip(grid.T, scenes, strict=True):
        upper.set_title("\n".join(textwrap.wrap(str(scene), 28)), fontsize=9.5)
        upper.set(xscale="log", yscale="log")
        lower.set(xlabel="CPU time for one lab [s]", ylim=(-3, 107))
        lower.axhline(100 * STATED, color=INK, linewidth=1)
        draw_scores(upper, rows, "error", colours)
        draw_scores(lower, rows, "coverage", colours)
    grid[0, 0].set_ylabel("error of I_zz, 68 % are closer [%]")
    grid[1, 0].set_ylabel("intervals with the true I_zz [%]")
    words = "coverage of the 95 % interval [%]"
    figure.colorbar(colours, ax=grid, label=words, ticks=STEPS[:-1])
    handles, _ = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)


def draw_scores(ax: Axes, rows: pd.DataFrame, name: str, colours: Any) -> None:
    """Draw one number of each program with its sampling error, against the cost."""
    centre: Any = {"ha": "center", "va": "center", "fontsize": 7.5}
    for number, row in enumerate(rows.to_dict("records"), start=1):
        value = 100 * row[name]
        ends = [[value - 100 * row[f"{name}_low"]], [100 * row[f"{name}_high"] - value]]
        look: Any = {"color": colours.to_rgba(100 * row["coverage"]), "mec": INK}
        label = f"{number} {row['program']}"
        ax.errorbar(
            row["seconds"], value, ends, fmt="o", ms=11, ecolor=INK, label=label, **look
        )
        ax.text(row["seconds"], value, str(number), zorder=4, **centre)
        if "process" in row and name == "error":
            ax.text(row["process"], value, str(number), color="#D55E00", **centre)


# --- motion ---

MODELS: dict[str, dict[str, Any]] = {
    "eq. (9)": {"color": "#0072B2", "marker": "o"},
    "eq. (8)": {"color": "#D55E00", "marker": "s"},
    "released from rest": {"color": "#CC79A7", "marker": "D"},
    "half of a release": {"color": "#009E73", "marker": "^"},
    FULL: {"color": INK, "marker": "o", "linewidth": 1},
    KNOWN: {"color": INK, "marker": "o", "linewidth": 1, "mfc": "white"},
}
"""Colour and marker of each model."""


def draw_motion(figure: Figure, points: pd.DataFrame) -> None:
    """Draw the cost of each model against its error, a panel for each kind of lab."""
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    for ax, (scene, panel) in zip(
        grid.flat, points.groupby("scene", sort=False), strict=True
    ):
        ax.set(xscale="log", yscale="log")
        ax.axhspan(DROP_ALL, 1, color="#F0E442", alpha=0.45)
        for method, look in MODELS.items():
            rows = panel[panel["method"] == method]
            ends = rows["error"] - rows["low"], rows["high"] - rows["error"]
            style = {"linewidth": 0, "markersize": 6, "elinewidth": 1, **look}
            ax.errorbar(rows["seconds"], rows["error"], ends, label=method, **style)
        chosen, u = panel.iloc[0][["chosen", "u"]]
        words = textwrap.wrap(f"gyro chooses {chosen}; u = {100 * u:.1f} %", 56)
        ax.set_title("\n".join([str(scene), *words]), fontsize=9)
        ax.set(xlabel="CPU time for nine runs [s]", ylabel="error of I_zz over its u")
        ax.label_outer()
    figure.legend(
        *grid[0, 0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=3,
        fontsize=8,
        title="median of the labs, with quartiles; harmless below the band",
        title_fontsize=8,
    )


# --- integrators ---

MARKERS = "<>vXo"


def draw_integrators(figure: Figure, curves: pd.DataFrame) -> None:
    """Draw the error of e3 against evaluations and against time, after few and many turns."""
    groups = list(curves.groupby("turns"))
    grid = figure.subplots(len(groups), 2, sharey=True, squeeze=False)
    for (left, right), (turns, rows) in zip(grid, groups, strict=True):
        label = f"error of e3, number of turns: {turns}"
        left.set(xscale="log", yscale="log", ylim=(1e-13, 10), ylabel=label)
        left.set_xlabel("evaluations of the torque")
        right.set(xscale="log", xlabel="CPU time, in Python [s]")
        methods = rows.groupby("method", sort=False)
        for marker, (method, curve) in zip(MARKERS, methods, strict=True):
            order = f"{fitted_order(curve):.2f}, nominal {curve['nominal'].iloc[0]}"
            style: Any = {"marker": marker, "markersize": 4, "linewidth": 1}
            words = f"{method}: {order}"
            left.plot(curve["evaluations"], curve["error"], label=words, **style)
            right.plot(curve["seconds"], curve["error"], **style)
        left.legend(loc="lower left", title="fitted order", fontsize=7.5)


# --- maps ---


def draw_map(figure: Figure, table: pd.DataFrame, kind: MapKind, place: Place) -> None:
    """Draw the number of each method in each cell; failures have a frame."""
    xs, ys = table["x"].unique(), table["y"].unique()
    figure.set_size_inches(9.0, 2.4 + 0.4 * len(ys))
    methods = list(table.groupby("program", sort=False))
    panels = figure.subplots(1, len(methods), sharex=True, sharey=True)
    for ax, (method, cells) in zip(panels, methods, strict=True):
        draw_cells(ax, cells, kind, (len(ys), len(xs)))
        ax.set_title(str(method), fontsize=9.5)
        ax.set(xticks=range(len(xs)), xticklabels=[f"{x:g}" for x in xs])
        ax.set(yticks=range(len(ys)), yticklabels=[f"{y:g}" for y in ys])
        ax.set_xlabel(kind.x_label)
        if place is not None:
            spots = [
                np.interp(place[0], xs, range(len(xs))),
                np.interp(place[1], ys, range(len(ys))),
            ]
            style: Any = {"color": "#E69F00", "mec": INK, "markersize": 18}
            ax.plot(*spots, "*", **style, label="your log")
            ax.legend(loc="upper left")
    panels[0].set_ylabel(kind.y_label)
    low, high = kind.good
    figure.supxlabel(
        f"Number: {kind.number_label}. Frame: the method fails (not {low:g} to {high:g})."
        f"\nDashed line: {kind.limit_label}. {kind.letters}",
        fontsize=8.5,
    )


def draw_cells(
    ax: Axes, cells: pd.DataFrame, kind: MapKind, shape: tuple[int, int]
) -> None:
    """Draw the cells of one method."""
    from matplotlib.patches import Rectangle

    values = cells[kind.number].to_numpy().reshape(shape)
    limit = cells["limit"].to_numpy().reshape(shape)
    low, high = kind.good
    off = (values - (low + high) / 2) / (high - low) * 2
    ax.imshow(off, "RdBu_r", aspect="auto", origin="lower", vmin=-3, vmax=3, alpha=0.7)
    ax.grid(visible=False)
    if np.nanmin(limit) < 1 < np.nanmax(limit):
        ax.contour(limit, [1.0], colors=INK, linestyles="--")
    for ((row, column), value), does in zip(
        np.ndenumerate(values), cells["does"], strict=True
    ):
        number = "" if np.isnan(value) else f"{value:.2f}"
        ax.text(column, row, f"{number} {does}", ha="center", va="center", fontsize=7.5)
        if value < low or value > high:
            corner = column - 0.46, row - 0.46
            ax.add_patch(Rectangle(corner, 0.92, 0.92, fill=False, linewidth=1.5))


CHARTS = {"fits": draw_fits, "motion": draw_motion, "integrators": draw_integrators}
"""The charts without a place for the log of the reader."""
