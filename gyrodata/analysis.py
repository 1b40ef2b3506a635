"""The story on one page: readings → measurements → which effects matter → fit → `Analysis`.

`analyze` is the whole tool without its printing. What it returns is frozen, in SI units, and knows how to turn
itself into the JSON of the contract; `reporting` and `plotting` only put it into other words.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, BinaryIO, Literal, TextIO

import numpy as np

from gyrodata import __version__, effects, fitting
from gyrodata.comparisons import (
    Ball,
    Constancy,
    Exponent,
    NamedFit,
    PowerLaw,
    Run,
    Torque,
    compare_with_ball,
    constancy,
    named_fits,
    overall_exponent,
    power_laws,
    run_table,
    torque_table,
)
from gyrodata.effects import Effect, Model, Rung
from gyrodata.errors import Diagnostic, LogError
from gyrodata.findings import G413, G415, G416, list_advice, outlier_findings, whole_findings
from gyrodata.fitting import Estimate, FitResult, Outlier, Share
from gyrodata.fitting.profile import profile_interval
from gyrodata.measurements import Measurements, measure, select
from gyrodata.readings import Readings, read_log
from gyrodata.unsteady import settle

if TYPE_CHECKING:
    import os

    import pandas as pd

SCHEMA = "gyro.analysis/1"

K_95 = 1.959963984540054
"""Coverage factor of a 95 % interval for infinite degrees of freedom (97.5 % point of the normal)."""

DOF_REASON = "the stated uncertainties are taken as known, so the degrees of freedom are infinite"


CONVENTIONS = {
    "inertia": "least squares in the raw readings (Gauss-Helmert); derivatives and proportional uncertainties at the "
    "adjusted values; u is one standard uncertainty (k = 1) from the stated ones, never scaled by chi-square unless "
    "asked; interval_95 is value ± U, U = k u, or the profile of chi-square where that differs by over 5 %",
    "imbalance": "the torque at work is the applied torque plus M0; M = I_zz φ̇ψ̇ − M0",
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


LARGEST = 3_000_000
"""Runs times shared readings that one fit may hold: a matrix of this many numbers is solved several times."""


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
    model: Rung
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


# --- the story ----------------------------------------------------------------------------------------------


def analyze(
    log: str | os.PathLike[str] | bytes | BinaryIO | TextIO | pd.DataFrame,
    *,
    name: str | None = None,
    settings: Mapping[str, str] | None = None,
    mapping: Mapping[str, str] | None = None,
    config: str | os.PathLike[str] | None = None,
    model: Model = "auto",
    keep_flagged: bool = False,
    scale_by_birge: bool = False,
) -> Analysis:
    """Turn a log into I_zz with its uncertainty, and everything that goes with it.

    Parameters
    ----------
    log : path, bytes, file or DataFrame
        What ``gyro analyze`` reads; the text of a log as bytes.
    name : str, optional
        Name to call it by.
    settings : mapping, optional
        Constants, as ``--set``: ``{"g": "9.803 m/s^2"}``.
    mapping : mapping, optional
        Headers of roles, as ``--map``: ``{"time": "T (s)"}``.
    config : path, optional
        TOML file with the same.
    model : {"auto", "horizontal", "steady", "released"}
        Eq. (9), eq. (8), the mean rate of a rod let go from rest, or the simplest of them that the log allows.
    keep_flagged : bool
        Keep runs in the fit that do not go with the others.
    scale_by_birge : bool
        Multiply the recommended fit's uncertainties by the Birge ratio where that is above 1.

    Returns
    -------
    Analysis

    Raises
    ------
    InputError
        If there is nothing that can be read.
    LogError
        If the log is wrong or incomplete; it lists every fault found.
    """
    readings = read_log(log, name=name, settings=settings or {}, mapping=mapping or {}, config=config)
    options = {
        "set": dict(sorted((settings or {}).items())),
        "map": dict(sorted((mapping or {}).items())),
        "model": model,
        "keep_flagged": keep_flagged,
        "scale_by_birge": scale_by_birge,
    }
    return analyze_readings(readings, options, model, keep_flagged, scale_by_birge)


def analyze_readings(
    readings: Readings,
    options: Mapping[str, Any],
    model: Model = "auto",
    keep_flagged: bool = False,
    scale_by_birge: bool = False,
) -> Analysis:
    """Analyse a log that has been read; see `analyze`.

    Parameters
    ----------
    readings : Readings
        As `read_log` gives them.
    options : mapping
        To be told in the output.
    model : {"auto", "horizontal", "steady", "released"}
        Eq. (9), eq. (8), the mean rate of a rod let go from rest, or the simplest of them that the log allows.
    keep_flagged : bool
        Keep runs in the fit that do not go with the others.
    scale_by_birge : bool
        Multiply the recommended fit's uncertainties by the Birge ratio where that is above 1.

    Returns
    -------
    Analysis

    Raises
    ------
    LogError
        If the readings have errors, or no run has a torque.
    """
    if any(diagnostic.severity == "error" for diagnostic in readings.diagnostics):
        raise LogError(readings.diagnostics)
    measured = measure(readings)
    found = [*readings.diagnostics, *measured.diagnostics]
    if not np.any(measured.torque):
        found.append(readings.diagnose(G413, "no run has a torque, so nothing ties the precession to I_zz",
                                       "add runs with a weight: mass and position"))  # fmt: skip
        raise LogError(found)

    shared = sum(source.shared_count for source in measured.sources)
    if shared * len(measured.runs) > LARGEST:
        found.append(
            readings.diagnose(
                G416,
                f"{len(measured.runs)} runs with {shared} weights, positions and spins that stand in several of them "
                "are too much for one fit",
                "split the log, and give each part on its own",
            )
        )
        raise LogError(found)
    fitted = fit_runs(measured, model, keep_flagged)
    measured, fit, left_out = fitted.measured, fitted.fit, fitted.left_out
    if not (math.isfinite(fit.inertia.value) and np.isfinite(fit.fitted_time).all()):
        why = "eq. (8) has no real solution for a run: the rod is up and the spin too low to precess steadily"
        found.append(readings.diagnose(G415, why, "check pitch, spin and transverse_inertia"))
        raise LogError(found)

    rung = fitted.rung
    kept = [i for i in range(len(measured.runs)) if i not in left_out]
    p = fitting.chi2_tail(fit.chi2, fit.dof) if fit.dof > 0 else None
    birge = math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else None
    listed = effects.list_effects(measured, fit, rung)
    advice = list_advice(select(measured, kept) if left_out else measured, fit, rung.tilted)
    profile = profile_interval(fit, K_95)
    found += outlier_findings(readings, measured, fitted.outliers, left_out, fitted.without)
    found += whole_findings(readings, measured, fit, p, listed)
    scaled = scale_by_birge and birge is not None and birge > 1
    if scaled and birge is not None:
        # A profile is of chi-square as it is.
        fit, profile = _scaled(fit, birge), None
    return Analysis(
        name=readings.name,
        sha256=readings.sha256,
        options=options,
        readings=readings,
        measurements=measured,
        fit=fit,
        model=rung,
        outliers=fitted.outliers,
        inertia=_with_interval(fit.inertia, "kg*m^2", profile),
        imbalance=_with_interval(fit.imbalance, "N*m"),
        timing_bias=_with_interval(fit.timing_bias, "s"),
        p=p,
        birge=birge,
        birge_applied=scaled,
        fits=named_fits(measured, fit, kept, scaled),
        budget=fit.budget,
        effects=listed,
        power_law=power_laws(measured, kept),
        exponent=overall_exponent(measured, kept),
        constancy=constancy(measured, kept),
        ball=compare_with_ball(fit.inertia, readings.constants, readings.uncertainties),
        torques=torque_table(measured, fit, kept, rung.tilted),
        run_table=run_table(measured, fit, fitted.outliers, left_out),
        advice=advice,
        diagnostics=tuple(found),
    )


@dataclass(frozen=True)
class Fitted:
    """A log's recommended fit, and what was decided for it."""

    measured: Measurements
    rung: Rung
    outliers: tuple[Outlier, ...]
    left_out: tuple[int, ...]
    fit: FitResult
    without: Estimate | None
    """I_zz without any odd run [kg*m^2], where one was kept."""


def fit_runs(measured: Measurements, model: Model = "auto", keep_flagged: bool = False) -> Fitted:
    """Choose the model, find the runs that do not go with the others, and fit the rest.

    Parameters
    ----------
    measured : Measurements
        n runs, at least one with a torque.
    model, keep_flagged
        As for `analyze`.

    Returns
    -------
    Fitted
    """
    rung = effects.choose(measured, model)
    outliers, clean = fitting.screen(measured, rung.tilted)
    if effects.is_unsteady(measured, rung):
        measured = settle(measured, rung, tuple(outlier.index for outlier in outliers))
        outliers, clean = fitting.screen(measured, rung.tilted)
    # A run that is merely odd is still a measurement, and stays.
    left_out = () if keep_flagged else tuple(outlier.index for outlier in outliers if outlier.slip)
    odd = tuple(outlier.index for outlier in outliers)
    fit = clean if clean is not None and odd == left_out else fitting.fit(measured, rung.tilted, left_out)
    without = fitting.fit(measured, rung.tilted, odd).inertia if odd != left_out else None
    return Fitted(measured, rung, tuple(outliers), left_out, fit, without)


def _with_interval(estimate: Estimate, unit: str, profile: tuple[float, float] | None = None) -> Result:
    if estimate.u is None:
        return Result(estimate.value, None, unit, None, None, None)
    if profile is not None:
        return Result(estimate.value, estimate.u, unit, profile, K_95, None, "profile")
    half = K_95 * estimate.u
    return Result(estimate.value, estimate.u, unit, (estimate.value - half, estimate.value + half), K_95, None)


def _scaled(fit: FitResult, ratio: float) -> FitResult:
    """Multiply every uncertainty of a fit: what is asked for where the stated ones are not believed."""

    def larger(estimate: Estimate) -> Estimate:
        return Estimate(estimate.value, None if estimate.u is None else ratio * estimate.u)

    return replace(
        fit,
        inertia=larger(fit.inertia),
        imbalance=larger(fit.imbalance),
        timing_bias=larger(fit.timing_bias),
        covariance=ratio**2 * fit.covariance,
        budget=tuple(replace(share, u_inertia=ratio * share.u_inertia) for share in fit.budget),
    )
