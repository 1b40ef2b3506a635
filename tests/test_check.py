"""`gyro check`, `gyro template` and `gyro schema`: what a log lacks, a log to fill in, and what outputs look like."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import jsonschema
import pandas as pd
import pytest
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata import schema
from gyrodata.cli import app
from gyrodata.diagnostics import CODES
from gyrodata.errors import GyroError

ROOT = Path(__file__).parent.parent
SAMPLE = ROOT / "sample_data" / "air_gyroscope.csv"
HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"


def gyro(*arguments: str | Path, stdin: str | bytes | None = None) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments], input=stdin, prog_name="gyro")


def found(log: str) -> dict[str, str]:
    told = json.loads(gyro("check", "-", "--format", "json", stdin=log).stdout)["diagnostics"]
    return {one["code"]: one["message"] for one in told}


class TestCheck:
    def test_a_complete_log_is_clean(self) -> None:
        done = gyro("check", SAMPLE)
        *_, last = done.stdout.splitlines()
        assert (done.exit_code, last) == (0, "air_gyroscope.csv: 10 runs, complete")

    def test_reasons_are_numbers(self) -> None:
        told = found(HEAD + "60.00,15.0,206,2.26,1/3\n60.00,15.0,407,4.4,1/3\n40.00,15.0,407,20.1,1\n")
        assert "2 torques (88.2 and 58.8 mN·m)" in told["G451"]
        assert "6.2 %" in told["G455"]
        assert "runs 1, 2" in told["G455"]

    def test_errors_and_findings_in_one_pass(self) -> None:
        done = gyro("check", "-", stdin=HEAD + "20,15.0,56O,13.06,1/3\nx,15.0,206,0,1/3\n")
        assert done.exit_code == 1
        assert "<stdin>:3:9: error G203" in done.stdout
        assert "<stdin>:4:12: error G215" in done.stdout
        assert done.stdout.splitlines()[-1].startswith("<stdin>: 2 runs, 3 errors")

    def test_exit_codes(self) -> None:
        poor, wrong = HEAD + "20.00,15.0,206,20.4,1\n", HEAD + "20,15.0,56O,13.06,1/3\n"
        lines = {"check none.csv": 2, "check -": 0, "check - --strict": 1, "check - --strict --exit-zero": 0}
        assert {line: gyro(*line.split(), stdin=poor).exit_code for line in lines} == lines
        assert gyro("selfcheck", "-", stdin=wrong).exit_code == 1

    def test_json_follows_its_schema(self, tmp_path: Path) -> None:
        for log in (SAMPLE, tmp_path / "none.csv"):
            document = json.loads(gyro("check", log, "--format", "json").stdout)
            jsonschema.validate(document, schema.check_schema())
            assert document["clean"] == (log == SAMPLE)

    def test_annotations(self, tmp_path: Path) -> None:
        log = tmp_path / "data.csv"
        log.write_text(HEAD + "20,15.0,56O,13.06,1/3\n", encoding="utf-8")
        line = gyro("check", log, "--format", "github").stdout.splitlines()[0]
        assert line == f'::error file={log},line=3,col=9,title=G203::spin "56O" is not a number%0Adid you mean 560?'


class TestTemplate:
    @pytest.mark.parametrize(("weights", "spins"), [(1, 1), (3, 2), (5, 4)])
    def test_each_weight_is_hung_at_each_spin_and_the_first_once_more(self, weights: int, spins: int) -> None:
        masses, aims = ([f"{step * (i + 1)}" for i in range(n)] for step, n in ((20, weights), (200, spins)))
        given = [",".join(f"{mass}g" for mass in masses), ",".join(f"{aim}rpm" for aim in aims)]
        blank = gyro("template", "--weights", given[0], "--position", "150mm", "--spins", given[1]).stdout
        _, *rows = [line.split(",") for line in blank.splitlines() if not line.startswith("#")]
        runs = [(row[0].split(".")[0], row[-1].rpartition("aim at ")[2]) for row in rows]
        assert sorted(set(runs) - {run for run in runs if run[0] == "0"}) == sorted(
            (mass, f"{aim} rpm") for mass in masses for aim in aims
        )
        assert (len(rows), runs[0], "once more" in rows[-1][-1]) == (weights * spins + 2, runs[-1], True)
        # A drift of the balance is no slope in the torque: each weight is hung early and late.
        for mass in set(masses) if spins > 1 else ():
            places = [i for i, run in enumerate(runs) if run[0] == mass]
            assert sum(places) / len(places) == pytest.approx((len(rows) - 1) / 2, abs=0.51)
        filled = [[*row[:2], "400", "39.7", "1", *row[5:]] for row in rows]
        log = blank.partition(",".join(rows[0]))[0] + "".join(f"{','.join(row)}\n" for row in filled)
        readings = gyrodata.read_log(log)
        assert (readings.diagnostics, len(readings.runs)) == ((), len(rows))

    def test_the_student_says_whether_the_ball_is_balanced(self) -> None:
        assert re.search(r"(?m)^# balanced: \n.*yes.*no", gyro("template").stdout)

    def test_spins_to_aim_at_are_in_rpm(self) -> None:
        told = gyro("template", "--spins", "3,6,9 Hz").stdout
        assert set(re.findall("aim at (.*)", told)) >= {"180 rpm", "360 rpm", "540 rpm"}


class TestSchema:
    def test_every_code_is_listed_with_an_example(self) -> None:
        text = gyro("schema", "--diagnostics").stdout
        rows = json.loads(gyro("schema", "--diagnostics", "--json").stdout)["diagnostics"]
        assert {row["code"] for row in rows} == set(CODES)
        parts = dict(zip((row["code"] for row in rows), re.split(r"(?m)^(?=G\d{3}  )", text)[1:], strict=True))
        for row in rows:
            assert parts[row["code"]].startswith(f"{row['code']}  {row['severity']}")
            assert bool(row["example"].strip()) == (row["code"] != "G103")
            shown = parts[row["code"]].split("\n")[1:]
            words = re.sub(r"[^ -~]", "?", row["example"].split("\n")[0]).split()
            assert re.sub(r"[^ -~]", "?", shown[0]).split() == words


LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
NOT_A_LINE = {"G108", "G606", "G609"}
"""The examples of these need a workbook, a full disk, or two gyros at the same time."""


@pytest.mark.parametrize("code", sorted({code for code in CODES if re.match("G([1235]|45|6)", code)} - NOT_A_LINE))
def test_the_example_of_each_code_raises_it(code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    example = CODES[code].example
    if code == "G235":
        frame = pd.DataFrame({"mass [g]": [20.0], "spin [rpm]": 406, "time [s]": 39.06, "position [cm]": 15.0})
        with pytest.raises(GyroError) as caught:
            gyrodata.analyze(frame)
        assert code in [one.code for one in caught.value.diagnostics]
    elif re.match("(analyze|template|explain|check|predict|simulate|schema) ", example):
        Path("log.csv").write_text(LOG if code < "G6" else SAMPLE.read_text("utf-8"), "utf-8")
        if code == "G106":
            Path("eleven-megabytes.csv").write_bytes(b"1" * 11_000_000)
        if code == "G223":
            Path("hundred-thousand-rows.csv").write_text(LOG + "20,15,400,7,1\n" * 100_001)
        assert code in gyro(*shlex.split(example)).output
    else:
        data = example.encode("latin-1" if code in ("G107", "G109") else "utf-8")
        told = json.loads(gyro("check", "-", "--format", "json", stdin=data).stdout)["diagnostics"]
        assert {one["severity"] for one in told if one["code"] == code} == {CODES[code].severity}
