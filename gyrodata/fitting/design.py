"""What a design can tell before it is measured: u(I_zz) from what is read and how well, whatever comes out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrodata.fitting.conditions import NEGLIGIBLE, Problem
from gyrodata.fitting.inertia import DEFAULT_IMBALANCE_U
from gyrodata.fitting.results import FitResult
from gyrodata.fitting.start import assume_sense, torques_differ
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats


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
    tested: bool
    """Whether a balance test gives it: there is one, and the runs do not contradict it."""
    timing_bias_u: float
    """Prior width of b [s]."""

    @property
    def torque(self) -> Floats:
        """Torque applied in each run [N*m], shape (n,)."""
        return self.problem.torque(self.problem.observed)[0]


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
    tested = measured.imbalance_u is not None and result.contradicted_balance is None
    if tested and measured.imbalance_u is not None:
        width = max(measured.imbalance_u(inertia), NEGLIGIBLE * largest)
    else:
        width = largest if torques_differ(measured.torque) else DEFAULT_IMBALANCE_U
    return Design(
        problem,
        sense=assume_sense(measured, float(np.copysign(1.0, imbalance))),
        unknowns=np.array([inertia, imbalance, result.timing_bias.value]),
        imbalance_u=width,
        tested=tested,
        timing_bias_u=measured.timing_bias_u,
    )


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
    One step of the adjustment, linear at the readings. A balance test counts unless the runs contradict it.
    """
    problems = [design.problem for design in designs]
    stack = _stacked(problems)
    said = np.arange(stack.count) < np.array([[problem.count] for problem in problems])
    sense = _padded([design.sense for design in designs], stack.count)
    unknowns = np.array([design.unknowns for design in designs])
    at = stack.linearise(np.zeros((len(stack.sources), stack.count)), np.zeros(0), sense, unknowns)
    width = 3 + max(problem.shared_count for problem in problems)
    rows = np.zeros((len(designs), stack.count + width - 1, width))
    # I_zz comes last: the last pivot then is what the rows tell of it alone.
    rows[:, stack.count :, :-1] = np.eye(width - 1)
    conditions = rows[:, : stack.count]
    widths = np.array([[design.imbalance_u, design.timing_bias_u] for design in designs])
    conditions[..., :2] = at.to_unknowns[..., 1:] * widths[:, None]
    conditions[..., -1] = at.to_unknowns[..., 0]
    for i, problem in enumerate(problems):
        conditions[i, problem.from_run, 2 + problem.to_column] = at.slopes[i, problem.from_source, problem.from_run]
    conditions *= (said / np.sqrt(at.own))[..., None]
    packed, _ = np.linalg.qr(rows, mode="raw")
    u: list[float] = (1 / np.abs(packed[:, -1, width - 1])).tolist()
    return u


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
