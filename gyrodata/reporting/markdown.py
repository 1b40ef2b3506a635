"""The report as Markdown: GitHub's, JupyterLab's and pandoc's."""

from __future__ import annotations

import re
import unicodedata

from gyrodata.reporting.content import (
    Block,
    Cell,
    Head,
    Section,
    Sentence,
    Table,
    cell_text,
    head_text,
    is_list,
    lines,
    part_text,
    report,
)
from gyrodata.reporting.values import Writing
from gyrodata.results import Analysis

_ACTIVE = re.compile(r"[\\`*_{}\[\]<>#|~$&!@^]|:(?=[\w+-]+:)")
"""What could begin emphasis, code, a link, HTML, a table cell, mathematics, a name or a picture."""

_BLOCK_START = re.compile(r"^(?:([-+=])(?=[-+=\s]|$)|(\d{1,9})([.)])(?=\s|$))")
"""What would begin a list or underline a heading at the beginning of a line."""


def markdown_report(analysis: Analysis, writing: Writing = "plain") -> str:
    """Write the report as Markdown; whatever comes from the log is escaped."""
    whole = report(analysis)
    blocks = [f"# {_sentence(whole.title, writing)}", _sentence(whole.read_as, writing)]
    blocks += [f"**{_sentence(doubt, writing)}**" for doubt in whole.doubts]
    answer = _sentence(whole.answer, writing)
    # What is not to be relied on is not set in bold.
    blocks.append(answer if whole.doubts else f"**{answer}**")
    for section in whole.sections:
        blocks += _section(section, writing)
    return "\n\n".join(blocks) + "\n"


def escape(text: str) -> str:
    """Make text stay text in Markdown, on one line."""
    line = " ".join("".join(" " if unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") else c for c in text).split())
    line = _ACTIVE.sub(lambda found: f"\\{found[0]}", line)
    return _BLOCK_START.sub(lambda found: f"\\{found[1]}" if found[1] else f"{found[2]}\\{found[3]}", line)


def _section(section: Section, writing: Writing) -> list[str]:
    blocks = [f"{'#' * section.level} {escape(section.title)}"] if section.title else []
    return blocks + [line for block in section.blocks for line in _block(block, writing)]


def _block(block: Block, writing: Writing) -> list[str]:
    if isinstance(block, Table):
        return [f"{escape(block.caption)}:", _table(block, writing)]
    found = [_sentence(line, writing) for line in lines(block)]
    return ["\n".join(f"- {line}" for line in found)] if is_list(block) else found


def _sentence(sentence: Sentence, writing: Writing) -> str:
    return escape("".join(part_text(part, writing) for part in sentence))


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
    return escape(cell_text(cell, writing))
