"""Gate 4: a class of 60 students, as Canvas hands it out, is graded as before.

Of the sixty 37 work right, each with an answer typed in another way; 14 make one known mistake on the way from their own
readings to I_zz; 5 hand in a neighbour's rows, more or less changed; 4 hand in what cannot be graded. `grades.txt`
contains grades.csv and flags.csv as they are printed. What must be true whatever is stored: every mistake is named, no
copy is overlooked, and nobody who worked right is accused or loses a point for the answer.
"""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import openpyxl
from typer.testing import CliRunner

from gates.labs import ARM, RPM, Bench, G, Table, draw, write
from gates.stored import Found, compare
from gyrodata.cli import app

STATIONS = 6
MISTAKES: dict[str, dict[str, float]] = {
    "rpm_as_rad_s": {"spin": 1 / RPM}, "minutes_as_seconds": {"spin": 60.0}, "two_pi_missing": {"rate": 1 / (2 * np.pi)},
    "two_pi_twice": {"rate": 2 * np.pi}, "both_in_rpm": {"rate": 60 / (2 * np.pi), "spin": 1 / RPM},
    "g_as_kg": {"torque": 1e3}, "cm_as_m": {"torque": 100.0}, "missing_g": {"torque": 1 / G},
    "diameter_for_radius": {"torque": 2.0}, "radius_halved": {"torque": 0.5}, "turns_forgotten": {"turns": 1.0},
    "degrees_per_second": {"rate": 180 / np.pi}, "exponent_lost": {"answer": 1e3}, "power_of_ten": {"answer": 0.1},
}  # fmt: skip
"""By what each mistake multiplies a quantity on the way; ``turns``: all turns are taken for one."""


def answer(table: Table, constant: bool = True, **factors: float) -> tuple[float, float]:
    """Work out I_zz and u by a line of M on φ̇ψ̇ [kg*m^2]."""
    turns = np.ones(len(table.mass)) if "turns" in factors else table.counts
    product = 2 * np.pi * turns / table.time * RPM * table.spin * factors.get("rate", 1.0) * factors.get("spin", 1.0)
    torque = 1e-3 * table.mass * G * ARM * factors.get("torque", 1.0)
    design = np.stack([product, np.ones_like(product)][: 1 + constant], axis=1)
    solution, *_ = np.linalg.lstsq(design, torque, rcond=None)
    left = torque - design @ solution
    u = np.sqrt(np.linalg.inv(design.T @ design)[0, 0] * (left @ left) / (len(torque) - design.shape[1]))
    return float(solution[0]) * factors.get("answer", 1.0), float(u) * factors.get("answer", 1.0)


def stated(value: float, u: float, way: str = "{v}e{p} ± {u}e{p} kg m^2") -> str:
    """Type an answer with two digits of u."""
    power = int(np.floor(np.log10(value)))
    places = max(0, 1 - int(np.floor(np.log10(u / 10.0**power))))
    return way.format(v=f"{value / 10.0**power:.{places}f}", u=f"{u / 10.0**power:.{places}f}", p=power)


WAYS = (
    "# reported_inertia: {v}e{p} ± {u}e{p} kg m^2", "# I_zz = ({v} ± {u})e{p} kg*m^2",
    "# I_zz: {v}×10^{p} ± {u}×10^{p} kg m^2", "# Result: I = {v}e{p} ± {u}e{p} kg·m²",
    "# inertia: {v}e{p} kg m^2, u = {u}e{p}", "# reported_inertia: about {v}e{p} ± {u}e{p} kg m^2 (1 sigma)",
)  # fmt: skip


def workbook(table: Table, said: str) -> bytes:
    """Type a log into a spreadsheet, its answer on a second sheet."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"])
    for row in zip(table.mass, table.spin, table.time, table.turns, strict=True):
        sheet.append([float(row[0]), 100 * ARM, float(row[1]), float(row[2]), row[3]])
        sheet.cell(sheet.max_row, 2).number_format = "0.0"
    book.create_sheet("Results").append(["I_zz", said])
    out = io.BytesIO()
    book.save(out)
    return out.getvalue()


COPIES: dict[str, Callable[[np.random.Generator, Table], Table]] = {
    "exact": lambda random, rows: rows,
    "shuffled": lambda random, rows: Table(
        *(
            list(np.array(c)[[4, 0, 8, 2, 6, 1, 3, 7, 5]]) if isinstance(c, list) else c[[4, 0, 8, 2, 6, 1, 3, 7, 5]]
            for c in rows
        )
    ),
    "times by 0.03 s": lambda random, rows: rows._replace(time=rows.time + random.uniform(-0.03, 0.03, 9)),
    "three times changed": lambda random, rows: rows._replace(time=rows.time + np.where(np.arange(9) % 3, 0.0, 0.3)),
    "shifted": lambda random, rows: rows._replace(time=rows.time + 0.2),
}


def make_class(root: Path) -> tuple[dict[str, str], list[set[str]]]:
    """Write the class; give the mistake of each key that makes one, and the pairs of copies."""
    made: dict[str, str] = {}
    pairs: list[set[str]] = []
    root.mkdir()
    for number in range(60):
        key, stem = f"{1000 + number}", f"student{number:02d}_{1000 + number}_{9000 + number}"
        there = np.random.default_rng([3, number % STATIONS])
        inertia = 4.44e-3 * (1 + there.uniform(-0.04, 0.04))
        table = draw(Bench(thirds=True, imbalance=0.003 * (number % STATIONS)), 100 + number, inertia)
        above = f"# station: {number % STATIONS + 1}\n"
        name, data = "lab.csv", b""
        if 37 <= number < 51:
            kind = list(MISTAKES)[number - 37]
            made[key] = kind
            above += f"# reported_inertia: {stated(*answer(table, False, **MISTAKES[kind]))}\n"
        elif 51 <= number < 56:
            copied = number - 5 * STATIONS
            source = draw(Bench(thirds=True, imbalance=0.003 * (copied % STATIONS)), 100 + copied, inertia)
            table = list(COPIES.values())[number - 51](np.random.default_rng(number), source)
            pairs.append({key, f"{1000 + copied}"})
            above += f"# reported_inertia: {stated(*answer(table, constant=False))}\n"
        elif number < 56:
            above += stated(*answer(table, constant=bool(number % 2)), way=WAYS[number % len(WAYS)]) + "\n"
        if number == 56:
            name, data = "lab.csv", b"\n"
        elif number == 57:
            name, data = "photo.png", b"\x89PNG\r\n\x1a\n"
        elif number == 59:
            data = write(table, above).replace("\n20", "\n2O").encode()
        elif number % 9 == 4 and number < 37:
            said = stated(*answer(table))
            name, data = "lab.xlsx", workbook(table, said)
        elif number % 9 == 7 and number < 37:
            data = write(table, above, delimiter=";").encode("utf-8-sig")
        late = "LATE_" if number == 20 else ""
        path = root / f"student{number:02d}_{late}{stem.partition('_')[2]}_{name}"
        path.write_bytes(data or write(table, above).encode())
    return made, pairs


def gate(accept: bool = False, part: bool = False) -> Found:
    """Grade the class."""
    with tempfile.TemporaryDirectory() as folder:
        made, pairs = make_class(Path(folder) / "class")
        options = ["--out", f"{folder}/grades", "--workers", "0", "--quiet"]
        done = CliRunner().invoke(app, ["grade", f"{folder}/class", *options], prog_name="gyro")
        texts = {name: (Path(folder) / "grades" / name).read_text("utf-8-sig") for name in ("grades.csv", "flags.csv")}
    texts = {"output": f"exit code {done.exit_code}\n{done.output.replace(folder, 'FOLDER')}", **texts}
    lines = compare("grades.txt", texts, accept)
    students = {row["student"]: row for row in csv.DictReader(io.StringIO(texts["grades.csv"]))}
    flags = [set(row["students"].split(", ")) for row in csv.DictReader(io.StringIO(texts["flags.csv"]))]
    named = sum(kind in students[key]["slips"] for key, kind in made.items())
    found = sum(any(pair <= flag for flag in flags) for pair in pairs)
    honest = [str(1000 + n) for n in range(37)]
    copied = set().union(*pairs)
    accused = sum(
        bool(students[key]["slips"]) or (bool(students[key]["flags"]) and key not in copied) for key in honest
    )
    unjust = sum(float(students[key]["inertia"] or 0) < 5.5 for key in honest)
    measured = (
        f"{len(lines)} lines differ; {named} of {len(made)} mistakes named, {found} of {len(pairs)} copies found, "
        f"{accused} of 37 accused, {unjust} lose for their answer"
    )
    right = (named, found, accused, unjust) == (len(made), len(pairs), 0, 0)
    return Found(measured, "none differs, all, all, none, none", right and not lines, lines)
