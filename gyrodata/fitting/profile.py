"""The 95 % interval of I_zz by the profile of chi-square, where value ± k·u is not good enough."""

from __future__ import annotations

import numpy as np

from gyrodata.fitting.adjustment import Adjusted, fill_rows, onto_conditions, prior_rows, solve_rows
from gyrodata.fitting.results import FitResult
from gyrodata.physics import Floats

TOLERANCE = 0.05
"""The linear interval stands where each half of it is right to this relative size."""


def profile_interval(result: FitResult, k: float) -> tuple[float, float] | None:
    """Find where chi-square, with all else adjusted, has risen by k² on either side of I_zz.

    Parameters
    ----------
    result : FitResult
        Of one log.
    k : float
        Coverage factor of the interval: 1.96 for 95 %.

    Returns
    -------
    tuple of float or None
        Lower and upper end [kg*m^2]; None where value ± k·u is right to 5 % of its half-width, where chi-square
        never rises so far, or where the answer is a mixture of two fits, which has no one profile.
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
