"""Counts of turns that are wrong for all runs of a torque: one number written in every row, for example."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from gyrodata.fitting.conditions import median
from gyrodata.measurements import Measurements, torque_groups
from gyrodata.physics import Floats

LIKELY = (1 / 3, 1 / 2, 2 / 3, 1.0, 2.0, 3.0)
"""Revolutions that a lab times all runs of a weight by."""

AGREES = 0.03
"""Torques agree where what is left of them is below this, relative, as a root mean square: wrong counts leave 20 %."""

MODEST = 0.3
"""Other counts explain a log only with a residual torque below this share of the lightest torque."""

MOST_TORQUES = 12
"""More torques than this are not tried."""


def explaining_counts(measured: Measurements) -> list[dict[int, float]]:
    """Find the counts, one for each torque, with which the torques agree.

    Parameters
    ----------
    measured : Measurements
        n runs.

    Returns
    -------
    list of dict
        The corrections that change the fewest torques, one in most cases: number of the group in `torque_groups` and
        the revolutions that fit it. Empty where the torques agree as written, or no counts make them.

    Notes
    -----
    With a level rod M + M0 = I_zz φ̇ψ̇ is a line, and a count scales φ̇ψ̇. Every two torques with any two counts make a
    line, and so does every torque with M0 = 0; each of the others then takes the count that is nearest to it.
    """
    numbers = [k for k, group in enumerate(torque_groups(measured)) if measured.torque[group[0]]]
    if not 2 <= len(numbers) <= MOST_TORQUES:
        return []
    groups = [torque_groups(measured)[k] for k in numbers]
    torque = np.array([measured.torque[group[0]] for group in groups])
    product = np.array(
        [np.sign(m) * median(np.abs(measured.product[group])) for m, group in zip(torque, groups, strict=True)]
    )
    # Runs of one torque with different counts were counted one by one.
    written = [np.unique(measured.turns[group]) for group in groups]
    factors = [np.unique([1.0, *(np.array(LIKELY) / w[0] if len(w) == 1 else [])]) for w in written]
    lines = _lines(torque, product, factors)
    if lines is None:
        return []
    inertia, imbalance = lines
    total = torque + imbalance[:, None]
    chosen, left = np.ones((len(inertia), len(torque))), np.empty((len(inertia), len(torque)))
    for k, factor in enumerate(factors):
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.abs(np.log(inertia[:, None] * product[k] * factor / total[:, k : k + 1]))
        off[~np.isfinite(off)] = np.inf
        best = off.argmin(axis=1)
        chosen[:, k], left[:, k] = factor[best], off[np.arange(len(off)), best]
    changed = ~np.isclose(chosen, 1.0)
    agrees = np.sqrt(np.mean(left**2, axis=1)) < AGREES
    if np.any(agrees & ~changed.any(axis=1)):
        return []
    modest = np.abs(imbalance) < MODEST * np.abs(torque).min()
    found = np.flatnonzero(agrees & modest)
    if not len(found):
        return []
    fewest = changed[found].sum(axis=1).min()
    answers = {
        tuple(
            (numbers[k], float(written[k][0] * chosen[line, k])) for k in range(len(numbers)) if changed[line, k]
        ): None
        for line in found
        if changed[line].sum() == fewest
    }
    return [dict(answer) for answer in answers]


def _lines(torque: Floats, product: Floats, factors: list[Floats]) -> tuple[Floats, Floats] | None:
    """I_zz [kg*m^2] and M0 [N*m] of every line that two torques, or one with M0 = 0, may lie on."""
    slopes, constants = [], []
    for k, factor in enumerate(factors):
        slopes.append(torque[k] / (product[k] * factor))
        constants.append(np.zeros(len(factor)))
    # Two torques always lie on a line, and it tells nothing.
    for a, b in combinations(range(len(torque)), 2) if len(torque) > 2 else ():
        first, second = (x.ravel() for x in np.meshgrid(product[a] * factors[a], product[b] * factors[b]))
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = (torque[a] - torque[b]) / (first - second)
        slopes.append(slope)
        constants.append(slope * first - torque[a])
    inertia, imbalance = np.concatenate(slopes), np.concatenate(constants)
    sane = np.isfinite(inertia) & (inertia > 0) & (np.abs(imbalance) < 3 * np.abs(torque).max())
    return (inertia[sane], imbalance[sane]) if sane.any() else None
