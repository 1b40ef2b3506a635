"""Motion models and integrators: what an evaluation costs, and by how much I_zz would be wrong with it.

A scene is a lab of nine runs, three weights at three spins, each of one turn. A method gives the azimuth that the
rod of each run sweeps in the time that the turn really takes; how far this is from what it really sweeps is, to
first order, how far that run's I_zz is off. The runs count as the recommended fit weighs them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import effects, fitting, motion, physics
from gyrodata.benchmark.effort import Clock, Effort, Progress
from gyrodata.benchmark.stability import one_top
from gyrodata.effects import choose_model
from gyrodata.fitting import ChosenModel
from gyrodata.forecast import design_of, expected_u
from gyrodata.measurements import Measurements, measure
from gyrodata.physics import RPM, Floats
from gyrodata.simulation import TYPICAL, Decay, Design, Runs, Truth, simulate
from gyrodata.units import Uncertainty

BATCH = 500
"""Tops at a time for the methods that take arrays."""

Family = Literal["closed form", "exact", "splitting", "integrator"]

_NOISE = {**TYPICAL, "u_time_bias": Uncertainty(0.05)}
"""What the labs state: a hand that has practised, else a scene would tell of the hand and not of the motion."""

LADDER = {"horizontal": "eq. (9)", "steady": "eq. (8)", "released": "mean rate"}
"""The method that each model of an analysis is."""


class MotionScene(Struct, frozen=True):
    """A lab whose motion is to be described."""

    name: str
    title: str
    truth: Truth
    spin: float
    """Nominal spin of all runs [rad/s]."""
    pitch: float = 0.0
    """[rad]"""
    labs: int = 1
    """Labs with other spins near the nominal one, of which the root mean square is taken: a rod let go from rest
    nods, and where in its nodding the clock stops is luck."""


SCENES = (
    MotionScene("level", "level and steady, 400 rpm", Truth(), 400 * RPM),
    MotionScene("tilted", "tilted 10°, 200 rpm", Truth(), 200 * RPM, math.radians(10)),
    MotionScene("released", "released from rest at 200 rpm", Truth(motion="released"), 200 * RPM, labs=200),
    MotionScene("steep", "tilted 45°, 100 rpm", Truth(), 100 * RPM, math.radians(45)),
    MotionScene("decay", "spin falling by half, harmonic mean", Truth(decay=Decay(lost=0.5)), 400 * RPM),
)


class MotionPoint(Struct, frozen=True):
    """One method at one setting in one scene."""

    method: str
    setting: str
    """Tolerance or steps; "" where there is none."""
    family: Family
    seconds: float
    """For one top [s]; in arrays of `BATCH` where the method takes arrays, one by one for the integrators."""
    error: float
    """Of I_zz, relative, without its sign [1]."""


class MotionPanel(Struct, frozen=True):
    """All methods in one scene."""

    scene: str
    title: str
    u: float
    """Relative standard uncertainty of I_zz that the recommended fit gives a typical lab there [1]."""
    points: tuple[MotionPoint, ...]
    ladder: str
    """The method that the ladder of models takes."""

    @property
    def bound(self) -> float:
        """Error that does no harm [1]: what the ladder of models may leave out in all, `effects.DROP_ALL` × u."""
        return effects.DROP_ALL * self.u

    @property
    def winner(self) -> MotionPoint:
        """The cheapest point below the bound."""
        return min((point for point in self.points if point.error < self.bound), key=lambda point: point.seconds)

    @property
    def ladder_point(self) -> MotionPoint:
        """The point of the method that the ladder takes."""
        return next(point for point in self.points if point.method == self.ladder)


class _Lab(Struct, frozen=True):
    """What happens in one lab of n runs, and what is read of the spin; arrays of shape (n,)."""

    top: motion.Top
    state: motion.State
    """At the start of the clock."""
    pitch: Floats
    spin: Floats
    """Mean, as the tool takes it [rad/s]."""
    start: Floats
    """Spin at the start [rad/s]."""
    plain: Floats
    """Arithmetic mean of the spins at start and end [rad/s]."""
    time: Floats
    """That a turn takes [s]."""
    drag: Floats
    """c of the torque −c ω [N*m*s]."""
    released: bool


def run_motion(effort: Effort, clock: Clock, seed: int = 1, progress: Progress | None = None) -> list[MotionPanel]:
    """Try every method in every scene."""
    panels = []
    for i, scene in enumerate(SCENES):
        panels.append(_run_scene(scene, effort, clock, np.random.default_rng(seed)))
        if progress is not None:
            progress((i + 1) / len(SCENES))
    return panels


def _run_scene(scene: MotionScene, effort: Effort, clock: Clock, random: np.random.Generator) -> MotionPanel:
    labs: list[_Lab] = []
    points = []
    spins = scene.spin * (1 + 0.05 * random.uniform(-1, 1, (scene.labs, 3)))
    spins[0] = scene.spin * np.array([0.95, 1.0, 1.05])
    for row in spins:
        design = Design(spins=tuple(float(spin) for spin in row), pitches=(scene.pitch,))
        # Without errors, but with those stated that such a lab has.
        simulation = simulate(scene.truth, design, _NOISE, None)
        measured = measure(simulation.readings)
        if not labs:
            chosen = choose_model(measured, "auto")
            response, u = _weigh(measured, chosen)
        labs.append(_lab(scene, simulation.runs, measured))
    first = labs[0]
    tight = _integrated(first, "DOP853", effort.tightest)
    true = tight if first.drag.any() else motion.precession_angle(first.top, first.state, first.time)
    many = _many(first)
    for method, angle in _closed_forms(first):
        off = [float(np.sum(response * (angle(lab) / (true if lab is first else 2 * np.pi) - 1))) for lab in labs]
        if method == "exact motion":
            # It is what the others are compared with; the tightest integration bounds its own error.
            off = [float(np.sum(response * (angle(first) / tight - 1)))]
        seconds = _shortest(clock, effort.repeats, 20, partial(angle, many)) / BATCH
        family: Family = "exact" if method == "exact motion" else "closed form"
        points.append(MotionPoint(method, "", family, seconds, math.sqrt(np.mean(np.square(off)))))
    points += [
        replace(point, error=abs(float(np.sum(response * (angles / true - 1)))))
        for point, angles in _stepped(first, true, effort, clock)
    ]
    return MotionPanel(scene.name, scene.title, u, tuple(points), LADDER[chosen.name])


def _weigh(measured: Measurements, chosen: ChosenModel) -> tuple[Floats, float]:
    """Weight of each run in I_zz, and the relative u of I_zz, as the tool fits such a lab."""
    runs = fitting.iterate_mean_rate(measured, chosen)
    # A log without errors scatters less than any lab's: what it says of the scatter is no part of a typical lab.
    fit = fitting.fit_as_stated(runs, chosen.tilted)
    return fit.response, expected_u([design_of(runs, fit, chosen.tilted)])[0] / fit.inertia.value


def _lab(scene: MotionScene, runs: Runs, measured: Measurements) -> _Lab:
    inertia = np.full(len(runs.time), scene.truth.inertia)
    top = motion.Top(inertia, runs.across, runs.torque)
    released = scene.truth.motion == "released"
    begin = motion.released if released else motion.steady
    end = runs.spin if runs.spin_end is None else runs.spin_end
    return _Lab(
        top=top,
        state=begin(top, runs.spin, runs.pitch),
        pitch=runs.pitch,
        spin=measured.spin,
        start=runs.spin,
        plain=(runs.spin + end) / 2,
        time=runs.time,
        drag=inertia * np.log(runs.spin / end) / runs.time,
        released=released,
    )


def _many(lab: _Lab) -> _Lab:
    """The same tops over and over, `BATCH` of them."""

    def more(values: Floats) -> Floats:
        return np.resize(values, (BATCH, *np.shape(values)[1:]))

    top = motion.Top(more(lab.top.inertia), more(lab.top.transverse_inertia), more(lab.top.torque))
    state = motion.State(more(lab.state.axis), more(lab.state.momentum))
    pitch, spin, start, plain, time, drag = map(more, (lab.pitch, lab.spin, lab.start, lab.plain, lab.time, lab.drag))
    return _Lab(top, state, pitch, spin, start, plain, time, drag, lab.released)


# --- methods ------------------------------------------------------------------------------------------------


def _closed_forms(lab: _Lab) -> list[tuple[str, Callable[[_Lab], Floats]]]:
    """Azimuth swept in the time of the turn [rad], by each method that needs no steps."""
    methods: list[tuple[str, Callable[[_Lab], Floats]]] = [("eq. (9)", lambda lab: _level(lab, lab.spin))]
    if lab.drag.any():
        methods.append(("eq. (9), plain mean spin", lambda lab: _level(lab, lab.plain)))
        methods.append(("eq. (9), spin at start", lambda lab: _level(lab, lab.start)))
    methods.append(("eq. (8)", _steady))
    if not lab.drag.any():
        # Neither knows of drag.
        methods += [("mean rate", _mean_rate), ("exact motion", _exact)]
    return methods


def _level(lab: _Lab, spin: Floats) -> Floats:
    rate: Floats = physics.horizontal_precession_rate(lab.top.torque, spin, lab.top.inertia)
    return rate * lab.time


def _steady(lab: _Lab) -> Floats:
    top = lab.top
    rate: Floats = physics.precession_rate(top.torque, lab.spin, top.inertia, top.transverse_inertia, lab.pitch)
    return rate * lab.time


def _begin(lab: _Lab) -> motion.State:
    return (motion.released if lab.released else motion.steady)(lab.top, lab.spin, lab.pitch)


def _mean_rate(lab: _Lab) -> Floats:
    rate: Floats = motion.mean_precession_rate(lab.top, _begin(lab))
    return rate * lab.time


def _exact(lab: _Lab) -> Floats:
    angle: Floats = motion.precession_angle(lab.top, _begin(lab), lab.time)
    return angle


def _stepped(lab: _Lab, true: Floats, effort: Effort, clock: Clock) -> Iterator[tuple[MotionPoint, Floats]]:
    """Azimuths [rad] by the methods that go step by step, shape (n,), each with its cost."""
    if not lab.drag.any():
        top = lab.top
        period = 2 * np.pi / physics.nutation_rate(lab.spin, top.inertia, top.transverse_inertia)
        many = _many(lab)
        for method in ("strang", "aba84"):
            for per in effort.steps_per_nutation:
                steps = np.ceil(per * lab.time / period).astype(int)
                ends = [
                    motion.split(*one_top(top, lab.state, i), lab.time[i], int(steps[i]), method).axis
                    for i in range(len(steps))
                ]
                middle = int(np.median(steps))
                evaluate = partial(motion.split, many.top, many.state, many.time, middle, method)
                seconds = _shortest(clock, 1, 1, evaluate) / BATCH
                setting = f"{per:g} steps a nutation"
                yield MotionPoint(f"splitting {method}", setting, "splitting", seconds, 0.0), _nearest(ends, true)
    for method, tolerances in effort.tolerances.items():
        for tolerance in tolerances:
            begun = clock()
            angles = _integrated(lab, method, tolerance)
            seconds = max(clock() - begun, 1e-9) / len(angles)
            yield MotionPoint(method, f"rtol {tolerance:.0e}", "integrator", seconds, 0.0), angles


def _integrated(lab: _Lab, method: str, tolerance: float) -> Floats:
    """Azimuths by an integrator of `scipy`, drag included [rad]."""
    ends = [
        motion.integrate(
            *one_top(lab.top, lab.state, i), lab.time[i],
            drag=float(lab.drag[i]), method=method, rtol=tolerance, atol=1e-3 * tolerance,
        ).axis
        for i in range(len(lab.time))
    ]  # fmt: skip
    return _nearest(ends, np.full(len(ends), 2 * np.pi))


def _nearest(ends: list[Floats], expected: Floats) -> Floats:
    """Azimuth of rods [rad], of all that differ by whole turns the one nearest to what is expected."""
    axis = np.array(ends)
    azimuth = np.arctan2(axis[:, 1], axis[:, 0])
    return expected + np.remainder(azimuth - expected + np.pi, 2 * np.pi) - np.pi


def _shortest(clock: Clock, repeats: int, calls: int, evaluate: Callable[[], object]) -> float:
    """Shortest time of one call [s] in several tries of several calls; never zero, whatever the clock's steps."""
    times = []
    for _ in range(repeats):
        begun = clock()
        for _ in range(calls):
            evaluate()
        times.append(clock() - begun)
    return max(min(times), 1e-9) / calls
