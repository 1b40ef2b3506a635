"""Models and integrators of the motion: cost against error.

`run_motion` compares models in realistic labs. A lab has nine runs of one turn, three
weights at three spins. The hand pushes the rod with a part of the rate of steady
precession, the rod is tilted by up to 2 degrees, the air film drags, and the Earth
turns; so no simple model is exact. Each model predicts the azimuth that the rod sweeps
in the time of the turn. To first order, its ratio to the true azimuth is the ratio of
I_zz with this model to the true I_zz. The runs have the weights of the recommended fit.

`find_orders` compares integrators for one top that is released at 150 rpm with a level
rod. It nods eight times in one turn about the vertical. The true motion is known
exactly.
"""

from __future__ import annotations

import math
import timeit
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from msgspec import Struct

from gyrodata import fitting, physics
from gyrodata.judging import changes
from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO, measure
from gyrodata.physics import RPM, Floats, motion
from gyrodata.quantities.units import Uncertainty
from gyrodata.trials.simulation import TYPICAL, Design, Truth, simulate

Clock = Callable[[], float]
"""A function that returns the time in seconds, such as `time.process_time`."""


class Effort(Struct, frozen=True):
    """The size of a benchmark."""

    motion_labs: int
    """Number of simulated labs for the models of the motion."""
    turns: int
    """Number of turns about the vertical in a long motion."""
    evaluations: int
    """Largest number of evaluations of the torque in one turn; for n turns √n times as
    many."""
    labs: int
    """Number of simulated labs for the fits."""
    repeats: int = 5
    """Number of times that each duration is measured."""


QUICK = Effort(motion_labs=40, turns=50, evaluations=20_000, labs=120)
"""Less than a minute."""

FULL = Effort(motion_labs=200, turns=200, evaluations=100_000, labs=2000)
"""Some minutes."""


def time_of(task: Callable[[], object], clock: Clock, repeats: int) -> float:
    """Measure the shortest CPU time of a task [s].

    Other work of the machine only makes the time longer.
    """
    return max(min(timeit.repeat(task, timer=clock, repeat=repeats, number=1)), 1e-9)


# --- models ---


class MotionScene(Struct, frozen=True):
    """A kind of lab."""

    name: str
    title: str
    rpm: tuple[int, int, int]
    """Spins [rpm]."""
    tilt: float = 0.0
    """Mean pitch [degrees]; each run differs from it by up to 2 degrees."""
    push: tuple[float, float] = (0.0, 1.0)
    """Smallest and largest push of the hand, over the rate of steady precession [1]."""

    @property
    def heading(self) -> str:
        """The title with the range of spins."""
        return f"{self.title}, {self.rpm[0]} to {self.rpm[-1]} rpm"


SCENES = (
    MotionScene("usual", "a usual lab", (200, 400, 600)),
    MotionScene(
        "tilted",
        "rod tilted by 30°, well pushed",
        (100, 200, 300),
        tilt=30.0,
        push=(0.7, 1.0),
    ),
    MotionScene(
        "released", "released without a push", (140, 200, 300), push=(0.0, 0.0)
    ),
    MotionScene("slow", "slow spins", (60, 100, 150)),
)

MASSES, POSITION = (0.020, 0.040, 0.060), 0.15
"""[kg], [m]"""

DECAY, LATITUDE = 1100.0, math.radians(45)
"""Time constant of the spin in the air film [s], and the latitude of the lab [rad]."""

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
"""Relative tolerances of the full motion [1]."""

_CLOSE, _CLOSEST = 1e-6, 1e-9
"""Relative tolerances of the reference for simple models and for the full motion [1].
"""

_NOISE = {**TYPICAL, "u_time_bias": Uncertainty(0.05)}
"""Uncertainties of a practised student; larger ones would hide every error of the
models."""

_NORTH, _UP = (
    physics.EARTH_ROTATION * math.cos(LATITUDE),
    physics.EARTH_ROTATION * math.sin(LATITUDE),
)
_EARTH = np.array([[0.0, -_UP, 0.0], [_UP, 0.0, -_NORTH], [0.0, _NORTH, 0.0]])
"""Ω × of the Earth's rotation, as a matrix in the frame X north, Y west, Z up [rad/s].
"""


class MotionPoint(Struct, frozen=True):
    """One model in one kind of lab."""

    method: str
    setting: str
    """Relative tolerance; "" if there is none."""
    seconds: float
    """CPU time for the nine runs of a lab, in Python [s]."""
    error: float
    """Root mean square over the labs of the relative error of I_zz [1]."""
    evaluations: int | None = None
    """Number of evaluations of the torque; None for a closed form."""


class MotionPanel(Struct, frozen=True):
    """All models in one kind of lab."""

    scene: MotionScene
    u: float
    """Relative standard uncertainty of I_zz in a typical lab [1]."""
    points: tuple[MotionPoint, ...]

    @property
    def bound(self) -> float:
        """Largest harmless error [1], `changes.DROP_ALL` × u."""
        return changes.DROP_ALL * self.u

    @property
    def winner(self) -> MotionPoint:
        """The cheapest model below the bound."""
        return min(
            (point for point in self.points if point.error < self.bound),
            key=lambda point: point.seconds,
        )


class _Labs(Struct, frozen=True):
    """L labs of nine runs; arrays of shape (9 L,), one lab after the other."""

    top: motion.Top
    state: motion.State
    """At the start of the clock."""
    pitch: Floats
    """[rad]"""
    spin: Floats
    """Mean spin from the readings at start and end [rad/s]."""
    time: Floats
    """Duration of each run [s]."""


def run_motion(effort: Effort, clock: Clock, seed: int = 1) -> list[MotionPanel]:
    """Measure every model in every kind of lab."""
    return [_run_scene(scene, effort, clock, seed) for scene in SCENES]


def _run_scene(
    scene: MotionScene, effort: Effort, clock: Clock, seed: int
) -> MotionPanel:
    spins = tuple(RPM * one for one in scene.rpm)
    pitch = math.radians(scene.tilt)
    design = Design(masses=MASSES, positions=(POSITION,), spins=spins, pitches=(pitch,))
    measured = measure(simulate(Truth(), design, _NOISE, None).readings)
    # A log without errors has less scatter than a real one; with the stated widths it
    # is typical.
    widths = fitting.Widths(
        1.0, fitting.fit(measured, tilted=bool(pitch)).widths.residual_torque
    )
    fit = fitting.fit(measured, tilted=bool(pitch), widths=widths)
    random = np.random.default_rng(seed)
    labs, one = (_draw_labs(scene, count, random) for count in (effort.motion_labs, 1))

    def error(found: Floats, true: Floats) -> float:
        """Compute the root mean square of the error of I_zz over the labs.

        The runs have the weights of the fit.
        """
        return math.sqrt(
            np.mean(
                ((found / true - 1).reshape(-1, len(fit.response)) @ fit.response) ** 2
            )
        )

    true = follow(labs, _CLOSE)[0]
    points = [
        MotionPoint(
            method,
            "",
            time_of(partial(model, one), clock, effort.repeats),
            error(model(labs), true),
        )
        for method, model in MODELS.items()
    ]
    true = follow(one, _CLOSEST)[0]
    for tolerance in TOLERANCES:
        begun = clock()
        found, evaluations = follow(one, tolerance)
        seconds = clock() - begun
        points.append(
            MotionPoint(
                "full motion",
                f"rtol {tolerance:.0e}",
                seconds,
                error(found, true),
                evaluations,
            )
        )
    return MotionPanel(scene, (fit.inertia.u or 0.0) / fit.inertia.value, tuple(points))


def _draw_labs(scene: MotionScene, count: int, random: np.random.Generator) -> _Labs:
    """Simulate labs with a random push and pitch for each run."""
    mass, start = (
        part.ravel()
        for part in np.meshgrid(MASSES, RPM * np.array(scene.rpm), indexing="ij")
    )
    # Different spins, because the phase of the nutation at the end of a run is random.
    mass, start = (
        np.tile(mass, count),
        np.tile(start, count) * random.uniform(0.95, 1.05, count * mass.size),
    )
    inertia = np.full(mass.shape, Truth().inertia)
    across = DEFAULT_TRANSVERSE_RATIO * inertia + mass * POSITION**2
    top = motion.Top(
        inertia, across, physics.torque(mass, POSITION, physics.STANDARD_GRAVITY)
    )
    pitch = np.radians(scene.tilt + random.uniform(-2, 2, mass.shape))
    push = random.uniform(*scene.push, mass.shape)
    rest = motion.released(top, start, pitch)
    steady = motion.steady(top, start, pitch)
    state = motion.State(
        rest.axis, rest.momentum + push[:, None] * (steady.momentum - rest.momentum)
    )
    time = (
        2 * np.pi / physics.precession_rate(top.torque, start, inertia, across, pitch)
    )
    return _Labs(
        top,
        state,
        pitch,
        physics.harmonic_mean_spin(start, start * np.exp(-time / DECAY)),
        time,
    )


MODELS: dict[str, Callable[[_Labs], Floats]] = {
    "eq. (9)": lambda labs: (
        labs.time
        * physics.horizontal_precession_rate(
            labs.top.torque, labs.spin, labs.top.inertia
        )
    ),
    "eq. (8)": lambda labs: (
        labs.time
        * physics.precession_rate(
            labs.top.torque,
            labs.spin,
            labs.top.inertia,
            labs.top.transverse_inertia,
            labs.pitch,
        )
    ),
    "mean rate of a release": lambda labs: (
        labs.time * motion.mean_precession_rate(labs.top, labs.spin, labs.pitch)
    ),
}
"""Azimuth that each rod sweeps in its time [rad]. No model knows the push, and eq. (9)
does not know the pitch."""


def follow(labs: _Labs, tolerance: float) -> tuple[Floats, int]:
    """Integrate eqs. (7) as vectors, with push, drag and Earth rotation.

    Returns
    -------
    ndarray, shape (9 L,)
        The swept azimuth [rad].
    int
        The number of evaluations.
    """
    from scipy.integrate import solve_ivp

    # Time is measured in durations of each run, so that all runs end at 1.
    rates = motion.vector_rates(labs.top, labs.top.inertia / DECAY, labs.time)

    def slope(_: float, row: Floats) -> Floats:
        vectors = row.reshape(2, 3, -1)
        change = np.array(rates(*row.reshape(6, -1))).reshape(vectors.shape)
        return np.asarray(change - labs.time * (_EARTH @ vectors)).ravel()

    start = np.concatenate([labs.state.axis.T, labs.state.momentum.T])
    scale = np.repeat([1.0, float(np.abs(labs.state.momentum).max())], start.size // 2)
    done = solve_ivp(
        slope,
        (0, 1),
        start.ravel(),
        "DOP853",
        rtol=tolerance,
        atol=0.01 * tolerance * scale,
    )
    x, y = done.y[:, -1].reshape(start.shape)[:2]
    azimuth = np.arctan2(y, x) - np.arctan2(start[1], start[0])
    # Add whole turns: the azimuth is near one turn.
    return 2 * np.pi + np.remainder(azimuth + np.pi, 2 * np.pi) - np.pi, done.nfev


# --- integrators ---

INERTIA, SPIN = Truth().inertia, 150 * RPM
"""I_zz of a 4-inch steel ball [kg*m^2], and its spin [rad/s]."""

_MASS = MASSES[-1]
TOP = motion.Top(
    INERTIA,
    DEFAULT_TRANSVERSE_RATIO * INERTIA + _MASS * POSITION**2,
    _MASS * POSITION * physics.STANDARD_GRAVITY,
)
START = motion.released(TOP, SPIN)

METHODS = {
    "splitting strang": 2,
    "splitting aba84": 4,
    "RK4": 4,
    "RK45": 5,
    "DOP853": 8,
}
"""Integrators and their order."""

AIMS = (1e-3, 1e-6, 1e-9)
"""Errors of e3 for which the number of evaluations is reported [1]."""

_ARRIVED = 3e-13
"""Smaller errors are rounding."""


class Grade(Struct, frozen=True):
    """One integrator with one setting."""

    setting: str
    evaluations: int
    """Number of evaluations of the torque in all turns."""
    seconds: float
    """CPU time of one evaluation, in Python [s]."""
    off: float
    """Distance of e3 from the true one at the end [1]."""


class Order(Struct, frozen=True):
    """All settings of one integrator."""

    method: str
    turns: int
    points: tuple[Grade, ...]

    @property
    def order(self) -> float | None:
        """The slope between large errors and rounding; None if there is no such range."""
        seen = [point for point in self.points if 1e-11 < point.off < 1e-3]
        if len(seen) < 2:
            return None
        evaluations = np.log([p.evaluations for p in seen])
        off = np.log([p.off for p in seen])
        return -float(np.polyfit(evaluations, off, 1)[0])

    def evaluations(self, aim: float) -> float | None:
        """Interpolate the number of evaluations for an error of e3.

        None if the error is outside the range.
        """
        for before, after in zip(self.points, self.points[1:], strict=False):
            if after.off <= aim < before.off:
                share = math.log(before.off / aim) / math.log(before.off / after.off)
                return float(
                    before.evaluations
                    * (after.evaluations / before.evaluations) ** share
                )
        return None


def find_orders(effort: Effort, clock: Clock) -> list[Order]:
    """Integrate the motion of the top for one turn and for many turns, with ever finer settings."""
    nod = motion.nutation(TOP, SPIN)
    rate = float(motion.mean_precession_rate(TOP, SPIN))
    orders = []
    for turns in (1, effort.turns):
        # After a whole number of nutations and a half the rod is at its lowest point,
        # where it moves fastest.
        time = (round(2 * math.pi * turns / rate / nod.period) + 0.5) * nod.period
        level = math.cos(nod.greatest_sag)
        azimuth = rate * time
        true = np.array(
            [
                level * math.cos(azimuth),
                level * math.sin(azimuth),
                -math.sin(nod.greatest_sag),
            ]
        )
        for method in METHODS:
            points: list[Grade] = []
            for power in range(2, 13):
                steps = math.ceil(2**power * time / nod.period)
                begun = clock()
                axis, evaluations, setting = _follow(
                    method, steps, 10.0 ** -(power + 1), time
                )
                seconds = max(clock() - begun, 1e-9) / evaluations
                off = float(np.linalg.norm(axis - true))
                points.append(
                    Grade(
                        setting or f"{2**power} steps per nutation",
                        evaluations,
                        seconds,
                        off,
                    )
                )
                if off < _ARRIVED or 2 * evaluations > effort.evaluations * turns**0.5:
                    break
            orders.append(Order(method, turns, tuple(points)))
    return orders


def _follow(
    method: str, steps: int, tolerance: float, time: float
) -> tuple[Floats, int, str]:
    """Integrate the motion for a time.

    Return e3 at the end, the number of evaluations, and a tolerance if used.
    """
    if method == "RK4":
        row = [*START.axis.tolist(), *START.momentum.tolist()]
        return (
            np.array(
                runge_kutta(motion.vector_rates(TOP), row, time / steps, steps)[:3]
            ),
            4 * steps,
            "",
        )
    if method.startswith("splitting"):
        name = method.removeprefix("splitting ")
        return (
            motion.split(TOP, START, time, steps, name).axis,
            steps * len(motion.METHODS[name][1]),
            "",
        )
    path, evaluations = motion.integrate(
        TOP, START, [time], method=method, rtol=tolerance, atol=1e-3 * tolerance
    )
    return path.axis[0], evaluations, f"rtol {tolerance:.0e}"


def cheapest(orders: Sequence[Order], turns: int) -> dict[str, tuple[float, float]]:
    """Find the integrators that need the fewest evaluations.

    The result for each integrator is the largest and the smallest error for which this
    is true.
    """
    winners: dict[str, tuple[float, float]] = {}
    for aim in np.geomspace(1e-2, 1e-11, 181).tolist():
        needed = {
            o.method: count
            for o in orders
            if o.turns == turns and (count := o.evaluations(aim))
        }
        if needed:
            best = min(needed, key=lambda method: needed[method])
            winners[best] = winners.get(best, (aim,))[0], aim
    return winners


def runge_kutta(
    rates: Callable[..., Sequence[float]], row: Sequence[float], step: float, steps: int
) -> list[float]:
    """Take steps of the classical Runge–Kutta method.

    The arguments of `rates` are the components of the row.
    """
    for _ in range(steps):
        a = rates(*row)
        b = rates(*[y + step / 2 * k for y, k in zip(row, a, strict=True)])
        c = rates(*[y + step / 2 * k for y, k in zip(row, b, strict=True)])
        d = rates(*[y + step * k for y, k in zip(row, c, strict=True)])
        row = [
            y + step / 6 * (p + 2 * (q + r) + s)
            for y, p, q, r, s in zip(row, a, b, c, d, strict=True)
        ]
    return list(row)
