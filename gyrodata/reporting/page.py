"""The report as one HTML page that needs nothing else.

A number becomes ``<data value="0.00444" data-from="inertia.value" data-size="0.001">4.44</data>``: the value as
results.json has it, where it stands there, and what one unit of the shown text is worth. Nothing is computed.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from markupsafe import Markup, escape

from gyrodata.reporting import content, tree, values
from gyrodata.results import Analysis

_STYLES = {
    "strong": "<strong>{}</strong>",
    "warn": '<strong class="warn">{}</strong>',
    "quote": "<q>{}</q>",
    "code": "<code>{}</code>",
}

# The figures' markers in a square of 12 by 12.
_SHAPES = {
    "o": "M6 1.4a4.6 4.6 0 1 0 .01 0z",
    "s": "M1.8 1.8h8.4v8.4H1.8z",
    "^": "M6 1 11.2 10.6H.8z",
    "v": "M6 11 11.2 1.4H.8z",
    "<": "M1 6 10.6.8v10.4z",
    "D": "M6 .4 11.6 6 6 11.6.4 6z",
    "P": "M4.2 1h3.6v3.2H11v3.6H7.8V11H4.2V7.8H1V4.2h3.2z",
    "X": "M3.5 1 6 3.5 8.5 1 11 3.5 8.5 6 11 8.5 8.5 11 6 8.5 3.5 11 1 8.5 3.5 6 1 3.5z",
}


def report_page(
    analysis: Analysis,
    figures: Mapping[str, bytes],
    form: Literal["png", "svg"],
    alt: Mapping[str, str],
    looks: Sequence[tuple[str, str, str]],
) -> str:
    """Write the report as one HTML page that needs nothing else.

    `figures` are the files of "period", "product", "torque" and "residuals", `alt` what each shows in words, `looks`
    label, colour and marker of each torque in them. The page has no clock time and no folder's name; whatever comes
    from the log is escaped, and every number says where in results.json it stands.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    write, whole = _Page(analysis.to_dict(), looks), content.report(analysis)
    kind = {"png": "image/png", "svg": "image/svg+xml"}[form]
    room = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=lambda name: name is not None and name.endswith(".html.jinja"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    room.filters |= {
        "sentence": write.sentence, "cell": write.cell, "sort_value": _sort_value, "typeset": _typeset, "draw": _draw,
        "kind": lambda block: type(block).__name__,
    }  # fmt: skip
    images = {name: f"data:{kind};base64,{base64.b64encode(data).decode()}" for name, data in figures.items()}
    title = f"{tree.sentence_text(whole.answer)} – {analysis.name}"
    page = room.get_template("report.html.jinja")
    return page.render(whole=whole, images=images, alt=alt, title=title).lstrip() + "\n"


class _Page:
    """Return the filters that write the parts of a report in HTML."""

    def __init__(self, document: Mapping[str, Any], looks: Sequence[tuple[str, str, str]]) -> None:
        self.document, self.looks = document, looks

    # --- numbers

    def at(self, place: str) -> Any:
        """Return the value at a place below "result", or below the top with a leading "/"; "length" counts a list."""
        found: Any = self.document if place.startswith("/") else self.document["result"]
        for key in place.removeprefix("/").split("."):
            if key == "length":
                return len(found)
            found = found[int(key) if isinstance(found, list) else key]
        return found

    def mark(self, text: str, place: str, size: float = 1.0) -> Markup:
        """Mark a text as the number, or the name, at a place."""
        found = self.at(place)
        # Formatted by Python itself, each text escaped by hand: a page has hundreds of numbers, cells and sentences.
        if isinstance(found, str):
            return Markup(f'<data value="{escape(found)}" data-from="{escape(place)}">{escape(text)}</data>')
        shown = escape(text.replace("-", "−"))
        return Markup(f'<data value="{found!r}" data-from="{escape(place)}" data-size="{size!r}">{shown}</data>')

    def number(self, value: tree.Value) -> Markup:
        """Write a value rounded to its uncertainty, without unit: "4.441 ± 0.023"."""
        size = value.scale.size
        # M0 is minus the constant of a line, which is what results.json has.
        signed = size if self.at(value.place) == value.value else -size
        if not value.u:
            return self.mark(value.without_u, value.place, signed)
        nominal, spread, exponent = values.rounded(value.value, value.u, size)
        factor = 10.0**exponent
        above, _, last = value.place.rpartition(".")
        beside = self.at(above) if above else self.at("inertia")
        key = f"{last}_u" if f"{last}_u" in beside else "u"
        number = self.mark(nominal, value.place, signed * factor)
        shown = f"{number} ± {self.mark(spread, f'{above}.{key}', size * factor)}"
        return Markup(f"({shown}) × {values.power_of_ten(factor)[1]}" if exponent else shown)

    # --- sentences

    def sentence(self, sentence: tree.Sentence) -> Markup:
        """Write a sentence."""
        done = []
        for before, part in pairwise(("", *sentence)):
            # A number stays on the line of its unit.
            if isinstance(before, tree.Number) and isinstance(part, str) and part.startswith(" "):
                part = f"\N{NO-BREAK SPACE}{part[1:]}"
            done.append(self.part(part))
        return Markup("".join(done))

    def part(self, part: tree.Part) -> Markup:
        """Write a part of a sentence."""
        if isinstance(part, tree.Number):
            return self.mark(part.text, part.place, part.size)
        if isinstance(part, tree.Value):
            number, unit = str(self.number(part)), str(part.scale)
            if part.scale.exponent:
                number = f"({number}) ×" if part.u else f"{number} ×"
            return Markup(f'<span class="q">{number}{" " * bool(unit)}{escape(unit)}</span>')
        if isinstance(part, tree.Interval):
            size, times = part.scale.size, " × " if part.scale.exponent else " "
            low, high = values.interval_ends(part.low, part.high, size)
            ends = self.mark(low, f"{part.place}.0", size), self.mark(high, f"{part.place}.1", size)
            return Markup('<span class="q">{} to {}{}{}</span>').format(*ends, times, part.scale)
        if isinstance(part, tree.Styled):
            return Markup(_STYLES[part.style]).format(part.text)
        if isinstance(part, tree.Mark):
            _, colour, marker = self.looks[part.group]
            shape = '<svg class="mark" viewBox="0 0 12 12" aria-hidden="true"><path fill="{}" d="{}"/></svg>'
            return Markup(shape).format(colour, _SHAPES[marker])
        return _typeset(part)

    def cell(self, cell: tree.Cell, head: tree.Head) -> Markup:
        """Write the content of a cell of a table."""
        if cell is None:
            return Markup("–" if head.scale else "")
        return self.number(cell) if isinstance(cell, tree.Value) else self.sentence(cell)


def _sort_value(cell: tree.Cell) -> Markup:
    """Give the attribute by which a table sorts the names of torques."""
    marks = [part for part in cell if isinstance(part, tree.Mark)] if isinstance(cell, tuple) else []
    return Markup(f' data-value="{marks[0].torque!r}"' if marks else "")


def _typeset(text: str) -> Markup:
    """Escape a text, set its symbols and keep numbers with their units."""
    plain = re.sub(
        r"(?<=\d) (?=[^\W\d]|%|°)|(?<=\b[ukpn]) (?==)|(?<=\b[ukpn] =) ", "\N{NO-BREAK SPACE}", str(escape(text))
    )
    plain = tree.SYMBOLS.sub(r"<i>\g<0></i>", plain.replace("I_zz", "<i>I</i><sub>zz</sub>"))
    return Markup(plain.replace("M0", "<i>M</i><sub>0</sub>"))


def _draw(picture: tree.Picture) -> list[Markup]:
    """Draw a picture for each row: a bar, or a dot with its uncertainty on one axis for all rows.

    Screen readers do not see them: the table's cells say the same in numbers.
    """
    if picture.band is None:
        bar = Markup('<span class="bar" style="width: {:.1f}%"></span>')
        return [bar.format(100 * value[0]) if value else Markup() for value in picture.values]
    reference = picture.band
    drawn = [value for value in picture.values if value is not None]
    low = min([reference[0], *(value - u for value, u in drawn)])
    high = max([reference[1], *(value + u for value, u in drawn)])
    if picture.reach is not None:
        farthest = picture.reach * (reference[1] - reference[0])
        low, high = max(low, reference[0] - farthest), min(high, reference[1] + farthest)
    space = 0.05 * (high - low) or 1.0
    low, high = low - space, high + space

    def mark(kind: str, start: float, end: float | None = None) -> Markup:
        start = min(max(start, low), high)
        width = "" if end is None else f";width:{100 * (min(max(end, low), high) - start) / (high - low):.1f}%"
        return Markup('<i class="{}" style="left:{:.1f}%{}"></i>').format(
            kind, 100 * (start - low) / (high - low), width
        )

    def shown(value: float, u: float) -> Markup:
        kind = "off left" if value < low else "off right" if value > high else "dot"
        return mark("bar", value - u, value + u) + mark(kind, value)

    behind = mark("ref", *reference) if reference[1] > reference[0] else mark("line", reference[0])
    return [behind + (shown(*value) if value else "") for value in picture.values]
