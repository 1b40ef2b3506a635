"""Kinds of quantity and their units: a unit that a student writes becomes an SI factor.

One rule splits a unit text with symbols in many languages, products, powers and
look-alike letters; the symbols, each with its SI factor, are in `vocabulary.toml`. Pint
converts any other name of a usual unit, such as "ounces" or "milliseconds"; it takes
0.3 s to load, and nothing else uses it. Pint does not get symbols: it reads ``Nm`` as a
textile unit, ``U/min`` as an enzyme activity, and 1 Hz as 1 rad/s.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Collection, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from msgspec import Struct, convert
from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.quantities import vocabulary

MAX_UNIT_LENGTH = 64
"""Characters in a unit text; longer ones are refused unread."""
RPM = math.pi / 30
"""One revolution per minute [rad/s]."""
STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2] (CGPM 1901): for the kilogram-force, and
for a log without g."""


class UnitError(ValueError):
    """A quantity or a unit that cannot be read.

    The message follows the text that cannot be read; `hint` says what to write, and
    `code` names the diagnostic.
    """

    def __init__(
        self, message: str, hint: str = "", code: str = diagnostics.UNIT_UNKNOWN
    ) -> None:
        super().__init__(message)
        self.hint, self.code = hint, code


class Uncertainty(Struct, frozen=True):
    """Standard uncertainty of a reading: a fixed part plus a proportional part.

    It is the plain sum of the two parts, as in data sheets.

    Attributes
    ----------
    absolute : float
        Fixed part [SI unit of the role].
    relative : float
        Part proportional to the reading [1].
    """

    absolute: float = 0.0
    relative: float = 0.0

    def at(self, value: float) -> float:
        """Return the standard uncertainty of one reading."""
        return self.absolute + self.relative * abs(value)


class Kind(Struct, frozen=True):
    """A kind of quantity."""

    si: str
    """Unit in which it is kept inside."""
    shown: str
    """Unit in which it is shown, and which a message proposes."""
    words: str
    """With its article."""
    limits: tuple[float, float] | None = None
    """Smallest and largest possible size in a lab [SI unit], except zero."""
    examples: str = "the number alone"
    """Units to propose."""
    also: tuple[str, ...] = ()
    """Units of other dimensions that measure the same."""
    in_words: str = ""
    """Units of pint, with any prefix, that may be written as a word; "hand" and "point"
    are lengths there too."""


KINDS = convert(vocabulary.KINDS, dict[str, Kind])
"""Every kind of quantity, by name."""
SI = {name: kind.si for name, kind in KINDS.items()}
"""Unit in which each kind of quantity is kept inside."""
DISPLAY = {name: kind.shown for name, kind in KINDS.items()}
"""Unit in which each kind of quantity is shown, and which a message proposes."""
LIMITS = {name: kind.limits for name, kind in KINDS.items() if kind.limits}
"""Smallest and largest size of each kind [SI unit]."""


class Dimensions(NamedTuple):
    """Powers of mass, length, time, radians and revolutions.

    Radians and revolutions differ here.
    """

    mass: int = 0
    length: int = 0
    time: int = 0
    angle: int = 0
    turn: int = 0


class Unit(Struct, frozen=True):
    """A unit.

    Attributes
    ----------
    text : str
        Spelling that this tool reads back: ``kg*m^2``, ``m/s^2``.
    factor : float
        SI value of one such unit.
    dimensions : Dimensions
        A unit in words, which pint converts, has none.
    """

    text: str
    factor: float
    dimensions: Dimensions = Dimensions()


class Letters(dict[int, int | str | None]):
    """A table for ``str.translate`` that also removes marks.

    The marks are those of some Unicode categories, from a letter on.
    """

    def __init__(
        self,
        table: Mapping[int, str | int | None],
        categories: Collection[str],
        first: str = "",
    ) -> None:
        super().__init__(table)
        self.categories, self.first = categories, first

    def __missing__(self, code: int) -> int | None:
        """Decide about a letter when it is first seen."""
        letter = chr(code)
        is_gone = (
            letter >= self.first and unicodedata.category(letter) in self.categories
        )
        self[code] = kept = None if is_gone else code
        return kept


# Letters of other alphabets that look like Latin letters become these. Capital and
# small letters are listed one by one, because "н" is not an "h". For `re`, the vowel
# signs of Hindi, Thai and Arabic are not letters.
_LOOK_ALIKES = Letters(
    str.maketrans(
        "АВЕКМНОРСТУХІавекмнорстухі" + "ΑΒΕΖΗΙΚΜΝΟΡΤΥΧο" + "∆µʹ′″⁄",
        "ABEKMHOPCTYXIabekmhopctyxi" + "ABEZHIKMNOPTYXo" + "Δμ''\"/",
    ),
    categories=("Mn", "Mc", "Me"),
    first="\u0590",
)


@lru_cache(maxsize=4096)
def fold_letters(text: str) -> str:
    """Replace compatibility forms and look-alike letters of other alphabets.

    Upper and lower case are kept.
    """
    if text.isascii():
        return text
    for ring in "º˚\u030a":
        text = text.replace(ring, "°")
    return unicodedata.normalize("NFKC", text).translate(_LOOK_ALIKES)


_BASES = {unit: Dimensions(*powers) for unit, powers in vocabulary.BASES.items()}
_SYMBOLS: dict[str, Unit] = {}
for _spelling, _line in vocabulary.UNITS.items():
    _factor, _base, *_words = [*_line.split(), _spelling]
    _SYMBOLS |= dict.fromkeys(
        map(fold_letters, _words), Unit(_spelling, float(_factor), _BASES[_base])
    )
for _spelling in ("rev", "min", "s"):
    for _word in vocabulary.words(_spelling).split():
        _SYMBOLS.setdefault(fold_letters(_word), _SYMBOLS[_spelling])
# Case is forgiven ("KG", "Sec") unless it separates milli from mega.
_MEGA = {"Mg", "MG", "MN", "Ms", "MS", "MHz", "MHZ", "Mrad"}
_ANY_CASE = {_word.lower(): _unit for _word, _unit in reversed(_SYMBOLS.items())}

_LETTERS = frozenset("gmsh")
"""Units of one letter whose capital is forgiven too."""

_TOKEN = re.compile(
    r"\s*+([*/]?)\s*+(?:([^\W\d_]+\.?(?:[^\W\d_]+\.?)*|°)(?:\s*\^?\s*([-+]?\d{1,3}))?|\^?1(?!\d)|$)"
)
_PRODUCT_SIGNS = str.maketrans("·⋅∙×•−–‐‑÷∕", "*****----//")
_USUAL = [
    (way.replace("PER", vocabulary.words("per", "|")), usual)
    for way, usual in vocabulary.WAYS["unit"]
]


_SCALED = r"(?:\*?\s*10(?:\^|(?=[-+]))([-+]?[0-9]{1,2})|[x*]\s*1(0+)|1/1(0+))[\s*]*([^\W\d].*)"
"""A power of ten and a unit: "10^-3 kg", "x100 rpm", "1/100 s"."""


def _product(word: str) -> list[Unit]:
    """Return the units of a product without ``*``; empty if the word is not a product.

    It may be written "N.m", or "Nm" and "gcm": then its last symbol is a length.
    """
    bare = word.replace(".", "")
    with_dots = word.strip(".").split(".")
    for parts in (with_dots, [bare[:-2], bare[-2:]], [bare[:-1], bare[-1:]]):
        if all(part in _SYMBOLS for part in parts):
            symbols = [_SYMBOLS[part] for part in parts]
            if parts is with_dots or symbols[-1].dimensions == _BASES["m"]:
                return symbols
    return []


@lru_cache(maxsize=1024)
def parse(text: str) -> Unit:
    """Read a unit text: symbols with powers, and ``*`` or ``/`` between them; a turn has 2π."""
    if len(text) > MAX_UNIT_LENGTH:
        raise UnitError(
            f"a unit of {len(text)} characters; at most {MAX_UNIT_LENGTH} are read"
        )
    rest = (
        fold_letters(text.strip()).translate(_PRODUCT_SIGNS).replace("**", "^").strip()
    )
    for way, usual in _USUAL:
        rest = re.sub(way, usual, rest)
    if scaled := re.fullmatch(_SCALED, rest):
        power, unit = (
            int(scaled[1] or 0) + len(scaled[2] or "") - len(scaled[3] or ""),
            parse(scaled[4]),
        )
        return Unit(
            f"10^{power} {unit.text}",
            float(f"1e{power}") * unit.factor,
            unit.dimensions,
        )
    letter = text.strip()
    is_letter = len(letter) == 1 and letter.isascii() and letter.isalpha()
    if is_letter and letter not in _SYMBOLS and letter.lower() not in _LETTERS:
        raise UnitError(
            f'the unit "{text}" is not known'
        )  # V and T are not turns, although v and t are
    up: list[str] = []
    down: list[str] = []
    dimensions, factor, position = Dimensions(), 1.0, 0
    while position < len(rest):
        match = _TOKEN.match(rest, position)
        word = (match and match[2]) or ""
        bare = word.replace(".", "")
        known = _SYMBOLS.get(bare) or (
            _ANY_CASE.get(bare.lower()) if bare not in _MEGA else None
        )
        symbols = [known] if known else []
        if word and not known:
            symbols = _product(word)
        if match is None or (word and not symbols):
            inside = f' ("{match[2]}")' if match and match[2] != text else ""
            raise UnitError(f'the unit "{text}"{inside} is not known')
        position = match.end()
        written = int(match[3] or 1)
        if not 1 <= abs(written) <= 4:
            raise UnitError(
                f'the power {written} in the unit "{text}" makes no sense here'
            )
        for left, symbol in enumerate(symbols, start=1 - len(symbols)):
            # The power belongs to the last of "kg.m^2".
            power = (1 if left else written) * (-1 if match[1] == "/" else 1)
            size = symbol.factor ** abs(power)
            factor = factor * size if power > 0 else factor / size
            dimensions = Dimensions(
                *(
                    d + power * one
                    for d, one in zip(dimensions, symbol.dimensions, strict=True)
                )
            )
            (up if power > 0 else down).append(
                symbol.text if abs(power) == 1 else f"{symbol.text}^{abs(power)}"
            )
    return Unit(
        "/".join(["*".join(up) or "1", *down]) if up or down else "", factor, dimensions
    )


_DIMENSIONS = {
    name: {parse(unit).dimensions for unit in (kind.si, *kind.also)}
    for name, kind in KINDS.items()
    if kind.limits
}
"""What the units of each kind may have."""


def _from_pint(name: str, kind: str) -> Unit | None:
    """Convert a unit written as a word; None if it is not one of this kind."""
    if not KINDS[kind].in_words or not re.fullmatch("[a-z]{4,20}", name):
        return None
    import pint

    registry: Any = pint.application_registry
    if not any(
        unit in KINDS[kind].in_words.split()
        for _, unit, _ in registry.parse_unit_name(name)
    ):
        return None
    quantity = registry.Quantity(1, name)
    return (
        Unit(name, float(quantity.to(SI[kind]).magnitude))
        if quantity.is_compatible_with(SI[kind])
        else None
    )


def _proposal(kind: str) -> str:
    return (
        f"write one of: {KINDS[kind].examples}"
        if SI[kind]
        else "write the number alone"
    )


@lru_cache(maxsize=1024)
def parse_unit(text: str, kind: str) -> Unit:
    """Read a unit of one kind of quantity."""
    try:
        unit = parse(text)
    except UnitError as fault:
        if in_words := _from_pint(text.strip().lower(), kind):
            return in_words
        hint = "; convert the numbers if they are in another unit" if SI[kind] else ""
        raise UnitError(
            str(fault), f"for {KINDS[kind].words}, {_proposal(kind)}{hint}"
        ) from None
    factor, dimensions = unit.factor, unit.dimensions
    if dimensions not in _DIMENSIONS.get(kind, ()):
        hint = _proposal(kind)
        if kind == "rate" and dimensions.time:
            hint += "; a time per revolution goes into a column spin_period [s]"
        raise UnitError(f'"{text.strip()}" is not a unit of {KINDS[kind].words}', hint)
    if kind == "rate" and not dimensions.angle and not dimensions.turn:
        # Counts per minute of a turning thing are revolutions; per second they might be
        # radians.
        if unit.text != "1/min":
            hint, code = (
                "write rev/s (or Hz) for revolutions, rad/s for radians",
                diagnostics.PER_SECOND_IS_AMBIGUOUS,
            )
            raise UnitError(
                f'"{text.strip()}" can mean revolutions or radians', hint, code
            )
        factor = RPM
    elif kind in ("number", "time"):
        factor /= (
            2 * math.pi
        ) ** dimensions.turn  # a turn has 2π radians, and yet counts as one
    elif kind == "torque" and not dimensions.time:
        factor *= STANDARD_GRAVITY
    # A power of ten should be that power, not its neighbour; factors with pi in them
    # keep all their digits.
    return replace(
        unit, factor=factor if kind in ("rate", "angle") else float(f"{factor:.15g}")
    )


@lru_cache(maxsize=1024)
def kinds_of(text: str) -> frozenset[str]:
    """Return the kinds of quantity that a unit text can measure; none if it is not a unit."""
    try:
        dimensions = parse(text).dimensions if text.strip() else None
    except UnitError:
        dimensions = None
    return frozenset(
        name for name, possible in _DIMENSIONS.items() if dimensions in possible
    )


def from_si(value: float, unit: str, kind: str) -> float:
    """Express an SI value in another unit."""
    return value / parse_unit(unit, kind).factor
