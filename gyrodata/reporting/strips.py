"""Small pictures in a table's cell: a dot with its uncertainty on one axis for all rows, drawn by the page's style."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from markupsafe import Markup


class Point(NamedTuple):
    """One row's value."""

    value: float
    u: float | None
    """Standard uncertainty, same unit."""


def draw_strips(points: Sequence[Point | None], reference: tuple[float, float]) -> list[Markup]:
    """Draw one strip for each row.

    Parameters
    ----------
    points : sequence of Point or None
        None for a row without a value.
    reference : tuple of float
        Ends of a band behind all rows; equal ends are a line.

    Returns
    -------
    list of Markup
        Hidden from screen readers: the table's cells say the same in numbers.
    """
    drawn = [point for point in points if point is not None]
    low = min([reference[0], *(point.value - (point.u or 0.0) for point in drawn)])
    high = max([reference[1], *(point.value + (point.u or 0.0) for point in drawn)])
    space = 0.05 * (high - low) or 1.0
    low, high = low - space, high + space

    def along(value: float) -> str:
        return f"{100 * (value - low) / (high - low):.1f}%"

    def span(kind: str, start: float, end: float) -> Markup:
        width = f"{100 * (end - start) / (high - low):.1f}%"
        return Markup('<i class="{}" style="left:{};width:{}"></i>').format(kind, along(start), width)

    def mark(kind: str, value: float) -> Markup:
        return Markup('<i class="{}" style="left:{}"></i>').format(kind, along(value))

    strips = []
    for point in points:
        parts = [span("ref", *reference) if reference[1] > reference[0] else mark("line", reference[0])]
        if point is not None:
            u = point.u or 0.0
            parts.append(span("bar", point.value - u, point.value + u))
            parts.append(mark("dot", point.value))
        strips.append(Markup('<span aria-hidden="true">{}</span>').format(Markup("").join(parts)))
    return strips
