"""What fits, models, sources and effects are called, and the sentences that several forms share."""

from __future__ import annotations

from collections.abc import Mapping

from gyrodata.comparisons import NamedFit
from gyrodata.effects import DROP_ONE, Effect
from gyrodata.errors import PICTURES
from gyrodata.fitting import Share
from gyrodata.reporting.values import Scale, count_text, p_text, percent_text, torque_scale
from gyrodata.results import Analysis, Result

FIT_NAMES = {
    "recommended": "recommended",
    "through_origin": "through the origin",
    "with_constant": "with a constant",
}


MODEL_NAMES = {
    "horizontal": "eq. (9), a level rod",
    "steady": "eq. (8), a tilted rod",
    "released": "the mean rate of a rod let go from rest",
}


SOURCE_NAMES = {
    "time": "stopwatch",
    "time_bias": "hand's bias",
    "spin": "tachometer readings",
    "spin_scale": "tachometer scale",
    "mass": "each weight's mass",
    "mass_scale": "scale",
    "position": "position readings",
    "position_zero": "ruler's zero",
    "force": "force",
    "torque": "torque",
    "g": "g",
    "residual_torque": "residual torque (prior)",
    "residual_torque_sign": "unknown sense of the unloaded run",
    "balance_doubt": "doubt about the balance test",
    "precession_rate": "precession rate",
    "angle": "swept angle",
    "pitch": "pitch",
    "transverse_inertia": "transverse inertia",
    "nutation": "nutation at the last click",
    "release": "transverse inertia, in the nutation",
}


EFFECT_NAMES = {
    "residual_torque": "imperfect balance",
    "timing_bias": "late or early hand",
    "spin_decay": "falling spin, plain mean of start and end",
    "decay_law": "law by which the spin falls",
    "tilt": "tilted rod, eq. (9) for eq. (8)",
    "release": "nutation after letting go",
    "earth": "the Earth's rotation",
}


def visible(text: str) -> str:
    """Show control characters as pictures, so that nothing in a log commands the terminal it is printed on."""
    return text.translate(PICTURES)


def common_torque_scale(analysis: Analysis) -> Scale:
    """Choose one unit for every torque of a log, so that they can be compared at a glance."""
    return torque_scale(max(abs(run.torque) for run in analysis.run_table))


def size_of_log(analysis: Analysis) -> str:
    """Count runs and torques: "10 runs, 4 torques"."""
    return f"{count_text(len(analysis.run_table), 'run')}, {count_text(len(analysis.torques), 'torque')}"


def goodness_text(analysis: Analysis) -> str:
    """Write how well the runs go together."""
    fit = analysis.fit
    if analysis.p is None or analysis.birge is None:
        return "goodness: as many unknowns as runs, so nothing tells how well they fit"
    return (
        f"goodness: chi-square {fit.chi2:.3g} for {count_text(fit.dof, 'degree')} of freedom, {p_text(analysis.p)} "
        f"(Birge ratio {analysis.birge:.2f})"
    )


def interval_kind(result: Result) -> str:
    """Say how an interval was found: "u × k, k = 1.96"."""
    return f"u × k, k = {result.k:.2f}"


def difference_text(analysis: Analysis, fit: NamedFit) -> str:
    """Say how far a fit lies from the recommended one, in its u and in per cent."""
    if fit.inertia is None or fit.name == "recommended" or not analysis.inertia.u:
        return ""
    difference = fit.inertia.value - analysis.inertia.value
    return f"{difference / analysis.inertia.u:+.1f} u ({percent_text(difference / analysis.inertia.value)})"


def effect_verdict(effect: Effect) -> str:
    """Say whether an effect is in the model: "in the model", "left out", or "left out, and not small"."""
    if effect.kept:
        return "in the model"
    return "left out, and not small" if (effect.size or 0.0) > DROP_ONE else "left out"


def shared_text(share: Share) -> str:
    """Say which runs have an error in common."""
    return f"shared by {share.shared_by}" if share.shared else "each run its own"


def defaults_used(analysis: Analysis) -> list[str]:
    """List the uncertainties that the log does not state: "u_spin_scale 0.1 %"."""
    used = [f"u_{s.name} {s.usual}" for s in analysis.measurements.sources if s.default and s.usual != "0"]
    if analysis.measurements.timed and "u_time_bias" not in analysis.readings.uncertainties:
        used.append("u_time_bias 0.05 s")
    return used


def size_text(size: float) -> str:
    """Write the size of an effect in standard uncertainties of I_zz: "0.70 u"."""
    return f"{size:.2f} u" if size < 10 else f"{size:.0f} u"


def option_text(value: object) -> str:
    """Write what was asked for by an option: "yes", "none", "turns = 1"."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} = {item}" for key, item in value.items()) or "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "none" if value is None else str(value)
