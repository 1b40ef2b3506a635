"""What the fits give back, and when a fit is no answer, however small the uncertainty that it gives.

Errors in proportion to what is read let I_zz, all torques and M0 shrink together at little cost, where nothing else
holds their common scale. So a solution has to come to rest, to be positive, and to stay where the readings are; and
the lines of the textbook, which know nothing of all this, have to lie within a factor of 3 (`textbook`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gyrodata.fitting.adjustment import Adjusted
from gyrodata.fitting.posterior import Posterior
from gyrodata.physics import Floats


class NoFit(Exception):  # noqa: N818 - like StopIteration, what came of it and not a fault
    """The runs have no answer that can be believed; its text says why, for a student."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with its standard uncertainty (k = 1)."""

    value: float
    u: float | None
    """None where nothing tells it; the reason is in the note of its fit."""
    interval_95: tuple[float, float] | None = None
    """Where it is not value ± 1.96 u."""


@dataclass(frozen=True, slots=True)
class Share:
    """What one source of uncertainty contributes to u(I_zz)."""

    source: str
    shared: bool
    shared_by: str
    u_inertia: float
    """[kg*m^2]"""
    share: float
    """Of the variance [1]; the shares of a budget add up to 1."""


@dataclass(frozen=True, slots=True)
class Outlier:
    """A run that does not go with the others."""

    index: int
    deviation: float
    """Of its time from what the other runs predict, in standard uncertainties of that difference."""
    turns: float | None
    """Number of revolutions that would explain it."""
    slip: bool
    """True if it is no measurement of this motion: a count explains it, or it is off beyond all doubt."""


@dataclass(frozen=True)
class FitResult:
    """The adjusted unknowns of one log of n runs.

    Convention: Gauss–Helmert least squares in the raw readings; derivatives and proportional uncertainties at
    the adjusted values; standard uncertainties from the stated ones, not scaled by chi-square.
    """

    inertia: Estimate
    """I_zz [kg*m^2]."""
    imbalance: Estimate
    """M0 [N*m]: the torque is M + M0."""
    timing_bias: Estimate
    """b [s]: a clock reading is the true time plus b."""
    covariance: Floats
    """Of (I_zz, M0, b), shape (3, 3)."""
    chi2: float
    dof: int
    fitted_time: Floats
    """Time that the fit predicts for each run [s], shape (n,)."""
    time_u: Floats
    """Standard uncertainty of a run's time about the fit, from the errors that it has alone [s], shape (n,)."""
    deviations: Floats
    """Time minus what the *other* runs predict, over the standard uncertainty of that difference, shape (n,)."""
    influence: Floats
    """Change of I_zz when one run is left out, to first order [kg*m^2]; 0 for a run that is, shape (n,)."""
    response: Floats
    """Relative change of I_zz for a relative change of each run's own M/(φ̇ψ̇) [1], shape (n,)."""
    budget: tuple[Share, ...]
    balance_u: float
    """Width of M0 with which the runs were adjusted [N*m]."""
    scatter: float
    """Factor on the errors that a run has alone with which they were [1]."""
    contradicted_balance: float | None
    """Width [N*m] that a balance test allowed M0 where the data contradict it, and so were left alone; or None."""
    two_signs: bool
    """True if the log leaves the sign of M0 open and both are in the answer."""
    sense: Floats
    """Sign of φ̇ψ̇ used for each run, shape (n,)."""
    adjusted: Adjusted
    """Where the adjustment ended; of two possible answers the likelier."""
    posterior: Posterior | None
    """The answer as a mixture; None of a fit at one width."""


FACTOR = 3.0
"""No answer is further than this from both lines of the textbook."""

ASTRAY = 30.0
"""No fit ends further than this from where a robust start has put it."""

MOVED = 0.2
"""A shared reading that had to be moved by more than this share of itself …"""

MOVED_U = 3.0
"""… and by more than so many of its standard uncertainties was not what was read."""


def insist_on_solution(adjusted: Adjusted, start: float, factor: float) -> None:
    """Accept where an adjustment ended, near its start [kg*m^2] by a factor, or raise `NoFit`."""
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
