"""What another hour in the lab would gain: u(I_zz) of this log with runs or statements that it does not have.

The uncertainty of a fit hardly depends on how the readings come out, only on what was read and how well. So each
forecast takes the fitted values for the truth and adds or changes readings; `fitting.expected_u` says what they give.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from gyrodata import physics
from gyrodata.fitting import FitResult
from gyrodata.measurements import Measurements, Source
from gyrodata.physics import Floats

WATCHED = 180.0
"""How long [s] a run without a weight is timed."""

DRIFT = (np.radians(5.0), 60.0, 400 * np.pi / 30)
"""A balance test that is easily met: 5° [rad] in a minute [s] at 400 rpm [rad/s]."""


def with_unloaded_run(measured: Measurements, fit: FitResult) -> Measurements:
    """Add a run without a weight, at the middle spin, its sense written down.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their fit: the truth of the forecast.

    Returns
    -------
    Measurements
        n + 1 runs.
    """
    # How much is learnt does not depend on how large M0 turns out; but no residual torque has no time.
    floor = 0.005 * float(np.abs(measured.torque[measured.torque != 0]).min())
    imbalance = float(np.copysign(max(abs(fit.imbalance.value), floor), fit.imbalance.value or 1.0))
    spin = float(np.sort(measured.spin)[len(measured.spin) // 2])
    turns = WATCHED * abs(physics.precession_rate(imbalance, spin, fit.inertia.value)) / (2 * np.pi)
    new = {"time": WATCHED, "turns": turns, "spin": spin, "sense": float(np.sign(imbalance)), "slowing": 1.0}

    def added(name: str, values: Floats) -> Floats:
        """A quantity that no run has stays absent; one that the new run does not have is nothing."""
        more = np.empty(len(values) + 1)
        more[:-1] = values
        more[-1] = np.nan if np.isnan(values).all() else new.get(name, 0.0)
        return more

    return _changed(
        measured,
        added,
        runs=(*measured.runs, "forecast"),
        lines=(*measured.lines, 0),
        sources=tuple(_source_with_unloaded(source) for source in measured.sources),
    )


def _source_with_unloaded(source: Source) -> Source:
    """Give the new run its own reading of time and spin, the errors that all runs share, and no weight."""
    touched = source.quantity in ("time", "spin", "turns", "g")
    shared = source.shared_by.startswith("all runs")
    group = 0 if shared else max(source.groups) + 1 if touched else -1
    return replace(
        source,
        groups=(*source.groups, group),
        absolute=_one_more(source.absolute),
        relative=_one_more(source.relative),
    )


def _one_more(values: Floats) -> Floats:
    """Values with the largest of them once more at the end."""
    more = np.empty(len(values) + 1)
    more[:-1] = values
    more[-1] = values.max()
    return more


def with_both_signs(measured: Measurements, fit: FitResult) -> Measurements:
    """Move the weight to the other side of the ball in every second run of each torque.

    Parameters
    ----------
    measured : Measurements
        n runs, weights on one side.
    fit : FitResult
        Their fit: the truth of the forecast.

    Returns
    -------
    Measurements
        n runs, with the positions' errors shared as before (one ruler, one zero).
    """
    turned = np.zeros(len(measured.runs), dtype=bool)
    for number, group in enumerate(_by_torque(measured)):
        turned[group[number % 2 :: 2]] = True
    sign = np.where(turned, -1.0, 1.0)
    torque = sign * measured.torque
    rate = np.abs(physics.precession_rate(torque + fit.imbalance.value, measured.spin, fit.inertia.value))
    moved = {
        "torque": torque,
        "given_torque": sign * measured.given_torque,
        "position": sign * measured.position,
        "time": 2 * np.pi * measured.turns / rate,
        "sense": np.sign(torque),
    }
    sources = tuple(
        replace(source, groups=_apart(source.groups, turned)) if source.name in ("position", "torque") else source
        for source in measured.sources
    )
    return _changed(measured, lambda name, values: moved.get(name, values), sources=sources)


def _by_torque(measured: Measurements) -> list[list[int]]:
    groups: dict[str, list[int]] = {}
    for i, torque in enumerate(measured.torque):
        groups.setdefault(f"{torque:.9g}", []).append(i)
    return list(groups.values())


def _apart(groups: tuple[int, ...], turned: Any) -> tuple[int, ...]:
    """A position on the other side is another reading."""
    return tuple(2 * group + int(other) if group >= 0 else -1 for group, other in zip(groups, turned, strict=True))


def balance_test(inertia: float) -> float:
    """Standard uncertainty of M0 [N*m] that a balance test leaves where the ball drifts no more than `DRIFT`.

    Parameters
    ----------
    inertia : float
        I_zz [kg*m^2].

    Returns
    -------
    float
    """
    angle, seconds, spin = DRIFT
    return float(inertia * spin * angle / seconds)


def _changed(measured: Measurements, change: Callable[[str, Floats], Floats], **fields: Any) -> Measurements:
    """Apply `change` to each array of the measurements."""
    arrays: dict[str, Any] = {
        name: change(name, value)
        for name in measured.__dataclass_fields__
        if isinstance(value := getattr(measured, name), np.ndarray)
    }
    return replace(measured, **arrays, **fields)
