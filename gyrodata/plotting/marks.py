"""What the charts of the benchmark still take from here: round numbers, and places for names beside dots."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrodata.physics import Floats

NAME_SIZE = 7.5
"""Of letters beside dots [point]."""

_ANGLES = (0, 180, 90, 270, 35, 145, 325, 215, 60, 120, 240, 300)
"""Where a name in a crowd may stand, seen from its dot [degrees]; the first are preferred."""


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


class Place(NamedTuple):
    """Where a name stands [point]."""

    middle: Floats
    half: Floats
    """Half its width and height."""
    apart: bool
    """So far from its dot that a line has to tie them."""


def place_names(
    dots: Floats, frame: Sequence[float] | Floats, names: Mapping[int, str], bold: Collection[int] = ()
) -> dict[int, Place]:
    """Find for names beside dots [point] where each covers least of other names and dots, near its own; bold first.

    `frame` is left, bottom, right and top of where names should stand.
    """
    radii = np.array([8.0 if i in bold else 5.0 for i in range(len(dots))])[:, None]
    taken = np.concatenate([dots - radii, dots + radii], axis=1)
    places = {}
    for i in sorted(names, key=lambda i: i not in bold):
        distance, angle = (
            part.ravel()
            for part in np.meshgrid(
                (9.0 if i in bold else 6.5, 14.0, 22.0, 32.0, 44.0), np.radians(_ANGLES), indexing="ij"
            )
        )
        width = 0.66 if i in bold else 0.56
        half = np.array([width, 0]) * NAME_SIZE * len(names[i]) / 2 + np.array([0, 0.55 * NAME_SIZE])
        aim = np.column_stack([np.cos(angle), np.sin(angle)])
        middles = dots[i] + (distance[:, None] + half) * aim
        boxes = np.concatenate([middles - half, middles + half], axis=1)
        others = np.delete(taken, i, axis=0)
        inside = _areas(boxes, np.array([frame]))[:, 0] / (4 * half.prod())
        lines = dots[i] + np.linspace(0, 1, 17)[:, None, None] * (middles - dots[i])
        hit = ((lines[:, :, None] > others[:, :2]) & (lines[:, :, None] < others[:, 2:])).all(axis=3).any(axis=0)
        crossed = np.where(distance > 10, hit.sum(axis=1), 0)
        cost = 3 * _areas(boxes, others).sum(axis=1) + 20 * crossed + 1500 * (1 - inside) + 1.2 * distance
        best = int(cost.argmin())
        taken = np.concatenate([taken, boxes[best : best + 1]])
        offset = middles[best] - dots[i]
        apart = float(np.hypot(*np.maximum(np.abs(offset) - (half[0], NAME_SIZE / 2), 0.0))) > 10
        places[i] = Place(middles[best], half, apart)
    return places


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
