"""The report as Markdown: GitHub's, JupyterLab's and pandoc's."""

from __future__ import annotations

import re
import unicodedata

from gyrodata.reporting.content import Cell, Head, Interval, Section, Sentence, Table, Value, answer, sections, title
from gyrodata.reporting.values import Writing, interval_text, number_text, reading_text, uncertainty_text, value_text
from gyrodata.results import Analysis

_ACTIVE = re.compile(r"[\\`*_{}\[\]<>#|~$&!@^]|:(?=[\w+-]+:)")
"""What could begin emphasis, code, a link, HTML, a table cell, mathematics, a name or a picture."""

_BLOCK_START = re.compile(r"^(?:([-+=])(?=[-+=\s]|$)|(\d{1,9})([.)])(?=\s|$))")
"""What would begin a list or underline a heading at the beginning of a line."""


def markdown_report(analysis: Analysis, writing: Writing = "plain") -> str:
    """Write the report as Markdown.

    Parameters
    ----------
    analysis : Analysis
        The result.
    writing : {"plain", "short"}
        How values stand with their uncertainties.

    Returns
    -------
    str
        One heading, the answer, sections; whatever comes from the log is escaped.
    """
    blocks = [f"# {escape(title(analysis))}", f"**{_sentence(answer(analysis), writing)}**"]
    for section in sections(analysis):
        blocks += _section(section, writing)
    return "\n\n".join(blocks) + "\n"


def escape(text: str) -> str:
    """Make text stay text in Markdown.

    Parameters
    ----------
    text : str
        Whatever a log holds.

    Returns
    -------
    str
        One line; characters that are not for reading have become blanks.
    """
    line = " ".join("".join(" " if unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") else c for c in text).split())
    line = _ACTIVE.sub(lambda found: f"\\{found[0]}", line)
    return _BLOCK_START.sub(lambda found: f"\\{found[1]}" if found[1] else f"{found[2]}\\{found[3]}", line)


def _section(section: Section, writing: Writing) -> list[str]:
    blocks = [f"## {escape(section.title)}"] if section.title else []
    blocks += [_sentence(sentence, writing) for sentence in section.sentences]
    if section.table:
        blocks.append(_table(section.table, writing))
    if section.items:
        blocks.append("\n".join(f"- {_sentence(item, writing)}" for item in section.items))
    return blocks


def _sentence(sentence: Sentence, writing: Writing) -> str:
    return "".join(_part(part, writing) for part in sentence)


def _part(part: str | Value | Interval, writing: Writing) -> str:
    if isinstance(part, Value):
        return escape(value_text(part.value, part.u, part.scale, writing))
    if isinstance(part, Interval):
        times = " × " if part.scale.exponent else " "
        return f"{interval_text(part.low, part.high, part.scale.size)}{times}{part.scale}"
    # A sentence's parts touch: blanks at their ends are part of it.
    before, after = (" " if part[:1] == " " else ""), (" " if part[-1:] == " " else "")
    return f"{before}{escape(part)}{after}"


def _table(table: Table, writing: Writing) -> str:
    rows = [
        [_head(head) for head in table.heads],
        ["---:" if head.scale else "---" for head in table.heads],
        *([_cell(cell, head, writing) for cell, head in zip(row, table.heads, strict=True)] for row in table.rows),
    ]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _head(head: Head) -> str:
    unit = str(head.scale or "")
    return escape(f"{head.words} [{unit}]" if unit else head.words)


def _cell(cell: Cell, head: Head, writing: Writing) -> str:
    if cell is None:
        return "–" if head.scale else ""
    if isinstance(cell, str):
        return escape(cell)
    if cell.u:
        return number_text(cell.value, cell.u, cell.scale.size, writing)
    return (uncertainty_text if cell.is_u else reading_text)(cell.value, cell.scale.size)
