"""What is decided about reports and classes of every kind, to the digit and the word."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import zip_longest
from pathlib import Path

import pytest
from golden import NUMBER
from grading import alike, handed, judged, whole_class

EXPECTED = Path(__file__).parent / "expected"


def assert_as_before(found: Iterable[str], name: str, first: int = 0, step: int = 1) -> None:
    """Compare scene by scene with a golden text, or every so manieth; `make_feedback.py` writes it anew."""
    expected = re.split("(?m)^(?=== )", (EXPECTED / name).read_text(encoding="utf-8"))[1:][first::step]
    for one, other in zip_longest(found, expected, fillvalue="no more"):
        for line, before in zip_longest(one.splitlines(), other.splitlines(), fillvalue="no more"):
            if line == before:
                continue
            told = one.partition("\n")[0]
            assert NUMBER.sub("№", line) == NUMBER.sub("№", before), told
            # As far as every processor gives them.
            numbers = [[float(number) for number in NUMBER.findall(text)] for text in (line, before)]
            assert numbers[0] == pytest.approx(numbers[1], rel=1e-7, abs=1e-12), told


@pytest.mark.parametrize("first", range(8))
def test_every_report_is_judged_as_before(first: int, tmp_path: Path) -> None:
    assert_as_before(judged.judged(tmp_path, first, 8), "judged.txt", first, 8)


def test_what_gradescope_shows_is_as_before(tmp_path: Path) -> None:
    assert_as_before(judged.handed_back(tmp_path), "handed_back.txt")


def test_every_class_is_settled_as_before(tmp_path: Path) -> None:
    assert_as_before(judged.classes(tmp_path), "settled.txt")


@pytest.mark.parametrize("first", range(3))
def test_what_is_alike_is_found_as_before(first: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def patch(name: str, value: object) -> None:
        monkeypatch.setattr(f"gyrodata.grading.forensics.{name}", value)

    assert_as_before(alike.told(patch, first, 3), "alike.txt", first, 3)


def test_every_class_of_files_is_found_as_before(tmp_path: Path) -> None:
    assert_as_before(handed.classes(tmp_path), "classes.txt")


def test_every_sheet_is_filled_as_before() -> None:
    assert_as_before(handed.sheets(), "sheets.txt")


def test_every_desk_and_answer_is_read_as_before() -> None:
    assert_as_before(handed.desks(), "desks.txt")


def test_a_class_in_which_everything_happens_is_told_as_before(tmp_path: Path) -> None:
    assert_as_before(whole_class.at_first(tmp_path), "at_first.txt")


def test_a_class_that_is_decided_on_is_told_as_before(tmp_path: Path) -> None:
    assert_as_before(whole_class.decided_on(tmp_path), "decided_on.txt")
