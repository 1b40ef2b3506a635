"""What is not a number is asked about: texts in a load, impossible numbers of turns.
Powers of ten are numbers.
"""

from __future__ import annotations

from itertools import islice

import pytest

import gyrodata
from gyrodata.readings import Readings, read_log, write_log

ROLES = ("mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns")
ROWS = (
    ("20.1", "16.2", "193", "5.85", "1/3"),
    ("20.1", "16.2", "414", "24.75", "2/3"),
    ("40.2", "15.2", "192", "6.08", "2/3"),
    ("40.2", "15.2", "410", "12.73", "2/3"),
    ("60.1", "16.4", "386", "23.25", "2"),
    ("60.1", "16.4", "610", "18.37", "1"),
)
WORDS = (
    "?",
    "??",
    "n/a",
    "N/A",
    "n.a.",
    "NA",
    "na",
    "#N/A",
    "TBD",
    "tbd",
    "unknown",
    "x",
    "nan",
    "NaN",
    "see notes",
)


def table(rows: list[list[str]], head: tuple[str, ...] = ROLES) -> str:
    return "".join(";".join(row) + "\n" for row in [list(head), *rows])


def errors_of(log: Readings) -> list[gyrodata.Diagnostic]:
    return [one for one in log.diagnostics if one.severity == "error"]


# --- texts in a load ---


@pytest.mark.slow
@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("load", ["mass", "position", "force", "torque"])
def test_text_in_a_load_is_a_question(load: str, word: str) -> None:
    rows = [list(row) for row in ROWS]
    head = list(ROLES)
    at = 1 if load == "position" else 0
    if load == "force":
        head[0] = "force [N]"
        rows = [[f"{float(row[0]) * 9.8e-3:.4f}", *row[1:]] for row in rows]
    if load == "torque":
        head = ["torque [mN*m]", *head[2:]]
        rows = [
            [f"{float(row[0]) * float(row[1]) * 9.8e-2:.3f}", *row[2:]] for row in rows
        ]
    assert read_log(table(rows, tuple(head))).ok
    for run in (0, 1, 3):
        changed = [list(row) for row in rows]
        changed[run][at] = word
        found = read_log(table(changed, tuple(head)))
        asked = [
            one
            for one in errors_of(found)
            if one.line == run + 2 and one.column is not None
        ]
        assert asked, f"{word} in line {run + 2}"
        assert word in asked[0].message
        column = table(changed, tuple(head)).splitlines()[run + 1]
        assert column[asked[0].column - 1 :].startswith(word)


def test_new_weight_with_an_unknown_position_is_a_question() -> None:
    rows = [list(row) for row in ROWS]
    for row in rows[2:4]:
        row[1] = "?"
    with pytest.raises(gyrodata.LogError) as refused:
        gyrodata.analyze(table(rows))
    found = refused.value.diagnostics
    (error,) = [one for one in found if one.severity == "error"]
    assert error.line == 4
    assert error.message.endswith("also in line 5")


def test_unknown_position_without_a_weight_is_no_question() -> None:
    for word in ("?", "n/a", "-", ""):
        rows = [*map(list, ROWS), ["0", word, "401", "160.2", "1/3"]]
        assert read_log(table(rows)).ok


def test_unknown_mass_of_a_run_that_was_not_timed_is_no_question() -> None:
    rows = [*map(list, ROWS), ["?", "?", "?", "", ""]]
    found = read_log(table(rows))
    assert found.ok
    assert len(found.runs) == len(ROWS)


def test_value_for_the_whole_log_does_not_answer_a_question_mark() -> None:
    rows = [list(row) for row in ROWS]
    rows[2][1] = "?"
    assert errors_of(read_log("# position: 15 cm\n" + table(rows)))


# --- blank cells ---


def positions(cells: str) -> Readings:
    """A log with these positions, one letter for each run: b is blank."""
    known = {"a": "16.2", "c": "15.2", "d": "16.4", "b": ""}
    return read_log(
        table(
            [
                [row[0], known[cell], *row[2:]]
                for row, cell in zip(ROWS, cells, strict=True)
            ]
        )
    )


@pytest.mark.parametrize("cells", ["abcbdb", "abbbbb", "acccdb", "abcbdd"])
def test_blank_position_takes_the_one_above_for_the_same_weight(cells: str) -> None:
    found = positions(cells)
    assert found.ok
    column = found.columns["position"]
    assert None not in column.values
    again = read_log(write_log(found))
    assert again.columns["position"].values == column.values


@pytest.mark.parametrize(
    ("cells", "line"),
    [("aabbdd", 4), ("abcbbb", 6), ("abbbdb", 4), ("abbcdd", 4), ("aaccbb", 6)],
)
def test_blank_position_of_another_weight_is_a_question(cells: str, line: int) -> None:
    found = positions(cells)
    assert [one.code for one in errors_of(found)] == ["G302"]
    assert errors_of(found)[0].line == line
    assert "position" in errors_of(found)[0].message


# --- numbers of turns that are none ---

IMPOSSIBLE = ("1/0", "0/0", "0/3", "3/0", "12/00", "1⁄0", "1 / 0")
ODD = (
    *IMPOSSIBLE,
    "0",
    "1e999",
    "1e-999",
    "99999999999999999999",
    "1//3",
    "½/0",
    "1 1/0",
    "∞",
    "1:0",
    "zero",
)
LINES = (
    "time for {} turns",
    "{} turns",
    "turns: {}",
    "turns = {}",
    "time = {} turns",
    "Zeit für {} Umdrehungen",
)
HEADERS = (
    "time for {} turns [s]",
    "{} turns (s)",
    "t({} rev) [s]",
    "time {} turns",
    "t {} turn / s",
)


def logs_with(count: str) -> dict[str, str]:
    """Logs that write a number of turns in a line, title, caption, header or cell."""
    rows = [list(row) for row in ROWS]
    without = table([row[:4] for row in rows], ROLES[:4])
    logs = {f"cell: {count}": table([rows[0], [*rows[1][:4], count], *rows[2:]])}
    for words in LINES:
        text = words.format(count)
        logs |= {
            f"line with a column: {text}": f"# {text}\n{table(rows)}",
            f"line: {text}": f"# {text}\n{without}",
        }
        logs |= {
            f"title: {text}": f"{text}\n{without}",
            f"below: {text}": f"{without}{text}\n",
        }
    for words in HEADERS:
        text = words.format(count)
        logs[f"header: {text}"] = without.replace("time [s]", text)
        logs[f"header with a column: {text}"] = table(rows).replace("time [s]", text)
    return logs


@pytest.mark.slow
@pytest.mark.parametrize("count", ODD)
def test_impossible_number_of_turns_is_no_fault_of_the_tool(count: str) -> None:
    # Each count in a third of the places.
    for name, log in islice(logs_with(count).items(), ODD.index(count) % 3, None, 3):
        found = read_log(log)
        assert found.ok or all(one.code < "G900" for one in errors_of(found)), name
        turns = found.columns.get("turns")
        if found.ok and turns is not None:
            assert all(value and 0 < value < 100 for value in turns.values), name


@pytest.mark.slow
@pytest.mark.parametrize("count", IMPOSSIBLE)
@pytest.mark.parametrize("words", ["time for {} turns", "Zeit für {} Umdrehungen"])
def test_line_with_an_impossible_number_of_turns_is_an_error_with_its_line(
    words: str, count: str
) -> None:
    text = words.format(count)
    rows = [list(row) for row in ROWS]
    (error,) = errors_of(read_log(f"# station: 3\n# {text}\n{table(rows)}"))
    assert (error.code, error.line) == ("G306", 2)
    header = f"time for {count} turns [s]"
    errors = errors_of(
        read_log(
            table([row[:4] for row in rows], ROLES[:4]).replace("time [s]", header)
        )
    )
    assert errors
    assert errors[0].line == 1


# --- powers of ten ---


def power(number: str, form: str) -> str:
    """Write a number with a power of ten, or with a unit behind it."""
    mantissa, exponent = f"{float(number):.3e}".split("e")
    forms = {
        "E+": f"{mantissa}E{exponent}",
        "e": f"{mantissa}e{int(exponent)}",
        "e+": f"{mantissa}e{int(exponent):+d}",
        "comma": f"{mantissa}E{exponent}".replace(".", ","),
        "E0": f"{number}E0",
        "blank": f"{mantissa} E{exponent}",
    }
    return forms[form]


@pytest.mark.slow
@pytest.mark.parametrize("form", ["E+", "e", "e+", "comma", "E0", "blank"])
def test_powers_of_ten_are_numbers_in_every_column(form: str) -> None:
    rows = [
        [*row[:4], {"1/3": "0.5", "2/3": "1.5"}.get(row[4], row[4])] for row in ROWS
    ]
    plain = read_log(table(rows))
    for unit in (False, True):
        units = ("g", "cm", "rpm", "s", "")
        cells = []
        for row in rows:
            pairs = zip(row, units, strict=True)
            cells.append(
                [f"{power(cell, form)} {own * unit}".strip() for cell, own in pairs]
            )
        found = read_log(table(cells))
        assert found.ok
        for role, column in plain.columns.items():
            assert found.columns[role].values == pytest.approx(column.values, rel=1e-12)


def test_two_weights_may_be_added_as_powers_of_ten() -> None:
    rows = [
        ["1.005E+01 + 1.005E+01", *ROWS[0][1:]],
        ["2.0E+01 g + 0.1 g", *ROWS[1][1:]],
    ]
    found = read_log(table(rows))
    assert found.columns["mass"].values == pytest.approx((0.0201, 0.0201))
