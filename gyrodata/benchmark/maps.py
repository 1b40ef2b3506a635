"""Maps of how many digits a method has right, each method that fails beside one that holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.physics import Floats

MOST_DIGITS = 16.0
"""A double holds no more."""


@dataclass(frozen=True)
class DigitMap:
    """Correct digits of one method over a plane."""

    method: str
    digits: Floats
    """Shape (y, x), 0 to `MOST_DIGITS`; NaN where there is nothing to compute."""


@dataclass(frozen=True)
class MapPair:
    """A method that fails somewhere, and one that does not, over the same plane."""

    name: str
    title: str
    x_label: str
    x: Floats
    """Spin [rpm], on a logarithmic axis."""
    y_label: str
    y: Floats
    """Tilt [degrees], or powers of ten."""
    fails: DigitMap
    holds: DigitMap
    empty: str
    """What is so where there is nothing to compute; "" where that is nowhere."""


def digits(error: ArrayLike) -> Floats:
    """Correct digits for a relative error: −log10, from 0 to `MOST_DIGITS`; what is not finite is 0."""
    size = np.abs(np.asarray(error, dtype=float))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.clip(-np.log10(size), 0.0, MOST_DIGITS) + 0.0
    return np.where(np.isnan(size), 0.0, found)
