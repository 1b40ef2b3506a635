"""The pages of documentation: Markdown that comes with the package, and is read in a terminal or in a browser."""

from __future__ import annotations

import re
from pathlib import Path

PAGES = (
    "first-timer",
    "log-format",
    "theory",
    "statistics",
    "approximations",
    "instructors",
    "python",
    "pipelines",
)
"""Their names, in the order in which they are listed."""

WIDEST = 100
"""Longer lines [columns] are hard to read, however wide the terminal is."""


def page_text(name: str) -> str:
    """Give a page as Markdown."""
    return Path(__file__).with_name(f"{name}.md").read_text(encoding="utf-8")


def page_title(name: str) -> str:
    """Give the title of a page, its first line."""
    return page_text(name).partition("\n")[0].removeprefix("# ")


def for_terminal(markdown: str, width: int | None = None) -> str:
    """Format a page for a terminal of `width` columns, or of its own width."""
    from rich.console import Console
    from rich.markdown import Markdown
    from rich.theme import Theme

    # A black ground for names would stand out from a light one.
    plain = Theme({"markdown.code": "bold cyan"})
    console = Console(width=width, force_terminal=True, legacy_windows=False, theme=plain)
    console.width = min(console.width, WIDEST)
    # A terminal shows no pictures and follows no link to another page; comments are for tests.
    words = re.sub(r"^!\[.*\n|<!--.*?-->\n?", "", markdown, flags=re.MULTILINE)
    words = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", words)
    with console.capture() as captured:
        console.print(Markdown(words, code_theme="ansi_dark", hyperlinks=False))
    return "\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n"
