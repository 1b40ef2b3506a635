"""Split a written quantity: number, last digit, ±, unit, power of ten, coverage factor.

A text goes in, and its parts come out as texts and numbers. Units are not read here,
and nothing is converted. The functions read everything that this tool prints.
"""

from __future__ import annotations

import math
import re
from fractions import Fraction
from functools import lru_cache

from msgspec import Struct

from gyrodata.quantities import units

LONGEST = 200
"""Characters in a written quantity; a longer text is not one."""
MOST_DIGITS = 7
"""Most digits of a reading, with the zeros before it: 0.02000 kg has six."""

_SIZE = r"(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][-+]?[0-9]{1,5})?"
NUMBER = rf"[-+]?{_SIZE}"
PLUS = re.compile(r"(?<![0-9][eE])(?<![0-9.,]\s[eE])(?<!\^)\+")
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
    rf"\s*(?P<unit>{_UNIT})?"
    rf"(?:\s*±\s*(?P<spread>{_SIZE})\s*(?P<percent>%)?\s*(?P<last>{_UNIT})?)?"
    rf"(?(open)\s*\)\s*(?P<shared>{_POWER})?\s*(?P<behind>{_UNIT})?)"
)
"""``4.4(1)e-3 g``, ``4.4 g ± 2 %``, ``(4.4 ± 0.1)e-3 g``; `_USUAL` turns other ways of
writing into these."""

_ABOUT = r"(?:about|approximately|approx\.?|circa|ca\.?|roughly|[~≈≃])\s*(?=[-+(\d.,])"
_IN_FRONT = rf"(?i)^(?:[^\W\d][\w ]{{0,30}}=\s*)?(?:{_ABOUT})?"
"""A name and "about" in front of a number."""
_STATED_U = (
    r"(?i)(?<=\S)\s*(?:[,;(]|\bwith\b)\s*(?:(?:with|an?|and|the|its|standard)\s+)*"
    r"(?:u(?:\s*\([^()]*\)|_?[^\W\d]{0,4})|σ|sigma|uncertainty|error|±)"
    rf"\s*(?:=|:|of\b|is\b|±)?\s*(?={NUMBER})"
)
_TIMES_TEN = r"[×x*·⋅∙]\s*10"
_POWER_OF_TEN = (
    rf"(?:(?<!\s)\s+)?"
    rf"(?:{_TIMES_TEN}\s*(?:(?:\^|\*\*)\s*|(?=[-+]))|(?<=[\s)])10\s*(?:\^|\*\*)\s*)"
    r"(?:[({]\s*([-+]?[0-9]{1,3})\s*[)}]|([-+]?[0-9]{1,3}))(?![0-9.,])"
)
_USUAL = (
    # the end of a sentence
    (r"(?:(?<=[^\W\d])|(?<=\^\d))\.$", ""),
    # "4.30 ± 0.06 g m^2 (i.e. 0.00430 kg m^2)"
    (r"(?i)(?:(?<!\s)\s+)?\(\s*(?:i\.\s?e\.|=|d\.\s?h\.)[^()]*\)$", ""),
    # "4.3 e-3"
    (r"(?<=\d)\s+[eE](?=[-+]\d)", "e"),
    # "4.4e-3 kg m^2, u = 1e-4" and "4.4e-3 kg m^2 (± 1e-4)"
    (rf"{_STATED_U}((?:[^()]|\([^()]*\))*)\)?$", r" ± \1"),
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
_POWERS = frozenset("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_FRACTIONS = frozenset("¼½¾⅐⅑⅒⅓⅔⅕⅖⅗⅘⅙⅚⅛⅜⅝⅞")
_SIGNS_OF_SPREAD = ("+/-", "+ / -", "+ /-", "+/ -", "+-", r"\pm")


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


def fold_number(text: str) -> str:
    """Replace real minus signs, ½ and wide digits by their ASCII forms.

    10⁻³ becomes 10^-3.
    """
    if text.isascii():
        return text.strip()
    spaced = ""
    for letter in text:
        if letter in _POWERS and spaced[-1:].isdecimal():
            spaced += "^"
        elif letter in _FRACTIONS:
            spaced += " "
        spaced += letter
    return units.fold_letters(spaced).translate(_MINUS).strip()


def has_digit(text: str) -> bool:
    """Return whether a text contains one of the digits 0 to 9."""
    return not _DIGITS.isdisjoint(text)


_DIGITS = frozenset("0123456789")


def may_have_thousands(number: str, sign: str = ",") -> bool:
    """Return whether a comma, or another sign, may separate thousands: 46,300."""
    whole, _, rest = number.lstrip("+-").partition(sign)
    are_digits = f"{whole}{rest}".isdigit()
    return are_digits and whole[:1] > "0" and len(whole) <= 3 == len(rest)


def without_name(text: str) -> str:
    """Return a text without a name and "about" in front of its number."""
    return re.sub(_IN_FRONT, "", text)


def to_float(number: str) -> float:
    """Read a number with either decimal sign."""
    return float(number.replace(",", "."))


def last_place(number: str) -> int:
    """Return the power of ten of the last digit typed."""
    mantissa, _, exponent = number.lower().replace(",", ".").partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2])


def as_read(value: float, step: float) -> str:
    """Write a reading with its digits: 15 in steps of 0.1 is "15.0".

    Four digits are written if `step` is 0, or if the digits are more than an instrument
    has, because such digits come from arithmetic.
    """
    if step:
        decimals = max(0, -math.floor(math.log10(step) + 1e-6))
        text = f"{value:.{decimals}f}"
        if sum(map(str.isdigit, text)) <= MOST_DIGITS:
            return text
    return f"{value:.4g}"


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
    usual_signs = _with_usual_signs(plain)
    bare, coverage = without_coverage(usual_signs, "±" in usual_signs)
    for way, usual in _USUAL:
        bare = re.sub(way, usual, bare)
    match = re.fullmatch(_QUANTITY, bare)
    if match is None or _says_something_twice(match):
        return None
    return _parts(match, coverage)


def _with_usual_signs(text: str) -> str:
    """Write ± for other signs of it, and one blank for several."""
    usual = " ".join(text.split())
    for sign in _SIGNS_OF_SPREAD:
        usual = usual.replace(sign, "±")
    return usual


def without_coverage(text: str, has_uncertainty: bool) -> tuple[str, float]:
    """Split off the coverage factor: "4 ± 1 mm (k = 2)" becomes "4 ± 1 mm" and 2.

    Its other forms, 2σ and (95 %), are read in a text with an uncertainty only.
    """
    match = re.search(_COVERAGE, text)
    if match is None or not (has_uncertainty or match[1]):
        return text, 1.0
    number = to_float(match[match.lastindex or 0])
    factor = _LEVELS.get(number, number if number < 10 else None)
    if factor is None:
        return text, 1.0
    return f"{text[: match.start()]} {text[match.end() :]}".strip(), factor


def _says_something_twice(match: re.Match[str]) -> bool:
    """Return whether a quantity has two units, powers of ten or uncertainties.

    A bracket around a number without an uncertainty is not a quantity either.
    """
    if match["digits"] and match["spread"]:
        return True
    if match["open"] and not match["spread"]:
        return True
    return _has_two_units(match) or _has_two_powers(match)


def _has_two_units(match: re.Match[str]) -> bool:
    """Return whether a unit follows the bracket of one, or two differ next to a %."""
    unit = match["unit"]
    last = match["last"]
    if match["behind"]:
        return bool(unit or last)
    return bool(match["percent"] and unit and last and unit != last)


def _has_two_powers(match: re.Match[str]) -> bool:
    """Return whether a number has a power of ten, or is a fraction, before another."""
    if not match["power"] and not match["shared"]:
        return False
    numbers = match["number"] + (match["digits"] or match["spread"] or "")
    return any(sign in numbers for sign in "/eE")


def _parts(match: re.Match[str], coverage: float) -> Written:
    """Return the parts of a match of `_QUANTITY`, the power of ten in each number."""
    power = match["power"] or match["shared"] or ""
    number = match["number"] + power
    spread = match["spread"]
    unit = match["unit"]
    last = match["last"]
    behind = match["behind"]
    spread_unit = last if unit else None
    if match["digits"]:
        spread = _spread_of_digits(match["digits"], number, power)
    elif match["percent"]:
        spread_unit = "%"
    elif spread:
        spread += power
        if spread_unit is None:
            number = _without_separator(number, spread)
    value, step = _value_and_step(number)
    unit = unit or last or behind
    return Written(number, value, step, unit, spread, spread_unit, coverage)


def _spread_of_digits(digits: str, number: str, power: str) -> str:
    """Return the uncertainty in a bracket: 4.41(3) and 4.41(0.03) are ± 0.03."""
    if digits.isdigit():
        return f"{digits}e{last_place(number)}"
    return digits + power


def _without_separator(number: str, spread: str) -> str:
    """Return 46300 for "46,300 ± 600", whose comma separates thousands."""
    if may_have_thousands(number) and to_float(spread) > to_float(number):
        return number.replace(",", "")
    return number


def _value_and_step(number: str) -> tuple[float, float | None]:
    """Return the value of a number or a fraction, and one step of its last digit."""
    if "/" not in number:
        return to_float(number), float(f"1e{last_place(number)}")
    whole_and_part = "/".join(map(str.strip, number.lstrip("+-").split("/")))
    sign = -1.0 if number[0] == "-" else 1.0
    try:
        return sign * float(sum(map(Fraction, whole_and_part.split()))), None
    except ZeroDivisionError:
        return sign * math.inf, None
