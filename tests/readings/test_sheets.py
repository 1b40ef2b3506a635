"""More than a hundred logs as students type them: read and right, or refused with a
remedy that is right.
"""

import datetime
import io
import math
from fractions import Fraction

import numpy as np
import openpyxl
import pandas as pd
import pytest
from sheets import HABITS, HEAD, INERTIA, lab, source
from simulated_labs import analyze_briefly

import gyrodata
from gyrodata.base.errors import GyroError
from gyrodata.readings import read_log


def answer(data, **given):
    """Give how far off I_zz is in u, and all that is said."""
    try:
        analysis = analyze_briefly(data, **given)
    except GyroError as error:
        return None, " ".join(f"{d.message} {d.hint}" for d in error.diagnostics)
    said = " ".join(f"{d.message} {d.hint}" for d in analysis.diagnostics)
    return (analysis.inertia.value - INERTIA) / analysis.inertia.u, said


def values(readings, role):
    return [one.value for one in readings.columns[role].readings]


@pytest.mark.slow
@pytest.mark.parametrize("habit", HABITS, ids=lambda habit: habit.name)
def test_log_as_students_type_it_gives_the_truth(habit):
    data = source(habit.make(lab(HABITS.index(habit), habit.turns, habit.unloaded)))
    off, said = answer(data)
    assert habit.says in said
    assert (off is None) == habit.asked, said
    if habit.edit:
        data = data.decode().replace(*habit.edit).encode()
    if habit.asked:
        off, said = answer(data, settings=habit.settings, mapping=habit.mapping)
    assert off is not None, said
    assert abs(off) < 3, (off, said)


def test_most_habits_are_read_without_help():
    assert sum(habit.asked for habit in HABITS) < 0.15 * len(HABITS)


def workbook(*rows, formats=()):
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(list(row))
    for at, shown in enumerate(formats, 2):
        book.active.cell(at, 2).number_format = shown
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


@pytest.mark.slow
def test_rounded_cell_of_a_workbook_is_mended_by_its_format():
    rows = (
        HEAD,
        [20.1, 15, 300, 9.93, 1 / 3],
        [40.3, 15, 600, 19.9, 2 / 3],
        [60.2, 15, 400, 13.2, 1],
    )
    hints = []
    for shown in ("General", "0.0"):
        said = gyrodata.analyze(
            workbook(*rows, formats=[shown] * 3), name="log.xlsx"
        ).diagnostics
        hints.append([one.hint for one in said if one.code == "G407"])
    assert "such as 15.0 (in a spreadsheet, by a number format" in hints[0][0]
    assert hints[1] == []


def test_times_of_a_workbook_are_read_as_they_were_typed():
    typed = [
        (datetime.time(0, 3, 36, 260000), 216.26),
        (datetime.time(0, 0, 7), 7.0),
        (7.06, 7.06),
        (7, 7.0),
        ("7,06", 7.06),
        (datetime.timedelta(minutes=99, seconds=59.99), 5999.99),
        (datetime.timedelta(seconds=7.06), 7.06),
    ]
    rows = [[20, 15.5, 406, time, 1, 'a\t"b"\nc'] for time, _ in typed]
    assert values(read_log(workbook([*HEAD, "note"], *rows)), "time") == pytest.approx(
        [s for _, s in typed]
    )
    for wrong, shown in (
        (datetime.time(5, 36), "05:36:00 (a time of the day)"),
        (True, "True"),
    ):
        found = read_log(
            workbook(HEAD, [20, 15.5, 406, wrong, 1]), name="log.xlsx"
        ).diagnostics[0]
        assert (shown in found.message, str(found)[:18]) == (True, "log.xlsx:Sheet!D2:")
    with pytest.raises(GyroError, match="the workbook is empty"):
        read_log(workbook())


def test_values_of_a_table_are_read_as_they_were_typed():
    typed = [
        (pd.Timedelta(seconds=7.06), 7.06),
        (np.float32(0.5), 0.5),
        (7, 7),
        ("1/3", 1 / 3),
        (Fraction(1, 3), 1 / 3),
        *((blank, None) for blank in (None, float("nan"), pd.NA, pd.NaT)),
    ]
    frame = pd.DataFrame(
        {"time [s]": pd.Series([value for value, _ in typed], dtype=object)}
    )
    frame = frame.assign(
        **{"mass [g]": 20, "position [cm]": 15, "spin [rpm]": 400, "turns": "1"}
    )
    assert values(read_log(frame), "time") == pytest.approx(
        [value for _, value in typed if value], rel=1e-7
    )
    refused = read_log(
        frame.assign(**{"time [s]": [True, math.inf, -0.25, *[7] * 6]})
    ).diagnostics
    # What contains no digit is not a time.
    assert [
        "-0.25" in refused[0].message,
        "lines 2-3: left out" in refused[1].message,
    ] == [True] * 2


def test_table_with_units_in_its_attributes_is_read():
    rows = {
        ("mass", "g"): [20.0, 40.5],
        ("position", "cm"): [15, None],
        "spin": [406, 398],
        "time": [7.06, 6.71],
        ("turns", ""): ["1/3", "2/3"],
        7: [1, 2],
        "x\ty": ["a\tb", '"c'],
    }
    frame = pd.DataFrame(rows)
    frame.columns = list(rows)
    units = {"spin": "rpm", "time": "s", "mass": "kg", "turns": ""}
    frame.attrs |= {
        "units": units,
        "g": 9.81,
        "station": "a\nb",
        "list": [1],
        "table": {"a": 1},
    }
    readings = read_log(frame)
    assert (readings.ok, readings.constants, readings.metadata) == (
        True,
        {"g": 9.81},
        {"station": "a b"},
    )
    assert values(readings, "mass") == [0.02, 0.0405]
    assert values(readings, "spin") == pytest.approx(
        [406 * math.pi / 30, 398 * math.pi / 30]
    )
    indexed = pd.DataFrame(
        {"time [s]": [7.06]}, index=pd.Index([20.1], name="mass [g]")
    )
    assert values(read_log(indexed), "mass") == pytest.approx([0.0201])


def test_row_that_is_struck_out_is_left_out_with_a_note():
    book = openpyxl.load_workbook(
        io.BytesIO(workbook(HEAD, *[[20, 15, 406 + k, 13.06, "1/3"] for k in range(3)]))
    )
    for cell in book.active[3]:
        cell.font = openpyxl.styles.Font(strike=True)
    book.active["A4"].font = openpyxl.styles.Font(
        strike=True
    )  # only one cell of its row
    stream = io.BytesIO()
    book.save(stream)
    readings = read_log(stream.getvalue())
    assert readings.lines == (2, 4)
    assert (
        "line 3 left out (taken out with #, a line through it, or a note)"
        in " ".join(d.message for d in readings.diagnostics)
    )


def test_sheet_of_a_plot_and_result_rows_are_left_out() -> None:
    runs = [[20, 15, 406 + k, 13.06, "1/3"] for k in range(3)]
    book = openpyxl.load_workbook(
        io.BytesIO(workbook(HEAD, *runs, ["I_zz =", 0.0044, "kg m^2"]))
    )
    for row in (["x", "y"], [1.5, 0.006], [3.0, 0.013]):
        book.create_sheet("Plot") if "Plot" not in book.sheetnames else None
        book["Plot"].append(row)
    stream = io.BytesIO()
    book.save(stream)
    log = read_log(stream.getvalue())
    assert (log.ok, len(log.runs)) == (True, 3)
    assert "rows Plot!2-3: left out, because there is no time" in [
        one.message for one in log.diagnostics
    ]
