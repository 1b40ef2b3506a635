"""The Gauss–Helmert adjustment: the unknowns and all the errors of the readings, by least squares together.

It starts from an answer that up to half of the runs may be wrong about. Errors that one run has alone are eliminated
row by row, shared ones stay as unknowns with their prior, the conditions are linearised at the *adjusted* readings, and
each step is solved by QR: no covariance matrix of the data is built, no normal equations are formed, and an uncertainty
of zero is just a column of zeros. Where it ends has to be an answer that can be believed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
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
    stack,
    torques_differ,
)
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats
from gyrodata.stacks import stacked


class NoFit(Exception):  # noqa: N818 - like StopIteration, what came of it and not a fault
    """The runs have no answer that can be believed; its text says why, for a student."""


class Start(Struct, frozen=True):
    """Rough values of the unknowns."""

    inertia: float
    """[kg*m^2]"""
    imbalance: float
    """[N*m]"""


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
    total = np.abs(measured.torque[index] + start.imbalance)
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


TURNS = 100
"""What has not come to rest after so many steps never will."""

LOST = 1e-3
"""An I_zz smaller than this share of its start never comes back, nor does one as much larger."""

WHOLE = 20
"""So many steps are whole ones; hardly any log needs half as many."""


class Adjusted(Struct, frozen=True):
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
    scale: Floats
    """What the unknowns I_zz, M0 and b are counted in: a start, and the widths of the priors, shape (3,)."""
    directions: Floats
    """Covariance of all unknowns with I_zz over its variance, as the steps count them, shape (3 + K,)."""
    rows: Floats
    """Derivatives of the runs' conditions to all unknowns, over their standard uncertainties, shape (n, 3 + K)."""
    orthogonal: Floats
    """Weighted derivatives of the runs' conditions on an orthonormal basis, shape (n, 3 + K)."""
    kept: Floats
    """1 for a run with a say, 0 for one that is left out, shape (n,)."""
    weighted: Floats
    """Misclosure of each run at the fit over its standard uncertainty, 0 where left out, shape (n,)."""
    own: Floats
    """Variance of each run's condition from the errors that it has alone, shape (n,)."""
    deviations: Floats
    influence: Floats
    """Change of I_zz when a run is left out [kg*m^2], shape (n,)."""
    chi2: float
    converged: bool
    """Whether the steps came to rest; what did not is no solution."""

    def without(self, groups: Sequence[Sequence[int]]) -> list[tuple[float, float] | None]:
        """Change of I_zz [kg*m^2] and of its variance [kg²*m⁴] when each of some groups of runs is left out.

        To first order; None for a group without runs, and where the others tell so little of it that first order
        is no guide.
        """
        changes: list[tuple[float, float] | None] = [None] * len(groups)
        for size in {len(group) for group in groups} - {0}:
            alike = [at for at, group in enumerate(groups) if len(group) == size]
            index = np.array([groups[at] for at in alike])
            orthogonal, gain = self.orthogonal[index], self.gain[index]
            turned = orthogonal.swapaxes(1, 2)
            # I − QQᵀ of the runs and I − QᵀQ of the unknowns have the same least eigenvalue: take the smaller one.
            many = size > orthogonal.shape[2]
            remaining = np.eye(min(size, orthogonal.shape[2])) - (turned @ orthogonal if many else orthogonal @ turned)
            told = np.linalg.eigvalsh(remaining)[:, 0] > 1e-4
            # What the others say of these runs takes the runs' own share out again.
            own = np.stack([self.weighted[index], gain], axis=-1)[told]
            if many:
                pull = own + orthogonal[told] @ np.linalg.solve(remaining[told], turned[told] @ own)
            else:
                pull = np.linalg.solve(remaining[told], own)
            moved = (gain[told, None] @ pull)[:, 0].tolist()
            for at, change in zip(np.array(alike)[told].tolist(), moved, strict=True):
                changes[at] = change[0], change[1]
        return changes


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

    The unknowns are scaled to order one: I_zz by its start, M0 by its prior width, b by its own. Runs where
    `kept` is 0 have no weight, but what the others say of them is worked out. Raises `NoFit`. `near` is where a fit of
    nearly the same ended: the errors begin there.
    """
    scale = np.array([start.inertia, prior_width, problem.measured.timing_bias_u])
    unknowns = np.zeros(3 + problem.shared_count)
    unknowns[:2] = 1.0, start.imbalance / prior_width
    if near is not None and np.array_equal(near.problem.groups, problem.groups):
        unknowns[2:] = near.unknowns[2] / scale[2] if scale[2] else 0.0, *near.shared
        single = -near.slopes * problem.alone * near.weighted / np.sqrt(near.own)
    else:
        single = np.zeros_like(problem.absolute)
    try:
        adjusted = _iterate(problem, sense, kept, scale, unknowns, single)
    except np.linalg.LinAlgError:
        raise NoFit("the runs do not tell the unknowns apart") from None
    insist_on_solution(adjusted, start.inertia, factor)
    return adjusted


@stacked(lambda problem, *_: problem.kind)
# What is not finite does not pass.
@np.errstate(all="ignore")
def _iterate(calls: Sequence[tuple[Problem, Floats, Floats, Floats, Floats, Floats]]) -> list[Adjusted]:
    """Go on from where each of L logs begins until it comes to rest, or never will; each stops by itself."""
    problems = [problem for problem, *_ in calls]
    problem = stack(problems)
    sense, kept, scale, unknowns, single = (np.array(each) for each in list(zip(*calls, strict=True))[1:])
    labs, width = unknowns.shape
    prior = prior_rows(problem.count, width)
    rows = np.empty((labs, *prior.shape))
    rows[:] = prior
    ended: list[tuple[Any, ...]] = []
    # Of those that still move: which they are, and how far they went.
    moving = np.arange(labs)
    chi2 = moved = np.full(labs, np.inf)
    jumped = np.zeros(labs)
    for turn in range(TURNS):
        at = problem.linearise(single, unknowns[:, 3:], sense, unknowns[:, :3] * scale)
        far = jumped > 0.03 if turn < WHOLE else np.ones(len(moving), dtype=bool)
        if far.any():
            onto = onto_conditions(at, unknowns[:, :1] * scale[:, :1])
            single = np.where(far[:, None, None], onto, single)
            at = problem.linearise(single, unknowns[:, 3:], sense, unknowns[:, :3] * scale)
        plain = fill_rows(rows, problem, at, kept, scale[:, None], unknowns)
        solution, triangle = solve_rows(rows)
        step = _damped(solution, unknowns)
        if turn >= WHOLE:
            # Whole steps go round in a circle where errors are as large as what is read: go ever less far.
            step *= 0.5 ** (turn // WHOLE)
        unknowns = unknowns + step
        closed = at.misclosure + (plain @ step[..., None])[..., 0]
        # A run that is left out has no weight, but its prediction too is linear only on its condition.
        single = -at.alone * (closed / at.own)[:, None]
        lost = ~((unknowns[:, 0] > LOST) & (unknowns[:, 0] < 1 / LOST))
        sizes = np.abs(step)
        last, moved, jumped = moved, np.maximum.reduce(sizes, axis=1), np.maximum(sizes[:, 0], sizes[:, 1])
        # Steps shrink by a constant factor: the next would be this one times this one over the last.
        resting = (moved < 1e-11) | (moved * moved < 1e-8 * np.minimum(last, 1.0 if turn else 0.0))
        if turn > 2:
            before, chi2 = chi2, _chi2(closed, at.own, kept, unknowns)
            resting |= np.abs(before - chi2) <= 1e-13 * chi2
        stops = lost | resting | (turn == TURNS - 1)
        if not stops.any():
            continue
        told = moving, resting & ~lost, at.slopes, at.own, rows, triangle, plain, closed, sense, kept, unknowns, scale
        ended.append(tuple(each[stops] for each in told))
        if stops.all():
            break
        goes = ~stops
        moving, problem = moving[goes], problem.part(goes)
        sense, kept, scale, unknowns, single, rows, moved, jumped, chi2 = (
            each[goes] for each in (sense, kept, scale, unknowns, single, rows, moved, jumped, chi2)
        )
    order, *values = ended[0] if len(ended) == 1 else map(np.concatenate, zip(*ended, strict=True))
    adjusted = _conclude([problems[place] for place in order.tolist()], *values)
    return [adjusted[place] for place in order.argsort().tolist()]


def _conclude(
    problems: Sequence[Problem], converged: Any, slopes: Floats, own: Floats, rows: Floats, factor: Floats,
    plain: Floats, closed: Floats, sense: Floats, kept: Floats, unknowns: Floats, scale: Floats,
) -> list[Adjusted]:  # fmt: skip
    """Work out covariance, deleted residuals and influence where the steps ended."""
    count = problems[0].count
    inverse = np.linalg.inv(factor)
    q = rows[..., :-1] @ inverse
    # Deleted residuals: for a run in the fit the leverage takes it out again, for one outside the
    # uncertainty of the prediction is added.
    rest = np.maximum(1 - np.add.reduce(q[:, :count] ** 2, axis=-1), NEGLIGIBLE)
    variance = own * rest
    if not kept.all():
        variance = np.where(kept > 0, variance, own + np.add.reduce((plain @ inverse) ** 2, axis=-1))
    gain = (q @ inverse[:, 0, :, None])[..., 0] * scale[:, :1]
    directions = (inverse @ inverse[:, 0, :, None])[..., 0]
    directions /= directions[:, :1].copy()
    weighted = kept * closed / np.sqrt(own)
    influence, deviations = gain[:, :count] * weighted / rest, sense * closed / np.sqrt(variance)
    covariance = inverse[:, :3] @ inverse[:, :3].swapaxes(1, 2) * (scale[:, :, None] * scale[:, None])
    found, chi2 = unknowns[:, :3] * scale, _chi2(closed, own, kept, unknowns)
    return [
        Adjusted(
            problem=problem,
            unknowns=found[i],
            covariance=covariance[i],
            gain=gain[i],
            shared=unknowns[i, 3:],
            slopes=slopes[i],
            scale=scale[i],
            directions=directions[i],
            rows=rows[i, :count, :-1],
            orthogonal=q[i, :count],
            kept=kept[i],
            weighted=weighted[i],
            own=own[i],
            deviations=deviations[i],
            influence=influence[i],
            chi2=float(chi2[i]),
            converged=bool(converged[i]),
        )
        for i, problem in enumerate(problems)
    ]


def _chi2(closed: Floats, own: Floats, kept: Floats, unknowns: Floats) -> Floats:
    """Add up the squares of the runs' errors and of the priors', shape (L,)."""
    chi2: Floats = np.add.reduce(kept * closed * closed / own, axis=-1) + np.add.reduce(unknowns[:, 1:] ** 2, axis=-1)
    return chi2


def prior_rows(count: int, width: int) -> Floats:
    """Make room for n runs, above one row for the prior of each unknown but the first; last column the target."""
    rows = np.zeros((count + width - 1, width + 1))
    rows[count:, 1:width] = np.eye(width - 1)
    return rows


def fill_rows(
    rows: Floats, problem: Problem, at: Linear, kept: Floats | float, scale: Floats, unknowns: Floats
) -> Floats:
    """Fill in the weighted conditions and all targets; give the derivatives without weights, shape (…, n, 3 + K)."""
    count, labs, width = problem.count, at.own.shape[:-1], rows.shape[-1] - 1
    flat = np.zeros((*labs, count * width))
    flat[..., problem.to_row] = at.slopes.reshape(*labs, len(problem.sources) * count).take(problem.from_slope, axis=-1)
    plain = flat.reshape(*labs, count, width)
    plain[..., :3] = at.to_unknowns * scale
    weight = kept / np.sqrt(at.own)
    rows[..., :count, :-1] = plain * weight[..., None]
    rows[..., :count, -1] = -at.misclosure * weight
    rows[..., count:, -1] = -unknowns[..., 1:]
    return plain


def solve_rows(rows: Floats) -> tuple[Floats, Floats]:
    """Least squares of rows, last column the target: solution, (…, k), and triangular factor of the rest, (…, k, k)."""
    # The factor with the target beside it holds Qᵀ·target, so that Q itself is never formed.
    packed, _ = np.linalg.qr(rows, mode="raw")
    width = rows.shape[-1] - 1
    whole = np.swapaxes(packed, -1, -2)[..., :width, :]
    # Below it the packed form keeps the reflections.
    factor = whole[..., :-1] * _upper(width)
    solution: Floats = np.linalg.solve(factor, whole[..., -1:])[..., 0]
    return solution, factor


@lru_cache(maxsize=32)
def _upper(width: int) -> Floats:
    """Ones on and above the diagonal."""
    return np.triu(np.ones((width, width)))


def onto_conditions(at: Linear, inertia: Floats) -> Floats:
    """Errors that each run has alone, moved back onto its condition; for after a large step, shape (…, S, n).

    Only there is the derivative of the distance exact, and a common shrinking of I_zz and all torques gains
    nothing, however far off the runs are. A run without a weight may still be beyond the pole, M0 = 0: it
    stays where it was read.
    """
    near = np.abs(at.misclosure) < 0.5 * np.abs(at.to_unknowns[..., 0] * inertia)
    moved: Floats = -at.alone * (near * at.misclosure / at.own)[..., None, :]
    return moved


def _damped(step: Floats, unknowns: Floats) -> Floats:
    """Shorten each step that would more than halve or double the inertia."""
    limit, size = 0.5 * np.abs(unknowns[:, :1]), np.abs(step[:, :1])
    return np.where(size > limit, step * (limit / size), step)


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
