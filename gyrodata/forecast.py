"""What another hour in the lab would gain: u(I_zz) of this log with runs or statements that it does not have.

The uncertainty of a fit hardly depends on how the readings come out, only on what was read and how well. So each
forecast takes the fitted values for the truth and adds or changes readings; `fitting.expected_u` says what they give.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from gyrodata import physics
from gyrodata.fitting import Design
from gyrodata.physics import Floats

WATCHED = 180.0
"""How long [s] a run without a weight is timed."""

DRIFT = (np.radians(5.0), 60.0, 400 * physics.RPM)
"""A balance test that is easily met: 5° [rad] in a minute [s] at 400 rpm [rad/s]."""


def with_unloaded_run(design: Design) -> Design:
    """Add a run without a weight, at the middle spin, its sense written down.

    It has its own readings of time, turns and spin, and the errors that all runs share.
    """
    problem, torque = design.problem, design.torque
    inertia, imbalance = design.unknowns[:2]
    # How much is learnt does not depend on how large M0 turns out; but no residual torque has no time.
    floor = 0.005 * np.abs(torque[torque != 0]).min()
    imbalance = np.copysign(max(abs(imbalance), floor), imbalance or 1.0)
    spin = np.sort(problem.observed[1])[problem.count // 2]
    turns = WATCHED * abs(physics.horizontal_precession_rate(imbalance, spin, inertia)) / (2 * np.pi)
    new = np.zeros(len(problem.observed))
    new[:3] = WATCHED, spin, turns
    new[7] = problem.observed[7, 0]
    shared = np.array([source.shared_by.startswith("all runs") for source in problem.sources])
    touched = np.array([source.quantity in ("time", "spin", "turns", "g") for source in problem.sources])
    group = np.where(shared, 0, np.where(touched, problem.groups.max(axis=1) + 1, -1))
    largest = problem.absolute.max(axis=1), problem.relative.max(axis=1)
    longer = problem.reread(
        _one_more(problem.observed, new),
        (_one_more(problem.absolute, largest[0]), _one_more(problem.relative, largest[1])),
        _one_more(problem.groups, group),
    )
    sense = _one_more(design.sense, np.sign(imbalance))
    return replace(design, problem=longer, sense=sense)


def _one_more(values: Any, last: Any) -> Any:
    """Put one more run at the end of the last axis."""
    more = np.empty((*values.shape[:-1], values.shape[-1] + 1), dtype=values.dtype)
    more[..., :-1], more[..., -1] = values, last
    return more


def with_both_signs(design: Design) -> Design:
    """Move the weight to the other side of the ball in every second run of each torque.

    The positions share their errors as before: one ruler, one zero.
    """
    problem = design.problem
    turned = np.zeros(problem.count, dtype=bool)
    for number, group in enumerate(_by_torque(design.torque)):
        turned[group[number % 2 :: 2]] = True
    sign = np.where(turned, -1.0, 1.0)
    torque = sign * design.torque
    inertia, imbalance = design.unknowns[:2]
    observed = problem.observed.copy()
    observed[4] *= sign
    observed[6] *= sign
    rate = np.abs(physics.horizontal_precession_rate(torque + imbalance, observed[1], inertia))
    observed[0] = 2 * np.pi * observed[2] / rate
    # A position on the other side is another reading.
    split = np.array([source.name in ("position", "torque") for source in problem.sources], dtype=bool)
    apart = split[:, None] & (problem.groups >= 0)
    groups = np.where(apart, 2 * problem.groups + turned, problem.groups)
    moved = problem.reread(observed, groups=groups)
    return replace(design, problem=moved, sense=np.sign(torque))


def _by_torque(torque: Floats) -> list[list[int]]:
    groups: dict[str, list[int]] = {}
    for i, value in enumerate(torque.tolist()):
        groups.setdefault(f"{value:.9g}", []).append(i)
    return list(groups.values())


def with_longer_times(design: Design, factor: float) -> Design:
    """Time so many times the turns in every run."""
    bias = design.unknowns[2]
    observed = design.problem.observed.copy()
    observed[0] = (observed[0] - bias) * factor + bias
    observed[2] *= factor
    return replace(design, problem=design.problem.reread(observed))


def with_better(design: Design, source: str) -> Design:
    """Make one source of error half as large."""
    problem = design.problem
    smaller = np.array([0.5 if one.name == source else 1.0 for one in problem.sources])[:, None]
    sizes = problem.absolute * smaller, problem.relative * smaller
    return replace(design, problem=problem.reread(problem.observed, sizes))


def with_balance_test(design: Design) -> Design:
    """Add a balance test in which the ball drifts no more than `DRIFT`."""
    return replace(design, tested=balance_test(float(design.unknowns[0])))


def balance_test(inertia: float) -> float:
    """Standard uncertainty of M0 [N*m] that a balance test leaves where the ball drifts no more than `DRIFT`."""
    angle, seconds, spin = DRIFT
    return float(inertia * spin * angle / seconds)
