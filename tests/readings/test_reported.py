"""What a student reports in the log: read as it is written, graded by others, never an error of the log."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrodata.readings import canonical_key, find_inertia, read_log, read_reported, usable_inertia, write_log

LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"

SAME = [
    "4.4e-3 ± 0.1e-3 kg m^2",
    "(4.4 ± 0.1) × 10⁻³ kg m²",
    "(4.4 +/- 0.1)e-3 kg·m²",
    "(4.4 ± 0.1) 10^-3 kg m^2",
    "4.4 ± 0.1 ×10^-3 kg m^2",
    "( 4.4 \\pm 0.1 )·10^{-3} kg m^2",
    "4.4(1)e-3 kg m^2",
    "4.4(0.1)e-3 kg*m**2",
    "0,0044 ± 0,0001 кг·м²",
    "4.4e-3 ± 0.1e-3 [kg m^2]",
    "I = 4.4e-3 kg m^2 ± 0.1e-3 kg m^2",
    "4.4 ± 0.1 g m^2",
    "4.4e-3 kg m^2 ± 0.1 g m^2",
    "44e3 ± 1e3 g cm^2",
    "4.4e-3 ± 0.2e-3 kg m^2 (k=2)",
]


@pytest.mark.parametrize("text", SAME)
def test_every_way_to_write_it_is_the_same_value(text: str) -> None:
    reported = read_reported("inertia", text)
    assert reported.problem is None
    assert reported.value == pytest.approx(4.4e-3, rel=1e-12)
    assert reported.u == pytest.approx(1e-4, rel=1e-12)
    assert (reported.digits, reported.u_digits) == (2, 1)
    assert reported.step == pytest.approx(reported.u_step)
    assert reported.step == pytest.approx(1e-4)


def test_an_uncertainty_in_percent() -> None:
    reported = read_reported("inertia", "4.40e-3 kg m^2 ± 2 %")
    assert reported.u == pytest.approx(8.8e-5)
    assert (reported.u_digits, reported.u_step, reported.unit) == (1, None, "kg m^2")


@pytest.mark.parametrize(
    ("text", "fault", "value", "number"),
    [
        ("4.4e-3 ± 0.1e-3", "no unit", 4.4e-3, 4.4e-3),
        ("4.4 ± 0.1 kg m", "wrong unit", None, 4.4),
        ("4.4 ± 0.1 furlong", "wrong unit", None, 4.4),
        ("about four", "unreadable", None, None),
        ("1e999 kg m^2", "unreadable", None, None),
        ("4.4 ± -0.1 kg m^2", "unreadable", None, 4.4),
        ("9" * 1000, "unreadable", None, None),
        ("4.4e-3 ± kg m^2", "unreadable", None, None),
    ],
)
def test_what_is_wrong_is_kept_beside_what_can_be_read(
    text: str, fault: str, value: float | None, number: float | None
) -> None:
    reported = read_reported("inertia", text)
    assert (reported.fault, reported.value, reported.number) == (fault, value, number)
    assert reported.problem


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("reported_inertia", "inertia"),
        ("reported_I_zz", "inertia"),
        ("Reported_Izz", "inertia"),
        ("reported_moment_of_inertia", "inertia"),
        ("reported_Trägheitsmoment", "inertia"),
        ("reported_imbalance", "imbalance"),
        ("reported_slope", "slope"),
    ],
)
def test_the_key_by_any_of_its_names(key: str, name: str) -> None:
    assert canonical_key(key) == name


def test_each_key_has_its_kind_of_quantity() -> None:
    assert read_reported("imbalance", "0.10(5) mN m").value == pytest.approx(1e-4)
    assert read_reported("timing_bias", "50 ± 20 ms").u == pytest.approx(0.02)
    assert read_reported("exponent", "0.98 ± 0.02").fault is None
    assert read_reported("slope", "0.21 s/rpm").text == "0.21 s/rpm"
    assert read_reported("ball_radius", "37.5 mm").value == pytest.approx(0.0375)


def test_a_log_with_reported_values_is_read_without_complaint() -> None:
    readings = read_log("# reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2\n# reported_exponent: 0.98 ± 0.02\n" + LOG)
    assert readings.diagnostics == ()
    assert readings.metadata == {}
    assert readings.reported["inertia"].line == 1
    assert readings.reported["exponent"].value == 0.98


def test_a_malformed_value_is_a_note_and_the_log_is_fine() -> None:
    readings = read_log("# reported_inertia: 4.4e-3\n" + LOG)
    assert readings.ok
    assert [(d.code, d.severity, d.line, d.column) for d in readings.diagnostics] == [("G308", "note", 1, 21)]
    assert "has no unit" in str(readings.diagnostics[0])


def test_a_line_left_blank_reports_nothing() -> None:
    readings = read_log("# reported_inertia: \n# reported_imbalance: -\n" + LOG)
    assert (readings.reported, readings.diagnostics) == ({}, ())


def test_two_values_for_one_key_are_neither() -> None:
    readings = read_log("# reported_inertia: 4.4 g m^2\n# reported_I: 4.5 g m^2\n" + LOG)
    reported = readings.reported["inertia"]
    assert (reported.value, reported.fault) == (None, "given twice")
    assert reported.problem == "inertia is reported twice, in lines 1 and 2, with two values"
    twice = read_log("# reported_inertia: 4.4 g m^2\n# reported_inertia: 4.4 g m^2\n" + LOG)
    assert twice.reported["inertia"].fault is None


@pytest.mark.parametrize("line", ["# reported_inertai: 4.4 g m^2", "# reported_inertia 4.4 g m^2"])
def test_a_misspelt_line_is_told(line: str) -> None:
    readings = read_log(f"{line}\n{LOG}")
    assert [d.code for d in readings.diagnostics] == ["G305"]
    assert "did you mean" in readings.diagnostics[0].hint


NUMBERS = st.decimals(min_value="0.001", max_value="999", places=3)


@given(NUMBERS, NUMBERS, st.integers(-6, 3), st.sampled_from(["kg m^2", "g·cm²", "кг м²", "g m^2", ""]))
@settings(derandomize=True, deadline=None, max_examples=150)
def test_written_and_read_again_it_is_the_same(value: object, u: object, power: int, unit: str) -> None:
    text = f"({value} ± {u})e{power} {unit}"
    readings = read_log(f"# reported_inertia: {text}\n# g: 9.803 m/s^2\n{LOG}")
    again = read_log(write_log(readings))
    assert again.reported == readings.reported
    reported = readings.reported["inertia"]
    factor = {"g·cm²": 1e-7, "g m^2": 1e-3}.get(unit, 1.0)
    assert reported.value is not None
    assert math.isclose(reported.value, float(str(value)) * 10.0**power * factor, rel_tol=1e-12)
    assert reported.fault == (None if unit else "no unit")


@given(st.text(max_size=60) | st.text("0123456789.,eE+-±()[]×^*% kgm²·/", max_size=60))
@settings(derandomize=True, deadline=None, max_examples=400)
def test_no_text_makes_it_raise(text: str) -> None:
    reported = read_reported("inertia", text)
    assert (reported.fault is None) == (reported.problem is None)
    assert reported.value is None or math.isfinite(reported.value)


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2", "4.4e-3 ± 0.1e-3 kg m^2"),
        ("**I_zz** = 4.4e-3 kg m^2", "4.4e-3 kg m^2"),
        ("I_zz: 4.4e-3 kg·m², which is 3 % low", "4.4e-3 kg·m²"),
        ("I_zz = 0.0044", "0.0044"),
        ("moment of inertia: 0.0044", "0.0044"),
        ("moment of inertia (kg m^2): 0.0044", "0.0044 kg m^2"),
        ("I = 0.0044 kg m^2, as we found", "0.0044 kg m^2"),
        ("I = 0.0044", ""),  # a current, or whatever
        ("expected I_zz = 4.4e-3 kg m^2", ""),
        ("torque = 3 N m", ""),
        ("I_zz of no number", ""),
        ("x" * 290 + " I_zz = 0.0044", ""),
        ("x" * 280 + " I_zz = 0.0044", "0.0044"),
    ],
)
def test_an_answer_in_a_line_of_a_report_is_found(line, answer):
    assert find_inertia(line) == answer


@pytest.mark.parametrize(
    ("text", "value", "problem"),
    [
        ("4.4e-3 kg m^2", 4.4e-3, None),
        ("1e-29 kg m^2", 1e-29, None),
        ("1e29 kg m^2", 1e29, None),
        ("1e-31 kg m^2", None, '"1e-31 kg m^2" is far from any moment of inertia'),
        ("1e31 kg m^2", None, '"1e31 kg m^2" is far from any moment of inertia'),
        ("4.4e-3 ± 1e-31 kg m^2", None, '"4.4e-3 ± 1e-31 kg m^2" is far from any moment of inertia'),
        ("0 kg m^2", 0.0, None),
    ],
)
def test_a_number_far_from_any_moment_of_inertia_is_not_judged(text, value, problem):
    used = usable_inertia(read_reported("inertia", text))
    assert (used.value, used.problem) == (value, problem)


@pytest.mark.parametrize(
    ("text", "value", "u"),
    [
        ("4.4e-3 ± 0.1e-3 kg m^2", 4.4e-3, 0.1e-3),
        ("4.4e-3 ± 0.1e-3", 4.4e-3, 0.1e-3),
        ("4.4e-3 ± 0.1e-3 furlongs", 4.4e-3, 0.1e-3),
        ("44 ± 1 kg cm^2", 4.4e-3, 1e-4),
        ("4.4e-3 ± 0 kg m^2", 4.4e-3, 0.0),
        ("0 kg m^2", 0.0, None),
        ("1.5e-30 kg m^2", 1.5e-30, None),
        ("-9e29 kg m^2", -9e29, None),
        ("0.9e-30 kg m^2", None, None),
        ("1.1e30 kg m^2", None, None),
        ("4.4e-3 ± 0.9e-30 kg m^2", None, 0.9e-30),
        ("4.4e-3 ± 1.1e30 kg m^2", None, 1.1e30),
        ("about four", None, None),
        ("9e200 kg m^2", None, None),
    ],
)
def test_a_number_without_its_unit_is_used_and_one_that_is_far_off_is_not(text, value, u):
    read = read_reported("inertia", text)
    used = usable_inertia(read)
    assert (used.value, used.u) == (pytest.approx(value) if value else value, pytest.approx(u) if u else u)
    assert bool(used.problem) == bool(read.problem or value is None)
    if read.value == value:
        assert used is read
