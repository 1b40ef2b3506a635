"""Golden text: words to the letter, numbers as far as a processor and a release of numpy leave them alone."""

from __future__ import annotations

import re
from typing import Any


def steady(text: str) -> str:
    """Write every long number with ten digits: those behind are the processor's; and figures by their names alone."""
    text = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "FIGURE", text)
    return re.sub(r"\d+\.\d{6,}(?:e[-+]?\d+)?", lambda number: f"{float(number[0]):.10g}", text)


def numbers(node: Any, place: str = "") -> dict[str, float]:
    """Every number of a JSON by its place, with the digits that no processor changes."""
    if isinstance(node, dict):
        parts = node.items()
    elif isinstance(node, list):
        parts = enumerate(node)
    else:
        return {place: float(f"{node:.8g}")} if isinstance(node, float) else {}
    return {at: value for key, part in parts for at, value in numbers(part, f"{place}.{key}".lstrip(".")).items()}
