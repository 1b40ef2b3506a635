"""Straight lines: those of the textbook, and one through points with errors in both variables and any covariance.

The fits of the textbook are a line through the origin, one with a constant, and the mean of the ratios; each is for one
lab or for many of one design, stacked: x = φ̇ψ̇ [rad²/s²] and y = M [N*m] of shape (…, n), the answer I_zz and u of
shape (…). Uncertainties are from the scatter, runs taken as independent; NaN where nothing is left to tell them. These
know nothing of shared errors: they are there to compare with, and no answer may be far from them.

`fit_line` is for errors in both variables. The observed x and y are true ones on the line plus errors B z, z
independent standard normal numbers: U = B Bᵀ. Each step solves the conditions, linear about the *adjusted* points, for
the line that needs the smallest ‖z‖² (generalised least squares by orthogonal factors, after C. C. Paige, SIAM J.
Numer. Anal. 16, 1979). No matrix is inverted and no normal equations are formed, so that U may be singular or zero in
parts.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from functools import lru_cache

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from gyrodata.fitting.adjustment import FACTOR, NoFit
from gyrodata.fitting.conditions import torques_differ, transverse_inertia
from gyrodata.fitting.inertia import Estimate, FitResult
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats


def through_origin(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Least squares of y = slope·x: slope and u, s² being the sum of squared residuals over n − 1."""
    slope, sd, spread = _line(x, y, 1)
    return slope, sd / spread


def with_constant(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Least squares of y = slope·x + constant: slope and u, s² being the sum of squared residuals over n − 2.

    The classical formulas about the means, which lose no digits where the points are far from zero.
    """
    count = x.shape[-1]
    x, y = (values - np.add.reduce(values, axis=-1, keepdims=True) / count for values in (x, y))
    slope, sd, spread = _line(x, y, 2)
    return slope, sd / spread


def _line(x: Floats, y: Floats, unknowns: int) -> tuple[Floats, Floats, Floats]:
    """Slope through the origin, standard deviation of the residuals, and √Σx²."""
    spread = np.sqrt(_dot(x, x))
    slope: Floats = _dot(x, y) / spread**2
    freedom = x.shape[-1] - unknowns
    if freedom <= 0:
        return slope, np.full_like(slope, np.nan), spread
    left = y - slope[..., None] * x
    return slope, np.sqrt(_dot(left, left) / freedom), spread


def _dot(a: Floats, b: Floats) -> Floats:
    """Scalar product along the last axis."""
    product: Floats = (a[..., None, :] @ b[..., :, None])[..., 0, 0]
    return product


def mean_of_ratios(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Mean of y/x over the runs with a torque, and u, the standard error of that mean."""
    loaded = y[(0,) * (y.ndim - 1)] != 0
    ratios = y[..., loaded] / x[..., loaded]
    count = ratios.shape[-1]
    mean = np.add.reduce(ratios, axis=-1) / count
    if count < 2:
        return mean, np.full_like(mean, np.nan)
    away = ratios - mean[..., None]
    return mean, np.sqrt(np.add.reduce(away * away, axis=-1) / (count - 1) / count)


TEXTBOOK: Mapping[str, Callable[[Floats, Floats], tuple[Floats, Floats]]] = {
    "through_origin": through_origin,
    "with_constant": with_constant,
    "mean_of_ratios": mean_of_ratios,
}
"""The fits of the textbook by name."""


class Line(Struct, frozen=True):
    """Ordinary least squares of y on x, uncertainties from the scatter."""

    slope: Estimate
    intercept: Estimate | None


def ordinary_line(x: Floats, y: Floats, intercept: bool) -> Line | None:
    """Fit y = slope·x (+ intercept) to n points; None where x does not determine the unknowns."""
    x_mean, y_mean = (float(x.mean()), float(y.mean())) if intercept else (0.0, 0.0)
    count, size = len(x), math.sqrt(x @ x)
    if np.linalg.norm(x - x_mean) <= 1e-9 * size:
        return None
    slope, sd, spread = (float(value) for value in _line(x - x_mean, y - y_mean, 1 + intercept))
    told = not math.isnan(sd)
    constant = None
    if intercept:
        u = sd * size / (spread * math.sqrt(count)) if told else None
        constant = Estimate(y_mean - slope * x_mean, u)
    return Line(Estimate(slope, sd / spread if told else None), constant)


def insist_on_lines(measured: Measurements, fit: FitResult, tilted: bool, kept: Floats) -> None:
    """Accept a fit within a factor of `FACTOR` of a line, corrected for tilt and release, or raise `NoFit`."""
    index = np.flatnonzero(kept)
    rate = fit.sense[index] * 2 * np.pi * measured.turns[index] / measured.time[index]
    if measured.slowing is not None:
        rate = rate * measured.slowing[index]
    spin, torque = measured.spin[index], measured.torque[index]
    if tilted:
        # Eq. (8) as a line: M + I φ̇² cosθ against φ̇ (ψ̇ + φ̇ cosθ).
        height = np.sin(measured.pitch[index])
        torque = torque + transverse_inertia(measured)[index] * rate**2 * height
        spin = spin + rate * height
    slopes = []
    for intercept in (False, True) if torques_differ(torque) else (False,):
        line = ordinary_line(rate * spin, torque, intercept)
        if line is not None:
            slopes.append(line.slope.value)
            # One of them is enough.
            if slopes[-1] > 0 and 1 / FACTOR < fit.inertia.value / slopes[-1] < FACTOR:
                return
    beside = " and ".join(f"{slope:.2g}" for slope in slopes) or "nothing"
    raise NoFit(f"the fit gives {fit.inertia.value:.2g} kg*m^2, and the lines of the textbook {beside}")


Extended = NDArray[np.longdouble]

STATED = (
    "errors in both variables with the stated covariances (ISO/TS 28037 generalised Gauss-Markov regression, York "
    "2004): derivatives at the adjusted points; standard uncertainties (k = 1) from the stated covariances, not "
    "scaled by chi-square"
)
SCATTER = (
    "ordinary least squares of y on x: no uncertainties stated, so x is taken as exact and y as equally uncertain in "
    "every point; standard uncertainties (k = 1) from the residuals, s² their sum of squares over dof"
)

_SINGULAR = 1e-12
"""Below this part of the largest, a singular value is a zero that was rounded."""

_OFF = 1e-9
"""Exact points are on a line if no further off than this part of the largest y."""


class LineFit(Struct, frozen=True, eq=False):
    """The straight line y = slope·x + intercept of n points."""

    slope: float
    """[unit of y over unit of x]"""
    intercept: float
    """[unit of y]; 0 where the line was asked to go through the origin."""
    u_slope: float
    """Standard uncertainty, k = 1."""
    u_intercept: float | None
    """Standard uncertainty, k = 1; None for a line through the origin."""
    covariance: Floats
    """Of (slope, intercept), shape (2, 2); zeros for what was not fitted."""
    chi2: float
    """Smallest sum of squared standardised errors; without stated covariances the residual sum of squares [y²]."""
    dof: int
    """Degrees of freedom."""
    p: float | None
    """Probability of a chi-square at least this large; None without stated covariances or degrees of freedom."""
    convention: str
    """What was minimised and where the uncertainties come from, in words."""


class _Step(Struct, frozen=True):
    """A linear least-squares problem solved."""

    change: Floats
    """Of slope and intercept, shape (k,)."""
    errors: Floats
    """z of smallest norm."""
    spread: Floats
    """Derivatives of the unknowns to independent standard normal numbers, shape (k, m): covariance S Sᵀ."""
    rank: int
    """Degrees of freedom."""
    off: float
    """Distance [y] that no z closes."""


def fit_line(
    x: ArrayLike,
    y: ArrayLike,
    cov_x: ArrayLike | None = None,
    cov_y: ArrayLike | None = None,
    cov_xy: ArrayLike | None = None,
    intercept: bool = True,
) -> LineFit:
    """Fit a straight line to points with errors in both variables and any covariance.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        Points, in any units.
    cov_x, cov_y : array_like, optional
        Covariance of the errors of x [x²], of y [y²]: a number or shape (n,) for *variances* u² (not standard
        uncertainties) of independent errors, shape (n, n) for a covariance matrix. Zeros and singular matrices
        are allowed. Where only some are given the others are zero; without any, x is taken as exact and the
        residuals give the uncertainties.
    cov_xy : array_like, optional
        Covariance [x·y] of the errors of x and y: a number or shape (n,) within each row, shape (n, n) between
        error i of x and error j of y.
    intercept : bool
        Whether the line has a constant; without, it goes through the origin.

    Returns
    -------
    LineFit

    Raises
    ------
    ValueError
        If the points do not determine the line or its uncertainty (too few, all x equal, not finite), if a
        covariance is not one, or if points without any error are not on a line.

    Notes
    -----
    ISO/TS 28037:2010 clause 10 (and York, Evensen, Martínez López and Delgado, Am. J. Phys. 72, 367, 2004, for
    independent points): ‖z‖² is smallest over the line and all true points; uncertainties use derivatives at the
    adjusted points, not at the observed ones.
    """
    observed_x, observed_y = _points(x, y, intercept)
    stated = any(cov is not None for cov in (cov_x, cov_y, cov_xy))
    if not stated and len(observed_x) <= 1 + intercept:
        raise ValueError(
            f"{len(observed_x)} points leave no residual to take the uncertainties from; pass cov_y, or more points"
        )
    factors = factorise(cov_x, cov_y if stated else 1.0, cov_xy, len(observed_x))
    # About the middle, slope and constant hardly depend on each other, and no digits cancel.
    middle = np.longdouble(observed_x.mean()) if intercept else np.longdouble(0)
    slope, constant, step = _iterate(observed_x - middle, observed_y.astype(np.longdouble), factors, intercept)
    spread = np.zeros((2, step.spread.shape[1]))
    spread[: len(step.spread)] = step.spread
    if intercept:
        spread[1] -= float(middle) * spread[0]
    chi2 = float(np.sum(step.errors**2))
    covariance = spread @ spread.T * (1.0 if stated else chi2 / step.rank)
    return LineFit(
        slope=float(slope),
        intercept=float(constant - slope * middle) if intercept else 0.0,
        u_slope=math.sqrt(covariance[0, 0]),
        u_intercept=math.sqrt(covariance[1, 1]) if intercept else None,
        covariance=covariance,
        chi2=chi2,
        dof=step.rank,
        p=chi2_tail(chi2, step.rank) if stated and step.rank > 0 else None,
        convention=STATED if stated else SCATTER,
    )


def _points(x: ArrayLike, y: ArrayLike, intercept: bool) -> tuple[Floats, Floats]:
    """Check that the points are points and determine a line."""
    xs, ys = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if xs.ndim != 1 or xs.shape != ys.shape:
        raise ValueError(f"x has shape {xs.shape} and y {ys.shape}; pass two sequences of the same length")
    if not (np.isfinite(xs).all() and np.isfinite(ys).all()):
        raise ValueError("x or y has a value that is not finite; leave out the points that are not complete")
    if len(xs) < 1 + intercept:
        raise ValueError(f"{len(xs)} points do not determine a line; pass two or more, or one with intercept=False")
    if intercept and np.ptp(xs) <= 1e-13 * np.abs(xs).max():
        raise ValueError("all x are equal, so slope and constant cannot be told apart; pass intercept=False or more x")
    if not xs.any():
        raise ValueError("all x are zero, so there is no slope; pass points away from the origin")
    return xs, ys


def _iterate(x: Extended, y: Extended, factors: Factors, intercept: bool) -> tuple[np.longdouble, np.longdouble, _Step]:
    """Find the line by Gauss–Newton steps, each linear about the points adjusted by the one before."""
    count = len(x)
    design = np.ones((count, 1 + intercept))
    design[:, 0] = x
    start = np.linalg.lstsq(design, y.astype(float), rcond=None)[0]
    # Extended precision where the machine has it: steps then refine the answer to the last digit of a double.
    slope, constant = np.longdouble(start[0]), np.longdouble(start[1] if intercept else 0.0)
    last = math.inf
    for _turn in range(500):
        distance = np.asarray(y - constant - slope * x, dtype=float)
        pull = factors.to_y - float(slope) * factors.to_x
        step = _solve_rows(design, pull, distance) if factors.independent else _solve(design, pull, distance)
        slope = slope + step.change[0]
        constant = constant + (step.change[1] if intercept else 0.0)
        moved = float(abs(step.change[0]) / (abs(slope) + np.ptp(y) / np.abs(x).max() + 1e-300))
        if moved < 1e-17 or (moved < 1e-13 and moved >= 0.5 * last):
            break
        last = moved
        # Adjusted x, at which the next derivatives are taken.
        errors = np.sum(factors.to_x * step.errors, axis=1) if factors.independent else factors.to_x @ step.errors
        design[:, 0] = x - errors
    else:
        raise ValueError("no line is found: the errors of x are too large for the spread of x; pass better points")
    if step.off > _OFF * float(np.abs(y).max()):
        raise ValueError("points without any error of their own are not on one line; pass their variances")
    return slope, constant, step


def _solve_rows(design: Floats, pull: Floats, distance: Floats) -> _Step:
    """Solve design·p + pull·z = distance for independent rows: by weights; exact rows go the general way."""
    size = np.hypot(pull[:, 0], pull[:, 1])
    if not (size > 1e-9 * size.max()).all():
        return _spread_out(pull, _solve(design, np.diag(size), distance), size)
    q, r = np.linalg.qr(design / size[:, None])
    scaled = distance / size
    change = np.linalg.solve(r, q.T @ scaled)
    left = scaled - (design / size[:, None]) @ change
    return _Step(change, pull * (left / size)[:, None], np.linalg.solve(r, q.T), len(left) - len(change), 0.0)


def _spread_out(pull: Floats, step: _Step, size: Floats) -> _Step:
    """Give each row's one error back to the two that it stands for."""
    shares = np.divide(pull, size[:, None], out=np.zeros_like(pull), where=size[:, None] > 0)
    return _Step(step.change, shares * step.errors[:, None], step.spread, step.rank, step.off)


def _solve(design: Floats, pull: Floats, distance: Floats) -> _Step:
    """Solve design·p + pull·z = distance for p and the smallest z, whatever the rank of pull.

    Seen across the design (by the rest of its Q) only z is left: it is the smallest that closes the distance.
    """
    unknowns = design.shape[1]
    q, r = np.linalg.qr(design, mode="complete")
    along, across = q[:, :unknowns], q[:, unknowns:]
    left, sizes, right = np.linalg.svd(across.T @ pull, full_matrices=False)
    rank = int(np.sum(sizes > _SINGULAR * np.linalg.norm(pull)))
    left, sizes, right = left[:, :rank], sizes[:rank], right[:rank]
    seen = across.T @ distance
    parts = left.T @ seen
    errors = right.T @ (parts / sizes)
    change = np.linalg.solve(r[:unknowns], along.T @ (distance - pull @ errors))
    # What errors do to the answer: those that the fit sees, it takes away again.
    through = along.T @ pull
    spread = np.linalg.solve(r[:unknowns], through - (through @ right.T) @ right)
    return _Step(change, errors, spread, rank, float(np.linalg.norm(seen - left @ parts)))


_EPS = float(np.finfo(float).eps)


class Factors(Struct, frozen=True):
    """Errors of n points as factors times independent standard normal numbers z.

    Where the rows are independent each has its own two numbers: factors of shape (n, 2), z of shape (n, 2).
    Otherwise all share m: factors of shape (n, m), z of shape (m,).
    """

    to_x: Floats
    to_y: Floats
    independent: bool


def factorise(cov_x: ArrayLike | None, cov_y: ArrayLike | None, cov_xy: ArrayLike | None, count: int) -> Factors:
    """Check the covariance U of n points (x, y), and take it apart: U = B Bᵀ, singular parts included."""
    x, y, xy = (
        _checked(value, name, count) for value, name in ((cov_x, "cov_x"), (cov_y, "cov_y"), (cov_xy, "cov_xy"))
    )
    for name, matrix in (("cov_x", x), ("cov_y", y)):
        variances = matrix if matrix.ndim == 1 else np.diag(matrix)
        if (variances < 0).any():
            raise ValueError(f"{name} has a negative variance; pass variances u², not below 0")
        if matrix.ndim == 2 and not np.allclose(matrix, matrix.T, rtol=1e-9, atol=1e-12 * variances.max()):
            raise ValueError(f"{name} is not symmetric; pass a covariance matrix, U[i, j] = U[j, i]")
    if not any(part.any() for part in (x, y, xy)):
        raise ValueError("all covariances are zero; leave them out to have the uncertainties from the scatter")
    if x.ndim == y.ndim == xy.ndim == 1:
        return _by_row(x, y, xy)
    full_x, full_y, full_xy = (part if part.ndim == 2 else np.diag(part) for part in (x, y, xy))
    factor = _root(np.block([[full_x, full_xy], [full_xy.T, full_y]]))
    return Factors(factor[:count], factor[count:], independent=False)


def _checked(value: ArrayLike | None, name: str, count: int) -> Floats:
    """Give a covariance as a vector of what each row has, or as a matrix."""
    array = np.zeros(count) if value is None else np.asarray(value, dtype=float)
    if array.ndim == 0:
        array = np.full(count, float(array))
    if array.shape not in ((count,), (count, count)):
        raise ValueError(
            f"{name} has shape {array.shape}; pass a number, {count} variances, or a {count} × {count} matrix"
        )
    if not np.isfinite(array).all():
        raise ValueError(f"{name} has a value that is not finite; pass 0 for what is exact")
    return array


def _by_row(x: Floats, y: Floats, xy: Floats) -> Factors:
    """Cholesky's factor of each row's 2 × 2 matrix."""
    if (xy**2 > x * y * (1 + 1e-12)).any():
        raise ValueError("cov_xy is larger than √(cov_x·cov_y) in a row; no pair of errors has such a covariance")
    root = np.sqrt(x)
    along = np.divide(xy, root, out=np.zeros_like(x), where=root > 0)
    nothing = np.zeros_like(x)
    across = np.sqrt(np.maximum(y - along**2, 0.0))
    return Factors(np.column_stack([root, nothing]), np.column_stack([along, across]), independent=True)


def _root(matrix: Floats) -> Floats:
    """Find B with U = B Bᵀ, shape (2n, m); scaled to correlations first, so that no small variance drowns."""
    matrix = (matrix + matrix.T) / 2
    scale = np.sqrt(np.diag(matrix))
    divisor = np.where(scale > 0, scale, 1.0)
    correlation = matrix / np.outer(divisor, divisor)
    if correlation[scale == 0].any():
        raise ValueError("an error of variance 0 has a covariance with another; pass 0 for both, or its variance")
    # Without a variance, or with one error that is made of others, there is no such factor.
    with contextlib.suppress(np.linalg.LinAlgError):
        lower: Floats = np.linalg.cholesky(correlation)
        if np.diag(lower).min() > 1e-6:
            return scale[:, None] * lower
    values, vectors = np.linalg.eigh(correlation)
    if values[0] < -1e-9 * values[-1]:
        raise ValueError(
            "the covariances have a negative eigenvalue, so some sum of readings would have a negative variance; "
            "check the signs and sizes of the off-diagonal parts"
        )
    # What is left of a zero after rounding must not become an uncertainty of 1e-8.
    kept = values > 8 * len(values) * _EPS * values[-1]
    root: Floats = scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    return root


@lru_cache(maxsize=64)
def chi2_tail(chi2: float, dof: int) -> float:
    """Probability of a chi-square at least this large: Q(dof/2, chi2/2), the regularised incomplete gamma function.

    For a whole or half argument it is a finite sum (DLMF 8.4.10 and 8.8.2), so twenty lines save the quarter
    of a second that importing scipy for it would cost at every start.
    """
    half = chi2 / 2
    if half <= 0:
        return 1.0
    odd = dof % 2
    total = math.erfc(math.sqrt(half)) if odd else 0.0
    # Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1), in logarithms because e^-x alone underflows. What lies further than
    # this from the largest term, which is at a = x, adds nothing to sixteen digits.
    reach = 10 * math.sqrt(half) + 100
    last = (dof - odd) // 2 - 1
    nearest = min(last, int(half))
    for step in range(max(0, int(nearest - reach)), min(last, int(nearest + reach)) + 1):
        order = step + odd / 2
        total += math.exp(order * math.log(half) - half - math.lgamma(order + 1))
    return min(total, 1.0)


def chi2_lower_tail(chi2: float, dof: float) -> float:
    """Probability of a chi-square at most this large.

    Gives: P(dof/2, chi2/2), the regularised lower incomplete gamma function, by its series (DLMF 8.11.4), which keeps
    all digits of a tiny probability.
    """
    if chi2 <= 0:
        return 0.0
    order, half = dof / 2, chi2 / 2
    term = total = 1.0
    step = order
    while term > 1e-16 * total:
        step += 1
        term *= half / step
        total += term
    return min(1.0, math.exp(order * math.log(half) - half - math.lgamma(order + 1)) * total)
