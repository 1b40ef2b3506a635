"""How many turns a time covers is never taken from a name alone; names in the languages of the lab."""

import pytest

from gyrodata.measurements import measure
from gyrodata.readings import parse_header, read_log, stated_turns, write_log

HEAD = "mass [g],position [cm],spin [rpm],"


def errors(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics if diagnostic.severity == "error"]


def hints(readings, code="G301"):
    return [diagnostic.hint for diagnostic in readings.diagnostics if diagnostic.code == code]


@pytest.mark.parametrize(
    ("header", "roles", "unit"),
    [
        ("t_R / s", ("spin_period",), "s"),
        ("ω_K / s^-1", (), "s^-1"),
        ("Zusatzmasse in g", ("mass",), "g"),
        ("Drehzahl in U/min", ("spin",), "U/min"),
        ("masse en g", ("mass",), "g"),
        ("NT, c", ("time",), "c"),
        ("N_p", ("turns",), None),
        ("N_w", (), None),
        ("ΔT_p [s]", ("u_precession_period", "time"), "s"),
        ("Tiempo de giro inicial T Gi (s)", ("spin_period_start",), "s"),
        ("T Gf (s)", ("spin_period_end",), "s"),
        ("Frequência (Hz)", ("spin", "precession_rate"), "Hz"),
        ("질량(kg)", ("mass",), "kg"),
        ("반경(m)", ("position",), "m"),
        ("회전수 (rpm)", ("spin",), "rpm"),
        ("세차각속도(측정)", ("precession_rate",), None),
        ("세차각속도(이론)", (), "이론"),
        ("Ω theory [rad/s]", (), "rad/s"),
        ("mean of the period (s)", ("precession_period",), "s"),
    ],
)
def test_headers(header, roles, unit):
    parsed = parse_header(header)
    assert (parsed.roles, parsed.unit) == (roles, unit)


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ("T/2 (s)", "turns=1/2"),
        ("T Ω(180°) (s)", 'angle="180 deg"'),
        ("time for 10 revolutions (s)", "turns=10"),
        ("Time for 2 precession turns (s)", "turns=2"),
        ("10T (s)", "turns=10"),
        ("t half turn [s]", "turns=1/2"),
        ("Time for 1/3 rev (s)", "turns=1/3"),
        ("t(2/3 rev) [s]", "turns=2/3"),
        ("⅓ turn [s]", "turns=1/3"),
        ("one revolution (s)", "turns=1"),
        ("T_P_1 [s]", ""),
        ("Trial 1 (s)", ""),
        ("time [s]", ""),
    ],
)
def test_turns_that_a_header_tells_of(header, says):
    assert stated_turns(header) == says


def test_turns_that_a_header_states_are_read_and_those_of_a_symbol_proposed():
    stated = read_log(HEAD + "T Ω(180°) (s)\n20,15,400,19.6\n")
    assert [d.code for d in stated.diagnostics] == ["G145"]
    assert stated.columns["turns"].values == (0.5,)
    short = read_log(HEAD + "T/2 (s)\n20,15,400,19.6\n")
    assert '--map time="T/2 (s)" --set turns=1/2' in hints(short)[0]
    assert read_log(HEAD + "T/2 (s)\n20,15,400,19.6\n", mapping={"time": "T/2 (s)"}, settings={"turns": "1/2"}).ok
    two = read_log(HEAD + "t(1/3 rev) [s],t(2/3 rev) [s]\n20,15,400,6.6,13.1\n40,15,400,,6.6\n")
    assert two.columns["turns"].values == (1 / 3, 2 / 3, 2 / 3)
    assert read_log(write_log(two)).columns["turns"].values == (1 / 3, 2 / 3, 2 / 3)
    wheel = (
        "mass [g],position [cm],time for 10 revolutions (initial) (s),Time for 2 precession turns (s)\n20,15,1.5,22\n"
    )
    (spin,) = hints(read_log(wheel))
    assert "spin_period" in spin
    assert "divide" in spin
    ball = read_log("mass [g],position [cm],time of 10 turns of the ball (s),time [s],turns\n20,15,1.5,22,1\n")
    assert (ball.columns["spin_time"].values, ball.columns["spin_turns"].values) == ((1.5,), (10.0,))
    # Ten turns may be those of the ball, where no spin is told.
    assert errors(read_log("mass [g],position [cm],time of 10 turns (s),time [s],turns\n20,15,1.5,22,1\n")) == ["G301"]
    trials = read_log(HEAD + "Trial 1 (s),Trial 2 (s),N\n20,15,400,7,7.1,1\n")
    assert trials.columns["time"].values == (7.0, 7.1)
    assert '--map precession_period="T_P_1 [s]"' in hints(read_log(HEAD + "T_P_1 [s]\n20,15,400,39\n"))[0]


def test_a_header_and_a_column_that_contradict_each_other():
    log = HEAD + "Time for 1/3 rev (s),turns\n20,15,400,6.6,1\n"
    assert errors(read_log(log)) == ["G303"]
    assert read_log(log, settings={"turns": "1/3"}).columns["turns"].values == (1 / 3,)
    assert read_log(log.replace(",1\n", ",1/3\n")).ok


def test_a_period_beside_turns_is_asked_about():
    for given in ({"turns": "3"}, {"angle": "40 deg"}):
        assert errors(read_log(HEAD + "period [s]\n20,15,400,39.2\n", settings=given)) == ["G230"]
    assert errors(read_log(HEAD + "period [s],turns\n20,15,400,39.2,1\n20,15,400,39.2,2\n")) == ["G230"]
    assert read_log(HEAD + "period [s],turns\n20,15,400,39.2,1\n").ok
    assert read_log(HEAD + "period [s]\n20,15,400,39.2\n", settings={"angle": "360 deg"}).ok


def test_time_and_period_the_other_way_round():
    rows = "20,15,400,93.1,46.55,2\n20,15,400,36.5,36.5,1\n"
    readings = read_log(HEAD + '"T, с","t, с",N\n' + rows)
    assert errors(readings) == ["G231"]
    answered = read_log(HEAD + '"T, с","t, с",N\n' + rows, mapping={"time": "T, с", "precession_period": "t, с"})
    assert answered.ok
    assert answered.columns["time"].values == (93.1, 36.5)
    assert read_log(HEAD + '"t, с","T, с",N\n' + rows).ok


def test_a_mean_beside_repeats_is_no_period_of_one_turn():
    readings = read_log(HEAD + "T1 (s),T2 (s),T avg (s)\n20,15,400,39.2,39.4,39.3\n")
    assert errors(readings) == ["G301"]
    assert read_log(HEAD + "T1 (s),T2 (s),T avg (s)\n20,15,400,39.2,39.4,39.3\n", settings={"turns": "1"}).ok
    either = read_log(HEAD + "T (s)\n20,15,400,39.2\n")
    assert errors(either) == ["G207"]
    assert "--set turns" in either.diagnostics[0].hint


def test_repeats_without_turns_do_not_multiply_a_period():
    readings = read_log(HEAD + "time_1 [s],time_2 [s],precession period [s]\n20,15,400,39.2,39.4,39.3\n")
    assert readings.ok
    assert readings.runs == ("1",)
    assert [d.code for d in readings.diagnostics] == ["G220"]


def test_a_header_parted_by_its_own_comma():
    readings = read_log('m, г,"t, c",N\n76г,139.2,1\n', settings={"position": "12 cm", "spin": "400 Hz"})
    assert errors(readings) == ["G232"]
    assert '"m [г]"' in readings.diagnostics[0].hint


def test_two_rotations_exchanged_are_warned_of():
    log = "m (g);d (cm);φ̇ (tr/min);ψ̇ (rad/s)\n20;15;400;0,16\n40;15;400;0,32\n"
    assert "G405" in [diagnostic.code for diagnostic in measure(read_log(log)).diagnostics]


def test_a_numbered_symbol_in_a_remark():
    readings = read_log("# m1 = 47 g\n" + HEAD + "time [s],turns\n20,15,400,39,1\n")
    assert "# mass: 47 g" in readings.diagnostics[0].hint
