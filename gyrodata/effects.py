"""How large each simplification is in a log: the bias of I_zz, in its own standard uncertainties.

Each has a bias in closed form; the log's own numbers go into it, weighted as the fit weights its runs. What is below
0.2 of the standard uncertainty is dropped, smallest first, while all that is dropped stays below 0.3 and the single
runs do not scatter by it; the rest is kept (`model`). Effects of unknown size (M0, b) are parameters of every model.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

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


def list_effects(
    measured: Measurements, fit: FitResult, tilted: bool, released: bool, asked: bool
) -> tuple[Effect, ...]:
    """List every simplification with its size in this log, and what became of it."""
    u = relative_u(fit)
    never = never_corrected(measured, fit)
    effects = [*_unknown_sizes(measured, fit, u), *_decay(measured, fit, never.get("decay_law"), u)]
    words = ", as asked" if asked else ""
    if np.any(measured.pitch):
        tilt = whole(fit, tilt_by_run(measured, fit, measured.pitch))
        reason = _why(tilt, u, f"eq. (8) is used{words}" if tilted else f"eq. (9) is used{words}", tilted)
    else:
        tilt = whole(fit, tilt_by_run(measured, fit, LEVEL_TO))
        reason = _why(tilt, u, "no pitch in the log; this is for 2° off level", False)
    effects.append(_sized("tilt", tilt, u, tilted and bool(np.any(measured.pitch)), reason))
    release = whole(fit, release_by_run(measured, fit))
    premise = {
        True: f"the mean rate of a rod let go from rest is used{words}",
        False: f"taken for steady precession{words}",
    }[released]
    if not released and measured.motion is None:
        premise = 'assumed steady; this is for a rod let go from rest ("# motion: released" in the log)'
    elif measured.motion == "steady":
        premise = "steady, as the log says; this is for a rod let go from rest"
    effects.append(_sized("release", release, u, released, _why(release, u, premise, released)))
    effects.append(_sized("earth", never["earth"], u, False, _why(never["earth"], u, "at most, at a pole", False)))
    return tuple(effects)


def _sized(effect: str, bias: float, u: float, kept: bool, reason: str) -> Effect:
    return Effect(effect, bias, abs(bias) / u if u else None, kept, reason)


def _why(bias: float, u: float, premise: str, kept: bool) -> str:
    """Say why an effect was left out or kept, with its size in standard uncertainties."""
    if u == 0:
        return premise
    size = abs(bias) / u
    if kept:
        return f"{premise}: {size:.2g} u"
    verdict = "small enough" if size < DROP_ONE else "NOT small, and the log does not say enough to correct for it"
    return f"{premise}: {size:.2g} u, {verdict}"


def _unknown_sizes(measured: Measurements, fit: FitResult, u: float) -> list[Effect]:
    """Give the two effects whose size nobody knows beforehand: parameters in every model."""
    weights = (measured.time / fit.time_u) ** 2 * (fit.response != 0)
    weights = weights / weights.sum()
    loaded = measured.torque != 0
    per_run = np.zeros(len(weights))
    per_run[loaded] = physics.imbalance_bias(measured.torque[loaded], fit.imbalance.value)
    prior = f"prior width {fitting.balance_scale(measured, fit.inertia.value):.2g} N*m, with wide tails"
    unknown = "its size is unknown beforehand, so {} is a parameter with {}"
    timing = float(np.sum(weights * physics.timing_bias(measured.time - fit.timing_bias.value, fit.timing_bias.value)))
    if measured.timing_bias_u > 0:
        reason = unknown.format("b", f"prior width {measured.timing_bias_u:g} s")
    else:
        reason = "not a stopwatch's time, or u_time_bias is 0"
    return [
        _sized("residual_torque", float(np.sum(weights * per_run)), u, True, unknown.format("M0", prior)),
        _sized("timing_bias", timing, u, measured.timing_bias_u > 0, reason),
    ]


def _decay(measured: Measurements, fit: FitResult, law: float | None, u: float) -> list[Effect]:
    """Give the fall of the spin while it is timed, and the doubt about its law."""
    if measured.spin_start is None or measured.spin_end is None:
        why = "one reading of the spin in each run; taken at half time it is good to 0.05 % for a fall of 10 %"
        return [Effect("spin_decay", None, None, False, why)]
    plain = whole(fit, measured.spin / ((measured.spin_start + measured.spin_end) / 2) - 1)
    readings = "start, half time and end" if law is None else "start and end"
    why = f"the harmonic mean in time of {readings} costs nothing, so it is used"
    effects = [_sized("spin_decay", plain, u, True, why)]
    if law is not None:
        why = _why(law, u, "a viscous decay is assumed, as of an air film", False)
        if abs(law) >= DROP_ONE * u:
            why += "; read the spin at half time as well"
        effects.append(_sized("decay_law", law, u, False, why))
    return effects
