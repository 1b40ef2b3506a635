"""A log from a known truth: what happens, what is read of it, and that the analysis finds the truth again."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata import fitting, motion, physics
from gyrodata.cli import app
from gyrodata.diagnostics import CODES
from gyrodata.errors import InputError
from gyrodata.measurements import measure
from gyrodata.readings import Uncertainty, read_log
from gyrodata.simulation import (
    EXACT,
    NOISE_KEYS,
    TYPICAL,
    Decay,
    Design,
    Simulation,
    SpinReading,
    Truth,
    course,
    happen,
    put_errors,
    read_noise,
    time_by_constant,
    time_by_share,
)
from gyrodata.simulation import simulate as simulated

RPM = math.pi / 30
INERTIA = 4.44e-3
TILTED = (math.radians(-50), math.radians(50))
BOTH_SPINS = tuple(sign * rpm * RPM for sign in (1, -1) for rpm in (200, 400, 600))


def gyro(*arguments: str, stdin: str | None = None) -> Result:
    return CliRunner().invoke(app, arguments, input=stdin)


def found(log: str) -> gyrodata.Analysis:
    return gyrodata.analyze(log.encode())


def off(done: Simulation) -> float:
    """Relative error of I_zz that the analysis makes of a log."""
    return found(done.log).inertia.value / done.truth.inertia - 1


class TestFallingSpin:
    """Eq. (8) on a spin that dies away, in closed form."""

    @staticmethod
    def by_quadrature(torque: float, spin: float, ratio: float, pitch: float, turns: float, constant: float) -> Any:
        """Find the time by integrating the slow root of eq. (8) to 30 digits."""
        with mpmath.workdps(30):
            lean = (1 - mpmath.mpf(ratio)) * INERTIA * mpmath.sin(pitch)

            def rate(t: Any) -> Any:
                momentum = INERTIA * mpmath.mpf(abs(spin)) * mpmath.exp(-t / constant)
                return 2 * abs(torque) / (momentum + mpmath.sqrt(momentum**2 + 4 * lean * torque))

            guess = 2 * mpmath.pi * turns / rate(mpmath.mpf(0))

            def beyond(end: Any) -> Any:
                return mpmath.quad(rate, [0, end]) - 2 * mpmath.pi * turns

            return mpmath.findroot(beyond, (guess, 0.9 * guess), tol=1e-24)

    @pytest.mark.parametrize(
        ("torque", "spin", "ratio", "degrees", "turns", "constant"),
        [
            (0.03, 40.0, 1.3, 0.0, 1.0, 60.0),
            (0.09, 20.0, 1.3, 50.0, 1.0, 20.0),
            (0.09, 20.0, 1.3, -50.0, 1.0, 20.0),
            (0.09, -20.0, 1.8, -50.0, 1 / 3, 20.0),
            (-0.09, 20.0, 1.8, 50.0, 1.0, 20.0),
            (0.03, 20.0, 0.7, 60.0, 1.0, 60.0),
            (0.03, 20.0, 1.3, 1e-6, 1.0, 60.0),
            (0.03, 60.0, 1.3, 40.0, 1.0, 1e7),
        ],
    )
    def test_the_time_is_that_of_the_integral(
        self, torque: float, spin: float, ratio: float, degrees: float, turns: float, constant: float
    ) -> None:
        pitch = math.radians(degrees)
        at = course([torque], [spin], INERTIA, ratio * INERTIA, [pitch])
        angle = np.array([2 * np.pi * turns])
        time = time_by_constant(at, angle, constant)
        expected = self.by_quadrature(torque, spin, ratio, pitch, turns, constant)
        assert time[0] == pytest.approx(float(expected), rel=1e-12)
        lost = -math.expm1(-time[0] / constant)
        assert time_by_share(at, angle, lost)[0] == pytest.approx(time[0], rel=1e-12)

    def test_a_level_rod_has_the_harmonic_mean(self) -> None:
        at = course([0.03], [40.0], INERTIA, 6e-3, [0.0])
        time = time_by_share(at, np.array([2 * np.pi]), 0.3)
        mean = physics.harmonic_mean_spin(40.0, 28.0)
        assert time[0] == pytest.approx(2 * np.pi * INERTIA * mean / 0.03, rel=1e-14)
        fallen = time_by_constant(at, np.array([2 * np.pi]), 60.0)
        assert fallen[0] == pytest.approx(60 * math.log1p(2 * np.pi * INERTIA * 40 / 0.03 / 60), rel=1e-14)

    def test_up_to_the_last_moment_and_not_beyond(self) -> None:
        torque, across, pitch, start = 0.09, 1.3 * INERTIA, 0.8, 10.0
        at = course([torque], [start], INERTIA, across, [pitch])
        least = physics.least_spin(torque, INERTIA, across, pitch)
        longest = 20.0 * math.log(start / least)
        # The angle swept until the last moment, from the same closed form by its share.
        whole = float(abs(at.rate[0]) * 20.0 * at.swept(np.array([1 - least / start * (1 + 1e-14)]))[0])
        almost = time_by_constant(at, np.array([whole * (1 - 1e-9)]), 20.0)[0]
        assert 0.999 * longest < almost < longest
        assert math.isnan(time_by_constant(at, np.array([whole * 1.001]), 20.0)[0])


SCENES: dict[str, tuple[Truth, Design]] = {
    "level": (Truth(imbalance=0.0, timing_bias=0.0), Design()),
    "thirds": (Truth(timing_bias=0.0), Design(turns=(1 / 3,))),
    "rod up": (Truth(), Design(pitches=TILTED[1:])),
    "rod down": (Truth(), Design(pitches=TILTED[:1])),
    "up and down": (Truth(transverse_inertia=6e-3), Design(pitches=TILTED)),
    "falling spin": (Truth(decay=Decay(lost=0.3)), Design()),
    "time constant": (Truth(decay=Decay(time_constant=600.0)), Design()),
    "both torques and spins": (Truth(), Design(positions=(0.15, -0.15), spins=BOTH_SPINS)),
    "both, tilted": (Truth(), Design(positions=(0.15, -0.15), spins=BOTH_SPINS, pitches=TILTED)),
    "both, falling": (Truth(decay=Decay(lost=0.1)), Design(positions=(0.15, -0.15), spins=BOTH_SPINS)),
    "imbalance and bias": (Truth(imbalance=3e-4, timing_bias=0.05), Design()),
    "imbalance, both sides": (Truth(imbalance=-3e-4, timing_bias=0.05), Design(positions=(0.15, -0.15))),
    "without a weight": (Truth(imbalance=3e-4), Design(masses=(0.0, 0.02, 0.04), turns=(1 / 12, 1 / 3))),
    "turned by the imbalance": (Truth(imbalance=-3e-4), Design(masses=(0.0, 0.02, 0.04), spins=BOTH_SPINS)),
    "imbalance, falling": (Truth(imbalance=3e-4, timing_bias=-0.1, decay=Decay(lost=0.2)), Design()),
    "imbalance, tilted": (Truth(imbalance=3e-4), Design(pitches=TILTED)),
    "repeats": (Truth(), Design(repeats=3)),
}


class TestTheTruthComesBack:
    """From an exact log the analysis finds what made it."""

    @pytest.mark.parametrize(("truth", "design"), SCENES.values(), ids=SCENES.keys())
    def test_to_eight_digits(self, truth: Truth, design: Design) -> None:
        done = simulated(truth, design, EXACT)
        analysis = found(done.log)
        assert analysis.inertia.value == pytest.approx(truth.inertia, rel=1e-8)
        assert analysis.residual_torque.value == pytest.approx(truth.imbalance or 0.0, abs=1e-10)
        assert analysis.timing_bias.value == pytest.approx(truth.timing_bias or 0.0, abs=1e-6)
        assert not any(run.flagged for run in analysis.run_table)

    def test_one_run_is_enough_without_unknowns(self) -> None:
        assert abs(off(simulated(Truth(), Design(masses=(0.04,), spins=(40.0,)), EXACT))) < 1e-8

    def test_through_the_shell(self) -> None:
        log = gyro(
            "simulate", "--noise", "none", "--pitch=-50deg,50deg", "--position=15cm,-15cm", "--spins=300,-500rpm"
        )
        done = gyro("analyze", "-", "--format", "json", stdin=log.stdout)
        assert done.exit_code == 0
        assert json.loads(done.stdout)["result"]["inertia"]["value"] == pytest.approx(INERTIA, rel=1e-8)

    @settings(max_examples=15, deadline=None)
    @given(
        inertia=st.floats(1e-3, 2e-2),
        imbalance=st.floats(-5e-4, 5e-4),
        bias=st.floats(-0.2, 0.2),
        masses=st.lists(st.sampled_from((0.01, 0.02, 0.03, 0.04, 0.06)), min_size=2, max_size=3, unique=True),
        positions=st.sampled_from(((0.15,), (0.15, -0.15), (-0.1, 0.08))),
        rpm=st.lists(st.integers(150, 900), min_size=2, max_size=3, unique=True),
        turns=st.sampled_from((1 / 3, 2 / 3, 1.0, 2.0)),
        lost=st.none() | st.floats(0.01, 0.4),
    )
    def test_of_any_level_lab(
        self,
        inertia: float,
        imbalance: float,
        bias: float,
        masses: list[float],
        positions: tuple[float, ...],
        rpm: list[int],
        turns: float,
        lost: float | None,
    ) -> None:
        decay = None if lost is None else Decay(lost=lost)
        # Spins that are nearly equal cannot tell the timing bias from the inertia.
        bias = bias if max(rpm) > 1.2 * min(rpm) else 0.0
        truth = Truth(inertia, imbalance=imbalance, timing_bias=bias, decay=decay)
        design = Design(tuple(masses), positions, tuple(x * RPM for x in rpm), (turns,))
        assert abs(off(simulated(truth, design, EXACT))) < 1e-8

    @settings(max_examples=10, deadline=None)
    @given(
        inertia=st.floats(2e-3, 1e-2),
        ratio=st.floats(0.6, 2.0),
        degrees=st.lists(st.integers(-50, 50), min_size=1, max_size=2, unique=True),
        rpm=st.lists(st.integers(400, 900), min_size=2, max_size=3, unique=True),
    )
    def test_of_any_tilted_lab(self, inertia: float, ratio: float, degrees: list[int], rpm: list[int]) -> None:
        truth = Truth(inertia, ratio * inertia)
        design = Design(spins=tuple(x * RPM for x in rpm), pitches=tuple(math.radians(d) for d in degrees))
        assert abs(off(simulated(truth, design, EXACT))) < 1e-8

    @pytest.mark.parametrize(
        "design",
        [Design(), Design(positions=(0.15, -0.15), spins=(400 * RPM,)), Design(spins=(400 * RPM, 600 * RPM))],
        ids=["three spins", "400 rpm on both sides", "two spins"],
    )
    def test_of_a_released_rod_within_a_tenth_of_a_percent(self, design: Design) -> None:
        done = simulated(Truth(motion="released"), design, EXACT)
        assert abs(off(done)) < 1e-3
        runs = done.runs
        top = motion.Top(INERTIA, runs.across, runs.torque)
        mean = np.abs(motion.mean_precession_rate(top, motion.released(top, runs.spin)))
        # It nods, and may be caught early or late by what the nutation is worth, but not by more.
        late = np.abs(runs.time - 2 * np.pi / mean)
        assert np.all(late < 1.05 * physics.click_error(runs.spin, INERTIA, runs.across))

    def test_of_a_tilted_rod_with_a_falling_spin_nearly(self) -> None:
        done = simulated(Truth(decay=Decay(lost=0.3)), Design((0.06,), spins=(200 * RPM,), pitches=TILTED[1:]), EXACT)
        runs = done.runs
        fall = math.log(1 / 0.7)
        mean = physics.harmonic_mean_spin(runs.spin, runs.spin_end or 0.0)
        rate, up = 2 * np.pi / runs.time, np.sin(runs.pitch)
        taken = (runs.torque / rate + runs.across * up * rate) / (mean + up * rate)
        rule = (1 - runs.across / INERTIA) * rate / mean * up * fall**2 / 4
        assert taken / INERTIA - 1 == pytest.approx(rule, rel=0.1)
        assert abs(rule) == pytest.approx(0.001, rel=0.1)


class TestNoise:
    def test_a_class_of_typical_logs_is_as_wrong_as_it_says(self) -> None:
        chi2, dof, deviations = 0.0, 0, []
        for seed in range(40):
            analysis = found(simulated(seed=seed).log)
            chi2, dof = chi2 + analysis.fit.chi2, dof + analysis.fit.dof
            deviations.append((analysis.inertia.value - INERTIA) / (analysis.inertia.u or 0.0))
        # Three standard deviations of what chance does.
        assert chi2 == pytest.approx(dof, abs=3 * math.sqrt(2 * dof))
        assert np.mean(deviations) == pytest.approx(0, abs=3 / math.sqrt(40))
        assert np.mean(np.square(deviations)) == pytest.approx(1, abs=3 * math.sqrt(2 / 40))

    def test_errors_are_shared_as_the_analysis_takes_them_to_be(self) -> None:
        design = Design((0.0, 0.02, 0.04), (0.15, -0.1), (20.0, 40.0))
        done = simulated(Truth(imbalance=3e-4), design)
        sources = {source.name: source for source in measure(done.readings).sources}
        alone = {role: np.ones(10) for role in ("time", "spin", "mass", "position")}
        loaded = done.runs.mass > 0
        true = alone | {
            "mass": np.where(loaded, done.runs.mass, np.nan), "position": np.where(loaded, done.runs.position, np.nan)
        }  # fmt: skip
        for key in ("u_time", "u_spin", "u_spin_scale", "u_mass", "u_mass_scale", "u_position", "u_position_zero"):
            read = put_errors(true, {key: Uncertainty(1e-3)}, np.random.default_rng(1))
            role = key.removeprefix("u_").partition("_")[0]
            errors = (read[role] - true[role]).round(9)
            source = sources[key.removeprefix("u_")]
            groups = np.array(source.groups)
            there = ~np.isnan(errors)
            for group in set(groups[there]) - {-1}:
                assert len(set(errors[there & (groups == group)])) == 1, key
            assert len(set(errors[there])) == len(set(groups[there]) - {-1}), key
            for other in set(read) - {role}:
                np.testing.assert_array_equal(read[other], true[other])

    def test_start_and_end_have_one_tachometer_and_two_readings(self) -> None:
        true = {"spin_start": np.full(4, 40.0), "spin_end": np.full(4, 20.0)}
        one = put_errors(true, {"u_spin_scale": Uncertainty(0.0, 0.01)}, np.random.default_rng(1))
        np.testing.assert_allclose(one["spin_start"], 2 * one["spin_end"])
        two = put_errors(true, {"u_spin": Uncertainty(0.0, 0.01)}, np.random.default_rng(1))
        assert len(set((two["spin_start"] / 40).round(12)) | set((two["spin_end"] / 20).round(12))) == 8

    def test_errors_have_the_stated_size(self) -> None:
        random = np.random.default_rng(1)
        values = np.full(4000, 0.2)
        read = put_errors({"time": values}, {"u_time": Uncertainty(0.01, 0.1)}, random)["time"]
        assert np.std(read) == pytest.approx(0.03, rel=0.04)
        assert np.mean(read) == pytest.approx(0.2, abs=0.0015)

    def test_readings_have_the_digits_they_deserve(self) -> None:
        rows = simulated().log.splitlines()
        first = next(row for row in rows if row.startswith("mass")), rows[-9]
        cells = dict(zip(*(row.split(",") for row in first), strict=True))
        assert [len(cells[name].partition(".")[2]) for name in list(cells)[:4]] == [2, 2, 1, 2]

    def test_another_noise_scales_the_same_errors(self) -> None:
        small, large = (
            simulated(Truth(timing_bias=0.0), Design(), {"u_time": Uncertainty(1e-3 * size)}).readings.columns["time"]
            for size in (1.0, 10.0)
        )
        exact = simulated(Truth(timing_bias=0.0), Design(), EXACT).runs.time
        np.testing.assert_allclose(10 * (np.array(small.values) - exact), np.array(large.values) - exact, atol=3e-3)

    def test_what_is_not_given_is_drawn_and_told(self) -> None:
        noise = {**TYPICAL, "u_imbalance": Uncertainty(3e-4)}
        drawn = [simulated(noise=noise, seed=seed).truth for seed in range(300)]
        assert np.std([truth.imbalance for truth in drawn]) == pytest.approx(3e-4, rel=0.15)
        assert np.std([truth.timing_bias for truth in drawn]) == pytest.approx(
            TYPICAL["u_time_bias"].absolute, rel=0.15
        )
        given = simulated(Truth(imbalance=1e-4, timing_bias=0.0), noise=noise).truth
        assert (given.imbalance, given.timing_bias) == (1e-4, 0.0)

    def test_an_exact_log_says_that_nobody_knows_the_bias_it_has(self) -> None:
        assert simulated(noise=EXACT).noise["u_time_bias"] == Uncertainty()
        assert simulated(Truth(timing_bias=0.05), noise=EXACT).noise["u_time_bias"].absolute > 10

    def test_a_design_without_errors_is_for_other_errors(self) -> None:
        done = simulated(Truth(imbalance=2e-4), seed=None)
        measured = measure(done.readings)
        np.testing.assert_allclose(measured.time, done.runs.time, rtol=1e-12)
        assert {source.name: source.default for source in measured.sources}["time"] is False
        # A median: the doubt about M0 makes the two sides differ by a little.
        assert fitting.fit(measured).inertia.value == pytest.approx(INERTIA, rel=1e-3)
        assert "no errors" in done.log.splitlines()[0]


class TestNoiseFile:
    def test_toml_and_the_lines_of_a_log_say_the_same(self, tmp_path: Path) -> None:
        (tmp_path / "a.toml").write_text(
            'u_time = "0.3 s"\nu_spin = "0.5 % + 1 rpm"\nu_g = "0.1 %"\n', encoding="utf-8"
        )
        lines = "# station: 3\n# u_time: 0.3 s\n#u_spin : 0.5 % + 1 rpm\n# u_g: 0.1 %\nmass [g],time [s]\n20,7\n"
        (tmp_path / "log.csv").write_text(lines, encoding="utf-8")
        noise = read_noise(tmp_path / "a.toml")
        assert noise == read_noise(tmp_path / "log.csv")
        assert noise["u_time"] == Uncertainty(0.3)
        assert noise["u_mass"] == TYPICAL["u_mass"]
        log = gyro("simulate", "--noise", str(tmp_path / "a.toml")).stdout
        assert "# u_time: 0.3 s" in log
        assert "# u_g: 0.1 %" in log
        assert read_log(log).uncertainties["u_spin"] == noise["u_spin"]
        assert read_log(log).constants["g"] != physics.STANDARD_GRAVITY

    def test_a_simulated_log_is_a_noise_file_too(self, tmp_path: Path) -> None:
        (tmp_path / "log.csv").write_text(simulated(noise=EXACT).log, encoding="utf-8")
        noise = read_noise(tmp_path / "log.csv")
        # What it has no readings for it does not state.
        absent = ("u_pitch", "u_transverse_inertia", "u_turns", "u_decay_exponent")
        assert noise == {**EXACT, **{key: TYPICAL[key] for key in absent}}

    @pytest.mark.parametrize(
        ("content", "said"),
        [
            (b'u_tme = "0.1 s"\n', "did you mean u_time"),
            (b'g = "9.8 m/s^2"\n', "has no such uncertainty"),
            (b'u_torque = "1 %"\n', "has no such uncertainty"),
            (b"u_time = 0.1\n", "has no unit"),
            (b'u_time = "-1 s"\n', "negative"),
            (b'u_spin_scale = "1 rpm"\n', "not a share"),
            (b"nothing to see here\n", "noise:1:9: error G636: this is not TOML"),
            (b"# a remark\n", "states no uncertainty"),
            (b"\xff\xfe\x00", "not UTF-8"),
            (b'u_time = ["1 s"]\n', "not a number"),
        ],
    )
    def test_what_cannot_be_read(self, content: bytes, said: str, tmp_path: Path) -> None:
        (tmp_path / "noise").write_bytes(content)
        done = gyro("simulate", "--noise", str(tmp_path / "noise"))
        assert done.exit_code == 2
        assert said in done.stderr
        assert "G636" in done.stderr

    @pytest.mark.parametrize(
        "lines", ['u_tme = "1 s"\nu_mass = "little"\n', "# u_tme: 1 s\r\n# u_mass: little\n20,7\n"]
    )
    def test_all_faults_at_once_each_with_its_place(self, lines: str, tmp_path: Path) -> None:
        (tmp_path / "noise.toml").write_text(lines, encoding="utf-8", newline="")
        with pytest.raises(InputError) as caught:
            read_noise(tmp_path / "noise.toml")
        column = 3 if lines.startswith("#") else 1
        assert [(one.line, one.column) for one in caught.value.diagnostics] == [(1, column), (2, column)]
        assert [one.excerpt for one in caught.value.diagnostics] == lines.splitlines()[:2]
        assert set(NOISE_KEYS) >= set(TYPICAL)


class TestWhatARealLabHas:
    """What the log says nothing of, each against its own closed form."""

    ONE = Design(masses=(0.04,), spins=(400 * RPM,))

    @pytest.mark.parametrize("exponent", [0.0, 0.7, 1.0, 2.0])
    @pytest.mark.parametrize("how", [{"lost": 0.3}, {"time_constant": 100.0}])
    def test_a_level_rod_has_the_harmonic_mean_of_its_law(self, exponent: float, how: dict[str, float]) -> None:
        runs = happen(Truth(decay=Decay(exponent=exponent, **how)), self.ONE)
        assert runs.spin_end is not None
        mean = physics.harmonic_mean_spin(runs.spin, runs.spin_end, exponent)
        assert runs.time[0] == pytest.approx(2 * np.pi * INERTIA * mean[0] / runs.torque[0], rel=1e-9)

    @pytest.mark.parametrize("exponent", [0.0, 1.0, 2.0])
    def test_a_part_lost_and_its_time_constant_are_the_same_fall(self, exponent: float) -> None:
        tilted = replace(self.ONE, pitches=TILTED[:1])
        by_part = happen(Truth(decay=Decay(lost=0.3, exponent=exponent)), tilted)
        constant = Decay(exponent=exponent).constant(by_part.time, 0.3)
        again = happen(Truth(decay=Decay(time_constant=float(np.ravel(constant)[0]), exponent=exponent)), tilted)
        assert again.time == pytest.approx(by_part.time, rel=1e-9)
        assert again.spin_end == pytest.approx(0.7 * by_part.spin, rel=1e-9)
        assert again.spin_half == pytest.approx(by_part.spin_half, rel=1e-9)

    def test_a_spin_read_at_half_time_or_later(self) -> None:
        decay = Decay(time_constant=300.0)
        design = replace(self.ONE, spin_reading="half")
        half, late = (happen(Truth(decay=decay, spin_delay=delay), design) for delay in (0.0, 2.0))
        assert half.spin_half is not None
        assert half.spin_end is not None
        assert half.spin_half**2 == pytest.approx(half.spin * half.spin_end, rel=1e-12)
        assert late.spin_half == pytest.approx(half.spin_half * math.exp(-2 / 300), rel=1e-12)
        assert late.time == half.time

    @pytest.mark.parametrize(
        ("reading", "columns"),
        [
            (None, {"spin_start", "spin_end"}),
            ("both", {"spin_start", "spin_end"}),
            ("half", {"spin"}),
            ("three", {"spin_start", "spin", "spin_end"}),
        ],
    )
    def test_what_is_read_of_a_falling_spin(self, reading: SpinReading | None, columns: set[str]) -> None:
        done = simulated(Truth(decay=Decay(lost=0.1)), Design(spin_reading=reading))
        assert {role for role in read_log(done.log).columns if "spin" in role} == columns

    def test_three_readings_tell_any_law_and_two_do_not(self) -> None:
        truth = Truth(timing_bias=0.0, decay=Decay(lost=0.3, exponent=0.0))
        thrice, twice = (simulated(truth, Design(spin_reading=reading), seed=None) for reading in ("three", "both"))
        assert abs(off(thrice)) < 1e-3
        assert off(twice) == pytest.approx(0.0107, rel=0.05)

    def test_a_rod_let_go_under_drag(self) -> None:
        slow = replace(self.ONE, turns=(1 / 3,))
        free = happen(Truth(motion="released"), slow)
        hardly, dragged = (
            happen(Truth(motion="released", decay=Decay(time_constant=constant)), slow) for constant in (9e6, 100.0)
        )
        assert hardly.time == pytest.approx(free.time, rel=1e-5)
        # Its spin falls, so that it goes as a steady rod's would, but for its nodding.
        steady = happen(Truth(decay=Decay(time_constant=100.0)), slow)
        click = physics.click_error(dragged.spin, INERTIA, dragged.across)
        assert dragged.time == pytest.approx(steady.time, abs=1.1 * click[0])
        assert dragged.time[0] < 0.99 * free.time[0]
        assert dragged.spin_end == pytest.approx(dragged.spin * np.exp(-dragged.time / 100), rel=1e-12)

    @pytest.mark.parametrize("latitude", [0.74, -0.74])
    def test_the_mark_goes_on_with_the_earth(self, latitude: float) -> None:
        design = Design(masses=(0.0, 0.04), spins=(400 * RPM, -400 * RPM))
        still, turning = (happen(Truth(imbalance=3e-4, latitude=where), design) for where in (None, latitude))
        rate = still.sense * 2 * np.pi / still.time
        seen = rate - physics.EARTH_ROTATION * math.sin(latitude)
        assert turning.time == pytest.approx(2 * np.pi / np.abs(seen), rel=1e-12)

    def test_a_log_tells_the_latitude_and_the_earth_is_in_it(self) -> None:
        truth = Truth(imbalance=3e-4, timing_bias=0.0, latitude=0.74)
        done = simulated(truth, Design(masses=(0.0, 0.02, 0.04)), seed=None)
        assert read_log(done.log).constants["latitude"] == 0.74
        assert "latitude 0.74 rad" in done.log.splitlines()[0]

    def test_normal_gravity_goes_with_the_latitude(self) -> None:
        log = gyro("simulate", "--latitude", "45deg", "--noise", "none").stdout
        assert read_log(log).constants["g"] == pytest.approx(9.80620, abs=1e-5)
        given = gyro("simulate", "--latitude", "45deg", "--g", "9.81 m/s^2", "--noise", "none").stdout
        assert read_log(given).constants["g"] == 9.81

    def test_the_balance_drifts_from_the_first_run_to_the_last(self) -> None:
        still, drifting = (happen(Truth(balance_drift=drift), Design()) for drift in (0.0, 6e-4))
        np.testing.assert_allclose(drifting.torque - still.torque, np.linspace(-3e-4, 3e-4, 9), rtol=1e-9)

    def test_parts_of_a_turn_are_sighted_and_whole_turns_are_not(self) -> None:
        design = Design(turns=(1 / 3, 1.0), repeats=300)
        noise = {"u_turns": Uncertainty(0.01)}
        done = simulated(Truth(timing_bias=0.0), design, noise)
        off = np.array(done.readings.columns["time"].values) / done.runs.time - 1
        part = done.runs.turns < 1
        assert np.std(off[part]) == pytest.approx(0.03, rel=0.05)
        assert np.max(np.abs(off[~part])) < 1e-9
        again = read_log(simulated(Truth(timing_bias=0.0), Design(turns=(1 / 3, 1.0)), noise).log)
        stated = [reading.u for reading in again.columns["turns"].readings[:2]]
        assert stated == [Uncertainty(0.01), None]

    def test_sighting_is_of_both_clicks(self) -> None:
        log = gyro("simulate", "--sighting", "1deg", "--turns", "1/3").stdout
        assert read_log(log).uncertainties["u_turns"].absolute == pytest.approx(math.sqrt(2) / 360)

    def test_heavy_tails_are_the_stopwatch_s(self) -> None:
        true = {"time": np.full(4000, 20.0), "spin": np.full(4000, 20.0)}
        noise = {"u_time": Uncertainty(0.1), "u_spin": Uncertainty(0.1)}
        read = put_errors(true, noise, np.random.default_rng(1), tails=3)
        far = {role: np.mean(np.abs(values - 20) > 0.4) for role, values in read.items()}
        assert far["time"] == pytest.approx(0.028, abs=0.008)
        assert far["spin"] < 0.001

    def test_the_first_line_tells_all_of_it(self) -> None:
        told = gyro(
            "simulate", "--spin-decay", "600 s", "--decay-law", "dry", "--spin-reading", "half", "--delay", "2 s",
            "--balance-drift", "0.6 mN*m", "--tails", "3", "--latitude", "42.5deg", "--turns", "1/3", "--seed", "2",
        ).stdout.splitlines()[0]  # fmt: skip
        for words in (
            "rising by 0.0006 N*m from first run to last", "time constant 600.0 s", "dry law of exponent 0.0",
            "half time read 2.0 s late", "Student's t with 3 degrees", "latitude 0.741", "seed 2",
        ):  # fmt: skip
            assert words in told

    def test_what_is_not_given_is_drawn_from_the_noise(self) -> None:
        noise = {**TYPICAL, "u_spin_delay": Uncertainty(2.0), "u_decay_exponent": Uncertainty(0.5)}
        design = replace(self.ONE, spin_reading="half")
        fallen = Truth(decay=Decay(time_constant=600.0))
        drawn = [simulated(fallen, design, noise, seed).truth for seed in range(200)]
        assert np.std([truth.spin_delay for truth in drawn]) == pytest.approx(2.0, rel=0.2)
        assert np.std([truth.decay.exponent for truth in drawn if truth.decay]) == pytest.approx(0.5, rel=0.2)
        assert simulated(Truth(), self.ONE, noise).truth.spin_delay == 0.0


GOLDEN = """\
# Simulated, not measured: I_zz = 0.00444 kg*m^2, I = 0.006 kg*m^2, residual torque 0.0003 N*m, timing bias \
0.06572945148009267 s, steady, seed 1
# g: 9.80665 m/s^2
# u_time: 0.14 s
# u_time_bias: 0.08 s
# u_spin: 0.2 %
# u_spin_scale: 0.1 %
# u_mass: 0.2 %
# u_mass_scale: 0.05 %
# u_position: 0.0003 m
# u_position_zero: 0.0005 m
# u_pitch: 0.03490658503988659 rad
# u_transverse_inertia: 2.0 %
# u_spin_delay: 0.0 %
# u_turns: 0.003928371006591931
# motion: steady
# transverse_inertia: 0.00585 kg*m^2
mass [g],position [cm],spin [rpm],time [s],turns,pitch [deg],spin_sense,precession_sense,run
0,,400.0,1283.83,1/3,11.3,ccw,ccw,1
0,,400.5,1297.09,1/3,11.3,cw,cw,2
19.94,14.97,399.4,13.25,1/3,9.0,ccw,ccw,3
19.94,14.97,399.9,13.10,1/3,6.7,cw,cw,4
19.94,-15.02,399.6,13.45,1/3,10.3,ccw,cw,5
19.94,-15.02,400.5,13.59,1/3,10.2,cw,ccw,6
"""


class TestLog:
    def test_a_small_one(self) -> None:
        done = gyro(
            "simulate", "--weights", "0,20g", "--position=15cm,-15cm", "--spins=400rpm,-400rpm", "--pitch", "10deg",
            "--turns", "1/3", "--transverse", "6e-3 kg m^2", "--imbalance", "0.3 mN m", "--seed", "1",
        )  # fmt: skip
        assert done.exit_code == 0, done.stderr
        assert done.stdout == GOLDEN

    def test_the_default_is_a_log_to_work_with(self) -> None:
        log = gyro("simulate").stdout
        analysis = found(log)
        assert len(analysis.run_table) == 9
        assert abs(analysis.inertia.value - INERTIA) < 3 * (analysis.inertia.u or 0.0)
        assert [d.code for d in analysis.diagnostics] == []

    def test_same_options_same_bytes(self) -> None:
        options = ("simulate", "--weights", "20g,30g", "--spin-decay", "10 %", "--repeats", "2", "--seed")
        assert gyro(*options, "7").stdout == gyro(*options, "7").stdout
        assert gyro(*options, "7").stdout != gyro(*options, "8").stdout

    @pytest.mark.parametrize("noise", [EXACT, TYPICAL], ids=["exact", "typical"])
    @pytest.mark.parametrize("scene", ["level", "both, tilted", "without a weight", "both, falling"])
    def test_it_reads_back_as_it_was_written(self, scene: str, noise: dict[str, Uncertainty]) -> None:
        done = simulated(*SCENES[scene], noise)
        again = read_log(done.log)
        assert again.ok
        assert again.diagnostics == ()
        assert again.uncertainties == done.readings.uncertainties
        assert again.constants == done.readings.constants
        assert again.motion == done.readings.motion
        assert set(again.columns) == set(done.readings.columns)
        for role, column in done.readings.columns.items():
            other = again.columns[role]
            assert column.readings == other.readings, role

    def test_the_order_of_the_runs(self) -> None:
        runs = simulated(Truth(), Design((0.02, 0.04), (0.1, 0.2), (20.0, 40.0), (1 / 3, 1.0), repeats=2)).runs
        assert len(runs.time) == 32
        assert runs.mass[:16].tolist() == [0.02] * 16
        assert runs.position[:8].tolist() == [0.1] * 8
        assert runs.spin[:4].tolist() == [20.0] * 4
        assert runs.turns[:4].tolist() == [1 / 3, 1 / 3, 1.0, 1.0]

    def test_released_and_steady_are_told(self) -> None:
        assert "# motion: released" in gyro("simulate", "--motion", "released").stdout
        assert "# motion: steady" in gyro("simulate").stdout

    def test_quantities_in_other_units(self) -> None:
        same = [
            gyro("simulate", "--spins", spins, "--weights", weights, "--position", position, "--noise", "none").stdout
            for spins, weights, position in (("5Hz", "0.05kg", "150mm"), ("300rpm", "50g", "15cm"))
        ]
        assert found(same[0]).run_table[0].time == pytest.approx(found(same[1]).run_table[0].time, rel=1e-12)


class TestTruthFile:
    def test_it_says_everything(self, tmp_path: Path) -> None:
        file = tmp_path / "truth.json"
        done = gyro(
            "simulate", "--weights", "0g,20g", "--imbalance", "0.3 mN m", "--spin-decay", "10 %", "--spins=-400rpm",
            "--decay-law", "viscous", "--truth", str(file), "--seed", "5",
        )  # fmt: skip
        told = json.loads(file.read_text(encoding="utf-8"))
        assert told["schema"] == "gyro.truth/1"
        assert told["seed"] == 5
        assert told["truth"]["inertia"] == INERTIA
        assert told["truth"]["imbalance"] == 3e-4
        assert told["truth"]["decay"] == {"time_constant": None, "lost": 0.1, "exponent": 1.0}
        assert told["options"]["weights"] == "0g,20g"
        assert str(tmp_path) not in file.read_text(encoding="utf-8")
        log = read_log(done.stdout)
        assert [run["run"] for run in told["runs"]] == list(log.runs)
        unloaded, loaded = told["runs"]
        assert (unloaded["position"], unloaded["torque"]) == (None, 3e-4)
        assert loaded["transverse_inertia"] == pytest.approx(1.3 * INERTIA + 0.02 * 0.15**2)
        assert loaded["spin_end"] == pytest.approx(0.9 * loaded["spin"])
        assert loaded["precession_rate"] == pytest.approx(-2 * math.pi / loaded["time"])
        bias = told["truth"]["timing_bias"]
        for run, time in zip(told["runs"], log.columns["time"].values, strict=True):
            assert time == pytest.approx(run["time"] + bias, abs=4 * 0.14)

    def test_it_is_the_same_for_the_same_options(self, tmp_path: Path) -> None:
        for name in ("a", "b"):
            gyro("simulate", "--truth", str(tmp_path / name))
        assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


MESSAGES: dict[str, tuple[str, str]] = {
    "bare spin": ("--spins 400", 'write --spins "400 rpm"'),
    "bare weight": ("--weights 20,40", 'write --weights "20 g"'),
    "bare inertia": ("--inertia 4.44e-3", "has no unit"),
    "bare decay": ("--spin-decay 600", 'write --spin-decay "600 s"'),
    "bare imbalance": ("--imbalance 0.3", "has no unit"),
    "wrong unit": ("--position 15g", "is no unit of a length"),
    "no number": ("--spins fast", "not a number"),
    "negative inertia": ('--inertia "-1 g m^2"', "below zero"),
    "negative weight": ("--weights=-20g", "negative position"),
    "not a number": ("--spins nanrpm", "not a number"),
    "endless": ("--spins 1e999rpm", "no finite number"),
    "absurd": ("--weights 1e300g", "too large"),
    "no weight": ("--weights 0g", "--imbalance"),
    "no arm": ("--position 0cm", "--imbalance"),
    "weight and imbalance cancel": ("--weights 20g --g 10m/s^2 --imbalance -30mN*m", "cancel"),
    "no spin": ("--spins 0rpm", "is zero"),
    "no turns": ("--turns 0", "is zero"),
    "nothing": ('--weights ""', "0 runs"),
    "too many": ("--repeats 1000000", "a log has 1 to"),
    "none at all": ("--repeats 0", "--repeats"),
    "upright": ("--pitch 90deg", "not between"),
    "too slow": ("--pitch 60deg --spins 40rpm --weights 60g", "it takes more than 61.6 rpm"),
    "too slow at the end": (
        "--pitch 60deg --spins 200rpm --weights 60g --transverse 0.02kg*m^2 --spin-decay 3s",
        "it takes more than 148.4 rpm",
    ),
    "spin gone": ("--spin-decay 1s --decay-law viscous", "fallen to"),
    "all lost": ("--spin-decay 100%", "cannot lose"),
    "level and tilted": ("--motion horizontal --pitch 10deg", "--motion steady"),
    "released, and a part lost": ("--motion released --spin-decay 10%", "with one time constant"),
    "released, dry": ("--motion released --spin-decay 600s --decay-law dry", "as in an air film"),
    "law of nothing": ("--decay-law dry", "this one stays"),
    "read thrice, and stays": ("--spin-reading three", "is read once"),
    "late, and stays": ("--delay 2s", "only where a falling spin is read at half time"),
    "late, and not then": ("--delay 2s --spin-decay 600s", "--spin-reading half"),
    "sighted whole turns": ("--sighting 1deg", "--turns 1/3"),
    "no sight": ("--sighting 0deg --turns 1/3", "is zero"),
    "no such law": ("--spin-decay 600s --decay-law wet", "'viscous', 'dry', 'turbulent'"),
    "no tails": ("--tails 0", "x>=1"),
    "beyond the pole": ("--latitude 100deg", "not between -90 and 90 deg"),
    "absurd drift": ("--balance-drift 1e9N*m", "too large"),
    "early hand": ("--timing-bias=-60s", "not above zero"),
    "wild tachometer": ("--timing-bias=1e9s", "too large"),
    "no noise file": ("--noise no-such-file.toml", "cannot be read"),
    "truth nowhere": ("--truth no-such-folder/truth.json", "cannot be written"),
}


class TestMessages:
    @pytest.mark.parametrize(("options", "said"), MESSAGES.values(), ids=MESSAGES.keys())
    def test_what_cannot_be(self, options: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        done = gyro("simulate", *shlex.split(options))
        assert done.exit_code == 2
        assert said in done.stderr
        assert done.stdout == ""
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize("code", sorted(code for code in CODES if code.startswith("G63")))
    def test_the_example_of_each_code_raises_it(
        self, code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tmp_path)
        done = gyro(*shlex.split(CODES[code].example))
        assert done.exit_code == 2
        assert code in done.stderr

    def test_from_python_too(self) -> None:
        for truth in (
            Truth(inertia=-1.0),
            Truth(g=0.0),
            Truth(motion="wild"),
            Truth(decay=Decay()),
            Truth(decay=Decay(600.0, 0.1)),
        ):  # type: ignore[arg-type]
            with pytest.raises(InputError):
                simulated(truth)
        with pytest.raises(InputError):
            simulated(Truth(timing_bias=math.nan))
        with pytest.raises(InputError):
            simulated(design=Design(spins=(math.nan,)))

    def test_help_has_an_example_that_runs(self) -> None:
        shown = " ".join(gyro("simulate", "--help").stdout.replace("\\\n", " ").split())
        example = shown.partition("Example: gyro ")[2].partition(" > ")[0]
        assert gyro(*shlex.split(example)).exit_code == 0


def test_turns_of_a_design_may_be_whole_numbers() -> None:
    whole, parts = (simulated(Truth(), Design(turns=(turns,)), TYPICAL, 1).readings for turns in (1, 1.0))
    assert whole.columns["turns"].values == parts.columns["turns"].values
