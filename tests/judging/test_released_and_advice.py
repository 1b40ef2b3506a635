"""A slow rod that is released, and advice that a user can follow, as both are seen from
outside.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gates.drawn_logs import ARM, INERTIA, RPM, Bench, G, draw, write
from physics.test_released import Nutation
from simulated_labs import analyze_briefly
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata import Design, Truth
from gyrodata.cli import app


def gyro(*arguments: str, stdin: str | None = None) -> Result:
    return CliRunner().invoke(app, list(arguments), input=stdin)


def released(spins: str, seed: int, **more: tuple[float, ...]) -> str:
    """Simulate a lab in which the rod is released."""
    rates = tuple(float(spin) * RPM for spin in spins.split(","))
    return gyrodata.simulate(
        Truth(motion="released"), Design(spins=rates, **more), seed=seed
    ).log


def analyzed(log: str) -> Result:
    return gyro("analyze", "-", "--no-report", stdin=log)


def off(log: str) -> float:
    """How many u the answer is from the truth."""
    found = analyze_briefly(log).inertia
    return abs(found.value - INERTIA) / found.u


class TestReleased:
    @pytest.mark.slow
    @pytest.mark.parametrize(("spins", "fall"), [("20,30,40", 75), ("40,60,80", 61)])
    def test_slow_rod_has_no_answer(self, spins: str, fall: int) -> None:
        for seed in (1, 2):
            log = released(spins, seed)
            done = analyzed(log)
            assert done.exit_code == 1
            assert "I_zz = " not in done.stdout
            line = next(
                i for i, row in enumerate(log.splitlines(), 1) if row.endswith(",7")
            )
            words = (
                rf":{line}:\S* error G425: run 7.* at (\d+) rpm with .* falls by about "
                rf"(\d+) degrees and hits"
            )
            # A rod with 60 g at 15 cm that is released level, by the conservation laws.
            spin, angle = map(int, re.search(words, done.stderr).groups())
            assert (spin, angle) == (
                pytest.approx(int(spins[:2]), abs=6),
                pytest.approx(fall, abs=5),
            )

    @pytest.mark.slow
    @pytest.mark.parametrize("spins", ["60,100,150", "100,200,300", "200,400,600"])
    @pytest.mark.parametrize("turns", [1.0, 1 / 3])
    def test_faster_rod_has_its_answer(self, spins: str, turns: float) -> None:
        assert off(released(spins, 1, turns=(turns,))) < 4

    @pytest.mark.slow
    @pytest.mark.parametrize("spins", ["20,30,40", "40,60,80", "50,75,100"])
    def test_spin_of_the_hint_is_answered(self, spins: str) -> None:
        for seed in (1, 4):
            try:
                analyze_briefly(released(spins, seed))
                assert spins == "50,75,100"
            except gyrodata.LogError as refused:
                rpm = int(
                    re.search(r"at least (\d+) rpm for this weight", str(refused))[1]
                )
                assert off(released(f"{rpm},{2 * rpm},{3 * rpm}", seed)) < 3

    @pytest.mark.slow
    def test_tachometer_line_of_the_hint_is_answered(self) -> None:
        head, *rows = [
            line.split(",")
            for line in released("60,100,150", 1).splitlines()
            if line[0] not in "#"
        ]
        at, spins = head.index("spin [rpm]"), ("60", "100", "150")
        typed = [
            [*row[:at], spins[i % 3], *row[at + 1 :]] for i, row in enumerate(rows)
        ]
        log = "# motion: released\n" + "".join(
            ",".join(row) + "\n" for row in [head, *typed]
        )
        assert "write # tachometer: still" in analyzed(log).stderr
        assert off("# tachometer: still\n" + log) < 4

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("header", "spins"),
        [
            ("spin [rpm]", "{during}"),
            ("spin_start [rpm],spin_end [rpm]", "{total},{total}"),
        ],
    )
    def test_only_a_spin_that_is_read_during_the_run_contains_the_sag(
        self, header: str, spins: str
    ) -> None:
        # The times are those of the nutation, integrated between its turning points.
        # The rod is level before the release, so a reading at the start is the total
        # spin; one during the run is larger by the mean of φ̇ times the sine of the
        # sag.
        across = 7.0e-3
        log = f"# g: {G} m/s^2\n# motion: released\n# transverse_inertia: {across} kg*m^2\n"
        log += "# u_spin_delay: 0 s\n# u_time: 1 ms\n# u_time_bias: 0 s\n# u_imbalance: 0 N*m\n"
        log += f"mass [g],position [cm],{header},time [s],turns\n"
        for mass in (20, 40, 60):
            for rpm in (200, 400, 600):
                top = Nutation(mass * 1e-3 * G * 0.15, rpm * RPM, across)
                cells = spins.format(
                    total=f"{rpm:.5f}", during=f"{top.mean_spin() / RPM:.5f}"
                )
                log += f"{mass}.0000,15.0000,{cells},{4 * math.pi / top.mean():.7f},2\n"
        found = analyze_briefly(log)
        assert found.inertia.value == pytest.approx(INERTIA, rel=1e-4)

    def test_motion_line_of_the_hint_is_answered(self) -> None:
        log = gyro("simulate", "--spins", "20,30,40rpm", "--seed", "1").stdout
        assert (
            "write # motion: steady"
            in analyzed(log.replace("# motion: steady", "# motion: released")).stderr
        )
        assert off(log) < 3

    @pytest.mark.slow
    def test_rod_up_that_cannot_precess_steadily_is_named(self) -> None:
        for seed in (1, 2):
            assert (
                "error G425: run 7"
                in analyzed(released("40,55,70", seed, pitches=(math.pi / 4,))).stderr
            )


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
    """Add a run without a weight and the column precession_sense, filled in for it and
    for the first run.
    """
    first, rest = README.replace(
        "time [s],turns\n", "time [s],turns,precession_sense\n"
    ).split("1/3\n", 1)
    return f"{first}1/3,{loaded}\n{rest}0,,402,100,1/20,{unloaded}\n"


def rows_to_copy(told: str) -> list[str]:
    """Return the header and the two rows that G454 shows."""
    shown = told.partition("G454")[2].partition("to copy:\n")[2]
    return [line.strip() for line in shown.splitlines()[:3]]


OWN_COLUMNS = {
    "an angle": (
        "mass [g],position [cm],spin [rpm],angle [deg],time [s]",
        lambda mass, spin, turns, time: [mass, 14.8, spin, 360 * turns, time],
    ),
    "decimal commas, a note, another order": (
        "note;time [s];turns;spin [Hz];mass [g];position [mm]",
        lambda mass, spin, turns, time: [
            *("good", time, round(turns, 4), round(spin / 60, 2), mass, 148)
        ],
    ),
    "spins at the start and the end": (
        "run,mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns",
        lambda mass, spin, turns, time: [
            *(time, mass, 14.8, spin + 3, spin - 3, time, round(turns, 4))
        ],
    ),
    "periods": (
        "mass [g],position [cm],spin_period [s],precession_period [s]",
        lambda mass, spin, turns, time: [mass, 14.8, 60 / spin, time / turns],
    ),
    "units in the cells": (
        "mass,position,spin,turns,time",
        lambda mass, spin, turns, time: [
            *(f"{mass} g", "14.8 cm", f"{spin} rpm", round(turns, 4), f"{time} s")
        ],
    ),
}


def in_columns(header: str, row: Callable[..., list[Any]]) -> str:
    """Write the runs of `README` in other columns."""
    mark = ";" if ";" in header else ","
    lines = [header]
    for line in README.splitlines()[2:]:
        mass, _, spin, time, turns = line.split(",")
        cells = row(float(mass), float(spin), float(Fraction(turns)), float(time))
        text = mark.join(map(str, cells))
        lines.append(text.replace(".", ",") if mark == ";" else text)
    return "\n".join([*lines, ""])


@pytest.mark.slow
@pytest.mark.parametrize("form", OWN_COLUMNS)
def test_run_without_a_weight_is_added_as_the_hint_says(form: str) -> None:
    log = f"# motion: steady\n{in_columns(*OWN_COLUMNS[form])}"
    header, loaded, unloaded = rows_to_copy(gyro("check", "-", stdin=log).stdout)
    motion, *first, _ = log.splitlines()[:4]
    mark = header.removeprefix(first[0])[0]
    assert header == f"{first[0]}{mark}precession_sense"
    assert loaded == f"{first[1]}{mark}ccw"
    assert mark == "," or "." not in unloaded
    lines = [motion, header, loaded, *log.splitlines()[3:], unloaded, ""]
    before = analyze_briefly(log.encode())
    after = analyze_briefly("\n".join(lines).encode())
    assert len(after.run_table) == len(before.run_table) + 1
    assert after.run_table[-1].torque == 0
    assert after.inertia.u < before.inertia.u
    assert "G454" not in gyro("check", "-", stdin="\n".join(lines)).stdout


@pytest.mark.slow
def test_the_run_to_add_has_a_direction_in_a_column_that_is_there() -> None:
    head, first, *others = in_columns(*OWN_COLUMNS["an angle"]).splitlines()
    lines = [f"{head},precession_sense", f"{first},ccw", *others, ""]
    rows = rows_to_copy(gyro("check", "-", stdin="\n".join(lines)).stdout)
    assert rows[:2] == lines[:2]
    assert rows[2].endswith(",ccw")


@pytest.mark.slow
def test_a_weight_of_misread_runs_alone_needs_no_more_runs() -> None:
    lines = README.splitlines()
    mass, rest = lines[-2].split(",", 1)
    lines[-2] = f"{2 * float(mass)},{rest}"
    told = gyro("check", "-", stdin="\n".join([*lines, ""])).stdout
    assert "warning G410" in told
    assert told.count("warning G452") == 1


class TestDirection:
    @pytest.mark.slow
    def test_hint_of_check_is_followed(self) -> None:
        told = gyro("check", "-", stdin=README).stdout
        header, loaded, unloaded = rows_to_copy(told)
        first = README.splitlines()[1:3]
        assert header == f"{first[0]},precession_sense"
        assert loaded == f"{first[1]},ccw"
        assert unloaded.endswith(",ccw")
        now, then = map(
            float, re.search(r"from ([\d.]+) % to ([\d.]+) %", told).groups()
        )
        better = gyrodata.analyze(
            (README.replace(README.splitlines()[1], header) + unloaded + "\n").encode()
        )
        assert better.inertia.relative_u < 1.15 * then / 100 < now / 100
        assert (
            "G454" not in gyro("check", "-", stdin=with_direction("ccw", "ccw")).stdout
        )

    @pytest.mark.slow
    @pytest.mark.parametrize("command", ["check", "analyze"])
    def test_missing_direction_is_named_with_what_it_costs(self, command: str) -> None:
        log = README + "0,,402,100,1/20\n"
        done = gyro(command, "-", stdin=log)
        said = re.search(
            r"12:\d+: warning G426: run 10 .* is ([\d.]+) % and would be about ([\d.]+) %",
            done.output,
        )
        now, then, before = (
            100 * gyrodata.analyze(text.encode()).inertia.relative_u
            for text in (log, with_direction("ccw", "ccw"), README)
        )
        assert list(map(float, said.groups())) == pytest.approx([now, then], rel=0.05)
        assert then < 0.95 * before

    @pytest.mark.slow
    def test_only_same_or_other_direction_counts(self) -> None:
        for loaded, unloaded, sign in (
            ("ccw", "ccw", 1),
            ("cw", "cw", 1),
            ("ccw", "cw", -1),
            ("cw", "ccw", -1),
            ("", "ccw", 1),
        ):
            found = gyrodata.analyze(with_direction(loaded, unloaded).encode())
            assert found.residual_torque.value * sign > 4 * found.residual_torque.u
            assert {one.code for one in found.diagnostics} <= {"G418"}


STILL = "0,,405,120,0\n"


class TestRodThatStays:
    @pytest.mark.slow
    @pytest.mark.parametrize("row", [STILL, "none,,405,120,0\n"])
    def test_it_is_the_best_result(self, row: str) -> None:
        before, after = (
            gyrodata.analyze(README.encode()),
            gyrodata.analyze((README + row).encode()),
        )
        assert after.inertia.u < 0.85 * before.inertia.u
        bound = (
            after.inertia.value * 405 * math.pi / 30 * math.radians(math.sqrt(2)) / 120
        )
        assert (
            0.5 * bound
            < after.residual_torque.u
            < 2.5 * bound
            < 0.5 * before.residual_torque.u
        )
        assert [
            one.code for one in after.diagnostics if one.code not in ("G418", "G407")
        ] == ["G427"]
        assert "complete" in gyro("check", "-", stdin=README + row).stdout

    def test_zero_elsewhere_stays_an_error(self) -> None:
        for row in ("20.1,14.8,405,120,0\n", "0,,405,0,0\n"):
            assert "G215" in analyzed(README + row).stderr
        assert "G413" in analyzed("".join(README.splitlines(True)[:2]) + STILL).stderr

    @pytest.mark.slow
    def test_intervals_contain_the_truth_for_tiny_m0(self) -> None:
        random, inside = np.random.default_rng(4), []
        for seed in range(24):
            # M0 that turns the rod by a degree in 120 s.
            imbalance = (
                INERTIA * 400 * RPM * math.radians(1) / 120 * random.standard_normal()
            )
            share = float(imbalance) / (0.02 * G * ARM)
            found = analyze_briefly(
                (write(draw(Bench(imbalance=share), seed)) + "0,,400,120,0\n").encode()
            )
            ends = found.inertia.interval_95, found.residual_torque.interval_95
            inside.append(
                [
                    low <= true <= high
                    for true, (low, high) in zip(
                        (INERTIA, imbalance), ends, strict=True
                    )
                ]
            )
        assert np.sum(inside, axis=0).min() >= 21


def filled(sense: str, still: bool, lines: dict[str, str]) -> str:
    """Fill in the template as its comments say, with the readings of a ball whose I_zz
    is 4.44e-3 kg*m^2.
    """
    random, rows = np.random.default_rng(3), []
    for row in gyro("template").stdout.splitlines():
        key = re.fullmatch(r"# (\w+): ", row)
        run = re.fullmatch(r"([\d.]+),([\d.]*),,,,,(.*aim at (\d+) rpm)", row)
        if key:
            row += lines.get(key[1], "")
        elif run:
            mass, rpm = float(run[1]) * 1e-3, float(run[4])
            time = (
                2
                * math.pi
                * INERTIA
                * rpm
                * RPM
                / (mass * 9.80665 * ARM + (1e-9 if still else 5e-4))
            )
            cells = (
                f"{time + 0.14 * random.standard_normal():.2f},1"
                if mass
                else f"{time / 20:.2f},1/20"
            )
            cells = "120,0" if still and not mass else cells
            row = f"{run[1]},{run[2]},{rpm:.0f},{cells},{sense},{run[3]}"
        rows.append(row)
    return "\n".join(rows) + "\n"


BALL = {
    "station": "4",
    "ball_mass": "4.31 kg",
    "ball_diameter": "10.16 cm",
    "latitude": "45 deg",
    "balanced": "yes",
}


class TestTemplate:
    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("lines", "sense", "still"),
        [({}, "ccw", False), (BALL, "cw", True)],
    )
    def test_filled_in_it_raises_no_alarm(
        self, lines: dict[str, str], sense: str, still: bool
    ) -> None:
        log = filled(sense, still, lines)
        found = gyrodata.analyze(log.encode())
        assert {one.code for one in found.diagnostics} <= {"G404", "G418", "G427"}
        assert abs(found.inertia.value - INERTIA) < 3 * found.inertia.u
        assert (found.ball is not None) == bool(lines)
        assert "complete" in gyro("check", "-", stdin=log).stdout

    @pytest.mark.slow
    def test_it_asks_for_the_ball_and_its_example_row_is_read(self) -> None:
        text = gyro("template").stdout
        assert {
            "# ball_mass: ",
            "# ball_diameter: ",
            "# latitude: ",
            "# balanced: ",
        } <= set(text.splitlines())
        assert "turns,precession_sense,note\n" in text
        example = re.search(r"# A row that is filled in: (.*)", text)[1]
        found = gyrodata.analyze((text + example + "\n").encode())
        assert found.inertia.value == pytest.approx(4.4e-3, rel=0.1)


def test_a_log_with_one_torque_is_not_asked_for_what_it_states() -> None:
    rows = "".join(f"20.0,15.0,{rpm},{0.0993 * rpm:.2f},1\n" for rpm in (206, 401, 603))
    table = f"mass [g],position [cm],spin [rpm],time [s],turns\n{rows}"
    for line, is_asked in (("", True), ("# balanced: yes\n", False)):
        lab = gyrodata.analyze(f"{line}{table}".encode())
        [finding] = [one for one in lab.diagnostics if one.code == "G414"]
        assert ('"# balanced: yes"' in finding.hint) == is_asked
        assert "add runs with another weight" in finding.hint
