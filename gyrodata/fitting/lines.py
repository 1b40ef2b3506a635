"""A straight line through points with errors in both variables.

The observed points are true points on the line plus errors B z, with z independent
standard normal numbers and the covariance U = B Bᵀ. Each step solves the conditions,
linear about the *adjusted* points, for the line with the smallest ‖z‖² (generalised
least squares). A rotation makes the errors of the conditions independent; conditions
without an error are constraints. No matrix is inverted, so that U may be singular.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike, NDArray

from gyrodata.base.errors import insist_on_type
from gyrodata.fitting.posterior import chi2_tail
from gyrodata.physics import Floats

STATED = (
    "errors in both variables (ISO/TS 28037, York 2004); standard uncertainties (k = 1) "
    "from the stated covariances, not scaled by chi-square"
)
SCATTER = "ordinary least squares of y on x; standard uncertainties (k = 1) from the residuals"


class LineFit(Struct, frozen=True, eq=False):
    """The straight line y = slope·x + intercept of n points."""

    slope: float
    """[unit of y over unit of x]"""
    intercept: float
    """[unit of y]; 0 for a line through the origin."""
    u_slope: float
    """Standard uncertainty, k = 1."""
    u_intercept: float | None
    """Standard uncertainty, k = 1; None for a line through the origin."""
    covariance: Floats
    """Covariance of (slope, intercept), shape (2, 2); zeros for a line through the
    origin."""
    chi2: float
    """Smallest sum of squared standardised errors; without covariances the sum of
    squared residuals [y²]."""
    dof: int
    """Degrees of freedom."""
    p: float | None
    """Probability of a chi-square at least this large; None without stated covariances
    or degrees of freedom."""
    convention: str
    """Description of the method and of the uncertainties."""

    def __str__(self) -> str:
        from uncertainties import ufloat

        line = f"y = ({ufloat(self.slope, self.u_slope):.2uP}) x"
        if self.u_intercept is not None:
            line += f" + ({ufloat(self.intercept, self.u_intercept):.2uP})"
        quality = f"chi-square {self.chi2:.3g} with {self.dof} degrees of freedom"
        return f"{line}, {quality}"


def fit_line(
    x: ArrayLike,
    y: ArrayLike,
    cov_x: ArrayLike | None = None,
    cov_y: ArrayLike | None = None,
    cov_xy: ArrayLike | None = None,
    *,
    intercept: bool = True,
) -> LineFit:
    """Fit a straight line to points with errors in both variables and any covariance.

    Parameters
    ----------
    x, y : array_like, shape (n,)
        Points, in any units.
    cov_x, cov_y : array_like, optional
        Covariance of the errors of x [x²], of y [y²]: a number or shape (n,) for
        *variances* u² (not standard uncertainties) of independent errors, shape (n, n)
        for a covariance matrix. Zeros and singular matrices are allowed. If only some
        are given, the others are zero; without any, x is exact and the residuals give
        the uncertainties.
    cov_xy : array_like, optional
        Covariance [x·y] of the errors of x and y: a number or shape (n,) within each
        row, shape (n, n) between error i of x and error j of y.
    intercept : bool
        Whether the line has an intercept; otherwise it goes through the origin.

    Returns
    -------
    LineFit

    Raises
    ------
    ValueError
        If the points do not determine the line or its uncertainty (too few, all x
        equal, not finite), if a covariance is invalid, or if exact points are not on a
        line.

    Notes
    -----
    ISO/TS 28037:2010 clause 10 (and York, Evensen, Martínez López and Delgado, Am. J.
    Phys. 72, 367, 2004, for independent points): ‖z‖² is smallest over the line and all
    true points; uncertainties use derivatives at the adjusted points, not at the
    observed ones.
    """
    insist_on_type("intercept", intercept, bool, "True or False")
    xs = np.asarray(x, dtype=float)
    ys = np.asarray(y, dtype=float)
    stated = any(cov is not None for cov in (cov_x, cov_y, cov_xy))
    _insist_on_points(xs, ys, intercept, stated)
    factors = _factorise(cov_x, cov_y if stated else 1.0, cov_xy, xs.size)
    # Relative to the mean of x, slope and intercept are nearly independent, and no
    # digits are lost.
    middle = np.longdouble(xs.mean() if intercept else 0.0)
    extended_y = ys.astype(np.longdouble)
    unknowns, step = _iterate(xs - middle, extended_y, factors, intercept)
    # Zeros for an intercept that is not fitted.
    spread = np.zeros((2, step.spread.shape[1]))
    spread[: len(step.spread)] = step.spread
    spread[1] -= float(middle) * spread[0]
    chi2 = float(np.sum(step.errors**2))
    dof = step.dof
    variance = 1.0 if stated else chi2 / dof
    covariance = spread @ spread.T * variance
    u_slope, u_intercept = np.sqrt(np.diag(covariance)).tolist()
    at_middle = unknowns[1:].sum()
    return LineFit(
        slope=float(unknowns[0]),
        intercept=float(at_middle - unknowns[0] * middle),
        u_slope=u_slope,
        u_intercept=u_intercept if intercept else None,
        covariance=covariance,
        chi2=chi2,
        dof=dof,
        p=chi2_tail(chi2, dof) if stated and dof > 0 else None,
        convention=STATED if stated else SCATTER,
    )


def _insist_on_points(xs: Floats, ys: Floats, intercept: bool, stated: bool) -> None:
    """Raise ValueError if points do not determine a line and its uncertainty."""
    if xs.ndim != 1 or xs.shape != ys.shape:
        raise ValueError(
            f"x has shape {xs.shape} and y {ys.shape}; "
            "pass two sequences of the same length"
        )
    if not (np.isfinite(xs).all() and np.isfinite(ys).all()):
        raise ValueError(
            "x or y contains a value that is not finite; leave out incomplete points"
        )
    needed = 1 + intercept + (not stated)
    if xs.size < needed:
        raise ValueError(
            f"{xs.size} points do not determine a line, or leave no residuals for its "
            f"uncertainty; pass {needed} points or more"
        )
    largest = np.abs(xs).max()
    extent = np.ptp(xs) if intercept else largest
    if extent <= 1e-13 * largest:
        raise ValueError(
            "all x are equal, or all x are zero without an intercept, so there is no "
            "slope; pass points with other x"
        )


Extended = NDArray[np.longdouble]
"""Extended precision, if the machine has it, for the last digit of a double."""


EXACT = 1e-12
"""Smallest standard uncertainty of a condition over the largest one."""


class _Step(NamedTuple):
    """The solution of a linear least-squares problem."""

    change: Floats
    """Change of slope and intercept, shape (k,)."""
    errors: Floats
    """The smallest z, shape (m,)."""
    spread: Floats
    """Derivatives S of the unknowns with respect to z, shape (k, m); the covariance is
    S Sᵀ."""
    dof: int
    """Degrees of freedom."""
    off: float
    """Distance [y] that remains for every z."""


def _iterate(
    x: Extended, y: Extended, factors: Factors, intercept: bool
) -> tuple[Extended, _Step]:
    """Find the line by Gauss–Newton steps.

    Each step is linear about the points that the previous step adjusted.
    """
    to_x, to_y, by_row = factors
    design = np.ones((len(x), 1 + intercept))
    design[:, 0] = x
    start, *_ = np.linalg.lstsq(design, y.astype(float), rcond=None)
    unknowns = start.astype(np.longdouble)
    last = math.inf
    for _turn in range(500):
        slope = unknowns[0]
        constant = unknowns[1:].sum()
        distance = (y - constant - slope * x).astype(float)
        pull = to_y - float(slope) * to_x
        if by_row:
            # A row's condition contains one sum of its two errors.
            sizes = np.hypot(pull[:, 0], pull[:, 1])
            step = _solve(design, sizes, distance)
            covariance = np.sum(to_x * pull, axis=1)
            error = covariance / np.maximum(sizes, 1e-300) * step.errors
        else:
            turn, sizes, right = np.linalg.svd(pull, full_matrices=False)
            step = _solve(turn.T @ design, sizes, turn.T @ distance)
            error = to_x @ (right.T @ step.errors)
        unknowns = unknowns + step.change
        steepest = np.ptp(y) / np.abs(x).max()
        size = abs(unknowns[0]) + steepest + 1e-300
        moved = float(abs(step.change[0]) / size)
        # Rounding prevents smaller steps. The first step is never the last one: its
        # derivatives are those at the measured x, and the start may satisfy them.
        if moved < 1e-13 and moved >= 0.5 * last:
            break
        last = moved
        # The next derivatives are computed at the adjusted x.
        design[:, 0] = x - error
    else:
        raise ValueError(
            "the fit does not converge: the errors of x are too large; "
            "pass better points"
        )
    if step.off > 1e-9 * float(np.abs(y).max()):
        raise ValueError("exact points are not on one line; pass their variances")
    return unknowns, step


def _solve(design: Floats, sizes: Floats, distance: Floats) -> _Step:
    """Solve design·p + sizes·z = distance for p and the smallest z, shape (n,).

    A condition whose size is zero, but for rounding, is a constraint. The constraints
    determine a part of p; `free` contains the directions in which it can still change.
    """
    is_exact = sizes <= EXACT * sizes.max()
    constraints = design[is_exact]
    change, _, rank, _ = np.linalg.lstsq(constraints, distance[is_exact], rcond=EXACT)
    _, _, directions = np.linalg.svd(constraints)
    free = directions[rank:].T
    remaining = distance - design @ change
    weight = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=~is_exact)
    weighted = weight[:, None] * design
    q, r = np.linalg.qr(weighted @ free)
    spread = free @ np.linalg.solve(r, q.T)
    change = change + spread @ (weight * remaining)
    errors = weight * distance - weighted @ change
    dof = int(np.sum(~is_exact)) - free.shape[1]
    off = float(np.linalg.norm(remaining[is_exact]))
    return _Step(change, errors, spread, dof, off)


Factors = tuple[Floats, Floats, bool]
"""Factors B of the errors B z of x and of y, and whether the rows are independent.

Independent rows have two numbers z each: factors of shape (n, 2). Otherwise all rows
share m: shape (n, m). """


def _factorise(
    cov_x: ArrayLike | None,
    cov_y: ArrayLike | None,
    cov_xy: ArrayLike | None,
    count: int,
) -> Factors:
    """Check the covariance U of n points (x, y), and factorise it: U = B Bᵀ."""
    x = _covariance("cov_x", cov_x, count)
    y = _covariance("cov_y", cov_y, count)
    xy = _covariance("cov_xy", cov_xy, count)
    for name, part in (("cov_x", x), ("cov_y", y)):
        _insist_on_variances(name, part)
    if not (x.any() or y.any() or xy.any()):
        raise ValueError(
            "all covariances are zero; "
            "leave them out to get the uncertainties from the scatter"
        )
    by_row = x.ndim == y.ndim == xy.ndim == 1
    if by_row:
        root = _root(np.array([[x, xy], [xy, y]]).T)
        return root[:, 0], root[:, 1], by_row
    x, y, xy = [part if part.ndim == 2 else np.diag(part) for part in (x, y, xy)]
    root = _root(np.block([[x, xy], [xy.T, y]]))
    return root[:count], root[count:], by_row


def _covariance(name: str, value: ArrayLike | None, count: int) -> Floats:
    """Return a covariance of n points as an array of shape (n,) or (n, n)."""
    part = np.asarray(0.0 if value is None else value, dtype=float)
    if part.ndim == 0:
        part = np.full(count, part)
    if part.shape not in ((count,), (count, count)):
        wanted = f"pass a number, {count} variances, or a {count} × {count} matrix"
        raise ValueError(f"{name} has shape {part.shape}; {wanted}")
    if not np.isfinite(part).all():
        raise ValueError(
            f"{name} contains a value that is not finite; pass 0 for exact values"
        )
    return part


def _insist_on_variances(name: str, part: Floats) -> None:
    """Raise ValueError if a covariance of one variable is not a possible one."""
    variances = part if part.ndim == 1 else np.diag(part)
    if (variances < 0).any():
        raise ValueError(f"{name} contains a negative variance; pass variances u²")
    close = 1e-12 * variances.max()
    is_symmetric = np.allclose(part, part.T, rtol=1e-9, atol=close)
    if not is_symmetric:
        raise ValueError(
            f"{name} is not symmetric; pass a covariance matrix, U[i, j] = U[j, i]"
        )


def _root(matrix: Floats) -> Floats:
    """Find B with U = B Bᵀ, of one covariance matrix or of many, shape (…, m, m).

    B is computed from the correlations, so that small variances keep their digits.
    """
    variances = np.diagonal(matrix, axis1=-2, axis2=-1)
    scale = np.sqrt(variances)
    divisor = np.where(scale > 0, scale, 1.0)
    transposed = np.swapaxes(matrix, -2, -1)
    symmetric = (matrix + transposed) / 2
    rows = divisor[..., None]
    columns = divisor[..., None, :]
    correlation = symmetric / (rows * columns)
    if correlation[scale == 0].any():
        raise ValueError(
            "an error with variance 0 has a covariance with another; pass 0 for both"
        )
    values, vectors = np.linalg.eigh(correlation)
    largest = values[..., -1:]
    if (values < -1e-9 * largest).any():
        raise ValueError(
            "the covariance matrix has a negative eigenvalue: "
            "a covariance is larger than the variances allow; "
            "check the signs and sizes of the off-diagonal elements"
        )
    # A rounded zero must not become an uncertainty of 1e-8.
    rounding = np.finfo(float).eps * largest
    limit = 8 * values.shape[-1] * rounding
    sizes = np.sqrt(np.where(values > limit, values, 0.0))
    scaled = scale[..., None] * vectors
    return np.asarray(scaled * sizes[..., None, :])
