"""Motion models and integrators: what an evaluation costs, and by how much I_zz would be wrong with it.

A scene is a lab of nine runs, three weights at three spins, each of one turn. A method gives the azimuth that the
rod of each run sweeps in the time that the turn really takes; how far this is from what it really sweeps is, to
first order, how far that run's I_zz is off. The runs count as the recommended fit weighs them.

Every method goes through one top alone, in Python's floats, and through a stack of `BATCH`, in arrays. A long run is
timed on its beginning and counts as many times as much as it has more evaluations of the torque.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import effects, fitting, motion, physics
from gyrodata.benchmark.effort import Clock, Effort, Progress
from gyrodata.benchmark.steppers import STEPPERS, march, tsit5
from gyrodata.benchmark.timing import Task, Timing, time_in_turns
from gyrodata.effects import choose_model
from gyrodata.fitting import ChosenModel
from gyrodata.measurements import Measurements, measure
from gyrodata.physics import RPM, Floats
from gyrodata.simulation import TYPICAL, Decay, Design, Runs, Truth, simulate
from gyrodata.units import Uncertainty

BATCH = 500
"""Tops of a stack."""

Family = Literal["closed form", "exact", "splitting", "fixed step", "adaptive"]

FAMILIES: dict[str, Family] = {
    "splitting strang": "splitting",
    "splitting aba84": "splitting",
    **dict.fromkeys(STEPPERS, "fixed step"),
}
"""Of the methods with a fixed step; the first are those of `motion.split`."""

_ALONE_ONLY = ("LSODA", "Radau")
"""They solve equations with as many unknowns as the stack has, six a top."""

_DRAGLESS = ("splitting strang", "splitting aba84", "implicit midpoint")

_EVALUATION = {("fixed", 1): 10e-6, ("fixed", BATCH): 40e-6, ("adaptive", 1): 60e-6, ("adaptive", BATCH): 40e-6}
"""What an evaluation takes where a curve's errors are found, about [s]: three runs in turn, or at once."""

_ARRIVED = 2e-13
"""A curve ends at this error [1]: below it rounding is seen, and no method."""

_PIECE = {1: 200, BATCH: 40}
"""Evaluations after which a run is not timed further, by the number of tops."""

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
    tops: int
    """1, or a stack of `BATCH`."""
    timing: Timing
    """For one top."""
    error: float
    """Of I_zz, relative, without its sign [1]."""
    evaluations: float | None = None
    """Of the torque for one top, mean over the runs, or of the whole stack; None where nothing is integrated."""

    @property
    def seconds(self) -> float:
        """Least CPU time for one top [s]."""
        return self.timing.seconds


class Duel(Struct, frozen=True):
    """The cheapest harmless method of a family beside the exact motion, in turns that follow one another closely."""

    tops: int
    family: Family
    method: str
    timing: Timing
    exact: Timing


class MotionPanel(Struct, frozen=True):
    """All methods in one scene."""

    scene: str
    title: str
    u: float
    """Relative standard uncertainty of I_zz that the recommended fit gives a typical lab there [1]."""
    points: tuple[MotionPoint, ...]
    ladder: str
    """The method that the ladder of models takes."""
    duels: tuple[Duel, ...] = ()

    @property
    def bound(self) -> float:
        """Error that does no harm [1]: what the ladder of models may leave out in all, `effects.DROP_ALL` × u."""
        return effects.DROP_ALL * self.u

    def of(self, tops: int) -> list[MotionPoint]:
        """The points of tops alone, 1, or of a stack."""
        return [point for point in self.points if point.tops == tops]

    def harmless(self, tops: int, *families: Family) -> list[MotionPoint]:
        """The points below the bound, of some families or of all, the cheapest first."""
        found = [p for p in self.of(tops) if p.error < self.bound and p.family in (families or (p.family,))]
        return sorted(found, key=lambda point: point.seconds)

    def cheapest(self, tops: int) -> MotionPoint | None:
        """The cheapest point below the bound."""
        return next(iter(self.harmless(tops)), None)

    @property
    def ladder_point(self) -> MotionPoint:
        """The point of the method that the ladder takes, for one top."""
        return next(point for point in self.points if point.method == self.ladder)


class _Lab(Struct, frozen=True):
    """What happens in one lab of n runs, and what is read of the spin; arrays of shape (n,), or floats for one run."""

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


def run_motion(
    effort: Effort, clock: Clock, seed: int = 1, progress: Progress | None = None, wall: Clock | None = None
) -> list[MotionPanel]:
    """Try every method in every scene; `clock` gives CPU time, `wall` the time on the wall."""
    panels = []
    for i, scene in enumerate(SCENES):
        panels.append(_run_scene(scene, effort, (clock, wall or clock), np.random.default_rng(seed)))
        if progress is not None:
            progress((i + 1) / len(SCENES))
    return panels


class _Tried(Struct, frozen=True):
    """A point whose time is not yet taken."""

    method: str
    setting: str
    family: Family
    tops: int
    error: float
    task: Task
    evaluations: float | None = None


def _run_scene(
    scene: MotionScene, effort: Effort, clocks: tuple[Clock, Clock], random: np.random.Generator
) -> MotionPanel:
    labs: list[_Lab] = []
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
    tried = [*_closed_forms(labs, response, effort), *_stepped(labs[0], response, effort)]
    timings = time_in_turns([one.task for one in tried], effort.repeats, *clocks)
    points = tuple(
        MotionPoint(one.method, one.setting, one.family, one.tops, timing, one.error, one.evaluations)
        for one, timing in zip(tried, timings, strict=True)
    )
    panel = MotionPanel(scene.name, scene.title, u, points, LADDER[chosen.name])
    tasks = dict(zip(points, (one.task for one in tried), strict=True))
    duels = tuple(_duel(panel, tops, tasks, _MORE * effort.repeats, clocks) for tops in (1, BATCH))
    return replace(panel, duels=sum(duels, ()))


STEPPING: tuple[Family, ...] = ("splitting", "fixed step", "adaptive")
"""Families that go step by step."""

_MORE, _TRIES = 3, 4
"""So many times as many rounds for those whose ratios are told, and so many tries where others interrupt."""


def _duel(
    panel: MotionPanel, tops: int, tasks: dict[MotionPoint, Task], rounds: int, clocks: tuple[Clock, Clock]
) -> tuple[Duel, ...]:
    """The exact motion and the two cheapest of each other family, again and again; the cheaper one counts."""
    exact = next((point for point in panel.of(tops) if point.family == "exact"), None)
    if exact is None:
        return ()
    rivals = [point for family in STEPPING for point in panel.harmless(tops, family)[:2]]
    own, *others = time_in_turns([tasks[point] for point in (exact, *rivals)], rounds, *clocks, _TRIES)
    duels = [
        Duel(tops, point.family, f"{point.method}, {point.setting}", timing, own)
        for point, timing in zip(rivals, others, strict=True)
    ]
    families = dict.fromkeys(duel.family for duel in duels)
    return tuple(
        min((duel for duel in duels if duel.family == family), key=lambda duel: duel.timing.seconds)
        for family in families
    )


def _weigh(measured: Measurements, chosen: ChosenModel) -> tuple[Floats, float]:
    """Weight of each run in I_zz, and the relative u of I_zz, as the tool fits such a lab."""
    _, fit = fitting.fit_model(measured, chosen)
    # A log without errors scatters less than any lab's: at the stated widths it is a typical lab.
    widths = fitting.Widths(1.0, fit.widths.residual_torque)
    _, typical = fitting.fit_model(measured, chosen, widths=widths, near=fit)
    return fit.response, (typical.inertia.u or 0.0) / fit.inertia.value


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


def _picked(lab: _Lab, pick: Callable[[Floats], Any]) -> _Lab:
    """Some of the runs, each number and vector taken by `pick`."""
    top = motion.Top(pick(lab.top.inertia), pick(lab.top.transverse_inertia), pick(lab.top.torque))
    state = motion.State(pick(lab.state.axis), pick(lab.state.momentum))
    numbers = (lab.pitch, lab.spin, lab.start, lab.plain, lab.time, lab.drag)
    pitch, spin, start, plain, time, drag = map(pick, numbers)
    return _Lab(top, state, pitch, spin, start, plain, time, drag, lab.released)


def _many(lab: _Lab) -> _Lab:
    """The same tops over and over, `BATCH` of them."""
    return _picked(lab, lambda values: np.resize(values, (BATCH, *np.shape(values)[1:])))


def _one(lab: _Lab, i: int) -> _Lab:
    """One run, in Python's floats."""
    return _picked(lab, lambda values: float(values[i]) if values.ndim == 1 else values[i])


# --- methods ------------------------------------------------------------------------------------------------


def _closed_forms(labs: list[_Lab], response: Floats, effort: Effort) -> Iterator[_Tried]:
    """Azimuth swept in the time of the turn, by each method that needs no steps."""
    first = labs[0]
    dragging = first.drag.any()
    methods: list[tuple[str, Callable[[_Lab], Floats]]] = [("eq. (9)", lambda lab: _level(lab, lab.spin))]
    if dragging:
        methods.append(("eq. (9), plain mean spin", lambda lab: _level(lab, lab.plain)))
        methods.append(("eq. (9), spin at start", lambda lab: _level(lab, lab.start)))
    methods.append(("eq. (8)", _steady))
    if not dragging:
        # Neither knows of drag.
        methods += [("mean rate", _mean_rate), ("exact motion", _exact)]
    tight = _azimuths(_tightest(first, effort).axis, 2 * np.pi)
    true = tight if dragging else _exact(first)
    for method, angle in methods:
        off = [float(np.sum(response * (angle(lab) / (true if lab is first else 2 * np.pi) - 1))) for lab in labs]
        if method == "exact motion":
            # It is what the others are compared with; the tightest integration bounds its own error.
            off = [float(np.sum(response * (angle(first) / tight - 1)))]
        error = math.sqrt(np.mean(np.square(off)))
        family: Family = "exact" if method == "exact motion" else "closed form"
        for tops, lab in ((1, _one(first, len(first.time) // 2)), (BATCH, _many(first))):
            calls = 1 if method in ("mean rate", "exact motion") else 10
            yield _Tried(method, "", family, tops, error, Task(partial(angle, lab), calls, 1 / tops))


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


def _stepped(lab: _Lab, response: Floats, effort: Effort) -> Iterator[_Tried]:
    """The methods that go step by step, each at all its settings, for tops alone and for a stack."""
    # The middle spin of each weight stands for all of that weight.
    weights = len(lab.time) // 3
    some = _picked(lab, lambda values: values[1::3])
    share = response.reshape(weights, 3).sum(axis=1)
    dragging = bool(lab.drag.any())
    true = _azimuths(_tightest(some, effort).axis, 2 * np.pi) if dragging else _exact(some)
    singles = [_one(some, i) for i in range(weights)]
    timed = {1: singles[weights // 2], BATCH: _many(some)}
    for method, settings in _settings(effort, dragging).items():
        family = FAMILIES.get(method, "adaptive")
        for tops in (1,) if method in _ALONE_ONLY else (1, BATCH):
            most = effort.budget / _EVALUATION["adaptive" if family == "adaptive" else "fixed", tops]
            for setting in settings:
                if family != "adaptive" and _steps(some, setting) * stages_of(method) > most:
                    break
                paths = [_follow(method, one, setting) for one in (singles if tops == 1 else [some])]
                evaluations = float(np.mean([path.evaluations for path in paths]))
                angles = _azimuths(np.array([path.axis for path in paths]).reshape(-1, 3), true)
                error = abs(float(np.sum(share * (angles / true - 1))))
                task = _beginning(method, timed[tops], setting, tops, evaluations)
                yield _Tried(method, setting_words(method, setting), family, tops, error, task, evaluations)
                if error < _ARRIVED or evaluations > most:
                    break


def _beginning(method: str, lab: _Lab, setting: float, tops: int, evaluations: float) -> Task:
    """Take the first part of a run, of enough evaluations, for all of them."""
    part, count = min(1.0, _PIECE[tops] / evaluations), 0
    while True:
        count = _follow(method, lab, setting, part).evaluations
        # A motion that begins steadily asks for little at first.
        if part == 1 or count > 0.8 * _PIECE[tops]:
            return Task(partial(_follow, method, lab, setting, part), share=evaluations / count / tops)
        part = min(1.0, 2 * part)


def _settings(effort: Effort, dragging: bool) -> dict[str, tuple[float, ...]]:
    """Steps a nutation, or relative tolerances, of each method that goes step by step."""
    fixed = (name for name in FAMILIES if not (dragging and name in _DRAGLESS))
    return {**dict.fromkeys(fixed, effort.steps_per_nutation), **effort.tolerances}


def _follow(method: str, lab: _Lab, setting: float, part: float = 1.0) -> motion.Path:
    """Follow a run, or all as a stack, or the first part of them, by steps a nutation or a relative tolerance."""
    if method in FAMILIES:
        steps = _steps(lab, setting)
        some = math.ceil(part * steps)
        return march(method.removeprefix("splitting "), lab.top, lab.state, lab.time * (some / steps), some, lab.drag)
    return motion.integrate(
        lab.top, lab.state, part * lab.time, drag=lab.drag, method=tsit5() if method == "Tsit5" else method,
        rtol=setting, atol=1e-3 * setting,
    )  # fmt: skip


def _steps(lab: _Lab, per_nutation: float) -> int:
    """Steps of one run, or of a stack as many as its busiest top needs."""
    rate = physics.nutation_rate(lab.start, lab.top.inertia, lab.top.transverse_inertia)
    return math.ceil(per_nutation * float(np.max(rate * lab.time)) / (2 * np.pi))


def stages_of(method: str) -> int:
    """Evaluations a step; the midpoint rule's are about four."""
    name = method.removeprefix("splitting ")
    return len(motion.METHODS[name][1]) if name in motion.METHODS else 4


def setting_words(method: str, setting: float) -> str:
    """Write steps a nutation, or a relative tolerance."""
    return f"{setting:g} steps a nutation" if method in FAMILIES else f"rtol {setting:.0e}"


def _tightest(lab: _Lab, effort: Effort) -> motion.Path:
    return _follow("DOP853", lab, effort.tightest)


def _azimuths(axis: Floats, expected: Floats | float) -> Floats:
    """Azimuth of rods [rad], of all that differ by whole turns the one nearest to what is expected."""
    azimuth = np.arctan2(axis[..., 1], axis[..., 0])
    return expected + np.remainder(azimuth - expected + np.pi, 2 * np.pi) - np.pi
