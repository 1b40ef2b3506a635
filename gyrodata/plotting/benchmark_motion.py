"""Time against error of the motion models and integrators, one panel a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gyrodata.benchmark.motion import MotionPanel, MotionPoint
from gyrodata.plotting.benchmark_labels import Named, head, log_axis, name_points, percent_text, power_text, time_text
from gyrodata.plotting.marks import INK
from gyrodata.plotting.style import STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOKS = {
    "eq. (9)": ("#0072B2", "o"),
    "eq. (9), plain mean spin": ("#0072B2", "v"),
    "eq. (9), spin at start": ("#0072B2", "^"),
    "eq. (8)": ("#D55E00", "s"),
    "mean rate": ("#CC79A7", "D"),
    "exact motion": ("#009E73", "P"),
    "splitting strang": ("#E69F00", "<"),
    "splitting aba84": ("#E69F00", ">"),
    "RK45": ("#56B4E9", "X"),
    "DOP853": ("#000000", "o"),
    "LSODA": ("#777777", "s"),
    "Radau": ("#777777", "^"),
}
"""Colour and marker of each method: Okabe and Ito's set, told apart by markers too."""

_FLOOR = 1e-16
"""Smaller errors are drawn here."""

_TIMES = (1e-8, 1e-6, 1e-4, 1e-2)
_ERRORS = (1e-16, 1e-12, 1e-8, 1e-4, 1.0)
_GOLD = "#F0E442"


def draw_motion(panels: Sequence[MotionPanel]) -> Figure:
    """Draw time against error, logarithmic, with u of I_zz as a band.

    Parameters
    ----------
    panels : sequence of MotionPanel
        Up to five.

    Returns
    -------
    matplotlib.figure.Figure
        9 × 6.3 inches.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.3), dpi=150)
        times = [point.seconds for panel in panels for point in panel.points]
        limits = (min(times) / 4, max(times) * 6)
        for i, panel in enumerate(panels):
            row, column = divmod(i, 3)
            ax = figure.add_axes((0.072 + 0.318 * column, 0.575 - 0.49 * row, 0.265, 0.34))
            _draw_panel(ax, panel, limits, first=column == 0)
        _draw_key(figure.add_axes((0.705, 0.085, 0.265, 0.37)), panels)
    return figure


def _draw_panel(ax: Axes, panel: MotionPanel, limits: tuple[float, float], first: bool) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(limits)
    ax.set_ylim(_FLOOR / 300, 50.0)
    shown = [time for time in _TIMES if limits[0] < time < limits[1]]
    log_axis("x", ax, shown, [time_text(time) for time in shown])
    log_axis("y", ax, _ERRORS, [power_text(error) for error in _ERRORS])
    ax.set_xlabel("time for one top")
    if first:
        ax.set_ylabel("relative error of I_zz")
    ax.axhspan(panel.bound, panel.u, color=_GOLD, alpha=0.55, linewidth=0)
    ax.text(0.995, 1.4 * panel.u, f"u = {percent_text(panel.u)}", transform=ax.get_yaxis_transform(), fontsize=7.5,
            ha="right", va="bottom", color=INK)  # fmt: skip
    for method, (colour, marker) in _LOOKS.items():
        points = [point for point in panel.points if point.method == method]
        if points:
            ax.plot(
                [point.seconds for point in points], [_height(point) for point in points], color=colour,
                marker=marker, markersize=5, markeredgecolor="white", markeredgewidth=0.4, linewidth=1.0, zorder=7,
            )  # fmt: skip
    winner = panel.winner
    ax.plot([winner.seconds], [_height(winner)], "o", markersize=12, color="none", markeredgecolor=INK,
            markeredgewidth=1.2, zorder=7)  # fmt: skip
    named = [
        Named(point.seconds, _height(point), point.method)
        for point in panel.points
        if point.family in ("closed form", "exact")
    ]
    others = [(point.seconds, _height(point)) for point in panel.points if point.family not in ("closed form", "exact")]
    name_points(ax, named, others, size=7.5)
    also = "the ladder takes it too" if winner.method == panel.ladder else f"the ladder takes {panel.ladder}"
    head(ax, panel.title, f"wins: {winner.method}; {also}")


def _height(point: MotionPoint) -> float:
    return max(point.error, _FLOOR)


def _draw_key(ax: Axes, panels: Sequence[MotionPanel]) -> None:
    """Say how to read the panels, and which marks are which."""
    ax.set_axis_off()
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1)
    words = (
        "Left-most under the band wins (ringed).",
        "Band: 0.3 u to u of I_zz in a lab of nine runs.",
        "Closed forms, splitting: in arrays of 500 tops.",
        "Integrators of scipy: one top at a time, from",
        "the loosest tolerance (top) to the tightest.",
        "Errors below 10⁻¹⁶ stand at 10⁻¹⁶.",
    )
    for i, line in enumerate(words):
        ax.text(-0.02, 1.02 - 0.082 * i, line, fontsize=8, color=INK, va="top")
    drawn = {point.method for panel in panels for point in panel.points}
    entries = [method for method in _LOOKS if method in drawn and not method.startswith("eq. (9),")]
    for i, method in enumerate(entries):
        column, row = divmod(i, 5)
        x, y = 0.02 + 0.5 * column, 0.47 - 0.095 * row
        colour, marker = _LOOKS[method]
        ax.plot([x], [y], marker=marker, color=colour, markersize=5.5, markeredgecolor="white", markeredgewidth=0.4)
        ax.text(x + 0.04, y, method, fontsize=8, color=INK, va="center")
