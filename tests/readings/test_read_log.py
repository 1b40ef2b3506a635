"""What the reader understands, refuses, fills in and asks about, and every way in which
a log comes to it.
"""

import gzip
import io
import math
import sys
import tomllib

import pytest
from places import DATA

from gyrodata.readings import Uncertainty, read_log

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,206,7.06,1/3\n"
RUNS = HEAD + ROW * 3
RPM = 2 * math.pi / 60


CELLS = tomllib.loads((DATA / "odd_cells.toml").read_text(encoding="utf-8"))


def codes(readings):
    return [diagnostic.code for diagnostic in readings.diagnostics]


def column(readings, role):
    return list(readings.columns[role].values)


def test_plain_log_is_read_with_its_constants():
    readings = read_log(
        "# station: 3\n# g: 9.803 m/s^2\n# u_position: 0.5 mm\n"
        + HEAD
        + ROW
        + "0,,401,160.2,1/3\n"
    )
    assert readings.diagnostics == ()
    assert (readings.metadata, readings.constants) == ({"station": "3"}, {"g": 9.803})
    assert readings.uncertainties == {"u_position": Uncertainty(0.0005)}
    assert (column(readings, "mass"), column(readings, "position")) == (
        [0.02, 0.0],
        [0.15, None],
    )
    assert (readings.runs, readings.lines) == (("1", "2"), (5, 6))


def test_wrong_cell_is_shown_with_its_place():
    readings = read_log(
        HEAD.replace(",", ", ") + "20, 15.0, 56O, 13.06, 1/3\n", name="data.csv"
    )
    assert str(readings.diagnostics[0]) == (
        'data.csv:2:11: error G203: spin "56O" is not a number\n'
        "   20, 15.0, 56O, 13.06, 1/3\n"
        "             ^^^  did you mean 560?"
    )


@pytest.mark.parametrize(
    "case", CELLS["value"], ids=lambda case: case["log"].splitlines()[-1]
)
def test_cell_has_its_value(case):
    readings = read_log(case["log"] + "\n")
    assert readings.ok, readings.diagnostics
    ((role, values),) = ((key, value) for key, value in case.items() if key != "log")
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
    assert (codes(readings), len(readings.runs)) == ([], 3)
    assert (readings.reported["inertia"].value, readings.reported["inertia"].u) == (
        value,
        u,
    )


@pytest.mark.parametrize(
    "sign", ["±", "+/-", "+-", "± [{unit}]", "error", "uncertainty"]
)
def test_header_of_an_uncertainty_alone_is_used_with_a_unit(sign):
    signs = [sign.format(unit=unit) for unit in ("s", "rpm")]
    readings = read_log(
        f"time [s],{signs[0]},spin [rpm],{signs[1]},mass [g],position [cm],turns\n"
        f"13.06,0.2,406,3,20,15.0,1/3\n"
    )
    told = " ".join(map(str, readings.diagnostics))
    is_told = not readings.ok or all(f"{one}" in told for one in signs)
    assert is_told != ("[" in sign)
    if "[" in sign:
        columns = (readings.columns[role] for role in ("time", "spin"))
        assert [column.readings[0].u.absolute for column in columns] == pytest.approx(
            [0.2, 3 * 0.10471975511965977]
        )


@pytest.mark.parametrize(
    "line",
    [
        "Transverse inertia = 5.7e-3 kg m^2",
        "I_rod: 5.7e-3 kg m^2",
        "I_zz = ",
        "I_zz",
    ],
)
def test_another_quantity_in_a_row_of_the_table_is_not_what_is_reported(line):
    readings = read_log(f"{RUNS}{line}\n")
    assert (readings.ok, len(readings.runs), readings.reported) == (True, 3, {})


def test_a_fault_is_said_once_where_blank_cells_repeat_it():
    readings = read_log(HEAD + "20,15.0,56O,7.06,1/3\n,,,7.1,1/3\n,,400,7.1,1/3\n")
    assert [code for code in codes(readings) if code != "G217"] == ["G203"]


def test_option_wins_over_line_and_column():
    body = "mass [g],time [s],turns\n20,7.06,1/3\n,13.06,\n"
    readings = read_log(
        "# turns: 2/3\n# spin: 400 rpm\n" + body,
        settings={"spin": "10 Hz", "position": "5 cm"},
    )
    assert readings.ok
    assert column(readings, "turns") == [1 / 3, 2 / 3]
    assert column(readings, "spin") == pytest.approx([20 * math.pi] * 2)
    replaced = read_log(RUNS, settings={"spin": "400 rpm"})
    assert (codes(replaced), column(replaced, "spin")[0]) == (
        ["G304"],
        pytest.approx(400 * RPM),
    )


def test_log_is_the_same_in_every_way_in(tmp_path, monkeypatch):
    data = (HEAD + ROW).encode()
    path = tmp_path / "log.csv"
    path.write_bytes(data)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
    with path.open() as text:
        ways = [
            read_log(s)
            for s in (
                path,
                str(path),
                data,
                RUNS[: len(data)],
                io.BytesIO(data),
                text,
                gzip.compress(data),
                "-",
            )
        ]
    assert len({(way.columns["spin"].readings, way.runs) for way in ways}) == 1
    names = [
        "log.csv",
        "log.csv",
        "<bytes>",
        "<text>",
        "<stream>",
        "log.csv",
        "<bytes>",
        "<stdin>",
    ]
    assert [way.name for way in ways] == names
