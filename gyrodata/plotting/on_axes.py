"""A figure of a log on axes of matplotlib that a caller has, in a notebook: to be changed and put beside others."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrodata.errors import insist_on_choice, insist_on_type
from gyrodata.physics import RPM, Floats
from gyrodata.plotting.figure_data import Scene, gather, line_band
from gyrodata.plotting.figures import FIGURES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gyrodata.results import Analysis


def plot_on(analysis: Analysis, name: str, ax: Axes | None = None) -> Axes:
    """Draw the runs of one of `FIGURES` on axes, new ones if none are given; ValueError for a name that is none."""
    from matplotlib.axes import Axes

    insist_on_choice("name", name, FIGURES)
    insist_on_type("ax", ax, Axes | None, "axes of matplotlib")
    if ax is None:
        from matplotlib import pyplot

        ax = pyplot.figure().add_subplot()
    scene = gather(analysis)
    drawn: dict[str, tuple[Floats, Floats, Floats | None, Floats, str, str]] = {
        "period": (scene.spin, scene.period, scene.spin_u, scene.period_u, "spin ψ̇ [rpm]", "precession period τ [s]"),
        "product": (scene.spin, scene.product, scene.spin_u, scene.product_u, "spin ψ̇ [rpm]", "φ̇ψ̇ [rad²/s²]"),
        "torque": (scene.product, scene.torque, scene.product_u, scene.torque_u, "φ̇ψ̇ [rad²/s²]", "torque M [N·m]"),
        "residuals": (
            np.arange(1.0, len(scene.names) + 1), scene.deviations, None, np.ones(len(scene.names)),
            "run, in the order of the log", "time − prediction [u]",
        ),
    }  # fmt: skip
    x, y, x_u, y_u, x_label, y_label = drawn[name]
    for group in scene.groups:
        for hollow in (False, True):
            at = [i for i in group.members if scene.hollow[i] == hollow]
            style: dict[str, Any] = {"color": group.colour, "marker": group.marker, "linestyle": "none"}
            if at:
                ax.errorbar(
                    x[at], y[at], yerr=y_u[at], xerr=None if x_u is None else x_u[at], **style,
                    fillstyle="none" if hollow else "full", label=group.label + (", flagged" if hollow else ""),
                )  # fmt: skip
    _LINES[name](scene, ax)
    ax.set_xlabel(x_label)
    ax.set_ylabel(y_label)
    return ax


def _laws(scene: Scene, ax: Axes) -> None:
    for group in scene.groups:
        working = abs(group.summary.torque + scene.imbalance)
        if group.summary.torque and working:
            ax.axline((0.0, 0.0), slope=2 * math.pi * scene.inertia * RPM / working, color=group.colour, lw=1.0)
    # A run without a weight may take an hour for a turn.
    ax.set_ylim(0.0, 1.15 * float(scene.period[scene.loaded].max()))


def _means(scene: Scene, ax: Axes) -> None:
    for group in scene.groups:
        mean, half = group.summary.product.value, 2 * (group.summary.product.u or 0.0)
        ax.axhspan(mean - half, mean + half, color=group.colour, alpha=0.2, lw=0.0)
        ax.axhline(mean, color=group.colour, lw=1.0)


def _line(scene: Scene, ax: Axes) -> None:
    x = np.linspace(min(0.0, 1.06 * scene.product.min()), max(0.0, 1.06 * scene.product.max()), 41)
    line, (down, up) = x * scene.inertia - scene.imbalance, line_band(scene, x)
    ax.fill_between(x, line - down, line + up, color="#0072B2", alpha=0.15, lw=0.0)
    ax.plot(x, line, color="#222222", lw=1.2)


def _expected(_: Scene, ax: Axes) -> None:
    ax.axhspan(-2.0, 2.0, color="#0072B2", alpha=0.1, lw=0.0)
    ax.axhline(0.0, color="#666666", lw=0.8)


_LINES = {"period": _laws, "product": _means, "torque": _line, "residuals": _expected}
