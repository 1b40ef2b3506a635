"""Models of the motion in a lab as it is: what each costs, and by how much I_zz is wrong with it.

A lab has nine runs, three weights at three spins, each of one turn. The hand pushes the rod with a part of the rate of
steady precession, the rod is tilted by up to 2 degrees, the air film drags, and the Earth turns. None of the simple
models describes all of this, so none is exact by construction. Each gives the azimuth that the rod sweeps in the time
of the turn. The ratio of this to what the rod really sweeps is, to first order, the ratio of I_zz with that model to
the true I_zz. The runs count as the recommended fit weighs them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from msgspec import Struct

from gyrodata import effects, fitting, motion, physics
from gyrodata.benchmark.effort import Clock, Effort, time_of
from gyrodata.fitting import DEFAULT_TRANSVERSE_RATIO
from gyrodata.measurements import measure
from gyrodata.physics import RPM, Floats
from gyrodata.simulation import TYPICAL, Design, Truth, simulate
from gyrodata.units import Uncertainty


class MotionScene(Struct, frozen=True):
    """A kind of lab."""

    name: str
    title: str
    rpm: tuple[int, int, int]
    """Spins [rpm]."""
    tilt: float = 0.0
    """Pitch [degrees]; that of each run is up to 2 degrees off."""
    push: tuple[float, float] = (0.0, 1.0)
    """Least and largest push of the hand, in parts of the rate of steady precession [1]."""

    @property
    def speeds(self) -> str:
        """The spins in words."""
        return f"{self.rpm[0]} to {self.rpm[-1]} rpm"


SCENES = (
    MotionScene("usual", "a usual lab", (200, 400, 600)),
    MotionScene("tilted", "rod tilted by 30°, well pushed", (100, 200, 300), tilt=30.0, push=(0.7, 1.0)),
    MotionScene("released", "let go without a push", (140, 200, 300), push=(0.0, 0.0)),
    MotionScene("slow", "slow spins", (60, 100, 150)),
)

MASSES, POSITION = (0.020, 0.040, 0.060), 0.15
"""[kg], [m]"""

DECAY, LATITUDE = 1100.0, math.radians(45)
"""Time in which the air film slows the spin to 1/e [s], and where the lab is [rad]."""

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
"""Relative tolerances of the full motion [1]."""

_CLOSE, _CLOSEST = 1e-6, 1e-9
"""Relative tolerances of the integrations that simple models and the full motion are compared with [1]."""

_NOISE = {**TYPICAL, "u_time_bias": Uncertainty(0.05)}
"""What the labs state: a hand that has practised. A worse hand would hide every error of the models."""

_NORTH, _UP = physics.EARTH_ROTATION * math.cos(LATITUDE), physics.EARTH_ROTATION * math.sin(LATITUDE)
_EARTH = np.array([[0.0, -_UP, 0.0], [_UP, 0.0, -_NORTH], [0.0, _NORTH, 0.0]])
"""Ω × of the Earth's rotation, as a matrix in the frame X north, Y west, Z up [rad/s]."""


class MotionPoint(Struct, frozen=True):
    """One model in one scene."""

    method: str
    setting: str
    """Relative tolerance; "" if there is none."""
    seconds: float
    """CPU time for the nine runs of a lab, in Python [s]."""
    error: float
    """Root mean square over the labs of the relative error of I_zz [1]."""
    evaluations: int | None = None
    """How often an integrator asks for the torque; None for a closed form."""


class MotionPanel(Struct, frozen=True):
    """All models in one scene."""

    scene: MotionScene
    u: float
    """Relative standard uncertainty of I_zz that the recommended fit gives a typical lab of the scene [1]."""
    points: tuple[MotionPoint, ...]

    @property
    def bound(self) -> float:
        """Error that does no harm [1]: what a report may leave out in all, `effects.DROP_ALL` × u."""
        return effects.DROP_ALL * self.u

    @property
    def winner(self) -> MotionPoint:
        """The cheapest model below the bound."""
        return min((point for point in self.points if point.error < self.bound), key=lambda point: point.seconds)


class _Labs(Struct, frozen=True):
    """L labs of nine runs; arrays of shape (9 L,), the runs of a lab one after the other."""

    top: motion.Top
    state: motion.State
    """When the clock starts."""
    pitch: Floats
    """[rad]"""
    spin: Floats
    """Mean spin, as it is worked out from the readings at start and end [rad/s]."""
    time: Floats
    """That each run takes [s]."""


def run_motion(effort: Effort, clock: Clock, seed: int = 1) -> list[MotionPanel]:
    """Try every model in every scene."""
    return [_run_scene(scene, effort, clock, seed) for scene in SCENES]


def _run_scene(scene: MotionScene, effort: Effort, clock: Clock, seed: int) -> MotionPanel:
    spins, pitch = tuple(RPM * one for one in scene.rpm), math.radians(scene.tilt)
    design = Design(masses=MASSES, positions=(POSITION,), spins=spins, pitches=(pitch,))
    measured = measure(simulate(Truth(), design, _NOISE, None).readings)
    # A log without errors scatters less than any lab's; with the widths as stated it is a typical lab.
    widths = fitting.Widths(1.0, fitting.fit(measured, tilted=bool(pitch)).widths.residual_torque)
    fit = fitting.fit(measured, tilted=bool(pitch), widths=widths)
    random = np.random.default_rng(seed)
    labs, one = (_draw_labs(scene, count, random) for count in (effort.motion_labs, 1))

    def error(found: Floats, true: Floats) -> float:
        """Root mean square over the labs of the error of I_zz, each run as it counts in the fit."""
        return math.sqrt(np.mean(((found / true - 1).reshape(-1, len(fit.response)) @ fit.response) ** 2))

    true = follow(labs, _CLOSE)[0]
    points = [
        MotionPoint(method, "", time_of(partial(model, one), clock, effort.repeats), error(model(labs), true))
        for method, model in MODELS.items()
    ]
    true = follow(one, _CLOSEST)[0]
    for tolerance in TOLERANCES:
        begun = clock()
        found, evaluations = follow(one, tolerance)
        seconds = clock() - begun
        points.append(MotionPoint("full motion", f"rtol {tolerance:.0e}", seconds, error(found, true), evaluations))
    return MotionPanel(scene, (fit.inertia.u or 0.0) / fit.inertia.value, tuple(points))


def _draw_labs(scene: MotionScene, count: int, random: np.random.Generator) -> _Labs:
    """Draw labs with a push and a pitch for each run."""
    mass, start = (part.ravel() for part in np.meshgrid(MASSES, RPM * np.array(scene.rpm), indexing="ij"))
    # Where in its nodding a rod is when the clock stops is luck, so no two labs have the same spins.
    mass, start = np.tile(mass, count), np.tile(start, count) * random.uniform(0.95, 1.05, count * mass.size)
    inertia = np.full(mass.shape, Truth().inertia)
    across = DEFAULT_TRANSVERSE_RATIO * inertia + mass * POSITION**2
    top = motion.Top(inertia, across, physics.torque(mass, POSITION, physics.STANDARD_GRAVITY))
    pitch, push = np.radians(scene.tilt + random.uniform(-2, 2, mass.shape)), random.uniform(*scene.push, mass.shape)
    rest, steady = motion.released(top, start, pitch), motion.steady(top, start, pitch)
    state = motion.State(rest.axis, rest.momentum + push[:, None] * (steady.momentum - rest.momentum))
    time = 2 * np.pi / physics.precession_rate(top.torque, start, inertia, across, pitch)
    spin = physics.harmonic_mean_spin(start, start * np.exp(-time / DECAY))
    return _Labs(top, state, pitch, spin, time)


# --- the models: the azimuth that each rod sweeps in its time [rad] ---------------------------------------------


def _level(labs: _Labs) -> Floats:
    rate: Floats = physics.horizontal_precession_rate(labs.top.torque, labs.spin, labs.top.inertia)
    return rate * labs.time


def _steady(labs: _Labs) -> Floats:
    top = labs.top
    rate: Floats = physics.precession_rate(top.torque, labs.spin, top.inertia, top.transverse_inertia, labs.pitch)
    return rate * labs.time


def _mean_rate(labs: _Labs) -> Floats:
    rate: Floats = motion.mean_precession_rate(labs.top, motion.released(labs.top, labs.spin, labs.pitch))
    return rate * labs.time


def _exact(labs: _Labs) -> Floats:
    angle: Floats = motion.precession_angle(labs.top, motion.released(labs.top, labs.spin, labs.pitch), labs.time)
    return angle


MODELS: dict[str, Callable[[_Labs], Floats]] = {
    "eq. (9)": _level,
    "eq. (8)": _steady,
    "mean rate of a release": _mean_rate,
    "exact motion of a release": _exact,
}
"""They know the spin, the torque and the time; all but eq. (9) know the pitch; none knows the push."""


def follow(labs: _Labs, tolerance: float) -> tuple[Floats, int]:
    """Integrate eqs. (7) as vectors, with the push, the drag and the Earth's rotation; with the count of evaluations.

    Every run goes through its own time, so that all end at once.
    """
    from scipy.integrate import solve_ivp

    rates = motion.vector_rates(labs.top, labs.top.inertia / DECAY, labs.time)

    def slope(_: float, row: Floats) -> Floats:
        vectors = row.reshape(2, 3, -1)
        change = np.array(rates(*row.reshape(6, -1))).reshape(vectors.shape)
        return np.asarray(change - labs.time * (_EARTH @ vectors)).ravel()

    start = np.concatenate([labs.state.axis.T, labs.state.momentum.T])
    scale = np.repeat([1.0, float(np.abs(labs.state.momentum).max())], start.size // 2)
    done = solve_ivp(slope, (0, 1), start.ravel(), "DOP853", rtol=tolerance, atol=0.01 * tolerance * scale)
    x, y = done.y[:, -1].reshape(start.shape)[:2]
    azimuth = np.arctan2(y, x) - np.arctan2(start[1], start[0])
    # Of all that differ by whole turns, the one nearest to a turn.
    return 2 * np.pi + np.remainder(azimuth + np.pi, 2 * np.pi) - np.pi, done.nfev
