"""The story on one page: readings → measurements → which effects matter → fit → `Analysis`.

`analyze` is the whole tool without its printing; `reporting` and `plotting` only put its answer into other words.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO, get_args

import numpy as np
from msgspec.structs import replace

from gyrodata import effects, findings, fitting, tables
from gyrodata.changes import Lab
from gyrodata.diagnostics import NO_STEADY_PRECESSION, NO_TORQUE, TOO_MANY_SHARED_READINGS
from gyrodata.effects import Outcome, Sensitivity
from gyrodata.errors import LogError, insist_on_choice, insist_on_type
from gyrodata.fitting import Estimate, Model, NoFit, Outlier
from gyrodata.measurements import Measurements, measure
from gyrodata.patterns import look_for_patterns
from gyrodata.readings import Readings, read_log, value_text
from gyrodata.results import DOF_REASON, DOUBTS, Analysis, Doubt, Options, Result
from gyrodata.wrong_cells import explain

if TYPE_CHECKING:
    import os

    import pandas as pd

LARGEST = 3_000_000
"""Runs times shared readings that one fit may hold: a matrix of this many numbers is solved several times."""


def analyze(
    log: str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame,
    *,
    name: str | None = None,
    settings: Mapping[str, Any] | None = None,
    mapping: Mapping[str, str] | None = None,
    config: str | os.PathLike[str] | None = None,
    model: Model = "auto",
    keep_flagged: bool = False,
) -> Analysis:
    """Turn a log into I_zz with its uncertainty, and everything that goes with it.

    Parameters
    ----------
    log : path, bytes, file or DataFrame
        What ``gyro analyze`` reads; the text of a log as bytes.
    name : str, optional
        Name to call it by.
    settings : mapping, optional
        Constants, as ``--set``: ``{"g": "9.803 m/s^2"}``; a quantity of pint or a number of uncertainties will do.
    mapping : mapping, optional
        Headers of roles, as ``--map``: ``{"time": "T (s)"}``.
    config : path, optional
        TOML file with the same.
    model : {"auto", "horizontal", "steady", "released"}
        Eq. (9), eq. (8), the mean rate of a rod let go from rest, or the simplest of them that the log allows.
    keep_flagged : bool
        Keep runs in the fit that do not go with the others.

    Returns
    -------
    Analysis

    Raises
    ------
    InputError
        If there is nothing that can be read.
    LogError
        If the log is wrong or incomplete; it lists every fault found.
    TypeError, ValueError
        If an argument cannot be what it is; it says what it may be.
    """
    insist_on_choice("model", model, get_args(Model))
    insist_on_type("keep_flagged", keep_flagged, bool, "True or False")
    readings = read_log(log, name=name, settings=settings or {}, mapping=mapping or {}, config=config)
    options = Options(
        set={key: value_text(value) for key, value in sorted((settings or {}).items())},
        map=dict(sorted((mapping or {}).items())),
        config=None if config is None else Path(config).name,
        model=model,
        keep_flagged=keep_flagged,
    )
    return analyze_readings(readings, options)


def analyze_readings(readings: Readings, options: Options | None = None, *, whole: bool = True) -> Analysis:
    """Analyse a log that has been read; see `analyze`.

    `whole`: False leaves out what a report tells and a grade does not: advice, doubts, sensitivity, the tables of fits
    and laws, what each torque does to the answer, and effects, but for a release that may matter and is not told.
    """
    options = options or Options()
    if any(diagnostic.severity == "error" for diagnostic in readings.diagnostics):
        raise LogError(readings.diagnostics)
    measured = measure(readings)
    sizes = findings.size_findings(readings, measured)
    found = [*readings.diagnostics, *measured.diagnostics, *sizes]
    if not np.any(measured.torque):
        words = "no run has a torque, so nothing ties the precession to I_zz"
        raise LogError([*found, readings.diagnose(NO_TORQUE, words, "add runs with a weight: mass and position")])
    try:
        lab, outliers, no_odd_run = fit_runs(readings, measured, options.model, options.keep_flagged)
    except LogError as error:
        raise LogError([*found, *error.diagnostics]) from None

    measured, fit, kept = lab.measured, lab.fit, lab.kept
    p = fitting.chi2_tail(fit.chi2, fit.dof) if fit.dof > 0 else None
    needed = whole or (measured.motion is None and effects.release_may_matter(lab))
    listed = effects.list_effects(lab, () if whole else ("release",)) if needed else ()
    patterns = look_for_patterns(measured, fit)
    exponent = tables.overall_exponent(measured, kept) if whole else None
    seen = findings.Seen(readings, lab, outliers, no_odd_run, p, listed, patterns, exponent, tuple(sizes), whole)
    found += findings.findings(seen)
    changed = list(effects.answers(lab, "sensitivity")) if whole else []
    without = {one.case.torque: one.inertia for one in changed if one.case.torque is not None and one.inertia}
    as_written = fit.inertia if measured.balanced else None
    balanced = next((one.inertia for one in changed if one.name == "balanced"), as_written)
    out = set(lab.left_out)
    # Without a weight a turn may take an hour.
    silent = {line for i, line in enumerate(measured.lines) if i in out or not measured.torque[i]}
    denied = [one for one in found if one.doubt and not (one.doubt == "size" and one.line in silent)] if whole else []
    doubts = tuple(Doubt(kind, one.message, one.hint) for kind in DOUBTS for one in denied if one.doubt == kind)
    # The gain of another hour is computed for runs that follow the law.
    advice = tuple(f"find the cause first: {doubt.remedy}" for doubt in doubts)
    return Analysis(
        name=readings.name,
        sha256=readings.sha256,
        options=options,
        readings=readings,
        measurements=measured,
        fit=fit,
        model=lab.chosen,
        outliers=outliers,
        inertia=_result(fit.inertia),
        residual_torque=_result(fit.residual_torque),
        timing_bias=_result(fit.timing_bias),
        if_balanced=balanced if whole and not fitting.torques_differ(measured.torque[kept]) else None,
        doubts=doubts,
        p=p,
        birge=math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else None,
        fits=tables.named_fits(measured, fit, kept) if whole else (),
        budget=fit.budget,
        sensitivity=tuple(_sensitivity(fit.inertia, one) for one in changed),
        effects=listed,
        power_law=tables.power_laws(measured, kept) if whole else (),
        exponent=exponent,
        constancy=tables.constancy(measured, kept) if whole else None,
        ball=tables.compare_with_ball(fit.inertia, readings.constants, readings.uncertainties) if whole else None,
        torques=tables.torque_table(measured, fit, kept, without),
        run_table=tables.run_table(measured, fit, outliers, lab.left_out),
        patterns=patterns,
        advice=advice or (findings.list_advice(lab) if whole else ()),
        diagnostics=tuple(found),
    )


ABSURD = 1000.0
"""A Birge ratio above this is no scatter: the uncertainties stated were not meant."""

EXACT = 1e-6
"""No lab knows I_zz better than by this share of it."""

HOPELESS = 1e-6
"""Where chi-square is less likely than this, counts that explain all torques are no accident."""


def fit_runs(
    readings: Readings, measured: Measurements, model: Model = "auto", keep_flagged: bool = False
) -> tuple[Lab, tuple[Outlier, ...], Estimate | None]:
    """Choose the model, find the runs that do not agree with the others, and fit the rest.

    Parameters
    ----------
    readings : Readings
        The log.
    measured : Measurements
        Its n runs, at least one with a torque.
    model, keep_flagged
        As for `analyze`.

    Returns
    -------
    tuple of Lab, tuple of Outlier, and Estimate or None
        The log with its recommended fit; the runs that look odd; and I_zz without any of these [kg*m^2], if one is
        kept.

    Raises
    ------
    LogError
        If there is no answer, or none that can be believed; it says what to look at.
    """
    shared = sum(source.shared_count for source in measured.sources)
    if shared * len(measured.runs) > LARGEST:
        several = f"{shared} weights, positions and spins that stand in several of them"
        words = f"{len(measured.runs)} runs with {several} are too much for one fit"
        hint = "split the log, and give each part on its own"
        raise LogError([readings.diagnose(TOO_MANY_SHARED_READINGS, words, hint)])
    if model == "released" or (model == "auto" and measured.motion == "released"):
        fallen = findings.fall_findings(readings, measured)
        if fallen:
            raise LogError(fallen)
    try:
        runs, chosen = measured, effects.choose_model(measured, model)
        outliers, screened = fitting.screen(runs, chosen.tilted)
        if fitting.is_corrected(measured, chosen):
            odd = tuple(outlier.index for outlier in outliers)
            runs, _ = fitting.fit_model(measured, chosen, odd, fitting.AS_STATED)
            outliers, screened = fitting.screen(runs, chosen.tilted)
        odd = tuple(outlier.index for outlier in outliers)
        # A run that is merely odd is still a measurement, and stays.
        left_out = () if keep_flagged else tuple(outlier.index for outlier in outliers if outlier.slip)
        fit = fitting.fit(runs, tilted=chosen.tilted, left_out=left_out)
        without = fitting.fit(runs, tilted=chosen.tilted, left_out=odd).inertia if odd != left_out else None
        if not np.isfinite(fit.fitted_time).all():
            why = "eq. (8) has no real solution for a run: the rod is up and the spin too low to precess steadily"
            raise LogError([readings.diagnose(NO_STEADY_PRECESSION, why, "check pitch, spin and transverse_inertia")])
        says = np.array([i not in odd for i in range(len(measured.runs))])
        fitting.insist_on_lines(runs, fit, chosen.tilted, says)
        if fit.dof <= 0 and (fit.inertia.u or 0.0) < EXACT * fit.inertia.value:
            # Without a run to spare nothing could refute it.
            why = "all uncertainties are stated as zero, and no run is left over to tell how well the others agree"
            raise NoFit(why)
        birge = math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else 0.0
        if birge > ABSURD:
            raise NoFit(f"they scatter {birge:.2g} times as much as the stated uncertainties allow")
        if fit.inertia.interval_95 is not None and findings.is_unmeasured(fit.inertia):
            raise LogError([findings.not_measured(readings, fit)])
    except NoFit as reason:
        miscounted = findings.count_findings(readings, measured)
        raise LogError(miscounted or [findings.refusal(readings, measured, str(reason), keep_flagged)]) from None
    if fit.dof > 0 and fitting.chi2_tail(fit.chi2, fit.dof) < HOPELESS:
        miscounted = findings.count_findings(readings, runs, fit, left_out)
        if miscounted:
            raise LogError(miscounted)
    # How far one that is left out is off by the recommended fit, as in the table of runs and the figure.
    shown = tuple(
        replace(outlier, deviation=float(fit.deviations[outlier.index])) if outlier.index in left_out else outlier
        for outlier in outliers
    )
    lab = Lab(readings, runs, fit, chosen, left_out)
    return lab, explain(readings, runs, chosen, shown, screened or fit), without


def _sensitivity(answer: Estimate, outcome: Outcome) -> Sensitivity:
    """Compare the answer of a changed log with that of the log."""
    inertia = outcome.inertia
    deviation = (inertia.value - answer.value) / answer.u if inertia and answer.u else None
    return Sensitivity(outcome.name, outcome.words, inertia, deviation)


def _result(estimate: Estimate) -> Result:
    """Put a value with its interval into words that GUM has."""
    value, u, interval = estimate.value, estimate.u, estimate.interval_95
    assert u is not None
    assert interval is not None
    half = (interval[1] - interval[0]) / 2
    relative, k = abs(u / value) if value else None, half / u if u else None
    return Result(
        value, u, estimate.unit, interval,
        k=k, dof=None, expanded_u=half, relative_u=relative, level=0.95, dof_reason=DOF_REASON,
    )  # fmt: skip
