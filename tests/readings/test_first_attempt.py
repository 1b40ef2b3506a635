"""Logs in the forms that students write: each gives the right answer as it is, without
an option.
"""

from __future__ import annotations

import datetime
import io
import math
from collections.abc import Sequence

import pytest
from simulated_labs import analyze_briefly as analyze

from gyrodata import GyroError, LogError

TRUTH, ARM = 4.4e-3, "14.8"
G_LINE = "# g: 9.80665 m/s^2\n"
TURN = 2 * math.pi * TRUTH * math.pi / 30 / (1e-3 * 9.80665 * 0.148)
"""Time of one turn [s] with 1 g at 1 rpm."""
ROWS = [
    [mass, ARM, spin, f"{TURN * float(spin) / float(mass):.2f}", "1"]
    for mass in ("20.1", "40.3", "60.2")
    for spin in ("206", "407", "598")
]
HEAD = ["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"]


def table(
    sign: str = ",",
    rows: Sequence[Sequence[str]] = ROWS,
    head: Sequence[str] = HEAD,
    frame: str = "{}\n",
) -> str:
    return "".join(frame.format(sign.join(row)) for row in (head, *rows))


def is_right(text: str | bytes) -> bool:
    return abs(analyze(text).inertia.value / TRUTH - 1) < 0.02


HEADERS = (
    "massa (g);distanza dal centro (cm);velocità di rotazione (giri/min);tempo (s);giri",
    "Massa [g];Braccio [cm];numero di giri [giri/min];tempo di un giro [s];prova",
    "Massa (g);distância ao centro (cm);velocidade de rotação (rpm);tempo (s);voltas",
    "Kütle (g);Merkezden uzaklık (cm);Dönme hızı (dev/dk);Süre (s);Tur sayısı",
    "massa (g);afstand tot midden (cm);toerental (omw/min);tijd (s);omwentelingen",
    "massa (g);avstånd från centrum (cm);varvtal (varv/min);tid (s);varv",
    "massa (g);avstånd (cm);varvtal (varv/min);Tid för ett varv (s);försök",
    "massa (g);etäisyys keskipisteestä (cm);pyörimisnopeus (kierrosta/min);aika (s);kierrokset",
    "hmotnost (g);vzdálenost od středu (cm);otáčky (ot/min);čas (s);počet otáček",
    "μάζα (g);απόσταση από το κέντρο (cm);ταχύτητα περιστροφής (στροφές/λεπτό);χρόνος (s);στροφές",
    "tömeg (g);távolság a középponttól (cm);fordulatszám (1/perc);idő (s);fordulatok",
    "おもりの質量 (g);中心からの距離 (cm);回転数 (rpm);時間 (s);回数",
    "质量 (g);到球心的距离 (cm);转速 (转/分);时间 (秒);圈数",
    "추의 질량 (g);중심에서의 거리 (cm);회전수 (rpm);시간 (초);횟수",
    "masa [g];odległość od środka [cm];obroty [obr/min];czas jednego obrotu [s];lp",
    "Masse (g);Abstand x vom Mittelpunkt in cm;Drehzahl (U/min);Zeit (s);Umdrehungen",
    "Masse [g];Position ab Kugelmitte [cm];Drehzahl [1/min];Zeit [s];Umläufe",
    "масса (г);расстояние до центра (см);частота вращения (об/мин);время (с);число оборотов",
    "m (g);x from centre (cm);f (R.P.M.);time (s);turns",
    "m (g);Dist. of load from centre (cms);spin (rpm);time (s);turns",
    "mass_g;dist_center_cm;spin_rpm;time_s;turns",
    "m_g;arm_cm;spin_rpm;period_s;nr",
    "m (g);Position (from center) cm;spin (rpm);time (s);turns",
    "m (g);x (cm);rpm;t (s);turns",
    "m (g);x (cm);rpm;time of one precession turn [s];trial",
    "m (g);x (cm);rpm;time per revolution (s);trial",
    "A (gram);B (cm);C (rpm);D (sec);turns",
    "m (g);d (cm) from centre of sphere;rpm;Stopwatch [s] (1 rev);trial",
    "m/g;l/cm (Mitte);n/(U/min);t(1 Umdr.)/s;Nr",
    "m (g);Dist from ctr [cm];how fast it spins [rpm];period s;nr",
)


@pytest.mark.slow
@pytest.mark.parametrize("header", HEADERS)
def test_headers_in_many_languages_and_styles(header: str) -> None:
    assert is_right(G_LINE + table(";", head=header.split(";")))


TEX = (
    "$m$ [\\si{\\gram}]",
    "$x$ [\\si{\\centi\\metre}]",
    "$f$ [rpm]",
    "$t$ [s]",
    "$N$",
)
WIDE = ("m [g]   ", "x [cm]  ", "f [rpm] ", "t [s]   ", "turns")
CLOCK = [
    [
        *row[:3],
        "12:01:10",
        f"12:{1 + (10 + float(row[3])) // 60:02.0f}:{(10 + float(row[3])) % 60:05.2f}",
        "1",
    ]
    for row in ROWS
]
DISK = [
    [
        *row[:2],
        "10",
        f"{597 / float(row[2]):.2f}",
        f"{603 / float(row[2]):.2f}",
        *row[3:],
    ]
    for row in ROWS
]
COLUMNS = list(zip(*ROWS, strict=True))
THIRDS = [[*row[:3], f"{float(row[3]) / 3:.2f}", "1/3"] for row in ROWS]
WITHOUT_ARM = [[row[0], *row[2:4]] for row in ROWS]
TITLED = "".join(
    f"m = {mass} g\n"
    + table(rows=[row[2:4] for row in ROWS if row[0] == mass], head=HEAD[2:4])
    + "\n"
    for mass in ("20.1", "40.3", "60.2")
)
PAIRS = [[*row[:2], f"{int(row[2]) + 6} - {int(row[2]) - 6}", *row[3:]] for row in ROWS]

FORMS = {
    "Markdown": table(" | ", [["---"] * 5, *ROWS], frame="| {} |\n"),
    "pipes": table("|"),
    "a frame of signs": "+-----+-----+\n"
    + table(" | ", frame="| {} |\n")
    + "+-----+-----+\n",
    "aligned by blanks": table("   ", head=WIDE),
    "one blank": table(" ", head=["m[g]", "x[cm]", "f[rpm]", "t[s]", "N"]),
    "constants above": "g = 9.80665\nBall diameter: 101.6 mm\n" + table(),
    "constants in cells": "g;9.80665;m/s^2\nBall mass;4.26 kg\n" + table(";"),
    "a key without its colon": "# latitude 45.3 deg\n" + table(),
    "minutes and seconds": table(
        rows=[
            [*row[:3], f"{float(row[3]) // 60:.0f} min {float(row[3]) % 60:.2f} s", "1"]
            for row in ROWS
        ]
    ),
    "a blank between thousands": table(
        rows=[
            [*row[:3], "1 " + f"{float(row[3]) * 1e3 - 1000:.0f}"[-3:], "1"]
            if 1 <= float(row[3]) < 2
            else row
            for row in ROWS
        ]
    ),
    "not measured": table(rows=[*ROWS, ["20.1", ARM, "300", "n/a", "1"]]),
    "weights in N": table(
        rows=[[f"{float(row[0]) * 9.80665e-3:.5f}", *row[1:]] for row in ROWS],
        head=["Weight (N)", *HEAD[1:]],
    ),
    "ten turns": table(
        rows=[[*row[:3], f"{10 * float(row[3]):.2f}"] for row in ROWS],
        head=[*HEAD[:3], "10T (s)"],
    ),
    "a third in words": table(
        rows=[[*row[:3], f"{float(row[3]) / 3:.2f}", "Drittel"] for row in ROWS]
    ),
    "spin at start and end": table(rows=PAIRS),
    "start and stop of a clock": table(
        rows=CLOCK, head=[*HEAD[:3], "start", "stop", "turns"]
    ),
    "ten turns of the disk": table(
        rows=DISK,
        head=[
            *HEAD[:2],
            "spin_turns",
            "spin_time_start [s]",
            "spin_time_end [s]",
            *HEAD[3:],
        ],
    ),
    "LaTeX": "\\begin{tabular}{lllll}\n"
    + table(" & ", head=TEX, frame="{} \\\\ \\hline\n")
    + "\\end{tabular}\n",
    "LaTeX with {,}": table(
        " & ",
        [[cell.replace(".", "{,}") for cell in row] for row in ROWS],
        frame="${}$ \\\\\n",
    ),
    "turned": "".join(
        ",".join([name, *cells]) + "\n"
        for name, cells in zip(HEAD, COLUMNS, strict=True)
    ),
    "turned, with one position": "".join(
        ",".join([name, *(cells if name != "position [cm]" else [ARM])]) + "\n"
        for name, cells in zip(HEAD, COLUMNS, strict=True)
    ),
    "fractions below an unknown name": table(rows=THIRDS, head=[*HEAD[:4], "how far"]),
    "a word for turns in an unknown name": table(head=[*HEAD[:4], "nb de tours faits"]),
    "angles below an unknown name": table(
        rows=[[*row[:4], "120"] for row in THIRDS], head=[*HEAD[:4], "Bogen (°)"]
    ),
    "what holds for all tables above the first": f"x = {ARM} cm\none turn\n" + TITLED,
    "± beside each column": table(
        rows=[[a, "0.1", b, "0.1", c, "2", d, "0.2", "1"] for a, b, c, d, _ in ROWS],
        head=[HEAD[0], "±", HEAD[1], "±", HEAD[2], "±", HEAD[3], "±", "turns"],
    ),
    "snake case": table(
        rows=[
            [*row[:2], f"{float(row[2]) * math.pi / 30:.4f}", *row[3:]] for row in ROWS
        ],
        head=["mass_g", "x_cm", "omega_rad_s", "t_s", "turns"],
    ),
    "letters for weights": "A = 20.1 g\nB = 40.3 g, C = 60.2 g\n"
    + table(";", [["ABC"[at // 3], *row[1:]] for at, row in enumerate(ROWS)]),
    "turns in the second row": "mass,spin,time (s),,\n(g),(rpm),1/3 turn,2/3 turn,1 turn\n"
    + table(
        rows=[
            [*row[::2][:2], *(f"{float(row[3]) * k / 3:.2f}" for k in (1, 2, 3))]
            for row in ROWS[1:]
        ],
        head=[
            *ROWS[0][::2][:2],
            *(f"{float(ROWS[0][3]) * k / 3:.2f}" for k in (1, 2, 3)),
        ],
    )
    + f"x = {ARM} cm\n",
    "two parts": f"Weight 1: r = {ARM} cm\n"
    + table(rows=WITHOUT_ARM[:3], head=[HEAD[0], HEAD[2], "Time for 1 turn (s)"])
    + f"\nWeight 2: 60.2 g, r = {ARM} cm\n"
    + table(
        rows=[one[1:] for one in WITHOUT_ARM[6:]], head=[HEAD[2], "Time for 1 turn (s)"]
    ),
    "other turns in each table": f"x = {ARM} cm\n"
    + "\n".join(
        table(
            rows=[
                [*one[:2], f"{float(one[2]) * k / 3:.2f}"]
                for one in WITHOUT_ARM[3 * k - 3 : 3 * k]
            ],
            head=[HEAD[0], HEAD[2], f"time for {k}/3 turn (s)"],
        )
        for k in (1, 2)
    ),
    "two partners": table(
        rows=[[*row[:4], row[3]] for row in ROWS],
        head=[*HEAD[:3], "Ana's time (s)", "Bo's time (s)"],
    )
    + "all times are for one full revolution\n",
    "one header with the turns": table(
        rows=[[*row[:4], row[3]] for row in ROWS],
        head=[*HEAD[:3], "temps pour un tour t1 [s]", "t2 [s]"],
    ),
    "the turns as numbers": table(
        rows=[
            [*row[:3], *(f"{float(row[3]) * k / 3:.2f}" for k in (1, 2, 3))]
            for row in ROWS
        ],
        head=[*HEAD[:3], "T1/3 (s)", "T2/3 (s)", "T1 (s)"],
    ),
    "minutes in the unit": table(
        rows=[
            [*row[:3], f"{float(row[3]) // 60:.0f}:{float(row[3]) % 60:04.1f}"]
            for row in ROWS
        ],
        head=[*HEAD[:3], "Time for 1 turn (m:ss.s)"],
    ),
    "ten turns of the disk in the header": table(
        rows=[
            [
                *row[:2],
                f"{597 / float(row[2]):.3f}",
                row[3],
                f"{603 / float(row[2]):.3f}",
            ]
            for row in ROWS
        ],
        head=[
            *HEAD[:2],
            "Time for 10 rotations of disk before (s)",
            "Time for 1 precession (s)",
            "Time for 10 rotations of disk after (s)",
        ],
    ),
    "units beside the names": "".join(
        ",".join(
            [name.partition(" ")[0], name.partition("[")[2].rstrip("]") or "-", *cells]
        )
        + "\n"
        for name, cells in zip(HEAD, COLUMNS, strict=True)
    ),
    "quotes of a word processor": table(
        rows=[[f"“{cell}”" for cell in row] for row in ROWS]
    ),
    "ditto marks between tabs": table(
        "\t",
        rows=[
            [row[0] if at % 3 == 0 else '"', '"' if at else row[1], *row[2:]]
            for at, row in enumerate(ROWS)
        ],
    ),
    "a legend in quotes": table(
        rows=[["ABC"[at // 3], *row[1:]] for at, row in enumerate(ROWS)]
    )
    + '"A = 20.1 g, B = 40.3 g, C = 60.2 g"\n',
    "a result below the table": table(
        rows=[[*row, "", "4.4e-3"] for row in ROWS], head=[*HEAD, "ω", "I (kg m²)"]
    )
    + "2/5 m r²,,,,,,4.48e-3\n% error,,,,,,0.9%\n",
    "footnotes": table(
        rows=[[*row[:3], f"{row[3]}*", row[4]] for row in ROWS],
        head=["mass¹ (g)", *HEAD[1:]],
    )
    + "¹ kitchen scale\n* by phone\n",
    "the time of the day": table(
        "\t",
        rows=[["14:05", *row] for row in ROWS],
        head=["Time", *HEAD[:3], "Duration [s]", "Turns"],
    ),
    "other words for the ball": table(
        head=[*HEAD[:2], "RPM ball", "secs", "# rotations"]
    ),
    "quotes for seconds": table(
        rows=[
            [*row[:3], "0'" + row[3].replace(".", '"').zfill(5), row[4]] for row in ROWS
        ],
        head=[*HEAD[:3], "time", "turns"],
    ).replace('""', '"'),
    "unknown units below the names": "mass,position,spin,T,Ωω\n"
    + table(
        rows=[[*row[:4], "31"] for row in ROWS], head=["g", "cm", "rpm", "s", "rad²/s²"]
    ),
    "blank below a merged cell": "m [g]     x [cm]    f [rpm]   t [s]     turns\n"
    + "".join(
        f"{row[0] * (at % 3 == 0):10}{row[1] * (at % 3 == 0):10}{row[2]:10}{row[3]:10}{row[4]}\n"
        for at, row in enumerate(ROWS)
    ),
    "a letter for a place": f"# hole K: {ARM} cm\n"
    + table(rows=[[row[0], "K", *row[2:]] for row in ROWS]),
}


ASKED = {
    "turned": "G201",
    "turned, with one position": "G201",
    "units beside the names": "G201",
    "spin at start and end": "G203",
    "ten turns of the disk": "G301",
    "LaTeX": "G104",
    "LaTeX with {,}": "G104",
    "letters for weights": "G203",
    "turns in the second row": "G209",
    "two partners": "G301",
    "one header with the turns": "G302",
    "the turns as numbers": "G302",
    "ten turns of the disk in the header": "G301",
    "quotes of a word processor": "G202",
    "ditto marks between tabs": "G203",
    "a legend in quotes": "G203",
    "a result below the table": "G205",
    "footnotes": "G205",
    "unknown units below the names": "G207",
    "a letter for a place": "G203",
    "± beside each column": "G210",
    "start and stop of a clock": "G301",
    "two parts": "G212",
    "other turns in each table": "G212",
}
"""Rare forms that are asked about, with the code of the first question."""


@pytest.mark.slow
@pytest.mark.parametrize("form", [form for form in FORMS if form not in ASKED])
def test_forms_of_tables_and_cells(form: str) -> None:
    assert is_right(FORMS[form])


@pytest.mark.slow
@pytest.mark.parametrize("form", ASKED)
def test_rare_forms_are_asked_about(form: str) -> None:
    with pytest.raises(GyroError) as refused:
        analyze(FORMS[form])
    errors = [one for one in refused.value.diagnostics if one.severity == "error"]
    assert errors[0].code == ASKED[form]
    assert errors[0].hint


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["cp932", "gb18030", "cp949"])
def test_what_excel_saves_in_japan_china_and_korea(encoding: str) -> None:
    header = next(
        one
        for one in HEADERS
        if one.startswith({"cp932": "お", "gb18030": "质", "cp949": "추"}[encoding])
    )
    assert is_right(table(";", head=header.split(";")).encode(encoding))


WITHOUT = {
    "turns": table(rows=[row[:4] for row in ROWS], head=HEAD[:4]),
    "position": table(
        rows=[[row[0], *row[2:]] for row in ROWS], head=[HEAD[0], *HEAD[2:]]
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "missing"),
    [
        ("Three marks on the circle, 120 deg apart", "turns"),
        ("rod horizontal (90 deg to the axis)", "turns"),
        ("1 turn = 360 deg", "turns"),
        ("one screw every third of a turn", "turns"),
        ("counterweight moved by 1/2 turn", "turns"),
        ("Ventil eine halbe Umdrehung geöffnet", "turns"),
        ("times at 1/3, 2/3 or 1 turn", "turns"),
        ("Time of 1 turn = t/3", "turns"),
        ("stopwatch: 3 trials of one turn, added together", "turns"),
        ("We waited for the rod to turn", "turns"),
        ("Runs 1-4: a quarter turn. Runs 5-9: a full turn.", "turns"),
        ("Kugelradius r = 5.08 cm", "position"),
        ("R = 5.08 cm (ball)", "position"),
        ("a tape mark 5.0 cm wide", "position"),
        ("The weight is 2.0 cm long.", "position"),
        ("Position 15,5 cm", "position"),
    ],
)
def test_a_remark_about_something_else_gives_no_turns_and_no_position(
    line: str, missing: str
) -> None:
    elsewhere = (
        (f"# {line}\n{WITHOUT[missing]}", f"{WITHOUT[missing]}{line}\n")
        if missing == "turns"
        else ()
    )
    for text in (f"{line}\n{WITHOUT[missing]}", *elsewhere):
        with pytest.raises(LogError, match=f"{missing} is missing"):
            analyze(text)


@pytest.mark.slow
@pytest.mark.parametrize(
    "log",
    [
        f"# each time is for one full turn\n{WITHOUT['turns']}",
        f"Zeiten für eine Umdrehung\n{WITHOUT['turns']}",
        table().translate(str.maketrans("0123456789", "٠١٢٣٤٥٦٧٨٩")),
        table(
            rows=[[*row[:4], "2pi"] for row in ROWS], head=[*HEAD[:4], "angle [rad]"]
        ),
        table(
            ";",
            head=[
                "Ağırlık (g)",
                "Merkezden uzaklık (cm)",
                "Hız (dev/dk)",
                "Süre (s)",
                "Tur sayısı",
            ],
        ).encode("cp1254"),
    ],
)
def test_statements_scripts_and_sentences_are_read(log: str | bytes) -> None:
    text = G_LINE + log if isinstance(log, str) else G_LINE.encode() + log
    assert is_right(text)


@pytest.mark.parametrize(
    ("header", "code"),
    [
        ("T/2 (s)", "G301"),
        ("ball diameter (cm)", "G301"),
        ("ruler (cm)", "G340"),
        ("position from the end (cm)", "G340"),
    ],
)
def test_a_header_that_may_mean_something_else_is_asked_about(
    header: str, code: str
) -> None:
    at = 1 if "cm" in header else 3 if "(s)" in header else 4
    with pytest.raises(LogError, match=code):
        analyze(
            table(
                rows=[[*row[:4], "3"] for row in ROWS],
                head=[*HEAD[:at], header, *HEAD[at + 1 :]],
            )
        )


@pytest.mark.parametrize(
    "log",
    [
        table(head=["mass of one weight (g)", *HEAD[1:]]),
        table(head=[*HEAD[:3], "T (s)", "run"])
        + "T is the time from one mark to the next; there are three marks\n",
        table(head=["mass without hanger", *HEAD[1:]]) + "the hanger weighs 5.2 g\n",
        table(rows=[["20·3", *row[1:]] for row in ROWS]),
        "turns: 5\n"
        + table(rows=[row[:4] for row in ROWS], head=[*HEAD[:3], "period (s)"]),
        "Zeiten für 5 Umläufe\n"
        + table(rows=[row[:4] for row in ROWS], head=[*HEAD[:3], "T (s)"]),
    ],
)
def test_what_is_said_beside_the_numbers_is_asked_about(log: str) -> None:
    with pytest.raises(LogError):
        analyze(log)


@pytest.mark.parametrize(
    "header",
    ["θ (deg)", "inclination angle (deg)", "angle of rod (deg)", "zur Vertikalen (°)"],
)
def test_angle_of_a_level_rod_is_not_the_swept_angle(header: str) -> None:
    with pytest.raises(LogError, match="turns is missing"):
        analyze(
            table(rows=[[*row[:4], "90"] for row in ROWS], head=[*HEAD[:4], header])
        )


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        "x is measured from the surface of the ball",
        "distances measured from the edge of the ball",
        "x = Abstand ab Kugelrand",
        "position depuis la superficie de la boule",
        "the zero of the ruler was at the ball",
        "x = length of rod sticking out to the weight",
    ],
)
@pytest.mark.parametrize("frame", ["{0}\n{1}", "# {0}\n{1}", "{1}{0}\n"])
def test_note_that_positions_count_from_the_surface_is_followed(
    line: str, frame: str
) -> None:
    log = frame.format(
        line, G_LINE + table(rows=[[row[0], "9.72", *row[2:]] for row in ROWS])
    )
    with pytest.raises(LogError, match="positions count from the surface"):
        analyze(log)
    assert is_right(f"# ball_diameter: 10.16 cm\n{log}")
    assert (
        abs(
            analyze(f"# position_from: centre\n{log}").inertia.value / TRUTH
            - 9.72 / 14.8
        )
        < 0.02
    )


def test_minutes_and_seconds_of_excel_are_not_hours_and_minutes() -> None:
    from openpyxl import Workbook

    book, data = Workbook(), io.BytesIO()
    book.active.append([*HEAD[:3], "time (min:sec)", "turns"])
    for mass, arm, spin, time, _ in ROWS:
        book.active.append(
            [
                *map(float, (mass, arm, spin)),
                datetime.time(*divmod(round(3 * float(time)), 60)),
                3,
            ]
        )
    book.save(data)
    assert abs(analyze(data.getvalue()).inertia.value / TRUTH - 1) < 0.02


@pytest.mark.parametrize(
    "legend",
    ["A = 20.1 g + 5 g", "A = 20.1 g without the hanger", "A = 20.1 g\nA = 25.1 g"],
)
def test_legend_that_says_more_than_one_quantity_is_asked_about(legend: str) -> None:
    with pytest.raises(LogError, match="name of a weight"):
        analyze(
            f"# {legend.replace(chr(10), chr(10) + '# ')}\n"
            + table(rows=[["A", *row[1:]] for row in ROWS[:3]])
        )


@pytest.mark.parametrize(
    ("head", "row", "said"),
    [
        # The time is there already, so that nobody needs to know what "T" is.
        (
            "mass [g],position [cm],spin [rpm],time [s],turns,ω [rad/s]",
            "40.3,14.8,407,9.2,1,42.6",
            "is only compared",
        ),
        (
            "mass [g],position [cm],spin [rpm],T [s]",
            "40.3,14.8,407,9.2",
            "fits time and precession_period",
        ),
        (
            "mass [g],position [cm],T [s],frequency [Hz]",
            "40.3,14.8,9.2,6.78",
            "fits time and precession_period",
        ),
        (
            "mass [g],position [cm],spin [rpm],T [s],turns",
            "40.3,14.8,407,9.2,1/3",
            "fits time and precession_period",
        ),
    ],
)
def test_header_of_two_meanings_is_decided_by_what_else_is_there(
    head: str, row: str, said: str
) -> None:
    log = f"{G_LINE}{head}\n{row}\n"
    try:
        found = analyze(log).diagnostics
    except LogError as error:
        found = error.diagnostics
    assert any(said in one.message for one in found), found
