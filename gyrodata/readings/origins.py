"""Where positions count from: the centre of the ball, its surface, or the tip."""

from __future__ import annotations

import re
from functools import lru_cache

from gyrodata.quantities import notation, vocabulary
from gyrodata.readings.names import (
    CENTRE_WORDS,
    MAX_HEADER,
    name_roles,
    squeeze,
    squeezed_words,
)

FROM = vocabulary.pattern("from")
"""Words between a length and its origin."""
_FROM = rf"\b{FROM}\b((?:\W+[\w']+){{1,5}})"
_SURFACE_NOTE = vocabulary.pattern("surface_note")
_WEIGHT_NAMES = [
    name.strip()
    for name in vocabulary.words("mass", ",").split(",")
    if " " not in name.strip()
]
_WEIGHT_NAME = "|".join(name for name in _WEIGHT_NAMES if len(name) > 3)
_CENTRE = r"(?i)cent(?:re|er)|mittel|Mitte|центр|środk"
_OF_WEIGHT = (
    rf"(?i)(?:{_CENTRE[4:]})\w*\W+(?:\w+\W+){{0,2}}?(?:{_WEIGHT_NAME})"
    rf"|{vocabulary.pattern('not_centre')}"
)
"""The centre of the weight, or what is not the origin."""
_ORIGIN = tuple(
    (origin, f"(?i){vocabulary.words(origin, '|')}") for origin in ("surface", "tip")
)


@lru_cache(maxsize=4096)
def origin_in(header: str) -> str:
    """Return the origin of positions if a header names it; else "".

    The origin is the "surface" of the ball or the "tip" of the rod.
    """
    if len(header) > MAX_HEADER or (
        re.search(_CENTRE, header)
        and re.search(_CENTRE, re.sub(_OF_WEIGHT, "", header))
    ):
        return ""
    return next((origin for origin, words in _ORIGIN if re.search(words, header)), "")


@lru_cache(maxsize=4096)
def noted_origin(note: str) -> str:
    """Return the origin of positions in a note; else "".

    An example is "x is measured from the surface of the ball".
    """
    if not any(
        re.search(words, note) for words in (_SURFACE_NOTE, *dict(_ORIGIN).values())
    ):
        return ""
    to_weight = bool(re.search(_OF_WEIGHT, note))
    note = re.sub(_OF_WEIGHT, "", note)
    if re.search(_SURFACE_NOTE, note) and not re.search(_CENTRE, note):
        return "surface"
    if not (origin := origin_in(note)):
        return ""
    if (symbol := re.match(r"\W*(\w{1,8})\s*[,:=]", note)) and "position" in name_roles(
        symbol[1]
    )[0]:
        return origin  # "x: surface of the ball to the middle of the weight"
    names = re.findall(r"[^\W\d_]+", note)
    named = (
        name.removesuffix(end)
        for name in names
        for end in ("", "s", "n", "en", "e", "et")
    )
    is_position = to_weight or any(
        {"position", "mass"}.intersection(name_roles(one)[0]) for one in named
    )
    is_position |= bool(
        re.match(rf"\W*{FROM}\b", note)
    )  # the footnote "* from the surface"
    return (
        origin
        if is_position
        and any(origin_in(found[1]) for found in re.finditer(f"(?={_FROM})", note))
        else ""
    )


def noted_centre(note: str) -> bool:
    """Return whether a note says that positions count from the centre of the ball."""
    note = re.sub(_OF_WEIGHT, "", note)
    names = [
        name.removesuffix(end)
        for name in re.findall(r"[^\W\d_]+", note)
        for end in ("", "s", "e", "n")
    ]
    is_position = any(
        {"position", "mass"}.intersection(name_roles(name)[0]) for name in names
    )
    return is_position and from_centre(note) and bool(re.search(_FROM, note))


WIDE, _RADIUS, SPHERE = map(vocabulary.pattern, ("diameter", "radius", "sphere"))
_LONG = rf"({notation.NUMBER}\s*[^\W\d_]{{1,20}})"
DIAMETER = (
    rf"(?:{WIDE}|\bD(?:\s+\w+)?\s*=)[^0-9;]{{0,30}}?{_LONG}|(?<![0-9]){_LONG}\s*"
    rf"(?:[^\W\d]{{1,30}}\s+)?{WIDE}"
)


def diameter_in(sentence: str) -> str:
    """Return the diameter of the ball that a sentence states: "101.6 mm"; "" if it states none."""
    if not re.search(SPHERE, sentence):
        return ""
    # "diameter (mm): 101.6", "diameter, cm 10.2"
    sentence = re.sub(
        rf"(?:[\[(]|,\s)([mcdik]?[mn]|[сcм]м)[\])]?\W*({notation.NUMBER})",
        r"\2 \1",
        sentence,
    )
    if match := re.search(DIAMETER, sentence):
        return match[1] or match[2]
    # "from the surface, r = x + 5.08 cm"
    match = re.search(rf"(?:{_RADIUS}|\bR\s*=)[^0-9;]{{0,30}}?{_LONG}", sentence) or (
        re.search(rf"=[^0-9;=+]{{1,30}}\+\s*{_LONG}", sentence)
        if origin_in(sentence) == "surface"
        else None
    )
    return f"2 x {match[1]}" if match else ""


def without_origin(name: str) -> str:
    """Return a name without the origin at its end, as in "pos. from ball surface"."""
    is_told = origin_in(name) or from_centre(name)
    if is_told and re.search(rf"{_FROM}$", name):
        return re.split(_FROM, name)[0]
    return name


def from_centre(header: str) -> bool:
    """Return whether a header says that a length counts from the centre.

    An example is "x from centre".
    """
    if any(re.search(words, header) for _, words in _ORIGIN):
        return False
    # The languages of Asia join small words to others, or have no blanks.
    joined = squeeze(header)
    return not CENTRE_WORDS.isdisjoint(squeezed_words(header)) or any(
        w in joined for w in CENTRE_WORDS if w > "\u0590"
    )
