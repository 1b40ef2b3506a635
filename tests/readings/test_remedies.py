"""A log whose columns lack something or count something else: it is read right, or the
first remedy that gyro prints gives the truth.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest
from simulated_labs import analyze_briefly
from typed_labs import (
    FOUR,
    START,
    is_true,
    log,
    questions,
)
from typer.testing import CliRunner

import gyrodata
from gyrodata import LogError
from gyrodata.cli import app


@pytest.mark.parametrize(
    ("header", "cell"),
    [
        ("number of thirds", "{thirds}"),
        ("thirds of a turn", "{thirds}"),
        ("thirds", "{thirds}"),
        ("Turns (thirds)", "{thirds}"),
        ("Anzahl Drittel", "{thirds}"),
        ("tiers de tour", "{thirds}"),
        ("turn completed (%)", "{percent}"),
        ("turns [%]", "{percent}"),
        ("Präzession", "{turns}"),
    ],
)
def test_columns_that_count_parts_of_a_turn_are_read_as_turns(
    header: str, cell: str
) -> None:
    text = log(f"{START},{header}", f"{FOUR},{cell}")
    assert is_true(text)
    assert is_true(text, mapping={"turns": header})


def test_whole_numbers_below_precession_are_asked_about() -> None:
    head = f"{START},precession"
    text = log(head, "{mass},14.8,{spin},{period:.2f},1")
    (asked,) = questions(text)
    assert asked.code == "G207"
    assert '--map turns="precession"' in asked.hint
    assert is_true(text, mapping={"turns": "precession"})


@pytest.mark.parametrize(
    ("wrong", "right", "cell"),
    [
        ("time [min]", "time [s]", "{turns}"),
        ("angle [rad]", "angle [deg]", "{degrees}"),
    ],
)
def test_unit_of_impossible_numbers_is_replaced_as_the_question_says(
    wrong: str, right: str, cell: str
) -> None:
    count = "angle [deg]" if "angle" in wrong else "turns"
    text = log(f"{START},{count}".replace(right, wrong), f"{FOUR},{cell}")
    doubted = gyrodata.analyze(text.encode()).doubts[0].remedy
    assert re.findall(r'write the header as "([^"]+)"', doubted) == [right]
    assert is_true(text.replace(wrong, right))


def test_mapped_percentages_are_asked_about() -> None:
    head = f"{START},how far around"
    text = log(head, FOUR + ",{percent}")
    with pytest.raises(LogError, match=r'write the header as "turns \[%\]"'):
        analyze_briefly(text.encode(), mapping={"turns": "how far around"})


def test_unit_of_large_numbers_may_be_right_in_each_cell() -> None:
    head = f"{START.replace('[s]', '[min]')},turns"
    assert is_true(log(head, "{mass},14.8,{spin},{minutes:.4f} min,{turns}"))


def test_one_question_contains_the_header_row_with_all_units() -> None:
    head = "mass,position,spin,time,turns"
    text = log(head, FOUR + ",{turns}")
    (asked,) = questions(text)
    assert is_true(text.replace(head, asked.hint.rpartition(": ")[2]))


def test_one_question_contains_the_header_row_with_all_missing_columns() -> None:
    head = "Jisim [g],position [cm],spin [rpm],Masa [s],turns"
    text = log(head, FOUR + ",{turns}")
    (asked,) = questions(text)
    row = asked.hint.splitlines()[0].rpartition(": ")[2]
    assert row == "mass [g],position [cm],spin [rpm],time [s],turns"
    assert is_true(text.replace(head, row))


def test_unit_of_a_time_says_more_than_a_name_of_the_mass() -> None:
    head = "m [g],position [cm],spin [rpm],Masa [s],turns"
    text = log(head, FOUR + ",{turns}")
    (asked,) = questions(text)
    assert 'or type --map time="Masa [s]"' in asked.hint
    assert is_true(text, mapping={"time": "Masa [s]"})


def test_header_with_a_subscript_can_be_mapped_to_the_period() -> None:
    head = "mass [g],position [cm],spin [rpm],T_P / s"
    text = log(head, "{mass},14.8,{spin},{period:.2f}")
    assert is_true(text, mapping={"precession_period": "T_P / s"})


def test_mass_of_the_ball_in_a_wrong_unit_is_asked_about() -> None:
    wrong = "# ball_mass: 4310 kg"
    text = log(f"{START},turns", FOUR + ",{turns}", above=f"{wrong}\n")
    (asked,) = questions(text)
    (line,) = re.findall(r'such as "([^"]+)"', asked.hint)
    assert line == "# ball_mass: 4.31 kg"
    assert is_true(text.replace(wrong, line))


def test_two_readings_of_a_ruler_are_asked_about() -> None:
    head = "mass [g],ruler start [cm],ruler weight [cm],spin [rpm],time [s],turns"
    asked = questions(log(head, "{mass},12.0,26.8,{spin},{time:.2f},{turns}"))
    both = '"ruler start [cm]" and "ruler weight [cm]"'
    assert any(both in question.message for question in asked)


def test_rate_of_the_precession_is_not_proposed_for_the_spin() -> None:
    head = "mass [g],position [cm],f_precession / Hz"
    (asked,) = questions(log(head, "{mass},14.8,0.01"))
    assert "f_precession" not in asked.hint


@pytest.mark.parametrize(
    ("header", "cell", "new"),
    [
        ("percent of a turn", "{percent}", "turns [%]"),
        ("screws", "{thirds}", "thirds of a turn"),
        ("deg turned", "{degrees}", "angle [deg]"),
    ],
)
def test_column_of_unknown_counts_gets_the_header_that_the_question_proposes(
    header: str, cell: str, new: str
) -> None:
    text = log(f"{START},{header}", f"{FOUR},{cell}")
    (asked,) = questions(text)
    assert f'"{new}"' in asked.hint
    assert is_true(text.replace(header, new))


def test_findings_of_other_runs_are_shown_next_to_an_unreadable_cell(
    tmp_path: Path,
) -> None:
    lines = log(f"{START},turns", FOUR + ",{turns}").splitlines()
    lines[2] = lines[2].replace(",206,", ",206rpm?,")
    time = lines[4].split(",")[3]
    lines[4] = lines[4].replace(time, time.replace(".", ""))
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    shown = CliRunner().invoke(app, ["check", str(path)]).output
    assert "log.csv:3:11: error" in shown
    assert f"time {time} s would fit" in shown


@pytest.mark.parametrize(
    ("header", "replaced"),
    [
        ("half distance [cm]", "position [cm]"),
        ("turns x2", "turns"),
        ("turns 2", "turns"),
    ],
)
def test_a_word_of_a_header_that_nothing_uses_is_asked_about(
    header: str, replaced: str
) -> None:
    text = log(f"{START},turns", f"{FOUR},{{turns}}")
    assert is_true(text)
    wrong = text.replace(replaced, header)
    asked = [one for one in questions(wrong) if one.code == "G207"]
    assert [re.findall(r'write "([^"]+)"', one.hint) for one in asked] == [[replaced]]
    assert is_true(wrong.replace(header, replaced))
    role = replaced.partition(" ")[0]
    assert is_true(wrong, mapping={role: header})


@pytest.mark.parametrize(
    ("header", "replaced"),
    [
        ("time 2 [s]", "time [s]"),
        ("t1 [s]", "time [s]"),
        ("Time (run 1) [s]", "time [s]"),
        ("spin at half time [rpm]", "spin [rpm]"),
        ("spin of the ball [rpm]", "spin [rpm]"),
        ("distance to the tip [cm]", "position [cm]"),
    ],
)
def test_numbers_of_repeats_and_the_ball_of_a_spin_are_no_question(
    header: str, replaced: str
) -> None:
    text = log(f"{START},turns", f"{FOUR},{{turns}}").replace(replaced, header)
    readings = gyrodata.read_log(text.encode(), name="log.csv")
    assert [one for one in readings.diagnostics if one.code == "G207"] == []


def test_a_time_without_turns_next_to_others_asks_with_the_whole_header_row() -> None:
    row = "m (g),x (cm),f (rpm),T1/3 (s),T2/3 (s),{}"
    runs = [(20.1, 200), (20.1, 400), (40.3, 200), (40.3, 400)]
    lines = []
    for mass, spin in runs:
        turn = (
            2 * math.pi * 4.4e-3 * spin * math.pi / 30 / (mass * 1e-3 * 9.803 * 0.148)
        )
        lines.append(f"{mass},14.8,{spin},{turn / 3:.2f},{2 * turn / 3:.2f},{turn:.2f}")
    text = "\n".join(["# g: 9.803 m/s^2", row.format("T1 (s)"), *lines])
    with pytest.raises(gyrodata.LogError) as caught:
        gyrodata.analyze(text.encode())
    errors = [one for one in caught.value.diagnostics if one.severity == "error"]
    corrected = row.format("time for 1 turn [s]")
    assert [one.code for one in errors] == ["G302"]
    assert errors[0].hint.endswith(f": {corrected}")
    result = gyrodata.analyze(text.replace(row.format("T1 (s)"), corrected).encode())
    assert abs(result.inertia.value / 4.4e-3 - 1) < 0.02
