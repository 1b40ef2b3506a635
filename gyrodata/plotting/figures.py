"""The four figures of a log, and that of balanced gyroscopes above the turning Earth; and their files."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence

import numpy as np

from gyrodata.physics import RPM, Floats, balanced_direction
from gyrodata.plotting.figure_data import Scene, gather, line_band, mean_text, torque_unit, with_u
from gyrodata.plotting.marks import (
    MEDIA,
    Marks,
    Medium,
    bars_note,
    draw_axes,
    draw_runs,
    label_margin,
    list_labels,
    log_ticks,
    name_runs,
    number_ticks,
    odd_names,
    round_ticks,
    with_hollow,
    write_title,
    zero_range,
)
from gyrodata.plotting.sheet import INK, SOFT, STYLE, Box, Dots, Form, Panel, Sheet, Strokes, Words
from gyrodata.results import Analysis

FIGURES = ("period", "product", "torque", "residuals")
"""Names of the figures, in the order of the report."""

_BAND = "#0072B2"


def _draw_period(scene: Scene, medium: Medium) -> Sheet:
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
    else:
        left = bottom = 0.0
        top = zero_range(period, scene.period_u[scene.loaded], hollow)[1]
        top = max([top, *(1.01 * ends[ends < 1.3 * top])])
    labels = list_labels(scene, medium, medium.room(2))
    sheet = medium.sheet()
    panel = Panel(sheet, medium.boxes(labels.right, 2)[0], (left, right), (bottom, top), logarithmic)
    logs = ", log scale" if logarithmic else ""
    ticks = [number_ticks(log_ticks(*limits)) for limits in (panel.x, panel.y)] if logarithmic else []
    draw_axes(panel, f"spin ψ̇ [rpm{logs}]", f"precession period τ [s{logs}]", *ticks)
    # A law that leaves the axes at once would only be a stroke along their edge.
    for group, slope in zip(scene.groups, slopes.tolist(), strict=True):
        if slope * right < 8 * top:
            # Straight on linear and on logarithmic axes.
            panel.line((left, right), (slope * left, slope * right), group.colour)
    shown = np.clip(scene.period, bottom, top)
    bars = np.where(shown == scene.period, np.minimum(scene.period_u, shown - bottom), 0.0)
    marks = Marks(scene.spin, shown, scene.spin_u, bars)
    draw_runs(panel, scene, marks)
    name_runs(panel, marks.x, marks.y, odd_names(scene, scene.period, shown, " s", "↓↑"))
    label_margin(panel, scene, labels, [float(min(end, top)) for end in ends])
    law = f"lines: τ = 2π I_zz ψ̇ / |M + M0|; {bars_note(panel, marks)}"
    write_title(sheet, "Precession period against spin", with_hollow(scene, law))
    return sheet


def _draw_product(scene: Scene, medium: Medium) -> Sheet:
    """φ̇ψ̇ against spin: level for each torque, with the mean and its band."""
    labels = list_labels(scene, medium, medium.room(2), [mean_text(group) for group in scene.groups])
    sheet = medium.sheet()
    limits = (0.0, 1.06 * float((scene.spin + scene.spin_u).max()))
    bottom, top = zero_range(scene.product, scene.product_u, scene.hollow)
    panel = Panel(sheet, medium.boxes(labels.right, 2)[0], limits, (bottom, top))
    draw_axes(panel, "spin ψ̇ [rpm]", "φ̇ψ̇ [rad²/s²]")
    means = [group.summary.product.value for group in scene.groups]
    for group, mean in zip(scene.groups, means, strict=True):
        half = np.full(2, 2 * (group.summary.product.u or 0.0))
        panel.band(limits, mean - half, mean + half, group.colour, 0.2)
        panel.level(mean, group.colour, 1.0)
    if bottom < 0 < top:
        panel.level(0.0, SOFT, 0.8)
    product = np.clip(scene.product, bottom, top)
    marks = Marks(scene.spin, product, scene.spin_u, scene.product_u)
    draw_runs(panel, scene, marks)
    name_runs(panel, marks.x, marks.y, odd_names(scene, scene.product, product, "", "↓↑"))
    label_margin(panel, scene, labels, means)
    bands = f"bands: weighted mean ± 2 u; {bars_note(panel, marks)}"
    write_title(sheet, "Precession rate × spin for each torque", with_hollow(scene, bands))
    return sheet


def _draw_torque(scene: Scene, medium: Medium) -> Sheet:
    """Torque against φ̇ψ̇ with the recommended line, its 95 % band, the line through the origin, and what is left."""
    strokes = ["M = I_zz φ̇ψ̇ − M0, with its 95 % band"]
    if scene.origin is not None:
        strokes.append(f"through the origin: {with_u(scene.origin, scene.origin_u)} kg·m²")
    rows = 1 + len(strokes)
    labels = list_labels(scene, medium, 0.6 * medium.room(rows, strip=True))
    sheet = medium.sheet(strip=True)
    upper, lower = medium.boxes(labels.right, rows, strip=True)
    unit, factor = torque_unit(float(np.abs(scene.torque).max()))
    x = np.linspace(*zero_range(scene.product, scene.product_u, scene.hollow), 41)
    limits = (float(x[0]), float(x[-1]))
    torque, torque_u = factor * scene.torque, factor * scene.torque_u
    line = factor * (x * scene.inertia - scene.imbalance)
    down, up = (factor * way for way in line_band(scene, x))
    low, high = zero_range(torque, torque_u, scene.hollow)
    low, high = min(low, float(line.min()) - 0.02 * (high - low)), max(high, float(line.max()))
    panel = Panel(sheet, upper, limits, (low, high))
    draw_axes(panel, "", f"torque M [{unit}]")
    panel.band(x, line - down, line + up, _BAND, 0.15)
    panel.line(limits, line[[0, -1]], INK, 1.2)
    if scene.origin is not None:
        panel.line(limits, factor * scene.origin * x[[0, -1]], SOFT, 0.9, dashed=True)
    panel.level(0.0, SOFT, 0.8)
    if limits[0] < 0 < limits[1]:
        panel.plumb(0.0, SOFT, 0.8)
    product = np.clip(scene.product, *limits)
    draw_runs(panel, scene, Marks(product, torque, scene.product_u, torque_u))
    name_runs(panel, product, torque, odd_names(scene, scene.product, product, "", "←→"))
    label_margin(panel, scene, labels, [factor * group.summary.torque for group in scene.groups])
    _draw_rest(sheet, lower, scene, unit, factor, x, (-down, up))
    title = f"I_zz = {scene.inertia_text}" if medium.telling else "Torque against precession rate × spin"
    write_title(sheet, title, with_hollow(scene, "bars: ± 1 standard uncertainty"), strokes)
    return sheet


def _draw_rest(
    sheet: Sheet, box: Box, scene: Scene, unit: str, factor: float, x: Floats, band: tuple[Floats, Floats]
) -> None:
    """What the line leaves of each run's torque: much larger than it stands where the line rises to the torque."""
    rest, rest_u = factor * scene.rest, factor * scene.rest_u
    kept = ~scene.hollow if not scene.hollow.all() else np.ones_like(scene.hollow)
    # A wide band may leave the strip, that the runs have room in it.
    reach = float((np.abs(rest) + rest_u)[kept].max())
    limit = 1.1 * min(max(reach, float(np.abs(band).max())), 2 * reach) or 1.0
    limits = (float(x[0]), float(x[-1]))
    panel = Panel(sheet, box, limits, (-limit, limit))
    # On a slide the unit stands at the axis above alone.
    label = f"M − line [{unit}]" if box.tall > 70 else "M − line"
    draw_axes(panel, "precession rate × spin, φ̇ψ̇ [rad²/s²]", label, y_ticks=round_ticks(panel.y, 4))
    panel.band(x, *band, _BAND, 0.15)
    panel.level(0.0, INK, 1.2)
    if limits[0] < 0 < limits[1]:
        panel.plumb(0.0, SOFT, 0.8)
    if scene.origin is not None:
        away = factor * ((scene.origin - scene.inertia) * x[[0, -1]] + scene.imbalance)
        panel.line(limits, away, SOFT, 0.9, dashed=True)
    shown = np.clip(rest, -0.9 * limit, 0.9 * limit)
    product = np.clip(scene.product, *limits)
    draw_runs(panel, scene, Marks(product, shown, np.zeros_like(rest), np.where(shown == rest, rest_u, 0.0)))
    name_runs(panel, product, shown, odd_names(scene, rest, shown, f" {unit}", "↓↑"))


def _draw_residuals(scene: Scene, medium: Medium) -> Sheet:
    """Each run's time against what the others predict, in standard uncertainties, in the order of the log."""
    labels = list_labels(scene, medium, medium.room(2))
    sheet = medium.sheet()
    count = len(scene.names)
    deviations = np.nan_to_num(scene.deviations)
    limit = max(3.5, 1.15 * float(np.abs(deviations[~scene.hollow]).max(initial=0.0)))
    panel = Panel(sheet, medium.boxes(labels.right, 2)[0], (0.4, count + 0.6), (-limit, limit))
    draw_axes(panel, "run, in the order of the log", "time − prediction [u]", _run_ticks(panel.box.wide, scene.names))
    panel.band(panel.x, np.full(2, -2.0), np.full(2, 2.0), _BAND, 0.1)
    panel.level(0.0, SOFT, 0.8)
    nothing = np.zeros(count)
    height = np.clip(deviations, -0.96 * limit, 0.96 * limit)
    marks = Marks(np.arange(1.0, count + 1), height, nothing, nothing)
    draw_runs(panel, scene, marks, bars=False)
    told = np.where(height == deviations, deviations, np.round(deviations))
    name_runs(panel, marks.x, marks.y, odd_names(scene, told, height, " u", "↓↑"))
    label_margin(panel, scene, labels, None)
    kept = np.abs(deviations[~scene.left_out])
    inside = int(np.sum(kept <= 2))
    title = f"Residuals: {inside} of {len(kept)} runs within ± 2 u" if medium.telling else "Residuals"
    if scene.dof < 1:
        title = "Residuals: as many unknowns as runs"
    write_title(
        sheet, title, with_hollow(scene, "predicted by the other runs; about 95 % of good runs lie in the band")
    )
    return sheet


def _run_ticks(wide: float, names: Sequence[str]) -> dict[float, str]:
    """Runs by their names where these have room, else every so many."""
    # A character is 5.6 points wide.
    step = max(1, math.ceil(len(names) * (max(len(name) for name in names) + 1.5) * 5.6 / wide))
    return {1.0 + i: names[i] for i in range(0, len(names), step)}


_DRAWERS: dict[str, Callable[[Scene, Medium], Sheet]] = {
    "period": _draw_period,
    "product": _draw_product,
    "torque": _draw_torque,
    "residuals": _draw_residuals,
}


def draw(analysis: Analysis, name: str, medium: Medium = MEDIA["screen"]) -> Sheet:
    """Draw one figure."""
    return _DRAWERS[name](gather(analysis, medium.grey_safe), medium)


def render(
    analysis: Analysis, form: Form = "png", medium: Medium = MEDIA["screen"], names: Sequence[str] = FIGURES
) -> dict[str, bytes]:
    """Draw figures as files, by their names."""
    from matplotlib import rc_context

    # What is worked out comes first: beside other tasks it may wait for them, and the style is that of all.
    scene = gather(analysis, medium.grey_safe)
    with rc_context(STYLE), warnings.catch_warnings():
        # A run's name may be written in a script that the font does not have; it is drawn as boxes then.
        warnings.filterwarnings("ignore", message="(?s).*[Gg]lyph.* missing")
        return {name: _DRAWERS[name](scene, medium).save(form) for name in names}


# --- the Earth that turns below ------------------------------------------------------------------------------

_EARTH_COLOURS = {"axis": "#0072B2", "east": "#D55E00"}
_EARTH_LABELS = {"axis": "started along\nthe Earth's axis,\nto the {pole}", "east": "started level,\nto the east"}
_BEARINGS = {0.0: "N 0", 90.0: "E 90", 180.0: "S 180", 270.0: "W 270", 360.0: "N 360"}


def draw_earth(latitude: float, times: Sequence[float]) -> Sheet:
    """Draw altitude and azimuth of both gyroscopes against the hours of the clock."""
    dots = np.asarray(times, dtype=float)
    fine = np.linspace(0.0, dots[-1], 1441)
    hours = float(dots[-1]) / 3600
    every = next((step for step in (0.25, 1, 3, 6, 12, 24, 72) if hours <= 9 * step), None)
    ticks = None if every is None else number_ticks(np.arange(0, hours * (1 + 1e-9), every).tolist())
    sheet = Sheet((6.6, 4.2), 150)
    upper = Panel(sheet, Box(68, 160, 293, 103), (0.0, hours), (-90.0, 90.0))
    lower = Panel(sheet, Box(68, 38, 293, 103), (0.0, hours), (0.0, 360.0))
    draw_axes(upper, "", "altitude [°]", y_ticks=number_ticks((-90, -45, 0, 45, 90)))
    draw_axes(lower, "time [hours of the clock]", "azimuth [°]", ticks, _BEARINGS)
    upper.level(0.0, SOFT, 0.8)
    # The pole of the sky that is up.
    axis = (0.0, latitude) if latitude >= 0 else (math.pi, -latitude)
    for rank, (name, start) in enumerate((("axis", axis), ("east", (math.pi / 2, 0.0)))):
        colour = _EARTH_COLOURS[name]
        course = balanced_direction(*start, latitude, fine)
        marks = balanced_direction(*start, latitude, dots)
        for panel, line, at in ((upper, course[1], marks[1]), (lower, course[0], marks[0])):
            for part in np.split(np.arange(len(fine)), _jumps(line) if panel is lower else []):
                sheet.items.append(Strokes([panel.at(fine[part] / 3600, np.degrees(line[part]))], colour, 1.4))
            if len(dots) <= 100:
                sheet.items.append(Dots(panel.at(dots / 3600, np.degrees(at)), "o", colour, 3.5))
        height = 160 + 103 * (0.85 - 0.55 * rank)
        sheet.items.append(Strokes([np.array([(370, height), (382, height)])], colour, 2.0))
        lines = _EARTH_LABELS[name].format(pole="north" if latitude >= 0 else "south").split("\n")
        for down, words in enumerate(lines):
            sheet.items.append(Words(388, height + 10.2 * ((len(lines) - 1) / 2 - down) - 3, words, 8.5))
    title = f"Where balanced gyroscopes point, latitude {math.degrees(latitude):.4g}°"
    write_title(sheet, title, "seen from the ground, which turns under them; azimuth from north through east")
    return sheet


def _jumps(bearings: Floats) -> list[int]:
    """Where a line goes through north, from 360° to 0°."""
    return [int(i) + 1 for i in np.flatnonzero(np.abs(np.diff(bearings)) > math.pi)]


def render_earth(latitude: float, times: Sequence[float]) -> bytes:
    """Draw the figure as a PNG."""
    from matplotlib import rc_context

    with rc_context(STYLE):
        return draw_earth(latitude, times).save("png")
