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
from msgspec.structs import replace

from gyrodata.units import (
    KINDS,
    LIMITS,
    Uncertainty,
    UnitError,
    fold_letters,
    kinds_of,
    parse_unit,
)

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
_ALONE = rf"({NUMBER})\s*({_UNIT})?"
_IN_BRACKETS = rf"\(\s*({NUMBER})\s*±\s*({NUMBER})\s*\)\s*([eE][-+]?[0-9]{{1,3}})?\s*({_UNIT})?"
_PLUS_MINUS = rf"({NUMBER})\s*({_UNIT})?\s*±\s*({NUMBER})\s*(%)?\s*({_UNIT})?"
_CONCISE = rf"({NUMBER})\(({NUMBER})\)([eE][-+]?[0-9]{{1,3}})?\s*({_UNIT})?"
_SIGN_PAIR = r"\+\s?/\s?-|\+-|\\pm"
_NAME = r"[^\W\d][\w ]{0,30}=\s*"
_SUPERSCRIPT = r"(?<=[0-9])([⁺⁻]?[⁰¹²³⁴-⁹]+)"
_TIMES_TEN = r"[×x*·⋅∙]\s*10"
_POWER_OF_TEN = (
    rf"\s*(?:{_TIMES_TEN}\s*(?:(?:\^|\*\*)\s*|(?=[-+]))|(?<=[\s)])10\s*(?:\^|\*\*)\s*)"
    r"(?:[({]\s*([-+]?[0-9]{1,3})\s*[)}]|([-+]?[0-9]{1,3}))(?![0-9.,])"
)
_SHARED_POWER = rf"({NUMBER}\s*±\s*{NUMBER})(?=\s*{_TIMES_TEN}|\s+10\s*(?:\^|\*\*))"
_COVERAGE = r"\s*[(,;]?\s*k\s*=\s*([1-9](?:[.,][0-9]+)?)\s*\)?$"
_COVERAGE_INSIDE = r"\(\s*k\s*=\s*([1-9](?:[.,][0-9]+)?)\s*\)"
_SIGMAS = r"\s*[(\[,;]?\s*([1-3])\s?-?(?:σ|sigma|s\.?d\.?)\s*[)\]]?$"
_ABOUT = r"(?:about|approximately|approx\.?|circa|ca\.?|roughly|[~≈≃])\s*(?=[-+(\d.,])"
_SAID = (
    r"\s*(?:[,;(]|\bwith\b)\s*(?:(?:with|an?|and|the|its|standard)\s+)*"
    r"(?:u(?:\s*\([^()]*\)|_?[^\W\d]{0,4})|σ|sigma|uncertainty|error|±)"
    rf"\s*(?:=|:|of\b|is\b|±)?\s*(?={NUMBER})"
)
_LEVEL = r"[(\[]\s*([0-9]{2}(?:[.,][0-9]+)?)\s*%\s*(?:C\.?[IL]\.?|confidence|confidence level|coverage)?\s*[)\]]"
_UNIT_IN_BRACKETS = r"(?<=[\d\s)%])[\[(]\s*((?:1/)?[^\W\d][^()\[\]±]*?|°[^()\[\]±]*?)\s*[\])]$"
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
    text = re.sub(_SUPERSCRIPT, lambda match: "^" + unicodedata.normalize("NFKC", match[1]), text)
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
    if number.isdigit():
        return 0
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
    match = PLAIN.fullmatch(plain)
    if match:
        return Written(plain, to_float(plain), float(f"1e{last_place(plain)}"))
    match = re.fullmatch(_FRACTION, plain) if "/" in plain else None
    if match:
        sign, whole, over, under, unit = match.groups()
        number = (int(whole or 0) * int(under) + int(over)) / int(under) if int(under) else math.inf
        return Written(f"{over}/{under}", -number if sign == "-" else number, None, unit)
    match = re.fullmatch(_ALONE, plain)
    if match and kinds_of(match[2]):
        return _written(match[1], match[2])
    return _take_apart_long(re.sub(_SIGN_PAIR, "±", plain) if "-" in plain or "\\" in plain else plain)


def _take_apart_long(plain: str) -> Written | None:
    """Take apart what has a ±, a bracket, a power of ten, a name or a coverage factor."""
    # What a text has no sign of is not looked for, so that its pattern need not be compiled.
    bare = re.sub(rf"^{_NAME}", "", plain, count=1) if "=" in plain else plain
    if bare[:1].isalpha() or bare[:1] in "~≈≃":
        bare = re.sub(rf"^{_ABOUT}", "", bare, count=1, flags=re.IGNORECASE)
    if bare.endswith("."):  # the end of a sentence
        bare = re.sub(r"(?<=[^\W\d])\.$|(?<=\^\d)\.$", "", bare)
    named = bare != plain
    bare, coverage = _without_coverage(bare)
    said = re.search(_SAID, bare, re.IGNORECASE) if "±" not in bare or "(" in bare else None
    if said and said.start():
        # "4.4e-3 kg m^2, u = 1e-4" and "4.4e-3 kg m^2 (± 1e-4)"
        end = bare[said.end() :]
        bare = f"{bare[: said.start()]} ± {end[:-1] if '(' in said[0] and end.endswith(')') else end}"
    if bare.endswith((")", "]")):
        bare = re.sub(_UNIT_IN_BRACKETS, r" \1", bare)
    if "10" in bare:
        # "4.4 ± 0.1 × 10^-3" means that power of both.
        bare = re.sub(rf"^{_SHARED_POWER}", r"(\1)", bare)
        bare = re.sub(_POWER_OF_TEN, lambda power: f"e{power[1] or power[2]}", bare)
    if bare.endswith(")") and re.fullmatch(r"\([^()]*±[^()]*\)", bare):
        bare = bare[1:-1].strip()
    written = _match_long(bare)
    if written is None:
        return None
    return replace(written, coverage=coverage, named=named)


def _without_coverage(text: str) -> tuple[str, float]:
    """Take ``(k = 2)`` or ``(95 %)`` off, and give the coverage factor."""
    for pattern in (_COVERAGE, _COVERAGE_INSIDE) if "=" in text else ():
        match = re.search(pattern, text)
        if match:
            return f"{text[: match.start()]} {text[match.end() :]}".strip(), to_float(match[1])
    match = re.search(_SIGMAS, text, re.IGNORECASE) if "±" in text and text[-1] in ")]aAσdD." else None
    if match:
        return text[: match.start()].strip(), to_float(match[1])
    match = re.search(_LEVEL, text) if "±" in text and "%" in text else None
    if match and to_float(match[1]) in _LEVELS:
        return f"{text[: match.start()]} {text[match.end() :]}".strip(), _LEVELS[to_float(match[1])]
    return text, 1.0


def _match_long(text: str) -> Written | None:
    match = re.fullmatch(_IN_BRACKETS, text) if text[:1] == "(" else None
    if match:
        number, spread, power, unit = match.groups()
        if power and "e" in (number + spread).lower():
            return None
        return _written(number + (power or ""), unit, spread + (power or ""))
    match = re.fullmatch(_PLUS_MINUS, text) if "±" in text else None
    if match:
        number, first, spread, percent, last = match.groups()
        if percent and first and last and first != last:
            return None
        return _written(number, first or last, spread, percent == "%", None if percent or not first else last)
    match = re.fullmatch(_CONCISE, text) if "(" in text else None
    if match:
        number, spread, power, unit = match.groups()
        if power and "e" in number.lower():
            return None
        number += power or ""
        # A whole number in the bracket counts in the last digits.
        spread = f"{spread}e{last_place(number)}" if spread.isdigit() else spread + (power or "")
        return _written(number, unit, spread)
    match = re.fullmatch(_ALONE, text)
    return _written(match[1], match[2]) if match else None


def _written(
    number: str,
    unit: str | None = None,
    spread: str | None = None,
    percent: bool = False,
    spread_unit: str | None = None,
) -> Written:
    if spread and not percent and re.fullmatch(_THOUSANDS, number) and "," not in spread:
        # "46,300 ± 600": nobody writes 46.300 ± 600; and with a point in "± 0.5" the comma is none.
        thousands = spread_unit in (None, unit) and to_float(spread) > abs(to_float(number))
        number = number.replace(",", "") if thousands or "." in spread else number
    return Written(
        number, to_float(number), float(f"1e{last_place(number)}"), unit, spread, percent, spread_unit or None
    )


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
    if not all(low <= abs(value) * factor <= high for value in (written.value, 1000 * written.value)):
        return ""
    return f"{number.replace(',', '')} or {number.replace(',', '.')}"


def in_si(written: Written, kind: str, unit: str | None = None) -> Quantity:
    """Bring a quantity taken apart into SI; `unit` holds where none is written."""
    own = written.unit or unit or ""
    u = written.u
    if kind == "rate" and own and kinds_of(own) == {"time"}:
        return _rate_of_period(written, own)
    known = parse_unit(own, kind)
    factor = known.factor
    step = None if written.step is None else written.step * factor
    if u is None:
        return Quantity(written.value * factor, step, None, known.text)
    if written.percent:
        return Quantity(written.value * factor, step, Uncertainty(0.0, abs(u)), known.text)
    u_factor = parse_unit(written.spread_unit, kind).factor if written.spread_unit else factor
    return Quantity(written.value * factor, step, Uncertainty(abs(u) * u_factor), known.text)


def _rate_of_period(written: Written, unit: str) -> Quantity:
    """Turn "0.1 s per turn" into a rate; "0.1 s" alone might be the time of ten turns."""
    period = parse_unit(unit, "time")
    if "/" not in period.text:
        hint = "write s/rev if it is the time of one revolution"
        raise UnitError(f'"{unit}" is a time, not a rotation rate', hint, "kind")
    if written.value == 0:
        return Quantity(math.inf, None, None, "rad/s")
    rate = 2 * math.pi / (written.value * period.factor)
    share = abs(rate / written.value)
    u = written.u
    uncertainty = None
    if u is not None:
        uncertainty = Uncertainty(0.0, abs(u)) if written.percent else Uncertainty(abs(u) * share)
    return Quantity(rate, None if written.step is None else written.step * share, uncertainty, "rad/s")


def read_quantity(text: str, kind: str, unit: str | None = None, ask: bool = True) -> Quantity:
    """Understand a quantity with its unit and its ±: an option, or a value in a file of settings.

    `unit` holds where none is written. With `ask`, a comma that may part thousands is refused; without, it is a
    decimal comma.
    """
    shown = text.strip()[:40]
    written = take_apart(text)
    if written is None or written.named:
        raise _unreadable(text, kind)
    if not written.unit and not unit and kind not in ("number", "sign"):
        raise UnitError(f'"{text.strip()}" has no unit', f"write one behind it: {KINDS[kind].examples}")
    if ask and (ways := doubtful_comma(written, kind, unit)):
        raise UnitError(f'"{shown}" can mean {ways}', "write it without marks between the thousands", "ambiguous")
    quantity = in_si(written, kind, unit)
    if not math.isfinite(quantity.value):
        raise UnitError(f'"{shown}" is no finite number')
    return quantity


def _unreadable(text: str, kind: str) -> UnitError:
    match = re.fullmatch(rf"({NUMBER})(?:\s*/\s*[0-9]+)?\s*(\S.*)", fold_number(text), re.DOTALL)
    if match and "±" not in text:
        try:
            parse_unit(match[2], kind)
        except UnitError as error:
            return error
    return UnitError(f'"{text.strip()[:40]}" is not a number with a unit', f"write it like {KINDS[kind].sample}")


def how_to_write(kind: str) -> str:
    """Say how a number of some kind is written, without a number that could be taken over as it stands."""
    of = KINDS[kind]
    return f"write a number with its unit: {of.examples}" if of.si else of.proposal


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
