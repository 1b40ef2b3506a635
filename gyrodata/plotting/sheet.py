"""What the charts of the benchmark still take from here: style, metadata, and a PNG of few colours."""

from __future__ import annotations

import io
from typing import Any, Literal

Form = Literal["png", "svg", "pdf"]

INK, SOFT = "#222222", "#666666"

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
