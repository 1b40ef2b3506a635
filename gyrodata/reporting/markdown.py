"""The report as Markdown: GitHub's, JupyterLab's and pandoc's."""

from __future__ import annotations

import re
import unicodedata

from gyrodata.reporting.content import (
    Cell,
    Head,
    Interval,
    Section,
    Sentence,
    Table,
    Value,
    answer,
    cell_text,
    head_text,
    part_text,
    sections,
    title,
)
from gyrodata.reporting.values import Writing
from gyrodata.results import Analysis

_ACTIVE = re.compile(r"[\\`*_{}\[\]<>#|~$&!@^]|:(?=[\w+-]+:)")
"""What could begin emphasis, code, a link, HTML, a table cell, mathematics, a name or a picture."""

_BLOCK_START = re.compile(r"^(?:([-+=])(?=[-+=\s]|$)|(\d{1,9})([.)])(?=\s|$))")
"""What would begin a list or underline a heading at the beginning of a line."""


def markdown_report(analysis: Analysis, writing: Writing = "plain") -> str:
    """Write the report as Markdown; whatever comes from the log is escaped."""
    blocks = [f"# {escape(title(analysis))}", f"**{_sentence(answer(analysis), writing)}**"]
    for section in sections(analysis):
        blocks += _section(section, writing)
    return "\n\n".join(blocks) + "\n"


def escape(text: str) -> str:
    """Make text stay text in Markdown, on one line."""
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
    text = part_text(part, writing)
    if not isinstance(part, str):
        return escape(text)
    # A sentence's parts touch: blanks at their ends are part of it.
    before, after = (" " if text[:1] == " " else ""), (" " if text[-1:] == " " else "")
    return f"{before}{escape(text)}{after}"


def _table(table: Table, writing: Writing) -> str:
    rows = [
        [escape(head_text(head)) for head in table.heads],
        ["---:" if head.scale else "---" for head in table.heads],
        *([_cell(cell, head, writing) for cell, head in zip(row, table.heads, strict=True)] for row in table.rows),
    ]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _cell(cell: Cell, head: Head, writing: Writing) -> str:
    if cell is None:
        return "–" if head.scale else ""
    return escape(cell_text(cell, writing)) if isinstance(cell, str) else cell_text(cell, writing)
