"""Kinds of quantity and their units: what a student writes becomes an SI float, and an SI float what is expected.

The only module that imports pint, and only when the first unusual unit is met (0.3 s): the factors of the
everyday ones stand in `_EVERYDAY`, and a test compares them with pint. pint gets expressions made of names from
our own table, in a registry of our own definitions: its own takes ``Nm`` for a textile unit, ``U/min`` for an
enzyme activity, 1 Hz for 1 rad/s, and can be kept busy for ever by ``9**9**9*m``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from gyrodata.unit_grammar import (
    MAX_UNIT_LENGTH,
    STANDARD_GRAVITY,
    TABLE,
    Dimensions,
    Parsed,
    UnitError,
    fold_letters,
    parse,
)

__all__ = [
    "DISPLAY",
    "KINDS",
    "LIMITS",
    "MAX_UNIT_LENGTH",
    "RPM",
    "SI",
    "STANDARD_GRAVITY",
    "Kind",
    "Uncertainty",
    "Unit",
    "UnitError",
    "fold_letters",
    "from_si",
    "kinds_of",
    "parse_unit",
]

RPM = math.pi / 30
"""One revolution per minute [rad/s]."""


class Kind(NamedTuple):
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


_MASS, _LENGTH, _TIME = Dimensions(mass=1), Dimensions(length=1), Dimensions(time=1)
_ANGLE, _TURN, _FORCE = Dimensions(angle=1), Dimensions(turn=1), Dimensions(1, 1, -2)
_RATES = (Dimensions(time=-1, angle=1), Dimensions(time=-1, turn=1), Dimensions(time=-1))
# "g*cm" means the weight of that mass at that arm.
_TORQUES = (Dimensions(1, 2, -2), Dimensions(1, 1, 0))
_INERTIA, _ACCELERATION = Dimensions(1, 2, 0), Dimensions(0, 1, -2)
_PER_TURN = Dimensions(time=1, turn=-1)
_RATE_UNITS = "rpm, Hz, rev/s, rad/s, deg/s"
_INERTIA_UNITS = "kg*m^2, g*m^2, g*cm^2"

KINDS: dict[str, Kind] = {
    "mass": Kind("kg", "g", "a mass", (_MASS,), (1e-9, 1e4), "g, kg", '"20 g"'),
    "length": Kind("m", "cm", "a length", (_LENGTH,), (1e-9, 1e3), "mm, cm, m", '"15 cm"'),
    "torque": Kind("N*m", "N*m", "a torque", _TORQUES, (1e-12, 1e6), "N*m, mN*m, gf*cm", '"0.03 N*m"'),
    "force": Kind("N", "N", "a force", (_FORCE,), (1e-9, 1e6), "N, mN, gf", '"0.2 N"'),
    "rate": Kind("rad/s", "rpm", "a rotation rate", _RATES, (1e-6, 1e6), _RATE_UNITS, '"400 rpm"'),
    "time": Kind("s", "s", "a time", (_TIME, _PER_TURN), (1e-6, 1e7), "s, ms, min", '"7.06 s"'),
    "number": Kind("", "", "a number of turns", (Dimensions(), _TURN), (1e-6, 1e6)),
    "angle": Kind("rad", "deg", "an angle", (_ANGLE, _TURN), (1e-6, 1e7), "deg, rad, rev", '"120 deg"'),
    "inertia": Kind(
        "kg*m^2", "kg*m^2", "a moment of inertia", (_INERTIA,), (1e-12, 1e6), _INERTIA_UNITS, '"0.004 kg*m^2"'
    ),
    "acceleration": Kind(
        "m/s^2", "m/s^2", "an acceleration", (_ACCELERATION,), (1e-3, 1e3), "m/s^2, cm/s^2", '"9.803 m/s^2"'
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
        raise UnitError(
            str(fault), f"for {KINDS[kind].words}, write one of: {KINDS[kind].examples}", fault.reason
        ) from None
    dimensions = parsed.dimensions
    if kind == "rate" and dimensions == _TIME:
        hint = "a time per revolution goes into a column spin_period [s], or is written in s/rev"
        raise UnitError(f'"{text.strip()}" is a time, not a rotation rate', hint, "kind")
    if dimensions not in KINDS[kind].dimensions:
        raise UnitError(
            f'"{text.strip()}" is no unit of {KINDS[kind].words}', f"write one of: {KINDS[kind].examples}", "kind"
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
