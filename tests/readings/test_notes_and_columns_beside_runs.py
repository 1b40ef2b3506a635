"""Columns of uncertainties, data of the ball, and sentences about turns or units."""

from __future__ import annotations

import pytest
from simulated_labs import analyze_briefly
from typed_labs import FOUR, START, is_true, log, questions

from gyrodata import read_log
from gyrodata.base.errors import Diagnostic

PLAIN = log(f"{START},turns", f"{FOUR},{{turns}}")
WITHOUT_TURNS = log(START, "{mass},14.8,{spin},{period:.2f}")


def diagnostics(text: str, code: str) -> list[Diagnostic]:
    return [each for each in read_log(text.encode()).diagnostics if each.code == code]


# --- Columns of uncertainties ---

WITH_U = "{mass},0.2,14.8,0.3,{spin},9,{time:.2f},0.5,{turns}"
U = {"mass": 0.2e-3, "position": 0.3e-2, "spin": 9 * 0.10471975511965977, "time": 0.5}
HEADERS_OF_U = [
    "m (g),Δm (g),x (cm),Δx (cm),n (rpm),Δn (rpm),t (s),Δt (s),turns",
    "m [g],δm [g],x [cm],δx [cm],n [rpm],δn [rpm],t [s],δt [s],turns",
    "m (g),σm (g),x (cm),σx (cm),n (rpm),σn (rpm),t (s),σt (s),turns",
    "m (g),dm (g),x (cm),dx (cm),n (rpm),dn (rpm),t (s),dt (s),turns",
    "m (g),Δm,x (cm),Δx,n (rpm),Δn,t (s),Δt,turns",
    "mass (g),Δmass (g),position (cm),Δposition (cm),spin (rpm),Δspin (rpm),time (s),"
    "Δtime (s),turns",
    "mass (g),± (g),position (cm),± (cm),spin (rpm),± (rpm),time (s),± (s),turns",
    "mass (g),+/- g,position (cm),+/- cm,spin (rpm),+/- rpm,time (s),+/- s,turns",
    "mass (g),uncertainty (g),position (cm),uncertainty (cm),spin (rpm),"
    "uncertainty (rpm),time (s),uncertainty (s),turns",
    "Masse (g),Fehler (g),Abstand (cm),Fehler (cm),Drehzahl (1/min),Fehler (1/min),"
    "Zeit (s),Fehler (s),Umdrehungen",
    "masse (g),incertitude (g),position (cm),incertitude (cm),rotation (tr/min),"
    "incertitude (tr/min),temps (s),incertitude (s),tours",
    "m (g),u_m,x (cm),u_x,n (rpm),u_n,t (s),u_t,turns",
    "m (g),error m,x (cm),error x,N (rpm),error N,t (s),error t,turns",
]


@pytest.mark.parametrize("head", HEADERS_OF_U)
def test_a_column_of_uncertainties_is_used(head: str) -> None:
    read = read_log(log(head, WITH_U).encode())
    assert read.ok
    assert {each.code for each in read.diagnostics}.isdisjoint({"G221", "G240"})
    for role, u in U.items():
        reading = read.columns[role].readings[0].u
        assert reading is not None
        assert reading.absolute == pytest.approx(u, rel=1e-6), role


def test_a_lonely_delta_t_is_asked_about() -> None:
    head = "mass (g),position (cm),spin (rpm),Δt (s),turns"
    (question,) = questions(log(head, f"{FOUR},{{turns}}"))
    assert 'if "Δt (s)" is the stopwatch time of each run' in question.hint


def test_a_symbol_that_may_be_of_two_readings_is_asked_about() -> None:
    text = log("m (g),x (cm),spin (rpm),u_n,t (s),turns", f"{FOUR},{{turns}}")
    text = text.replace(",14.8,", ",14.8,2,", 0)
    row = "{mass},14.8,{spin},9,{time:.2f},{turns}"
    text = log("m (g),x (cm),spin (rpm),u_n,t (s),turns", row)
    (question,) = questions(text)
    assert "u_turns and u_spin" in question.message
    assert is_true(text.replace("u_n", "u_spin [rpm]"))


@pytest.mark.parametrize(
    ("head", "row"),
    [
        # An error of the result, and an error in percent, are not of the time.
        (f"{START},turns,I (kg m^2),error (%)", f"{FOUR},{{turns}},4.4e-3,2"),
        (f"{START},turns,error", f"{FOUR},{{turns}},none"),
    ],
)
def test_another_error_is_no_uncertainty_of_the_column_before(
    head: str, row: str
) -> None:
    read = read_log(log(head, row).encode())
    assert all(column.readings[0].u is None for column in read.columns.values())


# --- Turns in a sentence ---


@pytest.mark.parametrize(
    ("sentence", "turns"),
    [
        ("# stopped after a third of a turn", "1/3"),
        ("Chronométrage sur un tiers de tour.", "1/3"),
        ("Gemessen: Dauer von 2/3 Umlauf", "2/3"),
        ("# Se mide el tiempo de una vuelta completa de precesión", "1"),
        ("Deux tiers de tour chronométrés trois fois", "2/3"),
        ("Precesszió: harmad fordulat ideje", "1/3"),
    ],
)
def test_turns_in_a_sentence_are_quoted_and_proposed(
    sentence: str, turns: str
) -> None:
    text = f"{sentence}\n{WITHOUT_TURNS}"
    (question,) = questions(text)
    assert f'the log says "{sentence.strip("# ")}"' in question.message
    assert f'"# turns: {turns}"' in question.hint
    assert f"--set turns={turns}" in question.hint
    assert read_log(f"# turns: {turns}\n{text}".encode()).ok


def test_several_numbers_of_turns_are_not_proposed_for_all_runs() -> None:
    note = "# runs 1-6: 1/3 turn, runs 7-9: 2/3 turn"
    (question,) = questions(f"{note}\n{WITHOUT_TURNS}")
    assert "2/3 turn" in question.message
    assert "# turns:" not in question.hint
    assert "add a column turns" in question.hint


def test_turns_of_the_ball_are_not_proposed() -> None:
    note = "# each reading of the spin is for 10 turns of the ball"
    (question,) = questions(f"{note}\n{WITHOUT_TURNS}")
    assert "10" not in question.hint.replace("10.16", "").split("(1/3")[0]


@pytest.mark.parametrize(
    "line",
    [
        "Turns per run:,1",
        "# Turns per run: 1",
        "Precession angle,1 turn",
        "Angle of precession: 360°",
        "Umdrehungen pro Messung: 1",
        "Tours par mesure : 1",
    ],
)
def test_a_line_that_names_the_turns_of_each_run_is_used(line: str) -> None:
    assert is_true(f"{line}\n{WITHOUT_TURNS}")


@pytest.mark.parametrize("line", ["Rod angle: 90°", "Angle of the rod 90°"])
def test_the_angle_of_the_rod_is_not_turned(line: str) -> None:
    (question,) = questions(f"{line}\n{WITHOUT_TURNS}")
    assert "turns is missing" in question.message


# --- Data of the ball ---

BALL = [
    "# ball mass 4.3 kg, ball diameter 99 mm",
    "# ball_mass: 4.3 kg, ball_diameter: 99 mm",
    "# ball mass: 4.3 kg; ball diameter: 99 mm",
    "# ball: m = 4.3 kg, d = 99 mm",
    "# Ball (mass 4.3 kg, diameter 99 mm)",
    "# ball mass 4.3 kg\n# ball diameter 99 mm",
    "ball mass 4.3 kg, ball diameter 99 mm",
    "Ball mass: 4.3 kg, diameter: 99 mm",
    "ball mass 4.3 kg and diameter 99 mm",
    "# Masse der Kugel 4.3 kg und Kugeldurchmesser 99 mm",
    "# masse de la boule 4.3 kg, diamètre de la boule 99 mm",
]


@pytest.mark.parametrize("line", BALL)
def test_data_of_the_ball_in_one_line_are_read(line: str) -> None:
    read = read_log(f"{line}\n{PLAIN}".encode())
    assert read.ok
    assert read.constants["ball_mass"] == pytest.approx(4.3)
    assert read.constants["ball_diameter"] == pytest.approx(0.099)
    assert {each.code for each in read.diagnostics}.isdisjoint({"G240", "G214"})


@pytest.mark.parametrize(
    "line",
    [
        "# ball 4.3 kg",
        "# weight 50 g, ball diameter 99 mm",
        "# diameter of the weight 30 mm, ball mass 4.3 kg, and more",
        "# distance from the ball 14.8 cm",
        "Ball 3, mass 20.1 g, distance 14.8 cm",
    ],
)
def test_a_line_that_says_more_than_constants_is_a_note(line: str) -> None:
    assert not read_log(f"{line}\n{PLAIN}".encode()).constants.keys() - {"g"}


def test_a_line_with_another_key_is_to_be_written_as_two() -> None:
    (fault,) = questions(f"# ball_mass: 4.3 kg, label: B7\n{PLAIN}")
    assert "one line for each value" in fault.hint
