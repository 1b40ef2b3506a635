"""What a design can tell: the u(I_zz) that readings like these give, by the same posterior as a fit's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrodata.fitting.adjustment import MANY, assume_sense, sample
from gyrodata.fitting.conditions import Problem
from gyrodata.fitting.estimates import FitResult
from gyrodata.fitting.inertia import balance_scale, times_stated
from gyrodata.fitting.posterior import Conditions, integrate
from gyrodata.measurements import Measurements, select
from gyrodata.physics import Floats

_MANY = 1000
"""From so many runs on designs are taken one by one."""


NOTHING = 1e6
"""Width of a balance test that says nothing [N*m]."""


@dataclass(frozen=True)
class Design:
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
    if len(designs) > 1 and problems[0].count > _MANY:
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
    conditions = Conditions(
        unknowns=weight * at.to_unknowns * unit[:, None, :],
        shared=weight * shared,
        left=np.zeros(said.shape),
        ended=np.divide(unknowns, unit, out=np.zeros_like(unknowns), where=unit > 0),
        runs=said.sum(axis=1),
        scatter=np.array([design.scatter for design in designs]),
    )
    first = designs[0]
    # A test that says nothing, where there is none.
    tested = np.array([NOTHING if design.tested is None else design.tested for design in designs]) / lightest
    posterior = integrate(
        conditions,
        np.array([design.balance for design in designs]) / lightest,
        first.stated,
        tested if any(design.tested is not None for design in designs) else None,
    )
    ends = posterior.quantiles(0, slice(1, 4, 2))
    return [float(u) for u in unit[:, 0] * (ends[:, 1] - ends[:, 0]) / 2]


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
