"""The ways to get I_zz from a log that a student or another program would take, beside the recommended one.

Each takes the `Measurements` of one log and gives I_zz with the half-width of the 95 % interval that it would quote.
P stands for φ̇ψ̇, M for the torque; eq. (9) is M = I_zz P. Where only the scatter tells the uncertainty the
interval has Student's factor, so that a poor coverage is no fault of a small number of runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np
from msgspec import Struct

from gyrodata import fitting
from gyrodata.fitting import K_95
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

_KEEP = 1.345
"""Huber's constant: residuals beyond this many standard uncertainties count less [1]."""


class Answer(Struct, frozen=True):
    """I_zz, as one estimator has it."""

    value: float
    """[kg*m^2]"""
    half: float | None
    """Half of the 95 % interval [kg*m^2]; None where the estimator quotes none."""


Estimator = Callable[[Measurements], Answer]


def _student(freedom: int) -> float | None:
    """95 % quantile of Student's t, both sides; None without degrees of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.975)) if freedom > 0 else None


def _from_scatter(value: float, u: float | None, freedom: int) -> Answer:
    factor = _student(freedom)
    return Answer(value, None if factor is None or u is None else factor * u)


# --- the scatter tells the uncertainty ----------------------------------------------------------------------


def mean_of_ratios(measured: Measurements) -> Answer:
    """Mean of M/P over the loaded runs, with the standard error of a mean."""
    value, u = fitting.mean_of_ratios(measured.product, measured.torque)
    return _from_scatter(float(value), float(u), int(np.sum(measured.torque != 0)) - 1)


def torque_on_product(measured: Measurements, intercept: bool) -> Answer:
    """Least squares of M on P, through the origin or not."""
    line = fitting.ordinary_line(measured.product, measured.torque, intercept)
    if line is None:
        raise ValueError("the products do not determine a line")
    return _from_scatter(line.slope.value, line.slope.u, len(measured.runs) - 1 - intercept)


def product_on_torque(measured: Measurements, intercept: bool) -> Answer:
    """Least squares of P on M, through the origin or not; I_zz is one over the slope."""
    line = fitting.ordinary_line(measured.torque, measured.product, intercept)
    if line is None or not line.slope.value:
        raise ValueError("the torques do not determine a line")
    slope = line.slope.value
    u = None if line.slope.u is None else line.slope.u / slope**2
    return _from_scatter(1 / slope, u, len(measured.runs) - 1 - intercept)


def theil_sen(measured: Measurements) -> Answer:
    """Median of the slopes between all pairs of points, M on P; scipy's interval."""
    from scipy.stats import theilslopes

    slope, _, low, high = theilslopes(measured.torque, measured.product, 0.95)
    return Answer(float(slope), float(high - low) / 2)


def polyfit(measured: Measurements) -> Answer:
    """``numpy.polyfit`` of M on P with a constant, interval from its covariance."""
    with_scatter = len(measured.runs) > 4
    if with_scatter:
        slopes, covariance = np.polyfit(measured.product, measured.torque, 1, cov=True)
        return Answer(float(slopes[0]), K_95 * math.sqrt(covariance[0, 0]))
    return Answer(float(np.polyfit(measured.product, measured.torque, 1)[0]), None)


def linregress(measured: Measurements) -> Answer:
    """``scipy.stats.linregress`` of M on P."""
    from scipy.stats import linregress as regress

    line = regress(measured.product, measured.torque)
    freedom = len(measured.runs) - 2
    return _from_scatter(float(line.slope), float(line.stderr), freedom)


# --- the stated uncertainties tell it -----------------------------------------------------------------------


def covariances(measured: Measurements, shared: bool) -> tuple[Floats, Floats]:
    """Covariances of P [rad⁴/s⁴] and of M [N²m²] from the stated uncertainties, taken at the measured values."""
    count = len(measured.runs)
    of_product, of_torque = np.zeros((count, count)), np.zeros((count, count))
    onto = {
        "time": (of_product, measured.product, measured.time),
        "spin": (of_product, measured.product, measured.spin),
        "turns": (of_product, measured.product, measured.turns),
        "mass": (of_torque, measured.torque, measured.mass),
        "position": (of_torque, measured.torque, measured.position),
        "g": (of_torque, measured.torque, np.full(count, measured.g)),
    }
    for source in measured.sources:
        if source.quantity not in onto:
            continue
        covariance, whole, part = onto[source.quantity]
        slope = np.divide(whole, part, out=np.zeros(count), where=part != 0)
        spread = slope * (source.absolute + source.relative * part)
        groups = source.groups
        same = np.equal.outer(groups, groups) if shared else np.eye(count, dtype=bool)
        covariance += np.where(same & (groups >= 0), np.outer(spread, spread), 0.0)
    # The hand that is late is late in all runs: an unknown of the fit, and to a covariance one more shared error.
    late = measured.product / measured.time * measured.timing_bias_u
    of_product += np.outer(late, late) if shared else np.diag(late**2)
    return of_product, of_torque


def weighted(measured: Measurements) -> Answer:
    """Least squares of M on P through the origin, each run weighted by its own variance of M − I_zz P."""
    of_product, of_torque = covariances(measured, shared=False)
    product, torque = measured.product, measured.torque
    rough = float(np.median(torque[torque != 0] / product[torque != 0]))
    weight = 1 / (np.diag(of_torque) + rough**2 * np.diag(of_product))
    curvature = float(np.sum(weight * product**2))
    return Answer(float(np.sum(weight * product * torque)) / curvature, K_95 / math.sqrt(curvature))


def york(measured: Measurements, intercept: bool) -> Answer:
    """A line with errors in both variables, every run independent: York's, and that of ODR packages."""
    of_product, of_torque = covariances(measured, shared=False)
    variances = np.diag(of_product).copy(), np.diag(of_torque).copy()
    line = fitting.fit_line(measured.product, measured.torque, *variances, intercept=intercept)
    return Answer(line.slope, K_95 * line.u_slope)


def _log_ratios(measured: Measurements) -> tuple[Floats, Floats]:
    """Logarithm of M/P of the loaded runs, and its variance, every run independent."""
    loaded = measured.torque != 0
    of_product, of_torque = (np.diag(part)[loaded] for part in covariances(measured, shared=False))
    product, torque = measured.product[loaded], measured.torque[loaded]
    ratio = torque / product
    if not (ratio > 0).all():
        raise ValueError("a torque and its precession are of opposite sign: no logarithm")
    return np.log(ratio), of_product / product**2 + of_torque / torque**2


def log_fit(measured: Measurements) -> Answer:
    """Weighted mean of log(M/P): a line of slope 1 on double logarithmic paper."""
    logs, variance = _log_ratios(measured)
    total = float(np.sum(1 / variance))
    value = math.exp(float(np.sum(logs / variance)) / total)
    return Answer(value, K_95 * value / math.sqrt(total))


def huber(measured: Measurements) -> Answer:
    """Huber's estimate of log(M/P): as `log_fit`, but far runs pull with a bounded force."""
    logs, variance = _log_ratios(measured)
    centre = float(np.median(logs))
    for _turn in range(100):
        far = np.abs(logs - centre) / np.sqrt(variance)
        weight = np.minimum(1.0, _KEEP / np.maximum(far, _KEEP)) / variance
        before, centre = centre, float(np.sum(weight * logs) / np.sum(weight))
        if abs(centre - before) < 1e-12:
            break
    value = math.exp(centre)
    return Answer(value, K_95 * value / math.sqrt(float(np.sum(weight))))


def free_constant(measured: Measurements) -> Answer:
    """A line with a constant, errors in both variables and shared ones as shared (ISO/TS 28037)."""
    line = fitting.fit_line(measured.product, measured.torque, *covariances(measured, shared=True))
    return Answer(line.slope, K_95 * line.u_slope)


def pretested(measured: Measurements) -> Answer:
    """The same; the constant is left out unless it is significant at 95 %."""
    covariance = covariances(measured, shared=True)
    line = fitting.fit_line(measured.product, measured.torque, *covariance)
    assert line.u_intercept is not None
    if abs(line.intercept) < K_95 * line.u_intercept:
        line = fitting.fit_line(measured.product, measured.torque, *covariance, intercept=False)
    return Answer(line.slope, K_95 * line.u_slope)


def recommended(measured: Measurements) -> Answer:
    """The tool's own: screened for wrong counts, then fitted in the raw readings with shared errors as shared."""
    outliers, _ = fitting.screen(measured)
    fit = fitting.fit(measured, False, tuple(outlier.index for outlier in outliers if outlier.slip))
    low, high = fit.inertia.interval_95 or (math.nan, math.nan)
    return Answer(fit.inertia.value, (high - low) / 2)


ESTIMATORS: Mapping[str, Estimator] = {
    "mean of ratios": mean_of_ratios,
    "M on P, origin": lambda measured: torque_on_product(measured, intercept=False),
    "M on P, constant": lambda measured: torque_on_product(measured, intercept=True),
    "P on M, origin": lambda measured: product_on_torque(measured, intercept=False),
    "P on M, constant": lambda measured: product_on_torque(measured, intercept=True),
    "weighted, origin": weighted,
    "York, origin": lambda measured: york(measured, intercept=False),
    "York, constant": lambda measured: york(measured, intercept=True),
    "Theil–Sen": theil_sen,
    "Huber": huber,
    "log fit": log_fit,
    "full covariance": free_constant,
    "pretest": pretested,
    "recommended": recommended,
}
"""By the name in the charts."""

STUDENTS: Mapping[str, Estimator] = {
    "numpy.polyfit": polyfit,
    "scipy linregress": linregress,
    **{name: estimate for name, estimate in ESTIMATORS.items() if name != "recommended"},
}
"""All but the tool's own."""
