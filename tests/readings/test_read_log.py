"""What the reader understands, refuses, fills in and asks about, and every way in which a log comes to it."""

import datetime
import gzip
import io
import math
import subprocess
import sys

import pytest

from gyrodata.errors import InputError
from gyrodata.readings import Uncertainty, blank_log, read_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,206,7.06,1/3\n"
RUNS = HEAD + ROW * 3
RPM = 2 * math.pi / 60


def codes(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics]


def column(readings, role):
    return list(readings.columns[role].values)


def refused(source, **options):
    with pytest.raises(InputError) as caught:
        read_log(source, **options)
    return caught.value.diagnostics[-1]


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


@pytest.mark.parametrize(
    ("log", "code", "words"),
    [
        # What may mean two things is asked about.
        *((HEAD.replace(",", ";").replace("spin [rpm]", header) + ROW.replace(",", ";"), "G208", "rev/s")
          for header in ("spin [1/s]", "spin, с^-1", "ω (s⁻¹)")),
        ("mass [g],position [cm],spin [rpm],T (s),turns\n20,15,400,39,1\n", "G207", '--map time="T (s)"'),
        *((f"mass [g],position [cm],{first} [rad/s],time [s],turns\n20,15,40,7,1/3\n", "G207", "") for first in
          ("w_0", "w_1", "ω1")),
        (HEAD + "20,15.0,5 1/s,7,1\n", "G208", "rev/s"),
        (HEAD + "20,15.0,5 kg,7,1\n", "G205", ""),
        # What is missing is asked for with every way to give it.
        *(("positon [cm],spin [rpm],time [s]\n15,400,7\n", "G301", way) for way in (
            '--set mass="20 g"', 'is it "positon [cm]"?')),
        ("mass [g],position [cm],spin [rpm],time [s]\n20,15,400,7\n", "G301", "--set turns=1"),
        (HEAD + ROW + "20,15,400,13,1/3\n20,15,,19,1/3\n", "G218", "put # before the line"),
        (HEAD + ROW + "0,,400,99,1/3\n40,,400,7,1/3\n", "G302", ""),
        ("mass,position,spin,time,turns\n[g],[cm],[rpm],[s],\n,15,400,7,1\n20,15,400,7,1\n", "G219", ""),
        # Cells that are no numbers.
        *((HEAD + f"20,15.0,206,7.06,{cell}\n", code, hint) for cell, code, hint in (
            ("5-Apr", "G204", "4/5"), ("2026-03-25", "G204", ""), ("l/3", "G203", "1/3"), ("1/0", "G203", ""),
            ("NaN", "G203", "put # before the line"), ("inf", "G203", ""), ("1e400", "G203", ""),
            ("1e-400", "G203", ""), ("1 000", "G203", "thousands"), ("1ª", "G203", "how many"), ("1_000", "G203", ""),
            ("0", "G215", ""), ("-1", "G215", ""),
        )),
        # Tables of another shape.
        ("mass [g],20,40\nposition [cm],15,15\ntime [s],7,8\n", "G213", ""),
        (HEAD + ROW + HEAD.replace("[g]", "[kg]") + ROW, "G212", ""),
        ("m=335 g,,m=273 g,\nN,t,N,t\n1,2,3,4\n", "G211", ""),
        ("N,t [s],N.1,t [s].1\n1,2,3,4\n", "G211", ""),
        (ROW * 3, "G201", ""),
        ("1,2,3\n" + RUNS, "G201", ""),
        ("# " + HEAD + ROW, "G201", ""),
        (HEAD, "G202", ""),
        (HEAD.replace("mass [g]", "time [s]") + ROW, "G210", ""),
        (HEAD + "20,15,0,206,7.06,1/3\n", "G209", ""),
        ("# mass: 20 g\n" + HEAD + ROW + "# mass: 40 g\n" + ROW, "G307", ""),
        (HEAD.strip() + ",angle [deg]\n20,15.0,206,7.06,1/3,90\n", "G303", ""),
        (HEAD.strip() + ",note\n20,15,5,206,7,1\n", "G229", ""),
        # Lines above.
        ("# u_tme: 0.2 s\n" + RUNS, "G305", "u_time"),
        ("# Masse: 20 g\n" + RUNS, "G305", ""),
        *((f"# balance_{line}\n{RUNS}", "G306", "") for line in (
            "tilt: 3 deg in 0 s", "tilt: 3 deg", "drift: 5 deg in 60 s at 0 rpm", "drift: 5 deg in 0 s at 400 rpm")),
        (HEAD.strip() + ",u_time [furlong]\n" + "20,15,400,7,1,0.2\n" * 2, "G205", ""),
        (RUNS + ",,,,I_zz\n", "G214", ""),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_named_with_a_remedy(log, code, words):
    told = [one for one in read_log(log).diagnostics if one.code == code]
    assert told
    assert any(words in one.hint for one in told)


@pytest.mark.parametrize(
    ("log", "role", "values"),
    [
        *((HEAD.replace("spin [rpm]", header) + f"20,15,{cell},7,1\n", "spin", [20 * math.pi]) for header, cell in (
            ("spin [Hz]", "10"), ("spin [rpm]", "600"), ("spin [rpm]", "10 Hz"), ("spin", "0.1 s per turn"),
            ("N (rpm)", "600"), ("об/мин", "600"), ("Rev/min", "600"),
        )),
        *((HEAD + f"20,15.0,206,{cell},1\n", "time", [value]) for cell, value in (
            ("03:36.26", 216.26), ("1:00:00.0", 3600.0), ('"7,06"', 7.06), ("7.06 s", 7.06), ("7060 ms", 7.06),
            ("7.06±0.3", 7.06), ("(7.06 +/- 0.3) s", 7.06), ("1.234", 1.234), ('"0,234"', 0.234), (".5", 0.5),
            ("1.2e-1", 0.12), ("½", 0.5), ("1½", 1.5), ("7", 7.0),
        )),
        (HEAD + "20,−15.0,206,7,1\n", "position", [-0.15]),
        ('mass [g],position [cm],spin [rpm],"t, c",N,"T, c"\n20,15,400,39,1,39\n', "precession_period", [39.0]),
        ("m,x,N,t,n\n[g],[cm],,[s],[rpm]\n20,15,1/3,7,600\n", "spin", [20 * math.pi]),
        # Blank cells are filled down.
        (HEAD + ROW + ",,,7.2,1/3\n40,,500,7.3,1/3\n,,,7.3,1/3\n", "mass", [0.02, 0.02, 0.04, 0.04]),
        # A dash without a position is no weight; with one it says "as above".
        (RUNS + ROW * 3 + "-,-,401,160,1/12\n", "mass", [0.02] * 6 + [0.0]),
        (RUNS + ROW * 3 + "-,15.0,401,6.7,1/3\n", "mass", [0.02] * 7),
        ("m/g,x in cm,n / rpm,t_s,turns\n20,15.0,206,7.06,1/3\n", "mass", [0.02]),
        *((f"mass,position,spin,time,turns\n{units}\n20,15.0,206,7.06,1/3\n", "position", [0.15])
          for units in ("g,cm,rpm,s,", "[g],(cm),[rpm],(s),", "( g ),[ cm ],rpm,[s],()")),
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
        ("I_zz,4.4e-3 kg m^2,,,", 4.4e-3, None),
        (",I_zz,4.4e-3 ± 1e-4 kg m^2,,", 4.4e-3, 1e-4),
        (",,,,I_zz: 4.4e-3 kg m^2", 4.4e-3, None),
    ],
)
def test_result_in_a_row_of_the_table_is_what_is_reported(line, value, u):
    readings = read_log(f"{RUNS}{line}\n")
    assert (readings.diagnostics, len(readings.runs)) == ((), 3)
    assert (readings.reported["inertia"].value, readings.reported["inertia"].u) == (value, u)


def test_each_fault_is_said_once():
    readings = read_log(HEAD + "20 kg,15.0 g,206,7.06 h,2 rad\n20,15.0,5 1/s,7,1\n20,15.0,1/s,7,1\n")
    assert sorted(codes(readings)) == ["G205", "G205", "G208", "G208"]
    filled_down = read_log(HEAD + "20,15.0,56O,7.06,1/3\n,,,7.1,1/3\n,,400,7.1,1/3\n")
    assert [code for code in codes(filled_down) if code != "G217"] == ["G203"]


# --- options ------------------------------------------------------------------------------------------------


def test_option_wins_over_line_and_column(tmp_path):
    body = "mass [g],time [s],turns\n20,7.06,1/3\n,13.06,\n"
    readings = read_log("# turns: 2/3\n# spin: 400 rpm\n" + body, settings={"spin": "10 Hz", "position": "5 cm"})
    assert readings.ok
    assert column(readings, "turns") == [1 / 3, 2 / 3]
    assert column(readings, "spin") == pytest.approx([20 * math.pi] * 2)
    replaced = read_log(RUNS, settings={"spin": "400 rpm"})
    assert (codes(replaced), column(replaced, "spin")[0]) == (["G304"], pytest.approx(400 * RPM))
    path = tmp_path / "station.toml"
    path.write_text('g = "9.81 m/s^2"\nturns = 1\n')
    assert read_log(RUNS, settings={"g": "9.8 m/s^2"}, config=path).constants["g"] == 9.81


def test_option_that_makes_no_sense_is_refused():
    assert "turns" in refused(RUNS, settings={"trns": "1"}).hint
    assert "time [s]" in refused(RUNS, mapping={"time": "Zeit"}).hint
    assert refused(RUNS, mapping={"tme": "time [s]"}).code == "G503"
    assert refused(RUNS, settings={"spin": "400"}).code == "G504"


# --- every way in -------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be", "cp1251", "koi8-r"])
def test_log_is_read_in_every_encoding(encoding):
    text = "Масса груза, г;Плечо, см;Частота вращения, об/мин;Время, с;Число оборотов\r\n20;15,0;406;39,2;1\r\n"
    readings = read_log(("\ufeff" + text if encoding == "utf-16-be" else text).encode(encoding))
    assert set(readings.columns) == {"mass", "position", "spin", "time", "turns"}
    assert codes(readings) == (["G109"] if encoding in ("cp1251", "koi8-r") else [])


def test_dataframe_is_read_as_its_cells_were_typed():
    import pandas as pd

    columns = {
        "mass [g]": [20, 40],
        "position [cm]": [15.0, 15.5],
        "spin [rpm]": [206.0, None],
        "time [s]": [7.06, 9.1],
    }
    frame = pd.DataFrame(columns | {"turns": ["1/3", "2/3"]})
    frame.attrs["g"] = "9.8 m/s^2"
    readings = read_log(frame)
    assert (readings.name, readings.constants) == ("<table>", {"g": 9.8})
    assert column(readings, "mass") == [0.02, 0.04]
    assert column(readings, "spin") == [206 * RPM] * 2
    single = read_log(frame.astype({"mass [g]": "float32"}))
    assert [one.text for one in single.columns["mass"].readings] == ["20", "40"], "a whole number has no point"


def test_workbook_is_read_with_its_times():
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"])
    book.active.append([20, 15.5, 206, 7.06, "1/3"])
    book.active.append([20, 15.5, 206, datetime.time(0, 3, 36, 260000), 1])
    stream = io.BytesIO()
    book.save(stream)
    assert column(read_log(stream.getvalue()), "time") == [7.06, 216.26]


def test_reading_loads_neither_pandas_nor_numpy_nor_pint():
    code = (
        f"import sys; from gyrodata.readings import read_log; assert read_log({RUNS!r}).ok; "
        "print([m for m in ('pint', 'numpy', 'pandas', 'openpyxl') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_blank_log_filled_in_has_no_diagnostic():
    blank = blank_log(("0.5 g", "40 g", "60 g"), "15 cm", ("0.5 rpm", "400 rpm", "600 rpm")).splitlines()
    start = next(i for i, line in enumerate(blank) if line.startswith("mass"))
    assert blank[start + 1] == "0.50,15.0,,,,,aim at 0.5 rpm"
    rows = [line.split(",") for line in blank[start + 1 :]]
    filled = [",".join([*row[:2], "406", "13.06", "1/3", *row[5:]]) for row in rows]
    readings = read_log("\n".join([*blank[: start + 1], *filled]))
    assert (readings.diagnostics, readings.balanced, len(readings.runs)) == ((), None, 11)
    assert (column(readings, "mass")[5], column(readings, "position")[5]) == (0, None)
    with pytest.raises(InputError, match="not above zero"):
        blank_log(("20 g",), "15 cm", ("-5 rpm",))
