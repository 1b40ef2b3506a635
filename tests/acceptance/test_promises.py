"""Each sentence that promises something of every log has a test, listed in
promises.toml; some of them are here.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from documents import DOCUMENTS, ROOT
from places import DATA, TESTS
from simulated_labs import analyze_briefly
from typer.testing import CliRunner

import gyrodata
from gyrodata.cli import app, schema
from gyrodata.grading.rubric import default_rubric_text
from gyrodata.reporting.markdown import markdown_report

LISTED: dict[str, dict[str, str]] = tomllib.loads(
    (DATA / "promises.toml").read_text(encoding="utf-8")
)
FRAGMENTS = [*LISTED["promises"], *LISTED["no_promise"]]
UNCONDITIONAL = re.compile(
    r"\b(always|never|every|only|the same|none)\b", re.IGNORECASE
)


def promises(text: str) -> Iterator[str]:
    """Give the sentences of a document that promise: no blocks, tables, headings and
    references.
    """
    text = re.sub(
        r"^```\w+\n.*?^```$",
        "\n",
        text.partition("## References")[0],
        flags=re.MULTILINE | re.DOTALL,
    )
    text = re.sub(
        r"^(?:\||#|!\[|\* .*: \[test_).*$|<!--.*?-->", "\n", text, flags=re.MULTILINE
    )
    for part in re.split(r"\n\s*\n|\n(?=\* |\d\. )", text):
        flowing = re.sub(r"\[|\](\([^)]*\))?", "", " ".join(part.split()))
        yield from filter(
            UNCONDITIONAL.search, re.split(r"(?<=[.?!:]) (?=[A-Z`*\"(-])", flowing)
        )


PROMISES = [one for path in DOCUMENTS for one in promises(path.read_text("utf-8"))]


def test_every_promise_has_one_test_and_every_test_is_there() -> None:
    told = " ".join(PROMISES).casefold()
    assert len(PROMISES) > 30
    for sentence in PROMISES:
        found = [one for one in FRAGMENTS if one.casefold() in sentence.casefold()]
        assert len(found) == 1, (
            f"name the test of this sentence in promises.toml: {sentence}"
        )
    assert [one for one in FRAGMENTS if one.casefold() not in told] == []
    tests = [test.split("::") for test in LISTED["promises"].values()]
    assert [
        one
        for one in tests
        if f"def {one[1]}(" not in (TESTS / one[0]).read_text("utf-8")
    ] == []


# --- what no other test checks ---

HEADER = ["mass [g]", "position [cm]", "spin [rpm]", "time [s]", "turns"]
ROWS = "".join(
    f"{mass},15.00,{spin},{0.98 * spin / mass:.2f},1\n"
    for mass in (20, 40, 60)
    for spin in (200, 400, 600)
)


def errors(header: list[str], rows: str) -> list[dict[str, Any]]:
    done = CliRunner().invoke(
        app, ["check", "-", "--format", "json"], input=f"{','.join(header)}\n{rows}"
    )
    return [
        one
        for one in json.loads(done.stdout)["diagnostics"]
        if one["severity"] == "error"
    ]


@pytest.mark.parametrize("at", range(5))
def test_turns_and_units_are_never_guessed(at: int) -> None:
    assert at or errors(HEADER, ROWS) == []
    name, header = HEADER[at].partition(" ")[0], [*HEADER]
    header[at] = "" if name == "turns" else name
    asked = errors(header, ROWS)
    assert asked
    assert all(one["hint"] for one in asked)
    assert any(name in one["message"] + one["hint"] for one in asked)


def keys(declared: Any, tables: dict[str, Any], before: str = "") -> Iterator[str]:
    """Give the path of every key that a schema declares."""
    if isinstance(declared, dict):
        if "$ref" in declared:
            inside = tables[declared["$ref"].removeprefix("#/$defs/")]
            kind = inside["properties"].get("prediction", {}).get("enum", [""])[0]
            yield from keys(inside, tables, f"{before}{kind}")
        for name, inside in declared.get("properties", {}).items():
            yield f"{before}.{name}"
            yield from keys(inside, tables, f"{before}.{name}")
        for name in ("items", "additionalProperties"):
            yield from keys(declared.get(name), tables, f"{before}[]")
        for inside in declared.get("anyOf", []) + declared.get("oneOf", []):
            yield from keys(inside, tables, before)


def test_no_key_is_taken_away() -> None:
    """A key that is added may be added to the list; a name of a schema with another
    number has a list of its own.
    """
    told, title = set(), ""
    for line in (DATA / "schema_keys.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith(" "):
            told.add(f"{title}{line}")
        else:
            title = line
    kinds = ("analysis", "check", "grades", "predictions", "selfcheck")
    wholes = [schema.json_schema(kind) for kind in kinds]
    assert told <= {
        f"{whole['title']} {key}"
        for whole in wholes
        for key in keys(whole, whole["$defs"])
    }


def graded(folder: Path) -> list[dict[str, Any]]:
    done = CliRunner().invoke(
        app,
        [
            "grade",
            str(ROOT / "sample_data" / "class"),
            "--workers",
            "0",
            "-o",
            str(folder),
        ],
    )
    assert done.exit_code == 1, done.output
    students: list[dict[str, Any]] = json.loads(
        (folder / "grades.json").read_text(encoding="utf-8")
    )["students"]
    return students


def test_the_desk_is_never_written_over(tmp_path: Path) -> None:
    desk = b'student,what,value,by,why\r\nadlernina, total ,16,Ann,"agreed"\r\n\r\n'
    graded(tmp_path)
    (tmp_path / "desk.csv").write_bytes(desk)
    for _ in range(2):
        assert [
            one["points"] for one in graded(tmp_path) if one["name"] == "adlernina"
        ] == [16]
        assert (tmp_path / "desk.csv").read_bytes() == desk


def test_a_flag_takes_no_points(tmp_path: Path) -> None:
    flagged = [one for one in graded(tmp_path) if one["flags"]]
    assert len(flagged) >= 2
    for one in flagged:
        assert one["points"] == sum(mark["points"] for mark in one["marks"])
        assert [
            mark
            for mark in one["marks"]
            if re.search("copy|flag|shared", mark["reason"])
        ] == []


def test_every_key_of_the_full_rubric_is_explained() -> None:
    parts = [part for part in default_rubric_text().split("\n\n") if "# " in part]
    shown = {word for part in parts for word in re.findall(r"\w+", part)}
    known = {
        key
        for table in schema.json_schema("rubric")["$defs"].values()
        for key in table.get("properties", {})
    }
    assert len(known) > 20
    # The uncertainties of a bench are called as in a log.
    assert sorted(one for one in known - shown if not one.startswith("u_")) == []


@pytest.mark.parametrize(
    "log", ["air_gyroscope", "heidelberg_ball", "salort_one_torque"]
)
def test_every_report_has_the_table_of_effects_and_the_defaults(log: str) -> None:
    lab = gyrodata.analyze(ROOT / "sample_data" / f"{log}.csv")
    shown = markdown_report(lab)
    assert len(lab.effects) > 3
    assert [
        one.effect
        for one in lab.effects
        if one.reason and one.reason not in shown.replace("\\", "")
    ] == []
    taken = [
        one for one in lab.measurements.sources if one.default and one.usual != "0"
    ]
    assert len(taken) > 3
    assert [one.name for one in taken if f"u_{one.name} {one.usual}" not in shown] == []


def test_a_constant_may_stand_in_the_log_or_on_the_command_line() -> None:
    log = f"{','.join(HEADER)}\n{ROWS}"
    within = analyze_briefly(f"# latitude: 42.5 deg\n{log}".encode())
    beside = analyze_briefly(log.encode(), settings={"latitude": "42.5 deg"})
    assert within.inertia == beside.inertia
    assert (
        within.measurements.g
        == beside.measurements.g
        != analyze_briefly(log.encode()).measurements.g
    )
