"""The ways to get I_zz from a log that a student or another program would take, beside the recommended one.

Each takes the `Measurements` of one log, or of L labs of one design at once, whose readings then have shape (L, n), and
gives I_zz with the 95 % interval that it would quote. P stands for φ̇ψ̇, M for the torque; eq. (9) is M = I_zz P. Where
only the scatter tells the uncertainty the interval has Student's factor, so that a poor coverage is no fault of a small
number of runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from gyrodata import fitting
from gyrodata.fitting import K_95, MAD_TO_SD
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

_KEEP = 1.345
"""Huber's constant: residuals beyond this many standard uncertainties count less [1]."""

READ = ("time", "spin", "turns", "mass", "position")
"""What is read in every lab, and differs between labs of one design."""


class Answer(Struct, frozen=True):
    """I_zz, as one estimator has it, shape (…)."""

    value: Floats
    """[kg*m^2]"""
    low: Floats
    """Lower end of the 95 % interval [kg*m^2]; NaN where the estimator quotes none …"""
    high: Floats
    """… and the upper one."""

    @property
    def half(self) -> Floats:
        """Half of the interval [kg*m^2]."""
        return (self.high - self.low) / 2


Estimator = Callable[[Measurements], Answer]


def _about(value: Floats, half: Floats) -> Answer:
    return Answer(value, value - half, value + half)


def _from_scatter(value: Floats, u: Floats, freedom: int) -> Answer:
    """Make an interval with Student's factor; none without degrees of freedom."""
    from scipy.special import stdtrit

    return _about(value, (float(stdtrit(freedom, 0.975)) if freedom > 0 else math.nan) * u)


def one_lab(labs: Measurements, lab: int) -> Measurements:
    """Take one of L labs of a design."""
    return replace(labs, torque=labs.torque[lab], **{name: getattr(labs, name)[lab] for name in READ})


# --- the scatter tells the uncertainty ----------------------------------------------------------------------


def mean_of_ratios(measured: Measurements) -> Answer:
    """Mean of M/P over the loaded runs, with the standard error of a mean."""
    value, u = fitting.mean_of_ratios(measured.product, measured.torque)
    return _from_scatter(value, u, int(np.sum(_loaded(measured))) - 1)


def median_of_ratios(measured: Measurements) -> Answer:
    """Median of M/P over the loaded runs, with the standard error of a median from their median deviation."""
    loaded = _loaded(measured)
    ratios = measured.torque[..., loaded] / measured.product[..., loaded]
    middle = np.median(ratios, axis=-1)
    spread = MAD_TO_SD * np.median(np.abs(ratios - middle[..., None]), axis=-1)
    count = int(loaded.sum())
    return _from_scatter(middle, math.sqrt(math.pi / 2 / count) * spread, count - 1)


def _loaded(measured: Measurements) -> NDArray[np.bool_]:
    """Which runs have a torque, the same in all labs."""
    return np.asarray(measured.torque.reshape(-1, measured.torque.shape[-1])[0] != 0)


def torque_on_product(measured: Measurements, intercept: bool) -> Answer:
    """Least squares of M on P, through the origin or not."""
    return _from_scatter(*_textbook(measured.product, measured.torque, intercept))


def product_on_torque(measured: Measurements, intercept: bool) -> Answer:
    """Least squares of P on M, through the origin or not; I_zz is one over the slope."""
    slope, u, freedom = _textbook(measured.torque, measured.product, intercept)
    return _from_scatter(1 / slope, u / slope**2, freedom)


def _textbook(x: Floats, y: Floats, intercept: bool) -> tuple[Floats, Floats, int]:
    """Slope, its standard uncertainty, and degrees of freedom."""
    # Two runs of one torque, or one run.
    if intercept and np.any(np.ptp(x, axis=-1) <= 1e-9 * np.abs(x).max()):
        raise ValueError("the points do not determine a line")
    slope, u = fitting.ordinary_line(x, y, intercept)[:2]
    return slope, u, x.shape[-1] - 1 - intercept


def theil_sen(measured: Measurements) -> Answer:
    """Median of the slopes between all pairs of points, M on P, with Sen's interval, as scipy's ``theilslopes``."""
    count = measured.torque.shape[-1]
    first, second = np.triu_indices(count, 1)
    apart = measured.product[..., second] - measured.product[..., first]
    if not apart.all():
        raise ValueError("two points have the same product")
    slopes = np.sort((measured.torque[..., second] - measured.torque[..., first]) / apart, axis=-1)
    # Torques that are used again; the same in all labs.
    alike = np.unique(measured.torque.reshape(-1, count)[0], return_counts=True)[1]
    square = count * (count - 1) * (2 * count + 5) - np.sum(alike * (alike - 1) * (2 * alike + 5))
    reach, pairs = K_95 * math.sqrt(square / 18), len(first)
    low, high = max(round((pairs - reach) / 2) - 1, 0), min(round((pairs + reach) / 2), pairs - 1)
    return Answer(np.median(slopes, axis=-1), slopes[..., low], slopes[..., high])


def polyfit(measured: Measurements) -> Answer:
    """``numpy.polyfit`` of M on P with a constant, interval from its covariance; one lab."""
    with_scatter = len(measured.runs) > 4
    if with_scatter:
        slopes, covariance = np.polyfit(measured.product, measured.torque, 1, cov=True)
        return _about(slopes[0], K_95 * np.sqrt(covariance[0, 0]))
    return _about(np.polyfit(measured.product, measured.torque, 1)[0], np.array(math.nan))


def linregress(measured: Measurements) -> Answer:
    """``scipy.stats.linregress`` of M on P; one lab."""
    from scipy.stats import linregress as regress

    line = regress(measured.product, measured.torque)
    return _from_scatter(np.asarray(line.slope), np.asarray(line.stderr), len(measured.runs) - 2)


# --- the stated uncertainties tell it -----------------------------------------------------------------------


class Errors(Struct, frozen=True):
    """Standard uncertainties of P [rad²/s²] and M [N*m], taken at the measured values."""

    product: Floats
    """Of each run's own, shape (…, n)."""
    torque: Floats
    shared_product: Floats
    """Of each error that runs share, shape (…, n, K)."""
    shared_torque: Floats

    @property
    def independent(self) -> Errors:
        """The same as if runs shared nothing."""
        none = np.zeros((*self.product.shape, 0))
        product, torque = (
            np.sqrt(own**2 + np.sum(shared**2, axis=-1))
            for own, shared in ((self.product, self.shared_product), (self.torque, self.shared_torque))
        )
        return Errors(product, torque, none, none)


_ONTO = dict.fromkeys(("time", "spin", "turns"), "product") | dict.fromkeys(("mass", "position", "g"), "torque")
"""Which of the two an error of a reading is in."""


def stated_errors(measured: Measurements, factors: Mapping[str, float] | None = None) -> Errors:
    """Work out the errors of P and M from the stated ones, each source times a factor if it has one."""
    own = {"product": np.zeros(measured.product.shape), "torque": np.zeros(measured.torque.shape)}
    shared: dict[str, list[Floats]] = {"product": [], "torque": []}
    # The hand that is late is late in all runs: an unknown of the fit, and to a covariance one more shared error.
    columns = [("product", measured.product / measured.time * measured.timing_bias_u, np.ones(len(measured.runs)))]
    for source in measured.sources:
        if source.quantity not in _ONTO or not (source.absolute.any() or source.relative.any()):
            continue
        onto, part = _ONTO[source.quantity], np.asarray(getattr(measured, source.quantity), dtype=float)
        whole = np.asarray(getattr(measured, onto))
        slope = np.divide(whole, part, out=np.zeros(whole.shape), where=part != 0)
        spread = slope * (source.absolute + source.relative * part) * (factors or {}).get(source.name, 1.0)
        counts = np.bincount(source.groups[source.groups >= 0])
        alone = (source.groups >= 0) & (counts[source.groups] == 1)
        own[onto] = np.hypot(own[onto], np.where(alone, spread, 0.0))
        columns += [(onto, spread, source.groups == group) for group in np.flatnonzero(counts > 1)]
    for onto, spread, members in columns:
        other = "torque" if onto == "product" else "product"
        shared[onto].append(np.where(members, spread, 0.0))
        shared[other].append(np.zeros(spread.shape))
    return Errors(own["product"], own["torque"], np.stack(shared["product"], -1), np.stack(shared["torque"], -1))


class Fitted(Struct, frozen=True):
    """Straight lines M = slope P + constant of labs, shape (…)."""

    slope: Floats
    u: Floats
    """NaN where no line was found."""
    constant: Floats
    u_constant: Floats
    chi2: Floats
    adjusted: Floats
    """P, shape (…, n)."""
    farthest: Floats
    """Distance of the run that is farthest from what the others predict, in standard uncertainties of that [1]."""


_TURNS = 60
"""So often at most a line is adjusted."""


def straight_line(x: Floats, y: Floats, errors: Errors, intercept: bool) -> Fitted:
    """Fit lines to points with errors in both variables, as `fitting.fit_line` does it, many labs at once.

    The errors that runs share are unknowns of known width, so that no covariance of n runs is made.
    """
    slope, _, _ = _textbook(x, y, intercept)
    constant = np.mean(y - slope[..., None] * x, axis=-1) if intercept else np.zeros(slope.shape)
    adjusted, kinds = x, 1 + intercept
    unknowns = kinds + errors.shared_product.shape[-1]
    prior = np.zeros((*slope.shape, unknowns - kinds, unknowns + 1))
    prior[..., kinds:-1] = np.eye(unknowns - kinds)
    found = np.zeros(slope.shape, dtype=bool)
    for _turn in range(_TURNS):
        own = np.hypot(errors.torque, slope[..., None] * errors.product)
        pull = errors.shared_torque - slope[..., None, None] * errors.shared_product
        left = y - constant[..., None] - slope[..., None] * x
        design = np.stack([adjusted, np.ones(x.shape)][:kinds], axis=-1)
        rows = np.concatenate([design, pull, left[..., None]], axis=-1) / own[..., None]
        upper: Floats = np.asarray(np.linalg.qr(np.concatenate([rows, prior], axis=-2), mode="r"))
        inverse = np.linalg.inv(upper[..., :unknowns, :unknowns])
        step = (inverse @ upper[..., :unknowns, -1:])[..., 0]
        rest = left - (np.concatenate([design, pull], axis=-1) @ step[..., None])[..., 0]
        off = -slope[..., None] * errors.product**2 * rest / own**2
        # Adjusted P, at which the next derivatives are taken.
        adjusted = x - off - (errors.shared_product @ step[..., kinds:, None])[..., 0]
        slope = slope + step[..., 0]
        constant = constant + (step[..., 1] if intercept else 0.0)
        found = np.abs(step[..., 0]) <= 1e-11 * np.abs(slope) + 1e-300
        if found.all():
            break
    leverage = np.sum((rows[..., :-1] @ inverse) ** 2, axis=-1)
    farthest = np.max(np.abs(rest / own) / np.sqrt(np.maximum(1 - leverage, 1e-12)), axis=-1)
    spread = np.sqrt(np.sum(inverse[..., :kinds, :] ** 2, axis=-1))
    u, u_constant = (np.where(found, spread[..., k], np.nan) for k in (0, kinds - 1))
    return Fitted(slope, u, constant, u_constant, np.sum(upper[..., unknowns:, -1] ** 2, axis=-1), adjusted, farthest)


def weighted(measured: Measurements) -> Answer:
    """Least squares of M on P through the origin, each run weighted by its own variance of M − I_zz P."""
    errors = stated_errors(measured).independent
    product, torque, loaded = measured.product, measured.torque, _loaded(measured)
    rough = np.median(torque[..., loaded] / product[..., loaded], axis=-1)
    weight = 1 / (errors.torque**2 + (rough[..., None] * errors.product) ** 2)
    curvature = np.sum(weight * product**2, axis=-1)
    return _about(np.sum(weight * product * torque, axis=-1) / curvature, K_95 / np.sqrt(curvature))


def york(measured: Measurements, intercept: bool) -> Answer:
    """A line with errors in both variables, every run independent: York's."""
    line = straight_line(measured.product, measured.torque, stated_errors(measured).independent, intercept)
    return _about(line.slope, K_95 * line.u)


def odr(measured: Measurements, intercept: bool) -> Answer:
    """The same line; the scatter tells the uncertainty, as in ``odrpack`` and ``scipy.odr`` (``sd_beta``)."""
    line = straight_line(measured.product, measured.torque, stated_errors(measured).independent, intercept)
    freedom = len(measured.runs) - 1 - intercept
    return _from_scatter(line.slope, line.u * np.sqrt(line.chi2 / max(freedom, 1)), freedom)


def _log_ratios(measured: Measurements) -> tuple[Floats, Floats]:
    """Logarithm of M/P of the loaded runs, and its variance, every run independent."""
    loaded, errors = _loaded(measured), stated_errors(measured).independent
    product, torque = measured.product[..., loaded], measured.torque[..., loaded]
    relative = np.hypot(errors.product[..., loaded] / product, errors.torque[..., loaded] / torque)
    # A torque and its precession of opposite sign have no logarithm: a warning, and no number.
    return np.log(torque / product), relative**2


def log_fit(measured: Measurements) -> Answer:
    """Weighted mean of log(M/P): a line of slope 1 on double logarithmic paper."""
    logs, variance = _log_ratios(measured)
    total = np.sum(1 / variance, axis=-1)
    value = np.exp(np.sum(logs / variance, axis=-1) / total)
    return _about(value, K_95 * value / np.sqrt(total))


def huber(measured: Measurements) -> Answer:
    """Huber's estimate of log(M/P): as `log_fit`, but far runs pull with a bounded force."""
    logs, variance = _log_ratios(measured)
    centre = np.median(logs, axis=-1)
    for _turn in range(100):
        far = np.abs(logs - centre[..., None]) / np.sqrt(variance)
        weight = np.minimum(1.0, _KEEP / np.maximum(far, _KEEP)) / variance
        before, centre = centre, np.sum(weight * logs, axis=-1) / np.sum(weight, axis=-1)
        if not np.any(np.abs(centre - before) >= 1e-12):
            break
    value = np.exp(centre)
    return _about(value, K_95 * value / np.sqrt(np.sum(weight, axis=-1)))


def full_covariance(measured: Measurements, intercept: bool) -> Answer:
    """A line with errors in both variables, and shared ones as shared, the hand's bias among them (ISO/TS 28037)."""
    line = straight_line(measured.product, measured.torque, stated_errors(measured), intercept)
    return _about(line.slope, K_95 * line.u)


def iterated(measured: Measurements) -> Answer:
    """The same with a constant; the errors are taken at the points on the line, not at the measured ones."""
    at = measured
    for _turn in range(4):
        line = straight_line(measured.product, measured.torque, stated_errors(at), intercept=True)
        torque = line.slope[..., None] * line.adjusted + line.constant[..., None]
        at = replace(measured, time=measured.time * measured.product / line.adjusted, torque=torque)
    return _about(line.slope, K_95 * line.u)


def pretested(measured: Measurements) -> Answer:
    """The same; the constant is left out unless it is significant at 95 %."""
    errors = stated_errors(measured)
    free = straight_line(measured.product, measured.torque, errors, intercept=True)
    bound = straight_line(measured.product, measured.torque, errors, intercept=False)
    none = np.abs(free.constant) < K_95 * free.u_constant
    return _about(np.where(none, bound.slope, free.slope), K_95 * np.where(none, bound.u, free.u))


def recommended(measured: Measurements) -> Answer:
    """The tool's own: screened for wrong counts, then fitted in the raw readings with shared errors as shared."""
    if measured.time.ndim == 1:
        fit = fitting.fit(measured, left_out=_slips(measured))
        low, high = fit.inertia.interval_95 or (math.nan, math.nan)
        return Answer(*map(np.asarray, (fit.inertia.value, low, high)))
    ends = np.full((3, len(measured.time)), math.nan)
    for lab, odd in enumerate(_may_have_slips(measured)):
        one = one_lab(measured, lab)
        try:
            inertia = fitting.fit(one, left_out=_slips(one) if odd else ()).inertia
        except fitting.NoFit:
            continue
        ends[:, lab] = inertia.value, *(inertia.interval_95 or (math.nan, math.nan))
    return Answer(*ends)


_PLAIN, _LIKELY = 4.0, 5e-3
"""Screening starts to look at runs 5 standard uncertainties off, and at logs less likely than 0.001: labs that are well
within need not be screened one by one."""


def _may_have_slips(labs: Measurements) -> NDArray[np.bool_]:
    """Which of L labs screening could find something in."""
    from scipy.special import chdtrc

    with np.errstate(all="ignore"):
        line = straight_line(labs.product, labs.torque, stated_errors(labs), intercept=True)
    likely = chdtrc(max(labs.torque.shape[-1] - 2, 1), line.chi2) > _LIKELY
    return np.asarray(~(np.isfinite(line.u) & (line.farthest < _PLAIN) & likely))


def _slips(measured: Measurements) -> tuple[int, ...]:
    """The runs that screening leaves out."""
    outliers: Sequence[fitting.Outlier] = fitting.screen(measured)[0]
    return tuple(outlier.index for outlier in outliers if outlier.slip)


_BALANCED: Mapping[str, Estimator] = {
    "mean of ratios": mean_of_ratios,
    "median of ratios": median_of_ratios,
    "M on P, origin": lambda measured: torque_on_product(measured, intercept=False),
    "P on M, origin": lambda measured: product_on_torque(measured, intercept=False),
    "weighted, origin": weighted,
    "log fit": log_fit,
    "Huber": huber,
    "ODR, origin": lambda measured: odr(measured, intercept=False),
    "York, origin": lambda measured: york(measured, intercept=False),
    "full cov., origin": lambda measured: full_covariance(measured, intercept=False),
}

TAKE_BALANCE = frozenset(_BALANCED)
"""Those that take for granted that the ball is balanced: M0 = 0."""

ESTIMATORS: Mapping[str, Estimator] = {
    **_BALANCED,
    "Theil–Sen": theil_sen,
    "M on P, constant": lambda measured: torque_on_product(measured, intercept=True),
    "P on M, constant": lambda measured: product_on_torque(measured, intercept=True),
    "ODR, constant": lambda measured: odr(measured, intercept=True),
    "York, constant": lambda measured: york(measured, intercept=True),
    "pretest": pretested,
    "full cov., constant": lambda measured: full_covariance(measured, intercept=True),
    "full cov., iterated": iterated,
    "recommended": recommended,
}
"""By the name in the charts."""

STUDENTS: Mapping[str, Estimator] = {
    "numpy.polyfit": polyfit,
    "scipy linregress": linregress,
    **{name: estimate for name, estimate in ESTIMATORS.items() if name != "recommended"},
}
"""All but the tool's own."""
