"""The results of one log: `Analysis`, and the records of its JSON.

`to_json` turns a record into JSON, and the module `schema` derives the JSON Schema from
the same records.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import msgspec
import numpy as np
from msgspec import Struct, field

from gyrodata.base.errors import Diagnostic, DiagnosticJson, insist_on_choice
from gyrodata.base.tool import Tool
from gyrodata.fitting import Estimate, FitResult, Outlier, Share
from gyrodata.judging.blocks import Block, BlockAgreement
from gyrodata.judging.changes import Effect, Lab, Sensitivity
from gyrodata.judging.explanations import Explanation
from gyrodata.judging.tables import (
    Ball,
    Constancy,
    Exponent,
    NamedFit,
    PowerLaw,
    Run,
    Torque,
)
from gyrodata.measurements import Measurements
from gyrodata.physics.models import AUTO, ModelName, Motion
from gyrodata.readings import Readings

if TYPE_CHECKING:
    import pandas as pd

DOF_REASON = (
    "u and the interval are quantiles of the posterior distribution, which includes "
    "the doubt about the sizes of the errors"
)


CONVENTIONS: dict[str, str] = msgspec.json.decode(
    Path(__file__).with_name("conventions.json").read_bytes()
)
"""The convention of each number, by its key in the JSON."""


class Options(Struct, frozen=True):
    """The options of the analysis."""

    set: Mapping[str, str] = field(default_factory=dict)
    """Constants that were given in addition to the log."""
    map: Mapping[str, str] = field(default_factory=dict)
    """Headers of roles that were given in addition to the log."""
    config: str | None = None
    """Name of the TOML file with constants and headers, without its folder."""
    model: ModelName = AUTO
    keep_flagged: bool = False
    worksheet: bool = False
    """Whether the report asks questions instead of giving conclusions."""


DoubtKind = Literal["ball", "size", "note", "contradiction", "exponent", "scatter"]

DOUBTS: tuple[DoubtKind, ...] = get_args(DoubtKind)
"""Kinds of doubt, the most serious first: I_zz contradicts the ball; a reading has an
unusual size; a note of the student says so; the runs contradict each other; the period
is not in proportion to the spin; the runs scatter too much."""


class Doubt(Struct, frozen=True):
    """A reason why I_zz may be wrong by more than its u."""

    kind: DoubtKind
    words: str
    """The reason."""
    remedy: str
    """What to check."""


class Result(Estimate, frozen=True, kw_only=True):
    """A value with its standard uncertainty u (k = 1) and its 95 % interval."""

    k: float | None
    """Coverage factor: half the 95 % interval over u [1]."""
    dof: float | None = None
    """Degrees of freedom; null, see dof_reason."""
    expanded_u: float | None
    """k·u, half the 95 % interval."""
    relative_u: float | None
    """u over the value [1]."""
    level: float = 0.95
    """Probability of the interval [1]."""
    dof_reason: str | None = DOF_REASON
    """Why dof is null."""

    @property
    def ufloat(self) -> Any:
        """Value and u as a number of `uncertainties`; see also `Analysis.ufloats`."""
        from uncertainties import ufloat

        return ufloat(self.value, self.u or 0.0)

    def to_pint(self, registry: Any) -> Any:
        """Convert to a quantity of pint.

        Parameters
        ----------
        registry : pint.UnitRegistry
            The registry of your other quantities.

        Returns
        -------
        pint.Quantity
            With a number of `uncertainties` as its magnitude.
        """
        return registry.Quantity(self.ufloat, self.unit)

    def __float__(self) -> float:
        return self.value

    def __format__(self, form: str) -> str:
        """Format like `uncertainties`, with the unit: ``f"{lab.inertia:.2u}"``."""
        if form:
            return f"{self.ufloat:{form}} {self.unit}"
        return str(self)

    def __str__(self) -> str:
        unit = self.unit.replace("*", "·").replace("^2", "²")
        return f"{self.ufloat:.2uP} {unit}"


NO_BALL = (
    "Not checked against the ball: add # ball_mass and # ball_diameter; without them "
    "gyro cannot detect "
    "a wrong unit in a whole column"
)
"""Printed instead of the comparison with the ball."""


WIDE = 3.0
"""If the coverage factor k is larger, the answer is the 95 % interval, because ± 2 u is
much narrower."""


def is_wide(answer: Result) -> bool:
    """Return whether the 95 % interval is much wider than ± 2 u."""
    return answer.interval_95 is not None and (answer.k or 0.0) > WIDE


UNITS_OF_RUNS = {
    "mass": "kg",
    "position": "m",
    "torque": "N*m",
    "spin": "rad/s",
    "time": "s",
    "precession_rate": "rad/s",
    "period": "s",
    "product": "rad^2/s^2",
    "inertia": "kg*m^2",
    "residual": "s",
    "residual_u": "s",
    "influence": "kg*m^2",
}
"""Units of the columns of `Analysis.runs` that have one."""

TABLES = (
    "budget",
    "effects",
    "fits",
    "power_law",
    "run_table",
    "sensitivity",
    "torques",
)
"""The tables of an analysis."""


class FittedLog(Struct, frozen=True, eq=False, kw_only=True):
    """The fit of one log, before it is judged, in SI units.

    Attributes
    ----------
    name : str
        Name of the log in messages.
    sha256 : str
        SHA-256 of the bytes of the log.
    options : Options
        The options of the analysis.
    readings : Readings
        The readings of the log, with their cells.
    measurements : Measurements
        Measured quantities of each run, with their uncertainty components.
    fit : FitResult
        The recommended fit: adjusted times, residuals, covariance and posterior
        distribution.
    model : Motion
        How the rods moved: the models that were fitted to the runs. `model.name` is the
        name that users choose, as in `options.model` and in the JSON.
    outliers : tuple of Outlier
        Suspected outliers, also those that are in the fit.
    without_outliers : Estimate or None
        I_zz without all suspected outliers [kg*m^2]; None if none of them is in the
        fit.
    explanations : tuple of Explanation
        Mistakes with which the runs would agree, the most probable first.
    inertia : Result
        I_zz [kg*m^2].
    residual_torque : Result
        M0 [N*m]: the net torque is m g x + M0.
    timing_bias : Result
        b [s]: the reading of the stopwatch is the true time plus b.
    p : float or None
        Probability of a chi-square at least this large; None without degrees of
        freedom.
    birge : float or None
        Birge ratio, √(chi-square/dof) [1]; None without degrees of freedom.
    budget : tuple of Share
        What each uncertainty component contributes to u(I_zz), the largest first.
    constancy : Constancy or None
        Scatter of φ̇ψ̇ among runs with the same torque; None if no torque has two runs.
    torques : tuple of Torque
        Mean φ̇ψ̇ of each torque.
    run_table : tuple of Run
        Every run with its residual; `runs` is the same as a DataFrame.
    unusual_sizes : tuple of Diagnostic
        The diagnostics about readings of an unusual size.
    blocks : tuple of Block
        The days or groups of the log, each alone; empty if it has only one.
    blocks_agreement : BlockAgreement or None
        Whether they have one I_zz; None if there is only one, or if they cannot be
        compared.
    diagnostics : tuple of Diagnostic
        Errors, warnings and notes, with code, place and remedy.
    effects : tuple of Effect
        The sizes of the approximations in this log: none after `fit_log`, those that
        are assumed after `check_fit`, all of them in an `Analysis`.
    """

    name: str
    sha256: str
    options: Options
    readings: Readings
    measurements: Measurements
    fit: FitResult
    model: Motion
    outliers: tuple[Outlier, ...]
    without_outliers: Estimate | None
    explanations: tuple[Explanation, ...]
    inertia: Result
    residual_torque: Result
    timing_bias: Result
    p: float | None
    birge: float | None
    budget: tuple[Share, ...]
    constancy: Constancy | None
    torques: tuple[Torque, ...]
    run_table: tuple[Run, ...]
    unusual_sizes: tuple[Diagnostic, ...]
    blocks: tuple[Block, ...] = ()
    blocks_agreement: BlockAgreement | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    effects: tuple[Effect, ...] = ()

    @property
    def lab(self) -> Lab:
        """The log and its fit as `changes` needs them; users call an analysis a lab."""
        left_out = [i for i, run in enumerate(self.run_table) if run.left_out]
        return Lab(
            readings=self.readings,
            measured=self.measurements,
            fit=self.fit,
            motion=self.model,
            left_out=tuple(left_out),
            effects=self.effects,
            asked=self.options.model != AUTO,
        )


class Analysis(FittedLog, frozen=True, eq=False, kw_only=True):
    """The complete result of a log, in SI units; two are equal if their JSON is equal.

    Attributes
    ----------
    if_balanced : Estimate or None
        I_zz of a log with one torque, if the ball is balanced [kg*m^2]; None if torques
        differ, if this fit has no answer, or for more than 500 runs that are not stated
        as those of a balanced ball.
    doubts : tuple of Doubt
        Reasons why I_zz may be wrong by more than its u.
    fits : tuple of NamedFit
        The recommended fit and the textbook fits.
    sensitivity : tuple of Sensitivity
        I_zz if one reading, setting or assumption were different.
    power_law : tuple of PowerLaw
        Exponent of period against spin for each torque.
    exponent : Exponent or None
        Exponent of period against spin, of all torques; None if no torque has runs at
        different spins.
    ball : Ball or None
        Comparison with the inertia of the ball or disk; None if the log gives neither.
    advice : tuple of str
        What would improve the next measurement.
    """

    if_balanced: Estimate | None
    doubts: tuple[Doubt, ...]
    fits: tuple[NamedFit, ...]
    sensitivity: tuple[Sensitivity, ...]
    power_law: tuple[PowerLaw, ...]
    exponent: Exponent | None
    ball: Ball | None
    advice: tuple[str, ...]

    @property
    def runs_disagree(self) -> bool:
        """Whether the runs contradict each other or the fitted law.

        Other doubts are about the ball, a column or a note.
        """
        return any(doubt.kind not in ("ball", "size", "note") for doubt in self.doubts)

    @property
    def angular_momentum(self) -> Estimate:
        """I_zz ψ̇ along the rod at the fastest spin [kg*m^2/s], with the u of I_zz.

        Its u is the standard uncertainty of I_zz, multiplied by this spin.
        """
        spin = max(run.spin for run in self.run_table)
        u = self.inertia.u or 0.0
        return Estimate(self.inertia.value * spin, u * spin, "kg*m^2/s")

    @property
    def centre_of_mass(self) -> Estimate | None:
        """Its distance M0/(m g) from the centre of the ball [m].

        None if the log does not give the ball's mass.
        """
        mass = self.readings.constants.get("ball_mass")
        if not mass:
            return None
        weight = mass * self.measurements.g
        u = self.residual_torque.u or 0.0
        return Estimate(self.residual_torque.value / weight, u / weight, "m")

    @property
    def runs(self) -> pd.DataFrame:
        """A DataFrame with one row for each run, in SI units.

        Its `attrs` contain the units of the columns and the lines "# key: value" of the
        log, so that `gyrodata.analyze` can read it.
        """
        from gyrodata.readings import write_log

        frame = self.table("run_table")
        sense = self.measurements.precession_sense
        if sense is not None:
            # A log states directions in words, and not by the sign of a rate.
            words = np.select([sense > 0, sense < 0], ["ccw", "cw"], "")
            frame["precession_sense"] = words
        frame.attrs = {"units": dict(UNITS_OF_RUNS)}
        for line in write_log(self.readings).splitlines():
            if line.startswith("# "):
                key, _, value = line.removeprefix("# ").partition(": ")
                frame.attrs[key] = value
        return frame

    def table(self, name: str) -> pd.DataFrame:
        """Return one of the tables of the analysis as a DataFrame, in SI units.

        Parameters
        ----------
        name : {"budget", "effects", "fits", "power_law", "run_table", "sensitivity", \
                "torques"}
            A record in a cell, such as the estimate of a fit, becomes several columns:
            "inertia.value", "inertia.u".

        Returns
        -------
        pandas.DataFrame
        """
        import pandas as pd

        insist_on_choice("name", name, TABLES)
        return pd.json_normalize(msgspec.to_builtins(getattr(self, name)))

    def ufloats(self) -> dict[str, Any]:
        """Return I_zz, M0 and b [SI units] as correlated numbers of `uncertainties`.

        Returns
        -------
        dict of str to uncertainties.UFloat
            With the keys "inertia", "residual_torque" and "timing_bias".
        """
        from uncertainties import correlated_values

        results = (self.inertia, self.residual_torque, self.timing_bias)
        # The fit gives the correlations, and the results their u.
        u = np.array([result.u or 0.0 for result in results])
        u_of_fit = np.sqrt(np.diag(self.fit.covariance))
        ratio = np.divide(u, u_of_fit, out=np.zeros_like(u), where=u_of_fit > 0)
        covariance = self.fit.covariance * np.outer(ratio, ratio)
        values = correlated_values([result.value for result in results], covariance)
        inertia, residual_torque, timing_bias = values
        return {
            "inertia": inertia,
            "residual_torque": residual_torque,
            "timing_bias": timing_bias,
        }

    def __eq__(self, other: object) -> bool:
        return (
            self.to_dict() == other.to_dict()
            if isinstance(other, Analysis)
            else NotImplemented
        )

    def __hash__(self) -> int:
        return hash((self.name, self.sha256))

    def __repr__(self) -> str:
        counts = f"{len(self.run_table)} runs, {len(self.diagnostics)} diagnostics"
        return f"<Analysis of {self.name[:200]}: I_zz = {self.inertia}; {counts}>"

    def to_dict(self) -> dict[str, Any]:
        """Return the object of the JSON, with the schema "gyro.analysis/2".

        Its numbers have 12 significant digits; the attributes have all digits.
        """
        document = AnalysisDocument(
            input=Input(self.name, self.sha256, len(self.run_table)),
            options=self.options,
            result=AnalysisResult(**self._result_fields()),
            diagnostics=tuple([each.to_dict() for each in self.diagnostics]),
        )
        return to_json(document)

    def _result_fields(self) -> dict[str, Any]:
        """Return the fields of the result in the JSON; most are attributes."""
        fields = {
            "goodness": self._goodness(),
            "constants": {"g": self.measurements.g, **self.readings.constants},
            "model": self.model.name,
            "ball_reason": NO_BALL if self.ball is None else None,
            "runs": [run for run, _ in runs_with_notes(self)],
            "uncertainties": _stated_uncertainties(self.measurements),
            "conventions": CONVENTIONS,
            "patterns": (),
        }
        for name in AnalysisResult.__struct_fields__:
            if name not in fields:
                fields[name] = getattr(self, name)
        return fields

    def _goodness(self) -> Goodness:
        """Return how well the runs agree with each other."""
        return Goodness(
            chi2=self.fit.chi2,
            dof=self.fit.dof,
            p=self.p,
            birge=self.birge,
            scatter=self.fit.widths.scatter,
            time_u=self.measurements.time_u,
            reason=NO_P if self.p is None else None,
        )


# --- the JSON ---

NO_P = "no degrees of freedom: as many unknowns as runs"
"""Why there is no probability of chi-square."""


def runs_with_notes(analysis: Analysis) -> Iterator[tuple[Run, str]]:
    """Pair each run of the table of runs, as in the JSON, with its note."""
    yield from zip(analysis.run_table, analysis.readings.notes, strict=True)


class Input(Struct, eq=False):
    """The log."""

    name: str
    """The path of the log as given; without the common folders if it is absolute."""
    sha256: str | None
    """SHA-256 of the bytes of the log; null if it cannot be read."""
    rows: int | None
    """Number of runs read."""


class Goodness(Struct, eq=False):
    """How well the runs agree with each other."""

    chi2: float
    dof: int
    p: float | None
    """Probability of a chi-square at least as large."""
    birge: float | None
    """√(chi2/dof)."""
    scatter: float
    """Factor on the independent errors of each run, estimated from the runs; u includes
    it."""
    time_u: float | None
    """Standard uncertainty of every time [s], without this factor; null if it is not
    the same for all runs."""
    reason: str | None
    """Why p is null."""


class StatedUncertainty(Struct, eq=False):
    """One uncertainty of the readings."""

    source: str
    shared_by: str
    """The runs that share this error; "" if each run has its own."""
    default: bool
    """True if the log does not state it."""
    text: str
    """The uncertainty as text: "0.2 %"."""


def _stated_uncertainties(measured: Measurements) -> tuple[StatedUncertainty, ...]:
    """List the uncertainties of the readings."""
    return tuple(
        [
            StatedUncertainty(each.name, each.shared_by, each.default, each.described)
            for each in measured.sources
        ]
    )


class Pattern(Struct, eq=False):
    """A pattern in the residuals, as older versions listed it."""

    name: str
    of: str
    statistic: float
    size: float | None
    p: float
    p_corrected: float


class AnalysisResult(Struct, eq=False):
    """All quantities are SI."""

    inertia: Result
    """I_zz."""
    residual_torque: Result
    """M0: the net torque is the applied torque plus M0."""
    timing_bias: Result
    """b: the reading of the stopwatch is the true time plus b."""
    if_balanced: Estimate | None
    """I_zz of a log with one torque, if the ball is balanced [kg*m^2]; null if torques
    differ."""
    doubts: tuple[Doubt, ...]
    """Reasons why I_zz may be wrong by more than its u, the most serious first; empty
    if there are none."""
    goodness: Goodness
    fits: tuple[NamedFit, ...]
    budget: tuple[Share, ...]
    """What each uncertainty component contributes to u(I_zz)."""
    sensitivity: tuple[Sensitivity, ...]
    """I_zz if one reading, setting or assumption were different."""
    explanations: tuple[Explanation, ...]
    """Mistakes with which the runs would agree, the most probable first; empty if they
    agree, or if no mistake explains them."""
    constants: Mapping[str, float]
    """By name: g, and every other constant that the log gives."""
    model: str
    effects: tuple[Effect, ...]
    """The size of every approximation in this log."""
    power_law: tuple[PowerLaw, ...]
    exponent: Exponent | None
    constancy: Constancy | None
    ball: Ball | None
    ball_reason: str | None
    """Why there is no comparison; null if there is one."""
    angular_momentum: Estimate
    """I_zz ψ̇ along the rod at the fastest spin [kg*m^2/s], with the standard
    uncertainty of I_zz."""
    centre_of_mass: Estimate | None
    """Its distance M0/(m g) from the centre of the ball, along the rod towards the
    weight [m]; null without m."""
    torques: tuple[Torque, ...]
    runs: tuple[Run, ...]
    uncertainties: tuple[StatedUncertainty, ...]
    advice: tuple[str, ...]
    """What would improve the next measurement."""
    conventions: Mapping[str, str]
    """The convention of each number, by its key."""
    patterns: tuple[Pattern, ...]
    """Always empty: `explanations` contains the errors that all runs share."""
    blocks: tuple[Block, ...]
    """The days or groups of the log; empty if it has only one."""
    blocks_agreement: BlockAgreement | None
    """Whether they have one I_zz; null if there is only one, or if they cannot be
    compared."""


class AnalysisDocument(Struct, eq=False, kw_only=True):
    """The JSON of ``gyro analyze`` for one log."""

    schema: Literal["gyro.analysis/2"] = "gyro.analysis/2"
    tool: Tool = Tool()
    input: Input
    options: Options
    result: AnalysisResult | None
    """null if the log cannot be analysed; the diagnostics contain the reason."""
    diagnostics: tuple[DiagnosticJson, ...]


class HandIn(Struct, eq=False):
    """What ``gyro grade`` would read from this submission."""

    text: str | None
    """I_zz as written; null if it is not found."""
    inertia: float | None
    """[kg*m^2]; null if it cannot be read, or if two values differ."""
    u: float | None
    """Standard uncertainty [kg*m^2]; null if it is not found."""
    file: str | None
    """The file that contains I_zz."""
    line: int | None
    """The line that contains I_zz, from 1."""
    station: str | None
    """The station that the log names."""


class CheckDocument(Struct, eq=False, kw_only=True):
    """The JSON of ``gyro check`` for one log."""

    schema: Literal["gyro.check/1"] = "gyro.check/1"
    tool: Tool = Tool()
    input: Input
    clean: bool
    """True if there is no doubt, and no diagnostic above a note."""
    doubts: tuple[Doubt, ...]
    """Reasons why I_zz may be wrong by more than its u."""
    diagnostics: tuple[DiagnosticJson, ...]
    hand_in: HandIn | None
    """null without --hand-in."""


# U+007F to U+009F, U+061C, U+200E, U+200F, U+202A to U+202E, and U+2066 to U+2069, in
# UTF-8.
_CONTROLS = re.compile(
    rb"\x7f|\xc2[\x80-\x9f]|\xd8\x9c|\xe2\x80[\x8e\x8f\xaa-\xae]|\xe2\x81[\xa6-\xa9]"
)


def escape_controls(text: bytes) -> bytes:
    r"""Write some characters of JSON as ``\uXXXX``.

    They are the characters that a terminal obeys, or that turn a line around.

    They can only be in the texts of JSON, whose content stays the same.
    """
    return _CONTROLS.sub(_escaped, text)


def _escaped(control: re.Match[bytes]) -> bytes:
    r"""Write one character as ``\uXXXX``."""
    return b"\\u%04x" % ord(control[0].decode())


def encode(record: Any) -> bytes:
    """Write a record as JSON on one line; a NaN becomes null."""
    try:
        return escape_controls(msgspec.json.encode(record))
    except UnicodeEncodeError:
        # The name of a file in another encoding can contain half of a surrogate pair,
        # which has to be escaped.
        escaped = json.dumps(msgspec.to_builtins(record))
        return json.dumps(json.loads(escaped, parse_constant=_null)).encode()


def _null(constant: str) -> None:
    """Return null for NaN and Infinity, which JSON does not have."""


def decode(text: bytes, kind: Any) -> Any:
    """Read a record that `encode` has written.

    Raise ValueError or `msgspec.ValidationError` if it is another text.
    """
    try:
        return msgspec.json.decode(text, type=kind)
    except msgspec.DecodeError:
        # Unlike msgspec's own decoder, `json` reads half of a surrogate pair.
        return msgspec.convert(json.loads(text), kind)


DIGITS = 12
"""Significant digits of a number in JSON and CSV. Those behind them differ between
versions of Python, NumPy and SciPy."""


def round_digits(value: float | str) -> float:
    """Round a number, or its text, to `DIGITS` significant digits."""
    return float(f"{float(value):.{DIGITS}g}")


def to_json(record: Struct) -> dict[str, Any]:
    """Convert a record to the object of its JSON.

    Tuples become lists, and numbers have 12 significant digits.
    """
    content: dict[str, Any] = json.loads(encode(record), parse_float=round_digits)
    return content
