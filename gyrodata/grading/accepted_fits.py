"""What a student's own runs give: every fit that a course accepts, and what a slip would make of each.

A report is held against the student's own data, and there is more than one right way to work them out: a line
through the origin, a line with a constant, the mean of M/(φ̇ψ̇), or this tool's fit; with every run, or without
those that were miscounted; with or without the run that has no weight. Each is worked out here, for many slips in
one go, from the readings with the slip applied to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrodata import fitting
from gyrodata.physics import Floats
from gyrodata.results import Analysis

FIT_WORDS = {
    "through_origin": "a line through the origin",
    "with_constant": "a line with a constant",
    "mean_of_ratios": "the mean of M/(φ̇ψ̇)",
    "recommended": "the recommended fit",
}

SET_WORDS = {"all": ", every run in it", "loaded": ", runs with a weight only"}

FINEST, COARSEST = 0.005, 0.05
"""Least and largest u, as a share of I_zz, that a report is measured with. Two careful people who round their
intermediate results to three digits differ by up to 0.5 %; and where the runs leave I_zz wide open, arithmetic on
them is still arithmetic."""


@dataclass(frozen=True, slots=True)
class OwnValue:
    """I_zz by one fit of the student's own runs."""

    name: str
    """Of `FIT_WORDS`, with ":all" or ":loaded" behind it where it is of other runs than the analysis keeps."""
    value: float
    """[kg*m^2]"""
    u: float | None
    """As this fit itself gives it [kg*m^2]; None where it has none."""

    @property
    def words(self) -> str:
        """Which fit it is, in words."""
        return fit_words(self.name)


def fit_words(name: str) -> str:
    """Say which fit of which runs it is: "a line with a constant, every run in it"."""
    fit, _, runs = name.partition(":")
    return FIT_WORDS[fit] + SET_WORDS.get(runs, "")


@dataclass(frozen=True)
class OwnRuns:
    """The runs of one log as the textbook fits need them, n runs."""

    product: Floats
    """φ̇ψ̇ with the torque's sign [rad²/s²], shape (n,)."""
    torque: Floats
    """[N*m], shape (n,)."""
    sets: tuple[tuple[str, NDArray[np.bool_]], ...]
    """Which runs are used, each shape (n,): those that the analysis keeps (""), all, those with a weight."""
    accept: tuple[str, ...]
    """Fits that the course accepts."""
    recommended: OwnValue
    yardstick: float
    """One unit of d, as a share of I_zz [1]."""

    def fits(self, product: Floats, torque: Floats) -> list[tuple[str, Floats, Floats]]:
        """Work out the accepted textbook fits for c changed tables at once.

        `product`, `torque`: shape (c, n): φ̇ψ̇ [rad²/s²] and M [N*m] of each table. Gives: Name, values and
        uncertainties [kg*m^2], shape (c,); NaN where a fit has none.
        """
        found = []
        for suffix, used in self.sets:
            x, y = product[:, used], torque[:, used]
            for name in self.accept:
                if name == "recommended" or (name == "mean_of_ratios" and suffix == "loaded"):
                    continue
                if name == "with_constant" and not fitting.torques_differ(self.torque[used]):
                    continue
                with np.errstate(all="ignore"):
                    value, u = fitting.TEXTBOOK[name](x, y)
                found.append((f"{name}:{suffix}" if suffix else name, value, u))
        return found

    def values(self) -> tuple[OwnValue, ...]:
        """Give every accepted fit of the runs as they are, the rubric's order kept and equal ones once.

        Where none of them is possible (a constant, and one torque only), it is the recommended fit.
        """
        found = [
            OwnValue(name, float(value[0]), float(u[0]) if np.isfinite(u[0]) else None)
            for name, value, u in self.fits(self.product[None, :], self.torque[None, :])
            if np.isfinite(value[0])
        ]
        if "recommended" in self.accept:
            found.append(self.recommended)
        found.sort(key=lambda own: (":" in own.name, self.accept.index(own.name.partition(":")[0])))
        kept: list[OwnValue] = []
        for own in found:
            if not any(abs(own.value - other.value) <= 1e-9 * abs(own.value) for other in kept):
                kept.append(own)
        return tuple(kept) or (self.recommended,)


def own_runs(analysis: Analysis, accept: Sequence[str]) -> OwnRuns:
    """Take from an analysis what a report is compared with."""
    measured = analysis.measurements
    every = np.ones(len(measured.runs), dtype=bool)
    kept = np.array([not run.left_out for run in analysis.run_table])
    sets = [("", kept)]
    if not kept.all():
        sets.append(("all", every))
    loaded = kept & (measured.torque != 0)
    if not np.array_equal(loaded, kept):
        sets.append(("loaded", loaded))
    inertia = analysis.inertia
    share = (inertia.u or 0.0) / abs(inertia.value)
    return OwnRuns(
        product=analysis.fit.sense * np.abs(measured.product),
        torque=measured.torque,
        sets=tuple(sets),
        accept=tuple(accept),
        recommended=OwnValue("recommended", inertia.value, inertia.u or None),
        yardstick=min(max(share, FINEST), COARSEST),
    )


def nearest(values: Sequence[OwnValue], reported: float) -> OwnValue:
    """Find the fit that a reported value comes nearest to, the earlier of two equally near.

    `reported` [kg*m^2].
    """
    return min(values, key=lambda own: abs(own.value - reported))


def distance(reported: float, own: float, step: float, yardstick: float) -> float:
    """Tell how far a reported value lies from one of the student's own runs, in units of u.

    `reported`, `own` [kg*m^2]. `step`: One step of the last digit reported [kg*m^2]: half of it is rounding, and costs
    nothing. `yardstick`: u as a share of the value [1].
    """
    # A value rounded to nothing is no value.
    rounding = step / 2 * (1 + 1e-9) if reported else 0.0
    return max(0.0, abs(reported - own) - rounding) / (yardstick * abs(own))
