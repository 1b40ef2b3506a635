"""Time for a fit against the error of I_zz, every estimator in four kinds of lab, its coverage as colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gyrodata.benchmark.trials import HONEST, Trial, TrialPanel
from gyrodata.plotting.benchmark_labels import Named, head, log_axis, name_points, percent_text, time_text
from gyrodata.plotting.marks import INK, SOFT, log_ticks
from gyrodata.plotting.style import STYLE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHADES = ((HONEST, "#0072B2", "o"), (0.8, "#56B4E9", "s"), (0.5, "#E69F00", "^"), (-1.0, "#D55E00", "v"))
"""Least coverage, colour and marker, from Okabe and Ito's set: blue is honest, orange is not."""

_TIMES = (1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0)

_KEY = ("93.5 % and more", "80 to 93.5 %", "50 to 80 %", "less than 50 %")


def draw_trials(panels: Sequence[TrialPanel]) -> Figure:
    """Draw time for a fit against the root mean square error of I_zz, both logarithmic.

    Parameters
    ----------
    panels : sequence of TrialPanel
        Four to draw, and one of labs with weights on one side, to be told of in the key.

    Returns
    -------
    matplotlib.figure.Figure
        9 × 7.4 inches.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 7.4), dpi=150)
        times = [trial.seconds for panel in panels for trial in panel.trials]
        for i, panel in enumerate(panels[:4]):
            row, column = divmod(i, 2)
            ax = figure.add_axes((0.085 + 0.49 * column, 0.605 - 0.46 * row, 0.415, 0.335))
            _draw_panel(ax, panel, times, first=column == 0, last=row == 1)
        _draw_key(figure.add_axes((0.085, 0.008, 0.905, 0.075)), panels[4])
    return figure


def _look(trial: Trial) -> tuple[str, str]:
    if trial.honest:
        return _SHADES[0][1:]
    return next((colour, marker) for least, colour, marker in _SHADES[1:] if trial.coverage >= least)


def _draw_panel(ax: Axes, panel: TrialPanel, times: Sequence[float], first: bool, last: bool) -> None:
    errors = [trial.rmse for trial in panel.trials]
    limits = (min(times) / 2.5, max(times) * 2.5), (min(errors) / 1.8, max(errors) * 1.6)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(limits[0])
    ax.set_ylim(limits[1])
    shown = [time for time in _TIMES if limits[0][0] < time < limits[0][1] / 1.3]
    log_axis("x", ax, shown, [time_text(time) for time in shown])
    log_axis("y", ax, ticks := log_ticks(*limits[1]), [percent_text(tick) for tick in ticks])
    ax.grid(axis="y", color="#dddddd", linewidth=0.6)
    if last:
        ax.set_xlabel("time for one fit")
    if first:
        ax.set_ylabel("RMSE of I_zz")
    for trial in panel.trials:
        colour, marker = _look(trial)
        mine = trial.estimator == "recommended"
        ax.plot(
            [trial.seconds], [trial.rmse], marker=marker, color=colour, markersize=9 if mine else 6,
            markeredgecolor=INK if mine else "white", markeredgewidth=1.2 if mine else 0.5, zorder=7,
        )  # fmt: skip
    order = sorted(panel.trials, key=lambda trial: trial.estimator != "recommended")
    named = [
        Named(trial.seconds, trial.rmse, trial.estimator, bold=trial.estimator == "recommended") for trial in order
    ]
    name_points(ax, named, size=7.5)
    head(ax, panel.scene.title, panel.scene.words)


def _draw_key(ax: Axes, one_side: TrialPanel) -> None:
    ax.set_axis_off()
    ax.set_xlim(0, 1)
    ax.set_ylim(0, 1)
    ax.text(0.0, 0.85, "the 95 % interval holds the truth in", fontsize=8, color=INK, va="center")
    for i, ((_, colour, marker), text) in enumerate(zip(_SHADES, _KEY, strict=True)):
        x = 0.29 + 0.17 * i
        ax.plot([x], [0.85], marker=marker, color=colour, markersize=6, markeredgecolor="white", markeredgewidth=0.5)
        ax.text(x + 0.015, 0.85, text, fontsize=8, color=INK, va="center")
    note = "M is the torque, P = φ̇ψ̇; 18 runs a lab, three weights at three spins on either side of the ball"
    ax.text(0.0, 0.47, note, fontsize=7.5, color=SOFT, va="center")
    best, mine = one_side.best, one_side.recommended
    if best is not None and best is not mine:
        note = (
            "with weights on one side only and a ball that is in perfect balance, who takes that for granted is better "
            f"off: {best.estimator} {100 * best.rmse:.2f} %, recommended {100 * mine.rmse:.2f} %"
        )
        ax.text(0.0, 0.15, note, fontsize=7.5, color=SOFT, va="center")
