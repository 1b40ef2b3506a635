"""The four figures of a log, and what each of them shows in words: the only matplotlib.

`scene` takes from an `Analysis` the plain arrays that are drawn; `marks` and `figures` draw them; `words` says
what they show. A torque keeps its colour and marker through all figures. Axes stand at fixed places and nothing
is laid out by trial, which makes the figures quick and their bytes the same on every run.
"""

from __future__ import annotations

from gyrodata.plotting.figures import FIGURES, draw, render
from gyrodata.plotting.scene import Look, list_looks
from gyrodata.plotting.style import MEDIA, Form
from gyrodata.plotting.words import alt_text

__all__ = ["FIGURES", "MEDIA", "Form", "Look", "alt_text", "draw", "list_looks", "render"]
