"""Where the fit starts: an answer that up to half of the runs may be wrong about."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np

from gyrodata.fitting.adjustment import Start
from gyrodata.fitting.conditions import MAD_TO_SD, rough_inertia, torques_differ
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

_SAMPLE = 150
"""So many runs are enough to start from."""

_ODD = 5.0
"""Misfit from which on a run is odd, and one that is further off no worse."""


def first_guess(measured: Measurements, sense: Floats, free: bool, kept: Floats) -> Start:
    """Fit the straight line; where a run is far from it, take the robust start."""
    index = sample(measured, kept)
    if free and torques_differ(measured.torque[index]):
        lever, swing = _lever(measured, index), sense[index] * measured.time[index]
        inertia, imbalance = straight_line(lever, swing, measured.torque[index])
        total = np.abs(measured.torque[index] + imbalance)
        if inertia > 0 and total.all() and rough_misfit(measured, inertia * lever / total, index).max() < 5:
            return Start(float(inertia), float(imbalance))
    return robust_start(measured, sense, free, kept)


MANY = 500
"""Of more runs than so many a sample tells sizes and designs as well, for a hundredth of the time."""


def sample(measured: Measurements, kept: Floats) -> Any:
    """Indices of the runs kept, of very many 150: every torque in its share, and at random among its runs.

    An even stride through the log would meet one torque only where the weights come round with the same period.
    """
    index = np.flatnonzero(kept > 0)
    if len(index) <= _SAMPLE:
        return index
    mixed = np.random.default_rng(0).permutation(index)
    by_torque = mixed[np.argsort(measured.torque[mixed], kind="stable")]
    return np.sort(by_torque[np.linspace(0, len(index) - 1, _SAMPLE).round().astype(int)])


def _lever(measured: Measurements, index: Any) -> Floats:
    return cast(Floats, 2 * np.pi * measured.turns[index] * measured.spin[index])


def straight_line(lever: Floats, swing: Floats, torque: Floats) -> tuple[Floats, Floats]:
    """Give I_zz and M0 by least squares of s M T on the lever 2π f ψ̇ and the swing s T, for labs of shape (…, n)."""
    # A clock's error weighs as much as the torque it is multiplied by.
    size = np.abs(torque)
    weight = 1 / np.maximum(size, 0.1 * size.max(axis=-1, keepdims=True))
    lever, swing = lever * weight, swing * weight
    effort = swing * torque
    aa, ab, bb = (np.add.reduce(product, axis=-1) for product in (lever * lever, lever * swing, swing * swing))
    ae, be = np.add.reduce(lever * effort, axis=-1), np.add.reduce(swing * effort, axis=-1)
    determinant = aa * bb - ab * ab
    return (ae * bb - be * ab) / determinant, (ae * ab - be * aa) / determinant


def robust_start(measured: Measurements, sense: Floats, free: bool, kept: Floats) -> Start:
    """Solve many pairs of runs for (I_zz, M0) and take the pair that most runs agree with.

    With b = 0 and a horizontal rod the condition is linear: s M T = I_zz 2π f ψ̇ − M0 s T.
    """
    index = sample(measured, kept)
    if not free or not torques_differ(measured.torque[index]):
        return Start(rough_inertia(measured), 0.0)
    lever, swing = _lever(measured, index), sense[index] * measured.time[index]
    effort = swing * measured.torque[index]
    first, second = _pairs(len(index))
    # Two runs: lever·I − swing·M0 = effort for each.
    determinant = lever[second] * swing[first] - lever[first] * swing[second]
    usable = np.abs(determinant) > 1e-3 * np.abs(lever[first] * swing[second])
    first, second, determinant = first[usable], second[usable], determinant[usable]
    inertia = (effort[second] * swing[first] - effort[first] * swing[second]) / determinant
    imbalance = (lever[first] * effort[second] - lever[second] * effort[first]) / determinant
    largest = np.abs(measured.torque[index]).max()
    plausible = (inertia > 0) & (np.abs(imbalance) < 3 * largest)
    if not plausible.any():
        return Start(rough_inertia(measured), 0.0)
    inertia, imbalance = inertia[plausible], imbalance[plausible]
    total = np.maximum(np.abs(measured.torque[index] + imbalance[:, None]), 1e-3 * largest)
    off = rough_misfit(measured, inertia[:, None] * lever / total, index)
    # In units of the scatter about the best pair a run counts at most as much as one that is just odd, so that the
    # fewest odd runs win; of equals the pair with the smaller M0.
    middle = np.partition(off, len(index) // 2, axis=1)[:, len(index) // 2]
    scatter = max(1.0, MAD_TO_SD * float(middle.min()))
    loads = np.abs(measured.torque[measured.torque != 0])
    cost = np.sum(np.minimum(off / scatter, _ODD) ** 2, axis=1) + (imbalance / loads.min()) ** 2
    best = int(np.argmin(cost))
    return Start(float(inertia[best]), float(imbalance[best]))


@lru_cache(maxsize=32)
def _pairs(count: int) -> tuple[Any, Any]:
    """Pick pairs of runs, all of them or about 80 spread evenly."""
    first, second = np.triu_indices(count, 1)
    step = len(first) // 80 + 1
    return first[::step], second[::step]


def misfit(measured: Measurements, start: Start, kept: Floats) -> float:
    """Root mean square of the kept runs' misfits to a start, in units of the clock's uncertainty and 1 %."""
    index = np.flatnonzero(kept > 0)
    total = np.abs(measured.torque[index] + start.imbalance)
    with np.errstate(divide="ignore"):
        off = rough_misfit(measured, start.inertia * _lever(measured, index) / total, index)
    return float(np.sqrt(np.mean(off**2)))


def rough_misfit(measured: Measurements, predicted: Floats, index: Any = slice(None)) -> Floats:
    """Time against prediction, in units of the clock's uncertainty and 1 %: a rough scale for rough answers."""
    time = measured.time[index]
    bounded = np.where(np.isfinite(predicted), predicted, time)
    return cast(Floats, np.abs(time - bounded) / np.hypot(_time_u(measured)[index], 0.01 * bounded))


def _time_u(measured: Measurements) -> Floats:
    for source in measured.sources:
        if source.quantity == "time":
            return source.absolute + source.relative * measured.time
    return np.zeros(len(measured.runs))


def assume_sense(measured: Measurements, imbalance_sign: float) -> Floats:
    """Sense of each run; a run without a weight turns the way of the residual torque."""
    return cast(Floats, np.where(measured.sense == 0, imbalance_sign, measured.sense))
