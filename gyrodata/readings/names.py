"""The names of roles: words and symbols of all languages, and the roles they mean."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection
from functools import cache, lru_cache

from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.roles import (
    BY_NAME,
    REPORTED,
    ROLES,
    SHARED_NAMES,
    UNCERTAINTIES,
)

_MARKS = units.Letters(
    {**str.maketrans("łϕı", "lφi", "_-.:'’<>|^$*~`\\{}"), ord("ß"): "ss"},
    categories=("Mn",),
)


@lru_cache(maxsize=8192)
def squeeze(text: str) -> str:
    """Return the letters of a name, without accents, blanks, ``_``, ``-`` and dots.

    Upper and lower case are kept.
    """
    letters = text
    if not text.isascii():
        # A dot above means a rate ("φ̇"); other accents depend on the keyboard.
        letters = unicodedata.normalize("NFD", units.fold_letters(text)).replace(
            "\u0307", "dot"
        )
    return "".join(letters.translate(_MARKS).split())


def squeezed_words(text: str) -> set[str]:
    """Return the words of a text, squeezed and in small letters."""
    return {squeeze(word).lower() for word in re.split(r"[\W_]+", text)}


def contains_word(text: str, words: Collection[str]) -> bool:
    """Return whether a text contains one of some squeezed words in small letters."""
    return any(squeeze(word).lower() in words for word in TOKENS.split(text))


def squeezed_names(names: str) -> list[str]:
    """Squeeze names between commas, in small letters.

    The names are squeezed together, because one by one would take 20 ms at each start.
    """
    return squeeze(names).lower().split(",")


def _words(key: str) -> set[str]:
    return set(squeezed_names(",".join(vocabulary.words(key).split())))


START_WORDS, END_WORDS, NOISE_WORDS, UNSURE_WORDS = map(
    _words, ("start", "end", "noise", "unsure")
)
THEORY_WORDS, TRIAL_WORDS, CENTRE_WORDS = map(_words, ("theory", "trial", "centre"))
MEAN_WORDS, SCALE_WORDS, COUNTER_WORDS = map(_words, ("mean", "scale", "counter"))
"""Words for calculated values, repeats of one setting, the centre of the ball, means,
and scales of instruments; and words for a turn that may also number the runs."""
SUMMARY_WORDS = MEAN_WORDS | _words("summary")
"""Words for what is below a table and is not a run."""
NOT_THE_WEIGHT, DIMENSION_WORDS = map(_words, ("not_the_weight", "dimension"))
"""Words next to a quantity in a title that is not an added weight, its position, or a
measured spin; and words behind a length that is not a position."""
MOTION_WORDS = _words("motion")
"""Words for a rotation, whose unit says whether it is an angle, turns or a rate."""
SPINNING = vocabulary.pattern("spinning")
PRECESSION = f"(?i:(?:{vocabulary.words('precession', '|')})[^\\W\\d_]*\\.?)"

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
    lists = (
        text for section in vocabulary.LANGUAGES.values() for text in section.values()
    )
    return frozenset(
        squeeze(word).lower() for word in " ".join(lists).replace(",", " ").split()
    )


def is_word(text: str) -> bool:
    """Return whether a word is a word of headers, or a unit."""
    return squeeze(text).lower() in _all_words() or bool(kinds_of(text))


MAX_HEADER = 200
"""Characters of the longest header that is read."""
TOKENS = re.compile(r"[\s_,;()\[\]\-]+")
INDEX = r"(.*?[^\W\d])[\s_\-.]{0,20}([1-9][0-9]?)"
SMALL_WORDS = START_WORDS | END_WORDS | NOISE_WORDS
_AFFIXES = (
    (START_WORDS, "", "_start"),
    (END_WORDS, "", "_end"),
    (UNSURE_WORDS, "u_", ""),
)
"""Words that change a role, with what the role's name gets before and behind it."""


@lru_cache(maxsize=4096)
def name_roles(name: str) -> tuple[tuple[str, ...], int | None]:
    """Find the roles that a name without a unit may mean, and the number of a repeat."""
    if len(name) > MAX_HEADER:
        return (), None
    if found := _known(name) or _modified(name):
        return found, None
    match = re.fullmatch(INDEX, name.strip())
    if match and "time" in (_known(match[1]) or _modified(match[1])):
        return ("time",), int(match[2])
    return (), None


def _known(name: str) -> tuple[str, ...]:
    """Look up a symbol or a name, as it is."""
    symbol, key = squeeze(name), re.sub(r"[\s-]", "_", name.lower())
    one_letter = SYMBOLS.get(symbol.lower(), ()) if len(symbol) == 1 else ()
    joined = (
        NAMES.get(symbol.lower()) if not re.search(r"[\s,]s$", name) else ()
    )  # "time s" is not "times"
    return (
        SYMBOLS.get(symbol)
        or joined
        or ((key,) if key in UNCERTAINTIES else one_letter)
    )


def _modified(name: str) -> tuple[str, ...]:
    """Look up a known name between small words.

    Examples are "initial spin", "mean period", "error of T" and "Mass, m".
    """
    tokens = [token for token in TOKENS.split(name) if token]
    if len(tokens) == 1:
        return _known(tokens[0])
    if not 2 <= len(tokens) <= 8:
        return ()
    # "Mass m", "Tiempo de giro inicial T Gi", "m (mass)": what both mean is meant.
    for words, letters in (
        (tokens[:-1], tokens[-1:]),
        (tokens[:-2], tokens[-2:]),
        (tokens[1:], tokens[:1]),
    ):
        word, symbol = " ".join(words), SYMBOLS.get(squeeze(" ".join(letters)), ())
        if not symbol:
            continue
        named_by_word = _known(word) or _modified(word)
        both = tuple(role for role in named_by_word if role in symbol)
        # A word of Chinese or Japanese may have two signs.
        if both and (len(squeeze(words[0])) > 2 or words[0] > "\u2e80"):
            return both
    lower = [squeeze(token).lower() for token in tokens]
    affixes = [affix for affix in _AFFIXES if not affix[0].isdisjoint(lower)]
    small = {word for words, _, _ in affixes for word in words}
    # Small words may belong to a name: "tiempo de giro".
    named = " ".join(
        token for token, low in zip(tokens, lower, strict=True) if low not in small
    )
    left = " ".join(
        token for token in named.split() if squeeze(token).lower() not in NOISE_WORDS
    )
    before, after = (
        "".join(one for _, one, _ in affixes),
        "".join(one for _, _, one in affixes),
    )
    bases = _known(left) or _known(named) if left else ()
    # "Rotations before (rpm)"
    bases += ("spin",) * (bases == ("turns",) and after != "")
    modified = (f"{before}{role}{after}" for role in bases)
    if found := tuple(
        role for role in modified if role in ROLES or role in UNCERTAINTIES
    ):
        return found
    # "Period of precession" in any order of its words; "precession" alone is a name.
    bare = " ".join(word for word in left.split() if not re.fullmatch(PRECESSION, word))
    found = _known(bare) if bare not in ("", left) else ()
    return tuple(role for role in found if BY_NAME[role].part in ("count", "timing"))


def reported_key(key: str) -> str:
    """Return the key of a reported value.

    It is ``inertia`` for ``reported_I_zz`` and ``reported_moment_of_inertia``.
    """
    bare = key[len(REPORTED) :] if key.lower().startswith(REPORTED) else key
    return "inertia" if name_roles(bare)[0] == ("inertia",) else bare.lower()
