"""What the readings mean, and what each error is shared by."""

from __future__ import annotations

import numpy as np
import pytest

from gyrodata.measurements import SOURCES, Measurements, Source, measure, select, torque_groups
from gyrodata.readings import read_log
from gyrodata.simulation import TYPICAL

HEAD = "mass [g],position [cm],spin [rpm],time [s],turns\n"
ROWS = "20.00,15.0,206,7.06,1/3\n20.00,15.0,407,13.06,1/3\n40.0,15.0,401,6.6,1/3\n40.0,-15.0,401,6.6,1/3\n"


def measured(text: str, **settings: str) -> Measurements:
    readings = read_log(text.encode(), settings=settings)
    assert [d for d in readings.diagnostics if d.severity == "error"] == []
    return measure(readings)


def source(measurements: Measurements, name: str) -> Source:
    return next(s for s in measurements.sources if s.name == name)


def test_simulated_readings_err_as_readings_are_taken_to_err() -> None:
    for key, u in TYPICAL.items():
        # A position is read to its rounding, of which a simulated one has a millimetre's.
        assert key == "u_position" or u == SOURCES[key.removeprefix("u_")].default


def test_values_in_si() -> None:
    m = measured("# g: 9.803 m/s^2\n" + HEAD + ROWS)
    assert m.torque == pytest.approx([0.0294090, 0.0294090, 0.0588180, -0.0588180])
    assert m.spin[0] == pytest.approx(206 * np.pi / 30)
    assert m.turns == pytest.approx([1 / 3] * 4)
    assert m.sense.tolist() == [1, 1, 1, -1]
    assert m.product[3] < 0


def test_sharing_follows_from_equal_values() -> None:
    m = measured(HEAD + ROWS)
    assert source(m, "mass").groups == (0, 0, 1, 1)
    assert source(m, "position").groups == (0, 0, 0, 1)
    assert source(m, "position_zero").groups == (0, 0, 0, 0)
    assert source(m, "time").groups == (0, 1, 2, 3)
    assert source(m, "spin").groups == (0, 1, 2, 3), "a spin typed twice was read twice"


def test_a_spin_for_the_whole_log_is_one_reading() -> None:
    m = measured("mass [g],position [cm],time [s],turns\n20,15,7,1\n40,15,4,1\n", spin="400 rpm")
    assert source(m, "spin").groups == (0, 0)


def test_the_same_weight_in_another_unit_is_the_same_weight() -> None:
    m = measured("mass,position [cm],spin [rpm],time [s],turns\n20 g,15,400,39,1\n0.02 kg,15,200,20,1\n")
    assert source(m, "mass").groups == (0, 0)
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


def test_senses_tell_the_sign_of_an_unloaded_run() -> None:
    rows = "20.00,15.0,206,7.06,1/3,ccw\n0,,401,160.2,1/12,cw\n"
    m = measured(HEAD.strip() + ",precession_sense\n" + rows)
    assert m.sense.tolist() == [1, -1]
    swapped = measured(
        HEAD.strip() + ",precession_sense\n" + rows.replace("ccw", "x").replace("cw", "ccw").replace("x", "cw")
    )
    assert swapped.sense.tolist() == [1, -1]
    assert [d.code for d in swapped.diagnostics if d.severity == "warning"] == ["G402"]


def test_balance_tests_become_a_prior() -> None:
    drift = measured("# balance_drift: 5 deg in 60 s at 400 rpm\n" + HEAD + ROWS)
    assert drift.imbalance_u is not None
    assert drift.imbalance_u(4.44e-3) == pytest.approx(4.44e-3 * 400 * np.pi / 30 * np.radians(5) / 60)
    tilt = measured("# balance_tilt: 3 deg in 10 s\n# transverse_inertia: 0.006 kg*m^2\n" + HEAD + ROWS)
    assert tilt.imbalance_u is not None
    assert tilt.imbalance_u(4.44e-3) == pytest.approx(2 * 0.006 * np.radians(3) / 100)


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
    assert source(part, "position").groups == (0, 0)


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
    # One value only, perhaps that of a mean: it is not what each time has.
    assert time_error(head.replace("Ω", "x") + rows.replace("0.5,", ",").replace(",3\n", ",\n"))[0]
