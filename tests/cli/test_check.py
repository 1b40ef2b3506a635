"""`gyro check`, `gyro template` and `gyro schema`: what a log lacks, a log to fill in,
and what outputs look like.
"""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import openpyxl
import pandas as pd
import pytest
from places import ROOT
from simulated_labs import analyze_briefly
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import GyroError
from gyrodata.cli import app
from gyrodata.cli.documentation import COMMANDS

SAMPLE = ROOT / "sample_data" / "air_gyroscope.csv"
HEAD = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"


def gyro(*arguments: str | Path, stdin: str | bytes | None = None) -> Result:
    return CliRunner().invoke(
        app, [str(a) for a in arguments], input=stdin, prog_name="gyro"
    )


def found(log: str) -> dict[str, str]:
    told = json.loads(gyro("check", "-", "--format", "json", stdin=log).stdout)[
        "diagnostics"
    ]
    return {one["code"]: one["message"] for one in told}


class TestCheck:
    @pytest.mark.slow
    def test_a_complete_log_is_clean(self) -> None:
        done = gyro("check", SAMPLE)
        *_, last = done.stdout.splitlines()
        assert (done.exit_code, last) == (0, "air_gyroscope.csv: 10 runs, complete")
        assert json.loads(gyro("check", SAMPLE, "--format", "json").stdout)["clean"]
        assert not json.loads(gyro("check", "none.csv", "--format", "json").stdout)[
            "clean"
        ]

    @pytest.mark.slow
    def test_reasons_are_numbers(self) -> None:
        told = found(
            HEAD
            + "60.00,15.0,206,2.26,1/3\n60.00,15.0,407,4.4,1/3\n40.00,15.0,407,20.1,1\n"
        )
        assert "2 torques (88.2 and 58.8 mN·m)" in told["G451"]
        assert "6.2 %" in told["G455"]
        assert "runs 1, 2" in told["G455"]

    def test_errors_and_findings_in_one_pass(self) -> None:
        done = gyro(
            "check", "-", stdin=HEAD + "20,15.0,56O,13.06,1/3\nx,15.0,206,0,1/3\n"
        )
        assert done.exit_code == 1
        assert "<stdin>:3:9: error G203" in done.stdout
        assert "<stdin>:4:12: error G215" in done.stdout
        assert done.stdout.splitlines()[-1].startswith("<stdin>: 2 runs, 3 errors")

    @pytest.mark.slow
    def test_exit_codes(self) -> None:
        poor, wrong = HEAD + "20.00,15.0,206,20.4,1\n", HEAD + "20,15.0,56O,13.06,1/3\n"
        lines = {
            "check none.csv": 2,
            "check -": 0,
        }
        assert {
            line: gyro(*line.split(), stdin=poor).exit_code for line in lines
        } == lines
        assert gyro("selfcheck", "-", stdin=wrong).exit_code == 1


class TestTemplate:
    @pytest.mark.slow
    @pytest.mark.parametrize(("weights", "spins"), [(1, 1), (3, 2), (5, 4)])
    def test_each_weight_is_hung_at_each_spin_and_the_first_once_more(
        self, weights: int, spins: int
    ) -> None:
        masses, aims = (
            [f"{step * (i + 1)}" for i in range(n)]
            for step, n in ((20, weights), (200, spins))
        )
        given = [
            ",".join(f"{mass}g" for mass in masses),
            ",".join(f"{aim}rpm" for aim in aims),
        ]
        blank = gyro(
            "template",
            "--weights",
            given[0],
            "--position",
            "150mm",
            "--spins",
            given[1],
        ).stdout
        _, *rows = [
            line.split(",") for line in blank.splitlines() if not line.startswith("#")
        ]
        runs = [
            (row[0].split(".")[0], row[-1].rpartition("aim at ")[2]) for row in rows
        ]
        assert sorted(set(runs) - {run for run in runs if run[0] == "0"}) == sorted(
            (mass, f"{aim} rpm") for mass in masses for aim in aims
        )
        assert (len(rows), runs[0], "once more" in rows[-1][-1]) == (
            weights * spins + 2,
            runs[-1],
            True,
        )
        # A drift of the balance is no slope in the torque: each weight is hung early
        # and late.
        for mass in set(masses) if spins > 1 else ():
            places = [i for i, run in enumerate(runs) if run[0] == mass]
            assert sum(places) / len(places) == pytest.approx(
                (len(rows) - 1) / 2, abs=0.51
            )
        filled = [[*row[:2], "400", "39.7", "1", *row[5:]] for row in rows]
        log = blank.partition(",".join(rows[0]))[0] + "".join(
            f"{','.join(row)}\n" for row in filled
        )
        readings = gyrodata.read_log(log)
        assert (readings.diagnostics, len(readings.runs)) == ((), len(rows))

    def test_spins_to_aim_at_are_in_rpm(self) -> None:
        told = gyro("template", "--spins", "3,6,9 Hz").stdout
        assert set(re.findall("aim at (.*)", told)) >= {"180 rpm", "360 rpm", "540 rpm"}
        told = gyro("template", "--spins", "25,40 rad/s").stdout
        assert set(re.findall("aim at (.*)", told)) >= {"239 rpm", "382 rpm"}


class TestSchema:
    def test_every_code_is_listed_with_an_example(self) -> None:
        text = gyro("schema", "diagnostics").stdout
        codes = explanations()
        parts = dict(zip(codes, re.split(r"(?m)^(?=G\d{3}  )", text)[1:], strict=True))
        for code, entry in codes.items():
            assert parts[code].startswith(f"{code}  {entry.severity}")
            assert bool(entry.example.strip()) == (code != "G103")
            shown = parts[code].split("\n")[1:]
            words = re.sub(r"[^ -~]", "?", entry.example.split("\n")[0]).split()
            assert re.sub(r"[^ -~]", "?", shown[0]).split() == words


LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
NOT_A_LINE = {"G108", "G312", "G606", "G609"}
"""The examples of these need a workbook, two logs, a full disk, or two gyros at the same
time."""
TYPED = {
    code
    for code, entry in explanations().items()
    if entry.example.split(" ")[0] in COMMANDS
} | {"G235"}


TOO_LARGE = {
    "G223": LOG + "20,15,400,7,1\n" * 100_001,
    "G224": "a," * 200 + "b\n1,2\n",
    "G225": LOG + "x" * 10_001 + "\n",
    "G416": LOG.splitlines()[0]
    + "".join(
        f"\n{20 + k // 2 / 100:.2f},15.0,400,{40 + k / 1000:.3f},1" for k in range(2600)
    ),
}
"""The logs of examples that are too large to be shown."""


def workbook_of(code: str, path: Path) -> None:
    """Write a log as a workbook with a formula that was not calculated (G110), or with
    a hidden row.
    """
    book = openpyxl.Workbook()
    for line in SAMPLE.read_text("utf-8").splitlines():
        book.active.append(line.split(","))
    last = book.active.max_row
    book.active.row_dimensions[last].hidden = code == "G111"
    if code == "G110":
        book.active.cell(last, 1).value = f"=A{last - 1}"
    book.save(path)


@pytest.mark.slow
@pytest.mark.parametrize(
    "code", sorted({code for code in TYPED if code < "G7"} - NOT_A_LINE)
)
def test_the_example_of_each_code_raises_it(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An example that is a command; `test_explain.py` has those that are logs."""
    monkeypatch.chdir(tmp_path)
    example = explanations()[code].example
    if code == "G235":
        frame = pd.DataFrame(
            {
                "mass [g]": [20.0],
                "spin [rpm]": 406,
                "time [s]": 39.06,
                "position [cm]": 15.0,
            }
        )
        with pytest.raises(GyroError) as caught:
            gyrodata.analyze(frame)
        assert code in [one.code for one in caught.value.diagnostics]
    else:
        Path("log.csv").write_text(
            LOG if code < "G6" else SAMPLE.read_text("utf-8"), "utf-8"
        )
        if code == "G106":
            Path("eleven-megabytes.csv").write_bytes(b"1" * 11_000_000)
        if code in ("G110", "G111"):
            workbook_of(code, Path(example.split()[1]))
        if code in TOO_LARGE:
            Path(example.split()[1]).write_text(TOO_LARGE[code])
        before, done = sorted(tmp_path.iterdir()), gyro(*shlex.split(example))
        assert code in done.output
        assert code[:3] != "G63" or (
            done.exit_code,
            done.stdout,
            sorted(tmp_path.iterdir()),
        ) == (2, "", before)


class TestFix:
    CLEAN = (
        "# g: 9.803 m/s^2\nmass [g];spin [rpm];position from centre (cm);T1 (s);T2 "
        "(s);turns;remark\n"
        "20,1;201;14,8;6,45;6,41;1/3;\n20,1;402;14,8;13,09;13,01;1/3;door\n"
        "40,3;201;14,8;6,75;6,70;2/3;\n40,3;400;14,8;13,15;13,21;2/3;\n60,2;200;14,8;6,47;6,50;1;\n"
    )

    def fixed(self, folder: Path, log: str) -> tuple[str, str]:
        """Give what is printed about the log that is written, and this log."""
        (folder / "log.csv").write_text(log, encoding="utf-8")
        done = gyro("check", "--fix", folder / "log.csv")
        return done.stdout.partition("log-fixed.csv: ")[2], (
            folder / "log-fixed.csv"
        ).read_text(encoding="utf-8")

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("before", "after", "left", "was", "correct"),
        [
            (
                "402;14,8",
                "4O2;14,8",
                'spin of run 2.1, written "4O2"',
                "20.1,14.8,?,",
                "20.1,14.8,402,",
            ),
            ("402;14,8", ";14,8", "line 4: no spin\n", "20.1,14.8,,", "20.1,14.8,402,"),
            (
                "40,3;400",
                "4O,3;400",
                'mass of run 4.1, written "4O,3"',
                "?,14.8,400",
                "40.3,14.8,400",
            ),
            (
                "13,09",
                "13,O9",
                'time of run 2.1, written "13,O9"',
                "402,?,",
                "402,13.09,",
            ),
            (
                "spin [rpm]",
                "spin [rmp]",
                'the column "spin [rmp]": its name, or its unit',
                "[rmp]",
                "[rpm]",
            ),
            (
                "mass [g]",
                "mass",
                'the column "mass": its name, or its unit',
                "run,note,mass",
                "run,note,mass [g]",
            ),
            (
                "9.803 m/s^2",
                "9.803 n/s",
                "the line # g: 9.803 n/s",
                "9.803 n/s",
                "9.803 m/s^2",
            ),
        ],
    )
    def test_filled_in_it_gives_the_answer_of_the_clean_log(
        self, before: str, after: str, left: str, was: str, correct: str, tmp_path: Path
    ) -> None:
        told, fixed = self.fixed(tmp_path, self.CLEAN.replace(before, after, 1))
        assert "left for you: 1" in told
        assert left in told
        assert fixed.count(was) == 1
        again, clean = (
            analyze_briefly(log).inertia
            for log in (fixed.replace(was, correct), self.CLEAN)
        )
        assert (again.value, again.u) == pytest.approx((clean.value, clean.u), rel=1e-9)

    def test_it_keeps_order_notes_and_unknown_columns(self, tmp_path: Path) -> None:
        told, fixed = self.fixed(
            tmp_path,
            self.CLEAN.replace("remark", "humidity").replace("9.803 m/s^2", "fast"),
        )
        assert "left for you: 2" in told
        rows = [line.split(",") for line in fixed.splitlines() if line[0] != "#"]
        assert rows[0] == [
            "mass [g]",
            "position [cm]",
            "spin [rpm]",
            "time [s]",
            "turns",
            "run",
            "humidity",
        ]
        assert [row[2] for row in rows[1::2]] == ["201", "402", "201", "400", "200"]
        assert rows[3][-1] == "door"

    def test_it_says_what_is_missing(self, tmp_path: Path) -> None:
        told, _ = self.fixed(tmp_path, self.CLEAN.replace("spin [rpm]", "Kram"))
        assert "   spin is missing" in told
        assert '   the column "Kram"' in told

    @pytest.mark.slow
    def test_no_other_file_is_written_over_and_other_logs_go_on(
        self, tmp_path: Path
    ) -> None:
        for name in ("a", "b"):
            (tmp_path / f"{name}.csv").write_text(self.CLEAN, encoding="utf-8")
        (tmp_path / "a-fixed.csv").write_text("mine", encoding="utf-8")
        for _ in range(2):
            done = gyro("check", "--fix", tmp_path / "a.csv", tmp_path / "b.csv")
            assert (tmp_path / "a-fixed.csv").read_text(encoding="utf-8") == "mine"
            assert analyze_briefly(tmp_path / "b-fixed.csv").inertia.value > 0
            assert "G603" in str(done.exception) + done.output

    @pytest.mark.slow
    @pytest.mark.parametrize(
        "path", sorted(SAMPLE.parent.glob("*.csv")), ids=lambda path: path.stem
    )
    def test_log_without_errors_keeps_its_answer(
        self, path: Path, tmp_path: Path
    ) -> None:
        text = path.read_text(encoding="utf-8")
        told, _ = self.fixed(tmp_path, text)
        assert "left for you: nothing" in told
        again, clean = (
            analyze_briefly(tmp_path / name).inertia
            for name in ("log-fixed.csv", "log.csv")
        )
        assert (again.value, again.u) == pytest.approx((clean.value, clean.u), rel=1e-9)


def test_line_of_the_answer_is_not_called_a_remark(tmp_path: Path) -> None:
    log = tmp_path / "lab.csv"
    answer = "# my_inertia: 4.40e-3 ± 0.04e-3 kg m^2\n# my_remark: 3\n"
    log.write_text(answer + gyrodata.sample().read_text("utf-8"), "utf-8")
    done = CliRunner().invoke(app, ["check", "--hand-in", str(log)])
    assert "read from lab.csv, line 1" in done.stdout
    assert "# my_inertia" not in done.stdout
