"""A sheet that figures are drawn on: what stands on it, in points, and its files by matplotlib's renderers.

The figures of a log are drawn straight on a renderer. To load matplotlib's `Figure` and `Axes` takes as long as to
draw all four, and its ticks take as long again; a log needs neither projections nor a layout that is found by trial.
"""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from msgspec import Struct

from gyrodata.physics import Floats

if TYPE_CHECKING:
    from matplotlib.font_manager import FontProperties

Form = Literal["png", "svg", "pdf"]
Slant = Literal["normal", "italic"]

INK, SOFT, FAINT = "#222222", "#666666", "#dddddd"

STYLE: Any = {
    # A "$" in a run's name is a dollar; and the parser of formulas costs more than the figure.
    "text.parse_math": False,
    "text.usetex": False,
    # Letters as the font has them: a tenth faster than letters fitted to the dots.
    "text.hinting": "no_hinting",
    "font.family": "DejaVu Sans",
    "svg.hashsalt": "gyrodata",
    "svg.fonttype": "path",
    "pdf.fonttype": 3,
}
"""For matplotlib's ``rc_context``, around drawing and saving."""

METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": "gyrodata"},
    "pdf": {"CreationDate": None, "Creator": "gyrodata", "Producer": None},
}
"""What is written about each form: no date and no version, so that the same log gives the same bytes."""


class Box(NamedTuple):
    """A part of a sheet, from its lower left corner [point]."""

    left: float
    bottom: float
    wide: float
    tall: float


class Pen(NamedTuple):
    """A renderer, the dots of one point, and what it needs beside them."""

    renderer: Any
    scale: float
    height: float
    """Of the sheet [point]."""

    def hold(self, colour: str, width: float, clip: Box | None, alpha: float = 1.0) -> Any:
        """Make a renderer's context with a colour, a width [point], and the box that nothing is drawn beyond."""
        from matplotlib.colors import to_rgba
        from matplotlib.transforms import Bbox

        held = self.renderer.new_gc()
        held.set_foreground(to_rgba(colour, alpha), isRGBA=True)
        held.set_linewidth(width)
        if clip is not None:
            held.set_clip_rectangle(Bbox.from_bounds(*(self.scale * part for part in clip)))
        return held

    def transform(self) -> Any:
        """Points to the renderer's dots."""
        from matplotlib.transforms import Affine2D

        return Affine2D().scale(self.scale)


class Strokes(Struct, frozen=True):
    """Lines of one look, each an array of shape (n, 2) [point]."""

    lines: Sequence[Floats]
    colour: str
    width: float = 1.0
    dashed: bool = False
    clip: Box | None = None
    order: float = 2.0

    def paint(self, pen: Pen) -> None:
        """Draw."""
        from matplotlib.path import Path

        held = pen.hold(self.colour, self.width, self.clip)
        held.set_capstyle("butt")
        if self.dashed:
            held.set_dashes(0, (4.5, 3.6))
        codes = [[Path.MOVETO] + [Path.LINETO] * (len(line) - 1) for line in self.lines]
        path = Path(np.concatenate(self.lines), np.concatenate(codes))
        pen.renderer.draw_path(held, path, pen.transform())
        held.restore()


class Area(Struct, frozen=True):
    """A filled outline."""

    outline: Floats
    colour: str
    alpha: float = 1.0
    clip: Box | None = None
    order: float = 1.0

    def paint(self, pen: Pen) -> None:
        """Draw."""
        from matplotlib.colors import to_rgba
        from matplotlib.path import Path

        held = pen.hold(self.colour, 0.0, self.clip)
        path = Path(np.concatenate([self.outline, self.outline[:1]]), closed=True)
        pen.renderer.draw_path(held, path, pen.transform(), to_rgba(self.colour, self.alpha))
        held.restore()


class Dots(Struct, frozen=True):
    """Markers of one look; they may stand over the edge of the axes."""

    at: Floats
    marker: str
    colour: str
    size: float
    hollow: bool = False
    order: float = 3.0

    def paint(self, pen: Pen) -> None:
        """Draw."""
        from matplotlib.colors import to_rgba
        from matplotlib.markers import MarkerStyle
        from matplotlib.path import Path

        style = MarkerStyle(self.marker)
        held = pen.hold(self.colour if self.hollow else "#ffffff", 1.3 if self.hollow else 0.5, None)
        held.set_joinstyle(style.get_joinstyle())
        held.set_capstyle(style.get_capstyle())
        threshold = style.get_snap_threshold()
        held.set_snap(threshold is not None and self.size * pen.scale >= threshold)
        shape: Any = style.get_transform()
        shape.scale(pen.renderer.points_to_pixels(self.size))
        face = to_rgba("#ffffff" if self.hollow else self.colour)
        pen.renderer.draw_markers(held, style.get_path(), shape, Path(self.at), pen.transform(), face)
        held.restore()


class Words(Struct, frozen=True):
    """A line of text in one style, from a place on its base line to the right or upwards."""

    x: float
    y: float
    text: str
    size: float
    colour: str = INK
    weight: str = "normal"
    style: Slant = "normal"
    upright: bool = False
    name: bool = False
    """A name beside a dot."""
    order: float = 5.0

    @property
    def box(self) -> Box:
        """What it covers."""
        wide, down, up = text_width(self.text, self.size, self.weight, self.style), 0.22 * self.size, 0.75 * self.size
        if self.upright:
            return Box(self.x - up, self.y, up + down, wide)
        return Box(self.x, self.y - down, wide, up + down)

    def paint(self, pen: Pen) -> None:
        """Draw."""
        held = pen.hold(self.colour, 1.0, None)
        x, y = pen.scale * self.x, pen.scale * self.y
        y = pen.scale * pen.height - y if pen.renderer.flipy() else y
        font = _font(self.size, self.weight, self.style)
        pen.renderer.draw_text(held, x, y, self.text, font, 90.0 if self.upright else 0.0)
        held.restore()


@cache
def _font(size: float, weight: str, style: Slant) -> FontProperties:
    from matplotlib.font_manager import FontProperties

    return FontProperties(family="DejaVu Sans", size=size, weight=weight, style=style)


@lru_cache(maxsize=4096)
def text_width(text: str, size: float, weight: str = "normal", style: Slant = "normal") -> float:
    """Width of a text [point], the same in every form of a file."""
    from matplotlib.textpath import text_to_path

    return float(text_to_path.get_text_width_height_descent(text, _font(size, weight, style), False)[0])


_SYMBOL = re.compile(r"(?<!\w)(?:(I)_(zz)|(M)(0)|([Mu]))(?!\w)")
"""What is set in italics, and what below the line: as the report's page has it."""


class Sheet:
    """A figure: what stands on it, in any order."""

    def __init__(self, size: tuple[float, float], dpi: float) -> None:
        self.wide, self.tall = 72 * size[0], 72 * size[1]
        self.dpi = dpi
        self.items: list[Strokes | Area | Dots | Words] = []
        self.panels: list[Panel] = []

    def write(
        self,
        x: float,
        y: float,
        text: str,
        size: float = 8.0,
        colour: str = INK,
        weight: str = "normal",
        align: float = 0.0,
        upright: bool = False,
    ) -> None:
        """Write a line with its symbols; `align` is the part of it that stands before the place.

        A name from a log is no formula, and does not come here.
        """
        parts = [(piece, style, 0.7 * size if low else size, low) for piece, style, low in _pieces(text)]
        widths = [text_width(piece, height, weight, style) if len(parts) > 1 or align else 0.0
                  for piece, style, height, _ in parts]  # fmt: skip
        along = -align * sum(widths)
        for (piece, style, height, low), width in zip(parts, widths, strict=True):
            down = 0.16 * size if low else 0.0
            at = (x + down, y + along) if upright else (x + along, y - down)
            self.items.append(Words(*at, piece, height, colour, weight, style, upright))
            along += width

    def paint(self, renderer: Any, scale: float) -> None:
        """Draw everything with one of matplotlib's renderers, a point being so many of its dots."""
        pen = Pen(renderer, scale, self.tall)
        for item in sorted(self.items, key=lambda item: item.order):
            item.paint(pen)

    def save(self, form: Form) -> bytes:
        """Write it as a file, within ``rc_context(STYLE)``."""
        return self._png() if form == "png" else self._drawing(form)

    def _png(self) -> bytes:
        from matplotlib.backends.backend_agg import RendererAgg

        make: Any = RendererAgg
        scale = self.dpi / 72
        renderer = make(round(self.wide * scale), round(self.tall * scale), self.dpi)
        # A little larger than the sheet, so that its edge is as white as the rest.
        paper = np.array([(-9, -9), (self.wide + 9, -9), (self.wide + 9, self.tall + 9), (-9, self.tall + 9)])
        Area(paper, "#ffffff").paint(Pen(renderer, scale, self.tall))
        self.paint(renderer, scale)
        return write_png(np.asarray(renderer.buffer_rgba()), self.dpi)

    def _drawing(self, form: Form) -> bytes:
        from matplotlib.artist import Artist
        from matplotlib.figure import Figure

        paint = self.paint

        class Whole(Artist):
            def draw(self, renderer: Any) -> None:
                paint(renderer, 1.0)

        figure = Figure(figsize=(self.wide / 72, self.tall / 72), dpi=72)
        figure.add_artist(Whole())
        file = io.BytesIO()
        figure.savefig(file, format=form, metadata=METADATA[form])
        return file.getvalue()


def _pieces(text: str) -> list[tuple[str, Slant, bool]]:
    """Part a text into pieces of one style: the piece, "normal" or "italic", and whether it stands below the line."""
    pieces: list[tuple[str, Slant, bool]] = []
    end = 0
    for found in _SYMBOL.finditer(text):
        letter, below = found[1] or found[3] or found[5], found[2] or found[4] or ""
        pieces += [(text[end : found.start()], "normal", False), (letter, "italic", False), (below, "normal", True)]
        end = found.end()
    pieces.append((text[end:], "normal", False))
    return [piece for piece in pieces if piece[0]]


def write_png(dots: Any, dpi: float) -> bytes:
    """Write dots of shape (height, width, 4) as a PNG of at most 256 colours."""
    from PIL import Image

    image = Image.fromarray(dots).convert("RGB")
    image = image.quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    # The ground's entry is the mean of all near-white dots; a printer would dot paper that is not quite white.
    ground: Any = image.getpixel((0, 0))
    palette: Any = image.getpalette()
    palette[3 * ground : 3 * ground + 3] = [255, 255, 255]
    image.putpalette(palette)
    file = io.BytesIO()
    image.save(file, "png", compress_level=4, dpi=(dpi, dpi))
    return file.getvalue()


class Panel:
    """Axes on a sheet: data at places, both linear or both logarithmic."""

    def __init__(
        self, sheet: Sheet, box: Box, x: tuple[float, float], y: tuple[float, float], logarithmic: bool = False
    ) -> None:
        self.sheet, self.box, self.x, self.y, self.logarithmic = sheet, box, x, y, logarithmic
        sheet.panels.append(self)

    def at(self, x: Floats | Sequence[float], y: Floats | Sequence[float]) -> Floats:
        """Where data stand on the sheet, shape (n, 2) [point]."""
        data = np.column_stack(np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float)))
        ends = np.array([self.x, self.y]).T
        if self.logarithmic:
            # A bar may reach to zero: it ends far below the axes.
            data, ends = np.log10(np.maximum(data, 1e-3 * ends[0])), np.log10(ends)
        corner, size = np.array(self.box[:2]), np.array(self.box[2:])
        return np.asarray(corner + size * (data - ends[0]) / (ends[1] - ends[0]))

    def line(self, x: Sequence[float] | Floats, y: Sequence[float] | Floats, colour: str, width: float = 1.0,
             dashed: bool = False) -> None:  # fmt: skip
        """Draw a line through data, within the axes."""
        self.sheet.items.append(Strokes([self.at(x, y)], colour, width, dashed, self.box))

    def level(self, y: float, colour: str, width: float) -> None:
        """Draw a line across the axes."""
        self.line(self.x, (y, y), colour, width)

    def plumb(self, x: float, colour: str, width: float) -> None:
        """Draw a line from the bottom of the axes to their top."""
        self.line((x, x), self.y, colour, width)

    def band(self, x: Sequence[float] | Floats, low: Floats, high: Floats, colour: str, alpha: float) -> None:
        """Fill between two lines, within the axes."""
        outline = np.concatenate([self.at(x, low), self.at(x, high)[::-1]])
        self.sheet.items.append(Area(outline, colour, alpha, self.box))
