"""Reported values from the log and from files beside it."""

import pytest

from gyrodata.grading.submissions.student_files import read_answers
from gyrodata.readings import read_log

LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
VALUE = "4.40e-3 ± 0.05e-3 kg m^2"


def test_answer_in_the_log_goes_before_one_beside_it() -> None:
    answers = read_answers(read_log(f"# reported_inertia: {VALUE}\n{LOG}"), [("report.txt", b"I_zz = 4.5e-3 kg m^2")])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u, answers.inertia.line) == (4.4e-3, 0.05e-3, 1)
    assert answers.diagnostics == ()


@pytest.mark.parametrize(
    "text",
    [
        "4.40×10⁻³ ± 0.05×10⁻³ kg·m²", "4.40 x 10^-3 ± 0.05 x 10^-3 kg m^2", "(4.40 ± 0.05)×10⁻³ kg·m²",
        "4.40e-3 ± 1.136364% kg m^2", "4.40e-3 ± 0.05e-3 kg-m^2", "44,000 ± 500 g cm^2",
        "4.40e-3 ± 0.10e-3 kg m^2 (95 %)",
        "4.40e-3 ± 0.05e-3 kg m^2 (1 sigma)", "about 4.40e-3 ± 0.05e-3 kg m^2", "4.40e-3 kg m^2, u = 0.05e-3",
    ],
)  # fmt: skip
def test_value_typed_as_people_type_is_read(text: str) -> None:
    found = read_answers(read_log(f"# I_zz = {text}\n{LOG}".encode())).inertia
    assert found
    assert (found.value, found.u) == (pytest.approx(4.4e-3), pytest.approx(0.05e-3, rel=0.03))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
@pytest.mark.parametrize(
    "text",
    [
        f'inertia = "{VALUE}"\n',
        f"inertia = {VALUE}\n",
        f"# reported_inertia: {VALUE}\r\n",
        f"My answers\n\ninertia = {VALUE} # from the slope\n",
    ],
)
def test_answer_in_a_file_of_answers_is_read(text: str, encoding: str) -> None:
    answers = read_answers(None, [("answers.toml", text.encode(encoding))])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u, answers.inertia.text) == (4.4e-3, 0.05e-3, VALUE)
    assert (answers.file, [one.code for one in answers.diagnostics]) == ("answers.toml", ["G717"])


@pytest.mark.parametrize(
    "text",
    [
        "Our report.\n\nI_zz = 4.40e-3 ± 0.05e-3 kg m^2\n",
        "**Moment of inertia: (4.40 ± 0.05)×10⁻³ kg·m²**, as it should be\n",
        "We find that I is 4.40e-3 kg m^2, u = 0.05e-3, which is fine.\n",
        "| I_zz [kg m^2] | 4.40e-3 ± 0.05e-3 |\n",
        "<p>I<sub>zz</sub> = 4.40&middot;10<sup>-3</sup> &plusmn; 0.05&middot;10<sup>-3</sup> kg m<sup>2</sup></p>",
    ],
)
def test_answer_in_a_report_is_read_and_its_line_told(text: str) -> None:
    name = "text.html" if text.startswith("<") else "report.txt"
    answers = read_answers(None, [(name, text.encode())])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u) == (pytest.approx(4.4e-3), pytest.approx(0.05e-3))
    assert answers.diagnostics[0].message.startswith(f"I_zz is read from {name}, line ")


@pytest.mark.parametrize(
    "text",
    ["the period I = 3 s", "I_zz = see the PDF", "", "inertia = " + "[" * 100_000],
    ids=["period", "elsewhere", "nothing", "huge"],
)
def test_report_without_the_answer_gives_none(text: str) -> None:
    assert read_answers(None, [("report.txt", text.encode())]).inertia is None


def test_two_answers_that_differ_are_none() -> None:
    reports = [("report.txt", b"I_zz = 4.4e-3 kg m^2"), ("notes.md", b"\nI_zz = 4.5e-3 kg m^2")]
    inertia = read_answers(None, reports).inertia
    assert inertia is not None
    assert (inertia.value, inertia.fault) == (None, "given twice")
    assert all(place in (inertia.problem or "") for place in ("report.txt, line 1", "notes.md, line 2"))
