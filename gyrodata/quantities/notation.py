"""Read a written quantity of one kind, and convert it to SI.

Cells, options, ``# key:`` lines, rubrics and reported values are all read here. They
differ in the kind of quantity and in the unit that is used if none is written.
"""

from __future__ import annotations

import math
import re
from functools import lru_cache

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.quantities import misreadings, units
from gyrodata.quantities.misreadings import fault
from gyrodata.quantities.numerals import (
    NUMBER,
    PLAIN,
    PLUS,
    Written,
    fold_number,
    last_place,
    may_have_thousands,
    take_apart,
    to_float,
    without_coverage,
)
from gyrodata.quantities.units import Uncertainty, UnitError

LONG = 600.0
"""A time [s] at least this long that is written as 00:20:13 may be one of 20.13 s."""

_ORDINARY = re.compile(
    rf"(?:[0-9]+/[0-9]+|{NUMBER})(?:\s*±\s*{NUMBER})?\s*"
    r"(?:(?!(?i:pi)|π)[^\W\d]+(?:/[^\W\d]+(?:\^?2)?)?)?"
)
"""A number or fraction, perhaps with ±, and a unit such as ``m/s^2``."""
_SEVERAL = r"([1-9][0-9]?)(?:\s*[x×*]|\s+·)(?!\s*10\s*[\^*⁻⁰-⁹-])\s*(.+)"
_CLOCK = r"(?:([0-9]{1,2}):)?([0-9]{1,3}):([0-9]{2}(?:[.,][0-9]+)?)"
_SECONDS = ("", "s", "sec", "c", '"', "''")
"""Words behind the seconds of "1 min 42.74 s"."""
_COUNTERCLOCKWISE = ("ccw", "counterclockwise", "anticlockwise", "+", "+1", "1")
_CLOCKWISE = ("cw", "clockwise", "-1")


class Quantity(Struct, frozen=True):
    """A written quantity in SI."""

    value: float
    """[SI unit of its kind]"""
    step: float | None
    """One step of the last digit typed [SI unit of its kind]; None for a fraction."""
    uncertainty: Uncertainty | None
    """Standard uncertainty, if one is written."""
    unit: str
    """Unit that was used, in a spelling that is read back."""
    u_step: float | None = None
    """One step of the last digit of the uncertainty [SI unit of its kind]; None if it
    is in %."""


@lru_cache(maxsize=16384)
def read_cell(
    text: str, kind: str, unit: str | None, doubt_comma: bool = False
) -> Quantity:
    """Read a quantity of one kind: a cell, an option, or a value of a line.

    Parameters
    ----------
    text : str
        As typed, not blank.
    kind : str
        Kind of quantity, a key of `gyrodata.quantities.units.KINDS`.
    unit : str or None
        Unit that is used if the text has none.
    doubt_comma : bool
        Whether "1,234" is an error, because its comma may separate thousands; else it
        is 1.234.

    Raises
    ------
    UnitError
        The text cannot be read.
    """
    plain = fold_number(text)
    if kind == "sign":
        return _read_sense(plain)
    if not _ORDINARY.fullmatch(plain):
        special = _read_special(text, plain, kind, unit, doubt_comma)
        if special is not None:
            return special
    written = _take_cell_apart(text, kind)
    quantity = _convert(written, text, kind, unit)
    if doubt_comma and "," in written.number:
        _insist_on_decimal_comma(written, quantity, kind)
    u = quantity.uncertainty
    if u is not None and u.absolute > units.LIMITS[kind][1]:
        raise fault(
            "has an uncertainty that is far too large", "is its unit the one written?"
        )
    if quantity.value == 0 and set(text) <= set("+-−0"):
        # "0" states nothing about the last digit that was read.
        return replace(quantity, step=None)
    return quantity


def _read_special(
    text: str, plain: str, kind: str, unit: str | None, doubt_comma: bool
) -> Quantity | None:
    """Read a way of writing that only some kinds have; None for other texts.

    "3 x 20 g" is a mass, a force or a length, "20 + 30 g" a mass, "2π/3" an angle, "33
    %" a part of a turn, and "1:42.74" a time.
    """
    quantity = None
    if kind in ("mass", "force", "length"):
        quantity = _read_several(text, kind, unit, doubt_comma)
    if quantity is None and kind == "mass":
        quantity = _read_sum(text, unit, doubt_comma)
    if kind == "angle" and unit in (None, "rad"):
        quantity = _read_part_of_pi(plain)
    if kind == "number" and plain.endswith("%"):
        quantity = _read_percent(plain[:-1].strip(), unit, doubt_comma)
    return quantity or _read_clock(plain, kind, unit)


def _read_sense(plain: str) -> Quantity:
    """Read a sense of rotation: +1 is counterclockwise, -1 clockwise."""
    sense = plain.lower().replace(" ", "").replace("-c", "c")
    if sense in _COUNTERCLOCKWISE:
        return Quantity(1.0, None, None, "")
    if sense in _CLOCKWISE:
        return Quantity(-1.0, None, None, "")
    raise fault("is not a sense of rotation", "write ccw (or +1) or cw (or -1)")


def _read_several(
    text: str, kind: str, unit: str | None, doubt_comma: bool
) -> Quantity | None:
    """Read equal weights, forces or lengths: "3 x 20 g"."""
    match = re.fullmatch(_SEVERAL, text)
    if match is None:
        return None
    count = int(match[1])
    single = read_cell(match[2], kind, unit, doubt_comma)
    step = None if single.step is None else count * single.step
    u = single.uncertainty
    if u is not None:
        u = Uncertainty(count * u.absolute, u.relative)
    return Quantity(count * single.value, step, u, single.unit)


def _read_sum(text: str, unit: str | None, doubt_comma: bool) -> Quantity | None:
    """Read the sum of several weights: "20 + 30 g"."""
    parts = [part.strip() for part in PLUS.split(text)]
    if len(parts) < 2 or "/" in text:
        return None
    if not all(part[:1].isdecimal() for part in parts):
        return None
    last = read_cell(parts[-1], "mass", unit, doubt_comma)
    others = [read_cell(part, "mass", last.unit, doubt_comma) for part in parts[:-1]]
    total = math.fsum(other.value for other in others)
    return replace(last, value=last.value + total)


def _read_part_of_pi(plain: str) -> Quantity | None:
    """Read an angle such as "2π/3" or "1.5 pi rad"."""
    text = plain.lower().replace("pi", "π").removesuffix("rad")
    count, sign, rest = text.partition("π")
    number = count.strip(" *·×") or "1"
    before, slash, divisor = (rest.strip() or "/1").partition("/")
    is_angle = sign and slash and not before and PLAIN.fullmatch(number)
    if not is_angle or not divisor.strip(" 0").isdecimal():
        return None
    return Quantity(math.pi * to_float(number) / int(divisor), None, None, "rad")


def _read_percent(number: str, unit: str | None, doubt_comma: bool) -> Quantity | None:
    """Read a part of a turn in percent."""
    if not PLAIN.fullmatch(number):
        return None
    whole = read_cell(number, "number", unit, doubt_comma)
    step = None if whole.step is None else whole.step / 100
    return replace(whole, value=whole.value / 100, step=step)


def _read_clock(plain: str, kind: str, unit: str | None) -> Quantity | None:
    """Read a clock time, such as "1:42.74" or "1 min 42.74 s"; None for other texts."""
    clock = re.fullmatch(_CLOCK, _as_clock(plain) if kind == "time" else plain)
    if clock is None:
        return None
    if kind != "time":
        raise fault("is a clock time, not a number", "")
    if unit not in (None, "s", "min"):
        raise fault("is a clock time, not a number", "write the column's unit as s")
    hours, minutes, seconds = clock.groups(default="")
    _insist_on_sixty(hours, minutes, seconds)
    whole_minutes = 60 * int(hours or 0) + int(minutes)
    value = 60 * whole_minutes + to_float(seconds)
    if value >= LONG:
        _insist_on_one_meaning(hours, minutes, seconds)
    return Quantity(value, float(f"1e{last_place(seconds)}"), None, "s")


def _as_clock(plain: str) -> str:
    """Return "1:42.74" for "1 min 42.74 s" and 1'42"74; other texts are unchanged."""
    for word in ("min", "m", "'"):
        minutes, _, rest = plain.lower().partition(word)
        seconds = rest.lstrip(". ")
        number = seconds.rstrip(" .\"'sec")
        unit = seconds.removeprefix(number).strip(" .")
        if minutes.strip().isdecimal() and number and unit in _SECONDS:
            # A clock shows 5 s as 05.
            zero = "" if number[1:2].isdecimal() else "0"
            decimal = number.replace('"', ".")
            return f"{minutes.strip()}:{zero}{decimal}"
    return plain


def _insist_on_sixty(hours: str, minutes: str, seconds: str) -> None:
    """Raise an error if a clock time has more than 59 seconds or minutes: "1:75"."""
    has_minutes = not hours or int(minutes) < 60
    if to_float(seconds) < 60 and has_minutes:
        return
    short = ""
    if not hours and seconds.isdigit():
        short = f"{minutes}.{seconds} for seconds and hundredths, "
    raise fault(
        "is not a clock time: its seconds or minutes are above 59",
        f"write {short}mm:ss.cc for minutes",
    )


def _insist_on_one_meaning(hours: str, minutes: str, seconds: str) -> None:
    """Raise an error if a clock time can end with seconds or hundredths: "00:20:13"."""
    if len(hours) != 2 or not seconds.isdigit():
        return
    short = f"{hours}:{minutes}.{seconds}"
    long = f"{int(hours) * 60 + int(minutes)}:{seconds}"
    raise fault(
        "can be h:mm:ss or mm:ss:hundredths",
        f"write {short} for minutes, seconds and hundredths; or {long} for minutes and "
        f"seconds",
    )


def _take_cell_apart(text: str, kind: str) -> Written:
    """Split the text of a cell; its numbers can be stored."""
    is_grouped = kind != "number" and _is_in_groups(text.split())
    written = take_apart("".join(text.split()) if is_grouped else text)
    if written is None or misreadings.is_mistyped_number(written.unit or ""):
        otherwise = fault("is not a number", how_to_write(kind))
        raise misreadings.explain(text, kind, otherwise)
    _insist_on_size(written.number, written.value)
    if written.spread:
        _insist_on_size(written.spread, to_float(written.spread))
    if kind != "number" and _are_two_readings(written.number):
        otherwise = fault("is not one number", how_to_write(kind))
        raise misreadings.explain(text, kind, otherwise)
    return written


def _are_two_readings(number: str) -> bool:
    """Return whether a fraction has two digits above and below: "206/198"."""
    parts = list(map(str.strip, number.split("/")))
    lengths = [len(part) for part in parts if part.isdecimal()]
    return len(lengths) == 2 and min(lengths) > 1


def _is_in_groups(parts: list[str]) -> bool:
    """Return whether a number is written as "1 198", below a header with a unit."""
    if len(parts) < 2 or not "".join(parts).isdecimal():
        return False
    first, *others = parts
    return first[0] != "0" and len(first) <= 3 and set(map(len, others)) == {3}


def _insist_on_size(number: str, value: float) -> None:
    """Raise an error if a number divides by zero, or is too large or too small."""
    mantissa, _, _ = number.lower().replace("/", "e").partition("e")
    underflows = value == 0 and mantissa.strip("+-0., ") != ""
    if not math.isinf(value) and not underflows:
        return
    words = "is too large or too small for a number"
    if "/" in number:
        words = "divides by zero"
    raise fault(words, "write the value as it was read")


def _convert(written: Written, text: str, kind: str, unit: str | None) -> Quantity:
    """Convert a quantity to SI; its unit must be known, and of its kind."""
    own = written.unit or unit
    if own is None and kind != "number":
        raise UnitError(
            "has no unit",
            f"write one behind it: {units.KINDS[kind].examples}",
            diagnostics.UNIT_MISSING,
        )
    try:
        return in_si(written, kind, unit)
    except UnitError as error:
        unreadable = UnitError(f"cannot be read: {error}", error.hint, error.code)
        if not units.kinds_of(own or ""):
            unreadable = misreadings.explain(text, kind, unreadable)
        raise unreadable from None


def in_si(written: Written, kind: str, unit: str | None = None) -> Quantity:
    """Convert a quantity to SI; `unit` is used if none is written."""
    own = written.unit or unit or ""
    known = units.parse_unit(own, kind)
    step = None if written.step is None else written.step * known.factor
    value = written.value * known.factor
    if written.spread is None:
        return Quantity(value, step, None, known.text)
    u = to_float(written.spread) / written.coverage
    if written.spread_unit == "%":
        return Quantity(value, step, Uncertainty(0.0, u / 100), known.text)
    factor = units.parse_unit(written.spread_unit or own, kind).factor
    u_step = 10.0 ** last_place(written.spread) * factor
    return Quantity(value, step, Uncertainty(u * factor), known.text, u_step)


def _insist_on_decimal_comma(written: Written, quantity: Quantity, kind: str) -> None:
    """Raise an error if a comma can separate thousands.

    A power of ten, another number with a decimal comma, or an impossible size shows how
    the comma is meant.
    """
    low, high = units.LIMITS[kind]
    if not low <= abs(quantity.value) <= high:
        return
    if not low <= abs(1000 * quantity.value) <= high:
        return
    for number in (written.number, written.spread or ""):
        if "," in number and not may_have_thousands(number):
            return
    thousands = written.number.replace(",", "")
    decimals = written.number.replace(",", ".")
    raise fault(
        f"can mean {thousands} or {decimals}",
        f"write {thousands} or {decimals}0 (one more zero shows that the sign is "
        f"decimal)",
    )


def how_to_write(kind: str) -> str:
    """Return how a number of a kind is written, with no number to copy."""
    known = units.KINDS[kind]
    if not known.si:
        return "write the number alone"
    return f"write a number with its unit: {known.examples}"


def parse_quantity(text: str, kind: str) -> float:
    """Read one number with its unit.

    Examples are ``60 g``, ``200 rpm``, ``(4.44 ± 0.06) × 10⁻³ kg·m²`` and ``1/3``.
    """
    try:
        return read_cell(text.strip(), kind, None, doubt_comma=True).value
    except UnitError as error:
        hint = error.hint or how_to_write(kind)
        raise UnitError(f'"{text.strip()[:40]}" {error}', hint, error.code) from None


@lru_cache(maxsize=512)
def parse_uncertainty(
    text: str, kind: str, unit: str = "", doubt_comma: bool = True
) -> Uncertainty:
    """Read a standard uncertainty: ``0.5 mm``, ``0.2 %``, or ``0.2 % + 0.5 rpm``.

    The function divides by a coverage factor behind it, as in ``1 mm (k = 2)``; a term
    without a unit has `unit`.
    """
    shown = f'"{text.strip()[:40]}"'
    absolute = relative = 0.0
    stated = text.strip().lstrip("±+ ")
    terms, coverage = without_coverage(stated, has_uncertainty=True)
    for term in PLUS.split(terms):
        u = _parse_term(term, kind, unit, doubt_comma)
        if u is None:
            raise UnitError(f"{shown} is not an uncertainty", _share_of_value(kind))
        absolute += u.absolute / coverage
        relative += u.relative / coverage
    if relative > 10 or absolute > units.LIMITS[kind][1]:
        raise UnitError(
            f"{shown} is far too large for an uncertainty",
            "is its unit the one written?",
        )
    return Uncertainty(absolute, relative)


def _parse_term(
    term: str, kind: str, unit: str, doubt_comma: bool
) -> Uncertainty | None:
    """Read one term of an uncertainty; None if it is negative or has a ± itself."""
    percent = term.rstrip().endswith("%")
    number = term.strip("% ")
    try:
        if percent:
            quantity = read_cell(number, "number", "", doubt_comma)
        else:
            quantity = read_cell(number, kind, unit or None, doubt_comma)
    except UnitError as error:
        hint = error.hint
        if str(error) == "is not a number" and hint == how_to_write(kind):
            hint = _share_of_value(kind)
        raise UnitError(f'"{term.strip()[:40]}" {error}', hint, error.code) from None
    if quantity.uncertainty is not None or quantity.value < 0:
        return None
    if percent:
        return Uncertainty(0.0, quantity.value / 100)
    return Uncertainty(quantity.value)


def _share_of_value(kind: str) -> str:
    return f'{how_to_write(kind)}, or a share of the value: "1 %"'
