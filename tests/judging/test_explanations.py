"""Explanations: what the runs of a log would agree with, and how sure gyro is of it.

The logs are simulated: I_zz = 0.0044 kg*m^2, numpy seeds as written, and an error of
0.1 s in each time.
"""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from simulated_labs import analyze_briefly, kinds_of_doubts
from typer.testing import CliRunner

import gyrodata
from gyrodata.cli import app
from gyrodata.results import FittedLog

TRUTH, G = 4.4e-3, 9.803
HEAD = "# g: 9.803 m/s^2\n# motion: steady\nmass [g],position [cm],spin [rpm],time [s],turns\n"
MASSES, SPINS = (20.1, 40.3, 60.2), (205, 394, 603)
Rows = list[list[str]]


def rows(seed: int, imbalance: float = 0.01) -> Rows:
    """Write nine runs of one turn; M0 is a part of the lightest torque."""
    random = np.random.default_rng(seed)
    written = []
    for mass in MASSES:
        torque = (mass + imbalance * MASSES[0]) * 1e-3 * G * 0.148
        for spin in SPINS:
            time = 2 * np.pi * TRUTH * spin * np.pi / 30 / torque
            shown = f"{time + random.normal(0, 0.1):.2f}"
            written.append([f"{mass:.1f}", "14.8", str(spin), shown, "1"])
    return written


def analyze(table: Rows) -> gyrodata.Analysis:
    text = HEAD + "".join(",".join(row) + "\n" for row in table)
    return gyrodata.analyze(text.encode())


def fitted(table: Rows) -> FittedLog:
    """Analyse a log without what only a report shows."""
    text = HEAD + "".join(",".join(row) + "\n" for row in table)
    return analyze_briefly(text.encode())


def explained(table: Rows) -> tuple[Any, ...]:
    return fitted(table).explanations


def off(found: FittedLog) -> float:
    return abs(found.inertia.value - TRUTH) / found.inertia.u


def with_load(seed: int, weight: int, column: int, text: str) -> Rows:
    """Change the mass or the position of all runs of a weight."""
    table = rows(seed)
    for row in table[3 * weight : 3 * weight + 3]:
        row[column] = text
    return table


WRONG_LOADS = [
    (0, 0, "12.1", "12.1 g at 14.8 cm"),
    (1, 1, "17.8", "40.3 g at 17.8 cm"),
    (2, 0, "52.2", "52.2 g at 14.8 cm"),
]


@pytest.mark.parametrize(("weight", "column", "text", "load"), WRONG_LOADS)
def test_wrong_load_of_a_weight_is_the_first_one_named(
    weight: int, column: int, text: str, load: str
) -> None:
    found = fitted(with_load(weight, weight, column, text))
    (first, *_) = [each for each in found.explanations if each.kind == "weight"]
    assert f"all 3 runs of {load} would agree with the others if" in first.words
    # The true value is proposed, with the digits of the log.
    quantity = "position" if column else "mass"
    proposed = float(re.search(rf"its {quantity} were ([\d.]+)", first.words)[1])
    assert proposed == pytest.approx(14.8 if column else MASSES[weight], rel=0.06)
    # No single run is blamed, and a wrong answer is never without a doubt.
    assert not [each for each in found.diagnostics if each.code == "G410"]
    assert kinds_of_doubts(found) or off(found) < 3
    assert any(first.words in each.message for each in found.diagnostics)


def test_weight_that_is_certainly_wrong_is_left_out() -> None:
    found = analyze(with_load(0, 0, 0, "2.01"))
    assert [each.kind for each in found.explanations] == ["weight"]
    assert [run.run for run in found.run_table if run.left_out] == ["1", "2", "3"]
    assert "is wrong" in found.run_table[0].reason
    assert "decimal point" in found.explanations[0].words
    assert not found.doubts
    assert off(found) < 3


def test_balance_and_weight_are_both_listed_and_nothing_is_left_out() -> None:
    found = analyze(with_load(1, 2, 0, "52.2"))
    assert {each.kind for each in found.explanations} == {"weight", "balance"}
    assert not any(run.left_out for run in found.run_table)
    (doubt, *_) = found.doubts
    assert all(each.words in doubt.words for each in found.explanations)
    assert sum(each.probability for each in found.explanations) <= 1


def exchanged(table: Rows, runs: tuple[int, int], columns: slice) -> Rows:
    first, second = (table[run - 1] for run in runs)
    first[columns], second[columns] = second[columns], first[columns]
    return table


CELLS = {
    "spins": (exchanged(rows(2), (2, 9), slice(2, 3)), "spins of runs 2 and 9", "29"),
    "times": (exchanged(rows(3), (3, 7), slice(3, 4)), "times .* runs 3 and 7", "37"),
    "rows": (exchanged(rows(4), (1, 6), slice(2, 5)), "weights of runs 1 and 6", "16"),
}


@pytest.mark.parametrize("name", CELLS)
def test_cells_of_two_runs_that_are_exchanged_are_named(name: str) -> None:
    table, words, runs = CELLS[name]
    found = fitted(table)
    assert re.search(words, found.explanations[0].words)
    assert "".join(run.run for run in found.run_table if run.left_out) == runs
    assert off(found) < 3


def test_time_and_spin_exchanged_in_a_row_are_named() -> None:
    table = rows(5)
    table[4][2:4] = table[4][3:1:-1]
    assert "time and spin exchanged" in explained(table)[0].words


def test_minutes_and_seconds_typed_as_a_decimal_number_are_named() -> None:
    table = rows(6)
    (minutes, seconds) = divmod(round(2 * float(table[2][3])), 60)
    table[2][3:] = f"{minutes}.{seconds:02d}", "2"
    (explanation,) = explained(table)
    assert f"Then write {minutes}:{seconds:02d}" in explanation.words


def test_spins_of_one_weight_that_are_doubled_are_named() -> None:
    table = rows(7)
    for row in table[3:6]:
        row[2] = str(2 * int(row[2]))
    (first, *_) = [e for e in explained(table) if e.kind == "weight"]
    assert "their spins were half as large" in first.words


def test_a_log_that_agrees_has_no_explanation() -> None:
    assert [explained(rows(seed)) for seed in range(5)] == [()] * 5


def test_check_and_json_show_the_same_explanations() -> None:
    table = with_load(1, 2, 0, "52.2")
    text = HEAD + "".join(",".join(row) + "\n" for row in table)
    found = gyrodata.analyze(text.encode())
    shown = CliRunner().invoke(app, ["check", "-"], input=text).output
    done = CliRunner().invoke(app, ["analyze", "-", "--format", "json"], input=text)
    result = json.loads(done.stdout)["result"]
    listed = [each["words"] for each in result["explanations"]]
    assert listed == [each.words for each in found.explanations]
    assert all(words in " ".join(shown.split()) for words in listed)


def log_with_wrong_origin(seed: int, off: float, line: str = "") -> str:
    """Write 18 runs whose positions are all too small by `off` [m]."""
    random = np.random.default_rng(seed)
    written = [f"{line}# u_time: 0.1 s\n{HEAD}"]
    for mass in MASSES[:2]:
        for position in (9.0, 13.0, 17.0):
            for spin in SPINS:
                torque = mass * 1e-3 * G * (position / 100 + off)
                time = 2 * np.pi * TRUTH * spin * np.pi / 30 / torque
                shown = f"{time + random.normal(0, 0.1):.2f}"
                written.append(f"{mass:.1f},{position:.1f},{spin},{shown},1\n")
    return "".join(written)


@pytest.mark.parametrize("seed", [0, 6, 11])
def test_the_remedy_of_a_wrong_origin_gives_the_right_answer(seed: int) -> None:
    found = analyze_briefly(log_with_wrong_origin(seed, 6e-3).encode())
    assert found.explanations[0].kind == "origin"
    line = re.search(r"# u_position_zero: \S+ mm", found.explanations[0].remedy)
    assert line is not None
    mended = analyze_briefly(log_with_wrong_origin(seed, 6e-3, f"{line[0]}\n").encode())
    assert off(mended) < 2
    assert mended.explanations == ()
