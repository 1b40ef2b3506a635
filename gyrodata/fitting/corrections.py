"""What the equation of a log's model has to be corrected by.

The models are eq. (9) for a level rod, eq. (8) for a tilted one, and the mean rate of the whole motion for a rod let go
from rest; `effects` tells which of them a log needs. A rod let go from rest nutates, and goes a little slower on
average; a tilted one whose spin falls has a mean rate that is not the one at the mean spin; the floor turns with the
Earth. The fit multiplies the angle of each run by `Measurements.slowing`. All of it depends on I_zz and M0 a little, so
that fit and correction are iterated together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from itertools import pairwise
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import physics
from gyrodata.fitting.adjustment import NoFit
from gyrodata.fitting.conditions import transverse_inertia
from gyrodata.fitting.inertia import FitResult, fit_as_stated, refit
from gyrodata.fitting.lines import insist_on_lines
from gyrodata.measurements import SOURCES, TRANSVERSE_U, Measurements, Source
from gyrodata.physics import Floats

Model = Literal["auto", "horizontal", "steady", "released"]


class ChosenModel(Struct, frozen=True):
    """The model that a log is fitted with."""

    tilted: bool
    """Eq. (8) with each run's pitch, not eq. (9)."""
    released: bool
    """The mean rate of a rod let go from rest, not that of steady precession."""
    asked: bool
    """True if the caller chose it."""
    earth: bool = False
    """The precession against the stars, not against the turning floor."""

    @property
    def name(self) -> Literal["horizontal", "steady", "released"]:
        """Name of the model, as ``--model`` takes it."""
        if self.released:
            return "released"
        return "steady" if self.tilted else "horizontal"


OF_RELEASE = ("nutation", "release")
"""Sources of error that only a rod let go from rest has."""

LIKELY = 10.0
"""A phase of the nutation whose chi-square is larger than the best one's by more than this is not looked into."""


def unslowed(measured: Measurements) -> Measurements:
    """Give the runs as they were read, taken for steady precession at their mean spin."""
    kept = tuple(source for source in measured.sources if source.name not in OF_RELEASE)
    return replace(measured, slowing=None, sources=kept)


def slowed(
    measured: Measurements, fit: FitResult, inertia: float, tilted: bool, released: bool, followed: bool = False
) -> Measurements:
    """Work out how much slower each run is than steady precession at its mean spin, for an I_zz [kg*m^2].

    A rod let go from rest gets its mean rate, and two more sources of error: the phase of the nutation at the last
    click, and I. With `followed` it is followed exactly from the start of the clock to the last click. Where the phase
    has a standard uncertainty σ, the most likely delay is e^(−σ²/2) of the computed one, and what is left of it is
    spread as (1 − e^(−σ²))/(2 ω_n²).
    """
    across = transverse_inertia(measured)
    total = measured.torque + fit.imbalance.value
    lean = (across, measured.pitch) if tilted else (0.0, 0.0)
    # The weight spins along.
    whole = inertia + measured.added
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = physics.precession_rate(total, measured.spin, whole, *lean)
        if not released:
            return replace(measured, slowing=steady / _mean_rate_of_decay(measured, total, whole, across))
    from gyrodata import motion

    top = motion.Top(whole, across, total)
    state = motion.released(top, measured.spin, measured.pitch)
    mean = motion.mean_precession_rate(top, state)
    ratio = steady / mean
    known = np.zeros(len(total))
    if followed:
        known = phase_known(measured, whole)
        angle = np.sign(mean) * 2 * np.pi * measured.turns
        # What the rod has swept by the time that was read, not the time that the count would take: the phase is
        # then free of the torque.
        time = measured.time - fit.timing_bias.value
        ahead = motion.precession_angle(top, state, time) - mean * time
        ratio = ratio - known * ahead * steady / (mean * angle)
    click = physics.click_error(measured.spin, whole, across)
    own, every = np.arange(len(total)), np.zeros(len(total), dtype=int)
    nothing = np.zeros(len(total))
    spread = click * np.sqrt((1 - known**2) / 2)
    # The delay of the mean goes with the square of I.
    doubt = 2 * _transverse_u(measured) * np.abs(steady / mean - 1)
    more = (
        Source("nutation", "time", own, spread, nothing, "", True, "its phase at the last click"),
        Source("release", "turns", every, nothing, doubt, "all runs", True, "the doubt about I in the mean rate"),
    )
    return replace(measured, slowing=ratio, sources=(*measured.sources, *more))


def phase_known(measured: Measurements, inertia: Floats | float) -> Floats:
    """How well the phase of the nutation at the last click is known, 0 to 1: e^(−σ²/2) of its uncertainty σ [rad]."""
    click = physics.click_error(measured.spin, inertia, transverse_inertia(measured))
    own = sum((s.relative**2 for s in measured.sources if s.quantity == "spin"), start=np.zeros(len(measured.runs)))
    known: Floats = np.exp(-0.5 * (measured.time / click) ** 2 * (_transverse_u(measured) ** 2 + own))
    return known


def _transverse_u(measured: Measurements) -> float:
    """Relative standard uncertainty of I [1]."""
    stated = (float(source.relative.max()) for source in measured.sources if source.quantity == "transverse")
    # A log that says neither pitch nor "released" has no such source, though it may give I.
    given = measured.transverse_inertia is not None
    return next(stated, SOURCES["transverse_inertia"].default.relative if given else TRANSVERSE_U)


def _mean_rate_of_decay(measured: Measurements, total: Floats, inertia: Floats | float, across: Floats) -> Floats:
    """Mean of eq. (8)'s rate over a viscous fall of the spin [rad/s], by Gauss-Legendre in time."""
    assert measured.spin_start is not None
    assert measured.spin_end is not None
    points, weights = np.polynomial.legendre.leggauss(8)
    decay = np.log(measured.spin_end / measured.spin_start)
    spins = measured.spin_start * np.exp(0.5 * (points[:, None] + 1) * decay)
    # What is read at half time too has another harmonic mean than a viscous fall.
    spins *= measured.spin / physics.harmonic_mean_spin(measured.spin_start, measured.spin_end)
    rates = physics.precession_rate(total, spins, inertia, across, measured.pitch)
    return np.asarray(0.5 * weights @ rates)


def is_unsteady(measured: Measurements, chosen: ChosenModel) -> bool:
    """Say whether a model's rate is not that of steady precession at one spin."""
    return chosen.released or (chosen.tilted and measured.spin_start is not None)


def corrected(
    measured: Measurements, fit: FitResult, inertia: float, chosen: ChosenModel, followed: bool = False
) -> Measurements:
    """Give the runs with what a model corrects them by, for an I_zz [kg*m^2] and the M0 and b of a fit."""
    runs = measured
    if is_unsteady(measured, chosen):
        runs = slowed(measured, fit, inertia, chosen.tilted, chosen.released, followed)
    return on_turning_floor(runs, fit) if chosen.earth else runs


def at_mean_rate(
    measured: Measurements, chosen: ChosenModel, left_out: Collection[int] = ()
) -> tuple[Measurements, FitResult]:
    """Correct runs by what the fit of them gives, until both go together; give that fit as well."""
    result = fit_as_stated(measured, chosen.tilted, left_out)
    runs = measured
    for _turn in range(20):
        before, runs = runs.slowing, corrected(measured, result, result.inertia.value, chosen)
        result = fit_as_stated(runs, chosen.tilted, left_out)
        if before is not None and runs.slowing is not None and np.allclose(before, runs.slowing, rtol=1e-10, atol=0):
            break
    return runs, result


def on_turning_floor(measured: Measurements, fit: FitResult) -> Measurements:
    """Count each run's angle against the stars, for the floor turns while it is timed."""
    steady = 1.0 if measured.slowing is None else measured.slowing
    return replace(measured, slowing=steady * (1 + turn_of_floor(measured, fit)))


def turn_of_floor(measured: Measurements, fit: FitResult) -> Floats:
    """Angle that the floor turns by while a run is timed, over that of the run; at a pole without a latitude."""
    vertical = physics.EARTH_ROTATION * math.sin(math.pi / 2 if measured.latitude is None else measured.latitude)
    # Seen from above, counterclockwise is +1.
    sense = fit.sense if measured.precession_sense is None else measured.precession_sense
    return np.where(sense == 0, fit.sense, sense) * vertical * measured.time / (2 * np.pi * measured.turns)


def earth_is_told(measured: Measurements) -> bool:
    """Say whether the log gives the latitude, and which way each run went: then the Earth can be corrected for."""
    return (
        measured.latitude is not None
        and measured.precession_sense is not None
        and bool(measured.precession_sense.all())
    )


def iterate_mean_rate(measured: Measurements, chosen: ChosenModel, left_out: Collection[int] = ()) -> Measurements:
    """Correct runs whose rate is not that of steady precession at one spin, by what the fit of them gives.

    Gives the runs with `slowing`, and for a rod let go from rest with two more sources of error: the phase of the
    nutation at the last click, and I. Runs that need nothing of it are given back as they are.
    """
    if not chosen.earth and not is_unsteady(measured, chosen):
        return measured
    runs, result = at_mean_rate(measured, chosen, left_out)
    # Without a run to spare every value that goes with itself fits as well, and runs that contradict each other tell
    # no phase.
    if (
        not chosen.released
        or result.dof < 1
        or result.scatter > 1
        or phase_known(measured, result.inertia.value).max() < 0.1
    ):
        return runs
    # Following takes hundreds of fits: not of what is no answer anyway.
    says = np.ones(len(measured.runs))
    says[list(left_out)] = 0.0
    insist_on_lines(runs, result, chosen.tilted, says)
    return _followed(measured, result, chosen, left_out)


def _followed(measured: Measurements, mean: FitResult, chosen: ChosenModel, left_out: Collection[int]) -> Measurements:
    """Follow the nutation too, at the I_zz near that of the mean rates that goes with itself.

    The nutation's phase turns many times within the uncertainty of I_zz, so several values do; of them the one
    with the smallest chi-square is taken. Then the same nearby, with the M0 and b that go with it.
    """
    centre = mean.inertia.value
    # Which way runs without a weight turn is known by now.
    measured = replace(measured, sense=mean.sense)
    click = physics.click_error(measured.spin, centre, transverse_inertia(measured))
    # A fit may end near any I_zz above 0; no trial is made at 0 or below.
    radian = min(centre / float((measured.time / click).max()), 0.5 * centre)
    result = mean
    for reach in (min(4 * math.sqrt(mean.covariance[0, 0]), 30 * radian), radian, radian):

        def at(inertia: float, fit: FitResult = result) -> Trial:
            runs = corrected(measured, fit, inertia, chosen, followed=True)
            try:
                return Trial(inertia, refit(fit, runs, chosen.tilted), runs)
            except NoFit:
                return Trial(inertia, fit_as_stated(runs, chosen.tilted, left_out), runs)

        near = min(reach, 0.5 * centre)
        trials = [at(float(t)) for t in centre + np.arange(-near, 1.01 * near, 0.3 * radian)]
        # Only where it may beat the best so far.
        likely = min(trial.result.chi2 for trial in trials) + LIKELY
        trials += [
            _crossing(at, a, b)
            for a, b in pairwise(trials)
            if a.misfit * b.misfit < 0 and min(a.result.chi2, b.result.chi2) < likely
        ]
        best = min(trials, key=lambda trial: trial.result.chi2)
        centre, result = best.result.inertia.value, best.result
    return best.runs


class Trial(Struct, frozen=True):
    """The fit of runs that were followed with some I_zz."""

    inertia: float
    """That I_zz [kg*m^2]."""
    result: FitResult
    runs: Measurements

    @property
    def misfit(self) -> float:
        """I_zz that comes out minus the one that went in [kg*m^2]."""
        return self.result.inertia.value - self.inertia


def _crossing(at: Callable[[float], Trial], low: Trial, high: Trial) -> Trial:
    """Find where the I_zz that comes out is the one that went in, by the Illinois rule."""
    a, b, f_a, f_b = low.inertia, high.inertia, low.misfit, high.misfit
    found = high
    for _turn in range(40):
        found = at((a * f_b - b * f_a) / (f_b - f_a))
        if abs(found.misfit) < 1e-9 * math.sqrt(found.result.covariance[0, 0]):
            break
        if found.misfit * f_b < 0:
            a, f_a = b, f_b
        else:
            f_a /= 2
        b, f_b = found.inertia, found.misfit
    return found
