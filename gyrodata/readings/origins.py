"""Where positions count from: the centre of the ball, its surface, or the tip."""

from __future__ import annotations

import re
from typing import Literal

from gyrodata.quantities import vocabulary
from gyrodata.readings.words import (
    CENTRE_WORDS,
    MAX_HEADER,
    Phrases,
    squeeze,
    squeezed_words,
)

FROM = vocabulary.pattern("from")
"""Words between a length and its origin."""
BEHIND_FROM = rf"\b{FROM}\b((?:\W+[\w']+){{1,5}})"
_WEIGHT_NAMES = [
    name.strip()
    for name in vocabulary.words("mass", ",").split(",")
    if " " not in name.strip()
]
_WEIGHT_NAME = "|".join(name for name in _WEIGHT_NAMES if len(name) > 3)
CENTRE = r"(?i)cent(?:re|er)|mittel|Mitte|центр|środk"
OF_WEIGHT = (
    rf"(?i)(?:{CENTRE[4:]})\w*\W+(?:\w+\W+){{0,2}}?(?:{_WEIGHT_NAME})"
    rf"|{vocabulary.pattern('not_centre')}"
)
"""The centre of the weight, or what is not the origin."""
Origin = Literal["", "centre", "surface", "tip"]
ORIGINS: tuple[tuple[Origin, Phrases], ...] = (
    ("surface", Phrases("surface")),
    ("tip", Phrases("tip")),
)


def origin_in(header: str) -> Origin:
    """Return the origin of positions if a header names it; else "".

    The origin is the "surface" of the ball or the "tip" of the rod.
    """
    if len(header) > MAX_HEADER or re.search(CENTRE, re.sub(OF_WEIGHT, "", header)):
        return ""
    return next((origin for origin, words in ORIGINS if words.is_in(header)), "")


def without_origin(name: str) -> str:
    """Return a name without the origin at its end, as in "pos. from ball surface"."""
    is_told = origin_in(name) or from_centre(name)
    if is_told and re.search(rf"{BEHIND_FROM}$", name):
        return re.split(BEHIND_FROM, name)[0]
    return name


def from_centre(header: str) -> bool:
    """Return whether a header says that a length counts from the centre.

    An example is "x from centre".
    """
    if any(words.is_in(header) for _, words in ORIGINS):
        return False
    # The languages of Asia join small words to others, or have no blanks.
    joined = squeeze(header)
    return not CENTRE_WORDS.isdisjoint(squeezed_words(header)) or any(
        w in joined for w in CENTRE_WORDS if w > "\u0590"
    )
