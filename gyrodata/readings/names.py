"""The names of roles: words and symbols of all languages, and the roles they mean.

A name is a known one, or known words together with small words ("initial spin"), with
its symbol ("Mass m"), with its origin ("position from the centre"), or with the thing
that turns ("period of precession").
"""

from __future__ import annotations

import re
from functools import cache, lru_cache

from gyrodata.quantities import vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.origins import without_origin
from gyrodata.readings.roles import REPORTED, ROLES, SHARED_NAMES, UNCERTAINTIES
from gyrodata.readings.words import (
    END_WORDS,
    FIRST_SIGN,
    MAX_HEADER,
    NOISE_WORDS,
    PRECESSION,
    SPINNING,
    START_WORDS,
    TOKENS,
    UNSURE_WORDS,
    Phrases,
    squeeze,
    squeezed_names,
)

NAMES: dict[str, tuple[str, ...]] = {squeeze(role).lower(): (role,) for role in ROLES}
"""Roles by squeezed lower-case name."""
for _roles in (*ROLES, *SHARED_NAMES):
    _meant = tuple(_roles.split())
    for _name in squeezed_names(vocabulary.words(_roles, ",")):
        NAMES.setdefault(_name, _meant)
del NAMES[""]

SYMBOLS: dict[str, tuple[str, ...]] = {
    squeeze(symbol): tuple(roles.split())
    for roles, symbols in vocabulary.SYMBOLS.items()
    for symbol in symbols.split()
}
"""Roles by squeezed symbol; upper and lower case differ."""


@cache
def _all_words() -> frozenset[str]:
    """Return every word of the vocabulary; few logs need it."""
    lists = [",".join(section.values()) for section in vocabulary.LANGUAGES.values()]
    return frozenset(squeezed_names(",".join(lists).replace(" ", ",")))


def is_word(text: str) -> bool:
    """Return whether a word is a word of headers, or a unit."""
    return squeeze(text).lower() in _all_words() or bool(kinds_of(text))


BESIDE = {
    role: frozenset(
        squeezed_names(",".join(vocabulary.words(f"beside_{role}").split()))
    )
    for role in ("mass", "position", "turns", "time", "spin")
}
"""Words beside the name of a role that say nothing more: "added mass"."""
INDEX = r"(.*?[^\W\d])[\s_\-.]{0,20}([1-9][0-9]?)"
_AFFIXES = (
    (START_WORDS, "", "_start"),
    (END_WORDS, "", "_end"),
    (UNSURE_WORDS, "u_", ""),
)
"""Words that change a role, with what the role's name gets before and behind it."""
_MOST_WORDS = 8


@lru_cache(maxsize=4096)
def name_roles(name: str) -> tuple[tuple[str, ...], int | None]:
    """Find the roles that a name without a unit may mean, and the number of a repeat."""
    if len(name) > MAX_HEADER:
        return (), None
    roles = _roles_of(name)
    if roles:
        return roles, None
    match = re.fullmatch(INDEX, name.strip())
    if match and "time" in _roles_of(match[1]):
        return ("time",), int(match[2])
    return (), None


def _roles_of(name: str) -> tuple[str, ...]:
    roles = known_roles(name)
    words = [word for word in TOKENS.split(name) if word]
    if roles or len(words) > _MOST_WORDS:
        return roles
    bare = without_origin(name)
    if bare != name:
        return _roles_of(bare)
    return _named_twice(words) or _with_small_words(words)


def known_roles(name: str) -> tuple[str, ...]:
    """Look up a symbol or a name, as it is."""
    symbol = squeeze(name)
    if symbol in SYMBOLS:
        return SYMBOLS[symbol]
    is_unit_behind = re.search(r"[\s,]s$", name)  # "time s" is not "times"
    if symbol.lower() in NAMES and not is_unit_behind:
        return NAMES[symbol.lower()]
    key = re.sub(r"[\s-]", "_", name.lower())
    if key in UNCERTAINTIES:
        return (key,)
    return SYMBOLS.get(symbol.lower(), ()) if len(symbol) == 1 else ()


def _named_twice(words: list[str]) -> tuple[str, ...]:
    """Return what both parts of "Mass m", "Tiempo inicial T Gi" and "m (mass)" mean."""
    for name, symbol in (
        (words[:-1], words[-1:]),
        (words[:-2], words[-2:]),
        (words[1:], words[:1]),
    ):
        meant = SYMBOLS.get(squeeze("".join(symbol)), ())
        # A word of Chinese or Japanese may have two signs.
        if not meant or not name or (len(name[0]) <= 2 and name[0] < FIRST_SIGN):
            continue
        both = tuple(role for role in _roles_of(" ".join(name)) if role in meant)
        if both:
            return both
    return ()


def _with_small_words(words: list[str]) -> tuple[str, ...]:
    """Look up a name between small words: "initial spin", "mean period", "error of T"."""
    before = after = ""
    for small, first, last in _AFFIXES:
        bare = [word for word in words if squeeze(word).lower() not in small]
        if len(bare) < len(words):
            words, before, after = bare, before + first, after + last
    roles = _base_roles(words)
    if after and roles == ("turns",):
        roles = ("turns", "spin")  # "Rotations before (rpm)"
    modified = tuple(f"{before}{role}{after}" for role in roles)
    return tuple(role for role in modified if role in ROLES or role in UNCERTAINTIES)


def _base_roles(words: list[str]) -> tuple[str, ...]:
    """Look up a name without the words that say nothing of its role, or with them.

    Small words may belong to a name: "tiempo de giro".
    """
    bare = [word for word in words if squeeze(word).lower() not in NOISE_WORDS]
    if not bare:
        return ()
    return (
        known_roles(" ".join(bare))
        or known_roles(" ".join(words))
        or _of_what_turns(bare)
    )


_OF_PRECESSION = {
    "turns": "turns",
    "angle": "angle",
    "time": "time",
    "precession_period": "precession_period",
    "precession_rate": "precession_rate",
    "spin": "precession_rate",
}
"""What a quantity is, if it is one of the precession: a speed is a precession rate."""
_OF_THE_BALL = {
    "spin": "spin",
    "precession_rate": "spin",
    "precession_period": "spin_period",
    "spin_period": "spin_period",
    "turns": "spin_turns",
}
"""What a quantity is, if it is one of the ball."""


def _of_what_turns(words: list[str]) -> tuple[str, ...]:
    """Look up "period of precession" and "ball speed", in any order of the words."""
    rest = [word for word in words if not re.fullmatch(PRECESSION, word)]
    bare = [word for word in rest if not SPINNING.is_in(word)]
    if bare == words:
        return _meant_by_all(bare)
    if rest not in (bare, words):
        return ()  # of both
    roles_of = _OF_PRECESSION if rest == bare else _OF_THE_BALL
    meant = (roles_of.get(role, "") for role in _meant_by_all(bare))
    return tuple(dict.fromkeys(filter(None, meant)))


def _meant_by_all(words: list[str]) -> tuple[str, ...]:
    """Return the roles that several words mean, each alone or all together."""
    roles = known_roles(" ".join(words))
    if roles or not words:
        return roles
    named = {word: known_roles(word) for word in words}
    possible = dict.fromkeys(role for roles in named.values() for role in roles)
    return tuple(role for role in possible if _all_fit(role, named))


def _all_fit(role: str, named: dict[str, tuple[str, ...]]) -> bool:
    """Return whether each word names a role, or may be next to its name.

    Words beside the turns stand in front: a "turn number" counts the runs.
    """
    beside = [word for word, roles in named.items() if role not in roles]
    if not beside:
        return True
    if role == "turns" and beside[-1] == [*named][-1]:
        return False
    if role == "position" and _RADIUS.is_in(" ".join(named)):
        return False  # "weight radius" is half of its diameter
    if min(map(len, named)) == 1:
        return False  # "mass (x)"
    return BESIDE.get(role, frozenset()).issuperset(
        squeeze(word).lower() for word in beside
    )


_RADIUS = Phrases("radius")


def reported_key(key: str) -> str:
    """Return the key of a reported value.

    It is ``inertia`` for ``reported_I_zz`` and ``reported_moment_of_inertia``.
    """
    bare = key[len(REPORTED) :] if key.lower().startswith(REPORTED) else key
    return "inertia" if known_roles(bare) == ("inertia",) else bare.lower()
