"""What small errors of the apparatus and of the hand do to I_zz, each alone, run by run.

Biases are I_zz estimated over true, minus 1, of one run by eq. (9). A fit's bias is their mean with the fit's
weights: equal for a mean of ratios, (φ̇ψ̇)² for M against φ̇ψ̇, (2πfψ̇/M)²/u_T² for the time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def imbalance_bias(torque: ArrayLike, imbalance: ArrayLike) -> Any:
    """Relative bias of I_zz when a residual torque M0 is taken for none: −M0/(M + M0).

    Parameters
    ----------
    torque : array_like
        Torque of the weight, without the residual one [N*m].
    imbalance : array_like
        M0 [N*m].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact.
    """
    return -np.divide(imbalance, np.add(torque, imbalance))


def position_zero_bias(position: ArrayLike, error: ArrayLike) -> Any:
    """Relative bias of I_zz when the zero of the ruler is off: error/position.

    Parameters
    ----------
    position : array_like
        True distance of the weight from the centre [m].
    error : array_like
        Position read minus true position [m].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact. A common factor of all runs where only the mass is varied: nothing
        in such a log shows it.
    """
    return np.divide(error, position)


def timing_bias(time: ArrayLike, bias: ArrayLike) -> Any:
    """Relative bias of I_zz when every time is too long by `bias`: bias/time.

    Parameters
    ----------
    time : array_like
        True time of the interval [s].
    bias : array_like
        Time read minus true time, of a hand that is slow to start or to stop [s].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact.
    """
    return np.divide(bias, time)


def sighting_bias(turns: ArrayLike, error: ArrayLike) -> Any:
    """Relative bias of I_zz when the rod turned by a little more than was believed: error/(2π turns).

    Parameters
    ----------
    turns : array_like
        Turns of precession believed to be timed [1].
    error : array_like
        True angle minus that of `turns` [rad].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact.
    """
    return np.divide(error, np.multiply(2 * np.pi, turns))
