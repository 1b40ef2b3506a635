"""What a student reports in the log: read as it is written, graded by others, never an error of the log."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrodata.readings import find_inertia, read_log, usable_inertia, write_log

LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"


def reported(text, key="inertia", name=None):
    return read_log(f"# reported_{name or key}: {text}\n{LOG}").reported[key]


@pytest.mark.parametrize(
    ("text", "fault", "value", "u"),
    [
        ("I = 4.4e-3 kg m^2 ± 0.1e-3 kg m^2", None, 4.4e-3, 1e-4),
        ("( 4.4 \\pm 0.1 )·10^{-3} kg m^2", None, 4.4e-3, 1e-4),
        ("44e3 ± 1e3 g cm^2", None, 4.4e-3, 1e-4),
        ("4.40e-3 kg m^2 ± 2 %", None, 4.4e-3, 8.8e-5),
        ("4.4e-3 ± 0.1e-3", "no unit", 4.4e-3, 1e-4),
        ("4.4 ± 0.1 kg m", "wrong unit", None, None),
        ("4.4 ± 0.1 furlong", "wrong unit", None, None),
        ("about four", "unreadable", None, None),
        ("1e999 kg m^2", "unreadable", None, None),
        ("4.4 ± -0.1 kg m^2", "unreadable", None, None),
        ("4.4e-3 ± kg m^2", "unreadable", None, None),
    ],
)
def test_reported_value_is_read_and_what_is_wrong_is_kept(text, fault, value, u):
    told = reported(text)
    assert (told.fault, told.value) == (fault, value and pytest.approx(value))
    assert (fault in (None, "wrong unit", "unreadable") and u is None) or told.u == pytest.approx(u)
    assert bool(told.problem) == bool(fault)


@pytest.mark.parametrize("name", ["inertia", "I_zz", "Izz", "moment_of_inertia", "Trägheitsmoment"])
def test_key_has_any_of_its_names(name):
    assert reported("4.4e-3 kg m^2", name=name).value == pytest.approx(4.4e-3)


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [("imbalance", "0.10(5) mN m", 1e-4), ("timing_bias", "50 ± 20 ms", 0.05), ("exponent", "0.98 ± 0.02", 0.98),
     ("ball_radius", "37.5 mm", 0.0375)],
)  # fmt: skip
def test_each_key_has_its_kind_of_quantity(key, text, value):
    assert reported(text, key).value == pytest.approx(value)


@pytest.mark.parametrize(
    ("lines", "codes"),
    [
        ("# reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2\n# reported_exponent: 0.98 ± 0.02", []),
        ("# reported_inertia: \n# reported_imbalance: -", []),
        ("# reported_inertia: 4.4e-3", ["G308"]),
        ("# reported_inertai: 4.4 g m^2", ["G305"]),
        ("# reported_inertia 4.4 g m^2", ["G305"]),
    ],
)
def test_reported_value_never_stops_a_log(lines, codes):
    readings = read_log(f"{lines}\n{LOG}")
    assert readings.ok
    assert [d.code for d in readings.diagnostics] == codes
    assert all(d.hint for d in readings.diagnostics)


def test_two_values_for_one_key_are_neither():
    told = reported("4.4 g m^2\n# reported_I: 4.5 g m^2")
    assert (told.value, told.fault) == (None, "given twice")
    assert told.problem == "inertia is reported twice, in lines 1 and 2, with two values"
    assert reported("4.4 g m^2\n# reported_inertia: 4.4 g m^2").fault is None


NUMBERS = st.decimals(min_value="0.001", max_value="999", places=3)


@given(NUMBERS, NUMBERS, st.integers(-6, 3), st.sampled_from(["kg m^2", "g·cm²", "кг м²", "g m^2"]))
@settings(derandomize=True, deadline=None, max_examples=150)
def test_reported_value_written_and_read_again_is_the_same(value, u, power, unit):
    readings = read_log(f"# reported_inertia: ({value} ± {u})e{power} {unit}\n{LOG}")
    assert read_log(write_log(readings)).reported == readings.reported
    factor = {"g·cm²": 1e-7, "g m^2": 1e-3}.get(unit, 1.0)
    expected = float(str(value)) * 10.0**power * factor
    assert math.isclose(readings.reported["inertia"].value, expected, rel_tol=1e-12)


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2", "4.4e-3 ± 0.1e-3 kg m^2"),
        ("**I_zz** = 4.4e-3 kg m^2", "4.4e-3 kg m^2"),
        ("I_zz: 4.4e-3 kg·m², which is 3 % low", "4.4e-3 kg·m²"),
        ("moment of inertia (kg m^2): 0.0044", "0.0044 kg m^2"),
        ("I = 0.0044 kg m^2, as we found", "0.0044 kg m^2"),
        ("I = 0.0044", ""),  # a current, or whatever
        ("expected I_zz = 4.4e-3 kg m^2", ""),
        ("torque = 3 N m", ""),
    ],
)
def test_answer_in_a_line_of_a_report_is_found(line, answer):
    assert find_inertia(line) == answer


@pytest.mark.parametrize(
    ("text", "value"),
    [("44 ± 1 kg cm^2", 4.4e-3), ("4.4e-3 ± 0.1e-3 furlongs", 4.4e-3), ("1e-31 kg m^2", None), ("1e31 kg m^2", None)],
)
def test_number_far_from_any_moment_of_inertia_is_not_judged(text, value):
    used = usable_inertia(reported(text))
    assert used.value == (value and pytest.approx(value))
    assert value is not None or "far from any moment of inertia" in used.problem
