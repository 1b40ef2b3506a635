"""The charts of `gyro benchmark`, one function each, 9 inches wide."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
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
from gyrodata.trials.benchmark.motions import KNOWN
from gyrodata.trials.benchmark.report import Benchmark

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STYLES = figures.STYLE, Path(__file__).with_suffix(".mplstyle")

CENTRE: Any = {"ha": "center", "va": "center", "fontsize": 7.5}


def render(done: Benchmark, workers: int) -> dict[str, bytes]:
    """Draw all charts in several processes; return the bytes of each PNG by name."""
    titles = report.titles(done)
    tasks = {name: partial(draw, name, titles[name], done) for name in titles}
    return dict(report.answers_of(tasks, workers))


def draw(name: str, title: str, done: Benchmark) -> bytes:
    """Draw one chart."""
    from matplotlib.figure import Figure

    with figures.own_style(*STYLES):
        figure = Figure(figsize=(9.0, 7.2), dpi=80, layout="constrained")
        table = done.tables[name]
        note = report.labs_text(done) if "labs" in table else ""
        figure.suptitle(f"{title}\n{note}".strip(), x=0.01, ha="left", fontsize=10)
        DRAWINGS[name](figure, table)
        return figures.save(figure, "png", 9)


def draw_points(ax: Axes, rows: pd.DataFrame, name: str, colours: Any) -> None:
    """Draw a number of each method against its cost, with the ends of its interval.

    The label of a point is the number of its method in the list of methods.
    """
    numbers = rows[rows.columns[1]].factorize()[0] + 1
    values = rows[name]
    at = rows["seconds"], values
    ends = values - rows[f"{name}_low"], rows[f"{name}_high"] - values
    ax.errorbar(*at, ends, fmt="none", ecolor=INK)
    ax.scatter(*at, s=130, c=colours, edgecolors=INK, zorder=3)
    for number, x, y in zip(numbers, *at, strict=True):
        ax.text(x, y, str(number), zorder=4, **CENTRE)


def list_methods(figure: Figure, rows: pd.DataFrame, words: str) -> None:
    """Write the names of the methods below the panels, after some words."""
    methods = rows[rows.columns[1]].unique()
    names = [f"{number} {method}" for number, method in enumerate(methods, start=1)]
    text = textwrap.fill(f"{words}: {', '.join(names)}.", 125)
    figure.supxlabel(text, fontsize=8.5)


def draw_fits(figure: Figure, scores: pd.DataFrame) -> None:
    """Draw the error and the coverage of each program against its cost."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    coverage = ScalarMappable(Normalize(0.5, 1.0), "RdYlBu")
    scenes = list(scores.groupby("scene", sort=False))
    grid = figure.subplots(2, len(scenes), sharex=True, sharey="row")
    for (upper, lower), (scene, rows) in zip(grid.T, scenes, strict=True):
        colours = coverage.to_rgba(rows["coverage"].to_numpy())
        draw_points(upper, rows, "error", colours)
        draw_points(lower, rows, "coverage", colours)
        lower.axhline(STATED, color=INK, linewidth=1)
        upper.set_title(textwrap.fill(str(scene), 27), fontsize=9)
        upper.set(xscale="log", yscale="log", ylabel="error of I_zz, 68 % are closer")
        lower.set(
            xlabel="CPU time for one lab [s]", ylabel="intervals with the true I_zz"
        )
        upper.label_outer()
        lower.label_outer()
        if "process" in rows:
            upper.plot(rows["process"], rows["error"], ",", color="red")
            for number, row in enumerate(rows.itertuples(), start=1):
                upper.text(row.process, row.error, str(number), color="red", **CENTRE)
    figure.colorbar(coverage, ax=grid, label="coverage of the 95 % interval")
    list_methods(figure, rows, "Red: cost of a whole process. Programs")


def draw_motion(figure: Figure, points: pd.DataFrame) -> None:
    """Draw the cost of each model against its error, a panel for each kind of lab."""
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    panels = points.groupby("scene", sort=False)
    for ax, (scene, panel) in zip(grid.flat, panels, strict=True):
        ax.axhspan(DROP_ALL, 1, color="#F0E442", alpha=0.45)
        colours = np.where(panel["method"] == KNOWN, "white", "#56B4E9")
        draw_points(ax, panel, "error", colours)
        chosen, u = panel.iloc[0][["chosen", "u"]]
        words = textwrap.fill(f"gyro chooses {chosen}; u = {100 * u:.1f} %", 52)
        ax.set_title(f"{scene}\n{words}", fontsize=8.5)
        ax.set(xscale="log", xlabel="CPU time for nine runs [s]")
        ax.set(yscale="log", ylabel="error of I_zz over its u")
        ax.label_outer()
    words = "Median of the labs with quartiles; harmless below the band. Models"
    list_methods(figure, points, words)


def draw_integrators(figure: Figure, curves: pd.DataFrame) -> None:
    """Draw the error of e3 against evaluations and time, after few and many turns."""
    groups = list(curves.groupby("turns"))
    grid = figure.subplots(len(groups), 2, sharey=True, squeeze=False)
    for (left, right), (turns, rows) in zip(grid, groups, strict=True):
        left.set(xscale="log", xlabel="evaluations of the torque")
        left.set(yscale="log", ylabel=f"error of e3 after turns: {turns}")
        right.set(xscale="log", xlabel="CPU time, in Python [s]")
        for method, curve in rows.groupby("method", sort=False):
            nominal = curve["nominal"].iloc[0]
            order = fitted_order(curve)
            fitted = "too few points" if np.isnan(order) else f"{order:.2f}"
            label = f"{method}: {fitted}, nominal {nominal}"
            left.plot(curve["evaluations"], curve["error"], ".-", label=label)
            right.plot(curve["seconds"], curve["error"], ".-")
        left.legend(loc="lower left", title="fitted order", fontsize=7.5)


def draw_map(kind: MapKind, figure: Figure, table: pd.DataFrame) -> None:
    """Draw the number of each method in each cell; failures have a frame."""
    xs = table["x"].unique()
    ys = table["y"].unique()
    figure.set_size_inches(9.0, 2.6 + 0.35 * len(ys))
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    methods = table.groupby("program", sort=False)
    for ax, (method, cells) in zip(panels, methods, strict=True):
        draw_cells(ax, cells, kind, (len(ys), len(xs)))
        ax.set_title(str(method), fontsize=9.5)
        ax.set(xlabel=kind.x_label, xticks=range(len(xs)), xticklabels=xs)
        ax.set(ylabel=kind.y_label, yticks=range(len(ys)), yticklabels=ys)
        ax.label_outer()
    low, high = kind.good
    words = (
        f"Number: {kind.number_label}. Frame: fails, because it is not {low:g} to "
        f"{high:g}.\nDashed line: {kind.limit_label}. {kind.letters}"
    )
    figure.supxlabel(words, fontsize=8.5)


def draw_cells(
    ax: Axes, cells: pd.DataFrame, kind: MapKind, shape: tuple[int, int]
) -> None:
    """Draw the cells of one method."""
    values = cells[kind.number].to_numpy().reshape(shape)
    limit = cells["limit"].to_numpy().reshape(shape)
    low, high = kind.good
    off = (values - (low + high) / 2) / (high - low)
    ax.imshow(
        off, "RdBu_r", aspect="auto", origin="lower", vmin=-1.5, vmax=1.5, alpha=0.6
    )
    ax.grid(visible=False)
    if np.nanmin(limit) < 1 < np.nanmax(limit):
        ax.contour(limit, [1.0], colors=INK, linestyles="--")
    places = np.ndindex(shape)
    for (y, x), value, does in zip(places, values.flat, cells["does"], strict=True):
        number = "" if np.isnan(value) else f"{round(value, 2) + 0:.2f}"
        box = {"fill": False, "pad": 2} if value < low or value > high else None
        ax.text(x, y, f"{number} {does}".strip(), bbox=box, **CENTRE)


DRAWINGS: dict[str, Callable[[Figure, pd.DataFrame], None]] = {
    "fits": draw_fits,
    "motion": draw_motion,
    "integrators": draw_integrators,
    **{kind.name: partial(draw_map, kind) for kind in KINDS},
}
"""The function that draws each chart."""
