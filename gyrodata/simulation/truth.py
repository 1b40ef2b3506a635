"""What happens: the gyroscope as it is, what is done with it, and the time that each run then takes.

The spin falls as ψ̇ = ψ̇₀ e^(−t/τ), as in an air film, and the precession follows the slow root of eq. (8),
a φ̇² + I_zz ψ̇ φ̇ − M = 0 with a = (I_zz − I) sin(pitch), at every moment. With φ̇ in the place of the spin as the
variable, φ = ∫ φ̇ dt = −τ ∫ φ̇ dψ̇/ψ̇ becomes

    φ = τ ∫ (M + a φ̇²)/(M − a φ̇²) dφ̇,

an inverse hyperbolic tangent for a M > 0, an arc tangent for a M < 0, and for a level rod, a = 0, just τ (φ̇₁ − φ̇₀).
By another law of decay, ψ̈ ∝ −ψ̇^p, the same integral over the time is taken by quadrature. A rod that is let go and
dragged has its whole motion integrated. On the turning Earth the rod has to come round to a mark that moves with it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from functools import lru_cache
from numbers import Real
from typing import Literal, NoReturn, cast, get_args

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import ArrayLike

from gyrodata import motion, physics
from gyrodata.diagnostics import (
    SIMULATED_NO_STEADY_PRECESSION,
    SIMULATED_OPTIONS_CONTRADICT,
    SIMULATED_VALUE_IMPOSSIBLE,
    SIMULATED_WITHOUT_TORQUE,
    TURNS_NEVER_COMPLETED,
)
from gyrodata.errors import InputError, insist_on_type
from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats
from gyrodata.readings import MAX_ROWS, check_value, to_display
from gyrodata.units import LIMITS, SI

Motion = Literal["horizontal", "steady", "released"]

SpinReading = Literal["half", "both", "three"]
"""When a spin that falls is read: at half time, at start and end, or at all three."""

DecayLaw = Literal["viscous", "dry", "turbulent"]

EXPONENTS: Mapping[DecayLaw, float] = {"viscous": physics.VISCOUS, "dry": 0.0, "turbulent": 2.0}
"""p of the law ψ̈ ∝ −ψ̇^p."""


class Decay(Struct, frozen=True):
    """How the spin falls, ψ̇ ∝ e^(−t/τ) as in an air film; one of the first two is given."""

    time_constant: float | None = None
    """τ [s], the same in every run: spin over loss of spin in a second, at the start."""
    lost: float | None = None
    """Part of the spin that each run loses, 1 − end/start [1]; τ then differs from run to run."""
    exponent: float | None = None
    """p of ψ̈ ∝ −ψ̇^p; None: drawn from ``u_decay_exponent`` about 1, that of an air film."""

    @property
    def viscous(self) -> bool:
        """Whether it is the law of an air film."""
        return self.exponent in (None, physics.VISCOUS)

    def left(self, time: Floats, time_constant: Floats | float) -> Floats:
        """Part of the spin that is left after a time, for a time constant at the start; NaN where it has stopped."""
        gone = np.divide(time, time_constant)
        if self.viscous:
            return cast(Floats, np.exp(-gone))
        assert self.exponent is not None
        rest = 1 - self.exponent
        with np.errstate(invalid="ignore", divide="ignore"):
            return cast(Floats, np.exp(np.log1p(-rest * gone) / rest))

    def constant(self, time: Floats, lost: float) -> Floats | float:
        """Time constant at the start with which a part of the spin is lost in a time."""
        if self.viscous:
            return cast(Floats, -time / np.log1p(-lost))
        assert self.exponent is not None
        rest = 1 - self.exponent
        return cast(Floats, -rest * time / np.expm1(rest * np.log1p(-lost)))


class Truth(Struct, frozen=True):
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
    spin_delay: float | None = None
    """By how much later than at half time a spin is read that is to be read then [s]; None: drawn from
    ``u_spin_delay``."""
    tails: int | None = None
    """Degrees of freedom of the Student's t that the stopwatch errs by, in ``u_time``; None: normal errors."""
    g: float = physics.STANDARD_GRAVITY
    """Acceleration of free fall [m/s^2]."""
    motion: Motion = "steady"
    """"horizontal": eq. (9); "steady": eq. (8); "released": the exact motion of a rod let go from rest."""
    decay: Decay | None = None
    """None: the spin stays."""
    balance_drift: float = 0.0
    """By how much M0 rises from the first run to the last, about its mean [N*m]."""
    latitude: float | None = None
    """[rad]: the Earth turns below the rod; None: it stands still."""


class Design(Struct, frozen=True):
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
    spin_reading: SpinReading | None = None
    """None: at start and end if the spin falls, else once."""


class Runs(Struct, frozen=True):
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
    spin_half: Floats | None
    """When it is to be read at half time, with the hand's delay [rad/s]; None where the spin stays."""
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


_EARTH_TURNS = 30
"""So often at most a run is timed to where the Earth has turned its mark."""


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
    session = np.linspace(-0.5, 0.5, len(mass)) if len(mass) > 1 else np.zeros(1)
    residual = (truth.imbalance or 0.0) + truth.balance_drift * session
    torque = physics.torque(mass, position, truth.g) + residual
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
    untimed = Runs(mass, position, pitch, turns, spin, None, None, across, torque, np.full(len(mass), math.inf))
    timed = _released if truth.motion == "released" else _steady
    if truth.latitude is None:
        return timed(truth, untimed, 2 * np.pi * turns)
    # The mark goes on with the Earth while the rod comes round; it is slow, and each turn is nearer by its share.
    turning = untimed.sense * physics.EARTH_ROTATION * math.sin(truth.latitude)
    angle = 2 * np.pi * turns
    for _again in range(_EARTH_TURNS):
        runs = timed(truth, untimed, angle)
        last, angle = angle, 2 * np.pi * turns + turning * runs.time
        for i in np.flatnonzero(~(angle > 0))[:1]:
            _refuse(
                TURNS_NEVER_COMPLETED,
                f"{_words(mass[i], position[i])}, {_rpm(spin[i])}: the Earth turns faster than the rod",
                "take a larger torque, or no latitude",
            )
        if np.all(np.abs(angle - last) < 1e-13 * angle):
            break
    return runs


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
        insist_on_type(name, value, Real, "a number in SI")
        fault, hint = check_value(role, value)
        if not fault and role == "g" and value <= 0:
            fault = "is not above zero"
        if fault:
            shown, unit = to_display(value, role)
            _refuse(SIMULATED_VALUE_IMPOSSIBLE, f"{name} {shown:.6g} {unit}".rstrip() + f" {fault}", hint)
    unknowns = (
        ("torque", "imbalance", truth.imbalance),
        ("torque", "balance drift", truth.balance_drift),
        ("time", "timing bias", truth.timing_bias),
        ("time", "delay", truth.spin_delay),
    )
    for kind, name, size in unknowns:
        # They may be as small as they like.
        if size is not None and not abs(size) <= LIMITS[kind][1]:
            _refuse(SIMULATED_VALUE_IMPOSSIBLE, f"{name} {size:g} {SI[kind]} is too large")
    if truth.latitude is not None and not abs(truth.latitude) <= math.pi / 2:
        _refuse(
            SIMULATED_VALUE_IMPOSSIBLE,
            f"latitude {math.degrees(truth.latitude):.6g} deg is not between -90 and 90 deg",
        )
    if truth.tails is not None and truth.tails < 1:
        _refuse(SIMULATED_VALUE_IMPOSSIBLE, f"a Student's t has 1 degree of freedom or more, not {truth.tails}")
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
    reading = design.spin_reading
    if reading is not None and reading not in get_args(SpinReading):
        _refuse(
            SIMULATED_VALUE_IMPOSSIBLE,
            f"there is no spin reading {reading!r}",
            f"write one of: {', '.join(get_args(SpinReading))}",
        )
    if decay is None and reading in ("both", "three"):
        _refuse(
            SIMULATED_OPTIONS_CONTRADICT,
            "a spin that stays is read once",
            "let it fall, or read it once",
        )
    if truth.spin_delay and (decay is None or reading in (None, "both")):
        _refuse(
            SIMULATED_OPTIONS_CONTRADICT,
            "a delay matters only where a falling spin is read at half time",
            "let the spin fall, and read it at half time",
        )
    if truth.motion == "released" and decay is not None and (decay.time_constant is None or not decay.viscous):
        _refuse(
            SIMULATED_OPTIONS_CONTRADICT,
            "a released rod is dragged as in an air film, with one time constant",
            'take --spin-decay "600 s", or --motion steady',
        )


def _steady(truth: Truth, runs: Runs, angle: Floats) -> Runs:
    """Runs in steady precession, eq. (8), which is eq. (9) for a level rod; the spin may fall."""
    at = course(runs.torque, runs.spin, truth.inertia, runs.across, runs.pitch)
    slow = np.flatnonzero(~np.isfinite(at.rate))
    if len(slow):
        # Of all that are too slow the one that needs most: a faster spin then serves every run.
        i = slow[np.argmax(_least_rpm(truth, runs)[slow])]
        _refuse(
            SIMULATED_NO_STEADY_PRECESSION,
            f"{_run_words(runs, i)}: {_rpm(runs.spin[i])} is too slow for steady precession",
            f"at this pitch and torque it takes more than {_least_rpm(truth, runs)[i]:g} rpm",
        )
    decay = truth.decay
    if decay is None:
        return replace(runs, time=angle / np.abs(at.rate))
    if decay.lost is not None:
        time = time_by_share(at, angle, decay.lost) if decay.viscous else _time_by_law(at, angle, decay)
    else:
        assert decay.time_constant is not None
        viscous = decay.viscous
        time = time_by_constant(at, angle, decay.time_constant) if viscous else _time_by_law(at, angle, decay)
    runs = _read_spins(truth, replace(runs, time=time))
    assert runs.spin_end is not None
    rate = physics.precession_rate(runs.torque, runs.spin_end, truth.inertia, runs.across, runs.pitch)
    for i in np.flatnonzero(~np.isfinite(time))[:1]:
        what = "the spin dies away before the turns are completed"
        hint = "take fewer turns, or a slower decay"
        if least := _least_rpm(truth, runs)[i]:
            hint += f"; at this pitch and torque it takes more than {least:g} rpm to the end"
        _refuse(TURNS_NEVER_COMPLETED, f"{_run_words(runs, i)}: {what}", hint)
    for i in np.flatnonzero(~(np.abs(rate) < np.abs(runs.spin_end)))[:1]:
        _refuse(
            TURNS_NEVER_COMPLETED,
            f"{_words(runs.mass[i], runs.position[i])}, {_rpm(runs.spin[i])}: the spin has fallen to "
            f"{_rpm(runs.spin_end[i])} before the turns are completed, slower than the precession",
            "take fewer turns, or a slower decay",
        )
    return runs


def _read_spins(truth: Truth, runs: Runs) -> Runs:
    """Fill in the spins at the end of each run, and when it is to be read at half time."""
    decay = truth.decay
    assert decay is not None
    constant = decay.time_constant or decay.constant(runs.time, decay.lost or 0.0)
    half = runs.spin * decay.left(np.maximum(runs.time / 2 + (truth.spin_delay or 0.0), 0.0), constant)
    end = runs.spin * (1 - decay.lost) if decay.lost is not None else runs.spin * decay.left(runs.time, constant)
    return replace(runs, spin_end=end, spin_half=half)


def _released(truth: Truth, runs: Runs, angle: Floats) -> Runs:
    """Runs of a rod that is let go from rest: it nods, and the stopwatch stops where it first comes round."""
    top = motion.Top(truth.inertia, runs.across, runs.torque)
    if truth.decay is None:
        start = motion.released(top, runs.spin, runs.pitch)
        time = motion.time_to_turn(top, start, runs.sense * angle)
    else:
        time = np.array([_dragged_time(truth, runs, angle, i) for i in range(len(angle))])
    for i in np.flatnonzero(~np.isfinite(time))[:1]:
        _refuse(
            TURNS_NEVER_COMPLETED,
            f"{_words(runs.mass[i], runs.position[i])}, {_rpm(runs.spin[i])}: the rod never gets round",
            "spin faster, or take --motion steady",
        )
    runs = replace(runs, time=time)
    # The drag about the rod slows the spin as if the rod did not move.
    return runs if truth.decay is None else _read_spins(truth, runs)


_SAMPLES = 64
"""States in a turn: so few that the azimuth is followed, and the nutation need not be."""


@lru_cache(maxsize=1000)
def _dragged(
    inertia: float, across: float, torque: float, spin: float, pitch: float, drag: float, turns: float
) -> tuple[Floats, motion.Path]:
    """Times and states of a rod that is let go under drag, for somewhat longer than the turns take."""
    top = motion.Top(inertia, across, torque)
    # The spin only falls, so that a rod in steady precession would be there long before; one that nods, a nod later.
    rate = abs(float(physics.horizontal_precession_rate(torque, spin, inertia)))
    longest = 1.3 * 2 * math.pi * turns / rate + 2 * math.pi * across / (inertia * abs(spin))
    times = np.linspace(0.0, longest, 2 * math.ceil(_SAMPLES * turns) + 1)
    return times, motion.integrate(top, motion.released(top, spin, pitch), times, drag=drag)


def _dragged_time(truth: Truth, runs: Runs, angle: Floats, i: int) -> float:
    """Time until a rod let go under drag comes round by an angle; NaN if it does not."""
    from scipy.optimize import brentq

    assert truth.decay is not None
    assert truth.decay.time_constant is not None
    drag, sense = truth.inertia / truth.decay.time_constant, float(runs.sense[i])
    across, torque, spin, pitch, turns = (
        float(values[i]) for values in (runs.across, runs.torque, runs.spin, runs.pitch, runs.turns)
    )
    top = motion.Top(truth.inertia, across, torque)
    times, path = _dragged(truth.inertia, across, torque, spin, pitch, drag, turns)
    azimuth = np.unwrap(np.arctan2(sense * path.axis[:, 1], path.axis[:, 0]))
    beyond = np.flatnonzero(azimuth >= angle[i])
    if not len(beyond):
        return math.nan
    before = int(beyond[0]) - 1
    near = motion.State(path.axis[before], path.momentum[before])
    first = math.atan2(sense * near.axis[1], near.axis[0])

    def missing(later: float) -> float:
        axis = motion.integrate(top, near, later, drag=drag).axis
        turned = math.remainder(math.atan2(sense * axis[1], axis[0]) - first, 2 * math.pi)
        return float(azimuth[before]) + turned - float(angle[i])

    return float(times[before]) + float(brentq(missing, 0.0, times[1], xtol=1e-10))


def _least_rpm(truth: Truth, runs: Runs) -> Floats:
    """Spins that steady precession needs at least, a little rounded up [rpm]."""
    least = physics.least_spin(runs.torque, truth.inertia, runs.across, runs.pitch)
    return np.array([math.ceil(10 * to_display(one, "spin")[0]) / 10 for one in least])


def _run_words(runs: Runs, i: int) -> str:
    return f"{_words(runs.mass[i], runs.position[i])}, pitch {math.degrees(runs.pitch[i]):.4g} deg"


def _words(mass: float, position: float) -> str:
    return f"{1e3 * mass:.6g} g at {100 * position:.6g} cm" if mass else "no weight on the rod"


def _rpm(spin: float) -> str:
    return f"{to_display(spin, 'spin')[0]:.4g} rpm"


def _refuse(code: str, message: str, hint: str = "") -> NoReturn:
    raise InputError.of(code, message, hint)


class Course(Struct, frozen=True):
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


_PLACES, _SHARES = np.polynomial.legendre.leggauss(64)


def _time_by_law(at: Course, angle: Floats, decay: Decay) -> Floats:
    """Time to sweep an angle while the spin falls by another law than an air film's, by quadrature."""
    places, shares = (_PLACES + 1) / 2, _SHARES / 2

    def rate(left: Floats) -> Floats:
        momentum = at.momentum[:, None] * left
        with np.errstate(invalid="ignore"):
            root = np.sqrt(momentum**2 + at.tilt[:, None])
        return (np.abs(at.rate) * (at.momentum + at.root(at.momentum)))[:, None] / (momentum + root)

    if decay.lost is not None:
        # In parts of the run's own time the spin falls alike, whatever the time.
        left = decay.left(places, decay.constant(np.ones(1), decay.lost))
        return angle / (rate(np.broadcast_to(left, (len(angle), len(left)))) @ shares)
    assert decay.time_constant is not None
    # From a time that is too long Newton's steps go down to the answer: the precession only becomes faster.
    time = angle / np.abs(at.rate)
    if decay.exponent is not None and decay.exponent < 1:
        time = np.minimum(time, 0.9999 * decay.time_constant / (1 - decay.exponent))
    for _step in range(100):
        beyond = time * (rate(decay.left(time[:, None] * places, decay.time_constant)) @ shares) - angle
        step = beyond / rate(decay.left(time[:, None], decay.time_constant))[:, 0]
        time = time - step
        if np.all(np.abs(step) < 1e-12 * time):
            break
    return np.where(np.abs(beyond) < 1e-9 * angle, time, np.nan)


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
