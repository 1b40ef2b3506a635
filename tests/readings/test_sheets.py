"""A hundred and twenty logs as students type them: read and right, or refused with a remedy that is right."""

import datetime
import io
import math
from collections import Counter
from fractions import Fraction

import numpy as np
import openpyxl
import pytest
from msgspec.structs import replace
from sheets import HABITS, HEADERS, INERTIA, lab, source

from gyrodata.analysis import analyze_readings
from gyrodata.errors import GyroError
from gyrodata.measurements import measure
from gyrodata.readings import read_log, value_text, write_log


def answer(data, **given):
    """Give how far off I_zz is in u, whether anything was warned of, and all that is said."""
    try:
        readings = read_log(data, **given)
    except GyroError as error:
        return None, " ".join(f"{d.message} {d.hint}" for d in error.diagnostics), True
    said = " ".join(f"{d.code} {d.message} {d.hint}" for d in readings.diagnostics)
    if not readings.ok:
        return None, said, True
    analysis = analyze_readings(readings)
    found = analysis.inertia
    warned = any(d.severity != "note" for d in analysis.diagnostics)
    return (found.value - INERTIA) / found.u, said, warned


def made(habit):
    runs = lab(HABITS.index(habit), habit.turns, habit.unloaded)
    return source(habit.make(runs))


@pytest.mark.parametrize("habit", HABITS, ids=lambda habit: habit.name)
def test_a_log_as_students_type_it(habit):
    data = made(habit)
    off, said, _ = answer(data)
    if habit.asked:
        assert off is None, said
        assert habit.says in said
        if habit.edit:
            data = data.decode().replace(*habit.edit).encode()
        off, said, _ = answer(data, settings=habit.settings, mapping=habit.mapping)
    assert off is not None, said
    assert abs(off) < 3, (off, said)
    if not habit.asked:
        assert habit.says in said


def test_most_of_them_are_read_without_help_and_workbooks_and_languages_are_among_them():
    asked = [habit for habit in HABITS if habit.asked]
    assert len(HABITS) >= 120
    assert len(asked) < 0.15 * len(HABITS)
    assert sum(made(habit).startswith(b"PK") for habit in HABITS) >= 40
    assert len({habit.name for habit in HABITS}) == len(HABITS)


USUAL = {
    "mass [g]": ("mass", "20.1", 0.0201),
    "position [cm]": ("position", "14.8", 0.148),
    "spin [rpm]": ("spin", "400", 400 * math.pi / 30),
    "time [s]": ("time", "13.2", 13.2),
    "turns": ("turns", "1/3", 1 / 3),
}


def test_headers_that_students_write_are_understood_or_asked_about_by_name():
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
    assert outcomes.total() >= 120
    assert outcomes["understood"] >= 110
    assert outcomes["not placed"] <= 2


def test_a_workbook_s_numbers_have_the_decimals_that_it_shows():
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(list(USUAL))
    for value, shown in ((15, "0.0"), (15, "General"), (15.25, "0.0"), (-7.5, "0.00"), (15, "0")):
        sheet.append([20, value, 400, 13.06, 1])
        sheet.cell(sheet.max_row, 2).number_format = shown
    stream = io.BytesIO()
    book.save(stream)
    position = read_log(stream.getvalue()).columns["position"]
    assert [read.text for read in position.readings] == ["15.0", "15", "15.25", "-7.50", "15"]


def test_a_workbook_s_rounded_cell_is_mended_by_its_format():
    def said(shown):
        book = openpyxl.Workbook()
        sheet = book.active
        for row in (list(USUAL), [20.1, 15, 300, 9.93, 1 / 3], [40.3, 15, 600, 19.9, 2 / 3], [60.2, 15, 400, 13.2, 1]):
            sheet.append(row)
            sheet.cell(sheet.max_row, 2).number_format = shown
        stream = io.BytesIO()
        book.save(stream)
        found = analyze_readings(read_log(stream.getvalue(), name="log.xlsx")).diagnostics
        return [d.hint for d in found if d.code == "G407"]

    (hint,) = said("General")
    assert "such as 15.0 (by a number format that shows it)" in hint
    assert said("0.0") == []


@pytest.mark.parametrize("word", ["none", "no weight", "-", "ohne", "нет"])
def test_no_weight_in_words(word):
    rows = "".join(f"20.1,14.8,{spin},13.2,1/3\n" for spin in (300, 400, 500))
    readings = read_log(";".join(USUAL) + "\n" + rows.replace(",", ";") + f"{word};;400;160;1/12\n")
    assert readings.columns["mass"].values[-1] == 0
    assert readings.columns["position"].values[-1] is None


def test_dashes_in_many_rows_say_as_above():
    rows = "20.1;14.8;300;13.2;1/3\n-;-;400;17.6;1/3\n40.3;14.8;300;6.6;1/3\n-;-;400;8.8;1/3\n"
    readings = read_log(";".join(USUAL) + "\n" + rows)
    assert readings.columns["mass"].values == pytest.approx((0.0201, 0.0201, 0.0403, 0.0403))
    assert "G217" in [d.code for d in readings.diagnostics]


def test_a_record_of_a_sensor_is_told_from_runs():
    cells = "".join(f"{k * 0.01:.2f};0.01;22.2\n" for k in range(200))
    readings = read_log("Time (s);Gyroscope x (rad/s);Gyroscope y (rad/s)\n" + cells)
    assert [d.code for d in readings.diagnostics] == ["G144"]
    assert "one row a run is read" in readings.diagnostics[0].message


def test_turns_that_are_rounded_widen_the_answer_of_all_their_runs():
    def width(turns):
        rows = "".join(f"{m};14.8;{s};{t};{turns}\n" for m, s, t in (("20.1", 300, "9.9"), ("40.3", 600, "9.9")))
        return analyze_readings(read_log("# u_imbalance: 0 N*m\n" + ";".join(USUAL) + "\n" + rows)).inertia

    exact, rounded = width("1/3"), width("0.33")
    assert rounded.u / rounded.value > math.hypot(exact.u / exact.value, 0.015)
    assert width("0.3").u > 3 * rounded.u


def test_what_a_position_counts_from_is_a_source_of_error():
    def source(line, arm):
        rows = "".join(f"{m};{arm};{s};9.9;1/3\n" for m, s in (("20.1", 300), ("40.3", 600)))
        measured = measure(read_log(line + ";".join(USUAL) + "\n" + rows))
        assert measured.position == pytest.approx([0.148, 0.148])
        return next(s.absolute[0] for s in measured.sources if s.name == "position_zero")

    plain = source("", "14.8")
    surface = "# position_from: surface\n# ball_diameter: 10 cm\n"
    assert source(surface, "9.8") == pytest.approx(math.hypot(plain, 0.01 / math.sqrt(12) / 2))
    assert source(surface + "# u_ball_diameter: 2 mm\n", "9.8") == pytest.approx(math.hypot(plain, 0.001))
    tip = "# position_from: tip\n# rod_length: 30 cm\n# u_rod_length: 1 mm\n"
    assert source(tip, "15.2") == pytest.approx(math.hypot(plain, 0.001))


def test_positions_of_another_origin_survive_being_written():
    log = "# position_from: surface\n# ball_diameter: 10.16 cm\n" + ";".join(USUAL) + "\n20.1;-9.72;300;9.9;1/3\n"
    readings = read_log(log)
    assert readings.columns["position"].values == pytest.approx((-0.148,))
    assert read_log(write_log(readings)).columns["position"].values == pytest.approx((-0.148,))
    assert read_log(log.replace("surface", "wall")).diagnostics[0].code == "G306"


def told_of(book):
    stream = io.BytesIO()
    book.save(stream)
    return read_log(stream.getvalue())


def test_cells_of_a_workbook_as_they_were_typed():
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append([*USUAL, "note"])
    times = [
        datetime.time(0, 3, 36, 260000), datetime.time(0, 0, 7), datetime.time(3, 36),
        datetime.timedelta(minutes=99, seconds=59.99), datetime.timedelta(seconds=7.06), 7.06, 7, "7,06", True,
    ]  # fmt: skip
    for at, value in enumerate(times):
        sheet.append([20, 15.5, 406, value, 1, 'a\t"b"\nc' if at else '"x'])
    source_text = told_of(book).source_text.splitlines()
    assert [line.split("\t")[3] for line in source_text[1:]] == [
        "03:36.26", "00:07.00", "03:36:00 (a time of the day)", "99:59.99", "00:07.06", "7.06", "7", "7,06", "True"
    ]  # fmt: skip
    assert [line.split("\t")[5] for line in source_text[1:3]] == ['"""x"', 'a "b" c']


def test_only_filled_cells_of_filled_sheets_are_read():
    book = openpyxl.Workbook()
    first = book.active
    first.title = "runs"
    first.append(list(USUAL))
    first.append([20, 15.5, 406, 7.06, 1, None, None])
    first.append([None, None])
    book.create_sheet("nothing")
    one = told_of(book)
    assert one.source_text == "mass [g]\tposition [cm]\tspin [rpm]\ttime [s]\tturns\n20\t15.5\t406\t7.06\t1\n"
    book.create_sheet("more").append(["It went well"])
    two = told_of(book)
    assert two.source_text == f"sheet runs\n{one.source_text}sheet more\nIt went well\n"
    assert two.columns == {role: replace(column, find=two.columns[role].find, spots=two.columns[role].spots)
                           for role, column in one.columns.items()}  # fmt: skip
    assert two.columns["mass"].place(0) == (3, 1)
    with pytest.raises(GyroError, match="the workbook is empty"):
        told_of(openpyxl.Workbook())


def test_values_of_tables_as_a_student_would_have_typed_them():
    import pandas as pd

    typed = [
        (None, ""), (float("nan"), ""), (pd.NA, ""), (pd.NaT, ""), (pd.Timedelta(seconds=7.06), "7.06 s"),
        (np.float32(0.5), "0.5"), (np.float64(15.0), "15"), (15.0, "15"), (-0.25, "-0.25"), (7, "7"), (True, "True"),
        (1e15, "1000000000000000.0"), (999_999_999_999_999.0, "999999999999999"), (-1e15, "-1000000000000000.0"),
        (float("inf"), "inf"), ("1/3", "1/3"), (Fraction(1, 3), "1/3"),
    ]  # fmt: skip
    assert [value_text(value) for value, _ in typed] == [text for _, text in typed]


def test_a_table_with_units_beside_its_names():
    import pandas as pd

    rows = {("mass", "g"): [20.0, 40.5], ("position", "cm"): [15, None], "spin": [406, 398], "time": [7.06, 6.71],
            ("turns", ""): ["1/3", 'a "b"'], 7: [1, 2], "x\ty": ["a\tb", '"c']}  # fmt: skip
    frame = pd.DataFrame(rows)
    frame.columns = list(rows)
    frame.attrs |= {
        "units": {"spin": "rpm", "time": "s", "mass": "kg", "turns": ""},
        "g": 9.81, "station": "a\nb", "list": [1], "pair": (1, 2), "table": {"a": 1},
    }  # fmt: skip
    readings = read_log(frame)
    head, *body = readings.source_text.splitlines()[2:]
    assert readings.source_text.splitlines()[:2] == ["# g: 9.81", "# station: a b"]
    assert head == "mass [g]\tposition [cm]\tspin [rpm]\ttime [s]\tturns\t7\tx y"
    assert body == ["20\t15\t406\t7.06\t1/3\t1\ta b", '40.5\t\t398\t6.71\ta "b"\t2\t"""c"']
    frame.attrs["units"] = "g"
    assert read_log(frame, name="mine").source_text.splitlines()[3].split("\t")[2] == "spin"
    assert (read_log(frame, name="mine").name, readings.name) == ("mine", "<table>")
    indexed = pd.DataFrame({"time [s]": [7.06]}, index=pd.Index([20.1], name="mass [g]"))
    assert read_log(indexed).source_text == "mass [g]\ttime [s]\n20.1\t7.06\n"
    assert read_log(indexed.rename_axis(None)).source_text == "time [s]\n7.06\n"
