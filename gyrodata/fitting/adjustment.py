"""The Gauss–Helmert adjustment: the unknowns and all the errors of the readings, by least squares together.

It starts from an answer that up to half of the runs may be wrong about. Errors that one run has alone are eliminated
row by row, shared ones stay as unknowns with their prior, the conditions are linearised at the *adjusted* readings, and
each step is solved by QR: no covariance matrix of the data is built, no normal equations are formed, and an uncertainty
of zero is just a column of zeros. Where it ends has to be an answer that can be believed.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, cast

import numpy as np
from msgspec import Struct

from gyrodata.fitting.conditions import (
    MAD_TO_SD,
    NEGLIGIBLE,
    QUANTITIES,
    Linear,
    Problem,
    rough_inertia,
    torques_differ,
)
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats


class NoFit(Exception):  # noqa: N818 - like StopIteration, what came of it and not a fault
    """The runs have no answer that can be believed; its text says why, for a student."""


class Start(Struct, frozen=True):
    """Rough values of the unknowns."""

    inertia: float
    """[kg*m^2]"""
    residual_torque: float
    """M0 [N*m]"""


_GOLDEN = (math.sqrt(5) - 1) / 2
"""Golden ratio [1]: its multiples have no period."""

_SAMPLE = 150
"""So many runs are enough to start from."""

_ODD = 5.0
"""Misfit from which on a run is odd, and one that is further off no worse."""


def first_guess(measured: Measurements, sense: Floats, kept: Floats) -> Start:
    """Fit the straight line; where a run is far from it, take the robust start."""
    index = sample(measured, kept)
    if torques_differ(measured.torque[index]):
        lever, swing = _lever(measured, index), sense[index] * measured.time[index]
        inertia, imbalance = straight_line(lever, swing, measured.torque[index])
        total = np.abs(measured.torque[index] + imbalance)
        if 0 < inertia < np.inf and total.all() and rough_misfit(measured, inertia * lever / total, index).max() < 5:
            return Start(float(inertia), float(imbalance))
    return robust_start(measured, sense, kept)


def sample(measured: Measurements, kept: Floats) -> Any:
    """Indices of the runs kept, of very many 150: every torque in its share, and mixed among its runs.

    An even stride through the log would meet one torque only where the weights come round with the same period; the
    multiples of the golden ratio lie evenly in every part of it.
    """
    index = np.flatnonzero(kept > 0)
    if len(index) <= _SAMPLE:
        return index
    mixed = index[np.argsort(np.arange(len(index)) * _GOLDEN % 1.0)]
    by_torque = mixed[np.argsort(measured.torque[mixed], kind="stable")]
    return np.sort(by_torque[np.linspace(0, len(index) - 1, _SAMPLE).round().astype(int)])


def _lever(measured: Measurements, index: Any) -> Floats:
    return cast(Floats, 2 * np.pi * measured.turns[index] * measured.spin[index])


def straight_line(lever: Floats, swing: Floats, torque: Floats) -> tuple[Floats, Floats]:
    """Give I_zz and M0 by least squares of s M T on the lever 2π f ψ̇ and the swing s T, for labs of shape (…, n)."""
    # A clock's error weighs as much as the torque it is multiplied by.
    size = np.abs(torque)
    weight = 1 / np.maximum(size, 0.1 * size.max(axis=-1, keepdims=True))
    lever, swing = lever * weight, swing * weight
    effort = swing * torque
    aa, ab, bb = (np.add.reduce(product, axis=-1) for product in (lever * lever, lever * swing, swing * swing))
    ae, be = np.add.reduce(lever * effort, axis=-1), np.add.reduce(swing * effort, axis=-1)
    determinant = aa * bb - ab * ab
    # Runs that are all alike have no line.
    with np.errstate(divide="ignore", invalid="ignore"):
        return (ae * bb - be * ab) / determinant, (ae * ab - be * aa) / determinant


def robust_start(measured: Measurements, sense: Floats, kept: Floats) -> Start:
    """Solve many pairs of runs for (I_zz, M0) and take the pair that most runs agree with.

    With b = 0 and a horizontal rod the condition is linear: s M T = I_zz 2π f ψ̇ − M0 s T.
    """
    index = sample(measured, kept)
    if not torques_differ(measured.torque[index]):
        return Start(rough_inertia(measured), 0.0)
    lever, swing = _lever(measured, index), sense[index] * measured.time[index]
    effort = swing * measured.torque[index]
    first, second = _pairs(len(index))
    # Two runs: lever·I − swing·M0 = effort for each.
    determinant = lever[second] * swing[first] - lever[first] * swing[second]
    usable = np.abs(determinant) > 1e-3 * np.abs(lever[first] * swing[second])
    first, second, determinant = first[usable], second[usable], determinant[usable]
    inertia = (effort[second] * swing[first] - effort[first] * swing[second]) / determinant
    imbalance = (lever[first] * effort[second] - lever[second] * effort[first]) / determinant
    largest = np.abs(measured.torque[index]).max()
    plausible = (inertia > 0) & (np.abs(imbalance) < 3 * largest)
    if not plausible.any():
        return Start(rough_inertia(measured), 0.0)
    inertia, imbalance = inertia[plausible], imbalance[plausible]
    total = np.maximum(np.abs(measured.torque[index] + imbalance[:, None]), 1e-3 * largest)
    off = rough_misfit(measured, inertia[:, None] * lever / total, index)
    # In units of the scatter about the best pair a run counts at most as much as one that is just odd, so that the
    # fewest odd runs win; of equals the pair with the smaller M0.
    middle = np.partition(off, len(index) // 2, axis=1)[:, len(index) // 2]
    scatter = max(1.0, MAD_TO_SD * float(middle.min()))
    loads = np.abs(measured.torque[measured.torque != 0])
    cost = np.sum(np.minimum(off / scatter, _ODD) ** 2, axis=1) + (imbalance / loads.min()) ** 2
    best = int(np.argmin(cost))
    return Start(float(inertia[best]), float(imbalance[best]))


@lru_cache(maxsize=32)
def _pairs(count: int) -> tuple[Any, Any]:
    """Pick pairs of runs, all of them or about 80 spread evenly."""
    first, second = np.triu_indices(count, 1)
    step = len(first) // 80 + 1
    return first[::step], second[::step]


def misfit(measured: Measurements, start: Start, kept: Floats) -> float:
    """Root mean square of the kept runs' misfits to a start, in units of the clock's uncertainty and 1 %."""
    index = np.flatnonzero(kept > 0)
    total = np.abs(measured.torque[index] + start.residual_torque)
    with np.errstate(divide="ignore"):
        off = rough_misfit(measured, start.inertia * _lever(measured, index) / total, index)
    return float(np.sqrt(np.mean(off**2)))


def rough_misfit(measured: Measurements, predicted: Floats, index: Any = slice(None)) -> Floats:
    """Time against prediction, in units of the clock's uncertainty and 1 %: a rough scale for rough answers."""
    time = measured.time[index]
    bounded = np.where(np.isfinite(predicted), predicted, time)
    return cast(Floats, np.abs(time - bounded) / np.hypot(_time_u(measured)[index], 0.01 * bounded))


def _time_u(measured: Measurements) -> Floats:
    for source in measured.sources:
        if source.quantity == "time":
            return source.absolute + source.relative * measured.time
    return np.zeros(len(measured.runs))


def assume_sense(measured: Measurements, imbalance_sign: float) -> Floats:
    """Sense of each run; a run without a weight turns the way of the residual torque."""
    return cast(Floats, np.where(measured.sense == 0, imbalance_sign, measured.sense))


MAX_ITERATIONS = 100
"""If the steps have not converged after so many, they never will."""

LOST = 1e-3
"""An I_zz below this share of its start, or above its inverse, never comes back."""

FULL_STEPS = 20
"""So many steps are full ones; hardly any log needs half as many."""


class Adjusted(Struct, frozen=True):
    """The end of an adjustment, linearised there."""

    problem: Problem
    unknowns: Floats
    """I_zz [kg*m^2], M0 [N*m] and b [s], shape (3,)."""
    covariance: Floats
    """Of the unknowns, shape (3, 3)."""
    gain: Floats
    """Derivative of I_zz to the weighted misclosures and to the priors of M0, b and the shared errors."""
    shared: Floats
    """The K shared errors, in their standard uncertainties, shape (K,)."""
    slopes: Floats
    """Derivative of each run's condition to each source's error, shape (S, n)."""
    scale: Floats
    """Units of the unknowns in the steps: a start, and the widths of the priors, shape (3,)."""
    rows: Floats
    """Derivatives of the runs' conditions to all unknowns, over their standard uncertainties, shape (n, 3 + K)."""
    kept: Floats
    """1 for a run that is used, 0 for one that is left out, shape (n,)."""
    weighted: Floats
    """Misclosure of each run at the end over its standard uncertainty, 0 for a run that is left out, shape (n,)."""
    independent_variance: Floats
    """Variance of each run's condition from the errors that only this run has, shape (n,)."""
    deviations: Floats
    """Time minus what the other runs predict, over the standard uncertainty of that difference, shape (n,)."""
    influence: Floats
    """Change of I_zz if a run is left out, to first order (DFBETA) [kg*m^2], shape (n,)."""
    chi2: float
    converged: bool
    """Whether the steps converged; if not, this is not a solution."""


def adjust(
    problem: Problem,
    sense: Floats,
    start: Start,
    prior_width: float,
    kept: Floats,
    factor: float,
    near: Adjusted | None = None,
) -> Adjusted:
    """Iterate the Gauss–Helmert adjustment to a solution that can be believed, near its start by a factor.

    The unknowns are scaled to order one: I_zz by its start, M0 by its prior width, b by its own. Runs with a `kept` of
    0 have no weight, but what the others predict for them is computed. `near` is the end of a fit of nearly the same
    runs: the errors begin there. Raises `NoFit`.
    """
    scale = np.array([start.inertia, prior_width, problem.measured.timing_bias_u])
    unknowns = np.zeros(3 + problem.shared_count)
    unknowns[:2] = 1.0, start.residual_torque / prior_width
    single = np.zeros_like(problem.absolute)
    if near is not None and np.array_equal(near.problem.groups, problem.groups):
        unknowns[2:] = near.unknowns[2] / scale[2] if scale[2] else 0.0, *near.shared
        single = -near.slopes * problem.independent * near.weighted / np.sqrt(near.independent_variance)
    try:
        adjusted = _iterate(problem, sense, kept, scale, unknowns, single)
    except np.linalg.LinAlgError:
        raise NoFit("the runs do not tell the unknowns apart") from None
    insist_on_solution(adjusted, start.inertia, factor)
    return adjusted


# A value that is not finite is refused afterwards.
@np.errstate(all="ignore")
def _iterate(
    problem: Problem, sense: Floats, kept: Floats, scale: Floats, unknowns: Floats, single: Floats
) -> Adjusted:
    """Repeat the linearised least squares until the steps converge."""
    count, width = problem.count, len(unknowns)
    # n runs, one row for the prior of each unknown but I_zz; the last column is the target.
    rows = np.zeros((count + width - 1, width + 1))
    rows[count:, 1:width] = np.eye(width - 1)
    chi2 = moved = math.inf
    jumped, converged = 0.0, False
    for turn in range(MAX_ITERATIONS):
        at = problem.linearise(single, unknowns[3:], sense, unknowns[:3] * scale)
        if turn >= FULL_STEPS or jumped > 0.03:
            single = _onto_conditions(at, unknowns[0] * scale[0])
            at = problem.linearise(single, unknowns[3:], sense, unknowns[:3] * scale)
        plain = np.zeros((count, width))
        plain[:, :3] = at.to_unknowns * scale
        plain[problem.from_run, 3 + problem.to_column] = at.slopes[problem.from_source, problem.from_run]
        weight = kept / np.sqrt(at.independent_variance)
        rows[:count, :-1] = plain * weight[:, None]
        rows[:count, -1] = -at.misclosure * weight
        rows[count:, -1] = -unknowns[1:]
        step, factor = _solve(rows)
        # No step more than halves or doubles I_zz.
        limit, size = 0.5 * abs(unknowns[0]), abs(step[0])
        if size > limit:
            step *= limit / size
        if turn >= FULL_STEPS:
            # Full steps can go round in a circle if errors are as large as the readings: go ever less far.
            step *= 0.5 ** (turn // FULL_STEPS)
        unknowns = unknowns + step
        closed = at.misclosure + plain @ step
        # A run that is left out has no weight, but its prediction too is linear only on its condition.
        single = -at.independent * (closed / at.independent_variance)
        before, chi2 = chi2, _chi2(closed, at.independent_variance, kept, unknowns)
        if not LOST < unknowns[0] < 1 / LOST:
            break
        last, moved = moved, float(np.maximum.reduce(np.abs(step)))
        jumped = float(np.maximum.reduce(np.abs(step[:2])))
        # Steps shrink by a constant factor: the next would be this one times this one over the last.
        converged = moved < 1e-11 or moved * moved < 1e-8 * min(last, 1.0 if turn else 0.0)
        converged |= turn > 3 and abs(before - chi2) <= 1e-13 * chi2
        if converged:
            break
    # Covariance, deleted residuals and influence at the end.
    inverse = np.linalg.inv(factor)
    q = rows[:, :-1] @ inverse
    # For a run in the fit its leverage is removed; for one outside, the variance of its prediction is added.
    rest = np.maximum(1 - np.add.reduce(q[:count] ** 2, axis=1), NEGLIGIBLE)
    own = at.independent_variance
    variance = np.where(kept > 0, own * rest, own + np.add.reduce((plain @ inverse) ** 2, axis=1))
    gain = q @ inverse[0] * scale[0]
    weighted = kept * closed / np.sqrt(own)
    return Adjusted(
        problem=problem,
        unknowns=unknowns[:3] * scale,
        covariance=inverse[:3] @ inverse[:3].T * np.outer(scale, scale),
        gain=gain,
        shared=unknowns[3:],
        slopes=at.slopes,
        scale=scale,
        rows=rows[:count, :-1],
        kept=kept,
        weighted=weighted,
        independent_variance=own,
        deviations=sense * closed / np.sqrt(variance),
        influence=gain[:count] * weighted / rest,
        chi2=chi2,
        converged=bool(converged),
    )


def _chi2(closed: Floats, own: Floats, kept: Floats, unknowns: Floats) -> float:
    """Sum of the squares of the runs' errors and of the priors'."""
    return float(np.add.reduce(kept * closed * closed / own) + np.add.reduce(unknowns[1:] ** 2))


def _solve(rows: Floats) -> tuple[Floats, Floats]:
    """Least squares of rows whose last column is the target: solution (k,), and triangular factor of the rest."""
    # The factor with the target beside it contains Qᵀ·target, so that Q itself is never formed.
    packed, _ = np.linalg.qr(rows, mode="raw")
    width = rows.shape[1] - 1
    whole = packed.T[:width]
    # Below it the packed form keeps the reflections.
    factor = whole[:, :-1] * _upper(width)
    return np.linalg.solve(factor, whole[:, -1]), factor


@lru_cache(maxsize=32)
def _upper(width: int) -> Floats:
    """Ones on and above the diagonal."""
    return np.triu(np.ones((width, width)))


def _onto_conditions(at: Linear, inertia: float) -> Floats:
    """Errors that only one run has, moved back onto its condition; for use after a large step, shape (S, n).

    Only there is the derivative of the distance exact, and a common shrinking of I_zz and all torques gains
    nothing, however far off the runs are. A run without a weight may still be beyond the pole, M0 = 0: it
    stays at its reading.
    """
    near = np.abs(at.misclosure) < 0.5 * np.abs(at.to_unknowns[:, 0] * inertia)
    moved: Floats = -at.independent * (near * at.misclosure / at.independent_variance)
    return moved


FACTOR = 3.0
"""No answer is further than this from both lines of the textbook."""

ASTRAY = 30.0
"""No fit ends further than this from where a robust start has put it."""

MOVED = 0.2
"""A shared reading that had to be moved by more than this share of itself …"""

MOVED_U = 3.0
"""… and by more than so many of its standard uncertainties was not what was read."""

MEASURED = np.array([quantity not in ("pitch", "transverse", "turns") for quantity in QUANTITIES])
"""Of each quantity: a pitch of 0 may well be off by more than itself, and I and what it does are guesses."""


def insist_on_solution(adjusted: Adjusted, start: float, factor: float) -> None:
    """Accept where an adjustment ended, near its start [kg*m^2] by a factor, or raise `NoFit`.

    Errors in proportion to what is read let I_zz, all torques and M0 shrink together at little cost, where nothing else
    holds their common scale. So a solution has to come to rest, to be positive, and to stay where the readings are; and
    the lines of the textbook, which know nothing of all this, have to lie within a factor of 3 (`insist_on_lines`).
    """
    inertia = float(adjusted.unknowns[0])
    if not (np.isfinite(adjusted.unknowns).all() and np.isfinite(adjusted.covariance).all()):
        raise NoFit("the fit ends in numbers that are not finite")
    if not adjusted.converged:
        raise NoFit("the fit does not come to rest")
    if not inertia > 0:
        raise NoFit("the fit gives a moment of inertia that is not positive")
    if not 1 / factor < inertia / start < factor:
        raise NoFit(f"the fit ends at {inertia:.2g} kg*m^2, where the runs by themselves are near {start:.2g}")
    problem = adjusted.problem
    if not (np.abs(adjusted.shared) > MOVED_U).any():
        return
    error = np.abs(adjusted.shared[problem.to_column])
    source, run = problem.from_source, problem.from_run
    read = np.abs(problem.observed[problem.quantity[source], run])
    size = problem.absolute[source, run] + problem.relative[source, run] * read
    far = MEASURED[problem.quantity[source]] & (adjusted.kept[run] > 0)
    far &= (error > MOVED_U) & (error * size > MOVED * read)
    if far.any():
        worst = int(np.argmax(far * error * size / np.maximum(read, 1e-300)))
        moved = problem.sources[source[worst]].name.replace("_", " ")
        raise NoFit(f"the fit holds only if what was read as {moved} is off by more than {100 * MOVED:.0f} %")
