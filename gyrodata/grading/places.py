"""Where the keys of a TOML file stand: `tomllib` gives values without their lines."""

from __future__ import annotations

import re
from typing import NamedTuple

Path = tuple[str | int, ...]
"""Keys from the top; an array of tables has the number of the table, from 0, after its name."""

_PART = r"(?:\"[^\"\n]*\"|'[^'\n]*'|[\w-]+)"
_DOTTED = rf"{_PART}(?:\s*\.\s*{_PART})*"
_HEADER = re.compile(rf"(\s*)(\[\[?)\s*({_DOTTED})\s*\]{{1,2}}")
_KEY = re.compile(rf"(\s*)({_DOTTED})\s*=")
_TOKEN = re.compile(r"\"\"\"|'''|\"(?:\\.|[^\"\\])*\"|'[^']*'|#.*|[\[\]{}]")


class Spot(NamedTuple):
    """Where something stands, counted as an editor counts."""

    line: int
    column: int
    width: int


def find_places(text: str) -> dict[Path, Spot]:
    """Find every table and key of a TOML file.

    Gives: From path to place. Keys of inline tables are not in it; their table is.
    """
    places: dict[Path, Spot] = {}
    count: dict[Path, int] = {}
    table: Path = ()
    closing, depth = "", 0
    for number, line in enumerate(text.split("\n"), 1):
        if closing or depth:
            closing, depth = _inside(line, closing, depth)
            continue
        if header := _HEADER.match(line):
            table = _resolve(_split(header[3]), count)
            if header[2] == "[[":
                count[table] = count.get(table, -1) + 1
                table = (*table, count[table])
            places[table] = Spot(number, len(header[1]) + 1, len(header[0]) - len(header[1]))
            continue
        if key := _KEY.match(line):
            spot = Spot(number, len(key[1]) + 1, len(key[2]))
            parts = _split(key[2])
            for length in range(1, len(parts) + 1):
                places.setdefault((*table, *parts[:length]), spot)
            closing, depth = _inside(line[key.end() :], closing, depth)
    return places


def _split(dotted: str) -> Path:
    return tuple(part.strip("\"'") for part in re.findall(_PART, dotted))


def _resolve(path: Path, count: dict[Path, int]) -> Path:
    """Give ``[late.x]`` below ``[[late]]`` the number of its table."""
    resolved: Path = ()
    for part in path[:-1]:
        resolved = (*resolved, part)
        if resolved in count:
            resolved = (*resolved, count[resolved])
    return (*resolved, path[-1])


def _inside(line: str, closing: str, depth: int) -> tuple[str, int]:
    """Follow a value that goes on over lines: the quotes that end it, or the number of open brackets."""
    position = 0
    while True:
        if closing:
            end = line.find(closing, position)
            if end < 0:
                return closing, depth
            position, closing = end + 3, ""
        token = _TOKEN.search(line, position)
        if token is None:
            return "", max(depth, 0)
        position = token.end()
        if token[0] in ('"""', "'''"):
            closing = token[0]
        elif token[0] in "[{":
            depth += 1
        elif token[0] in "]}":
            depth -= 1
