"""What all figures have in common: size, fonts, and files whose bytes are the same on every run."""

from __future__ import annotations

from typing import Any, Literal

from gyrodata.plotting.marks import INK, SOFT

Form = Literal["png", "svg", "pdf"]

SIZE = (6.6, 4.2)
"""Width and height [inch]."""

PACKING: dict[str, Any] = {"png": {"pil_kwargs": {"compress_level": 2}}, "svg": {}, "pdf": {}}
"""How ``savefig`` packs each form: a tenth faster than the usual level, for files a twelfth larger."""

STYLE: Any = {
    # A "$" in a run's name is a dollar; and the parser of formulas costs more than the figure.
    "text.parse_math": False,
    "text.usetex": False,
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

METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": "gyrodata"},
    "pdf": {"CreationDate": None, "Creator": "gyrodata", "Producer": None},
}
"""What ``savefig`` writes about each form: no date and no version, so that the same log gives the same bytes."""
