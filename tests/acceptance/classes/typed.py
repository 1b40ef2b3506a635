"""How a value and its uncertainty are typed, and where."""

import io
import math
from collections.abc import Callable

import openpyxl

from classes.drawn import TITLES, Student

Files = dict[str, str | bytes]
"""What a student hands in, by name."""

UNITS = {
    "kg m^2": 1.0,
    "kg·m²": 1.0,
    "kg*m^2": 1.0,
    "kg-m^2": 1.0,
    "kg m2": 1.0,
    "N m s^2": 1.0,
    "g m^2": 1e-3,
    "kg cm^2": 1e-4,
    "g cm^2": 1e-7,
    "g·cm²": 1e-7,
}
"""Units as typed, and what they are in kg*m^2."""


def fixed(value: float, u: float, digits: int) -> tuple[str, str]:
    """Write u with so many digits and the value to the same place, without powers of
    ten.
    """
    places = digits - 1 - math.floor(math.log10(u))
    return (
        f"{round(value, places):.{max(places, 0)}f}",
        f"{round(u, places):.{max(places, 0)}f}",
    )


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


# --- where the answer is ---

Habit = Callable[[Student, str], Files]


def _above(shape: str) -> Habit:
    return lambda student, value: {"lab.csv": student.log(shape.format(value))}


def _below(student: Student, value: str) -> Files:
    return {
        "lab.csv": student.log(foot=f"I_zz,{value}{',,,' * (student.number % 2)}\n")
    }


def _beside(name: str, shape: str) -> Habit:
    return lambda student, value: {"lab.csv": student.log(), name: shape.format(value)}


def _workbook(where: str) -> Habit:
    def write(student: Student, value: str) -> Files:
        book, out = openpyxl.Workbook(), io.BytesIO()
        sheet = book.active
        rows = [
            [float(cell) if "/" not in cell else cell for cell in row]
            for row in student.cells()
        ]
        for row in [
            TITLES.split(","),
            *rows,
            *([[], ["I_zz", value]] if where == "below" else []),
        ]:
            sheet.append(row)
        if where == "beside":
            sheet["G2"], sheet["H2"] = "I_zz", value
        book.save(out)
        return {"lab.xlsx": out.getvalue()}

    return write


def _semicolons(student: Student, value: str) -> Files:
    lines = [
        TITLES.replace(",", ";"),
        *(";".join(row).replace(".", ",") for row in student.cells()),
    ]
    return {
        "lab.csv": "\n".join([f"# I_zz = {value.replace('.', ',')}", *lines]) + "\n"
    }


HABITS: dict[str, Habit] = {
    "# reported_inertia:": _above("# reported_inertia: {}"),
    "# I_zz =": _above("# I_zz = {}"),
    "# Result: I =": _above("# Result: I = {}"),
    "g without unit": _above("# g: 9.81\n# I_zz = {}"),
    "remark below": lambda student, value: {
        "lab.csv": student.log(foot=f"# I_zz = {value}\n")
    },
    "last row": _below,
    "report.txt": _beside("report.txt", "Our report.\n\nThe result is\nI_zz = {}\n"),
    "report.md": _beside("report.md", "# Gyroscope\n\n**I_zz = {}**\n"),
    "cell below": _workbook("below"),
    "cell beside": _workbook("beside"),
    "semicolons": _semicolons,
    "text.html": _beside("text.html", "<p>Our result: I_zz = {}</p>"),
    "Moodle text": _beside("onlinetext.html", "<p>I<sub>zz</sub> = {}</p>"),
    "Blackboard field": _beside("receipt", "I_zz = {}"),
    "PDF": _beside("report.pdf", "%PDF-1.4\n% a picture of the answer\n"),
}
"""Where those write it who are told no format; nobody reads a PDF."""
