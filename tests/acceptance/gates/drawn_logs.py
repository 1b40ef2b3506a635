"""Labs of a known truth: T = 2π f I_zz ψ̇/(M + M0) + b with errors that runs share,
typed as a student types them.

Only numpy, and nothing of the package: a mistake of the package cannot be in the truth
too."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np

INERTIA, G, ARM, RPM = 4.44e-3, 9.803, 0.15, np.pi / 30
THIRDS = {20: "1/3", 40: "2/3", 60: "1"}
"""Turns timed with each weight [g] that make the times about equal."""


class Bench(NamedTuple):
    """How a lab is done, what is wrong in it, and what its log states.

    Weights [g] with each spin [rpm], `repeats` times, a whole turn or `THIRDS`. The
    hand errs by `hand` [s] and by a part of the time, normally or with Student's t of
    `tails` degrees of freedom, and is late by `late` ± 0.05 s. M0 is a share of the
    lightest torque, `sighting` the error of the angle [deg], `pitch` the rod above the
    horizontal [deg]. The spin falls with a time constant [s] and is read `delay` [s]
    after half time."""

    masses: tuple[int, ...] = (20, 40, 60)
    spins: tuple[int, ...] = (200, 400, 600)
    repeats: int = 1
    thirds: bool = False
    lines: str = ""
    hand: float = 0.14
    in_proportion: float = 0.0
    tails: int = 0
    late: float = 0.0
    imbalance: float = 0.0
    sighting: float = 0.0
    pitch: float = 0.0
    time_constant: float = np.inf
    delay: float = 0.0


class Table(NamedTuple):
    """What is written down: g, rpm, s, and turns as text; I across the rod [kg*m^2].
    One entry for each run.
    """

    mass: np.ndarray
    spin: np.ndarray
    time: np.ndarray
    turns: np.ndarray
    across: np.ndarray

    @property
    def counts(self) -> np.ndarray:
        return np.array([float(Fraction(text)) for text in self.turns])


def draw(bench: Bench, seed: int, inertia: float = INERTIA) -> Table:
    """Draw one lab. The same seed gives the same lab."""
    random = np.random.default_rng(seed)
    normal = random.standard_normal
    runs = [
        (m, s) for m in bench.masses for s in bench.spins for _ in range(bench.repeats)
    ]
    mass, aimed = np.array(runs, dtype=float).T
    turns, n = (
        np.array([THIRDS[m] if bench.thirds else "1" for m, _ in runs]),
        len(runs),
    )
    true_mass = (
        mass
        * (1 + 0.002 * normal(len(bench.masses)))[np.searchsorted(bench.masses, mass)]
    )
    torque = (
        1e-3
        * G
        * (
            true_mass * (ARM + 5e-4 * normal())
            + bench.imbalance * min(bench.masses) * ARM
        )
    )
    spin = RPM * (aimed + random.uniform(-8, 8, n))
    across, up = 1.3 * inertia + 1e-3 * mass * ARM**2, np.sin(np.radians(bench.pitch))
    # The slow root of (I_zz - I) sin(pitch) rate² + I_zz spin rate = torque, which is
    # eq. (8).
    slowness = np.sqrt(1 + 4 * (inertia - across) * up * torque / (inertia * spin) ** 2)
    rate = 2 * torque / (inertia * spin * (1 + slowness))
    time = (
        2 * np.pi * Table(mass, spin, mass, turns, mass).counts
        + np.radians(bench.sighting) * normal(n)
    ) / rate
    if np.isfinite(bench.time_constant):
        time = bench.time_constant * np.log1p(time / bench.time_constant)
        spin = spin * np.exp(-(time / 2 + bench.delay) / bench.time_constant)
    error = random.standard_t(bench.tails, n) if bench.tails else normal(n)
    time = (
        time
        + bench.late
        + 0.05 * normal()
        + (bench.hand + bench.in_proportion * time) * error
    )
    read = np.round(spin / RPM * (1 + 0.001 * normal()) * (1 + 0.002 * normal(n)))
    return Table(
        np.round(true_mass * (1 + 5e-4 * normal()), 1),
        read,
        np.round(time, 2),
        turns,
        across,
    )


def write(table: Table, lines: str = "", pitch: float = 0.0) -> str:
    """Type a table as a log."""
    tilted = f",{pitch:g}," if pitch else ""
    head = (
        "mass [g],position [cm],spin [rpm],time [s],turns"
        + ",pitch [deg],transverse_inertia [kg*m^2]" * bool(pitch)
    )
    text = "\n".join([f"# g: {G} m/s^2", *lines.splitlines(), head]) + "\n"
    for m, s, t, f, i in zip(*table, strict=True):
        text += (
            f"{m:.1f},{100 * ARM:.1f},{s:.0f},{t:.2f},{f}{tilted}"
            + f"{i:.3e}" * bool(pitch)
            + "\n"
        )
    return text


def typed(bench: Bench, seed: int) -> bytes:
    """Draw a lab and type its log."""
    return write(draw(bench, seed), bench.lines, bench.pitch).encode()
