"""Straight lines with errors in both variables: published answers, exact arithmetic,
other programs, refusals.
"""

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
    # Without errors in x and with uncertain numbers for y its propagation is the whole
    # of the covariance.
    propagated = type_b.line_fit_wls(
        [float(x) for x in YORK_X],
        [ureal(*pair) for pair in zip(YORK_Y, u_y, strict=True)],
    )
    plain = fit_line(YORK_X, YORK_Y, cov_y=YORK_U2Y)
    assert plain.u_slope == pytest.approx(uncertainty(propagated.a_b[1]), rel=1e-12)
    assert plain.u_intercept == pytest.approx(uncertainty(propagated.a_b[0]), rel=1e-12)


def agrees_with_exact_arithmetic(
    line: LineFit, x: np.ndarray, y: np.ndarray, U: np.ndarray, constant: bool = True
) -> None:
    """Fit the same line with 50 digits, by another way: weights from the inverse of the
    conditions' covariance.
    """
    n = len(x)
    with mpmath.workdps(50):
        xs, ys, full = (mpmath.matrix(values.tolist()) for values in (x, y, U))
        ux, uy, uxy = full[:n, :n], full[n:, n:], full[:n, n:]
        p = mpmath.matrix(
            [mpmath.mpf(float(np.polyfit(x, y, 1)[0])), 0][: 1 + constant]
        )
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


def correlated(
    seed: int, constant: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nine points and a full covariance: errors of their own, and three that all share
    in different measure.
    """
    random, n = np.random.default_rng(seed), 9
    shared = random.standard_normal((2 * n, 3))
    U = 0.01 * (np.diag(random.uniform(0.5, 2, 2 * n)) + 0.5 * shared @ shared.T)
    errors, truth = (
        np.linalg.cholesky(U) @ random.standard_normal(2 * n),
        np.linspace(1, 9, n),
    )
    return truth + errors[:n], 1.7 * truth + (4 if constant else 0) + errors[n:], U


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "constant"), [(1, True), (2, False)])
def test_full_covariances_agree_with_exact_arithmetic(
    seed: int, constant: bool
) -> None:
    x, y, U = correlated(seed, constant)
    line = fit_line(x, y, U[:9, :9], U[9:, 9:], U[:9, 9:], intercept=constant)
    agrees_with_exact_arithmetic(line, x, y, U, constant)
    assert line.dof == 8 - constant


def test_singular_covariances_agree_with_exact_arithmetic() -> None:
    # One ruler for all x, an exact y, the rest alone.
    random, n = np.random.default_rng(4), 8
    x, variances = (
        np.linspace(1, 8, n),
        np.array([0.0, 0.04, 0.04, 0.09, 0.04, 0.01, 0.04, 0.04]),
    )
    y = 2.5 * x + 1 + np.sqrt(variances) * random.standard_normal(n)
    U = np.zeros((2 * n, 2 * n))
    U[:n, :n], U[n:, n:] = 0.03, np.diag(variances)
    agrees_with_exact_arithmetic(fit_line(x, y, U[:n, :n], variances), x, y, U)
    # Exact x and a shared error alone in y leave the slope exact, and the whole error
    # in the constant.
    line = fit_line(x, 2.5 * x + 1, None, np.full((n, n), 0.04))
    assert (line.slope, line.u_slope) == (
        pytest.approx(2.5, rel=1e-13),
        pytest.approx(0, abs=1e-12),
    )
    assert (line.u_intercept, line.dof) == (pytest.approx(0.2, rel=1e-12), 0)


def test_iminuit_agrees() -> None:
    iminuit = pytest.importorskip("iminuit")
    x, y, U = correlated(5)
    xx, xy, yy = U[:9, :9], U[:9, 9:], U[9:, 9:]

    def chi2(slope: float, constant: float) -> float:
        left = y - slope * x - constant
        return float(
            left @ np.linalg.solve(yy + slope**2 * xx - slope * (xy + xy.T), left)
        )

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
        ([1.0, 2.0], [2.0, 3.0], {}, "no residual"),
        ([3.0] * 5, [1, 2, 3, 4, 5], {}, "all x are equal"),
        ([0.0] * 5, [1, 2, 3, 4, 5], {"intercept": False}, "all x are zero"),
        ([1, 2, math.nan], [1, 2, 3], {}, "not finite"),
        ([1, 2, 3], [1, 2], {}, "same length"),
        (XS, YS, {"cov_y": [1, 2]}, "cov_y has shape"),
        (
            XS,
            YS,
            {"cov_y": [1, 2, math.inf]},
            "cov_y contains a value that is not finite",
        ),
        (XS, YS, {"cov_y": [1, -2, 1]}, "negative variance"),
        (XS, YS, {"cov_y": np.eye(3) + 2e-9 * np.eye(3, k=1)}, "not symmetric"),
        (XS, YS, {"cov_y": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "negative eigenvalue"),
        (
            XS,
            YS,
            {"cov_y": [[0, 1e-3, 0], [1e-3, 1, 0], [0, 0, 1]]},
            "variance 0 has a covariance",
        ),
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


@pytest.mark.parametrize("count", [3, 4, 12, 1200])
def test_p_is_the_upper_tail_of_chi_square_by_mpmath(count: int) -> None:
    x = np.arange(1.0, count + 1)
    for size in (0.1, 1.0, 1.3):
        y = 2 * x + size * np.sqrt(2) * np.cos(5 * x)
        line = fit_line(x, y, cov_y=1.0)
        expected = float(
            mpmath.gammainc(mpmath.mpf(count - 2) / 2, line.chi2 / 2, regularized=True)
        )
        assert line.p == pytest.approx(expected, rel=1e-9)
    assert (fit_line(x, y).p, fit_line(x[:2], y[:2], cov_y=1.0).p) == (None, None)


def test_equal_errors_give_deming_s_line() -> None:
    """Errors of one size in all points: the slope has a closed form.

    The start of the iteration can satisfy its first conditions to the last digit, and
    is not the answer.
    """
    assert fit_line([0, 1, 2], [0, 1, 5], cov_x=1.0).slope == pytest.approx(2.8)
    random = np.random.default_rng(11)
    for _ in range(200):
        count = random.integers(4, 14)
        x = np.arange(count) + random.normal(0, 0.1 * count, count)
        y = 2 * np.arange(count) + random.normal(0, 0.1 * count, count)
        u2x, u2y = random.uniform(0.1, 2.0, 2)
        line = fit_line(x, y, u2x, u2y)
        ratio = u2y / u2x
        (s_xx, s_xy), (_, s_yy) = np.cov(x, y)
        half = (s_yy - ratio * s_xx) / 2
        slope = (half + math.sqrt(half**2 + ratio * s_xy**2)) / s_xy
        assert line.slope == pytest.approx(slope, rel=1e-9)
        middle = np.mean(y) - slope * np.mean(x)
        assert line.intercept == pytest.approx(middle, rel=1e-7, abs=1e-9)
