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
from gyrodata.fitting import FitResult, relative_u
from gyrodata.judging import changes
from gyrodata.judging.changes import Lab
from gyrodata.judging.procedure import SHORT
from gyrodata.judging.tables import load_words
from gyrodata.measurements import Measurements, checks, measure, select
from gyrodata.physics import RPM, models
from gyrodata.readings import read_log
from gyrodata.reporting.content import source_words
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
    now = relative_u(lab.fit.inertia)
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
    readings = read_log(log.encode())
    measured = measure(readings)
    count = len(measured.runs)
    good = [run for run in range(count) if not _fault(measured, run)]
    if not good:
        raise InputError.named("plan_impossible")
    measured = select(measured, good)
    lab = Lab(None, measured, fitting.fit(measured), models.Motion())
    u = relative_u(lab.fit.inertia)
    first = [_planned(measured, run, u) for run in range(len(good))]
    left = limits.minutes - sum(run.minutes for run in first)
    return _plan(lab, replace(limits, minutes=left, spins=spins), None, tuple(first))


def _plan(
    lab: Lab, limits: Limits, now: float | None, first: tuple[PlannedRun, ...]
) -> Plan:
    """Choose runs, and say what remains."""
    ranked = _rank(lab, limits)[:SHOWN]
    if not ranked:
        raise InputError.named("plan_impossible")
    # The user sees the first choices with the u of their whole fits.
    choices = tuple([run for run, _ in _fitted(lab, ranked)])
    left_out = _left_out(lab, limits)
    runs, lab, end = _choose(lab, limits)
    u = relative_u(lab.fit.inertia)
    largest = lab.fit.budget[0]
    limit = source_words(largest.source)
    others = _others(lab)
    return Plan(now, first, choices, runs, others, u, limit, limits.goal, end, left_out)


def _choose(lab: Lab, limits: Limits) -> tuple[tuple[PlannedRun, ...], Lab, str]:
    """Choose runs; return them, the lab with them, and why there are no more."""
    u = relative_u(lab.fit.inertia)
    left = limits.minutes
    goal = limits.goal or 0.0
    runs: list[PlannedRun] = []
    end = f"a plan has at most {MOST} runs"
    while len(runs) < MOST and u > goal:
        ranked = _rank(lab, limits, left)
        if not ranked:
            end = "no other run fits into the time"
            break
        # On the way to a goal each gain counts.
        least = u if goal else WORTH * u
        best = _fitted(lab, ranked[:SHOWN])
        step = next(((run, larger) for run, larger in best if run.u < least), None)
        if step is None:
            end = "no other run reduces u by more than 1 %"
            break
        run, lab = step
        u = run.u
        left -= run.minutes
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
        u = relative_u(fit.inertia)
        yield replace(run, u=u), replace(lab, measured=measured, fit=fit)


def _rank(
    lab: Lab, limits: Limits, minutes: float = math.inf
) -> list[tuple[PlannedRun, Measurements]]:
    """List each run that can be added, with the lab that contains it, best first.

    The runs fit into a time [min]. At the widths of the fit of the lab, u of I_zz is
    quick to compute, and its ratio to that of the lab is right.
    """
    widths = lab.fit.widths
    fit = _fit(lab, lab.measured, widths)
    now = relative_u(fit.inertia)
    ranked = []
    for larger in _larger_labs(lab, limits):
        run = _planned(larger, -1, now)
        if run.minutes <= minutes and not _fault(larger):
            fit = _fit(lab, larger, widths)
            u = relative_u(fit.inertia)
            ratio = now / u
            gain = math.log(ratio)
            ranked.append((gain / run.minutes, run, larger))
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
    torque = measured.torque
    is_changed = torque[run] != torque[run - 1]
    if run == 0 or is_changed:
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
    mass: float = 1.0
    """Its mass over that of the run [1]."""
    position: float = 1.0
    """Its position over that of the run [1]."""


def _larger_labs(lab: Lab, limits: Limits) -> Iterator[Measurements]:
    """Yield the lab with each run that can be added."""
    measured = lab.measured
    # A slow, a middle and a fast spin, in whole rpm.
    speeds = np.abs(measured.spin) / RPM
    rpm = np.quantile(speeds, [0.0, 0.5, 1.0]).round()
    spins = limits.spins or dict.fromkeys((RPM * rpm).tolist())
    loads = _loads(measured, limits)
    settings = itertools.product(loads, spins, limits.turns)
    for load, spin, turns in dict.fromkeys(settings):
        yield _with_run(measured, lab.fit, load, spin, turns)
    for change in changes.CHANGES["unloaded_run"](lab):
        assert change.measured is not None
        yield change.measured


def _loads(measured: Measurements, limits: Limits) -> Iterator[_Load]:
    """Yield the loads of the log, or those that the user has."""
    # The weights of the last day are there.
    is_today = measured.day == measured.day[-1]
    is_loaded = measured.torque != 0
    usable = is_today & is_loaded
    first_runs = [runs[0] for runs in measured.by_torque]
    loaded = [run for run in first_runs if usable[run]]
    if not (limits.masses or limits.positions):
        yield from map(_Load, loaded)
        return
    distances = np.abs(measured.position)
    known = np.array([measured.mass[loaded], distances[loaded]])
    masses = limits.masses or known[0].tolist()
    positions = limits.positions or known[1].tolist()
    for size in itertools.product(masses, positions):
        ratios = np.array(size)[:, None] / known
        ln_ratios = np.log(ratios)
        differences = np.abs(ln_ratios)
        distance = differences.sum(axis=0)
        nearest = int(distance.argmin())
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
    torque_like = measured.torque[like]
    torque = torque_like * load.mass * load.position
    fitted_time = fit.fitted_time[like]
    duration = fitted_time - bias
    time = duration * turns / measured.turns[like]
    spin_like = measured.spin[like]
    faster = spin / spin_like
    slower = (torque_like + balance) / (torque + balance)
    values = {
        "mass": measured.mass[like] * load.mass,
        "position": measured.position[like] * load.position,
        "torque": torque,
        "spin": spin,
        "turns": turns,
        "time": time * faster * slower + bias,
    }
    count = len(measured.runs)
    larger = select(measured, [*range(count), like])
    for name, value in values.items():
        getattr(larger, name)[-1] = value
    is_new = {"mass": load.mass != 1, "position": load.position != 1}
    for source in larger.sources:
        is_of_all = source.shared_by.startswith("all runs")
        is_own = not source.shared_by or is_new.get(source.quantity)
        if is_own and not is_of_all:
            source.groups[-1] = source.groups.max() + 1
    runs = *measured.runs, f"planned {count + 1}"
    lines = *measured.lines, 0
    return replace(larger, runs=runs, lines=lines)


RANGES = {role: size.possible for role, size in checks.SIZES.items()}
RANGES["time"] = SHORT, RANGES["time"][1]
"""The readings that `gyro check` does not doubt [SI unit]."""


def _fault(measured: Measurements, run: int = -1) -> str:
    """Name the reading of a run that `gyro check` would doubt; "" if there is none."""
    for role, (low, high) in RANGES.items():
        values = getattr(measured, role)
        size = abs(values[run])
        if 0 < size < low or size > high:
            return role
    return ""


def _left_out(lab: Lab, limits: Limits) -> dict[str, str]:
    """Return an example of the runs that are left out for each doubted reading."""
    labs = {_fault(larger): larger for larger in _larger_labs(lab, limits)}
    examples = {}
    for role, larger in labs.items():
        if role:
            load = load_words(larger, -1)
            rpm = larger.spin[-1] / RPM
            examples[role] = f"{load} at {rpm:.0f} rpm"
    return examples


# --- what remains ---


def _others(lab: Lab) -> tuple[Other, ...]:
    """List what else would reduce u of a lab: the advice of an analysis."""
    gains = changes.gains(lab, "advice", WORTH)
    others = []
    for words, now, then in sorted(gains, key=itemgetter(2)):
        if then < WORTH * now:
            others.append(Other(words, then / 100))
    return tuple(others)
