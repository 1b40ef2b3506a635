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

from gyrodata import __version__, fitting, forecast, physics
from gyrodata.errors import Diagnostic, LogError, register
from gyrodata.fitting import Estimate, FitResult, Outlier, Share
from gyrodata.fitting.profile import profile_interval
from gyrodata.measurements import Measurements, measure, select, torque_groups
from gyrodata.physics import Floats
from gyrodata.readings import Readings, read_log

if TYPE_CHECKING:
    import os

    import pandas as pd

SCHEMA = "gyro.analysis/1"

K_95 = 1.959963984540054
"""Coverage factor of a 95 % interval for infinite degrees of freedom (97.5 % point of the normal)."""

DOF_REASON = "the stated uncertainties are taken as known, so the degrees of freedom are infinite"

DROP_ONE = 0.2
"""An effect below this many standard uncertainties of I_zz may be left out …"""

DROP_ALL = 0.3
"""… as long as all that are left out stay below this many together."""

Model = Literal["auto", "horizontal", "steady"]

_LOG = "mass [g],position [cm],spin [rpm],time [s],turns\n"

G410 = register(
    "G410",
    "warning",
    "a run does not go with the others",
    "# g: 9.803 m/s^2\n" + _LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n40.00,15.0,405,20.1,1\n"
    "40.00,15.0,607,30.1,2\n60.00,15.0,404,13.4,1\n60.00,15.0,603,20.0,1\n",
)
G411 = register(
    "G411",
    "warning",
    "the scatter is larger than the stated uncertainties allow",
    "# g: 9.803 m/s^2\n# u_time: 0.01 s\n" + _LOG + "20.00,15.0,206,20.9,1\n20.00,15.0,407,40.1,1\n"
    "40.00,15.0,405,20.5,1\n40.00,15.0,607,29.8,1\n60.00,15.0,404,13.7,1\n60.00,15.0,603,19.8,1\n",
)
G412 = register(
    "G412",
    "warning",
    "the data contradict the balance test in the log",
    "# g: 9.803 m/s^2\n# u_imbalance: 0.00001 N*m\n" + _LOG + "20.00,15.0,206,16.0,1\n20.00,15.0,407,31.6,1\n"
    "40.00,15.0,405,18.0,1\n40.00,15.0,607,27.0,1\n60.00,15.0,404,12.5,1\n60.00,15.0,603,18.6,1\n",
)
G413 = register(
    "G413",
    "error",
    "no run has a torque",
    "# g: 9.803 m/s^2\n" + _LOG + "0,,400,160.2,1/3\n0,,600,240.3,1/3\n",
)
G414 = register(
    "G414",
    "warning",
    "I_zz rests on a single torque",
    "# g: 9.803 m/s^2\n" + _LOG + "20.00,15.0,206,20.4,1\n20.00,15.0,407,40.4,1\n",
)
G415 = register(
    "G415",
    "error",
    "no steady precession is possible at this tilt and spin",
    "# g: 9.803 m/s^2\n# transverse_inertia: 0.02 kg*m^2\n"
    "mass [g],position [cm],spin [rpm],time [s],turns,pitch [deg]\n"
    "60.00,15.0,400,13.3,1,0\n60.00,15.0,600,19.9,1,0\n60.00,15.0,300,10.0,1,0\n60.00,15.0,20,2.5,1,60\n",
)


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
    "power_law": "weighted least squares of ln(period) on ln(spin); u from each run's own timing and spin",
    "product": "weighted mean; u includes what these runs share; p from the scatter about the mean against each run's "
    "own timing and spin",
}
"""Which convention each number follows."""


G416 = register(
    "G416",
    "error",
    "too many shared readings for one fit",
    "# g: 9.803 m/s^2\n"
    + _LOG
    + "".join(f"{20 + k // 2 / 100:.2f},15.0,400,{40 + k / 1000:.3f},1\n" for k in range(2600)),
)

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


@dataclass(frozen=True, slots=True)
class Effect:
    """One simplification: how much it would move I_zz in this log, and whether it was allowed."""

    effect: str
    bias: float | None
    """I_zz without it over I_zz with it, minus 1; None where the log does not tell."""
    kept: bool
    """True if the model takes it into account."""
    reason: str


@dataclass(frozen=True, slots=True)
class PowerLaw:
    """τ ∝ ψ̇^exponent among the runs of one torque; eq. (9) says 1."""

    torque: float
    exponent: float | None
    u: float | None
    reason: str


@dataclass(frozen=True, slots=True)
class Torque:
    """The runs of one torque."""

    mass: float | None
    position: float | None
    torque: float
    runs: int
    product: float
    """Weighted mean of φ̇ψ̇ [rad²/s²]."""
    product_u: float
    """Standard uncertainty of that mean, errors shared by these runs included [rad²/s²]."""
    product_spread: float | None
    """Standard deviation of the single values; None for one run [rad²/s²]."""
    without: Estimate | None
    """I_zz from the runs of the other torques [kg*m^2]; None where they cannot tell it, or with over 12 torques."""
    product_p: float | None
    """Chance of a scatter at least as large if φ̇ψ̇ is constant; None for one run."""


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
    influence: float
    """Change of I_zz if this run were left out [kg*m^2]; 0 where it is."""
    flagged: bool
    left_out: bool
    reason: str


@dataclass(frozen=True)
class Analysis:
    """Everything that is said of one log; SI units."""

    name: str
    sha256: str
    options: Mapping[str, Any]
    readings: Readings
    measurements: Measurements
    fit: FitResult
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
            "effects": [_slots(effect) for effect in self.effects],
            "power_law": [_slots(law) for law in self.power_law],
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
    model : {"auto", "horizontal", "steady"}
        Eq. (9), eq. (8), or whichever the log needs.
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
    model : {"auto", "horizontal", "steady"}
        Eq. (9), eq. (8), or whichever the log needs.
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
    tilted = model == "steady" or (model == "auto" and _tilt_matters(measured))
    outliers = fitting.screen(measured, tilted)
    # A slip of the count is a known cause; a run that is merely odd is still a measurement, and stays.
    explained = tuple(outlier.index for outlier in outliers if outlier.turns is not None)
    left_out = () if keep_flagged else explained
    fit = fitting.fit(measured, tilted, left_out)
    if not (math.isfinite(fit.inertia.value) and np.isfinite(fit.fitted_time).all()):
        why = "eq. (8) has no real solution for a run: the rod is up and the spin too low to precess steadily"
        found.append(readings.diagnose(G415, why, "check pitch, spin and transverse_inertia"))
        raise LogError(found)

    kept = [i for i in range(len(measured.runs)) if i not in left_out]
    p = fitting.chi2_tail(fit.chi2, fit.dof) if fit.dof > 0 else None
    effects = _effects(measured, fit, tilted, model)
    birge = math.sqrt(fit.chi2 / fit.dof) if fit.dof > 0 else None
    advice = _advice(select(measured, kept) if left_out else measured, fit, tilted)
    profile = profile_interval(measured, fit, K_95, tilted, left_out)
    scaled = scale_by_birge and birge is not None and birge > 1
    if scaled and birge is not None:
        # A profile is of chi-square as it is.
        fit, profile = _scaled(fit, birge), None
    without = None
    if any(outlier.index not in left_out for outlier in outliers):
        without = fitting.fit(measured, tilted, tuple(outlier.index for outlier in outliers)).inertia
    found += _outlier_findings(readings, measured, outliers, left_out, without)
    found += _findings(readings, measured, fit, p)
    return Analysis(
        name=readings.name,
        sha256=readings.sha256,
        options=options,
        readings=readings,
        measurements=measured,
        fit=fit,
        inertia=_with_interval(fit.inertia, "kg*m^2", profile),
        imbalance=_with_interval(fit.imbalance, "N*m"),
        timing_bias=_with_interval(fit.timing_bias, "s"),
        p=p,
        birge=birge,
        birge_applied=scaled,
        fits=_fits(measured, fit, kept, scaled),
        budget=fit.budget,
        effects=effects,
        power_law=_power_law(measured, kept),
        torques=_torques(measured, fit, kept, tilted),
        run_table=_runs(measured, fit, outliers, left_out),
        advice=advice,
        diagnostics=tuple(found),
    )


def _with_interval(estimate: Estimate, unit: str, profile: tuple[float, float] | None = None) -> Result:
    if estimate.u is None:
        return Result(estimate.value, None, unit, None, None, None)
    if profile is not None:
        return Result(estimate.value, estimate.u, unit, profile, K_95, None, "profile")
    half = K_95 * estimate.u
    return Result(estimate.value, estimate.u, unit, (estimate.value - half, estimate.value + half), K_95, None)


# --- fits side by side --------------------------------------------------------------------------------------


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


def _fits(measured: Measurements, fit: FitResult, kept: list[int], scaled: bool) -> tuple[NamedFit, ...]:
    """The two straight lines of the textbook beside the recommended fit."""
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
        NamedFit("through_origin", origin.slope if origin else None, None, note),
        constant,
    )


# --- effects ------------------------------------------------------------------------------------------------


def _tilt_matters(measured: Measurements) -> bool:
    """Decide before the fit whether eq. (9) is good enough: the tilt's bias against u of a horizontal fit."""
    if not np.any(measured.pitch):
        return False
    fit = fitting.fit(measured)
    return abs(_tilt(measured, fit)) > DROP_ONE * _relative_u(fit)


def _relative_u(fit: FitResult) -> float:
    return (fit.inertia.u or 0.0) / abs(fit.inertia.value)


def _tilt(measured: Measurements, fit: FitResult, pitch: Floats | float | None = None) -> float:
    """Relative bias of I_zz from using eq. (9), for this log's runs with this fit's weights."""
    rate = fit.sense * 2 * np.pi * measured.turns / measured.time
    bias = physics.tilt_bias(
        rate,
        measured.spin,
        measured.pitch if pitch is None else pitch,
        fit.inertia.value,
        fitting.transverse_inertia(measured),
    )
    return float(np.sum(fit.response * bias))


def _effects(measured: Measurements, fit: FitResult, tilted: bool, model: Model) -> tuple[Effect, ...]:
    """Every simplification with its size in this log; unknown sizes are parameters and always kept."""
    u = _relative_u(fit)
    weights = (measured.time / fit.time_u) ** 2 * (fit.response != 0)
    weights = weights / weights.sum()
    total = measured.torque + fit.imbalance.value
    loaded = measured.torque != 0
    effects = [
        Effect(
            "imbalance",
            -float(np.sum((weights * fit.imbalance.value / total)[loaded])),
            True,
            "its size is unknown beforehand, so M0 is a parameter "
            + (
                "with practically no prior" if fit.imbalance_free else f"with prior width {fit.imbalance_prior:.2g} N*m"
            ),
        ),
        Effect(
            "timing_bias",
            float(np.sum(weights * fit.timing_bias.value / measured.time)),
            measured.timing_bias_u > 0,
            f"its size is unknown beforehand, so b is a parameter with prior width {measured.timing_bias_u:g} s"
            if measured.timing_bias_u > 0
            else "not a stopwatch's time, or u_time_bias is 0",
        ),
    ]
    if measured.spin_start is not None and measured.spin_end is not None:
        plain = float(np.sum(fit.response * physics.arithmetic_mean_bias(measured.spin_start, measured.spin_end)))
        doubt = float(np.sum(fit.response * physics.decay_law_doubt(measured.spin_start, measured.spin_end)))
        effects.append(
            Effect("spin_decay", plain, True, "the harmonic mean in time of start and end costs nothing, so it is used")
        )
        effects.append(
            Effect("decay_law", doubt, False, _dropped(doubt, u, "a viscous decay is assumed, as of an air film"))
        )
    if np.any(measured.pitch):
        tilt = _tilt(measured, fit)
        if tilted:
            reason = "eq. (8) is used" + (", as asked" if model == "steady" else "")
        else:
            reason = _dropped(tilt, u, "eq. (9) is used" + (", as asked" if model == "horizontal" else ""))
        effects.append(Effect("tilt", tilt, tilted, reason))
    else:
        tilt = _tilt(measured, fit, math.radians(2.0))
        effects.append(Effect("tilt", tilt, False, _dropped(tilt, u, "no pitch in the log; this is for 2° off level")))
    release = float(
        np.sum(
            fit.response
            * physics.release_bias(total, measured.spin, fit.inertia.value, fitting.transverse_inertia(measured))
        )
    )
    effects.append(
        Effect("release", release, False, _dropped(release, u, "assumed steady; this is for a rod let go"))
    )  # fmt: skip
    earth = float(np.sum(np.abs(fit.response) * physics.EARTH_ROTATION * measured.time / (2 * np.pi * measured.turns)))
    effects.append(Effect("earth", earth, False, _dropped(earth, u, "at most, at a pole")))
    return tuple(effects)


def _dropped(bias: float, u: float, premise: str) -> str:
    """Say why an effect was left out, with its size in standard uncertainties."""
    if u == 0:
        return premise
    size = abs(bias) / u
    verdict = "small enough" if size < DROP_ONE else "NOT small, and the log does not say enough to correct for it"
    return f"{premise}: {size:.2g} u, {verdict}"


# --- tables -------------------------------------------------------------------------------------------------


def _own_relative(measured: Measurements) -> Floats:
    """Relative uncertainty of φ̇ψ̇ of each run from time and spin, each run's own, shape (n,)."""
    variance = np.zeros(len(measured.runs))
    for source in measured.sources:
        size = {"time": measured.time, "spin": measured.spin, "turns": measured.turns}.get(source.quantity)
        if size is not None and source.name not in ("spin_scale",):
            variance += (source.absolute / size + source.relative) ** 2
    return np.sqrt(variance)


def _power_law(measured: Measurements, kept: list[int]) -> tuple[PowerLaw, ...]:
    """Exponent of the period against the spin for each torque: a weighted line through the logarithms."""
    laws = []
    inside = set(kept)
    own = _own_relative(measured)
    for group in torque_groups(measured):
        members = [i for i in group if i in inside]
        torque = float(measured.torque[group[0]])
        spins = np.log(measured.spin[members])
        if len(members) < 2 or np.ptp(spins) < 0.02:
            laws.append(PowerLaw(torque, None, None, "needs two runs with different spins"))
            continue
        periods = np.log(measured.time[members] / measured.turns[members])
        weights = 1 / np.maximum(own[members], 1e-12) ** 2
        centre = np.sum(weights * spins) / np.sum(weights)
        across = np.sum(weights * (spins - centre) ** 2)
        exponent = float(np.sum(weights * (spins - centre) * periods) / across)
        laws.append(PowerLaw(torque, exponent, float(1 / np.sqrt(across)), "u from timing and spin of each run"))
    return tuple(laws)


def _without(measured: Measurements, group: list[int], kept: list[int], tilted: bool) -> Estimate | None:
    """I_zz from all runs but those of one torque: what leaning on that weight does."""
    rest = set(kept) - set(group)
    if not np.any(measured.torque[sorted(rest)]) or len(set(measured.torque)) > 12:
        return None
    return fitting.fit(measured, tilted, set(range(len(measured.runs))) - rest).inertia


def _torques(measured: Measurements, fit: FitResult, kept: list[int], tilted: bool) -> tuple[Torque, ...]:
    """Constancy of φ̇ψ̇ for each torque, and what each does to the answer."""
    groups = []
    inside = set(kept)
    own = _own_relative(measured)
    product = fit.sense * np.abs(measured.product)
    scale = next((float(s.relative[0]) for s in measured.sources if s.name == "spin_scale"), 0.0)
    for group in torque_groups(measured):
        members = [i for i in group if i in inside] or group
        values = product[members]
        weights = 1 / np.maximum(own[members] * np.abs(values), 1e-12) ** 2
        weights = weights / weights.sum()
        mean = float(np.sum(weights * values))
        alone = float(np.sqrt(np.sum((weights * own[members] * values) ** 2)))
        # A late or early hand moves all of them the same way, each by b/T.
        hand = measured.timing_bias_u * float(np.sum(weights * values / measured.time[members]))
        several = len(members) > 1
        chi2 = (
            float(np.sum(((values - mean) / (own[members] * values)) ** 2)) if several and own[members].all() else None
        )
        groups.append(
            Torque(
                mass=_or_none(measured.mass[group[0]]),
                position=_or_none(measured.position[group[0]]),
                torque=float(measured.torque[group[0]]),
                runs=len(members),
                without=_without(measured, group, kept, tilted),
                product=mean,
                product_u=math.hypot(alone, hand, scale * mean),
                product_spread=float(np.std(values, ddof=1)) if several else None,
                product_p=None if chi2 is None else fitting.chi2_tail(chi2, len(members) - 1),
            )
        )
    return tuple(groups)


def _runs(
    measured: Measurements, fit: FitResult, outliers: list[Outlier], left_out: tuple[int, ...]
) -> tuple[Run, ...]:
    reasons = {outlier.index: outlier_reason(measured, outlier) for outlier in outliers}
    product = fit.sense * np.abs(measured.product)
    rate = 2 * np.pi * measured.turns / measured.time
    return tuple(
        Run(
            run=measured.runs[i],
            line=measured.lines[i],
            mass=_or_none(measured.mass[i]),
            position=_or_none(measured.position[i]),
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
            influence=float(fit.influence[i]),
            flagged=i in reasons,
            left_out=i in left_out,
            reason=reasons.get(i, ""),
        )
        for i in range(len(measured.runs))
    )


def _or_none(value: float) -> float | None:
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


# --- what to say --------------------------------------------------------------------------------------------


def _outlier_findings(
    readings: Readings,
    measured: Measurements,
    outliers: list[Outlier],
    left_out: tuple[int, ...],
    without: Estimate | None,
) -> list[Diagnostic]:
    """Name each run that looks odd, what was done with it, and what it does to the answer."""
    roles = ("time", "precession_period", "precession_rate")
    timing = next(readings.columns[role] for role in roles if role in readings.columns)
    found = []
    for outlier in outliers:
        if outlier.index in left_out:
            done, hint = "left out of the fits", "correct the turns in the log, or keep the run with --keep-flagged"
        else:
            done = f"kept; without every run that looks odd I_zz = {without.value:.4g} kg*m^2" if without else "kept"
            hint = "time it again; if you know what went wrong, put # before its line to leave it out"
        found.append(
            readings.diagnose(
                G410,
                f"run {measured.runs[outlier.index]}: {outlier_reason(measured, outlier)}; {done}",
                hint,
                timing.places[outlier.index],
                len(timing.texts[outlier.index]),
            )
        )
    return found


def _findings(readings: Readings, measured: Measurements, fit: FitResult, p: float | None) -> list[Diagnostic]:
    """Turn what looks odd in the whole log into diagnostics."""
    found = []
    if p is not None and p < 0.001:
        found.append(
            readings.diagnose(
                G411,
                f"the runs scatter {math.sqrt(fit.chi2 / fit.dof):.1f} times as much as the stated uncertainties allow "
                f"({'p < 1e-6' if p < 1e-6 else f'p = {p:.1g}'}): u of I_zz may be too small",
                "state what your hand can do, for example # u_time: 0.3 s, or look for a run that is wrong",
            )
        )
    if fit.contradicted_balance is not None:
        found.append(
            readings.diagnose(
                G412,
                f"the runs say M0 = {1e3 * fit.imbalance.value:.2g} mN*m, far from the "
                f"{1e3 * fit.contradicted_balance:.2g} mN*m that {measured.imbalance_from} allows; the runs win",
                f"check {measured.imbalance_from}",
            )
        )
    if not fitting.torques_differ(measured.torque):
        found.append(
            readings.diagnose(
                G414,
                "all torques are equal, so the runs cannot tell the residual torque M0 from I_zz: "
                f"M0 is taken as 0 ± {1e3 * fit.imbalance_prior:.2g} mN*m"
                + (f" (from {measured.imbalance_from})" if measured.imbalance_from else " (default)"),
                "add runs with another weight, or state the balance: # balance_drift: 5 deg in 60 s at 400 rpm",
            )
        )
    return found


BETTER = {
    "position_zero": "the ruler's zero twice as well known (measure the arm from both ends)",
    "position": "positions read twice as well",
    "mass": "weights weighed twice as well (write every digit that the scale shows)",
    "mass_scale": "a scale checked to half its error",
    "spin": "the spin as the mean of four readings",
    "spin_scale": "a tachometer checked to half its error",
    "force": "forces known twice as well",
    "torque": "torques known twice as well",
}


def _advice(measured: Measurements, fit: FitResult, tilted: bool) -> tuple[str, ...]:
    """What would make the next lab better, in order of gain, each computed for this log."""
    options = []
    one_side = len(set(np.sign(measured.torque))) == 1
    if not np.any(measured.torque == 0):
        unloaded = forecast.with_unloaded_run(measured, fit)
        options.append(("one run without a weight, the sense of its precession written down", unloaded))
    if one_side and len(measured.runs) > 1:
        both = forecast.with_both_signs(measured, fit)
        options.append(("the weight on the other side of the ball in half of the runs", both))
    if measured.imbalance_u is None:
        tested = forecast.with_balance_test(measured)
        options.append(('a balance test in the log, "# balance_drift: 5 deg in 60 s at 400 rpm" or better', tested))
    if measured.timed:
        options.append(("three times the turns in every run", forecast.with_longer_times(measured, fit)))
    options += [
        (BETTER[share.source], forecast.with_better(measured, share.source))
        for share in fit.budget
        if share.source in BETTER and share.share > 0.05
    ]
    now = fit.inertia.u or 0.0
    forecasts = ((forecast.u_inertia(changed, tilted), words) for words, changed in options)
    gains = sorted(forecasts, key=lambda gain: gain[0])
    per_cent = 100 / abs(fit.inertia.value)
    return tuple(
        f"{words}: u of I_zz from {now * per_cent:.2g} % to {then * per_cent:.2g} %"
        for then, words in gains
        if then < 0.95 * now
    )
