"""Read a written quantity: number, last digit, ±, unit, power of ten and coverage factor.

Cells, options, ``# key:`` lines, rubrics and reported values are all read here. They
differ in the kind of quantity and in the unit that is used if none is written. The
functions read everything that this tool prints.
"""

from __future__ import annotations

import math
import re
import unicodedata
from fractions import Fraction
from functools import lru_cache

from msgspec import Struct
from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.quantities import units, vocabulary
from gyrodata.quantities.units import Uncertainty, UnitError

LONGEST = 200
"""Characters in a written quantity; a longer text is not one."""
MOST_DIGITS = 7
"""Most digits of a reading, with the zeros before it: 0.02000 kg has six."""
LONG = 600.0
"""A time [s] at least this long that is written as 00:20:13 may be one of 20.13 s."""

_SIZE = r"(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][-+]?[0-9]{1,5})?"
NUMBER = rf"[-+]?{_SIZE}"
PLUS = r"(?<![0-9][eE])(?<![0-9.,]\s[eE])\+"
"""A plus that does not belong to a power of ten."""
PLAIN = re.compile(NUMBER)
"""A number and nothing else."""

# Most cells are plain numbers; the other patterns are compiled when the first other
# text comes (`re` keeps them).
_UNIT = r"(?:1/)?[^\d\s.,;:+±()%\-][^±;%]*?"
_FRACTION = r"[-+]?(?:[0-9]{1,9}\s+)?[0-9]{1,9}\s*/\s*[0-9]{1,9}"
_POWER = r"[eE][-+]?[0-9]{1,3}"
_QUANTITY = (
    rf"(?P<open>\(\s*)?(?P<number>{_FRACTION}|{NUMBER})(?:\((?P<digits>{_SIZE})\)"
    rf"(?P<power>{_POWER})?)?"
    rf"\s*(?P<unit>{_UNIT})?(?:\s*±\s*(?P<spread>{_SIZE})\s*(?P<percent>%)?\s*(?P<last>{_UNIT})?)?"
    rf"(?(open)\s*\)\s*(?P<shared>{_POWER})?\s*(?P<behind>{_UNIT})?)"
)
"""``4.4(1)e-3 g``, ``4.4 g ± 2 %``, ``(4.4 ± 0.1)e-3 g``; `_USUAL` turns other ways of
writing into these."""

_ABOUT = r"(?:about|approximately|approx\.?|circa|ca\.?|roughly|[~≈≃])\s*(?=[-+(\d.,])"
IN_FRONT = rf"(?i)^(?:[^\W\d][\w ]{{0,30}}=\s*)?(?:{_ABOUT})?"
"""A name and "about" in front of a number."""
_SAID = (
    r"(?i)(?<=\S)\s*(?:[,;(]|\bwith\b)\s*(?:(?:with|an?|and|the|its|standard)\s+)*"
    r"(?:u(?:\s*\([^()]*\)|_?[^\W\d]{0,4})|σ|sigma|uncertainty|error|±)"
    rf"\s*(?:=|:|of\b|is\b|±)?\s*(?={NUMBER})"
)
_TIMES_TEN = r"[×x*·⋅∙]\s*10"
_POWER_OF_TEN = (
    rf"(?:(?<!\s)\s+)?(?:{_TIMES_TEN}\s*(?:(?:\^|\*\*)\s*|(?=[-+]))|(?<=[\s)])10\s*(?:\^|\*\*)\s*)"
    r"(?:[({]\s*([-+]?[0-9]{1,3})\s*[)}]|([-+]?[0-9]{1,3}))(?![0-9.,])"
)
_USUAL = (
    (r"(?:(?<=[^\W\d])|(?<=\^\d))\.$", ""),  # the end of a sentence
    (
        r"(?i)(?:(?<!\s)\s+)?\(\s*(?:i\.\s?e\.|=|d\.\s?h\.)[^()]*\)$",
        "",
    ),  # "4.30 ± 0.06 g m^2 (i.e. 0.00430 kg m^2)"
    (r"(?<=\d)\s+[eE](?=[-+]\d)", "e"),  # "4.30 e-3"
    (
        rf"{_SAID}((?:[^()]|\([^()]*\))*)\)?$",
        r" ± \1",
    ),  # "4.4e-3 kg m^2, u = 1e-4" and "4.4e-3 kg m^2 (± 1e-4)"
    # a unit in brackets
    (
        (
            r"(?<=[\d\s)%])[\[(]\s*((?:1/"
            r"|10\s*\^[-+]?\d+\s*[·*×]?\s*)?[^\W\d][^()\[\]±]*?|°[^()\[\]±]*?)\s*[\])]$"
        ),
        r" \1",
    ),
    # "4.4 ± 0.1 × 10^-3" means that power of both.
    (rf"^({NUMBER}\s*±\s*{NUMBER})(?=\s*{_TIMES_TEN}|\s+10\s*(?:\^|\*\*))", r"(\1)"),
    (_POWER_OF_TEN, r"e\1\2"),
)
"""Ways of writing, and the usual way that replaces each."""

_COVERAGE = (
    r"(?i)(?:(?<!\s)\s+)?(?:(?:[(\[,;]\s*)?(?:k\s*=\s*([1-9](?:[.,][0-9]+)?)"
    r"|([1-3])\s?-?(?:σ|sigma|s\.?d\.?))\s*[)\]]?"
    r"|[(\[]\s*([0-9]{2}(?:[.,][0-9]+)?)\s*%\s*+(?:C\.?[IL]\.?|confidence|confidence "
    r"level|coverage)?"
    r"(?:,\s*k\s*=\s*\d)?\s*[)\]])"
)
"""A coverage factor or a level: ``(k = 2)``, ``2σ``, ``(95 %)``."""
_LEVELS = {
    68.0: 1.0,
    68.3: 1.0,
    68.27: 1.0,
    90.0: 1.645,
    95.0: 1.96,
    95.4: 2.0,
    95.45: 2.0,
    99.0: 2.576,
    99.7: 3.0,
}
"""Coverage factors of the levels that are stated in %, for normal errors."""

_MINUS = str.maketrans({"−": "-", "–": "-", "‐": "-", "‑": "-"})
_MISTYPED = str.maketrans(
    {
        "O": "0",
        "o": "0",
        "l": "1",
        "I": "1",
        "|": "1",
        "S": "5",
        "З": "3",
        "О": "0",
        "о": "0",
    }
)
_THOUSANDS = r"[-+]?[1-9][0-9]{0,2},[0-9]{3}"
_SPACED = r"[1-9][0-9]{0,2}(?:[ \u00a0\u202f][0-9]{3})+"
_SEVERAL = r"([1-9][0-9]?)(?:\s*[x×*]|\s+·)(?!\s*10\s*[\^*⁻⁰-⁹-])\s*(.+)"
_CLOCK = r"(?:([0-9]{1,2}):)?([0-9]{1,3}):([0-9]{2}(?:[.,][0-9]+)?)"
_SPOKEN_CLOCK = (
    r"()([0-9]{1,3})\s*(?:'|m|min|мин)\.?\s*([0-9]{1,2}(?:[.,][0-9]+)?)\s*(?:\"|''|s"
    r"|sec|c|сек)?\.?"
)
_PARTS_OF_PI = (
    r"(?i)([0-9]+(?:[.,][0-9]+)?)?\s*+(?:[*·×]\s*)?(?:pi|π)\s*+"
    r"(?:/\s*([1-9][0-9]?)\s*)?(?:rad)?"
)
"""Angles such as "2pi/3"."""
_CCW, _CW = (
    ("ccw", "counterclockwise", "anticlockwise", "+", "+1", "1"),
    ("cw", "clockwise", "-1"),
)

_MONTHS = {
    word: int(number)
    for number, words in vocabulary.MONTHS.items()
    for word in words.split()
}
_DATES = (
    r"(?P<day>[0-9]{1,4})[.\s-]*(?P<month>[^\W\d_]{3,9})\.?(?:[\s-]*[0-9]{2,4})?",
    r"(?P<month>[^\W\d_]{3,9})\.?[\s-]*(?P<day>[0-9]{1,4})",
    r"[0-9]{4}[./-](?P<month>[0-9]{1,2})[./-](?P<day>[0-9]{1,2})(?:[ T]00:00:00)?",
    r"(?P<day>[0-9]{1,2})([./-])(?P<month>[0-9]{1,2})\2(?:19|20)[0-9]{2}",
)
_DATE_DIGITS = r"[0-9]{1,4}[./-][0-9]{1,2}[./-][0-9]{1,4}(?:[ T].*)?"
_TWO = rf"{NUMBER}\s*(?:-|–|—|->|→|to|bis|à|a|до)\s*{NUMBER}\s*\S*"


class Written(Struct, frozen=True):
    """The parts of a written quantity, before its unit is read."""

    number: str
    """Text of the number, its power of ten in it: ``4.441e-3``, ``1/3``."""
    value: float
    """The number; infinite if it is too large or divides by zero."""
    step: float | None
    """One step of its last digit; None for a fraction."""
    unit: str | None = None
    """In folded letters; None if there is none."""
    spread: str | None = None
    """Text behind ±, or in the bracket; None if there is none."""
    spread_unit: str | None = None
    """Its own unit, if it has one; "%" of the number."""
    coverage: float = 1.0
    """Divisor that makes it a standard uncertainty."""


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


def fold_number(text: str) -> str:
    """Replace real minus signs, ½ and wide digits by their ASCII forms; 10⁻³ becomes 10^-3."""
    if text.isascii():
        return text.strip()
    text = re.sub(
        r"(?<=[0-9])([⁺⁻]?[⁰¹²³⁴-⁹]+)",
        lambda match: "^" + unicodedata.normalize("NFKC", match[1]),
        text,
    )
    text = re.sub("[¼-¾⅐-⅞]", r" \g<0>", text)
    return units.fold_letters(text).translate(_MINUS).strip()


def to_float(number: str) -> float:
    """Read a number with either decimal sign."""
    return float(number.replace(",", "."))


def last_place(number: str) -> int:
    """Return the power of ten of the last digit typed."""
    mantissa, _, exponent = number.lower().replace(",", ".").partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2])


def as_read(value: float, step: float) -> str:
    """Write a reading with the digits that it was read to: 15 in steps of 0.1 is "15.0".

    Four if `step` is 0.
    """
    text = f"{value:.{max(0, -math.floor(math.log10(step) + 1e-6))}f}" if step else ""
    # More digits than an instrument has come from arithmetic.
    return text if 0 < sum(map(str.isdigit, text)) <= MOST_DIGITS else f"{value:.4g}"


@lru_cache(maxsize=4096)
def take_apart(text: str) -> Written | None:
    """Split a written quantity into its number, its unit and its uncertainty.

    The function reads ``4.4e-3 kg m^2``, ``4.4×10⁻³ kg·m²``, ``4.4(1)e-3 kg m^2``,
    ``4.4e-3 ± 2 % kg m^2``, ``(4.4 ± 0.1) × 10⁻³ kg·m²``, ``4.4 ± 0.2 g (k = 2)``, ``76
    g`` and ``1/3``; it returns None for other texts.
    """
    if len(text) > LONGEST:
        return None
    plain = fold_number(text)
    if PLAIN.fullmatch(plain):
        return Written(plain, to_float(plain), float(f"1e{last_place(plain)}"))
    # Of many blanks in a row two are left: the patterns would try all ways to split
    # them.
    plain = re.sub(r"\+\s?/\s?-|\+-|\\pm", "±", re.sub(r"\s{3,}", "  ", plain))
    bare, coverage = _without_coverage(plain)
    for way, usual in _USUAL:
        bare = re.sub(way, usual, bare)
    match = re.fullmatch(_QUANTITY, bare)
    if match is None:
        return None
    number, digits, spread = match["number"], match["digits"], match["spread"]
    unit, last, behind = match["unit"], match["last"], match["behind"]
    percent, power = (
        match["percent"] is not None,
        match["power"] or match["shared"] or "",
    )
    two_units = (behind and (unit or last)) or (
        percent and unit and last and unit != last
    )
    two_powers = power and re.search("[/eE]", number + (digits or spread or ""))
    if two_units or two_powers or (digits and spread) or (match["open"] and not spread):
        return None
    number += power
    if digits:
        # A whole number in the bracket counts in the last digits.
        spread = (
            f"{digits}e{last_place(number)}" if digits.isdigit() else digits + power
        )
    elif spread and not percent:
        spread += power
        if (
            re.fullmatch(_THOUSANDS, number)
            and not (unit and last)
            and to_float(spread) > to_float(number)
        ):
            number = number.replace(",", "")  # "46,300 ± 600"
    spread_unit = last if unit else None
    if percent:
        spread_unit = "%"
    unit = unit or last or behind
    if "/" not in number:
        value, step = to_float(number), float(f"1e{last_place(number)}")
        return Written(number, value, step, unit, spread, spread_unit, coverage)
    try:
        parts = "/".join(map(str.strip, number.lstrip("+-").split("/")))
        value = float(sum(map(Fraction, parts.split())))
    except ZeroDivisionError:
        value = math.inf
    return Written(
        number,
        -value if number[0] == "-" else value,
        None,
        unit,
        spread,
        spread_unit,
        coverage,
    )


def _without_coverage(text: str) -> tuple[str, float]:
    """Remove ``(k = 2)`` or ``(95 %)``, and return the coverage factor."""
    match = re.search(_COVERAGE, text)
    number = (
        to_float(match[match.lastindex or 0])
        if match and ("±" in text or match[1])
        else 0.0
    )
    factor = _LEVELS.get(number, number if number < 10 else 0.0)
    return (
        (f"{text[: match.start()]} {text[match.end() :]}".strip(), factor)
        if match and factor
        else (text, 1.0)
    )


def in_si(written: Written, kind: str, unit: str | None = None) -> Quantity:
    """Convert a quantity to SI; `unit` is used if none is written."""
    own = written.unit or unit or ""
    known, uncertainty, u_step = units.parse_unit(own, kind), None, None
    u = to_float(written.spread or "0") / written.coverage
    if written.spread_unit == "%":
        uncertainty = Uncertainty(0.0, u / 100)
    elif written.spread is not None:
        factor = units.parse_unit(written.spread_unit or own, kind).factor
        uncertainty, u_step = (
            Uncertainty(u * factor),
            10.0 ** last_place(written.spread) * factor,
        )
    step = None if written.step is None else written.step * known.factor
    return Quantity(written.value * known.factor, step, uncertainty, known.text, u_step)


@lru_cache(maxsize=16384)
def read_cell(text: str, kind: str, unit: str | None, ask: bool = False) -> Quantity:
    """Read a quantity of one kind: a cell, an option, or a value of a line.

    Parameters
    ----------
    text : str
        As typed, not blank.
    kind : str
        Kind of quantity, a key of `gyrodata.quantities.units.KINDS`.
    unit : str or None
        Unit that is used if the text has none.
    ask : bool
        Whether a comma that may separate thousands is an error.

    Raises
    ------
    UnitError
        The text cannot be read.
    """
    plain = fold_number(text)
    if kind == "sign":
        sense = plain.lower().replace(" ", "").replace("-c", "c")
        if sense not in _CCW + _CW:
            raise _fault(
                "is not a sense of rotation", "write ccw (or +1) or cw (or -1)"
            )
        return Quantity(1.0 if sense in _CCW else -1.0, None, None, "")
    if kind in ("mass", "force", "length") and (
        several := re.fullmatch(_SEVERAL, text)
    ):
        one, count = read_cell(several[2], kind, unit, ask), int(several[1])
        u = one.uncertainty and Uncertainty(
            count * one.uncertainty.absolute, one.uncertainty.relative
        )
        return Quantity(count * one.value, one.step and count * one.step, u, one.unit)
    parts = re.split(PLUS, text)
    if (
        kind == "mass"
        and parts[1:]
        and all(re.match(r"\s*\d", part) for part in parts)
        and "/" not in text
    ):
        # "20 + 30 g": two weights
        last = read_cell(parts[-1].strip(), kind, unit, ask)
        others = [read_cell(part.strip(), kind, last.unit, ask) for part in parts[:-1]]
        return replace(last, value=last.value + math.fsum(one.value for one in others))
    if (
        kind == "angle"
        and unit in (None, "rad")
        and (part := re.fullmatch(_PARTS_OF_PI, plain))
    ):
        return Quantity(
            math.pi * to_float(part[1] or "1") / int(part[2] or 1), None, None, "rad"
        )
    if kind == "number" and plain[-1:] == "%" and PLAIN.fullmatch(plain[:-1].strip()):
        whole = read_cell(plain[:-1].strip(), kind, unit, ask)  # 25 % of a turn
        return replace(
            whole, value=whole.value / 100, step=whole.step and whole.step / 100
        )
    if kind == "time" and '"' in text:
        text = plain = re.sub(
            r"^([0-9'’]+)\"([0-9]{1,2})$", r"\1.\2 s", plain
        )  # 1'42"74 and 21"48
    spoken = re.fullmatch(_SPOKEN_CLOCK, plain.lower()) if kind == "time" else None
    if clock := spoken or re.fullmatch(_CLOCK, plain):
        return _read_clock(clock, kind, unit)
    # "1 198 rpm" below such a header
    joined = (
        "".join(text.split())
        if kind != "number" and re.fullmatch(_SPACED, text)
        else text
    )
    written = take_apart(joined)
    if written is None or (written.unit or "").translate(_MISTYPED).isdigit():
        raise _not_a_number(text, kind, _fault("is not a number", how_to_write(kind)))
    for number in (written.number, written.spread or "0"):
        size = written.value if "/" in number else to_float(number)
        if math.isinf(size) or (
            size == 0 and re.search("[1-9]", re.split("[eE/]", number)[0])
        ):
            fault = (
                "divides by zero"
                if "/" in number
                else "is too large or too small for a number"
            )
            raise _fault(fault, "write the value as it was read")
    if kind != "number" and re.fullmatch(r"[0-9]{2,}\s*/\s*[0-9]{2,}", written.number):
        raise _fault(*_TWO_NUMBERS)
    own, (low, high) = written.unit or unit, units.LIMITS[kind]
    if own is None and kind != "number":
        raise UnitError(
            "has no unit",
            f"write one behind it: {units.KINDS[kind].examples}",
            diagnostics.UNIT_MISSING,
        )
    try:
        quantity = in_si(written, kind, unit)
    except UnitError as error:
        told = UnitError(f"cannot be read: {error}", error.hint, error.code)
        raise (
            told if units.kinds_of(own or "") else _not_a_number(text, kind, told)
        ) from None
    if ask and "," in written.number:
        # A power of ten, another number with a decimal comma, or an impossible size
        # shows how the comma is meant.
        commas = [
            number for number in (written.number, written.spread or "") if "," in number
        ]
        both = all(
            low <= abs(size) <= high for size in (quantity.value, 1000 * quantity.value)
        )
        if both and all(re.fullmatch(_THOUSANDS, number) for number in commas):
            thousands, decimals = (
                written.number.replace(",", sign) for sign in ("", ".")
            )
            hint = (
                f"write {thousands} or {decimals}0 (one more zero shows that the sign "
                f"is decimal)"
            )
            raise _fault(f"can mean {thousands} or {decimals}", hint)
    if quantity.uncertainty is not None and quantity.uncertainty.absolute > high:
        raise _fault(
            "has an uncertainty that is far too large", "is its unit the one written?"
        )
    return (
        replace(quantity, step=None)
        if quantity.value == 0 and set(text) <= set("+-−0")
        else quantity
    )


_TWO_NUMBERS = (
    "is not one number, but looks like two readings",
    (
        "write their mean; or write them in two columns, such as spin_start [rpm] and "
        "spin_end [rpm], or in two rows"
    ),
)


def _fault(
    message: str, hint: str, code: str = diagnostics.CELL_IS_NO_NUMBER
) -> UnitError:
    return UnitError(message, hint, code)


def _read_clock(clock: re.Match[str], kind: str, unit: str | None) -> Quantity:
    if kind != "time" or unit not in (None, "s", "min"):
        raise _fault(
            "is a clock time, not a number",
            "write the column's unit as s" if kind == "time" else "",
        )
    hours, minutes, seconds = clock.groups()
    late = to_float(seconds)
    if late >= 60 or (hours and int(minutes) >= 60):
        short = (
            ""
            if hours or not seconds.isdigit()
            else f"{minutes}.{seconds} for seconds and hundredths, "
        )
        message = "is not a clock time: its seconds or minutes are above 59"
        raise _fault(message, f"write {short}mm:ss.cc for minutes")
    value = int(hours or 0) * 3600 + int(minutes) * 60 + late
    if hours and len(hours) == 2 and seconds.isdigit() and value >= LONG:
        short, long = (
            f"{hours}:{minutes}.{seconds}",
            f"{int(hours) * 60 + int(minutes)}:{seconds}",
        )
        hint = (
            f"write {short} for minutes, seconds and hundredths; or {long} for minutes "
            f"and seconds"
        )
        raise _fault("can be h:mm:ss or mm:ss:hundredths", hint)
    return Quantity(value, float(f"1e{last_place(seconds)}"), None, "s")


def _not_a_number(text: str, kind: str, otherwise: UnitError) -> UnitError:
    """Return an error that says what a text looks like, and what was probably meant.

    Else `otherwise`.
    """
    plain = fold_number(text)
    if kind == "rate" and re.fullmatch(_TWO, plain):
        return _fault(*_TWO_NUMBERS)
    for case in vocabulary.NO_NUMBER:
        if match := re.fullmatch(case["pattern"], plain, re.IGNORECASE):
            return _fault(case["message"], match.expand(case["hint"]))
    pair = date_pair(text)
    if pair or re.fullmatch(_DATE_DIGITS, text):
        # If the comma is the decimal sign, 20.1 becomes the 20th of January.
        meant = ""
        if pair and kind == "number":
            meant = f"{min(pair)}/{max(pair)}"
        elif pair:
            meant = "{}.{}".format(*pair)
        hint = (
            f"did you mean {meant}? " if meant else "write the number that was read. "
        )
        hint += "A spreadsheet makes dates of such numbers: make the cells text first"
        return _fault("is a date, not a number", hint, diagnostics.CELL_BECAME_A_DATE)
    mended = re.sub(
        r"([.,])[.,]+", r"\1", re.sub(IN_FRONT, "", plain).translate(_MISTYPED)
    ).rstrip(".,;")
    bare = take_apart(mended) if mended != plain else None
    if bare and bare.unit is None and bare.spread is None:
        return _fault("is not a number", f"did you mean {mended}?")
    return otherwise


def date_pair(text: str) -> tuple[int, int] | None:
    """Return day and month of a date, in either order; None if a text is not a date."""
    for date in _DATES:
        if match := re.fullmatch(date, text):
            word = match["month"].lower()
            month = (
                int(word)
                if word.isdigit()
                else _MONTHS.get(word) or _MONTHS.get(word[:4]) or _MONTHS.get(word[:3])
            )
            return (int(match["day"]), month) if month is not None else None
    return None


def how_to_write(kind: str) -> str:
    """Return how a number of a kind is written, without a number that could be copied."""
    known = units.KINDS[kind]
    return (
        f"write a number with its unit: {known.examples}"
        if known.si
        else "write the number alone"
    )


def parse_quantity(text: str, kind: str) -> float:
    """Read one number with its unit.

    Examples are ``60 g``, ``200 rpm``, ``(4.44 ± 0.06) × 10⁻³ kg·m²`` and ``1/3``.
    """
    try:
        return read_cell(text.strip(), kind, None, ask=True).value
    except UnitError as error:
        raise UnitError(
            f'"{text.strip()[:40]}" {error}',
            error.hint or how_to_write(kind),
            error.code,
        ) from None


@lru_cache(maxsize=512)
def parse_uncertainty(
    text: str, kind: str, unit: str = "", ask: bool = True
) -> Uncertainty:
    """Read a standard uncertainty: ``0.5 mm``, ``0.2 %``, or a sum of both, ``0.2 % + 0.5 rpm``.

    The function divides by a coverage factor behind it, as in ``1 mm (k = 2)``; a term
    without a unit has `unit`.
    """
    absolute = relative = 0.0
    share = f'{how_to_write(kind)}, or a share of the value: "1 %"'
    whole, coverage = _without_coverage(f"± {text.strip().lstrip('±+ ')}")
    for term in re.split(r"(?<![eE^])\+", whole[1:].strip()):
        percent = term.rstrip().endswith("%")
        try:
            quantity = read_cell(
                term.strip("% "),
                "number" if percent else kind,
                "" if percent else unit or None,
                ask,
            )
        except UnitError as error:
            hint = (
                share
                if (str(error), error.hint) == ("is not a number", how_to_write(kind))
                else error.hint
            )
            raise UnitError(
                f'"{term.strip()[:40]}" {error}', hint, error.code
            ) from None
        if quantity.uncertainty is not None or quantity.value < 0:
            raise UnitError(f'"{text.strip()[:40]}" is not an uncertainty', share)
        relative += quantity.value / 100 / coverage if percent else 0.0
        absolute += 0.0 if percent else quantity.value / coverage
    if relative > 10 or absolute > units.LIMITS[kind][1]:
        raise UnitError(
            f'"{text.strip()[:40]}" is far too large for an uncertainty',
            "is its unit the one written?",
        )
    return Uncertainty(absolute, relative)
