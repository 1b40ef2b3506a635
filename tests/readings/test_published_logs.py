"""Layouts of published student tables, shortened to the rows that show how they are written."""

import math
import re

import pytest

from gyrodata.readings import read_log


def codes(readings):
    return {diagnostic.code for diagnostic in readings.diagnostics}


@pytest.mark.parametrize(
    ("log", "options", "values"),
    [
        # Timings below each other, with merged cells.
        (('"Mass, m (kg)","Radius,r (m)","Couple,M (Nm)","Spin Speed,N (rpm)","Spin speed,ω (rad/s)",'
         '"Precession period,T (s)","Average precession period,T (s)","Precession speed,Ω (rad/s)",Ω×ω\n'
         "0.15,0.12,0.1766,4585,480.14,8.13,8.21,0.08,40.81\n,,,,,8.16,,,\n,,,,,8.35,,,\n"
         ",0.15,0.2207,,,6.28,6.38,0.11,52.51\n"),
         {"mapping": {"time": "Precession period,T (s)", "spin": "Spin Speed,N (rpm)"},
          "settings": {"angle": "40 deg"}},
         {"position": (0.12, 0.12, 0.12, 0.15), "torque": (0.1766, 0.1766, 0.1766, 0.2207),
          "spin": (4585 * math.pi / 30,) * 4, "precession_period": (8.21, None, None, 6.38)}),
        # One torque, with an uncertainty in each row.
        ("φ̇ (rpm),T_ψ (s),Δφ̇ (rpm)\n308.5,6.81,30.5\n294,7.22,4\n",
         {"mapping": {"spin": "φ̇ (rpm)", "time": "T_ψ (s)", "u_spin": "Δφ̇ (rpm)"},
          "settings": {"turns": "1", "mass": "165.24 g", "position": "7.3 cm", "g": "9.81 m/s^2"}},
         {"spin": (308.5 * math.pi / 30, 294 * math.pi / 30), "time": (6.81, 7.22)}),
        # Values with their errors in the cells.
        (('"m, г","l, мм","t_обр, c",N,"t_пад, c","α, рад","M, Н*м","T, c","Ω, c^-1","Ω_тр, c^-1"\n'
         "343±0.3,122±10,86.2±0.3,3,86.2±0.3,0.17±0.01,0.41,28.7,0.219,0.00197\n"),
         {"mapping": {"time": "t_обр, c"}, "settings": {"spin": "382.79 Hz"}},
         {"mass": (0.343,), "time": (86.2,), "turns": (3.0,), "torque": (0.41,), "precession_period": (28.7,)}),
        # Decimal commas and columns of σ.
        (("№;m, кг;l, м;M, Н·м;σ_M, Н·м;t, с;N;T, с;σ_T, с;ε_T, %;Ω, с^-1;σ_Ω, с^-1\n"
         "1;0,074;0,122;0,089;0,001;139,48;1;139,48;0,5;0,3;0,045;0,001\n"),
         {"settings": {"spin": "392 Hz"}}, {"mass": (0.074,), "time": (139.48,), "torque": (0.089,)}),
        # Minutes and seconds.
        ("mass [g],turns,time\n335,7,03:36.26\n273,2,01:14.80\n",
         {"settings": {"spin": "390.9 Hz", "position": "12.1 cm"}}, {"time": (216.26, 74.8), "turns": (7, 2)}),
    ],
)  # fmt: skip
def test_published_table_is_read(log, options, values):
    readings = read_log(log, **options)
    assert readings.ok
    for role, expected in values.items():
        assert list(readings.columns[role].values) == [value and pytest.approx(value) for value in expected]


def test_uncertainties_in_cells_and_columns_are_read():
    readings = read_log(
        "m, г;x, см;M, Н·м;σ_M, Н·м;t, с;N\n343±0,3;12,2;0,41;0,01;86,2;1\n", settings={"spin": "392 Hz"}
    )
    assert [readings.columns[role].readings[0].u.absolute for role in ("mass", "torque")] == pytest.approx([3e-4, 0.01])


def test_table_that_lacks_something_is_asked_about():
    assert codes(read_log('m=335 g,,m=273 g,\nN,"t, min",N,"t, min"\n7,03:36.26,4,02:32.40\n')) == {"G211"}
    readings = read_log(
        "n;po.;nr pom.;kt ();czas (t)\n[obr/min];[cm];-;[°];[s]\n;0.5;1;;14.169\n"
        ";2.5;1;;31.559\n2400;4.5;-;90;-\n;6.5;1;;29.665\n"
    )
    assert codes(readings) >= {"G219", "G301"}
    missing = [d.message for d in readings.diagnostics if d.code == "G301"]
    assert [message.split()[0] for message in missing] == ["mass", "position", "turns"]
    assert "po., kt ()" in missing[0]
    told = read_log("Voltas;Medição 1 Tp ±0,2 (s);Medição 2 Tp ±0,2 (s)\n1ª;9,7;11,4\n").diagnostics
    assert any(re.match(r"(.*, )?spin( is|,| and).* missing", d.message) for d in told if d.code == "G301")
