"""Labs of a known truth: T = 2π f I_zz ψ̇/(M + M0) + b with errors that runs share, typed as a student types them.

Only numpy: a mistake of the package cannot be in the truth too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

INERTIA, G, ARM, RPM = 4.44e-3, 9.803, 0.15, np.pi / 30
ACROSS = 1.3 * INERTIA
"""Moment of inertia across the rod without the weight [kg*m^2]."""
THIRDS = {20: "1/3", 40: "2/3", 60: "1"}
"""Turns timed with each weight [g] that make the times about equal."""


class Bench(NamedTuple):
    """How a lab is done, what is wrong in it, and what its log states."""

    masses: tuple[int, ...] = (20, 40, 60)
    spins: tuple[int, ...] = (200, 400, 600)
    repeats: int = 1
    thirds: bool = False
    lines: str = ""
    """What the log states: lines such as ``# u_time: 0.14 s``."""
    hand: float = 0.14
    """Standard uncertainty of one timed interval [s] …"""
    in_proportion: float = 0.0
    """… and the part of it that grows with the time [1]."""
    tails: int = 0
    """Degrees of freedom of the Student's t of the hand; 0: normal."""
    late: float = 0.0
    """Mean timing bias of a hand [s] …"""
    late_u: float = 0.05
    """… and its spread from lab to lab [s]."""
    imbalance: float = 0.0
    """Residual torque over the lightest torque [1]."""
    sighting: float = 0.0
    """Standard uncertainty of the angle turned [deg]."""
    pitch: float = 0.0
    """Rod above the horizontal [deg]."""
    time_constant: float = np.inf
    """Of the fall of the spin [s], which is read once …"""
    delay: float = 0.0
    """… so long after half time [s]."""


class Table(NamedTuple):
    """What is written down: g, cm, rpm, s, turns as text; one entry for each run."""

    mass: np.ndarray
    spin: np.ndarray
    time: np.ndarray
    turns: list[str]
    across: np.ndarray

    @property
    def counts(self) -> np.ndarray:
        """Turns as numbers."""
        return np.array([float(top) / float(low or 1) for top, _, low in (text.partition("/") for text in self.turns)])


def draw(bench: Bench, seed: int, inertia: float = INERTIA) -> Table:
    """Draw one lab. The same seed gives the same lab."""
    random = np.random.default_rng(seed)
    normal = random.standard_normal
    runs = [(m, s) for m in bench.masses for s in bench.spins for _ in range(bench.repeats)]
    mass, aimed = np.array(runs, dtype=float).T
    turns = [THIRDS[m] if bench.thirds else "1" for m, _ in runs]
    n, f = len(mass), np.array([{"1/3": 1 / 3, "2/3": 2 / 3, "1": 1.0}[text] for text in turns])
    true_mass = mass * (1 + 0.002 * normal(len(bench.masses)))[np.searchsorted(bench.masses, mass)]
    arm = ARM + 5e-4 * normal()
    residual = bench.imbalance * 1e-3 * min(bench.masses) * G * ARM
    torque = 1e-3 * true_mass * G * arm + residual
    spin = RPM * (aimed + random.uniform(-8, 8, n))
    angle = 2 * np.pi * f + np.radians(bench.sighting) * normal(n)
    across, up = ACROSS + 1e-3 * mass * ARM**2, np.sin(np.radians(bench.pitch))
    # The slow root of (I_zz - I) sin(pitch) rate² + I_zz spin rate = torque, which is eq. (8).
    rate = (
        2 * torque / (inertia * spin * (1 + np.sqrt(1 + 4 * (inertia - across) * up * torque / (inertia * spin) ** 2)))
    )
    if np.isfinite(bench.time_constant):
        time = bench.time_constant * np.log1p(angle / rate / bench.time_constant)
        spin = spin * np.exp(-(time / 2 + bench.delay) / bench.time_constant)
    else:
        time = angle / rate
    error = random.standard_t(bench.tails, n) if bench.tails else normal(n)
    time = time + bench.late + bench.late_u * normal() + (bench.hand + bench.in_proportion * time) * error
    read = np.round(spin / RPM * (1 + 0.001 * normal()) * (1 + 0.002 * normal(n)))
    weighed = np.round(true_mass * (1 + 5e-4 * normal()), 1)
    return Table(weighed, read, np.round(time, 2), turns, across)


def write(table: Table, lines: str = "", pitch: float = 0.0, delimiter: str = ",") -> str:
    """Type a table as a log."""
    head = ["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"]
    rows = [
        [f"{m:.1f}", f"{100 * ARM:.1f}", f"{s:.0f}", f"{t:.2f}", f]
        for m, s, t, f in zip(table.mass, table.spin, table.time, table.turns, strict=True)
    ]
    if pitch:
        head += ["pitch [deg]", "transverse_inertia [kg*m^2]"]
        rows = [[*row, f"{pitch:g}", f"{across:.3e}"] for row, across in zip(rows, table.across, strict=True)]
    text = "".join(delimiter.join(row) + "\n" for row in [head, *rows])
    return f"# g: {G} m/s^2\n{lines}" + (text if delimiter == "," else text.replace(".", ","))


def typed(bench: Bench, seed: int) -> bytes:
    """Draw a lab and type its log."""
    return write(draw(bench, seed), bench.lines, bench.pitch).encode()
