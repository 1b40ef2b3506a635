"""The roles: what a column of a log can measure, one record each; and what is missing.

And the other keys that a log can give.

A new role is one record in `vocabulary.toml`, with its names there; readers, hints and
fill-down use these records.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from itertools import chain
from typing import Literal

from msgspec import Struct, convert

from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.error_sources import SOURCES
from gyrodata.quantities.units import Uncertainty


class Role(Struct, frozen=True):
    """A quantity that a column can measure."""

    name: str
    kind: str
    """Kind of quantity, a key of `gyrodata.quantities.units.SI`."""
    part: Literal["", "load", "spin", "count", "timing"] = ""
    """Part of a run that it measures: what turns the rod, the spin, how far the rod
    turned, and how long that took."""
    bound: Literal[
        "", "above zero", "not zero", "not below zero", "below 90 degrees"
    ] = ""
    """Condition for its values."""
    bound_hint: str = ""
    """What to type if a value is outside the bound."""
    sample: str = ""
    """Value to propose if it is missing."""
    meaning: str = ""
    """Its meaning, in words."""
    instead: str = ""
    """What can replace it, for hints."""
    derived_from: tuple[str, ...] = ()
    """Sets of roles, each separated by blanks; if all of one set are there, this role
    is only compared."""
    by_unit_without: tuple[str, ...] = ()
    """Roles; if none of them is there, a column without a known name can have this role
    by its unit."""
    u_of: str = ""
    """Role whose ``u_…`` is used if it has no ``u_…`` of its own."""


TABLE = tuple(
    convert({"name": name, **fields}, Role) for name, fields in vocabulary.ROLES.items()
)

_KEYS_OF_LANGUAGES = dict.fromkeys(chain.from_iterable(vocabulary.LANGUAGES.values()))
SHARED_NAMES = tuple(key for key in _KEYS_OF_LANGUAGES if " " in key)
"""Roles that share names, as they are written in the vocabulary."""

BY_NAME: dict[str, Role] = {role.name: role for role in TABLE}
ROLES = tuple(BY_NAME)
TEXTS = frozenset(role.name for role in TABLE if role.kind == "text")


def _of_part(part: str) -> tuple[str, ...]:
    return tuple(role.name for role in TABLE if role.part == part)


LOADS = _of_part("load")
COUNTS = _of_part("count")
TIMINGS = _of_part("timing")
"""Roles by the part of a run that they measure; of several timings, the first is used.
"""
FILLED_DOWN = {*LOADS, *COUNTS, *_of_part("spin")}
FILLED_DOWN |= {"weight_diameter", "transverse_inertia"}
"""Roles whose blank cells take the value above, as in merged cells."""
ONE_TURN = TIMINGS[1:]
"""Timings of one whole turn, which need no number of turns."""
SPIN_SETS = (
    ("spin",),
    ("spin_start", "spin_end"),
    ("spin_period",),
    ("spin_period_start", "spin_period_end"),
    ("spin_time", "spin_turns"),
)
"""Each of these sets gives the spin of a run; of several, the first is used."""

CONSTANTS = vocabulary.CONSTANTS
"""Kinds of the constants of a log that are not roles."""

SHARED_UNCERTAINTIES = {
    f"u_{key}": source.kind for key, source in SOURCES.items() if source.kind
}
SHARED_UNCERTAINTIES |= {"u_imbalance": "torque", "u_ball_mass": "mass"}
SHARED_UNCERTAINTIES |= {"u_ball_diameter": "length", "u_rod_length": "length"}
"""Kinds of the uncertainties whose names are not those of roles."""

UNCERTAINTIES = (
    *(f"u_{role.name}" for role in TABLE if role.kind not in ("sign", "text")),
    *SHARED_UNCERTAINTIES,
)


ORIGIN_LENGTHS = {
    "surface": ("ball_diameter", 0.5, "surface_unknown"),
    "tip": ("rod_length", 1.0, "tip_unknown"),
}
"""Origins of positions: the length that says where the centre is, the share of it that
is between both, and the name of the message if it is not given."""
OTHER_KEYS = tuple(vocabulary.LINES)
KEYS = (*ROLES, *CONSTANTS, *UNCERTAINTIES, *OTHER_KEYS)
"""Every key of ``# key: value``, ``--set`` and ``--config``."""


def kind_of_role(role: str) -> str:
    """Return the kind of quantity of a role, a constant or a ``u_…`` key.

    The function raises KeyError if the name does not have a kind.
    """
    if role in SHARED_UNCERTAINTIES:
        return SHARED_UNCERTAINTIES[role]
    base = role.removeprefix("u_")
    if base in CONSTANTS:
        return CONSTANTS[base]
    return BY_NAME[base].kind


def u_keys(role: str) -> tuple[str, ...]:
    """Return the ``u_…`` keys of a role, its own first."""
    shared = BY_NAME[role].u_of if role in BY_NAME else ""
    if shared:
        return (f"u_{role}", f"u_{shared}")
    return (f"u_{role}",)


def as_u_of(role: str, key: str, u: Uncertainty) -> Uncertainty:
    """Convert the uncertainty of a ``u_…`` key to the unit of a role.

    An angle is a share of a turn.
    """
    kind = kind_of_role(role)
    if kind == kind_of_role(key):
        return u
    per_turn = 2 * math.pi
    if kind == "number":
        per_turn = 1 / per_turn
    return Uncertainty(u.absolute * per_turn, u.relative)


def stated_u(role: str, stated: Mapping[str, Uncertainty]) -> Uncertainty | None:
    """Return the uncertainty that a log states for every reading of a role.

    None if it states none.
    """
    return next(
        (as_u_of(role, key, stated[key]) for key in u_keys(role) if key in stated), None
    )


def to_display(value: float, role: str) -> tuple[float, str]:
    """Return a value of a role in the unit in which it is usually shown.

    The function also returns this unit (``g``, ``cm``, ``rpm``, …).
    """
    kind = kind_of_role(role)
    return units.from_si(value, units.DISPLAY[kind], kind), units.DISPLAY[kind]


def derived_roles(there: set[str]) -> set[str]:
    """Return the roles that are only compared.

    The readings from which they are calculated are present as well.
    """
    return {role.name for role in TABLE if _is_derived(role, there)}


def _is_derived(role: Role, there: set[str]) -> bool:
    return any(there.issuperset(readings.split()) for readings in role.derived_from)


def check_value(role: str, value: float) -> tuple[str, str]:
    """Return what is wrong with an impossible number, and what to type.

    Two empty texts if the number is possible.
    """
    known = BY_NAME.get(role)
    kind = kind_of_role(role)
    steep = abs(value) >= math.pi / 2
    broken = {
        "above zero": value <= 0,
        "not zero": value == 0,
        "not below zero": value < 0,
        "below 90 degrees": steep,
    }
    if known and broken.get(known.bound):
        return f"must be {known.bound}".replace("be not", "not be"), known.bound_hint
    low, high = units.LIMITS.get(kind, (0.0, math.inf))
    if value == 0 or low <= abs(value) <= high:
        return "", ""
    fault = (
        f"is too {'large' if abs(value) > high else 'small'} for "
        f"{units.KINDS[kind].words} in a lab"
    )
    return (
        fault,
        "is its unit the one written? "
        f"Read are {low:g} to {high:g} {units.SI[kind]}".rstrip(),
    )


REPORTED = "reported_"
"""Beginning of the keys of a student's results."""


def is_key(key: str) -> bool:
    """Return whether a ``# key: value`` line gives a value, and is not a note."""
    return key.lower() in KEYS or key.lower().startswith(REPORTED)


# What is missing


def missing_roles(
    there: set[str], columns: Collection[str], loaded: bool = True
) -> list[str]:
    """Name what a run lacks, or the whole log.

    Of several roles that serve, one that the log has a column of. A run that is not
    `loaded` needs no load.
    """
    missing = _missing_load(there, columns) if loaded else []
    return [*missing, *_missing_spin(there, columns), *_missing_timing(there, columns)]


def _missing_load(there: set[str], columns: Collection[str]) -> list[str]:
    if "torque" in there:
        return []
    pulls = [role for role in ("mass", "force", "torque") if role in columns]
    pull = pulls[0] if pulls else "mass"
    missing = [pull] if there.isdisjoint(("mass", "force")) else []
    if pull != "torque" and "position" not in there:
        missing.append("position")
    return missing


def _missing_spin(there: set[str], columns: Collection[str]) -> list[str]:
    if any(there.issuperset(names) for names in SPIN_SETS):
        return []
    known = there.union(columns)
    begun = [names for names in SPIN_SETS if not known.isdisjoint(names)]
    needed = begun[0] if begun else ("spin",)
    return [role for role in needed if role not in there]


def _missing_timing(there: set[str], columns: Collection[str]) -> list[str]:
    if not there.isdisjoint(ONE_TURN):
        return []
    missing = [] if "time" in there else ["time"]
    whole = [role for role in ONE_TURN if role in columns]
    if whole and "time" not in columns:
        return whole[:1] if missing else []
    return [*missing, *_missing_count(there, columns)]


def _missing_count(there: set[str], columns: Collection[str]) -> list[str]:
    if not there.isdisjoint(COUNTS):
        return []
    counts = [role for role in COUNTS if role in columns]
    return counts[:1] or ["turns"]


def can_be_found_by_unit(role: Role, there: set[str]) -> bool:
    """Return whether a column can have a missing role by its unit alone."""
    if not role.by_unit_without or not there.isdisjoint(role.by_unit_without):
        return False
    return role.name != "time" or not there.isdisjoint(COUNTS)
