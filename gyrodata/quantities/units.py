"""Kinds of quantity and their units: a unit that a student writes becomes an SI factor.

Pint converts the units, with the definitions in `units.txt` and no others: the registry
that it comes with reads 60 rpm as 6.28 Hz, ``Nm`` as a textile unit and ``U/min`` as an
enzyme activity. Pint gets no text of a student either, because it would compute
``9**9**9*m``. In front of it a strict pattern splits the text into units and powers,
and each unit is looked up among the spellings of all languages, with look-alike letters
of other alphabets.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache, lru_cache
from numbers import Real
from pathlib import Path
from string import ascii_letters
from typing import TYPE_CHECKING, Any

from msgspec import Struct, convert

from gyrodata.base import diagnostics
from gyrodata.base.errors import insist_on_type
from gyrodata.quantities import vocabulary

if TYPE_CHECKING:
    import pint

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
        self.hint = hint
        self.code = code


class Uncertainty(Struct, frozen=True):
    """Standard uncertainty of a reading: a fixed part plus a proportional part.

    It is the plain sum of the two parts, as in data sheets.

    Attributes
    ----------
    absolute : float
        Fixed part [SI unit of the role].
    relative : float
        Part proportional to the reading [1].

    Raises
    ------
    TypeError, ValueError
        If a part is not a number, or is below zero.
    """

    absolute: float = 0.0
    relative: float = 0.0

    def __post_init__(self) -> None:
        for part in (self.absolute, self.relative):
            insist_on_type("u", part, Real, "a number in SI")
            if not part >= 0:
                raise ValueError(f"u is 0 or more, not {part}")

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


KINDS = convert(vocabulary.KINDS, dict[str, Kind])
"""Every kind of quantity, by name."""
SI = {name: kind.si for name, kind in KINDS.items()}
"""Unit in which each kind of quantity is kept inside."""
DISPLAY = {name: kind.shown for name, kind in KINDS.items()}
"""Unit in which each kind of quantity is shown, and which a message proposes."""
LIMITS = {name: kind.limits for name, kind in KINDS.items() if kind.limits}
"""Smallest and largest size of each kind [SI unit]."""


class Unit(Struct, frozen=True):
    """A unit of one kind of quantity.

    Attributes
    ----------
    text : str
        Spelling that this tool reads back: ``kg*m^2``, ``m/s^2``.
    factor : float
        SI value of one such unit.
    """

    text: str
    factor: float


class Product(Struct, frozen=True):
    """A product of units, of whatever kind.

    Attributes
    ----------
    text : str
        Spelling that this tool reads back.
    scale : Fraction
        Its size in the base units of `units.txt`: in turns, if it contains a turn.
    dimensions : mapping
        Powers of length, mass, time, angle and turn, by name in brackets.
    """

    text: str
    scale: Fraction
    dimensions: Mapping[str, int]


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
        self.categories = categories
        self.first = first

    def __missing__(self, code: int) -> int | None:
        """Decide about a letter when it is first seen."""
        letter = chr(code)
        category = unicodedata.category(letter)
        is_gone = letter >= self.first and category in self.categories
        self[code] = kept = None if is_gone else code
        return kept


# Letters of other alphabets that look like Latin letters become these. Capital and
# small letters are listed one by one, because "н" is not an "h". For `re`, the vowel
# signs of Hindi, Thai and Arabic are not letters.
_LOOK_ALIKES = Letters(
    str.maketrans(
        "АВЕКМНОРСТУХІавекмнорстухі" + "ΑΒΕΖΗΙΚΜΝΟΡΤΥΧο" + "∆µʹ′″⁄",
        "ABEKMHOPCTYXIabekmhopctyxi" + "ABEZHIKMNOPTYXo" + "Δμ''\"/",
        "\u200c",  # Persian: it only keeps two letters apart
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


@cache
def registry() -> pint.UnitRegistry[Fraction]:
    """Return the registry of pint with the units of `units.txt`.

    Its factors are exact: ten to a power is that power, not its neighbour.
    """
    import pint

    units: pint.UnitRegistry[Fraction] = pint.UnitRegistry(
        None, non_int_type=Fraction, on_redefinition="raise", cache_folder=None
    )
    units.load_definitions(Path(__file__).with_name("units.txt"))
    return units


@cache
def spellings() -> dict[str, str]:
    """Return the unit of each spelling, with Latin letters for look-alikes."""
    names = {
        fold_letters(spelling): registry().get_name(spelling) for spelling in registry()
    }
    for name in ("rev", "min", "s"):
        for spelling in vocabulary.single_words(name):
            names.setdefault(fold_letters(spelling), name)
    return names


@cache
def _spellings_in_any_case() -> dict[str, str]:
    return {spelling.lower(): name for spelling, name in spellings().items()}


_MEGA = {"Mg", "MG", "MN", "Ms", "MS", "MHz", "MHZ", "Mrad"}
"""Case is forgiven ("KG", "Sec") unless it separates milli from mega."""
_NOT_FORGIVEN = frozenset(ascii_letters) - frozenset("gmshGMSH")
"""Letters whose case matters if they are the whole unit: v and U are turns, V and u are
not."""


def _name(word: str) -> str | None:
    """Return the name of the unit that a word means; None if it is not known."""
    if word in spellings():
        return spellings()[word]
    if word in _MEGA:
        return None
    lower = word.lower()
    if lower in _spellings_in_any_case():
        return _spellings_in_any_case()[lower]
    for prefix, name, _ in registry().parse_unit_name(lower):
        english = registry().get_symbol(name)
        with_prefix = prefix + english
        if prefix and english != name and lower in (with_prefix, f"{with_prefix}s"):
            return spellings().get(with_prefix, with_prefix)
    return None


def _names_in_product(word: str) -> list[str]:
    """Return the units of a product without ``*``; empty if the word is not a product.

    It may be written "N.m", or "Nm" and "gcm": then its last symbol is a length.
    """
    with_dots = word.strip(".").split(".")
    if all(part in spellings() for part in with_dots):
        return [spellings()[part] for part in with_dots]
    bare = word.replace(".", "")
    for letters in (2, 1):
        first = bare[:-letters]
        last = bare[-letters:]
        is_product = first in spellings() and last in spellings()
        if is_product and kinds_of(last) == {"length"}:
            return [spellings()[first], spellings()[last]]
    return []


_PRODUCT_SIGNS = str.maketrans("·⋅∙×•−–‐‑÷∕", "*****----//")
_USUAL = [
    (way.replace("PER", vocabulary.pattern("per")), usual)
    for way, usual in vocabulary.WAYS["unit"]
]
_SCALED = (
    r"(?:\*?\s*10(?:\^|(?=[-+]))(?P<power>[-+]?[0-9]{1,2})"
    r"|[x*]\s*1(?P<times>0+)|1/1(?P<part>0+))[\s*]*(?P<unit>[^\W\d].*)"
)
"""A power of ten and a unit: "10^-3 kg", "x100 rpm", "1/100 s"."""
_TERM = re.compile(
    r"\s*+(?P<sign>[*/]?)\s*+"
    r"(?:(?P<word>[^\W\d_]+\.?(?:[^\W\d_]+\.?)*|°)(?:\s*\^?\s*(?P<power>[-+]?\d{1,3}))?"
    r"|\^?1(?!\d)|$)"
)


def _in_usual_signs(text: str) -> str:
    """Write a unit text with Latin letters, ``*``, ``/`` and ``^``."""
    usual = fold_letters(text.strip()).translate(_PRODUCT_SIGNS)
    usual = usual.replace("**", "^").strip()
    if usual in spellings():
        return usual
    for way, replacement in _USUAL:
        usual = re.sub(way, replacement, usual)
    return usual


def _unknown(text: str, word: str | None) -> UnitError:
    inside = f' ("{word}")' if word and word != text else ""
    return UnitError(f'the unit "{text}"{inside} is not known')


def _split(text: str, usual: str) -> Iterator[tuple[str, int]]:
    """Yield the name and the power of each unit of a product.

    Parameters
    ----------
    text : str
        As it was written, for messages.
    usual : str
        In usual signs.
    """
    position = 0
    while position < len(usual):
        term = _TERM.match(usual, position)
        if term is None:
            raise _unknown(text, None)
        position = term.end()
        if term["word"]:
            yield from _powers_of(term, text)


def _powers_of(term: re.Match[str], text: str) -> Iterator[tuple[str, int]]:
    """Yield the units of one term of a unit text with their powers: of "/s^2", s −2."""
    word = term["word"]
    name = _name(word.replace(".", ""))
    names = [name] if name else _names_in_product(word)
    if not names:
        raise _unknown(text, word)
    power = int(term["power"] or 1)
    if not 1 <= abs(power) <= 4:
        raise UnitError(f'the power {power} in the unit "{text}" makes no sense here')
    sign = -1 if term["sign"] == "/" else 1
    # The power belongs to the last of "kg.m^2".
    for first in names[:-1]:
        yield first, sign
    yield names[-1], sign * power


def _join(terms: Sequence[tuple[str, int]]) -> str:
    """Write a product of units and powers."""
    above = list[str]()
    below = list[str]()
    for name, power in terms:
        factor = name if abs(power) == 1 else f"{name}^{abs(power)}"
        (above if power > 0 else below).append(factor)
    if terms:
        return "/".join(["*".join(above) or "1", *below])
    return ""


@lru_cache(maxsize=1024)
def parse(text: str) -> Product:
    """Read a unit text: names with powers, and ``*`` or ``/`` between them."""
    if len(text) > MAX_UNIT_LENGTH:
        raise UnitError(
            f"a unit of {len(text)} characters; at most {MAX_UNIT_LENGTH} are read"
        )
    letter = text.strip()
    if letter in _NOT_FORGIVEN and letter not in spellings():
        raise _unknown(text, None)
    usual = _in_usual_signs(text)
    if scaled := re.fullmatch(_SCALED, usual):
        power = int(scaled["power"] or 0)
        power += len(scaled["times"] or "") - len(scaled["part"] or "")
        unit = parse(scaled["unit"])
        scale = Fraction(10) ** power * unit.scale
        return Product(f"10^{power} {unit.text}", scale, unit.dimensions)
    terms = list(_split(text, usual))
    powers = Counter[str]()
    for name, power in terms:
        powers[name] += power
    units: Any = registry()
    scale, base = units.get_root_units(units.UnitsContainer(powers))
    return Product(_join(terms), Fraction(scale), base.dimensionality)


@cache
def _dimensions() -> dict[str, set[Mapping[str, int]]]:
    """Return what the units of each kind of quantity may have."""
    dimensions = {}
    for name, kind in KINDS.items():
        if kind.limits:
            products = map(parse, (kind.si, *kind.also))
            dimensions[name] = {product.dimensions for product in products}
    return dimensions


def load() -> None:
    """Load the units now: processes that are forked from this one have them already."""
    _dimensions()


def _proposal(kind: str) -> str:
    if SI[kind]:
        return f"write one of: {KINDS[kind].examples}"
    return "write the number alone"


_SIGNS_OF_LINES = frozenset(":=")
"""Signs of several values in one line: "g: 9.81, 20 g"."""


@lru_cache(maxsize=1024)
def parse_unit(text: str, kind: str) -> Unit:
    """Read a unit of one kind of quantity."""
    try:
        product = parse(text)
    except UnitError as fault:
        hint = "; convert the numbers if they are in another unit" if SI[kind] else ""
        if not _SIGNS_OF_LINES.isdisjoint(text):
            hint = "; write one line for each value"
        raise UnitError(
            str(fault), f"for {KINDS[kind].words}, {_proposal(kind)}{hint}"
        ) from None
    if product.dimensions not in _dimensions().get(kind, ()):
        hint = _proposal(kind)
        if kind == "rate" and "[time]" in product.dimensions:
            hint += "; a time per revolution goes into a column spin_period [s]"
        raise UnitError(f'"{text.strip()}" is not a unit of {KINDS[kind].words}', hint)
    if kind == "rate":
        return Unit(product.text, _rate(product, text))
    if kind == "angle":
        return Unit(product.text, _in_radians(product))
    scale = product.scale
    if kind == "torque" and "[time]" not in product.dimensions:
        scale *= Fraction(str(STANDARD_GRAVITY))  # a mass stands for its weight
    return Unit(product.text, float(scale))


def _rate(product: Product, text: str) -> float:
    """Return a rotation rate in rad/s.

    Counts per minute of a turning thing are revolutions; per second they might be
    radians.
    """
    if product.dimensions.keys() & {"[angle]", "[turn]"}:
        return _in_radians(product)
    if product.text == "1/min":
        return RPM
    raise UnitError(
        f'"{text.strip()}" can mean revolutions or radians',
        "write rev/s (or Hz) for revolutions, rad/s for radians",
        diagnostics.PER_SECOND_IS_AMBIGUOUS,
    )


def _in_radians(product: Product) -> float:
    """Return the size of an angle, or of a rate, with 2π radians in a turn."""
    if "[turn]" in product.dimensions:
        return math.tau * product.scale.numerator / product.scale.denominator
    return float(product.scale)


@lru_cache(maxsize=1024)
def kinds_of(text: str) -> frozenset[str]:
    """Return the kinds of quantity that a unit measures; none for other texts."""
    if not text.strip():
        return frozenset()
    try:
        dimensions = parse(text).dimensions
    except UnitError:
        return frozenset()
    return frozenset(
        name for name, possible in _dimensions().items() if dimensions in possible
    )


def from_si(value: float, unit: str, kind: str) -> float:
    """Express an SI value in another unit."""
    return value / parse_unit(unit, kind).factor
