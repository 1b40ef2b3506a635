"""What figures are made of: sizes, fonts, dots, bars, titles, keys, ticks, names; and how they become files."""

from __future__ import annotations

import io
import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.physics import Floats
from gyrodata.plotting.figure_data import Group, Scene, as_number, run_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, SOFT, FAINT = "#222222", "#666666", "#dddddd"

Form = Literal["png", "svg", "pdf"]

SIZE = (6.6, 4.2)
"""Width and height [inch]."""


class Medium(Struct, frozen=True):
    """What a figure is made for. Fonts keep their points, so a smaller figure has larger letters when shown."""

    size: tuple[float, float]
    """Width and height [inch]."""
    dpi: float
    """Dots of a PNG to the inch."""
    grey_safe: bool
    """Torques in shades that differ on a black-and-white printer too."""

    @property
    def frame(self) -> tuple[float, float, float, float]:
        """Left, bottom, width and height of the axes as shares of the figure, with room for labels right of them."""
        width, height = self.size
        left, bottom, right, top = 0.825, 0.525, 1.585, 0.545  # inches
        return left / width, bottom / height, 1 - (left + right) / width, 1 - (bottom + top) / height


MEDIA = {
    "screen": Medium(SIZE, 150, grey_safe=False),
    # 1920 x 1080 dots, letters as tall as 20 points on a slide of 7.5 inches.
    "slides": Medium((5.6, 3.15), 1920 / 5.6, grey_safe=False),
    # As wide as the text on A4 and Letter.
    "print": Medium(SIZE, 300, grey_safe=True),
}

STYLE: Any = {
    # A "$" in a run's name is a dollar; and the parser of formulas costs more than the figure.
    "text.parse_math": False,
    "text.usetex": False,
    # Letters as the font has them: a tenth faster than letters fitted to the dots.
    "text.hinting": "no_hinting",
    "svg.hashsalt": "gyrodata",
    "svg.fonttype": "path",
    "pdf.fonttype": 3,
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": SOFT,
    "axes.labelcolor": INK,
    "axes.labelsize": 9.5,
    "axes.axisbelow": True,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
}
"""For matplotlib's ``rc_context``, around drawing and saving."""

RULED: Any = {
    **STYLE,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
}
"""The same with a ruled ground. Said beforehand: to change every tick afterwards takes longer."""

METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": "gyrodata"},
    "pdf": {"CreationDate": None, "Creator": "gyrodata", "Producer": None},
}
"""What ``savefig`` writes about each form: no date and no version, so that the same log gives the same bytes."""


def save(figure: Figure, form: Form) -> bytes:
    """Write a figure as a file, within ``rc_context(STYLE)``."""
    file = io.BytesIO()
    if form != "png":
        figure.savefig(file, format=form, metadata=METADATA[form])
        return file.getvalue()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    image = image.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    # The ground's entry is the mean of all near-white dots; a printer would dot paper that is not quite white.
    ground: Any = image.getpixel((0, 0))
    palette: Any = image.getpalette()
    palette[3 * ground : 3 * ground + 3] = [255, 255, 255]
    image.putpalette(palette)
    image.save(file, "png", compress_level=4, dpi=(figure.dpi, figure.dpi))
    return file.getvalue()


# --- parts of a figure, from arrays and axes -----------------------------------------------------------------------


MARK = 5.5
"""Diameter of a dot [point]."""

_NAME_SIZE = 7.5
"""Of letters beside dots [point]."""

_MANY = 10
"""More torques than this get one compact list of labels."""

_ANGLES = (0, 180, 90, 270, 35, 145, 325, 215, 60, 120, 240, 300)
"""Where a name in a crowd may stand, seen from its dot [degrees]; the first are preferred."""


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


def odd_names(scene: Scene, values: Floats, drawn: Floats, unit: str, arrows: str) -> dict[int, str]:
    """What to write beside which runs: the names of flagged ones, and the value of what is drawn at the edge."""
    names = {}
    for i in range(len(scene.names)):
        # A run without a weight is known by its grey mark, and needs no name.
        told = [run_name(scene.names[i])] if scene.hollow[i] else []
        if values[i] != drawn[i]:
            told.append(f"{arrows[int(values[i] > drawn[i])]} {as_number(values[i])}{unit}")
        if told:
            names[i] = " ".join(told)
    return names


def name_dots(ax: Axes, x: Floats, y: Floats, names: Mapping[int, str], bold: Collection[int] = ()) -> None:
    """Write names beside dots, each where it covers least of other names and dots, near its own; bold ones first."""
    to_points = 72 / ax.figure.dpi
    frame = np.array(ax.bbox.extents) * to_points
    dots = ax.transData.transform(np.column_stack([x, y])) * to_points
    radii = np.array([8.0 if i in bold else 5.0 for i in range(len(dots))])[:, None]
    taken = np.concatenate([dots - radii, dots + radii], axis=1)
    for i in sorted(names, key=lambda i: i not in bold):
        distance, angle = (
            part.ravel()
            for part in np.meshgrid(
                (9.0 if i in bold else 6.5, 14.0, 22.0, 32.0, 44.0), np.radians(_ANGLES), indexing="ij"
            )
        )
        width = 0.66 if i in bold else 0.56
        half = np.array([width, 0]) * _NAME_SIZE * len(names[i]) / 2 + np.array([0, 0.55 * _NAME_SIZE])
        aim = np.column_stack([np.cos(angle), np.sin(angle)])
        middles = dots[i] + (distance[:, None] + half) * aim
        boxes = np.concatenate([middles - half, middles + half], axis=1)
        others = np.delete(taken, i, axis=0)
        inside = _areas(boxes, frame[None])[:, 0] / (4 * half.prod())
        lines = dots[i] + np.linspace(0, 1, 17)[:, None, None] * (middles - dots[i])
        hit = ((lines[:, :, None] > others[:, :2]) & (lines[:, :, None] < others[:, 2:])).all(axis=3).any(axis=0)
        crossed = np.where(distance > 10, hit.sum(axis=1), 0)
        cost = 3 * _areas(boxes, others).sum(axis=1) + 20 * crossed + 1500 * (1 - inside) + 1.2 * distance
        best = int(cost.argmin())
        taken = np.concatenate([taken, boxes[best : best + 1]])
        offset = middles[best] - dots[i]
        apart = float(np.hypot(*np.maximum(np.abs(offset) - (half[0], _NAME_SIZE / 2), 0.0))) > 10
        line = {"arrowstyle": "-", "color": SOFT, "linewidth": 0.5, "shrinkA": 1, "shrinkB": 3}
        ax.annotate(
            names[i],
            (x[i], y[i]),
            tuple(offset),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=_NAME_SIZE,
            color=INK,
            weight="bold" if i in bold else "normal",
            annotation_clip=False,
            bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.2},
            arrowprops=line if apart else None,
            zorder=6,
        )


def _areas(boxes: Floats, others: Floats) -> NDArray[np.float64]:
    """Area that each of m boxes has in common with each of n others, shape (m, n) [point²]."""
    high = np.minimum(boxes[:, None, 2:], others[:, 2:])
    low = np.maximum(boxes[:, None, :2], others[:, :2])
    return np.asarray(np.prod(np.maximum(high - low, 0.0), axis=2))


def spread(targets: Sequence[float], gap: float) -> list[float]:
    """Move heights apart until neighbours are `gap` from one another, as near to their targets as the frame lets."""
    order = sorted(range(len(targets)), key=lambda i: targets[i])
    heights = [min(max(targets[i], 0.0), 1.0) for i in order]
    for _ in range(60):
        moved = False
        for low in range(len(heights) - 1):
            lack = gap - (heights[low + 1] - heights[low])
            if lack > 1e-6:
                heights[low] -= lack / 2
                heights[low + 1] += lack / 2
                moved = True
        heights = [min(max(height, 0.0), 1.0) for height in heights]
        if not moved:
            break
    else:
        # Too tight to settle: evenly, in order.
        heights = [0.5 + gap * (rank - (len(heights) - 1) / 2) for rank in range(len(heights))]
    placed = [0.0] * len(targets)
    for rank, i in enumerate(order):
        placed[i] = heights[rank]
    return placed


def label_margin(ax: Axes, scene: Scene, heights: Sequence[float] | None, extra: Sequence[str] = ()) -> None:
    """Name each torque right of the axes, beside where its line ends; without heights, from the top down."""
    groups = scene.groups
    if len(groups) > _MANY:
        _list_margin(ax, scene)
        return
    tall = measure_axes(ax)[1]
    if len(groups) * 23.5 > tall + 12:
        extra = ()
    gap = (23.5 if extra else 13) / tall
    if heights is None:
        placed = [0.97 - gap * rank for rank in range(len(groups))]
    else:
        at = ax.transAxes.inverted().transform(ax.transData.transform([(1.0, height) for height in heights]))
        placed = spread([float(y) if math.isfinite(y) else 1.0 for y in at[:, 1]], gap)
    for i, group in enumerate(groups):
        _label(ax, placed[i], group, group.label + (f"\n{extra[i]}" if extra else ""), 8.5)


def _label(ax: Axes, height: float, group: Group, text: str, size: float) -> None:
    wide = measure_axes(ax)[0]
    draw_key(
        ax, [1 + 10.5 / wide], [height], text, 7.5 / wide, size, 1.15, marker=group.marker, markersize=MARK,
        color=group.colour, markeredgecolor="white", markeredgewidth=0.5, clip_on=False,
    )  # fmt: skip


def _list_margin(ax: Axes, scene: Scene) -> None:
    """Many torques: one compact list by torque, the largest on top, thinned out where it would not fit."""
    wide, tall = measure_axes(ax)
    ranked = sorted(scene.groups, key=lambda group: -group.summary.torque)
    step = math.ceil(len(ranked) / int(tall / 9.4))
    shown = ranked[::step]
    for rank, group in enumerate(shown):
        _label(ax, 0.98 - rank * min(10.1 / tall, 1 / len(shown)), group, group.label, 7.0)
    if step > 1:
        ax.text(
            1 + 6 / wide, 1 + 6.7 / tall, f"1 in {step} of {len(ranked)} torques", transform=ax.transAxes, fontsize=7,
            color=SOFT,
        )  # fmt: skip
