"""Names beside points without lying on one another, and words for logarithmic axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gyrodata.plotting.marks import INK, SOFT

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LETTER, _BOLD = 0.56, 0.66
"""Mean width of a letter over the size of the font."""

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True, slots=True)
class Named:
    """A point and its name."""

    x: float
    y: float
    text: str
    colour: str = INK
    bold: bool = False

    def width(self, size: float) -> float:
        """Of the name in a font of this size [points]."""
        return size * len(self.text) * (_BOLD if self.bold else _LETTER)


@dataclass(frozen=True, slots=True)
class _Box:
    left: float
    bottom: float
    right: float
    top: float

    def overlap(self, other: _Box) -> float:
        """Area in common [points²]."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        high = min(self.top, other.top) - max(self.bottom, other.bottom)
        return wide * high if wide > 0 and high > 0 else 0.0

    def crossed(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        """Whether a line between two places goes through it."""
        steps = [step / 16 for step in range(17)]
        places = [(start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])) for t in steps]
        return any(self.left < x < self.right and self.bottom < y < self.top for x, y in places)


def name_points(
    ax: Axes, named: Sequence[Named], others: Sequence[tuple[float, float]] = (), size: float = 8.0
) -> None:
    """Write names beside points, each where it covers least of other names and points.

    Parameters
    ----------
    ax : Axes
        With its place, scales and limits set.
    named : sequence of Named
        In the data's units; the first have the first choice of place.
    others : sequence of (float, float)
        Points without a name, to be left uncovered.
    size : float
        Of the font [points].
    """
    to_points = 72 / ax.figure.dpi
    corners = ax.transAxes.transform([(0, 0), (1, 1)]) * to_points
    frame = _Box(*corners[0], *corners[1])
    spots = [(point.x, point.y) for point in named] + list(others)
    places = ax.transData.transform(spots) * to_points
    sizes = [8.0 if point.bold else 5.0 for point in named] + [5.0] * len(others)
    taken = [_Box(x - r, y - r, x + r, y + r) for (x, y), r in zip(places, sizes, strict=True)]
    for i, (point, (x, y)) in enumerate(zip(named, places, strict=False)):
        width, height = point.width(size), 1.1 * size
        best: tuple[float, float, float] | None = None
        for distance in (9.0 if point.bold else 6.5, 14.0, 22.0, 32.0, 44.0):
            for angle in (0, 180, 90, 270, 35, 145, 325, 215, 60, 120, 240, 300):
                cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
                left = x + distance * cosine - (width / 2) * (1 - cosine)
                bottom = y + distance * sine - (height / 2) * (1 - sine)
                box = _Box(left, bottom, left + width, bottom + height)
                inside = box.overlap(frame) / (width * height)
                others_taken = [other for k, other in enumerate(taken) if k != i]
                covered = sum(box.overlap(other) for other in others_taken)
                ends = (left + width / 2, bottom + height / 2)
                crossed = sum(other.crossed((x, y), ends) for other in others_taken) if distance > 10 else 0
                cost = 3 * covered + 20 * crossed + 1500 * (1 - inside) + 1.2 * distance
                if best is None or cost < best[0]:
                    best = (cost, left, bottom)
        assert best is not None
        _, left, bottom = best
        taken.append(_Box(left, bottom, left + width, bottom + height))
        _write(ax, point, (left + width / 2 - x, bottom + height / 2 - y), size, to_points)


def _write(ax: Axes, point: Named, offset: tuple[float, float], size: float, to_points: float) -> None:
    """Write one name, with a thin line to its point where it stands apart."""
    apart = math.hypot(max(abs(offset[0]) - point.width(size) / 2, 0.0), max(abs(offset[1]) - size / 2, 0.0)) > 10
    ax.annotate(
        point.text,
        (point.x, point.y),
        offset,
        textcoords="offset points",
        ha="center",
        va="center",
        fontsize=size,
        color=point.colour,
        weight="bold" if point.bold else "normal",
        annotation_clip=False,
        bbox={"facecolor": "white", "alpha": 0.75, "linewidth": 0, "pad": 0.2},
        arrowprops={"arrowstyle": "-", "color": SOFT, "linewidth": 0.5, "shrinkA": 1, "shrinkB": 3} if apart else None,
        zorder=6,
    )


def power_text(value: float) -> str:
    """Write a power of ten: 10⁻⁴."""
    return "10" + str(round(math.log10(value))).translate(_SUPERSCRIPTS)


def time_text(seconds: float) -> str:
    """Write a time of a power of ten or any other with one or two digits: 10 µs."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= 0.9995 * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 99.5 * size else f"{seconds / size:.0f} {unit}"
    return f"{seconds / 1e-9:.2g} ns"


def percent_text(part: float) -> str:
    """Write a part in per cent with two digits."""
    return f"{100 * part:.2g} %" if part < 0.995 else f"{100 * part:.0f} %"


def log_axis(axis: str, ax: Axes, values: Sequence[float], texts: Sequence[str]) -> None:
    """Put written ticks on a logarithmic axis, "x" or "y", and no others."""
    which = ax.xaxis if axis == "x" else ax.yaxis
    which.set_ticks(list(values), list(texts))
    which.set_ticks([], minor=True)
    ax.tick_params(length=3)


def head(ax: Axes, title: str, note: str, size: float = 9.0) -> None:
    """Write a panel's title, and a line of small print below it."""
    ax.text(0.0, 1.0, title, transform=_above(ax, 14.0), fontsize=size, weight="bold", color=INK)
    ax.text(0.0, 1.0, note, transform=_above(ax, 4.0), fontsize=size - 1.5, color=SOFT)


def _above(ax: Axes, points: float) -> object:
    from matplotlib.transforms import ScaledTranslation

    figure = ax.figure
    return ax.transAxes + ScaledTranslation(0, points / 72, figure.dpi_scale_trans)
