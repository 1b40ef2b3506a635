"""The true gyroscope, the design of the measurement, and the time of each run.

In steady precession the rod follows the slow root of eq. (8) at every moment while the
spin falls. A rod that is released from rest keeps its spin and follows its exact
motion.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any, Literal, get_args

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.base.errors import InputError, insist_on_choice
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO
from gyrodata.physics import RPM, Floats, motion
from gyrodata.readings import MAX_ROWS

Motion = Literal["steady", "released"]


class Truth(Struct, frozen=True):
    """The true properties of the gyroscope and of the stopwatch."""

    inertia: float = 4.44e-3
    """I_zz about the rod [kg*m^2]; the default is a 4-inch steel ball."""
    transverse_inertia: float | None = None
    """I about an axis across the rod through the fixed point, weight included [kg*m^2];
    None: 1.3 I_zz, as for a ball with a light rod, plus m x² of the weight."""
    imbalance: float | None = None
    """M0, the residual torque without a weight [N*m]; positive: like a weight at a
    positive position. None: drawn from ``u_imbalance`` if the noise contains it, else
    0."""
    timing_bias: float | None = None
    """b, by which all times are too long [s]; None: drawn from ``u_time_bias``."""
    g: float = physics.STANDARD_GRAVITY
    """Gravitational acceleration [m/s^2]."""
    motion: Motion = "steady"
    """"steady": eq. (8); "released": the exact motion of a rod that is released from
    rest."""
    decay_time: float | None = None
    """Time constant τ of the exponential decay of the spin in an air film [s]; None:
    the spin is constant."""


class Design(Struct, frozen=True):
    """The runs of the lab: all combinations of loads, pitches, spins and turns.

    The loads are weights at positions, and the turns are numbers of turns.
    """

    masses: tuple[float, ...] = (0.020, 0.040, 0.060)
    """[kg]; 0: the rod without a weight, which has no position."""
    positions: tuple[float, ...] = (0.15,)
    """Distance from the centre of the ball, with a sign [m]."""
    spins: tuple[float, ...] = (200 * RPM, 400 * RPM, 600 * RPM)
    """At the start of each run [rad/s]; negative: the opposite direction."""
    turns: tuple[float, ...] = (1.0,)
    """Revolutions of precession that are timed [1]."""
    pitches: tuple[float, ...] = (0.0,)
    """Angle of the rod above the horizontal, at the start of the run [rad]."""
    repeats: int = 1
    """Number of times that each run is repeated."""
    runs: Sequence[Sequence[float]] = ()
    """Mass, position, pitch, spin and turns of each run, such as those of a log, in
    place of all combinations."""

    def _settings(self) -> Iterator[Sequence[float]]:
        """Yield mass, position, pitch, spin and turns of each run."""
        yield from self.runs
        if self.runs:
            return
        settings = itertools.product(
            self.masses, self.positions, self.pitches, self.spins, self.turns
        )
        for mass, position, *others in settings:
            # A run without a weight has no position.
            if mass or position == self.positions[0]:
                load = (mass, position) if mass else (0.0, 0.0)
                yield from itertools.repeat((*load, *others), self.repeats)


class Runs(Struct, frozen=True):
    """The true values of n runs; all arrays have shape (n,)."""

    mass: Floats
    """[kg]"""
    position: Floats
    """[m]; 0 without a weight."""
    pitch: Floats
    """[rad]"""
    turns: Floats
    """[1]"""
    spin: Floats
    """At the start, with its sign [rad/s]."""
    spin_end: Floats | None
    """At the end [rad/s]; None if the spin is constant."""
    transverse_inertia: Floats
    """I across the rod [kg*m^2]."""
    torque: Floats
    """Total torque with the rod horizontal, m g x + M0 [N*m]."""
    time: Floats
    """Duration of the turns [s]."""

    @property
    def sense(self) -> Floats:
        """Direction of the precession seen from above: +1 is counterclockwise."""
        return np.sign(self.torque * self.spin)


def happen(truth: Truth, design: Design) -> Runs:
    """Compute the duration of each run.

    Raises
    ------
    InputError
        If there is no inertia or run, or if a rod never completes its turns.
    """
    insist_on_choice("motion", truth.motion, get_args(Motion))
    if truth.decay_time is not None and truth.motion == "released":
        raise InputError.named("simulated_release_decays")
    if not truth.inertia > 0:
        raise InputError.named("simulated_inertia", inertia=truth.inertia)
    settings = list(itertools.islice(design._settings(), MAX_ROWS + 1))
    if not 1 <= len(settings) <= MAX_ROWS:
        raise InputError.named("simulated_runs", most=MAX_ROWS)
    mass, position, pitch, spin, turns = map(np.array, zip(*settings, strict=True))
    torque = physics.torque(mass, position, truth.g) + (truth.imbalance or 0.0)
    if not torque.all():
        raise InputError.named("simulated_without_torque")
    across = np.full(len(mass), truth.transverse_inertia)
    if truth.transverse_inertia is None:
        across = DEFAULT_TRANSVERSE_RATIO * truth.inertia + mass * position**2
    time = np.full(len(mass), math.inf)
    runs = Runs(mass, position, pitch, turns, spin, None, across, torque, time)
    return (
        _released(truth, runs) if truth.motion == "released" else _steady(truth, runs)
    )


_PLACES, _SHARES = np.polynomial.legendre.leggauss(64)
_PLACES = (_PLACES[:, None] + 1) / 2
_SHARES = _SHARES / 2
"""Quadrature over a run: places from 0 to 1, shape (64, 1), and their weights."""


def _steady(truth: Truth, runs: Runs) -> Runs:
    """Time runs in steady precession, eq. (8), which is eq. (9) for a level rod.

    The spin may fall.
    """
    body = truth.inertia, runs.transverse_inertia

    def rate(spin: Floats) -> Any:
        """Compute the rate at spins of the runs, shape (..., n)."""
        return np.abs(physics.precession_rate(runs.torque, spin, *body, runs.pitch))

    angle = 2 * np.pi * runs.turns
    at_start = rate(runs.spin)
    if not np.isfinite(at_start).all():
        raise InputError.named("simulated_not_steady")
    constant = truth.decay_time
    longest = angle / at_start
    if constant is None:
        return replace(runs, time=longest)

    def mean_rate(fall: Floats) -> Any:
        """Compute the mean rate while the spin falls by the factor e^−fall."""
        return _SHARES @ rate(runs.spin * np.exp(-fall * _PLACES))

    # The precession becomes faster as the spin falls, so a run is never longer than at
    # the first rate.
    time = motion.find_crossing(
        lambda time: time * mean_rate(time / constant) - angle, 0 * angle, longest
    )
    end = runs.spin * np.exp(-time / constant)
    # The rate is NaN if steady precession is impossible at the end.
    if not (rate(end) < np.abs(end)).all():
        raise InputError.named("simulated_spin_dies")
    return replace(runs, time=time, spin_end=end)


def top_of(truth: Truth, runs: Runs) -> motion.Top:
    """Return the tops of the runs, with the true I_zz."""
    return motion.Top(
        inertia=truth.inertia,
        transverse_inertia=runs.transverse_inertia,
        torque=runs.torque,
    )


def _released(truth: Truth, runs: Runs) -> Runs:
    """Time a rod that is released from rest and nods.

    The stopwatch stops when the rod first completes its turns.
    """
    time = motion.time_to_turn(
        top_of(truth, runs), runs.spin, runs.pitch, runs.sense * 2 * np.pi * runs.turns
    )
    return replace(runs, time=time)
