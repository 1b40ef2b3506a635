"""What a cell says beyond a plain quantity, what its value may be, and the values that a student reports.

A value that a student reports, ``# reported_inertia: 4.4e-3 ± 0.1e-3 kg m^2``, is an answer, not a reading: a malformed
one is not a fault of the log, and what is wrong with it is kept beside what can still be read of it, for whoever grades
it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from gyrodata import diagnostics, quantities, vocabulary
from gyrodata.quantities import CellError as CellError
from gyrodata.quantities import read_cell as read_cell
from gyrodata.quantities import to_float
from gyrodata.readings.headers import name_roles, turns_in, words_of_turns
from gyrodata.readings.roles import BY_NAME, kind_of_role
from gyrodata.units import KINDS, LIMITS, SI, kinds_of

BLANKS = frozenset({"", "-", "–", "—", "−", "--", "~", "‐", "‑", "n/a", "N/A", "n.a.", "#N/A", "NA"})
"""What is written if nothing was measured."""
SPOKEN = ("mass", "turns", "spin_turns")
"""Roles whose numbers are also said in words."""
_NO_WEIGHT = frozenset(vocabulary.words("no_weight").split())
_TURN_BEHIND = rf"(?i)(.*?)\s*(?:of\s+)?(?:an?\s+)?(?:{vocabulary.words('turn', '|')})\w*\.?"


@lru_cache(maxsize=4096)
def said_otherwise(text: str, role: str) -> str:
    """Give the number that a cell says in another way: "none" of a mass, "one third" or "120°" of turns."""
    if role == "mass":
        return "0 g" if re.sub(r"[\s.\-]+", "", text).lower() in _NO_WEIGHT else ""
    if fraction := fraction_of_date(text):
        return fraction
    match = re.fullmatch(_TURN_BEHIND, text)
    bare = match[1] if match else text
    if words := words_of_turns(bare, whole=True):
        return words
    if bare != text and (bare == "" or quantities.take_apart(bare) is not None):
        return bare or "1"
    written = quantities.take_apart(text)
    angle = written is not None and written.spread is None and kinds_of(written.unit or "") == {"angle"}
    return turns_in(text) if angle else ""


def fraction_of_date(text: str) -> str:
    """Undo what a spreadsheet makes of 1/3 and 2/3: "3-Jan", "01. Mrz", "2026-01-03 00:00:00"; "" if it is none."""
    pair = quantities.date_pair(text)
    if pair is None or not (min(pair) == 1 or sorted(pair) == [2, 3]) or max(pair) > 12:
        return ""
    return f"{min(pair)}/{max(pair)}"


def rounded_turns(text: str) -> tuple[str, float]:
    """Find the part of a turn that 0.33 or 0.7 was rounded from, and half of what the rounding leaves open; "", 0 else.

    The screws of the ball are a third of a turn apart; a twelfth is what a run without a weight takes.
    """
    # Whole turns, however many, are meant as written.
    if not quantities.PLAIN.fullmatch(text) or quantities.last_place(text) >= 0:
        return "", 0.0
    value, step = to_float(text), float(f"1e{quantities.last_place(text)}")
    twelfths = round(value * 12)
    # Quarters have few digits: they are meant as written. Who cuts 2/3 off at 0.66 is off by nearly a whole step.
    if twelfths % 3 == 0 or abs(value - twelfths / 12) >= step:
        return "", 0.0
    return str(Fraction(twelfths, 12)), step / math.sqrt(3)


@lru_cache(maxsize=16384)
def check_value(role: str, value: float) -> tuple[str, str]:
    """Say what is wrong with a number that cannot be, and what to type; two empty texts if nothing is."""
    known, kind = BY_NAME.get(role), kind_of_role(role)
    steep = abs(value) >= math.pi / 2
    broken = {"above zero": value <= 0, "not zero": value == 0, "not below zero": value < 0, "below 90 degrees": steep}
    if known and broken.get(known.bound):
        return f"must be {known.bound}", known.bound_hint
    low, high = LIMITS.get(kind, (0.0, math.inf))
    if value == 0 or low <= abs(value) <= high:
        return "", ""
    fault = f"is too {'large' if abs(value) > high else 'small'} for {KINDS[kind].words} in a lab"
    return fault, f"is its unit the one written? Read are {low:g} to {high:g} {SI[kind]}".rstrip()


PREFIX = "reported_"
REPORTED_KINDS = {"inertia": "inertia", "imbalance": "torque", "timing_bias": "time", "exponent": "number"}
"""Kind of quantity of what is read of a lab's report."""

Fault = Literal["unreadable", "no unit", "wrong unit", "given twice"]
_FAULTS: dict[str, Fault] = {diagnostics.UNIT_MISSING: "no unit", diagnostics.UNIT_UNKNOWN: "wrong unit"}
_HUGE = 1e30
"""A number above this, or below one over it, is not a quantity of a lab [SI]."""


class Reported(Struct, frozen=True):
    """One value that a student reports, as far as it can be read.

    Attributes
    ----------
    key : str
        What it is: ``inertia``, ``imbalance``, …
    text : str
        As written.
    value : float or None
        [SI unit of its kind]; if its unit is missing, or is one of another kind, the number taken as SI: the unit is
        judged by itself. None if it cannot be read.
    u : float or None
        Its standard uncertainty [SI unit of its kind], that is what is stated divided by a k written behind it; None
        if none is stated.
    digits : int or None
        Significant digits of the value; zeros at its end count behind the point, where they say something.
    u_digits : int or None
        Those of the uncertainty.
    step : float or None
        One step of the value's last digit [SI unit of its kind].
    u_step : float or None
        One step of the uncertainty's last digit [SI unit of its kind]; None if it is stated in %.
    fault : {"unreadable", "no unit", "wrong unit", "given twice"} or None
        What is wrong, in a word.
    problem : str or None
        What is wrong, in a sentence; None exactly if `fault` is.
    line : int or None
        Its line in its file, 1-based.
    """

    key: str
    text: str
    value: float | None = None
    u: float | None = None
    digits: int | None = None
    u_digits: int | None = None
    step: float | None = None
    u_step: float | None = None
    fault: Fault | None = None
    problem: str | None = None
    line: int | None = None


def canonical_key(key: str) -> str:
    """Name what is reported: ``reported_I_zz`` and ``reported_moment_of_inertia`` are ``inertia``."""
    bare = key[len(PREFIX) :] if key.lower().startswith(PREFIX) else key
    return "inertia" if name_roles(bare)[0] == ("inertia",) else bare.lower()


def read_reported(key: str, text: str, line: int | None = None, ask: bool = True) -> Reported:
    """Read one reported value: ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` or ``4.4(1) g m^2``."""
    read = Reported(canonical_key(key), text.strip(), line=line)
    kind = REPORTED_KINDS[read.key]
    bare = re.sub(quantities.IN_FRONT, "", read.text)
    written = quantities.take_apart(bare)
    try:
        quantity = read_cell(bare, kind, None, ask)
    except CellError as error:
        fault = _FAULTS.get(error.code, "unreadable")
        read = replace(read, fault=fault, problem=f'"{read.text[:60]}" {error}')
        if written is None or fault == "unreadable":
            return read
        spread_unit = "%" if written.spread_unit == "%" else None
        quantity = quantities.in_si(replace(written, unit=SI[kind], spread_unit=spread_unit), kind)
    u = quantity.uncertainty and quantity.uncertainty.at(quantity.value)
    if any(not 1 / _HUGE <= abs(size) <= _HUGE for size in (quantity.value, u) if size):
        return replace(read, fault="unreadable", problem=f'"{read.text[:60]}" is far from anything in a lab')
    read = replace(read, value=quantity.value, u=u, step=quantity.step, u_step=quantity.u_step)
    if written is None or quantity.step is None:
        return read  # a fraction has no digits that could be counted
    return replace(read, digits=_digits(written.number), u_digits=written.spread and _digits(written.spread))


def _digits(number: str) -> int:
    """Count significant digits, those of ``0.0044`` as of ``4.4e-3``; zeros before the point may only fill up."""
    mantissa = re.split("[eE]", number)[0]
    digits = re.sub("[^0-9]", "", mantissa).lstrip("0")
    return len(digits if re.search("[.,]", mantissa) else digits.rstrip("0")) or 1


def find_in_row(texts: Sequence[str]) -> tuple[int, str] | None:
    """Find I_zz in a row of a table, "I_zz", "4.4e-3 ± 0.1e-3 kg m^2" or both in one cell: where, and the value."""
    for at, text in enumerate(texts):
        name, _, value = text.replace("=", ":").partition(":")
        value = (value or " ".join(texts[at + 1 :])).strip()
        named = text[:1].isalpha() and value and canonical_key(name.strip()) == "inertia"
        if named and read_reported("inertia", value).fault is None:
            return at, value
    return None
