"""The learning platforms: how they name the files of a class, and how grades go back. `platforms.toml` has the data."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path

from msgspec import Struct, convert


class Book(Struct, frozen=True):
    """The sheet of grades that a platform exports; `platforms.toml` explains the fields."""

    noun: str
    code: str
    none: str
    export: str
    begins: str = ""
    maximum: str = ""
    assignment: str = ""
    unlock: str = ""
    known_by: tuple[tuple[str, tuple[str, ...]], ...] = ()


class Platform(Struct, frozen=True):
    """How one platform names the files of a class."""

    sample: str  # name of one file, for messages
    names: tuple[str, ...] = ()  # regular expressions of a whole name
    book: Book | None = None

    def match(self, name: str) -> re.Match[str] | None:
        """Match the name of a file below the class; None if the platform does not write such names."""
        return next(filter(None, (re.fullmatch(one, name, re.DOTALL) for one in self.names)), None)


PLATFORMS: Mapping[str, Platform] = convert(
    tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")), dict[str, Platform]
)
"""All platforms by name; "folder" has no names of its own."""

NAMED = tuple(name for name, platform in PLATFORMS.items() if platform.names)
"""The platforms that are known by their names."""
