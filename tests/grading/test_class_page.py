"""The page of a class: whole, escaped, and saying what the grades say."""

from __future__ import annotations

import html
import json
import math
import re
import shutil
import subprocess
from collections.abc import Sequence
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from gyrodata.grading import ClassGrades, Flag, Grade, Reference, Submission, Submissions, class_page, default_rubric
from gyrodata.grading.exports.class_page import LEFT, RIGHT, WIDTH, Drawing, draw_distribution

EXPECTED = Path(__file__).parent / "expected"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
GOOD, SLIP, WAITING = (
    Grade.from_dict(json.loads((EXPECTED / f"{name}.json").read_text(encoding="utf-8")))
    for name in ("good", "slip", "waiting")
)
REFERENCE = Reference(4.44e-3, 0.02e-3, "the rubric")
EVIL = '<script>alert("x")</script>'


def a_class(grades: Sequence[Grade], flags: Sequence[Flag] = ()) -> ClassGrades:
    items = tuple(Submission(one.student, one.name, {"canvas": one.student}, Path("class")) for one in grades)
    return ClassGrades(
        "class", Submissions("canvas", items), default_rubric(), tuple(grades), {"all": REFERENCE}, tuple(flags), {}, {}
    )


def three() -> ClassGrades:
    grades = [replace(GOOD, student="g", name="Good"), replace(SLIP, student="s", name="Slip"),
              replace(WAITING, student="w", name="Waiting")]  # fmt: skip
    return a_class(grades, [Flag("shared rows", ("g", "s"), "9 of 9 rows", 1e-9, 1e-8)])


def page_of(found: ClassGrades) -> str:
    return "".join(class_page(found, lambda student: f"feedback/{student}.html"))


class Structure(HTMLParser):
    """Tags in order, each closed; the text of the table cells."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag != "meta":
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_structure_is_sound_and_nothing_comes_from_outside() -> None:
    page = page_of(three())
    tags = Structure(page).tags
    assert [tag for tag, _ in tags].count("h1") == 1
    assert all(attributes.get("scope") for tag, attributes in tags if tag == "th")
    assert {attributes["href"] for tag, attributes in tags if tag == "a"} == {
        "feedback/g.html", "feedback/s.html", "feedback/w.html"
    }  # fmt: skip
    assert not any(key.startswith("on") or key == "src" for _, attributes in tags for key in attributes)
    assert not re.search(r"https?://|url\(|@import", page)


def test_it_says_what_the_grades_say() -> None:
    found = three()
    text = html.unescape(re.sub(r"<[^>]+>", " ", page_of(found)))
    text = " ".join(text.split())
    assert "3 submissions: 2 graded, 1 not" in text
    assert found.mean == pytest.approx((GOOD.points + SLIP.points) / 2, abs=1e-4)  # type: ignore[operator]
    assert f"Mean {found.mean:.2f}" in text
    assert f"Waiting : Could not be graded: {WAITING.why}" in text
    assert "Good : Flag: shared rows with Slip (s)." in text
    assert "9 of 9 rows." in text
    for slip in SLIP.slips[:1]:
        assert slip.words[1:] in text
    for one in found.criteria():
        assert f"{one.title} {'–' if one.mean is None else f'{one.mean:.2f}'} " in text


def test_statistics_of_the_criteria() -> None:
    found = three()
    for at, one in enumerate(found.criteria()):
        points = [grade.marks[at].points for grade in found.grades if grade.marks[at].points is not None]
        assert one.judged == len(points)
        assert (one.full, one.none) == (sum(p == one.out_of for p in points), sum(p == 0 for p in points))
        assert one.mean == (round(math.fsum(p for p in points if p is not None) / len(points), 4) if points else None)


@pytest.mark.parametrize("evil", [EVIL, "</title><b>", "{{ 7 * 7 }}", "\u202egnp.exe", "a\x00b\x1b[31m"])
def test_names_and_reasons_stay_text(evil: str) -> None:
    grades = [
        replace(GOOD, student=evil, name=evil, title=evil, late_reason=evil, look=(evil,)),
        replace(WAITING, student="w", name=evil, why=evil),
    ]
    found = a_class(grades, [Flag("shared rows", (evil, "w"), evil, 1e-9, 1e-8, (evil,))])
    page = page_of(replace(found, source=evil))
    Structure(page)
    for bad in ("<script>alert", "</title><b>", "\u202e", "\x00", "\x1b", " 49 "):
        assert bad not in page


def test_nobody_graded() -> None:
    page = page_of(a_class([replace(WAITING, student="w")]))
    Structure(page)
    assert "1 submission: 0 graded, 1 not" in page
    assert "I_zz in this class" not in page


def brightness(colour: str) -> float:
    """Relative luminance (WCAG 2.2)."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_contrast_in_both_themes() -> None:
    themes = re.findall(r":root \{(.*?)\}", page_of(three()))
    assert len(themes) == 3
    for theme in themes:
        colours = {name: brightness(colour) for name, colour in re.findall(r"--([\w-]+): (#\w{6})", theme)}
        pairs = [("ink", "paper", 4.5), ("soft", "paper", 4.5), ("mark", "paper", 4.5), ("ink", "warn-paper", 4.5),
                 ("mark", "warn-paper", 4.5), ("warn", "paper", 3), ("other", "paper", 3), ("ink", "band", 3),
                 ("mark", "band", 3), ("other", "band", 3)]  # fmt: skip
        for one, other, least in pairs:
            low, high = sorted((colours[one], colours[other]))
            assert (high + 0.05) / (low + 0.05) >= least, (one, other)


# --- the distribution ---------------------------------------------------------------------------------------


def drawn(values: Sequence[float], reported: Sequence[float | None]) -> Drawing | None:
    grades = [
        replace(GOOD, student=str(i), inertia=value, station="3", reported={} if told is None else {"value": told})
        for i, (value, told) in enumerate(zip(values, reported, strict=True))
    ]
    return draw_distribution(grades, {"all": REFERENCE})


INERTIAS = st.floats(1e-6, 1e3)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(INERTIAS, st.none() | st.floats(-1e6, 1e6)), min_size=1, max_size=30))
def test_everybody_is_in_a_bar_or_counted_beside(pairs: list[tuple[float, float | None]]) -> None:
    drawing = drawn([own for own, _ in pairs], [told for _, told in pairs])
    assert drawing is not None
    for strip in drawing.strips:
        for side, count in ((strip.own, len(pairs)), (strip.reported, sum(told is not None for _, told in pairs))):
            inside = sum(int(bar.words.split(" ")[0]) for bar in side.bars)
            assert inside + len(side.below) + len(side.above) == side.number == count
            for bar in side.bars:
                assert LEFT <= bar.x <= bar.x + bar.width <= WIDTH - RIGHT + 0.2
                assert 0 <= bar.y <= bar.y + bar.height <= drawing.height
    assert 1 <= len(drawing.ticks) <= 8


def test_slips_do_not_squeeze_the_class() -> None:
    values = [4.40e-3, 4.42e-3, 4.44e-3, 4.45e-3, 4.48e-3]
    drawing = drawn(values, [4.44e-3, 4.2e-2, 4.45, None, -4.4e-3])
    assert drawing is not None
    (strip,) = drawing.strips
    assert len(strip.own.bars) >= 4
    assert (strip.reported.below, strip.reported.above) == (("4",), ("1", "2"))
    assert "3 of those reported off the axis" in drawing.words
    assert strip.band is not None
    left, middle, right = strip.band
    assert middle - left == pytest.approx(right - middle, abs=0.2)


def test_each_station_with_a_reference_has_its_own_strip() -> None:
    grades = [replace(GOOD, student=str(i), station=str(i % 2), inertia=4.4e-3 + 1e-5 * i) for i in range(10)]
    drawing = draw_distribution(grades, {"0": REFERENCE, "1": REFERENCE, "all": REFERENCE})
    assert drawing is not None
    assert [strip.label for strip in drawing.strips] == ["station 0", "station 1"]
    many = {str(i): REFERENCE for i in range(13)}
    grades = [replace(GOOD, student=key, station=key) for key in many]
    drawing = draw_distribution(grades, many)
    assert drawing is not None
    assert [strip.label for strip in drawing.strips] == ["all"]


# --- in a browser -------------------------------------------------------------------------------------------

PROBE = """<script>
addEventListener("load", () => {
  const frame = document.querySelector("iframe"), page = frame.contentDocument;
  const table = page.querySelector("table.everybody"), heads = [...table.tHead.rows[0].cells];
  const sort = i => {
    heads[i].querySelector("button").click();
    return [...table.tBodies[0].rows].map(r => r.cells[0].textContent.trim());
  };
  const out = {
    wide: page.documentElement.scrollWidth, inner: frame.clientWidth, up: sort(1), down: sort(1), names: sort(0),
    aria: heads.map(h => h.getAttribute("aria-sort")).slice(0, 2)};
  const place = document.createElement("pre");
  place.id = "out"; place.textContent = JSON.stringify(out); document.body.append(place);
});
</script>"""


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine")
def test_on_a_phone_nothing_is_cut_and_the_table_sorts(tmp_path: Path) -> None:
    assert CHROMIUM is not None
    frame = f'<iframe style="width:360px;height:800px;border:0" srcdoc="{html.escape(page_of(three()))}"></iframe>'
    probe = tmp_path / "probe.html"
    probe.write_text(f"<!doctype html><meta charset=utf-8><body>{PROBE}{frame}</body>", "utf-8")
    run = subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
         f"--user-data-dir={tmp_path / 'profile'}", "--enable-logging=stderr", "--virtual-time-budget=5000",
         "--dump-dom", probe.as_uri()],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    found = re.search(r'<pre id="out">(.*?)</pre>', run.stdout, re.DOTALL)
    assert found, run.stderr[-2000:]
    out = json.loads(html.unescape(found[1]))
    assert out["wide"] <= out["inner"] == 360
    assert out["up"] == ["Slip", "Good", "Waiting"], "blank ones last"
    assert out["down"] == ["Good", "Slip", "Waiting"]
    assert out["names"] == ["Good", "Slip", "Waiting"]
    assert out["aria"] == ["ascending", None]
    assert "CONSOLE" not in run.stderr
