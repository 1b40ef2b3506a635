"""Rotation and angular momentum of the top, eqs. (1) to (5) of the lab sheet, as
components along e1, e2 and e3.

e3 points along the rod, e1 is horizontal, e2 = e3 × e1; the last axis of every vector
has its three components."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.physics import Floats


def frame_axes(azimuth: ArrayLike, theta: ArrayLike) -> Floats:
    """Give e1, e2 and e3 in the fixed frame X, Y, Z, one axis a row.

    The azimuth counts counterclockwise from X seen from above; e1 = Z × e3/sinθ, so
    that a growing θ is a positive turn about e1."""
    phi, tilt = np.broadcast_arrays(azimuth, theta)
    along = np.stack(
        [np.sin(tilt) * np.cos(phi), np.sin(tilt) * np.sin(phi), np.cos(tilt)], axis=-1
    )
    level = np.stack([-np.sin(phi), np.cos(phi), np.zeros(np.shape(phi))], axis=-1)
    return np.stack([level, np.cross(along, level), along], axis=-2)


def frame_rotation(
    theta_rate: ArrayLike, precession_rate: ArrayLike, theta: ArrayLike
) -> Floats:
    """Rotation of the frame that follows the rod, eq. (1): Ω = θ̇ e1 + φ̇ sinθ e2 + φ̇
    cosθ e3 [rad/s].
    """
    across, along = (
        np.multiply(precession_rate, np.sin(theta)),
        np.multiply(precession_rate, np.cos(theta)),
    )
    return _stack(theta_rate, across, along)


def body_rotation(
    theta_rate: ArrayLike, precession_rate: ArrayLike, spin: ArrayLike, theta: ArrayLike
) -> Floats:
    """Rotation of the body, eq. (2): ω = Ω + ψ̇ e3 [rad/s]; its last component is the
    total spin ω3.
    """
    return frame_rotation(theta_rate, precession_rate, theta) + _stack(0.0, 0.0, spin)


def angular_momentum(
    rotation: ArrayLike, inertia: ArrayLike, transverse_inertia: ArrayLike
) -> Floats:
    """Angular momentum about the fixed point, eq. (3): H = I ω1 e1 + I ω2 e2 + I_zz ω3
    e3 [kg*m^2/s].
    """
    return np.asarray(rotation, dtype=float) * _stack(
        transverse_inertia, transverse_inertia, inertia
    )


def momentum_change(
    rotation: ArrayLike,
    rotation_change: ArrayLike,
    frame: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
) -> Floats:
    """Rate of change of the angular momentum, eqs. (4) and (5): I ω̇1 e1 + I ω̇2 e2 +
    I_zz ω̇3 e3 + Ω × H [N*m].

    `rotation_change` is ω̇ in the frame that follows the rod [rad/s^2], `frame` is Ω.
    Equal to the torque, h m g sinθ e1 of eq. (6), which is eq. (7).
    """
    momentum = angular_momentum(rotation, inertia, transverse_inertia)
    own = angular_momentum(rotation_change, inertia, transverse_inertia)
    return own + np.cross(np.asarray(frame, dtype=float), momentum)


def _stack(first: Any, second: Any, third: Any) -> Floats:
    return np.stack(np.broadcast_arrays(first, second, third), axis=-1).astype(float)
