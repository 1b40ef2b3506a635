"""The one reader of a written quantity: number, last digit, ±, unit, power of ten and coverage factor.

Cells, options, ``# key:`` lines, rubrics and reported values are all read here. They differ in the kind of quantity,
in the unit that holds where none is written, and in what they refuse. What this tool prints, it reads.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise

from msgspec import Struct

from gyrodata.units import KINDS, LIMITS, Uncertainty, UnitError, fold_letters, kinds_of, parse_unit

LONGEST = 200
"""Characters in a written quantity; longer texts are none."""

MOST_DIGITS = 7
"""Of a reading, zeros before it included: 0.02000 kg has six."""

NUMBER = r"[-+]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][-+]?[0-9]{1,5})?"
_UNIT = r"(?:1/)?[^\d\s.,;:+±()%\-][^±;%]*?"
PLAIN = re.compile(NUMBER)
"""A number and nothing else."""

# Most cells are plain numbers; these patterns are compiled when the first other text comes (`re` keeps them).
_FRACTION = rf"([-+]?)(?:([0-9]{{1,9}})\s+)?([0-9]{{1,9}})\s*/\s*([0-9]{{1,9}})\s*({_UNIT})?"
_POWER = r"[eE][-+]?[0-9]{1,3}"
_QUANTITY = (
    rf"(?P<open>\(\s*)?(?P<number>{NUMBER})(?:\((?P<digits>{NUMBER})\)(?P<power>{_POWER})?)?\s*(?P<unit>{_UNIT})?"
    rf"(?:\s*±\s*(?P<spread>{NUMBER})\s*(?P<percent>%)?\s*(?P<last>{_UNIT})?)?"
    rf"(?(open)\s*\)\s*(?P<shared>{_POWER})?\s*(?P<behind>{_UNIT})?)"
)
"""``4.4(1)e-3 g``, ``4.4 g ± 2 %``, ``(4.4 ± 0.1)e-3 g``: all that `_USUAL` brings the other ways of writing to."""

_NAME = r"^[^\W\d][\w ]{0,30}=\s*"
_ABOUT = r"(?i)^(?:about|approximately|approx\.?|circa|ca\.?|roughly|[~≈≃])\s*(?=[-+(\d.,])"
_SAID = (
    r"(?i)(?<=\S)\s*(?:[,;(]|\bwith\b)\s*(?:(?:with|an?|and|the|its|standard)\s+)*"
    r"(?:u(?:\s*\([^()]*\)|_?[^\W\d]{0,4})|σ|sigma|uncertainty|error|±)"
    rf"\s*(?:=|:|of\b|is\b|±)?\s*(?={NUMBER})"
)
_TIMES_TEN = r"[×x*·⋅∙]\s*10"
_POWER_OF_TEN = (
    rf"\s*(?:{_TIMES_TEN}\s*(?:(?:\^|\*\*)\s*|(?=[-+]))|(?<=[\s)])10\s*(?:\^|\*\*)\s*)"
    r"(?:[({]\s*([-+]?[0-9]{1,3})\s*[)}]|([-+]?[0-9]{1,3}))(?![0-9.,])"
)
_USUAL = (
    (r"(?:(?<=[^\W\d])|(?<=\^\d))\.$", ""),  # the end of a sentence
    (rf"{_SAID}((?:[^()]|\([^()]*\))*)\)?$", r" ± \1"),  # "4.4e-3 kg m^2, u = 1e-4" and "4.4e-3 kg m^2 (± 1e-4)"
    (r"(?<=[\d\s)%])[\[(]\s*((?:1/)?[^\W\d][^()\[\]±]*?|°[^()\[\]±]*?)\s*[\])]$", r" \1"),  # a unit in brackets
    # "4.4 ± 0.1 × 10^-3" means that power of both.
    (rf"^({NUMBER}\s*±\s*{NUMBER})(?=\s*{_TIMES_TEN}|\s+10\s*(?:\^|\*\*))", r"(\1)"),
    (_POWER_OF_TEN, r"e\1\2"),
)
"""Ways of writing, and the usual one to put in their place."""

_K = r"\s*k\s*=\s*([1-9](?:[.,][0-9]+)?)\s*"
_COVERAGES = (
    rf"(.*?)\s*[(,;]?{_K}\)?()",
    rf"(.*)\({_K}\)(.*)",
    r"(.*±.*?)\s*[(\[,;]?\s*([1-3])\s?-?(?:σ|sigma|s\.?d\.?)\s*[)\]]?()",
    r"(.*±.*)[(\[]\s*([0-9]{2}(?:[.,][0-9]+)?)\s*%\s*(?:C\.?[IL]\.?|confidence|confidence level|coverage)?\s*[)\]](.*)",
)
"""A coverage factor or a level with what stands before and behind it: ``(k = 2)``, ``2σ``, ``(95 %)``."""
_THOUSANDS = r"[-+]?[1-9][0-9]{0,2},[0-9]{3}"

_LEVELS = {68.0: 1.0, 68.3: 1.0, 68.27: 1.0, 90.0: 1.645, 95.0: 1.96, 95.4: 2.0, 95.45: 2.0, 99.0: 2.576, 99.7: 3.0}
"""Coverage factors of the levels that are stated in %, for normal errors."""

_MINUS = str.maketrans({"−": "-", "–": "-", "‐": "-", "‑": "-"})


class Written(Struct, frozen=True):
    """A quantity taken apart, before its unit is understood."""

    number: str
    """Text of the number, its power of ten in it: ``4.441e-3``; ``1/3`` of a fraction."""
    value: float
    """The number; infinite where it is too large or divides by zero."""
    step: float | None
    """One step of its last digit; None for a fraction."""
    unit: str | None = None
    """In folded letters; None where there is none."""
    spread: str | None = None
    """Text of what stands behind ±, or in the bracket; None where there is none."""
    percent: bool = False
    """Whether that is in % of the number."""
    spread_unit: str | None = None
    """Its own unit, where it has one."""
    coverage: float = 1.0
    """What it is to be divided by to become a standard uncertainty."""
    named: bool = False
    """Whether a name stood in front: ``I = 4.4e-3 kg m^2``."""

    @property
    def u(self) -> float | None:
        """Give the standard uncertainty: a share of 1 if `percent`, else in the unit that it is written in."""
        if self.spread is None:
            return None
        return to_float(self.spread) / self.coverage / (100 if self.percent else 1)


class Quantity(Struct, frozen=True):
    """A written quantity in SI."""

    value: float
    """[SI unit of its kind]"""
    step: float | None
    """One step of the last digit typed [SI unit of its kind]; None for a fraction."""
    uncertainty: Uncertainty | None
    """Standard uncertainty, where one is written."""
    unit: str
    """Unit that was used, in a spelling that is read back."""


def fold_number(text: str) -> str:
    """Write a text in ASCII as far as that changes nothing: real minus signs, ½, wide digits; 10⁻³ becomes 10^-3."""
    if text.isascii():
        return text.strip()
    text = re.sub(r"(?<=[0-9])([⁺⁻]?[⁰¹²³⁴-⁹]+)", lambda match: "^" + unicodedata.normalize("NFKC", match[1]), text)
    spelled = "".join(
        f" {folded}" if unicodedata.category(c) == "No" and "⁄" in (folded := unicodedata.normalize("NFKC", c)) else c
        for c in text
    )
    return fold_letters(spelled).translate(_MINUS).replace("⁄", "/").strip()


def to_float(number: str) -> float:
    """Understand a number with either decimal sign."""
    return float(number.replace(",", "."))


def last_place(number: str) -> int:
    """Give the power of ten of the last digit typed."""
    mantissa, _, exponent = number.lower().replace(",", ".").partition("e")
    return int(exponent or 0) - len(mantissa.partition(".")[2])


def exchanged_digits(number: str) -> Iterator[str]:
    """Give a number with each two neighbouring digits exchanged, but for those that begin with 0."""
    digits = [at for at, sign in enumerate(number) if sign.isdigit()]
    for one, other in pairwise(digits):
        signs = [*number]
        signs[one], signs[other] = number[other], number[one]
        if signs[digits[0]] != "0" and signs != [*number]:
            yield "".join(signs)


def as_read(value: float, step: float) -> str:
    """Write a reading with the digits that it was read to: 15 in steps of 0.1 is "15.0"; four where `step` is 0."""
    text = f"{value:.{max(0, -math.floor(math.log10(step) + 1e-6))}f}" if step else ""
    # More digits than an instrument has come from arithmetic.
    return text if 0 < sum(map(str.isdigit, text)) <= MOST_DIGITS else f"{value:.4g}"


def take_apart(text: str) -> Written | None:
    """Take a written quantity apart; None if it is none.

    Read are ``4.4e-3 kg m^2``, ``4.4×10⁻³ kg·m²``, ``4.4(1)e-3 kg m^2``, ``4.4e-3 ± 2 % kg m^2``,
    ``(4.4 ± 0.1) × 10⁻³ kg·m²``, ``4.4 ± 0.2 g (k = 2)``, ``76 g``, ``1/3`` and their like.
    """
    if len(text) > LONGEST:
        return None
    plain = fold_number(text)
    if PLAIN.fullmatch(plain):
        return Written(plain, to_float(plain), float(f"1e{last_place(plain)}"))
    if match := re.fullmatch(_FRACTION, plain):
        sign, whole, over, under, unit = match.groups()
        value = (int(whole or 0) * int(under) + int(over)) / int(under) if int(under) else math.inf
        return Written(f"{over}/{under}", -value if sign == "-" else value, None, unit)
    # Of many blanks in a row two are left: the patterns would try all ways to part them.
    plain = re.sub(r"\+\s?/\s?-|\+-|\\pm", "±", re.sub(r"\s{3,}", "  ", plain))
    bare = re.sub(_ABOUT, "", re.sub(_NAME, "", plain))
    named = bare != plain
    bare, coverage = _without_coverage(bare)
    for way, usual in _USUAL:
        bare = re.sub(way, usual, bare)
    match = re.fullmatch(_QUANTITY, bare)
    if match is None:
        return None
    number, digits, spread = match["number"], match["digits"], match["spread"]
    unit, last, behind = match["unit"], match["last"], match["behind"]
    percent, power = match["percent"] is not None, match["power"] or match["shared"] or ""
    two_units = (behind and (unit or last)) or (percent and unit and last and unit != last)
    two_powers = power and "e" in (number + (digits or spread or "")).lower()
    if two_units or two_powers or (digits and spread) or (match["open"] and not spread):
        return None
    number += power
    spread_unit, unit = last if unit and not percent else None, unit or last or behind
    if digits:
        # A whole number in the bracket counts in the last digits.
        spread = f"{digits}e{last_place(number)}" if digits.isdigit() else digits + power
    elif spread and not percent:
        spread += power
        if re.fullmatch(_THOUSANDS, number) and "," not in spread:
            # "46,300 ± 600": nobody writes 46.300 ± 600; and with a point in "± 0.5" the comma is none.
            larger = spread_unit in (None, unit) and to_float(spread) > abs(to_float(number))
            number = number.replace(",", "") if larger or "." in spread else number
    step = float(f"1e{last_place(number)}")
    return Written(number, to_float(number), step, unit, spread, percent, spread_unit, coverage, named)


def _without_coverage(text: str) -> tuple[str, float]:
    """Take ``(k = 2)`` or ``(95 %)`` off, and give the coverage factor."""
    for pattern in _COVERAGES:
        match = re.fullmatch(pattern, text, re.IGNORECASE)
        if match and ((number := to_float(match[2])) < 10 or number in _LEVELS):
            return f"{match[1]} {match[3]}".strip(), _LEVELS.get(number, number)
    return text, 1.0


def doubtful_comma(written: Written, kind: str, unit: str | None = None) -> str:
    """Say in which two ways a comma can be meant that may part thousands: "46300 or 46.300"; "" if in one only.

    A power of ten, another number with a decimal comma, or a size that no lab has tells how it is meant.
    """
    number, spread = written.number, written.spread or ""
    if not re.fullmatch(_THOUSANDS, number) or ("," in spread and not re.fullmatch(_THOUSANDS, spread)):
        return ""
    try:
        factor = parse_unit(written.unit or unit or "", kind).factor
    except UnitError:
        return ""
    low, high = LIMITS.get(kind, (0.0, math.inf))
    both = all(low <= abs(value) * factor <= high for value in (written.value, 1000 * written.value))
    return f"{number.replace(',', '')} or {number.replace(',', '.')}" if both else ""


def in_si(written: Written, kind: str, unit: str | None = None) -> Quantity:
    """Bring a quantity taken apart into SI; `unit` holds where none is written."""
    own, u = written.unit or unit or "", written.u
    # "0.1 s per turn" becomes a rate; "0.1 s" alone might be the time of ten turns.
    inverse = kind == "rate" and kinds_of(own) == {"time"}
    known = parse_unit(own, "time" if inverse else kind)
    factor, spread_factor = known.factor, parse_unit(written.spread_unit or own, known.kind).factor
    value, text = written.value * factor, known.text
    if inverse:
        if "/" not in text:
            hint = "write s/rev if it is the time of one revolution"
            raise UnitError(f'"{own}" is a time, not a rotation rate', hint, "kind")
        if value == 0:
            return Quantity(math.inf, None, None, "rad/s")
        slope = 2 * math.pi / value**2
        value, text, factor, spread_factor = 2 * math.pi / value, "rad/s", factor * slope, spread_factor * slope
    uncertainty = None
    if u is not None:
        uncertainty = Uncertainty(0.0, abs(u)) if written.percent else Uncertainty(abs(u) * spread_factor)
    return Quantity(value, None if written.step is None else written.step * factor, uncertainty, text)


def read_quantity(text: str, kind: str, unit: str | None = None, ask: bool = True) -> Quantity:
    """Understand a quantity with its unit and its ±: an option, or a value in a file of settings.

    `unit` holds where none is written. With `ask`, a comma that may part thousands is refused; without, it is a
    decimal comma.
    """
    shown = text.strip()[:40]
    written = take_apart(text)
    if written is None or written.named:
        raise UnitError(f'"{shown}" is not a number with a unit', f"write it like {KINDS[kind].sample}")
    if not written.unit and not unit and kind not in ("number", "sign"):
        raise UnitError(f'"{text.strip()}" has no unit', f"write one behind it: {KINDS[kind].examples}")
    if ask and (ways := doubtful_comma(written, kind, unit)):
        raise UnitError(f'"{shown}" can mean {ways}', "write it without marks between the thousands", "ambiguous")
    quantity = in_si(written, kind, unit)
    if not math.isfinite(quantity.value):
        raise UnitError(f'"{shown}" is no finite number')
    return quantity


def how_to_write(kind: str) -> str:
    """Say how a number of some kind is written, without a number that could be taken over as it stands."""
    return f"write a number with its unit: {KINDS[kind].examples}" if KINDS[kind].si else KINDS[kind].proposal


def parse_quantity(text: str, kind: str) -> float:
    """Understand one number with its unit: ``60 g``, ``200 rpm``, ``(4.44 ± 0.06) × 10⁻³ kg·m²``, ``1/3``."""
    return read_quantity(text, kind).value


@lru_cache(maxsize=512)
def parse_uncertainty(text: str, kind: str, unit: str = "", ask: bool = True) -> Uncertainty:
    """Understand a standard uncertainty: ``0.5 mm``, ``0.2 %``, or a sum of both, ``0.2 % + 0.5 rpm``.

    A coverage factor behind it, ``1 mm (k = 2)``, is divided out; `unit` is that of a term that has none of its own.
    """
    absolute = relative = 0.0
    whole, coverage = _without_coverage(f"± {text.strip().lstrip('±+ ')}")
    for term in re.split(r"(?<![eE^])\+", whole[1:].strip()):
        if term.rstrip().endswith("%"):
            part = read_quantity(term.rstrip()[:-1], "number").value / 100 / coverage
            relative += part
        else:
            try:
                quantity = read_quantity(term, kind, unit or None, ask)
            except UnitError as error:
                # The sample of its kind is as large as a value: it would drown the log.
                share = f'{how_to_write(kind)}, or a share of the value: "1 %"'
                hint = error.hint.replace(f"write it like {KINDS[kind].sample}", share)
                raise UnitError(str(error), hint, error.reason) from None
            if quantity.uncertainty is not None:
                raise UnitError(f'"{text.strip()[:40]}" is no uncertainty, but a value with one')
            part = quantity.value / coverage
            absolute += part
        if part < 0:
            raise UnitError(f'"{text.strip()[:40]}" is negative, and an uncertainty cannot be')
    if relative > 10 or absolute > LIMITS[kind][1]:
        raise UnitError(f'"{text.strip()[:40]}" is far too large for an uncertainty', "is its unit the one written?")
    return Uncertainty(absolute, relative)
