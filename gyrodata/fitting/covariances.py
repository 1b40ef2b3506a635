"""What a caller may say of the errors of x and y, checked, and taken apart into factors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gyrodata.physics import Floats

_EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True)
class Factors:
    """Errors of n points as factors times independent standard normal numbers z.

    Where the rows are independent each has its own two numbers: factors of shape (n, 2), z of shape (n, 2).
    Otherwise all share m: factors of shape (n, m), z of shape (m,).
    """

    to_x: Floats
    to_y: Floats
    independent: bool


def factorise(cov_x: ArrayLike | None, cov_y: ArrayLike | None, cov_xy: ArrayLike | None, count: int) -> Factors:
    """Take the covariance U of n points (x, y) apart: U = B Bᵀ, singular parts included.

    Parameters
    ----------
    cov_x, cov_y, cov_xy : array_like or None
        Scalar, shape (n,) or shape (n, n); None is zero.
    count : int
        n.

    Returns
    -------
    Factors

    Raises
    ------
    ValueError
        If one has another shape, is not finite, not symmetric, or the whole is not a covariance.
    """
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
    if (scale > 0).all():
        try:
            lower: Floats = np.linalg.cholesky(correlation)
        except np.linalg.LinAlgError:
            pass
        else:
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
