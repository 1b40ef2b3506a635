"""Golden text: words to the letter, numbers as far as a processor and a release of numpy leave them alone."""

from __future__ import annotations

import re


def steady(text: str) -> str:
    """Write every long number with ten digits: those behind are the processor's; and figures by their names alone."""
    text = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "FIGURE", text)
    return re.sub(r"\d+\.\d{6,}(?:e[-+]?\d+)?", lambda number: f"{float(number[0]):.10g}", text)
