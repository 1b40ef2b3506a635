"""Kinds of quantity and their units: what a student writes becomes an SI float, and an SI float what is expected.

A unit text, with symbols in many languages, products, powers and look-alike letters, is taken apart by one rule; the
symbols, each with its SI factor, are in `vocabulary.toml`. Any other name of a usual unit, such as "ounces" or
"milliseconds", is converted by pint, which takes 0.3 s to load and is the only import of it. Symbols are not given to
pint: it takes ``Nm`` for a textile unit, ``U/min`` for an enzyme activity, and 1 Hz for 1 rad/s.
"""

from __future__ import annotations

import math
import re
import unicodedata
from functools import lru_cache
from typing import Any, NamedTuple

from msgspec import Struct

from gyrodata import vocabulary

MAX_UNIT_LENGTH = 64
"""Characters in a unit text; longer ones are refused unread."""

RPM = math.pi / 30
"""One revolution per minute [rad/s]."""


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


STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2] (CGPM 1901): of the kilogram-force, and where a log gives none."""

_M, _L, _T, _F = Dimensions(mass=1), Dimensions(length=1), Dimensions(time=1), Dimensions(1, 1, -2)
_A, _R, _PER_TURN_TIME = Dimensions(angle=1), Dimensions(turn=1), Dimensions(time=-1, turn=1)
_BASES = {"kg": _M, "m": _L, "s": _T, "N": _F, "rad": _A, "rev": _R, "rev/s": _PER_TURN_TIME}


class Parsed(Struct, frozen=True):
    """A unit text that was understood, or one symbol of it."""

    spelling: str
    """In a form that can be read back: ``kg*m^2``, ``m/s^2``."""
    dimensions: Dimensions
    factor: float
    """SI value of one such unit, a turn as 2π."""


_SYMBOLS: dict[str, Parsed] = {}
for _spelling, _line in vocabulary.UNITS.items():
    _factor, _base, *_words = _line.split()
    _atom = Parsed(_spelling, _BASES[_base], float(_factor))
    _SYMBOLS |= {fold_letters(word): _atom for word in (_spelling, *_words)}
for _spelling in ("rev", "min", "s"):
    for _word in vocabulary.words(_spelling).split():
        _SYMBOLS.setdefault(fold_letters(_word), _SYMBOLS[_spelling])
# Case is forgiven ("KG", "Sec") unless it tells milli from mega.
_MEGA = {"Mg", "MG", "MN", "Ms", "MS", "MHz", "MHZ", "Mrad"}
_ANY_CASE: dict[str, Parsed] = {}
for _word, _atom in _SYMBOLS.items():
    _ANY_CASE.setdefault(_word.lower(), _atom)

_TOKEN = re.compile(r"\s*([*/]?)\s*(?:([^\W\d_]+\.?(?:[^\W\d_]+\.?)*|°)(?:\s*\^?\s*([-+]?\d{1,3}))?|\^?1(?!\d)|$)")
_PRODUCT_SIGNS = str.maketrans("·⋅∙×•−–‐‑÷∕", "*****----//")


def _find_symbols(word: str) -> list[Parsed]:
    """Look a symbol up; glued ("Nm", "gcm") and dotted ("N.m") products come apart here. Empty if it is none."""
    bare = word.replace(".", "")
    if bare in _SYMBOLS:
        return [_SYMBOLS[bare]]
    if bare.lower() in _ANY_CASE and bare not in _MEGA:
        return [_ANY_CASE[bare.lower()]]
    if "." in word.strip("."):
        parts = word.strip(".").split(".")
        return [_SYMBOLS[part] for part in parts] if set(parts) <= _SYMBOLS.keys() else []
    for length in (2, 1):
        left, right = _SYMBOLS.get(bare[:-length]), _SYMBOLS.get(bare[-length:])
        if left and right and right.dimensions == _L and left.dimensions in (_M, _F):
            return [left, right]
    return []


@lru_cache(maxsize=1024)
def parse(text: str) -> Parsed:
    """Take a unit text apart: symbols with powers, and ``*`` or ``/`` between them."""
    if len(text) > MAX_UNIT_LENGTH:
        raise UnitError(f"a unit of {len(text)} characters; at most {MAX_UNIT_LENGTH} are read")
    rest = fold_letters(text.strip()).translate(_PRODUCT_SIGNS).replace("**", "^").strip()
    if rest.startswith("["):
        rest = rest.removeprefix("[").removesuffix("]")
    rest = re.sub(r"\s+(?:per|pro|por|par|na)\s+", "/", rest)
    rest = re.sub(r"(?<=\w)-(?=[^\W\d_])", "*", rest)  # "kg-m^2"
    # "rad/(s*rev)" is "rad/s/rev"; other parentheses say nothing.
    rest = re.sub(r"/\s*\(([^()]*)\)", lambda m: "/" + m[1].replace("*", "/"), rest)
    rest = rest.removeprefix("(").removesuffix(")").strip()
    up: list[str] = []
    down: list[str] = []
    sizes, factor, position = [0] * len(Dimensions()), 1.0, 0
    while position < len(rest):
        match = _TOKEN.match(rest, position)
        symbols = _find_symbols(match[2]) if match and match[2] else []
        if match is None or (match[2] and not symbols):
            inside = f' ("{match[2]}")' if match and match[2] != text else ""
            raise UnitError(f'the unit "{text}"{inside} is not known')
        position = match.end()
        written = int(match[3] or 1)
        if not 1 <= abs(written) <= 4:
            raise UnitError(f'the power {written} in the unit "{text}" makes no sense here')
        for left, symbol in enumerate(symbols, start=1 - len(symbols)):
            # The power belongs to the last of "kg.m^2".
            power = (1 if left else written) * (-1 if match[1] == "/" else 1)
            size = symbol.factor ** abs(power)
            factor = factor * size if power > 0 else factor / size
            sizes = [one + power * other for one, other in zip(sizes, symbol.dimensions, strict=True)]
            spelled = symbol.spelling if abs(power) == 1 else f"{symbol.spelling}^{abs(power)}"
            (up if power > 0 else down).append(spelled)
    spelling = "/".join(["*".join(up) or "1", *down]) if up or down else ""
    return Parsed(spelling, Dimensions(*sizes), factor)


class Kind(Struct, frozen=True):
    """A kind of quantity."""

    si: str
    """Unit in which it is kept inside."""
    shown: str
    """Unit in which it is shown, and which a message proposes."""
    words: str
    """With its article."""
    dimensions: tuple[Dimensions, ...]
    """What its units may have."""
    limits: tuple[float, float] | None = None
    """Smallest and largest size [SI unit] of what stands on a lab bench, zero apart: far from all ever read."""
    examples: str = "the number alone"
    """Units to propose."""
    sample: str = '"1/3"'
    """How it is written."""

    @property
    def proposal(self) -> str:
        """What to write, without a number that could be taken over as it stands."""
        return f"write one of: {self.examples}" if self.si else "write the number alone"


_RATES = (Dimensions(time=-1, angle=1), _PER_TURN_TIME, Dimensions(time=-1))
# "g*cm" means the weight of that mass at that arm.
_TORQUES = (Dimensions(1, 2, -2), Dimensions(1, 1, 0))
_INERTIA, _G = (Dimensions(1, 2),), (Dimensions(0, 1, -2),)
_RATE_UNITS = "rpm, Hz, rev/s, rad/s, deg/s"
_INERTIA_UNITS = "kg*m^2, g*m^2, g*cm^2"

KINDS: dict[str, Kind] = {
    "mass": Kind("kg", "g", "a mass", (_M,), (1e-9, 1e4), "g, kg", '"20 g"'),
    "length": Kind("m", "cm", "a length", (_L,), (1e-9, 1e3), "mm, cm, m", '"15 cm"'),
    "torque": Kind("N*m", "N*m", "a torque", _TORQUES, (1e-12, 1e6), "N*m, mN*m, gf*cm", '"0.03 N*m"'),
    "force": Kind("N", "N", "a force", (_F,), (1e-9, 1e6), "N, mN, gf", '"0.2 N"'),
    "rate": Kind("rad/s", "rpm", "a rotation rate", _RATES, (1e-6, 1e6), _RATE_UNITS, '"400 rpm"'),
    "time": Kind("s", "s", "a time", (_T, Dimensions(time=1, turn=-1)), (1e-6, 1e7), "s, ms, min", '"7.06 s"'),
    "number": Kind("", "", "a number of turns", (Dimensions(), _R), (1e-6, 1e6)),
    "angle": Kind("rad", "deg", "an angle", (_A, _R), (1e-6, 1e7), "deg, rad, rev", '"120 deg"'),
    "inertia": Kind(
        "kg*m^2", "kg*m^2", "a moment of inertia", _INERTIA, (1e-12, 1e6), _INERTIA_UNITS, '"0.004 kg*m^2"'
    ),
    "acceleration": Kind("m/s^2", "m/s^2", "an acceleration", _G, (1e-3, 1e3), "m/s^2, cm/s^2", '"9.803 m/s^2"'),
    "sign": Kind("", "", "a sense of rotation", ()),
    "text": Kind("", "", "a text", ()),
}

SI = {name: kind.si for name, kind in KINDS.items()}
"""Unit in which each kind of quantity is kept inside."""
DISPLAY = {name: kind.shown for name, kind in KINDS.items()}
"""Unit in which each kind of quantity is shown, and which a message proposes."""
LIMITS = {name: kind.limits for name, kind in KINDS.items() if kind.limits}
"""Smallest and largest size of each kind [SI unit]."""


class Unit(Struct, frozen=True):
    """A unit that this tool understood.

    Attributes
    ----------
    text : str
        Spelling that this tool reads back.
    kind : str
        Kind of quantity, a key of `SI`.
    factor : float
        SI value of one such unit.
    """

    text: str
    kind: str
    factor: float


class Uncertainty(Struct, frozen=True):
    """Standard uncertainty of a reading, as data sheets mean it: a plain sum of a fixed part and a proportional one.

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
        """Give the standard uncertainty of one reading."""
        return self.absolute + self.relative * abs(value)


# Counts per minute of a turning thing are revolutions; per second they might be radians. A mass at an arm means its
# weight.
_RESPELLED = {
    "rate": {"rev/min": "rpm", "1/min": "rpm", "rev/s": "rps"},
    "torque": {"g*cm": "gf*cm", "kg*cm": "kgf*cm", "kg*m": "kgf*m", "g*m": "gf*m"},
}


_PINT_NAMES = frozenset(
    ("gram", "meter", "second", "minute", "hour", "newton", "dyne", "pound", "ounce", "inch", "foot", "yard")
)
"""Units of pint, with any prefix, that may be written in a log; "hand" and "point" are lengths there too."""


@lru_cache(maxsize=64)
def _from_pint(name: str, kind: str) -> Unit | None:
    """Convert a unit written as a word; None if it is none of this kind."""
    if kind not in ("mass", "length", "time", "force") or not re.fullmatch("[a-z]{4,20}", name):
        return None
    import pint

    registry: Any = pint.UnitRegistry()
    if not any(unit in _PINT_NAMES for _, unit, _ in registry.parse_unit_name(name)):
        return None
    try:
        return Unit(name, kind, float(registry.Quantity(1, name).to(SI[kind]).magnitude))
    except pint.DimensionalityError:
        return None


@lru_cache(maxsize=1024)
def parse_unit(text: str, kind: str) -> Unit:
    """Understand a unit as a unit of one kind of quantity."""
    try:
        parsed = parse(text)
    except UnitError as fault:
        if unit := _from_pint(text.strip().lower(), kind):
            return unit
        raise UnitError(str(fault), f"for {KINDS[kind].words}, {KINDS[kind].proposal}", fault.reason) from None
    dimensions = parsed.dimensions
    if kind == "rate" and dimensions == _T:
        hint = "a time per revolution goes into a column spin_period [s], or is written in s/rev"
        raise UnitError(f'"{text.strip()}" is a time, not a rotation rate', hint, "kind")
    if dimensions not in KINDS[kind].dimensions:
        raise UnitError(f'"{text.strip()}" is no unit of {KINDS[kind].words}', KINDS[kind].proposal, "kind")
    if respelled := _RESPELLED.get(kind, {}).get(parsed.spelling):
        return parse_unit(respelled, kind)
    if kind == "rate" and not dimensions.angle and not dimensions.turn:
        raise UnitError(
            f'"{text.strip()}" can mean revolutions or radians',
            "write rev/s (or Hz) for revolutions, rad/s for radians",
            "ambiguous",
        )
    factor = parsed.factor
    if kind in ("number", "time"):
        factor /= (2 * math.pi) ** dimensions.turn  # a turn has 2π radians, and yet counts as one
    elif kind == "torque" and not dimensions.time:
        factor *= STANDARD_GRAVITY
    # A power of ten should be that power, not its neighbour; factors with pi in them keep all their digits.
    return Unit(parsed.spelling, kind, factor if kind in ("rate", "angle") else float(f"{factor:.15g}"))


@lru_cache(maxsize=1024)
def kinds_of(text: str) -> frozenset[str]:
    """Tell which kinds of quantity a unit text can measure; none if it is no unit."""
    if not text.strip():
        return frozenset()
    try:
        dimensions = parse(text).dimensions
    except UnitError:
        return frozenset()
    return frozenset(name for name, kind in KINDS.items() if dimensions in kind.dimensions)


def from_si(value: float, unit: str, kind: str) -> float:
    """Express an SI value in another unit."""
    return value / parse_unit(unit, kind).factor
