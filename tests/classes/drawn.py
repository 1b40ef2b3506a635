"""Students at their benches: logs of a known truth, and what each works out from the numbers typed.

The truth is worked out here by a few formulas of its own, M τ = 2π f I_zz ψ̇ with a residual torque, so that a mistake
of the package cannot be in both. The same seed gives the same class.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from grading.reports import RIGHT, Formula, Sheet
from labs import INERTIA, RPM, G
from msgspec import Struct
from msgspec.structs import replace

THIRDS = {20: 1 / 3, 40: 2 / 3, 60: 1.0}
"""Turns timed with each weight [g], which makes the times about equal."""

FRACTIONS = {1 / 3: "1/3", 2 / 3: "2/3", 1.0: "1"}


class Bench(Struct, frozen=True):
    """How a class works; standard deviations unless it says otherwise."""

    masses: tuple[int, ...] = (20, 40, 60)
    """Weights [g]."""
    spins: tuple[int, ...] = (200, 400, 600)
    """Spins aimed at [rpm] …"""
    missed: float = 0.04
    """… and by how much they are missed [1]."""
    thirds: bool = True
    """Whether `THIRDS` are timed; else whole turns."""
    hand: float = 0.12
    """Of one timed interval [s] …"""
    late: float = 0.04
    """… and of the bias that a hand has in all of them [s]."""
    decimals: int = 2
    """Of the times."""
    wobble: float = 0.0
    """Of the angle turned, by nutation, over one turn [1]."""
    rpm_step: float = 1.0
    """Last digit of the tachometer [rpm]."""
    imbalance: float = 0.005
    """Residual torque over that of the lightest weight [1]."""
    nominal: bool = False
    """Whether the spin aimed at is written, whatever it was."""


USUAL = Bench()
STATIONS = 10


class Student(Struct, frozen=True, eq=False):
    """One student's log."""

    number: int
    bench: Bench
    rows: Sheet

    @property
    def station(self) -> int:
        return self.number % STATIONS + 1

    @property
    def key(self) -> str:
        """What the class knows the student by."""
        return str(1000 + self.number)

    @property
    def stem(self) -> str:
        """How Canvas begins the names of the student's files."""
        return f"student{self.number:04d}_{self.key}_{9000 + self.number}"

    def log(self, *head: str, foot: str = "", titles: str = "mass [g],position [cm],spin [rpm],time [s],turns") -> str:
        """Type the log."""
        return "\n".join([*head, f"# station: {self.station}", titles, *map(",".join, self.cells())]) + f"\n{foot}"

    def cells(self) -> list[list[str]]:
        rows = self.rows
        columns = (rows.mass, rows.position, rows.spin, rows.time, rows.turns)
        return [
            [f"{m:g}", f"{x:.1f}", f"{n:g}", f"{t:.{self.bench.decimals}f}", FRACTIONS[float(f)]]
            for m, x, n, t, f in zip(*columns, strict=True)
        ]

    def answer(self, formula: Formula = RIGHT, fit: str = "with_constant") -> tuple[float, float]:
        """I_zz and its uncertainty by one of the fits of a textbook [kg*m^2]."""
        return formula.inertia(self.rows, fit)


def draw(number: int, seed: int, bench: Bench = USUAL) -> Student:
    """Draw one student; a station has its own ball and balance."""
    there = np.random.default_rng([seed, 7, number % STATIONS])
    inertia = INERTIA * (1 + there.uniform(-0.04, 0.04))
    residual = bench.imbalance * 1e-3 * min(bench.masses) * G * 0.15 * there.standard_normal()
    weights = {mass: mass * (1 + 0.002 * there.standard_normal()) for mass in bench.masses}
    random = np.random.default_rng([seed, 11, number])
    runs = [(mass, spin) for mass in bench.masses for spin in bench.spins]
    mass, aimed = np.array(runs, dtype=float).T
    n = len(mass)
    turns = np.array([THIRDS.get(int(m), 1.0) if bench.thirds else 1.0 for m in mass])
    # The ruler is read to a millimetre, and the tachometer is off by a factor of its own.
    arm = 0.15 + 5e-4 * random.standard_normal()
    spin = aimed * (1 + bench.missed * random.standard_normal(n))
    torque = 1e-3 * np.array([weights[int(m)] for m in mass]) * G * arm + residual
    angle = 2 * np.pi * (turns + bench.wobble * random.standard_normal(n))
    time = angle * inertia * spin * RPM / torque
    time += bench.late * random.standard_normal() + bench.hand * random.standard_normal(n)
    shown = spin * (1 + 0.001 * random.standard_normal()) * (1 + 0.002 * random.standard_normal(n))
    shown = aimed if bench.nominal else np.round(shown / bench.rpm_step) * bench.rpm_step
    return Student(number, bench, Sheet(mass, np.full(n, 15.0), shown, np.round(time, bench.decimals), turns))


def with_rows(student: Student, rows: Sheet, number: int) -> Student:
    """Put rows under another student's name, times to the digits of the bench."""
    return replace(student, number=number, rows=replace(rows, time=np.round(rows.time, student.bench.decimals)))


# --- the ways to I_zz that are right ------------------------------------------------------------------------

FITS = ("through_origin", "with_constant", "mean_of_ratios")
Route = Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[float, float]]
"""From torque [N*m], precession and spin [rad/s] of each run to I_zz and its uncertainty [kg*m^2]."""


def _mean(values: np.ndarray) -> tuple[float, float]:
    return float(np.mean(values)), float(np.std(values, ddof=1) / math.sqrt(len(values)))


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope through the origin, and its standard error."""
    slope = float(x @ y / (x @ x))
    return slope, float(np.sqrt(np.mean((y - slope * x) ** 2) * len(x) / (len(x) - 1) / (x @ x)))


def _periods(torque: np.ndarray, precession: np.ndarray, spin: np.ndarray) -> tuple[float, float]:
    """The slope of τ on ψ̇ at each weight."""
    slopes = [(t, _line(spin[torque == t], 2 * np.pi / precession[torque == t])[0]) for t in np.unique(torque)]
    return _mean(np.array([t * slope / (2 * np.pi) for t, slope in slopes]))


def _swapped(torque: np.ndarray, precession: np.ndarray, spin: np.ndarray) -> tuple[float, float]:
    slope, u = _line(torque, precession * spin)
    return 1 / slope, u / slope**2


def _logarithms(torque: np.ndarray, precession: np.ndarray, spin: np.ndarray) -> tuple[float, float]:
    mean, u = _mean(np.log(torque / (precession * spin)))
    return math.exp(mean), u * math.exp(mean)


def _median(torque: np.ndarray, precession: np.ndarray, spin: np.ndarray) -> tuple[float, float]:
    ratios = torque / (precession * spin)
    return float(np.median(ratios)), _mean(ratios)[1]


def _weighted(torque: np.ndarray, precession: np.ndarray, spin: np.ndarray) -> tuple[float, float]:
    ratios, weights = torque / (precession * spin), precession**-2
    return float(np.average(ratios, weights=weights)), _mean(ratios)[1]


ROUTES: dict[str, Route] = {
    "mean": lambda torque, precession, spin: _mean(torque / (precession * spin)),
    "line": lambda torque, precession, spin: _line(precession * spin, torque),
    "periods": _periods,
    "swapped axes": _swapped,
    "logarithms": _logarithms,
    "median": _median,
    "weighted": _weighted,
}


def three_digits(values: np.ndarray) -> np.ndarray:
    return np.array([float(f"{value:.3g}") for value in values])


def by_route(student: Student, route: str, g: float, rounds: bool) -> tuple[float, float]:
    """I_zz and its uncertainty by a route, with steps of three digits where one rounds."""
    rows = student.rows
    steps = (1e-3 * rows.mass * g * 0.01 * rows.position, 2 * np.pi * rows.turns / rows.time, RPM * rows.spin)
    return ROUTES[route](*(three_digits(step) if rounds else step for step in steps))
