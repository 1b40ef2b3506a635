"""What the reader understands, refuses, fills in and asks about, and every way in which a log comes to it."""

import gzip
import io
import math
import sys

import pytest

from gyrodata.readings import Uncertainty, read_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,206,7.06,1/3\n"
RUNS = HEAD + ROW * 3
RPM = 2 * math.pi / 60


def codes(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics]


def column(readings, role):
    return list(readings.columns[role].values)


def test_plain_log_is_read_with_its_constants():
    readings = read_log("# station: 3\n# g: 9.803 m/s^2\n# u_position: 0.5 mm\n" + HEAD + ROW + "0,,401,160.2,1/3\n")
    assert readings.diagnostics == ()
    assert (readings.metadata, readings.constants) == ({"station": "3"}, {"g": 9.803})
    assert readings.uncertainties == {"u_position": Uncertainty(0.0005)}
    assert (column(readings, "mass"), column(readings, "position")) == ([0.02, 0.0], [0.15, None])
    assert (readings.runs, readings.lines) == (("1", "2"), (5, 6))


def test_wrong_cell_is_shown_with_its_place():
    readings = read_log(HEAD.replace(",", ", ") + "20, 15.0, 56O, 13.06, 1/3\n", name="data.csv")
    assert str(readings.diagnostics[0]) == (
        'data.csv:2:11: error G203: spin "56O" is not a number\n'
        "   20, 15.0, 56O, 13.06, 1/3\n"
        "             ^^^  did you mean 560?"
    )


OTHER_TIME = HEAD.replace("time [s],turns", "{}")
BY_SYMBOL = OTHER_TIME.format('"T, с","t, с",N') + "20,15,400,93.1,46.55,2\n20,15,400,36.5,36.5,1\n"


@pytest.mark.parametrize(
    ("log", "code", "words"),
    [
        # What may mean two things is asked about.
        (HEAD.replace("spin [rpm]", "ω (s⁻¹)") + ROW, "G208", "rev/s"),
        (OTHER_TIME.format("T (s)") + "20,15,400,39\n", "G207", '--map time="T (s)"'),
        (OTHER_TIME.format("T (s)") + "20,15,400,39\n", "G207", "--set turns"),
        (OTHER_TIME.format("T/2 (s)") + "20,15,400,19.6\n", "G301", '--map time="T/2 (s)" --set turns=1/2'),
        (OTHER_TIME.format("T_P_1 [s]") + "20,15,400,39\n", "G301", '--map precession_period="T_P_1 [s]"'),
        (BY_SYMBOL, "G231", ""),
        ("# m1 = 47 g\n" + RUNS, "G305", "# mass: 47 g"),
        # What is missing is asked for with every way to give it.
        *(("positon [cm],spin [rpm],time [s]\n15,400,7\n", "G301", way) for way in (
            '--set mass="20 g"', 'is it "positon [cm]"?')),
        (OTHER_TIME.format("time [s]") + "20,15,400,7\n", "G301", "--set turns=1"),
        ("mass,position,spin,time,turns\n[g],[cm],[rpm],[s],\n,15,400,7,1\n20,15,400,7,1\n", "G219", ""),
        # Cells that are no numbers.
        *((HEAD + f"20,15.0,206,7.06,{cell}\n", code, hint) for cell, code, hint in (
            ("5-Apr", "G204", "4/5"), ("l/3", "G203", "1/3"), ("1 000", "G203", "thousands"),
        )),
        ("# u_tme: 0.2 s\n" + RUNS, "G305", "u_time"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_named_with_a_remedy(log, code, words):
    assert any(words in one.hint for one in read_log(log).diagnostics if one.code == code)


@pytest.mark.parametrize(
    ("log", "role", "values"),
    [
        (HEAD.replace("spin [rpm]", "spin") + "20,15,0.1 s per turn,7,1\n", "spin", [20 * math.pi]),
        *((HEAD + f"20,15.0,206,{cell},1\n", "time", [value]) for cell, value in (
            ("03:36.26", 216.26), ('"7,06"', 7.06), ("7060 ms", 7.06), ("1½", 1.5),
        )),
        (HEAD + "20,−15.0,206,7,1\n", "position", [-0.15]),
        ('mass [g],position [cm],spin [rpm],"t, c",N,"T, c"\n20,15,400,39,1,39\n', "precession_period", [39.0]),
        # Blank cells are filled down.
        (HEAD + ROW + ",,,7.2,1/3\n40,,500,7.3,1/3\n,,,7.3,1/3\n", "mass", [0.02, 0.02, 0.04, 0.04]),
        # A dash without a position is no weight; with one it says "as above".
        (RUNS + ROW * 3 + "-,-,401,160,1/12\n", "mass", [0.02] * 6 + [0.0]),
        (OTHER_TIME.format("T Ω(180°) (s)") + "20,15,400,19.6\n", "turns", [0.5]),
        (OTHER_TIME.format("t(1/3 rev) [s],t(2/3 rev) [s]") + "20,15,400,6.6,13.1\n40,15,400,,6.6\n", "turns",
         [1 / 3, 2 / 3, 2 / 3]),
        (BY_SYMBOL.replace('"T, с","t, с"', '"t, с","T, с"'), "time", [93.1, 36.5]),
        # Rows that are no runs, and derived columns that are not clean, stop nothing.
        (HEAD + ROW + "20,15.0,300,-,1/3\n,,,,\n\n#20,15.0,400,9,1/3\n", "time", [7.06]),
        (HEAD.strip() + ',"Ω, с^-1","ε_T, %",T [s],I,torque [furlong]\n20,15.0,206,7.06,1/3,x,1,21.2,-,?\n',
         "precession_period", [21.2]),
    ],
)  # fmt: skip
def test_cell_has_its_value(log, role, values):
    readings = read_log(log)
    assert readings.ok, readings.diagnostics
    assert column(readings, role) == pytest.approx(values, rel=1e-14)


def test_repeats_in_columns_become_runs():
    head = "run,mass [g],position [cm],spin [rpm],time_1 [s],time_2 [s],turns\n"
    readings = read_log(head + "a,20,15,400,7,7.1,1\nb,20,15,400,7,,1\n")
    assert (readings.runs, readings.lines) == (("a.1", "a.2", "b"), (2, 2, 3))


@pytest.mark.parametrize(
    ("line", "value", "u"),
    [
        (",I_zz,4.4e-3 ± 1e-4 kg m^2,,", 4.4e-3, 1e-4),
        (",,,,I_zz: 4.4e-3 kg m^2", 4.4e-3, None),
    ],
)
def test_result_in_a_row_of_the_table_is_what_is_reported(line, value, u):
    readings = read_log(f"{RUNS}{line}\n")
    assert (readings.diagnostics, len(readings.runs)) == ((), 3)
    assert (readings.reported["inertia"].value, readings.reported["inertia"].u) == (value, u)


def test_a_fault_is_said_once_where_blank_cells_repeat_it():
    readings = read_log(HEAD + "20,15.0,56O,7.06,1/3\n,,,7.1,1/3\n,,400,7.1,1/3\n")
    assert [code for code in codes(readings) if code != "G217"] == ["G203"]


def test_option_wins_over_line_and_column():
    body = "mass [g],time [s],turns\n20,7.06,1/3\n,13.06,\n"
    readings = read_log("# turns: 2/3\n# spin: 400 rpm\n" + body, settings={"spin": "10 Hz", "position": "5 cm"})
    assert readings.ok
    assert column(readings, "turns") == [1 / 3, 2 / 3]
    assert column(readings, "spin") == pytest.approx([20 * math.pi] * 2)
    replaced = read_log(RUNS, settings={"spin": "400 rpm"})
    assert (codes(replaced), column(replaced, "spin")[0]) == (["G304"], pytest.approx(400 * RPM))


def test_log_is_the_same_in_every_way_in(tmp_path, monkeypatch):
    data = (HEAD + ROW).encode()
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    with path.open() as text:
        ways = [read_log(s) for s in (path, str(path), data, RUNS[: len(data)], io.BytesIO(data), text,
                                      gzip.compress(data), "-")]  # fmt: skip
    assert len({(way.columns["spin"].readings, way.runs) for way in ways}) == 1
    names = ["log.csv", "log.csv", "<bytes>", "<text>", "<stream>", "log.csv", "<bytes>", "<stdin>"]
    assert [way.name for way in ways] == names
