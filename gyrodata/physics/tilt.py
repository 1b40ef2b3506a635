"""What a tilted rod does to I_zz when its tilt is left out, or put in wrongly.

Biases are I_zz estimated over true, minus 1, from one run of exactly steady precession, eq. (8). The spin is
what was read, either ψ̇ or, with ``total_spin``, ω3 = ψ̇ + φ̇ cosθ.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def tilt_bias(
    precession_rate: ArrayLike,
    spin: ArrayLike,
    pitch: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    *,
    total_spin: bool = False,
) -> Any:
    """Relative bias of I_zz when eq. (9) is used for a tilted rod: (1 − I/I_zz)(φ̇/ψ̇) sin(pitch).

    Parameters
    ----------
    precession_rate, spin : array_like
        φ̇ and ψ̇ [rad/s].
    pitch : array_like
        Angle of the rod above the horizontal [rad].
    inertia, transverse_inertia : array_like
        I_zz and I [kg*m^2].
    total_spin : bool
        `spin` is ω3; the bias is −(I/I_zz)(φ̇/ω3) sin(pitch) then.

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact for steady precession.
    """
    own = 0.0 if total_spin else 1.0
    ratio = np.divide(transverse_inertia, inertia)
    return (own - ratio) * np.divide(precession_rate, spin) * np.sin(pitch)


def transverse_bias(
    precession_rate: ArrayLike,
    spin: ArrayLike,
    pitch: ArrayLike,
    inertia: ArrayLike,
    error: ArrayLike,
    *,
    total_spin: bool = False,
) -> Any:
    """Relative bias of I_zz when eq. (8) is used with a wrong I: (error/I_zz)(φ̇/ω3) sin(pitch).

    Parameters
    ----------
    precession_rate, spin, pitch, total_spin
        As for `tilt_bias`.
    inertia : array_like
        I_zz [kg*m^2].
    error : array_like
        I used minus true I [kg*m^2]. Minus the true I if the term with I was left out of eq. (8): that is
        worse than eq. (9), by a factor I/(I − I_zz) or so.

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1; exact for steady precession.
    """
    turning = np.multiply(precession_rate, np.sin(pitch))
    return np.divide(error, inertia) * turning / _total(spin, turning, total_spin)


def pitch_bias(
    precession_rate: ArrayLike,
    spin: ArrayLike,
    pitch: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    error: ArrayLike,
    *,
    total_spin: bool = False,
) -> Any:
    """Relative bias of I_zz when eq. (8) is used with a wrong pitch.

    Parameters
    ----------
    precession_rate, spin, pitch, inertia, transverse_inertia, total_spin
        As for `tilt_bias`; the true pitch.
    error : array_like
        Pitch used minus true pitch [rad].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1: (I/I_zz − 1)(φ̇/ψ̇) cos(pitch) × error for a small one, or
        (I/I_zz)(φ̇/ω3) cos(pitch) × error for the total spin; exact for one of any size.
    """
    own = 0.0 if total_spin else 1.0
    ratio = np.divide(transverse_inertia, inertia)
    half = np.multiply(0.5, error)
    change = 2 * np.cos(pitch + half) * np.sin(half)
    used = np.multiply(precession_rate, np.sin(np.add(pitch, error)))
    return (ratio - own) * np.multiply(precession_rate, change) / _total(spin, used, total_spin)


def _total(spin: ArrayLike, turning: Any, total_spin: bool) -> Any:
    """Give ω3 for the spin as read; `turning` is φ̇ cosθ [rad/s]."""
    return np.asarray(spin, dtype=float) if total_spin else np.add(spin, turning)


def cosine_bias(pitch: ArrayLike) -> Any:
    """Relative bias of I_zz when the torque is taken for m g x cos(pitch): cos(pitch) − 1.

    Parameters
    ----------
    pitch : array_like
        Angle of the rod above the horizontal [rad].

    Returns
    -------
    ndarray or float
        I_zz estimated over true, minus 1. The sinθ = cos(pitch) of the torque cancels in eq. (8), so that
        this is a mistake; it multiplies what else is wrong.
    """
    return -2 * np.sin(np.multiply(0.5, pitch)) ** 2
