"""The roles: what a column of a log can measure, one record each.

And the other keys that a log can give.

A new role is one record in `vocabulary.toml`, with its names there; readers, hints and
fill-down use these records.
"""

from __future__ import annotations

import difflib
import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache, lru_cache
from itertools import accumulate
from typing import Literal

from msgspec import Struct, convert
from msgspec.structs import replace

from gyrodata.quantities import notation, units, vocabulary
from gyrodata.quantities.error_sources import SOURCES
from gyrodata.quantities.units import Uncertainty, kinds_of


class Role(Struct, frozen=True):
    """A quantity that a column can measure."""

    name: str
    kind: str
    """Kind of quantity, a key of `gyrodata.quantities.units.SI`."""
    part: Literal["", "load", "spin", "count", "timing"] = ""
    """Part of a run that it measures: what turns the rod, the spin, how far the rod
    turned, and how long that took."""
    bound: Literal[
        "", "above zero", "not zero", "not below zero", "below 90 degrees"
    ] = ""
    """Condition for its values."""
    bound_hint: str = ""
    """What to type if a value is outside the bound."""
    sample: str = ""
    """Value to propose if it is missing."""
    meaning: str = ""
    """Its meaning, in words."""
    instead: str = ""
    """What can replace it, for hints."""
    derived_from: tuple[str, ...] = ()
    """Sets of roles, each separated by blanks; if all of one set are there, this role
    is only compared."""
    by_unit_without: tuple[str, ...] = ()
    """Roles; if none of them is there, a column without a known name can have this role
    by its unit."""
    u_of: str = ""
    """Role whose ``u_…`` is used if it has no ``u_…`` of its own."""


TABLE = tuple(
    convert({"name": name, **fields}, Role) for name, fields in vocabulary.ROLES.items()
)

SHARED_NAMES = tuple(
    dict.fromkeys(
        key
        for section in vocabulary.LANGUAGES.values()
        for key in section
        if " " in key
    )
)
"""Roles that share names, as they are written in the vocabulary."""

BY_NAME: dict[str, Role] = {role.name: role for role in TABLE}
ROLES = tuple(BY_NAME)
FILLED_DOWN = {r.name for r in TABLE if r.part in ("load", "spin", "count")} | {
    "weight_diameter",
    "transverse_inertia",
}
"""Roles whose blank cells take the value above, as in merged cells."""
TEXTS = frozenset(role.name for role in TABLE if role.kind == "text")
LOADS, COUNTS, TIMINGS = (
    tuple(r.name for r in TABLE if r.part == part)
    for part in ("load", "count", "timing")
)
"""Roles by the part of a run that they measure; of several timings, the first is used.
"""
ONE_TURN = TIMINGS[1:]
"""Timings of one whole turn, which need no number of turns."""
_SPIN_SETS = (
    "spin, spin_start spin_end, spin_period, spin_period_start spin_period_end, "
    "spin_time spin_turns"
)
SPIN_SETS = tuple(tuple(names.split()) for names in _SPIN_SETS.split(","))
"""Each of these sets gives the spin of a run; of several, the first is used."""

CONSTANTS = vocabulary.CONSTANTS
"""Kinds of the constants of a log that are not roles."""

SHARED_UNCERTAINTIES = {
    f"u_{key}": source.kind for key, source in SOURCES.items() if source.kind
}
SHARED_UNCERTAINTIES |= {"u_imbalance": "torque", "u_ball_mass": "mass"}
SHARED_UNCERTAINTIES |= {"u_ball_diameter": "length", "u_rod_length": "length"}
"""Kinds of the uncertainties whose names are not those of roles."""

UNCERTAINTIES = (
    *(f"u_{role.name}" for role in TABLE if role.kind not in ("sign", "text")),
    *SHARED_UNCERTAINTIES,
)


ORIGIN_LENGTHS = {
    "surface": ("ball_diameter", 0.5, "surface_unknown"),
    "tip": ("rod_length", 1.0, "tip_unknown"),
}
"""Origins of positions: the length that says where the centre is, the share of it that
is between both, and the name of the message if it is not given."""
OTHER_KEYS = tuple(vocabulary.LINES)
KEYS = (*ROLES, *CONSTANTS, *UNCERTAINTIES, *OTHER_KEYS)
"""Every key of ``# key: value``, ``--set`` and ``--config``."""


def kind_of_role(role: str) -> str:
    """Return the kind of quantity of a role, a constant or a ``u_…`` key.

    The function raises KeyError if the name does not have a kind.
    """
    if role in SHARED_UNCERTAINTIES:
        return SHARED_UNCERTAINTIES[role]
    base = role.removeprefix("u_")
    return CONSTANTS[base] if base in CONSTANTS else BY_NAME[base].kind


def u_keys(role: str) -> tuple[str, ...]:
    """Return the ``u_…`` keys of a role, its own first."""
    shared = BY_NAME[role].u_of if role in BY_NAME else ""
    return (f"u_{role}", f"u_{shared}") if shared else (f"u_{role}",)


def as_u_of(role: str, key: str, u: Uncertainty) -> Uncertainty:
    """Convert the uncertainty of a ``u_…`` key to the unit of a role.

    An angle is a share of a turn.
    """
    kinds = kind_of_role(role), kind_of_role(key)
    if kinds[0] == kinds[1]:
        return u
    per_turn = 1 / (2 * math.pi) if kinds[0] == "number" else 2 * math.pi
    return Uncertainty(u.absolute * per_turn, u.relative)


def stated_u(role: str, stated: Mapping[str, Uncertainty]) -> Uncertainty | None:
    """Return the uncertainty that a log states for every reading of a role.

    None if it states none.
    """
    return next(
        (as_u_of(role, key, stated[key]) for key in u_keys(role) if key in stated), None
    )


def to_display(value: float, role: str) -> tuple[float, str]:
    """Return a value of a role in the unit in which it is usually shown.

    The function also returns this unit (``g``, ``cm``, ``rpm``, …).
    """
    kind = kind_of_role(role)
    return units.from_si(value, units.DISPLAY[kind], kind), units.DISPLAY[kind]


def derived_roles(there: set[str]) -> set[str]:
    """Return the roles that are only compared.

    The readings from which they are calculated are present as well.
    """
    return {
        role.name
        for role in TABLE
        if any(there.issuperset(readings.split()) for readings in role.derived_from)
    }


@lru_cache(maxsize=16384)
def check_value(role: str, value: float) -> tuple[str, str]:
    """Return what is wrong with an impossible number, and what to type.

    Two empty texts if the number is possible.
    """
    known, kind = BY_NAME.get(role), kind_of_role(role)
    steep = abs(value) >= math.pi / 2
    broken = {
        "above zero": value <= 0,
        "not zero": value == 0,
        "not below zero": value < 0,
        "below 90 degrees": steep,
    }
    if known and broken.get(known.bound):
        return f"must be {known.bound}".replace("be not", "not be"), known.bound_hint
    low, high = units.LIMITS.get(kind, (0.0, math.inf))
    if value == 0 or low <= abs(value) <= high:
        return "", ""
    fault = (
        f"is too {'large' if abs(value) > high else 'small'} for "
        f"{units.KINDS[kind].words} in a lab"
    )
    return (
        fault,
        f"is its unit the one written? Read are {low:g} to {high:g} {units.SI[kind]}".rstrip(),
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


def _squeezed(names: str) -> list[str]:
    """Squeeze names between commas, in small letters.

    The names are squeezed together, because one by one would take 20 ms at each start.
    """
    return squeeze(names).lower().split(",")


def _words(key: str) -> set[str]:
    return set(_squeezed(",".join(vocabulary.words(key).split())))


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
PRECESSION = f"(?i:(?:{vocabulary.words('precession', '|')})[^\\W\\d_]*\\.?)"

NAMES: dict[str, tuple[str, ...]] = {squeeze(role).lower(): (role,) for role in ROLES}
"""Roles by squeezed lower-case name."""
for _roles in (*ROLES, *SHARED_NAMES):
    _meant = tuple(_roles.split())
    for _name in _squeezed(vocabulary.words(_roles, ",")):
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


_FIRST_SIGN = "\u2e80"
"""Letters from this one on are signs of Chinese, Japanese or Korean, which are words.
"""
MAX_HEADER = 200
"""Characters of the longest header that is read: the work grows with the cube of the
length."""


class Header(Struct, frozen=True):
    """The content of a header."""

    text: str
    roles: tuple[str, ...]
    """Roles that the header may name."""
    unit: str | None
    """Unit text as written, known or not; None if there is none."""
    spread: str
    """Text of a ±, with its unit if it has one; or ""."""
    number: int | None = None
    """Number of a repeat: ``time_2`` is 2."""


_SPREAD = r"(?:[\[(]\s*|(?<!\s)\s+)?(?:±|\+/-|\+-)\s*([0-9]+(?:[.,][0-9]+)?)\s*([^\])\[(,;]*)[\])]?"
_OF_ONE = vocabulary.pattern("of_one")
"""Words for one of several weights."""
_CLOCK_FORM = r"[a-zA-Z.]+:[a-zA-Z:.0]+"
"""A unit such as "mm:ss.cc"."""
_BRACKET = (
    r"(.*?)(?:(?<!\s)\s+)?(?:\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\))\s*"
)
_BRACKET_INSIDE = (
    r"([^\[(]*?)(?:(?<!\s)\s+)?[\[(]([^\[\]()]+)[\])][\s,;]{1,20}([^\[\]]+)"
)
_IN_UNIT = (
    r"(.+?)(?:(?<!\s)\s+(?:in|en|em|w|в)\s+|(?:(?<!\s)\s+)?/\s*)(\S{1,40}+)\s+(.+)"
)
_TIME_PER = rf"(\w+)\s+(?:{vocabulary.words('per', '|')}|for|für|pour)\s+(.+)"
_INDEX = r"(.*?[^\W\d])[\s_\-.]{0,20}([1-9][0-9]?)"
_WIDE_BRACKETS = str.maketrans("（）［］【】₀₁₂₃₄₅₆₇₈₉", "()[][]0123456789")
_TOKENS = re.compile(r"[\s_,;()\[\]\-]+")
_ORDINAL = r"(?:#|№|第|n[or]?[°º.]?)?([1-9][0-9]?)(?:st|nd|rd|th|er|re|ème|e|ª|º|[.)]|回目?|次)?"
_NUMBER_OF = (
    r"(?i)(?<!\w)(?:number "
    r"of|nombre|numero|anzahl|número|aantal|antal|liczb\w|počet|cantidad|quantidade)"
)
_NOT_COUNTED = rf"{_NUMBER_OF}(?:\s+[^\W\d]+){{1,3}}\s*$"
"""The "number of full" in front of "turns" does not say how many they are."""
SPINNING = vocabulary.pattern("spinning")
_SMALL_WORDS = START_WORDS | END_WORDS | NOISE_WORDS
_AFFIXES = (
    (START_WORDS, "", "_start"),
    (END_WORDS, "", "_end"),
    (UNSURE_WORDS, "u_", ""),
)
"""Words that change a role, with what the role's name gets before and behind it."""
_SWEPT = ("rotation", "precession", "drehung", "präzession", "précession", "прецессия")
"""Names that mean an angle in degrees, and else a rate."""


@lru_cache(maxsize=4096)
def parse_header(text: str) -> Header:
    """Find the roles, the unit, the ± and the number of a repeat in one header."""
    if len(text) > MAX_HEADER:
        return Header(text, (), None, "")
    spread, rest = "", text.translate(_WIDE_BRACKETS).rstrip("*†‡: ")
    if match := re.search(_SPREAD, rest):
        spread = f"{match[1]} {match[2].strip()}".strip()
        rest = f"{rest[: match.start()].strip()} {rest[match.end() :].strip()}".strip(
            " ,;"
        )
    name, unit = split_unit(re.sub(r"(?<=[\])]) Run #\d+$", "", rest))
    name = re.sub(
        r"(?i)(?<!\s)\s+(?:of|from|over|aus|de|di|von)\s+[0-9]{1,2}\s+\w{4,}$", "", name
    )  # "mean of 5 trials"
    if not name.isascii():
        name = re.sub(r"(?<=[\u2e80-\uffff])(?=[A-Za-z])", " ", name)  # "质量m"
    if unit is None and kinds_of(spread.partition(" ")[2]):
        unit = spread.partition(" ")[2]
    if unit and re.fullmatch(_CLOCK_FORM, unit):
        unit = "s"  # how its cells are written, and they say so themselves
    if not THEORY_WORDS.isdisjoint(
        squeeze(token).lower() for token in _TOKENS.split(text)
    ):
        return Header(text, (), unit, spread)  # worked out, not measured
    found, number = name_roles(name)
    if not found and not text.islower():
        parted = re.sub(r"(?:(?<=[a-z]{3})|(?<=\bn))(?=[A-Z])", "_", text)
        if parted != text and (header := parse_header(parted)).roles:
            return replace(header, text=text)  # "massGrams"
    if unit is None:
        begins = accumulate(re.split(r"[\s(,]+", name), "{} {}".format)
        if (
            not found
            and turns_in(name)
            and any("time" in name_roles(begin)[0] for begin in begins)
        ):
            found = ("time",)  # "Time for one turn" above "20.3 s"
        # A bare "N" counts turns: the other readings would need a unit.
        bare = tuple(
            role for role in found if kind_of_role(role) in ("number", "text", "sign")
        )
        return Header(text, bare or found, unit, spread, number)
    kinds = kinds_of(unit)
    found = (
        ("time", "precession_period")
        if found == ("precession_rate",) and kinds == {"time"}
        else found
    )
    if not found and "time" in kinds and turns_in(name):
        found = ("time",)  # "1/3 turn (s)"
    elif not found and "time" in kinds:
        # "Trial 2" and "2nd measurement" above times
        spaced = re.sub(r"(?<=[^\W\d])(?=[0-9])", " ", name)
        tokens = [
            (token, re.fullmatch(_ORDINAL, token.lower()))
            for token in _TOKENS.split(spaced)
            if token
        ]
        counted = [int(ordinal[1]) for _, ordinal in tokens if ordinal]
        others = [
            token
            for token, ordinal in tokens
            if not ordinal and squeeze(token).lower() not in TRIAL_WORDS
        ]
        if len(counted) == 1 and all(
            "time" in name_roles(token)[0] for token in others
        ):
            found, number = ("time",), counted[0]
    elif (
        not found
        and kinds == {"rate"}
        and is_of_the_spin(name)
        and not clock_word(name)
    ):
        found = ("spin",)  # "Kreisfrequenz der Kugel (rad/s)"
    elif not found and "length" in kinds and (origin_in(name) or from_centre(name)):
        found = ("position",)
    # Roles that the unit cannot measure are left out, unless it fits none: then the
    # unit is wrong.
    kept = tuple(role for role in found if _measures(unit, role))
    if kinds == {"angle"} and (name.strip().lower() in _SWEPT or found == ("turns",)):
        kept = ("angle",)
    elif kinds == {"rate"} and found == ("turns",):
        kept = ("spin",)  # "Rotations (rpm)"
    elif (
        kinds == _OF_TURNS
        and len(name) > 1
        and not kept
        and _names_motion(found)
        and not is_of_the_spin(name)
    ):
        kept = ("turns",)  # "Precession (turns)", "Rotation (rev)"
    elif kinds == {"force"} and found == ("mass",):
        kept = ("force",)  # "Weight (N)"
    elif "time" in kinds and "/" in unit and not kept:
        # "spin [s/rev]" is a period under another name.
        kept = tuple(
            role.replace("spin", "spin_period", 1)
            for role in found
            if role.startswith("spin")
        )
    # A symbol says less than a unit: "D (s)" is not a torque.
    return Header(
        text,
        kept if len(name.strip()) == 1 and kinds else kept or found,
        unit,
        spread,
        number,
    )


_OF_TURNS = frozenset({"angle", "number"})
"""Kinds that a unit of turns can measure."""


def _names_motion(found: tuple[str, ...]) -> bool:
    """Return whether one of the roles is a rate of rotation."""
    return any(kind_of_role(role) == "rate" for role in found)


def can_measure(header: Header) -> bool:
    """Return whether the unit of a header fits one of its roles."""
    return header.unit is None or any(
        _measures(header.unit, role) for role in header.roles
    )


def counts_turns(header: Header) -> bool:
    """Return whether the unit of a header is that of turns, as in "far (turns)"."""
    return kinds_of(header.unit or "") == _OF_TURNS


def is_one_letter(unit: str) -> bool:
    """Return whether a unit is a single letter: V may be a volt, T a tesla, and m any length.

    A sign of Chinese or Japanese is a word.
    """
    letters = units.fold_letters(unit).strip(". ")
    return len(letters) == 1 and letters.isalpha() and letters < _FIRST_SIGN


def hinted(header: Header) -> set[str]:
    """Return the roles that one word of a header names.

    The unit of the header can measure them, or the header says that the reading is
    "without" something.
    """
    if header.unit is None:
        return {altered_role(header.text)}
    words = re.findall(r"[^\W\d_]{2,}", header.text)
    return {
        role
        for word in words
        for role in name_roles(word)[0]
        if _measures(header.unit, role)
    }


@lru_cache(maxsize=4096)
def contains(pattern: str, text: str) -> bool:
    """Return whether a header contains some words."""
    return bool(re.search(pattern, text))


def is_part_of_mass(header: str) -> bool:
    """Return whether a header names a part of the mass.

    Examples are "mass of one weight" and "mass without hanger".
    """
    return bool(re.search(_OF_ONE, header)) or altered_role(header) == "mass"


def _measures(unit: str, role: str) -> bool:
    return kind_of_role(role) in kinds_of(unit) or (
        unit == "%" and role.startswith("u_")
    )


@lru_cache(maxsize=4096)
def split_unit(text: str) -> tuple[str, str | None]:
    """Split a header into its name and its unit: "m [g]", "t / s", "Zeit in s", "mass_g".

    "rpm" alone is the spin.
    """
    if len(text) > MAX_HEADER:
        return text, None
    if match := re.fullmatch(_BRACKET, text):
        name, square, round_ = match.groups()
        inside = (round_ if square is None else square).strip()
        if inside in ("-", "–", "—"):
            return split_unit(name)  # "Umdrehungen [-]"
        is_unit = bool(re.fullmatch(_CLOCK_FORM, inside)) or (
            _is_unit_of(name, inside) and not turns_in(inside)
        )
        is_unit |= len(inside) > 1 and len(kinds_of(inside)) == 1
        if (
            inside
            and not is_unit
            and all(squeeze(word).lower() in NOISE_WORDS for word in inside.split())
        ):
            return split_unit(name)  # "RPM (measured)"
        words = re.split(r"[\s,;]+", inside, maxsplit=1)
        if (
            len(words) > 1
            and not kinds_of(inside)
            and _is_unit_of(f"{name} {words[1]}", words[0])
        ):
            return name if name_roles(name)[0] else f"{name} {words[1]}", words[
                0
            ]  # "a (cm, from centre)"
        parted, own = ("", None) if is_unit else split_unit(name)
        if (
            own
            and not own.isdigit()
            and kinds_of(own)
            and (name[-1] in "])" or not kinds_of(inside))
        ):
            return f"{parted} {inside}", own  # "r [cm] (from centre)"
        if not is_unit and kinds_of(name) == {"rate"}:
            return "spin", name  # "turns per second (tachometer)"
        if not is_unit and name_roles(name)[0] == ("position",) and from_centre(inside):
            return name, None  # "Position (from the centre)"
        said = (
            name_roles(text)[0] or turns_in(inside)
            if name_roles(name)[0]
            else not kinds_of(inside)
        )
        if square is None and not is_unit and said:
            return text, None  # "czas (t)": a symbol, not a unit
        return name.rstrip(" /,;"), inside or None
    if match := re.fullmatch(_BRACKET_INSIDE, text):
        name = f"{match[1]} {match[3]}"  # "d (cm) from centre"
        is_unit = not turns_in(match[2]) and any(
            _is_unit_of(one, match[2]) for one in (match[1], name)
        )
        if is_unit and (name_roles(name)[0] or not name_roles(text)[0]):
            return name, match[2]
    if kinds_of(text) == {"rate"} and len(text.partition("/")[0].strip()) > 2:
        return "spin", text  # "toeren/min"
    if (
        (match := re.fullmatch(_TIME_PER, text))
        and kinds_of(match[1]) == {"time"}
        and re.search(_TURN, match[2])
    ):
        owner = ""
        if re.search(PRECESSION, match[2]):
            owner = "precession"
        elif re.search(SPINNING, match[2]):
            owner = "spin"
        return f"{owner} period" if owner else f"time per {match[2]}", match[
            1
        ]  # "sec per precession turn"
    match = re.fullmatch(r"([^\W\d][\w.]*)/(\S+)", text)
    if (
        match
        and kinds_of(match[2])
        and not kinds_of(text)
        and ("_" not in text or turns_in(match[1]))
    ):
        return match[1], match[2]  # "a/mm", "t_one_turn/ms"
    if match := re.fullmatch(r"(\w+?)_(rad|deg|rev)_(?:per_)?(s|min)", text):
        return match[1], f"{match[2]}/{match[3]}"
    if (
        (match := re.fullmatch(r"(.+)_([^_()]+)", text))
        and kinds_of(match[2])
        and re.search(r"[/(]|_.*_", text)
    ):
        return match[1].replace("_", " "), match[
            2
        ]  # "spin_speed_rad/s", "total_time_(3_turns)_s"
    match = re.fullmatch(_IN_UNIT, text)
    if (
        match
        and kinds_of(match[2]) in ({"length"}, {"time"})
        and not kinds_of(text[: match.end(2)])
    ):
        return f"{match[1]} {match[3]}", match[
            2
        ]  # "distance in cm from the centre", "x/cm from centre"
    if (
        (match := re.fullmatch(r"(\S+)\s+(.+)", text))
        and kinds_of(match[1]) == {"length"}
        and from_centre(match[2])
    ):
        return match[2], match[1]  # "cm from the centre"
    name, unit = (*re.split(r"[_\s]+(?=[^_\s]+$)", text), "")[:2]
    is_time = (unit == "s" and turns_in(name)) or re.fullmatch(_CLOCK_FORM, unit)
    if is_time or any(
        kind_of_role(role) in kinds_of(unit) for role in name_roles(name)[0]
    ):
        return (
            name,
            unit,
        )  # "period s" is not "periods"; "half_turn_s" and "time m:ss" are times
    if name_roles(text)[0]:
        own = (
            unit
            if name_roles(text)[0] == ("spin",) and kinds_of(unit) == {"rate"}
            else None
        )  # "ball rpm"
        return ("spin", text) if kinds_of(text) == {"rate"} else (text, own)
    small = [token for token in text.split() if squeeze(token).lower() in _SMALL_WORDS]
    tokens = [token for token in text.split() if token not in small]
    if "_" in text and kinds_of(text.partition("_")[0]) == {"rate"}:
        return split_unit(text.replace("_", " "))  # "rpm_start"
    if len(tokens) > 1 and any(kinds_of(token) == {"rate"} for token in tokens):
        tokens = [
            token for token in tokens if not re.search(SPINNING, token)
        ]  # "RPM ball"
    rest = " ".join(tokens)
    is_rate = kinds_of(rest) == {"rate"}
    # The shortest name comes first, so that "rad s^-1" is one unit; before a slash U is
    # not an uncertainty.
    parts = [
        (
            text[: match.start()].strip(" _/,;"),
            text[match.end() :].strip(" _").lstrip("/ "),
        )
        for separator in (r"(?<!\s)\s+(?:in|en|em|w|в|/)\s+", r"[\s_]+", r"[,;]", "/")
        for match in re.finditer(separator, text)
    ]
    # "时间 t/s" is a time in s, and not one in turns per second.
    for strict in (True, False):
        for name, unit in parts:
            fits = any(_measures(unit, role) for role in name_roles(name)[0])
            fits = fits or (
                "time" in kinds_of(unit) and bool(turns_in(name))
            )  # "time for 1 turn / s"
            fits = fits or (not strict and _is_unit_of(name, unit))
            is_name = unit not in ("h", "t", "r", "U", "об") and not (
                is_rate and name_roles(name)[0] == ("turns",)
            )
            # Of "how long for 1 turn", the turn is not a unit.
            of_turns = fits and "angle" in kinds_of(unit) and re.search(_TURN, unit)
            counted = bool(
                re.search("[0-9]", text) or words_of_turns(text.removesuffix(unit))
            )
            if fits and is_name and not (of_turns and counted):
                return name, unit
    if is_rate:
        return " ".join(("spin", *small)), rest  # "Rev/min", "RPM before"
    if len(kinds_of(text)) == 1 and not kinds_of(text).isdisjoint(
        ("angle", "mass", "length", "time")
    ):
        return "", text  # "cm" above the positions
    if (match := re.fullmatch(r"(.+)\s(?:/|in|en|em|w|в)\s+(\S+)", text)) and kinds_of(
        match[2]
    ):
        return match[1].strip(), match[2]  # "a in cm"
    name, _, unit = text.rpartition(",")
    if name_roles(name)[0] and unit.strip() and not re.search(_TURN, unit):
        return name.strip(), unit.strip()  # an unknown unit, which is reported
    return text, None


def _is_unit_of(name: str, unit: str) -> bool:
    found, kinds = name_roles(name.rstrip(" /,;"))[0], kinds_of(unit)
    if not found:
        return ("length" in kinds and from_centre(name)) or (
            "time" in kinds and bool(turns_in(name))
        )
    return any(_measures(unit, role) for role in found) or bool(
        kinds and not SYMBOLS.get(squeeze(unit))
    )


@lru_cache(maxsize=4096)
def name_roles(name: str) -> tuple[tuple[str, ...], int | None]:
    """Find the roles that a name without a unit may mean, and the number of a repeat."""
    if len(name) > MAX_HEADER:
        return (), None
    if found := _known(name) or _modified(name):
        return found, None
    match = re.fullmatch(_INDEX, name.strip())
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
    if (
        re.search(rf"{_FROM}$", name)
        and not re.search("[/,)]", name)
        and (origin_in(name) or from_centre(name))
    ):
        name = re.split(_FROM, name)[0]  # "pos. from ball surface"
    tokens = [token for token in _TOKENS.split(name) if token]
    if not 2 <= len(tokens) <= 8:
        return (
            _known(tokens[0])
            if len(tokens) == 1 and "position" in _known(tokens[0])
            else ()
        )
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


REPORTED = "reported_"
"""Beginning of the keys of a student's results."""


def is_key(key: str) -> bool:
    """Return whether a ``# key: value`` line gives a value, and is not a note."""
    return key.lower() in KEYS or key.lower().startswith(REPORTED)


def reported_key(key: str) -> str:
    """Return the key of a reported value.

    It is ``inertia`` for ``reported_I_zz`` and ``reported_moment_of_inertia``.
    """
    bare = key[len(REPORTED) :] if key.lower().startswith(REPORTED) else key
    return "inertia" if name_roles(bare)[0] == ("inertia",) else bare.lower()


def suggest_role(header: str) -> str:
    """Return the role whose name is nearly that of a header; "" if there is none."""
    name = re.split(r"[\[(]", split_unit(header)[0])[0].strip()
    key = squeeze(name).lower()
    if len(key) > 2 and (
        close := difflib.get_close_matches(key, NAMES, n=1, cutoff=0.75)
    ):
        return NAMES[close[0]][0]
    match = re.fullmatch(_INDEX, name)  # "T_P_1"
    return next(iter(name_roles(match[1])[0]), "") if match else ""


AND, _FILLERS, _PARTS = (
    tuple(vocabulary.words(key).split()) for key in ("and", "filler", "part")
)
"""Words between two numbers of one count, "one and a half"; between a count and "turn";
and "part of" one turn."""
_NUMBERS = dict(
    number.split("=")
    for number in _squeezed(",".join(vocabulary.words("number").split()))
)
_SIGNS = "|".join(
    sorted((word for word in _NUMBERS if chr(0x2E80) < word < chr(0xA000)), key=len)[
        ::-1
    ]
)
_SIGNS = f"(?<!第)(?:{_SIGNS})"
"""Numbers in languages without blanks between words."""
_TURN, _PERIOD, _ONE_TURN, _DIVIDED = map(
    vocabulary.pattern, ("turn", "period", "one_turn", "divided")
)
_PARTS_OF_ONE = {
    word: f"1{number}"[-3:]
    for word, number in _NUMBERS.items()
    if "/" in number and len(word) > 2
}
_JOINED = rf"(?i)\b({'|'.join(_PARTS_OF_ONE)})(?={_TURN})"
"""Joined words such as "Vierteldrehung"."""
_ONES = "|".join([*_FILLERS, *re.findall(r"(\S+)=1(?!\S)", vocabulary.words("number"))])
_AND_A_HALF = (
    rf"(?i){_TURN}\w*\s+(?:{'|'.join(AND)})\s+(?:an?\s+)?(?:half|halbe?|demie?|medi[ao]"
    rf"|mezz[ao]|meia)\b"
)
_COUNTED = (
    r"(?i)(?<![0-9.,/第])([0-9]{1,2}(?:[.,][0-9])?|[0-9]{1,2}\s*[/⁄]\s*[0-9]{1,2})\s*"
    rf"(?:(?:{_ONES}|d'|{PRECESSION})\s*){{0,3}}{_TURN}(?!\w*/\w)"
)
_MIXED = (
    rf"(?i)(?:^|\(|([^\W\d]{{1,20}})[\s_]{{1,20}})([1-9][0-9]?)\s+([1-9]/[2-9])\s*"
    rf"(?:of\s+)?(?:an?\s+)?{_TURN}"
)
_FOR = ("for", "of", "für", "pour", "de", "per", "para", "por")
_ALONE = (
    r"(?i)(?:t|time|Zeit|temps|tiempo|tempo|czas|время)[\s_(]*([1-9]\s*/\s*[2-9])\)?"
)
_PERIODS = r"([1-9][0-9]?)\s*[·*×]?\s*T(?!\w)"
_ANGLE = r"(?<![0-9.,])([1-9][0-9]{1,3})\s*([°º˚]|[^\W\d]+)"


@lru_cache(maxsize=4096)
def turns_in(header: str) -> str:
    """Find the turns that a header or a caption states: "1/3", "1", "2.5"; "" if it states none."""
    # Nearly all texts are units, numbers and known names, and the patterns below take
    # 20 ms to compile.
    if (header.isalpha() and kinds_of(header)) or not re.search(
        r"[^\W\d_]|[°º˚]", header
    ):
        return ""  # "rpm", "20.3"
    name, unit = split_unit(header) if len(header) < 30 else ("", None)
    known = (
        name.isascii()
        and name.isalpha()
        and name.lower() in NAMES
        and not re.search("[0-9]", header)
    )
    if known and (unit is None or kinds_of(unit)):
        return ""  # "time [s]", "revolutions"
    plain = _in_plain_words(header, unit)
    if len(header) > MAX_HEADER:
        return ""
    # Most texts name no turn: they need few of the patterns.
    names_turn = re.search(_TURN, plain) is not None
    counted = _count_of_turns(plain) if names_turn else None
    if counted is not None:
        return counted
    if match := re.match(_ALONE, plain) or re.match(_PERIODS, plain):
        return _in_digits(match[1])
    if part := _part_in_degrees(plain):
        return part
    if names_turn and (number := _number_of_turns(plain)):
        return number
    if re.search(_ONE_TURN, plain):
        return "1"
    if not re.search(_PERIOD, plain):
        return ""
    number = words_of_turns(re.split(_PERIOD, plain)[0])
    return "" if number == "1" else number


def _in_plain_words(header: str, unit: str | None) -> str:
    """Write a header without joined words such as "Vierteldrehung", and without "⅓"."""
    plain = "".join(
        f" {unicodedata.normalize('NFKC', c)}" if unicodedata.category(c) == "No" else c
        for c in header
    )
    for way, usual in vocabulary.WAYS["turns"]:
        plain = re.sub(way, usual, plain)
    if re.search(_TURN, plain):
        plain = re.sub(
            _JOINED, lambda joined: f"{_PARTS_OF_ONE[joined[1].lower()]} ", plain
        )
    if unit and "time" in kinds_of(unit):
        plain = re.sub(
            r"(?:(?<!\s)\s+)?/\s*\w+\W*$", "", plain
        )  # "time for one turn/s"
    return plain


def _count_of_turns(plain: str) -> str | None:
    """Return the number in digits next to a word for a turn.

    It is "" if the number cannot be read, and None if there is none.
    """
    if re.search(_AND_A_HALF, plain):
        return ""  # nothing here reads a number from "1 tour et demi"
    if re.search(_DIVIDED, plain) and re.search(
        rf"[0-9]\s*(?:\w{{1,30}}+\s+)?(?:{_TURN})", plain
    ):
        return "1"  # "we timed 3 turns and divided"
    if mixed := re.search(_MIXED, plain):
        # "Time 1 1/3 turn" may be the first of several.
        is_number = not mixed[1] or mixed[1].lower() in _FOR
        return str(int(mixed[2]) + Fraction(mixed[3])) if is_number else ""
    counted = re.search(_COUNTED, plain)
    return _in_digits(counted[1]) if counted else None


def _in_digits(number: str) -> str:
    return number.replace(" ", "").replace(",", ".").replace("⁄", "/")


def _part_in_degrees(plain: str) -> str:
    """Return the part of a turn that an angle of whole degrees is, such as 1/3; else ""."""
    match = re.search(_ANGLE, plain)
    if match is None or kinds_of(match[2]) != {"angle"}:
        return ""
    if units.parse(match[2]).text != "deg":
        return ""
    part = Fraction(int(match[1]), 360)
    return str(part) if part.denominator in (1, 2, 3, 4, 6, 12) else ""


def _number_of_turns(plain: str) -> str:
    """Return the number in words in front of a word for a turn; else ""."""
    for turn in re.finditer(rf"{_TURN}(?!\w*/\w)", plain):
        before = plain[: turn.start()]
        # "back at screw 1 (one turn)"
        number = words_of_turns(before.rpartition("(")[2]) or words_of_turns(before)
        if number and not (number == "1" and re.search(_NOT_COUNTED, before)):
            return number
    return ""


def is_of_turns(word: str) -> bool:
    """Return whether a word belongs to a count of turns: "full", "third", "turn", "precession"."""
    return (
        word in _FILLERS
        or word in _NUMBERS
        or bool(re.search(f"{_TURN}|{_ONE_TURN}|{PRECESSION}", word))
    )


def words_of_turns(text: str, whole: bool = False) -> str:
    """Read the last words before "turn" as a number; else return "".

    For example, "one third of a" is 1/3, "zwei" is 2, and "one and a half" is 3/2.

    With `whole` the text contains nothing else, as in a cell, and digits count: "5
    half" is 5/2.
    """
    tokens = filter(None, _TOKENS.split(re.sub(_SIGNS, r" \g<0> ", text.lower())))
    words = [
        word
        for word in tokens
        if word not in _FILLERS and not re.fullmatch(PRECESSION, word)
    ]
    words = [
        word if re.search("[0-9]", word) else squeeze(word).lower() for word in words
    ]
    numbers = [_NUMBERS.get(word, word) for word in words]
    if numbers[-1:] == ["1"] and "/" in "".join(numbers[-2:-1]):
        del words[-1], numbers[-1]  # "a third of one"
    if len(words) > 1 and words[-1] in _PARTS and "/" in numbers[-2]:
        del words[-1], numbers[-1]  # "trzecia część"
    if not words or words[-1] not in _NUMBERS:
        return ""
    *before, part = numbers
    if part.startswith("/"):
        count = before.pop() if before and before[-1].isdecimal() else ""
        part = (
            count or ("" if before or not whole else "1")
        ) + part  # "Drittel" alone in a cell
    mixed = before[-1:] != [] and before[-1] in AND
    before = before[: len(before) - mixed]
    count = before.pop() if before and before[-1].isdecimal() else ""
    # The digit of a header may number a trial, and not count parts of a turn.
    if before and before[-1] in _PARTS:
        return ""
    trial = bool(count) and not whole and words[len(before)].isdecimal()
    if part.startswith("/") or trial or (whole and before):
        return ""
    number = Fraction(part)
    return str(number + int(count) if mixed and count else number * int(count or 1))


_TURNS = r"(?:[1-9]\s+)?[1-9][0-9]?\s*/\s*(?:[2-9]|12)"
_COUNT = r"[1-9][0-9]?(?:[.,](?:0+|25|5|50|75|3{2,}|6+7?))?|[0.]*[.,](?:25|5|50|75|3{2,}|6+7?)"


def are_turns(header: Header, texts: Sequence[str]) -> bool:
    """Return whether the cells of a column with an unknown name count turns.

    An example is "how far" above 1/3, 2/3, 1.

    Fractions and words such as "one third" are enough; for other numbers the name must
    contain a word for a turn.
    """
    texts = [text for text in map(notation.fold_number, texts) if text]
    parts = [
        bool(
            re.fullmatch(_TURNS, text)
            or words_of_turns(text, whole=True)
            or turns_in(text)
        )
        for text in texts
    ]
    counts = [
        part or bool(re.fullmatch(_COUNT, text))
        for part, text in zip(parts, texts, strict=True)
    ]
    unknown = not header.roles and header.unit is None
    # "thirds of a turn" above 3 is something else.
    numbered = not _NUMBERS.keys().isdisjoint(
        _TOKENS.split(header.text.lower())
    ) and "/" not in turns_in(header.text)
    named = bool(re.search(_TURN, header.text)) and not numbered
    return unknown and bool(texts) and all(counts) and (any(parts) or named)


_WEIGHTS = vocabulary.pattern("weights")


def counts_weights(header: Header) -> bool:
    """Return whether a column counts the weights on the rod, as "number of weights" does."""
    return (
        header.unit is None
        and not header.roles
        and bool(re.search(rf"\b{_WEIGHTS}\b", header.text))
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


def clock_word(header: str) -> str:
    """Return "start" or "stop" for the readings of a running clock; else "".

    Examples of headers are "start (s)" and "t stop".
    """
    words = squeezed_words(header)
    if words & START_WORDS:
        return "start"
    return "stop" if words & END_WORDS else ""


def is_of_the_spin(header: str) -> bool:
    """Return whether a header says that turns of the ball are timed."""
    return bool(re.search(SPINNING, header)) and not re.search(PRECESSION, header)
