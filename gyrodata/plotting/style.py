"""What all figures have in common: sizes, fonts, and files whose bytes are the same on every run."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from gyrodata.plotting.marks import FAINT, INK, SOFT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Form = Literal["png", "svg", "pdf"]

SIZE = (6.6, 4.2)
"""Width and height [inch]."""


@dataclass(frozen=True)
class Medium:
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
