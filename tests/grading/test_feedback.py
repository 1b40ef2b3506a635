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


@pytest.mark.parametrize("name", GRADES)
def test_feedback_is_the_stored_text_and_the_page_agrees(name: str) -> None:
    """After an intended change, write the new text into the file in ``expected``."""
    assert feedback_markdown(GRADES[name]) == (EXPECTED / f"{name}.md").read_text(encoding="utf-8")
    text = feedback_html(GRADES[name], {"torque": (b"\x89PNG1", "a line"), "period": (b"\x89PNG2", "")})
    page = Page(text)
    for mark in GRADES[name].marks if name != "waiting" else ():
        assert f"{points_text(mark.points)} of {points_text(mark.out_of)}" in page.text
    assert ("Not graded yet" in page.text) == (name == "waiting") == ("of 20 points" not in page.text)
    assert not {"script", "link", "iframe", "object"} & {tag for tag, _ in page.tags}
    sources = [str(value) for _, one in page.tags for key, value in one.items() if key in ("src", "href")]
    assert [source.split(";")[0] for source in sources] == ["data:image/png"] * 2, "it needs no other file"
    assert "a line" in [one.get("alt") for _, one in page.tags]
    assert "default-src 'none'" in text
    assert "prefers-color-scheme: dark" in text


def with_everywhere(text: str) -> Grade:
    """Put a text wherever one comes from a student, a platform or a rubric."""
    grade = GRADES["slip"]
    marks = tuple(replace(mark, title=text, reason=f"{text} {i}", rule=text) for i, mark in enumerate(grade.marks))
    told = tuple({**one, "message": text, "hint": text} for one in grade.diagnostics)
    reported = {**grade.reported, "text": text}
    return replace(grade, name=text, title=text, late_reason=text, reported=reported, marks=marks, diagnostics=told)


@settings(max_examples=40, deadline=None)
@given(st.text(max_size=60))
def test_page_obeys_nothing_from_outside(text: str) -> None:
    page = Page(feedback_html(with_everywhere(text + "<img src=x onerror=alert(1)>\"'&</td>{{ 7*7 }}")))
    assert [tag for tag, _ in page.tags] == [tag for tag, _ in Page(feedback_html(with_everywhere("x"))).tags]
    assert "49" not in page.text or "49" in text


@settings(max_examples=60, deadline=None)
@given(st.text(alphabet="`*_[]()<>#|~$&:/!\\-\n\r\t\u202e\u2028 ax", max_size=40))
def test_markdown_obeys_nothing_from_outside(text: str) -> None:
    before, after = feedback_markdown(with_everywhere("x")), feedback_markdown(with_everywhere(f"x{text}x"))
    assert after.count("\n") == before.count("\n")
    assert re.findall(r"(?m)^#+ ", after) == re.findall(r"(?m)^#+ ", before)
    assert "<" not in after
    for line, plain in zip(after.splitlines(), before.splitlines(), strict=True):
        bare = re.sub(r"\\[\\`*_\[\]|~$]", "", line)
        assert not re.search(r"\]\(|`", bare)
        assert not plain.startswith("|") or bare.count("|") == plain.replace(r"\|", "").count("|")
        assert not {"\u202e", "\u2028", "\t"} & set(line)
