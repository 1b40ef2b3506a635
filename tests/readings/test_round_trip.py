"""What the tool writes of a log is read as the log itself."""

import csv
import io
import math

import pytest
from typer.testing import CliRunner

import gyrodata
from gyrodata.cli import app
from gyrodata.readings import read_log, write_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"


def read_of(readings):
    """What the analysis uses; places, lines and headers are those of each file."""
    columns = {
        role: [(one and one.value, one and one.u) for one in column.readings]
        for role, column in readings.columns.items()
    }
    return columns, readings.runs


RICH = """# station: 3
# g: 9.803 m/s^2
# u_position: 0.5 mm
# u_spin: 0.2 % + 0.5 rpm
# u_mass_scale: 0.07 %
# balance_tilt: 3 deg in 10 s
# balance_drift: 5 deg in 60 s at 400 rpm
# balanced: nein
# latitude: -33.9 deg
# weight_diameter: 3.0 ± 0.1 cm
# u_angle: 2 deg
# pitch: 2 deg
run;mass [g];position [cm];spin_start [rpm];spin_end [rpm];time_1 [s];time_2 [s];turns;u_time [s];spin_sense;note
a;20;15,0±0,1;410;400;7,06;7,10;1/3;0,2;ccw;first, with a comma
b;;;610;600;10,01;;1/3;;cw;"a ""quoted"" word"
c;0;;405±3;400;160,2;;1/3;1 %;ccw;
d;40;-15,0;600;590;03:36,26;3:40,5;2/3;0,3;ccw;#4
"""  # noqa: E501


@pytest.mark.parametrize(
    ("log", "given"),
    [
        (RICH, {}),
        (
            "# turns: 2/3\nmass [g],time [s],turns\n20,7.06,1/3\n,13.06,\n",
            {"spin": "10 Hz", "position": "-5 cm", "u_time": "0.1 s"},
        ),
        (f"# u_time: 33.333333333333336 %\n{HEAD}20,15.0,206,7.06,1/3\n", {}),
        (
            (
                "mass [g],position [cm],spin [rpm],time [s],half turns\n"
                "20.1,14.8,212,21.01,2\n40.3,14.8,398,19.76,3\n"
            ),
            {},
        ),
        (
            f"# position_from: tip\n# rod_length: 25.0 cm\n{HEAD}20.1,10.2,212,7.00,1/3\n",
            {},
        ),
        (
            (
                "mass [g],position [cm],spin [rpm],t(1/3 rev) [s],t(2/3 rev) [s]\n"
                "20,15,212,6.95,13.9\n40,15,398,6.71,\n"
            ),
            {},
        ),
        (
            "# position_from: surface\n# ball_diameter: 10.16 cm\n"
            + HEAD
            + "20.1,-9.72,300,9.9,1/3\n",
            {},
        ),
    ],
)
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


UNKNOWN = '''\
run;mass [g];battery [V];position [cm];spin [rpm];"a; b";time_1 [s];time_2 [s];turns;note;remarks;"say ""x"""
a;20;1,5;15,0;410;well, "quite";7,06;7,10;1/3;first, with a comma;"a; b";#1
b;;1.6;;610;;10,01;;1/3;;;
c;0;?;;405;n/a;160,2;;1/3;;z;"one, ""two"""
d;40;;-15,0;600;=1+1;6,9;;1/3;#4;;-
'''  # noqa: E501


def cells_of(text: str) -> dict[str, list[str]]:
    """The columns of a written log."""
    rows = list(csv.reader(line for line in text.splitlines() if line[0] != "#"))
    return {header: [row[at] for row in rows[1:]] for at, header in enumerate(rows[0])}


def test_columns_that_are_not_known_are_kept_as_they_are():
    readings = read_log(UNKNOWN)
    assert readings.ok
    written = write_log(readings)
    columns = cells_of(written)
    assert columns["battery [V]"] == ["1,5", "", "1.6", "?", ""]
    assert columns["a; b"] == ['well, "quite"', "", "", "n/a", "=1+1"]
    assert columns["remarks"] == ["a; b", "", "", "z", ""]
    assert columns['say "x"'] == ["#1", "", "", 'one, "two"', "-"]
    assert columns["note"][0] == "first, with a comma"
    again = read_log(written)
    assert read_of(again) == read_of(readings)
    assert again.notes == readings.notes
    assert write_log(again) == written


FIVE = """mass [g];position [cm];spin [rpm];time [s];turns
20;15,0;206;7,06;1/3
20;15,0;396;13,0;1/3
40;15,0;209;7,0;2/3
40;15,0;610;20,2;2/3
60;15,0;600;19,9;1
"""
STRANGE = ("battery [V]", "comment", "P [bar]", "room [C]", "weather, today", "who?")


@pytest.mark.slow
@pytest.mark.parametrize("header", STRANGE)
def test_fixed_log_has_the_same_answer_and_the_column(header, tmp_path):
    cells = ["1.50", "", "two words", 'so "quoted"', "a;b,c"]
    text = io.StringIO()
    rows = [row.split(";") for row in FIVE.splitlines()]
    writer = csv.writer(text, delimiter=";", lineterminator="\n")
    writer.writerows(
        [*row, cell] for row, cell in zip(rows, [header, *cells], strict=True)
    )
    log, fixed = tmp_path / "log.csv", tmp_path / "log-fixed.csv"
    log.write_text(text.getvalue(), encoding="utf-8")
    done = CliRunner().invoke(app, ["check", "--fix", str(log)])
    assert done.exit_code in (0, 1), done.output
    written = cells_of(fixed.read_text(encoding="utf-8"))
    assert written["note" if header == "comment" else header] == cells
    before, after = gyrodata.analyze(log), gyrodata.analyze(fixed)
    assert (after.inertia.value, after.inertia.u) == (
        before.inertia.value,
        before.inertia.u,
    )


def test_a_line_ends_where_editors_end_it() -> None:
    for end in ("\u2028", "\x0b", "\x0c", "\x85"):
        head = f"# nice{end}day\nmass [g],position [cm],spin [rpm],time [s],turns\n"
        rows = "20,15,400,13.0,1/3\n20,15,500,,1/3\n"
        text = write_log(read_log(head + rows))
        assert "# left out: 20,15,500,,1/3" in text
        assert "\n20,15,400,13.0,1/3" in text


@pytest.mark.parametrize("count", [7, 8, 20])
def test_a_weight_that_only_one_run_repeats_is_written(count: int) -> None:
    head = "mass [g],position [cm],spin [rpm],time_1 [s],time_2 [s],turns\n"
    rows = [f"20,15,{400 + 10 * i},{13 + 0.3 * i:.1f},,1/3\n" for i in range(count)]
    rows[0] = rows[0].replace(",,", ",13.1,")
    log = read_log(head + "".join(rows))
    assert log.ok
    again = read_log(write_log(log))
    assert again.ok
    assert len(again.runs) == len(log.runs)
