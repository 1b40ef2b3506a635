"""Load the templates: HTML is escaped, and each text from outside becomes one harmless line."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING

from gyrodata.errors import shown
from gyrodata.grading.grade import points_text
from gyrodata.grading.yardsticks import fit_words
from gyrodata.reporting.values import factor_text, inertia_text, number_text

if TYPE_CHECKING:
    from jinja2 import Environment


@lru_cache(maxsize=1)
def environment() -> Environment:
    """Return the environment of all templates, with its filters."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("gyrodata.grading", "."),
        autoescape=lambda name: name is not None and name.endswith(".html.jinja"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"plain": shown, "points": points_text, "factor": factor_text, "inertia": inertia_text}
    made.filters |= {"number": number_text, "distance": _distance, "fit_words": fit_words}
    # Titles, rules and reasons are the same for many students.
    made.filters |= {"md": lru_cache(512)(_markdown_safe), "sentence": lru_cache(512)(sentence)}
    return made


def sentence(text: object) -> str:
    """Return one line with a capital and a full stop."""
    line = shown(text).rstrip(".")
    # "g is missing" and "φ̇ψ̇ scatters" begin with a symbol.
    first = line[:1].upper() if re.match("[a-z]{2}", line) else line[:1]
    return f"{first}{line[1:]}{'' if line.endswith(('?', '!')) else '.'}" if line else ""


def _distance(value: float | None) -> str:
    """Write a distance in units of u: two digits, and all digits before the point up to a million."""
    return "–" if value is None else f"{value:.0f}" if 100 <= value < 1e6 else f"{value:.2g}".replace("-", "−")


def _markdown_safe(text: object) -> str:
    """Return one line that Markdown takes literally."""
    line = re.sub(r"([\\`*_\[\]|~$])", r"\\\1", shown(text))
    return line.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("://", ":\\//")
