"""Numbers as text, rounded to two digits of u by the package `uncertainties`."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Sequence
from functools import lru_cache

from msgspec import Struct

from gyrodata.base.errors import count_text as count_text
from gyrodata.quantities import units
from gyrodata.quantities.numerals import as_read


class Scale(Struct, frozen=True):
    """A unit that values are shown in, with the power of ten before it."""

    unit: str
    """As text: "mN·m"; "" for plain numbers."""
    siunitx: str
    """The same in the commands of LaTeX's siunitx."""
    size: float = 1.0
    """The value of a displayed 1 [SI unit]."""
    exponent: int = 0
    """Power of ten written out."""

    def __str__(self) -> str:
        return f"{ten_to(self.exponent)} {self.unit}".strip()


NUMBER = Scale("", "")
PERCENT = Scale("%", r"\percent", 0.01)
IN_U = Scale("u", "u")
SECOND = Scale("s", r"\second")
RPM = Scale("rpm", r"\rpm", units.RPM)
METRE = Scale("m", r"\metre")
CENTIMETRE = Scale("cm", r"\centi\metre", 1e-2)
MICROMETRE = Scale("µm", r"\micro\metre", 1e-6)
GRAM = Scale("g", r"\gram", 1e-3)
KILOGRAM = Scale("kg", r"\kilogram")
NEWTON_METRE = Scale("N·m", r"\newton\metre")
MILLINEWTON_METRE = Scale("mN·m", r"\milli\newton\metre", 1e-3)
MICRONEWTON_METRE = Scale("µN·m", r"\micro\newton\metre", 1e-6)
RATE = Scale("rad/s", r"\radian\per\second")
PRODUCT = Scale("rad²/s²", r"\radian\squared\per\second\squared")
FREE_FALL = Scale("m/s²", r"\metre\per\second\squared")
ANGULAR_MOMENTUM = Scale("kg·m²/s", r"\kilogram\metre\squared\per\second")
r"""The units of the report: with `CENTIMETRE`, 0.15 [m] of the JSON is "15 cm" in a
text and ``\qty{15}{\centi\metre}`` in LaTeX."""


def inertia_scale(value: float, u: float | None) -> Scale:
    """Choose the power of ten for a moment of inertia and its uncertainty [kg*m^2]."""
    larger = max(value, u or 0.0, key=abs)
    exponent = exponent_of(larger)
    siunitx = r"\kilogram\metre\squared"
    return Scale("kg·m²", siunitx, 10.0**exponent, exponent)


def number_text(value: float, u: float | None, factor: float = 1.0) -> str:
    """Write a value rounded to its uncertainty, in units of `factor`: "4.44 ± 0.06".

    u has two significant digits, the value ends at the same place (GUM 7.2.6); without
    u it has four digits.
    """
    if u is None or u == 0 or not math.isfinite(u):
        return reading_text(value, factor)
    nominal, spread, exponent = rounded(value, u, factor)
    digits = f"{nominal} ± {spread}"
    if not exponent:
        return digits
    return f"({digits}) × {ten_to(exponent)}"


def reading_text(value: float, factor: float = 1.0, step: float = 0.0) -> str:
    """Write a value without an uncertainty.

    The value is written to its last digit that was read, or else with four digits and
    all digits before the point.
    """
    value /= factor
    if 1e4 <= abs(value) < 1e9:
        return f"{value:.0f}"
    return as_read(value, step / factor)


@lru_cache(maxsize=1024)  # the pages of a class repeat their references
def rounded(value: float, u: float, factor: float = 1.0) -> tuple[str, str, int]:
    """Round a value to its uncertainty: ("4.441", "0.023", 0).

    The last is a common exponent of ten.
    """
    from uncertainties import ufloat

    text = f"{ufloat(value / factor, u / factor):.2u}"
    if re.match(r"\(?-[0.]+(?![0-9.])", text):
        # A value that rounds to zero has no sign.
        text = f"{ufloat(0.0, u / factor):.2u}"
    number, _, exponent = text.partition("e")
    nominal, _, spread = number.strip("()").partition("+/-")
    return nominal, spread, int(exponent or 0)


def exponent_of(value: float) -> int:
    """Return the power of ten of the first digit: -3 for 0.0044."""
    return math.floor(math.log10(abs(value))) if value else 0


RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def ten_to(exponent: int) -> str:
    """Write a power of ten: "10⁻³"; "" for 10⁰."""
    if not exponent:
        return ""
    raised = str(exponent).translate(RAISED)
    return f"10{raised}"


def power_of_ten(value: float) -> tuple[float, str]:
    """Find the power of ten that leaves one digit before the point, and write it.

    Examples are (1e-3, "10⁻³") and (1.0, "").
    """
    exponent = exponent_of(value)
    return 10.0**exponent, ten_to(exponent)


def with_unit(number: str, scale: Scale) -> str:
    """Add the unit to a number: "(4.44 ± 0.06) × 10⁻³ kg·m²"."""
    if not scale.exponent:
        return f"{number} {scale}".rstrip()
    if "±" in number:
        number = f"({number})"
    return f"{number} × {scale}"


def inertia_text(value: float, u: float | None) -> str:
    """Write a moment of inertia [kg*m^2]: "(4.44 ± 0.06) × 10⁻³ kg·m²"."""
    scale = inertia_scale(value, u)
    return with_unit(number_text(value, u, scale.size), scale)


def p_text(p: float) -> str:
    """Write a probability: "p = 0.32", "p < 0.0001"."""
    if p < 1e-4:
        return "p < 0.0001"
    return f"p = {p:.2g}"


def duration_text(seconds: float) -> str:
    """Write a duration [s] in at most two units, cut off: "2 days 4 h"."""
    if round(seconds) < 60:
        return f"{seconds:.0f} s"
    days, rest = divmod(max(60, int(seconds)), 86400)
    hours, rest = divmod(rest, 3600)
    minutes = rest // 60
    unit_of_days = "day" if days == 1 else "days"
    parts = [(days, unit_of_days), (hours, "h"), (minutes, "min")]
    while parts[0][0] == 0:
        parts.pop(0)
    return " ".join(f"{count} {unit}" for count, unit in parts[:2] if count)


def inertia_range_text(low: float, high: float) -> str:
    """Write a range of uncertainties: "(1.7 to 5.8) × 10⁻⁵ kg·m²"."""
    factor, power = power_of_ten(high)
    start, end = [f"{number / factor:.2g}" for number in (low, high)]
    numbers = f"({start} to {end})"
    if start == end:
        numbers = start
    if power:
        numbers += f" × {power}"
    return f"{numbers} kg·m²"


def factor_text(factor: float) -> str:
    """Write a factor: "9.55 times", "1/9.55 of", "10⁷ times"."""
    sign = "−" if factor < 0 else ""
    size = abs(factor)
    is_part = 0 < size < 1
    number = 1 / size if is_part else size
    rounded = float(f"{number:.3g}")
    digits = f"{rounded:.3g}"
    if rounded >= 1e6:
        ten, power = power_of_ten(rounded)
        digits = power
        if rounded != ten:
            digits = f"{rounded / ten:.3g} × {power}"
    elif rounded >= 1000:
        digits = f"{rounded:.0f}"
    if is_part:
        return f"{sign}1/{digits} of"
    return f"{sign}{digits} times"


def in_columns(
    rows: Sequence[Sequence[str]], right: Collection[int] = ()
) -> Iterator[str]:
    """Set cells under each other, two blanks between.

    Columns of numbers, by their place, end at the right.
    """
    from rich.cells import cell_len

    widths = [max(map(cell_len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = []
        for at, (cell, width) in enumerate(zip(row, widths, strict=True)):
            blanks = " " * (width - cell_len(cell))
            if at in right:
                cells.append(blanks + cell)
            else:
                cells.append(cell + blanks)
        yield "  ".join(cells).rstrip()
