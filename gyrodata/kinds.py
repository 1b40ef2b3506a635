"""Kinds of quantity: which role is of which kind, the unit each is kept and shown in, and the words for them."""

from __future__ import annotations

from collections.abc import Iterable

SI: dict[str, str] = {
    "mass": "kg",
    "length": "m",
    "torque": "N*m",
    "force": "N",
    "rate": "rad/s",
    "time": "s",
    "number": "",
    "angle": "rad",
    "inertia": "kg*m^2",
    "acceleration": "m/s^2",
    "sign": "",
    "text": "",
}
"""Unit in which each kind of quantity is kept inside."""

DISPLAY: dict[str, str] = SI | {"mass": "g", "length": "cm", "rate": "rpm", "angle": "deg"}
"""Unit in which each kind of quantity is shown, and which a message proposes."""

LIMITS: dict[str, tuple[float, float]] = {
    "mass": (1e-9, 1e4),
    "length": (1e-9, 1e3),
    "torque": (1e-12, 1e6),
    "force": (1e-9, 1e6),
    "rate": (1e-6, 1e6),
    "time": (1e-6, 1e7),
    "number": (1e-6, 1e6),
    "angle": (1e-6, 1e7),
    "inertia": (1e-12, 1e6),
    "acceleration": (1e-3, 1e3),
}
"""Smallest and largest size [SI unit] of what stands on a lab bench, zero apart: far from all that was ever read."""

ROLE_KINDS: dict[str, str] = {
    "mass": "mass",
    "position": "length",
    "torque": "torque",
    "force": "force",
    "spin": "rate",
    "spin_start": "rate",
    "spin_end": "rate",
    "spin_period": "time",
    "spin_period_start": "time",
    "spin_period_end": "time",
    "time": "time",
    "turns": "number",
    "angle": "angle",
    "precession_period": "time",
    "precession_rate": "rate",
    "pitch": "angle",
    "spin_sense": "sign",
    "precession_sense": "sign",
    "transverse_inertia": "inertia",
    "inertia": "inertia",
    "run": "text",
    "note": "text",
    "g": "acceleration",
    "ball_diameter": "length",
    "ball_mass": "mass",
}
"""Kind of quantity of every role and constant."""


# Uncertainty keys that belong to no role of their own name.
_U_KINDS = {
    "u_time_bias": "time",
    "u_spin_scale": "rate",
    "u_mass_scale": "mass",
    "u_position_zero": "length",
    "u_imbalance": "torque",
}


def kind_of_role(role: str) -> str:
    """Give the kind of quantity of a role, a constant or a ``u_…`` key (KeyError if there is none)."""
    if role in _U_KINDS:
        return _U_KINDS[role]
    return ROLE_KINDS[role.removeprefix("u_")]


def examples(kind: str) -> str:
    """List units to propose for a kind of quantity, in words."""
    return {
        "mass": "g, kg",
        "length": "mm, cm, m",
        "torque": "N*m, mN*m, gf*cm",
        "force": "N, mN, gf",
        "rate": "rpm, Hz, rev/s, rad/s, deg/s",
        "time": "s, ms, min",
        "angle": "deg, rad, rev",
        "inertia": "kg*m^2, g*m^2, g*cm^2",
        "acceleration": "m/s^2, cm/s^2",
    }.get(kind, "the number alone")


def kind_in_words(kind: str) -> str:
    """Say a kind of quantity in words, with its article."""
    return {
        "mass": "a mass",
        "length": "a length",
        "torque": "a torque",
        "force": "a force",
        "rate": "a rotation rate",
        "time": "a time",
        "number": "a number of turns",
        "angle": "an angle",
        "inertia": "a moment of inertia",
        "acceleration": "an acceleration",
        "sign": "a sense of rotation",
    }.get(kind, "a text")


def describe_kinds(kinds: Iterable[str]) -> str:
    """Say kinds of quantity in words, in a fixed order."""
    return " or ".join(kind_in_words(kind) for kind in SI if kind in set(kinds))
