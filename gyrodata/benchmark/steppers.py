"""Integrators over tilt and spin: how many digits of the rod's direction each leaves, some seconds after its release.

The exact motion is the truth; one that fails stands beside one that holds.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gyrodata import motion
from gyrodata.benchmark.effort import Effort, Progress
from gyrodata.benchmark.maps import DigitMap, MapPair, digits
from gyrodata.benchmark.roots import ACROSS, INERTIA, RPM, TORQUE
from gyrodata.physics import Floats

TIME = 5.0
"""[s]"""

STEP = 0.002
"""Of the integrators with a fixed step [s]: what engines for robots and games take if nobody says otherwise."""


def map_integrators(effort: Effort, progress: Progress | None = None) -> list[MapPair]:
    """Map integrators over tilt and spin.

    Parameters
    ----------
    effort : Effort
    progress : callable, optional
        Told the part that is done.

    Returns
    -------
    list of MapPair
    """
    rpm, tilts = np.geomspace(30, 1000, effort.grid), np.linspace(-75, 75, effort.grid)
    pitch, spin = (part.ravel() for part in np.meshgrid(np.radians(tilts), rpm * RPM, indexing="ij"))
    top = motion.Top(np.full(len(spin), INERTIA), np.full(len(spin), ACROSS), np.full(len(spin), TORQUE))
    start = motion.released(top, spin, pitch)
    true = motion.exact(top, start, TIME).axis
    shape = (len(tilts), len(rpm))

    def right(axis: Floats) -> Floats:
        return digits(np.linalg.norm(axis - true, axis=-1)).reshape(shape)

    def pair(name: str, title: str, fails: tuple[str, Floats], holds: tuple[str, Floats]) -> MapPair:
        bad, good = (DigitMap(method, right(axis)) for method, axis in (fails, holds))
        return MapPair(name, title, "spin [rpm]", rpm, "rod above the horizontal [°]", tilts, bad, good, "")

    # A slow top nods as a pendulum swings.
    nutations = np.hypot(INERTIA * spin / ACROSS, np.sqrt(TORQUE / ACROSS)) * TIME / (2 * np.pi)
    tell = progress or (lambda _part: None)
    loose = ("RK45, rtol 1e-3 (the default)", _integrated(top, start, "RK45", 1e-3, lambda part: tell(0.3 * part)))
    tight = ("DOP853, rtol 1e-8", _integrated(top, start, "DOP853", 1e-8, lambda part: tell(0.3 + 0.7 * part)))
    euler = ("Euler, semi-implicit, 2 ms", euler_axis(spin, pitch, TIME, STEP))
    fixed = ("splitting aba84, 2 ms", motion.split(top, start, TIME, round(TIME / STEP)).axis)
    few = ("splitting aba84, 1.5 steps a nutation", _split(top, start, nutations, 1.5))
    more = ("splitting aba84, 12 steps a nutation", _split(top, start, nutations, 12.0))
    return [
        pair("tolerance", "5 s after its release: the tolerance", loose, tight),
        pair("engine", "5 s after its release: one step for all", euler, fixed),
        pair("steps", "5 s after its release: steps a nutation", few, more),
    ]


def _integrated(
    top: motion.Top, start: motion.State, method: str, tolerance: float, tell: Callable[[float], None]
) -> Floats:
    ends = np.empty_like(start.axis)
    for i in range(len(ends)):
        one = motion.Top(float(top.inertia[i]), float(top.transverse_inertia[i]), float(top.torque[i]))
        state = motion.State(start.axis[i], start.momentum[i])
        ends[i] = motion.integrate(one, state, TIME, method=method, rtol=tolerance, atol=1e-3 * tolerance).axis
        tell((i + 1) / len(ends))
    return ends


def _split(top: motion.Top, start: motion.State, nutations: Floats, per: float) -> Floats:
    ends = np.empty_like(start.axis)
    for steps in np.unique(whole := np.maximum(np.ceil(per * nutations), 1).astype(int)):
        members = np.flatnonzero(whole == steps)
        some = motion.Top(top.inertia[members], top.transverse_inertia[members], top.torque[members])
        state = motion.State(start.axis[members], start.momentum[members])
        ends[members] = motion.split(some, state, TIME, int(steps)).axis
    return ends


def euler_axis(spin: Floats, pitch: Floats, time: float, step: float) -> Floats:
    """Follow rods that are let go from rest by semi-implicit Euler in the body's frame, as physics engines do.

    Parameters
    ----------
    spin : ndarray, shape (n,)
        [rad/s]
    pitch : ndarray, shape (n,)
        [rad]
    time : float
        [s]
    step : float
        [s]

    Returns
    -------
    ndarray, shape (n, 3)
        e3 at the end.

    Notes
    -----
    The rates ω in the frame of the body take a plain Euler step, ω × H included; the orientation, a quaternion, then
    turns exactly with the new ω. The frame spins with the ball, so that the step has to follow every turn of it.
    """
    _, orientation = euler_motion(spin, pitch, time, step)
    w, x, y, z = orientation
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z], axis=-1)


def euler_motion(spin: Floats, pitch: Floats, time: float, step: float) -> tuple[Floats, Floats]:
    """Give the rates in the body's frame, shape (3, n) [rad/s], and the quaternions, shape (4, n), of `euler_axis`."""
    nothing = np.zeros_like(spin)
    rates = np.stack([nothing, nothing, spin])
    # From e3 = Z to the pitch, towards X.
    half = (np.pi / 2 - pitch) / 2
    orientation = np.stack([np.cos(half), nothing, np.sin(half), nothing])
    for _ in range(round(time / step)):
        w, x, y, z = orientation
        up_x, up_y = 2 * (x * z - w * y), 2 * (y * z + w * x)
        # Gravity's torque is h m g Z × e3, and Z × e3 = (Z_y, −Z_x, 0) in the body.
        turn = (ACROSS - INERTIA) * rates[2]
        rates = np.stack(
            [
                rates[0] + step * (TORQUE * up_y + turn * rates[1]) / ACROSS,
                rates[1] + step * (-TORQUE * up_x - turn * rates[0]) / ACROSS,
                rates[2],
            ]
        )
        orientation = _turned(orientation, rates, step)
    return rates, orientation


def _turned(orientation: Floats, rates: Floats, step: float) -> Floats:
    """Quaternions turned by rates in their own frame for a step."""
    speed = np.sqrt(np.sum(rates**2, axis=0))
    half = speed * step / 2
    c = np.cos(half)
    a, b, d = rates * (np.sin(half) / speed)
    w, x, y, z = orientation
    return np.stack(
        [w * c - x * a - y * b - z * d, w * a + x * c + y * d - z * b,
         w * b - x * d + y * c + z * a, w * d + x * b - y * a + z * c]
    )  # fmt: skip
