"""A top with a fixed point, and the state of its motion."""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from gyrodata.physics import Floats, precession_rate


class Top(Struct, frozen=True, eq=False):
    """A symmetric body with one fixed point and a torque from gravity; arrays describe many tops and are broadcast."""

    inertia: Any
    """I_zz, the moment of inertia about the rod [kg*m^2], above 0."""
    transverse_inertia: Any
    """I about an axis across the rod through the fixed point [kg*m^2], above 0; may be below or equal to I_zz."""
    torque: Any
    """h m g, the torque with the rod horizontal [N*m]; negative for a weight on the other side of the centre."""

    def __post_init__(self) -> None:
        for name in ("inertia", "transverse_inertia", "torque"):
            values = np.asarray(getattr(self, name), dtype=float)
            if not np.isfinite(values).all():
                raise ValueError(f"{name} is not a finite number")
            if name != "torque" and not (values > 0).all():
                raise ValueError(f"{name} must be above 0")


class State(Struct, frozen=True, eq=False):
    """Direction of the rod and angular momentum.

    The angle of the spin is not included, because nothing depends on it. Euler angles would fail at the vertical.
    """

    axis: Floats
    """e3, the unit vector along the rod, in the fixed frame X, Y, Z with Z upwards [1]; shape (..., 3)."""
    momentum: Floats
    """H, the angular momentum about the fixed point, in the fixed frame [kg*m^2/s]; shape (..., 3)."""


def steady(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state in steady slow precession, eq. (8), at azimuth 0.

    Raises
    ------
    ValueError
        If there is no steady precession: the rod points upwards and the spin is too low.
    """
    rate = precession_rate(top.torque, spin, top.inertia, top.transverse_inertia, pitch)
    if not np.isfinite(rate).all():
        raise ValueError("no steady precession exists at this spin and pitch; use a faster spin or a lower rod")
    # ω3 = ψ̇ + φ̇ cosθ, eq. (2); H = I (Ω − Ω3 e3) + I_zz ω3 e3, eq. (3).
    along = rate * np.sin(pitch)
    about_rod = np.multiply(top.inertia, spin + along) - np.multiply(top.transverse_inertia, along)
    state = _along_axis(about_rod, pitch, np.shape(rate))
    state.momentum[..., 2] += np.multiply(top.transverse_inertia, rate)
    return state


def released(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """Return the state of a rod at rest at azimuth 0, with the ball spinning, when the rod is released."""
    momentum = np.multiply(top.inertia, spin)
    return _along_axis(momentum, pitch, np.broadcast_shapes(np.shape(momentum), np.shape(pitch), np.shape(top.torque)))


def _along_axis(momentum: ArrayLike, pitch: ArrayLike, shape: tuple[int, ...]) -> State:
    """Return the state at azimuth 0 with all angular momentum along the rod, with vectors of shape (*shape, 3)."""
    axis = np.zeros((*shape, 3))
    axis[..., 0], axis[..., 2] = np.cos(pitch), np.sin(pitch)
    return State(axis, np.asarray(momentum)[..., None] * axis)
