"""The condition that ties one run's readings to the unknowns, and its derivatives.

For each run eq. (8), multiplied by the time so that it has no pole where the torque vanishes, is a condition
between the readings and the unknowns I_zz, M0 (residual torque of an imperfect balance) and b (timing bias):

    s (M + M0)(T − b) = 2π f I_zz ψ̇ + s (I_zz − I) cosθ (2π f)²/(T − b),      s = sign of φ̇ψ̇

Every reading is its truth plus its errors, each error a standard normal number times its uncertainty at the
*true* value.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gyrodata.measurements import Measurements, Source
from gyrodata.physics import Floats

DEFAULT_TRANSVERSE_RATIO = 1.3
"""I/I_zz of a ball with a light rod, where the log does not give I."""

TRANSVERSE_U = 0.2
"""Relative standard uncertainty of I where the log does not give it; I enters only through the tilt."""

_QUANTITIES = ("time", "spin", "turns", "mass", "position", "force", "torque", "g", "pitch", "transverse")

NEGLIGIBLE = 1e-9
"""No reading is exact beyond this relative size; keeps a row whose stated errors are all zero finite."""


@dataclass(frozen=True)
class Linear:
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


class Problem:
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

    def linearise(self, single: Floats, shared: Floats, sense: Floats, unknowns: Floats) -> Linear:
        """Linearise the conditions at adjusted readings; extrapolate the errors of one run back to none."""
        values, slopes = self.truth(single, shared)
        value, to_unknowns, to_quantities = self.conditions(values, sense, *unknowns)
        slopes = slopes * to_quantities[self.quantity]
        alone = slopes * self.alone
        floor = NEGLIGIBLE * to_quantities[0] * values[0]
        own = np.sum(alone**2, axis=0) + floor**2
        return Linear(value - np.sum(alone * single, axis=0), to_unknowns, slopes, alone, own)

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
    return DEFAULT_TRANSVERSE_RATIO * rough_inertia(measured) + load


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


def rough_inertia(measured: Measurements) -> float:
    """Median of M/(φ̇ψ̇) over the loaded runs [kg*m^2]: a scale, not an answer."""
    ratios = np.abs(measured.torque / measured.product)
    ratios = ratios[ratios > 0]
    return float(np.median(ratios)) if len(ratios) else 1e-3
