"""The words that students write in logs, in each language, and their units: `vocabulary.toml`."""

from __future__ import annotations

import tomllib
from pathlib import Path

LANGUAGES: dict[str, dict[str, str]] = tomllib.loads(
    Path(__file__).with_name("vocabulary.toml").read_text(encoding="utf-8")
)
"""The sections of the file, by language: lists of names or words by key."""
UNITS = LANGUAGES.pop("units")
"""Units by the spelling given back: SI factor, a unit that measures the same, and what students write."""
MONTHS = LANGUAGES.pop("months")
"""What the names of the months begin with, by number."""
SYMBOLS = LANGUAGES.pop("symbols")
"""Symbols by the role, or the roles, that they mean, separated by blanks."""


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
    return separator.join(section[key] for section in LANGUAGES.values() if key in section)
