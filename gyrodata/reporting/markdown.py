"""The report as Markdown: GitHub's, JupyterLab's and pandoc's."""

from __future__ import annotations

import re

from gyrodata.reporting.content import report
from gyrodata.reporting.data import filled
from gyrodata.reporting.elements import Part, Sentence, Styled, one_line
from gyrodata.reporting.figures import alternatives
from gyrodata.results import Analysis

_ACTIVE = re.compile(
    r"[\\`*{}\[\]<>#|~$&!@^]|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])|:(?=[\w+-]+:)"
)
"""What could begin emphasis, code, a link, HTML, a table cell, mathematics, a name or a
picture."""

_BLOCK_START = re.compile(r"^(\d{1,9}|)((?<!\d)[-+=](?=[-+=\s]|$)|(?<=\d)[.)](?=\s|$))")
"""What would begin a list or underline a heading at the beginning of a line."""


def markdown_report(analysis: Analysis, figures: str = "{}.png") -> str:
    """Write the report as Markdown; text from the log is escaped.

    Parameters
    ----------
    analysis : Analysis
    figures : str
        Path of a figure, with {} for its name.

    Returns
    -------
    str
    """
    return filled(
        "report.md.jinja",
        {"sentence": _sentence, "text": escape},
        whole=report(analysis),
        figures=figures,
        alt=alternatives(analysis),
    )


def escape(text: str) -> str:
    """Write text as one line of Markdown that has no other meaning."""
    return _as_line(_inside(text))


def _sentence(sentence: Sentence) -> str:
    return _as_line("".join(map(_part, sentence)))


def _part(part: Part) -> str:
    text = str(part)
    is_code = isinstance(part, Styled) and part.style == "code"
    if is_code and "`" not in text:
        return f"`{text}`"
    return _inside(text)


def _inside(text: str) -> str:
    """Escape what has a meaning inside a line."""
    return _ACTIVE.sub(r"\\\g<0>", one_line(text))


def _as_line(text: str) -> str:
    """Escape what has a meaning at the beginning of a line."""
    return _BLOCK_START.sub(r"\g<1>\\\g<2>", text.strip())
