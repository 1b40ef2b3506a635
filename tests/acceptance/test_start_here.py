"""The page START-HERE shows each package by short calls, with the outputs that they have."""

from __future__ import annotations

import doctest
import importlib
import re
from pathlib import Path
from typing import Any

import pytest
from documents import blocks
from places import PACKAGE, ROOT

TEXT = (ROOT / ".github" / "START-HERE.md").read_text(encoding="utf-8")
INTRODUCTION, *_PARTS = re.split(r"^## ", TEXT, flags=re.MULTILINE)
SECTIONS = {part.partition("\n")[0]: part for part in _PARTS}
PACKAGES = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
LONGEST = 6
"""Largest number of lines of an output: nobody predicts more."""


def calls_in(section: str, known: dict[str, Any]) -> doctest.DocTest:
    """Read the calls of a section, which can use the names that are known."""
    source = "".join(part.body for part in blocks(section) if part.kind == "pycon")
    parser = doctest.DocTestParser()
    return parser.get_doctest(source, known, section.partition("\n")[0], None, None)


def run(calls: doctest.DocTest) -> str:
    """Run calls, and describe those whose output differs; a long line may be wrapped."""
    differences: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(calls, out=differences.append, clear_globs=False)
    return "".join(differences)


def test_every_package_has_a_section() -> None:
    assert sorted(SECTIONS) == PACKAGES


@pytest.mark.parametrize("name", SECTIONS)
def test_each_call_has_the_output_of_the_page(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    known: dict[str, Any] = {"__name__": "__main__"}
    before = calls_in(INTRODUCTION, known)
    assert run(before) == ""
    calls = calls_in(SECTIONS[name], before.globs)
    outputs = [example.want for example in calls.examples if example.want]
    assert len(outputs) >= 4
    assert max(output.count("\n") for output in outputs) <= LONGEST
    assert run(calls) == ""


@pytest.mark.parametrize("name", PACKAGES)
def test_a_package_says_what_goes_in_and_out_and_what_it_never_does(name: str) -> None:
    text = importlib.import_module(f"gyrodata.{name}").__doc__ or ""
    _, opening, *_ = f"{text}\n\n".split("\n\n")
    words = " ".join(opening.split())
    assert re.search(r"\bgo(es)? in\b.*\bcomes? out\b.*\b(Nothing|never)\b", words)


def test_a_wrong_output_is_a_difference() -> None:
    calls = calls_in("page\n```pycon\n>>> 1 + 1\n3\n```\n", {})
    assert "Expected:\n    3\nGot:\n    2\n" in run(calls)
