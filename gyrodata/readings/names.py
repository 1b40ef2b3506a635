"""Words in all languages, the names of roles, and the record of a header.

A name is a known one, or known words together with small words ("initial spin"), with
its symbol ("Mass m"), with its origin ("position from the centre"), or with the thing
that turns ("period of precession").
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection
from functools import cache, lru_cache
from itertools import chain
from typing import Literal

from msgspec import Struct

from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.roles import (
    REPORTED,
    ROLES,
    SHARED_NAMES,
    UNCERTAINTIES,
    kind_of_role,
)

# --- Words ---

FIRST_SIGN = "\u2e80"
"""Letters from this one on are signs of Chinese, Japanese or Korean, which are words.
"""
MAX_HEADER = 200
"""Characters of the longest header that is read."""
TOKENS = re.compile(r"[\s_,;()\[\]\-]+|(?<=^[ΔδσΣ∆])(?=\w)")
"""What is between words; the sign of an uncertainty, as in "Δm", is a word as well."""
_MARKS = units.Letters(
    {**str.maketrans("łϕı", "lφi", "_-.:'’<>|^$*~`\\{}"), ord("ß"): "ss"},
    categories=("Mn",),
)


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


def fold_name(text: str) -> str:
    """Return the letters of a name, squeezed and in lower case."""
    return squeeze(text).lower()


LETTERS = re.compile(r"[^\W\d_]+")
"""A word without digits."""
_BETWEEN_WORDS = re.compile(r"[\W_]+")


def words_of(text: str) -> list[str]:
    """Return the words of a text; blank texts stand for signs at its ends."""
    return _BETWEEN_WORDS.split(text)


def squeezed_words(text: str) -> set[str]:
    """Return the words of a text, squeezed and in small letters."""
    return set(map(fold_name, words_of(text)))


def contains_word(text: str, words: Collection[str]) -> bool:
    """Return whether a text contains one of some squeezed words in small letters."""
    return any(fold_name(word) in words for word in TOKENS.split(text))


class Phrases:
    """The phrases of all languages under one key.

    A regular expression of all phrases is long, and a text contains few of their words:
    only the phrases whose first word is in the text are tried.
    """

    def __init__(self, key: str) -> None:
        self.pattern = vocabulary.pattern(key)
        self._by_first_word: dict[str, list[str]] = {}
        self._single_words: dict[str, str] = {}
        for phrase in vocabulary.phrases(key):
            # The beginning of a word, without signs such as those in "don't"
            first = phrase.lower().split()[0]
            letters = _WORD.search(first)
            first = letters[0] if letters else first
            self._by_first_word.setdefault(first, []).append(phrase)
            if " " not in phrase:
                # A single word may stand inside of a longer one.
                self._single_words[phrase.lower().removesuffix(".")] = phrase

    def is_in(self, text: str) -> bool:
        """Return whether a text contains one of the phrases."""
        small = text.lower()
        likely = {
            phrase for word, phrase in self._single_words.items() if word in small
        }
        for word in _WORD.findall(small):
            likely.update(self._by_first_word.get(word, ()))
        if not likely:
            return False
        return re.search(vocabulary.pattern_of(sorted(likely)), text) is not None

    def without(self, text: str, instead: str = "") -> str:
        """Return a text without the phrases, or with another text for each."""
        return re.sub(self.pattern, instead, text)


_WORD = re.compile(r"\w+")


def squeezed_names(names: str) -> list[str]:
    """Squeeze names between commas, in small letters.

    The names are squeezed together, because one by one would take 20 ms at each start.
    """
    return fold_name(names).split(",")


def word_set(key: str) -> set[str]:
    """Return the single words of all languages under one key, squeezed."""
    return set(squeezed_names(",".join(vocabulary.single_words(key))))


START_WORDS = word_set("start")
END_WORDS = word_set("end")
NOISE_WORDS = word_set("noise")
UNSURE_WORDS = word_set("unsure")
THEORY_WORDS = word_set("theory")
TRIAL_WORDS = word_set("trial")
CENTRE_WORDS = word_set("centre")
MEAN_WORDS = word_set("mean")
SCALE_WORDS = word_set("scale")
COUNTER_WORDS = word_set("counter")
"""Words for calculated values, repeats of one setting, the centre of the ball, means,
and scales of instruments; and words for a turn that may also number the runs."""
SUMMARY_WORDS = MEAN_WORDS | word_set("summary")
"""Words for what is below a table and is not a run."""
DISC_WORDS = word_set("disc")
"""Words for a disc: a weight on the rod, or the rotor of another gyroscope."""
NOT_THE_WEIGHT = word_set("not_the_weight") | word_set("diameter") | DISC_WORDS
"""Words next to a quantity that is not an added weight, its position, or a spin."""
MOTION_WORDS = word_set("motion")
"""Words for a rotation, whose unit says whether it is an angle, turns or a rate."""
STATION_WORDS = word_set("station")
"""Words for the place in the lab where a gyroscope is."""
SPINNING = Phrases("spinning")
SPHERE = Phrases("sphere")
DIAMETER = Phrases("diameter")
ROD = Phrases("rod")
PRECESSION = Phrases("precession")

SMALL_WORDS = START_WORDS | END_WORDS | NOISE_WORDS


# --- Origins of positions ---

_BEHIND_FROM = re.compile(
    rf"\b(?={vocabulary.pattern('from')}\b((?:\W+[\w']+){{1,5}}))"
)
"""Words between a length and its origin, and five words of the origin."""
_WEIGHT_NAMES = [
    name.strip()
    for name in vocabulary.words("mass", ",").split(",")
    if " " not in name.strip()
]
_WEIGHT_NAME = "|".join(name for name in _WEIGHT_NAMES if len(name) > 3)
_CENTRE = ("centre", "center", "middle", "milieu", "mittel", "mitte", "центр", "środk")
_OF_WEIGHT = (
    rf"(?i)(?:{'|'.join(_CENTRE)})\w*\W+(?:\w+\W+){{0,2}}?(?:{_WEIGHT_NAME})"
    rf"|{vocabulary.pattern('not_centre')}"
)
"""The centre of the weight, or what is not the origin."""
Origin = Literal["", "centre", "surface", "tip"]
ORIGINS: tuple[tuple[Origin, Phrases], ...] = (
    ("surface", Phrases("surface")),
    ("tip", Phrases("tip")),
)


def without_weight(text: str) -> str:
    """Return a text without the centre of the weight, which is not an origin."""
    return re.sub(_OF_WEIGHT, "", text)


def names_centre(text: str) -> bool:
    """Return whether a text contains a word for the centre of something."""
    small = text.lower()
    return any(stem in small for stem in _CENTRE)


def behind_from(text: str) -> list[tuple[int, str]]:
    """List the places of "from" in a text, and the words behind each."""
    return [(match.start(), match[1]) for match in _BEHIND_FROM.finditer(text)]


def origin_in(header: str) -> Origin:
    """Return the origin of positions if a header names it; else "".

    The origin is the "surface" of the ball or the "tip" of the rod.
    """
    if len(header) > MAX_HEADER or names_centre(without_weight(header)):
        return ""
    return next((origin for origin, words in ORIGINS if words.is_in(header)), "")


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


# --- Names of roles ---

NAMES: dict[str, tuple[str, ...]] = {fold_name(role): (role,) for role in ROLES}
"""Roles by squeezed lower-case name."""
for _roles in (*ROLES, *SHARED_NAMES):
    _meant = tuple(_roles.split())
    for _name in squeezed_names(vocabulary.words(_roles, ",")):
        NAMES.setdefault(_name, _meant)
del NAMES[""]

SYMBOLS: dict[str, tuple[str, ...]] = {}
"""Roles by squeezed symbol; upper and lower case differ."""
for _roles, _symbols in vocabulary.SYMBOLS.items():
    SYMBOLS |= dict.fromkeys(map(squeeze, _symbols.split()), tuple(_roles.split()))


@cache
def _all_words() -> frozenset[str]:
    """Return every word of the vocabulary; few logs need it."""
    lists = [",".join(section.values()) for section in vocabulary.LANGUAGES.values()]
    return frozenset(squeezed_names(",".join(lists).replace(" ", ",")))


def is_word(text: str) -> bool:
    """Return whether a word is a word of headers, or a unit."""
    return fold_name(text) in _all_words() or bool(kinds_of(text))


BESIDE = {
    role: word_set(f"beside_{role}")
    for role in ("mass", "position", "turns", "time", "spin")
}
"""Words beside the name of a role that say nothing more: "added mass"."""
_AFFIXES = (
    (START_WORDS, "", "_start"),
    (END_WORDS, "", "_end"),
    (UNSURE_WORDS, "u_", ""),
)
"""Words that change a role, with what the role's name gets before and behind it."""
_MOST_WORDS = 8


@lru_cache(maxsize=4096)
def name_roles(name: str) -> tuple[tuple[str, ...], int | None]:
    """Find the roles that a name without a unit may mean, and its repeat number."""
    if len(name) > MAX_HEADER:
        return (), None
    roles = _roles_of(name)
    if roles:
        return roles, None
    stem, number = numbered(name.strip())
    roles = _roles_of(stem)
    if number and "time" in roles:
        return ("time",), number
    return (), None


def numbered(name: str) -> tuple[str, int | None]:
    """Split "t_2" and "T 2" into the name and its number, None without one."""
    bare = name.rstrip("0123456789")
    digits = name[len(bare) :]
    stem = bare.rstrip(" _-.")
    if stem[-1:].isalpha() and 0 < len(digits) <= 2 and digits[0] != "0":
        return stem, int(digits)
    return name, None


def _roles_of(name: str) -> tuple[str, ...]:
    """Return the roles of a name, by the first of four ways that finds any.

    It is a symbol or a name as it is (`exact_roles`), without the place from which it
    counts; a name next to its symbol (`_named_twice`); a name between small words
    (`_with_small_words`); or there a name with the thing that turns (`_of_what_turns`).
    """
    roles = exact_roles(name)
    words = [word for word in TOKENS.split(name) if word]
    if roles or len(words) > _MOST_WORDS:
        return roles
    # "pos. from ball surface" without its end
    is_told = origin_in(name) or from_centre(name)
    places = behind_from(name) if is_told else []
    if places and any(name.endswith(origin) for _, origin in places):
        start, _ = places[0]
        return _roles_of(name[:start])
    return _named_twice(words) or _with_small_words(words)


def exact_roles(name: str) -> tuple[str, ...]:
    """Look up a symbol or a name, as it is."""
    symbol = squeeze(name)
    if symbol in SYMBOLS:
        return SYMBOLS[symbol]
    is_unit_behind = name.endswith((" s", ",s"))  # "time s" is not "times"
    small = symbol.lower()
    if small in NAMES and not is_unit_behind:
        return NAMES[small]
    key = name.lower().replace(" ", "_").replace("-", "_")
    if key in UNCERTAINTIES:
        return (key,)
    if len(symbol) == 1:
        return SYMBOLS.get(small, ())
    return ()


def _named_twice(words: list[str]) -> tuple[str, ...]:
    """Return what both parts of "Mass m", "Tiempo inicial T Gi" and "m (mass)" mean."""
    for name, symbol in (
        (words[:-1], words[-1:]),
        (words[:-2], words[-2:]),
        (words[1:], words[:1]),
    ):
        letters = "".join(symbol)
        meant = SYMBOLS.get(squeeze(letters), ())
        if not meant or not name:
            continue
        # A word of Chinese or Japanese may have two signs.
        if len(name[0]) <= 2 and name[0] < FIRST_SIGN:
            continue
        roles = _roles_of(" ".join(name))
        both = tuple(role for role in roles if role in meant)
        if both:
            return both
    return ()


def _with_small_words(words: list[str]) -> tuple[str, ...]:
    """Look up a name between small words: "initial spin", "error of T"."""
    before = after = ""
    for small, first, last in _AFFIXES:
        bare = [word for word in words if fold_name(word) not in small]
        if len(bare) < len(words):
            words = bare
            before = before + first
            after = after + last
    roles = _base_roles(words)
    if after and roles == ("turns",):
        roles = ("turns", "spin")  # "Rotations before (rpm)"
    modified = tuple(f"{before}{role}{after}" for role in roles)
    return tuple(role for role in modified if role in ROLES or role in UNCERTAINTIES)


def _base_roles(words: list[str]) -> tuple[str, ...]:
    """Look up a name without the words that say nothing of its role, or with them.

    Small words may belong to a name: "tiempo de giro".
    """
    bare = [word for word in words if fold_name(word) not in NOISE_WORDS]
    if not bare:
        return ()
    return (
        exact_roles(" ".join(bare))
        or exact_roles(" ".join(words))
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
    rest = [word for word in words if not PRECESSION.is_in(word)]
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
    roles = exact_roles(" ".join(words))
    if roles or not words:
        return roles
    named = {word: exact_roles(word) for word in words}
    possible = dict.fromkeys(chain.from_iterable(named.values()))
    return tuple(role for role in possible if _all_fit(role, named))


def _all_fit(role: str, named: dict[str, tuple[str, ...]]) -> bool:
    """Return whether each word names a role, or may be next to its name.

    Words beside the turns stand in front: a "turn number" counts the runs.
    """
    beside = [word for word, roles in named.items() if role not in roles]
    if not beside:
        return True
    *_, last = named
    if role == "turns" and last in beside:
        return False
    if role == "position" and _RADIUS.is_in(" ".join(named)):
        return False  # "weight radius" is half of its diameter
    if min(map(len, named)) == 1:
        return False  # "mass (x)"
    return BESIDE.get(role, set()).issuperset(map(fold_name, beside))


_RADIUS = Phrases("radius")


def reported_key(key: str) -> str:
    """Return the key of a reported value.

    It is ``inertia`` for ``reported_I_zz`` and ``reported_moment_of_inertia``.
    """
    bare = key[len(REPORTED) :] if key.lower().startswith(REPORTED) else key
    if exact_roles(bare) == ("inertia",):
        return "inertia"
    return bare.lower()


def station_in(line: str) -> str:
    """Return the station that a line names ("Station 2", "# poste: B"); else ""."""
    words = line.translate(_SIGNS_BESIDE).split()
    if len(words) != 2 or fold_name(words[0]) not in STATION_WORDS:
        return ""
    letter = words[1].rstrip("0123456789")
    digits = words[1].removeprefix(letter)
    is_name = len(digits) <= 2 and (letter == "" or letter.isalpha())
    return words[1] if is_name and len(letter) <= 1 else ""


_SIGNS_BESIDE = str.maketrans("#:=;,", "     ")


# --- The record of a header ---

OF_TURNS = frozenset({"angle", "number"})
"""Kinds that a unit of turns can measure."""


class Header(Struct, frozen=True):
    """The content of a header."""

    text: str
    roles: tuple[str, ...] = ()
    """Roles that the header may name."""
    unit: str | None = None
    """Unit text as written, known or not; None if there is none."""
    spread: str = ""
    """Text of a ±, with its unit if it has one; or ""."""
    number: int | None = None
    """Number of a repeat: ``time_2`` is 2."""
    name: str = ""
    """The text without its unit, its ± and the signs around them."""
    turns: str = ""
    """Turns that the text states: "1/3", "1", "2.5"; or ""."""
    origin: Origin = ""
    """Where the text says that a position counts from."""
    moment: Literal["", "start", "end"] = ""
    """Part of a run to which the reading belongs, if the text says so."""
    is_of_means: bool = False
    """Whether the text says that the values are means."""
    is_of_the_spin: bool = False
    """Whether the text says that the ball turns, and not the rod."""

    @property
    def kinds(self) -> frozenset[str]:
        """Kinds of quantity that the unit can measure."""
        return kinds_of(self.unit or "")


def bare_roles(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return those of some roles that need no unit, or else all."""
    bare = tuple(role for role in names if kind_of_role(role) in _WITHOUT_UNIT)
    return bare or names


_WITHOUT_UNIT = ("number", "text", "sign")


def measures(unit: str, role: str) -> bool:
    """Return whether a role, or the uncertainty of one, can have a unit."""
    return kind_of_role(role) in kinds_of(unit) or (
        unit == "%" and role.startswith("u_")
    )


def moment_in(header: str) -> Literal["", "start", "end"]:
    """Return the part of a run that a header names, as "start (s)" and "t stop" do."""
    words = squeezed_words(header)
    is_start = bool(words & START_WORDS)
    is_end = bool(words & END_WORDS)
    if is_start == is_end:
        return ""  # none, or "mean of start and end"
    return "start" if is_start else "end"


def is_of_the_spin(header: str) -> bool:
    """Return whether a header says that turns of the ball are timed."""
    return SPINNING.is_in(header) and not PRECESSION.is_in(header)
