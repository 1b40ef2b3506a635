"""The words that students write in logs, in each language: `vocabulary.toml`."""

from __future__ import annotations

import tomllib
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


def numbers() -> dict[str, None]:
    """Return the keys that are numbers, "1" or "/3": each lists the words that say it."""
    keys = (key for section in LANGUAGES.values() for key in section)
    return dict.fromkeys(key for key in keys if key[-1].isdigit())


def pattern(key: str) -> str:
    """Return a regular expression for the words of all languages under one key.

    Upper and lower case are the same.
    """
    return f"(?i:{words(key, '|')})"
