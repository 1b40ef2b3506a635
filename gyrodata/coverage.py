"""Is the answer to be trusted? This very lab, simulated many times, with the answers known.

The lab's own design, its fitted values as the truth and its own stated uncertainties make new readings; the
recommended fit and those of the textbook are applied to each. How often the true I_zz lies in the interval that they
quote is what their uncertainty is worth. Labs with the stated uncertainties cannot show what happens to the intervals
if these are wrong: if the log's own runs scatter otherwise, labs that scatter so are simulated too.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Literal, cast

import numpy as np
from msgspec import Struct, to_builtins
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.errors import insist_on_type
from gyrodata.fitting import TEXTBOOK, FitResult, NoFit, fit, torques_differ, transverse_inertia
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

DOUBTED = 0.025
"""The log's scatter is not what is stated if the chance that it is no larger, or no smaller, is below this."""


class Performance(Struct, frozen=True):
    """The results of one estimator in the simulated labs; None if it gives no answer or no uncertainty."""

    name: str
    """"recommended", "through_origin", "with_constant" or "mean_of_ratios"."""
    bias: float | None
    """Mean of I_zz over the true one, minus 1 [1]."""
    rmse: float | None
    """Root mean square of the same [1]."""
    coverage_68: float | None
    """Part of the labs whose 68.3 % interval holds the true I_zz: between the quantiles for the recommended fit, value
    ± u for the others; 0.683 if it is honest."""
    coverage_95: float | None
    """The same for the 95 % interval of the recommended fit, 0.950 if it is honest, and for value ± 2u of the others,
    0.954."""
    mean_u: float | None
    """Mean quoted standard uncertainty over the true I_zz [1]."""
    time_us: float
    """Time for one lab [µs]."""
    refused: int = 0
    """Labs without an answer, which no other number here counts: the fit is refused, or a time is not above zero."""


class SelfCheck(Struct, frozen=True):
    """A lab's fits, tried out on simulated labs like it."""

    labs: int
    """How many were simulated."""
    estimators: tuple[Performance, ...]
    """In labs with the uncertainties as stated, or as assumed where the log states none."""
    scatter: float
    """Factor on the errors that each run has alone, as the log's own runs show it [1]."""
    estimators_with_scatter: tuple[Performance, ...] | None
    """In labs whose runs scatter as this log's do; null where that is as stated."""
    schema: Literal["gyro.selfcheck/1"] = "gyro.selfcheck/1"

    def to_dict(self) -> dict[str, Any]:
        """Give it as the JSON contract has it."""
        return {"schema": self.schema, **to_builtins(self)}

    def to_text(self) -> str:
        """Give it as a table, or as two if the log does not scatter as stated."""
        labs = f"{self.labs} simulated labs like this one"
        if self.estimators_with_scatter is None:
            parts = ["this log's scatter agrees with what is stated", _table(f"{labs}, as stated", self.estimators)]
        else:
            parts = [
                f"this log's scatter is {self.scatter:.2g} times what is stated: trust the first table",
                _table(f"{labs}, with the scatter of this log", self.estimators_with_scatter),
                _table(f"{labs}, if the scatter were as stated", self.estimators),
            ]
        return "\n\n".join([*parts, LEGEND])


LEGEND = "68 % and 95 %: the recommended fit's own intervals; of the others ± u and ± 2u (honest: 95.4)"


def _table(title: str, estimators: tuple[Performance, ...]) -> str:
    lines = [
        f"{title}; all in % of the true I_zz",
        f"{'fit':<16}{'bias':>9}{'rmse':>9}{'quoted u':>10}{'68 % holds':>12}{'95 % holds':>12}{'µs a lab':>10}",
    ]
    notes = []
    for one in estimators:
        name = one.name.replace("_", " ")
        cells = (
            (one.bias, "+.3f", 9), (one.rmse, ".3f", 9), (one.mean_u, ".3f", 10),
            (one.coverage_68, ".1f", 12), (one.coverage_95, ".1f", 12),
        )  # fmt: skip
        told = "".join(f"{'-' if v is None else format(100 * v, how):>{wide}}" for v, how, wide in cells)
        lines.append(f"{name:<16}{told}{one.time_us:>10.1f}")
        if one.refused and (one.rmse is not None or name == "recommended"):
            why = "the fit is refused, or a simulated time is not above zero"
            notes.append(
                f"{name}: {one.refused} of the labs have no answer ({why}); the numbers are those of the others"
            )
    return "\n".join([*lines, f"{'honest':<16}{'':>28}{68.3:>12}{'95.0':>12}", *notes])


def selfcheck(
    measured: Measurements,
    clock: Callable[[], float] = time.process_time,
    labs: int = 1000,
    seed: int = 1,
    tilted: bool = False,
    progress: Callable[[int], None] | None = None,
) -> SelfCheck:
    """Simulate a lab many times and see what its fits are worth, as ``gyro selfcheck`` does.

    Parameters
    ----------
    measured : Measurements
        The n runs that have a say, such as ``lab.measurements``.
    clock : callable
        Gives seconds [s].
    labs : int
        How many are simulated.
    seed : int
        Of the random numbers.
    tilted : bool
        Eq. (8) with each run's pitch, not eq. (9).
    progress : callable, optional
        Told how many labs of a table are done.

    Returns
    -------
    SelfCheck

    Raises
    ------
    ValueError, TypeError
        If there is nothing to simulate.

    Notes
    -----
    True readings are those of the log, true I_zz and M0 the fitted ones; the timing bias is drawn from its prior, every
    error from its source. Labs without an answer are counted in `Performance.refused`.
    """
    insist_on_type("measured", measured, Measurements, "what was measured: lab.measurements")
    insist_on_type("labs", labs, int, "a number of labs")
    if labs < 1:
        raise ValueError(f"{labs} labs say nothing; pass 1 or more")
    found = fit(measured, tilted=tilted)
    assert found.posterior is not None
    # Whether the runs contradict that their scatter is as stated.
    larger = float(found.posterior.weight[found.posterior.factor > 1].sum())
    scatters = (1.0, found.scatter) if min(larger, 1 - larger) < DOUBTED else (1.0,)
    names = "recommended", *TEXTBOOK
    tables = []
    for scatter in scatters:
        random = np.random.default_rng(seed)
        ends, seconds = np.full((len(names), labs, 5), math.nan), np.zeros(len(names))
        for i in range(labs):
            lab = _draw(measured, found, scatter, tilted, random)
            for k, name in enumerate(names):
                begun = clock()
                if (lab.time > 0).all():
                    ends[k, i] = _answer(name, lab, tilted)
                seconds[k] += clock() - begun
            if progress is not None:
                progress(i + 1)
        tables.append(tuple(_judge(name, ends[k], found.inertia.value, seconds[k]) for k, name in enumerate(names)))
    return SelfCheck(labs, tables[0], found.scatter, tables[1] if len(tables) > 1 else None)


def _judge(name: str, ends: Floats, truth: float, seconds: float) -> Performance:
    """Compare the answers of one way to fit, five ends of intervals a lab, with the truth."""
    answered, time_us = ends[np.isfinite(ends[:, 2])], 1e6 * float(seconds) / len(ends)
    bias = rmse = one = two = mean_u = None
    if len(answered):
        off = answered[:, 2] / truth - 1
        bias, rmse = float(off.mean()), math.sqrt(float(np.mean(off**2)))
        if np.isfinite(answered).all():
            two, one = (float(np.mean((answered[:, i] <= truth) & (truth <= answered[:, -1 - i]))) for i in (0, 1))
            mean_u = float((answered[:, 3] - answered[:, 1]).mean() / 2 / truth)
    return Performance(name, bias, rmse, one, two, mean_u, time_us, len(ends) - len(answered))


def _draw(
    measured: Measurements, found: FitResult, scatter: float, tilted: bool, random: np.random.Generator
) -> Measurements:
    """Draw a lab: true times, and each source's errors on the readings; a group of runs draws once."""
    across = transverse_inertia(measured) if tilted else 0.0
    pitch = measured.pitch if tilted else 0.0
    # The weight spins along.
    inertia, torque = found.inertia.value + measured.added, measured.torque + found.residual_torque.value
    rate = np.abs(physics.precession_rate(torque, found.sense * measured.spin, inertia, across, pitch))
    truth = {name: np.broadcast_to(getattr(measured, name), len(measured.runs)) for name in READ}
    truth["time"] = 2 * np.pi * measured.turns / rate
    readings = {name: value.copy() for name, value in truth.items()}
    readings["time"] += measured.timing_bias_u * random.standard_normal()
    for source in measured.sources:
        name = "given_torque" if source.quantity == "torque" else source.quantity
        if name in readings:
            groups = source.groups
            drawn = random.standard_normal(groups.max(initial=0) + 1)[groups] * (groups >= 0)
            # As in the fit, what a run shares with no other is its own.
            runs = np.bincount(groups[groups >= 0], minlength=groups.max(initial=0) + 1)[groups]
            drawn *= np.where(runs == 1, scatter, 1.0)
            # Errors are in proportion to the true value, and several add up.
            readings[name] += (source.absolute + source.relative * truth[name]) * drawn
    g = float(readings.pop("g")[0])
    # The torque as a student works it out from the readings.
    applied = readings["given_torque"]
    if not np.isnan(measured.mass).all():
        applied = physics.torque(readings["mass"], readings["position"], g)
    elif not np.isnan(measured.force).all():
        applied = readings["force"] * readings["position"]
    return replace(measured, **readings, g=g, torque=applied, slowing=None)


READ = ("time", "spin", "turns", "mass", "position", "force", "given_torque", "g", "pitch", "added")
"""What has errors in a simulated lab."""


def _answer(name: str, lab: Measurements, tilted: bool) -> Floats:
    """Apply a fit to a lab: the quantiles of the recommended fit, value − 2u, − u, + 0, + u and + 2u of the others.

    Shape (5,). NaN if the fit is refused; a line with a constant needs torques that differ.
    """
    if name == "recommended":
        with suppress(NoFit):
            posterior = fit(lab, tilted=tilted).posterior
            assert posterior is not None
            return cast(Floats, posterior.quantiles()[0])
    elif name != "with_constant" or torques_differ(lab.torque):
        # φ̇ψ̇ with the torque's sign, as a textbook plots it.
        product = np.where(lab.torque < 0, -1, 1) * 2 * np.pi * lab.turns / lab.time * lab.spin
        value, u = TEXTBOOK[name](product, lab.torque)
        # A fit without u has a value.
        return np.array([value - 2 * u, value - u, value, value + u, value + 2 * u])
    return np.full(5, math.nan)
