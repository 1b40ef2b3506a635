"""What a design can tell before it is measured: u(I_zz) from what is read and how well, whatever comes out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

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
    tested: float | None
    """Width [N*m] that a balance test gives M0; None without a test, or where the runs contradict it."""
    timing_bias_u: float
    """Prior width of b [s]."""

    @property
    def torque(self) -> Floats:
        """Torque applied in each run [N*m], shape (n,)."""
        return self.problem.torque(self.problem.observed)[0]

    @property
    def imbalance_u(self) -> float:
        """Prior width of M0 [N*m]: as in `fit`."""
        torque = self.torque
        largest = float(np.abs(torque).max())
        if self.tested is not None:
            return max(self.tested, NEGLIGIBLE * largest)
        return largest if torques_differ(torque) else DEFAULT_IMBALANCE_U


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
    believed = measured.imbalance_u is not None and result.contradicted_balance is None
    return Design(
        problem,
        assume_sense(measured, float(np.copysign(1.0, imbalance))),
        np.array([inertia, imbalance, result.timing_bias.value]),
        measured.imbalance_u(inertia) if believed and measured.imbalance_u is not None else None,
        measured.timing_bias_u,
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
    stack, runs = _stacked(problems)
    said = np.arange(stack.count) < np.array([[problem.count] for problem in problems])
    sense = np.array([design.sense[index] for design, index in zip(designs, runs, strict=True)])
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


def _stacked(problems: Sequence[Problem]) -> tuple[Problem, list[Any]]:
    """Lay problems over each other, shared errors aside; one with fewer runs repeats its last. And each one's runs."""
    count = max(problem.count for problem in problems)
    runs = [np.minimum(np.arange(count), problem.count - 1) for problem in problems]

    def laid(arrays: Iterable[Floats]) -> Floats:
        return np.array([array[:, index] for array, index in zip(arrays, runs, strict=True)])

    sizes = laid(problem.absolute for problem in problems), laid(problem.relative for problem in problems)
    stack = problems[0].reread(laid(problem.observed for problem in problems), sizes)
    stack.alone, stack.shared_count = laid(problem.alone for problem in problems), 0
    return stack, runs
