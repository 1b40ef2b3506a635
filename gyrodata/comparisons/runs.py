"""Each run: what was read, what was made of it, and why it looks odd."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gyrodata.fitting import FitResult, Outlier
from gyrodata.measurements import Measurements


@dataclass(frozen=True, slots=True)
class Run:
    """One timed run."""

    run: str
    line: int
    mass: float | None
    position: float | None
    torque: float
    spin: float
    time: float
    turns: float
    precession_rate: float
    period: float
    product: float
    inertia: float | None
    residual: float
    """Time minus fitted time [s]."""
    residual_u: float
    """Standard uncertainty expected of it from what this run has alone [s]."""
    deviation: float | None
    """Time minus what the other runs predict, in standard uncertainties; None where they cannot tell."""
    influence: float
    """Change of I_zz if this run were left out [kg*m^2]; 0 where it is."""
    flagged: bool
    left_out: bool
    reason: str


def run_table(
    measured: Measurements, fit: FitResult, outliers: tuple[Outlier, ...], left_out: tuple[int, ...]
) -> tuple[Run, ...]:
    """Put what was read and what was made of it side by side for each run.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their recommended fit.
    outliers : tuple of Outlier
        Those that look odd.
    left_out : tuple of int
        Indices of the runs that have no say.

    Returns
    -------
    tuple of Run
    """
    reasons = {outlier.index: outlier_reason(measured, outlier) for outlier in outliers}
    product = fit.sense * np.abs(measured.product)
    rate = 2 * np.pi * measured.turns / measured.time
    return tuple(
        Run(
            run=measured.runs[i],
            line=measured.lines[i],
            mass=or_none(measured.mass[i]),
            position=or_none(measured.position[i]),
            torque=float(measured.torque[i]),
            spin=float(measured.spin[i]),
            time=float(measured.time[i]),
            turns=float(measured.turns[i]),
            precession_rate=float(fit.sense[i] * rate[i]),
            period=float(measured.time[i] / measured.turns[i]),
            product=float(product[i]),
            inertia=float(measured.torque[i] / product[i]) if measured.torque[i] else None,
            residual=float(measured.time[i] - fit.fitted_time[i]),
            residual_u=float(fit.time_u[i]),
            deviation=or_none(fit.deviations[i]),
            influence=float(fit.influence[i]),
            flagged=i in reasons,
            left_out=i in left_out,
            reason=reasons.get(i, ""),
        )
        for i in range(len(measured.runs))
    )


def or_none(value: float) -> float | None:
    """Give None for what was not read."""
    return None if math.isnan(value) else float(value)


def outlier_reason(measured: Measurements, outlier: Outlier) -> str:
    """Say why a run looks odd: the count that fits it, or how far off it is.

    Parameters
    ----------
    measured : Measurements
        n runs.
    outlier : Outlier
        One of them.

    Returns
    -------
    str
    """
    written = measured.turns[outlier.index]
    if outlier.turns is not None:
        return f"fits {turn_words(outlier.turns)}, not {turn_words(written).split(' ')[0]}"
    side = "longer" if outlier.deviation > 0 else "shorter"
    return f"its time is {abs(outlier.deviation):.0f} standard uncertainties {side} than the other runs say"


def turn_words(turns: float) -> str:
    """Write a number of turns as a student would: "1/3 turn", "2 turns".

    Parameters
    ----------
    turns : float
        Revolutions, > 0.

    Returns
    -------
    str
    """
    from fractions import Fraction

    near = Fraction(turns).limit_denominator(12)
    text = str(near) if abs(near - turns) < 1e-6 * turns else f"{turns:.4g}"
    return f"{text} turn" if turns <= 1 else f"{text} turns"
