"""The logs of a class side by side, as arrays: what pairs are compared by."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

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
    """N logs with R rows in all: the class, by key, and then the earlier ones, by key."""

    keys: tuple[str, ...]
    prints: tuple[Fingerprint, ...]
    current: int
    """How many are of this class."""
    scatters: tuple[Scatter | None, ...]
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


def lay_out(prints: Mapping[str, Fingerprint], exempt: Exemptions, previous: Mapping[str, Fingerprint]) -> Logs:
    """Put the logs side by side.

    Parameters
    ----------
    prints : mapping of str to Fingerprint
        The class, by student.
    exempt : Exemptions
        Whose logs may be alike.
    previous : mapping of str to Fingerprint
        Earlier logs, by a key of their own.

    Returns
    -------
    Logs
    """
    class_keys, earlier_keys = sorted(prints), sorted(previous)
    every = (*(prints[key] for key in class_keys), *(previous[key] for key in earlier_keys))
    scatters = tuple(measure_scatter(one) for one in every)
    sizes = [len(one.time) for one in every]
    turns = _joined([one.turns for one in every])
    number = {key: i for i, key in enumerate(class_keys)}
    return Logs(
        keys=(*class_keys, *earlier_keys),
        prints=every,
        current=len(class_keys),
        scatters=scatters,
        noise=_noise(every, scatters),
        starts=np.concatenate([[0], np.cumsum(sizes, dtype=int)]).astype(int),
        log=np.repeat(np.arange(len(every)), sizes),
        torque=_joined([one.torque for one in every]),
        spin=_joined([one.spin for one in every]),
        period=_joined([one.time for one in every]) / turns,
        spin_step=_joined([one.spin_step for one in every]),
        period_step=_joined([one.time_step for one in every]) / turns,
        turns=turns,
        partners=exempt.partners(number),
    )


def _joined(parts: list[tuple[float, ...]]) -> Floats:
    return np.array([value for part in parts for value in part])


def _noise(prints: tuple[Fingerprint, ...], scatters: tuple[Scatter | None, ...]) -> Floats:
    """Least scatter of a log's times: its own or the class's middle one, whichever is less, and a good hand's at least.

    A log that scatters more than most may only be bent, and bends can be shared. What the tachometer adds is no
    scatter of the times: students who hit the same spins share them however they read them.
    """
    noise = np.zeros(len(prints))
    for by_hand in (True, False):
        own = {
            i: math.sqrt(max(scatter.squares / scatter.dof - _from_tachometer(one), 0.0))
            for i, (one, scatter) in enumerate(zip(prints, scatters, strict=True))
            if one.by_hand == by_hand and scatter is not None and scatter.dof >= TRUSTED_DOF
        }
        middle = float(np.median(list(own.values()))) if own else 0.0
        for i, one in enumerate(prints):
            if one.by_hand == by_hand:
                noise[i] = max(min(own.get(i, 0.0), middle), HAND if by_hand else 0.0)
    return noise


def _from_tachometer(one: Fingerprint) -> float:
    """Variance that the readings of the spin bring into the times [s²], in the middle of the log's rows."""
    time, spin, step = np.array(one.time), np.array(one.spin), np.array(one.spin_step)
    return float(np.median(time**2 * (TACHOMETER**2 + (step / spin) ** 2 / 12)))
