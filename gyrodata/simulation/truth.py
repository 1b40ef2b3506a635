"""What happens: the gyroscope as it is, what is done with it, and the time that each run then takes.

The spin falls as ψ̇ = ψ̇₀ e^(−t/τ), as in an air film, and the precession follows the slow root of eq. (8),
a φ̇² + I_zz ψ̇ φ̇ − M = 0 with a = (I_zz − I) sin(pitch), at every moment. With φ̇ in the place of the spin as the
variable, φ = ∫ φ̇ dt = −τ ∫ φ̇ dψ̇/ψ̇ becomes

    φ = τ ∫ (M + a φ̇²)/(M − a φ̇²) dφ̇,

an inverse hyperbolic tangent for a M > 0, an arc tangent for a M < 0, and for a level rod, a = 0, just τ (φ̇₁ − φ̇₀).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import Literal, NoReturn, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from gyrodata import motion, physics
from gyrodata.diagnostics import (
    SIMULATED_NO_STEADY_PRECESSION,
    SIMULATED_OPTIONS_CONTRADICT,
    SIMULATED_VALUE_IMPOSSIBLE,
    SIMULATED_WITHOUT_TORQUE,
    TURNS_NEVER_COMPLETED,
)
from gyrodata.errors import Diagnostic, InputError
from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats
from gyrodata.readings import MAX_ROWS, check_value, to_display
from gyrodata.units import LIMITS, SI

Motion = Literal["horizontal", "steady", "released"]


@dataclass(frozen=True, slots=True)
class Decay:
    """How the spin falls, ψ̇ ∝ e^(−t/τ) as in an air film; one of the two is given."""

    time_constant: float | None = None
    """τ [s], the same in every run."""
    lost: float | None = None
    """Part of the spin that each run loses, 1 − end/start [1]; τ then differs from run to run."""


@dataclass(frozen=True, slots=True)
class Truth:
    """The gyroscope as it is, and the hand that times it."""

    inertia: float = 4.44e-3
    """I_zz about the rod [kg*m^2]; 4.44e-3 is a 4-inch steel ball."""
    transverse_inertia: float | None = None
    """I about an axis across the rod through the fixed point, weight on [kg*m^2]; None: that of a ball with a light
    rod, 1.3 I_zz, and m x² of the weight."""
    imbalance: float | None = None
    """M0, residual torque of the balanced rod, with the sign of a weight's at positive position [N*m]; None: drawn
    from ``u_imbalance`` where the noise has it, else 0."""
    timing_bias: float | None = None
    """b, by which the stopwatch reads too much [s]; None: drawn from ``u_time_bias``."""
    g: float = physics.STANDARD_GRAVITY
    """Acceleration of free fall [m/s^2]."""
    motion: Motion = "steady"
    """"horizontal": eq. (9); "steady": eq. (8); "released": the exact motion of a rod let go from rest."""
    decay: Decay | None = None
    """None: the spin stays."""


@dataclass(frozen=True, slots=True)
class Design:
    """What is done: every weight at every position, with every pitch, spin and number of turns."""

    masses: tuple[float, ...] = (0.020, 0.040, 0.060)
    """[kg]; 0 is the rod without a weight, which has no position."""
    positions: tuple[float, ...] = (0.15,)
    """Signed distance from the centre [m]."""
    spins: tuple[float, ...] = (200 * RPM, 400 * RPM, 600 * RPM)
    """At the start of each run [rad/s]; negative: the other way round."""
    turns: tuple[float, ...] = (1.0,)
    """Revolutions of precession that are timed [1]."""
    pitches: tuple[float, ...] = (0.0,)
    """Rod above the horizontal [rad]; where it is let go from for a released one."""
    repeats: int = 1
    """How often each of these is done."""


@dataclass(frozen=True, slots=True)
class Runs:
    """What happened in n runs, without any error; all arrays have shape (n,)."""

    mass: Floats
    """[kg]"""
    position: Floats
    """[m]; 0 where there is no weight."""
    pitch: Floats
    """[rad]"""
    turns: Floats
    """[1]"""
    spin: Floats
    """At the start, signed [rad/s]."""
    spin_end: Floats | None
    """At the end [rad/s]; None where the spin stays."""
    across: Floats
    """I across the rod [kg*m^2]."""
    torque: Floats
    """At work with the rod horizontal: m g x + M0 [N*m]."""
    time: Floats
    """That the turns took [s]."""

    @property
    def sense(self) -> Floats:
        """Sense of the precession about the vertical: +1 is counterclockwise seen from above."""
        return np.sign(self.torque * self.spin)


def happen(truth: Truth, design: Design) -> Runs:
    """Work out how long each run takes."""
    _check_values(truth, design)
    _check_together(truth, design)
    settings = [
        (mass, position, pitch, spin, turns)
        for mass in design.masses
        for position in (design.positions if mass else (0.0,))
        for pitch, spin, turns in itertools.product(design.pitches, design.spins, design.turns)
        for _ in range(design.repeats)
    ]
    mass, position, pitch, spin, turns = (np.array(column) for column in zip(*settings, strict=True))
    torque = physics.torque(mass, position, truth.g) + (truth.imbalance or 0.0)
    for i in np.flatnonzero(torque == 0)[:1]:
        _refuse(
            SIMULATED_WITHOUT_TORQUE,
            f"{_words(mass[i], position[i])}: there is no torque, so this rod never precesses",
            "weight and imbalance cancel: change one of them"
            if mass[i] and position[i]
            else 'only an imbalance turns it then: --imbalance "0.3 mN m"',
        )
    across = np.full(len(mass), truth.transverse_inertia)
    if truth.transverse_inertia is None:
        across = DEFAULT_TRANSVERSE_RATIO * truth.inertia + mass * position**2
    untimed = Runs(mass, position, pitch, turns, spin, None, across, torque, np.full(len(mass), math.inf))
    if truth.motion == "released":
        return _released(truth, untimed)
    return _steady(truth, untimed)


def _check_values(truth: Truth, design: Design) -> None:
    """Refuse numbers that cannot be, before anything is computed from them."""
    across = truth.inertia if truth.transverse_inertia is None else truth.transverse_inertia
    values = [("transverse_inertia", "inertia", truth.inertia), ("transverse_inertia", "transverse", across)]
    values += [("g", "g", truth.g)]
    values += [("position", "position", position) for position in design.positions]
    values += [("mass", "weight", mass) for mass in design.masses]
    values += [("spin", "spin", spin) for spin in design.spins]
    values += [("pitch", "pitch", pitch) for pitch in design.pitches]
    values += [("turns", "turns", turns) for turns in design.turns]
    decay = truth.decay
    if decay is not None and decay.time_constant is not None:
        values.append(("time", "spin decay", decay.time_constant))
    for role, name, value in values:
        fault, hint = check_value(role, value)
        if not fault and role == "g" and value <= 0:
            fault = "is not above zero"
        if fault:
            shown, unit = to_display(value, role)
            _refuse(SIMULATED_VALUE_IMPOSSIBLE, f"{name} {shown:.6g} {unit}".rstrip() + f" {fault}", hint)
    unknowns = (("torque", "imbalance", truth.imbalance), ("time", "timing bias", truth.timing_bias))
    for kind, name, size in unknowns:
        # They may be as small as they like.
        if size is not None and not abs(size) <= LIMITS[kind][1]:
            _refuse(SIMULATED_VALUE_IMPOSSIBLE, f"{name} {size:g} {SI[kind]} is too large")
    if decay is not None and decay.lost is not None and not 0 < decay.lost < 1:
        _refuse(
            SIMULATED_VALUE_IMPOSSIBLE, f"a run cannot lose {100 * decay.lost:g} % of its spin", "write it like 10 %"
        )


def _check_together(truth: Truth, design: Design) -> None:
    """Refuse what does not go together."""
    decay = truth.decay
    if decay is not None and (decay.time_constant is None) == (decay.lost is None):
        _refuse(
            SIMULATED_OPTIONS_CONTRADICT,
            "a spin falls with a time constant, or by a part in each run: not with both or neither",
        )
    rows = design.repeats * math.prod(
        len(part) for part in (design.masses, design.positions, design.spins, design.turns, design.pitches)
    )
    if not 1 <= rows <= MAX_ROWS:
        _refuse(SIMULATED_VALUE_IMPOSSIBLE, f"these are {rows} runs", f"a log has 1 to {MAX_ROWS}")
    if truth.motion not in get_args(Motion):
        _refuse(
            SIMULATED_VALUE_IMPOSSIBLE,
            f"there is no motion {truth.motion!r}",
            f"write one of: {', '.join(get_args(Motion))}",
        )
    if truth.motion == "horizontal" and any(design.pitches):
        _refuse(SIMULATED_OPTIONS_CONTRADICT, "a rod with a pitch is not horizontal", "take --motion steady")
    if truth.motion == "released" and decay is not None:
        _refuse(
            SIMULATED_OPTIONS_CONTRADICT,
            "the exact motion of a released rod is one without drag",
            "take --motion steady",
        )


def _steady(truth: Truth, runs: Runs) -> Runs:
    """Runs in steady precession, eq. (8), which is eq. (9) for a level rod; the spin may fall."""
    at = course(runs.torque, runs.spin, truth.inertia, runs.across, runs.pitch)
    angle = 2 * np.pi * runs.turns
    for i in np.flatnonzero(~np.isfinite(at.rate))[:1]:
        _refuse_slow(
            truth,
            runs,
            int(i),
            SIMULATED_NO_STEADY_PRECESSION,
            f"{_rpm(runs.spin[i])} is too slow for steady precession",
        )
    end = None
    if truth.decay is None:
        time = angle / np.abs(at.rate)
    elif truth.decay.lost is not None:
        time, end = time_by_share(at, angle, truth.decay.lost), runs.spin * (1 - truth.decay.lost)
    else:
        assert truth.decay.time_constant is not None
        time = time_by_constant(at, angle, truth.decay.time_constant)
        end = runs.spin * np.exp(-time / truth.decay.time_constant)
    if end is not None:
        rate = physics.precession_rate(runs.torque, end, truth.inertia, runs.across, runs.pitch)
        for i in np.flatnonzero(~np.isfinite(time))[:1]:
            _refuse_slow(
                truth, runs, int(i), TURNS_NEVER_COMPLETED, "the spin dies away before the turns are completed"
            )
        for i in np.flatnonzero(~(np.abs(rate) < np.abs(end)))[:1]:
            _refuse(
                TURNS_NEVER_COMPLETED,
                f"{_words(runs.mass[i], runs.position[i])}, {_rpm(runs.spin[i])}: the spin has fallen to "
                f"{_rpm(end[i])} before the turns are completed, slower than the precession",
                "take fewer turns, or a slower decay",
            )
    return replace(runs, time=time, spin_end=end)


def _released(truth: Truth, runs: Runs) -> Runs:
    """Runs of a rod that is let go from rest: it nods, and the stopwatch stops where it first comes round."""
    top = motion.Top(truth.inertia, runs.across, runs.torque)
    start = motion.released(top, runs.spin, runs.pitch)
    time = motion.time_to_turn(top, start, runs.sense * 2 * np.pi * runs.turns)
    for i in np.flatnonzero(~np.isfinite(time))[:1]:
        _refuse(
            TURNS_NEVER_COMPLETED,
            f"{_words(runs.mass[i], runs.position[i])}, {_rpm(runs.spin[i])}: the rod never gets round",
            "spin faster, or take --motion steady",
        )
    return replace(runs, time=time)


def _refuse_slow(truth: Truth, runs: Runs, i: int, code: str, what: str) -> NoReturn:
    least = physics.least_spin(runs.torque[i], truth.inertia, runs.across[i], runs.pitch[i])
    pitch = math.degrees(runs.pitch[i])
    _refuse(
        code,
        f"{_words(runs.mass[i], runs.position[i])}, pitch {pitch:.4g} deg: {what}",
        f"at this pitch and torque it takes more than {math.ceil(10 * to_display(least, 'spin')[0]) / 10:g} rpm",
    )


def _words(mass: float, position: float) -> str:
    return f"{1e3 * mass:.6g} g at {100 * position:.6g} cm" if mass else "no weight on the rod"


def _rpm(spin: float) -> str:
    return f"{to_display(spin, 'spin')[0]:.4g} rpm"


def _refuse(code: str, message: str, hint: str = "") -> NoReturn:
    raise InputError([Diagnostic(code, "error", message, hint)])


@dataclass(frozen=True)
class Course:
    """Precession of n runs from their start on, with the spin falling."""

    rate: Floats
    """Precession rate at the start [rad/s], with its sign."""
    momentum: Floats
    """I_zz × size of the spin at the start [kg*m^2/s]."""
    tilt: Floats
    """4 a M [kg²m⁴/s²]: above 0 where the tilt slows the precession, below 0 where it hastens it."""

    def root(self, momentum: Floats) -> Floats:
        """√D of eq. (8) [kg*m^2/s]; NaN where it has no solution, 0 where it is about to have none."""
        square = momentum**2 + self.tilt
        return cast(Floats, np.sqrt(np.where(np.abs(square) < 1e-15 * momentum**2, 0.0, square)))

    def swept(self, lost: ArrayLike) -> Floats:
        """Angle swept while a part of the spin is lost, as a multiple of rate × τ."""
        lost = np.asarray(lost, dtype=float)
        after = self.momentum * (1 - lost)
        with np.errstate(invalid="ignore"):
            root, root_after = self.root(self.momentum), self.root(after)
        # φ̇ = 2M/(I_zz ψ̇ + √(…)), so this is φ̇₁/φ̇₀ − 1 without the difference of near-equal numbers.
        grown = lost * self.momentum * (1 + (self.momentum + after) / (root + root_after)) / (after + root_after)
        # q = a φ̇²/M at the start.
        q = self.tilt / (self.momentum + root) ** 2
        # Difference of the two inverse tangents, by their addition theorem.
        step = grown / (1 - q * (1 + grown))
        return cast(Floats, 2 * step * _inverse_tangent(q * step**2) - grown)


def _inverse_tangent(square: Floats) -> Floats:
    """Give artanh(z)/z of z² for a positive and arctan(z)/z of −z² for a negative argument: 1 + x/3 + x²/5 …."""
    size = np.sqrt(np.abs(square))
    with np.errstate(invalid="ignore", divide="ignore"):
        whole = np.where(square > 0, np.arctanh(np.minimum(size, 1.0)), np.arctan(size)) / size
    near = 1 + square / 3 + square**2 / 5 + square**3 / 7
    return np.where(np.abs(square) < 1e-4, near, whole)


def course(torque: ArrayLike, spin: ArrayLike, inertia: float, across: ArrayLike, pitch: ArrayLike) -> Course:
    """Give the precession of a top from its start on."""
    rate = physics.precession_rate(torque, spin, inertia, across, pitch)
    tilt = 4 * (inertia - np.asarray(across)) * np.sin(pitch) * np.asarray(torque)
    return Course(np.asarray(rate), inertia * np.abs(spin), np.asarray(tilt))


def time_by_share(at: Course, angle: Floats, lost: float) -> Floats:
    """Time to sweep an angle in which a given part of the spin is lost."""
    return cast(Floats, -np.log1p(-lost) * angle / (np.abs(at.rate) * at.swept(lost)))


def time_by_constant(at: Course, angle: Floats, time_constant: float) -> Floats:
    """Time to sweep an angle while the spin falls with a time constant τ.

    The precession only becomes faster, so the angle is a convex function of the time, and Newton's steps from any later
    time go down to the answer without ever passing it.
    """
    speed = np.abs(at.rate)
    with np.errstate(divide="ignore"):
        # Below the spin of D = 0 eq. (8) has no solution.
        longest = -time_constant * np.log(np.sqrt(np.maximum(-at.tilt, 0.0)) / at.momentum)
    # With a M < 0 the precession gains more than that of a level rod, with a M > 0 less, but it gains.
    level = time_constant * np.log1p(angle / (speed * time_constant))
    time = np.minimum(np.where(at.tilt > 0, angle / speed, level), longest)

    def beyond(time: Floats) -> Floats:
        return speed * time_constant * at.swept(-np.expm1(-time / time_constant)) - angle

    reached = beyond(time) > -1e-14 * angle
    for _step in range(100):
        left = at.momentum * np.exp(-time / time_constant)
        rate = speed * (at.momentum + at.root(at.momentum)) / (left + at.root(left))
        step = beyond(time) / rate
        time = time - step
        if np.all(np.abs(step[reached]) < 1e-10 * time[reached]):
            break
    return np.where(reached, time, np.nan)
