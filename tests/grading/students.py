"""Simulated students: honest logs as they are typed, and ways to copy one."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from msgspec import Struct

from gyrodata.grading import Fingerprint, fingerprint
from gyrodata.measurements import measure
from gyrodata.readings import read_log

G = 9.803
INERTIA = 4.44e-3
RPM = np.pi / 30
HEADER = "mass [g],position [cm],spin [rpm],time [s],turns"

Row = tuple[str, str, str, str, str]
"""Mass, position, spin, time, turns, as typed."""


class Course(Struct, frozen=True):
    """How a class works."""

    stations: int = 8
    rpm: tuple[float, ...] = (200.0, 400.0, 600.0)
    missed: float = 6.0  # standard deviation of the spin from the one aimed at [rpm]
    repeats: int = 1  # rows with one setting, each with a spin of its own …
    same_spin: bool = False  # … or with one reading of the spin
    hand: tuple[float, float] = (0.06, 0.2)  # scatter of a time, from the best hand to the worst [s]
    decimals: int = 2  # of the times
    rpm_decimals: int = 0
    turns: tuple[str, ...] = ("1/3", "2/3", "1")  # for each of the weights
    bend: float = 0.0  # share that the spin loses in 20 s, which nobody takes into account


def honest_log(random: np.random.Generator, course: Course, station: int) -> list[Row]:
    """Make one student's rows; a station has its own weights, balance and ball."""
    there = np.random.default_rng([7, station])
    weights = np.array([20.0, 40.0, 60.0]) * (1 + 0.002 * there.standard_normal(3))
    inertia = INERTIA * (1 + 0.003 * there.standard_normal())
    imbalance = 3e-4 * there.standard_normal()
    zero = 5e-4 * there.standard_normal()
    hand, late = random.uniform(*course.hand), 0.05 * random.standard_normal()
    rows: list[Row] = []
    for nominal, weight, turns in zip((20, 40, 60), weights, course.turns, strict=True):
        torque = weight * 1e-3 * G * (0.15 + zero) + imbalance
        for aim in course.rpm:
            spin = aim + course.missed * random.standard_normal()
            for _ in range(course.repeats):
                if not course.same_spin:
                    spin = aim + course.missed * random.standard_normal()
                read = spin * (1 + 0.002 * random.standard_normal())
                top, _, bottom = turns.partition("/")
                exact = 2 * np.pi * float(top) / float(bottom or 1) * inertia * spin * RPM / torque
                exact *= 1 - course.bend * exact / 40
                time = exact + late + hand * random.standard_normal()
                spoken = spin if course.same_spin else read
                rows.append(
                    (f"{nominal}", "15.0", f"{spoken:.{course.rpm_decimals}f}", f"{time:.{course.decimals}f}", turns)
                )
    return rows


def honest_class(random: np.random.Generator, course: Course, students: int = 200) -> dict[str, list[Row]]:
    """Make a class: students go round the stations."""
    return {f"s{i:05d}": honest_log(random, course, i % course.stations) for i in range(students)}


def text(rows: Iterable[Row], header: str = HEADER, constants: str = "# g: 9.803 m/s^2\n") -> str:
    """Write a log."""
    return constants + header + "\n" + "\n".join(",".join(row) for row in rows) + "\n"


def print_of(log: str) -> Fingerprint:
    """Read a log and take its fingerprint."""
    readings = read_log(log.encode(), name="log.csv")
    assert readings.ok, readings.diagnostics
    return fingerprint(readings, measure(readings))


def prints_of(logs: dict[str, list[Row]]) -> dict[str, Fingerprint]:
    """Take the fingerprints of a class."""
    return {student: print_of(text(rows)) for student, rows in logs.items()}


def with_times(rows: list[Row], change: Callable[[float], float], decimals: int = 2) -> list[Row]:
    """Change every time."""
    return [(m, x, spin, f"{change(float(time)):.{decimals}f}", turns) for m, x, spin, time, turns in rows]
