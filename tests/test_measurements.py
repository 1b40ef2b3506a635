"""What the readings mean, and what each error is shared by."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from corners import CORNERS, blocks, told
from msgspec.structs import replace

import gyrodata
from gyrodata.errors import Diagnostic
from gyrodata.fitting import Model, fit
from gyrodata.measurements import SOURCES, Measurements, Source, measure, select, torque_groups
from gyrodata.procedure import check_log
from gyrodata.readings import UNCERTAINTIES, kind_of_role, read_log
from gyrodata.simulation import TYPICAL

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROWS = "20.00,15.0,206,7.06,1/3\n20.00,15.0,407,13.06,1/3\n40.0,15.0,401,6.6,1/3\n40.0,-15.0,401,6.6,1/3\n"


def measured(text: str, **settings: str) -> Measurements:
    readings = read_log(text.encode(), settings=settings)
    assert [d for d in readings.diagnostics if d.severity == "error"] == []
    return measure(readings)


def source(measurements: Measurements, name: str) -> Source:
    return next(s for s in measurements.sources if s.name == name)


MEASURED = {head: body for head, body in blocks(CORNERS.read_text(encoding="utf-8")) if head.startswith("measured")}


@pytest.mark.parametrize("head", MEASURED)
def test_what_is_measured_is_what_stands_beside_the_log(head: str) -> None:
    expected = "\n".join([f"== {head}", *MEASURED[head]]).rstrip()
    assert "\n".join(told(head, MEASURED[head])).rstrip() == expected, "if it is meant: python tests/make_expected.py"


def test_simulated_readings_err_as_readings_are_taken_to_err() -> None:
    for key, u in TYPICAL.items():
        # A position is read to its rounding, of which a simulated one has a millimetre's; turns are an angle.
        name = {"u_turns": "angle"}.get(key, key.removeprefix("u_"))
        assert key == "u_position" or u == SOURCES[name].default


def test_what_was_measured_stays_as_it_is() -> None:
    m = measured(HEAD + ROWS)
    with pytest.raises(AttributeError, match="immutable"):
        m.time = m.spin  # type: ignore[misc]


def test_values_in_si() -> None:
    m = measured("# g: 9.803 m/s^2\n" + HEAD + ROWS)
    assert m.torque == pytest.approx([0.0294090, 0.0294090, 0.0588180, -0.0588180])
    assert m.spin[0] == pytest.approx(206 * np.pi / 30)
    assert m.turns == pytest.approx([1 / 3] * 4)
    assert m.sense.tolist() == [1, 1, 1, -1]
    assert m.product[3] < 0


def test_sharing_follows_from_equal_values() -> None:
    m = measured(HEAD + ROWS)
    assert tuple(source(m, "mass").groups) == (0, 0, 1, 1)
    assert tuple(source(m, "position").groups) == (0, 0, 0, 1)
    assert tuple(source(m, "position_zero").groups) == (0, 0, 0, 0)
    assert tuple(source(m, "time").groups) == (0, 1, 2, 3)
    assert tuple(source(m, "spin").groups) == (0, 1, 2, 3), "a spin typed twice was read twice"


def test_a_spin_for_the_whole_log_is_one_reading() -> None:
    m = measured("mass [g],position [cm],time [s],turns\n20,15,7,1\n40,15,4,1\n", spin="400 rpm")
    assert tuple(source(m, "spin").groups) == (0, 0)


def test_an_error_is_shared_where_two_runs_have_it() -> None:
    m = measured(HEAD + ROWS.partition("40.0")[0])
    assert [(s.name, s.shared_count) for s in m.sources if s.shared] == [
        (name, 1) for name in ("spin_scale", "spin_delay", "mass", "mass_scale", "position", "position_zero", "g")
    ]


def test_the_same_weight_in_another_unit_is_the_same_weight() -> None:
    m = measured("mass,position [cm],spin [rpm],time [s],turns\n20 g,15,400,39,1\n0.02 kg,15,200,20,1\n")
    assert tuple(source(m, "mass").groups) == (0, 0)
    assert torque_groups(m) == [[0, 1]]


def test_defaults_carry_the_rounding_of_the_last_digit() -> None:
    m = measured("mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,206,7.1,1/3\n")
    assert source(m, "mass").relative[0] == pytest.approx(np.hypot(0.002, 1 / 12**0.5 / 20))
    assert source(m, "time").absolute[0] == pytest.approx(np.hypot(0.14, 0.1 / 12**0.5))
    assert source(m, "position").absolute[0] == pytest.approx(0.001 / 12**0.5)
    assert source(m, "spin").relative[0] == pytest.approx(np.hypot(0.002, 1 / 12**0.5 / 206))
    assert all(s.default for s in m.sources)


def test_what_is_stated_is_taken_as_stated() -> None:
    m = measured("# u_time: 0.3 s\n# u_mass: 1 %\n# u_position_zero: 2 mm\n# u_time_bias: 0.1 s\n" + HEAD + ROWS)
    assert source(m, "time").absolute.tolist() == [0.3] * 4
    assert source(m, "mass").relative.tolist() == [0.01] * 4
    assert source(m, "position_zero").absolute[0] == 0.002
    assert not source(m, "time").default
    assert m.timing_bias_u == 0.1


def test_an_uncertainty_says_in_words_where_it_is_from() -> None:
    m = measured("# u_time: 0.3 s\n# u_mass: 1 g\n# u_position_zero: 1 mm\n" + HEAD + ROWS)
    said = {s.name: s.described for s in m.sources}
    assert [said[name] for name in ("time", "mass", "position_zero")] == ["as given"] * 3
    assert (said["spin"], said["spin_scale"]) == ("0.2 % a reading and rounding", "0.1 %")


def test_the_uncertainty_of_the_period_serves_for_the_time() -> None:
    m = measured(HEAD.strip() + ",precession_period [s],u_precession_period [s]\n20,15,206,7.06,1/3,21.18,0.6\n")
    assert source(m, "time").absolute[0] == pytest.approx(0.2)
    assert not source(m, "time").default


def test_an_unloaded_run_has_no_weight_and_no_position() -> None:
    m = measured(HEAD + ROWS + "0,,401,160.2,1/12\n")
    assert m.position.tolist() == [0.15, 0.15, 0.15, -0.15, 0]
    bare = measured("mass [g],spin [rpm],time [s],turns\n0,401,160.2,1/12\n")
    assert (bare.position.tolist(), bare.torque.tolist()) == ([0], [0])
    assert "position" not in {s.name for s in bare.sources}
    assert m.torque[4] == 0
    assert m.sense[4] == 0
    assert source(m, "mass").groups[4] == -1


def test_start_and_end_give_the_harmonic_mean() -> None:
    m = measured("mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n20,15,440,400,39,1\n")
    mean = 440 * 400 * np.log(1.1) / 40
    assert m.spin[0] == pytest.approx(mean * np.pi / 30)
    reading = np.hypot(0.002, 1 / 12**0.5 / 420)
    assert source(m, "spin").relative[0] == pytest.approx(reading / 2**0.5, rel=0.01)


@pytest.mark.parametrize(
    ("header", "cells"),
    [
        ("spin [rpm]", "600"),
        ("spin [Hz]", "10"),
        ("spin [rad/s]", "62.83185307179586"),
        ("spin_period [s]", "0.1"),
    ],
)
def test_one_spin_in_four_units(header: str, cells: str) -> None:
    m = measured(f"mass [g],position [cm],{header},time [s],turns\n20,15,{cells},39,1\n")
    assert m.spin[0] == pytest.approx(20 * np.pi)


def test_force_and_torque_instead_of_a_mass() -> None:
    by_force = measured("force [N],position [cm],spin [rpm],time [s],turns\n0.2,15,400,39,1\n")
    assert by_force.torque[0] == pytest.approx(0.03)
    given = measured("torque [mN*m],spin [rpm],time [s],turns\n30,400,39,1\n")
    assert given.torque[0] == pytest.approx(0.03)
    assert {s.name for s in given.sources} == {"time", "spin", "spin_scale", "spin_delay", "torque"}


def test_a_period_or_a_rate_instead_of_time_and_turns() -> None:
    period = measured("mass [g],position [cm],spin [rpm],precession_period [s]\n20,15,400,39\n")
    assert (period.time[0], period.turns[0]) == (39, 1)
    rate = measured("mass [g],position [cm],spin [rpm],precession_rate [rad/s]\n20,15,400,0.16\n")
    assert rate.time[0] == pytest.approx(2 * np.pi / 0.16)
    assert rate.timing_bias_u == 0


def test_an_uncertainty_in_the_unit_of_a_rate_is_a_share_of_each() -> None:
    head = "mass [g],position [cm],spin [rpm],precession_rate [rad/s]\n20,15,400,0.16\n20,15,200,0.32\n"
    m = measured("# u_precession_rate: 0.016 rad/s\n# u_spin: 20 rpm\n" + head)
    assert source(m, "precession_rate").relative == pytest.approx([0.1, 0.05])
    assert source(m, "spin").relative == pytest.approx([0.05, 0.1])


def test_the_standard_free_fall_is_told_where_it_is_taken() -> None:
    def codes(line: str) -> list[str]:
        return [d.code for d in measured(line + HEAD + ROWS).diagnostics]

    assert codes("") == ["G404"]
    assert codes("# g: 9.81 m/s^2\n") == codes("# latitude: 45 deg\n") == []


def test_senses_tell_the_sign_of_an_unloaded_run() -> None:
    rows = "20.00,15.0,206,7.06,1/3,ccw\n0,,401,160.2,1/12,cw\n"
    m = measured(HEAD.strip() + ",precession_sense\n" + rows)
    assert m.sense.tolist() == [1, -1]
    swapped = measured(
        HEAD.strip() + ",precession_sense\n" + rows.replace("ccw", "x").replace("cw", "ccw").replace("x", "cw")
    )
    assert swapped.sense.tolist() == [1, -1]
    assert not [d.code for d in swapped.diagnostics if d.severity == "warning"], "the ball spins the other way"


def test_only_a_run_without_a_weight_needs_its_sense() -> None:
    loaded = "20.00,15.0,206,7.06,1/3\n40.00,15.0,206,3.55,1/3\n"
    assert measured(HEAD + loaded).sense.tolist() == [1, 1]
    assert measured(HEAD + loaded + "0,,401,160.2,1/12\n").sense.tolist() == [1, 1, 0]


def test_a_spin_with_a_sign_says_its_sense() -> None:
    head = "mass [g],position [cm],spin [rpm],time [s],turns,precession_sense\n"
    m = measured(
        head + "20,15,206,7.06,1/3,ccw\n20,-15,406,7.06,1/3,cw\n0,,-401,160.2,1/12,ccw\n0,,401,160.2,1/12,ccw\n"
    )
    assert m.sense.tolist() == [1, -1, -1, 1]
    assert (m.spin > 0).all()
    # A sense of the spin alone, and a sign of the spin alone, tell nothing of the torque.
    alone = measured(HEAD + "20,15,206,7.06,1/3\n20,15,-406,13.06,1/3\n0,,-401,160.2,1/12\n")
    assert alone.sense.tolist() == [1, 1, 0]


def test_senses_are_turned_where_most_of_them_contradict() -> None:
    def senses(*written: str) -> tuple[list[float], bool]:
        rows = "".join(f"20,15,206,7.06,1/3,{sense}\n" for sense in written)
        m = measured(HEAD.strip() + ",precession_sense\n" + rows + "0,,401,160.2,1/12,cw\n")
        return m.sense.tolist(), any(d.code == "G402" for d in m.diagnostics)

    assert senses("ccw", "cw", "cw") == ([-1, 1, 1, 1], True)
    assert senses("ccw", "cw") == ([1, -1, -1], False), "half of them is not most"
    assert senses("ccw", "ccw", "") == ([1, 1, 1, -1], False), "what is not written is as the torque makes it"


def test_more_precession_than_spin_is_asked_about_where_most_runs_have_it() -> None:
    slow, fast = "20,15,206,7.06,1/3\n", "20,15,2,7.06,1/3\n"

    def found(rows: str) -> list[tuple[int | None, str]]:
        return [(d.line, d.message) for d in measured(HEAD + rows).diagnostics if d.code == "G405"]

    assert found(slow + fast) == []
    assert found(slow + fast + fast) == [(3, 'the precession is faster than the spin ("spin [rpm]") in 2 of 3 runs')]
    # 2π/3 in 7.06 s are 2.833 rpm.
    assert len(found(fast.replace(",2,", ",2.83,"))) == 1
    assert found(fast.replace(",2,", ",2.84,")) == []


def test_balance_tests_become_a_prior() -> None:
    drift = measured("# balance_drift: 5 deg in 60 s at 400 rpm\n" + HEAD + ROWS)
    assert drift.imbalance_u is not None
    assert drift.imbalance_u(4.44e-3) == pytest.approx(4.44e-3 * 400 * np.pi / 30 * np.radians(5) / 60)
    tilt = measured("# balance_tilt: 3 deg in 10 s\n# transverse_inertia: 0.006 kg*m^2\n" + HEAD + ROWS)
    assert tilt.imbalance_u is not None
    assert tilt.imbalance_u(4.44e-3) == pytest.approx(2 * 0.006 * np.radians(3) / 100)


def test_a_balance_test_takes_a_ball_with_a_light_rod_where_the_log_does_not_say() -> None:
    tilt = measured("# balance_tilt: 3 deg in 10 s\n" + HEAD + ROWS)
    assert tilt.imbalance_u is not None
    assert tilt.imbalance_u(1.0) == pytest.approx(2 * 1.3 * np.radians(3) / 100)
    plain = measured(HEAD + ROWS)
    assert (plain.imbalance_u, plain.imbalance_from) == (None, "")


def test_defaults_are_what_their_words_say() -> None:
    size = {"%": 0.01, "s": 1.0, "mm": 1e-3, "°": np.radians(1), "": 1.0}
    for key, kind in SOURCES.items():
        said = re.match(r"(?:an exponent of 1 ± )?([0-9.]*) ?(%|s|mm|°|)", kind.usual)
        assert said is not None
        u = float(said[1] or 0) * size[said[2]]
        # Both ends of a turn's part are sighted, and it is counted in turns.
        expected = 2**0.5 * u / (2 * np.pi) if key == "angle" else u
        stated = (kind.default.absolute, kind.default.relative)
        assert stated == pytest.approx((0.0, expected) if said[2] == "%" else (expected, 0.0)), key


def test_runs_of_one_torque_stand_together() -> None:
    rows = "20,15,200,9.0,1\n0,,401,160,1\n40,7.5,200,9.0,1\n20,-15,200,9.0,1\n0,,402,161,1\n20,15,400,18.0,1\n"
    assert torque_groups(measured(HEAD + rows)) == [[0, 5], [1, 4], [2], [3]]
    senses = "".join(f"{row},{sense}\n" for row, sense in zip(rows.split(), ("ccw", "cw") * 3, strict=True))
    # Without a weight, M0 alone turns the rod: runs of both senses contradict each other.
    two = torque_groups(
        measured(HEAD.strip() + ",precession_sense\n" + senses.replace("402,161,1,ccw", "402,161,1,cw"))
    )
    assert [1, 4] in two
    assert [1] in torque_groups(measured(HEAD.strip() + ",precession_sense\n" + senses))
    force = "force [N],position [cm],spin [rpm],time [s],turns\n"
    assert torque_groups(measured(force + "0.2,15,200,9,1\n0.4,15,200,9,1\n0.2,15,400,9,1\n")) == [[0, 2], [1]]
    given = "torque [mN*m],spin [rpm],time [s],turns\n"
    assert torque_groups(measured(given + "30,200,9,1\n60,200,9,1\n30,400,9,1\n")) == [[0, 2], [1]]


def test_the_product_of_the_rates_has_the_sign_of_the_torque() -> None:
    m = measured(HEAD + ROWS + "0,,401,160.2,1/12\n")
    size = 2 * np.pi * np.array([1, 1, 1, 1, 0.25]) / 3 / m.time * m.spin
    assert m.product == pytest.approx(size * [1, 1, 1, -1, 1])


def test_what_a_run_has_alone_is_what_its_own_readings_err_by() -> None:
    m = measured("# u_time: 1 %\n# u_spin: 2 %\n# u_angle: 3.6 deg\n" + HEAD + ROWS)
    assert m.own_relative == pytest.approx([(0.01**2 + 0.02**2 + 0.03**2) ** 0.5] * 4)


def test_the_error_of_every_time_is_told_where_it_is_one() -> None:
    assert measured("# u_time: 0.3 s\n" + HEAD + ROWS.splitlines()[0] + "\n").time_u == 0.3
    assert measured("# u_time: 0.3 s\n" + HEAD + ROWS).time_u == 0.3
    assert measured("# u_time: 1 %\n" + HEAD + ROWS).time_u is None
    assert measured(HEAD + ROWS.replace("6.6,", "6.6 ± 0.2,")).time_u is None
    rate = "mass [g],position [cm],spin [rpm],precession_rate [rad/s]\n20,15,400,0.16\n"
    assert measured(rate).time_u is None


HIGH = "20.00,15.00,206.0,7.060,1/3"
DERIVED = {
    "precession_period [s]": 21.18, "precession_rate [rad/s]": 0.29666, "torque [N*m]": 0.0294200,
    "spin_period [s]": 0.291262, "inertia [kg*m^2]": 4.5972e-3,
}  # fmt: skip


@pytest.mark.parametrize("header", DERIVED)
def test_a_derived_column_may_be_off_by_a_twentieth(header: str) -> None:
    for factor, codes in ((0.951, []), (1.0, []), (1.049, []), (0.949, ["G401"]), (1.051, ["G401"])):
        m = measured(f"{HEAD.strip()},{header}\n{HIGH},{factor * DERIVED[header]:.8f}\n")
        assert [d.code for d in m.diagnostics if d.code != "G404"] == codes, factor


def test_a_derived_column_may_be_off_by_two_last_digits() -> None:
    for period, codes in (("18", []), ("22", []), ("17", ["G401"]), ("23", ["G401"])):
        m = measured(f"{HEAD.strip()},precession_period [s]\n20.00,15.00,206.0,20.000,1,{period}\n")
        assert [d.code for d in m.diagnostics if d.code == "G401"] == codes, period


def test_six_runs_that_disagree_are_named() -> None:
    def named(count: int) -> str:
        log = HEAD.strip() + ",precession_period [s]\n" + f"{HIGH},7.06\n" * count
        (found,) = [d for d in measured(log).diagnostics if d.code == "G401"]
        return found.message.partition("give in ")[2].partition(";")[0]

    assert named(1) == "run 1"
    assert named(6) == "runs 1, 2, 3, 4, 5, 6"
    assert named(7) == "runs 1, 2, 3, 4, 5, 6, …"


def test_a_reading_that_serves_several_runs_is_compared_once() -> None:
    log = (
        HEAD.strip() + ",torque [N*m]\n20.00,15.00,206,7.06,1/3,0.06\n,,407,13.06,1/3,\n40.00,15.00,206,3.5,1/3,0.06\n"
    )
    (found,) = [d for d in measured(log).diagnostics if d.code == "G401"]
    assert "in run 1;" in found.message


def test_a_derived_column_that_disagrees_is_named() -> None:
    m = measured(
        HEAD.strip() + ",precession period [s]\n20.00,15.0,206,7.06,1/3,21.2\n20.00,15.0,407,13.06,1/3,13.06\n"
    )
    (finding,) = [d for d in m.diagnostics if d.code == "G401"]
    assert (finding.line, finding.column) == (3, 26)
    assert "0.333 times" in finding.message


def test_select_keeps_what_is_shared() -> None:
    m = measured(HEAD + ROWS)
    part = select(m, [0, 2])
    assert part.runs == ("1", "3")
    assert tuple(source(part, "position").groups) == (0, 0)


def test_the_uncertainty_of_a_period_is_that_of_its_time():
    head = "mass [g],position [cm],spin [rpm],time [s],turns,T [s],σ_T [s],Ω [rad/s],u_precession_rate [%]\n"
    rows = "20,15,400,20,2,10,0.5,0.628,3\n20,15,600,60,4,15,1.5,0.419,3\n"

    def time_error(text):
        measured = measure(read_log(text))
        source = next(source for source in measured.sources if source.name == "time")
        return source.default, tuple((source.absolute + source.relative * measured.time).round(12))

    assert time_error(head + rows) == (False, (1.0, 6.0))
    assert time_error(head + rows.replace("0.5,", ",").replace("1.5,", ",")) == (False, (0.6, 1.8))
    assert time_error("# u_time: 0.2 s\n" + head + rows) == (False, (0.2, 0.2))
    rates = head.replace("[%]", "[rad/s]") + "20,15,400,20,2,10,,0.628,0.1\n20,15,600,60,4,15,,0.419,0.1\n"
    assert time_error(rates)[1] == pytest.approx((20 * 0.1 / (0.2 * np.pi), 60 * 0.1 / (2 * np.pi / 15)))
    # One value only, perhaps that of a mean: it is not what each time has.
    assert time_error(head.replace("Ω", "x") + rows.replace("0.5,", ",").replace(",3\n", ",\n"))[0]


class TestSighting:
    def test_only_a_part_of_a_turn_is_sighted(self) -> None:
        m = measured(HEAD + "20.0,15.0,206,7.06,1/3\n20.0,15.0,407,40.1,1\n")
        assert source(m, "angle").absolute == pytest.approx([2**0.5 / 360, 0.0])
        assert (tuple(source(m, "angle").groups), source(m, "angle").default) == ((0, 1), True)
        whole = measured(HEAD + "20.0,15.0,206,20.4,1\n20.0,15.0,407,81.0,2.00\n")
        assert "angle" not in {s.name for s in whole.sources}
        period = measured("mass [g],position [cm],spin [rpm],precession_period [s]\n20,15,400,39\n")
        assert "angle" not in {s.name for s in period.sources}

    @pytest.mark.parametrize(
        ("line", "header", "cell"),
        [
            ("# u_angle: 3 deg", "turns", "1/3"),
            ("# u_turns: 0.00833333333", "turns", "1/3"),
            ("# u_turns: 0.00833333333", "angle [deg]", "120"),
            ("", "turns,u_angle [deg]", "1/3,3"),
            ("", "angle [deg],u_turns", "120,0.00833333333"),
            ("# turns: 1/3", "u_angle [deg]", "3"),
            ("", "angle [deg]", "120 ± 3"),
        ],
    )
    def test_it_may_be_stated_for_turns_and_angle_alike(self, line: str, header: str, cell: str) -> None:
        m = measured(f"{line}\nmass [g],position [cm],spin [rpm],time [s],{header}\n20.0,15.0,206,7.06,{cell}\n")
        assert source(m, "angle").absolute == pytest.approx([3 / 360])
        assert not source(m, "angle").default
        assert m.diagnostics[1:] == ()

    def test_what_is_rounded_is_as_uncertain_as_its_rounding(self) -> None:
        rows = "20.0,15.0,206,7.06,0.33\n20.0,15.0,407,13.06,0.33\n20.0,15.0,407,26.1,0.67\n20.0,15.0,407,40.1,1\n"
        m = measured(HEAD + rows)
        rounded = 0.01 / 3**0.5
        own = np.hypot(2**0.5 / 360, rounded)
        angle = source(m, "angle")
        assert angle.absolute == pytest.approx([own, own, own, 0])
        assert (tuple(angle.groups), angle.shared_by) == ((0, 0, 1, 2), "runs with the same rounded turns")
        assert angle.described == "1° at each end of a part of a turn, and rounding"
        stated = source(measured(HEAD + rows.replace("0.67\n", "0.67 ± 0.02\n")), "angle")
        assert stated.absolute == pytest.approx([own, own, 0.02, 0])
        assert measured("mass [g],position [cm],spin [rpm],time [s],angle [deg]\n20,15,206,7.06,120\n").turns == [
            pytest.approx(1 / 3)
        ]


class TestTilt:
    LOG = (
        "mass [g],position [cm],spin [rpm],time [s],turns,pitch [deg]\n20,15,206,7.06,1/3,-20\n20,15,406,14.0,1/3,-20\n"
    )

    def test_the_pitch_of_each_run_and_i_of_the_rod_are_in_doubt(self) -> None:
        m = measured(self.LOG)
        assert source(m, "pitch").absolute == pytest.approx([np.radians(np.hypot(2, 1 / 12**0.5))] * 2)
        assert tuple(source(m, "pitch").groups) == (0, 1)
        assert (source(m, "transverse_inertia").relative.tolist(), tuple(source(m, "transverse_inertia").groups)) == (
            [0.2, 0.2], (0, 0)
        )  # fmt: skip
        assert source(m, "transverse_inertia").described == "20 %"
        released = measured("# motion: released\n" + HEAD + ROWS)
        assert [s.name for s in released.sources][-2:] == ["g", "transverse_inertia"]
        assert "transverse_inertia" not in {s.name for s in measured(HEAD + ROWS).sources}

    def test_i_that_is_given_is_better_known(self) -> None:
        def doubt(line: str, header: str = "", *cells: str) -> tuple[float, str]:
            rows = self.LOG.splitlines()
            log = "\n".join(
                row + cell for row, cell in zip(rows, (header, *cells) if header else ("",) * 3, strict=True)
            )
            found = source(measured(f"{line}\n{log}\n"), "transverse_inertia")
            return found.relative[1], found.described

        assert doubt("# transverse_inertia: 0.006 kg*m^2") == (0.02, "2 %")
        assert doubt("# transverse_inertia: 0.006 kg*m^2\n# u_transverse_inertia: 5 %") == (0.05, "as given")
        told = ",transverse_inertia [kg*m^2]", ",0.005 ± 0.0005", ",0.005 ± 0.0001"
        assert doubt("", *told) == (pytest.approx(0.1), "as given")


class TestTimedSpin:
    HEAD = "mass [g],position [cm],spin_time [s],spin_turns,time [s],turns\n"

    def test_it_is_as_good_as_the_stopwatch(self) -> None:
        m = measured(self.HEAD + "20,15,3.00,10,9.0,1\n40,15,1.50,20,9.0,1\n")
        assert m.spin == pytest.approx([20 * np.pi / 3, 80 * np.pi / 3])
        # A period's u is that of the time over its turns, the fewest of the log; the last digit is a hundredth of it.
        u = np.hypot([0.14 / 10 / 0.3, 0.14 / 10 / 0.075], 0.01 / 12**0.5 / np.array([3.0, 1.5]))
        assert source(m, "spin").relative == pytest.approx(u)
        assert source(m, "spin").usual == SOURCES["time"].usual

    def test_what_is_stated_of_it_and_of_its_count_is_taken(self) -> None:
        m = measured(
            "# u_spin_time: 0.3 s\n# u_spin_turns: 1\n" + self.HEAD + "20,15,3.00,10,9.0,1\n40,15,1.50,20,9.0,1\n"
        )
        assert source(m, "spin").relative == pytest.approx([np.hypot(0.1, 0.1), np.hypot(0.2, 0.05)])
        assert [d.code for d in m.diagnostics if d.code == "G406"] == []
        share = measured("# u_spin_time: 5 %\n" + self.HEAD + "20,15,3.00,10,9.0,1\n")
        assert source(share, "spin").relative == pytest.approx([0.05])


def test_what_is_added_to_every_position_makes_its_zero_less_certain() -> None:
    tip = "# position_from: tip\n# rod_length: 40 cm\n# u_rod_length: 2 mm\n# u_position_zero: 1.5 mm\n"
    m = measured(tip + HEAD + ROWS.replace("-15.0", "15.0"))
    assert source(m, "position_zero").absolute == pytest.approx([0.0025] * 4)
    assert source(m, "position").absolute == pytest.approx([0.001 / 12**0.5] * 4)


class TestFallingSpin:
    FALLING = "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n20,15,440,400,39,1\n"

    def test_a_spin_read_once_is_read_late(self) -> None:
        m = measured("# u_spin_delay: 3 s\n" + HEAD + ROWS)
        assert source(m, "spin_delay").relative == pytest.approx([0.01] * 4)
        assert tuple(source(m, "spin_delay").groups) == (0,) * 4

    def test_one_spin_for_the_whole_log_was_not_read_at_half_time(self) -> None:
        m = measured("mass [g],position [cm],time [s],turns\n20,15,7,1\n40,15,4,1\n", spin="400 rpm")
        assert "spin_delay" not in {s.name for s in m.sources}

    def test_it_may_rise_by_as_much_as_it_is_misread(self) -> None:
        def found(end: str) -> list[tuple[str, int | None]]:
            m = measured(self.FALLING.replace("440,400", f"400,{end}"))
            return [(d.code, d.column) for d in m.diagnostics if d.line == 2]

        assert found("407") == []
        assert found("409") == [("G403", 11)]
        thrice = self.FALLING.replace("spin_end", "spin [rpm],spin_end").replace("440,400", "400,405,409")
        assert [(d.code, d.column) for d in measured(thrice).diagnostics if d.line == 2] == [("G403", 15)]

    def test_a_mean_changes_with_its_readings_as_its_weights_say(self) -> None:
        thrice = "# u_spin_start: 3 %\n# u_spin: 4 %\n# u_spin_end: 5 %\n" + self.FALLING.replace(
            "spin_end", "spin [rpm],spin_end"
        ).replace("440,400", "480,430,380")
        m = measured(thrice)
        spins, u = np.array([480, 430, 380]), np.array([0.03, 0.04, 0.05])
        parts = np.array([1, 4, 1]) / spins
        assert m.spin[0] == pytest.approx(6 / parts.sum() * np.pi / 30)
        assert m.spin_readings == 3
        assert m.spin_start == pytest.approx([480 * np.pi / 30])
        assert m.spin_end == pytest.approx([380 * np.pi / 30])
        assert source(m, "spin").relative == pytest.approx([np.hypot.reduce(parts / parts.sum() * u)])
        twice = measured("# u_spin_start: 3 %\n# u_spin_end: 5 %\n" + self.FALLING)

        def mean(start: float, end: float) -> float:
            return start * end * np.log(start / end) / (start - end)

        slopes = [mean(440 * 1.0001, 400), mean(440, 400 * 1.0001)] / np.array(mean(440, 400)) - 1
        assert source(twice, "spin").relative == pytest.approx(
            [np.hypot.reduce(slopes / 1e-4 * [0.03, 0.05])], rel=1e-3
        )

    def test_the_law_is_in_doubt_where_start_and_end_are_read(self) -> None:
        m = measured("# u_decay_exponent: 1\n" + self.FALLING)
        assert source(m, "decay_exponent").relative == pytest.approx([np.log(1.1) ** 2 / 12], rel=1e-3)
        assert "spin_delay" not in {s.name for s in m.sources}
        thrice = self.FALLING.replace("spin_end", "spin [rpm],spin_end").replace("400,39", "419,400,39")
        assert "decay_exponent" not in {s.name for s in measured(thrice).sources}


class TestGravity:
    def test_what_is_known_of_it_goes_into_u(self) -> None:
        def doubt(line: str) -> tuple[float, float]:
            m = measured(line + HEAD + ROWS)
            return m.g, source(m, "g").relative[0]

        assert doubt("") == (9.80665, 0.001)
        assert doubt("# latitude: 45 deg\n") == (pytest.approx(9.8061978), 0.0001)
        assert doubt("# latitude: 90\n# g: 9.803 m/s^2\n") == (9.803, 0.0)
        assert doubt("# u_g: 1 %\n# latitude: 33.9 S\n")[1] == 0.01

    def test_the_latitude_is_kept(self) -> None:
        south = measured("# latitude: 33.9° S\n" + HEAD + ROWS)
        assert south.latitude == pytest.approx(-np.radians(33.9))
        assert [d.code for d in south.diagnostics] == []
        assert measured(HEAD + ROWS).latitude is None

    @pytest.mark.parametrize("text", ["91 deg", "-33 S", "north", "3 m"])
    def test_what_is_no_latitude_is_refused(self, text: str) -> None:
        found = read_log(f"# latitude: {text}\n{HEAD}{ROWS}".encode()).diagnostics
        assert [(d.code, d.line) for d in found] == [("G306", 1)]


class TestWeightSpinsAlong:
    LOG = "# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns,weight_diameter [cm]\n"
    SHAPE = LOG + "".join(
        f"{m},{x},{s},9.0,1,{d}\n" for m, x, d in ((200, 15, 6), (400, 15, 8), (300, -15, 6)) for s in (200, 400, 600)
    )

    def exact(self, inertia: float) -> Measurements:
        m = measured(self.SHAPE)
        whole = inertia + 0.5 * m.mass * np.repeat([0.03, 0.04, 0.03], 3) ** 2
        return replace(m, time=2 * np.pi * whole * m.spin / np.abs(m.torque))

    def test_i_zz_is_that_of_ball_and_rod(self) -> None:
        m = self.exact(4.44e-3)
        found = fit(m)
        assert found.inertia.value == pytest.approx(4.44e-3, rel=1e-6)
        assert found.fitted_time == pytest.approx(m.time, rel=1e-6)
        # What is left out makes it wrong by 2 %.
        assert fit(replace(m, added=0.0)).inertia.value > 4.52e-3

    def test_a_run_without_a_weight_has_nothing_added(self) -> None:
        m = measured(self.SHAPE + "0,,400,160,1/12,\n")
        assert m.added[-1] == 0  # type: ignore[index]

    def test_its_doubt_is_that_of_one_weight(self) -> None:
        m = measured("# u_weight_diameter: 10 %\n" + self.SHAPE)
        assert source(m, "weight_diameter").relative == pytest.approx([0.2] * 9)
        assert tuple(source(m, "weight_diameter").groups) == (0,) * 3 + (1,) * 3 + (0,) * 3
        assert source(m, "weight_diameter").described == "as given"
        assert "weight_diameter" not in {s.name for s in measured(self.SHAPE).sources}
        bare = source(measured("# u_weight_diameter: 10 %\n" + self.SHAPE + "0,,400,160,1/12,6\n"), "weight_diameter")
        assert (bare.groups[-1], bare.relative[-1]) == (-1, 0)
        some = measured(self.SHAPE.replace(",6\n", ",6 ± 0.6\n"))
        assert source(some, "weight_diameter").relative == pytest.approx([0.2] * 3 + [0] * 3 + [0.2] * 3)


class TestBalance:
    @pytest.mark.parametrize(("text", "meant"), [("yes", True), ("Ja", True), ("no", False), ("нет", False)])
    def test_the_log_may_say_that_the_ball_is_balanced(self, text: str, meant: bool) -> None:
        assert measured(f"# balanced: {text}\n{HEAD}{ROWS}").balanced is meant

    def test_what_is_neither_yes_nor_no_is_refused(self) -> None:
        (found,) = read_log(f"# balanced: roughly\n{HEAD}{ROWS}".encode()).diagnostics
        assert (found.code, found.line) == ("G306", 1)
        assert '"yes"' in found.hint

    def test_no_imbalance_at_all_is_obeyed(self) -> None:
        rows = "20.00,15.0,206,20.5,1\n20.00,15.0,407,40.5,1\n40.00,15.0,405,20.1,1\n60.00,15.0,404,13.4,1\n"
        free = gyrodata.analyze((HEAD + rows).encode())
        obeyed = gyrodata.analyze(f"# u_imbalance: 0 N*m\n{HEAD}{rows}".encode())
        assert (free.residual_torque.u or 0.0) > 1e-4
        assert (obeyed.residual_torque.u or 0.0) < 1e-7
        assert abs(obeyed.residual_torque.value) < 1e-7
        assert (obeyed.inertia.u or 0.0) < (free.inertia.u or 0.0)

    def test_a_line_left_blank_says_nothing(self) -> None:
        readings = read_log(f"# balanced:\n{HEAD}{ROWS}".encode())
        assert readings.diagnostics == ()
        assert readings.balanced is None

    @pytest.mark.parametrize("key", ["u_imbalance", "u_time_bias", "u_spin_delay"])
    def test_a_share_of_nothing_is_refused(self, key: str) -> None:
        (found,) = read_log(f"# {key}: 5 %\n{HEAD}{ROWS}".encode()).diagnostics
        assert (found.code, found.line) == ("G306", 1)


BALL = "# ball_mass: 4.1 kg\n# ball_diameter: 10.16 cm\n"
SHAPES = {
    "level": BALL + "# weight_diameter: 4 cm\n" + HEAD,
    "falling": "mass [g],position [cm],spin_start [rpm],spin_end [rpm],time [s],turns\n",
    "spin periods": "force [N],position [cm],spin_period_start [s],spin_period_end [s],time [s],angle [deg]\n",
    "spin period": "torque [mN*m],spin_period [s],precession_period [s]\n",
    "timed spins": "# position_from: tip\n# rod_length: 40 cm\n"
    "mass [g],position [cm],spin_time [s],spin_turns,time [s],turns\n",
    "rates": "torque [mN*m],spin [rpm],precession_rate [rad/s]\n",
    "tilted": "# transverse_inertia: 0.006 kg*m^2\n" + HEAD.strip() + ",pitch [deg]\n",
}
CELLS = {
    "mass": (40, 80, 60), "position": (15.0,) * 3, "torque": (58.8, 117.6, 88.2), "force": (0.392, 0.784, 0.588),
    "spin": (200, 400, 600), "spin_start": (230, 460, 690), "spin_end": (170, 340, 510),
    "spin_period": (0.3, 0.15, 0.1), "spin_period_start": (0.27, 0.135, 0.09), "spin_period_end": (0.33, 0.165, 0.11),
    "spin_time": (3.0, 1.5, 1.0), "spin_turns": (10,) * 3,
    "time": (3.31, 3.31, 6.62), "turns": ("1/3",) * 3, "angle": (120,) * 3, "precession_period": (9.94, 9.94, 19.87),
    "precession_rate": (0.632, 0.632, 0.316), "pitch": (40.0,) * 3, "transverse_inertia": (0.006,) * 3,
}  # fmt: skip
STATED = {"number": "0.3", "angle": "4 deg", "time": "0.01 s", "length": "2 mm", "torque": "3 mN*m"}
Look = Callable[[bytes], tuple[object, tuple[Diagnostic, ...]]]


def in_budget(log: bytes, model: Model) -> tuple[object, tuple[Diagnostic, ...]]:
    a = gyrodata.analyze(log, model=model)
    return ({share.source: round(share.u_inertia / a.inertia.value, 6) for share in a.budget}, a.ball), a.diagnostics


def in_sources(log: bytes) -> tuple[object, tuple[Diagnostic, ...]]:
    m = measure(read_log(log))
    sizes = {s.name: (s.absolute.round(9).tolist(), s.relative.round(9).tolist()) for s in m.sources}
    return (sizes, m.timing_bias_u, m.imbalance_u and m.imbalance_u(1.0)), m.diagnostics


def test_every_uncertainty_changes_the_budget_or_is_refused() -> None:
    heard = set()
    for name, shape in SHAPES.items():
        roles = [header.split(" ")[0] for header in shape.splitlines()[-1].split(",")]
        log = shape + "".join(",".join(str(CELLS[role][i]) for role in roles) + "\n" for i in range(3))
        # What a source is for I_zz, and what a tilt is, take an analysis to tell.
        look = {"level": partial(in_budget, model="auto"), "tilted": partial(in_budget, model="steady")}.get(
            name, in_sources
        )

        def told(line: str, log: str = log, look: Look = look) -> tuple[object, list[tuple[str, int | None]]]:
            what, diagnostics = look((line + log).encode())
            return what, [(d.code, d.line) for d in diagnostics if d.code == "G406"]

        silent, none = told("")
        assert none == []
        for key in UNCERTAINTIES:
            u = "3 %" if key.endswith("_scale") else STATED.get(kind_of_role(key), "4 %")
            changed, refused = told(f"# {key}: {u}\n")
            assert (changed == silent) == bool(refused), f"{key} in the log {name}"
            assert refused in ([], [("G406", 1)])
            heard |= set() if refused else {key}
    assert set(UNCERTAINTIES) - heard == {"u_inertia"}, "I_zz is what is to be found"


UNHEARD = [
    ("u_time_bias: 0.1 s", "torque [mN*m],spin [rpm],precession_rate [rad/s]", "rates are given, not times"),
    ("u_g: 1 %", "torque [mN*m],spin [rpm],time [s],turns", "the torque is given, and no mass"),
    ("u_mass_scale: 1 %", "force [N],position [cm],spin [rpm],time [s],turns", "the force is given, and no mass"),
    ("u_position_zero: 1 mm", "torque [mN*m],spin [rpm],time [s],turns", "no position is read"),
    ("u_spin_delay: 3 s", "torque [mN*m],spin_start [rpm],spin_end [rpm],time [s],turns", "more than once in each run"),
    ("u_spin_delay: 3 s", "torque [mN*m],time [s],turns", "one spin is given for the whole log"),
    ("u_decay_exponent: 1", "torque [mN*m],spin [rpm],time [s],turns", "not read at start and end alone"),
    ("u_ball_mass: 1 g", "torque [mN*m],spin [rpm],time [s],turns", "are not both given"),
    ("u_rod_length: 1 mm", "torque [mN*m],spin [rpm],time [s],turns", "counts from the tip of the rod"),
    ("u_turns: 0.01", "torque [mN*m],spin [rpm],precession_period [s]", "the precession period is given, and no angle"),
    ("u_mass: 1 g", "torque [mN*m],spin [rpm],time [s],turns", "there is no mass in this log"),
    ("u_spin_turns: 1", "torque [mN*m],spin [rpm],time [s],turns", "there is no spin_turns in this log"),
    ("u_transverse_inertia: 1 %", "torque [mN*m],spin [rpm],time [s],turns,transverse_inertia [kg*m^2]", "is level"),
    ("u_time: 1 s", "torque [mN*m],spin [rpm],precession_rate [rad/s]", "there is no time in this log"),
    ("u_inertia: 1 %", "torque [mN*m],spin [rpm],time [s],turns", "I_zz is what is to be found"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "head", "why"), UNHEARD)
def test_the_reason_why_an_uncertainty_changes_nothing_is_told(line: str, head: str, why: str) -> None:
    row = ",".join(str(CELLS[header.split(" ")[0]][0]) for header in head.split(","))
    m = measured(f"# {line}\n{head}\n{row}\n", **({} if "spin" in head else {"spin": "400 rpm"}))
    (found,) = [d for d in m.diagnostics if d.code == "G406"]
    assert found.message.startswith(line.partition(":")[0])
    assert why in found.message
    assert found.line == 1


def test_an_uncertainty_that_nothing_has_is_refused_where_it_stands() -> None:
    column = HEAD.strip() + ",u_pitch [deg]\n" + ROWS.replace("1/3\n", "1/3,2\n")
    (found,) = [d for d in read_log(column.encode()).diagnostics if d.code == "G220"]
    assert "there is no pitch" in found.message
    given = measured(HEAD + ROWS, u_pitch="1 deg")
    (refused,) = [d for d in given.diagnostics if d.code == "G406"]
    assert refused.line is None
    assert not any(d.code == "G406" for d in measured(HEAD + ROWS, u_pitch="0 deg").diagnostics), "so much is true"


@pytest.mark.parametrize("pitch", ["0", "0.1"])
@pytest.mark.parametrize("line", ["# u_pitch: 0.1 deg", "# u_transverse_inertia: 5 %"])
def test_an_uncertainty_of_a_tilt_that_is_left_out_is_refused(pitch: str, line: str) -> None:
    log = HEAD.strip() + ",pitch [deg]\n" + ROWS.replace("1/3\n", f"1/3,{pitch}\n")
    found = gyrodata.analyze(f"{line}\n# transverse_inertia: 0.006 kg*m^2\n{log}".encode()).diagnostics
    assert ("G406", 1) in {(d.code, d.line) for d in found}


ROUNDED = {"mass": ("0.02", "0.0200"), "position": ("15", "15.0")}


@pytest.mark.parametrize("role", ROUNDED)
def test_digits_that_decide_much_of_u_are_named_with_both_answers(role: str) -> None:
    short = "mass [kg],position [cm],spin [rpm],time [s],turns\n"
    for mass, spin, time in (("0.02", 206, 20.4), ("0.04", 405, 20.1), ("0.06", 404, 13.4)):
        short += f"{mass},15.0,{spin},{time},1\n"
    if role == "position":
        short = re.sub(r"(0\.0\d),15\.0", r"\g<1>00,15", short)
    before = gyrodata.analyze(short.encode())
    (found,) = [d for d in before.diagnostics if d.code == "G407"]
    text, longer = ROUNDED[role]
    assert (found.line, found.severity) == (2, "warning")
    assert found.message.startswith(f'{role} "{text}" is taken as anything from ')
    told = re.findall(r"\d\.\d\d ± \d\.\d\d", found.message)
    assert f"such as {longer}, or state" in found.hint
    stated = found.hint.partition("# ")[2]
    written = re.sub(r"(0\.0\d),", r"\g<1>00,", short) if role == "mass" else short.replace(",15,", ",15.0,")
    assert told[0] == f"{1e3 * before.inertia.value:.2f} ± {1e3 * (before.inertia.u or 0):.2f}"
    for log in (f"# {stated}\n{short}", written):
        after = gyrodata.analyze(log.encode())
        assert [d.code for d in after.diagnostics if d.code == "G407"] == []
        value, u = map(float, told[1].split(" ± "))
        assert 1e3 * after.inertia.value == pytest.approx(value, abs=0.5 * u)
        assert 1e3 * (after.inertia.u or 0) == pytest.approx(u, rel=0.25)
    assert [d.code for d in check_log(read_log(short.encode()))[1] if d.code == "G407"] == ["G407"]
