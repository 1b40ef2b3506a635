"""Remarks that say that a reading is not what is typed."""

from __future__ import annotations

import re

from gyrodata.quantities import notation, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import NAMES, name_roles
from gyrodata.readings.origins import (
    BEHIND_FROM,
    CENTRE,
    FROM,
    OF_WEIGHT,
    ORIGINS,
    from_centre,
    origin_in,
)
from gyrodata.readings.roles import BY_NAME
from gyrodata.readings.words import squeeze

_HANGER, _HALF = (f"(?:{vocabulary.words(key, '|')})" for key in ("hanger", "half"))
_ALTERED, _USUAL, CORRECTED = (
    rf"(?i)(?<!\w)(?:{vocabulary.words(key, '|')}){end}".replace(
        "HANGER", _HANGER
    ).replace("HALF", _HALF)
    for key, end in (("altered", r"(?!\w)"), ("usual", ""), ("corrected", ""))
)
"""Patterns of a note that says that a reading is not what is typed; of usual notes; and
of notes that correct it."""
ALTERED = {
    role: vocabulary.pattern(f"altered_{role}")
    for role in ("spin", "turns", "mass", "position")
}
"""Patterns of notes that say this of one role, in words that do not name it."""


def altered_role(note: str) -> str:
    """Find the reading that a note says is twice, half, without or minus something.

    "" if there is none.
    """
    if re.search(CORRECTED, note):
        return ""
    for role, words in ALTERED.items():
        if re.search(words, note):
            return role
    if not re.search(_ALTERED, note):
        return ""
    for clause in re.split(r"[.;!?]\s", re.sub(_USUAL, "…", note)):
        if not re.search(_ALTERED, clause):
            continue
        for word in re.findall(r"[\w/]+", clause):
            for role in _roles_of_word(word):
                if BY_NAME[role].part and role != "torque":
                    return role
    return ""


def _roles_of_word(word: str) -> tuple[str, ...]:
    """Look up a word of a note: a name, perhaps in the plural, a unit, or a hanger."""
    if re.fullmatch(_HANGER, word, re.IGNORECASE):
        return ("mass",)
    if kinds_of(word) == {"rate"}:
        return ("spin",)
    if len(word) <= 2:
        return ()
    singular = re.sub(r"e?[ns]$", "", word)
    named = NAMES.get(squeeze(word).lower())
    return named or NAMES.get(squeeze(singular).lower(), ())


_SURFACE_NOTE = vocabulary.pattern("surface_note")


def noted_origin(note: str) -> str:
    """Return the origin of positions in a note; else "".

    An example is "x is measured from the surface of the ball".
    """
    if not any(
        re.search(words, note) for words in (_SURFACE_NOTE, *dict(ORIGINS).values())
    ):
        return ""
    to_weight = bool(re.search(OF_WEIGHT, note))
    note = re.sub(OF_WEIGHT, "", note)
    if re.search(_SURFACE_NOTE, note) and not re.search(CENTRE, note):
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
        and any(
            origin_in(found[1]) for found in re.finditer(f"(?={BEHIND_FROM})", note)
        )
        else ""
    )


def noted_centre(note: str) -> bool:
    """Return whether a note says that positions count from the centre of the ball."""
    note = re.sub(OF_WEIGHT, "", note)
    names = [
        name.removesuffix(end)
        for name in re.findall(r"[^\W\d_]+", note)
        for end in ("", "s", "e", "n")
    ]
    is_position = any(
        {"position", "mass"}.intersection(name_roles(name)[0]) for name in names
    )
    return is_position and from_centre(note) and bool(re.search(BEHIND_FROM, note))


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
