"""Which model a log is fitted with, and what its equation has to be corrected by.

The models are eq. (9) for a level rod, eq. (8) for a tilted one, and the mean rate of the whole motion for a rod let go
from rest: the simplest that the sizes of the `effects` allow. A rod let go from rest nutates, and goes a little slower
on average; a tilted one whose spin falls has a mean rate that is not the one at the mean spin. Both depend on I_zz a
little, so that fit and correction are iterated together.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from gyrodata import fitting, physics
from gyrodata.effects import (
    DROP_ALL,
    DROP_ONE,
    never_corrected,
    relative_u,
    release_by_run,
    tilt_by_run,
    whole,
)
from gyrodata.fitting import FitResult
from gyrodata.measurements import TRANSVERSE_U, Measurements, Source
from gyrodata.physics import Floats

Model = Literal["auto", "horizontal", "steady", "released"]

LIKELY = 10.0
"""A phase of the nutation whose chi-square is larger than the best one's by more than this is not looked into."""


@dataclass(frozen=True)
class ChosenModel:
    """The model that a log is fitted with."""

    tilted: bool
    """Eq. (8) with each run's pitch, not eq. (9)."""
    released: bool
    """The mean rate of a rod let go from rest, not that of steady precession."""
    asked: bool
    """True if the caller chose it."""

    @property
    def name(self) -> Literal["horizontal", "steady", "released"]:
        """Name of the model, as ``--model`` takes it."""
        if self.released:
            return "released"
        return "steady" if self.tilted else "horizontal"


def choose_model(measured: Measurements, model: Model) -> ChosenModel:
    """Take the simplest model that is good enough for a log, by the sizes of the effects, or the one asked for."""
    tilts = bool(np.any(measured.pitch))
    if model != "auto":
        tilted = model == "steady" or (model == "released" and tilts)
        return ChosenModel(tilted, released=model == "released", asked=True)
    if not tilts and measured.motion != "released":
        return ChosenModel(tilted=False, released=False, asked=False)
    try:
        fit = fitting.fit_as_stated(measured)
    except fitting.NoFit:
        # Nothing tells what could be left out.
        return ChosenModel(tilts, measured.motion == "released", asked=False)
    by_run = {}
    if tilts:
        by_run["tilt"] = tilt_by_run(measured, fit, measured.pitch)
    if measured.motion == "released":
        by_run["release"] = release_by_run(measured, fit)
    dropped = sum(abs(bias) for bias in never_corrected(measured, fit).values())
    kept = _kept({name: whole(fit, biases) for name, biases in by_run.items()}, dropped, relative_u(fit))
    kept |= {name for name, biases in by_run.items() if _seen_in_scatter(measured, fit, biases)}
    return ChosenModel(tilted="tilt" in kept, released="release" in kept, asked=False)


def _kept(biases: Mapping[str, float], dropped: float, u: float) -> set[str]:
    """Which effects are too large to leave out, where `dropped` is out already."""
    kept = set(biases)
    for name in sorted(biases, key=lambda name: abs(biases[name])):
        dropped += abs(biases[name])
        if abs(biases[name]) > DROP_ONE * u or dropped > DROP_ALL * u:
            break
        kept.discard(name)
    return kept


def _seen_in_scatter(measured: Measurements, fit: FitResult, biases: Floats) -> bool:
    """Say whether an effect that cancels in I_zz, as of a rod tilted up and down, still spoils the single runs."""
    return float(np.sqrt(np.mean((biases * measured.time / fit.time_u) ** 2))) > DROP_ALL


def is_unsteady(measured: Measurements, chosen: ChosenModel) -> bool:
    """Say whether eqs. (8) and (9), for steady precession at one spin, need `iterate_mean_rate`."""
    return chosen.released or (chosen.tilted and measured.spin_start is not None)


def iterate_mean_rate(measured: Measurements, chosen: ChosenModel, left_out: Collection[int] = ()) -> Measurements:
    """Correct runs whose rate is not that of steady precession at one spin, by what the fit of them gives.

    Gives the runs with `slowing`, and for a rod let go from rest with two more sources of error: the phase of the
    nutation at the last click, and I.
    """
    result = fitting.fit_as_stated(measured, chosen.tilted, left_out)
    runs = measured
    for _turn in range(20):
        before, runs = runs.slowing, _slowed(measured, result, chosen, result.inertia.value, followed=False)
        result = fitting.fit_as_stated(runs, chosen.tilted, left_out)
        if before is not None and runs.slowing is not None and np.allclose(before, runs.slowing, rtol=1e-10, atol=0):
            break
    # Without a run to spare every value that goes with itself fits as well, and runs that contradict each other tell
    # no phase.
    if (
        not chosen.released
        or result.dof < 1
        or result.scatter > 1
        or _phase_known(measured, result.inertia.value).max() < 0.1
    ):
        return runs
    # Following takes hundreds of fits: not of what is no answer anyway.
    fitting.insist_on_lines(runs, result, chosen.tilted, _says(measured, left_out))
    return _followed(measured, result, chosen, left_out)


def _says(measured: Measurements, left_out: Collection[int]) -> Floats:
    """1 for a run with a say, else 0."""
    says = np.ones(len(measured.runs))
    says[list(left_out)] = 0.0
    return says


def _followed(measured: Measurements, mean: FitResult, chosen: ChosenModel, left_out: Collection[int]) -> Measurements:
    """Follow the nutation too, at the I_zz near that of the mean rates that goes with itself.

    The nutation's phase turns many times within the uncertainty of I_zz, so several values do; of them the one
    with the smallest chi-square is taken. Then the same nearby, with the M0 and b that go with it.
    """
    centre = mean.inertia.value
    if not mean.two_signs:
        # Which way runs without a weight turn is known by now.
        measured = replace(measured, sense=mean.sense)
    click = physics.click_error(measured.spin, centre, fitting.transverse_inertia(measured))
    # A fit may end near any I_zz above 0; no trial is made at 0 or below.
    radian = min(centre / float((measured.time / click).max()), 0.5 * centre)
    result = mean
    for reach in (min(4 * (mean.inertia.u or 0.0), 30 * radian, 0.5 * centre), radian, radian):

        def at(inertia: float, fit: FitResult = result) -> Trial:
            runs = _slowed(measured, fit, chosen, inertia, followed=True)
            return Trial(inertia, fitting.fit_as_stated(runs, chosen.tilted, left_out), runs)

        trials = [at(float(t)) for t in centre + np.arange(-reach, 1.01 * reach, 0.3 * radian)]
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


@dataclass(frozen=True)
class Trial:
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
        if abs(found.misfit) < 1e-13 * abs(found.inertia):
            break
        if found.misfit * f_b < 0:
            a, f_a = b, f_b
        else:
            f_a /= 2
        b, f_b = found.inertia, found.misfit
    return found


def _phase_known(measured: Measurements, inertia: Floats | float) -> Floats:
    """How well the phase of the nutation at the last click is known, 0 to 1: e^(−σ²/2) of its uncertainty σ [rad]."""
    click = physics.click_error(measured.spin, inertia, fitting.transverse_inertia(measured))
    own = sum((s.relative**2 for s in measured.sources if s.quantity == "spin"), start=np.zeros(len(measured.runs)))
    known: Floats = np.exp(-0.5 * (measured.time / click) ** 2 * (_transverse_u(measured) ** 2 + own))
    return known


def _slowed(
    measured: Measurements, fit: FitResult, chosen: ChosenModel, inertia: float, followed: bool
) -> Measurements:
    """Work out how much slower each run is than steady precession at its mean spin, for an I_zz [kg*m^2].

    Without `followed` a rod let go from rest has its mean rate. With it, it is followed exactly from the start of
    the clock to the last click. Where the phase has a standard uncertainty σ, the most likely delay is e^(−σ²/2) of
    the computed one, and what is left of it is spread as (1 − e^(−σ²))/(2 ω_n²).
    """
    across = fitting.transverse_inertia(measured)
    total = measured.torque + fit.imbalance.value
    lean = (across, measured.pitch) if chosen.tilted else (0.0, 0.0)
    # The weight spins along.
    whole = inertia + measured.added
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = physics.precession_rate(total, measured.spin, whole, *lean)
        if not chosen.released:
            return replace(measured, slowing=steady / _mean_rate_of_decay(measured, total, whole, across))
    from gyrodata import motion

    top = motion.Top(whole, across, total)
    state = motion.released(top, measured.spin, measured.pitch)
    mean = motion.mean_precession_rate(top, state)
    ratio = steady / mean
    known = np.zeros(len(total))
    if followed:
        known = _phase_known(measured, whole)
        angle = np.sign(mean) * 2 * np.pi * measured.turns
        # What the rod has swept by the time that was read, not the time that the count would take: the phase is
        # then free of the torque.
        time = measured.time - fit.timing_bias.value
        ahead = motion.precession_angle(top, state, time) - mean * time
        ratio = ratio - known * ahead * steady / (mean * angle)
    click = physics.click_error(measured.spin, whole, across)
    own, every = tuple(range(len(total))), (0,) * len(total)
    nothing = np.zeros(len(total))
    spread = click * np.sqrt((1 - known**2) / 2)
    # The delay of the mean goes with the square of I.
    doubt = 2 * _transverse_u(measured) * np.abs(steady / mean - 1)
    more = (
        Source("nutation", "time", own, spread, nothing, "", True, "its phase at the last click"),
        Source("release", "turns", every, nothing, doubt, "all runs", True, "the doubt about I in the mean rate"),
    )
    return replace(measured, slowing=ratio, sources=(*measured.sources, *more))


def _transverse_u(measured: Measurements) -> float:
    """Relative standard uncertainty of I [1]."""
    stated = (float(source.relative.max()) for source in measured.sources if source.quantity == "transverse")
    return next(stated, TRANSVERSE_U)


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
