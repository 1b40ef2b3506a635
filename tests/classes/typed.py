"""How a value and its uncertainty are typed, and where."""

import io
import math
from collections.abc import Callable

import openpyxl

from classes.drawn import TITLES, Student

Files = dict[str, str | bytes]
"""What a student hands in, by name."""

UNITS = {
    "kg m^2": 1.0, "kg·m²": 1.0, "kg*m^2": 1.0, "kg-m^2": 1.0, "kg m2": 1.0, "N m s^2": 1.0,
    "g m^2": 1e-3, "kg cm^2": 1e-4, "g cm^2": 1e-7, "g·cm²": 1e-7,
}  # fmt: skip
"""Units as typed, and what they are in kg*m^2."""

WAYS = {
    "each its power": "{v}×10⁻³ ± {u}×10⁻³ kg·m²",
    "x 10^": "{v} x 10^-3 ± {u} x 10^-3 kg m^2",
    "bracket": "({v} ± {u})×10⁻³ kg·m²",
    "percent": "{v}e-3 ± {percent:.1f}% kg m^2",
    "kg-m^2": "{v}e-3 ± {u}e-3 kg-m^2",
    "whole g cm^2": "{whole} ± {whole_u} g cm^2",
    "thousands": "{tens:,.0f} ± {tens_u:.0f} g cm^2",
    "95 %": "{v}e-3 ± {twice}e-3 kg m^2 (95 %)",
    "1 sigma": "{v}e-3 ± {u}e-3 kg m^2 (1 sigma)",
    "about": "about {v}e-3 ± {u}e-3 kg m^2",
    "u =": "{v}e-3 kg m^2, u = {u}e-3",
    "uncertainty": "{v}e-3 kg m^2, uncertainty {u}e-3",
}
"""Twelve ways that a reader takes for one answer."""


def fixed(value: float, u: float, digits: int) -> tuple[str, str]:
    """Write u with so many digits and the value to the same place, without powers of ten."""
    places = digits - 1 - math.floor(math.log10(u))
    return f"{round(value, places):.{max(places, 0)}f}", f"{round(u, places):.{max(places, 0)}f}"


def in_unit(value: float, u: float, unit: str, digits: int) -> str:
    """Write them in a unit, as the size of the number suggests."""
    if UNITS[unit] == 1.0:
        one, other = fixed(1e3 * value, 1e3 * u, digits)
        return f"{one}e-3 ± {other}e-3 {unit}"
    one, other = fixed(value / UNITS[unit], u / UNITS[unit], digits)
    return f"{one} ± {other} {unit}"


def plain(value: float, u: float) -> str:
    """Write them as the format asks for."""
    return in_unit(value, u, "kg m^2", 2)


def in_way(way: str, value: float, u: float) -> str:
    """Write them in one of the twelve ways."""
    (one, other), (whole, whole_u) = fixed(1e3 * value, 1e3 * u, 2), fixed(1e7 * value, 1e7 * u, 2)
    # As many decimals as u has: whoever doubles 0.050 writes 0.100, or 0.10, and not 0.1.
    twice = f"{2 * float(other):.{len(other.partition('.')[2])}f}"
    return WAYS[way].format(
        v=one, u=other, twice=twice, percent=100 * u / value, whole=whole, whole_u=whole_u,
        tens=round(value * 1e7, -1), tens_u=round(u * 1e7, -1),
    )  # fmt: skip


# --- where the answer is ------------------------------------------------------------------------------------

Habit = Callable[[Student, str], Files]


def _above(shape: str) -> Habit:
    return lambda student, value: {"lab.csv": student.log(shape.format(value))}


def _below(student: Student, value: str) -> Files:
    return {"lab.csv": student.log(foot=f"I_zz,{value}{',,,' * (student.number % 2)}\n")}


def _beside(name: str, shape: str) -> Habit:
    return lambda student, value: {"lab.csv": student.log(), name: shape.format(value)}


def _workbook(where: str) -> Habit:
    def write(student: Student, value: str) -> Files:
        book, out = openpyxl.Workbook(), io.BytesIO()
        sheet = book.active
        rows = [[float(cell) if "/" not in cell else cell for cell in row] for row in student.cells()]
        for row in [TITLES.split(","), *rows, *([[], ["I_zz", value]] if where == "below" else [])]:
            sheet.append(row)
        if where == "beside":
            sheet["G2"], sheet["H2"] = "I_zz", value
        elif where == "second":
            book.create_sheet("Results").append(["I_zz", value])
        book.save(out)
        return {"lab.xlsx": out.getvalue()}

    return write


def _semicolons(student: Student, value: str) -> Files:
    lines = [TITLES.replace(",", ";"), *(";".join(row).replace(".", ",") for row in student.cells())]
    return {"lab.csv": "\n".join([f"# I_zz = {value.replace('.', ',')}", *lines]) + "\n"}


HABITS: dict[str, Habit] = {
    "# reported_inertia:": _above("# reported_inertia: {}"),
    "# I_zz =": _above("# I_zz = {}"),
    "# I_zz:": _above("# I_zz: {}"),
    "# inertia:": _above("# inertia: {}"),
    "# Result: I =": _above("# Result: I = {}"),
    "g without unit": _above("# g: 9.81\n# I_zz = {}"),
    "remark below": lambda student, value: {"lab.csv": student.log(foot=f"# I_zz = {value}\n")},
    "last row": _below,
    "report.txt": _beside("report.txt", "Our report.\n\nThe result is\nI_zz = {}\n"),
    "results.txt": _beside("results.txt", "inertia: {}\n"),
    "report.md": _beside("report.md", "# Gyroscope\n\n**I_zz = {}**\n"),
    "answers.txt": _beside("answers.txt", "I_zz = {}\n"),
    "cell below": _workbook("below"),
    "cell beside": _workbook("beside"),
    "second sheet": _workbook("second"),
    "semicolons": _semicolons,
    "text.html": _beside("text.html", "<p>Our result: I_zz = {}</p>"),
    "Moodle text": _beside("onlinetext.html", "<p>I<sub>zz</sub> = {}</p>"),
    "Blackboard field": _beside("receipt", "I_zz = {}"),
    "PDF": _beside("report.pdf", "%PDF-1.4\n% a picture of the answer\n"),
}
"""Where those write it who are told no format; nobody reads a PDF."""


def named_by(lms: str, student: Student, files: Files) -> Files:
    """Name files as a platform does; on Blackboard beside a receipt that contains what was typed into its field."""
    if lms == "canvas":  # What is typed into its text box has no number of its own.
        short = student.stem.rpartition("_")[0]
        return {f"{short if name == 'text.html' else student.stem}_{name}": data for name, data in files.items()}
    if lms == "moodle":
        stem = f"Student {student.number:04d}_{student.key}_assignsubmission_"
        kinds = {"onlinetext.html": "onlinetext"}
        return {f"{stem}{kinds.get(name, 'file')}/{name}": data for name, data in files.items()}
    stem = f"Gyroscope lab_s{student.key}_attempt_2026-03-09-14-05-59"
    field = files.get("receipt", "There is no student submission text data for this assignment.")
    told = [
        f"Name: Student {student.number:04d} (s{student.key})", "Assignment: Gyroscope lab",
        "Date Submitted: Monday, March 9, 2026 2:05:59 PM CET", "Current Grade: Needs Grading", "",
        "Submission Field:", str(field), "", "Comments:", "There are no student comments for this assignment.",
        "", "Files:", "\tOriginal filename: lab.csv", f"\tFilename: {stem}_lab.csv", "",
    ]  # fmt: skip
    own = {f"{stem}_{name}": data for name, data in files.items() if name != "receipt"}
    return {**own, f"{stem}.txt": "\r\n".join(told)}
