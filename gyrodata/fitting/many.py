"""The recommended fit of many labs of one design at once: the same adjustment, stacked."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from msgspec import Struct

from gyrodata.errors import insist_on_choice, insist_on_type
from gyrodata.fitting.adjustment import fill_rows, prior_rows, solve_rows, straight_line
from gyrodata.fitting.conditions import QUANTITIES, Problem, torques_differ
from gyrodata.fitting.inertia import balance_scale, times_stated
from gyrodata.fitting.posterior import Conditions, integrate
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

STEPS = 8
"""Most Gauss–Newton steps; three are enough for labs that go with their stated uncertainties."""

WIDE = 3.0
"""Width of M0, over the scale of its prior, with which labs are adjusted."""

FACTORS = 0.5, 20.0
"""Bounds of the factor on the errors that each run has alone with which they are."""

_CHUNK = 16
"""Labs at a time: as many as stay in a processor's cache."""


class ManyFits(Struct, frozen=True, eq=False):
    """The unknowns of L labs."""

    inertia: Floats
    """Quantiles of I_zz at 2.5, 15.87, 50, 84.13 and 97.5 % [kg*m^2], shape (L, 5)."""
    imbalance: Floats
    """Mean of M0 [N*m], shape (L,)."""
    timing_bias: Floats
    """Mean of b [s], shape (L,)."""


def fit_many(measured: Measurements, readings: Mapping[str, Floats], tilted: bool = False) -> ManyFits:
    """Fit L labs of one design at once, as `analyze` does one.

    Parameters
    ----------
    measured : Measurements
        The design: n runs, in which every run has a known sense, with their sources of error and what shares them.
    readings : mapping of str to array, shape (L, n)
        Readings of the labs by quantity ("time", "spin", "mass", …) [SI]; what is missing is as in `measured`.
    tilted : bool
        Eq. (8) with each run's pitch, not eq. (9).

    Returns
    -------
    ManyFits

    Raises
    ------
    ValueError
        If a run has no known sense, or the readings are not of L labs of n runs.

    Notes
    -----
    Each lab starts from ordinary least squares: good for labs without gross errors, as simulated ones are.
    """
    insist_on_type("measured", measured, Measurements, "what was measured: lab.measurements")
    insist_on_type("readings", readings, Mapping, "a mapping of quantities to arrays")
    for name in readings:
        insist_on_choice("a name in readings", name, QUANTITIES)
    if not measured.sense.all():
        raise ValueError("a run has no known sense of precession; fit such labs one at a time")
    shapes = {np.shape(values) for values in readings.values()}
    if len(shapes) != 1 or len(shape := next(iter(shapes))) != 2 or shape[1] != len(measured.runs):
        raise ValueError(f"the readings have shapes {shapes}; pass arrays of shape (labs, {len(measured.runs)})")
    problem = Problem(measured, tilted)
    observed = np.empty((shape[0], *problem.observed.shape))
    observed[:] = problem.observed
    for name, values in readings.items():
        observed[:, QUANTITIES.index(name)] = values
    parts = [_fit_stack(problem, observed[i : i + _CHUNK]) for i in range(0, shape[0], _CHUNK)]
    found = np.concatenate(parts)
    return ManyFits(found[:, :5], found[:, 5], found[:, 6])


def _fit_stack(problem: Problem, observed: Floats) -> Floats:
    """Adjust one stack of labs: five quantiles of I_zz, the means of M0 and b, shape (L, 7)."""
    problem, measured = problem.reread(observed), problem.measured
    torque, _ = problem.torque(observed)
    labs, count = len(observed), problem.count
    lightest = np.abs(np.where(measured.torque == 0, np.inf, torque)).min(axis=1)
    lever, swing = 2 * np.pi * observed[:, 2] * observed[:, 1], measured.sense * observed[:, 0]
    if torques_differ(measured.torque):
        inertia, imbalance = straight_line(lever, swing, torque)
    else:
        inertia, imbalance = np.median(swing * torque / lever, axis=1), np.zeros(labs)
    balance = balance_scale(measured, inertia) / lightest
    scale = np.stack([inertia, lightest, np.full(labs, measured.timing_bias_u)], axis=-1)
    unknowns = np.zeros((labs, 3 + problem.shared_count))
    unknowns[:, 0] = 1.0
    unknowns[:, 1] = imbalance / lightest
    rows = np.broadcast_to(prior := prior_rows(count, 3 + problem.shared_count), (labs, *prior.shape)).copy()
    rows[:, count, 1] = 1 / (WIDE * balance)
    single = np.zeros((labs, *problem.absolute.shape))
    factor, moved = np.ones((labs, 1)), np.inf
    for turn in range(STEPS):
        at = problem.linearise(single, unknowns[:, 3:], measured.sense, unknowns[:, :3] * scale)
        plain = fill_rows(rows, problem, at, 1 / factor, scale[:, None, :], unknowns)
        rows[:, count, -1] *= rows[:, count, 1]
        step, _ = solve_rows(rows)
        unknowns = unknowns + step
        closed = at.misclosure + (plain @ step[..., None])[..., 0]
        single = -at.alone * (closed / at.own)[:, None, :]
        if turn == 0:
            # Where the runs scatter more than stated, what they share moves less.
            squares = np.add.reduce(closed**2 / at.own, axis=1, keepdims=True) / max(count - 2, 1)
            factor = np.clip(np.sqrt(squares), *FACTORS)
        # Steps shrink ever faster: the next is smaller than this one times this one over the last.
        last, moved = moved, float(np.abs(step).max())
        if turn and moved**2 < 1e-5 * last:
            break
    rows[:, :count] *= factor[..., None]
    weighted = rows[:, :count, :-1]
    conditions = Conditions(
        unknowns=weighted[..., :3],
        shared=weighted[..., 3:],
        left=closed / np.sqrt(at.own) - (weighted[..., 3:] @ unknowns[:, 3:, None])[..., 0],
        ended=unknowns[:, :3],
        runs=np.full(labs, count),
        scatter=factor[:, 0],
    )
    tested = None
    if measured.imbalance_u is not None:
        tested = np.array([measured.imbalance_u(float(one)) for one in inertia]) / lightest
    posterior = integrate(conditions, balance, times_stated(measured), tested)
    return np.concatenate(
        [posterior.quantiles()[:, 0] * scale[:, :1], posterior.middle()[:, 1:] * scale[:, 1:]], axis=1
    )
