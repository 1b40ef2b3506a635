"""`gyro schema`: every key of an output is declared, and every declared key is emitted,
at every depth.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from analyzed_once import analyzed_once
from places import ROOT
from typer.testing import CliRunner

from gyrodata.cli import app, schema

LOGS = [
    ROOT / "sample_data" / f"{name}.csv"
    for name in ("air_gyroscope", "heidelberg_ball")
]
HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"
EDGES = {
    "one run": HEAD + "20.00,15.0,206,20.4,1\n",
    "a slip": HEAD
    + "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n40.00,15.0,405,20.1,1\n40.00,15.0,607,30.1,2\n"
    "60.00,15.0,404,13.4,1\n60.00,15.0,603,20.0,1\n",
    "the ball": "# ball_mass: 1 kg\n# ball_diameter: 12 cm\n"
    + HEAD
    + "20,15,206,20.4,1\n40,15,405,20.1,1\n",
    "released": "# motion: released\n"
    + HEAD
    + "60,15,200,6.62,1\n60,15,400,13.24,1\n40,15,200,9.93,1\n",
    "tilted": "# pitch: 60 deg\n"
    + HEAD
    + "60,15,150,4.71,1\n60,15,300,9.74,1\n40,15,150,7.23,1\n40,15,300,14.69,1\n",
    "refused": HEAD + "20,15.0,56O,13.06,1/3\n",
}


@pytest.fixture(scope="module", autouse=True)
def analyses_are_kept() -> Iterator[None]:
    """``gyro analyze`` and ``gyro check`` show the same analysis."""
    with analyzed_once():
        yield


def gyro(*args: object, stdin: str | None = None) -> str:
    return CliRunner().invoke(app, [str(arg) for arg in args], input=stdin).stdout


def check(document: Any, output: str) -> None:
    """Validate, where a key that is not declared is a fault too, and none is left out."""
    strict(output).validate(document)


@cache
def strict(output: str) -> jsonschema.Draft202012Validator:
    declared = schema.json_schema(output)
    for name, table in declared["$defs"].items():
        keys = table["properties"]
        table["additionalProperties"] = False
        assert name == "Reported" or set(table["required"]) == set(keys), name
        assert len({key.casefold() for key in keys}) == len(keys), name
    return jsonschema.Draft202012Validator(declared)


@pytest.mark.slow
@pytest.mark.parametrize("log", [*EDGES, *(path.stem for path in LOGS), "none"])
def test_analysis_and_check(log: str) -> None:
    name, text = (
        ("-", EDGES[log]) if log in EDGES else (f"{ROOT}/sample_data/{log}.csv", None)
    )
    document = json.loads(gyro("analyze", name, "--format", "json", stdin=text))
    assert (document["result"] is None) == (log in ("refused", "none"))
    check(document, "analysis")
    check(
        json.loads(gyro("check", name, "--format", "json", stdin=text)),
        "check",
    )


@pytest.mark.slow
def test_analysis_that_keeps_what_is_flagged() -> None:
    document = json.loads(
        gyro(
            "analyze", "-", "--format", "json", "--keep-flagged", stdin=EDGES["a slip"]
        )
    )
    check(document, "analysis")


@pytest.mark.slow
def test_selfcheck() -> None:
    check(
        json.loads(gyro("selfcheck", LOGS[0], "--labs", "5", "--format", "json")),
        "selfcheck",
    )


@pytest.mark.slow
def test_grades(tmp_path: Path) -> None:
    copied = "# reported_inertia: (4.44 +- 0.05)e-3 kg m^2\n" + LOGS[0].read_text(
        encoding="utf-8"
    )
    for name, log in {
        "alice": copied,
        "bob": copied,
        "dave": EDGES["refused"],
        "eve": EDGES["a slip"],
    }.items():
        (tmp_path / "class" / name).mkdir(parents=True)
        (tmp_path / "class" / name / "data.csv").write_text(log, encoding="utf-8")
    for folder in (ROOT / "sample_data" / "class", tmp_path / "class"):
        text = gyro(
            "grade",
            folder,
            "--format",
            "json",
            "--workers",
            0,
            "--out",
            tmp_path / f"out-{folder.parent.name}",
        )
        check(json.loads(text), "grades")


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        "precession",
        "precession --spin 4rpm --pitch 40deg",
        "earth --latitude 52deg",
        "platform",
        "twist",
        "tip --spin 0rpm",
        f"precession --log {LOGS[0]}",
    ],
)
def test_predictions(command: str) -> None:
    check(
        json.loads(gyro("predict", *shlex.split(command), "--format", "json")),
        "predictions",
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", [*schema.DOCUMENTS, "rubric"])
def test_each_is_a_schema(name: str) -> None:
    document = json.loads(gyro("schema", name))
    jsonschema.Draft202012Validator.check_schema(document)
