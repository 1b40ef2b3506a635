"""Jacobi's elliptic functions from the complementary parameter, by the arithmetic-geometric mean.

`scipy.special.ellipj` takes m alone. An orbit that almost comes to rest near the upright has 1 − m far below
the last digit of m, and its period hangs on 1 − m: so both are handed in. Method: Abramowitz and Stegun,
Handbook of Mathematical Functions, 16.4 and 17.6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

_NEGLIGIBLE = 1e-8
"""What follows a step this small is its square over 4: below the last digit."""


@dataclass(frozen=True, eq=False)
class Ladder:
    """The steps of the arithmetic-geometric mean that belong to a parameter m, or to an array of them."""

    steps: tuple[tuple[Any, Any], ...]
    """c_n/a_n and b_n/a_n for n = 1, 2, ... to the last that matters: sine and cosine of an angle [1]."""
    mean: Any
    """a_n at the end: the arithmetic-geometric mean of 1 and √(1 − m) [1]."""

    @property
    def quarter(self) -> Any:
        """The complete integral K(m), a quarter of the functions' period [1]."""
        return np.pi / 2 / self.mean

    def amplitude(self, argument: Any) -> Any:
        """The angle am(x|m) whose sine is sn and whose cosine is cn [rad], for an argument within ±K."""
        angle = 2 ** len(self.steps) * self.mean * argument
        for sine, cosine in reversed(self.steps):
            # The angle whose sine is c/a sinφ, from its cosine too, because an arcsine has no digits near 1.
            s = np.sin(angle)
            angle = (angle + np.arctan2(sine * s, np.hypot(np.cos(angle), cosine * s))) / 2
        return angle


def ladder(parameter: Any, complement: Any) -> Ladder:
    """Climb from m and 1 − m, each with its own digits, both from 0 to 1, the complement above 0."""
    arithmetic, geometric, half = 1.0, np.sqrt(complement), np.sqrt(parameter)
    steps = []
    while np.max(half / arithmetic) > _NEGLIGIBLE:
        # (a − b)/2 would lose the digits of a small c; c²/4a' does not.
        arithmetic, geometric = (arithmetic + geometric) / 2, np.sqrt(arithmetic * geometric)
        half = half**2 / (4 * arithmetic)
        steps.append((half / arithmetic, geometric / arithmetic))
    return Ladder(tuple(steps), arithmetic)
