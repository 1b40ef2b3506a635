"""Remarks that say that a reading is not what is typed."""

from __future__ import annotations

import re

from gyrodata.quantities import numerals, vocabulary
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
from gyrodata.readings.turns import MARK, TURN, mark_turns
from gyrodata.readings.words import Phrases, squeeze

_ROLES = ("spin", "turns", "mass", "position")
ALTERED = {role: Phrases(f"altered_{role}") for role in _ROLES}
"""Words that say this of one role, and do not name it."""
_ALTERED, CORRECTED = map(Phrases, ("altered", "corrected"))
_USUAL = vocabulary.pattern("usual")
"""Words that say that a reading is not what is typed, that only look so, and that say
that it is corrected."""


_HALVES = "|".join(map(re.escape, vocabulary.words("1/2").split()))
_HALF_TURN = rf"(?i:(?:{_HALVES})\W+(?:\w{{1,3}}\W+)?{TURN})"
_HANGER, _INCLUDED = map(Phrases, ("hanger", "included"))
_WITHOUT_HANGER = (
    rf"{vocabulary.pattern('without')}\W{{1,4}}(?:\w{{1,20}}\W{{1,4}})?"
    rf"{_HANGER.pattern}"
)
_ADDED = rf"(?:\+|{vocabulary.pattern('added')})\s*{numerals.NUMBER}\s*([^\W\d_]+)"
_MASS = r"(?<![0-9.,])[0-9.,]+\s*k?g(?!\w)"
_ROLE_OF_UNIT = {
    frozenset({"mass"}): "mass",
    frozenset({"length"}): "position",
    frozenset({"time"}): "time",
}
_DONE = r"\b(?:measured|weighed|timed|checked|read|took)\W{1,4}"
_DONE_TWICE = rf"(?i:{_DONE}(?:\w{{1,20}}\W{{1,4}}){{1,3}}twice)"
"""In "we measured the spin twice"."""
_DEFINITION = rf"[2-9]\s*=\s*(?:\w+\s+)?{MARK}"
"""In "4 = full turn"."""


def altered_role(note: str) -> str:
    """Find the reading that a note says is twice, half, without or minus something.

    "" if there is none.
    """
    role = _role_of_phrase(note) or _added_role(note) or _altered_by_word(note)
    is_corrected = role and CORRECTED.is_in(re.sub(_ALTERED.pattern, "…", note))
    return "" if is_corrected else role


def _role_of_phrase(note: str) -> str:
    """Find the reading of a phrase such as "4 = full turn" or "two stripes"."""
    if "=" in note and re.search(_DEFINITION, mark_turns(note)):
        return "turns"
    for role, words in ALTERED.items():
        if words.is_in(note):
            return role
    return ""


def _added_role(note: str) -> str:
    """Find the mass or the position to which a note adds something: "+ 5 g", "hook: 5 g"."""
    if added := re.search(_ADDED, note):
        return _ROLE_OF_UNIT.get(kinds_of(added[1]), "")
    if re.search(r"\+\s*(?:R|radius)\b", note):
        return "position"
    if not _HANGER.is_in(note):
        return ""
    if re.search(_WITHOUT_HANGER, note):
        return "mass"
    weighs = re.search(_MASS, note)
    return "mass" if weighs and not _INCLUDED.is_in(note) else ""


def _altered_by_word(note: str) -> str:
    """Find the first reading in a clause that says "twice", "half" or "wrong"."""
    if not _ALTERED.is_in(note):
        return ""
    bare = re.sub(f"{_USUAL}|{_HALF_TURN}|{_DONE_TWICE}", "…", note)
    for clause in re.split(r"[.;!?]\s", bare):
        if not _ALTERED.is_in(clause):
            continue
        for word in re.findall(r"[\w/]+", clause):
            for role in _roles_of_word(word):
                if BY_NAME[role].part and role != "torque":
                    return role
    return ""


def _roles_of_word(word: str) -> tuple[str, ...]:
    """Look up a word of a note: a name, perhaps in the plural, a unit, or a hanger."""
    if re.match(_HANGER.pattern, word):
        return ("mass",)
    if kinds_of(word) == {"rate"}:
        return ("spin",)
    if len(word) <= 2:
        return ()
    singular = re.sub(r"e?[ns]$", "", word)
    named = NAMES.get(squeeze(word).lower())
    return named or NAMES.get(squeeze(singular).lower(), ())


_SURFACE_NOTE = Phrases("surface_note")


def noted_origin(note: str) -> str:
    """Return the origin of positions in a note; else "".

    An example is "x is measured from the surface of the ball".
    """
    if _SURFACE_NOTE.is_in(note):
        bare = re.sub(OF_WEIGHT, "", note)
        return "" if re.search(CENTRE, bare) else "surface"
    if not any(words.is_in(note) for _, words in ORIGINS):
        return ""
    return _origin_of_position(note)


def _origin_of_position(note: str) -> str:
    """Return the origin that a note names, if it is about positions."""
    bare = re.sub(OF_WEIGHT, "", note)
    origin = origin_in(bare)
    if not origin or _explains_position(bare):
        return origin
    starts_with_from = re.match(rf"\W*{FROM}\b", bare)  # the footnote "* from the tip"
    is_position = starts_with_from or bare != note or _names_position(bare)
    return origin if is_position and _names_origin_behind_from(bare) else ""


def _names_origin_behind_from(note: str) -> bool:
    places = (match[1] for match in re.finditer(f"(?={BEHIND_FROM})", note))
    return any(map(origin_in, places))


def noted_centre(note: str) -> bool:
    """Return whether a note says that positions count from the centre of the ball."""
    bare = re.sub(OF_WEIGHT, "", note)
    is_of_position = _names_position(bare) and re.search(BEHIND_FROM, bare)
    return bool(is_of_position) and from_centre(bare)


def _explains_position(note: str) -> bool:
    """Return whether a note explains its first word: "x: from the surface of …"."""
    symbol = re.match(r"\W*(\w{1,8})\s*[,:=]", note)
    return symbol is not None and "position" in name_roles(symbol[1])[0]


def _names_position(note: str) -> bool:
    """Return whether a note names the position or the weight, perhaps in the plural."""
    return any(
        role in ("position", "mass")
        for word in re.findall(r"[^\W\d_]+", note)
        for end in ("", "s", "n", "en", "e", "et")
        for role in name_roles(word.removesuffix(end))[0]
    )


WIDE, SPHERE = map(Phrases, ("diameter", "sphere"))
