"""A slow rod that is released, and advice that a user can follow, as both are seen from outside."""

from __future__ import annotations

import re

import pytest
from typer.testing import CliRunner, Result

from gyrodata.cli import app


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
        assert "G425" in str(done.stderr or done.exception)

    @pytest.mark.parametrize("seed", range(1, 5))
    def test_rod_up_that_cannot_precess_steadily_is_named(self, seed: int) -> None:
        done = analyzed(released("40,55,70", seed, "--pitch", "45deg"))
        assert done.exit_code == 1
        assert "error G425: run 7" in done.stderr
