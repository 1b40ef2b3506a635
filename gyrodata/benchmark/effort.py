"""How much work a benchmark does: a look in less than a minute, or the whole of it in some minutes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from msgspec import Struct

Clock = Callable[[], float]
"""Time in seconds, as `time.perf_counter`."""

Progress = Callable[[float], None]
"""Told the part that is done, 0 to 1."""


class Effort(Struct, frozen=True):
    """How many points a benchmark has, and how often each is tried."""

    tolerances: Mapping[str, tuple[float, ...]]
    """Relative tolerances that each integrator is tried with [1]."""
    tightest: float
    """Of the integration that bounds the error of the exact motion [1]."""
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
    curve_labs: int = 20
    """Simulated labs at each point of a curve of fits, fewer where they have many runs."""


_SOME, _MANY = (1e-3, 1e-6), (1e-3, 1e-4, 1e-6, 1e-8, 1e-10)

QUICK = Effort(
    tolerances=dict.fromkeys(("RK45", "DOP853", "LSODA"), _SOME),
    tightest=1e-12,
    steps_per_nutation=(4.0, 12.0),
    repeats=2,
    labs=240,
    grid=9,
    fine_grid=36,
    swings=3,
    draws=8,
    curve_labs=50,
)
"""Less than a minute."""

FULL = Effort(
    # Radau solves equations at every step, for nothing: no motion here is stiff.
    tolerances={**dict.fromkeys(("RK45", "DOP853", "LSODA"), _MANY), "Radau": (1e-3, 1e-5)},
    tightest=1e-13,
    steps_per_nutation=(4.0, 8.0, 16.0, 48.0),
    repeats=5,
    labs=3000,
    grid=20,
    fine_grid=72,
    swings=9,
    draws=60,
    curve_labs=600,
)
"""Some minutes."""
