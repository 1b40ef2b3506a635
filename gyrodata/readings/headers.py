"""The headers of a table, each parsed once into a record."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from functools import lru_cache
from itertools import accumulate
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.quantities import notation, units, vocabulary
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import (
    END_WORDS,
    INDEX,
    MAX_HEADER,
    MEAN_WORDS,
    NAMES,
    NOISE_WORDS,
    PRECESSION,
    SMALL_WORDS,
    START_WORDS,
    SYMBOLS,
    THEORY_WORDS,
    TOKENS,
    TRIAL_WORDS,
    contains_word,
    name_roles,
    squeeze,
    squeezed_words,
)
from gyrodata.readings.origins import from_centre, origin_in, without_origin
from gyrodata.readings.remarks import altered_role
from gyrodata.readings.roles import kind_of_role
from gyrodata.readings.turns import NUMBERS, TURN, turns_in, words_of_turns

_FIRST_SIGN = "\u2e80"
"""Letters from this one on are signs of Chinese, Japanese or Korean, which are words.
"""


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
    name: str = ""
    """The text without its unit, its ± and the signs around them."""
    turns: str = ""
    """Turns that the text states: "1/3", "1", "2.5"; or ""."""
    origin: Literal["", "centre", "surface", "tip"] = ""
    """Where the text says that a position counts from."""
    moment: Literal["", "start", "end"] = ""
    """Part of a run to which the reading belongs, if the text says so."""
    is_of_means: bool = False
    """Whether the text says that the values are means."""
    is_of_the_spin: bool = False
    """Whether the text says that the ball turns, and not the rod."""


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
_WIDE_BRACKETS = str.maketrans("（）［］【】₀₁₂₃₄₅₆₇₈₉", "()[][]0123456789")
_ORDINAL = r"(?:#|№|第|n[or]?[°º.]?)?([1-9][0-9]?)(?:st|nd|rd|th|er|re|ème|e|ª|º|[.)]|回目?|次)?"
SPINNING = vocabulary.pattern("spinning")
_SWEPT = ("rotation", "precession", "drehung", "präzession", "précession", "прецессия")
"""Names that mean an angle in degrees, and else a rate."""


@lru_cache(maxsize=4096)
def parse_header(text: str) -> Header:
    """Read one header from left to right."""
    header = _parse(text)
    if len(text) > MAX_HEADER:
        return header
    return replace(
        header,
        name=split_unit(text)[0],
        turns=turns_in(text),
        origin=origin_in(text) or ("centre" if from_centre(text) else ""),
        moment=_moment(text),
        is_of_means=contains_word(text, MEAN_WORDS),
        is_of_the_spin=is_of_the_spin(text),
    )


def _parse(text: str) -> Header:
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
    if contains_word(text, THEORY_WORDS):
        return Header(text, (), unit, spread)  # worked out, not measured
    found, number = name_roles(name)
    if not found:
        found = name_roles(without_origin(name))[0]
    if not found and not text.islower():
        parted = re.sub(r"(?:(?<=[a-z]{3})|(?<=\bn))(?=[A-Z])", "_", text)
        if parted != text and (header := _parse(parted)).roles:
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
            for token in TOKENS.split(spaced)
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
    elif not found and kinds == {"rate"} and is_of_the_spin(name) and not _moment(name):
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
        and re.search(TURN, match[2])
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
    small = [token for token in text.split() if squeeze(token).lower() in SMALL_WORDS]
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
            of_turns = fits and "angle" in kinds_of(unit) and re.search(TURN, unit)
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
    if name_roles(name)[0] and unit.strip() and not re.search(TURN, unit):
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


TURNS = r"(?:[1-9]\s+)?[1-9][0-9]?\s*/\s*(?:[2-9]|12)"
COUNT = r"[1-9][0-9]?(?:[.,](?:0+|25|5|50|75|3{2,}|6+7?))?|[0.]*[.,](?:25|5|50|75|3{2,}|6+7?)"
_WEIGHTS = vocabulary.pattern("weights")


def counts_weights(header: Header) -> bool:
    """Return whether a column counts the weights on the rod, as "number of weights" does."""
    return (
        header.unit is None
        and not header.roles
        and bool(re.search(rf"\b{_WEIGHTS}\b", header.text))
    )


def _moment(header: str) -> Literal["", "start", "end"]:
    """Return the part of a run that a header names, as "start (s)" and "t stop" do."""
    words = squeezed_words(header)
    if words & START_WORDS:
        return "start"
    return "end" if words & END_WORDS else ""


def is_of_the_spin(header: str) -> bool:
    """Return whether a header says that turns of the ball are timed."""
    return bool(re.search(SPINNING, header)) and not re.search(PRECESSION, header)


def are_turns(header: Header, texts: Sequence[str]) -> bool:
    """Return whether the cells of a column with an unknown name count turns.

    An example is "how far" above 1/3, 2/3, 1.

    Fractions and words such as "one third" are enough; for other numbers the name must
    contain a word for a turn.
    """
    texts = [text for text in map(notation.fold_number, texts) if text]
    parts = [
        bool(
            re.fullmatch(TURNS, text)
            or words_of_turns(text, whole=True)
            or turns_in(text)
        )
        for text in texts
    ]
    counts = [
        part or bool(re.fullmatch(COUNT, text))
        for part, text in zip(parts, texts, strict=True)
    ]
    unknown = not header.roles and header.unit is None
    # "thirds of a turn" above 3 is something else.
    numbered = not NUMBERS.keys().isdisjoint(
        TOKENS.split(header.text.lower())
    ) and "/" not in turns_in(header.text)
    named = bool(re.search(TURN, header.text)) and not numbered
    return unknown and bool(texts) and all(counts) and (any(parts) or named)


def suggest_role(header: str) -> str:
    """Return the role whose name is nearly that of a header; "" if there is none."""
    name = re.split(r"[\[(]", split_unit(header)[0])[0].strip()
    key = squeeze(name).lower()
    if len(key) > 2 and (
        close := difflib.get_close_matches(key, NAMES, n=1, cutoff=0.75)
    ):
        return NAMES[close[0]][0]
    match = re.fullmatch(INDEX, name)  # "T_P_1"
    return next(iter(name_roles(match[1])[0]), "") if match else ""
