"""How much work a benchmark does: a look in less than a minute, or the whole of it in some minutes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Clock = Callable[[], float]
"""Time in seconds, as `time.perf_counter`."""

Progress = Callable[[float], None]
"""Told the part that is done, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Effort:
    """How many points a benchmark has, and how often each is tried."""

    tolerances: tuple[float, ...]
    """Relative tolerances of the integrators [1]."""
    stiff_tolerances: tuple[float, ...]
    """The same for Radau, which is dear."""
    steps_per_nutation: tuple[float, ...]
    """Of splitting."""
    repeats: int
    """How often a time is taken; the shortest counts."""
    labs: int
    """Simulated labs in each scene of the estimators."""
    grid: int
    """Points along each side of a map of integrators."""
    fine_grid: int
    """Points along each side of a map of closed forms."""
    swings: int
    """Orbits that pass near the vertical."""
    draws: int
    """Simulated labs in each case in which estimators break."""


QUICK = Effort((1e-3, 1e-6), (), (4.0, 12.0), 2, 300, 9, 48, 3, 8)
FULL = Effort((1e-3, 1e-4, 1e-6, 1e-8, 1e-10), (1e-3, 1e-5), (4.0, 8.0, 16.0, 48.0), 5, 3000, 20, 120, 9, 60)
