"""The Gauss–Helmert adjustment: the unknowns and all the errors of the readings, by least squares together.

Errors that one run has alone are eliminated row by row, shared ones stay as unknowns with their prior, the
conditions are linearised at the *adjusted* readings, and each step is solved by QR: no covariance matrix
of the data is built, no normal equations are formed, and an uncertainty of zero is just a column of zeros.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import cast

import numpy as np

from gyrodata.fitting.conditions import NEGLIGIBLE, Problem
from gyrodata.fitting.start import Start
from gyrodata.physics import Floats


@dataclass(frozen=True)
class Adjusted:
    """Where an adjustment ended, linearised there."""

    problem: Problem
    unknowns: Floats
    """I_zz, M0, b."""
    covariance: Floats
    gain: Floats
    """Derivative of I_zz to the weighted misclosures and to the priors of M0, b and the shared errors."""
    shared: Floats
    slopes: Floats
    """Derivative of each run's condition to each source's error, shape (S, n)."""
    own: Floats
    """Variance of each run's condition from the errors that it has alone, shape (n,)."""
    deviations: Floats
    chi2: float


def adjust(problem: Problem, sense: Floats, start: Start, prior_width: float, bias_u: float, kept: Floats) -> Adjusted:
    """Iterate the Gauss–Helmert adjustment to convergence.

    The unknowns are scaled to order one: I_zz by its start, M0 by its prior width, b by its own. Runs where
    `kept` is 0 have no weight, but what the others say of them is worked out.
    """
    count, shared_count = problem.count, problem.shared_count
    scale = np.array([start.inertia, prior_width, bias_u])
    unknowns = np.array([1.0, start.imbalance / prior_width, 0.0])
    single, shared = np.zeros_like(problem.absolute), np.zeros(shared_count)
    # Below the runs, one row for each prior: M0, b, and the shared errors.
    rows = np.vstack([np.zeros((count, 3 + shared_count)), np.eye(3 + shared_count)[1:]])
    target = np.zeros(len(rows))
    previous = math.inf
    moved = math.inf
    for turn in range(50):
        at = problem.linearise(single, shared, sense, unknowns * scale)
        if moved > 1e-3:
            # Move back onto the conditions after a large step: only there is the derivative of the distance
            # exact, and a common shrinking of I_zz and all torques gains nothing, however far off the runs are.
            # A run without a weight may still be beyond the pole, M0 = 0: it stays where it was read.
            near = np.abs(at.misclosure) < 0.5 * np.abs(at.to_unknowns[:, 0] * unknowns[0] * scale[0])
            single = -at.alone * (near * at.misclosure / at.own)
            at = problem.linearise(single, shared, sense, unknowns * scale)
        plain = np.zeros((count, 3 + shared_count))
        plain[:, :3] = at.to_unknowns * scale
        plain[problem.from_run, 3 + problem.to_column] = at.slopes[problem.from_source, problem.from_run]
        weight = kept / np.sqrt(at.own)
        rows[:count] = plain * weight[:, None]
        target[:count] = -at.misclosure * weight
        target[count:] = -np.concatenate([unknowns[1:], shared])
        q, r = np.linalg.qr(rows)
        step = _damped(np.linalg.solve(r, q.T @ target), unknowns)
        unknowns = unknowns + step[:3]
        shared = shared + step[3:]
        closed = at.misclosure + plain @ step
        # A run that is left out has no weight, but its prediction too is linear only on its condition.
        single = -at.alone * (closed / at.own)
        chi2 = float(np.sum((closed * weight) ** 2) + np.sum(unknowns[1:] ** 2) + np.sum(shared**2))
        moved = float(np.abs(step).max())
        if moved < 1e-11 or (turn > 3 and abs(previous - chi2) <= 1e-13 * chi2):
            break
        previous = chi2
    inverse = np.linalg.inv(r)
    # Deleted residuals: for a run in the fit the leverage takes it out again, for one outside the
    # uncertainty of the prediction is added.
    inside = at.own * np.maximum(1 - np.sum(q[:count] ** 2, axis=1), NEGLIGIBLE)
    outside = at.own + np.sum((plain @ inverse) ** 2, axis=1)
    return Adjusted(
        problem=problem,
        unknowns=unknowns * scale,
        covariance=(inverse @ inverse.T)[:3, :3] * np.outer(scale, scale),
        gain=(inverse[0] @ q.T) * scale[0],
        shared=shared,
        slopes=at.slopes,
        own=at.own,
        deviations=sense * closed / np.sqrt(np.where(kept > 0, inside, outside)),
        chi2=chi2,
    )


def _damped(step: Floats, unknowns: Floats) -> Floats:
    """Shorten a step that would more than halve or double the inertia."""
    limit = 0.5 * abs(unknowns[0])
    return cast(Floats, step * (limit / abs(step[0]))) if abs(step[0]) > limit else step
