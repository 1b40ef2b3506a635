"""Where functions cross zero, many at once, when a bracket is known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

_STEPS = 200
"""More than it takes to halve any bracket down to the last digit, with as many interpolations between."""


def find_crossing(function: Callable[[Any], Any], early: ArrayLike, late: ArrayLike) -> Any:
    """The argument at which each function is 0, to the last digit.

    Parameters
    ----------
    function : callable
        Takes an array of arguments, one for each function, and gives as many values.
    early, late : array_like
        Arguments at which the values are at most 0 and at least 0. Where they are not, the end that is
        closer to 0 is the answer, as it should be when only rounding is to blame.

    Returns
    -------
    ndarray or float

    Notes
    -----
    Inverse quadratic interpolation wherever the last three points speak for it, else halving (Chandrupatla,
    Advances in Engineering Software 28, 145, 1997). Newton's method stalls where a precessing rod stands still.
    """
    first, second = np.broadcast_arrays(np.asarray(early, dtype=float), np.asarray(late, dtype=float))
    f_first, f_second = function(first), function(second)
    fraction = np.full(first.shape, 0.5)
    closed = f_first * f_second > 0
    for _step in range(_STEPS):
        nearer = np.abs(f_first) < np.abs(f_second)
        best = np.where(nearer, first, second)
        width = np.abs(second - first)
        reach = np.finfo(float).eps * np.abs(best)
        closed = closed | (np.where(nearer, f_first, f_second) == 0) | (width <= 2 * reach)
        if closed.all():
            break
        with np.errstate(divide="ignore", invalid="ignore"):
            least = np.where(closed, 0.5, reach / width)
        between = first + np.clip(fraction, least, 1 - least) * (second - first)
        between = np.where(closed, best, between)
        value = function(between)
        same = value * f_first > 0
        third, f_third = np.where(same, first, second), np.where(same, f_first, f_second)
        second, f_second = np.where(same, second, first), np.where(same, f_second, f_first)
        first, f_first = np.where(closed, first, between), np.where(closed, f_first, value)
        fraction = _interpolated(first, second, third, f_first, f_second, f_third)
    return best[()]


def _interpolated(first: Any, second: Any, third: Any, f_first: Any, f_second: Any, f_third: Any) -> Any:
    """The crossing as a fraction of the way from first to second: interpolated where that is safe, else a half."""
    with np.errstate(divide="ignore", invalid="ignore"):
        place = (first - second) / (third - second)
        level = (f_first - f_second) / (f_third - f_second)
        safe = (level**2 < place) & ((1 - level) ** 2 < 1 - place)
        curved = f_first / (f_second - f_first) * f_third / (f_second - f_third)
        curved = curved + (third - first) / (second - first) * f_first / (f_third - f_first) * f_second / (
            f_third - f_second
        )
    return np.where(safe, curved, 0.5)
