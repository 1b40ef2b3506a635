"""Logs whose meaning is in a sentence, in a legend, or in the shape of the table: the
truth, or a question.
"""

from __future__ import annotations

import json
import math
import re
import warnings
from collections.abc import Sequence

import numpy as np
import pytest
from readings.test_first_attempt import TRUTH, TURN, is_right
from sheets import workbook
from simulated_labs import analyze_briefly as analyze

import gyrodata
from gyrodata import GyroError, LogError
from gyrodata.readings import read_log

MASSES, SPINS = ("20.1", "40.3", "60.2"), (206, 407, 598)
HEAD = "mass (g);r (cm);spin (rpm);time (s);turns\n"
ROW, SHORT = "{m};14.8;{s};{t};1\n", "{m};14.8;{s};{t}\n"
PLAIN = "mass (g);spin (rpm);time (s)\n", "{m};{s};{t}\n"
MARKDOWN = "| mass (g) | r (cm) | spin (rpm) | t (s) | turns |\n|---|---|---|---|---|\n"


def t(mass: str, spin: int, turns: float = 1.0, arm: str = "14.8") -> str:
    return f"{turns * TURN * spin / float(mass) * 14.8 / float(arm):.2f}"


def runs(row: str, turns: float = 1.0, masses: Sequence[str] = MASSES) -> str:
    """Write a row for each run; {d} is the mass, or blank below the same mass; {c} is
    the time in min:s.
    """
    each = [(m, s, t(m, s, turns)) for m in masses for s in SPINS]
    of_runs = (
        {
            "m": m,
            "s": s,
            "t": time,
            "d": m if s == 206 else "",
            "c": f"0:{float(time):05.2f}",
        }
        for m, s, time in each
    )
    return "".join(row.format_map(run) for run in of_runs)


def crossed(label: str = "{s}", masses: Sequence[str] = MASSES) -> str:
    return "".join(
        f"{label.format(s=s)},{','.join(t(m, s) for m in masses)}\n" for s in SPINS
    )


def sheet(mass: str) -> list[list[str]]:
    head = [
        ["Mass (g)", mass],
        ["r (cm)", "14.8"],
        ["Turns", "1"],
        ["Spin (rpm)", "Time (s)"],
    ]
    return [*head, *([str(s), t(mass, s)] for s in SPINS)]


def program(list_of: str) -> str:
    """Write each quantity as a list of a program, with its unit in a comment."""
    columns = (
        ("m", "{m}", "g"),
        ("rpm", "{s}", ""),
        ("turns", "1", ""),
        ("t", "{t}", "s"),
    )
    cells = {
        name: ", ".join(runs(cell + ";").split(";")[:-1]) for name, cell, _ in columns
    }
    return "".join(
        f"{name} = {list_of.format(cells[name])}  # {unit}\n"
        for name, _, unit in columns
    )


def notebook(sources: Sequence[str]) -> str:
    """Write cells as a notebook of Jupyter."""
    return json.dumps(
        {
            "cells": [{"cell_type": "code", "source": [source]} for source in sources],
            "nbformat": 4,
        },
        indent=1,
    )


SURFACE, FROM_SURFACE = (
    "{m};9.72;{s};{t};1\n",
    "r is measured from the surface of the ball",
)
READ = {
    "weights at the top": "One turn, r = 14.8 cm\nTime (s)\nSpin (rpm),20.1 g,40.3 g,60.2 g\n"
    + crossed(),
    "times with weights": "r = 14.8 cm, one turn\nspin (rpm)"
    + "".join(f",time (s) with {m} g" for m in MASSES)
    + "\n"
    + crossed(),
    "units in a sentence": (
        "masses in g, positions in cm, spins in rpm, times in s\n"
        "mass;position;spin;time;turns\n"
    )
    + runs(ROW),
    "a list of units": "# Units: g, cm, rpm, s\nmass;position;spin;time;turns\n"
    + runs(ROW),
    "a sentence over three lines": "# We hung the weight on the rod 14.8 cm from the "
    "centre of the\n"
    "# ball and took the time from the start to the end of\n# half a turn.\n"
    + PLAIN[0]
    + runs(PLAIN[1], 0.5),
    "two sentences in a line": (
        "The weight is 14.8 cm from the centre of the ball. Each time is for half a "
        "turn.\n"
    )
    + PLAIN[0]
    + runs(PLAIN[1], 0.5),
    "a length of the weight": (
        "The weight is 2.0 cm long. It hangs 14.8 cm from the centre of the ball. One "
        "turn.\n"
    )
    + PLAIN[0]
    + runs(PLAIN[1]),
    "the diameter in a sentence": f"{FROM_SURFACE}. The diameter of the ball is 101.6 mm.\n"
    + HEAD
    + runs(SURFACE),
    "the radius in a sentence": f"{FROM_SURFACE}, whose radius is 5.08 cm.\n"
    + HEAD
    + runs(SURFACE),
    "to the middle of the weight": (
        f"Ball diameter 101.6 mm.\n{FROM_SURFACE} to the middle of the weight\n"
    )
    + HEAD
    + runs(SURFACE),
    "surface and centre in the header": "Ball diameter 101.6 mm\n"
    + HEAD.replace("r (cm)", "from the surface, centre of the weight [cm]")
    + runs(SURFACE),
    "the same weight moved": "\n".join(
        f"{title} r = {x} cm, one turn\nspin (rpm);time (s)\n"
        + "".join(f"{s};{t('20.1', s, 1, x)}\n" for s in SPINS)
        for title, x in (
            ("20.1 g at", "14.8"),
            ("same weight moved to", "17.1"),
            ("same weight moved to", "20.5"),
        )
    ),
    "only the spin before": HEAD.replace("spin (rpm)", "rpm before") + runs(ROW),
    "a spin, and one after": HEAD.replace("spin (rpm)", "spin (rpm);spin after (rpm)")
    + runs("{m};14.8;{s};{s};{t};1\n"),
    "units in snake case": "m_g;distance_from_centre_cm;spin_speed_rev/min;total_time_(1_turn)_s\n"
    + runs(SHORT),
    "omega_i": HEAD.replace("spin (rpm)", "omega_i / rpm") + runs(ROW),
    "the radius is added": "r = x + 5.08 cm, because x counts from the surface of the ball\n"
    + HEAD
    + runs(SURFACE),
    "surface without a unit": "units: g, cm, rpm, s\nmass;pos. from ball surface;spin;time;turns\n"
    "# ball_diameter: 101.6 mm\n" + runs(SURFACE),
    "a calculated rate": HEAD.replace("spin (rpm)", "rpm before;rpm after").replace(
        "turns", "turns;Omega [rad/s]"
    )
    + runs("{m};14.8;{s};{s};{t};1;0.3\n"),
    "a sentence behind the name of a quantity": (
        "# Spin = tachometer just before the rod was released\n"
    )
    + HEAD
    + runs(ROW),
    "used": "g = 9.80665 m/s² verwendet.;;;;\n" + HEAD + runs(ROW),
    "means without a name": HEAD
    + runs(ROW)
    + "\n40.2;14.8;403.67;"
    + f"{sum(float(t(m, s)) for m in MASSES for s in SPINS) / 9:.4f};1\n",
    "a constant from the surface": (
        "weight always 9.72 cm from the surface of the ball (ball diameter 101.6 mm)\n"
    )
    + HEAD.replace("r (cm);", "")
    + runs("{m};{s};{t};1\n"),
    "a constant, and the radius": "pesa a 9,72 cm de la superficie de la bola (radio 5,08 cm)\n"
    + HEAD.replace("r (cm);", "")
    + runs("{m};{s};{t};1\n"),
    "a remark with the word about": (
        "Uncertainty: the stopwatch (about 0.15 s) and the position of the weight.\n"
    )
    + HEAD
    + runs(ROW),
    "turns behind time": "# time = 2 turns\n"
    + HEAD.replace(";turns", "")
    + runs(SHORT, 2),
    "a legend": (
        "m = mass (g), R = distance from ball centre (cm)\nn = spin (rpm), t = time "
        "for one turn (s)\nm;R;n;t\n"
    )
    + runs(SHORT),
    "a legend in German": "- Masse `m` in g\n- Abstand `r` von der Mitte in cm\n- "
    "Drehzahl `n` in 1/min\n"
    "- Zeit `t` für eine Umdrehung in s\n\n| m | r | n | t |\n|---|---|---|---|\n"
    + runs("|{m}|14.8|{s}|{t}|\n"),
    "symbols and meanings": "symbol;meaning\nm;mass in g\nR;distance from ball centre "
    "in cm\nw;spin in rpm\n"
    "t;time for one turn in s\n\nm;R;w;t\n" + runs(SHORT),
    "units with words": "mass;position;spin;time\ng;cm from centre;rpm;s, one turn\n"
    + runs(SHORT),
    "seconds per turn": HEAD.replace("time (s);turns", "sec per turn") + runs(SHORT),
    "units in the cells": "mass;position;spin;time;turns\n"
    + runs("{m} g;14.8 cm;{s} rpm;{t} s;1\n"),
    "commas in Markdown": (MARKDOWN + runs("| {m} | 14.8 | {s} | {t} | 1 |\n")).replace(
        ".", ","
    ),
    "commas between blanks": (HEAD + runs("{m};  14.8;  {s};  {t};  1\n"))
    .replace(";", "   ")
    .replace(".", ","),
    "names in the second column": "".join(
        f",{name}{runs(',' + cell)}\n"
        for name, cell in (
            ("mass (g)", "{m}"),
            ("r (cm)", "14.8"),
            ("spin (rpm)", "{s}"),
            ("time for one turn (s)", "{t}"),
        )
    ),
    "blocks with titles": "20.1 g,,,40.3 g,,,60.2 g,\n"
    + ",,".join(["spin (rpm),time (s)"] * 3)
    + "\n"
    + "".join(",,".join(f"{s},{t(m, s)}" for m in MASSES) + "\n" for s in SPINS)
    + "One turn each; r = 14.8 cm\n",
    "names with the numbers of pandas": "m (g),x (cm),rpm,t (s),turns,"
    "m (g).1,x (cm).1,rpm.1,t (s).1,turns.1\n20.1,14.8,400,9.1,1,40.3,14.8,400,4.6,1\n",
    "a row struck out": MARKDOWN
    + runs("| {m} | 14.8 | {s} | {t} | 1 |\n")
    + "| ~~20.1~~ | ~~14.8~~ | ~~300~~ | ~~1.0~~ | ~~1~~ |\n",
    "a run that is not used": HEAD.replace("turns", "turns;note")
    + runs(ROW)
    + "20.1;14.8;300;1;1;slip: do not use\n",
    "merged cells of a web page": (
        "<html>\n<table><tr><th>mass (g)<th>r (cm)<th>spin (rpm)<th>t (s)<th>turns</tr>"
    )
    + runs(
        "<tr><td rowspan=3>{d}</td><td>14.8</td><td>{s}</td><td>{t}</td><td>1</td></tr>"
    ).replace("<td rowspan=3></td>", "")
    + "</table></html>",
    "LaTeX with a caption": "\\begin{table}\n\\caption{Times for one full turn, weight "
    "at 14.8 cm from the "
    "centre}\n"
    "\\begin{tabular}{lll}\n$m$ [g] & $\\omega$ [rpm] & $t$ [s] \\\\ \\hline\n"
    + runs("{m} & {s} & {t} \\\\\n")
    + "\\end{tabular}\n\\end{table}\n",
    "results below the runs": HEAD
    + runs(ROW)
    + "I_zz;0.0044;kg m^2\nu(I_zz);5e-05;kg m^2\n",
    "the ditto mark of Japan": HEAD + runs("{d}" + ROW[3:]).replace("\n;", "\n〃;"),
    "Italian thirds": HEAD + runs("{m};14.8;{s};{t};due terzi\n", 2 / 3),
    "several runs in a line": "r = 14.8 cm from the centre, one full turn each\n"
    + "".join(
        f"M{at} = {m} g: " + " ".join(f"({s} rpm; {t(m, s)} s)" for s in SPINS) + "\n"
        for at, m in enumerate(MASSES, 1)
    ),
    "words between blanks": "rod pos 14.8 cm from ball center\ntimed one full turn each\n"
    + "".join(
        f"\n{m} g weight\n" + "".join(f"{s} rpm - {t(m, s)} s\n" for s in SPINS)
        for m in MASSES
    ),
    "the mass in a sentence": "".join(
        f"\nThe {m} g weight is on the rod, 14.8 cm from the centre of the ball.\n"
        + "".join(f"Spin {s} rpm, one full turn took {t(m, s)} s.\n" for s in SPINS)
        for m in MASSES
    ),
    "turns by their unit": HEAD.replace("turns", "Precession (turns)") + runs(ROW),
    "units as names": "g;cm;rpm;sec;turns\n" + runs(ROW),
    "fewer units than names": " mass   r    spin  turn  time\n (g)  (cm)  (rpm)        (s)\n"
    + runs("{m}  14.8    {s}     1  {t}\n"),
    "1 as a unit": "mass;r;rpm;t;turns\ng;cm;1/min;s;1\n" + runs(ROW),
    "results on the right": HEAD + runs(ROW).replace(";1\n", ";1;;;u;4e-5\n", 1),
    "a typing error": HEAD.replace("r (cm)", "Postion (cm)") + runs(ROW),
    "two times in a cell": HEAD.replace("time (s)", "times (s)")
    + runs(ROW.replace("{t}", "{t} / {t}")),
    "numbers of the weights": HEAD.replace("mass (g)", "Weight;mass (g)")
    + runs("1;" + ROW),
    "two weights together": HEAD
    + runs(ROW.replace("{m}", "{m}+10"))
    .replace("20.1+", "10.1+")
    .replace("40.3+", "30.3+")
    .replace("60.2+", "50.2+"),
    "minutes and seconds": HEAD.replace("time (s)", "time m:ss")
    + runs(ROW.replace("{t}", "{c}")),
    "rows of LaTeX together": "\\caption{Tiempo (una vuelta completa), "
    "$d=\\SI{0.148}{\\metre}$ del centro.}\n"
    "$m$ [\\si{\\gram}] & $n$ [rpm] & $t$ [s]\\\\\n"
    + runs("<{d}> & {s} & {t} \\\\\n")
    .replace("<>", "")
    .replace("<", "\\multirow{3}{*}{")
    .replace(">", "}"),
    "a quoted mail": "".join(f"> {line}\n" for line in (HEAD + runs(ROW)).splitlines()),
    "a Norwegian unit": HEAD.replace("spin (rpm)", "turtall (o/min)") + runs(ROW),
    "one mass twice": "14,8 cm von der Mitte, je ein Umlauf\n"
    + "".join(
        f"Masse: {m} g (Waage: {m}0 g)\nspin (rpm);time (s)\n"
        + runs("{s};{t}\n", 1, [m])
        + "\n"
        for m in MASSES
    ),
    "results below their own names": workbook(
        {
            **{f"{m} g": sheet(m) for m in MASSES},
            "Result": [["I_zz (kg m^2)", "uncertainty (kg m^2)"], ["0.0044", "5e-5"]],
        }
    ),
    "a result with its unit in a cell": HEAD
    + runs(ROW)
    + ";;;average;0.0044\n;;;standard error;5e-5\nI (kg m2);0.0044\n",
    "laps that number the runs": "One full turn in every measurement\n"
    + HEAD.replace("mass", "Lap;mass").replace(";turns", "")
    + "".join(f"{n};{row}\n" for n, row in enumerate(runs(SHORT).splitlines(), 1)),
    "parts in percent": HEAD + runs("{m};14.8;{s};{t};25 %\n", 0.25),
    "quarters as words": HEAD.replace("turns", "Quarter turns")
    + runs("{m};14.8;{s};{t};3\n", 0.75),
    "powers of ten in units": HEAD.replace("(g)", "(10^-3 kg)")
    .replace("(rpm)", "(x10 rpm)")
    .replace("(s)", "(1/100 s)")
    + "".join(
        f"{m};14.8;{s / 10:.1f};{100 * float(t(m, s)):.0f};1\n"
        for m in MASSES
        for s in SPINS
    ),
    "before and after": HEAD.replace(
        "spin (rpm)", "Before (rpm);After (rpm);Average (rpm)"
    )
    + runs(ROW.replace("{s}", "{s};{s};{s}")),
    "a bare rpm": HEAD.replace("spin (rpm)", "ball rpm") + runs(ROW),
    "slashes between the cells": "weight at 14.8 cm\nmass / rpm / turns / time\n"
    + runs("{m} g / {s} rpm / 1 / {t} s\n"),
    "a weight on the rod": (
        "Time for one turn in s. Rod weight at 14.8 cm.\nspin (rpm),20.1 g,40.3 "
        "g,60.2 g\n"
    )
    + crossed(),
    "a formula in Markdown": "We used $x = 14.8$ cm for all runs.\n\n"
    + MARKDOWN.replace(" r (cm) |", "").replace("|---", "", 1)
    + runs("| {m} | {s} | {t} | 1 |\n"),
    "stamps of a chat": "".join(
        f"[13/02/2024, 14:0{n}:32] Mia: {row}\n"
        for n, row in enumerate(
            runs("{m} g, 14.8 cm, {s} rpm, 1 turn, {t} s\n").splitlines()
        )
    ),
    "names at the side of three tables": (
        "r = 14.8 cm;;;;;;\nmass:;20.1 g;;40.3 g;;60.2 g;\nturns:;1;;1;;1;\n"
    )
    + ";rpm;t/s" * 3
    + "\n"
    + "".join(
        f"run {n}" + "".join(f";{s};{t(m, s)}" for m in MASSES) + "\n"
        for n, s in enumerate(SPINS, 1)
    ),
    "lists of a program": "import numpy as np\nx = 14.8  # cm\n"
    + program("np.array([{}])")
    + "I = m * x / rpm\n",
    "lists of R": "x <- 14.8  # cm\n" + program("c({})").replace("=", "<-"),
    "a matrix of MATLAB": "% mass(g)  dist(cm)  spin(rpm)  turns  time(s)\ndata = [\n"
    + runs("  {m}  14.8  {s}  1  {t};\n")
    + "];\n",
    "a table of a notebook": notebook(
        ["# Gyro\n\n" + MARKDOWN + runs("| {m} | 14.8 | {s} | {t} | 1 |\n"), "m.mean()"]
    ),
    "a string of a notebook": notebook(
        ['data = """' + HEAD + runs(ROW) + '"""\ndf = pd.read_csv(io.StringIO(data))']
    ),
    "tuples of a notebook": notebook(
        [
            "# mass (g), r (cm), spin (rpm), turns, t (s)\ndata = [\n"
            + runs("    ({m}, 14.8, {s}, 1, {t}),\n")
            + "]"
        ]
    ),
    "a dictionary of a notebook": notebook(
        [
            "df = pd.DataFrame({\n"
            + "".join(
                f'    "{name}": [{", ".join(runs(cell + ";").split(";")[:-1])}],\n'
                for name, cell in (
                    ("mass_g", "{m}"),
                    ("r_cm", "14.8"),
                    ("spin_rpm", "{s}"),
                    ("turns", "1"),
                    ("time_s", "{t}"),
                )
            )
            + "})"
        ]
    ),
    "tuples of a program": (
        "from math import pi\n# mass [g], r (cm), spin [rpm], turns, t [s]\nrows = [\n"
    )
    + runs("  ({m}, 14.8, {s}.0, 1, {t}),\n")
    + "]\nI = [m / 1e3 * 9.8 * r for m, r, s, n, t in rows]\n",
    "a legend in a program": "d = distance from the centre in cm\nN = number of turns\n"
    "# mass (g), d, spin (rpm), N, t (s)\nrows = [\n"
    + runs("  ({m}, 14.8, {s}.0, 1, {t}),\n")
    + "]\nk = 9.8 * rows[0]\n",
    "remarks behind %": "% r = 14.8 cm\n"
    + PLAIN[0]
    + runs(PLAIN[1])
    + "% time for one turn\n",
    "a header behind # with bars": (
        "Each time is for one turn\n# | m / g | r / cm | ω / rpm | t / s |\n"
    )
    + "".join(
        f"{n} | {row} |\n"
        for n, row in enumerate(runs("{m} | 14.8 | {s} | {t}\n").splitlines(), 1)
    ),
    "a unit behind a slash": (
        "masse / g;bras de levier / cm;vitesse de rotation / tr/min;temps / s;tours\n"
    )
    + runs(ROW),
    "a column of turns and a text about full turns": "time of the stated number of full turns\n"
    + HEAD.replace("turns", "turns of the rod")
    + runs(ROW.replace(";1\n", ";3\n"), 3),
    "a remark on turns and a text about turns": HEAD.replace(
        "turns", "remarks on the turn"
    )
    + runs(ROW.replace(";1\n", ";ok\n"), 1 / 3)
    + "All times are for 1/3 of a turn.\n",
    "a column of turns above another text": HEAD.replace("turns", "turns of the rod")
    + runs(ROW.replace(";1\n", ";3\n"), 3)
    + "The time covers the stated number of full turns.\n",
    "a title that says how long a turn takes": "Mass,r,Spin,1 turn takes\n"
    + runs("{m}g,14.8cm,{s}rpm,{t}s\n"),
    "units in a sentence, with that of the spin in words": "masses in gram, "
    "r in cm from the centre of the ball, n in revs per minute, T (1 turn) in "
    "seconds\nm;r;n;T\n" + runs(SHORT),
    "letters explained below": "M,d,w,N,t\n"
    + "".join(
        f"{m},14.8,{s * math.pi / 30:.2f},1,{t(m, s)}\n" for m in MASSES for s in SPINS
    )
    + "\nM = mass in g\nd = cm from centre of sphere\nw = spin in rad/s\nN = how many turns\n"
    "t = stopwatch in s for the N turns\n",
    "weights on a sheet of their own": workbook(
        {
            "weights": [
                ["name", "g"],
                *([f"W{at}", m] for at, m in enumerate(MASSES, 1)),
            ],
            "runs": [
                ["weight", "r (cm)", "spin (rpm)", "time of two turns (s)"],
                *(
                    [f"W{at}", "14.8", str(s), t(m, s, 2)]
                    for at, m in enumerate(MASSES, 1)
                    for s in SPINS
                ),
            ],
        }
    ),
    "numbers of holes in a sentence": "Holes (from centre of ball): #1 14.8 cm, #2 18.0 cm\n"
    + HEAD.replace("r (cm)", "hole")
    + runs("{m};1;{s};{t};1\n"),
    "places in a legend with a semicolon": HEAD.replace("r (cm)", "posición")
    + runs("{m};A;{s};{t};1\n")
    + "A: 14,8 cm del centro;;;\n",
    "rows with another delimiter": HEAD
    + runs(ROW, masses=MASSES[:2])
    + runs(ROW, masses=MASSES[2:]).replace(";", ","),
    "a weight in newtons with its symbol": HEAD.replace("mass (g)", "Gewicht G (N)")
    + "".join(
        f"{float(m) * 9.81e-3:.5f};14.8;{s};{t(m, s)};1\n"
        for m in MASSES
        for s in SPINS
    ),
    "a symbol with its uncertainty beside it": HEAD.replace(
        "time (s);turns", "T precesji [s];u(T)"
    )
    + runs("{m};14.8;{s};{t};0.1\n"),
    "a calculated rate without a unit": HEAD.replace(
        "time (s);turns", "T one turn (s);omega prec"
    )
    + runs("{m};14.8;{s};{t};0.3\n"),
    "a fraction of a scale in a sentence": "La masselotte pèse 20.1 g (balance au 1/10 g).\n"
    "On mesure un tour de la tige.\nbras (cm);N (tr/min);durée (s)\n"
    + runs("14.8;{s};{t}\n", masses=MASSES[:1])
    + "La masselotte pèse 40.3 g\nbras (cm);N (tr/min);durée (s)\n"
    + runs("14.8;{s};{t}\n", masses=MASSES[1:2])
    + "La masselotte pèse 60.2 g\nbras (cm);N (tr/min);durée (s)\n"
    + runs("14.8;{s};{t}\n", masses=MASSES[2:]),
    "a title over the repeats": workbook(
        {
            "Sheet": [
                ["", "", "", "Time for one precession (s)"],
                [
                    "Mass (g)",
                    "r from ball centre (cm)",
                    "Spin (rpm)",
                    "Trial 1",
                    "Trial 2",
                    "Average",
                    "SD",
                ],
                *(
                    [m, "14.8", str(s), t(m, s), t(m, s), t(m, s), "0.01"]
                    for m in MASSES
                    for s in SPINS
                ),
            ]
        }
    ),
    "a run that was aborted": HEAD.replace("\n", ";remarks\n")
    + runs("{m};14.8;{s};{t};1;\n")
    + "60.2;14.8;300;aborted;1;hit the table\n60.2;14.8;300;---;1;forgot the stopwatch\n",
    "a unit behind a name that nobody knows": "m in g;a in cm;f in rpm;T1 in s\n"
    + runs(SHORT),
    "names of columns that end in a unit": "m_weight/g\tr_centre/cm\tf_spin/rpm\tt_one_turn/s\n"
    + runs(SHORT.replace(";", "\t")),
    "a header of several words behind #": (
        "# columns: mass/g  r/cm (centre of ball)  spin/rpm  number of turns  t/s\n"
    )
    + runs("{m} 14.8 {s} 1 {t}\n"),
    "the diameter in a cell of its own": "Диаметр шара, см;10.16\nl - расстояние от "
    "поверхности шара до груза\n"
    "m, г;l, см;n, об/мин;T (1 оборот), с\n" + runs("{m};9.72;{s};{t}\n"),
    "the radius of the ball": "Kugel: R = 50,8 mm;;;\nx: Abstand Kugeloberfläche - Gewicht;;;\n"
    "m/g;x/cm;n/min^-1;t/s (1 Umlauf)\n" + runs("{m};9.72;{s};{t}\n"),
    "a force that nobody knows": HEAD.replace("mass (g)", "Tyngdekraft på lod (newton)")
    + "".join(
        f"{float(m) * 9.81e-3:.5f};14.8;{s};{t(m, s)};1\n"
        for m in MASSES
        for s in SPINS
    ),
    "turns in a cell above": "Voltas cronometradas;3\nmassa (g);posição (cm, a partir "
    "do centro);rotação (rpm);"
    "tempo (s)\n" + runs(SHORT, 3),
    "a spin before and after in Italian": HEAD.replace(
        "spin (rpm)", "giri/min inizio;giri/min fine"
    )
    + runs(ROW.replace("{s}", "{s};{s}")),
    "constants on a second sheet": workbook(
        {
            "Runs": [
                line.split(";") for line in (PLAIN[0] + runs(PLAIN[1])).splitlines()
            ],
            "Constants": [
                ["quantity", "value", "unit"],
                ["distance from centre", "14.8", "cm"],
                ["turns", "1", ""],
            ],
        }
    ),
}


ASKED_FORMS = {
    "weights at the top": "G201",
    "times with weights": "G301",
    "units in a sentence": "G206",
    "a list of units": "G206",
    "the diameter in a sentence": "G340",
    "the radius in a sentence": "G340",
    "the radius is added": "G340",
    "surface without a unit": "G206",
    "used": "G306",
    "a constant from the surface": "G340",
    "a constant, and the radius": "G340",
    "blocks with titles": "G210",
    "names at the side of three tables": "G210",
    "names with the numbers of pandas": "G210",
    "merged cells of a web page": "G104",
    "LaTeX with a caption": "G104",
    "the ditto mark of Japan": "G203",
    "several runs in a line": "G201",
    "words between blanks": "G206",
    "the mass in a sentence": "G201",
    "two times in a cell": "G203",
    "rows of LaTeX together": "G104",
    "a quoted mail": "G203",
    "slashes between the cells": "G210",
    "a weight on the rod": "G201",
    "stamps of a chat": "G201",
    "lists of a program": "G104",
    "lists of R": "G104",
    "a matrix of MATLAB": "G104",
    "a table of a notebook": "G104",
    "a string of a notebook": "G104",
    "tuples of a notebook": "G104",
    "a dictionary of a notebook": "G104",
    "tuples of a program": "G104",
    "a legend in a program": "G104",
    "names in the second column": "G201",
    "a title that says how long a turn takes": "G301",
    "remarks behind %": "G301",
    "a remark on turns and a text about turns": "G301",
    "units in a sentence, with that of the spin in words": "G207",
    "letters explained below": "G207",
    "turns behind time": "G306",
    "a legend": "G206",
    "a legend in German": "G206",
    "symbols and meanings": "G206",
    "results below the runs": "G203",
    "a result with its unit in a cell": "G203",
    "weights on a sheet of their own": "G203",
    "numbers of holes in a sentence": "G206",
    "places in a legend with a semicolon": "G203",
    "rows with another delimiter": "G203",
    "a symbol with its uncertainty beside it": "G207",
    "a title over the repeats": "G301",
    "a unit behind a name that nobody knows": "G301",
    "a header of several words behind #": "G201",
    "the diameter in a cell of its own": "G340",
    "the radius of the ball": "G340",
    "constants on a second sheet": "G301",
    "a sentence over three lines": "G301",
    "the same weight moved": "G301",
    "seconds per turn": "G205",
    "one mass twice": "G301",
    "a fraction of a scale in a sentence": "G301",
}
"""Rare forms that are asked about, with the code of the first question."""
TWICE = "a title over the repeats"
"""The log with two times for each run."""


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in READ if name not in ASKED_FORMS])
def test_each_run_is_read_as_it_is_meant(name: str) -> None:
    analysis = analyze(READ[name])
    assert len(analysis.run_table) == (18 if name == TWICE else 9)
    assert analysis.inertia.value == pytest.approx(TRUTH, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", ASKED_FORMS)
def test_a_rare_form_is_asked_about_with_what_to_type(name: str) -> None:
    with pytest.raises(GyroError) as refused:
        analyze(READ[name])
    errors = [one for one in refused.value.diagnostics if one.severity == "error"]
    assert errors[0].code == ASKED_FORMS[name]
    assert errors[0].hint


TURNS_IN_WORDS = {
    "Zeit zweier Umdrehungen": 2,
    "temps de trois tours": 3,
    "tiempo de dos vueltas": 2,
    "tempo di tre giri": 3,
    "tempo de duas voltas": 2,
    "tijd 1/2 omw.": 1 / 2,
    "tid för tre varv": 3,
    "kahden kierroksen aika": 2,
    "kolmen kierroksen aika": 3,
    "czas trzech obrotów": 3,
    "čas tří otáček": 3,
    "čas troch otáčok": 3,
    "vrijeme dva okreta": 2,
    "čas treh vrtljajev": 3,
    "kahe pöörde aeg": 2,
    "trijų apsisukimų laikas": 3,
    "temps de dues voltes": 2,
    "время двух оборотов": 2,
    "час трьох обертів": 3,
    "két fordulat ideje": 2,
    "üç tur süresi": 3,
    "timp pentru două rotații": 2,
    "χρόνος τριών περιστροφών": 3,
    "време за два оборота": 2,
    "两圈时间": 2,
    "半周の時間": 1 / 2,
    "세 바퀴 시간": 3,
    "thời gian hai vòng": 2,
    "waktu tiga putaran": 3,
}


@pytest.mark.slow
@pytest.mark.parametrize("words", TURNS_IN_WORDS)
def test_turns_in_words_of_many_languages_are_read_in_the_header_of_a_time(
    words: str,
) -> None:
    log = read_log(
        f"# r: 14.8 cm\n{PLAIN[0].replace('time (s)', f'{words} (s)')}{runs(PLAIN[1])}"
    )
    assert log.columns["turns"].values == pytest.approx([TURNS_IN_WORDS[words]] * 9)


@pytest.mark.parametrize(
    ("words", "turns"),
    [
        ("tid för två varv", 2),
        ("čas tří otáček", 3),
        ("čas čtvrtiny otáčky", 1 / 4),
        ("tiempo de media vuelta", 1 / 2),
    ],
)
def test_turns_in_words_with_accents_are_read_above_the_table(
    words: str, turns: float
) -> None:
    log = read_log(f"# {words}\n# r: 14.8 cm\n{PLAIN[0]}{runs(PLAIN[1])}")
    assert log.columns["turns"].values == pytest.approx([turns] * 9)


BEFORE_AND_AFTER = (
    "tr/min début, tr/min fin; giri iniziali (rpm), giri finali (rpm); rpm inicial, "
    "rpm final; rpm início, rpm fim; "
    "U/min Anfang, U/min Ende; toeren/min begin, toeren/min eind; varv/min före, varv/min efter; "
    "o/min før, o/min etter; obr/min początek, obr/min koniec; ot/min začátek, ot/min konec; "
    "об/мин начало, об/мин конец; rpm alussa, rpm lopussa; ford/perc eleje, ford/perc "
    "vége; rpm baş, rpm son; "
    "rot/min început, rot/min sfârșit"
)


@pytest.mark.parametrize("pair", BEFORE_AND_AFTER.split("; "))
def test_spin_before_and_after_is_read_in_many_languages(pair: str) -> None:
    log = read_log(
        HEAD.replace("spin (rpm)", pair.replace(", ", ";"))
        + runs(ROW.replace("{s}", "{s};{s}"))
    )
    assert {"spin_start", "spin_end"} <= log.columns.keys()


PARTS = {
    "Zeit für eine Vierteldrehung": 1 / 4,
    "tempo per un quarto di giro": 1 / 4,
    "время полуоборота": 1 / 2,
    "čas čtvrtiny otáčky": 1 / 4,
    "tijd voor een kwartslag": 1 / 4,
    "tempo de meia volta": 1 / 2,
    "temps pour la moitié d'un tour": 1 / 2,
    "time half way around": 1 / 2,
    "time to go round twice": 2,
    "time for half a precession": 1 / 2,
    "çeyrek tur süresi": 1 / 4,
    "idő: negyed fordulat": 1 / 4,
    "time for one turn/s": 1,
    "half_turn_s": 1 / 2,
}


@pytest.mark.slow
@pytest.mark.parametrize("words", PARTS)
def test_part_of_a_turn_is_read_in_a_header(words: str) -> None:
    header = words if words[-2] in "/_" else f"{words} (s)"
    head = PLAIN[0].replace("time (s)", header)
    log = read_log(f"# r: 14.8 cm\n{head}{runs(PLAIN[1], PARTS[words])}")
    assert log.columns["turns"].values == pytest.approx([PARTS[words]] * 9)


@pytest.mark.slow
@pytest.mark.parametrize("words", [words for words in PARTS if words[-2] not in "/_"])
def test_part_of_a_turn_in_a_line_is_read_or_asked_about(words: str) -> None:
    log = read_log(f"# r: 14.8 cm\n{words}\n{PLAIN[0]}{runs(PLAIN[1], PARTS[words])}")
    if "turns" in log.columns:
        assert log.columns["turns"].values == pytest.approx([PARTS[words]] * 9)
    else:
        assert "turns is missing" in str(log.diagnostics)


HALF = (
    "All times are for one full turn.\n"
    + HEAD.replace("time (s);turns", "half a turn (s)")
    + runs(SHORT, 0.5)
)
ORIGINS = "The position is measured from the centre of the ball\n"
FULL = "Time for one full revolution of the rod, weight 14.8 cm from the centre\n"
ASKED = [
    (
        FULL + PLAIN[0] + runs(PLAIN[1]) + "\nAll times are for 1/3 of a revolution.\n",
        "G303",
        "says 1/3",
    ),
    ("spin (rpm),20.1 g,40.3 g,60.2 g\n" + crossed(), "G201", "one row for each run"),
    (
        "Time of one turn (s), r = 14.8 cm\nspin (rpm) \\ mass (g),20.1,40.3,60.2\n"
        + crossed(),
        "G201",
        "one row for each run",
    ),
    (
        "r = 14.8 cm\ntime of one turn (s),20.1 g,40.3 g,60.2 g\n" + crossed("{s} rpm"),
        "G201",
        "one row for each run",
    ),
    (
        "position of the weight: 14.8 cm\n"
        + "".join(
            f"\nmass = {m} g, 1 turn\nrpm,206,407,598\n"
            f"time (s),{','.join(t(m, s) for s in SPINS)}\n"
            for m in MASSES
        ),
        "G201",
        "one row for each run",
    ),
    (
        "one washer = 8.3 g\n"
        + HEAD.replace("mass (g)", "washers")
        + "".join(runs(f"{n}" + ROW[3:], 1, [f"{8.3 * n:.1f}"]) for n in (2, 4, 6)),
        "G301",
        "mass is missing",
    ),
    *(
        (
            f"{line}\nweight 14.8 cm from the centre\n{PLAIN[0]}" + runs(PLAIN[1]),
            "G301",
            "turns is missing",
        )
        for line in ("one screw = 1/3 turn", "# 3 screws = 1 full turn")
    ),
    (HALF, "G303", "covers 1/2 turns, and .* says 1"),
    (
        "# turns: 1/2\n" + HEAD.replace("turns", "Rev") + runs(ROW, 0.5),
        "G237",
        "delete the line or the column",
    ),
    (
        f"{FROM_SURFACE} (diameter 101.6 mm)\n{ORIGINS}{HEAD}{runs(SURFACE)}",
        "G340",
        "and another says",
    ),
    (
        f"{FROM_SURFACE}\n{HEAD.replace('r (cm)', 'x from centre (cm)')}{runs(SURFACE)}",
        "G340",
        "and another says",
    ),
]


@pytest.mark.parametrize(("log", "code", "words"), ASKED)
def test_what_contradicts_itself_is_asked_about(
    log: str, code: str, words: str
) -> None:
    with pytest.raises(LogError, match=f"(?s){code}.*{words}"):
        analyze(log)


@pytest.mark.slow
def test_option_decides_which_turns_are_right() -> None:
    found = [
        analyze(HALF, settings={"turns": turns}).inertia.value for turns in ("1/2", "1")
    ]
    assert found == pytest.approx([TRUTH, TRUTH / 2], rel=0.02)


HINTS = {
    "two times": (
        ROW.replace("{t}", "{t} and {t}"),
        "write the one that is right",
        ROW,
    ),
    "no mass": (ROW.replace("{m}", ""), "write it there", ROW),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", HINTS)
def test_hint_about_one_wrong_row_leads_to_the_answer(case: str) -> None:
    wrong, hint, right = HINTS[case]
    rows = [runs(row).splitlines(keepends=True) for row in (ROW, wrong, right)]
    for changed, is_wrong in ((rows[1], True), (rows[2], False)):
        log = HEAD + "".join([*rows[0][:4], changed[4], *rows[0][5:]])
        if is_wrong:
            with pytest.raises(LogError, match=hint):
                analyze(log)
        else:
            assert is_right(log)


@pytest.mark.parametrize("tau", [600.0, 2000.0])
def test_spin_that_is_read_only_before_the_runs_gives_the_truth(tau: float) -> None:
    """Simulated: I_zz = 4.44e-3 kg m^2, three turns in each run, a spin that falls by
    1/e in tau, seed 1.
    """
    random, inertia = np.random.default_rng(1), 4.44e-3
    log = "mass [g],position [cm],spin before [rpm],time [s],turns\n"
    for mass in (20.0, 40.0, 60.0):
        for rpm in (200, 400, 600):
            torque = 1e-3 * mass * 9.80665 * 0.15
            time = tau * math.log1p(
                6 * math.pi * inertia * rpm * math.pi / 30 / (torque * tau)
            )
            log += f"{mass:.2f},15.0,{rpm},{time + random.normal(0, 0.1):.2f},3\n"
    found = analyze(log).inertia
    assert found.interval_95 is not None
    assert found.interval_95[0] < inertia < found.interval_95[1]
    assert found.value == pytest.approx(inertia, rel=0.015)


OTHER_TURNS = {
    "Gyroscope, 3 rotations each\n": False,
    "# all 3 turns\n": False,
    "T is the time of one turn (we timed 3 turns and divided)\n": False,
}


@pytest.mark.parametrize("note", OTHER_TURNS)
def test_period_of_one_turn_is_asked_about_if_a_note_counts_more(note: str) -> None:
    log = f"{note}mass (g),r (cm),spin (rpm),T (s)\n" + runs("{m},14.8,{s},{t}\n")
    found = read_log(log)
    assert (
        found.ok,
        [one.code for one in found.diagnostics if one.code == "G207"],
    ) == (OTHER_TURNS[note], [] if OTHER_TURNS[note] else ["G207"])


@pytest.mark.slow
def test_uncertainties_in_a_remark_are_not_the_readings() -> None:
    log = (
        HEAD
        + runs(ROW)
        + "u(r) = 1 mm, u(t) = 0.15 s, u(m) = 0.1 g, combined in quadrature\n"
    )
    assert is_right(log)


def test_turns_that_count_the_rows_are_asked_about_unless_mapped() -> None:
    log = HEAD.replace("turns", "N") + "".join(
        f"{row};{n}\n"
        for n, row in enumerate(runs("{m};14.8;{s};{t}\n").splitlines(), 1)
    )
    (asked,) = read_log(log).diagnostics
    assert (asked.code, asked.severity) == ("G303", "error")
    mapped = read_log(log, mapping={"turns": "N"})
    assert mapped.ok
    assert mapped.columns["turns"].values == tuple(map(float, range(1, 10)))


@pytest.mark.slow
def test_numbers_of_holes_are_replaced_as_the_hint_says() -> None:
    log = HEAD.replace("r (cm)", "hole no.") + runs("{m};1;{s};{t};1\n")
    assert "write in each cell what its number means, such as 9.0 cm" in str(
        read_log(log).diagnostics
    )
    assert is_right(log.replace(";1;", ";14.8 cm;"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "thing", ["the ball", "the rod", "the sphere", "the ball and the rod"]
)
def test_unit_of_another_thing_is_not_the_unit_of_a_column(thing: str) -> None:
    bare = "mass;r (cm);spin (rpm);time (s);turns\n" + runs(ROW)
    for line in (
        "masses in g",
        f"mass of {thing} in kg",
        f"{thing} in kg",
        f"Units: mass of {thing} in kg",
        "hook: 5 g",
    ):
        told = read_log(f"# {line}\n{bare}").diagnostics
        assert [one.code for one in told if one.severity == "error"] == ["G206"], line


def test_turns_without_a_weight_are_not_those_of_the_runs_below() -> None:
    log = HEAD + "0;;400;180;1/20\n" + runs("{m};14.8;{s};{t};\n")
    with pytest.raises(LogError, match=r"G302: lines 3-11: no turns"):
        analyze(log)


@pytest.mark.slow
def test_turns_of_each_row_can_be_written_as_the_hint_says() -> None:
    rows = [
        (m, arm, 5 if m == "30.1" else 1)
        for m in ("30.1", "60.2")
        for arm in ("12.0", "16.0", "20.0", "24.0")
    ]
    typed = [f"{m};{arm};407;{t(m, 407, turns, arm)}" for m, arm, turns in rows]
    with pytest.raises(
        LogError,
        match=r"G420(?s:.*)in a column turns, and no turns in the header of the time",
    ):
        analyze(
            HEAD.replace("time (s);turns", "time for 5 turns (s)")
            + "\n".join(typed)
            + "\n"
        )
    assert is_right(
        HEAD
        + "".join(
            f"{row};{turns}\n" for row, (_, _, turns) in zip(typed, rows, strict=True)
        )
    )


def test_angle_among_numbers_of_turns_is_asked_about() -> None:
    typed = runs("{m};14.8;{s};{t};1/4\n", 0.25).replace(
        f"{t('60.2', 598, 0.25)};1/4", f"{t('60.2', 598, 0.25)};90"
    )
    with pytest.raises(
        LogError, match=r"90 turns is too large for one run(?s:.*)write 1/4"
    ):
        analyze(HEAD + typed)


def test_weight_in_newtons_can_be_written_as_the_hint_says() -> None:
    newtons = "".join(
        f"{float(m) * 9.81e-3:.5f};14.8;{s};{t(m, s)};1\n"
        for m in MASSES
        for s in SPINS
    )
    log = HEAD.replace("mass (g)", "poids") + newtons
    assert "N for a weight" in str(read_log(log).diagnostics)
    assert is_right(log.replace("poids", "poids [N]"))


def test_cell_that_is_missing_in_a_row_can_be_written_as_the_hint_says() -> None:
    log = HEAD + runs(ROW)
    short = log.replace("40.3;14.8;407", "40.3;407")
    assert "if another cell of the line is missing" in str(read_log(short).diagnostics)


def test_rounding_of_a_position_is_printed_as_it_was_typed() -> None:
    rows = "".join(
        f"{m};10;{s};{t(m, s, arm='15.08')};1\n" for m in MASSES for s in SPINS
    )
    found = analyze(
        "# ball_diameter: 101.6 mm\n# position_from: surface\n" + HEAD + rows
    )
    hints = [one.hint for one in found.diagnostics if one.code == "G407"]
    assert [hint for hint in hints if "such as 10.0" in hint] == hints != []


@pytest.mark.slow
def test_warning_about_a_run_marks_the_cell_that_may_be_wrong() -> None:
    log = HEAD + runs(ROW).replace(
        f"40.3;14.8;407;{t('40.3', 407)}", f"40.3;148;407;{t('40.3', 407)}"
    )
    (found,) = [one for one in analyze(log).diagnostics if one.code == "G410"]
    assert (found.line, found.column) == (6, 6)
    assert [one.code for one in analyze(log).diagnostics if one.code == "G441"] == []


def test_columns_of_one_name_get_the_names_that_the_hint_says() -> None:
    two = HEAD.replace("spin (rpm)", "spin (rpm);spin (rpm)")
    assert "write spin_start [rpm] over" in str(
        read_log(two + runs("{m};14.8;{s};{s};{t};1\n")).diagnostics
    )
    named = two.replace("spin (rpm);spin (rpm)", "spin_start [rpm];spin_end [rpm]")
    assert is_right(named + runs("{m};14.8;{s};{s};{t};1\n"))


def test_headers_of_two_roles_can_be_written_as_the_hint_says() -> None:
    row = "{m};14.8;{s};{t};2\n"
    bare = "m;d;n;T;turns\n" + runs(row, 2)
    with pytest.raises(
        LogError,
        match=r'"T" fits(?s:.*)"precession_period \[s\]"',
    ):
        analyze(bare)
    assert is_right("m [g];d [cm];n [rpm];time [s];turns\n" + runs(row, 2))


@pytest.mark.slow
def test_hints_about_two_readings_and_a_missing_unit_lead_to_the_answer() -> None:
    typed = HEAD + runs("{m};14.8;{s};{t} / {t};1\n")
    assert "has two values" in str(read_log(typed).diagnostics)
    assert is_right(
        HEAD.replace("time (s)", "time 1 (s);time 2 (s)")
        + runs("{m};14.8;{s};{t};{t};1\n")
    )
    hertz = "".join(
        f"{m};14.8;{s};{s / 60:.3f};{t(m, s)};1\n" for m in MASSES for s in SPINS
    )
    header = HEAD.replace("spin (rpm)", "spin before (rpm);spin after")
    assert 'write the header as "spin after [rpm]"' in str(
        read_log(header + hertz).diagnostics
    )
    with pytest.raises(LogError):
        analyze(header + hertz)
    assert is_right(header.replace("spin after", "spin after (Hz)") + hertz)


READ_NOW = {
    "turns in words": "# turns = one\n" + HEAD.replace(";turns", "") + runs(SHORT),
    "a remark that counts": HEAD.replace("\n", ";note\n")
    + runs("{m};14.8;{s};{t};1;1 turn\n"),
    "outside the ball": "# ball_diameter: 101.6 mm\n"
    + HEAD.replace("r (cm)", "length of rod outside the ball (cm)")
    + runs("{m};9.72;{s};{t};1\n"),
    "without the radius": "# ball_diameter: 101.6 mm\n"
    + HEAD.replace("r (cm)", "r without ball radius (cm)")
    + runs("{m};9.72;{s};{t};1\n"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", READ_NOW)
def test_what_students_write_for_times_turns_and_distances_is_read(case: str) -> None:
    assert is_right(READ_NOW[case])
    assert "G229" not in str(read_log(READ_NOW[case]).diagnostics)


def test_all_blank_cells_of_turns_are_named_at_once() -> None:
    full, blank = (
        runs(row).splitlines(keepends=True) for row in (ROW, ROW.replace(";1\n", ";\n"))
    )
    log = HEAD + "".join(blank[i] if i in (0, 1, 4, 6) else full[i] for i in range(9))
    assert "turns is blank in lines 2-3, 6, 8" in str(read_log(log).diagnostics)


def test_doubtful_time_can_be_written_as_the_hint_says() -> None:
    log = HEAD + runs(ROW).replace(f"{t('20.1', 206)};", f"{t('20.1', 206)}?;")
    assert f"write {t('20.1', 206)} if you trust it" in str(read_log(log).diagnostics)


@pytest.mark.slow
def test_weight_in_the_centre_is_not_compared_with_a_torque_of_zero() -> None:
    log = HEAD.replace("turns", "turns;torque [mN m]") + runs(
        "{m};14.8;{s};{t};1;{m}\n"
    ).replace("14.8", "0", 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        analyze(log)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("log", "kind"),
    [
        ("# two reflective strips on the ball\n" + HEAD + runs(ROW), "note"),
        (
            "contamos as voltas em quartos (4 = volta completa)\n"
            + HEAD
            + runs("{m};14.8;{s};{t};1\n"),
            "note",
        ),
        (HEAD + runs(ROW) + "clip itself not included\n", "note"),
        (
            HEAD.replace("r (cm)", "centre to inner face of the weight (cm)")
            + runs(ROW),
            "note",
        ),
        (HEAD.replace("r (cm)", "r (mm)") + runs(ROW), "size"),
    ],
)
def test_answer_that_the_log_contradicts_is_not_safe_to_quote(
    log: str, kind: str
) -> None:
    assert [doubt.kind for doubt in gyrodata.analyze(log).doubts] == [kind]


@pytest.mark.slow
def test_answer_of_a_plain_log_is_safe_to_quote() -> None:
    assert gyrodata.analyze(HEAD + runs(ROW)).doubts == ()


def test_times_of_a_running_stopwatch_are_asked_about() -> None:
    head, row = (
        HEAD.replace("time (s);turns", "lap 1 (s);lap 2 (s);lap 3 (s)"),
        "{m};14.8;{s};{t};{t2};{t3}\n",
    )
    log = head + "".join(
        row.format(m=m, s=s, t=t(m, s), t2=t(m, s, 2), t3=t(m, s, 3))
        for m in MASSES
        for s in SPINS
    )
    assert (
        'keep only the column "lap 3 (s)", and write how many turns it covers'
        in str(read_log(log).diagnostics)
    )
    last = HEAD.replace("time (s);turns", "lap 3 (s)")
    rows = "".join(f"{m};14.8;{s};{t(m, s, 3)}\n" for m in MASSES for s in SPINS)
    assert is_right("# turns: 3\n" + last + rows)


def test_header_with_other_delimiters_than_the_rows_is_asked_about() -> None:
    rows = runs("{m}  14.8  {s}  {t}  1\n")
    header = "mass [g], position [cm], spin [rpm], time [s], turns\n"
    with pytest.raises(GyroError):
        analyze(header + rows)
    assert is_right(header.replace(", ", "  ") + rows)


def test_frames_of_a_video_are_not_times() -> None:
    log = HEAD.replace("time (s)", "first frame;last frame") + runs(
        "{m};14.8;{s};100;{s};1\n"
    )
    assert "time is missing" in str(read_log(log).diagnostics)


@pytest.mark.slow
def test_turns_in_a_title_are_valid_for_all_runs() -> None:
    title = "time of ONE precession turn"
    assert is_right(f"{title}\n{HEAD.replace(';turns', '')}{runs(SHORT)}")


@pytest.mark.slow
def test_turns_in_a_title_with_other_words_are_asked_about() -> None:
    title = "Monday - 1 turn per measurement"
    log = read_log(f"{title}\n{HEAD.replace(';turns', '')}{runs(SHORT)}")
    assert "turns is missing" in str(log.diagnostics)


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        "n_A: Drehzahl am Anfang, n_E: Drehzahl am Ende",
        "n_A = spin at the start, n_E = spin at the end",
        "# n_A: vitesse au début, n_E: vitesse à la fin",
    ],
)
def test_two_spins_with_letters_are_asked_about_and_mapped(line: str) -> None:
    """The mean of both is the spin; the first alone is 10 % too large."""
    rows = "".join(
        f"{m};14.8;{1.1 * s:.1f};{0.9 * s:.1f};{t(m, s)};1\n"
        for m in MASSES
        for s in SPINS
    )
    head = HEAD.replace("spin (rpm)", "n_A [1/min];n_E [1/min]")
    text = f"{line}\n{head}{rows}"
    with pytest.raises(LogError, match="may both be spins") as refused:
        analyze(text)
    hints = " ".join(one.hint for one in refused.value.diagnostics)
    named = dict(re.findall(r'"?(spin_start|spin_end)"?[=:] ?"([^"]+)"', hints))
    assert sorted(named) == ["spin_end", "spin_start"]
    assert analyze(text, mapping=named).inertia.value == pytest.approx(TRUTH, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    "sentence",
    ["ボールの直径 101,6 mm", "D ball = 101,6 mm", "Kugeldurchmesser: 101,6 mm"],
)
def test_diameter_of_the_ball_in_a_line_is_used(sentence: str) -> None:
    head = HEAD.replace("r (cm)", "distance from the surface (cm)")
    assert is_right(f"{sentence}\n\n{head}" + runs("{m};9.72;{s};{t};1\n"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "sentence",
    [
        "діаметр кулі 101,6 мм",
        "διάμετρος σφαίρας 101,6 mm",
        "공 지름 101,6 mm",
        "priemer gule 101,6 mm",
        "diametrul bilei 101,6 mm",
        "קוטר הכדור 101,6 mm",
        "قطر الكرة 101,6 mm",
        "Ø Kugel 101,6 mm",
    ],
)
def test_diameter_of_the_ball_in_a_sentence_is_asked_for(sentence: str) -> None:
    head = HEAD.replace("r (cm)", "distance from the surface (cm)")
    log = f"{sentence}\n\n" + head + runs("{m};9.72;{s};{t};1\n")
    with pytest.raises(LogError, match=r"# ball_diameter: 10\.16 cm"):
        analyze(log)
    assert is_right("# ball_diameter: 10.16 cm\n" + log)
