"""A hundred and twenty logs as students type them: read and right, or refused with a remedy that is right."""

import datetime
import io
import math
from collections import Counter
from fractions import Fraction

import numpy as np
import openpyxl
import pytest
from sheets import HABITS, HEADERS, INERTIA, lab, source

import gyrodata
from gyrodata.errors import GyroError
from gyrodata.readings import read_log


def answer(data, **given):
    """Give how far off I_zz is in u, and all that is said."""
    try:
        analysis = gyrodata.analyze(data, **given)
    except GyroError as error:
        return None, " ".join(f"{d.message} {d.hint}" for d in error.diagnostics)
    said = " ".join(f"{d.message} {d.hint}" for d in analysis.diagnostics)
    return (analysis.inertia.value - INERTIA) / analysis.inertia.u, said


def made(habit):
    return source(habit.make(lab(HABITS.index(habit), habit.turns, habit.unloaded)))


@pytest.mark.parametrize("habit", HABITS, ids=lambda habit: habit.name)
def test_log_as_students_type_it_gives_the_truth(habit):
    data = made(habit)
    off, said = answer(data)
    assert habit.says in said
    assert (off is None) == habit.asked, said
    if habit.asked:
        if habit.edit:
            data = data.decode().replace(*habit.edit).encode()
        off, said = answer(data, settings=habit.settings, mapping=habit.mapping)
    assert off is not None, said
    assert abs(off) < 3, (off, said)


def test_most_habits_are_read_without_help():
    assert len({habit.name for habit in HABITS}) == len(HABITS) >= 120
    assert sum(habit.asked for habit in HABITS) < 0.15 * len(HABITS)
    assert sum(made(habit).startswith(b"PK") for habit in HABITS) >= 40


USUAL = {
    "mass [g]": ("mass", "20.1", 0.0201),
    "position [cm]": ("position", "14.8", 0.148),
    "spin [rpm]": ("spin", "400", 400 * math.pi / 30),
    "time [s]": ("time", "13.2", 13.2),
    "turns": ("turns", "1/3", 1 / 3),
}


def test_header_of_a_student_is_understood_or_asked_about():
    outcomes = Counter()
    for meant, headers in HEADERS.items():
        for header in headers.split("; "):
            head = [header if role == meant else usual for usual, (role, _, _) in USUAL.items()]
            row = [cell for _, cell, _ in USUAL.values()]
            readings = read_log(";".join(head) + "\n" + ";".join(row) + "\n")
            if readings.ok:
                for role, _, value in USUAL.values():
                    assert readings.columns[role].values == (pytest.approx(value),), header
                outcomes["understood"] += 1
            else:
                said = [d for d in readings.diagnostics if d.severity == "error"]
                asked = any(f'"{header}"' in d.hint or (d.code != "G301" and f'"{header}"' in d.message) for d in said)
                outcomes["asked" if asked else "not placed"] += 1
    assert outcomes["understood"] >= 110
    assert outcomes["not placed"] <= 2


def workbook(*rows, formats=()):
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(list(row))
    for at, shown in enumerate(formats, 2):
        book.active.cell(at, 2).number_format = shown
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def test_number_in_a_workbook_has_the_decimals_that_it_shows():
    cells = ((15, "0.0"), (15, "General"), (15.25, "0.0"), (-7.5, "0.00"), (15, "0"))
    data = workbook(USUAL, *([20, value, 400, 13.06, 1] for value, _ in cells), formats=[shown for _, shown in cells])
    assert [read.text for read in read_log(data).columns["position"].readings] == ["15.0", "15", "15.25", "-7.50", "15"]


def test_rounded_cell_of_a_workbook_is_mended_by_its_format():
    rows = (list(USUAL), [20.1, 15, 300, 9.93, 1 / 3], [40.3, 15, 600, 19.9, 2 / 3], [60.2, 15, 400, 13.2, 1])
    general, shown = (
        gyrodata.analyze(workbook(*rows, formats=[f] * 3), name="log.xlsx").diagnostics for f in ("General", "0.0")
    )
    assert ["such as 15.0 (by a number format that shows it)" in d.hint for d in general if d.code == "G407"] == [True]
    assert [d for d in shown if d.code == "G407"] == []


@pytest.mark.parametrize("word", ["none", "no weight", "-", "ohne", "нет"])
def test_no_weight_in_words_is_a_mass_of_zero(word):
    rows = "".join(f"20.1;14.8;{spin};13.2;1/3\n" for spin in (300, 400, 500))
    readings = read_log(";".join(USUAL) + "\n" + rows + f"{word};;400;160;1/12\n")
    assert (readings.columns["mass"].values[-1], readings.columns["position"].values[-1]) == (0, None)


def test_rounded_turns_widen_u_in_all_their_runs():
    def width(turns):
        rows = "".join(f"{m};14.8;{s};{t};{turns}\n" for m, s, t in (("20.1", 300, "9.9"), ("40.3", 600, "9.9")))
        return gyrodata.analyze(("# u_imbalance: 0 N*m\n" + ";".join(USUAL) + "\n" + rows).encode()).inertia

    exact, rounded = width("1/3"), width("0.33")
    assert rounded.u / rounded.value > math.hypot(exact.u / exact.value, 0.015)
    assert width("0.3").u > 3 * rounded.u


def test_cells_of_a_workbook_are_read_as_they_were_typed():
    times = [
        datetime.time(0, 3, 36, 260000), datetime.time(0, 0, 7), datetime.time(3, 36),
        datetime.timedelta(minutes=99, seconds=59.99), datetime.timedelta(seconds=7.06), 7.06, 7, "7,06", True,
    ]  # fmt: skip
    rows = [[20, 15.5, 406, value, 1, 'a\t"b"\nc' if at else '"x'] for at, value in enumerate(times)]
    lines = read_log(workbook([*USUAL, "note"], *rows)).source_text.splitlines()[1:]
    assert [line.split("\t")[3] for line in lines] == [
        "03:36.26", "00:07.00", "03:36:00 (a time of the day)", "99:59.99", "00:07.06", "7.06", "7", "7,06", "True"
    ]  # fmt: skip
    assert [line.split("\t")[5] for line in lines[:2]] == ['"""x"', 'a "b" c']
    with pytest.raises(GyroError, match="the workbook is empty"):
        read_log(workbook())


def test_values_of_a_table_are_read_as_they_were_typed():
    import pandas as pd

    typed = [
        (None, ""), (float("nan"), ""), (pd.NA, ""), (pd.NaT, ""), (pd.Timedelta(seconds=7.06), "7.06 s"),
        (np.float32(0.5), "0.5"), (np.float64(15.0), "15"), (-0.25, "-0.25"), (7, "7"), (True, "True"),
        (1e15, "1000000000000000.0"), (float("inf"), "inf"), ("1/3", "1/3"), (Fraction(1, 3), "1/3"),
    ]  # fmt: skip
    frame = pd.DataFrame({"time [s]": pd.Series([value for value, _ in typed], dtype=object), "note": "x"})
    lines = read_log(frame).source_text.splitlines()[1:]
    assert [line.split("\t")[0] for line in lines] == [text for _, text in typed]


def test_table_with_units_in_its_attributes_is_read():
    import pandas as pd

    rows = {("mass", "g"): [20.0, 40.5], ("position", "cm"): [15, None], "spin": [406, 398], "time": [7.06, 6.71],
            ("turns", ""): ["1/3", 'a "b"'], 7: [1, 2], "x\ty": ["a\tb", '"c']}  # fmt: skip
    frame = pd.DataFrame(rows)
    frame.columns = list(rows)
    units = {"spin": "rpm", "time": "s", "mass": "kg", "turns": ""}
    frame.attrs |= {"units": units, "g": 9.81, "station": "a\nb", "list": [1], "table": {"a": 1}}
    assert read_log(frame).source_text.splitlines() == [
        "# g: 9.81", "# station: a b", "mass [g]\tposition [cm]\tspin [rpm]\ttime [s]\tturns\t7\tx y",
        "20\t15\t406\t7.06\t1/3\t1\ta b", '40.5\t\t398\t6.71\ta "b"\t2\t"""c"',
    ]  # fmt: skip
    indexed = pd.DataFrame({"time [s]": [7.06]}, index=pd.Index([20.1], name="mass [g]"))
    assert read_log(indexed).source_text == "mass [g]\ttime [s]\n20.1\t7.06\n"
