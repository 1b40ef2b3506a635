"""The next runs of a lab: which of them reduce u of I_zz most for each minute.

A run that is not measured yet is added to the lab as it would be if the fit of the lab
were true, with the errors that it shares with the others. The fit of the larger lab
shows what u would be. The runs are chosen one after the other, each with the largest
relative gain of u for each minute of lab time. Runs that `gyro check` would doubt are
left out.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from operator import itemgetter
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting
from gyrodata.base.errors import InputError
from gyrodata.fitting import FitResult
from gyrodata.judging import changes
from gyrodata.judging.changes import Lab
from gyrodata.judging.procedure import SHORT
from gyrodata.judging.tables import load_words
from gyrodata.measurements import Measurements, checks, measure, select
from gyrodata.physics import RPM, models
from gyrodata.readings import read_log
from gyrodata.reporting.words import source_words
from gyrodata.results import to_json
from gyrodata.trials.simulation import Design, Truth, simulate

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


class Limits(Struct, frozen=True):
    """The weights, spins and time that a user has in the lab."""

    masses: tuple[float, ...] = ()
    """Weights [kg]; empty: those of the log."""
    positions: tuple[float, ...] = ()
    """Positions of the weights [m]; empty: those of the log."""
    spins: tuple[float, ...] = ()
    """[rad/s]; empty: slow, middle and fast, as in the log."""
    turns: tuple[float, ...] = (1.0,)
    """Numbers of turns that can be timed [1]."""
    minutes: float = 30.0
    """Lab time [min]; 0: none is left, and no run is planned."""
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
    end: str
    """Why the plan ends, in words."""
    left_out: dict[str, str]
    """An example of the runs that are left out, by the reading that `gyro check` would
    doubt: {"time": "500 g at 30 cm at 200 rpm"}, which is too short for a hand."""
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
    if (limits.masses or limits.positions) and np.isnan(lab.measured.mass).all():
        raise InputError.named("plan_without_masses")
    now = fitting.relative_u(lab.fit.inertia)
    return _plan(lab, limits, now, ())


def plan_lab(limits: Limits) -> Plan:
    """Plan a lab before it begins, with a typical ball.

    Each weight has a run at the middle spin first, of the most turns; without them u has
    no meaning.
    """
    usual = Design()
    masses = dict.fromkeys(limits.masses or usual.masses)
    positions = dict.fromkeys(limits.positions or usual.positions)
    spins = limits.spins or usual.spins
    middle = sorted(spins)[len(spins) // 2]
    turns = max(limits.turns)
    design = Design(tuple(masses), tuple(positions), (middle,), (turns,))
    log = simulate(Truth(), design, seed=None).log
    measured = measure(read_log(log.encode()))
    good = [run for run in range(len(measured.runs)) if not _fault(measured, run)]
    if not good:
        raise InputError.named("plan_impossible")
    measured = select(measured, good)
    lab = Lab(None, measured, fitting.fit(measured), models.Motion())
    u = fitting.relative_u(lab.fit.inertia)
    first = tuple([_planned(measured, run, u) for run in range(len(good))])
    return _plan(lab, replace(limits, spins=spins), None, first)


def _plan(
    lab: Lab, limits: Limits, now: float | None, first: tuple[PlannedRun, ...]
) -> Plan:
    """Choose runs, and say what remains."""
    ranked = _rank(lab, limits)[:SHOWN]
    if not ranked:
        raise InputError.named("plan_impossible")
    # The user sees the first choices with the u of their whole fits.
    choices = tuple([run for run, _ in _fitted(lab, ranked)])
    left_out = _doubted_runs(lab, limits)
    # Below zero if the first runs take longer: then no other run is planned.
    minutes = limits.minutes - sum(run.minutes for run in first)
    runs, lab, end = _choose(lab, limits, minutes)
    u = fitting.relative_u(lab.fit.inertia)
    limit = source_words(lab.fit.budget[0].source)
    others = _others(lab)
    return Plan(now, first, choices, runs, others, u, limit, limits.goal, end, left_out)


def _choose(
    lab: Lab, limits: Limits, minutes: float
) -> tuple[tuple[PlannedRun, ...], Lab, str]:
    """Choose runs that take up to some minutes.

    Return them, the lab with them, and why there are no more.
    """
    u = fitting.relative_u(lab.fit.inertia)
    goal = limits.goal or 0.0
    runs: list[PlannedRun] = []
    end = f"a plan has at most {MOST} runs"
    while len(runs) < MOST and u > goal:
        ranked = _rank(lab, limits, minutes)
        if not ranked:
            end = "no other run fits into the time"
            break
        # On the way to a goal each gain counts.
        least = u if goal else WORTH * u
        step = next((s for s in _fitted(lab, ranked[:SHOWN]) if s[0].u < least), None)
        if step is None:
            end = "no other run reduces u by more than 1 %"
            break
        run, lab = step
        u = run.u
        minutes -= run.minutes
        runs.append(run)
    if u <= goal:
        end = "the goal is reached"
    return tuple(runs), lab, end


def _fitted(
    lab: Lab, ranked: Sequence[tuple[PlannedRun, Measurements]]
) -> Iterator[tuple[PlannedRun, Lab]]:
    """Yield each run with the u of the whole fit, and the larger lab."""
    for run, measured in ranked:
        fit = _fit(lab, measured)
        u = fitting.relative_u(fit.inertia)
        yield replace(run, u=u), replace(lab, measured=measured, fit=fit)


def _rank(
    lab: Lab, limits: Limits, minutes: float = math.inf
) -> list[tuple[PlannedRun, Measurements]]:
    """List each run that can be added, with the lab that contains it, best first.

    The runs fit into a time [min]. At the widths of the fit of the lab, u of I_zz is
    quick to compute, and its ratio to that of the lab is right.
    """
    widths = lab.fit.widths
    now = fitting.relative_u(_fit(lab, lab.measured, widths).inertia)
    ranked = []
    for larger in _larger_labs(lab, limits):
        run = _planned(larger, -1, now)
        if run.minutes <= minutes and not _fault(larger):
            u = fitting.relative_u(_fit(lab, larger, widths).inertia)
            ranked.append((math.log(now / u) / run.minutes, run, larger))
    ranked.sort(key=itemgetter(0), reverse=True)
    return [(run, larger) for _, run, larger in ranked]


def _fit(
    lab: Lab, measured: Measurements, widths: fitting.Widths | None = None
) -> FitResult:
    """Fit a lab, at fixed widths if they are given."""
    return fitting.fit(
        measured, widths, tilted=lab.motion.tilted, left_out=lab.left_out
    )


def _planned(measured: Measurements, run: int, u: float) -> PlannedRun:
    """Describe a run of a lab."""
    time = float(measured.time[run])
    seconds = PREPARE + time
    if run == 0 or measured.torque[run] != measured.torque[run - 1]:
        seconds += CHANGE_WEIGHT
    return PlannedRun(
        mass=float(np.nan_to_num(measured.load[run])),
        position=float(np.nan_to_num(measured.position[run])),
        spin=float(measured.spin[run]),
        turns=float(measured.turns[run]),
        time=time,
        minutes=seconds / 60,
        u=u,
    )


# --- labs with one more run ---


class _Load(Struct, frozen=True):
    """A load on the rod, by a run of the lab whose load is nearest to it."""

    like: int
    """Index of this run."""
    mass_ratio: float = 1.0
    """Its mass over that of the run [1]."""
    position_ratio: float = 1.0
    """Its position over that of the run [1]."""


def _larger_labs(lab: Lab, limits: Limits) -> Iterator[Measurements]:
    """Yield the lab with each run that can be added."""
    measured = lab.measured
    # A slow, a middle and a fast spin, in whole rpm.
    rpm = np.quantile(np.abs(measured.spin) / RPM, [0.0, 0.5, 1.0]).round()
    spins = limits.spins or dict.fromkeys((RPM * rpm).tolist())
    settings = itertools.product(_loads(measured, limits), spins, limits.turns)
    for load, spin, turns in dict.fromkeys(settings):
        yield _with_run(measured, lab.fit, load, spin, turns)
    for change in changes.CHANGES["unloaded_run"](lab):
        yield change.measured


def _loads(measured: Measurements, limits: Limits) -> Iterator[_Load]:
    """Yield the loads of the log, or those that the user has."""
    # The weights of the last day are there.
    today = measured.day[-1]
    first_runs = [runs[0] for runs in measured.by_torque]
    loaded = [
        run for run in first_runs if measured.torque[run] and measured.day[run] == today
    ]
    if not (limits.masses or limits.positions):
        yield from map(_Load, loaded)
        return
    known = np.array([measured.mass[loaded], np.abs(measured.position[loaded])])
    masses = limits.masses or known[0].tolist()
    positions = limits.positions or known[1].tolist()
    for size in itertools.product(masses, positions):
        ratios = np.array(size)[:, None] / known
        nearest = int(np.abs(np.log(ratios)).sum(axis=0).argmin())
        ratio = ratios[:, nearest]
        # A weight that agrees within 1 % is that of the log.
        ratio[np.abs(ratio - 1) < SAME] = 1.0
        yield _Load(loaded[nearest], *ratio.tolist())


def _with_run(
    measured: Measurements, fit: FitResult, load: _Load, spin: float, turns: float
) -> Measurements:
    """Add a run with a load, a spin and a number of turns."""
    like = load.like
    bias = fit.timing_bias.value
    balance = fit.balances[like]
    torque = measured.torque[like] * load.mass_ratio * load.position_ratio
    time = (fit.fitted_time[like] - bias) * turns / measured.turns[like]
    faster = spin / measured.spin[like]
    slower = (measured.torque[like] + balance) / (torque + balance)
    values = {
        "mass": measured.mass[like] * load.mass_ratio,
        "position": measured.position[like] * load.position_ratio,
        "torque": torque,
        "spin": spin,
        "turns": turns,
        "time": time * faster * slower + bias,
    }
    larger = select(measured, [*range(len(measured.runs)), like])
    for name, value in values.items():
        getattr(larger, name)[-1] = value
    is_new = {"mass": load.mass_ratio != 1, "position": load.position_ratio != 1}
    for source in larger.sources:
        is_of_all = source.shared_by.startswith("all runs")
        is_own = not source.shared_by or is_new.get(source.quantity)
        if is_own and not is_of_all:
            source.groups[-1] = source.groups.max() + 1
    number = len(measured.runs) + 1
    return replace(
        larger, runs=(*measured.runs, f"planned {number}"), lines=(*measured.lines, 0)
    )


RANGES = {role: size.possible for role, size in checks.SIZES.items()}
RANGES["time"] = SHORT, RANGES["time"][1]
"""The readings that `gyro check` does not doubt [SI unit]."""


def _fault(measured: Measurements, run: int = -1) -> str:
    """Name the reading of a run that `gyro check` would doubt; "" if there is none."""
    for role, (low, high) in RANGES.items():
        size = abs(getattr(measured, role)[run])
        if 0 < size < low or size > high:
            return role
    return ""


def _doubted_runs(lab: Lab, limits: Limits) -> dict[str, str]:
    """Return, by the doubted reading, an example of the runs that are not planned."""
    labs = {_fault(larger): larger for larger in _larger_labs(lab, limits)}
    return {
        role: f"{load_words(larger, -1)} at {larger.spin[-1] / RPM:.0f} rpm"
        for role, larger in labs.items()
        if role
    }


# --- what remains ---


def _others(lab: Lab) -> tuple[Other, ...]:
    """List what else would reduce u of a lab: the advice of an analysis."""
    gains = sorted(changes.gains(lab, "advice", WORTH), key=itemgetter(2))
    return tuple(
        [Other(words, then / 100) for words, now, then in gains if then < WORTH * now]
    )
