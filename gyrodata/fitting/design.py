"""What a design can tell before it is measured: u(I_zz) from what is read and how well, whatever comes out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrodata.fitting.balance import weigh
from gyrodata.fitting.conditions import NEGLIGIBLE, Problem
from gyrodata.fitting.inertia import DEFAULT_IMBALANCE_U
from gyrodata.fitting.results import FitResult
from gyrodata.fitting.start import assume_sense, torques_differ
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

_MANY = 1000
"""From so many runs on designs are taken one by one."""


@dataclass(frozen=True)
class Design:
    """What is read in the n runs of a lab, how well, and the answer that is taken for true."""

    problem: Problem
    """Its readings matter only as the design that they are."""
    sense: Floats
    """Sign of φ̇ψ̇ in each run, shape (n,)."""
    unknowns: Floats
    """I_zz [kg*m^2], M0 [N*m] and b [s] taken for true, shape (3,)."""
    imbalance_u: float
    """Prior width of M0 [N*m], as in `fit`."""
    tested: float | None
    """Width that a balance test gives M0 [N*m]; where it is less than the other it is weighed as `fit` does."""
    timing_bias_u: float
    """Prior width of b [s]."""

    @property
    def torque(self) -> Floats:
        """Torque applied in each run [N*m], shape (n,)."""
        return self.problem.torque(self.problem.observed)[0]

    def with_balance_test(self, tested: float) -> Design:
        """Add a balance test of a width [N*m]; where all torques are equal it is the prior of M0."""
        width = self.imbalance_u if torques_differ(self.torque) else tested
        return replace(self, imbalance_u=width, tested=tested)


def design_of(measured: Measurements, result: FitResult, tilted: bool = False) -> Design:
    """Take a lab for a design.

    Parameters
    ----------
    measured : Measurements
        n runs.
    result : FitResult
        The unknowns to take for true, from a fit of this lab or one like it.
    tilted : bool
        Use eq. (8).

    Returns
    -------
    Design
    """
    problem = result.adjusted.problem
    if problem.measured is not measured or problem.tilted != tilted:
        problem = Problem(measured, tilted)
    inertia, imbalance = result.inertia.value, result.imbalance.value
    largest = float(np.abs(measured.torque).max())
    design = Design(
        problem,
        sense=assume_sense(measured, float(np.copysign(1.0, imbalance))),
        unknowns=np.array([inertia, imbalance, result.timing_bias.value]),
        imbalance_u=largest if torques_differ(measured.torque) else DEFAULT_IMBALANCE_U,
        tested=None,
        timing_bias_u=measured.timing_bias_u,
    )
    if measured.imbalance_u is None:
        return design
    return design.with_balance_test(max(measured.imbalance_u(inertia), NEGLIGIBLE * largest))


def expected_u(designs: Sequence[Design]) -> list[float]:
    """Standard uncertainty of I_zz that readings like these give.

    Parameters
    ----------
    designs : sequence of Design
        Of one lab, and of changes to it: the sources of error are the same, runs and sharing may differ.

    Returns
    -------
    list of float
        [kg*m^2]

    Notes
    -----
    One step of the adjustment, linear at the readings.
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
    width = 3 + max(problem.shared_count for problem in problems)
    rows = np.zeros((len(designs), stack.count + width - 1, width))
    # M0 and I_zz come last: the last pivots then are what the rows tell of these two alone.
    rows[:, stack.count :, :-1] = np.eye(width - 1)
    conditions = rows[:, : stack.count]
    widths = np.array([[design.timing_bias_u, design.imbalance_u] for design in designs])
    conditions[..., 0] = at.to_unknowns[..., 2] * widths[:, :1]
    conditions[..., -2] = at.to_unknowns[..., 1] * widths[:, 1:]
    conditions[..., -1] = at.to_unknowns[..., 0]
    for i, problem in enumerate(problems):
        conditions[i, problem.from_run, 1 + problem.to_column] = at.slopes[i, problem.from_source, problem.from_run]
    conditions *= (said / np.sqrt(at.own))[..., None]
    packed, _ = np.linalg.qr(rows, mode="raw")
    # Numpy gives the triangle lying on its side.
    pivots = packed[:, -2:, width - 2 : width].swapaxes(1, 2)
    return [_u_of_inertia(design, pivot) for design, pivot in zip(designs, pivots, strict=True)]


def _u_of_inertia(design: Design, pivot: Floats) -> float:
    """Standard uncertainty of I_zz from the triangle of M0, in units of its width, and I_zz, shape (2, 2)."""
    imbalance, both, inertia = float(pivot[0, 0]), float(pivot[0, 1]), float(pivot[1, 1])
    if design.tested is None or design.tested >= design.imbalance_u:
        return 1 / abs(inertia)
    width = design.imbalance_u / imbalance
    inverse = np.array([[1 / inertia, 0.0], [-width * both / inertia, width]])
    weighed = weigh(design.unknowns[:2], inverse @ inverse.T, design.tested)
    return math.sqrt(weighed.covariance[0, 0])


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
