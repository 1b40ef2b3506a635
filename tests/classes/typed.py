"""How a value and its uncertainty are typed, and where."""

from __future__ import annotations

import io
import math
from collections.abc import Callable

from classes.drawn import Student

UNITS = {
    "kg m^2": 1.0, "kg·m²": 1.0, "kg*m^2": 1.0, "kg-m^2": 1.0, "kg m2": 1.0, "N m s^2": 1.0,
    "g m^2": 1e-3, "kg cm^2": 1e-4, "g cm^2": 1e-7, "g·cm²": 1e-7,
}  # fmt: skip
"""Units as typed, and what they are in kg*m^2."""


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


def _with(shape: str) -> Callable[[float, float], str]:
    def write(value: float, u: float) -> str:
        one, other = fixed(1e3 * value, 1e3 * u, 2)
        # As many decimals as u has: whoever doubles 0.050 writes 0.100, or 0.10, and not 0.1.
        twice = f"{2 * float(other):.{len(other.partition('.')[2])}f}"
        return shape.format(v=one, u=other, twice=twice, percent=f"{100 * u / value:.1f}")

    return write


def _with_commas(value: float, u: float) -> str:
    return f"{round(value * 1e7, -1):,.0f} ± {round(u * 1e7, -1):.0f} g cm^2"


WAYS: dict[str, Callable[[float, float], str]] = {
    "each its power": _with("{v}×10⁻³ ± {u}×10⁻³ kg·m²"),
    "x 10^": _with("{v} x 10^-3 ± {u} x 10^-3 kg m^2"),
    "bracket": _with("({v} ± {u})×10⁻³ kg·m²"),
    "percent": _with("{v}e-3 ± {percent}% kg m^2"),
    "kg-m^2": _with("{v}e-3 ± {u}e-3 kg-m^2"),
    "whole g cm^2": lambda value, u: in_unit(value, u, "g cm^2", 2),
    "thousands": _with_commas,
    "95 %": _with("{v}e-3 ± {twice}e-3 kg m^2 (95 %)"),
    "1 sigma": _with("{v}e-3 ± {u}e-3 kg m^2 (1 sigma)"),
    "about": _with("about {v}e-3 ± {u}e-3 kg m^2"),
    "u =": _with("{v}e-3 kg m^2, u = {u}e-3"),
    "uncertainty": _with("{v}e-3 kg m^2, uncertainty {u}e-3"),
}
"""Twelve ways that a reader takes for one answer."""


# --- where it stands ----------------------------------------------------------------------------------------

Files = dict[str, str | bytes]
"""What a student hands in, by name."""


def _workbook(student: Student, value: str, where: str) -> bytes:
    import openpyxl

    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"])
    for row in student.cells():
        sheet.append([float(cell) if "/" not in cell else cell for cell in row])
    if where == "below":
        sheet.append([])
        sheet.append(["I_zz", value])
    elif where == "beside":
        sheet["G2"], sheet["H2"] = "I_zz", value
    else:
        book.create_sheet("Results").append(["I_zz", value])
    out = io.BytesIO()
    book.save(out)
    return out.getvalue()


def _in_semicolons(student: Student, value: str) -> str:
    lines = [f"# I_zz = {value.replace('.', ',')}", "mass [g];position [cm];spin [rpm];time [s];turns"]
    return "\n".join([*lines, *(";".join(row).replace(".", ",") for row in student.cells())]) + "\n"


HABITS: dict[str, Callable[[Student, str], Files]] = {
    "# reported_inertia:": lambda s, v: {"lab.csv": s.log(f"# reported_inertia: {v}")},
    "# I_zz =": lambda s, v: {"lab.csv": s.log(f"# I_zz = {v}")},
    "# I_zz:": lambda s, v: {"lab.csv": s.log(f"# I_zz: {v}")},
    "# inertia:": lambda s, v: {"lab.csv": s.log(f"# inertia: {v}")},
    "# Result: I =": lambda s, v: {"lab.csv": s.log(f"# Result: I = {v}")},
    "remark below": lambda s, v: {"lab.csv": s.log(foot=f"# I_zz = {v}\n")},
    "last row": lambda s, v: {"lab.csv": s.log(foot=f"I_zz,{v}{',,,' * (s.number % 2)}\n")},
    "report.txt": lambda s, v: {"lab.csv": s.log(), "report.txt": f"Our report.\n\nThe result is\nI_zz = {v}\n"},
    "results.txt": lambda s, v: {"lab.csv": s.log(), "results.txt": f"inertia: {v}\n"},
    "report.md": lambda s, v: {"lab.csv": s.log(), "report.md": f"# Gyroscope\n\n**I_zz = {v}**\n"},
    "answers.txt": lambda s, v: {"lab.csv": s.log(), "answers.txt": f"I_zz = {v}\n"},
    "cell below": lambda s, v: {"lab.xlsx": _workbook(s, v, "below")},
    "cell beside": lambda s, v: {"lab.xlsx": _workbook(s, v, "beside")},
    "second sheet": lambda s, v: {"lab.xlsx": _workbook(s, v, "second")},
    "semicolons": lambda s, v: {"lab.csv": _in_semicolons(s, v)},
    "g without unit": lambda s, v: {"lab.csv": s.log("# g: 9.81", f"# I_zz = {v}")},
    "text.html": lambda s, v: {"lab.csv": s.log(), "text.html": f"<p>Our result: I_zz = {v}</p>"},
    "Moodle text": lambda s, v: {"lab.csv": s.log(), "onlinetext.html": f"<p>I<sub>zz</sub> = {v}</p>"},
    "Blackboard field": lambda s, v: {"lab.csv": s.log(), "receipt": f"I_zz = {v}"},
    "PDF": lambda s, v: {"lab.csv": s.log(), "report.pdf": b"%PDF-1.4\n% a picture of the answer\n"},
}
"""Where those write it who are told no format; nobody reads a PDF."""


def as_canvas(student: Student, files: Files) -> Files:
    """Name files as Canvas does; what is typed into its text box has no number of its own."""
    short = student.stem.rpartition("_")[0]
    return {
        (f"{short}_{name}" if name == "text.html" else f"{student.stem}_{name}"): data for name, data in files.items()
    }


def as_moodle(student: Student, files: Files) -> Files:
    """Name files as Moodle does, a folder for each kind."""
    stem = f"Student {student.number:04d}_{student.key}_assignsubmission_"
    return {
        f"{stem}{'onlinetext' if name == 'onlinetext.html' else 'file'}/{name}": data for name, data in files.items()
    }


def as_blackboard(student: Student, files: Files) -> Files:
    """Name files as Blackboard does, beside a receipt that holds what was typed into its field."""
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
