"""Every regular expression that meets a text of a user takes time in proportion to its
length.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hostile_patterns import Use, slow_piece
from places import ROOT, TESTS

pytestmark = pytest.mark.skipif(os.name == "nt", reason="there are no alarms there")


def faults_of(package: str, folder: Path = ROOT) -> list[str]:
    """Try the patterns of a package in a process of its own, where `re` can be
    replaced.
    """
    done = subprocess.run(
        [sys.executable, str(TESTS / "support" / "hostile_patterns.py"), package],
        env={**os.environ, "PYTHONPATH": str(folder), "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_every_pattern_takes_linear_time() -> None:
    assert faults_of("gyrodata") == []


PLANTED = """
import re

_BLANKS = re.compile(r"\\s*$")
_WORDS = ("a", r"(?:a|a)*b")


def in_function(text):
    return re.sub(r"\\s+/", "/", text)


def compiled(text):
    return _BLANKS.search(text)


def compiled_inside(text):
    return re.compile(r"(<+)*>").sub("", text)


def in_two_lines(text):
    return re.fullmatch(
        r"(\\d+)*!", text
    )


def linear(text):
    return re.sub(r"(?<!\\s)\\s+/", "/", re.sub("[a-z]+", "", text))


def never_called(text, words):
    return re.search(words, text)


def from_data(text):
    return [
        re.match(words, text) for words in _WORDS
    ]


compiled("a")
from_data("a")
"""


def test_planted_patterns_are_found(tmp_path: Path) -> None:
    (tmp_path / "planted").mkdir()
    (tmp_path / "planted/__init__.py").write_text(PLANTED)
    faults = faults_of("planted", tmp_path)
    lines = PLANTED.splitlines()
    places = [int(re.split(":", fault)[1]) for fault in faults]
    assert [lines[place - 1].strip() for place in places] == [
        "return re.search(words, text)",
        'return re.sub(r"\\s+/", "/", text)',
        "return _BLANKS.search(text)",
        'return re.compile(r"(<+)*>").sub("", text)',
        "return re.fullmatch(",
        "re.match(words, text) for words in _WORDS",
    ]
    assert "is not reached" in faults[0]
    assert all("is slow for" in fault for fault in faults[1:])


@pytest.mark.parametrize(
    ("pattern", "method"),
    [
        # `PLANTED` has the other methods.
        (r"\w+=\S+", "findall"),
        (r"\s*,\s*", "split"),
        (rb"<[^>]*>", "finditer"),
    ],
)
def test_pattern_with_square_of_length_is_slow(
    pattern: str | bytes, method: str
) -> None:
    assert slow_piece(Use(pattern, 0, method))


@pytest.mark.parametrize(
    ("pattern", "method"),
    [
        (r"(?<!\s)\s+$", "search"),
        (r"(?:(?<!\s)\s+)?,\s*", "split"),
        (r"\[[^\[\]]*\]\(", "sub"),
        ("|".join(f"word{number}" for number in range(500)), "search"),
    ],
)
def test_linear_pattern_is_not_slow(pattern: str, method: str) -> None:
    assert slow_piece(Use(pattern, 0, method)) == ""
