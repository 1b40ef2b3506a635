"""What a design can tell before it is measured: u(I_zz) from what is read and how well, whatever comes out."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrodata.fitting.adjustment import fill_rows, prior_rows, solve_rows
from gyrodata.fitting.conditions import NEGLIGIBLE, Problem
from gyrodata.fitting.inertia import DEFAULT_IMBALANCE_U
from gyrodata.fitting.results import FitResult
from gyrodata.fitting.start import assume_sense, torques_differ
from gyrodata.measurements import Measurements


@dataclass(frozen=True, slots=True)
class Improvement:
    """The same runs, measured better."""

    longer: float = 1.0
    """Factor on every time and its turns [1]."""
    imbalance_u: float | None = None
    """Standard uncertainty to which a balance test tells M0 [N*m]; None: as it is."""
    source: str | None = None
    """Source of error that is made smaller …"""
    factor: float = 0.5
    """… by this factor [1]."""


def expected_u(measured: Measurements, result: FitResult, tilted: bool = False) -> float:
    """Standard uncertainty of I_zz that readings like these give.

    Parameters
    ----------
    measured : Measurements
        n runs; their values matter only as the design that they are.
    result : FitResult
        The unknowns to take for true, from a fit of this lab or one like it.
    tilted : bool
        Use eq. (8).

    Returns
    -------
    float
        [kg*m^2]

    Notes
    -----
    One step of the adjustment, linear at the readings. A balance test counts unless the runs contradict it.
    """
    return expected_with(measured, result, [Improvement()], tilted)[0]


def expected_with(
    measured: Measurements, result: FitResult, improvements: Sequence[Improvement], tilted: bool = False
) -> list[float]:
    """Standard uncertainty of I_zz with each of some improvements; see `expected_u`.

    Parameters
    ----------
    measured, result, tilted
        As for `expected_u`.
    improvements : sequence of Improvement
        One at a time.

    Returns
    -------
    list of float
        [kg*m^2]
    """
    inertia, imbalance, bias = result.inertia.value, result.imbalance.value, result.timing_bias.value
    problem = copy.copy(Problem(measured, tilted))
    count = len(improvements)
    longer = np.array([[better.longer] for better in improvements])
    problem.observed = np.repeat(problem.observed[None], count, axis=0)
    problem.observed[:, 0] = (problem.observed[:, 0] - bias) * longer + bias
    problem.observed[:, 2] *= longer
    width = _imbalance_width(measured, result)
    widths = [width if better.imbalance_u is None else better.imbalance_u for better in improvements]
    scale = np.stack([np.array([inertia, width, measured.timing_bias_u]) for width in widths])
    sense = assume_sense(measured, float(np.copysign(1.0, imbalance)))
    at = problem.linearise(
        np.zeros_like(problem.absolute), np.zeros(problem.shared_count), sense, np.array([inertia, imbalance, bias])
    )
    names = [source.name for source in problem.sources]
    for i, better in enumerate(improvements):
        if better.source in names:
            s = names.index(better.source)
            at.own[i] -= (1 - better.factor**2) * at.alone[i, s] ** 2
            at.slopes[i, s] *= better.factor
    unknowns = 3 + problem.shared_count
    rows = np.repeat(prior_rows(problem.count, unknowns)[None], count, axis=0)
    fill_rows(rows, problem, at, 1.0, scale[:, None, :], np.zeros((count, unknowns)))
    _, factor = solve_rows(rows)
    u = abs(inertia) * np.linalg.norm(np.linalg.inv(factor)[:, 0], axis=-1)
    return [float(value) for value in u]


def _imbalance_width(measured: Measurements, result: FitResult) -> float:
    """Prior width of M0 [N*m] that this design has."""
    largest = float(np.abs(measured.torque).max())
    if measured.imbalance_u is not None and result.contradicted_balance is None:
        return max(measured.imbalance_u(result.inertia.value), NEGLIGIBLE * largest)
    return largest if torques_differ(measured.torque) else DEFAULT_IMBALANCE_U
