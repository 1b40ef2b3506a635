"""Other fits beside the recommended one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gyrodata import fitting
from gyrodata.fitting import Estimate, FitResult
from gyrodata.measurements import Measurements


@dataclass(frozen=True, slots=True)
class NamedFit:
    """One way to fit the log, for comparison."""

    name: str
    """"through_origin", "with_constant" or "recommended"."""
    inertia: Estimate | None
    """[kg*m^2]; None where this fit is not possible."""
    constant: Estimate | None
    """Constant of the line M = I_zz φ̇ψ̇ + constant [N*m], which is −M0."""
    note: str
    """What it is, or why it is not possible."""
    difference: float | None = None
    """I_zz over the recommended one, minus 1; None for the recommended fit and for one that is not possible."""
    deviation: float | None = None
    """The same in standard uncertainties of the recommended fit."""


def named_fits(measured: Measurements, fit: FitResult, kept: list[int], scaled: bool) -> tuple[NamedFit, ...]:
    """The two straight lines of the textbook beside the recommended fit.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their recommended fit.
    kept : list of int
        Indices of the runs that have a say.
    scaled : bool
        Whether the recommended fit was scaled by the Birge ratio.

    Returns
    -------
    tuple of NamedFit
    """
    index = np.array(kept)
    product = fit.sense[index] * np.abs(measured.product[index])
    torque = measured.torque[index]
    textbook = "least squares of M on φ̇ψ̇, {}; u from the scatter, runs taken as independent"
    origin = fitting.ordinary_line(product, torque, intercept=False)
    line = fitting.ordinary_line(product, torque, intercept=True) if fitting.torques_differ(torque) else None
    if line is not None:
        constant = NamedFit("with_constant", line.slope, line.intercept, textbook.format("with a constant"))
    else:
        reason = (
            "not possible: a line with a constant needs at least two different points"
            if len(kept) < 2
            else "not possible: all torques are equal, so a slope and a constant cannot be told apart; "
            "add runs with another weight or position"
        )
        constant = NamedFit("with_constant", None, None, reason)
    note = textbook.format("through the origin")
    if len(kept) == 1:
        note += "; one run has no scatter, so no u"
    return (
        NamedFit(
            "recommended",
            fit.inertia,
            Estimate(-fit.imbalance.value, fit.imbalance.u),
            "all raw readings together; shared errors carried as shared; M0 and timing bias as unknowns; u from the "
            "stated uncertainties, "
            + ("multiplied by the Birge ratio, as asked" if scaled else "not scaled by chi-square"),
        ),
        _beside(NamedFit("through_origin", origin.slope if origin else None, None, note), fit.inertia),
        _beside(constant, fit.inertia),
    )


def _beside(other: NamedFit, recommended: Estimate) -> NamedFit:
    """Say how far another fit lies from the recommended one."""
    if other.inertia is None:
        return other
    difference = other.inertia.value - recommended.value
    deviation = difference / recommended.u if recommended.u else None
    return replace(other, difference=difference / recommended.value, deviation=deviation)
