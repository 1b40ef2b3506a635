"""A top, its state, and the states a run starts from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.physics import Floats, precession_rate


@dataclass(frozen=True, eq=False)
class Top:
    """A symmetric body with one point fixed and a torque from gravity; arrays stand for many tops and broadcast."""

    inertia: Any
    """I_zz, the moment of inertia about the rod [kg*m^2], above 0."""
    transverse_inertia: Any
    """I about an axis across the rod through the fixed point [kg*m^2], above 0; may be below or equal to I_zz."""
    torque: Any
    """h m g, the torque with the rod horizontal [N*m]; negative with the weight beyond the centre, 0 when balanced."""

    def __post_init__(self) -> None:
        for name in ("inertia", "transverse_inertia", "torque"):
            values = np.asarray(getattr(self, name), dtype=float)
            if not np.isfinite(values).all():
                raise ValueError(f"{name} is not a finite number")
            if name != "torque" and not (values > 0).all():
                raise ValueError(f"{name} must be above 0")


@dataclass(frozen=True, eq=False)
class State:
    """Where the rod points and the angular momentum: all that the torque acts on.

    The spin's angle is not in it, because nothing depends on it; nor are Euler angles, which fail at the vertical.
    """

    axis: Floats
    """e3, the unit vector along the rod, in the fixed frame X, Y, Z with Z up [1]; shape (..., 3)."""
    momentum: Floats
    """H, the angular momentum about the fixed point, in the fixed frame [kg*m^2/s]; shape (..., 3)."""


def steady(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """The rod in steady slow precession, eq. (8), pointing towards X (azimuth 0).

    A ValueError where none exists, because the rod points up and the spin is too low: `precession_rate` is NaN there.
    """
    rate = precession_rate(top.torque, spin, top.inertia, top.transverse_inertia, pitch)
    if not np.isfinite(rate).all():
        raise ValueError("no steady precession exists at this spin and pitch; spin faster or lower the rod")
    axis = _axis(pitch, np.shape(rate))
    vertical = np.zeros_like(axis)
    vertical[..., 2] = rate
    # ω3 = ψ̇ + φ̇ cosθ, eq. (2); H = I (Ω − Ω3 e3) + I_zz ω3 e3, eq. (3).
    along = rate * np.sin(pitch)
    about_rod = np.multiply(top.inertia, spin + along) - np.multiply(top.transverse_inertia, along)
    transverse = np.asarray(top.transverse_inertia, dtype=float)[..., None]
    return State(axis, transverse * vertical + np.asarray(about_rod)[..., None] * axis)


def released(top: Top, spin: ArrayLike, pitch: ArrayLike = 0.0) -> State:
    """The rod held at rest towards X (azimuth 0), the ball spinning, at the moment the rod is let go."""
    momentum = np.multiply(top.inertia, spin)
    shape = np.broadcast_shapes(np.shape(momentum), np.shape(pitch), np.shape(top.torque))
    axis = _axis(pitch, shape)
    return State(axis, np.asarray(momentum)[..., None] * axis)


def energy(top: Top, state: State) -> Any:
    """Kinetic and potential energy: (H² − H3²)/2I + H3²/2I_zz + h m g cosθ [J].

    0 for a body at rest with the rod horizontal.
    """
    about_rod = np.sum(state.axis * state.momentum, axis=-1)
    across = np.sum(state.momentum**2, axis=-1) - about_rod**2
    kinetic = across / np.multiply(2, top.transverse_inertia) + about_rod**2 / np.multiply(2, top.inertia)
    return kinetic + top.torque * state.axis[..., 2]


def _axis(pitch: ArrayLike, shape: tuple[int, ...]) -> Floats:
    """The unit vector at azimuth 0 and this pitch, shape (*shape, 3)."""
    axis = np.zeros((*shape, 3))
    axis[..., 0] = np.cos(pitch)
    axis[..., 2] = np.sin(pitch)
    return axis
