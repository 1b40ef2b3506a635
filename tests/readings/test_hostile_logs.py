"""Found by reading logs as a hostile and as a tired user would write them."""

import gzip
import io
import time

import pytest

from gyrodata.errors import InputError
from gyrodata.measurements import measure
from gyrodata.readings import read_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,406,13.06,1/3\n"


def codes(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics]


@pytest.mark.parametrize("header", ["a b " * 2400, "a_" * 4900, "time " * 1990, "± 1 " * 2400, "x y/ z (" * 1200])
def test_a_long_header_costs_no_time(header):
    start = time.perf_counter()
    read_log(",".join([header] * 50) + "\n" + ",".join("1" * 50) + "\n")
    assert time.perf_counter() - start < 2


def test_a_row_of_ones_is_a_run_and_no_row_of_units():
    readings = read_log("mass [g],position [cm],spin [rpm],time [s],turns\n1,1,1,1,1\n1,1,1,2,1\n")
    assert len(readings.runs) == 2


def test_many_faults_of_one_kind_are_counted():
    readings = read_log(HEAD + "2O,15,400,7,1\n" * 2000)
    assert len(readings.diagnostics) == 101
    assert readings.diagnostics[-1].message.startswith("1900 more")
    assert not readings.ok


def test_many_remarks_cost_no_time():
    start = time.perf_counter()
    assert read_log("".join(f"# key{i}: 2 g\n" for i in range(20_000)) + HEAD + ROW).ok
    assert time.perf_counter() - start < 4


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("1e-300,15,400,7,1", "too small for a mass"),
        ("20,1e300,400,7,1", "too large for a length"),
        ("20,15,1e9,7,1", "too large for a rotation rate"),
        ("20,15,400,1e300,1", "too large for a time"),
        ("20,15,400,7,1e-300", "too small for a number of turns"),
        ("20±1e300,15,400,7,1", "uncertainty that is far too large"),
    ],
)
def test_sizes_that_no_lab_has(row, said):
    readings = read_log(HEAD + row + "\n")
    assert not readings.ok
    assert said in readings.diagnostics[0].message


@pytest.mark.parametrize(
    "given", ["turns=0", "turns=-1", "spin=0 rpm", "mass=-1 g", "time=1e300 s", "g=1e300 m/s^2", "u_time=1e300 s",
              "u_spin=1e300 %", "pitch=95 deg", "balance_tilt=1e300 deg in 1e-300 s"]
)  # fmt: skip
def test_constants_that_cannot_be(given):
    key, _, text = given.partition("=")
    with pytest.raises(InputError) as caught:
        read_log(HEAD + ROW, settings={key: text})
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["G504"]
    line = read_log(f"# {key}: {text}\n" + HEAD + ROW)
    assert codes(line) == ["G306"]


@pytest.mark.parametrize(
    ("cell", "hint"),
    [("7 min 30 s", "07:30"), ("7'30", "07:30"), ("12.5 (3)", "12.5(3)"), ("2m30.5s", "02:30.5"), ("1S.0", "15.0")],
)
def test_what_was_meant(cell, hint):
    assert hint in read_log(HEAD + f"20,15,400,{cell},1\n").diagnostics[0].hint


def test_compressed_parts_one_behind_the_other():
    data = gzip.compress((HEAD + ROW).encode()) + gzip.compress(b"40,15,400,19,1\n")
    assert len(read_log(data).runs) == 2
    with pytest.raises(InputError, match="G107"):
        read_log(data + b"junk")
    with pytest.raises(InputError, match="G106"):
        read_log(gzip.compress(b"a," * 4_000_000) * 2)


def test_a_stray_cell_in_the_far_corner_of_a_workbook():
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"])
    book.active.append([20, 15.5, 206, 7.06, "1/3"])
    book.active["XFD1048576"] = 1
    stream = io.BytesIO()
    book.save(stream)
    start = time.perf_counter()
    assert read_log(stream.getvalue()).ok
    assert time.perf_counter() - start < 10


def test_marks_that_no_editor_shows():
    text = HEAD.replace(",", ",\u200b") + ROW.replace("406", "\u202e406\u202c")
    readings = read_log(("\ufeff\ufeff" + text).encode())
    assert readings.ok
    assert [reading.text for reading in readings.columns["spin"].readings] == ["406"]


def test_tables_in_a_configuration(tmp_path):
    path = tmp_path / "c.toml"
    for text, told in (
        ('[map]\ntime = "time [s]"', "--map"),
        ("g = [1]", 'write one value: g = "1"'),
        ("g = {a = 1}", "--map"),
        ("a.b.c = 1", "--map"),
    ):
        path.write_text(text)
        with pytest.raises(InputError) as caught:
            read_log(HEAD + ROW, config=path)
        assert told in caught.value.diagnostics[0].hint


def test_a_second_weight_that_disagrees_is_told():
    readings = read_log("mass [g],m [g],position [cm],spin [rpm],time [s],turns\n20,40,15,400,7,1\n")
    assert "G401" in [diagnostic.code for diagnostic in measure(readings).diagnostics]
    same = read_log("mass [g],m [kg],position [cm],spin [rpm],time [s],turns\n20,0.02,15,400,7,1\n")
    assert "G401" not in [diagnostic.code for diagnostic in measure(same).diagnostics]


def test_a_link_to_nothing(tmp_path):
    link = tmp_path / "gone.csv"
    link.symlink_to(tmp_path / "elsewhere.csv")
    with pytest.raises(InputError) as caught:
        read_log(link)
    assert caught.value.diagnostics[0].hint == ""
