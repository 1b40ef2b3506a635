"""The recommended fit of many labs of one design at once: the same adjustment, stacked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gyrodata.fitting.adjustment import fill_rows, prior_rows, solve_rows
from gyrodata.fitting.conditions import NEGLIGIBLE, QUANTITIES, Problem, torques_differ
from gyrodata.fitting.inertia import DEFAULT_IMBALANCE_U
from gyrodata.fitting.start import straight_line
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

STEPS = 8
"""Most Gauss–Newton steps; three are enough for labs that go with their stated uncertainties."""

_CHUNK = 128
"""Labs at a time: as many as stay in a processor's cache."""


@dataclass(frozen=True)
class ManyFits:
    """The unknowns of L labs, each array of shape (L,)."""

    inertia: Floats
    """I_zz [kg*m^2]."""
    inertia_u: Floats
    """Its standard uncertainty [kg*m^2]."""
    imbalance: Floats
    """M0 [N*m]."""
    imbalance_u: Floats
    """[N*m]"""
    timing_bias: Floats
    """b [s]"""


def fit_many(
    measured: Measurements, readings: Mapping[str, Floats], tilted: bool = False, width: float | None = None
) -> ManyFits:
    """Fit L labs of the design, sources and groups of `measured`, in which every run has a known sense.

    The readings are by quantity ("time", "spin", "mass", …), SI, shape (L, n); what is missing is as in `measured`. The
    prior width of M0 [N*m] is the same as in `fit` without a balance test where it is not given. As `fit`, from a start
    by ordinary least squares: good for labs without gross errors, as simulated ones are.
    """
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
    parts = [_fit_stack(problem, observed[i : i + _CHUNK], measured, width) for i in range(0, shape[0], _CHUNK)]
    return ManyFits(*np.concatenate(parts, axis=1))


def _fit_stack(problem: Problem, observed: Floats, measured: Measurements, width: float | None) -> Floats:
    """Adjust one stack of labs; I_zz, u, M0, u(M0) and b in the rows of the answer."""
    problem = problem.reread(observed)
    torque, _ = problem.torque(observed)
    labs = len(observed)
    differ = torques_differ(measured.torque)
    if width is None:
        largest = np.abs(torque).max(axis=1)
        widths = largest if differ else np.full(labs, DEFAULT_IMBALANCE_U)
    else:
        widths = np.full(labs, max(width, NEGLIGIBLE * float(np.abs(measured.torque).max())))
    lever, swing = 2 * np.pi * observed[:, 2] * observed[:, 1], measured.sense * observed[:, 0]
    if differ:
        inertia, imbalance = straight_line(lever, swing, torque)
    else:
        inertia, imbalance = np.median(swing * torque / lever, axis=1), np.zeros(labs)
    scale = np.stack([inertia, widths, np.full(labs, measured.timing_bias_u)], axis=-1)
    unknowns = np.zeros((labs, 3 + problem.shared_count))
    unknowns[:, 0] = 1.0
    unknowns[:, 1] = imbalance / widths
    rows = np.broadcast_to(prior := prior_rows(problem.count, 3 + problem.shared_count), (labs, *prior.shape)).copy()
    single = np.zeros((labs, *problem.absolute.shape))
    moved = 1.0
    for _turn in range(STEPS):
        at = problem.linearise(single, unknowns[:, 3:], measured.sense, unknowns[:, :3] * scale)
        plain = fill_rows(rows, problem, at, 1.0, scale[:, None, :], unknowns)
        step, factor = solve_rows(rows)
        unknowns = unknowns + step
        # Steps shrink ever faster: the next is smaller than this one times this one over the last.
        last, moved = moved, float(np.abs(step).max())
        if moved**2 < 1e-5 * last:
            break
        closed = at.misclosure + (plain @ step[..., None])[..., 0]
        single = -at.alone * (closed / at.own)[:, None, :]
    u = np.linalg.norm(_inverse_rows(factor, 2), axis=-1)
    value = unknowns[:, :3] * scale
    return np.stack([value[:, 0], u[:, 0] * scale[:, 0], value[:, 1], u[:, 1] * scale[:, 1], value[:, 2]])


def _inverse_rows(factor: Floats, count: int) -> Floats:
    """Take the first rows of the inverse of upper triangles, shape (L, count, k), by substitution."""
    width = factor.shape[-1]
    rows = np.zeros((len(factor), count, width))
    rows[:, range(count), range(count)] = 1.0
    for j in range(width):
        rows[:, :, j] -= np.einsum("lci,li->lc", rows[:, :, :j], factor[:, :j, j])
        rows[:, :, j] /= factor[:, j, j, None]
    return rows
