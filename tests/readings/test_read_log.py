"""What the reader understands, refuses, fills in and asks about."""

import gzip
import io
import math
import subprocess
import sys

import pytest
from columns import of, shared

from gyrodata.errors import InputError
from gyrodata.readings import Place, Uncertainty, blank_log, read_log, with_uncertainties

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,206,7.06,1/3\n"
RPM = 2 * math.pi / 60


def codes(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics]


def refused(source, **options):
    with pytest.raises(InputError) as caught:
        read_log(source, **options)
    return caught.value.diagnostics[-1]


def test_a_plain_log():
    readings = read_log("# station: 3\n# g: 9.803 m/s^2\n# u_position: 0.5 mm\n" + HEAD + ROW + "0,,401,160.2,1/3\n")
    assert readings.ok
    assert readings.diagnostics == ()
    assert readings.metadata == {"station": "3"}
    assert readings.constants == {"g": 9.803}
    assert readings.uncertainties == {"u_position": Uncertainty(0.0005)}
    mass, position, turns = (readings.columns[role] for role in ("mass", "position", "turns"))
    assert mass.values == (0.02, 0.0)
    assert of(mass, "step") == (0.001, None)
    assert (mass.steps, turns.steps) == ((0.001, 0.0), (0.0, 0.0))
    assert position.values == (0.15, None)
    assert of(position, "u") == (Uncertainty(0.0005), None)
    assert position.place(0) == Place(5, 4)
    assert turns.values == (1 / 3, 1 / 3)
    assert of(turns, "step") == (None, None)
    assert readings.columns["spin"].values[0] == pytest.approx(206 * RPM)
    assert readings.runs == ("1", "2")
    assert readings.lines == (5, 6)


def test_the_example_of_a_wrong_cell():
    readings = read_log(HEAD.replace(",", ", ") + "20, 15.0, 56O, 13.06, 1/3\n", name="data.csv")
    assert str(readings.diagnostics[0]) == (
        'data.csv:2:11: error G203: spin "56O" is not a number\n'
        "   20, 15.0, 56O, 13.06, 1/3\n"
        "             ^^^  did you mean 560?"
    )


def test_the_same_spin_in_every_form():
    spins = [
        read_log(HEAD.replace("spin [rpm]", header) + f"20,15,{cell},7,1\n").columns
        for header, cell in [
            ("spin [Hz]", "10"),
            ("spin [rpm]", "600"),
            ("spin [rpm]", "10 Hz"),
            ("spin", "0.1 s per turn"),
            ("N (rpm)", "600"),
            ("об/мин", "600"),
        ]
    ]
    assert [columns["spin"].values[0] for columns in spins] == pytest.approx([20 * math.pi] * 6)
    period = read_log(HEAD.replace("spin [rpm]", "spin [s/rev]") + "20,15,0.1,7,1\n").columns
    assert period["spin_period"].values == (0.1,)


@pytest.mark.parametrize("header", ["spin [1/s]", "spin, с^-1", "ω (s⁻¹)"])
def test_a_bare_per_second_is_asked_about(header):
    text = HEAD.replace(",", ";").replace("spin [rpm]", header) + ROW.replace(",", ";")
    readings = read_log(text)
    assert codes(readings) == ["G208"]
    assert "rev/s" in readings.diagnostics[0].hint


def test_a_header_that_fits_two_roles_is_asked_about():
    readings = read_log("mass [g],position [cm],spin [rpm],T (s),turns\n20,15,400,39,1\n")
    assert codes(readings) == ["G207"]
    assert '--map time="T (s)"' in readings.diagnostics[0].hint
    assert '--map precession_period="T (s)"' in readings.diagnostics[0].hint
    beside = read_log('mass [g],position [cm],spin [rpm],"t, c",N,"T, c"\n20,15,400,39,1,39\n')
    assert beside.ok
    assert beside.columns["precession_period"].values == (39.0,)
    bare = read_log("m,x,N,t,n\n[g],[cm],,[s],[rpm]\n20,15,1/3,7,400\n")
    assert bare.ok
    assert (bare.columns["turns"].values, bare.columns["spin"].unit) == ((1 / 3,), "rpm")


@pytest.mark.parametrize("first", ["w_0", "w_1", "ω1"])
def test_numbered_rates_in_radians_may_be_the_precession(first):
    readings = read_log(f"mass [g],position [cm],{first} [rad/s],time [s],turns\n20,15,40,7,1/3\n")
    assert "G207" in codes(readings)
    pair = read_log("mass [g],position [cm],ω0 RPM,ω1 RPM,time [s],turns\n20,15,410,400,7,1/3\n")
    assert pair.ok
    assert codes(pair) == ["G220"]


def test_missing_quantities_show_every_way_to_give_them():
    readings = read_log("positon [cm],spin [rpm],time [s]\n15,400,7\n")
    missing = {d.message.split()[0]: d for d in readings.diagnostics if d.code == "G301"}
    assert list(missing) == ["mass", "position", "turns"]
    for role, way in [
        ("mass", '--set mass="20 g"'),
        ("turns", "--set turns=1"),
        ("turns", "# turns: 1"),
        ("turns", "--map turns=HEADER"),
    ]:
        assert way in missing[role].hint
    assert "positon [cm]" in missing["mass"].message
    assert missing["position"].hint.startswith('is it "positon [cm]"?')


def test_repeats_become_runs_that_share_their_setting():
    readings = read_log(
        "run,mass [g],position [cm],spin [rpm],time_1 [s],time_2 [s],turns\na,20,15,400,7,7.1,1\nb,20,15,400,7,,1\n"
    )
    assert readings.runs == ("a.1", "a.2", "b")
    assert shared(readings.columns["mass"]) == (0, 0, 1)
    assert shared(readings.columns["time"]) == (0, 1, 2)
    assert readings.lines == (2, 2, 3)


def test_filling_down():
    readings = read_log(HEAD + ROW + ",,,7.2,1/3\n,,,7.3,1/3\n40,,500,7.3,1/3\n,,,7.3,1/3\n")
    assert readings.ok
    assert shared(readings.columns["mass"]) == (0, 0, 0, 1, 1)
    assert shared(readings.columns["position"]) == (0,) * 5
    assert codes(readings) == ["G217"] * 3
    assert "lines 3-4, 6" in readings.diagnostics[0].message


def test_a_single_blank_spin_was_forgotten():
    readings = read_log(HEAD + ROW + "20,15,400,13,1/3\n20,15,,19,1/3\n")
    assert codes(readings) == ["G218"]
    assert not readings.ok


def test_never_filled_across_a_run_without_a_weight():
    readings = read_log(HEAD + ROW + "0,,400,99,1/3\n40,,400,7,1/3\n")
    assert codes(readings) == ["G302"]
    assert "position" in readings.diagnostics[0].message


def test_never_filled_from_below_or_from_the_units():
    readings = read_log("mass,position,spin,time,turns\n[g],[cm],[rpm],[s],\n,15,400,7,1\n20,15,400,7,1\n")
    assert codes(readings) == ["G219"]


def test_constants_of_the_log():
    body = "mass [g],time [s],turns\n20,7.06,1/3\n,13.06,\n"
    readings = read_log("# turns: 2/3\n# spin: 400 rpm\n" + body, settings={"spin": "10 Hz", "position": "5 cm"})
    assert readings.ok
    assert readings.columns["turns"].values == (1 / 3, 2 / 3)
    assert readings.columns["turns"].place(1) == Place(1, 10)
    assert readings.columns["spin"].values[0] == pytest.approx(20 * math.pi)
    assert readings.columns["spin"].header == "--set spin"
    assert [readings.columns["spin"].place(run) for run in (0, 1)] == [None, None]
    replaced = read_log(HEAD + ROW, settings={"spin": "400 rpm"})
    assert codes(replaced) == ["G304"]
    assert replaced.columns["spin"].values[0] == pytest.approx(400 * RPM)


def test_config_wins_over_set(tmp_path):
    path = tmp_path / "station.toml"
    path.write_text('g = "9.81 m/s^2"\nturns = 1\n')
    readings = read_log(
        "mass [g],position [cm],spin [rpm],time [s]\n20,15,400,7\n", settings={"g": "9.8 m/s^2"}, config=path
    )
    assert readings.ok
    assert readings.constants["g"] == 9.81
    for text, code in [("g = [1]", "G504"), ("g = ", "G505"), ("gg = 1", "G501"), ('g = "fast"', "G504")]:
        path.write_text(text)
        assert refused(HEAD + ROW, config=path).code == code


def test_uncertainties_the_most_specific_wins():
    head = "# u_time: 0.2 s\nmass [g],position [cm],spin [rpm],time (±0.3 s),turns,u_mass [%]\n"
    text = head + "20,15,400±5,7(1),1,1\n20,15,400,7,1,\n"
    columns = read_log(text).columns
    assert of(columns["time"], "u") == (Uncertainty(1.0), Uncertainty(0.3))
    assert of(columns["spin"], "u") == (Uncertainty(5 * RPM), None)
    assert of(columns["mass"], "u") == (Uncertainty(0.0, 0.01), None)


def test_balance():
    readings = read_log("# balance_tilt: 3 deg in 10 s\n# balance_drift: 5 deg in 60 s at 400 rpm\n" + HEAD + ROW)
    assert readings.balance_tilt == pytest.approx((math.radians(3), 10))
    assert readings.balance_drift == pytest.approx((math.radians(5), 60, 400 * RPM))


def test_derived_columns_never_stop_a_log():
    text = HEAD.strip() + ',"Ω, с^-1","ε_T, %",T [s],I,torque [furlong]\n20,15.0,206,7.06,1/3,x,1,21.2,-,?\n'
    readings = read_log(text)
    assert readings.ok
    assert "precession_period" in readings.columns
    assert "precession_rate" not in readings.columns


def test_a_second_column_of_a_role_is_only_compared():
    readings = read_log(
        HEAD.strip() + ",spin speed [rad/s],moment of inertia [kg m^2]\n20,15.0,206,7.06,1/3,21.6,0.0044\n"
    )
    assert [other.role for other in readings.others] == ["spin", "inertia"]


@pytest.mark.parametrize(
    ("cell", "code", "hint"),
    [
        ("5-Apr", "G204", "4/5"),  # or 5/4
        ("2026-03-25", "G204", ""),
        ("l/3", "G203", ""),
        ("1/0", "G203", ""),
        ("NaN", "G203", "put # before the line"),
        ("inf", "G203", "put # before the line"),
        ("1e400", "G203", ""),
        ("1e-400", "G203", ""),
        ("1 000", "G203", "thousands"),
        ("1ª", "G203", "how many"),
        ("1_000", "G203", ""),
        ("0", "G215", ""),
        ("-1", "G215", ""),
    ],
)
def test_cells_that_are_no_numbers(cell, code, hint):
    readings = read_log(HEAD + f"20,15.0,206,7.06,{cell}\n")
    assert codes(readings)[0] == code
    assert hint in readings.diagnostics[0].hint
    assert readings.diagnostics[0].column == 18


@pytest.mark.parametrize(
    ("cell", "value"),
    [
        ("03:36.26", 216.26),
        ("1:00:00.0", 3600.0),
        ('"7,06"', 7.06),
        ("7.06 s", 7.06),
        ("7060 ms", 7.06),
        ("7.06±0.3", 7.06),
        ("(7.06 +/- 0.3) s", 7.06),
        ("1.234", 1.234),
        ('"0,234"', 0.234),
        (".5", 0.5),
        ("1.2e-1", 0.12),
        ("½", 0.5),
        ("1½", 1.5),
        ("7", 7.0),
    ],
)
def test_cells(cell, value):
    assert read_log(HEAD + f"20,15.0,206,{cell},1\n").columns["time"].values == (pytest.approx(value, rel=1e-15),)


def test_a_real_minus_sign():
    assert read_log(HEAD + "20,−15.0,206,7,1\n").columns["position"].values == (-0.15,)


def test_rows_that_are_no_runs():
    readings = read_log(HEAD + ROW + "20,15.0,300,-,1/3\n,,,,\n\n#20,15.0,400,9,1/3\n")
    assert readings.runs == ("1",)
    assert sorted(codes(readings)) == ["G216", "G228"]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("mass [g],20,40\nposition [cm],15,15\ntime [s],7,8\n", "G213"),
        (HEAD + ROW + HEAD.replace("[g]", "[kg]") + ROW, "G212"),
        ("m=335 g,,m=273 g,\nN,t,N,t\n1,2,3,4\n", "G211"),
        ("N,t [s],N.1,t [s].1\n1,2,3,4\n", "G211"),
        (ROW * 3, "G201"),
        ("# " + HEAD + ROW, "G201"),
        (HEAD, "G202"),
        (HEAD.replace("mass [g]", "time [s]") + ROW, "G210"),
        (HEAD + "20,15,0,206,7.06,1/3\n", "G209"),
        ("# mass: 20 g\n" + HEAD + ROW + "# mass: 40 g\n" + ROW, "G307"),
        (HEAD.strip() + ",angle [deg]\n20,15.0,206,7.06,1/3,90\n", "G303"),
    ],
)
def test_tables_of_another_shape(text, code):
    readings = read_log(text)
    assert codes(readings)[0] == code
    assert not readings.ok


def test_files_of_other_kinds(tmp_path):
    for data, code in [
        (b"\x89PNG\r\n\x1a\n", "G104"),
        (b"%PDF-1.4", "G104"),
        (b"PK\x03\x04", "G104"),
        (b"<html><body>", "G104"),
        (b"", "G103"),
        (b" \n\t\n", "G103"),
        (b"\x1f\x8bgarbage", "G107"),
        (gzip.compress(b"a,b" * 100)[:-9], "G107"),
    ]:
        assert refused(data).code == code
    assert refused(tmp_path).code == "G102"
    assert refused("bad\0name").code == "G102"
    (tmp_path / "data.csv").write_text(HEAD + ROW)
    assert "data.csv" in refused(tmp_path / "dta.csv").hint


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be", "cp1251", "koi8-r"])
def test_encodings(encoding):
    text = "Масса груза, г;Плечо, см;Частота вращения, об/мин;Время, с;Число оборотов\r\n20;15,0;406;39,2;1\r\n"
    data = ("\ufeff" + text if encoding == "utf-16-be" else text).encode(encoding)
    readings = read_log(data)
    assert readings.ok
    assert set(readings.columns) == {"mass", "position", "spin", "time", "turns"}
    assert codes(readings) == (["G109"] if encoding in ("cp1251", "koi8-r") else [])


def test_every_way_in(tmp_path, monkeypatch):
    data = (HEAD + ROW).encode()
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    with path.open() as text:
        ways = [
            read_log(s) for s in (path, str(path), data, HEAD + ROW, io.BytesIO(data), text, gzip.compress(data), "-")
        ]
    assert len({(way.columns["spin"].readings, way.runs) for way in ways}) == 1
    assert [way.name for way in ways] == [
        "log.csv",
        "log.csv",
        "<bytes>",
        "<text>",
        "<stream>",
        "log.csv",
        "<bytes>",
        "<stdin>",
    ]


def test_a_dataframe():
    import pandas as pd

    frame = pd.DataFrame(
        {
            "mass [g]": [20, 40],
            "position [cm]": [15.0, 15.5],
            "spin [rpm]": [206.0, None],
            "time [s]": [7.06, 9.1],
            "turns": ["1/3", "2/3"],
        }
    )
    frame.attrs["g"] = "9.8 m/s^2"
    readings = read_log(frame)
    assert readings.ok
    assert readings.name == "<table>"
    assert readings.constants == {"g": 9.8}
    assert readings.columns["mass"].values == (0.02, 0.04)  # noqa: PD011 (a Column, not a frame)
    assert of(readings.columns["position"], "step") == (0.001, 0.001)
    assert shared(readings.columns["spin"]) == (0, 0)


def test_workbooks():
    import datetime

    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"])
    book.active.append([20, 15.5, 206, 7.06, "1/3"])
    book.active.append([20, 15.5, 206, datetime.time(0, 3, 36, 260000), 1])
    stream = io.BytesIO()
    book.save(stream)
    readings = read_log(stream.getvalue())
    assert readings.ok
    assert readings.columns["time"].values == (7.06, 216.26)  # noqa: PD011 (a Column, not a frame)


def test_options_that_make_no_sense():
    assert "turns" in refused(HEAD + ROW, settings={"trns": "1"}).hint
    assert "time [s]" in refused(HEAD + ROW, mapping={"time": "Zeit"}).hint
    assert refused(HEAD + ROW, mapping={"tme": "time [s]"}).code == "G503"
    assert refused(HEAD + ROW, settings={"spin": "400"}).code == "G504"
    assert refused(HEAD + ROW, settings={"u_mass_scale": "1 g"}).code == "G504"


def test_misspelt_keys_are_told():
    readings = read_log("# u_tme: 0.2 s\n# Masse: 20 g\n# date: 2026-01-03\n# time: 14:30\n" + HEAD + ROW)
    assert codes(readings) == ["G305", "G305"]
    assert "u_time" in readings.diagnostics[0].hint
    assert set(readings.metadata) == {"u_tme", "Masse", "date", "time"}


def test_reading_loads_neither_pandas_nor_numpy_nor_pint():
    code = (
        "import sys; from gyrodata.readings import read_log; "
        f"assert read_log({HEAD + ROW!r}).ok; "
        "print([m for m in ('pint', 'numpy', 'pandas', 'openpyxl') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_note_that_is_only_a_number_may_be_a_shifted_row():
    readings = read_log(HEAD.strip() + ",note\n20,15,5,206,7,1\n")
    assert "G229" in codes(readings)


def test_a_blank_log_to_fill_in():
    blank = blank_log(("20 g", "40 g", "60 g"), "15 cm", ("200 rpm", "400 rpm", "600 rpm"))
    # The line about the balance may stay blank: then it says nothing.
    assert "# balanced: " in blank.splitlines()
    assert codes(read_log(blank)) == ["G202"]
    lines = blank.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("mass"))
    filled = []
    for line in lines[start + 1 :]:
        cells = line.split(",")
        cells[2:5] = ["406", "13.06", "1/3"]
        filled.append(",".join(cells))
    readings = read_log("\n".join([*lines[: start + 1], *filled]))
    assert readings.diagnostics == ()
    assert readings.balanced is None
    assert len(readings.runs) == 11
    assert readings.columns["mass"].readings[5].text == "0"
    assert readings.columns["position"].values[5] is None  # noqa: PD011 (a Column, not a frame)
    with pytest.raises(InputError):
        blank_log(("20",), "15 cm", ("200 rpm",))


def test_small_weights_and_slow_spins_may_be_aimed_at():
    rows = [
        line for line in blank_log(("0.5 g", "20 g"), "15 cm", ("0.5 rpm", "400 rpm")).splitlines() if line[0].isdigit()
    ]
    assert {row.partition(",")[0] for row in rows} == {"0.50", "20.00", "0"}
    assert rows[0] == "0.50,15.0,,,,,aim at 0.5 rpm"
    for spins in (("0 rpm",), ("-5 rpm",)):
        with pytest.raises(InputError, match="not above zero"):
            blank_log(("20 g",), "15 cm", spins)


@pytest.mark.parametrize(
    ("line", "kept"),
    [
        ("balance_tilt: 3 deg in 0.5 s", True),
        ("balance_tilt: 3 deg in 0 s", False),
        ("balance_tilt: 3 deg", False),
        ("balance_drift: 5 deg in 0.5 s at 400 rpm", True),
        ("balance_drift: 5 deg in 60 s at 1 rad/s", True),
        ("balance_drift: 0 deg in 60 s at 400 rpm", True),
        ("balance_drift: 5 deg in 60 s at 0 rpm", False),
        ("balance_drift: 5 deg in 0 s at 400 rpm", False),
    ],
)
def test_a_balance_test_needs_a_time_and_a_spin(line, kept):
    readings = read_log(f"# {line}\n{HEAD}{ROW}")
    assert ((readings.balance_tilt or readings.balance_drift) is not None) is kept
    assert ("G306" in codes(readings)) is not kept


def test_a_unit_may_stand_for_the_spin_and_names_may_hold_their_units():
    spins = read_log("mass [g],position [cm],Rev/min,time [s],turns\n20,15.0,206,7.06,1/3\n").columns["spin"]
    assert spins.values[0] == pytest.approx(206 * RPM)  # noqa: PD011 (a Column, not a frame)
    held = read_log("m/g,x in cm,n / rpm,t_s,turns\n20,15.0,206,7.06,1/3\n").columns
    assert {role: column.unit for role, column in held.items()} == {
        "mass": "g", "position": "cm", "spin": "rpm", "time": "s", "turns": ""
    }  # fmt: skip


RUNS = HEAD + ROW + ROW.replace("406", "206") + ROW.replace("406", "606")


@pytest.mark.parametrize(
    ("line", "value", "u"),
    [
        ("I_zz,4.4e-3 kg m^2,,,", 4.4e-3, None),
        (",I_zz,4.4e-3 ± 1e-4 kg m^2,,", 4.4e-3, 1e-4),
        ("I_zz = 4.4e-3 kg m^2,,,,", 4.4e-3, None),
        (",,,,I_zz: 4.4e-3 kg m^2", 4.4e-3, None),
    ],
)
def test_a_result_in_a_row_of_the_table_is_what_is_reported(line, value, u):
    readings = read_log(f"{RUNS}{line}\n")
    assert readings.diagnostics == ()
    assert (readings.reported["inertia"].value, readings.reported["inertia"].u) == (value, u)
    assert len(readings.runs) == 3
    assert [d.code for d in read_log(f"{RUNS},,,,I_zz\n").diagnostics] == ["G214"], "a name alone is no result"


def test_numbers_above_the_header_are_asked_about_where_they_may_be_a_run():
    assert codes(read_log("1,2\n" + RUNS)) == ["G214"]
    (found,) = read_log("1,2,3\n" + RUNS).diagnostics
    assert (found.code, found.line) == ("G201", 1)
    assert found.message == "line 1 holds numbers, and stands above the header in line 2"


def test_what_no_column_is_known_for_is_counted():
    def said(names, cells):
        (found,) = read_log(HEAD.strip() + names + "\n" + ROW.strip() + cells + "\n").diagnostics
        return found.message

    assert said(",foo", ",x") == "the column is not used: foo"
    assert said(",foo,bar", ",x,y") == "the columns are not used: foo, bar"


def test_a_cell_is_named_by_its_first_letter():
    head = '"mass [g]","position [cm]",spin [rpm],time [s],turns\n"20",15.0,  abc,7.06,1/3\n'
    for row, column in (('"20",15.0,  abc,7.06,1/3\n', 13), ('"20","15.0", "abc",7.06,1/3\n', 15)):
        (found,) = [d for d in read_log(head.partition("\n")[0] + "\n" + row).diagnostics if d.code == "G203"]
        assert (found.line, found.column) == (2, column)


def test_a_dash_without_a_position_is_no_weight():
    readings = read_log(RUNS + ROW * 3 + "-,-,401,160,1/12\n")
    assert readings.columns["mass"].values[6] == 0  # noqa: PD011 (a Column, not a frame)
    bare = "mass [g],spin [rpm],time [s],turns\n" + "20,206,7,1/3\n" * 5 + "-,401,160,1/12\n"
    assert read_log(bare, settings={"position": "15 cm"}).columns["mass"].values[5] == 0  # noqa: PD011
    above = read_log(RUNS + ROW * 3 + "-,15.0,401,6.7,1/3\n")
    assert above.columns["mass"].values[6] == pytest.approx(0.02)  # noqa: PD011
    assert codes(above) == ["G217"]


def test_units_may_stand_bare_or_in_brackets_below_the_names():
    for units in ("g,cm,rpm,s,", "[g],(cm),[rpm],(s),", "( g ),[ cm ],rpm,[s],()"):
        read = read_log(f"mass,position,spin,time,turns\n{units}\n20,15.0,206,7.06,1/3\n")
        assert {role: column.unit for role, column in read.columns.items()} == {
            "mass": "g", "position": "cm", "spin": "rpm", "time": "s", "turns": ""
        }  # fmt: skip


def test_a_unit_that_may_mean_two_and_one_that_is_none_of_the_kind_are_told_apart():
    assert codes(read_log(HEAD + "20,15.0,5 1/s,7,1\n")) == ["G208"]
    assert codes(read_log(HEAD + "20,15.0,5 kg,7,1\n")) == ["G205"]


def test_every_fault_is_told_once():
    readings = read_log(HEAD + "20 kg,15.0 g,206,7.06 h,2 rad\n20,15.0,5 1/s,7,1\n20,15.0,1/s,7,1\n")
    assert sorted(codes(readings)) == ["G205", "G205", "G208", "G208"]
    without_colon = read_log("# spin 400 rpm\n# angle: 120\nMass m [g],position [cm],time [s]\n20,15,7\n")
    assert sorted(codes(without_colon)) == ["G301", "G305", "G306"]


def test_one_wrong_cell_is_one_message_also_where_it_would_be_filled_down():
    wrong = read_log(HEAD + "20,15.0,56O,7.06,1/3\n,,,7.1,1/3\n,,400,7.1,1/3\n")
    assert [code for code in codes(wrong) if code != "G217"] == ["G203"]
    half = read_log(HEAD.replace("spin", "spin_start [rpm],spin_end") + "20,15,4OO,,7,1\n20,15,400,390,7,1\n")
    assert codes(half) == ["G219", "G203"] or codes(half) == ["G203", "G219"]
    fraction = read_log(HEAD + "20,15.0,560,7.06,l/3\n")
    assert fraction.diagnostics[0].hint == "did you mean 1/3?"


def test_the_unit_of_an_uncertainty():
    columns = read_log(HEAD.strip() + ",u_time\n20,15,400,7,1,0.2\n").columns
    assert of(columns["time"], "u") == (Uncertainty(0.2),)
    wrong = read_log(HEAD.strip() + ",u_time [furlong]\n20,15,400,7,1,0.2\n20,15,400,7,1,0.2\n")
    assert codes(wrong) == ["G205"]


def test_the_uncertainty_of_a_derived_column_is_kept_and_never_stops_a_log():
    head = HEAD.strip() + ",T [s],σ_T [s],Ω [rad/s],σ_Ω [furlong]\n"
    readings = read_log(head + "20,15,400,7,1/3,21,0.5,0.3,?\n20,15,400,7,1/3,21,much,0.3,0.01\n")
    assert readings.ok
    assert of(readings.columns["precession_period"], "u") == (Uncertainty(0.5), None)
    assert of(readings.columns["precession_rate"], "u") == (None, None)


class Sheet(io.BytesIO):
    """A stream that has columns too, as the sheets of some libraries have."""

    columns = ()


def test_what_only_has_columns_is_no_dataframe():
    assert read_log(Sheet((HEAD + ROW).encode())).ok


def test_a_dataframe_whose_index_has_the_name_of_a_column():
    import pandas as pd

    columns = {"mass [g]": [20.5, 40.0], "position [cm]": 15.0, "spin [rpm]": 206.0, "time [s]": 7.5, "turns": 1}
    frame = pd.DataFrame(columns, dtype="float32")
    readings = read_log(frame)
    assert readings.columns["mass"].values == (0.0205, 0.04)  # noqa: PD011 (a Column, not a frame)
    assert of(readings.columns["mass"], "text") == ("20.5", "40"), "a whole number has no point"
    noted = frame.assign(note=["by Ann", "by Bob"]).set_index("note", drop=False)
    assert [one.message for one in read_log(noted).diagnostics] == ['two columns are called "note"']


@pytest.mark.parametrize(
    ("line", "column", "used"),
    [
        ("", "", "u_imbalance u_position u_time u_time_bias"),
        ("# u_time: 0.2 s", "", "u_imbalance u_position u_time_bias"),
        ("# u_position: 1 mm", "", "u_imbalance u_time u_time_bias"),
        ("# u_imbalance: 0.1 mN m", "", "u_position u_time u_time_bias"),
        ("# balanced: yes", "", "u_position u_time u_time_bias"),
        ("# balanced: no", "", "u_position u_time u_time_bias"),
        ("# balance_drift: 30 deg in 20 s at 400 rpm", "", "u_position u_time u_time_bias"),
        ("# balance_tilt: 2 deg in 10 s", "", "u_position u_time u_time_bias"),
        ("", ",u_time [s]", "u_imbalance u_position u_time_bias"),
        ("", ",T [s]", "u_imbalance u_position u_time u_time_bias"),
        ("", ",T (± 0.1 s) [s]", "u_imbalance u_position u_time_bias"),
    ],
)
def test_uncertainties_of_the_bench_hold_where_a_log_states_none(line, column, used):
    rows = [f"{mass},15.0,206,{time},1{column and f',{time}'}\n" for mass, time in ((20, 20.5), (40, 10.5))]
    readings = read_log("\n".join([line, HEAD.strip() + column, *rows]))
    assert readings.ok, readings.diagnostics
    given = {f"u_{name}": Uncertainty(0.003) for name in ("imbalance", "position", "time", "time_bias", "torque")}
    told, keys = with_uncertainties(readings, given)
    assert keys == set(used.split())
    for name in ("position", "time"):
        mine = [one == Uncertainty(0.003) for one in of(told.columns[name], "u")]
        assert mine == [f"u_{name}" in used.split()] * 2
    ours = {key for key, u in told.uncertainties.items() if u == Uncertainty(0.003)}
    assert ours == keys & {"u_imbalance", "u_time_bias"}
    assert of(told.columns["mass"], "u") == of(readings.columns["mass"], "u")


class Labelled(float):
    """A number that says its units, or its deviation, and no more of what other libraries have."""

    units = "g"
    std_dev = 0.1


class Sized(float):
    magnitude = nominal_value = 7.0


@pytest.mark.parametrize("kind", [Labelled, Sized])
def test_a_number_that_only_looks_like_one_of_another_library_is_a_number(kind):
    import pandas as pd

    columns = {"mass [g]": [kind(20.5)], "position [cm]": 15, "spin [rpm]": 206, "time [s]": 7.5, "turns": 1}
    readings = read_log(pd.DataFrame(columns, dtype=object))
    assert of(readings.columns["mass"], "text") == ("20.5",)
