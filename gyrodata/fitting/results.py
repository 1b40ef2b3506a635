"""What the fits give back: estimates, shares of the uncertainty, odd runs, and the whole of one log's fit."""

from __future__ import annotations

from dataclasses import dataclass

from gyrodata.fitting.adjustment import Adjusted
from gyrodata.physics import Floats


class NoFit(Exception):  # noqa: N818 - like StopIteration, what came of it and not a fault
    """The runs have no answer that can be believed; its text says why, for a student."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with its standard uncertainty (k = 1)."""

    value: float
    u: float | None
    """None where nothing tells it; the reason is in the note of its fit."""


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
    imbalance_prior: float
    """Prior width of M0 that was used [N*m]."""
    imbalance_free: bool
    """True if the data alone tell M0."""
    contradicted_balance: float | None
    """Width [N*m] that a balance test allowed M0 where the data contradict it, and so were left alone; or None."""
    two_signs: bool
    """True if the log leaves the sign of M0 open and both are in the answer."""
    sense: Floats
    """Sign of φ̇ψ̇ used for each run, shape (n,)."""
    adjusted: Adjusted
    """Where the adjustment ended; of two possible answers the likelier."""
    widened: float
    """Factor on the uncertainties of the times [1]: 1 but where the runs contradict each other beyond all measure."""
