"""The recommended fit of a log: choose the models, find the outliers, fit the rest.

A log whose fit is not credible has no recommended fit; `refusals` says what to check.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from msgspec import Struct

from gyrodata import fitting
from gyrodata.base.errors import LogError
from gyrodata.fitting import Estimate, FitResult, NoFit, Outlier
from gyrodata.judging import changes, explanations, refusals
from gyrodata.judging.changes import Lab
from gyrodata.judging.explanations import ONE_BALANCE, Diagnosis, Explanation
from gyrodata.measurements import Measurements
from gyrodata.physics import models
from gyrodata.physics.models import AUTO, ModelName, Motion
from gyrodata.readings import Readings

LARGEST = 3_000_000
"""Largest number of runs times shared readings in one fit, which is the size of its
matrix."""

ABSURD = 1000.0
"""A Birge ratio above this means that the stated uncertainties are wrong."""

EXACT = 1e-6
"""Smallest credible relative uncertainty of I_zz [1]."""

SPIN_JUMP = math.log(2)
UNLIKE_OTHERS = 5.0
"""A spin that changes during a run by more than this factor, and by so many times more
than in half of the runs, has a wrong digit."""

TOO_WIDE = 0.7
"""Largest relative uncertainty of I_zz that is an answer [1]."""


class Recommended(Struct, frozen=True):
    """The recommended fit of a log."""

    lab: Lab
    outliers: tuple[Outlier, ...]
    """Suspected outliers, also those that are in the fit."""
    without_outliers: Estimate | None
    """I_zz without all of them [kg*m^2]; None if none of them is in the fit."""
    explanations: tuple[Explanation, ...]
    """Mistakes with which the runs would agree."""


def recommend(
    readings: Readings,
    measured: Measurements,
    model: ModelName = AUTO,
    keep_flagged: bool = False,
) -> Recommended:
    """Choose the models, find the outliers, and fit the other runs.

    Parameters
    ----------
    readings : Readings
        The log.
    measured : Measurements
        Its n runs, at least one with a torque.
    model, keep_flagged
        As for `gyrodata.analyze`.

    Returns
    -------
    Recommended

    Raises
    ------
    LogError
        If the runs do not determine a credible I_zz; it names what to check.
    """
    _refuse_too_many_shared_readings(readings, measured)
    _refuse_rods_that_fall(readings, measured, model)
    try:
        motion = changes.choose_model(measured, model)
        tilted = motion.tilted
        runs, outliers = _screen(measured, motion)
        fit = None
        with suppress(NoFit):
            fit = fitting.fit(runs, tilted=tilted)
        diagnosis = Diagnosis()
        agrees = _agrees(fit, outliers)
        if not agrees:
            odd = _with_spin_jumps(runs, outliers)
            diagnosis = explanations.diagnose(readings, runs, tilted, fit, odd)
            if not outliers and not diagnosis.explanations:
                # A ball that slows down much in a long run is not odd.
                diagnosis = Diagnosis()
        _refuse_wrong_counts(readings, diagnosis.explanations)
        left_out = () if keep_flagged else diagnosis.left_out
        if left_out or fit is None:
            fit = fitting.fit(runs, tilted=tilted, left_out=left_out)
        lab = Lab(readings, runs, fit, motion, left_out, asked=model != AUTO)
        suspected = tuple([outlier.index for outlier in diagnosis.outliers])
        without = None
        if suspected and suspected != left_out:
            without = fitting.fit(runs, tilted=tilted, left_out=suspected).inertia
        _insist_on_credible_fit(readings, lab, suspected)
    except NoFit as reason:
        refusal = refusals.refusal(readings, measured, str(reason), keep_flagged)
        raise LogError([refusal]) from None
    return Recommended(lab, diagnosis.outliers, without, diagnosis.explanations)


def _agrees(fit: FitResult | None, outliers: Sequence[Outlier]) -> bool:
    """Return whether the runs, and the weights, agree with each other."""
    if fit is None or outliers:
        return False
    is_likely = fit.as_stated.p >= fitting.UNLIKELY
    return is_likely and fit.chance_of_one_balance > ONE_BALANCE


def _screen(
    measured: Measurements, motion: Motion
) -> tuple[Measurements, list[Outlier]]:
    """Correct the runs for their motion, and find the outliers.

    The correction depends on I_zz, which an outlier can change: so outliers are found
    first without the correction, and then again with it.
    """
    outliers = fitting.screen(measured, motion.tilted)
    if not motion.is_corrected(fitting.timed_runs(measured)):
        return measured, outliers
    odd = [outlier.index for outlier in outliers]
    corrected, _ = fitting.fit_model(measured, motion, odd, fitting.AS_STATED)
    return corrected, fitting.screen(corrected, motion.tilted)


def _with_spin_jumps(
    measured: Measurements, outliers: Sequence[Outlier]
) -> list[Outlier]:
    """Mark the runs in which one of two spins has a wrong digit, if its change is odd.

    Nobody knows the mean spin of such a run, so that hardly any time would be far from
    its prediction. Without other outliers, such runs are the first to suspect.
    """
    known = {outlier.index: outlier for outlier in outliers}
    if measured.spin_start is not None and measured.spin_end is not None:
        change = np.abs(np.log(measured.spin_start / measured.spin_end))
        limit = max(SPIN_JUMP, UNLIKE_OTHERS * float(np.median(change)))
        for run in np.flatnonzero(change > limit).tolist():
            if run in known or not outliers:
                known[run] = Outlier(run, math.inf, slip=True)
    return [outlier for _, outlier in sorted(known.items())]


def _refuse_too_many_shared_readings(
    readings: Readings, measured: Measurements
) -> None:
    """Refuse a log if the matrix of its fit would be too large.

    Runs without an error of a source are in its group -1.
    """
    count = len(measured.runs)
    shared = 0
    for source in measured.sources:
        runs_of_group = np.bincount(source.groups + 1)[1:]
        shared += int((runs_of_group > 1).sum())
    if shared * count > LARGEST:
        fault = readings.say("too_many_shared_readings", runs=count, shared=shared)
        raise LogError([fault])


def _refuse_rods_that_fall(
    readings: Readings, measured: Measurements, model: ModelName
) -> None:
    """Refuse runs that are too slow for a rod that was released from rest."""
    if models.stated_or_asked(model, fitting.timed_runs(measured)).sags:
        fallen = refusals.fall_findings(readings, measured)
        if fallen:
            raise LogError(fallen)


def _insist_on_credible_fit(
    readings: Readings, lab: Lab, suspected: tuple[int, ...]
) -> None:
    """Raise NoFit or LogError if a fit is not an answer."""
    fit = lab.fit
    if not np.isfinite(fit.fitted_time).all():
        raise LogError([readings.say("no_steady_precession")])
    birge = 0.0
    if fit.dof > 0:
        birge = math.sqrt(fit.chi2 / fit.dof)
    if birge > ABSURD:
        raise NoFit(
            f"they scatter {birge:.2g} times as much as the stated uncertainties allow"
        )
    fitting.insist_on_lines(lab.measured, fit, [*suspected, *lab.left_out])
    if fit.dof <= 0 and fitting.relative_u(fit.as_stated.inertia) < EXACT:
        # Without degrees of freedom, the runs cannot contradict the stated
        # uncertainties.
        raise NoFit(
            "all uncertainties are stated as zero, "
            "and the runs are too few to show how well they agree"
        )
    value = fit.inertia.value
    u = fit.inertia.u or 0.0
    low, high = fit.inertia.interval_95 or (value, value)
    if low <= 0 or u > TOO_WIDE * value:
        raise LogError([refusals.not_measured(readings, fit, low, high)])


def _refuse_wrong_counts(readings: Readings, explained: Sequence[Explanation]) -> None:
    """Refuse a log whose weights agree only with other turns."""
    if {each.kind for each in explained} == {"turns"}:
        column = readings.columns.get("turns") or readings.columns.get("angle")
        first = readings.runs.index(explained[0].runs[0])
        cell = column.cell(first) if column else None
        counts = "; or else ".join([each.words for each in explained])
        raise LogError([readings.say("turns_of_weights_wrong", cell, counts=counts)])
