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

from gyrodata import quantities, vocabulary
from gyrodata.quantities import CellError as CellError
from gyrodata.quantities import read_cell as read_cell
from gyrodata.quantities import to_float
from gyrodata.readings.headers import name_roles, turns_in, words_of_turns
from gyrodata.readings.roles import BY_NAME, kind_of_role
from gyrodata.units import KINDS, LIMITS, SI, UnitError, kinds_of, parse_unit

BLANKS = frozenset({"", "-", "–", "—", "−", "--", "~", "‐", "‑", "n/a", "N/A", "n.a.", "#N/A", "NA"})
"""What is written if nothing was measured."""
SPOKEN = ("mass", "turns", "spin_turns")
"""Roles whose numbers are also said in words."""
_NO_WEIGHT = frozenset(vocabulary.words("no_weight").split())
_TURN_BEHIND = (
    r"(?i)(.*?)\s*(?:of\s+)?(?:an?\s+)?(?:turn|rev|revolution|rotation|lap|round|circle|cycle|Umdrehung|Umlauf|tour|"
    r"оборот|об|vuelta|volta|obrót|obrot|圈|转)\w*\.?"
)


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
    broken = {
        "above zero": value <= 0,
        "not zero": value == 0,
        "not below zero": value < 0,
        "below 90 degrees": abs(value) >= math.pi / 2,
    }
    if known and broken.get(known.bound):
        return f"must be {known.bound}", known.bound_hint
    low, high = LIMITS.get(kind, (0.0, math.inf))
    if value == 0 or low <= abs(value) <= high:
        return "", ""
    fault = f"is too {'large' if abs(value) > high else 'small'} for {KINDS[kind].words} in a lab"
    return fault, f"is its unit the one written? Read are {low:g} to {high:g} {SI[kind]}".rstrip()


PREFIX = "reported_"
REPORTED_KINDS = {"inertia": "inertia", "imbalance": "torque", "timing_bias": "time", "exponent": "number"}
"""Kind of quantity of what a lab's report usually states; of anything else, the unit written tells it."""

Fault = Literal["unreadable", "no unit", "wrong unit", "given twice"]


class Reported(Struct, frozen=True):
    """One value that a student reports, as far as it can be read.

    Attributes
    ----------
    key : str
        What it is: ``inertia``, ``imbalance``, …
    text : str
        As written.
    value : float or None
        [SI unit of its kind]; if no unit is written, the number taken as SI. None if the number or its unit cannot be
        read.
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


_LARGEST = 1e100


def canonical_key(key: str) -> str:
    """Name what is reported: ``reported_I_zz`` and ``reported_moment_of_inertia`` are ``inertia``."""
    bare = key[len(PREFIX) :] if key.lower().startswith(PREFIX) else key
    return "inertia" if name_roles(bare)[0] == ("inertia",) else bare.lower()


def read_reported(key: str, text: str, line: int | None = None, ask: bool = True) -> Reported:
    """Read one reported value: ``4.4e-3 ± 0.1e-3 kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg m²`` or ``4.4(1) g m^2``."""
    read = Reported(canonical_key(key), text.strip(), line=line)
    shown, written = f'"{read.text[:60]}"', quantities.take_apart(read.text)
    if written is None or not (abs(written.value) <= _LARGEST and 0 <= to_float(written.spread or "0") <= _LARGEST):
        problem = f"{shown} is not a number with its unit and its uncertainty"
        return replace(read, fault="unreadable", problem=problem)
    unit, spread = written.unit or "", written.spread
    kind = REPORTED_KINDS.get(read.key) or next((kind for kind in SI if kind in kinds_of(unit)), "")
    if not kind and unit:
        return read  # nothing that this tool knows; the text says it all
    kind = kind or "number"
    try:
        quantity = quantities.in_si(written, kind, SI[kind])
    except UnitError as error:
        return replace(read, fault="wrong unit", problem=str(error))
    if ask and (ways := quantities.doubtful_comma(written, quantity.value, kind)):
        return replace(read, fault="unreadable", problem=f"{shown} can mean {ways}")
    read = replace(
        read,
        value=quantity.value,
        u=quantity.uncertainty and quantity.uncertainty.at(quantity.value),
        digits=_digits(written.number) if written.step else None,
        u_digits=_digits(spread) if spread else None,
        step=quantity.step,
    )
    if spread and not written.percent:
        factor = parse_unit(written.spread_unit or unit or SI[kind], kind).factor
        read = replace(read, u_step=10.0 ** quantities.last_place(spread) * factor)
    if SI[kind] and not unit:
        problem = f"{shown} has no unit: write one behind it, such as {KINDS[kind].examples}"
        read = replace(read, fault="no unit", problem=problem)
    return read


def _digits(number: str) -> int:
    """Count significant digits, those of ``0.0044`` as of ``4.4e-3``; zeros before the point may only fill up."""
    mantissa = re.split("[eE]", number)[0]
    digits = re.sub("[^0-9]", "", mantissa).lstrip("0")
    return len(digits if re.search("[.,]", mantissa) else digits.rstrip("0")) or 1


_HUGE = 1e30  # a number above this, or below one over it, is not a moment of inertia [kg*m^2]


def usable_inertia(reported: Reported | None) -> Reported | None:
    """Take the number of a report without a usable unit as kg·m²: the unit is judged once, by itself."""
    if reported is None:
        return None
    if reported.fault == "wrong unit" and (written := quantities.take_apart(reported.text)):
        again = quantities.in_si(replace(written, unit=SI["inertia"], spread_unit=None), "inertia")
        u = again.uncertainty and again.uncertainty.at(again.value)
        reported = replace(reported, value=again.value, u=u, step=again.step)
    if all(1 / _HUGE <= abs(size) <= _HUGE for size in (reported.value, reported.u) if size):
        return reported
    return replace(reported, value=None, problem=f'"{reported.text[:60]}" is far from any moment of inertia')


_ANSWER_FOLLOWS = r"(?i)(?:[=:≈|\t]|\bis\b)\s*(?=[-+(~≈\s]*[.\d]|(?:about|ca\.?|approx\S*)\s)"
_OF_OTHERS = r"(?i)theor|liter|manual|expect|nominal|refer|textbook|accept|true|given|simulat"
_CUTS = r"[,;.)|]?\s+|[.,;|]*$"
_LONGEST_ANSWER = 300
_PLAIN_WORDS = str.maketrans("_", " ", "{}*$`")


def find_inertia(line: str) -> str:
    """Find I_zz in a line of a report, ``Our result: I_zz = 4.4e-3 ± 0.1e-3 kg m^2``; "" where there is none.

    Its name must stand before it, and its unit behind it; "I_zz" and "moment of inertia" alone do without.
    """
    if len(line) > _LONGEST_ANSWER or not re.search(r"\d", line):
        return ""
    for mark in re.finditer(_ANSWER_FOLLOWS, line):
        before, rest = line[: mark.start()], line[mark.end() :]
        if re.search(_OF_OTHERS, before):
            return ""
        if unit := re.search(r"[\[(]([^\])]*)[\])][\s*_`$]*$", before):
            before = before[: unit.start()]
        words = re.findall(r"[^\W\d][\w'’]*", before.translate(_PLAIN_WORDS))
        names = (" ".join(words[-count:]) for count in (3, 2, 1) if len(words) >= count)
        name, roles = next(((name, roles) for name in names if (roles := name_roles(name)[0])), ("", ()))
        if roles != ("inertia",):
            continue
        whole = rest.strip(" \t*_`$|")
        if unit and kinds_of(unit[1]) and (plain := quantities.take_apart(whole)) and not plain.unit:
            whole = f"{whole} {unit[1]}"
        for cut in reversed(list(re.finditer(_CUTS, whole))):
            answer = whole[: cut.start()].rstrip(" *`$_")
            if read_reported("inertia", answer).fault is None:
                return answer
        if len(name) > 1 and read_reported("inertia", whole).fault == "no unit":
            return whole
    return ""


def find_in_row(cells: Sequence[str]) -> tuple[int, str] | None:
    """Find I_zz in a row of a table, "I_zz", "4.4e-3 ± 0.1e-3 kg m^2" or both in one cell: where, and the value."""
    for at, cell in enumerate(cells):
        if cell[:1].isalpha():
            alone = "=" in cell or ":" in cell
            if not alone and at == len(cells) - 1:
                break
            if answer := find_inertia(cell if alone else f"{cell}: {' '.join(filter(None, cells[at + 1 :]))}"):
                return at, answer
    return None


def one_inertia(found: list[tuple[str, Reported]]) -> tuple[str, Reported] | None:
    """Take what all places of a report, each named, give for I_zz; two that differ are no answer."""
    # The one that says most of it, where several give one value.
    places = sorted(found, key=lambda one: (one[1].u is None, one[1].fault is not None))
    if not places:
        return None
    place, first = places[0]
    for other, reported in places[1:]:
        if (reported.value, reported.u or first.u) != (first.value, first.u):
            problem = f'two values are found: "{first.text}" in {place} and "{reported.text}" in {other}'
            return place, Reported("inertia", first.text, fault="given twice", problem=problem, line=first.line)
    return place, first
