"""``gyro explain``: pages of documentation, codes, words, and keys of a log."""

from __future__ import annotations

import os
import re
import sys
import tomllib
from pathlib import Path
from textwrap import fill, indent
from typing import TYPE_CHECKING, Annotated

import typer
from msgspec.structs import replace

from gyrodata.base import diagnostics
from gyrodata.base.errors import PICTURES, GyroError
from gyrodata.cli import documentation
from gyrodata.cli.options import settings_file
from gyrodata.cli.terminal import refuse, write_text

if TYPE_CHECKING:
    from gyrodata.base.errors import Diagnostic

COMMANDS = ("analyze", "check", "explain", "grade", "predict", "simulate", "template")
"""First words of examples that are commands."""


def _topics(incomplete: str) -> list[tuple[str, str]]:
    """List the pages and codes that begin with a text, each with its title.

    A shell that completes commands uses the list.
    """
    titles = {name: documentation.page_title(name) for name in documentation.PAGES}
    titles |= {code: entry.title for code, entry in diagnostics.explanations().items()}
    return [
        (name, title) for name, title in titles.items() if name.startswith(incomplete)
    ]


def explain(
    topics: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="PAGE | CODE | WORD | KEY",
            autocompletion=_topics,
            help=f"A page of the documentation; a code of a message, such as "
            f"{diagnostics.NO_UNLOADED_RUN}; a word, "
            "such as M0; or a key of a log, such as u_time. Without one, the pages and "
            "words are listed.",
        ),
    ] = None,
) -> None:
    """Show a page of the documentation, or explain a code, a word or a key of a log.

    For a code: what it means, how to fix it, and an example.
    """
    if not topics:
        write_text(_contents())
        return
    texts = [
        _settings() if topic.lower() == "settings" else _explanation(topic)
        for topic in topics
    ]
    write_text("\n".join(texts))


def _glossary() -> dict[str, dict[str, str]]:
    """Read the texts about the "words" and the "keys" of a log.

    The key of a text consists of all names of the word, separated by commas.
    """
    return tomllib.loads(
        (documentation.FOLDER / "glossary.toml").read_text(encoding="utf-8")
    )


def _contents() -> str:
    longest = max(map(len, documentation.PAGES))
    pages = "".join(
        f"  gyro explain {name:<{longest}}  {documentation.page_title(name)}\n"
        for name in documentation.PAGES
    )
    words = fill(
        ", ".join(names.partition(",")[0] for names in _glossary()["words"]), 74
    )
    codes = (
        f"Codes of messages, such as:\n  gyro explain {diagnostics.NO_UNLOADED_RUN}\n"
    )
    keys = "Keys of a log, such as:\n  gyro explain u_time\n"
    return f"Pages:\n{pages}{codes}Words:\n{indent(words, '  ')}\n{keys}"


def _folded(name: str) -> str:
    """Return a name in small letters, with one "_" for blanks and hyphens."""
    return re.sub(r"[\s_-]+", "_", name.strip().lower().removesuffix(".md"))


def _explanation(asked: str) -> str:
    """Return the text about a page, a code, a word or a key.

    Raises
    ------
    InputError
        If there is no such name; the message proposes the nearest one.
    """
    from difflib import get_close_matches

    from gyrodata.readings.roles import KEYS

    texts = _glossary()["keys"] | _glossary()["words"]
    words = {word: names for names in texts for word in names.split(", ")}
    known = {
        _folded(name): name
        for name in (*KEYS, *words, *diagnostics.explanations(), *documentation.PAGES)
    }
    name = f"g{asked}" if asked.isdigit() else _folded(asked)
    if name not in known:
        near = get_close_matches(name, known, n=1)
        pages = [
            page
            for page in documentation.PAGES
            if asked.lower() in documentation.page_text(page).lower()
        ]
        if near:
            refuse("page_misspelt", asked=asked, near=known[near[0]])
        elif pages:
            refuse("page_of_word", asked=asked, pages=", ".join(pages))
        refuse("page_unknown", asked=asked, code=diagnostics.NO_UNLOADED_RUN)
    topic = known[name]
    if topic in documentation.PAGES:
        page = documentation.page_text(topic)
        return documentation.for_terminal(page) if sys.stdout.isatty() else page
    if topic in diagnostics.explanations():
        return _about_code(topic)
    text = texts[words[topic]].rstrip("\n") + "\n" if topic in words else ""
    text += _about_key(topic) if topic in KEYS else ""
    return f"{words.get(topic, topic)}:\n{indent(text, '  ')}"


def _settings() -> str:
    """Say where settings come from, and which file a log in this folder uses."""
    used = settings_file(Path.cwd())
    file = "none" if used is None else used.as_posix()
    named = os.environ.get("GYRO_CONFIG") or "not set"
    return f"""settings:
  Constants of the apparatus and other keys of a log can be in a TOML file, with
  lines such as: latitude = "42.5 deg"
  gyro uses one file, the first of these:
    1. --config FILE
    2. the file that the variable GYRO_CONFIG names; now: {named}
    3. gyro.toml in the folder of the log or in a folder above it, up to the home
       folder or the top of a repository
  The file for a log in this folder: {file}
  A line of the log replaces a line of the file, and --set replaces both.
  A teacher can write: worksheet = "yes"
"""


def _about_key(key: str) -> str:
    """Describe the meaning and the form of a key of a log."""
    from gyrodata.quantities.error_sources import SOURCES
    from gyrodata.quantities.units import DISPLAY
    from gyrodata.readings import roles

    if key in roles.OTHER_KEYS:
        # The glossary shows these lines as a whole.
        return ""
    lines = []
    base = key.removeprefix("u_")
    role = roles.BY_NAME.get(key)
    if role and role.meaning:
        lines.append(f"As a quantity of a run: {role.meaning}.")
    if key != base and key in roles.UNCERTAINTIES:
        source = SOURCES.get(base)
        lines.append(f"Standard uncertainty of {source.words if source else base}.")
        if source:
            lines.append(f"If the log does not state it, gyro assumes {source.usual}.")
    unit = DISPLAY[roles.kind_of_role(key)]
    if base in roles.BY_NAME:
        lines.append(f"As a column: {key} [{unit}]" if unit else f"As a column: {key}")
    if key not in roles.TEXTS:
        value = role.sample if role and role.sample else f"NUMBER {unit}".rstrip()
        lines.append(f"For all runs: # {key}: {value}")
    return "".join(f"{line}\n" for line in lines)


def _about_code(code: str) -> str:
    """Describe the meaning and the remedy of a code, with an example."""
    entry = diagnostics.explanations()[code]
    raised = _raised(code)
    example = entry.example or "(an empty file)"
    if not raised and example.split()[0] in COMMANDS:
        example = f"gyro {example}"
    if raised and raised.hint[1:] in entry.remedy:
        # The remedy is the hint: it is not shown twice.
        raised = replace(raised, hint="")
    blocks = {
        "What it means": entry.meaning,
        "How to fix it": "\n".join(map(_wrapped, entry.remedy.splitlines())),
        "Example": example,
        "gyro says about this log": str(raised or ""),
    }
    lines = [
        f"{head}:\n{indent(text.rstrip(), '  ')}"
        for head, text in blocks.items()
        if text
    ]
    title = f"{code}, {entry.severity}: {entry.title}"
    return "\n\n".join([title, *lines]).translate(PICTURES) + "\n"


def _wrapped(line: str) -> str:
    """Wrap a line, but not one to copy."""
    if line.startswith("  "):
        return line
    return fill(line, 76, break_long_words=False, break_on_hyphens=False)


def _raised(code: str) -> Diagnostic | None:
    """Return the diagnostic of the example of a code; None if it is not a log."""
    from gyrodata.analysis import check_log
    from gyrodata.readings import read_log

    example = diagnostics.explanations()[code].example
    # Codes from G5 on are about options and classes.
    if code >= "G5" or example.startswith("analyze "):
        return None
    # These two codes are about bytes that are not UTF-8.
    encoding = (
        "latin-1"
        if code in (diagnostics.COMPRESSED_FILE_DAMAGED, diagnostics.CODE_PAGE_GUESSED)
        else "utf-8"
    )
    try:
        readings = read_log(example.encode(encoding), name="log.csv")
        raised = (*readings.diagnostics, *check_log(readings)[1])
    except GyroError as error:
        raised = error.diagnostics
    return next((diagnostic for diagnostic in raised if diagnostic.code == code), None)
