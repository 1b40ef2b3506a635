"""What another hour in the lab would gain: u(I_zz) of this log with runs or statements that it does not have.

The uncertainty of a fit hardly depends on how the readings come out, only on what was read and how well. So each
forecast takes the fitted values for the truth and adds or changes readings; `expected_u` says what they give, by the
same posterior as a fit's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.fitting import (
    MANY,
    Conditions,
    FitResult,
    Problem,
    assume_sense,
    balance_scale,
    integrate,
    sample,
    times_stated,
)
from gyrodata.measurements import Measurements, select
from gyrodata.physics import Floats

WATCHED = 180.0
"""How long [s] a run without a weight is timed."""

DRIFT = (np.radians(5.0), 60.0, 400 * physics.RPM)
"""A balance test that is easily met: 5° [rad] in a minute [s] at 400 rpm [rad/s]."""

ONE_BY_ONE = 1000
"""From so many runs on designs are taken one by one."""


class Design(Struct, frozen=True):
    """What is read in the n runs of a lab, how well, and the answer that is taken for true."""

    problem: Problem
    """Its readings matter only as the design that they are."""
    sense: Floats
    """Sign of φ̇ψ̇ in each run, shape (n,)."""
    unknowns: Floats
    """I_zz [kg*m^2], M0 [N*m] and b [s] taken for true, shape (3,)."""
    scatter: float
    """Factor on the errors that each run has alone [1]."""
    balance: float
    """Scale of M0's Cauchy [N*m], as in `fit`."""
    tested: float | None
    """Width that a balance test gives M0 [N*m]; None without one."""
    timing_bias_u: float
    """Prior width of b [s]."""
    stated: bool
    """Whether the log states how wide the errors of the times are."""

    @property
    def torque(self) -> Floats:
        """Torque applied in each run [N*m], shape (n,)."""
        return self.problem.torque(self.problem.observed)[0]


def design_of(measured: Measurements, result: FitResult, tilted: bool = False) -> Design:
    """Take a lab for a design, and the unknowns of a fit of it, or of one like it, for true.

    Of very many runs a sample stands for all, each for several, where it has all weights and positions that they share.
    """
    count = len(measured.runs)
    if count > MANY:
        some = select(measured, sample(measured, np.ones(count)))
        if all(one.shared_count == all_.shared_count for one, all_ in zip(some.sources, measured.sources, strict=True)):
            measured = some
    problem = Problem(measured, tilted).with_scatter(math.sqrt(len(measured.runs) / count))
    inertia, imbalance = result.inertia.value, result.imbalance.value
    tested = None if measured.imbalance_u is None else measured.imbalance_u(inertia)
    return Design(
        problem,
        sense=assume_sense(measured, float(np.copysign(1.0, imbalance))),
        unknowns=np.array([inertia, imbalance, result.timing_bias.value]),
        scatter=result.scatter,
        balance=balance_scale(measured, inertia),
        tested=tested,
        timing_bias_u=measured.timing_bias_u,
        stated=times_stated(measured),
    )


def expected_u(designs: Sequence[Design]) -> list[float]:
    """Standard uncertainty of I_zz [kg*m^2] that readings like these give.

    The designs are of one lab and of changes to it: the sources are the same, runs and sharing may differ. One step of
    the adjustment, linear at the readings.
    """
    problems = [design.problem for design in designs]
    if len(designs) > 1 and problems[0].count > ONE_BY_ONE:
        # One after the other: where there are many runs a stack saves nothing and takes memory.
        return [u for design in designs for u in expected_u([design])]
    stack = _stacked(problems)
    said = np.arange(stack.count) < np.array([[problem.count] for problem in problems])
    sense = _padded([design.sense for design in designs], stack.count)
    unknowns = np.array([design.unknowns for design in designs])
    at = stack.linearise(np.zeros((len(stack.sources), stack.count)), np.zeros(0), sense, unknowns)
    shared = np.zeros((len(designs), stack.count, max(problem.shared_count for problem in problems)))
    for i, problem in enumerate(problems):
        shared[i, problem.from_run, problem.to_column] = at.slopes[i, problem.from_source, problem.from_run]
    weight = (said / np.sqrt(at.own))[..., None]
    torque = np.abs(stack.torque(stack.observed)[0])
    lightest = np.where(said & (torque > 0), torque, np.inf).min(axis=1)
    unit = np.stack([unknowns[:, 0], lightest, np.array([design.timing_bias_u for design in designs])], axis=-1)
    lean, shares = weight * at.to_unknowns * unit[:, None, :], weight * shared
    ended = np.divide(unknowns, unit, out=np.zeros_like(unknowns), where=unit > 0)
    runs, scatter = said.sum(axis=1), np.array([design.scatter for design in designs])
    scale = np.array([design.balance for design in designs]) / lightest
    u = np.empty(len(designs))
    # A balance test that may be false needs twice as many widths of M0.
    tests = np.array([np.nan if design.tested is None else design.tested for design in designs]) / lightest
    for some in (np.isnan(tests), ~np.isnan(tests)):
        if some.any():
            left = np.zeros((some.sum(), stack.count))
            conditions = Conditions(
                lean[some], shares[some], left, ended[some], runs[some], scatter[some], without_readings=True
            )
            tested = None if np.isnan(tests[some]).any() else tests[some]
            posterior = integrate(conditions, scale[some], designs[0].stated, tested)
            ends = posterior.quantiles(1, slice(1, 4, 2))[..., 0, :]
            u[some] = unit[some, 0] * (ends[:, 1] - ends[:, 0]) / 2
    return [float(one) for one in u]


def _stacked(problems: Sequence[Problem]) -> Problem:
    """Lay problems over each other, shared errors aside."""
    count = max(problem.count for problem in problems)
    stack = problems[0].reread(
        _padded([problem.observed for problem in problems], count),
        (
            _padded([problem.absolute for problem in problems], count),
            _padded([problem.relative for problem in problems], count),
        ),
    )
    stack.alone, stack.shared_count = _padded([problem.alone for problem in problems], count), 0
    return stack


def _padded(arrays: Sequence[Floats], count: int) -> Floats:
    """Stack arrays of up to so many runs; where one has fewer, its last run stands once more."""
    stack = np.empty((len(arrays), *arrays[0].shape[:-1], count))
    for at, array in zip(stack, arrays, strict=True):
        runs = array.shape[-1]
        at[..., :runs], at[..., runs:] = array, array[..., -1:]
    return stack


def with_unloaded_run(design: Design) -> Design:
    """Add a run without a weight, at the middle spin, its sense written down.

    It has its own readings of time, turns and spin, and the errors that all runs share.
    """
    problem, torque = design.problem, design.torque
    inertia, imbalance = design.unknowns[:2]
    # How much is learnt does not depend on how large M0 turns out; but no residual torque has no time.
    floor = 0.005 * np.abs(torque[torque != 0]).min()
    imbalance = np.copysign(max(abs(imbalance), floor), imbalance or 1.0)
    spin = np.sort(problem.observed[1])[problem.count // 2]
    turns = WATCHED * abs(physics.horizontal_precession_rate(imbalance, spin, inertia)) / (2 * np.pi)
    new = np.zeros(len(problem.observed))
    new[:3] = WATCHED, spin, turns
    new[7] = problem.observed[7, 0]
    shared = np.array([source.shared_by.startswith("all runs") for source in problem.sources])
    touched = np.array([source.quantity in ("time", "spin", "turns", "g") for source in problem.sources])
    group = np.where(shared, 0, np.where(touched, problem.groups.max(axis=1) + 1, -1))
    largest = problem.absolute.max(axis=1), problem.relative.max(axis=1)
    longer = problem.reread(
        _one_more(problem.observed, new),
        (_one_more(problem.absolute, largest[0]), _one_more(problem.relative, largest[1])),
        _one_more(problem.groups, group),
    )
    sense = _one_more(design.sense, np.sign(imbalance))
    return replace(design, problem=longer, sense=sense)


def _one_more(values: Any, last: Any) -> Any:
    """Put one more run at the end of the last axis."""
    more = np.empty((*values.shape[:-1], values.shape[-1] + 1), dtype=values.dtype)
    more[..., :-1], more[..., -1] = values, last
    return more


def with_both_signs(design: Design) -> Design:
    """Move the weight to the other side of the ball in every second run of each torque.

    The positions share their errors as before: one ruler, one zero.
    """
    problem = design.problem
    turned = np.zeros(problem.count, dtype=bool)
    for number, group in enumerate(_by_torque(design.torque)):
        turned[group[number % 2 :: 2]] = True
    sign = np.where(turned, -1.0, 1.0)
    torque = sign * design.torque
    inertia, imbalance = design.unknowns[:2]
    observed = problem.observed.copy()
    observed[4] *= sign
    observed[6] *= sign
    rate = np.abs(physics.horizontal_precession_rate(torque + imbalance, observed[1], inertia))
    observed[0] = 2 * np.pi * observed[2] / rate
    # A position on the other side is another reading.
    split = np.array([source.name in ("position", "torque") for source in problem.sources], dtype=bool)
    apart = split[:, None] & (problem.groups >= 0)
    groups = np.where(apart, 2 * problem.groups + turned, problem.groups)
    moved = problem.reread(observed, groups=groups)
    return replace(design, problem=moved, sense=np.sign(torque))


def _by_torque(torque: Floats) -> list[list[int]]:
    groups: dict[str, list[int]] = {}
    for i, value in enumerate(torque.tolist()):
        groups.setdefault(f"{value:.9g}", []).append(i)
    return list(groups.values())


def with_longer_times(design: Design, factor: float) -> Design:
    """Time so many times the turns in every run."""
    bias = design.unknowns[2]
    observed = design.problem.observed.copy()
    observed[0] = (observed[0] - bias) * factor + bias
    observed[2] *= factor
    return replace(design, problem=design.problem.reread(observed))


def with_better(design: Design, source: str) -> Design:
    """Make one source of error half as large."""
    problem = design.problem
    smaller = np.array([0.5 if one.name == source else 1.0 for one in problem.sources])[:, None]
    sizes = problem.absolute * smaller, problem.relative * smaller
    return replace(design, problem=problem.reread(problem.observed, sizes))


def with_balance_test(design: Design) -> Design:
    """Add a balance test in which the ball drifts no more than `DRIFT`."""
    return replace(design, tested=balance_test(float(design.unknowns[0])))


def balance_test(inertia: float) -> float:
    """Standard uncertainty of M0 [N*m] that a balance test leaves where the ball drifts no more than `DRIFT`."""
    angle, seconds, spin = DRIFT
    return float(inertia * spin * angle / seconds)
