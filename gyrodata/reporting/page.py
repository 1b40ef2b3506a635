"""The report as one HTML page that needs nothing else, and the files of a report.

A number becomes ``<data value="0.00444" data-from="inertia.value"
data-size="0.001">4.44</data>``: the value in results.json, its place there, and the
value of a displayed 1.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

from markupsafe import Markup, escape
from msgspec import Struct

from gyrodata.fitting.inertia import Estimate
from gyrodata.reporting import content
from gyrodata.reporting.data import filled, json_text, table_header, table_rows
from gyrodata.reporting.elements import (
    SYMBOLS,
    Mark,
    Number,
    Numbers,
    Sentence,
    Styled,
    Table,
    plain,
)
from gyrodata.reporting.figure_data import Look, list_groups
from gyrodata.reporting.figures import Form, alternatives, render
from gyrodata.reporting.latex import latex_report
from gyrodata.reporting.markdown import markdown_report
from gyrodata.results import Analysis

_STYLES = {
    "strong": "<strong>{}</strong>",
    "typed": "{}",
    "quote": "<q>{}</q>",
    "code": "<code>{}</code>",
    "warn": '<strong class="warn">{}</strong>',
}

_SHAPES = dict(zip("os^v<DPX", "●■▲▼◀◆✚✖", strict=True))
"""Characters that look like the figures' markers."""

BOX = '<i class="{}" style="left:{:.1f}%;width:{:.1f}%"></i>'
BAR = '<span class="bar" style="width: {:.1f}%"></span>'
MARK = '<span class="mark" style="color: {}" aria-hidden="true">{}</span>'

REACH = 10.0
"""The drawings of a column end at this many u of the value that they compare with."""


def report_page(analysis: Analysis, figures: Mapping[str, bytes]) -> str:
    """Write the report as one HTML page that needs nothing else.

    Parameters
    ----------
    analysis : Analysis
    figures : mapping of str to bytes
        The SVG files of `figures.FIGURES`, by name.
        A figure that is missing is replaced by words.

    Returns
    -------
    str
        Text from the log is escaped; there is no clock time and no name of a folder in
        it.
    """
    whole = content.report(analysis)
    looks = [group.look for group in list_groups(whole.numbers)]
    write = _Writer(whole.numbers, looks)
    filters = {
        "sentence": write.sentence,
        "typeset": _typeset,
        "pictures": write.pictures,
    }
    images = {}
    for name, data in figures.items():
        in_letters = base64.b64encode(data).decode()
        images[name] = f"data:image/svg+xml;base64,{in_letters}"
    alt = alternatives(analysis)
    title = f"{plain(whole.answer)} – {analysis.name}"
    folder = Path(__file__).parent
    style = (folder / "report.css").read_text("utf-8")
    script = (folder / "report.js").read_text("utf-8")
    return filled(
        "report.html.jinja",
        filters,
        whole=whole,
        images=images,
        alt=alt,
        title=title,
        style=Markup(style),
        script=Markup(script),
    )


class _Writer(Struct):
    """Write the parts of a report in HTML."""

    numbers: Numbers
    looks: Sequence[Look]

    def number(self, number: Number) -> str:
        """Write a number with links to its places in results.json."""
        texts = []
        for text, place in zip(number.shown, number.places, strict=True):
            value = self.numbers.find(place)
            size = ""
            if not isinstance(value, str):
                size = f' data-size="{number.size!r}"'
                text = text.replace("-", "−")
            start = f'<data value="{escape(value)}" data-from="{place}"{size}>'
            texts.append(f"{start}{escape(text)}</data>")
        written = number.write(texts)
        if number.unit and number.scale.unit:
            return f'<span class="q">{written}</span>'
        return written

    def sentence(self, sentence: Sentence) -> Markup:
        """Write a sentence."""
        written = []
        after_number = False
        for part in sentence:
            if after_number and isinstance(part, str) and part.startswith(" "):
                # A number stays on the line of its noun.
                part = f"\N{NO-BREAK SPACE}{part[1:]}"
            after_number = isinstance(part, Number)
            if isinstance(part, Number):
                written.append(self.number(part))
            elif isinstance(part, Styled):
                written.append(_STYLES[part.style].format(escape(part.text)))
            elif isinstance(part, Mark):
                look = self.looks[part.group]
                written.append(MARK.format(look.colour, _SHAPES[look.marker]))
            else:
                written.append(_typeset(part))
        return Markup("".join(written))

    def pictures(self, table: Table) -> list[list[Markup]]:
        """Draw the cells of each column that has drawings; [] for other columns.

        Screen readers skip the drawings, because the cells contain the same numbers.
        """
        drawn = []
        for head, *cells in zip(table.heads, *table.rows, strict=True):
            pictures = []
            if head.bars or head.compared:
                pictures = _drawn([*map(self._values, cells)], head.compared)
            drawn.append(pictures)
        return drawn

    def _values(self, cell: Sentence) -> list[float]:
        """Return the value of a cell and its u, if it has one; [] without a number."""
        for part in cell:
            if isinstance(part, Number):
                return [*map(self.numbers.find, part.places)]
        return []


def _drawn(
    values: Sequence[Sequence[float]], compared: Estimate | None
) -> list[Markup]:
    """Draw shares as bars, or values as dots with their u on a common axis.

    `values` contains a share, or a value with its u; [] for a cell without a number.
    """
    if compared is None:
        return [Markup(BAR.format(100 * share)) for (share,) in values]
    middle, unit = compared.value, compared.u
    if not unit:
        return [Markup()] * len(values)
    away = [abs(value - middle) + sum(u) for value, *u in filter(None, values)]
    axis = min(max(unit, *away), REACH * unit)
    drawn = []
    for cell in values:
        boxes = _box("ref", 0.0, unit, axis)
        if cell:
            value, *u = cell
            boxes += _box("bar", value - middle, sum(u), axis)
            if abs(value - middle) <= axis:
                boxes += _box("dot", value - middle, 0.0, axis)
        drawn.append(Markup(boxes))
    return drawn


def _box(kind: str, middle: float, half: float, axis: float) -> str:
    """Draw a box around a distance, on an axis from −`axis` to `axis`."""
    ends = middle - half, middle + half
    low, high = [min(max(end / axis, -1.0), 1.0) for end in ends]
    return BOX.format(kind, 50 + 50 * low, 50 * (high - low))


def _typeset(text: str) -> Markup:
    """Escape a text, set its symbols and keep numbers with their units."""
    spaces = r"(?<=\d) (?=[^\W\d]|%|°)|(?<=\b[ukpn]) (?==)|(?<=\b[ukpn] =) "
    text = re.sub(spaces, "\N{NO-BREAK SPACE}", str(escape(text)))
    text = SYMBOLS.sub(r"<i>\g<0></i>", text.replace("I_zz", "<i>I</i><sub>zz</sub>"))
    return Markup(text.replace("M0", "<i>M</i><sub>0</sub>"))


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
    drawn = render(analysis, sorted({"svg", *forms}), style, faults=faults)
    texts = {
        "report.html": report_page(analysis, drawn["svg"]),
        "results.json": json_text(analysis.to_dict()),
        "runs.csv": table_header("runs") + table_rows(analysis, "runs"),
    }
    if document.endswith(".md"):
        place = f"{{}}.{shown_form(figures)}"
        texts[document] = markdown_report(analysis, place)
    elif document:
        texts[document] = latex_report(analysis)
    files = {name: text.encode() for name, text in texts.items()}
    for form in sorted(forms):
        for name, data in drawn[form].items():
            files[f"{name}.{form}"] = data
    return files


def shown_form(figures: Form) -> Literal["png", "svg"]:
    """Choose what a reader of Markdown shows: no PDF."""
    return "png" if figures == "png" else "svg"
