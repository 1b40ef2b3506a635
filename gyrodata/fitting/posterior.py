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

import numpy as np
from msgspec import Struct

from gyrodata.fitting.adjustment import Widths
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

CHANGE = 0.03
"""Scale of v's half-Cauchy prior over the lightest torque [1], if M0 differs between
weights. Published logs prefer 0.01 to 0.02; a little more covers labs with 0.15."""

UNTOUCHED = 0.5
"""Probability that M0 does not differ between weights, if the log does not say: five of
14 published logs clearly show a difference."""

CHANGES = CHANGE * np.exp(np.linspace(-1.5, 2.2, 6))
"""Widths v above zero, over the lightest torque [1]."""

SPREAD_DEFAULT = math.log(3.75)
SPREAD_STATED = math.log(2.5)
"""Standard deviation of ln s if ``u_time`` is a default, and if the log states it."""

SHARE_OF_TAIL = 0.05
TAIL = math.log(5.0)
"""Share and scale of the wide tails of ln s, a Cauchy distribution."""

STEPS = 14
"""Number of factors s."""

ENDS = np.log([0.25, 20.0])
"""Logarithms of the smallest and the largest factor s in the first round."""

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

NARROWEST = 2e-8
"""Smallest width of a balance test, over the scale of M0's prior."""

TESTED_WIDTHS = np.exp(STEP * np.arange(-40, 1))
"""Widths of M0 with a test, over the largest one without."""

LEVELS = np.array([0.025, 0.158655253931457, 0.5, 0.841344746068543, 0.975])
"""Quantiles: the ends of the 95 % interval and of the 68 % interval, and the median."""


class Conditions(Struct, frozen=True):
    """The conditions of n runs, linear at the end of a fit.

    Each condition is divided by the width of its independent errors.

    Unknowns and errors are differences from the end of the fit: I_zz over its start, M0
    [N*m], b and the shared errors in their standard uncertainties.
    """

    unknowns: Floats
    """Derivatives with respect to I_zz, M0 and b, shape (n, 3)."""
    shared: Floats
    """Derivatives with respect to the K shared errors, shape (n, K)."""
    levels: Floats
    """Derivatives with respect to the difference of M0 of each weight [1/(N*m)], shape
    (n, J)."""
    days: Floats
    """Derivatives with respect to the differences of M0 between D + 1 days [1/(N*m)],
    which have the width of M0, shape (n, D)."""
    left: Floats
    """Misclosure if all shared errors are zero, shape (n,)."""
    ended: Floats
    """I_zz, M0 and b at the end of the fit, in the units `unit`, shape (3,)."""
    unit: Floats
    """Units of I_zz [kg*m^2], M0 [N*m] and b [s], shape (3,)."""
    runs: float
    """Number of runs that are used."""
    scatter: float
    """Factor s on the independent errors in the fit."""


class Posterior(Struct, frozen=True):
    """A mixture of N normal distributions of I_zz, M0 and b."""

    weight: Floats
    """Weight of each part, shape (N,); the sum is 1."""
    mean: Floats
    """Mean of I_zz [kg*m^2], M0 [N*m] and b [s] in each part, shape (3, N)."""
    u: Floats
    """Standard deviations of the same, shape (3, N)."""
    factor: Floats
    """s of each part [1], shape (N,)."""
    width: Floats
    """Width of M0 in each part [N*m], shape (N,)."""
    level: Floats
    """v of each part [N*m], shape (N,)."""
    evidence: float
    """Logarithm of the likelihood of the whole model, up to a constant."""

    def quantiles(self, number: int = 0) -> Floats:
        """Compute the quantiles at `LEVELS` of I_zz, M0 or b, shape (5,)."""
        return _quantiles(self.weight, self.mean[number], self.u[number])

    def typical_widths(self) -> Widths:
        """Return a typical s, width of M0 and v: the weighted means of all parts."""
        factor = math.exp(self.weight @ np.log(self.factor))
        width = math.exp(self.weight @ np.log(self.width))
        return Widths(factor, width, float(self.weight @ self.level))

    def chance_of_one_balance(self) -> float:
        """Return the probability that M0 is the same with every weight."""
        return float(self.weight @ (self.level == 0))


def integrate(
    conditions: Conditions,
    balance: tuple[Floats, Floats],
    changes: tuple[Floats, Floats],
    stated: bool,
) -> Posterior:
    """Compute the posterior: all s, v and w, weighted by how they fit the runs.

    Parameters
    ----------
    conditions : Conditions
    balance : tuple of ndarray
        Widths of M0 [N*m], and the logarithm of the probability of each, as from
        `balance_prior`.
    changes : tuple of ndarray
        The same for the difference of M0 between weights, as from `level_prior`.
    stated : bool
        Whether the log states the uncertainty of its times.

    Returns
    -------
    Posterior
        I_zz [kg*m^2], M0 [N*m] and b [s].
    """
    widths, ln_of_width = balance
    levels, ln_of_level = changes
    ln_prior = ln_of_level[:, None, None] + ln_of_width
    shared, rows, slope = _rotate(conditions, levels, widths)
    low, high = ENDS
    for _round in range(MAX_SPREADS):
        logarithm, spacing = np.linspace(low, high, STEPS, retstep=True)
        factor = np.exp(logarithm)
        solution = _solve(conditions, widths, factor, shared, rows)
        ln_of_factor = scatter_prior(logarithm, stated) + math.log(spacing)
        ln_weight = solution.log_likelihood + ln_prior + ln_of_factor[:, None]
        top = ln_weight.max()
        weight = np.exp(ln_weight - top)
        total = weight.sum()
        weight /= total
        weight_of_factor = weight.sum(axis=(0, 2))
        centre = weight_of_factor @ logarithm
        sd = math.sqrt(weight_of_factor @ (logarithm - centre) ** 2)
        if sd < FINE * spacing:
            # With many runs the steps can be too wide for s.
            half = max(sd, 0.5 * spacing)
            low = centre - 6 * half
            high = centre + 6 * half
        elif weight_of_factor[-1] > 1e-3:
            # With very bad runs s can be above the range.
            high += 4.0
        else:
            break
    # One part for each s, v and w, without those of no weight.
    heavy = weight > LIGHT / weight.size
    mean, u = solution.of_unknowns(slope)
    unit = conditions.unit[:, None]
    inertia, m0, _ = conditions.ended
    start = np.array([[inertia], [m0], [0.0]])
    parts = np.broadcast_arrays(factor[:, None], levels[:, None, None], widths)
    factors, level, width = parts
    weight = weight[heavy]
    return Posterior(
        weight=weight / weight.sum(),
        mean=(start + mean[:, heavy]) * unit,
        u=u[:, heavy] * unit,
        factor=factors[heavy],
        width=width[heavy],
        level=level[heavy],
        evidence=float(top + math.log(total)),
    )


class _Solution(Struct, frozen=True):
    """The solution for each v, s and w: arrays of shape (V, S, W), or (V, S, 1).

    The unknowns are `both` = I_zz + slope M0, and M0; b follows from them.
    """

    log_likelihood: Floats
    both: Floats
    """Mean, minus the value at the end of the fit [1]."""
    m0: Floats
    """Mean, minus the value at the end of the fit [N*m]."""
    covariance: tuple[Floats, Floats, Floats]
    """Variance of `both`, covariance of both unknowns, variance of M0."""
    of_bias: tuple[Floats, ...]
    """Sums of the products of b with `both`, M0, b and the misclosure."""

    def of_unknowns(self, slope: Floats) -> tuple[Floats, Floats]:
        """Return the means of I_zz, M0 and b, and their standard deviations."""
        both_var, cov, m_var = self.covariance
        ib, mb, bb, b_left = self.of_bias
        # b follows from its prior and the rows, for given I_zz and M0.
        explained = ib * self.both + mb * self.m0
        bias = b_left - explained
        b_alone = 1 - bb
        of_both = ib**2 * both_var
        of_torque = mb**2 * m_var
        b_var = b_alone + of_both + 2 * ib * mb * cov + of_torque
        i_var = both_var - 2 * slope * cov + slope**2 * m_var
        of_m0 = slope * self.m0
        inertia = self.both - of_m0
        mean = np.array([inertia, self.m0, bias])
        return mean, np.sqrt(np.maximum([i_var, m_var, b_var], 0.0))


def _solve(
    conditions: Conditions,
    widths: Floats,
    factor: Floats,
    shared: Floats,
    rows: Floats,
) -> _Solution:
    """Solve the rotated conditions for `both` and M0, for each v, s and w.

    `rows` contains the derivatives to `both`, M0 and b, and the misclosure, as from
    `_rotate`. The page "statistics" derives the sums.
    """
    variance = factor[:, None] ** 2 + shared[:, :, None] ** 2
    # All products of two of the four columns.
    products = rows[..., :, None] * rows[..., None, :]
    products = products.reshape(*shared.shape, 16)
    sums = ((1 / variance) @ products).swapaxes(1, 2)
    normal = np.moveaxis(sums, 3, 0).reshape(4, 4, *sums.shape[:3])
    (ii, im, ib, i_left), (_, mm, mb, m_left), (_, _, bb, b_left), (*_, chi2) = normal
    narrow = 1 / widths**2
    at = conditions.ended[1]
    mm = mm + narrow
    m_left = m_left - at * narrow
    # By rounding the difference can be zero or negative.
    rounding = 1e-15 * ii * mm
    determinant = np.maximum(ii * mm - im**2, rounding)
    both = (mm * i_left - im * m_left) / determinant
    m0 = (ii * m_left - im * i_left) / determinant
    of_start = chi2 + at**2 * narrow
    misfit = of_start - both * i_left - m0 * m_left
    # Rows without information have the variance s².
    empty = conditions.runs - rows.shape[2]
    of_empty = 2 * empty * np.log(factor)
    of_rows = np.log(variance).sum(axis=-1)
    ln_variance = of_rows + of_empty
    ln_unknowns = np.log(determinant / narrow)
    log_likelihood = -0.5 * (ln_variance.swapaxes(1, 2) + ln_unknowns + misfit)
    covariance = mm / determinant, -im / determinant, ii / determinant
    of_bias = ib, mb, bb, b_left
    return _Solution(log_likelihood, both, m0, covariance, of_bias)


def _rotate(
    conditions: Conditions, levels: Floats, widths: Floats
) -> tuple[Floats, Floats, Floats]:
    """Rotate the conditions until shared errors and b do not correlate two rows.

    Parameters
    ----------
    conditions : Conditions
    levels : ndarray, shape (V,)
        Widths of the difference of M0 between weights [N*m].
    widths : ndarray, shape (W,)
        Widths of M0 [N*m]. They count only if M0 differs between days; else the
        results are the same for all of them, and W is 1 below.

    Returns
    -------
    tuple of ndarray
        For each v and w: the shared error of each of m rows, so that its variance is s²
        plus the square of this error, shape (V, W, m); derivatives with respect to
        I_zz + slope M0, M0 and b, and the misclosure, shape (V, W, m, 4); and the
        slope, which makes the first two unknowns nearly independent, shape (V, 1, W).
    """
    several = conditions.levels.shape[1]
    known = several + conditions.days.shape[1]
    count = known + conditions.shared.shape[1] + 1
    bias = conditions.unknowns[:, 2:]
    # Relative to b = 0, the centre of its prior.
    of_bias = bias * conditions.ended[2]
    target = of_bias - conditions.left[:, None]
    of_errors = conditions.levels, conditions.days, conditions.shared, bias
    rows: Floats = np.concatenate([*of_errors, conditions.unknowns, target], axis=1)
    if rows.shape[0] > rows.shape[1]:
        rows = np.asarray(np.linalg.qr(rows, mode="r"))
    each = widths if known > several else widths[:1]
    pairs = len(levels), len(each)
    errors = np.tile(rows[:, :count], (*pairs, 1, 1))
    errors[..., :several] *= levels[:, None, None, None]
    errors[..., several:known] *= each[:, None, None]
    turn, values, _ = np.linalg.svd(errors)
    size = np.zeros((*pairs, len(rows)))
    size[..., : values.shape[2]] = values
    rotated = turn.swapaxes(2, 3) @ rows[:, count:]
    weight = 1 / (conditions.scatter**2 + size**2)
    to_inertia = rotated[..., 0]
    # Weighted sums of the derivatives to I_zz, times those to I_zz and to M0.
    sums = "vwm,vwm,vwmk->kvw"
    own, with_m0 = np.einsum(sums, weight, to_inertia, rotated[..., :2])
    slope = with_m0 / own
    rotated[..., 1] -= slope[..., None] * to_inertia
    return size, rotated, slope[:, None]


def mixed(posteriors: Sequence[Posterior]) -> Posterior:
    """Combine the posteriors of several models of a log, weighted by evidence."""
    evidence = np.array([float(part.evidence) for part in posteriors])
    chance = np.exp(evidence - evidence.max())
    chance /= chance.sum()
    shares = zip(chance, posteriors, strict=True)
    fields = {"weight": np.concatenate([share * part.weight for share, part in shares])}
    for name in ("mean", "u", "factor", "width", "level"):
        values = [getattr(part, name) for part in posteriors]
        fields[name] = np.concatenate(values, axis=-1)
    return Posterior(**fields, evidence=evidence.max())


def level_prior(untouched: float, lightest: float) -> tuple[Floats, Floats]:
    """Return widths v and the logarithm of the probability of each, shape (V,).

    The widths have the unit of the lightest torque.

    v is zero with the probability `untouched`; else it has a half-Cauchy distribution.
    """
    # The density of ln v.
    density = 1 / (CHANGES / CHANGE + CHANGE / CHANGES)
    of_changes = (1 - untouched) * density / density.sum()
    chance = np.append(untouched, of_changes)
    is_possible = chance > 0
    widths = lightest * np.append(0.0, CHANGES)
    return widths[is_possible], np.log(chance[is_possible])


def balance_prior(
    scale: float, tested: float | None, tails: bool = True
) -> tuple[Floats, Floats]:
    """Return widths of M0, shape (W,), and the logarithm of the probability of each.

    Parameters
    ----------
    scale : float
        Scale of M0's Cauchy prior [N*m].
    tested : float, optional
        Width of M0 from a balance test [N*m].
    tails : bool
        Whether M0 can be much larger than its scale.
    """
    if tested is not None:
        width = max(tested, NARROWEST * scale)
        return _tested_prior(scale * WIDTHS, width * FALSE_WIDTHS)
    selected = slice(None) if tails else WIDTHS < NOT_FALSE
    return scale * WIDTHS[selected], CHANCES[selected]


def _tested_prior(widths: Floats, tested: Floats) -> tuple[Floats, Floats]:
    """Multiply the prior of M0 with the evidence of a balance test.

    The test is a Cauchy distribution too, a mixture of normal distributions. The
    product of two normal distributions is normal: all products are represented by fewer
    widths.
    """
    factors, chance = TOO_BOLD
    bold = np.log(FALSE_WIDTHS[:, None] / factors)
    # Each factor gives a Cauchy distribution.
    narrowed = np.exp(-2 * bold)
    density = np.exp(-bold - 0.5 * narrowed)
    doubt = np.log(density @ chance)
    prior = widths[:, None] ** 2
    test = tested**2
    both = prior + test
    ln_overlap = -0.5 * np.log(both)
    ln_weight = CHANCES[:, None] + doubt + ln_overlap
    mass = np.exp(ln_weight - ln_weight.max())
    width = np.sqrt(prior * test / both)
    grid = widths[-1] * TESTED_WIDTHS
    last = len(grid) - 1
    distance = np.log(width / grid[0])
    place = np.clip(distance / STEP, 0.0, last)
    # Each mass is divided between the two nearest widths.
    away = np.abs(place[..., None] - np.arange(last + 1))
    share = np.maximum(1 - away, 0.0)
    onto = np.tensordot(mass, share)
    with np.errstate(divide="ignore"):
        return grid, np.log(onto)


def doubt_of_widths(stated: bool) -> float:
    """Return by what factor errors of single runs can be larger than stated."""
    return math.exp(SPREAD_STATED if stated else SPREAD_DEFAULT)


def scatter_prior(factor: Floats, stated: bool) -> Floats:
    """Compute the logarithm of the prior density of ln s."""
    spread = SPREAD_STATED if stated else SPREAD_DEFAULT
    away = factor / spread
    normal = np.exp(-0.5 * away**2)
    near = (1 - SHARE_OF_TAIL) * normal / (spread * math.sqrt(math.tau))
    square = (factor / TAIL) ** 2
    cauchy = math.pi * TAIL * (1 + square)
    far = SHARE_OF_TAIL / cauchy
    density: Floats = near + far
    return np.log(density)


CLOSE = 1e-9
"""Largest error of a probability before the last step; Newton's method squares it."""

LIGHT = 1e-3
"""Parts that have less weight than this together are left out."""

NORMAL = np.array([-1.96, -1.0, 0.0, 1.0, 1.96])
"""Quantiles at `LEVELS` of a standard normal distribution, nearly."""


def _quantiles(weight: Floats, mean: Floats, u: Floats) -> Floats:
    """Compute the quantiles at `LEVELS` of a mixture of N normal distributions.

    Newton's method with brackets; `weight`, `mean` and `u` have the shape (N,).
    """
    centre = mean @ weight
    second_moments = u**2 + (mean - centre) ** 2
    sd = np.sqrt(second_moments @ weight)
    # Cantelli's inequality limits the distance of a quantile from the mean for every
    # distribution.
    reach = sd / np.sqrt(np.minimum(LEVELS, 1 - LEVELS))
    low = centre - reach
    high = centre + reach
    point: Floats = centre + sd * NORMAL
    # Exact values get a tiny uncertainty.
    size = np.maximum(u, 1e-6 * sd + 1e-300)
    steep = weight / (size * math.sqrt(math.tau))
    for _turn in range(60):
        away = (point[:, None] - mean) / size
        square = np.exp(-0.5 * away**2)
        off = _normal_below(away, square) @ weight - LEVELS
        low = np.where(off <= 0, point, low)
        high = np.where(off >= 0, point, high)
        density = np.maximum(square @ steep, 1e-300)
        step = point - off / density
        inside = (step >= low) & (step <= high)
        point = np.where(inside, step, 0.5 * (low + high))
        if np.abs(off).max() < CLOSE:
            break
    return point


def _normal_below(x: Floats, square: Floats) -> Floats:
    """Compute the probability that a standard normal number is below x, to 7.5e-8.

    `square` is exp(−x²/2). Approximation 26.2.17 of M. Abramowitz and I. A. Stegun,
    Handbook of Mathematical Functions; the import of `scipy.special` would take as long
    as the whole analysis.
    """
    t = 1 / (1 + 0.2316419 * np.abs(x))
    # The probability of the tail beyond x.
    tail = square * t * np.polyval(TAIL_SERIES, t)
    return np.where(x > 0, 1 - tail, tail)


TAIL_SERIES = np.array(
    [1.330274429, -1.821255978, 1.781477937, -0.356563782, 0.319381530]
) / math.sqrt(math.tau)
"""Coefficients, the highest power first."""


# --- chi-square ---


def chi2_tail(chi2: float, dof: int) -> float:
    """Compute the probability of a chi-square at least this large: Q(dof/2, chi2/2).

    A finite sum for a whole or half argument (DLMF 8.4.10 and 8.8.2); the import of
    scipy would take 0.25 s.
    """
    half = chi2 / 2
    odd = dof % 2
    if half <= 0:
        return 1.0
    total = math.erfc(math.sqrt(half)) if odd else 0.0
    # Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1), in logarithms because e^-x alone
    # underflows.
    for step in range(dof // 2):
        order = step + odd / 2
        ln_term = order * math.log(half) - half - math.lgamma(order + 1)
        total += math.exp(ln_term)
    return min(total, 1.0)
