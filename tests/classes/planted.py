"""Mistakes that are planted in a class, each as it comes about, and the words by which it is known."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from grading.reports import RIGHT, SLIPS, Formula, reported_line
from msgspec.structs import replace

from classes.drawn import Student


def _by(formula: Formula) -> Callable[[Student], str]:
    return lambda student: student.log(reported_line(*student.answer(formula)))


def _inverse(student: Student) -> str:
    value, u = student.answer(fit="through_origin")
    return student.log(reported_line(1 / value, u / value**2))


def _in_cgs(student: Student) -> str:
    value, u = student.answer()
    return student.log(reported_line(1e7 * value, 1e7 * u, unit=" g m^2"))


def _exchanged(student: Student) -> str:
    titles = "mass [g],position [cm],time [s],spin [rpm],turns"
    return student.log(reported_line(*student.answer()), titles=titles)


OLD = (
    "rpm_as_rad_s", "minutes_as_seconds", "two_pi_missing", "two_pi_twice", "both_in_rpm", "g_as_kg", "cm_as_m",
    "missing_g", "diameter_for_radius", "radius_halved", "turns_forgotten",
)  # fmt: skip
PLANTED: dict[str, tuple[Callable[[Student], str], str]] = {
    **{kind: (_by(SLIPS[kind]), f"^{kind}$") for kind in OLD},
    "degrees a second": (_by(replace(RIGHT, precession=360.0)), r"degree"),
    "lost exponent": (_by(replace(RIGHT, answer=1e3)), r"exponent|power of ten|decimal point"),
    "inverse slope": (_inverse, r"inver|reciprocal|1/I"),
    "g in cm/s^2": (_by(replace(RIGHT, g=980.3)), r"cm/s"),
    "cgs, said g m^2": (_in_cgs, r"cgs|g.?cm²"),
    "lost sign": (_by(replace(RIGHT, answer=1e6)), r"exponent"),
    "columns exchanged": (_exchanged, r"exchang|swap"),
}
"""Each with what a student types, and what its name or the words about it must contain."""


def told(student: Mapping[str, Any]) -> list[str]:
    """All that is said of mistakes."""
    return [part for slip in student["slips"] for part in (slip["kind"], slip["words"], slip["check"])]


def named(kind: str, student: Mapping[str, Any]) -> bool:
    """Tell whether a mistake is named right."""
    words = told(student)
    if kind == "columns exchanged":
        words += [*student["look"], *(one["message"] for one in student["diagnostics"])]
    return any(re.search(PLANTED[kind][1], text) for text in words)
