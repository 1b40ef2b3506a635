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
from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
from msgspec import Struct

from gyrodata.measurements import DEFAULT_TRANSVERSE_RATIO, Measurements
from gyrodata.physics import Floats, Integers

QUANTITIES = ("time", "spin", "turns", "mass", "position", "force", "torque", "g", "pitch", "transverse", "added")

MAD_TO_SD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation [1]."""

NEGLIGIBLE = 1e-9
"""No reading is exact beyond this relative size; keeps a row whose stated errors are all zero finite."""


MANY = 500
"""Of more runs than so many a sample tells sizes and designs as well, for a hundredth of the time; and logs of so many
gain nothing where they are fitted in a stack."""


class Linear(Struct, frozen=True):
    """The conditions of n runs, linear in the unknowns and in the errors of S sources.

    Labs of one design may be stacked: every array may have axes before those given.
    """

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


class Problem:
    """One log's readings and errors as arrays: S sources, n runs, K errors that are shared.

    A source's error that one run has alone is eliminated row by row; one that several runs share is an
    unknown, a column of its own. `observed` may be a stack of labs of one design, shape (…, 11, n).
    """

    def __init__(self, measured: Measurements, tilted: bool) -> None:
        count = len(measured.runs)
        self.measured = measured
        self.count = count
        self.tilted = tilted
        self.observed = np.empty((len(QUANTITIES), count))
        self.observed[:7] = (
            measured.time, measured.spin, measured.turns, measured.mass,
            measured.position, measured.force, measured.given_torque,
        )  # fmt: skip
        if measured.slowing is not None:
            # The angle that steady precession would have swept in the same time.
            self.observed[2] *= measured.slowing
        self.observed[7] = measured.g
        self.observed[8:10] = (measured.pitch, transverse_inertia(measured)) if tilted else 0.0
        self.observed[10] = measured.added
        sources = [source for source in measured.sources if tilted or source.quantity not in ("pitch", "transverse")]
        sizes = np.array([(source.absolute, source.relative) for source in sources]).reshape(len(sources), 2, count)
        stated = np.flatnonzero(sizes.any(axis=(1, 2)))
        self.sources = [sources[s] for s in stated]
        self.quantity = np.array([QUANTITIES.index(source.quantity) for source in self.sources], dtype=int)
        self.absolute, self.relative = sizes[stated, 0], sizes[stated, 1]
        self.onto = (np.arange(len(QUANTITIES))[:, None] == self.quantity).astype(float)
        self._share(np.array([source.groups for source in self.sources], dtype=int).reshape(len(stated), count))
        self.by_weight = not np.isnan(measured.mass).all()
        self.by_force = not np.isnan(measured.force).all()

    def reread(
        self, observed: Floats, sizes: tuple[Floats, Floats] | None = None, groups: Integers | None = None
    ) -> Problem:
        """Give the same sources with other readings, and absolute and relative sizes and groups of their errors."""
        new = copy.copy(self)
        new.observed, new.count = observed, observed.shape[-1]
        if sizes is not None:
            new.absolute, new.relative = sizes
        if groups is not None:
            new._share(groups)
        return new

    @property
    def kind(self) -> Hashable:
        """What problems of one stack have in common; None for one of very many runs."""
        if self.count > MANY:
            return None
        kinds = self.tilted, self.by_weight, self.by_force
        return *kinds, self.groups.shape, self.quantity.tobytes(), self.groups.tobytes()

    def part(self, which: Any) -> Problem:
        """Give some logs of a stack."""
        return self.reread(self.observed[which], (self.absolute[which], self.relative[which]))

    def with_scatter(self, factor: float) -> Problem:
        """Give the same with the errors that a run has alone so many times as wide."""
        sizes = np.where(self.alone > 0, factor, 1.0)
        return self.reread(self.observed, (sizes * self.absolute, sizes * self.relative))

    def _share(self, groups: Integers) -> None:
        """Number the errors that several runs share, in the order of sources and groups."""
        self.groups = groups
        width = int(groups.max(initial=0)) + 1
        touched = groups >= 0
        # One bin for each group of each source.
        bins = groups + width * np.arange(len(groups))[:, None]
        sizes = np.bincount(bins[touched], minlength=width * len(groups))
        size = np.where(touched, sizes[bins], 0)
        self.alone = (size == 1).astype(float)
        column = (sizes > 1).cumsum() - 1
        self.shared_count = int(column[-1]) + 1 if len(column) else 0
        self.member = np.where(size > 1, column[bins], -1)
        self.from_source, self.from_run = (size > 1).nonzero()
        self.to_column = self.member[self.from_source, self.from_run]
        # Places of what is shared among all slopes, and among all derivatives to I_zz, M0, b and the shared errors.
        self.from_slope = self.from_source * groups.shape[1] + self.from_run
        self.to_row = self.from_run * (3 + self.shared_count) + 3 + self.to_column

    def truth(self, single: Floats, shared: Floats) -> tuple[Floats, Floats]:
        """Adjusted value of each quantity, shape (11, n), and its derivative to each source's error, (S, n)."""
        # An error that a run has alone is in `single`, one that it shares in `shared`, never in both.
        errors = single
        if self.shared_count:
            padded = np.zeros((*shared.shape[:-1], self.shared_count + 1))
            padded[..., :-1] = shared
            errors = single + padded.take(self.member, axis=-1)
        scale = self.onto @ (self.relative * errors)
        scale += 1
        values = (self.observed - self.onto @ (self.absolute * errors)) / scale
        slopes = self.relative * values.take(self.quantity, axis=-2)
        slopes += self.absolute
        slopes /= -scale.take(self.quantity, axis=-2)
        return values, slopes

    def torque(self, values: Floats) -> tuple[Floats, dict[int, Floats]]:
        """Torque of each run [N*m] and its derivatives by quantity."""
        if self.by_weight:
            mass, position, g = values[..., 3, :], values[..., 4, :], values[..., 7, :]
            pull = mass * g
            return pull * position, {3: position * g, 4: pull, 7: mass * position}
        if self.by_force:
            position, force = values[..., 4, :], values[..., 5, :]
            return force * position, {5: position, 4: force}
        return values[..., 6, :], {6: np.ones(self.count)}

    def linearise(self, single: Floats, shared: Floats, sense: Floats, unknowns: Floats) -> Linear:
        """Linearise each run's condition at adjusted readings; extrapolate the errors of one run back to none."""
        values, slopes = self.truth(single, shared)
        inertia, imbalance, bias = unknowns[..., :1], unknowns[..., 1:2], unknowns[..., 2:]
        torque, chain = self.torque(values)
        time, spin = values[..., 0, :] - bias, values[..., 1, :]
        angle = 2 * np.pi * values[..., 2, :]
        back = -angle
        push = sense * (torque + imbalance)
        to_torque = sense * time
        whole = inertia + values[..., 10, :]
        moment = whole * spin
        value = push * time - angle * moment
        # Derivatives to I_zz, M0 and b, (n, 3), and to each quantity, (11, n).
        to_unknowns = np.empty((*value.shape, 3))
        to = np.zeros((*value.shape[:-1], *values.shape[-2:]))
        to_unknowns[..., 1] = to_torque
        to[..., 0, :] = push
        np.multiply(back, whole, out=to[..., 1, :])
        np.multiply(-2 * np.pi, moment, out=to[..., 2, :])
        to_unknowns[..., 0] = np.multiply(back, spin, out=to[..., 10, :])
        for quantity, slope in chain.items():
            np.multiply(to_torque, slope, out=to[..., quantity, :])
        if self.tilted:
            pitch, difference = values[..., 8, :], whole - values[..., 9, :]
            square = sense * angle**2 / time
            tilt = square * np.sin(pitch)
            value -= difference * tilt
            to_unknowns[..., 0] -= tilt
            to[..., 0, :] += difference * tilt / time
            to[..., 2, :] -= 4 * np.pi * difference * tilt / angle
            to[..., 8, :] = -difference * square * np.cos(pitch)
            to[..., 9, :] = tilt
            to[..., 10, :] -= tilt
        np.negative(to[..., 0, :], out=to_unknowns[..., 2])
        slopes *= to.take(self.quantity, axis=-2)
        alone = slopes * self.alone
        # Of the spin's term, which does not vanish with the torque.
        floor = NEGLIGIBLE * to[..., 1, :] * values[..., 1, :]
        own = np.add.reduce(alone * alone, axis=-2) + floor * floor
        return Linear(value - np.add.reduce(alone * single, axis=-2), to_unknowns, slopes, alone, own)


def stack(problems: Sequence[Problem]) -> Problem:
    """Put logs of one kind together, shape (L, …)."""
    observed, absolute, relative = (
        np.array([getattr(one, name) for one in problems]) for name in ("observed", "absolute", "relative")
    )
    return problems[0].reread(observed, (absolute, relative))


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
