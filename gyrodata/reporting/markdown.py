"""The report as Markdown: GitHub's, JupyterLab's and pandoc's."""

from __future__ import annotations

import re
from collections.abc import Mapping

from gyrodata.base.errors import shown
from gyrodata.reporting.content import report
from gyrodata.reporting.elements import Part, Picture, Sentence, Styled, Table, join
from gyrodata.results import Analysis

_ACTIVE = re.compile(
    r"[\\`*{}\[\]<>#|~$&!@^]|(?<![A-Za-z0-9])_|_(?![A-Za-z0-9])|:(?=[\w+-]+:)"
)
"""What could begin emphasis, code, a link, HTML, a table cell, mathematics, a name or a
picture."""

_BLOCK_START = re.compile(r"^(?:([-+=])(?=[-+=\s]|$)|(\d{1,9})([.)])(?=\s|$))")
"""What would begin a list or underline a heading at the beginning of a line."""


def markdown_report(
    analysis: Analysis, figures: str = "{}.png", alt: Mapping[str, str] | None = None
) -> str:
    """Write the report as Markdown; text from the log is escaped.

    Parameters
    ----------
    analysis : Analysis
    figures : str
        Path of a figure, with {} for its name.
    alt : mapping of str to str, optional
        What each figure shows, in words.

    Returns
    -------
    str
    """
    whole = report(analysis)
    blocks = [
        f"# {_sentence(whole.title)}",
        _sentence(whole.byline),
        _sentence(whole.read_as),
    ]
    # An unreliable answer is not bold, but the doubts about it are.
    answer = _sentence(whole.answer)
    blocks.append(answer if whole.doubts else f"**{answer}**")
    blocks += [f"**{_sentence(doubt)}**" for doubt in whole.doubts]
    blocks += map(_sentence, whole.warnings)
    for heading, contents in (
        ("", whole.top),
        *((f"## {escape(one.title)}", one.blocks) for one in whole.sections),
    ):
        blocks.append(heading)
        for block in contents:
            if isinstance(block, Table):
                blocks += [f"{escape(block.caption)}:", _table(block)]
            elif isinstance(block, Picture):
                shows = escape((alt or {}).get(block.name, block.name))
                blocks += [
                    f"![{shows}]({figures.format(block.name)})",
                    f"*{escape(block.caption)}*",
                ]
            elif block.is_list:
                blocks.append(
                    "\n".join(f"- {_sentence(line)}" for line in block.sentences)
                )
            else:
                blocks += map(_sentence, block.sentences)
    return "\n\n".join(filter(None, blocks)) + "\n"


def escape(text: str) -> str:
    """Write text as one line of Markdown that has no other meaning."""
    line = _ACTIVE.sub(lambda found: f"\\{found[0]}", shown(text))
    return _BLOCK_START.sub(
        lambda found: f"\\{found[1]}" if found[1] else f"{found[2]}\\{found[3]}", line
    )


def _sentence(sentence: Sentence) -> str:
    return join(sentence, escape, _code)


def _code(part: Part) -> str | None:
    return (
        f"`{part}`"
        if isinstance(part, Styled) and part.style == "code" and "`" not in part.text
        else None
    )


def _table(table: Table) -> str:
    rows = [
        [escape(str(head)) for head in table.heads],
        ["---:" if head.scale else "---" for head in table.heads],
        *(map(_sentence, row) for row in table.rows),
    ]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
