"""The Gauss–Helmert adjustment is one weighted least-squares problem.

Its solution contains I_zz, M0, b and all errors of the readings.

For each run eq. (8), multiplied by the time so that it has no pole at zero torque, is a
condition between the readings and the unknowns I_zz, M0 (residual torque of an
imperfect balance) and b (timing bias):

    s (M + M0)(T − b) = 2π f I_zz ψ̇ + s (I_zz − I) cosθ (2π f)²/(T − b),      s = sign
    of φ̇ψ̇

If the log states the width of the weights, I_zz includes what the weight adds to it,
because the weight spins as well. Every reading is its true value plus its errors; each
error is a standard normal number times its uncertainty at the
*true* value. Errors of a single run are eliminated row by row; errors that runs share
are unknowns with a prior. The conditions are linearised at the *adjusted* readings, and
each step is solved by QR: normal equations would lose digits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct

from gyrodata.measurements import (
    DEFAULT_TRANSVERSE_RATIO,
    REVOLUTION,
    Measurements,
    balance_sources,
    share_of_mean,
)
from gyrodata.physics import Floats

ROWS = {
    "time": 0,
    "spin": 1,
    "turns": 2,
    "mass": 3,
    "force": 3,
    "torque": 3,
    "position": 4,
    "g": 5,
    "pitch": 6,
    "transverse": 7,
    "added": 8,
    "balance": 9,
}
"""Row of each quantity in an array of shape (10, n). The torque is load × position × g:
a log has masses, forces (then g counts as 1) or torques (then the position does, too).
The balance is the difference of a weight's M0 from that of the log [N*m]; nobody reads
it, so it is zero."""

QUANTITIES = 10
"""Number of rows."""

TIME, SPIN, TURNS, LOAD, POSITION, G, PITCH, TRANSVERSE, ADDED, BALANCE = range(
    QUANTITIES
)

MAD_TO_SD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation [1].
"""

NEGLIGIBLE = 1e-9
"""Smallest relative error of a reading; keeps rows finite whose stated errors are all
zero."""

MANY = 500
"""With more runs than this, a sample of them is enough to estimate the size of an
effect."""


class NoFit(Exception):  # noqa: N818 - an outcome of a fit, not a fault of gyro
    """The runs have no credible solution; the text gives the reason."""


# --- the conditions ---


class Widths(Struct, frozen=True):
    """Widths of the errors that a log knows only roughly."""

    scatter: float
    """Factor s on the errors of single runs [1]."""
    residual_torque: float | None
    """Width of M0 [N*m]; None: the smallest torque."""
    level: float = 0.0
    """Width of the difference of M0 between weights [N*m]."""


class Linear(Struct, frozen=True):
    """The conditions of n runs, linear in the unknowns and the errors of S sources."""

    values: Floats
    """Adjusted value of each quantity, shape (10, n)."""
    torque: Floats
    """Adjusted torque of each weight, with its balance [N*m], shape (n,)."""
    misclosure: Floats
    """Value of each condition if the errors of single runs are zero, shape (n,)."""
    to_unknowns: Floats
    """Derivatives with respect to I_zz, M0 and b, shape (n, 3)."""
    slopes: Floats
    """Derivatives with respect to each source's error, shape (S, n)."""
    independent: Floats
    """The same for errors of single runs, 0 for shared errors, shape (S, n)."""
    independent_variance: Floats
    """Variance of each condition from the errors of single runs, shape (n,)."""


class Problem:
    """The readings of a log and their errors: S sources, n runs, K shared errors.

    `observed` contains the readings, shape (10, n). `width` is that of the prior of M0
    of each day [N*m]. `member` contains the number of the shared error in each reading,
    or −1, shape (S, n); `from_source`, `from_run` and `to_column` list the same pairs.
    """

    def __init__(self, measured: Measurements, tilted: bool, widths: Widths) -> None:
        """Number the errors, which have some widths; that of M0 is not None."""
        count = len(measured.runs)
        self.measured = measured
        self.count = count
        self.tilted = tilted
        self.observed = _observed(measured, tilted)
        assert widths.residual_torque is not None
        self.width = widths.residual_torque
        of_balance = balance_sources(measured, self.width, widths.level)
        sources = [*measured.sources, *of_balance]
        if not tilted:
            sources = [s for s in sources if s.quantity not in ("pitch", "transverse")]
        # Exact readings have no errors.
        sources = [s for s in sources if s.absolute.any() or s.relative.any()]
        self.sources = sources
        shape = len(sources), count
        self.absolute = np.reshape([s.absolute for s in sources], shape)
        self.relative = np.reshape([s.relative for s in sources], shape)
        self.quantity = np.array([ROWS[s.quantity] for s in sources], int)
        # Sums the errors of the sources of each quantity, shape (10, S).
        is_of_quantity = np.arange(QUANTITIES)[:, None] == self.quantity
        self.onto = is_of_quantity.astype(float)
        self._number_shared_errors()
        factor = np.where(self.independent > 0, widths.scatter, 1.0)
        self.absolute *= factor
        self.relative *= factor

    def _number_shared_errors(self) -> None:
        """Number the shared errors, in the order of sources and groups."""
        self.independent = np.zeros(self.absolute.shape)
        self.member = np.full(self.absolute.shape, -1)
        owners: list[int] = []
        for number, source in enumerate(self.sources):
            groups = source.groups
            touched = groups >= 0
            sizes = np.bincount(groups[touched], minlength=1)
            if source.quantity == "balance":
                # A weight with a single run has a balance too, which does not scatter
                # with the run's own errors.
                sizes *= self.count
            size = np.where(touched, sizes[groups], 0)
            self.independent[number] = size == 1
            is_shared = sizes > 1
            column = len(owners) + np.cumsum(is_shared) - 1
            self.member[number] = np.where(size > 1, column[groups], -1)
            owners += [number] * int(np.sum(is_shared))
        self.owners = np.array(owners, dtype=int)
        """The source of each shared error."""
        self.from_source, self.from_run = np.nonzero(self.member >= 0)
        self.to_column = self.member[self.from_source, self.from_run]

    def is_from(self, *names: str) -> Any:
        """Return whether each source has one of these names, shape (S,)."""
        return np.array([source.name in names for source in self.sources], dtype=bool)

    def owned_by(self, *names: str) -> Any:
        """Return whether each shared error is from one of these sources, shape (K,)."""
        return self.is_from(*names)[self.owners]

    def errors_of(self, shared: Floats) -> Floats:
        """Return the error of each source in each run, shape (S, n).

        It is zero for errors of single runs.
        """
        of_column = np.append(shared, 0.0)
        errors: Floats = of_column[self.member]
        return errors

    def linearise(
        self, single: Floats, shared: Floats, sense: Floats, unknowns: Floats
    ) -> Linear:
        """Linearise each run's condition at adjusted readings.

        Extrapolate the errors of single runs to zero.
        """
        # An error is either in `single` or in `shared`; the other one is zero.
        shared_errors = self.errors_of(shared)
        errors = single + shared_errors
        values, scale = self._true_values(errors)
        inertia, residual_torque, bias = unknowns
        clock, spin, turns, load, position, g, _, _, added, balance = values
        time = clock - bias
        minus_angle = -REVOLUTION * turns
        force = load * g
        applied_torque = force * position
        torque = applied_torque + balance
        net_torque = torque + residual_torque
        signed = sense * time
        push = sense * net_torque
        total_inertia = inertia + added
        moment = total_inertia * spin
        spin_term = minus_angle * moment
        torque_term = push * time
        misclosure = torque_term + spin_term
        # Derivatives with respect to each quantity, in the order of the rows.
        signed_load = signed * load
        arm = position * g
        level = np.zeros_like(time)
        by_spin = minus_angle * total_inertia
        by_turns = -REVOLUTION * moment
        by_load = signed * arm
        by_position = signed_load * g
        by_g = signed_load * position
        by_added = minus_angle * spin
        to = np.array(
            [
                push,
                by_spin,
                by_turns,
                by_load,
                by_position,
                by_g,
                level,
                level,
                by_added,
                signed,
            ]
        )
        if self.tilted:
            misclosure += _add_tilt(to, values, total_inertia, time, sense)
        # A larger I_zz is like an inertia of the weight, and b shortens the time.
        to_unknowns = np.array([to[ADDED], signed, -to[TIME]]).T
        # Derivative of a reading's true value with respect to each error.
        quantity = self.quantity
        factors = 1 + self.relative * errors
        spread = self.relative * values[quantity]
        by_relative = spread / factors
        by_absolute = self.absolute / scale[quantity]
        by_error = by_relative + by_absolute
        to_reading = to[quantity]
        slopes = -by_error * to_reading
        independent = slopes * self.independent
        # The floor uses the term of the spin, which is not zero if the torque is zero.
        floor = NEGLIGIBLE * spin_term
        variance = (independent**2).sum(axis=0) + floor**2
        of_single = independent * single
        misclosure -= of_single.sum(axis=0)
        return Linear(
            values, torque, misclosure, to_unknowns, slopes, independent, variance
        )

    def _true_values(self, errors: Floats) -> tuple[Floats, Floats]:
        """Return the readings without their errors, and the product of the factors.

        Relative errors multiply. If they were added, a shared factor that makes all
        true values smaller would also make each run's own error smaller: a gain that
        grows with the number of runs.
        """
        relative = self.relative * errors
        scale = np.ones_like(self.observed)
        np.multiply.at(scale, self.quantity, 1 + relative)
        absolute = self.absolute * errors
        shift = self.onto @ absolute
        unscaled = self.observed - shift
        return unscaled / scale, scale

    def derivatives(self, linear: Linear, scale: Floats) -> Floats:
        """Return the derivatives with respect to all unknowns, shape (n, 3 + K).

        I_zz, M0 and b are counted in the units `scale`.
        """
        derivatives = np.zeros((self.count, 3 + len(self.owners)))
        derivatives[:, :3] = linear.to_unknowns * scale
        column = 3 + self.to_column
        of_shared = linear.slopes[self.from_source, self.from_run]
        derivatives[self.from_run, column] = of_shared
        return derivatives


def _add_tilt(
    to: Floats, values: Floats, total_inertia: Floats, time: Floats, sense: Floats
) -> Floats:
    """Return the term of a tilted rod, and add its derivatives to `to`."""
    turns = values[TURNS]
    pitch = values[PITCH]
    transverse = values[TRANSVERSE]
    angle = REVOLUTION * turns
    difference = total_inertia - transverse
    square = sense * angle**2 / time
    tilt = square * np.sin(pitch)
    excess = difference * tilt
    to[TIME] += excess / time
    to[TURNS] -= 2 * REVOLUTION * difference * tilt / angle
    to[PITCH] = -difference * square * np.cos(pitch)
    to[TRANSVERSE] = tilt
    to[ADDED] -= tilt
    term: Floats = -excess
    return term


def _observed(measured: Measurements, tilted: bool) -> Floats:
    """Return the readings, shape (10, n)."""
    observed = np.zeros((QUANTITIES, len(measured.runs)))
    # The angle that steady precession would have swept in the same time.
    observed[TIME] = measured.time
    observed[TURNS] = measured.turns * measured.slowing
    observed[SPIN] = measured.corrected_spin
    observed[ADDED] = measured.added
    is_torque = not np.isnan(measured.given_torque).all()
    observed[LOAD] = measured.load
    observed[POSITION] = 1.0 if is_torque else measured.position
    observed[G] = 1.0 if np.isnan(measured.mass).all() else measured.g
    if tilted:
        observed[PITCH] = measured.pitch
        observed[TRANSVERSE] = transverse_inertia(measured)
    return observed


def torques_differ(torque: Floats) -> bool:
    """Return whether the torques of a log, with signs, differ by 2 % of the largest.

    M0 can be determined only if this is true.
    """
    largest = np.abs(torque).max()
    return bool(np.ptp(torque) > 0.02 * largest)


def transverse_inertia(measured: Measurements) -> Floats:
    """Return I of each run [kg*m^2].

    If the log does not state it, that of a ball with a light rod and the weight.
    """
    if measured.transverse_inertia is not None:
        return measured.transverse_inertia
    load = np.nan_to_num(measured.mass * measured.position**2)
    rough = rough_inertia(measured)
    if measured.nutation_ratio is not None:
        inertia = measured.nutation_ratio * rough
        of_body = np.nanmedian(inertia - load)
        of_others = of_body + load
        is_unknown = np.isnan(inertia)
        return np.where(is_unknown, of_others, inertia)
    return DEFAULT_TRANSVERSE_RATIO * rough + load


def rough_inertia(measured: Measurements) -> float:
    """Compute the median of M/(φ̇ψ̇) of the loaded runs [kg*m^2]."""
    ratios = measured.single_inertia
    is_loaded = ratios > 0
    return median(ratios[is_loaded]) if is_loaded.any() else 1e-3


def median(values: Floats) -> float:
    """Compute the median of at least one value.

    `np.median` would import numpy.ma, a tenth of the start-up time.
    """
    ordered = np.sort(values)
    half = len(ordered) // 2
    below = ordered[-1 - half]
    return float(below + ordered[half]) / 2


# --- the start ---


class Start(Struct, frozen=True):
    """Rough values of the unknowns, or arrays of them."""

    inertia: Any
    """[kg*m^2]"""
    residual_torque: Any
    """M0 [N*m]"""


_SAMPLE = 150
"""Number of runs that is enough for a start."""

_ODD = 5.0
"""Misfit of a run that is far from a start; larger ones count the same."""


def sample(measured: Measurements, kept: Floats) -> Any:
    """Return the indices of the kept runs, at most 150.

    An even stride could select a single torque if the weights come in the same order
    again and again.
    """
    index = np.flatnonzero(kept > 0)
    if len(index) <= _SAMPLE:
        return index
    drawn = np.random.default_rng(0).choice(index, _SAMPLE, replace=False)
    return np.sort(drawn)


@np.errstate(divide="ignore", invalid="ignore")
def first_guess(measured: Measurements, sense: Floats, kept: Floats) -> Start:
    """Return the I_zz and M0 of the pair of runs that agrees with most runs.

    With b = 0 and a level rod the runs are on the line M = I_zz φ̇ψ̇ − M0.
    """
    index = sample(measured, kept)
    torque = measured.torque[index]
    product = sense[index] * np.abs(measured.product[index])
    rough = Start(rough_inertia(measured), 0.0)
    if not torques_differ(torque):
        return rough
    count = len(index)
    first, second = _pairs(count)
    apart = product[second] - product[first]
    inertia = (torque[second] - torque[first]) / apart
    imbalance = inertia * product[first] - torque[first]
    size = np.abs(product[second])
    is_apart = np.abs(apart) > 1e-3 * size
    largest = np.abs(torque).max()
    is_small = np.abs(imbalance) < 3 * largest
    usable = is_apart & (inertia > 0) & is_small
    if not usable.any():
        return rough
    lines = Start(inertia[usable, None], imbalance[usable, None])
    misfit = misfits(measured, lines, index)
    # All outliers count the same, so that the pair with the fewest outliers wins; of
    # equal pairs the smaller M0 wins.
    half = count // 2
    medians = np.partition(misfit, half, axis=1)[:, half]
    scatter = max(1.0, MAD_TO_SD * float(medians.min()))
    relative = misfit / scatter
    limited = np.minimum(relative, _ODD)
    squares = limited**2
    cost = squares.sum(axis=1)
    cost += (imbalance[usable] / lightest_torque(measured, kept)) ** 2
    best = cost.argmin()
    m0 = float(lines.residual_torque[best, 0])
    return Start(float(lines.inertia[best, 0]), m0)


def _pairs(count: int) -> tuple[Any, Any]:
    """Return pairs of runs: all of them, or about 80 that are spread evenly."""
    first, second = np.triu_indices(count, 1)
    step = len(first) // 80 + 1
    return first[::step], second[::step]


def lightest_torque(measured: Measurements, kept: Floats) -> float:
    """Return the smallest torque of the kept runs that is not zero [N*m]."""
    sizes = np.abs(measured.torque)
    is_loaded = (kept > 0) & (sizes > 0)
    return float(sizes[is_loaded].min(initial=sizes.max()))


def misfits(measured: Measurements, start: Start, index: Any = slice(None)) -> Floats:
    """Compare times with those of a start, in their uncertainty and 1 %."""
    time = measured.time[index]
    with np.errstate(divide="ignore"):
        torque = measured.torque[index]
        net_torque = torque + start.residual_torque
        product = net_torque / start.inertia
        predicted = time * np.abs(measured.product[index] / product)
    exists = np.isfinite(predicted)
    predicted = np.where(exists, predicted, time)
    u = np.zeros_like(measured.time)
    for source in measured.sources:
        if source.quantity == "time":
            u = source.absolute + source.relative * measured.time
            break
    size = np.hypot(u[index], 0.01 * predicted)
    difference = np.abs(time - predicted)
    misfit: Floats = difference / size
    return misfit


# --- the adjustment ---

MAX_ITERATIONS = 100
"""Number of steps after which an adjustment will not converge."""

NO_CONVERGENCE = "the fit does not converge"

LOST = 1e-3
"""An I_zz below this multiple of its start, or above the inverse, does not come back.
"""

FULL_STEPS = 20
"""Number of full steps; most logs need less than half of it. Later steps become
shorter."""


FACTOR = 3.0
ASTRAY = 30.0
"""Largest ratio of an answer and its robust start, and of a fit with wrong runs."""


class Adjusted(Struct, frozen=True):
    """The end of an adjustment, linearised there."""

    problem: Problem
    unknowns: Floats
    """I_zz [kg*m^2], M0 [N*m] and b [s], shape (3,)."""
    covariance: Floats
    """Covariance of the unknowns, shape (3, 3)."""
    gain: Floats
    """Derivative of I_zz with respect to the weighted misclosures and to the priors of
    M0, b and the shared errors."""
    shared: Floats
    """The K shared errors, in their standard uncertainties, shape (K,)."""
    slopes: Floats
    """Derivative of each run's condition with respect to each source's error, shape (S,
    n)."""
    scale: Floats
    """Units of the unknowns in the steps: a start, and the widths of the priors, shape
    (3,)."""
    rows: Floats
    """Derivatives of the conditions to all unknowns, over their standard uncertainties,
    shape (n, 3 + K)."""
    kept: Floats
    """1 for a run that is used, 0 for one that is left out, shape (n,)."""
    weighted: Floats
    """Misclosure of each run over its standard uncertainty, 0 for a run that is left
    out, shape (n,)."""
    independent_variance: Floats
    """Variance of each run's condition from the errors of this run alone, shape (n,).
    """
    deviations: Floats
    """Time minus the prediction of the other runs, over the standard uncertainty of
    this difference, shape (n,)."""
    influence: Floats
    """Change of I_zz if a run is left out, to first order (DFBETA) [kg*m^2], shape
    (n,)."""
    chi2: float


# Values that are not finite are refused after the iteration.
@np.errstate(all="ignore")
def adjust(
    problem: Problem,
    sense: Floats,
    start: Start,
    kept: Floats,
    *,
    factor: float = FACTOR,
) -> Adjusted:
    """Repeat the linear least squares until it converges to a credible solution.

    Parameters
    ----------
    problem : Problem
    sense : ndarray, shape (n,)
        Sign of φ̇ψ̇ of each run.
    start : Start
        Rough unknowns.
    kept : ndarray, shape (n,)
        1 for a run in the fit, 0 for one that is left out; its time is still predicted.
    factor : float
        Largest ratio of I_zz and its start, or of the start and I_zz.

    Raises
    ------
    NoFit
        If there is no credible solution.
    """
    scale = _scale(problem, start)
    count = problem.count
    unknowns = np.zeros(3 + len(problem.owners))
    unknowns[:2] = 1.0, start.residual_torque / scale[1]
    single = np.zeros_like(problem.absolute)
    moves: list[float] = []
    costs: list[float] = []
    jumped = 0.0
    for turn in range(MAX_ITERATIONS):
        shared = unknowns[3:]
        current = unknowns[:3] * scale
        at = problem.linearise(single, shared, sense, current)
        if turn >= FULL_STEPS or jumped > 0.03:
            single = _onto_conditions(at, current[0])
            at = problem.linearise(single, shared, sense, current)
        derivatives = problem.derivatives(at, scale)
        weight = kept / np.sqrt(at.independent_variance)
        rows = _weighted_rows(derivatives, at.misclosure, weight, unknowns)
        triangle, step = _least_squares_step(rows)
        step = _shortened(step, unknowns[0], turn)
        unknowns = unknowns + step
        remaining = at.misclosure + derivatives @ step
        # The prediction for a run that is left out is also linear only on its
        # condition.
        single = -at.independent * (remaining / at.independent_variance)
        weighted = weight * remaining
        of_priors = unknowns[1:] @ unknowns[1:]
        of_runs = weighted @ weighted
        costs.append(float(of_runs + of_priors))
        if not LOST < unknowns[0] < 1 / LOST:
            raise NoFit(NO_CONVERGENCE)
        sizes = np.abs(step)
        moves.append(float(sizes.max()))
        jumped = float(sizes[:2].max())
        if _has_converged(moves, costs):
            break
    else:
        raise NoFit(NO_CONVERGENCE)
    inverse = np.linalg.inv(triangle)
    conditions = rows[:, :-1]
    q = conditions @ inverse
    leverage = (q[:count] ** 2).sum(axis=1)
    rest = np.maximum(1 - leverage, NEGLIGIBLE)
    # The leverage of a run in the fit is removed; for a run outside, the variance of
    # its prediction is added.
    predicted = ((derivatives @ inverse) ** 2).sum(axis=1)
    outside = at.independent_variance + predicted
    inside = at.independent_variance * rest
    variance = np.where(kept > 0, inside, outside)
    gain = q @ inverse[0] * scale[0]
    covariance = inverse[:3] @ inverse[:3].T
    adjusted = Adjusted(
        problem=problem,
        unknowns=unknowns[:3] * scale,
        covariance=covariance * np.outer(scale, scale),
        gain=gain,
        shared=unknowns[3:],
        slopes=at.slopes,
        scale=scale,
        rows=conditions[:count],
        kept=kept,
        weighted=weighted,
        independent_variance=at.independent_variance,
        deviations=sense * remaining / np.sqrt(variance),
        influence=gain[:count] * weighted / rest,
        chi2=costs[-1],
    )
    _insist_on_solution(adjusted, start.inertia, factor)
    return adjusted


def _has_converged(moves: Sequence[float], costs: Sequence[float]) -> bool:
    """Return whether the next step would change nothing.

    `moves` contains the largest change of an unknown in each step, and `costs` the
    chi-square after it.
    """
    if len(moves) < 2:
        return False
    last, moved = moves[-2:]
    before, cost = costs[-2:]
    # Steps shrink by a constant factor, which predicts the size of the next one.
    next_is_small = moved**2 <= 1e-8 * min(last, 1.0)
    is_flat = len(moves) > 4 and abs(before - cost) <= 1e-13 * cost
    return next_is_small or is_flat


def _scale(problem: Problem, start: Start) -> Floats:
    """Return the units of the unknowns in the steps, shape (3,).

    I_zz [kg*m^2] is of the order of its start, M0 [N*m] and b [s] of the widths of
    their priors. M0 and b are means over all days.
    """
    measured = problem.measured
    share = share_of_mean(measured.day)
    widths = share * np.array([problem.width, measured.timing_bias_u])
    return np.array([start.inertia, *widths])


def _weighted_rows(
    derivatives: Floats, misclosure: Floats, weight: Floats, unknowns: Floats
) -> Floats:
    """Return the weighted conditions of n runs, and the priors; last comes the target.

    There is a prior for each unknown except I_zz.
    """
    conditions = np.column_stack((derivatives, -misclosure))
    weighted = weight[:, None] * conditions
    directions = np.eye(len(unknowns))[1:]
    priors = np.column_stack((directions, -unknowns[1:]))
    return np.vstack((weighted, priors))


def _least_squares_step(rows: Floats) -> tuple[Floats, Floats]:
    """Return the triangular factor R of the rows, and the step of the unknowns.

    The last column of the rows is the target.

    Raises
    ------
    NoFit
        If the rows do not determine all unknowns.
    """
    # The triangular factor with the target as last column contains Qᵀ·target: Q is not
    # needed.
    augmented: Floats = np.asarray(np.linalg.qr(rows, mode="r"))
    unknowns = rows.shape[1] - 1
    upper = augmented[:unknowns]
    triangle = upper[:, :-1]
    if not triangle.diagonal().all():
        raise NoFit("these runs do not determine the unknowns separately")
    target = upper[:, -1]
    return triangle, np.asarray(np.linalg.solve(triangle, target), dtype=float)


def _shortened(step: Floats, inertia: float, turn: int) -> Floats:
    """Limit a step from an I_zz in its unit; `turn` counts the steps before it."""
    # One step at most halves or doubles I_zz.
    largest = 0.5 * abs(inertia)
    limit = largest / abs(step[0])
    # Full steps can oscillate if errors are as large as the readings.
    halvings = turn // FULL_STEPS
    shortened: Floats = step * min(1.0, limit) * 0.5**halvings
    return shortened


def _onto_conditions(at: Linear, inertia: float) -> Floats:
    """Move the errors of single runs back onto their conditions after a large step.

    Only there the derivative is exact, and a common shrinking of I_zz and all torques
    gains nothing. A run without a weight may be beyond the pole M0 = 0, and keeps its
    reading.
    """
    inertia_term = np.abs(at.to_unknowns[:, 0] * inertia)
    is_close = np.abs(at.misclosure) < 0.5 * inertia_term
    return -at.independent * (is_close * at.misclosure / at.independent_variance)


MOVED = 0.2
MOVED_U = 3.0
"""A shared reading that the fit moves by more than this part of itself, and by more
than this many standard uncertainties, contradicts the log."""

MEASURED = [TIME, SPIN, LOAD, POSITION, G, ADDED, BALANCE]
"""Which quantities are measured: a pitch of 0 may change by more than itself, and I is
often assumed."""


def _insist_on_solution(adjusted: Adjusted, start: float, factor: float) -> None:
    """Accept the end of an adjustment near its start [kg*m^2], or raise `NoFit`.

    If errors are proportional to the readings, I_zz, all torques and M0 can shrink
    together at little cost. So a solution must be positive, and keep the readings.
    """
    unknowns = adjusted.unknowns
    inertia = float(unknowns[0])
    is_finite = np.isfinite(unknowns).all()
    is_known = np.isfinite(adjusted.covariance).all()
    if not (is_finite and is_known):
        raise NoFit(NO_CONVERGENCE)
    ratio = inertia / start
    if not inertia > 0 or not 1 / factor < ratio < factor:
        raise NoFit(
            f"the fit gives {inertia:.2g} kg·m², "
            f"but the single runs give about {start:.2g} kg·m²"
        )
    _insist_on_readings(adjusted)


def _insist_on_readings(adjusted: Adjusted) -> None:
    """Raise `NoFit` if the fit moves a reading that runs share by too much."""
    problem = adjusted.problem
    error = np.abs(adjusted.shared[problem.to_column])
    source = problem.from_source
    run = problem.from_run
    quantity = problem.quantity[source]
    read = np.abs(problem.observed[quantity, run])
    absolute = np.abs(problem.absolute[source, run])
    size = absolute + problem.relative[source, run] * read
    is_measured = np.isin(quantity, MEASURED) & (adjusted.kept[run] > 0)
    is_large = error * size > MOVED * read
    far = is_measured & is_large & (error > MOVED_U)
    if far.any():
        relative = far * error * size / np.maximum(read, 1e-300)
        worst = source[relative.argmax()]
        moved = problem.sources[worst].name.replace("_", " ")
        raise NoFit(
            f"the runs agree only if the {moved} is wrong by more than "
            f"{100 * MOVED:.0f} %"
        )
