"""Words of many languages that say that a number is not what it seems: read as meant,
asked about, or a doubt.
"""

from __future__ import annotations

import numpy as np
import pytest
from simulated_labs import analyze_briefly, kinds_of_doubts

import gyrodata
from gyrodata.readings import read_reported

INERTIA, G, RPM = 4.4e-3, 9.80665, np.pi / 30
SURFACE = 5.08  # radius of the ball [cm]


def log(
    top: str,
    *,
    header: str = "",
    first: str = "",
    mass: float = 1.0,
    off: float = 0.0,
    turns: float = 1.0,
) -> str:
    """Write nine runs: a typed mass is the true one times `mass`, a typed position the
    true one minus `off` [cm].
    """
    random = np.random.default_rng(5)
    header = header or "mass (g);position (cm);spin (rpm);" + (
        "turns;time (s)" if turns == 1 else "T (s)"
    )
    lines = [*([top] if top else []), header]
    for true_mass, spin in (
        (m, s) for m in (20.1, 40.3, 60.2) for s in (248.0, 401.0, 552.0)
    ):
        time = (
            2 * np.pi * turns * INERTIA * spin * RPM / (true_mass * 1e-3 * G * 0.148)
            + 0.1 * random.standard_normal()
        )
        count = ["1"] * (turns == 1 and "turns" in header)
        cells = [first] * bool(first) + [
            f"{mass * true_mass:.2f}",
            f"{14.8 - off:.2f}",
            f"{spin:.1f}",
            *count,
        ]
        lines.append(";".join([*cells, f"{time:.2f}"]))
    return "\n".join(lines) + "\n"


PERIODS = (
    "5 periods timed each run",
    "5 périodes mesurées à chaque fois",
    "immer 5 Perioden gemessen",
    "время 5 периодов",
    "tiempo de 5 periodos",
    "misurati 5 periodi ogni volta",
)
PARTS = (
    "d'une vis à la suivante",
    "от винта до винта",
    "de un tornillo al siguiente",
    "T für einen Halbkreis",
    "转过180度的时间",
    "stopped at the opposite wall",
)


@pytest.mark.parametrize(
    ("top", "turns"), [*((one, 5) for one in PERIODS), *((one, 0.5) for one in PARTS)]
)
def test_a_note_of_other_turns_than_one_is_asked_for(top: str, turns: float) -> None:
    with pytest.raises(gyrodata.LogError) as caught:
        analyze_briefly(log(top, turns=turns).encode())
    assert "G207" in {one.code for one in caught.value.diagnostics}


@pytest.mark.slow
@pytest.mark.slow
def test_the_hint_about_a_distance_from_the_ball_works() -> None:
    text = log(
        "",
        header="mass (g);distance from ball (cm);spin (rpm);turns;time (s)",
        off=SURFACE,
    )
    with pytest.raises(gyrodata.LogError) as caught:
        analyze_briefly(text.encode())
    (hint,) = (one.hint for one in caught.value.diagnostics if one.code == "G301")
    assert '"# position_from: surface"' in hint
    text = text.replace("distance from ball (cm)", "position [cm]")
    found = analyze_briefly(
        f"# position_from: surface\n# ball_diameter: 10.16 cm\n{text}".encode()
    )
    assert found.inertia.value == pytest.approx(INERTIA, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    "top",
    [
        "the air comes out of the ball",
        "chronométré 1 tour entre deux repères",
        "两个标记之间的时间",
        "la boule tourne vite",
    ],
)
def test_a_note_about_something_else_changes_nothing(top: str) -> None:
    found = analyze_briefly(f"# ball_diameter: 101.6 mm\n{log(top)}".encode())
    assert (kinds_of_doubts(found), found.inertia.value) == (
        [],
        pytest.approx(INERTIA, rel=0.02),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "top",
    [
        "ball diameter 101.6 mm\nruler zero is where the rod goes into the ball",
        "diamètre de la boule 101,6 mm, distance mesurée à partir de la sortie de la boule",
        "x ab Kugel gemessen, Radius 50,8 mm noch addieren",
        "球直径 101.6 mm\n距离从球面量起",
    ],
)
def test_positions_from_the_surface_are_read_in_other_words(top: str) -> None:
    asked = f"# ball_diameter: 101.6 mm\n{log(top, off=SURFACE)}"
    found = analyze_briefly(asked.encode())
    assert found.inertia.value == pytest.approx(INERTIA, rel=0.02)


@pytest.mark.slow
def test_a_footnote_states_the_origin() -> None:
    text = log(
        "", header="mass (g);position* (cm);spin (rpm);turns;time (s)", off=SURFACE
    )
    found = analyze_briefly(
        f"# ball_diameter: 101.6 mm\n{text}* from the surface of the ball\n".encode()
    )
    assert found.inertia.value == pytest.approx(INERTIA, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    "top",
    [
        "We measured x from the ball, not from its centre.",
        "r = position + R, R = 5.08 cm",
        "position + 5.08 cm = arm",
        "length of rod between ball and weight",
        "distance entre la boule et la masse",
    ],
)
def test_a_doubtful_origin_is_a_doubt(top: str) -> None:
    found = analyze_briefly(log(top, off=SURFACE).encode())
    assert "note" in kinds_of_doubts(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    "top",
    [
        "On a mis deux masses identiques à chaque fois",
        "immer zwei gleiche Gewichte aufgesteckt",
        "dos pesas iguales",
        "два одинаковых груза",
        "the clamp screw weighs another 5.0 g",
        "+ 5 g Haken bei allen",
        "gancho: 5,0 g",
    ],
)
def test_more_weight_than_is_typed_is_a_doubt(top: str) -> None:
    found = analyze_briefly(log(top, mass=0.5).encode())
    assert "note" in kinds_of_doubts(found)


HEADER = "mass (g);position (cm);spin (rpm);turns;time (s)"


@pytest.mark.slow
@pytest.mark.parametrize(
    "column",
    [
        "no. of weights",
        "qty",
        "Anzahl Gewichte",
        "nombre de masses",
        "hook (g)",
        "total with hook (g)",
        "mass B (g)",
    ],
)
def test_an_unused_column_that_may_belong_to_the_mass_is_a_doubt(column: str) -> None:
    found = analyze_briefly(
        log("", header=f"{column};{HEADER}", first="2", mass=0.5).encode()
    )
    (told,) = (one for one in found.diagnostics if one.code == "G240")
    assert (
        f'the column "{column}" is not used, and it may belong to the mass'
        in told.message
    )
    assert "note" in kinds_of_doubts(found)
    # The hint: write all that hangs on the rod in one column.
    head, *rows = log("", mass=0.5).splitlines()
    followed = analyze_briefly(
        "\n".join([head, *(f"2 x {row}" for row in rows)]).encode()
    )
    assert (kinds_of_doubts(followed), followed.inertia.value) == (
        [],
        pytest.approx(INERTIA, rel=0.02),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "cell"), [("no. of weights", "1"), ("ball mass (g)", "4400")]
)
def test_a_column_that_does_not_change_the_mass_is_no_doubt(
    column: str, cell: str
) -> None:
    found = analyze_briefly(log("", header=f"{column};{HEADER}", first=cell).encode())
    assert "note" not in kinds_of_doubts(found)
    assert found.inertia.value == pytest.approx(INERTIA, rel=0.02)


@pytest.mark.slow
def test_a_mass_of_all_weights_beside_their_number_is_no_doubt() -> None:
    head, *rows = log("").splitlines()
    rows = [f"{round(float(row.partition(';')[0]) / 20)};{row}" for row in rows]
    found = analyze_briefly("\n".join([f"number of weights;{head}", *rows]).encode())
    assert "note" not in kinds_of_doubts(found)
    assert found.inertia.value == pytest.approx(INERTIA, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    "top",
    [
        "inkl. Haken 5 g",
        "crochet 5 g compris",
        "1 period timed",
        "x from the ball centre",
    ],
)
def test_a_note_that_changes_nothing_is_no_doubt(top: str) -> None:
    found = analyze_briefly(log(top).encode())
    assert (kinds_of_doubts(found), found.inertia.value) == (
        [],
        pytest.approx(INERTIA, rel=0.02),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("top", "column"),
    [
        ("masse d'un écrou : 8,35 g", "nombre d'écrous"),
        ("masa de una tuerca: 8,35 g", "tuercas"),
    ],
)
def test_a_number_of_nuts_is_asked_about(top: str, column: str) -> None:
    """The counts times the mass of one, as the hint says, give the answer."""
    lines = [top, f"{column};position (cm);spin (rpm);turns;time (s)"]
    for count, spin in ((n, s) for n in (3, 5, 7) for s in (248, 401, 552)):
        torque = count * 8.35e-3 * G * 0.148
        time = 2 * np.pi * INERTIA * spin * RPM / torque
        lines.append(f"{count};14.8;{spin};1;{time:.2f}")
    with pytest.raises(gyrodata.LogError, match="mass is missing"):
        analyze_briefly("\n".join(lines).encode())
    rows = [line.replace(";", " x 8.35;", 1) for line in lines[2:]]
    corrected = [lines[1].replace(column, "mass [g]"), *rows]
    inertia = analyze_briefly("\n".join(corrected).encode()).inertia
    assert inertia.value == pytest.approx(INERTIA, rel=0.02)


@pytest.mark.parametrize(
    "text",
    [
        r"(4.40 \pm 0.04)\times10^{-3} kg m^2",
        r"$(4.40 \pm 0.04)\times 10^{-3}$ kg m^2",
        r"4.40 \cdot 10^{-3} \pm 0.04 \cdot 10^{-3} kg\,m^{2}",
    ],
)
def test_an_answer_in_latex_is_read(text: str) -> None:
    read = read_reported("inertia", text)
    assert (read.value, read.u) == (pytest.approx(4.4e-3), pytest.approx(4e-5))


@pytest.mark.parametrize("text", ["4.40 mkg m²", "4.40 milli kg m^2", "4.40 foo"])
def test_an_answer_with_an_unknown_unit_has_no_value(text: str) -> None:
    assert (
        read_reported("inertia", text).fault,
        read_reported("inertia", text).value,
    ) == ("unreadable", None)


@pytest.mark.parametrize(
    ("header", "turns"),
    [
        ("t_1/3 (s)", 1 / 3),
        ("t1/3 [s]", 1 / 3),
        ("T_{1/3} (s)", 1 / 3),
        ("t_(2/3) [s]", 2 / 3),
        ("τ_3/4 (s)", 3 / 4),
    ],
)
def test_a_fraction_behind_the_symbol_of_a_time_is_its_turns(
    header: str, turns: float
) -> None:
    header = f"mass (g);position (cm);spin (rpm);{header}"
    text = log("", header=header, turns=turns)
    found = analyze_briefly(text.encode())
    assert found.inertia.value == pytest.approx(INERTIA, rel=0.05)


@pytest.mark.parametrize("header", ["t_3/3 (s)", "time 1/3 (s)"])
def test_a_fraction_that_may_number_a_reading_is_asked_for(header: str) -> None:
    header = f"mass (g);position (cm);spin (rpm);{header}"
    with pytest.raises(gyrodata.LogError):
        analyze_briefly(log("", header=header, turns=1 / 3).encode())


@pytest.mark.parametrize(
    "note",
    [
        "# r is really the diameter",
        "# note: r ist eigentlich der Durchmesser!",
        "# r: diamètre en réalité",
        "# we noticed later that the column r is the diameter of the circle",
    ],
)
def test_a_note_that_calls_the_position_a_diameter_is_a_doubt(note: str) -> None:
    header = "mass (g);r (cm);spin (rpm);turns;time (s)"
    with pytest.warns(gyrodata.GyroWarning, match="diam|Durchmesser"):
        found = gyrodata.analyze(log(note, header=header).encode())
    assert "G240" in {one.code for one in found.diagnostics}


def test_the_diameter_of_the_ball_or_of_the_rod_is_no_doubt() -> None:
    header = "mass (g);r (cm);spin (rpm);turns;time (s)"
    note = "# ball diameter 101.6 mm, diameter of the rod 6 mm, r from the centre"
    found = analyze_briefly(log(note, header=header).encode())
    assert "G240" not in {one.code for one in found.diagnostics}
