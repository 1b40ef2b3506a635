"""The report as one HTML page that needs nothing else.

A number becomes ``<data value="0.00444" data-from="inertia.value" data-size="0.001">4.44</data>``: the value as
results.json has it, where it stands there, and what one unit of the shown text is worth. Nothing is computed.
"""

from __future__ import annotations

import base64
import pkgutil
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, Literal

from markupsafe import Markup, escape

from gyrodata.reporting.content import report
from gyrodata.reporting.tree import (
    SYMBOLS,
    Block,
    Cell,
    Facts,
    Figure,
    Head,
    Interval,
    Mark,
    Number,
    Part,
    Picture,
    Section,
    Sentence,
    Styled,
    Table,
    Value,
    is_list,
    lines,
    sentence_text,
)
from gyrodata.reporting.values import interval_ends, power_of_ten, rounded
from gyrodata.results import Analysis

LONG = 25
"""A table with more rows than this may go over the edge of a printed page."""

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
    write = _Page(analysis.to_dict(), figures, form, alt, looks)
    whole = report(analysis)
    first, *sections = whole.sections
    links = [Markup('<a href="#{}">{}</a>').format(s.anchor, s.link) for s in sections if s.link]
    header = [
        Markup("<h1>{}</h1>").format(write.sentence(whole.title)),
        Markup('<p class="small">{}</p>').format(write.sentence(whole.read_as)),
        *(Markup('<p class="banner">{}</p>').format(write.sentence(doubt)) for doubt in whole.doubts),
        Markup('<p class="answer{}">{}</p>').format(" doubted" * bool(whole.doubts), write.sentence(whole.answer)),
        *write.blocks(first),
        Markup('<nav aria-label="Contents">{}</nav>').format(Markup(" ").join(links)),
    ]
    page = Markup(_read("report.html")).format(
        title=f"{sentence_text(whole.answer)} – {analysis.name}",
        style=Markup(_read("report.css")),
        header=Markup("\n").join(header),
        main=Markup("\n\n").join(write.section(section) for section in sections),
        script=Markup(_read("report.js")),
    )
    return str(page)


def _read(name: str) -> str:
    # `importlib.resources` takes a sixth of the page's time to load.
    data = pkgutil.get_data("gyrodata.reporting", name)
    assert data is not None, name
    return data.decode()


class _Page:
    """What makes HTML of the parts of a report."""

    def __init__(
        self,
        document: Mapping[str, Any],
        figures: Mapping[str, bytes],
        form: Literal["png", "svg"],
        alt: Mapping[str, str],
        looks: Sequence[tuple[str, str, str]],
    ) -> None:
        kind = {"png": "image/png", "svg": "image/svg+xml"}[form]
        self.document, self.alt, self.looks = document, alt, looks
        self.images = {name: f"data:{kind};base64,{base64.b64encode(data).decode()}" for name, data in figures.items()}

    # --- numbers

    def at(self, place: str) -> Any:
        """What stands at a place below "result", or below the top with a leading "/"; "length" counts a list."""
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

    def number(self, value: Value) -> Markup:
        """Write a value rounded to its uncertainty, without unit: "4.441 ± 0.023"."""
        size = value.scale.size
        # M0 is minus the constant of a line, which is what results.json has.
        signed = size if self.at(value.place) == value.value else -size
        if not value.u:
            return self.mark(value.without_u, value.place, signed)
        nominal, spread, exponent = rounded(value.value, value.u, size)
        factor = 10.0**exponent
        above, _, last = value.place.rpartition(".")
        beside = self.at(above) if above else self.at("inertia")
        key = f"{last}_u" if f"{last}_u" in beside else "u"
        number = self.mark(nominal, value.place, signed * factor)
        shown = f"{number} ± {self.mark(spread, f'{above}.{key}', size * factor)}"
        return Markup(f"({shown}) × {power_of_ten(factor)[1]}" if exponent else shown)

    # --- sentences

    def sentence(self, sentence: Sentence) -> Markup:
        """Write a sentence."""
        done = []
        for before, part in pairwise(("", *sentence)):
            # A number stays on the line of its unit.
            if isinstance(before, Number) and isinstance(part, str) and part.startswith(" "):
                part = f"\N{NO-BREAK SPACE}{part[1:]}"
            done.append(self.part(part))
        return Markup("".join(done))

    def part(self, part: Part) -> Markup:
        """Write a part of a sentence."""
        if isinstance(part, Number):
            return self.mark(part.text, part.place, part.size)
        if isinstance(part, Value):
            number, unit = str(self.number(part)), str(part.scale)
            if part.scale.exponent:
                number = f"({number}) ×" if part.u else f"{number} ×"
            return Markup(f'<span class="q">{number}{" " * bool(unit)}{escape(unit)}</span>')
        if isinstance(part, Interval):
            size, times = part.scale.size, " × " if part.scale.exponent else " "
            low, high = interval_ends(part.low, part.high, size)
            ends = self.mark(low, f"{part.place}.0", size), self.mark(high, f"{part.place}.1", size)
            return Markup('<span class="q">{} to {}{}{}</span>').format(*ends, times, part.scale)
        if isinstance(part, Styled):
            return Markup(_STYLES[part.style]).format(part.text)
        if isinstance(part, Mark):
            _, colour, marker = self.looks[part.group]
            shape = '<svg class="mark" viewBox="0 0 12 12" aria-hidden="true"><path fill="{}" d="{}"/></svg>'
            return Markup(shape).format(colour, _SHAPES[marker])
        return _typeset(part)

    # --- blocks

    def section(self, section: Section) -> Markup:
        """Write a section with its heading."""
        heading = Markup('<h{0} id="{1}">{2}</h{0}>').format(section.level, section.anchor, _typeset(section.title))
        if not section.blocks:
            return heading
        inside = Markup("\n").join([heading, *self.blocks(section)])
        return Markup('<section aria-labelledby="{}">\n{}\n</section>').format(section.anchor, inside)

    def blocks(self, section: Section) -> list[Markup]:
        """Write what stands below a heading."""
        return [self.block(block, section.anchor) for block in section.blocks]

    def block(self, block: Block, anchor: str) -> Markup:
        """Write a block; a table has the section's anchor as its class."""
        if isinstance(block, Table):
            return self.table(block, anchor)
        if isinstance(block, Facts):
            return self.facts(block, anchor)
        if isinstance(block, Figure):
            form = Markup('<figure><img src="{}" alt="{}"><figcaption>{}</figcaption></figure>')
            return form.format(self.images[block.name], self.alt[block.name], _typeset(block.caption))
        kind = {"result": ' class="result"', "small": ' class="soft small"'}.get(block.kind, "")
        tag = "li" if is_list(block) else "p"
        found = Markup("\n").join(
            Markup("<{0}{1}>{2}</{0}>").format(tag, Markup(kind), self.sentence(line)) for line in lines(block)
        )
        outer = {"list": "ul", "numbered": "ol"}.get(block.kind)
        return Markup("<{0}>\n{1}\n</{0}>").format(outer, found) if outer else found

    def facts(self, block: Facts, anchor: str) -> Markup:
        """Write facts: as cards below the answer, else as a list of terms."""
        form = Markup("<dt>{}</dt><dd>{}</dd>") if anchor else Markup("<div><dt>{}</dt><dd>{}</dd></div>")
        rows = []
        for fact in block.facts:
            words = fact.words if anchor else f"{fact.words[0].upper()}{fact.words[1:]}"
            symbol = Markup(" <i>{}</i>").format(_typeset(fact.symbol)) if fact.symbol else ""
            remark = Markup(" <small>{}</small>").format(self.sentence(fact.remark)) if fact.remark else ""
            rows.append(form.format(escape(words) + symbol, self.sentence(fact.says) + remark))
        return Markup("<dl{}>\n{}\n</dl>").format(Markup("" if anchor else ' class="facts"'), Markup("\n").join(rows))

    def table(self, table: Table, anchor: str) -> Markup:
        """Write a table that scrolls sideways in a box of its own."""
        picture = table.picture
        drawn = [] if picture is None else _draw(picture)
        caption = table.caption + (f"; {picture.caption}" if picture and picture.caption else "")
        caption += "; a click on a head sorts by that column" if table.sortable else ""
        shown = None if picture is None else [head.words for head in table.heads].index(picture.column)
        heads = [self.head(head) for head in table.heads]
        rows = []
        for i, row in enumerate(table.rows):
            kind = ' class="main"' if i == table.main else ' class="flagged"' if i in table.odd else ""
            cells = [self.cell(cell, head, j == 0) for j, (cell, head) in enumerate(zip(row, table.heads, strict=True))]
            if shown is not None:
                cells.insert(shown + 1, Markup('<td class="picture" aria-hidden="true">{}</td>').format(drawn[i]))
            rows.append(Markup(f"<tr{kind}>{Markup().join(cells)}</tr>"))
        if shown is not None:
            heads.insert(shown + 1, Markup('<td class="picture" aria-hidden="true"></td>'))
        kind = " ".join([anchor, *(["sortable"] if table.sortable else []), *(["long"] if len(rows) > LONG else [])])
        return Markup(
            '<div class="box" role="region" aria-label="{}" tabindex="0"><table class="{}">\n'
            "<caption><span>{}</span></caption>\n<thead><tr>{}</tr></thead>\n<tbody>\n{}\n</tbody>\n</table></div>"
        ).format(caption, kind, _typeset(caption), Markup().join(heads), Markup("\n").join(rows))

    def head(self, head: Head) -> Markup:
        """Write the head of a column."""
        kind, unit = (' class="n"', str(head.scale)) if head.scale else ("", "")
        unit = f' <span class="q">[{_typeset(unit)}]</span>' if unit else ""
        return Markup(f'<th scope="col"{kind}>{_typeset(head.words)}{unit}</th>')

    def cell(self, cell: Cell, head: Head, first: bool) -> Markup:
        """Write a cell: a number to the right, long text in several lines."""
        if cell is None:
            shown = Markup("–" if head.scale else "")
        else:
            shown = self.number(cell) if isinstance(cell, Value) else self.sentence(cell)
        kind = "n" if head.scale else "q" if head.wrap < 0.15 else "w" if cell and not first else ""
        sort_by = [part.torque for part in cell if isinstance(part, Mark)] if isinstance(cell, tuple) else []
        attributes = f' class="{kind}"' if kind else ""
        if sort_by and not first:
            attributes += f' data-value="{sort_by[0]!r}"'
        return Markup(f'<th scope="row"{attributes}>{shown}</th>' if first else f"<td{attributes}>{shown}</td>")


def _typeset(text: str) -> Markup:
    """Escape a text, set its symbols and keep numbers with their units."""
    plain = re.sub(
        r"(?<=\d) (?=[^\W\d]|%|°)|(?<=\b[ukpn]) (?==)|(?<=\b[ukpn] =) ", "\N{NO-BREAK SPACE}", str(escape(text))
    )
    plain = SYMBOLS.sub(r"<i>\g<0></i>", plain.replace("I_zz", "<i>I</i><sub>zz</sub>"))
    return Markup(plain.replace("M0", "<i>M</i><sub>0</sub>"))


def _draw(picture: Picture) -> list[Markup]:
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
