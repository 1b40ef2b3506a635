"""When a fit is no answer, however small the uncertainty that it gives.

Errors in proportion to what is read let I_zz, all torques and M0 shrink together at little cost, where nothing else
holds their common scale. So a solution has to come to rest, to be positive, and to stay where the readings are; and
the lines of the textbook, which know nothing of all this, have to lie within a factor of 3.
"""

from __future__ import annotations

import numpy as np

from gyrodata.fitting.adjustment import Adjusted
from gyrodata.fitting.conditions import transverse_inertia
from gyrodata.fitting.results import FitResult, NoFit
from gyrodata.fitting.start import torques_differ
from gyrodata.fitting.textbook import ordinary_line
from gyrodata.measurements import Measurements
from gyrodata.physics import Floats

FACTOR = 3.0
"""No answer is further than this from both lines of the textbook."""

ASTRAY = 30.0
"""No fit ends further than this from where a robust start has put it."""

MOVED = 0.2
"""A shared reading that had to be moved by more than this share of itself …"""

MOVED_U = 3.0
"""… and by more than so many of its standard uncertainties was not what was read."""


def insist_on_solution(adjusted: Adjusted, start: float, factor: float) -> None:
    """Accept where an adjustment ended, or raise.

    Parameters
    ----------
    adjusted : Adjusted
        Of n runs.
    start : float
        I_zz that the runs agree on roughly [kg*m^2].
    factor : float
        How far from it the fit may end [1].

    Raises
    ------
    NoFit
        If it did not come to rest, is not positive and finite, is not near the start, or needs readings that were
        not read.
    """
    inertia = float(adjusted.unknowns[0])
    if not (np.isfinite(adjusted.unknowns).all() and np.isfinite(adjusted.covariance).all()):
        raise NoFit("the fit ends in numbers that are not finite")
    if not adjusted.converged:
        raise NoFit("the fit does not come to rest")
    if not inertia > 0:
        raise NoFit("the fit gives a moment of inertia that is not positive")
    if not 1 / factor < inertia / start < factor:
        raise NoFit(f"the fit ends at {inertia:.2g} kg*m^2, where the runs by themselves are near {start:.2g}")
    moved = _moved_most(adjusted)
    if moved is not None:
        raise NoFit(f"the fit holds only if what was read as {moved} is off by more than {100 * MOVED:.0f} %")


def _moved_most(adjusted: Adjusted) -> str | None:
    """Quantity of the shared reading that the fit had to move too far; None if there is none."""
    problem = adjusted.problem
    if not problem.shared_count:
        return None
    error = np.abs(adjusted.shared[problem.to_column])
    source, run = problem.from_source, problem.from_run
    read = np.abs(problem.observed[problem.quantity[source], run])
    size = problem.absolute[source, run] + problem.relative[source, run] * read
    # A pitch of 0 may well be off by more than itself, and I and what it does are guesses.
    measured = np.array([one.quantity not in ("pitch", "transverse", "turns") for one in problem.sources])[source]
    far = measured & (adjusted.kept[run] > 0) & (error > MOVED_U) & (error * size > MOVED * read)
    if not far.any():
        return None
    worst = int(np.argmax(far * error * size / np.maximum(read, 1e-300)))
    name: str = problem.sources[source[worst]].name
    return name.replace("_", " ")


def insist_on_lines(measured: Measurements, fit: FitResult, tilted: bool, kept: Floats) -> None:
    """Accept a fit that lies near a line of the textbook, or raise.

    Parameters
    ----------
    measured : Measurements
        n runs.
    fit : FitResult
        Their fit.
    tilted : bool
        Whether eq. (8) was used.
    kept : ndarray, shape (n,)
        1 for a run with a say that goes with the others, else 0.

    Raises
    ------
    NoFit
        If both lines, corrected for tilt and release, are more than a factor of `FACTOR` away.
    """
    index = np.flatnonzero(kept)
    rate = fit.sense[index] * 2 * np.pi * measured.turns[index] / measured.time[index]
    if measured.slowing is not None:
        rate = rate * measured.slowing[index]
    spin, torque = measured.spin[index], measured.torque[index]
    if tilted:
        # Eq. (8) as a line: M + I φ̇² cosθ against φ̇ (ψ̇ + φ̇ cosθ).
        height = np.sin(measured.pitch[index])
        torque = torque + transverse_inertia(measured)[index] * rate**2 * height
        spin = spin + rate * height
    lines = [ordinary_line(rate * spin, torque, intercept=False)]
    if torques_differ(torque):
        lines.append(ordinary_line(rate * spin, torque, intercept=True))
    slopes = [line.slope.value for line in lines if line is not None]
    if not any(1 / FACTOR < fit.inertia.value / slope < FACTOR for slope in slopes if slope > 0):
        beside = " and ".join(f"{slope:.2g}" for slope in slopes) or "nothing"
        raise NoFit(f"the fit gives {fit.inertia.value:.2g} kg*m^2, and the lines of the textbook {beside}")
