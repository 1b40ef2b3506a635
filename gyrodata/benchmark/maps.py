"""Where formulas and integrators lose digits: maps over tilt and spin, each method that fails beside one that holds.

The truth of `map_roots` is the slow root of eq. (8) in fifty decimal digits, of the same numbers that the formulas get;
that of `map_integrators` is the exact motion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np
from numpy.typing import ArrayLike

from gyrodata import motion, physics
from gyrodata.benchmark.effort import Effort, Progress
from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats

MOST_DIGITS = 16.0
"""A double holds no more."""

INERTIA = 4.44e-3
"""I_zz [kg*m^2]: a 4-inch steel ball."""

MASS, POSITION = 0.060, 0.15
"""The heaviest weight of a typical lab [kg], and where it hangs [m]."""

TORQUE = MASS * POSITION * physics.STANDARD_GRAVITY
"""[N*m]"""

ACROSS = DEFAULT_TRANSVERSE_RATIO * INERTIA + MASS * POSITION**2
"""I across the rod [kg*m^2]."""

TIME = 5.0
"""[s]"""

STEP = 0.002
"""Of the integrators with a fixed step [s]: what engines for robots and games take if nobody says otherwise."""


@dataclass(frozen=True)
class DigitMap:
    """Correct digits of one method over a plane."""

    method: str
    digits: Floats
    """Shape (y, x), 0 to `MOST_DIGITS`; NaN where there is nothing to compute."""


@dataclass(frozen=True)
class MapPair:
    """A method that fails somewhere, and one that does not, over the same plane."""

    name: str
    title: str
    x_label: str
    x: Floats
    """Spin [rpm], on a logarithmic axis."""
    y_label: str
    y: Floats
    """Tilt [degrees], or powers of ten."""
    fails: DigitMap
    holds: DigitMap
    empty: str
    """What is so where there is nothing to compute; "" where that is nowhere."""


def digits(error: ArrayLike) -> Floats:
    """Correct digits for a relative error: −log10, from 0 to `MOST_DIGITS`; what is not finite is 0."""
    size = np.abs(np.asarray(error, dtype=float))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.clip(-np.log10(size), 0.0, MOST_DIGITS) + 0.0
    return np.where(np.isnan(size), 0.0, found)


# --- formulas for the rate of steady precession ----------------------------------------------------------------


@dataclass(frozen=True)
class _Plane:
    """Pairs of pitch and spin, flattened."""

    pitch: Floats
    """[rad]"""
    spin: Floats
    """[rad/s]"""
    true: Floats
    """Slow rate of eq. (8) [rad/s]; NaN where there is none."""
    shape: tuple[int, int]

    def map(self, method: str, rate: Floats) -> DigitMap:
        """Correct digits of a rate by a method; NaN where there is no true one."""
        right = np.where(np.isnan(self.true), np.nan, digits(rate / self.true - 1))
        return DigitMap(method, right.reshape(self.shape))

    def eight(self) -> Floats:
        """Slow rate of eq. (8) by the tool [rad/s]."""
        rate: Floats = physics.precession_rate(TORQUE, self.spin, INERTIA, ACROSS, self.pitch)
        return rate


def map_roots(effort: Effort) -> list[MapPair]:
    """Map formulas for the rate of steady precession, over tilt and spin, and over cosθ → 0 and spin."""
    rpm = np.geomspace(20, 1000, effort.fine_grid)
    tilts = np.linspace(-80, 80, effort.fine_grid)
    powers = np.linspace(-0.1, -17, effort.fine_grid)
    tilted, level = _plane(np.radians(tilts), rpm * RPM), _plane(np.arcsin(10**powers), rpm * RPM)
    return [
        MapPair(
            "tilt", "rod tilted", "spin [rpm]", rpm, "rod above the horizontal [°]", tilts,
            tilted.map("eq. (9)", physics.horizontal_precession_rate(TORQUE, tilted.spin, INERTIA)),
            tilted.map("eq. (8)", tilted.eight()),
            "no steady precession",
        ),
        MapPair(
            "level", "rod nearly level, cosθ → 0", "spin [rpm]", rpm, "log10 cosθ", powers,
            level.map("eq. (8), textbook root (−b + √D)/2a", textbook_root(level.spin, level.pitch)),
            level.map("eq. (8), root 2c/(b + √D)", level.eight()),
            "no steady precession",
        ),
    ]  # fmt: skip


def textbook_root(spin: Floats, pitch: Floats) -> Floats:
    """Slow root of eq. (8) by the formula of school [rad/s], (−b + √D)/2a, which loses digits as cosθ → 0."""
    a, b = (INERTIA - ACROSS) * np.sin(pitch), INERTIA * spin
    with np.errstate(divide="ignore", invalid="ignore"):
        root: Floats = (-b + np.sqrt(b * b + 4 * a * TORQUE)) / (2 * a)
    return root


def _plane(pitches: Floats, spins: Floats) -> _Plane:
    pitch, spin = (part.ravel() for part in np.meshgrid(pitches, spins, indexing="ij"))
    return _Plane(pitch, spin, _true_rates(np.sin(pitch), spin), (len(pitches), len(spins)))


def _true_rates(heights: Sequence[float] | Floats, spins: Sequence[float] | Floats) -> Floats:
    """Slow root of eq. (8) in 50 digits [rad/s], for cosθ and ψ̇ as they are; NaN where there is none."""
    rates = np.full(len(spins), np.nan)
    with localcontext() as context:
        context.prec = 50
        inertia, load = Decimal(INERTIA), Decimal(TORQUE)
        difference = inertia - Decimal(ACROSS)
        for i, (height, spin) in enumerate(zip(heights, spins, strict=True)):
            linear = inertia * Decimal(float(spin))
            square = linear * linear + 4 * difference * Decimal(float(height)) * load
            if square >= 0:
                rates[i] = float(2 * load / (linear + square.sqrt()))
    return rates


# --- integrators -----------------------------------------------------------------------------------------------


def map_integrators(effort: Effort, progress: Progress | None = None) -> list[MapPair]:
    """Map integrators over tilt and spin."""
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


def one_top(top: motion.Top, state: motion.State, i: int) -> tuple[motion.Top, motion.State]:
    """Take one of several tops, with its state."""
    one = motion.Top(float(top.inertia[i]), float(top.transverse_inertia[i]), float(top.torque[i]))
    return one, motion.State(state.axis[i], state.momentum[i])


def _integrated(
    top: motion.Top, start: motion.State, method: str, tolerance: float, tell: Callable[[float], None]
) -> Floats:
    ends = np.empty_like(start.axis)
    for i in range(len(ends)):
        one = one_top(top, start, i)
        ends[i] = motion.integrate(*one, TIME, method=method, rtol=tolerance, atol=1e-3 * tolerance).axis
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
