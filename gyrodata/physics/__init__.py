"""The gyroscope's closed forms, in SI floats and arrays: no units, no data, no fit.

The equations are numbered as in the lab sheet. θ is the angle from the vertical to the rod, ``pitch`` =
90° − θ the rod's angle above the horizontal, so cosθ = sin(pitch). The *spin* ψ̇ is counted relative to the
frame that follows the rod, the *precession rate* φ̇ about the vertical.

(6)  torque = h m g sinθ
(8)  φ̇ sinθ [I_zz (φ̇ cosθ + ψ̇) − I φ̇ cosθ] = torque
(9)  θ = 90°: I_zz φ̇ ψ̇ = h m g

`steady` has the rates of eqs. (8) and (9), `stability` the upright rod and nutation, `released` a rod let go from
rest, `decay` the means of a falling spin, `kinematics` eqs. (1) to (5). What each simplification does to I_zz is in
closed form in `tilt`, `released`, `decay`, `earth` and `biases`.
"""

from __future__ import annotations

from gyrodata.physics.biases import imbalance_bias, position_zero_bias, sighting_bias, timing_bias
from gyrodata.physics.bodies import solid_ball_inertia
from gyrodata.physics.constants import EARTH_ROTATION, RPM, SIDEREAL_DAY, STANDARD_GRAVITY, Floats
from gyrodata.physics.decay import (
    VISCOUS,
    SpinRule,
    arithmetic_mean_bias,
    decay_law_doubt,
    drag_exponent,
    harmonic_mean_spin,
    harmonic_mean_spin_of_three,
    harmonic_mean_spin_slopes,
    late_reading_bias,
    mean_spin_bias,
    simpson_mean_spin,
    sink_bias,
    sink_rate,
)
from gyrodata.physics.demonstrations import platform_rate, tip_velocity
from gyrodata.physics.earth import balanced_direction, earth_bias
from gyrodata.physics.kinematics import angular_momentum, body_rotation, frame_axes, frame_rotation, momentum_change
from gyrodata.physics.released import click_error, greatest_sag, mean_sag, release_bias, released_precession_rate
from gyrodata.physics.stability import nutation_rate, sleeping_growth, sleeping_spin
from gyrodata.physics.steady import (
    fast_precession_rate,
    horizontal_precession_rate,
    least_spin,
    precession_rate,
    torque,
)
from gyrodata.physics.tilt import cosine_bias, pitch_bias, tilt_bias, transverse_bias

__all__ = [
    "EARTH_ROTATION",
    "RPM",
    "SIDEREAL_DAY",
    "STANDARD_GRAVITY",
    "VISCOUS",
    "Floats",
    "SpinRule",
    "angular_momentum",
    "arithmetic_mean_bias",
    "balanced_direction",
    "body_rotation",
    "click_error",
    "cosine_bias",
    "decay_law_doubt",
    "drag_exponent",
    "earth_bias",
    "fast_precession_rate",
    "frame_axes",
    "frame_rotation",
    "greatest_sag",
    "harmonic_mean_spin",
    "harmonic_mean_spin_of_three",
    "harmonic_mean_spin_slopes",
    "horizontal_precession_rate",
    "imbalance_bias",
    "late_reading_bias",
    "least_spin",
    "mean_sag",
    "mean_spin_bias",
    "momentum_change",
    "nutation_rate",
    "pitch_bias",
    "platform_rate",
    "position_zero_bias",
    "precession_rate",
    "release_bias",
    "released_precession_rate",
    "sighting_bias",
    "simpson_mean_spin",
    "sink_bias",
    "sink_rate",
    "sleeping_growth",
    "sleeping_spin",
    "solid_ball_inertia",
    "tilt_bias",
    "timing_bias",
    "tip_velocity",
    "torque",
    "transverse_bias",
]
