"""The page: whole, self-contained, escaped, legible, and saying what the result says."""

from __future__ import annotations

import html
import json
import math
import re
from html.parser import HTMLParser
from itertools import pairwise
from typing import Any

import pytest
from pages import HEAD, LOG, WORDS, make_page

from gyrodata import analyze, plotting, reporting
from gyrodata.reporting.phrases import defaults_used
from gyrodata.results import Analysis

VOID = {"meta", "img", "br", "hr", "input", "link", "path"}


class Structure(HTMLParser):
    """Tags in order, with a check that every one is closed; numbers marked and other text apart."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.numbers: list[tuple[dict[str, str | None], str]] = []
        self.text = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag == "data":
            self.numbers.append((dict(attrs), ""))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "data" in self.open:
            attributes, text = self.numbers[-1]
            self.numbers[-1] = attributes, text + data
        elif not {"style", "script", "q", "title"} & set(self.open):
            self.text += data

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))


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
        starts = ["Gyroscope lab report", "What the answer hangs on", "Three fits", "Question 3", "(a)", "(b)", "(c)",
                  "(d)", "(e)", "Runs",
                  "Effects", "Where the uncertainty", "What to do better", "Diagnostics", "Provenance",
                  "Conventions"]  # fmt: skip
        assert len(headings) == len(starts)
        assert all(heading.startswith(start) for heading, start in zip(headings, starts, strict=True))

    def test_same_log_same_page(self, analysis: Analysis, page: str) -> None:
        assert make_page(analyze(LOG.encode(), name="log<1>.csv")) == page


def find(document: dict[str, Any], place: str) -> Any:
    """What stands at a place of results.json, as the page gives it."""
    found: Any = document if place.startswith("/") else document["result"]
    for key in place.removeprefix("/").split("."):
        if isinstance(found, list) and key == "length":
            return len(found)
        found = found[int(key) if isinstance(found, list) else key]
    return found


def strings(found: Any) -> list[str]:
    """Every text in a document."""
    if isinstance(found, dict):
        return [*found, *(text for value in found.values() for text in strings(value))]
    if isinstance(found, list):
        return [text for value in found for text in strings(value)]
    return [found] if isinstance(found, str) else []


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


# What the page says of itself and of the laws, whatever the log.
FIXED = [
    "Question 3", "3 (a)", "95 %", "2/5", "± 2 u", "± 2u", "eq. (9)", "eq. (8)", "100 rpm", "SHA-256", "n = 1",
    "with 1", "2π", "taken as 0", "as in step 2", "5 % of the torque, moves it by 5 %", "ball_mass: 4.10 ± 0.01 kg",
    "ball_diameter: 10.16 ± 0.01 cm",
]  # fmt: skip

KINDS = {
    "ball and a slip": LOG,
    "no ball": HEAD + LOG.partition(HEAD)[2],
    "one torque": "# g: 9.81 m/s^2\nmass [g],position [cm],spin [rpm],time [s],turns\n"
    "165,7.3,308,6.8,1\n165,7.3,500,11,1\n",
    "latitude": "# latitude: 42.5 deg\nmass [g],position [cm],spin [rpm],time [s],turns\n20,15,406,40.1,1\n"
    "40,15,405,20.5,1\n60,15,404,13.7,1\n",
    "one run": "mass [g],position [cm],spin [rpm],time [s],turns\n50,15,400,16.0,1\n",
    "torques, tilted": "torque [N*m],spin [rpm],time [s],turns,pitch [deg]\n0.05,400,24.0,1,10\n0.1,400,12.0,1,20\n"
    "0.1,600,17.6,1,-15\n",
    "far too much scatter": "# g: 9.803 m/s^2\n# u_time: 0.01 s\nmass [g],position [cm],spin [rpm],time [s],turns\n"
    "20,15,206,20.9,1\n20,15,407,40.1,1\n40,15,405,20.5,1\n40,15,607,29.8,1\n60,15,404,13.7,1\n60,15,603,19.8,1\n",
    "other side, heavy": "mass [kg],position [cm],spin [rpm],time [s],turns,note\n12,-15,400,160.0,1,9\n"
    "24,-15,400,80.3,1,\n24,-15,800,160.9,1,\n",
}


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
    quoted = [said(text).replace("M0", "") for text in strings(document) if len(text) > 3]
    known = sorted({*quoted, *FIXED}, key=len, reverse=True)
    for text in known:
        if re.search(r"\d", text):
            left = left.replace(text, " ")
    for default in defaults_used(analysis):
        left = left.replace(default.strip(), " ")
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
