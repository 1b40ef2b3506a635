"""Headers in other forms than a name with a unit in brackets.

Their unit may stand behind a slash, a comma, a blank or "in", in front of the name, or
alone; and the name may have a meaning only next to the unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

from gyrodata.quantities import numerals
from gyrodata.quantities.units import kinds_of
from gyrodata.readings.names import (
    MAX_HEADER,
    MOTION_WORDS,
    OF_TURNS,
    SMALL_WORDS,
    SYMBOLS,
    THEORY_WORDS,
    TOKENS,
    TRIAL_WORDS,
    Header,
    bare_roles,
    contains_word,
    fold_name,
    from_centre,
    is_of_the_spin,
    measures,
    moment_in,
    name_roles,
    origin_in,
    squeeze,
)
from gyrodata.readings.turns import (
    names_turns,
    turns_in,
    words_of_turns,
)

_WIDE_SIGNS = str.maketrans("（）［］【】₀₁₂₃₄₅₆₇₈₉", "()[][]0123456789", "${}")
_SPREAD = (
    r"(?:[\[(]\s*|(?<!\s)\s+)?(?:±|\+/-|\+-)\s*"
    r"([0-9]+(?:[.,][0-9]+)?)\s*([^\])\[(,;]*)[\])]?"
)


def unusual_header(text: str) -> Header:
    """Read one header: its ± first, then its unit, then its name."""
    typed, spread = _take_spread(text.translate(_WIDE_SIGNS).rstrip("*†‡: "))
    name, unit = split_unit(typed)
    unit = _meant_unit(unit, spread)
    roles, number = _roles_in(name, unit)
    if contains_word(text, THEORY_WORDS):
        roles = ()  # worked out, not measured
        number = None
    return Header(text, roles, unit, spread, number, name=name)


def _meant_unit(unit: str | None, spread: str) -> str | None:
    """Return the unit of the cells; that of the ± if the header has no other."""
    unit_of_spread = spread.partition(" ")[2]
    if unit is None and kinds_of(unit_of_spread):
        return unit_of_spread
    if unit and _is_form_of_clock(unit):
        return "s"  # its cells say themselves how they are written
    return unit


def _is_form_of_clock(unit: str) -> bool:
    """Return whether a unit says how times are written, such as "mm:ss.cc"."""
    first, _, others = unit.partition(":")
    letters = f"{first}{others}".translate(_SIGNS_OF_CLOCK)
    is_form = first != "" and others != ""
    return is_form and letters.isascii() and letters.isalpha()


_SIGNS_OF_CLOCK = {ord(sign): None for sign in ".:0"}


def _take_spread(text: str) -> tuple[str, str]:
    """Return a header without its ±, and the text of the ±."""
    match = re.search(_SPREAD, text)
    if match is None:
        return text, ""
    before = text[: match.start()].strip()
    behind = text[match.end() :].strip()
    spread = f"{match[1]} {match[2].strip()}"
    return f"{before} {behind}".strip(" ,;"), spread.strip()


# --- Where the unit is ---


class _Split(NamedTuple):
    """A way to split a header into a name and a unit."""

    name: str
    unit: str
    mark: Literal["bracket", "sign", ""]
    """What sets the unit apart: a bracket at the end, a slash or "in"; else ""."""


_BRACKET = r"\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\)"
IN = ("in", "en", "em", "w", "в")
"""Words between a quantity and its unit."""
_WORD = rf"(?<!\s)\s+(?:{'|'.join(IN)}|/)\s+"
_BLANK = r"(?<![/\s])[\s_,;]+(?!/)"


def split_unit(text: str) -> tuple[str, str | None]:
    """Split a header into its name and its unit, known or not; None if it has none."""
    splits = _splits_with_units(text)
    # First a unit that the named quantity can have,
    split = _first(_fits, splits)
    if split is None:
        # then any other in a bracket at the end: it is wrong, and the caller says so,
        in_brackets = [split for split in splits if split.mark == "bracket"]
        split = _first(_is_set_apart, in_brackets)
    if split is None and not name_roles(text)[0]:
        # and last, unless the whole header is a name, any that is set apart.
        split = _first(_is_set_apart, splits) or _unknown_unit(text)
    if split is None:
        return text, None
    return split.name, split.unit


def _splits_with_units(text: str) -> list[_Split]:
    """Return the ways to split a header at a unit, the most certain one first."""
    if len(text) > MAX_HEADER or numerals.PLAIN.fullmatch(text):
        return []
    return [split for split in _splits(text) if _is_unit(split.unit)]


def _first(test: Callable[[_Split], bool], splits: list[_Split]) -> _Split | None:
    return next(filter(test, splits), None)


def _splits(text: str) -> Iterator[_Split]:
    """Yield the ways to split a header, the most certain one first."""
    yield from _splits_at_brackets(text)
    yield from _splits_at_signs(_WORD, text)
    blanks = list(re.finditer(_BLANK, text))
    pairs = [(text[: blank.start()], text[blank.end() :]) for blank in blanks]
    for first, last in pairs:
        yield _Split(first, last, "")
    bare = text.replace("_per_", "_")
    words = bare.split("_")
    if len(words) > 2 and text.isascii():
        name = "_".join(words[:-2])
        yield _Split(name, "/".join(words[-2:]), "")  # "spin_rev_per_s"
    yield from _splits_at_signs("/", text)
    for first, last in pairs:
        yield _Split(last, first, "")
    yield _Split("", text, "")


def _splits_at_signs(sign: str, text: str) -> Iterator[_Split]:
    """Yield the splits at each sign: "a / cm", "distance in cm from the centre"."""
    for match in re.finditer(sign, text):
        name = text[: match.start()].strip()
        behind = text[match.end() :].strip()
        yield _Split(name, behind, "sign")
        unit, _, more = behind.partition(" ")
        if more:
            yield _Split(f"{name} {more}", unit, "sign")


def _splits_at_brackets(text: str) -> Iterator[_Split]:
    """Yield the splits at each bracket, the last one first: "a (cm, from centre)"."""
    for bracket in reversed(list(re.finditer(_BRACKET, text))):
        before = text[: bracket.start()].rstrip(" /,;")
        behind = text[bracket.end() :].strip()
        name = f"{before} {behind}".strip()
        inside = (bracket[1] or bracket[2] or "").strip()
        yield _Split(name, inside, "" if behind else "bracket")
        unit, _, remark = inside.replace(",", " ").partition(" ")
        yield _Split(f"{name} {remark.strip()}", unit, "")


def _is_unit(text: str) -> bool:
    if not any(map(str.isalpha, text)) and _OTHER_UNITS.isdisjoint(text):
        return False
    return text == "%" or bool(kinds_of(text)) or _is_form_of_clock(text)


_OTHER_UNITS = frozenset("°%")


def _fits(split: _Split) -> bool:
    """Return whether a quantity of this name can have the unit."""
    if not split.mark and kinds_of(split.unit) == OF_TURNS:
        return False  # "fraction of turn"
    last_word = split.name.rpartition(" ")[2]
    if split.mark != "bracket" and last_word and not last_word.strip("0123456789.,/"):
        return False  # "7 min"
    roles, _ = _roles_in(split.name, split.unit)
    return any(measures(split.unit, role) for role in roles)


def _is_set_apart(split: _Split) -> bool:
    """Return whether a known unit is meant as one, although the name cannot have it."""
    if not split.name:
        kinds = kinds_of(split.unit)
        return split.mark == "bracket" or kinds in _KINDS_OF_BARE_UNITS
    if name_roles(split.name)[0]:
        is_name = not split.mark and kinds_of(split.unit) == OF_TURNS
        return not is_name and squeeze(split.unit) not in SYMBOLS
    if kinds_of(split.unit) == {"rate"} and split.unit.isalpha():
        return True  # "rpm at half time"
    is_one_word = " " not in split.name
    return split.mark == "bracket" or (is_one_word and split.mark == "sign")


_KINDS_OF_BARE_UNITS = [{"angle"}, {"mass"}, {"length"}, {"time"}, {"rate"}]


def _unknown_unit(text: str) -> _Split | None:
    """Split off a text at the place of a unit that is none; None if there is none."""
    if len(text) > MAX_HEADER:
        return None
    start = {"]": "[", ")": "("}.get(text[-1:], ",")
    before, _, behind = text.rpartition(start)
    name = before.strip()
    unit = behind.strip("]) ")
    is_remark = contains_word(unit, SMALL_WORDS) or names_turns(unit)
    # "Turns (thirds)" counts thirds.
    is_count = turns_in(unit) or words_of_turns(unit, whole=True)
    if not name or not unit or is_remark or is_count:
        return None
    is_known = start == "[" or name_roles(name)[0]
    if not is_known:
        return None
    return _Split(name, unit, "bracket")


# --- The meaning of a name next to its unit ---


def _roles_in(name: str, unit: str | None) -> tuple[tuple[str, ...], int | None]:
    """Return the roles that a name means next to a unit, and the number of a repeat.

    If the named quantity cannot have the unit, the unit is wrong: the roles stay.
    """
    if unit is None:
        return _roles_without_unit(name)
    named, number = name_roles(name)
    fitting = tuple(role for role in named if measures(unit, role))
    if fitting:
        return fitting, number
    kinds = kinds_of(unit)
    if not named:
        return _roles_of_statement(name, kinds)
    other = _in_other_unit(name, named, unit)
    if other:
        return other, number
    # A symbol says less than a unit: "D (s)" is not a torque.
    is_symbol = len(name.strip()) == 1 and bool(kinds)
    return (() if is_symbol else named), number


def _roles_without_unit(name: str) -> tuple[tuple[str, ...], int | None]:
    """Return the roles that a name means on its own."""
    named, number = name_roles(name)
    if named[1:] and named[0].startswith("u_"):
        return named, number  # the unit of its reading decides
    # A bare "N" counts turns: the other readings would need a unit.
    return bare_roles(named), number


def _in_other_unit(name: str, named: tuple[str, ...], unit: str) -> tuple[str, ...]:
    """Return what a name means in the unit of a related quantity."""
    kinds = kinds_of(unit)
    other = _IN_OTHER_UNITS.get((*named, *kinds), ())
    if not other and contains_word(name, MOTION_WORDS):
        return _MOTION.get(kinds, ())
    return other


_IN_OTHER_UNITS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("mass", "force"): ("force",),
    ("turns", "rate"): ("spin",),
    ("turns", "angle"): ("angle",),
    ("precession_rate", "time"): ("time", "precession_period"),
}
"""What a role becomes next to a unit of another kind: "Weight (N)"."""
_MOTION = {frozenset({"angle"}): ("angle",), OF_TURNS: ("turns",)}
"""What "rotation" and "precession" mean in units that no rate has."""


def _roles_of_statement(
    name: str, kinds: frozenset[str]
) -> tuple[tuple[str, ...], int | None]:
    """Return the roles of a header that names no quantity, but says something of it."""
    if "time" in kinds:
        return (("time",), None) if turns_in(name) else _number_of_trial(name)
    if kinds == {"rate"} and _says_only_when(name):
        return (f"spin_{moment_in(name)}".rstrip("_"),), None
    if "length" in kinds and (origin_in(name) or from_centre(name)):
        return ("position",), None
    return (), None


def _says_only_when(name: str) -> bool:
    """Return whether a name only says that it is a spin, or when it was measured."""
    words = {fold_name(word) for word in TOKENS.split(name) if word}
    return is_of_the_spin(name) or words <= SMALL_WORDS


_BEFORE_NUMBERS = frozenset(["", "#", "№", "第", "n", "no", "nr", "n°", "no.", "nr."])
_BEHIND_NUMBERS = frozenset(
    ["", "st", "nd", "rd", "th", "er", "re", "ème", "e", "ª", "º", ".", ")", "回", "次"]
)
"""Signs of an ordinal number: "#2", "2nd"."""


def _number_of_trial(name: str) -> tuple[tuple[str, ...], int | None]:
    """Read "Trial 2" and "2nd measurement" above times: the time, and the number."""
    words = [word for word in TOKENS.split(name) if word]
    numbers = {word: _ordinal(word) for word in words}
    others = [word for word in words if numbers[word] is None]
    if len(words) - len(others) == 1 and all(map(_names_trial, others)):
        [number] = filter(None, numbers.values())
        return ("time",), number
    return (), None


def _ordinal(word: str) -> int | None:
    """Return the number in "2", "#2", "2nd" and "Trial2"."""
    digits = "".join(filter(str.isdecimal, word))
    before, _, behind = word.partition(digits or " ")
    name = before.lower()
    is_ordinal = name in _BEFORE_NUMBERS and behind.lower() in _BEHIND_NUMBERS
    is_number = is_ordinal or (behind == "" and _names_trial(before))
    is_small = digits[:1] > "0" and len(digits) <= 2
    return int(digits) if is_number and is_small else None


def _names_trial(word: str) -> bool:
    """Return whether a word means a time, or a repeat of one."""
    return fold_name(word) in TRIAL_WORDS or "time" in name_roles(word)[0]
