"""The fit: I_zz from raw readings, with errors carried by what they are shared by.

For each run eq. (8), multiplied by the time so that it has no pole where the torque vanishes, is a condition
between the readings and the unknowns I_zz, M0 (residual torque of an imperfect balance) and b (timing bias):

    s (M + M0)(T − b) = 2π f I_zz ψ̇ + s (I_zz − I) cosθ (2π f)²/(T − b),      s = sign of φ̇ψ̇

Every reading is its truth plus its errors, each error a standard normal number times its uncertainty at the
*true* value. The unknowns and all the errors are found together by least squares (a Gauss–Helmert adjustment):
errors that one run has alone are eliminated row by row, shared ones stay as unknowns with their prior, the
conditions are linearised at the *adjusted* readings, and each step is solved by QR: no covariance matrix
of the data is built, no normal equations are formed, and an uncertainty of zero is just a column of zeros.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from gyrodata import physics
from gyrodata.measurements import Measurements, Source, torque_groups
from gyrodata.physics import Floats

DEFAULT_IMBALANCE_U = 3e-4
"""Prior width of M0 [N*m] where one torque only is there and no balance test: what a balance that drifts
5 degrees in a minute at 400 rpm leaves in a 4-inch steel ball."""

DEFAULT_TRANSVERSE_RATIO = 1.3
"""I/I_zz of a ball with a light rod, where the log does not give I."""

TRANSVERSE_U = 0.2
"""Relative standard uncertainty of I where the log does not give it; I enters only through the tilt."""

OUTLIER = 5.0
"""A run is flagged when it stands off by more than this many standard uncertainties."""

CONTRADICTED = 3.0
"""A balance test is not believed when the runs alone find M0 this many standard uncertainties outside it."""

TURN_COUNTS = (1 / 6, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, *range(1, 31))
"""Revolutions that are likely to have been timed."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with its standard uncertainty (k = 1)."""

    value: float
    u: float | None
    """None where nothing tells it; the reason is in the note of its fit."""


@dataclass(frozen=True, slots=True)
class Share:
    """What one source of uncertainty contributes to u(I_zz)."""

    source: str
    shared: bool
    shared_by: str
    u_inertia: float
    """[kg*m^2]"""
    share: float
    """Of the variance [1]; the shares of a budget add up to 1."""


@dataclass(frozen=True, slots=True)
class Outlier:
    """A run that does not go with the others."""

    index: int
    deviation: float
    """Of its time from what the other runs predict, in standard uncertainties of that difference."""
    turns: float | None
    """Number of revolutions that would explain it."""


@dataclass(frozen=True)
class FitResult:
    """The adjusted unknowns of one log of n runs.

    Convention: Gauss–Helmert least squares in the raw readings; derivatives and proportional uncertainties at
    the adjusted values; standard uncertainties from the stated ones, not scaled by chi-square.
    """

    inertia: Estimate
    """I_zz [kg*m^2]."""
    imbalance: Estimate
    """M0 [N*m]: the torque is M + M0."""
    timing_bias: Estimate
    """b [s]: a clock reading is the true time plus b."""
    covariance: Floats
    """Of (I_zz, M0, b), shape (3, 3)."""
    chi2: float
    dof: int
    fitted_time: Floats
    """Time that the fit predicts for each run [s], shape (n,)."""
    time_u: Floats
    """Standard uncertainty of a run's time about the fit, from the errors that it has alone [s], shape (n,)."""
    deviations: Floats
    """Time minus what the *other* runs predict, over the standard uncertainty of that difference, shape (n,)."""
    response: Floats
    """Relative change of I_zz for a relative change of each run's own M/(φ̇ψ̇) [1], shape (n,)."""
    budget: tuple[Share, ...]
    imbalance_prior: float
    """Prior width of M0 that was used [N*m]."""
    imbalance_free: bool
    """True if the data alone tell M0."""
    contradicted_balance: float | None
    """Width [N*m] that a balance test allowed M0 where the data contradict it, and so were left alone; or None."""
    two_signs: bool
    """True if the log leaves the sign of M0 open and both are in the answer."""
    sense: Floats
    """Sign of φ̇ψ̇ used for each run, shape (n,)."""


# --- the straight line of the textbook ----------------------------------------------------------------------


def chi2_tail(chi2: float, dof: int) -> float:
    """Probability of a chi-square at least this large.

    Parameters
    ----------
    chi2 : float
        Sum of squares, ≥ 0.
    dof : int
        Degrees of freedom, ≥ 1.

    Returns
    -------
    float
        Q(dof/2, chi2/2), the regularised upper incomplete gamma function (DLMF 8.2.4).

    Notes
    -----
    For a whole or half argument it is a finite sum (DLMF 8.4.10 and 8.8.2), so twenty lines save the quarter
    of a second that importing scipy for it would cost at every start.
    """
    half = chi2 / 2
    if half <= 0:
        return 1.0
    odd = dof % 2
    total = math.erfc(math.sqrt(half)) if odd else 0.0
    # Q(a + 1, x) = Q(a, x) + x^a e^-x / Γ(a + 1), in logarithms because e^-x alone underflows.
    for step in range((dof - odd) // 2):
        order = step + odd / 2
        total += math.exp(order * math.log(half) - half - math.lgamma(order + 1))
    return min(total, 1.0)


@dataclass(frozen=True, slots=True)
class Line:
    """Ordinary least squares of y on x, uncertainties from the scatter."""

    slope: Estimate
    intercept: Estimate | None
    covariance: float
    """Of slope and intercept."""
    residual_sd: float | None


def ordinary_line(x: Floats, y: Floats, intercept: bool) -> Line | None:
    """Fit y = slope·x (+ intercept) by ordinary least squares, as a textbook does.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        Any units.
    intercept : bool
        Whether the line has a constant.

    Returns
    -------
    Line or None
        None where x does not determine the unknowns (no spread for a line with a constant).

    Notes
    -----
    By QR of the design. u is s·√(diagonal), s² the sum of squared residuals over n − unknowns; it is None
    where there are no more points than unknowns.
    """
    design = np.column_stack([x, np.ones_like(x)]) if intercept else x[:, None]
    unknowns = design.shape[1]
    q, r = np.linalg.qr(design)
    diagonal = np.abs(np.diag(r))
    if len(x) < unknowns or diagonal.min() <= 1e-9 * np.abs(r[0]).max():
        return None
    solution = np.linalg.solve(r, q.T @ y)
    residuals = y - design @ solution
    freedom = len(x) - unknowns
    inverse = np.linalg.inv(r)
    scale = float(residuals @ residuals) / freedom if freedom > 0 else math.nan
    cov = inverse @ inverse.T * scale
    u = [math.sqrt(cov[j, j]) if freedom > 0 else None for j in range(unknowns)]
    return Line(
        slope=Estimate(float(solution[0]), u[0]),
        intercept=Estimate(float(solution[1]), u[1]) if intercept else None,
        covariance=float(cov[0, 1]) if intercept and freedom > 0 else 0.0,
        residual_sd=math.sqrt(scale) if freedom > 0 else None,
    )


# --- the adjustment -----------------------------------------------------------------------------------------

_QUANTITIES = ("time", "spin", "turns", "mass", "position", "force", "torque", "g", "pitch", "transverse")


_NEGLIGIBLE = 1e-9
"""No reading is exact beyond this relative size; keeps a row whose stated errors are all zero finite."""


@dataclass(frozen=True)
class _Linear:
    """The conditions of n runs, linear in the unknowns and in the errors of S sources."""

    misclosure: Floats
    """Value with the errors that a run has alone set back to zero, shape (n,)."""
    to_unknowns: Floats
    """Derivatives to I_zz, M0 and b, shape (n, 3)."""
    slopes: Floats
    """Derivatives to each source's error, shape (S, n)."""
    alone: Floats
    """The same where a run has that error alone, else 0."""
    own: Floats
    """Variance from the errors that a run has alone, shape (n,)."""


class _Problem:
    """One log's readings and errors as arrays: S sources, n runs, K errors that are shared.

    A source's error that one run has alone is eliminated row by row; one that several runs share is an
    unknown, a column of its own.
    """

    def __init__(self, measured: Measurements, tilted: bool) -> None:
        count = len(measured.runs)
        level = np.zeros(count)
        self.count = count
        self.observed = np.array(
            [
                measured.time,
                measured.spin,
                measured.turns,
                measured.mass,
                measured.position,
                measured.force,
                measured.given_torque,
                np.full(count, measured.g),
                measured.pitch if tilted else level,
                transverse_inertia(measured) if tilted else level,
            ]
        )
        sources = [*measured.sources, *(_tilt_sources(measured) if tilted else ())]
        self.sources = [source for source in sources if source.absolute.any() or source.relative.any()]
        shape = (len(self.sources), count)
        self.quantity = np.array([_QUANTITIES.index(source.quantity) for source in self.sources], dtype=int)
        self.absolute = np.array([source.absolute for source in self.sources]).reshape(shape)
        self.relative = np.array([source.relative for source in self.sources]).reshape(shape)
        self.onto = (np.arange(len(_QUANTITIES))[:, None] == self.quantity).astype(float)
        self.alone = np.zeros(shape)
        self.member = np.full(shape, -1)
        self.shared_count = 0
        for number, source in enumerate(self.sources):
            groups = np.asarray(source.groups)
            sizes = np.bincount(groups[groups >= 0], minlength=1)
            size = np.where(groups >= 0, sizes[groups], 0)
            self.alone[number] = size == 1
            # Groups of two and more get the next columns.
            column = self.shared_count + np.cumsum(sizes > 1) - 1
            self.member[number] = np.where(size > 1, column[groups], -1)
            self.shared_count += int(np.sum(sizes > 1))
        self.from_source, self.from_run = np.nonzero(self.member >= 0)
        self.to_column = self.member[self.from_source, self.from_run]
        self.by_weight = not np.isnan(measured.mass).all()
        self.by_force = not np.isnan(measured.force).all()

    def linearise(self, single: Floats, shared: Floats, sense: Floats, unknowns: Floats) -> _Linear:
        """Linearise the conditions at adjusted readings; extrapolate the errors of one run back to none."""
        values, slopes = self.truth(single, shared)
        value, to_unknowns, to_quantities = self.conditions(values, sense, *unknowns)
        slopes = slopes * to_quantities[self.quantity]
        alone = slopes * self.alone
        floor = _NEGLIGIBLE * to_quantities[0] * values[0]
        own = np.sum(alone**2, axis=0) + floor**2
        return _Linear(value - np.sum(alone * single, axis=0), to_unknowns, slopes, alone, own)

    def truth(self, single: Floats, shared: Floats) -> tuple[Floats, Floats]:
        """Adjusted value of each quantity, shape (10, n), and its derivative to each source's error, (S, n)."""
        errors = np.where(self.member >= 0, np.append(shared, 0.0)[self.member], single)
        scale = 1 + self.onto @ (self.relative * errors)
        values = (self.observed - self.onto @ (self.absolute * errors)) / scale
        slopes = -(self.absolute + self.relative * values[self.quantity]) / scale[self.quantity]
        return values, slopes

    def torque(self, values: Floats) -> tuple[Floats, dict[int, Floats]]:
        """Torque of each run [N*m] and its derivatives by quantity."""
        _, _, _, mass, position, force, given, g, _, _ = values
        if self.by_weight:
            return mass * position * g, {3: position * g, 4: mass * g, 7: mass * position}
        if self.by_force:
            return force * position, {5: position, 4: force}
        return given, {6: np.ones(self.count)}

    def conditions(
        self, values: Floats, sense: Floats, inertia: float, imbalance: float, bias: float
    ) -> tuple[Floats, Floats, Floats]:
        """Evaluate the condition of each run; see the top of the module.

        Returns
        -------
        tuple of ndarray
            The value, shape (n,); its derivatives to I_zz, M0 and b, (n, 3); to each quantity, (10, n).
        """
        torque, chain = self.torque(values)
        time, total = values[0] - bias, torque + imbalance
        spin, pitch, transverse = values[1], values[8], values[9]
        angle = 2 * np.pi * values[2]
        tilt = sense * angle**2 * np.sin(pitch) / time
        difference = inertia - transverse
        to_time = sense * total + difference * tilt / time
        to_torque = sense * time
        to = np.zeros_like(values)
        to[0] = to_time
        to[1] = -angle * inertia
        to[2] = -2 * np.pi * (inertia * spin + 2 * difference * tilt / angle)
        for quantity, slope in chain.items():
            to[quantity] = to_torque * slope
        to[8] = -difference * sense * angle**2 * np.cos(pitch) / time
        to[9] = tilt
        value = sense * total * time - angle * inertia * spin - difference * tilt
        return value, np.column_stack([-angle * spin - tilt, to_torque, -to_time]), to


def transverse_inertia(measured: Measurements) -> Floats:
    """I of each run [kg*m^2]; where the log is silent, a ball with a light rod, the weight on top."""
    if measured.transverse_inertia is not None:
        return measured.transverse_inertia
    load = np.nan_to_num(measured.mass * measured.position**2)
    return DEFAULT_TRANSVERSE_RATIO * _rough_inertia(measured) + load


def _tilt_sources(measured: Measurements) -> list[Source]:
    """Doubt about the pitch (2° unless the log says) and about I, which matter only for a tilted rod."""
    count = len(measured.runs)
    given = measured.transverse_inertia is not None
    return [
        Source(
            "pitch",
            "pitch",
            tuple(range(count)),
            np.full(count, math.radians(2)),
            np.zeros(count),
            "",
            True,
            "2°",
        ),
        Source(
            "transverse_inertia",
            "transverse",
            (0,) * count,
            np.zeros(count),
            np.full(count, 0.02 if given else TRANSVERSE_U),
            "all runs",
            not given,
            "2 %" if given else "20 %",
        ),
    ]


def _rough_inertia(measured: Measurements) -> float:
    """Median of M/(φ̇ψ̇) over the loaded runs [kg*m^2]: a scale, not an answer."""
    ratios = np.abs(measured.torque / measured.product)
    ratios = ratios[ratios > 0]
    return float(np.median(ratios)) if len(ratios) else 1e-3


def torques_differ(torque: Floats) -> bool:
    """Say whether the signed torques of a log differ enough (2 % of the largest) to tell M0 from I_zz.

    Parameters
    ----------
    torque : ndarray, shape (n,)
        [N*m]

    Returns
    -------
    bool
        A property of the design of the experiment, never of how the data came out.
    """
    return bool(np.ptp(torque) > 0.02 * np.abs(torque).max())


@dataclass(frozen=True)
class _Start:
    inertia: float
    imbalance: float


def _robust_start(measured: Measurements, sense: Floats, free: bool, kept: Floats) -> _Start:
    """Solve many pairs of runs for (I_zz, M0) and take the pair that most runs agree with.

    With b = 0 and a horizontal rod the condition is linear: s M T = I_zz 2π f ψ̇ − M0 s T. Up to half of the
    runs may be wrong without moving the median of the misfits of the best pair.
    """
    alone = _Start(_rough_inertia(measured), 0.0)
    index = np.flatnonzero(kept > 0)
    index = index[:: len(index) // 150 + 1]
    if not free or len(index) < 2:
        return alone
    lever = 2 * np.pi * measured.turns[index] * measured.spin[index]
    swing = sense[index] * measured.time[index]
    effort = swing * measured.torque[index]
    first, second = np.triu_indices(len(index), 1)
    step = len(first) // 600 + 1
    first, second = first[::step], second[::step]
    # Two runs: lever·I − swing·M0 = effort for each.
    determinant = lever[second] * swing[first] - lever[first] * swing[second]
    usable = np.abs(determinant) > 1e-3 * np.abs(lever[first] * swing[second])
    first, second, determinant = first[usable], second[usable], determinant[usable]
    inertia = (effort[second] * swing[first] - effort[first] * swing[second]) / determinant
    imbalance = (lever[first] * effort[second] - lever[second] * effort[first]) / determinant
    largest = np.abs(measured.torque[index]).max()
    plausible = (inertia > 0) & (np.abs(imbalance) < 3 * largest)
    if not plausible.any():
        return alone
    inertia, imbalance = inertia[plausible], imbalance[plausible]
    total = np.maximum(np.abs(measured.torque[index] + imbalance[:, None]), 1e-3 * largest)
    chosen = np.median(_misfit(measured, inertia[:, None] * lever / total, index), axis=1)
    best = int(np.argmin(chosen))
    return _Start(float(inertia[best]), float(imbalance[best]))


def _misfit(measured: Measurements, predicted: Floats, index: Any = slice(None)) -> Floats:
    """Time against prediction, in units of the clock's uncertainty and 1 %: a rough scale for rough answers."""
    time = measured.time[index]
    bounded = np.where(np.isfinite(predicted), predicted, time)
    return cast(Floats, np.abs(time - bounded) / np.hypot(_time_u(measured)[index], 0.01 * bounded))


def _time_u(measured: Measurements) -> Floats:
    for source in measured.sources:
        if source.quantity == "time":
            return source.absolute + source.relative * measured.time
    return np.zeros(len(measured.runs))


@dataclass(frozen=True)
class _Adjusted:
    """Where an adjustment ended, linearised there."""

    problem: _Problem
    unknowns: Floats
    """I_zz, M0, b."""
    covariance: Floats
    gain: Floats
    """Derivative of I_zz to the weighted misclosures and to the priors of M0, b and the shared errors."""
    shared: Floats
    slopes: Floats
    """Derivative of each run's condition to each source's error, shape (S, n)."""
    own: Floats
    """Variance of each run's condition from the errors that it has alone, shape (n,)."""
    deviations: Floats
    chi2: float


def _adjust(
    problem: _Problem, sense: Floats, start: _Start, prior_width: float, bias_u: float, kept: Floats
) -> _Adjusted:
    """Iterate the Gauss–Helmert adjustment to convergence.

    The unknowns are scaled to order one: I_zz by its start, M0 by its prior width, b by its own. Runs where
    `kept` is 0 have no weight, but what the others say of them is worked out.
    """
    count, shared_count = problem.count, problem.shared_count
    scale = np.array([start.inertia, prior_width, bias_u])
    unknowns = np.array([1.0, start.imbalance / prior_width, 0.0])
    single, shared = np.zeros_like(problem.absolute), np.zeros(shared_count)
    # Below the runs, one row for each prior: M0, b, and the shared errors.
    rows = np.vstack([np.zeros((count, 3 + shared_count)), np.eye(3 + shared_count)[1:]])
    target = np.zeros(len(rows))
    previous = math.inf
    moved = math.inf
    for turn in range(50):
        at = problem.linearise(single, shared, sense, unknowns * scale)
        if moved > 1e-3:
            # Move back onto the conditions after a large step: only there is the derivative of the distance
            # exact, and a common shrinking of I_zz and all torques gains nothing, however far off the runs are.
            # A run without a weight may still be beyond the pole, M0 = 0: it stays where it was read.
            near = np.abs(at.misclosure) < 0.5 * np.abs(at.to_unknowns[:, 0] * unknowns[0] * scale[0])
            single = -at.alone * (near * at.misclosure / at.own)
            at = problem.linearise(single, shared, sense, unknowns * scale)
        plain = np.zeros((count, 3 + shared_count))
        plain[:, :3] = at.to_unknowns * scale
        plain[problem.from_run, 3 + problem.to_column] = at.slopes[problem.from_source, problem.from_run]
        weight = kept / np.sqrt(at.own)
        rows[:count] = plain * weight[:, None]
        target[:count] = -at.misclosure * weight
        target[count:] = -np.concatenate([unknowns[1:], shared])
        q, r = np.linalg.qr(rows)
        step = _damped(np.linalg.solve(r, q.T @ target), unknowns)
        unknowns = unknowns + step[:3]
        shared = shared + step[3:]
        closed = at.misclosure + plain @ step
        # A run that is left out has no weight, but its prediction too is linear only on its condition.
        single = -at.alone * (closed / at.own)
        chi2 = float(np.sum((closed * weight) ** 2) + np.sum(unknowns[1:] ** 2) + np.sum(shared**2))
        moved = float(np.abs(step).max())
        if moved < 1e-11 or (turn > 3 and abs(previous - chi2) <= 1e-13 * chi2):
            break
        previous = chi2
    inverse = np.linalg.inv(r)
    # Deleted residuals: for a run in the fit the leverage takes it out again, for one outside the
    # uncertainty of the prediction is added.
    inside = at.own * np.maximum(1 - np.sum(q[:count] ** 2, axis=1), _NEGLIGIBLE)
    outside = at.own + np.sum((plain @ inverse) ** 2, axis=1)
    return _Adjusted(
        problem=problem,
        unknowns=unknowns * scale,
        covariance=(inverse @ inverse.T)[:3, :3] * np.outer(scale, scale),
        gain=(inverse[0] @ q.T) * scale[0],
        shared=shared,
        slopes=at.slopes,
        own=at.own,
        deviations=sense * closed / np.sqrt(np.where(kept > 0, inside, outside)),
        chi2=chi2,
    )


def _damped(step: Floats, unknowns: Floats) -> Floats:
    """Shorten a step that would more than halve or double the inertia."""
    limit = 0.5 * abs(unknowns[0])
    return cast(Floats, step * (limit / abs(step[0]))) if abs(step[0]) > limit else step


# --- the recommended fit ------------------------------------------------------------------------------------


def fit(measured: Measurements, tilted: bool = False, left_out: Collection[int] = ()) -> FitResult:
    """Find I_zz, M0 and b of one log, with their uncertainties.

    Parameters
    ----------
    measured : Measurements
        n ≥ 1 runs, at least one of them kept and with a torque.
    tilted : bool
        Use eq. (8) with each run's pitch, not eq. (9).
    left_out : collection of int
        Indices of runs that have no say; what the others predict for them is told.

    Returns
    -------
    FitResult

    Notes
    -----
    M0 has practically no prior (the width is the largest torque) wherever the torques differ, the width of a
    balance test where the log has one that the data do not contradict, and `DEFAULT_IMBALANCE_U` where the
    torques are all the same. b has the prior of `u_time_bias`. Neither is ever switched off by the data.
    """
    kept = np.array([0.0 if i in left_out else 1.0 for i in range(len(measured.runs))])
    differ = torques_differ(measured.torque[kept > 0])
    largest = float(np.abs(measured.torque[kept > 0]).max())
    alone = _fit_signs(measured, tilted, largest if differ else DEFAULT_IMBALANCE_U, differ, kept)
    if measured.imbalance_u is None:
        return alone
    tested = max(measured.imbalance_u(alone.inertia.value), _NEGLIGIBLE * largest)
    # What the runs alone say of the balance, against what the test allows: far apart, the runs win.
    if differ and abs(alone.imbalance.value) > CONTRADICTED * math.hypot(alone.imbalance.u or 0.0, tested):
        return replace(alone, contradicted_balance=tested)
    return _fit_signs(measured, tilted, tested, False, kept)


def _assume_sense(measured: Measurements, imbalance_sign: float) -> Floats:
    """Sense of each run; a run without a weight turns the way of the residual torque."""
    return cast(Floats, np.where(measured.sense == 0, imbalance_sign, measured.sense))


def _fit_signs(measured: Measurements, tilted: bool, width: float, free: bool, kept: Floats) -> FitResult:
    """Fit once, or for both signs of M0 where only unloaded runs without a sense would tell them apart.

    Where both signs remain possible the answer is the mixture of the two, weighted by their likelihoods: its
    mean and its whole spread, not the better half.
    """
    if np.all(measured.sense[kept > 0] != 0):
        return _fit_once(measured, _assume_sense(measured, 1.0), tilted, width, free, kept)
    both = [_fit_once(measured, _assume_sense(measured, sign), tilted, width, free, kept) for sign in (1.0, -1.0)]
    both = [result for sign, result in zip((1.0, -1.0), both, strict=True) if result.imbalance.value * sign > 0] or both
    both.sort(key=lambda result: result.chi2)
    if len(both) == 1:
        return both[0]
    odds = math.exp(-0.5 * min(both[1].chi2 - both[0].chi2, 1400.0))
    return both[0] if odds < 1e-4 else _mixture(both[0], both[1], 1 / (1 + odds))


def _mixture(first: FitResult, second: FitResult, weight: float) -> FitResult:
    """Put two possible answers into one; all but the unknowns is told of the likelier, `first`."""
    pair = ((weight, first), (1 - weight, second))
    means = [np.array([r.inertia.value, r.imbalance.value, r.timing_bias.value]) for _, r in pair]
    mean = pair[0][0] * means[0] + pair[1][0] * means[1]
    covariance = np.zeros((3, 3))
    for (share, result), value in zip(pair, means, strict=True):
        covariance += share * (result.covariance + np.outer(value - mean, value - mean))
    grown = covariance[0, 0] - first.covariance[0, 0]
    budget = list(first.budget)
    if grown > 0:
        budget.append(Share("imbalance_sign", True, "all runs", math.sqrt(grown), 0.0))
    inertia, imbalance, bias = (Estimate(float(mean[j]), math.sqrt(covariance[j, j])) for j in range(3))
    return replace(
        first,
        inertia=inertia,
        imbalance=imbalance,
        timing_bias=bias,
        covariance=covariance,
        budget=_normalised(budget),
        two_signs=True,
    )


def _fit_once(measured: Measurements, sense: Floats, tilted: bool, width: float, free: bool, kept: Floats) -> FitResult:
    start = _robust_start(measured, sense, free, kept)
    adjusted = _adjust(_Problem(measured, tilted), sense, start, width, measured.timing_bias_u, kept)
    inertia, imbalance, bias = (float(value) for value in adjusted.unknowns)
    u = np.sqrt(np.diag(adjusted.covariance)[:3])
    fitted, own = _predict(adjusted, sense)
    return FitResult(
        inertia=Estimate(inertia, float(u[0])),
        imbalance=Estimate(imbalance, float(u[1])),
        timing_bias=Estimate(bias, float(u[2]) if measured.timing_bias_u > 0 else 0.0),
        covariance=adjusted.covariance[:3, :3],
        # A prior that says nothing is not a datum: neither its pull nor its degree of freedom counts.
        chi2=adjusted.chi2 - ((imbalance / width) ** 2 if free else 0.0),
        dof=int(kept.sum()) - 1 - int(free),
        fitted_time=fitted,
        time_u=own,
        deviations=adjusted.deviations,
        response=_response(adjusted),
        budget=_budget(adjusted),
        imbalance_prior=width,
        imbalance_free=free,
        contradicted_balance=None,
        two_signs=False,
        sense=sense,
    )


def _predict(adjusted: _Adjusted, sense: Floats) -> tuple[Floats, Floats]:
    """Time that the fit predicts from each run's other readings, and the spread expected about it [s]."""
    problem = adjusted.problem
    values, _ = problem.truth(np.zeros_like(adjusted.slopes), adjusted.shared)
    inertia, imbalance, bias = (float(value) for value in adjusted.unknowns)
    torque = problem.torque(values)[0] + imbalance
    rate = np.abs(physics.precession_rate(torque, sense * values[1], inertia, values[9], values[8]))
    with np.errstate(divide="ignore"):
        # The condition is the time multiplied by the torque at work, and so is its spread.
        return 2 * np.pi * values[2] / rate + bias, np.sqrt(adjusted.own) / np.abs(torque)


def _budget(adjusted: _Adjusted) -> tuple[Share, ...]:
    """Split u²(I_zz) by source: the answer is linear in every standardised error, so the squares add up."""
    problem, gain, count = adjusted.problem, adjusted.gain, adjusted.problem.count
    variances = np.sum(gain[:count] ** 2 * (adjusted.slopes * problem.alone) ** 2 / adjusted.own, axis=1)
    owners = np.zeros(problem.shared_count, dtype=int)
    owners[problem.to_column] = problem.from_source
    np.add.at(variances, owners, gain[count + 2 :] ** 2)
    shares = [
        Share(source.name, source.shared, source.shared_by, math.sqrt(variance), 0.0)
        for source, variance in zip(problem.sources, variances, strict=True)
        if variance > 0
    ]
    for row, name, words in (
        (count, "imbalance", "all runs"),
        (count + 1, "time_bias", "all runs (the same hand)"),
    ):
        if gain[row]:
            shares.append(Share(name, True, words, abs(float(gain[row])), 0.0))
    return _normalised(shares)


def _response(adjusted: _Adjusted) -> Floats:
    """Response of I_zz to each run's own inertia: M/(φ̇ψ̇) too high by r raises the condition by 2π f I_zz ψ̇ r."""
    problem = adjusted.problem
    lever = 2 * np.pi * problem.observed[2] * problem.observed[1]
    return cast(Floats, -adjusted.gain[: problem.count] * lever / np.sqrt(adjusted.own))


def _normalised(shares: list[Share]) -> tuple[Share, ...]:
    total = math.fsum(share.u_inertia**2 for share in shares)
    filled = (replace(share, share=share.u_inertia**2 / total if total else 0.0) for share in shares)
    return tuple(sorted(filled, key=lambda share: -share.share))


# --- screening ----------------------------------------------------------------------------------------------


def screen(measured: Measurements, tilted: bool = False) -> list[Outlier]:
    """Find the runs that do not go with the others, and the turn count that would explain each.

    Parameters
    ----------
    measured : Measurements
        n runs.
    tilted : bool
        Use eq. (8).

    Returns
    -------
    list of Outlier
        In the order of the log; empty for fewer than four runs, or where more than a third would have to go:
        then the stated uncertainties are at fault, not the runs.

    Notes
    -----
    A run is compared with what the fit of the *others* predicts, in units of the uncertainty of that
    difference, or of the runs' own scatter (1.4826 × median) where that is larger. Where the scatter is more
    than twice what was stated, a run is also compared with the median run of its torque: misfits between the
    torques must not hide one bad timing among good ones.
    """
    count = len(measured.runs)
    if count < 4:
        return []
    out = _far_from_start(measured)
    found: list[Outlier] = []
    for _round in range(6):
        kept = np.array([i not in out for i in range(count)])
        if len(out) > count / 3 or kept.sum() < 3 or not np.abs(measured.torque[kept]).any():
            return []
        result = fit(measured, tilted, out)
        typical = max(1.0, 1.4826 * float(np.median(np.abs(result.deviations[kept]))))
        far = np.flatnonzero((np.abs(result.deviations) > OUTLIER * typical) | _far_within(measured, result, typical))
        found = [
            Outlier(int(i), float(result.deviations[i]), _explaining_turns(measured, result, int(i), typical))
            for i in far
        ]
        fresh = {outlier.index for outlier in found}
        if fresh == out:
            break
        out = fresh
    return found if len(found) <= count / 3 else []


def _far_within(measured: Measurements, result: FitResult, typical: float) -> Any:
    """Which runs are far from the others of their torque, where the log scatters more than it should."""
    apart = np.full(len(measured.runs), np.nan)
    if typical > 2:
        for group in torque_groups(measured):
            if len(group) >= 4:
                apart[group] = np.abs(result.deviations[group] - np.median(result.deviations[group]))
    grouped = apart[~np.isnan(apart)]
    if not grouped.any():
        return np.zeros(len(apart), dtype=bool)
    return np.nan_to_num(apart) > OUTLIER * 1.4826 * float(np.median(grouped))


def _far_from_start(measured: Measurements) -> set[int]:
    """Runs far from the line that most runs agree with: a first guess, from which screening goes on."""
    everything = np.ones(len(measured.runs))
    start = _robust_start(measured, _assume_sense(measured, 1.0), torques_differ(measured.torque), everything)
    total = np.abs(measured.torque + start.imbalance)
    with np.errstate(divide="ignore"):
        predicted = start.inertia * 2 * np.pi * measured.turns * measured.spin / total
    misfit = _misfit(measured, predicted)
    misfit[measured.torque == 0] = 0.0
    scale = max(1.0, 1.4826 * float(np.median(misfit)))
    return {int(i) for i in np.flatnonzero(misfit > OUTLIER * scale)}


def _explaining_turns(measured: Measurements, result: FitResult, index: int, typical: float) -> float | None:
    """Turn count with which a run would fit within 3 of its own spreads, the nearest one; None if none does."""
    bias = result.timing_bias.value
    one_turn = (result.fitted_time[index] - bias) / measured.turns[index]
    spread = abs((measured.time[index] - result.fitted_time[index]) / result.deviations[index]) * typical
    candidates = {*TURN_COUNTS, *(measured.turns[index] + step for step in (-1, -0.5, 0.5, 1))}
    misfits = {
        # What is uncertain of one turn is as much more uncertain of several.
        turns: abs(measured.time[index] - bias - turns * one_turn) / (spread * max(1.0, turns / measured.turns[index]))
        for turns in candidates
        if turns > 0 and not math.isclose(turns, measured.turns[index])
    }
    best = min(sorted(misfits), key=lambda turns: misfits[turns])
    return best if misfits[best] < 3 else None
