"""The self-check compares the intervals of simulated labs with the known truth.

This lab is simulated many times.

The simulated labs have the design of the log, its fitted values as the truth, and its
stated uncertainties. Each day has its own M0 and its own hand, as in the fit. The
recommended fit and the textbook fits are applied to each lab. If the runs of the log
scatter more or less than stated, labs with this scatter are simulated too, because the
intervals depend on it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress
from html import escape
from typing import Any, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, physics
from gyrodata.base.errors import insist_on_type
from gyrodata.judging.changes import Lab
from gyrodata.measurements import Measurements, Source, select
from gyrodata.physics import Floats
from gyrodata.reporting.values import in_columns
from gyrodata.results import Analysis, to_json

DOUBTED = 0.025
"""The scatter of the log differs from the stated one if the probability that it is not
larger, or not smaller, is below this."""

READ = (
    "time",
    "spin",
    "turns",
    "mass",
    "position",
    "force",
    "given_torque",
    "g",
    "pitch",
    "added",
)
"""The readings that have errors in a simulated lab."""


class Performance(Struct, frozen=True):
    """The results of one fit in the simulated labs.

    None if the fit gives no answer in any lab.
    """

    name: str
    """"recommended", "through_origin", "with_constant" or "mean_of_ratios"."""
    bias: float | None
    """Mean of I_zz over the true one, minus 1 [1]."""
    rmse: float | None
    """Root mean square of the relative error of I_zz [1]."""
    coverage_68: float | None
    """Fraction of the labs whose 68.3 % interval contains the true I_zz [1]: the
    quantiles of the recommended fit, or value ± u of the others; 0.683 if the interval
    is honest."""
    coverage_95: float | None
    """The same for the 95 % interval of the recommended fit, 0.950 if it is honest, and
    for value ± 2u of the others, 0.954."""
    mean_u: float | None
    """Mean standard uncertainty over the true I_zz [1]."""
    time_us: float
    """Time for one lab [µs]."""
    refused: int = 0
    """Labs without an answer, which the other numbers do not include: the fit is
    refused, or has no uncertainty, or a time is not above 0."""


class SelfCheck(Struct, frozen=True):
    """The fits of a lab, applied to simulated labs like it."""

    labs: int
    """Number of simulated labs."""
    estimators: tuple[Performance, ...]
    """In labs with the stated or assumed uncertainties."""
    scatter: float
    """Factor on the independent errors of each run, estimated from the runs of the log
    [1]."""
    estimators_with_scatter: tuple[Performance, ...] | None
    """In labs whose runs scatter like those of the log; null if this is as stated."""
    schema: Literal["gyro.selfcheck/1"] = "gyro.selfcheck/1"

    def to_dict(self) -> dict[str, Any]:
        """Return the object of the JSON, with the schema "gyro.selfcheck/1"."""
        return {"schema": self.schema, **to_json(self)}

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        return f'<pre style="white-space: pre-wrap">{escape(str(self))}</pre>'

    def __str__(self) -> str:
        """Return a table, or two if the log does not scatter as stated."""
        labs = f"{self.labs} simulated labs like this one"
        stated = _table(f"{labs}, with the stated scatter", self.estimators)
        legend = (
            "in 68 % and 95 %: ± u and ± 2u of the textbook fits (honest: 68.3 and 95.4). "
            "refused: labs without an answer. µs: time for a lab"
        )
        note = "this log scatters as stated"
        tables = [stated, legend]
        if self.estimators_with_scatter is not None:
            note = (
                f"this log scatters {self.scatter:.2g} times as much as stated: trust "
                "the first table"
            )
            own = _table(f"{labs}, with its own scatter", self.estimators_with_scatter)
            tables.insert(0, own)
        return "\n\n".join([note, *tables])

    __repr__ = __str__


def _table(title: str, estimators: tuple[Performance, ...]) -> str:
    """Write what each fit reaches in columns."""
    heads = ["fit", "bias", "rmse", "mean u", "in 68 %", "in 95 %", "refused", "µs"]
    rows = [heads]
    for fit in estimators:
        name = fit.name.replace("_", " ").replace("constant", "intercept")
        parts = fit.bias, fit.rmse, fit.mean_u, fit.coverage_68, fit.coverage_95
        cells = ["-" if part is None else f"{100 * part:.2f}" for part in parts]
        rows.append([name, *cells, str(fit.refused), f"{fit.time_us:.1f}"])
    lines = in_columns(rows, right=range(1, len(heads)))
    return "\n".join([f"{title}; in % of the true I_zz", *lines])


def selfcheck(
    lab: Analysis,
    labs: int = 1000,
    seed: int = 1,
    progress: Callable[[int], None] | None = None,
) -> SelfCheck:
    """Simulate a lab many times, and count how often its intervals contain the truth.

    This is the command ``gyro selfcheck``.

    Parameters
    ----------
    lab : Analysis
        An analysed log; runs that were left out are not simulated.
    labs : int
        Number of simulated labs.
    seed : int
        Seed of the random numbers.
    progress : callable, optional
        Called with the number of labs of a table that are done.

    Returns
    -------
    SelfCheck

    Raises
    ------
    TypeError
        If `lab` is not an Analysis.
    ValueError
        If `labs` is below 1.

    Notes
    -----
    The true readings are those of the log, and the true I_zz and M0 are the fitted
    ones, M0 for each day. The timing bias of each day is drawn from its prior, and
    every error from its source.
    """
    insist_on_type("lab", lab, Analysis, "an Analysis, the result of analyze")
    if labs < 1:
        raise ValueError("labs must be at least 1")
    kept = [i for i, run in enumerate(lab.run_table) if not run.left_out]
    measured = select(lab.measurements, kept)
    motion = lab.lab.motion
    fit = fitting.fit(measured, tilted=motion.tilted)
    assert fit.posterior is not None
    typical = Lab(None, measured, fit, motion)
    stated = _try_fits(typical, 1.0, labs, seed, progress)
    with_scatter = None
    larger = float(fit.posterior.weight[fit.posterior.factor > 1].sum())
    scatter = fit.widths.scatter
    if min(larger, 1 - larger) < DOUBTED:
        with_scatter = _try_fits(typical, scatter, labs, seed, progress)
    return SelfCheck(labs, stated, scatter, with_scatter)


def _try_fits(
    lab: Lab,
    scatter: float,
    labs: int,
    seed: int,
    progress: Callable[[int], None] | None,
) -> tuple[Performance, ...]:
    """Apply the fits to simulated labs, and compare their answers with the truth."""
    random = np.random.default_rng(seed)
    names = "recommended", *fitting.TEXTBOOK
    ends = np.zeros((len(names), labs, 5))
    seconds = np.zeros(len(names))
    for i in range(labs):
        drawn = draw(lab, scatter, random)
        for k, name in enumerate(names):
            begun = time.perf_counter()
            ends[k, i] = _answer(name, drawn, lab.motion.tilted)
            seconds[k] += time.perf_counter() - begun
        if progress is not None:
            progress(i + 1)
    times_us = (1e6 * seconds / labs).tolist()
    return tuple(map(_judge, names, ends / lab.fit.inertia.value, times_us))


def _judge(name: str, ends: Floats, time_us: float) -> Performance:
    """Compare the answers of a fit with the truth, which is 1.

    There are five ends of intervals for each lab.
    """
    answered = ends[np.isfinite(ends).all(axis=1)]
    refused = len(ends) - len(answered)
    if not len(answered):
        return Performance(name, None, None, None, None, None, time_us, refused)
    low, below, value, above, high = answered.T
    bias = float(value.mean() - 1)
    return Performance(
        name,
        bias=bias,
        rmse=math.hypot(bias, value.std()),
        coverage_68=float(np.mean((below <= 1) & (above >= 1))),
        coverage_95=float(np.mean((low <= 1) & (high >= 1))),
        mean_u=float((above - below).mean() / 2),
        time_us=time_us,
        refused=refused,
    )


def draw(lab: Lab, scatter: float, random: np.random.Generator) -> Measurements:
    """Draw a lab: true times, and the errors of each source on the readings.

    Each day has its M0 and its hand.
    """
    measured = lab.measured
    truth = _truth(lab)
    readings = dict(truth)
    hands = random.standard_normal(measured.day.max() + 1)
    readings["time"] = truth["time"] + measured.timing_bias_u * hands[measured.day]
    for source in measured.sources:
        name = "given_torque" if source.quantity == "torque" else source.quantity
        if name in truth:
            size = source.absolute + source.relative * truth[name]
            errors = size * _drawn(source, scatter, random)
            readings[name] = readings[name] + errors
    g = float(readings.pop("g")[0])
    # The torque follows from the readings, as a student computes it; those that the log
    # does not contain are NaN.
    by_weight = physics.torque(readings["mass"], readings["position"], g)
    by_force = readings["force"] * readings["position"]
    applied = np.nansum([by_weight, by_force, readings["given_torque"]], axis=0)
    return replace(measured, **readings, g=g, torque=applied, slowing=1.0)


def _truth(lab: Lab) -> dict[str, Floats]:
    """Return the true readings of each run; the times follow from the others."""
    measured = lab.measured
    fit = lab.fit
    across = fitting.transverse_inertia(measured)
    pitch = measured.pitch * lab.motion.tilted
    # The weight turns with the ball if its own inertia is given.
    inertia = fit.inertia.value + measured.added
    torque = measured.torque + fit.balances
    spin = fit.sense * measured.corrected_spin
    rate = physics.precession_rate(torque, spin, inertia, across, pitch)
    count = len(measured.runs)
    truth = {name: np.broadcast_to(getattr(measured, name), count) for name in READ}
    truth["time"] = 2 * np.pi * measured.turns / np.abs(rate)
    return truth


def _drawn(source: Source, scatter: float, random: np.random.Generator) -> Any:
    """Draw the error of each run from a source, in its u; a group has one error."""
    groups = source.groups
    count = groups.max(initial=0) + 1
    drawn = random.standard_normal(count)[groups] * (groups >= 0)
    # An error that a run does not share is independent, as in the fit.
    runs = np.bincount(groups[groups >= 0], minlength=count)[groups]
    return drawn * np.where(runs == 1, scatter, 1.0)


def _answer(name: str, lab: Measurements, tilted: bool) -> Floats:
    """Apply a fit to a lab.

    Return five ends of intervals, shape (5,): the quantiles of the recommended fit, or
    value − 2u, − u, + 0, + u and + 2u of another fit. They are NaN if a time is not
    above zero, or if the fit is refused. A line with an intercept needs different
    torques.
    """
    nothing = np.full(5, math.nan)
    if not (lab.time > 0).all():
        return nothing
    if name == "recommended":
        with suppress(fitting.NoFit):
            posterior = fitting.fit(lab, tilted=tilted).posterior
            assert posterior is not None
            return posterior.quantiles()
        return nothing
    if name == "with_constant" and not fitting.torques_differ(lab.torque):
        return nothing
    value, u = fitting.TEXTBOOK[name](lab.product, lab.torque)
    return value + u * np.arange(-2, 3)
