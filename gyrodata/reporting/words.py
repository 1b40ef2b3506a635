"""The words of the report, in `words.toml`, and those of the sources of error."""

from __future__ import annotations

import tomllib
from pathlib import Path

from gyrodata.measurements import SOURCES
from gyrodata.physics import models

_TEXT = Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
WORDS = tomllib.loads(_TEXT)
"""Names, questions and answers in the report, by section and key."""


def source_words(name: str) -> str:
    """Return a source of uncertainty for users, by its name in the JSON."""
    if name in SOURCES:
        return SOURCES[name].words
    others = WORDS["sources"] | models.source_words()
    return str(others.get(name, name))
