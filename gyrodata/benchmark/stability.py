"""Where methods break over tilt and spin, and near the vertical: each that fails beside one that holds.

In the maps and along cosθ formulas and integrators lose digits. The truth of `map_roots` is the slow root of eq. (8)
in fifty decimal digits, of the same numbers that the formulas get; that of `map_integrators` is the exact motion.

In a passage a way of writing the motion loses digits where sinθ → 0, or dies: the rod swings from 43° off the vertical
to a smallest angle θ_min and back, as a top that nods. Eqs. (7) in Euler angles divide by sinθ, their form reduced by
the two conserved momenta by sin²θ; the vectors e3 and H divide by nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Literal

import numpy as np
from msgspec import Struct
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


class DigitMap(Struct, frozen=True):
    """Correct digits of one method over a plane."""

    method: str
    digits: Floats
    """Shape (y, x), 0 to `MOST_DIGITS`; NaN where there is nothing to compute."""
    evaluations: float | None = None
    """Of the torque for one top, median over the map; None where nothing is integrated."""


class MapPair(Struct, frozen=True):
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


class _Plane(Struct, frozen=True):
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


class DigitCurve(Struct, frozen=True):
    """Correct digits of one formula for the rate, the nearer the rod is to level, or to the vertical."""

    end: Literal["level", "vertical"]
    method: str
    away: Floats
    """|cosθ|, or 1 − cosθ."""
    middle: Floats
    """Median over the spins."""
    worst: Floats
    """Least over the spins."""


def follow_cosines(effort: Effort) -> list[DigitCurve]:
    """Follow formulas for the rate of steady precession as cosθ → 0 and as cosθ → 1.

    Spins are 60 to 1000 rpm, and the least one with which an upright rod has a steady precession: D vanishes there.
    """
    # A little above, so that the root exists in doubles too.
    upright = (1 + 1e-15) * float(physics.least_spin(TORQUE, INERTIA, ACROSS, np.pi / 2))
    spins = np.append(np.geomspace(60, 1000, 24) * RPM, upright)
    curves: list[DigitCurve] = []
    heights: dict[Literal["level", "vertical"], Floats] = {
        "level": 10 ** np.linspace(-0.1, -17, effort.fine_grid),
        "vertical": 1 - 10 ** np.linspace(-0.1, -15.5, effort.fine_grid),
    }
    for end, height in heights.items():
        plane = _plane(np.arcsin(height), spins)
        root = [_exact_root(*pair) for pair in zip(np.sin(plane.pitch), plane.spin, strict=True)]
        rates = {
            "eq. (9)": physics.horizontal_precession_rate(TORQUE, plane.spin, INERTIA),
            "eq. (8), (−b + √D)/2a": textbook_root(plane.spin, plane.pitch),
            "eq. (8), 2c/(b + √D)": plane.eight(),
            "the same, D in fractions": 2 * TORQUE / (INERTIA * plane.spin + np.array(root)),
        }
        true = np.sin(plane.pitch.reshape(plane.shape)[:, 0])
        away = true if end == "level" else 1 - true
        for method, rate in rates.items():
            right = plane.map(method, rate).digits
            curves.append(DigitCurve(end, method, away, np.nanmedian(right, axis=1), np.nanmin(right, axis=1)))
    return curves


def _exact_root(height: float, spin: float) -> float:
    """√D of eq. (8) for cosθ and ψ̇ as they are, rounded once; NaN where there is none."""
    linear = Fraction(INERTIA) * Fraction(float(spin))
    square = linear**2 + 4 * (Fraction(INERTIA) - Fraction(ACROSS)) * Fraction(float(height)) * Fraction(TORQUE)
    return math.sqrt(square) if square >= 0 else math.nan


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

    def mapped(method: str, path: motion.State, evaluations: Floats | float) -> DigitMap:
        right = digits(np.linalg.norm(path.axis - true, axis=-1)).reshape(shape)
        return DigitMap(method, right, float(np.median(evaluations)))

    def pair(name: str, title: str, fails: DigitMap, holds: DigitMap) -> MapPair:
        return MapPair(name, title, "spin [rpm]", rpm, "rod above the horizontal [°]", tilts, fails, holds, "")

    # A slow top nods as a pendulum swings.
    nutations = np.hypot(INERTIA * spin / ACROSS, np.sqrt(TORQUE / ACROSS)) * TIME / (2 * np.pi)
    tell = progress or (lambda _part: None)
    kicks, steps = len(motion.METHODS["aba84"][1]), round(TIME / STEP)
    # As many evaluations as Euler has.
    fewer = steps // kicks
    loose = _integrated(top, start, "RK45", 1e-3, lambda part: tell(0.3 * part))
    tight = _integrated(top, start, "DOP853", 1e-8, lambda part: tell(0.3 + 0.7 * part))
    euler = motion.State(euler_axis(spin, pitch, TIME, STEP), start.momentum)
    return [
        pair(
            "tolerance", "5 s after its release: the tolerance",
            mapped("RK45, rtol 1e-3 (the default)", *loose), mapped("DOP853, rtol 1e-8", *tight),
        ),
        pair(
            "engine", "5 s after its release: one step for all",
            mapped("Euler, semi-implicit, 2 ms", euler, steps),
            mapped("splitting aba84, 10 ms", motion.split(top, start, TIME, fewer), kicks * fewer),
        ),
        pair(
            "steps", "5 s after its release: steps a nutation",
            mapped("splitting aba84, 1.5 steps a nutation", *_split(top, start, nutations, 1.5)),
            mapped("splitting aba84, 12 steps a nutation", *_split(top, start, nutations, 12.0)),
        ),
    ]  # fmt: skip


def _integrated(
    top: motion.Top, start: motion.State, method: str, tolerance: float, tell: Callable[[float], None]
) -> tuple[motion.State, Floats]:
    """Each top alone, with steps of its own; and how often each asked for the torque."""
    ends, evaluations = np.empty_like(start.axis), np.empty(len(start.axis))
    for i in range(len(ends)):
        one = motion.Top(float(top.inertia[i]), float(top.transverse_inertia[i]), float(top.torque[i]))
        state = motion.State(start.axis[i], start.momentum[i])
        path = motion.integrate(one, state, TIME, method=method, rtol=tolerance, atol=1e-3 * tolerance)
        ends[i], evaluations[i] = path.axis, path.evaluations
        tell((i + 1) / len(ends))
    return motion.State(ends, start.momentum), evaluations


def _split(top: motion.Top, start: motion.State, nutations: Floats, per: float) -> tuple[motion.State, Floats]:
    """Each top with so many steps a nutation; and how often each asked for the torque."""
    ends = np.empty_like(start.axis)
    for steps in np.unique(whole := np.maximum(np.ceil(per * nutations), 1).astype(int)):
        members = np.flatnonzero(whole == steps)
        some = motion.Top(top.inertia[members], top.transverse_inertia[members], top.torque[members])
        state = motion.State(start.axis[members], start.momentum[members])
        ends[members] = motion.split(some, state, TIME, int(steps)).axis
    return motion.State(ends, start.momentum), len(motion.METHODS["aba84"][1]) * whole


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


# --- orbits that pass near the vertical ------------------------------------------------------------------------

LOW = math.radians(43)
"""θ at the lower turning point [rad]."""

SLEEPING_SPIN = 300 * RPM
"""ω3 [rad/s]; such a top sleeps."""

PASSING = 10.0
"""How long an orbit is followed [s]."""

_TOLERANCE = 1e-9


class Passage(Struct, frozen=True):
    """One way of writing the motion, on an orbit that passes the vertical at one distance."""

    method: str
    closest: float
    """θ_min [rad]; 0 for a rod that is started at the vertical."""
    error: float | None
    """Distance of e3 from the true one at its worst in `PASSING` [1]; None where it gives no number."""
    evaluations: int | None
    """Of the right-hand side; None for the exact motion."""


METHODS = ("eqs. (7), Euler angles", "reduced to θ", "vectors e3, H", "splitting aba84", "exact motion")
"""Ways of writing the motion, the failing ones first."""


def pass_upright(effort: Effort, progress: Progress | None = None) -> list[Passage]:
    """Follow orbits that pass ever nearer to the vertical, and one that starts there, by all `METHODS`.

    Errors are distances from the exact motion; its own is from the vectors at a tolerance of 1e-13, mostly theirs.
    """
    distances = [*(float(d) for d in np.geomspace(0.3, 1e-8, effort.swings)), 0.0]
    passages = []
    for i, closest in enumerate(distances):
        passages += _pass_once(closest)
        if progress is not None:
            progress((i + 1) / len(distances))
    return passages


def _pass_once(closest: float) -> list[Passage]:
    top = motion.Top(INERTIA, ACROSS, TORQUE)
    state = nodding(closest)
    times = np.linspace(0, PASSING, 41)[1:]
    true = motion.exact(top, state, times).axis
    found = []
    for method, follow in ((METHODS[0], follow_euler), (METHODS[1], follow_reduced)):
        axis, evaluations = follow(state, times)
        found.append(Passage(method, closest, _worst(axis, true), evaluations))
    path = motion.integrate(top, state, times, rtol=_TOLERANCE)
    found.append(Passage(METHODS[2], closest, _worst(path.axis, true), path.evaluations))
    steps, kicks = 2000, len(motion.METHODS["aba84"][1])
    split = motion.split(top, state, times[-1], steps).axis
    found.append(Passage(METHODS[3], closest, _worst(split[None], true[-1:]), steps * kicks))
    tight = motion.integrate(top, state, times, rtol=1e-13, atol=1e-15)
    return [*found, Passage(METHODS[4], closest, _worst(tight.axis, true), None)]


def _worst(axis: Floats | None, true: Floats) -> float | None:
    if axis is None:
        return None
    return float(np.max(np.linalg.norm(axis - true, axis=-1)))


def nodding(closest: float) -> motion.State:
    """The state at the lower turning point, `LOW`, of an orbit whose upper one is at an angle from the vertical.

    At both turning points (H·Z − H3 cosθ)²/(2 I sin²θ) + h m g cosθ is the same. With H·Z = H3 cosθ_min +
    q sinθ_min this is a quadratic in q that stays regular as θ_min → 0.
    """
    along = INERTIA * SLEEPING_SPIN
    below, above = math.sin(LOW), math.sin(closest)
    # cosθ_min − cosθ_low, without cancellation.
    rise = 2 * math.sin((LOW + closest) / 2) * math.sin((LOW - closest) / 2)
    drop = along * rise
    a, b = 1 - (above / below) ** 2, above * drop / below**2
    c = (drop / below) ** 2 - 2 * ACROSS * TORQUE * rise
    q = (b + math.sqrt(b * b + a * c)) / a
    if closest == 0:
        return motion.State(np.array([0.0, 0.0, 1.0]), np.array([q, 0.0, along]))
    across = (drop + q * above) / below
    axis = np.array([below, 0.0, math.cos(LOW)])
    return motion.State(axis, along * axis + across * np.array([-math.cos(LOW), 0.0, below]))


# --- the ways that fail -------------------------------------------------------------------------------------


def follow_euler(state: motion.State, times: Floats, tolerance: float = _TOLERANCE) -> tuple[Floats | None, int]:
    """Follow the rod by eqs. (7) in the Euler angles: e3 at the times, None without a number; and evaluations."""
    along = float(state.axis @ state.momentum)

    def rates(_time: float, row: Floats) -> Sequence[float]:
        angle, turning, nodding, _ = row.tolist()
        sine, cosine = math.sin(angle), math.cos(angle)
        falling = (ACROSS * turning**2 * cosine - along * turning + TORQUE) * sine / ACROSS
        return [nodding, (along - 2 * ACROSS * turning * cosine) * nodding / (ACROSS * sine), falling, turning]

    try:
        angle, turning = _start(state)
    except ZeroDivisionError:
        return None, 0
    return _followed(rates, [angle, turning, 0.0, 0.0], times, tolerance, (0, 3))


def follow_reduced(state: motion.State, times: Floats, tolerance: float = _TOLERANCE) -> tuple[Floats | None, int]:
    """Follow the rod by the equation of θ alone that the conserved H·Z and H·e3 leave: as `follow_euler`."""
    along, upwards = float(state.axis @ state.momentum), float(state.momentum[2])

    def rates(_time: float, row: Floats) -> Sequence[float]:
        angle, nodding, _ = row.tolist()
        sine, cosine = math.sin(angle), math.cos(angle)
        turning = (upwards - along * cosine) / (ACROSS * sine**2)
        falling = (ACROSS * turning**2 * cosine - along * turning + TORQUE) * sine / ACROSS
        return [nodding, falling, turning]

    return _followed(rates, [math.acos(state.axis[2]), 0.0, 0.0], times, tolerance, (0, 2))


def _start(state: motion.State) -> tuple[float, float]:
    """θ [rad] and φ̇ [rad/s] at the start."""
    sine = float(np.hypot(state.axis[0], state.axis[1]))
    across = float(state.momentum[2] - state.axis[2] * (state.axis @ state.momentum))
    return math.atan2(sine, float(state.axis[2])), across / (ACROSS * sine**2)


def _followed(
    rates: Callable[[float, Floats], Sequence[float]],
    start: list[float],
    times: Floats,
    tolerance: float,
    places: tuple[int, int],
) -> tuple[Floats | None, int]:
    from scipy.integrate import solve_ivp

    count = 0

    def counted(time: float, row: Floats) -> Sequence[float]:
        nonlocal count
        count += 1
        return rates(time, row)

    try:
        done = solve_ivp(counted, (0, times[-1]), start, "DOP853", times, rtol=tolerance, atol=1e-12)
    except (ZeroDivisionError, OverflowError):
        return None, count
    angle, azimuth = (done.y[place] for place in places)
    if not done.success or not np.isfinite(done.y).all():
        return None, count
    return np.stack([np.sin(angle) * np.cos(azimuth), np.sin(angle) * np.sin(azimuth), np.cos(angle)], axis=-1), count
