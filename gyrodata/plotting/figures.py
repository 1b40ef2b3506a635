"""The four figures of a log, and that of balanced gyroscopes above the turning Earth; and their files."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from gyrodata.physics import RPM, Floats, balanced_direction
from gyrodata.plotting.figure_data import Scene, gather, mean_text, torque_unit, with_u
from gyrodata.plotting.marks import (
    INK,
    MEDIA,
    RULED,
    SIZE,
    SOFT,
    Form,
    Marks,
    Medium,
    bars_note,
    draw_key,
    draw_runs,
    label_margin,
    log_ticks,
    measure_axes,
    name_axes,
    name_dots,
    odd_names,
    save,
    with_hollow,
    write_title,
    zero_range,
)
from gyrodata.results import Analysis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FIGURES = ("period", "product", "torque", "residuals")
"""Names of the figures, in the order of the report."""


def _draw_period(ax: Axes, scene: Scene) -> None:
    """Period against spin, with the fitted law of each torque."""
    working = np.array([abs(group.summary.torque + scene.imbalance) for group in scene.groups])
    with np.errstate(divide="ignore"):
        slopes = 2 * math.pi * scene.inertia / (1 / RPM) / working
    # A run without a weight may take an hour for a turn: it has no say in the limits.
    period, hollow = scene.period[scene.loaded], scene.hollow[scene.loaded]
    kept = period[~hollow] if not hollow.all() else period
    logarithmic = bool(kept.max() > 6 * np.median(kept))
    right = 1.06 * float((scene.spin + scene.spin_u).max())
    ends = slopes * right
    if logarithmic:
        left, bottom = float(scene.spin.min()) / 1.3, float(period.min()) / 1.4
        top = 1.5 * float(period.max())
        top = max([top, *(1.15 * ends[ends < 3 * top])])
        ax.set_xscale("log")
        ax.set_yscale("log")
    else:
        left = bottom = 0.0
        top = zero_range(period, scene.period_u[scene.loaded], hollow)[1]
        top = max([top, *(1.01 * ends[ends < 1.3 * top])])
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    for axis, limits in ((ax.xaxis, (left, right)), (ax.yaxis, (bottom, top))) if logarithmic else ():
        axis.set_ticks(log_ticks(*limits))
        axis.set_ticks([], minor=True)
    logs = ", log scale" if logarithmic else ""
    name_axes(ax, f"spin ψ̇ [rpm{logs}]", f"precession period τ [s{logs}]")
    # A law that leaves the axes at once would only be a stroke along their edge.
    inside = [(group.colour, slope) for group, slope in zip(scene.groups, slopes, strict=True)
              if slope * right < 8 * top]  # fmt: skip
    _laws(ax, inside, left, right)
    shown = np.clip(scene.period, bottom, top)
    bars = np.where(shown == scene.period, np.minimum(scene.period_u, shown - bottom), 0.0)
    marks = Marks(scene.spin, shown, scene.spin_u, bars)
    draw_runs(ax, scene, marks)
    name_dots(ax, marks.x, marks.y, odd_names(scene, scene.period, shown, " s", "↓↑"))
    label_margin(ax, scene, [float(min(end, top)) for end in ends])
    law = f"lines: τ = 2π I_zz ψ̇ / |M + M0|; {bars_note(ax, marks)}"
    write_title(ax, "Precession period against spin", with_hollow(scene, law))


def _laws(ax: Axes, laws: Sequence[tuple[str, float]], left: float, right: float) -> None:
    """Lines y = slope·x from the left to the right edge, straight on linear and on logarithmic axes."""
    from matplotlib.collections import LineCollection

    drawn = [(colour, slope) for colour, slope in laws if math.isfinite(slope)]
    segments = [np.array([(left, slope * left), (right, slope * right)]) for _, slope in drawn]
    ax.add_collection(LineCollection(segments, colors=[colour for colour, _ in drawn], linewidths=1.0), autolim=False)


def _draw_product(ax: Axes, scene: Scene) -> None:
    """φ̇ψ̇ against spin: level for each torque, with the mean and its band."""
    from matplotlib.collections import LineCollection, PolyCollection

    right = 1.06 * float((scene.spin + scene.spin_u).max())
    bottom, top = zero_range(scene.product, scene.product_u, scene.hollow)
    ax.set_xlim(0.0, right)
    ax.set_ylim(bottom, top)
    name_axes(ax, "spin ψ̇ [rpm]", "φ̇ψ̇ [rad²/s²]")
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
        ax.axhline(0, color=SOFT, linewidth=0.8)
    product = np.clip(scene.product, bottom, top)
    marks = Marks(scene.spin, product, scene.spin_u, scene.product_u)
    draw_runs(ax, scene, marks)
    name_dots(ax, marks.x, marks.y, odd_names(scene, scene.product, product, "", "↓↑"))
    label_margin(ax, scene, means, [mean_text(group) for group in scene.groups])
    bands = f"bands: weighted mean ± 2u; {bars_note(ax, marks)}"
    write_title(ax, "Precession rate × spin for each torque", with_hollow(scene, bands))


def _draw_torque(ax: Axes, scene: Scene) -> None:
    """Torque against φ̇ψ̇ with the recommended line, its 95 % band, and the line through the origin."""
    unit, factor = torque_unit(float(np.abs(scene.torque).max()))
    left, right = zero_range(scene.product, scene.product_u, scene.hollow)
    torque, torque_u = factor * scene.torque, factor * scene.torque_u
    x = np.linspace(left, right, 41)
    line = x * scene.inertia - scene.imbalance
    (v_inertia, cov), (_, v_imbalance) = scene.covariance
    half = 1.96 * np.sqrt(np.maximum(x**2 * v_inertia - 2 * x * cov + v_imbalance, 0.0))
    low, high = zero_range(torque, torque_u, scene.hollow)
    ends = factor * line[[0, -1]]
    low, high = min(low, float(ends.min()) - 0.02 * (high - low)), max(high, float(ends.max()))
    ax.set_xlim(left, right)
    # Room for the key of two lines above the fitted ones.
    ax.set_ylim(low, high + (high - low) * 30 / measure_axes(ax)[1])
    name_axes(ax, "precession rate × spin, φ̇ψ̇ [rad²/s²]", f"torque M [{unit}]")
    ax.fill_between(x, factor * (line - half), factor * (line + half), color="#0072B2", alpha=0.15, linewidth=0)
    ax.plot(x, factor * line, color=INK, linewidth=1.2)
    rows = [("-", "M = I_zz φ̇ψ̇ − M0, with its 95 % band")]
    if scene.origin is not None:
        ax.plot(x[[0, -1]], factor * scene.origin * x[[0, -1]], "--", color=SOFT, linewidth=0.9, dashes=(5, 4))
        rows.append(("--", f"through the origin: {with_u(scene.origin, scene.origin_u)} kg·m²"))
    if low < 0:
        ax.axhline(0, color=SOFT, linewidth=0.8)
    if left < 0 < right:
        ax.axvline(0, color=SOFT, linewidth=0.8)
    product = np.clip(scene.product, left, right)
    marks = Marks(product, torque, scene.product_u, torque_u)
    draw_runs(ax, scene, marks)
    name_dots(ax, marks.x, marks.y, odd_names(scene, scene.product, product, "", "←→"))
    label_margin(ax, scene, [factor * group.summary.torque for group in scene.groups])
    _key(ax, rows)
    write_title(ax, f"I_zz = {scene.inertia_text}", with_hollow(scene, f"torque against φ̇ψ̇; {bars_note(ax, marks)}"))


def _key(ax: Axes, rows: Sequence[tuple[str, str]]) -> None:
    """Say what the lines are, top left, where a rising line never is."""
    wide, tall = measure_axes(ax)
    for rank, (style, text) in enumerate(rows):
        height = 1 - (8 + 11.7 * rank) / tall
        colour = INK if style == "-" else SOFT
        draw_key(
            ax, [6 / wide, 23 / wide], [height, height], text, 4 / wide, linestyle=style, color=colour, linewidth=1.1
        )


def _draw_residuals(ax: Axes, scene: Scene) -> None:
    """Each run's time against what the others predict, in standard uncertainties, in the order of the log."""
    count = len(scene.names)
    place = np.arange(1.0, count + 1)
    deviations = np.nan_to_num(scene.deviations)
    limit = max(3.5, 1.15 * float(np.abs(deviations[~scene.hollow]).max(initial=0.0)))
    ax.set_xlim(0.4, count + 0.6)
    ax.set_ylim(-limit, limit)
    name_axes(ax, "run, in the order of the log", "time − prediction [u]")
    ax.axhspan(-2, 2, color="#0072B2", alpha=0.1, linewidth=0)
    ax.axhline(0, color=SOFT, linewidth=0.8)
    _run_ticks(ax, scene.names)
    nothing = np.zeros(count)
    height = np.clip(deviations, -0.96 * limit, 0.96 * limit)
    marks = Marks(place, height, nothing, nothing)
    draw_runs(ax, scene, marks, bars=False)
    told = np.where(height == deviations, deviations, np.round(deviations))
    name_dots(ax, marks.x, marks.y, odd_names(scene, told, height, " u", "↓↑"))
    label_margin(ax, scene, None)
    kept = np.abs(deviations[~scene.left_out])
    inside = int(np.sum(kept <= 2))
    title = f"Residuals: {inside} of {len(kept)} runs within ± 2 standard uncertainties"
    if scene.dof < 1:
        title = "Residuals: as many unknowns as runs, so they tell nothing"
    write_title(ax, title, with_hollow(scene, "predicted by the other runs; about 95 % of good runs lie in the band"))


def _run_ticks(ax: Axes, names: Sequence[str]) -> None:
    """Runs by their names where these have room, else every so many."""
    count = len(names)
    # About 58 characters fit below the axes.
    step = max(1, math.ceil(count * (max(len(name) for name in names) + 1.5) / 58))
    ax.xaxis.set_ticks(np.arange(1, count + 1)[::step], list(names[::step]))


_DRAWERS: dict[str, Callable[[Axes, Scene], None]] = {
    "period": _draw_period,
    "product": _draw_product,
    "torque": _draw_torque,
    "residuals": _draw_residuals,
}


def draw(analysis: Analysis, name: str, medium: Medium = MEDIA["screen"]) -> Figure:
    """Draw one figure."""
    from matplotlib import rc_context

    with rc_context(RULED):
        return _figure(gather(analysis, medium.grey_safe), name, medium)


def _figure(scene: Scene, name: str, medium: Medium) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=medium.size, dpi=medium.dpi)
    _DRAWERS[name](figure.add_axes(medium.frame), scene)
    return figure


def render(analysis: Analysis, form: Form = "png", medium: Medium = MEDIA["screen"]) -> dict[str, bytes]:
    """Draw all figures as files."""
    from matplotlib import rc_context

    with rc_context(RULED), warnings.catch_warnings():
        # A run's name may be written in a script that the font does not have; it is drawn as boxes then.
        warnings.filterwarnings("ignore", message="(?s).*[Gg]lyph.* missing")
        scene = gather(analysis, medium.grey_safe)
        return {name: save(_figure(scene, name, medium), form) for name in FIGURES}


# --- the Earth that turns below ------------------------------------------------------------------------------

_EARTH_COLOURS = {"north": "#0072B2", "east": "#D55E00"}
_EARTH_LABELS = {"north": "started along\nthe Earth's axis,\nto the north", "east": "started level,\nto the east"}
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
            _draw_course(upper, fine, np.degrees(course[1]), _EARTH_COLOURS[name])
            _draw_course(lower, fine, _parted(np.degrees(course[0])), _EARTH_COLOURS[name])
            if len(dots) <= 100:
                _draw_dots(upper, dots, np.degrees(marks[1]), _EARTH_COLOURS[name])
                _draw_dots(lower, dots, np.degrees(marks[0]), _EARTH_COLOURS[name])
        _dress_earth(upper, lower, dots[-1] / 3600)
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


def _dress_earth(upper: Axes, lower: Axes, hours: float) -> None:
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
        draw_key(upper, [1.03, 1.07], [height, height], _EARTH_LABELS[name], 0.02, 8.5,
                 color=_EARTH_COLOURS[name], linewidth=2, clip_on=False)  # fmt: skip


def render_earth(latitude: float, times: Sequence[float]) -> bytes:
    """Draw the figure as a PNG."""
    from matplotlib import rc_context

    figure = draw_earth(latitude, times)
    with rc_context(RULED):
        return save(figure, "png")
