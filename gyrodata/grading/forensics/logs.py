"""The logs of a class side by side, as arrays: what pairs are compared by."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import truediv

import numpy as np
from numpy.typing import NDArray

from gyrodata.grading.forensics.exemptions import Exemptions
from gyrodata.grading.forensics.fingerprint import Fingerprint
from gyrodata.grading.forensics.scatter import HAND, Scatter, measure_scatter
from gyrodata.physics import Floats

Integers = NDArray[np.int_]

TACHOMETER = 0.002
"""Relative scatter of a reading of the spin."""

TRUSTED_DOF = 3
"""Degrees of freedom from which a log's own scatter is believed."""


@dataclass(frozen=True)
class Logs:
    """N logs with R rows in all: the class, by key, and then the earlier ones, by key.

    What pairs are found by is held here; what only tells of them is looked up.
    """

    keys: tuple[str, ...]
    prints: Callable[[int], Fingerprint]
    """Looks up one of the logs."""
    current: int
    """How many are of this class."""
    by_hand: NDArray[np.bool_]
    """Which were timed with a stopwatch, shape (N,)."""
    dof: Integers
    """Degrees of freedom of each log's scatter, shape (N,); 0 where it has none."""
    squares: Floats
    """Sum of squares of each log's scatter [s²], shape (N,)."""
    time_step: Floats
    """Largest step of a time of each log [s], shape (N,)."""
    noise: Floats
    """Standard deviation that a time of each log has at least [s], shape (N,); 0 where nothing tells."""
    starts: Integers
    """Where each log's rows begin, shape (N + 1,)."""
    log: Integers
    """Log of each row, shape (R,)."""
    torque: Floats
    """[N*m], shape (R,)."""
    spin: Floats
    """[rad/s], shape (R,)."""
    period: Floats
    """Time of one revolution of precession [s], shape (R,)."""
    spin_step: Floats
    """[rad/s], shape (R,)."""
    period_step: Floats
    """[s], shape (R,)."""
    turns: Floats
    """Shape (R,)."""
    partners: Mapping[int, frozenset[int]]
    """Logs that may be like each log."""

    def rows(self, log: int) -> slice:
        """Give where a log's rows are."""
        return slice(int(self.starts[log]), int(self.starts[log + 1]))

    def scatter(self, log: int) -> Scatter:
        """Work out the scatter of a log that has a degree of freedom."""
        scatter = measure_scatter(self.prints(log))
        assert scatter is not None
        return scatter

    @property
    def pairs(self) -> int:
        """How many pairs there are to compare: within the class, and with the earlier logs."""
        earlier = len(self.keys) - self.current
        exempt = sum(map(len, self.partners.values())) // 2
        return self.current * (self.current - 1) // 2 + self.current * earlier - exempt

    def compared_with(self, log: int) -> NDArray[np.bool_]:
        """Tell which logs one is compared with, shape (N,)."""
        compared = np.full(len(self.keys), log < self.current)
        compared[: self.current] = True
        compared[[log, *self.partners.get(log, ())]] = False
        return compared


def lay_out(
    students: Sequence[str], prints: Mapping[str, Fingerprint], exempt: Exemptions, previous: Mapping[str, Fingerprint]
) -> Logs:
    """Put the logs side by side.

    `prints`: The class, by student.
    """
    keys = (*students, *sorted(previous))

    def print_of(log: int) -> Fingerprint:
        return prints[keys[log]] if log < len(students) else previous[keys[log]]

    rows = {name: array("d") for name in ("torque", "spin", "period", "turns", "spin_step", "period_step")}
    sizes, dof, by_hand = array("q"), array("q"), array("q")
    time_step, squares, own = array("d"), array("d"), array("d")
    for one in map(print_of, range(len(keys))):
        for name in ("torque", "spin", "turns", "spin_step"):
            rows[name].extend(getattr(one, name))
        rows["period"].extend(map(truediv, one.time, one.turns))
        rows["period_step"].extend(map(truediv, one.time_step, one.turns))
        sizes.append(len(one.time))
        by_hand.append(one.by_hand)
        time_step.append(max(one.time_step))
        scatter = measure_scatter(one)
        dof.append(0 if scatter is None else scatter.dof)
        squares.append(0.0 if scatter is None else scatter.squares)
        trusted = scatter is not None and scatter.dof >= TRUSTED_DOF
        own.append(math.sqrt(max(squares[-1] / dof[-1] - _from_tachometer(one), 0.0)) if trusted else 0.0)
    counts, freedom, stopwatch = (np.array(values, dtype=int) for values in (sizes, dof, by_hand))
    return Logs(
        keys=keys,
        prints=print_of,
        current=len(students),
        by_hand=stopwatch > 0,
        dof=freedom,
        squares=np.array(squares),
        time_step=np.array(time_step),
        noise=_noise(np.array(own), freedom >= TRUSTED_DOF, stopwatch > 0),
        starts=np.concatenate([[0], np.cumsum(counts)]).astype(int),
        log=np.repeat(np.arange(len(keys)), counts),
        partners=exempt.partners({key: i for i, key in enumerate(students)}),
        **{name: np.frombuffer(values) if values else np.zeros(0) for name, values in rows.items()},
    )


def _noise(own: Floats, trusted: NDArray[np.bool_], by_hand: NDArray[np.bool_]) -> Floats:
    """Least scatter of a log's times: its own or the class's middle one, whichever is less, and a good hand's at least.

    A log that scatters more than most may only be bent, and bends can be shared. What the tachometer adds is no
    scatter of the times: students who hit the same spins share them however they read them.
    """
    noise = np.zeros(len(own))
    for kind, least in ((by_hand, HAND), (~by_hand, 0.0)):
        middle = float(np.median(own[kind & trusted])) if np.any(kind & trusted) else 0.0
        noise[kind] = np.maximum(np.minimum(own[kind], middle), least)
    return noise


def _from_tachometer(one: Fingerprint) -> float:
    """Variance that the readings of the spin bring into the times [s²], in the middle of the log's rows."""
    time, spin, step = np.array(one.time), np.array(one.spin), np.array(one.spin_step)
    return float(np.median(time**2 * (TACHOMETER**2 + (step / spin) ** 2 / 12)))
