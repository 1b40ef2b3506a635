"""A flag: something in one log, or between several, that honest work hardly ever does. Never a verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal["shared rows", "shifted or scaled", "residuals", "scatter", "repeats", "digits"]

KINDS: tuple[Kind, ...] = ("shared rows", "shifted or scaled", "residuals", "scatter", "repeats", "digits")
"""In the order in which they are listed."""

ALLOWED = 0.05
"""Flags of one kind that a class of honest students gets by chance, at most; the thresholds follow from it."""

LEAST = 1e-300
"""Where products of small chances end; none is nought."""


@dataclass(frozen=True, slots=True)
class Flag:
    """What was found, and how often honest students would show it."""

    kind: Kind
    students: tuple[str, ...]
    """Their keys, sorted."""
    evidence: str
    """In words, with the numbers."""
    p: float
    """Chance of it, or of more, in one honest log or between two; of the strongest pair where there are several."""
    expected: float
    """How many such flags, as strong as this or stronger, chance makes in an honest class of this size."""
    previous: tuple[str, ...] = ()
    """Keys of earlier logs that it is about, sorted."""
