"""What students write around and beside their runs: it is used, asked about, or quoted."""

from __future__ import annotations

import io

import openpyxl
import pytest
from simulated_labs import analyze_briefly
from typed_labs import FOUR, START, is_true, log, questions

from gyrodata.base.errors import Diagnostic, GyroError
from gyrodata.grading.grade import station_of
from gyrodata.readings import Readings, read_log

FIVE = f"{FOUR},{{turns}}"
PLAIN = log(f"{START},turns", FIVE)


def readings(text: str) -> Readings:
    return read_log(text.encode())


def messages(text: str, code: str) -> list[Diagnostic]:
    return [each for each in readings(text).diagnostics if each.code == code]


@pytest.mark.parametrize(
    ("note", "named"),
    [
        ("The spin dropped to 70 % during every run", "the spin"),
        ("One washer weighs 12.5 g", "the mass"),
        ("Der Abstand war zuerst 2 cm kleiner", "the position"),
        ("Le temps de réaction est de 0,3 s", "the time"),
    ],
)
def test_a_sentence_of_which_nothing_is_used_is_quoted(note: str, named: str) -> None:
    (warning,) = messages(f"{note}\n{PLAIN}", "G240")
    assert note[:20] in warning.message
    assert named in warning.message
    assert is_true(f"{note}\n{PLAIN}")
    # What the hint and the explanation of a row of text propose.
    assert messages(f"# {note}\n{PLAIN}", "G240") == []
    assert messages(f"corrected: {note}\n{PLAIN}", "G240") == []


@pytest.mark.parametrize(
    "line",
    [
        "Lab 3: precession of a gyroscope",
        "Task 2",
        "all runs at 14.8 cm from the centre",
        "14 May, group 3",
    ],
)
def test_a_title_or_a_used_sentence_is_not_quoted(line: str) -> None:
    assert messages(f"{line}\n{PLAIN}", "G240") == []


def test_a_note_names_each_reading_that_it_may_change() -> None:
    note = "two strips on the weight, so the tachometer shows twice the rpm"
    (warning,) = messages(f"# {note}\n{PLAIN}", "G240")
    assert "the mass or the spin" in warning.message


def test_a_sentence_with_commas_is_one_note() -> None:
    note = "NB the ruler was in inches, the header is wrong for the arm"
    assert len(messages(f"{PLAIN}{note}\n", "G240")) == 1
    assert messages(f"{PLAIN}corrected: {note}\n", "G240") == []


def test_the_difference_of_start_and_stop_is_the_time() -> None:
    head = "mass [g],position [cm],spin [rpm],start (s),stop (s),turns"
    rows = PLAIN.splitlines()[2:]
    clock = []
    for number, row in enumerate(rows):
        *settings, time, turns = row.split(",")
        start = 2.5 + number
        clock.append(
            ",".join([*settings, f"{start}", f"{start + float(time):.2f}", turns])
        )
    (question,) = questions("\n".join([PLAIN.splitlines()[0], head, *clock]) + "\n")
    assert 'write "stop (s)" minus "start (s)" in a column "time [s]"' in question.hint


def test_several_periods_are_read_and_a_part_is_asked_about() -> None:
    three = log(
        "mass [g],position [cm],spin [rpm],3T (s)", "{mass},14.8,{spin},{period}"
    )
    cells = [row.split(",") for row in three.splitlines()[2:]]
    tripled = [",".join([*cell[:3], f"{3 * float(cell[3]):.2f}"]) for cell in cells]
    assert is_true("\n".join([*three.splitlines()[:2], *tripled]) + "\n")
    half = three.replace("3T (s)", "T/2 (s)")
    assert 'write "time for 1/2 turn [s]" above it' in questions(half)[0].hint
    with pytest.raises(Exception, match='contains "T/2"'):
        analyze_briefly(half.encode(), mapping={"precession_period": "T/2 (s)"})


def test_a_row_of_units_with_an_unknown_one_is_asked_about_with_a_header_row() -> None:
    head = "mass,position,spin,time,turns,temperature,battery\ng,cm,rpm,s,,°C,V"
    with pytest.raises(
        GyroError, match="mass \\[g\\],position \\[cm\\],spin \\[rpm\\]"
    ):
        analyze_briefly(log(head, f"{FIVE},21.5,9.1").encode())


def test_spins_in_two_units_are_one_spin() -> None:
    text = log(f"{START},turns,spin [rad/s]", f"{FIVE},{{spin}}")
    rows = []
    for row in text.splitlines()[2:]:
        *others, spin = row.split(",")
        rows.append(",".join([*others, f"{float(spin) * 0.104720:.4f}"]))
    assert is_true("\n".join([*text.splitlines()[:2], *rows]) + "\n")


@pytest.mark.parametrize(
    "row",
    [
        ("Moment of inertia I_zz", 0.0044, "±", 4e-05, "kg m²"),
        ("I_zz", 0.0044, 4e-05, "kg m^2"),
        ("I_zz", "(4.40 ± 0.04) × 10⁻³", "kg m²"),
    ],
)
def test_a_second_sheet_may_contain_the_result(row: tuple[object, ...]) -> None:
    workbook = openpyxl.Workbook()
    for line in PLAIN.splitlines()[1:]:
        workbook.active.append([_typed(cell) for cell in line.split(",")])
    results = workbook.create_sheet("Results")
    results.append(["A. Student"])
    results.append(list(row))
    file = io.BytesIO()
    workbook.save(file)
    result = read_log(file.getvalue())
    assert result.ok
    assert result.reported["inertia"].value == pytest.approx(0.0044)
    assert result.reported["inertia"].u == pytest.approx(4e-5)


def _typed(cell: str) -> object:
    try:
        return float(cell)
    except ValueError:
        return cell


@pytest.mark.parametrize(
    "line",
    [
        "# station: 2",
        "# Station 2",
        "station: 2",
        "Station,2",
        "# estación: 2",
        "# poste: 2",
        "# stanowisko: 2",
        "# установка: 2",
    ],
)
def test_a_log_names_its_station(line: str) -> None:
    assert station_of(readings(f"{line}\n{PLAIN}")) == "2"
    assert is_true(f"{line}\n{PLAIN}")


@pytest.mark.parametrize("line", ["Station 2 on Monday", "station", "# my station: ok"])
def test_other_lines_are_no_station(line: str) -> None:
    assert station_of(readings(f"{line}\n{PLAIN}")) is None


def test_a_blank_cell_below_percent_is_a_run_that_lacks_its_turns() -> None:
    percent = log(f"{START},turns [%]", f"{FOUR},{{percent}}")
    assert is_true(percent)
    *rows, last = percent.splitlines()
    (fault,) = questions("\n".join([*rows, f"{last.rpartition(',')[0]},"]) + "\n")
    assert fault.code == "G302"


def test_a_clock_that_ran_on_between_the_runs_is_named() -> None:
    head, row = f"{START},turns", "{mass},14.8,{spin},{period:.2f},1"
    total = 0.0
    rows = []
    for line in log(head, row).splitlines()[2:]:
        *settings, time, turns = line.split(",")
        total += float(time) + 10
        rows.append(",".join([*settings, f"{total:.1f}", turns]))
    (refusal,) = questions("\n".join(["# g: 9.80665 m/s^2", head, *rows]) + "\n")
    assert "write the differences" in refusal.hint


def test_a_log_of_two_stations_is_asked_about() -> None:
    (fault,) = questions(f"Station 1\n{PLAIN}Station 2\n")
    assert fault.code == "G307"
