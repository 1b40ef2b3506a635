"""How large each simplification is in a log: what it does to I_zz, in its own standard uncertainties.

One record of `EFFECTS` each. Its size is found by fitting again: with the effect and without it, at the widths of the
log's fit, with I_zz, M0 and b free in both; a small one by the fit's own response, to first order. What is below 0.2 of
the standard uncertainty is dropped, smallest first, while all that is dropped stays below 0.3 and the single runs do
not scatter by it; the rest is kept, in the model that `choose_model` takes. Effects of unknown size (M0, b) are
parameters of every model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from typing import cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from gyrodata import fitting, physics
from gyrodata.fitting import (
    ChosenModel,
    FitResult,
    Model,
    NoFit,
    corrected,
    earth_is_told,
    unslowed,
)
from gyrodata.measurements import Measurements, select
from gyrodata.physics import Floats

DROP_ONE = 0.2
"""An effect below this many standard uncertainties of I_zz may be left out …"""

DROP_ALL = 0.3
"""… as long as all that are left out stay below this many together."""

CLEARLY_SMALL = 0.05
"""A size below this many standard uncertainties need not be known any better."""

SECOND_ORDER = 0.01
"""What is left out of a size, where it is told to first order, is below this many standard uncertainties."""

LEVEL_TO = math.radians(2.0)
"""How far from level [rad] a rod may be that nobody measured: the default standard uncertainty of a pitch."""


TURNS = 12
"""So often at most I_zz goes into its own correction."""


class Effect(Struct, frozen=True):
    """One simplification: how much it would move I_zz in this log, and whether it was allowed."""

    effect: str
    bias: float | None
    """I_zz without it over I_zz with it, minus 1; None where the log does not tell."""
    size: float | None
    """The same without its sign, in standard uncertainties of I_zz."""
    kept: bool
    """True if the model takes it into account."""
    in_u: bool
    """True if u of I_zz holds the doubt about it."""
    reason: str


def relative_u(fit: FitResult) -> float:
    """Standard uncertainty of I_zz over I_zz [1]."""
    return (fit.inertia.u or 0.0) / abs(fit.inertia.value)


class Case(Struct, frozen=True):
    """A log that the sizes are worked out for, and the model that it is fitted with."""

    measured: Measurements
    fit: FitResult
    chosen: ChosenModel

    @property
    def asked(self) -> str:
        """Words where the caller chose the model, else none."""
        return ", as asked" if self.chosen.asked else ""

    def change(self, without: ChosenModel, within: ChosenModel, own: Floats | None = None) -> float | None:
        """I_zz by one model over I_zz by another, minus 1; None where one of them has no fit.

        `own`: what the first makes of each run's own I_zz over what the second does, minus 1, where that is known.
        """
        first_order = None if own is None else self.to_first_order(own)
        if first_order is not None:
            return first_order
        found = _over(self._at_its_widths(without), self._at_its_widths(within))
        if self.fit.posterior is None or (found is not None and abs(found) < CLEARLY_SMALL * relative_u(self.fit)):
            return found
        # A large effect changes how the runs scatter, and so the widths.
        return _over(self._anew(without), self._anew(within))

    def _at_its_widths(self, model: ChosenModel) -> float | None:
        """I_zz by a model, at the widths of the log's fit: it goes into its own correction [kg*m^2]."""
        bare = unslowed(self.measured)
        fit, inertia = self.fit, float(self.fit.adjusted.unknowns[0])
        if model == self.chosen and self.measured.slowing is None:
            return inertia
        for _turn in range(TURNS):
            runs = corrected(bare, fit, inertia, model)
            if runs.slowing is not None and not np.isfinite(runs.slowing).all():
                return None
            try:
                fit = fitting.refit(self.fit, runs, model.tilted)
            except NoFit:
                return None
            before, inertia = inertia, fit.inertia.value
            # A correction goes with the fourth power of I_zz at most.
            if runs.slowing is None or 4 * (inertia - before) ** 2 < 1e-3 * (self.fit.inertia.u or 0.0) * inertia:
                break
        return inertia

    def _anew(self, model: ChosenModel) -> float | None:
        """I_zz by a model, fitted as if it were the log's [kg*m^2]."""
        if model == self.chosen:
            return self.fit.inertia.value
        left_out = np.flatnonzero(self.fit.adjusted.kept == 0).tolist()
        try:
            runs = fitting.iterate_mean_rate(unslowed(self.measured), model, left_out)
            return fitting.fit(runs, model.tilted, left_out).inertia.value
        except NoFit:
            return None

    def to_first_order(self, own: Floats) -> float | None:
        """I_zz over that of the log's fit, minus 1, if each run's own I_zz changes by a share; None where not small."""
        each, u = self.fit.response * own, relative_u(self.fit)
        # What large shares leave of each other is no small change, but one of second order.
        bent = np.abs(each).sum() * np.abs(own).max()
        return float(each.sum()) if abs(each.sum()) < CLEARLY_SMALL * u and bent < SECOND_ORDER * u else None

    def of(self, measured: Measurements, balanced: bool = False) -> float | None:
        """I_zz of other runs over that of the log's fit, minus 1; None where there is no fit."""
        try:
            other = fitting.refit(self.fit, measured, self.chosen.tilted, balanced).inertia.value
        except NoFit:
            return None
        return other / float(self.fit.adjusted.unknowns[0]) - 1


def _over(without: float | None, within: float | None) -> float | None:
    return None if without is None or within is None else without / within - 1


Found = tuple[float | None, bool, str]
"""Change of I_zz, None where the log does not tell; whether the model takes the effect into account; and why."""


_UNKNOWN = "its size is unknown beforehand, so {} is a parameter with {}"


def _residual_torque(case: Case) -> Found:
    fit = case.fit
    width = fitting.balance_scale(case.measured, fit.inertia.value, fit.adjusted.kept)
    prior = f"prior width {width:.2g} N·m, with wide tails"
    return case.of(case.measured, balanced=True), True, _UNKNOWN.format("M0", prior)


def _timing_bias(case: Case) -> Found:
    measured = case.measured
    if measured.timing_bias_u == 0:
        return 0.0, False, "not a stopwatch's time, or u_time_bias is 0"
    prior = f"prior width {measured.timing_bias_u:g} s"
    return case.of(replace(measured, timing_bias_u=0.0)), True, _UNKNOWN.format("b", prior)


def _spin_decay(case: Case) -> Found:
    start, end = case.measured.spin_start, case.measured.spin_end
    if start is None or end is None:
        why = "one reading of the spin in each run; taken at half time it is good to 0.05 % for a fall of 10 %"
        return None, False, why
    readings = "start and end" if case.measured.spin_readings == 2 else "start, half time and end"
    why = f"the harmonic mean in time of {readings} costs nothing, so it is used"
    return case.of(replace(case.measured, spin=(start + end) / 2)), True, why


def _decay_law(case: Case) -> Found | None:
    measured = case.measured
    start, end = measured.spin_start, measured.spin_end
    if measured.spin_readings != 2 or start is None or end is None:
        return None
    own = physics.decay_law_doubt(start, end)
    bias = case.to_first_order(own)
    if bias is None:
        bias = case.of(replace(measured, spin=measured.spin / (1 + own)))
    premise = "a viscous decay is assumed, as of an air film; this is for dry friction"
    if held_in_u(measured, "decay_exponent"):
        return bias, False, f"{premise}; u holds the doubt about the law"
    u = relative_u(case.fit)
    more = "; read the spin at half time as well" if abs(bias or 0.0) >= DROP_ONE * u else ""
    return bias, False, _why(bias, u, premise, False) + more


def _tilt(case: Case) -> Found:
    u, chosen = relative_u(case.fit), case.chosen
    if not np.any(case.measured.pitch):
        leaning = replace(case, measured=replace(case.measured, pitch=np.full(len(case.measured.runs), LEVEL_TO)))
        own = _by_tilt(leaning.measured, case.fit)
        bias = leaning.change(replace(chosen, tilted=False), replace(chosen, tilted=True), own)
        return bias, False, _why(bias, u, "no pitch in the log; this is for 2° off level", False)
    own = _by_tilt(case.measured, case.fit)
    bias = case.change(replace(chosen, tilted=False), replace(chosen, tilted=True), own)
    equation = "eq. (8)" if chosen.tilted else "eq. (9)"
    return bias, chosen.tilted, _why(bias, u, f"{equation} is used{case.asked}", chosen.tilted)


def _release(case: Case) -> Found:
    chosen = case.chosen
    if case.measured.motion == "steady":
        premise = "steady, as the log says; this is for a rod let go from rest"
    elif chosen.released:
        premise = f"the mean rate of a rod let go from rest is used{case.asked}"
    elif case.measured.motion is None:
        premise = 'assumed steady; this is for a rod let go from rest ("# motion: released" in the log)'
    else:
        premise = f"taken for steady precession{case.asked}"
    u, level = relative_u(case.fit), not case.measured.pitch.any()
    own = _by_release(case.measured, case.fit) if level else None
    bias = case.change(replace(chosen, released=False), replace(chosen, released=True), own)
    return bias, chosen.released, _why(bias, u, premise, chosen.released)


def release_may_matter(measured: Measurements, fit: FitResult, chosen: ChosenModel) -> bool:
    """Say whether the release is worth its size: not so where it is small for certain, to first order."""
    if measured.pitch.any() or chosen.released:
        return True
    # Runs that scatter more than stated may do so for the release, which then widens u.
    size = abs(float(fit.response @ _by_release(measured, fit))) * max(1.0, fit.scatter)
    return not size < 0.7 * DROP_ONE * relative_u(fit)


def _by_release(measured: Measurements, fit: FitResult) -> Floats:
    """By what share each run's own I_zz is too high if a level rod was let go from rest, and is taken for steady."""
    total, across = measured.torque + fit.imbalance.value, fitting.transverse_inertia(measured)
    return cast(Floats, physics.release_bias(total, measured.spin, fit.inertia.value, across))


def _by_tilt(measured: Measurements, fit: FitResult) -> Floats:
    """By what share each run's own I_zz is too high where a tilted rod is taken for level."""
    rate, across = fit.sense * 2 * np.pi * measured.turns / measured.time, fitting.transverse_inertia(measured)
    return cast(Floats, physics.tilt_bias(rate, measured.spin, measured.pitch, fit.inertia.value, across))


def _earth(case: Case) -> Found:
    u, chosen = relative_u(case.fit), case.chosen
    own = fitting.turn_of_floor(case.measured, case.fit)
    bias = case.change(replace(chosen, earth=False), replace(chosen, earth=True), own)
    if earth_is_told(case.measured):
        premise = "the angles are counted against the stars" if chosen.earth else "at the log's latitude"
        return bias, chosen.earth, _why(bias, u, premise, chosen.earth)
    premise = "at most, at a pole" if case.measured.latitude is None else "at the log's latitude, its sign not told"
    return None if bias is None else abs(bias), False, _why(bias, u, premise, False)


def _why(bias: float | None, u: float, premise: str, kept: bool) -> str:
    """Say why an effect was left out or kept, with its size in standard uncertainties."""
    if bias is None:
        return f"{premise}: without a fit that could be compared"
    if u == 0:
        return premise
    size = abs(bias) / u
    if kept:
        return f"{premise}: {size:.2g} u"
    verdict = "small enough" if size < DROP_ONE else "NOT small, and the log does not say enough to correct for it"
    return f"{premise}: {size:.2g} u, {verdict}"


def held_in_u(measured: Measurements, source: str) -> bool:
    """Say whether a source of error of that name touches the log."""
    return any(one.name == source and (one.absolute.any() or one.relative.any()) for one in measured.sources)


class EffectKind(Struct, frozen=True):
    """What is known of an effect before a log is read."""

    name: str
    """Its name in the JSON."""
    words: str
    """What it is called; after a comma, what stands in its place where the model leaves it out."""
    find: Callable[[Case], Found | None]
    """Its size in a log, and what became of it; None where the log has no such effect."""
    source: str = ""
    """The source of error with which u of I_zz holds it, if there is one."""


EFFECTS = (
    EffectKind("residual_torque", "imperfect balance", _residual_torque),
    EffectKind("timing_bias", "timing bias of the hand", _timing_bias),
    EffectKind("spin_decay", "falling spin, plain mean of start and end", _spin_decay),
    EffectKind("decay_law", "law by which the spin falls", _decay_law, "decay_exponent"),
    EffectKind("tilt", "tilted rod, eq. (9) for eq. (8)", _tilt),
    EffectKind("release", "nutation after letting go", _release),
    EffectKind("earth", "the Earth's rotation", _earth),
)
"""Every effect, in the order of the tables."""


def _of_some(case: Case) -> Case:
    """Take a sample of the runs where there are very many, with the u of I_zz that all of them have."""
    if len(case.measured.runs) <= fitting.MANY:
        return case
    some = select(case.measured, fitting.sample(case.measured, case.fit.adjusted.kept))
    try:
        fit = fitting.fit(some, case.chosen.tilted)
    except NoFit:
        return case
    u = relative_u(case.fit) * abs(fit.inertia.value)
    # Without a posterior the sizes are told at the widths of this fit, however large they are.
    return Case(some, replace(fit, inertia=replace(fit.inertia, u=u), posterior=None), case.chosen)


def list_effects(
    measured: Measurements, fit: FitResult, chosen: ChosenModel, names: Collection[str] = ()
) -> tuple[Effect, ...]:
    """List every simplification, or those of some names, with its size in this log, and what became of it."""
    case, u = _of_some(Case(measured, fit, chosen)), relative_u(fit)
    effects = []
    for kind in EFFECTS:
        found = kind.find(case) if not names or kind.name in names else None
        if found is not None:
            bias, kept, reason = found
            size = None if bias is None or not u else abs(bias) / u
            effects.append(Effect(kind.name, bias, size, kept, held_in_u(measured, kind.source), reason))
    return tuple(effects)


ALWAYS_OUT = ("decay_law", "earth")
"""Effects that are left out where the log does not tell enough, and count towards all that is."""


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
    if name not in ("tilt", "release"):
        return False
    biases = _by_tilt(measured, fit) if name == "tilt" else _by_release(measured, fit)
    return float(np.sqrt(np.mean((biases * measured.time / fit.time_u) ** 2))) > DROP_ALL
