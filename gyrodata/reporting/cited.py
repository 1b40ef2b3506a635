"""Numbers for the page, each marked with the place in results.json that it is read from.

A number becomes ``<data value="0.00444" data-from="inertia.value" data-size="0.001">4.44</data>``: the value as
results.json has it, where it stands there, and what one unit of the shown text is worth. Nothing is computed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from markupsafe import Markup, escape

from gyrodata.reporting.values import (
    Scale,
    interval_ends,
    p_text,
    percent_text,
    power_of_ten,
    reading_text,
    rounded,
    uncertainty_text,
)

NOTHING = Markup("–")
_UNIT = Markup('<span class="q">{}</span>')


class Cited:
    """The numbers of one result: what results.json holds, as `Analysis.to_dict` gives it."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.document = document

    def at(self, place: str) -> Any:
        """Give what stands at a place below "result": "torques.0.product.value"; "length" counts a list.

        A leading "/" starts at the top of the document.
        """
        found: Any = self.document if place.startswith("/") else self.document["result"]
        for key in place.removeprefix("/").split("."):
            if isinstance(found, list) and key == "length":
                return len(found)
            found = found[int(key) if isinstance(found, list) else key]
        return found

    def mark(self, place: str, text: str, size: float = 1.0) -> Markup:
        """Mark a text as the number at a place; `size` is what a shown 1 is worth in the unit of results.json."""
        return Markup('<data value="{}" data-from="{}" data-size="{}">{}</data>').format(
            repr(self.at(place)), place, repr(size), text.replace("-", "−")
        )

    def name(self, place: str) -> Markup:
        """Write a name that the log gives, such as a run's."""
        return Markup('<data value="{0}" data-from="{1}">{0}</data>').format(self.at(place), place)

    def count(self, place: str, noun: str) -> Markup:
        """Write a count with its noun: "10 runs"."""
        number = self.at(place)
        return _UNIT.format(Markup("{} {}").format(self.mark(place, str(number)), noun if number == 1 else f"{noun}s"))

    def reading(self, place: str, size: float = 1.0) -> Markup:
        """Write a value without an uncertainty, four digits; a dash for None."""
        value = self.at(place)
        return NOTHING if value is None else self.mark(place, reading_text(value, size), size)

    def spread(self, place: str, size: float = 1.0) -> Markup:
        """Write an uncertainty or a scatter, two digits; a dash for None."""
        value = self.at(place)
        if value is None:
            return NOTHING
        text = "< 0.0001" if 0 < value / size < 1e-4 else uncertainty_text(value, size)
        return self.mark(place, text, size)

    def pair(self, place: str, size: float = 1.0, value: str = "value", u: str = "") -> Markup:
        """Write a value rounded to its uncertainty, without unit: "4.441 ± 0.023"; a dash for None.

        A negative `size` turns the sign. `value` and `u` are the keys at the place: "value" and "u", or any name and
        that name with "_u".
        """
        u = u or ("u" if value == "value" else f"{value}_u")
        number, spread = self.at(f"{place}.{value}"), self.at(f"{place}.{u}")
        if number is None:
            return NOTHING
        if not spread:
            return self.reading(f"{place}.{value}", size)
        nominal, spread, exponent = rounded(number, spread, abs(size))
        factor = 10.0**exponent
        if size < 0:
            nominal = nominal.removeprefix("-") if nominal.startswith("-") else f"-{nominal}"
        shown = Markup("{} ± {}").format(
            self.mark(f"{place}.{value}", nominal, size * factor), self.mark(f"{place}.{u}", spread, abs(size) * factor)
        )
        return Markup("({}) × {}").format(shown, power_of_ten(factor)[1]) if exponent else shown

    def quantity(self, place: str, scale: Scale, value: str = "value") -> Markup:
        """Write a value with its uncertainty and its unit, to stay on one line: "(4.441 ± 0.023) × 10⁻³ kg·m²"."""
        number = self.pair(place, scale.size, value)
        if not scale.exponent:
            return _UNIT.format(Markup("{} {}").format(number, scale))
        return _UNIT.format(Markup("({}) × {}" if "±" in number else "{} × {}").format(number, scale))

    def interval(self, place: str, scale: Scale) -> Markup:
        """Write an interval with its unit: "4.396 to 4.486 × 10⁻³ kg·m²"."""
        low, high = self.at(place)
        low, high = interval_ends(low, high, scale.size)
        ends = self.mark(f"{place}.0", low, scale.size), self.mark(f"{place}.1", high, scale.size)
        form = "{} to {} × {}" if scale.exponent else "{} to {} {}"
        return _UNIT.format(Markup(form).format(*ends, scale))

    def percent(self, place: str, signed: bool = True) -> Markup:
        """Write a share or a relative size in per cent, two digits: "+0.36 %"; a dash for None."""
        value = self.at(place)
        if value is None:
            return NOTHING
        text = percent_text(value).removesuffix(" %")
        shown = text if signed else text.removeprefix("+")
        return _UNIT.format(Markup("{} %").format(self.mark(place, shown, 0.01)))

    def share(self, place: str) -> Markup:
        """Write a part of a whole in per cent, one digit behind the point."""
        percent = 100 * self.at(place)
        text = f"{percent:.1f}" if percent >= 0.05 else "< 0.1"
        return _UNIT.format(Markup("{} %").format(self.mark(place, text, 0.01)))

    def in_u(self, place: str, places: int = 1, unit: str = " u", signed: bool = True) -> Markup:
        """Write a size in standard uncertainties: "−2.5 u"; a dash for None."""
        value = self.at(place)
        if value is None:
            return NOTHING
        least = 10.0**-places
        if not signed and 0 < value < least / 2:
            return _UNIT.format(self.mark(place, f"< {least:g}") + unit)
        text = f"{abs(value):.{places if abs(value) < 10 else 0}f}"
        sign = "" if not signed or float(text) == 0 else "+" if value > 0 else "-"
        return _UNIT.format(self.mark(place, sign + text) + unit)

    def chance(self, place: str) -> Markup:
        """Write a probability: "p = 0.32", "p < 0.0001"."""
        p = self.at(place)
        text = "> 0.99" if p > 0.995 else p_text(p).removeprefix("p ").removeprefix("= ")
        equal = "" if text[0] in "<>" else "= "
        return _UNIT.format(Markup("<i>p</i> {}{}").format(equal, self.mark(place, text)))

    def turns(self, place: str) -> Markup:
        """Write a number of turns as a student would: "1/3"."""
        value = self.at(place)
        near = Fraction(value).limit_denominator(12)
        return self.mark(place, str(near) if abs(near - value) < 1e-6 * value else f"{value:.4g}")


def typeset(text: str) -> Markup:
    """Escape a text of the tool and set its symbols, I_zz and M0 with an index, and keep numbers with their units."""
    plain = re.sub(r"(?<=\d) (?=[^\W\d]|%|°)", "\N{NO-BREAK SPACE}", str(escape(text)))
    for symbol, shown in (("I_zz", "<i>I</i><sub>zz</sub>"), ("M0", "<i>M</i><sub>0</sub>")):
        plain = plain.replace(symbol, shown)
    return Markup(plain)
