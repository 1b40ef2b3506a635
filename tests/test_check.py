"""`gyro check`, `gyro template` and `gyro schema`: what a log lacks, a log to fill in, and what outputs look like."""

from __future__ import annotations

import json
import re
import shlex
from itertools import pairwise
from pathlib import Path

import jsonschema
import pytest
from typer.testing import CliRunner, Result

from gyrodata import schema
from gyrodata.cli import app
from gyrodata.diagnostics import CODES
from gyrodata.readings import blank_log, read_log

ROOT = Path(__file__).parent.parent
SAMPLE = ROOT / "sample_data" / "air_gyroscope.csv"
HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"


def gyro(*arguments: str | Path, stdin: str | None = None) -> Result:
    return CliRunner().invoke(app, [str(a) for a in arguments], input=stdin, prog_name="gyro")


def found(log: str) -> dict[str, str]:
    told = json.loads(gyro("check", "-", "--format", "json", stdin=log).stdout)["diagnostics"]
    return {one["code"]: one["message"] for one in told}


class TestCheck:
    def test_a_complete_log_is_clean(self) -> None:
        done = gyro("check", SAMPLE)
        *_, last = done.stdout.splitlines()
        assert (done.exit_code, last) == (0, "air_gyroscope.csv: 10 runs, complete")

    @pytest.mark.parametrize("code", sorted(code for code in CODES if code.startswith("G45")))
    def test_the_example_of_each_code_raises_it(self, code: str) -> None:
        assert code in found(CODES[code].example)

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

    def test_exit_codes(self, tmp_path: Path) -> None:
        assert gyro("check", tmp_path / "none.csv").exit_code == 2
        poor = tmp_path / "poor.csv"
        poor.write_text(HEAD + "20.00,15.0,206,20.4,1\n", encoding="utf-8")
        assert gyro("check", poor).exit_code == 0
        assert gyro("check", poor, "--strict").exit_code == 1
        assert gyro("check", poor, "--strict", "--exit-zero").exit_code == 0
        assert gyro("selfcheck", "-", stdin=HEAD + "20,15.0,56O,13.06,1/3\n").exit_code == 1

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
    def test_filled_in_it_reads_without_a_diagnostic(self) -> None:
        blank = gyro("template", "--weights", "20g,40g", "--position", "150mm", "--spins", "200,400,600rpm").stdout
        rows = [line for line in blank.splitlines() if not line.startswith("#")]
        assert len(rows) == 1 + 2 * 3 + 2
        # Cells: mass, position, spin, time, turns, precession_sense, note.
        filled = blank
        for row in rows[1:]:
            mass, position, *_, note = row.split(",")
            filled = filled.replace(row, f"{mass},{position},400,39.7,1,,{note}")
        readings = read_log(filled.encode())
        assert readings.diagnostics == ()
        assert len(readings.runs) == 8

    @pytest.mark.parametrize("weights", [1, 2, 3, 5])
    @pytest.mark.parametrize("spins", [1, 2, 3, 4])
    def test_a_drift_of_the_balance_is_no_slope_in_the_torque(self, weights: int, spins: int) -> None:
        listed = [[f"{20 * (i + 1)} g" for i in range(weights)], [f"{200 * (i + 1)} rpm" for i in range(spins)]]
        rows = [line.split(",") for line in blank_log(listed[0], "15 cm", listed[1]).splitlines() if line[0].isdigit()]
        masses, aims = [row[0] for row in rows], [row[-1].rpartition("aim at ")[2] for row in rows]
        assert sorted(set(zip(masses, aims, strict=True)) - {("0", aims[masses.index("0")])}) == sorted(
            (f"{20 * (i + 1)}.00", f"{200 * (j + 1)} rpm") for i in range(weights) for j in range(spins)
        )
        assert len(rows) == weights * spins + 2
        assert (masses[0], aims[0]) == (masses[-1], aims[-1])
        assert "once more" in rows[-1][-1]
        if weights > 1:
            assert all(first != second for first, second in pairwise(masses))
        for mass in set(masses) if spins > 1 else ():
            places = [i for i, one in enumerate(masses) if one == mass]
            assert sum(places) / len(places) == pytest.approx((len(rows) - 1) / 2, abs=0.51)

    def test_the_student_says_whether_the_ball_is_balanced(self) -> None:
        lines = gyro("template").stdout.splitlines()
        at = lines.index("# balanced: ")
        assert "yes" in lines[at + 1]
        assert "no" in lines[at + 1]

    @pytest.mark.parametrize(
        ("spins", "aims"),
        [
            ("3,6,9 Hz", ["180 rpm", "360 rpm", "540 rpm"]),
            ("200.5rpm", ["200.5 rpm"]),
            ("0.5rpm,400rpm", ["0.5 rpm", "400 rpm"]),
        ],
    )
    def test_spins_to_aim_at_are_in_rpm(self, spins: str, aims: list[str]) -> None:
        lines = gyro("template", "--spins", spins).stdout.splitlines()
        told = {line.rpartition("aim at ")[2] for line in lines if "aim at " in line and line[0] in "246"}
        assert told == set(aims)

    def test_a_bare_number_is_refused_with_the_units_that_serve(self) -> None:
        done = gyro("template", "--weights", "20,40")
        assert done.exit_code == 2
        assert "write one behind it: g, kg; part several with commas" in done.stderr
        assert gyro("template", "--weights", "20 g,40 g").exit_code == 0

    @pytest.mark.parametrize("option", ["--weights", "--spins"])
    def test_no_weight_or_no_spin_is_refused_with_an_example(self, option: str) -> None:
        done = gyro("template", option, "")
        assert done.exit_code == 2
        assert f"for example {option} " in done.output


class TestSchema:
    def test_every_code_is_listed_with_an_example(self) -> None:
        text = gyro("schema", "--diagnostics").stdout
        rows = json.loads(gyro("schema", "--diagnostics", "--json").stdout)["diagnostics"]
        assert {row["code"] for row in rows} == set(CODES)
        parts = dict(zip((row["code"] for row in rows), re.split(r"(?m)^(?=G\d{3}  )", text)[1:], strict=True))
        for row in rows:
            assert parts[row["code"]].startswith(f"{row['code']}  {row['severity']}")
            # That of an empty log is nothing.
            assert bool(row["example"].strip()) == (row["code"] != "G103")
            shown = parts[row["code"]].split("\n")[1:]
            # Control characters as pictures.
            words = re.sub(r"[^ -~]", "?", row["example"].split("\n")[0]).split()
            assert re.sub(r"[^ -~]", "?", shown[0]).split() == words


@pytest.mark.parametrize(
    "code", sorted(code for code in CODES if code.startswith("G6") and code not in ("G606", "G609"))
)
def test_the_example_of_each_code_of_the_command_line_raises_it(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "log.csv").write_bytes(SAMPLE.read_bytes())
    done = gyro(*shlex.split(CODES[code].example))
    assert done.exit_code == 2
    assert code in done.output
