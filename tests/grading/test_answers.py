"""Reported values from the log and from files next to it; data/prose.toml has lines of
reports.
"""

import tomllib

import pytest
from places import DATA, SAMPLES

import gyrodata
from gyrodata.grading.submissions.answers import read_answers
from gyrodata.readings import read_log
from gyrodata.reporting.page import report_page

PROSE = tomllib.loads((DATA / "answers_in_prose.toml").read_text(encoding="utf-8"))
LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n20,15.0,406,13.06,1/3\n"
VALUE = "4.40e-3 ± 0.05e-3 kg m^2"


def test_answer_in_the_log_goes_before_one_beside_it() -> None:
    answers = read_answers(
        read_log(f"# reported_inertia: {VALUE}\n{LOG}"),
        [("report.txt", b"I_zz = 4.5e-3 kg m^2")],
    )
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u, answers.inertia.line) == (
        4.4e-3,
        0.05e-3,
        1,
    )
    assert answers.diagnostics == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    "text", [*(f"# I_zz = {one}" for one in PROSE["values"]), *PROSE["below"]]
)
def test_value_typed_as_people_type_is_read(text: str) -> None:
    for log in (f"{LOG}\n{text}\n", f"{text}\n{LOG}")[: 1 + ("#" in text)]:
        found = read_answers(read_log(log.encode())).inertia
        assert found
        assert (found.value, found.u) == (
            pytest.approx(4.4e-3),
            pytest.approx(0.05e-3, rel=0.03),
        )


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
@pytest.mark.parametrize(
    "text", [f'inertia = "{VALUE}"\n', f"\ninertia = {VALUE} # from the slope\n"]
)
def test_answer_in_a_file_of_answers_is_read(text: str, encoding: str) -> None:
    answers = read_answers(None, [("answers.toml", text.encode(encoding))])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u, answers.inertia.text) == (
        4.4e-3,
        0.05e-3,
        VALUE,
    )
    assert (answers.file, [one.code for one in answers.diagnostics]) == (
        "answers.toml",
        ["G717"],
    )


@pytest.mark.parametrize(
    "text",
    [
        '[inertia]\nvalue = 4.40e-3\nuncertainty = 0.05e-3\nunit = "kg m^2"\n',
        '[results.I_zz]\n\n# the slope\nvalue = 44.0 # mean\nu = 0.5\nunits = "kg cm^2"',
        '[answers]\nname = "Ann"\nI_zz = 4.40e-3\nu_I_zz = 5e-5\nunit = "kg m^2"\n',
        'I_zz = 4.40\nI_zz_u = 0.05\nI_zz_unit = "g m^2"\nstation = 3\n',
        'I_zz = { value = 4.40e-3, uncertainty = 0.05e-3, unit = "kg m^2" }\n',
        'I_zz = 4.4e-3\nu_I_zz = 5e-5\nI_zz_unit = "kg m²"\nM0 = 1e-4\nu_M0 = 2e-5\n',
        'I_zz = "4.40e-3 kg m^2"\nunsicherheit = "0.05e-3 kg m^2"\n',
    ],
    ids=["table", "dots", "keys", "behind", "inline", "others", "texts"],
)
def test_keys_of_an_uncertainty_and_a_unit_are_read(text: str) -> None:
    answers = read_answers(None, [("answers.toml", text.encode())])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u, answers.inertia.fault) == (
        pytest.approx(4.4e-3),
        pytest.approx(0.05e-3),
        None,
    )
    told = answers.diagnostics[0].message
    assert text.splitlines()[int(told.split("line ")[1].split(":")[0]) - 1].count("4")


def test_table_of_theory_is_no_answer() -> None:
    theory = '[theory]\nI_zz = 4.4e-3\nu = 5e-5\nunit = "kg m^2"\n'
    inline = 'theory = { I_zz = 4.4e-3, u = 5e-5, unit = "kg m^2" }\n'
    for text in (theory, inline):
        assert read_answers(None, [("answers.toml", text.encode())]).inertia is None


@pytest.mark.slow
@pytest.mark.parametrize("text", PROSE["answers"])
def test_answer_in_prose_is_read_and_its_line_told(text: str) -> None:
    name = "text.html" if text.startswith("<") else "report.txt"
    answers = read_answers(None, [(name, f"Our report.\n\n{text}\n".encode())])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u) == (
        pytest.approx(4.4e-3),
        pytest.approx(0.05e-3),
    )
    assert answers.diagnostics[0].message.startswith(f"I_zz is read from {name}, line ")


@pytest.mark.slow
@pytest.mark.parametrize("name", PROSE["hand_ins"])
def test_answer_without_instructions_is_read(name: str) -> None:
    # The square of a metre must be read in the code page of Windows too.
    found = read_answers(
        None,
        [
            (
                name,
                PROSE["hand_ins"][name].encode(
                    "cp1252" if name == "windows.txt" else "utf-8"
                ),
            )
        ],
    ).inertia
    assert found
    assert (found.value, found.u) == (
        pytest.approx(4.4e-3),
        pytest.approx(5e-5, rel=0.001),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [*PROSE["others"], "", "inertia = " + "[" * 100_000],
    ids=lambda text: text[:60],
)
def test_other_values_are_not_the_answer(text: str) -> None:
    found = read_answers(None, [("report.txt", text.encode())]).inertia
    assert found is None or found.value is None


@pytest.mark.parametrize("draft", ["draft.md", "answer_old.md", "entwurf.txt"])
def test_draft_is_the_answer_only_if_it_is_alone(draft: str) -> None:
    reports = [
        (draft, b"Result: I_zz = 4.1e-3 \xc2\xb1 0.1e-3 kg m^2"),
        ("answer.md", b"I_zz = 4.4e-3 kg m^2"),
    ]
    both, alone = (read_answers(None, some).inertia for some in (reports, reports[:1]))
    assert (both and both.value, alone and alone.value) == (4.4e-3, 4.1e-3)


def test_two_answers_that_differ_are_none() -> None:
    reports = [
        ("report.txt", b"I_zz = 4.4e-3 kg m^2"),
        ("notes.md", b"\nI_zz = 4.5e-3 kg m^2"),
    ]
    inertia = read_answers(None, reports).inertia
    assert inertia is not None
    assert (inertia.value, inertia.fault) == (None, "given twice")
    assert all(
        place in (inertia.problem or "")
        for place in ("report.txt, line 1", "notes.md, line 2")
    )


@pytest.mark.parametrize(
    "text", ["I_zz = 1/225 kg m^2", "I_zz = 4.4e-3 kg m^2", f"I_zz = {VALUE}"]
)
def test_the_same_answer_in_two_files_is_one_answer(text: str) -> None:
    # A fraction has no last digit.
    inertia = read_answers(
        None, [(name, text.encode()) for name in ("report.txt", "notes.md")]
    ).inertia
    assert inertia is not None
    assert inertia.value == pytest.approx(1 / 225 if "/" in text else 4.4e-3)
    assert inertia.fault is None


BELOW = ("u(I) = 0.05e-3 kg m^2", "u =\t0.05e-3\tkg m^2", "uncertainty: 0.05e-3 kg m^2")
BESIDE = (", within 1.1 % of theory", " (within 1,1% of the theory)", ", 2 % off")


@pytest.mark.parametrize(
    ("behind", "u"),
    [*((f"\n{one}", 0.05e-3) for one in BELOW), *((one, None) for one in BESIDE)],
)
def test_only_an_uncertainty_behind_the_answer_belongs_to_it(
    behind: str, u: float | None
) -> None:
    found = read_answers(
        None, [("report.txt", f"I_zz = 4.40e-3 kg m^2{behind}\n".encode())]
    ).inertia
    assert found is not None
    assert (found.value, found.u) == (pytest.approx(4.4e-3), pytest.approx(u))


EARLIER, LATER = "I_zz = 4.05e-3 ± 0.05e-3 kg m^2", "I_zz = 4.45e-3 ± 0.03e-3 kg m^2"


@pytest.mark.parametrize(
    ("text", "asked"),
    [
        (f"First attempt (forgot rpm): {EARLIER}\nAfter correction: {LATER}", False),
        (f"Results\n\n{EARLIER}\n\nCorrected answer: {LATER}", True),
        (f"{EARLIER}\n\nCorrected value after the comment:\n{LATER}", True),
        (f"{LATER} (corrected)\n{EARLIER} (first attempt)", False),
        (f"Final: {LATER}\n{EARLIER}", True),
        (f"Korrigiert: {LATER}\nEntwurf: {EARLIER}", False),
    ],
)
def test_corrected_answer_goes_before_an_earlier_one(text: str, asked: bool) -> None:
    """An earlier one without such a word is a question, but costs no grade."""
    answers = read_answers(None, [("report.txt", text.encode())])
    assert answers.inertia
    assert (answers.inertia.value, answers.inertia.u) == (4.45e-3, 0.03e-3)
    assert bool(answers.questions) == asked


def test_two_answers_of_one_version_are_none() -> None:
    text = f"Corrected: {EARLIER}\nCorrected: {LATER}"
    answers = read_answers(None, [("report.txt", text.encode())])
    assert answers.inertia
    assert answers.inertia.fault == "given twice"


def test_keys_of_another_table_belong_to_no_value_above_it() -> None:
    text = 'I_zz = "4.4e-3 kg m^2"\n[time]\nu = 0.14\n'
    answers = read_answers(None, [("answers.toml", text.encode())])
    assert answers.inertia is not None
    assert answers.inertia.u is None


def test_second_uncertainty_in_words_is_a_question() -> None:
    text = "with a statistical error of 0.03 g m^2 and a total error of 0.05 g m^2"
    report = f"I_zz = 4.40 g m^2 {text}".encode()
    answers = read_answers(None, [("report.md", report)])
    assert "give the total one" in answers.questions[0]


# --- a report that gyro analyze wrote ---


@pytest.fixture(scope="module")
def own_reports() -> dict[str, bytes]:
    """A report of gyro as its page and as Markdown, without figures."""
    lab = gyrodata.analyze(SAMPLES / "air_gyroscope.csv")
    page = report_page(lab, {})
    return {"report.html": page.encode(), "report.md": lab._repr_markdown_().encode()}


@pytest.mark.parametrize("name", ["report.html", "report.md"])
def test_an_answer_beside_a_report_of_gyro_is_the_answer(
    own_reports: dict[str, bytes], name: str
) -> None:
    report = (name, own_reports[name])
    for text in (f"The result is I_zz = {VALUE}.", "I_zz = 4.2e-3 ± 0.1e-3 kg m^2"):
        answers = read_answers(read_log(LOG), [report, ("own.txt", text.encode())])
        assert answers.file == "own.txt"
        assert answers.questions == ()
    stated = read_log(f"# reported_inertia: 4.2e-3 ± 0.1e-3 kg m^2\n{LOG}")
    assert read_answers(stated, [report]).questions == ()


@pytest.mark.parametrize("name", ["report.html", "report.md"])
def test_a_report_of_gyro_as_the_only_answer_is_a_question(
    own_reports: dict[str, bytes], name: str
) -> None:
    answers = read_answers(read_log(LOG), [(name, own_reports[name])])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u) == (4.416e-3, 0.033e-3)
    (question,) = answers.questions
    assert question.startswith("only a report of gyro analyze contains an answer: ")


@pytest.mark.parametrize(
    "text",
    [
        "L = I_zz ω = 0.2823 kg m^2 / s",
        "L = I_zz ω = 0.2823 ± 0.0021 kg m² s⁻¹",
        "L = I_zz · ψ = 0.2823 kg·m²·s^-1",
        r"$I_{zz} \dot\psi$ = \qty{0.28(2)}{\kilogram\metre\squared\per\second}",
        r"$I_{zz} \omega = 0.28\,\mathrm{kg\,m^2\,s^{-1}}$",
    ],
)
@pytest.mark.parametrize("name", ["report.txt", "report.tex"])
def test_an_angular_momentum_is_no_moment_of_inertia(text: str, name: str) -> None:
    assert read_answers(None, [(name, text.encode())]).inertia is None
    both = f"{text}\nI_zz = 4.40e-3 ± 0.05e-3 kg m^2\n"
    answer = read_answers(None, [(name, both.encode())]).inertia
    assert answer is not None
    assert answer.value == pytest.approx(4.4e-3)


def test_macros_of_latex_are_read_where_they_are_used() -> None:
    head = r"\newcommand{\Izz}{\qty{4.40 +- 0.05 e-3}{\kilogram\metre\squared}}"
    other = r"\renewcommand\never{I_zz = \qty{9 +- 1 e-3}{kg.m^2}}"
    report = f"{head}\n{other}\nWe find $I_{{zz}}$ = \\Izz{{}}.\n"
    answers = read_answers(None, [("report.tex", report.encode())])
    assert answers.inertia is not None
    assert (answers.inertia.value, answers.inertia.u) == (
        pytest.approx(4.4e-3),
        pytest.approx(0.05e-3),
    )
    assert "line 3" in answers.diagnostics[0].message


def test_macros_do_not_make_a_short_file_long() -> None:
    head = r"\newcommand{\a}{" + "x" * 200 + "}\n"
    answers = read_answers(None, [("report.tex", (head + r"\a" * 200_000).encode())])
    assert answers.inertia is None


@pytest.mark.parametrize(
    "behind",
    [
        "(expected 4.5 g m^2)",
        "[theory 4.5 g m^2]",
        "(accepted value 4.5e-3 kg m^2)",
        "(reference: 4.5 g m^2)",
    ],
)
def test_a_value_to_compare_in_brackets_is_not_about_the_answer(behind: str) -> None:
    text = f"I_zz = (4.40 ± 0.05) g m^2 {behind}"
    answer = read_answers(None, [("report.txt", text.encode())]).inertia
    assert answer is not None
    assert (answer.value, answer.u) == (pytest.approx(4.4e-3), pytest.approx(0.05e-3))


@pytest.mark.parametrize("behind", ["(theory)", "(expected)", "(theory, m = 4 kg)"])
def test_a_value_that_its_bracket_calls_another_is_no_answer(behind: str) -> None:
    text = f"I_zz = (4.50 ± 0.05) g m^2 {behind}"
    assert read_answers(None, [("report.txt", text.encode())]).inertia is None
