"""A log written in any of its forms is read the same, and survives being written in canonical form."""

import math

import pytest
from columns import of, shared
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from gyrodata.readings import read_log, write_log

BOUNDED = settings(derandomize=True, deadline=None, max_examples=150)

FORMS = {
    "mass": (
        {"g": 1e-3, "г": 1e-3, "kg": 1.0, "mg": 1e-6},
        ["mass", "weight", "Masse", "m", "Масса груза", "MASS", "masse ajoutée"],
    ),
    "position": (
        {"cm": 0.01, "mm": 1e-3, "m": 1.0, "см": 0.01},
        ["position", "x", "lever arm", "Hebelarm", "плечо", "ramię", "Lever-Arm"],
    ),
    "spin": (
        {
            "rpm": math.pi / 30,
            "Hz": 2 * math.pi,
            "rad/s": 1.0,
            "U/min": math.pi / 30,
            "об/мин": math.pi / 30,
            "deg/s": math.pi / 180,
        },
        ["spin", "spin speed", "Drehzahl", "ω", "prędkość obrotowa", "vitesse de rotation"],
    ),
    "time": ({"s": 1.0, "с": 1.0, "ms": 1e-3, "min": 60.0}, ["time", "t", "Zeit", "время", "stopwatch", "czas"]),
    "turns": ({"": 1.0}, ["turns", "N", "revolutions", "число оборотов", "Umläufe", "tours"]),
}
NUMBERS = {
    "mass": st.integers(0, 99999).map(lambda n: f"{n / 100:.2f}"),
    "position": st.integers(-3000, 3000).filter(bool).map(lambda n: f"{n / 10:.1f}"),
    "spin": st.integers(1, 99999).map(lambda n: f"{n / 10:.1f}"),
    "time": st.integers(1, 99999).map(lambda n: f"{n / 100:.2f}"),
    "turns": st.sampled_from(["1", "1/3", "2/3", "2.5", "3"]),
}


@st.composite
def logs(draw):
    """A log in a form drawn at random, with the SI values that it means."""
    delimiter = draw(st.sampled_from([",", ";", "\t"]))
    comma = draw(st.booleans())
    style = draw(st.sampled_from(["{} [{}]", "{} ({})", "{}, {}", "{} / {}", "{}[{}]"]))
    n = draw(st.integers(1, 6))
    columns, meant = [], {}
    for role in draw(st.permutations(list(FORMS))):
        units, names = FORMS[role]
        unit = draw(st.sampled_from(sorted(units)))
        header = draw(st.sampled_from(names))
        texts = draw(st.lists(NUMBERS[role], min_size=n, max_size=n))
        if role == "mass":
            texts = [text if float(text) else "1.00" for text in texts]
        meant[role] = [eval_number(text) * units[unit] for text in texts]
        written = [text.replace(".", ",") if comma else text for text in texts]
        columns.append([style.format(header, unit) if unit else header, *written])
    rows = [[quote(column[i], delimiter) for column in columns] for i in range(n + 1)]
    end = draw(st.sampled_from(["\n", "\r\n", "\r"]))
    text = end.join(delimiter.join(row) for row in rows) + (end if draw(st.booleans()) else "")
    return text.encode(draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]))), meant


def eval_number(text):
    over, _, under = text.partition("/")
    return int(over) / int(under) if under else float(text)


def quote(text, delimiter):
    return f'"{text}"' if delimiter in text or (delimiter == "," and "," in text) else text


def same(a, b):
    """Compare what the analysis uses; places, lines and headers are those of each file."""
    assert a.runs == b.runs
    assert a.notes == b.notes
    assert a.constants == b.constants
    assert a.uncertainties == b.uncertainties
    assert a.balance_tilt == b.balance_tilt
    assert a.balance_drift == b.balance_drift
    assert a.metadata == b.metadata
    assert set(a.columns) == set(b.columns)
    for role, column in a.columns.items():
        other = b.columns[role]
        assert (column.unit, shared(column)) == (other.unit, shared(other)), role
        for field in ("value", "step", "u"):
            assert of(column, field) == of(other, field), (role, field)


@given(logs())
@BOUNDED
def test_any_form_means_the_same(drawn):
    data, meant = drawn
    readings = read_log(data)
    assert readings.ok, readings.diagnostics
    for role, values in meant.items():
        for value, expected in zip(readings.columns[role].values, values, strict=True):
            assert math.isclose(value, expected, rel_tol=1e-14)
    again = read_log(write_log(readings))
    same(readings, again)
    assert write_log(again) == write_log(read_log(write_log(again)))


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


def test_a_rich_log():
    readings = read_log(RICH)
    assert readings.ok
    assert readings.runs == ("a.1", "a.2", "b", "c", "d.1", "d.2")
    assert readings.balanced is False
    assert math.isclose(readings.constants["latitude"], math.radians(-33.9))
    same(readings, read_log(write_log(readings)))


def test_constants_from_options_become_lines():
    body = "mass [g],time [s],turns\n20,7.06,1/3\n,13.06,\n"
    readings = read_log("# turns: 2/3\n" + body, settings={"spin": "10 Hz", "position": "-5 cm", "u_time": "0.1 s"})
    assert readings.columns["turns"].values == (1 / 3, 2 / 3)
    again = read_log(write_log(readings))
    same(readings, again)
    assert "# spin: 10 Hz" in write_log(readings)


@given(st.integers(2, 7), st.lists(st.booleans(), min_size=12, max_size=12), st.data())
@BOUNDED
def test_merged_cells_keep_their_identity(n, blanks, data):
    rows = []
    for i in range(n):
        mass = "" if i and blanks[i] else str(data.draw(st.integers(1, 3)) * 20)
        spin = "" if i and blanks[0] else "400"
        rows.append(f"{mass},15.0,{spin},{7 + i}.06,1/3")
    readings = read_log("mass [g],position [cm],spin [rpm],time [s],turns\n" + "\n".join(rows))
    assert readings.ok
    same(readings, read_log(write_log(readings)))


@pytest.mark.parametrize("stated", ["7.0 %", "0.07 %", "14.0 %", "29.0 %", "5.7 %", "57.0 %", "33.333333333333336 %"])
def test_a_percentage_is_written_as_it_was_stated(stated):
    readings = read_log(f"# u_time: {stated}\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,206,7.06,1/3\n")
    written = write_log(readings)
    assert f"# u_time: {stated}" in written.splitlines()
    assert read_log(written).uncertainties == readings.uncertainties


@pytest.mark.parametrize("line", ["# balanced: yes", "# balanced: no", ""])
def test_a_log_says_of_its_balance_what_it_said(line):
    log = f"{line}\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,206,7.06,1/3\n"
    written = write_log(read_log(log)).splitlines()
    assert [one for one in written if "balanced" in one] == ([line] if line else [])


def test_what_was_read_cannot_be_written_to():
    readings = read_log(
        "# reported_inertia: 4.4 g m^2\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15,400,39,1\n"
    )
    column = readings.columns["mass"]
    for record, field in (
        (readings, "name"),
        (column, "role"),
        (column.readings[0], "value"),
        (readings.reported["inertia"], "u"),
    ):
        with pytest.raises(AttributeError):
            setattr(record, field, None)


def test_readings_without_a_text_are_written_in_full():
    readings = read_log(
        "mass [g],position [cm],spin [rpm],time [s],turns,spin_sense\n20,15,400,39,1/3,cw\n0,,200,19.5,1,\n"
    )
    columns = {
        role: replace(column, readings=tuple(replace(read, text="", step=None) for read in column.readings))
        for role, column in readings.columns.items()
    }
    text = write_log(replace(readings, columns=columns))
    assert text.splitlines() == [
        "mass [g],position [cm],spin [rpm],time [s],turns,spin_sense,run",
        "20.0,15.0,400.0,39.0,0.3333333333333333,-1.0,1",
        "0.0,,200.0,19.5,1.0,,2",
    ]


@pytest.mark.parametrize("spin", ["389,665", "1,212", "604"])
def test_decimal_commas_become_points_which_part_no_thousands(spin):
    head = "mass [g];position [cm];spin [rpm];time [s];turns\n"
    readings = read_log(f"{head}40,3;14,8;{spin};4,88764;1/2\n20,1;114,985;212,4;6,951;1/3\n")
    written = write_log(readings)
    assert '"' not in written
    again = read_log(written)
    assert not again.diagnostics
    assert again.columns["spin"].values == readings.columns["spin"].values
    assert again.columns["spin"].values[0] == pytest.approx(float(spin.replace(",", ".")) * math.pi / 30)
