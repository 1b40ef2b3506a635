"""`gyro predict`: numbers against published ones, texts, the contract of keys, and what is refused."""

from __future__ import annotations

import json
import math
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any, NoReturn

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from gyrodata import fitting, physics
from gyrodata.cli import app
from gyrodata.prediction import predict_precession

RPM = math.pi / 30
TOP = '--inertia "4.44e-3 kg m^2" --transverse "7.1e-3 kg m^2"'
WEIGHT = '--mass 60g --position 15cm --g "9.8031 m/s^2"'
TORQUE = 0.06 * 0.15 * 9.8031


def gyro(command: str) -> Result:
    return CliRunner().invoke(app, ["predict", *shlex.split(command)], prog_name="gyro")


def asked(command: str) -> dict[str, Any]:
    def refuse(constant: str) -> NoReturn:
        raise AssertionError(f"{constant} in JSON")

    done = gyro(f"{command} --format json")
    assert done.exit_code == 0, done.output
    document: dict[str, Any] = json.loads(done.stdout, parse_constant=refuse)
    return document


class TestPrecession:
    def test_both_roots_and_the_level_rod(self) -> None:
        told = asked(f"precession {TOP} {WEIGHT} --spin 400rpm --pitch 10deg")
        with mpmath.workdps(30):
            a = (mpmath.mpf(4.44e-3) - mpmath.mpf(7.1e-3)) * mpmath.sin(mpmath.radians(10))
            b = mpmath.mpf(4.44e-3) * 400 * mpmath.pi / 30
            root = mpmath.sqrt(b * b + 4 * a * TORQUE)
        assert told["slow"] == pytest.approx(float((-b + root) / (2 * a)), rel=1e-14)
        assert told["fast"] == pytest.approx(float((-b - root) / (2 * a)), rel=1e-14)
        assert told["horizontal"] == pytest.approx(TORQUE / float(b), rel=1e-14)
        assert told["period"] == pytest.approx(2 * math.pi / told["slow"], rel=1e-15)
        assert told["exists"] is True
        assert told["reason"] == ""

    def test_the_contract(self) -> None:
        told = asked(f"precession {TOP} {WEIGHT} --spin 400rpm --pitch 10deg")
        envelope = ["schema", "tool", "prediction", "options", "notes"]
        own = ["slow", "fast", "horizontal", "exists", "critical_spin", "period", "reason", "released", "sleeping"]
        assert list(told) == envelope + own
        assert told["schema"] == "gyro.prediction/1"
        assert told["tool"]["name"] == "gyrodata"
        assert told["prediction"] == "precession"
        released = {"mean_rate", "sag", "greatest_sag", "nutation_rate", "click_error_s", "reason"}
        assert set(told["released"]) == released
        assert set(told["sleeping"]) == {"stable", "critical_spin", "growth_rate"}
        assert told["options"] == {
            "inertia": pytest.approx(4.44e-3),
            "spin": pytest.approx(400 * RPM),
            "pitch": pytest.approx(math.radians(10)),
            "torque": pytest.approx(TORQUE),
            "mass": pytest.approx(0.06),
            "position": pytest.approx(0.15),
            "g": pytest.approx(9.8031),
            "transverse_inertia": pytest.approx(7.1e-3),
        }

    def test_below_the_least_spin_it_is_null_and_says_what_would_do(self) -> None:
        told = asked(f"precession {TOP} {WEIGHT} --spin 50rpm --pitch 60deg")
        assert (told["slow"], told["fast"], told["period"], told["exists"]) == (None, None, None, False)
        # The least spin of 60 g at 60°, the weight in I, is 61 rpm.
        assert told["critical_spin"] / RPM == pytest.approx(61, abs=0.5)
        assert "61.3" in told["reason"]
        assert told["horizontal"] == pytest.approx(TORQUE / (4.44e-3 * 50 * RPM))
        above = f"precession {TOP} {WEIGHT} --spin '{told['critical_spin'] * 1.001} rad/s' --pitch 60deg"
        assert asked(above)["exists"] is True

    def test_a_level_rod_has_one_root(self) -> None:
        told = asked(f"precession {TOP} --torque '0.0588 N*m' --spin '-400 rpm'")
        assert told["fast"] is None
        assert "level" in told["reason"]
        assert told["slow"] == told["horizontal"] == pytest.approx(-0.0588 / (4.44e-3 * 400 * RPM))
        assert told["critical_spin"] == 0

    def test_equal_inertias_have_one_root(self) -> None:
        same = "--inertia '4e-3 kg m^2' --transverse '4e-3 kg m^2'"
        told = asked(f"precession {same} --torque '0.05 N*m' --spin 300rpm --pitch 20deg")
        assert told["fast"] is None
        assert "I = I_zz" in told["reason"]

    def test_no_torque(self) -> None:
        told = asked(f"precession {TOP} --mass 0g --position 15cm --spin 400rpm --pitch -10deg")
        assert (told["slow"], told["horizontal"], told["period"], told["exists"]) == (0, 0, None, True)
        assert "period: without a torque" in told["reason"]
        assert told["released"]["mean_rate"] == 0

    def test_no_spin(self) -> None:
        level = asked(f"precession {TOP} {WEIGHT} --spin 0rpm")
        assert (level["slow"], level["horizontal"], level["exists"]) == (None, None, False)
        assert "without spin" in level["reason"]
        assert level["released"]["mean_rate"] is None
        assert level["released"]["greatest_sag"] == pytest.approx(math.pi / 2)
        hanging = asked(f"precession {TOP} {WEIGHT} --spin 0rpm --pitch -30deg")
        assert hanging["slow"] == pytest.approx(-hanging["fast"])  # a conical pendulum
        assert hanging["slow"] == pytest.approx(math.sqrt(TORQUE / ((7.1e-3 - 4.44e-3) * 0.5)))

    def test_let_go_from_rest(self) -> None:
        # 60 g, 200 rpm: 1.02 % slower than steady in the mean; a click up to 0.076 s off.
        told = asked(f"precession {TOP} {WEIGHT} --spin 200rpm")
        released = told["released"]
        assert told["horizontal"] / released["mean_rate"] - 1 == pytest.approx(0.0102, abs=1e-4)
        delta = 7.1e-3 * TORQUE / (4.44e-3 * 200 * RPM) ** 2
        assert released["sag"] == pytest.approx(delta, rel=1e-12)
        assert released["greatest_sag"] == pytest.approx(2 * delta, rel=0.03)
        assert released["nutation_rate"] == pytest.approx(4.44e-3 * 200 * RPM / 7.1e-3, rel=1e-12)
        assert released["click_error_s"] == pytest.approx(1 / released["nutation_rate"], rel=1e-12)
        assert released["reason"] == ""

    def test_let_go_with_little_spin(self) -> None:
        released = asked(f"precession {TOP} {WEIGHT} --spin 50rpm")["released"]
        assert (released["sag"], released["nutation_rate"], released["click_error_s"]) == (None, None, None)
        assert "falls too far" in released["reason"]
        assert released["mean_rate"] > 0
        assert 0.9 < released["greatest_sag"] < math.pi / 2

    @pytest.mark.parametrize(("grams", "rpm"), [(20, 56), (40, 79), (60, 97)])
    def test_sleeping(self, grams: float, rpm: float) -> None:
        top = f"--inertia '4.44e-3 kg m^2' --transverse '5.74e-3 kg m^2' --mass {grams}g --position 15cm"
        above, below = (asked(f"precession {top} --spin '{rpm + d} rpm'")["sleeping"] for d in (1, -1))
        assert above["critical_spin"] / RPM == pytest.approx(rpm, abs=0.5)
        assert (above["stable"], below["stable"]) == (True, False)
        assert above["growth_rate"] == 0 < below["growth_rate"]

    def test_a_weight_below_needs_no_spin_to_stay(self) -> None:
        sleeping = asked(f"precession {TOP} --mass 60g --position -15cm --spin 0rpm --pitch 10deg")["sleeping"]
        assert sleeping == {"stable": True, "critical_spin": 0, "growth_rate": 0}

    def test_what_is_taken_by_default_is_said(self) -> None:
        told = asked("precession --inertia '4.44e-3 kg m^2' --mass 60g --position 15cm --spin 400rpm")
        across = fitting.DEFAULT_TRANSVERSE_RATIO * 4.44e-3 + 0.06 * 0.15**2
        assert told["options"]["transverse_inertia"] == pytest.approx(across)
        assert told["options"]["g"] == physics.STANDARD_GRAVITY
        assert [note.split(" =")[0] for note in told["notes"]] == ["g", "I"]
        bare = asked("precession --inertia '4.44e-3 kg m^2' --torque '0.05 N*m' --spin 400rpm")
        assert bare["options"]["transverse_inertia"] == pytest.approx(1.3 * 4.44e-3)
        assert bare["options"]["g"] is None
        assert asked(f"precession {TOP} {WEIGHT} --spin 400rpm")["notes"] == []

    def test_units_are_those_of_a_log(self) -> None:
        one = asked(f"precession {TOP} --torque '0.0588 N*m' --spin '10 Hz' --pitch '0.1 rad'")
        two = asked(f"precession {TOP} --torque '58.8 mN·m' --spin '600 rpm' --pitch '5.729577951308232 deg'")
        assert one["slow"] == pytest.approx(two["slow"], rel=1e-14)
        assert one["options"]["spin"] == pytest.approx(20 * math.pi)

    # The first example loads scipy.
    @settings(max_examples=60, deadline=None)
    @given(
        st.sampled_from([0.0, 1.0, -1.0]), st.floats(-5, 3), st.sampled_from([0.0, 1.0, -1.0]), st.floats(-3, 4),
        st.floats(-9, 3), st.sampled_from([0.5, 1.0, 1.3, 40.0]), st.floats(-1.57, 1.57),
    )  # fmt: skip
    def test_never_not_a_number(
        self, side: float, load: float, sense: float, speed: float, size: float, shape: float, pitch: float
    ) -> None:
        inertia = 10**size
        numbers = side * 10**load, sense * 10**speed, inertia, shape * inertia, pitch
        told = predict_precession(*numbers)
        json.dumps(told, allow_nan=False)
        assert told["exists"] is (told["slow"] is not None)
        for part in (told, told["released"]):
            lacking = {name for name, value in part.items() if value is None}
            assert all(name in part["reason"] for name in lacking)

    def test_text(self) -> None:
        done = gyro("precession --inertia '4.44e-3 kg m^2' --mass 60g --position 15cm --spin 400rpm --pitch 10deg")
        assert done.exit_code == 0
        assert done.stdout == PRECESSION
        assert done.stderr == ""

    def test_text_without_a_root(self) -> None:
        lines = gyro(f"precession {TOP} {WEIGHT} --spin 50rpm --pitch 60deg").stdout.splitlines()
        assert lines[2] == "  least spin      61.32 rpm (6.422 rad/s) for steady precession at this pitch"
        assert lines[3].startswith("  no slow, fast, period: no steady precession at this pitch below the least spin")
        assert not re.search(r"nan|None|inf\b", "\n".join(lines))


PRECESSION = """\
steady precession at pitch 10°, spin 400 rpm (41.89 rad/s), torque 0.08826 N*m
  slow, eq. (8)   4.537 rpm (0.4751 rad/s), one turn in 13.22 s
  fast, eq. (8)   3809 rpm (398.9 rad/s)
  level, eq. (9)  4.532 rpm (0.4746 rad/s)
  least spin      27.58 rpm (2.888 rad/s) for steady precession at this pitch

let go from rest
  mean rate       4.543 rpm (0.4758 rad/s)
  sags by         1.03° (0.0179 rad) on average, 2.07° (0.0361 rad) at most
  nutates at      249.4 rpm (26.11 rad/s)
  click error     up to 0.038 s, by the phase of the nutation

rod upright, at this spin
  stays           a small tilt does not grow
  least spin      107.8 rpm (11.29 rad/s) to stay

taken by default:
  g = 9.80665 m/s^2
  I = 1.3 I_zz + m x^2 = 0.007122 kg*m^2 (--transverse)
"""


class TestEarth:
    def test_six_sidereal_hours(self) -> None:
        for hours in ("6 --step 2 --sidereal", "5.9836", "5.9836 --step 5.9836"):
            told = asked(f"earth --latitude 42.5deg --hours {hours}")
            east, north = told["east"][-1], told["north"][-1]
            assert east["sidereal_hours"] == pytest.approx(6, abs=1e-4)
            assert (east["azimuth_deg"], east["altitude_deg"]) == pytest.approx((180, 47.5), abs=0.01)
            assert (north["azimuth_deg"], north["altitude_deg"]) == pytest.approx((0, 42.5), abs=1e-9)

    def test_the_contract(self) -> None:
        told = asked("earth --latitude 42.5deg")
        assert told["options"] == {"latitude": pytest.approx(math.radians(42.5)), "hours": 24.0, "sidereal": False}
        assert told["sidereal_day_hours"] == pytest.approx(23.9345, abs=1e-4)
        for name in ("north", "east"):
            rows = told[name]
            assert [row["hours"] for row in rows] == [float(hour) for hour in range(25)]
            assert set(rows[0]) == {"hours", "sidereal_hours", "azimuth_deg", "altitude_deg", "reason"}
        # In 24 hours of the clock the Earth turns by nearly a degree too much.
        assert told["east"][-1]["altitude_deg"] == pytest.approx(0.73, abs=0.01)
        assert told["east"][0] == {
            "hours": 0, "sidereal_hours": 0, "azimuth_deg": pytest.approx(90), "altitude_deg": pytest.approx(0),
            "reason": "",
        }  # fmt: skip

    def test_the_last_row_is_the_last_hour(self) -> None:
        told = asked("earth --latitude 10deg --hours 2.5 --step 1")
        assert [row["hours"] for row in told["east"]] == [0, 1, 2, 2.5]
        thirds = asked("earth --latitude 10deg --hours 0.3 --step 0.1")
        assert [row["hours"] for row in thirds["east"]] == pytest.approx([0, 0.1, 0.2, 0.3])

    def test_overhead_there_is_no_azimuth(self) -> None:
        row = asked("earth --latitude 0deg --hours 6 --step 6 --sidereal")["east"][-1]
        assert row["azimuth_deg"] is None
        assert row["altitude_deg"] == pytest.approx(90)
        assert "straight up" in row["reason"]
        assert " - " in gyro("earth --latitude 0deg --hours 6 --step 6 --sidereal").stdout

    def test_at_the_pole_and_in_the_south(self) -> None:
        pole = asked("earth --latitude 90deg --hours 6 --sidereal")
        assert {row["azimuth_deg"] for row in pole["north"]} == {None}
        assert pole["east"][-1]["azimuth_deg"] == pytest.approx(180)
        assert pole["east"][-1]["altitude_deg"] == pytest.approx(0, abs=1e-9)
        south = asked("earth --latitude -42.5deg --hours 6 --sidereal")["east"][-1]
        assert south["azimuth_deg"] % 360 == pytest.approx(0, abs=1e-9)
        assert south["altitude_deg"] == pytest.approx(47.5)

    def test_text(self) -> None:
        assert gyro("earth --latitude 42.5deg --hours 24 --step 6 --sidereal").stdout == EARTH

    def test_the_figure(self, tmp_path: Path) -> None:
        for folder in ("a", "b/c"):
            done = gyro(f"earth --latitude 42.5deg --out {shlex.quote(str(tmp_path / folder))}")
            assert done.exit_code == 0
            assert done.stdout.startswith("balanced gyroscopes")
        first, second = (tmp_path / folder / "earth.png" for folder in ("a", "b/c"))
        assert first.read_bytes() == second.read_bytes()
        assert first.read_bytes().startswith(b"\x89PNG")

    def test_nothing_is_written_unasked(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        gyro("earth --latitude 42.5deg")
        assert list(tmp_path.iterdir()) == []

    @pytest.mark.parametrize("latitude", [42.5, -33.9, 90.0])
    @pytest.mark.parametrize("hours", [0.1, 500.0])
    def test_the_figure_shows_the_numbers_and_its_text_stays_inside(self, latitude: float, hours: float) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.text import Text

        from gyrodata.plotting import draw_earth

        times = np.linspace(0, 3600 * hours, 9)
        figure = draw_earth(math.radians(latitude), times)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        upper = figure.axes[0]
        expected = physics.balanced_direction(math.pi / 2, 0.0, math.radians(latitude), times)[1]
        dots = next(line for line in reversed(upper.get_lines()) if len(np.asarray(line.get_xdata())) == 9)
        np.testing.assert_allclose(np.asarray(dots.get_ydata()), np.degrees(expected))
        width, height = canvas.get_width_height()
        for text in figure.findobj(Text):
            if isinstance(text, Text) and text.get_text() and text.get_visible():
                box = text.get_window_extent(canvas.get_renderer())
                assert 0 <= box.x0 <= box.x1 <= width, text.get_text()
                assert 0 <= box.y0 <= box.y1 <= height, text.get_text()


EARTH = """\
balanced gyroscopes at latitude 42.5°, from the ground, which turns under them
  north: started along the Earth's axis; east: started level. Azimuth is from north through east.

     hours  sidereal   north: azimuth  altitude   east: azimuth  altitude
    0.0000    0.0000            0.00°    42.50°          90.00°     0.00°
    5.9836    6.0000            0.00°    42.50°         180.00°    47.50°
   11.9672   12.0000            0.00°    42.50°         270.00°     0.00°
   17.9509   18.0000            0.00°    42.50°           0.00°   -47.50°
   23.9345   24.0000            0.00°    42.50°          90.00°     0.00°
"""

WHEEL = "--wheel-inertia '0.1 kg m^2' --wheel-spin 200rpm --platform-inertia '4 kg m^2'"


class TestPlatform:
    def test_from_level_to_upright(self) -> None:
        told = asked(f"platform {WHEEL} --from 0deg --to 90deg")
        assert told["rate"] == pytest.approx(-0.1 * 200 * RPM / 4, rel=1e-14)
        assert told["period"] == pytest.approx(12)
        assert told["options"]["from"] == 0
        own = ["rate", "period", "momentum_before", "momentum_after", "momentum_platform", "reason"]
        assert list(told)[5:] == own

    def test_the_angular_momentum_stays(self) -> None:
        told = asked(f"platform {WHEEL} --from 70deg --to -20deg")
        assert told["momentum_after"] + told["momentum_platform"] == pytest.approx(told["momentum_before"], rel=1e-14)

    def test_nothing_happens_without_spin_or_without_a_turn(self) -> None:
        for command in (f"platform {WHEEL} --from 30deg --to 30deg", f"platform {WHEEL.replace('200', '0')}"):
            told = asked(command)
            assert (told["rate"], told["period"]) == (0, None)
            assert "at rest" in told["reason"]
            assert "stays at rest" in gyro(command).stdout

    def test_text(self) -> None:
        assert gyro(f"platform {WHEEL}").stdout == PLATFORM
        assert "in that of the wheel" in gyro(f"platform {WHEEL} --from 90deg --to 0deg").stdout


PLATFORM = """\
axle tipped from 0° to 90° above the horizontal, the platform at rest before
  platform        5 rpm (0.5236 rad/s), one turn in 12 s
  sense           against that of the wheel when its axle points up

angular momentum about the vertical, which stays the same [kg*m^2/s]
  before          wheel 0
  after           wheel 2.094, platform -2.094
"""


class TestTip:
    def test_the_closed_form(self) -> None:
        told = asked("tip --force 0.5N --length 20cm --inertia '4.44e-3 kg m^2' --spin 400rpm")
        assert told["speed"] == pytest.approx(0.5 * 0.2**2 / (4.44e-3 * 400 * RPM), rel=1e-14)
        assert told["turning_rate"] == pytest.approx(told["speed"] / 0.2)
        assert told["torque"] == pytest.approx(0.1)
        assert told["angle_deg"] == pytest.approx(90)
        assert "along the torque" in told["direction"]
        assert list(told)[5:] == ["speed", "turning_rate", "torque", "angle_deg", "direction"]

    def test_the_other_sense(self) -> None:
        told = asked("tip --force 0.5N --length 20cm --inertia '4.44e-3 kg m^2' --spin '-400 rpm'")
        assert told["angle_deg"] == pytest.approx(-90)
        assert told["speed"] > 0

    def test_text(self) -> None:
        assert gyro("tip --force 0.5N --length 20cm --inertia '4.44e-3 kg m^2' --spin 400rpm").stdout == TIP


TIP = """\
a force of 0.5 N across the rod, 20 cm from the centre
  tip             10.75 cm/s (0.1075 m/s)
  direction       along the torque: across the force, a quarter turn ahead of it in the sense of the spin
  rod turns at    5.135 rpm (0.5377 rad/s)
  torque          0.1 N*m
"""

I_ZZ = "--inertia '4.44e-3 kg m^2'"
PULL = "tip --force 0.5N --length 20cm"


@pytest.mark.parametrize(
    ("command", "code", "said"),
    [
        (f"precession {I_ZZ} --spin 400 --torque '0.05 N*m'", "G621", 'write --spin "400 rpm"'),
        ("precession --inertia 4.44e-3 --spin 400rpm --torque '0.05 N*m'", "G621", 'write --inertia "4.44e-3 kg*m^2"'),
        (f"precession {I_ZZ} --spin 400rpm --mass 60 --position 15cm", "G621", 'write --mass "60 g"'),
        (f"precession {I_ZZ} --spin 400rpm --mass 60g --position 15", "G621", 'write --position "15 cm"'),
        (f"precession {I_ZZ} --spin 400rpm --torque 0.05", "G621", 'write --torque "0.05 N*m"'),
        (f"precession {I_ZZ} --spin 400rpm --torque '0.05 N*m' --pitch -10", "G621", 'write --pitch "-10 deg"'),
        (f"precession {I_ZZ} --spin 400kg --torque '0.05 N*m'", "G621", '--spin: "kg" is no unit of a rotation rate'),
        (f"precession {I_ZZ} --spin '40 1/s' --torque '0.05 N*m'", "G621", "revolutions or radians"),
        (f"precession {I_ZZ} --spin nan --torque '0.05 N*m'", "G621", "not a number with a unit"),
        (f"precession {I_ZZ} --spin inf --torque '0.05 N*m'", "G621", "not a number with a unit"),
        (f"precession {I_ZZ} --spin 1e400rpm --torque '0.05 N*m'", "G621", "no finite number"),
        (f"precession {I_ZZ} --spin 1e300rpm --torque '0.05 N*m'", "G622", "too large for a rotation rate"),
        (f"precession {I_ZZ} --spin 1e-300rpm --torque '0.05 N*m'", "G622", "too small for a rotation rate"),
        (f"precession {I_ZZ} --spin 400rpm --torque '0.05 N*m' --pitch 90deg", "G622", "between -90 and 90 degrees"),
        (f"precession {I_ZZ} --spin 400rpm --mass -60g --position 15cm", "G622", "has a negative --position"),
        (f"precession {I_ZZ} --spin 400rpm --mass 60g --position 15cm --g '-9.8 m/s^2'", "G622", "is below zero"),
        (f"precession {I_ZZ} --transverse '1e-3 kg m^2' --spin 400rpm --torque '0.05 N*m'", "G622", "no body has"),
        (f"precession {I_ZZ} --spin 400rpm", "G623", "give --torque, or --mass and --position"),
        (f"precession {I_ZZ} --spin 400rpm --mass 60g", "G623", "--position is not given"),
        (f"precession {I_ZZ} --spin 400rpm --position 15cm", "G623", "--mass is not given"),
        (f"precession {I_ZZ} --spin 400rpm --torque '0.05 N*m' --mass 60g", "G623", "given twice"),
        (f"{PULL} --inertia '-4.44e-3 kg m^2' --spin 400rpm", "G622", "a moment of inertia above zero is needed"),
        (f"{PULL} --inertia '0 kg m^2' --spin 400rpm", "G622", "is zero"),
        (f"{PULL} {I_ZZ} --spin 0rpm", "G622", "a rotation rate other than zero is needed"),
        (f"tip --force -1N --length 20cm {I_ZZ} --spin 400rpm", "G622", "a force above zero is needed"),
        (f"platform {WHEEL.replace('4 kg', '0 kg')}", "G622", "is zero"),
        ("earth --latitude 42.5", "G621", 'write --latitude "42.5 deg"'),
        ("earth --latitude 91deg", "G622", "between -90 and 90 degrees"),
        ("earth --latitude 42.5deg --hours soon", "G621", "write it like --hours 24"),
        ("earth --latitude 42.5deg --hours nan", "G622", "above zero"),
        ("earth --latitude 42.5deg --hours -3", "G622", "above zero"),
        ("earth --latitude 42.5deg --step 0", "G622", "above zero"),
        ("earth --latitude 42.5deg --hours 1e6 --step 1e-6", "G622", "give a longer --step"),
        ("earth --latitude 42.5deg --out /dev/null", "G603", "cannot be written"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(command: str, code: str, said: str) -> None:
    done = gyro(command)
    assert done.exit_code == 2
    assert done.stdout == ""
    assert code in done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("command", ["precession", "earth", "platform", "tip"])
def test_the_example_in_the_help_runs(command: str) -> None:
    text = gyro(f"{command} --help").stdout
    example = " ".join(text.partition("Example:")[2].replace("\\\n", " ").split())
    assert example.startswith(f"gyro predict {command}")
    done = gyro(example.removeprefix("gyro predict "))
    assert (done.exit_code, done.stderr) == (0, "")


@pytest.mark.parametrize("arguments", [["predict", "--help"], ["predict", "earth", "--help"]])
def test_help_loads_nothing_heavy(arguments: list[str]) -> None:
    code = (
        "import sys\n"
        f"sys.argv = ['gyro', *{arguments!r}]\n"
        "from gyrodata.__main__ import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print(sorted({'numpy', 'pandas', 'scipy', 'pint', 'matplotlib'} & set(sys.modules)), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "Usage" in done.stdout
    assert done.stderr.strip() == "[]"
