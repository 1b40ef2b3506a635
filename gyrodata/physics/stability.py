"""The upright rod and the small nutation about steady precession."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def sleeping_spin(torque: ArrayLike, inertia: ArrayLike, transverse_inertia: ArrayLike) -> Any:
    """Total spin above which an upright rod stays upright ("sleeps"): 2√(I h m g)/I_zz.

    Parameters
    ----------
    torque : array_like
        h m g, the torque that the rod has when horizontal [N*m]; negative for a rod that hangs straight down
        (or a weight below the centre), which is stable at any spin.
    inertia, transverse_inertia : array_like
        I_zz and I [kg*m^2].

    Returns
    -------
    ndarray or float
        Size of ω3 [rad/s], 0 where any spin will do. From the motion linearised about the vertical.
    """
    return 2 * np.sqrt(np.maximum(np.multiply(transverse_inertia, torque), 0.0)) / inertia


def sleeping_growth(torque: ArrayLike, total_spin: ArrayLike, inertia: ArrayLike, transverse_inertia: ArrayLike) -> Any:
    """Rate at which a small tilt of an upright rod grows: √(h m g/I − (I_zz ω3/2I)²).

    Parameters
    ----------
    torque : array_like
        As for `sleeping_spin` [N*m].
    total_spin : array_like
        ω3 [rad/s].
    inertia, transverse_inertia : array_like
        I_zz and I [kg*m^2].

    Returns
    -------
    ndarray or float
        Rate [1/s]: the tilt grows e-fold in its inverse; 0 where the rod sleeps. For small tilts.
    """
    half = np.multiply(inertia, total_spin) / np.multiply(2.0, transverse_inertia)
    return np.sqrt(np.maximum(np.divide(torque, transverse_inertia) - half * half, 0.0))


def nutation_rate(
    total_spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    precession_rate: ArrayLike = 0.0,
    pitch: ArrayLike = 0.0,
) -> Any:
    """Rate of a small nutation about steady precession: √((I_zz ω3/I − 2 φ̇ cosθ)² + (φ̇ sinθ)²).

    Parameters
    ----------
    total_spin : array_like
        ω3 = ψ̇ + φ̇ cosθ [rad/s].
    inertia, transverse_inertia : array_like
        I_zz and I [kg*m^2].
    precession_rate : array_like
        φ̇ of the steady precession [rad/s].
    pitch : array_like
        Angle of the rod above the horizontal [rad].

    Returns
    -------
    ndarray or float
        Rate [rad/s], not negative. Without precession I_zz |ω3|/I, which is exact for a nutation of any size
        where no torque acts.

    Notes
    -----
    The second derivative of the effective potential of θ at the steady state of eq. (8), over I; h m g is
    taken out of it by eq. (8) itself.
    """
    free = np.multiply(inertia, total_spin) / transverse_inertia
    rate = np.asarray(precession_rate, dtype=float)
    return np.hypot(free - 2 * rate * np.sin(pitch), rate * np.cos(pitch))
