"""The next runs of a lab: which of them reduce u of I_zz most for each minute.

A run that is not measured yet is added to the lab as it would be if the fit of the lab
were true, with the errors that it shares with the others. The fit of the larger lab
shows what u would be. The runs are chosen one after the other, each with the largest
relative gain of u for each minute of lab time.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.fitting import FitResult
from gyrodata.judging import changes
from gyrodata.judging.changes import Lab
from gyrodata.measurements import (
    PLACED,
    SOURCES,
    Measurements,
    Source,
    measure,
    select,
)
from gyrodata.physics import RPM, models
from gyrodata.readings import read_log
from gyrodata.results import to_json
from gyrodata.trials.simulation import TYPICAL, Design, Truth, simulate

PREPARE = 60.0
CHANGE_WEIGHT = 60.0
"""Lab time to spin the ball up and to write a run down, and to put on another weight
[s]."""

WORTH = 0.99
"""A run is worth its time if it reduces u at least to this part of its value."""

SHOWN = 8
"""Largest number of runs that could be next in a plan."""

MOST = 20
"""Largest number of runs of a plan."""

SAME = 0.01
"""Relative difference below which two loads are the same [1]."""

UNLOADED_SPAN = 120.0
"""For how long a run without a weight is watched [s]."""


class Limits(Struct, frozen=True):
    """The weights, spins and time that a user has in the lab."""

    masses: tuple[float, ...] = ()
    """Weights [kg]; empty: those of the log."""
    positions: tuple[float, ...] = ()
    """Positions of these weights [m]; empty: those of the log."""
    spins: tuple[float, ...] = ()
    """[rad/s]; empty: slow, middle and fast, as in the log."""
    turns: tuple[float, ...] = (1.0,)
    """Numbers of turns that can be timed [1]."""
    minutes: float = 30.0
    """Lab time [min]."""
    goal: float | None = None
    """u of I_zz over I_zz at which the plan ends [1]."""


class PlannedRun(Struct, frozen=True):
    """One run that is not measured yet."""

    mass: float
    """[kg]; 0 without a weight."""
    position: float
    """[m]; 0 without a weight."""
    spin: float
    """[rad/s]"""
    turns: float
    """[1]"""
    time: float
    """Expected time of the turns [s]."""
    minutes: float
    """Lab time that it needs [min]."""
    u: float
    """u of I_zz over I_zz after this run [1]."""


class Other(Struct, frozen=True):
    """Something else that would reduce u."""

    words: str
    u: float
    """u of I_zz over I_zz with it [1]."""


class Plan(Struct, frozen=True):
    """The next runs of a lab."""

    now: float | None
    """u of I_zz over I_zz before the plan [1]; null if nothing is measured yet."""
    first: tuple[PlannedRun, ...]
    """Runs that are needed before u can be computed; only before a lab."""
    choices: tuple[PlannedRun, ...]
    """The best runs that could be next, the best for its time first."""
    runs: tuple[PlannedRun, ...]
    """The runs of the plan in their order."""
    others: tuple[Other, ...]
    """What else would reduce u after the plan, the best first."""
    u: float
    """u of I_zz over I_zz after the plan [1]."""
    limit: str
    """The largest source of uncertainty after the plan, in words."""
    goal: float | None
    """u of I_zz over I_zz that was asked for [1]."""
    schema: Literal["gyro.plan/1"] = "gyro.plan/1"

    @property
    def minutes(self) -> float:
        """Lab time of the plan [min]."""
        return sum(run.minutes for run in (*self.first, *self.runs))

    def to_dict(self) -> dict[str, object]:
        """Return the object of the JSON, with the schema "gyro.plan/1"."""
        return {"schema": self.schema, **to_json(self)}


def plan_log(lab: Lab, limits: Limits) -> Plan:
    """Plan the next runs of a lab that has begun."""
    now = fitting.relative_u(lab.fit.inertia)
    return _plan(lab, limits, now, ())


def plan_lab(limits: Limits) -> Plan:
    """Plan a lab before it begins, with a typical ball.

    Each weight has a run at the middle spin first; without them u has no meaning.
    """
    masses = limits.masses or Design().masses
    positions = limits.positions or Design().positions
    spins = limits.spins or Design().spins
    limits = replace(limits, masses=masses, positions=positions, spins=spins)
    middle = sorted(spins)[len(spins) // 2]
    design = Design(masses, positions, (middle,), limits.turns[:1])
    log = simulate(Truth(), design, TYPICAL, None).log
    measured = measure(read_log(log.encode()))
    lab = Lab(None, measured, fitting.fit(measured), models.Motion())
    u = fitting.relative_u(lab.fit.inertia)
    first = [_planned(measured, run, u) for run in range(len(measured.runs))]
    return _plan(lab, limits, None, tuple(first))


def _plan(
    lab: Lab, limits: Limits, now: float | None, first: tuple[PlannedRun, ...]
) -> Plan:
    """Choose runs until the time is over, the goal is reached or no run is worth it."""
    measured = lab.measured
    fit = lab.fit
    u = fitting.relative_u(fit.inertia)
    left = limits.minutes - sum(run.minutes for run in first)
    choices: tuple[PlannedRun, ...] = ()
    runs: list[PlannedRun] = []
    while len(runs) < MOST and not (limits.goal and u <= limits.goal):
        ranked = _rank(lab, measured, fit, limits)
        # The user sees the first choices with the u of their whole fits.
        choices = choices or tuple(
            [
                replace(run, u=fitting.relative_u(_fit(lab, larger).inertia))
                for run, larger in ranked[:SHOWN]
            ]
        )
        possible = [each for each in ranked if each[0].minutes <= left]
        step = _first_worth(lab, possible, u)
        if step is None:
            break
        run, measured, fit = step
        u = run.u
        left -= run.minutes
        runs.append(run)
    others = _others(replace(lab, measured=measured, fit=fit))
    limit = _limit(fit)
    return Plan(now, first, choices, tuple(runs), others, u, limit, limits.goal)


def _first_worth(
    lab: Lab, ranked: Sequence[tuple[PlannedRun, Measurements]], u: float
) -> tuple[PlannedRun, Measurements, FitResult] | None:
    """Return the first run whose whole fit reduces u [1] enough, and its larger lab."""
    for run, larger in ranked[:SHOWN]:
        fit = _fit(lab, larger)
        then = fitting.relative_u(fit.inertia)
        if then <= WORTH * u:
            return replace(run, u=then), larger, fit
    return None


def _rank(
    lab: Lab, measured: Measurements, fit: FitResult, limits: Limits
) -> list[tuple[PlannedRun, Measurements]]:
    """List each run that can be added, with the lab that contains it, best first."""
    now = fitting.relative_u(_fit(lab, measured, fit).inertia)
    ranked = []
    for larger in _larger_labs(measured, fit, limits):
        u = fitting.relative_u(_fit(lab, larger, fit).inertia)
        run = _planned(larger, len(larger.runs) - 1, u)
        ranked.append((math.log(now / u) / run.minutes, run, larger))
    ranked.sort(key=lambda each: -each[0])
    # The fits at fixed widths show the ratio of u; the value is that of the whole fit.
    scale = fitting.relative_u(fit.inertia) / now
    return [(replace(run, u=run.u * scale), larger) for _, run, larger in ranked]


def _fit(lab: Lab, measured: Measurements, near: FitResult | None = None) -> FitResult:
    """Fit a lab; with the widths of another fit, which is faster, if given."""
    left_out = lab.left_out
    widths = None if near is None else near.widths
    return fitting.fit(measured, widths, tilted=lab.motion.tilted, left_out=left_out)


def _planned(measured: Measurements, run: int, u: float) -> PlannedRun:
    """Describe a run of a lab."""
    loaded = bool(measured.torque[run])
    seconds = PREPARE + float(measured.time[run])
    if run == 0 or measured.torque[run] != measured.torque[run - 1]:
        seconds += CHANGE_WEIGHT
    load = np.nan_to_num(measured.load[run])
    return PlannedRun(
        mass=float(load) if loaded else 0.0,
        position=float(np.nan_to_num(measured.position[run])) if loaded else 0.0,
        spin=float(measured.spin[run]),
        turns=float(measured.turns[run]),
        time=float(measured.time[run]),
        minutes=seconds / 60,
        u=u,
    )


# --- labs with one more run ---


class _Load(Struct, frozen=True):
    """A load on the rod, by a run of the lab whose load is nearest to it."""

    like: int
    """Index of this run."""
    mass: float = 1.0
    """Its mass over that of the run [1]."""
    position: float = 1.0
    """Its position over that of the run [1]."""


def _larger_labs(
    measured: Measurements, fit: FitResult, limits: Limits
) -> Iterator[Measurements]:
    """Yield the lab with each run that can be added."""
    spins = limits.spins or _usual_spins(measured)
    settings = itertools.product(_loads(measured, limits), spins, limits.turns)
    for load, spin, turns in settings:
        yield _with_loaded_run(measured, fit, load, spin, turns)
    if measured.torque.all():
        yield _with_unloaded_run(measured, fit, sorted(spins)[len(spins) // 2])


def _usual_spins(measured: Measurements) -> tuple[float, ...]:
    """Return a slow, a middle and a fast spin of a log, in whole rpm [rad/s]."""
    rpm = np.quantile(np.abs(measured.spin) / RPM, [0.0, 0.5, 1.0]).round()
    return tuple(dict.fromkeys((RPM * rpm).tolist()))


def _loads(measured: Measurements, limits: Limits) -> Iterator[_Load]:
    """Yield the loads of the log, or those that the user has."""
    # A load of several days is that of the last one.
    first = [runs[0] for runs in measured.by_torque if measured.torque[runs[0]]]
    last = {(measured.load[run], measured.position[run]): run for run in first}
    loaded = list(last.values())
    if not limits.masses or np.isnan(measured.mass).all():
        yield from map(_Load, loaded)
        return
    positions = limits.positions or (abs(float(measured.position[loaded[0]])),)
    for mass, position in itertools.product(limits.masses, positions):
        yield _nearest_load(measured, loaded, mass, position)


def _nearest_load(
    measured: Measurements, loaded: list[int], mass: float, position: float
) -> _Load:
    """Describe a load by the run whose load is nearest to it."""
    masses = mass / measured.mass[loaded]
    positions = position / np.abs(measured.position[loaded])
    at = int(np.argmin(np.abs(np.log(masses)) + np.abs(np.log(positions))))
    ratios = [float(masses[at]), float(positions[at])]
    # A weight that agrees within 1 % is that of the log.
    near = [1.0 if abs(ratio - 1) < SAME else ratio for ratio in ratios]
    return _Load(loaded[at], *near)


def _with_loaded_run(
    measured: Measurements, fit: FitResult, load: _Load, spin: float, turns: float
) -> Measurements:
    """Add a run with a load, a spin and a number of turns."""
    like = load.like
    m0 = fit.residual_torque.value
    bias = fit.timing_bias.value
    torque = measured.torque[like] * load.mass * load.position
    faster = spin / abs(measured.spin[like])
    slower = (measured.torque[like] + m0) / (torque + m0)
    time = (fit.fitted_time[like] - bias) * turns / measured.turns[like]
    values = {
        "mass": measured.mass[like] * load.mass,
        "force": measured.force[like] * load.mass,
        "position": measured.position[like] * load.position,
        "torque": torque,
        "spin": measured.spin[like] * faster,
        "turns": turns,
        "time": time * faster * slower + bias,
    }
    ratios = {"mass": load.mass, "position": load.position}
    others = [name for name, ratio in ratios.items() if ratio != 1]
    return _with_run(measured, like, values, others)


def _with_unloaded_run(
    measured: Measurements, fit: FitResult, spin: float
) -> Measurements:
    """Add a run without a weight, with its direction."""
    m0 = fit.residual_torque.value
    # Without a residual torque the rod stands still.
    torque = math.copysign(max(abs(m0), 0.005 * np.abs(measured.torque).min()), m0)
    rate = torque / (fit.inertia.value * spin)
    nothing = dict.fromkeys(("mass", "force", "position", "torque", "pitch"), 0.0)
    values = {
        **nothing,
        "given_torque": 0.0,
        "spin": spin,
        "time": UNLOADED_SPAN + fit.timing_bias.value,
        "turns": UNLOADED_SPAN * abs(rate) / (2 * math.pi),
        "sense": math.copysign(1.0, torque),
    }
    return _with_run(measured, len(measured.runs) - 1, values, ("none",))


def _with_run(
    measured: Measurements, like: int, values: dict[str, float], others: Sequence[str]
) -> Measurements:
    """Add a run to a lab, like another one but for some values.

    `others` names the quantities of the load that have an error of their own; "none"
    means that there is no load, and no error of it.
    """
    larger = select(measured, [*range(len(measured.runs)), like])
    today = measured.day[-1]
    if larger.block is not None:
        larger.block[-1] = today
    # A weight of another day is set again.
    set_again = () if measured.day[like] == today else PLACED
    for name, value in values.items():
        readings = getattr(larger, name)
        if readings is not None and not np.isnan(readings).all():
            readings[-1] = value
    for source in larger.sources:
        source.groups[-1] = _group_of_last_run(source, others, set_again)
    number = len(measured.runs) + 1
    return replace(
        larger, runs=(*measured.runs, f"planned {number}"), lines=(*measured.lines, 0)
    )


def _group_of_last_run(
    source: Source, others: Sequence[str], set_again: Sequence[str]
) -> int:
    """Return the group of an added run in a source of error; -1 without this error."""
    group = int(source.groups[-1])
    of_load = source.quantity in ("mass", "force", "torque", "position", "pitch")
    if "none" in others and of_load:
        return -1
    if source.shared_by.startswith("all runs"):
        return max(group, 0)
    is_own = not source.shared_by or source.quantity in others
    if is_own or source.name in set_again:
        return int(source.groups.max()) + 1
    return group


# --- what remains ---


def _limit(fit: FitResult) -> str:
    """Name the largest source of uncertainty of a fit."""
    largest = max(fit.budget, key=lambda share: share.share, default=None)
    if largest is None:
        return "nothing"
    source = SOURCES.get(largest.source)
    words = models.source_words() | {"unexplained_scatter": "scatter of the runs"}
    return source.words if source else words.get(largest.source, largest.source)


def _others(lab: Lab) -> tuple[Other, ...]:
    """List what else would reduce u of a lab: the advice of an analysis."""
    others = [
        Other(answer.words, fitting.relative_u(answer.inertia))
        for change, answer in changes.answers(lab, "advice")
        if answer.inertia is not None and change.name != "unloaded_run"
    ]
    now = fitting.relative_u(lab.fit.inertia)
    worth = [other for other in others if other.u < WORTH * now]
    return tuple(sorted(worth, key=lambda other: other.u))
