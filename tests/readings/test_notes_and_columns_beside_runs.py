"""Columns of uncertainties, data of the ball, and sentences about turns or units."""

from __future__ import annotations

import json
import re

import pytest
from simulated_labs import analyze_briefly
from typed_labs import FOUR, START, is_true, log, questions

from gyrodata import LogError, read_log
from gyrodata.base.errors import Diagnostic
from gyrodata.readings import fixed_log

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
    (
        "mass (g),Δmass (g),position (cm),Δposition (cm),spin (rpm),Δspin (rpm),time (s),"
        "Δtime (s),turns"
    ),
    "mass (g),± (g),position (cm),± (cm),spin (rpm),± (rpm),time (s),± (s),turns",
    "mass (g),+/- g,position (cm),+/- cm,spin (rpm),+/- rpm,time (s),+/- s,turns",
    (
        "mass (g),uncertainty (g),position (cm),uncertainty (cm),spin (rpm),"
        "uncertainty (rpm),time (s),uncertainty (s),turns"
    ),
    (
        "Masse (g),Fehler (g),Abstand (cm),Fehler (cm),Drehzahl (1/min),Fehler (1/min),"
        "Zeit (s),Fehler (s),Umdrehungen"
    ),
    (
        "masse (g),incertitude (g),position (cm),incertitude (cm),rotation (tr/min),"
        "incertitude (tr/min),temps (s),incertitude (s),tours"
    ),
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
def test_turns_in_a_sentence_are_quoted_and_proposed(sentence: str, turns: str) -> None:
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


# --- Units in notes ---


@pytest.mark.parametrize(
    ("note", "role"),
    [
        ("# positions are in inches", "position"),
        ("Note: positions in inches, not cm", "position"),
        ("Achtung: Abstand in Zoll gemessen", "position"),
        ("# les positions sont en pouces", "position"),
        ("# spin is in Hz, not rpm", "spin"),
        ("Drehzahl in Hz", "spin"),
        ("# masses are in ounces", "mass"),
        ("# times in minutes", "time"),
        ("# time in min not s", "time"),
    ],
)
def test_a_note_that_names_another_unit_is_a_doubt(note: str, role: str) -> None:
    answer = analyze_briefly(f"{note}\n{PLAIN}".encode())
    said = [each for each in answer.diagnostics if "names another unit" in each.message]
    (warning,) = said
    assert f"another unit of the {role}" in warning.message
    assert warning.doubt == "note"
    assert diagnostics(f"corrected: {note.strip('# ')}\n{PLAIN}", "G240") == []


def test_a_unit_in_the_header_answers_the_note() -> None:
    text = log(f"{START},turns".replace("[cm]", "[in]"), f"{FOUR},{{turns}}")
    text = f"# positions are in inches\n{text.replace('14.8', '5.827')}"
    assert diagnostics(text, "G240") == []
    assert is_true(text)


@pytest.mark.parametrize(
    "note",
    [
        "# all in g, cm, rpm and seconds",
        "# masses in grams, positions in centimetres",
        "# number of revolutions per minute",
        "# wait two minutes",
        "# one second of reaction",
        "# the rod is 12 inches long",
        "# time in s",
    ],
)
def test_a_note_with_the_same_unit_or_of_another_thing_is_no_doubt(note: str) -> None:
    assert diagnostics(f"{note}\n{PLAIN}", "G240") == []


# --- Words in headers and notes that change a reading ---


@pytest.mark.parametrize(
    ("header", "role", "words"),
    [
        ("sum of three times (s)", "time", "three"),
        ("Summe drei Zeiten (s)", "time", "drei"),
        ("time for 10 revolutions of the ball (s)", "spin_period", "ball"),
    ],
)
def test_a_mapped_time_is_not_several_times(header: str, role: str, words: str) -> None:
    names = START.split(",")
    at = 3 if role == "time" else 2
    names[at] = header
    text = log(f"{','.join(names)},turns", f"{FOUR},{{turns}}")
    found = read_log(text.encode(), mapping={role: header}).diagnostics
    (error,) = [each for each in found if each.severity == "error"]
    assert (error.code, f'"{words}"' in error.message) == ("G207", True)
    assert "a sum" in error.hint


def test_a_sum_of_times_is_to_be_divided() -> None:
    head = f"{START},turns".replace("time [s]", "sum of three times (s)")
    (question,) = questions(log(head, f"{FOUR},{{turns}}"))
    assert "if it is the sum of several times, write their mean" in question.hint


@pytest.mark.parametrize("header", ["2 x spin (rpm)", "spin x 2 (rpm)", "spin/2 [rpm]"])
def test_a_multiple_of_the_spin_is_asked_about(header: str) -> None:
    head = f"{START},turns".replace("spin [rpm]", header)
    (question,) = questions(log(head, f"{FOUR},{{turns}}"))
    assert question.code == "G207"
    assert '"spin [rpm]"' in question.hint


@pytest.mark.parametrize("header", ["spin 1 (rpm)", "Drehzahl n in 1/min", "n [1/min]"])
def test_a_number_or_a_fraction_beside_the_spin_is_none(header: str) -> None:
    head = f"{START},turns".replace("spin [rpm]", header)
    assert is_true(log(head, f"{FOUR},{{turns}}"))


@pytest.mark.parametrize(
    "note",
    [
        "# mass per piece, 2 pieces on the rod",
        "the mass is that of a single one",
        "# Masse pro Stück",
        "# la masse est celle d'une seule",
        "# each time is the sum of two measurements",
    ],
)
def test_a_note_on_one_of_several_is_a_doubt(note: str) -> None:
    (warning,) = diagnostics(f"{note}\n{PLAIN}", "G240")
    assert warning.doubt == "note"


def test_the_zero_of_the_ruler_is_no_origin_that_is_read() -> None:
    (warning,) = diagnostics(f"ruler zero at 1.5 cm\n{PLAIN}", "G240")
    assert "# ball_mass: 4.31 kg" in warning.hint
    assert "position" in warning.message


def test_the_middle_of_the_weight_is_not_the_centre_of_the_ball() -> None:
    note = "x = distance from the surface of the ball to the middle of the weight"
    (question,) = questions(f"{note}\n{PLAIN}")
    assert "positions count from the surface" in question.message


# --- Runs that are taken out, and cells that cannot be read ---


@pytest.mark.parametrize(
    "remark", ["bumped the table, do not use", '"bumped, do not use"', "discard"]
)
def test_a_run_with_an_excluding_remark_is_left_out(remark: str) -> None:
    lines = log(f"{START},turns,remark", f"{FOUR},{{turns}},").splitlines()
    cells = lines[4].split(",")
    cells[3] = f"{2 * float(cells[3]):.2f}"
    lines[4] = ",".join([*cells[:-1], remark])
    text = "\n".join(lines)
    assert len(read_log(text.encode()).runs) == 8
    assert [each.line for each in diagnostics(text, "G228")] == [5]
    assert is_true(text)


def test_a_remark_with_a_comma_does_not_leave_its_run_out() -> None:
    lines = log(f"{START},turns,remark", f"{FOUR},{{turns}},").splitlines()
    lines[4] += "good, went well"
    read = read_log("\n".join(lines).encode())
    assert len(read.runs) == 9
    (note,) = [each for each in read.diagnostics if each.code == "G214"]
    assert "left out" not in note.message


@pytest.mark.parametrize("mark", ["〃", '"', "small"])
def test_equal_cells_are_one_message_with_their_lines(mark: str) -> None:
    lines = log(
        f"{START},turns".replace(",", ";"), f"{FOUR},{{turns}}".replace(",", ";")
    )
    rows = lines.splitlines()
    for at in (3, 4, 6, 7):
        _, rest = rows[at].split(";", 1)
        rows[at] = f"{mark};{rest}"
    (error,) = questions("\n".join(rows))
    assert error.line == 4
    assert error.message.endswith("also in lines 5, 7-8")
    for at in (3, 4, 6, 7):
        rows[at] = rows[at].removeprefix(mark)
    assert read_log("\n".join(rows).encode()).ok


@pytest.mark.parametrize("time", ["?", "abc", "", "-"])
def test_a_row_without_a_time_is_kept_in_the_fixed_log(time: str) -> None:
    lines = log(f"{START},turns", f"{FOUR},{{turns}}").splitlines()
    cells = lines[5].split(",")
    cells[3] = time
    lines[5] = ",".join(cells)
    text, left = fixed_log(read_log("\n".join(lines).encode()))
    assert f"# left out: {lines[5]}" in text.splitlines()
    assert left == ("line 6: it has no time",)
    again = read_log(text.encode())
    assert again.ok
    assert len(again.runs) == 8


# --- Captions and units elsewhere ---


@pytest.mark.parametrize("sign", ["#", "##"])
def test_captions_behind_a_sign_are_of_the_table_below_them(sign: str) -> None:
    head, *runs = PLAIN.splitlines()[1:]
    head = head.split(",", 1)[1].split(",", 1)[1]
    parts = []
    for mass in (20.1, 40.3, 60.2):
        own = [run.split(",", 2)[2] for run in runs if run.startswith(f"{mass},")]
        parts += [f"{sign} Weight {mass} g at 14.8 cm", head, *own, ""]
    assert is_true("\n".join(parts))


def test_units_in_json_are_those_of_the_columns() -> None:
    names, *rows = [line.split(",") for line in PLAIN.splitlines()[1:]]
    pairs = [re.fullmatch(r"(\w+)(?: \[(\w+)\])?", name) for name in names]
    keys = [pair[1] for pair in pairs if pair]
    units = {pair[1]: pair[2] for pair in pairs if pair and pair[2]}
    runs = [dict(zip(keys, row, strict=True)) for row in rows]
    assert is_true(json.dumps({"g": "9.80665 m/s^2", "units": units, "runs": runs}))
    columns = {key: [run[key] for run in runs] for key in keys}
    assert is_true(json.dumps({"units": units, **columns}))


def test_seconds_below_ms_are_proposed_although_a_time_is_short() -> None:
    runs = [(m, s) for m in (20.1, 40.3, 60.2) for s in (196, 302, 404, 566)]
    rows = [f"{m},14.8,{s},1/3,{0.66 * s / m + 0.3:.2f}" for m, s in runs]
    rows[8] = "60.2,14.8,196,1/3,0.4"
    head = "mass (g),position (cm),spin (rpm),turns,time (ms)"
    with pytest.raises(LogError) as refused:
        analyze_briefly("\n".join([head, *rows]).encode())
    hints = [each.hint for each in refused.value.diagnostics if each.code == "G440"]
    assert any(
        'If s is meant, write the header as "time [s]"' in hint for hint in hints
    )


@pytest.mark.parametrize(
    "line",
    [
        "Ergebnis: I_zz = (4,49 ± 0,05)·10^-3 kg m²",
        "The moment of inertia is 4.49e-3 kg m^2",
    ],
)
def test_an_answer_in_a_line_of_text_changes_no_reading(line: str) -> None:
    assert diagnostics(f"{line}\n{PLAIN}", "G240") == []


def test_run_in_which_the_rod_did_not_move_is_kept_in_the_fixed_log() -> None:
    lines = log(f"{START},turns,notes", f"{FOUR},{{turns}},").splitlines()
    lines.append("0,15.0,400,60.0,0,rod at rest")
    before = read_log("\n".join(lines).encode())
    text, left = fixed_log(before)
    again = read_log(text.encode())
    assert left == ()
    assert before.unmoved is not None
    assert again.unmoved is not None
    assert again.unmoved.notes == before.unmoved.notes == ("rod at rest",)
    assert again.runs == before.runs
    assert again.columns["time"].values == before.columns["time"].values


def test_column_with_one_day_is_a_statement_about_the_log() -> None:
    lines = log(f"{START},turns,date", f"{FOUR},{{turns}},2026-03-09").splitlines()
    one = read_log("\n".join(lines).encode())
    assert one.metadata["day"] == "2026-03-09"
    assert one.blocks == ()
    lines[-4:] = [line.replace("03-09", "03-10") for line in lines[-4:]]
    two = read_log("\n".join(lines).encode())
    assert "day" not in two.metadata
    assert set(two.blocks) == {"2026-03-09", "2026-03-10"}
