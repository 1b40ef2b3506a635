"""The table of the sources of error, with the default of each.

A source is one record here, and a computation in `measurements.sources`. Its key in a log, its line in the budget, its
words and its advice follow from the record.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

from msgspec import Struct

from gyrodata.units import Uncertainty

Quantity = Literal["time", "spin", "mass", "position", "force", "torque", "g", "turns", "pitch", "transverse", "added"]


class SourceKind(Struct, frozen=True):
    """An uncertainty component, before a log is read."""

    quantity: Quantity
    """The quantity that has the error."""
    default: Uncertainty
    """Standard uncertainty if the log does not state it; the rounding of a reading is added."""
    usual: str
    """The same in words."""
    shared_by: str = ""
    """In words; "" if every run has its own error."""
    better: str = ""
    """How to make it half as large next time, in words; "" if nobody can."""
    words: str = ""
    """Its name for users: "ruler's zero"."""
    kind: str = ""
    """Kind of its quantity in a log if it does not belong to a column: "length"; "" for the error of a column."""


DECAY_TIME, DECAY_SPREAD = 1000.0, math.log(2)
"""Time [s] in which the spin falls by 1/e if the log does not show it, and the standard deviation of its logarithm. The
13 runs of a published air ball (Heidelberg) have 714 to 1315 s, with a median of 1047 s."""

LATE = 2.0
"""How long after the midpoint of a run the spin is read [s]: a judgement."""

NORMAL_GRAVITY_U = Uncertainty(0.0, 0.0001)
"""Relative uncertainty of g if the log states the latitude: 300 m of height, or dense rock below."""

WHOLE = 0.005
"""A number of turns [1] this close to a whole number counts as whole."""

SOURCES: Mapping[str, SourceKind] = {
    "precession_rate": SourceKind("time", Uncertainty(0.0, 0.01), "1 % and rounding", words="precession rate"),
    "time": SourceKind("time", Uncertainty(0.14), "0.14 s (0.1 s per press) and rounding", words="stopwatch readings"),
    # One press is 0.11 s late, with a standard deviation of 0.07 s: "Manual timing in physics experiments: error and
    # uncertainty", Am. J. Phys. 87, 110 (2019). Two presses are late by the same time, which cancels. A hand that
    # releases the rod and starts the clock together is late at the end only. Half of all labs do either: 0.11 s/√2.
    "time_bias": SourceKind(
        "time", Uncertainty(0.08), "0.08 s", "all runs (the same hand)", words="timing bias", kind="time"
    ),
    # √2 degrees in turns: one at the start, one at the end.
    "angle": SourceKind(
        "turns",
        Uncertainty(math.sqrt(2) / 360),
        "1° at each end of a part of a turn",
        "",
        "the rod sighted to half a degree (or whole turns timed, which end where they began)",
        words="sighting of the rod",
    ),
    "spin": SourceKind(
        "spin",
        Uncertainty(0.0, 0.002),
        "0.2 % a reading and rounding",
        "runs with the same reading",
        "the spin as the mean of four readings",
        words="tachometer readings",
    ),
    "spin_scale": SourceKind(
        "spin",
        Uncertainty(0.0, 0.001),
        "0.1 %",
        "all runs (one tachometer)",
        "a tachometer checked to half its error",
        words="tachometer scale",
        kind="rate",
    ),
    "spin_delay": SourceKind(
        "spin",
        Uncertainty(1.7),
        f"{LATE:g} s late ± 1.7 s, in a spin that falls by 1/e in {DECAY_TIME:g} s, within a factor of 2",
        "all runs (the same habit)",
        'a spin-down in the log, such as "# spin_down: 612 rpm to 540 rpm in 120 s"',
        words="delay of the spin reading while the ball slows down",
        kind="time",
    ),
    "decay_exponent": SourceKind(
        "spin",
        Uncertainty(0.8),
        "an exponent of 1 ± 0.8 before the readings of the spin: an air film has 1, dry friction 0, turbulence 2",
        "all runs (the same drag)",
        "the spin read at the midpoint as well",
        words="decay law of the spin",
        kind="number",
    ),
    "mass": SourceKind(
        "mass",
        Uncertainty(0.0, 0.002),
        "0.2 % and rounding",
        "runs with the same weight",
        "weights weighed twice as well (write every digit that the scale shows)",
        words="each weight's mass",
    ),
    "mass_scale": SourceKind(
        "mass",
        Uncertainty(0.0, 0.0005),
        "0.05 %",
        "all runs (one scale)",
        "a scale checked to half its error",
        words="scale for the masses",
        kind="mass",
    ),
    "force": SourceKind(
        "force",
        Uncertainty(0.0, 0.002),
        "0.2 % and rounding",
        "runs with the same force",
        "forces known twice as well",
        words="force",
    ),
    "torque": SourceKind(
        "torque",
        Uncertainty(0.0, 0.005),
        "0.5 % and rounding",
        "runs with the same torque",
        "torques known twice as well",
        words="torque",
    ),
    "position": SourceKind(
        "position",
        Uncertainty(),
        "rounding",
        "runs with the same position",
        "positions read twice as well",
        words="position readings",
    ),
    "position_zero": SourceKind(
        "position",
        Uncertainty(0.001),
        "1 mm",
        "all runs (one ruler, one zero)",
        "the ruler's zero twice as well known (measure the arm from both ends)",
        words="ruler's zero",
        kind="length",
    ),
    "g": SourceKind("g", Uncertainty(0.0, 0.001), "0.1 %", "all runs", words="g", kind="acceleration"),
    "weight_diameter": SourceKind(
        "added", Uncertainty(), "0", "runs with the same weight", words="diameter of the weight"
    ),
    "pitch": SourceKind("pitch", Uncertainty(math.radians(2)), "2° and rounding", words="pitch"),
    "transverse_inertia": SourceKind(
        "transverse", Uncertainty(0.0, 0.02), "2 %", "all runs", words="transverse inertia"
    ),
}
"""The sources by the key of the log without its ``u_``, in the order of the table in the documentation."""

DEFAULT_TRANSVERSE_RATIO = 1.3
"""I/I_zz of a ball with a light rod, if the log does not state I …"""

TRANSVERSE_U = 0.2
"""… and its relative standard uncertainty then."""
