"""Logs in JSON: records, columns as pandas writes them, and what is not a table."""

from __future__ import annotations

import json
from typing import Any

import pandas as pd
import pytest
from simulated_labs import analyze_briefly

from gyrodata.base.errors import GyroError
from gyrodata.readings import read_log, write_log

LOG = {
    "mass [g]": ["20.10", "20.10", "40.30", "40.30", "60.20"],
    "position [cm]": ["14.80"] * 5,
    "spin [rpm]": ["201", "400", "201", "400", "602"],
    "time [s]": ["20.12", "40.04", "10.04", "19.97", "20.12"],
    "turns": ["1"] * 5,
}


def as_csv() -> str:
    return (
        "\n".join(",".join(row) for row in (LOG, *zip(*LOG.values(), strict=True)))
        + "\n"
    )


def typed(log: dict[str, list[str]]) -> str:
    """Write columns as JSON with the numbers as they were typed."""
    return (
        "{"
        + ", ".join(f'"{name}": [{", ".join(cells)}]' for name, cells in log.items())
        + "}"
    )


def frame() -> pd.DataFrame:
    return pd.DataFrame(
        {name: [float(cell) for cell in cells] for name, cells in LOG.items()}
    )


def records() -> str:
    rows = zip(*LOG.values(), strict=True)
    return (
        "["
        + ",\n ".join(
            "{"
            + ", ".join(
                f'"{name}": {cell}' for name, cell in zip(LOG, row, strict=True)
            )
            + "}"
            for row in rows
        )
        + "]"
    )


EXACT = {
    "columns": typed(LOG),
    "columns below a key": '{"station": "3", "data": ' + typed(LOG) + "}",
    "records": records(),
    "records below a key": '{"station": "3", "runs": ' + records() + "}",
    "after a blank line": "\n  " + typed(LOG),
}


@pytest.mark.slow
@pytest.mark.parametrize("text", EXACT.values(), ids=list(EXACT))
def test_json_gives_the_same_answer_as_csv(text: str) -> None:
    expected, inertia = (
        analyze_briefly(as_csv()).inertia,
        analyze_briefly(text.encode()).inertia,
    )
    assert (inertia.value, inertia.u) == (expected.value, expected.u)


@pytest.mark.slow
@pytest.mark.parametrize(
    "orient", ["list", "dict", "records", "index of pandas", "table"]
)
def test_json_of_pandas_is_read(orient: str) -> None:
    text = {
        "list": lambda: json.dumps(frame().to_dict("list")),
        "dict": lambda: json.dumps(frame().to_dict("dict")),
        "records": lambda: frame().to_json(orient="records"),
        "index of pandas": lambda: frame().to_json(),
        "table": lambda: frame().to_json(orient="table", index=False),
    }[orient]()
    assert analyze_briefly(text.encode()).inertia.value == pytest.approx(
        analyze_briefly(as_csv()).inertia.value, rel=1e-3
    )


def test_constants_and_blank_cells_of_json_are_read() -> None:
    log: dict[str, Any] = {
        name: [float(cell) for cell in cells] for name, cells in LOG.items()
    }
    log["note"] = [None, "door", float("nan"), "a\tb", ""]
    readings = read_log(json.dumps({"g": "9.803 m/s^2", **log}).encode())
    assert readings.constants == {"g": 9.803}
    assert readings.notes == ("", "door", "", "a b", "")


def refusal(text: str) -> str:
    with pytest.raises(GyroError) as caught:
        analyze_briefly(text.encode(), name="lab.json")
    return str(caught.value)


DEPTH = 100_000
"""More brackets than any version of Python reads."""
BRACKETS = "[" * DEPTH + "]" * DEPTH

DEEP = {
    "lists": BRACKETS,
    "objects": '{"a":' * DEPTH + "1" + "}" * DEPTH,
    "inside of a table": typed(LOG)[:-1] + ', "b": ' + BRACKETS + "}",
    "inside of a notebook": '{"cells": [{"cell_type": "code", "source": ["x"], "m": '
    + BRACKETS
    + "}]}",
    "never closed": '{"a":' * DEPTH,
}


@pytest.mark.parametrize("text", DEEP.values(), ids=list(DEEP))
def test_deep_json_is_refused_in_words(text: str) -> None:
    said = refusal(text)
    assert said.startswith(
        "lab.json: error G104: this is JSON, but not a table: it contains too many "
        "brackets inside of brackets"
    )
    assert '{"mass [g]": [20, 40], "spin [rpm]": [400, 600]}' in said


def test_brackets_in_a_text_of_json_are_no_depth() -> None:
    text = typed(LOG)[:-1] + ', "note": ["' + "[{" * 100 + '", "\\"", "", "", ""]}'
    assert analyze_briefly(text.encode()).inertia.value


@pytest.mark.parametrize(
    "text",
    [
        records().replace('"turns": 1}', '"time [s]": 14.0, "turns": 1}', 1),
        typed(LOG)[:-1] + ', "mass [g]": [1, 2, 3, 4, 5]}',
        '{"g": "9.8 m/s^2", "g": "9.9 m/s^2", "runs": ' + records() + "}",
    ],
    ids=["record", "column", "constant"],
)
def test_key_that_json_contains_twice_is_an_error(text: str) -> None:
    assert 'contains the key "' in refusal(text)
    assert "twice" in refusal(text)


def test_lists_of_different_lengths_are_refused() -> None:
    assert "its columns do not have the same length" in refusal(
        typed(LOG | {"turns": ["1"] * 4})
    )


def test_two_tables_in_one_object_are_refused() -> None:
    table = json.loads(records())
    assert "several tables, practice, runs: keep one" in refusal(
        json.dumps({"practice": table, "runs": table})
    )


def test_half_of_a_sign_in_a_name_is_read() -> None:
    table = [{**run, "\ud800": 1} for run in json.loads(records())]
    assert write_log(read_log(json.dumps(table).encode(), name="log.json")).encode(
        "utf-8"
    )
