"""The size of each simplification in a log: the change of I_zz, in its standard uncertainties.

The size of an effect is the fit with it minus the fit without it (`changes`). An effect below 0.2 of the standard
uncertainty is left out, the smallest first, if all of these together stay below 0.3 and if the single runs do not
deviate because of it. `choose_model` keeps the others. Effects of unknown size (M0, b) are parameters of every model.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from contextlib import suppress
from typing import cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import changes, fitting, physics
from gyrodata.changes import Change, Lab
from gyrodata.fitting import ChosenModel, Estimate, FitResult, Model, earth_is_told, relative_u
from gyrodata.measurements import Measurements, select
from gyrodata.physics import Floats

DROP_ONE = 0.2
"""An effect below this many standard uncertainties of I_zz may be left out …"""

DROP_ALL = 0.3
"""… as long as all that are left out stay below this many together."""

CLEARLY_SMALL = 0.05
"""An effect below this many standard uncertainties does not change how the runs scatter."""


class Effect(Struct, frozen=True):
    """One simplification: how much it would change I_zz of a log, and whether it is made."""

    effect: str
    bias: float | None
    """I_zz without it over I_zz with it, minus 1; None if it cannot be computed."""
    size: float | None
    """The same without its sign, in standard uncertainties of I_zz."""
    kept: bool
    """True if the model takes it into account."""
    in_u: bool
    """True if u of I_zz contains its uncertainty."""
    reason: str


def _bias(lab: Lab, change: Change) -> float | None:
    """Compute I_zz without an effect over I_zz with it, minus 1; None if it cannot be computed."""
    if change.measured is lab.measured and change.chosen == lab.chosen and not change.widths:
        return 0.0
    if change.measured is None:
        return None
    try:
        _, fit = fitting.fit_model(change.measured, change.chosen, change.left_out, change.widths or lab.fit.widths)
        ratio = fit.inertia.value / float(lab.fit.adjusted.unknowns[0])
        is_large = abs(ratio - 1) > CLEARLY_SMALL * relative_u(lab.fit.inertia)
        if is_large and lab.fit.posterior is not None and not change.widths:
            # A large effect changes how the runs scatter, and so the widths.
            _, fit = fitting.fit_model(change.measured, change.chosen, change.left_out)
            ratio = fit.inertia.value / lab.fit.inertia.value
    except fitting.NoFit:
        return None
    return ratio - 1 if change.without else 1 / ratio - 1


def _sample(lab: Lab) -> Lab:
    """Take a sample of very many runs, with the u of I_zz of all runs."""
    some = select(lab.measured, fitting.sample(lab.measured, lab.fit.adjusted.kept))
    try:
        measured, fit = fitting.fit_model(some, lab.chosen)
    except fitting.NoFit:
        return lab
    u = relative_u(lab.fit.inertia) * abs(fit.inertia.value)
    # Without a posterior the sizes are those at the widths of this fit, however large they are.
    return Lab(None, measured, replace(fit, inertia=replace(fit.inertia, u=u), posterior=None), lab.chosen)


def list_effects(lab: Lab, names: Collection[str] = ()) -> tuple[Effect, ...]:
    """List every simplification, or those of some names, with its size in a log and the decision."""
    u, effects, told = relative_u(lab.fit.inertia), [], earth_is_told(lab.measured)
    if len(lab.measured.runs) > fitting.MANY:
        lab = _sample(lab)
    for change in changes.CHANGES["effect"](lab):
        if names and change.name not in names:
            continue
        bias = _bias(lab, change)
        if change.name == "earth" and bias is not None and not told:
            bias = abs(bias)
        size, reason = None if bias is None or not u else abs(bias) / u, change.words
        if change.sized and bias is None:
            reason += ": without a fit that could be compared"
        elif change.sized and size is not None:
            verdict = ", small enough"
            if change.kept:
                is_seen = size < DROP_ONE and change.name in ("tilt", "release")
                verdict = "; kept because the single runs show it" if is_seen else ""
            elif size >= DROP_ONE:
                verdict = ", NOT small, and the log does not say enough to correct for it"
                verdict += "; read the spin at the midpoint as well" if change.name == "decay_law" else ""
            reason += f": {size:.2g} u{verdict}"
        effects.append(Effect(change.name, bias, size, change.kept, change.in_u, reason))
    return tuple(effects)


def release_may_matter(lab: Lab) -> bool:
    """Return whether the size of the release is worth a fit; for a level rod it may be certainly small."""
    return bool(lab.measured.pitch.any()) or lab.chosen.released or not _release_size(lab) < 0.7 * DROP_ONE


def _release_size(lab: Lab) -> float:
    """Estimate the size of the release for a level rod, without a fit, in standard uncertainties of I_zz [1]."""
    u = relative_u(lab.fit.inertia)
    # Runs that scatter more than stated may do so because of the release, which then widens u.
    size = abs(float(lab.fit.response @ _release_bias(lab.measured, lab.fit))) * max(1.0, lab.fit.widths.scatter)
    return size / u if u else math.inf


def _release_bias(measured: Measurements, fit: FitResult) -> Floats:
    """Compute the relative excess of each run's I_zz if a level rod was released, and is treated as steady."""
    total, across = measured.torque + fit.residual_torque.value, fitting.transverse_inertia(measured)
    return cast(Floats, physics.release_bias(total, measured.spin, fit.inertia.value, across))


STEEP, FALLEN = math.radians(45), math.radians(52)
"""A released rod that sags by more than the first angle hits the cup of the ball. No answer is given from the
second angle on: without a fit the sag is known to some degrees only."""


def _stays_up(lab: Lab) -> bool:
    """Return whether no run of a log would sag steeply if the rod was released."""
    measured, fit = lab.measured, lab.fit
    loaded, across = measured.torque != 0, fitting.transverse_inertia(measured)
    total = measured.torque + fit.residual_torque.value
    sag = physics.greatest_sag(total, measured.spin, fit.inertia.value, across, measured.pitch)
    return bool(np.max(sag[loaded]) < FALLEN)


class Sensitivity(Struct, frozen=True):
    """I_zz if one thing were different."""

    name: str
    """"u_time_twice", "hand_late", "hand_early", "balanced", "balance_free" or "without"."""
    words: str
    """What is different: "without 20 g at 15 cm"."""
    inertia: Estimate | None
    """[kg*m^2]; None if the changed log has no answer: an interval that contains zero."""
    deviation: float | None
    """Its distance from I_zz in standard uncertainties of I_zz."""


def answers(lab: Lab, table: str) -> list[tuple[Change, Sensitivity]]:
    """Answer every question of a table of `changes.CHANGES` that applies to a lab."""
    if len(lab.measured.runs) > changes.MOST_RUNS:
        return []
    answer, is_clear, found = lab.fit.inertia, _is_clear(lab), []
    for change in changes.CHANGES[table](lab):
        measured, chosen, inertia = change.measured or lab.measured, change.chosen, None
        if not (chosen.asked or (chosen == lab.chosen and (is_clear or len(measured.runs) > FEW))):
            chosen = choose_model(measured, "auto")
        with suppress(fitting.NoFit):
            _, fit = fitting.fit_model(measured, chosen, change.left_out, change.widths)
            # An interval that includes zero is not an answer.
            if (fit.inertia.interval_95 or (1.0, 1.0))[0] > 0:
                inertia = fit.inertia
        deviation = (inertia.value - answer.value) / answer.u if inertia and answer.u else None
        found.append((change, Sensitivity(change.name, change.words, inertia, deviation)))
    return found


FAR_FROM_LIMIT = 2.0
"""If the release is so many times larger or smaller than the limit `DROP_ONE`, it is so in each changed log too."""


def _is_clear(lab: Lab) -> bool:
    """Return whether all changes of a log need the model of the log itself."""
    if lab.chosen.tilted or lab.measured.pitch.any() or earth_is_told(lab.measured):
        return False
    if lab.measured.motion == "steady":
        return True
    if lab.chosen.released:
        return (lab.release or 0.0) > FAR_FROM_LIMIT * DROP_ONE
    return (_release_size(lab) if lab.release is None else lab.release) < DROP_ONE / FAR_FROM_LIMIT


ALWAYS_OUT = ("decay_law", "earth")
"""Effects that are left out if the log lacks the readings for them, and that count towards the sum."""


FEW = 50
"""Of a log with more runs, a changed log has the model of the log itself: another choice takes a second."""


def choose_model(measured: Measurements, model: Model) -> ChosenModel:
    """Choose the simplest model that is good enough for a log, by the sizes of the effects, or the requested one.

    If the log does not say how the rod was started, a release from rest is assumed if it matters.
    """
    tilts, told = bool(np.any(measured.pitch)), earth_is_told(measured)
    if model != "auto":
        tilted = model == "steady" or (model == "released" and tilts)
        return ChosenModel(tilted, released=model == "released", asked=True)
    simplest = ChosenModel(tilted=False, released=False, asked=False)
    fullest = ChosenModel(tilts, measured.motion == "released", asked=False, earth=told)
    if simplest == fullest and measured.motion == "steady":
        return simplest
    try:
        runs, fit = fitting.fit_model(measured, simplest, widths=None if measured.motion is None else fitting.AS_STATED)
        lab = Lab(None, runs, fit, simplest)
    except fitting.NoFit:
        # It is unknown what could be left out.
        return fullest
    released = fullest.released or (measured.motion is None and release_may_matter(lab) and _stays_up(lab))
    if simplest == fullest and not released:
        return simplest
    named = {"tilt": tilts, "release": released, "earth": told}
    sizes = {effect.effect: effect for effect in list_effects(lab, (*named, *ALWAYS_OUT))}
    may = {name: sizes[name].bias for name, has in named.items() if has}
    rest = (sizes[name] for name in ALWAYS_OUT if name in sizes and name not in may)
    dropped = math.fsum(abs(effect.bias or 0.0) for effect in rest if not effect.in_u)
    kept, u = set(may), relative_u(lab.fit.inertia)
    # Leave out the smallest first. If the fit without an effect fails, the effect cannot be left out.
    for size, name in sorted((abs(bias), name) for name, bias in may.items() if bias is not None):
        dropped += size
        if size > DROP_ONE * u or dropped > DROP_ALL * u:
            break
        kept.discard(name)
    # A release that the log does not state is assumed for its effect on I_zz only.
    kept |= {
        name for name in may if _seen_in_scatter(measured, lab.fit, name) and (name != "release" or fullest.released)
    }
    chosen = ChosenModel("tilt" in kept, "release" in kept, asked=False, earth="earth" in kept)
    steady = replace(chosen, released=False)
    if chosen.released and measured.motion is None and _agrees_better(measured, steady, chosen):
        return steady
    return chosen


CLEARLY = math.log(200.0)
"""One explanation is clearly better than another if it makes the times 200 times as likely."""


def _agrees_better(measured: Measurements, one: ChosenModel, other: ChosenModel) -> bool:
    """Return whether the runs, or a sample of very many, agree clearly better with one model than with another."""
    if len(measured.runs) > fitting.MANY:
        measured = select(measured, fitting.sample(measured, np.ones(len(measured.runs))))
    try:
        fits = [fitting.fit_model(measured, chosen)[1] for chosen in (one, other)]
    except fitting.NoFit:
        return False
    return fits[0].log_evidence - fits[1].log_evidence > CLEARLY


def _seen_in_scatter(measured: Measurements, fit: FitResult, name: str) -> bool:
    """Return whether an effect that cancels in I_zz, as of a rod tilted up and down, is visible in the single runs."""
    if name not in ("tilt", "release"):
        return False
    if name == "release":
        biases = _release_bias(measured, fit)
    else:
        rate, across = fit.sense * 2 * np.pi * measured.turns / measured.time, fitting.transverse_inertia(measured)
        biases = physics.tilt_bias(rate, measured.spin, measured.pitch, fit.inertia.value, across)
    return float(np.sqrt(np.mean((biases * measured.time / fit.time_u) ** 2))) > DROP_ALL
