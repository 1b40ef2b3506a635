"""The four figures of a log, the charts of the benchmark and of the Earth's rotation: the only matplotlib.

`figure_data` takes from an `Analysis` the plain arrays that are drawn, and says in words what they show; `figures`
draws them with `marks` on a `sheet`. A torque keeps its colour and marker through all figures. Axes stand at known
places and nothing is laid out by trial, which makes the figures quick and their bytes the same on every run.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gyrodata.plotting.figure_data import Look, alt_text, choose_looks, list_looks
from gyrodata.plotting.figures import FIGURES, draw, draw_earth, render, render_earth
from gyrodata.plotting.marks import MEDIA
from gyrodata.plotting.sheet import INK, SOFT, Form

if TYPE_CHECKING:
    from gyrodata.plotting.charts import draw_chart, render_benchmark

__all__ = [
    "FIGURES",
    "INK",
    "MEDIA",
    "SOFT",
    "Form",
    "Look",
    "alt_text",
    "choose_looks",
    "draw",
    "draw_chart",
    "draw_earth",
    "list_looks",
    "render",
    "render_benchmark",
    "render_earth",
]


_LATER = {"draw_chart": "charts", "render_benchmark": "charts", "plot_on": "on_axes"}


def __getattr__(name: str) -> Any:
    # The benchmark takes long to import, and the figures of a log do without axes.
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"gyrodata.plotting.{_LATER[name]}"), name)
