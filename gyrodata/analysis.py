"""The story on one page: read a log, measure its runs, fit them, and judge the fit.

`fit_log` is all that a grade needs; `judge` adds what a report shows. `analyze` does
both; the room `reporting` shows its result.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO

import numpy as np
from msgspec.structs import asdict, replace

from gyrodata import fitting
from gyrodata.base.errors import Diagnostic, LogError, insist_on_choice, insist_on_type
from gyrodata.fitting import Estimate, NoFit, Outlier
from gyrodata.judging import changes, findings, refusals, tables, wrong_cells
from gyrodata.judging.changes import Lab
from gyrodata.judging.procedure import what_lacks
from gyrodata.measurements import Measurements, checks, measure
from gyrodata.physics import models
from gyrodata.physics.models import AUTO, Model
from gyrodata.readings import Readings, read_log, value_text
from gyrodata.results import DOUBTS, Analysis, Doubt, FittedLog, Options, Result

if TYPE_CHECKING:
    import os

    import pandas as pd

    from gyrodata.base.errors import Diagnostic

LARGEST = 3_000_000
"""Largest number of runs times shared readings in one fit, which is the size of its
matrix."""


def analyze(
    log: str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame,
    *,
    name: str | None = None,
    settings: Mapping[str, Any] | None = None,
    mapping: Mapping[str, str] | None = None,
    config: str | os.PathLike[str] | None = None,
    model: Model = AUTO,
    keep_flagged: bool = False,
) -> Analysis:
    """Compute I_zz with its uncertainty from a log, and everything that the report shows.

    Parameters
    ----------
    log : path, bytes, str, file or DataFrame
        The same as for ``gyro analyze``; bytes, and a str of several lines, are the
        text of a log.
    name : str, optional
        Name of the log in messages.
    settings : mapping, optional
        Constants, such as ``{"g": "9.803 m/s^2"}``; a value can also be a quantity of
        pint or a number of uncertainties. In the command: ``--set``.
    mapping : mapping, optional
        Headers of the columns by role, such as ``{"time": "T (s)"}``. In the command:
        ``--map``.
    config : path, optional
        TOML file with settings and mapping.
    model : {"auto", "horizontal", "steady", "released"}
        Eq. (9), eq. (8), the mean rate of a rod that is released from rest, or the
        simplest of them that is accurate enough for the log.
    keep_flagged : bool
        Keep suspected outliers in the fit.

    Returns
    -------
    Analysis

    Raises
    ------
    InputError
        If the log cannot be read.
    LogError
        If the log contains errors or is incomplete; it lists all faults.
    TypeError, ValueError
        If an argument has the wrong type or value.
    """
    insist_on_choice("model", model, (AUTO, *models.names()))
    insist_on_type("keep_flagged", keep_flagged, bool, "True or False")
    readings = read_log(
        log, name=name, settings=settings or {}, mapping=mapping or {}, config=config
    )
    options = Options(
        set={key: value_text(value) for key, value in sorted((settings or {}).items())},
        map=dict(sorted((mapping or {}).items())),
        config=None if config is None else Path(config).name,
        model=model,
        keep_flagged=keep_flagged,
    )
    return analyze_readings(readings, options)


def analyze_readings(readings: Readings, options: Options | None = None) -> Analysis:
    """Fit a log, and judge the fit; see `analyze`."""
    return judge(fit_log(readings, options or Options()))


def fit_log(readings: Readings, options: Options) -> FittedLog:
    """Fit a log: measure its runs, choose a model, find the outliers.

    Parameters
    ----------
    readings : Readings
        The log.
    options : Options
        The options of the analysis.

    Returns
    -------
    FittedLog
        The fit. Its diagnostics are those of the readings and of the measurements.

    Raises
    ------
    LogError
        If the log contains errors, or if its runs do not determine a credible I_zz.
    """
    if "error" in map(attrgetter("severity"), readings.diagnostics):
        raise LogError(readings.diagnostics)
    measured = measure(readings)
    measured = replace(
        measured, diagnostics=(*measured.diagnostics, *checks.check(readings, measured))
    )
    sizes = tuple(checks.check_sizes(readings, measured))
    diagnostics = (*readings.diagnostics, *measured.diagnostics, *sizes)
    if not np.any(measured.torque):
        raise LogError([*diagnostics, readings.say("all_torques_zero")])
    try:
        lab, outliers, without_outliers = fit_runs(
            readings, measured, options.model, options.keep_flagged
        )
    except LogError as error:
        raise LogError([*diagnostics, *error.diagnostics]) from None
    measured, fit = lab.measured, lab.fit
    torques = tables.torque_table(measured, fit, _kept_groups(measured, fit), {})
    return FittedLog(
        name=readings.name,
        sha256=readings.sha256,
        options=options,
        readings=readings,
        measurements=measured,
        fit=fit,
        model=lab.chosen,
        choice=lab.choice,
        outliers=outliers,
        without_outliers=without_outliers,
        inertia=_result(fit.inertia),
        residual_torque=_result(fit.residual_torque),
        timing_bias=_result(fit.timing_bias),
        p=fitting.chi2_tail(fit.chi2, fit.dof) if fit.dof > 0 else None,
        birge=math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else None,
        budget=fit.budget,
        effects=lab.effects,
        constancy=tables.constancy(measured, torques, _kept_groups(measured, fit)),
        torques=torques,
        run_table=tables.run_table(measured, fit, outliers, lab.left_out),
        patterns=tables.look_for_patterns(measured, fit),
        unusual_sizes=sizes,
        diagnostics=diagnostics,
    )


def judge(log: FittedLog) -> Analysis:
    """Judge a fit: list the effects, the other fits, the findings, doubts and advice."""
    log = replace(log, effects=changes.list_effects(log.lab))
    lab, measured, fit = log.lab, log.measurements, log.fit
    groups = _kept_groups(measured, fit)
    sensitivity = changes.answers(lab, "sensitivity")
    without_torque = {
        change.torque: answer.inertia
        for change, answer in sensitivity
        if change.torque is not None and answer.inertia
    }
    exponent = tables.common_exponent(measured, groups)
    diagnostics = (*log.diagnostics, *_findings(log, findings.CHECKS, exponent))
    doubts = _doubts(diagnostics, _unusual_lines(lab))
    return Analysis(
        **asdict(log)
        | {
            "torques": tables.torque_table(measured, fit, groups, without_torque),
            "diagnostics": diagnostics,
        },
        if_balanced=_if_balanced(log, [answer for _, answer in sensitivity]),
        doubts=doubts,
        fits=tables.named_fits(measured, fit, _kept_runs(fit)),
        sensitivity=tuple([answer for _, answer in sensitivity]),
        power_law=tables.power_laws(measured, groups),
        exponent=exponent,
        ball=_ball(log),
        advice=_advice(lab, doubts),
    )


def check_fit(log: FittedLog) -> FittedLog:
    """Add to a fit the findings that need no other fit: those that a grade shows."""
    assumed = changes.assumed_effects(log.lab)
    effects = changes.list_effects(log.lab, assumed) if assumed else ()
    log = replace(log, effects=effects)
    found = _findings(log, findings.OF_FIT, None)
    return replace(log, diagnostics=(*log.diagnostics, *found))


def _findings(
    log: FittedLog, every: Sequence[findings.Check], exponent: tables.Exponent | None
) -> list[Diagnostic]:
    """List what some checks find in a fit."""
    seen = findings.Seen(
        **asdict(log.lab),
        outliers=log.outliers,
        without=log.without_outliers,
        p=log.p,
        constancy=log.constancy,
        patterns=log.patterns,
        exponent=exponent,
        ball=_ball(log),
        sizes=log.unusual_sizes,
    )
    return [diagnostic for check in every for diagnostic in check(seen)]


def _kept_runs(fit: fitting.FitResult) -> list[int]:
    return np.flatnonzero(fit.adjusted.kept).tolist()


def _kept_groups(measured: Measurements, fit: fitting.FitResult) -> list[list[int]]:
    """List the runs of each torque that are in the fit."""
    kept = set(_kept_runs(fit))
    return [sorted(kept.intersection(group)) for group in measured.by_torque]


def _ball(log: FittedLog) -> tables.Ball | None:
    """Compare I_zz with the ball or disk in the log, if there is one."""
    return tables.compare_with_ball(
        log.fit.inertia, log.readings.constants, log.readings.uncertainties
    )


def _if_balanced(
    log: FittedLog, answers: Sequence[changes.Sensitivity]
) -> Estimate | None:
    """Return I_zz of a balanced ball, for a log with a single torque."""
    if fitting.torques_differ(log.measurements.torque[_kept_runs(log.fit)]):
        return None
    for answer in answers:
        if answer.name == "balanced":
            return answer.inertia
    return log.fit.inertia if log.measurements.balanced else None


def _unusual_lines(lab: Lab) -> list[int]:
    """List the lines of runs that may have unusual values.

    A turn without a weight can take an hour.
    """
    measured = lab.measured
    runs = (*lab.left_out, *np.flatnonzero(measured.torque == 0))
    return [measured.lines[run] for run in runs]


def _doubts(
    diagnostics: Sequence[Diagnostic], unusual_lines: Sequence[int]
) -> tuple[Doubt, ...]:
    """List the doubts in the order of `DOUBTS`, without sizes in unusual lines."""
    doubts: list[Doubt] = []
    for kind in DOUBTS:
        reasons = [
            diagnostic
            for diagnostic in diagnostics
            if diagnostic.doubt == kind
            and not (kind == "size" and diagnostic.line in unusual_lines)
        ]
        doubts += [Doubt(kind, reason.message, reason.hint) for reason in reasons]
    return tuple(doubts)


def _advice(lab: Lab, doubts: Sequence[Doubt]) -> tuple[str, ...]:
    """List what would improve the next measurement, or first the causes of doubts.

    Advice for another measurement is only valid for runs without doubts.
    """
    if doubts:
        return tuple(f"find the cause first: {doubt.remedy}" for doubt in doubts)
    return tuple(_worthwhile_changes(lab))


def _worthwhile_changes(lab: Lab) -> list[str]:
    """List the measurements that would make u of I_zz much smaller, best first."""
    now = 100 * fitting.relative_u(lab.fit.inertia)
    gains = []
    for _, answer in changes.answers(lab, "advice"):
        then = 100 * fitting.relative_u(answer.inertia) if answer.inertia else math.inf
        if then < findings.WORTH * now or answer.name == changes.DOUBTED:
            text = f"{answer.words}: u of I_zz from {now:.2g} % to {then:.2g} %"
            gains.append((then, answer.words, text))
    return [text for *_, text in sorted(gains)]


ABSURD = 1000.0
"""A Birge ratio above this means that the stated uncertainties are wrong."""

EXACT, TOO_WIDE = 1e-6, 0.7
"""Smallest credible relative uncertainty of I_zz [1], and the largest one of an answer.
"""

HOPELESS = 1e-6
"""If the probability of chi-square is below this, wrong turn counts that explain all
torques are reported as errors."""


def check_log(readings: Readings) -> tuple[Analysis | None, tuple[Diagnostic, ...]]:
    """Analyse a log and list what is missing.

    Return the analysis, or None if the log has no answer, and all diagnostics.
    """
    try:
        analysis = analyze_readings(readings)
    except LogError as error:
        measured = measure(readings) if readings.ok else None
        lacking = (
            what_lacks(readings, measured, None)
            if measured is not None and measured.torque.any()
            else []
        )
        return None, (*error.diagnostics, *lacking)
    return analysis, (
        *analysis.diagnostics,
        *what_lacks(readings, analysis.measurements, analysis.lab),
    )


def fit_runs(
    readings: Readings,
    measured: Measurements,
    model: Model = AUTO,
    keep_flagged: bool = False,
) -> tuple[Lab, tuple[Outlier, ...], Estimate | None]:
    """Choose the model, find the outliers, and fit the other runs.

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
        The log with its recommended fit; the suspected outliers; and I_zz without all
        of them [kg*m^2], if some of them are in the fit.

    Raises
    ------
    LogError
        If the runs do not determine a credible I_zz; it names what to check.
    """
    # The errors that several runs have in common, if there may be too many; runs
    # without an error are in group -1.
    count = len(measured.runs)
    counted = measured.sources if count**2 * len(measured.sources) > LARGEST else ()
    shared = sum(
        [int((np.bincount(source.groups + 1)[1:] > 1).sum()) for source in counted]
    )
    if shared * count > LARGEST:
        raise LogError(
            [readings.say("too_many_shared_readings", runs=count, shared=shared)]
        )
    timed = fitting.timed_runs(measured)
    if models.known(model, timed).sags:
        fallen = refusals.fall_findings(readings, measured)
        if fallen:
            raise LogError(fallen)
    try:
        runs, (choice, whole) = measured, changes.choose_model(measured, model)
        chosen = choice.motion
        fit, effects = (whole.fit, whole.effects) if whole else (None, ())
        outliers, screened = fitting.screen(runs, chosen.tilted, fit and fit.as_stated)
        if chosen.is_corrected(timed):
            odd = tuple([outlier.index for outlier in outliers])
            runs, _ = fitting.fit_model(measured, chosen, odd, fitting.AS_STATED)
            outliers, screened = fitting.screen(runs, chosen.tilted)
        odd = tuple([outlier.index for outlier in outliers])
        # Only a run with a wrong turn count is left out; another outlier is still a
        # measurement.
        left_out = (
            ()
            if keep_flagged
            else tuple([outlier.index for outlier in outliers if outlier.slip])
        )
        if fit is None or left_out:
            fit, effects = (
                fitting.fit(runs, tilted=chosen.tilted, left_out=left_out),
                (),
            )
        without = (
            fitting.fit(runs, tilted=chosen.tilted, left_out=odd).inertia
            if odd != left_out
            else None
        )
        if not np.isfinite(fit.fitted_time).all():
            raise LogError([readings.say("no_steady_precession")])
        birge = math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else 0.0
        if birge > ABSURD:
            raise NoFit(
                f"they scatter {birge:.2g} times as much as the stated uncertainties allow"
            )
        says = np.ones(len(measured.runs))
        says[list(odd)] = 0.0
        fitting.insist_on_lines(runs, fit, chosen.tilted, says)
        if fit.dof <= 0 and fitting.relative_u((fit.as_stated or fit).inertia) < EXACT:
            # Without degrees of freedom, the runs cannot contradict the stated
            # uncertainties.
            raise NoFit(
                "all uncertainties are stated as zero, and the runs are too few to "
                "show how well they agree"
            )
        low, high = fit.inertia.interval_95 or (fit.inertia.value, fit.inertia.value)
        if low <= 0 or (fit.inertia.u or 0.0) > TOO_WIDE * fit.inertia.value:
            raise LogError([refusals.not_measured(readings, fit, low, high)])
    except NoFit as reason:
        miscounted = refusals.count_findings(readings, measured)
        raise LogError(
            miscounted
            or [refusals.refusal(readings, measured, str(reason), keep_flagged)]
        ) from None
    if fit.dof > 0 and fitting.chi2_tail(fit.chi2, fit.dof) < HOPELESS:
        miscounted = refusals.count_findings(readings, runs, fit, left_out)
        if miscounted:
            raise LogError(miscounted)
    lab = Lab(readings, runs, fit, chosen, left_out, effects, model != AUTO, choice)
    return (
        lab,
        wrong_cells.explain(readings, lab, outliers, screened or fit)
        if outliers
        else (),
        without,
    )


def _result(estimate: Estimate) -> Result:
    """Describe a value and its interval by the terms of the GUM."""
    value, u, interval = estimate.value, estimate.u, estimate.interval_95
    assert u is not None
    assert interval is not None
    half = (interval[1] - interval[0]) / 2
    relative, k = abs(u / value) if value else None, half / u if u else None
    return Result(
        value, u, estimate.unit, interval, k=k, expanded_u=half, relative_u=relative
    )
