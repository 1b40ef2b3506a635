"""``gyro explain``: pages of documentation, codes, words, and keys of a log."""

from __future__ import annotations

import sys
from pathlib import Path
from textwrap import fill, indent
from typing import Annotated, NoReturn

import typer

from gyrodata.base.diagnostics import explanations
from gyrodata.base.errors import PICTURES
from gyrodata.cli.documentation import (
    COMMANDS,
    PAGES,
    for_terminal,
    page_text,
    page_title,
)
from gyrodata.cli.options import settings_file
from gyrodata.cli.terminal import refuse, write_text


def _topics() -> list[str]:
    """List the pages and codes, for a shell that completes commands."""
    return [*PAGES, *explanations()]


def explain(
    topics: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="PAGE | CODE | WORD | KEY",
            autocompletion=_topics,
            help="A page of the documentation; a code of a message, such as G454; a "
            "word, such as M0; or a key of a log, such as u_time. Without one, "
            "the pages and words are listed.",
        ),
    ] = None,
) -> None:
    """Show a page of the documentation, or explain a code, a word or a key of a log.

    For a code: what it means, how to fix it, and an example.

    Example:  gyro explain G454
    """
    texts = [_text_about(topic) for topic in topics] if topics else [_contents()]
    write_text("\n".join(texts))


def _contents() -> str:
    """List the pages and the words."""
    from gyrodata.reporting.values import in_columns

    pages = [[f"  gyro explain {name}", page_title(name)] for name in PAGES]
    table = "\n".join(in_columns(pages))
    words = [names.split(", ")[0] for names in _glossary()]
    listed = ", ".join(word for word in words if not word.startswith("u_"))
    return (
        f"Pages:\n{table}\n"
        "Codes and uncertainties, such as:\n"
        "  gyro explain G454\n"
        "  gyro explain u_time\n"
        f"Words, and keys of a log:\n{indent(fill(listed, 74), '  ')}\n"
    )


def _glossary() -> dict[str, str]:
    """Read the texts about words and about keys of a log, by all their names."""
    texts: dict[str, str] = {}
    for entry in page_text("glossary").split("\n### ")[1:]:
        names, _, text = entry.partition("\n")
        text = text.partition("\n## ")[0].strip("\n")
        texts[names] = f"{names}:\n{indent(text, '  ')}\n"
    return texts


def _folded(name: str) -> str:
    """Return a name in small letters, with one "_" for blanks and hyphens."""
    words = name.strip().lower().removesuffix(".md")
    return "_".join(words.replace("-", " ").replace("_", " ").split())


def _text_about(asked: str) -> str:
    """Return the text about a page, a code, a word or a key.

    Raises
    ------
    InputError
        If there is no such name; the message proposes the nearest one.
    """
    codes = explanations()
    texts: dict[str, str] = {}
    for names, text in _glossary().items():
        texts |= dict.fromkeys(names.split(", "), text)
    topics = {_folded(name): name for name in (*texts, *codes, *PAGES)}
    name = f"g{asked}" if asked.isdigit() else _folded(asked)
    if name not in topics:
        _refuse_unknown(asked, name, topics)
    topic = topics[name]
    if topic in PAGES:
        page = page_text(topic)
        return for_terminal(page) if sys.stdout.isatty() else page
    if topic in codes:
        return _about_code(topic)
    text = texts[topic]
    if topic == "settings":
        file = settings_file(Path.cwd()) or "none"
        text += f"  The file for a log in this folder: {file}\n"
    return text


def _refuse_unknown(asked: str, name: str, topics: dict[str, str]) -> NoReturn:
    """Propose the nearest name, the pages that contain the words, or a help."""
    from difflib import get_close_matches

    # Below 0.8, "analyze" would be near to "angle".
    near = get_close_matches(name, topics, n=1, cutoff=0.8)
    hints = [f"did you mean {topics[topic]}?" for topic in near]
    if name in COMMANDS:
        hints.append(f"for the options of the command: gyro {name} --help")
    pages = [page for page in PAGES if asked.lower() in page_text(page).lower()]
    if pages:
        hints.append(f"these pages contain it: {', '.join(pages)}")
    words = "gyro explain lists words, and codes such as G454"
    refuse("nothing_to_explain", asked=asked, hint="; ".join(hints) or words)


def _about_code(code: str) -> str:
    """Describe the meaning and the remedy of a code, with an example."""
    entry = explanations()[code]
    example = entry.example or "(an empty file)"
    if example.split()[0] in COMMANDS:
        example = f"gyro {example}"
    parts = {
        "What it means": entry.meaning,
        "How to fix it": entry.remedy,
        "Example": example,
    }
    text = f"{code}, {entry.severity}: {entry.title}\n"
    for head, part in parts.items():
        if part:
            text += f"\n{head}:\n{indent(part.rstrip(), '  ')}\n"
    return text.translate(PICTURES)
