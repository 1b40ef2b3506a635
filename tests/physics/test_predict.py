"""`gyro predict`: each number against its formula or an integrator, what a log gives,
and what is refused.
"""

from __future__ import annotations

import json
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
from places import SAMPLES
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner, Result

import gyrodata
from gyrodata.cli import app

RPM = math.pi / 30
INERTIA, ACROSS, SPIN = 4.44e-3, 7.1e-3, 400 * RPM
TORQUE = 0.06 * 0.15 * 9.8031
LOG = SAMPLES / "air_gyroscope.csv"
I_ZZ = "--inertia '4.44e-3 kg m^2'"
TOP = f"{I_ZZ} --transverse '7.1e-3 kg m^2'"
WEIGHT = '--mass 60g --position 15cm --g "9.8031 m/s^2"'
ROD = f"precession {TOP} {WEIGHT}"
PULL = "tip --force 0.5N --length 20cm"
WHEEL = "--wheel-inertia '0.1 kg m^2' --wheel-spin 200rpm --platform-inertia '4 kg m^2'"
HELD = "--wheel-inertia '0.1 kg m^2' --wheel-spin 200rpm"
STAR = f"earth --latitude 42.5deg --hours {2 * math.pi / 7.292115e-5 / 4 / 3600!r} --step 6"
COMMANDS = ("earth", "platform", "tip", "precession", "twist")


def gyro(command: str) -> Result:
    return CliRunner().invoke(app, ["predict", *shlex.split(command)], prog_name="gyro")


def asked(command: str) -> dict[str, Any]:
    done = gyro(f"{command} --format json")
    assert done.exit_code == 0, done.output
    assert not {"NaN", "Infinity"} & set(
        re.findall(r"\w+", re.sub(r'"[^"]*"', "", done.stdout))
    )
    return json.loads(done.stdout)  # type: ignore[no-any-return]


def part(told: Any, place: str) -> Any:
    """The value at a place such as "released.sag" or "east.-1.azimuth_deg"."""
    for name in place.split("."):
        told = told[int(name)] if isinstance(told, list) else told[name]
    return told


def roots(pitch: float) -> list[float]:
    """Both solutions of eq. (8), the slow one first, to 30 digits."""
    with mpmath.workdps(30):
        a = (mpmath.mpf(INERTIA) - mpmath.mpf(ACROSS)) * mpmath.sin(
            mpmath.radians(pitch)
        )
        b = mpmath.mpf(INERTIA) * 400 * mpmath.pi / 30
        root = mpmath.sqrt(b * b + 4 * a * TORQUE)
        return [float((-b + root) / (2 * a)), float((-b - root) / (2 * a))]


SAG = ACROSS * TORQUE / (INERTIA * 200 * RPM) ** 2
WHEEL_MOMENTUM = 0.1 * 200 * RPM
NUMBERS = [
    (f"{ROD} --spin 400rpm --pitch 10deg", "slow", roots(10)[0], 1e-11),
    (f"{ROD} --spin 400rpm --pitch 10deg", "fast", roots(10)[1], 1e-11),
    (f"{ROD} --spin 400rpm --pitch 10deg", "period", 2 * math.pi / roots(10)[0], 1e-11),
    (f"{ROD} --spin '-400 rpm'", "slow", -TORQUE / (INERTIA * SPIN), 1e-11),
    # A conical pendulum.
    (
        f"{ROD} --spin 0rpm --pitch -30deg",
        "slow",
        math.sqrt(TORQUE / ((ACROSS - INERTIA) * 0.5)),
        1e-11,
    ),
    # The least spin of 60 g at 60 degrees, and of an upright rod: published values in
    # rpm.
    (f"{ROD} --spin 50rpm --pitch 60deg", "critical_spin", 61.32 * RPM, 1e-4),
    *(
        (
            (
                f"precession {I_ZZ} --transverse '5.74e-3 kg m^2' --mass {grams}g "
                f"--position 15cm --spin 99rpm"
            ),
            "sleeping.critical_spin",
            rpm * RPM,
            0.01,
        )
        for grams, rpm in ((20, 56), (40, 79), (60, 97))
    ),
    # Let go from rest: 1.02 % slower in the mean, by elliptic integrals.
    (
        f"{ROD} --spin 200rpm",
        "released.mean_rate",
        TORQUE / (INERTIA * 200 * RPM) / 1.0102,
        1e-4,
    ),
    (f"{ROD} --spin 200rpm", "released.sag", SAG, 5 * SAG**2),
    (
        f"{ROD} --spin 200rpm",
        "released.nutation_rate",
        INERTIA * 200 * RPM / ACROSS,
        0.02,
    ),
    (f"{ROD} --spin 0rpm", "released.greatest_sag", math.pi / 2, 1e-9),
    # Eqs. (7) integrated for tilted rods.
    *(
        (
            (
                f"precession {I_ZZ} --transverse '7.104e-3 kg m^2' --g '9.8 m/s^2' "
                f"--spin {rpm}rpm --pitch {pitch}deg"
            ),
            place,
            value,
            1e-4,
        )
        for pitch, rpm, rate, sag in (
            (60, 144, 7.108, 6.346),
            (80, 108, 2.564, 12.626),
            (-70, 144, 11.674, 1.9242),
        )
        for place, value in (
            ("released.nutation_rate", rate),
            ("released.sag", math.radians(sag)),
        )
    ),
    (STAR, "east.-1.azimuth_deg", 180, 1e-8),
    (STAR, "east.-1.altitude_deg", 47.5, 1e-8),
    (STAR, "axis.-1.altitude_deg", 42.5, 1e-9),
    ("earth --latitude 42.5deg", "sidereal_day_hours", 86164.0905 / 3600, 1e-6),
    (STAR.replace("42.5", "-42.5"), "axis.-1.azimuth_deg", 180, 1e-9),
    (
        f"earth {I_ZZ} --spin '-400 rpm'",
        "drift_torque",
        INERTIA * SPIN * 2 * math.pi / 86164.1,
        1e-6,
    ),
    (f"platform {WHEEL} --from 0deg --to 90deg", "period", 12, 1e-11),
    (
        f"platform {WHEEL} --from 70deg --to -20deg",
        "rate",
        WHEEL_MOMENTUM * (math.sin(math.radians(70)) + math.sin(math.radians(20))) / 4,
        1e-11,
    ),
    (
        f"twist {HELD} --time 0.5s --handles 30cm",
        "force",
        WHEEL_MOMENTUM * 2 * math.pi / 0.3,
        1e-11,
    ),
    (f"twist {HELD} --time 0.5s", "momentum_change", 2 * WHEEL_MOMENTUM, 1e-11),
    (
        f"{PULL} {I_ZZ} --spin 4000rpm",
        "speed",
        0.5 * 0.2**2 / (INERTIA * 4000 * RPM),
        1e-4,
    ),
    (f"{PULL} {I_ZZ} --spin '-400 rpm'", "angle_deg", -90, 1e-11),
    # Without spin Newton's law: the angular acceleration is L F/I.
    (
        f"{PULL} {I_ZZ} --transverse '6e-3 kg m^2' --spin 0rpm",
        "acceleration",
        0.5 * 0.2**2 / 6e-3,
        1e-11,
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("command", "place", "value", "rel"), NUMBERS)
def test_a_predicted_number_is_that_of_its_formula(
    command: str, place: str, value: float, rel: float
) -> None:
    assert part(asked(command), place) == pytest.approx(value, rel=rel, abs=1e-12)


@pytest.mark.parametrize(
    ("command", "place", "said"),
    [
        (f"{ROD} --spin 50rpm --pitch 60deg", "slow", "too slow for steady precession"),
        (f"{ROD} --spin '-400 rpm'", "fast", "goes round, clockwise seen from above"),
        (f"{ROD} --spin 0rpm", "slow", "swings like a pendulum"),
        (
            f"precession {TOP} --mass 0g --position 15cm --spin 400rpm",
            "period",
            "without a torque",
        ),
        (f"platform {WHEEL.replace('200', '0')}", "period", "stays at rest"),
        (f"{PULL} {I_ZZ} --spin 0rpm", "speed", "Any force moves it, however small"),
    ],
)
def test_a_number_that_does_not_exist_is_null_and_said(
    command: str, place: str, said: str
) -> None:
    assert part(asked(command), place) is None
    assert said in " ".join(gyro(command).stdout.split())


def test_a_weight_beyond_the_centre_lifts_the_rod() -> None:
    command = (
        f"precession {TOP} --mass 60g --position -15cm --spin 200rpm --pitch 10deg"
    )
    told = asked(command)
    assert told["released"]["greatest_sag"] < told["released"]["sag"] < 0
    assert "; negative: the rod rises" in gyro(command).stdout
    # Below the centre the weight keeps an upright rod upright at any spin.
    assert told["sleeping"] == {"stable": True, "critical_spin": 0, "growth_rate": 0}


# The first example loads scipy.
@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from([0.0, 1.0, -1.0]),
    st.floats(-5, 3),
    st.sampled_from([0.0, 1.0, -1.0]),
    st.floats(-3, 4),
    st.floats(-9, 3),
    st.sampled_from([0.5, 1.0, 1.3, 40.0]),
    st.floats(-1.57, 1.57),
)
def test_any_rod_has_numbers_or_a_reason(
    side: float,
    load: float,
    sense: float,
    speed: float,
    size: float,
    shape: float,
    pitch: float,
) -> None:
    told = asked(
        f"precession --inertia '{10**size} kg m^2' --transverse '{shape * 10**size} kg "
        f"m^2' --pitch '{pitch} rad' "
        f"--position '{side * 10**load} m' --mass 100g --spin '{sense * 10**speed} rad/s'"
    )
    assert told["exists"] is (told["slow"] is not None)
    for found in (told, told["released"]):
        lacking = {name for name, value in found.items() if value is None}
        assert all(name in found["reason"] for name in lacking)


@pytest.mark.slow
@pytest.mark.parametrize("spin", [200, -200])
@pytest.mark.parametrize("way", ["turn_left", "right_end_up"])
def test_a_free_wheel_pushed_as_told_turns_over(spin: int, way: str) -> None:
    """Let the forces act on a free wheel, its right end along X and the forward
    direction Y, and integrate.
    """
    told = asked(f"twist --wheel-inertia '0.1 kg m^2' --wheel-spin '{spin} rpm'")
    turning, push, words = {
        "turn_left": ([0, 0, 1], [0, 0, -1], "right hand pushes down"),
        "right_end_up": ([0, -1, 0], [0, 1, 0], "right hand pushes forward"),
    }[way]
    assert (words in told[way]) is (spin > 0)
    turn, axle = told["twist_rate"] * np.array(turning), np.array([1.0, 0, 0])
    force = told["force"] * np.array(push) * (1 if words in told[way] else -1)

    def moves(time: float, state: np.ndarray) -> np.ndarray:
        # The forces turn with the axle; each hand is at one end.
        by_hand = 2 * np.cross(
            0.2 * state[:3], Rotation.from_rotvec(turn * time).apply(force)
        )
        return np.array([*np.cross(state[3:], state[:3]) / 0.06, *by_hand])

    start = [*axle, *(0.1 * spin * RPM * axle + 0.06 * turn)]
    for time, expected in ((1.0, -axle), (0.5, np.cross(turning, axle))):
        end = solve_ivp(
            moves, (0, time), start, method="DOP853", rtol=1e-10, atol=1e-12
        ).y[:3, -1]
        np.testing.assert_allclose(end, expected, atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("rpm", [-600, 100, 10])
def test_tip_is_the_motion_integrated_in_vectors(rpm: int) -> None:
    """The force on the tip of a free body, integrated from rest: three nutations and
    their mean.
    """
    told = asked(f"{PULL} {I_ZZ} --transverse '6.5e-3 kg m^2' --spin '{rpm} rpm'")
    force, rod = np.array([0.0, 0, -0.5]), np.array([1.0, 0, 0])

    def moves(_: float, state: np.ndarray) -> np.ndarray:
        axis, momentum = state[:3], state[3:6]
        velocity, aside = np.cross(momentum, axis) / 6.5e-3, np.cross(axis, force)
        sideways = 0.2 * velocity @ aside / np.linalg.norm(aside)
        return np.array(
            [
                *velocity,
                *np.cross(0.2 * axis, force),
                sideways,
                math.asin(max(-1, min(1, -axis[2]))),
            ]
        )

    time = 3 * 2 * math.pi / told["nutation_rate"]
    done = solve_ivp(
        moves,
        (0, time),
        [*rod, *(INERTIA * rpm * RPM * rod), 0, 0],
        rtol=1e-9,
        atol=1e-11,
    )
    speed, yields = np.abs(done.y[6:, -1]) / time
    assert (told["speed"], told["yields"]) == (
        pytest.approx(speed, rel=1e-5),
        pytest.approx(yields, rel=1e-5),
    )
    estimate = 0.02 / (INERTIA * abs(rpm) * RPM * speed) - 1
    assert told["estimate_error"] == pytest.approx(estimate, rel=1e-3, abs=1e-5)
    assert done.y[6, -1] * told["angle_deg"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("command", ["earth", "tip", "precession"])
def test_log_gives_the_numbers_that_no_option_gives(command: str) -> None:
    analysis, told = gyrodata.analyze(LOG), asked(f"{command} --log {LOG}")
    fastest = max(analysis.run_table, key=lambda run: run.spin)
    assert told["options"]["inertia"] == pytest.approx(
        analysis.inertia.value, rel=1e-11
    )
    assert told["options"]["spin"] == pytest.approx(fastest.spin, rel=1e-11)
    assert sum("from air_gyroscope.csv" in note for note in told["notes"]) >= 2
    own = asked(f"{command} --log {LOG} --inertia '5e-3 kg m^2' --spin 100rpm")
    assert own["options"]["inertia"] == pytest.approx(5e-3)
    assert not any("--inertia" in note or "--spin" in note for note in own["notes"])
    if command == "precession":
        assert told["options"]["torque"] == pytest.approx(fastest.torque, rel=1e-9)
        assert told["period"] == pytest.approx(fastest.period, rel=0.03)
        lighter = asked(f"precession --log {LOG} --mass 20g --position 15cm")["options"]
        assert lighter["torque"] == pytest.approx(0.02 * 0.15 * lighter["g"])


@pytest.mark.parametrize(
    "line",
    [
        "precession --spin 0rpm",
        "precession --mass 0g",
        "tip --spin 0rpm",
        "platform --wheel-spin 0rpm",
    ],
)
def test_reason_in_text_has_words_and_no_keys(line: str) -> None:
    shown = CliRunner().invoke(app, ["predict", *line.split()]).stdout
    assert "  no value " in shown
    assert "_" not in shown
    assert "0 rpm (0 rad/s) for steady" not in shown.replace("above 0", "")


@pytest.mark.parametrize("command", COMMANDS)
def test_command_without_options_names_the_values_it_assumes(command: str) -> None:
    assert "Not given, so assumed:" in gyro(command).stdout


def test_a_log_that_is_refused_is_refused_as_by_analyze(tmp_path: Path) -> None:
    text = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,56O,13.06,1/3\n"
    (tmp_path / "wrong.csv").write_text(text, encoding="utf-8")
    expected = CliRunner().invoke(
        app, ["analyze", str(tmp_path / "wrong.csv"), "--no-report"]
    )
    done = gyro(f"tip --log {tmp_path / 'wrong.csv'}")
    assert (done.exit_code, done.stderr, done.stdout) == (
        expected.exit_code,
        expected.stderr,
        "",
    )


@pytest.mark.slow
def test_a_doubtful_log_has_its_doubt_in_the_notes(tmp_path: Path) -> None:
    rows = [
        f"{m},15.0,{s},{19.84 * s**0.8 / m:.2f},1"
        for m in (20.0, 40.0, 60.0)
        for s in (200, 300, 400, 500, 600)
    ]
    log = tmp_path / "odd.csv"
    log.write_text(
        "mass [g],position [cm],spin [rpm],time [s],turns\n" + "\n".join(rows) + "\n",
        encoding="utf-8",
    )
    assert asked(f"tip --log {log}")["notes"][0].endswith(
        gyrodata.analyze(log).doubts[0].words
    )


@pytest.mark.parametrize(
    ("command", "code", "said"),
    [
        ("precession --transverse '1e-3 kg m^2'", "G622", "impossible for any body"),
        ("precession --mass=-60g", "G622", "must be zero or above"),
        ("precession --pitch 90deg", "G622", "must be below 90 degrees"),
        ("earth --hours 1e6", "G610", "less than or equal to 1000"),
    ],
)
def test_an_impossible_option_is_refused_with_its_remedy(
    command: str, code: str, said: str
) -> None:
    done = gyro(command)
    assert (done.exit_code, done.stdout) == (2, "")
    assert code in done.stderr
    assert said in done.stderr
