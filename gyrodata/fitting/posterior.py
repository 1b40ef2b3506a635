"""The posterior of I_zz, M0 and b, integrated over the widths of some errors.

A log contains only rough information about the widths of these errors.

These widths are described by two numbers with a prior that is the same for every
design:

* s, the factor on the errors of single runs: near 1, with long tails, especially if the
  log does not state ``u_time``. It is a Birge factor with a prior (Bodnar & Elster,
  Metrologia 51, 516, 2014);
* w, the width of M0: distributed so that M0 has a Cauchy distribution with the scale
  `BALANCE` times the smallest torque. A balance test is evidence about M0 that may be
  false (`TOO_BOLD`).

For given s and w the adjusted conditions are linear and normal, and the prior of I_zz
is flat. Shared errors and b are eliminated by a rotation that is the same for all s: n
runs become a few numbers, and each s and w needs only a few operations. The weights are
the marginal likelihoods with both determinants (of the readings' covariance and, as in
REML, of the unknowns') times the priors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import cast

import numpy as np
from msgspec import Struct

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

SPREAD_DEFAULT, SPREAD_STATED = math.log(3.75), math.log(2.5)
"""Standard deviation of ln s if ``u_time`` is a default, and if the log states it."""

SHARE_OF_TAIL, TAIL = 0.05, math.log(5.0)
"""Share and scale of the wide tails of ln s, a Cauchy distribution."""

STEPS = 20
"""Number of factors s."""

ENDS = np.log([0.25, 20.0])
"""Logarithms of the smallest and the largest factor s in the first round."""

EVENLY = np.linspace(0.0, 1.0, STEPS)

MAX_SPREADS = 10
"""Largest number of rounds in which the range of the factors changes."""

WIDTHS = np.exp(np.linspace(math.log(0.03), math.log(100.0), 18))
"""Widths of M0 over the scale of its prior."""

CHANCES = -np.log(WIDTHS) - 0.5 / WIDTHS**2
"""Logarithm of the probability of each: with it, the mixture of normal distributions is
a Cauchy distribution."""
CHANCES -= math.log(np.exp(CHANCES).sum())

STEP = math.log(100.0 / 0.03) / 17
"""Difference of the logarithms of two widths."""

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
    evidence: float
    """Logarithm of the likelihood of the whole model, up to a constant."""

    def quantiles(self, unknowns: int = 1) -> Floats:
        """Compute the quantiles at `LEVELS` of the first unknowns of I_zz, M0 and b.

        Shape (unknowns, 5).

        Newton's method with brackets.
        """
        weight, mean, u = self.weight, self.mean[:unknowns], self.u[:unknowns]
        if len(weight) > HEAVIEST:
            # Parts with almost no weight are ignored.
            heavy = np.argpartition(weight, -HEAVIEST)[-HEAVIEST:]
            total = np.add.reduce(weight[heavy])
            if total > 1 - LIGHT:
                weight, mean, u = weight[heavy] / total, mean[:, heavy], u[:, heavy]
        centre = (mean @ weight)[:, None]
        sd = np.sqrt((u**2 + (mean - centre) ** 2) @ weight)[:, None]
        # Cantelli's inequality limits the distance of a quantile from the mean for
        # every distribution.
        reach = sd * np.sqrt(1 / np.minimum(LEVELS, 1 - LEVELS))
        low, high = centre - reach, centre + reach
        point: Floats = centre + sd * NORMAL
        # Exact values get a tiny uncertainty.
        size = np.maximum(np.maximum(u, 1e-6 * sd), 1e-300)[:, None, :]
        close = 1e-3 * np.minimum(LEVELS, 1 - LEVELS)
        steep, centres = weight / (size * math.sqrt(2 * math.pi)), mean[:, None, :]
        for _turn in range(40):
            # Far away the density is zero; the limit avoids an overflow of the square.
            away = np.clip((point[..., None] - centres) / size, -40.0, 40.0)
            square = np.exp(-0.5 * away * away)
            off = _normal_below(away, square) @ weight - LEVELS
            np.copyto(low, point, where=off < 0)
            np.copyto(high, point, where=off > 0)
            step = point - off / np.maximum(
                np.add.reduce(steep * square, axis=-1), 1e-300
            )
            inside = (step >= low) & (step <= high)
            point = np.where(inside, step, 0.5 * (low + high))
            # The error after such a step is about the square of the step.
            if (inside & (np.abs(off) <= close)).all():
                break
        return point

    def typical_widths(self) -> tuple[float, float]:
        """Return a typical s, and the width of M0 that represents all widths.

        This width alone gives u(I_zz) of all widths with this s.
        """
        # The parts are sorted by s; each s has the same number of widths.
        each = self.weight.reshape(STEPS, -1)
        count = each.shape[1]
        factor = math.exp(float(self.weight @ np.log(self.factor)))
        most = np.maximum.reduce(each, axis=1)
        away = np.abs(np.log(self.factor[::count] / factor))
        at = int(np.where(most > 1e-6 * np.maximum.reduce(most), away, np.inf).argmin())
        nearest, weight = (
            slice(at * count, (at + 1) * count),
            each[at] / np.add.reduce(each[at]),
        )
        u = self.u[0, nearest]
        part = Posterior(
            weight, self.mean[:1, nearest], u[None], self.factor, self.factor, 0.0
        )
        _, below, _, above, _ = part.quantiles()[0]
        order = u.argsort()
        widths = np.log(self.width[nearest][order])
        return factor, float(np.exp(np.interp((above - below) / 2, u[order], widths)))


def integrate(
    conditions: Conditions, scale: float, stated: bool, tested: float | None = None
) -> Posterior:
    """Compute the posterior: every s and w with a weight for its agreement with the runs.

    Parameters
    ----------
    conditions : Conditions
    scale : float
        Scale of M0's Cauchy prior [unit of M0].
    stated : bool
        Whether the log states the uncertainty of its times.
    tested : float, optional
        Width of M0 from a balance test [unit of M0].

    Returns
    -------
    Posterior
        I_zz [kg*m^2], M0 [N*m] and b [s].
    """
    widths, prior = balance_prior(scale, tested)
    shared, rows, slope = _rotate(conditions)
    # Products of the columns I, M0, b and misclosure, in each row.
    products = (rows[:, :, None] * rows[:, None, :]).reshape(-1, 16)
    narrow, (ended, at, _) = 1 / widths**2, conditions.ended
    low, high = ENDS
    for turn in range(MAX_SPREADS):
        logarithm, spacing = low + (high - low) * EVENLY, (high - low) / (STEPS - 1)
        factor = np.exp(logarithm)
        variance = factor[:, None] ** 2 + shared**2
        sums = ((1 / variance) @ products).T[..., None]
        ii, im, ib, i_left, mm, mb, m_left, bb, b_left, chi2 = sums[
            [0, 1, 2, 3, 5, 6, 7, 10, 11, 15]
        ]
        # Solve for `both` = I_zz + slope M0 and for M0; arrays of shape (S, W) from
        # here on.
        mm, m_w = mm + narrow, m_left - at * narrow
        # By rounding the difference can be zero or negative.
        determinant = np.maximum(ii * mm - im**2, 1e-15 * ii * mm)
        both = (mm * i_left - im * m_w) / determinant
        residual_torque = (ii * m_w - im * i_left) / determinant
        misfit = chi2 + at * at * narrow - both * i_left - residual_torque * m_w
        # Rows without information have the variance s².
        spread = -0.5 * np.add.reduce(np.log(variance), axis=1) - (
            conditions.runs - len(rows)
        ) * np.log(factor)
        whole = spread[:, None] - 0.5 * (np.log(determinant / narrow) + misfit) + prior
        whole += (scatter_prior(logarithm, stated) + math.log(spacing))[:, None]
        top = np.maximum.reduce(whole, axis=None)
        weight = np.exp(whole - top)
        total = np.add.reduce(weight, axis=None)
        weight /= total
        of_factor = np.add.reduce(weight, axis=1)
        centre = of_factor @ logarithm
        sd = math.sqrt(of_factor @ (logarithm - centre) ** 2)
        # With many runs the steps can be too wide for s; with very bad runs s can be
        # above the range.
        if turn == MAX_SPREADS - 1 or not (sd < 1.2 * spacing or of_factor[-1] > 1e-3):
            break
        if sd < 1.2 * spacing:
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
    # One part for each pair of s and w.
    factor, unit = np.repeat(factor, len(widths)), conditions.unit[:, None]
    width = (np.ones((STEPS, 1)) * (widths * conditions.unit[1])).reshape(-1)
    mean, u = mean.reshape(3, -1) * unit, u.reshape(3, -1) * unit
    return Posterior(
        weight.reshape(-1), mean, u, factor, width, float(top + math.log(total))
    )


def _rotate(conditions: Conditions) -> tuple[Floats, Floats, float]:
    """Rotate the conditions so that shared errors, including b, do not correlate two rows.

    Returns
    -------
    tuple of ndarray, ndarray and float
        The shared error of each of m rows, so that its variance is s² plus the square
        of this error, shape (m,); derivatives with respect to I_zz + slope M0, M0 and
        b, and the misclosure, shape (m, 4); and the slope, which makes the first two
        unknowns nearly independent.
    """
    count = conditions.shared.shape[1] + 1
    bias = conditions.unknowns[:, 2:]
    # Relative to b = 0, the centre of its prior.
    target = bias * conditions.ended[2] - conditions.left[:, None]
    rows: Floats = np.concatenate(
        [conditions.shared, bias, conditions.unknowns, target], axis=1
    )
    if rows.shape[0] > rows.shape[1]:
        rows = np.asarray(np.linalg.qr(rows, mode="r"))
    turn, values, _ = np.linalg.svd(rows[:, :count])
    size = np.zeros(len(rows))
    size[: len(values)] = values
    rotated = turn.T @ rows[:, count:]
    own, with_m0 = rotated[:, 0] / (conditions.scatter**2 + size**2) @ rotated[:, :2]
    slope = float(with_m0 / own)
    rotated[:, 1] -= slope * rotated[:, 0]
    return size, rotated, slope


def mixed(posteriors: Sequence[Posterior]) -> Posterior:
    """Combine the posteriors of several models of one log, each with the weight of its evidence."""
    evidence = np.array([float(one.evidence) for one in posteriors])
    chance = np.exp(evidence - evidence.max())
    chance /= chance.sum()
    shares = zip(chance, posteriors, strict=True)
    parts = [
        [share * one.weight, one.mean, one.u, one.factor, one.width]
        for share, one in shares
    ]
    weight, mean, u, factor, width = (
        np.concatenate(column, axis=-1) for column in zip(*parts, strict=True)
    )
    return Posterior(weight, mean, u, factor, width, evidence.max())


def balance_prior(scale: float, tested: float | None) -> tuple[Floats, Floats]:
    """Return widths of M0, shape (W,), and the logarithm of the probability of each."""
    widths = scale * WIDTHS
    if tested is None:
        return widths, CHANCES
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


HEAVIEST, LIGHT = 160, 1e-4
"""This number of parts is enough for the quantiles if the weight of all others is less
than this."""

K_95 = 1.959963984540054
"""Coverage factor of the 95 % interval of a normal distribution."""

NORMAL = np.array([-K_95, -1.0, 0.0, 1.0, K_95])
"""Quantiles at `LEVELS` of a standard normal distribution."""


def _normal_below(x: Floats, square: Floats) -> Floats:
    """Compute the probability that a standard normal number is below x, to 1.2e-7 of the tail.

    `square` is exp(−x²/2). Approximation of erfc by Chebyshev's polynomials (W. H.
    Press et al., Numerical Recipes, section 6.2); the import of `scipy.special` would
    take as long as the whole analysis.
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
    # The probability of the tail beyond x.
    tail = np.multiply(t, square, out=t)
    tail *= np.exp(series, out=series)
    tail *= 0.5
    np.subtract(1, tail, out=tail, where=x > 0)
    return tail


ERFC = (
    0.17087277,
    -0.82215223,
    1.48851587,
    -1.13520398,
    0.27886807,
    -0.18628806,
    0.09678418,
    0.37409196,
    1.00002368,
    -1.26551223,
)
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
