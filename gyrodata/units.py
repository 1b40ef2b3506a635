"""Kinds of quantity and their units: what a student writes becomes an SI float, and an SI float what is expected.

A unit text, with symbols in eight languages, products, powers and look-alike letters, is taken apart by rule, before
any library sees it; what comes out is made of names from one table. The only module that imports pint, and only when
the first unusual unit is met (0.3 s): the factors of the everyday ones stand in `_EVERYDAY`, and a test compares them
with pint. pint gets expressions made of names from our own table, in a registry of our own definitions: its own takes
``Nm`` for a textile unit, ``U/min`` for an enzyme activity, 1 Hz for 1 rad/s, and can be kept busy for ever by
``9**9**9*m``.
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

    def plus(self, other: Dimensions, power: int) -> Dimensions:
        """Multiply by `other` to the given power."""
        return Dimensions(
            self.mass + power * other.mass,
            self.length + power * other.length,
            self.time + power * other.time,
            self.angle + power * other.angle,
            self.turn + power * other.turn,
        )


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

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2] (CGPM 1901): of the kilogram-force, and where a log gives none."""

# spelling given back, name and definition for pint, dimensions, what students write
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


class Atom(Struct, frozen=True):
    """One symbol: the spelling given back, the name that pint gets, and what it measures."""

    spelling: str
    name: str
    dimensions: Dimensions


_ATOMS: dict[str, Atom] = {
    fold_letters(word): Atom(spelling, name, dimensions)
    for spelling, name, _, dimensions, words in TABLE
    for word in words.split()
}
for _spelling in ("rev", "min", "s"):
    for _word in vocabulary.words(_spelling).split():
        _ATOMS.setdefault(fold_letters(_word), _ATOMS[_spelling])
# Case is forgiven ("KG", "Sec") unless it tells milli from mega.
_MEGA = {"Mg", "MG", "MN", "Ms", "MS", "MHz", "MHZ", "Mrad"}
_ATOMS_ANY_CASE: dict[str, Atom] = {}
for _word, _atom in _ATOMS.items():
    _ATOMS_ANY_CASE.setdefault(_word.lower(), _atom)

_TOKEN = re.compile(r"\s*(?:([*/])|(\^?\s*[-+]?\d{1,3})|([^\W\d_]+\.?(?:[^\W\d_]+\.?)*|°))")
_PRODUCT_SIGNS = str.maketrans("·⋅∙×•−–‐‑÷∕", "*****----//")


class Parsed(Struct, frozen=True):
    """A unit text taken apart: known symbols with their powers, in order."""

    factors: tuple[tuple[Atom, int], ...]
    dimensions: Dimensions

    @property
    def spelling(self) -> str:
        """Write it so that it can be read back: ``kg*m^2``, ``m/s^2``."""
        if not self.factors:
            return ""
        up: list[str] = []
        down: list[str] = []
        for atom, power in self.factors:
            size = abs(power)
            (up if power > 0 else down).append(atom.spelling if size == 1 else f"{atom.spelling}^{size}")
        return "/".join(["*".join(up) or "1", *down])

    @property
    def expression(self) -> str:
        """Write it for pint."""
        return "*".join(f"{atom.name}**({power})" for atom, power in self.factors)


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


def _prepare(folded: str) -> str:
    folded = folded.translate(_PRODUCT_SIGNS).replace("**", "^").strip()
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
    rest = _prepare(fold_letters(text.strip()))
    factors: list[tuple[Atom, int]] = []
    sign, position, fresh = 1, 0, False  # fresh: a power that comes next belongs to the last symbol
    while position < len(rest):
        match = _TOKEN.match(rest, position)
        if match is None:
            raise UnitError(f'the unit "{text}" is not known')
        position = match.end()
        operator, power, word = match.groups()
        if operator:
            sign, fresh = (-1 if operator == "/" else 1), False
        elif power is not None:
            if fresh:
                exponent = int(power.lstrip("^ ").replace(" ", ""))
                if not 1 <= abs(exponent) <= 4:
                    raise UnitError(f'the power {exponent} in the unit "{text}" makes no sense here')
                atom, once = factors[-1]
                factors[-1] = (atom, once * exponent)
            elif power.strip() != "1":  # as in "1/min"
                raise UnitError(f'the unit "{text}" is not known')
            fresh = False
        else:
            found = _find_atoms(word)
            if found is None:
                inside = f' ("{word}")' if word != text else ""
                raise UnitError(f'the unit "{text}"{inside} is not known')
            factors.extend((atom, sign) for atom in found)
            sign, fresh = 1, True
    dimensions = Dimensions()
    for atom, exponent in factors:
        dimensions = dimensions.plus(atom.dimensions, exponent)
    return Parsed(tuple(factors), dimensions)


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


_RATES = (Dimensions(time=-1, angle=1), Dimensions(time=-1, turn=1), Dimensions(time=-1))
# "g*cm" means the weight of that mass at that arm.
_TORQUES = (Dimensions(1, 2, -2), Dimensions(1, 1, 0))
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
        "kg*m^2",
        "kg*m^2",
        "a moment of inertia",
        (Dimensions(1, 2, 0),),
        (1e-12, 1e6),
        _INERTIA_UNITS,
        '"0.004 kg*m^2"',
    ),
    "acceleration": Kind(
        "m/s^2", "m/s^2", "an acceleration", (Dimensions(0, 1, -2),), (1e-3, 1e3), "m/s^2, cm/s^2", '"9.803 m/s^2"'
    ),
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


_EVERYDAY: dict[tuple[str, str], float] = {
    ("mass", "g"): 1e-3,
    ("mass", "kg"): 1.0,
    ("length", "mm"): 1e-3,
    ("length", "cm"): 1e-2,
    ("length", "m"): 1.0,
    ("time", "s"): 1.0,
    ("time", "s/rev"): 1.0,
    ("time", "min"): 60.0,
    ("rate", "rpm"): RPM,
    ("rate", "Hz"): 2 * math.pi,
    ("rate", "rps"): 2 * math.pi,
    ("rate", "rad/s"): 1.0,
    ("rate", "deg/s"): math.pi / 180,
    ("angle", "deg"): math.pi / 180,
    ("angle", "rad"): 1.0,
    ("angle", "rev"): 2 * math.pi,
    ("number", ""): 1.0,
    ("number", "rev"): 1.0,
    ("torque", "N*m"): 1.0,
    ("torque", "mN*m"): 1e-3,
    ("force", "N"): 1.0,
    ("force", "mN"): 1e-3,
    ("inertia", "kg*m^2"): 1.0,
    ("inertia", "g*m^2"): 1e-3,
    ("acceleration", "m/s^2"): 1.0,
    ("sign", ""): 1.0,
    ("text", ""): 1.0,
}
"""SI values of the units nearly every log uses, so that nearly no log has to wait 0.3 s for pint."""


@lru_cache(maxsize=1024)
def parse_unit(text: str, kind: str) -> Unit:
    """Understand a unit as a unit of one kind of quantity."""
    try:
        parsed = parse(text)
    except UnitError as fault:
        raise UnitError(str(fault), f"for {KINDS[kind].words}, {KINDS[kind].proposal}", fault.reason) from None
    dimensions = parsed.dimensions
    if kind == "rate" and dimensions == _T:
        hint = "a time per revolution goes into a column spin_period [s], or is written in s/rev"
        raise UnitError(f'"{text.strip()}" is a time, not a rotation rate', hint, "kind")
    if dimensions not in KINDS[kind].dimensions:
        raise UnitError(f'"{text.strip()}" is no unit of {KINDS[kind].words}', KINDS[kind].proposal, "kind")
    spelling = _spell(parsed, kind)
    if kind == "rate" and not dimensions.angle and not dimensions.turn and spelling != "rpm":
        raise UnitError(
            f'"{text.strip()}" can mean revolutions or radians',
            "write rev/s (or Hz) for revolutions, rad/s for radians",
            "ambiguous",
        )
    factor = _EVERYDAY.get((kind, spelling))
    return Unit(spelling, kind, _pint_factor(parsed, kind, spelling) if factor is None else factor)


def _spell(parsed: Parsed, kind: str) -> str:
    spelling = parsed.spelling
    if kind == "rate" and spelling in ("rev/min", "1/min"):
        return "rpm"  # counts per minute of a turning thing are revolutions; per second they might be radians
    if kind == "rate" and spelling == "rev/s":
        return "rps"
    if kind == "torque" and parsed.dimensions == (1, 1, 0, 0, 0):
        return {"g*cm": "gf*cm", "kg*cm": "kgf*cm", "kg*m": "kgf*m", "g*m": "gf*m"}.get(spelling, spelling)
    return spelling


@lru_cache(maxsize=1)
def _registry() -> Any:
    """Make a pint registry of nothing but the units above (in 5 ms; pint's own takes 100)."""
    import pint

    registry: Any = pint.UnitRegistry(None)
    for _, name, definition, _, _ in TABLE:
        registry.define(f"{name} = {definition}")
    return registry


def _pint_factor(parsed: Parsed, kind: str, spelling: str) -> float:
    registry = _registry()
    # A turn has 2π radians, and yet counts as one.
    target = parse(("rev" if parsed.dimensions.turn else "rad") if kind == "number" else SI[kind]).expression
    quantity = registry.Quantity(1.0, parsed.expression)
    if kind == "torque" and parsed.dimensions == (1, 1, 0, 0, 0):
        quantity = quantity * registry.Quantity(STANDARD_GRAVITY, "newton/kilogram")
    if parsed.dimensions == (0, 0, 1, 0, -1):
        quantity = quantity * registry.Quantity(1.0, "turn")
    factor = float(quantity.to(target).magnitude)
    # A power of ten should be that power, not its neighbour; factors with pi in them keep all their digits.
    return factor if kind in ("rate", "angle") else float(f"{factor:.15g}")


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
