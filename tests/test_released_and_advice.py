"""A slow rod that is released, and advice that a user can follow, as both are seen from outside."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.cli import app
from gyrodata.readings import write_log


def gyro(*arguments: str, stdin: str | None = None) -> Result:
    return CliRunner().invoke(app, list(arguments), input=stdin)


def released(spins: str, seed: int, *more: str) -> str:
    """Simulate a lab in which the rod is released."""
    options = ("--motion", "released", "--spins", f"{spins}rpm", "--seed", str(seed), *more)
    return gyro("simulate", *options).stdout


def analyzed(log: str) -> Result:
    return gyro("analyze", "-", "--no-report", stdin=log)


class TestReleased:
    @pytest.mark.parametrize("spins", ["20,30,40", "30,45,60", "40,60,80"])
    @pytest.mark.parametrize("seed", range(1, 11))
    def test_slow_rod_has_no_answer(self, spins: str, seed: int) -> None:
        log = released(spins, seed)
        done = analyzed(log)
        assert done.exit_code == 1
        assert "error G425" in done.stderr
        assert "I_zz = " not in done.stdout
        run, degrees = re.search(r"run (\d+): .* falls by about (\d+) degrees and hits the cup", done.stderr).groups()
        slowest = spins.split(",")[0]
        assert run == "7"
        assert f"at {slowest} rpm with" in done.stderr
        # A rod with 60 g at 15 cm that is released level, by the conservation laws.
        assert int(degrees) == pytest.approx({"20": 75, "30": 68, "40": 61}[slowest], abs=5)
        line = next(i for i, row in enumerate(log.splitlines(), 1) if row.endswith(",7"))
        assert f"<stdin>:{line}:" in done.stderr

    @pytest.mark.parametrize("spins", ["60,100,150", "100,200,300", "200,400,600"])
    @pytest.mark.parametrize("turns", ["1", "1/3"])
    def test_faster_rod_has_its_answer(self, spins: str, turns: str) -> None:
        for seed in range(1, 6):
            done = analyzed(released(spins, seed, "--turns", turns))
            assert done.exit_code == 0
            assert "I_zz = (" in done.stdout

    @pytest.mark.parametrize("spins", ["20,30,40", "40,60,80", "50,75,100"])
    def test_spin_of_the_hint_is_answered(self, spins: str) -> None:
        for seed in (1, 2, 4):
            refused = analyzed(released(spins, seed))
            if refused.exit_code == 0:
                continue
            rpm = int(re.search(r"at least (\d+) rpm for this weight", refused.stderr)[1])
            done = analyzed(released(f"{rpm},{2 * rpm},{3 * rpm}", seed))
            assert done.exit_code == 0
            value, u = map(float, re.search(r"I_zz = \(([\d.]+) ± ([\d.]+)\)", done.stdout).groups())
            assert abs(value - 4.44) < 3 * u

    def test_motion_line_of_the_hint_is_answered(self) -> None:
        log = gyro("simulate", "--motion", "steady", "--spins", "20,30,40rpm", "--seed", "1").stdout
        wrong = log.replace("# motion: steady", "# motion: released")
        refused = analyzed(wrong)
        assert "write # motion: steady" in refused.stderr
        done = analyzed(wrong.replace("# motion: released", "# motion: steady"))
        value, u = map(float, re.search(r"I_zz = \(([\d.]+) ± ([\d.]+)\)", done.stdout).groups())
        assert abs(value - 4.44) < 3 * u

    def test_check_and_selfcheck_refuse_it_too(self) -> None:
        log = released("20,30,40", 3)
        assert "error G425" in gyro("check", "-", stdin=log).stdout
        done = gyro("selfcheck", "-", "--labs", "5", stdin=log)
        assert done.exit_code == 1
        assert "G425" in done.stderr

    @pytest.mark.parametrize("seed", range(1, 5))
    def test_rod_up_that_cannot_precess_steadily_is_named(self, seed: int) -> None:
        done = analyzed(released("40,55,70", seed, "--pitch", "45deg"))
        assert done.exit_code == 1
        assert "error G425: run 7" in done.stderr


README = """\
# g: 9.803 m/s^2
mass [g],position [cm],spin [rpm],time [s],turns
20.1,14.8,201,6.45,1/3
20.1,14.8,402,13.09,1/3
20.1,14.8,598,19.64,1/3
40.3,14.8,201,6.75,2/3
40.3,14.8,400,13.15,2/3
40.3,14.8,599,19.69,2/3
60.2,14.8,200,6.47,1
60.2,14.8,401,12.98,1
60.2,14.8,602,19.85,1
"""


def with_direction(loaded: str, unloaded: str) -> str:
    """Add a run without a weight and the column precession_sense, filled in for it and for the first run."""
    first, rest = README.replace("time [s],turns\n", "time [s],turns,precession_sense\n").split("1/3\n", 1)
    return f"{first}1/3,{loaded}\n{rest}0,,402,100,1/20,{unloaded}\n"


class TestDirection:
    def test_hint_of_check_is_followed(self) -> None:
        told = gyro("check", "-", stdin=README).stdout
        assert "G454" in told
        header, loaded, unloaded = (line.strip() for line in told.partition("G454")[2].splitlines()[2:5])
        assert header == "mass [g],position [cm],spin [rpm],time [s],turns,precession_sense"
        assert loaded.endswith(",ccw")
        assert unloaded == "0,,400,180,1/20,ccw"
        now, then = map(float, re.search(r"is ([\d.]+) % and would be ([\d.]+) %", told).groups())
        better = gyrodata.analyze((README.replace(README.splitlines()[1], header) + unloaded + "\n").encode())
        assert better.inertia.relative_u < 1.15 * then / 100 < now / 100
        assert "G454" not in gyro("check", "-", stdin=with_direction("ccw", "ccw")).stdout

    @pytest.mark.parametrize("command", ["check", "analyze"])
    def test_missing_direction_is_named_with_what_it_costs(self, command: str) -> None:
        log = README + "0,,402,100,1/20\n"
        done = gyro(command, "-", stdin=log)
        said = re.search(r"12:\d+: warning G426: run 10 .* is ([\d.]+) % and would be about ([\d.]+) %", done.output)
        now, then = (float(share) / 100 for share in said.groups())
        assert gyrodata.analyze(log.encode()).inertia.relative_u == pytest.approx(now, rel=0.05)
        u = gyrodata.analyze(with_direction("ccw", "ccw").encode()).inertia.relative_u
        assert u == pytest.approx(then, rel=0.05)
        assert u < 0.95 * gyrodata.analyze(README.encode()).inertia.relative_u

    @pytest.mark.parametrize(("loaded", "unloaded", "sign"), [
        ("ccw", "ccw", 1), ("cw", "cw", 1), ("ccw", "cw", -1), ("cw", "ccw", -1), ("", "ccw", 1),
    ])  # fmt: skip
    def test_only_same_or_other_direction_counts(self, loaded: str, unloaded: str, sign: int) -> None:
        found = gyrodata.analyze(with_direction(loaded, unloaded).encode())
        assert found.residual_torque.value * sign > 4 * found.residual_torque.u
        assert {one.code for one in found.diagnostics} <= {"G418"}

    def test_senses_that_differ_among_weights_are_named(self) -> None:
        log = (
            with_direction("cw", "cw")
            .replace("402,13.09,1/3", "402,13.09,1/3,cw")
            .replace("598,19.64,1/3", "598,19.64,1/3,ccw")
        )
        assert "G402" in gyro("check", "-", stdin=log).stdout


def test_advice_to_change_sides_needs_a_negative_position() -> None:
    for seed in range(1, 4):
        one = gyro("simulate", "--seed", str(seed)).stdout
        assert "other side" not in gyro("analyze", "-", "--no-report", "-v", stdin=one).stdout
    few = one + "40.0,-15.00,400,20.0,1,10\n"
    assert "other side" in gyro("analyze", "-", "--no-report", "-v", stdin=few).stdout


STILL = "0,,405,120,0\n"


class TestRodThatStays:
    @pytest.mark.parametrize("row", [STILL, "0,,405,120,0.0\n", "none,,405,120,0\n", "0,14.8,405,120,0\n"])
    def test_it_is_the_best_result(self, row: str) -> None:
        before, after = gyrodata.analyze(README.encode()), gyrodata.analyze((README + row).encode())
        assert after.inertia.u < 0.85 * before.inertia.u
        bound = after.inertia.value * 405 * math.pi / 30 * math.radians(math.sqrt(2)) / 120
        assert 0.5 * bound < after.residual_torque.u < 2.5 * bound < 0.5 * before.residual_torque.u
        assert [one.code for one in after.diagnostics if one.code not in ("G418", "G407")] == ["G427"]
        done = gyro("check", "-", stdin=README + row)
        assert done.exit_code == 0
        assert "complete" in done.stdout

    def test_stated_angle_and_longer_times_bound_it_better(self) -> None:
        def u(row: str, line: str = "") -> float:
            return gyrodata.analyze((line + README + row).encode()).residual_torque.u

        usual = u(STILL)
        assert u("0,,405,240,0\n") == pytest.approx(usual / 2, rel=0.15)
        assert u(STILL + "0,,405,240,0\n") == pytest.approx(usual / 2, rel=0.15)
        assert u(STILL, "# u_angle: 0.3 deg\n") < 0.4 * usual
        assert u(STILL, "# u_turns: 0.02\n") > 2 * usual

    def test_angle_columns_and_one_torque_take_it_too(self) -> None:
        head, *rows = README.splitlines()[1:]
        one = "\n".join([head.replace("turns", "angle [deg]"), *(f"{row.rpartition(',')[0]},120" for row in rows[:3])])
        before, after = (gyrodata.analyze(f"{one}\n{row}".encode()) for row in ("", STILL))
        assert after.inertia.u < 0.3 * before.inertia.u
        assert "G414" not in {found.code for found in after.diagnostics}
        text = gyro("analyze", "-", "--no-report", stdin=f"{one}\n{STILL}").stdout
        assert "depends on the run without a weight" in text

    @pytest.mark.parametrize("row", ["20.1,14.8,405,120,0\n", "0,,405,0,1\n", "0,,405,0,0\n"])
    def test_zero_elsewhere_stays_an_error(self, row: str) -> None:
        assert "G215" in gyro("analyze", "-", "--no-report", stdin=README + row).stderr

    def test_nothing_but_such_runs_is_an_error(self) -> None:
        done = gyro("analyze", "-", "--no-report", stdin="".join(README.splitlines(True)[:2]) + STILL)
        assert done.exit_code == 1
        assert "G413" in done.stderr

    def test_a_log_is_written_back_with_it(self) -> None:
        read = gyrodata.read_log((README + STILL).encode())
        again = gyrodata.read_log(write_log(read).encode())
        assert len(read.runs) == 9
        assert again.unmoved.columns["time"].values == (120.0,)
        answers = [gyrodata.analyze(one.encode()).inertia.value for one in (README + STILL, write_log(read))]
        assert answers[0] == pytest.approx(answers[1], rel=1e-9)

    def test_intervals_contain_the_truth_for_tiny_m0(self) -> None:
        random, inside, known = np.random.default_rng(4), 0, 0
        width = 4.44e-3 * 400 * math.pi / 30 * math.radians(1) / 120
        for seed in range(60):
            imbalance = float(width * random.standard_normal())
            log = gyro("simulate", "--seed", str(seed), f"--imbalance={imbalance} N*m").stdout
            found = gyrodata.analyze((log + "0,,400,120,0,10\n").encode())
            low, high = found.inertia.interval_95
            inside += low <= 4.44e-3 <= high
            low, high = found.residual_torque.interval_95
            known += low <= imbalance <= high
        assert inside >= 53
        assert known >= 53


class TestTemplate:
    def filled(self, loaded: str = "", unloaded: str = "", still: bool = False, **lines: str) -> str:
        """Fill in the template as its comments say, with the readings of a ball whose I_zz is 4.44e-3 kg*m^2."""
        random, rows = np.random.default_rng(3), []
        for row in gyro("template").stdout.splitlines():
            key = re.fullmatch(r"# (\w+): ", row)
            run = re.fullmatch(r"([\d.]+),([\d.]*),,,,,(.*aim at (\d+) rpm)", row)
            if key and key[1] in lines:
                row += lines[key[1]]
            elif run:
                mass, rpm = float(run[1]) * 1e-3, float(run[4])
                torque = mass * 9.80665 * 0.15 + 5e-4 * (not still)
                if mass:
                    time = 2 * math.pi * 4.44e-3 * rpm * math.pi / 30 / torque + 0.14 * random.standard_normal()
                    row = f"{run[1]},{run[2]},{rpm:.0f},{time:.2f},1,{loaded},{run[3]}"
                elif still:
                    row = f"0,,{rpm:.0f},120,0,{unloaded},{run[3]}"
                else:
                    time = 2 * math.pi / 20 * 4.44e-3 * rpm * math.pi / 30 / torque
                    row = f"0,,{rpm:.0f},{time:.2f},1/20,{unloaded},{run[3]}"
            rows.append(row)
        return "\n".join(rows) + "\n"

    def test_it_asks_for_what_the_analysis_needs(self) -> None:
        text = gyro("template").stdout
        for line in ("# ball_mass: ", "# ball_diameter: ", "# latitude: "):
            assert line in text.splitlines()
        assert "turns,precession_sense,note\n" in text

    @pytest.mark.parametrize("still", [False, True])
    @pytest.mark.parametrize("sense", ["ccw", "cw"])
    @pytest.mark.parametrize("lines", [{}, {
        "station": "4", "ball_mass": "4.31 kg", "ball_diameter": "10.16 cm", "latitude": "45 deg", "balanced": "yes",
    }])  # fmt: skip
    def test_filled_in_it_raises_no_alarm(self, lines: dict[str, str], sense: str, still: bool) -> None:
        log = self.filled(sense, sense, still, **lines)
        found = gyrodata.analyze(log.encode())
        assert {one.code for one in found.diagnostics} <= {"G404", "G418", "G427"}
        assert abs(found.inertia.value - 4.44e-3) < 3 * found.inertia.u
        assert (found.ball is not None) == bool(lines)
        checked = gyro("check", "-", stdin=log)
        assert checked.exit_code == 0
        assert "complete" in checked.stdout

    def test_its_example_row_is_read(self) -> None:
        text = gyro("template").stdout
        example = re.search(r"# A row that is filled in: (.*)", text)[1]
        found = gyrodata.analyze((text + example + "\n").encode())
        assert len(found.runs) == 1
        assert found.inertia.value == pytest.approx(4.4e-3, rel=0.1)


class TestOptions:
    @pytest.mark.parametrize("name", ["report.pdf", "report.HTML", "a.txt", "a.docx", "a.md", "a.csv", "a.xlsx"])
    def test_file_name_for_the_report_is_refused(self, name: str, tmp_path: Path) -> None:
        done = gyro("analyze", "-", "--out", str(tmp_path / name), stdin=README)
        assert done.exit_code == 2
        assert "G638" in done.stderr
        assert not list(tmp_path.iterdir())

    def test_its_hints_are_followed(self, tmp_path: Path) -> None:
        for form in ("json", "csv"):
            assert (
                gyro("analyze", "-", "--format", form, "--out", str(tmp_path / f"a.{form}"), stdin=README).exit_code
                == 0
            )
        assert gyro("analyze", "-", "--out", str(tmp_path / "report"), stdin=README).exit_code == 0
        (tmp_path / "old.pdf").mkdir()
        assert gyro("analyze", "-", "--out", str(tmp_path / "old.pdf"), stdin=README).exit_code == 0
        assert (tmp_path / "report" / "report.html").exists()
        assert (tmp_path / "a.json").is_file()
        wrong = gyro("analyze", "-", "--format", "json", "--out", str(tmp_path / "a.csv"), stdin=README)
        assert "--format csv" in wrong.stderr

    def test_two_schemas_are_refused(self) -> None:
        done = gyro("schema", "--check", "--grades")
        assert done.exit_code == 2
        assert "--check and --grades" in done.stderr

    def test_page_is_named_only_if_there_is_one(self, tmp_path: Path) -> None:
        assert "report's page" not in analyzed(README).stdout
        assert "report's page" in gyro("analyze", "-", "--out", str(tmp_path), stdin=README).stdout
