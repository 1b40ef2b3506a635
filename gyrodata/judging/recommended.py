"""The recommended fit of a log: choose the models, find the outliers, fit the rest.

A log whose fit is not credible has no recommended fit; `refusals` says what to check.
"""

from __future__ import annotations

import math

import numpy as np
from msgspec import Struct

from gyrodata import fitting
from gyrodata.base.errors import LogError
from gyrodata.fitting import Estimate, FitResult, NoFit, Outlier
from gyrodata.judging import changes, refusals, wrong_cells
from gyrodata.judging.changes import Choice, Effect, Lab
from gyrodata.measurements import Measurements
from gyrodata.physics import models
from gyrodata.physics.models import AUTO, Model
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

HOPELESS = 1e-6
"""If the probability of chi-square is below this, wrong turn counts that explain all
torques are reported as errors."""


class Recommended(Struct, frozen=True):
    """The recommended fit of a log."""

    lab: Lab
    outliers: tuple[Outlier, ...]
    """Suspected outliers, also those that are in the fit."""
    without_outliers: Estimate | None
    """I_zz without all of them [kg*m^2]; None if none of them is in the fit."""


def recommend(
    readings: Readings,
    measured: Measurements,
    model: Model = AUTO,
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
        lab = screened.fit_kept(readings, model, keep_flagged)
        without = None
        if screened.suspected != lab.left_out:
            without = screened.fit_without(screened.suspected).inertia
        _insist_on_credible_fit(readings, lab, screened)
    except NoFit as reason:
        miscounted = refusals.count_findings(readings, measured)
        if miscounted:
            raise LogError(miscounted) from None
        refusal = refusals.refusal(readings, measured, str(reason), keep_flagged)
        raise LogError([refusal]) from None
    _refuse_wrong_counts(readings, lab)
    outliers = screened.outliers
    if outliers:
        others = screened.fit or lab.fit
        outliers = wrong_cells.explain(readings, lab, outliers, others)
    return Recommended(lab, outliers, without)


class _Screened(Struct, frozen=True):
    """The runs of a log, corrected for their motion, and their outliers."""

    runs: Measurements
    outliers: tuple[Outlier, ...]
    fit: FitResult | None
    """The fit by which the outliers were found; None if there are too few runs."""
    choice: Choice
    ready: Lab | None
    """The fit of all runs with these models, if the choice has made it already: that is
    only possible for models without a correction."""

    @property
    def suspected(self) -> tuple[int, ...]:
        """The outliers, by the numbers of their runs."""
        return tuple([outlier.index for outlier in self.outliers])

    @property
    def miscounted(self) -> tuple[int, ...]:
        """The outliers that a wrong number of turns explains."""
        return tuple([outlier.index for outlier in self.outliers if outlier.slip])

    def fit_without(self, left_out: tuple[int, ...]) -> FitResult:
        """Fit the other runs."""
        tilted = self.choice.motion.tilted
        return fitting.fit(self.runs, tilted=tilted, left_out=left_out)

    def fit_kept(self, readings: Readings, model: Model, keep_flagged: bool) -> Lab:
        """Fit the runs; a run with a wrong number of turns is left out.

        Another outlier is still a measurement.
        """
        left_out = () if keep_flagged else self.miscounted
        effects: tuple[Effect, ...] = ()
        if self.ready is None or left_out:
            fit = self.fit_without(left_out)
        else:
            fit = self.ready.fit
            effects = self.ready.effects
        return Lab(
            readings,
            self.runs,
            fit,
            self.choice.motion,
            left_out,
            effects,
            asked=model != AUTO,
            choice=self.choice,
        )


def _screen(measured: Measurements, model: Model) -> _Screened:
    """Choose the models, correct the runs for them, and find the outliers.

    The correction depends on I_zz, which an outlier can change: so outliers are found
    first without the correction, and then again with it.
    """
    choice, ready = changes.choose_model(measured, model)
    tilted = choice.motion.tilted
    as_stated = ready.fit.as_stated if ready else None
    outliers, fit = fitting.screen(measured, tilted, as_stated)
    screened = _Screened(measured, tuple(outliers), fit, choice, ready)
    if not choice.motion.is_corrected(fitting.timed_runs(measured)):
        return screened
    corrected, _ = fitting.fit_model(
        measured, choice.motion, screened.suspected, fitting.AS_STATED
    )
    outliers, fit = fitting.screen(corrected, tilted)
    return _Screened(corrected, tuple(outliers), fit, choice, ready)


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
    readings: Readings, measured: Measurements, model: Model
) -> None:
    """Refuse runs that are too slow for a rod that was released from rest."""
    if models.stated_or_asked(model, fitting.timed_runs(measured)).sags:
        fallen = refusals.fall_findings(readings, measured)
        if fallen:
            raise LogError(fallen)


def _insist_on_credible_fit(readings: Readings, lab: Lab, screened: _Screened) -> None:
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
    weights[list(screened.suspected)] = 0.0
    fitting.insist_on_lines(lab.measured, fit, lab.motion.tilted, weights)
    as_stated = fit.as_stated or fit
    if fit.dof <= 0 and fitting.relative_u(as_stated.inertia) < EXACT:
        # Without degrees of freedom, the runs cannot contradict the stated
        # uncertainties.
        raise NoFit(
            "all uncertainties are stated as zero, and the runs are too few to show how "
            "well they agree"
        )
    value, u = fit.inertia.value, fit.inertia.u or 0.0
    low, high = fit.inertia.interval_95 or (value, value)
    if low <= 0 or u > TOO_WIDE * value:
        raise LogError([refusals.not_measured(readings, fit, low, high)])


def _refuse_wrong_counts(readings: Readings, lab: Lab) -> None:
    """Refuse a log that is impossible with its turns, and probable with other turns."""
    fit = lab.fit
    if fit.dof <= 0 or fitting.chi2_tail(fit.chi2, fit.dof) >= HOPELESS:
        return
    miscounted = refusals.count_findings(readings, lab.measured, fit, lab.left_out)
    if miscounted:
        raise LogError(miscounted)
