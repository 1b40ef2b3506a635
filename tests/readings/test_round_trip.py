"""What the tool writes of a log is read as the log itself."""

import math

import pytest

from gyrodata.readings import read_log, write_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"


def read_of(readings):
    """What the analysis uses; places, lines and headers are those of each file."""
    columns = {role: [(one and one.value, one and one.u) for one in column.readings]
               for role, column in readings.columns.items()}  # fmt: skip
    return columns, readings.runs


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
        (f"# u_time: 33.333333333333336 %\n{HEAD}20,15.0,206,7.06,1/3\n", {}),
        ("mass [g],position [cm],spin [rpm],time [s],half turns\n20.1,14.8,212,21.01,2\n40.3,14.8,398,19.76,3\n", {}),
        (f"# position_from: tip\n# rod_length: 25.0 cm\n{HEAD}20.1,10.2,212,7.00,1/3\n", {}),
        ("mass [g],position [cm],spin [rpm],t(1/3 rev) [s],t(2/3 rev) [s]\n20,15,212,6.95,13.9\n40,15,398,6.71,\n", {}),
        ("# position_from: surface\n# ball_diameter: 10.16 cm\n" + HEAD + "20.1,-9.72,300,9.9,1/3\n", {}),
    ],
)  # fmt: skip
def test_log_written_by_the_tool_has_the_same_readings(log, given):
    readings = read_log(log, settings=given)
    assert readings.ok
    again = read_log(write_log(readings))
    assert read_of(again) == read_of(readings)
    assert again.origin_u == pytest.approx(readings.origin_u, rel=0.01)


def test_decimal_commas_become_points_that_part_no_thousands():
    log = f"{HEAD.replace(',', ';')}40,3;14,8;389,665;4,88764;1/2\n20,1;114,985;212,4;6,951;1/3\n"
    again = read_log(write_log(read_log(log)))
    assert not again.diagnostics
    assert again.columns["spin"].values[0] == pytest.approx(389.665 * math.pi / 30)
