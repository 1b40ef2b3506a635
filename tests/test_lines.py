"""Straight lines with errors in both variables: published answers, exact arithmetic, other programs, refusals."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy import stats

import gyrodata
from gyrodata import fitting
from gyrodata.fitting import LineFit, chi2_lower_tail, chi2_tail, fit_line, ordinary_line

YORK_X = np.array([0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4])
YORK_Y = np.array([5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5])
YORK_U2X = 1 / np.array([1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0])
YORK_U2Y = 1 / np.array([1.0, 1.8, 4.0, 8.0, 20, 20, 70, 70, 100, 500])

NORRIS_X = """0.2 337.4 118.2 884.6 10.1 226.5 666.3 996.3 448.6 777.0 558.2 0.4 0.6 775.5 666.9 338.0 447.5 11.6
    556.0 228.1 995.8 887.6 120.2 0.3 0.3 556.8 339.1 887.2 999.0 779.0 11.1 118.3 229.2 669.1 448.9 0.5"""
NORRIS_Y = """0.1 338.8 118.1 888.0 9.2 228.1 668.5 998.5 449.1 778.9 559.2 0.3 0.1 778.1 668.8 339.3 448.9 10.8
    557.7 228.3 998.0 888.8 119.6 0.3 0.6 557.6 339.3 888.0 998.5 778.9 10.2 117.6 228.9 668.4 449.2 0.2"""


@pytest.mark.parametrize("matrices", [False, True])
def test_york(matrices: bool) -> None:
    cov_x, cov_y = (np.diag(v) if matrices else v for v in (YORK_U2X, YORK_U2Y))
    line = gyrodata.fit_line(YORK_X, YORK_Y, cov_x, cov_y)
    assert line.slope == pytest.approx(-0.4805334074462020, rel=1e-14)
    assert line.intercept == pytest.approx(5.479910224032854, rel=1e-14)
    assert line.u_slope == pytest.approx(0.05798500900077444, rel=1e-14)
    assert line.chi2 == pytest.approx(11.8663531941, rel=1e-11)
    assert line.dof == 8
    assert "York 2004" in line.convention


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


def test_certified_lines_from_the_scatter() -> None:
    # NIST StRD; a certified value has 15 digits, and a double read from decimals may move the last.
    through = fit_line(np.arange(60.0, 71), np.arange(130.0, 141), intercept=False)
    assert (through.slope, through.u_slope) == pytest.approx((2.07438016528926, 0.165289256198347e-01), rel=1e-14)
    assert through.u_intercept is None
    through = fit_line([4, 5, 6], [3, 4, 4], intercept=False)
    assert (through.slope, through.u_slope) == pytest.approx((0.727272727272727, 0.420827318078432e-01), rel=1e-14)
    line = fit_line([float(v) for v in NORRIS_X.split()], [float(v) for v in NORRIS_Y.split()])
    assert line.slope == pytest.approx(1.00211681802045, rel=1e-14)
    assert line.intercept == pytest.approx(-0.262323073774029, rel=2e-14)
    assert line.u_slope == pytest.approx(0.429796848199937e-03, rel=1e-14)
    assert line.u_intercept == pytest.approx(0.232818234301152, rel=1e-14)
    assert line.chi2 == pytest.approx(26.6173985294224, rel=1e-14)
    assert line.p is None


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


def test_an_error_shared_by_all_y_does_not_shrink_with_the_number_of_points() -> None:
    x = np.linspace(1, 5, 40)
    line = fit_line(x, 3 * x, None, 0.01 * np.eye(40) + 0.04)
    assert line.u_intercept is not None
    assert line.u_intercept > 0.2


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


def test_units_do_not_matter() -> None:
    line = fit_line(YORK_X, YORK_Y, YORK_U2X, YORK_U2Y)
    scaled = fit_line(1e-9 * YORK_X, 1e6 * YORK_Y, 1e-18 * YORK_U2X, 1e12 * YORK_U2Y)
    assert scaled.slope == pytest.approx(1e15 * line.slope, rel=1e-13)
    assert scaled.u_slope == pytest.approx(1e15 * line.u_slope, rel=1e-13)


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


class TestLimits:
    """What is a line and what is none, on both sides of each limit."""

    def test_all_x_equal_to_thirteen_digits_is_refused(self) -> None:
        for off, refused in ((0.9e-13, True), (1.2e-13, False)):
            x = np.array([1.0, 1.0 + off, 1.0])
            if refused:
                with pytest.raises(ValueError, match="all x are equal"):
                    fit_line(x, [1.0, 2.0, 1.0], cov_y=1.0)
            else:
                assert fit_line(x, [1.0, 2.0, 1.0], cov_y=1.0).slope == pytest.approx(1 / off, rel=2e-2)
        assert fit_line([3.0] * 4, [3.0, 3.1, 2.9, 3.0], cov_y=0.01, intercept=False).slope == pytest.approx(1.0)

    def test_exact_points_may_be_off_by_a_part_of_a_thousand_million(self) -> None:
        # Three exact points: what no error closes is two thirds of how far the middle one is off, as a distance.
        for share, refused in ((0.97, False), (1.03, True)):
            off = share * 1e-9 * math.sqrt(6) / 2
            y = np.array([0.2, 0.3 + off, 0.4, 1.0])
            if refused:
                with pytest.raises(ValueError, match="not on one line"):
                    fit_line([0.0, 1.0, 2.0, 5.0], y, cov_y=[0, 0, 0, 1.0])
            else:
                assert fit_line([0.0, 1.0, 2.0, 5.0], y, cov_y=[0, 0, 0, 1.0]).slope == pytest.approx(0.1, rel=1e-8)

    def test_a_matrix_is_symmetric_to_nine_digits(self) -> None:
        def asked(off: float) -> np.ndarray:
            return np.array([[1.0, 0.3, 0.0], [0.3 * (1 + off), 1.0, 0.0], [0.0, 0.0, 1.0]])

        for name in ("cov_x", "cov_y"):
            fit_line([1, 2, 3], [1, 2, 4], **{name: asked(0.9e-9)})
            with pytest.raises(ValueError, match=f"{name} is not symmetric"):
                fit_line([1, 2, 3], [1, 2, 4], **{name: asked(1.1e-9)})
            # Beside a large variance what is as small as rounding may differ.
            matrix = np.diag([1.0, 2.0, 100.0])
            matrix[0, 1] = 0.9e-10
            fit_line([1, 2, 3], [1, 2, 4], **{name: matrix})
            matrix[0, 1] = 1.1e-10
            with pytest.raises(ValueError, match=f"{name} is not symmetric"):
                fit_line([1, 2, 3], [1, 2, 4], **{name: matrix})

    def test_two_errors_of_a_row_go_together_at_most_wholly(self) -> None:
        whole = np.full(4, 0.02)
        for x, y in ((0.01, 0.04), (0.04, 0.01)):
            line = fit_line([1, 2, 3, 5], [1, 2, 3.1, 5], x, y, whole)
            assert line.dof == 2
            fit_line([1, 2, 3, 5], [1, 2, 3.1, 5], x, y, whole * math.sqrt(1 + 0.8e-12))
            with pytest.raises(ValueError, match="larger than"):
                fit_line([1, 2, 3, 5], [1, 2, 3.1, 5], x, y, whole * math.sqrt(1 + 1.3e-12))
        with pytest.raises(ValueError, match="larger than"):
            fit_line([1, 2, 3, 5], [1, 2, 3.1, 5], 0.01, 0.04, -whole * (1 + 1e-9))

    @pytest.mark.parametrize(("least", "good"), [(-0.8e-9, True), (-1.3e-9, False), (0.0, True), (1e-3, True)])
    def test_an_eigenvalue_is_negative_by_rounding_at_most(self, least: float, good: bool) -> None:
        # Correlations of two errors each way and of all: eigenvalues 1 ± c of each pair.
        c = (1 - least) / (1 + least)
        matrix = np.kron(np.eye(2), np.array([[1.0, c], [c, 1.0]]))
        if good:
            # Where the errors of a pair are one, the slope is exact.
            line = fit_line([1, 2, 3, 5], [2.1, 4.1, 5.8, 9.8], cov_y=matrix)
            assert line.dof == (2 if least > 0 else 1)
            assert line.slope == pytest.approx(2.0, rel=1e-3 if least > 0 else 1e-12)
        else:
            with pytest.raises(ValueError, match="negative eigenvalue"):
                fit_line([1, 2, 3, 5], [1, 2, 3.1, 5], cov_y=matrix)

    def test_what_has_no_variance_has_no_covariance(self) -> None:
        matrix = np.diag([0.0, 1.0, 1.0, 1.0])
        assert fit_line([1, 2, 3, 5], [1, 2, 3.1, 5], cov_y=matrix).dof == 2
        matrix[0, 1] = matrix[1, 0] = 1e-3
        with pytest.raises(ValueError, match="variance 0 has a covariance"):
            fit_line([1, 2, 3, 5], [1, 2, 3.1, 5], cov_y=matrix)

    @pytest.mark.parametrize("count", [3, 4, 5])
    def test_degrees_of_freedom_are_those_of_errors_that_can_be_seen(self, count: int) -> None:
        # So many of six rows are exact: the line goes through them if there are two, and the others are left.
        variances = np.where(np.arange(6) < count - 3, 0.0, 0.04)
        x = np.arange(6.0)
        y = 2 * x + np.where(variances > 0, 0.1 * np.cos(5 * x), 0.0)
        by_row, whole = fit_line(x, y, cov_y=variances), fit_line(x, y, cov_y=np.diag(variances))
        assert (by_row.dof, whole.dof) == (4, 4)
        assert (whole.slope, whole.chi2) == pytest.approx((by_row.slope, by_row.chi2), rel=1e-11)
        assert whole.u_slope == pytest.approx(by_row.u_slope, rel=1e-12, abs=1e-15)

    def test_errors_that_run_along_the_line_leave_it_exact(self) -> None:
        x, one = np.array([1.0, 2.0, 3.0]), np.eye(3)
        for intercept in (True, False):
            line = fit_line(x, 2 * x, 0.04 * one, 0.16 * one, 0.08 * one, intercept=intercept)
            assert (line.slope, line.intercept, line.chi2) == (2, 0, 0)
            assert line.u_slope < 1e-8

    @pytest.mark.parametrize("small", [1e-6, 1e-10, 4e-10, 3e-9, 1e-8])
    def test_points_at_a_height_of_zero_are_on_a_line_too(self, small: float) -> None:
        for options in ({"cov_y": small}, {"cov_y": small * np.eye(3)}, {"cov_x": small, "cov_y": small}):
            for intercept in (True, False):
                line = fit_line([1.0, 2.0, 4.0], np.zeros(3), intercept=intercept, **options)  # type: ignore[arg-type]
                assert (line.slope, line.intercept, line.chi2, line.p) == (0, 0, 0, 1)

    @pytest.mark.parametrize("small", [1e-6, 1e-10, 4e-10, 3e-9, 1e-8])
    def test_rows_of_very_different_errors_are_weighed_as_they_are(self, small: float) -> None:
        u = np.array([1.0, small, 1.0, 1.0, 1.0, 2 * small])
        x, y = np.array([1.0, 2, 3, 4, 6, 8]), np.array([2.0, 4.5, 6, 7, 12, 15])
        line = fit_line(x, y, cov_y=u**2)
        # Two rows that are nearly exact are the line, and what is uncertain of it is theirs.
        assert line.slope == pytest.approx((15 - 4.5) / 6, rel=1e-9 + small)
        assert line.u_slope == pytest.approx(math.hypot(1, 2) * small / 6, rel=1e-6)
        assert line.dof == 4
        assert line.chi2 == pytest.approx(float(np.sum((y - 4.5 - 1.75 * (x - 2)) ** 2)), rel=1e-5)

    def test_few_points_of_the_textbook_tell_no_u(self) -> None:
        for name, least in (("through_origin", 1), ("with_constant", 2), ("mean_of_ratios", 1)):
            x, y = np.array([1.0, 2.0, 4.0]), np.array([2.0, 5.0, 7.0])
            for count in (least, least + 1):
                _, u = fitting.TEXTBOOK[name](x[:count], y[:count])
                assert np.isnan(u) == (count == least)
                stack, us = fitting.TEXTBOOK[name](np.array([x[:count]] * 2), np.array([y[:count]] * 2))
                assert stack.shape == us.shape == (2,)
        for stack in (lambda row: row, lambda row: row[None], lambda row: np.array([row] * 3)[None]):
            mean, u = fitting.mean_of_ratios(stack(np.array([1.0, 2.0, 4.0])), stack(np.array([0.0, 5.0, 7.0])))
            assert mean.shape == u.shape == stack(np.ones(1)).shape[:-1]
            assert mean == pytest.approx((2.5 + 1.75) / 2)
            assert u == pytest.approx(0.375, rel=1e-12)

    def test_the_textbook_line_needs_as_many_points_as_unknowns_and_some_spread(self) -> None:
        def line(x: list[float], intercept: bool) -> fitting.Line | None:
            return ordinary_line(np.array(x), 2.0 * np.array(x) + 1.0, intercept)

        assert line([], False) is None
        assert line([1.0], True) is None
        assert line([0.0, 0.0], False) is None
        two = line([1.0, 3.0], True)
        assert two is not None
        assert two.intercept is not None
        assert (two.slope.value, two.intercept.value) == pytest.approx((2.0, 1.0), rel=1e-14)
        assert two.slope.u is None
        assert two.intercept.u is None
        one = line([1.0], False)
        assert one is not None
        assert (one.slope.u, one.intercept) == (None, None)
        assert line([1.0, 1.0 + 1.3e-9], True) is None
        assert line([1.0, 1.0 + 2.2e-9], True) is not None
        random = np.random.default_rng(3)
        x, y = random.uniform(2, 9, 8), random.uniform(1, 7, 8)
        whole = ordinary_line(x, y, True)
        told = fit_line(x, y)
        assert whole is not None
        assert whole.intercept is not None
        assert whole.intercept.u == pytest.approx(told.u_intercept, rel=1e-12)
        assert whole.intercept.value == pytest.approx(told.intercept, rel=1e-12)

    def test_the_chance_of_a_misfit_is_told_with_stated_errors_and_points_to_spare(self) -> None:
        line = fit_line(YORK_X, YORK_Y, YORK_U2X, YORK_U2Y)
        assert line.p == pytest.approx(float(mpmath.gammainc(4, line.chi2 / 2, regularized=True)), rel=1e-10)
        assert fit_line([1.0, 2.0], [1.0, 3.0], cov_y=1.0).p is None
        assert fit_line([1.0, 2.0, 3.0], [1.0, 3.0, 4.0], cov_y=1.0).p is not None
        assert fit_line([1.0, 2.0, 3.0], [1.0, 3.0, 4.0]).p is None

    @pytest.mark.parametrize("dof", [1, 2, 3, 1000, 1001, 40000])
    def test_the_tail_of_many_degrees_of_freedom(self, dof: int) -> None:
        for chi2 in (-1.0, 0.0, 1e-12, 0.5 * dof, dof, 1.1 * dof, dof + 6 * math.sqrt(2 * dof)):
            expected = float(mpmath.gammainc(mpmath.mpf(dof) / 2, max(chi2, 0.0) / 2, regularized=True))
            assert fitting.chi2_tail(chi2, dof) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("dof", [1, 2, 5, 9, 24, 190])
@pytest.mark.parametrize("share", [1e-6, 0.01, 0.3, 1.0, 2.0])
def test_the_lower_tail_of_chi_square_agrees_with_scipy(dof: int, share: float) -> None:
    assert chi2_lower_tail(share * dof, dof) == pytest.approx(stats.chi2.cdf(share * dof, dof), rel=1e-10)


def test_the_two_tails_of_chi_square_add_up() -> None:
    assert chi2_lower_tail(7.3, 6) + chi2_tail(7.3, 6) == pytest.approx(1, abs=1e-14)
    assert chi2_lower_tail(0, 6) == 0
