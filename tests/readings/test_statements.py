"""What a log says in words is used, is asked about, or is quoted in a question."""

from __future__ import annotations

import math

import pytest
from simulated_labs import analyze_briefly

from gyrodata import LogError
from gyrodata.base.errors import Diagnostic
from gyrodata.readings import read_log

TRUTH, G = 4.4e-3, 9.80665
RUNS = [(20.1, 206), (40.3, 394), (60.2, 604), (20.1, 604), (40.3, 206), (60.2, 394)]


def log(
    head: str, row: str = "{mass};14.8;{spin};{period:.2f}", sign: str = ";"
) -> str:
    """Write six runs below a header; the weight hangs at 14.8 cm."""
    lines = [f"# g: {G} m/s^2", head]
    for mass, spin in RUNS:
        torque = mass * 1e-3 * G * 0.148
        period = 2 * math.pi * TRUTH * spin * math.pi / 30 / torque
        values = {"mass": mass, "spin": spin, "period": period, "half": period / 2}
        lines.append(row.format(**values, third=period / 3).replace(";", sign))
    return "\n".join(lines) + "\n"


def is_true(text: str) -> bool:
    answer = analyze_briefly(text.encode()).inertia
    return bool(abs(answer.value - TRUTH) < max(0.01 * TRUTH, 3 * answer.u))


def codes(text: str, severity: str) -> list[str]:
    found = read_log(text).diagnostics
    return [one.code for one in found if one.severity == severity]


def question(text: str) -> Diagnostic:
    """Return the only question about a log."""
    (asked,) = [one for one in read_log(text).diagnostics if one.severity == "error"]
    return asked


PERIOD = "mass (g);position (cm);spin (rpm);period (s)"
TIME = "mass (g);position (cm);spin (rpm);time (s)"


@pytest.mark.parametrize(
    "note",
    [
        "on a mesuré une demi-période",
        "se midió medio periodo",
        "misurato mezzo periodo",
        "mierzono pół okresu",
        "измеряли половину периода",
        "mierzono dwa okresy",
        "měřili jsme půl periody",
        "halvperioder mättes",
        "半周期を測定",
    ],
)
def test_note_on_another_number_of_periods_is_a_doubt(note: str) -> None:
    assert codes(f"{log(PERIOD)}# {note}\n", "warning") == ["G240"]


@pytest.mark.parametrize(
    "note",
    [
        "careful: mass and position columns are swapped",
        "Achtung: Spalten Masse und Abstand vertauscht",
    ],
)
def test_note_on_swapped_columns_is_a_doubt(note: str) -> None:
    assert codes(f"{log(PERIOD)}# {note}\n", "warning") == ["G240"]


@pytest.mark.parametrize("note", ["medimos un periodo", "run 3 has a long period"])
def test_note_on_one_period_is_no_doubt(note: str) -> None:
    assert codes(f"{log(PERIOD)}# {note}\n", "warning") == []


@pytest.mark.parametrize("sign", ["\t", ";", ","])
@pytest.mark.parametrize("mark", ['"', "″", "idem"])
def test_marks_for_the_value_above_are_asked_about(mark: str, sign: str) -> None:
    text = log("mass (g);position (cm);spin (rpm);period (s)", sign=sign)
    text = text.replace(
        "mass (g);position (cm);spin", f"mass (g){sign}position (cm){sign}spin"
    )
    lines = text.replace("(rpm);", f"(rpm){sign}").splitlines()
    lines[3] = sign.join([mark, mark, *lines[3].split(sign)[2:]])
    found = read_log("\n".join(lines)).diagnostics
    asked = [one for one in found if one.severity != "note"]
    assert [(one.code, one.line) for one in asked] == [("G203", 4)] * 2
    assert all("also if it is the same as above" in one.hint for one in asked)


@pytest.mark.parametrize(
    "header",
    [
        "diameter of the circle (cm)",
        "Durchmesser der Bahn (cm)",
        "średnica okręgu (cm)",
    ],
)
def test_diameter_is_to_be_halved_before_it_is_a_position(header: str) -> None:
    text = log(TIME.replace("position (cm)", header).replace("time", "period"))
    asked = question(text)
    assert f'for each "{header}" write half of it, below "position [cm]"' in asked.hint
    assert f'if "{header}" is' not in asked.hint


def test_count_of_weights_is_to_be_replaced_by_their_mass() -> None:
    text = log(PERIOD.replace("mass (g)", "washers"), "3;14.8;{spin};{period:.2f}")
    asked = question(f"{text}# one washer = 9.8 g\n")
    assert '"one washer: 9.8 g"' in asked.message
    assert 'for each "washers" write the mass of all' in asked.hint


def test_sentence_with_what_is_missing_is_quoted() -> None:
    text = f"{log(TIME)}# Waited 3 turns before the start\n"
    assert '"Waited 3 turns before the start"' in question(text).message


def test_header_row_to_copy_has_the_sign_between_the_cells() -> None:
    head = TIME.replace("mass (g)", "blob").replace(";", "\t")
    row = "{mass} x;14.8;{spin};{period:.2f}"
    asked = question(log(head, row, "\t"))
    assert "position (cm)\tspin (rpm)\ttime (s)" in asked.hint


def test_unit_in_latex_is_read() -> None:
    head = "$m$ [g];$x$ [cm];$n$ [min$^{-1}$];period (s)"
    assert is_true(log(head))


def test_units_below_a_date_belong_to_the_names() -> None:
    head = "mass;position;Kreisfrequenz;period\n20240314_A;;;\ng;cm;1/min;s"
    assert is_true(log(head))


@pytest.mark.parametrize(
    ("turns", "doubts"), [("2", []), ("1", ["G240"]), ("1/3", ["G240"])]
)
def test_note_on_turns_is_answered_by_a_line_with_them(
    turns: str, doubts: list[str]
) -> None:
    note = "note: we always let it go round twice before stopping the watch"
    text = f"# turns: {turns}\n{log(TIME)}\n{note}\n"
    found = codes(text, "warning") + codes(text, "error")
    assert found[:1] == doubts[:1] or (doubts and found)
    assert bool(found) == bool(doubts)


def test_title_with_a_comma_is_no_header() -> None:
    title = "Gyro lab, Thu section\nweight 40 g hung 14.8 cm from ball centre\n"
    head = "I timed one full precession\n\nrpm, s"
    text = log(title + head, "{spin},{period:.2f}")
    found = read_log(text)
    assert found.ok
    assert {*found.columns} == {"mass", "position", "spin", "time", "turns"}


SURFACE = "mass (g);distance from ball surface (cm);spin (rpm);period (s)"


@pytest.mark.parametrize(
    "key", ["diamètre de la boule", "Durchmesser der Kugel", "diameter of the ball"]
)
def test_diameter_of_the_ball_is_read_in_words(key: str) -> None:
    text = log(SURFACE, "{mass};9.72;{spin};{period:.2f}")
    assert is_true(f"# {key} : 10,16 cm\n{text}")


def test_radius_of_the_ball_is_quoted() -> None:
    asked = question(f"{log(SURFACE)}Kugelradius 5,0 cm\n")
    assert '"Kugelradius 5,0 cm"' in asked.hint
    assert "twice its radius" in asked.hint


LEGENDS = (
    "T = tempo di una precessione completa",
    "r – position, T – okres precesji",
    "T: time for 1/3 turn",
    "T = half a turn",
    "T: time of 5 periods",
    "T = t/3",
    "T = mean of 3 periods",
    "T: 3 turns divided by 3",
)


@pytest.mark.parametrize("legend", LEGENDS)
def test_legend_of_a_symbol_is_asked_about(legend: str) -> None:
    asked = question(f"{log('m (g);r (cm);n (rpm);T (s)')}\n# {legend}\n")
    assert asked.code == "G207"


def test_turns_timed_are_no_time() -> None:
    head = "mass (g);position (cm);spin (rpm);Revolutions timed;Elapsed time (s)"
    assert is_true(log(head, "{mass};14.8;{spin};1/3;{third:.2f}"))


@pytest.mark.parametrize(
    "caption",
    ["Masa: 40.3 g (medido con balanza)", "Masse: 40.3 g (gemessen auf der Waage)"],
)
def test_remark_in_brackets_behind_a_value(caption: str) -> None:
    text = log("position (cm);spin (rpm);period (s)", "14.8;{spin};{period:.2f}")
    found = read_log(f"{caption}\n{text}")
    assert found.ok
    assert found.columns["mass"].values[0] == pytest.approx(0.0403)


def test_remark_that_may_change_a_value_is_asked_about() -> None:
    text = log("position (cm);spin (rpm);period (s)", "14.8;{spin};{period:.2f}")
    with pytest.raises(LogError):
        analyze_briefly(f"mass: 40.3 g (measured without hanger)\n{text}".encode())


@pytest.mark.parametrize(
    "note",
    [
        "tempo medido para 1/3 de volta de precessão",
        "time measured for 1/3 of a turn of precession",
        "I timed 1/3 turn",
    ],
)
def test_sentence_gives_the_turns_of_all_times(note: str) -> None:
    text = log(TIME, "{mass};14.8;{spin};{third:.2f}")
    assert is_true(f"# {note}\n{text}")


RUNS_IN_WORDS = (
    "Run 1: m=40 g, x=10 cm, spin=332 rpm, turns=1, t=24.41 s\n",
    "50 g @ 14 cm\n{0}75 g @ 14 cm\n{0}(times of one turn)\n".format(
        "565 rpm -> 23.8 s\n445 rpm -> 18.7 s\n"
    ),
)


@pytest.mark.parametrize("lines", [2 * RUNS_IN_WORDS[0], RUNS_IN_WORDS[1]])
def test_the_names_for_runs_in_sentences_are_shown(lines: str) -> None:
    asked = question(lines)
    assert asked.code == "G202"
    names = asked.hint.partition("names: ")[2]
    typed = read_log(f"{names}\n40, 10, 332, 24.41, 1\n")
    assert typed.ok
    assert set(typed.columns) == {"mass", "position", "spin", "time", "turns"}


LACKS_POSITION = (
    "mass [g],spin [rpm],time [s],turns\n20.1,400,41.1,1\n40.3,200,10.3,1\n"
)


@pytest.mark.parametrize(
    "line", ["# x = 14.8 cm", "# arm: 14.8 cm", "# r = 14.8 cm from the centre"]
)
@pytest.mark.parametrize("is_above", [True, False])
def test_a_line_with_a_key_in_other_words_gives_what_lacks(
    line: str, is_above: bool
) -> None:
    parts = [f"{line}\n", LACKS_POSITION]
    log = read_log("".join(parts if is_above else parts[::-1]).encode())
    assert log.columns["position"].values == pytest.approx((0.148, 0.148))
    assert "G305" not in [each.code for each in log.diagnostics]


@pytest.mark.parametrize("name", ["Δx (cm)", "± (cm)", "δ (cm)", "delta x (cm)"])
def test_a_column_of_differences_is_never_the_reading(name: str) -> None:
    table = f"mass [g],{name},spin [rpm],time [s],turns\n20.1,0.1,400,41.1,1\n"
    log = read_log((table + "40.3,0.1,200,10.3,1\n").encode())
    assert "position" not in log.columns
    assert [each.code for each in log.diagnostics if each.severity == "error"] == [
        "G301"
    ]
