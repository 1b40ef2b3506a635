"""The answer with all that is uncertain about its own widths: one posterior from one prior, for every design.

How wide the errors of the single runs are (the hand), and how well the ball is balanced, a log knows only roughly. Two
numbers stand for that, and both are integrated over:

* s, the factor on the errors that each run has alone: near 1, with tails, the more so where the log states no
  ``u_time``;
* w, the width of M0 before the runs have their say: distributed so that M0 is a Cauchy of `BALANCE` times the lightest
  torque. A balance test, if there is one, is evidence about M0 that may be false (`TOO_BOLD`).

Given s and w the adjusted conditions are linear and normal, and the shared errors and b go out by a rotation that is
the same for all s: n runs become a handful of numbers, and each s and w costs a few operations. The weights are the
marginal likelihoods with both determinants (that of the readings' covariance, and that of the unknowns', as in REML),
times the priors. Known as an integrated nested Laplace approximation: Rue, Martino & Chopin, J. R. Stat. Soc. B 71,
319 (2009); the factor s is the "dark uncertainty" of interlaboratory comparisons: Koepke et al., Metrologia 54, S34
(2017).
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from itertools import accumulate, pairwise
from typing import cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.fitting.conditions import MANY, NEGLIGIBLE
from gyrodata.physics import Floats
from gyrodata.stacks import stacked

BALANCE = 0.05
"""Scale of M0's Cauchy prior over the lightest torque [1]: published balances have a median of 0.025, tails to 0.7."""

BALANCED = 0.0675
"""The same scale [rad²/s²] times I_zz where the log says that the ball is balanced: 0.3 mN*m for a 4-inch ball."""

TOO_BOLD = np.array([[1.0, 3.0, 10.0, 30.0, 100.0], [0.03, 0.06, 0.1, 0.26, 0.55]])
"""A balance test may be so many times too bold, with this chance."""

UNBALANCED = 6.0
"""So many times the usual scale where the log says that it is not."""

SPREAD_DEFAULT, TAIL_DEFAULT = math.log(3.75), 0.05
"""Standard deviation of ln s, and the share of its wide tail, where the width of the times is a default …"""

SPREAD_STATED, TAIL_STATED = math.log(1.15), 0.15
"""… and where the log states it."""

TAIL = math.log(5.0)
"""Scale of the wide tail of ln s, a Cauchy."""

LOW, HIGH, STEPS = 0.25, 20.0, 20
"""Factors s that are looked at first, and how many."""

ENDS = np.log([LOW, HIGH])
"""Their logarithms."""

EVENLY = np.linspace(0.0, 1.0, STEPS)

TURNS = 10
"""So often at most the factors are spread anew."""

FARTHEST = 2.0
"""Beyond this what is bent goes on straight."""

SMALL, LARGE = 0.04, 0.14
"""Below and above this u/I_zz is small and large."""

WIDTHS = np.exp(np.linspace(math.log(0.03), math.log(100.0), 18))
"""Widths of M0 over the scale of its prior."""

CHANCES = -np.log(WIDTHS) - 0.5 / WIDTHS**2
"""Logarithm of the chance of each, up to a constant: M0 of width w, mixed so, is a Cauchy."""
CHANCES -= math.log(np.exp(CHANCES).sum())

STEP = math.log(100.0 / 0.03) / 17
"""Between the logarithms of two widths."""

FALSE_WIDTHS = 0.03 * np.exp(STEP * np.arange(50))
"""Widths of M0 over what a balance test allows: a false one must leave M0 as free as no test does."""

TESTED_WIDTHS = np.exp(STEP * np.arange(-40, 1))
"""Widths of M0 where there is a test, over the largest without one."""

LEVELS = np.array([0.025, 0.158655253931457, 0.5, 0.841344746068543, 0.975])
"""The quantiles that are told: of the 95 % interval, of that of one standard uncertainty, and the median."""


class Conditions(Struct, frozen=True):
    """The conditions of n runs, linear where a fit ended, each over the width that its run has alone; labs stacked.

    Unknowns and errors are counted from where the fit ended: I_zz, M0 and b in some unit, the errors that runs share in
    their standard uncertainties.
    """

    unknowns: Floats
    """Derivatives to I_zz, M0 and b, shape (…, n, 3)."""
    shared: Floats
    """Derivatives to the K shared errors, shape (…, n, K)."""
    left: Floats
    """Misclosure where all shared errors are none, shape (…, n)."""
    ended: Floats
    """I_zz, M0 and b where the fit ended, in their units, shape (…, 3)."""
    runs: Floats
    """How many runs have a say, shape (…)."""
    scatter: Floats
    """Factor on the errors that each run has alone, as the fit had it, shape (…)."""
    without_readings: bool = False
    """Whether this is a design, in which errors of that size are to be expected."""


class Posterior(Struct, frozen=True):
    """A mixture of normal distributions of I_zz, M0 and b, for labs of shape (…)."""

    weight: Floats
    """Of each part, shape (…, N); they add up to 1."""
    mean: Floats
    """Shape (…, 3, N)."""
    u: Floats
    """Standard deviation of each part, shape (…, 3, N)."""
    factor: Floats
    """s of each part [1], shape (…, N)."""
    width: Floats
    """Width of M0 in each part, in its unit, shape (…, N)."""
    evidence: Floats
    """Logarithm of the likelihood of the whole model, up to what its labs have in common, shape (…)."""
    ended: Floats | float = 1.0
    """I_zz where the fit ended, shape (…)."""
    bend: Floats | float = 0.0
    """I_zz over that is 1 + t + `bend` t², to second order in what is normal, 1 + t; shape (…)."""

    def quantiles(self, unknowns: int = 1, which: slice = slice(None)) -> Floats:
        """Quantiles at `LEVELS`, or at some of them, of I_zz, or of it, M0 and b; shape (…, unknowns, 5)."""
        *labs, parts = self.weight.shape
        count = math.prod(labs)
        each = self.mean[..., :unknowns, :], self.u[..., :unknowns, :]
        mean, u = (values.reshape(count, unknowns, parts) for values in each)
        ended, bend = (_flat(value, count) for value in (self.ended, self.bend))
        ends = _quantiles(self.weight.reshape(count, parts), mean, u, ended, bend, which)
        return ends.reshape((*labs, unknowns, ends.shape[-1]))

    def middle(self) -> Floats:
        """Mean of I_zz, M0 and b, shape (…, 3)."""
        return cast(Floats, np.add.reduce(self.weight[..., None, :] * self.mean, axis=-1))

    def times(self, unit: Floats) -> Posterior:
        """Give the same with I_zz, M0 and b counted in other units, shape (…, 3)."""
        each = unit[..., None]
        return replace(
            self, mean=self.mean * each, u=self.u * each, width=self.width * unit[..., 1:2],
            ended=self.ended * unit[..., 0],
        )  # fmt: skip

    def straight(self) -> Posterior:
        """Give the same with parts that are normal in I_zz itself."""
        mean, u = self.mean.copy(), self.u.copy()
        mean[..., 0, :], slope = _bent(self.mean[..., 0, :], self.ended, self.bend)
        u[..., 0, :] *= slope
        return replace(self, mean=mean, u=u, ended=1.0, bend=0.0)

    def typical(self, values: Floats) -> Floats:
        """Geometric mean of s or of the width of M0, shape (…)."""
        return cast(Floats, np.exp(np.add.reduce(self.weight * np.log(values), axis=-1)))


def integrate(
    conditions: Conditions,
    scale: Floats | float,
    stated: bool,
    tested: Floats | float | None = None,
    near: Posterior | None = None,
) -> Posterior:
    """Weigh every s and w by how well the runs go with them.

    `scale` is that of M0's Cauchy, `tested` the width that a balance test allows M0, both in the unit of M0, shape (…);
    `stated` says whether the log states how wide the times are. `near` is what is known already of nearly the same.
    """
    *labs, runs, shared = conditions.shared.shape
    count = math.prod(labs)
    stack = Conditions(
        conditions.unknowns.reshape(count, runs, 3), conditions.shared.reshape(count, runs, shared),
        conditions.left.reshape(count, runs), conditions.ended.reshape(count, 3),
        conditions.runs.reshape(count), conditions.scatter.reshape(count), conditions.without_readings,
    )  # fmt: skip
    # Most logs need no others than these.
    low, high = ENDS if near is None else np.log(near.factor[..., [0, -1]]).T
    tests = None if tested is None else _flat(tested, count)
    found = _integrate(stack, _flat(scale, count), stated, tests, _flat(low, count), _flat(high, count))
    values = (getattr(found, name) for name in _OF_LABS)
    return Posterior(*(value.reshape((*labs, *value.shape[1:])) for value in values))


def _alike(one: Conditions, scale: Floats, stated: bool, tested: Floats | None, *_: Floats) -> Hashable:
    shape = one.shared.shape[1:]
    return None if shape[0] > MANY else (shape, stated, tested is None, one.without_readings)


@stacked(_alike)
def _integrate(calls: Sequence[_Weighed]) -> list[Posterior]:
    """Integrate for labs of shape (L,), those of several calls together."""
    conditions, scales, (stated, *_), tests, lows, highs = zip(*calls, strict=True)
    arrays = {name: np.concatenate([getattr(one, name) for one in conditions]) for name in _STACKED}
    whole = Conditions(**arrays, without_readings=conditions[0].without_readings)
    tested = None if tests[0] is None else np.concatenate(tests)
    found = _weigh(whole, np.concatenate(scales), stated, tested, np.concatenate(lows), np.concatenate(highs))
    values = [getattr(found, name) for name in _OF_LABS]
    ends = list(accumulate((len(one.left) for one in conditions), initial=0))
    return [Posterior(*(value[start:end] for value in values)) for start, end in pairwise(ends)]


def _weigh(
    conditions: Conditions, scale: Floats, stated: bool, tested: Floats | None, low: Floats, high: Floats
) -> Posterior:
    """Integrate over the factors s between two logarithms, for each lab wider or narrower where that is wanted."""
    widths, prior = balance_prior(scale, tested)
    reduced = _reduce(conditions, scale, tested)
    if conditions.without_readings:
        reduced = replace(reduced, squares=_expect(reduced, conditions.scatter, scale))
    labs, ended, bend = conditions.left.shape[:-1], conditions.ended[..., 0], reduced.bend
    spread = _spread(low, high, stated)
    at = ended[..., None, None]
    # As likely before the runs are looked at: every I_zz^(1 − bend), and M0 over I_zz^bend with its width in M0.
    lean = 2 * bend[..., None, None] / at
    for turn in range(TURNS):
        factor, spacing = spread.logarithm, (spread.high - spread.low) / (STEPS - 1)
        parts = _Parts(reduced, spread.factor, widths)
        whole = parts.log_likelihood + prior[..., None, :]
        whole += spread.chance[..., None]
        whole += lean * np.minimum(np.maximum(parts.inertia - at, -0.3 * at), 0.3 * at)
        top = np.maximum.reduce(whole, axis=(-1, -2), keepdims=True)
        weight = np.exp(whole - top)
        total = np.add.reduce(weight, axis=(-1, -2), keepdims=True)
        weight /= total
        of_factor = np.add.reduce(weight, axis=-1)
        centre = _dot(of_factor, factor)
        sd = np.sqrt(_dot(of_factor, (factor - centre[..., None]) ** 2))
        # Runs enough tell s so well that the steps are too wide; a log that is far off has it beyond the last.
        narrow = sd < 1.2 * spacing
        beyond = of_factor[..., -1] > 1e-3
        if turn == TURNS - 1 or not (narrow | beyond).any():
            break
        half = np.maximum(sd, 0.5 * spacing)
        low = np.where(narrow, centre - 6 * half, spread.low)
        high = np.where(narrow, centre + 6 * half, np.where(beyond, spread.high + 4.0, spread.high))
        spread = _spread(low, high, stated)
    flat = (*labs, -1)
    mean, variance, covariance = parts.moments()
    mean, variance, covariance = mean.reshape(*labs, 3, -1), variance.reshape(*labs, 3, -1), covariance.reshape(flat)
    # Within a part the same; but where u is small exact readings give the exact answer, and where it is large none.
    relative = variance[..., 0, :] / ended[..., None] ** 2
    square = relative * relative
    within = lean[..., 0] * square / (square + SMALL**4) / (1 + square / LARGE**4)
    mean[..., 0, :] += within * variance[..., 0, :]
    mean[..., 1, :] += within * covariance
    # From M0 over I_zz^bend to M0.
    value, slope = _bent(mean[..., 0, :], ended, bend)
    inertia = np.maximum(value, 1e-3 * ended[..., None])
    grown = (inertia / ended[..., None]) ** bend[..., None]
    pull = bend[..., None] * mean[..., 1, :] * slope / inertia
    variance[..., 1, :] += pull * (2 * covariance + pull * variance[..., 0, :])
    mean[..., 1, :] *= grown
    variance[..., 1, :] *= grown**2
    each = np.ones(weight.shape)
    return Posterior(
        weight.reshape(flat),
        mean,
        np.sqrt(variance),
        (spread.factor[..., None] * each).reshape(flat),
        (widths[..., None, :] * each).reshape(flat),
        (top + np.log(total))[..., 0, 0],
        ended,
        bend,
    )


_STACKED = ("unknowns", "shared", "left", "ended", "runs", "scatter")
"""What of some conditions has a row for each lab …"""

_OF_LABS = ("weight", "mean", "u", "factor", "width", "evidence", "ended", "bend")
"""… and of a posterior."""

_Weighed = tuple[Conditions, Floats, bool, Floats | None, Floats, Floats]
"""Conditions, the scale of M0, whether the times are stated, the balance test, and the logarithms of s at both ends."""


class _Spread(Struct, frozen=True):
    """Factors s, evenly spread between two logarithms, for labs of shape (…)."""

    low: Floats
    high: Floats
    logarithm: Floats
    """Shape (…, S)."""
    factor: Floats
    chance: Floats
    """Logarithm of the chance of each before the runs are looked at, times what lies between two."""


def _spread(low: Floats, high: Floats, stated: bool) -> _Spread:
    logarithm = low[..., None] + (high - low)[..., None] * EVENLY
    chance = scatter_prior(logarithm, stated) + np.log((high - low) / (STEPS - 1))[..., None]
    return _Spread(low, high, logarithm, np.exp(logarithm), chance)


def _flat(values: Floats | float, count: int) -> Floats:
    """One value for each lab of a stack, shape (L,)."""
    array = np.asarray(values, dtype=float)
    return array.reshape(count) if array.size == count else np.full(count, array)


def _bent(values: Floats, ended: Floats | float, bend: Floats | float) -> tuple[Floats, Floats]:
    """I_zz from what is normal in its place, and its derivative; the two go together where the fit ended."""
    unit, twice = np.asarray(ended)[..., None], 2 * np.maximum(bend, 1e-9)[..., None]
    away = twice * (values / unit - 1)
    near = np.minimum(away, FARTHEST)
    slope = np.exp(near)
    return unit * (1 + (np.expm1(near) + slope * (away - near)) / twice), slope


def mixed(posteriors: Sequence[Posterior]) -> Posterior:
    """Put posteriors of several models of one log together, each with the weight of its evidence."""
    posteriors = [one.straight() for one in posteriors]
    evidence = np.array([float(one.evidence) for one in posteriors])
    chance = np.exp(evidence - evidence.max())
    chance /= chance.sum()

    def joined(name: str) -> Floats:
        return np.concatenate([getattr(one, name) for one in posteriors], axis=-1)

    weight = np.concatenate([share * one.weight for share, one in zip(chance, posteriors, strict=True)])
    return Posterior(weight, joined("mean"), joined("u"), joined("factor"), joined("width"), evidence.max())


def balance_prior(scale: Floats, tested: Floats | float | None) -> tuple[Floats, Floats]:
    """Widths of M0, shape (…, W), and the logarithm of the chance of each."""
    widths = scale[..., None] * WIDTHS
    if tested is None:
        return widths, CHANCES
    # A Cauchy too, of the test's own width: the same mixture of normals, times what each says of the other.
    bold = np.log(FALSE_WIDTHS[:, None] / TOO_BOLD[0])
    doubt = np.log(np.exp(-bold - 0.5 * np.exp(-2 * bold)) @ TOO_BOLD[1])
    doubt -= math.log(np.exp(doubt).sum())
    test = np.maximum(tested, NEGLIGIBLE)[..., None] * FALSE_WIDTHS
    squares = widths[..., :, None] ** 2, test[..., None, :] ** 2
    both = squares[0] * squares[1] / (squares[0] + squares[1])
    weight = CHANCES[:, None] + doubt - 0.5 * np.log(squares[0] + squares[1])
    # The product of two normals is one: all of them, told by fewer widths.
    count = len(TESTED_WIDTHS)
    both, weight = (values.reshape(*both.shape[:-2], -1) for values in (both, weight))
    grid = widths[..., -1:] * TESTED_WIDTHS
    place = np.maximum(np.log(np.sqrt(both) / grid[..., :1]) / STEP, 0.0)
    lower = np.minimum(place.astype(int), count - 2)
    mass = np.exp(weight - weight.max(axis=-1, keepdims=True))
    onto = np.zeros(grid.shape)
    rows = np.arange(onto.size // count).reshape(onto.shape[:-1])[..., None] * count
    np.add.at(onto.reshape(-1), rows + lower, mass * (lower + 1 - place))
    np.add.at(onto.reshape(-1), rows + lower + 1, mass * (place - lower))
    with np.errstate(divide="ignore"):
        return grid, np.log(onto)


def doubt_of_widths(stated: bool) -> float:
    """Give the factor by which the errors that each run has alone may well be wider than the log says."""
    return math.exp(SPREAD_STATED if stated else SPREAD_DEFAULT)


def scatter_prior(factor: Floats, stated: bool) -> Floats:
    """Logarithm of the density of ln s."""
    spread, tail = (SPREAD_STATED, TAIL_STATED) if stated else (SPREAD_DEFAULT, TAIL_DEFAULT)
    near = (1 - tail) * np.exp(-0.5 * (factor / spread) ** 2) / (spread * math.sqrt(2 * math.pi))
    far = tail / (math.pi * TAIL * (1 + (factor / TAIL) ** 2))
    if stated:
        # Who states a width may be too bold, hardly too modest.
        far = np.where(factor > 0, 2 * far, 0.0)
    return cast(Floats, np.log(near + far))


class _Reduced(Struct, frozen=True):
    """What n runs say, rotated so that every row has its own variance s² + `shared`²."""

    shared: Floats
    """Shape (…, m)."""
    rows: Floats
    """Derivatives to I_zz + `slope` M0, M0 and b, and the misclosure, shape (…, m, 4)."""
    slope: Floats
    """With it the first two are told nearly by themselves, also where only their sum is told well; shape (…)."""
    rest: Floats
    """Rows that say nothing, shape (…)."""
    ended: Floats
    bend: Floats
    """Share of the runs in what is known of M0, times that of M0 in the doubt about I_zz, shape (…)."""
    squares: Floats | None = None
    """Squares of the misclosures to be expected of a design without readings, that of the `rest` last, (…, m + 1)."""


def _reduce(conditions: Conditions, scale: Floats, tested: Floats | float | None) -> _Reduced:
    """Rotate the conditions so that the shared errors, b among them, make no two rows go together.

    A run's time tells (M + M0)/I_zz, whose error is the same whatever M0 is: as far as the runs tell M0, 1/I_zz and
    M0/I_zz are normal, and as far as its prior does, I_zz and M0. Between them lie I_zz^(1 − 2a) and M0/I_zz^a.
    """
    count = conditions.shared.shape[-1] + 1
    bias = conditions.unknowns[..., 2:]
    # Counted from b = 0, where its prior is centred.
    target = bias * conditions.ended[..., None, 2:] - conditions.left[..., None]
    rows: Floats = np.concatenate([conditions.shared, bias, conditions.unknowns, target], axis=-1)
    *_, runs, columns = rows.shape
    if runs > columns:
        rows = np.asarray(np.linalg.qr(rows, mode="r"))
    turn, values, _ = np.linalg.svd(rows[..., :count])
    size = np.zeros(rows.shape[:-1])
    size[..., : values.shape[-1]] = values
    rotated = np.swapaxes(turn, -1, -2) @ rows[..., count:]
    weighted = rotated[..., :2] / (conditions.scatter[..., None] ** 2 + size**2)[..., None]
    sums = np.swapaxes(weighted, -1, -2) @ rotated[..., :2]
    ii, im, mm = sums[..., 0, 0], sums[..., 0, 1], sums[..., 1, 1]
    # What a Cauchy distribution tells where the fit ended.
    at = conditions.ended[..., 1]
    told = sum(2 / (np.square(width) + at**2 + 1e-300) for width in (scale, tested) if width is not None)
    by_runs = np.maximum(mm - im**2 / ii, 0.0)
    # An error that all torques or spins share leaves I_zz as normal as it is.
    by_m0 = im**2 / (ii * mm)
    bend = np.where(conditions.ended[..., 0] > 0, by_m0 * by_runs / (by_runs + told), 0.0)
    turned = bend * at / conditions.ended[..., 0]
    slope = (im + turned * mm) / (ii + 2 * turned * im + turned**2 * mm)
    rotated[..., 0] += turned[..., None] * rotated[..., 1]
    rotated[..., 1] -= slope[..., None] * rotated[..., 0]
    rest = conditions.runs - rows.shape[-2]
    return _Reduced(size, rotated, slope, np.asarray(rest), conditions.ended, bend)


def _expect(reduced: _Reduced, scatter: Floats, scale: Floats) -> Floats:
    """Expect squares of misclosures as large as their variances, but for what I_zz and M0 take up."""
    variance = scatter[..., None] ** 2 + reduced.shared**2
    inertia, imbalance = (reduced.rows[..., k] / np.sqrt(variance) for k in (0, 1))
    # With `slope` the two are told by themselves.
    taken = inertia**2 / _dot(inertia, inertia)[..., None]
    taken += imbalance**2 / (_dot(imbalance, imbalance) + 1 / scale**2)[..., None]
    return np.concatenate([(1 - taken) * variance, (reduced.rest * scatter**2)[..., None]], axis=-1)


class _Parts:
    """The normal distribution for each s, shape (…, S), and w, shape (…, W); of shape (…, S, W) or (…, S, 1)."""

    def __init__(self, reduced: _Reduced, factor: Floats, widths: Floats) -> None:
        """Solve for I_zz and M0, and say how likely the runs are."""
        variance = factor[..., None] ** 2 + reduced.shared[..., None, :] ** 2
        # Sums of products of the columns I, M0, b, misclosure, for each s.
        rows = reduced.rows
        products = (rows[..., :, None] * rows[..., None, :]).reshape(*rows.shape[:-1], 16)
        sums = (1 / variance) @ products
        log_likelihood = -0.5 * np.add.reduce(np.log(variance), axis=-1) - reduced.rest[..., None] * np.log(factor)
        if reduced.squares is not None:
            squares = reduced.squares[..., None, :]
            log_likelihood -= 0.5 * (_dot(squares[..., :-1], 1 / variance) + squares[..., -1] / factor**2)
        self.sums = sums[..., None]
        ii, im, i_left, mm, m_left, chi2 = (self.sums[..., k, :] for k in (0, 1, 3, 5, 7, 15))
        narrow = 1 / widths[..., None, :] ** 2
        self.at, self.slope = reduced.ended[..., 1, None, None], reduced.slope[..., None, None]
        self.mm, m_w = mm + narrow, m_left - self.at * narrow
        self.determinant = ii * self.mm - im**2
        self.both = (self.mm * i_left - im * m_w) / self.determinant
        self.imbalance = (ii * m_w - im * i_left) / self.determinant
        misfit = chi2 + self.at * self.at * narrow - self.both * i_left - self.imbalance * m_w
        self.log_likelihood = log_likelihood[..., None] - 0.5 * (np.log(self.determinant / narrow) + misfit)
        self.inertia = reduced.ended[..., 0, None, None] + self.both - self.slope * self.imbalance

    def moments(self) -> tuple[Floats, Floats, Floats]:
        """Means and variances of I_zz, M0 and b, shape (…, 3, S, W), and the covariance of I_zz and M0, (…, S, W)."""
        ii, im, ib, mb, bb, b_left = (self.sums[..., k, :] for k in (0, 1, 2, 6, 10, 11))
        slope = self.slope
        both_var, m_var, cov = self.mm / self.determinant, ii / self.determinant, -im / self.determinant
        # The others know b as well as its prior and what is left of the rows tell.
        bias = b_left - ib * self.both - mb * self.imbalance
        b_var = 1 - bb + ib**2 * both_var + 2 * ib * mb * cov + mb**2 * m_var
        i_var = both_var - 2 * slope * cov + slope**2 * m_var
        means, variances = (np.empty((*bias.shape[:-2], 3, *bias.shape[-2:])) for _ in range(2))
        means[..., 0, :, :], means[..., 1, :, :], means[..., 2, :, :] = self.inertia, self.at + self.imbalance, bias
        variances[..., 0, :, :], variances[..., 1, :, :], variances[..., 2, :, :] = i_var, m_var, np.maximum(b_var, 0.0)
        return means, variances, cov - slope * m_var


@stacked(lambda weight, mean, u, ended, bend, which: (mean.shape[1:], which.start, which.stop, which.step))
def _quantiles(calls: Sequence[tuple[Floats, Floats, Floats, Floats, Floats, slice]]) -> list[Floats]:
    """Quantiles at some of `LEVELS` of posteriors of labs of shape (L,), those of several calls together."""
    *each, (which, *_) = zip(*calls, strict=True)
    weight, mean, u, ended, bend = map(np.concatenate, each)
    ends = _of_mixtures(weight, mean, u, which)
    straight = ends[..., 0, :]
    # What reaches to zero is no measurement, bent or not.
    ends[..., 0, :] = np.where(straight > 0, _bent(straight, ended, bend)[0], straight)
    places = accumulate((len(one[0]) for one in calls), initial=0)
    return [ends[start:end] for start, end in pairwise(places)]


def _of_mixtures(weight: Floats, mean: Floats, u: Floats, which: slice) -> Floats:
    """Quantiles at `LEVELS` of mixtures of normal distributions, shapes (L, N) and (L, K, N): (L, K, 5).

    By Newton's steps, kept in brackets, until all of a mixture's are there.
    """
    levels, normal = LEVELS[which], NORMAL[which]
    labs, parts = weight.shape
    found = np.empty((*mean.shape[:2], len(levels)))
    if parts > HEAVIEST:
        # What weighs next to nothing need not be looked at.
        heavy = np.argpartition(weight, -HEAVIEST, axis=-1)[:, -HEAVIEST:]
        kept = np.take_along_axis(weight, heavy, axis=-1)
        whole = np.add.reduce(kept, axis=-1, keepdims=True)
        enough = whole[:, 0] > 1 - LIGHT
        if not enough.all() and enough.any():
            for some in (enough, ~enough):
                found[some] = _of_mixtures(weight[some], mean[some], u[some], which)
            return found
        if enough.all():
            weight = kept / whole
            mean, u = (np.take_along_axis(values, heavy[:, None], axis=-1) for values in (mean, u))
    weight = weight[:, None, :]
    centre = np.add.reduce(weight * mean, axis=-1)[..., None]
    sd = np.sqrt(np.add.reduce(weight * (u**2 + (mean - centre) ** 2), axis=-1))[..., None]
    # A quantile lies within so many standard deviations of the mean, whatever the distribution (Cantelli).
    reach = sd * np.sqrt(1 / np.minimum(levels, 1 - levels))
    low, high, point = centre - reach, centre + reach, centre + sd * normal
    # What is exact is nearly so.
    size = np.maximum(np.maximum(u, 1e-6 * sd), 1e-300)[..., None, :]
    close = 1e-3 * np.minimum(levels, 1 - levels)
    steep = weight[..., None, :] / (size * math.sqrt(2 * math.pi))
    weight, centres = weight[..., None, :], mean[..., None, :]
    open_ones = np.arange(labs)
    for _turn in range(40):
        away = (point[..., None] - centres) / size
        square = np.exp(-0.5 * away * away)
        off = _dot(weight, normal_below(away, square)) - levels
        np.copyto(low, point, where=off < 0)
        np.copyto(high, point, where=off > 0)
        step = point - off / np.maximum(_dot(steep, square), 1e-300)
        inside = (step >= low) & (step <= high)
        point = np.where(inside, step, 0.5 * (low + high))
        # What is left after such a step is about as large as its square.
        there = (inside & (np.abs(off) <= close)).all(axis=(1, 2))
        if there.any():
            found[open_ones[there]] = point[there]
            if there.all():
                return found
            more = ~there
            open_ones, weight, centres, size, steep, low, high, point = (
                each[more] for each in (open_ones, weight, centres, size, steep, low, high, point)
            )
    found[open_ones] = point
    return found


def _dot(a: Floats, b: Floats) -> Floats:
    """Sum of products along the last axis."""
    return cast(Floats, np.einsum("...i,...i->...", a, b))


HEAVIEST, LIGHT = 160, 1e-4
"""So many parts of a mixture are enough for its quantiles where the others weigh less than this together: few runs
leave many wide parts that weigh little each."""

K_95 = 1.959963984540054
"""Coverage factor of the 95 % interval of a normal distribution: its 97.5 % point."""

NORMAL = np.array([-K_95, -1.0, 0.0, 1.0, K_95])
"""The same quantiles of a standard normal number."""


def normal_below(x: Floats, square: Floats) -> Floats:
    """Chance that a standard normal number is below x, to 1.2e-7 of the tail; `square` is exp(−x²/2).

    Rational approximation of erfc by Chebyshev's polynomials (W. H. Press et al., Numerical Recipes, section 6.2);
    `scipy.special` would cost as much as the whole analysis.
    """
    t = np.abs(x)
    t *= math.sqrt(0.125)
    t += 1
    np.divide(1, t, out=t)
    series = ERFC[0] * t
    series += ERFC[1]
    for coefficient in ERFC[2:]:
        series *= t
        series += coefficient
    # How likely it is to be farther out than x, on its side.
    tail = np.multiply(t, square, out=t)
    tail *= np.exp(series, out=series)
    tail *= 0.5
    np.subtract(1, tail, out=tail, where=x > 0)
    return tail


ERFC = (
    0.17087277, -0.82215223, 1.48851587, -1.13520398, 0.27886807, -0.18628806, 0.09678418, 0.37409196, 1.00002368,
    -1.26551223,
)  # fmt: skip
"""Coefficients, that of the highest power first."""
