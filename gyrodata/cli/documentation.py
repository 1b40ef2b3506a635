"""The list of commands, and the pages of documentation for a terminal."""

from __future__ import annotations

from pathlib import Path

PAGES = (
    "first-timer",
    "log-format",
    "glossary",
    "theory",
    "statistics",
    "approximations",
    "benchmark",
    "instructors",
    "python",
    "pipelines",
    "changelog",
)
"""Names of the pages, in the order of the list."""

GROUPS = {
    "Your lab": {
        "demo": "Write a sample log and analyze it.",
        "template": "Write a blank log to fill in.",
        "plan": "Say which runs help most.",
        "check": "Check a log before you leave the lab.",
        "analyze": "Fit I_zz, and write a report.",
        "explain": "Explain a code, a word, a key; show a page.",
    },
    "A class": {"grade": "Grade a class, with feedback."},
    "Theory and simulation": {
        "predict": "Predict motions from theory.",
        "simulate": "Print a simulated log.",
    },
    "Advanced": {
        "selfcheck": "Test the intervals by simulation.",
        "schema": "Print JSON Schemas, or all codes.",
        "benchmark": "Chart speed against accuracy.",
    },
}
"""The commands as ``gyro --help`` lists them."""

COMMANDS: dict[str, str] = {}
"""What each command does."""
for _group in GROUPS.values():
    COMMANDS |= _group

FOLDER = Path(__file__).parents[1] / "docs"
"""The folder of the pages, and of the files that belong to them."""

WIDEST = 100
"""Maximum width of a line [characters]; longer lines are hard to read."""


def page_text(name: str) -> str:
    """Return a page as Markdown."""
    return (FOLDER / f"{name}.md").read_text(encoding="utf-8")


def page_title(name: str) -> str:
    """Return the title of a page, its first line."""
    return page_text(name).partition("\n")[0].removeprefix("# ")


def for_terminal(markdown: str, width: int | None = None) -> str:
    """Format a page for a terminal of `width` columns, or of its own width."""
    from rich.console import Console
    from rich.markdown import Markdown
    from rich.theme import Theme

    # The usual black background of code is too dark for a light terminal.
    plain = Theme({"markdown.code": "bold cyan"})
    console = Console(
        width=width, force_terminal=True, legacy_windows=False, theme=plain
    )
    console.width = min(console.width, WIDEST)
    with console.capture() as captured:
        console.print(Markdown(markdown, code_theme="ansi_dark", hyperlinks=False))
    return "\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n"
