"""The posterior of I_zz, M0 and b, integrated over the widths of some errors.

A log contains only rough information about the widths of these errors.

These widths are described by three numbers with a prior that is the same for every
design:

* s, the factor on the errors of single runs: near 1, with long tails, especially if the
  log does not state ``u_time``. It is a Birge factor with a prior (Bodnar & Elster,
  Metrologia 51, 516, 2014);
* w, the width of M0: distributed so that M0 has a Cauchy distribution with the scale
  `BALANCE` times the smallest torque. A balance test is evidence about M0 that may be
  false (`TOO_BOLD`);
* v, the width of the difference of M0 between weights: exactly zero, or of the order of
  `CHANGE` (`level_prior`).

For given s, v and w the adjusted conditions are linear and normal, and the prior of
I_zz is flat. For each v, shared errors and b are eliminated by a rotation that is the
same for all s: n runs become a few numbers, and each s and w needs only a few
operations. The weights are the marginal likelihoods with both determinants (of the
readings' covariance and, as in REML, of the unknowns') times the priors. The page
"statistics" derives the sums.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata.fitting.adjustment import NEGLIGIBLE
from gyrodata.physics import Floats

BALANCE = 0.05
"""Scale of M0's Cauchy prior over the lightest torque [1]: published balances have a
median of 0.025, tails to 0.7."""

BALANCED = 0.0675
"""The scale over I_zz [rad²/s²] if the log says that the ball is balanced: 0.3 mN·m for
a 4-inch ball."""

TOO_BOLD = np.array([[1.0, 3.0, 10.0, 30.0, 100.0], [0.03, 0.06, 0.1, 0.26, 0.55]])
"""Factors by which a balance test may be too optimistic, and the probability of each.
"""

UNBALANCED = 6.0
"""Factor on the usual scale if the log says that the ball is not balanced."""

CHANGE = 0.02
"""Scale of v's half-Cauchy prior over the lightest torque [1], if M0 differs between
weights. Published logs prefer 0.01 to 0.02."""

UNTOUCHED = 0.6
"""Probability that M0 does not differ between weights, if the log does not say: five of
14 published logs show a difference."""

CHANGES = CHANGE * np.exp(np.linspace(-1.5, 2.6, 4))
"""Widths v above zero, over the lightest torque [1]."""

SPREAD_DEFAULT, SPREAD_STATED = math.log(3.75), math.log(2.5)
"""Standard deviation of ln s if ``u_time`` is a default, and if the log states it."""

SHARE_OF_TAIL, TAIL = 0.05, math.log(5.0)
"""Share and scale of the wide tails of ln s, a Cauchy distribution."""

STEPS = 14
"""Number of factors s."""

ENDS = np.log([0.25, 20.0])
"""Logarithms of the smallest and the largest factor s in the first round."""

EVENLY = np.linspace(0.0, 1.0, STEPS)

FINE = 0.8
"""Smallest standard deviation of ln s over the difference of two logarithms: a sum over
a normal density then has an error of 7e-6."""

MAX_SPREADS = 10
"""Largest number of rounds in which the range of the factors changes."""

WIDTHS = np.exp(np.linspace(math.log(0.03), math.log(100.0), 12))
"""Widths of M0 over the scale of its prior."""

CHANCES = -np.log(WIDTHS) - 0.5 / WIDTHS**2
"""Logarithm of the probability of each: with it, the mixture of normal distributions is
a Cauchy distribution."""
CHANCES -= math.log(np.exp(CHANCES).sum())

NOT_FALSE = 6.0
"""Largest width of M0 over the scale of its prior if nothing but the condition that the
ball is balanced limits M0: an answer with this condition supposes that it is true."""

STEP = math.log(100.0 / 0.03) / 17
"""Difference of the logarithms of two widths with a balance test."""

FALSE_WIDTHS = 0.03 * np.exp(STEP * np.arange(50))
"""Widths of M0 over that of a balance test; with a false test M0 must be as free as
without one."""

TESTED_WIDTHS = np.exp(STEP * np.arange(-40, 1))
"""Widths of M0 with a test, over the largest one without."""

LEVELS = np.array([0.025, 0.158655253931457, 0.5, 0.841344746068543, 0.975])
"""Quantiles: the ends of the 95 % interval and of the 68 % interval, and the median."""


class Conditions(Struct, frozen=True):
    """The conditions of n runs, linear at the end of a fit.

    Each condition is divided by the width of its independent errors.

    Unknowns and errors are differences from the end of the fit: I_zz, M0 and b in some
    unit, shared errors in their standard uncertainties.
    """

    unknowns: Floats
    """Derivatives with respect to I_zz, M0 and b, shape (n, 3)."""
    shared: Floats
    """Derivatives with respect to the K shared errors, shape (n, K)."""
    levels: Floats
    """Derivatives with respect to the difference of M0 of each weight, in the unit of
    M0, shape (n, J); J is 0 if M0 does not differ."""
    left: Floats
    """Misclosure if all shared errors are zero, shape (n,)."""
    ended: Floats
    """I_zz, M0 and b at the end of the fit, in their units, shape (3,)."""
    unit: Floats
    """The units of I_zz [kg*m^2], M0 [N*m] and b [s], shape (3,)."""
    runs: float
    """Number of runs that are used."""
    scatter: float
    """Factor s on the independent errors in the fit."""


class Posterior(Struct, frozen=True):
    """A mixture of N normal distributions of I_zz, M0 and b."""

    weight: Floats
    """Weight of each part, shape (N,); the sum is 1."""
    mean: Floats
    """Mean of each part, shape (3, N)."""
    u: Floats
    """Standard deviation of each part, shape (3, N)."""
    factor: Floats
    """s of each part [1], shape (N,)."""
    width: Floats
    """Width of M0 in each part [N*m], shape (N,)."""
    level: Floats
    """v of each part [N*m], shape (N,)."""
    evidence: float
    """Logarithm of the likelihood of the whole model, up to a constant."""

    def quantiles(self, unknowns: int = 1) -> Floats:
        """Compute the quantiles at `LEVELS` of the first unknowns of I_zz, M0 and b.

        Shape (unknowns, 5).
        """
        return _quantiles(self.weight, self.mean[:unknowns], self.u[:unknowns])

    def typical_widths(self) -> tuple[float, float, float]:
        """Return a typical s, and the v and the width of M0 that represent all of them.

        These widths alone give u(I_zz) of all widths with this s.
        """
        factor = math.exp(float(self.weight @ np.log(self.factor)))
        likely = self.weight > 1e-6 * np.maximum.reduce(self.weight)
        of_factor = self._nearest(likely, self.factor, factor)
        levels, number = np.unique(self.level[of_factor], return_inverse=True)
        weight, u = self.weight[of_factor], self.u[0, of_factor]
        mean_u = np.bincount(number, weight * u) / np.bincount(number, weight)
        mean_u = np.maximum.accumulate(mean_u)
        level = float(np.interp(weight @ u / np.add.reduce(weight), mean_u, levels))
        nearest = self._nearest(of_factor, self.level, level)
        weight, u = self.weight[nearest], self.u[:1, nearest]
        part = replace(
            self,
            weight=weight / np.add.reduce(weight),
            mean=self.mean[:1, nearest],
            u=u,
        )
        _, below, _, above, _ = part.quantiles()[0]
        order = u[0].argsort()
        widths = np.log(self.width[nearest][order])
        width = np.interp((above - below) / 2, u[0, order], widths)
        return factor, level, float(np.exp(width))

    def chance_of_one_balance(self) -> float:
        """Return the probability that M0 is the same with every weight."""
        return float(self.weight @ (self.level == 0))

    def _nearest(self, some: Any, values: Floats, typical: float) -> Any:
        """Select those of some parts whose value is the nearest one to a typical value."""
        away = np.where(some, np.abs(values - typical), np.inf)
        return some & (values == values[away.argmin()])


def integrate(
    conditions: Conditions,
    balance: tuple[Floats, Floats],
    stated: bool,
    untouched: float = UNTOUCHED,
) -> Posterior:
    """Compute the posterior: all s, v and w with a weight for their agreement with the runs.

    Parameters
    ----------
    conditions : Conditions
    balance : tuple of ndarray
        Widths of M0 [unit of M0], and the logarithm of the probability of each, as from
        `balance_prior`.
    stated : bool
        Whether the log states the uncertainty of its times.
    untouched : float
        Probability that M0 does not differ between weights.

    Returns
    -------
    Posterior
        I_zz [kg*m^2], M0 [N*m] and b [s].
    """
    widths, prior = balance
    levels, chance = level_prior(untouched if conditions.levels.shape[1] else 1.0)
    prior = chance[:, None, None] + prior
    shared, rows, slope = _rotate(conditions, levels)
    # Products of the columns I, M0, b and misclosure, in each row.
    products = (rows[..., :, None] * rows[..., None, :]).reshape(*shared.shape, 16)
    narrow, (ended, at, _) = 1 / widths**2, conditions.ended
    low, high = ENDS
    for turn in range(MAX_SPREADS):
        logarithm, spacing = low + (high - low) * EVENLY, (high - low) / (STEPS - 1)
        factor = np.exp(logarithm)
        variance = factor[:, None] ** 2 + shared[:, None] ** 2
        sums = np.moveaxis((1 / variance) @ products, -1, 0)[..., None]
        ii, im, ib, i_left, mm, mb, m_left, bb, b_left, chi2 = sums[
            [0, 1, 2, 3, 5, 6, 7, 10, 11, 15]
        ]
        # Solve for `both` = I_zz + slope M0 and for M0; arrays of shape (V, S, W) from
        # here on.
        mm, m_w = mm + narrow, m_left - at * narrow
        # By rounding the difference can be zero or negative.
        determinant = np.maximum(ii * mm - im**2, 1e-15 * ii * mm)
        both = (mm * i_left - im * m_w) / determinant
        residual_torque = (ii * m_w - im * i_left) / determinant
        misfit = chi2 + at * at * narrow - both * i_left - residual_torque * m_w
        # Rows without information have the variance s².
        spread = -0.5 * np.add.reduce(np.log(variance), axis=-1) - (
            conditions.runs - rows.shape[1]
        ) * np.log(factor)
        whole = spread[..., None] - 0.5 * (np.log(determinant / narrow) + misfit)
        whole += prior
        whole += (scatter_prior(logarithm, stated) + math.log(spacing))[:, None]
        top = np.maximum.reduce(whole, axis=None)
        weight = np.exp(whole - top)
        total = np.add.reduce(weight, axis=None)
        weight /= total
        of_factor = np.add.reduce(weight, axis=(0, 2))
        centre = of_factor @ logarithm
        sd = math.sqrt(of_factor @ (logarithm - centre) ** 2)
        # With many runs the steps can be too wide for s; with very bad runs s can be
        # above the range.
        too_wide = sd < FINE * spacing
        if turn == MAX_SPREADS - 1 or not (too_wide or of_factor[-1] > 1e-3):
            break
        if too_wide:
            half = max(sd, 0.5 * spacing)
            low, high = centre - 6 * half, centre + 6 * half
        else:
            high = high + 4.0
    # b follows from its prior and the rows, for given I_zz and M0.
    bias = b_left - ib * both - mb * residual_torque
    both_var, m_var, cov = mm / determinant, ii / determinant, -im / determinant
    b_var = 1 - bb + ib**2 * both_var + 2 * ib * mb * cov + mb**2 * m_var
    i_var = both_var - 2 * slope * cov + slope**2 * m_var
    mean = np.array(
        [ended + both - slope * residual_torque, at + residual_torque, bias]
    )
    u = np.sqrt(np.maximum([i_var, m_var, b_var], 0.0))
    # One part for each s, v and w, without those of no weight.
    heavy = weight > LIGHT / weight.size
    factor, level, width = np.broadcast_arrays(
        factor[:, None],
        levels[:, None, None] * conditions.unit[1],
        widths * conditions.unit[1],
    )
    unit = conditions.unit[:, None]
    return Posterior(
        weight[heavy] / np.add.reduce(weight[heavy]),
        mean[:, heavy] * unit,
        u[:, heavy] * unit,
        factor[heavy],
        width[heavy],
        level[heavy],
        float(top + math.log(total)),
    )


def _rotate(conditions: Conditions, levels: Floats) -> tuple[Floats, Floats, Floats]:
    """Rotate the conditions so that shared errors, including b, do not correlate two rows.

    Parameters
    ----------
    conditions : Conditions
    levels : ndarray, shape (V,)
        Widths of the difference of M0 between weights [unit of M0].

    Returns
    -------
    tuple of ndarray
        For each v: the shared error of each of m rows, so that its variance is s² plus
        the square of this error, shape (V, m); derivatives with respect to I_zz + slope
        M0, M0 and b, and the misclosure, shape (V, m, 4); and the slope, which makes
        the first two unknowns nearly independent, shape (V, 1, 1).
    """
    several = conditions.levels.shape[1]
    count = several + conditions.shared.shape[1] + 1
    bias = conditions.unknowns[:, 2:]
    # Relative to b = 0, the centre of its prior.
    target = bias * conditions.ended[2] - conditions.left[:, None]
    rows: Floats = np.concatenate(
        [conditions.levels, conditions.shared, bias, conditions.unknowns, target],
        axis=1,
    )
    if rows.shape[0] > rows.shape[1]:
        rows = np.asarray(np.linalg.qr(rows, mode="r"))
    errors = np.repeat(rows[None, :, :count], len(levels), axis=0)
    errors[:, :, :several] *= levels[:, None, None]
    turn, values, _ = np.linalg.svd(errors)
    size = np.zeros((len(levels), len(rows)))
    size[:, : values.shape[1]] = values
    rotated = turn.transpose(0, 2, 1) @ rows[:, count:]
    weight = 1 / (conditions.scatter**2 + size**2)
    own, with_m0 = np.einsum("vm,vm,vmk->kv", weight, rotated[..., 0], rotated[..., :2])
    slope = (with_m0 / own)[:, None]
    rotated[..., 1] -= slope * rotated[..., 0]
    return size, rotated, slope[:, :, None]


def mixed(posteriors: Sequence[Posterior]) -> Posterior:
    """Combine the posteriors of several models of one log, each with the weight of its evidence."""
    evidence = np.array([float(one.evidence) for one in posteriors])
    chance = np.exp(evidence - evidence.max())
    chance /= chance.sum()
    shares = zip(chance, posteriors, strict=True)
    parts = [
        [share * one.weight, one.mean, one.u, one.factor, one.width, one.level]
        for share, one in shares
    ]
    weight, mean, u, factor, width, level = (
        np.concatenate(column, axis=-1) for column in zip(*parts, strict=True)
    )
    return Posterior(weight, mean, u, factor, width, level, evidence.max())


@lru_cache(maxsize=8)
def level_prior(untouched: float) -> tuple[Floats, Floats]:
    """Return widths v and the logarithm of the probability of each, shape (V,).

    The widths are divided by the lightest torque [1].

    v is zero with the probability `untouched`; else it has a half-Cauchy distribution.
    """
    if untouched == 1:
        return np.zeros(1), np.zeros(1)
    # The density of ln v.
    density = 1 / (CHANGES / CHANGE + CHANGE / CHANGES)
    chance = np.append(untouched, (1 - untouched) * density / density.sum())
    some = chance > 0
    return np.append(0.0, CHANGES)[some], np.log(chance[some])


def balance_prior(
    scale: float, tested: float | None, tails: bool = True
) -> tuple[Floats, Floats]:
    """Return widths of M0, shape (W,), and the logarithm of the probability of each.

    Parameters
    ----------
    scale : float
        Scale of M0's Cauchy prior [unit of M0].
    tested : float, optional
        Width of M0 from a balance test [unit of M0].
    tails : bool
        Whether M0 can be much larger than its scale.
    """
    widths = scale * WIDTHS
    if tested is None:
        some = slice(None) if tails else WIDTHS < NOT_FALSE
        return widths[some], CHANCES[some]
    # The test is a Cauchy distribution too: a mixture of normal distributions,
    # multiplied with that of the prior.
    bold = np.log(FALSE_WIDTHS[:, None] / TOO_BOLD[0])
    doubt = np.log(np.exp(-bold - 0.5 * np.exp(-2 * bold)) @ TOO_BOLD[1])
    doubt -= math.log(np.exp(doubt).sum())
    squares = widths[:, None] ** 2, (max(tested, NEGLIGIBLE) * FALSE_WIDTHS) ** 2
    both = (squares[0] * squares[1] / (squares[0] + squares[1])).reshape(-1)
    weight = (CHANCES[:, None] + doubt - 0.5 * np.log(squares[0] + squares[1])).reshape(
        -1
    )
    # The product of two normal distributions is normal: represent all products by fewer
    # widths.
    count = len(TESTED_WIDTHS)
    grid = widths[-1] * TESTED_WIDTHS
    place = np.maximum(np.log(np.sqrt(both) / grid[0]) / STEP, 0.0)
    lower = np.minimum(place.astype(int), count - 2)
    mass = np.exp(weight - weight.max())
    onto = np.bincount(lower, mass * (lower + 1 - place), count)
    onto += np.bincount(lower + 1, mass * (place - lower), count)
    with np.errstate(divide="ignore"):
        return grid, np.log(onto)


def doubt_of_widths(stated: bool) -> float:
    """Return the factor by which the errors of single runs can be larger than the log says."""
    return math.exp(SPREAD_STATED if stated else SPREAD_DEFAULT)


def scatter_prior(factor: Floats, stated: bool) -> Floats:
    """Compute the logarithm of the prior density of ln s."""
    spread = SPREAD_STATED if stated else SPREAD_DEFAULT
    near = (
        (1 - SHARE_OF_TAIL)
        * np.exp(-0.5 * (factor / spread) ** 2)
        / (spread * math.sqrt(2 * math.pi))
    )
    far = SHARE_OF_TAIL / (math.pi * TAIL * (1 + (factor / TAIL) ** 2))
    return cast(Floats, np.log(near + far))


ROUNDING = 1e-14
"""Error of a probability that is due to rounding."""

LIGHT = 1e-3
"""Parts that have less weight than this together are left out."""

K_95 = 1.959963984540054
"""Coverage factor of the 95 % interval of a normal distribution."""

NORMAL = np.array([-K_95, -1.0, 0.0, 1.0, K_95])
"""Quantiles at `LEVELS` of a standard normal distribution."""


def _quantiles(weight: Floats, mean: Floats, u: Floats) -> Floats:
    """Compute the quantiles at `LEVELS` of mixtures of N normal distributions.

    Newton's method with brackets.

    Parameters
    ----------
    weight : ndarray, shape (N,)
    mean, u : ndarray, shape (unknowns, N)
    """
    centre = (mean @ weight)[:, None]
    sd = np.sqrt((u**2 + (mean - centre) ** 2) @ weight)[:, None]
    # Cantelli's inequality limits the distance of a quantile from the mean for every
    # distribution.
    reach = sd * np.sqrt(1 / np.minimum(LEVELS, 1 - LEVELS))
    low, high = centre - reach, centre + reach
    point: Floats = centre + sd * NORMAL
    # Exact values get a tiny uncertainty.
    size = np.maximum(np.maximum(u, 1e-6 * sd), 1e-300)[:, None, :]
    close = 1e-2 * np.minimum(LEVELS, 1 - LEVELS)
    steep, centres = weight / (size * math.sqrt(2 * math.pi)), mean[:, None, :]
    for _turn in range(40):
        # Far away the density is zero; the limit avoids an overflow of the square.
        away = np.clip((point[..., None] - centres) / size, -40.0, 40.0)
        square = np.exp(-0.5 * away * away)
        off = _normal_below(away, square) @ weight - LEVELS
        np.copyto(low, point, where=off < 0)
        np.copyto(high, point, where=off > 0)
        step = point - off / np.maximum(np.add.reduce(steep * square, axis=-1), 1e-300)
        inside = (step >= low) & (step <= high) | (np.abs(off) < ROUNDING)
        point = np.where(inside, step, 0.5 * (low + high))
        # The error after such a step is about the square of the step.
        if (inside & (np.abs(off) <= close)).all():
            break
    return point


def _normal_below(x: Floats, square: Floats) -> Floats:
    """Compute the probability that a standard normal number is below x, to 7.5e-8.

    `square` is exp(−x²/2). Approximation 26.2.17 of M. Abramowitz and I. A. Stegun,
    Handbook of Mathematical Functions; the import of `scipy.special` would take as long
    as the whole analysis.
    """
    t = np.abs(x)
    t *= 0.2316419
    t += 1
    np.divide(1, t, out=t)
    series = TAIL_SERIES[0] * t
    for coefficient in TAIL_SERIES[1:]:
        series += coefficient
        series *= t
    # The probability of the tail beyond x.
    tail: Floats = np.multiply(series, square, out=series)
    np.subtract(1, tail, out=tail, where=x > 0)
    return tail


TAIL_SERIES = np.array(
    [1.330274429, -1.821255978, 1.781477937, -0.356563782, 0.319381530]
) / math.sqrt(2 * math.pi)
"""Coefficients, the highest power first."""


# --- chi-square ---


@lru_cache(maxsize=64)
def chi2_tail(chi2: float, dof: int) -> float:
    """Compute the probability of a chi-square at least this large: Q(dof/2, chi2/2).

    A finite sum for a whole or half argument (DLMF 8.4.10 and 8.8.2); the import of
    scipy would take 0.25 s.
    """
    half, odd = chi2 / 2, dof % 2
    if half <= 0:
        return 1.0
    total = math.erfc(math.sqrt(half)) if odd else 0.0
    # Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1), in logarithms because e^-x alone
    # underflows. Terms that are further from the largest one, at a = x, do not change
    # the sum.
    reach, last = 10 * math.sqrt(half) + 100, (dof - odd) // 2 - 1
    nearest = min(last, int(half))
    for step in range(
        max(0, int(nearest - reach)), min(last, int(nearest + reach)) + 1
    ):
        order = step + odd / 2
        total += math.exp(order * math.log(half) - half - math.lgamma(order + 1))
    return min(total, 1.0)


def chi2_lower_tail(chi2: float, dof: float) -> float:
    """Compute the probability of a chi-square at most this large, with all digits (DLMF 8.11.4)."""
    if chi2 <= 0:
        return 0.0
    half, order = chi2 / 2, dof / 2
    term, total, step = 1.0, 1.0, order
    while term > 1e-16 * total:
        step += 1
        term *= half / step
        total += term
    return min(
        1.0, math.exp(order * math.log(half) - half - math.lgamma(order + 1)) * total
    )
