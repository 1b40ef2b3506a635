"""The table of the sources of error, with the default of each.

A source is one section of `error_sources.toml`, and a computation in
`measurements.sources`. Its key in a log, its line in the budget, its words and its
advice follow from the section.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from msgspec import Struct, convert
from msgspec.structs import replace

from gyrodata.quantities.units import Uncertainty

Quantity = Literal[
    "time",
    "spin",
    "mass",
    "position",
    "force",
    "torque",
    "g",
    "turns",
    "pitch",
    "transverse",
    "added",
    "balance",
]


class SourceKind(Struct, frozen=True):
    """An uncertainty component, before a log is read."""

    quantity: Quantity
    """The quantity that has the error."""
    default: Uncertainty
    """Standard uncertainty if the log does not state it; the rounding of a reading is
    added."""
    usual: str
    """The same in words."""
    shared_by: str = ""
    """In words; "" if every run has its own error."""
    better: str = ""
    """How to make it half as large next time, in words; "" if nobody can."""
    words: str = ""
    """Its name for users: "ruler's zero"."""
    kind: str = ""
    """Kind of its quantity in a log if it does not belong to a column: "length"; "" for
    the error of a column."""


DECAY_TIME = 1000.0
DECAY_SPREAD = math.log(2)
"""Time [s] in which the spin falls by 1/e if the log does not show it, and the standard
deviation of its logarithm. The 13 runs of a published air ball (Heidelberg) have 714 to
1315 s, with a median of 1047 s."""

LATE = 2.0
"""How long after the midpoint of a run the spin is read [s]: a judgement."""

NORMAL_GRAVITY_U = Uncertainty(0.0, 0.0001)
"""Relative uncertainty of g if the log states the latitude: 300 m of height, or dense
rock below."""

WHOLE = 0.005
"""A number of turns [1] this close to a whole number counts as whole."""

SOURCES: Mapping[str, SourceKind] = {
    key: replace(source, usual=source.usual.format(late=LATE, time=DECAY_TIME))
    for key, source in convert(
        tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")),
        dict[str, SourceKind],
    ).items()
}
"""The sources by the key of the log without its ``u_``, in the order of the table in
the documentation."""

DEFAULT_TRANSVERSE_RATIO = 1.3
"""I/I_zz of a ball with a light rod, if the log does not state I …"""

TRANSVERSE_U = 0.2
"""… and its relative standard uncertainty then."""
