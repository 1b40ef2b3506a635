"""What a student reports in the log: read as it is written, graded by others, never an
error of the log.
"""

import pytest
from typer.testing import CliRunner

from gyrodata.cli import app
from gyrodata.readings import read_log

LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"


def reported(text, key="inertia", name=None):
    return read_log(f"# reported_{name or key}: {text}\n{LOG}").reported[key]


@pytest.mark.parametrize(
    ("text", "fault", "value", "u"),
    [
        ("I = 4.4e-3 kg m^2 ± 0.1e-3 kg m^2", None, 4.4e-3, 1e-4),
        ("4.4e-3 ± 0.1e-3", "no unit", 4.4e-3, 1e-4),
        ("4.4 ± 0.1 kg m", "wrong unit", 4.4, 0.1),
        ("about four", "unreadable", None, None),
        ("4.4 ± -0.1 kg m^2", "unreadable", None, None),
    ],
)
def test_reported_value_is_read_and_what_is_wrong_is_kept(text, fault, value, u):
    told = reported(text)
    assert (told.fault, told.value) == (fault, value and pytest.approx(value))
    assert (fault in (None, "unreadable") and u is None) or told.u == pytest.approx(u)
    assert bool(told.problem) == bool(fault)


def test_each_key_has_its_names_and_its_kind_of_quantity():
    for name in ("I_zz", "Trägheitsmoment"):
        assert reported("4.4e-3 kg m^2", "inertia", name).value == pytest.approx(4.4e-3)
    assert reported("0.10(5) mN m", "imbalance").value == pytest.approx(1e-4)
    assert reported("50 ± 20 ms", "timing_bias").value == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("lines", "codes"),
    [
        (
            "# reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2\n# reported_exponent: 0.98 ± 0.02",
            [],
        ),
        ("# reported_inertia: 4.4e-3", ["G308"]),
        ("# reported_inertai: 4.4 g m^2", ["G305"]),
    ],
)
def test_reported_value_never_stops_a_log(lines, codes):
    readings = read_log(f"{lines}\n{LOG}")
    assert readings.ok
    assert [d.code for d in readings.diagnostics] == codes
    assert all(d.hint for d in readings.diagnostics)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "read"),
    [
        ("Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2", "(4.40 ± 0.10) × 10⁻³ kg·m²"),
        ("moment of inertia (kg m^2): 0.0044", "4.4 × 10⁻³ kg·m²"),
        ("I = 0.0044", ""),  # a current, or whatever
        ("expected I_zz = 4.4e-3 kg m^2", ""),
    ],
)
def test_answer_in_a_line_of_a_report_is_found(line, read, tmp_path):
    (tmp_path / "log.csv").write_text(LOG)
    (tmp_path / "report.txt").write_text(f"Lab 4\n{line}\n")
    said = CliRunner().invoke(app, ["check", "--hand-in", str(tmp_path)]).output
    assert (
        ("G719" in said)
        if not read
        else (f"I_zz = {read}, read from report.txt, line 2" in said)
    ), said
