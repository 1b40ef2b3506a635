"""The recommended fit of a log: choose the models, find the outliers, fit the rest.

A log whose fit is not credible has no recommended fit; `refusals` says what to check.
"""

from __future__ import annotations

import math
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

TOO_WIDE = 0.7
"""Largest relative uncertainty of I_zz that is an answer [1]."""

UNLIKELY = 1e-3
"""If chi-square is less probable than this, the runs do not agree."""


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
        screened = _screen(measured, model)
        diagnosis = screened.diagnose(readings)
        _refuse_wrong_counts(readings, measured, diagnosis)
        left_out = () if keep_flagged else diagnosis.left_out
        lab = screened.fit_kept(readings, model, left_out)
        suspected = tuple([outlier.index for outlier in diagnosis.outliers])
        without = None
        if suspected and suspected != lab.left_out:
            without = screened.fit_without(suspected).inertia
        _insist_on_credible_fit(readings, lab, suspected)
    except NoFit as reason:
        miscounted = refusals.count_findings(readings, measured)
        if miscounted:
            raise LogError(miscounted) from None
        refusal = refusals.refusal(readings, measured, str(reason), keep_flagged)
        raise LogError([refusal]) from None
    return Recommended(lab, diagnosis.outliers, without, diagnosis.explanations)


class _Screened(Struct, frozen=True):
    """The runs of a log, corrected for their motion, and their outliers."""

    runs: Measurements
    outliers: tuple[Outlier, ...]
    fit: FitResult | None
    """The fit by which the outliers were found; None if there are too few runs."""
    motion: Motion
    ready: Lab | None
    """The fit of all runs with these models, if the choice has made it already: that is
    only possible for models without a correction."""

    def fit_without(self, left_out: tuple[int, ...]) -> FitResult:
        """Fit the other runs."""
        tilted = self.motion.tilted
        return fitting.fit(self.runs, tilted=tilted, left_out=left_out)

    def diagnose(self, readings: Readings) -> Diagnosis:
        """Find what explains that the runs do not agree; nothing if they agree."""
        base = None if self.ready is None else self.ready.fit
        if base is None:
            with suppress(NoFit):
                base = self.fit_without(())
        if not self.outliers and base is not None and _agrees(base):
            return Diagnosis()
        tilted = self.motion.tilted
        return explanations.diagnose(readings, self.runs, tilted, base, self.outliers)

    def fit_kept(
        self, readings: Readings, model: ModelName, left_out: tuple[int, ...]
    ) -> Lab:
        """Fit the runs that are not certainly wrong."""
        ready = self.ready if not left_out else None
        fit = self.fit_without(left_out) if ready is None else ready.fit
        return Lab(
            readings,
            self.runs,
            fit,
            self.motion,
            left_out,
            asked=model != AUTO,
        )


def _agrees(fit: FitResult) -> bool:
    """Return whether the runs, and the weights, agree with each other."""
    as_stated = fit.as_stated or fit
    if fitting.chi2_tail(as_stated.chi2, max(as_stated.dof, 1)) < UNLIKELY:
        return False
    return fit.chance_of_one_balance > ONE_BALANCE


def _screen(measured: Measurements, model: ModelName) -> _Screened:
    """Choose the models, correct the runs for them, and find the outliers.

    The correction depends on I_zz, which an outlier can change: so outliers are found
    first without the correction, and then again with it.
    """
    motion, ready = changes.choose_model(measured, model)
    tilted = motion.tilted
    as_stated = ready.fit.as_stated if ready else None
    outliers, fit = fitting.screen(measured, tilted, as_stated)
    screened = _Screened(measured, tuple(outliers), fit, motion, ready)
    if not motion.is_corrected(fitting.timed_runs(measured)):
        return screened
    corrected, _ = fitting.fit_model(
        measured,
        motion,
        [outlier.index for outlier in outliers],
        fitting.AS_STATED,
    )
    outliers, fit = fitting.screen(corrected, tilted)
    return _Screened(corrected, tuple(outliers), fit, motion, ready)


def _refuse_too_many_shared_readings(
    readings: Readings, measured: Measurements
) -> None:
    """Refuse a log if the matrix of its fit would be too large.

    Most logs are too short for it, whatever they share. Runs without an error of a source
    are in its group -1.
    """
    count = len(measured.runs)
    if count**2 * len(measured.sources) <= LARGEST:
        return
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
    birge = math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else 0.0
    if birge > ABSURD:
        raise NoFit(
            f"they scatter {birge:.2g} times as much as the stated uncertainties allow"
        )
    weights = np.ones(len(lab.measured.runs))
    weights[list({*suspected, *lab.left_out})] = 0.0
    fitting.insist_on_lines(lab.measured, fit, lab.motion.tilted, weights)
    as_stated = fit.as_stated or fit
    if fit.dof <= 0 and fitting.relative_u(as_stated.inertia) < EXACT:
        # Without degrees of freedom, the runs cannot contradict the stated
        # uncertainties.
        raise NoFit(
            "all uncertainties are stated as zero, and the runs are too few to show how "
            "well they agree"
        )
    value = fit.inertia.value
    u = fit.inertia.u or 0.0
    low, high = fit.inertia.interval_95 or (value, value)
    if low <= 0 or u > TOO_WIDE * value:
        raise LogError([refusals.not_measured(readings, fit, low, high)])


def _refuse_wrong_counts(
    readings: Readings, measured: Measurements, diagnosis: Diagnosis
) -> None:
    """Refuse a log whose weights agree only with other turns."""
    if {each.kind for each in diagnosis.explanations} == {"turns"}:
        raise LogError(refusals.count_findings(readings, measured))
