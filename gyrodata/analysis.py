"""The story on one page: read a log, measure its runs, fit them, and judge the fit.

`fit_log` makes the fit, and `judge` adds what a report shows. `analyze` does both; the
room `reporting` shows its result. A grade needs less than `judge`: `check_fit`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, TextIO, TypeAlias

import numpy as np
from msgspec.structs import asdict, replace

from gyrodata import fitting
from gyrodata.base.diagnostics import message as diagnostic_of
from gyrodata.base.errors import Diagnostic, LogError, insist_on_choice, insist_on_type
from gyrodata.fitting import Estimate
from gyrodata.judging import changes, findings, tables
from gyrodata.judging.blocks import compare_blocks, list_blocks
from gyrodata.judging.changes import Lab
from gyrodata.judging.procedure import what_lacks
from gyrodata.judging.recommended import recommend
from gyrodata.measurements import Measurements, checks, measure
from gyrodata.physics import models
from gyrodata.physics.models import AUTO, ModelName
from gyrodata.readings import Readings, read_log, value_text, without_wrong_runs
from gyrodata.readings.together import in_own_file, read_together
from gyrodata.results import DOUBTS, Analysis, Doubt, FittedLog, Options, Result

if TYPE_CHECKING:
    import os

    import pandas as pd


Log: TypeAlias = "str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame"


def analyze(
    log: Log | Sequence[Log],
    *,
    name: str | None = None,
    settings: Mapping[str, Any] | None = None,
    mapping: Mapping[str, str] | None = None,
    config: str | os.PathLike[str] | None = None,
    model: ModelName = AUTO,
    keep_flagged: bool = False,
    together: bool = False,
) -> Analysis:
    """Compute I_zz with its uncertainty from a log, and all that the report shows.

    Parameters
    ----------
    log : path, bytes, str, file or DataFrame
        The same as for ``gyro analyze``; bytes, and a str of several lines, are the
        text of a log. With `together`, a list of logs.
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
    model : str
        "horizontal" (eq. (9)), "steady" (eq. (8)), "released" (a rod that is released
        from rest), or another name of ``--model``; "auto" is the simplest that is
        accurate enough for the log. If the log does not say how the rod was started,
        "auto" can also assume half the effect of a release: the model is then named
        "released", too.
    keep_flagged : bool
        Keep all outliers in the fit. By default those are left out that are certainly
        wrong; the other outliers are only named.
    together : bool
        Fit one I_zz to several logs of one gyroscope, of several days or groups.

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
    settings = settings or {}
    mapping = mapping or {}
    insist_on_type("together", together, bool, "True or False")
    logs: Any = [log]
    if together:
        insist_on_type("log", log, list | tuple, "a list of logs with together=True")
        if not log:
            raise ValueError("log is an empty list; pass one log or more")
        logs = log
    read = [
        read_log(each, name=name, settings=settings, mapping=mapping, config=config)
        for each in logs
    ]
    readings = read_together(read)
    options = Options(
        set={key: value_text(settings[key]) for key in sorted(settings)},
        map={key: mapping[key] for key in sorted(mapping)},
        config=None if config is None else Path(config).name,
        model=model,
        keep_flagged=keep_flagged,
    )
    return analyze_readings(readings, options)


def analyze_readings(readings: Readings, options: Options | None = None) -> Analysis:
    """Fit a log, and judge the fit; see `analyze`."""
    if not readings.files:
        return judge(fit_log(readings, options or Options()))
    try:
        analysis = judge(fit_log(readings, options or Options()))
    except LogError as error:
        raise LogError(_in_own_files(error.diagnostics, readings)) from None
    return replace(
        analysis,
        diagnostics=_in_own_files(analysis.diagnostics, readings),
        run_table=tuple(_in_own_log(run, readings) for run in analysis.run_table),
    )


def _in_own_log(run: tables.Run, readings: Readings) -> tables.Run:
    """Return a run with its line in the one of several logs that contains it."""
    start, _ = readings.files[readings.file_of(run.line)]
    return replace(run, line=run.line - start)


def _in_own_files(
    diagnostics: Sequence[Diagnostic], readings: Readings
) -> tuple[Diagnostic, ...]:
    """Return diagnostics with their places in the logs that were joined."""
    return tuple(in_own_file(diagnostic, readings) for diagnostic in diagnostics)


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
        The fit. Its diagnostics are those of the readings, of the measurements, and of
        readings of an unusual size.

    Raises
    ------
    LogError
        If the log contains errors, or if its runs do not determine a credible I_zz.
    """
    if not readings.ok:
        raise LogError(readings.diagnostics)
    measured = measure(readings)
    of_readings = tuple(checks.check(readings, measured))
    measured = replace(measured, diagnostics=(*measured.diagnostics, *of_readings))
    # Kept apart from the others: a finding about much scatter needs to know them.
    unusual_sizes = tuple(checks.check_sizes(readings))
    diagnostics = (*readings.diagnostics, *measured.diagnostics, *unusual_sizes)
    if not np.any(measured.torque):
        raise LogError([*diagnostics, readings.say("all_torques_zero")])
    model = options.model
    keep_flagged = options.keep_flagged
    try:
        recommended = recommend(readings, measured, model, keep_flagged)
    except LogError as error:
        reasons = error.diagnostics
        if unusual_sizes and reasons[0].code == diagnostic_of("not_measured").code:
            reasons = (replace(reasons[0], hint=FIRST_THE_SIZES), *reasons[1:])
        raise LogError([*diagnostics, *reasons]) from None
    lab = recommended.lab
    outliers = recommended.outliers
    # `recommend` chose the models of motion, corrected the runs by them, and left
    # certain outliers out.
    corrected = lab.measured
    fit = lab.fit
    groups = _kept_groups(corrected, fit)
    torques = tables.torque_table(corrected, fit, groups)
    return FittedLog(
        name=readings.name,
        sha256=readings.sha256,
        options=options,
        readings=readings,
        measurements=corrected,
        fit=fit,
        model=lab.motion,
        outliers=outliers,
        without_outliers=recommended.without_outliers,
        explanations=recommended.explanations,
        inertia=_result(fit.inertia),
        residual_torque=_result(fit.residual_torque),
        timing_bias=_result(fit.timing_bias),
        p=fitting.chi2_tail(fit.chi2, fit.dof) if fit.dof > 0 else None,
        birge=math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else None,
        budget=fit.budget,
        constancy=tables.constancy(corrected, torques, groups),
        torques=torques,
        run_table=tables.run_table(corrected, fit, outliers, lab.left_out),
        unusual_sizes=unusual_sizes,
        blocks=list_blocks(lab),
        blocks_agreement=compare_blocks(lab),
        diagnostics=diagnostics,
    )


FIRST_THE_SIZES = "first correct the readings that the warnings ask about"
"""What to do if the interval is useless because readings have an unusual size."""


def judge(fitted: FittedLog) -> Analysis:
    """Judge a fit: list effects, other fits, findings, doubts and advice."""
    fitted = replace(fitted, effects=changes.list_effects(fitted.lab))
    lab = fitted.lab
    measured = fitted.measurements
    fit = fitted.fit
    groups = _kept_groups(measured, fit)
    without_torque: dict[int, Estimate] = {}
    sensitivity = []
    for change, answer in changes.answers(lab, "sensitivity"):
        sensitivity.append(answer)
        if change.torque_number is not None and answer.inertia:
            without_torque[change.torque_number] = answer.inertia
    exponent = tables.common_exponent(measured, groups)
    diagnostics = (*fitted.diagnostics, *_run_checks(fitted, findings.CHECKS, exponent))
    doubts = _doubts(diagnostics, _excused_lines(lab))
    torques = tuple(
        [
            replace(torque, without=without_torque.get(number))
            for number, torque in enumerate(fitted.torques)
        ]
    )
    fitted = replace(fitted, torques=torques, diagnostics=diagnostics)
    # `asdict` of msgspec copies the fields, and does not change records in them.
    return Analysis(
        **asdict(fitted),
        if_balanced=_if_balanced(fitted, sensitivity),
        doubts=doubts,
        fits=tables.named_fits(measured, fit, _kept_runs(fit)),
        sensitivity=tuple(sensitivity),
        power_law=tables.power_laws(measured, groups),
        exponent=exponent,
        ball=_ball(fitted),
        advice=_advice(lab, doubts),
    )


def check_fit(fitted: FittedLog) -> FittedLog:
    """Return a fit with the findings that a grade shows, and with the assumed effects.

    To save time, other fits are made only for the sizes of these effects, and for
    findings about a missing direction or much scatter.
    """
    assumed = changes.assumed_effects(fitted.lab)
    fitted = replace(fitted, effects=changes.list_effects(fitted.lab, assumed))
    of_fit = _run_checks(fitted, findings.OF_FIT, None)
    return replace(fitted, diagnostics=(*fitted.diagnostics, *of_fit))


def _run_checks(
    fitted: FittedLog,
    selected: Sequence[findings.Check],
    exponent: tables.Exponent | None,
) -> list[Diagnostic]:
    """List what some checks of `gyrodata.judging.findings` find in a fit."""
    # A `JudgedLab` is a `Lab` with more fields.
    judged = findings.JudgedLab(
        **asdict(fitted.lab),
        outliers=fitted.outliers,
        without_outliers=fitted.without_outliers,
        explanations=fitted.explanations,
        constancy=fitted.constancy,
        blocks=fitted.blocks,
        agreement=fitted.blocks_agreement,
        exponent=exponent,
        ball=_ball(fitted),
        unusual_sizes=fitted.unusual_sizes,
    )
    return findings.run_checks(judged, selected)


def _kept_runs(fit: fitting.FitResult) -> list[int]:
    return np.flatnonzero(fit.adjusted.kept).tolist()


def _kept_groups(measured: Measurements, fit: fitting.FitResult) -> list[list[int]]:
    """List the runs of each torque that are in the fit."""
    kept = set(_kept_runs(fit))
    return [sorted(kept.intersection(group)) for group in measured.by_torque]


def _ball(fitted: FittedLog) -> tables.Ball | None:
    """Compare I_zz with the ball or disk in the log, if there is one."""
    return tables.compare_with_ball(
        fitted.fit.inertia, fitted.readings.constants, fitted.readings.uncertainties
    )


def _if_balanced(
    fitted: FittedLog, answers: Sequence[changes.Sensitivity]
) -> Estimate | None:
    """Return I_zz of a balanced ball, for a log with a single torque.

    With one torque, I_zz and M0 cannot be told apart: this is the answer for M0 = 0.
    """
    if fitting.torques_differ(fitted.measurements.torque[_kept_runs(fitted.fit)]):
        return None
    for answer in answers:
        if answer.name == "balanced":
            return answer.inertia
    # With the line "# balanced: yes", the recommended fit has M0 = 0 already, and
    # `changes` does not ask what I_zz would be with it.
    return fitted.fit.inertia if fitted.measurements.balanced else None


def _excused_lines(lab: Lab) -> list[int]:
    """List the lines of runs whose unusual values are no reason to doubt the answer.

    They are runs that are left out, and those without a weight: a turn without a weight
    can take an hour.
    """
    measured = lab.measured
    without_weight = np.flatnonzero(measured.torque == 0)
    return [measured.lines[run] for run in (*lab.left_out, *without_weight)]


def _doubts(
    diagnostics: Sequence[Diagnostic], excused_lines: Sequence[int]
) -> tuple[Doubt, ...]:
    """List the doubts in the order of `DOUBTS`, without sizes in excused lines."""
    doubts: list[Doubt] = []
    for kind in DOUBTS:
        reasons = [
            diagnostic
            for diagnostic in diagnostics
            if diagnostic.doubt == kind
            and not (kind == "size" and diagnostic.line in excused_lines)
        ]
        doubts += [Doubt(kind, reason.message, reason.hint) for reason in reasons]
    return tuple(doubts)


def _advice(lab: Lab, doubts: Sequence[Doubt]) -> tuple[str, ...]:
    """List what would improve the next measurement, or first the causes of doubts.

    Advice for another measurement is only valid for runs without doubts.
    """
    if doubts:
        return tuple([f"find the cause first: {doubt.remedy}" for doubt in doubts])
    return tuple(_worthwhile_changes(lab))


def _worthwhile_changes(lab: Lab) -> list[str]:
    """List the measurements that would make u of I_zz much smaller, best first."""
    gains = sorted(changes.gains(lab, "advice"), key=itemgetter(2, 0))
    return [
        f"{words}: u of I_zz from {now:.2g} % to {then:.2g} %"
        for words, now, then in gains
    ]


def check_log(
    readings: Readings, options: Options | None = None
) -> tuple[Analysis | None, tuple[Diagnostic, ...]]:
    """Analyse a log and list what is missing.

    Return the analysis, or None if the log has no answer, and all diagnostics. If the
    log contains an error (`Readings.ok` is false), the runs of other lines are checked
    without it.
    """
    if not readings.ok:
        return None, (*readings.diagnostics, *_findings_of_other_runs(readings))
    try:
        analysis = analyze_readings(readings, options)
    except LogError as error:
        measured = measure(readings)
        has_torque = measured.torque.any()
        lacking = what_lacks(readings, measured, None) if has_torque else []
        return None, (*error.diagnostics, *_in_own_files(lacking, readings))
    lacking = what_lacks(analysis.readings, analysis.measurements, analysis.lab)
    return analysis, (*analysis.diagnostics, *_in_own_files(lacking, readings))


def _findings_of_other_runs(readings: Readings) -> list[Diagnostic]:
    """Check the runs of a log without those whose cells cannot be read.

    Return the findings about single cells; those about the whole log have to wait.
    """
    rest = without_wrong_runs(readings)
    if rest is None:
        return []
    try:
        findings_of_rest = analyze_readings(rest).diagnostics
    except LogError as error:
        findings_of_rest = error.diagnostics
    return [
        finding
        for finding in findings_of_rest
        if finding.line in rest.lines and finding.severity != "note"
    ]


def _result(estimate: Estimate) -> Result:
    """Describe a value and its interval by the terms of the GUM."""
    value = estimate.value
    u = estimate.u
    interval = estimate.interval_95
    assert u is not None
    assert interval is not None
    half = (interval[1] - interval[0]) / 2
    return Result(
        value,
        u,
        estimate.unit,
        interval,
        k=half / u if u else None,
        expanded_u=half,
        relative_u=abs(u / value) if value else None,
    )
