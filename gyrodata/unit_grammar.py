"""How students write units: symbols in eight languages, products, powers, look-alike letters.

A unit text is taken apart by rule, before any library sees it; what comes out is made of names from one table.
"""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

MAX_UNIT_LENGTH = 64
"""Characters in a unit text; longer ones are refused unread."""


class UnitError(ValueError):
    """A unit that cannot be used: unknown, of another kind, or ambiguous."""

    def __init__(self, message: str, hint: str = "", reason: str = "unknown") -> None:
        super().__init__(message)
        self.hint = hint
        self.reason = reason


class Dimensions(NamedTuple):
    """Powers of mass, length and time, and of radians and revolutions, which are not the same thing here."""

    mass: int = 0
    length: int = 0
    time: int = 0
    angle: int = 0
    turn: int = 0

    def plus(self, other: Dimensions, power: int) -> Dimensions:
        """Multiply by `other` to the given power."""
        return Dimensions(*(a + power * b for a, b in zip(self, other, strict=True)))


# Letters that look alike in the alphabets of the lab are one letter; in capitals because "н" is no "h", and in
# small letters so that a word folds the same way however it is written.
_LOOK_ALIKES = str.maketrans(
    "АВЕКМНОРСТУХІавекмнорстухі" + "ΑΒΕΖΗΙΚΜΝΟΡΤΥΧο" + "∆µʹ′″",
    "ABEKMHOPCTYXIabekmhopctyxi" + "ABEZHIKMNOPTYXo" + "Δμ''\"",
)
_RINGS = str.maketrans({"º": "°", "˚": "°", "̊": "°"})


@lru_cache(maxsize=4096)
def fold_letters(text: str) -> str:
    """Write compatibility forms and look-alike letters of other alphabets in one way; case is kept."""
    if text.isascii():
        return text
    return unicodedata.normalize("NFKC", text.translate(_RINGS)).translate(_LOOK_ALIKES).replace("⁄", "/")


_M, _L, _T = Dimensions(mass=1), Dimensions(length=1), Dimensions(time=1)
_F = Dimensions(1, 1, -2)
_A, _R = Dimensions(angle=1), Dimensions(turn=1)
_PER_TURN_TIME = Dimensions(time=-1, turn=1)

# spelling given back, name and definition for pint, dimensions, what students write
STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2] (CGPM 1901): of the kilogram-force, and where a log gives none."""

TABLE: tuple[tuple[str, str, str, Dimensions, str], ...] = (
    (
        "kg",
        "kilogram",
        "[mass]",
        _M,
        "kg kgs kilo kilogram kilograms kilogramm kilogramme kilogramo кг килограмм",
    ),
    (
        "g",
        "gram",
        "1e-3 kilogram",
        _M,
        "g gr grs gm gms gram grams gramm gramme grammes gramo gramos г гр грамм",
    ),
    ("mg", "milligram", "1e-6 kilogram", _M, "mg мг"),
    ("lb", "pound", "0.45359237 kilogram", _M, "lb lbs"),
    ("oz", "ounce", "0.028349523125 kilogram", _M, "oz"),
    ("m", "meter", "[length]", _L, "m meter meters metre metres mètre metro metros metr м метр"),
    ("dm", "decimeter", "0.1 meter", _L, "dm дм"),
    ("cm", "centimeter", "1e-2 meter", _L, "cm cms centimeter centimetre zentimeter см"),
    ("mm", "millimeter", "1e-3 meter", _L, "mm millimeter millimetre мм"),
    ("um", "micrometer", "1e-6 meter", _L, "um μm мкм"),
    ("in", "inch", "0.0254 meter", _L, "in inch inches"),
    ("ft", "foot", "0.3048 meter", _L, "ft"),
    (
        "s",
        "second",
        "[time]",
        _T,
        "s sec secs second seconds sek sekunde sekunden seconde secondes seg segundos sekund с сек",
    ),
    ("ms", "millisecond", "1e-3 second", _T, "ms мс"),
    ("min", "minute", "60 second", _T, "min mins minute minutes minuten minuto minutos minut мин"),
    ("h", "hour", "3600 second", _T, "h hr hour hours ч"),
    ("N", "newton", "kilogram*meter/second**2", _F, "N newton newtons Н"),
    ("mN", "millinewton", "1e-3 newton", _F, "mN мН"),
    ("uN", "micronewton", "1e-6 newton", _F, "uN μN мкН"),
    ("cN", "centinewton", "1e-2 newton", _F, "cN"),
    ("kN", "kilonewton", "1e3 newton", _F, "kN кН"),
    ("kgf", "kilogram_force", f"{STANDARD_GRAVITY} newton", _F, "kgf kp кгс"),
    ("gf", "gram_force", "1e-3 kilogram_force", _F, "gf pond гс"),
    ("lbf", "pound_force", "4.4482216152605 newton", _F, "lbf"),
    ("rad", "radian", "[]", _A, "rad rads radian radians radiant рад"),
    ("mrad", "milliradian", "1e-3 radian", _A, "mrad мрад"),
    (
        "deg",
        "degree",
        f"{math.pi / 180!r} radian",
        _A,
        "° deg degs degree degrees grad grados degré degrés stopni град градус",
    ),
    (
        "rev",
        "turn",
        f"{2 * math.pi!r} radian",
        _R,
        (
            "rev revs revolution revolutions turn turns r U Umdr Umdrehung Umdrehungen tr tour tours t obr obrót "
            "obroty obrotów vuelta vueltas volta voltas rot cycle cycles об оборот оборота оборотов"
        ),
    ),
    ("rpm", "turn_per_minute", "turn/minute", _PER_TURN_TIME, "rpm upm"),
    ("rps", "turn_per_second", "turn/second", _PER_TURN_TIME, "rps cps"),
    # A rotation in hertz is turns a second; nothing else in this lab is measured in hertz.
    ("Hz", "rotation_hertz", "turn/second", _PER_TURN_TIME, "Hz hertz Гц"),
    ("kHz", "rotation_kilohertz", "1e3 turn/second", _PER_TURN_TIME, "kHz кГц"),
    ("mHz", "rotation_millihertz", "1e-3 turn/second", _PER_TURN_TIME, "mHz мГц"),
)


class Atom(NamedTuple):
    """One symbol: the spelling given back, the name that pint gets, and what it measures."""

    spelling: str
    name: str
    dimensions: Dimensions


_ATOMS: dict[str, Atom] = {
    fold_letters(word): Atom(spelling, name, dimensions)
    for spelling, name, _, dimensions, words in TABLE
    for word in words.split()
}
# Case is forgiven ("KG", "Sec") unless it tells milli from mega.
_MEGA = {"Mg", "MG", "MN", "Ms", "MS", "MHz", "MHZ", "Mrad"}
_ATOMS_ANY_CASE: dict[str, Atom] = {}
for _word, _atom in _ATOMS.items():
    _ATOMS_ANY_CASE.setdefault(_word.lower(), _atom)

_TOKEN = re.compile(r"\s*(?:([*/])|(\^?\s*[-+]?\d{1,3})|([^\W\d_]+\.?(?:[^\W\d_]+\.?)*|°))")
_PRODUCT_SIGNS = str.maketrans("·⋅∙×•−–‐‑÷∕", "*****----//")


@dataclass(frozen=True, slots=True)
class Parsed:
    """A unit text taken apart: known symbols with their powers, in order."""

    factors: tuple[tuple[Atom, int], ...]
    dimensions: Dimensions

    @property
    def spelling(self) -> str:
        """Write it so that it can be read back: ``kg*m^2``, ``m/s^2``."""
        up = [_power(atom.spelling, power) for atom, power in self.factors if power > 0]
        down = [_power(atom.spelling, -power) for atom, power in self.factors if power < 0]
        if not up and not down:
            return ""
        return "/".join(["*".join(up) or "1", *down])

    @property
    def expression(self) -> str:
        """Write it for pint."""
        return "*".join(f"{atom.name}**({power})" for atom, power in self.factors)


def _power(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}^{power}"


def _find_atoms(word: str) -> list[Atom] | None:
    """Look a symbol up; glued ("Nm", "gcm") and dotted ("N.m") products come apart here."""
    bare = word.replace(".", "")
    atom = _ATOMS.get(bare)
    if atom is None and bare not in _MEGA:
        atom = _ATOMS_ANY_CASE.get(bare.lower())
    if atom is not None:
        return [atom]
    if "." in word.strip("."):
        parts = [_ATOMS.get(part) for part in word.strip(".").split(".")]
        return None if None in parts else [part for part in parts if part is not None]
    for length in (2, 1):
        left, right = _ATOMS.get(bare[:-length]), _ATOMS.get(bare[-length:])
        if left and right and right.dimensions == _L and left.dimensions in (_M, _F):
            return [left, right]
    return None


def _prepare(text: str) -> str:
    folded = fold_letters(text.strip()).translate(_PRODUCT_SIGNS).replace("**", "^").strip()
    if folded.startswith("["):
        folded = folded.removeprefix("[").removesuffix("]")
    folded = re.sub(r"\s+(?:per|pro|por|par|na)\s+", "/", folded)
    folded = re.sub(r"(?<=\w)-(?=[^\W\d_])", "*", folded)  # "kg-m^2"
    # "rad/(s*rev)" is "rad/s/rev"; other parentheses say nothing.
    folded = re.sub(r"/\s*\(([^()]*)\)", lambda m: "/" + m[1].replace("*", "/"), folded)
    return folded.removeprefix("(").removesuffix(")").strip()


@lru_cache(maxsize=1024)
def parse(text: str) -> Parsed:
    """Take a unit text apart."""
    if len(text) > MAX_UNIT_LENGTH:
        raise UnitError(f"a unit of {len(text)} characters; at most {MAX_UNIT_LENGTH} are read")
    rest = _prepare(text)
    factors: list[tuple[Atom, int]] = []
    sign, position, fresh = 1, 0, False  # fresh: a power that comes next belongs to the last symbol
    while position < len(rest):
        match = _TOKEN.match(rest, position)
        if match is None:
            raise _unknown(text)
        position = match.end()
        operator, power, word = match.groups()
        if operator:
            sign, fresh = (-1 if operator == "/" else 1), False
        elif power is not None:
            _apply_power(power, fresh, factors, text)
            fresh = False
        else:
            found = _find_atoms(word)
            if found is None:
                raise _unknown(text, word)
            factors.extend((atom, sign) for atom in found)
            sign, fresh = 1, True
    dimensions = Dimensions()
    for atom, exponent in factors:
        dimensions = dimensions.plus(atom.dimensions, exponent)
    return Parsed(tuple(factors), dimensions)


def _apply_power(power: str, fresh: bool, factors: list[tuple[Atom, int]], text: str) -> None:
    """Give the power to the last symbol; without one, only the 1 of "1/min" makes sense."""
    if not fresh:
        if power.strip() != "1":
            raise _unknown(text)
        return
    exponent = int(power.lstrip("^ ").replace(" ", ""))
    if not 1 <= abs(exponent) <= 4:
        raise UnitError(f'the power {exponent} in the unit "{text}" makes no sense here')
    atom, sign = factors[-1]
    factors[-1] = (atom, sign * exponent)


def _unknown(text: str, word: str = "") -> UnitError:
    inside = f' ("{word}")' if word and word != text else ""
    return UnitError(f'the unit "{text}"{inside} is not known', "")
