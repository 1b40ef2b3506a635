"""Where balanced gyroscopes point as the Earth turns under them, drawn against the time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gyrodata.physics import Floats, balanced_direction
from gyrodata.plotting.marks import INK, SOFT, draw_key, name_axes
from gyrodata.plotting.style import RULED, SIZE, Form, save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = {"north": "#0072B2", "east": "#D55E00"}
_LABELS = {"north": "started along\nthe Earth's axis,\nto the north", "east": "started level,\nto the east"}
_BEARINGS = ((0, "N 0"), (90, "E 90"), (180, "S 180"), (270, "W 270"), (360, "N 360"))


def draw_earth(latitude: float, times: Sequence[float]) -> Figure:
    """Draw altitude and azimuth of both gyroscopes against the hours of the clock."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    dots = np.asarray(times, dtype=float)
    fine = np.linspace(0.0, dots[-1], 1441)
    with rc_context(RULED):
        figure = Figure(figsize=SIZE, dpi=150)
        upper, lower = figure.add_axes((0.125, 0.53, 0.635, 0.34)), figure.add_axes((0.125, 0.125, 0.635, 0.34))
        for name, start in (("north", (0.0, latitude)), ("east", (math.pi / 2, 0.0))):
            course = balanced_direction(*start, latitude, fine)
            marks = balanced_direction(*start, latitude, dots)
            _draw_course(upper, fine, np.degrees(course[1]), _COLOURS[name])
            _draw_course(lower, fine, _parted(np.degrees(course[0])), _COLOURS[name])
            if len(dots) <= 100:
                _draw_dots(upper, dots, np.degrees(marks[1]), _COLOURS[name])
                _draw_dots(lower, dots, np.degrees(marks[0]), _COLOURS[name])
        _dress(upper, lower, dots[-1] / 3600)
        title = f"Where balanced gyroscopes point, latitude {math.degrees(latitude):.4g}°"
        upper.text(0.0, 1.17, title, transform=upper.transAxes, fontsize=10.5, weight="bold", color=INK)
        note = "seen from the ground, which turns under them; azimuth from north through east"
        upper.text(0.0, 1.06, note, transform=upper.transAxes, fontsize=8, color=SOFT)
    return figure


def _draw_course(ax: Axes, times: Floats, degrees: Floats, colour: str) -> None:
    ax.plot(times / 3600, degrees, color=colour, linewidth=1.4, clip_on=False)


def _draw_dots(ax: Axes, times: Floats, degrees: Floats, colour: str) -> None:
    ax.plot(times / 3600, degrees, "o", color=colour, markersize=3.5, clip_on=False, zorder=3)


def _parted(bearings: Floats) -> Floats:
    """Part the line where it goes through north, from 360° to 0°."""
    jump = np.abs(np.diff(bearings, prepend=bearings[0])) > 180
    return np.where(jump, np.nan, bearings)


def _dress(upper: Axes, lower: Axes, hours: float) -> None:
    """Limits, ticks, names of the axes and of the courses."""
    name_axes(upper, "", "altitude [°]")
    name_axes(lower, "time [hours of the clock]", "azimuth [°]")
    upper.set_ylim(-90, 90)
    upper.yaxis.set_ticks([-90, -45, 0, 45, 90])
    upper.axhline(0, color=SOFT, linewidth=0.8)
    lower.set_ylim(0, 360)
    lower.yaxis.set_ticks([degrees for degrees, _ in _BEARINGS], [label for _, label in _BEARINGS])
    every = next((step for step in (0.25, 1, 3, 6, 12, 24, 72) if hours <= 9 * step), None)
    for ax in (upper, lower):
        ax.set_xlim(0, hours)
        if every is not None:
            ax.xaxis.set_ticks(np.arange(0, hours * (1 + 1e-9), every))
    upper.tick_params(labelbottom=False)
    for height, name in ((0.85, "north"), (0.3, "east")):
        draw_key(upper, [1.03, 1.07], [height, height], _LABELS[name], 0.02, 8.5, color=_COLOURS[name], linewidth=2,
                 clip_on=False)  # fmt: skip


def render_earth(latitude: float, times: Sequence[float], form: Form = "png") -> bytes:
    """Draw the figure as a file."""
    from matplotlib import rc_context

    figure = draw_earth(latitude, times)
    with rc_context(RULED):
        return save(figure, form)
