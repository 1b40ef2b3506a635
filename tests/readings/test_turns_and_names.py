"""How many turns a time covers is never taken from a name alone; names in the languages of the lab."""

import pytest

from gyrodata.readings import read_log

HEAD = "mass [g],position [cm],spin [rpm],"
BY_SYMBOL = HEAD + '"T, с","t, с",N\n20,15,400,93.1,46.55,2\n20,15,400,36.5,36.5,1\n'


@pytest.mark.parametrize(
    ("log", "given", "role", "values"),
    [
        (HEAD + "T Ω(180°) (s)\n20,15,400,19.6\n", {}, "turns", (0.5,)),
        (HEAD + "T/2 (s)\n20,15,400,19.6\n", {"mapping": {"time": "T/2 (s)"}, "settings": {"turns": "1/2"}}, "turns",
         (0.5,)),
        (HEAD + "t(1/3 rev) [s],t(2/3 rev) [s]\n20,15,400,6.6,13.1\n40,15,400,,6.6\n", {}, "turns",
         (1 / 3, 2 / 3, 2 / 3)),
        ("mass [g],position [cm],time of 10 turns of the ball (s),time [s],turns\n20,15,1.5,22,1\n", {}, "spin_turns",
         (10.0,)),
        (HEAD + "Trial 1 (s),Trial 2 (s),N\n20,15,400,7,7.1,1\n", {}, "time", (7.0, 7.1)),
        (HEAD + "Time for 1/3 rev (s),turns\n20,15,400,6.6,1\n", {"settings": {"turns": "1/3"}}, "turns", (1 / 3,)),
        (HEAD + "Time for 1/3 rev (s),turns\n20,15,400,6.6,1/3\n", {}, "turns", (1 / 3,)),
        (HEAD + "period [s],turns\n20,15,400,39.2,1\n", {}, "precession_period", (39.2,)),
        (HEAD + "period [s]\n20,15,400,39.2\n", {"settings": {"angle": "360 deg"}}, "precession_period", (39.2,)),
        (BY_SYMBOL, {"mapping": {"time": "T, с", "precession_period": "t, с"}}, "time", (93.1, 36.5)),
        (BY_SYMBOL.replace('"T, с","t, с"', '"t, с","T, с"'), {}, "time", (93.1, 36.5)),
        (HEAD + "T1 (s),T2 (s),T avg (s)\n20,15,400,39.2,39.4,39.3\n", {"settings": {"turns": "1"}}, "turns", (1, 1)),
        (HEAD + "time_1 [s],time_2 [s],precession period [s]\n20,15,400,39.2,39.4,39.3\n", {}, "precession_period",
         (39.3,)),
    ],
)  # fmt: skip
def test_stated_turns_are_read(log, given, role, values):
    readings = read_log(log, **given)
    assert readings.ok, readings.diagnostics
    assert readings.columns[role].values == pytest.approx(values)


@pytest.mark.parametrize(
    ("log", "settings", "code", "hint"),
    [
        (HEAD + "T/2 (s)\n20,15,400,19.6\n", {}, "G301", '--map time="T/2 (s)" --set turns=1/2'),
        (HEAD + "T_P_1 [s]\n20,15,400,39\n", {}, "G301", '--map precession_period="T_P_1 [s]"'),
        ("mass [g],position [cm],time for 10 revolutions (initial) (s),Time for 2 precession turns (s)\n20,15,1.5,22\n",
         {}, "G301", "divide"),
        # Ten turns may be those of the ball, if no spin is given.
        ("mass [g],position [cm],time of 10 turns (s),time [s],turns\n20,15,1.5,22,1\n", {}, "G301", ""),
        (HEAD + "Time for 1/3 rev (s),turns\n20,15,400,6.6,1\n", {}, "G303", ""),
        (HEAD + "period [s]\n20,15,400,39.2\n", {"turns": "3"}, "G230", ""),
        (HEAD + "period [s]\n20,15,400,39.2\n", {"angle": "40 deg"}, "G230", ""),
        (HEAD + "period [s],turns\n20,15,400,39.2,1\n20,15,400,39.2,2\n", {}, "G230", ""),
        (BY_SYMBOL, {}, "G231", ""),
        (HEAD + "T1 (s),T2 (s),T avg (s)\n20,15,400,39.2,39.4,39.3\n", {}, "G301", ""),
        (HEAD + "T (s)\n20,15,400,39.2\n", {}, "G207", "--set turns"),
        ('m, г,"t, c",N\n76г,139.2,1\n', {"position": "12 cm", "spin": "400 Hz"}, "G232", '"m [г]"'),
        ("# m1 = 47 g\n" + HEAD + "time [s],turns\n20,15,400,39,1\n", {}, "G305", "# mass: 47 g"),
    ],
)  # fmt: skip
def test_turns_that_may_mean_two_things_are_asked_about(log, settings, code, hint):
    told = [one for one in read_log(log, settings=settings).diagnostics if one.code == code]
    assert told
    assert any(hint in one.hint for one in told)
