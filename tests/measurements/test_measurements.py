"""What the readings mean, how uncertain each is, and which errors runs share: seen in
the result and its budget.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from simulated_labs import analyze_briefly

import gyrodata
from gyrodata.judging.tables import compare_with_ball
from gyrodata.readings.roles import UNCERTAINTIES, kind_of_role

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROW = "20,15.0,206,7.1,1/3\n"
ROWS = (
    "20.00,15.0,206,7.06,1/3\n20.00,15.0,407,13.06,1/3\n40.0,15.0,401,6.6,1/3\n"
    "40.0,-15.0,401,6.6,1/3\n"
)
FALLING = (
    "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n"
    "20,15,440,400,39,1\n"
)
SIGHTED = "mass [g],position [cm],spin [rpm],time [s],"
TIMED = "mass [g],position [cm],spin_time [s],spin_turns,time [s],turns\n20,15,3.00,10,9.0,1\n"
RATE = "mass [g],position [cm],spin [rpm],precession_rate [rad/s]\n20,15,400,0.16\n"
PERIOD = "mass [g],position [cm],spin [rpm],precession_period [s]\n20,15,400,39\n"
UNDELAYED = "# u_spin_delay: 0 s\n"
DIGIT = 1 / 12**0.5
"""A last digit is uncertain by this share of its step."""
RPM = np.pi / 30


def result(log: str, **settings: str) -> dict[str, Any]:
    return gyrodata.analyze(log.encode(), settings=settings).to_dict()["result"]


def budget(log: str, **settings: str) -> dict[str, float]:
    """Relative uncertainty of I_zz from each source, if the tachometer, which every run
    shares, is good to 0.1 %.
    """
    text = f"# u_imbalance: 0 N*m\n{log}"
    found = analyze_briefly(text.encode(), settings=settings)
    told = {one.source: one.u_inertia for one in found.budget}
    return {name: 0.001 * u / told["spin_scale"] for name, u in told.items()}


def found(log: str, code: str, **settings: str) -> list[gyrodata.Diagnostic]:
    return [
        one
        for one in analyze_briefly(log.encode(), settings=settings).diagnostics
        if one.code == code
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("log", "field", "value"),
    [
        (UNDELAYED + TIMED, "spin", 20 * np.pi / 3),
        (FALLING, "spin", 440 * 400 * np.log(1.1) / 40 * RPM),
        ("# g: 9.803 m/s^2\n" + HEAD + ROW, "torque", 0.020 * 9.803 * 0.15),
        (
            "force [N],position [cm],spin [rpm],time [s],turns\n0.20,15.0,400,24,1\n",
            "torque",
            0.03,
        ),
        (PERIOD, "time", 39.0),
        (RATE, "precession_rate", 0.16),
    ],
)
def test_reading_in_any_form_has_its_si_value(
    log: str, field: str, value: float
) -> None:
    assert result(log)["runs"][0][field] == pytest.approx(value)


SURFACE = "# position_from: surface\n# ball_diameter: 10 cm\n"
# The spin falls by 1/e in 1000 s, within a factor of 2.
LATE = math.exp(math.log(2) ** 2) / 1000
# Read 2 s ± 1.7 s late, and corrected for 2 s: the factor of 2 is then an error of the
# correction.
LATE_BY_2_S = (
    math.sqrt(
        1.7**2 * 4 ** math.log(2)
        + 4 * (4 ** math.log(2) - 2 * 2 ** (math.log(2) / 2) + 1)
    )
    / 1000
)
TIP = "# position_from: tip\n# rod_length: 30 cm\n# u_rod_length: 1 mm\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("log", "shares"),
    [
        # What is not stated has the default of its kind and the rounding of its last
        # digit.
        (
            HEAD + ROW,
            {
                "time": math.hypot(0.14, 0.1 * DIGIT) / 7.1,
                "mass": math.hypot(0.002, DIGIT / 20),
                "mass_scale": 0.0005,
                "position": 0.1 * DIGIT / 15,
                "position_zero": 0.1 / 15,
                "spin": math.hypot(0.002, DIGIT / 206),
                "spin_scale": 0.001,
                "spin_delay": LATE_BY_2_S,
                "g": 0.001,
                "angle": 3 * 2**0.5 / 360,
            },
        ),
        (
            (
                "# u_time: 0.3 s\n# u_mass: 1 %\n# u_position_zero: 2 mm\n# "
                "u_time_bias: 0.1 s\n# u_spin_delay: 3 s\n"
            )
            + HEAD
            + ROW,
            {
                "time": 0.3 / 7.1,
                "mass": 0.01,
                "position_zero": 0.2 / 15,
                "spin_delay": 3 * LATE,
            },
        ),
        # Gravity is known better from a latitude, and given is exact.
        ("# latitude: 45 deg\n" + HEAD + ROW, {"g": 0.0001}),
        ("# u_g: 1 %\n# latitude: -33.9 deg\n" + HEAD + ROW, {"g": 0.01}),
        # A period or a rate has its own uncertainty, which serves for the time beside
        # it.
        (
            SIGHTED
            + "turns,precession_period [s],u_precession_period [s]\n20,15,206,7.06,1/3,21.18,0.6\n",
            {"time": 0.2 / 7.06},
        ),
        (
            "# u_precession_rate: 0.016 rad/s\n# u_spin: 20 rpm\n" + RATE,
            {"precession_rate": 0.1, "spin": 0.05, "time_bias": None, "angle": None},
        ),
        ("# u_angle: 3 deg\n" + HEAD + ROW, {"angle": 3 * 3 * 2**0.5 / 360}),
        (SIGHTED + "angle [deg]\n20.0,15.0,206,7.06,120 ± 3\n", {"angle": 3 * 3 / 360}),
        (
            HEAD + ROW.replace("1/3", "0.33"),
            {"angle": 2**0.5 / 360 / 0.33, "rounded_turns": 0.01 / 3**0.5 / 0.33},
        ),
        (
            HEAD.replace("turns", "turns [%]") + ROW.replace("1/3", "33.3"),
            {"angle": 2**0.5 / 360 / 0.333, "rounded_turns": 0.001 / 3**0.5 / 0.333},
        ),
        # A typed fraction is no rounded one.
        (HEAD + ROW.replace("1/3", "1/5"), {"rounded_turns": None}),
        (
            HEAD + ROW.replace("1/3", "0.3333333"),
            {"angle": 3 * 2**0.5 / 360, "rounded_turns": None},
        ),
        # A spin read more than once, timed, or given for the whole log.
        (
            FALLING,
            {"spin": math.hypot(0.002, DIGIT / 420) / 2**0.5, "spin_delay": None},
        ),
        (
            "# u_decay_exponent: 1\n" + FALLING,
            {"decay_exponent": np.log(1.1) ** 2 / 12},
        ),
        (TIMED, {"spin": math.hypot(0.14 / 10 / 0.3, 0.01 * DIGIT / 3)}),
        (
            "# u_spin_time: 0.03 s\n# u_spin_turns: 0.1\n" + TIMED,
            {"spin": math.hypot(0.01, 0.01)},
        ),
        # What is added to a position makes its zero less certain.
        (
            SURFACE + HEAD + ROW.replace("15.0", "10.0"),
            {"position_zero": math.hypot(0.1, 0.5 * DIGIT) / 15},
        ),
        (TIP + HEAD + ROW, {"position_zero": math.hypot(0.1, 0.1) / 15}),
        # A force or a torque instead of a mass.
        (
            "torque [mN*m],spin [rpm],time [s],turns\n30,400,39,1\n",
            {
                "mass": None,
                "position": None,
                "position_zero": None,
                "g": None,
                "torque": math.hypot(0.005, DIGIT / 30),
            },
        ),
    ],
)
def test_each_source_of_error_has_its_size(
    log: str, shares: dict[str, float | None]
) -> None:
    told = budget(log)
    assert {name: told.get(name) for name in shares} == {
        name: share and pytest.approx(share, rel=2e-3) for name, share in shares.items()
    }


@pytest.mark.slow
def test_a_spin_read_once_is_read_late() -> None:
    # A spin-down shows the decay time: 100 s.
    down = budget(
        "# spin_down: 412 rpm to 151.6 rpm in 100 s\n"
        + HEAD
        + ROW.replace("206", "250")
    )
    assert down["spin_delay"] == pytest.approx(0.017, rel=0.01)


def delayed(*lines: str) -> dict[str, Any]:
    lines = ("# balance: untouched", *lines)
    return result("".join(f"{line}\n" for line in lines) + HEAD + ROWS)


@pytest.mark.slow
@pytest.mark.parametrize("lines", [(), ("# u_time: 0.2 s",)])
def test_a_late_reading_is_corrected_as_by_the_usual_spin_down(
    lines: tuple[str, ...],
) -> None:
    silent, at_the_middle = delayed(*lines), delayed(*lines, "# u_spin_delay: 0 s")
    # The usual fall is by 1/e in 1000 s.
    stated = delayed(*lines, "# spin_down: 600 rpm to 532.152 rpm in 120 s")
    value, u = silent["inertia"]["value"], silent["inertia"]["u"]
    assert value == pytest.approx(stated["inertia"]["value"], abs=0.05 * u)
    assert at_the_middle["inertia"]["value"] / value == pytest.approx(
        math.exp(2 / 1000), abs=2e-4
    )
    assert u > stated["inertia"]["u"] > at_the_middle["inertia"]["u"]
    effect, without = (
        {row["effect"]: row for row in each["effects"]}.get("spin_delay")
        for each in (silent, at_the_middle)
    )
    assert (effect["kept"], effect["in_u"], without) == (True, True, None)
    assert effect["bias"] == pytest.approx(math.expm1(2 / 1000), rel=1e-3)


@pytest.mark.slow
def test_a_delay_that_is_stated_is_not_late_on_average() -> None:
    exact = delayed("# u_spin_delay: 0 s")["inertia"]
    for line in (
        "# u_spin_delay: 1.7 s",
        "# spin_down: 600 rpm to 500 rpm in 100 s\n# u_spin_delay: 0 s",
    ):
        assert delayed(line)["inertia"]["value"] == pytest.approx(
            exact["value"], rel=2e-4
        )


@pytest.mark.slow
def test_a_spin_that_was_read_before_the_run_is_corrected_for_half_of_its_time() -> (
    None
):
    row = "20.0,15.0,400,40.0,1\n"
    heads = HEAD, HEAD.replace("spin [rpm]", "spin before [rpm]")
    at_the_middle, before = (
        result(f"# u_spin_delay: 0 s\n{head}{row}") for head in heads
    )
    # The spin in the middle was lower, and so I_zz is larger. What was read is shown as
    # it was read.
    ratio = before["inertia"]["value"] / at_the_middle["inertia"]["value"]
    assert ratio == pytest.approx(math.exp(20 / 1000), rel=2e-3)
    assert before["runs"][0]["spin"] == pytest.approx(400 * RPM, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "decimals", [("0.3333333", "0.6666667"), ("0.333333", "0.666667")]
)
def test_a_fraction_with_many_decimals_is_the_fraction(
    decimals: tuple[str, str],
) -> None:
    rows = ROWS.replace("13.06,1/3", "26.12,2/3")
    fraction = result(HEAD + rows)["inertia"]
    decimal = result(
        HEAD + rows.replace("1/3", decimals[0]).replace("2/3", decimals[1])
    )["inertia"]
    assert decimal["value"] == pytest.approx(fraction["value"], rel=2e-6)
    assert decimal["u"] == pytest.approx(fraction["u"], rel=1e-4)


@pytest.mark.slow
def test_rounding_is_shared_and_sighting_is_of_each_run() -> None:
    def shared(turns: str) -> dict[str, bool]:
        return {
            one["source"]: one["shared"]
            for one in result(HEAD + ROWS.replace("1/3", turns))["budget"]
        }

    assert shared("0.33").items() >= {"angle": False, "rounded_turns": True}.items()
    assert "rounded_turns" not in shared("1/3")


@pytest.mark.slow
def test_only_the_spin_of_a_log_without_u_spin_delay_is_corrected() -> None:
    def inertia(line: str) -> dict[str, Any]:
        # The spin falls by 1/e in 100 s.
        down = "# spin_down: 412 rpm to 151.566 rpm in 100 s\n# balanced: yes\n"
        return result(f"{down}{line}{HEAD}20.0,15.0,250,7.1,1/3\n")["inertia"]

    silent, exact, vague = map(
        inertia, ("", "# u_spin_delay: 0 s\n", "# u_spin_delay: 3 s\n")
    )
    assert exact["value"] / silent["value"] == pytest.approx(
        math.exp(2 / 100), rel=1e-3
    )
    assert vague["value"] == pytest.approx(exact["value"], rel=1e-3)
    assert vague["u"] > silent["u"] > exact["u"]


@pytest.mark.slow
def test_only_a_part_of_a_turn_is_sighted() -> None:
    assert budget(HEAD + ROW)["angle"] == pytest.approx(3 * 2**0.5 / 360)
    assert "angle" not in budget(HEAD + ROW.replace("1/3", "2.00"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("second", "source", "shared"),
    [
        ("20,15,400,23.1,1", "mass", True),
        (",15,400,23.1,1", "mass", True),
        ("20.1,15,400,23.1,1", "mass", False),
        ("20,15.1,400,23.1,1", "position", False),
        # A spin that is typed twice was read twice, and one for the whole log was read
        # once.
        ("20,15,400,23.1,1", "spin", False),
        ("20,15,,23.1,1\n20,15,,23.1,1", "spin", True),
        ("20,15,400,23.1,1", "time", False),
    ],
)
def test_equal_values_share_their_error(second: str, source: str, shared: bool) -> None:
    share = budget(f"# u_{source}: 1 %\n{HEAD}20,15,400,23.1,1\n{second}\n")[source]
    assert share == pytest.approx(0.01, rel=1e-3) if shared else share < 0.008


@pytest.mark.slow
def test_report_says_where_an_uncertainty_is_from() -> None:
    told = result(
        "# weight_diameter: 4 ± 0.1 cm\n" + HEAD + ROWS.replace("1/3", "0.33")
    )["uncertainties"]
    assert {one["source"]: one["text"] for one in told}.items() >= {
        "spin": "0.2 % a reading and rounding",
        "angle": "1° at each end of a part of a turn",
        "rounded_turns": "rounding",
        "weight_diameter": "as given",
    }.items()


@pytest.mark.slow
def test_only_a_run_without_a_weight_needs_its_sense() -> None:
    assert not found(HEAD + ROWS, "G402")
    log = (
        HEAD.strip()
        + ",precession_sense\n"
        + ROWS.replace("1/3\n", "1/3,\n")
        + "0,,{},160.2,1/12,{}\n"
    )
    signs = [
        result(log.format(*last))["residual_torque"]["value"] > 0
        for last in ((401, "ccw"), (401, "cw"), (-401, "ccw"))
    ]
    assert signs == [True, False, False]


@pytest.mark.slow
def test_balance_test_limits_m0_by_its_torque() -> None:
    def width(line: str, inertia: str = "0.006") -> float:
        log = (
            f"# {line}\n# transverse_inertia: {inertia} kg*m^2\n"
            f"{HEAD}20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n"
        )
        return result(log)["residual_torque"]["u"]

    drift, tilt = (
        width("balance_drift: 5 deg in 60 s at 400 rpm"),
        width("balance_tilt: 3 deg in 10 s"),
    )
    assert tilt < 0.7 * drift < 0.5 * width("station: 1")
    # I_zz times the spin times the drift's rate; twice I times the tilt over the square
    # of its time.
    assert width("balance_drift: 10 deg in 60 s at 200 rpm") == pytest.approx(
        drift, rel=1e-6
    )
    assert width("balance_tilt: 12 deg in 20 s") == pytest.approx(tilt, rel=1e-6)
    assert width("balance_tilt: 1.5 deg in 10 s", "0.012") == pytest.approx(
        tilt, rel=1e-6
    )


@pytest.mark.slow
def test_balanced_line_is_obeyed_and_no_imbalance_narrows_u() -> None:
    rows = (
        "20.00,15.0,206,20.5,1\n20.00,15.0,407,40.5,1\n40.00,15.0,405,20.1,1\n"
        "60.00,15.0,404,13.4,1\n"
    )
    free, obeyed = (
        result(f"{line}{HEAD}{rows}") for line in ("", "# u_imbalance: 0 N*m\n")
    )
    assert free["residual_torque"]["u"] > 1e-4
    assert obeyed["residual_torque"]["u"] < 1e-7
    assert obeyed["inertia"]["u"] < free["inertia"]["u"]
    for words, meant in (("yes", True), ("нет", False), ("", None)):
        assert (
            gyrodata.read_log(f"# balanced: {words}\n{HEAD}{rows}".encode()).balanced
            is meant
        )


HIGH = "20.00,15.00,206.0,7.060,1/3"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("header", "value"),
    [
        ("precession_period [s]", 21.18),
        ("torque [N*m]", 0.0294200),
        ("inertia [kg*m^2]", 4.5972e-3),
    ],
)
def test_derived_column_that_is_a_tenth_off_is_named(header: str, value: float) -> None:
    log = f"{HEAD.strip()},{header}\n{HIGH},{{:.8f}}\n"
    assert [
        bool(found(log.format(factor * value), "G401")) for factor in (0.9, 1.0, 1.1)
    ] == [True, False, True]


REPEATED = "mass [g],position [cm],spin [rpm],turns,t1 [s],t2 [s],t3 [s],mean t [s]\n"


def repeated(seed: int, factor: float = 1.0) -> str:
    """Write short times that scatter, with their mean times a factor in row 3."""
    random = np.random.default_rng(seed)
    rows = [REPEATED]
    for number in range(1, 7):
        times = np.round(1.4 * number**0.5 + random.normal(0, 0.15, 3), 2)
        mean = times.mean() * (factor if number == 3 else 1)
        cells = ",".join([f"{time:.2f}" for time in (*times, mean)])
        rows.append(f"60.3,14.0,{200 * number**0.5:.0f},1/3,{cells}\n")
    return "".join(rows)


@pytest.mark.slow
def test_mean_of_repeated_times_is_compared_with_their_mean() -> None:
    for seed in range(8):
        assert not found(repeated(seed), "G401")
        (warning,) = found(repeated(seed, 3.0), "G401")
        assert warning.message.startswith('"mean t [s]" is 3')
        assert "from the readings in line 4;" in warning.message


@pytest.mark.slow
@pytest.mark.parametrize(
    ("log", "code", "line", "words"),
    [
        (
            HEAD.strip()
            + (
                ",precession period [s]\n20.00,15.0,206,7.06,1/3,21.2\n"
                "20.00,15.0,407,13.06,1/3,13.06\n"
            ),
            "G401",
            3,
            "0.333 times",
        ),
        (
            HEAD.strip()
            + ",precession_sense\n20,15,206,7.06,1/3,ccw\n"
            + "20,15,206,7.06,1/3,cw\n" * 2
            + "0,,401,160.2,1/12,cw\n",
            "G402",
            None,
            "most written directions are opposite",
        ),
        (
            FALLING.replace("440,400", "400,409"),
            "G403",
            2,
            "the spin rises by 2 % while",
        ),
        (
            FALLING.replace("440,400", "500,550"),
            "G403",
            2,
            "the spin rises by 10 % while",
        ),
    ],
)
def test_readings_that_contradict_each_other_are_named(
    log: str, code: str, line: int | None, words: str
) -> None:
    try:
        diagnostics = analyze_briefly(log.encode()).diagnostics
    except gyrodata.LogError as error:
        diagnostics = error.diagnostics
    told = [one for one in diagnostics if one.code == code]
    assert [one.line for one in told] == [line]
    assert words in told[0].message


@pytest.mark.slow
def test_i_zz_is_that_of_ball_and_rod() -> None:
    head = "# g: 9.803 m/s^2\n# motion: steady\n# u_spin_delay: 0 s\n"
    head += "mass [g],position [cm],spin [rpm],time [s],turns,weight_diameter [cm]\n"
    rows = []
    for mass, position, diameter in ((200, 15, 6), (400, 15, 8), (300, -15, 6)):
        whole = 4.44e-3 + 0.5 * mass * 1e-3 * (diameter / 200) ** 2
        torque = mass * 1e-5 * 9.803 * 15
        for spin in (200, 400, 600):
            time = 2 * np.pi * whole * spin * RPM / torque
            rows.append(f"{mass},{position},{spin},{time:.8f},1,{diameter}\n")
    log = head + "".join(rows)
    assert result(log)["inertia"]["value"] == pytest.approx(4.44e-3, rel=1e-5)
    # What is left out makes it wrong by 2 %.
    assert (
        result(re.sub(",weight_diameter.*|,[68]$", "", log, flags=re.MULTILINE))[
            "inertia"
        ]["value"]
        > 4.52e-3
    )


BALL = "# ball_mass: 4.1 kg\n# ball_diameter: 10.16 cm\n"
SHAPES = {
    "level": BALL + "# weight_diameter: 4 cm\n" + HEAD,
    "set again": "# position_set: each run\n" + HEAD,
    "falling": "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n",
    "spin periods": (
        "force [N],position [cm],spin_period_start [s],spin_period_end [s],time "
        "[s],angle [deg]\n"
    ),
    "spin period": "torque [mN*m],spin_period [s],precession_period [s]\n",
    "timed spins": "# position_from: tip\n# rod_length: 40 cm\n"
    "mass [g],position [cm],spin_time [s],spin_turns,time [s],turns\n",
    "rates": "torque [mN*m],spin [rpm],precession_rate [rad/s]\n",
    "tilted": "# transverse_inertia: 0.006 kg*m^2\n" + HEAD.strip() + ",pitch [deg]\n",
    "nutating": HEAD.strip() + ",pitch [deg],nutation_period [s]\n",
}
CELLS = {
    "mass": (40, 80, 60),
    "position": (15.0,) * 3,
    "torque": (58.8, 117.6, 88.2),
    "force": (0.392, 0.784, 0.588),
    "spin": (200, 400, 600),
    "spin_start": (230, 460, 690),
    "spin_end": (170, 340, 510),
    "spin_period": (0.3, 0.15, 0.1),
    "spin_period_start": (0.27, 0.135, 0.09),
    "spin_period_end": (0.33, 0.165, 0.11),
    "spin_time": (3.0, 1.5, 1.0),
    "spin_turns": (10,) * 3,
    "time": (3.31, 3.31, 6.62),
    "turns": ("1/3",) * 3,
    "angle": (120,) * 3,
    "precession_period": (9.94, 9.94, 19.87),
    "precession_rate": (0.632, 0.632, 0.316),
    "pitch": (40.0,) * 3,
    "transverse_inertia": (0.006,) * 3,
    "nutation_period": (0.4, 0.2, 0.13),
}
STATED = {
    "number": "0.03",
    "angle": "0.4 deg",
    "time": "2 ms",
    "length": "0.2 mm",
    "torque": "0.3 mN*m",
}


@pytest.mark.slow
def test_every_uncertainty_changes_the_budget_or_is_refused() -> None:
    heard = set()
    for name, shape in SHAPES.items():
        roles = [header.split(" ")[0] for header in shape.splitlines()[-1].split(",")]
        log = shape + "".join(
            ",".join(str(CELLS[role][i]) for role in roles) + "\n" for i in range(3)
        )

        def told(
            keys: Iterable[str], log: str = log, name: str = name
        ) -> tuple[object, set[str]]:
            """Give the budget if these are stated, and those that are said to change
            nothing.
            """
            keys = list(keys)
            us = (
                "0.3 %"
                if key.endswith("_scale")
                else STATED.get(kind_of_role(key), "0.4 %")
                for key in keys
            )
            lines = "".join(f"# {key}: {u}\n" for key, u in zip(keys, us, strict=True))
            a = analyze_briefly((lines + log).encode(), "steady")
            ball = compare_with_ball(
                a.fit.inertia, a.readings.constants, a.readings.uncertainties
            )
            shares = {
                one.source: round(one.u_inertia / a.inertia.value, 9)
                for one in a.budget
            }
            return (shares, ball), {
                keys[one.line - 1]
                for one in a.diagnostics
                if one.code == "G406" and one.line
            }

        silent = told([])
        # One may be refused only because another one is stated as well.
        _, refused = told(told(UNCERTAINTIES)[1])
        assert told(refused) == (silent[0], refused), name
        for key in set(UNCERTAINTIES) - refused:
            changed, none = told([key])
            assert (changed != silent[0], none) == (True, set()), (
                f"{key} in the log {name}"
            )
            heard.add(key)
    assert set(UNCERTAINTIES) - heard == {"u_inertia"}, "I_zz is the result"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "head", "why"),
    [
        (
            "u_g: 1 %",
            "torque [mN*m],spin [rpm],time [s],turns",
            "the torque is given, and no mass",
        ),
        (
            "u_spin_delay: 3 s",
            "torque [mN*m],time [s],turns",
            "one spin is given for the whole log",
        ),
        (
            "u_inertia: 1 %",
            "torque [mN*m],spin [rpm],time [s],turns",
            "I_zz is the result",
        ),
    ],
)
def test_reason_why_an_uncertainty_changes_nothing_is_said(
    line: str, head: str, why: str
) -> None:
    row = ",".join(str(CELLS[header.split(" ")[0]][0]) for header in head.split(","))
    (told,) = found(
        f"# {line}\n{head}\n{row}\n",
        "G406",
        **({} if "spin" in head else {"spin": "400 rpm"}),
    )
    assert told.message.startswith(line.partition(":")[0])
    assert (why in told.message, told.line) == (True, 1)


@pytest.mark.slow
def test_digits_that_decide_u_are_named_with_u_before_and_after() -> None:
    full = "mass [kg],position [cm],spin [rpm],time [s],turns\n"
    full += "0.0200,15.0,206,20.4,1\n0.0400,15.0,405,20.1,1\n0.0600,15.0,404,13.4,1\n"
    short = full.replace("15.0", "15")
    before = gyrodata.analyze(short.encode())
    (named,) = [d for d in before.diagnostics if d.code == "G407"]
    assert (named.line, named.severity) == (2, "warning")
    assert named.message.startswith('position "15" can mean any value from ')
    assert (
        "such as 15.0 (in a spreadsheet, by a number format that shows it), or state"
        in named.hint
    )
    then, now = map(float, re.findall(r"([\d.]+) %", named.message)[-2:])
    assert now == pytest.approx(100 * (before.inertia.relative_u or 0), rel=0.05)
    for log in (f"# {named.hint.partition('# ')[2]}\n{short}", full):
        after = gyrodata.analyze(log.encode())
        assert [d.code for d in after.diagnostics if d.code == "G407"] == []
        assert abs(after.inertia.value - before.inertia.value) < (before.inertia.u or 0)
        assert 100 * (after.inertia.relative_u or 0) == pytest.approx(then, rel=0.25)


@pytest.mark.slow
def test_torque_is_used_if_a_mass_has_no_position() -> None:
    rows = "10.1,0.0161,703,119.9,1\n20.0,0.0318,500,43.13,1\n50.3,0.0799,605,20.6,1\n"
    lab = gyrodata.analyze(
        f"mass [g],torque [N*m],spin [rpm],time [s],turns\n{rows}".encode()
    )
    assert lab.inertia.value == pytest.approx(4.15e-3, rel=0.02)
