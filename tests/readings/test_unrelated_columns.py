"""A column that is no quantity of the experiment never changes a reading."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from itertools import cycle

import pytest
from simulated_labs import analyze_briefly

import gyrodata
from gyrodata.quantities import units
from gyrodata.readings import Readings, read_log

ROLES = ("mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns")
PLAIN = """mass [g],position [cm],spin [rpm],time [s],turns,run
19.91,15.01,200.2,19.74,1,1
19.91,15.01,400.1,39.91,1,2
19.91,15.01,601.5,59.71,1,3
39.89,15.01,200.3,9.92,1,4
39.89,15.01,400.3,20.01,1,5
39.89,15.01,599.8,29.91,1,6
60.04,15.01,200.2,6.73,1,7
60.04,15.01,400.5,13.31,1,8
60.04,15.01,600.4,20.00,1,9
"""
GERMAN = """Gewicht (g),Abstand (cm),Drehzahl (1/min),Zeit (s),Umläufe
20.1,14.8,212,7.05,1/3
20.1,14.8,398,13.2,1/3
40.3,14.8,398,6.61,1/3
40.3,14.8,604,20.1,2/3
60.2,14.8,604,20.2,1
60.2,14.8,212,7.10,1
"""
LOGS = {
    "plain": PLAIN,
    "German": GERMAN,
    "turns in the header of the times": PLAIN.replace(
        "time [s]", "time for 1 turn (s)"
    ).replace("turns", "bench"),
    "angle": PLAIN.replace("turns", "angle [turn]"),
    "turns in a line": "# turns: 1\n" + PLAIN.replace("turns", "bench"),
}
NAMES = """
battery,field,photodiode,Spannung,tension,napětí,humidity,temperature,
air pressure,current,voltage,light,noise,battery life,height,room height,
depth,altitude,table height,compressor,pump pressure,air flow,flow,gas flow,
laser power,power,energy,capacitance,resistance,magnetic field,brightness,
exposure,frame,supply voltage,signal,sensor,LED,motor,lamp,cable length,
camera,string,thread length,wind,sound level,heart rate,memory,room,coffee,
phone battery,age,water level,density,viscosity,dose,volume,area,price,gain,
channel,screen,Luftdruck,Raumhöhe,température,hauteur,courant,давление,
температура,высота,напряжение,altura,ciśnienie,teplota,výška,电压,高度,온도
""".replace("\n", "").split(",")
SYMBOLS = """
V T A K C F Pa bar hPa kPa mbar W J °C °F lx dB ppm % Ah Ω u r R t U v l L M G n p d D a
b B c e E f H i I k P q Q S w x X y Y z Z φ ω μ mT kV mV psi mol cd lm Wb Gy
"""
UNITS = [*sorted({*units.spellings().values()}), *SYMBOLS.split()]
HEADERS = [
    f"{NAMES[at % len(NAMES)]} {'[{}]' if at % 2 else '({})'}".format(
        UNITS[at % len(UNITS)]
    )
    for at in range(240)
]
VALUES = {
    "constant": ("1.5",) * 9,
    "varying": ("2", "3.1", "1", "12", "0.5", "7", "21.4", "1", "9"),
}


def with_column(log: str, header: str, cells: Sequence[str], place: int) -> str:
    """Put a column into a log: in front of all others (0), between them (1), or behind
    them (2).
    """
    lines = [line for line in log.splitlines() if line[0] == "#"]
    rows = list(csv.reader(log.splitlines()[len(lines) :]))
    at = (0, 2, len(rows[0]))[place]
    for row, cell in zip(rows, (header, *cells), strict=False):
        row.insert(at, cell)
    text = io.StringIO()
    csv.writer(text, delimiter=";", lineterminator="\n").writerows(rows)
    return "\n".join([*lines, text.getvalue()])


def without_column(log: str, header: str) -> str:
    rows = list(csv.reader(log.splitlines()))
    at = rows[0].index(header)
    return "".join(",".join(row[:at] + row[at + 1 :]) + "\n" for row in rows)


def read_of(log: Readings) -> dict[str, list[tuple[float | None, float | None]]]:
    """The readings that the analysis uses: a second column of a load or a period is
    only compared.
    """
    kept = {
        role: column
        for role, column in log.columns.items()
        if role not in ("force", "precession_period")
    }
    return {
        role: [(one.value, one.step) for one in column.readings]
        for role, column in kept.items()
    }


def test_every_name_and_unit_is_tried() -> None:
    assert len(NAMES) >= 60
    assert len(HEADERS) == 240
    assert len(UNITS) <= len(HEADERS)


@pytest.mark.slow
@pytest.mark.parametrize("values", VALUES)
@pytest.mark.parametrize("name", LOGS)
def test_unrelated_column_changes_no_reading(name: str, values: str) -> None:
    log = LOGS[name]
    alone = read_log(log)
    assert alone.ok
    changed = []
    # Each header in the plain log, and each log with headers of every kind.
    kept = [*LOGS].index(name) + [*VALUES].index(values)
    step = 2 if name == "plain" else 11
    for at, header in enumerate(HEADERS):
        if at % step != kept % step:
            continue
        found = read_log(with_column(log, header, VALUES[values], at % 3))
        if not found.ok or read_of(found) != read_of(alone):
            changed.append(header)
    assert not changed


@pytest.mark.slow
@pytest.mark.parametrize(
    "header",
    ["battery [V]", "field [T]", "Spannung (V)", "height [m]", "LED (u)", "wind [rev]"],
)
def test_unrelated_column_changes_no_answer(header: str) -> None:
    alone = gyrodata.analyze(PLAIN).inertia
    for place in range(3):
        log = with_column(PLAIN, header, VALUES["constant"], place)
        found = analyze_briefly(log)
        assert (found.inertia.value, found.inertia.u) == (alone.value, alone.u)
        assert any(header in one.message for one in found.diagnostics)


# The name or the symbol of a quantity, with any unit: such a column may change nothing,
# or gyro asks.
NAMED = (
    "charge",
    "clock",
    "offset",
    "ball mass",
    "Last",
    "P",
    "F",
    "T",
    "L",
    "f",
    "I",
    "R",
    "t",
    "n",
    "U",
    "V",
    "D",
)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMED)
def test_second_column_with_the_name_of_a_quantity_is_asked_about(name: str) -> None:
    alone = read_log(PLAIN)
    for at, unit in enumerate(UNITS[::6]):
        header = f"{name} [{unit}]"
        found = read_log(with_column(PLAIN, header, VALUES["varying"], at % 3))
        asked = [
            one
            for one in found.diagnostics
            if one.severity == "error" and header in one.message + one.excerpt
        ]
        assert asked or (found.ok and read_of(found) == read_of(alone)), header


LETTERS = sorted(
    {unit for unit in UNITS if len(unit) == 1 and unit.isalpha()} | set("mgshN")
)


@pytest.mark.slow
@pytest.mark.parametrize("role", ROLES)
def test_one_letter_does_not_make_a_column_the_missing_quantity(role: str) -> None:
    log = without_column(PLAIN, role)
    missing = role.split()[0]
    for name, letter in zip(cycle(("battery life", "height")), LETTERS, strict=False):
        found = read_log(with_column(log, f"{name} [{letter}]", VALUES["varying"], 2))
        errors = [one for one in found.diagnostics if one.severity == "error"]
        assert errors, f"{name} [{letter}] was read as {missing}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("role", "header", "cells"),
    [
        ("turns", "revolutions", "2"),
        ("mass", "weight [g]", "25.0"),
        ("position", "L [m]", "0.21"),
        ("spin", "f [Hz]", "4.4"),
        ("time", "clock [s]", "21.4"),
    ],
)
def test_question_about_two_columns_shows_what_to_type(
    role: str, header: str, cells: str
) -> None:
    own = next(name for name in ROLES if name.startswith(role))
    for place in range(3):
        log = with_column(PLAIN, header, (cells,) * 9, place)
        with pytest.raises(gyrodata.LogError) as refused:
            gyrodata.analyze(log)
        (error,) = (one for one in refused.value.diagnostics if one.severity == "error")
        assert error.code == "G237"
        assert own in error.message
        assert header in error.message
        typed = re.findall(r'--map (\w+)="([^"]+)"', error.hint)
        assert sorted(typed) == sorted([(role, own), (role, header)])
        kept = read_log(log, mapping={role: own})
        assert read_of(kept) == read_of(read_log(PLAIN))
        other = read_log(log, mapping={role: header})
        assert other.columns[role].header == header
        assert other.ok


def test_two_columns_that_agree_need_no_question() -> None:
    cells = [f"{float(row.split(',')[2]) / 60:.4f}" for row in PLAIN.splitlines()[1:]]
    found = read_log(with_column(PLAIN, "f [Hz]", cells, 2))
    assert found.ok
    assert read_of(found) == read_of(read_log(PLAIN))


@pytest.mark.parametrize("header", ["P [bar]", "P (kPa)", "F"])
def test_load_that_is_not_needed_does_not_stop_the_log(header: str) -> None:
    found = read_log(with_column(PLAIN, header, VALUES["varying"], 0))
    assert found.ok
    assert read_of(found) == read_of(read_log(PLAIN))
    assert any(header in one.message for one in found.diagnostics)


@pytest.mark.parametrize("header", ["tilt", "inclination", "tilt [bar]"])
def test_question_about_a_unit_says_that_the_column_can_be_deleted(header: str) -> None:
    log = with_column(PLAIN, header, VALUES["varying"], 2)
    (error,) = (one for one in read_log(log).diagnostics if one.severity == "error")
    assert "delete it" in error.hint


@pytest.mark.parametrize(
    ("role", "header", "meant"),
    [
        ("mass [g]", "Jisim (g)", "mass"),
        ("position [cm]", "Ulu (m)", "position"),
        ("time [s]", "Ulu (s)", "time"),
    ],
)
def test_question_about_a_missing_quantity_names_the_column_whose_unit_fits(
    role: str, header: str, meant: str
) -> None:
    log = PLAIN.replace(role, header)
    (error,) = (one for one in read_log(log).diagnostics if one.severity == "error")
    assert f'--map {meant}="{header}"' in error.hint
    found = read_log(log, mapping={meant: header})
    assert found.ok or meant == "position"
    assert meant in found.columns


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "header", "cell"),
    [
        ("# turns: 1/3", "revs", "1"),
        ("# position: 14.8 cm", "arm [cm]", "30.2"),
        ("# spin: 400 rpm", "speed [rpm]", "900"),
        ("# mass: 40.3 g", "weight [g]", "71.2"),
    ],
)
def test_line_and_column_that_differ_are_a_question(
    line: str, header: str, cell: str
) -> None:
    cells = {
        "mass [g]": "40.3",
        "position [cm]": "14.8",
        "spin [rpm]": "400",
        "time [s]": "6.4",
        "turns": "1/3",
    }
    role = line[2:].partition(":")[0]
    kept = {name: text for name, text in cells.items() if not name.startswith(role)}
    same = line.partition(": ")[2].partition(" ")[0]

    def log(value: str) -> str:
        return (
            f"{line}\n{','.join([*kept, header])}\n"
            + f"{','.join([*kept.values(), value])}\n" * 2
        )

    with pytest.raises(gyrodata.GyroError) as refused:
        gyrodata.analyze(log(cell))
    (error,) = [one for one in refused.value.diagnostics if one.severity == "error"]
    assert (error.code, error.line) == ("G237", 3)
    assert line in error.message
    assert header in error.message
    # A spin for the whole log has no delay.
    alike, blank = (gyrodata.analyze(log(value)).inertia.value for value in (same, ""))
    assert alike == pytest.approx(blank, rel=3e-3)
