"""Mechanics of the gyroscope: closed forms, exact motion, theory for numbers.

Numbers or arrays in SI go in, and numbers or arrays in SI come out; a value that does
not exist is NaN, or in a prediction None with the reason. Nothing here knows a log, a
fit or a page.

`closed_forms` contains the equations that this package hands on; `motion` integrates
the motion of a top; `models` lists how a rod may move while it is timed; `prediction`
answers the questions of `gyro predict`.
"""

from gyrodata.physics.closed_forms import (
    EARTH_ROTATION,
    RPM,
    SIDEREAL_DAY,
    STANDARD_GRAVITY,
    VISCOUS,
    Floats,
    Integers,
    balanced_direction,
    bored_ball_inertia,
    click_error,
    cylinder_inertia,
    decay_law_doubt,
    fast_precession_rate,
    harmonic_mean_spin,
    harmonic_mean_spin_share,
    horizontal_precession_rate,
    least_spin,
    normal_gravity,
    platform_rate,
    precession_rate,
    sag_size,
    simpson_mean_spin,
    sinhc,
    sleeping_growth,
    sleeping_spin,
    solid_ball_inertia,
    spin_of_sag,
    torque,
)
