"""What a student reads: three stored texts, and nothing from outside that a page or Markdown would obey."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from grading.reports import three_grades
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from gyrodata.grading import Grade, feedback_html, feedback_markdown, points_text

EXPECTED = Path(__file__).parent / "expected"
GRADES = three_grades()
BY_NAME = pytest.mark.parametrize("name", GRADES)


class Page(HTMLParser):
    """Tags with their attributes and the text of a page; each tag is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "img", "input"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@BY_NAME
def test_feedback_in_markdown_is_the_stored_text(name: str) -> None:
    """After an intended change, write the new text into the file in ``expected``."""
    assert feedback_markdown(GRADES[name]) == (EXPECTED / f"{name}.md").read_text(encoding="utf-8")


@BY_NAME
def test_page_and_markdown_state_the_same_points(name: str) -> None:
    page, text = Page(feedback_html(GRADES[name])).text, feedback_markdown(GRADES[name])
    for mark in GRADES[name].marks:
        if mark.points is not None:
            told = f"{points_text(mark.points)} of {points_text(mark.out_of)}"
            assert told in page
            assert told in text
    assert ("Not graded yet" in page) == (name == "waiting") == ("of 20 points" not in page)


@BY_NAME
def test_page_needs_no_other_file_and_runs_nothing(name: str) -> None:
    text = feedback_html(GRADES[name], {"torque": (b"\x89PNG1", "a line"), "period": (b"\x89PNG2", "")})
    tags = Page(text).tags
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in tags}
    sources = [value for _, one in tags for key, value in one.items() if key in ("src", "href")]
    assert [(source or "").split(";")[0] for source in sources] == ["data:image/png"] * 2
    assert "default-src 'none'" in text
    assert "prefers-color-scheme: dark" in text
    assert "a line" in [one.get("alt") for _, one in tags]


@settings(max_examples=40, deadline=None)
@given(st.text(max_size=60))
def test_page_obeys_nothing_from_outside(text: str) -> None:
    hostile = _with_everywhere(GRADES["slip"], text + "<img src=x onerror=alert(1)>\"'&</td>{{ 7*7 }}")
    page = Page(feedback_html(hostile))
    plain = Page(feedback_html(_with_everywhere(GRADES["slip"], "x")))
    assert [tag for tag, _ in page.tags] == [tag for tag, _ in plain.tags]
    assert "49" not in page.text or "49" in text


@settings(max_examples=60, deadline=None)
@given(st.text(alphabet="`*_[]()<>#|~$&:/!\\-\n\r\t\u202e\u2028 ax", max_size=40))
def test_markdown_obeys_nothing_from_outside(text: str) -> None:
    before = feedback_markdown(_with_everywhere(GRADES["slip"], "x"))
    after = feedback_markdown(_with_everywhere(GRADES["slip"], f"x{text}x"))
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
