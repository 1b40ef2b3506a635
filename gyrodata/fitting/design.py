"""What a design can tell before it is measured: u(I_zz) from what is read and how well, whatever comes out."""

from __future__ import annotations

import numpy as np

from gyrodata.fitting.adjustment import fill_rows, prior_rows, solve_rows
from gyrodata.fitting.conditions import NEGLIGIBLE, Problem
from gyrodata.fitting.inertia import DEFAULT_IMBALANCE_U
from gyrodata.fitting.results import FitResult
from gyrodata.fitting.start import assume_sense, torques_differ
from gyrodata.measurements import Measurements


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
    inertia, imbalance, bias = result.inertia.value, result.imbalance.value, result.timing_bias.value
    largest = float(np.abs(measured.torque).max())
    width = largest if torques_differ(measured.torque) else DEFAULT_IMBALANCE_U
    if measured.imbalance_u is not None and result.contradicted_balance is None:
        width = max(measured.imbalance_u(inertia), NEGLIGIBLE * largest)
    problem = Problem(measured, tilted)
    scale = np.array([inertia, width, measured.timing_bias_u])
    sense = assume_sense(measured, float(np.copysign(1.0, imbalance)))
    at = problem.linearise(
        np.zeros_like(problem.absolute), np.zeros(problem.shared_count), sense, np.array([inertia, imbalance, bias])
    )
    rows = prior_rows(problem.count, 3 + problem.shared_count)
    fill_rows(rows, problem, at, 1.0, scale, np.zeros(3 + problem.shared_count))
    _, factor = solve_rows(rows)
    return abs(inertia) * float(np.linalg.norm(np.linalg.inv(factor)[0]))
