"""Names of fits, models, uncertainty components and effects, and phrases that several formats share."""

from __future__ import annotations

from gyrodata.changes import CHANGES
from gyrodata.effects import DROP_ONE, Effect
from gyrodata.errors import PICTURES
from gyrodata.measurements import SOURCES
from gyrodata.results import Analysis

FIT_NAMES = {
    "recommended": "recommended",
    "through_origin": "without an intercept",
    "with_constant": "with an intercept",
}

MODEL_NAMES = {
    "horizontal": "eq. (9), a level rod",
    "steady": "eq. (8), a tilted rod",
    "released": "the mean rate of a rod released from rest",
}

SOURCE_NAMES = {key: source.words for key, source in SOURCES.items()} | {
    "residual_torque": "imbalance of the ball, which these runs do not determine",
    "unexplained_scatter": "unexplained scatter",
    "nutation": "nutation at the last button press",
    "release": "transverse inertia, in the nutation",
    "habit": "push of the hand when the rod is released",
    "push": "push of the hand in each run",
}

EFFECT_NAMES = {change.name: change.words for change in CHANGES if change.use == "effect"}


def visible(text: str) -> str:
    """Show control characters as pictures, so that nothing in a log commands the terminal it is printed on."""
    return text.translate(PICTURES)


def effect_verdict(effect: Effect) -> str:
    """Say what became of an effect: "in the model", "in u", "left out", or "left out, and not small"."""
    if effect.kept or effect.in_u:
        return "in the model" if effect.kept else "in u"
    return "left out, and not small" if (effect.size or 0.0) > DROP_ONE else "left out"


def defaults_used(analysis: Analysis) -> list[str]:
    """List the uncertainties that the log does not state: "u_spin_scale 0.1 %"."""
    used = [f"u_{s.name} {s.usual}" for s in analysis.measurements.sources if s.default and s.usual != "0"]
    if analysis.measurements.timed and "u_time_bias" not in analysis.readings.uncertainties:
        used.append(f"u_time_bias {SOURCES['time_bias'].usual}")
    return used
