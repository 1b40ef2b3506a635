"""One number of the table, and what must hold."""

from __future__ import annotations

import math

from msgspec import Struct


class Number(Struct, frozen=True):
    """What was measured; None for what is not there to be measured."""

    value: float | None
    low: float = -math.inf
    high: float = math.inf
    of: int | None = None
    """Out of how many."""
    digits: str = ".0f"
    told: str = ""
    """What else there is to tell."""

    @property
    def shown(self) -> str:
        if self.value is None:
            return "not there"
        return f"{self.value:{self.digits}}" + ("" if self.of is None else f" of {self.of}")

    @property
    def must_hold(self) -> str:
        if math.isinf(self.low) and math.isinf(self.high):
            return "-"
        return f"<= {self.high:{self.digits}}" if math.isinf(self.low) else f">= {self.low:{self.digits}}"

    @property
    def holds(self) -> bool:
        return self.value is not None and self.low <= self.value <= self.high
