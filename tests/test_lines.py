"""Straight lines with errors in both variables: published answers, exact arithmetic, other programs, refusals."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest

from gyrodata import LineFit, fit_line

YORK_X = np.array([0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4])
YORK_Y = np.array([5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5])
XS, YS = [1, 2, 3], [1, 2, 4]
YORK_U2X = 1 / np.array([1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0])
YORK_U2Y = 1 / np.array([1.0, 1.8, 4.0, 8.0, 20, 20, 70, 70, 100, 500])


def test_agrees_with_gtc() -> None:
    from GTC import type_a, type_b, uncertainty, ureal, value

    u_x, u_y = np.sqrt(YORK_U2X), np.sqrt(YORK_U2Y)
    line = fit_line(YORK_X, YORK_Y, YORK_U2X, YORK_U2Y)
    oracle = type_a.line_fit_wtls(list(YORK_X), list(YORK_Y), list(u_x), list(u_y))
    assert line.slope == pytest.approx(value(oracle.a_b[1]), rel=1e-7)
    assert line.intercept == pytest.approx(value(oracle.a_b[0]), rel=1e-7)
    assert line.chi2 == pytest.approx(oracle.ssr, rel=1e-7)
    # Without errors in x and with uncertain numbers for y its propagation is the whole of the covariance.
    propagated = type_b.line_fit_wls(
        [float(x) for x in YORK_X], [ureal(*pair) for pair in zip(YORK_Y, u_y, strict=True)]
    )
    plain = fit_line(YORK_X, YORK_Y, cov_y=YORK_U2Y)
    assert plain.u_slope == pytest.approx(uncertainty(propagated.a_b[1]), rel=1e-12)
    assert plain.u_intercept == pytest.approx(uncertainty(propagated.a_b[0]), rel=1e-12)


def agrees_with_exact_arithmetic(
    line: LineFit, x: np.ndarray, y: np.ndarray, U: np.ndarray, constant: bool = True
) -> None:
    """Fit the same line with 50 digits, by another way: weights from the inverse of the conditions' covariance."""
    n = len(x)
    with mpmath.workdps(50):
        xs, ys, full = (mpmath.matrix(values.tolist()) for values in (x, y, U))
        ux, uy, uxy = full[:n, :n], full[n:, n:], full[:n, n:]
        p = mpmath.matrix([mpmath.mpf(float(np.polyfit(x, y, 1)[0])), 0][: 1 + constant])
        true = xs.copy()
        for _ in range(200):
            design = mpmath.matrix([[true[i], 1][: 1 + constant] for i in range(n)])
            b = p[0]
            inverse = mpmath.inverse(uy + b * b * ux - b * (uxy + uxy.T))
            rest = ys - b * xs - (p[1] if constant else 0) * mpmath.ones(n, 1)
            normal = mpmath.inverse(design.T * inverse * design)
            step = normal * (design.T * inverse * rest)
            p += step
            left = rest - design * step
            true = xs - (uxy - b * ux) * (inverse * left)
            if mpmath.norm(step) < mpmath.mpf(10) ** -40:
                break
        chi2 = (left.T * inverse * left)[0]
        found, expected = [line.slope, line.u_slope], [p[0], mpmath.sqrt(normal[0, 0])]
        if constant:
            found += [line.intercept, line.u_intercept, line.covariance[0, 1]]
            expected += [p[1], mpmath.sqrt(normal[1, 1]), normal[0, 1]]
    assert found == pytest.approx([float(value) for value in expected], rel=1e-13)
    assert line.chi2 == pytest.approx(float(chi2), rel=1e-12)


def correlated(seed: int, constant: bool = True) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nine points and a full covariance: errors of their own, and three that all share in different measure."""
    random, n = np.random.default_rng(seed), 9
    shared = random.standard_normal((2 * n, 3))
    U = 0.01 * (np.diag(random.uniform(0.5, 2, 2 * n)) + 0.5 * shared @ shared.T)
    errors, truth = np.linalg.cholesky(U) @ random.standard_normal(2 * n), np.linspace(1, 9, n)
    return truth + errors[:n], 1.7 * truth + (4 if constant else 0) + errors[n:], U


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("constant", [True, False])
def test_full_covariances_agree_with_exact_arithmetic(seed: int, constant: bool) -> None:
    x, y, U = correlated(seed, constant)
    line = fit_line(x, y, U[:9, :9], U[9:, 9:], U[:9, 9:], intercept=constant)
    agrees_with_exact_arithmetic(line, x, y, U, constant)
    assert line.dof == 8 - constant


def test_singular_covariances_agree_with_exact_arithmetic() -> None:
    # One ruler for all x, an exact y, the rest alone.
    random, n = np.random.default_rng(4), 8
    x, variances = np.linspace(1, 8, n), np.array([0.0, 0.04, 0.04, 0.09, 0.04, 0.01, 0.04, 0.04])
    y = 2.5 * x + 1 + np.sqrt(variances) * random.standard_normal(n)
    U = np.zeros((2 * n, 2 * n))
    U[:n, :n], U[n:, n:] = 0.03, np.diag(variances)
    agrees_with_exact_arithmetic(fit_line(x, y, U[:n, :n], variances), x, y, U)
    # Exact x and a shared error alone in y leave the slope exact, and the whole error in the constant.
    line = fit_line(x, 2.5 * x + 1, None, np.full((n, n), 0.04))
    assert (line.slope, line.u_slope) == (pytest.approx(2.5, rel=1e-13), pytest.approx(0, abs=1e-12))
    assert (line.u_intercept, line.dof) == (pytest.approx(0.2, rel=1e-12), 0)


def test_errors_tied_within_a_row_agree_with_exact_arithmetic() -> None:
    cov_xy = 0.6 * np.sqrt(YORK_U2X * YORK_U2Y)
    U = np.block([[np.diag(YORK_U2X), np.diag(cov_xy)], [np.diag(cov_xy), np.diag(YORK_U2Y)]])
    agrees_with_exact_arithmetic(fit_line(YORK_X, YORK_Y, YORK_U2X, YORK_U2Y, cov_xy), YORK_X, YORK_Y, U)
    whole = fit_line(YORK_X, YORK_Y, np.diag(YORK_U2X), np.diag(YORK_U2Y), np.diag(cov_xy))
    agrees_with_exact_arithmetic(whole, YORK_X, YORK_Y, U)


def test_an_exact_point_is_a_fixed_point() -> None:
    others = np.arange(10) != 2
    line = fit_line(YORK_X, YORK_Y, None, np.where(others, 0.04, 0.0))
    assert line.intercept + line.slope * YORK_X[2] == pytest.approx(YORK_Y[2], rel=1e-13)
    # The same as a line through the origin about that point.
    about = fit_line((YORK_X - 1.8)[others], (YORK_Y - 4.4)[others], None, 0.04, intercept=False)
    assert (line.slope, line.u_slope) == pytest.approx((about.slope, about.u_slope), rel=1e-13)


def test_odrpack_agrees() -> None:
    odrpack = pytest.importorskip("odrpack")
    # Independent errors are what it can express; its u is scaled by chi-square, so only the line is compared.
    found = odrpack.odr_fit(
        lambda x, beta: beta[0] * x + beta[1], YORK_X, YORK_Y, np.array([-0.5, 5.5]),
        weight_x=1 / YORK_U2X, weight_y=1 / YORK_U2Y, partol=1e-15, sstol=1e-15,
    )  # fmt: skip
    line = fit_line(YORK_X, YORK_Y, YORK_U2X, YORK_U2Y)
    assert [line.slope, line.intercept] == pytest.approx(found.beta, rel=1e-5)


def test_iminuit_agrees() -> None:
    iminuit = pytest.importorskip("iminuit")
    x, y, U = correlated(5)
    xx, xy, yy = U[:9, :9], U[:9, 9:], U[9:, 9:]

    def chi2(slope: float, constant: float) -> float:
        left = y - slope * x - constant
        return float(left @ np.linalg.solve(yy + slope**2 * xx - slope * (xy + xy.T), left))

    minuit = iminuit.Minuit(chi2, slope=1.5, constant=3.0)
    minuit.errordef, minuit.tol = 1, 1e-6
    minuit.migrad()
    line = fit_line(x, y, xx, yy, xy)
    assert line.slope == pytest.approx(minuit.values["slope"], rel=1e-5)
    assert line.chi2 == pytest.approx(minuit.fval, rel=1e-8)


@pytest.mark.parametrize(
    ("x", "y", "options", "words"),
    [
        ([1.0], [2.0], {"cov_y": 1.0}, "do not determine"),
        ([1.0], [2.0], {"intercept": False}, "no residual"),
        ([], [], {"intercept": False}, "do not determine"),
        ([1.0, 2.0], [2.0, 3.0], {}, "no residual"),
        ([3.0] * 5, [1, 2, 3, 4, 5], {}, "all x are equal"),
        ([1.0, 1.0 + 0.9e-13, 1.0, 1.0], [2, 4, 6, 8], {}, "all x are equal"),
        ([0.0] * 5, [1, 2, 3, 4, 5], {"intercept": False}, "all x are zero"),
        ([1, 2, math.nan], [1, 2, 3], {}, "not finite"),
        ([1, 2, 3], [1, 2], {}, "same length"),
        ([[1, 2, 3]], [[1, 2, 3]], {}, "same length"),
        (XS, YS, {"cov_y": [1, 2]}, "cov_y has shape"),
        (XS, YS, {"cov_y": [1, 2, math.inf]}, "cov_y has a value that is not finite"),
        (XS, YS, {"cov_y": [1, -2, 1]}, "negative variance"),
        (XS, YS, {"cov_y": np.eye(3) + 2e-9 * np.eye(3, k=1)}, "not symmetric"),
        (XS, YS, {"cov_y": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "negative eigenvalue"),
        (XS, YS, {"cov_y": [[0, 1e-3, 0], [1e-3, 1, 0], [0, 0, 1]]}, "variance 0 has a covariance"),
        (XS, YS, {"cov_xy": 1.5}, "larger than"),
        (XS, YS, {"cov_x": 1e-4, "cov_y": 1e-4, "cov_xy": 1.01e-4}, "larger than"),
        (XS, YS, {"cov_y": 0.0}, "all covariances are zero"),
        ([1, 2, 3, 4], [1, 2, 4, 9], {"cov_y": [0, 0, 0, 1]}, "not on one line"),
    ],
)
def test_what_has_no_line_is_refused_with_its_reason(
    x: list[float], y: list[float], options: dict[str, Any], words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        fit_line(x, y, **options)


@pytest.mark.parametrize(
    "options",
    [
        {"x": [1.0, 1.0 + 1.2e-13, 1.0, 1.0]},
        {"x": [0, 1, 2, 5], "y": [0.2, 0.3 + 1.1e-9, 0.4, 1], "cov_y": [0, 0, 0, 1.0]},
        {"cov_y": np.eye(4) + 0.9e-12 * np.eye(4, k=1)},
        {"cov_x": 0.01, "cov_y": 0.04, "cov_xy": np.full(4, 0.02)},
        {"cov_y": np.kron(np.eye(2), [[1, 1 + 1.6e-9], [1 + 1.6e-9, 1]])},
    ],
)
def test_what_is_off_by_rounding_only_has_a_line(options: dict[str, Any]) -> None:
    given = {"x": [1.0, 2.0, 3.0, 5.0], "y": [2.1, 4.1, 5.8, 9.8], "cov_y": 1.0} | options
    assert math.isfinite(fit_line(**given).slope)


def test_one_stated_point_through_the_origin_is_enough() -> None:
    line = fit_line([2.0], [4.0], cov_y=0.04, intercept=False)
    assert (line.slope, line.u_slope, line.dof, line.p) == (2.0, pytest.approx(0.1), 0, None)


@pytest.mark.parametrize("exact", [0, 1, 2])
def test_exact_points_leave_four_degrees_of_freedom(exact: int) -> None:
    # The line goes through two exact points of six, and the other four are left.
    x, variances = np.arange(6.0), np.where(np.arange(6) < exact, 0.0, 0.04)
    y = 2 * x + np.where(variances > 0, 0.1 * np.cos(5 * x), 0.0)
    by_row, whole = fit_line(x, y, cov_y=variances), fit_line(x, y, cov_y=np.diag(variances))
    assert (by_row.dof, whole.dof) == (4, 4)
    assert (whole.slope, whole.chi2) == pytest.approx((by_row.slope, by_row.chi2), rel=1e-11)
    assert whole.u_slope == pytest.approx(by_row.u_slope, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("small", [1e-6, 4e-10, 1e-8])
def test_rows_of_very_different_errors_have_their_own_weight(small: float) -> None:
    u = np.array([1.0, small, 1.0, 1.0, 1.0, 2 * small])
    x, y = np.array([1.0, 2, 3, 4, 6, 8]), np.array([2.0, 4.5, 6, 7, 12, 15])
    line = fit_line(x, y, cov_y=u**2)
    # Two rows that are nearly exact are the line, and its uncertainty is theirs.
    assert line.slope == pytest.approx((15 - 4.5) / 6, rel=1e-9 + small)
    assert line.u_slope == pytest.approx(math.hypot(1, 2) * small / 6, rel=1e-6)
    assert line.chi2 == pytest.approx(float(np.sum((y - 4.5 - 1.75 * (x - 2)) ** 2)), rel=1e-5)


@pytest.mark.parametrize("count", [3, 4, 12, 1200])
def test_p_is_the_upper_tail_of_chi_square_by_mpmath(count: int) -> None:
    x = np.arange(1.0, count + 1)
    for size in (0.1, 1.0, 1.3):
        y = 2 * x + size * np.sqrt(2) * np.cos(5 * x)
        line = fit_line(x, y, cov_y=1.0)
        expected = float(mpmath.gammainc(mpmath.mpf(count - 2) / 2, line.chi2 / 2, regularized=True))
        assert line.p == pytest.approx(expected, rel=1e-9)
    assert (fit_line(x, y).p, fit_line(x[:2], y[:2], cov_y=1.0).p) == (None, None)
