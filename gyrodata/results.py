"""What is said of one log: `Analysis`, and the JSON of the contract that it turns into."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from gyrodata import __version__
from gyrodata.comparisons import Ball, Constancy, Exponent, NamedFit, PowerLaw, Run, Torque
from gyrodata.effects import Effect
from gyrodata.errors import Diagnostic
from gyrodata.fitting import Estimate, FitResult, Outlier, Share
from gyrodata.measurements import Measurements
from gyrodata.model import ChosenModel
from gyrodata.readings import Readings

if TYPE_CHECKING:
    import pandas as pd

SCHEMA = "gyro.analysis/1"

DOF_REASON = "the stated uncertainties are taken as known, so the degrees of freedom are infinite"


CONVENTIONS = {
    "inertia": "least squares in the raw readings (Gauss-Helmert); derivatives and proportional uncertainties at the "
    "adjusted values; u is one standard uncertainty (k = 1) from the stated ones, never scaled by chi-square unless "
    "asked; interval_95 is value ± U, U = k u, or the profile of chi-square where that differs by over 5 %",
    "imbalance": "the torque at work is the applied torque plus M0; M = I_zz φ̇ψ̇ − M0; a balance test may be false: the "
    "answer leans on it, and u holds that doubt",
    "timing_bias": "a stopwatch's reading is the true time plus b",
    "goodness": "chi-square of all readings and priors at the fit; p is the chance of one at least as large; Birge "
    "ratio = sqrt(chi2/dof)",
    "through_origin, with_constant": "ordinary least squares of M on φ̇ψ̇, runs taken as independent; u from the "
    "scatter with n - 1 and n - 2 degrees of freedom",
    "effects": "bias = I_zz without the effect over I_zz with it, minus 1",
    "power_law": "weighted least squares of ln(period) on ln(spin), for each torque; exponent: with one for "
    "all torques; u from each run's own timing and spin, and the hand's bias",
    "product": "weighted mean; u includes what these runs share; p from the scatter about the mean against each run's "
    "own timing and spin; constancy: the same for all torques together",
    "ball": "I_zz beside 2/5 m r² of a solid ball; what has no u in the log is taken as exact",
}
"""Which convention each number follows."""


@dataclass(frozen=True, slots=True)
class Result:
    """A value with its standard uncertainty u (k = 1) and its 95 % interval, value ± k·u."""

    value: float
    u: float | None
    unit: str
    interval_95: tuple[float, float] | None
    k: float | None
    dof: float | None
    interval_by: Literal["linear", "profile"] = "linear"
    """"linear": value ± k·u; "profile": where chi-square has risen by k², used where the two differ by over 5 %."""


@dataclass(frozen=True)
class Analysis:
    """Everything that is said of one log; SI units."""

    name: str
    sha256: str
    options: Mapping[str, Any]
    readings: Readings
    measurements: Measurements
    fit: FitResult
    model: ChosenModel
    """The model that the runs were fitted with."""
    outliers: tuple[Outlier, ...]
    """Runs that look odd, left out or not."""
    inertia: Result
    """I_zz [kg*m^2]."""
    imbalance: Result
    """M0 [N*m]: the torque is m g x + M0."""
    timing_bias: Result
    """b [s]"""
    p: float | None
    """Probability of a chi-square at least as large; None without degrees of freedom."""
    birge: float | None
    """√(chi-square/dof): shown, not applied unless asked."""
    birge_applied: bool
    """True if u of the recommended fit was multiplied by it, as asked."""
    fits: tuple[NamedFit, ...]
    budget: tuple[Share, ...]
    effects: tuple[Effect, ...]
    power_law: tuple[PowerLaw, ...]
    exponent: Exponent | None
    """None where no torque has runs at different spins."""
    constancy: Constancy | None
    """None where no torque has two runs."""
    ball: Ball | None
    """None where the log does not give the ball's mass and diameter."""
    torques: tuple[Torque, ...]
    run_table: tuple[Run, ...]
    advice: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...] = field(default=())

    @property
    def runs(self) -> pd.DataFrame:
        """One row for each run, SI units, as a DataFrame."""
        import pandas as pd

        return pd.DataFrame([{name: getattr(run, name) for name in Run.__slots__} for run in self.run_table])

    def to_dict(self) -> dict[str, Any]:
        """Give the analysis as the JSON contract has it (schema "gyro.analysis/1")."""
        result = {
            "inertia": _result_dict(self.inertia),
            "imbalance": _result_dict(self.imbalance),
            "timing_bias": _result_dict(self.timing_bias),
            "goodness": self._goodness(),
            "fits": [_fit_dict(fit) for fit in self.fits],
            "budget": [
                {
                    "source": share.source,
                    "shared": share.shared,
                    "shared_by": share.shared_by,
                    "u_inertia": share.u_inertia,
                    "share": share.share,
                }
                for share in self.budget
            ],
            "constants": {"g": self.measurements.g, **self.readings.constants},
            "model": self.model.name,
            "effects": [_slots(effect) for effect in self.effects],
            "power_law": [_slots(law) for law in self.power_law],
            "exponent": None if self.exponent is None else _slots(self.exponent),
            "constancy": None if self.constancy is None else _slots(self.constancy),
            "ball": None if self.ball is None else _slots(self.ball),
            "torques": [
                {
                    "mass": group.mass,
                    "position": group.position,
                    "torque": group.torque,
                    "runs": group.runs,
                    "without": None if group.without is None else _slots(group.without),
                    "product": {
                        "value": group.product,
                        "u": group.product_u,
                        "spread": group.product_spread,
                        "p": group.product_p,
                    },
                    "period_per_spin": {"value": group.period_per_spin, "u": group.period_per_spin_u},
                }
                for group in self.torques
            ],
            "runs": [_slots(run) for run in self.run_table],
            "uncertainties": [
                {
                    "source": source.name,
                    "shared_by": source.shared_by,
                    "default": source.default,
                    "is": source.described,
                }
                for source in self.measurements.sources
            ],
            "advice": list(self.advice),
            "conventions": CONVENTIONS,
        }
        return envelope(self.name, self.sha256, len(self.run_table), self.options, result, self.diagnostics)

    def _goodness(self) -> dict[str, Any]:
        goodness: dict[str, Any] = {"chi2": self.fit.chi2, "dof": self.fit.dof, "p": self.p, "birge": self.birge}
        goodness["birge_applied"] = self.birge_applied
        if self.p is None:
            goodness["reason"] = "no degrees of freedom: as many unknowns as runs"
        return goodness


def envelope(
    name: str,
    sha256: str | None,
    rows: int | None,
    options: Mapping[str, Any],
    result: dict[str, Any] | None,
    diagnostics: tuple[Diagnostic, ...],
) -> dict[str, Any]:
    """Put a result, or None, into the object that every output of the tool is.

    Parameters
    ----------
    name : str
        Name of the log, without its folder.
    sha256 : str or None
        Of its bytes; None where it could not be read.
    rows : int or None
        Number of runs read.
    options : mapping
        What was asked for.
    result : dict or None
        None when the log cannot be analysed; the diagnostics say why.
    diagnostics : tuple of Diagnostic
        In the order of the file.

    Returns
    -------
    dict
    """
    return {
        "schema": SCHEMA,
        "tool": {"name": "gyrodata", "version": __version__},
        "input": {"name": name, "sha256": sha256, "rows": rows},
        "options": dict(options),
        "result": result,
        "diagnostics": [diagnostic.to_dict() for diagnostic in diagnostics],
    }


def _slots(item: Any) -> dict[str, Any]:
    return {name: getattr(item, name) for name in item.__slots__}


def _result_dict(result: Result) -> dict[str, Any]:
    out = _slots(result)
    out["U"] = result.k * result.u if result.k is not None and result.u is not None else None
    out["relative_u"] = abs(result.u / result.value) if result.u is not None and result.value else None
    out["level"] = 0.95
    out["interval_95"] = list(result.interval_95) if result.interval_95 else None
    if result.dof is None:
        out["dof_reason"] = DOF_REASON
    return out


def _fit_dict(fit: NamedFit) -> dict[str, Any]:
    def estimate(value: Estimate | None, unit: str) -> dict[str, Any] | None:
        return None if value is None else {"value": value.value, "u": value.u, "unit": unit}

    return {
        "name": fit.name,
        "inertia": estimate(fit.inertia, "kg*m^2"),
        "constant": estimate(fit.constant, "N*m"),
        "note": fit.note,
        "difference": fit.difference,
        "deviation": fit.deviation,
    }
