"""What a student reads: golden texts, and nothing from outside that a page or Markdown would obey."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import convert
from msgspec.structs import replace

from gyrodata.grading import Grade, feedback_html, feedback_markdown, points_text

EXPECTED = Path(__file__).parent / "expected"
NAMES = sorted(path.stem for path in EXPECTED.glob("*.json"))


def stored(name: str) -> Grade:
    return convert(json.loads((EXPECTED / f"{name}.json").read_text(encoding="utf-8")), Grade)


class Page(HTMLParser):
    """Tags, attributes and text of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.mark.parametrize("name", NAMES)
def test_golden_markdown(name: str) -> None:
    assert feedback_markdown(stored(name)) == (EXPECTED / f"{name}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_golden_page(name: str) -> None:
    assert feedback_html(stored(name)) == (EXPECTED / f"{name}.html").read_text(encoding="utf-8")


def test_there_is_one_for_each_outcome() -> None:
    assert NAMES == ["good", "slip", "waiting"]
    assert [stored(name).status for name in NAMES] == ["graded", "graded", "not graded"]


class TestWhatItSays:
    def test_the_slip_and_how_to_check_it(self) -> None:
        text = feedback_markdown(stored("slip"))
        assert "The spin in rpm was used as if it were in rad/s." in text
        assert "2π/60 × rpm" in text
        assert "It cost 3 points, once" in text

    def test_a_waiting_student_is_not_told_zero(self) -> None:
        for text in (feedback_markdown(stored("waiting")), feedback_html(stored("waiting"))):
            assert "Not graded yet" in text
            assert "0 of" not in text

    @pytest.mark.parametrize("name", NAMES)
    def test_both_forms_say_the_same(self, name: str) -> None:
        grade = stored(name)
        page, text = Page(feedback_html(grade)).text, feedback_markdown(grade)
        for mark in grade.marks:
            if mark.points is not None:
                told = f"{points_text(mark.points)} of {points_text(mark.out_of)}"
                assert told in page
                assert told in text

    @pytest.mark.parametrize(("points", "text"), [(6.0, "6"), (4.35, "4.35"), (0.0, "0"), (10.0, "10"), (None, "–")])
    def test_points(self, points: float | None, text: str) -> None:
        assert points_text(points) == text


class TestThePage:
    @pytest.mark.parametrize("name", NAMES)
    def test_needs_nothing_else_and_runs_nothing(self, name: str) -> None:
        text = feedback_html(stored(name), {"torque": (b"\x89PNG1", "a line"), "period": (b"\x89PNG2", "")})
        page = Page(text)
        assert page.open == []
        assert not {"script", "link", "iframe", "object"} & set(page.tags)
        sources = [value for key, value in page.attributes if key in ("src", "href")]
        assert [(source or "").split(";")[0] for source in sources] == ["data:image/png"] * 2
        assert "default-src 'none'" in text
        assert "prefers-color-scheme: dark" in text
        assert ("alt", "a line") in page.attributes

    @settings(max_examples=40, deadline=None)
    @given(st.text(max_size=60))
    def test_obeys_nothing_that_comes_from_outside(self, text: str) -> None:
        hostile = _with_everywhere(stored("slip"), text + "<img src=x onerror=alert(1)>\"'&</td>{{ 7*7 }}")
        plain = Page(feedback_html(_with_everywhere(stored("slip"), "x")))
        page = Page(feedback_html(hostile))
        assert page.tags == plain.tags
        assert page.open == []
        assert "49" not in page.text or "49" in text


class TestMarkdown:
    @settings(max_examples=60, deadline=None)
    @given(st.text(alphabet="`*_[]()<>#|~$&:/!\\-\n\r\t\u202e\u2028 ax", max_size=40))
    def test_obeys_nothing_that_comes_from_outside(self, text: str) -> None:
        before = feedback_markdown(stored("slip"))
        after = feedback_markdown(_with_everywhere(stored("slip"), f"x{text}x"))
        assert after.count("\n") == before.count("\n")
        assert re.findall(r"(?m)^#+ ", after) == re.findall(r"(?m)^#+ ", before)
        assert "<" not in after
        for line, plain in zip(after.splitlines(), before.splitlines(), strict=True):
            bare = re.sub(r"\\[\\`*_\[\]|~$]", "", line)
            assert "](" not in bare
            assert "`" not in bare
            if plain.startswith("|"):
                assert bare.count("|") == re.sub(r"\\\|", "", plain).count("|")
            assert not {"\u202e", "\u2028", "\t"} & set(line)


def _with_everywhere(grade: Grade, text: str) -> Grade:
    """Put a text wherever one comes from a student, a platform or a rubric."""
    return replace(
        grade,
        name=text,
        title=text,
        late_reason=text,
        reported={**grade.reported, "text": text},
        marks=tuple(replace(mark, title=text, reason=f"{text} {i}", rule=text) for i, mark in enumerate(grade.marks)),
        diagnostics=tuple({**one, "message": text, "hint": text} for one in grade.diagnostics),
    )
