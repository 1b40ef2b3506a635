"""How much work a benchmark does: a look in less than a minute, or the whole of it in some minutes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from msgspec import Struct

Clock = Callable[[], float]
"""Time in seconds, as `time.process_time`."""

Progress = Callable[[float], None]
"""Told the part that is done, 0 to 1."""


class Effort(Struct, frozen=True):
    """How many points a benchmark has, and how often each is tried."""

    tolerances: Mapping[str, tuple[float, ...]]
    """Relative tolerances that each integrator is tried with [1], the loosest first."""
    tightest: float
    """Of the integration that bounds the error of the exact motion [1]."""
    steps_per_nutation: tuple[float, ...]
    """Of splitting and the other methods with a fixed step, the fewest first."""
    budget: float
    """A curve of an integrator ends where its longest run would take about so much CPU time [s]."""
    repeats: int
    """In how many rounds each time of a motion is taken."""
    precessions: int
    """How long energies and lengths are watched."""
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


_ADAPTIVE = ("RK45", "Tsit5", "DOP853", "LSODA")

QUICK = Effort(
    tolerances=dict.fromkeys(_ADAPTIVE, (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)),
    tightest=1e-12,
    steps_per_nutation=tuple(4.0**power for power in range(1, 8)),
    budget=0.06,
    repeats=5,
    precessions=100,
    labs=200,
    grid=8,
    fine_grid=36,
    swings=3,
    draws=8,
    curve_labs=40,
)
"""Less than a minute."""

FULL = Effort(
    tolerances={
        **dict.fromkeys(_ADAPTIVE, tuple(float(f"1e-{digits}") for digits in range(3, 14))),
        # Radau solves equations at every step, for nothing: no motion here is stiff.
        "Radau": (1e-3, 1e-5, 1e-7),
    },
    tightest=1e-13,
    steps_per_nutation=tuple(2.0**power for power in range(2, 15)),
    budget=0.6,
    repeats=7,
    precessions=1000,
    labs=3000,
    grid=20,
    fine_grid=72,
    swings=9,
    draws=60,
    curve_labs=600,
)
"""Some minutes."""
