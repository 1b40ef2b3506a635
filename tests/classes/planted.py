"""Slips, each as it comes about, and the words by which it is known."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from grading.reports import RIGHT, SLIPS, Formula, reported_line
from msgspec.structs import replace

from classes.drawn import Student

EXCHANGED = "mass [g],position [cm],time [s],spin [rpm],turns"


def _by(formula: Formula, fit: str = "with_constant") -> Callable[[Student], str]:
    return lambda student: student.log(reported_line(*student.answer(formula, fit)))


def _scaled(factor: float, unit: str = " kg m^2") -> Callable[[Student], str]:
    def write(student: Student) -> str:
        value, u = student.answer()
        return student.log(reported_line(value * factor, u * factor, unit=unit))

    return write


def _inverse(student: Student) -> str:
    value, u = student.answer(fit="through_origin")
    return student.log(reported_line(1 / value, u / value**2))


def _exchanged(student: Student) -> str:
    return student.log(reported_line(*student.answer()), titles=EXCHANGED)


OLD = {
    "rpm_as_rad_s": r"^rpm_as_rad_s$",
    "minutes_as_seconds": r"^minutes_as_seconds$",
    "two_pi_missing": r"^two_pi_missing$",
    "two_pi_twice": r"^two_pi_twice$",
    "both_in_rpm": r"^both_in_rpm$",
    "g_as_kg": r"^g_as_kg$",
    "cm_as_m": r"^cm_as_m$",
    "missing_g": r"^missing_g$",
    "diameter_for_radius": r"^diameter_for_radius$",
    "radius_halved": r"^radius_halved$",
    "turns_forgotten": r"^turns_forgotten$",
}

PLANTED: dict[str, tuple[Callable[[Student], str], str]] = {
    **{kind: (_by(SLIPS[kind]), known) for kind, known in OLD.items()},
    "degrees a second": (_by(replace(RIGHT, precession=360.0)), r"degree"),
    "lost exponent": (_scaled(1e3), r"exponent|power of ten|decimal point"),
    "inverse slope": (_inverse, r"inver|reciprocal|1/I"),
    "g in cm/s^2": (_by(replace(RIGHT, g=980.3)), r"cm/s"),
    "cgs, said g m^2": (_scaled(1e7, " g m^2"), r"cgs|g.?cm²"),
    "lost sign": (_scaled(1e6), r"sign of (the|its|an) exponent|exponent"),
    "columns exchanged": (_exchanged, r"exchang|swap"),
}
"""Each with what a student types, and what its name or the words of it must hold."""


def told(student: Mapping[str, Any]) -> list[str]:
    """All that is said of slips."""
    return [part for slip in student["slips"] for part in (slip["kind"], slip["words"], slip["check"])]


def named(kind: str, student: Mapping[str, Any]) -> bool:
    """Tell whether a slip is named right."""
    words = told(student)
    if kind == "columns exchanged":
        words += [*student["look"], *(one["message"] for one in student["diagnostics"])]
    return any(re.search(PLANTED[kind][1], text) for text in words)


def pick(count: int, each: int) -> np.ndarray:
    """Say which kind each student plants; -1 for those that make no slip, who are the reference."""
    kinds = np.repeat(np.arange(len(PLANTED)), each)
    return np.concatenate([kinds, np.full(count, -1)])
