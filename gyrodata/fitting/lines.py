"""Straight lines: those of the textbook, and one through points with errors in both variables and any covariance.

The fits of the textbook are a line through the origin, a line with a constant, and the mean of the ratios. Each fits
one lab, or many labs of one design at once: x = φ̇ψ̇ [rad²/s²] and y = M [N*m] have shape (…, n), I_zz and u have shape
(…). The uncertainties come from the scatter, and the runs are taken as independent: NaN if no run is left over to show
a scatter. These fits know nothing of errors that runs share. They are there to compare with, and no answer may be far
from them.

`fit_line` is for errors in both variables. The observed x and y are true ones on the line plus errors B z, with z
independent standard normal numbers: U = B Bᵀ. Each step solves the conditions, linear about the *adjusted* points, for
the line that needs the smallest ‖z‖² (generalised least squares by orthogonal factors, after C. C. Paige, SIAM J.
Numer. Anal. 16, 1979). No matrix is inverted and no normal equations are formed, so that U may be singular or zero in
parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from gyrodata.fitting.adjustment import FACTOR, NoFit
from gyrodata.fitting.conditions import torques_differ, transverse_inertia
from gyrodata.fitting.inertia import FitResult
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats


def ordinary_line(x: Floats, y: Floats, intercept: bool) -> tuple[Floats, Floats, Floats, Floats]:
    """Fit y = slope·x (+ constant) to n points of each lab by ordinary least squares.

    Returns: slope, its u, constant and its u, each of shape (…). s² is the sum of squared residuals over the degrees of
    freedom; u is NaN without any, all is NaN if x does not determine the line. Without `intercept` the constant is 0
    and its u means nothing.
    """
    count = x.shape[-1]
    # The classical formulas about the means, which lose no digits if the points are far from zero.
    x_mean, y_mean = (intercept * np.add.reduce(each, axis=-1, keepdims=True) / count for each in (x, y))
    away, size = x - x_mean, np.sqrt(_dot(x, x))
    spread = np.sqrt(_dot(away, away))
    spread = np.where(spread > 1e-9 * size, spread, np.nan)
    slope = _dot(away, y - y_mean) / spread**2
    left, freedom = y - y_mean - slope[..., None] * away, count - 1 - intercept
    sd = np.sqrt(_dot(left, left) / freedom) if freedom > 0 else np.full_like(slope, np.nan)
    constant = y_mean[..., 0] - slope * x_mean[..., 0]
    return slope, sd / spread, constant, sd * size / (spread * math.sqrt(count))


def _dot(a: Floats, b: Floats) -> Floats:
    """Scalar product along the last axis."""
    return np.asarray((a[..., None, :] @ b[..., :, None])[..., 0, 0])


def mean_of_ratios(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Mean of y/x over the runs with a torque, and u, the standard error of that mean."""
    loaded = y[(0,) * (y.ndim - 1)] != 0
    ratios = y[..., loaded] / x[..., loaded]
    count = ratios.shape[-1]
    mean = np.add.reduce(ratios, axis=-1) / count
    squares = np.add.reduce((ratios - mean[..., None]) ** 2, axis=-1)
    return mean, np.sqrt(squares / (count - 1) / count) if count > 1 else np.full_like(mean, np.nan)


TEXTBOOK: Mapping[str, Callable[[Floats, Floats], tuple[Floats, Floats]]] = {
    "through_origin": lambda x, y: ordinary_line(x, y, intercept=False)[:2],
    "with_constant": lambda x, y: ordinary_line(x, y, intercept=True)[:2],
    "mean_of_ratios": mean_of_ratios,
}
"""The fits of the textbook by name: x and y to I_zz and u."""


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
    kinds = (False, True) if torques_differ(torque) else (False,)
    slopes = [float(ordinary_line(rate * spin, torque, intercept)[0]) for intercept in kinds]
    if not any(slope > 0 and 1 / FACTOR < fit.inertia.value / slope < FACTOR for slope in slopes):
        beside = " and ".join(f"{slope:.2g}" for slope in slopes if not math.isnan(slope)) or "nothing"
        raise NoFit(f"the fit gives {fit.inertia.value:.2g} kg*m^2, and the lines of the textbook {beside}")


STATED = (
    "errors in both variables with the stated covariances (ISO/TS 28037 generalised Gauss-Markov regression, York "
    "2004): derivatives at the adjusted points; standard uncertainties (k = 1) from the stated covariances, not "
    "scaled by chi-square"
)
SCATTER = (
    "ordinary least squares of y on x: no uncertainties stated, so x is taken as exact and y as equally uncertain in "
    "every point; standard uncertainties (k = 1) from the residuals, s² their sum of squares over dof"
)


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
        are allowed. If only some are given the others are zero; without any, x is taken as exact and the
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
    xs, ys = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    count, stated = xs.size, any(cov is not None for cov in (cov_x, cov_y, cov_xy))
    if xs.ndim != 1 or xs.shape != ys.shape:
        raise ValueError(f"x has shape {xs.shape} and y {ys.shape}; pass two sequences of the same length")
    if not (np.isfinite(xs).all() and np.isfinite(ys).all()):
        raise ValueError("x or y has a value that is not finite; leave out the points that are not complete")
    if count < 1 + intercept:
        raise ValueError(f"{count} points do not determine a line; pass two or more, or one with intercept=False")
    if intercept and np.ptp(xs) <= 1e-13 * np.abs(xs).max():
        raise ValueError("all x are equal, so slope and constant cannot be told apart; pass intercept=False or more x")
    if not xs.any():
        raise ValueError("all x are zero, so there is no slope; pass points away from the origin")
    if not stated and count == 1 + intercept:
        raise ValueError(f"{count} points leave no residual to take the uncertainties from; pass cov_y, or more points")
    factors = _factorise(cov_x, cov_y if stated else 1.0, cov_xy, count)
    # About the middle, slope and constant hardly depend on each other, and no digits cancel.
    middle = np.longdouble(xs.mean() if intercept else 0.0)
    unknowns, (_, errors, parts, dof, _) = _iterate(xs - middle, ys.astype(np.longdouble), factors, intercept)
    # Zeros for a constant that is not fitted.
    spread = np.vstack([parts, np.zeros_like(parts)])[:2]
    spread[1] -= float(middle) * spread[0]
    chi2 = float(np.sum(errors**2))
    covariance = spread @ spread.T * (1.0 if stated else chi2 / dof)
    u_slope, u_intercept = (math.sqrt(variance) for variance in np.diag(covariance))
    slope, constant = float(unknowns[0]), float(unknowns[1:].sum() - unknowns[0] * middle)
    p = chi2_tail(chi2, dof) if stated and dof > 0 else None
    told = covariance, chi2, dof, p, STATED if stated else SCATTER
    return LineFit(slope, constant, u_slope, u_intercept if intercept else None, *told)


Extended = NDArray[np.longdouble]
"""Extended precision if the machine has it: steps then refine the answer to the last digit of a double."""


class _Step(NamedTuple):
    """A linear least-squares problem solved."""

    change: Floats
    """Of slope and constant, shape (k,)."""
    errors: Floats
    """z of smallest norm, shape (m,)."""
    spread: Floats
    """Derivatives of the unknowns to independent standard normal numbers, shape (k, m): covariance S Sᵀ."""
    dof: int
    """Degrees of freedom."""
    off: float
    """Distance [y] that no z closes."""


def _iterate(x: Extended, y: Extended, factors: Factors, intercept: bool) -> tuple[Extended, _Step]:
    """Find the line by Gauss–Newton steps, each linear about the points adjusted by the one before."""
    to_x, to_y, by_row = factors
    design = np.ones((len(x), 1 + intercept))
    design[:, 0] = x
    unknowns = np.linalg.lstsq(design, y.astype(float), rcond=None)[0].astype(np.longdouble)
    last = math.inf
    for _turn in range(500):
        slope, constant = unknowns[0], unknowns[1:].sum()
        distance, pull = (y - constant - slope * x).astype(float), to_y - float(slope) * to_x
        if by_row:
            # A row's condition contains one sum of its two errors.
            size = np.hypot(pull[:, 0], pull[:, 1])
            step = _solve(design, size, distance)
            error = np.sum(to_x * pull, axis=1) / np.maximum(size, 1e-300) * step.errors
        else:
            step = _solve(design, pull, distance)
            error = to_x @ step.errors
        unknowns = unknowns + step.change
        moved = float(abs(step.change[0]) / (abs(unknowns[0]) + np.ptp(y) / np.abs(x).max() + 1e-300))
        if moved < 1e-17 or (moved < 1e-13 and moved >= 0.5 * last):
            break
        last = moved
        # Adjusted x, at which the next derivatives are taken.
        design[:, 0] = x - error
    else:
        raise ValueError("no line is found: the errors of x are too large for the spread of x; pass better points")
    if step.off > 1e-9 * float(np.abs(y).max()):
        raise ValueError("points without any error of their own are not on one line; pass their variances")
    return unknowns, step


def _solve(design: Floats, pull: Floats, distance: Floats) -> _Step:
    """Solve design·p + pull·z = distance for p and the smallest z, whatever the rank of pull, shape (n, m).

    A pull of shape (n,) is a diagonal matrix: without zeros, weights solve it. Otherwise, seen across the design (by
    the rest of its Q) only z is left: it is the smallest that closes the distance.
    """
    count, unknowns = design.shape
    if pull.ndim == 1 and (pull > 1e-9 * pull.max()).all():
        design, distance = design / pull[:, None], distance / pull
        q, r = np.linalg.qr(design)
        change = np.linalg.solve(r, q.T @ distance)
        return _Step(change, distance - design @ change, np.linalg.solve(r, q.T), count - unknowns, 0.0)
    pull = np.diag(pull) if pull.ndim == 1 else pull
    q, r = np.linalg.qr(design, mode="complete")
    along, across = q[:, :unknowns], q[:, unknowns:]
    left, sizes, right = np.linalg.svd(across.T @ pull, full_matrices=False)
    # A smaller singular value is a zero that was rounded.
    rank = int(np.sum(sizes > 1e-12 * np.linalg.norm(pull)))
    left, sizes, right = left[:, :rank], sizes[:rank], right[:rank]
    seen = across.T @ distance
    parts = left.T @ seen
    errors = right.T @ (parts / sizes)
    change = np.linalg.solve(r[:unknowns], along.T @ (distance - pull @ errors))
    # What errors do to the answer: those that the fit sees, it takes away again.
    through = along.T @ pull
    spread = np.linalg.solve(r[:unknowns], through - (through @ right.T) @ right)
    return _Step(change, errors, spread, rank, float(np.linalg.norm(seen - left @ parts)))


Factors = tuple[Floats, Floats, bool]
"""Errors of x and of y as factors times independent standard normal numbers z, and whether the rows are independent.

Independent rows have two numbers each: factors of shape (n, 2). Otherwise all rows share m: factors of shape (n, m).
"""


def _factorise(cov_x: ArrayLike | None, cov_y: ArrayLike | None, cov_xy: ArrayLike | None, count: int) -> Factors:
    """Check the covariance U of n points (x, y), and take it apart: U = B Bᵀ, singular parts included."""
    parts = []
    for name, value in (("cov_x", cov_x), ("cov_y", cov_y), ("cov_xy", cov_xy)):
        part = np.asarray(0.0 if value is None else value, dtype=float)
        part = np.full(count, part) if part.ndim == 0 else part
        if part.shape not in ((count,), (count, count)):
            raise ValueError(
                f"{name} has shape {part.shape}; pass a number, {count} variances, or a {count} × {count} matrix"
            )
        if not np.isfinite(part).all():
            raise ValueError(f"{name} has a value that is not finite; pass 0 for what is exact")
        if name != "cov_xy":
            variances = part if part.ndim == 1 else np.diag(part)
            if (variances < 0).any():
                raise ValueError(f"{name} has a negative variance; pass variances u², not below 0")
            if part.ndim == 2 and not np.allclose(part, part.T, rtol=1e-9, atol=1e-12 * variances.max()):
                raise ValueError(f"{name} is not symmetric; pass a covariance matrix, U[i, j] = U[j, i]")
        parts.append(part)
    if not any(part.any() for part in parts):
        raise ValueError("all covariances are zero; leave them out to have the uncertainties from the scatter")
    if any(part.ndim == 2 for part in parts):
        x, y, xy = (part if part.ndim == 2 else np.diag(part) for part in parts)
        factor = _root(np.block([[x, xy], [xy.T, y]]))
        return factor[:count], factor[count:], False
    x, y, xy = parts
    if (xy**2 > x * y * (1 + 1e-12)).any():
        raise ValueError("cov_xy is larger than √(cov_x·cov_y) in a row; no pair of errors has such a covariance")
    # Cholesky's factor of each row's 2 × 2 matrix.
    root, nothing = np.sqrt(x), np.zeros(count)
    along = np.divide(xy, root, out=nothing.copy(), where=root > 0)
    across = np.sqrt(np.maximum(y - along**2, 0.0))
    return np.column_stack([root, nothing]), np.column_stack([along, across]), True


def _root(matrix: Floats) -> Floats:
    """Find B with U = B Bᵀ, shape (2n, m); scaled to correlations first, so that no small variance drowns."""
    scale = np.sqrt(np.diag(matrix))
    divisor = np.where(scale > 0, scale, 1.0)
    correlation = (matrix + matrix.T) / 2 / np.outer(divisor, divisor)
    if correlation[scale == 0].any():
        raise ValueError("an error of variance 0 has a covariance with another; pass 0 for both, or its variance")
    values, vectors = np.linalg.eigh(correlation)
    if values[0] < -1e-9 * values[-1]:
        raise ValueError(
            "the covariances have a negative eigenvalue, so some sum of readings would have a negative variance; "
            "check the signs and sizes of the off-diagonal parts"
        )
    # What is left of a zero after rounding must not become an uncertainty of 1e-8.
    kept = values > 8 * len(values) * np.finfo(float).eps * values[-1]
    return np.asarray(scale[:, None] * vectors[:, kept] * np.sqrt(values[kept]))


@lru_cache(maxsize=64)
def chi2_tail(chi2: float, dof: int) -> float:
    """Probability of a chi-square at least this large: Q(dof/2, chi2/2), the regularised incomplete gamma function.

    For a whole or half argument it is a finite sum (DLMF 8.4.10 and 8.8.2), so twenty lines save the quarter
    of a second that importing scipy for it would cost at every start.
    """
    half, odd = chi2 / 2, dof % 2
    if half <= 0:
        return 1.0
    total = math.erfc(math.sqrt(half)) if odd else 0.0
    # Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1), in logarithms because e^-x alone underflows. What lies further than
    # this from the largest term, which is at a = x, adds nothing to sixteen digits.
    reach, last = 10 * math.sqrt(half) + 100, (dof - odd) // 2 - 1
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
    half, order = chi2 / 2, dof / 2
    term, total, step = 1.0, 1.0, order
    while term > 1e-16 * total:
        step += 1
        term *= half / step
        total += term
    return min(1.0, math.exp(order * math.log(half) - half - math.lgamma(order + 1)) * total)
