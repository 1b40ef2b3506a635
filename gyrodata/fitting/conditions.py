"""The condition that ties one run's readings to the unknowns, and its derivatives.

For each run eq. (8), multiplied by the time so that it has no pole where the torque vanishes, is a condition
between the readings and the unknowns I_zz, M0 (residual torque of an imperfect balance) and b (timing bias):

    s (M + M0)(T − b) = 2π f I_zz ψ̇ + s (I_zz − I) cosθ (2π f)²/(T − b),      s = sign of φ̇ψ̇

with what the weight adds to I_zz in each run, where the log says how wide it is: it spins along.

Every reading is its truth plus its errors, each error a standard normal number times its uncertainty at the
*true* value.
"""

from __future__ import annotations

import copy

import numpy as np
from msgspec import Struct

from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO, Measurements
from gyrodata.physics import Floats, Integers

QUANTITIES = ("time", "spin", "turns", "mass", "position", "force", "torque", "g", "pitch", "transverse", "added")
TIME, SPIN, TURNS, MASS, POSITION, FORCE, TORQUE, G, PITCH, TRANSVERSE, ADDED = range(len(QUANTITIES))
"""Row of each quantity in an array of shape (11, n)."""

MAD_TO_SD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation [1]."""

NEGLIGIBLE = 1e-9
"""No reading is exact beyond this relative size; keeps a row whose stated errors are all zero finite."""


MANY = 500
"""With more runs than this, a sample of them gives the size of an effect as well, in a hundredth of the time."""


class Linear(Struct, frozen=True):
    """The conditions of n runs, linear in the unknowns and in the errors of S sources."""

    misclosure: Floats
    """Value of each condition if the errors that only this run has are zero, shape (n,)."""
    to_unknowns: Floats
    """Derivatives to I_zz, M0 and b, shape (n, 3)."""
    slopes: Floats
    """Derivatives to each source's error, shape (S, n)."""
    independent: Floats
    """The same if only this run has the error, else 0, shape (S, n)."""
    independent_variance: Floats
    """Variance of each condition from the errors that only this run has, shape (n,)."""


class Problem:
    """One log's readings and errors as arrays: S sources, n runs, K errors that several runs share.

    An error that only one run has is eliminated row by row; an error that several runs share is an unknown with a
    column of its own. `observed` contains the readings, shape (11, n).
    """

    def __init__(self, measured: Measurements, tilted: bool) -> None:
        count = len(measured.runs)
        self.measured = measured
        self.count = count
        self.tilted = tilted
        self.observed = np.empty((len(QUANTITIES), count))
        self.observed[TIME], self.observed[SPIN], self.observed[TURNS] = measured.time, measured.spin, measured.turns
        self.observed[MASS], self.observed[POSITION] = measured.mass, measured.position
        self.observed[FORCE], self.observed[TORQUE] = measured.force, measured.given_torque
        if measured.slowing is not None:
            # The angle that steady precession would have swept in the same time.
            self.observed[TURNS] *= measured.slowing
        self.observed[G] = measured.g
        self.observed[PITCH] = measured.pitch if tilted else 0.0
        self.observed[TRANSVERSE] = transverse_inertia(measured) if tilted else 0.0
        self.observed[ADDED] = measured.added
        sources = [source for source in measured.sources if tilted or source.quantity not in ("pitch", "transverse")]
        self.sources = [source for source in sources if source.absolute.any() or source.relative.any()]
        shape = len(self.sources), count
        self.quantity = np.array([QUANTITIES.index(source.quantity) for source in self.sources], dtype=int)
        self.absolute = np.array([source.absolute for source in self.sources]).reshape(shape)
        self.relative = np.array([source.relative for source in self.sources]).reshape(shape)
        self.onto = (np.arange(len(QUANTITIES))[:, None] == self.quantity).astype(float)
        self._share(np.array([source.groups for source in self.sources], dtype=int).reshape(shape))
        self.by_weight = not np.isnan(measured.mass).all()
        self.by_force = not np.isnan(measured.force).all()

    def with_scatter(self, factor: float) -> Problem:
        """Give the same problem with the errors that only one run has `factor` times as large."""
        new, sizes = copy.copy(self), np.where(self.independent > 0, factor, 1.0)
        new.absolute, new.relative = sizes * self.absolute, sizes * self.relative
        return new

    def _share(self, groups: Integers) -> None:
        """Number the errors that several runs share, in the order of sources and groups."""
        width = int(groups.max(initial=0)) + 1
        touched = groups >= 0
        # One bin for each group of each source.
        bins = groups + width * np.arange(len(groups))[:, None]
        sizes = np.bincount(bins[touched], minlength=width * len(groups))
        size = np.where(touched, sizes[bins], 0)
        self.groups = groups
        self.independent = (size == 1).astype(float)
        column = (sizes > 1).cumsum() - 1
        self.shared_count = int(column[-1]) + 1 if len(column) else 0
        self.member = np.where(size > 1, column[bins], -1)
        self.from_source, self.from_run = (size > 1).nonzero()
        self.to_column = self.member[self.from_source, self.from_run]

    def truth(self, single: Floats, shared: Floats) -> tuple[Floats, Floats]:
        """Adjusted value of each quantity, shape (11, n), and its derivative to each source's error, (S, n)."""
        # An error that only one run has is in `single`, a shared one in `shared`, never in both.
        errors = single + np.append(shared, 0.0)[self.member]
        scale = 1 + self.onto @ (self.relative * errors)
        values = (self.observed - self.onto @ (self.absolute * errors)) / scale
        slopes = -(self.relative * values[self.quantity] + self.absolute) / scale[self.quantity]
        return values, slopes

    def torque(self, values: Floats) -> tuple[Floats, dict[int, Floats]]:
        """Torque of each run [N*m] and its derivatives by quantity."""
        if self.by_weight:
            pull = values[MASS] * values[G]
            slopes = {MASS: values[POSITION] * values[G], POSITION: pull, G: values[MASS] * values[POSITION]}
            return pull * values[POSITION], slopes
        if self.by_force:
            return values[FORCE] * values[POSITION], {POSITION: values[FORCE], FORCE: values[POSITION]}
        return values[TORQUE], {TORQUE: np.ones(self.count)}

    def linearise(self, single: Floats, shared: Floats, sense: Floats, unknowns: Floats) -> Linear:
        """Linearise each run's condition at adjusted readings; extrapolate the errors of one run back to none."""
        values, slopes = self.truth(single, shared)
        inertia, residual_torque, bias = unknowns
        torque, chain = self.torque(values)
        time, spin = values[TIME] - bias, values[SPIN]
        angle = 2 * np.pi * values[TURNS]
        push = sense * (torque + residual_torque)
        whole = inertia + values[ADDED]
        moment = whole * spin
        misclosure = push * time - angle * moment
        # Derivatives to each quantity, (11, n), and to I_zz, M0 and b, (n, 3).
        to = np.zeros(values.shape)
        to[TIME], to[SPIN], to[TURNS] = push, -angle * whole, -2 * np.pi * moment
        to[ADDED] = -angle * spin
        for quantity, slope in chain.items():
            to[quantity] = sense * time * slope
        to_unknowns = np.array([to[ADDED], sense * time, to[TIME]]).T
        if self.tilted:
            pitch, difference = values[PITCH], whole - values[TRANSVERSE]
            square = sense * angle**2 / time
            tilt = square * np.sin(pitch)
            misclosure -= difference * tilt
            to_unknowns[:, 0] -= tilt
            to[TIME] += difference * tilt / time
            to[TURNS] -= 4 * np.pi * difference * tilt / angle
            to[PITCH], to[TRANSVERSE] = -difference * square * np.cos(pitch), tilt
            to[ADDED] -= tilt
        to_unknowns[:, 2] = -to[TIME]
        slopes = slopes * to[self.quantity]
        independent = slopes * self.independent
        # Of the spin's term, which does not vanish with the torque.
        floor = NEGLIGIBLE * to[SPIN] * values[SPIN]
        variance = np.add.reduce(independent**2, axis=0) + floor**2
        misclosure -= np.add.reduce(independent * single, axis=0)
        return Linear(misclosure, to_unknowns, slopes, independent, variance)


def torques_differ(torque: Floats) -> bool:
    """Say whether the signed torques of a log differ enough (2 % of the largest) to tell M0 from I_zz.

    A property of the design of the experiment, never of how the data came out.
    """
    most, least = np.maximum.reduce(torque), np.minimum.reduce(torque)
    return bool(most - least > 0.02 * max(most, -least))


def transverse_inertia(measured: Measurements) -> Floats:
    """I of each run [kg*m^2]; where the log is silent, a ball with a light rod, the weight on top."""
    if measured.transverse_inertia is not None:
        return measured.transverse_inertia
    load = measured.mass * measured.position**2
    return DEFAULT_TRANSVERSE_RATIO * rough_inertia(measured) + np.where(np.isnan(load), 0.0, load)


def rough_inertia(measured: Measurements) -> float:
    """Median of M/(φ̇ψ̇) over the loaded runs [kg*m^2]: a scale, not an answer."""
    ratios = np.abs(measured.torque / measured.product)
    ratios = ratios[ratios > 0]
    return median(ratios) if len(ratios) else 1e-3


def median(values: Floats) -> float:
    """Middle value of some, at least one; `np.median` would load numpy.ma, a tenth of the start."""
    ordered = np.sort(values)
    return float(ordered[(len(ordered) - 1) // 2] + ordered[len(ordered) // 2]) / 2
