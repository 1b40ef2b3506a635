"""The words that students write in logs, in each language: `vocabulary.toml`."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Any

_SECTIONS = tomllib.loads(
    Path(__file__).with_name("vocabulary.toml").read_text(encoding="utf-8")
)
KINDS: dict[str, Any] = _SECTIONS.pop("kinds")
"""The fields of each kind of quantity."""
ROLES: dict[str, Any] = _SECTIONS.pop("roles")
"""The fields of each role."""
CONSTANTS: dict[str, str] = _SECTIONS.pop("constants")
"""The kind of each constant of a log that is not a role."""
LINES: dict[str, Any] = _SECTIONS.pop("lines")
"""The other keys of ``# key: value``: a sample of several quantities, or words and a
hint."""
MONTHS: dict[str, str] = _SECTIONS.pop("months")
"""What the names of the months begin with, by number."""
SYMBOLS: dict[str, str] = _SECTIONS.pop("symbols")
"""Symbols by the role, or the roles, that they mean, separated by blanks."""
NO_NUMBER: list[dict[str, str]] = _SECTIONS.pop("no_number")
"""Messages for texts in the place of a number, and what to type."""
WAYS: dict[str, list[list[str]]] = _SECTIONS.pop("ways")
"""Ways of writing a unit or a number of turns, as regular expressions, each with the
usual way."""
LANGUAGES: dict[str, dict[str, str]] = _SECTIONS
"""The other sections of the file, by language: lists of names or words by key."""


def words(key: str, separator: str = " ") -> str:
    """Join what all languages list under one key.

    Parameters
    ----------
    key : str
        A role, two roles that share names, or a list of words such as "mean".
    separator : str
        "," between names that may contain blanks.

    Returns
    -------
    str
        Empty if no language has the key.
    """
    return separator.join(
        section[key] for section in LANGUAGES.values() if key in section
    )


def single_words(key: str) -> list[str]:
    """List the single words of all languages under one key.

    Blanks or commas are between them.
    """
    return words(key).replace(",", " ").split()


def numbers() -> dict[str, None]:
    """Return the keys that are numbers, "1" or "/3", with the words for each."""
    keys = chain.from_iterable(LANGUAGES.values())
    return dict.fromkeys(key for key in keys if key[-1].isdigit())


def phrases(key: str) -> list[str]:
    """Return what all languages list under one key, between commas."""
    return [phrase.strip() for phrase in words(key, ",").split(",") if phrase]


def pattern(key: str) -> str:
    """Return a regular expression for the phrases of all languages under one key."""
    return pattern_of(phrases(key))


def pattern_of(phrases: Iterable[str]) -> str:
    """Return a regular expression for some phrases.

    A phrase begins where a word begins, and up to two small words may stand between
    its words; a single word may stand inside of a longer one. A last word of up to
    three letters, or with a dot behind it, is a whole word. Upper and lower case are
    the same.
    """
    at_start = [_NEVER]
    anywhere = [_NEVER]
    for phrase in phrases:
        words_of_it = phrase.removesuffix(".").split()
        is_whole = _is_whole(phrase)
        form = _BETWEEN.join(map(re.escape, words_of_it)) + (_END if is_whole else "")
        has_start = phrase[0].isalpha() and (is_whole or len(words_of_it) > 1)
        (at_start if has_start else anywhere).append(form)
    return rf"(?i:(?<!\w)(?:{'|'.join(at_start)})|{'|'.join(anywhere)})"


def _is_whole(phrase: str) -> bool:
    """Return whether the last word of a phrase is a whole word."""
    last = phrase.split()[-1]
    is_short = len(last) <= 3 and last.isalpha() and last < _FIRST_WITHOUT_WORDS
    return phrase.endswith(".") or is_short


_NEVER = "(?!)"
_END = r"(?!\w)"
_BETWEEN = r"\W{1,4}(?:\w{1,4}\W{1,4}){0,2}"
_FIRST_WITHOUT_WORDS = "\u0590"
"""From this letter on, words are joined to others, or have no blanks between them."""


def expression(key: str) -> str:
    """Return what all languages list as regular expressions: the words for a turn."""
    return f"(?i:{words(key, '|')})"
