"""Gate 4: a class of 60 students, as Canvas hands it out, is graded as before.

Of the sixty 37 work right, each with an answer typed in another way; 14 make one known
mistake on the way from their readings to I_zz; 5 hand in a neighbour's rows, more or
less changed; 4 hand in what cannot be graded. `grades.txt` contains what is printed,
grades.csv and flags.csv, and short digests of all other files. The class is graded a
second time with a rubric of all criteria, decisions of a person, late students, and the
sheets of two platforms. Whatever is stored, every mistake must be named and no copy
overlooked, and nobody who worked right may be accused or lose points for the answer.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
import tempfile
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from gates.drawn_logs import ARM, RPM, Bench, G, Table, draw, write
from gates.outputs import kept
from gates.stored import Found, compare
from gyrodata.cli import app

STATIONS = 6
MISTAKES: dict[str, dict[str, float]] = {
    "rpm_as_rad_s": {"spin": 1 / RPM},
    "minutes_as_seconds": {"spin": 60.0},
    "two_pi_missing": {"rate": 0.5 / np.pi},
    "two_pi_twice": {"rate": 2 * np.pi},
    "both_in_rpm": {"rate": 30 / np.pi, "spin": 1 / RPM},
    "g_as_kg": {"torque": 1e3},
    "cm_as_m": {"torque": 100.0},
    "missing_g": {"torque": 1 / G},
    "diameter_for_radius": {"torque": 2.0},
    "radius_halved": {"torque": 0.5},
    "turns_forgotten": {"turns": 1.0},
    "degrees_per_second": {"rate": 180 / np.pi},
    "exponent_lost": {"answer": 1e3},
    "power_of_ten": {"answer": 0.1},
}
"""By what each mistake multiplies a quantity on the way; ``turns``: all turns are taken
for one."""
WAYS = (
    "# reported_inertia: {v}e{p} ± {u}e{p} kg m^2",
    "# I_zz = ({v} ± {u})e{p} kg*m^2",
    "# I_zz: {v}×10^{p} ± {u}×10^{p} kg m^2",
    "# Result: I = {v}e{p} ± {u}e{p} kg·m²",
    "# inertia: {v}e{p} kg m^2, u = {u}e{p}",
    "# reported_inertia: about {v}e{p} ± {u}e{p} kg m^2 (1 sigma)",
)
COPIES = (
    lambda rows: rows,
    lambda rows: Table(*(column[[4, 0, 8, 2, 6, 1, 3, 7, 5]] for column in rows)),
    lambda rows: rows._replace(
        time=rows.time + np.random.default_rng(1).uniform(-0.03, 0.03, 9)
    ),
    lambda rows: rows._replace(time=rows.time + np.where(np.arange(9) % 3, 0.0, 0.3)),
    lambda rows: rows._replace(time=rows.time + 0.2),
)


def answer(table: Table, constant: bool, way: str = WAYS[0], **factors: float) -> str:
    """Work out I_zz and u by a line of M on φ̇ψ̇, and type them with two digits of u."""
    turns = 1.0 if "turns" in factors else table.counts
    product = (
        2
        * np.pi
        * turns
        / table.time
        * RPM
        * table.spin
        * factors.get("rate", 1.0)
        * factors.get("spin", 1.0)
    )
    torque = 1e-3 * table.mass * G * ARM * factors.get("torque", 1.0)
    design = np.stack([product, np.ones_like(product)][: 1 + constant], axis=1)
    solution, *_ = np.linalg.lstsq(design, torque, rcond=None)
    left = torque - design @ solution
    u = np.sqrt(
        np.linalg.inv(design.T @ design)[0, 0]
        * (left @ left)
        / (len(torque) - design.shape[1])
    )
    value, u = solution[0] * factors.get("answer", 1.0), u * factors.get("answer", 1.0)
    power = int(np.floor(np.log10(value)))
    places = max(0, 1 - int(np.floor(np.log10(u / 10.0**power))))
    return (
        way.format(
            v=f"{value / 10.0**power:.{places}f}",
            u=f"{u / 10.0**power:.{places}f}",
            p=power,
        )
        + "\n"
    )


def log_of(number: int) -> bytes:
    """Write what a student hands in."""
    station = number % STATIONS
    inertia = 4.44e-3 * (1 + np.random.default_rng([3, station]).uniform(-0.04, 0.04))
    copied = 51 <= number < 56
    table = draw(
        Bench(thirds=True, imbalance=0.003 * station),
        100 + number - 5 * STATIONS * copied,
        inertia,
    )
    if copied:
        table = COPIES[number - 51](table)
    if 37 <= number < 51:
        said = answer(table, False, **list(MISTAKES.values())[number - 37])
    else:
        said = (
            answer(table, bool(number % 2), WAYS[number % len(WAYS)])
            if number < 56
            else ""
        )
    text = write(table, f"# station: {station + 1}\n{said}")
    if number == 5:
        text = text.replace("spin [rpm],time [s]", "time [s],spin [rpm]")
    if number == 11:
        # A run without a weight: the residual torque alone turns the rod by 10 degrees.
        torque = 1e-3 * 20 * G * ARM * 0.003 * station
        text += f"0,{100 * ARM:.1f},200,{np.pi / 18 * inertia * 200 * RPM / torque:.2f},1/36\n"
    if number % 9 == 7 and number < 37:
        return text.replace(",", ";").replace(".", ",").encode("utf-8-sig")
    return {
        56: b"\n",
        57: b"\x89PNG\r\n\x1a\n",
        59: text.replace("\n20", "\n2O").encode(),
    }.get(number, text.encode())


def digest(text: str) -> str:
    """Give six digits that differ for nearly every other text."""
    return hashlib.sha256(text.encode()).hexdigest()[:6]


def digests(folder: Path) -> str:
    """Write a line for each file but those that contain all digits of a fit; for a
    page, one for each of its parts.
    """
    lines, students = [], []
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if name.startswith("feedback/") and path.suffix == ".html":
            whole = path.read_text("utf-8") + path.with_suffix(".md").read_text("utf-8")
            students.append(f"{name.partition('_')[0][-2:]} {digest(whole)}")
        elif path.suffix in (".html", ".csv") and not name.startswith("published"):
            parts = re.split("(?=<h[123])", path.read_text("utf-8-sig"))
            lines.append(f"{name} {' '.join(map(digest, parts))}\n")
    return "".join(
        [
            *lines,
            *(
                f"{', '.join(students[at : at + 8])}\n"
                for at in range(0, len(students), 8)
            ),
        ]
    )


def grade_again(home: Path, options: str) -> dict[str, str]:
    """Run the command, and give what it prints."""
    command = (
        f"grade {home}/class --out {home}/grades --workers 0 {options or '--quiet'}"
    )
    done = CliRunner().invoke(app, command.split(), prog_name="gyro")
    printed = f"exit code {done.exit_code}\n{done.output.replace(str(home), 'FOLDER')}"
    return {"printed": printed, "stdout": done.stdout}


def harder_rubric() -> str:
    """Write the full rubric with every criterion, and with deductions for who is late."""
    text = CliRunner().invoke(app, ["grade", "--print-rubric", "full"]).stdout
    text = text.replace(
        '"weights", "runs", "spins"]',
        '"weights", "runs", "spins", "unloaded", "times", "odd_runs"]',
    )
    text = text.replace("points = 20 ", "points = 25 ").replace(
        'full = "p >= 0.001"', 'full = "p >= 0.5"'
    )
    criteria = """
[[criterion]]
id = "plot"
check = "files"
points = 2
full = "files >= 1"
zero = "files <= 0"
[[criterion]]
id = "talk"
check = "manual"
points = 3
[late]
grace = "15 min"
marked = "10 %"
[[late.exception]]
student = "1030"
waive = true
"""
    return text.partition("# Being late.")[0] + criteria


CANVAS = (
    "Student,ID,SIS User ID,SIS Login ID,Section,Gyroscope lab (123456)\n    Points "
    "Possible,,,,,25.00\n"
)
CANVAS_ROW = '"{n:02d}, Student",10{n:02d},s{n:03d},student{n:02d},"Lab, Monday",\n'
MOODLE = (
    "Identifier,Full name,ID number,Email address,Status,Grade,Maximum Grade,Grade can "
    "be changed,Feedback comments\n"
)
MOODLE_ROW = (
    "Participant 10{n:02d},Student {n:02d},10{n:02d},s@x.edu,Submitted,,25.00,Yes,\n"
)
ROSTER = "student,name,section,station,partner\n" + "".join(
    f"10{n:02d},Student {n:02d},{'AB'[n % 2]},{n % STATIONS + 1},"
    f"{'10' + str(n ^ 1) if 10 <= n < 20 else ''}\n"
    for n in range(62)
)
DESK = """student,what,value,by,why
1000,talk,2.5,Ann,heard
1001,total,11,Ann,agreed
1056,reported,4.44e-3 ± 0.05e-3 kg m^2,Ann,on paper
1021 + 1051,flag,partners,Ann,
1002,station,5,Ann,
1004,inertia,3,Ann,by hand
"""
PICTURES = {
    "plot.png": b"\x89PNG\r\n\x1a\n" + bytes(40),
    "report.pdf": b"%PDF-1.4\n" + b" " * 40,
}


def gate(accept: bool = False, part: bool = False) -> Found:
    """Grade the class."""
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        (home / "class").mkdir()
        for number in range(60):
            late, name = (
                "LATE_" * (number == 20),
                "photo.png" if number == 57 else "lab.csv",
            )
            path = (
                home
                / "class"
                / f"student{number:02d}_{late}{1000 + number}_{9000 + number}_{name}"
            )
            path.write_bytes(log_of(number))
        texts = {"printed": grade_again(home, "")["printed"]}
        sheets = {
            name: (home / "grades" / name).read_text("utf-8-sig")
            for name in ("grades.csv", "flags.csv")
        }
        texts |= sheets | {"all": digests(home / "grades")}
        (home / "rubric.toml").write_text(harder_rubric(), encoding="utf-8")
        (home / "canvas.csv").write_text(
            CANVAS + "".join(CANVAS_ROW.format(n=n) for n in range(60)),
            encoding="utf-8",
        )
        (home / "moodle.csv").write_text(
            MOODLE + "".join(MOODLE_ROW.format(n=n) for n in range(60)),
            encoding="utf-8",
        )
        (home / "roster.csv").write_text(ROSTER, encoding="utf-8")
        (home / "grades" / "desk.csv").write_text(DESK, encoding="utf-8")
        for number, name in ((3, "plot.png"), (4, "report.pdf")):
            (
                home
                / "class"
                / f"student{number:02d}_{1000 + number}_{9100 + number}_{name}"
            ).write_bytes(PICTURES[name])
        options = (
            f"--rubric {home}/rubric.toml --roster {home}/roster.csv --gradebook "
            f"{home}/canvas.csv"
        )
        printed = grade_again(home, options)["printed"].splitlines()
        texts["second run"] = "".join(
            f"{' '.join(map(digest, printed[at : at + 8]))}\n" for at in range(0, 90, 8)
        )
        texts["second run, all"] = digests(home / "grades")
        options = (
            f"--rubric {home}/rubric.toml --gradebook {home}/moodle.csv --attempts "
            f"oldest --format csv"
        )
        texts["third run"] = (
            digest(grade_again(home, options)["printed"])
            + "\n"
            + digests(home / "grades")
        )
        # The worksheet that was filled is filled again; JSON is compared to five
        # digits.
        (home / "moodle.csv").write_bytes((home / "grades" / "moodle.csv").read_bytes())
        options = options.replace("csv --attempts", "csv --dry-run --attempts").replace(
            "--format csv", "--format json"
        )
        document = json.loads(grade_again(home, options)["stdout"])
        words = [
            digest(json.dumps(kept(part, "", 5, 1e-9)))
            for part in [document, *document.pop("students")]
        ]
        texts["fourth run"] = "".join(
            f"{' '.join(words[at : at + 10])}\n" for at in range(0, len(words), 10)
        )
    lines = compare("grades.txt", texts, accept)
    rows = {
        row["student"]: row for row in csv.DictReader(io.StringIO(texts["grades.csv"]))
    }
    pairs = [
        {str(1000 + number), str(1000 + number - 5 * STATIONS)}
        for number in range(51, 56)
    ]
    flags = [
        set(row["students"].split(", "))
        for row in csv.DictReader(io.StringIO(texts["flags.csv"]))
    ]
    honest = [rows[str(1000 + number)] for number in range(37)]
    named = sum(
        kind in rows[str(1037 + at)]["slips"] for at, kind in enumerate(MISTAKES)
    )
    found = sum(any(pair <= flag for flag in flags) for pair in pairs)
    copied = set().union(*pairs)
    accused = sum(
        bool(row["slips"] or (row["flags"] and row["student"] not in copied))
        for row in honest
    )
    unjust = sum(float(row["inertia"]) < 5.5 for row in honest)
    measured = (
        f"{len(lines)} lines differ; {named} of 14 mistakes named, {found} of 5 copies "
        f"found, {accused} accused"
    )
    right = (named, found, accused, unjust) == (14, 5, 0, 0)
    measured += f", {unjust} lose points for a right answer"
    return Found(
        measured,
        "none differs, all named, all found, none, none",
        right and not lines,
        lines,
    )
