"""Straight lines with errors in both variables: published answers, exact arithmetic, other programs, refusals."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy import stats

from gyrodata.fitting import LineFit, chi2_lower_tail, chi2_tail, fit_line, ordinary_line

YORK_X = np.array([0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4])
YORK_Y = np.array([5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5])
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


def exactly(x: np.ndarray, y: np.ndarray, U: np.ndarray, constant: bool) -> tuple[list[float], np.ndarray, float]:
    """The same line with 50 digits, by another way: weights from the inverse of the conditions' covariance."""
    with mpmath.workdps(50):
        n = len(x)
        xs, ys, full = mpmath.matrix(list(map(float, x))), mpmath.matrix(list(map(float, y))), mpmath.matrix(U.tolist())
        ux, uy, uxy = full[:n, :n], full[n:, n:], full[:n, n:]
        p = mpmath.matrix([mpmath.mpf(float(np.polyfit(x, y, 1)[0])), 0][: 1 + constant])
        true = xs.copy()
        for _ in range(200):
            design = mpmath.matrix(n, 1 + constant)
            for i in range(n):
                design[i, 0] = true[i]
                if constant:
                    design[i, 1] = 1
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
        cov = np.array([[float(normal[i, j]) for j in range(1 + constant)] for i in range(1 + constant)])
        return [float(v) for v in p], cov, float((left.T * inverse * left)[0])


def agree(line: LineFit, x: np.ndarray, y: np.ndarray, U: np.ndarray, constant: bool) -> None:
    p, cov, chi2 = exactly(x, y, U, constant)
    assert line.slope == pytest.approx(p[0], rel=1e-13)
    assert line.u_slope == pytest.approx(math.sqrt(cov[0, 0]), rel=1e-13)
    assert line.chi2 == pytest.approx(chi2, rel=1e-12)
    if constant:
        assert line.intercept == pytest.approx(p[1], rel=1e-13)
        assert line.u_intercept == pytest.approx(math.sqrt(cov[1, 1]), rel=1e-13)
        assert line.covariance[0, 1] == pytest.approx(cov[0, 1], rel=1e-13)


def correlated(random: np.random.Generator, size: int) -> np.ndarray:
    """A full covariance: errors of their own, and three that all share in different measure."""
    shared = random.standard_normal((size, 3))
    return 0.01 * (np.diag(random.uniform(0.5, 2, size)) + 0.5 * shared @ shared.T)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("constant", [True, False])
def test_full_covariances_against_exact_arithmetic(seed: int, constant: bool) -> None:
    random = np.random.default_rng(seed)
    n = 9
    U = correlated(random, 2 * n)
    errors = np.linalg.cholesky(U) @ random.standard_normal(2 * n)
    truth = np.linspace(1, 9, n)
    x, y = truth + errors[:n], 1.7 * truth + (4 if constant else 0) + errors[n:]
    line = fit_line(x, y, U[:n, :n], U[n:, n:], U[:n, n:], intercept=constant)
    agree(line, x, y, U, constant)
    assert line.dof == n - 1 - constant


def test_singular_parts_against_exact_arithmetic() -> None:
    # One ruler for all x, three exact y, the rest alone: U has rank 7 of 16.
    random = np.random.default_rng(4)
    n = 8
    x = np.linspace(1, 8, n)
    variances = np.array([0.0, 0.04, 0.04, 0.09, 0.04, 0.01, 0.04, 0.04])
    y = 2.5 * x + 1 + np.sqrt(variances) * random.standard_normal(n)
    U = np.zeros((2 * n, 2 * n))
    U[:n, :n] = 0.03
    U[n:, n:] = np.diag(variances)
    line = fit_line(x, y, U[:n, :n], variances)
    agree(line, x, y, U, True)
    # Exact x and a shared error alone in y leave the slope exact, and the whole error in the constant.
    line = fit_line(x, 2.5 * x + 1, None, np.full((n, n), 0.04))
    assert line.slope == pytest.approx(2.5, rel=1e-13)
    assert line.u_slope == pytest.approx(0, abs=1e-12)
    assert line.u_intercept == pytest.approx(0.2, rel=1e-12)
    assert line.dof == 0


def test_errors_tied_within_a_row() -> None:
    cov_xy = 0.6 * np.sqrt(YORK_U2X * YORK_U2Y)
    by_row = fit_line(YORK_X, YORK_Y, YORK_U2X, YORK_U2Y, cov_xy)
    whole = fit_line(YORK_X, YORK_Y, np.diag(YORK_U2X), np.diag(YORK_U2Y), np.diag(cov_xy))
    assert by_row.slope == pytest.approx(whole.slope, rel=1e-13)
    assert by_row.u_slope == pytest.approx(whole.u_slope, rel=1e-13)
    U = np.block([[np.diag(YORK_U2X), np.diag(cov_xy)], [np.diag(cov_xy), np.diag(YORK_U2Y)]])
    agree(by_row, YORK_X, YORK_Y, U, True)


def test_an_exact_point_is_a_fixed_point() -> None:
    variances = np.full(10, 0.04)
    variances[2] = 0.0
    line = fit_line(YORK_X, YORK_Y, None, variances)
    assert line.intercept + line.slope * YORK_X[2] == pytest.approx(YORK_Y[2], rel=1e-13)
    # The same as a line through the origin about that point.
    others = np.arange(10) != 2
    about = fit_line((YORK_X - 1.8)[others], (YORK_Y - 4.4)[others], None, 0.04, intercept=False)
    assert line.slope == pytest.approx(about.slope, rel=1e-13)
    assert line.u_slope == pytest.approx(about.u_slope, rel=1e-13)


def test_without_covariances_it_is_the_textbook_line() -> None:
    for intercept in (True, False):
        line, textbook = fit_line(YORK_X, YORK_Y, intercept=intercept), ordinary_line(YORK_X, YORK_Y, intercept)
        assert textbook is not None
        assert (line.slope, line.u_slope) == pytest.approx((textbook.slope.value, textbook.slope.u), rel=1e-12)
    assert "residuals" in line.convention


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
    random = np.random.default_rng(5)
    n = 8
    U = correlated(random, 2 * n)
    truth = np.linspace(1, 9, n)
    errors = np.linalg.cholesky(U) @ random.standard_normal(2 * n)
    x, y = truth + errors[:n], 1.7 * truth + 4 + errors[n:]

    def chi2(slope: float, constant: float) -> float:
        V = U[n:, n:] + slope**2 * U[:n, :n] - slope * (U[:n, n:] + U[n:, :n])
        left = y - slope * x - constant
        return float(left @ np.linalg.solve(V, left))

    minuit = iminuit.Minuit(chi2, slope=1.5, constant=3.0)
    minuit.errordef = 1
    minuit.tol = 1e-6
    minuit.migrad()
    line = fit_line(x, y, U[:n, :n], U[n:, n:], U[:n, n:])
    assert line.slope == pytest.approx(minuit.values["slope"], rel=1e-5)
    assert line.chi2 == pytest.approx(minuit.fval, rel=1e-8)


class TestRefusals:
    @pytest.mark.parametrize(
        ("x", "y", "options", "words"),
        [
            ([1.0], [2.0], {"cov_y": 1.0}, "do not determine"),
            ([1.0], [2.0], {"intercept": False}, "no residual"),
            ([], [], {"intercept": False}, "do not determine"),
            ([1.0, 2.0], [2.0, 3.0], {}, "no residual"),
            ([3.0] * 5, [1, 2, 3, 4, 5], {}, "all x are equal"),
            ([0.0] * 5, [1, 2, 3, 4, 5], {}, "all x are equal"),
            ([0.0] * 5, [1, 2, 3, 4, 5], {"intercept": False}, "all x are zero"),
            ([1, 2, math.nan], [1, 2, 3], {}, "not finite"),
            ([1, 2, 3], [1, 2], {}, "same length"),
            ([[1, 2, 3]], [[1, 2, 3]], {}, "same length"),
            ([1, 2, 3], [1, 2, 4], {"cov_y": [1, 2]}, "cov_y has shape"),
            ([1, 2, 3], [1, 2, 4], {"cov_y": [1, 2, math.inf]}, "cov_y has a value that is not finite"),
            ([1, 2, 3], [1, 2, 4], {"cov_y": [1, -2, 1]}, "negative variance"),
            ([1, 2, 3], [1, 2, 4], {"cov_y": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, "not symmetric"),
            ([1, 2, 3], [1, 2, 4], {"cov_y": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "negative eigenvalue"),
            ([1, 2, 3], [1, 2, 4], {"cov_x": 1.0, "cov_y": 1.0, "cov_xy": 1.5}, "larger than"),
            ([1, 2, 3], [1, 2, 4], {"cov_xy": 1.5}, "larger than"),
            ([1, 2, 3], [1, 2, 4], {"cov_x": 1e-4, "cov_y": 1e-4, "cov_xy": 1.01e-4}, "larger than"),
            ([1, 2, 3], [1, 2, 4], {"cov_y": 0.0}, "all covariances are zero"),
            ([1, 2, 3, 4], [1, 2, 4, 9], {"cov_y": [0, 0, 0, 1]}, "not on one line"),
        ],
    )
    def test_named(self, x: list[float], y: list[float], options: dict[str, object], words: str) -> None:
        with pytest.raises(ValueError, match=words):
            fit_line(x, y, **options)  # type: ignore[arg-type]

    def test_one_stated_point_through_the_origin_is_enough(self) -> None:
        line = fit_line([2.0], [4.0], cov_y=0.04, intercept=False)
        assert (line.slope, line.u_slope, line.dof, line.p) == (2.0, pytest.approx(0.1), 0, None)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"x": [1.0, 1.0 + 1.2e-13, 1.0, 1.0]}, ""),
        ({"x": [1.0, 1.0 + 0.9e-13, 1.0, 1.0]}, "all x are equal"),
        ({"x": [0, 1, 2, 5], "y": [0.2, 0.3 + 1.1e-9, 0.4, 1], "cov_y": [0, 0, 0, 1.0]}, ""),
        ({"x": [0, 1, 2, 5], "y": [0.2, 0.3 + 1.4e-9, 0.4, 1], "cov_y": [0, 0, 0, 1.0]}, "not on one line"),
        ({"cov_y": np.eye(4) + 0.9e-12 * np.eye(4, k=1)}, ""),
        ({"cov_y": np.eye(4) + 2e-9 * np.eye(4, k=1)}, "not symmetric"),
        ({"cov_x": 0.01, "cov_y": 0.04, "cov_xy": np.full(4, 0.02)}, ""),
        ({"cov_x": 0.01, "cov_y": 0.04, "cov_xy": np.full(4, -0.02 * (1 + 1e-9))}, "larger than"),
        ({"cov_y": np.kron(np.eye(2), [[1, 1 + 1.6e-9], [1 + 1.6e-9, 1]])}, ""),
        ({"cov_y": np.kron(np.eye(2), [[1, 1 + 2.6e-9], [1 + 2.6e-9, 1]])}, "negative eigenvalue"),
        ({"cov_y": [[0, 1e-3, 0, 0], [1e-3, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}, "variance 0 has a covariance"),
    ],
)
def test_what_is_off_by_rounding_is_a_line_and_more_is_refused(options: dict[str, Any], words: str) -> None:
    given = {"x": [1.0, 2.0, 3.0, 5.0], "y": [2.1, 4.1, 5.8, 9.8], "cov_y": 1.0} | options
    if not words:
        assert math.isfinite(fit_line(**given).slope)
        return
    with pytest.raises(ValueError, match=words):
        fit_line(**given)


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


@pytest.mark.parametrize(
    ("count", "options", "has_p"), [(2, {"cov_y": 1.0}, False), (3, {"cov_y": 1.0}, True), (3, {}, False)]
)
def test_p_needs_stated_errors_and_a_point_to_spare(count: int, options: dict[str, float], has_p: bool) -> None:
    line = fit_line([1.0, 2.0, 3.0][:count], [1.0, 3.0, 4.0][:count], **options)
    assert (line.p is not None) == has_p
    if has_p:
        assert line.p == pytest.approx(float(mpmath.gammainc(0.5, line.chi2 / 2, regularized=True)), rel=1e-10)


@pytest.mark.parametrize("dof", [1, 2, 3, 1000, 1001, 40000])
def test_the_upper_tail_of_chi_square_agrees_with_mpmath(dof: int) -> None:
    for chi2 in (-1.0, 0.0, 1e-12, 0.5 * dof, dof, 1.1 * dof, dof + 6 * math.sqrt(2 * dof)):
        expected = float(mpmath.gammainc(mpmath.mpf(dof) / 2, max(chi2, 0.0) / 2, regularized=True))
        assert chi2_tail(chi2, dof) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("dof", [1, 2, 5, 9, 24, 190])
@pytest.mark.parametrize("share", [1e-6, 0.01, 0.3, 1.0, 2.0])
def test_the_lower_tail_of_chi_square_agrees_with_scipy(dof: int, share: float) -> None:
    assert chi2_lower_tail(share * dof, dof) == pytest.approx(stats.chi2.cdf(share * dof, dof), rel=1e-10)
