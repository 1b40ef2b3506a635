"""The page: whole, self-contained, escaped, legible, and saying what the result says."""

from __future__ import annotations

import html
import json
import math
import re
from itertools import pairwise
from typing import Any

import pytest
from pages import KINDS, LOG, WORDS, Structure, find, known, make_page

from gyrodata import __version__, analyze, plotting, reporting
from gyrodata.results import Analysis


def words(page: str) -> str:
    """All that is read, as one line with plain blanks and minus signs."""
    plain = html.unescape(re.sub(r"<[^>]+>", "", re.sub(r"<(style|script).*?</\1>", "", page, flags=re.S)))
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


class TestStructure:
    def test_headings_images_and_identities(self, page: str) -> None:
        tags = Structure(page).tags
        levels = [int(tag[1]) for tag, _ in tags if re.fullmatch("h[1-6]", tag)]
        assert levels[0] == 1
        assert levels.count(1) == 1
        assert all(after - before <= 1 for before, after in pairwise(levels))
        images = [attrs for tag, attrs in tags if tag == "img"]
        assert [image["alt"] for image in images] == [f"what {name} shows" for name in plotting.FIGURES]
        identities = [attrs["id"] for _, attrs in tags if "id" in attrs]
        assert len(set(identities)) == len(identities)
        targets = {str(attrs["href"])[1:] for tag, attrs in tags if tag == "a"}
        assert targets <= set(identities)

    def test_every_table_has_a_caption_and_heads_with_a_scope(self, page: str) -> None:
        tags = Structure(page).tags
        names = [tag for tag, _ in tags]
        assert names.count("caption") == names.count("table") == names.count("thead") > 6
        assert all(attrs.get("scope") in ("col", "row") for tag, attrs in tags if tag == "th")
        boxes = [attrs for _, attrs in tags if attrs.get("class") == "box"]
        assert all(box["role"] == "region" and box["aria-label"] and box["tabindex"] == "0" for box in boxes)

    def test_pictures_beside_numbers_are_hidden_from_screen_readers(self, analysis: Analysis, page: str) -> None:
        for tag, attrs in Structure(page).tags:
            if tag == "svg" or attrs.get("class") == "picture":
                assert attrs["aria-hidden"] == "true"
        hangs = sum(case.inertia is not None for case in analysis.sensitivity)
        dots = page.count('class="dot"') + page.count('class="off')
        assert hangs > 6
        assert dots == 1 + hangs + 3 + 4 + 2  # the answer, what it hangs on; fits, exponents, measured and solid ball

    def test_nothing_from_outside(self, page: str) -> None:
        for tag, attrs in Structure(page).tags:
            for key in ("src", "href"):
                assert str(attrs.get(key, "data:")).startswith(("data:", "#")), tag
            assert not any(key.startswith("on") for key in attrs), tag
        assert not re.search(r"https?://|url\(|@import", page)

    def test_text_of_the_log_stays_text(self, page: str) -> None:
        assert "<script>alert" not in page
        assert "<img src=x" not in page
        assert "<b>3" not in page
        assert "log<1>" not in page
        assert html.escape("<script>alert('x')</script> & more") in page.replace("&#39;", "&#x27;")

    def test_order_of_the_page(self, page: str) -> None:
        headings = [words(heading) for heading in re.findall(r"<h[123][^>]*>(.*?)</h[123]>", page)]
        starts = ["Gyroscope lab report", "What the answer hangs on", "Three fits", "One run by hand", "Question 3",
                  "(a)", "(b)", "(c)", "(d)", "(e)", "The other questions", "Runs", "Effects", "Where the uncertainty",
                  "What to do better", "Diagnostics", "Method", "Provenance", "Conventions"]  # fmt: skip
        assert len(headings) == len(starts)
        assert all(heading.startswith(start) for heading, start in zip(headings, starts, strict=True))

    def test_same_log_same_page(self, analysis: Analysis, page: str) -> None:
        assert make_page(analyze(LOG.encode(), name="log<1>.csv")) == page


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


@pytest.mark.parametrize("kind", KINDS)
def test_every_number_of_the_page_is_in_results_json_and_equal(kind: str) -> None:
    analysis = analyze(KINDS[kind].encode(), name="log.csv")
    document = json.loads(reporting.json_text(analysis.to_dict()))
    page = Structure(make_page(analysis))
    assert len(page.numbers) > 40
    for attributes, text in page.numbers:
        place, expected = str(attributes["data-from"]), find(document, str(attributes["data-from"]))
        if isinstance(expected, str):
            assert attributes["value"] == text == expected, place
            continue
        value = float(str(attributes["value"]))
        assert value == expected, place
        assert shows(text, value / float(str(attributes["data-size"]))), (place, text, value)
    # And what is left holds no other number.
    left = re.sub(r"\s+", " ", page.text.replace("\xa0", " ").replace("−", "-"))
    left = re.sub(r"10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+|M0", "", left)
    for text in known(analysis):
        left = left.replace(said(text).replace("M0", ""), " ")
    assert re.findall(r"[^ ]*\d[^ ]*", left) == []


@pytest.mark.parametrize("name", plotting.FIGURES)
def test_every_number_of_an_alternative_text_is_in_results_json(name: str, analysis: Analysis) -> None:
    leaves: list[float] = []

    def gather(found: Any) -> None:
        for value in found.values() if isinstance(found, dict) else found if isinstance(found, list) else ():
            if isinstance(value, int | float) and not isinstance(value, bool):
                leaves.append(abs(value))
            gather(value)

    gather(analysis.to_dict())
    leaves += [len(analysis.torques), len(analysis.run_table), sum(not run.left_out for run in analysis.run_table)]
    text = plotting.alt_text(analysis, name).replace("± 2 standard", "").replace("95 %", "")
    text = re.sub(r"run [\w<>]+|10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", "", text)
    numbers = re.findall(r"\d+(?:\.\d+)?", text)
    assert len(numbers) > 2
    for number in numbers:
        assert any(shows(number, leaf * factor) for leaf in leaves for factor in (1, 1e2, 1e3, 30 / math.pi)), number


class TestWords:
    def test_it_says_what_the_result_says(self, analysis: Analysis, page: str) -> None:
        text = words(page)
        assert said(reporting.inertia_text(analysis.inertia.value, analysis.inertia.u)) in text
        assert analysis.sha256 in text
        texts = [
            *analysis.advice,
            *(diagnostic.message for diagnostic in analysis.diagnostics),
            *(effect.reason for effect in analysis.effects),
            *(fit.note for fit in analysis.fits),
            *(reporting.number_text(group.product, group.product_u) for group in analysis.torques),
        ]
        for told in texts:
            assert said(told) in text
        rows = re.findall(r'<tr class="flagged">(.*?)</tr>', page, re.S)
        assert len(rows) == sum(run.flagged for run in analysis.run_table) == 1
        assert "left out: fits 1 turn, not 2" in words(rows[0])

    @pytest.mark.parametrize(
        ("kind", "told"),
        [
            ("other side, heavy", ["The 3 runs agree with one line", "; the largest uncertainty is the "]),
            ("far too much scatter", ["The 6 runs do not agree with one line within what the log states"]),
            ("one run", ["There are as many unknowns as runs, so nothing tells whether they agree"]),
            (
                "one torque",
                [
                    "These runs do not tell how well the ball is balanced, and that is the largest part of u², ",
                    "If the ball is balanced as in step 2, Izz = (",
                    "All torques are equal: to settle it, write # balanced: yes, add a balance test, or time a run",
                ],
            ),
        ],
    )
    def test_below_the_answer_stands_whether_the_runs_agree_and_what_u_is_made_of(
        self, kind: str, told: list[str]
    ) -> None:
        analysis = analyze(KINDS[kind].encode(), name="log.csv")
        page, summary = words(make_page(analysis)), reporting.summary(analysis)
        for one in told:
            assert one in page.partition("What it hangs on")[0]
            assert one.replace("Izz", "I_zz") in summary.partition("What the answer hangs on")[0]
        markdown = reporting.markdown_report(analysis).replace("\\", "")
        assert told[0] in markdown.partition("## What the answer hangs on")[0]

    def test_what_not_even_u_can_save_is_said_before_the_answer(self) -> None:
        wrong = KINDS["far too much scatter"].replace("20,15,407,40.1,1", "20,15,407,60.1,1")
        law = "".join(
            f"{20 * k},15,{s},{0.0993 / k * s * (s / 400) ** 0.1:.2f},1\n" for k in (1, 2, 3) for s in (206, 407, 605)
        )
        start = "mass [g],position [cm],spin [rpm],time [s],turns\n"
        for log, why in ((wrong, "contradict each other"), (start + law, "as the spin to the power 1.1")):
            analysis = analyze(log.encode(), name="log.csv", keep_flagged=True)
            for text in (words(make_page(analysis)).partition("Gyroscope lab report")[2], reporting.summary(analysis)):
                before = re.split("I_?zz = ", text)[0]
                assert "Do not rely on this answer: " in before
                assert why in before
            for form in (reporting.markdown_report, reporting.latex_report):
                assert "Do not rely on this answer" in form(analysis).partition("95")[0]
        assert "Do not rely" not in reporting.summary(analyze(LOG.encode()))

    def test_one_torque_has_the_value_of_a_balanced_ball_in_the_result_too(self) -> None:
        analysis = analyze(KINDS["one torque"].encode())
        assert analysis.if_balanced is not None
        balanced = reporting.inertia_text(analysis.if_balanced.value, analysis.if_balanced.u)
        assert f"step 2, {said('I_zz')} = {said(balanced)}" in words(make_page(analysis))
        assert analysis.to_dict()["result"]["if_balanced"]["value"] == analysis.if_balanced.value

    @pytest.mark.parametrize(
        ("kind", "row"),
        [("far too much scatter", "unexplained scatter"), ("one torque", "balance not told by this design")],
    )
    def test_what_the_log_leaves_open_is_a_row_of_the_budget(self, kind: str, row: str) -> None:
        analysis = analyze(KINDS[kind].encode())
        assert row in words(make_page(analysis)).partition("Where the uncertainty comes from")[2]
        assert row in reporting.summary(analysis).partition("Where the uncertainty comes from")[2]

    def test_one_run_is_worked_out_by_hand(self) -> None:
        """The first one with a load that is in the fit, and each step follows from the numbers before it."""
        runs = "0,,401,160.2,1/12\n20,15,206,30.9,1\n20,15,407,13.47,1/3\n20,15,601,59.5,1\n"
        runs += "".join(f"{20 * k},15,{rpm},{0.0993 * rpm / k:.2f},1\n" for k in (2, 3) for rpm in (206, 407, 605))
        analysis = analyze(("# g: 9.803 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n" + runs).encode())
        assert [run.left_out for run in analysis.run_table[:3]] == [False, True, False]
        text = reporting.markdown_report(analysis).replace("\\", "")
        section = text.partition("## One run by hand")[2].partition("\n## ")[0]
        assert "Run 3 (line 5)" in section
        steps = re.findall(r"^- (.*)$", section, re.M)
        assert [step.split(" = ")[0] for step in steps] == ["M", "φ̇", "ψ̇", "φ̇ψ̇", "I_zz"]
        assert steps[1].startswith("φ̇ = 2π × (1/3) / 13.47 s = ")
        for step in steps:
            *_, worked, result = step.split(" = ")
            sum_ = re.sub(r" (?:rad²/s²|rad/s|m/s²|N·m|kg|rpm|rad|m|s)(?![\w·/])", "", worked).replace("×", "*")
            number = float(re.match(r"[\d.]+", result)[0]) * (1e-3 if "10⁻³" in result else 1)  # type: ignore[index]
            assert eval(sum_.replace("2π", "2*math.pi")) == pytest.approx(number, rel=5e-4), step
        assert analysis.run_table[2].inertia == pytest.approx(number, rel=2e-4)

    @pytest.mark.parametrize(
        ("kind", "steps"),
        [
            ("torques, tilted", ["M = 0.05 N·m, as the log gives it", "φ̇ = 2π × 1 / 24 s = "]),
            ("other side, heavy", ["M = m g x = 12 kg × 9.807 m/s² × -0.15 m = -17.65 N·m", "φ̇ = -2π × 1 / 160 s = -"]),
        ],
    )
    def test_other_readings_are_worked_out_too(self, kind: str, steps: list[str]) -> None:
        text = words(make_page(analyze(KINDS[kind].encode(), name="log.csv")))
        assert [step for step in steps if step not in text] == []

    def test_rates_that_the_log_gives_are_not_worked_out(self) -> None:
        head = "torque [mN*m],spin_start [rpm],spin_end [rpm],precession_rate [rad/s]\n"
        text = words(make_page(analyze((head + "30,410,400,0.16\n60,410,400,0.32\n").encode())))
        assert "φ̇ = 0.16 rad/s, as the log gives it" in text
        assert "rad/s, the mean of what was read" in text

    def test_what_the_data_do_not_answer_is_pointed_to(self, analysis: Analysis) -> None:
        page = make_page(analyze(LOG.encode(), name="lab_4.csv"))
        told = page.partition('id="others"')[2].partition("</section>")[0]
        commands = re.findall("<code>(.*?)</code>", told)
        assert "Questions 1, 2 and 4 are not in this report" in words(told)
        assert [command.split()[2] for command in commands] == ["tip", "precession", "twist", "earth", "platform"]
        assert all(command.endswith(" --log lab_4.csv") for command in commands)
        # What a shell would take apart is not written into a command.
        assert "--log LOG</code>" in make_page(analysis)

    def test_the_method_can_be_cited(self, analysis: Analysis, page: str) -> None:
        told = words(page).partition("Method and how to cite it")[2].partition("Provenance")[0]
        assert f"gyrodata, version {__version__}" in told
        assert "the 10 runs, without those marked as left out, at once, by eq. (9)" in told
        assert "without those marked" not in words(make_page(analyze(KINDS["latitude"].encode())))
        assert analysis.name in told

    def test_question_3_is_answered_from_the_data(self, page: str) -> None:
        text = words(page)
        assert "grows in proportion to the spin" in text
        assert re.search(r"τ ∝ ψ̇ⁿ with n = \d\.\d+ ± 0\.\d+ The exponent agrees with 1", text)
        assert "φ̇ψ̇ is constant within the uncertainties" in text
        assert "M + M0 = Izz φ̇ψ̇ with Izz = (" in text

    def test_question_3_says_when_the_data_do_not(self) -> None:
        text = words(make_page(analyze(KINDS["far too much scatter"].encode())))
        assert "φ̇ψ̇ is not constant within the stated uncertainties" in text
        slow = (
            LOG.replace("59.5", "75.5").replace("40.4", "46.4").replace("30.1,2", "36.1,1").replace("20.0,1", "24.0,1")
        )
        text = words(make_page(analyze(slow.encode(), keep_flagged=True)))
        assert "not in proportion within the uncertainties" in text
        assert "The exponent does not agree with 1" in text
        text = words(make_page(analyze(KINDS["one run"].encode())))
        assert "At no torque are there two different spins" in text
        assert "No torque has two runs" in text

    @pytest.mark.parametrize(
        ("lines", "expected"),
        [
            (
                "# ball_mass: 4.10 ± 0.01 kg\n# ball_diameter: 10.16 ± 0.005 cm\n",
                "does not agree with that of the ball: ",
            ),
            (
                "# ball_mass: 4.10 ± 0.30 kg\n# ball_diameter: 10.16 cm\n",
                "agrees with that of the ball: the diff",
            ),
            ("# ball_mass: 4.10 kg\n# ball_diameter: 10.16 cm\n", "(taken as exact: the log gives no uncertainty)"),
            ("", "it is compared with 2/5 m r² here"),
        ],
    )
    def test_the_ball_is_compared_where_the_log_gives_it(self, lines: str, expected: str) -> None:
        text = words(make_page(analyze((lines + KINDS["no ball"]).encode(), name="log.csv")))
        assert expected in text
        assert ("2/5 m r² = 4.232 × 10⁻³ kg·m²" in text) == ("10.16 cm\n" in lines and "±" not in lines)

    @pytest.mark.parametrize("kind", ["one torque", "one run", "torques, tilted", "other side, heavy"])
    def test_small_and_odd_logs_have_a_page_too(self, kind: str) -> None:
        page = make_page(analyze(KINDS[kind].encode(), name="log.csv"))
        assert not {"nan", "None", "inf"} & set(words(page).split())

    def test_figures_are_shown_as_what_they_are(self, analysis: Analysis) -> None:
        looks = plotting.list_looks(analysis)
        drawn = dict.fromkeys(plotting.FIGURES, b"<svg xmlns='http://www.w3.org/2000/svg'/>")
        page = reporting.report_page(analysis, drawn, "svg", WORDS, looks)
        assert page.count("data:image/svg+xml;base64,") == 4

    def test_a_torque_has_the_mark_of_the_figures(self, analysis: Analysis, page: str) -> None:
        for look in plotting.list_looks(analysis):
            assert page.count(f'fill="{look.colour}"') >= 3


# --- colours ------------------------------------------------------------------------------------------------

TEXT_ON = [
    ("ink", "paper"), ("ink", "card"), ("ink", "warn-paper"), ("soft", "paper"), ("soft", "card"), ("mark", "paper"),
    ("warn", "paper"), ("warn", "card"), ("warn", "warn-paper"),
]  # fmt: skip
SHAPES_ON = [("mark", "paper"), ("mark", "band"), ("soft", "paper")]


def channels(colour: str) -> list[float]:
    return [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]


def luminance(rgb: list[float]) -> float:
    """Relative luminance of WCAG 2.2."""
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in rgb]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: list[float], other: list[float]) -> float:
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def themes(page: str) -> dict[str, dict[str, list[float]]]:
    found = re.findall(r":root \{(.*?)\}", page)
    assert len(found) == 3
    return {
        name: {key: channels(value) for key, value in re.findall(r"--([\w-]+): (#[0-9a-f]{6})", text)}
        for name, text in zip(("light", "dark", "print"), found, strict=True)
    }


@pytest.mark.parametrize("theme", ["light", "dark", "print"])
def test_contrast_is_enough_for_all_eyes(theme: str, page: str) -> None:
    colours = themes(page)[theme]
    for text, ground in TEXT_ON:
        assert contrast(colours[text], colours[ground]) >= 4.5, (text, ground)
    for shape, ground in SHAPES_ON:
        assert contrast(colours[shape], colours[ground]) >= 3, (shape, ground)


def darkened(rgb: list[float]) -> list[float]:
    """What the dark theme's filter, invert(.91) hue-rotate(180deg), makes of a colour (W3C filter effects)."""
    rgb = [v * (1 - 2 * 0.91) + 0.91 for v in rgb]
    weights = (0.213, 0.715, 0.072)
    turned = [sum(2 * w * v for w, v in zip(weights, rgb, strict=True)) - v for v in rgb]
    return [min(max(v, 0.0), 1.0) for v in turned]


def test_figures_are_legible_in_both_themes(page: str) -> None:
    from gyrodata.plotting import INK, SOFT, choose_looks

    assert "invert(.91) hue-rotate(180deg)" in page
    white = [1.0, 1.0, 1.0]
    assert contrast(darkened(white), themes(page)["dark"]["paper"]) < 1.05
    for colour, least in [(INK, 4.5), (SOFT, 4.5), *((c, 3.0) for c, _ in choose_looks([1.0 + i for i in range(6)]))]:
        assert contrast(channels(colour), white) >= least, colour
        assert contrast(darkened(channels(colour)), darkened(white)) >= least, colour
