"""The self-check compares the intervals of simulated labs with the known truth.

This lab is simulated many times.

The simulated labs have the design of the log, its fitted values as the truth, and its
stated uncertainties. The recommended fit and the textbook fits are applied to each. If
the runs of the log scatter more or less than stated, labs with this scatter are
simulated too, because the intervals depend on it.
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
from gyrodata.measurements import Measurements, select
from gyrodata.physics import Floats
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

    None if the fit gives no answer or no uncertainty.
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
    refused, or a time is not above 0."""


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
        if self.estimators_with_scatter is None:
            stated = "the scatter of this log agrees with what is stated"
            parts = [stated, _table(f"{labs}, as stated", self.estimators)]
        else:
            larger = (
                f"the scatter of this log is {self.scatter:.2g} times what is stated"
            )
            heading = f"{labs}, with the scatter of this log"
            parts = [
                f"{larger}: trust the first table",
                _table(heading, self.estimators_with_scatter),
                _table(f"{labs}, if the scatter were as stated", self.estimators),
            ]
        legend = (
            "68 % and 95 %: the intervals of the recommended fit; ± u and ± 2u of the "
            "others (honest: 95.4)"
        )
        return "\n\n".join([*parts, legend])


def _table(title: str, estimators: tuple[Performance, ...]) -> str:
    heads = ("bias", "rmse", "mean u", "in 68 %", "in 95 %")
    header = f"{'fit':<16}{''.join(f'{head:>9}' for head in heads)}{'µs per lab':>12}"
    lines = [f"{title}; all in % of the true I_zz", header]
    notes = []
    for estimator in estimators:
        name = estimator.name.replace("_", " ").replace("constant", "intercept")
        values = (
            estimator.bias,
            estimator.rmse,
            estimator.mean_u,
            estimator.coverage_68,
            estimator.coverage_95,
        )
        forms = ("+.3f", ".3f", ".3f", ".1f", ".1f")
        cells = (
            "-" if value is None else f"{100 * value:{form}}"
            for value, form in zip(values, forms, strict=True)
        )
        row = "".join(f"{cell:>9}" for cell in cells)
        lines.append(f"{name:<16}{row}{estimator.time_us:>12.1f}")
        if estimator.refused and (estimator.rmse is not None or name == "recommended"):
            why = (
                "because the fit is refused or a simulated time is not above zero; "
                "they are not in the numbers above"
            )
            notes.append(
                f"{name}: {estimator.refused} of the labs have no answer, {why}"
            )
    return "\n".join([*lines, f"{'honest':<43}{68.3:>9}{'95.0':>9}", *notes])


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
    ValueError, TypeError
        If an argument has the wrong type, or if there is nothing to simulate.

    Notes
    -----
    The true readings are those of the log, and the true I_zz and M0 are the fitted
    ones. The timing bias is drawn from its prior, and every error from its source.
    """
    insist_on_type("lab", lab, Analysis, "an Analysis, the result of analyze")
    insist_on_type("labs", labs, int, "a number of labs")
    if labs < 1:
        raise ValueError(f"{labs} labs are too few; use 1 or more")
    tilted = lab.model.tilted
    measured = select(
        lab.measurements, [i for i, run in enumerate(lab.run_table) if not run.left_out]
    )
    first_fit = fitting.fit(measured, tilted=tilted)
    assert first_fit.posterior is not None
    larger = float(first_fit.posterior.weight[first_fit.posterior.factor > 1].sum())
    scatters = [1.0]
    if min(larger, 1 - larger) < DOUBTED:
        scatters.append(first_fit.widths.scatter)
    names = "recommended", *fitting.TEXTBOOK
    tables = []
    for scatter in scatters:
        random = np.random.default_rng(seed)
        ends = np.full((len(names), labs, 5), math.nan)
        seconds = np.zeros(len(names))
        for i in range(labs):
            drawn = draw(measured, first_fit, scatter, tilted, random)
            for k, name in enumerate(names):
                begun = time.perf_counter()
                if (drawn.time > 0).all():
                    ends[k, i] = _answer(name, drawn, tilted)
                seconds[k] += time.perf_counter() - begun
            if progress is not None:
                progress(i + 1)
        judged = [
            _judge(name, ends[k], first_fit.inertia.value, seconds[k])
            for k, name in enumerate(names)
        ]
        tables.append(tuple(judged))
    return SelfCheck(
        labs,
        tables[0],
        first_fit.widths.scatter,
        tables[1] if len(tables) > 1 else None,
    )


def _judge(name: str, ends: Floats, truth: float, seconds: float) -> Performance:
    """Compare the answers of a fit with the truth: five interval ends for each lab."""
    answered = ends[np.isfinite(ends[:, 2])]
    time_us = 1e6 * float(seconds) / len(ends)
    bias = rmse = in_68 = in_95 = mean_u = None
    if len(answered):
        off = answered[:, 2] / truth - 1
        bias = float(off.mean())
        rmse = math.sqrt(float(np.mean(off**2)))
        if np.isfinite(answered).all():
            in_95 = _coverage(answered[:, [0, -1]], truth)
            in_68 = _coverage(answered[:, [1, -2]], truth)
            mean_u = float((answered[:, 3] - answered[:, 1]).mean() / 2 / truth)
    return Performance(
        name, bias, rmse, in_68, in_95, mean_u, time_us, len(ends) - len(answered)
    )


def draw(
    measured: Measurements,
    fit: fitting.FitResult,
    scatter: float,
    tilted: bool,
    random: np.random.Generator,
) -> Measurements:
    """Draw a lab: true times, and the errors of each source on the readings.

    A group of runs has one error.
    """
    across = fitting.transverse_inertia(measured) if tilted else 0.0
    pitch = measured.pitch if tilted else 0.0
    # The weight turns with the ball if its own inertia is given.
    inertia = fit.inertia.value + measured.added
    torque = measured.torque + fit.residual_torque.value
    rate = np.abs(
        physics.precession_rate(
            torque, fit.sense * measured.corrected_spin, inertia, across, pitch
        )
    )
    truth = {
        name: np.broadcast_to(getattr(measured, name), len(measured.runs))
        for name in READ
    }
    truth["time"] = 2 * np.pi * measured.turns / rate
    readings = {name: value.copy() for name, value in truth.items()}
    shifts = dict.fromkeys(READ, np.zeros(len(measured.runs)))
    shifts["time"] = shifts["time"] + measured.timing_bias_u * random.standard_normal()
    for source in measured.sources:
        name = "given_torque" if source.quantity == "torque" else source.quantity
        if name in readings:
            groups = source.groups
            count = groups.max(initial=0) + 1
            drawn = random.standard_normal(count)[groups] * (groups >= 0)
            # An error that a run does not share is independent, as in the fit.
            runs = np.bincount(groups[groups >= 0], minlength=count)[groups]
            drawn *= np.where(runs == 1, scatter, 1.0)
            readings[name] *= 1 + source.relative * drawn
            shifts[name] = shifts[name] + source.absolute * drawn
    readings = {name: value + shifts[name] for name, value in readings.items()}
    g = float(readings.pop("g")[0])
    # The torque follows from the readings, as a student computes it.
    applied = readings["given_torque"]
    if not np.isnan(measured.mass).all():
        applied = physics.torque(readings["mass"], readings["position"], g)
    elif not np.isnan(measured.force).all():
        applied = readings["force"] * readings["position"]
    return replace(measured, **readings, g=g, torque=applied, slowing=1.0)


def _coverage(ends: Floats, truth: float) -> float:
    """Return the share of intervals with the truth, from their ends, shape (n, 2)."""
    low, high = ends.T
    return float(np.mean((low <= truth) & (truth <= high)))


def _answer(name: str, lab: Measurements, tilted: bool) -> Floats:
    """Apply a fit to a lab.

    Return five ends of intervals, shape (5,): the quantiles of the recommended fit, or
    value − 2u, − u, + 0, + u and + 2u of another fit. They are NaN if the fit is
    refused. A line with an intercept needs different torques.
    """
    if name == "recommended":
        with suppress(fitting.NoFit):
            posterior = fitting.fit(lab, tilted=tilted).posterior
            assert posterior is not None
            return posterior.quantiles()
    elif name != "with_constant" or fitting.torques_differ(lab.torque):
        # φ̇ψ̇ with the sign of the torque, as a textbook plots it.
        rate = 2 * np.pi * lab.turns / lab.time
        product = np.where(lab.torque < 0, -1, 1) * rate * lab.spin
        value, u = fitting.TEXTBOOK[name](product, lab.torque)
        return np.array([value - 2 * u, value - u, value, value + u, value + 2 * u])
    return np.full(5, math.nan)
