"""Simulated labs in arrays, of a known truth and with whatever may be wrong in a real one.

Nothing here comes from the package but the reading of the design's log, which says what the analyst knows: the truth is
worked out by its own few formulas, so that a mistake of the package cannot be in both.
"""

from __future__ import annotations

import zlib

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.measurements import Measurements, measure
from gyrodata.readings import read_log

INERTIA, G, ARM, RPM = 4.44e-3, 9.803, 0.15, np.pi / 30
THIRDS = {20: 1 / 3, 40: 2 / 3, 60: 1.0}
"""Turns timed with each weight [g] that make the times about equal."""

Floats = np.ndarray
Run = tuple[int, int]
"""Weight [g] and spin aimed at [rpm]."""


class Scene(Struct, frozen=True):
    """What is done in a lab, what its log says, and what is true in it.

    Weights [g] with each spin [rpm] in rising order, or `order`; `THIRDS` of a turn or whole turns; `lines` are
    what the log says of its errors. A time errs by `hand` [s] and by a part of the time, normally or with Student's
    t of `tails` degrees of freedom, and is late by `late` ± `late_u` [s]. M0 is a share of the lightest torque, or
    drawn from a Cauchy distribution of that scale, or from a normal one of width `imbalance_u` [N*m]; it drifts by
    a share of the lightest torque from the middle of the session to its end. The angle errs by `sighting` [deg].
    The spin loses the part `fall` by dry friction, read at start and end, or falls with a time constant [s] and is
    read `delay` ± `delay_u` [s] after half time.
    """

    masses: tuple[int, ...] = (20, 40, 60)
    spins: tuple[int, ...] = (200, 400, 600)
    repeats: int = 1
    order: tuple[Run, ...] | None = None
    thirds: bool = False
    lines: str = ""
    hand: float = 0.14
    in_proportion: float = 0.0
    tails: int | None = None
    late: float = 0.0
    late_u: float = 0.05
    imbalance: float = 0.0
    imbalance_cauchy: float = 0.0
    imbalance_u: float = 0.0
    drift: float = 0.0
    sighting: float = 0.0
    fall: float = 0.0
    time_constant: float | None = None
    delay: float = 0.0
    delay_u: float = 0.0

    @property
    def lightest(self) -> float:
        """Lightest torque [N*m]."""
        return min(self.masses) * 1e-3 * G * ARM

    @property
    def runs(self) -> tuple[Run, ...]:
        """Weight and spin of each run."""
        return self.order or tuple((m, s) for m in self.masses for s in self.spins for _ in range(self.repeats))

    def design(self, lines: str | None = None) -> Measurements:
        """Read a log of this design without errors, in which an analyst states his errors in `lines`."""
        mass, spin, turns = self._columns()
        start, end = spin, spin * (1 - self.fall)
        time = 2 * np.pi * turns * INERTIA * _mean_under_dry_friction(start, end) / (1e-3 * mass * G * ARM)
        spins = "spin_start [rpm],spin_end [rpm]" if self.fall else "spin [rpm]"
        text = (
            f"# g: {G} m/s^2\n{self.lines if lines is None else lines}mass [g],position [cm],{spins},time [s],turns\n"
        )
        for i in range(len(mass)):
            # No two spins are quite the same, as in a lab, so that each is a reading of its own.
            aimed = start[i] / RPM + 0.1 * i
            read = f"{aimed:.0f},{aimed * (1 - self.fall):.0f}" if self.fall else f"{aimed:.0f}"
            text += f"{mass[i]:.1f},{100 * ARM:.1f},{read},{time[i]:.2f},{turns[i]:.10g}\n"
        return measure(read_log(text.encode(), name="design.csv"))

    def _columns(self) -> tuple[Floats, Floats, Floats]:
        """Weight [g], spin [rad/s] and turns of each run."""
        mass = np.array([m for m, _ in self.runs], dtype=float)
        turns = np.array([THIRDS.get(m, 1.0) if self.thirds else 1.0 for m, _ in self.runs])
        return mass, RPM * np.array([s for _, s in self.runs], dtype=float), turns

    def draw(self, labs: int) -> dict[str, Floats]:
        """Readings of so many labs by quantity, SI, shape (labs, n); a lab that could not be is left out.

        Each scene has labs of its own, whatever its log says, and always the same.
        """
        random = np.random.default_rng(zlib.crc32(repr(replace(self, lines="")).encode()))
        normal = random.standard_normal
        mass, aimed, turns = self._columns()
        n, labs_1 = len(mass), (labs, 1)
        weights = sorted(set(mass.tolist()))
        which = np.array([weights.index(m) for m in mass])
        true_mass = mass * (1 + 0.002 * normal((labs, len(weights))))[:, which]
        arm = ARM + 0.001 * (random.random(labs_1) - 0.5) + 5e-4 * normal(labs_1)
        scale, tachometer = 1 + 5e-4 * normal(labs_1), 1 + 0.001 * normal(labs_1)
        imbalance = self.imbalance + self.imbalance_cauchy * np.tan(np.pi * (random.random(labs_1) - 0.5))
        session = np.linspace(-1, 1, n) if n > 1 else np.zeros(n)
        residual = (imbalance + self.drift * session) * self.lightest + self.imbalance_u * normal(labs_1)
        torque = 1e-3 * true_mass * G * arm + residual
        spin = aimed + RPM * random.uniform(-8, 8, (labs, n))
        angle = 2 * np.pi * turns + np.radians(self.sighting) * normal((labs, n))
        error = normal((labs, n)) if self.tails is None else random.standard_t(self.tails, (labs, n))
        delay = self.delay + self.delay_u * normal(labs_1)

        def read(true: Floats) -> Floats:
            return RPM * np.round(true / RPM * tachometer * (1 + 0.002 * normal((labs, n))))

        if self.time_constant is not None:
            # φ = ∫ M/(I_zz ψ̇) dt with ψ̇ = ψ̇₀ e^(−t/τ).
            time = self.time_constant * np.log1p(angle * INERTIA * spin / (torque * self.time_constant))
            mean = read(spin * np.exp(-(time / 2 + delay) / self.time_constant))
        elif self.fall:
            end = spin * (1 - self.fall)
            time = angle * INERTIA * _mean_under_dry_friction(spin, end) / torque
            start, end = read(spin), read(end)
            # What the analyst takes it for: the harmonic mean in time of a viscous fall.
            mean = start * end * np.log(start / end) / (start - end)
        else:
            time = angle * INERTIA * spin / torque
            mean = read(spin)
        time = time + self.late + self.late_u * normal(labs_1) + (self.hand + self.in_proportion * time) * error
        readings = {
            "mass": 1e-3 * np.round(true_mass * scale, 1),
            "position": np.full((labs, n), ARM),
            "spin": mean,
            "time": np.round(time, 2),
            "turns": np.broadcast_to(turns, (labs, n)),
        }
        possible = (time > 0).all(axis=1) & (torque > 0).all(axis=1)
        return {name: values[possible] for name, values in readings.items()}


def _mean_under_dry_friction(start: Floats, end: Floats) -> Floats:
    """Harmonic mean in time of a spin that falls evenly, the logarithmic mean of its ends."""
    return start if np.array_equal(start, end) else (start - end) / np.log(start / end)


def drift_width(degrees: float, seconds: float, rpm: float) -> float:
    """Torque that turns the unloaded rod by an angle in a time [N*m]: what a balance test of so much says."""
    return float(INERTIA * rpm * RPM * np.radians(degrees) / seconds)
