"""The report as one HTML page that needs nothing else, and the files of a report.

A number becomes ``<data value="0.00444" data-from="inertia.value"
data-size="0.001">4.44</data>``: the value in results.json, its place there, and the
value of a displayed 1.
"""

from __future__ import annotations

import base64
import math
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Literal

from markupsafe import Markup, escape

from gyrodata.reporting import content
from gyrodata.reporting.data import json_text, table_header, table_rows, templates
from gyrodata.reporting.elements import (
    SYMBOLS,
    Head,
    Mark,
    Number,
    Numbers,
    Part,
    Sentence,
    Styled,
    plain,
)
from gyrodata.reporting.figure_data import list_looks
from gyrodata.reporting.figures import Form, alt_text, figures_of, render_all
from gyrodata.reporting.latex import latex_report
from gyrodata.reporting.markdown import markdown_report
from gyrodata.results import Analysis

_STYLES = {
    "strong": "<strong>{}</strong>",
    "quote": "<q>{}</q>",
    "code": "<code>{}</code>",
}
_STYLES["warn"] = '<strong class="warn">{}</strong>'

_SHAPES = dict(zip("os^v<DPX", "●■▲▼◀◆✚✖", strict=True))
"""Characters that look like the figures' markers."""

FARTHEST = 5.0
"""A drawn value is cut off if it is further from the band than this many widths of the
band."""


def report_page(
    analysis: Analysis,
    figures: Mapping[str, bytes],
    alt: Mapping[str, str],
    looks: Sequence[tuple[str, str, str]],
) -> str:
    """Write the report as one HTML page that needs nothing else.

    Parameters
    ----------
    analysis : Analysis
    figures : mapping of str to bytes
        The SVG files of "period", "product", "torque" and "residuals".
    alt : mapping of str to str
        What each figure shows, in words.
    looks : sequence of (str, str, str)
        Label, colour and marker of each torque in the figures.

    Returns
    -------
    str
        Text from the log is escaped; there is no clock time and no name of a folder in
        it.
    """
    write = _Writer(analysis, looks)
    whole = content.report(analysis)
    room = templates(Path(__file__).parent)
    room.filters |= {"sentence": write.sentence, "typeset": _typeset, "draw": _draw}
    images = {
        name: f"data:image/svg+xml;base64,{base64.b64encode(data).decode()}"
        for name, data in figures.items()
    }
    title = f"{plain(whole.answer)} – {analysis.name}"
    page = room.get_template("report.html.jinja")
    return page.render(whole=whole, images=images, alt=alt, title=title).lstrip() + "\n"


class _Writer:
    """Write the parts of a report in HTML."""

    def __init__(
        self, analysis: Analysis, looks: Sequence[tuple[str, str, str]]
    ) -> None:
        self.numbers = Numbers(analysis)
        self.looks = looks

    def number(self, number: Number) -> Markup:
        """Write a number with links to its places in results.json."""
        texts = []
        for text, place in zip(number.shown, number.places, strict=True):
            in_json = self.numbers.find(place)
            shown = escape(text)
            size = ""
            if not isinstance(in_json, str):
                shown = escape(text.replace("-", "−"))
                size = f' data-size="{number.size!r}"'
            value = escape(in_json if isinstance(in_json, str) else repr(in_json))
            texts.append(
                f'<data value="{value}" data-from="{place}"{size}>{shown}</data>'
            )
        written = number.write(texts)
        return Markup(
            f'<span class="q">{written}</span>'
            if number.unit and number.scale.unit
            else written
        )

    def sentence(self, sentence: Sentence) -> Markup:
        """Write a sentence."""
        done = []
        for before, part in pairwise(("", *sentence)):
            # A number stays on the line of its noun.
            if (
                isinstance(before, Number)
                and isinstance(part, str)
                and part.startswith(" ")
            ):
                part = f"\N{NO-BREAK SPACE}{part[1:]}"
            done.append(self.part(part))
        return Markup("".join(done))

    def part(self, part: Part) -> Markup:
        """Write a part of a sentence."""
        if isinstance(part, Number):
            return self.number(part)
        if isinstance(part, Styled):
            return Markup(_STYLES[part.style]).format(part.text)
        if isinstance(part, Mark):
            _, colour, marker = self.looks[part.group]
            shape = Markup(
                '<span class="mark" style="color: {}" aria-hidden="true">{}</span>'
            )
            return shape.format(colour, _SHAPES[marker])
        return _typeset(part)


def _typeset(text: str) -> Markup:
    """Escape a text, set its symbols and keep numbers with their units."""
    spaces = r"(?<=\d) (?=[^\W\d]|%|°)|(?<=\b[ukpn]) (?==)|(?<=\b[ukpn] =) "
    text = re.sub(spaces, "\N{NO-BREAK SPACE}", str(escape(text)))
    text = SYMBOLS.sub(r"<i>\g<0></i>", text.replace("I_zz", "<i>I</i><sub>zz</sub>"))
    return Markup(text.replace("M0", "<i>M</i><sub>0</sub>"))


def _draw(head: Head) -> list[Markup]:
    """Draw the values of a column, one drawing for each row.

    The drawings are bars, or dots with their u on one axis.

    Screen readers skip the drawings, because the cells contain the same numbers.
    """
    if head.band is None:
        bar = Markup('<span class="bar" style="width: {:.1f}%"></span>')
        return [
            bar.format(100 * value[0]) if value else Markup() for value in head.dots
        ]
    start, end = head.band
    ends = [start, end]
    for value, u in filter(None, head.dots):
        ends += [value - u, value + u]
    reach = FARTHEST * (end - start) or math.inf
    low = max(min(ends), start - reach)
    high = min(max(ends), end + reach)
    space = 0.05 * (high - low) or 1.0

    def percent(place: float) -> float:
        part = (place - low + space) / (high - low + 2 * space)
        return 100 * min(max(part, 0.0), 1.0)

    def box(kind: str, left: float, right: float) -> Markup:
        style = '<i class="{}" style="left:{:.1f}%;width:{:.1f}%"></i>'
        begin = percent(left)
        return Markup(style).format(kind, begin, percent(right) - begin)

    drawn = []
    behind = box("ref" if end > start else "line", start, end)
    for dot in head.dots:
        boxes = behind
        if dot:
            value, u = dot
            boxes += box("bar", value - u, value + u)
            if low <= value <= high:
                boxes += box("dot", value, value)
        drawn.append(boxes)
    return drawn


# The files of a report, made in memory
# ----------------------------------------------------------------------------


def report_files(
    analysis: Analysis,
    figures: Form = "svg",
    style: str = "screen",
    document: str = "",
    faults: dict[str, str] | None = None,
) -> dict[str, bytes]:
    """Make every file of the report, so that an error leaves no half of it behind.

    Parameters
    ----------
    analysis : Analysis
    figures : {"png", "svg", "pdf"}
        File type of the figures next to the page, which contains them as SVG.
    style : {"screen", "print"}
        Of the figures.
    document : str
        Name of a document that ends in .md or .tex, if there is one.
    faults : dict, optional
        Receives why figures cannot be drawn, by their names; words take their places.
        Without it, an error is raised.

    Returns
    -------
    dict of str to bytes
        The contents by name of the file.
    """
    forms: set[Form] = {figures}
    # Markdown shows no PDF, and LaTeX includes no SVG.
    if document.endswith(".md"):
        forms.add(shown_form(figures))
    elif document and figures == "svg":
        forms.add("pdf")
    drawn = render_all(analysis, sorted({"svg", *forms}), style, faults=faults)
    alt = alternatives(analysis)
    texts = {
        "report.html": report_page(analysis, drawn["svg"], alt, list_looks(analysis)),
        "results.json": json_text(analysis.to_dict()),
        "runs.csv": table_header("runs") + table_rows(analysis, "runs"),
    }
    if document:
        is_markdown = document.endswith(".md")
        texts[document] = (
            markdown_report(analysis, f"{{}}.{shown_form(figures)}", alt)
            if is_markdown
            else latex_report(analysis)
        )
    files = {
        f"{name}.{form}": data
        for form in sorted(forms)
        for name, data in drawn[form].items()
    }
    return files | {name: text.encode() for name, text in texts.items()}


def shown_form(figures: Form) -> Literal["png", "svg"]:
    """Choose what a reader of Markdown shows: no PDF."""
    return "png" if figures == "png" else "svg"


def alternatives(analysis: Analysis) -> dict[str, str]:
    """Describe each figure in words."""
    return {name: alt_text(analysis, name) for name in figures_of(analysis)}
