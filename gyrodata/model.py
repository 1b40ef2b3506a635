"""Which model a log is fitted with, and what its equation has to be corrected by.

The models are eq. (9) for a level rod, eq. (8) for a tilted one, and the mean rate of the whole motion for a rod let go
from rest: the simplest that the sizes of the `effects` allow. A rod let go from rest nutates, and goes a little slower
on average; a tilted one whose spin falls has a mean rate that is not the one at the mean spin. Both depend on I_zz a
little, so that fit and correction are iterated together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

from gyrodata import fitting, physics
from gyrodata.effects import (
    DROP_ALL,
    DROP_ONE,
    ChosenModel,
    at_mean_rate,
    corrected,
    earth_is_told,
    list_effects,
    relative_u,
)
from gyrodata.fitting import FitResult
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

Model = Literal["auto", "horizontal", "steady", "released"]

ALWAYS_OUT = ("decay_law", "earth")
"""Effects that are left out where the log does not tell enough, and count towards all that is."""

LIKELY = 10.0
"""A phase of the nutation whose chi-square is larger than the best one's by more than this is not looked into."""


def choose_model(measured: Measurements, model: Model) -> ChosenModel:
    """Take the simplest model that is good enough for a log, by the sizes of the effects, or the one asked for."""
    tilts, told = bool(np.any(measured.pitch)), earth_is_told(measured)
    released = measured.motion == "released"
    if model != "auto":
        tilted = model == "steady" or (model == "released" and tilts)
        return ChosenModel(tilted, released=model == "released", asked=True)
    named = {"tilt": tilts, "release": released, "earth": told}
    simplest = ChosenModel(tilted=False, released=False, asked=False)
    fullest = ChosenModel(tilts, released, asked=False, earth=told)
    if simplest == fullest:
        return simplest
    try:
        fit = fitting.fit_as_stated(measured)
    except fitting.NoFit:
        # Nothing tells what could be left out.
        return fullest
    sizes = {effect.effect: effect for effect in list_effects(measured, fit, simplest, (*named, *ALWAYS_OUT))}
    may = {name: sizes[name].bias for name, has in named.items() if has}
    # What has no fit without it cannot be left out.
    known = {name: bias for name, bias in may.items() if bias is not None}
    rest = (sizes[name] for name in ALWAYS_OUT if name in sizes and name not in may)
    dropped = math.fsum(abs(effect.bias or 0.0) for effect in rest if not effect.in_u)
    kept = _kept(known, dropped, relative_u(fit)) | (set(may) - set(known))
    kept |= {name for name in may if name in named and _seen_in_scatter(measured, fit, name)}
    return ChosenModel("tilt" in kept, "release" in kept, asked=False, earth="earth" in kept)


def _kept(biases: Mapping[str, float], dropped: float, u: float) -> set[str]:
    """Which effects are too large to leave out, where `dropped` is out already."""
    kept = set(biases)
    for name in sorted(biases, key=lambda name: abs(biases[name])):
        dropped += abs(biases[name])
        if abs(biases[name]) > DROP_ONE * u or dropped > DROP_ALL * u:
            break
        kept.discard(name)
    return kept


def _seen_in_scatter(measured: Measurements, fit: FitResult, name: str) -> bool:
    """Say whether an effect that cancels in I_zz, as of a rod tilted up and down, still spoils the single runs."""
    across = fitting.transverse_inertia(measured)
    if name == "tilt":
        rate = fit.sense * 2 * np.pi * measured.turns / measured.time
        biases = physics.tilt_bias(rate, measured.spin, measured.pitch, fit.inertia.value, across)
    elif name == "release":
        biases = physics.release_bias(measured.torque + fit.imbalance.value, measured.spin, fit.inertia.value, across)
    else:
        return False
    return float(np.sqrt(np.mean((biases * measured.time / fit.time_u) ** 2))) > DROP_ALL


def iterate_mean_rate(measured: Measurements, chosen: ChosenModel, left_out: Collection[int] = ()) -> Measurements:
    """Correct runs whose rate is not that of steady precession at one spin, by what the fit of them gives.

    Gives the runs with `slowing`, and for a rod let go from rest with two more sources of error: the phase of the
    nutation at the last click, and I.
    """
    runs, result = at_mean_rate(measured, chosen, left_out)
    # Without a run to spare every value that goes with itself fits as well, and runs that contradict each other tell
    # no phase.
    if (
        not chosen.released
        or result.dof < 1
        or result.scatter > 1
        or fitting.phase_known(measured, result.inertia.value).max() < 0.1
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
            runs = corrected(measured, fit, inertia, chosen, followed=True)
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
