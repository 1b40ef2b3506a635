"""How well I_zz is known: its interval by the profile of chi-square, and what a design can tell beforehand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrodata.fitting.adjustment import Adjusted, fill_rows, onto_conditions, prior_rows, solve_rows
from gyrodata.fitting.conditions import NEGLIGIBLE, Problem, torques_differ
from gyrodata.fitting.estimates import FitResult
from gyrodata.fitting.inertia import DEFAULT_IMBALANCE_U, weigh
from gyrodata.fitting.start import assume_sense
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

K_95 = 1.959963984540054
"""Coverage factor of a 95 % interval for infinite degrees of freedom (97.5 % point of the normal)."""

TOLERANCE = 0.05
"""The linear interval stands where each half of it is right to this relative size."""


def profile_interval(result: FitResult, k: float) -> tuple[float, float] | None:
    """Find where chi-square, with all else adjusted, has risen by k² on either side of I_zz [kg*m^2].

    None where value ± k·u is right to 5 % of its half-width, where chi-square never rises so far, or where the answer
    is a mixture of two fits, which has no one profile.
    """
    u = result.inertia.u
    if not u or result.two_signs or "balance_doubt" in {share.source for share in result.budget}:
        return None
    sides = np.array([-1.0, 1.0])
    halves = np.full(2, k * u)
    for turn in range(8):
        ends = result.inertia.value + sides * halves
        if ends[0] <= 0:
            return None
        # Whether the linear interval will do is told by a rough rise already.
        left = 1e-4 if turn else 0.05
        rise = _chi2_at(result.adjusted, result.sense, ends, left) - result.adjusted.chi2
        if not np.all(rise > 0):
            return None
        # Exact for a parabola, and a short way for what is nearly one.
        ratio = k / np.sqrt(rise)
        off = np.abs(ratio - 1).max()
        if not turn and off < TOLERANCE:
            return None
        halves = halves * np.clip(ratio, 0.5, 2.0)
        if off < 1e-4:
            break
    return float(result.inertia.value - halves[0]), float(result.inertia.value + halves[1])


def _chi2_at(adjusted: Adjusted, sense: Floats, inertias: Floats, left: float = 1e-4) -> Floats:
    """Chi-square with I_zz held at each of some values [kg*m^2] and all else adjusted, shape (m,).

    `left` is what the last step, squared, may be of the one before it; chi-square is flat at its minimum, so
    that what is left of a step counts squared.
    """
    problem, scale, kept = adjusted.problem, adjusted.scale, adjusted.kept
    width = 3 + problem.shared_count
    away = (inertias - adjusted.unknowns[0]) / scale[0]
    there = np.concatenate([adjusted.unknowns / np.where(scale > 0, scale, 1.0), adjusted.shared])
    unknowns = there + away[:, None] * adjusted.directions
    # What the errors that each run has alone do on the way there, to first order.
    weighted = adjusted.weighted + away[:, None] * adjusted.gain[: problem.count] * scale[0] / adjusted.covariance[0, 0]
    single = -adjusted.slopes * problem.alone * (weighted / np.sqrt(adjusted.own))[:, None, :]
    # The last row says that I_zz takes no step; its column is empty above.
    rows = np.zeros((len(inertias), problem.count + width, width + 1))
    rows[:, :-1] = prior_rows(problem.count, width)
    rows[:, -1, 0] = 1.0
    moved = np.inf
    for turn in range(30):
        at = problem.linearise(single, unknowns[:, 3:], sense, unknowns[:, :3] * scale)
        if turn:
            single = onto_conditions(at, inertias[:, None])
            at = problem.linearise(single, unknowns[:, 3:], sense, unknowns[:, :3] * scale)
        plain = fill_rows(rows, problem, at, kept, scale, unknowns)
        rows[:, : problem.count, 0] = 0.0
        step, _ = solve_rows(rows)
        unknowns = unknowns + step
        closed = at.misclosure + (plain @ step[..., None])[..., 0]
        single = -at.alone * (closed / at.own)[:, None, :]
        last, moved = moved, float(np.abs(step).max())
        if moved**2 < left * min(last, 1.0):
            break
    squares = kept * closed**2 / at.own
    chi2: Floats = np.add.reduce(squares, axis=-1) + np.add.reduce(unknowns[:, 1:] ** 2, axis=-1)
    return chi2


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
    """Take a lab for a design, and the unknowns of a fit of it, or of one like it, for true."""
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
