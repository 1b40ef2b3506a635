"""The page: whole, self-contained, escaped, legible, and saying what the result says."""

from __future__ import annotations

import html
import json
import math
import re
from itertools import pairwise

import pytest
from msgspec.structs import replace
from pages import (
    IN_ORDER,
    KINDS,
    LOG,
    Structure,
    analysis_of,
    find,
    known,
    make_page,
)
from places import SAMPLES

from gyrodata import analyze
from gyrodata.base.errors import InputError
from gyrodata.reporting.data import json_text
from gyrodata.reporting.figures import alternatives
from gyrodata.reporting.latex import latex_report
from gyrodata.reporting.markdown import markdown_report
from gyrodata.reporting.text import summary
from gyrodata.reporting.values import inertia_text, number_text
from gyrodata.results import Analysis


def words(page: str) -> str:
    """All that is read, as one line with plain blanks and minus signs."""
    plain = html.unescape(
        re.sub(r"<[^>]+>", "", re.sub(r"<(style|script).*?</\1>", "", page, flags=re.S))
    )
    return re.sub(r"\s+", " ", plain.replace("−", "-").replace("\xa0", " "))


def said(text: str) -> str:
    """A text of the tool as the page shows it."""
    return re.sub(r"\s+", " ", text.replace("−", "-").replace("I_zz", "Izz"))


@pytest.fixture(scope="module")
def analysis() -> Analysis:
    return analyze(LOG.encode(), name="log<1>.csv")


@pytest.fixture(scope="module")
def page(analysis: Analysis) -> str:
    return make_page(analysis)


@pytest.mark.slow
def test_headings_images_tables_and_identities(analysis: Analysis, page: str) -> None:
    tags = Structure(page).tags
    levels = [int(tag[1]) for tag, _ in tags if re.fullmatch("h[1-6]", tag)]
    assert (levels[0], levels.count(1)) == (1, 1)
    assert all(after - before <= 1 for before, after in pairwise(levels))
    words = alternatives(analysis)
    assert [attrs["alt"] for tag, attrs in tags if tag == "img"] == [
        words[name] for name in IN_ORDER
    ]
    identities = [attrs["id"] for _, attrs in tags if "id" in attrs]
    assert len(set(identities)) == len(identities)
    assert {str(attrs["href"])[1:] for tag, attrs in tags if tag == "a"} <= set(
        identities
    )
    names = [tag for tag, _ in tags]
    assert names.count("caption") == names.count("table") == names.count("thead") > 6
    assert all(
        attrs.get("scope") in ("col", "row") for tag, attrs in tags if tag == "th"
    )
    boxes = [attrs for _, attrs in tags if attrs.get("class") == "box"]
    assert all(
        box["role"] == "region" and box["aria-label"] and box["tabindex"] == "0"
        for box in boxes
    )


@pytest.mark.slow
def test_nothing_comes_from_outside_or_from_the_log_as_code(page: str) -> None:
    for tag, attrs in Structure(page).tags:
        assert all(
            str(attrs.get(key, "#")).startswith(("data:", "#"))
            for key in ("src", "href")
        ), tag
        assert not any(key.startswith("on") for key in attrs), tag
    assert not re.search(
        r"https?://|url\(|@import|<script>alert|<img src=x|<b>3|log<1>", page
    )
    assert html.escape("<script>alert('x')</script> & more") in page.replace(
        "&#39;", "&#x27;"
    )


def shows(text: str, shown: float) -> bool:
    """Whether a text is the number, rounded to the digits that it has."""
    text = text.replace("−", "-")
    if text[0] in "<>":
        return (abs(shown) < float(text[1:])) == (text[0] == "<")
    if "/" in text:
        above, below = text.split("/")
        return math.isclose(int(above) / int(below), shown, rel_tol=1e-6)
    mantissa, _, exponent = text.partition("e")
    half = 0.5 * 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(float(text) - shown) <= half * (1 + 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_number_of_the_page_is_in_results_json_and_equal(kind: str) -> None:
    analysis = analysis_of(kind)
    document = json.loads(json_text(analysis.to_dict()))
    page = Structure(make_page(analysis))
    assert len(page.numbers) > 40
    assert not {"nan", "None", "inf"} & set(page.text.split())
    for attributes, text in page.numbers:
        place, expected = (
            str(attributes["data-from"]),
            find(document, str(attributes["data-from"])),
        )
        if isinstance(expected, str):
            assert attributes["value"] == text == expected, place
            continue
        value = float(str(attributes["value"]))
        assert value == expected, place
        assert shows(text, value / float(str(attributes["data-size"]))), (
            place,
            text,
            value,
        )
    # And what is left holds no other number.
    left = re.sub(r"\s+", " ", page.text.replace("\xa0", " ").replace("−", "-"))
    left = re.sub(r"10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|M0", "", left)
    for text in known(analysis):
        left = left.replace(said(text).replace("M0", ""), " ")
    assert re.findall(r"[^ ]*\d[^ ]*", left) == []


def test_it_says_what_the_result_says(analysis: Analysis, page: str) -> None:
    text = words(page)
    assert said(inertia_text(analysis.inertia.value, analysis.inertia.u)) in text
    assert analysis.sha256 in text
    texts = [
        *analysis.advice,
        *(diagnostic.message for diagnostic in analysis.diagnostics),
    ]
    texts += [
        *(effect.reason for effect in analysis.effects),
        *(fit.note for fit in analysis.fits),
    ]
    texts += [
        number_text(group.product.value, group.product.u) for group in analysis.torques
    ]
    assert [told for told in texts if said(told) not in text] == []
    rows = re.findall(r'<tr class="flagged">(.*?)</tr>', page, re.S)
    assert len(rows) == sum(run.flagged for run in analysis.run_table) == 1
    assert "left out: fits 1 turn, not 2" in words(rows[0])


@pytest.mark.slow
def test_what_not_even_u_can_save_is_said_next_to_the_answer() -> None:
    log = KINDS["far too much scatter"].replace("40.1,1", "60.1,1")
    analysis = analyze(log.encode(), name="log.csv", keep_flagged=True)
    page = make_page(analysis)
    below = page.partition('class="answer doubted"')[2].partition("<figure")[0]
    before = summary(analysis).partition("I_zz = ")[0]
    for text in (words(below), before):
        assert "Do not rely on this answer: " in text
        assert "contradict each other" in text
    for form in (markdown_report, latex_report):
        assert "Do not rely on this answer" in form(analysis).partition("95")[0]
    assert "Do not rely" not in summary(analyze(LOG.encode()))


@pytest.mark.slow
def test_one_run_is_worked_out_by_hand() -> None:
    """The first one with a load that is in the fit, and each step follows from the
    numbers before it.
    """
    head, row = KINDS["one torque"].splitlines()[1], "{},15,{},{:.2f},1\n".format
    runs = (
        "0,,401,160.2,1/12\n20,15,206,30.9,1\n20,15,407,13.47,1/3\n20,15,601,59.5,1\n"
    )
    runs += "".join(
        row(20 * k, rpm, 0.0993 * rpm / k) for k in (2, 3) for rpm in (206, 407, 605)
    )
    analysis = analyze(f"# g: 9.803 m/s^2\n{head}\n{runs}".encode())
    assert [run.left_out for run in analysis.run_table[:3]] == [False, True, False]
    text = markdown_report(analysis).replace("\\", "")
    section = text.partition("## One run by hand")[2].partition("\n## ")[0]
    assert "Run 3 (line 5)" in section
    steps = re.findall(r"^- (.*)$", section, re.M)
    assert [step.split(" = ")[0] for step in steps] == ["M", "φ̇", "ψ̇", "φ̇ψ̇", "I_zz"]
    assert steps[1].startswith("φ̇ = 2π × (1/3) / 13.47 s = ")
    for step in steps:
        *_, worked, result = step.split(" = ")
        sum_ = re.sub(
            r" (?:rad²/s²|rad/s|m/s²|N·m|kg|rpm|rad|m|s)(?![\w·/])", "", worked
        ).replace("×", "*")
        number = float(result.split()[0]) * (1e-3 if "10⁻³" in result else 1)
        assert eval(sum_.replace("2π", "2*math.pi")) == pytest.approx(
            number, rel=5e-4
        ), step
    assert analysis.run_table[2].inertia == pytest.approx(number, rel=2e-4)


@pytest.mark.slow
def test_first_screen_has_author_and_few_words_and_details_are_folded() -> None:
    lines = "# date: 2026-03-14\n# Author: Ana <b>Müller</b>\n# course: Physics II\n"
    analysis = analyze(
        f"{lines}{LOG}".encode().replace(b",206,20.4,", b",206.0,20.40,"),
        name="log.csv",
    )
    page = make_page(analysis)
    first_screen = page.partition("<main")[0]
    first = words(re.sub('<p class="(banner|warning)">.*?</p>', "", first_screen))
    assert re.search(
        "Author: Ana <b>Müller</b> · Course: Physics II · .* · Date: 2026-03-14", first
    )
    assert len(first.split()) <= 120
    folded = re.findall(r'<details>\s*<summary><h2 id="(\w+)"', page)
    assert folded[:3] == ["sensitivity", "fits", "effects"]
    assert folded[-2:] == ["provenance", "conventions"]
    by_hand = words(page.partition('id="byhand"')[2])
    assert "ψ̇ = 206.0 rpm × (2π rad)/(60 s)" in by_hand
    assert "/ 20.40 s = " in by_hand


def test_angular_momentum_and_centre_of_mass_are_on_the_page(
    analysis: Analysis, page: str
) -> None:
    momentum, centre = analysis.angular_momentum, analysis.centre_of_mass
    assert momentum.value == pytest.approx(
        analysis.inertia.value * 607 * 2 * math.pi / 60
    )
    assert f"L = Izz ψ̇ = {number_text(momentum.value, momentum.u)} kg·m²/s" in words(
        page
    )
    assert centre is not None
    assert centre.value == pytest.approx(
        analysis.residual_torque.value / (4.10 * 9.803)
    )
    assert f"{number_text(centre.value, centre.u, 1e-6)} µm, along the rod" in words(
        page
    )


def test_worksheet_keeps_numbers_and_asks_for_conclusions(
    analysis: Analysis, page: str
) -> None:
    worksheet = make_page(
        replace(analysis, options=replace(analysis.options, worksheet=True))
    )
    assert worksheet.count("Hint:") == worksheet.count('class="task"') == 8
    assert "Answer the questions that have a hint" in words(worksheet)
    assert not re.search(
        "agrees with|agree with one|is constant|is proportional|perfectly balanced",
        words(worksheet),
    )
    shown = {text for _, text in Structure(worksheet).numbers}
    assert {
        number_text(group.product.value, group.product.u).split()[0]
        for group in analysis.torques
    } - shown == set()
    assert [worksheet.count(f"<{tag}") for tag in ("figure", "table")] == [
        page.count(f"<{tag}") for tag in ("figure", "table")
    ]


def test_terminal_page_and_worksheet_have_one_limit_of_p(analysis: Analysis) -> None:
    options = replace(analysis.options, worksheet=True)
    assert "A p below 0.05" in words(make_page(replace(analysis, options=options)))
    for p, agrees in ((0.051, True), (0.049, False)):
        shown = replace(analysis, p=p, doubts=())
        for text in (words(make_page(shown)), summary(shown, verbose=False)):
            assert ("agree with one straight line" in text) == agrees
    # All runs are on their lines, but each weight has its own M0.
    disagreeing = analyze(SAMPLES / "heidelberg_ball.csv")
    assert "do not agree with one straight line for the reason above" in words(
        make_page(disagreeing)
    )


def test_page_names_the_run_that_is_worth_repeating() -> None:
    log = SAMPLES / "class" / "adlernina_101_9001_lab.csv"
    repeated = "If you have time, repeat run 4 (line 8): over 2 u away"
    assert repeated in words(make_page(analyze(log)))


@pytest.mark.slow
def test_numbers_of_questions_can_be_removed(page: str) -> None:
    assert len(re.findall(r"\(question [124]|\(question 3 [a-e]\)", words(page))) == 10
    assert "(question" not in words(
        make_page(analyze(LOG, settings={"question_numbers": "no"}))
    )
    with pytest.raises(InputError, match='write "no" to omit'):
        analyze(LOG, settings={"question_numbers": "off-ish"})


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_warning_is_below_the_answer_with_its_place(kind: str) -> None:
    log = KINDS[kind].replace("# g: ", "# gg: ")
    analysis = analyze(log.encode(), name="log.csv")
    page = make_page(analysis)
    top = words(page.partition('class="answer')[2].partition("<main")[0])
    for finding in analysis.diagnostics:
        if finding.severity == "note":
            assert said(finding.message) not in top
            continue
        assert said(finding.message) in top
        if finding.line is not None:
            assert f"(line {finding.line}" in top
    doubted = page.partition('class="answer')[2].partition("<main")[0]
    assert doubted.count('class="banner"') == len(analysis.doubts)


def test_a_balanced_ball_has_a_bound_of_its_imbalance(analysis: Analysis) -> None:
    low, high = (-2e-4, 3e-4)
    m0 = replace(analysis.residual_torque, value=5e-5, u=1e-4, interval_95=(low, high))
    text = words(make_page(replace(analysis, residual_torque=m0)))
    assert "The imbalance is smaller than 0.30 mN·m (95 %)." in text
