"""The report as Markdown: GitHub's, JupyterLab's and pandoc's."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping

from msgspec import Struct

from gyrodata.errors import PICTURES
from gyrodata.reporting import tree
from gyrodata.reporting.content import report
from gyrodata.results import Analysis

_ACTIVE = re.compile(r"[\\`*_{}\[\]<>#|~$&!@^]|:(?=[\w+-]+:)")
"""What could begin emphasis, code, a link, HTML, a table cell, mathematics, a name or a picture."""

_BLOCK_START = re.compile(r"^(?:([-+=])(?=[-+=\s]|$)|(\d{1,9})([.)])(?=\s|$))")
"""What would begin a list or underline a heading at the beginning of a line."""


def markdown_report(analysis: Analysis, figures: str = "{}.png", alt: Mapping[str, str] | None = None) -> str:
    """Write the report as Markdown; whatever comes from the log is escaped.

    `figures` is where a figure stands, with {} for its name: beside the report as a PNG, if not given. `alt` has
    for each name what the figure shows in words.
    """
    whole, write = report(analysis), _Markdown(figures, alt or {})
    blocks = [f"# {write.sentence(whole.title)}", write.sentence(whole.read_as)]
    blocks += [f"**{write.sentence(doubt)}**" for doubt in whole.doubts]
    answer = write.sentence(whole.answer)
    # An unreliable answer is not bold.
    blocks.append(answer if whole.doubts else f"**{answer}**")
    for section in whole.sections:
        blocks += [f"{'#' * section.level} {escape(section.title)}"] if section.title else []
        blocks += [line for block in section.blocks for line in write.block(block)]
    return "\n\n".join(blocks) + "\n"


def escape(text: str) -> str:
    """Make text stay text in Markdown, on one line."""
    blank = "".join(" " if unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") else c for c in text)
    line = " ".join(blank.translate(PICTURES).split())
    line = _ACTIVE.sub(lambda found: f"\\{found[0]}", line)
    return _BLOCK_START.sub(lambda found: f"\\{found[1]}" if found[1] else f"{found[2]}\\{found[3]}", line)


class _Markdown(Struct, frozen=True):
    """Return the writers of the parts of a report in Markdown."""

    figures: str
    alt: Mapping[str, str]

    def block(self, block: tree.Block) -> list[str]:
        """Write a block as paragraphs."""
        if isinstance(block, tree.Table):
            return [f"{escape(block.caption)}:", self.table(block)]
        if isinstance(block, tree.Figure):
            shows, place = escape(self.alt.get(block.name, block.name)), self.figures.format(block.name)
            return [f"![{shows}]({place})", f"*{escape(block.caption)}*"]
        found = [self.sentence(line) for line in tree.lines(block)]
        return ["\n".join(f"- {line}" for line in found)] if tree.is_list(block) else found

    def sentence(self, sentence: tree.Sentence) -> str:
        """Write a sentence; the text between two pieces of code is escaped as a whole."""
        done, text = "", ""
        for part in sentence:
            if isinstance(part, tree.Styled) and part.style == "code" and "`" not in part.text:
                done += f"{_inside(text)}`{part.text}`"
                text = ""
            else:
                text += tree.part_text(part)
        return f"{done}{_inside(text)}".strip()

    def table(self, table: tree.Table) -> str:
        """Write a table in pipes."""
        rows = [
            [escape(tree.head_text(head)) for head in table.heads],
            ["---:" if head.scale else "---" for head in table.heads],
            *([self.cell(cell, head) for cell, head in zip(row, table.heads, strict=True)] for row in table.rows),
        ]
        return "\n".join(f"| {' | '.join(row)} |" for row in rows)

    def cell(self, cell: tree.Cell, head: tree.Head) -> str:
        """Write a cell."""
        if cell is None:
            return "–" if head.scale else ""
        return escape(tree.cell_text(cell))


def _inside(text: str) -> str:
    """Make text stay text inside a line, with a blank where one stood at its ends."""
    return f"{' ' * text.startswith(' ')}{escape(text)}{' ' * text.endswith(' ')}"
