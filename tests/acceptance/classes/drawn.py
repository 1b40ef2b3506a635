"""Students at their benches: logs of a known truth, and what each works out from the
numbers typed.

The truth is worked out here by a few formulas of its own, M τ = 2π f I_zz ψ̇ with a
residual torque, so that a mistake of the package cannot be in both. The same seed gives
the same class."""

import math

import numpy as np
from grading.students_reports import RIGHT, Formula, Sheet
from msgspec import Struct
from msgspec.structs import replace
from simulated_labs import INERTIA, RPM, G

THIRDS = {20: 1 / 3, 40: 2 / 3, 60: 1.0}
"""Turns timed with each weight [g], which makes the times about equal."""
FRACTIONS = {1 / 3: "1/3", 2 / 3: "2/3", 1.0: "1"}
FITS = ("through_origin", "with_constant", "mean_of_ratios")
TITLES = "mass [g],position [cm],spin [rpm],time [s],turns"
STATIONS = 10


class Bench(Struct, frozen=True):
    """How a class works; standard deviations unless it says otherwise."""

    masses: tuple[int, ...] = (20, 40, 60)  # weights [g]
    spins: tuple[int, ...] = (200, 400, 600)  # spins aimed at [rpm] …
    missed: float = 0.04  # … and by how much they are missed [1]
    thirds: bool = True  # whether `THIRDS` are timed; else whole turns
    hand: float = 0.12  # of one timed interval [s] …
    late: float = 0.04  # … and of the bias that a hand has in all of them [s]
    decimals: int = 2  # of the times
    wobble: float = 0.0  # of the angle turned, by nutation, over one turn [1]
    rpm_step: float = 1.0  # last digit of the tachometer [rpm]
    imbalance: float = 0.005  # residual torque over that of the lightest weight [1]


USUAL = Bench()


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

    def log(self, *head: str, foot: str = "", titles: str = TITLES) -> str:
        """Type the log."""
        return (
            "\n".join(
                [
                    *head,
                    f"# station: {self.station}",
                    titles,
                    *map(",".join, self.cells()),
                ]
            )
            + f"\n{foot}"
        )

    def cells(self) -> list[list[str]]:
        rows = zip(
            *(getattr(self.rows, name) for name in self.rows.__struct_fields__),
            strict=True,
        )
        return [
            [
                f"{m:g}",
                f"{x:.1f}",
                f"{n:g}",
                f"{t:.{self.bench.decimals}f}",
                FRACTIONS[float(f)],
            ]
            for m, x, n, t, f in rows
        ]

    def answer(
        self, formula: Formula = RIGHT, fit: str = "with_constant"
    ) -> tuple[float, float]:
        """I_zz and its uncertainty by one of the fits of a textbook [kg*m^2]."""
        return formula.inertia(self.rows, fit)


def draw(number: int, seed: int, bench: Bench = USUAL) -> Student:
    """Draw one student; a station has its own ball and balance."""
    there = np.random.default_rng([seed, 7, number % STATIONS])
    inertia = INERTIA * (1 + there.uniform(-0.04, 0.04))
    residual = (
        bench.imbalance * 1e-3 * min(bench.masses) * G * 0.15 * there.standard_normal()
    )
    weights = {
        mass: mass * (1 + 0.002 * there.standard_normal()) for mass in bench.masses
    }
    random = np.random.default_rng([seed, 11, number])
    runs = [(mass, spin) for mass in bench.masses for spin in bench.spins]
    (mass, aimed), n = np.array(runs, dtype=float).T, len(runs)
    turns = np.array([THIRDS.get(int(m), 1.0) if bench.thirds else 1.0 for m in mass])
    # The ruler is read to a millimetre, and the tachometer is off by a factor of its
    # own.
    arm = 0.15 + 5e-4 * random.standard_normal()
    spin = aimed * (1 + bench.missed * random.standard_normal(n))
    torque = 1e-3 * np.array([weights[int(m)] for m in mass]) * G * arm + residual
    time = (
        2
        * np.pi
        * (turns + bench.wobble * random.standard_normal(n))
        * inertia
        * spin
        * RPM
        / torque
    )
    time += bench.late * random.standard_normal() + bench.hand * random.standard_normal(
        n
    )
    shown = (
        spin
        * (1 + 0.001 * random.standard_normal())
        * (1 + 0.002 * random.standard_normal(n))
    )
    shown = np.round(shown / bench.rpm_step) * bench.rpm_step
    return Student(
        number,
        bench,
        Sheet(mass, np.full(n, 15.0), shown, np.round(time, bench.decimals), turns),
    )


def with_rows(student: Student, rows: Sheet, number: int) -> Student:
    """Put rows under another student's name, times to the digits of the bench."""
    return replace(
        student,
        number=number,
        rows=replace(rows, time=np.round(rows.time, student.bench.decimals)),
    )


# --- the ways to I_zz that are right ---

ROUTES = ("mean", "line", "periods", "swapped axes", "logarithms", "median", "weighted")


def _mean(values: np.ndarray) -> tuple[float, float]:
    return float(np.mean(values)), float(
        np.std(values, ddof=1) / math.sqrt(len(values))
    )


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope through the origin, and its standard error."""
    slope = float(x @ y / (x @ x))
    return slope, float(
        np.sqrt(np.mean((y - slope * x) ** 2) * len(x) / (len(x) - 1) / (x @ x))
    )


def by_route(
    student: Student, route: str, g: float, rounds: bool
) -> tuple[float, float]:
    """I_zz and its uncertainty by a route, with steps of three digits where one rounds."""
    rows = student.rows
    steps = (
        1e-3 * rows.mass * g * 0.01 * rows.position,
        2 * np.pi * rows.turns / rows.time,
        RPM * rows.spin,
    )
    if rounds:
        steps = tuple(
            np.array([float(f"{value:.3g}") for value in step]) for step in steps
        )
    torque, rate, spin = steps
    ratios, weights = torque / (rate * spin), np.unique(torque)
    back, u_back = _line(torque, rate * spin)
    logarithm, u_logarithm = _mean(np.log(ratios))
    # The slope of τ on ψ̇ at each weight.
    slopes = [
        m / (2 * np.pi) * _line(spin[torque == m], 2 * np.pi / rate[torque == m])[0]
        for m in weights
    ]
    mean, u = _mean(ratios)
    return {
        "mean": (mean, u),
        "line": _line(rate * spin, torque),
        "periods": _mean(np.array(slopes)),
        "swapped axes": (1 / back, u_back / back**2),
        "logarithms": (math.exp(logarithm), u_logarithm * math.exp(logarithm)),
        "median": (float(np.median(ratios)), u),
        "weighted": (float(np.average(ratios, weights=rate**-2)), u),
    }[route]
