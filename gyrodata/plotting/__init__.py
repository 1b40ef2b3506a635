"""The four figures of a log, the charts of the benchmark and the figure of the Earth's rotation: the only matplotlib.

`figure_data` takes from an `Analysis` the plain arrays that are drawn, and one look for each torque; `figures` draws
them on axes of matplotlib, and says in words what they show.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gyrodata.plotting.figure_data import Look, list_looks
from gyrodata.plotting.figures import FIGURES, SIZES, Form, alt_text, plot_on, render, render_earth

if TYPE_CHECKING:
    from gyrodata.plotting.charts import draw_chart, render_benchmark

__all__ = [
    "FIGURES",
    "SIZES",
    "Form",
    "Look",
    "alt_text",
    "draw_chart",
    "list_looks",
    "plot_on",
    "render",
    "render_benchmark",
    "render_earth",
]


def __getattr__(name: str) -> Any:
    # The benchmark takes long to import.
    if name not in ("draw_chart", "render_benchmark"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from gyrodata.plotting import charts

    return getattr(charts, name)
