"""The headers of a table, each parsed once into a record.

A header is a name and perhaps a unit: "m [g]", "m (g)", "m / g", "m in g", "m, g",
"mass_g", "cm from the centre", or a unit alone.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache

from msgspec.structs import replace

from gyrodata.quantities import numerals, units
from gyrodata.quantities.units import kinds_of
from gyrodata.readings import roles
from gyrodata.readings.names import (
    FIRST_SIGN,
    MAX_HEADER,
    MEAN_WORDS,
    OF_TURNS,
    SPHERE,
    THEORY_WORDS,
    TOKENS,
    Header,
    Phrases,
    bare_roles,
    contains_word,
    exact_roles,
    fold_name,
    from_centre,
    is_of_the_spin,
    measures,
    moment_in,
    origin_in,
    squeezed_words,
    word_set,
)
from gyrodata.readings.roles import BY_NAME
from gyrodata.readings.turns import (
    NUMBERS,
    names_turns,
    turns_in,
    words_of_turns,
)


@lru_cache(maxsize=4096)
def parse_header(text: str) -> Header:
    """Read one header: mostly a known name, and perhaps a unit in brackets."""
    if len(text) > MAX_HEADER:
        return Header(text)
    header = _usual_header(text)
    if header is None:
        from gyrodata.readings.unusual_headers import unusual_header

        header = unusual_header(text)
    # In "time for one turn/s", only the name states the turns.
    turns = turns_in(text) or turns_in(header.name)
    if not (turns or header.roles) and (timed := _time_of_symbol(text)):
        return timed
    return replace(
        header,
        turns=turns,
        origin=origin_in(text) or ("centre" if from_centre(text) else ""),
        moment=moment_in(text),
        is_of_means=contains_word(text, MEAN_WORDS),
        is_of_the_spin=is_of_the_spin(text),
    )


def _time_of_symbol(text: str) -> Header | None:
    """Read "t_1/3 (s)" and "3T (s)": the time of a third of a turn, and of three."""
    matches = (pattern.fullmatch(text) for pattern in _TURNS_BESIDE_SYMBOL)
    match = next(filter(None, matches), None)
    if match is None:
        return None
    symbol = parse_header(match["symbol"] + match["rest"])
    if "time" not in symbol.kinds:
        return None
    if {"time", "precession_period"}.isdisjoint(symbol.roles):
        return None
    return replace(symbol, text=text, roles=("time",), turns=match["turns"])


_TURNS_BESIDE_SYMBOL = tuple(
    re.compile(pattern)
    for pattern in (
        r"(?P<symbol>[^\W\d_])_?[{(]?(?P<turns>1/[2-9]|2/3|3/4)[)}]?(?P<rest>\W.*)",
        r"(?P<turns>[1-9][0-9]?)\s?[x×*·]?\s?(?P<symbol>[Tτ])(?P<rest>\s*[\[(,/].*)",
    )
)


def _usual_header(text: str) -> Header | None:
    """Read a known name and perhaps its unit: "run", "mass [g]", "T (s)".

    None for every other header: `unusual_header` reads it.
    """
    match = _USUAL.fullmatch(text)
    if match is None:
        return None
    name = match[1]
    unit = match[2]
    roles = _fitting_roles(exact_roles(name), name, unit)
    return Header(text, roles, unit, name=name) if roles else None


def _fitting_roles(
    roles: tuple[str, ...], name: str, unit: str | None
) -> tuple[str, ...]:
    """Return the roles that a name surely means next to its unit."""
    has_unit_inside = "_" in name and name not in BY_NAME  # "time_s"
    if has_unit_inside or contains_word(name, THEORY_WORDS):
        return ()
    if unit is not None:
        return tuple(role for role in roles if measures(unit, role))
    if kinds_of(name) not in _KINDS_OF_NAMES:
        return ()
    return bare_roles(roles)


_USUAL = re.compile(
    r"([^\W\d_]+|[a-z]+_[a-z]+)(?:\s[\[(]([^\s\[\]()/]+|rad/s|rev/s)[\])])?"
)


_KINDS_OF_NAMES = (frozenset[str](), OF_TURNS)
"""Kinds of a word that can be a name: it is no unit, or a unit and a name, as
"revolutions"."""


# --- Questions about a header ---


def can_measure(header: Header) -> bool:
    """Return whether the unit of a header fits one of its roles."""
    return header.unit is None or any(
        measures(header.unit, role) for role in header.roles
    )


def counts_turns(header: Header) -> bool:
    """Return whether the unit of a header is that of turns, as in "far (turns)"."""
    return header.kinds == OF_TURNS


def is_one_letter(unit: str) -> bool:
    """Return whether a unit is one letter: V may be volt, T tesla, m any length.

    A sign of Chinese or Japanese is a word.
    """
    folded = units.fold_letters(unit)
    letters = folded.strip(". ")
    return len(letters) == 1 and letters.isalpha() and letters < FIRST_SIGN


_WEIGHTS = word_set("weights")


def counts_weights(header: Header) -> bool:
    """Return whether a column counts the weights on the rod: "number of weights"."""
    if header.roles or header.unit is not None:
        return False
    return not _WEIGHTS.isdisjoint(squeezed_words(header.text))


def are_turns(header: Header, texts: Sequence[str]) -> bool:
    """Return whether the cells of a column with an unknown name count turns.

    An example is "how far" above 1/3, 2/3, 1.

    Fractions and words such as "one third" are enough; for other numbers the name must
    contain a word for a turn.
    """
    cells = [numerals.fold_number(text) for text in texts if text]
    if header.roles or header.unit is not None or not cells:
        return False
    if all(_is_part_of_turns(cell) or _may_count_turns(cell) for cell in cells):
        return any(map(_is_part_of_turns, cells)) or _names_whole_turns(header)
    return False


def _is_part_of_turns(cell: str) -> bool:
    """Return whether a cell states turns as a fraction or in words."""
    above, _, below = cell.replace(" ", "").partition("/")
    is_fraction = above.strip("0").isdecimal() and below.isdecimal()
    if is_fraction and 1 < int(below) <= 12:
        return True
    words = words_of_turns(cell, whole=True) or turns_in(cell)
    return words != ""


def _names_whole_turns(header: Header) -> bool:
    """Return whether a header names turns, and not "thirds of a turn" above 3."""
    counts_parts = contains_word(header.text, NUMBERS) and "/" not in header.turns
    return names_turns(header.text) and not counts_parts


def _may_count_turns(cell: str) -> bool:
    """Return whether a cell is a number of thirds or of quarters of a turn."""
    if not numerals.PLAIN.fullmatch(cell):
        return False
    twelfths = 12 * numerals.to_float(cell)
    is_part = min(twelfths % 3, -twelfths % 3, twelfths % 4, -twelfths % 4) < 0.1
    return 0 < twelfths < 1200 and is_part


def names_timing(header: Header) -> bool:
    """Return whether a header names the time, the period or the rate of a run."""
    return not set(roles.TIMINGS).isdisjoint(header.roles)


def may_number(header: Header) -> bool:
    """Return whether a column such as "n" or "count" may number the runs."""
    is_counter = len(header.text) == 1 or header.text.lower() == "count"
    return header.unit is None and is_counter


def unused_words(header: Header) -> tuple[str, ...]:
    """Return the numbers, and words for the ball or the tip, that no rule has used."""
    if exact_roles(header.name):
        return ()
    uses_number = header.turns or header.number is not None
    uses_place = header.origin or any(role[:4] == "spin" for role in header.roles)
    return tuple(
        word
        for word in TOKENS.split(header.name)
        if (_says_number(word) and not uses_number)
        or (not uses_place and (SPHERE.is_in(word) or _TIP.is_in(word)))
    )


def _says_number(word: str) -> bool:
    """Return whether a word contains a digit, or is a number; "от" is no "öt"."""
    is_name = len(word) > 2 and fold_name(word) in NUMBERS
    return is_name or numerals.has_digit(word)


_TIP = Phrases("tip")
