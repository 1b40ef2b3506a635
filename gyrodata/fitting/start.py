"""Where the fit starts: an answer that up to half of the runs may be wrong about."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, cast

import numpy as np

from gyrodata.fitting.conditions import rough_inertia
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats


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
class Start:
    """Rough values of the unknowns."""

    inertia: float
    """[kg*m^2]"""
    imbalance: float
    """[N*m]"""


def robust_start(measured: Measurements, sense: Floats, free: bool, kept: Floats) -> Start:
    """Solve many pairs of runs for (I_zz, M0) and take the pair that most runs agree with.

    With b = 0 and a horizontal rod the condition is linear: s M T = I_zz 2π f ψ̇ − M0 s T. Up to half of the
    runs may be wrong without moving the median of the misfits of the best pair.
    """
    index = np.flatnonzero(kept > 0)
    index = index[:: len(index) // 150 + 1]
    if not free or len(index) < 2:
        return Start(rough_inertia(measured), 0.0)
    lever = 2 * np.pi * measured.turns[index] * measured.spin[index]
    swing = sense[index] * measured.time[index]
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
    # The median; np.median takes longer than all the rest.
    below, above = (len(index) - 1) // 2, len(index) // 2
    off.partition((below, above), axis=1)
    best = int(np.argmin(off[:, below] + off[:, above]))
    return Start(float(inertia[best]), float(imbalance[best]))


@lru_cache(maxsize=32)
def _pairs(count: int) -> tuple[Any, Any]:
    """Pick pairs of runs, all of them or about 150 spread evenly."""
    first, second = np.triu_indices(count, 1)
    step = len(first) // 150 + 1
    return first[::step], second[::step]


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
