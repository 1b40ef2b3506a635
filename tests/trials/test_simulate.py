"""A log from a known truth: the analysis finds the truth again, and errors have the
stated size.
"""

from __future__ import annotations

import math
import re
import shlex
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from simulated_labs import analyze_briefly
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata import physics
from gyrodata.cli import app
from gyrodata.readings import Uncertainty, read_log, write_log
from gyrodata.trials.simulation import (
    EXACT,
    TYPICAL,
    Design,
    Simulation,
    Truth,
    simulate,
)

RPM = math.pi / 30
INERTIA = 4.44e-3
TILTED = (math.radians(-50), math.radians(50))
BOTH_SPINS = tuple(sign * rpm * RPM for sign in (1, -1) for rpm in (200, 400, 600))
ONE = Design(masses=(0.04,), spins=(400 * RPM,))


def gyro(*arguments: str, stdin: str | None = None) -> Result:
    return CliRunner().invoke(app, arguments, input=stdin)


def found(log: str) -> gyrodata.Analysis:
    return gyrodata.analyze(log.encode())


def off(done: Simulation) -> float:
    """Relative error of I_zz that the analysis makes of a log."""
    return analyze_briefly(done.log).inertia.value / done.truth.inertia - 1


SCENES: dict[str, tuple[Truth, Design]] = {
    "level": (Truth(imbalance=0.0, timing_bias=0.0), Design()),
    "thirds": (Truth(timing_bias=0.0), Design(turns=(1 / 3,))),
    "up and down": (Truth(transverse_inertia=6e-3), Design(pitches=TILTED)),
    "falling spin": (Truth(decay_time=100.0), Design()),
    "falling, tilted": (Truth(decay_time=60.0), Design(pitches=TILTED)),
    "both, tilted": (
        Truth(),
        Design(positions=(0.15, -0.15), spins=BOTH_SPINS, pitches=TILTED),
    ),
    "both, falling": (
        Truth(decay_time=300.0),
        Design(positions=(0.15, -0.15), spins=BOTH_SPINS),
    ),
    "imbalance and bias": (Truth(imbalance=3e-4, timing_bias=0.05), Design(repeats=2)),
    "without a weight": (
        Truth(imbalance=3e-4),
        Design(masses=(0.0, 0.02, 0.04), turns=(1 / 12, 1 / 3)),
    ),
    "turned by the imbalance": (
        Truth(imbalance=-3e-4),
        Design(masses=(0.0, 0.02, 0.04), spins=BOTH_SPINS),
    ),
    "imbalance, falling": (
        Truth(imbalance=3e-4, timing_bias=-0.1, decay_time=150.0),
        Design(),
    ),
    "released, tilted": (Truth(motion="released"), Design(pitches=(math.radians(20),))),
    "released, imbalance": (
        Truth(motion="released", imbalance=5e-4),
        Design(spins=(400 * RPM, 600 * RPM)),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize(("truth", "design"), SCENES.values(), ids=SCENES.keys())
def test_an_exact_log_gives_the_truth_to_eight_digits(
    truth: Truth, design: Design
) -> None:
    analysis = analyze_briefly(simulate(truth, design, EXACT).log)
    low, high = analysis.inertia.interval_95
    # The phase of the nutation is not followed from run to run: it is in u.
    near = {"abs": analysis.inertia.u} if truth.motion == "released" else {"rel": 1e-8}
    assert analysis.inertia.value == pytest.approx(truth.inertia, **near)
    assert truth.motion == "steady" or low < truth.inertia < high
    assert not any(run.flagged for run in analysis.run_table)
    if truth.motion == "steady" and truth.decay_time is None:
        assert analysis.residual_torque.value == pytest.approx(
            truth.imbalance or 0.0, abs=1e-10
        )
        assert analysis.timing_bias.value == pytest.approx(
            truth.timing_bias or 0.0, abs=1e-6
        )


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(
    inertia=st.floats(1e-3, 2e-2),
    imbalance=st.floats(-5e-4, 5e-4),
    bias=st.floats(-0.2, 0.2),
    masses=st.lists(
        st.sampled_from((0.01, 0.02, 0.03, 0.04, 0.06)),
        min_size=2,
        max_size=3,
        unique=True,
    ),
    positions=st.sampled_from(((0.15,), (0.15, -0.15), (-0.1, 0.08))),
    rpm=st.lists(st.integers(150, 900), min_size=2, max_size=3, unique=True),
    turns=st.sampled_from((1 / 3, 2 / 3, 1.0, 2.0)),
    constant=st.none() | st.floats(100.0, 5000.0),
    tilted=st.none() | st.tuples(st.floats(0.6, 2.0), st.integers(-50, 50)),
)
def test_an_exact_log_of_any_lab_gives_the_truth(
    inertia: float,
    imbalance: float,
    bias: float,
    masses: list[float],
    positions: tuple[float, ...],
    rpm: list[int],
    turns: float,
    constant: float | None,
    tilted: tuple[float, int] | None,
) -> None:
    # Spins that are nearly equal cannot distinguish the timing bias from the inertia.
    bias = bias if max(rpm) > 1.2 * min(rpm) else 0.0
    truth = Truth(
        inertia,
        imbalance=imbalance,
        timing_bias=bias,
        decay_time=constant,
    )
    design = Design(tuple(masses), positions, tuple(x * RPM for x in rpm), (turns,))
    if tilted:
        truth = Truth(inertia, tilted[0] * inertia)
        design = Design(
            spins=tuple(x + 400 * RPM for x in design.spins),
            pitches=(math.radians(tilted[1]),),
        )
    assert abs(off(simulate(truth, design, EXACT))) < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("sense", "pitch", "turns", "constant", "ratio"),
    [
        (1, 0.0, 1.0, 60.0, 1.3),
        (1, 0.9, 1.0, 40.0, 1.3),
        (1, -0.9, 1.0, 40.0, 1.3),
        (-1, -0.9, 1 / 3, 20.0, 1.8),
        (1, 1.0, 1.0, 60.0, 0.7),
        (1, 1e-5, 1.0, 60.0, 1.3),
        (1, 0.7, 1.0, 1e7, 1.3),
    ],
)
def test_the_time_of_a_falling_spin_is_that_of_the_integral(
    sense: int, pitch: float, turns: float, constant: float, ratio: float
) -> None:
    """The slow root of eq. (8), integrated to 30 digits while the spin falls."""
    truth = Truth(INERTIA, ratio * INERTIA, decay_time=constant)
    design = Design((0.02,), spins=(sense * 60.0,), turns=(turns,), pitches=(pitch,))
    runs = simulate(truth, design, EXACT).runs
    torque, across = float(runs.torque[0]), float(np.ravel(runs.transverse_inertia)[0])
    with mpmath.workdps(30):
        lean = (INERTIA - mpmath.mpf(across)) * mpmath.sin(pitch)

        def rate(t: Any) -> Any:
            momentum = INERTIA * mpmath.mpf(60) * mpmath.exp(-t / constant)
            return (
                2 * torque / (momentum + mpmath.sqrt(momentum**2 + 4 * lean * torque))
            )

        guess = 2 * mpmath.pi * turns / rate(mpmath.mpf(0))
        expected = mpmath.findroot(
            lambda end: mpmath.quad(rate, [0, end]) - 2 * mpmath.pi * turns,
            (guess, 0.9 * guess),
            tol=1e-24,
        )
    assert runs.time[0] == pytest.approx(float(expected), rel=1e-12)


@pytest.mark.slow
def test_three_spin_readings_find_any_law_of_decay() -> None:
    """Dry friction: the spin falls evenly by 30 %, so that a run takes 2π I_zz ψ̇ 0.3 /
    (M ln(1/0.7)).
    """
    rows = [
        (
            "mass [g],position [cm],spin at start [rad/s],spin [rad/s],spin at end "
            "[rad/s],time [s],turns"
        )
    ]
    for mass, spin in (
        (mass, spin) for mass in (20, 40, 60) for spin in (20.0, 40.0, 60.0)
    ):
        time = (
            2
            * math.pi
            * INERTIA
            * spin
            * 0.3
            / (mass * 1.5e-4 * physics.STANDARD_GRAVITY * math.log(1 / 0.7))
        )
        rows.append(f"{mass},15.0,{spin},{0.85 * spin},{0.7 * spin:.1f},{time},1")
    head = f"# g: {physics.STANDARD_GRAVITY} m/s^2\n# u_time_bias: 0 s\n# u_spin_delay: 0 s\n"
    assert found(head + "\n".join(rows)).inertia.value == pytest.approx(
        INERTIA, rel=2e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "role", "within"),
    [
        ("u_time", "time", 1),
        ("u_spin", "spin", 1),
        ("u_spin_scale", "spin", 0),
        ("u_mass", "mass", 0),
        ("u_mass_scale", "mass", 0),
        ("u_position_zero", "position", 0),
    ],
)
def test_errors_have_the_stated_size_and_are_shared(
    key: str, role: str, within: int
) -> None:
    """A share of 1 % of one weight, timed 100 times: each reading has its own error, or
    all have one.
    """
    wide = Uncertainty(0.0015) if role == "position" else Uncertainty(0.0, 0.01)
    spread, common = [], []
    for seed in range(6):
        done = simulate(
            Truth(timing_bias=0.0), replace(ONE, repeats=100), {key: wide}, seed
        )
        share = (
            np.array(read_log(done.log).columns[role].values) / getattr(done.runs, role)
            - 1
        )
        spread.append(share.std())
        common.append(share.mean())
    assert np.mean(spread) == pytest.approx(0.01 * within, rel=0.1, abs=1e-9)
    assert np.std(common) == pytest.approx(
        0.01 / (math.sqrt(100) if within else 1), rel=0.6
    )


@pytest.mark.slow
@pytest.mark.parametrize("noise", [EXACT, TYPICAL], ids=["exact", "typical"])
@pytest.mark.parametrize("scene", ["both, tilted", "without a weight"])
def test_a_simulated_log_is_canonical_and_states_its_noise(
    scene: str, noise: dict[str, Uncertainty]
) -> None:
    done = simulate(*SCENES[scene], noise)
    again = read_log(done.log)
    assert again.diagnostics == ()
    assert write_log(again) == done.log.partition("\n")[2]
    assert again.uncertainties == done.noise


@pytest.mark.slow
def test_the_default_log_raises_no_diagnostic_and_same_bytes() -> None:
    log = gyro("simulate").stdout
    analysis = found(log)
    assert (len(analysis.run_table), list(analysis.diagnostics)) == (9, [])
    assert abs(analysis.inertia.value - INERTIA) < 3 * (analysis.inertia.u or 0.0)
    assert gyro("simulate").stdout == log != gyro("simulate", "--seed", "8").stdout


def test_truth_is_in_the_record_and_in_the_first_line() -> None:
    done = gyro(
        "simulate",
        "--weights",
        "0g,20g",
        "--imbalance",
        "0.3 mN m",
        "--spin-decay",
        "600 s",
        "--spins=-400rpm",
        "--seed",
        "5",
    )
    truth = Truth(imbalance=3e-4, decay_time=600.0)
    simulation = simulate(
        truth, Design(masses=(0, 0.02), spins=(-400 * physics.RPM,)), seed=5
    )
    assert simulation.log == done.stdout
    true, runs, log = simulation.truth, simulation.runs, read_log(done.stdout)
    assert (true.inertia, true.imbalance, runs.torque[0]) == (INERTIA, 3e-4, 3e-4)
    assert runs.spin_end == pytest.approx(runs.spin * np.exp(-runs.time / 600))
    assert log.columns["time"].values == pytest.approx(
        runs.time + true.timing_bias, abs=4 * 0.14
    )
    first = done.stdout.splitlines()[0]
    assert "residual torque 0.0003 N*m, " in first
    assert not re.search(r"\d{8}", first)


def test_noise_is_read_from_the_lines_of_a_log(tmp_path: Path) -> None:
    lines = (
        "# station: 3\n# u_time: 0.3 s\n#u_spin : 0.5 % + 1 rpm\n# u_g: 0.1 %\nmass "
        "[g],time [s]\n20,7\n"
    )
    (tmp_path / "log.csv").write_text(lines, encoding="utf-8")
    log = gyro("simulate", "--noise", str(tmp_path / "log.csv")).stdout
    stated = read_log(log).uncertainties
    assert stated["u_time"] == Uncertainty(0.3)
    assert stated["u_spin"] == Uncertainty(2 * math.pi / 60, 0.005)
    assert read_log(log).constants["g"] != physics.STANDARD_GRAVITY


@pytest.mark.parametrize(
    ("content", "code", "said"),
    [
        (b"# u_tme: 0.1 s\n", "G636", "did you mean u_time"),
        (b"nothing to see here\n", "G636", "known here: u_time, "),
        (b"# a remark\n", "G636", "known here: u_time, "),
        (b"\xff\xfe\x00", "G105", "this is not text"),
        (b"# u_time: long\n", "G306", '"long" is not a number'),
        (b"# u_mass_scale: 0.1 g\n", "G306", "is in %"),
    ],
)
def test_a_noise_file_that_cannot_be_read_is_refused(
    content: bytes, code: str, said: str, tmp_path: Path
) -> None:
    (tmp_path / "noise").write_bytes(content)
    done = gyro("simulate", "--noise", str(tmp_path / "noise"))
    assert done.exit_code == 2
    assert code in done.stderr
    assert said in done.stderr


MESSAGES = [
    ("--spins 400", 'write --spins "400 rpm"'),
    ("--weights=-20g", "run 1: mass must not be below zero"),
    ("--weights 20g --imbalance -29.41995mN*m", "change the weight"),
]


@pytest.mark.parametrize(("options", "said"), MESSAGES)
def test_an_impossible_lab_is_refused(
    options: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = gyro("simulate", *shlex.split(options))
    assert (done.exit_code, done.stdout) == (2, "")
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []
