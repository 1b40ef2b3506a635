"""A log in any of its forms is read the same, and so is what the tool writes of it."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gyrodata
from gyrodata.readings import read_log, write_log

BOUNDED = settings(derandomize=True, deadline=None, max_examples=150)
HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
RPM = math.pi / 30

FORMS = {
    "mass": ({"g": 1e-3, "г": 1e-3, "kg": 1.0, "mg": 1e-6}, ["mass", "weight", "Masse", "m", "Масса груза", "MASS"]),
    "position": ({"cm": 0.01, "mm": 1e-3, "m": 1.0, "см": 0.01}, ["position", "x", "lever arm", "Hebelarm", "плечо"]),
    "spin": (
        {"rpm": RPM, "Hz": 2 * math.pi, "rad/s": 1.0, "U/min": RPM, "об/мин": RPM, "deg/s": math.pi / 180},
        ["spin", "spin speed", "Drehzahl", "ω", "prędkość obrotowa", "vitesse de rotation"],
    ),
    "time": ({"s": 1.0, "с": 1.0, "ms": 1e-3, "min": 60.0}, ["time", "t", "Zeit", "время", "stopwatch", "czas"]),
    "turns": ({"": 1.0}, ["turns", "N", "revolutions", "число оборотов", "Umläufe", "tours"]),
}
NUMBERS = {
    "mass": st.integers(100, 99999).map(lambda n: f"{n / 100:.2f}"),
    "position": st.integers(-3000, 3000).filter(bool).map(lambda n: f"{n / 10:.1f}"),
    "spin": st.integers(1, 99999).map(lambda n: f"{n / 10:.1f}"),
    "time": st.integers(1, 99999).map(lambda n: f"{n / 100:.2f}"),
    "turns": st.sampled_from(["1", "1/3", "2/3", "2.5", "3"]),
}


@st.composite
def logs(draw):
    """A log in a form drawn at random, with the SI values that it means."""
    delimiter, comma = draw(st.sampled_from([",", ";", "\t"])), draw(st.booleans())
    style = draw(st.sampled_from(["{} [{}]", "{} ({})", "{}, {}", "{} / {}", "{}[{}]"]))
    n = draw(st.integers(1, 6))
    columns, meant = [], {}
    for role in draw(st.permutations(list(FORMS))):
        units, names = FORMS[role]
        unit, header = draw(st.sampled_from(sorted(units))), draw(st.sampled_from(names))
        texts = draw(st.lists(NUMBERS[role], min_size=n, max_size=n))
        meant[role] = [number(text) * units[unit] for text in texts]
        written = [text.replace(".", ",") if comma else text for text in texts]
        columns.append([style.format(header, unit) if unit else header, *written])
    end = draw(st.sampled_from(["\n", "\r\n", "\r"]))
    rows = [delimiter.join(f'"{c[i]}"' if delimiter in c[i] else c[i] for c in columns) for i in range(n + 1)]
    return (end.join(rows) + end).encode(draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]))), meant


def number(text):
    over, _, under = text.partition("/")
    return int(over) / int(under) if under else float(text)


def read_of(readings):
    """What the analysis uses; places, lines and headers are those of each file."""
    columns = {role: [(one and one.value, one and one.u) for one in column.readings]
               for role, column in readings.columns.items()}  # fmt: skip
    return (columns, readings.runs, readings.notes, readings.constants, readings.uncertainties, readings.balance_tilt,
            readings.balance_drift, readings.metadata, readings.balanced)  # fmt: skip


@given(logs())
@BOUNDED
def test_log_in_any_form_has_the_values_that_it_means(drawn):
    data, meant = drawn
    readings = read_log(data)
    assert readings.ok, readings.diagnostics
    for role, values in meant.items():
        assert list(readings.columns[role].values) == pytest.approx(values, rel=1e-14)
    written = write_log(readings)
    assert read_of(read_log(written)) == read_of(readings)
    assert write_log(read_log(written)) == written


RICH = """# station: 3
# g: 9.803 m/s^2
# u_position: 0.5 mm
# u_spin: 0.2 % + 0.5 rpm
# u_mass_scale: 0.07 %
# balance_tilt: 3 deg in 10 s
# balance_drift: 5 deg in 60 s at 400 rpm
# balanced: nein
# latitude: 33.9 S
# weight_diameter: 3.0 ± 0.1 cm
# u_angle: 2 deg
# pitch: 2 deg
run;mass [g];position [cm];spin_start [rpm];spin_end [rpm];time_1 [s];time_2 [s];turns;u_time [s];spin_sense;note
a;20;15,0±0,1;410;400;7,06;7,10;1/3;0,2;ccw;first, with a comma
b;;;610;600;10,01;;1/3;;cw;"a ""quoted"" word"
c;0;;405±3;400;160,2;;1/3;1 %;ccw;
d;40;-15,0;600;590;03:36,26;3:40,5;2/3;0,3;ccw;#4
"""


@pytest.mark.parametrize(
    ("log", "given"),
    [
        (RICH, {}),
        ("# turns: 2/3\nmass [g],time [s],turns\n20,7.06,1/3\n,13.06,\n",
         {"spin": "10 Hz", "position": "-5 cm", "u_time": "0.1 s"}),
        *((f"# u_time: {stated}\n{HEAD}20,15.0,206,7.06,1/3\n", {}) for stated in ("7.0 %", "33.333333333333336 %")),
        ("# position_from: surface\n# ball_diameter: 10.16 cm\n" + HEAD + "20.1,-9.72,300,9.9,1/3\n", {}),
    ],
)  # fmt: skip
def test_log_written_by_the_tool_has_the_same_readings(log, given):
    readings = read_log(log, settings=given)
    assert readings.ok
    assert read_of(read_log(write_log(readings)))[:2] == read_of(readings)[:2]


def test_log_written_by_the_tool_has_the_same_answer():
    log = HEAD + "20,15.0,206,20.4,1\n,,407,40.1,1\n40,15,405,20.2,1\n"
    again = write_log(read_log(log)).encode()
    assert gyrodata.analyze(again).inertia == gyrodata.analyze(log.encode()).inertia, "filled cells are one weighing"


@pytest.mark.parametrize("spin", ["389,665", "1,212", "604"])
def test_decimal_commas_become_points_that_part_no_thousands(spin):
    log = f"{HEAD.replace(',', ';')}40,3;14,8;{spin};4,88764;1/2\n20,1;114,985;212,4;6,951;1/3\n"
    again = read_log(write_log(read_log(log)))
    assert not again.diagnostics
    assert again.columns["spin"].values[0] == pytest.approx(float(spin.replace(",", ".")) * RPM)
