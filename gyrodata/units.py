"""Units at the border: what a student writes becomes an SI float, and an SI float becomes what a reader expects.

The only module that imports pint, and only when the first unusual unit is met (0.3 s): the factors of the
everyday ones stand in `_EVERYDAY`, and a test compares them with pint. pint gets expressions made of names from
our own table, in a registry of our own definitions: its own takes ``Nm`` for a textile unit, ``U/min`` for an
enzyme activity, 1 Hz for 1 rad/s, and can be kept busy for ever by ``9**9**9*m``.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from gyrodata.kinds import DISPLAY, LIMITS, ROLE_KINDS, SI, describe_kinds, examples, kind_in_words, kind_of_role
from gyrodata.unit_grammar import (
    MAX_UNIT_LENGTH,
    TABLE,
    Dimensions,
    Parsed,
    UnitError,
    fold_letters,
    parse,
)

__all__ = [
    "DISPLAY",
    "LIMITS",
    "MAX_UNIT_LENGTH",
    "ROLE_KINDS",
    "SI",
    "Uncertainty",
    "Unit",
    "UnitError",
    "describe_kinds",
    "examples",
    "fold_letters",
    "from_si",
    "kind_in_words",
    "kind_of_role",
    "kinds_of",
    "parse_quantity",
    "parse_uncertainty",
    "parse_unit",
    "to_display",
]


@dataclass(frozen=True, slots=True)
class Unit:
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


@dataclass(frozen=True, slots=True)
class Uncertainty:
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
        """Give the standard uncertainty of one reading.

        Parameters
        ----------
        value : float
            The reading [SI unit of the role].

        Returns
        -------
        float
            Its standard uncertainty [SI unit of the role].
        """
        return self.absolute + self.relative * abs(value)


_MASS, _LENGTH, _TIME = Dimensions(mass=1), Dimensions(length=1), Dimensions(time=1)
_ANGLE, _TURN, _FORCE = Dimensions(angle=1), Dimensions(turn=1), Dimensions(1, 1, -2)

_DIMENSIONS: dict[str, tuple[Dimensions, ...]] = {
    "mass": (_MASS,),
    "length": (_LENGTH,),
    # "g*cm" means the weight of that mass at that arm.
    "torque": (Dimensions(1, 2, -2), Dimensions(1, 1, 0)),
    "force": (_FORCE,),
    "rate": (Dimensions(time=-1, angle=1), Dimensions(time=-1, turn=1), Dimensions(time=-1)),
    "time": (_TIME, Dimensions(time=1, turn=-1)),
    "number": (Dimensions(), _TURN),
    "angle": (_ANGLE, _TURN),
    "inertia": (Dimensions(1, 2, 0),),
    "acceleration": (Dimensions(0, 1, -2),),
    "sign": (),
    "text": (),
}
_STANDARD_GRAVITY = 9.80665

_EVERYDAY: dict[tuple[str, str], float] = {
    ("mass", "g"): 1e-3,
    ("mass", "kg"): 1.0,
    ("length", "mm"): 1e-3,
    ("length", "cm"): 1e-2,
    ("length", "m"): 1.0,
    ("time", "s"): 1.0,
    ("time", "s/rev"): 1.0,
    ("time", "min"): 60.0,
    ("rate", "rpm"): 2 * math.pi / 60,
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
    """Understand a unit as a unit of one kind of quantity.

    Parameters
    ----------
    text : str
        As written: ``rpm``, ``об/мин``, ``N·m``, ``rad·s⁻¹``, …
    kind : str
        Kind of quantity, a key of `SI`; it decides what hertz and ``g*cm`` mean.

    Returns
    -------
    Unit
        With a spelling that this function reads back, and the SI factor.

    Raises
    ------
    UnitError
        The unit is unknown, belongs to another kind of quantity, or can be meant in two ways.
    """
    try:
        parsed = parse(text)
    except UnitError as fault:
        raise UnitError(
            str(fault), f"for {kind_in_words(kind)}, write one of: {examples(kind)}", fault.reason
        ) from None
    dimensions = parsed.dimensions
    if kind == "rate" and dimensions == _TIME:
        hint = "a time per revolution goes into a column spin_period [s], or is written in s/rev"
        raise UnitError(f'"{text.strip()}" is a time, not a rotation rate', hint, "kind")
    if dimensions not in _DIMENSIONS[kind]:
        raise UnitError(
            f'"{text.strip()}" is no unit of {kind_in_words(kind)}', f"write one of: {examples(kind)}", "kind"
        )
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
    target = {
        "rate": "radian/second",
        "angle": "radian",
        "time": "second",
        "number": "turn" if parsed.dimensions.turn else "radian",
        "mass": "kilogram",
        "length": "meter",
        "torque": "newton*meter",
        "force": "newton",
        "inertia": "kilogram*meter**2",
        "acceleration": "meter/second**2",
    }[kind]
    quantity = registry.Quantity(1.0, parsed.expression)
    if kind == "torque" and parsed.dimensions == (1, 1, 0, 0, 0):
        quantity = quantity * registry.Quantity(_STANDARD_GRAVITY, "newton/kilogram")
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
    return frozenset(kind for kind, known in _DIMENSIONS.items() if dimensions in known)


def from_si(value: float, unit: str, kind: str) -> float:
    """Express an SI value in another unit.

    Parameters
    ----------
    value : float
        [SI unit of `kind`]
    unit : str
        Any spelling that `parse_unit` knows.
    kind : str
        Kind of quantity, a key of `SI`.

    Raises
    ------
    UnitError
        The unit does not fit.
    """
    return value / parse_unit(unit, kind).factor


def to_display(value: float, role: str) -> tuple[float, str]:
    """Give a value of a role in the unit it is usually shown in, with that unit (``g``, ``cm``, ``rpm``, …)."""
    kind = kind_of_role(role)
    return from_si(value, DISPLAY[kind], kind), DISPLAY[kind]


_NUMBER = r"[-+]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][-+]?[0-9]{1,4})?"
_QUANTITY = re.compile(rf"({_NUMBER})(?:\s*/\s*([0-9]+))?\s*(.*)", re.DOTALL)


def parse_quantity(text: str, kind: str) -> float:
    """Understand one number with its unit: ``60 g``, ``200 rpm``, ``9.803 m/s^2``, ``0.1 s per turn``, ``1/3``.

    Parameters
    ----------
    text : str
        As written; a decimal comma is as good as a point.
    kind : str
        Kind of quantity, a key of `SI`.

    Returns
    -------
    float
        [SI unit of `kind`]

    Raises
    ------
    UnitError
        No number, no unit where one is needed, or a unit that does not fit.
    """
    match = _QUANTITY.fullmatch(text.strip().replace("−", "-"))
    if match is None:
        raise UnitError(f'"{text.strip()[:40]}" is not a number with a unit', f"write it like {_sample(kind)}")
    number, divisor, unit = match.groups()
    value = float(number.replace(",", "."))
    if divisor is not None:
        value = value / int(divisor) if int(divisor) else math.inf
    if not unit and kind not in ("number", "sign"):
        raise UnitError(f'"{text.strip()}" has no unit', f"write it like {_sample(kind)}")
    if kind == "rate" and "time" in kinds_of(unit) and "rate" not in kinds_of(unit):
        value = _rate_of_period(value, unit)
    else:
        value *= parse_unit(unit, kind).factor
    if not math.isfinite(value):
        raise UnitError(f'"{text.strip()[:40]}" is no finite number')
    return value


def _rate_of_period(value: float, unit: str) -> float:
    """Turn "0.1 s per turn" into a rate; "0.1 s" alone might be the time of ten turns."""
    period = parse_unit(unit, "time")
    if "/" not in period.text:
        raise UnitError(
            f'"{unit}" is a time, not a rotation rate',
            "write s/rev if it is the time of one revolution",
            "kind",
        )
    return 2 * math.pi / (value * period.factor) if value else math.inf


@lru_cache(maxsize=512)
def parse_uncertainty(text: str, kind: str, unit: str = "") -> Uncertainty:
    """Understand a standard uncertainty: ``0.5 mm``, ``0.2 %``, or a sum of both, ``0.2 % + 0.5 rpm``.

    Parameters
    ----------
    text : str
        As written.
    kind : str
        Kind of quantity, a key of `SI`.
    unit : str
        Unit of a term that has none of its own.

    Raises
    ------
    UnitError
        Not such a sum, a negative term, or a unit that does not fit.
    """
    absolute = relative = 0.0
    for term in re.split(r"(?<![eE])\+", text.strip().lstrip("±+ ")):
        if term.rstrip().endswith("%"):
            part = parse_quantity(term.rstrip()[:-1], "number") / 100
            relative += part
        else:
            bare = _QUANTITY.fullmatch(term.strip())
            part = parse_quantity(f"{term} {unit}" if bare and not bare[3] else term, kind)
            absolute += part
        if part < 0:
            raise UnitError(f'"{text.strip()[:40]}" is negative, and an uncertainty cannot be')
    if relative > 10 or absolute > LIMITS[kind][1]:
        raise UnitError(f'"{text.strip()[:40]}" is far too large for an uncertainty', "is its unit the one written?")
    return Uncertainty(absolute, relative)


def _sample(kind: str) -> str:
    return {
        "mass": '"20 g"',
        "length": '"15 cm"',
        "torque": '"0.03 N*m"',
        "force": '"0.2 N"',
        "rate": '"400 rpm"',
        "time": '"7.06 s"',
        "angle": '"120 deg"',
        "inertia": '"0.004 kg*m^2"',
        "acceleration": '"9.803 m/s^2"',
    }.get(kind, '"1/3"')
