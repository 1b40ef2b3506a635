"""What figures are made of: sizes, dots, bars, titles, keys, ticks, names."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from gyrodata.physics import Floats
from gyrodata.plotting.figure_data import Group, Scene, as_number, run_name
from gyrodata.plotting.sheet import FAINT, INK, SOFT, Area, Box, Dots, Panel, Sheet, Strokes, Words, text_width

_LEFT, _BOTTOM = 54.0, 34.0
"""Room left of axes and below them, for ticks and a label [point]."""

_TITLE, _ROW = 26.0, 11.0
"""Room above axes for a title, and for each row of small print [point]."""


class Medium(Struct, frozen=True):
    """What a figure is made for. Fonts keep their points, so a smaller figure has larger letters when shown."""

    size: tuple[float, float]
    """Width and height [inch]."""
    dpi: float
    """Dots of a PNG to the inch."""
    grey_safe: bool
    """Torques in shades that differ on a black-and-white printer too."""
    strip: float
    """What a figure with a strip below is taller by [inch]."""
    telling: bool = True
    """Titles tell results; where they do not, a report's caption does."""

    def sheet(self, strip: bool = False) -> Sheet:
        """Make an empty figure, taller where there is a strip below."""
        return Sheet((self.size[0], self.size[1] + strip * self.strip), self.dpi)

    def room(self, rows: int, strip: bool = False) -> float:
        """Height between what stands above and below axes [point]."""
        return 72 * (self.size[1] + strip * self.strip) - _TITLE - _ROW * rows - _BOTTOM

    def boxes(self, right: float, rows: int, strip: bool = False) -> tuple[Box, Box]:
        """Places of the axes and of a strip below, with labels right of them [point] and rows of small print above."""
        room, wide = self.room(rows, strip), 72 * self.size[0] - _LEFT - right
        below = 0.34 * room if strip else 0.0
        gap = 8.0 if strip else 0.0
        upper = Box(_LEFT, _BOTTOM + below + gap, wide, room - below - gap)
        return upper, Box(_LEFT, _BOTTOM, wide, below)


MEDIA = {
    # On a phone of 390 dots letters of 9 points are 11 dots tall, and as tall as the caption beside it on a wide page.
    "screen": Medium((4.4, 3.4), 200, grey_safe=False, strip=0.9),
    # 1920 x 1080 dots, letters as tall as 20 points on a slide of 7.5 inches.
    "slides": Medium((5.6, 3.15), 1920 / 5.6, grey_safe=False, strip=0.0),
    # As wide as the text on A4 and Letter.
    "print": Medium((6.6, 4.2), 300, grey_safe=True, strip=1.2, telling=False),
}

# --- parts of a figure, from arrays and axes -----------------------------------------------------------------------


MARK = 5.5
"""Diameter of a dot [point]."""

NAME_SIZE = 7.5
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


def _bars(panel: Panel, marks: Marks, colours: Sequence[str]) -> None:
    """Draw the error bars of a figure, those of one colour as one; colours has one entry for each run."""
    x, y, x_u, y_u = marks
    low, high = panel.at(x, y - y_u), panel.at(x, y + y_u)
    left, right = panel.at(x - x_u, y), panel.at(x + x_u, y)
    for colour in dict.fromkeys(colours):
        own = [i for i, one in enumerate(colours) if one == colour]
        lines = [np.array(ends[i]) for ends in (list(zip(low, high, strict=True)), list(zip(left, right, strict=True)))
                 for i in own]  # fmt: skip
        panel.sheet.items.append(Strokes(lines, colour, clip=panel.box))


def bars_note(panel: Panel, marks: Marks) -> str:
    """Say what the error bars are, or that the dots hide them all; u is one standard uncertainty."""
    long = panel.at(marks.x + marks.x_u, marks.y + marks.y_u) - panel.at(marks.x, marks.y)
    if np.all(np.abs(long) < MARK / 2):
        return "bars, ± 1 u, are within the dots"
    return "bars: ± 1 standard uncertainty"


def draw_runs(panel: Panel, scene: Scene, marks: Marks, bars: bool = True) -> None:
    """Draw every run with its group's colour and marker; flagged ones hollow."""
    colours = [""] * len(scene.names)
    places = panel.at(marks.x, marks.y)
    for group in scene.groups:
        members = np.array(group.members)
        for i in group.members:
            colours[i] = group.colour
        for hollow in (False, True):
            chosen = members[scene.hollow[members] == hollow]
            if len(chosen):
                dots = Dots(places[chosen], group.marker, group.colour, MARK, hollow, order=4.0 if hollow else 3.0)
                panel.sheet.items.append(dots)
    if bars:
        _bars(panel, marks, colours)


def write_title(sheet: Sheet, title: str, note: str, keys: Sequence[str] = ()) -> None:
    """Write the title, below it in small print how to read the figure, and what a line and a dashed one are."""
    sheet.write(8, sheet.tall - 18, title, 10.5, weight="bold")
    down = 20.0
    for line in _lines(note, int((sheet.wide - 16) / 4.3)):
        down += _ROW
        sheet.write(8, sheet.tall - down, line, colour=SOFT)
    for rank, words in enumerate(keys):
        down += _ROW
        stroke = np.array([(8, sheet.tall - down + 2.7), (25, sheet.tall - down + 2.7)])
        sheet.items.append(Strokes([stroke], SOFT if rank else INK, 1.1, dashed=rank > 0))
        sheet.write(30, sheet.tall - down, words)


def _lines(note: str, most: int) -> list[str]:
    """Part a note at its semicolons into lines of at most so many characters."""
    lines = [""]
    for clause in note.split("; "):
        whole = f"{lines[-1]}; {clause}" if lines[-1] else clause
        lines = [*lines, clause] if len(whole) > most else [*lines[:-1], whole]
    return lines


def with_hollow(scene: Scene, text: str) -> str:
    """Add to a note what hollow marks mean, where there are any."""
    if not scene.hollow.any():
        return text
    return f"{text}; hollow: {'left out' if (scene.left_out == scene.hollow).all() else 'flagged'}"


Ticks = Mapping[float, str]
"""Places along an axis, and what is written there."""


def round_ticks(limits: tuple[float, float], most: int = 6) -> Ticks:
    """Few round numbers, for readers and for speed."""
    from matplotlib.ticker import MaxNLocator

    return number_ticks(float(tick) for tick in MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]).tick_values(*limits))


def number_ticks(values: Iterable[float]) -> Ticks:
    """Write numbers as they are."""
    return {value: f"{value:.5g}".replace("-", "−").replace("e+0", "e").replace("e−0", "e−") for value in values}


def draw_axes(panel: Panel, x: str, y: str, x_ticks: Ticks | None = None, y_ticks: Ticks | None = None) -> None:
    """Draw ruled ground, both axes with ticks, and their labels; without a label x has no axis of its own."""
    sheet, (left, bottom, wide, tall) = panel.sheet, panel.box
    xs = _placed(panel, 0, round_ticks(panel.x) if x_ticks is None else x_ticks) if x else []
    ys = _placed(panel, 1, round_ticks(panel.y) if y_ticks is None else y_ticks)
    frame = [[(left, bottom), (left, bottom + tall)], *([[(left, bottom), (left + wide, bottom)]] if x else [])]
    frame += [*([(left - 3, at), (left, at)] for at, _ in ys), *([(at, bottom - 3), (at, bottom)] for at, _ in xs)]
    ground = [np.array([(left, at), (left + wide, at)]) for at, _ in ys]
    sheet.items.append(Strokes([np.array(line) for line in frame], SOFT, 0.8, order=2.5))
    if ground:
        sheet.items.append(Strokes(ground, FAINT, 0.6, order=0.5))
    for at, text in xs:
        sheet.items.append(Words(at - text_width(text, 9.0) / 2, bottom - 13.5, text, 9.0))
    # Between the label and the axis; long numbers are written smaller.
    size = 9.0 * min(1.0, (left - 23) / max((text_width(text, 9.0) for _, text in ys), default=1.0))
    for at, text in ys:
        sheet.items.append(Words(left - 6 - text_width(text, size), at - 0.36 * size, text, size))
    if x:
        sheet.write(left + wide / 2, bottom - 28, x, 9.0, align=0.5)
    sheet.write(14, bottom + tall / 2, y, 9.0, align=0.5, upright=True)


def _placed(panel: Panel, axis: int, ticks: Ticks) -> list[tuple[float, str]]:
    """Ticks within the limits, and where they stand on the sheet [point]."""
    low, high = sorted((panel.x, panel.y)[axis])
    slack = 1e-9 * (high - low)
    shown = {value: text for value, text in ticks.items() if low - slack <= value <= high + slack}
    # Only one of the two is asked for; the other stands at its edge.
    ends = [list(shown), [panel.y[0]] * len(shown)] if axis == 0 else [[panel.x[0]] * len(shown), list(shown)]
    return list(zip(panel.at(*ends)[:, axis].tolist(), shown.values(), strict=True))


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


def name_runs(panel: Panel, x: Floats, y: Floats, names: Mapping[int, str]) -> None:
    """Write names beside dots, on a white ground, tied to their dots where they stand apart."""
    left, bottom, wide, tall = panel.box
    dots, items = panel.at(x, y), panel.sheet.items
    for i, (middle, half, apart) in place_names(dots, (left, bottom, left + wide, bottom + tall), names).items():
        if apart:
            away = dots[i] - middle
            start = middle + away * float(np.min(half / np.maximum(np.abs(away), 1e-9)))
            items.append(Strokes([np.array([start, dots[i] - 3 * away / np.hypot(*away)])], SOFT, 0.5, order=6.0))
        text_half = text_width(names[i], NAME_SIZE) / 2
        ground = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (text_half + 0.5, 0.5 * NAME_SIZE) + middle
        items.append(Area(ground, "#ffffff", 0.75, order=6.0))
        down = 0.36 * NAME_SIZE
        items.append(Words(middle[0] - text_half, middle[1] - down, names[i], NAME_SIZE, name=True, order=6.0))


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


class Labels(NamedTuple):
    """What stands right of the axes for each torque."""

    texts: tuple[str, ...]
    size: float
    """[point]"""
    pitch: float
    """From one to the next [point]."""
    right: float
    """Room that they need [point]."""


def list_labels(scene: Scene, medium: Medium, tall: float, extra: Sequence[str] = ()) -> Labels:
    """Choose how torques are labelled beside axes of a height [point]: in lines, with what is extra, if that fits."""
    whole = [group.label for group in scene.groups]
    if len(whole) > _MANY:
        return Labels(tuple(whole), 7.0, 10.1, 17 + 4.1 * max(map(len, whole)))
    slim = max(map(len, whole)) * 5 > 0.17 * 72 * medium.size[0]
    short = [label.replace(" at ", "\nat ") for label in whole] if slim else whole
    told = [[f"{label}\n{more}" for label, more in zip(names, extra, strict=True)] for names in (short, whole) if extra]
    for texts in (*told, short, whole):
        pitch = 4 + 9.8 * (1 + max(text.count("\n") for text in texts))
        if len(whole) * pitch <= tall + 12:
            break
    return Labels(tuple(texts), 8.5, pitch, 18 + 5.2 * max(len(line) for text in texts for line in text.split("\n")))


def label_margin(panel: Panel, scene: Scene, labels: Labels, heights: Sequence[float] | None) -> None:
    """Name each torque right of the axes, beside where its line ends; without heights, from the top down."""
    groups = scene.groups
    if len(groups) > _MANY:
        _list_margin(panel, scene, labels)
        return
    _, bottom, _, tall = panel.box
    gap, edge = labels.pitch / tall, (labels.pitch - 4) / 2 / tall
    if heights is None:
        placed = [1 - edge - gap * rank for rank in range(len(groups))]
    else:
        finite = [height if math.isfinite(height) else panel.y[1] for height in heights]
        inner = 1 - 2 * edge
        shares = (panel.at([panel.x[0]] * len(finite), finite)[:, 1] - bottom) / tall
        placed = [edge + inner * at for at in spread(((shares - edge) / inner).tolist(), gap / inner)]
    for group, text, height in zip(groups, labels.texts, placed, strict=True):
        _label(panel, bottom + tall * height, group, text, labels.size)


def _label(panel: Panel, middle: float, group: Group, text: str, size: float) -> None:
    right, items, lines = panel.box.left + panel.box.wide, panel.sheet.items, text.split("\n")
    items.append(Dots(np.array([(right + 9, middle)]), group.marker, group.colour, MARK))
    for rank, line in enumerate(lines):
        height = middle + 1.15 * size * ((len(lines) - 1) / 2 - rank) - 0.36 * size
        items.append(Words(right + 15.5, height, line, size))


def _list_margin(panel: Panel, scene: Scene, labels: Labels) -> None:
    """Many torques: one compact list by torque, the largest on top, thinned out where it would not fit."""
    left, bottom, wide, tall = panel.box
    ranked = sorted(zip(scene.groups, labels.texts, strict=True), key=lambda one: -one[0].summary.torque)
    # The first line says how many there are.
    step = math.ceil(len(ranked) / int(tall / 9.4 - 1))
    shown = ranked[::step]
    pitch, top = min(labels.pitch, tall / (len(shown) + 1)), bottom + 0.98 * tall
    if step > 1:
        text = f"1 in {step} of {len(ranked)}:"
        panel.sheet.items.append(Words(left + wide + 6, top - 0.36 * labels.size, text, labels.size, SOFT))
    for rank, (group, text) in enumerate(shown):
        _label(panel, top - pitch * (rank + (step > 1)), group, text, labels.size)
