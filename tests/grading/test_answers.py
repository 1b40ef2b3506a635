"""Reported values from the log and from an answers file."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrodata.grading import Answers, read_answers
from gyrodata.readings import read_log

LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
VALUE = "4.40e-3 ± 0.05e-3 kg m^2"


def codes(answers: Answers) -> list[str]:
    return [diagnostic.code for diagnostic in answers.diagnostics]


def test_the_log_reports() -> None:
    answers = read_answers(read_log(f"# reported_inertia: {VALUE}\n{LOG}"), [("report.txt", b"I_zz = 4.5e-3 kg m^2")])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u, answers.inertia.line) == (4.4e-3, 0.05e-3, 1)
    assert answers.diagnostics == ()


@pytest.mark.parametrize(
    "text",
    [
        f'inertia = "{VALUE}"\n',
        f"reported_inertia = '{VALUE}'",
        f'# my answers\n[reported]\nI_zz = "{VALUE}"\n',
        f"inertia = {VALUE}\n",
        f"inertia: {VALUE}",
        f"# reported_inertia: {VALUE}\r\n",
        f'Moment of inertia = "{VALUE}\n',
        f"My answers\n\ninertia = {VALUE} # from the slope\n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_a_file_of_answers_is_read_line_by_line(text: str, encoding: str) -> None:
    answers = read_answers(None, [("answers.toml", text.encode(encoding))])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u) == (4.4e-3, 0.05e-3)
    assert answers.inertia.text == VALUE
    assert answers.file == "answers.toml"
    assert codes(answers) == ["G717"]


@given(st.binary(max_size=200) | st.text(max_size=200).map(lambda text: text.encode("utf-8", "replace")))
@settings(derandomize=True, deadline=None, max_examples=300)
def test_no_text_makes_it_raise(data: bytes) -> None:
    answers = read_answers(None, [("answers.toml", data)])
    assert all(diagnostic.message for diagnostic in answers.diagnostics)


def test_a_huge_file_is_survived() -> None:
    assert read_answers(None, [("a.txt", b"inertia = " + b"[" * 100_000)]).inertia is None
    assert read_answers(None, [("a.txt", b"inertia = " + b"9" * 1_000_000)]) is not None


@pytest.mark.parametrize(
    "text",
    [
        "Our report.\n\nI_zz = 4.40e-3 ± 0.05e-3 kg m^2\n",
        "**Moment of inertia: (4.40 ± 0.05)×10⁻³ kg·m²**, as it should be\n",
        "We find that I is 4.40e-3 kg m^2, u = 0.05e-3, which is fine.\n",
        "| I_zz [kg m^2] | 4.40e-3 ± 0.05e-3 |\n",
        "<p>I<sub>zz</sub> = 4.40&middot;10<sup>-3</sup> &plusmn; 0.05&middot;10<sup>-3</sup> kg m<sup>2</sup></p>",
        "I_zz (theory) = 4.6e-3 kg m^2\nI_zz = 4.40e-3 ± 0.05e-3 kg m^2\nthe mass was 20 g\n",
    ],
)
def test_a_report_beside_the_log(text: str) -> None:
    name = "text.html" if text.startswith("<") else "report.txt"
    answers = read_answers(None, [(name, text.encode())])
    assert answers.inertia is not None
    assert answers.inertia.fault is None
    assert answers.inertia.value == pytest.approx(4.4e-3)
    assert answers.inertia.u == pytest.approx(0.05e-3)
    (told,) = answers.diagnostics
    assert told.message.startswith(f"I_zz is read from {name}, line ")


@pytest.mark.parametrize("text", ["the period I = 3 s", "transverse inertia: 3e-3 kg m^2", "I_zz = see the PDF", ""])
def test_a_report_without_the_answer(text: str) -> None:
    assert read_answers(None, [("report.txt", text.encode())]).inertia is None


def test_two_answers_that_differ_are_none() -> None:
    reports = [("report.txt", b"I_zz = 4.4e-3 kg m^2"), ("notes.md", b"\nI_zz = 4.5e-3 kg m^2")]
    inertia = read_answers(None, reports).inertia
    assert inertia is not None
    assert (inertia.value, inertia.fault) == (None, "given twice")
    assert "report.txt, line 1" in (inertia.problem or "")
    assert "notes.md, line 2" in (inertia.problem or "")
    same = [("report.txt", b"I_zz = 4.4e-3 kg m^2"), ("notes.md", b"I_zz = 4.4e-3 +- 0.1e-3 kg m^2")]
    inertia = read_answers(None, same).inertia
    assert inertia is not None
    assert inertia.u == pytest.approx(1e-4)
