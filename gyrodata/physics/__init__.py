"""The gyroscope's closed forms, in SI floats and arrays: no units, no data, no fit.

The equations are numbered as in the lab sheet. θ is the angle from the vertical to the rod, ``pitch`` =
90° − θ the rod's angle above the horizontal, so cosθ = sin(pitch). The *spin* ψ̇ is counted relative to the
frame that follows the rod, the *precession rate* φ̇ about the vertical.

(6)  torque = h m g sinθ
(8)  φ̇ sinθ [I_zz (φ̇ cosθ + ψ̇) − I φ̇ cosθ] = torque
(9)  θ = 90°: I_zz φ̇ ψ̇ = h m g

Everywhere `torque` is h m g, that of the level rod [N*m], `inertia` I_zz and `transverse_inertia` I across the rod
through the fixed point [kg*m^2]; masses are in kg, lengths in m, times in s, rates and spins in rad/s, angles in rad.
All arguments are arrays or numbers that broadcast; what does not exist is NaN. ``total_spin`` says that a spin is
ω3 = ψ̇ + φ̇ cosθ, as a tachometer that stands still reads it.

`precession` has eqs. (8) and (9), the means of a falling spin, a rod let go from rest, stability, and what
simplifications do to I_zz; `kinematics` eqs. (1) to (5), `demonstrations` what else the lab shows.
"""

from __future__ import annotations

from gyrodata.physics.demonstrations import SIDEREAL_DAY, balanced_direction, platform_rate, tip_velocity
from gyrodata.physics.kinematics import (
    Floats,
    Integers,
    angular_momentum,
    body_rotation,
    frame_axes,
    frame_rotation,
    momentum_change,
)
from gyrodata.physics.precession import (
    EARTH_ROTATION,
    VISCOUS,
    bored_ball_inertia,
    click_error,
    cylinder_inertia,
    decay_law_doubt,
    fast_precession_rate,
    greatest_sag,
    harmonic_mean_spin,
    harmonic_mean_spin_slopes,
    horizontal_precession_rate,
    least_spin,
    mean_sag,
    normal_gravity,
    nutation_rate,
    precession_rate,
    release_bias,
    simpson_mean_spin,
    sleeping_growth,
    sleeping_spin,
    solid_ball_inertia,
    tilt_bias,
    torque,
)
from gyrodata.units import RPM, STANDARD_GRAVITY

__all__ = [
    "EARTH_ROTATION",
    "RPM",
    "SIDEREAL_DAY",
    "STANDARD_GRAVITY",
    "VISCOUS",
    "Floats",
    "Integers",
    "angular_momentum",
    "balanced_direction",
    "body_rotation",
    "bored_ball_inertia",
    "click_error",
    "cylinder_inertia",
    "decay_law_doubt",
    "fast_precession_rate",
    "frame_axes",
    "frame_rotation",
    "greatest_sag",
    "harmonic_mean_spin",
    "harmonic_mean_spin_slopes",
    "horizontal_precession_rate",
    "least_spin",
    "mean_sag",
    "momentum_change",
    "normal_gravity",
    "nutation_rate",
    "platform_rate",
    "precession_rate",
    "release_bias",
    "simpson_mean_spin",
    "sleeping_growth",
    "sleeping_spin",
    "solid_ball_inertia",
    "tilt_bias",
    "tip_velocity",
    "torque",
]
