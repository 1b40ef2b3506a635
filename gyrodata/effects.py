"""How large each simplification is in a log: the bias of I_zz, in its own standard uncertainties.

One record of `EFFECTS` each. Each has a bias in closed form; the log's own numbers go into it, weighted as the fit
weights its runs. What is below 0.2 of the standard uncertainty is dropped, smallest first, while all that is dropped
stays below 0.3 and the single runs do not scatter by it; the rest is kept (`model`). Effects of unknown size (M0, b)
are parameters of every model.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gyrodata import fitting, physics
from gyrodata.fitting import FitResult
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

DROP_ONE = 0.2
"""An effect below this many standard uncertainties of I_zz may be left out …"""

DROP_ALL = 0.3
"""… as long as all that are left out stay below this many together."""

LEVEL_TO = math.radians(2.0)
"""How far from level [rad] a rod may be that nobody measured: the default standard uncertainty of a pitch."""


@dataclass(frozen=True, slots=True)
class Effect:
    """One simplification: how much it would move I_zz in this log, and whether it was allowed."""

    effect: str
    bias: float | None
    """I_zz without it over I_zz with it, minus 1; None where the log does not tell."""
    size: float | None
    """The same without its sign, in standard uncertainties of I_zz."""
    kept: bool
    """True if the model takes it into account."""
    reason: str


def relative_u(fit: FitResult) -> float:
    """Standard uncertainty of I_zz over I_zz [1]."""
    return (fit.inertia.u or 0.0) / abs(fit.inertia.value)


def _rate(measured: Measurements, fit: FitResult) -> Floats:
    return fit.sense * 2 * np.pi * measured.turns / measured.time


def whole(fit: FitResult, biases: Floats) -> float:
    """Bias of I_zz from the biases of the runs."""
    return float(np.sum(fit.response * biases))


def tilt_by_run(measured: Measurements, fit: FitResult, pitch: Floats | float) -> Floats:
    """Bias of each run, shape (n,), if its tilt were left out."""
    across = fitting.transverse_inertia(measured)
    bias: Floats = physics.tilt_bias(_rate(measured, fit), measured.spin, pitch, fit.inertia.value, across)
    return bias


def release_by_run(measured: Measurements, fit: FitResult) -> Floats:
    """Bias of each run, shape (n,), if it was let go from rest and taken for steady."""
    total = measured.torque + fit.imbalance.value
    across = fitting.transverse_inertia(measured)
    bias: Floats = physics.release_bias(total, measured.spin, fit.inertia.value, across)
    return bias


def never_corrected(measured: Measurements, fit: FitResult) -> dict[str, float]:
    """Biases of what no model takes into account, because the log cannot tell its sign or its law."""
    at_most = np.abs(physics.earth_bias(_rate(measured, fit), np.pi / 2))
    biases = {"earth": float(np.sum(np.abs(fit.response) * at_most))}
    if measured.spin_readings == 2:
        assert measured.spin_start is not None
        assert measured.spin_end is not None
        biases["decay_law"] = whole(fit, physics.decay_law_doubt(measured.spin_start, measured.spin_end))
    return biases


class Case(NamedTuple):
    """A log that the sizes are worked out for, and the model that it is fitted with."""

    measured: Measurements
    fit: FitResult
    tilted: bool
    """Eq. (8) with each run's pitch, not eq. (9)."""
    released: bool
    """The mean rate of a rod let go from rest, not that of steady precession."""
    asked: str
    """", as asked" where the caller chose the model, else ""."""


Found = tuple[float | None, bool, str]
"""Bias of I_zz, None where the log does not tell; whether the model takes the effect into account; and why."""


_UNKNOWN = "its size is unknown beforehand, so {} is a parameter with {}"


def _residual_torque(case: Case) -> Found:
    fit, torque = case.fit, case.measured.torque
    weights = (case.measured.time / fit.time_u) ** 2 * (fit.response != 0)
    loaded = torque != 0
    per_run = np.zeros(len(weights))
    per_run[loaded] = physics.imbalance_bias(torque[loaded], fit.imbalance.value)
    prior = f"prior width {fitting.balance_scale(case.measured, fit.inertia.value):.2g} N*m, with wide tails"
    return float(np.sum(weights / weights.sum() * per_run)), True, _UNKNOWN.format("M0", prior)


def _timing_bias(case: Case) -> Found:
    measured, fit = case.measured, case.fit
    weights = (measured.time / fit.time_u) ** 2 * (fit.response != 0)
    late = physics.timing_bias(measured.time - fit.timing_bias.value, fit.timing_bias.value)
    known = measured.timing_bias_u == 0
    prior = f"prior width {measured.timing_bias_u:g} s"
    reason = "not a stopwatch's time, or u_time_bias is 0" if known else _UNKNOWN.format("b", prior)
    return float(np.sum(weights / weights.sum() * late)), not known, reason


def _spin_decay(case: Case) -> Found:
    start, end = case.measured.spin_start, case.measured.spin_end
    if start is None or end is None:
        why = "one reading of the spin in each run; taken at half time it is good to 0.05 % for a fall of 10 %"
        return None, False, why
    readings = "start and end" if case.measured.spin_readings == 2 else "start, half time and end"
    why = f"the harmonic mean in time of {readings} costs nothing, so it is used"
    return whole(case.fit, case.measured.spin / ((start + end) / 2) - 1), True, why


def _decay_law(case: Case) -> Found | None:
    bias = never_corrected(case.measured, case.fit).get("decay_law")
    if bias is None:
        return None
    u = relative_u(case.fit)
    more = "; read the spin at half time as well" if abs(bias) >= DROP_ONE * u else ""
    return bias, False, _why(bias, u, "a viscous decay is assumed, as of an air film", False) + more


def _tilt(case: Case) -> Found:
    measured, u = case.measured, relative_u(case.fit)
    if not np.any(measured.pitch):
        bias = whole(case.fit, tilt_by_run(measured, case.fit, LEVEL_TO))
        return bias, False, _why(bias, u, "no pitch in the log; this is for 2° off level", False)
    bias = whole(case.fit, tilt_by_run(measured, case.fit, measured.pitch))
    equation = "eq. (8)" if case.tilted else "eq. (9)"
    return bias, case.tilted, _why(bias, u, f"{equation} is used{case.asked}", case.tilted)


def _release(case: Case) -> Found:
    if case.measured.motion == "steady":
        premise = "steady, as the log says; this is for a rod let go from rest"
    elif case.released:
        premise = f"the mean rate of a rod let go from rest is used{case.asked}"
    elif case.measured.motion is None:
        premise = 'assumed steady; this is for a rod let go from rest ("# motion: released" in the log)'
    else:
        premise = f"taken for steady precession{case.asked}"
    bias = whole(case.fit, release_by_run(case.measured, case.fit))
    return bias, case.released, _why(bias, relative_u(case.fit), premise, case.released)


def _earth(case: Case) -> Found:
    bias = never_corrected(case.measured, case.fit)["earth"]
    return bias, False, _why(bias, relative_u(case.fit), "at most, at a pole", False)


def _why(bias: float, u: float, premise: str, kept: bool) -> str:
    """Say why an effect was left out or kept, with its size in standard uncertainties."""
    if u == 0:
        return premise
    size = abs(bias) / u
    if kept:
        return f"{premise}: {size:.2g} u"
    verdict = "small enough" if size < DROP_ONE else "NOT small, and the log does not say enough to correct for it"
    return f"{premise}: {size:.2g} u, {verdict}"


class EffectKind(NamedTuple):
    """What is known of an effect before a log is read."""

    name: str
    """Its name in the JSON."""
    words: str
    """What it is called; after a comma, what stands in its place where the model leaves it out."""
    find: Callable[[Case], Found | None]
    """Its size in a log, and what became of it; None where the log has no such effect."""


EFFECTS = (
    EffectKind("residual_torque", "imperfect balance", _residual_torque),
    EffectKind("timing_bias", "timing bias of the hand", _timing_bias),
    EffectKind("spin_decay", "falling spin, plain mean of start and end", _spin_decay),
    EffectKind("decay_law", "law by which the spin falls", _decay_law),
    EffectKind("tilt", "tilted rod, eq. (9) for eq. (8)", _tilt),
    EffectKind("release", "nutation after letting go", _release),
    EffectKind("earth", "the Earth's rotation", _earth),
)
"""Every effect, in the order of the tables."""


def list_effects(
    measured: Measurements, fit: FitResult, tilted: bool, released: bool, asked: bool
) -> tuple[Effect, ...]:
    """List every simplification with its size in this log, and what became of it."""
    case = Case(measured, fit, tilted, released, ", as asked" if asked else "")
    u = relative_u(fit)
    effects = []
    for kind in EFFECTS:
        found = kind.find(case)
        if found is not None:
            bias, kept, reason = found
            effects.append(Effect(kind.name, bias, None if bias is None or not u else abs(bias) / u, kept, reason))
    return tuple(effects)
