"""The gyroscope's closed forms, in SI floats and arrays: no units, no data, no fit.

The equations are numbered as in the lab sheet. θ is the angle from the vertical to the
rod, ``pitch`` = 90° − θ the rod's angle above the horizontal, so cosθ = sin(pitch). The
*spin* ψ̇ is counted relative to the frame that follows the rod, the *precession rate*
φ̇ about the vertical.

(6)  torque = h m g sinθ
(8)  φ̇ sinθ [I_zz (φ̇ cosθ + ψ̇) − I φ̇ cosθ] = torque
(9)  θ = 90°: I_zz φ̇ ψ̇ = h m g

Everywhere `torque` is h m g, that of the level rod [N*m], `inertia` I_zz and
`transverse_inertia` I across the rod through the fixed point [kg*m^2]; masses are in
kg, lengths in m, times in s, rates and spins in rad/s, angles in rad. All arguments are
arrays or numbers that broadcast; a result that does not exist is NaN. The *total spin*
is ω3 = ψ̇ + φ̇ cosθ, as a tachometer that stands still reads it.

A rod that is released from rest falls a little, picks up speed sideways, and nutates in
cusps about the steady precession. All of it is governed by δ = I h m g/(I_zz ω3)², the
mean sag of a level rod; ω3 is the spin at the release.

A spin that falls while it is timed: drag is ψ̈ = −c ψ̇^p, p = 0 dry friction, p = 1
viscous (an air film), p = 2 turbulent. The angle precessed is ∫ M/(I_zz ψ̇) dt, so the
mean that belongs in eq. (9) is the harmonic one in time. With start a, end b, d =
ln(a/b), the geometric mean G = √(ab) and sinhc(x) = sinh(x)/x it is G sinhc((1 −
p)d/2)/sinhc(p d/2).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gyrodata.quantities.units import RPM as RPM
from gyrodata.quantities.units import STANDARD_GRAVITY as STANDARD_GRAVITY

Floats = NDArray[np.float64]
Integers = NDArray[np.int_]

EARTH_ROTATION = 7.292115e-5
"""The Earth's rate of rotation against the stars [rad/s] (WGS 84)."""

SIDEREAL_DAY = 2 * math.pi / EARTH_ROTATION
"""Time of one turn of the Earth against the stars [s]; 3 min 56 s less than 24 hours.
"""

EQUATOR_GRAVITY = 9.7803253359
GRAVITY_RISE = 0.00193185265241
ECCENTRICITY_SQUARED = 0.00669437999013
"""Normal gravity at the equator [m/s^2], and how it grows and flattens towards a pole
[1] (WGS 84, NIMA TR8350.2)."""

VISCOUS = 1.0
"""Exponent of the drag of an air film."""


# --- g, bodies and torque ---


def normal_gravity(latitude: ArrayLike) -> Any:
    """Acceleration of free fall [m/s^2] at sea level and a latitude.

    It is calculated by Somigliana's formula (WGS 84).

    The local value differs from it by 0.003 % for every 100 m of height, and by 0.005 %
    or so by what is underground.
    """
    sine = np.sin(latitude)
    square = sine**2
    rise = 1 + GRAVITY_RISE * square
    flattening = np.sqrt(1 - ECCENTRICITY_SQUARED * square)
    raised = EQUATOR_GRAVITY * rise
    return raised / flattening


def solid_ball_inertia(mass: float, diameter: float) -> float:
    """Moment of inertia of a homogeneous ball, 2/5 m r² [kg*m^2].

    It is the same about any axis through the centre of the ball.
    """
    return 0.4 * mass * (diameter / 2) ** 2


def bored_ball_inertia(
    mass: float, diameter: float, bore_diameter: float, bore_depth: float
) -> float:
    """Moment of inertia [kg*m^2] of a ball about a cylindrical bore along a radius.

    The mass is that of the bored ball. The bore is near the axis, so of two balls of
    the same mass the bored one has the larger moment of inertia. The round end of the
    bore at the surface is treated as flat.
    """
    radius = diameter / 2
    bore_radius = bore_diameter / 2
    bore_volume = math.pi * bore_radius**2 * bore_depth
    full_volume = 4 / 3 * math.pi * radius**3
    volume = full_volume - bore_volume
    density = mass / volume
    # Moments of inertia over the density [m^5].
    full_ball = 8 / 15 * math.pi * radius**5
    bore = bore_volume * bore_radius**2 / 2
    return density * (full_ball - bore)


def cylinder_inertia(mass: float, diameter: float) -> float:
    """Moment of inertia of a rod or a disk about its own axis, ½ m r² [kg*m^2]."""
    return 0.5 * mass * (diameter / 2) ** 2


def torque(mass: ArrayLike, position: ArrayLike, g: float) -> Any:
    """Torque of a weight about the centre of the ball, rod horizontal: m g x [N*m].

    Its sinθ, eq. (6), is on both sides of eq. (8) and cancels.
    """
    moment = np.multiply(mass, position)
    return moment * g


# --- steady precession, eqs. (8) and (9) ---


def precession_rate(
    torque: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike = 0.0,
    pitch: ArrayLike = 0.0,
) -> Any:
    """Slow rate of steady precession: eq. (8), which is eq. (9) for a horizontal rod.

    φ̇ [rad/s]; NaN if no steady precession exists: rod up (for a positive torque and I
    > I_zz) and spin below `least_spin`, or a level rod that does not spin. 0 for no
    torque. With no spin, and the rod hanging, the positive one of the two rates of a
    conical pendulum.

    a φ̇² + b φ̇ − h m g = 0, with b = I_zz × spin and a = (I_zz − I) cosθ, is solved as
    2 h m g/(b + sgn(b)√D), D = b² + 4 a h m g: the textbook form is 0/0 for a
    horizontal rod and loses all digits near it. Where D nearly vanishes the rate itself
    is ill-conditioned: a relative error ε of D/b² moves it by √ε.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        load = np.asarray(torque, dtype=float)
        curvature = _curvature(inertia, transverse_inertia, pitch)
        doubled = _doubled(load, spin, inertia, curvature)
        rate = 2 * load / doubled
    # A level rod without spin cannot balance a torque; without a torque the rod stays
    # at rest.
    level_without_spin = np.where(load == 0, 0.0, np.nan)
    return np.where(doubled == 0, level_without_spin, rate)[()]


def fast_precession_rate(
    torque: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    pitch: ArrayLike,
) -> Any:
    """Fast rate of steady precession, the other root of eq. (8), rare in a lab.

    φ̇ [rad/s]; NaN if no steady precession exists; infinite if there is only the slow
    one, for a level rod or I = I_zz. Without a torque, the free precession of a
    spinning body.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        load = np.asarray(torque, dtype=float)
        curvature = _curvature(inertia, transverse_inertia, pitch)
        doubled = _doubled(load, spin, inertia, curvature)
        return -doubled / (2 * curvature)


def _curvature(
    inertia: ArrayLike, transverse_inertia: ArrayLike, pitch: ArrayLike
) -> Any:
    """Give a = (I_zz − I) cosθ, the factor of φ̇² in eq. (8) [kg*m^2]."""
    return np.subtract(inertia, transverse_inertia) * np.sin(pitch)


def _doubled(load: Any, spin: ArrayLike, inertia: ArrayLike, curvature: Any) -> Any:
    """Give b + sgn(b)√D of eq. (8), curvature a; sgn(0) is the sign of that zero."""
    momentum = np.multiply(inertia, spin)
    discriminant = momentum * momentum + 4 * curvature * load
    return momentum + np.copysign(np.sqrt(discriminant), momentum)


def horizontal_precession_rate(
    torque: ArrayLike, spin: ArrayLike, inertia: ArrayLike
) -> Any:
    """Rate of steady precession of a horizontal rod, eq. (9): h m g/(I_zz ψ̇) [rad/s].

    NaN for a spin of zero.
    """
    momentum = np.multiply(inertia, spin)
    divisor = np.where(momentum == 0, np.nan, momentum)
    return np.divide(torque, divisor)


# --- a spin that falls while it is timed ---


def sinhc(x: Any) -> Any:
    """Compute sinh(x)/x, and its limit 1 at 0."""
    is_zero = np.equal(x, 0.0)
    safe = np.where(is_zero, 1.0, x)
    sine = np.sinh(safe)
    ratio = sine / safe
    return np.where(is_zero, 1.0, ratio)[()]


def harmonic_mean_spin(
    start: ArrayLike, end: ArrayLike, exponent: ArrayLike = VISCOUS
) -> Any:
    """Mean in time of a decaying spin, as eq. (9) needs it: the harmonic one [rad/s].

    G²/L for viscous drag, with the geometric mean G and the logarithmic mean L of both
    readings; G for p = 1/2; L for dry friction; 2ab/(a + b) for p = 2.

    The law hardly matters for a small decay: mean/G = 1 + (1 − 2p) d²/24 + …, see
    `decay_law_doubt`.
    """
    half = _half_decay(start, end)
    share = np.multiply(exponent, half)
    geometric_mean = np.multiply(start, np.exp(-half))
    return geometric_mean * sinhc(half - share) / sinhc(share)


def _half_decay(start: ArrayLike, end: ArrayLike) -> Any:
    """Give d/2, half the logarithm of the ratio of two spins [1]."""
    return np.log(np.divide(start, end)) / 2


def harmonic_mean_spin_share(start: ArrayLike, end: ArrayLike) -> Any:
    """Relative change of `harmonic_mean_spin` for a relative change of the start [1].

    The formula is for viscous drag.

    1/2 if the spin does not change. The share of the end is the rest, because the mean
    scales with the readings.
    """
    half = _half_decay(start, end)
    is_small = np.abs(half) < 1e-4
    safe = np.where(is_small, 1.0, half)
    # coth(x) − 1/x and its limit x/3
    langevin = 1 / np.tanh(safe) - 1 / safe
    langevin = np.where(is_small, half / 3, langevin)
    rest = 1 - langevin
    return rest / 2


def simpson_mean_spin(start: ArrayLike, half: ArrayLike, end: ArrayLike) -> Any:
    """Harmonic mean in time [rad/s] of a spin read at start, midpoint and end.

    The method is Simpson's rule for 1/ψ̇.

    The formula is smooth in the readings, so that their noise does no harm if the spin
    hardly falls.

    6/(1/start + 4/half + 1/end); for a viscous decay low by d⁴/2880 of itself with d =
    ln(start/end), which is 8e-5 for a spin that falls by half, and as good for any
    other smooth decay.
    """
    at_start = np.divide(1, start)
    at_half = np.divide(4, half)
    at_end = np.divide(1, end)
    return 6 / (at_start + at_half + at_end)


def decay_law_doubt(start: ArrayLike, end: ArrayLike) -> Any:
    """Relative change of I_zz [1] if the spin fell by dry friction: −d²/12.

    Logarithmic mean (dry friction) in the place of `harmonic_mean_spin`, as a ratio
    minus 1, which is the change of I_zz because the inertia is proportional to 1/spin.
    """
    viscous = harmonic_mean_spin(start, end)
    dry = harmonic_mean_spin(start, end, 0.0)
    ratio = viscous / dry
    return ratio - 1


# --- stability ---


def least_spin(
    torque: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    pitch: ArrayLike,
) -> Any:
    """Return the minimum spin for steady precession, from D = 0 in eq. (8).

    2√((I − I_zz) cosθ h m g)/I_zz [rad/s]; 0 if every spin has a steady precession. A
    level rod under a torque needs a spin above 0.
    """
    curvature = _curvature(inertia, transverse_inertia, pitch)
    square = np.maximum(-curvature * np.asarray(torque), 0.0)
    return 2 * np.sqrt(square) / inertia


def sleeping_spin(
    torque: ArrayLike, inertia: ArrayLike, transverse_inertia: ArrayLike
) -> Any:
    """Total spin above which an upright rod "sleeps": 2√(I h m g)/I_zz [rad/s].

    From the motion linearised about the vertical; 0 if every spin is enough. The torque
    is that of the horizontal rod. It is negative for a rod that hangs straight down, or
    a weight below the centre, which is stable at any spin.
    """
    square = np.maximum(np.multiply(transverse_inertia, torque), 0.0)
    return 2 * np.sqrt(square) / inertia


def sleeping_growth(
    torque: ArrayLike,
    total_spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
) -> Any:
    """Rate at which a small tilt of an upright rod grows: √(h m g/I − (I_zz ω3/2I)²).

    Rate [1/s]: the tilt grows e-fold in its inverse; 0 if the rod sleeps. For small
    tilts.
    """
    falling = np.divide(torque, transverse_inertia)
    holding = np.multiply(inertia, total_spin) / np.multiply(2.0, transverse_inertia)
    stiffness = holding * holding
    square = falling - stiffness
    return np.sqrt(np.maximum(square, 0.0))


# --- a rod released from rest ---


def sag_size(
    torque: ArrayLike,
    spin: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    pitch: ArrayLike,
) -> Any:
    """Size of the greatest sag of a rod that is released from rest [rad], above 0.

    It is the angle from the direction at the release to the lowest one, or to the
    highest one if the torque is negative. (`motion.Nutation` has sags with a sign.)

    Energy and angular momentum are conserved: with z the sine of the pitch, from z0 on,
    it turns back at 2δ (1 − z²) = z0 − z.
    """
    high = np.sign(torque) * np.sin(pitch)
    pull = np.multiply(transverse_inertia, torque)
    momentum = np.multiply(inertia, spin)
    mean_sag = pull / momentum**2
    # 1/(2δ)
    stiff = 0.5 / np.abs(mean_sag)
    discriminant = (stiff - 2 * high) ** 2 + 4 * (1 - high**2)
    low = (stiff - np.sqrt(discriminant)) / 2
    lowest = np.arcsin(np.maximum(low, -1.0))
    start = np.arcsin(high)
    return start - lowest


def spin_of_sag(
    sag: float,
    torque: ArrayLike,
    inertia: ArrayLike,
    transverse_inertia: ArrayLike,
    pitch: ArrayLike,
) -> Any:
    """Spin [rad/s] at which a released rod sags by an angle; see `sag_size`."""
    high = np.sign(torque) * np.sin(pitch)
    low = np.sin(np.arcsin(high) - sag)
    pull = np.multiply(transverse_inertia, np.abs(torque))
    momentum_squared = 2 * pull * (1 - low**2) / (high - low)
    return np.sqrt(momentum_squared) / inertia


def click_error(
    spin: ArrayLike, inertia: ArrayLike, transverse_inertia: ArrayLike
) -> Any:
    """Largest error of one click of the stopwatch: I/(I_zz ψ̇).

    The cause is that the phase of the nutation is not known.

    Time [s], for a released rod, whatever the weight; 1/√2 of it is its root mean
    square.

    In cusps φ = φ̇ (t − sin(ν t)/ν) with the nutation rate ν = I_zz ψ̇/I: up to 1/ν
    early or late.
    """
    momentum = np.multiply(inertia, spin)
    size = np.abs(momentum)
    return np.divide(transverse_inertia, size)


# --- demonstrations: a bicycle wheel on a turntable, the Earth that turns below ---


def platform_rate(
    wheel_inertia: ArrayLike,
    wheel_spin: ArrayLike,
    platform_inertia: ArrayLike,
    start: ArrayLike,
    end: ArrayLike,
) -> Any:
    """Rate of a turntable [rad/s] after a spinning wheel held on it was tipped.

    The turntable is at rest at first. `platform_inertia` is that of turntable, person
    and wheel about the vertical, but for the wheel's own spin; `start` and `end` are
    angles of the axle above the horizontal. The rate is positive in the sense of a
    wheel that spins with its axle upright. The angular momentum about the vertical is
    conserved: I_p Ω = I_w ω (sin(start) − sin(end)).
    """
    # sin(start) − sin(end) without cancellation
    mean = np.add(start, end) / 2
    half_difference = np.subtract(start, end) / 2
    change = 2 * np.cos(mean) * np.sin(half_difference)
    momentum = np.multiply(wheel_inertia, wheel_spin)
    gained = momentum * change
    return gained / platform_inertia


def balanced_direction(
    azimuth: ArrayLike, altitude: ArrayLike, latitude: ArrayLike, time: ArrayLike
) -> tuple[Any, Any]:
    """Where a balanced spinning gyroscope points after a time: at the same star.

    Azimuth in [0, 2π) and altitude [rad]; the azimuth is NaN if the rod points straight
    up or down, within 1e-12 rad.

    Against the ground the sky turns about the Earth's axis, which points north at the
    altitude of the latitude, from east to west: a turn of the direction by −Ω t about
    that axis (Rodrigues' formula).
    """
    rod_east = np.cos(altitude) * np.sin(azimuth)
    rod_north = np.cos(altitude) * np.cos(azimuth)
    rod_up = np.sin(altitude)
    # The Earth's axis has no part to the east.
    axis_north = np.cos(latitude)
    axis_up = np.sin(latitude)
    turned = -EARTH_ROTATION * np.asarray(time, dtype=float)
    sine = np.sin(turned)
    cosine = np.cos(turned)
    along = axis_north * rod_north + axis_up * rod_up
    share = 2 * np.sin(turned / 2) ** 2
    across_east = axis_north * rod_up - axis_up * rod_north
    across_north = axis_up * rod_east
    across_up = axis_north * rod_east
    east = rod_east * cosine + across_east * sine
    north = rod_north * cosine + across_north * sine + axis_north * along * share
    up = rod_up * cosine - across_up * sine + axis_up * along * share
    away = np.hypot(east, north)
    bearing = np.mod(np.arctan2(east, north), 2 * np.pi)
    # A direction just west of north is rounded to a whole turn.
    bearing = np.where(bearing >= 2 * np.pi, 0.0, bearing)
    is_vertical = np.isclose(away, 0.0, atol=1e-12)
    bearing = np.where(is_vertical, np.nan, bearing)
    return bearing[()], np.arctan2(up, away)
