"""The Gauss–Helmert adjustment: the unknowns and all the errors of the readings, by least squares together.

Errors that one run has alone are eliminated row by row, shared ones stay as unknowns with their prior, the
conditions are linearised at the *adjusted* readings, and each step is solved by QR: no covariance matrix
of the data is built, no normal equations are formed, and an uncertainty of zero is just a column of zeros.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np

from gyrodata.fitting.conditions import NEGLIGIBLE, QUANTITIES, Linear, Problem
from gyrodata.physics import Floats

TURNS = 100
"""What has not come to rest after so many steps never will."""

LOST = 1e-3
"""An I_zz smaller than this share of its start never comes back, nor does one as much larger."""

WHOLE = 20
"""So many steps are whole ones; hardly any log needs half as many."""


class NoFit(Exception):  # noqa: N818 - like StopIteration, what came of it and not a fault
    """The runs have no answer that can be believed; its text says why, for a student."""


@dataclass(frozen=True)
class Start:
    """Rough values of the unknowns."""

    inertia: float
    """[kg*m^2]"""
    imbalance: float
    """[N*m]"""


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


# What is not finite does not pass.
@np.errstate(all="ignore")
def adjust(problem: Problem, sense: Floats, start: Start, prior_width: float, kept: Floats, factor: float) -> Adjusted:
    """Iterate the Gauss–Helmert adjustment to a solution that can be believed, near its start by a factor.

    The unknowns are scaled to order one: I_zz by its start, M0 by its prior width, b by its own. Runs where
    `kept` is 0 have no weight, but what the others say of them is worked out. Raises `NoFit`.
    """
    count, shared_count = problem.count, problem.shared_count
    scale = np.array([start.inertia, prior_width, problem.measured.timing_bias_u])
    unknowns = np.zeros(3 + shared_count)
    unknowns[:2] = 1.0, start.imbalance / prior_width
    single = np.zeros_like(problem.absolute)
    rows = prior_rows(count, 3 + shared_count)
    chi2 = moved = math.inf
    jumped = 0.0
    converged = False
    try:
        for turn in range(TURNS):
            at = problem.linearise(single, unknowns[3:], sense, unknowns[:3] * scale)
            if jumped > 0.03 or turn >= WHOLE:
                single = onto_conditions(at, unknowns[:1] * scale[0])
                at = problem.linearise(single, unknowns[3:], sense, unknowns[:3] * scale)
            plain = fill_rows(rows, problem, at, kept, scale, unknowns)
            solution, triangle = solve_rows(rows)
            step = _damped(solution, unknowns)
            if turn >= WHOLE:
                # Whole steps go round in a circle where errors are as large as what is read: go ever less far.
                step = step * 0.5 ** (turn // WHOLE)
            unknowns = unknowns + step
            closed = at.misclosure + plain @ step
            # A run that is left out has no weight, but its prediction too is linear only on its condition.
            single = -at.alone * (closed / at.own)
            if not LOST < unknowns[0] < 1 / LOST:
                break
            sizes = np.abs(step).tolist()
            last, moved, jumped = moved, max(sizes), max(sizes[:2])
            # Steps shrink by a constant factor: the next would be this one times this one over the last.
            if moved**2 < 1e-9 * min(last, 1.0 if turn else 0.0) or moved < 1e-11:
                converged = True
                break
            if turn > 2:
                before, chi2 = chi2, _chi2(closed, at.own, kept, unknowns)
                if abs(before - chi2) <= 1e-13 * chi2:
                    converged = True
                    break
        adjusted = _conclude(problem, at, rows, triangle, plain, closed, sense, kept, unknowns, scale, converged)
    except np.linalg.LinAlgError:
        raise NoFit("the runs do not tell the unknowns apart") from None
    insist_on_solution(adjusted, start.inertia, factor)
    return adjusted


def _conclude(
    problem: Problem, at: Linear, rows: Floats, factor: Floats, plain: Floats, closed: Floats,
    sense: Floats, kept: Floats, unknowns: Floats, scale: Floats, converged: bool,
) -> Adjusted:  # fmt: skip
    """Work out covariance, deleted residuals and influence where the steps ended."""
    count = problem.count
    inverse = np.linalg.inv(factor)
    q = rows[:, :-1] @ inverse
    # Deleted residuals: for a run in the fit the leverage takes it out again, for one outside the
    # uncertainty of the prediction is added.
    rest = np.maximum(1 - np.add.reduce(q[:count] ** 2, axis=1), NEGLIGIBLE)
    inside = at.own * rest
    outside = at.own + np.add.reduce((plain @ inverse) ** 2, axis=1)
    gain = (inverse[0] @ q.T) * scale[0]
    directions = inverse @ inverse[0]
    weighted = kept * closed / np.sqrt(at.own)
    return Adjusted(
        problem=problem,
        unknowns=unknowns[:3] * scale,
        covariance=inverse[:3] @ inverse[:3].T * (scale[:, None] * scale),
        gain=gain,
        shared=unknowns[3:],
        slopes=at.slopes,
        scale=scale,
        directions=directions / directions[0],
        rows=rows[:count, :-1],
        orthogonal=q[:count],
        kept=kept,
        weighted=weighted,
        own=at.own,
        influence=gain[:count] * weighted / rest,
        deviations=sense * closed / np.sqrt(np.where(kept > 0, inside, outside)),
        chi2=_chi2(closed, at.own, kept, unknowns),
        converged=converged,
    )


def _chi2(closed: Floats, own: Floats, kept: Floats, unknowns: Floats) -> float:
    """Add up the squares of the runs' errors and of the priors'."""
    return float((kept * closed) @ (closed / own) + unknowns[1:] @ unknowns[1:])


def prior_rows(count: int, width: int) -> Floats:
    """Make room for n runs, above one row for the prior of each unknown but the first; last column the target."""
    rows = np.zeros((count + width - 1, width + 1))
    rows[count:, 1:width] = np.eye(width - 1)
    return rows


def fill_rows(
    rows: Floats, problem: Problem, at: Linear, kept: Floats | float, scale: Floats, unknowns: Floats
) -> Floats:
    """Fill in the weighted conditions and all targets; give the derivatives without weights, shape (…, n, 3 + K)."""
    count = problem.count
    plain = np.zeros((*at.own.shape, rows.shape[-1] - 1))
    plain[..., :3] = at.to_unknowns * scale
    plain[..., problem.from_run, 3 + problem.to_column] = at.slopes[..., problem.from_source, problem.from_run]
    weight = kept / np.sqrt(at.own)
    rows[..., :count, :-1] = plain * weight[..., None]
    rows[..., :count, -1] = -at.misclosure * weight
    rows[..., count : count + unknowns.shape[-1] - 1, -1] = -unknowns[..., 1:]
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
    """Shorten a step that would more than halve or double the inertia."""
    limit = 0.5 * abs(unknowns[0])
    return cast(Floats, step * (limit / abs(step[0]))) if abs(step[0]) > limit else step


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
