"""One header: which roles it may name, the unit it carries, and an uncertainty if it holds one."""

from __future__ import annotations

import difflib
import re
from functools import lru_cache
from typing import NamedTuple

from gyrodata.readings.vocabulary import (
    END_WORDS,
    NAMES,
    NOISE_WORDS,
    ROLES,
    START_WORDS,
    SYMBOLS,
    UNCERTAINTIES,
    UNSURE_WORDS,
    squeeze,
)
from gyrodata.units import kind_of_role, kinds_of


class Header(NamedTuple):
    """What a header says."""

    text: str
    roles: tuple[str, ...]
    """Roles it may name; none if it names none."""
    unit: str | None
    """Unit text as written, known or not; None if there is none."""
    spread: str
    """Text of a ±, with its unit if it has one; or ""."""
    number: int | None = None
    """Number of a repeat: ``time_2`` is 2."""


_SPREAD = re.compile(r"[\[(]?\s*(?:±|\+/-|\+-)\s*([0-9]+(?:[.,][0-9]+)?)\s*([^\])\[(,;]*)[\])]?")
_BRACKET = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*(?:\([^()]*\)[^()]*)?)\))\s*")
_INDEX = re.compile(r"(.*?[^\W\d])[\s_\-.]*([1-9][0-9]?)")
_TOKENS = re.compile(r"[\s_,;()\-]+")


@lru_cache(maxsize=4096)
def parse_header(text: str) -> Header:
    """Understand one header as far as it goes by itself.

    Parameters
    ----------
    text : str
        As written, without blanks around it.
    """
    spread, rest = "", text
    if "±" in text or "+/-" in text or "+-" in text:
        match = _SPREAD.search(text)
        if match:
            spread = f"{match[1]} {match[2].strip()}".strip()
            rest = f"{text[: match.start()].strip()} {text[match.end() :].strip()}".strip(" ,;")
    name, unit = _split_unit(rest)
    if unit is None and spread and kinds_of(spread.partition(" ")[2]):
        unit = spread.partition(" ")[2]
    roles, index = name_roles(name)
    if unit and ":" in unit and re.fullmatch(r"[a-zA-Z:.]+", unit):
        unit = "s"  # "mm:ss.cc": how its cells are written, and they say so themselves
    if unit is not None:
        roles = _fitting(roles, unit)
    elif len(roles) > 1:
        # A bare "N" counts turns: the other readings would need a unit.
        bare = tuple(role for role in roles if kind_of_role(role) in ("number", "text", "sign"))
        roles = bare or roles
    return Header(text, roles, unit, spread, index)


def with_unit(header: Header, unit: str) -> Header:
    """Give a header the unit of the row below it."""
    roles, index = name_roles(header.text)
    return header._replace(roles=_fitting(roles, unit), unit=unit, number=index)


def _fitting(roles: tuple[str, ...], unit: str) -> tuple[str, ...]:
    """Keep the roles that the unit can measure; all of them if it fits none, so that the unit is at fault."""
    kinds = kinds_of(unit)
    kept = tuple(role for role in roles if kind_of_role(role) in kinds or (unit == "%" and role[:2] == "u_"))
    if "time" in kinds and not kept and "/" in unit and any(role.startswith("spin") for role in roles):
        # "spin [s/rev]" is a period under another name.
        return tuple(role.replace("spin", "spin_period", 1) for role in roles if role.startswith("spin"))
    return kept or roles


def _split_unit(text: str) -> tuple[str, str | None]:
    """Part a header into its name and its unit."""
    match = _BRACKET.fullmatch(text)
    if match:
        name, square, round_ = match.groups()
        inside = (square if square is not None else round_).strip()
        if square is not None or _is_unit_of(name, inside) or (kinds_of(inside) and not name_roles(name)[0]):
            return name.rstrip(" /,;"), inside or None
        if name_roles(text)[0] or not name_roles(name)[0]:
            return text, None  # "czas (t)": a symbol, not a unit
        return (name, inside) if inside else (name, None)
    if name_roles(text)[0]:
        return text, None
    return _split_loose(text)


def _split_loose(text: str) -> tuple[str, str | None]:
    """Part ``m, кг``, ``t / s``, ``mass_g``, ``time s``; a name that is a rate unit alone is the spin's."""
    for separator, last in ((",", True), (";", True), ("/", False)):
        left, found, right = text.rpartition(separator) if last else text.partition(separator)
        left, right = left.strip(), right.strip()
        if found and left and right and _is_unit_of(left, right):
            return left, right
    for left, right in _cuts(text):
        if _is_unit_of(left, right) and right not in ("h", "t", "r", "U", "об"):
            return left, right
    if kinds_of(text) == {"rate"}:
        return "spin", text
    left, found, right = text.rpartition(",")
    if found and name_roles(left.strip())[0] and right.strip():
        return left.strip(), right.strip()  # an unknown unit, to be told so
    return text, None


def _cuts(text: str) -> list[tuple[str, str]]:
    """Cut at each blank and underscore, the shortest name first so that "rad s^-1" stays whole."""
    places = [m.start() for m in re.finditer(r"[\s_]", text)]
    return [(text[:i].strip(" _"), text[i:].strip(" _")) for i in places if text[:i].strip(" _")]


def _is_unit_of(name: str, unit: str) -> bool:
    roles, _ = name_roles(name)
    kinds = kinds_of(unit)
    roles = roles or name_roles(name.rstrip(" /,;"))[0]
    if not roles or not (kinds or unit == "%"):
        return False
    return any(kind_of_role(role) in kinds or (unit == "%" and role[:2] == "u_") for role in roles) or bool(
        kinds and not SYMBOLS.get(squeeze(unit))
    )


@lru_cache(maxsize=4096)
def name_roles(name: str) -> tuple[tuple[str, ...], int | None]:
    """Find the roles that a name without a unit may mean, and the number of a repeat."""
    roles = _plain_roles(name) or _unsure_roles(name)
    if roles:
        return roles, None
    match = _INDEX.fullmatch(name.strip())
    if match and "time" in _plain_roles(match[1]):
        return ("time",), int(match[2])
    return (), None


def _plain_roles(name: str) -> tuple[str, ...]:
    symbol = squeeze(name)
    if symbol in SYMBOLS:
        return SYMBOLS[symbol]
    lower = symbol.lower()
    if lower in NAMES:
        return NAMES[lower]
    if lower.startswith("u") and name.lower().replace(" ", "_").replace("-", "_") in UNCERTAINTIES:
        return (name.lower().replace(" ", "_").replace("-", "_"),)
    if len(lower) == 1 and lower in SYMBOLS and symbol not in SYMBOLS:
        return SYMBOLS[lower] if lower not in "tnm" else ()
    return _piecewise_roles(name) or _modified_roles(name)


def _piecewise_roles(name: str) -> tuple[str, ...]:
    """Read "Mass, m" and "czas (t)": a word with its symbol; what both mean is meant."""
    pieces = [piece for piece in re.split(r"[,;()]+", name) if piece.strip()]
    if len(pieces) < 2:
        return ()
    found = [_plain_roles(piece.strip()) for piece in pieces]
    if not found[0]:
        return ()
    common = found[0]
    for roles in found[1:]:
        if roles:
            common = tuple(role for role in common if role in roles)
    unknown = [
        piece
        for piece, roles in zip(pieces, found, strict=True)
        if not roles and squeeze(piece).lower() not in NOISE_WORDS
    ]
    return () if unknown else common


def _modified_roles(name: str) -> tuple[str, ...]:
    """Read "initial spin", "mean period", "spin before": a known name between small words."""
    tokens = [token for token in _TOKENS.split(name) if token]
    if not 2 <= len(tokens) <= 8:
        return ()
    if squeeze(tokens[-1]) in SYMBOLS and len(squeeze(tokens[-1])) < 3:
        word = NAMES.get(squeeze(" ".join(tokens[:-1])).lower(), ())  # "Mass m"
        both = tuple(role for role in word if role in SYMBOLS[squeeze(tokens[-1])])
        if both:
            return both
    lower = [squeeze(token).lower() for token in tokens]
    start = any(token in START_WORDS for token in lower)
    end = any(token in END_WORDS for token in lower)
    left = [t for t, low in zip(tokens, lower, strict=True) if low not in START_WORDS | END_WORDS | NOISE_WORDS]
    if not left or len(left) == len(tokens) or (start and end):
        return ()
    key = squeeze(" ".join(left))
    roles = SYMBOLS.get(key) or NAMES.get(key.lower(), ())
    if not (start or end):
        return roles
    suffix = "_start" if start else "_end"
    return tuple(role + suffix for role in roles if role + suffix in ROLES)


def _unsure_roles(name: str) -> tuple[str, ...]:
    """Read "σ_M", "Δt", "u(m)", "err time" as the uncertainty of what follows."""
    bare = name.strip()
    match = re.fullmatch(r"(?:[σδΔ∆ε]|u(?=[\s_(])|s(?=\())[\s_]*\(?(.+?)\)?", bare)
    if match:
        roles = tuple(f"u_{role}" for role in _plain_roles(match[1]) if f"u_{role}" in UNCERTAINTIES)
        # Δt may be an error, or simply the time that went by.
        return roles + (_plain_roles(match[1]) if bare[0] in "Δ∆" else ())
    tokens = [token for token in _TOKENS.split(bare) if token]
    left = [token for token in tokens if squeeze(token).lower() not in UNSURE_WORDS]
    if left and len(left) < len(tokens):
        roles = _plain_roles(" ".join(left))
        return tuple(f"u_{role}" for role in roles if f"u_{role}" in UNCERTAINTIES)
    return ()


def unit_for(text: str, kind: str) -> str | None:
    """Find the unit in a header whose name is not known, once ``--map`` has told what it measures."""
    for separator in (",", ";", "/", "_", " "):
        _, found, right = text.rpartition(separator)
        if found and kind in kinds_of(right.strip()):
            return right.strip()
    return None


def suggest_role(header: str) -> str:
    """Propose the role whose name a header nearly is; "" if it is near to none."""
    name, _ = _split_unit(header)
    loose = re.sub(r"[\[(].*", "", name).strip()
    for key in (squeeze(loose).lower(), squeeze(re.split(r"[\s_]", loose or " ")[0]).lower()):
        close = difflib.get_close_matches(key, NAMES, n=1, cutoff=0.75) if len(key) > 2 else []
        if close:
            return NAMES[close[0]][0]
    return ""
