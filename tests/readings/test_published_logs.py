"""Layouts of published student tables, shortened to the rows that show how they are written."""

import math
import re

import pytest
from columns import of, shared

from gyrodata.readings import Uncertainty, read_log


def codes(readings):
    return {diagnostic.code for diagnostic in readings.diagnostics}


def test_stacked_timings_with_merged_cells():
    readings = read_log(
        '"Mass, m (kg)","Radius,r (m)","Couple,M (Nm)","Spin Speed,N (rpm)","Spin speed,ω (rad/s)",'
        '"Precession period,T (s)","Average precession period,T (s)","Precession speed,Ω (rad/s)",Ω×ω\n'
        "0.15,0.12,0.1766,4585,480.14,8.13,8.21,0.08,40.81\n,,,,,8.16,,,\n,,,,,8.35,,,\n,0.15,0.2207,,,6.28,6.38,0.11,52.51\n",
        mapping={"time": "Precession period,T (s)", "spin": "Spin Speed,N (rpm)"},
        settings={"angle": "40 deg"},
    )
    assert readings.ok
    assert readings.columns["position"].values == (0.12, 0.12, 0.12, 0.15)
    assert shared(readings.columns["position"]) == (0, 0, 0, 1)
    assert readings.columns["torque"].values == (0.1766, 0.1766, 0.1766, 0.2207)
    assert shared(readings.columns["spin"]) == (0, 0, 0, 0)
    assert readings.columns["precession_period"].values == (8.21, None, None, 6.38)
    assert [other.header for other in readings.others] == ["Spin speed,ω (rad/s)"]


def test_one_torque_with_an_uncertainty_in_each_row():
    readings = read_log(
        "φ̇ (rpm),T_ψ (s),Δφ̇ (rpm)\n308.5,6.81,30.5\n294,7.22,4\n",
        mapping={"spin": "φ̇ (rpm)", "time": "T_ψ (s)", "u_spin": "Δφ̇ (rpm)"},
        settings={"turns": "1", "mass": "165.24 g", "position": "7.3 cm", "g": "9.81 m/s^2"},
    )
    assert readings.ok
    spin = readings.columns["spin"]
    assert [u.absolute for u in of(spin, "u")] == pytest.approx([30.5 * math.pi / 30, 4 * math.pi / 30])
    assert spin.readings[1].step == pytest.approx(0.1 * math.pi / 30)


def test_values_with_their_errors_in_the_cells():
    readings = read_log(
        '"m, г","l, мм","t_обр, c",N,"t_пад, c","α, рад","M, Н*м","T, c","Ω, c^-1","Ω_тр, c^-1"\n'
        "343±0.3,122±10,86.2±0.3,3,86.2±0.3,0.17±0.01,0.41,28.7,0.219,0.00197\n",
        mapping={"time": "t_обр, c"},
        settings={"spin": "382.79 Hz"},
    )
    assert readings.ok
    assert of(readings.columns["mass"], "u") == (Uncertainty(0.3 * 1e-3),)
    assert readings.columns["time"].values == (86.2,)
    assert readings.columns["turns"].values == (3.0,)
    assert readings.columns["spin"].values == (382.79 * 2 * math.pi,)
    assert readings.columns["torque"].values == (0.41,)
    assert readings.columns["precession_period"].values == (28.7,)


def test_decimal_commas_and_sigma_columns():
    readings = read_log(
        "№;m, кг;l, м;M, Н·м;σ_M, Н·м;t, с;N;T, с;σ_T, с;ε_T, %;Ω, с^-1;σ_Ω, с^-1\n"
        "1;0,074;0,122;0,089;0,001;139,48;1;139,48;0,5;0,3;0,045;0,001\n",
        settings={"spin": "392 Hz"},
    )
    assert readings.ok
    assert codes(readings) == {"G220"}
    assert readings.columns["mass"].values == (0.074,)
    assert readings.columns["time"].values == (139.48,)
    assert of(readings.columns["time"], "u") == (None,)
    assert of(readings.columns["precession_period"], "u") == (Uncertainty(0.5),)
    assert of(readings.columns["torque"], "u") == (Uncertainty(0.001),)


def test_minutes_and_seconds():
    readings = read_log(
        "mass [g],turns,time\n335,7,03:36.26\n273,2,01:14.80\n", settings={"spin": "390.9 Hz", "position": "12.1 cm"}
    )
    assert readings.ok
    assert readings.columns["time"].values == pytest.approx((216.26, 74.8))
    assert of(readings.columns["time"], "step") == (0.01, 0.01)


def test_blocks_side_by_side():
    readings = read_log('m=335 g,,m=273 g,\nN,"t, min",N,"t, min"\n7,03:36.26,4,02:32.40\n')
    assert codes(readings) == {"G211"}


def test_a_value_in_the_middle_of_its_block_and_no_mass():
    readings = read_log(
        "n;po.;nr pom.;kt ();czas (t)\n[obr/min];[cm];-;[°];[s]\n;0.5;1;;14.169\n"
        ";2.5;1;;31.559\n2400;4.5;-;90;-\n;6.5;1;;29.665\n"
    )
    assert codes(readings) >= {"G219", "G301"}
    missing = [d.message for d in readings.diagnostics if d.code == "G301"]
    assert [message.split()[0] for message in missing] == ["mass", "position", "turns"]
    assert "po., kt ()" in missing[0]


def test_no_spin():
    readings = read_log("Voltas;Medição 1 Tp ±0,2 (s);Medição 2 Tp ±0,2 (s)\n1ª;9,7;11,4\n")
    told = [d.message for d in readings.diagnostics if d.code == "G301"]
    assert any(re.match(r"(.*, )?spin( is|,| and).* missing", message) for message in told)
